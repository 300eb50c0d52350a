//! The box of a motor's tolerances, and the motors within it.

use std::borrow::Cow;

use gearwise_model::catalog::audit::Severity;
use gearwise_model::catalog::drag::Drag;
use gearwise_model::catalog::module::constants::EfficiencyFrom;
use gearwise_model::catalog::module::{Inside, MODULE_FIELDS, ModuleSheet, Published};
use gearwise_model::catalog::{Alternative, Catalog, FIELDS, Field, Motor, Printed, fitted::FittedGear};
use gearwise_model::effects::Named;
use gearwise_model::units::TEMPERATURE;

/// The columns of a sheet that limits depend on. A speed constant counts where it is the only source of a
/// back-EMF constant.
const COLUMNS: &[&str] = &[
    "resistance",
    "inductance",
    "torque_constant",
    "back_emf_constant",
    "speed_constant",
    "rotor_inertia",
    "viscous_friction",
    "coulomb_friction",
    "no_load_current",
    "no_load_speed",
    "thermal_resistance_winding_housing",
    "thermal_resistance_housing_ambient",
    "thermal_time_constant_winding",
    "thermal_time_constant_housing",
    "max_winding_temperature",
    "reference_temperature",
    "continuous_current",
    "peak_current",
    "demagnetization_current",
    "continuous_torque",
    "peak_torque",
    "max_speed",
    "mass",
    "outer_diameter",
    "length",
];

/// The columns of a module's own sheet that limits depend on, and whether a share of each may be assumed as its ±: a supply range does not
/// spread. Its curves and its overload table go with the ratings, the gear's efficiency with a torque constant that was measured at the
/// flange.
const RATINGS: &[(&str, bool)] = &[
    ("peak_torque", true),
    ("stall_torque", true),
    ("rated_torque", true),
    ("no_load_speed", true),
    ("torque_constant", true),
    ("efficiency", true),
    ("min_voltage", false),
    ("max_voltage", false),
];

/// The numbers of a fitted actuator's gear.
const GEAR: &[&str] = &["efficiency", "backdrive_efficiency", "inertia"];

/// True if a module's torque constant is that of the flange, beside a back-EMF constant.
fn is_measured(motor: &Motor) -> bool {
    motor.inside.as_deref().is_some_and(|inside| inside.gear_loss == Some(EfficiencyFrom::TorqueConstant))
}

/// Location of a number of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// A column of its sheet.
    Sheet(&'static str),
    /// A column of the sheet of the module that it is in.
    Rating(&'static str),
    /// A parameter of one of the effects that were fitted for it.
    Effect {
        /// Index of the effect.
        instance: usize,
        /// Index of the parameter.
        parameter: usize,
    },
    /// A number of the gear that it was fitted with.
    Gear(&'static str),
}

/// A number of a motor with a tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Toleranced {
    /// Column of the catalogue; of a fitted actuator also `effects.NAME.PARAMETER` and `gear.NAME`.
    pub column: Cow<'static, str>,
    /// True for a rating of a module, at the flange.
    pub is_rating: bool,
    /// The printed number, SI, in the sheet's convention.
    pub value: f64,
    /// Tolerance in the same unit, the larger of both sides.
    pub tolerance: f64,
    /// The ends of what several sources print, where they are taken.
    pub published: Option<[f64; 2]>,
    pub(super) place: Place,
    /// Least and largest value that is possible at all.
    range: [f64; 2],
    /// True if zero is possible.
    may_be_zero: bool,
}

impl Toleranced {
    /// The ends of the tolerance, within what is possible at all.
    pub(super) fn ends(&self) -> [f64; 2] {
        let ends = self.published.unwrap_or([self.value - self.tolerance, self.value + self.tolerance]);
        let [low, high] = self.range;
        // A no-load current that may be zero is told from one that is not known.
        let least = if self.place == Place::Sheet("no_load_current") { 1e-9 * self.value } else { low };
        [ends[0].max(least).min(self.value), ends[1].min(high).max(self.value)]
    }

    /// The number at a share of the way from its lower to its upper end.
    pub(super) fn at(&self, share: f64) -> f64 {
        let [low, high] = self.ends();
        if share == 1.0 { high } else { low + share * (high - low) }
    }

    /// The share at which the printed number is.
    pub(super) fn nominal(&self) -> f64 {
        let [low, high] = self.ends();
        if high > low { (self.value - low) / (high - low) } else { 0.0 }
    }

    /// True if it may be a number of the gear.
    pub(super) fn is_of_gear(&self) -> bool {
        !matches!(self.place, Place::Sheet(_))
    }

    /// True if it may be positive and negative.
    pub(super) fn is_signed(&self) -> bool {
        self.range[0] < 0.0
    }

    /// The possible number that is nearest to another one.
    pub(super) fn possible(&self, value: f64) -> f64 {
        value.clamp(self.range[0], self.range[1])
    }

    /// True where the tolerance reaches zero and the number cannot be zero.
    fn reaches_zero(&self) -> bool {
        let [low, _] = self.published.unwrap_or([self.value - self.tolerance, self.value]);
        !self.may_be_zero && low <= 0.0
    }
}

fn field(column: &str) -> &'static Field {
    FIELDS.iter().find(|f| f.name == column).expect("a column of the sheet")
}

