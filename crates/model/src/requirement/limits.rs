//! What a choice must keep: `limits` of a joint, with its `spring`.

use super::prices::{self, Money};
use crate::catalog::LifeQuantile;
use crate::input::{Problem, Range, Section, key, limits};
use crate::motion::Motion;
use crate::transmission::{Passed, SpringAt};
use crate::units;

/// Limits that a requirement puts on a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Mass of motor and gear \[kg\].
    pub actuator_mass: Option<f64>,
    /// Outer diameter of the largest part \[m\].
    pub outer_diameter: Option<f64>,
    /// Axial length of all parts \[m\].
    pub axial_length: Option<f64>,
    /// How the lengths of the parts make one.
    pub arrangement: Arrangement,
    /// Price of all parts, in the currency of `[prices]`.
    pub price: Option<f64>,
    /// Longest time until a part is delivered \[s\].
    pub lead_time: Option<f64>,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: Option<f64>,
    /// Torque to be delivered on top of the motion.
    pub torque_bandwidth: Option<TorqueBandwidth>,
    /// Highest winding temperature \[K\].
    pub winding_temperature: Option<f64>,
    /// Torque at the output of a few shocks in a life \[N·m\].
    pub shock_torque: Option<f64>,
    /// Life that the gear is to have \[s\], L10.
    pub life: Option<f64>,
    /// Largest backlash at the output \[rad\].
    pub max_backlash: Option<f64>,
    /// Smallest torsional stiffness of the gear at the output \[N·m/rad\].
    pub min_stiffness: Option<f64>,
    /// Largest torque at the output that sets the actuator going without current \[N·m\].
    pub max_backdriving_torque: Option<f64>,
    /// Thermal resistance from housing to ambient as it is mounted here, in place of the row's \[K/W\].
    pub mount_resistance: Option<f64>,
    /// Factor on demanded torque and current in peak checks (not on heat).
    pub safety: f64,
    /// What of a limit is not to be used, by its name, as a share of what may be had; each limit once.
    pub reserves: Vec<(&'static str, f64)>,
    /// By how much the winding is to stay below its highest temperature \[K\].
    pub temperature_reserve: f64,
    /// A spring parallel to the actuator, to be chosen.
    pub spring: Option<Spring>,
}

impl Limits {
    /// The share of a limit that is kept in reserve.
    pub fn reserve(&self, limit: &str) -> f64 {
        self.reserves.iter().find(|(name, _)| *name == limit).map_or(0.0, |(_, share)| *share)
    }

    /// The share of a limit that its reserve leaves.
    pub fn left_of(&self, limit: &str) -> f64 {
        1.0 - self.reserve(limit)
    }

    /// Keeps at least this share of a limit in reserve.
    pub fn keep_reserve(&mut self, limit: &'static str, share: f64) {
        match self.reserves.iter_mut().find(|(name, _)| *name == limit) {
            Some((_, kept)) => *kept = kept.max(share),
            None if share > 0.0 => self.reserves.push((limit, share)),
            None => {}
        }
    }
}

/// How the parts of an actuator lie to each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// One behind the other on one axis: their lengths add up.
    #[default]
    Coaxial,
    /// Side by side, joined by a belt or a spur gear: the longer one counts.
    SideBySide,
}

impl Arrangement {
    /// Both with the word that a requirement uses for them.
    pub const NAMES: &[(&str, Arrangement)] =
        &[("coaxial", Arrangement::Coaxial), ("side_by_side", Arrangement::SideBySide)];
}

/// What a spring parallel to the actuator may be: it pulls the joint towards its rest angle with
/// `k (q_0 − q)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Smallest and largest stiffness \[N·m/rad\], k.
    pub stiffness: [f64; 2],
    /// Smallest and largest rest angle \[rad\], q_0, on the scale of the motion's position where it is at the joint, of the actuator's
    /// where it is there.
    pub rest_angle: [f64; 2],
    /// On which side of a transmission it is.
    pub at: SpringAt,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            actuator_mass: None,
            outer_diameter: None,
            axial_length: None,
            arrangement: Arrangement::Coaxial,
            price: None,
            lead_time: None,
            reflected_inertia: None,
            torque_bandwidth: None,
            winding_temperature: None,
            shock_torque: None,
            life: None,
            max_backlash: None,
            min_stiffness: None,
            max_backdriving_torque: None,
            mount_resistance: None,
            safety: 1.0,
            reserves: Vec::new(),
            temperature_reserve: 0.0,
            spring: None,
        }
    }
}

/// A sinusoidal torque at the output on top of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueBandwidth {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Amplitude \[N·m\].
    pub amplitude: f64,
}

/// A torque on top of a motion, at the joint, as it arrives at the actuator.
#[derive(Debug, Clone, Copy)]
pub struct Ripple<'j> {
    /// Amplitude and frequency at the joint.
    pub bandwidth: TorqueBandwidth,
    /// What is between joint and actuator.
    pub passed: Option<&'j Passed>,
}

