//! From a requirement and a catalogue to a choice.
//!
//! The one idea of this room: a motor with a gear becomes a [`Candidate`] whose limits are gathered
//! once ([`Prepared`]); a [`mod@sweep`] evaluates it at given ratios, the [ratio program](program) finds
//! the best ratio and proves it, [`mod@optimize`] ranks all motors. All three read the same limits.

pub mod agreement;
pub mod evaluate;
pub mod examine;
pub mod explain;
pub mod judge;
pub mod optimize;
pub mod pareto;
pub mod program;
pub mod prune;
pub mod remake;
pub mod robot;
pub mod robust;
pub mod simulated;
pub mod spring;
pub mod sweep;

pub use crate::actuator::limits::Candidate;
pub use evaluate::{Evaluation, Margin, Prepared};
pub use optimize::optimize;
pub use sweep::sweep;

use crate::actuator::fitted::gear_with_fit;
use crate::actuator::limits::{hot_winding, hottest};
use crate::actuator::{Actuator, Load};
use crate::catalog::{Catalog, Gear, Motor, matches_pattern};
use crate::requirement::{EfficiencyCovers, GearModel, Joint, RatioChoice, Robot, backdrive_efficiency};

/// Why a motor, or a motor with a gear, is not a candidate at all.
#[derive(Debug, Clone, PartialEq)]
pub enum Unusable {
    /// The rotor inertia is not known: neither metric nor acceleration torque can be computed.
    RotorInertia,
    /// No gear of the catalogue that the joint allows fits the motor.
    NoGearFits,
    /// The gear's efficiency is not known.
    GearEfficiency,
    /// The objective needs a mass that is not known.
    Mass,
    /// Energy per cycle needs durations.
    Durations,
}

impl Unusable {
    /// In words.
    pub fn reason(&self) -> &'static str {
        match self {
            Unusable::RotorInertia => "its rotor inertia is not known",
            Unusable::NoGearFits => "no allowed gear of the catalogue fits it",
            Unusable::GearEfficiency => "the gear's efficiency is not known",
            Unusable::Mass => "the objective needs a mass that is not known",
            Unusable::Durations => "energy needs operating points with durations",
        }
    }
}

/// What a joint asks, made ready once for all motors: its load, and the gears it allows, each with the
/// load as that gear passes it on.
#[derive(Debug)]
pub struct JointDemand<'a> {
    /// The load at the joint.
    pub load: Load,
    /// The gears of the catalogue that the joint allows, in the order of their ids; a load of its own
    /// where the gear's efficiency covers its inertia.
    gears: Vec<(&'a Gear, Option<Load>)>,
}

impl<'a> JointDemand<'a> {
    /// Prepares a joint.
    pub fn new(joint: &Joint, catalog: &'a Catalog) -> JointDemand<'a> {
        let gears = match &joint.ratio {
            RatioChoice::Continuous { .. } => Vec::new(),
            RatioChoice::Catalog { patterns, .. } => {
                catalog.gears.iter().filter(|g| patterns.iter().any(|p| matches_pattern(p, &g.id))).collect()
            }
        };
        let gears = gears.into_iter().map(|gear| (gear, load_through(joint, gear))).collect();
        JointDemand { load: Load::new(&joint.motion, joint.limits.torque_bandwidth), gears }
    }

    /// The gears that may be mounted on a motor, each with its load.
    pub fn gears_for<'d>(&'d self, motor: &'d Motor) -> impl Iterator<Item = (&'a Gear, &'d Load)> + use<'a, 'd> {
        let fitting = self.gears.iter().filter(|(gear, _)| gear.fits(&motor.id) != Some(false));
        fitting.map(|(gear, own)| (*gear, own.as_ref().unwrap_or(&self.load)))
    }
}

/// The load as a gear passes it on, where that is another than the joint's: with the torque that
/// accelerates the gear's inertia, where its efficiency covers that too.
pub fn load_through(joint: &Joint, gear: &Gear) -> Option<Load> {
    let inertia = gear.inertia.filter(|_| covers_gear(joint))?;
    Some(Load::with_inertia(&joint.motion, joint.limits.torque_bandwidth, inertia * gear.ratio * gear.ratio))
}

