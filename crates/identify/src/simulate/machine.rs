//! The machine and one step of it in time.

use gearwise_model::effects::{Effect, Equation, Operating};

/// By what share of the current without losses an equation of it may be off.
const EXACT: f64 = 1e-9;
/// Most steps to solve it.
const MOST_STEPS: usize = 60;

/// An effect with its values.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Its values: the linear ones, then the shape.
    pub values: Vec<f64>,
    /// Whether it jumps with the direction of motion, so that it can hold the machine.
    is_dry: bool,
}

impl Term {
    /// An effect with its values.
    pub fn new(effect: &'static dyn Effect, values: Vec<f64>) -> Term {
        let at = |direction| Operating {
            speed: 0.0,
            direction,
            angle: 0.0,
            output_angle: 0.0,
            current: 0.0,
            torque: 1.0,
            torque_curvature: 0.0,
            winding_rise: 0.0,
            housing_rise: 0.0,
            duty: 0.0,
        };
        let shape = values.get(effect.linear()).copied().unwrap_or(1.0);
        let is_dry = effect.basis(shape, &at(1.0)) != effect.basis(shape, &at(0.0));
        Term { effect, values, is_dry }
    }
}

impl std::fmt::Debug for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:?}", self.effect.name(), self.values)
    }
}

/// A motor with its gear, in SI; motor side unless said. On a linear axis metres, newtons and kilograms, and
/// a ratio of one.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Ratio N.
    pub ratio: f64,
    /// Torque constant K_T \[N·m/A\].
    pub torque_constant: f64,
    /// Resistance R \[Ω\]; only a machine driven by a voltage asks for it.
    pub resistance: f64,
    /// Back-EMF constant K_B \[V·s/rad\].
    pub back_emf: f64,
    /// Torque per speed that opposes motion beside the effects \[N·m·s/rad\]: with a voltage at the
    /// terminals it holds the back-EMF, K_T K_B/R.
    pub damping: f64,
    /// Inertia of rotor and gear \[kg·m²\].
    pub inertia: f64,
    /// Delay between the measurement of a controller, or a logged input, and its effect \[s\].
    pub lag: f64,
    /// Effects.
    pub terms: Vec<Term>,
}

/// What acts on the machine at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Current \[A\] of a machine driven by current, voltage \[V\] of one driven by voltage.
    pub input: f64,
    /// Whether the input is a voltage.
    pub is_voltage: bool,
    /// Whether the terminals are open.
    pub is_open: bool,
    /// Duty cycle.
    pub duty: f64,
    /// Inertia of the load at the output \[kg·m²\].
    pub load_inertia: f64,
    /// Gravity torque amplitude of the load \[N·m\].
    pub load_gravity: f64,
    /// Winding temperature over the reference \[K\].
    pub winding_rise: f64,
    /// Housing temperature over the reference \[K\].
    pub housing_rise: f64,
}

/// Position and speed at the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Position \[rad\].
    pub position: f64,
    /// Speed \[rad/s\].
    pub speed: f64,
}

/// Forces at the output, as far as they do not jump.
struct Forces {
    /// Drive less smooth effects, without the linear damping \[N·m\].
    given: f64,
    /// Linear damping \[N·m·s/rad\].
    damping: f64,
    /// Weight of the load \[N·m\].
    weight: f64,
    /// Inertia of all that moves \[kg·m²\].
    inertia: f64,
    load_inertia: f64,
}

impl Forces {
    /// What pushes at standstill.
    fn net(&self) -> f64 {
        self.given - self.weight
    }

    /// Acceleration in a direction at a speed under dry friction `constant + factor·|τ|`. The transmitted
    /// torque τ has the acceleration in it: its sign is that without the factor, and where the factor would
    /// turn it, it is zero.
    fn acceleration(&self, direction: f64, speed: f64, (constant, factor): (f64, f64)) -> f64 {
        let push = self.net() - self.damping * speed - direction * constant;
        let plain = push / self.inertia;
        if factor == 0.0 {
            return plain;
        }
        let sign = (self.weight + self.load_inertia * plain).signum();
        let part = direction * factor * sign;
        let acceleration = (push - part * self.weight) / (self.inertia + part * self.load_inertia);
        if (self.weight + self.load_inertia * acceleration) * sign < 0.0 { plain } else { acceleration }
    }
}

