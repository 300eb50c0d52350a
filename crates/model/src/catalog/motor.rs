//! A motor as the program computes with it: the power-invariant q-axis equivalent of its sheet.

use std::sync::Arc;

use super::about::{About, PeakTorqueOf};
use super::convention::{Commutation, Terminals};
use super::estimate::{Estimate, Estimated};
use super::fit::{Fit, FittedGear};
use super::module::Inside;
use super::sheet::{Conventions, Printed, Sheet, SourceKind};
use crate::effects::{EFFECTS, Effect, FittedEffect};

/// Winding temperature that a resistance refers to where its row does not say \[K\]: 25 °C.
pub const REFERENCE_TEMPERATURE: f64 = 298.15;

/// Torque constant and speed constant that differ by less (relative) say the same: sheets round both.
const PRINTED_DIGITS: f64 = 0.01;

/// Share by which a peak torque has to be less than K_T I_peak to be more than rounding.
const SATURATES: f64 = 0.005;

/// What a motor is that has other turns than its row.
#[derive(Debug, Clone, PartialEq)]
pub struct Wound {
    /// Id of the row.
    pub of: String,
    /// Turns, as a multiple of the row's.
    pub turns: f64,
}

/// A motor of the catalogue. Numbers are SI, on the q axis (power invariant), at the motor shaft.
#[derive(Debug, Clone)]
pub struct Motor {
    /// Unique name.
    pub id: String,
    /// Who makes it.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// Where the numbers come from.
    pub source: String,
    /// Day, month or year of the source, as 2026-11-01; of one without a date the day on which it was read. Empty: not said.
    pub source_date: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// What the reader of the row should know.
    pub note: String,
    /// Audit findings that the note explains, by code.
    pub accepted_findings: Vec<String>,
    /// How it is built, and how its row belongs with others.
    pub about: About,
    /// The conventions of the sheet.
    pub conventions: Conventions,
    /// The sheet as printed.
    pub sheet: Sheet,
    /// Winding resistance at the reference temperature \[Ω\], R.
    pub resistance: f64,
    /// Synchronous inductance \[H\], L; unknown where the sheet does not say.
    pub inductance: Option<f64>,
    /// Torque constant \[N·m/A\], K_T.
    pub torque_constant: f64,
    /// Back-EMF constant \[V·s/rad\], K_B.
    pub back_emf_constant: f64,
    /// Rotor inertia \[kg·m²\], J_m.
    pub rotor_inertia: Option<f64>,
    /// Mass \[kg\], m.
    pub mass: Option<f64>,
    /// Pole pairs, p.
    pub pole_pairs: Option<u32>,
    /// Current that can flow for ever \[A\] (by its heat).
    pub continuous_current: Option<f64>,
    /// Largest current \[A\] (by its torque).
    pub peak_current: Option<f64>,
    /// What is inside the module that it stands for; `None` of a motor.
    pub inside: Option<Arc<Inside>>,
    /// What it is where it has other turns than its row.
    pub wound: Option<Wound>,
    /// Largest q-axis ampere against the magnets, at their hottest \[A\].
    pub demagnetization_current: Option<f64>,
    /// Torque that can be held for ever \[N·m\].
    pub continuous_torque: Option<f64>,
    /// Largest torque \[N·m\].
    pub peak_torque: Option<f64>,
    /// Largest speed \[rad/s\].
    pub max_speed: Option<f64>,
    /// Thermal resistance winding to ambient \[K/W\]: both steps, where both are known.
    pub thermal_resistance: Option<f64>,
    /// Highest winding temperature \[K\].
    pub max_winding_temperature: Option<f64>,
    /// Temperature that the resistance refers to \[K\].
    pub reference_temperature: f64,
    /// Coulomb friction \[N·m\], c; `None` is unknown.
    pub coulomb_friction: Option<f64>,
    /// Viscous friction \[N·m·s/rad\], b; `None` is unknown.
    pub viscous_friction: Option<f64>,
    /// Torque of the drag without load \[N·m\], T_0: K_T I_0 of the row, or estimated. See [`Motor::drag`].
    pub no_load_torque: Option<f64>,
    /// Effects that were found in logs of this actuator, beyond friction of its row; empty for a data sheet.
    pub effects: Vec<FittedEffect>,
    /// Numbers of the gear that it was fitted with.
    pub fitted_gear: Option<FittedGear>,
    /// Where a fitted actuator comes from.
    pub fit: Option<Fit>,
    /// Thermal resistance winding to ambient \[K/W\] that a continuous current or torque says at most, of a row without
    /// thermal resistances: an estimate, for a temperature that a requirement states.
    pub rated_thermal_resistance: Option<f64>,
    /// What of the numbers above is estimated, because the row does not say it.
    pub estimates: Vec<Estimate>,
    /// What had to be assumed to make the equivalent.
    pub assumptions: Vec<&'static str>,
}

