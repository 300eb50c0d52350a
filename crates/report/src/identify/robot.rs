//! What the logs of a whole robot say: of its masses first, then a line for each joint.

use super::{heading_of_logs, listed, overall, short};
use crate::number;
use crate::table::{Column, Table, paragraph};
use gearwise_identify::identify::{Report, Verdict};
use gearwise_identify::robot::{Asked, Carrier, JointReport, Named, PayloadAnswer, RobotBench, RobotReport};

/// What is to be said of a robot: each joint with its reports, or why it has none.
pub struct Said<'a> {
    /// Whether the masses of the description are enough.
    pub payload: &'a PayloadAnswer,
    joints: Vec<(&'a JointReport, Result<Vec<Report>, String>)>,
}

impl<'a> Said<'a> {
    /// Of a report.
    pub fn new(report: &'a RobotReport) -> Said<'a> {
        let reports = |joint: &'a JointReport| {
            let identified = joint.identified.as_ref().map_err(Clone::clone);
            (joint, identified.map(|all| all.iter().map(|i| i.report.clone()).collect()))
        };
        Said { payload: &report.payload, joints: report.joints.iter().map(reports).collect() }
    }

    /// The joints.
    pub fn joints(&self) -> impl Iterator<Item = (&'a JointReport, &Result<Vec<Report>, String>)> {
        self.joints.iter().map(|(joint, reports)| (*joint, reports))
    }
}

fn carrier(carrier: &Carrier) -> String {
    match carrier.has_payload {
        true => format!("the payload at `{}`", carrier.link),
        false => format!("the mass of `{}`, or of what hangs on it", carrier.link),
    }
}

/// Whether the masses are enough, in sentences.
pub fn payload(robot: &RobotBench, answer: &PayloadAnswer) -> String {
    match masses(robot, answer) {
        (head, None) => head,
        (head, Some(more)) => format!("{head} {more}"),
    }
}

/// Whether the masses are enough in one sentence, and what that rests on.
pub fn masses(robot: &RobotBench, answer: &PayloadAnswer) -> (String, Option<String>) {
    match answer {
        PayloadAnswer::NotAsked => {
            let why = "Masses were not asked for: no joint with a current carries a part of the robot in these logs.";
            (why.into(), None)
        }
        PayloadAnswer::Enough(felt) => {
            let head = format!(
                "No mass beyond the description was found; at `{}` the logs suit {} kg more best (95 %).",
                felt.carrier.link,
                within(felt.mass, felt.error)
            );
            (head, None)
        }
        PayloadAnswer::Named(named) => {
            let what = match named.carriers.as_slice() {
                [one] => format!("{} is not as declared", carrier(one)),
                all => format!(
                    "something is not as declared: {}",
                    all.iter().map(carrier).collect::<Vec<_>>().join(", or ")
                ),
            };
            let head = format!("{}{}: the logs want {}.", what[..1].to_uppercase(), &what[1..], mass(named));
            (head, Some(format!("{} The joints are compared with it.", witnesses(robot, named))))
        }
        PayloadAnswer::Open(named, why) => {
            let links: Vec<String> = named.carriers.iter().map(|c| format!("`{}`", c.link)).collect();
            let why = match why {
                Asked::Scales => {
                    "torques of the drives that are off by a factor explain as much: a run with another known payload separates them"
                }
                Asked::OneJoint => {
                    "fewer than two joints feel it, and one joint's own torque may be off: move more joints that carry it"
                }
                Asked::LeavesMuch => {
                    "much of the error is left with it: a sign, a zero of an angle, the direction of gravity or a length of the description may be wrong"
                }
                Asked::Scatters => {
                    "what it takes away scatters too much between stretches of the logs: a longer run would show more"
                }
                Asked::Disagree => {
                    "alone the joints ask for different masses there: it is no single mass at that place"
                }
            };
            let head = format!(
                "A mass at {} would lower the error ({}), but is not certain: {why}.",
                listed(&links),
                mass(named)
            );
            (
                head,
                Some(format!(
                    "{} The joints are compared without it: their torque constants, and effects that follow the load, may be that mass.",
                    witnesses(robot, named)
                )),
            )
        }
    }
}

/// A mass with its ±, to a tenth of that.
fn within(mass: f64, error: f64) -> String {
    if error.is_nan() || error <= 0.0 {
        return number(mass);
    }
    let step = 10_f64.powi((error.log10().floor() as i32) - 1);
    let rounded = |value: f64| number((value / step).round() * step);
    format!("{} ± {}", rounded(mass), rounded(error))
}

fn mass(named: &Named) -> String {
    let more = if named.mass < 0.0 { "less" } else { "more" };
    let at = named.at.map(|v| number((1e3 * v).round() / 1e3)).join(", ");
    let place = if named.is_place_fitted { "fitted at" } else { "at" };
    format!("{} kg {more}, {place} ({at}) m", within(named.mass.abs(), named.error))
}

fn witnesses(robot: &RobotBench, named: &Named) -> String {
    let one =
        |w: &gearwise_identify::robot::Witness| format!("`{}` {}", robot.joints[w.joint].name, within(w.mass, w.error));
    let gain = number((1e3 * named.gain).round() / 10.0);
    match named.witnesses.as_slice() {
        [] => format!("It takes away {gain} % of the squared error of all joints."),
        all => format!(
            "It takes away {gain} % of the squared error of all joints; alone they ask for [kg]: {}.",
            all.iter().map(one).collect::<Vec<_>>().join(", ")
        ),
    }
}

