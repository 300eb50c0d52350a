//! What the search asks of a robot: menus made once, or when a load is known; combinations solved.

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::answer::{Combination, Options};
use super::carry;
use super::convex::{least_over, lowest};
use super::menu::{Build, Item, Menu, Needs, made, menu, pieces};
use super::power::{self, Profile, Schedule};
use super::search::{Combinations, Completed, Entry, Found, Rules, Table};
use super::shared::{self, Known, Outcome, Part, Price, Shares};
use super::total::Total;
use super::work::Work;
use crate::Prepared;
use crate::answer::Design;
use crate::best::lacking;
use crate::judge;
use crate::mount::{JointDemand, Mount, Site, covered_inertia, load_through};
use crate::options::Stop;
use crate::program::RatioProgram;
use crate::solved::design;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::actuator::{Laurent, Load};
use gearwise_model::catalog::Catalog;
use gearwise_model::catalog::module::Inside;
use gearwise_model::requirement::{Joint, Robot};

/// Loads of carrying joints that are kept ready.
const MAX_LOADS: usize = 200;

/// Combinations whose programs give prices of power.
const PRICES: usize = 6;
/// Prices of solved combinations that are tried first on the next.
const KNOWN_PRICES: usize = 2;
/// Tables of prices that are kept, those with the best bounds.
const TABLES: usize = 4;

/// Steps of [`Work`] that a design of a joint takes under a load, and a bound of it at prices.
const DESIGN: usize = 3000;
const PRICED: usize = 300;
/// Steps of programs that take as long as one of [`Work`].
const OF_PROGRAMS: usize = 200;

/// Told at each branch of a search.
type Searched<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// The robot with all that was found out about its joints.
pub(super) struct Context<'a> {
    pub robot: &'a Robot,
    pub catalog: &'a Catalog,
    /// What is carried comes before what carries it.
    pub order: Vec<usize>,
    pub needs: Vec<Needs>,
    /// Whether the search is to stop.
    pub stop: Stop<'a>,
    /// When a search gives what it has.
    pub enough: Option<&'a (dyn Fn() -> bool + Sync)>,
    searched: Searched<'a>,
    /// Steps that the searches have taken, and their limit.
    pub work: Work,
    /// Menus of the joints that carry nothing.
    pub certain: Vec<Option<Arc<Menu<'a>>>>,
    /// All ways to build each joint.
    pub ways: Vec<Vec<Way<'a>>>,
    /// Motors of carrying joints that were not solved, or not proved, where they were tried.
    pub unproved: Vec<usize>,
    /// Of carrying joints: motors of which something that is asked for is not known whatever the load, and what.
    doubted: Vec<Vec<usize>>,
    exact: HashMap<(usize, usize, Vec<u64>), Option<Arc<Item<'a>>>>,
    loads: HashMap<(usize, Vec<u64>), Arc<Carrying<'a>>>,
    /// Loads of the joints' own motions, made where they are asked for: slow motion is looked at once for each winding.
    own_loads: Vec<OnceLock<Load>>,
    pub total: Total,
    pub schedule: Schedule,
    /// The budget of the power of all joints \[W\].
    pub power: Option<f64>,
    /// What a supply that sags under all joints gives at most \[W\].
    pub supply: Option<f64>,
    /// What may come back from all joints together \[W\].
    pub returned: Option<f64>,
    /// Where a search is to be short: bounds of ways to build a joint after which it ends.
    pub most_bounded: Option<usize>,
    /// What power cost in the combinations that were solved last, where it is all that is shared.
    prices: Vec<Price>,
    /// What power costs by the last combination that was too much for the bus.
    pub too_much: Option<Price>,
    /// The same, until an excess is made of it.
    shown: Option<Price>,
    /// Least power that a combination which was too much for the bus could do with \[W\].
    pub least_power: f64,
}

/// One way to build a joint.
#[derive(Debug, Clone)]
pub(super) struct Way<'a> {
    pub build: Build<'a>,
    /// Lightest and heaviest that one actuator can be \[kg\]: one number, where its gear is known.
    pub mass: (f64, f64),
    /// What it is; `None` where that depends on the load.
    pub item: Option<Arc<Item<'a>>>,
}

/// A carrying joint under one load.
#[derive(Debug)]
pub(super) struct Carrying<'a> {
    pub joint: Joint,
    pub demand: JointDemand<'a>,
}

/// A joint of a combination under the load that it has there.
struct Loaded {
    joint: Joint,
    load: Load,
}

