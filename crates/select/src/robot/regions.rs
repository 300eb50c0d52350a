//! The best combinations where actuators load one another, by regions of what they weigh.
//!
//! The one idea: in a region each carried actuator weighs between two numbers. What a joint costs there is bounded from below by its
//! tangents (`tangent`) at one load, less the masses at prices; as the prices are common, the joints fall apart: each way to build a
//! joint has one cost, which bounds all combinations with it. What the bound rules out is left out, which narrows the region, and
//! so on; a region in which too much is left is divided by the mass of one joint. The region with the least bound comes first.

use std::sync::Arc;

use rayon::prelude::*;

use super::carry;
use super::context::{Among, Context};
use super::menu::{Item, pieces};
use super::search::{self, Answer, Found, Rules, Table};
use super::shared::Price;
use super::tangent::{Directions, Over, Tangent};
use crate::mount::{Mount, Site};
use gearwise_model::requirement::{Joint, Objective, Quantity};

/// How often a region is narrowed at most before it is searched.
const ROUNDS: usize = 6;
/// Combinations that are solved at most in each round, and in the search of a region.
const SOLVED: (usize, usize) = (24, 400);
/// The same in the search of a region where each takes a program of its own.
const SOLVED_SHARED: usize = 60;
/// Bounds of ways to build a joint that are made at most.
const BOUNDED: usize = 100_000;
/// Steps of [`Work`](super::work::Work) that a bound of a way to build a joint takes.
const BOUND: usize = 300;
/// How often a range of ratios is divided at most, to see which ways are worth more, and for those.
const DIVISIONS: (usize, usize) = (6, 200);
/// What is nearer than this to the best is not told from it.
const CLOSE: f64 = 1e-9;

/// A region: the ways to build each joint that are left, and a bound of all combinations of them.
#[derive(Clone)]
struct Region {
    ways: Vec<Vec<usize>>,
    bound: f64,
    tables: Vec<Table>,
    /// Whether the first of them is without prices.
    has_plain: bool,
    /// What all combinations draw at least at instants at which one of them drew too much, over what they may; where none was found.
    too_much: Option<Table>,
}

/// Finds the best combinations.
pub(super) fn solve<'a>(context: &mut Context<'a>, rules: Rules) -> Answer<'a> {
    let mut answer = Answer::nothing();
    let all = (0..context.ways.len()).map(|j| (0..context.ways[j].len()).collect()).collect();
    let mut open =
        vec![Region { ways: all, bound: f64::NEG_INFINITY, tables: Vec::new(), has_plain: false, too_much: None }];
    while let Some(place) = (0..open.len()).min_by(|a, b| open[*a].bound.total_cmp(&open[*b].bound)) {
        let region = open.swap_remove(place);
        if region.bound >= answer.threshold(rules.keep) || region.ways.iter().any(Vec::is_empty) {
            answer.regions.0 += 1;
            continue;
        }
        let short = match context.returned {
            Some(_) => SOLVED.0,
            None if context.shares_power() => SOLVED_SHARED,
            None => SOLVED.1,
        };
        let few = context.most_bounded.map_or(search::MAX_SOLVED_LOADED, |_| short);
        let most = context.at_most(few);
        let programs = context.shares_power() && answer.solved >= most;
        let bounded = answer.bounded >= context.at_most(context.most_bounded.unwrap_or(BOUNDED));
        if programs || bounded || context.ends() {
            answer.finished = false;
            answer.lower = answer.lower.min(region.bound);
            answer.leave(&region.ways);
            answer.regions.1 += 1;
            continue;
        }
        answer.regions.0 += 1;
        let left = narrow(context, region, rules, &mut answer);
        open.extend(left.into_iter().flat_map(|region| divide(context, region, rules, &mut answer)));
    }
    if let Some(best) = answer.found.first() {
        answer.lower = answer.lower.min(best.lower);
    }
    answer
}

