//! The machine as physics has it, stepped finely in time.
//!
//! One step function for each kind of bench. Friction is a bristle (LuGre) whose equation is solved
//! exactly over a step, so that it stays stable at any speed; gear and load are two masses stepped by
//! Runge and Kutta where a spring or a gap is between them.

use super::profile::Profile;
use super::random::Random;
use std::f64::consts::{PI, TAU};

/// Temperature that resistance and torque constant refer to \[°C\].
pub const REFERENCE: f64 = 25.0;
/// Copper \[1/K\].
pub const COPPER: f64 = 0.003_93;

/// What a log shows beside what the catalogue row says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    ViscousFriction,
    CoulombFriction,
    StribeckFriction,
    LoadDependentFriction,
    DirectionAsymmetry,
    EddyDrag,
    Cogging {
        order: u32,
    },
    TorqueRipple {
        order: u32,
    },
    GearRipple {
        order: u32,
    },
    TorqueConstantSaturation,
    TorqueConstantTemperature,
    WindingTemperature,
    InverterDeadTime,
    Gravity,
    TorqueOffset,
    GearCompliance,
    Backlash,
    SupplySag,
    /// Outside the library: 50 Hz on the target's channel.
    Hum,
    /// Outside: the sensor's zero jumps once within each log.
    ZeroStep,
    /// Outside: Coulomb friction that wears off over a log.
    RunIn,
    /// Outside: a sum of random steps on the target's channel.
    RandomWalk,
    /// Outside: drag with the third power of speed.
    CubicDrag,
    /// Outside: the sensor remembers its load (Bouc and Wen).
    LoadMemory,
}

impl Effect {
    /// The library's eighteen.
    pub const LIBRARY: [Effect; 18] = [
        Effect::ViscousFriction,
        Effect::CoulombFriction,
        Effect::StribeckFriction,
        Effect::LoadDependentFriction,
        Effect::DirectionAsymmetry,
        Effect::EddyDrag,
        Effect::Cogging { order: 12 },
        Effect::TorqueRipple { order: 42 },
        Effect::GearRipple { order: 2 },
        Effect::TorqueConstantSaturation,
        Effect::TorqueConstantTemperature,
        Effect::WindingTemperature,
        Effect::InverterDeadTime,
        Effect::Gravity,
        Effect::TorqueOffset,
        Effect::GearCompliance,
        Effect::Backlash,
        Effect::SupplySag,
    ];

    /// Those that no effect of the library explains.
    pub const OUTSIDE: [Effect; 6] =
        [Effect::Hum, Effect::ZeroStep, Effect::RunIn, Effect::RandomWalk, Effect::CubicDrag, Effect::LoadMemory];

    /// The name that `identify` gives it, or would.
    pub fn name(self) -> &'static str {
        match self {
            Effect::ViscousFriction => "viscous_friction",
            Effect::CoulombFriction => "coulomb_friction",
            Effect::StribeckFriction => "stribeck_friction",
            Effect::LoadDependentFriction => "load_dependent_friction",
            Effect::DirectionAsymmetry => "direction_asymmetry",
            Effect::EddyDrag => "eddy_drag",
            Effect::Cogging { .. } => "cogging",
            Effect::TorqueRipple { .. } => "torque_ripple",
            Effect::GearRipple { .. } => "gear_ripple",
            Effect::TorqueConstantSaturation => "torque_constant_saturation",
            Effect::TorqueConstantTemperature => "torque_constant_temperature",
            Effect::WindingTemperature => "winding_temperature",
            Effect::InverterDeadTime => "inverter_dead_time",
            Effect::Gravity => "gravity",
            Effect::TorqueOffset => "torque_offset",
            Effect::GearCompliance => "gear_compliance",
            Effect::Backlash => "backlash",
            Effect::SupplySag => "supply_sag",
            Effect::Hum => "hum",
            Effect::ZeroStep => "zero_step",
            Effect::RunIn => "run_in",
            Effect::RandomWalk => "random_walk",
            Effect::CubicDrag => "cubic_drag",
            Effect::LoadMemory => "load_memory",
        }
    }

    /// The effect of a name, with a usual order.
    pub fn named(name: &str) -> Option<Effect> {
        Effect::LIBRARY.into_iter().chain(Effect::OUTSIDE).find(|effect| effect.name() == name)
    }
}

/// A motor with its gear, q-axis power-invariant, everything seen from the motor unless said.
#[derive(Debug, Clone)]
pub struct Machine {
    /// R at the reference temperature \[Ω\].
    pub resistance: f64,
    /// L \[H\].
    pub inductance: f64,
    /// K_T = K_B \[N·m/A\].
    pub torque_constant: f64,
    /// J_m \[kg·m²\].
    pub inertia: f64,
    /// J_g \[kg·m²\].
    pub gear_inertia: f64,
    /// N.
    pub ratio: f64,
    /// Pole pairs.
    pub pole_pairs: u32,
    /// b \[N·m·s/rad\], declared in the row.
    pub viscous: f64,
    /// c \[N·m\], declared in the row.
    pub coulomb: f64,
    /// Largest current of the bench \[A\].
    pub peak_current: f64,
    /// Largest speed of the motor on the bench \[rad/s\].
    pub peak_speed: f64,
    /// Inertia of the load \[kg·m²\] at the output, where there is one.
    pub load_inertia: f64,
    /// Winding to housing, housing to ambient \[K/W\].
    pub thermal_resistance: [f64; 2],
    /// Winding, housing \[J/K\].
    pub heat_capacity: [f64; 2],
    /// Bus \[V\].
    pub bus: f64,
}

