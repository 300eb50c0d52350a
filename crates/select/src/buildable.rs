//! Ratios that can be built: planetary gears of few teeth near an optimum, and what they cost.
//!
//! The one idea: a ratio of a proof has as many digits as a number has; a gear has teeth. A simple planetary stage (ring
//! held, sun in, carrier out) has 1 + ring/sun. Where three planets fit and can be assembled, it is one of the ratios that are
//! listed here; the motor is solved again at such a ratio, so that what is written keeps every limit.

use std::sync::LazyLock;

use super::answer::{Design, Refused};
use super::best::best_design;
use super::mount::{JointDemand, Site};
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::requirement::{Joint, RatioChoice, Robot, Stage, Train, stages as stages_of};

/// Planets of a stage.
const PLANETS: u32 = 3;
/// Fewest teeth of sun and planet: fewer are undercut.
const FEWEST_TEETH: u32 = 12;
/// Most teeth of a ring.
const MOST_TEETH: u32 = 120;
/// Most teeth of a sun.
const LARGEST_SUN: u32 = 48;
/// Largest ratio of a stage that is listed.
const LARGEST_STAGE: f64 = 10.0;
/// A gear this near to the optimum (relative) is taken for its few teeth.
const NEAR: f64 = 0.01;
/// Further away than this (relative) none is looked for.
const FAR: f64 = 0.1;
/// Most ratios that are tried for one design.
const TRIES: usize = 6;

/// Every stage that can be assembled, of each ratio the one with the fewest teeth, by ratio.
fn stages() -> &'static [Stage] {
    static ALL: LazyLock<Vec<Stage>> = LazyLock::new(|| {
        let mut all: Vec<Stage> = (FEWEST_TEETH..=LARGEST_SUN)
            .flat_map(|sun| (sun + 1..=MOST_TEETH).map(move |ring| Stage { sun, ring }))
            .filter(|stage| {
                stage.planet() >= FEWEST_TEETH && stage.can_be_assembled(PLANETS) && stage.ratio() <= LARGEST_STAGE
            })
            .collect();
        all.sort_by(|a, b| a.ratio().total_cmp(&b.ratio()).then(a.ring.cmp(&b.ring)));
        all.dedup_by(|b, a| (a.ratio() - b.ratio()).abs() < 1e-12);
        all
    });
    &ALL
}

/// The stages that are put one behind another: those of few teeth.
fn few_teeth(most: u32) -> impl Iterator<Item = Stage> + Clone {
    stages().iter().copied().filter(move |stage| stage.ring <= most)
}

/// Gears whose ratio lies between two, those near `ratio` with the fewest teeth first, then the nearest: of as few stages as can
/// have it; where the mass is counted by stages of at most some ratio, of as many as were counted.
pub fn trains(ratio: f64, window: (f64, f64), largest: Option<f64>) -> Vec<Train> {
    match largest {
        Some(largest) => trains_of(stages_of(ratio, largest), ratio, window, largest),
        None => {
            let mut all = (1..=3).map(|count| trains_of(count, ratio, window, LARGEST_STAGE));
            all.find(|found| !found.is_empty()).unwrap_or_default()
        }
    }
}

/// The same with a number of stages, each of at most some ratio.
fn trains_of(count: u32, ratio: f64, (min, max): (f64, f64), largest: f64) -> Vec<Train> {
    let within = |r: f64| min <= r && r <= max && (r / ratio - 1.0).abs() <= FAR;
    let mut found: Vec<Train> = Vec::new();
    let few_teeth = |most: u32| few_teeth(most).filter(|stage| stage.ratio() <= largest * (1.0 + 1e-9));
    if count == 1 {
        let one = few_teeth(MOST_TEETH).filter(|a| within(a.ratio()));
        found.extend(one.map(|a| Train { stages: vec![a] }));
    } else if count == 2 {
        let all: Vec<Stage> = few_teeth(MOST_TEETH).collect();
        for (k, a) in all.iter().enumerate() {
            let second = all[k..].iter().filter(|b| within(a.ratio() * b.ratio()));
            found.extend(second.map(|b| Train { stages: vec![*b, *a] }));
        }
    } else if count == 3 {
        let all: Vec<Stage> = few_teeth(60).collect();
        for (k, a) in all.iter().enumerate() {
            for (l, b) in all.iter().enumerate().skip(k) {
                let third = all[l..].iter().filter(|c| within(a.ratio() * b.ratio() * c.ratio()));
                found.extend(third.map(|c| Train { stages: vec![*c, *b, *a] }));
            }
        }
    }
    let away = |train: &Train| (train.ratio() / ratio - 1.0).abs();
    let rank = |train: &Train| match away(train) {
        off if off <= NEAR => (0, f64::from(train.teeth()), off),
        off => (1, off, 0.0),
    };
    found.sort_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2))
    });
    found
}