/// Narrows a region; `None` where nothing is left of it.
fn narrow<'a>(context: &mut Context<'a>, mut region: Region, rules: Rules, answer: &mut Answer<'a>) -> Option<Region> {
    for round in 0..ROUNDS {
        // A search needs a table.
        if round > 0 && context.ends() {
            break;
        }
        let best = answer.found.first().map(|found| found.value);
        let counts = |ways: &[Vec<usize>]| ways.iter().map(Vec::len).sum::<usize>();
        let before = counts(&region.ways);
        region.too_much = if answer.found.is_empty() { too_much(context, &region.ways) } else { None };
        rule_out_too_much(&mut region);
        if region.ways.iter().any(Vec::is_empty) {
            return None;
        }
        let table = table(context, &region.ways, answer.found.first(), answer.threshold(rules.keep), rules, true);
        answer.bounded += before;
        region.tables.push(table);
        // The last of them are the best; one of the region around this one may show what they do not.
        if region.tables.len() > 3 {
            region.tables.remove(1);
        }
        rule_out(context, &mut region, rules, answer.threshold(rules.keep));
        if region.ways.iter().any(Vec::is_empty) {
            return None;
        }
        search(context, &region, rules, answer, SOLVED.0);
        if answer.found.is_empty() {
            // What is light loads the others least: where few combinations can be at all, one that can be is the first step.
            answer.solved += 1;
            let light = lightest(context, &region.ways).and_then(|found| search::counted(found, rules));
            light.into_iter().filter(|found| found.value.is_finite()).for_each(|found| answer.take(found, rules.keep));
        }
        rule_out(context, &mut region, rules, answer.threshold(rules.keep));
        if region.ways.iter().any(Vec::is_empty) {
            return None;
        }
        let better = answer.found.first().map(|found| found.value) != best;
        if !better && counts(&region.ways) * 10 > before * 9 {
            // Where bounds say little, a better combination near the best one narrows the region, too.
            match descend(context, &region, rules, answer) {
                true => rule_out(context, &mut region, rules, answer.threshold(rules.keep)),
                false => break,
            }
            if region.ways.iter().any(Vec::is_empty) {
                return None;
            }
        }
    }
    Some(region)
}

/// Ways of each joint that are tried in the place of the best combination's, the cheapest first, and how often all joints are gone
/// through.
const TRIED: (usize, usize) = (16, 4);

/// Goes from the best combination to better ones that differ at one joint, until there is none; whether there was one.
fn descend<'a>(context: &mut Context<'a>, region: &Region, rules: Rules, answer: &mut Answer<'a>) -> bool {
    let (Some(first), Some(table)) = (answer.found.first().cloned(), region.tables.last()) else { return false };
    let mut best = first;
    let before = best.value;
    for _ in 0..TRIED.1 {
        let start = best.value;
        for j in 0..region.ways.len() {
            let mut cheap: Vec<usize> = region.ways[j]
                .iter()
                .copied()
                .filter(|way| *way != best.ways[j] && table.costs[j][*way].is_finite())
                .collect();
            cheap.sort_by(|a, b| table.costs[j][*a].total_cmp(&table.costs[j][*b]).then(a.cmp(b)));
            for way in cheap.into_iter().take(TRIED.0) {
                if context.ends() {
                    break;
                }
                let mut chosen = best.ways.clone();
                chosen[j] = way;
                answer.solved += 1;
                let threshold = if rules.lightest { f64::INFINITY } else { best.value };
                let found =
                    context.complete(&chosen, threshold).found().and_then(|found| search::counted(found, rules));
                if let Some(found) = found.filter(|found| found.value < best.value) {
                    answer.take(found.clone(), rules.keep);
                    best = found;
                }
            }
        }
        if best.value >= start {
            break;
        }
    }
    best.value < before
}

/// Ways that are tried together.
const TOGETHER: usize = 8;

