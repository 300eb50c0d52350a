//! What a row lacks, estimated from rows that are built alike.
//!
//! The one idea: heat, rotor inertia and electrical time constant of motors of one construction follow their mass (and
//! diameter) closely enough for a first choice. A [`Law`] is a regression over the rows that have the number, one point
//! for each motor (windings of one motor are one). It gives a prediction interval, of which the pessimistic end is used.
//! A law is shipped only if it predicts the rows of motors that it was not made from: at most 10 % of them may be off by
//! more than a factor of two (leave one motor out). Where no row of a construction has the number, the law of all others
//! stands in, if each construction is told by the others as well; its end is then that factor of two.

use std::sync::OnceLock;

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::thermal;
use crate::catalog::convention::Commutation;
use crate::catalog::drag::Drag;
use crate::catalog::estimate::{Estimate, Estimated};
use crate::catalog::module::Depth;
use crate::catalog::{About, Catalog, Construction, Motor};

/// Highest winding temperature where neither row nor requirement gives one \[K\]: 100 °C, assumed.
pub const ASSUMED_WINDING_TEMPERATURE: f64 = 373.15;

/// Highest winding temperature that a maker may have had in mind for a continuous current whose row gives none \[K\]:
/// 155 °C, class F, the highest of any row. A thermal resistance that is told from such a current is an upper bound then.
const HIGHEST_RATED_TEMPERATURE: f64 = 428.15;

/// Surroundings that ratings refer to \[K\]: 25 °C.
const RATED_AMBIENT: f64 = 298.15;

/// One-sided probability of the prediction interval.
const PROBABILITY: f64 = 0.9;

/// A prediction that is off by more than this factor is a miss.
pub const MISS: f64 = 2.0;

/// Largest share of misses of a law that is shipped.
pub const LARGEST_SHARE: f64 = 0.1;

/// Fewest motors that a law is made from.
const FEWEST: usize = 8;

/// A mass this many times outside the range of the rows is not asked of a law.
const BEYOND: f64 = 1.5;

/// A regression over the motors of one construction: `ln y = a + b ln m`, or `ln y = a`.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    /// What it estimates.
    pub of: Estimated,
    /// Of which motors.
    pub construction: Construction,
    line: Line,
    /// Least and largest mass of the motors that it is made from \[kg\].
    pub masses: (f64, f64),
    /// Motors that it is made from, windings of one counted once.
    pub motors: usize,
    /// Rows that it is made from.
    pub rows: usize,
    /// Of these, rows that the law of all other motors misses by more than a factor of [`MISS`]; of a law of other
    /// constructions, those that the law of all constructions but their own misses.
    pub misses: usize,
    /// Whether it is made from motors of other constructions, because too few of this one say the number.
    pub of_others: bool,
}

/// A straight line through points, with what its scatter says of the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    intercept: f64,
    slope: f64,
    points: f64,
    freedom: f64,
    deviation: f64,
    mean: f64,
    spread: f64,
}

impl Line {
    /// Through points (x, y); level where `sloped` is not.
    fn through(points: &[(f64, f64)], sloped: bool) -> Line {
        let n = points.len() as f64;
        let mean = points.iter().map(|p| p.0).sum::<f64>() / n;
        let level = points.iter().map(|p| p.1).sum::<f64>() / n;
        let spread: f64 = points.iter().map(|p| (p.0 - mean).powi(2)).sum();
        let slope = match sloped && spread > 0.0 {
            true => points.iter().map(|p| (p.0 - mean) * (p.1 - level)).sum::<f64>() / spread,
            false => 0.0,
        };
        let intercept = level - slope * mean;
        let freedom = (n - if sloped { 2.0 } else { 1.0 }).max(1.0);
        let squares: f64 = points.iter().map(|p| (p.1 - intercept - slope * p.0).powi(2)).sum();
        let spread = if sloped { spread } else { f64::INFINITY };
        Line { intercept, slope, points: n, freedom, deviation: (squares / freedom).sqrt(), mean, spread }
    }

    fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }

    /// How far the next point may lie above the line, one-sided.
    fn reach(&self, x: f64) -> f64 {
        let quantile = StudentsT::new(0.0, 1.0, self.freedom).map_or(f64::NAN, |d| d.inverse_cdf(PROBABILITY));
        let beside = (x - self.mean).powi(2) / self.spread;
        quantile * self.deviation * (1.0 + 1.0 / self.points + beside).sqrt()
    }
}