impl Machine {
    /// A quasi-direct-drive actuator of a leg.
    pub fn actuator(random: &mut Random) -> Self {
        let torque_constant = random.within(0.07, 0.14);
        let resistance = random.within(0.25, 0.6);
        let inertia = random.within(2e-5, 5e-5);
        // Never near an integer: there motor order 1 and output order N would be one.
        let ratio = [5.4, 6.3, 7.2, 7.6, 8.7][random.index(5)];
        let peak_current = random.within(10.0, 16.0);
        let peak_speed = random.within(120.0, 200.0);
        let peak = torque_constant * peak_current;
        let heat = resistance * (0.5 * peak_current).powi(2);
        let thermal_resistance = [random.within(35.0, 50.0) / heat, random.within(40.0, 70.0) / heat];
        Machine {
            resistance,
            inductance: resistance * random.within(5e-4, 1.2e-3),
            torque_constant,
            inertia,
            gear_inertia: 0.0,
            ratio,
            pole_pairs: [7, 10, 14][random.index(3)],
            viscous: random.within(0.01, 0.03) * peak / peak_speed,
            coulomb: random.within(0.01, 0.03) * peak,
            peak_current,
            peak_speed,
            load_inertia: random.within(6.0, 12.0) * inertia * ratio * ratio,
            thermal_resistance,
            heat_capacity: [
                random.within(6.0, 12.0) / thermal_resistance[0],
                random.within(40.0, 80.0) / thermal_resistance[1],
            ],
            bus: 48.0,
        }
    }

    /// A small servo.
    pub fn servo(random: &mut Random) -> Self {
        let torque_constant = random.within(0.003, 0.004);
        Machine {
            resistance: random.within(3.5, 5.0),
            inductance: 2e-4,
            torque_constant,
            inertia: random.within(3e-8, 6e-8),
            gear_inertia: 0.0,
            ratio: 250.4,
            pole_pairs: 1,
            viscous: 2e-8,
            coulomb: random.within(5e-5, 1e-4),
            peak_current: 1.5,
            peak_speed: 1800.0,
            load_inertia: 0.0,
            thermal_resistance: [10.0, 20.0],
            heat_capacity: [1.0, 5.0],
            bus: 7.4,
        }
    }

    /// A belt or screw axis: newtons for newton metres, kilograms for inertia, the drive's force for current.
    pub fn axis(random: &mut Random) -> Self {
        Machine {
            resistance: 1.0,
            inductance: 0.0,
            torque_constant: 1.0,
            inertia: 0.0,
            gear_inertia: 0.0,
            ratio: 1.0,
            pole_pairs: 1,
            viscous: random.within(150.0, 250.0),
            coulomb: random.within(15.0, 25.0),
            peak_current: 150.0,
            peak_speed: 0.25,
            load_inertia: random.within(70.0, 110.0),
            thermal_resistance: [1.0, 1.0],
            heat_capacity: [1e9, 1e9],
            bus: 48.0,
        }
    }

    /// K_T times the largest current \[N·m\].
    pub fn peak_torque(&self) -> f64 {
        self.torque_constant * self.peak_current
    }
}

/// A wave over an angle: order, relative amplitude, phase.
type Wave = [f64; 3];

fn wave(waves: &[Wave], angle: f64) -> f64 {
    waves.iter().map(|[order, amplitude, phase]| amplitude * (order * angle + phase).cos()).sum()
}

/// Harmonics of a tooth: each one weaker, phases aligned so that the sum looks like teeth.
fn teeth(order: u32, count: i32, random: &mut Random) -> Vec<Wave> {
    let shift = random.within(0.0, TAU);
    (1..=count)
        .map(|h| {
            let amplitude = f64::from(h).powi(-2) * random.within(0.8, 1.2);
            [f64::from(order) * f64::from(h), amplitude, f64::from(h) * shift]
        })
        .collect()
}

/// Everything that acts, and how strongly: the truth.
#[derive(Debug, Clone)]
pub struct Nature {
    pub machine: Machine,
    /// b \[N·m·s/rad\], c \[N·m\] of both directions' mean.
    pub viscous: f64,
    pub coulomb: f64,
    /// c_s \[N·m\] and ω_s \[rad/s\].
    pub stribeck: f64,
    pub stribeck_speed: f64,
    /// Angle of the motor over which friction builds up \[rad\].
    pub bristle: f64,
    /// γ.
    pub load_dependent: f64,
    /// (b₊ − b₋)/2 and (c₊ − c₋)/2.
    pub viscous_asymmetry: f64,
    pub coulomb_asymmetry: f64,
    pub asymmetry_sign: f64,
    /// T_max \[N·m\], ω_k \[rad/s\].
    pub eddy: f64,
    pub eddy_knee: f64,
    /// Amplitudes of the waves; shapes beside them.
    pub cogging: f64,
    pub cogging_waves: Vec<Wave>,
    pub torque_ripple: f64,
    pub torque_ripple_waves: Vec<Wave>,
    pub gear_ripple: f64,
    pub gear_ripple_waves: Vec<Wave>,
    /// 1/i_s of K_T i_s tanh(i/i_s) \[1/A\].
    pub saturation: f64,
    /// Loss of K_T per kelvin of the magnets \[1/K\].
    pub magnet: f64,
    /// Rise of R per kelvin \[1/K\].
    pub copper: f64,
    /// V_d \[V\], and the current over which it turns its sign \[A\].
    pub dead_voltage: f64,
    pub dead_current: f64,
    /// m g l \[N·m\], φ \[rad\].
    pub gravity: f64,
    pub gravity_angle: f64,
    /// Constant torque at the motor \[N·m\].
    pub offset: f64,
    /// 1/k at the output \[rad/(N·m)\], and damping relative to the critical.
    pub compliance: f64,
    pub compliance_damping: f64,
    /// Whole gap at the output \[rad\], and the smallest that this gear would be sold with.
    pub backlash: f64,
    pub least_backlash: f64,
    /// Ω between supply and drive.
    pub sag: f64,
    /// Outside the library, all at the motor \[N·m\] or in the target's own unit.
    pub hum: f64,
    pub zero_step: f64,
    pub run_in: f64,
    pub random_walk: f64,
    pub cubic: f64,
    pub memory: f64,
}