/// A combination of the lightest way of each joint that can be under the load that it has then; `None` where one has none.
fn lightest<'a>(context: &mut Context<'a>, ways: &[Vec<usize>]) -> Option<Found<'a>> {
    let mut chosen = vec![0; ways.len()];
    let mut masses = vec![0.0; ways.len()];
    for j in context.order.clone() {
        let coordinates = carry::coordinates(&context.robot.joints[j], |k| masses[k]);
        let mut light = ways[j].clone();
        light.sort_by(|a, b| {
            let mass = |way: &usize| context.ways[j][*way].mass.0;
            mass(a).total_cmp(&mass(b)).then(a.cmp(b))
        });
        let found = light.chunks(TOGETHER).find_map(|some| {
            let items = context.exact(j, some, &coordinates);
            some.iter().zip(items).find_map(|(way, item)| Some((*way, item?.mass)))
        });
        (chosen[j], masses[j]) = found?;
    }
    context.complete(&chosen, f64::INFINITY).found()
}

/// Searches a region, and divides it where that was too much.
fn divide<'a>(context: &mut Context<'a>, mut region: Region, rules: Rules, answer: &mut Answer<'a>) -> Vec<Region> {
    let by = dividing(context, &region.ways);
    let few = if context.shares_power() { SOLVED_SHARED } else { SOLVED.1 };
    let most = if by.is_some() { few } else { context.at_most(search::MAX_SOLVED_LOADED) };
    let (finished, lower) = search(context, &region, rules, answer, most);
    if finished {
        answer.lower = answer.lower.min(lower);
        return Vec::new();
    }
    let Some((joint, middle)) = by else {
        answer.finished = false;
        answer.lower = answer.lower.min(lower);
        answer.leave(&region.ways);
        answer.regions = (answer.regions.0 - 1, answer.regions.1 + 1);
        return Vec::new();
    };
    // Over a wide region prices may say less than nothing.
    if !region.has_plain && !rules.lightest {
        let plain = table(context, &region.ways, None, f64::INFINITY, rules, false);
        answer.bounded += region.ways.iter().map(Vec::len).sum::<usize>();
        region.tables.insert(0, plain);
        region.has_plain = true;
        rule_out(context, &mut region, rules, answer.threshold(rules.keep));
    }
    let mass = |way: &usize| context.ways[joint][*way].mass.0;
    let halves = [false, true].map(|heavy| {
        let mut ways = region.ways.clone();
        ways[joint].retain(|way| (mass(way) > middle) == heavy);
        Region { ways, bound: region.bound.max(lower), ..region.clone() }
    });
    halves.into_iter().collect()
}

/// The joint whose mass leaves most open, and where its masses are divided; `None` where all are known.
fn dividing(context: &Context, ways: &[Vec<usize>]) -> Option<(usize, f64)> {
    let robot = context.robot;
    let spread = |joint: usize| {
        let (low, high) = masses(context, joint, &ways[joint]);
        let of = |carrier: &Joint| {
            let carried = carrier.carries.iter().filter(|c| c.joint == joint);
            carried.map(|c| c.torque_per_mass.iter().fold(0.0_f64, |most, t| most.max(t.abs()))).sum::<f64>()
        };
        (high - low) * robot.joints.iter().map(of).sum::<f64>()
    };
    let widest = (0..ways.len()).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).filter(|j| spread(*j) > 0.0)?;
    let mut known: Vec<f64> = ways[widest].iter().map(|way| context.ways[widest][*way].mass.0).collect();
    known.sort_by(f64::total_cmp);
    known.dedup();
    // As many masses on both sides.
    let lower = known[(known.len() - 1) / 2];
    (known.len() > 1).then_some((widest, lower))
}

/// Lightest and heaviest of some ways to build a joint \[kg\].
fn masses(context: &Context, joint: usize, ways: &[usize]) -> (f64, f64) {
    let of = |span: (f64, f64), way: &usize| {
        let mass = context.ways[joint][*way].mass;
        (span.0.min(mass.0), span.1.max(mass.1))
    };
    let span = ways.iter().fold((f64::INFINITY, f64::NEG_INFINITY), of);
    if span.0.is_finite() { span } else { (0.0, 0.0) }
}

