//! The front of two quantities: designs at which neither can be had for less without more of the other.
//!
//! For one motor whose program is convex both quantities fall towards their own best ratio and rise
//! beyond it, so its front is exactly the ratios between the two best ones: lowering a bound on one
//! quantity (ε-constraint) moves N along that interval. The front over all motors is what of these
//! curves is not dominated; it is given at points of each curve, the ends included.

use rayon::prelude::*;

use super::answer::Reason;
use super::best::lacking;
use super::evaluate::Judged;
use super::mount::{JointDemand, Mount, Site};
use super::options::{Options, Stop, Stopped};
use super::program::{Certificate, Unsolved};
use super::selection::Selection;
use super::solved::solve;
use super::{Evaluation, Prepared, Unusable, judge};
use crate::actuator::limits::{Candidate, Remark};
use crate::catalog::{Catalog, Motor};
use crate::numerics::grid::grid;
use crate::requirement::{Joint, Objective, Quantity, Robot};

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
/// out of which a limit could not be checked; of the options it, what is called and what stops it count.
///
/// # Errors
/// It was stopped.
pub fn fronts<'a>(
    robot: &'a Robot,
    catalog: &'a Catalog,
    quantities: [Quantity; 2],
    points: usize,
    options: Options,
) -> Result<Vec<Front<'a>>, Stopped> {
    let (stop, only_checked) = (Stop::when(options.stop), options.only_checked);
    let one = |joint: &'a Joint| {
        let demand = JointDemand::new(joint, catalog);
        let asked = Asked { site: Site::new(robot, joint, &demand).stopping(stop), quantities, points, only_checked };
        let curve = |motor: &'a Motor| {
            let curve = asked.curve(motor);
            (options.tick)();
            stop.unless(curve)
        };
        let motors: Vec<&Motor> = catalog.motors.iter().filter(|motor| !joint.motors.pass_over(motor)).collect();
        let curves: Vec<Curve> = motors.par_iter().map(|motor| curve(motor)).collect::<Result<_, _>>()?;
        let mut front = Front { joint, quantities, points: Vec::new(), motors: 0, unjudged: vec![], rejected: vec![] };
        for (motor, curve) in motors.into_iter().zip(curves) {
            match curve {
                Ok(points) => {
                    front.motors += 1;
                    front.points.extend(points);
                }
                Err(Reason::Unjudged(because)) => front.unjudged.push((motor, because)),
                Err(why) => match why.unknown() {
                    Some(remark) => front.unjudged.push((motor, vec![remark])),
                    None => front.rejected.push((motor, why)),
                },
            }
        }
        front.points = not_dominated(front.points);
        Ok(front)
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
    site: Site<'a, 'd>,
    quantities: [Quantity; 2],
    points: usize,
    only_checked: bool,
}

