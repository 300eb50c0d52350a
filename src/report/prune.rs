//! What was not solved, where only the first designs of a joint were wanted.

use serde_json::{Value, json};

use super::number;
use super::table::wrap;
use crate::design::optimize::JointResult;
use crate::design::prune::Pruned;
use crate::requirement::Joint;

/// How many can, cannot, and were not solved.
pub(super) fn verdict(result: &JointResult, pruned: &Pruned) -> String {
    let solved = result.candidates.len() + pruned.behind;
    let cannot = result.rejected.len() + pruned.impossible.len();
    let apart = super::unjudged::counted(result.unjudged.len());
    match pruned.not_solved.len() {
        0 => format!("{solved} motors can do it, {cannot} cannot{apart}"),
        left => format!(
            "of the motors solved {solved} can do it and {cannot} cannot{apart}; {left} not solved, none of them is among the first {}",
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
        "{} motors were not solved: whether they can do it is not known, but their {} is at least {}{unit}. No order by metric is \
         compared. Without `--only-top` all are solved",
        pruned.not_solved.len(),
        joint.objective.name(),
        number(*least),
    );
    format!("  {}\n", wrap(&line, 4))
}

/// Why a motor was not solved.
pub(super) fn reason(joint: &Joint, keep: usize, bound: f64) -> String {
    format!("not solved: {} is at least {}, which is not among the first {keep}", joint.objective.name(), number(bound))
}

/// For programs.
pub(super) fn json(pruned: &Pruned) -> Value {
    let not_solved = pruned.not_solved.iter().map(|(motor, bound)| json!({ "motor": motor.id, "lower_bound": bound }));
    json!({
        "keep": pruned.keep,
        "feasible_behind": pruned.behind,
        "not_solved": not_solved.collect::<Vec<_>>(),
    })
}
