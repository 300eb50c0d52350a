//! A robot drawn joint by joint: which actuator carries which, how heavy each is, what it loses, and how much its tightest limit leaves.
//!
//! The one idea: each joint is a line of the page. At its start the robot is drawn: a disc as large as the actuators are heavy, on a line
//! that leads from what carries it to what it carries. So it can be read at any width, printed, and read aloud.

use std::fmt::Write as _;

use super::render::printed;
use crate::number;
use crate::plot::Tone;
use gearwise_model::requirement::Robot;
use gearwise_select::robot::{Choice, Combination};

/// A joint in its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name of the joint, and how many there are.
    pub name: String,
    /// What it is built of.
    pub built: String,
    /// Which column the chain runs in here.
    pub column: usize,
    /// Columns with a line from above, and with a line that goes on below.
    pub above: Vec<usize>,
    /// As `above`, below.
    pub below: Vec<usize>,
    /// What carries it, by its place among the links.
    pub from: Option<usize>,
    /// Mass of all its actuators \[kg\].
    pub mass: Option<f64>,
    /// Loss of all its actuators \[W\].
    pub loss: f64,
    /// The limit that leaves least, and what it leaves (1 is all).
    pub tightest: Option<(&'static str, f64)>,
}

/// A robot's joints in the order of what carries what.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// What it shows.
    pub title: String,
    /// Its joints.
    pub links: Vec<Link>,
}

/// Width of a column.
const COLUMN: f64 = 34.0;
/// Where the disc of a joint is, from above.
const MIDDLE: &str = "24";
/// Largest radius of a disc.
const RADIUS: f64 = 15.0;
/// Length of the longest bar in its own unit, which is stretched.
const LONGEST: f64 = 1000.0;

/// What carries each joint: as the description of the robot says it, else of all that carry its actuators that which carries least.
fn carriers(robot: &Robot) -> Vec<Option<usize>> {
    if let Some(driven) = &robot.driven {
        return driven.hangs_on.clone();
    }
    let carries = |k: usize, joint: usize| robot.joints[k].carries.iter().any(|c| c.joint == joint);
    let of = |joint: usize| {
        let all = (0..robot.joints.len()).filter(|k| carries(*k, joint));
        all.min_by_key(|k| robot.joints[*k].carries.len())
    };
    (0..robot.joints.len()).map(of).collect()
}

impl Chain {
    /// The best combination of a robot.
    pub(super) fn of(choice: &Choice, best: &Combination) -> Chain {
        let robot = choice.robot;
        let carriers = carriers(robot);
        let mut chain = Chain { title: format!("{}, joint by joint", robot.name), links: Vec::new() };
        let mut columns = 0;
        for root in (0..carriers.len()).filter(|j| carriers[*j].is_none()) {
            chain.add(choice, best, &carriers, root, (0, None), &mut columns);
        }
        chain.connect();
        chain
    }

    fn add(
        &mut self,
        choice: &Choice,
        best: &Combination,
        carriers: &[Option<usize>],
        joint: usize,
        (column, from): (usize, Option<usize>),
        columns: &mut usize,
    ) {
        let (of, design) = (&choice.robot.joints[joint], &best.joints[joint]);
        let count = f64::from(of.count);
        let times = if of.count > 1 { format!(" (×{})", of.count) } else { String::new() };
        let gear = design.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
        self.links.push(Link {
            name: format!("{}{times}", of.name),
            built: format!("{}{gear}, N {}", design.motor.id, number(design.evaluation.ratio)),
            column,
            above: Vec::new(),
            below: Vec::new(),
            from,
            mass: design.evaluation.mass.map(|mass| count * mass),
            loss: count * design.evaluation.loss,
            tightest: design.evaluation.tightest().map(|m| (m.limit, m.margin.max(0.0))),
        });
        *columns = (*columns).max(column);
        let place_of = self.links.len() - 1;
        // The first that it carries goes on in its column, each further one in a new column.
        let carried = (0..carriers.len()).filter(|k| carriers[*k] == Some(joint));
        for (place, next) in carried.enumerate() {
            let to = if place == 0 { column } else { *columns + 1 };
            self.add(choice, best, carriers, next, (to, Some(place_of)), columns);
        }
    }

    /// Lines that pass a joint on their way.
    fn connect(&mut self) {
        for to in 0..self.links.len() {
            let Some(from) = self.links[to].from else { continue };
            // It runs in the column of what is carried, from the line of what carries it.
            let column = self.links[to].column;
            self.links[from].below.push(column);
            for passed in &mut self.links[from + 1..to] {
                passed.above.push(column);
                passed.below.push(column);
            }
            self.links[to].above.push(column);
        }
        for link in &mut self.links {
            link.above.sort_unstable();
            link.above.dedup();
            link.below.sort_unstable();
            link.below.dedup();
        }
    }

