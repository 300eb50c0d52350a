//! A motion of a joint as its actuator has it.

use std::sync::Arc;

use super::both::Both;
use super::range::Range;
use super::{At, Coupler, Coupling, Fault, Numbers, Transmission, Way};
use crate::motion::{self, Instant, Motion};

/// Where a spring parallel to the actuator pulls.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SpringAt {
    /// At the joint: its angles are the joint's.
    #[default]
    Joint,
    /// At the actuator, before the transmission: its angles are the actuator's.
    Actuator,
}

impl SpringAt {
    /// Names, as a requirement has them.
    pub const NAMES: &[(&str, SpringAt)] = &[("joint", SpringAt::Joint), ("actuator", SpringAt::Actuator)];
}

/// What one of something on one side is on the other, at its worst over the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levers {
    /// Largest torque at an actuator per torque at a joint: 1/min |r|.
    pub torque: f64,
    /// Largest angle of a joint per angle that its actuators are loose by: 1/min |r|.
    pub angle: f64,
    /// Largest inertia at a joint per inertia at each actuator: max r².
    pub inertia: f64,
    /// Smallest stiffness at a joint per stiffness of each actuator: min r².
    pub stiffness: f64,
    /// Largest torque at a joint that sets its actuators going, per torque that sets one of them going: max |r|.
    pub backdriving: f64,
}

/// How a transmission is at each sample.
#[derive(Debug, Clone, PartialEq)]
pub enum Ways {
    /// One actuator drives one joint.
    One {
        /// The transmission at each sample.
        at: Vec<At>,
        /// Smallest and largest |r|.
        ratio: Range,
    },
    /// Two actuators drive two joints.
    Two(Both),
}

/// What is between actuators and joints.
#[derive(Debug, Clone, PartialEq)]
pub enum Via {
    /// Of one joint.
    One(Way),
    /// Of two.
    Two(Coupler),
}

/// What a transmission makes of a motion: the motion of the actuator is the joint's own; this is what is before it.
#[derive(Debug, Clone, PartialEq)]
pub struct Passed {
    /// What is between: other motions can be put through it.
    pub via: Via,
    /// What it loses, weighs and bears.
    pub numbers: Numbers,
    /// The motions of the joints that it moves \[rad, N·m\], with their names where there are two, at the samples of each actuator;
    /// without the inertia that moves with the joint.
    pub joints: Vec<(String, Arc<Motion>)>,
    /// How it is at each sample.
    pub ways: Ways,
    /// What one of something on one side is on the other.
    pub levers: Levers,
    /// Mean loss over the motion \[W\].
    pub loss: f64,
}

impl Passed {
    /// A motion of a joint \[rad, N·m\] through a transmission: the motion of the actuator, and what was passed.
    ///
    /// # Errors
    /// The transmission cannot be where the motion is.
    pub fn new(transmission: &Transmission, motion: &Motion) -> Result<(Motion, Passed), Fault> {
        Passed::of(transmission, motion, motion::At::NewInstants)
    }

    /// The same for other motions of its joints, at the samples that these have.
    ///
    /// # Errors
    /// As [`Passed::new`], or there are not as many motions as joints.
    pub(crate) fn again(&self, motions: &[Motion]) -> Result<(Motion, Passed), Fault> {
        let numbers = self.numbers;
        match (&self.via, motions) {
            (Via::Two(coupler), [first, second]) => {
                let coupling = Coupling { coupler: coupler.clone(), numbers };
                let named = [(&*self.joints[0].0, first), (&*self.joints[1].0, second)];
                Passed::coupled_at(&coupling, named, motion::At::ItsInstants)
            }
            (Via::One(way), [motion, ..]) => {
                Passed::of(&Transmission { way: way.clone(), numbers }, motion, motion::At::ItsInstants)
            }
            _ => Err(Fault::Open(f64::NAN)),
        }
    }

