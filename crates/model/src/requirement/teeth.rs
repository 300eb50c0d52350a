//! Planetary gears by their teeth: which stages can be put together, and the ratios of all trains that a requirement allows
//! (`ratio = { stages, teeth }`).
//!
//! The one idea: a ratio of teeth is a fraction of whole numbers, so that two trains have one ratio or they do not; no rounding
//! decides it. Of each ratio the train with the fewest teeth is kept, and how many others there are.

use std::collections::BTreeMap;

use crate::input::{Problem, Range, Section, key};
use crate::units::RATIO;
use crate::words::number;

/// A simple planetary stage: ring held, sun in, carrier out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stage {
    /// Teeth of the sun.
    pub sun: u32,
    /// Teeth of the ring.
    pub ring: u32,
}

impl Stage {
    /// Its ratio, 1 + ring/sun.
    pub fn ratio(self) -> f64 {
        f64::from(self.sun + self.ring) / f64::from(self.sun)
    }

    /// Teeth of a planet.
    pub fn planet(self) -> u32 {
        self.ring.saturating_sub(self.sun) / 2
    }

    /// Whether so many equal planets fit between sun and ring and can be put in at equal distances.
    ///
    /// ```
    /// use gearwise_model::requirement::Stage;
    /// // 24/72 with planets of 24: 96/3 is whole, and they fit. 20/60: 80/3 is not.
    /// assert!(Stage { sun: 24, ring: 72 }.can_be_assembled(3));
    /// assert!(!Stage { sun: 20, ring: 60 }.can_be_assembled(3));
    /// ```
    pub fn can_be_assembled(self, planets: u32) -> bool {
        let Stage { sun, ring } = self;
        let even = ring > sun && (ring - sun).is_multiple_of(2) && (ring + sun).is_multiple_of(planets);
        // Neighbours do not touch: their centres are apart by more than two outer radii.
        let apart = f64::from(sun + self.planet()) * (std::f64::consts::PI / f64::from(planets)).sin();
        even && apart > f64::from(self.planet() + 2)
    }

    /// Teeth of sun and ring.
    fn teeth(self) -> u32 {
        self.sun + self.ring
    }
}

/// A gear of simple planetary stages, one behind another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Train {
    /// Its stages, the motor's first.
    pub stages: Vec<Stage>,
}

impl Train {
    /// Its ratio.
    pub fn ratio(&self) -> f64 {
        self.stages.iter().map(|stage| stage.ratio()).product()
    }

    /// All teeth of suns and rings.
    pub fn teeth(&self) -> u32 {
        self.stages.iter().map(|stage| stage.teeth()).sum()
    }
}

/// The gear of a listed ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct Toothed {
    /// The ratio.
    pub ratio: f64,
    /// Of the trains of this ratio that with the fewest teeth; of several the one that reduces most in its first stage.
    pub train: Train,
    /// How many other trains have the ratio.
    pub others: u64,
}

/// What a requirement says of the teeth of a gear, and what follows.
#[derive(Debug, Clone, PartialEq)]
pub struct Teeth {
    /// Smallest and largest ratio of each stage, the motor's first.
    pub stages: Vec<[f64; 2]>,
    /// Fewest and most teeth of a sun.
    pub sun: [u32; 2],
    /// Most teeth of a ring.
    pub ring_max: u32,
    /// Planets of each stage.
    pub planets: u32,
    /// The gears of the listed ratios, ascending.
    pub gears: Vec<Toothed>,
    /// How many ratios can be assembled; more than are listed where there would be too many.
    pub ratios: usize,
    /// Where not all are listed: each that is not is within this share of a listed one, which has no more teeth.
    pub within: Option<f64>,
}

impl Teeth {
    /// The gear of a ratio, but for rounding.
    pub fn of(&self, ratio: f64) -> Option<&Toothed> {
        self.gears.iter().find(|gear| (gear.ratio - ratio).abs() <= SAME * gear.ratio)
    }
}