/// Searches what is left of a region: whether it came to its end, and its bound.
fn search<'a>(
    context: &mut Context<'a>,
    region: &Region,
    rules: Rules,
    answer: &mut Answer<'a>,
    most: usize,
) -> (bool, f64) {
    let entries = context.entries(&region.ways);
    let mut tables = context.with_prices_of_mass(region.tables.clone(), &region.ways, rules);
    tables.extend(region.too_much.clone());
    let left = |costs: &Vec<f64>, ways: &Vec<usize>| ways.iter().map(|way| costs[*way]).collect();
    let compact = |table: &Table| Table {
        costs: table.costs.iter().zip(&region.ways).map(|(costs, ways)| left(costs, ways)).collect(),
        ..*table
    };
    let tables: Vec<Table> = tables.iter().map(compact).collect();
    let found = std::mem::take(&mut answer.found);
    let part = search::run(&mut Among { context, ways: &region.ways }, &entries, &tables, rules, most, found);
    answer.found = part.found;
    answer.nodes += part.nodes;
    answer.solved += part.solved;
    (part.finished, part.lower)
}

/// Of all ways to build each joint those of combinations that may be better than a value, by some tables of prices.
pub(super) fn may_be_better(context: &Context, tables: Vec<Table>, rules: Rules, threshold: f64) -> Vec<Vec<usize>> {
    let ways = (0..context.ways.len()).map(|j| (0..context.ways[j].len()).collect()).collect();
    let mut region = Region { ways, bound: f64::NEG_INFINITY, tables, has_plain: false, too_much: None };
    rule_out(context, &mut region, rules, threshold);
    region.ways
}

/// Leaves out what no combination below a value has, and raises the region's bound.
fn rule_out(context: &Context, region: &mut Region, rules: Rules, threshold: f64) {
    let tables = context.with_prices_of_mass(region.tables.clone(), &region.ways, rules);
    let entries = context.entries(&region.ways);
    let mut keep: Vec<Vec<bool>> = region.ways.iter().map(|ways| vec![true; ways.len()]).collect();
    for table in tables.iter().filter(|table| !table.is_excess) {
        let cost = |joint: usize, k: usize| {
            let way = region.ways[joint][k];
            search::cost(table, rules, joint, way, &entries[joint][k])
        };
        let least = |joint: usize| (0..entries[joint].len()).map(|k| cost(joint, k)).fold(f64::INFINITY, f64::min);
        let all: Vec<f64> = (0..entries.len()).map(least).collect();
        let bound = search::constant(table, rules) + all.iter().sum::<f64>();
        region.bound = region.bound.max(bound);
        for (joint, keep) in keep.iter_mut().enumerate() {
            let others = bound - all[joint];
            for (k, keep) in keep.iter_mut().enumerate() {
                let of = cost(joint, k);
                let ruled_out =
                    if all[joint].is_finite() && others.is_finite() { others + of >= threshold } else { false };
                *keep &= !(of == f64::INFINITY || ruled_out);
            }
        }
    }
    for (ways, keep) in region.ways.iter_mut().zip(keep) {
        let mut keep = keep.into_iter();
        ways.retain(|_| keep.next().unwrap_or(true));
    }
}

/// Leaves out what draws too much in all combinations.
fn rule_out_too_much(region: &mut Region) {
    let Some(table) = &region.too_much else { return };
    let least = |(costs, ways): (&Vec<f64>, &Vec<usize>)| ways.iter().map(|w| costs[*w]).fold(f64::INFINITY, f64::min);
    let all: Vec<f64> = table.costs.iter().zip(&region.ways).map(least).collect();
    for (joint, ways) in region.ways.iter_mut().enumerate() {
        let others = all.iter().enumerate().filter(|(j, _)| *j != joint).map(|(_, least)| least).sum::<f64>();
        // In watts, as all of it is.
        let beyond = |way: &usize| table.offset + others + table.costs[joint][*way] > -table.offset * CLOSE;
        ways.retain(|way| !beyond(way));
    }
}

