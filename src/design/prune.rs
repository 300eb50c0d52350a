//! The first few motors of a joint without solving them all.
//!
//! The one idea: a lower bound per motor is cheap (`RatioProgram::lower_bound`). Motors are solved in the
//! order of their bounds, in blocks of fixed size; once the bound of the next one is above the k-th best
//! objective found, neither it nor any after it can be among the first k. What is found is what solving
//! all would have found, and does not depend on the number of threads: blocks do not. Where nobody asks why a
//! motor cannot, one that certainly cannot is not solved either.

use rayon::prelude::*;

use super::answer::{Design, Pruned, Refused, Sorted};
use super::best::{is_impossible, lacking, with_windows};
use super::mount::{Mount, Site};
use super::options::{Options, Stopped};
use super::program::RatioProgram;
use super::windings::best_wound;
use crate::catalog::{Catalog, Motor};

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
    let bound = |motor| site.stop.unless(lower_bound(site, motor));
    let bounds: Vec<Option<f64>> = catalog.motors.par_iter().map(bound).collect::<Result<_, _>>()?;
    // A motor without a bound is solved: that gives the reason why it cannot.
    let (mut bounded, mut queue) = (Vec::new(), Vec::new());
    for (index, bound) in bounds.into_iter().enumerate() {
        match bound {
            _ if site.joint.motors.turns.pass_over(&catalog.motors[index]) => {}
            Some(bound) => bounded.push((bound, index)),
            None => queue.push(index),
        }
    }
    bounded.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // What was found, by motor; of it only candidates count among the first.
    let mut found: Vec<(usize, Result<Design, Refused>)> = Vec::new();
    let mut objectives: Vec<f64> = Vec::new();
    let mut impossible = Vec::new();
    let mut next = 0;
    loop {
        let kth = keep.checked_sub(1).and_then(|k| objectives.get(k)).copied();
        let may_enter = |bound: f64| kth.is_none_or(|kth| bound - CLEAR * bound.abs() <= kth) && keep > 0;
        let block: Vec<usize> =
            bounded[next..].iter().take(BLOCK).take_while(|(b, _)| may_enter(*b)).map(|b| b.1).collect();
        next += block.len();
        queue.extend(block);
        if queue.is_empty() {
            break;
        }
        let solve = |index: &usize| {
            let motor = &catalog.motors[*index];
            let certain = !options.reasons && is_impossible(site, motor);
            let found = (!certain).then(|| best_wound(site, motor, options.only_checked));
            (options.tick)();
            site.stop.unless(found)
        };
        let solved: Vec<_> = queue.par_iter().map(solve).collect::<Result<_, _>>()?;
        for (index, result) in queue.drain(..).zip(solved) {
            match result {
                Some(result) => {
                    objectives.extend(result.as_ref().ok().map(|design| design.optimum.objective));
                    found.push((index, result));
                }
                None => impossible.push(index),
            }
        }
        objectives.sort_by(f64::total_cmp);
    }
    if objectives.is_empty() {
        // What stands in the way of a joint without a design is told of every motor.
        let why = |index: &usize| site.stop.unless(best_wound(site, &catalog.motors[*index], options.only_checked));
        let solved: Vec<_> = impossible.par_iter().map(why).collect::<Result<_, _>>()?;
        found.extend(impossible.drain(..).zip(solved));
    }
    found.sort_by_key(|(index, _)| *index);
    let mut sorted = Sorted::of(found.into_iter().map(|(_, result)| result));
    let behind = sorted.candidates.len().saturating_sub(keep);
    sorted.candidates.truncate(keep);
    let whole = std::mem::take(&mut sorted.candidates).into_par_iter();
    sorted.candidates = whole.map(|design| with_windows(site, design, options.only_checked)).collect();
    let not_solved = bounded[next..].iter().map(|(bound, index)| (&catalog.motors[*index], *bound)).collect();
    impossible.sort_unstable();
    let impossible = impossible.into_iter().map(|index| &catalog.motors[index]).collect();
    Ok((sorted, Pruned { keep, behind, impossible, not_solved }))
}

/// What the objective is nowhere below for a motor; `None` where it has to be solved to be told.
fn lower_bound(site: Site, motor: &Motor) -> Option<f64> {
    let Site { joint, demand, .. } = site;
    // A spring takes load off: a bound without it is none.
    let counts = |quantity| joint.objective.weight(quantity) > 0.0;
    if joint.limits.spring.is_some() || lacking(motor, demand.load.duration.is_some(), counts).is_some() {
        return None;
    }
    let bound = |mount: Mount| {
        let (min, max) = mount.range()?;
        RatioProgram::new(&mount.prepared().ok()?, &joint.objective, min, max).lower_bound()
    };
    site.mounts(motor).filter_map(bound).reduce(f64::min)
}
