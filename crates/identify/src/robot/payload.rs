//! Whether the masses of the description and its payloads are enough: asked of all joints at once.
//!
//! The one idea: a mass that is not in the description is felt by every joint that carries it, by each as its place says. One
//! number (or a mass with its place) has to explain them all; what only one joint asks for is that joint's.

use nalgebra::Vector3;

use super::bench::{Prepared, RobotBench};
use super::courses::Course;
use super::stacked::{Fit, Part, fit};
use crate::identify::Options;
use gearwise_model::mechanism::dynamics::{per_mass, point_mass, regressor};
use gearwise_model::mechanism::{Mechanism, Place};
use gearwise_model::numerics::sums::paired;

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

/// What each part feels of one number, as a column of its equation.
type Columns = Vec<Vec<f64>>;

/// A body that a mass may move with.
struct Candidate {
    carrier: Carrier,
    /// The place that is asked first: the declared payload's, or the centre of its heaviest part.
    place: Place,
    /// The most that may be too much there (less than zero), and the most that may be missing \[kg\].
    bounds: [f64; 2],
    /// What each part feels of the body's inertial parameters, in the order of [`regressor`].
    columns: [Columns; 10],
}

/// A mass at a place, fitted.
struct Placed {
    at: Vector3<f64>,
    columns: Columns,
    fit: Fit,
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
    let candidates = question.candidates();
    let Some(last) = candidates.last() else { return PayloadAnswer::NotAsked };
    for (index, part) in question.parts.iter_mut().enumerate() {
        let free: Vec<&[f64]> = last.columns[..4].iter().map(|c| c[index].as_slice()).collect();
        part.weigh(&free);
    }
    question.answer(&candidates)
}

impl Candidate {
    /// What each part feels of a kilogram at a point of the body.
    fn of_point(&self, at: &Vector3<f64>) -> Columns {
        self.sum(&point_mass(at))
    }

    /// What each part feels of that much of each parameter.
    fn sum(&self, amounts: &[f64; 10]) -> Columns {
        let mut sums: Columns = self.columns[0].iter().map(|part| vec![0.0; part.len()]).collect();
        for (amount, parts) in amounts.iter().zip(&self.columns) {
            for (sum, part) in sums.iter_mut().zip(parts) {
                sum.iter_mut().zip(part).for_each(|(s, v)| *s += amount * v);
            }
        }
        sums
    }

    /// No link weighs less than nothing, nor more than the robot.
    fn may_be(&self, fit: &Fit) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&fit.shared[0])
    }
}

