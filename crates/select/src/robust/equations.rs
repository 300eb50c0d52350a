//! The equations of a limit over a box of tolerances, in interval arithmetic with derivatives.
//!
//! The one idea: the limits' own equations, evaluated once more with [`Number`]s, tell for each pair of limit and tolerance whether the
//! excess over the bound is monotone or convex. They are a second, independent statement of the model; it has to agree with the
//! program's numbers wherever both are evaluated ([`Equations::agrees`]), or it proves nothing.

use super::corners::{Place, Toleranced};
use super::derivative::{Interval, Number};
use gearwise_model::actuator::candidate::RATED_UP_TO;
use gearwise_model::actuator::limits::{Asked, Candidate, DRIVE_CONTINUOUS_CURRENT, Demand};
use gearwise_model::actuator::shaft::{End, FEATURE_POWER, FEATURES, Feature, Flow, ShaftForm};
use gearwise_model::actuator::thermal::{AT_20_DEGREES, TWENTY_DEGREES};
use gearwise_model::actuator::waveform::{Functional, WavePoint, Waveform};
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::drag::Drag;
use gearwise_model::catalog::module::constants::EfficiencyFrom;
use gearwise_model::effects::{Enters, Side};
use gearwise_model::numerics::work;
use gearwise_model::requirement::MotorDrag;

/// Relative difference up to which the equations agree with the program.
const AGREEMENT: f64 = 1e-7;

/// Steps of [`work`] for a sample without derivatives, and more of them for each derivative.
const PLAIN_STEPS: usize = 30;
const DERIVATIVE_STEPS: usize = 10;

type Form = Vec<Number>;

/// Demand and bound of a limit in the same quantity, of one sample.
pub struct Compared {
    /// Demand.
    pub demand: Number,
    /// Bound.
    pub bound: Number,
    /// True if both are squares.
    pub is_squared: bool,
}

impl Compared {
    /// Demand less bound.
    pub fn excess(&self) -> Number {
        &self.demand - &self.bound
    }
}

/// Reading of a catalogue entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The one that holds at the place.
    Actual,
    /// One of them, all over the box.
    Nth(usize),
}

/// A candidate whose motor has tolerances.
pub struct Equations<'e> {
    /// The candidate with the printed numbers.
    pub candidate: &'e Candidate<'e>,
    /// The tolerances.
    pub all: &'e [Toleranced],
}

/// The numbers of motor and gear over a box.
pub struct Machine {
    torque_constant: Number,
    torque: Vec<Form>,
    /// Quadrature voltage of the hottest winding and of the coldest.
    voltage: [Vec<Form>; 2],
    cross: Number,
    emf: Number,
    /// Loss per squared torque: of power taken with the hottest winding, and of power returned with the coldest.
    taken: Number,
    returned: Number,
    inertia: Number,
    /// Sum of amplitudes of ripple, its mean square, its share of the current and what that adds to the heat.
    ripple: Number,
    ripple_square: Number,
    proportional: Number,
    heat_factor: Number,
    /// Resistance at the reference temperature.
    resistance: Number,
    drag_at_rest: Number,
    lost: Number,
}

fn constant_form(form: &ShaftForm) -> Form {
    form.0.iter().map(|c| Number::constant(*c)).collect()
}

impl<'e> Equations<'e> {
    fn motor(&self) -> &Motor {
        self.candidate.motor
    }

    fn place(&self, place: Place) -> Option<usize> {
        self.all.iter().position(|t| t.place == place)
    }

    /// True if a column of the sheet has a tolerance.
    pub fn has(&self, column: &'static str) -> bool {
        self.place(Place::Sheet(column)).is_some()
    }

    /// A number of the box over a sub-box; `None` where it has no tolerance.
    fn number(&self, place: Place, over: &[Interval], derive: bool) -> Option<Number> {
        let index = self.place(place)?;
        let of = &self.all[index];
        let value = over[index].map(|share| of.at(share));
        let [low, high] = of.ends();
        Some(if derive { Number::coordinate(index, value, high - low) } else { Number::between(value) })
    }

    /// The factor by which a column of the sheet moves, over a sub-box.
    fn scale(&self, column: &'static str, over: &[Interval], derive: bool) -> Number {
        let nominal = self.place(Place::Sheet(column)).map_or(1.0, |index| self.all[index].value);
        match self.number(Place::Sheet(column), over, derive) {
            Some(number) if nominal != 0.0 => &number * (1.0 / nominal),
            _ => Number::constant(1.0),
        }
    }

    /// Deviation of a number from its nominal value, over a sub-box.
    fn moved(&self, place: Place, over: &[Interval], derive: bool) -> Option<Number> {
        let nominal = self.all[self.place(place)?].value;
        self.number(place, over, derive).map(|number| &number + -nominal)
    }

    /// Number of readings of the entry in the box: a speed constant gives the back-EMF constant where it is more precise than the torque constant's
    /// printed digits, and nothing where it does not.
    pub fn readings(&self) -> usize {
        let sheet = &self.motor().sheet;
        let both = sheet.torque_constant.is_some() && sheet.speed_constant.is_some();
        let open = both && sheet.back_emf_constant.is_none();
        if open && (self.has("speed_constant") || self.has("torque_constant")) { 2 } else { 1 }
    }

