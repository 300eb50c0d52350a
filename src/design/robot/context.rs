//! What the search asks of a robot: menus made once, or when a load is known; combinations solved.

use std::collections::HashMap;
use std::rc::Rc;

use rayon::prelude::*;

use super::answer::{Combination, Options};
use super::carry::{self, Boxes};
use super::convex::{Convex, add, under};
use super::menu::{Item, Menu, Needs, menu};
use super::power::{self, Profile, Schedule};
use super::search::{Completed, Found, Joints, Rules, Table};
use super::shared::{self, Outcome, Part, Price};
use super::total::Total;
use crate::actuator::Load;
use crate::catalog::Catalog;
use crate::design::Prepared;
use crate::design::answer::Design;
use crate::design::mount::{Mount, covered_inertia, load_through};
use crate::design::options::Stop;
use crate::design::program::{RatioProgram, minimise, value};
use crate::design::solved::design;
use crate::numerics::line_search::least_in_range;
use crate::requirement::{Joint, RatioChoice, Robot};

/// Menus of joints under loads of their own that are made at most.
const MAX_MENUS: usize = 4000;
/// Motors times samples over all those menus at most: what a search may take does not grow with the catalogue.
const MENU_WORK: usize = 6_000_000;

/// Combinations whose programs give prices of power.
const PRICES: usize = 6;
/// Tables of prices that are kept, those with the best bounds.
const TABLES: usize = 4;

