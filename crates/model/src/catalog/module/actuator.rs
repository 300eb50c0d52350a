//! A module as the model computes with it: a motor row and the gear inside, whose ratio is fixed.

use std::sync::Arc;

use super::audit::audit_module;
use super::inside::{BUILT_IN, Depth, Inside};
use super::overload::Response;
use super::{MODULE_FIELDS, Module, NoLoadCurrent, Side, TorqueLoss};
use crate::catalog::alternative::Alternative;
use crate::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals};
use crate::catalog::drag::Drag;
use crate::catalog::gear::GearKind;
use crate::catalog::module::constants::EfficiencyFrom;
use crate::catalog::row::MotorRow;
use crate::catalog::sheet::{Conventions, OwnConventions, Printed, Sheet};
use crate::catalog::{Catalog, Gear, Motor, across, is_named};

/// A number with a ± that is so large a share of it.
fn known(value: Option<f64>, share: Option<f64>) -> Option<Printed> {
    value.map(|value| Printed { value, tolerance: share.map(|share| share * value.abs()) })
}

/// A number that comes from a printed one, with the same share as its ±.
fn like(value: Option<f64>, printed: Option<Printed>) -> Option<Printed> {
    known(value, printed.and_then(|p| p.relative_tolerance()))
}

impl Module {
    /// The module as a motor with the gear inside. Numbers that nobody knows are not: without constants they are no number at
    /// all, and nothing that is computed with them is shown.
    pub fn as_motor(&self, catalog: &Catalog) -> Motor {
        let depth = self.depth();
        let row = |id: &str| catalog.motors.iter().chain(&catalog.aside).find(|m| m.id == id);
        let pair = row(&self.motor).zip(catalog.gears.iter().find(|g| g.id == self.gear));
        let response = self.response();
        let alternatives: Vec<Alternative> = catalog.alternatives_of(&self.id).cloned().collect();
        let findings = audit_module(self, &catalog.modules, &catalog.motors, &alternatives);
        if let (Depth::Inside, Some((motor, gear))) = (depth, pair) {
            // What the two rows do not say, the module's may.
            let own = self.constants();
            let (ratio, whole) = (self.ratio(), self.sheet.mass.map(|p| p.value));
            let splits = motor.mass.is_some() && gear.mass.is_some();
            let efficiency = gear.efficiency.map(|efficiency| (efficiency, EfficiencyFrom::Row)).or(own.efficiency);
            let inertia = own.inertia.map(|j| j / (ratio * ratio));
            let inside = Inside {
                module: self.clone(),
                gear: Gear {
                    efficiency: Some(efficiency.map_or(1.0, |(efficiency, _)| efficiency)),
                    backdrive_efficiency: gear.backdrive_efficiency.or(own.backdrive_efficiency),
                    mass: if splits || whole.is_none() { gear.mass } else { Some(0.0) },
                    // An inertia of the whole is counted at the rotor.
                    inertia: if motor.rotor_inertia.is_none() { Some(0.0) } else { gear.inertia },
                    ..gear.clone()
                },
                depth,
                says_inertia: motor.rotor_inertia.or(inertia).is_some(),
                says_back_emf: true,
                gear_loss: efficiency.map(|(_, from)| from),
                loss_in_constant: false,
                response,
                findings,
                alternatives,
                published: Vec::new(),
            };
            return Motor { id: self.id.clone(), inside: Some(Arc::new(inside)), ..self.filled(motor, splits) };
        }
        let mut motor = self.by_constants(depth, response);
        if let Some(inside) = motor.inside.as_mut().map(Arc::make_mut) {
            (inside.findings, inside.alternatives) = (findings, alternatives);
        }
        motor
    }

