//! `export --to json`.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{NotChecked, not_checked};
use super::{Named, document};
use crate::catalog::Provenance;
use crate::design::simulated::Bound;
use crate::report::export::{Exported, Origin};

/// What `export --to json` writes: what a simulator is told, SI.
#[derive(Debug, Serialize, JsonSchema)]
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
#[derive(Debug, Serialize, JsonSchema)]
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
    /// The logs that the motor was fitted from; `null` for a catalogue row.
    pub fitted_from: Option<Vec<Fit<'a>>>,
    /// What a simulator cannot be told.
    pub left_out: Vec<LeftOut<'a>>,
}

/// A log that a motor was fitted from.
#[derive(Debug, Serialize, JsonSchema)]
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
#[derive(Debug, Serialize, JsonSchema)]
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

impl<'a> OfJoint<'a> {
    fn new(e: &'a Exported) -> OfJoint<'a> {
        let s = &e.simulated;
        let bound = |b: Option<Bound>| (b.map(|b| b.value), b.map(|b| b.owner));
        let (effort_nm, effort_by) = bound(s.effort());
        let (continuous_effort_nm, continuous_effort_by) = bound(s.continuous_effort());
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
            fitted_from: e.motor.fit.as_ref().map(|fit| fit.provenance.iter().map(log).collect()),
            left_out: s.left_out.iter().map(|l| LeftOut { what: &l.what, why: &l.why }).collect(),
        }
    }
}
