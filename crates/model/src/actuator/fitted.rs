//! Effects that were found in logs and belong to one actuator, and what those of them that are no linear
//! feature of a sample do to its limits.
//!
//! The one idea: an effect says as data how it enters ([`Enters`]), and each way is worked out in one place. Features
//! are added to the shaft's equation. What lowers what may be had, or adds to the heat,
//! becomes one [`Shortfall`] of the actuator, which turns torques into currents for every limit. What
//! depends on the motor's own speed in no polynomial way is a [`drag`], evaluated at a ratio.

use crate::catalog::Motor;
use crate::effects::features::{Feature, ShaftForm};
use crate::effects::{EFFECTS, Enters, FittedEffect, Operating, Side};
use crate::requirement::{GearModel, Joint, RatioChoice, backdrive_efficiency};

/// Saturation of the iron: torque `K_T i − k (i − i_s tanh(i/i_s))` at a current i ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Saturation {
    /// k \[N·m/A\].
    slope: f64,
    /// i_s \[A\].
    current: f64,
    /// Up to this current the curve is used \[A\]; beyond it heat goes on as its tangent.
    last: f64,
    /// Torque \[N·m\] and its slope \[N·m/A\] at that current.
    end: (f64, f64),
    /// True if the iron gives next to no more torque beyond.
    ends: bool,
}

/// Adds all effects that the motor's row declares and that were fitted for it, where they are features of a sample.
pub(crate) fn add_features(motor: &Motor, form: &mut ShaftForm) {
    for effect in motor.all_effects() {
        if let Enters::Features(own) = effect.enters() {
            *form = form.plus(1.0, &own);
        }
    }
}

/// What lies between the torque that a sample asks for and the current that makes it, beyond `T/K_T`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shortfall {
    /// Torque constant \[N·m/A\] that the rest refers to.
    torque_constant: f64,
    /// Sum of the amplitudes of torques that depend on angle alone \[N·m\], A.
    ripple: f64,
    /// Mean of their square `Σ A²/2` \[N²·m²\].
    ripple_mean_square: f64,
    /// Sum of the amplitudes of ripple that is proportional to current, over the torque constant, r.
    proportional: f64,
    /// What that ripple multiplies the mean squared current with: `(1 − Σ r²)^(−3/2)`.
    proportional_heat: f64,
    saturation: Option<Saturation>,
    /// Voltage lost in the inverter \[V\].
    pub voltage: f64,
}

impl Shortfall {
    /// Nothing lies between.
    pub fn none(torque_constant: f64) -> Shortfall {
        Shortfall {
            torque_constant,
            ripple: 0.0,
            ripple_mean_square: 0.0,
            proportional: 0.0,
            proportional_heat: 1.0,
            saturation: None,
            voltage: 0.0,
        }
    }

    /// Of the motor's effects, at a torque constant; ripple of the gear only where the gear is the one that
    /// was fitted.
    pub fn new(motor: &Motor, torque_constant: f64, fitted_gear: bool) -> Shortfall {
        let mut all = Shortfall::none(torque_constant);
        let mut squares = 0.0;
        for fitted in &motor.effects {
            if fitted.effect.side() == Side::Gear && !fitted_gear {
                continue;
            }
            match fitted.enters() {
                Enters::Ripple(amplitude) => all.add_ripple(amplitude),
                Enters::RippleOfCurrent(amplitude) => {
                    let relative = amplitude / torque_constant;
                    all.proportional += relative;
                    squares += relative * relative;
                }
                Enters::Saturation { slope, current } if slope != 0.0 => {
                    all.saturation = Some(Saturation::new(slope, current, torque_constant, motor.peak_current));
                }
                Enters::Voltage(lost) => all.voltage += lost,
                _ => {}
            }
        }
        if let Some(current) = motor.saturation_current() {
            all.saturation = Some(Saturation::new(torque_constant, current, torque_constant, motor.peak_current));
        }
        // Ripple as large as the torque itself leaves none: the heat has no end.
        all.proportional_heat = (1.0 - squares).max(0.0).powf(-1.5);
        all
    }

    fn add_ripple(&mut self, amplitude: f64) {
        self.ripple += amplitude;
        self.ripple_mean_square += 0.5 * amplitude * amplitude;
    }

    /// Whether torque and current are proportional, and nothing is lost.
    pub fn is_nothing(&self) -> bool {
        *self == Shortfall::none(self.torque_constant)
    }

    /// Whether the current is no longer proportional to the torque.
    pub fn saturates(&self) -> bool {
        self.saturation.is_some()
    }