impl<'a> Asked<'a, '_> {
    /// The points of one motor.
    fn curve(&self, motor: &'a Motor) -> Curve<'a> {
        let durations = self.site.demand.load.duration.is_some();
        if let Some(why) = lacking(motor, durations, |quantity| self.quantities.contains(&quantity)) {
            return Err(Reason::Unusable(why));
        }
        if self.site.is_geared_with(motor) { self.of_gears(motor) } else { self.of_ratios(self.site.direct(motor)) }
    }

    /// The gate: why a design is not on a front, from what is not known of it.
    fn judge(&self, unchecked: &[Remark]) -> Result<(), Reason> {
        if let Some(why) = self.left_out(unchecked) {
            return Err(why);
        }
        match judge::unjudged(self.site.robot, self.site.joint, unchecked) {
            because if because.is_empty() => Ok(()),
            because => Err(Reason::Unjudged(because)),
        }
    }

    /// Why something with these unknowns is not looked at.
    fn left_out(&self, unchecked: &[Remark]) -> Option<Reason> {
        let what = judge::left_out(self.site.robot, self.site.joint, unchecked, self.only_checked);
        what.map(|(limit, why)| Reason::Unchecked(limit, why))
    }

    fn at(&self, mount: &Mount<'a, '_>, prepared: &Prepared, ratio: f64, certified: bool) -> Option<FrontPoint<'a>> {
        let evaluation = prepared.at(ratio);
        let values = self.quantities.map(|q| value(prepared, &evaluation, q));
        match values {
            [Some(a), Some(b)] if evaluation.feasible => {
                let Judged { unchecked, assumed } = prepared.judged(ratio);
                let (motor, gear) = (mount.motor, mount.gear_id());
                Some(FrontPoint { motor, gear, values: [a, b], evaluation, certified, unchecked, assumed })
            }
            _ => None,
        }
    }

    fn of_ratios(&self, mount: Mount<'a, '_>) -> Curve<'a> {
        let prepared = mount.prepared().map_err(Reason::Unusable)?;
        let Some(range) = mount.range() else { return Err(Reason::Unusable(Unusable::NoGearFits)) };
        if let Some(why) = self.left_out(&prepared.unchecked) {
            return Err(why);
        }
        let best = self.quantities.map(|quantity| {
            let joint = Joint { objective: Objective::single(quantity), ..mount.joint.clone() };
            let own = Prepared::new(Candidate { joint: &joint, ..prepared.candidate }).stopping(mount.stop);
            solve(&own, &joint, range).map(|optimum| judge::judged_part(&own, optimum, self.only_checked))
        });
        let [a, b] = best;
        let (a, b) = (a?, b?);
        let certified = [&a, &b].iter().all(|o| matches!(o.certificate, Certificate::Certified { .. }));
        let convex = a.windows.len() == 1 && !prepared.candidate.has_odd_powers() && !prepared.candidate.is_evaluated();
        let (from, to) = (a.ratio.min(b.ratio), a.ratio.max(b.ratio));
        let count = if to > from * (1.0 + 1e-12) { self.points.max(2) } else { 1 };
        let listed = mount.joint.ratio.listed();
        let ratios = match listed {
            // All of them: what is dominated is left out, and that all are evaluated is the proof.
            Some(values) => values.to_vec(),
            None if count == 1 => vec![a.ratio],
            None => grid(from, to, count),
        };
        let proved = certified && (convex || listed.is_some());
        let points: Vec<FrontPoint> =
            ratios.into_iter().filter_map(|n| self.at(&mount, &prepared, n, proved)).collect();
        if points.is_empty() {
            let unknown = prepared.candidate.mass_at(range.0).is_none() && self.quantities.contains(&Quantity::Mass);
            let not = || Reason::NotSolved(Unsolved::NoneBetween);
            return Err(if unknown { Reason::Unusable(Unusable::Mass) } else { not() });
        }
        self.judged(points)
    }

    fn of_gears(&self, motor: &'a Motor) -> Curve<'a> {
        let mut gears: Selection<()> = Selection::new(motor);
        let mut points = Vec::new();
        for mount in self.site.mounts(motor) {
            let Some(gear) = mount.gear else { continue };
            let prepared = match mount.prepared() {
                Ok(prepared) => prepared,
                Err(why) => {
                    gears.unusable(why);
                    continue;
                }
            };
            if let Some(what) = judge::left_out(mount.robot, mount.joint, &prepared.unchecked, self.only_checked) {
                gears.unchecked(&gear.id, what);
                continue;
            }
            let evaluation = prepared.at(gear.ratio);
            match self.at(&mount, &prepared, gear.ratio, true) {
                Some(point) => {
                    gears.take(false, (0.0, 0.0), ());
                    points.push(point);
                }
                None if evaluation.feasible => gears.unusable(Unusable::Mass),
                None => gears.exceeds(&gear.id, evaluation.tightest()),
            }
        }
        gears.best()?;
        self.judged(points)
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