/// Least power of each way to build each joint at the instants at which some combination drew too much, less what its mass is worth
/// to those that carry it; `None` where none drew too much.
fn too_much(context: &mut Context, ways: &[Vec<usize>]) -> Option<Table> {
    let price = context.too_much.as_ref().map(Price::of_all).filter(|price| !price.rows.is_empty())?;
    let limit = context.limit()?;
    let (powers, _) = context.powers(&price.shares());
    let n = ways.len();
    let reach: Vec<(f64, f64)> = (0..n).map(|j| masses(context, j, &ways[j])).collect();
    // What is light draws least, mostly.
    let center: Vec<f64> = reach.iter().map(|(low, _)| *low).collect();
    let mut costs: Vec<Vec<f64>> = context.ways.iter().map(|ways| vec![f64::INFINITY; ways.len()]).collect();
    let mut prices = vec![0.0; n];
    for j in context.order.clone() {
        let carried: Vec<usize> = context.robot.joints[j].carries.iter().map(|c| c.joint).collect();
        let bounds = if carried.is_empty() {
            context.certain_power(j, &ways[j], &powers[j])
        } else {
            let mut place = Place::new(context, j, &center, &reach, powers[j].clone());
            place.joint.objective = Objective { terms: Vec::new() };
            let nothing = vec![0.0; carried.len()];
            let here = vec![(0.0, 0.0); carried.len()];
            let over = Over { masses: &here, prices: &nothing, enough: f64::INFINITY, divisions: DIVISIONS.0 };
            let of_here = place.bounds(context, j, &ways[j], over, &[]);
            let least = (0..ways[j].len()).min_by(|a, b| of_here[*a].total_cmp(&of_here[*b]));
            let slopes = least.and_then(|k| place.slopes_between(context, j, ways[j][k])).unwrap_or(nothing);
            carried.iter().zip(&slopes).for_each(|(k, slope)| prices[*k] += slope);
            let over = Over { masses: &place.masses, prices: &slopes, enough: f64::INFINITY, divisions: DIVISIONS.0 };
            place.bounds(context, j, &ways[j], over, &[])
        };
        ways[j].iter().zip(bounds).for_each(|(way, bound)| costs[j][*way] = bound);
    }
    for j in 0..n {
        for way in &ways[j] {
            let (low, high) = context.ways[j][*way].mass;
            costs[j][*way] += (prices[j] * (low - center[j])).min(prices[j] * (high - center[j]));
        }
    }
    Some(Table { per_mass: 0.0, costs, offset: -limit, is_excess: true })
}

/// A carrying joint at the load of a table.
struct Place {
    joint: Joint,
    directions: Directions,
    /// For each carried joint how much lighter and heavier it may be \[kg\].
    masses: Vec<(f64, f64)>,
    coordinates: Vec<f64>,
    /// Samples whose power has a price \[objective/W\].
    power: Vec<(usize, f64)>,
}