impl From<TorqueBandwidth> for Ripple<'_> {
    fn from(bandwidth: TorqueBandwidth) -> Self {
        Ripple { bandwidth, passed: None }
    }
}

impl Ripple<'_> {
    /// Torque \[N·m\] and its rate \[N·m/s\] at the actuator at sample k of its motion, with so much more at the joint.
    pub fn superposed(&self, motion: &Motion, k: usize, torque: f64, rate: f64) -> (f64, f64) {
        match self.passed {
            None => (motion.torque[k] + torque, motion.torque_rate[k] + rate),
            Some(passed) => {
                // What is in the actuator's motion beyond the joint's (a carried mass, a spring before the transmission) stays.
                let (plain, plain_rate) = passed.with_more(k, 0.0, 0.0);
                let (more, more_rate) = passed.with_more(k, torque, rate);
                (motion.torque[k] + more - plain, motion.torque_rate[k] + more_rate - plain_rate)
            }
        }
    }
}

/// Every limit of the model that a reserve may be kept of, by name; a test compares them with the model's own list.
pub const LIMIT_NAMES: &[&str] = &[
    "peak_current",
    "peak_torque",
    "continuous_current",
    "drive_continuous_current",
    "continuous_torque",
    "winding_temperature",
    "winding_peak_temperature",
    "standstill_holding",
    "torque_speed",
    "rated_torque",
    "overload",
    "supply_range",
    "voltage",
    "open_circuit_voltage",
    "max_speed",
    "gear_input_speed",
    "gear_peak_torque",
    "gear_continuous_torque",
    "gear_average_torque",
    "gear_momentary_torque",
    "gear_ratcheting_torque",
    "gear_average_speed",
    "gear_life",
    "gear_backlash",
    "gear_stiffness",
    "backdriving_torque",
    "transmission_torque",
    "transmission_force",
    "transmission_speed",
    "reflected_inertia",
    "torque_bandwidth_current",
    "torque_bandwidth_voltage",
    "bus_power",
    "bus_current",
    "regeneration",
    "bus_overvoltage",
    "actuator_mass",
    "outer_diameter",
    "axial_length",
    "price",
    "lead_time",
];

/// Reads `reserve`: shares of limits by their names; `all` is that of each that is not named.
fn read_reserves(section: &Section) -> Vec<(&'static str, f64)> {
    let about = "what of each limit is left, by its name; `all` for those that are not named";
    let Some(table) = section.section(key("reserve", about)) else { return Vec::new() };
    let share = |name: &'static str, about: &'static str| table.number(key(name, about).value("share"), Range::Share);
    let all = share("all", "of every limit that is not named").unwrap_or(0.0);
    let each = |name: &&'static str| (*name, share(name, "of this limit").unwrap_or(all));
    let found = LIMIT_NAMES.iter().map(each).filter(|(_, share)| *share > 0.0).collect();
    table.finish();
    found
}

/// Reads a `spring`.
pub(super) fn read_spring(section: Section) -> Option<Spring> {
    const STIFFNESS: &str = "[\"0 N*m/rad\", \"50 N*m/rad\"]";
    const REST_ANGLE: &str = "[\"-90 deg\", \"90 deg\"]";
    for (key, example) in [("stiffness", STIFFNESS), ("rest_angle", REST_ANGLE)] {
        if !section.has(key) {
            section.missing(key, example);
        }
    }
    let stiffness = section.quantity_range(key("stiffness", "k").required(), &units::STIFFNESS, Range::NonNegative);
    let rest_angle = section.quantity_range(
        key("rest_angle", "q_0 on the scale of the motion's position").required(),
        &units::ANGLE,
        Range::Any,
    );
    let within = |[least, most]: [f64; 2]| {
        section.at_most("rest_angle", Some(least), limits::REST_ANGLE, " rad")?;
        Some([least, section.at_most("rest_angle", Some(most), limits::REST_ANGLE, " rad")?])
    };
    let rest_angle = rest_angle.and_then(within);
    let about = "on which side of the `transmission` it pulls, and whose angles and stiffness are meant";
    let at = section.choice(key("at", about).default("`joint`"), SpringAt::NAMES).unwrap_or_default();
    section.finish();
    Some(Spring { stiffness: stiffness?, rest_angle: rest_angle?, at })
}

/// Reads how the parts lie to each other.
fn read_arrangement(section: &Section) -> Arrangement {
    let about = "one behind the other, whose lengths add up, or side by side, of which the longer one counts; for `axial_length`";
    let read = section.choice(key("arrangement", about).default("`coaxial`"), Arrangement::NAMES);
    if read.is_some() && !section.has("axial_length") {
        let message = "`arrangement` of [limits] is for `axial_length`, which is not asked for";
        let problem = Problem::at(section.span_of("arrangement"), message, "nothing to act on");
        section.note(problem.help("give axial_length = \"70 mm\" too, or remove it"));
    }
    read.unwrap_or_default()
}

