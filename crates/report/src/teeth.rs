//! Teeth of planetary gears in words.

use super::number;
use gearwise_model::requirement::{Joint, Teeth, Train};
use gearwise_model::words::counted;

/// Teeth of a train of simple planetary stages.
pub(super) fn of_train(train: &Train) -> String {
    let stages: Vec<String> =
        train.stages.iter().map(|stage| format!("sun {} ring {}", stage.sun, stage.ring)).collect();
    stages.join(", then ")
}

/// The ratios of a joint that lists its stages.
pub(super) fn ratios(teeth: &Teeth) -> String {
    let ends = [teeth.gears.first(), teeth.gears.last()].map(|gear| number(gear.map_or(f64::NAN, |gear| gear.ratio)));
    let [from, to] = ends;
    format!("ratio {from} to {to} by teeth ({})", counted(teeth.gears.len(), "gear"))
}

/// The teeth of a ratio of a joint that lists its stages.
pub(super) fn of_ratio(joint: &Joint, ratio: f64) -> Option<String> {
    let (teeth, gear) = (joint.ratio.teeth()?, joint.ratio.toothed(ratio)?);
    let others = match gear.others {
        0 => "no others have this ratio".into(),
        1 => "one other set of teeth has this ratio, of no fewer".into(),
        n => format!("{n} other sets of teeth have this ratio, of no fewer"),
    };
    Some(format!("teeth: {}, {} planets each; {others}", of_train(&gear.train), teeth.planets))
}

/// What was left out of the ratios of a joint that lists its stages.
pub(super) fn note(joint: &Joint) -> Option<String> {
    let teeth = joint.ratio.teeth()?;
    let within = teeth.within?;
    Some(format!(
        "Of {} ratios that can be assembled {} are looked at: each other one is within {} of one of these, which has \
         no more teeth.",
        teeth.ratios,
        teeth.gears.len(),
        format_args!("{} %", number((1e4 * within).ceil() / 100.0))
    ))
}
