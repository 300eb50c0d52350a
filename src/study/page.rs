//! The page of a study: what was varied, the best robots, who wins, what each parameter does, the pictures.

use std::path::Path;

use super::effects::Effect;
use super::output::Manifest;
use super::plan::PlannedParameter;
use super::summary::JointSummary;
use super::{StudyError, Summary, plot};
use crate::input::InputFile;
use crate::report::html::{Page, Part, Row, Section, Table, Verdict};
pub use crate::report::{counted, number, optional};
use crate::words::csv::unguarded;

/// Robots in the table of the best.
const BEST: usize = 30;

/// Whether a joint has no design in any robot, and not because its robot has no combination.
fn is_impossible(joint: &JointSummary) -> bool {
    joint.without_design - joint.without_combination == joint.robots
}

/// The page of the finished study in a folder.
///
/// # Errors
/// Its results cannot be read.
pub fn page(out: &Path, summary: &Summary, manifest: &Manifest) -> Result<Page, StudyError> {
    let best = best(out, manifest)?;
    let without: Vec<&str> = summary.joints.iter().filter(|j| is_impossible(j)).map(|j| j.joint.as_str()).collect();
    let robots = counted(summary.robots as usize, "robot");
    let headline = match (best.first(), without.as_slice()) {
        (Some(first), _) => format!(
            "{} of {robots} can be built; {} has the least loss, {} W over all joints.",
            best.whole,
            first.title(manifest),
            number(first.loss)
        ),
        (None, []) => format!("None of {robots} can be built as a whole."),
        (None, joints) => format!("None of {robots} can be built: no motor can do {}.", joints.join(", ")),
    };
    let mut sections =
        vec![Section::new("Who wins, and what the parameters do", vec![Part::Figure(plot::figure(summary))])];
    sections.push(Section::new("Joints", joints(summary)));
    sections.extend(effects(&summary.effects).part().map(|part| {
        let note = "Loss times: geometric mean over the pairs of points that differ in this parameter alone and have a design \
                    at both values. Gained, lost: points that have a design at this value only, or at the other only.";
        Section::new("What the parameters do, all else equal", vec![part, Part::Text(note.into())])
    }));
    let broken = (summary.broken > 0)
        .then(|| format!("{} could not be worked on: errors.csv says why", counted(summary.broken as usize, "robot")));
    let mut summaries = vec![];
    summaries.extend(best.table(manifest).part());
    if best.whole > best.robots.len() as u64 {
        summaries.push(Part::Text(format!("The best {} of {}; results.csv has all.", best.robots.len(), best.whole)));
    }
    Ok(Page {
        command: "study",
        title: match &manifest.plan.study {
            Some(study) => format!("{}: {robots}", study.file),
            None => robots.clone(),
        },
        verdict: Verdict::from(summary.broken == 0),
        asked: asked(summary, manifest),
        headline,
        summary: summaries,
        sections,
        warnings: broken.into_iter().collect(),
        ..Page::default()
    })
}

/// The files that the study rests on, as the manifest has them; those of each robot are in inputs.csv.
pub fn inputs(manifest: &Manifest) -> Vec<InputFile> {
    let all = manifest.plan.study.iter().chain(&manifest.plan.catalog).chain(&manifest.outputs);
    all.map(|f| InputFile { name: f.file.clone(), sha256: f.sha256.clone() }).collect()
}

/// What was varied.
fn asked(summary: &Summary, manifest: &Manifest) -> Vec<Part> {
    let plan = &manifest.plan;
    let requirements = counted(plan.requirements as usize, "requirement");
    let top = match plan.settings.top {
        Some(top) => format!("the first {} of each joint", counted(top as usize, "design")),
        None => "every design of each joint".into(),
    };
    let points = match plan.points() {
        1 => String::new(),
        n => format!(" at {n} points of a grid"),
    };
    let rows = plan.grid.iter().map(|p| vec![p.key.clone(), p.values.len().to_string(), p.values.join(", ")]);
    let grid = Table::new("What was varied", &["parameter", ">values", "each"]).rows(rows);
    let text = format!(
        "{requirements}{points}: {}, {} of the catalogue, {top}.",
        counted(summary.robots as usize, "robot"),
        counted(plan.motors.len(), "motor")
    );
    std::iter::once(Part::Text(text)).chain(grid.part()).collect()
}

