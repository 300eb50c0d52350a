//! Readings that are no logs: `[motor]`, `[terminals]`, `[rotor]`.

use crate::bench::{KnownMotor, Readings, RotorReadings, TerminalReadings};
use gearwise_model::catalog::FIELDS;
use gearwise_model::catalog::convention::{Commutation, CurrentConvention, Winding};
use gearwise_model::catalog::{Printed, Sheet};
use gearwise_model::input::{Key, Problem, Range, Section, key};
use gearwise_model::units::{self, Kind};

/// Columns of a row that `[motor]` may give, with the key of their ±: those that need no convention, and the
/// currents, which say theirs.
const GIVEN: &[(&str, &str)] = &[
    ("rotor_inertia", "rotor_inertia_tolerance"),
    ("rotor_mass", "rotor_mass_tolerance"),
    ("mass", "mass_tolerance"),
    ("gap_radius", "gap_radius_tolerance"),
    ("outer_diameter", "outer_diameter_tolerance"),
    ("length", "length_tolerance"),
    ("continuous_current", "continuous_current_tolerance"),
    ("peak_current", "peak_current_tolerance"),
    ("continuous_torque", "continuous_torque_tolerance"),
    ("peak_torque", "peak_torque_tolerance"),
    ("max_speed", "max_speed_tolerance"),
    ("thermal_resistance_winding_housing", "thermal_resistance_winding_housing_tolerance"),
    ("thermal_resistance_housing_ambient", "thermal_resistance_housing_ambient_tolerance"),
    ("thermal_time_constant_winding", "thermal_time_constant_winding_tolerance"),
    ("thermal_time_constant_housing", "thermal_time_constant_housing_tolerance"),
    ("max_winding_temperature", "max_winding_temperature_tolerance"),
    ("coulomb_friction", "coulomb_friction_tolerance"),
    ("viscous_friction", "viscous_friction_tolerance"),
];

const MOTOR: Key =
    key("motor", "for `characterize`: `id` and any column of a motor catalogue, `…_tolerance` too, that no test gives");
const RESISTANCE: Key = key("resistance", "of each pair of terminals")
    .value("three of resistance, as `\"1.41 ohm\"`; one of a motor with two terminals");
const INDUCTANCE: Key = key("inductance", "of each pair of terminals")
    .value("three of inductance, as `\"1.2 mH\"`; one of a motor with two terminals");

/// Reads the three tables, and the ambient temperature.
pub fn read(root: &Section) -> Readings {
    Readings {
        motor: root.section(MOTOR).map(read_motor).unwrap_or_default(),
        terminals: root
            .section(key("terminals", "for `characterize`: readings between the terminals"))
            .map(read_terminals),
        rotor: root.section(key("rotor", "for `characterize`: the rotor as a thin ring")).and_then(read_rotor),
        ambient: root.quantity(key("ambient", "around the bench"), &units::TEMPERATURE, Range::Positive),
    }
}

fn read_motor(table: Section) -> KnownMotor {
    let text = |key| {
        if table.has(key) { table.required_text(key, "\"a name\"").map(toml::Spanned::into_inner) } else { None }
    };
    let id = text("id");
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.' | '_');
    if let Some(id) = id.as_ref().filter(|id| !id.chars().all(good)) {
        table.note(
            Problem::at(
                table.span_of("id"),
                "an id has lower-case letters, digits, `-`, `_` and `.` only",
                "other characters here",
            )
            .help(format!("for example `{}`", id.to_lowercase().replace(|c| !good(c), "-"))),
        );
    }
    let (manufacturer, model) = (text("manufacturer"), text("model"));
    let commutation = table.choice("commutation", Commutation::NAMES);
    let brushless = commutation.unwrap_or(Commutation::Brushless);
    let convention = table.choice("current", CurrentConvention::NAMES);
    let mut sheet = Sheet::default();
    for (key, tolerance) in GIVEN {
        let Some(field) = FIELDS.iter().find(|f| f.name == *key) else { continue };
        let value = table.quantity(key, field.kind, field.range);
        let tolerance = read_tolerance(&table, tolerance, field.kind, value);
        let Some(value) = value else { continue };
        let mut factor = 1.0;
        if matches!(*key, "continuous_current" | "peak_current") {
            let Some(convention) = convention.or((brushless == Commutation::Brushed).then_some(CurrentConvention::Dc))
            else {
                if !table.has("current") {
                    table.missing("current", "\"phase_amplitude\"  # what ampere means in the currents of this table");
                }
                continue;
            };
            factor = match *key {
                "continuous_current" => convention.heating_current(brushless),
                _ => convention.torque_current(brushless),
            };
        }
        (field.set)(&mut sheet, Printed { value: value * factor, tolerance: tolerance.map(|t| t * factor) });
    }
    let pole_pairs = table.count("pole_pairs");
    table.finish();
    KnownMotor { id, manufacturer, model, commutation, pole_pairs, sheet }
}

