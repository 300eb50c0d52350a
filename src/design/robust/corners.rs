//! The box of a motor's tolerances: its corners, and which of them a limit needs.

use crate::actuator::limits::{Depends, Limit};
use crate::catalog::audit::Severity;
use crate::catalog::module::constants::EfficiencyFrom;
use crate::catalog::module::{Inside, MODULE_FIELDS, ModuleSheet, Published};
use crate::catalog::{Alternative, Catalog, FIELDS, Field, Motor, Printed};
use crate::design::Prepared;
use crate::design::program::Limited;
use crate::units::TEMPERATURE;

/// Which end of a tolerance is the worse one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Worst {
    Low,
    High,
    /// It depends on the limit, the sample and the ratio.
    Either,
}

/// What a column of the sheet is for a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Resistance,
    Inductance,
    /// A constant that K_T or K_B comes from.
    Constant,
    RotorInertia,
    Friction,
    /// The resistance from winding to housing.
    WindingToHousing,
    /// Any other number of the thermal nodes.
    Thermal,
    /// A rating, a temperature or the mass: its worse end is known.
    Rating,
}

impl Part {
    /// What the motor's own torque is made of.
    fn is_of_torque(self) -> bool {
        matches!(self, Part::RotorInertia | Part::Friction)
    }
}

/// The columns of a sheet that limits depend on. A speed constant counts where it is the only source of a
/// back-EMF constant.
const COLUMNS: &[(&str, Part, Worst)] = &[
    ("resistance", Part::Resistance, Worst::Either),
    ("inductance", Part::Inductance, Worst::Either),
    ("torque_constant", Part::Constant, Worst::Either),
    ("back_emf_constant", Part::Constant, Worst::Either),
    ("speed_constant", Part::Constant, Worst::Either),
    ("rotor_inertia", Part::RotorInertia, Worst::Either),
    ("viscous_friction", Part::Friction, Worst::Either),
    ("coulomb_friction", Part::Friction, Worst::Either),
    ("thermal_resistance_winding_housing", Part::WindingToHousing, Worst::Either),
    ("thermal_resistance_housing_ambient", Part::Thermal, Worst::High),
    ("thermal_time_constant_winding", Part::Thermal, Worst::Either),
    ("thermal_time_constant_housing", Part::Thermal, Worst::Either),
    ("max_winding_temperature", Part::Rating, Worst::Low),
    ("reference_temperature", Part::Rating, Worst::Low),
    ("continuous_current", Part::Rating, Worst::Low),
    ("peak_current", Part::Rating, Worst::Low),
    ("continuous_torque", Part::Rating, Worst::Low),
    ("peak_torque", Part::Rating, Worst::Low),
    ("max_speed", Part::Rating, Worst::Low),
    ("mass", Part::Rating, Worst::High),
    ("outer_diameter", Part::Rating, Worst::High),
    ("length", Part::Rating, Worst::High),
];

/// A column of a module's own sheet that limits depend on.
struct Rating {
    column: &'static str,
    worst: Worst,
    /// Whether a share of it may be assumed as its ±: a supply range is no number that spreads.
    spreads: bool,
}

const fn rated(column: &'static str, worst: Worst, spreads: bool) -> Rating {
    Rating { column, worst, spreads }
}

/// Its curves and its overload table go with the ratings, the gear's efficiency with a torque constant that was measured at the flange.
const RATINGS: &[Rating] = &[
    rated("peak_torque", Worst::Low, true),
    rated("stall_torque", Worst::Low, true),
    rated("rated_torque", Worst::Low, true),
    rated("no_load_speed", Worst::Low, true),
    rated("torque_constant", Worst::Low, true),
    rated("min_voltage", Worst::High, false),
    rated("max_voltage", Worst::Low, false),
];

/// Whether a module's torque constant is that of the flange, beside a back-EMF constant.
fn is_measured(motor: &Motor) -> bool {
    motor.inside.as_deref().is_some_and(|inside| inside.gear_loss == Some(EfficiencyFrom::TorqueConstant))
}

/// A number of the sheet with a tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toleranced {
    /// Column of the catalogue.
    pub column: &'static str,
    /// Whether it is a rating of a module, at its flange.
    pub is_rating: bool,
    /// The printed number, SI, in the sheet's convention.
    pub value: f64,
    /// Its ±, in the same unit: the larger one of both sides.
    pub tolerance: f64,
    /// The ends of what several sources print, where they are taken.
    pub published: Option<[f64; 2]>,
    part: Part,
    worst: Worst,
}

impl Toleranced {
    /// The ends of the tolerance; what cannot be negative ends at zero.
    fn ends(&self) -> [f64; 2] {
        self.published.unwrap_or([(self.value - self.tolerance).max(0.0), self.value + self.tolerance])
    }

    /// Whether zero is out of the question for the number, and the tolerance reaches it.
    fn reaches_zero(&self) -> bool {
        let may_be_zero = matches!(self.part, Part::Inductance | Part::Friction);
        !may_be_zero && self.ends()[0] <= 0.0
    }
}