impl<'a> Context<'a> {
    pub(super) fn new(robot: &'a Robot, catalog: &'a Catalog, options: Options<'a>) -> Result<Context<'a>, String> {
        let n = robot.joints.len();
        let stop = Stop::when(options.stop);
        let budget = robot.shared_power();
        let supply = robot.shared_resistance().map(|resistance| robot.bus.voltage.powi(2) / (4.0 * resistance));
        let returned = robot.shared_regeneration();
        let carried = |j: usize| robot.joints.iter().any(|k| k.carries.iter().any(|c| c.joint == j));
        let needs: Vec<Needs> = (0..n)
            .map(|j| Needs {
                mass: robot.budget.actuator_mass.is_some() || carried(j),
                moves: budget.is_some() || supply.is_some() || returned.is_some(),
                only_checked: options.only_checked,
            })
            .collect();
        let mut certain: Vec<Option<Arc<Menu>>> = vec![None; n];
        for j in 0..n {
            let joint = &robot.joints[j];
            if !joint.carries.is_empty() {
                continue;
            }
            let same = |i: &usize| {
                certain[*i].is_some() && joint.asks_the_same(&robot.joints[*i]) && needs[*i].mass == needs[j].mass
            };
            certain[j] = match (0..j).find(same) {
                Some(i) => certain[i].clone(),
                None => Some(Arc::new(menu(robot, joint, catalog, needs[j], stop))),
            };
            (options.tick)();
        }
        let mut doubted = vec![Vec::new(); n];
        let ways = (0..n)
            .map(|j| match &certain[j] {
                Some(menu) => menu.items.iter().map(Way::certain).collect(),
                None => ways(robot, &robot.joints[j], catalog, needs[j], &mut doubted[j]),
            })
            .collect();
        let least = |menu: &Menu| menu.items.iter().map(|i| i.design.optimum.objective).fold(f64::INFINITY, f64::min);
        let alone = |j: usize| match &certain[j] {
            // Nothing is chosen for the robot then.
            Some(menu) if menu.items.is_empty() => 1.0,
            Some(menu) => least(menu),
            None => least(&menu(robot, &robot.joints[j], catalog, needs[j], stop)),
        };
        let differ = robot.joints.iter().any(|j| j.objective != robot.joints[0].objective);
        let best: Vec<f64> = if differ { (0..n).map(alone).collect() } else { vec![1.0; n] };
        let total = Total::new(&robot.joints, &best)?;
        Ok(Context {
            order: carry::order(&robot.joints),
            schedule: Schedule::new(robot),
            exact: HashMap::new(),
            loads: HashMap::new(),
            own_loads: vec![OnceLock::new(); n],
            unproved: Vec::new(),
            doubted,
            ways,
            most_bounded: None,
            prices: Vec::new(),
            too_much: None,
            shown: None,
            least_power: f64::INFINITY,
            robot,
            catalog,
            needs,
            stop,
            enough: options.enough,
            searched: options.searched,
            work: Work::endless(),
            certain,
            total,
            power: budget,
            supply,
            returned,
        })
    }

    /// Whether a search is to end now.
    pub(super) fn ends(&self) -> bool {
        self.stop.now() || self.enough.map_or_else(|| self.work.left() == 0, |enough| enough())
    }

    /// So many of something, where nobody says when it is enough.
    pub(super) fn at_most(&self, most: usize) -> usize {
        if self.enough.is_some() { usize::MAX } else { most }
    }

    /// The limit on the power of all joints \[W\].
    pub(super) fn limit(&self) -> Option<f64> {
        self.power.into_iter().chain(self.supply).reduce(f64::min)
    }

    /// Whether the ratios of a combination depend on each other.
    pub(super) fn shares_power(&self) -> bool {
        self.limit().is_some() || self.returned.is_some()
    }

    /// Whether no actuator loads another one.
    pub(super) fn is_certain(&self) -> bool {
        self.certain.iter().all(Option::is_some)
    }

    /// Mass of all actuators of a joint of which one has this \[kg\].
    pub(super) fn weight(&self, joint: usize, mass: f64) -> f64 {
        f64::from(self.robot.joints[joint].count) * mass
    }

    /// Some ways of each joint as a search sees them.
    pub(super) fn entries(&self, ways: &[Vec<usize>]) -> Vec<Vec<Entry>> {
        let entry = |joint: usize, way: &usize| {
            let way = &self.ways[joint][*way];
            Entry { motor: way.build.motor, mass: self.weight(joint, way.mass.0) }
        };
        ways.iter().enumerate().map(|(j, of_joint)| of_joint.iter().map(|way| entry(j, way)).collect()).collect()
    }

    /// A carrying joint under the load that it has at some coordinates.
    pub(super) fn carrying(&mut self, joint: usize, coordinates: &[f64]) -> Arc<Carrying<'a>> {
        let key = (joint, bits(coordinates));
        if let Some(ready) = self.loads.get(&key) {
            return ready.clone();
        }
        if self.loads.len() >= MAX_LOADS {
            self.loads.clear();
        }
        let loaded = carry::loaded(&self.robot.joints[joint], coordinates);
        let ready = Arc::new(Carrying { demand: JointDemand::new(&loaded, self.catalog), joint: loaded });
        self.loads.insert(key, ready.clone());
        ready
    }

