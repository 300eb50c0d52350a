//! The best combinations of one design per joint, by branch and bound.
//!
//! Whatever couples the joints (mass, power) gets a price; with prices fixed the joints fall apart and the sum
//! of their cheapest items, less what the budgets are worth, is below every combination that keeps them. Several
//! sets of prices are kept as tables, and a branch is cut where any of them shows that it is not among the best
//! that are wanted. Complete combinations are solved exactly. A limit on the number of motors is branched on
//! directly, with a bound from what each further motor could gain at most.

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use super::menu::Menu;

/// Nodes after which the search gives up; what is left is reported as a gap.
const MAX_NODES: usize = 2_000_000;

/// The same where loads are open: bounds over loads take longer.
const MAX_NODES_OPEN: usize = 60_000;

/// Combinations that are solved at most where each takes a program of its own.
const MAX_SOLVED: usize = 1500;

/// A set of prices, as costs of items.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// Price of a kilogram \[objective/kg\].
    pub per_mass: f64,
    /// Lower bound of objective and power at their prices, for each item of each joint; `None` where the
    /// objective alone counts.
    pub priced: Option<Vec<Vec<f64>>>,
    /// What the power budget is worth at its price.
    pub offset: f64,
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
pub(super) struct Found {
    /// Item of each joint, with the menu that it is from.
    pub items: Vec<usize>,
    pub coordinates: Vec<Vec<f64>>,
    pub motors: Vec<usize>,
    pub mass: f64,
    pub ratios: Option<Vec<f64>>,
    pub value: f64,
    pub lower: f64,
}

/// What a search says.
#[derive(Debug, Clone)]
pub(super) struct Answer {
    /// Best first.
    pub found: Vec<Found>,
    /// No combination is better than this; infinite where there is none at all.
    pub lower: f64,
    /// Whether the search came to its end.
    pub finished: bool,
    pub nodes: usize,
    /// Complete combinations that were solved.
    pub solved: usize,
}

/// What the search asks of the robot.
pub(super) trait Joints<'a> {
    /// The order of decision: what is carried first.
    fn order(&self) -> &[usize];
    /// Count of a joint.
    fn count(&self, joint: usize) -> f64;
    /// Share of a joint's objective in the total.
    fn scale(&self, joint: usize) -> f64;
    /// The coordinates of a joint's load for the masses chosen.
    fn coordinates(&self, joint: usize, masses: &[Option<f64>]) -> Vec<f64>;
    /// The menu of a joint at some coordinates; `None` where no more can be made.
    fn menu(&mut self, joint: usize, coordinates: &[f64]) -> Option<Rc<Menu<'a>>>;
    /// The menu of a joint whose load is certain.
    fn certain(&self, joint: usize) -> Option<Rc<Menu<'a>>>;
    /// A lower bound of a joint's objective and of its mass for the masses chosen so far.
    fn bound(&self, joint: usize, masses: &[Option<f64>]) -> (f64, f64);
    /// Whether the search is to stop.
    fn is_stopped(&self) -> bool;
    /// Told at each branch: how many were looked at, and how many complete combinations solved.
    fn searched(&self, branches: usize, solved: usize);
    /// Whether a complete combination takes a program of its own.
    fn is_costly(&self) -> bool;
    /// Best ratios, value and bound of a complete combination; `None` where it cannot be.
    fn complete(&mut self, menus: &[Rc<Menu<'a>>], items: &[usize], coordinates: &[Vec<f64>]) -> Option<Completed>;
}

pub(super) struct Completed {
    pub ratios: Option<Vec<f64>>,
    pub value: f64,
    pub lower: f64,
}

/// What is summed up of a certain joint under a table.
struct Column {
    /// Cost of each item.
    cost: Vec<f64>,
    least: f64,
    /// Least cost by motor.
    by_motor: HashMap<usize, f64>,
}

struct Search<'s, 'a, J: Joints<'a>> {
    joints: &'s mut J,
    tables: Vec<Table>,
    rules: Rules,
    order: Vec<usize>,
    /// For each table and certain joint.
    columns: Vec<Vec<Option<Column>>>,
    all_motors: Vec<usize>,
    answer: Answer,
    menus: Vec<Option<Rc<Menu<'a>>>>,
    /// Whether the search gave up.
    ended: bool,
    most_nodes: usize,
}

