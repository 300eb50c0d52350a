//! Worst end of each tolerance for a limit, and proof of a limit over the whole box.
//!
//! The one idea: a limit's excess over its bound is evaluated in interval arithmetic with derivatives. Where it is monotone in a number,
//! that number is at its worse end; where it is convex, at one of its ends; where neither is shown, the box is divided. A limit is proven
//! where every part of the box is below the bound, and a place that is above becomes a corner of its own. Nothing is proven of a limit whose
//! equations are not stated here, or do not agree with the program's.

use std::collections::BTreeMap;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::chance::uniform;
use super::corners::{Corner, Toleranced};
use super::derivative::{Along, Interval, Number};
use super::equations::{Equations, Reading};
use crate::Prepared;
use crate::evaluate::{FEASIBILITY_TOLERANCE, Margin};
use gearwise_model::actuator::limits::{Asked, Demand};
use gearwise_model::numerics::work;

/// Most parts into which the box is divided for one limit.
const PARTS: usize = 20_000;

/// Most corners of a limit that is convex in its samples together.
const MOST_CORNERS: usize = 1024;

/// Number of samples that decide which end of a tolerance is the worst. The proof examines all.
const LOOKS: usize = 2048;

/// Number of places of the box that are tried for a limit that is not proven.
const PLACES: usize = 48;

/// The smallest margin of each limit at a place of the box.
pub type Margins = BTreeMap<&'static str, Margin>;

/// The smallest margin of each of some limits at a place of the box and a ratio.
pub type MarginsAt<'b> = dyn Fn(&[f64], f64, &[&str]) -> Margins + 'b;

/// The box of a motor's tolerances, as proofs look at it.
pub struct Region<'b, 'p> {
    /// The printed numbers.
    pub nominal: &'b Prepared<'p>,
    /// Corners that were looked at.
    pub corners: &'b [(Prepared<'p>, &'p Corner)],
    /// The smallest margin of each of some limits at a place of the box and a ratio.
    pub margins: &'b MarginsAt<'b>,
}

impl Region<'_, '_> {
    /// True of a corner that equations are compared with the program at: of all combinations of ends those with at most one
    /// tolerance at another end than the others, and places that break a limit.
    fn tells(&self, corner: &Corner) -> bool {
        let moves = |i: usize| self.corners.iter().any(|(_, other)| other.at[i] != self.corners[0].1.at[i]);
        let (mut low, mut high) = (0, 0);
        for i in (0..corner.at.len()).filter(|i| moves(*i)) {
            (low, high) = (low + usize::from(corner.at[i] != 1.0), high + usize::from(corner.at[i] == 1.0));
        }
        corner.found_for.is_some() || low.min(high) <= 1
    }

    /// The smallest margin of a limit; `None` where it does not apply there.
    fn margin_at(&self, at: &[f64], limit: &str, ratio: f64) -> Option<Margin> {
        (self.margins)(at, ratio, &[limit]).get(limit).copied()
    }
}

/// The smallest margin of each limit, and where that is.
type Worst = BTreeMap<&'static str, (Margin, Vec<f64>)>;

/// Behaviour of the limits along the tolerances, between two ratios.
pub struct Directions {
    of: BTreeMap<&'static str, Vec<Along>>,
}

/// Both behaviours in one.
fn joined(a: Along, b: Along) -> Along {
    match (a, b) {
        (Along::Constant, other) | (other, Along::Constant) => other,
        (a, b) if a == b => a,
        _ => Along::Unknown,
    }
}

impl Directions {
    /// Behaviour of the limits of a candidate; `margins` evaluates all limits at a place of the box, for limits without stated equations.
    pub fn new(
        nominal: &Prepared,
        all: &[Toleranced],
        range: (f64, f64),
        margins: &dyn Fn(&[f64]) -> Margins,
    ) -> Directions {
        let equations = Equations { candidate: &nominal.candidate, all };
        let ratio = Number::between([range.0, range.1]);
        let over = vec![[0.0, 1.0]; all.len()];
        let mut of: BTreeMap<&'static str, Vec<Along>> = BTreeMap::new();
        let mut unstated = false;
        for asked in &nominal.asked {
            let found = directions(&equations, asked, &ratio, &over);
            unstated |= found.is_none();
            let found = found.unwrap_or_else(|| vec![Along::Unknown; all.len()]);
            let known = of.entry(asked.limit.name).or_insert_with(|| vec![Along::Constant; all.len()]);
            known.iter_mut().zip(found).for_each(|(known, new)| *known = joined(*known, new));
        }
        let mut directions = Directions { of };
        if unstated {
            directions.try_ends(nominal, all, margins);
        }
        directions
    }