    /// What some ways to build a joint come to at some coordinates of its load, each made once; `None` of those that cannot be.
    pub(super) fn exact(&mut self, joint: usize, ways: &[usize], coordinates: &[f64]) -> Vec<Option<Arc<Item<'a>>>> {
        let key = |way: usize| (joint, way, bits(coordinates));
        let known = |way: &usize| self.ways[joint][*way].item.is_some() || self.exact.contains_key(&key(*way));
        let new: Vec<usize> = ways.iter().copied().filter(|way| !known(way)).collect();
        if !new.is_empty() {
            let carrying = self.carrying(joint, coordinates);
            let (robot, catalog, needs, stop) = (self.robot, self.catalog, self.needs[joint], self.stop);
            let all = &self.ways[joint];
            let done = AtomicU64::new(0);
            let of = |way: &usize| {
                let site = Site::new(robot, &carrying.joint, &carrying.demand).stopping(stop.adding(&done));
                made(site, catalog, needs, all[*way].build)
            };
            let made: Vec<_> = new.par_iter().map(of).collect();
            self.work.count((new.len() * DESIGN).max(done.into_inner() as usize / OF_PROGRAMS));
            for (way, made) in new.iter().zip(made) {
                self.unproved.extend(made.unproved.then_some(self.ways[joint][*way].build.motor));
                self.exact.insert(key(*way), made.items.into_iter().next());
            }
        }
        let one = |way: &usize| match &self.ways[joint][*way].item {
            Some(item) => Some(item.clone()),
            None => self.exact[&key(*way)].clone(),
        };
        ways.iter().map(one).collect()
    }

    /// What an item comes to at other coordinates of its joint's load.
    pub(super) fn again(&mut self, joint: usize, item: &Item<'a>, coordinates: &[f64]) -> Option<Arc<Item<'a>>> {
        let gear = item.design.gear;
        let ratio = item.design.evaluation.ratio;
        let pieces = pieces(&self.robot.joints[joint], self.needs[joint]);
        let holds = |piece: &Joint| piece.ratio.range().is_none_or(|(min, max)| min <= ratio && ratio <= max);
        let piece = pieces.iter().position(holds)?;
        let same = |way: &Way| {
            let build = &way.build;
            build.motor == item.motor && build.gear.map(|gear| gear.id.as_str()) == gear && build.piece == piece
        };
        let way = self.ways[joint].iter().position(same)?;
        self.exact(joint, &[way], coordinates).pop().flatten()
    }

    /// Motors that are no choice because something that is asked for is not known, by joint: of carrying joints at the load that they
    /// have in a combination.
    pub(super) fn unjudged(&mut self, found: Option<&Found<'a>>) -> BTreeMap<(usize, usize), Vec<Remark>> {
        let mut all: BTreeMap<(usize, usize), Vec<Remark>> = BTreeMap::new();
        for joint in 0..self.robot.joints.len() {
            if let Some(menu) = &self.certain[joint] {
                for (motor, because) in &menu.unjudged {
                    all.entry((joint, *motor)).or_default().extend(because);
                }
                menu.items.iter().for_each(|item| drop(all.remove(&(joint, item.motor))));
                continue;
            }
            let masses = |k: usize| found.map_or(0.0, |found| found.items[k].mass);
            let coordinates = carry::coordinates(&self.robot.joints[joint], masses);
            let carrying = self.carrying(joint, &coordinates);
            let (robot, catalog, needs, stop) = (self.robot, self.catalog, self.needs[joint], self.stop);
            let of_motor = |motor: &usize| {
                let site = Site::new(robot, &carrying.joint, &carrying.demand).stopping(stop);
                let mut because = Vec::new();
                let builds = builds(site, catalog, *motor, needs);
                let mut is_choice = false;
                for build in builds {
                    let made = made(site, catalog, needs, build);
                    is_choice |= !made.items.is_empty();
                    because.extend(made.unjudged);
                }
                because.sort_unstable();
                because.dedup();
                (*motor, because, is_choice)
            };
            let doubted: Vec<_> = self.doubted[joint].par_iter().map(of_motor).collect();
            let apart = doubted.into_iter().filter(|(_, because, is_choice)| !is_choice && !because.is_empty());
            all.extend(apart.map(|(motor, because, _)| ((joint, motor), because)));
        }
        all
    }

    fn loaded(&self, items: &[&Item<'a>], coordinates: &[Vec<f64>]) -> Vec<Loaded> {
        let mount = |(j, item): (usize, &&Item)| {
            let joint = carry::loaded(&self.robot.joints[j], &coordinates[j]);
            let gear = item.design.gear.and_then(|id| self.catalog.gear(id));
            let joint = sprung(&joint, item).unwrap_or(joint);
            let is_own = coordinates[j].is_empty() && joint.limits.spring.is_none() && joint.gear_map.is_none();
            let covers = gear.is_some_and(|gear| covered_inertia(&joint, gear).is_some());
            let load = match is_own && !covers && item.design.spring.is_none() {
                true => self.own_load(j).clone(),
                false => load_through(&joint, gear),
            };
            Loaded { joint, load }
        };
        items.iter().enumerate().map(mount).collect()
    }

    fn own_load(&self, joint: usize) -> &Load {
        let of = &self.robot.joints[joint];
        self.own_loads[joint].get_or_init(|| Load::new(&of.motion, of.ripple()))
    }

    fn mount<'m>(&'m self, loaded: &'m Loaded, item: &Item<'a>) -> Mount<'m, 'm> {
        let motor = &self.catalog.motors[item.motor];
        let gear = item.design.gear.and_then(|id| self.catalog.gear(id));
        Mount::new(self.robot, &loaded.joint, &loaded.load, motor).with_gear(gear)
    }

    fn prepare<'m>(&'m self, loaded: &'m Loaded, item: &Item<'a>) -> Prepared<'m> {
        self.mount(loaded, item).prepared().expect("an item of a menu is a candidate")
    }

    fn profile(&self, prepared: &Prepared, ratio: f64) -> Profile {
        Profile::of(prepared, ratio)
    }

    /// Calls `look` with the parts of a combination.
    fn with_parts<T>(&self, items: &[&Item<'a>], coordinates: &[Vec<f64>], look: impl FnOnce(&mut [Part]) -> T) -> T {
        let mounts = self.loaded(items, coordinates);
        let prepared: Vec<Prepared> = mounts.iter().zip(items).map(|(m, item)| self.prepare(m, item)).collect();
        let mut parts: Vec<Part> = (0..items.len())
            .map(|j| Part {
                prepared: &prepared[j],
                joint: &mounts[j].joint,
                profile: self.profile(&prepared[j], items[j].design.evaluation.ratio),
                ratios: items[j].ratios,
                own: items[j].design.evaluation.ratio,
                objective: items[j].design.optimum.objective,
                lower: items[j].lower,
                scale: self.total.scale[j],
            })
            .collect();
        look(&mut parts)
    }

    /// The best ratios of a combination under what its joints share, the limit on power given.
    fn solve(
        &mut self,
        items: &[&Item<'a>],
        coordinates: &[Vec<f64>],
        (limit, returned): (f64, Option<f64>),
        threshold: f64,
    ) -> Outcome {
        let known = Known { prices: &self.prices, too_much: self.too_much.as_ref() };
        let outcome = self.with_parts(items, coordinates, |parts| {
            let shares = Shares { schedule: &self.schedule, limit, returned, work: &self.work };
            shared::solve(parts, shares, (threshold, known), &|| self.ends())
        });
        if let Outcome::Solved(solved) = &outcome
            && !solved.price.rows.is_empty()
        {
            self.prices.insert(0, solved.price.clone());
            self.prices.truncate(KNOWN_PRICES);
        }
        // On a supply that sags it is not known what is too much.
        if let (Outcome::TooMuch { least, .. }, None) = (&outcome, self.supply) {
            self.least_power = self.least_power.min(*least);
        }
        outcome
    }

    /// The costs of all that joints may be built of which carry nothing; of those that carry they are given.
    fn own_costs(&self) -> Vec<Vec<f64>> {
        let of = |(joint, ways): (usize, &Vec<Way>)| {
            let lower = |way: &Way| way.item.as_ref().map_or(f64::NEG_INFINITY, |item| item.lower);
            ways.iter().map(|way| self.total.scale[joint] * lower(way)).collect()
        };
        self.ways.iter().enumerate().map(of).collect()
    }

    /// Tables of prices that go with the rules where no actuator loads another one: prices on mass and on power.
    pub(super) fn tables(&mut self, rules: Rules) -> Vec<Table> {
        if rules.lightest {
            return vec![Table { per_mass: 0.0, costs: self.masses(), offset: 0.0, is_excess: false }];
        }
        let plain = Table { per_mass: 0.0, costs: self.own_costs(), offset: 0.0, is_excess: false };
        let mut tables = vec![plain.clone()];
        if let Some(limit) = self.limit() {
            tables.extend(self.power_tables(&plain, limit));
        }
        let all: Vec<Vec<usize>> = self.ways.iter().map(|ways| (0..ways.len()).collect()).collect();
        self.with_prices_of_mass(tables, &all, rules)
    }

    /// Tables with some prices of a kilogram beside those of before, where there is a budget of mass.
    pub(super) fn with_prices_of_mass(&self, mut tables: Vec<Table>, ways: &[Vec<usize>], rules: Rules) -> Vec<Table> {
        if let Some(limit) = rules.mass.filter(|_| !rules.lightest) {
            let priced: Vec<Table> = tables
                .iter()
                .filter(|table| !table.is_excess)
                .flat_map(|table| {
                    let price = self.price_of_mass(table, ways, limit);
                    [0.5, 2.0, 1.0].map(|factor| Table { per_mass: factor * price, ..table.clone() })
                })
                .filter(|t| t.per_mass > 0.0)
                .collect();
            tables.extend(priced);
        }
        tables
    }

    /// Mass of all that joints may be built of \[kg\].
    pub(super) fn masses(&self) -> Vec<Vec<f64>> {
        let of = |(joint, ways): (usize, &Vec<Way>)| ways.iter().map(|way| self.weight(joint, way.mass.0)).collect();
        self.ways.iter().enumerate().map(of).collect()
    }

    /// The price of a kilogram at which the cheapest ways together just keep the budget.
    fn price_of_mass(&self, table: &Table, ways: &[Vec<usize>], limit: f64) -> f64 {
        let weight = |joint: usize, way: usize| self.weight(joint, self.ways[joint][way].mass.0);
        let mass_at = |price: f64| -> f64 {
            let of = |(j, ways): (usize, &Vec<usize>)| {
                let cost = |way: &usize| table.costs[j][*way] + price * weight(j, *way);
                let best = ways.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
                best.map_or(0.0, |way| weight(j, *way))
            };
            ways.iter().enumerate().map(of).sum()
        };
        if mass_at(0.0) <= limit {
            return 0.0;
        }
        let least = |(j, ways): (usize, &Vec<usize>)| {
            ways.iter().map(|way| table.costs[j][*way].abs()).filter(|c| c.is_finite()).reduce(f64::min)
        };
        let size: f64 = ways.iter().enumerate().filter_map(least).sum();
        let mut high = if size > 0.0 { size / limit } else { 1.0 };
        let mut low = 0.0;
        for _ in 0..60 {
            if mass_at(high) <= limit {
                break;
            }
            low = high;
            high *= 2.0;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if mass_at(middle) <= limit { high = middle } else { low = middle }
        }
        high
    }

    /// Prices of power from a few combinations: the cheapest under the prices so far is solved, and what its
    /// program says of power is mixed with them in the share that gives the best bound.
    fn power_tables(&mut self, plain: &Table, limit: f64) -> Vec<Table> {
        let menus: Vec<Arc<Menu>> = self.certain.iter().flatten().cloned().collect();
        if menus.iter().any(|m| m.items.is_empty()) {
            return Vec::new();
        }
        let nothing = vec![Vec::new(); menus.len()];
        let mut tables: Vec<(f64, Price, Table)> = Vec::new();
        let mut excesses: Vec<Table> = Vec::new();
        let mut seen: Vec<Vec<usize>> = Vec::new();
        for _ in 0..PRICES {
            let best = tables.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            let (center, table) = best.map_or((Price::default(), plain), |(_, price, table)| (price.clone(), table));
            let cheapest = |(j, menu): (usize, &Arc<Menu>)| {
                let cost = |i: usize| table.costs[j][i];
                (0..menu.items.len()).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0)
            };
            let chosen: Vec<usize> = menus.iter().enumerate().map(cheapest).collect();
            if seen.contains(&chosen) {
                break;
            }
            let items: Vec<&Item> = menus.iter().zip(&chosen).map(|(m, i)| &*m.items[*i]).collect();
            let worth: f64 = items.iter().zip(&self.total.scale).map(|(i, s)| s * i.lower.abs()).sum();
            // Without what comes back: that has no part in the bounds.
            let (price, factor) = match self.solve(&items, &nothing, (limit, None), f64::INFINITY) {
                Outcome::Solved(solved) => (solved.price, 1.0),
                Outcome::TooMuch { price, .. } => {
                    self.shown = Some(price.of_all()).filter(|price| !price.rows.is_empty());
                    excesses.extend(self.excess());
                    (price, 3.0 * worth / limit)
                }
                Outcome::ComesBack => break,
            };
            seen.push(chosen);
            if price.rows.is_empty() {
                break;
            }
            let shares: &[f64] = if center.rows.is_empty() { &[1.0, 0.5, 0.25] } else { &[1.0, 0.5, 0.2] };
            for share in shares {
                let old = center.rows.iter().map(|(places, m)| (places.clone(), (1.0 - share) * m));
                let new = price.rows.iter().map(|(places, m)| (places.clone(), share * factor * m));
                let mixed = Price { rows: old.chain(new).filter(|(_, m)| *m > 0.0).collect() };
                let table = self.power_table(&mixed);
                let least = |costs: &Vec<f64>| costs.iter().copied().fold(f64::INFINITY, f64::min);
                let bound = table.offset + table.costs.iter().map(least).sum::<f64>();
                tables.push((bound, mixed, table));
            }
        }
        tables.sort_by(|a, b| a.0.total_cmp(&b.0));
        let few = tables.len().saturating_sub(TABLES);
        excesses.into_iter().chain(tables.into_iter().skip(few).map(|(.., table)| table)).collect()
    }

    /// Least power of each way to build each joint at the instants at which the last combination drew too much, less the budget.
    fn excess(&mut self) -> Option<Table> {
        let (price, limit) = self.shown.take().filter(|_| self.is_certain()).zip(self.limit())?;
        let (weights, _) = self.powers(&price.shares());
        let all = |joint: usize| (0..self.ways[joint].len()).collect::<Vec<usize>>();
        let costs = weights.iter().enumerate().map(|(j, weights)| self.certain_power(j, &all(j), weights)).collect();
        Some(Table { per_mass: 0.0, costs, offset: -limit, is_excess: true })
    }

    fn power_table(&self, price: &Price) -> Table {
        let (weights, worth) = self.powers(price);
        let all = |joint: usize| (0..self.ways[joint].len()).collect::<Vec<usize>>();
        let costs = weights.iter().enumerate().map(|(j, weights)| self.certain_costs(j, &all(j), weights)).collect();
        Table { per_mass: 0.0, costs, offset: -worth, is_excess: false }
    }

    /// The weights of the power of each joint's samples at prices \[objective/W\], and what the budget is worth at them.
    pub(super) fn powers(&self, price: &Price) -> (Vec<Vec<(usize, f64)>>, f64) {
        let mut weights: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.robot.joints.len()];
        let mut worth = 0.0;
        let limit = self.limit().unwrap_or(f64::INFINITY);
        for (places, multiplier) in price.rows.iter().filter(|(places, _)| places.drive.is_none()) {
            worth += multiplier * limit;
            for (j, sample, weight) in self.schedule.parts(places) {
                weights[*j].push((*sample, multiplier * weight));
            }
        }
        (weights, worth)
    }

    /// Lower bounds of some ways to build a joint that carries nothing, with the power that they draw at prices.
    pub(super) fn certain_costs(&self, joint: usize, ways: &[usize], weights: &[(usize, f64)]) -> Vec<f64> {
        let scale = self.total.scale[joint];
        let item = |way: &usize| self.ways[joint][*way].item.as_ref();
        if weights.is_empty() {
            return ways.iter().map(|way| scale * item(way).map_or(f64::NEG_INFINITY, |item| item.lower)).collect();
        }
        self.priced_costs(joint, ways, weights, scale)
    }

    /// Lower bounds of the power that some ways to build a joint draw which carries nothing, at prices.
    pub(super) fn certain_power(&self, joint: usize, ways: &[usize], weights: &[(usize, f64)]) -> Vec<f64> {
        if weights.is_empty() {
            return vec![0.0; ways.len()];
        }
        self.priced_costs(joint, ways, weights, 0.0)
    }

    fn priced_costs(&self, joint: usize, ways: &[usize], weights: &[(usize, f64)], scale: f64) -> Vec<f64> {
        let of = &self.robot.joints[joint];
        let load = self.own_load(joint);
        let one = |way: &usize| {
            let item = self.ways[joint][*way].item.as_ref();
            item.map_or(f64::NEG_INFINITY, |item| priced(self.robot, self.catalog, of, load, item, scale, weights))
        };
        self.work.count(ways.len() * PRICED);
        ways.par_iter().map(one).collect()
    }

    /// A combination with all that is known of it.
    pub(super) fn combination(&self, found: &Found<'a>) -> Combination<'a> {
        let items: Vec<&Item> = found.items.iter().map(|item| &**item).collect();
        let own_ratios: Vec<f64> = items.iter().map(|i| i.design.evaluation.ratio).collect();
        let ratios = found.ratios.clone().unwrap_or(own_ratios);
        let draws = self.with_parts(&items, &found.coordinates, |parts| shared::draws(parts, &self.schedule, &ratios));
        let powers: Vec<&[f64]> = draws.iter().map(|draws| draws.power.as_slice()).collect();
        let open = self.robot.bus.voltage;
        let sag = self.robot.shared_resistance().and_then(|shared| power::sag(&self.schedule, &draws, (open, shared)));
        // Where what comes back decides the ratios, the multipliers of the power are those of a part of them.
        let price = self.power.filter(|_| self.returned.is_none()).map(|_| {
            let of_power = found.price.rows.iter().filter(|(places, _)| places.drive.is_none());
            -of_power.map(|(_, multiplier)| multiplier).sum::<f64>()
        });
        let mounts = self.loaded(&items, &found.coordinates);
        let designs: Vec<Design> = (0..items.len())
            .map(|j| {
                let mut design_of = items[j].design.clone();
                if ratios[j] != design_of.evaluation.ratio {
                    let prepared = self.prepare(&mounts[j], items[j]);
                    let objective = prepared.at_in_full(ratios[j]).objective(&self.robot.joints[j].objective);
                    let optimum = crate::program::Optimum {
                        ratio: ratios[j],
                        objective: objective.unwrap_or(f64::NAN),
                        shadow_prices: Vec::new(),
                        ..design_of.optimum
                    };
                    let mount = self.mount(&mounts[j], items[j]);
                    design_of = design(&mount, &prepared, optimum).of_catalog(self.catalog);
                }
                design_of
            })
            .collect();
        let counts = self.robot.joints.iter().map(|j| f64::from(j.count));
        let mass = designs.iter().zip(counts).map(|(d, count)| Some(d.evaluation.mass? * count)).sum();
        let mut motors = found.motors.clone();
        motors.sort_unstable();
        motors.dedup();
        let carried_torque = found.coordinates.clone();
        // Of a module whose currents nobody knows there is no power.
        let says_power = |d: &Design| d.motor.inside.as_deref().is_none_or(Inside::says_whole_power);
        let known = designs.iter().all(says_power);
        let if_known = |power: f64| if known { power } else { f64::NAN };
        Combination {
            joints: designs,
            objective: found.value,
            lower_bound: found.lower,
            mass,
            peak_power: if_known(power::largest(&self.schedule, &powers).0),
            most_returned: if_known(power::most_returned(&self.schedule, &draws).0),
            peak_power_by_case: if known { power::by_case(&self.schedule, &powers) } else { Vec::new() },
            sag,
            power_price: price,
            per_mass: Vec::new(),
            distinct_motors: motors.len(),
            carried: carried_torque,
        }
    }

    /// A complete combination of ways, where it may be better than a value.
    pub(super) fn complete(&mut self, chosen: &[usize], threshold: f64) -> Completed<'a> {
        let n = chosen.len();
        let mut items: Vec<Option<Arc<Item>>> = vec![None; n];
        let mut coordinates = vec![Vec::new(); n];
        for j in self.order.clone() {
            let mass = |k: usize| items[k].as_ref().map_or(0.0, |item: &Arc<Item>| item.mass);
            coordinates[j] = carry::coordinates(&self.robot.joints[j], mass);
            let item = self.exact(j, &[chosen[j]], &coordinates[j]).pop().flatten();
            if item.is_none() {
                return Completed::Cannot;
            }
            items[j] = item;
        }
        let items: Vec<Arc<Item>> = items.into_iter().flatten().collect();
        let mass = items.iter().enumerate().map(|(j, item)| self.weight(j, item.mass)).sum();
        let motors = items.iter().map(|item| item.motor).collect();
        let sum = |of: &dyn Fn(&Item) -> f64| -> f64 {
            items.iter().zip(&self.total.scale).map(|(item, scale)| scale * of(item)).sum()
        };
        // What is shared makes nothing better.
        let least = sum(&|i| i.lower);
        let (ratios, value, lower, price) = match self.shares_power() {
            false => (None, sum(&|i| i.design.optimum.objective), least, Price::default()),
            true if least >= threshold => return Completed::NoBetter(least),
            true => {
                let refs: Vec<&Item> = items.iter().map(|item| &**item).collect();
                let limit = self.limit().unwrap_or(f64::INFINITY);
                match self.solve(&refs, &coordinates, (limit, self.returned), threshold) {
                    Outcome::Solved(solved) => (Some(solved.ratios), solved.value, solved.lower, solved.price),
                    Outcome::TooMuch { price, .. } => {
                        // Rows of a share of one are made as dear as the robot.
                        let worth: f64 = items.iter().zip(&self.total.scale).map(|(i, s)| s * i.lower.abs()).sum();
                        self.shown = Some(price.of_all()).filter(|price| !price.rows.is_empty());
                        let factor = 3.0 * worth / limit;
                        let dear = price.rows.into_iter().map(|(places, m)| (places, factor * m));
                        self.too_much = Some(Price { rows: dear.collect() });
                        return Completed::Cannot;
                    }
                    Outcome::ComesBack => return Completed::Cannot,
                }
            }
        };
        Completed::Found(Found { ways: chosen.to_vec(), items, coordinates, motors, mass, ratios, price, value, lower })
    }
}