impl Nature {
    /// The machine with its declared friction alone; shapes of everything else drawn already.
    pub fn new(machine: Machine, effects: &[Effect], random: &mut Random) -> Self {
        let mut nature = Nature {
            viscous: machine.viscous,
            coulomb: machine.coulomb,
            stribeck: 0.0,
            stribeck_speed: random.within(0.03, 0.06) * machine.peak_speed,
            bristle: random.log_within(5e-4, 3e-3) * machine.peak_speed / 150.0,
            load_dependent: 0.0,
            viscous_asymmetry: 0.0,
            coulomb_asymmetry: 0.0,
            asymmetry_sign: random.sign(),
            eddy: 0.0,
            eddy_knee: random.within(0.25, 0.4) * machine.peak_speed,
            cogging: 0.0,
            cogging_waves: Vec::new(),
            torque_ripple: 0.0,
            torque_ripple_waves: Vec::new(),
            gear_ripple: 0.0,
            gear_ripple_waves: Vec::new(),
            saturation: 0.0,
            magnet: 0.0,
            copper: 0.0,
            dead_voltage: 0.0,
            dead_current: random.within(0.02, 0.05) * machine.peak_current,
            gravity: 0.0,
            gravity_angle: random.within(-PI, PI),
            offset: 0.0,
            compliance: 0.0,
            compliance_damping: random.within(0.03, 0.08),
            backlash: 0.0,
            // One to five minutes of arc.
            least_backlash: random.log_within(3e-4, 1.5e-3),
            sag: 0.0,
            hum: 0.0,
            zero_step: 0.0,
            run_in: 0.0,
            random_walk: 0.0,
            cubic: 0.0,
            memory: 0.0,
            machine,
        };
        for effect in effects {
            match *effect {
                Effect::Cogging { order } => nature.cogging_waves = teeth(order, 3, random),
                Effect::TorqueRipple { order } => nature.torque_ripple_waves = teeth(order, 2, random),
                Effect::GearRipple { order } => nature.gear_ripple_waves = teeth(order, 2, random),
                // What is undeclared is not there beside the effect.
                Effect::ViscousFriction => nature.viscous = 0.0,
                Effect::CoulombFriction => nature.coulomb = 0.0,
                _ => {}
            }
        }
        nature
    }

    /// The amplitude of an effect: the one number that says how strong it is.
    pub fn amplitude_mut(&mut self, effect: Effect) -> &mut f64 {
        match effect {
            Effect::ViscousFriction => &mut self.viscous,
            Effect::CoulombFriction => &mut self.coulomb,
            Effect::StribeckFriction => &mut self.stribeck,
            Effect::LoadDependentFriction => &mut self.load_dependent,
            Effect::DirectionAsymmetry => &mut self.viscous_asymmetry,
            Effect::EddyDrag => &mut self.eddy,
            Effect::Cogging { .. } => &mut self.cogging,
            Effect::TorqueRipple { .. } => &mut self.torque_ripple,
            Effect::GearRipple { .. } => &mut self.gear_ripple,
            Effect::TorqueConstantSaturation => &mut self.saturation,
            Effect::TorqueConstantTemperature => &mut self.magnet,
            Effect::WindingTemperature => &mut self.copper,
            Effect::InverterDeadTime => &mut self.dead_voltage,
            Effect::Gravity => &mut self.gravity,
            Effect::TorqueOffset => &mut self.offset,
            Effect::GearCompliance => &mut self.compliance,
            Effect::Backlash => &mut self.backlash,
            Effect::SupplySag => &mut self.sag,
            Effect::Hum => &mut self.hum,
            Effect::ZeroStep => &mut self.zero_step,
            Effect::RunIn => &mut self.run_in,
            Effect::RandomWalk => &mut self.random_walk,
            Effect::CubicDrag => &mut self.cubic,
            Effect::LoadMemory => &mut self.memory,
        }
    }

    /// Sets an effect's amplitude.
    pub fn set(&mut self, effect: Effect, amplitude: f64) {
        *self.amplitude_mut(effect) = amplitude;
        if effect == Effect::DirectionAsymmetry {
            // A little of the constant part too, which a zero of the sensor hides.
            let sign = self.asymmetry_sign;
            self.viscous_asymmetry = sign * amplitude;
            self.coulomb_asymmetry = sign * 0.1 * amplitude * self.machine.peak_speed;
        }
    }

