//! What actuators can do, as arrays over motor and ratio, without a motion: for loops in which the motion is still sought.
//!
//! Torques are those at the joint, behind the gear's loss while the motor drives, before it while the load drives. Friction, and what
//! the rotor takes for its own acceleration, is not in them: they are figures of their own.

use rayon::prelude::*;

use super::rows::Rows;
use super::{Failure, chosen, evaluate, settled};
use crate::catalog::Motor;
use crate::design::simulated::{Figures, SimulatedJoint};
use crate::design::{JointDemand, Mount};
use crate::requirement::{RatioChoice, Robot};

/// Actuators as arrays over (motor, ratio), the ratio fastest. SI, at the joint. What is not known is NaN.
#[derive(Debug, Clone, Default)]
pub struct ActuatorMap {
    /// Ids of the motors.
    pub motors: Vec<String>,
    /// Ratios, N.
    pub ratio: Vec<f64>,
    /// Motors of which nothing can be worked out, with the reason.
    pub unusable: Vec<(String, String)>,
    /// The figures of each; `None` of a motor that cannot be worked out.
    pub figures: Vec<Option<Figures>>,
    /// Torque while the motor drives over (motor, ratio, speed) \[N·m\]; empty where no speeds were asked for.
    pub driving: Vec<f64>,
    /// Torque while the load drives \[N·m\], likewise.
    pub braking: Vec<f64>,
}

/// The figures of motors (`None` for all) at ratios, with the bus, the surroundings and the gear of the one joint of a robot,
/// whose motion does not matter; at speeds of the joint \[rad/s\] too, where some are given.
///
/// # Errors
/// Motors that are not there, ratios that are none, a joint that takes gears of the catalogue.
pub fn actuator_map(
    robot: &Robot,
    rows: &Rows,
    motors: Option<&[String]>,
    ratios: &[f64],
    speeds: &[f64],
) -> Result<ActuatorMap, Failure> {
    evaluate::check_ratios(ratios)?;
    if let Some(wrong) = speeds.iter().find(|speed| !speed.is_finite()) {
        return Err(Failure::Argument(format!("{wrong} is not a speed")));
    }
    let catalog = rows.for_motors(robot, motors)?;
    let robot = settled(robot.clone(), &catalog)?;
    let joint = chosen::joint(&robot, None)?;
    if matches!(joint.ratio, RatioChoice::Catalog { .. }) {
        return Err(Failure::Argument("the ratios of gears of the catalogue are theirs".into()));
    }
    let found = evaluate::motors(&catalog, motors, joint)?;
    let demand = JointDemand::new(joint, &catalog);
    let of_motor = |motor: &&Motor| {
        let candidate =
            Mount::new(&robot, joint, &demand.load, motor).candidate().map_err(|why| why.reason().to_string())?;
        let fixed = candidate.catalog_gear.map(|gear| gear.ratio);
        let one = |ratio: &f64| {
            // A module has the ratio of its gear alone.
            if fixed.is_some_and(|own| (ratio / own - 1.0).abs() > 1e-9) {
                return (None, vec![(f64::NAN, f64::NAN); speeds.len()]);
            }
            let curve = speeds.iter().map(|speed| SimulatedJoint::torque_at(&candidate, *ratio, *speed)).collect();
            (Some(SimulatedJoint::figures(&candidate, *ratio)), curve)
        };
        Ok(ratios.iter().map(one).collect::<Vec<_>>())
    };
    let all: Vec<Result<Vec<_>, String>> = match found.len() {
        1 => found.iter().map(of_motor).collect(),
        _ => found.par_iter().map(of_motor).collect(),
    };
    let mut map = ActuatorMap { ratio: ratios.to_vec(), ..ActuatorMap::default() };
    for (motor, row) in found.iter().zip(all) {
        map.motors.push(motor.id.clone());
        let nothing = || ratios.iter().map(|_| (None, vec![(f64::NAN, f64::NAN); speeds.len()])).collect();
        let row = row.unwrap_or_else(|why| {
            map.unusable.push((motor.id.clone(), why));
            nothing()
        });
        for (figures, curve) in row {
            map.figures.push(figures);
            map.driving.extend(curve.iter().map(|(driving, _)| driving));
            map.braking.extend(curve.iter().map(|(_, braking)| braking));
        }
    }
    Ok(map)
}