    /// The numbers of motor and gear over a sub-box, for one reading of the row; `None` where a tolerance enters them in a way that is not
    /// stated here.
    pub fn machine(&self, end: End, reading: Reading, over: &[Interval], derive: bool) -> Option<Machine> {
        let (candidate, motor) = (self.candidate, self.motor());
        let actuator = candidate.end(end);
        let scale = |column: &'static str| self.scale(column, over, derive);
        let moved = |place: Place| self.moved(place, over, derive);
        let sheet = &motor.sheet;
        let by_back_emf = || &scale("back_emf_constant") * motor.back_emf_constant;
        let by_speed = |nominal: f64| &scale("speed_constant").recip() * nominal;
        // The constant of the cold motor; that of the hottest differs from it by what the magnets lose.
        let cold = match (sheet.torque_constant, sheet.back_emf_constant) {
            (Some(_), _) => &scale("torque_constant") * motor.torque_constant,
            (None, Some(_)) => &scale("back_emf_constant") * motor.torque_constant,
            (None, None) => by_speed(motor.torque_constant),
        };
        let back_emf = match (sheet.torque_constant, sheet.back_emf_constant, sheet.speed_constant) {
            (_, Some(_), _) => by_back_emf(),
            (None, None, _) => cold.clone(),
            (Some(_), None, Some(_)) if self.readings() == 2 => {
                let convention = motor.conventions.speed_constant?;
                let nominal = convention.back_emf_constant(motor.conventions.commutation) / sheet.speed_constant?.value;
                let of_speed = by_speed(nominal);
                let counts = of_speed.value[1] > 1.01 * cold.value[0];
                match reading {
                    Reading::Nth(0) => cold.clone(),
                    Reading::Nth(_) => of_speed,
                    Reading::Actual if counts => of_speed,
                    Reading::Actual => cold.clone(),
                }
            }
            (Some(_), None, _) => match motor.back_emf_constant == motor.torque_constant {
                true => cold.clone(),
                false => Number::constant(motor.back_emf_constant),
            },
        };
        let emf = back_emf.max(&cold);
        let magnets = actuator.torque_constant - motor.torque_constant;
        let torque_constant = &cold + magnets;
        let resistance = &scale("resistance") * actuator.resistance;
        let factor = self.resistance_factor(self.hottest(over, derive), over, derive);
        let nominal_hot = actuator.hot_resistance / actuator.resistance;
        // A winding whose resistance was not told at its hottest has the printed one.
        let hot = match nominal_hot == 1.0 && !self.has("max_winding_temperature") && !self.has("reference_temperature")
        {
            true => resistance.clone(),
            false => &resistance * &factor,
        };
        let drive = actuator.resistance_per_torque() * actuator.torque_constant - actuator.hot_resistance;
        let per_ampere = torque_constant.recip();
        let inductance_factor = scale("inductance");
        let nominal_inductance = actuator.rate() * actuator.torque_constant;
        let inductance = match self.place(Place::Sheet("inductance")) {
            Some(index) if self.all[index].value == 0.0 => return None,
            _ => &inductance_factor * nominal_inductance,
        };
        let rate = &inductance * &per_ampere;
        // Torques that the shaft supplies.
        let mut torque: Vec<Form> = Flow::ALL.iter().map(|flow| constant_form(actuator.torque_form(*flow))).collect();
        let mut more = |feature: Feature, number: &Number| {
            torque.iter_mut().for_each(|form| form[feature as usize] = &form[feature as usize] + number);
        };
        let mut inertia = Number::constant(actuator.inertia);
        for place in [Place::Sheet("rotor_inertia"), Place::Gear("inertia")] {
            if let Some(moved) =
                moved(place).filter(|_| place == Place::Sheet("rotor_inertia") || candidate.catalog_gear.is_none())
            {
                more(Feature::Acceleration, &moved);
                inertia = &inertia + &moved;
            }
        }
        let mut at_rest = Number::constant(actuator.drag_form()[Feature::Sign]);
        if let Some(moved) = moved(Place::Sheet("viscous_friction")) {
            more(Feature::Velocity, &moved);
        }
        if let Some(moved) = moved(Place::Sheet("coulomb_friction")) {
            more(Feature::Sign, &moved);
            at_rest = &at_rest + &moved;
        }
        if let (Drag::NoLoad { torque: _, speed }, MotorDrag::Counted) = (motor.drag(), candidate.joint.motor_drag) {
            let whole = motor.no_load_torque?;
            // The torque of another entry of the motor has no tolerance, nor has its torque constant.
            let told = match sheet.no_load_current {
                Some(_) => &(&(&cold * (1.0 / motor.torque_constant)) * &scale("no_load_current")) * whole,
                None => Number::constant(whole),
            };
            let at_speed = sheet.no_load_speed.map_or(0.0, |p| p.value);
            let own = motor.viscous_friction.map(|viscous| {
                let viscous = &Number::constant(viscous)
                    + &moved(Place::Sheet("viscous_friction")).unwrap_or(Number::constant(0.0));
                &viscous * &(&scale("no_load_speed") * at_speed)
            });
            let nominal = motor.viscous_friction.map_or(whole, |viscous| (whole - viscous * at_speed).max(0.0));
            let friction = own.map_or(told.clone(), |own| (&told - &own).max(&Number::constant(0.0)));
            match (end, speed) {
                (End::Other, Some(speed)) => {
                    let viscous = &(&friction * &scale("no_load_speed").recip()) * (1.0 / speed);
                    more(Feature::Velocity, &(&viscous + -nominal / speed));
                }
                (End::Other, None) => return None,
                (End::First, _) => {
                    more(Feature::Sign, &(&friction + -nominal));
                    at_rest = &at_rest + &(&friction + -nominal);
                }
            }
        }
        let fitted = self.effects(over, derive, &torque_constant)?;
        for (feature, change) in &fitted.features {
            torque.iter_mut().for_each(|form| form[*feature] = &form[*feature] + change);
            if *feature == Feature::Sign as usize {
                at_rest = &at_rest + change;
            }
        }
        // Load torque through the gear's efficiency.
        let (driving, braking) = self.gear_changes(over, derive, &fitted.gear_loss, &emf)?;
        let load = Feature::Load as usize;
        torque[Flow::Driving as usize][load] = &torque[Flow::Driving as usize][load] + &driving;
        torque[Flow::Braking as usize][load] = &torque[Flow::Braking as usize][load] + &braking;
        let per_torque = &(&hot + drive) * &per_ampere;
        // The coldest winding is at ambient, and no hotter than the hottest; its magnets have lost nothing.
        let ambient = self.resistance_factor(Number::constant(candidate.robot.ambient), over, derive);
        let coldest = (&resistance * &ambient).min(&hot);
        let per_cold_torque = &(&coldest + drive) * &cold.recip();
        let voltage = [&per_torque, &per_cold_torque]
            .map(|per_torque| torque.iter().map(|form| voltage_form(form, per_torque, &rate, &emf)).collect());
        let per_square = per_ampere.square();
        let pole_pairs = motor.pole_pairs.map_or(0.0, f64::from);
        Some(Machine {
            cross: &(&inductance * &per_ampere) * pole_pairs,
            taken: &(&hot + drive) * &per_square,
            returned: &(&coldest + drive) * &per_square,
            torque,
            voltage,
            torque_constant,
            emf,
            inertia,
            resistance,
            drag_at_rest: at_rest,
            ripple: fitted.ripple,
            ripple_square: fitted.ripple_square,
            proportional: fitted.proportional,
            heat_factor: fitted.heat_factor,
            lost: fitted.lost,
        })
    }

