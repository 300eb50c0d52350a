//! Designs that keep their limits for every motor within its tolerances.
//!
//! The one idea: the worst motor within the box of tolerances stands at a corner of the box, for each limit
//! at its own corner, so the robust program is the nominal objective under the rows of the corners.
//! Why a corner, at any fixed ratio and sample:
//!
//! * Shaft torque T and its rate are affine in J, b, c. |T| and the mean of T² are convex in them, and fall
//!   with K_T where they are currents: largest at a corner.
//! * `v_q = (R T + L Ṫ)/K_T + K_B N ω` and `v_d = −p N ω L T/K_T` are affine in each of R, L, 1/K_T, K_B, J, b, c
//!   alone, so `v_q² + v_d²` is convex in each alone: largest at a corner. Where K_B was taken from K_T (or K_T
//!   from K_B) they are one number K, and `a²/K² + 2 a e + e² K² + d²/K²` is convex in K.
//! * Bus power `R T²/K_T² + K_B N ω T/K_T` rises with R and is convex in each of the others alone.
//! * Ratings, highest temperatures and thermal resistances (steady state) are monotone: the worse end.
//!
//! The largest over samples, phases and means of such functions are such functions. **Not proved** are two
//! cases, and they are marked so: a regeneration limit, whose −P is concave in T (its largest may lie
//! between the corners), and the winding's temperature over the motion in the time constants and in the
//! resistance from winding to housing; there corners and the nominal motor are looked at. Efficiency,
//! load and bus have no tolerances here.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::evaluate::Judged;
use super::judge;
use super::optimize::{Design, JointResult, Options, Reason, RobotResult, optimize_with};
use super::program::{Bind, Certificate, Limited, Optimum, Outcome, RatioProgram, Window};
use super::{Evaluation, JointDemand, Prepared, Unusable, continuous_candidate, geared_candidate};
use crate::actuator::limits::{Candidate, Remark, hottest};
use crate::catalog::{Catalog, FIELDS, Field, Identity, Motor, Printed};
use crate::requirement::{Joint, RatioChoice, Regeneration, Robot};

use super::evaluate::{FEASIBILITY_TOLERANCE, Margin};

/// How many samples of the motors a probability rests on.
pub const SAMPLES: usize = 1000;
/// How many motors of the nominal order are compared with each other.
pub const CONTENDERS: usize = 5;

/// Which end of a tolerance is the worse one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Worst {
    Low,
    High,
    /// It depends on the limit, the sample and the ratio.
    Either,
}

/// The columns of a sheet that limits depend on. A speed constant counts where it is the only source of a
/// back-EMF constant.
const COLUMNS: &[(&str, Worst)] = &[
    ("resistance", Worst::Either),
    ("inductance", Worst::Either),
    ("torque_constant", Worst::Either),
    ("back_emf_constant", Worst::Either),
    ("speed_constant", Worst::Either),
    ("rotor_inertia", Worst::Either),
    ("viscous_friction", Worst::Either),
    ("coulomb_friction", Worst::Either),
    ("thermal_resistance_winding_housing", Worst::Either),
    ("thermal_resistance_housing_ambient", Worst::High),
    ("thermal_time_constant_winding", Worst::Either),
    ("thermal_time_constant_housing", Worst::Either),
    ("max_winding_temperature", Worst::Low),
    ("reference_temperature", Worst::Low),
    ("continuous_current", Worst::Low),
    ("peak_current", Worst::Low),
    ("continuous_torque", Worst::Low),
    ("peak_torque", Worst::Low),
    ("max_speed", Worst::Low),
    ("mass", Worst::High),
];

/// A number of the sheet with a tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toleranced {
    /// Column of the catalogue.
    pub column: &'static str,
    /// The printed number, SI, in the sheet's convention.
    pub value: f64,
    /// Its ±, in the same unit.
    pub tolerance: f64,
    worst: Worst,
}

impl Toleranced {
    /// The ends of the tolerance; what cannot be negative ends at zero.
    fn ends(&self) -> [f64; 2] {
        [(self.value - self.tolerance).max(0.0), self.value + self.tolerance]
    }

