//! What was not solved, where only the first designs of a joint were wanted.

use super::number;
use super::table::paragraph;
use super::unjudged;
use gearwise_model::requirement::Joint;
use gearwise_select::answer::{JointResult, Pruned, Says};

/// How many motors cannot do a joint, and of how many it is not known.
pub(super) fn refusals(result: &JointResult) -> String {
    let said = |what: Says| result.rejected.iter().filter(|r| r.reason.says() == what).count();
    let cannot = said(Says::Cannot) + result.pruned.as_ref().map_or(0, |p| p.impossible.len());
    let mut out = format!("{cannot} cannot{}", unjudged::counted(result.unjudged.len()));
    let left_out = unjudged::left_out(result.rejected.iter().map(|r| &r.reason));
    for (count, what) in [(left_out, "cannot be checked in full"), (said(Says::NotAllowed), "not allowed")] {
        if count > 0 {
            out.push_str(&format!(", {count} {what}"));
        }
    }
    out
}

/// How many can, cannot, and were not solved.
pub(super) fn verdict(result: &JointResult, pruned: &Pruned) -> String {
    let solved = result.candidates.len() + pruned.behind;
    let refused = refusals(result);
    match pruned.not_solved.len() {
        0 => format!("{} can do it, {refused}", gearwise_model::words::counted(solved, "motor")),
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
        gearwise_model::words::counted(pruned.not_solved.len(), "motor"),
        joint.goal(),
        number(*least),
    );
    paragraph(&line, 2, 4)
}

/// Why a motor was not solved.
pub(super) fn reason(joint: &Joint, keep: usize, bound: f64) -> String {
    format!("not solved: {} is at least {}, which is not among the first {keep}", joint.goal(), number(bound))
}