    /// The motor row inside with what the module's row says in its place: in the sheet too, so that it has its ±.
    fn filled(&self, motor: &Motor, splits: bool) -> Motor {
        let (ratio, own, sheet) = (self.ratio(), &self.sheet, &motor.sheet);
        // Its own peak torque is that of the flange: a motor's that follows from it would count the gear's loss twice.
        let says_peak = own.peak_torque.is_some();
        // Of a current and a temperature that both rows bound the smaller one counts.
        let least = |a: Option<Printed>, b: Option<Printed>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.value < a.value { b } else { a }),
            (a, b) => a.or(b),
        };
        let in_row = motor.conventions.of_peak_current().torque_current(motor.conventions.commutation);
        let factor = self.refers.current.map(|is| is.torque_current(Commutation::Brushless) / in_row);
        let peak = factor.zip(own.peak_current).map(|(factor, p)| p.times(factor));
        let no_drag = motor.drag() == Drag::Unknown;
        let friction = |printed: Option<Printed>, power: i32| {
            let at_flange = self.at_output(printed.filter(|_| no_drag), self.refers.friction_side, power);
            like(at_flange.map(|f| f / ratio.powi(power)), printed)
        };
        let inertia = self.constants().inertia.filter(|_| motor.rotor_inertia.is_none());
        let sheet = Sheet {
            // What is bought and built in is the module, not the motor inside.
            outer_diameter: self.across(),
            length: own.length,
            offer: own.offer.clone(),
            peak_torque: sheet.peak_torque.filter(|_| !says_peak),
            mass: if splits { sheet.mass } else { own.mass.or(sheet.mass) },
            peak_current: least(sheet.peak_current, peak),
            max_winding_temperature: least(sheet.max_winding_temperature, own.max_winding_temperature),
            coulomb_friction: sheet.coulomb_friction.or(friction(own.dynamic_friction, 1)),
            viscous_friction: sheet.viscous_friction.or(friction(own.viscous_friction, 2)),
            rotor_inertia: sheet.rotor_inertia.or(like(inertia.map(|j| j / (ratio * ratio)), own.armature)),
            ..sheet.clone()
        };
        let value = |p: Option<Printed>| p.map(|p| p.value);
        Motor {
            peak_torque: motor.peak_torque.filter(|_| !says_peak),
            mass: if splits { motor.mass } else { value(own.mass).or(motor.mass) },
            peak_current: value(sheet.peak_current).map(|i| i * in_row).or(motor.peak_current),
            max_winding_temperature: value(sheet.max_winding_temperature).or(motor.max_winding_temperature),
            coulomb_friction: motor.coulomb_friction.or(value(sheet.coulomb_friction)),
            viscous_friction: motor.viscous_friction.or(value(sheet.viscous_friction)),
            rotor_inertia: motor.rotor_inertia.or(value(sheet.rotor_inertia)),
            sheet,
            ..motor.clone()
        }
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
                source_date: self.source_date.clone(),
                source_kind: self.source_kind,
                ..Gear::blank()
            },
            depth,
            says_inertia: constants.inertia.is_some(),
            says_back_emf: constants.back_emf_constant.is_some(),
            gear_loss: constants.efficiency.map(|(_, from)| from),
            loss_in_constant,
            response,
            findings: Vec::new(),
            alternatives: Vec::new(),
            published: Vec::new(),
        };
        let spread = constants.spread;
        let in_convention = |p: Option<Printed>, is: Option<CurrentConvention>| {
            Some(p?.times(is?.torque_current(Commutation::Brushless)))
        };
        let at_motor = |printed: Option<Printed>, power| {
            like(self.at_output(printed, self.refers.friction_side, power).map(|f| f / ratio.powi(power)), printed)
        };
        let back_emf_constant = constants.back_emf_constant.map(|k| k / ratio);
        // Of one number there is one.
        let is_one = constants.back_emf_constant == constants.torque_constant;
        let row = MotorRow {
            id: self.id.clone(),
            manufacturer: self.manufacturer.clone(),
            model: self.model.clone(),
            source: self.source.clone(),
            source_date: self.source_date.clone(),
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
                resistance: like(Some(constants.resistance.unwrap_or(1.0)), sheet.resistance),
                inductance: like(constants.inductance, sheet.inductance),
                torque_constant: known(
                    Some(constants.torque_constant.map_or(1.0, |k| k / ratio)),
                    spread.torque_constant,
                ),
                back_emf_constant: known(back_emf_constant.filter(|_| !is_one), spread.back_emf_constant),
                rotor_inertia: like(constants.inertia.map(|j| j / (ratio * ratio)), sheet.armature),
                mass: sheet.mass,
                outer_diameter: self.across(),
                length: sheet.length,
                offer: sheet.offer.clone(),
                peak_current: in_convention(sheet.peak_current, self.refers.current),
                no_load_current: match self.refers.no_load_current_is {
                    Some(NoLoadCurrent::Winding(is)) => in_convention(sheet.no_load_current, Some(is)),
                    _ => None,
                },
                no_load_speed: known(sheet.no_load_current.and(self.no_load_speed()).map(|speed| speed * ratio), None),
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
        row.motor().expect("resistance and torque constant are there").around(Arc::new(inside))
    }
}

