//! A module as the model computes with it: a motor row and the gear inside, whose ratio is fixed.

use std::sync::Arc;

use super::inside::{BUILT_IN, Depth, Inside};
use super::overload::Response;
use super::{Module, Side, TorqueLoss};
use crate::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals};
use crate::catalog::gear::GearKind;
use crate::catalog::module::constants::EfficiencyFrom;
use crate::catalog::row::MotorRow;
use crate::catalog::sheet::{Conventions, OwnConventions, Printed, Sheet};
use crate::catalog::{Catalog, Gear, Motor, is_named};

impl Module {
    /// The module as a motor with the gear inside. Numbers that nobody knows are not: without constants they are no number at
    /// all, and nothing that is computed with them is shown.
    pub fn as_motor(&self, catalog: &Catalog) -> Motor {
        let depth = self.depth();
        let row = |id: &str| catalog.motors.iter().chain(&catalog.aside).find(|m| m.id == id);
        let pair = row(&self.motor).zip(catalog.gears.iter().find(|g| g.id == self.gear));
        let response = self.sheet.rated_torque.and_then(|rated| Response::fit(rated.value, &self.overload));
        if let (Depth::Inside, Some((motor, gear))) = (depth, pair) {
            let inside = Inside {
                module: self.clone(),
                gear: gear.clone(),
                depth,
                says_inertia: motor.rotor_inertia.is_some(),
                says_back_emf: true,
                gear_loss: gear.efficiency.map(|_| EfficiencyFrom::Row),
                loss_in_constant: false,
                response,
            };
            return Motor { id: self.id.clone(), inside: Some(Arc::new(inside)), ..motor.clone() };
        }
        self.by_constants(depth, response)
    }

    fn by_constants(&self, depth: Depth, response: Option<Response>) -> Motor {
        let (constants, ratio, sheet) = (self.constants(), self.ratio(), &self.sheet);
        let loss_in_constant = constants.efficiency.is_none()
            && self.refers.torque_constant_loss == Some(TorqueLoss::Measured)
            && constants.back_emf_constant.is_none();
        let inside = Inside {
            module: self.clone(),
            gear: Gear {
                id: BUILT_IN.into(),
                manufacturer: self.manufacturer.clone(),
                kind: self.kind.unwrap_or(GearKind::Direct),
                ratio,
                efficiency: Some(constants.efficiency.map_or(1.0, |(efficiency, _)| efficiency)),
                backdrive_efficiency: constants.backdrive_efficiency,
                // All that turns is the rotor's.
                mass: Some(0.0),
                inertia: Some(0.0),
                backlash: sheet.backlash.map(|p| p.value),
                stiffness: sheet.stiffness.map(|p| p.value),
                backdriving_torque: sheet
                    .backdriving_torque
                    .filter(|_| self.refers.friction_side != Some(Side::Motor))
                    .map(|p| p.value),
                source: self.source.clone(),
                source_kind: self.source_kind,
                ..Gear::blank()
            },
            depth,
            says_inertia: constants.inertia.is_some(),
            says_back_emf: constants.back_emf_constant.is_some(),
            gear_loss: constants.efficiency.map(|(_, from)| from),
            loss_in_constant,
            response,
        };
        let unknown = |value: Option<f64>| value.map(Printed::exact);
        let of_current = |p: Option<Printed>| {
            let factor = self.refers.current?.torque_current(Commutation::Brushless);
            Some(Printed::exact(p?.value * factor))
        };
        let at_motor = |printed: Option<Printed>, power| {
            unknown(self.at_output(printed, self.refers.friction_side, power).map(|f| f / ratio.powi(power)))
        };
        let row = MotorRow {
            id: self.id.clone(),
            manufacturer: self.manufacturer.clone(),
            model: self.model.clone(),
            source: self.source.clone(),
            source_kind: self.source_kind,
            note: self.note.clone(),
            conventions: Conventions {
                commutation: Commutation::Brushless,
                terminals: Terminals::QAxis,
                winding: None,
                current: CurrentConvention::QAxis,
                back_emf: Some(BackEmfConvention::QAxis),
                speed_constant: None,
                own: OwnConventions::default(),
            },
            pole_pairs: self.pole_pairs,
            sheet: Sheet {
                resistance: Some(Printed::exact(constants.resistance.unwrap_or(1.0))),
                inductance: unknown(constants.inductance),
                torque_constant: Some(Printed::exact(constants.torque_constant.map_or(1.0, |k| k / ratio))),
                back_emf_constant: unknown(constants.back_emf_constant.map(|k| k / ratio)),
                rotor_inertia: unknown(constants.inertia.map(|j| j / (ratio * ratio))),
                mass: sheet.mass,
                outer_diameter: sheet.outer_diameter,
                length: sheet.length.filter(|_| sheet.outer_diameter.is_some()),
                peak_current: of_current(sheet.peak_current),
                no_load_current: of_current(sheet.no_load_current),
                no_load_speed: unknown(sheet.no_load_current.and(self.no_load_speed()).map(|speed| speed * ratio)),
                coulomb_friction: at_motor(sheet.dynamic_friction, 1),
                viscous_friction: at_motor(sheet.viscous_friction, 2),
                thermal_resistance_winding_housing: sheet.thermal_resistance_winding_housing,
                thermal_resistance_housing_ambient: sheet.thermal_resistance_housing_ambient,
                thermal_time_constant_winding: sheet.thermal_time_constant_winding,
                thermal_time_constant_housing: sheet.thermal_time_constant_housing,
                max_winding_temperature: sheet.max_winding_temperature,
                reference_temperature: sheet.reference_temperature,
                ..Sheet::default()
            },
            ..MotorRow::default()
        };
        let motor = row.motor().expect("resistance and torque constant are there");
        let blank = |value: f64| if inside.says_currents() { value } else { f64::NAN };
        Motor {
            resistance: blank(motor.resistance),
            torque_constant: blank(motor.torque_constant),
            back_emf_constant: blank(motor.back_emf_constant),
            peak_current: motor.peak_current.filter(|_| inside.says_currents()),
            no_load_torque: motor.no_load_torque.filter(|_| inside.says_currents()),
            inside: Some(Arc::new(inside)),
            ..motor
        }
    }
}

impl Catalog {
    /// The catalogue with modules among the motors: those whose id or maker matches one of some patterns, each completed.
    #[must_use]
    pub fn with_modules<'p>(
        mut self,
        patterns: impl Iterator<Item = &'p String>,
        complete: fn(Motor) -> Motor,
    ) -> Catalog {
        let patterns: Vec<&String> = patterns.collect();
        let wanted = |module: &&Module| patterns.iter().any(|pattern| module.matches(pattern));
        let mut modules: Vec<Motor> = self.modules.iter().filter(wanted).map(|m| complete(m.as_motor(&self))).collect();
        modules.retain(|module| !self.motors.iter().any(|m| m.id == module.id));
        self.motors.append(&mut modules);
        self.motors.sort_by(|a, b| a.id.cmp(&b.id));
        self
    }
}

impl Module {
    /// Whether a pattern is of it: by its id, or by its maker in letters of either case.
    pub fn matches(&self, pattern: &str) -> bool {
        is_named(pattern, &self.id, &self.manufacturer)
    }
}