/// Identity and provenance of a row, everything that is text.
#[derive(Debug, Clone)]
pub struct Identity {
    /// Unique name.
    pub id: String,
    /// Who makes it.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// Where the numbers come from.
    pub source: String,
    /// Day, month or year of the source, as 2026-11-01; of one without a date the day on which it was read. Empty: not said.
    pub source_date: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// What the reader of the row should know.
    pub note: String,
    /// Audit findings that the note explains.
    pub accepted_findings: Vec<String>,
    /// How it is built, and how the row belongs with others.
    pub about: About,
}

/// Why a sheet has no q-axis equivalent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Incomplete {
    /// No resistance, and none can be derived.
    Resistance,
    /// Neither torque constant nor back-EMF or speed constant.
    TorqueConstant,
    /// Resistance per winding, but wye or delta is not said.
    Winding,
    /// A back-EMF constant without its convention.
    BackEmfConvention,
    /// A speed constant without its convention.
    SpeedConstantConvention,
}

impl Motor {
    /// Back-EMF constant that the voltage and the power of a joint are computed with \[V·s/rad\]: no less than the torque
    /// constant, or the motor would make energy from nothing. Metrics take the row's own.
    pub fn emf_constant(&self) -> f64 {
        self.back_emf_constant.max(self.torque_constant)
    }

    /// The values of an effect that the row declares, where it does.
    pub fn declared(&self, effect: &dyn Effect) -> Option<Vec<f64>> {
        let value = match effect.column()? {
            "coulomb_friction" => self.coulomb_friction,
            "viscous_friction" => self.viscous_friction,
            _ => None,
        };
        value.map(|value| vec![value])
    }

