//! An independent check of the ratio program: random joints are solved by `design::optimize`, and again
//! in `raw` by looking at more than a thousand ratios, one after the other, straight from the raw waveforms.
//!
//! `GEARWISE_CASES=10` makes it ten times as many cases as all (see `cases`), `GEARWISE_TELL=1` prints those that
//! disagree in full.

use std::collections::BTreeMap;

use gearwise::actuator::Load;
use gearwise::catalog::convention::Commutation;
use gearwise::catalog::drag::Friction;
use gearwise::catalog::estimate::{Estimate, Estimated};
use gearwise::catalog::{Catalog, Construction, Printed};
use gearwise::design::answer::Reason;
use gearwise::design::judge::unjudged;
use gearwise::design::optimize::optimize;
use gearwise::design::program::Infeasible::{Contradiction, Never, Nowhere};
use gearwise::design::program::{Certificate, Window};
use gearwise::design::{Mount, Prepared};
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::cases::{are_all, long_cases};
use crate::raw::{Case, LIMITS, Scan, draw};
use crate::solved::{self, Solved};

/// A case is too close to call where the least violation is nearer to zero than `CLOSE` or no window is
/// wider than `NARROW`, which is also what its ends may differ by.
const CLOSE: f64 = 1e-7;
const NARROW: f64 = 1e-6;

