//! The first few motors of a joint without solving them all.
//!
//! The one idea: a lower bound per motor is cheap (`RatioProgram::lower_bound`). Motors are solved in the
//! order of their bounds, in blocks of fixed size; once the bound of the next one is above the k-th best
//! objective found, neither it nor any after it can be among the first k. What is found is what solving
//! all would have found, and does not depend on the number of threads: blocks do not. Where nobody asks why a
//! motor cannot, one that certainly cannot is not solved either.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::answer::{Design, Pruned, Refused, Sorted};
use super::best::{is_impossible, is_known, lacking, with_windows};
use super::mount::{Mount, Site};
use super::options::{Options, Stopped};
use super::program::{Bound, RatioProgram};
use super::windings::best_wound;
use gearwise_model::catalog::{Catalog, Motor};

/// Motors that are solved together.
const BLOCK: usize = 8;
/// Relative distance by which a bound must be above the k-th best: more than the accuracy of either.
const CLEAR: f64 = 1e-6;

/// What came of the motors of a joint that were solved, of the candidates the best `keep`, and the rest.
pub(super) fn first<'a>(
    site: Site<'a, '_>,
    catalog: &'a Catalog,
    keep: usize,
    options: &Options,
) -> Result<(Sorted<'a>, Pruned<'a>), Stopped> {
    // The search for a number of turns reads windows.
    let site = Site { whole_windows: site.joint.motors.turns.range().is_none(), ..site };
    // Why a motor cannot is seen by the limits over samples: where nobody asks, they are looked at when its turn comes.
    let first_look = if options.reasons { Look::All } else { Look::Loose };
    let first = |index: &usize| site.stop.unless(bound(site, &catalog.motors[*index], first_look));
    let asked: Vec<usize> =
        (0..catalog.motors.len()).filter(|k| !site.joint.motors.pass_over(&catalog.motors[*k])).collect();
    let bounds: Vec<Bound> = asked.par_iter().map(first).collect::<Result<_, _>>()?;
    let mut motors = Motors::default();
    for (motor, bound) in asked.into_iter().zip(bounds) {
        motors.sort(motor, bound, first_look, options);
    }
    // What was found, by motor; of it only candidates count among the first.
    let mut found: Vec<(usize, Result<Design, Refused>)> = Vec::new();
    let mut objectives: Vec<f64> = Vec::new();
    loop {
        let kth = keep.checked_sub(1).and_then(|k| objectives.get(k)).copied();
        let may_enter = |open: &Open| kth.is_none_or(|kth| open.bound - CLEAR * open.bound.abs() <= kth) && keep > 0;
        let mut block = Vec::new();
        while block.len() < BLOCK
            && let Some(Reverse(next)) = motors.open.peek().filter(|next| may_enter(&next.0))
        {
            block.push(*next);
            motors.open.pop();
        }
        if block.is_empty() && motors.queue.is_empty() {
            break;
        }
        let (loose, ready): (Vec<Open>, Vec<Open>) = block.into_iter().partition(|open| open.look == Look::Loose);
        let look = |open: &Open| site.stop.unless(bound(site, &catalog.motors[open.motor], Look::All));
        let bounds: Vec<Bound> = loose.par_iter().map(look).collect::<Result<_, _>>()?;
        for (Open { motor, .. }, bound) in loose.into_iter().zip(bounds) {
            motors.sort(motor, bound, Look::All, options);
        }
        motors.queue.extend(ready.into_iter().map(|open| open.motor));
        let solve = |index: &usize| {
            let motor = &catalog.motors[*index];
            let certain = !options.reasons && is_impossible(site, motor);
            let found = (!certain).then(|| best_wound(site, motor, options.only_checked));
            (options.tick)();
            site.stop.unless(found)
        };
        let solved: Vec<_> = motors.queue.par_iter().map(solve).collect::<Result<_, _>>()?;
        for (index, result) in motors.queue.drain(..).zip(solved) {
            match result {
                Some(result) => {
                    objectives.extend(result.as_ref().ok().map(|design| design.optimum.objective));
                    found.push((index, result));
                }
                None => motors.impossible.push(index),
            }
        }
        objectives.sort_by(f64::total_cmp);
    }
    if objectives.is_empty() {
        // What stands in the way of a joint without a design is told of every motor.
        let why = |index: &usize| site.stop.unless(best_wound(site, &catalog.motors[*index], options.only_checked));
        let solved: Vec<_> = motors.impossible.par_iter().map(why).collect::<Result<_, _>>()?;
        found.extend(motors.impossible.drain(..).zip(solved));
    }
    found.sort_by_key(|(index, _)| *index);
    let mut sorted = Sorted::of(found.into_iter().map(|(_, result)| result));
    let behind = sorted.candidates.len().saturating_sub(keep);
    sorted.candidates.truncate(keep);
    let whole = std::mem::take(&mut sorted.candidates).into_par_iter();
    sorted.candidates = whole.map(|design| with_windows(site, design, options.only_checked)).collect();
    let not_solved = motors.open.into_sorted_vec().into_iter().rev();
    let not_solved = not_solved.map(|Reverse(open)| (&catalog.motors[open.motor], open.bound)).collect();
    motors.impossible.sort_unstable();
    let impossible = motors.impossible.into_iter().map(|index| &catalog.motors[index]).collect();
    Ok((sorted, Pruned { keep, behind, impossible, not_solved }))
}

