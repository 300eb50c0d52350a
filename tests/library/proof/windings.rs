//! The best ratio and winding together, against a scan over ratios and turns that shares no code with it.

use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize;
use gearwise::design::program::Certificate;
use gearwise::design::turns::{Rewinding, rewinding};
use gearwise::design::windings::{Best, best, wind};
use gearwise::design::{JointDemand, Site};
use gearwise::requirement::{Quantity, RatioChoice, Windings};
use rayon::prelude::*;

use super::turns::{with_limits_of_turns, with_turns};
use crate::cases::{are_all, cases};
use crate::raw::{Case, draw};

/// Ratios and turns that are looked at.
const RATIOS: i32 = 150;
const TURNS: i32 = 40;

/// What came of a case.
#[derive(Debug, Default)]
struct Came {
    proved: bool,
    /// The best over ratio and turns is not where voltage and drive are left out.
    divided: bool,
    none: bool,
    seen: bool,
    wrong: Vec<String>,
}

fn look(i: u64, convex: bool) -> Option<Came> {
    let mut case = draw(i, convex);
    // A supply that is far too low or far too high as often as one that suits, and a drive that is too small.
    case.robot.bus.voltage *= [0.05, 0.3, 1.0, 3.0][(i % 4) as usize];
    if i.is_multiple_of(3) {
        let drive = &mut case.robot.joints[0].drive_current;
        *drive = drive.or(case.robot.bus.drive_current).map(|current| 0.2 * current);
    }
    with_limits_of_turns(&mut case, i);
    let range = [(0.5, 2.0), (0.05, 20.0), (0.3, 0.9), (1.0, 5.0)][(i / 4 % 4) as usize];
    let case = Case::new(case.motor.clone(), case.robot.clone(), case.raw.clone());
    let joint = &case.robot.joints[0];
    let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
    if joint.objective.weight(Quantity::PeakCurrent) > 0.0 {
        return None;
    }
    let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
    let demand = JointDemand::new(joint, &catalog);
    let told = best(Site::new(&case.robot, joint, &demand), &catalog.motors[0], range, false);
    let mut came = Came::default();
    let turns: Vec<Case> = (0..=TURNS)
        .map(|k| with_turns(&case, range.0 * (range.1 / range.0).powf(f64::from(k) / f64::from(TURNS))))
        .collect();
    let ratios: Vec<f64> = (0..=RATIOS).map(|k| min * (max / min).powf(f64::from(k) / f64::from(RATIOS))).collect();
    let kept = ratios.iter().flat_map(|n| turns.iter().map(move |wound| (*n, wound)));
    let kept = kept.filter(|(n, wound)| wound.worst(*n).0 <= -1e-9).map(|(n, wound)| wound.look(n).objective);
    let seen = kept.reduce(f64::min);
    came.seen = seen.is_some();
    let Some(Best { ratio, turns, objective, lower_bound }) = told else {
        // What cannot be judged is no choice with any winding.
        let free = rewinding(Site::new(&case.robot, joint, &demand), &catalog.motors[0], &catalog, false);
        came.none = true;
        return (!matches!(free, Rewinding::Unjudged(_))).then_some(came);
    };
    let mut must = |holds: bool, what: String| {
        if !holds {
            came.wrong.push(format!("case {i}: {what}"));
        }
    };
    must(range.0 <= turns && turns <= range.1, format!("{turns} turns, not in {range:?}"));
    let wound = with_turns(&case, turns);
    must(wound.worst(ratio).0 <= 1e-6, format!("{turns} turns at {ratio}: {:?}", wound.worst(ratio)));
    let there = wound.look(ratio).objective;
    must((there - objective).abs() <= 1e-8 * there.abs().max(1e-9), format!("objective {objective}, {there}"));
    let close = |bound: f64| objective - bound <= 1e-6 * objective.abs();
    if let (Some(bound), Some(seen)) = (lower_bound, seen) {
        must(bound <= seen + 1e-9 * seen.abs(), format!("nothing below {bound} is said to be, {seen} was seen"));
    }
    came.proved = lower_bound.is_some_and(close);
    // The choice of the whole program is the same, and says no more than that.
    let mut robot = case.robot.clone();
    robot.joints[0].motors.turns = Windings::Between { min: range.0, max: range.1, found: Vec::new() };
    let catalog = wind(&mut robot, &catalog, false).expect("it goes with what is drawn");
    let result = optimize(&robot, &catalog);
    match result.joints[0].designs().next() {
        Some(design) => {
            let own = design.optimum.objective;
            must((own - objective).abs() <= 2e-6 * objective.abs().max(1e-9), format!("{own} is chosen, {objective}"));
            must(design.motor.turns() == turns, format!("{} chosen, {turns} found", design.motor.id));
            let certified = matches!(design.optimum.certificate, Certificate::Certified { .. });
            must(
                !certified || lower_bound.is_some_and(|b| own - b <= 2e-6 * own.abs()),
                "proved without a bound".into(),
            );
        }
        None => must(false, format!("{turns} turns at {ratio} were found, and are no choice")),
    }
    came.divided = seen.is_some() && (turns - 1.0).abs() > 1e-9;
    Some(came)
}

/// What is found keeps every limit in raw waveforms, what is proved is not beaten by any ratio and winding of the scan, and what
/// is chosen is what was found.
#[test]
fn the_best_ratio_and_winding_agree_with_a_scan_over_both() {
    let drawn = cases(0, 600).map(|i| (i, true)).chain(cases(100_000, 200).map(|i| (i, false)));
    let found: Vec<Came> = drawn.collect::<Vec<_>>().into_par_iter().filter_map(|(i, c)| look(i, c)).collect();
    let wrong: Vec<&String> = found.iter().flat_map(|f| &f.wrong).collect();
    let count = |what: &dyn Fn(&Came) -> bool| found.iter().filter(|f| what(f)).count();
    let (with, proved) = (count(&|f| !f.none), count(&|f| f.proved));
    let (none, missed, other) = (count(&|f| f.none), count(&|f| f.none && f.seen), count(&|f| f.divided));
    println!(
        "{} joints: {with} with a winding ({other} another than the row's), {proved} of them proved over ratio and turns; {none} without, {missed} of these with one that was seen",
        found.len()
    );
    assert!(wrong.is_empty(), "{} disagree: {:#?}", wrong.len(), &wrong[..wrong.len().min(12)]);
    assert!(missed * 50 <= none.max(50), "{missed} of {none}");
    assert!(proved * 10 >= with * 9, "{proved} of {with}");
    if are_all() {
        assert!(with > 80 && other > 25 && none > 100, "{with} {other} {none}");
    }
}