    fn of(transmission: &Transmission, motion: &Motion, at: motion::At) -> Result<(Motion, Passed), Fault> {
        let mut transmission = transmission.clone();
        if let Some(position) = &motion.position {
            let [low, high] = ends(position);
            transmission.way = transmission.way.around(0.5 * (low + high));
            for (samples, course) in motion.courses() {
                let [low, high] = ends(&position[samples]);
                // Nothing lies between operating points.
                if !matches!(course, motion::Course::Points(_)) {
                    transmission.way.ratios(low, high)?;
                }
            }
            // From case to case the sign may not change either.
            let signs = position.iter().map(|q| transmission.way.at(*q).map(|at| (*q, at.ratio.signum())));
            let signs = signs.collect::<Result<Vec<_>, _>>()?;
            if let Some((q, _)) = signs.iter().find(|(_, sign)| *sign != signs[0].1) {
                return Err(Fault::Reverses(*q));
            }
        }
        // Every angle of the motion was looked at; a spline between its samples may leave their range by a little.
        let broken = std::cell::Cell::new(None);
        let change = |[instant]: &[Instant; 1]| match transmission.change(instant) {
            Ok(changed) => [changed],
            Err(fault) => {
                broken.set(Some(fault));
                [*instant]
            }
        };
        let ([mut behind], [before]) = motion::through([motion], at, &change);
        if let Some(fault) = broken.get() {
            return Err(fault);
        }
        let Transmission { way, numbers } = transmission;
        behind.held = numbers.efficiency;
        let zeros = vec![0.0; before.len()];
        let position = before.position.as_ref().unwrap_or(&zeros);
        let at = position.iter().map(|q| way.at(*q)).collect::<Result<Vec<At>, Fault>>()?;
        let loss = before.mean(|k| {
            let torque = before.torque[k] + numbers.joint_inertia * before.acceleration[k];
            (numbers.factor(torque, before.velocity[k]) - 1.0) * torque * before.velocity[k]
        });
        // Nothing lost is zero, not less than it.
        let loss = loss + 0.0;
        let ratio = Range::of(at.iter().map(|at| at.ratio.abs()));
        let (least, most) = (ratio.least.0, ratio.most.0);
        let levers = Levers {
            torque: 1.0 / least,
            angle: 1.0 / least,
            inertia: most * most,
            stiffness: least * least,
            backdriving: most,
        };
        let ways = Ways::One { at, ratio };
        let joints = vec![(String::new(), before.into())];
        Ok((behind, Passed { via: Via::One(way), numbers, joints, ways, levers, loss }))
    }

    /// The motion of the joint, or of the first of two.
    pub fn motion(&self) -> &Arc<Motion> {
        &self.joints[0].1
    }

