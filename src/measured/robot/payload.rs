//! Whether the masses of the description and its payloads are enough: asked of all joints at once.
//!
//! The one idea: a mass that is not in the description is felt by every joint that carries it, by each as its place says. One
//! number (or a mass with its place) has to explain them all; what only one joint asks for is that joint's.

use nalgebra::Vector3;

use super::bench::{Prepared, RobotBench};
use super::courses::Course;
use super::stacked::{Fit, Part, fit};
use crate::measured::identify::Options;
use crate::mechanism::dynamics::{Moving, first_moments, per_mass};
use crate::mechanism::{Mechanism, Place};
use crate::numerics::sums::paired;

/// Least share of the left-out squared error that a mass must take away to be worth a name.
const WORTH: f64 = 0.04;
/// Least share that it must take away to be the explanation: what leaves more is not explained by it.
const EXPLAINS: f64 = 0.7;
/// The furthest that it may be from the origin of its link, in lengths of the robot.
const FAR: f64 = 0.5;
/// Standard errors between blocks by which it must, of a dozen that are asked.
const SURE: f64 = 3.0;
/// Standard errors by which another explanation must be worse not to be named as well.
const WORSE: f64 = 2.5;
/// A joint says something of a mass that its own ± is less than this share of.
const SAYS: f64 = 0.5;
/// The masses that single joints ask for may differ by this share, or by the sum of their ±.
const AGREE: f64 = 0.3;
/// How often the inertia of a mass follows its place.
const ROUNDS: usize = 4;

/// A part of the robot that a mass may be at.
#[derive(Debug, Clone, PartialEq)]
pub struct Carrier {
    /// The link.
    pub link: String,
    /// Whether a declared payload hangs there.
    pub has_payload: bool,
}

/// What one joint alone asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Witness {
    /// The joint, by its number among those of the bench file.
    pub joint: usize,
    /// The mass \[kg\].
    pub mass: f64,
    /// Its ± (95 %) \[kg\].
    pub error: f64,
}

/// A mass beyond the description.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Where it may be: the best first; the others are not surely worse.
    pub carriers: Vec<Carrier>,
    /// The mass \[kg\]; less than zero where the description has too much.
    pub mass: f64,
    /// Its ± (95 %) \[kg\].
    pub error: f64,
    /// Its place on the first of the links \[m\].
    pub at: [f64; 3],
    /// Whether that place was fitted; else it is the declared payload's, or the link's centre.
    pub is_place_fitted: bool,
    /// What joints alone ask for.
    pub witnesses: Vec<Witness>,
    /// Share of the left-out squared error of all joints that it takes away.
    pub gain: f64,
    body: usize,
}

/// A mass that was asked for and not named, at the end of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Felt {
    /// Where.
    pub carrier: Carrier,
    /// The mass that suits the logs best \[kg\].
    pub mass: f64,
    /// Its ± (95 %) \[kg\].
    pub error: f64,
}

/// Why a mass that would lower the error is not named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Torques of the drives that are off by a factor explain as much.
    Scales,
    /// One joint alone says something of it.
    OneJoint,
    /// Joints ask for different masses.
    Disagree,
    /// What it takes away scatters too much between stretches of the logs.
    Scatters,
    /// Much is left beside it.
    LeavesMuch,
}

/// Whether the masses of the description are enough.
#[derive(Debug, Clone, PartialEq)]
pub enum PayloadAnswer {
    /// It was not asked: no joint's logs have a current of the drive, or no joint carries anything.
    NotAsked,
    /// No mass lowers the error of the joints.
    Enough(Felt),
    /// A mass would lower the error, and something else may be it.
    Open(Named, Asked),
    /// A mass is missing, or too much; the joints are identified with it.
    Named(Named),
}

impl Named {
    /// Adds what it asks of the joints to a load of them, at the times of a course.
    pub(super) fn add_to(&self, mechanism: &Mechanism, course: &Course, load: &mut [Vec<f64>]) {
        let place = Place { body: self.body, at: Vector3::from(self.at) };
        for (k, moving) in course.kinematics(mechanism).enumerate() {
            for (joint, torque) in per_mass(mechanism, &moving, place) {
                load[joint][k] += self.mass * torque;
            }
        }
    }
}