struct State<'a> {
    menus: Vec<Option<Rc<Menu<'a>>>>,
    items: Vec<usize>,
    coordinates: Vec<Vec<f64>>,
    masses: Vec<Option<f64>>,
    mass: f64,
    used: BTreeSet<usize>,
    sums: Vec<f64>,
}

/// Finds the best combinations.
pub(super) fn run<'a, J: Joints<'a>>(joints: &mut J, tables: &[Table], rules: Rules) -> Answer {
    let order = joints.order().to_vec();
    let n = order.len();
    let menus: Vec<Option<Rc<Menu>>> = (0..n).map(|j| joints.certain(j)).collect();
    let mut tables = tables.to_vec();
    if rules.lightest {
        tables = vec![Table { per_mass: 1.0, priced: None, offset: 0.0 }];
    }
    let mut search = Search {
        columns: Vec::new(),
        all_motors: Vec::new(),
        tables,
        rules,
        order,
        answer: Answer { found: Vec::new(), lower: f64::INFINITY, finished: true, nodes: 0, solved: 0 },
        most_nodes: if menus.iter().all(Option::is_some) { MAX_NODES } else { MAX_NODES_OPEN },
        menus,
        joints,
        ended: false,
    };
    search.prepare();
    let root = search.tables.iter().map(|t| search.constant(t)).collect();
    let mut state = State {
        menus: vec![None; n],
        items: vec![0; n],
        coordinates: vec![Vec::new(); n],
        masses: vec![None; n],
        mass: 0.0,
        used: BTreeSet::new(),
        sums: root,
    };
    search.descend(0, &mut state);
    let mut answer = search.answer;
    if let Some(best) = answer.found.first() {
        answer.lower = answer.lower.min(best.lower);
    }
    answer
}

impl<'a, J: Joints<'a>> Search<'_, 'a, J> {
    /// What the budgets are worth at a table's prices, taken off the sum.
    fn constant(&self, table: &Table) -> f64 {
        match (self.rules.lightest, self.rules.mass) {
            (false, Some(limit)) => table.offset - table.per_mass * limit,
            _ => table.offset,
        }
    }

    fn cost(&self, table: &Table, joint: usize, menu: &Menu, item: usize) -> f64 {
        let weight = self.joints.count(joint) * menu.items[item].mass;
        if self.rules.lightest {
            return weight;
        }
        // Without a budget of mass its price is nothing.
        let of_mass = if self.rules.mass.is_some() { table.per_mass * weight } else { 0.0 };
        of_mass
            + match &table.priced {
                Some(priced) => priced[joint][item],
                None => self.joints.scale(joint) * menu.items[item].lower,
            }
    }

    fn prepare(&mut self) {
        let column = |table: &Table, joint: usize| {
            let menu = self.menus[joint].as_ref()?;
            let cost: Vec<f64> = (0..menu.items.len()).map(|i| self.cost(table, joint, menu, i)).collect();
            let mut by_motor: HashMap<usize, f64> = HashMap::new();
            for (item, cost) in menu.items.iter().zip(&cost) {
                let least = by_motor.entry(item.motor).or_insert(f64::INFINITY);
                *least = least.min(*cost);
            }
            Some(Column { least: cost.iter().copied().fold(f64::INFINITY, f64::min), cost, by_motor })
        };
        let columns = self.tables.iter().map(|t| (0..self.order.len()).map(|j| column(t, j)).collect()).collect();
        self.columns = columns;
        let motors: BTreeSet<usize> =
            self.menus.iter().flatten().flat_map(|m| m.items.iter().map(|i| i.motor)).collect();
        self.all_motors = motors.into_iter().collect();
    }

    /// The value that a combination must be below.
    fn threshold(&self) -> f64 {
        self.answer.found.get(self.rules.keep - 1).map_or(f64::INFINITY, |f| f.value)
    }

