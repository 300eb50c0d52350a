//! The motions of two joints as the two actuators have them that drive both.

use super::both::{Both, determinant, inverse};
use super::coupler::AtBoth;
use super::passed::Via;
use super::range::Range;
use super::{Coupling, Fault, Levers, Passed, Ways};
use crate::motion::{self, Instant, Motion};

/// Directions of the two actuators count as one where |det J| is a smaller share of its largest over the motion.
const SINGULAR: f64 = 1e-3;
/// Step along the motion over which the rate of J is looked at \[rad\].
const STEP: f64 = 1e-4;

impl Passed {
    /// The motions of two joints of one time base \[rad, N·m\] through a coupling: one motion with that of both actuators as its parts, and
    /// what was passed.
    ///
    /// # Errors
    /// The coupling cannot be where the motions are.
    pub fn coupled(coupling: &Coupling, joints: [(&str, &Motion); 2]) -> Result<(Motion, Passed), Fault> {
        Passed::coupled_at(coupling, joints, motion::At::NewInstants)
    }

    pub(super) fn coupled_at(
        coupling: &Coupling,
        joints: [(&str, &Motion); 2],
        at: motion::At,
    ) -> Result<(Motion, Passed), Fault> {
        let numbers = coupling.numbers;
        let broken = std::cell::Cell::new(None);
        let change = |instants: &[Instant; 2]| match change(coupling, instants) {
            Ok(changed) => changed.0,
            Err(fault) => {
                broken.set(Some(fault));
                *instants
            }
        };
        let (mut behind, before) = motion::through(joints.map(|(_, motion)| motion), at, &change);
        if let Some(fault) = broken.get() {
            return Err(fault);
        }
        let (mut at, mut torques) = (Vec::new(), [Vec::new(), Vec::new()]);
        for k in 0..before[0].len() {
            let instants = [before[0].instant(k), before[1].instant(k)];
            let (_, here, loads) = self::change(coupling, &instants)?;
            at.push(here);
            torques.iter_mut().zip(loads).for_each(|(all, load)| all.push(load));
        }
        let determinants = at.iter().map(|at| determinant(&at.jacobian));
        let determinant = Range::of(determinants.clone().map(f64::abs));
        let signs = [f64::signum, |d: f64| -d.signum()].map(|sign| determinants.clone().all(|d| sign(d) > 0.0));
        if determinant.least.0 <= SINGULAR * determinant.most.0 || !(signs[0] || signs[1]) {
            let k = determinant.least.1;
            return Err(Fault::SingularAt([0, 1].map(|j| before[j].position.as_ref().map_or(0.0, |q| q[k]))));
        }
        for motion in &mut behind {
            motion.held = numbers.efficiency;
            motion.position = None;
            motion.placed = false;
        }
        let loss = (0..2).map(|a| {
            behind[a].mean(|k| {
                let power = torques[a][k] * behind[a].velocity[k];
                (numbers.factor(torques[a][k], behind[a].velocity[k]) - 1.0) * power
            })
        });
        // Nothing lost is zero, not less than it.
        let loss = loss.sum::<f64>() + 0.0;
        let levers = levers(&at);
        let joints = joints.iter().map(|(name, _)| name.to_string()).zip(before.map(Into::into)).collect();
        let ways = Ways::Two(Both { at, torques, determinant });
        let passed = Passed { via: Via::Two(coupling.coupler.clone()), numbers, joints, ways, levers, loss };
        Ok((Motion::together(behind), passed))
    }
}

/// The worst over the motion, over both actuators and both joints.
fn levers(at: &[AtBoth]) -> Levers {
    let mut levers = Levers { torque: 0.0, angle: 0.0, inertia: 0.0, stiffness: f64::INFINITY, backdriving: 0.0 };
    for AtBoth { jacobian: j, .. } in at {
        let inverse = inverse(j);
        for i in 0..2 {
            let squares = j[0][i].powi(2) + j[1][i].powi(2);
            levers.torque = levers.torque.max(inverse[i][0].abs()).max(inverse[i][1].abs());
            // Both actuators are loose by the same.
            levers.angle = levers.angle.max(inverse[i][0].abs() + inverse[i][1].abs());
            levers.inertia = levers.inertia.max(squares);
            // The other joint is held, or gives way: the least is with it free.
            let other = j[0][1 - i].powi(2) + j[1][1 - i].powi(2);
            let mixed = j[0][0] * j[0][1] + j[1][0] * j[1][1];
            levers.stiffness = levers.stiffness.min(squares - mixed * mixed / other);
            levers.backdriving = levers.backdriving.max(j[0][i].abs() + j[1][i].abs());
        }
    }
    levers
}

