//! Why a motor was rejected, in words.

use super::said::bind_text;
use super::{number, unjudged};
use gearwise_model::requirement::Joint;
use gearwise_select::answer::Reason;
use gearwise_select::program::Infeasible;

/// Why a motor was rejected: a short class for counting, and the sentence.
pub fn reason_text(reason: &Reason, joint: &Joint) -> (String, String) {
    // By how much a limit is exceeded, after the verb.
    let by = |over: f64, allowed: f64| match () {
        () if allowed == 0.0 => "above a limit of zero".to_string(),
        () if !over.is_finite() => "unbounded".into(),
        () if allowed < 0.0 => format!("{} against a limit of {}", number(over * allowed), number(allowed)),
        () => format!("{} times the limit", number(over)),
    };
    match reason {
        Reason::Unusable(unusable) => (unusable.reason().into(), unusable.reason().into()),
        Reason::Infeasible(Infeasible::Never { bind, least, allowed, ratio }) => (
            format!("{} is exceeded at every ratio", bind.limit),
            format!(
                "{} is exceeded at every ratio: at best it is {}, at N = {}",
                bind_text(bind, joint),
                by(*least, *allowed),
                number(*ratio)
            ),
        ),
        Reason::Infeasible(Infeasible::Contradiction { low, at_least, high, at_most }) if low.limit == "ratio_min" => (
            format!("{} allows only ratios below the range", high.limit),
            format!(
                "{} allows only N ≤ {}, below the range from {}",
                bind_text(high, joint),
                number(*at_most),
                number(*at_least)
            ),
        ),
        Reason::Infeasible(Infeasible::Contradiction { low, at_least, high, at_most }) if high.limit == "ratio_max" => {
            (
                format!("{} needs ratios above the range", low.limit),
                format!(
                    "{} needs N ≥ {}, above the range up to {}",
                    bind_text(low, joint),
                    number(*at_least),
                    number(*at_most)
                ),
            )
        }
        Reason::Infeasible(Infeasible::Contradiction { low, at_least, high, at_most }) => (
            match low.limit == high.limit {
                true => format!("{} is exceeded at every ratio, at one instant or another", low.limit),
                false => format!("{} needs a larger ratio than {} allows", low.limit, high.limit),
            },
            format!(
                "{} needs N ≥ {}, {} allows N ≤ {}",
                bind_text(low, joint),
                number(*at_least),
                bind_text(high, joint),
                number(*at_most)
            ),
        ),
        Reason::Infeasible(Infeasible::Nowhere { bind, least, allowed, ratio }) => (
            format!("no ratio keeps all limits together; at the nearest {} is exceeded", bind.limit),
            format!(
                "no ratio keeps all limits together: {} is {} at the nearest, N = {}",
                bind_text(bind, joint),
                by(*least, *allowed),
                number(*ratio)
            ),
        ),
        // At such a speed a module's row gives nothing, however little is asked.
        Reason::Module { bind, over, .. } if !over.is_finite() => (
            format!("{} is exceeded", bind.limit),
            format!("{}: at that speed it gives no torque", bind_text(bind, joint)),
        ),
        Reason::Module { bind, over, allowed } => {
            (format!("{} is exceeded", bind.limit), format!("{} is {}", bind_text(bind, joint), by(*over, *allowed)))
        }
        Reason::Gears { bind, over, allowed, tried } => (
            format!("no gear will do; with the nearest, {} is exceeded", bind.limit),
            format!(
                "none of {tried} gears will do; with the nearest, {} is {}",
                bind_text(bind, joint),
                by(*over, *allowed)
            ),
        ),
        Reason::Unchecked(limit, why) => {
            (format!("{limit} cannot be checked"), format!("{limit} cannot be checked: {why}"))
        }
        Reason::Unjudged(because) => (unjudged::class(because), unjudged::sentence(because)),
        Reason::Rule(why) => ("a rule is broken".into(), format!("a rule is broken: {why}")),
        Reason::Unbounded => ("the objective has no lower bound".into(), "the objective has no lower bound".into()),
        Reason::NotSolved(why) => ("not solved".into(), format!("not solved: {why}")),
    }
}