    /// Whether zero is out of the question for the number, and the tolerance reaches it.
    fn reaches_zero(&self) -> bool {
        let may_be_zero = matches!(self.column, "inductance" | "viscous_friction" | "coulomb_friction");
        !may_be_zero && self.tolerance >= self.value
    }
}

fn field(column: &str) -> &'static Field {
    FIELDS.iter().find(|f| f.name == column).expect("a column of the sheet")
}

/// The numbers of a motor that have a tolerance, as far as limits depend on them.
pub fn toleranced(motor: &Motor) -> Vec<Toleranced> {
    let sheet = &motor.sheet;
    let counts = |column: &str| match column {
        "speed_constant" => sheet.back_emf_constant.is_none(),
        "inductance" => motor.inductance.is_some(),
        _ => true,
    };
    let of = |(column, worst): &(&'static str, Worst)| {
        let printed = (field(column).get)(sheet)?;
        let tolerance = printed.tolerance.filter(|t| *t > 0.0)?;
        counts(column).then_some(Toleranced { column, value: printed.value, tolerance, worst: *worst })
    };
    COLUMNS.iter().filter_map(of).collect()
}

/// The same motor with other numbers in its sheet; `None` where they make no motor.
fn with_numbers(motor: &Motor, numbers: impl Iterator<Item = (&'static str, f64)>) -> Option<Motor> {
    let mut sheet = motor.sheet.clone();
    for (column, value) in numbers {
        (field(column).set)(&mut sheet, Printed { value, tolerance: None });
    }
    let identity = Identity {
        id: motor.id.clone(),
        manufacturer: motor.manufacturer.clone(),
        model: motor.model.clone(),
        source: motor.source.clone(),
        source_kind: motor.source_kind,
        note: motor.note.clone(),
        accepted_findings: motor.accepted_findings.clone(),
    };
    let other = Motor::new(identity, motor.conventions, sheet, motor.pole_pairs).ok()?;
    Some(Motor { effects: motor.effects.clone(), fitted_gear: motor.fitted_gear, fit: motor.fit.clone(), ..other })
}

/// A corner of the box of tolerances.
#[derive(Debug, Clone)]
pub struct Corner {
    /// Each column with whether its upper end is taken.
    pub ends: Vec<(&'static str, bool)>,
    /// The motor there.
    pub motor: Motor,
}

/// The corners of the box that some limit may need, in a fixed order. A single one, the motor itself,
/// where nothing has a tolerance.
///
/// # Errors
/// The column whose tolerance reaches zero, where that makes no motor.
pub fn corners(motor: &Motor) -> Result<Vec<Corner>, &'static str> {
    let all = toleranced(motor);
    if let Some(wide) = all.iter().find(|t| t.reaches_zero()) {
        return Err(wide.column);
    }
    let free: Vec<usize> = (0..all.len()).filter(|i| all[*i].worst == Worst::Either).collect();
    let corner = |bits: usize| {
        let upper = |i: usize| match all[i].worst {
            Worst::Low => false,
            Worst::High => true,
            Worst::Either => free.iter().position(|f| *f == i).is_some_and(|place| bits >> place & 1 == 1),
        };
        let ends: Vec<(&'static str, bool)> = (0..all.len()).map(|i| (all[i].column, upper(i))).collect();
        let numbers = (0..all.len()).map(|i| (all[i].column, all[i].ends()[usize::from(upper(i))]));
        Some(Corner { motor: with_numbers(motor, numbers)?, ends })
    };
    (0..1_usize << free.len()).map(corner).collect::<Option<Vec<_>>>().ok_or("the sheet")
}

/// Whether a limit needs a corner: of the columns that do not matter to it, or whose worse end is known
/// for it, only one end.
fn needs(limit: &str, corner: &Corner, motor: &Motor) -> bool {
    let sheet = &motor.sheet;
    // The column that K_T comes from, and whether K_T rises with it.
    let (k_t, rising) = match (sheet.torque_constant, sheet.back_emf_constant) {
        (Some(_), _) => ("torque_constant", true),
        (None, Some(_)) => ("back_emf_constant", true),
        (None, None) => ("speed_constant", false),
    };
    let constants = ["torque_constant", "back_emf_constant", "speed_constant"];
    let free = |column: &str| matches!(column, "rotor_inertia" | "viscous_friction" | "coulomb_friction");
    corner.ends.iter().all(|(column, upper)| {
        let column = *column;
        // `None`: both ends.
        let end = match limit {
            "peak_current"
            | "continuous_current"
            | "standstill_holding"
            | "winding_temperature"
            | "torque_bandwidth_current" => match column {
                _ if free(column) => None,
                "resistance" | "thermal_resistance_winding_housing" => Some(true),
                _ if column == k_t => Some(!rising),
                _ => Some(false),
            },
            "winding_peak_temperature" => match column {
                _ if free(column) || column.starts_with("thermal_") => None,
                "resistance" => Some(true),
                _ if column == k_t => Some(!rising),
                _ => Some(false),
            },
            "peak_torque" | "continuous_torque" => (!free(column)).then_some(false),
            "voltage" | "torque_bandwidth_voltage" => {
                let matters =
                    free(column) || constants.contains(&column) || matches!(column, "resistance" | "inductance");
                (!matters).then_some(false)
            }
            "bus_power" | "bus_current" | "regeneration" => match column {
                "resistance" => Some(limit != "regeneration"),
                _ if free(column) || constants.contains(&column) => None,
                _ => Some(false),
            },
            "reflected_inertia" => Some(column == "rotor_inertia"),
            "max_speed" | "gear_input_speed" | "gear_peak_torque" | "gear_continuous_torque" | "actuator_mass" => {
                Some(false)
            }
            _ => None,
        };
        let fixed = COLUMNS.iter().any(|(name, worst)| *name == column && *worst != Worst::Either);
        fixed || end.is_none_or(|end| end == *upper)
    })
}

/// The limits of a box: those of the corners that each needs, and of the nominal motor where corners do not
/// prove it.
fn limits_of<'p>(nominal: &'p Prepared<'p>, corners: &'p [(Prepared<'p>, Corner)]) -> Vec<Limited<'p>> {
    let motor = nominal.candidate.motor;
    let mut limits = Vec::new();
    for (prepared, corner) in corners {
        let wanted = prepared.asked.iter().filter(|a| needs(a.limit.name, corner, motor));
        limits.extend(wanted.map(|asked| Limited { candidate: &prepared.candidate, asked }));
    }
    let unproved = nominal.asked.iter().filter(|a| matches!(a.limit.name, "regeneration" | "winding_peak_temperature"));
    limits.extend(unproved.map(|asked| Limited { candidate: &nominal.candidate, asked }));
    limits
}

/// Why corners do not prove that the whole box keeps the limits, where they do not.
fn unproved(robot: &Robot, nominal: &Prepared, all: &[Toleranced]) -> Option<&'static str> {
    let has = |names: &[&str]| all.iter().any(|t| names.contains(&t.column));
    let asked = |name: &str| nominal.asked.iter().any(|a| a.limit.name == name);
    let of_power = [
        "torque_constant",
        "back_emf_constant",
        "speed_constant",
        "rotor_inertia",
        "viscous_friction",
        "coulomb_friction",
    ];
    let thermal =
        ["thermal_resistance_winding_housing", "thermal_time_constant_winding", "thermal_time_constant_housing"];
    if matches!(robot.bus.regeneration, Regeneration::Limited(_)) && has(&of_power) {
        return Some("power that comes back may be largest between the corners of the tolerances");
    }
    let Candidate { motor, joint, .. } = nominal.candidate;
    let settles = hottest(motor, joint).is_none() && motor.thermal_resistance.is_some();
    let by_rating = settles && has(&["continuous_current"]);
    if has(&["max_winding_temperature"]) || by_rating {
        return Some(
            "voltage takes the winding at its hottest, which the other end of its tolerance would make hotter",
        );
    }
    if asked("winding_peak_temperature") && has(&thermal) {
        return Some("temperature over the motion may be highest between the ends of the thermal tolerances");
    }
    None
}

/// A design that keeps its limits over the whole box of tolerances.
#[derive(Debug, Clone)]
pub struct RobustDesign<'a> {
    /// The design for the printed numbers.
    pub nominal: Design<'a>,
    /// The numbers that have a tolerance; none: the design is the nominal one.
    pub toleranced: Vec<Toleranced>,
    /// How many corners of the box were looked at.
    pub corners: usize,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The best ratio that keeps all limits at all corners: least objective for the printed numbers.
    pub optimum: Optimum,
    /// The printed numbers at that ratio.
    pub evaluation: Evaluation,
    /// The largest objective at a corner, at that ratio.
    pub worst_objective: f64,
    /// The smallest margin at a corner, at that ratio.
    pub tightest: Option<Margin>,
    /// Limits that could not be checked at that ratio, of the printed numbers or at a corner, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept there, and as far as what holds.
    pub assumed: Vec<Remark>,
}

/// A motor that can do it by its printed numbers, but not over its tolerances.
#[derive(Debug, Clone)]
pub struct Lost<'a> {
    /// The nominal design.
    pub nominal: Design<'a>,
    /// Why no ratio keeps the limits at all corners.
    pub reason: Reason,
}

/// How a motor of the nominal order fares among the others when all motors vary within their tolerances.
#[derive(Debug, Clone)]
pub struct Contender<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Nominal ratio, and the robust one where there is one.
    pub ratios: (f64, Option<f64>),
    /// Share of the samples that keep all limits at the nominal ratio.
    pub feasible_nominal: f64,
    /// Share of the samples that keep all limits at the robust ratio.
    pub feasible_robust: Option<f64>,
    /// Share of the samples in which it is feasible and best, all at their nominal ratios.
    pub first_nominal: f64,
    /// The same with all at their robust ratios, where they have one.
    pub first_robust: f64,
}

