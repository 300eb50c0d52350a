//! A design that was chosen already, looked at with the limits that sweep and ratio program use: how it
//! stands against each, and what else a reviewer asks of it.

use rayon::prelude::*;

use super::evaluate::Judged;
use super::mount::{Mount, load_through};
use super::robot::{Draws, carried_first, carrying, draws};
use super::solved::solve;
use super::{Evaluation, Unusable};
use gearwise_model::actuator::limits::{LIMITS, Remark, hottest};
use gearwise_model::actuator::thermal::Winding;
use gearwise_model::requirement::{Choice, Joint, Motion, Robot};

/// What is known of a chosen design. SI.
#[derive(Debug, Clone)]
pub struct Examined {
    /// The design at its ratio, the costlier figures too.
    pub evaluation: Evaluation,
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
    /// Steady winding temperature.
    pub winding_temperature: Winding,
    /// Highest winding temperature that motor and requirement allow \[K\].
    pub hottest: Option<f64>,
    /// Longest time that the current needs for its jumps at a reversal \[s\].
    pub reversal_time: Option<f64>,
    /// The best ratio of the same motor and its objective; `None` where the gear fixes the ratio or no ratio
    /// keeps the limits.
    pub best: Option<(f64, f64)>,
    /// Inertia of the load about the joint \[kg·m²\], as stated or as the motion shows it.
    pub load_inertia: Option<f64>,
    /// Whether the load's inertia is an estimate from the motion.
    pub load_inertia_estimated: bool,
    /// Power that the bus gives at each sample \[W\].
    pub draws: Draws,
}

impl Examined {
    /// `1 − demand/limit` of a limit, the least of all that ask for it, where it was checked.
    pub fn margin(&self, limit: &str) -> Option<f64> {
        self.evaluation.least(limit).map(|least| least.margin)
    }

    /// What is left of a limit over the bare demand, without the requirement's safety factor and reserve.
    pub fn reserve(&self, joint: &Joint, limit: &str) -> Option<f64> {
        let has_safety = LIMITS.iter().any(|l| l.name == limit && l.safety);
        let factor = if has_safety { joint.limits.safety } else { 1.0 };
        let kept = joint.limits.left_of(limit);
        self.margin(limit).map(|margin| 1.0 - (1.0 - margin) * kept / factor)
    }
}

/// Evaluates the chosen designs of all joints with every limit of the model, each loaded with the actuators that
/// it carries. One for each choice: or why motor and gear are no candidate.
pub fn examine(robot: &Robot, choices: &[Choice]) -> Vec<Result<Examined, Unusable>> {
    if robot.joints.iter().all(|joint| joint.carries.is_empty()) {
        return choices.par_iter().map(|choice| examine_joint(robot, choice, choice.joint.clone())).collect();
    }
    let mut found: Vec<Option<Result<Examined, Unusable>>> = choices.iter().map(|_| None).collect();
    let place = |joint: usize| choices.iter().position(|c| c.joint.name == robot.joints[joint].name);
    for joint in carried_first(&robot.joints) {
        let Some(place) = place(joint) else { continue };
        let choice = &choices[place];
        let mass = |carried: usize| {
            let at = choices.iter().position(|c| c.joint.name == robot.joints[carried].name)?;
            found[at].as_ref()?.as_ref().ok()?.evaluation.mass
        };
        let unknown = choice.joint.carries.iter().any(|carried| mass(carried.joint).is_none());
        let loaded = carrying(choice.joint, |carried| mass(carried).unwrap_or(0.0));
        let mut examined = examine_joint(robot, choice, loaded);
        if let (true, Ok(examined)) = (unknown, &mut examined) {
            // Its own mass may be unknown, too, and carried by a third.
            examined.unchecked.retain(|(name, _)| *name != "carried_mass");
            examined.unchecked.push(("carried_mass", "the mass of an actuator that it carries is not known"));
        }
        found[place] = Some(examined);
    }
    found.into_iter().map(|one| one.expect("every choice is of a joint of the robot")).collect()
}

/// The best ratio of each choice's motor and its objective, as in [`Examined::best`]; outside `None` where motor and gear
/// are no candidate. For limits that rules have tightened.
pub fn best_ratios(robot: &Robot, choices: &[Choice]) -> Vec<Option<Option<(f64, f64)>>> {
    examine(robot, choices).into_iter().map(|one| one.ok().map(|examined| examined.best)).collect()
}