/// A place that is asked, and what a kilogram there is at each part.
struct Candidate {
    carrier: Carrier,
    place: Place,
    /// The most that may be too much there (less than zero), and the most that may be missing \[kg\].
    bounds: [f64; 2],
    columns: Vec<Vec<f64>>,
}

/// Everything that the questions share.
struct Question<'a> {
    robot: &'a RobotBench,
    courses: &'a [Course],
    /// The first time of each log.
    first: Vec<f64>,
    parts: Vec<Part>,
}

/// Asks all joints for a mass.
pub(super) fn ask(robot: &RobotBench, prepared: &[Prepared], courses: &[Course], options: &Options) -> PayloadAnswer {
    let part = |p: &Prepared| Part::new(p, robot.joints[p.joint].number, options);
    let parts: Vec<Part> = prepared.iter().filter_map(part).collect();
    let first = prepared[0].bench.logs.iter().map(|log| log.time.first().copied().unwrap_or(0.0)).collect();
    let mut question = Question { robot, courses, first, parts };
    let candidates: Vec<Candidate> = question.candidates();
    let Some(last) = candidates.last() else { return PayloadAnswer::NotAsked };
    let free: Vec<Vec<Vec<f64>>> = question.moments(last.place.body);
    for (index, part) in question.parts.iter_mut().enumerate() {
        part.weigh(&free.iter().map(|c| c[index].as_slice()).collect::<Vec<_>>());
    }
    question.answer(&candidates)
}