/// Columns of [`joint_rows`].
pub fn joint_columns() -> Vec<Column> {
    vec![
        Column::name("joint"),
        Column::name("motor").dropped(2),
        Column::number("declared", "N*m"),
        Column::number("final", "N*m"),
        Column::name("on").dropped(1),
        Column::name("missing"),
        Column::name("verdict").dropped(3),
    ]
}

/// A line for each joint: its error as declared and in the end, and what its actuator lacks.
pub fn joint_rows(robot: &RobotBench, said: &Said) -> Vec<Vec<String>> {
    said.joints().map(|(joint, reports)| row(robot, joint, reports)).collect()
}

fn row(robot: &RobotBench, joint: &JointReport, reports: &Result<Vec<Report>, String>) -> Vec<String> {
    let name = robot.joints[joint.joint].name.clone();
    let motor = joint.bench.declared.motor.as_ref().map_or_else(String::new, |m| m.id.clone());
    let none = || "–".to_string();
    let Ok(reports) = reports else {
        return vec![name, motor, none(), none(), none(), "nothing can be learnt".into(), none()];
    };
    let end = reports.first().and_then(|r| r.stages.last());
    let start = joint.declared.or_else(|| reports.first().and_then(|r| r.stages.first()).map(|s| (s.fit, s.held_out)));
    let (from, to, on) = match (start, end) {
        (Some((_, Some(from))), Some(end)) if end.held_out.is_some() => {
            (number(from), end.held_out.map_or_else(none, number), "held out")
        }
        (Some((from, _)), Some(end)) => (number(from), number(end.fit), "fit"),
        _ => (none(), none(), ""),
    };
    let names: Vec<&str> = reports.iter().flat_map(|r| &r.effects).map(|e| e.name()).collect();
    let missing = if names.is_empty() { none() } else { names.join(", ") };
    vec![name, motor, from, to, on.into(), missing, overall(reports).word().into()]
}

/// What else a weight may be that the description lacks.
pub fn of_weight(reports: &[Report]) -> &'static str {
    match reports.iter().flat_map(|r| &r.effects).any(|e| e.effect.is_weight()) {
        true => " Gravity beyond the description may be a zero of an angle, the direction of gravity, or a mass.",
        false => "",
    }
}

/// For people.
pub fn text(robot: &RobotBench, said: &Said) -> String {
    let actuators = robot.joints.iter().filter(|j| j.declared.is_some()).count();
    let what =
        format!("{}: {} {} of {}", robot.name, actuators, if actuators == 1 { "joint" } else { "joints" }, robot.model);
    let mut out = robot.joints.first().map_or_else(String::new, |first| heading_of_logs(&what, &first.logs));
    out.push_str(&format!("\n{}\n", paragraph(&payload(robot, said.payload), 0, 2)));
    out.push_str(&Table::new(joint_columns()).rows(joint_rows(robot, said)).also_in("`--json`").text());
    for (joint, reports) in said.joints() {
        let name = &robot.joints[joint.joint].name;
        let line = match reports {
            Ok(reports) => format!("{}{}", short(&joint.bench, reports), of_weight(reports)),
            Err(why) => format!("Nothing can be learnt: {why}."),
        };
        out.push_str(&format!("\n{}", paragraph(&format!("{name}: {line}"), 0, 2)));
    }
    out.push_str("\n`--joint NAME` shows all of one joint, and takes `--write`, `--requirement` and `--plot`.\n");
    out
}

/// For programs: the rows of every joint, with its name in front.
pub fn csv(robot: &RobotBench, said: &Said) -> String {
    let rows = std::iter::once(mass_row(robot, said.payload)).chain(said.joints().flat_map(|(joint, reports)| {
        let name = &robot.joints[joint.joint].name;
        let of = match reports {
            Ok(reports) => super::csv_rows(&joint.bench, reports),
            Err(why) => {
                let mut row = vec![String::new(); super::CSV.len()];
                row[..3].clone_from_slice(&["all".into(), "verdict".into(), Verdict::NotResolved.word().into()]);
                row[super::CSV.len() - 1].clone_from(why);
                vec![row]
            }
        };
        of.into_iter().map(move |row| std::iter::once(name.clone()).chain(row).collect::<Vec<_>>())
    }));
    let header: Vec<&str> = std::iter::once("joint").chain(super::CSV).collect();
    crate::csv_text(&header, rows)
}

/// The answer about masses as a row.
fn mass_row(robot: &RobotBench, answer: &PayloadAnswer) -> Vec<String> {
    let (link, value) = match answer {
        PayloadAnswer::NotAsked => (None, None),
        PayloadAnswer::Enough(felt) => (Some(&felt.carrier.link), Some((felt.mass, felt.error))),
        PayloadAnswer::Open(named, _) | PayloadAnswer::Named(named) => {
            (named.carriers.first().map(|c| &c.link), Some((named.mass, named.error)))
        }
    };
    let mut row = vec![String::new(); 1 + super::CSV.len()];
    row[1..4].clone_from_slice(&["all".into(), "mass".into(), link.cloned().unwrap_or_default()]);
    row[5] = crate::csv_number(value.map(|v| v.0));
    row[6] = crate::csv_number(value.map(|v| v.1));
    row[12] = value.map_or_else(String::new, |_| "kg".into());
    row[13] = payload(robot, answer);
    row
}