/// A robot whose every joint has a design.
#[derive(Debug, Clone, PartialEq)]
struct Whole {
    robot: u64,
    name: String,
    /// The cells of the grid.
    point: Vec<String>,
    /// Loss of all first choices \[W\].
    loss: f64,
    /// Their mass \[kg\], where all are known.
    mass: Option<f64>,
    /// Joint, motor and ratio of each.
    choices: Vec<String>,
}

impl Whole {
    /// Its name with its point of the grid.
    fn title(&self, manifest: &Manifest) -> String {
        let at = manifest.plan.grid.iter().zip(&self.point).map(|(p, cell)| format!("{} = {cell}", p.key));
        let at: Vec<String> = at.collect();
        if at.is_empty() { self.name.clone() } else { format!("{} with {}", self.name, at.join(", ")) }
    }
}

/// The best robots, and how many there are.
#[derive(Debug, Default)]
struct Best {
    robots: Vec<Whole>,
    whole: u64,
}

impl Best {
    fn first(&self) -> Option<&Whole> {
        self.robots.first()
    }

    fn add(&mut self, robot: Whole) {
        self.whole += 1;
        let place = self.robots.partition_point(|other| other.loss <= robot.loss);
        if place < BEST {
            self.robots.insert(place, robot);
            self.robots.truncate(BEST);
        }
    }

    fn table(&self, manifest: &Manifest) -> Table {
        let grid: Vec<String> = manifest.plan.grid.iter().map(heading).collect();
        let mut header = vec![">#", ">robot", "requirement"];
        header.extend(grid.iter().map(String::as_str));
        header.extend([">loss [W]", ">mass [kg]", "first choices"]);
        let rows = self.robots.iter().enumerate().map(|(place, of)| {
            let mut cells = vec![(place + 1).to_string(), of.robot.to_string(), of.name.clone()];
            cells.extend(of.point.iter().cloned());
            cells.extend([number(of.loss), optional(of.mass), of.choices.join("; ")]);
            cells
        });
        Table::new("Robots whose every joint has a design, the least loss of their first choices first", &header)
            .rows(rows)
    }
}

fn heading(parameter: &PlannedParameter) -> String {
    if parameter.numeric { format!(">{}", parameter.key) } else { parameter.key.clone() }
}

/// Reads the results once, robot by robot: nothing grows with their number.
fn best(out: &Path, manifest: &Manifest) -> Result<Best, StudyError> {
    let path = out.join("results.csv");
    let fail = |e: csv::Error| StudyError::Argument(format!("cannot read `{}`: {e}", path.display()));
    let mut reader = csv::Reader::from_path(&path).map_err(fail)?;
    let head = reader.headers().map_err(fail)?.clone();
    let column = |name: &str| head.iter().position(|h| h == name);
    let grid: Vec<Option<usize>> = manifest.plan.grid.iter().map(|p| column(&p.column)).collect();
    let [robot, name, joint, count, rank, motor, ratio, loss, mass, gear] =
        ["robot", "name", "joint", "joint_count", "rank", "motor", "ratio", "loss_w", "mass_kg", "gear"].map(column);
    let mut best = Best::default();
    let mut here: Option<(Whole, bool, String)> = None;
    let take = |here: Option<(Whole, bool, String)>, best: &mut Best| {
        if let Some((whole, true, _)) = here {
            best.add(whole);
        }
    };
    for row in reader.records() {
        let row = row.map_err(fail)?;
        let text = |at: Option<usize>| at.and_then(|k| row.get(k)).map_or("", unguarded);
        let number_of = |at| text(at).parse::<f64>().ok();
        let id: u64 = text(robot).parse().unwrap_or(u64::MAX);
        if here.as_ref().is_none_or(|(whole, ..)| whole.robot != id) {
            take(here.take(), &mut best);
            // As the study's file has it: a number with its unit.
            let written = |(p, k): (&PlannedParameter, &Option<usize>)| {
                let value = p.cells.iter().position(|cell| cell == text(*k)).and_then(|v| p.values.get(v));
                value.cloned().unwrap_or_else(|| text(*k).to_string())
            };
            let point = manifest.plan.grid.iter().zip(&grid).map(written).collect();
            let name = text(name).to_string();
            let whole = Whole { robot: id, name, point, loss: 0.0, mass: Some(0.0), choices: Vec::new() };
            here = Some((whole, true, String::new()));
        }
        let Some((whole, complete, last)) = &mut here else { continue };
        // The first row of a joint is its first choice, or says that there is none.
        if *last == text(joint) {
            continue;
        }
        *last = text(joint).to_string();
        let count = number_of(count).unwrap_or(1.0);
        match (text(rank), number_of(loss)) {
            ("1", Some(loss)) => {
                whole.loss += count * loss;
                whole.mass = whole.mass.zip(number_of(mass)).map(|(sum, mass)| sum + count * mass);
                let gear = if text(gear).is_empty() { String::new() } else { format!(" + {}", text(gear)) };
                let at = number_of(ratio).map_or_else(String::new, |n| format!(" at N = {}", number(n)));
                whole.choices.push(format!("{}: {}{gear}{at}", text(joint), text(motor)));
            }
            _ => *complete = false,
        }
    }
    take(here, &mut best);
    Ok(best)
}

