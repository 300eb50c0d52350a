//! The front of two quantities: designs at which neither can be had for less without more of the other.
//!
//! For one motor whose program is convex both quantities fall towards their own best ratio and rise
//! beyond it, so its front is exactly the ratios between the two best ones: lowering a bound on one
//! quantity (ε-constraint) moves N along that interval. The front over all motors is what of these
//! curves is not dominated; it is given at points of each curve, the ends included.

use rayon::prelude::*;

use super::evaluate::Judged;
use super::judge;
use super::optimize::{Reason, solve};
use super::program::{Bind, Certificate};
use super::sweep::grid;
use super::{Evaluation, JointDemand, Prepared, Unusable, continuous_candidate, geared_candidate};
use crate::actuator::limits::{Candidate, Remark};
use crate::catalog::{Catalog, Motor};
use crate::requirement::{Joint, Objective, Quantity, RatioChoice, Robot};

/// A design on the front.
#[derive(Debug, Clone)]
pub struct FrontPoint<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The two quantities, SI.
    pub values: [f64; 2],
    /// The design.
    pub evaluation: Evaluation,
    /// Whether the motor's own front is proved: both best ratios are certified.
    pub certified: bool,
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
}

/// The front at one joint.
#[derive(Debug)]
pub struct Front<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// The quantities.
    pub quantities: [Quantity; 2],
    /// Designs, the best in the first quantity first.
    pub points: Vec<FrontPoint<'a>>,
    /// Number of motors that have a feasible design of which every stated limit could be judged.
    pub motors: usize,
    /// Motors that keep all that could be judged, and of which a limit that the requirement states could not.
    pub unjudged: Vec<(&'a Motor, Vec<Remark>)>,
    /// Motors without a point, and why.
    pub rejected: Vec<(&'a Motor, Reason)>,
}

/// The curve of a motor; else why it has none.
type Curve<'a> = Result<Vec<FrontPoint<'a>>, Reason>;

/// The fronts of all joints, with `points` ratios along the curve of each motor. With `only_checked` motors are left
/// out of which a limit could not be checked.
pub fn fronts<'a>(
    robot: &'a Robot,
    catalog: &'a Catalog,
    quantities: [Quantity; 2],
    points: usize,
    only_checked: bool,
) -> Vec<Front<'a>> {
    let one = |joint: &'a Joint| {
        let demand = JointDemand::new(joint, catalog);
        let asked = Asked { robot, joint, demand: &demand, quantities, points, only_checked };
        let curves: Vec<Curve> = catalog.motors.par_iter().map(|motor| asked.curve(motor)).collect();
        let mut front = Front { joint, quantities, points: Vec::new(), motors: 0, unjudged: vec![], rejected: vec![] };
        for (motor, curve) in catalog.motors.iter().zip(curves) {
            match curve {
                Ok(points) => {
                    front.motors += 1;
                    front.points.extend(points);
                }
                Err(Reason::Unjudged(because)) => front.unjudged.push((motor, because)),
                Err(why) => front.rejected.push((motor, why)),
            }
        }
        front.points = not_dominated(front.points);
        front
    };
    robot.joints.iter().map(one).collect()
}

fn value(prepared: &Prepared, evaluation: &Evaluation, quantity: Quantity) -> Option<f64> {
    match quantity {
        Quantity::Energy => prepared.energy(evaluation.ratio),
        Quantity::PeakPower => Some(prepared.peak_power(evaluation.ratio)),
        other => evaluation.quantity(other),
    }
}

/// What a front is asked for.
struct Asked<'a, 'd> {
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &'d JointDemand<'a>,
    quantities: [Quantity; 2],
    points: usize,
    only_checked: bool,
}

