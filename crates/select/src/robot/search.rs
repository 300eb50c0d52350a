//! The best combinations of one design per joint, by branch and bound.
//!
//! Whatever couples the joints (mass, power, what they carry) gets a price; with prices fixed the joints fall apart and the
//! sum of their cheapest entries, less what the budgets are worth, is below every combination that keeps them. Several
//! sets of prices are kept as tables, and a branch is cut where any of them shows that it is not among the best
//! that are wanted. Complete combinations are solved exactly. A limit on the number of motors is branched on
//! directly, with a bound from what each further motor could gain at most.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use super::menu::Item;
use super::shared::Price;

/// Nodes after which the search gives up; what is left is reported as a gap.
const MAX_NODES: usize = 2_000_000;

/// Excesses over a budget that are kept, the last ones.
const EXCESSES: usize = 12;
/// Share of a budget beyond which it is certainly exceeded.
const SURELY: f64 = 1e-7;

/// Costs that are looked up in a step of [`Work`](super::work::Work).
const LOOKS: usize = 32;

/// Combinations that are solved at most where each takes a program of its own.
pub(super) const MAX_SOLVED: usize = 1500;
/// The same where actuators load one another: bounds know nothing of what they share.
pub(super) const MAX_SOLVED_LOADED: usize = 6000;

/// A set of prices, as costs of entries.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// Price of a kilogram \[objective/kg\].
    pub per_mass: f64,
    /// Lower bound of the share in the total at the prices of what is shared but mass, for each entry of each joint.
    pub costs: Vec<Vec<f64>>,
    /// What is shared is worth so much at its prices.
    pub offset: f64,
    /// True if the costs are what joints draw beyond a budget \[W\], not shares in the total: combinations above zero do not keep it.
    pub is_excess: bool,
}

impl Table {
    /// Values above this exceed the budget of an excess by more than rounding.
    fn surely(&self) -> f64 {
        SURELY * self.offset.abs()
    }
}

/// One way to build a joint, before it is known how good it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    /// Index of the motor in the catalogue.
    pub motor: usize,
    /// Mass of all actuators of the joint \[kg\], at least.
    pub mass: f64,
}

/// What one search keeps to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules {
    pub mass: Option<f64>,
    pub motors: Option<usize>,
    /// How many combinations, different in a motor, are wanted.
    pub keep: usize,
    /// Mass is what is minimised.
    pub lightest: bool,
}

/// A complete combination.
#[derive(Debug, Clone)]
pub(super) struct Found<'a> {
    /// What each joint is built of, under the load that it has there.
    pub items: Vec<Arc<Item<'a>>>,
    /// Which way to build each joint that is.
    pub ways: Vec<usize>,
    /// The coordinates of each joint's load.
    pub coordinates: Vec<Vec<f64>>,
    pub motors: Vec<usize>,
    pub mass: f64,
    pub ratios: Option<Vec<f64>>,
    /// What power costs there, where it is limited.
    pub price: Price,
    pub value: f64,
    pub lower: f64,
}

/// What came of a complete combination.
pub(super) enum Completed<'a> {
    /// Its value is infinite where it is not known.
    Found(Found<'a>),
    /// It is not below this, which is as much as was asked.
    NoBetter(f64),
    Cannot,
}

impl<'a> Completed<'a> {
    pub(super) fn found(self) -> Option<Found<'a>> {
        match self {
            Completed::Found(found) => Some(found),
            Completed::NoBetter(_) | Completed::Cannot => None,
        }
    }
}

/// What a search says.
#[derive(Debug, Clone)]
pub(super) struct Answer<'a> {
    /// Best first.
    pub found: Vec<Found<'a>>,
    /// No combination is better than this; infinite where there is none at all.
    pub lower: f64,
    /// Whether the search came to its end.
    pub finished: bool,
    pub nodes: usize,
    /// Complete combinations that were solved.
    pub solved: usize,
    /// Bounds of ways to build a joint over loads that were made.
    pub bounded: usize,
    /// Of each joint the entries of combinations that may be better; empty where the search came to its end.
    pub left: Vec<BTreeSet<usize>>,
    /// Regions that were settled, and that were left.
    pub regions: (usize, usize),
}