    /// Try both ends of one tolerance after the other where the equations show nothing. This guides the search and proves nothing.
    fn try_ends(&mut self, nominal: &Prepared, all: &[Toleranced], margins: &dyn Fn(&[f64]) -> Margins) {
        let middle: Vec<f64> = all.iter().map(Toleranced::nominal).collect();
        let printed = margins(&middle);
        for i in 0..all.len() {
            let at = |share: f64| {
                let mut place = middle.clone();
                place[i] = share;
                margins(&place)
            };
            let (low, high) = (at(0.0), at(1.0));
            for asked in &nominal.asked {
                let name = asked.limit.name;
                let Some(along) = self.of.get_mut(name).map(|of| &mut of[i]).filter(|a| **a == Along::Unknown) else {
                    continue;
                };
                let of = |margins: &Margins| margins.get(name).map(|m| m.margin);
                let (Some(low), Some(middle), Some(high)) = (of(&low), of(&printed), of(&high)) else { continue };
                match () {
                    () if low == middle && middle == high => *along = Along::Constant,
                    () if low >= middle && middle >= high => *along = Along::Rising,
                    () if low <= middle && middle <= high => *along = Along::Falling,
                    () => {}
                }
            }
        }
    }

    /// Behaviour of all limits together along a tolerance.
    pub fn of_all(&self, place: usize) -> Along {
        self.of.values().map(|of| of[place]).fold(Along::Constant, joined)
    }

    /// True if a limit needs a place of the box: the worse end of each free tolerance, where that is known.
    pub fn needs(&self, limit: &str, at: &[f64], free: &[bool]) -> bool {
        let Some(of) = self.of.get(limit) else { return true };
        of.iter().zip(at).zip(free).all(|((along, share), free)| match along {
            _ if !free => true,
            Along::Constant | Along::Falling => *share == 0.0,
            Along::Rising => *share == 1.0,
            Along::Convex | Along::Unknown => true,
        })
    }
}

/// Behaviour of a limit along each tolerance; `None` where its equations are not stated.
fn directions(equations: &Equations, asked: &Asked, ratio: &Number, over: &[Interval]) -> Option<Vec<Along>> {
    let mut found = vec![Along::Constant; over.len()];
    for reading in 0..equations.readings() {
        let machine = equations.machine(asked.end, Reading::Nth(reading), over, true)?;
        let mut add = |number: &Number| {
            for (i, along) in found.iter_mut().enumerate() {
                *along = joined(*along, number.along(i));
            }
        };
        match asked.demand {
            Demand::WindingPeak(_) | Demand::MeanCurrentSquared(_) => {
                equations.heats(asked, &machine, ratio)?.iter().for_each(&mut add);
            }
            _ => {
                let count = equations.samples(asked);
                for sample in (0..count).step_by(count.div_ceil(LOOKS).max(1)) {
                    add(&equations.compared(asked, &machine, sample, ratio, over, true)?.excess());
                }
            }
        }
    }
    if matches!(asked.demand, Demand::WindingPeak(_)) {
        for (i, of) in equations.all.iter().enumerate() {
            if of.column == "max_winding_temperature" {
                found[i] = joined(found[i], Along::Falling);
            }
        }
    }
    Some(found)
}

/// Result of the proof of a limit over the box.
enum Found {
    /// Kept everywhere.
    Proven,
    /// Exceeded at a place of the box.
    Exceeded(Vec<f64>),
    /// Neither.
    Open,
}