/// Costs of all ways that are left, at the masses of a combination; without one, at those that seem best one after another. `priced`
/// says whether masses have prices.
fn table<'a>(
    context: &mut Context<'a>,
    ways: &[Vec<usize>],
    found: Option<&Found<'a>>,
    threshold: f64,
    rules: Rules,
    priced: bool,
) -> Table {
    let n = ways.len();
    // Power of all joints has a price where it is limited and some combination was solved.
    let price = match found.map(|found| &found.price).filter(|price| !price.rows.is_empty()) {
        Some(price) => Some(price.clone()),
        None => context.too_much.clone().filter(|_| found.is_none()),
    };
    let price = price.filter(|_| priced && !rules.lightest && context.limit().is_some());
    let (powers, worth_of_power) = context.powers(&price.unwrap_or_default());
    let reach: Vec<(f64, f64)> = (0..n).map(|j| masses(context, j, &ways[j])).collect();
    let given = found.is_some();
    let of_found = |found: &Found| found.items.iter().map(|item| item.mass).collect();
    let mut center: Vec<f64> = found.map_or_else(|| vec![0.0; n], of_found);
    // The masses of a combination elsewhere are moved into the region.
    let moved = |(mass, (low, high)): (&f64, &(f64, f64))| mass < low || mass > high;
    let found = found.filter(|_| !center.iter().zip(&reach).any(moved));
    center.iter_mut().zip(&reach).for_each(|(mass, (low, high))| *mass = mass.clamp(*low, *high));
    let mut costs: Vec<Vec<f64>> = context.ways.iter().map(|ways| vec![f64::INFINITY; ways.len()]).collect();
    // The price of a kilogram at each joint.
    let mut prices = vec![0.0; n];
    let mut places: Vec<Option<(Place, Vec<f64>)>> = (0..n).map(|_| None).collect();
    for j in context.order.clone() {
        let scale = context.total.scale[j];
        let carried: Vec<usize> = context.robot.joints[j].carries.iter().map(|c| c.joint).collect();
        if carried.is_empty() {
            let of_ways = context.certain_costs(j, &ways[j], &powers[j]);
            ways[j].iter().zip(of_ways).for_each(|(way, cost)| costs[j][*way] = cost);
            let least = ways[j].iter().min_by(|a, b| costs[j][**a].total_cmp(&costs[j][**b]));
            if let (false, Some(way)) = (given, least) {
                center[j] = context.ways[j][*way].mass.0;
            }
            continue;
        }
        let of_power = powers[j].iter().map(|(sample, price)| (*sample, price / scale)).collect();
        let place = Place::new(context, j, &center, &reach, of_power);
        let here = vec![(0.0, 0.0); carried.len()];
        let nothing = vec![0.0; carried.len()];
        let over = Over { masses: &here, prices: &nothing, enough: f64::INFINITY, divisions: DIVISIONS.0 };
        let of_found = found.and_then(|found| place.slopes_of(context, j, &found.items[j]));
        let (reference, slopes) = match of_found {
            Some(slopes) => (None, slopes),
            None => {
                let of_here = place.bounds(context, j, &ways[j], over, &[]);
                place.reference(context, j, &ways[j], &of_here)
            }
        };
        if let (false, Some(way)) = (given, reference) {
            center[j] = context.ways[j][way].mass.0;
        }
        let slopes = if rules.lightest || !priced { nothing } else { slopes };
        carried.iter().zip(&slopes).for_each(|(k, slope)| prices[*k] += scale * slope);
        places[j] = Some((place, slopes));
    }
    for j in 0..n {
        let Some((place, slopes)) = &places[j] else { continue };
        let over = Over { masses: &place.masses, prices: slopes, enough: f64::INFINITY, divisions: DIVISIONS.0 };
        let bounds = place.bounds(context, j, &ways[j], over, &[]);
        for (way, bound) in ways[j].iter().zip(bounds) {
            costs[j][*way] = context.total.scale[j] * bound;
        }
    }
    if rules.lightest {
        let mass = context.masses();
        let of = |joint: usize, way: usize| {
            if costs[joint][way] == f64::INFINITY { f64::INFINITY } else { mass[joint][way] }
        };
        let costs = (0..n).map(|j| (0..costs[j].len()).map(|way| of(j, way)).collect()).collect();
        return Table { per_mass: 0.0, costs, offset: 0.0, is_excess: false };
    }
    let offset = -worth_of_power;
    // What the mass of a way is worth to those that carry it.
    let worth = |context: &Context, j: usize, way: usize| {
        let (low, high) = context.ways[j][way].mass;
        (prices[j] * (low - center[j])).min(prices[j] * (high - center[j]))
    };
    for j in 0..n {
        for way in &ways[j] {
            costs[j][*way] += worth(context, j, *way);
        }
    }
    // Where a way may still be one of the best it is worth more: limits that bind at this load have prices then.
    for j in (0..n).filter(|_| threshold.is_finite()) {
        let Some((place, slopes)) = &places[j] else { continue };
        let least = |k: usize| ways[k].iter().map(|way| costs[k][*way]).fold(f64::INFINITY, f64::min);
        let others: f64 = offset + (0..n).filter(|k| *k != j).map(least).sum::<f64>();
        let open: Vec<usize> = ways[j].iter().copied().filter(|way| others + costs[j][*way] < threshold).collect();
        let items = context.exact(j, &open, &place.coordinates);
        let scale = context.total.scale[j];
        let own: Vec<f64> = open.iter().map(|way| worth(context, j, *way)).collect();
        // Of the lightest of them by its own mass.
        let most = own.iter().copied().fold(f64::INFINITY, f64::min);
        let enough = (threshold - others - most) / scale;
        let over = Over { masses: &place.masses, prices: slopes, enough, divisions: DIVISIONS.1 };
        let bounds = place.bounds(context, j, &open, over, &items);
        for ((way, bound), own) in open.iter().zip(bounds).zip(own) {
            costs[j][*way] = costs[j][*way].max(scale * bound + own);
        }
    }
    Table { per_mass: 0.0, costs, offset, is_excess: false }
}