impl Machine {
    /// The rate at which speed decays at most \[1/s\]: a step in time has to be shorter.
    pub fn fastest(&self, load_inertia: f64) -> f64 {
        let n = self.ratio;
        let inertia = n * n * self.inertia + load_inertia;
        let at = |speed: f64| Operating { speed, direction: 1.0, ..Operating::UNKNOWN };
        let viscous: f64 = self
            .terms
            .iter()
            .map(|t| t.effect.value(&t.values, &at(1.0)) - t.effect.value(&t.values, &at(0.0)))
            .filter(|v| v.is_finite())
            .map(f64::abs)
            .sum();
        n * n * (self.damping.abs() + viscous) / inertia.max(f64::MIN_POSITIVE)
    }

    /// Current at a voltage and a speed, and the voltage that effects take away.
    fn current(&self, sample: &Sample, at: &Operating) -> (f64, f64) {
        let open = (sample.input - self.back_emf * at.speed) / self.resistance;
        let drop = |current: f64| -> f64 {
            let at = Operating { current, ..*at };
            let of = |t: &Term| t.effect.value(&t.values, &at);
            self.terms.iter().filter(|t| t.effect.acts_on() == Equation::Voltage).map(of).sum()
        };
        let lost = drop(open);
        if lost == 0.0 || open == 0.0 {
            return (open, lost);
        }
        // i + u(i)/R = i_open: exact where the drop is proportional, then one secant.
        let first = open / (1.0 + lost / (self.resistance * open)).max(0.05);
        let left = |i: f64, u: f64| i + u / self.resistance - open;
        let (far, near) = (left(open, lost), left(first, drop(first)));
        let slope = (far - near) / (open - first);
        let current = if slope.is_finite() && slope > 0.5 { first - near / slope } else { first };
        let lost = drop(current);
        let off = |left: f64| left.abs() > EXACT * open.abs();
        if !off(left(current, lost)) {
            return (current, lost);
        }
        // A drop that is large beside the voltage, as dead time at low duty: between no current and all of it, by the false
        // position that halves what stays (the Illinois rule).
        let (mut low, mut high) = ((0.0, left(0.0, drop(0.0))), (open, far));
        if low.1 * high.1 > 0.0 {
            return (current, lost);
        }
        let mut between = current;
        for _ in 0..MOST_STEPS {
            between = high.0 - high.1 * (high.0 - low.0) / (high.1 - low.1);
            let now = left(between, drop(between));
            if !off(now) {
                break;
            }
            if now * high.1 < 0.0 {
                low = high
            } else {
                low.1 *= 0.5
            }
            high = (between, now);
        }
        (between, drop(between))
    }

    fn forces(&self, state: State, position: f64, sample: &Sample) -> (Forces, Operating) {
        let n = self.ratio;
        let mut at = Operating {
            speed: n * state.speed,
            direction: 0.0,
            angle: n * position,
            output_angle: position,
            current: sample.input,
            torque: 0.0,
            torque_curvature: f64::NAN,
            winding_rise: sample.winding_rise,
            housing_rise: sample.housing_rise,
            duty: sample.duty,
        };
        let (mut torque, mut damping) = (0.0, self.damping);
        if sample.is_open {
            at.current = 0.0;
            damping = (damping - self.torque_constant * self.back_emf / self.resistance).max(0.0);
        } else if sample.is_voltage {
            let (current, lost) = self.current(sample, &at);
            at.current = current;
            torque = self.torque_constant * (sample.input - lost) / self.resistance;
        } else {
            torque = self.torque_constant * sample.input;
        }
        let smooth = |t: &&Term| !t.is_dry && t.effect.acts_on() == Equation::Torque;
        let drag: f64 = self.terms.iter().filter(smooth).map(|t| t.effect.value(&t.values, &at)).sum();
        let weight = if sample.load_gravity == 0.0 { 0.0 } else { sample.load_gravity * position.sin() };
        let forces = Forces {
            given: n * (torque - drag),
            damping: n * n * damping,
            weight,
            inertia: n * n * self.inertia + sample.load_inertia,
            load_inertia: sample.load_inertia,
        };
        (forces, at)
    }