    /// Shortfall without saturation. Its current is a lower bound at any torque.
    #[must_use]
    pub fn unsaturated(self) -> Shortfall {
        Shortfall { saturation: None, ..self }
    }

    /// Largest torque of the iron at any current \[N·m\], where the slope of the saturation curve has fallen to a hundredth of the torque
    /// constant; `None` where it does not.
    pub fn largest_torque(&self) -> Option<f64> {
        Some(self.saturation.filter(|saturation| saturation.ends)?.end.0)
    }

    /// What remains for the motion of a largest torque \[N·m\], where demands are multiplied with `safety`.
    pub fn left_of_torque(&self, largest: f64, safety: f64) -> f64 {
        if self.ripple == 0.0 && self.proportional == 0.0 {
            return largest;
        }
        (largest * (1.0 - self.proportional) - safety * self.ripple).max(0.0)
    }

    /// What remains for the motion of a largest current \[A\], as `T/K_T`.
    pub fn left_of_current(&self, largest: f64, safety: f64) -> f64 {
        if *self == (Shortfall { voltage: self.voltage, ..Shortfall::none(self.torque_constant) }) {
            return largest;
        }
        let torque = match self.saturation {
            Some(saturation) => saturation.largest_torque(self.torque_constant, largest),
            None => self.torque_constant * largest,
        };
        self.left_of_torque(torque, safety) / self.torque_constant
    }

    /// Largest current of a largest torque of the motion \[A\].
    pub fn peak_current(&self, torque: f64) -> f64 {
        let Some(saturation) = self.saturation else {
            return match self.ripple == 0.0 && self.proportional == 0.0 {
                true => torque / self.torque_constant,
                false => (torque + self.ripple) / (self.torque_constant * (1.0 - self.proportional).max(0.0)),
            };
        };
        self.saturated(saturation, (torque + self.ripple) / (1.0 - self.proportional).max(0.0)).0
    }

    /// Derivative of [`Self::peak_current`] \[A/(N·m)\].
    pub fn peak_current_slope(&self, torque: f64) -> f64 {
        let share = (1.0 - self.proportional).max(0.0);
        match self.saturation {
            None => 1.0 / (self.torque_constant * share),
            Some(saturation) => self.saturated(saturation, (torque + self.ripple) / share).1 / share,
        }
    }

    /// Torque `K_T i` \[N·m\] that the current at a torque ≥ 0 would give without saturation, and its derivative. Convex; ripple is left
    /// out.
    pub fn without_saturation(&self, torque: f64) -> (f64, f64) {
        let Some(saturation) = self.saturation else { return (torque, 1.0) };
        let (current, slope) = self.saturated(saturation, torque);
        (self.torque_constant * current, self.torque_constant * slope)
    }

    /// What is added to the mean of `T²` \[N²·m²\].
    pub fn mean_square(&self) -> f64 {
        self.ripple_mean_square
    }

    /// What the mean of the squared current is multiplied with beyond `1/K_T²`.
    pub fn heat_factor(&self) -> f64 {
        self.proportional_heat
    }

    /// Mean squared current at a squared torque \[A²\], and its derivative \[A²/(N²·m²)\]: a convex
    /// function. Ripple is added in its mean square.
    #[inline(always)]
    pub fn current_squared(&self, torque_squared: f64) -> (f64, f64) {
        let squared = (torque_squared + self.ripple_mean_square) * self.proportional_heat;
        let per_square = 1.0 / (self.torque_constant * self.torque_constant);
        let (current_squared, slope) = match self.saturation {
            None => (squared * per_square, per_square),
            Some(saturation) => {
                let share = squared * per_square / (saturation.current * saturation.current);
                let is_tanh = saturation.slope == self.torque_constant;
                if is_tanh && share < SMALL * SMALL && squared <= saturation.end.0 * saturation.end.0 {
                    let series = atanh_series(share);
                    (squared * per_square * series * series, per_square * series / (1.0 - share))
                } else {
                    self.on_curve(saturation, squared)
                }
            }
        };
        (current_squared, slope * self.proportional_heat)
    }

    /// Squared current of a squared torque of the saturated curve \[A²\] and its derivative \[A²/(N²·m²)\].
    #[inline(never)]
    fn on_curve(&self, saturation: Saturation, squared: f64) -> (f64, f64) {
        let torque = squared.sqrt();
        let (current, slope) = self.saturated(saturation, torque);
        // d(i²)/d(T²) = i i'/T, which is 1/K_T² where both vanish.
        let per_square = if torque > 0.0 { current * slope / torque } else { self.torque_constant.powi(-2) };
        (current * current, per_square)
    }