fn covers_gear(joint: &Joint) -> bool {
    matches!(joint.ratio, RatioChoice::Catalog { efficiency_covers: EfficiencyCovers::LoadAndGear, .. })
}

/// The actuator with the resistance of the hottest winding that may be in its voltage and power, where that is known.
fn with_hot_winding(actuator: Actuator, robot: &Robot, joint: &Joint, motor: &Motor) -> Actuator {
    match hot_winding(motor, joint, robot.ambient) {
        Some(kelvin) => actuator.with_winding_at(kelvin, motor.reference_temperature),
        None => actuator,
    }
}

/// A candidate with a continuous ratio.
pub fn continuous_candidate<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    load: &'a Load,
    motor: &'a Motor,
) -> Result<Candidate<'a>, Unusable> {
    let rotor = motor.rotor_inertia.ok_or(Unusable::RotorInertia)?;
    let gear = gear_with_fit(motor, &joint.gear);
    let actuator = Actuator::at_temperature(motor, rotor, &gear, hottest(motor, joint).map(|t| t.0), true);
    let actuator = with_hot_winding(actuator, robot, joint, motor);
    Ok(Candidate { robot, joint, load, motor, catalog_gear: None, gear, actuator, folded: false })
}

/// A candidate with a gear of the catalogue; `load` as the gear passes it on.
pub fn geared_candidate<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    load: &'a Load,
    motor: &'a Motor,
    gear: &'a Gear,
) -> Result<Candidate<'a>, Unusable> {
    let rotor = motor.rotor_inertia.ok_or(Unusable::RotorInertia)?;
    let efficiency = gear.efficiency.ok_or(Unusable::GearEfficiency)?;
    let model = GearModel {
        efficiency,
        backdrive_efficiency: gear.backdrive_efficiency.unwrap_or_else(|| backdrive_efficiency(efficiency)),
        mass: gear.mass,
        mass_per_stage: None,
        inertia: gear.inertia.unwrap_or(0.0),
        peak_torque: gear.peak_torque,
        continuous_torque: gear.continuous_torque,
        max_input_speed: gear.max_input_speed,
    };
    // Where the efficiency covers the gear's inertia, the load has it already.
    let at_the_shaft = GearModel { inertia: if covers_gear(joint) { 0.0 } else { model.inertia }, ..model };
    let hottest = hottest(motor, joint).map(|t| t.0);
    let actuator = Actuator::at_temperature(motor, rotor, &at_the_shaft, hottest, false);
    let mut actuator = with_hot_winding(actuator, robot, joint, motor);
    actuator.inertia = rotor + model.inertia;
    Ok(Candidate { robot, joint, load, motor, catalog_gear: Some(gear), gear: model, actuator, folded: false })
}

/// Every gear pattern of a robot must name a gear of the catalogue.
///
/// # Errors
/// The pattern that names none, in words.
pub fn check_gears(robot: &Robot, catalog: &Catalog) -> Result<(), String> {
    for joint in &robot.joints {
        let RatioChoice::Catalog { patterns, .. } = &joint.ratio else { continue };
        for pattern in patterns {
            if catalog.gears.iter().any(|g| matches_pattern(pattern, &g.id)) {
                continue;
            }
            let kinds = ["planetary-*", "strain-wave-*", "cycloidal-*", "belt-*"];
            let ids = catalog.gears.iter().map(|g| g.id.as_str()).chain(kinds);
            let help = match crate::words::nearest(pattern, ids) {
                _ if catalog.gears.is_empty() => "it has no gears at all; add a gear file to `--catalog`".to_string(),
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("ids begin with the kind, as in {}", kinds.join(", ")),
            };
            let message = format!("joint `{}`: no gear of the catalogue matches `{pattern}`; {help}", joint.name);
            return Err(message);
        }
    }
    Ok(())
}