    /// Highest temperature of the winding over a sub-box \[K\].
    fn hottest(&self, over: &[Interval], derive: bool) -> Number {
        let (nominal, _) = gearwise_model::actuator::limits::hottest(self.motor(), self.candidate.joint);
        match self.number(Place::Sheet("max_winding_temperature"), over, derive) {
            None => Number::constant(nominal),
            Some(own) => match self.candidate.joint.limits.winding_temperature {
                Some(asked) => own.min(&Number::constant(asked)),
                None => own,
            },
        }
    }

    /// Copper's resistance at a temperature over that of the printed one: (1 + α₂₀ (T − 20 °C))/(1 + α₂₀ (T₀ − 20 °C)).
    fn resistance_factor(&self, at: Number, over: &[Interval], derive: bool) -> Number {
        let reference = self
            .number(Place::Sheet("reference_temperature"), over, derive)
            .unwrap_or(Number::constant(self.motor().reference_temperature));
        let line = |t: &Number| &(&(t + -TWENTY_DEGREES) * AT_20_DEGREES) + 1.0;
        &line(&at) * &line(&reference).recip()
    }

    /// Resistance from winding to ambient over a sub-box \[K/W\], and the share of the winding's own part in it.
    fn thermal_resistances(&self, over: &[Interval], derive: bool) -> Option<(Number, Option<Number>)> {
        let (sheet, limits) = (&self.motor().sheet, &self.candidate.joint.limits);
        let of = |column: &'static str, nominal: Option<f64>| {
            nominal.map(|nominal| &self.scale(column, over, derive) * nominal)
        };
        let winding =
            of("thermal_resistance_winding_housing", sheet.thermal_resistance_winding_housing.map(|p| p.value));
        let row = of("thermal_resistance_housing_ambient", sheet.thermal_resistance_housing_ambient.map(|p| p.value));
        let housing = limits.mount_resistance.map(Number::constant).or(row);
        let toleranced =
            self.has("thermal_resistance_winding_housing") || self.has("thermal_resistance_housing_ambient");
        match (winding, housing) {
            (Some(winding), Some(housing)) => {
                let whole = &winding + &housing;
                // The share w/(w + h) as one function of the quotient, which is met once.
                let share = (&(&housing * &winding.recip()) + 1.0).recip();
                let share = if winding.value == [0.0; 2] { Number::constant(0.0) } else { share };
                Some((whole, Some(share)))
            }
            _ if toleranced => None,
            _ => self.candidate.thermal_resistance().map(|whole| (Number::constant(whole), None)),
        }
    }

    /// Fitted effects over a sub-box.
    fn effects(&self, over: &[Interval], derive: bool, torque_constant: &Number) -> Option<Fitted> {
        let (candidate, zero) = (self.candidate, Number::constant(0.0));
        let mut all = Fitted {
            features: Vec::new(),
            ripple: zero.clone(),
            ripple_square: zero.clone(),
            proportional: zero.clone(),
            heat_factor: Number::constant(1.0),
            lost: zero.clone(),
            gear_loss: zero.clone(),
        };
        let mut squares = zero.clone();
        for (instance, fitted) in self.motor().effects.iter().enumerate() {
            let place = |parameter: usize| Place::Effect { instance, parameter };
            let moves: Vec<usize> =
                (0..fitted.values.len()).filter(|parameter| self.place(place(*parameter)).is_some()).collect();
            let value = |parameter: usize| {
                self.number(place(parameter), over, derive).unwrap_or(Number::constant(fitted.values[parameter]))
            };
            let linear = fitted.effect.linear();
            // Sine and cosine of an order, or one amplitude.
            let amplitude = |nominal: f64| {
                let squares = (0..linear).fold(zero.clone(), |sum, k| &sum + &value(k).square());
                let amplitude = if moves.is_empty() { Number::constant(nominal) } else { squares.sqrt() };
                let norm = fitted.values[..linear].iter().map(|x| x * x).sum::<f64>().sqrt();
                let square = if moves.is_empty() { Number::constant(nominal * nominal) } else { squares };
                (moves.is_empty() || (norm - nominal).abs() <= 1e-12 * nominal.abs().max(f64::MIN_POSITIVE))
                    .then_some((amplitude, square))
            };
            let of_gear = fitted.effect.side() == Side::Gear && candidate.catalog_gear.is_some();
            match fitted.enters() {
                Enters::NotAtAll(_) => {}
                Enters::Features(own) => {
                    for parameter in moves {
                        // The features are linear in all parameters but the shape.
                        if parameter >= linear {
                            return None;
                        }
                        let mut unit = fitted.clone();
                        unit.values[parameter] += 1.0;
                        let Enters::Features(shifted) = unit.enters() else { return None };
                        let moved = self.moved(place(parameter), over, derive)?;
                        for feature in (0..FEATURES).filter(|f| shifted.0[*f] != own.0[*f]) {
                            all.features.push((feature, &moved * (shifted.0[feature] - own.0[feature])));
                        }
                    }
                }
                _ if of_gear && !matches!(fitted.enters(), Enters::Efficiency { .. }) => {}
                Enters::Ripple(nominal) => {
                    let (amplitude, square) = amplitude(nominal)?;
                    all.ripple = &all.ripple + &amplitude;
                    all.ripple_square = &all.ripple_square + &(&square * 0.5);
                }
                Enters::RippleOfCurrent(nominal) => {
                    let (amplitude, square) = amplitude(nominal)?;
                    all.proportional = &all.proportional + &(&amplitude * &torque_constant.recip());
                    squares = &squares + &(&square * &torque_constant.square().recip());
                }
                Enters::Voltage(nominal) => {
                    let lost = if moves.is_empty() { Number::constant(nominal) } else { value(0) };
                    if !moves.is_empty() && (linear != 1 || fitted.values[0] != nominal) {
                        return None;
                    }
                    all.lost = &all.lost + &lost;
                }
                Enters::Efficiency { loss } => {
                    if moves.is_empty() || candidate.catalog_gear.is_some() {
                        continue;
                    }
                    if linear != 1 || fitted.values[0] != loss {
                        return None;
                    }
                    all.gear_loss = &all.gear_loss + &self.moved(place(0), over, derive)?;
                }
                // Saturation is stated by whoever asks; a warm magnet and what is evaluated are not stated at all.
                Enters::Saturation { .. } if moves.is_empty() => {}
                Enters::TorqueConstant { .. }
                    if moves.is_empty()
                        && !self.has("max_winding_temperature")
                        && !self.has("reference_temperature") => {}
                Enters::Saturation { .. } | Enters::TorqueConstant { .. } | Enters::Evaluated(_) => return None,
            }
        }
        let left = &-&squares + 1.0;
        if squares.value != [0.0; 2] {
            all.heat_factor = (&left * &left.sqrt()).recip();
        }
        Some(all)
    }

    /// Changes of the load's coefficients while the motor drives and while it brakes.
    fn gear_changes(&self, over: &[Interval], derive: bool, loss: &Number, emf: &Number) -> Option<(Number, Number)> {
        let (candidate, motor) = (self.candidate, self.motor());
        let zero = Number::constant(0.0);
        if candidate.catalog_gear.is_none() {
            let own = self.number(Place::Gear("efficiency"), over, derive);
            let fitted = motor.fitted_gear.unwrap_or_default();
            let inverse = match (own, fitted.efficiency) {
                (Some(own), Some(nominal)) => &own.recip() + -1.0 / nominal,
                _ => zero.clone(),
            };
            let back =
                match (self.moved(Place::Gear("backdrive_efficiency"), over, derive), fitted.backdrive_efficiency) {
                    (Some(moved), _) => moved,
                    (None, Some(_)) => zero,
                    (None, None) => -&inverse,
                };
            return Some((&inverse + loss, &back - loss));
        }
        let Some(inside) = motor.inside.as_deref() else { return Some((zero.clone(), zero)) };
        let nominal = candidate.gear.efficiency;
        let measured = inside.gear_loss == Some(EfficiencyFrom::TorqueConstant);
        let rated = |column: &'static str| {
            let index = self.place(Place::Rating(column))?;
            Some(&self.number(Place::Rating(column), over, derive)? * (1.0 / self.all[index].value))
        };
        let mut share = Number::constant(1.0);
        if let Some(own) = rated("efficiency") {
            share = &share * &own;
        }
        if measured {
            let nominal_emf = motor.back_emf_constant;
            // The larger of both constants is used; here it has to be the entry's own.
            if nominal_emf < motor.torque_constant {
                return None;
            }
            share = &share * &(&emf.recip() * nominal_emf);
            if let Some(own) = rated("torque_constant") {
                share = &share * &own;
            }
        }
        if share.value == [1.0; 2] {
            return Some((zero.clone(), zero));
        }
        let efficiency = (&share * nominal).min(&Number::constant(1.0));
        let driving = &efficiency.recip() + -1.0 / nominal;
        let braking = match inside.gear.backdrive_efficiency {
            Some(_) => zero,
            None => -&driving,
        };
        Some((driving, braking))
    }
}