impl<'a> Answer<'a> {
    /// Of a search that found out nothing yet.
    pub(super) fn nothing() -> Answer<'a> {
        Answer {
            found: Vec::new(),
            lower: f64::INFINITY,
            finished: true,
            nodes: 0,
            solved: 0,
            bounded: 0,
            left: Vec::new(),
            regions: (0, 0),
        }
    }

    /// Notes what was left of a search.
    pub(super) fn leave(&mut self, ways: &[Vec<usize>]) {
        self.left.resize(ways.len(), BTreeSet::new());
        for (left, ways) in self.left.iter_mut().zip(ways) {
            left.extend(ways);
        }
    }

    /// The value that a combination must be below to be among those that are wanted.
    pub(super) fn threshold(&self, keep: usize) -> f64 {
        self.found.get(keep - 1).map_or(f64::INFINITY, |f| f.value)
    }

    /// Takes a combination in, if it is among the best; of the same motors the better one stays.
    pub(super) fn take(&mut self, found: Found<'a>, keep: usize) {
        let list = &mut self.found;
        match list.iter().position(|f| f.motors == found.motors) {
            Some(same) if list[same].value <= found.value => return,
            Some(same) => {
                list.remove(same);
            }
            None => {}
        }
        let place = list.partition_point(|f| f.value <= found.value);
        list.insert(place, found);
        list.truncate(keep);
    }
}

/// What the search asks of the robot.
pub(super) trait Combinations<'a> {
    /// Whether the search is to stop.
    fn is_stopped(&self) -> bool;
    /// Whether somebody says when it is enough: then no number of branches ends the search.
    fn is_timed(&self) -> bool;
    /// Told at each branch: how many were looked at, and how many complete combinations solved.
    fn searched(&self, branches: usize, solved: usize);
    /// Counts steps of [`Work`](super::work::Work).
    fn count(&self, steps: usize);
    /// An excess that the last complete combination showed, if it did.
    fn excess(&mut self) -> Option<Table>;
    /// A complete combination, by the places of its entries, where it may be better than a value.
    fn complete(&mut self, entries: &[usize], threshold: f64) -> Completed<'a>;
}

/// What is summed up of a joint under a table.
struct Column {
    /// Cost of each entry.
    cost: Vec<f64>,
    least: f64,
    /// Least cost by motor.
    by_motor: HashMap<usize, f64>,
}

struct Search<'s, 'a, C: Combinations<'a>> {
    robot: &'s mut C,
    entries: &'s [Vec<Entry>],
    tables: Vec<Table>,
    rules: Rules,
    /// For each table and joint.
    columns: Vec<Vec<Column>>,
    /// Least mass of the joints from one on.
    lightest: Vec<f64>,
    all_motors: Vec<usize>,
    answer: Answer<'a>,
    /// Combinations that it may solve.
    most_solved: usize,
    /// Whether the search gave up.
    ended: bool,
}

struct State {
    places: Vec<usize>,
    mass: f64,
    used: BTreeSet<usize>,
}

/// Finds the best combinations of the entries of each joint, beside those that were found already; after so many that it solved it gives
/// up.
pub(super) fn run<'a, C: Combinations<'a>>(
    robot: &mut C,
    entries: &[Vec<Entry>],
    tables: &[Table],
    rules: Rules,
    most_solved: usize,
    found: Vec<Found<'a>>,
) -> Answer<'a> {
    let answer = Answer { found, ..Answer::nothing() };
    let mut lightest = vec![0.0; entries.len() + 1];
    for (j, of_joint) in entries.iter().enumerate().rev() {
        lightest[j] = lightest[j + 1] + of_joint.iter().map(|e| e.mass).fold(f64::INFINITY, f64::min);
    }
    let motors: BTreeSet<usize> = entries.iter().flatten().map(|e| e.motor).collect();
    let mut search = Search {
        columns: tables.iter().map(|table| columns(table, entries, rules)).collect(),
        lightest,
        all_motors: motors.into_iter().collect(),
        robot,
        entries,
        tables: tables.to_vec(),
        rules,
        answer,
        most_solved,
        ended: false,
    };
    let mut state = State { places: vec![0; entries.len()], mass: 0.0, used: BTreeSet::new() };
    search.descend(0, &mut state);
    let mut answer = search.answer;
    if let Some(best) = answer.found.first() {
        answer.lower = answer.lower.min(best.lower);
    }
    answer
}