/// A design at a ratio that can be built.
#[derive(Debug, Clone)]
pub struct Built<'a> {
    /// A gear that has the ratio; `None` where it is rounded to few digits.
    pub train: Option<Train>,
    /// The design, solved again at that ratio: with its spring, where the joint asks for one.
    pub design: Design<'a>,
}

/// A design of a free ratio at a ratio that can be built: that of a simple planetary gear inside the window of the
/// optimum; else with fewer digits. `None` where neither keeps the limits, or the ratio is none that is free.
pub fn built<'a>(robot: &Robot, joint: &Joint, catalog: &Catalog, design: &Design<'a>) -> Option<Built<'a>> {
    let RatioChoice::Continuous { min, max } = joint.ratio else { return None };
    // A family has gears of its own: at its points they are there, and between them no teeth are known, nor is another ratio better.
    if design.gear.is_some() || joint.family_map().is_some() {
        return None;
    }
    let optimal = design.optimum.ratio;
    // With a spring the window is that of the spring found; another ratio brings another spring.
    let window = match joint.limits.spring {
        Some(_) => (min, max),
        None => (design.optimum.window().min, design.optimum.window().max),
    };
    let trains = trains(optimal, window, joint.gear.mass_per_stage.map(|(_, largest)| largest))
        .into_iter()
        .take(TRIES)
        .map(|train| (train.ratio(), Some(train)));
    let rounded = rounded(optimal, window).into_iter().map(|ratio| (ratio, None));
    trains.chain(rounded).find_map(|(ratio, train)| {
        let design = at_ratio(robot, joint, catalog, design.motor, ratio)?;
        Some(Built { train, design })
    })
}

/// The ratio with few digits, downwards and upwards, where that stays inside a window.
fn rounded(ratio: f64, (min, max): (f64, f64)) -> Vec<f64> {
    let digits = |digits: i32| {
        let step = 10.0_f64.powi(ratio.log10().floor() as i32 + 1 - digits);
        [(ratio / step).floor() * step, (ratio / step).ceil() * step]
    };
    let all = [3, 4, 5].into_iter().flat_map(digits);
    let all = all.map(|r| format!("{r:.6}").parse().unwrap_or(r));
    all.filter(|r| min <= *r && *r <= max).collect()
}

/// The best design of a motor at one ratio; `None` where it is no choice there.
fn at_ratio<'a>(robot: &Robot, joint: &Joint, catalog: &Catalog, motor: &'a Motor, ratio: f64) -> Option<Design<'a>> {
    let joint = Joint { ratio: RatioChoice::Continuous { min: ratio, max: ratio }, ..joint.clone() };
    let demand = JointDemand::new(&joint, catalog);
    let found: Result<Design, Refused> = best_design(Site::new(robot, &joint, &demand), motor, false);
    Some(found.ok()?.with_parts(motor, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_those_that_can_be_put_together() {
        for stage in stages() {
            assert_eq!((stage.sun + stage.ring) % 3, 0);
            assert_eq!(stage.sun + 2 * stage.planet(), stage.ring);
            assert!(stage.planet() >= FEWEST_TEETH && stage.ratio() <= LARGEST_STAGE);
        }
    }

    #[test]
    fn trains_stay_in_their_window_and_the_first_is_near_with_few_teeth() {
        for (ratio, window) in
            [(4.02, (3.0, 4.02)), (9.84, (5.0, 9.84)), (45.93, (20.0, 45.93)), (133.6, (62.0, 133.6))]
        {
            let found = trains(ratio, window, None);
            assert!(!found.is_empty(), "{ratio}");
            assert!(found.iter().all(|t| window.0 <= t.ratio() && t.ratio() <= window.1));
            let first = &found[0];
            let near: Vec<&Train> = found.iter().filter(|t| (t.ratio() / ratio - 1.0).abs() <= NEAR).collect();
            assert!(near.is_empty() || near.iter().all(|t| first.teeth() <= t.teeth()), "{ratio} {first:?}");
        }
        assert!(trains(1.5, (1.0, 2.0), None).is_empty());
        // A mass of two stages of at most 3:1 each: no single stage of 9:1.
        let two = trains(8.9, (8.0, 8.9), Some(3.0));
        assert!(!two.is_empty() && two.iter().all(|t| t.stages.len() == 2));
        assert!(two.iter().flat_map(|t| &t.stages).all(|s| s.ratio() <= 3.0 + 1e-9));
    }

    #[test]
    fn a_rounded_ratio_stays_inside() {
        assert_eq!(rounded(1.53718, (1.0, 1.53718)), [1.53, 1.537, 1.5371]);
        assert!(rounded(1.53718, (1.53717, 1.53719)).is_empty());
    }
}