    /// Everything that the motor has beyond its constants, as one list: the effects that columns of its row declare, in the
    /// order of the library, then those that were fitted for it.
    pub fn all_effects(&self) -> impl Iterator<Item = FittedEffect> + '_ {
        let columns = EFFECTS.iter().filter_map(|e| Some(FittedEffect { effect: *e, values: self.declared(*e)? }));
        columns.chain(self.effects.iter().cloned())
    }

    /// Motor constant √(K_T K_B/R) \[N·m/√W\]: not a number where the row has no constants.
    pub fn motor_constant(&self) -> f64 {
        (self.torque_constant * self.back_emf_constant / self.resistance).sqrt()
    }

    /// Whether a number of it is estimated.
    pub fn is_estimated(&self, of: Estimated) -> bool {
        self.estimates.iter().any(|e| e.of == of)
    }

    /// Identity and provenance of its row.
    pub fn identity(&self) -> Identity {
        Identity {
            id: self.id.clone(),
            manufacturer: self.manufacturer.clone(),
            model: self.model.clone(),
            source: self.source.clone(),
            source_date: self.source_date.clone(),
            source_kind: self.source_kind,
            note: self.note.clone(),
            accepted_findings: self.accepted_findings.clone(),
            about: self.about.clone(),
        }
    }

    /// Converts a sheet to its q-axis equivalent.
    ///
    /// # Errors
    /// What is missing for it.
    pub fn new(
        identity: Identity,
        conventions: Conventions,
        sheet: Sheet,
        pole_pairs: Option<u32>,
    ) -> Result<Motor, Incomplete> {
        let commutation = conventions.commutation;
        let mut assumptions = Vec::new();
        let value = |p: Option<Printed>| p.map(|p| p.value);
        let winding =
            |terminals: Terminals| terminals.resistance(conventions.winding, commutation).ok_or(Incomplete::Winding);
        let (of_resistance, of_inductance) =
            (winding(conventions.of_resistance())?, winding(conventions.of_inductance())?);
        let resistance = sheet.resistance.ok_or(Incomplete::Resistance)?.value * of_resistance;
        let by_back_emf = match (sheet.back_emf_constant, conventions.back_emf) {
            (Some(k), Some(convention)) => Some(k.value * convention.back_emf_constant(commutation)),
            (Some(_), None) => return Err(Incomplete::BackEmfConvention),
            (None, _) => None,
        };
        let by_speed = match (sheet.speed_constant, conventions.speed_constant) {
            (Some(k), Some(convention)) => Some(convention.back_emf_constant(commutation) / k.value),
            (Some(_), None) => return Err(Incomplete::SpeedConstantConvention),
            (None, _) => None,
        };
        let torque_constant = match (sheet.torque_constant, by_back_emf.or(by_speed)) {
            (Some(k), _) => k.value * conventions.of_torque_constant().torque_constant(commutation),
            (None, Some(k)) => {
                assumptions.push("torque constant taken equal to the back-EMF constant");
                k
            }
            (None, None) => return Err(Incomplete::TorqueConstant),
        };
        // A speed constant beside a torque constant tells the back-EMF, where more than printed digits part the two. One
        // that is less than the torque takes would make energy from nothing.
        let by_speed = by_speed.filter(|by_speed| {
            let more = by_speed / torque_constant - 1.0;
            if more < -PRINTED_DIGITS && by_back_emf.is_none() {
                assumptions.push("the speed constant says a back-EMF constant below the torque constant: not used");
            }
            sheet.torque_constant.is_none() || more > PRINTED_DIGITS
        });
        let back_emf_constant = by_back_emf.or(by_speed).unwrap_or_else(|| {
            if sheet.torque_constant.is_some() {
                assumptions.push("back-EMF constant taken equal to the torque constant");
            }
            torque_constant
        });
        if back_emf_constant < torque_constant {
            assumptions.push(
                "a back-EMF constant below the torque constant would make energy: for voltage and power of a joint the torque constant is taken for both",
            );
        }
        if sheet.reference_temperature.is_none() {
            assumptions.push("resistance taken at 25 degC");
        }
        let series = |a: Option<f64>, b: Option<f64>| Some(a? + b?);
        Ok(Motor {
            resistance,
            inductance: value(sheet.inductance).map(|l| l * of_inductance),
            torque_constant,
            back_emf_constant,
            rotor_inertia: value(sheet.rotor_inertia),
            mass: value(sheet.mass),
            pole_pairs: if commutation == Commutation::Brushed { Some(0) } else { pole_pairs },
            continuous_current: value(sheet.continuous_current)
                .map(|i| i * conventions.of_continuous_current().heating_current(commutation)),
            peak_current: value(sheet.peak_current)
                .map(|i| i * conventions.of_peak_current().torque_current(commutation)),
            inside: None,
            wound: None,
            demagnetization_current: value(sheet.demagnetization_current)
                .map(|i| i * conventions.current.torque_current(commutation)),
            continuous_torque: value(sheet.continuous_torque),
            peak_torque: value(sheet.peak_torque),
            max_speed: value(sheet.max_speed),
            thermal_resistance: series(
                value(sheet.thermal_resistance_winding_housing),
                value(sheet.thermal_resistance_housing_ambient),
            ),
            max_winding_temperature: value(sheet.max_winding_temperature),
            reference_temperature: value(sheet.reference_temperature).unwrap_or(REFERENCE_TEMPERATURE),
            coulomb_friction: value(sheet.coulomb_friction),
            viscous_friction: value(sheet.viscous_friction),
            no_load_torque: value(sheet.no_load_current)
                .map(|i| i * conventions.current.torque_current(commutation) * torque_constant)
                .filter(|torque| *torque > 0.0),
            id: identity.id,
            manufacturer: identity.manufacturer,
            model: identity.model,
            source: identity.source,
            source_date: identity.source_date,
            source_kind: identity.source_kind,
            note: identity.note,
            accepted_findings: identity.accepted_findings,
            about: identity.about,
            conventions,
            sheet,
            effects: Vec::new(),
            fitted_gear: None,
            fit: None,
            rated_thermal_resistance: None,
            estimates: Vec::new(),
            assumptions,
        })
    }

    /// The current i_s \[A\] of T = K_T i_s tanh(i/i_s) through the row's peak torque: at its linearity where the row prints it, else at its
    /// peak current where the row says that the torque is the motor's own, and it is less than K_T I_peak by more than printed digits leave.
    /// `None` elsewhere, and of a motor with a fit, whose logs say what its iron does.
    pub fn saturation_current(&self) -> Option<f64> {
        let own = self.about.peak_torque_of == Some(PeakTorqueOf::Motor) && self.sheet.peak_current.is_some();
        let torque = self.peak_torque.filter(|_| self.sheet.peak_torque.is_some())?;
        let (share, current) = match self.sheet.peak_torque_linearity {
            Some(printed) => (printed.value, torque / (self.torque_constant * printed.value)),
            None => {
                let current = self.peak_current.filter(|_| own)?;
                (torque / (self.torque_constant * current), current)
            }
        };
        if self.fit.is_some() || !self.effects.is_empty() || !(share > 0.0 && share < 1.0 - SATURATES) {
            return None;
        }
        // tanh(x)/x falls from 1, and is below the share at 1/share.
        let (mut low, mut high) = (0.0_f64, 1.0 / share);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle.tanh() > share * middle { low = middle } else { high = middle }
        }
        Some(current / high)
    }

    /// `L` and `p` where the dq voltage can be computed: an unknown inductance or unknown pole pairs
    /// make it unknown. A brushed motor has no d axis.
    pub fn inductance_and_poles(&self) -> Option<(f64, f64)> {
        Some((self.inductance?, f64::from(self.pole_pairs?)))
    }
}
