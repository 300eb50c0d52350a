//! A whole robot: the best combination of actuators under what its joints share, proved.
//!
//! The one idea: what a joint may be built of is found first, each item with its best ratio and proof
//! (`menu`); the best combination under mass, number of motors and power at each instant is then found by
//! branch and bound with prices on what is shared (`search`), complete combinations being solved exactly
//! (`shared`: a convex program over all ratios at once). What is carried is chosen before what carries it
//! (`carry`). Nothing is called the best that was not proved: a search that gave up, or a motor that could not
//! be certified, is said with what is left of the gap.

mod answer;
mod carry;
mod context;
mod convex;
mod dual;
mod menu;
mod power;
mod regions;
mod search;
mod shared;
mod tangent;
mod total;
mod work;

use std::collections::BTreeSet;

use crate::Prepared;
use crate::options::Stop;
use crate::program::GAP_TOLERANCE;
pub use answer::{Apart, Bill, Change, Choice, Combination, NoChoice, Options, Proof, Sag, Wanting};
use context::{Among, Context};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::Catalog;
use gearwise_model::requirement::{Joint, Robot};
pub use power::Draws;
use search::{Answer, Found, Rules};
pub use total::Total;

/// Finds the best combination for a robot.
///
/// # Errors
/// Where the joints' objectives cannot be summed up.
pub fn choose<'a>(robot: &'a Robot, catalog: &'a Catalog, options: Options<'a>) -> Result<Choice<'a>, NoChoice> {
    let stop = Stop::when(options.stop);
    let mut context = Context::new(robot, catalog, options).map_err(NoChoice::Cannot)?;
    stop.unless(())?;
    let budget = &robot.budget;
    let rules = Rules {
        mass: budget.actuator_mass,
        motors: budget.max_distinct_motors.map(|k| k as usize),
        keep: 1 + options.runner_ups,
        lightest: false,
    };
    let empty: Vec<String> = robot
        .joints
        .iter()
        .zip(&context.certain)
        .filter(|(_, menu)| menu.as_ref().is_some_and(|m| m.items.is_empty()))
        .map(|(joint, _)| joint.name.clone())
        .collect();
    context.work.allow(options.steps);
    let answer = if empty.is_empty() { solve(&mut context, rules) } else { Answer::nothing() };
    context.work.allow(options.steps / 3);
    let mut combinations: Vec<Combination> = answer.found.iter().map(|f| context.combination(f)).collect();
    if let (Some(first), Some(found)) = (combinations.first_mut(), answer.found.first())
        && !context.shares_power()
    {
        first.per_mass = regions::per_mass(&mut context, found);
    }
    let wanting = match (empty.is_empty(), combinations.is_empty()) {
        (false, _) => vec![Wanting::Joints(empty)],
        (true, true) => wanting(&mut context, rules),
        (true, false) => Vec::new(),
    };
    let (mut changes, mut front, mut others_left_out) = (Vec::new(), Vec::new(), false);
    if let Some(best) = combinations.first().filter(|_| options.budgets) {
        let mut effort = Effort::after(&context, &answer);
        changes = other_budgets(&mut context, rules, best.distinct_motors, &mut effort);
        if effort.is_left(&context) {
            front = mass_front(&mut context, rules);
        } else {
            effort.left_out |= rules.mass.is_some();
        }
        others_left_out = effort.left_out;
    }
    let proof = prove(&context, &answer);
    let unjudged = unjudged(&mut context, answer.found.first());
    let name = |j: &usize| robot.joints[*j].name.clone();
    let scenarios = &context.schedule.scenarios;
    // One joint that is alone in its place needs no time.
    let timed = |g: &power::Group| g.timed || robot.joints.iter().all(|j| j.count == 1);
    let one_by_one = |s: &power::Scenario| s.groups.len() == 1 && timed(&s.groups[0]);
    let most_groups = scenarios.iter().map(|s| &s.groups).max_by_key(|groups| groups.len());
    let mut bases: Vec<Vec<String>> =
        most_groups.into_iter().flatten().map(|g| g.joints.iter().map(name).collect()).collect();
    bases.dedup();
    Ok(stop.unless(Choice {
        robot,
        combinations,
        proof,
        wanting,
        changes,
        others_left_out,
        front,
        unjudged,
        time_bases: bases,
        instant_by_instant: scenarios.iter().all(one_by_one),
        total: context.total,
    })?)
}