/// A search over some ways of each joint.
pub(super) struct Among<'s, 'a> {
    pub context: &'s mut Context<'a>,
    pub ways: &'s [Vec<usize>],
}

impl<'a> Combinations<'a> for Among<'_, 'a> {
    fn is_stopped(&self) -> bool {
        self.context.ends()
    }

    fn is_timed(&self) -> bool {
        self.context.enough.is_some()
    }

    fn searched(&self, branches: usize, solved: usize) {
        (self.context.searched)(branches, solved);
    }

    fn count(&self, steps: usize) {
        self.context.work.count(steps);
    }

    fn excess(&mut self) -> Option<Table> {
        self.context.excess()
    }

    fn complete(&mut self, entries: &[usize], threshold: f64) -> Completed<'a> {
        let chosen: Vec<usize> = entries.iter().zip(self.ways).map(|(entry, ways)| ways[*entry]).collect();
        self.context.complete(&chosen, threshold)
    }
}

impl<'a> Way<'a> {
    fn certain(item: &Arc<Item<'a>>) -> Way<'a> {
        let build = Build { motor: item.motor, gear: None, piece: 0 };
        Way { build, mass: (item.mass, item.mass), item: Some(item.clone()) }
    }
}

fn bits(coordinates: &[f64]) -> Vec<u64> {
    coordinates.iter().map(|y| y.to_bits()).collect()
}

/// How a motor may be built into a joint, whatever its load.
fn builds<'a>(site: Site, catalog: &'a Catalog, motor: usize, needs: Needs) -> Vec<Build<'a>> {
    let row = &catalog.motors[motor];
    if !site.is_geared_with(row) {
        return (0..pieces(site.joint, needs).len()).map(|piece| Build { motor, gear: None, piece }).collect();
    }
    if site.joint.limits.spring.is_some() {
        return vec![Build { motor, gear: None, piece: 0 }];
    }
    let gears = site.mounts(row).filter_map(|mount| catalog.gear_of(row, mount.gear_id()?));
    gears.map(|gear| Build { motor, gear: Some(gear), piece: 0 }).collect()
}