/// What a motor has of a quantity, freed of its size where a law of physics says how: `y`, and the factor from `y` to the
/// quantity. `None` of the first where the row lacks it.
fn reduced(of: Estimated, motor: &Motor) -> Option<(Option<f64>, f64)> {
    let mass = motor.mass?;
    match of {
        Estimated::ThermalResistance => Some((witnessed_resistance(motor, ASSUMED_WINDING_TEMPERATURE), 1.0)),
        Estimated::RotorInertia => {
            // A rotor is some share of the motor's mass at some share of its radius.
            let factor = mass * motor.sheet.outer_diameter?.value.powi(2);
            Some((motor.rotor_inertia.map(|j| j / factor), factor))
        }
        Estimated::Inductance => Some((motor.inductance.map(|l| l / motor.resistance), motor.resistance)),
        Estimated::Drag => {
            // Iron that makes torque makes hysteresis. Brushes rub otherwise.
            let constant = motor.torque_constant / motor.resistance.sqrt();
            let is_brushless = motor.conventions.commutation == Commutation::Brushless;
            is_brushless.then(|| (motor.no_load_torque.map(|t| t / constant), constant))
        }
    }
}

/// Thermal resistance from winding to ambient \[K/W\] as a row says it: its thermal resistances; else what the lesser of its
/// continuous current and torque leads to, at the row's highest temperature or at `hottest` \[K\].
fn witnessed_resistance(motor: &Motor, hottest: f64) -> Option<f64> {
    let hottest = motor.max_winding_temperature.unwrap_or(hottest);
    let of_current = |current: f64| {
        // What `allowed_current_squared` inverts.
        let one = thermal::allowed_current_squared(
            hottest,
            motor.resistance,
            motor.reference_temperature,
            1.0,
            RATED_AMBIENT,
        );
        one / current.powi(2)
    };
    let rated = [
        motor.continuous_current.map(of_current),
        motor.continuous_torque.map(|torque| of_current(torque / motor.torque_constant)),
    ];
    motor.thermal_resistance.or(rated.into_iter().flatten().reduce(f64::max))
}

/// Whether a row gives any witness of heat.
fn tells_heat(motor: &Motor) -> bool {
    motor.thermal_resistance.is_some() || motor.continuous_current.is_some() || motor.continuous_torque.is_some()
}

/// A point of a regression: which motor it is of, ln mass, ln y.
type Point<'m> = (MotorKey<'m>, f64, f64);

/// What windings of one motor have in common: maker, mass and outer diameter.
type MotorKey<'m> = (&'m str, u64, Option<u64>);

/// One point for each motor: the mean over its windings.
fn per_motor(points: &[Point]) -> Vec<(f64, f64)> {
    let mut motors: Vec<MotorKey> = points.iter().map(|p| p.0).collect();
    motors.dedup();
    let mean = |motor: &MotorKey| {
        let own: Vec<&Point> = points.iter().filter(|p| p.0 == *motor).collect();
        let n = own.len() as f64;
        (own.iter().map(|p| p.1).sum::<f64>() / n, own.iter().map(|p| p.2).sum::<f64>() / n)
    };
    motors.iter().map(mean).collect()
}

