//! The page of an identification of a whole robot.

use super::{Page, Part, Section, Table, Verdict, group_of};
use crate::identify::robot::{Said, joint_columns, joint_rows, masses, of_weight};
use crate::identify::short;
use crate::plot::residual as plot;
use gearwise_identify::robot::RobotBench;

/// The page.
pub fn page(robot: &RobotBench, said: &Said) -> Page {
    let table =
        Table::of("Error of each joint (RMSE), before and after", &joint_columns()).rows(joint_rows(robot, said));
    let mut sections = vec![Section::new("Joints", vec![Part::Table(table)])];
    let mut lines = Vec::new();
    let mut warnings = Vec::new();
    for (joint, reports) in said.joints() {
        let name = &robot.joints[joint.joint].name;
        match reports {
            Ok(reports) => {
                lines.push(format!("{name}: {}{}", short(&joint.bench, reports), of_weight(reports)));
                let figure = plot::figure(&joint.bench, reports);
                let mut parts: Vec<Part> = (0..reports.len()).filter_map(|k| group_of(&figure, k)).collect();
                parts.extend(reports.iter().flat_map(|report| super::identify::equation(&joint.bench, report).parts));
                sections.push(Section::new(name.clone(), parts));
                let of = super::identify::warnings(&joint.bench, reports);
                warnings.extend(of.into_iter().map(|warning| format!("{name}: {warning}")));
            }
            Err(why) => warnings.push(format!("{name}: nothing can be learnt: {why}")),
        }
    }
    let (headline, rests_on) = masses(robot, said.payload);
    let asked = "What the models of these actuators lack, by logs of the whole robot; the load of each joint is computed from the \
                 description and the motion of all joints.";
    Page {
        command: "identify",
        title: format!("{}: joints of {}", robot.name, robot.model),
        verdict: Verdict::Information,
        asked: vec![Part::Text(asked.into())],
        headline,
        summary: rests_on.map(Part::Text).into_iter().chain([Part::List(lines)]).collect(),
        sections,
        warnings,
        ..Page::default()
    }
}