/// A ratio may be off by this share of itself and is still the one that is meant.
pub(super) const SAME: f64 = 1e-9;
/// Most ratios that a list or a grid may have.
pub(super) const MOST_LISTED: usize = 1000;
/// Fewest teeth of a sun or a planet: below them not even a shifted profile has a sound root.
pub const LEAST_TEETH: u32 = 8;
/// Most teeth of a ring.
const MOST_TEETH: u32 = 400;
/// Most planets of a stage.
const MOST_PLANETS: u32 = 12;
/// Most stages.
const MOST_STAGES: usize = 3;
/// Most products of ratios that are looked at.
const MOST_PRODUCTS: usize = 2_000_000;

/// Why teeth make no list of ratios.
#[derive(Debug, Clone, PartialEq)]
pub enum NoTeeth {
    /// No stage of these ratios can be assembled: which stage, and the next ratios below and above that can.
    Stage(usize, [Option<Stage>; 2]),
    /// More products of ratios than are looked at.
    Many(usize),
}

/// A ratio as a fraction in its lowest terms.
type Fraction = (u64, u64);

fn lowest(num: u64, den: u64) -> Fraction {
    let (mut a, mut b) = (num, den);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    (num / a, den / a)
}

/// Of one ratio: the train with the fewest teeth and how many there are in all.
struct Alike {
    best: Vec<Stage>,
    teeth: u32,
    count: u64,
}

impl Alike {
    /// Takes in trains of the same ratio.
    fn join(&mut self, other: Alike) {
        // Of trains of as many teeth the one that reduces most at the motor.
        let first = |stages: &[Stage]| stages[0].ratio();
        if other.teeth < self.teeth || other.teeth == self.teeth && first(&other.best) > first(&self.best) {
            (self.best, self.teeth) = (other.best, other.teeth);
        }
        self.count += other.count;
    }
}

fn into_map(all: impl Iterator<Item = (Fraction, Alike)>) -> BTreeMap<Fraction, Alike> {
    let mut map: BTreeMap<Fraction, Alike> = BTreeMap::new();
    for (fraction, alike) in all {
        match map.get_mut(&fraction) {
            Some(known) => known.join(alike),
            None => {
                map.insert(fraction, alike);
            }
        }
    }
    map
}

/// Every train of stages whose ratios lie in ranges (both ends included), of suns and rings with certain teeth.
///
/// # Errors
/// A stage has none, or there are too many.
pub fn trains(stages: &[[f64; 2]], sun: [u32; 2], ring_max: u32, planets: u32) -> Result<Teeth, NoTeeth> {
    let rings = |sun: u32| (sun + 1..=ring_max).map(move |ring| Stage { sun, ring });
    let all: Vec<Stage> = (sun[0]..=sun[1])
        .flat_map(rings)
        .filter(|stage| stage.planet() >= LEAST_TEETH && stage.can_be_assembled(planets))
        .collect();
    let mut of_stages = Vec::with_capacity(stages.len());
    for (k, [min, max]) in stages.iter().enumerate() {
        let within = |stage: &&Stage| min * (1.0 - SAME) <= stage.ratio() && stage.ratio() <= max * (1.0 + SAME);
        let own = into_map(all.iter().filter(within).map(|stage| {
            let fraction = lowest(u64::from(stage.teeth()), u64::from(stage.sun));
            (fraction, Alike { best: vec![*stage], teeth: stage.teeth(), count: 1 })
        }));
        if own.is_empty() {
            let below = all.iter().filter(|stage| stage.ratio() < *min);
            let above = all.iter().filter(|stage| stage.ratio() > *max);
            let near = [
                below.max_by(|a, b| a.ratio().total_cmp(&b.ratio()).then(b.teeth().cmp(&a.teeth()))),
                above.min_by(|a, b| a.ratio().total_cmp(&b.ratio()).then(a.teeth().cmp(&b.teeth()))),
            ];
            return Err(NoTeeth::Stage(k, near.map(|stage| stage.copied())));
        }
        of_stages.push(own);
    }
    let mut of_stages = of_stages.into_iter();
    let mut found = of_stages.next().unwrap_or_default();
    for next in of_stages {
        let products = found.len().saturating_mul(next.len());
        if products > MOST_PRODUCTS {
            return Err(NoTeeth::Many(products));
        }
        found = into_map(found.iter().flat_map(|((num, den), before)| {
            next.iter().map(move |((n, d), stage)| {
                let best = before.best.iter().chain(&stage.best).copied().collect();
                let alike = Alike { best, teeth: before.teeth + stage.teeth, count: before.count * stage.count };
                (lowest(num * n, den * d), alike)
            })
        }));
    }
    let mut gears: Vec<Toothed> = found
        .into_iter()
        .map(|((num, den), alike)| Toothed {
            ratio: num as f64 / den as f64,
            train: Train { stages: alike.best },
            others: alike.count - 1,
        })
        .collect();
    gears.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let ratios = gears.len();
    let (gears, within) = if ratios > MOST_LISTED { thinned(gears) } else { (gears, None) };
    Ok(Teeth { stages: stages.to_vec(), sun, ring_max, planets, gears, ratios, within })
}