impl Law {
    /// The law of a quantity over the motors of a construction; `None` where too few have it.
    pub fn over(of: Estimated, construction: Construction, motors: &[Motor]) -> Option<Law> {
        let points = points(of, motors, |c| c == construction);
        let sloped = is_sloped(of);
        let all = per_motor(&points);
        if all.len() < FEWEST {
            return None;
        }
        let missed = |point: &&Point| {
            let others: Vec<Point> = points.iter().filter(|p| p.0 != point.0).copied().collect();
            (point.2 - Line::through(&per_motor(&others), sloped).at(point.1)).abs() > MISS.ln()
        };
        let masses = all.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.0.exp()), b.max(p.0.exp())));
        Some(Law {
            of,
            construction,
            line: Line::through(&all, sloped),
            masses,
            motors: all.len(),
            rows: points.len(),
            misses: points.iter().filter(missed).count(),
            of_others: false,
        })
    }

    /// The law of a quantity for a construction over the motors of all others, where it has no size in it; `None` where
    /// fewer than two others have enough motors.
    pub fn over_others(of: Estimated, construction: Construction, motors: &[Motor]) -> Option<Law> {
        if is_sloped(of) {
            return None;
        }
        let groups: Vec<Vec<Point>> = Construction::NAMES
            .iter()
            .filter(|(_, other)| *other != construction)
            .map(|(_, other)| points(of, motors, |c| c == *other))
            .filter(|points| per_motor(points).len() >= FEWEST)
            .collect();
        if groups.len() < 2 {
            return None;
        }
        let missed_of = |k: usize| {
            let others: Vec<Point> =
                groups.iter().enumerate().filter(|(j, _)| *j != k).flat_map(|g| g.1).copied().collect();
            let line = Line::through(&per_motor(&others), false);
            groups[k].iter().filter(|point| (point.2 - line.at(point.1)).abs() > MISS.ln()).count()
        };
        let misses = (0..groups.len()).map(missed_of).sum();
        let all = per_motor(&groups.concat());
        Some(Law {
            of,
            construction,
            line: Line::through(&all, false),
            masses: (0.0, f64::INFINITY),
            motors: all.len(),
            rows: groups.iter().map(Vec::len).sum(),
            misses,
            of_others: true,
        })
    }

    /// Share of the rows that the law of all other motors misses.
    pub fn share_of_misses(&self) -> f64 {
        self.misses as f64 / self.rows as f64
    }

    /// Whether it predicts well enough to be used.
    pub fn is_shipped(&self) -> bool {
        self.share_of_misses() <= LARGEST_SHARE
    }

    /// The law in words, of what the model computes with.
    pub fn formula(&self) -> String {
        let number = |x: f64| crate::words::number(x);
        let (a, b) = (number(self.line.intercept.exp()), number(self.line.slope));
        match self.of {
            Estimated::ThermalResistance => format!("R_th = {a} K/W · (m/kg)^{b}"),
            Estimated::RotorInertia => format!("J_m = {a} · m D²"),
            Estimated::Inductance => format!("L/R = {a} s · (m/kg)^{b}"),
            Estimated::Drag => format!("T_0 = {a} √W · K_M"),
        }
    }

    /// By what factor one motor in six or so lies above the law, and as many below: one standard deviation.
    pub fn scatter(&self) -> f64 {
        self.line.deviation.exp()
    }

    /// The estimate for a motor; `None` where it is not of this construction, too far from the rows, or its row lacks what
    /// the law needs.
    pub fn estimate(&self, motor: &Motor) -> Option<Estimate> {
        let mass = motor.mass.filter(|m| *m > 0.0 && self.masses.0 / BEYOND <= *m && *m <= self.masses.1 * BEYOND)?;
        if motor.about.construction != Some(self.construction) {
            return None;
        }
        let (_, factor) = reduced(self.of, motor)?;
        let x = mass.ln();
        let middle = self.line.at(x).exp() * factor;
        // More of each is worse: hotter, slower, less voltage left. Of motors built otherwise the scatter says too little.
        let value = middle * if self.of_others { MISS } else { self.line.reach(x).exp() };
        Some(Estimate { of: self.of, value, middle, rows: self.rows, construction: self.construction })
    }
}

/// Whether a law goes with a power of the mass.
fn is_sloped(of: Estimated) -> bool {
    matches!(of, Estimated::ThermalResistance | Estimated::Inductance)
}

/// The points of the motors of some constructions, sorted by motor.
fn points<'m>(of: Estimated, motors: &'m [Motor], is_of: impl Fn(Construction) -> bool) -> Vec<Point<'m>> {
    let mut points: Vec<Point> = Vec::new();
    for motor in motors.iter().filter(|m| is_alone(m) && m.about.construction.is_some_and(&is_of)) {
        let Some((Some(y), mass)) = reduced(of, motor).map(|r| r.0).zip(motor.mass) else { continue };
        let diameter = motor.sheet.outer_diameter.map(|p| p.value.to_bits());
        points.push(((motor.manufacturer.as_str(), mass.to_bits(), diameter), mass.ln(), y.ln()));
    }
    points.sort_by(|a, b| a.0.cmp(&b.0));
    points
}

/// Whether the numbers of a row are those of the motor alone, and no other row counts for it.
fn is_alone(motor: &Motor) -> bool {
    motor.about.only_inside.is_empty() && motor.about.same_as.is_empty()
}

/// Every law over some motors, shipped or not.
pub fn laws(motors: &[Motor]) -> Vec<Law> {
    let all = Estimated::NAMES.iter().flat_map(|of| Construction::NAMES.iter().map(move |c| (of.1, c.1)));
    all.filter_map(|(of, construction)| {
        Law::over(of, construction, motors).or_else(|| Law::over_others(of, construction, motors))
    })
    .collect()
}

