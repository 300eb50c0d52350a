//! The constants of a module at the flange and on the q axis, once.

use super::{Module, TorqueLoss};
use crate::catalog::Printed;
use crate::catalog::convention::Commutation;
use crate::catalog::row::Side;

/// The constants of a module's motor as seen at the flange: SI, q axis, power invariant. `None` is unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Constants {
    /// Torque per ampere in the winding, without the gear's loss \[N·m/A\]: N K_T.
    pub torque_constant: Option<f64>,
    /// Back-EMF per speed of the flange \[V·s/rad\]: N K_B.
    pub back_emf_constant: Option<f64>,
    /// Winding resistance \[Ω\].
    pub resistance: Option<f64>,
    /// Inductance \[H\].
    pub inductance: Option<f64>,
    /// Electrical turns per turn of the flange: p N.
    pub pole_pairs: Option<f64>,
    /// Inertia of rotor and gear \[kg·m²\].
    pub inertia: Option<f64>,
    /// Efficiency of the gear when the motor drives, and how it is known.
    pub efficiency: Option<(f64, EfficiencyFrom)>,
    /// Efficiency of the gear when the load drives, where the row says it.
    pub backdrive_efficiency: Option<f64>,
    /// ± of the two constants as shares, where the number that they come from has one.
    pub spread: Spread,
}

/// ± of constants as shares of them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spread {
    /// Of the torque constant.
    pub torque_constant: Option<f64>,
    /// Of the back-EMF constant.
    pub back_emf_constant: Option<f64>,
}

/// How a module's gear efficiency is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EfficiencyFrom {
    /// The row says it.
    Row,
    /// From the torque per ampere that was measured at the flange, over the back-EMF constant.
    TorqueConstant,
    /// From the torques that it gives while it drives and while it is driven.
    Braking,
}

impl EfficiencyFrom {
    /// What is said of it, where it is not the row's own.
    pub fn says(self) -> Option<&'static str> {
        match self {
            EfficiencyFrom::Row => None,
            EfficiencyFrom::TorqueConstant => Some(
                "the gear's efficiency is the torque constant measured at the flange over N times the back-EMF constant",
            ),
            EfficiencyFrom::Braking => {
                Some("the gear's efficiency follows from the peak torques while it drives and while it is driven")
            }
        }
    }
}

impl Module {
    /// What a number at a side is at the flange: N to this power times as much from the motor.
    pub fn at_output(&self, number: Option<Printed>, side: Option<Side>, power: i32) -> Option<f64> {
        let number = number?.value;
        Some(match side? {
            Side::Output => number,
            Side::Motor => number * self.ratio().powi(power),
        })
    }

    /// Its constants at the flange.
    pub fn constants(&self) -> Constants {
        let (sheet, refers, brushless) = (&self.sheet, &self.refers, Commutation::Brushless);
        let of_winding = refers.terminals.and_then(|terminals| terminals.resistance(refers.winding, brushless));
        let in_winding = |p: Option<Printed>| Some(p?.value * of_winding?);
        let by_emf = refers.back_emf_convention.map(|of| of.back_emf_constant(brushless));
        let by_emf = by_emf.zip(self.at_output(sheet.back_emf_constant, refers.back_emf_side, 1)).map(|(f, k)| f * k);
        // A speed constant falls by N from the motor to the flange.
        let by_speed = refers.speed_constant_convention.map(|of| of.back_emf_constant(brushless));
        let by_speed = by_speed
            .zip(self.at_output(sheet.speed_constant, refers.speed_constant_side, -1))
            .map(|(factor, constant)| factor / constant);
        let at_flange = refers
            .torque_constant_current
            .map(|current| current.torque_constant(brushless))
            .zip(self.at_output(sheet.torque_constant, refers.torque_constant_side, 1))
            .map(|(factor, constant)| factor * constant);
        let measured = refers.torque_constant_side == Some(Side::Output)
            && refers.torque_constant_loss == Some(TorqueLoss::Measured);
        let nominal = at_flange.filter(|_| !measured);
        let back_emf_constant = by_emf.or(nominal).or(by_speed);
        let value = |p: Option<Printed>| p.map(|p| p.value);
        let share = |of: Option<f64>, printed: Option<Printed>| of.and(Some(printed?.relative_tolerance()));
        let of_emf = || share(by_emf, sheet.back_emf_constant).or(share(by_speed, sheet.speed_constant));
        let of_torque = |known| share(known, sheet.torque_constant);
        let spread = Spread {
            torque_constant: of_torque(nominal).or_else(of_emf).or_else(|| of_torque(at_flange)).flatten(),
            back_emf_constant: share(by_emf, sheet.back_emf_constant)
                .or_else(|| of_torque(nominal))
                .or_else(of_emf)
                .flatten(),
        };
        let from_constants =
            || Some((at_flange.filter(|_| measured)? / by_emf.or(by_speed)?, EfficiencyFrom::TorqueConstant));
        let efficiency = value(sheet.efficiency)
            .map(|efficiency| (efficiency, EfficiencyFrom::Row))
            .or_else(from_constants)
            .or_else(|| Some((self.efficiency_of_braking()?, EfficiencyFrom::Braking)))
            .filter(|(efficiency, _)| *efficiency > 0.0 && *efficiency <= 1.0);
        Constants {
            torque_constant: nominal.or(by_emf).or(by_speed).or(at_flange),
            back_emf_constant,
            resistance: in_winding(sheet.resistance),
            inductance: in_winding(sheet.inductance),
            pole_pairs: self.pole_pairs.map(|p| f64::from(p) * self.ratio()),
            inertia: self.at_output(sheet.armature, refers.armature_side, 2),
            efficiency,
            backdrive_efficiency: value(sheet.backdrive_efficiency),
            spread,
        }
    }

    /// η = (1 + Y₁/Y₂)/2 of the largest torques while it drives, Y₁, and while it is driven, Y₂: η η_b = Y₁/Y₂ with
    /// η_b = 2 − 1/η.
    pub fn efficiency_of_braking(&self) -> Option<f64> {
        let most = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).reduce(f64::max);
        let (driving, braking) = (most(&self.driving_curve)?, most(&self.braking_curve)?);
        (braking > 0.0).then_some(0.5 * (1.0 + driving / braking))
    }
}

#[cfg(test)]
mod tests {
    use crate::catalog::Catalog;

    #[test]
    fn the_shipped_modules_are_read() {
        let catalog = match Catalog::builtin() {
            Ok(catalog) => catalog,
            Err(errors) => panic!(
                "{}",
                errors.iter().flat_map(|e| &e.problems).map(|p| format!("{}\n", p.message)).collect::<String>()
            ),
        };
        assert!(catalog.modules.len() >= 72, "{}", catalog.modules.len());
    }
}