    /// What an effect's amplitude may at most be in a machine that someone would sell.
    pub fn largest(&self, effect: Effect) -> f64 {
        let m = &self.machine;
        let torque = m.peak_torque();
        match effect {
            Effect::ViscousFriction => 0.3 * torque / m.peak_speed,
            Effect::CoulombFriction => 0.3 * torque,
            Effect::StribeckFriction => 0.2 * torque,
            Effect::LoadDependentFriction => 0.25,
            // Friction must stay a drag in both directions.
            Effect::DirectionAsymmetry => 0.9 * self.viscous.min(5.0 * self.coulomb / m.peak_speed),
            Effect::EddyDrag => 0.2 * torque,
            Effect::Cogging { .. } | Effect::GearRipple { .. } => 0.1 * torque,
            Effect::TorqueRipple { .. } => 0.1,
            Effect::TorqueConstantSaturation => 1.0 / (0.8 * m.peak_current),
            Effect::TorqueConstantTemperature => 0.002,
            Effect::WindingTemperature => COPPER,
            Effect::InverterDeadTime => 1.0,
            Effect::Gravity => 0.5 * m.ratio * torque,
            Effect::TorqueOffset => 0.2 * torque,
            Effect::GearCompliance => {
                let inertia = if m.load_inertia > 0.0 { m.load_inertia } else { m.inertia * m.ratio.powi(2) };
                1.0 / (inertia * (TAU * 8.0).powi(2))
            }
            Effect::Backlash => 3f64.to_radians(),
            Effect::SupplySag => 0.3 * m.resistance,
            Effect::Hum | Effect::ZeroStep | Effect::RandomWalk | Effect::LoadMemory => f64::INFINITY,
            Effect::RunIn => 0.3 * torque,
            Effect::CubicDrag => 0.3 * torque / m.peak_speed.powi(3),
        }
    }

    /// What an effect's amplitude is at least where it is worth a name.
    pub fn smallest(&self, effect: Effect) -> f64 {
        match effect {
            Effect::Backlash => self.least_backlash,
            // A gear that rings at 40 Hz with its load.
            Effect::GearCompliance => 0.04 * self.largest(effect),
            _ => 0.0,
        }
    }

    /// Parameters in SI, by the names of the equations.
    pub fn parameters(&self, effect: Effect) -> Vec<(&'static str, f64)> {
        let first = |waves: &[Wave]| waves.first().map_or(0.0, |w| w[0]);
        match effect {
            Effect::ViscousFriction => vec![("b", self.viscous)],
            Effect::CoulombFriction => vec![("c", self.coulomb)],
            Effect::StribeckFriction => vec![("c_s", self.stribeck), ("omega_s", self.stribeck_speed)],
            Effect::LoadDependentFriction => vec![("gamma", self.load_dependent)],
            Effect::DirectionAsymmetry => {
                vec![("b_difference", 2.0 * self.viscous_asymmetry), ("c_difference", 2.0 * self.coulomb_asymmetry)]
            }
            Effect::EddyDrag => vec![("t_max", self.eddy), ("omega_k", self.eddy_knee)],
            Effect::Cogging { .. } => vec![
                ("order", first(&self.cogging_waves)),
                ("amplitude", self.cogging * self.cogging_waves.first().map_or(0.0, |w| w[1])),
            ],
            Effect::TorqueRipple { .. } => vec![
                ("order", first(&self.torque_ripple_waves)),
                ("amplitude", self.torque_ripple * self.torque_ripple_waves.first().map_or(0.0, |w| w[1])),
            ],
            Effect::GearRipple { .. } => vec![
                ("order", first(&self.gear_ripple_waves)),
                ("amplitude", self.gear_ripple * self.gear_ripple_waves.first().map_or(0.0, |w| w[1])),
            ],
            Effect::TorqueConstantSaturation => vec![("i_s", 1.0 / self.saturation)],
            Effect::TorqueConstantTemperature => vec![("coefficient", -self.magnet)],
            Effect::WindingTemperature => vec![("coefficient", self.copper)],
            Effect::InverterDeadTime => vec![("v_d", self.dead_voltage), ("i_width", self.dead_current)],
            Effect::Gravity => vec![("m_g_l", self.gravity), ("phi", self.gravity_angle)],
            Effect::TorqueOffset => vec![("torque", self.offset)],
            Effect::GearCompliance => vec![("stiffness", 1.0 / self.compliance)],
            Effect::Backlash => vec![("gap", self.backlash)],
            Effect::SupplySag => vec![("resistance", self.sag)],
            Effect::Hum => vec![("amplitude", self.hum)],
            Effect::ZeroStep => vec![("step", self.zero_step)],
            Effect::RunIn => vec![("c", self.run_in)],
            Effect::RandomWalk => vec![("scale", self.random_walk)],
            Effect::CubicDrag => vec![("coefficient", self.cubic)],
            Effect::LoadMemory => vec![("scale", self.memory)],
        }
    }

    /// The torque that friction settles at in steady sliding, without the viscous part: the Stribeck
    /// curve \[N·m\].
    pub fn sliding(&self, speed: f64, time: f64) -> f64 {
        let mut curve = self.coulomb + speed.signum() * self.coulomb_asymmetry;
        curve += self.stribeck * (-(speed / self.stribeck_speed).powi(2)).exp();
        curve + self.run_in * (-time / 8.0).exp()
    }