/// Fitted effects over a sub-box.
struct Fitted {
    features: Vec<(usize, Number)>,
    ripple: Number,
    ripple_square: Number,
    proportional: Number,
    heat_factor: Number,
    lost: Number,
    gear_loss: Number,
}

/// `v_q` as a linear form: resistance, inductance, and the back-EMF.
fn voltage_form(torque: &Form, per_torque: &Number, rate: &Number, emf: &Number) -> Form {
    let mut form: Form = torque.iter().map(|c| c * per_torque).collect();
    for (to, from) in [
        (Feature::LoadRate, Feature::Load),
        (Feature::Jerk, Feature::Acceleration),
        (Feature::Acceleration, Feature::Velocity),
        (Feature::SpeedRate, Feature::Speed),
    ] {
        form[to as usize] = &form[to as usize] + &(&torque[from as usize] * rate);
    }
    let velocity = Feature::Velocity as usize;
    form[velocity] = &form[velocity] + emf;
    form
}

/// A linear form at a sample and a ratio.
fn weighed(form: &Form, features: &[f64; FEATURES], ratio: &Number, down: &Number) -> Number {
    let mut by_power = [Number::constant(0.0), Number::constant(0.0), Number::constant(0.0)];
    for f in (0..FEATURES).filter(|f| features[*f] != 0.0 && form[*f].value != [0.0; 2]) {
        by_power[(FEATURE_POWER[f] + 1) as usize].add_scaled(&form[f], features[f]);
    }
    let [low, middle, high] = by_power;
    &(&(&low * down) + &middle) + &(&high * ratio)
}