type Changed = ([Instant; 2], AtBoth, [f64; 2]);

/// Instants of two joints as the actuators have them, and the torques of the actuators that come from the joints \[N·m\].
fn change(coupling: &Coupling, joints: &[Instant; 2]) -> Result<Changed, Fault> {
    let Coupling { coupler, numbers } = coupling;
    let q = joints.map(|instant| instant.position.unwrap_or(0.0));
    let speed = joints.map(|instant| instant.velocity);
    let at = coupler.at(q)?;
    // The sine of the angle between the directions of both actuators.
    let lengths = at.jacobian.map(|row| row[0].hypot(row[1]));
    if determinant(&at.jacobian).abs() <= SINGULAR * lengths[0] * lengths[1] {
        return Err(Fault::SingularAt(q));
    }
    let turning = at.turning(speed);
    // The rate of J̇: along the motion by a difference, and with the acceleration.
    let fast = speed[0].hypot(speed[1]);
    let mut bending = [[0.0; 2]; 2];
    if fast > 0.0 && !matches!(coupler, super::Coupler::Matrix(_)) {
        let step = STEP / fast;
        let side = |sign: f64| coupler.at([q[0] + sign * step * speed[0], q[1] + sign * step * speed[1]]);
        // At the end of a table or of a way there is one side alone.
        let (after, before) = (side(1.0).unwrap_or(at), side(-1.0).unwrap_or(at));
        let apart = f64::from(u8::from(after != at) + u8::from(before != at)).max(1.0) * step;
        let (after, before) = (after.turning(speed), before.turning(speed));
        for a in 0..2 {
            for i in 0..2 {
                let along = (after[a][i] - before[a][i]) / apart;
                let pushed: f64 = (0..2).map(|m| at.slopes[m][a][i] * joints[m].acceleration).sum();
                bending[a][i] = along + pushed;
            }
        }
    }
    let times = |m: &[[f64; 2]; 2], v: [f64; 2]| [0, 1].map(|a| m[a][0] * v[0] + m[a][1] * v[1]);
    let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
    let acceleration = joints.map(|instant| instant.acceleration);
    let jerk = joints.map(|instant| instant.jerk);
    let velocity = times(&at.jacobian, speed);
    let turned = sum(times(&at.jacobian, acceleration), times(&turning, speed));
    let both = times(&turning, acceleration).map(|x| 2.0 * x);
    let turned_jerk = sum(sum(times(&at.jacobian, jerk), both), times(&bending, speed));
    let inverse = inverse(&at.jacobian);
    // J⁻ᵀ v.
    let back = |v: [f64; 2]| [0, 1].map(|a| inverse[0][a] * v[0] + inverse[1][a] * v[1]);
    let load = back(joints.map(|i| i.torque + numbers.joint_inertia * i.acceleration));
    let pulled = [0, 1].map(|i| turning[0][i] * load[0] + turning[1][i] * load[1]);
    let rates = [0, 1].map(|i| joints[i].torque_rate + numbers.joint_inertia * joints[i].jerk - pulled[i]);
    let load_rate = back(rates);
    let of = |a: usize| {
        let factor = numbers.factor(load[a], velocity[a]);
        Instant {
            torque: factor * load[a] + numbers.inertia * turned[a],
            torque_rate: factor * load_rate[a] + numbers.inertia * turned_jerk[a],
            velocity: velocity[a],
            acceleration: turned[a],
            jerk: turned_jerk[a],
            position: joints[a].position,
        }
    };
    Ok(([of(0), of(1)], at, load))
}