/// All ways to build a joint that carries others of which all that is asked for is known, whatever the load; and the motors that are
/// no choice for what is not known of them, or may not be one.
fn ways<'a>(
    robot: &'a Robot,
    joint: &Joint,
    catalog: &'a Catalog,
    needs: Needs,
    doubted: &mut Vec<usize>,
) -> Vec<Way<'a>> {
    let demand = JointDemand::new(joint, catalog);
    let site = Site::new(robot, joint, &demand);
    let pieces = pieces(joint, needs);
    let of_motor = |motor: usize| {
        let row = &catalog.motors[motor];
        let mut doubt = false;
        let mut of_motor: Vec<Way> = Vec::new();
        if let Some(why) = lacking(row, demand.load.duration.is_some(), |q| joint.objective.weight(q) > 0.0) {
            return (of_motor, why.unknown().is_some());
        }
        for build in builds(site, catalog, motor, needs) {
            let gear = build.gear.map(|gear| gear.id.as_str());
            let mounts: Vec<Mount> = match gear {
                None if site.is_geared_with(row) => site.mounts(row).collect(),
                None => vec![site.direct(row)],
                Some(_) => site.mount(row, gear).into_iter().collect(),
            };
            let mounts: Vec<_> = mounts.into_iter().map(Mount::prepared).collect();
            let Some(mass) = span(mounts.iter().flatten(), &pieces[build.piece.min(pieces.len() - 1)], needs) else {
                doubt = true;
                continue;
            };
            let mut judged = false;
            for prepared in mounts {
                match prepared {
                    Ok(prepared) => {
                        let of = |unchecked: &[Remark]| {
                            judge::left_out(robot, joint, unchecked, needs.only_checked).is_some()
                                || !judge::unjudged(robot, joint, unchecked).is_empty()
                        };
                        let unknown = of(&prepared.unchecked);
                        doubt |= unknown || judge::may_change(&prepared, needs.only_checked);
                        judged |= !unknown;
                    }
                    Err(why) => doubt |= why.unknown().is_some(),
                }
            }
            if judged {
                of_motor.push(Way { build, mass, item: None });
            }
        }
        (of_motor, doubt)
    };
    let all: Vec<(Vec<Way>, bool)> = (0..catalog.motors.len()).into_par_iter().map(of_motor).collect();
    doubted.extend(all.iter().enumerate().filter(|(_, (_, doubt))| *doubt).map(|(motor, _)| motor));
    all.into_iter().flat_map(|(ways, _)| ways).collect()
}