    /// Least objective and mass of the joints from a depth on whose load is open.
    fn open(&self, depth: usize, state: &State<'a>) -> Vec<(f64, f64)> {
        let open = self.order[depth..].iter().filter(|j| self.menus[**j].is_none());
        open.map(|j| self.joints.bound(*j, &state.masses)).collect()
    }

    /// What the joints from a depth on cost at least under a table; `open` as [`Search::open`] gives it.
    fn rest(&self, t: usize, depth: usize, state: &State<'a>, open: &[(f64, f64)]) -> f64 {
        let mut open = open.iter();
        let slots = self.rules.motors.map(|k| k.saturating_sub(state.used.len()));
        let (mut least, mut kept) = (0.0, 0.0);
        let mut certain = Vec::new();
        for joint in &self.order[depth..] {
            let Some(column) = &self.columns[t][*joint] else {
                let (objective, mass) = open.next().copied().unwrap_or((0.0, 0.0));
                let weight = self.joints.count(*joint) * mass;
                let cost = match (self.rules.lightest, self.rules.mass) {
                    (true, _) => weight,
                    (false, Some(_)) => self.joints.scale(*joint) * objective + self.tables[t].per_mass * weight,
                    (false, None) => self.joints.scale(*joint) * objective,
                };
                least += cost;
                kept += cost;
                continue;
            };
            let of_used =
                state.used.iter().filter_map(|m| column.by_motor.get(m)).copied().fold(f64::INFINITY, f64::min);
            certain.push((column, of_used));
            least += if slots == Some(0) { of_used } else { column.least };
            kept += of_used;
        }
        let Some(slots) = slots.filter(|s| *s > 0 && kept.is_finite()) else { return least };
        // Each further motor gains at most this over staying with those there are; no more than `slots` may come.
        let gain = |motor: &usize| {
            let of = |(column, of_used): &(&Column, f64)| {
                column.by_motor.get(motor).map_or(0.0, |cost| (of_used - cost).max(0.0))
            };
            certain.iter().map(of).sum::<f64>()
        };
        let mut gains: Vec<f64> = self.all_motors.iter().filter(|m| !state.used.contains(m)).map(gain).collect();
        gains.sort_by(|a, b| b.total_cmp(a));
        least.max(kept - gains.iter().take(slots).sum::<f64>())
    }

    /// The lightest that the joints from a depth on can be \[kg\].
    fn lightest(&self, depth: usize, state: &State<'a>) -> f64 {
        let of = |joint: &usize| {
            let count = self.joints.count(*joint);
            match &self.menus[*joint] {
                Some(menu) => count * menu.items.iter().map(|i| i.mass).fold(f64::INFINITY, f64::min),
                None => count * self.joints.bound(*joint, &state.masses).1,
            }
        };
        self.order[depth..].iter().map(of).sum()
    }