    /// Torque of the motor's current at a magnet temperature and angle \[N·m\].
    pub fn motor_torque(&self, current: f64, magnet: f64, angle: f64) -> f64 {
        self.torque_scale(magnet, angle) * self.machine.torque_constant * self.saturated(current)
    }

    /// The current that makes a torque \[A\].
    pub fn current_for(&self, torque: f64, magnet: f64, angle: f64) -> f64 {
        let wanted = torque / (self.torque_scale(magnet, angle) * self.machine.torque_constant);
        if self.saturation == 0.0 {
            return wanted;
        }
        // Beyond 0.999 of the asymptote no current is enough: a drive would clip there.
        (wanted * self.saturation).clamp(-0.999, 0.999).atanh() / self.saturation
    }

    fn torque_scale(&self, magnet: f64, angle: f64) -> f64 {
        let ripple = if self.torque_ripple == 0.0 { 0.0 } else { wave(&self.torque_ripple_waves, angle) };
        (1.0 - self.magnet * (magnet - REFERENCE)) * (1.0 + self.torque_ripple * ripple)
    }

    fn saturated(&self, current: f64) -> f64 {
        if self.saturation == 0.0 { current } else { (self.saturation * current).tanh() / self.saturation }
    }

    fn effective_inertia(&self) -> f64 {
        self.machine.inertia + self.machine.gear_inertia
    }

    /// Torque through a spring with a gap, at the output \[N·m\]; `twist` and its rate at the output.
    pub fn coupling(&self, twist: f64, rate: f64, inertia: f64) -> f64 {
        // Flanks alone: so stiff that the gap, not they, is what a log shows.
        let stiffness = if self.compliance > 0.0 { 1.0 / self.compliance } else { inertia * (TAU * 180.0).powi(2) };
        let damping = if self.backlash > 0.0 { 0.3 } else { self.compliance_damping };
        let damper = 2.0 * damping * (stiffness * inertia).sqrt();
        let half = 0.5 * self.backlash;
        if self.backlash == 0.0 {
            stiffness * twist + damper * rate
        } else if twist > half {
            (stiffness * (twist - half) + damper * rate).max(0.0)
        } else if twist < -half {
            (stiffness * (twist + half) + damper * rate).min(0.0)
        } else {
            0.0
        }
    }

    /// Whether motor and output move on their own.
    pub fn is_two_masses(&self) -> bool {
        self.compliance > 0.0 || self.backlash > 0.0
    }

    fn output_torque(&self, angle: f64) -> f64 {
        if self.gravity == 0.0 { 0.0 } else { self.gravity * (angle + self.gravity_angle).sin() }
    }
}

/// What changes while it runs and is no motion.
#[derive(Debug, Clone, Copy)]
pub struct State {
    /// Torque of the bristles \[N·m\].
    bristle: f64,
    /// Their direction alone, −1…1.
    direction: f64,
    memory: f64,
    last_load: f64,
    pub winding: f64,
    pub housing: f64,
}

impl State {
    /// At rest, at given temperatures \[°C\].
    pub fn new(winding: f64, housing: f64) -> Self {
        State { bristle: 0.0, direction: 0.0, memory: 0.0, last_load: 0.0, winding, housing }
    }

    /// Bristles over a step at a speed: `ż = v − abs(v) z/z_ss`, solved exactly for a constant speed.
    pub fn slide(&mut self, nature: &Nature, speed: f64, time: f64, step: f64) {
        let travel = speed.abs() * step;
        let curve = nature.sliding(speed, time);
        if curve > 0.0 {
            // Stiffness of the bristles: that of the highest sliding torque over the pre-sliding angle.
            let stiffness = (nature.coulomb + nature.stribeck + nature.run_in) / nature.bristle;
            let end = curve * speed.signum();
            self.bristle = end + (self.bristle - end) * (-travel * stiffness / curve).exp();
        } else {
            self.bristle = 0.0;
        }
        let end = speed.signum();
        self.direction = end + (self.direction - end) * (-travel / nature.bristle).exp();
    }

    /// Torque of friction now \[N·m\].
    pub fn friction(&self, nature: &Nature, speed: f64) -> f64 {
        self.bristle + nature.viscous * speed + nature.viscous_asymmetry * speed.abs()
    }

    /// Everything inside the motor that its torque has to overcome beside inertia and load \[N·m\].
    pub fn drag(&self, nature: &Nature, angle: f64, speed: f64) -> f64 {
        let mut torque = self.friction(nature, speed) + nature.offset;
        if nature.eddy != 0.0 && speed != 0.0 {
            torque += 2.0 * nature.eddy / (speed / nature.eddy_knee + nature.eddy_knee / speed);
        }
        if nature.cogging != 0.0 {
            torque += nature.cogging * wave(&nature.cogging_waves, angle);
        }
        if nature.gear_ripple != 0.0 {
            torque += nature.gear_ripple * wave(&nature.gear_ripple_waves, angle / nature.machine.ratio);
        }
        torque + nature.cubic * speed.powi(3)
    }

    fn heat(&mut self, nature: &Nature, current: f64, step: f64) {
        let m = &nature.machine;
        let power = m.resistance * (1.0 + nature.copper * (self.winding - REFERENCE)) * current * current;
        let out = (self.winding - self.housing) / m.thermal_resistance[0];
        let away = (self.housing - REFERENCE) / m.thermal_resistance[1];
        self.winding += step * (power - out) / m.heat_capacity[0];
        self.housing += step * (out - away) / m.heat_capacity[1];
    }