impl Machine {
    fn torque(&self, point: &WavePoint, ratio: &Number, down: &Number) -> Number {
        weighed(&self.torque[point.flow as usize], &point.features, ratio, down)
    }

    /// A functional of a sample, its voltage with the hottest winding (0) or the coldest (1); `None` where it is not stated here.
    fn functional(&self, functional: Functional, point: &WavePoint, winding: usize, ratio: &Number) -> Option<Number> {
        if point.direct != 0.0 {
            return None;
        }
        let down = ratio.recip();
        let torque = self.torque(point, ratio, &down);
        let speed = ratio * point.features[Feature::Velocity as usize];
        let power = |loss: &Number| {
            let mechanical = &(&torque * &speed) * &(&self.emf * &self.torque_constant.recip());
            &(&torque.square() * loss) + &mechanical
        };
        Some(match functional {
            Functional::TorqueSquared | Functional::CurrentSquared => torque.square(),
            Functional::VoltageSquared => {
                let direct = &(&self.cross * &speed) * &torque;
                let quadrature = weighed(&self.voltage[winding][point.flow as usize], &point.features, ratio, &down);
                &quadrature.square() + &direct.square()
            }
            Functional::Power => power(&self.taken),
            Functional::PowerBack => -&power(&self.returned),
            Functional::LeastVoltage(_) | Functional::OpenVoltage(_) => return None,
        })
    }
}

/// Number of windings that a limit is computed with at each sample.
fn windings(asked: &Asked) -> usize {
    match asked.demand {
        Demand::Samples(Functional::VoltageSquared) | Demand::Bandwidth(Functional::VoltageSquared) => 2,
        _ => 1,
    }
}

impl<'e> Equations<'e> {
    /// Number of samples that a limit compares, each by itself: the voltage of both windings at each sample of the motion.
    pub fn samples(&self, asked: &Asked) -> usize {
        self.waveform(asked).map_or(1, |waveform| windings(asked) * waveform.len())
    }