    /// Current at a torque ≥ 0 of the saturated curve \[A\] and its derivative \[A/(N·m)\].
    fn saturated(&self, saturation: Saturation, torque: f64) -> (f64, f64) {
        let k_t = self.torque_constant;
        let end = saturation.end;
        if torque > end.0 {
            // i² goes on as the tangent in T²: convex, and beyond what the motor can do anyway.
            let rate = 2.0 * saturation.last / end.1;
            let squared = saturation.last.powi(2) + rate / (2.0 * end.0) * (torque * torque - end.0 * end.0);
            return (squared.sqrt(), rate / (2.0 * end.0) * torque / squared.sqrt());
        }
        if saturation.slope == k_t {
            // T = K_T i_s tanh(i/i_s).
            let share = torque / (k_t * saturation.current);
            return (saturation.current * share.atanh(), 1.0 / (k_t * (1.0 - share * share)));
        }
        // The curve rises and bends down: Newton from T/K_T, which is below the root, never passes it.
        let mut current = torque / k_t;
        for _ in 0..100 {
            let (value, slope) = saturation.torque(k_t, current);
            let next = (current + (torque - value) / slope).min(saturation.last);
            let done = (next - current).abs() <= 4.0 * f64::EPSILON * current;
            current = next;
            if done {
                break;
            }
        }
        (current, 1.0 / saturation.torque(k_t, current).1)
    }
}

impl Saturation {
    fn new(slope: f64, current: f64, torque_constant: f64, peak_current: Option<f64>) -> Saturation {
        // Where the slope dT/di = K_T − k tanh²(i/i_s) has fallen to a hundredth, the motor gives no more.
        let share = 0.99 * torque_constant / slope;
        let steep = if (0.0..1.0).contains(&share) { current * share.sqrt().atanh() } else { f64::INFINITY };
        let largest = peak_current.unwrap_or(f64::INFINITY).max(current);
        let last = steep.min(1e3 * largest.min(1e6));
        let mut all = Saturation { slope, current, last, end: (0.0, torque_constant), ends: last == steep };
        all.end = all.torque(torque_constant, last);
        all
    }

    /// Torque \[N·m\] and its slope \[N·m/A\] at a current.
    fn torque(&self, torque_constant: f64, current: f64) -> (f64, f64) {
        let bent = (current / self.current).tanh();
        let torque = torque_constant * current - self.slope * (current - self.current * bent);
        (torque, torque_constant - self.slope * bent * bent)
    }

    /// The largest torque with a current up to `largest`.
    fn largest_torque(&self, torque_constant: f64, largest: f64) -> f64 {
        self.torque(torque_constant, largest.min(self.last)).0
    }
}

/// Upper end of the arguments at which [`atanh_series`] is exact to rounding.
const SMALL: f64 = 0.2;

/// `artanh(x)/x` of a squared x below [`SMALL`]²: Σ x²ᵏ/(2k+1) to k = 10, summed in pairs.
#[inline]
fn atanh_series(x: f64) -> f64 {
    let pair = |k: f64| 1.0 / (4.0 * k + 1.0) + x * (1.0 / (4.0 * k + 3.0));
    let x2 = x * x;
    let x4 = x2 * x2;
    let ends = pair(4.0) + x2 * (1.0 / 21.0);
    (pair(0.0) + x2 * pair(1.0)) + x4 * ((pair(2.0) + x2 * pair(3.0)) + x4 * ends)
}

/// Effects that are evaluated at each ratio.
pub fn evaluated(motor: &Motor) -> impl Iterator<Item = &FittedEffect> {
    motor.effects.iter().filter(|e| matches!(e.enters(), Enters::Evaluated(_)))
}

/// Torque of the evaluated effects at a speed of the motor \[N·m\] with its sign, and its derivative
/// \[N·m·s/rad\].
pub fn drag(motor: &Motor, speed: f64, direction: f64) -> (f64, f64) {
    let at = Operating { direction, ..Operating::at_speed(speed) };
    motor.effects.iter().fold((0.0, 0.0), |(torque, slope), fitted| match fitted.enters() {
        Enters::Evaluated(of_speed) => {
            (torque + fitted.effect.value(&fitted.values, &at), slope + of_speed(&fitted.values, &at))
        }
        _ => (torque, slope),
    })
}

