//! Rules as limits of the program: what a rule asks of a measure that the model limits is kept while a design is chosen,
//! so that what is chosen passes its check.

use super::file::RulesFile;
use super::measure::{Measure, Value, measure};
use super::registry::RULES;
use super::rule::{Severity, Test};
use gearwise_model::actuator::limits::LIMITS;
use gearwise_model::requirement::{Joint, Limits, RatioChoice, Robot};

/// A bound of a rule that became a limit of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Name of the rule.
    pub rule: String,
    /// The joint.
    pub joint: String,
    /// The limit that it tightens.
    pub limit: &'static str,
}

/// The robot whose limits are tightened by what rules bound, and which rule tightens what. Rules that bound nothing that
/// the model limits are looked at on the result ([`crate::check`]).
pub fn bounded(robot: &Robot, file: &RulesFile) -> (Robot, Vec<Kept>) {
    let mut robot = robot.clone();
    let mut kept = Vec::new();
    for joint in &mut robot.joints {
        let name = joint.name.clone();
        let own = joint.limits.clone();
        let mut keep = |joint: &mut Joint, rule: &str, measure: &Measure, min: Option<f64>, max: Option<f64>| {
            if let Some(limit) = tighten(joint, &own, measure, min, max) {
                kept.push(Kept { rule: rule.into(), joint: name.clone(), limit });
            }
        };
        for rule in RULES {
            let Test::Bounds { measures, min, max } = rule.test else { continue };
            let (severity, _) = file.severity(rule, Some(&name));
            let [min, max] = file.bounds(rule, &name, [min, max]);
            for found in measures.iter().filter_map(|name| measure(name)) {
                let allowed = file.allows.iter().any(|allow| allow.is_of(rule.code, Some(&name), &found.name));
                if severity >= Severity::Warning && !allowed {
                    keep(joint, rule.name, found, min, max);
                }
            }
        }
        for own in file.own.iter().filter(|own| own.joints.has(&name) && own.severity >= Severity::Warning) {
            let allowed = file.allows.iter().any(|allow| allow.is_of(&own.name, Some(&name), &own.measure.name));
            if !allowed {
                keep(joint, &own.name, own.measure, own.min, own.max);
            }
        }
    }
    (robot, kept)
}

/// Tightens a limit of a joint by the bounds of a measure; the limit, where there is one that the measure is of. `own` is
/// what the requirement itself asks: several rules of one limit do not add up.
fn tighten(
    joint: &mut Joint,
    own: &Limits,
    measure: &Measure,
    min: Option<f64>,
    max: Option<f64>,
) -> Option<&'static str> {
    let Limits { safety, .. } = *own;
    let least = |place: &mut Option<f64>, most: f64| *place = Some(place.map_or(most, |was| was.min(most)));
    match (measure.value, measure.name.as_str()) {
        (Value::Margin(limit), _) => {
            let (limit, share) = (limit_named(limit)?, min?);
            // Of what the requirement's own reserve leaves.
            joint.limits.keep_reserve(limit, 1.0 - own.left_of(limit) * (1.0 - share));
            Some(limit)
        }
        (Value::Reserve(limit), _) => {
            let (limit, share) = (limit_named(limit)?, min?);
            let has_safety = LIMITS.iter().any(|l| l.name == limit && l.safety);
            let factor = if has_safety { safety } else { 1.0 };
            // The demand of the limit has the factor in it already.
            joint.limits.keep_reserve(limit, 1.0 - factor * (1.0 - share));
            Some(limit)
        }
        (_, "temperature_reserve") => {
            joint.limits.temperature_reserve = joint.limits.temperature_reserve.max(min?);
            Some("winding_temperature")
        }
        (_, "mass") => {
            least(&mut joint.limits.actuator_mass, max?);
            Some("actuator_mass")
        }
        (_, "reflected_inertia") => {
            least(&mut joint.limits.reflected_inertia, max?);
            Some("reflected_inertia")
        }
        (_, "ratio") => {
            if let RatioChoice::Listed { values, .. } = &mut joint.ratio {
                let kept = |n: &f64| min.is_none_or(|min| *n >= min) && max.is_none_or(|max| *n <= max);
                // A rule that leaves no ratio is found on the result.
                if !values.iter().any(kept) {
                    return None;
                }
                values.retain(kept);
                return Some("ratio");
            }
            let RatioChoice::Continuous { min: low, max: high, .. } = &mut joint.ratio else { return None };
            let (at_least, at_most) = (min.unwrap_or(*low).max(*low), max.unwrap_or(*high).min(*high));
            // A rule that leaves no ratio is found on the result.
            if at_least > at_most {
                return None;
            }
            (*low, *high) = (at_least, at_most);
            Some("ratio")
        }
        _ => None,
    }
}

fn limit_named(name: &str) -> Option<&'static str> {
    LIMITS.iter().find(|limit| limit.name == name).map(|limit| limit.name)
}
