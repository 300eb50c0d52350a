//! A motor of MGDB as the catalogue's.

use super::cells::Cells;
use crate::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals};
use crate::catalog::row::MotorRow;
use crate::catalog::{About, Conventions, FIELDS, Identity, OwnConventions, Printed, Sheet, SourceKind};
use crate::input::Source;
use crate::words::number;

/// Columns of MGDB and the catalogue's; both in SI.
const NUMBERS: &[(&str, &str)] = &[
    ("V", "voltage"),
    ("k_e", "back_emf_constant"),
    ("L", "inductance"),
    ("mass", "mass"),
    ("inertia", "rotor_inertia"),
    ("diameter", "outer_diameter"),
    ("length", "length"),
    ("omega_nl", "no_load_speed"),
    ("I_nl", "no_load_current"),
    ("I_nom", "continuous_current"),
    ("max_int_torque", "peak_torque"),
    ("max_int_speed", "max_speed"),
    ("coulomb_friction", "coulomb_friction"),
    ("viscous_friction", "viscous_friction"),
    ("Rth1", "thermal_resistance_winding_housing"),
    ("Rth2", "thermal_resistance_housing_ambient"),
];

/// Columns that the catalogue has no place for, and their units.
const LEFT_OUT: &[(&str, &str)] = &[("max_cont_speed", "rad/s"), ("max_cont_power", "W")];

/// What MGDB says of a motor's commutation: it decides how missing friction is derived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Machine {
    /// With brushes.
    Dc,
    /// Brushless.
    Bldc,
}

/// Friction of a motor; `None` where nothing is known that it could be derived from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Coulomb friction \[N·m\].
    pub coulomb: Option<f64>,
    /// Viscous friction \[N·m·s/rad\].
    pub viscous: Option<f64>,
}

/// No-load current (V − k_t ω_nl)/R \[A\] of a motor whose sheet does not print it, from voltage
/// \[V\], torque constant \[N·m/A\], no-load speed \[rad/s\] and resistance \[Ω\]: the equilibrium of the DC
/// machine at no load, as CORDS has it. Negative where the sheet's numbers contradict each other.
pub fn no_load_current(voltage: f64, torque_constant: f64, no_load_speed: f64, resistance: f64) -> f64 {
    (voltage - torque_constant * no_load_speed) / resistance
}

/// Fills in what a sheet does not say of friction as CORDS does (ekrimsk/cords, `joule_rigid`): what
/// turns the motor at no load, k_t I_nl, is Coulomb friction of a motor with brushes and viscous friction
/// of a brushless one. A negative no-load current \[A\] counts as none; the no-load speed is \[rad/s\].
///
/// ```
/// use gearwise_model::catalog::import::mgdb::{Friction, Machine, friction};
/// let unknown = Friction { coulomb: None, viscous: None };
/// // 0.05 N·m/A, and 0.2 A at 500 rad/s without load.
/// let bldc = friction(Machine::Bldc, unknown, 0.05, Some(0.2), Some(500.0));
/// assert_eq!(bldc, Friction { coulomb: Some(0.0), viscous: Some(0.05 * 0.2 / 500.0) });
/// let dc = friction(Machine::Dc, unknown, 0.05, Some(0.2), Some(500.0));
/// assert_eq!(dc, Friction { coulomb: Some(0.05 * 0.2), viscous: Some(0.0) });
/// ```
pub fn friction(
    machine: Machine,
    printed: Friction,
    torque_constant: f64,
    no_load_current: Option<f64>,
    no_load_speed: Option<f64>,
) -> Friction {
    let torque = no_load_current.map(|i| torque_constant * i.max(0.0));
    match machine {
        Machine::Dc => Friction { coulomb: printed.coulomb.or(torque), viscous: Some(printed.viscous.unwrap_or(0.0)) },
        Machine::Bldc => {
            let viscous = torque.zip(no_load_speed).map(|(torque, speed)| torque / speed);
            Friction { coulomb: Some(printed.coulomb.unwrap_or(0.0)), viscous: printed.viscous.or(viscous) }
        }
    }
}