/// Lightest and heaviest that an actuator with its transmission can be \[kg\]; `None` where its mass decides and is not known. Without any
/// actuator it is zero.
fn span<'p>(actuators: impl Iterator<Item = &'p Prepared<'p>>, piece: &Joint, needs: Needs) -> Option<(f64, f64)> {
    let of = |prepared: &Prepared| {
        let candidate = &prepared.candidate;
        let own = candidate.catalog_gear.map(|gear| (gear.ratio, gear.ratio));
        candidate.mass_between(own.or(piece.ratio.range())?)
    };
    let mut known = actuators.map(of).peekable();
    if !needs.mass || known.peek().is_none() {
        return Some((0.0, 0.0));
    }
    known.flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The joint with the spring that was chosen for it taking its part of the load; `None` where none was.
fn sprung(joint: &Joint, item: &Item) -> Option<Joint> {
    let spring = item.design.spring.as_ref()?;
    joint.with_spring(spring.stiffness, spring.rest_angle.unwrap_or(0.0))
}

/// A lower bound of an item's objective and of the power it draws at prices, over the ratios it may have.
fn priced(
    robot: &Robot,
    catalog: &Catalog,
    joint: &Joint,
    load: &Load,
    item: &Item,
    scale: f64,
    weights: &[(usize, f64)],
) -> f64 {
    let motor = &catalog.motors[item.motor];
    let gear = item.design.gear.and_then(|id| catalog.gear(id));
    let sprung = sprung(joint, item);
    let joint = sprung.as_ref().unwrap_or(joint);
    let own = (sprung.is_some() || gear.is_some_and(|gear| covered_inertia(joint, gear).is_some()))
        .then(|| load_through(joint, gear));
    let load = own.as_ref().unwrap_or(load);
    let mount = Mount::new(robot, joint, load, motor).with_gear(gear);
    let Ok(prepared) = mount.prepared() else { return f64::INFINITY };
    let own = item.design.evaluation.ratio;
    let profile = Profile::of(&prepared, own);
    let power = |n: f64| weights.iter().map(|(k, w)| w * profile.at(*k, n).0).sum::<f64>();
    if item.ratios.1 / item.ratios.0 - 1.0 <= 1e-12 {
        return scale * item.lower + power(own);
    }
    let program = RatioProgram::new(&prepared, &joint.objective, item.ratios.0, item.ratios.1);
    let (a, b) = item.ratios;
    let cut = |n: f64| {
        let own = (program.objective_cut(n).0 + Laurent::constant(program.objective_cut(b).1)) * scale;
        weights.iter().fold(own, |sum, (k, weight)| sum + profile.at(*k, n).1 * *weight)
    };
    let best = lowest((a, b), cut, None, |n| scale * program.objective_at(n) + power(n));
    least_over(&cut(best), (a, b))
}