/// What was found for a joint.
#[derive(Debug)]
pub struct RobustJoint<'a> {
    /// The nominal result.
    pub nominal: JointResult<'a>,
    /// Robust designs, least nominal objective at their ratio first.
    pub designs: Vec<RobustDesign<'a>>,
    /// Motors that are lost to their tolerances, in the nominal order.
    pub lost: Vec<Lost<'a>>,
    /// The first motors of the nominal order among each other.
    pub contenders: Vec<Contender<'a>>,
}

/// Standard error of a share that was found in [`SAMPLES`] samples.
pub fn standard_error(share: f64) -> f64 {
    (share * (1.0 - share) / SAMPLES as f64).sqrt()
}

/// Robust designs for every joint of a robot.
pub fn robust<'a>(robot: &'a Robot, catalog: &'a Catalog, options: Options) -> Vec<RobustJoint<'a>> {
    let RobotResult { joints, .. } = optimize_with(robot, catalog, options);
    let solve = |nominal: JointResult<'a>| {
        let joint = nominal.joint;
        let demand = JointDemand::new(joint, catalog);
        let found: Vec<Result<RobustDesign, Reason>> = nominal
            .candidates
            .par_iter()
            .map(|design| best_robust(robot, joint, &demand, design, options.only_checked))
            .collect();
        let (mut designs, mut lost) = (Vec::new(), Vec::new());
        for (design, result) in nominal.candidates.iter().zip(found) {
            match result {
                Ok(design) => designs.push(design),
                Err(reason) => lost.push(Lost { nominal: design.clone(), reason }),
            }
        }
        designs.sort_by(|a: &RobustDesign, b| {
            a.optimum
                .objective
                .total_cmp(&b.optimum.objective)
                .then(a.evaluation.loss.total_cmp(&b.evaluation.loss))
                .then(a.nominal.motor.id.cmp(&b.nominal.motor.id))
        });
        let contenders = contenders(robot, joint, &demand, &nominal.candidates, &designs, options.only_checked);
        RobustJoint { nominal, designs, lost, contenders }
    };
    joints.into_iter().map(solve).collect()
}