/// A ± in the unit of its quantity, or in percent of it.
fn read_tolerance(table: &Section, name: &'static str, kind: &'static Kind, value: Option<f64>) -> Option<f64> {
    if !table.has(key(name, "± (95 %)").value("the same unit, or `%` of the value")) {
        return None;
    }
    let relative = table
        .text(name)
        .filter(|t| t.get_ref().trim_end().ends_with('%'))
        .and_then(|t| units::quantity(t.get_ref(), &units::RATIO).ok());
    match relative {
        Some(share) if share >= 0.0 => value.map(|v| share * v.abs()),
        _ if *kind == units::TEMPERATURE => {
            table.note(Problem::at(table.span_of(name), format!("`{name}` cannot be read"), "expected percent"));
            None
        }
        _ => table.quantity(name, kind, Range::NonNegative),
    }
}

fn read_terminals(table: Section) -> TerminalReadings {
    let winding = table.choice(key("winding", "how the windings are connected"), Winding::NAMES);
    let resistance = readings(&table, RESISTANCE, &units::RESISTANCE);
    let inductance = readings(&table, INDUCTANCE, &units::INDUCTANCE);
    if !table.has("resistance") && !table.has("inductance") {
        table.missing(
            "resistance",
            "[\"1.41 ohm\", \"1.42 ohm\", \"1.40 ohm\"]  # line to line, each pair of terminals",
        );
    }
    let mean = |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    let resistance_tolerance = read_tolerance(&table, "resistance_tolerance", &units::RESISTANCE, mean(&resistance));
    let inductance_tolerance = read_tolerance(&table, "inductance_tolerance", &units::INDUCTANCE, mean(&inductance));
    let temperature = table.quantity(key("temperature", "of the winding then"), &units::TEMPERATURE, Range::Positive);
    table.finish();
    TerminalReadings { winding, resistance, resistance_tolerance, inductance, inductance_tolerance, temperature }
}

/// Three readings, one for each pair of terminals, or the single one of a motor with two.
fn readings(table: &Section, asked: Key, kind: &'static Kind) -> Vec<f64> {
    let key = asked.name();
    if !table.has(asked) {
        return Vec::new();
    }
    if !table.is_list(key) {
        return table.quantity(key, kind, Range::Positive).into_iter().collect();
    }
    let Some(texts) = table.texts(key) else { return Vec::new() };
    let mut values = Vec::new();
    for text in &texts {
        match units::quantity(text.get_ref(), kind) {
            Ok(value) if value > 0.0 => values.push(value),
            Ok(_) => table.note(Problem::at(text.span(), format!("`{key}` must be greater than zero"), "in this list")),
            Err(error) => table.note(
                Problem::at(
                    text.span(),
                    format!("`{key}`: {}", error.message(kind)),
                    format!("expected {}", kind.with_article()),
                )
                .help(error.help(kind)),
            ),
        }
    }
    if !matches!(texts.len(), 1 | 3) {
        table.note(
            Problem::at(
                table.span_of(key),
                format!("`{key}` has {} readings", texts.len()),
                "expected three, one for each pair of terminals",
            )
            .help("a motor with two terminals has one"),
        );
    }
    values
}

fn read_rotor(table: Section) -> Option<RotorReadings> {
    let mass = table.required_quantity(key("mass", "of the rotor"), &units::MASS, Range::Positive);
    let radius = table.required_quantity(key("radius", "of the ring"), &units::LENGTH, Range::Positive);
    let mass_tolerance = read_tolerance(&table, "mass_tolerance", &units::MASS, mass);
    let radius_tolerance = read_tolerance(&table, "radius_tolerance", &units::LENGTH, radius);
    for (key, there, example) in [
        ("mass_tolerance", mass_tolerance.is_some(), "\"0.5 g\"  # 95 %"),
        ("radius_tolerance", radius_tolerance.is_some(), "\"0.5 mm\"  # 95 %"),
    ] {
        if !there && !table.has(key) {
            table.missing(key, example);
        }
    }
    table.finish();
    Some(RotorReadings {
        mass: mass?,
        mass_tolerance: mass_tolerance?,
        radius: radius?,
        radius_tolerance: radius_tolerance?,
    })
}