impl<'a> Asked<'a, '_> {
    /// The points of one motor.
    fn curve(&self, motor: &'a Motor) -> Curve<'a> {
        for (quantity, unusable) in [(Quantity::Mass, Unusable::Mass), (Quantity::Energy, Unusable::Durations)] {
            let known = match quantity {
                Quantity::Mass => motor.mass.is_some(),
                _ => self.demand.load.has_durations,
            };
            if self.quantities.contains(&quantity) && !known {
                return Err(Reason::Unusable(unusable));
            }
        }
        match &self.joint.ratio {
            RatioChoice::Continuous { min, max } => self.of_ratios(motor, (*min, *max)),
            RatioChoice::Catalog { .. } => self.of_gears(motor),
        }
    }

    /// The gate: why a design is not on a front, from what is not known of it.
    fn judge(&self, unchecked: &[Remark]) -> Result<(), Reason> {
        if let Some(why) = self.left_out(unchecked) {
            return Err(why);
        }
        match judge::unjudged(self.robot, self.joint, unchecked) {
            because if because.is_empty() => Ok(()),
            because => Err(Reason::Unjudged(because)),
        }
    }

    /// Why something with these unknowns is not looked at.
    fn left_out(&self, unchecked: &[Remark]) -> Option<Reason> {
        let what = judge::left_out(self.robot, self.joint, unchecked, self.only_checked);
        what.map(|(limit, why)| Reason::Unchecked(limit, why))
    }

    fn at(
        &self,
        prepared: &Prepared,
        motor: &'a Motor,
        ratio: f64,
        gear: Option<&'a str>,
        certified: bool,
    ) -> Option<FrontPoint<'a>> {
        let evaluation = prepared.at(ratio);
        let values = self.quantities.map(|q| value(prepared, &evaluation, q));
        match values {
            [Some(a), Some(b)] if evaluation.feasible => {
                let Judged { unchecked, assumed } = prepared.judged(ratio);
                Some(FrontPoint { motor, gear, values: [a, b], evaluation, certified, unchecked, assumed })
            }
            _ => None,
        }
    }

    fn of_ratios(&self, motor: &'a Motor, range: (f64, f64)) -> Curve<'a> {
        let candidate =
            continuous_candidate(self.robot, self.joint, &self.demand.load, motor).map_err(Reason::Unusable)?;
        let prepared = Prepared::new(candidate);
        if let Some(why) = self.left_out(&prepared.unchecked) {
            return Err(why);
        }
        let best = self.quantities.map(|quantity| {
            let joint = Joint { objective: Objective::single(quantity), ..self.joint.clone() };
            let own = Prepared::new(Candidate { joint: &joint, ..prepared.candidate });
            solve(&own, &joint, range).map(|optimum| judge::judged_part(&own, optimum, self.only_checked))
        });
        let [a, b] = best;
        let (a, b) = (a?, b?);
        let certified = [&a, &b].iter().all(|o| matches!(o.certificate, Certificate::Certified { .. }));
        let convex =
            a.windows.len() == 1 && !prepared.candidate.actuator.has_odd_powers() && !prepared.candidate.is_evaluated();
        let (from, to) = (a.ratio.min(b.ratio), a.ratio.max(b.ratio));
        let count = if to > from * (1.0 + 1e-12) { self.points.max(2) } else { 1 };
        let ratios = if count == 1 { vec![a.ratio] } else { grid(from, to, count) };
        let points: Vec<FrontPoint> =
            ratios.into_iter().filter_map(|n| self.at(&prepared, motor, n, None, certified && convex)).collect();
        if points.is_empty() {
            let unknown = prepared.candidate.mass_at(range.0).is_none() && self.quantities.contains(&Quantity::Mass);
            let not = || Reason::NotSolved("no ratio between the two best ones keeps every limit".into());
            return Err(if unknown { Reason::Unusable(Unusable::Mass) } else { not() });
        }
        self.judged(points)
    }

    fn of_gears(&self, motor: &'a Motor) -> Curve<'a> {
        let mut why = Reason::Unusable(Unusable::NoGearFits);
        let mut nearest: Option<(f64, Reason)> = None;
        let mut tried = 0;
        let mut points = Vec::new();
        for (gear, load) in self.demand.gears_for(motor) {
            let candidate = match geared_candidate(self.robot, self.joint, load, motor, gear) {
                Ok(candidate) => candidate,
                Err(unusable) => {
                    why = Reason::Unusable(unusable);
                    continue;
                }
            };
            let prepared = Prepared::new(candidate);
            if let Some(reason) = self.left_out(&prepared.unchecked) {
                why = reason;
                continue;
            }
            let evaluation = prepared.at(gear.ratio);
            if let Some(point) = self.at(&prepared, motor, gear.ratio, Some(gear.id.as_str()), true) {
                points.push(point);
            } else if evaluation.feasible {
                why = Reason::Unusable(Unusable::Mass);
                continue;
            } else if let Some(worst) = evaluation.tightest()
                && nearest.as_ref().is_none_or(|(margin, _)| worst.margin > *margin)
            {
                let bind = Bind::of(worst.limit, worst.sample);
                let (over, allowed) = (worst.demand / worst.bound, worst.bound);
                nearest = Some((worst.margin, Reason::Gears { bind, over, allowed, tried }));
            }
            tried += 1;
        }
        match (points.is_empty(), nearest) {
            (false, _) => self.judged(points),
            (true, Some((_, Reason::Gears { bind, over, allowed, .. }))) => {
                Err(Reason::Gears { bind, over, allowed, tried })
            }
            (true, _) => Err(why),
        }
    }

    /// The points that can be judged; where there are none, why.
    fn judged(&self, points: Vec<FrontPoint<'a>>) -> Curve<'a> {
        let mut refused = None;
        let mut judged = Vec::with_capacity(points.len());
        for point in points {
            match self.judge(&point.unchecked) {
                Ok(()) => judged.push(point),
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        match refused {
            Some(why) if judged.is_empty() => Err(why),
            _ => Ok(judged),
        }
    }
}

/// Keeps what no other point betters in both quantities.
fn not_dominated(mut points: Vec<FrontPoint>) -> Vec<FrontPoint> {
    points.sort_by(|x, y| {
        x.values[0]
            .total_cmp(&y.values[0])
            .then(x.values[1].total_cmp(&y.values[1]))
            .then_with(|| x.motor.id.cmp(&y.motor.id))
            .then(x.evaluation.ratio.total_cmp(&y.evaluation.ratio))
    });
    let mut least = f64::INFINITY;
    points.retain(|p| {
        let better = p.values[1] < least;
        least = least.min(p.values[1]);
        better
    });
    points
}
