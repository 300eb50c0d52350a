//! Many episodes of a simulator as one motion.

use std::sync::Arc;

use super::read::{check_samples, time_order};
use super::{Course, Motion, Point, Samples};
use crate::input::{InputError, Problem, Source};

/// What a simulator's joint has of its own in place of an actuator's.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SimulatorsOwn {
    /// Armature \[kg·m²\].
    pub armature: f64,
    /// Viscous friction \[N·m·s/rad\].
    pub damping: f64,
    /// Coulomb friction \[N·m\].
    pub friction: f64,
}

/// A motion of all samples of episodes, each with its own spline, weighed by how long they last. The torque of each is what the
/// actuator gave the joint, of which what the simulator's joint had of its own is taken out: the real actuator brings its own.
///
/// # Errors
/// Every mistake of an episode, with its number, counted from zero.
pub fn of_episodes(episodes: Vec<Samples>, own: SimulatorsOwn) -> Result<Motion, InputError> {
    let (mut points, mut problems) = (Vec::new(), Vec::new());
    for (place, samples) in episodes.into_iter().enumerate() {
        let before = problems.len();
        check_samples(&samples, &mut problems);
        if problems.len() == before {
            time_order(&samples, &mut problems);
        }
        if problems.len() == before {
            points.extend(of_episode(samples, own));
        }
        for problem in &mut problems[before..] {
            problem.message = format!("episode {place}: {}", problem.message);
        }
    }
    if problems.is_empty() && points.is_empty() {
        problems.push(Problem::whole("there is no episode"));
    }
    InputError::unless_empty(&Arc::new(Source::of_values("the episodes", "")), problems)?;
    Ok(Motion { mixed: true, ..Motion::from_points(&points) })
}

fn of_episode(samples: Samples, own: SimulatorsOwn) -> Vec<Point> {
    let lasts = samples.time[samples.time.len() - 1] - samples.time[0];
    let motion = Motion::at_samples(samples, Course::Once(lasts));
    let point = |k: usize| {
        let (velocity, acceleration, jerk) = (motion.velocity[k], motion.acceleration[k], motion.jerk[k]);
        let towards = if velocity == 0.0 { 0.0 } else { velocity.signum() };
        Point {
            torque: motion.torque[k] - own.armature * acceleration - own.damping * velocity - own.friction * towards,
            velocity,
            acceleration,
            torque_rate: motion.torque_rate[k] - own.armature * jerk - own.damping * acceleration,
            jerk,
            duration: Some(motion.weight[k] * lasts),
        }
    };
    (0..motion.len()).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// An episode of a pendulum's torque with what a simulator adds, over some time.
    fn episode(begin: f64, steps: usize, own: SimulatorsOwn) -> (Samples, Vec<f64>) {
        let time: Vec<f64> = (0..steps).map(|k| begin + 0.002 * k as f64).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 2.0 * (3.0 * t).sin()).collect();
        let acceleration: Vec<f64> = time.iter().map(|t| 6.0 * (3.0 * t).cos()).collect();
        let load: Vec<f64> = time.iter().map(|t| 5.0 + (4.0 * t).cos()).collect();
        let added =
            |k: usize| own.armature * acceleration[k] + own.damping * velocity[k] + own.friction * velocity[k].signum();
        let torque = (0..steps).map(|k| load[k] + added(k)).collect();
        let samples =
            Samples { time, torque, velocity: Some(velocity), acceleration: Some(acceleration), ..Samples::default() };
        (samples, load)
    }

    #[test]
    fn what_the_simulator_has_is_taken_out_and_derivatives_stay_within_an_episode() {
        let own = SimulatorsOwn { armature: 0.02, damping: 0.3, friction: 0.1 };
        let (first, load) = episode(0.1, 300, own);
        let (second, _) = episode(0.9, 40, own);
        let motion = of_episodes(vec![first, second], own).unwrap();
        assert_eq!(motion.len(), 340);
        for (torque, load) in motion.torque.iter().zip(&load) {
            assert_relative_eq!(torque, load, max_relative = 1e-12);
        }
        // The load's rate is -4 sin 4t; the last sample of the first episode knows nothing of the second.
        for k in 10..290 {
            let t = 0.1 + 0.002 * k as f64;
            assert_relative_eq!(motion.torque_rate[k], -4.0 * (4.0 * t).sin(), epsilon = 2e-3);
        }
        assert!(motion.torque_rate.iter().all(|rate| rate.abs() < 10.0));
        assert_relative_eq!(motion.duration().unwrap(), 0.002 * (299.0 + 39.0), max_relative = 1e-12);
        assert_relative_eq!(motion.weight.iter().sum::<f64>(), 1.0, max_relative = 1e-12);
    }

    #[test]
    fn each_mistake_has_its_episode() {
        let (good, _) = episode(0.0, 20, SimulatorsOwn::default());
        let mut back = good.clone();
        back.time.swap(3, 4);
        let mut short = good.clone();
        short.torque.pop();
        let mut unknown = good.clone();
        unknown.torque[7] = f64::NAN;
        let error = of_episodes(vec![good, back, short, unknown], SimulatorsOwn::default()).unwrap_err();
        let said: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
        assert!(said[0].starts_with("episode 1: ") && said[0].contains("does not increase"), "{said:?}");
        assert!(said[1].starts_with("episode 2: ") && said[2].starts_with("episode 3: "), "{said:?}");
        assert!(of_episodes(Vec::new(), SimulatorsOwn::default()).is_err());
    }
}