/// What came of a case: how far each thing is apart and may be at most, and the limits that bind.
#[derive(Default)]
struct Verdict {
    feasible: bool,
    /// Nothing is feasible, and the program says that it has not ruled out everything.
    open: bool,
    certified: bool,
    close: bool,
    apart: Vec<(&'static str, f64, f64)>,
    binding: Vec<&'static str>,
}

fn compare(case: &Case, convex: bool, tell: bool) -> Verdict {
    let (scan, found) = (Scan::new(case), solved::solve(&case.motor, &case.robot));
    let mut v = Verdict { feasible: !scan.windows.is_empty(), ..Verdict::default() };
    // What is burned is what the bus does not take, and no more: its limit is met with equality.
    let burned = case.robot.bus.flux_braking && scan.least.1 == "regeneration" && scan.least.0 < 0.0;
    v.close =
        scan.least.0.abs() < CLOSE && !burned || v.feasible && scan.windows.iter().all(|[a, b]| b / a - 1.0 < NARROW);
    if tell {
        let optimum = found.as_ref().map(|found| &found.optimum);
        println!("{:?}\n{optimum:?}\n{:?}", case.robot, scan.windows);
    }
    match &found {
        Ok(_) | Err(Reason::Infeasible(_)) if v.close => {}
        Ok(design) if v.feasible => compare_designs(case, convex, design, &scan, &mut v),
        Err(Reason::Infeasible(why)) if !v.feasible => {
            // What is said of the cause must hold: at every ratio, or just beyond the two that contradict.
            let filled = |limit: &str, n: f64| case.excess(n).find(|at| at.1 == limit).map_or(0.0, |at| at.0 + 1.0);
            let holds = match why {
                Never { bind: b, least, .. } => scan.grid.iter().all(|n| filled(b.limit, *n) > least.max(1.0) - CLOSE),
                Contradiction { low, at_least, high, at_most } => {
                    let forbidden = [(low.limit, at_least * (1.0 - NARROW)), (high.limit, at_most * (1.0 + NARROW))];
                    at_least > at_most && forbidden.iter().all(|(limit, n)| filled(limit, *n) > 1.0)
                }
                // Standstill falls in steps of the ratio, which no other limit of a convex program does.
                Nowhere { .. } => !convex || case.has_slow_motion(),
            };
            v.apart.push(("cause", f64::from(!holds), 0.0));
            v.binding.push(scan.least.1);
        }
        Err(Reason::NotSolved(_)) if !v.feasible && !convex => v.open = true,
        _ => v.apart.push(("verdict", 1.0, 0.0)),
    }
    v
}

/// Everything that is said of the best design.
fn compare_designs(case: &Case, convex: bool, design: &Solved, scan: &Scan, v: &mut Verdict) {
    v.certified = matches!(design.optimum.certificate, Certificate::Certified { .. });
    let (n, optimum, evaluation) = (design.optimum.ratio, &design.optimum, &design.evaluation);
    let (at, usual) = (case.look(n), case.look((scan.grid[0] * scan.grid[scan.grid.len() - 1]).sqrt()));
    let mut near = |what, apart: f64, most| v.apart.push((what, apart, most));
    // Relative; where a single operating point can be met without any torque, to what is usual.
    // Energy may be less than nothing.
    let above = |a: f64, b: f64, usual: f64| match a.min(b) {
        least if least < 0.0 => (a - b) / b.abs().max(1e-3 * usual.abs()),
        _ => 0.5 * (a * a - b * b) / (b * b).max(1e-6 * usual * usual),
    };
    let best = scan.least_of(|n| case.look(n).objective);
    // Power and energy may be nothing altogether: they are measured by the heat in them.
    let motion = &case.robot.joints[0].motion;
    let copper = usual.quantities[1];
    let heat = [0.0, 0.0, 0.0, 0.0, 0.0, copper * motion.duration().unwrap_or(0.0), copper];
    let in_heat = |(q, weight): &(Quantity, f64)| weight * heat[*q as usize];
    let usual_objective = usual.objective.abs() + case.robot.joints[0].objective.terms.iter().map(in_heat).sum::<f64>();
    near("objective above the best", above(optimum.objective, best, usual_objective), 1e-6);
    near("objective below the best", -above(optimum.objective, best, usual_objective), 1e-8);
    near("objective at N*", above(optimum.objective, at.objective, usual_objective).abs(), 1e-9);
    if case.robot.joints[0].objective.sole() == Some(Quantity::Mass) {
        // The declared tie-break: among the ratios of least mass the one of least loss.
        let loss = |q: [f64; 7]| if q[4] > best * (1.0 + 1e-12) { f64::INFINITY } else { q[0] };
        let best_loss = scan.least_of(|n| loss(case.look(n).quantities));
        near("loss at least mass", above(at.quantities[0], best_loss, usual.quantities[0]), 1e-6);
    }
    near("N* feasible", f64::from(!evaluation.feasible), 0.0);
    near("violation at N*", case.worst(n).0, CLOSE);
    // Windows, and what ends them: beyond the end the limit that is named must be exceeded.
    let theirs: Vec<f64> = optimum.windows.iter().flat_map(|w| [w.min, w.max]).collect();
    let is_one = !convex || case.has_slow_motion() || theirs.len() <= 2;
    near("windows", f64::from(theirs.len() != 2 * scan.windows.len() || !is_one), 0.0);
    for (a, b) in scan.windows.iter().flatten().zip(theirs).filter(|_| optimum.windows.len() == scan.windows.len()) {
        near("window end", (a / b - 1.0).abs(), NARROW);
    }
    let outside = optimum.windows.iter().map(|w| (w.min / n).max(n / w.max) - 1.0).fold(f64::INFINITY, f64::min);
    near("N* outside the windows", outside, 1e-9);
    let ends = |w: &Window| [(w.low.limit, w.min * (1.0 - NARROW)), (w.high.limit, w.max * (1.0 + NARROW))];
    for (limit, beyond) in optimum.windows.iter().flat_map(ends) {
        near("what ends a window", f64::from(!case.excess(beyond).any(|at| at.1 == limit && at.0 > 0.0)), 0.0);
        v.binding.push(limit);
    }
    // The proof; beyond the convex programs there may be none.
    if let Certificate::Certified { lower_bound, gap, .. } = optimum.certificate {
        near("lower bound above the best", above(lower_bound, best, usual_objective), 1e-9);
        near("gap", gap, 1e-6);
    }
    near("certified", f64::from(convex && matches!(optimum.certificate, Certificate::NotCertified(_))), 0.0);
    // The figures and the margins; demands far below their bound count less.
    for q in (0..7).filter(|q| *q != 5 || motion.has_durations()) {
        let quantity = Quantity::NAMES.iter().find(|(_, quantity)| *quantity as usize == q).unwrap();
        let x = evaluation.quantity(quantity.1).unwrap_or(f64::NAN);
        near(quantity.0, above(x, at.quantities[q], usual.quantities[q].abs() + heat[q]).abs(), 1e-9);
    }
    let ends = [scan.grid[0], scan.grid[scan.grid.len() - 1]].map(|end| case.look(end).limits);
    let asked = at.limits[..LIMITS].iter().filter(|(_, _, bound)| bound.is_some());
    near("limits", f64::from(!evaluation.margins.iter().map(|m| m.limit).eq(asked.clone().map(|a| a.0))), 0.0);
    for (margin, (_, demand, bound)) in evaluation.margins.iter().zip(asked).filter(|(margin, _)| margin.bound > 0.0) {
        let (a, b) = (1.0 - margin.margin, demand.max(0.0) / bound.unwrap());
        // A mean whose terms cancel has the rounding of its terms, which the ends of the range show.
        let terms = ends.iter().map(|end| end.iter().find(|at| at.0 == margin.limit).map_or(0.0, |at| at.1));
        let terms = terms.fold(0.0, f64::max).min(1e9 * margin.bound) / margin.bound;
        if std::env::var_os("GEARWISE_TELL").is_some() && (a - b).abs() > 1e-6 {
            println!("{}: {a} of the bound, {b} by the scan", margin.limit);
        }
        near("margin", (a * a - b * b).abs() / ((a + b).max(1e-3) + 1e-7 * terms * terms), 1e-8);
    }
}

/// Compares cases in parallel and says how it went; `limits` is the number of limits that bind somewhere.
pub(super) fn run(cases: std::ops::Range<u64>, convex: bool, limits: usize, draw: impl Fn(u64) -> Case + Sync) {
    let verdicts: Vec<_> = cases.into_par_iter().map(|i| (i, compare(&draw(i), convex, false))).collect();
    let count = |f: fn(&Verdict) -> bool| verdicts.iter().filter(|(_, v)| f(v)).count();
    let (all, feasible, close) = (verdicts.len(), count(|v| v.feasible), count(|v| v.close));
    let (mut binding, mut apart) = (BTreeMap::new(), BTreeMap::new());
    verdicts.iter().flat_map(|(_, v)| &v.binding).for_each(|limit| *binding.entry(limit).or_insert(0) += 1);
    for (what, x, _) in verdicts.iter().flat_map(|(_, v)| &v.apart) {
        apart.entry(what).and_modify(|most: &mut f64| *most = most.max(*x)).or_insert(*x);
    }
    let (open, certified) = (count(|v| v.open), count(|v| v.certified));
    println!(
        "{all} cases, {feasible} feasible, {certified} proved, {open} open, {close} too close to call; binding {binding:?}; most apart {apart:?}"
    );
    if std::env::var_os("GEARWISE_TELL").is_some() {
        let open = verdicts.iter().filter(|(_, v)| v.feasible && !v.certified);
        println!("not proved: {:?}", open.map(|(i, v)| (*i, &v.binding)).collect::<Vec<_>>());
    }
    let apart = |v: &Verdict| v.apart.iter().copied().filter(|(_, x, most)| x.is_nan() || x > most).collect::<Vec<_>>();
    let wrong: Vec<_> = verdicts.iter().map(|(i, v)| (*i, apart(v))).filter(|(_, apart)| !apart.is_empty()).collect();
    for (i, apart) in wrong.iter().take(20) {
        println!("case {i}, what is apart by how much and may be at most: {apart:?}");
        if std::env::var_os("GEARWISE_TELL").is_some() {
            compare(&draw(*i), convex, true);
        }
    }
    assert!(
        open * 20 <= all && certified * 20 >= feasible * 19,
        "{open} of {all} open, {certified} of {feasible} proved"
    );
    assert!(wrong.is_empty(), "{} cases disagree: {:?}", wrong.len(), wrong.iter().map(|w| w.0).collect::<Vec<_>>());
    if are_all() {
        assert!(close * 50 < all && feasible * 9 > all * 4 && feasible * 5 < all * 4 && binding.len() >= limits);
    }
}

#[test]
fn convex_programs_agree_with_a_scan_of_the_raw_waveforms() {
    run(long_cases(0, 1400), true, 20, |i| draw(i, true));
}

#[test]
fn other_programs_agree_with_a_scan_of_the_raw_waveforms() {
    run(long_cases(100_000, 700), false, 21, |i| draw(i, false));
}

/// A joint whose motor says its drag by one torque without load, or by an estimate; with a gear that takes some without
/// load, a drive with resistance and standby, and all losses minimised where it was that in the copper.
pub(super) fn dragged(i: u64) -> Case {
    let mut case = draw(i, !i.is_multiple_of(3));
    let mut random = Pcg64::seed_from_u64(i);
    let mut around = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let n = (min * max).sqrt();
    let motor = &mut case.motor;
    let current = (case.raw.iter().zip(&case.shares).map(|(p, s)| s[0] * p.torque.powi(2)).sum::<f64>()).sqrt() / n;
    let speed = n * case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
    (motor.coulomb_friction, motor.viscous_friction) = (None, None);
    motor.no_load_torque = Some(current * around(0.003, 0.5));
    motor.sheet.no_load_speed = Some(Printed { value: speed.max(1.0) * around(0.3, 5.0), tolerance: None });
    if i.is_multiple_of(4) {
        let value = motor.no_load_torque.unwrap();
        let construction = Construction::Housed;
        motor.estimates.push(Estimate { of: Estimated::Drag, value, middle: 0.5 * value, rows: 9, construction });
    }
    let joint = &mut case.robot.joints[0];
    joint.motor_drag = MotorDrag::Counted;
    if i.is_multiple_of(2) {
        joint.gear.no_load = Friction { coulomb: current * around(0.001, 0.1), viscous: 0.0 };
        joint.gear.no_load.viscous = joint.gear.no_load.coulomb / speed.max(1.0) * around(0.1, 3.0);
        joint.drive.phase_resistance = Some(motor.resistance * around(0.003, 0.3));
        joint.drive.standby_power =
            Some(motor.resistance * (current / motor.torque_constant).powi(2) * around(0.001, 0.1));
    }
    // Where nothing may come back, a single ratio at which power just touches zero is a matter of rounding.
    if case.robot.bus.regeneration == Regeneration::Limited(0.0) {
        case.robot.bus.regeneration = Regeneration::Allowed;
    }
    for (quantity, _) in &mut case.robot.joints[0].objective.terms {
        *quantity = if *quantity == Quantity::CopperLoss && !i.is_multiple_of(5) { Quantity::Loss } else { *quantity };
    }
    Case::new(case.motor, case.robot, case.raw)
}

/// Motor drag between two ends, all losses, friction of gears: verdicts, windows, best ratio, objective and every margin.
#[test]
fn programs_with_drag_between_two_ends_agree_with_a_scan_of_the_raw_waveforms() {
    run(long_cases(200_000, 1200), false, 18, dragged);
}

/// A joint on a supply with a resistance: with leads of its own, a bus that may rise, a brake, what comes back kept in part or
/// not at all, and a drive whose current for ever is a limit.
pub(super) fn supplied(i: u64) -> Case {
    let mut case = if i.is_multiple_of(4) { dragged(i) } else { draw(i, !i.is_multiple_of(3)) };
    let mut random = Pcg64::seed_from_u64(i + 1);
    let mut around = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let at = case.look((min * max).sqrt());
    let need = |name: &str| at.limits.iter().find(|limit| limit.0 == name).unwrap().1;
    let (peak, back) = (need("bus_power").abs().max(1e-9), need("regeneration"));
    let bus = &mut case.robot.bus;
    // A sag of a thousandth to a half at the most power of the middle ratio.
    let resistance = bus.voltage * bus.voltage / peak * around(1e-3, 0.25);
    bus.internal_resistance = Some(resistance).filter(|_| !i.is_multiple_of(7));
    case.robot.joints[0].drive.supply_lead_resistance = Some(0.1 * resistance).filter(|_| i.is_multiple_of(2));
    bus.regeneration_efficiency = Some(bus.drive_efficiency * around(0.4, 1.0)).filter(|_| i.is_multiple_of(3));
    match i % 5 {
        0 => bus.regeneration = Regeneration::Dissipated,
        1 if back > 0.0 => {
            bus.max_voltage = Some(bus.voltage * around(1.001, 1.3));
            if i.is_multiple_of(2) {
                bus.regeneration = Regeneration::Limited(back * around(0.5, 2.0));
                bus.brake_power = Some(back * around(0.01, 1.0));
            }
        }
        2 if back > 0.0 => {
            bus.regeneration = Regeneration::Limited(back * around(0.1, 2.0));
            bus.brake_power = Some(back * around(0.1, 2.0));
        }
        _ => {}
    }
    if i.is_multiple_of(3) {
        let amplitude = if case.motor.conventions.commutation == Commutation::Brushed { 1.0 } else { 1.5_f64.sqrt() };
        bus.drive.continuous_current = Some(need("continuous_current") / amplitude * around(0.7, 2.0));
    }
    // Where nothing may come back, a single ratio at which power just touches zero is a matter of rounding.
    if bus.regeneration == Regeneration::Limited(0.0) {
        bus.regeneration = Regeneration::Allowed;
    }
    Case::new(case.motor, case.robot, case.raw)
}

/// A supply that sags and what it makes of power that comes back: verdicts, windows, best ratio, objective and every margin.
#[test]
fn programs_on_a_supply_that_sags_agree_with_a_scan_of_the_raw_waveforms() {
    run(long_cases(400_000, 800), false, 18, supplied);
}

/// A joint with a brushless motor of which what couples across is `low` to `high` of its back-EMF at the middle ratio; what that
/// ratio asks for by name, and draws between two numbers.
fn coupled(i: u64, seed: u64, [low, high]: [f64; 2]) -> (Case, impl Fn(&str) -> f64, impl FnMut(f64, f64) -> f64) {
    // Of some the drag lies between two ends.
    let mut case = if i % 4 == 1 { dragged(i) } else { draw(i, i.is_multiple_of(2)) };
    let mut random = Pcg64::seed_from_u64(seed);
    let mut around = move |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let n = (min * max).sqrt();
    let at = case.look(n);
    let need = move |name: &str| at.limits.iter().find(|limit| limit.0 == name).unwrap().1;
    let speed = n * case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
    let current = need("peak_current").max(1e-9);
    let motor = &mut case.motor;
    if motor.conventions.commutation == Commutation::Brushless && speed > 0.0 {
        let poles = motor.pole_pairs.unwrap_or(7).max(1);
        motor.pole_pairs = Some(poles);
        motor.inductance = Some(motor.emf_constant() / (f64::from(poles) * current) * around(low, high));
    }
    (case, need, around)
}

/// A joint whose drive may weaken the field, by more or less than the middle ratio asks for; some magnets bear less.
fn weakened(i: u64) -> Case {
    let (mut case, need, mut around) = coupled(i, i + 2, [0.1, 10.0]);
    let (voltage, current) = (need("voltage").max(need("torque_bandwidth_voltage")), need("peak_current").max(1e-9));
    case.robot.bus.voltage = voltage.max(1e-9) * around(0.5, 2.5) / 0.6;
    case.robot.bus.drive.field_weakening_current = Some(current * around(0.05, 3.0));
    case.motor.demagnetization_current = Some(current * around(0.1, 3.0)).filter(|_| i.is_multiple_of(3));
    case.robot.bus.max_voltage = Some(case.robot.bus.voltage * around(1.0, 5.0)).filter(|_| i.is_multiple_of(5));
    // What comes back is helped by more of that current than the least: nothing is said of it here.
    case.robot.bus.regeneration = Regeneration::Allowed;
    Case::new(case.motor, case.robot, case.raw)
}

/// A weakened field: verdicts, best ratio, objective and every margin, against a scan over ratios with the current against the
/// magnets found by halving at every sample.
#[test]
fn programs_with_a_weakened_field_agree_with_a_scan_of_the_raw_waveforms() {
    run(long_cases(500_000, 160), false, 15, weakened);
}

/// A joint whose drive burns what comes back beyond what the bus takes by a current along d.
fn burned(i: u64) -> Case {
    let (mut case, need, mut around) = coupled(i, i + 3, [0.01, 3.0]);
    let (voltage, current) = (need("voltage").max(need("torque_bandwidth_voltage")), need("peak_current").max(1e-9));
    case.robot.bus.voltage = voltage.max(1e-9) * around(0.7, 5.0) / 0.6;
    let back = need("regeneration").max(1e-3 * need("bus_power").abs()).max(1e-9);
    case.robot.bus.regeneration = Regeneration::Limited(back * around(0.02, 1.5));
    case.robot.bus.brake_power = Some(back * around(0.02, 0.5)).filter(|_| i.is_multiple_of(4));
    case.robot.bus.flux_braking = true;
    case.motor.demagnetization_current = Some(current * around(0.5, 5.0)).filter(|_| i.is_multiple_of(3));
    Case::new(case.motor, case.robot, case.raw)
}

/// Flux braking: verdicts, best ratio, objective and every margin, against a scan over ratios with the current that burns it
/// computed at every sample.
#[test]
fn programs_with_flux_braking_agree_with_a_scan_of_the_raw_waveforms() {
    run(long_cases(600_000, 160), false, 12, burned);
}

/// Parts of constant heat are the model's own approximation: here heat is linear between samples, the
/// equations are integrated by the classic Runge-Kutta rule, and a periodic motion is repeated until it
/// repeats. The model is never below it, but for the fourth order of its parts, and above it by no more than it says.
#[test]
fn the_hottest_winding_is_that_of_an_integration() {
    let cases: Vec<Case> = (0..400).map(|i| draw(i, true)).filter(|case| case.nodes().is_some()).collect();
    let compare = |case: &Case| {
        let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
        let result = &optimize(&case.robot, &catalog).joints[0];
        let design = result.designs().next()?;
        let margin = design.evaluation.margins.iter().find(|m| m.limit == "winding_peak_temperature")?;
        let heat = case.copper_heat(design.optimum.ratio);
        let (nodes, peak) = (case.nodes()?, case.nodes()?.integrated_peak(&heat, 400.0));
        let above = margin.demand / peak - 1.0;
        Some([-above, above - nodes.given_away(&heat, peak) / peak, above])
    };
    let apart: Vec<[f64; 3]> = cases.par_iter().filter_map(compare).collect();
    let [below, beyond, above] = [0, 1, 2].map(|i| apart.iter().map(|x| x[i]).fold(f64::NEG_INFINITY, f64::max));
    println!("{} motions: below by {below:e}, above by {above:e}, more than is said by {beyond:e}", apart.len());
    assert!(apart.len() > 40 && below < 1e-5 && beyond < 1e-5 && above < 5e-3, "{below} {beyond} {above}");
}

/// Where heat can be judged at some ratios only: the best of those that a dense look finds is the choice, and what lies
/// in its windows can be judged. What is said at a ratio is looked at elsewhere (tests/library/proof/heat_over_motion.rs).
#[test]
fn of_the_ratios_that_can_be_judged_the_best_is_the_choice() {
    let look = |(i, convex): (u64, bool)| {
        let mut case = draw(i, convex);
        let joint = &mut case.robot.joints[0];
        joint.limits.winding_temperature = joint.limits.winding_temperature.or(case.motor.max_winding_temperature);
        let joint = &case.robot.joints[0];
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let load = Load::new(&joint.motion, joint.ripple());
        let prepared = Prepared::new(Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap());
        let is_judged = |n: f64| unjudged(&case.robot, joint, &prepared.unchecked_at(n)).is_empty();
        let looked: Vec<(f64, bool, f64)> = (0..=600)
            .map(|k| min * (max / min).powf(f64::from(k) / 600.0))
            .map(|n| (n, is_judged(n), prepared.at_in_full(n)))
            .filter(|(.., at)| at.feasible)
            .map(|(n, judged, at)| (n, judged, at.objective(&joint.objective).unwrap()))
            .collect();
        let part = looked.iter().any(|l| l.1) && looked.iter().any(|l| !l.1);
        let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
        let result = &optimize(&case.robot, &catalog).joints[0];
        let Some(design) = result.candidates.first() else {
            assert!(!looked.iter().any(|l| l.1), "case {i} {convex}: {:?} will do", looked.iter().find(|l| l.1));
            return (part, false);
        };
        let (optimum, size) = (&design.optimum, design.optimum.objective.abs());
        assert!(is_judged(optimum.ratio), "case {i} {convex}");
        let best = looked.iter().filter(|l| l.1).map(|l| l.2).fold(f64::INFINITY, f64::min);
        assert!(optimum.objective <= best + 1e-6 * size.max(1e-9), "case {i} {convex}: {} {best}", optimum.objective);
        for window in &optimum.windows {
            let inside = |n: f64| n > window.min * 1.001 && n < window.max * 0.999;
            assert!(looked.iter().filter(|l| inside(l.0)).all(|l| l.1), "case {i} {convex}: {window:?}");
        }
        let moved = matches!(&optimum.certificate, Certificate::NotCertified(why) if why.to_string().contains("cannot be judged"));
        if moved {
            let free = solved::solve(&case.motor, &case.robot).map_or_else(|why| panic!("{why:?}"), |f| f.optimum);
            assert!(!is_judged(free.ratio) && free.objective <= optimum.objective, "case {i} {convex}: {free:?}");
        }
        (part, moved)
    };
    let cases: Vec<(u64, bool)> =
        long_cases(0, 1600).map(|i| (i, true)).chain(long_cases(100_000, 300).map(|i| (i, false))).collect();
    let found: Vec<(bool, bool)> = cases.into_par_iter().map(look).collect();
    let (part, moved) = (found.iter().filter(|f| f.0).count(), found.iter().filter(|f| f.1).count());
    println!("{part} can be judged in part, {moved} have a better ratio that cannot");
    assert!(!are_all() || part > 20 && moved > 5, "{part} {moved}");
}
