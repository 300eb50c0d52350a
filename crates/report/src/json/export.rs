//! `export --to json`.

use std::collections::BTreeMap;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{NotChecked, not_checked};
use super::{Named, document};
use crate::export::{Exported, Origin};
use gearwise_model::catalog::Provenance;
use gearwise_select::simulated::spread::Ranged;
use gearwise_select::simulated::{Bound, Cog, Line};

/// What `export --to json` writes: what a simulator is told, SI.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// Version of the program.
    pub gearwise: &'static str,
    /// The robot.
    pub robot: Named<'a>,
    /// File name of the requirement.
    pub requirement: &'a str,
    /// SHA-256 of its text.
    pub requirement_sha256: &'a str,
    /// File name of the design, where there is one.
    pub design: Option<&'a str>,
    /// SHA-256 of its text.
    pub design_sha256: Option<&'a str>,
    /// The joints.
    pub joints: Vec<OfJoint<'a>>,
}

/// A joint of a simulator.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// Id of the motor.
    pub motor: &'a str,
    /// Where the motor's numbers come from.
    pub motor_source: &'a str,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Ratio N.
    pub ratio: f64,
    /// Whether every limit that could be checked is kept.
    pub feasible: bool,
    /// Limits that are broken.
    pub broken: &'a [&'static str],
    /// Limits that could not be checked.
    pub unchecked: &'a [&'static str],
    /// Whether every limit that the requirement states could be judged.
    pub judged: bool,
    /// What the requirement states and cannot be judged.
    pub unjudged: Vec<NotChecked<'a>>,
    /// Inertia of the rotor, at the motor; `null` for a module that does not say its own.
    pub rotor_inertia_kgm2: Option<f64>,
    /// Inertia of the gear, at the motor; likewise.
    pub gear_inertia_kgm2: Option<f64>,
    /// Both at the joint: what simulators call armature; likewise.
    pub armature_kgm2: Option<f64>,
    /// Viscous friction at the joint; `null` where it is not known.
    pub damping_nms_per_rad: Option<f64>,
    /// Coulomb friction at the joint; `null` where it is not known.
    pub friction_loss_nm: Option<f64>,
    /// Largest torque at the joint.
    pub effort_nm: Option<f64>,
    /// Whose limit that is.
    pub effort_by: Option<&'static str>,
    /// Largest continuous torque at the joint.
    pub continuous_effort_nm: Option<f64>,
    /// Whose limit that is.
    pub continuous_effort_by: Option<&'static str>,
    /// Largest torque of the motor.
    pub motor_torque_nm: Option<f64>,
    /// K_T, q axis; `null` for a module that says ratings alone.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Largest speed of the joint.
    pub velocity_rad_per_s: f64,
    /// Whose limit that is.
    pub velocity_by: &'static str,
    /// Largest speed at the largest torque.
    pub velocity_at_effort_rad_per_s: Option<f64>,
    /// Efficiency of the gear while it drives; `null` for a module whose row does not say it.
    pub gear_efficiency: Option<f64>,
    /// Efficiency of the gear while it is driven; likewise.
    pub gear_backdrive_efficiency: Option<f64>,
    /// Whether the largest torque is a module's rating at its flange, with its gear's loss in it.
    pub effort_is_behind_loss: bool,
    /// Of a transmission whose ratio goes with the angle: joint angle in rad, turns of the motor for one of the joint, largest torque
    /// at the joint in N·m; empty for others.
    pub over_angle_rad_ratio_nm: &'a [[f64; 3]],
    /// What friction has more at rest than while it moves, at the joint; `null` where it is not known.
    pub friction_at_rest_nm: Option<f64>,
    /// Largest torque at the joint whatever the voltage: while the load drives, the back-EMF helps.
    pub braking_effort_nm: Option<f64>,
    /// Whose limit that is.
    pub braking_effort_by: Option<&'static str>,
    /// Largest speed of the joint that motor, gear and transmission allow whatever the voltage.
    pub mechanical_velocity_rad_per_s: Option<f64>,
    /// Whose limit that is.
    pub mechanical_velocity_by: Option<&'static str>,
    /// Torque over speed as simulators draw it; `null` where it is not known.
    pub line: Option<TorqueSpeed>,
    /// The highest line that promises nothing too much.
    pub line_below: Option<TorqueSpeed>,
    /// Elasticity of the gear; `null` where it is not known.
    pub gear_stiffness_nm_per_rad: Option<f64>,
    /// Play of the gear from stop to stop; `null` where it is not known.
    pub backlash_rad: Option<f64>,
    /// Cogging of the motor, the largest order first.
    pub cogging: Vec<Cogging>,
    /// L/R; `null` where the inductance is not known.
    pub electrical_time_constant_s: Option<f64>,
    /// How the winding heats; `null` where that is not known.
    pub heat: Option<Heat>,
    /// Ranges of 95 %, with `--ranges` or `--draws`; empty where nothing has a ±.
    pub ranges: Vec<Range<'a>>,
    /// Draws of all numbers together, with `--draws`: the names are those of the ranges.
    pub draws: Vec<BTreeMap<&'static str, f64>>,
    /// Whether the numbers were fitted together, so that draws keep their covariance; `null` where neither was asked for.
    pub draws_are_correlated: Option<bool>,
    /// The logs that the motor was fitted from; `null` for a catalogue row.
    pub fitted_from: Option<Vec<Fit<'a>>>,
    /// What a simulator cannot be told.
    pub left_out: Vec<LeftOut<'a>>,
}