/// Reads a row; `None` where it is refused. The id is left to the caller.
pub fn read(cells: &mut Cells, key: &str, source: &Source) -> Option<MotorRow> {
    let kind = cells.text("type");
    let machine = match kind.to_ascii_lowercase().as_str() {
        "dc" => Some(Machine::Dc),
        "bldc" => Some(Machine::Bldc),
        _ => {
            let kind: String = kind.chars().take(60).collect();
            cells.refuse("type", "unknown-type", format!("type is `{kind}`: expected BLDC or DC"));
            None
        }
    };
    let mut sheet = Sheet::default();
    for (column, name) in NUMBERS {
        let field = FIELDS.iter().find(|f| f.name == *name)?;
        if let Some(value) = cells.number(column, field.range) {
            (field.set)(&mut sheet, printed(value));
        }
    }
    let resistance = cells.required("R", "missing-resistance");
    let torque_constant = cells.required("k_t", "missing-torque-constant");
    let (machine, resistance, torque_constant) = (machine?, resistance?, torque_constant?);
    sheet.resistance = Some(printed(resistance));
    sheet.torque_constant = Some(printed(torque_constant));
    let note = fill_friction(cells, machine, &mut sheet, torque_constant, resistance);
    for (column, unit) in LEFT_OUT {
        let text = cells.text(column);
        if text.parse::<f64>().is_ok_and(f64::is_finite) {
            let message = format!("{column} = {text} {unit}: the catalogue has no column for it");
            cells.leave_out("no-column", message);
        }
    }
    let (manufacturer, model) = cells.maker_and_model(key, source.folder());
    let conventions = Conventions {
        commutation: Commutation::Brushed,
        terminals: Terminals::LineToLine,
        winding: None,
        current: CurrentConvention::Dc,
        back_emf: sheet.back_emf_constant.map(|_| BackEmfConvention::Dc),
        speed_constant: None,
        own: OwnConventions::default(),
    };
    let kind = if machine == Machine::Bldc { "A BLDC motor" } else { "A DC motor" };
    let identity = Identity {
        id: String::new(),
        source: format!("{manufacturer} {model}, as collected in MGDB"),
        source_date: String::new(),
        source_kind: SourceKind::Secondary,
        note: format!(
            "{key} of MGDB. {kind} taken as its equivalent DC machine: no convention is converted, and the bus voltage \
             itself is the voltage limit.{note}"
        ),
        manufacturer,
        model,
        accepted_findings: Vec::new(),
        about: About::default(),
    };
    Some(MotorRow::new(identity, conventions, sheet, None))
}

fn printed(value: f64) -> Printed {
    Printed { value, tolerance: None }
}

/// Fills in the friction that the row does not say, notes each assumption, and gives the words for
/// the row's note.
fn fill_friction(cells: &mut Cells, machine: Machine, sheet: &mut Sheet, k_t: f64, r: f64) -> String {
    let value = |p: Option<Printed>| p.map(|p| p.value);
    let says = Friction { coulomb: value(sheet.coulomb_friction), viscous: value(sheet.viscous_friction) };
    let speed = value(sheet.no_load_speed);
    let mut current = value(sheet.no_load_current);
    let wanted = match machine {
        Machine::Dc => says.coulomb.is_none(),
        Machine::Bldc => says.viscous.is_none(),
    };
    if wanted && current.is_none() {
        current = value(sheet.voltage).zip(speed).map(|(v, w)| no_load_current(v, k_t, w, r));
        match current {
            Some(i) if i < 0.0 => cells.assume(
                "no-load-current-negative",
                format!("no-load current taken as 0: (V - k_t omega_nl)/R is {} A", number(i)),
            ),
            Some(i) => cells.assume(
                "no-load-current-derived",
                format!("no-load current taken as (V - k_t omega_nl)/R = {} A", number(i)),
            ),
            None => {}
        }
    }
    let filled = friction(machine, says, k_t, current, speed);
    let mut words = Vec::new();
    if says.coulomb.is_none() {
        words.push(match (machine, filled.coulomb) {
            (Machine::Bldc, _) => {
                cells.assume("coulomb-friction-zero", "Coulomb friction taken as 0, as of a brushless motor");
                "Coulomb friction taken as 0"
            }
            (Machine::Dc, Some(c)) => {
                let message = format!("Coulomb friction taken as k_t I_nl = {} N*m", number(c));
                cells.assume("coulomb-friction-from-no-load", message);
                "Coulomb friction from the no-load current"
            }
            (Machine::Dc, None) => {
                cells.assume(
                    "friction-unknown",
                    "Coulomb friction unknown: no no-load current and speed to derive it from",
                );
                "Coulomb friction unknown"
            }
        });
    }
    if says.viscous.is_none() {
        words.push(match (machine, filled.viscous) {
            (Machine::Dc, _) => {
                cells.assume("viscous-friction-zero", "viscous friction taken as 0, as of a motor with brushes");
                "viscous friction taken as 0"
            }
            (Machine::Bldc, Some(b)) => {
                let message = format!("viscous friction taken as k_t I_nl/omega_nl = {} N*m*s/rad", number(b));
                cells.assume("viscous-friction-from-no-load", message);
                "viscous friction from the no-load current"
            }
            (Machine::Bldc, None) => {
                cells.assume(
                    "friction-unknown",
                    "viscous friction unknown: no no-load current and speed to derive it from",
                );
                "viscous friction unknown"
            }
        });
    }
    sheet.coulomb_friction = filled.coulomb.map(printed);
    sheet.viscous_friction = filled.viscous.map(printed);
    if words.is_empty() { String::new() } else { format!(" Friction: {}.", words.join(", ")) }
}
