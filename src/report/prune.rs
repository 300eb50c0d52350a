//! What was not solved, where only the first designs of a joint were wanted.

use super::number;
use super::table::paragraph;
use crate::design::answer::{JointResult, Pruned};
use crate::requirement::Joint;

/// How many can, cannot, and were not solved.
pub(super) fn verdict(result: &JointResult, pruned: &Pruned) -> String {
    let solved = result.candidates.len() + pruned.behind;
    let refused = super::optimize::refusals(result);
    match pruned.not_solved.len() {
        0 => format!("{} can do it, {refused}", crate::words::counted(solved, "motor")),
        left => format!(
            "of the motors solved {solved} can do it, {refused}; {left} not solved, none of them is among the first {}",
            pruned.keep
        ),
    }
}

/// What stands behind the first ones.
pub(super) fn text(joint: &Joint, pruned: &Pruned) -> String {
    let Some((_, least)) = pruned.not_solved.first() else { return String::new() };
    let unit = match joint.objective.unit() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let line = format!(
        "Not solved: {}, with {} of at least {}{unit}; whether any can do it is not known. No order by metric is compared. \
         Without `--only-top` all are solved",
        crate::words::counted(pruned.not_solved.len(), "motor"),
        joint.goal(),
        number(*least),
    );
    paragraph(&line, 2, 4)
}

/// Why a motor was not solved.
pub(super) fn reason(joint: &Joint, keep: usize, bound: f64) -> String {
    format!("not solved: {} is at least {}, which is not among the first {keep}", joint.goal(), number(bound))
}