/// A motor in place of the one of the catalogue, with the same gear.
fn candidate<'p>(
    robot: &'p Robot,
    joint: &'p Joint,
    demand: &'p JointDemand<'_>,
    motor: &'p Motor,
    gear: Option<&str>,
) -> Result<Candidate<'p>, Unusable> {
    match gear {
        None => continuous_candidate(robot, joint, &demand.load, motor),
        Some(id) => {
            let (gear, load) = demand.gears_for(motor).find(|(g, _)| g.id == id).ok_or(Unusable::NoGearFits)?;
            geared_candidate(robot, joint, load, motor, gear)
        }
    }
}

/// The design of a motor that keeps all limits over its tolerances; with `only_checked`, one of which every limit could
/// be checked.
///
/// # Errors
/// Why no ratio does.
pub fn best_robust<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    nominal: &Design<'a>,
    only_checked: bool,
) -> Result<RobustDesign<'a>, Reason> {
    let motor = nominal.motor;
    let all = toleranced(motor);
    if all.is_empty() {
        return Ok(RobustDesign {
            nominal: nominal.clone(),
            toleranced: all,
            corners: 0,
            gear: nominal.gear,
            optimum: nominal.optimum.clone(),
            evaluation: nominal.evaluation.clone(),
            worst_objective: nominal.optimum.objective,
            tightest: nominal.evaluation.tightest().copied(),
            unchecked: nominal.unchecked.clone(),
            assumed: nominal.assumed.clone(),
        });
    }
    let corners =
        corners(motor).map_err(|column| Reason::NotSolved(format!("the tolerance of {column} reaches zero")))?;
    match &joint.ratio {
        RatioChoice::Continuous { min, max } => {
            let boxed = Boxed::new(robot, joint, demand, motor, &corners, None).map_err(Reason::Unusable)?;
            let limits = limits_of(&boxed.nominal, &boxed.corners);
            let program = RatioProgram::under(&boxed.nominal, &joint.objective, (*min, *max), limits);
            let mut optimum = match program.solve() {
                Outcome::Optimal(optimum) => optimum,
                Outcome::Infeasible(why) => return Err(Reason::Infeasible(why)),
                Outcome::Unbounded => return Err(Reason::Unbounded),
                Outcome::NotSolved(why) => return Err(Reason::NotSolved(why)),
            };
            if let Some(why) = unproved(robot, &boxed.nominal, &all) {
                optimum.certificate = Certificate::NotCertified(why.into());
            }
            if judge::may_change(&boxed.nominal, only_checked) {
                optimum = judge::within(&boxed.nominal, optimum, &|ratio| boxed.doubt(ratio, only_checked));
                if let Some(doubt) = boxed.doubt(optimum.ratio, only_checked) {
                    return Err(Reason::Unjudged(vec![doubt]));
                }
            }
            Ok(boxed.design(nominal, all, None, optimum))
        }
        RatioChoice::Catalog { .. } => {
            let mut best: Option<RobustDesign> = None;
            let mut nearest: Option<(f64, Bind, f64, f64)> = None;
            let mut doubted = None;
            let mut tried = 0;
            for (gear, _) in demand.gears_for(motor) {
                let Ok(boxed) = Boxed::new(robot, joint, demand, motor, &corners, Some(&gear.id)) else { continue };
                // With another gear than the nominal one other limits may be unknown.
                if let Some(doubt) = boxed.doubt(gear.ratio, only_checked) {
                    doubted = doubted.or(Some(doubt));
                    continue;
                }
                tried += 1;
                let tightest = boxed.tightest(gear.ratio);
                if let Some(margin) = tightest.filter(|m| m.margin < -FEASIBILITY_TOLERANCE) {
                    if nearest.as_ref().is_none_or(|(m, ..)| margin.margin > *m) {
                        let bind = Bind::of(margin.limit, margin.sample);
                        nearest = Some((margin.margin, bind, margin.demand / margin.bound, margin.bound));
                    }
                    continue;
                }
                let Some(objective) = boxed.nominal.at(gear.ratio).objective(&joint.objective) else { continue };
                let bind = Bind::of("gear", None);
                let method = "all gears evaluated";
                let certificate = match unproved(robot, &boxed.nominal, &all) {
                    None => Certificate::Certified { lower_bound: objective, gap: 0.0, method },
                    Some(why) => Certificate::NotCertified(why.into()),
                };
                let window = Window { min: gear.ratio, max: gear.ratio, low: bind.clone(), high: bind };
                let optimum = Optimum {
                    ratio: gear.ratio,
                    objective,
                    windows: vec![window],
                    certificate,
                    shadow_prices: Vec::new(),
                };
                let design = boxed.design(nominal, all.clone(), Some(gear.id.as_str()), optimum);
                let key = |d: &RobustDesign| (d.optimum.objective, d.evaluation.loss);
                if best.as_ref().is_none_or(|b| key(&design) < key(b)) {
                    best = Some(design);
                }
            }
            let reason = match (nearest, doubted) {
                (Some((_, bind, over, allowed)), _) => Reason::Gears { bind, over, allowed, tried },
                (None, Some(doubt)) => Reason::Unjudged(vec![doubt]),
                (None, None) => Reason::Unusable(Unusable::NoGearFits),
            };
            best.ok_or(reason)
        }
    }
}

