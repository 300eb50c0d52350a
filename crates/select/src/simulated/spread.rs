//! How sure the numbers of a simulated joint are: ranges of 95 %, and draws that keep what belongs together.
//!
//! The one idea: what is uncertain are the numbers of the motor's row, of its gear and of its effects: each with a ± of its
//! row, or all together with the covariance of a fit. What a simulator is told follows from them by the same way as ever
//! ([`SimulatedJoint`](super::SimulatedJoint)), of a motor with other numbers: ranges by its slopes, draws one by one.

use nalgebra::{DMatrix, DVector};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::{NoLoad, Numbers, no_load_friction};
use gearwise_model::catalog::drag::Drag;
use gearwise_model::catalog::{FIELDS, Field, Motor};
use gearwise_model::effects::{Effect, Named};

/// Standard errors in half of an interval of 95 %.
const INTERVAL: f64 = 1.96;
/// A slope is taken over this share of a standard error.
const STEP: f64 = 0.1;
/// A number that makes less than this share of a variance is not named as its source.
const SHARE: f64 = 0.01;
/// Draws beyond what a number can be are drawn again, at most so often.
const TRIES: usize = 200;
/// Draws are the same on every machine.
const SEED: u64 = 20_251;

/// A range of 95 %.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranged {
    /// Which number: a name of [`SimulatedJoint::numbers`](super::SimulatedJoint::numbers).
    pub name: &'static str,
    /// Lower end, SI; not below zero.
    pub low: f64,
    /// Upper end, SI.
    pub high: f64,
    /// Numbers that it comes from, the largest share first.
    pub from: Vec<String>,
}

/// How sure the numbers of a joint are.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spread {
    /// Ranges; a number of which nothing has a ± has none.
    pub ranges: Vec<Ranged>,
    /// Draws, each with the numbers of [`SimulatedJoint::numbers`](super::SimulatedJoint::numbers).
    pub draws: Vec<Vec<(&'static str, f64)>>,
    /// Whether the numbers were fitted together: then draws keep their covariance.
    pub is_correlated: bool,
}

/// Where an uncertain number is.
#[derive(Clone, Copy)]
enum Place {
    /// In the motor's row.
    Row(&'static Field),
    /// A value of an effect, by their places.
    Effect(usize, usize),
    /// The gear's efficiency, its efficiency backwards, its inertia at the input.
    Gear(usize),
}

/// A number that has a ±.
struct Found {
    name: String,
    place: Place,
    value: f64,
    tolerance: Option<f64>,
    /// Its place in the covariance of the fit.
    fitted: Option<usize>,
}

/// The uncertain numbers of a motor.
struct Uncertain<'a> {
    motor: &'a Motor,
    names: Vec<String>,
    places: Vec<Place>,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
    is_correlated: bool,
}

impl Spread {
    /// Ranges of a joint, and `draws` draws of it, where `of` has the joint's numbers with another motor. `None` where no number of the
    /// motor has a ± and its drag is known; a module's row has none.
    pub fn new(motor: &Motor, draws: usize, of: impl Fn(&Motor) -> Option<Numbers>) -> Option<Spread> {
        let uncertain = Uncertain::new(motor);
        let mut ranges = uncertain.ranges(&of);
        let is_split = Split::of(motor).is_some();
        let friction = uncertain.friction(&of);
        ranges.retain(|range| friction.iter().all(|of| of.name != range.name));
        ranges.extend(friction);
        if uncertain.names.is_empty() && !is_split {
            return None;
        }
        let draws = uncertain.draws(draws, &of);
        Some(Spread { ranges, draws, is_correlated: uncertain.is_correlated })
    }

    /// The range of a number.
    pub fn range(&self, name: &str) -> Option<&Ranged> {
        self.ranges.iter().find(|r| r.name == name)
    }
}

