//! The fitted actuator: what the logs say of a machine, as one set of facts.
//!
//! The one idea: every number knows which fitted numbers it follows from, and how. So its ± and the covariance are one
//! statement, and the file that is written and the choice that is made again are of the same actuator. The row is made on
//! the q axis with the digits that a file has, through the same door as the row of any file: [`Motor::new`].
//!
//! Where two equations see one parameter, that with the least standard error says it, alone: equations of a bench
//! share instruments, so a mean of them would claim more than was measured. What the others see is in the note.

mod numbers;

use self::numbers::{Fits, Number, coefficient};
use super::answer::Report;
use super::bench::{Bench, Use};
use crate::answer::INTERVAL;
use crate::characterize::row::REDUNDANT;
use gearwise_model::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals};
use gearwise_model::catalog::fitted::FittedGear;
use gearwise_model::catalog::fitted::{Axis, Fit, Fitted, Provenance, settled, settled_difference};
use gearwise_model::catalog::{
    About, Conventions, FIELDS, Field, Identity, Motor, OwnConventions, Printed, Sheet, SourceKind,
};
use gearwise_model::effects::{EFFECTS, Effect, FittedEffect, Named, Shape, of_column, of_efficiency};
use gearwise_model::input::Range;
use gearwise_model::requirement::backdrive_efficiency;
use gearwise_model::words::number;

/// The declared actuator with the numbers that were fitted and the effects that were found. What the logs do not show is
/// as declared, with its own ±; a fitted number's ± is that of 95 %. `None` where the numbers make no row,
/// which no bench file that was read leads to.
pub fn fitted_actuator(bench: &Bench, reports: &[Report]) -> Option<Fitted> {
    let mut builder =
        Builder { fits: Fits::new(bench, reports), tolerances: Vec::new(), named: Vec::new(), notes: Vec::new() };
    match &bench.declared.motor {
        Some(motor) => builder.motor(motor).map(|motor| Fitted::Motor(Box::new(motor))),
        None => Some(Fitted::Axis(Box::new(builder.axis()))),
    }
}

/// The fitted actuator as a motor; `None` for a linear axis, which has no motor of a catalogue.
pub fn fitted_motor(bench: &Bench, reports: &[Report]) -> Option<Motor> {
    match fitted_actuator(bench, reports)? {
        Fitted::Motor(motor) => Some(*motor),
        Fitted::Axis(_) => None,
    }
}

/// What is gathered on the way.
struct Builder<'a> {
    fits: Fits<'a>,
    /// ± of the effects' parameters.
    tolerances: Vec<(String, f64)>,
    /// Numbers that follow from fitted ones, by their place in the file.
    named: Vec<(String, Number)>,
    notes: Vec<String>,
}

/// Numbers of the motor that are worked out together.
struct Constants {
    torque_constant: Option<Number>,
    back_emf: Option<Number>,
    resistance: Option<Number>,
}