    fn waveform(&self, asked: &Asked) -> Option<&'e Waveform> {
        match asked.demand {
            Demand::Samples(_) => Some(&self.candidate.load.waveform),
            Demand::Bandwidth(_) => self.candidate.load.bandwidth.as_ref(),
            _ => None,
        }
    }

    /// True if the torque is not proportional to the current and a tolerance moves the curve.
    fn bends(&self) -> bool {
        let shortfall = &self.candidate.actuator.shortfall;
        // A peak torque that is close to K_T I_peak may show saturation elsewhere in the box.
        let may = self.motor().about.peak_torque_of.is_some() && self.motor().peak_torque.is_some();
        let columns = ["torque_constant", "back_emf_constant", "speed_constant", "peak_current", "peak_torque"];
        (shortfall.saturates() || may) && columns.iter().any(|column| self.has(column))
    }

    /// Demand and bound of one sample of a limit over a sub-box and ratios; `None` where that is not stated here.
    pub fn compared(
        &self,
        asked: &Asked,
        machine: &Machine,
        sample: usize,
        ratio: &Number,
        over: &[Interval],
        derive: bool,
    ) -> Option<Compared> {
        let candidate = self.candidate;
        work::count(PLAIN_STEPS + if derive { over.len() * DERIVATIVE_STEPS } else { 0 });
        if candidate.is_evaluated() || asked.actuator.is_some() || candidate.map.is_some() {
            return None;
        }
        // The torque at a module's flange depends on its own inertia and ratings.
        let of_flange =
            |t: &Toleranced| matches!(t.place, Place::Rating(_)) || t.place == Place::Sheet("rotor_inertia");
        if asked.owner == "module" && asked.limit.name != "rated_torque" && self.all.iter().any(of_flange) {
            return None;
        }
        let kept = candidate.joint.limits.left_of(asked.limit.name);
        let safety = candidate.joint.limits.safety;
        let scale = |column: &'static str| self.scale(column, over, derive);
        let squared = |demand: Number, bound: Number| {
            let bound = bound.max(&Number::constant(0.0)).square();
            Compared { demand, bound, is_squared: true }
        };
        let plain = |demand: Number, bound: Number| Compared { demand, bound, is_squared: false };
        let saturates = candidate.actuator.shortfall.saturates();
        match asked.demand {
            Demand::Samples(functional) | Demand::Bandwidth(functional) => {
                if (saturates || self.bends()) && matches!(functional, Functional::VoltageSquared | Functional::Power) {
                    return None;
                }
                let windings = windings(asked);
                let point = self.waveform(asked)?.point(sample / windings);
                let demand = machine.functional(functional, &point, sample % windings, ratio)?;
                Some(match functional {
                    Functional::TorqueSquared if asked.limit.name == "peak_torque" => {
                        let most = &scale("peak_torque") * self.motor().peak_torque?;
                        let left = &(&most * &(&-&machine.proportional + 1.0)) - &(&machine.ripple * safety);
                        squared(demand, &left * (kept / safety))
                    }
                    Functional::TorqueSquared | Functional::CurrentSquared => {
                        if saturates || self.bends() {
                            return None;
                        }
                        let own = self.motor().peak_current.map(|i| &scale("peak_current") * i);
                        let drive = candidate.drive_current().zip(candidate.joint.turns.of_current());
                        let drive = drive.map(|(i, times)| Number::constant(i * times));
                        let most = match (own, drive) {
                            (Some(own), Some(drive)) => own.min(&drive),
                            (own, drive) => own.or(drive)?,
                        };
                        let torque = &most * &machine.torque_constant;
                        let left = &(&torque * &(&-&machine.proportional + 1.0)) - &(&machine.ripple * safety);
                        squared(demand, &left * (kept / safety))
                    }
                    Functional::VoltageSquared => {
                        let lost = candidate.actuator.shortfall.voltage;
                        let left = &-&machine.lost + (candidate.voltage() + lost);
                        if candidate.voltage() == 0.0 {
                            return None;
                        }
                        squared(demand, &left * kept)
                    }
                    Functional::Power | Functional::PowerBack => {
                        plain(demand, Number::constant(asked.bound / asked.factor))
                    }
                    Functional::LeastVoltage(_) | Functional::OpenVoltage(_) => return None,
                })
            }
            Demand::Polynomial(nominal, _) => {
                let mean = |standing: f64| self.mean_square(machine, ratio, &Number::constant(standing));
                let rated = || {
                    let rated = &scale("continuous_current") * self.motor().continuous_current?;
                    Some(&rated * &self.derating(over, derive)).filter(|_| !candidate.is_mounted())
                };
                let amperes = |mean: Number, bound: Number| {
                    // In torque, so that the constant is met once.
                    let demand = &mean * &machine.heat_factor;
                    squared(demand, &(&bound * &machine.torque_constant) * kept)
                };
                if saturates || self.bends() {
                    return None;
                }
                match asked.limit.name {
                    "continuous_current" => Some(amperes(mean(0.0), rated()?)),
                    name if name == DRIVE_CONTINUOUS_CURRENT => {
                        let (current, times) =
                            candidate.drive_continuous_current().zip(candidate.joint.turns.of_current())?;
                        Some(amperes(mean(0.0), Number::constant(current * times)))
                    }
                    "winding_temperature" => Some(amperes(mean(0.0), self.thermal_current(machine, over, derive)?)),
                    // The time constant decides what is slow.
                    "standstill_holding"
                        if candidate.load.counts_slow_motion() && self.has("thermal_time_constant_winding") =>
                    {
                        None
                    }
                    "standstill_holding" => {
                        let thermal = match candidate.thermal_resistance() {
                            Some(_) => Some(self.thermal_current(machine, over, derive)?),
                            None => None,
                        };
                        let bound = match (rated(), thermal) {
                            (Some(a), Some(b)) => Some(a.min(&b)),
                            (a, b) => a.or(b),
                        };
                        let standing = match candidate.standing_share() {
                            0.0 => Number::constant(0.0),
                            nominal => match self.thermal_resistances(over, derive) {
                                Some((_, share)) => share.unwrap_or(Number::constant(nominal)),
                                None if candidate.thermal_resistance().is_none() => Number::constant(nominal),
                                None => return None,
                            },
                        };
                        let mean = self.mean_square(machine, ratio, &standing);
                        Some(match bound {
                            Some(bound) => amperes(mean, bound),
                            // A motor with a continuous torque alone is bounded by that.
                            None => squared(mean, &self.continuous_torque(over, derive)? * kept),
                        })
                    }
                    "continuous_torque" => Some(squared(mean(0.0), &self.continuous_torque(over, derive)? * kept)),
                    "open_circuit_voltage" => {
                        let per_emf = candidate.open_circuit_per_speed() / self.motor().emf_constant();
                        let speed = candidate.load.peak_speed.0;
                        let demand = &(ratio * (speed * per_emf)) * &machine.emf;
                        Some(plain(demand, Number::constant(asked.bound)))
                    }
                    "max_speed" => {
                        let bound = &scale("max_speed") * (self.motor().max_speed? * kept);
                        Some(plain(ratio * candidate.load.peak_speed.0, bound))
                    }
                    "reflected_inertia" => {
                        // a N² + c, of which a is in proportion to the inertia at the shaft.
                        let (one, two) = (nominal.at(1.0), nominal.at(2.0));
                        let (slope, rest) = ((two - one) / 3.0, one - (two - one) / 3.0);
                        let inertia = &machine.inertia * (slope / candidate.actuator.inertia);
                        if candidate.actuator.inertia <= 0.0 {
                            return None;
                        }
                        Some(plain(&(&inertia * &ratio.square()) + rest, Number::constant(asked.bound)))
                    }
                    "backdriving_torque" => {
                        if candidate.has_evaluated_effects() || self.all.iter().any(|t| t.is_of_gear()) {
                            return None;
                        }
                        let (one, two) = (nominal.at(1.0), nominal.at(2.0));
                        let (slope, rest) = (two - one, 2.0 * one - two);
                        let own = candidate.end(asked.end).drag_form()[Feature::Sign];
                        let passes = candidate
                            .joint
                            .passed
                            .as_deref()
                            .map_or(1.0, |p| p.levers.backdriving / p.numbers.backdrive_efficiency);
                        let per_torque = passes / candidate.gear.backdrive_efficiency;
                        let more = &(&machine.drag_at_rest + -own) * per_torque;
                        Some(plain(&(ratio * &(&more + slope)) + rest, Number::constant(asked.bound)))
                    }
                    "gear_average_speed" | "gear_life" | "gear_input_speed" => {
                        let (one, two) = (nominal.at(1.0), nominal.at(2.0));
                        let demand = &(ratio * (two - one)) + (2.0 * one - two);
                        Some(plain(&demand * asked.factor, Number::constant(asked.bound)))
                    }
                    _ => None,
                }
            }
            Demand::Fixed(..) if asked.limit.name == "rated_torque" => {
                let inside = self.motor().inside.as_deref()?;
                let inertia = &machine.inertia * inside.gear.ratio.powi(2);
                let at = candidate.actuator.inertia * inside.gear.ratio.powi(2);
                // A square of τ + J α in the mean: told from three inertias.
                let [zero, one, two] = [0.0, at, 2.0 * at].map(|j| candidate.load.flange_mean_square(j));
                let demand = match at > 0.0 {
                    true => {
                        let bend = (two - 2.0 * one + zero) / (2.0 * at * at);
                        let slope = (one - zero) / at - bend * at;
                        &(&(&inertia.square() * bend) + &(&inertia * slope)) + zero
                    }
                    false => Number::constant(zero),
                };
                let rated = inside.module.sheet.rated_torque?.value;
                let bound = self.number(Place::Rating("rated_torque"), over, derive).unwrap_or(Number::constant(rated));
                let bound = &bound * &self.derating(over, derive);
                Some(squared(&demand * candidate.load.share_of_time, &bound * kept))
            }
            // Its bound falls with the highest temperature of the winding where the surroundings are hot.
            Demand::Fixed(..)
                if asked.limit.name == "overload"
                    && self.has("max_winding_temperature")
                    && candidate.robot.ambient > RATED_UP_TO =>
            {
                None
            }
            Demand::Fixed(value, _) | Demand::Constant(value) | Demand::AverageTorque(value) => {
                Some(plain(Number::constant(value * asked.factor), Number::constant(asked.bound)))
            }
            Demand::Mass => {
                let nominal = self.motor().mass?;
                let own = &(&scale("mass") + -1.0) * nominal;
                let whole = match ratio.value {
                    [low, high] if low == high => Number::constant(candidate.known_mass_at(low)),
                    [low, high] => {
                        let [a, b] = [low, high].map(|n| candidate.known_mass_at(n));
                        Number::between([a.min(b), a.max(b)])
                    }
                };
                Some(plain(&own + &whole, Number::constant(asked.bound)))
            }
            Demand::Parts(whole) => {
                let column = match asked.limit.name {
                    "outer_diameter" => "outer_diameter",
                    "axial_length" => "length",
                    _ => {
                        return Some(plain(
                            Number::constant(whole.known * asked.factor),
                            Number::constant(asked.bound),
                        ));
                    }
                };
                match self.moved(Place::Sheet(column), over, derive) {
                    None => Some(plain(Number::constant(whole.known * asked.factor), Number::constant(asked.bound))),
                    // A part that is larger already stays as it is; a sum is at most this.
                    Some(moved) if column == "length" => {
                        Some(plain(&(&moved + whole.known) * asked.factor, Number::constant(asked.bound)))
                    }
                    Some(moved) => {
                        let nominal = self.all[self.place(Place::Sheet(column))?].value;
                        let rest = if whole.known > nominal { whole.known } else { 0.0 };
                        let across = (&moved + nominal).max(&Number::constant(rest));
                        Some(plain(&across * asked.factor, Number::constant(asked.bound)))
                    }
                }
            }
            Demand::WindingPeak(_) | Demand::MeanCurrentSquared(_) => None,
        }
    }

    /// Mean of the squared torque \[N²·m²\] over all of the time.
    fn mean_square(&self, machine: &Machine, ratio: &Number, standing: &Number) -> Number {
        let (load, down) = (self.candidate.load, ratio.recip());
        work::count(load.means().len() * (PLAIN_STEPS + self.all.len() * DERIVATIVE_STEPS));
        let (mut moving, mut standstill, mut at_rest) = (Number::constant(0.0), Number::constant(0.0), 0.0);
        for (k, (point, share)) in load.means().enumerate() {
            let square = machine.torque(point, ratio, &down).square();
            let rest = load.share(k, 1.0) - share;
            moving.add_scaled(&square, share);
            if rest != 0.0 {
                standstill.add_scaled(&square, rest);
                at_rest += rest;
            }
        }
        let moving = &moving + &machine.ripple_square;
        let standstill = &standstill + &(&machine.ripple_square * at_rest);
        &(&moving + &(&standstill * standing)) * load.share_of_time
    }

    /// Continuous torque \[N·m\]; `None` without one, or behind a mount of its own.
    fn continuous_torque(&self, over: &[Interval], derive: bool) -> Option<Number> {
        let rated = self.motor().continuous_torque.filter(|_| !self.candidate.is_mounted())?;
        Some(&(&self.scale("continuous_torque", over, derive) * rated) * &self.derating(over, derive))
    }

    /// Derating of a continuous rating above 40 °C ambient.
    fn derating(&self, over: &[Interval], derive: bool) -> Number {
        let ambient = self.candidate.robot.ambient;
        match self.number(Place::Sheet("max_winding_temperature"), over, derive) {
            Some(hottest) if ambient > RATED_UP_TO => {
                let left = (&hottest + -ambient).max(&Number::constant(0.0));
                // (h − a)/(h − r) = 1 − (a − r)/(h − r), in which h is met once.
                let ratio = &(&(&hottest + -RATED_UP_TO).recip() * (RATED_UP_TO - ambient)) + 1.0;
                if left.value[0] > 0.0 { ratio.sqrt() } else { left.either(&ratio) }
            }
            _ => Number::constant(self.candidate.derating()),
        }
    }

    /// Current that heats the winding to its limit in steady state \[A\].
    fn thermal_current(&self, machine: &Machine, over: &[Interval], derive: bool) -> Option<Number> {
        let limit = &self.hottest(over, derive) + -self.candidate.joint.limits.temperature_reserve;
        let (whole, _) = self.thermal_resistances(over, derive)?;
        let hot = &self.resistance_factor(limit.clone(), over, derive) * &machine.resistance;
        let rise = &limit + -self.candidate.robot.ambient;
        Some((&rise * &(&whole * &hot).recip()).sqrt())
    }

    /// The heat of each sample of the motion over a sub-box, of a limit that rises with each of them and is convex in all of them together:
    /// the temperature of a winding, and the mean of a squared current where the iron saturates. `None` where a tolerance enters in
    /// another way too.
    pub fn heats(&self, asked: &Asked, machine: &Machine, ratio: &Number) -> Option<Vec<Number>> {
        let candidate = self.candidate;
        if candidate.is_evaluated() || asked.actuator.is_some() || candidate.map.is_some() || self.bends() {
            return None;
        }
        let thermal = [
            "thermal_resistance_winding_housing",
            "thermal_resistance_housing_ambient",
            "thermal_time_constant_winding",
            "thermal_time_constant_housing",
            "reference_temperature",
        ];
        let bounds = ["continuous_current", "continuous_torque"];
        let ripples = candidate.motor.effects.iter().enumerate().any(|(instance, e)| {
            let moves = self.all.iter().any(|t| matches!(t.place, Place::Effect { instance: i, .. } if i == instance));
            moves && matches!(e.enters(), Enters::Ripple(_) | Enters::RippleOfCurrent(_))
        });
        let factor = match asked.demand {
            Demand::WindingPeak(_) if thermal.iter().any(|column| self.has(column)) || ripples => return None,
            Demand::WindingPeak(_) => &machine.resistance * &machine.torque_constant.square().recip(),
            Demand::MeanCurrentSquared(_) => {
                let moves = |columns: &[&'static str]| columns.iter().any(|column| self.has(column));
                if ripples || moves(&thermal) || moves(&bounds) || moves(&["max_winding_temperature", "resistance"]) {
                    return None;
                }
                Number::constant(1.0)
            }
            _ => return None,
        };
        let down = ratio.recip();
        work::count(candidate.load.means().len() * (PLAIN_STEPS + self.all.len() * DERIVATIVE_STEPS));
        Some(candidate.load.means().map(|(point, _)| &machine.torque(point, ratio, &down).square() * &factor).collect())
    }

    /// True if the equations say the same of a limit as the program does at a place of the box and a ratio.
    pub fn agrees(&self, asked: &Asked, at: &[f64], there: (&Candidate, &Asked), ratio: f64) -> bool {
        let over: Vec<Interval> = at.iter().map(|share| [*share; 2]).collect();
        let Some(machine) = self.machine(asked.end, Reading::Actual, &over, false) else { return false };
        let n = Number::constant(ratio);
        let mut worst: Option<(f64, f64, f64)> = None;
        let mut is_squared = false;
        for sample in 0..self.samples(asked) {
            let Some(both) = self.compared(asked, &machine, sample, &n, &over, false) else { return false };
            let (demand, bound) = (both.demand.value[1], both.bound.value[0]);
            is_squared = both.is_squared;
            if worst.is_none_or(|(excess, ..)| demand - bound > excess) {
                worst = Some((demand - bound, demand, bound));
            }
        }
        let Some((_, demand, bound)) = worst else { return false };
        let (candidate, asked) = there;
        let (mut raw, mut limit) = (asked.raw_demand(candidate, ratio).0, asked.at(candidate, ratio).raw_bound());
        if is_squared && !asked.squared {
            (raw, limit) = (raw * raw, limit * limit);
        }
        let close = |a: f64, b: f64| (a - b).abs() <= AGREEMENT * a.abs().max(b.abs()).max((limit * bound).abs());
        // In another quantity than the program's both are the same share of each other.
        match limit == 0.0 || bound == 0.0 {
            true => limit == bound && close(demand, raw),
            false => close(demand * limit, raw * bound),
        }
    }
}