/// A motor with a gear, at its printed numbers and at all corners.
struct Boxed<'p> {
    nominal: Prepared<'p>,
    corners: Vec<(Prepared<'p>, Corner)>,
}

impl<'p> Boxed<'p> {
    fn new(
        robot: &'p Robot,
        joint: &'p Joint,
        demand: &'p JointDemand<'_>,
        motor: &'p Motor,
        corners: &'p [Corner],
        gear: Option<&str>,
    ) -> Result<Boxed<'p>, Unusable> {
        let prepare = |motor: &'p Motor| candidate(robot, joint, demand, motor, gear).map(Prepared::new);
        let corners = corners.iter().map(|c| Ok((prepare(&c.motor)?, c.clone())));
        Ok(Boxed { nominal: prepare(motor)?, corners: corners.collect::<Result<_, _>>()? })
    }

    /// What keeps the printed numbers or a corner from being a choice at a ratio, by what is not known.
    fn doubt(&self, ratio: f64, only_checked: bool) -> Option<Remark> {
        self.all().find_map(|prepared| judge::doubt(prepared, ratio, only_checked))
    }

    /// The printed numbers, then the corners.
    fn all(&self) -> impl Iterator<Item = &Prepared<'p>> {
        std::iter::once(&self.nominal).chain(self.corners.iter().map(|(prepared, _)| prepared))
    }

    /// What is to be said of the printed numbers or of a corner at a ratio, each once.
    fn judged(&self, ratio: f64) -> Judged {
        let mut all = Judged::default();
        for Judged { unchecked, assumed } in self.all().map(|prepared| prepared.judged(ratio)) {
            for (told, new) in [(&mut all.unchecked, unchecked), (&mut all.assumed, assumed)] {
                let new: Vec<Remark> = new.into_iter().filter(|remark| !told.contains(remark)).collect();
                told.extend(new);
            }
        }
        let unchecked: Vec<&str> = all.unchecked.iter().map(|(limit, _)| *limit).collect();
        all.assumed.retain(|(limit, _)| !unchecked.contains(limit));
        all
    }

    /// The smallest margin over the limits of all corners at a ratio.
    fn tightest(&self, ratio: f64) -> Option<Margin> {
        let margin = |Limited { candidate, asked }: Limited| {
            let (raw, sample) = asked.raw_demand(candidate, ratio);
            let demand = asked.natural(raw);
            let margin = asked.margin(candidate, ratio, raw);
            Margin {
                limit: asked.limit.name,
                unit: asked.limit.unit,
                demand,
                bound: asked.bound,
                margin,
                sample,
                owner: asked.owner,
            }
        };
        limits_of(&self.nominal, &self.corners).into_iter().map(margin).min_by(|a, b| a.margin.total_cmp(&b.margin))
    }

    fn design<'a>(
        &self,
        nominal: &Design<'a>,
        toleranced: Vec<Toleranced>,
        gear: Option<&'a str>,
        optimum: Optimum,
    ) -> RobustDesign<'a> {
        let ratio = optimum.ratio;
        let objective = &self.nominal.candidate.joint.objective;
        let at_corners = self.corners.iter().filter_map(|(prepared, _)| prepared.at(ratio).objective(objective));
        let evaluation = Evaluation {
            energy: self.nominal.energy(ratio),
            peak_power: Some(self.nominal.peak_power(ratio)),
            ..self.nominal.at(ratio)
        };
        let Judged { unchecked, assumed } = self.judged(ratio);
        RobustDesign {
            nominal: nominal.clone(),
            toleranced,
            corners: self.corners.len(),
            gear,
            unchecked,
            assumed,
            worst_objective: at_corners.fold(optimum.objective, f64::max),
            tightest: self.tightest(ratio),
            evaluation,
            optimum,
        }
    }
}