/// Why a program with evaluated effects has no certificate; empty where the motor has none.
pub fn why_evaluated(motor: &Motor) -> String {
    let has = |name: &str| evaluated(motor).any(|e| e.name() == name);
    let names: Vec<&str> = EFFECTS.iter().map(|e| e.name()).filter(|name| has(name)).collect();
    let verb = match names.len() {
        0 => return String::new(),
        1 => "is",
        _ => "are",
    };
    format!("{} {verb} evaluated on a grid of ratios", names.join(" and "))
}

/// Torque constant of the hottest motor \[N·m/A\], where magnets were found to lose flux.
pub fn hot_torque_constant(motor: &Motor, hottest: Option<f64>) -> f64 {
    let slopes = motor.effects.iter().filter_map(|e| match e.enters() {
        Enters::TorqueConstant { per_kelvin } => Some(per_kelvin),
        _ => None,
    });
    let Some(hottest) = hottest else { return motor.torque_constant };
    let rise = (hottest - motor.reference_temperature).max(0.0);
    // A magnet that would be gone altogether is left a hundredth: currents without end are refused anyway.
    slopes.fold(motor.torque_constant, |k, slope| k - slope * rise).max(0.01 * motor.torque_constant)
}

/// The factor γ of the gear's friction, where it was found.
fn load_dependent(motor: &Motor) -> Option<f64> {
    let mut found = motor.effects.iter().filter_map(|e| match e.enters() {
        Enters::Efficiency { loss } => Some(loss),
        _ => None,
    });
    let first = found.next()?;
    Some(found.fold(first, |a, b| a + b))
}

/// The gear of a continuous ratio with the numbers that were fitted for this motor: they replace those of
/// the requirement. `1/η = 1/η_fitted + γ`, `η_b = η_b fitted − γ`.
pub fn gear_with_fit(motor: &Motor, gear: &GearModel) -> GearModel {
    let (fitted, factor) = (motor.fitted_gear.unwrap_or_default(), load_dependent(motor));
    let mut gear = *gear;
    if let Some(inertia) = fitted.inertia {
        gear.inertia = inertia;
    }
    if fitted.efficiency.is_some() || factor.is_some() {
        let (own, factor) = (fitted.efficiency.unwrap_or(1.0), factor.unwrap_or(0.0));
        gear.efficiency = 1.0 / (1.0 / own + factor);
        gear.backdrive_efficiency = fitted.backdrive_efficiency.unwrap_or_else(|| backdrive_efficiency(own)) - factor;
    } else if let Some(backdrive) = fitted.backdrive_efficiency {
        gear.backdrive_efficiency = backdrive;
    }
    gear
}

/// How one thing that was fitted enters the limits of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The effect, or `gear`.
    pub effect: &'static str,
    /// How, in words.
    pub how: String,
}

/// How everything that was fitted for a motor enters the limits at a joint; empty for a catalogue row.
pub fn notes(motor: &Motor, joint: &Joint, hottest: Option<f64>) -> Vec<Note> {
    let listed = matches!(joint.ratio, RatioChoice::Catalog { .. });
    let mut notes: Vec<Note> = Vec::new();
    let mut add = |effect: &'static str, how: String| {
        if !notes.iter().any(|n| n.effect == effect) {
            notes.push(Note { effect, how });
        }
    };
    for fitted in &motor.effects {
        let how = match fitted.enters() {
            enters @ Enters::NotAtAll(_) => enters.detail(),
            _ if listed && fitted.effect.side() == Side::Gear => {
                "does not enter the limits: it belongs to the gear that was on the bench, and this joint takes gears of \
                 the catalogue"
                    .into()
            }
            Enters::TorqueConstant { .. } if hottest.is_none() => {
                "does not enter the limits: no highest temperature is known".into()
            }
            enters => enters.detail(),
        };
        add(fitted.name(), how);
    }
    let replaced = gear_with_fit(motor, &joint.gear);
    if !listed && replaced != joint.gear {
        let number = crate::words::number;
        let mut parts = Vec::new();
        if replaced.efficiency != joint.gear.efficiency {
            parts.push(("efficiency", replaced.efficiency, joint.gear.efficiency, ""));
        }
        if replaced.backdrive_efficiency != joint.gear.backdrive_efficiency {
            let (own, asked) = (replaced.backdrive_efficiency, joint.gear.backdrive_efficiency);
            parts.push(("backdrive efficiency", own, asked, ""));
        }
        if replaced.inertia != joint.gear.inertia {
            parts.push(("inertia", replaced.inertia, joint.gear.inertia, " kg*m^2"));
        }
        let said = parts.iter().map(|(what, own, asked, unit)| {
            format!("{what} {}{unit} in place of the requirement's {}{unit}", number(*own), number(*asked))
        });
        let how = format!("is the fitted one: {}", said.collect::<Vec<_>>().join(", "));
        add("gear", how);
    }
    if listed && motor.fitted_gear.is_some_and(|g| g.efficiency.is_some() || g.inertia.is_some()) {
        add("gear", "is not used: this joint takes gears of the catalogue".into());
    }
    notes
}

