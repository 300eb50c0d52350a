//! How often a motor keeps its limits, and is the best, when all motors vary within their tolerances.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::RobustDesign;
use super::corners::{Toleranced, toleranced, with_numbers};
use crate::answer::Design;
use crate::judge;
use crate::mount::Site;
use gearwise_model::catalog::Motor;

/// How many samples of the motors a probability rests on.
pub const SAMPLES: usize = 1000;
/// How many motors of the nominal order are compared with each other.
pub const CONTENDERS: usize = 5;

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

/// Standard error of a share that was found in [`SAMPLES`] samples.
pub fn standard_error(share: f64) -> f64 {
    (share * (1.0 - share) / SAMPLES as f64).sqrt()
}

/// A random motor within its tolerances: each ± is the 95 % interval (two standard deviations) of an
/// independent normal error of the logarithm, as in the metrics. A number that is zero, half a normal one; between what several
/// sources print, the logarithm is anywhere.
fn sample(motor: &Motor, all: &[Toleranced], generator: &mut Pcg64) -> Option<Motor> {
    let numbers: Vec<(&Toleranced, f64)> = all
        .iter()
        .map(|t| {
            let z = normal(generator);
            let deviation = 0.5 * t.tolerance;
            let value = match t.published {
                // A number that may have either sign has no logarithm.
                _ if t.is_signed() => t.value + deviation * z,
                _ if t.value == 0.0 => deviation * z.abs(),
                // Between what sources print none is likelier.
                Some([low, high]) => low * (high / low).powf(uniform(generator)),
                None => t.value * (deviation / t.value * z).exp(),
            };
            (t, t.possible(value))
        })
        .collect();
    with_numbers(motor, numbers.into_iter())
}

/// A number between zero and one.
pub(super) fn uniform(generator: &mut Pcg64) -> f64 {
    ((generator.next_u64() >> 11) as f64 + 0.5) * 2.0_f64.powi(-53)
}

/// A standard normal number (Box and Muller).
fn normal(generator: &mut Pcg64) -> f64 {
    let (a, b) = (uniform(generator), uniform(generator));
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// A seed that depends on the names alone (FNV-1a).
fn seed(motor: &str, joint: &str) -> u64 {
    let bytes = motor.bytes().chain([0]).chain(joint.bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Objective of each sample at a ratio, where it keeps all limits.
type Course = Vec<Option<f64>>;

/// How the first motors of the nominal order fare among each other.
pub(super) fn contenders<'a>(
    site: Site<'a, '_>,
    nominal: &[Design<'a>],
    robust: &[RobustDesign<'a>],
    only_checked: bool,
) -> Vec<Contender<'a>> {
    let joint = site.joint;
    let first: Vec<&Design> = nominal.iter().take(CONTENDERS).collect();
    let sampled: Vec<(Course, Option<Course>)> = first
        .par_iter()
        .map(|design| {
            let motor = design.motor;
            let all = toleranced(motor);
            let own = robust.iter().find(|r| r.nominal.motor.id == motor.id);
            let at = |motor: &Motor, gear: Option<&str>, ratio: f64| {
                let prepared = site.mount(motor, gear).ok()?.prepared().ok()?;
                let objective = prepared.kept_objective_at(&joint.objective, ratio)?;
                // What cannot be judged is not known to be kept.
                let is_open = judge::may_change(&prepared, only_checked)
                    && judge::doubt(&prepared, ratio, only_checked).is_some();
                (!is_open).then_some(objective)
            };
            let mut generator = Pcg64::seed_from_u64(seed(&motor.id, &joint.name));
            let motors: Vec<Option<Motor>> = match all.is_empty() {
                true => Vec::new(),
                false => (0..SAMPLES).map(|_| sample(motor, &all, &mut generator)).collect(),
            };
            let course = |gear: Option<&str>, ratio: f64| -> Course {
                match all.is_empty() {
                    true => vec![at(motor, gear, ratio); SAMPLES],
                    false => motors.iter().map(|motor| at(motor.as_ref()?, gear, ratio)).collect(),
                }
            };
            (course(design.gear, design.optimum.ratio), own.map(|own| course(own.gear, own.optimum.ratio)))
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