/// The motors of a joint, by what is known of them.
#[derive(Default)]
struct Motors {
    /// They may be among the first.
    open: BinaryHeap<Reverse<Open>>,
    /// They are to be solved.
    queue: Vec<usize>,
    /// They certainly cannot.
    impossible: Vec<usize>,
}

impl Motors {
    fn sort(&mut self, motor: usize, bound: Bound, look: Look, options: &Options) {
        match bound {
            Bound::Of(bound) => self.open.push(Reverse(Open { bound, motor, look })),
            Bound::Nowhere if !options.reasons => {
                (options.tick)();
                self.impossible.push(motor);
            }
            // Solving gives the reason why it cannot.
            Bound::Nowhere | Bound::Unknown => self.queue.push(motor),
        }
    }
}

/// What a bound of a motor looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Look {
    /// Not at the limits over samples.
    Loose,
    /// At all limits.
    All,
}

/// A motor that may be among the first.
#[derive(Debug, Clone, Copy)]
struct Open {
    bound: f64,
    motor: usize,
    look: Look,
}

impl Ord for Open {
    /// By bound, then in the order of the catalogue.
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(self.motor.cmp(&other.motor))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

/// What is certain of a motor without solving.
fn bound(site: Site, motor: &Motor, look: Look) -> Bound {
    let Site { joint, demand, .. } = site;
    // A spring takes load off: a bound without it is none.
    let counts = |quantity| joint.objective.weight(quantity) > 0.0;
    // A module is one design: it is looked at.
    if motor.inside.is_some() {
        return Bound::Unknown;
    }
    if joint.limits.spring.is_some() || lacking(motor, demand.load.duration.is_some(), counts).is_some() {
        return Bound::Unknown;
    }
    let of_mount = |mount: Mount| {
        let range = mount.range()?;
        let prepared = match mount.prepared() {
            Ok(prepared) => prepared,
            // That a number is missing is no reason to say that the motor cannot.
            Err(why) => return why.unknown().map(|_| Bound::Unknown),
        };
        let program = RatioProgram::new(&prepared, &joint.objective, range.0, range.1);
        Some(match program.bounded(look == Look::All) {
            Bound::Nowhere if !is_known(&prepared) => Bound::Unknown,
            bound => bound,
        })
    };
    let least = |a: Bound, b: Bound| match (a, b) {
        (Bound::Unknown, _) | (_, Bound::Unknown) => Bound::Unknown,
        (Bound::Of(a), Bound::Of(b)) => Bound::Of(a.min(b)),
        (Bound::Nowhere, other) | (other, Bound::Nowhere) => other,
    };
    match site.mounts(motor).filter_map(of_mount).reduce(least) {
        None => Bound::Unknown,
        // With other turns it may.
        Some(Bound::Nowhere) if joint.motors.turns.range().is_some() => Bound::Unknown,
        Some(bound) => bound,
    }
}