/// Torque and its rate that are folded into a sample at a ratio, motor side: the constant, `a |ω|` and
/// the drag, and the rate of the last two per N.
pub fn folded(
    motor: &Motor,
    form: &ShaftForm,
    ratio: f64,
    velocity: f64,
    towards: f64,
    acceleration: f64,
) -> (f64, f64) {
    let speed = ratio * velocity;
    let (torque, slope) = drag(motor, speed, towards);
    let asymmetry = form[Feature::Speed];
    let constant = form[Feature::One] + asymmetry * speed.abs() + torque;
    (constant, (asymmetry * towards + slope) * acceleration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Shape;

    /// T = K_T i_s tanh(i/i_s): the squared current against artanh, on both sides of where its series ends.
    #[test]
    fn the_squared_current_of_saturated_iron_is_that_of_its_curve() {
        let (k_t, i_s) = (0.13, 31.0);
        let mut shortfall = Shortfall::none(k_t);
        shortfall.saturation = Some(Saturation::new(k_t, i_s, k_t, Some(2.0 * i_s)));
        for share in [1e-9, 1e-3, 0.05, 0.1999, 0.2, 0.2001, 0.5, 0.9] {
            let torque: f64 = share * k_t * i_s;
            let (squared, slope) = shortfall.current_squared(torque * torque);
            let current = i_s * f64::atanh(share);
            assert!((squared / (current * current) - 1.0).abs() < 1e-14, "{share}");
            let expected = current / (k_t * (1.0 - share * share)) / torque;
            assert!((slope / expected - 1.0).abs() < 1e-14, "{share}");
        }
    }

    /// What an effect says of the limits is what the code does with it: none is left out of a list somewhere.
    #[test]
    fn every_effect_enters_the_limits_as_it_says() {
        let row = crate::catalog::Catalog::builtin().unwrap().motors.remove(0);
        let k_t = row.torque_constant;
        for effect in EFFECTS {
            let name = effect.name();
            let mut values = vec![0.01; effect.linear()];
            if effect.shape() != Shape::None {
                values.push(4.0);
            }
            let fitted = FittedEffect { effect: *effect, values: values.clone() };
            let motor = crate::catalog::Motor {
                viscous_friction: None,
                coulomb_friction: None,
                effects: vec![fitted.clone()],
                ..row.clone()
            };
            let mut form = ShaftForm::default();
            add_features(&motor, &mut form);
            let hot = hot_torque_constant(&motor, Some(motor.reference_temperature + 50.0));
            let here = [
                form != ShaftForm::default(),
                gear_with_fit(&motor, &GearModel::IDEAL) != GearModel::IDEAL,
                Shortfall::new(&motor, k_t, true) != Shortfall::none(k_t) || hot != k_t,
                evaluated(&motor).next().is_some() && why_evaluated(&motor).contains(name),
            ];
            let says = match fitted.enters() {
                Enters::Features(_) => [true, false, false, false],
                Enters::Efficiency { .. } => [false, true, false, false],
                Enters::Ripple(_)
                | Enters::RippleOfCurrent(_)
                | Enters::Saturation { .. }
                | Enters::Voltage(_)
                | Enters::TorqueConstant { .. } => [false, false, true, false],
                Enters::Evaluated(_) => [false, false, false, true],
                Enters::NotAtAll(_) => [false; 4],
            };
            assert_eq!(here, says, "{name}: in shaft torque, gear, bounds, evaluated");
            if matches!(fitted.enters(), Enters::Evaluated(_) | Enters::Features(_)) {
                for speed in [3.0, 30.0] {
                    let at = |speed: f64| effect.value(&values, &Operating::at_speed(speed));
                    let slope = fitted.speed_slope(&Operating::at_speed(speed));
                    let difference = (at(speed + 1e-4) - at(speed - 1e-4)) / 2e-4;
                    approx::assert_relative_eq!(slope, difference, max_relative = 1e-6, epsilon = 1e-9);
                }
            }
        }
    }
}