/// Every motor that is no choice at a joint because it cannot be judged there.
fn unjudged<'a>(context: &mut Context<'a>, found: Option<&Found<'a>>) -> Vec<Apart<'a>> {
    let all = context.unjudged(found);
    let apart = |((joint, motor), mut because): ((usize, usize), Vec<Remark>)| {
        because.sort_unstable();
        because.dedup();
        Apart { joint: &context.robot.joints[joint], motor: &context.catalog.motors[motor], because }
    };
    all.into_iter().map(apart).collect()
}

fn solve<'a>(context: &mut Context<'a>, rules: Rules) -> Answer<'a> {
    let Some(most) = context.returned.filter(|_| !rules.lightest) else { return search_all(context, rules) };
    // Without the limit on what comes back the search is short; what keeps it all the same is the best with it.
    context.returned = None;
    let left = context.work.left();
    context.work.allow(left / 2);
    let free = search_all(context, rules);
    context.work.allow(left / 2 + context.work.left());
    let keeps = |found: &&Found<'a>| context.combination(found).most_returned <= most;
    let kept: Vec<Found> = free.found.iter().filter(keeps).cloned().collect();
    // Behind one that does not keep it others may come next.
    let first: Vec<Found> = free.found.iter().take_while(keeps).cloned().collect();
    context.returned = Some(most);
    if free.finished && (!first.is_empty() || free.found.is_empty()) {
        return Answer { found: first, ..free };
    }
    let mut answer = search_all(context, rules);
    kept.into_iter().for_each(|found| answer.take(found, rules.keep));
    answer.lower = answer.lower.max(free.lower);
    (answer.bounded, answer.solved) = (answer.bounded + free.bounded, answer.solved + free.solved);
    answer
}

fn search_all<'a>(context: &mut Context<'a>, rules: Rules) -> Answer<'a> {
    if !context.is_certain() {
        return regions::solve(context, rules);
    }
    let ways: Vec<Vec<usize>> = context.ways.iter().map(|ways| (0..ways.len()).collect()).collect();
    let (entries, tables) = (context.entries(&ways), context.tables(rules));
    // Where a combination takes a program of its own there may not be too many.
    let most = if context.shares_power() { context.at_most(search::MAX_SOLVED) } else { usize::MAX };
    let mut answer = search::run(&mut Among { context, ways: &ways }, &entries, &tables, rules, most, Vec::new());
    if !answer.finished {
        answer.leave(&regions::may_be_better(context, tables, rules, answer.threshold(1)));
    }
    answer
}

fn prove(context: &Context, answer: &Answer) -> Proof {
    let mut not_proved = Vec::new();
    let best = answer.found.first().map(|f| f.value);
    let gap = best.filter(|_| answer.lower.is_finite()).map(|best| {
        let size = best.abs().max(f64::MIN_POSITIVE);
        ((best - answer.lower) / size).max(0.0)
    });
    if !answer.finished {
        not_proved.push("the search was ended before all combinations were looked at or ruled out".into());
    } else if gap.is_some_and(|g| g > GAP_TOLERANCE) {
        not_proved.push("the bounds did not meet".into());
    }
    let of_menus = context.certain.iter().flatten().flat_map(|menu| menu.unproved.iter());
    let mut unproved: Vec<usize> = of_menus.chain(&context.unproved).copied().collect();
    unproved.sort_unstable();
    unproved.dedup();
    if !unproved.is_empty() {
        let ids: Vec<&str> = unproved.iter().take(5).map(|m| context.catalog.motors[*m].id.as_str()).collect();
        let more = if unproved.len() > ids.len() {
            format!(" and {} more", unproved.len() - ids.len())
        } else {
            String::new()
        };
        not_proved.push(format!("the best ratios of {}{more} are not certified", ids.join(", ")));
    }
    // A ratio that may be better has no part in the bound: then there is none.
    let bounds = unproved.is_empty();
    let (lower_bound, gap) = (Some(answer.lower).filter(|l| bounds && l.is_finite()), gap.filter(|_| bounds));
    let open = open(context, answer);
    Proof { lower_bound, gap, not_proved, branches: answer.nodes, open, regions: answer.regions }
}

/// Of each joint the motors of combinations that may be better, but the one that it has in the best.
fn open(context: &Context, answer: &Answer) -> Vec<Vec<String>> {
    let of = |(joint, ways): (usize, &BTreeSet<usize>)| {
        let own = answer.found.first().map(|found| found.motors[joint]);
        let motors: BTreeSet<usize> = ways.iter().map(|way| context.ways[joint][*way].build.motor).collect();
        let others = motors.into_iter().filter(|motor| Some(*motor) != own);
        others.map(|motor| context.catalog.motors[motor].id.clone()).collect()
    };
    answer.left.iter().enumerate().map(of).collect()
}