    /// Hysteresis of the sensor over a change of its load, −1…1.
    fn remember(&mut self, load: f64, full: f64) {
        let change = 4.0 * (load - self.last_load) / full;
        self.memory += change - change.abs() * self.memory;
        self.last_load = load;
    }
}

/// One log, finely sampled, before any instrument has seen it.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Time between samples \[s\].
    pub step: f64,
    pub motor_angle: Vec<f64>,
    pub motor_speed: Vec<f64>,
    pub motor_acceleration: Vec<f64>,
    pub output_angle: Vec<f64>,
    pub output_speed: Vec<f64>,
    pub output_acceleration: Vec<f64>,
    pub current: Vec<f64>,
    pub current_rate: Vec<f64>,
    /// What the sensor at the output carries \[N·m\].
    pub torque: Vec<f64>,
    pub voltage: Vec<f64>,
    pub winding: Vec<f64>,
    pub housing: Vec<f64>,
    pub duty: Vec<f64>,
    pub goal: Vec<f64>,
    pub supply: Vec<f64>,
    /// What the driving machine was told \[N·m\].
    pub command: Vec<f64>,
    /// Heat of friction, of every kind \[W\].
    pub friction_power: Vec<f64>,
}

impl Trace {
    /// Adds how an output moves, and the motor behind a stiff gear of a ratio.
    pub fn push_motion(&mut self, ratio: f64, position: f64, speed: f64, acceleration: f64) {
        self.motor_angle.push(ratio * position);
        self.motor_speed.push(ratio * speed);
        self.motor_acceleration.push(ratio * acceleration);
        self.output_angle.push(position);
        self.output_speed.push(speed);
        self.output_acceleration.push(acceleration);
    }
}

/// What a bench imposes on the machine in one log.
pub struct Drive {
    pub step: f64,
    pub duration: f64,
    /// Speed: of the output on a dynamometer, of the motor elsewhere; the goal of a servo is its integral.
    pub motion: Profile,
    /// Current where it is commanded.
    pub current: Profile,
    pub winding: f64,
    pub housing: f64,
    /// For disturbances of the channel.
    pub seed: u64,
}

impl Drive {
    /// Samples of the trace.
    pub fn steps(&self) -> usize {
        (self.duration / self.step).round() as usize + 1
    }
}

/// Additive disturbances of the target's channel, outside the library.
struct Disturbance {
    random: Random,
    walk: f64,
    jump: f64,
    phase: f64,
}

impl Disturbance {
    fn new(drive: &Drive) -> Self {
        let mut random = Random::new(drive.seed, "disturbance");
        let jump = drive.duration * random.within(0.35, 0.65);
        let phase = random.within(0.0, TAU);
        Disturbance { random, walk: 0.0, jump, phase }
    }

    fn at(&mut self, nature: &Nature, time: f64, step: f64) -> f64 {
        let mut sum = 0.0;
        if nature.random_walk != 0.0 {
            self.walk += self.random.normal() * step.sqrt();
            sum += nature.random_walk * self.walk;
        }
        if nature.hum != 0.0 {
            sum += nature.hum * (TAU * 50.0 * time + self.phase).sin();
        }
        if time > self.jump { sum + nature.zero_step } else { sum }
    }
}

/// A dynamometer: speed imposed at the output, current commanded; also what an electrical bench,
/// a stall bench and a back-driven motor are.
pub fn dynamometer(nature: &Nature, mut drive: Drive) -> Trace {
    let m = &nature.machine;
    let (n, h) = (m.ratio, drive.step);
    let inertia = nature.effective_inertia();
    let reflected = inertia * n * n;
    let mut state = State::new(drive.winding, drive.housing);
    let mut disturbance = Disturbance::new(&drive);
    let mut trace = Trace { step: h, ..Trace::default() };
    // Motor at the middle of the gap, at the output's speed.
    let (mut angle, mut speed) = (0.0, n * drive.motion.value());
    for k in 0..drive.steps() {
        let time = k as f64 * h;
        let (output_angle, output_speed) = (drive.motion.integral(), drive.motion.value());
        let output_acceleration = drive.motion.slope();
        let (current, current_rate) = (drive.current.value(), drive.current.slope());
        if !nature.is_two_masses() {
            (angle, speed) = (n * output_angle, n * output_speed);
        }
        state.slide(nature, speed, time, h);
        let motor_torque = nature.motor_torque(current, state.housing, angle);
        let drag = state.drag(nature, angle, speed);
        let (acceleration, through) = if nature.is_two_masses() {
            let through = nature.coupling(angle / n - output_angle, speed / n - output_speed, reflected);
            let lost = nature.load_dependent * (through / n).abs() * state.direction;
            ((motor_torque - drag - lost - through / n) / inertia, through)
        } else {
            let acceleration = n * output_acceleration;
            let given = motor_torque - inertia * acceleration - drag;
            // τ/N = X − γ abs(τ/N) s: the loss takes from what drives and helps what holds.
            let loss = nature.load_dependent * state.direction * given.signum();
            (acceleration, n * given / (1.0 + loss))
        };
        let mut torque = through - nature.output_torque(output_angle);
        state.remember(torque, n * m.peak_torque());
        torque += nature.memory * state.memory + disturbance.at(nature, time, h);
        let lost = nature.load_dependent * (through / n).abs() * state.direction;
        let eddy_and_friction = (drag - nature.offset) * speed + lost * speed;
        let dead = nature.dead_voltage * (current / nature.dead_current).tanh();
        let resistance = m.resistance * (1.0 + nature.copper * (state.winding - REFERENCE));
        trace.motor_angle.push(angle);
        trace.motor_speed.push(speed);
        trace.motor_acceleration.push(acceleration);
        trace.output_angle.push(output_angle);
        trace.output_speed.push(output_speed);
        trace.output_acceleration.push(output_acceleration);
        trace.current.push(current);
        trace.current_rate.push(current_rate);
        trace.torque.push(torque);
        let back_emf = m.torque_constant * speed;
        trace.voltage.push(resistance * current + m.inductance * current_rate + back_emf + dead);
        trace.winding.push(state.winding);
        trace.housing.push(state.housing);
        trace.friction_power.push(eddy_and_friction);
        state.heat(nature, current, h);
        drive.motion.advance();
        drive.current.advance();
        if nature.is_two_masses() {
            let (next_angle, next_speed) = (drive.motion.integral(), drive.motion.value());
            let push = motor_torque - drag;
            let derivative = |share: f64, angle: f64, speed: f64| {
                let output = output_angle + share * (next_angle - output_angle);
                let rate = output_speed + share * (next_speed - output_speed);
                let through = nature.coupling(angle / n - output, speed / n - rate, reflected) / n;
                (speed, (push - through - nature.load_dependent * through.abs() * state.direction) / inertia)
            };
            (angle, speed) = runge_kutta(h, angle, speed, derivative);
        }
    }
    trace
}