impl Question<'_> {
    fn all(&self) -> Vec<&Part> {
        self.parts.iter().collect()
    }

    /// The bodies that are asked, from the base outwards: each moving body that a joint with an equation carries.
    fn candidates(&self) -> Vec<Candidate> {
        let mechanism = &self.robot.mechanism;
        let bodies = &mechanism.bodies;
        let mover =
            |body: usize| std::iter::successors(Some(body), |b| bodies[*b].parent).find(|b| bodies[*b].joint.is_some());
        // Every payload of a log, with the body it hangs on.
        let payloads: Vec<_> =
            self.robot.carrying.iter().flatten().filter_map(|p| Some((mechanism.body(&p.link)?, p))).collect();
        let heaviest = |hung: &mut dyn Iterator<Item = f64>| hung.fold(0.0, f64::max);
        let whole = mechanism.mass() + heaviest(&mut payloads.iter().map(|(_, p)| p.mass));
        let candidate = |moving: usize| {
            let members: Vec<usize> = (0..bodies.len()).filter(|b| mover(*b) == Some(moving)).collect();
            let mut hung = payloads.iter().filter(|(body, _)| members.contains(body));
            let own = members.iter().map(|b| bodies[*b].inertia.mass).sum::<f64>();
            let described = own + heaviest(&mut hung.clone().map(|(_, p)| p.mass));
            let (carrier, place) = if let Some((body, payload)) = hung.next() {
                let carrier = Carrier { link: payload.link.clone(), has_payload: true };
                (carrier, Place { body: *body, at: Vector3::from(payload.at) })
            } else {
                let mass = |b: usize| bodies[b].inertia.mass;
                let body = *members.iter().max_by(|a, b| mass(**a).total_cmp(&mass(**b)).then(b.cmp(a)))?;
                let named = std::iter::once(&body).chain(&members).find_map(|b| bodies[*b].name.clone())?;
                (Carrier { link: named, has_payload: false }, Place { body, at: bodies[body].inertia.centre })
            };
            let columns = self.felt(place.body);
            let candidate = Candidate { carrier, place, bounds: [-described, whole], columns };
            let is_felt = candidate.of_point(&place.at).iter().flatten().any(|v| *v != 0.0);
            is_felt.then_some(candidate)
        };
        mechanism.moving().into_iter().filter_map(candidate).collect()
    }

    /// What each part feels of the inertial parameters of a body.
    fn felt(&self, body: usize) -> [Columns; 10] {
        let mechanism = &self.robot.mechanism;
        // Part, then log, then time.
        let mut all: Vec<Vec<Vec<[f64; 10]>>> = vec![Vec::new(); self.parts.len()];
        for course in self.courses {
            all.iter_mut().for_each(|logs| logs.push(Vec::new()));
            for moving in course.kinematics(mechanism) {
                let torques = regressor(mechanism, &moving, body);
                for (part, logs) in self.parts.iter().zip(&mut all) {
                    let own = torques.iter().find(|(joint, _)| *joint == part.number);
                    if let Some(log) = logs.last_mut() {
                        log.push(own.map_or([0.0; 10], |(_, ten)| *ten));
                    }
                }
            }
        }
        std::array::from_fn(|k| {
            let column = |(part, logs): (&Part, &Vec<Vec<[f64; 10]>>)| {
                let torque: Vec<Vec<f64>> = logs.iter().map(|log| log.iter().map(|ten| ten[k]).collect()).collect();
                part.column(self.courses, &torque, &self.first)
            };
            self.parts.iter().zip(&all).map(column).collect()
        })
    }

    /// The length of the robot \[m\]: of all its bodies, one after the other.
    fn reach(&self) -> f64 {
        self.robot.mechanism.bodies.iter().map(|b| b.placement.translation.vector.norm()).sum()
    }

    /// The mass at a point of a body that suits all parts best.
    fn fitted(&self, candidate: &Candidate, at: Vector3<f64>) -> Placed {
        let columns = candidate.of_point(&at);
        let fit = fit(&self.all(), &[slices(&columns)], false);
        Placed { at, columns, fit }
    }

    fn answer(&self, candidates: &[Candidate]) -> PayloadAnswer {
        let without = fit(&self.all(), &[], false);
        let as_described: Vec<Placed> = candidates.iter().map(|c| self.fitted(c, c.place.at)).collect();
        let last = &as_described[candidates.len() - 1].fit;
        let carrier = candidates[candidates.len() - 1].carrier.clone();
        let felt = Felt { carrier, mass: last.shared[0], error: last.error[0] };
        let possible = |placed: Vec<Option<Placed>>| -> Vec<Option<Placed>> {
            placed.into_iter().zip(candidates).map(|(p, c)| p.filter(|p| c.may_be(&p.fit))).collect()
        };
        let anywhere = possible(candidates.iter().map(|c| self.placed(c)).collect());
        let as_described = possible(as_described.into_iter().map(Some).collect());
        let Some((described, own)) = best(&as_described) else { return PayloadAnswer::Enough(felt) };
        // A place that differs from the described one is worth it only where it is surely better.
        let freest = best(&anywhere).filter(|(_, free)| {
            let gain = (own.fit.left() - free.fit.left()) / without.left();
            gain > 0.5 * WORTH && paired(&own.fit.left_out, &free.fit.left_out) > SURE
        });
        let (index, own, all) = match freest {
            Some((index, own)) => (index, own, &anywhere),
            None => (described, own, &as_described),
        };
        let gain = 1.0 - own.fit.left() / without.left();
        let is_there = own.fit.shared[0].abs() > own.fit.error[0];
        if gain <= WORTH || !is_there {
            return PayloadAnswer::Enough(felt);
        }
        // Others of the same kind that are not surely worse.
        let others = (0..candidates.len()).filter(|k| {
            let is_near = |other: &Placed| paired(&other.fit.left_out, &own.fit.left_out) < WORSE;
            *k != index && all[*k].as_ref().is_some_and(is_near)
        });
        let carriers = std::iter::once(index).chain(others).map(|k| candidates[k].carrier.clone()).collect();
        // What torque constants that are off by a factor would make of it is not known any better.
        let mass = own.fit.shared[0];
        let beside_scales = fit(&self.all(), &[slices(&own.columns)], true).shared[0];
        let named = Named {
            carriers,
            mass,
            error: own.fit.error[0].max((beside_scales - mass).abs()),
            at: own.at.into(),
            is_place_fitted: freest.is_some(),
            gain,
            body: candidates[index].place.body,
            witnesses: self.witnesses(&own.columns, mass),
        };
        match self.doubt(&named, own, &without) {
            Some(why) => PayloadAnswer::Open(named, why),
            None => PayloadAnswer::Named(named),
        }
    }

    /// Why a mass that lowers the error is not named.
    fn doubt(&self, named: &Named, own: &Placed, without: &Fit) -> Option<Asked> {
        let agree = |w: &Witness| (w.mass - named.mass).abs() <= (w.error + named.error).max(AGREE * named.mass.abs());
        let scaled = fit(&self.all(), &[], true);
        let better_than = |other: &Fit| paired(&other.left_out, &own.fit.left_out);
        if named.witnesses.len() < 2 {
            Some(Asked::OneJoint)
        } else if !named.witnesses.iter().all(agree) {
            Some(Asked::Disagree)
        } else if better_than(&scaled) < WORSE {
            Some(Asked::Scales)
        } else if better_than(without) <= SURE {
            Some(Asked::Scatters)
        } else if named.gain < EXPLAINS {
            Some(Asked::LeavesMuch)
        } else {
            None
        }
    }

    /// What each joint alone asks for at a place, of those that say something.
    fn witnesses(&self, columns: &Columns, mass: f64) -> Vec<Witness> {
        let one = |(part, column): (&Part, &Vec<f64>)| {
            if part.size(column) * mass * mass < 1e-4 {
                return None;
            }
            let fit = fit(&[part], &[vec![column.as_slice()]], false);
            let (own, error) = (fit.shared[0], fit.error[0]);
            (error < SAYS * mass.abs()).then_some(Witness { joint: part.joint, mass: own, error })
        };
        self.parts.iter().zip(columns).filter_map(one).collect()
    }

    /// The same mass where it suits best on its body: a point whose inertia follows its place. `None` where no mass with a place
    /// comes of it.
    fn placed(&self, candidate: &Candidate) -> Option<Placed> {
        let mut at = candidate.place.at;
        for round in 0.. {
            // A kilogram that keeps the inertia it has at the place so far, and what moving it does.
            let mut amounts = point_mass(&at);
            amounts[1..4].fill(0.0);
            let kept = candidate.sum(&amounts);
            let shared: Vec<Vec<&[f64]>> = std::iter::once(&kept).chain(&candidate.columns[1..4]).map(slices).collect();
            let found = fit(&self.all(), &shared, false);
            // Without a mass there is no place.
            let mass = found.shared[0];
            if mass.abs() <= found.error[0] {
                return None;
            }
            let next = Vector3::new(found.shared[1], found.shared[2], found.shared[3]) / mass;
            if !next.iter().all(|v| v.is_finite()) || next.norm() > FAR * self.reach() {
                return None;
            }
            if round == ROUNDS || (next - at).norm() < 1e-4 {
                return Some(self.fitted(candidate, next));
            }
            at = next;
        }
        None
    }
}

fn slices(columns: &Columns) -> Vec<&[f64]> {
    columns.iter().map(Vec::as_slice).collect()
}

/// The mass that leaves least, with its number.
fn best(placed: &[Option<Placed>]) -> Option<(usize, &Placed)> {
    let some = placed.iter().enumerate().filter_map(|(k, p)| Some((k, p.as_ref()?)));
    some.min_by(|(_, a), (_, b)| a.fit.left().total_cmp(&b.fit.left()))
}