/// How much heavier an actuator is made to see what that costs \[kg\].
const HEAVIER: f64 = 1e-4;

/// Change of the total per kilogram more of one actuator of each joint, with the same motors at their best ratios; empty where no
/// joint carries another, and where some joint has no design with a little more.
pub(super) fn per_mass<'a>(context: &mut Context<'a>, found: &Found<'a>) -> Vec<f64> {
    if context.is_certain() {
        return Vec::new();
    }
    let mut prices = vec![0.0; found.items.len()];
    for (j, item) in found.items.iter().enumerate() {
        for carried in &context.robot.joints[j].carries {
            let heavier = |k: usize| found.items[k].mass + if k == carried.joint { HEAVIER } else { 0.0 };
            let coordinates = carry::coordinates(&context.robot.joints[j], heavier);
            let Some(changed) = context.again(j, item, &coordinates) else { return Vec::new() };
            let more = changed.design.optimum.objective - item.design.optimum.objective;
            prices[carried.joint] += context.total.scale[j] * more / HEAVIER;
        }
    }
    prices
}

impl Place {
    fn new(context: &mut Context, j: usize, center: &[f64], reach: &[(f64, f64)], power: Vec<(usize, f64)>) -> Place {
        let joint = &context.robot.joints[j];
        let coordinates = carry::coordinates(joint, |k| center[k]);
        let directions = carry::directions_of(joint);
        let masses =
            joint.carries.iter().map(|c| (reach[c.joint].0 - center[c.joint], reach[c.joint].1 - center[c.joint]));
        let masses = masses.collect();
        let carrying = context.carrying(j, &coordinates);
        Place { joint: carrying.joint.clone(), directions, masses, coordinates, power }
    }

    /// Lower bounds of some ways to build the joint, with prices on the limits that bind where they are best at this load.
    fn bounds(
        &self,
        context: &mut Context,
        j: usize,
        ways: &[usize],
        over: Over,
        items: &[Option<Arc<Item>>],
    ) -> Vec<f64> {
        let carrying = context.carrying(j, &self.coordinates);
        let (robot, catalog, needs) = (context.robot, context.catalog, context.needs[j]);
        let site = Site::new(robot, &self.joint, &carrying.demand);
        let pieces = pieces(&self.joint, needs);
        // Energy may be less than nothing, and power; all else is not.
        let trivial = match self.joint.objective.weight(Quantity::Energy) > 0.0 || !self.power.is_empty() {
            true => f64::NEG_INFINITY,
            false => 0.0,
        };
        // No less than that, and what the masses are worth at most.
        let worth = over.masses.iter().zip(over.prices).map(|((low, high), price)| (price * low).max(price * high));
        let floor = trivial - worth.sum::<f64>();
        let all = &context.ways[j];
        let of = |(k, way): (usize, &usize)| {
            let build = all[*way].build;
            let row = &catalog.motors[build.motor];
            let gear = build.gear.map(|gear| gear.id.as_str());
            let Ok(mount) = site.mount(row, gear) else { return f64::INFINITY };
            if gear.is_none() && site.is_geared_with(row) {
                return floor;
            }
            let Some(tangent) = self.tangent(mount, &pieces[build.piece.min(pieces.len() - 1)]) else { return floor };
            let item = items.get(k).and_then(Option::as_ref);
            let tangent = match item {
                Some(item) => with_binding(tangent, item).0,
                None => tangent,
            };
            tangent.least(over).max(floor)
        };
        context.work.count(ways.len() * BOUND);
        ways.par_iter().enumerate().map(of).collect()
    }