fn field(column: &str) -> &'static Field {
    FIELDS.iter().find(|f| f.name == column).expect("a column of the sheet")
}

fn rating(column: &str) -> &'static Field<ModuleSheet> {
    MODULE_FIELDS.iter().find(|f| f.name == column).expect("a column of the sheet")
}

/// Whether a column of the motor's sheet is a number that somebody knows: of a module whose row says no constants it is none.
fn is_known(motor: &Motor, column: &str) -> bool {
    let says = motor.inside.as_deref().is_none_or(Inside::says_currents);
    says || !["resistance", "torque_constant", "peak_current"].contains(&column)
}

/// The numbers of a motor that have a tolerance, as far as limits depend on them.
pub fn toleranced(motor: &Motor) -> Vec<Toleranced> {
    let sheet = &motor.sheet;
    let counts = |column: &str| match column {
        "speed_constant" => sheet.back_emf_constant.is_none(),
        "inductance" => motor.inductance.is_some(),
        column => is_known(motor, column),
    };
    let ends = |column: &str, is_rating: bool| {
        let all = &motor.inside.as_deref()?.published;
        all.iter().find(|p| p.column == column && p.is_rating == is_rating).map(|p| p.ends)
    };
    let one = |column: &'static str, is_rating: bool, printed: Printed, part: Part, worst: Worst| {
        let Printed { value, tolerance } = printed;
        let published = ends(column, is_rating).map(|[low, high]| {
            let of_row = tolerance.unwrap_or(0.0);
            [low.min(value - of_row).max(0.0), high.max(value + of_row)]
        });
        let tolerance = published.map_or(tolerance, |[low, high]| Some((value - low).max(high - value)));
        let tolerance = tolerance.filter(|t| *t > 0.0)?;
        Some(Toleranced { column, is_rating, value, tolerance, published, part, worst })
    };
    let of = |(column, part, worst): &(&'static str, Part, Worst)| {
        let printed = (field(column).get)(sheet).filter(|_| counts(column))?;
        one(column, false, printed, *part, *worst)
    };
    let of_module = |of: &Rating| {
        let printed = (rating(of.column).get)(&motor.inside.as_deref()?.module.sheet)?;
        let counts = of.column != "torque_constant" || is_measured(motor);
        one(of.column, true, printed, Part::Rating, of.worst).filter(|_| counts)
    };
    COLUMNS.iter().filter_map(of).chain(RATINGS.iter().filter_map(of_module)).collect()
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
            let of_sheet = COLUMNS.iter().filter_map(|(column, ..)| {
                ends(false, column, &|of: &Motor| (field(column).get)(&of.sheet).map(|p| p.value))
            });
            let of_module = RATINGS.iter().map(|of| of.column).filter_map(|column| {
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
        for (column, ..) in COLUMNS {
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
        for of in RATINGS.iter().filter(|of| of.spreads) {
            let field = rating(of.column);
            if let Some(printed) = assumed((field.get)(&module.sheet)) {
                (field.set)(&mut module.sheet, printed);
            }
        }
    }
}

/// The same motor with other numbers in its sheet, or in the ratings of the module that it is in; `None` where they make no motor.
pub(super) fn with_numbers(motor: &Motor, numbers: impl Iterator<Item = (Toleranced, f64)>) -> Option<Motor> {
    let mut sheet = motor.sheet.clone();
    let mut ratings = Vec::new();
    for (of, value) in numbers {
        match of.is_rating {
            true => ratings.push((of.column, value)),
            false => (field(of.column).set)(&mut sheet, Printed { value, tolerance: None }),
        }
    }
    let other = Motor::new(motor.identity(), motor.conventions, sheet, motor.pole_pairs).ok()?;
    // What the sheet does not have, of another row of it or estimated, has no tolerance.
    let other = other.filled_from(motor).inside_of(motor, &ratings);
    Some(Motor { effects: motor.effects.clone(), fitted_gear: motor.fitted_gear, fit: motor.fit.clone(), ..other })
}

/// A corner of the box of tolerances.
#[derive(Debug, Clone)]
pub struct Corner {
    /// Each column with whether its upper end is taken.
    pub ends: Vec<(&'static str, bool)>,
    /// What each of them is.
    parts: Vec<(Part, Worst)>,
    /// The motor there.
    pub motor: Motor,
}

/// The corners of the box that some limit may need, in a fixed order. A single one, the motor itself,
/// where nothing has a tolerance.
///
/// # Errors
/// The column whose tolerance reaches zero, where that makes no motor.
pub fn corners(motor: &Motor) -> Result<Vec<Corner>, &'static str> {
    let all = toleranced(motor);
    if let Some(wide) = all.iter().find(|t| t.reaches_zero()) {
        return Err(wide.column);
    }
    let free: Vec<usize> = (0..all.len()).filter(|i| all[*i].worst == Worst::Either).collect();
    let corner = |bits: usize| {
        let upper = |i: usize| match all[i].worst {
            Worst::Low => false,
            Worst::High => true,
            Worst::Either => free.iter().position(|f| *f == i).is_some_and(|place| bits >> place & 1 == 1),
        };
        let ends: Vec<(&'static str, bool)> = (0..all.len()).map(|i| (all[i].column, upper(i))).collect();
        let numbers = (0..all.len()).map(|i| (all[i], all[i].ends()[usize::from(upper(i))]));
        let parts = all.iter().map(|t| (t.part, t.worst)).collect();
        Some(Corner { motor: with_numbers(motor, numbers)?, ends, parts })
    };
    (0..1_usize << free.len()).map(corner).collect::<Option<Vec<_>>>().ok_or("the sheet")
}

/// Whether a limit needs a corner: of the columns that do not matter to it, or whose worse end is known
/// for it, only one end.
fn needs(limit: &Limit, corner: &Corner, motor: &Motor) -> bool {
    let sheet = &motor.sheet;
    // The column that K_T comes from, and whether K_T rises with it.
    let (k_t, rising) = match (sheet.torque_constant, sheet.back_emf_constant) {
        (Some(_), _) => ("torque_constant", true),
        (None, Some(_)) => ("back_emf_constant", true),
        (None, None) => ("speed_constant", false),
    };
    let ends = corner.ends.iter().zip(&corner.parts);
    ends.into_iter().all(|((column, upper), (part, worst))| {
        // `None`: both ends.
        let end = match (limit.depends, part) {
            (Depends::BackEmf | Depends::Anyhow, _) => None,
            (Depends::Current | Depends::Temperature | Depends::Torque | Depends::Voltage, part)
            | (Depends::Power | Depends::PowerBack, part)
                if part.is_of_torque() =>
            {
                None
            }
            (Depends::Current | Depends::Temperature, Part::Resistance) => Some(true),
            (Depends::Current, Part::WindingToHousing) => Some(true),
            (Depends::Temperature, Part::WindingToHousing | Part::Thermal) => None,
            (Depends::Current | Depends::Temperature, _) if *column == k_t => Some(!rising),
            (Depends::Voltage, Part::Constant | Part::Resistance | Part::Inductance) => None,
            (Depends::Power, Part::Resistance) => Some(true),
            (Depends::Power | Depends::PowerBack, Part::Constant) => None,
            (Depends::Inertia, Part::RotorInertia) => Some(true),
            // What a module has to give at its flange has its own inertia in it.
            (Depends::Rating, Part::RotorInertia) if motor.inside.is_some() => None,
            _ => Some(false),
        };
        *worst != Worst::Either || end.is_none_or(|end| end == *upper)
    })
}

/// Whether the corners of the tolerances do not prove a limit over the whole box.
fn is_unproved(limit: &Limit) -> bool {
    matches!(limit.depends, Depends::PowerBack | Depends::Temperature)
}

/// The limits of a box: those of the corners that each needs, and of the nominal motor where corners do not
/// prove it.
pub(super) fn limits_of<'p>(nominal: &'p Prepared<'p>, corners: &'p [(Prepared<'p>, Corner)]) -> Vec<Limited<'p>> {
    let motor = nominal.candidate.motor;
    let mut limits = Vec::new();
    for (prepared, corner) in corners {
        let wanted = prepared.asked.iter().filter(|a| needs(a.limit, corner, motor));
        limits.extend(wanted.map(|asked| Limited { candidate: &prepared.candidate, asked }));
    }
    let unproved = nominal.asked.iter().filter(|a| is_unproved(a.limit));
    limits.extend(unproved.map(|asked| Limited { candidate: &nominal.candidate, asked }));
    limits
}

/// Why corners do not prove that the whole box keeps the limits, where they do not.
pub(super) fn unproved(nominal: &Prepared, all: &[Toleranced]) -> Option<&'static str> {
    let has = |matters: &dyn Fn(Part) -> bool| all.iter().any(|t| matters(t.part));
    let has_column = |name: &str| all.iter().any(|t| t.column == name);
    let of_power = |part: Part| part.is_of_torque() || part == Part::Constant;
    // The end of a resistance to ambient is known.
    let of_heat = |t: &Toleranced| matches!(t.part, Part::WindingToHousing | Part::Thermal) && t.worst == Worst::Either;
    let follows = nominal.asked.iter().any(|a| a.limit.depends == Depends::Temperature);
    if nominal.asked.iter().any(|a| a.limit.depends == Depends::PowerBack) && has(&of_power) {
        return Some("power that comes back may be largest between the corners of the tolerances");
    }
    if has_column("max_winding_temperature") {
        return Some(
            "voltage takes the winding at its hottest, which the other end of its tolerance would make hotter",
        );
    }
    if follows && all.iter().any(of_heat) {
        return Some("temperature over the motion may be highest between the ends of the thermal tolerances");
    }
    None
}
