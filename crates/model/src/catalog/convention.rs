//! What the numbers of a data sheet refer to, and their power-invariant q-axis equivalent.
//!
//! Inside the program a motor is the brushed-DC machine with the same torque, the same copper loss
//! and the same terminal power: torque `K_T i`, copper loss `R i²`, terminal power
//! `R i² + K_B ω i` (Lee et al., "How to Model Brushless Electric Motors for the Design of
//! Lightweight Robotic Systems", arXiv 2310.00080). Every convention is one variant here, with the
//! factor that takes the printed number there. `λ` is the peak flux linkage of a phase (wye
//! equivalent), `p` the number of pole pairs.

use std::f64::consts::PI;

/// What "ampere" means in a torque constant and in the current ratings of the same sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurrentConvention {
    /// Power-invariant q-axis current: the program's own.
    QAxis,
    /// Peak of the sinusoidal phase current; `K_T = 1.5 p λ`. Most FOC drives.
    PhaseAmplitude,
    /// Rms of the sinusoidal phase current. Servo data sheets.
    Rms,
    /// DC ampere: of a brushed motor, or of a brushless one under block commutation
    /// (`K_T = (3√3/π) p λ`; maxon, FAULHABER).
    Dc,
}

/// What a back-EMF constant was measured between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackEmfConvention {
    /// Power-invariant q-axis voltage: the program's own.
    QAxis,
    /// Peak of the line-to-line voltage; `√3 p λ`.
    LineToLinePeak,
    /// Rms of the line-to-line voltage.
    LineToLineRms,
    /// Peak of the phase voltage; `p λ`.
    PhasePeak,
    /// Rms of the phase voltage.
    PhaseRms,
    /// Mean of the rectified line-to-line voltage under block commutation, or a brushed motor's.
    Dc,
}

/// What voltage a speed constant refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedConstantConvention {
    /// Peak of the line-to-line voltage. Outrunners.
    LineToLinePeak,
    /// The DC voltage of block commutation, or of a brushed motor.
    Dc,
}

/// Between what a sheet's resistance and inductance are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terminals {
    /// Between two terminals.
    LineToLine,
    /// Of one winding (phase).
    Winding,
    /// Already that of the q-axis equivalent.
    QAxis,
}

/// How the three windings are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Winding {
    /// Star.
    Wye,
    /// Delta.
    Delta,
}

/// Whether the machine commutates itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Commutation {
    /// Electronically, three phases.
    Brushless,
    /// By brushes: the sheet's numbers are the q-axis equivalent's.
    Brushed,
}

/// `√(3/2) · π / (3√3)`: a constant of block commutation on the q axis, 0.7405.
pub const BLOCK: f64 = 1.224_744_871_391_589 * PI / (3.0 * 1.732_050_807_568_877_2);

impl CurrentConvention {
    /// Every convention with the word a catalogue uses for it.
    pub const NAMES: &[(&str, CurrentConvention)] = &[
        ("q_axis", CurrentConvention::QAxis),
        ("phase_amplitude", CurrentConvention::PhaseAmplitude),
        ("rms", CurrentConvention::Rms),
        ("dc", CurrentConvention::Dc),
    ];

    /// q-axis torque constant per printed one.
    pub fn torque_constant(self, commutation: Commutation) -> f64 {
        match (self, commutation) {
            (_, Commutation::Brushed) | (CurrentConvention::QAxis, _) => 1.0,
            (CurrentConvention::PhaseAmplitude, _) => (2.0_f64 / 3.0).sqrt(),
            (CurrentConvention::Rms, _) => 1.0 / 3.0_f64.sqrt(),
            (CurrentConvention::Dc, _) => BLOCK,
        }
    }

    /// q-axis current per printed one where the current stands for heat (continuous ratings).
    pub fn heating_current(self, commutation: Commutation) -> f64 {
        match (self, commutation) {
            (CurrentConvention::Dc, Commutation::Brushless) => 2.0_f64.sqrt(),
            _ => self.torque_current(commutation),
        }
    }

    /// q-axis current per printed one where the current stands for torque (peak ratings).
    pub fn torque_current(self, commutation: Commutation) -> f64 {
        1.0 / self.torque_constant(commutation)
    }
}