/// One joint under the load that is given.
fn examine_joint(robot: &Robot, choice: &Choice, mut joint: Joint) -> Result<Examined, Unusable> {
    if let Some(spring) = choice.design.spring
        && let Some(moved) = joint.with_spring(spring.stiffness, spring.rest_angle)
    {
        joint = moved;
    }
    let (motor, ratio) = (choice.motor, choice.ratio);
    let load = load_through(&joint, choice.gear);
    let prepared = Mount::new(robot, &joint, &load, motor).with_gear(choice.gear).prepared()?;
    if !prepared.says_gear_at(ratio) {
        return Err(Unusable::OutsideMap);
    }
    let range = joint.ratio.range().filter(|_| choice.gear.is_none());
    let best = range.and_then(|range| solve(&prepared, &joint, range).ok());
    let best = best.map(|optimum| (optimum.ratio, optimum.objective));
    let estimated = choice.design.load_inertia.is_none();
    let Judged { unchecked, assumed } = prepared.judged(ratio);
    Ok(Examined {
        evaluation: prepared.at_in_full(ratio),
        winding_temperature: prepared.winding_temperature(ratio),
        hottest: Some(hottest(motor, &joint).0),
        reversal_time: prepared.reversal_time(ratio),
        best,
        // A spring's torque follows the position, not the acceleration: the bare motion tells.
        load_inertia: choice.design.load_inertia.or_else(|| match choice.joint.own_motions().as_slice() {
            [(_, motion)] => apparent_inertia(motion),
            // Of two joints that two actuators move together there is no one inertia.
            _ => None,
        }),
        load_inertia_estimated: estimated,
        draws: draws(&prepared, ratio),
        unchecked,
        assumed,
    })
}

/// Share of the torque's variance that inertia and gravity must explain before an inertia is read off a motion.
const EXPLAINED: f64 = 0.9;

/// Largest relative standard error of an inertia that is read off a motion.
const UNCERTAIN: f64 = 0.1;

/// Inertia of the load \[kg·m²\] that a motion shows: the slope of torque over acceleration, with gravity
/// (a constant, sine and cosine of the position) and viscous drag beside it. `None` for operating points, and
/// where that explains less than nine tenths of the torque: then other forces rule, and the slope would be
/// noise.
pub(crate) fn apparent_inertia(motion: &Motion) -> Option<f64> {
    // What a spline says between the samples is no evidence of its own, and operating points are no motion.
    let seen: Vec<usize> = motion.given.iter().copied().filter(|k| !motion.is_point(*k)).collect();
    if seen.is_empty() {
        return None;
    }
    let given = |values: &[f64]| seen.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let samples = seen.len();
    let mut columns = vec![vec![1.0; samples], given(&motion.acceleration), given(&motion.velocity)];
    if let Some(position) = motion.position.as_ref().map(|q| given(q)) {
        columns.push(position.iter().map(|q| q.sin()).collect());
        columns.push(position.iter().map(|q| q.cos()).collect());
    }
    let matrix = nalgebra::DMatrix::from_fn(samples, columns.len(), |k, j| columns[j][k]);
    let torque = nalgebra::DVector::from_vec(given(&motion.torque));
    // The decomposition does not end on what is not finite.
    if matrix.iter().chain(torque.iter()).any(|value| !value.is_finite()) {
        return None;
    }
    let solution = matrix.clone().try_svd(true, true, f64::EPSILON, 1000)?.solve(&torque, 1e-9).ok()?;
    let left = (&torque - &matrix * &solution).norm_squared();
    let all = torque.add_scalar(-torque.mean()).norm_squared();
    if all <= 0.0 || left > (1.0 - EXPLAINED) * all {
        return None;
    }
    // Where gravity and inertia go alike, neither is known: its standard error says so.
    let freedom = samples.checked_sub(columns.len()).filter(|n| *n > 0)?;
    let covariance = (matrix.transpose() * &matrix).try_inverse()?;
    let error = (left / freedom as f64 * covariance[(1, 1)]).max(0.0).sqrt();
    (solution[1] > 0.0 && error <= UNCERTAIN * solution[1]).then_some(solution[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearwise_model::requirement::{Course, Samples};

    fn pendulum(push: f64) -> Motion {
        let time: Vec<f64> = (0..200).map(|k| f64::from(k) / 200.0).collect();
        let turn = std::f64::consts::TAU;
        let position: Vec<f64> = time.iter().map(|t| 0.4 * (turn * t).sin()).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 0.4 * turn * (turn * t).cos()).collect();
        let acceleration: Vec<f64> = position.iter().map(|q| -turn * turn * q).collect();
        let kick = |t: f64| push * f64::from(t > 0.2 && t < 0.4);
        let torque = (0..time.len()).map(|k| 0.3 * acceleration[k] + 8.0 * position[k].sin() + kick(time[k])).collect();
        let samples =
            Samples { time, torque, velocity: Some(velocity), position: Some(position), ..Samples::default() };
        Motion::from_samples(samples, Course::Periodic(1.0))
    }

    #[test]
    fn a_pendulum_shows_its_inertia_and_a_pushed_one_does_not() {
        // Sine of the position and acceleration are nearly collinear here: what is left between them is the
        // third harmonic, which is enough without noise.
        let inertia = apparent_inertia(&pendulum(0.0)).unwrap();
        assert!((inertia - 0.3).abs() < 0.01, "{inertia}");
        assert_eq!(apparent_inertia(&pendulum(60.0)), None);
    }
}