impl Question<'_> {
    fn all(&self) -> Vec<&Part> {
        self.parts.iter().collect()
    }

    /// The places that are asked, from the base outwards: of each moving body that a joint with an equation carries the declared
    /// payload's, or the centre of its heaviest part.
    fn candidates(&self) -> Vec<Candidate> {
        let mechanism = &self.robot.mechanism;
        let carrier_of = |body: usize| {
            std::iter::successors(Some(body), |b| mechanism.bodies[*b].parent)
                .find(|b| mechanism.bodies[*b].joint.is_some())
        };
        let place = |moving: usize| {
            let members = || (0..mechanism.bodies.len()).filter(|b| carrier_of(*b) == Some(moving));
            let payloads = || self.robot.carrying.iter().flatten();
            let hung = payloads().filter(|p| mechanism.body(&p.link).is_some_and(|b| members().any(|m| m == b)));
            let described = members().map(|b| mechanism.bodies[b].inertia.mass).sum::<f64>()
                + hung.map(|p| p.mass).fold(0.0, f64::max);
            let of = payloads()
                .find_map(|p| Some((p, mechanism.body(&p.link)?)).filter(|(_, b)| members().any(|m| m == *b)));
            if let Some((payload, body)) = of {
                let carrier = Carrier { link: payload.link.clone(), has_payload: true };
                return Some((carrier, Place { body, at: Vector3::from(payload.at) }, described));
            }
            let heaviest = members().max_by(|a, b| {
                let mass = |b: usize| mechanism.bodies[b].inertia.mass;
                mass(*a).total_cmp(&mass(*b)).then(b.cmp(a))
            })?;
            let body = &mechanism.bodies[heaviest];
            let link = members().find_map(|b| mechanism.bodies[b].name.clone())?;
            let link = body.name.clone().unwrap_or(link);
            Some((Carrier { link, has_payload: false }, Place { body: heaviest, at: body.inertia.centre }, described))
        };
        let heaviest = self.robot.carrying.iter().flatten().map(|p| p.mass).fold(0.0, f64::max);
        let whole = mechanism.mass() + heaviest;
        let places = mechanism.moving().into_iter().filter_map(place);
        let candidate = |(carrier, place, described): (Carrier, Place, f64)| {
            let columns = self.of_place(place);
            let felt = columns.iter().flatten().any(|v| *v != 0.0);
            felt.then_some(Candidate { carrier, place, bounds: [-described, whole], columns })
        };
        places.filter_map(candidate).collect()
    }

    /// What each part feels of something that moves with a body, given as torques of joints at an instant; one column for each of
    /// `count` numbers.
    fn felt(&self, count: usize, torques: impl Fn(&[Moving]) -> Vec<(usize, Vec<f64>)>) -> Vec<Vec<Vec<f64>>> {
        let mechanism = &self.robot.mechanism;
        // Number, then part, then log.
        let mut all = vec![vec![Vec::new(); self.parts.len()]; count];
        for course in self.courses {
            for parts in &mut all {
                parts.iter_mut().for_each(|logs| logs.push(Vec::new()));
            }
            for moving in course.kinematics(mechanism) {
                let felt = torques(&moving);
                for (index, part) in self.parts.iter().enumerate() {
                    let own = felt.iter().find(|(joint, _)| *joint == part.number);
                    for (k, parts) in all.iter_mut().enumerate() {
                        if let Some(log) = parts[index].last_mut() {
                            log.push(own.map_or(0.0, |(_, values)| values[k]));
                        }
                    }
                }
            }
        }
        let column = |(index, logs): (usize, &Vec<Vec<f64>>)| self.parts[index].column(self.courses, logs, &self.first);
        all.iter().map(|parts| parts.iter().enumerate().map(column).collect()).collect()
    }

    /// What each part feels of a kilogram at a place.
    fn of_place(&self, place: Place) -> Vec<Vec<f64>> {
        let mechanism = &self.robot.mechanism;
        let torques = |moving: &[Moving]| {
            per_mass(mechanism, moving, place).into_iter().map(|(joint, torque)| (joint, vec![torque])).collect()
        };
        self.felt(1, torques).remove(0)
    }

    /// What each part feels of a kilogram at the origin of a body, and of a first moment of one kilogram metre along each of its
    /// axes.
    fn moments(&self, body: usize) -> Vec<Vec<Vec<f64>>> {
        let mechanism = &self.robot.mechanism;
        self.felt(4, |moving| {
            first_moments(mechanism, moving, body).into_iter().map(|(joint, four)| (joint, four.to_vec())).collect()
        })
    }

    /// The length of the robot \[m\]: of all its bodies, one after the other.
    fn reach(&self) -> f64 {
        self.robot.mechanism.bodies.iter().map(|b| b.placement.translation.vector.norm()).sum()
    }

    fn answer(&self, candidates: &[Candidate]) -> PayloadAnswer {
        let parts = self.all();
        let without = fit(&parts, &[], false);
        let scaled = fit(&parts, &[], true);
        let fits: Vec<Fit> =
            candidates.iter().map(|c| fit(&parts, &[c.columns.iter().map(Vec::as_slice).collect()], false)).collect();
        let least = |a: &usize, b: &usize| fits[*a].left().total_cmp(&fits[*b].left());
        // No link weighs less than nothing, nor more than the robot.
        let may_be =
            |candidate: &Candidate, fit: &Fit| (candidate.bounds[0]..=candidate.bounds[1]).contains(&fit.shared[0]);
        let best = (0..fits.len()).filter(|k| may_be(&candidates[*k], &fits[*k])).min_by(least);
        let end = candidates.len() - 1;
        let felt =
            Felt { carrier: candidates[end].carrier.clone(), mass: fits[end].shared[0], error: fits[end].error[0] };
        let Some(best) = best else { return PayloadAnswer::Enough(felt) };
        // A place that differs from the declared one is worth it only where it is surely better.
        let placed: Vec<Option<(Candidate, Fit)>> =
            candidates.iter().map(|c| self.placed(c).filter(|(c, fit)| may_be(c, fit))).collect();
        let least = |a: &usize, b: &usize| {
            let left = |k: usize| placed[k].as_ref().map_or(f64::INFINITY, |(_, fit)| fit.left());
            left(*a).total_cmp(&left(*b))
        };
        let freest = (0..placed.len()).min_by(least).and_then(|k| placed[k].as_ref().map(|p| (k, p)));
        let freest = freest.filter(|(_, (_, fit))| {
            let gain = (fits[best].left() - fit.left()) / without.left();
            gain > 0.5 * WORTH && paired(&fits[best].left_out, &fit.left_out) > SURE
        });
        let (index, candidate, own) = match &freest {
            Some((k, (candidate, fit))) => (*k, candidate, fit),
            None => (best, &candidates[best], &fits[best]),
        };
        let gain = 1.0 - own.left() / without.left();
        let is_there = own.shared[0].abs() > own.error[0];
        if gain <= WORTH || !is_there {
            return PayloadAnswer::Enough(felt);
        }
        let is_sure = paired(&without.left_out, &own.left_out) > SURE;
        // Others of the same kind that are not surely worse.
        let others = (0..candidates.len()).filter(|k| *k != index && may_be(&candidates[*k], &fits[*k])).filter(|k| {
            let other = match (&freest, &placed[*k]) {
                (Some(_), Some((_, fit))) => fit,
                (Some(_), None) => return false,
                (None, _) => &fits[*k],
            };
            paired(&other.left_out, &own.left_out) < WORSE
        });
        let carriers = std::iter::once(index).chain(others).map(|k| candidates[k].carrier.clone()).collect();
        let witnesses = self.witnesses(candidate, own.shared[0]);
        // What torque constants that are off by a factor would make of it is not known any better.
        let columns: Vec<&[f64]> = candidate.columns.iter().map(Vec::as_slice).collect();
        let beside_scales = fit(&parts, &[columns], true).shared[0];
        let named = Named {
            carriers,
            mass: own.shared[0],
            error: own.error[0].max((beside_scales - own.shared[0]).abs()),
            at: candidate.place.at.into(),
            is_place_fitted: freest.is_some(),
            gain,
            body: candidate.place.body,
            witnesses,
        };
        let agree = |w: &Witness| (w.mass - named.mass).abs() <= (w.error + named.error).max(AGREE * named.mass.abs());
        let why = if named.witnesses.len() < 2 {
            Some(Asked::OneJoint)
        } else if !named.witnesses.iter().all(agree) {
            Some(Asked::Disagree)
        } else if paired(&scaled.left_out, &own.left_out) < WORSE {
            Some(Asked::Scales)
        } else if !is_sure {
            Some(Asked::Scatters)
        } else if gain < EXPLAINS {
            Some(Asked::LeavesMuch)
        } else {
            None
        };
        match why {
            Some(why) => PayloadAnswer::Open(named, why),
            None => PayloadAnswer::Named(named),
        }
    }

    /// What each joint alone asks for at a place, of those that say something.
    fn witnesses(&self, candidate: &Candidate, mass: f64) -> Vec<Witness> {
        let one = |(index, part): (usize, &Part)| {
            let column = candidate.columns[index].as_slice();
            if part.size(column) * mass * mass < 1e-4 {
                return None;
            }
            let fit = fit(&[part], &[vec![column]], false);
            let (own, error) = (fit.shared[0], fit.error[0]);
            (error < SAYS * mass.abs()).then_some(Witness { joint: part.joint, mass: own, error })
        };
        self.parts.iter().enumerate().filter_map(one).collect()
    }

    /// The same mass where it suits best on its body: a point whose inertia follows its place. `None` where no mass with a place
    /// comes of it.
    fn placed(&self, candidate: &Candidate) -> Option<(Candidate, Fit)> {
        let body = candidate.place.body;
        let columns = self.moments(body);
        let parts = self.all();
        let mut at = candidate.place.at;
        for round in 0.. {
            // A kilogram at the place so far, and what moving it does, its inertia left as it is.
            let here = self.of_place(Place { body, at });
            let mut four = columns.clone();
            for (index, column) in here.iter().enumerate() {
                for (k, value) in column.iter().enumerate() {
                    let moments =
                        at.x * columns[1][index][k] + at.y * columns[2][index][k] + at.z * columns[3][index][k];
                    // m (τ(p₀) + (p − p₀)·∂τ/∂h): the mass's own column is what is left where h = m p stays free.
                    four[0][index][k] = value - moments;
                }
            }
            let shared: Vec<Vec<&[f64]>> = four.iter().map(|parts| parts.iter().map(Vec::as_slice).collect()).collect();
            let found = fit(&parts, &shared, false);
            let mass = found.shared[0];
            // Without a mass there is no place.
            if mass.abs() <= found.error[0] {
                return None;
            }
            let next = Vector3::new(found.shared[1], found.shared[2], found.shared[3]) / mass;
            if !next.iter().all(|v| v.is_finite()) || next.norm() > FAR * self.reach() {
                return None;
            }
            if round == ROUNDS || (next - at).norm() < 1e-4 {
                let place = Place { body, at: next };
                let columns = self.of_place(place);
                let again = fit(&parts, &[columns.iter().map(Vec::as_slice).collect()], false);
                let Candidate { carrier, bounds, .. } = candidate;
                return Some((Candidate { carrier: carrier.clone(), place, bounds: *bounds, columns }, again));
            }
            at = next;
        }
        None
    }
}