impl BackEmfConvention {
    /// Every convention with the word a catalogue uses for it.
    pub const NAMES: &[(&str, BackEmfConvention)] = &[
        ("q_axis", BackEmfConvention::QAxis),
        ("line_to_line_peak", BackEmfConvention::LineToLinePeak),
        ("line_to_line_rms", BackEmfConvention::LineToLineRms),
        ("phase_peak", BackEmfConvention::PhasePeak),
        ("phase_rms", BackEmfConvention::PhaseRms),
        ("dc", BackEmfConvention::Dc),
    ];

    /// q-axis back-EMF constant per printed one.
    pub fn back_emf_constant(self, commutation: Commutation) -> f64 {
        match (self, commutation) {
            (_, Commutation::Brushed) | (BackEmfConvention::QAxis | BackEmfConvention::LineToLineRms, _) => 1.0,
            (BackEmfConvention::LineToLinePeak, _) => 1.0 / 2.0_f64.sqrt(),
            (BackEmfConvention::PhasePeak, _) => 1.5_f64.sqrt(),
            (BackEmfConvention::PhaseRms, _) => 3.0_f64.sqrt(),
            (BackEmfConvention::Dc, _) => BLOCK,
        }
    }
}

impl SpeedConstantConvention {
    /// Every convention with the word a catalogue uses for it.
    pub const NAMES: &[(&str, SpeedConstantConvention)] =
        &[("line_to_line_peak", SpeedConstantConvention::LineToLinePeak), ("dc", SpeedConstantConvention::Dc)];

    /// q-axis back-EMF constant times printed speed constant \[both SI\].
    pub fn back_emf_constant(self, commutation: Commutation) -> f64 {
        match self {
            SpeedConstantConvention::LineToLinePeak => BackEmfConvention::LineToLinePeak.back_emf_constant(commutation),
            SpeedConstantConvention::Dc => BackEmfConvention::Dc.back_emf_constant(commutation),
        }
    }
}

impl Terminals {
    /// Every convention with the word a catalogue uses for it.
    pub const NAMES: &[(&str, Terminals)] =
        &[("line_to_line", Terminals::LineToLine), ("winding", Terminals::Winding), ("q_axis", Terminals::QAxis)];

    /// q-axis resistance (or synchronous inductance) per printed one. A winding's needs to know how
    /// the windings are connected: `None` where it is not said.
    pub fn resistance(self, winding: Option<Winding>, commutation: Commutation) -> Option<f64> {
        match (self, winding, commutation) {
            (_, _, Commutation::Brushed) | (Terminals::QAxis, ..) | (Terminals::Winding, Some(Winding::Wye), _) => {
                Some(1.0)
            }
            (Terminals::LineToLine, ..) => Some(0.5),
            (Terminals::Winding, Some(Winding::Delta), _) => Some(1.0 / 3.0),
            (Terminals::Winding, None, _) => None,
        }
    }
}

impl Winding {
    /// Both connections with the word a catalogue uses for them.
    pub const NAMES: &[(&str, Winding)] = &[("wye", Winding::Wye), ("delta", Winding::Delta)];
}

impl Commutation {
    /// Both kinds with the word a catalogue uses for them.
    pub const NAMES: &[(&str, Commutation)] =
        &[("brushless", Commutation::Brushless), ("brushed", Commutation::Brushed)];
}