/// The laws over the rows of the built-in catalogue: those that every catalogue is completed by, so that a row of one's own
/// is estimated alike whatever stands beside it.
pub fn builtin_laws() -> &'static [Law] {
    static LAWS: OnceLock<Vec<Law>> = OnceLock::new();
    LAWS.get_or_init(|| Catalog::builtin().map_or_else(|_| Vec::new(), |catalog| laws(&catalog.motors)))
}

/// The motor with what its row lacks and a law of the built-in catalogue says. What is estimated stands in
/// `motor.estimates`.
pub fn completed(motor: Motor) -> Motor {
    if !motor.about.only_inside.is_empty() {
        return motor;
    }
    let law = |of: Estimated| {
        let found = builtin_laws().iter().find(|l| l.of == of && Some(l.construction) == motor.about.construction)?;
        found.is_shipped().then(|| found.estimate(&motor)).flatten()
    };
    let heat = (!tells_heat(&motor)).then(|| law(Estimated::ThermalResistance)).flatten();
    let inertia = motor.rotor_inertia.is_none().then(|| law(Estimated::RotorInertia)).flatten();
    let inductance = motor.inductance.is_none().then(|| law(Estimated::Inductance)).flatten();
    let drag = (motor.drag() == Drag::Unknown).then(|| law(Estimated::Drag)).flatten();
    let rated = motor.thermal_resistance.is_none().then(|| witnessed_resistance(&motor, HIGHEST_RATED_TEMPERATURE));
    Motor {
        thermal_resistance: motor.thermal_resistance.or(heat.map(|e| e.value)),
        rated_thermal_resistance: rated.flatten(),
        rotor_inertia: motor.rotor_inertia.or(inertia.map(|e| e.value)),
        inductance: motor.inductance.or(inductance.map(|e| e.value)),
        no_load_torque: motor.no_load_torque.or(drag.map(|e| e.value)),
        estimates: [heat, inertia, inductance, drag].into_iter().flatten().collect(),
        ..motor
    }
}

/// A module with the drag of its motor estimated, where its row says none and its constants are known: the largest that motors of
/// like motor constant have, however they are built.
pub fn completed_module(module: Motor) -> Motor {
    let known = module.inside.as_deref().is_some_and(|inside| inside.depth == Depth::Constants);
    if !known || module.drag() != Drag::Unknown {
        return module;
    }
    let laws = builtin_laws().iter().filter(|law| law.of == Estimated::Drag && law.is_shipped());
    let built = |construction: Construction| {
        let about = About { construction: Some(construction), ..module.about.clone() };
        Motor { about, ..module.clone() }
    };
    let drag = laws.filter_map(|law| law.estimate(&built(law.construction))).max_by(|a, b| a.value.total_cmp(&b.value));
    Motor { no_load_torque: drag.map(|e| e.value), estimates: drag.into_iter().collect(), ..module }
}