impl Builder<'_> {
    fn motor(&mut self, motor: &Motor) -> Option<Motor> {
        let constants = self.constants(motor);
        let mut sheet = Sheet::default();
        for field in FIELDS.iter().filter(|f| !REDUNDANT.contains(&f.name)) {
            let fitted = self.column(motor, field, &constants).filter(|n| field.range.contains(n.value));
            let printed = match fitted {
                Some(fitted) => Some(self.printed(format!("motor.{}", field.name), &fitted, field.kind.si)),
                None => declared(motor, field),
            };
            if let Some(printed) = printed {
                (field.set)(&mut sheet, printed);
            }
        }
        sheet.offer = motor.sheet.offer.clone();
        let gear = self.gear(motor);
        let effects = self.effects(true);
        self.keep_drag(motor, &mut sheet, &effects);
        // A brushed motor's ampere is the q axis' already.
        let brushed = motor.conventions.commutation == Commutation::Brushed;
        let conventions = Conventions {
            commutation: motor.conventions.commutation,
            terminals: Terminals::QAxis,
            winding: motor.conventions.winding,
            current: if brushed { CurrentConvention::Dc } else { CurrentConvention::QAxis },
            back_emf: sheet.back_emf_constant.map(|_| BackEmfConvention::QAxis),
            speed_constant: None,
            own: OwnConventions::default(),
        };
        let poles = motor.pole_pairs.filter(|_| !brushed);
        let made = Motor::new(self.identity(motor), conventions, sheet, poles).ok()?;
        let fit = Fit { entry: motor.machine_id().to_string(), ..self.finish() };
        Some(Motor { effects, fitted_gear: gear, fit: Some(fit), ..made })
    }

    /// The friction of the catalogue entry, where the logs cannot show any: it stays as the entry says. Where they were asked for Coulomb
    /// friction and showed none, it is zero.
    fn keep_drag(&mut self, motor: &Motor, sheet: &mut Sheet, effects: &[FittedEffect]) {
        if sheet.coulomb_friction.is_some() || effects.iter().any(FittedEffect::is_friction) {
            return;
        }
        let coulomb = "coulomb_friction";
        if self.fits.asked_for(coulomb) {
            sheet.coulomb_friction = Some(Printed { value: 0.0, tolerance: None });
            self.notes.push("the logs show no Coulomb friction".into());
            return;
        }
        let Some(torque) = motor.no_load_torque else { return };
        // No-load torque of the entry, with the torque constant of this machine.
        let constant = sheet.torque_constant.or(sheet.back_emf_constant).map_or(motor.torque_constant, |p| p.value);
        let share = motor.sheet.no_load_current.and_then(|p| p.relative_tolerance());
        let current = settled(torque / constant, "A");
        sheet.no_load_current = Some(Printed { value: current, tolerance: share.map(|share| share * current) });
        sheet.no_load_speed = motor.sheet.no_load_speed;
        self.notes.push("no-load friction is that of the entry: the logs cannot show it".into());
    }

    fn identity(&mut self, motor: &Motor) -> Identity {
        let bench = self.fits.bench;
        self.notes.extend(self.fits.disagreements());
        self.notes.push(format!("fitted row of `{}`", motor.id));
        if bench.declared.ratio != 1.0 {
            self.notes.push(format!(
                "measured behind a gear of {}: friction and inertia at the motor contain the gear's input side",
                number(bench.declared.ratio)
            ));
        }
        let logs = bench.logs.len();
        Identity {
            id: format!("{}-fitted", motor.id),
            manufacturer: motor.manufacturer.clone(),
            model: motor.model.clone(),
            source: format!(
                "identified from {logs} {} of the bench `{}` ({}); what they do not show: {}",
                if logs == 1 { "log" } else { "logs" },
                bench.name,
                bench.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
                motor.source
            ),
            source_date: String::new(),
            source_kind: SourceKind::Measured,
            note: self.notes.join("; "),
            // What its note explains is of the numbers as they were printed.
            accepted_findings: Vec::new(),
            about: About { same_as: String::new(), ..motor.about.clone() },
        }
    }

    /// K_T, K_B and R where the logs show them. From duty alone K_T/R is seen: with the resistance that holds.
    fn constants(&mut self, motor: &Motor) -> Constants {
        let positive = |n: &Number| n.value > 0.0;
        let resistance = self.fits.best("resistance", |_| true).filter(positive);
        let back_emf = self.fits.best("back_emf_constant", |_| true).filter(positive);
        let direct = self.fits.best("torque_constant", |f| !f.sees_quotient).filter(positive);
        let torque_constant = direct.or_else(|| {
            let quotient = self.fits.best("torque_constant", |f| f.sees_quotient).filter(positive)?;
            self.notes
                .push("only K_T/R is identifiable from duty and position: K_T is that with this resistance".into());
            Some(match &resistance {
                Some(r) => quotient.times(&r.by_factor(1.0 / motor.resistance)),
                None => quotient,
            })
        });
        Constants { torque_constant, back_emf, resistance }
    }

    /// A column that follows from fitted numbers, on the q axis; `None` where it stays as declared.
    fn column(&mut self, motor: &Motor, field: &Field, constants: &Constants) -> Option<Number> {
        match field.name {
            "resistance" => constants.resistance.clone(),
            "inductance" => self.fits.best("inductance", |_| true),
            "torque_constant" => constants.torque_constant.clone(),
            "back_emf_constant" => constants.back_emf.clone(),
            "rotor_inertia" => {
                // J_m + J_g was seen: the gear keeps what it declares. Less than that is no rotor.
                let gear = self.fits.bench.declared.gear.inertia;
                let seen = self.fits.best("inertia", |_| true)?;
                let rotor = seen.plus(-gear);
                if rotor.value <= 0.0 {
                    self.notes.push("the fitted inertia is less than the gear's: the rotor's is as declared".into());
                    return None;
                }
                if gear > 0.0 {
                    self.notes.push("the gear's inertia is taken as declared".into());
                }
                Some(rotor)
            }
            column => {
                let effect = of_column(column)?;
                let declared = self.fits.declared_effect(effect).map(Number::exact);
                let fitted = match effect.is_damping() {
                    true => self.viscous(effect, motor, constants),
                    false => self.fits.best(&coefficient(effect), |_| true).filter(|n| n.value >= 0.0),
                };
                fitted.or(declared)
            }
        }
    }

    /// Viscous friction b. Where a voltage drives, what opposes motion holds the back-EMF too: `D = b + K_T K_B/R`,
    /// with the K_T/R of the same fit.
    fn viscous(&mut self, effect: &'static dyn Effect, motor: &Motor, constants: &Constants) -> Option<Number> {
        let direct = self.fits.best(&coefficient(effect), |f| !f.sees_quotient).filter(|n| n.value >= 0.0);
        if direct.is_some() {
            return direct;
        }
        let back_emf = match (&constants.back_emf, &constants.torque_constant) {
            (Some(own), _) => own.clone(),
            // A row that gives only one of the two constants takes the other from it.
            (None, Some(k)) if motor.sheet.back_emf_constant.or(motor.sheet.speed_constant).is_none() => k.clone(),
            _ => Number::exact(motor.back_emf_constant),
        };
        let (damping, quotient) = self.fits.damping(motor)?;
        let taken = back_emf.times(&quotient);
        let left = damping.minus(&taken);
        let error = self.fits.error(&left).unwrap_or(0.0);
        if left.value >= 0.0 {
            self.notes.push("viscous friction is the fitted damping less K_T K_B/R".into());
            return Some(left);
        }
        if left.value > -2.0 * error {
            self.notes.push("the fitted damping is that of the back-EMF: viscous friction is zero within its ±".into());
            return Some(Number { value: 0.0, ..left });
        }
        self.notes.push(
            "the fitted damping is less than K_T K_B/R: K_B is smaller than declared, and viscous friction as declared"
                .into(),
        );
        None
    }

    /// A linear axis has no row: its mass and friction.
    fn axis(&mut self) -> Axis {
        let bench = self.fits.bench;
        let declared = &bench.declared;
        let effects = self.effects(false);
        self.notes.extend(self.fits.disagreements());
        let mut one = |place: &str, own: Option<f64>, unit: &str, range: Range| {
            let effect = of_column(place);
            let name = effect.map_or_else(|| place.to_string(), coefficient);
            let fitted = self.fits.best(&name, |_| true).filter(|n| range.contains(n.value));
            let known = || effect.and_then(|e| self.fits.declared_effect(e)).or(own).map(Number::exact);
            fitted.or_else(known).map(|n| self.printed(format!("axis.{place}"), &n, unit))
        };
        let mass = one("mass", declared.mass, "kg", Range::Positive);
        let viscous_friction = one("viscous_friction", declared.viscous_friction, "N*s/m", Range::NonNegative);
        let coulomb_friction = one("coulomb_friction", declared.coulomb_friction, "N", Range::NonNegative);
        Axis {
            id: format!("{}-fitted", bench.name),
            note: self.notes.join("; "),
            mass,
            viscous_friction,
            coulomb_friction,
            effects,
            fit: self.finish(),
        }
    }

    /// What load-dependent friction says of the gear: `η = 1/(1 + γ)` forwards, `η_b = 1 − γ` backwards.
    fn gear(&mut self, motor: &Motor) -> Option<FittedGear> {
        let ratio = self.fits.bench.declared.ratio;
        let mut gear = motor.fitted_gear.unwrap_or_default();
        let loss = of_efficiency();
        let fitted = loss.and_then(|e| self.fits.best(&coefficient(e), |_| true)).filter(|f| f.value > 0.0);
        // What was fitted is the whole loss; what was only declared beyond the row adds to that of the row's gear.
        let own = gear.efficiency.filter(|_| fitted.is_none()).unwrap_or(1.0);
        let back = gear.backdrive_efficiency.filter(|_| fitted.is_none()).unwrap_or_else(|| backdrive_efficiency(own));
        let factor = fitted.or_else(|| self.fits.declared_effect(loss?).map(Number::exact));
        if let Some(factor) = &factor {
            let whole = 1.0 / own + factor.value;
            let efficiency = factor.through(1.0 / whole, -1.0 / (whole * whole));
            let backdrive = factor.through(back - factor.value, -1.0);
            gear.efficiency = Some(self.of_gear("gear.efficiency", &efficiency));
            gear.backdrive_efficiency = Some(self.of_gear("gear.backdrive_efficiency", &backdrive));
        }
        if ratio != 1.0 || factor.is_some() {
            gear.ratio = Some(settled(ratio, "1"));
        }
        (gear != FittedGear::default()).then_some(gear)
    }

    /// A number of the gear as a file has it. Its ± is kept.
    fn of_gear(&mut self, name: &str, found: &Number) -> f64 {
        let printed = self.printed(name.into(), found, "1");
        self.tolerances.extend(printed.tolerance.map(|tolerance| (name.into(), tolerance)));
        printed.value
    }

    /// Effects that were found, and those that were declared beyond the row, with their fitted values: in the order of
    /// the library.
    fn effects(&mut self, turns: bool) -> Vec<FittedEffect> {
        let mut effects = Vec::new();
        for effect in EFFECTS.iter().copied().filter(|e| !has_a_column(*e, turns)) {
            for instance in self.fits.instances(effect) {
                effects.extend(self.instance(effect, &instance));
            }
        }
        effects
    }

    /// One instance of an effect; what a file may not hold stays as it was declared, or is left out.
    fn instance(&mut self, effect: &'static dyn Effect, instance: &[f64]) -> Option<FittedEffect> {
        let fitted = self.fits.values(effect, instance);
        let holds = |index: usize, value: f64| match index {
            i if i >= effect.linear() && effect.shape() != Shape::None => Range::Positive.contains(value),
            _ if effect.is_signed() => value.is_finite(),
            _ => Range::NonNegative.contains(value),
        };
        let good = fitted.iter().enumerate().all(|(k, n)| holds(k, n.value));
        if !good {
            self.notes.push(format!("`{}` has a sign that it cannot have: it stays as declared", effect.name()));
        }
        let numbers = if good { fitted } else { instance.iter().map(|v| Number::exact(*v)).collect() };
        if !good && !instance.iter().enumerate().all(|(k, v)| holds(k, *v)) {
            return None;
        }
        let mut values = Vec::new();
        for (parameter, found) in effect.parameters().iter().zip(&numbers) {
            let name = Named::new(effect, instance.last().copied(), parameter.name).to_string();
            let printed = self.printed(format!("effects.{name}"), found, parameter.kind.si);
            self.tolerances.extend(printed.tolerance.map(|tolerance| (name, tolerance)));
            values.push(printed.value);
        }
        Some(FittedEffect { effect, values })
    }

    /// A number as a file has it, with its ± (95 %).
    fn printed(&mut self, place: String, found: &Number, unit: &str) -> Printed {
        let error = self.fits.error(found).filter(|e| e.is_finite() && *e > 0.0);
        if !found.by.is_empty() {
            self.named.push((place, found.clone()));
        }
        let tolerance = error.map(|e| settled_difference(INTERVAL * e));
        Printed { value: settled(found.value, unit), tolerance }
    }

    /// Version, covariance and logs.
    fn finish(&mut self) -> Fit {
        let named = std::mem::take(&mut self.named);
        let covariance = |a: usize, b: usize| {
            let own = if a == b { named[a].1.loose } else { 0.0 };
            settled_difference(self.fits.covariance(&named[a].1, &named[b].1) + own)
        };
        let logs = self.fits.bench.logs.iter();
        Fit {
            entry: String::new(),
            version: env!("CARGO_PKG_VERSION").to_string(),
            tolerances: std::mem::take(&mut self.tolerances),
            covariance: (0..named.len()).map(|a| (0..named.len()).map(|b| covariance(a, b)).collect()).collect(),
            provenance: logs
                .map(|log| Provenance {
                    log: log.name.clone(),
                    sha256: Some(log.hash.clone()),
                    usage: Some(if log.usage == Use::Fit { "fit" } else { "held_out" }.into()),
                })
                .collect(),
            names: named.into_iter().map(|(place, _)| place).collect(),
        }
    }
}