/// The line `min(e, s (1 − ω/ω₀))` by which simulators let torque fall with speed, at the joint, before the gear's loss.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct TorqueSpeed {
    /// Largest torque e.
    pub effort_nm: f64,
    /// Torque of the line at standstill, s.
    pub stall_nm: f64,
    /// Speed up to which e can be had.
    pub corner_rad_per_s: f64,
    /// Speed without load ω₀.
    pub no_load_rad_per_s: f64,
    /// What the line promises at most beyond the motor.
    pub excess_nm: f64,
    /// At which speed.
    pub excess_at_rad_per_s: f64,
    /// What the line has at most less than the motor.
    pub shortfall_nm: f64,
    /// At which speed.
    pub shortfall_at_rad_per_s: f64,
    /// Whether the speed up to which e can be had is not known: then the line falls from standstill on.
    pub assumed: bool,
}

/// Cogging of one order: `amplitude sin(order θ + phase)` pulls at the rotor at its angle θ.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Cogging {
    /// Periods a revolution of the rotor.
    pub order: f64,
    /// Amplitude at the motor.
    pub amplitude_nm: f64,
    /// Phase.
    pub phase_rad: f64,
}

/// How a winding heats.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Heat {
    /// Thermal resistance from winding to ambient.
    pub resistance_k_per_w: f64,
    /// Time constant of the housing; `null` where the row says none.
    pub time_constant_s: Option<f64>,
    /// Ambient temperature.
    pub ambient_k: f64,
}

/// A range of 95 %.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Range<'a> {
    /// Which number, SI: `armature`, `damping`, `friction_loss`, `effort`, `saturation_effort`, `no_load_speed`, `torque_constant`.
    pub name: &'static str,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Numbers whose ± it comes from, the largest share first.
    pub from: &'a [String],
}

/// A log that a motor was fitted from.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Fit<'a> {
    /// The log.
    pub log: &'a str,
    /// SHA-256 of the file.
    pub sha256: Option<&'a str>,
    /// `fit` or `held_out`.
    #[serde(rename = "use")]
    pub usage: Option<&'a str>,
}

/// What a simulator cannot be told.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct LeftOut<'a> {
    /// What.
    pub what: &'a str,
    /// Why.
    pub why: &'a str,
}

/// Designs handed over to a simulator.
pub fn json(origin: &Origin, joints: &[Exported]) -> Value {
    document(
        "export",
        Answer {
            gearwise: env!("CARGO_PKG_VERSION"),
            robot: Named::new(origin.robot.as_str(), &origin.set),
            requirement: &origin.requirement.name,
            requirement_sha256: &origin.requirement.sha256,
            design: origin.design.as_ref().map(|d| d.name.as_str()),
            design_sha256: origin.design.as_ref().map(|d| d.sha256.as_str()),
            joints: joints.iter().map(OfJoint::new).collect(),
        },
    )
}