/// Result of the proofs of all limits over the box at a ratio.
#[derive(Default)]
pub struct Verified {
    /// Places at which a limit is exceeded, with its name.
    pub exceeded: Vec<(Vec<f64>, &'static str)>,
    /// The limits that are not proven, in the order of the model.
    pub unproven: Vec<&'static str>,
    /// The smallest margin that was found of what is not proven.
    pub worst: Option<Margin>,
}

impl Verified {
    /// Records that a limit is not proven.
    pub fn leave_open(&mut self, limit: &'static str) {
        if !self.unproven.contains(&limit) {
            self.unproven.push(limit);
        }
    }
}

/// Examines every limit that is wanted over the whole box at a ratio.
pub fn verify(boxed: &Region, all: &[Toleranced], ratio: f64, is_wanted: &dyn Fn(&str) -> bool) -> Verified {
    let nominal = boxed.nominal;
    let equations = Equations { candidate: &nominal.candidate, all };
    let mut verified = Verified::default();
    for asked in nominal.asked.iter().filter(|asked| is_wanted(asked.limit.name)) {
        let name = asked.limit.name;
        match look(boxed, &equations, asked, ratio) {
            Found::Proven => {}
            // The program has to confirm what the equations show.
            Found::Exceeded(at)
                if boxed.margin_at(&at, name, ratio).is_some_and(|m| m.margin < -FEASIBILITY_TOLERANCE) =>
            {
                verified.exceeded.push((at, name));
            }
            Found::Exceeded(_) | Found::Open => verified.leave_open(name),
        }
    }
    // A limit that applies to some motors of the box alone.
    for (corner, _) in boxed.corners {
        for asked in &corner.asked {
            if nominal.asked.iter().all(|other| other.limit.name != asked.limit.name) {
                verified.leave_open(asked.limit.name);
            }
        }
    }
    if verified.exceeded.is_empty() && !verified.unproven.is_empty() {
        search(boxed, all, ratio, &mut verified);
    }
    verified
}

/// Try places of the box for the limits that are not proven: at random, and from the worst of them one tolerance after the other.
fn search(boxed: &Region, all: &[Toleranced], ratio: f64, verified: &mut Verified) {
    let mut generator = Pcg64::seed_from_u64(0x0b0f);
    let mut worst: Worst = BTreeMap::new();
    let unproven = verified.unproven.clone();
    let look = |at: Vec<f64>, worst: &mut Worst| {
        if work::is_spent() {
            return;
        }
        let margins = (boxed.margins)(&at, ratio, &unproven);
        for name in &unproven {
            let Some(margin) = margins.get(name).copied() else { continue };
            if worst.get(name).is_none_or(|(least, _)| margin.margin < least.margin) {
                worst.insert(name, (margin, at.clone()));
            }
        }
    };
    look(all.iter().map(Toleranced::nominal).collect(), &mut worst);
    for (_, corner) in boxed.corners.iter().take(PLACES) {
        look(corner.at.clone(), &mut worst);
    }
    for k in 0..PLACES {
        // Inside, on faces and at corners.
        let stretch = f64::from(1 + k as u32 % 3);
        let at = all.iter().map(|_| (0.5 + (uniform(&mut generator) - 0.5) * stretch).clamp(0.0, 1.0)).collect();
        look(at, &mut worst);
    }
    for _ in 0..2 {
        for i in 0..all.len() {
            let from: Vec<Vec<f64>> = worst.values().map(|(_, at)| at.clone()).collect();
            for at in from {
                for end in [0.0, 1.0] {
                    let mut place = at.clone();
                    if place[i] != end {
                        place[i] = end;
                        look(place, &mut worst);
                    }
                }
            }
        }
    }
    for (name, (margin, at)) in worst {
        if margin.margin < -FEASIBILITY_TOLERANCE {
            verified.exceeded.push((at, name));
        }
        if verified.worst.is_none_or(|least| margin.margin < least.margin) {
            verified.worst = Some(margin);
        }
    }
}

fn look(boxed: &Region, equations: &Equations, asked: &Asked, ratio: f64) -> Found {
    let nominal = boxed.nominal;
    if work::is_spent() {
        return Found::Open;
    }
    match asked.demand {
        Demand::WindingPeak(_) | Demand::MeanCurrentSquared(_) => together(boxed, equations, asked, ratio),
        _ => {
            let middle: Vec<f64> = equations.all.iter().map(Toleranced::nominal).collect();
            if !equations.agrees(asked, &middle, (&nominal.candidate, asked), ratio) {
                return Found::Open;
            }
            let agree = boxed.corners.iter().filter(|(_, corner)| boxed.tells(corner)).all(|(prepared, corner)| {
                let same = |other: &&Asked| other.limit.name == asked.limit.name && other.end == asked.end;
                let there = prepared.asked.iter().find(same);
                there.is_some_and(|there| equations.agrees(asked, &corner.at, (&prepared.candidate, there), ratio))
            });
            if agree { each(equations, asked, ratio) } else { Found::Open }
        }
    }
}

/// A limit that rises with the heat of each sample and is convex in all of them: at each tolerance it is monotone or convex where the heat
/// of all samples is, and the corners that this leaves are evaluated by the program.
fn together(boxed: &Region, equations: &Equations, asked: &Asked, ratio: f64) -> Found {
    let over = vec![[0.0, 1.0]; equations.all.len()];
    let n = Number::constant(ratio);
    let Some(mut along) = directions(equations, asked, &n, &over) else { return Found::Open };
    for reading in 0..equations.readings() {
        let machine = equations.machine(asked.end, Reading::Nth(reading), &over, true);
        let Some(heats) = machine.and_then(|machine| equations.heats(asked, &machine, &n)) else { return Found::Open };
        for (i, along) in along.iter_mut().enumerate().filter(|(_, along)| **along == Along::Unknown) {
            if heats.iter().all(|heat| heat.is_convex(i)) {
                *along = Along::Convex;
            }
        }
    }
    let free: Vec<usize> = (0..along.len()).filter(|i| along[*i] == Along::Convex).collect();
    if along.contains(&Along::Unknown) || 1_usize << free.len().min(20) > MOST_CORNERS {
        return Found::Open;
    }
    for bits in 0..1_usize << free.len() {
        if work::is_spent() {
            return Found::Open;
        }
        let at: Vec<f64> = (0..along.len())
            .map(|i| match along[i] {
                Along::Constant => equations.all[i].nominal(),
                Along::Rising => 1.0,
                Along::Falling => 0.0,
                _ => free.iter().position(|f| *f == i).map_or(0.0, |place| f64::from((bits >> place & 1) as u32)),
            })
            .collect();
        match boxed.margin_at(&at, asked.limit.name, ratio) {
            None => return Found::Open,
            Some(margin) if margin.margin < -FEASIBILITY_TOLERANCE => return Found::Exceeded(at),
            Some(_) => {}
        }
    }
    Found::Proven
}

/// A limit of which each sample is compared by itself.
fn each(equations: &Equations, asked: &Asked, ratio: f64) -> Found {
    let n = Number::constant(ratio);
    let mut parts = 0;
    for reading in 0..equations.readings() {
        let whole: (Vec<Interval>, Vec<usize>) =
            (vec![[0.0, 1.0]; equations.all.len()], (0..equations.samples(asked)).collect());
        let mut left = vec![whole];
        while let Some((mut over, samples)) = left.pop() {
            parts += 1;
            if parts > PARTS || work::is_spent() {
                return Found::Open;
            }
            let Some(plain) = equations.machine(asked.end, Reading::Nth(reading), &over, false) else {
                return Found::Open;
            };
            // Samples that bounds alone decide need no derivatives.
            let mut open = Vec::new();
            for sample in samples {
                let Some(both) = equations.compared(asked, &plain, sample, &n, &over, false) else {
                    return Found::Open;
                };
                let most = both.excess().value[1];
                let size =
                    both.bound.value[1].abs().max(1e-9 * both.demand.value[0].abs().max(both.demand.value[1].abs()));
                let share = if both.is_squared { 2.0 } else { 1.0 } * FEASIBILITY_TOLERANCE;
                // A number that is none is not below.
                if most > share * size || most.is_nan() {
                    open.push(sample);
                }
            }
            if open.is_empty() {
                continue;
            }
            if over.iter().all(|[low, high]| low == high) {
                return Found::Exceeded(over.iter().map(|[low, _]| *low).collect());
            }
            let machine =
                equations.machine(asked.end, Reading::Nth(reading), &over, true).expect("as without derivatives");
            let excess: Option<Vec<Number>> = open
                .iter()
                .map(|sample| Some(equations.compared(asked, &machine, *sample, &n, &over, true)?.excess()))
                .collect();
            let Some(excess) = excess else { return Found::Open };
            let along = |i: usize| excess.iter().map(|e| e.along(i)).fold(Along::Constant, joined);
            let wide: Vec<usize> = (0..over.len()).filter(|i| over[*i][0] < over[*i][1]).collect();
            let mut moved = false;
            for i in &wide {
                let end = match along(*i) {
                    Along::Constant | Along::Falling => over[*i][0],
                    Along::Rising => over[*i][1],
                    Along::Convex | Along::Unknown => continue,
                };
                (over[*i], moved) = ([end; 2], true);
            }
            if moved {
                left.push((over, open));
                continue;
            }
            // Samples that ask for different ends go their own ways.
            let alone = |i: usize| excess.iter().any(|e| !matches!(e.along(i), Along::Convex | Along::Unknown));
            if open.len() > 1 && wide.iter().any(|i| along(*i) == Along::Unknown && alone(*i)) && open.len() <= 64 {
                left.extend(open.iter().map(|sample| (over.clone(), vec![*sample])));
                continue;
            }
            let influence = |i: &usize| {
                let slope = |e: &Number| {
                    let [low, high] = e.slope(*i);
                    low.abs().max(high.abs())
                };
                excess.iter().map(slope).fold(0.0, f64::max) * (over[*i][1] - over[*i][0])
            };
            let convex = wide.iter().copied().find(|i| excess.iter().all(|e| e.is_convex(*i)));
            let widest = wide.iter().copied().max_by(|a, b| influence(a).total_cmp(&influence(b)));
            let (i, ends) = match (convex, widest) {
                (Some(i), _) => (i, over[i].map(|end| [end; 2])),
                (None, Some(i)) => {
                    let [low, high] = over[i];
                    let middle = 0.5 * (low + high);
                    if middle <= low || middle >= high {
                        return Found::Open;
                    }
                    (i, [[low, middle], [middle, high]])
                }
                (None, None) => return Found::Open,
            };
            for part in ends.into_iter().rev() {
                let mut over = over.clone();
                over[i] = part;
                left.push((over, open.clone()));
            }
        }
    }
    Found::Proven
}