/// The words of a list of names.
pub(crate) const fn words<T, const N: usize>(names: &[(&'static str, T)]) -> [&'static str; N] {
    let mut words = [""; N];
    let mut k = 0;
    while k < N {
        words[k] = names[k].0;
        k += 1;
    }
    words
}

/// `WORDS`: the words of every type that has `NAMES`.
macro_rules! has_words {
    ($($name:ident),*) => {$(
        impl $name {
            /// The words of [`NAMES`](Self::NAMES) alone.
            pub const WORDS: &'static [&'static str] = &$crate::catalog::convention::words::<_, { Self::NAMES.len() }>(Self::NAMES);
        }
    )*};
}
has_words!(CurrentConvention, BackEmfConvention, SpeedConstantConvention, Terminals, Winding, Commutation);
pub(crate) use has_words;

/// The word of a convention in its list of names.
pub fn word<T: PartialEq>(names: &[(&'static str, T)], value: &T) -> &'static str {
    names.iter().find(|(_, v)| v == value).map_or("", |(name, _)| name)
}

/// What the inverter makes of the bus voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Modulation {
    /// Space-vector modulation: phase amplitude `V/√3`.
    SpaceVector,
    /// Sinusoidal PWM: phase amplitude `V/2`.
    Sine,
}

impl Modulation {
    /// Both kinds with the word a requirement uses for them.
    pub const NAMES: &[(&str, Modulation)] = &[("space_vector", Modulation::SpaceVector), ("sine", Modulation::Sine)];

    /// Radius of the q-axis voltage circle per volt of the bus.
    pub fn voltage(self, commutation: Commutation) -> f64 {
        match (commutation, self) {
            (Commutation::Brushed, _) => 1.0,
            (_, Modulation::SpaceVector) => 1.0 / 2.0_f64.sqrt(),
            (_, Modulation::Sine) => (3.0_f64 / 8.0).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// A physical machine: the flux linkage and winding that every sheet describes in its own way.
    struct Machine {
        name: &'static str,
        flux: f64,
        phase_resistance: f64,
        pole_pairs: f64,
    }

    const MACHINES: &[Machine] = &[
        Machine { name: "RI50", flux: 0.105 / 1.224_744_871_391_589 / 7.0, phase_resistance: 0.705, pole_pairs: 7.0 },
        Machine { name: "U8", flux: 0.14 / 1.224_744_871_391_589 / 21.0, phase_resistance: 0.093, pole_pairs: 21.0 },
        Machine {
            name: "maxon 323218",
            flux: 0.014 * PI / (3.0 * 1.732_050_807_568_877_2) / 2.0,
            phase_resistance: 0.2635,
            pole_pairs: 2.0,
        },
        Machine {
            name: "FAULHABER 4221G024BXTH",
            flux: 0.0377 * PI / (3.0 * 1.732_050_807_568_877_2) / 7.0,
            phase_resistance: 0.37,
            pole_pairs: 7.0,
        },
        Machine { name: "mj5208 on a moteus", flux: 0.0273 / 1.5 / 7.0, phase_resistance: 0.047, pole_pairs: 7.0 },
    ];

    /// Physics of the three phases, term by term: mean torque and copper loss of sinusoidal
    /// currents of amplitude `a` in phase with the back-EMF.
    fn three_phase(machine: &Machine, amplitude: f64, speed: f64) -> (f64, f64, f64) {
        let (mut torque, mut loss, mut power) = (0.0, 0.0, 0.0);
        let steps = 360;
        for step in 0..steps {
            let angle = 2.0 * PI * f64::from(step) / f64::from(steps);
            for phase in 0..3 {
                let here = (angle - 2.0 * PI * f64::from(phase) / 3.0).sin();
                let current = amplitude * here;
                let emf_per_speed = machine.pole_pairs * machine.flux * here;
                torque += emf_per_speed * current;
                loss += machine.phase_resistance * current * current;
                power += current * (machine.phase_resistance * current + emf_per_speed * speed);
            }
        }
        (torque / f64::from(steps), loss / f64::from(steps), power / f64::from(steps))
    }

    #[test]
    fn every_convention_leads_to_the_same_torque_loss_and_power() {
        for machine in MACHINES {
            let pl = machine.pole_pairs * machine.flux;
            let (amplitude, speed) = (5.0, 30.0);
            let (torque, loss, power) = three_phase(machine, amplitude, speed);
            // Each sheet's torque constant and its reading of the same current, where the reading
            // stands for torque.
            let sheets = [
                (CurrentConvention::PhaseAmplitude, 1.5 * pl, amplitude),
                (CurrentConvention::Rms, 1.5 * 2.0_f64.sqrt() * pl, amplitude / 2.0_f64.sqrt()),
                (CurrentConvention::Dc, 3.0 * 3.0_f64.sqrt() / PI * pl, torque / (3.0 * 3.0_f64.sqrt() / PI * pl)),
                (CurrentConvention::QAxis, 1.5_f64.sqrt() * pl, 1.5_f64.sqrt() * amplitude),
            ];
            let back_emf = [
                (BackEmfConvention::QAxis, 1.5_f64.sqrt() * pl),
                (BackEmfConvention::LineToLinePeak, 3.0_f64.sqrt() * pl),
                (BackEmfConvention::LineToLineRms, 1.5_f64.sqrt() * pl),
                (BackEmfConvention::PhasePeak, pl),
                (BackEmfConvention::PhaseRms, pl / 2.0_f64.sqrt()),
                (BackEmfConvention::Dc, 3.0 * 3.0_f64.sqrt() / PI * pl),
            ];
            let resistances = [
                (Terminals::LineToLine, None, 2.0 * machine.phase_resistance),
                (Terminals::Winding, Some(Winding::Wye), machine.phase_resistance),
                (Terminals::Winding, Some(Winding::Delta), 3.0 * machine.phase_resistance),
                (Terminals::QAxis, None, machine.phase_resistance),
            ];
            let brushless = Commutation::Brushless;
            for (convention, printed, reading) in sheets {
                let k_t = printed * convention.torque_constant(brushless);
                let i = reading * convention.torque_current(brushless);
                assert_relative_eq!(k_t * i, torque, max_relative = 1e-12);
                for (emf, printed) in back_emf {
                    let k_b = printed * emf.back_emf_constant(brushless);
                    assert_relative_eq!(k_b, k_t, max_relative = 1e-12);
                    for (terminals, winding, printed) in resistances {
                        let r = printed * terminals.resistance(winding, brushless).unwrap();
                        assert_relative_eq!(r * i * i, loss, max_relative = 1e-9);
                        assert_relative_eq!(r * i * i + k_b * speed * i, power, max_relative = 1e-9);
                    }
                }
            }
            // Block commutation: a DC ampere flows through two windings in series, so its heat is
            // 2 R_phase i², which the heating factor must reproduce.
            let heating = 3.0 * CurrentConvention::Dc.heating_current(brushless);
            assert_relative_eq!(
                machine.phase_resistance * heating * heating,
                2.0 * machine.phase_resistance * 9.0,
                max_relative = 1e-12
            );
            // Speed constants are the inverse of the back-EMF they are taken on.
            for (speed_convention, emf) in [
                (SpeedConstantConvention::LineToLinePeak, 3.0_f64.sqrt() * pl),
                (SpeedConstantConvention::Dc, 3.0 * 3.0_f64.sqrt() / PI * pl),
            ] {
                assert_relative_eq!(
                    speed_convention.back_emf_constant(brushless) * emf,
                    1.5_f64.sqrt() * pl,
                    max_relative = 1e-12
                );
            }
            assert!(!machine.name.is_empty());
        }
    }

    #[test]
    fn the_factors_are_those_on_paper() {
        assert_relative_eq!(BLOCK, 0.740_480_489_693, max_relative = 1e-9);
        let brushless = Commutation::Brushless;
        assert_relative_eq!(
            CurrentConvention::Dc.torque_current(brushless),
            3.0 * 2.0_f64.sqrt() / PI,
            max_relative = 1e-12
        );
        // 8.27/Kv is the phase-amplitude torque constant of an outrunner; rms is √2 of it.
        let kv = crate::units::quantity("100 rpm/V", &crate::units::SPEED_CONSTANT).unwrap();
        let q = SpeedConstantConvention::LineToLinePeak.back_emf_constant(brushless) / kv;
        assert_relative_eq!(
            q / CurrentConvention::PhaseAmplitude.torque_constant(brushless),
            0.0827,
            max_relative = 1e-3
        );
        // Voltage: the largest line-to-line voltage under space-vector modulation is the bus.
        let line_to_line_peak =
            Modulation::SpaceVector.voltage(brushless) / BackEmfConvention::LineToLinePeak.back_emf_constant(brushless);
        assert_relative_eq!(line_to_line_peak, 1.0, max_relative = 1e-12);
        let phase_peak =
            Modulation::Sine.voltage(brushless) / BackEmfConvention::PhasePeak.back_emf_constant(brushless);
        assert_relative_eq!(phase_peak, 0.5, max_relative = 1e-12);
    }

    #[test]
    fn a_brushed_motor_is_its_own_equivalent() {
        let brushed = Commutation::Brushed;
        assert_relative_eq!(CurrentConvention::Dc.torque_constant(brushed), 1.0);
        assert_relative_eq!(CurrentConvention::Dc.heating_current(brushed), 1.0);
        assert_relative_eq!(SpeedConstantConvention::Dc.back_emf_constant(brushed), 1.0);
        assert_eq!(Terminals::LineToLine.resistance(None, brushed), Some(1.0));
        assert_relative_eq!(Modulation::Sine.voltage(brushed), 1.0);
    }
}
