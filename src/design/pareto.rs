//! The front of two quantities: designs at which neither can be had for less without more of the other.
//!
//! For one motor whose program is convex both quantities fall towards their own best ratio and rise
//! beyond it, so its front is exactly the ratios between the two best ones: lowering a bound on one
//! quantity (ε-constraint) moves N along that interval. The front over all motors is what of these
//! curves is not dominated; it is given at points of each curve, the ends included.

use rayon::prelude::*;

use super::program::{Certificate, Outcome, RatioProgram};
use super::sweep::grid;
use super::{Evaluation, JointDemand, Prepared, continuous_candidate, geared_candidate};
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
    /// Number of motors that have a feasible design.
    pub motors: usize,
}

/// The fronts of all joints, with `points` ratios along the curve of each motor.
pub fn fronts<'a>(robot: &'a Robot, catalog: &'a Catalog, quantities: [Quantity; 2], points: usize) -> Vec<Front<'a>> {
    let one = |joint: &'a Joint| {
        let demand = JointDemand::new(joint, catalog);
        let curves: Vec<Vec<FrontPoint>> =
            catalog.motors.par_iter().map(|motor| curve(robot, joint, &demand, motor, quantities, points)).collect();
        let motors = curves.iter().filter(|c| !c.is_empty()).count();
        Front { joint, quantities, points: not_dominated(curves.into_iter().flatten().collect()), motors }
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

fn curve<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    quantities: [Quantity; 2],
    points: usize,
) -> Vec<FrontPoint<'a>> {
    let at = |prepared: &Prepared, ratio: f64, gear, certified| {
        let evaluation = prepared.at(ratio);
        let values = quantities.map(|q| value(prepared, &evaluation, q));
        match values {
            [Some(a), Some(b)] if evaluation.feasible => {
                Some(FrontPoint { motor, gear, values: [a, b], evaluation, certified })
            }
            _ => None,
        }
    };
    match &joint.ratio {
        RatioChoice::Continuous { min, max } => {
            let Ok(candidate) = continuous_candidate(robot, joint, &demand.load, motor) else { return Vec::new() };
            let prepared = Prepared::new(candidate);
            let best = quantities.map(|quantity| {
                let objective = Objective::single(quantity);
                match RatioProgram::new(&prepared, &objective, *min, *max).solve() {
                    Outcome::Optimal(optimum) => Some(optimum),
                    _ => None,
                }
            });
            let [Some(a), Some(b)] = best else { return Vec::new() };
            let certified = [&a, &b].iter().all(|o| matches!(o.certificate, Certificate::Certified { .. }));
            let convex = a.windows.len() == 1
                && !prepared.candidate.actuator.has_odd_powers()
                && !prepared.candidate.is_evaluated();
            let (from, to) = (a.ratio.min(b.ratio), a.ratio.max(b.ratio));
            let count = if to > from * (1.0 + 1e-12) { points.max(2) } else { 1 };
            let ratios = if count == 1 { vec![a.ratio] } else { grid(from, to, count) };
            ratios.into_iter().filter_map(|n| at(&prepared, n, None, certified && convex)).collect()
        }
        RatioChoice::Catalog { .. } => demand
            .gears_for(motor)
            .filter_map(|(gear, load)| {
                let candidate = geared_candidate(robot, joint, load, motor, gear).ok()?;
                at(&Prepared::new(candidate), gear.ratio, Some(gear.id.as_str()), true)
            })
            .collect(),
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
