//! The equations of a motor with the numbers of a gear: for a gear that is described, at one ratio of a family or within a
//! piece of it.

use super::candidate::{Candidate, MapPart, hottest};
use super::load::Load;
use super::shaft::Actuator;
use super::thermal::resistance_factor;
use crate::catalog::Motor;
use crate::catalog::drag::Friction;
use crate::requirement::{GearModel, GearPiece, Joint, MotorDrag, Robot};

/// The equations of a motor with a gear that the requirement describes, without drag and drive.
pub fn described(motor: &Motor, joint: &Joint, rotor_inertia: f64, gear: &GearModel) -> Actuator {
    let hottest = hottest(motor, joint).0;
    let actuator = Actuator::at_temperature(motor, rotor_inertia, gear, Some(hottest), true);
    actuator.with_winding_at(hottest, motor.reference_temperature)
}

/// The same with the gear's torque without load, the drive's resistance and the motor's drag: at each end of what is known of
/// that.
pub fn complete(
    actuator: Actuator,
    robot: &Robot,
    joint: &Joint,
    motor: &Motor,
    gear: &GearModel,
) -> (Actuator, Option<Actuator>) {
    let drive = joint.drive.or(robot.bus.drive);
    let coldest = motor.resistance * resistance_factor(robot.ambient, motor.reference_temperature);
    let actuator = actuator
        .with_gear_friction(gear.no_load)
        .with_drive_resistance(drive.phase_resistance.unwrap_or(0.0))
        .with_coldest_winding(coldest);
    let (first, second) = match joint.motor_drag {
        MotorDrag::Counted => motor.drag().ends(),
        MotorDrag::Off => (Friction::default(), None),
    };
    (actuator.with_friction(first), second.map(|friction| actuator.with_friction(friction)))
}

impl<'a> Candidate<'a> {
    /// The same motor with another gear.
    pub fn with_gear(&self, gear: GearModel, map: Option<MapPart<'a>>) -> Candidate<'a> {
        let Candidate { robot, joint, motor, .. } = *self;
        let own = described(motor, joint, motor.rotor_inertia.unwrap_or(0.0), &gear);
        let (actuator, other) = complete(own, robot, joint, motor, &gear);
        Candidate { gear, actuator, other, map, ..*self }
    }

    /// The same motor within a piece of a family of gears: `load` has to be the joint's [on that piece](Load::on_piece). Its
    /// limits that go with the ratio (torque, speed and mass of the gear, inertia) are not among those of this candidate.
    pub fn on_piece<'p>(&self, piece: &'p GearPiece, load: &'p Load) -> Candidate<'p>
    where
        'a: 'p,
    {
        let base = &self.gear;
        let mass = piece.mass();
        // What the efficiency does to the load, and inertia and torque that fall with the ratio, are in the load.
        let gear = GearModel {
            efficiency: 1.0,
            backdrive_efficiency: 1.0,
            inertia: piece.inertia(base).constant,
            mass: mass.map_or(base.mass, |mass| Some(mass.constant)),
            no_load: Friction { coulomb: piece.no_load(base).constant, ..base.no_load },
            ..*base
        };
        let here: Candidate<'p> = Candidate { load, ..*self };
        let mut here = here.with_gear(gear, Some(MapPart::Piece(piece)));
        if piece.load(base).iter().any(|line| line.per_power != 0.0) {
            here.actuator = here.actuator.with_rising_load();
            here.other = here.other.map(Actuator::with_rising_load);
        }
        here
    }
}