/// A complete combination by what is minimised; `None` where it is beyond a budget.
pub(super) fn counted<'a>(found: Found<'a>, rules: Rules) -> Option<Found<'a>> {
    if rules.mass.is_some_and(|limit| found.mass > limit * (1.0 + 1e-12)) {
        return None;
    }
    let motors: BTreeSet<usize> = found.motors.iter().copied().collect();
    if rules.motors.is_some_and(|most| motors.len() > most) {
        return None;
    }
    Some(match rules.lightest {
        true => {
            let value = if found.value.is_finite() { found.mass } else { f64::INFINITY };
            Found { value, lower: found.mass, ..found }
        }
        false => found,
    })
}

/// What the budgets are worth at a table's prices, taken off the sum.
pub(super) fn constant(table: &Table, rules: Rules) -> f64 {
    match (rules.lightest || table.is_excess, rules.mass) {
        (false, Some(limit)) => table.offset - table.per_mass * limit,
        _ => table.offset,
    }
}

/// What an entry costs under a table.
pub(super) fn cost(table: &Table, rules: Rules, joint: usize, place: usize, entry: &Entry) -> f64 {
    // Without a budget of mass its price is nothing.
    let of_mass =
        if rules.mass.is_some() && !rules.lightest && !table.is_excess { table.per_mass * entry.mass } else { 0.0 };
    of_mass + table.costs[joint][place]
}

fn columns(table: &Table, entries: &[Vec<Entry>], rules: Rules) -> Vec<Column> {
    let column = |(joint, entries): (usize, &Vec<Entry>)| {
        let costs: Vec<f64> =
            entries.iter().enumerate().map(|(place, entry)| cost(table, rules, joint, place, entry)).collect();
        let mut by_motor: HashMap<usize, f64> = HashMap::new();
        for (entry, cost) in entries.iter().zip(&costs) {
            let least = by_motor.entry(entry.motor).or_insert(f64::INFINITY);
            *least = least.min(*cost);
        }
        Column { least: costs.iter().copied().fold(f64::INFINITY, f64::min), cost: costs, by_motor }
    };
    entries.iter().enumerate().map(column).collect()
}

impl<'a, C: Combinations<'a>> Search<'_, 'a, C> {
    /// What the joints from a depth on cost at least under a table.
    fn rest(&self, t: usize, depth: usize, state: &State) -> f64 {
        let slots = self.rules.motors.map(|k| k.saturating_sub(state.used.len()));
        let rest = &self.columns[t][depth..];
        let of_used = |column: &Column| {
            state.used.iter().filter_map(|m| column.by_motor.get(m)).copied().fold(f64::INFINITY, f64::min)
        };
        match slots {
            None => return rest.iter().map(|column| column.least).sum(),
            Some(0) => return rest.iter().map(of_used).sum(),
            Some(_) => {}
        }
        let least: f64 = rest.iter().map(|column| column.least).sum();
        let kept: Vec<f64> = rest.iter().map(of_used).collect();
        let all_kept: f64 = kept.iter().sum();
        let Some(slots) = slots.filter(|_| all_kept.is_finite()) else { return least };
        // Each further motor gains at most this over staying with those there are; no more than `slots` may come.
        let gain = |motor: &usize| {
            let of = |(column, of_used): (&Column, &f64)| {
                column.by_motor.get(motor).map_or(0.0, |cost| (of_used - cost).max(0.0))
            };
            rest.iter().zip(&kept).map(of).sum::<f64>()
        };
        let mut gains: Vec<f64> = self.all_motors.iter().filter(|m| !state.used.contains(m)).map(gain).collect();
        gains.sort_by(|a, b| b.total_cmp(a));
        least.max(all_kept - gains.iter().take(slots).sum::<f64>())
    }