fn rating(column: &str) -> &'static Field<ModuleSheet> {
    MODULE_FIELDS.iter().find(|f| f.name == column).expect("a column of the sheet")
}

/// True where the motor's sheet states the column; a module whose row states no constants has none.
fn is_known(motor: &Motor, column: &str) -> bool {
    let says = motor.inside.as_deref().is_none_or(Inside::says_currents);
    says || !["resistance", "torque_constant", "peak_current"].contains(&column)
}

/// A number of a fitted actuator's gear.
fn of_gear<'g>(gear: &'g mut FittedGear, name: &str) -> &'g mut Option<f64> {
    match name {
        "efficiency" => &mut gear.efficiency,
        "backdrive_efficiency" => &mut gear.backdrive_efficiency,
        _ => &mut gear.inertia,
    }
}

/// The numbers of a motor that have a tolerance, as far as limits depend on them.
pub fn toleranced(motor: &Motor) -> Vec<Toleranced> {
    let sheet = &motor.sheet;
    let drag = motor.drag();
    let counts = |column: &str| match column {
        "speed_constant" => sheet.back_emf_constant.is_none(),
        "inductance" => motor.inductance.is_some(),
        "no_load_current" => matches!(drag, Drag::NoLoad { .. }),
        // A speed without load says what part of a no-load current is viscous friction.
        "no_load_speed" => {
            matches!(drag, Drag::NoLoad { speed: Some(_), .. })
                || matches!(drag, Drag::NoLoad { .. }) && motor.viscous_friction.is_some()
        }
        column => is_known(motor, column),
    };
    let ends = |column: &str, is_rating: bool| {
        let all = &motor.inside.as_deref()?.published;
        all.iter().find(|p| p.column == column && p.is_rating == is_rating).map(|p| p.ends)
    };
    let one = |column: &'static str, place: Place, printed: Printed| {
        let Printed { value, tolerance } = printed;
        let is_rating = matches!(place, Place::Rating(_));
        let published = ends(column, is_rating).map(|[low, high]| {
            let of_row = tolerance.unwrap_or(0.0);
            [low.min(value - of_row).max(0.0), high.max(value + of_row)]
        });
        let tolerance = published.map_or(tolerance, |[low, high]| Some((value - low).max(high - value)));
        let tolerance = tolerance.filter(|t| *t > 0.0)?;
        let may_be_zero = ["inductance", "viscous_friction", "coulomb_friction", "no_load_current"].contains(&column);
        let most = if is_rating && column == "efficiency" { 1.0 } else { f64::INFINITY };
        let column = column.into();
        Some(Toleranced { column, is_rating, value, tolerance, published, place, range: [0.0, most], may_be_zero })
    };
    let of_sheet = |column: &&'static str| {
        let printed = (field(column).get)(sheet).filter(|_| counts(column))?;
        one(column, Place::Sheet(column), printed)
    };
    let of_module = |(column, _): &(&'static str, bool)| {
        let printed = (rating(column).get)(&motor.inside.as_deref()?.module.sheet)?;
        let counts = match *column {
            "torque_constant" => is_measured(motor),
            // The gear's own row may say another.
            "efficiency" => motor.inside.as_deref().is_some_and(|inside| inside.gear.efficiency == Some(printed.value)),
            _ => true,
        };
        one(column, Place::Rating(column), printed).filter(|_| counts)
    };
    let sheets = COLUMNS.iter().filter_map(of_sheet).chain(RATINGS.iter().filter_map(of_module));
    sheets.chain(fitted(motor)).collect()
}