impl TorqueSpeed {
    fn new(line: Line) -> TorqueSpeed {
        TorqueSpeed {
            effort_nm: line.effort,
            stall_nm: line.stall,
            corner_rad_per_s: line.corner,
            no_load_rad_per_s: line.no_load,
            excess_nm: line.excess.1,
            excess_at_rad_per_s: line.excess.0,
            shortfall_nm: line.shortfall.1,
            shortfall_at_rad_per_s: line.shortfall.0,
            assumed: line.is_assumed,
        }
    }
}

impl<'a> Range<'a> {
    fn new(range: &'a Ranged) -> Range<'a> {
        Range { name: range.name, low: range.low, high: range.high, from: &range.from }
    }
}

impl<'a> OfJoint<'a> {
    fn new(e: &'a Exported) -> OfJoint<'a> {
        let s = &e.simulated;
        let bound = |b: Option<Bound>| (b.map(|b| b.value), b.map(|b| b.owner));
        let (effort_nm, effort_by) = bound(s.effort());
        let (continuous_effort_nm, continuous_effort_by) = bound(s.continuous_effort());
        let (braking_effort_nm, braking_effort_by) = bound(s.braking_effort());
        let cogging = |cog: &Cog| Cogging { order: cog.order, amplitude_nm: cog.amplitude, phase_rad: cog.phase };
        let log =
            |log: &'a Provenance| Fit { log: &log.log, sha256: log.sha256.as_deref(), usage: log.usage.as_deref() };
        OfJoint {
            joint: e.joint,
            motor: &e.motor.id,
            motor_source: &e.motor.source,
            gear: e.gear.map(|g| g.id.as_str()),
            ratio: s.ratio,
            feasible: e.broken.is_empty(),
            broken: &e.broken,
            unchecked: &e.unchecked,
            judged: e.unjudged.is_empty(),
            unjudged: not_checked(&e.unjudged),
            rotor_inertia_kgm2: s.inertias.map(|(rotor, _)| rotor),
            gear_inertia_kgm2: s.inertias.map(|(_, gear)| gear),
            armature_kgm2: s.armature,
            damping_nms_per_rad: s.damping,
            friction_loss_nm: s.friction_loss,
            effort_nm,
            effort_by,
            continuous_effort_nm,
            continuous_effort_by,
            motor_torque_nm: s.motor_torque.map(|b| b.value),
            torque_constant_nm_per_a: s.torque_constant,
            velocity_rad_per_s: s.speed.value,
            velocity_by: s.speed.owner,
            velocity_at_effort_rad_per_s: s.speed_at_motor_torque,
            gear_efficiency: s.efficiencies.map(|(efficiency, _)| efficiency),
            gear_backdrive_efficiency: s.efficiencies.map(|(_, backwards)| backwards),
            effort_is_behind_loss: s.is_behind_loss,
            over_angle_rad_ratio_nm: &s.over_angle,
            friction_at_rest_nm: s.friction_at_rest,
            braking_effort_nm,
            braking_effort_by,
            mechanical_velocity_rad_per_s: s.mechanical_speed.map(|b| b.value),
            mechanical_velocity_by: s.mechanical_speed.map(|b| b.owner),
            line: s.line.map(TorqueSpeed::new),
            line_below: s.line_below.map(TorqueSpeed::new),
            gear_stiffness_nm_per_rad: s.stiffness,
            backlash_rad: s.backlash,
            cogging: s.cogging.iter().map(cogging).collect(),
            electrical_time_constant_s: s.winding.and_then(|w| w.time_constant),
            heat: s.heat.map(|heat| Heat {
                resistance_k_per_w: heat.resistance,
                time_constant_s: heat.time_constant,
                ambient_k: heat.ambient,
            }),
            ranges: e.spread.iter().flat_map(|spread| &spread.ranges).map(Range::new).collect(),
            draws: e.spread.iter().flat_map(|spread| &spread.draws).map(|d| d.iter().copied().collect()).collect(),
            draws_are_correlated: e.spread.as_ref().map(|spread| spread.is_correlated),
            fitted_from: e.motor.fit.as_ref().map(|fit| fit.provenance.iter().map(log).collect()),
            left_out: s.left_out.iter().map(|l| LeftOut { what: &l.what, why: &l.why }).collect(),
        }
    }
}