/// Drag without load of which only the sum is known: Coulomb friction up to all of it, the rest viscous.
#[derive(Clone, Copy)]
struct Split {
    /// All of it \[N·m\].
    torque: f64,
    /// The speed \[rad/s\] at which it is known; `None` where that is not known or the torque is an upper bound.
    speed: Option<f64>,
    /// Number that it comes from.
    from: &'static str,
}

impl Split {
    fn of(motor: &Motor) -> Option<Split> {
        // The numbers inside a module are none of its row.
        let (NoLoad::AtMost(_), None) = (no_load_friction(motor), &motor.inside) else { return None };
        match motor.drag() {
            Drag::NoLoad { torque, speed } => Some(Split { torque, speed, from: "motor.no_load_current" }),
            Drag::Estimated { torque } => Some(Split { torque, speed: None, from: "motor.drag (estimated)" }),
            Drag::Declared | Drag::Unknown => None,
        }
        .filter(|split| split.torque > 0.0)
    }

    /// The motor with a share of the drag that is not Coulomb friction.
    fn motor(self, motor: &Motor, share: f64) -> Motor {
        Motor {
            coulomb_friction: Some((1.0 - share) * self.torque),
            viscous_friction: self.speed.map(|speed| share * self.torque / speed).or(motor.viscous_friction),
            ..motor.clone()
        }
    }
}