/// A catalogue with what its rows lack estimated, where the laws of the built-in catalogue say it.
pub fn complete(mut catalog: Catalog) -> Catalog {
    catalog.motors = catalog.motors.into_iter().map(completed).collect();
    catalog
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(of: Estimated, construction: Construction) -> &'static Law {
        builtin_laws().iter().find(|l| l.of == of && l.construction == construction).expect("enough rows")
    }

    #[test]
    fn only_what_predicts_other_motors_is_used() {
        use Construction::{Frameless, Housed, Outrunner};
        let shipped: Vec<_> =
            builtin_laws().iter().filter(|l| l.is_shipped()).map(|l| (l.of, l.construction)).collect();
        let expected = [
            (Estimated::ThermalResistance, Frameless),
            (Estimated::ThermalResistance, Housed),
            (Estimated::ThermalResistance, Outrunner),
            (Estimated::Inductance, Outrunner),
            (Estimated::Drag, Frameless),
            (Estimated::Drag, Housed),
            (Estimated::Drag, Outrunner),
        ];
        assert_eq!(shipped, expected);
        // A law that does not predict gives no number, whatever the row lacks.
        let catalog = Catalog::builtin().unwrap();
        let outrunner = completed(catalog.motor("odrive-d6374-kv150").unwrap().clone());
        assert!(!law(Estimated::RotorInertia, Outrunner).is_shipped());
        assert_eq!(outrunner.rotor_inertia, None);
    }

    #[test]
    fn the_line_and_its_reach_are_those_of_the_textbook() {
        // Draper and Smith: y over x = 1..5; slope and intercept on paper, s² = Σr²/3, t(0.9, 3) = 1.6377.
        let points = [(1.0, 2.1), (2.0, 3.9), (3.0, 6.2), (4.0, 7.8), (5.0, 10.1)];
        let line = Line::through(&points, true);
        assert!((line.slope - 1.99).abs() < 1e-12 && (line.intercept - 0.05).abs() < 1e-12);
        let squares: f64 = points.iter().map(|(x, y)| (y - 0.05 - 1.99 * x).powi(2)).sum();
        let reach = 1.637_744 * (squares / 3.0).sqrt() * (1.0 + 0.2 + 9.0 / 10.0_f64).sqrt();
        assert!((line.reach(6.0) / reach - 1.0).abs() < 1e-5);
    }

    /// What the law of all other motors says of a motor is beyond its interval about one time in ten, and no more than one in
    /// five: every motor of the catalogue with the number is asked, the mean over its windings.
    #[test]
    fn the_interval_holds_what_it_says_for_motors_that_it_was_not_made_from() {
        let all = Catalog::builtin().unwrap().motors;
        for construction in [Construction::Frameless, Construction::Housed, Construction::Outrunner] {
            let (mut beyond, mut seen) = (0, Vec::new());
            for motor in all.iter().filter(|m| is_alone(m) && m.about.construction == Some(construction)) {
                let diameter = |m: &Motor| m.sheet.outer_diameter.map(|p| p.value.to_bits());
                let key = |m: &Motor| (m.manufacturer.clone(), m.mass.map(f64::to_bits), diameter(m));
                let same = |m: &&Motor| key(m) == key(motor);
                let name = key(motor);
                let told: Vec<f64> = all
                    .iter()
                    .filter(same)
                    .filter_map(|m| Some(witnessed_resistance(m, ASSUMED_WINDING_TEMPERATURE)?.ln()))
                    .collect();
                if told.is_empty() || seen.contains(&name) {
                    continue;
                }
                let others: Vec<Motor> = all.iter().filter(|m| !same(m)).cloned().collect();
                let law = Law::over(Estimated::ThermalResistance, construction, &others).unwrap();
                let Some(estimate) = law.estimate(motor) else { continue };
                seen.push(name);
                beyond += usize::from(told.iter().sum::<f64>() / told.len() as f64 > estimate.value.ln());
            }
            let asked = seen.len();
            assert!(asked >= 10 && 5 * beyond <= asked, "{construction:?}: {beyond} of {asked}");
        }
    }

    #[test]
    fn what_a_row_says_is_never_estimated() {
        for motor in Catalog::builtin().unwrap().motors {
            let made = completed(motor.clone());
            assert!(motor.thermal_resistance.is_none() || made.thermal_resistance == motor.thermal_resistance);
            assert!(motor.rotor_inertia.is_none() || made.rotor_inertia == motor.rotor_inertia);
            assert!(motor.inductance.is_none() || made.inductance == motor.inductance);
            assert!(!tells_heat(&motor) || !made.is_estimated(Estimated::ThermalResistance));
            // The insides of a module have the module's mass: nothing is told from it.
            assert!(motor.about.only_inside.is_empty() || made.estimates.is_empty());
        }
    }

    #[test]
    fn without_mass_or_construction_or_far_from_the_rows_nothing_is_estimated() {
        let catalog = Catalog::builtin().unwrap();
        let gimbal = catalog.motor("t-motor-g60-kv55").unwrap();
        assert!(completed(gimbal.clone()).is_estimated(Estimated::ThermalResistance));
        let mut other = gimbal.clone();
        other.mass = None;
        assert!(completed(other.clone()).estimates.is_empty());
        (other.mass, other.about.construction) = (gimbal.mass, None);
        assert!(completed(other.clone()).estimates.is_empty());
        (other.mass, other.about.construction) = (Some(20.0), gimbal.about.construction);
        assert!(completed(other).estimates.is_empty());
    }

    #[test]
    fn most_of_the_shipped_motors_can_be_judged_for_heat() {
        let catalog = complete(Catalog::builtin().unwrap().free(false));
        let judged = catalog.motors.iter().filter(|m| tells_heat(m)).count();
        assert!(judged >= 100, "{judged} of {}", catalog.motors.len());
        let unknown: Vec<&str> = catalog.motors.iter().filter(|m| !tells_heat(m)).map(|m| m.id.as_str()).collect();
        assert_eq!(unknown, ["moons-r57blb50l2", "nanotec-db59s024035-a", "tq-robodrive-ilm-25x08"]);
    }
}
