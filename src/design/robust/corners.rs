//! The box of a motor's tolerances: its corners, and which of them a limit needs.

use crate::actuator::limits::{Depends, Limit};
use crate::catalog::{FIELDS, Field, Motor, Printed};
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

/// A number of the sheet with a tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toleranced {
    /// Column of the catalogue.
    pub column: &'static str,
    /// The printed number, SI, in the sheet's convention.
    pub value: f64,
    /// Its ±, in the same unit.
    pub tolerance: f64,
    part: Part,
    worst: Worst,
}

impl Toleranced {
    /// The ends of the tolerance; what cannot be negative ends at zero.
    fn ends(&self) -> [f64; 2] {
        [(self.value - self.tolerance).max(0.0), self.value + self.tolerance]
    }

    /// Whether zero is out of the question for the number, and the tolerance reaches it.
    fn reaches_zero(&self) -> bool {
        let may_be_zero = matches!(self.part, Part::Inductance | Part::Friction);
        !may_be_zero && self.tolerance >= self.value
    }
}

fn field(column: &str) -> &'static Field {
    FIELDS.iter().find(|f| f.name == column).expect("a column of the sheet")
}

/// The numbers of a motor that have a tolerance, as far as limits depend on them.
pub fn toleranced(motor: &Motor) -> Vec<Toleranced> {
    let sheet = &motor.sheet;
    let counts = |column: &str| match column {
        "speed_constant" => sheet.back_emf_constant.is_none(),
        "inductance" => motor.inductance.is_some(),
        _ => true,
    };
    let of = |(column, part, worst): &(&'static str, Part, Worst)| {
        let printed = (field(column).get)(sheet)?;
        let tolerance = printed.tolerance.filter(|t| *t > 0.0)?;
        counts(column).then_some(Toleranced { column, value: printed.value, tolerance, part: *part, worst: *worst })
    };
    COLUMNS.iter().filter_map(of).collect()
}

/// Gives each number of the sheets that limits depend on, and that states no tolerance, one of this share of it. Temperatures
/// are left as they are: a share of kelvin says nothing.
pub fn assume_tolerance(motors: &mut [Motor], share: f64) {
    for motor in motors {
        for (column, ..) in COLUMNS {
            let field = field(column);
            let Some(printed) = (field.get)(&motor.sheet) else { continue };
            if printed.tolerance.is_none() && field.kind.name != TEMPERATURE.name {
                let tolerance = Some(share * printed.value.abs());
                (field.set)(&mut motor.sheet, Printed { value: printed.value, tolerance });
            }
        }
    }
}

/// The same motor with other numbers in its sheet; `None` where they make no motor.
pub(super) fn with_numbers(motor: &Motor, numbers: impl Iterator<Item = (&'static str, f64)>) -> Option<Motor> {
    let mut sheet = motor.sheet.clone();
    for (column, value) in numbers {
        (field(column).set)(&mut sheet, Printed { value, tolerance: None });
    }
    let other = Motor::new(motor.identity(), motor.conventions, sheet, motor.pole_pairs).ok()?;
    // What the sheet does not have, of another row of it or estimated, has no tolerance.
    let other = other.filled_from(motor);
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
        let numbers = (0..all.len()).map(|i| (all[i].column, all[i].ends()[usize::from(upper(i))]));
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