/// Effects that have a column of the row or of the gear. An axis has no gear.
fn has_a_column(effect: &dyn Effect, turns: bool) -> bool {
    effect.column().is_some() || (turns && of_efficiency().is_some_and(|e| e == effect))
}

/// A column on the q axis as declared, with its own ±.
fn declared(motor: &Motor, field: &Field) -> Option<Printed> {
    let printed = (field.get)(&motor.sheet);
    let (value, of) = match field.name {
        "resistance" => (Some(motor.resistance), printed),
        "inductance" => (motor.inductance, printed),
        // Where the sheet has only one of the two constants, the other is taken equal again.
        "torque_constant" => (printed.map(|_| motor.torque_constant), printed),
        "back_emf_constant" => {
            let of = printed.or(motor.sheet.speed_constant);
            (of.map(|_| motor.back_emf_constant), of)
        }
        "rotor_inertia" => (motor.rotor_inertia, printed),
        "continuous_current" => (motor.continuous_current, printed),
        "peak_current" => (motor.peak_current, printed),
        column => match of_column(column) {
            Some(effect) => (motor.declared(effect).map(|values| values[0]), printed),
            None => (printed.map(|p| p.value), printed),
        },
    };
    let value = value?;
    let tolerance = of.and_then(|p| p.relative_tolerance()).map(|t| t * value.abs());
    Some(Printed {
        value: settled(value, field.kind.si),
        tolerance: tolerance.filter(|t| *t > 0.0).map(settled_difference),
    })
}