/// Reads the life that a gear is to have, as L10.
fn read_life(section: &Section) -> Option<f64> {
    let about = "of the gear, in hours of this motion; its pauses count, and rest that follows it does not";
    let life = section.quantity(key("life", about), &units::TIME, Range::Positive);
    let about = "what `life` is: nine in ten gears last longer, or half of them";
    let quantile = section.choice(key("life_quantile", about).default("`L10`"), LifeQuantile::NAMES);
    if quantile.is_some() && !section.has("life") {
        section.missing("life", "\"10000 h\"");
    }
    life.map(|life| quantile.unwrap_or(LifeQuantile::L10).l10(life))
}

/// Reads `limits` of a joint; its spring apart.
pub(super) fn read(section: Section, ambient: f64, money: &Money) -> Limits {
    let bandwidth =
        section.section(key("torque_bandwidth", "a sinusoidal torque on top of the motion")).and_then(|table| {
            let frequency =
                table.required_quantity(key("frequency", "of the torque"), &units::FREQUENCY, Range::Positive);
            let amplitude = table.required_quantity(
                key("amplitude", "of the torque, at the output"),
                &units::TORQUE,
                Range::NonNegative,
            );
            table.finish();
            Some(TorqueBandwidth { frequency: frequency?, amplitude: amplitude? })
        });
    let life = read_life(&section);
    let limits = Limits {
        actuator_mass: section.quantity(
            key(
                "actuator_mass",
                "of motor and gear; like every limit here it has to be judged, or the motor is no choice",
            ),
            &units::MASS,
            Range::Positive,
        ),
        outer_diameter: section.quantity(
            key("outer_diameter", "of the largest of motor and gear; a module as printed, a box by its diagonal across the axis"),
            &units::LENGTH,
            Range::Positive,
        ),
        axial_length: section.quantity(
            key("axial_length", "of motor and gear together; a module as printed"),
            &units::LENGTH,
            Range::Positive,
        ),
        arrangement: read_arrangement(&section),
        price: prices::read_amount(
            &section,
            key("price", "of motor and gear together, or of a module; needs [prices]"),
            Range::Positive,
            money,
        ),
        lead_time: section.quantity(
            key("lead_time", "the longest of motor and gear, or of a module"),
            &units::TIME,
            Range::Positive,
        ),
        reflected_inertia: section.quantity(
            key("reflected_inertia", "N² (J_m + J_g) at the output; through a `transmission` at the joint"),
            &units::INERTIA,
            Range::Positive,
        ),
        torque_bandwidth: bandwidth,
        winding_temperature: section.quantity(
            key("winding_temperature", "highest; the motor's own holds too"),
            &units::TEMPERATURE,
            Range::Positive,
        ),
        shock_torque: section.quantity(
            key(
                "shock_torque",
                "of a few shocks in a life, at the output; the gear's momentary peak and ratcheting torque are compared with it",
            ),
            &units::TORQUE,
            Range::Positive,
        ),
        life,
        max_backlash: section.quantity(
            key("max_backlash", "largest of the gear, at the output"),
            &units::ANGLE,
            Range::Positive,
        ),
        min_stiffness: section.quantity(
            key("min_stiffness", "smallest of the gear, torsional, at the output"),
            &units::STIFFNESS,
            Range::Positive,
        ),
        max_backdriving_torque: section.quantity(
            key("max_backdriving_torque", "largest that sets the actuator going without current, at the output"),
            &units::TORQUE,
            Range::Positive,
        ),
        mount_resistance: None,
        safety: section
            .number(key("safety", "factor on demanded torque and current, not on heat").default("1"), Range::AtLeastOne)
            .unwrap_or(1.0),
        reserves: read_reserves(&section),
        temperature_reserve: 0.0,
        spring: None,
    };
    if limits.winding_temperature.is_some_and(|t| t <= ambient) {
        section.note(Problem::at(
            section.span_of("winding_temperature"),
            "the winding may not even be as warm as its surroundings",
            format!("expected more than the ambient temperature, {} degC", crate::words::number(ambient - 273.15)),
        ));
    }
    section.finish();
    limits
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::input::{Form, Source};

    #[test]
    fn a_rest_angle_beyond_some_turns_is_a_slip() {
        let read = |least: &str, most: &str| {
            let text = format!(
                "spring = {{ stiffness = [\"0 N*m/rad\", \"50 N*m/rad\"], rest_angle = [\"{least}\", \"{most}\"] }}\n"
            );
            let source = Arc::new(Source::new("r.toml", text.clone()));
            let read = Form::read(&source, |root| read_spring(root.section(key("spring", "a spring"))?));
            read.map_err(|error| {
                error.problems.into_iter().map(|p| text[p.span.unwrap()].to_string()).collect::<Vec<_>>()
            })
        };
        assert_eq!(read("-100 rad", "100 rad").unwrap().rest_angle, [-100.0, 100.0]);
        for (least, most) in [("1e17 deg", "1e17 deg"), ("-101 rad", "0 rad"), ("0 rad", "1e5 rad")] {
            assert_eq!(read(least, most).unwrap_err(), [format!("[\"{least}\", \"{most}\"]")]);
        }
    }
}