    fn tangent<'t>(&'t self, mount: Mount<'t, 't>, piece: &Joint) -> Option<Tangent<'t>> {
        let range = match (mount.gear, piece.ratio.range()) {
            (Some(gear), _) => (gear.ratio, gear.ratio),
            (None, range) => range?,
        };
        Some(Tangent::new(mount, &self.directions, &self.joint.objective, range)?.with_power(&self.power))
    }

    /// The best way to build the joint at this load, and what a kilogram more of each carried joint costs it.
    fn reference(&self, context: &mut Context, j: usize, ways: &[usize], bounds: &[f64]) -> (Option<usize>, Vec<f64>) {
        let mut order: Vec<usize> = (0..ways.len()).filter(|k| bounds[*k] < f64::INFINITY).collect();
        order.sort_by(|a, b| bounds[*a].total_cmp(&bounds[*b]).then(a.cmp(b)));
        let mut best: Option<(f64, usize, Arc<Item>)> = None;
        for k in order {
            if best.as_ref().is_some_and(|(value, ..)| bounds[k] >= *value) {
                break;
            }
            let Some(item) = context.exact(j, &[ways[k]], &self.coordinates).pop().flatten() else { continue };
            let value = item.design.optimum.objective;
            if best.as_ref().is_none_or(|(least, ..)| value < *least) {
                best = Some((value, ways[k], item));
            }
        }
        let nothing = vec![0.0; self.masses.len()];
        let Some((_, way, item)) = best else { return (None, nothing) };
        let slopes = self.slopes_of(context, j, &item);
        (Some(way), slopes.unwrap_or(nothing))
    }

    /// What a kilogram more of each carried joint costs a way to build the joint at its best ratio at this load, whatever its limits.
    fn slopes_between(&self, context: &mut Context, j: usize, way: usize) -> Option<Vec<f64>> {
        let carrying = context.carrying(j, &self.coordinates);
        let site = Site::new(context.robot, &self.joint, &carrying.demand);
        let build = context.ways[j][way].build;
        let mount = site.mount(&context.catalog.motors[build.motor], build.gear.map(|gear| gear.id.as_str())).ok()?;
        let pieces = pieces(&self.joint, context.needs[j]);
        let tangent = self.tangent(mount, &pieces[build.piece.min(pieces.len() - 1)])?;
        let ratio = tangent.best_of_all();
        Some(tangent.slopes(ratio))
    }

    /// What a kilogram more of each carried joint costs an item at its best ratio at this load.
    fn slopes_of(&self, context: &mut Context, j: usize, item: &Item) -> Option<Vec<f64>> {
        let carrying = context.carrying(j, &self.coordinates);
        let site = Site::new(context.robot, &self.joint, &carrying.demand);
        let mount = site.mount(&context.catalog.motors[item.motor], item.design.gear).ok()?;
        let (tangent, ratio) = with_binding(self.tangent(mount, &self.joint)?, item);
        Some(tangent.slopes(ratio))
    }
}

/// A tangent with a price on the limit that ends the ratios of an item where it is best, where one does; and where it is best.
fn with_binding<'t>(tangent: Tangent<'t>, item: &Item) -> (Tangent<'t>, f64) {
    let (optimum, own) = (&item.design.optimum, item.design.evaluation.ratio);
    let Some(window) = optimum.windows.first().map(|_| optimum.window()) else { return (tangent, own) };
    let ratio = tangent.best_between((window.min, window.max), own);
    let is = |end: f64| (ratio / end - 1.0).abs() < CLOSE.sqrt();
    let tangent = match () {
        () if is(window.max) => tangent.with_price(ratio, window.high.limit),
        () if is(window.min) => tangent.with_price(ratio, window.low.limit),
        () => tangent,
    };
    (tangent, ratio)
}