    /// Dry friction at the output at a speed: a constant \[N·m\] and a factor of the transmitted torque.
    fn dry(&self, at: &Operating, speed: f64) -> (f64, f64) {
        let (mut constant, mut factor) = (0.0, 0.0);
        let point = Operating { speed: self.ratio * speed, direction: 1.0, torque: 0.0, ..*at };
        let loaded = Operating { torque: 1.0, ..point };
        for term in self.terms.iter().filter(|t| t.is_dry) {
            let bare = term.effect.value(&term.values, &point);
            constant += self.ratio * bare;
            factor += term.effect.value(&term.values, &loaded) - bare;
        }
        (constant, factor)
    }

    /// One step in time \[s\]: semi-implicit, with what jumps at standstill as a set of values.
    pub fn step(&self, state: State, sample: &Sample, h: f64) -> State {
        let middle = state.position + 0.5 * h * state.speed;
        let (forces, at) = self.forces(state, middle, sample);
        let implicit = 1.0 + 0.5 * h * forces.damping / forces.inertia;
        let rest = self.dry(&at, 0.0);
        let hold = rest.0 + rest.1 * forces.weight.abs();
        let sticks = forces.net().abs() <= hold;
        if state.speed == 0.0 {
            if sticks {
                return state;
            }
            let speed = h * forces.acceleration(forces.net().signum(), 0.0, rest) / implicit;
            return State { position: state.position + 0.5 * h * speed, speed };
        }
        let friction = if rest == (0.0, 0.0) { rest } else { self.dry(&at, state.speed) };
        let change = h * forces.acceleration(state.speed.signum(), state.speed, friction) / implicit;
        let speed = state.speed + change;
        if speed * state.speed >= 0.0 || rest == (0.0, 0.0) {
            return State { position: state.position + 0.5 * h * (state.speed + speed), speed };
        }
        // It comes to rest within the step: there it stays or goes on the other way.
        let stop = -h * state.speed / change;
        let position = state.position + 0.5 * stop * state.speed;
        if sticks {
            return State { position, speed: 0.0 };
        }
        let left = h - stop;
        let speed = left * forces.acceleration(forces.net().signum(), 0.0, rest);
        State { position: position + 0.5 * left * speed, speed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::steady::moving;
    use crate::simulate::model::declared_machine;
    use gearwise_model::effects::effect;

    /// Ohm's law with dead time, from far below the lost voltage to far above it: what the resistance and the drop take is the
    /// voltage, and a lost voltage drives no current backwards.
    #[test]
    fn current_and_dead_time_take_the_voltage_between_them() {
        let mut machine = declared_machine(&moving(600, false).declared, true);
        machine.resistance = 1.2;
        machine.terms = vec![Term::new(effect("inverter_dead_time").unwrap(), vec![1.0, 0.1])];
        let at = |volts: f64| {
            let sample = Sample {
                input: volts,
                is_voltage: true,
                is_open: false,
                duty: 1.0,
                load_inertia: 0.0,
                load_gravity: 0.0,
                winding_rise: 0.0,
                housing_rise: 0.0,
            };
            machine.current(&sample, &Operating::at_speed(0.0))
        };
        for volts in [0.01, 0.1, 0.5, 0.8, 1.0, 1.2, 2.0, 12.0] {
            let (current, lost) = at(volts);
            assert!((1.2 * current + (current / 0.1).tanh() - volts).abs() < 1e-8 * volts, "{volts}: {current}");
            assert!(current > 0.0 && (lost - (current / 0.1).tanh()).abs() < 1e-9);
            assert_eq!(at(-volts), (-current, -lost));
        }
        assert_eq!(at(0.0), (0.0, 0.0));
    }
}