/// A random motor within its tolerances: each ± is the 95 % interval (two standard deviations) of an
/// independent normal error of the logarithm, as in the metrics. A number that is zero, half a normal one.
fn sample(motor: &Motor, all: &[Toleranced], generator: &mut Pcg64) -> Option<Motor> {
    let numbers: Vec<(&'static str, f64)> = all
        .iter()
        .map(|t| {
            let z = normal(generator);
            let deviation = 0.5 * t.tolerance;
            let value = if t.value == 0.0 { deviation * z.abs() } else { t.value * (deviation / t.value * z).exp() };
            (t.column, value)
        })
        .collect();
    with_numbers(motor, numbers.into_iter())
}

/// A standard normal number (Box and Muller).
fn normal(generator: &mut Pcg64) -> f64 {
    let mut uniform = || ((generator.next_u64() >> 11) as f64 + 0.5) * 2.0_f64.powi(-53);
    let (a, b) = (uniform(), uniform());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// A seed that depends on the names alone (FNV-1a).
fn seed(motor: &str, joint: &str) -> u64 {
    let bytes = motor.bytes().chain([0]).chain(joint.bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Objective of each sample at a ratio, where it keeps all limits.
type Course = Vec<Option<f64>>;

fn contenders<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    nominal: &[Design<'a>],
    robust: &[RobustDesign<'a>],
    only_checked: bool,
) -> Vec<Contender<'a>> {
    let first: Vec<&Design> = nominal.iter().take(CONTENDERS).collect();
    let sampled: Vec<(Course, Option<Course>)> = first
        .par_iter()
        .map(|design| {
            let motor = design.motor;
            let all = toleranced(motor);
            let own = robust.iter().find(|r| r.nominal.motor.id == motor.id);
            let at = |motor: &Motor, gear: Option<&str>, ratio: f64| {
                let prepared = Prepared::new(candidate(robot, joint, demand, motor, gear).ok()?);
                let evaluation = prepared.at(ratio);
                // What cannot be judged is not known to be kept.
                let kept = evaluation.feasible
                    && !(judge::may_change(&prepared, only_checked)
                        && judge::doubt(&prepared, ratio, only_checked).is_some());
                evaluation.objective(&joint.objective).filter(|_| kept)
            };
            let both = |motor: &Motor| {
                let robust = own.map(|own| at(motor, own.gear, own.optimum.ratio));
                (at(motor, design.gear, design.optimum.ratio), robust)
            };
            let mut generator = Pcg64::seed_from_u64(seed(&motor.id, &joint.name));
            let samples: Vec<(Option<f64>, Option<Option<f64>>)> = if all.is_empty() {
                vec![both(motor); SAMPLES]
            } else {
                (0..SAMPLES)
                    .map(|_| sample(motor, &all, &mut generator).map_or((None, own.map(|_| None)), |m| both(&m)))
                    .collect()
            };
            let at_nominal = samples.iter().map(|s| s.0).collect();
            (at_nominal, samples.iter().map(|s| s.1).collect())
        })
        .collect();
    let share = |count: usize| count as f64 / SAMPLES as f64;
    let feasible = |course: &Course| share(course.iter().flatten().count());
    // How often each is first: the least objective among those that keep their limits.
    let wins = |courses: &[&Course]| {
        let mut wins = vec![0; courses.len()];
        for s in 0..SAMPLES {
            let alive = courses.iter().enumerate().filter_map(|(i, c)| Some((i, c[s]?)));
            if let Some((i, _)) = alive.min_by(|a, b| a.1.total_cmp(&b.1)) {
                wins[i] += 1;
            }
        }
        wins
    };
    let at_nominal = wins(&sampled.iter().map(|(n, _)| n).collect::<Vec<_>>());
    let at_robust = wins(&sampled.iter().map(|(n, r)| r.as_ref().unwrap_or(n)).collect::<Vec<_>>());
    let contender = |i: usize| Contender {
        motor: first[i].motor,
        ratios: (
            first[i].optimum.ratio,
            robust.iter().find(|r| r.nominal.motor.id == first[i].motor.id).map(|r| r.optimum.ratio),
        ),
        feasible_nominal: feasible(&sampled[i].0),
        feasible_robust: sampled[i].1.as_ref().map(feasible),
        first_nominal: share(at_nominal[i]),
        first_robust: share(at_robust[i]),
    };
    (0..first.len()).map(contender).collect()
}