/// Numbers of a fitted actuator beyond its sheet that have a tolerance: the stated one, else two standard deviations of the covariance.
fn fitted(motor: &Motor) -> Vec<Toleranced> {
    let Some(fit) = &motor.fit else { return Vec::new() };
    let deviation = |name: &str| {
        let place = fit.names.iter().position(|other| other == name)?;
        let variance = *fit.covariance.get(place)?.get(place)?;
        (variance > 0.0).then(|| 2.0 * variance.sqrt())
    };
    let tolerance = |name: &str, column: &str| {
        fit.tolerance(name).or_else(|| deviation(column)).filter(|tolerance| *tolerance > 0.0)
    };
    let mut all = Vec::new();
    for (instance, fitted) in motor.effects.iter().enumerate() {
        let linear = fitted.effect.linear();
        for (parameter, of) in fitted.effect.parameters().iter().enumerate().take(fitted.values.len()) {
            let name = Named::new(fitted.effect, fitted.values.last().copied(), of.name).to_string();
            let column = format!("effects.{name}");
            let Some(tolerance) = tolerance(&name, &column) else { continue };
            let is_signed = fitted.effect.is_signed() && parameter < linear;
            all.push(Toleranced {
                column: column.into(),
                is_rating: false,
                value: fitted.values[parameter],
                tolerance,
                published: None,
                place: Place::Effect { instance, parameter },
                range: [if is_signed { f64::NEG_INFINITY } else { 0.0 }, f64::INFINITY],
                may_be_zero: parameter < linear,
            });
        }
    }
    let mut gear = motor.fitted_gear.unwrap_or_default();
    for name in GEAR {
        let column = format!("gear.{name}");
        let (Some(value), Some(tolerance)) = (*of_gear(&mut gear, name), tolerance(&column, &column)) else { continue };
        let range = match *name {
            "efficiency" => [0.0, 1.0],
            "backdrive_efficiency" => [f64::NEG_INFINITY, 1.0],
            _ => [0.0, f64::INFINITY],
        };
        all.push(Toleranced {
            column: column.into(),
            is_rating: false,
            value,
            tolerance,
            published: None,
            place: Place::Gear(name),
            range,
            may_be_zero: *name != "efficiency",
        });
    }
    all
}

/// Takes the ends of what all sources print of a module's numbers as their ±. A number that contradicts others of its row, by
/// what the audit finds, does not count.
pub fn take_alternatives(catalog: &mut Catalog) {
    let wrong = |motor: &Motor| -> Vec<&'static str> {
        let findings = motor.inside.iter().flat_map(|inside| &inside.findings);
        findings.filter(|f| f.severity == Severity::Error).map(|f| f.code).collect()
    };
    let all: Vec<Vec<Published>> = catalog
        .motors
        .iter()
        .map(|motor| {
            let Some(inside) = motor.inside.as_deref() else { return Vec::new() };
            let own = wrong(motor);
            let other = |alternative: &Alternative| {
                let printed = alternative.as_in(&inside.module)?;
                let mut module = inside.module.clone();
                let field = MODULE_FIELDS.iter().find(|f| f.name == alternative.column)?;
                (field.get)(&module.sheet)?;
                // The ends of its own ±.
                let tolerance = printed.tolerance.unwrap_or(0.0);
                let ends = [printed.value - tolerance, printed.value + tolerance].map(|value| {
                    (field.set)(&mut module.sheet, Printed { value, tolerance: None });
                    module.as_motor(catalog)
                });
                (!ends.iter().any(|end| wrong(end).iter().any(|code| !own.contains(code)))).then_some(ends)
            };
            let others: Vec<Motor> = inside.alternatives.iter().filter_map(other).flatten().collect();
            let ends = |is_rating: bool, column: &'static str, of: &dyn Fn(&Motor) -> Option<f64>| {
                let own = of(motor)?;
                let all = others.iter().filter_map(of).fold([own, own], |[low, high], v| [low.min(v), high.max(v)]);
                (all != [own, own]).then_some(Published { column, is_rating, ends: all })
            };
            let of_sheet = COLUMNS.iter().filter_map(|column| {
                ends(false, column, &|of: &Motor| (field(column).get)(&of.sheet).map(|p| p.value))
            });
            let of_module = RATINGS.iter().map(|(column, _)| *column).filter_map(|column| {
                ends(true, column, &|of: &Motor| {
                    (rating(column).get)(&of.inside.as_deref()?.module.sheet).map(|p| p.value)
                })
            });
            of_sheet.chain(of_module).collect()
        })
        .collect();
    for (motor, published) in catalog.motors.iter_mut().zip(all) {
        if let Some(inside) = motor.inside.as_mut().filter(|_| !published.is_empty()) {
            std::sync::Arc::make_mut(inside).published = published;
        }
    }
}