    /// What it is, in a word or a few.
    pub fn word(&self) -> &'static str {
        match &self.via {
            Via::One(way) => way.word(),
            Via::Two(coupler) => coupler.word(),
        }
    }

    /// Smallest and largest |r|; `None` of two joints.
    pub fn ratio(&self) -> Option<Range> {
        match &self.ways {
            Ways::One { ratio, .. } => Some(*ratio),
            Ways::Two(_) => None,
        }
    }

    /// r, where it is the same at every angle.
    pub fn constant(&self) -> Option<f64> {
        match &self.via {
            Via::One(way) => way.constant(),
            Via::Two(_) => None,
        }
    }

    /// The ratio at each sample, where it is one.
    pub fn at(&self) -> Option<&[At]> {
        match &self.ways {
            Ways::One { at, .. } => Some(at),
            Ways::Two(_) => None,
        }
    }

    /// Torque \[N·m\] and its rate \[N·m/s\] at the actuator at a sample of its motion, with so much more at the joint. Of two joints the
    /// more is at that whose torque the actuator feels more.
    pub fn with_more(&self, k: usize, torque: f64, rate: f64) -> (f64, f64) {
        match &self.ways {
            Ways::One { at, .. } => {
                let motion = self.motion();
                let instant = motion.instant(k);
                let more =
                    Instant { torque: instant.torque + torque, torque_rate: instant.torque_rate + rate, ..instant };
                let passed = pass(&self.numbers, &at[k], &more);
                (passed.torque, passed.torque_rate)
            }
            Ways::Two(both) => both.with_more(&self.joints, &self.numbers, k, torque, rate),
        }
    }

    /// 1/r and its rate \[1/s\] at a sample: the torque at the actuator of one N·m at the joint, without loss; of one joint.
    pub fn per_torque(&self, k: usize) -> (f64, f64) {
        let Some(at) = self.at() else { return (f64::NAN, f64::NAN) };
        let At { ratio, slope, .. } = at[k];
        (1.0 / ratio, -slope * self.motion().velocity[k] / (ratio * ratio))
    }

    /// Largest inertia at the joint \[kg·m²\] of one at the actuator's output: r² (J + J_t) + J_j.
    pub fn inertia_at_joint(&self, at_output: f64) -> f64 {
        self.levers.inertia * (at_output + self.numbers.inertia) + self.numbers.joint_inertia
    }

    /// Mass of what goes with each actuator \[kg\]; `None` where it is not said.
    pub fn mass_of_each(&self) -> Option<f64> {
        self.numbers.mass.map(|mass| mass / self.joints.len() as f64)
    }

    /// Largest force of a rod or screw \[N\], with its sample of the actuator's motion; `None` where no arm says it.
    pub fn largest_force(&self) -> Option<(f64, usize)> {
        let forces = match &self.ways {
            Ways::One { at, .. } => {
                let force = |(k, at): (usize, &At)| Some(self.torque_through(0, k).abs() / at.arm?);
                at.iter().enumerate().map(force).collect::<Option<Vec<f64>>>()?
            }
            Ways::Two(both) => both.forces()?,
        };
        Some(Range::of(forces.into_iter()).most)
    }

    /// Largest torque at a joint that goes through the transmission \[N·m\], with its sample.
    pub fn largest_torque(&self) -> (f64, usize) {
        let of = |(joint, (_, motion)): (usize, &(String, Arc<Motion>))| {
            Range::of((0..motion.len()).map(|k| self.torque_through(joint, k).abs())).most
        };
        let each = self.joints.iter().enumerate().map(of);
        each.fold((0.0, 0), |most, one| if one.0 > most.0 { one } else { most })
    }

    /// Torque of a joint that goes through the transmission \[N·m\].
    pub(super) fn torque_through(&self, joint: usize, k: usize) -> f64 {
        let motion = &self.joints[joint].1;
        motion.torque[k] + self.numbers.joint_inertia * motion.acceleration[k]
    }
}

fn ends(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(*v), high.max(*v)])
}

impl Transmission {
    /// Of a way, without loss and inertia.
    pub fn ideal(way: Way) -> Transmission {
        Transmission { way, numbers: Numbers::IDEAL }
    }

    /// An instant of the joint as the actuator has it.
    fn change(&self, instant: &Instant) -> Result<Instant, Fault> {
        let at = self.way.at(instant.position.unwrap_or(0.0))?;
        Ok(pass(&self.numbers, &at, instant))
    }
}

fn pass(numbers: &Numbers, at: &At, instant: &Instant) -> Instant {
    let At { angle, ratio: r, slope, bend, .. } = *at;
    let Instant { torque, torque_rate, velocity, acceleration, jerk, position } = *instant;
    let load = torque + numbers.joint_inertia * acceleration;
    let load_rate = torque_rate + numbers.joint_inertia * jerk;
    let factor = numbers.factor(load, velocity);
    let turned = r * acceleration + slope * velocity * velocity;
    let turned_jerk = r * jerk + 3.0 * slope * velocity * acceleration + bend * velocity.powi(3);
    Instant {
        torque: factor * load / r + numbers.inertia * turned,
        torque_rate: factor * (load_rate / r - load * slope * velocity / (r * r)) + numbers.inertia * turned_jerk,
        velocity: r * velocity,
        acceleration: turned,
        jerk: turned_jerk,
        position: position.map(|_| angle),
    }
}