/// Bounds of ways to build a joint that each search for what is wanting may make.
const WANTING_BOUNDED: usize = 20_000;

/// What would have to change, one budget at a time; where that is not settled, that it is not.
fn wanting(context: &mut Context, rules: Rules) -> Vec<Wanting> {
    let mut wanting = Vec::new();
    let one = Rules { keep: 1, ..rules };
    context.most_bounded = Some(WANTING_BOUNDED);
    let mut settled = true;
    if rules.mass.is_some() {
        let lightest = solve(context, Rules { mass: None, lightest: true, ..one });
        settled &= lightest.finished;
        wanting.extend(lightest.found.first().filter(|_| lightest.finished).map(|f| Wanting::Mass(f.mass)));
    }
    if let Some(limit) = rules.motors {
        for k in limit + 1..=context.robot.joints.len() {
            let answer = solve(context, Rules { motors: Some(k), ..one });
            settled &= answer.finished;
            if !answer.found.is_empty() {
                wanting.extend(settled.then_some(Wanting::Motors(k)));
                break;
            }
        }
    }
    if let Some(limit) = context.power.take() {
        let least = context.least_power;
        let answer = solve(context, one);
        settled &= answer.finished;
        if let Some(found) = answer.found.first() {
            let draws = context.combination(found).peak_power;
            wanting.push(Wanting::Power(least.min(draws), draws));
        }
        context.power = Some(limit);
    }
    if let Some(most) = context.returned.take() {
        let answer = solve(context, one);
        settled &= answer.finished;
        wanting.extend(answer.found.first().map(|f| Wanting::Returned(context.combination(f).most_returned)));
        context.returned = Some(most);
    }
    if let Some(supply) = context.supply.take() {
        let answer = solve(context, one);
        settled &= answer.finished;
        wanting.extend((!answer.found.is_empty()).then_some(Wanting::Supply));
        context.supply = Some(supply);
    }
    context.most_bounded = None;
    if wanting.is_empty() && !settled {
        wanting.push(Wanting::NotSettled);
    }
    wanting
}

/// Programs of combinations after which other budgets are not looked at.
const LONG: usize = 100;
/// The same of bounds of ways to build a joint over loads.
const MANY_BOUNDED: usize = 1000;
/// How many times the bounds of the first search the others may take.
const OTHERS: usize = 2;
/// Steps of a budget, as shares of it: the nearest are looked at first.
const STEPS: [f64; 4] = [-0.05, 0.05, -0.1, 0.1];

/// What searches under other budgets may take, so that they take no more than a few times that of the first.
struct Effort {
    bounded: usize,
    /// Whether the search itself was short, and came to its end.
    short: bool,
    /// Whether some budget was not looked at.
    left_out: bool,
}

impl Effort {
    fn after(context: &Context, answer: &Answer) -> Effort {
        // Each program takes long where what comes back is limited and loads are not known.
        let slow = context.returned.is_some() && !context.is_certain();
        let short = answer.finished && !slow && (!context.shares_power() || answer.solved <= LONG);
        Effort { bounded: MANY_BOUNDED.max(OTHERS * answer.bounded), short, left_out: false }
    }

    fn is_left(&self, context: &Context) -> bool {
        self.short && self.bounded > 0 && !context.ends()
    }
}

/// Another budget that is looked at.
enum Other {
    Mass,
    Motors,
    Power,
    Returned,
}