/// As many gears as may be listed: of those in each of many equal ratios of ratios the one with the fewest teeth. With the
/// share within which each of the others is of one that is kept.
fn thinned(gears: Vec<Toothed>) -> (Vec<Toothed>, Option<f64>) {
    let (Some(first), Some(last)) = (gears.first(), gears.last()) else { return (gears, None) };
    let (from, width) = (first.ratio.ln(), (last.ratio / first.ratio).ln() / MOST_LISTED as f64);
    let place = |gear: &Toothed| (((gear.ratio.ln() - from) / width) as usize).min(MOST_LISTED - 1);
    let mut kept: BTreeMap<usize, Toothed> = BTreeMap::new();
    for gear in gears {
        let place = place(&gear);
        match kept.get(&place) {
            Some(known) if known.train.teeth() <= gear.train.teeth() => {}
            _ => {
                kept.insert(place, gear);
            }
        }
    }
    (kept.into_values().collect(), Some(width.exp_m1() * (1.0 + SAME)))
}

/// Reads `stages` and `teeth` of a `ratio`; `None` with the mistakes noted.
pub(super) fn read(table: &Section, stages: Option<Vec<[f64; 2]>>, teeth: Option<Section>) -> Option<Teeth> {
    let wrong = |key: &'static str, message: String, label: &str, help: &str| {
        table.note(Problem::at(table.span_of(key), message, label).help(help.to_string()));
    };
    let other = ["min", "max", "step", "values"].into_iter().find(|other| table.has(*other));
    if let Some(other) = other {
        let message = format!("`stages` and `teeth` say the ratios: they have no `{other}`");
        wrong(other, message, "not with `stages`", "remove it; each stage has its own [least, most]");
    }
    if !table.has("stages") {
        table.missing("stages", "[[3, 10], [3, 10]]");
    }
    if !table.has("teeth") {
        table.missing("teeth", "{ sun = [18, 40], ring_max = 120, planets = 3 }");
    }
    let teeth = teeth.and_then(read_teeth);
    let stages = stages?;
    if stages.is_empty() || stages.len() > MOST_STAGES {
        let message = format!("`stages` lists {} stages", stages.len());
        wrong("stages", message, &format!("expected 1 to {MOST_STAGES}"), "give each stage its [least, most] ratio");
        return None;
    }
    for (k, [min, max]) in stages.iter().enumerate() {
        if min > max {
            let message = format!("the ratios of stage {} are upside down: {min} to {max}", k + 1);
            wrong("stages", message, "the first is more than the second", "swap the two");
            return None;
        }
    }
    let Bounds { sun, ring_max, planets } = teeth?;
    if other.is_some() {
        return None;
    }
    match trains(&stages, sun, ring_max, planets) {
        Ok(teeth) => Some(teeth),
        Err(NoTeeth::Stage(k, near)) => {
            let [min, max] = stages[k];
            let message = format!(
                "no planetary stage of these teeth with a ratio from {min} to {max} can be assembled (stage {})",
                k + 1
            );
            let named = |stage: &Stage| format!("{} (sun {}, ring {})", number(stage.ratio()), stage.sun, stage.ring);
            let near: Vec<String> = near.iter().flatten().map(named).collect();
            let help = match near.is_empty() {
                true => "no stage at all can be: allow other suns, a larger `ring_max` or fewer planets".to_string(),
                false => format!("the nearest that can be: {}", near.join(" and ")),
            };
            wrong("stages", message, "sun + ring must divide by the planets, and these must not touch", &help);
            None
        }
        Err(NoTeeth::Many(products)) => {
            let message = format!("these stages and teeth make {products} products of ratios");
            let help = "give the stages narrower ratios, or `sun` and `ring_max` fewer teeth";
            wrong("stages", message, &format!("at most {MOST_PRODUCTS}"), help);
            None
        }
    }
}

