//! A number of a motor in any convention that a sheet could have printed it in.

use super::Motor;
use super::convention::{BackEmfConvention, CurrentConvention, SpeedConstantConvention, Terminals, Winding};
use super::row::{Convention, Field, States};

/// The value of a word.
fn find<T: Copy>(names: &[(&'static str, T)], word: &str) -> Option<T> {
    names.iter().find(|(name, _)| *name == word).map(|(_, value)| *value)
}

impl Motor {
    /// A number that has a convention, as a sheet of the convention `word` would print it \[SI\]; `None` where the number is
    /// not known, the word is none of its conventions, or the winding would have to be known. A speed constant is that
    /// of the back-EMF constant.
    ///
    /// ```
    /// use gearwise_model::catalog::{Catalog, row::Convention};
    /// let catalog = Catalog::builtin().unwrap();
    /// let motor = catalog.motor("t-motor-u8-lee").unwrap();
    /// let k_t = |word| motor.in_convention(Convention::TorqueConstant, word).unwrap();
    /// assert!((k_t("rms") / k_t("phase_amplitude") - 2.0_f64.sqrt()).abs() < 1e-12);
    /// assert_eq!(k_t("q_axis"), motor.torque_constant);
    /// ```
    pub fn in_convention(&self, of: Convention, word: &str) -> Option<f64> {
        self.in_convention_with(of, word, self.conventions.winding)
    }

    /// The same as if the windings were connected so.
    pub fn in_convention_with(&self, of: Convention, word: &str, winding: Option<Winding>) -> Option<f64> {
        let commutation = self.conventions.commutation;
        let terminals = || find(Terminals::NAMES, word)?.resistance(winding, commutation);
        let current = || find(CurrentConvention::NAMES, word);
        match of {
            Convention::Resistance => Some(self.resistance / terminals()?),
            Convention::Inductance => Some(self.inductance? / terminals()?),
            Convention::TorqueConstant => Some(self.torque_constant / current()?.torque_constant(commutation)),
            Convention::ContinuousCurrent => Some(self.continuous_current? / current()?.heating_current(commutation)),
            Convention::PeakCurrent => Some(self.peak_current? / current()?.torque_current(commutation)),
            Convention::BackEmf => {
                Some(self.back_emf_constant / find(BackEmfConvention::NAMES, word)?.back_emf_constant(commutation))
            }
            Convention::SpeedConstant => {
                let convention = find(SpeedConstantConvention::NAMES, word)?.back_emf_constant(commutation);
                // The row's own number, where it has one: the model computes with K_T, which a sheet rounds differently.
                match (self.sheet.speed_constant, self.conventions.speed_constant) {
                    (Some(own), Some(of)) => Some(own.value * convention / of.back_emf_constant(commutation)),
                    _ => Some(convention / self.back_emf_constant),
                }
            }
        }
    }

    /// A numeric column with one meaning for all rows \[SI\]: on the q axis where sheets differ, else as printed; the motor
    /// constant is √(K_T K_B/R) of every row, printed or not. `None` where it is not known, and of the speed constant, which has no
    /// form on the q axis.
    pub fn comparable(&self, field: &Field) -> Option<f64> {
        match field.states {
            States::Convention(of) => self.in_convention(of, "q_axis"),
            _ if field.name == "motor_constant" => Some(self.motor_constant()).filter(|k| k.is_finite()),
            _ => (field.get)(&self.sheet).map(|p| p.value),
        }
    }
}