/// Told at each branch of a search.
type Searched<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// The robot with all that was found out about its joints.
pub(super) struct Context<'a> {
    pub robot: &'a Robot,
    pub catalog: &'a Catalog,
    pub order: Vec<usize>,
    pub needs: Vec<Needs>,
    /// Whether the search is to stop.
    pub stop: Stop<'a>,
    searched: Searched<'a>,
    pub certain: Vec<Option<Rc<Menu<'a>>>>,
    made: HashMap<(usize, Vec<u64>), Rc<Menu<'a>>>,
    /// Lightest and heaviest actuator of each joint.
    reach: Vec<(f64, f64)>,
    boxes: Vec<Option<Boxes>>,
    pub total: Total,
    pub schedule: Schedule,
    /// The budget of the power of all joints \[W\].
    pub power: Option<f64>,
    /// What a supply that sags under all joints gives at most \[W\].
    pub supply: Option<f64>,
    /// Least power that a combination which was too much for the bus could do with \[W\].
    pub least_power: f64,
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
        let carried = |j: usize| robot.joints.iter().any(|k| k.carries.iter().any(|c| c.joint == j));
        let needs: Vec<Needs> = (0..n)
            .map(|j| Needs {
                mass: robot.budget.actuator_mass.is_some() || carried(j),
                moves: budget.is_some() || supply.is_some(),
                only_checked: options.only_checked,
            })
            .collect();
        let mut certain: Vec<Option<Rc<Menu>>> = vec![None; n];
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
                None => Some(Rc::new(menu(robot, joint, catalog, needs[j], stop))),
            };
            (options.tick)();
        }
        let reach: Vec<(f64, f64)> = (0..n).map(|j| reach(&robot.joints[j], catalog, certain[j].as_deref())).collect();
        let boxes = (0..n)
            .map(|j| {
                let joint = &robot.joints[j];
                (!joint.carries.is_empty())
                    .then(|| Boxes::new(robot, joint, catalog, carry::reach(joint, |i| reach[i]), needs[j]))
            })
            .collect();
        let least = |menu: &Menu| menu.items.iter().map(|i| i.design.optimum.objective).fold(f64::INFINITY, f64::min);
        let alone = |j: usize| match &certain[j] {
            Some(menu) => least(menu),
            None => least(&menu(robot, &robot.joints[j], catalog, needs[j], stop)),
        };
        let differ = robot.joints.iter().any(|j| j.objective != robot.joints[0].objective);
        let best: Vec<f64> = if differ { (0..n).map(alone).collect() } else { vec![1.0; n] };
        let total = Total::new(&robot.joints, &best)?;
        Ok(Context {
            order: carry::order(&robot.joints),
            schedule: Schedule::new(robot),
            made: HashMap::new(),
            least_power: f64::INFINITY,
            robot,
            catalog,
            needs,
            stop,
            searched: options.searched,
            certain,
            reach,
            boxes,
            total,
            power: budget,
            supply,
        })
    }

    /// The limit on the power of all joints \[W\].
    pub(super) fn limit(&self) -> Option<f64> {
        self.power.into_iter().chain(self.supply).reduce(f64::min)
    }

    /// Every menu that was made, with the place of its joint.
    pub(super) fn menus(&self) -> impl Iterator<Item = (usize, &Menu<'a>)> {
        let certain = self.certain.iter().enumerate().filter_map(|(joint, menu)| Some((joint, &**menu.as_ref()?)));
        certain.chain(self.made.iter().map(|((joint, _), menu)| (*joint, &**menu)))
    }

    fn masses(&self, masses: &[Option<f64>], joint: usize) -> (f64, f64) {
        masses[joint].map_or(self.reach[joint], |m| (m, m))
    }

    fn loaded(&self, items: &[&Item<'a>], coordinates: &[Vec<f64>]) -> Vec<Loaded> {
        let mount = |(j, item): (usize, &&Item)| {
            let joint = carry::loaded(&self.robot.joints[j], &coordinates[j]);
            let gear = item.design.gear.and_then(|id| self.catalog.gears.iter().find(|g| g.id == id));
            let joint = sprung(&joint, item).unwrap_or(joint);
            let load = load_through(&joint, gear);
            Loaded { joint, load }
        };
        items.iter().enumerate().map(mount).collect()
    }

    fn mount<'m>(&'m self, loaded: &'m Loaded, item: &Item<'a>) -> Mount<'m, 'm> {
        let motor = &self.catalog.motors[item.motor];
        let gear = item.design.gear.and_then(|id| self.catalog.gears.iter().find(|g| g.id == id));
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

    fn solve(&mut self, items: &[&Item<'a>], coordinates: &[Vec<f64>], limit: f64) -> Outcome {
        let outcome = self.with_parts(items, coordinates, |parts| shared::solve(parts, &self.schedule, limit));
        // On a supply that sags it is not known what is too much.
        if let (Outcome::TooMuch { least, .. }, None) = (&outcome, self.supply) {
            self.least_power = self.least_power.min(*least);
        }
        outcome
    }

    /// Tables of prices that go with the rules: prices on mass and on power.
    pub(super) fn tables(&mut self, rules: Rules) -> Vec<Table> {
        let plain = Table { per_mass: 0.0, priced: None, offset: 0.0 };
        let mut tables = vec![plain.clone()];
        if let (Some(limit), None, true) = (self.power, self.supply, self.certain.iter().all(Option::is_some)) {
            tables.extend(self.power_tables(limit));
        }
        if let Some(limit) = rules.mass {
            let priced: Vec<Table> = tables
                .iter()
                .flat_map(|table| {
                    let price = self.price_of_mass(table, limit);
                    [0.5, 2.0, 1.0].map(|factor| Table { per_mass: factor * price, ..table.clone() })
                })
                .filter(|t| t.per_mass > 0.0)
                .collect();
            tables.extend(priced);
        }
        tables
    }

    fn cost(&self, table: &Table, joint: usize, item: usize, menu: &Menu) -> f64 {
        match &table.priced {
            Some(priced) => priced[joint][item],
            None => self.total.scale[joint] * menu.items[item].lower,
        }
    }

    /// The price of a kilogram at which the cheapest items together just keep the budget.
    fn price_of_mass(&self, table: &Table, limit: f64) -> f64 {
        let mass_at = |price: f64| -> f64 {
            let of = |(j, menu): (usize, &Option<Rc<Menu>>)| {
                let count = f64::from(self.robot.joints[j].count);
                let Some(menu) = menu else { return count * self.reach[j].0 };
                let cost = |i: usize| self.cost(table, j, i, menu) + price * count * menu.items[i].mass;
                let best = (0..menu.items.len()).min_by(|a, b| cost(*a).total_cmp(&cost(*b)));
                best.map_or(0.0, |i| count * menu.items[i].mass)
            };
            self.certain.iter().enumerate().map(of).sum()
        };
        if mass_at(0.0) <= limit {
            return 0.0;
        }
        let size: f64 = self
            .certain
            .iter()
            .enumerate()
            .filter_map(|(j, menu)| {
                let menu = menu.as_ref()?;
                (0..menu.items.len()).map(|i| self.cost(table, j, i, menu).abs()).reduce(f64::min)
            })
            .sum();
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
    fn power_tables(&mut self, limit: f64) -> Vec<Table> {
        let menus: Vec<Rc<Menu>> = self.certain.iter().flatten().cloned().collect();
        if menus.iter().any(|m| m.items.is_empty()) {
            return Vec::new();
        }
        let nothing = vec![Vec::new(); menus.len()];
        let plain = Table { per_mass: 0.0, priced: None, offset: 0.0 };
        let mut tables: Vec<(f64, Price, Table)> = Vec::new();
        let mut seen: Vec<Vec<usize>> = Vec::new();
        for _ in 0..PRICES {
            let best = tables.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            let (center, table) = best.map_or((Price::default(), &plain), |(_, price, table)| (price.clone(), table));
            let cheapest = |(j, menu): (usize, &Rc<Menu>)| {
                let cost = |i: usize| self.cost(table, j, i, menu);
                (0..menu.items.len()).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0)
            };
            let chosen: Vec<usize> = menus.iter().enumerate().map(cheapest).collect();
            if seen.contains(&chosen) {
                break;
            }
            let items: Vec<&Item> = menus.iter().zip(&chosen).map(|(m, i)| &m.items[*i]).collect();
            let worth: f64 = items.iter().zip(&self.total.scale).map(|(i, s)| s * i.lower.abs()).sum();
            let (price, factor) = match self.solve(&items, &nothing, limit) {
                Outcome::Solved(solved) => (solved.price, 1.0),
                Outcome::TooMuch { price, .. } => (price, 3.0 * worth / limit),
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
                let table = self.power_table(&menus, &mixed, limit);
                let least = |(j, menu): (usize, &Rc<Menu>)| {
                    (0..menu.items.len()).map(|i| self.cost(&table, j, i, menu)).fold(f64::INFINITY, f64::min)
                };
                let bound = table.offset + menus.iter().enumerate().map(least).sum::<f64>();
                tables.push((bound, mixed, table));
            }
        }
        tables.sort_by(|a, b| a.0.total_cmp(&b.0));
        let few = tables.len().saturating_sub(TABLES);
        tables.into_iter().skip(few).map(|(.., table)| table).collect()
    }

    fn power_table(&self, menus: &[Rc<Menu<'a>>], price: &Price, limit: f64) -> Table {
        let mut weights: Vec<Vec<(usize, f64)>> = vec![Vec::new(); menus.len()];
        let mut worth = 0.0;
        for (places, multiplier) in &price.rows {
            worth += multiplier * limit;
            for (j, sample, weight) in self.schedule.parts(places) {
                weights[*j].push((*sample, multiplier * weight));
            }
        }
        let priced = menus
            .iter()
            .enumerate()
            .map(|(j, menu)| {
                let joint = &self.robot.joints[j];
                let load = Load::new(&joint.motion, joint.limits.torque_bandwidth);
                let (robot, catalog, scale) = (self.robot, self.catalog, self.total.scale[j]);
                let one = |item: &Item| priced(robot, catalog, joint, &load, item, scale, &weights[j]);
                menu.items.par_iter().map(one).collect()
            })
            .collect();
        Table { per_mass: 0.0, priced: Some(priced), offset: -worth }
    }

    /// A combination with all that is known of it.
    pub(super) fn combination(&mut self, found: &Found) -> Combination<'a> {
        let menus: Vec<Rc<Menu>> = (0..found.items.len()).map(|j| self.menu_of(j, &found.coordinates[j])).collect();
        let items: Vec<&Item> = menus.iter().zip(&found.items).map(|(m, i)| &m.items[*i]).collect();
        let own_ratios: Vec<f64> = items.iter().map(|i| i.design.evaluation.ratio).collect();
        let ratios = found.ratios.clone().unwrap_or(own_ratios);
        let draws = self.with_parts(&items, &found.coordinates, |parts| shared::draws(parts, &self.schedule, &ratios));
        let powers: Vec<&[f64]> = draws.iter().map(|draws| draws.power.as_slice()).collect();
        let open = self.robot.bus.voltage;
        let sag = self.robot.shared_resistance().and_then(|shared| power::sag(&self.schedule, &draws, (open, shared)));
        let limit = self.limit();
        let price = self.power.zip(limit).map(|(_, limit)| match self.solve(&items, &found.coordinates, limit) {
            Outcome::Solved(solved) => {
                let of_power = solved.price.rows.iter().filter(|(places, _)| places.drive.is_none());
                -of_power.map(|r| r.1).sum::<f64>()
            }
            Outcome::TooMuch { .. } => 0.0,
        });
        let mounts = self.loaded(&items, &found.coordinates);
        let designs: Vec<Design> = (0..items.len())
            .map(|j| {
                let mut design_of = items[j].design.clone();
                if ratios[j] != design_of.evaluation.ratio {
                    let prepared = self.prepare(&mounts[j], items[j]);
                    let objective = prepared.at_in_full(ratios[j]).objective(&self.robot.joints[j].objective);
                    let optimum = crate::design::program::Optimum {
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
        Combination {
            joints: designs,
            objective: found.value,
            lower_bound: found.lower,
            mass,
            peak_power: power::largest(&self.schedule, &powers).0,
            peak_power_by_case: power::by_case(&self.schedule, &powers),
            sag,
            power_price: price,
            distinct_motors: motors.len(),
            carried: carried_torque,
        }
    }

    fn menu_of(&mut self, joint: usize, coordinates: &[f64]) -> Rc<Menu<'a>> {
        match self.certain(joint) {
            Some(menu) => menu,
            None => self.menu(joint, coordinates).unwrap_or_default(),
        }
    }
}

/// Lightest and heaviest that a joint's actuator can be, whatever its load.
fn reach(joint: &Joint, catalog: &Catalog, menu: Option<&Menu>) -> (f64, f64) {
    let span =
        |masses: &mut dyn Iterator<Item = f64>| masses.fold((f64::INFINITY, 0.0_f64), |(a, b), m| (a.min(m), b.max(m)));
    if let Some(menu) = menu {
        let (least, most) = span(&mut menu.items.iter().map(|i| i.mass));
        return if least.is_finite() { (least, most) } else { (0.0, 0.0) };
    }
    let motor = span(&mut catalog.motors.iter().filter_map(|m| m.mass));
    let gear = match &joint.ratio {
        RatioChoice::Continuous { .. } | RatioChoice::Listed { .. } => {
            let at_the_ends = joint.ratio.range().map(|(min, max)| (joint.gear.mass_at(min), joint.gear.mass_at(max)));
            at_the_ends.map_or((0.0, 0.0), |(least, most)| (least.unwrap_or(0.0), most.unwrap_or(0.0)))
        }
        RatioChoice::Catalog { patterns, .. } => {
            let allowed =
                catalog.gears.iter().filter(|g| patterns.iter().any(|p| crate::catalog::matches_pattern(p, &g.id)));
            span(&mut allowed.filter_map(|g| g.mass))
        }
    };
    let heaviest = joint.limits.actuator_mass.map_or(motor.1 + gear.1, |limit| limit.min(motor.1 + gear.1));
    let sum = (motor.0 + gear.0, heaviest * (1.0 + 1e-6));
    if sum.0.is_finite() && sum.0 <= sum.1 { sum } else { (0.0, 0.0) }
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
    let gear = item.design.gear.and_then(|id| catalog.gears.iter().find(|g| g.id == id));
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
    let best = least_in_range(&|n: f64| scale * program.objective_at(n) + power(n), a, b);
    let (polynomial, _) = program.objective_cut(best);
    let mut sum: Convex = under(&polynomial, item.ratios, best).map(|c| c * scale);
    sum[1] += scale * program.objective_cut(b).1;
    for (k, weight) in weights {
        add(&mut sum, &under(&profile.at(*k, best).1, item.ratios, best), *weight);
    }
    let u = minimise(&sum, a * a, b * b);
    value(&sum, u) - 1e-13 * value(&sum.map(f64::abs), u)
}

impl<'a> Joints<'a> for Context<'a> {
    fn order(&self) -> &[usize] {
        &self.order
    }

    fn count(&self, joint: usize) -> f64 {
        f64::from(self.robot.joints[joint].count)
    }

    fn scale(&self, joint: usize) -> f64 {
        self.total.scale[joint]
    }

    fn coordinates(&self, joint: usize, masses: &[Option<f64>]) -> Vec<f64> {
        carry::coordinates(&self.robot.joints[joint], |i| masses[i].unwrap_or(0.0))
    }

    fn menu(&mut self, joint: usize, coordinates: &[f64]) -> Option<Rc<Menu<'a>>> {
        let key = (joint, coordinates.iter().map(|y| y.to_bits()).collect::<Vec<u64>>());
        if let Some(menu) = self.made.get(&key) {
            return Some(menu.clone());
        }
        let work = self.catalog.motors.len() * self.robot.joints[joint].motion.len();
        if self.made.len() >= MAX_MENUS.min(MENU_WORK / work.max(1)) {
            return None;
        }
        let loaded = carry::loaded(&self.robot.joints[joint], coordinates);
        let made = Rc::new(menu(self.robot, &loaded, self.catalog, self.needs[joint], self.stop));
        self.made.insert(key, made.clone());
        Some(made)
    }

    fn certain(&self, joint: usize) -> Option<Rc<Menu<'a>>> {
        self.certain[joint].clone()
    }

    fn bound(&self, joint: usize, masses: &[Option<f64>]) -> (f64, f64) {
        let Some(boxes) = &self.boxes[joint] else { return (0.0, 0.0) };
        let part = carry::reach(&self.robot.joints[joint], |i| self.masses(masses, i));
        (boxes.least(&part), self.reach[joint].0)
    }

    fn is_stopped(&self) -> bool {
        self.stop.now()
    }

    fn searched(&self, branches: usize, solved: usize) {
        (self.searched)(branches, solved);
    }

    fn is_costly(&self) -> bool {
        self.limit().is_some()
    }

    fn complete(&mut self, menus: &[Rc<Menu<'a>>], chosen: &[usize], coordinates: &[Vec<f64>]) -> Option<Completed> {
        let items: Vec<&Item> = menus.iter().zip(chosen).map(|(m, i)| &m.items[*i]).collect();
        let Some(limit) = self.limit() else {
            let sum = |of: &dyn Fn(&Item) -> f64| -> f64 {
                items.iter().zip(&self.total.scale).map(|(item, scale)| scale * of(item)).sum()
            };
            let value = sum(&|i| i.design.optimum.objective);
            return Some(Completed { ratios: None, value, lower: sum(&|i| i.lower) });
        };
        match self.solve(&items, coordinates, limit) {
            Outcome::Solved(s) => Some(Completed { ratios: Some(s.ratios), value: s.value, lower: s.lower }),
            Outcome::TooMuch { .. } => None,
        }
    }
}