/// What teeth gears may have.
struct Bounds {
    sun: [u32; 2],
    ring_max: u32,
    planets: u32,
}

fn read_teeth(table: Section) -> Option<Bounds> {
    let sun = table.number_list(key("sun", "fewest and most teeth of a sun, `[18, 40]`").required(), Range::Positive);
    let ring_max = table.count(key("ring_max", "most teeth of a ring").required());
    let planets = table.count(key("planets", "planets of each stage, equal and at equal distances").default("3"));
    if !table.has("sun") {
        table.missing("sun", "[18, 40]");
    }
    if !table.has("ring_max") {
        table.missing("ring_max", "120");
    }
    let noted = table.noted();
    let wrong = |key: &'static str, message: String, label: String, help: &str| {
        table.note(Problem::at(table.span_of(key), message, label).help(help.to_string()));
    };
    let sun = sun.and_then(|sun| match sun.as_slice() {
        [least, most] if least.fract() == 0.0 && most.fract() == 0.0 && most.max(*least) <= f64::from(MOST_TEETH) => {
            let (least, most) = (*least as u32, *most as u32);
            if least > most {
                let message = format!("the teeth of the sun are upside down: {least} to {most}");
                wrong("sun", message, "the first is more than the second".into(), "swap the two");
            } else if least < LEAST_TEETH {
                let message = format!("a sun of {least} teeth is not one that can be made well");
                let help = "below 17 teeth the root is undercut unless the profile is shifted; 18 need no shift";
                wrong("sun", message, format!("expected at least {LEAST_TEETH}"), help);
            }
            Some([least, most])
        }
        _ => {
            let label = format!("expected two whole numbers up to {MOST_TEETH}");
            wrong("sun", "`sun` is not a pair [fewest, most]".into(), label, "for example sun = [18, 40]");
            None
        }
    });
    if let (Some(ring), Some([least, _])) = (ring_max, sun) {
        // A planet has at least its teeth.
        if ring < least + 2 * LEAST_TEETH {
            let message = format!("a ring of at most {ring} teeth has no room for a sun of {least} and planets");
            wrong(
                "ring_max",
                message,
                format!("expected at least {}", least + 2 * LEAST_TEETH),
                "the ring has the teeth of the sun and twice those of a planet",
            );
        } else if ring > MOST_TEETH {
            let message = format!("a ring of up to {ring} teeth is beyond what is listed");
            wrong("ring_max", message, format!("at most {MOST_TEETH}"), "give fewer");
        }
    }
    if let Some(planets) = planets.filter(|planets| !(2..=MOST_PLANETS).contains(planets)) {
        let message = format!("a stage of {planets} planets");
        wrong("planets", message, format!("expected 2 to {MOST_PLANETS}"), "three are usual");
    }
    let is_wrong = table.noted() > noted || table.has("planets") && planets.is_none();
    table.finish();
    let bounds = Bounds { sun: sun?, ring_max: ring_max?, planets: planets.unwrap_or(3) };
    (!is_wrong).then_some(bounds)
}

/// The stages as a requirement gives them.
pub(super) fn read_stages(table: &Section) -> Option<Vec<[f64; 2]>> {
    let stages = key("stages", "smallest and largest ratio of each planetary stage, the motor's first; with `teeth`")
        .value("list of pairs, as `[[3, 10], [3, 10]]`")
        .or("min");
    table.pairs(stages, [(&RATIO, Range::AtLeastOne); 2])
}