/// How often which motor is first, joint by joint.
fn joints(summary: &Summary) -> Vec<Part> {
    // Robots whose joints are chosen one by one have no combinations.
    let combined = summary.joints.iter().any(|joint| joint.without_combination > 0);
    let mut header = vec!["joint", ">robots", ">no design"];
    header.extend(combined.then_some(">no combination"));
    header.extend([">not judged", ">least loss [W]", ">mean loss [W]", ">largest loss [W]"]);
    header.extend(["most frequent first choice", ">share [%]"]);
    let mut table = Table::new("Joints of one name", &header);
    let mut all =
        Table::new("Motors", &["joint", "motor", ">first choice", ">share [%]", ">among those asked for", ">cannot"]);
    for joint in &summary.joints {
        let share = |first: u64| number((1000.0 * first as f64 / joint.robots.max(1) as f64).round() / 10.0);
        let first = joint.motors.first().filter(|m| m.first > 0);
        let mut cells = vec![joint.joint.clone()];
        cells.extend([joint.robots, joint.without_design].map(|n| n.to_string()));
        cells.extend(combined.then(|| joint.without_combination.to_string()));
        cells.push(joint.unjudged.to_string());
        cells.extend([joint.least_loss_w, joint.mean_loss_w, joint.largest_loss_w].map(optional));
        cells.push(first.map_or_else(|| "none".into(), |m| m.motor.clone()));
        cells.push(first.map_or_else(String::new, |m| share(m.first)));
        table.push(first.map_or("", |m| &m.motor), cells);
        for m in &joint.motors {
            let cells = [m.first.to_string(), share(m.first), m.among.to_string(), m.cannot.to_string()];
            all.rows.push(Row {
                id: m.motor.clone(),
                cells: [joint.joint.clone(), m.motor.clone()].into_iter().chain(cells).collect(),
                faint: m.first == 0,
            });
        }
    }
    let count = all.rows.len();
    let folded =
        all.part().map(|part| Part::Folded(format!("Every motor that is among them ({count})"), Box::new(part)));
    table.part().into_iter().chain(folded).collect()
}

fn effects(effects: &[Effect]) -> Table {
    let header = [
        "parameter",
        "value",
        "against",
        "joint",
        ">loss times",
        ">other first choice [%]",
        ">gained",
        ">lost",
        ">pairs",
    ];
    let rows = effects.iter().map(|e| {
        let other = match e.pairs {
            0 => "–".to_string(),
            pairs => format!("{:.0}", 100.0 * e.other_first_choice as f64 / pairs as f64),
        };
        let mut cells = vec![e.parameter.clone(), e.value.clone(), e.reference.clone(), e.joint.clone()];
        cells.extend([optional(e.loss_ratio), other, e.gained.to_string(), e.lost.to_string(), e.pairs.to_string()]);
        cells
    });
    Table::new("Effects", &header).rows(rows)
}