/// Gives each number of the sheets that limits depend on, and that states no tolerance, one of this share of it. Temperatures
/// are left as they are: a share of kelvin says nothing.
pub fn assume_tolerance(motors: &mut [Motor], share: f64) {
    let assumed = |printed: Option<Printed>| {
        let printed = printed.filter(|p| p.tolerance.is_none())?;
        Some(Printed { tolerance: Some(share * printed.value.abs()), ..printed })
    };
    for motor in motors {
        for column in COLUMNS {
            let field = field(column);
            let printed = (field.get)(&motor.sheet).filter(|_| field.kind.name != TEMPERATURE.name);
            if let Some(printed) = assumed(printed).filter(|_| is_known(motor, column)) {
                (field.set)(&mut motor.sheet, printed);
            }
        }
        let Some(inside) = &mut motor.inside else { continue };
        let module = &mut std::sync::Arc::make_mut(inside).module;
        // What its curve alone says has a ± too.
        let (most, free) = (module.largest_torque(), module.no_load_speed());
        let sheet = &mut module.sheet;
        sheet.peak_torque = sheet.peak_torque.or(most.map(Printed::exact));
        sheet.no_load_speed = sheet.no_load_speed.or(free.map(Printed::exact));
        for (column, _) in RATINGS.iter().filter(|(_, spreads)| *spreads) {
            let field = rating(column);
            if let Some(printed) = assumed((field.get)(&module.sheet)) {
                (field.set)(&mut module.sheet, printed);
            }
        }
    }
}

/// Motor with other numbers in its sheet, in the ratings of its module, or in its fit; `None` where
/// they make no motor.
pub(super) fn with_numbers<'t>(motor: &Motor, numbers: impl Iterator<Item = (&'t Toleranced, f64)>) -> Option<Motor> {
    let mut sheet = motor.sheet.clone();
    let (mut effects, mut fitted_gear) = (motor.effects.clone(), motor.fitted_gear);
    let mut ratings = Vec::new();
    for (of, value) in numbers {
        match of.place {
            Place::Rating(column) => ratings.push((column, value)),
            Place::Sheet(column) => (field(column).set)(&mut sheet, Printed { value, tolerance: None }),
            Place::Effect { instance, parameter } => effects[instance].values[parameter] = value,
            Place::Gear(name) => *of_gear(fitted_gear.get_or_insert_default(), name) = Some(value),
        }
    }
    let other = Motor::new(motor.identity(), motor.conventions, sheet, motor.pole_pairs).ok()?;
    // What the sheet does not have, of another row of it or estimated, has no tolerance.
    let other = other.filled_from(motor).inside_of(motor, &ratings);
    Some(Motor { effects, fitted_gear, fit: motor.fit.clone(), ..other })
}

/// A motor of the box.
#[derive(Debug, Clone)]
pub struct Corner {
    /// Position of each number between its lower end (0) and its upper end (1).
    pub at: Vec<f64>,
    /// The limit that it was found for; `None` of the corners that the search begins with.
    pub found_for: Option<&'static str>,
    /// The motor there.
    pub motor: Motor,
}

impl Corner {
    /// The motor at a place of the box; `None` where the numbers make none.
    pub(super) fn new(
        motor: &Motor,
        all: &[Toleranced],
        at: Vec<f64>,
        found_for: Option<&'static str>,
    ) -> Option<Corner> {
        let numbers = all.iter().zip(&at).map(|(of, share)| (of, of.at(*share)));
        Some(Corner { motor: with_numbers(motor, numbers)?, at, found_for })
    }
}

/// The number whose tolerance reaches zero, where that makes no motor.
pub(super) fn reaching_zero(all: &[Toleranced]) -> Option<&Toleranced> {
    all.iter().find(|t| t.reaches_zero())
}
