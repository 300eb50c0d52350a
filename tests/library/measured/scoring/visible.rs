//! Which effects a bench can show: this file's own table, from the equations alone.
//!
//! An effect is visible where the bench measures its equation, has every channel that it is a function of, and that
//! function is not made of the response itself.

use crate::simulator::{Effect, Kind};

/// Why an effect cannot be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hidden {
    /// It is a term of an equation that this bench does not measure.
    Elsewhere,
    /// What it is a function of is not measured, or does not vary.
    Lacks,
    /// The bench has something that looks the same: a free zero, the back-EMF, a measured supply.
    Bench,
    /// Its function is made of the response.
    Response,
}

/// What a bench has beyond its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Has {
    /// Positions of motor and output.
    pub both_sides: bool,
    /// The voltage of the supply.
    pub supply: bool,
}

/// Whether a bench can show an effect.
pub fn visible(effect: Effect, kind: Kind, has: Has) -> Result<(), Hidden> {
    use Effect::{
        Backlash, Cogging, CoulombFriction, DirectionAsymmetry, EddyDrag, GearCompliance, GearRipple, Gravity,
        InverterDeadTime, LoadDependentFriction, StribeckFriction, SupplySag, TorqueConstantSaturation,
        TorqueConstantTemperature, TorqueOffset, TorqueRipple, ViscousFriction, WindingTemperature,
    };
    let speed = matches!(
        effect,
        ViscousFriction | CoulombFriction | StribeckFriction | DirectionAsymmetry | EddyDrag | LoadDependentFriction
    );
    let angle = matches!(effect, Cogging { .. } | TorqueRipple { .. } | GearRipple { .. });
    let current = matches!(effect, TorqueConstantSaturation | TorqueConstantTemperature | TorqueRipple { .. });
    // The angle between motor and output: a bench of its own, where both are measured and a torque is known.
    if matches!(effect, GearCompliance | Backlash) {
        let loaded = matches!(kind, Kind::Dynamometer | Kind::Free | Kind::Drag | Kind::RandomTorque);
        return if loaded && has.both_sides { Ok(()) } else { Err(Hidden::Lacks) };
    }
    let voltage = matches!(effect, WindingTemperature | InverterDeadTime | SupplySag);
    match kind {
        // Torque at the output = N (K_T i − J α − drag) + zero.
        Kind::Dynamometer if voltage => Err(Hidden::Elsewhere),
        Kind::Dynamometer if matches!(effect, Gravity | TorqueOffset) => Err(Hidden::Bench),
        Kind::Dynamometer => Ok(()),
        // The same without current: nothing that needs one, and no load but the actuator's own.
        Kind::Drag | Kind::RandomTorque if voltage => Err(Hidden::Elsewhere),
        Kind::Drag | Kind::RandomTorque if matches!(effect, Gravity | TorqueOffset) => Err(Hidden::Bench),
        Kind::Drag | Kind::RandomTorque if current || effect == LoadDependentFriction => Err(Hidden::Lacks),
        Kind::Drag | Kind::RandomTorque => Ok(()),
        // The same at rest.
        Kind::Stall if voltage => Err(Hidden::Elsewhere),
        Kind::Stall if matches!(effect, Gravity | TorqueOffset) => Err(Hidden::Bench),
        Kind::Stall if speed || angle => Err(Hidden::Lacks),
        Kind::Stall => Ok(()),
        // N K_T i = (N² J + J_load) α/N + drag: the current is the response.
        Kind::Free if voltage => Err(Hidden::Elsewhere),
        Kind::Free if current => Err(Hidden::Response),
        Kind::Free => Ok(()),
        // Voltage = R i + L di/dt + K_B ω.
        Kind::Electrical if effect == SupplySag => Err(Hidden::Bench),
        Kind::Electrical if voltage => Ok(()),
        Kind::Electrical => Err(Hidden::Elsewhere),
        // Position of the output, driven by duty: no current, no temperature, and the friction that is proportional to
        // speed is in one damping with the back-EMF.
        Kind::Servo if effect == ViscousFriction => Err(Hidden::Bench),
        Kind::Servo if effect == SupplySag && has.supply => Err(Hidden::Bench),
        Kind::Servo if angle || current || effect == WindingTemperature => Err(Hidden::Lacks),
        Kind::Servo => Ok(()),
        other => panic!("{other:?} is not scored"),
    }
}

/// Whether an effect contributes to the target of a bench at all, seen or not: otherwise it has no size in noise there.
pub fn contributes(effect: Effect, kind: Kind) -> bool {
    use Effect::{
        Backlash, GearCompliance, Gravity, InverterDeadTime, SupplySag, TorqueConstantSaturation,
        TorqueConstantTemperature, TorqueOffset, TorqueRipple, WindingTemperature,
    };
    let two_masses = matches!(effect, GearCompliance | Backlash);
    let voltage = matches!(effect, WindingTemperature | InverterDeadTime | SupplySag);
    let current = matches!(effect, TorqueConstantSaturation | TorqueConstantTemperature | TorqueRipple { .. });
    match kind {
        Kind::Dynamometer => !two_masses && !voltage,
        Kind::Drag | Kind::RandomTorque => !two_masses && !voltage && !current,
        Kind::Stall => {
            matches!(effect, TorqueConstantSaturation | TorqueConstantTemperature | TorqueOffset | Gravity)
        }
        Kind::Free => !voltage,
        Kind::Electrical => matches!(effect, WindingTemperature | InverterDeadTime),
        Kind::Servo => !two_masses && !matches!(effect, WindingTemperature | TorqueConstantTemperature),
        other => panic!("{other:?} is not scored"),
    }
}
