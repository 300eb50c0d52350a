#![doc = include_str!("../README.md")]

mod answer;
pub mod audit;
mod balance;
pub mod catalog;
pub mod characterize;
pub mod check;
pub mod columns;
pub mod compare;
pub mod currents;
pub mod design_file;
mod estimated;
pub mod explain;
pub mod export;
mod family;
pub mod fitted;
pub mod forward;
pub mod html;
pub mod identify;
pub mod import;
pub mod json;
pub mod losses;
mod motion;
pub mod optimize;
mod outlook;
pub mod over;
pub mod pareto;
pub mod plan;
pub mod plot;
mod prune;
pub mod rank;
pub mod reason;
pub mod remake;
pub mod robot;
pub mod robust;
pub mod rules;
mod said;
pub mod spring;
pub mod sweep;
pub mod table;
mod teeth;
pub mod tint;
pub mod torques;
pub(crate) mod turns;
pub mod unjudged;

pub use gearwise_model::words::csv::{csv_number, csv_row, csv_text, guarded};
pub use gearwise_model::words::{counted, heat_or, with_unit};
pub use gearwise_model::words::{number, number_between, optional};

use serde_json::Value;

use gearwise_select::answer::Design;
use gearwise_select::evaluate::Margin;
use gearwise_select::pareto::{Front, FrontPoint};
use gearwise_select::program::Optimum;

/// How many different motors there are, in words.
///
/// ```
/// use gearwise_report::different_motors;
/// assert_eq!((different_motors(1).as_str(), different_motors(3).as_str()), ("one motor", "3 different motors"));
/// ```
pub fn different_motors(count: usize) -> String {
    if count == 1 { "one motor".into() } else { format!("{count} different motors") }
}

/// What a limit is asked and what it allows, in words: `12 of 10 A`, `thermal runaway, where 85 K are allowed`.
pub(crate) fn demand_of(margin: &Margin) -> String {
    let Margin { demand, bound, unit, .. } = margin;
    match heat_or(*demand, unit) {
        hot if hot != with_unit(*demand, unit) => format!("{hot}, where {} {unit} are allowed", number(*bound)),
        _ => format!("{} of {} {unit}", number(*demand), number(*bound)),
    }
}

/// The ratio of a design, so that it keeps its limits when it is typed again: inside the ratios that do.
pub fn design_ratio(design: &Design) -> String {
    ratio_within(design.evaluation.ratio, &design.optimum, design.gear)
}

/// The ratio of an optimum, rounded into its window; that of a gear is the gear's.
pub fn optimum_ratio(optimum: &Optimum, gear: Option<&str>) -> String {
    ratio_within(optimum.ratio, optimum, gear)
}

fn ratio_within(ratio: f64, optimum: &Optimum, gear: Option<&str>) -> String {
    let window = optimum.window();
    if gear.is_some() { number(ratio) } else { number_between(ratio, window.min, window.max) }
}

/// The ratio of a point on a front, rounded to lie between those of its motor.
pub fn point_ratio(point: &FrontPoint, front: &Front) -> String {
    let ratio = point.evaluation.ratio;
    if point.gear.is_some() {
        return number(ratio);
    }
    let same = || front.points.iter().filter(|p| p.motor.id == point.motor.id).map(|p| p.evaluation.ratio);
    match (same().fold(ratio, f64::min), same().fold(ratio, f64::max)) {
        // One point alone tells nothing of the ratios beside it.
        (min, max) if min == max => number(ratio),
        (min, max) => number_between(ratio, min, max),
    }
}

/// JSON text, two spaces deep, with a final newline.
pub fn json_text(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

/// What a design that is not proved leaves open: by how much of its own value a better one may be less. `gap` is
/// `(objective − lower bound)/|objective|`. Rounded up to two digits, so that "up to" is true.
pub(crate) fn may_be_beaten(gap: f64) -> String {
    let percent = 100.0 * gap;
    if percent == 0.0 {
        return "may be beaten by what rounding leaves".into();
    }
    let step = 10.0_f64.powf(percent.log10().floor() - 1.0);
    // What is two digits already stays.
    let up = (percent / step * (1.0 - 1e-9)).ceil() * step;
    format!("may be beaten by up to {} %", number(up))
}

#[cfg(test)]
mod tests {
    use super::may_be_beaten;

    /// By the definition of the gap the bound is `(1 − gap)` times the objective: so much less may a better one be.
    #[test]
    fn what_may_be_beaten_is_said_by_how_much_and_never_too_little() {
        for (gap, told) in [
            (0.9391, "may be beaten by up to 94 %"),
            (0.94, "may be beaten by up to 94 %"),
            (0.5, "may be beaten by up to 50 %"),
            (1.0e-5, "may be beaten by up to 0.001 %"),
            (1.201, "may be beaten by up to 130 %"),
            (0.0, "may be beaten by what rounding leaves"),
        ] {
            assert_eq!(may_be_beaten(gap), told);
        }
        for k in 1..400 {
            let gap = 1e-9 * 1.06_f64.powi(k);
            let told = may_be_beaten(gap);
            let percent: f64 = told.split_whitespace().rev().nth(1).unwrap().parse().unwrap();
            assert!(percent >= 100.0 * gap * (1.0 - 1e-8) && percent <= 111.0 * gap, "{gap}: {told}");
        }
    }
}