    fn descend(&mut self, depth: usize, state: &mut State<'a>) {
        if depth == self.order.len() {
            self.finish(state);
            return;
        }
        let joint = self.order[depth];
        state.coordinates[joint] = self.joints.coordinates(joint, &state.masses);
        let menu = match &self.menus[joint] {
            Some(menu) => menu.clone(),
            None => match self.joints.menu(joint, &state.coordinates[joint]) {
                Some(menu) => menu,
                None => {
                    self.give_up(depth, state);
                    return;
                }
            },
        };
        let costs: Vec<Vec<f64>> = (0..self.tables.len())
            .map(|t| match &self.columns[t][joint] {
                Some(column) => column.cost.clone(),
                None => (0..menu.items.len()).map(|i| self.cost(&self.tables[t], joint, &menu, i)).collect(),
            })
            .collect();
        // The last table is the guide: its cheapest items come first.
        let guide = self.tables.len() - 1;
        let mut items: Vec<usize> = (0..menu.items.len()).collect();
        items.sort_by(|a, b| costs[guide][*a].total_cmp(&costs[guide][*b]).then(a.cmp(b)));
        // What is carried costs more than its own joint: where a load is open, the cheapest for all come first.
        if !self.rules.lightest && self.order[depth + 1..].iter().any(|j| self.menus[*j].is_none()) {
            let mut whole: Vec<f64> = Vec::with_capacity(menu.items.len());
            for item in &menu.items {
                state.masses[joint] = Some(item.mass);
                whole.push(self.rest(guide, depth + 1, state, &self.open(depth + 1, state)));
            }
            state.masses[joint] = None;
            let cost = |i: usize| costs[guide][i] + whole[i];
            items.sort_by(|a, b| cost(*a).total_cmp(&cost(*b)).then(a.cmp(b)));
        }
        let lightest = if self.rules.mass.is_some() { self.lightest(depth + 1, state) } else { 0.0 };
        for item in items {
            let chosen = &menu.items[item];
            let mass = state.mass + self.joints.count(joint) * chosen.mass;
            if self.rules.mass.is_some_and(|limit| mass + lightest > limit * (1.0 + 1e-12)) {
                continue;
            }
            let new = !state.used.contains(&chosen.motor);
            if new && self.rules.motors.is_some_and(|k| state.used.len() >= k) {
                continue;
            }
            if self.ended || self.answer.nodes >= self.most_nodes || self.joints.is_stopped() {
                self.give_up(depth, state);
                return;
            }
            self.answer.nodes += 1;
            self.joints.searched(self.answer.nodes, self.answer.solved);
            let before = (state.mass, state.sums.clone());
            state.mass = mass;
            state.masses[joint] = Some(chosen.mass);
            if new {
                state.used.insert(chosen.motor);
            }
            for (sum, costs) in state.sums.iter_mut().zip(&costs) {
                *sum += costs[item];
            }
            state.items[joint] = item;
            state.menus[joint] = Some(menu.clone());
            let bound = self.bound(depth + 1, state);
            if bound < self.threshold() {
                self.descend(depth + 1, state);
            } else {
                self.answer.lower = self.answer.lower.min(bound);
            }
            (state.mass, state.sums) = before;
            state.masses[joint] = None;
            if new {
                state.used.remove(&chosen.motor);
            }
        }
        state.menus[joint] = None;
    }

    fn bound(&self, depth: usize, state: &State<'a>) -> f64 {
        let open = self.open(depth, state);
        let of = |t: usize| state.sums[t] + self.rest(t, depth, state, &open);
        (0..self.tables.len()).map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Nothing further is looked at: what is left counts with its bounds.
    fn give_up(&mut self, depth: usize, state: &State<'a>) {
        self.answer.lower = self.answer.lower.min(self.bound(depth, state));
        self.answer.finished = false;
        self.ended = true;
    }

    fn finish(&mut self, state: &State<'a>) {
        let menus: Vec<Rc<Menu>> = state.menus.iter().flatten().cloned().collect();
        self.answer.solved += 1;
        if self.joints.is_costly() && self.answer.solved > MAX_SOLVED {
            self.give_up(self.order.len(), state);
            return;
        }
        let Some(completed) = self.joints.complete(&menus, &state.items, &state.coordinates) else { return };
        let (value, lower) = match self.rules.lightest {
            true => (if completed.value.is_finite() { state.mass } else { f64::INFINITY }, state.mass),
            false => (completed.value, completed.lower),
        };
        if !value.is_finite() {
            self.answer.finished = false;
            self.answer.lower = self.answer.lower.min(lower);
            return;
        }
        let motors: Vec<usize> = menus.iter().zip(&state.items).map(|(m, i)| m.items[*i].motor).collect();
        let found = Found {
            items: state.items.clone(),
            coordinates: state.coordinates.clone(),
            mass: state.mass,
            ratios: completed.ratios,
            motors,
            value,
            lower,
        };
        self.answer.lower = self.answer.lower.min(lower);
        let list = &mut self.answer.found;
        match list.iter().position(|f| f.motors == found.motors) {
            Some(same) if list[same].value <= found.value => return,
            Some(same) => {
                list.remove(same);
            }
            None => {}
        }
        let place = list.partition_point(|f| f.value <= found.value);
        list.insert(place, found);
        list.truncate(self.rules.keep);
    }
}