/// A known inertia (or mass) moved by the motor, whose motion the drive holds; the current follows.
pub fn free(nature: &Nature, mut drive: Drive) -> Trace {
    let m = &nature.machine;
    let (n, h) = (m.ratio, drive.step);
    let inertia = nature.effective_inertia();
    let mut state = State::new(drive.winding, drive.housing);
    let mut disturbance = Disturbance::new(&drive);
    let mut trace = Trace { step: h, ..Trace::default() };
    let (mut output_angle, mut output_speed) = (0.0, drive.motion.value() / n);
    let mut last = None;
    for k in 0..drive.steps() {
        let time = k as f64 * h;
        let (angle, speed, acceleration) = (drive.motion.integral(), drive.motion.value(), drive.motion.slope());
        if !nature.is_two_masses() {
            (output_angle, output_speed) = (angle / n, speed / n);
        }
        state.slide(nature, speed, time, h);
        let gravity = nature.output_torque(output_angle);
        let (through, output_acceleration) = if nature.is_two_masses() {
            let through = nature.coupling(angle / n - output_angle, speed / n - output_speed, m.load_inertia);
            (through, (through - gravity) / m.load_inertia)
        } else {
            (m.load_inertia * acceleration / n + gravity, acceleration / n)
        };
        let drag = state.drag(nature, angle, speed);
        let lost = nature.load_dependent * (through / n).abs() * state.direction;
        let torque = inertia * acceleration + drag + through / n + lost;
        let mut current = nature.current_for(torque, state.housing, angle);
        state.heat(nature, current, h);
        state.remember(torque, m.peak_torque());
        current += (nature.memory * state.memory + disturbance.at(nature, time, h)) / (n * m.torque_constant);
        let current_rate = last.map_or(0.0, |last| (current - last) / h);
        last = Some(current);
        trace.motor_angle.push(angle);
        trace.motor_speed.push(speed);
        trace.motor_acceleration.push(acceleration);
        trace.output_angle.push(output_angle);
        trace.output_speed.push(output_speed);
        trace.output_acceleration.push(output_acceleration);
        trace.current.push(current);
        trace.current_rate.push(current_rate);
        trace.torque.push(through);
        let resistance = m.resistance * (1.0 + nature.copper * (state.winding - REFERENCE));
        let back_emf = m.torque_constant * speed;
        let dead = nature.dead_voltage * (current / nature.dead_current).tanh();
        trace.voltage.push(resistance * current + m.inductance * current_rate + back_emf + dead);
        trace.winding.push(state.winding);
        trace.housing.push(state.housing);
        trace.friction_power.push((drag - nature.offset + lost) * speed);
        drive.motion.advance();
        if nature.is_two_masses() {
            let (next_angle, next_speed) = (drive.motion.integral(), drive.motion.value());
            let derivative = |share: f64, output: f64, rate: f64| {
                let motor = angle + share * (next_angle - angle);
                let motor_rate = speed + share * (next_speed - speed);
                let through = nature.coupling(motor / n - output, motor_rate / n - rate, m.load_inertia);
                (rate, (through - nature.output_torque(output)) / m.load_inertia)
            };
            (output_angle, output_speed) = runge_kutta(h, output_angle, output_speed, derivative);
        }
    }
    trace
}

/// A servo's law and its pendulum.
#[derive(Debug, Clone, Copy)]
pub struct Servo {
    /// Duty per radian of error at the output.
    pub gain: f64,
    /// Point mass \[kg\] and its distance from the axis \[m\].
    pub mass: f64,
    pub length: f64,
}