impl Motor {
    /// The motor as that of a module: what the module's row does not say is no number.
    fn around(self, inside: Arc<Inside>) -> Motor {
        let says = inside.says_currents();
        let blank = |value: f64| if says { value } else { f64::NAN };
        Motor {
            resistance: blank(self.resistance),
            torque_constant: blank(self.torque_constant),
            back_emf_constant: blank(self.back_emf_constant),
            peak_current: self.peak_current.filter(|_| says),
            no_load_torque: self.no_load_torque.filter(|_| says),
            // What is taken for a constant is said of constants.
            assumptions: if says { self.assumptions } else { Vec::new() },
            inside: Some(inside),
            ..self
        }
    }

    /// The motor inside the same module as another one, with other ratings of the module.
    #[must_use]
    pub fn inside_of(self, other: &Motor, ratings: &[(&'static str, f64)]) -> Motor {
        match &other.inside {
            None => self,
            Some(inside) if ratings.is_empty() && inside.gear_loss != Some(EfficiencyFrom::TorqueConstant) => {
                self.around(inside.clone())
            }
            Some(inside) => {
                let share = ratings.iter().find(|(column, _)| *column == "torque_constant");
                let share =
                    share.zip(inside.module.sheet.torque_constant).map_or(1.0, |((_, new), old)| new / old.value);
                let module = inside.module.with_ratings(ratings);
                // With the rated torque goes the whole table: the answer in shares of it is the same.
                let rated = module.sheet.rated_torque.map(|p| p.value);
                let response = inside.response.clone().zip(rated).map(|(answer, rated)| Response { rated, ..answer });
                let mut gear = inside.gear.clone();
                // Torque per ampere was measured at the flange: the gear's efficiency is what is left of it over K_B.
                if inside.gear_loss == Some(EfficiencyFrom::TorqueConstant) {
                    let kept = share * other.back_emf_constant / self.back_emf_constant;
                    gear.efficiency = gear.efficiency.map(|efficiency| (efficiency * kept).min(1.0));
                }
                if let Some((_, efficiency)) = ratings.iter().find(|(column, _)| *column == "efficiency") {
                    gear.efficiency = gear.efficiency.map(|_| *efficiency);
                }
                self.around(Arc::new(Inside { module, gear, response, ..Inside::clone(inside) }))
            }
        }
    }
}

impl Module {
    /// Its diameter across the output axis \[m\]: see [`across`].
    pub fn across(&self) -> Option<Printed> {
        across(self.sheet.outer_diameter, self.sheet.width, self.sheet.height)
    }

    /// Thermal response of its winding, from its overload tables.
    fn response(&self) -> Option<Response> {
        Response::of_tables(self.sheet.rated_torque?.value, &self.overload, &self.overload_stall)
    }

    /// The module with other ratings. Its curves go with its peak torque and its speed without load, its overload table with its
    /// rated torque.
    #[must_use]
    pub fn with_ratings(&self, ratings: &[(&'static str, f64)]) -> Module {
        let mut module = self.clone();
        for (column, value) in ratings {
            if let Some(field) = MODULE_FIELDS.iter().find(|f| f.name == *column) {
                (field.set)(&mut module.sheet, Printed::exact(*value));
            }
        }
        let share = |name: &str, known: Option<f64>| {
            let new = ratings.iter().find(|(column, _)| *column == name).map(|(_, value)| *value);
            new.zip(known).map_or(1.0, |(new, known)| new / known)
        };
        let value = |p: Option<Printed>| p.map(|p| p.value);
        let torque = share("peak_torque", value(self.sheet.peak_torque).or(self.largest_torque()));
        let speed = share("no_load_speed", self.no_load_speed());
        let rated = share("rated_torque", value(self.sheet.rated_torque));
        for curve in [&mut module.driving_curve, &mut module.braking_curve] {
            curve.iter_mut().for_each(|[at, most]| (*at, *most) = (*at * speed, *most * torque));
        }
        for table in [&mut module.overload, &mut module.overload_stall] {
            table.iter_mut().for_each(|[most, _]| *most *= rated);
        }
        module
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