    fn descend(&mut self, depth: usize, state: &mut State) {
        if depth == self.entries.len() {
            self.finish(state);
            return;
        }
        // The last table of costs is the guide: its cheapest entries come first.
        let guide = self.tables.iter().rposition(|table| !table.is_excess).unwrap_or(0);
        let costs = &self.columns[guide][depth].cost;
        let mut places: Vec<usize> = (0..self.entries[depth].len()).collect();
        places.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]).then(a.cmp(b)));
        for place in places {
            let chosen = self.entries[depth][place];
            let mass = state.mass + chosen.mass;
            if self.rules.mass.is_some_and(|limit| mass + self.lightest[depth + 1] > limit * (1.0 + 1e-12)) {
                continue;
            }
            let new = !state.used.contains(&chosen.motor);
            if new && self.rules.motors.is_some_and(|k| state.used.len() >= k) {
                continue;
            }
            let too_many = self.answer.nodes >= MAX_NODES && !self.robot.is_timed();
            if self.ended || too_many || self.robot.is_stopped() {
                self.give_up(depth, state);
                return;
            }
            self.answer.nodes += 1;
            self.robot.searched(self.answer.nodes, self.answer.solved);
            let before = state.mass;
            state.mass = mass;
            if new {
                state.used.insert(chosen.motor);
            }
            state.places[depth] = place;
            let looks = if self.rules.motors.is_some() { self.all_motors.len() } else { 1 };
            self.robot.count(1 + self.tables.len() * (self.entries.len() - depth) * looks / LOOKS);
            let bound = self.bound(depth + 1, state);
            if bound < self.answer.threshold(self.rules.keep) {
                self.descend(depth + 1, state);
            } else {
                self.answer.lower = self.answer.lower.min(bound);
            }
            state.mass = before;
            if new {
                state.used.remove(&chosen.motor);
            }
        }
    }

    /// A bound of all combinations that begin with the first entries of a state; infinite where none of them keeps a budget.
    fn bound(&self, depth: usize, state: &State) -> f64 {
        let mut bound = f64::NEG_INFINITY;
        for (t, table) in self.tables.iter().enumerate() {
            let chosen =
                self.columns[t].iter().zip(&state.places).take(depth).map(|(column, place)| column.cost[*place]);
            let here = constant(table, self.rules) + chosen.sum::<f64>() + self.rest(t, depth, state);
            match table.is_excess {
                true if here > table.surely() => return f64::INFINITY,
                true => {}
                false => bound = bound.max(here),
            }
        }
        bound
    }

    /// Takes an excess that a combination showed into account.
    fn learn(&mut self) {
        let Some(table) = self.robot.excess() else { return };
        let excesses: Vec<usize> = (0..self.tables.len()).filter(|t| self.tables[*t].is_excess).collect();
        if excesses.len() >= EXCESSES {
            self.tables.remove(excesses[0]);
            self.columns.remove(excesses[0]);
        }
        self.columns.push(columns(&table, self.entries, self.rules));
        self.tables.push(table);
    }

    /// Nothing further is looked at: what is left counts with its bounds.
    fn give_up(&mut self, depth: usize, state: &State) {
        self.answer.lower = self.answer.lower.min(self.bound(depth, state));
        self.answer.finished = false;
        self.ended = true;
    }

    fn finish(&mut self, state: &State) {
        self.answer.solved += 1;
        if self.answer.solved > self.most_solved {
            self.give_up(self.entries.len(), state);
            return;
        }
        // Where mass is minimised a total says nothing.
        let threshold = if self.rules.lightest { f64::INFINITY } else { self.answer.threshold(self.rules.keep) };
        let found = match self.robot.complete(&state.places, threshold) {
            Completed::Found(found) => counted(found, self.rules),
            Completed::NoBetter(lower) => {
                self.answer.lower = self.answer.lower.min(lower);
                return;
            }
            Completed::Cannot => {
                self.learn();
                return;
            }
        };
        let Some(found) = found else { return };
        self.answer.lower = self.answer.lower.min(found.lower);
        match found.value.is_finite() {
            true => self.answer.take(found, self.rules.keep),
            false if found.lower >= threshold => {}
            false => self.answer.finished = false,
        }
    }
}