/// A servo with a pendulum: duty = gain · (goal − position), the supply behind a resistance. The goal
/// is the motion's own value.
pub fn servo(nature: &Nature, servo: Servo, mut drive: Drive) -> Trace {
    let m = &nature.machine;
    let (n, h) = (m.ratio, drive.step);
    let pendulum = servo.mass * servo.length * servo.length;
    let weight = servo.mass * 9.806_65 * servo.length;
    let inertia = pendulum + nature.effective_inertia() * n * n;
    let mut state = State::new(drive.winding, drive.housing);
    let mut disturbance = Disturbance::new(&drive);
    let mut trace = Trace { step: h, ..Trace::default() };
    let (mut position, mut speed) = (0.0_f64, 0.0_f64);
    for k in 0..drive.steps() {
        let time = k as f64 * h;
        let goal = drive.motion.value();
        let duty = (servo.gain * (goal - position)).clamp(-1.0, 1.0);
        let resistance = m.resistance * (1.0 + nature.copper * (state.winding - REFERENCE));
        let open = duty * m.bus - m.torque_constant * n * speed;
        // A smooth dead voltage has no closed form: the current without it decides its sign.
        let dead = nature.dead_voltage * (open / resistance / nature.dead_current).tanh();
        let current = (open - dead) / (resistance + nature.sag * duty * duty);
        let supply = m.bus - nature.sag * duty * current;
        state.slide(nature, n * speed, time, h);
        let torque = nature.motor_torque(current, state.housing, n * position);
        let drag = state.drag(nature, n * position, n * speed);
        let load = weight * position.sin() + nature.output_torque(position);
        // The gear's loss grows with what it carries: weight and the pendulum's own inertia, so the
        // acceleration is solved for with the sign of the torque that an ideal gear would carry.
        let given = n * (torque - drag) + disturbance.at(nature, time, h);
        let ideal = load + pendulum * (given - load) / inertia;
        let factor = 1.0 + nature.load_dependent * state.direction * ideal.signum();
        let acceleration = (given - factor * load) / (factor * pendulum + inertia - pendulum);
        let lost = (factor - 1.0) * (load + pendulum * acceleration);
        trace.push_motion(n, position, speed, acceleration);
        trace.current.push(current);
        trace.current_rate.push(0.0);
        trace.torque.push(load + pendulum * acceleration);
        trace.voltage.push(duty * supply);
        trace.winding.push(state.winding);
        trace.housing.push(state.housing);
        trace.duty.push(duty);
        trace.goal.push(goal);
        trace.supply.push(supply);
        trace.friction_power.push(n * speed * drag + lost * speed);
        state.heat(nature, current, h);
        speed += h * acceleration;
        position += h * speed;
        drive.motion.advance();
    }
    trace
}

/// One step of an angle and its rate; `derivative(share of the step, angle, rate)`.
pub fn runge_kutta(h: f64, x: f64, v: f64, derivative: impl Fn(f64, f64, f64) -> (f64, f64)) -> (f64, f64) {
    let a = derivative(0.0, x, v);
    let b = derivative(0.5, x + 0.5 * h * a.0, v + 0.5 * h * a.1);
    let c = derivative(0.5, x + 0.5 * h * b.0, v + 0.5 * h * b.1);
    let d = derivative(1.0, x + h * c.0, v + h * c.1);
    (x + h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0), v + h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1))
}

/// A table of steady points, speed by speed and current by current, as a trace with a point a second.
/// It warms up as it goes on.
pub fn steady_table(nature: &Nature, drive: &Drive) -> Trace {
    let m = &nature.machine;
    let mut random = Random::new(drive.seed, "points");
    let mut housing = drive.housing;
    let mut trace = Trace { step: drive.step, ..Trace::default() };
    let count = drive.steps() - 1;
    for k in 0..count {
        let speed = m.peak_speed * ((k / 9 + 1) * 9) as f64 / count as f64;
        let current = m.peak_current * (k % 9) as f64 / 8.0 * random.within(0.97, 1.03);
        let heat = m.resistance * current * current;
        housing += 0.05 * (REFERENCE + 0.3 * heat * m.thermal_resistance[1] - housing);
        trace.motor_angle.push(0.0);
        trace.motor_speed.push(speed);
        trace.motor_acceleration.push(0.0);
        trace.output_angle.push(0.0);
        trace.output_speed.push(speed / m.ratio);
        trace.output_acceleration.push(0.0);
        trace.current.push(current);
        trace.current_rate.push(0.0);
        trace.torque.push(steady_torque(nature, speed, current, housing));
        let winding = housing + 0.3 * heat * m.thermal_resistance[0];
        let resistance = m.resistance * (1.0 + nature.copper * (winding - REFERENCE));
        trace.voltage.push(resistance * current + m.torque_constant * speed);
        trace.winding.push(winding);
        trace.housing.push(housing);
    }
    trace
}

/// Torque at the output in steady running, the ripple over a turn averaged out \[N·m\].
pub fn steady_torque(nature: &Nature, speed: f64, current: f64, magnet: f64) -> f64 {
    let smooth = Nature { torque_ripple: 0.0, cogging: 0.0, gear_ripple: 0.0, ..nature.clone() };
    let mut state = State::new(magnet, magnet);
    // Long enough for the bristles to have settled.
    state.slide(&smooth, speed, 0.0, 1e3);
    let given = smooth.motor_torque(current, magnet, 0.0) - state.drag(&smooth, 0.0, speed);
    smooth.machine.ratio * given / (1.0 + smooth.load_dependent * state.direction * given.signum())
}