impl<'a> Uncertain<'a> {
    fn new(motor: &'a Motor) -> Uncertain<'a> {
        let fit = motor.fit.as_ref();
        let covariance_of = |name: &str| fit.and_then(|fit| fit.names.iter().position(|n| n == name));
        let mut found = Vec::new();
        for field in FIELDS {
            let Some(printed) = (field.get)(&motor.sheet) else { continue };
            let name = format!("motor.{}", field.name);
            let fitted = covariance_of(&name);
            found.push(Found {
                name,
                place: Place::Row(field),
                value: printed.value,
                tolerance: printed.tolerance,
                fitted,
            });
        }
        for (k, fitted_effect) in motor.effects.iter().enumerate() {
            let effect: &'static dyn Effect = fitted_effect.effect;
            for (j, (parameter, value)) in effect.parameters().iter().zip(&fitted_effect.values).enumerate() {
                let within = Named::new(effect, fitted_effect.values.last().copied(), parameter.name).to_string();
                let tolerance = fit.and_then(|fit| fit.tolerance(&within));
                let name = format!("effects.{within}");
                let fitted = covariance_of(&name);
                found.push(Found { name, place: Place::Effect(k, j), value: *value, tolerance, fitted });
            }
        }
        for (k, (name, value)) in gear_numbers(motor).into_iter().enumerate() {
            let Some(value) = value else { continue };
            let name = format!("gear.{name}");
            let (tolerance, fitted) = (fit.and_then(|fit| fit.tolerance(&name)), covariance_of(&name));
            found.push(Found { name, place: Place::Gear(k), value, tolerance, fitted });
        }
        found.retain(|f| f.tolerance.is_some_and(|t| t > 0.0) || f.fitted.is_some());
        // The numbers inside a module have no ± of their own.
        if motor.inside.is_some() {
            found.clear();
        }
        let n = found.len();
        let mut covariance = DMatrix::zeros(n, n);
        for (a, of_a) in found.iter().enumerate() {
            for (b, of_b) in found.iter().enumerate() {
                covariance[(a, b)] = match (fit, of_a.fitted, of_b.fitted) {
                    (Some(fit), Some(j), Some(k)) => {
                        fit.covariance.get(j).and_then(|row| row.get(k)).copied().unwrap_or(0.0)
                    }
                    (_, None, _) if a == b => (of_a.tolerance.unwrap_or(0.0) / INTERVAL).powi(2),
                    _ => 0.0,
                };
            }
        }
        Uncertain {
            motor,
            is_correlated: found.iter().filter(|f| f.fitted.is_some()).count() > 1,
            values: DVector::from_iterator(n, found.iter().map(|f| f.value)),
            places: found.iter().map(|f| f.place).collect(),
            names: found.into_iter().map(|f| f.name).collect(),
            covariance,
        }
    }

    fn error(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }

    /// The motor with other numbers; `None` where one of them is none that it can have.
    fn with(&self, values: &DVector<f64>) -> Option<Motor> {
        let old = self.motor;
        let (mut sheet, mut effects, mut gear) = (old.sheet.clone(), old.effects.clone(), old.fitted_gear);
        for (k, (place, value)) in self.places.iter().zip(values.iter()).enumerate() {
            if *value == self.values[k] {
                continue;
            }
            match place {
                Place::Row(field) => {
                    if !field.range.contains(*value) {
                        return None;
                    }
                    let printed = (field.get)(&sheet)?;
                    (field.set)(&mut sheet, gearwise_model::catalog::Printed { value: *value, ..printed });
                }
                Place::Effect(effect, parameter) => {
                    // What has no sign keeps none.
                    if !effects[*effect].effect.is_signed() && *value < 0.0 {
                        return None;
                    }
                    effects[*effect].values[*parameter] = *value;
                }
                Place::Gear(which) => {
                    if *value < 0.0 || (*which < 2 && *value > 1.0) {
                        return None;
                    }
                    let gear = gear.as_mut()?;
                    match which {
                        0 => gear.efficiency = Some(*value),
                        1 => gear.backdrive_efficiency = Some(*value),
                        _ => gear.inertia = Some(*value),
                    }
                }
            }
        }
        let made = Motor::new(old.identity(), old.conventions, sheet, old.pole_pairs).ok()?;
        Some(Motor {
            effects,
            fitted_gear: gear,
            fit: old.fit.clone(),
            pole_pairs: old.pole_pairs,
            wound: old.wound.clone(),
            // What the row does not print but an estimate or a rating says stays.
            rotor_inertia: made.rotor_inertia.or(old.rotor_inertia),
            inductance: made.inductance.or(old.inductance),
            mass: made.mass.or(old.mass),
            continuous_current: made.continuous_current.or(old.continuous_current),
            peak_current: made.peak_current.or(old.peak_current),
            thermal_resistance: made.thermal_resistance.or(old.thermal_resistance),
            max_winding_temperature: made.max_winding_temperature.or(old.max_winding_temperature),
            coulomb_friction: made.coulomb_friction.or(old.coulomb_friction),
            viscous_friction: made.viscous_friction.or(old.viscous_friction),
            no_load_torque: made.no_load_torque.or(old.no_load_torque),
            rated_thermal_resistance: old.rated_thermal_resistance,
            estimates: old.estimates.clone(),
            ..made
        })
    }

    fn ranges(&self, of: &impl Fn(&Motor) -> Option<Numbers>) -> Vec<Ranged> {
        let Some(numbers) = of(self.motor) else { return Vec::new() };
        // Slope of each number along each uncertain one.
        let mut slopes = DMatrix::zeros(numbers.len(), self.values.len());
        for k in 0..self.values.len() {
            let step = STEP * self.error(k);
            if step == 0.0 {
                continue;
            }
            let at = |by: f64| {
                let mut values = self.values.clone();
                values[k] += by;
                of(&self.with(&values)?)
            };
            // One side is enough where the other is none that the number can have.
            let (down, up) = (at(-step), at(step));
            for (j, (_, value)) in numbers.iter().enumerate() {
                let side = |other: &Option<Numbers>| other.as_ref().and_then(|o| o[j].1);
                slopes[(j, k)] = match (side(&down), *value, side(&up)) {
                    (Some(a), _, Some(b)) => (b - a) / (2.0 * step),
                    (None, Some(a), Some(b)) | (Some(a), Some(b), None) => (b - a) / step,
                    _ => 0.0,
                };
            }
        }
        let mut ranges = Vec::new();
        for (j, (name, value)) in numbers.iter().enumerate() {
            let Some(value) = value else { continue };
            let slope = slopes.row(j).transpose();
            let variance = (slope.transpose() * &self.covariance * &slope)[(0, 0)];
            if variance.is_nan() || variance <= (1e-9 * value).powi(2) {
                continue;
            }
            let half = INTERVAL * variance.sqrt();
            let mut shares: Vec<(f64, &str)> =
                self.names.iter().enumerate().map(|(k, n)| ((slope[k] * self.error(k)).powi(2), n.as_str())).collect();
            shares.sort_by(|a, b| b.0.total_cmp(&a.0));
            let most = shares[0].0;
            let from = shares.iter().filter(|(share, _)| *share > SHARE * most).map(|(_, n)| (*n).to_string());
            ranges.push(Ranged { name, low: (value - half).max(0.0), high: value + half, from: from.collect() });
        }
        ranges
    }

    /// Ranges of viscous and Coulomb friction at the joint where the motor's drag is known as a sum: those of either end of the split.
    fn friction(&self, of: &impl Fn(&Motor) -> Option<Numbers>) -> Vec<Ranged> {
        let Some(split) = Split::of(self.motor) else { return Vec::new() };
        let ends = [0.0, 1.0].map(|share| {
            let of_end = |motor: &Motor| of(&Split::of(motor)?.motor(motor, share));
            (of_end(self.motor), self.ranges(&of_end))
        });
        let mut found = Vec::new();
        for name in ["damping", "friction_loss"] {
            let mut all = Ranged { name, low: f64::INFINITY, high: 0.0, from: Vec::new() };
            for (numbers, ranges) in &ends {
                let value = numbers.iter().flatten().find(|(other, _)| *other == name).and_then(|(_, value)| *value);
                let range = ranges.iter().find(|range| range.name == name);
                let [low, high] = range.map_or([value.unwrap_or(0.0); 2], |range| [range.low, range.high]);
                (all.low, all.high) = (all.low.min(low), all.high.max(high));
                all.from.extend(range.into_iter().flat_map(|range| range.from.clone()));
            }
            if all.low < all.high {
                all.from.insert(0, split.from.into());
                all.from.dedup();
                found.push(all);
            }
        }
        found
    }

    fn draws(&self, count: usize, of: &impl Fn(&Motor) -> Option<Numbers>) -> Vec<Vec<(&'static str, f64)>> {
        // A root of the covariance, whatever rounding made of its rank.
        let root = if self.values.is_empty() {
            DMatrix::zeros(0, 0)
        } else {
            let eigen = self.covariance.clone().symmetric_eigen();
            &eigen.eigenvectors * DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()))
        };
        let mut generator = Pcg64::seed_from_u64(SEED);
        let mut draws = Vec::new();
        for _ in 0..count {
            let drawn = (0..TRIES).find_map(|_| {
                let normal = DVector::from_fn(self.values.len(), |_, _| normal(&mut generator));
                let motor = self.with(&(&self.values + &root * normal))?;
                let numbers = match Split::of(&motor) {
                    Some(split) => of(&split.motor(&motor, uniform(&mut generator)))?,
                    None => of(&motor)?,
                };
                Some(numbers.iter().filter_map(|(name, value)| Some((*name, (*value)?))).collect())
            });
            draws.extend(drawn);
        }
        draws
    }
}

fn gear_numbers(motor: &Motor) -> [(&'static str, Option<f64>); 3] {
    let gear = motor.fitted_gear;
    [
        ("efficiency", gear.and_then(|g| g.efficiency)),
        ("backdrive_efficiency", gear.and_then(|g| g.backdrive_efficiency)),
        ("inertia", gear.and_then(|g| g.inertia)),
    ]
}

/// A number between 0 and 1.
fn uniform(generator: &mut Pcg64) -> f64 {
    ((generator.next_u64() >> 11) as f64 + 0.5) * 2.0_f64.powi(-53)
}

/// A number of the standard normal distribution (Box and Muller).
fn normal(generator: &mut Pcg64) -> f64 {
    let (a, b) = (uniform(generator), uniform(generator));
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}