fn other_budgets<'a>(context: &mut Context<'a>, rules: Rules, distinct: usize, effort: &mut Effort) -> Vec<Change<'a>> {
    let one = Rules { keep: 1, ..rules };
    let most = context.robot.joints.len();
    let mut others: Vec<(Other, f64)> = Vec::new();
    for step in STEPS {
        others.extend(rules.mass.map(|mass| (Other::Mass, mass * (1.0 + step))));
        others.extend(context.power.map(|power| (Other::Power, power * (1.0 + step))));
        // Of nothing no share is another.
        let returned = context.returned.filter(|most| *most > 0.0);
        others.extend(returned.map(|most| (Other::Returned, most * (1.0 + step))));
        if step == STEPS[0] {
            let counts = match rules.motors {
                Some(motors) => vec![motors.saturating_sub(1), motors + 1],
                // What a motor less to buy and to stock would cost.
                None if context.is_certain() => vec![distinct.saturating_sub(1)],
                None => Vec::new(),
            };
            let counts = counts.into_iter().filter(|k| (1..=most).contains(k));
            others.extend(counts.map(|k| (Other::Motors, k as f64)));
        }
    }
    let mut changes = Vec::new();
    for (other, value) in others {
        if !effort.is_left(context) {
            effort.left_out = true;
            break;
        }
        let (power, returned) = (context.power, context.returned);
        let (budget, unit, rules) = match other {
            Other::Mass => ("actuator_mass", "kg", Rules { mass: Some(value), ..one }),
            Other::Motors => ("max_distinct_motors", "1", Rules { motors: Some(value as usize), ..one }),
            Other::Power => {
                context.power = Some(value);
                ("power", "W", one)
            }
            Other::Returned => {
                context.returned = Some(value);
                ("regeneration", "W", one)
            }
        };
        context.most_bounded = Some(effort.bounded);
        let answer = solve(context, rules);
        context.most_bounded = None;
        let best = answer.found.first().map(|f| context.combination(f));
        let certified = prove(context, &answer).certified();
        (context.power, context.returned) = (power, returned);
        effort.bounded = effort.bounded.saturating_sub(answer.bounded);
        changes.push(Change { budget, unit, value, best, certified });
    }
    changes.sort_by(|a, b| a.budget.cmp(b.budget).then(a.value.total_cmp(&b.value)));
    changes
}

/// Points of the front of mass and total.
const FRONT: usize = 12;

/// The best combinations for less and less mass: from the best without a budget of mass to the lightest.
fn mass_front<'a>(context: &mut Context<'a>, rules: Rules) -> Vec<Combination<'a>> {
    if rules.mass.is_none() {
        return Vec::new();
    }
    let one = Rules { keep: 1, mass: None, ..rules };
    let free = solve(context, one);
    let lightest = solve(context, Rules { lightest: true, ..one });
    let (Some(free), Some(lightest)) = (free.found.first(), lightest.found.first()) else { return Vec::new() };
    let (most, least) = (free.mass, lightest.mass);
    let mut front = vec![context.combination(free)];
    for step in (0..FRONT).rev() {
        let budget = least + (most - least) * step as f64 / FRONT as f64;
        let answer = solve(context, Rules { mass: Some(budget * (1.0 + 1e-12)), ..one });
        let Some(found) = answer.found.first() else { continue };
        let found = context.combination(found);
        if front.last().is_none_or(|last| found.mass < last.mass) {
            front.push(found);
        }
    }
    front
}

/// A joint with what the actuators that it carries add to its load, from the mass of each \[kg\], by joint.
pub fn carrying(joint: &Joint, mass: impl Fn(usize) -> f64) -> Joint {
    carry::loaded(joint, &carry::coordinates(joint, mass))
}

/// Joints in an order in which what is carried comes before what carries it.
pub(crate) fn carried_first(joints: &[Joint]) -> Vec<usize> {
    carry::order(joints)
}

/// What one actuator draws and asks for at each sample of its motion.
pub(crate) fn draws(prepared: &Prepared, ratio: f64) -> Draws {
    power::Profile::of(prepared, ratio).draws(ratio, true)
}

/// What a supply with a resistance makes of all joints together, from the `draws` of each; `None` where it is stiff, or feeds one
/// actuator.
pub fn sag(robot: &Robot, all: &[Draws]) -> Option<Sag> {
    let shared = robot.shared_resistance()?;
    power::sag(&power::Schedule::new(robot), all, (robot.bus.voltage, shared))
}

/// The most that all joints together give back to the bus at any instant \[W\], less what others draw then, from the `draws` of each;
/// where they share no time base, the sum of what each gives back at most.
pub fn most_returned(robot: &Robot, all: &[Draws]) -> f64 {
    power::most_returned(&power::Schedule::new(robot), all).0
}

/// Largest power that all joints together draw at any instant \[W\], from the power of each at the samples of its motion; where they
/// share no time base, the sum of their peaks.
pub fn peak_power(robot: &Robot, courses: &[Vec<f64>]) -> f64 {
    let courses: Vec<&[f64]> = courses.iter().map(Vec::as_slice).collect();
    power::largest(&power::Schedule::new(robot), &courses).0
}