    /// The drawing.
    pub(super) fn html(&self) -> String {
        let heaviest = self.links.iter().filter_map(|link| link.mass).fold(0.0, f64::max);
        let most = self.links.iter().map(|link| link.loss).fold(0.0, f64::max);
        let columns = self.links.iter().map(|link| link.column).max().unwrap_or(0) + 1;
        let mut out = format!(
            "<figure class=\"chain\"><figcaption>{}</figcaption>\n<p class=\"note\">The disc is as large as the actuators are heavy; the lines lead from what carries to what is carried. Mass and loss are those of all actuators of a joint.</p>\n<ol>\n",
            printed(&self.title)
        );
        for link in &self.links {
            let _ = writeln!(
                out,
                "<li>{}<div><p><b>{}</b> {}</p>",
                self.drawn(link, columns, heaviest),
                printed(&link.name),
                printed(&link.built)
            );
            let mass = link.mass.map_or_else(|| "mass not known".to_string(), |mass| format!("{} kg", number(mass)));
            bar(&mut out, &mass, link.mass.unwrap_or(0.0), heaviest, Tone::Blue);
            bar(&mut out, &format!("{} W lost", number(link.loss)), link.loss, most, Tone::Orange);
            if let Some((limit, margin)) = link.tightest {
                let said = format!("{} % left of {limit}", number((1000.0 * margin).round() / 10.0));
                bar(&mut out, &said, margin.min(1.0), 1.0, Tone::Green);
            }
            out.push_str("</div></li>\n");
        }
        out.push_str("</ol></figure>\n");
        out
    }

    /// The robot at the start of a line, as high as that: ends of lines are shares of its height.
    fn drawn(&self, link: &Link, columns: usize, heaviest: f64) -> String {
        let at = |column: usize| COLUMN * (column as f64 + 0.5);
        let width = COLUMN * columns as f64;
        let mut out = format!(
            "<svg width=\"{width}\" height=\"100%\" aria-hidden=\"true\"><g stroke=\"{}\" stroke-width=\"4\">",
            Tone::Grey.colour()
        );
        let mut line = |x1: f64, y1: &str, x2: f64, y2: &str| {
            let _ = write!(out, "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>");
        };
        link.above.iter().for_each(|column| line(at(*column), "0", at(*column), MIDDLE));
        link.below.iter().for_each(|column| line(at(*column), MIDDLE, at(*column), "100%"));
        // What it carries in another column.
        let branches = link.below.iter().filter(|column| !link.above.contains(column) && **column != link.column);
        branches.for_each(|column| line(at(link.column), MIDDLE, at(*column), MIDDLE));
        let share = link.mass.filter(|_| heaviest > 0.0).map_or(0.1, |mass| mass / heaviest);
        let radius = (RADIUS * share.sqrt()).max(3.0);
        let (x, colour) = (at(link.column), Tone::Blue.colour());
        let _ = write!(out, "</g><circle cx=\"{x}\" cy=\"{MIDDLE}\" r=\"{radius:.1}\" fill=\"{colour}\"/></svg>");
        out
    }
}

/// A line with what it says and a bar of so much of the most.
fn bar(out: &mut String, said: &str, value: f64, most: f64, tone: Tone) {
    let wide = if most > 0.0 { LONGEST * value.max(0.0) / most } else { 0.0 };
    let _ = writeln!(
        out,
        "<p class=\"bar\"><svg viewBox=\"0 0 {LONGEST} 10\" preserveAspectRatio=\"none\" aria-hidden=\"true\"><rect width=\"{wide:.1}\" height=\"10\" fill=\"{}\"/></svg> {}</p>",
        tone.colour(),
        printed(said)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link(name: &str, column: usize, from: Option<usize>) -> Link {
        Link {
            name: name.into(),
            built: "motor, N 5".into(),
            column,
            above: Vec::new(),
            below: Vec::new(),
            from,
            mass: Some(0.25),
            loss: 2.0,
            tightest: Some(("voltage", 0.125)),
        }
    }

    #[test]
    fn lines_lead_from_what_carries_to_what_is_carried() {
        // A hip that carries a knee and, in a column of its own, an arm; the knee carries a foot.
        let links = vec![
            link("hip", 0, None),
            link("knee", 0, Some(0)),
            link("foot", 0, Some(1)),
            link("arm", 1, Some(0)),
            link("head", 0, None),
        ];
        let mut chain = Chain { title: "a & b".into(), links };
        chain.connect();
        let lines: Vec<(&[usize], &[usize])> =
            chain.links.iter().map(|l| (l.above.as_slice(), l.below.as_slice())).collect();
        assert_eq!(lines, [(&[][..], &[0, 1][..]), (&[0, 1], &[0, 1]), (&[0, 1], &[1]), (&[1], &[]), (&[], &[])]);
        let html = chain.html();
        assert!(html.contains("a &amp; b") && html.contains("12.5 % left of voltage") && html.contains("0.25 kg"));
    }
}
