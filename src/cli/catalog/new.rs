use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::{Done, Failure};
use crate::catalog::filter::names;
use crate::catalog::row::{Convention, MotorRow, Row, States, about, aliases_of, choices, column_of};
use crate::catalog::{Gear, Module, VERSION, read_gears, read_modules, read_motors};
use crate::input::Source;
use crate::output;
use crate::words::csv::csv_text;
use crate::words::nearest;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog new motor\n  gearwise catalog new requirement --write requirement.toml\n  \
                   gearwise catalog new motor --set id=my-motor --set terminals=line_to_line --set current=phase_amplitude --set 'R=0.186 ohm' --set 'KV=100 rpm/V line_to_line_peak' --set source=sheet --set source_kind=datasheet\n\n\
                   The values of a template are examples that work without edits: replace them. A template of a design names requirement.toml and rules.toml, \
                   which are what the templates of these are called."
)]
pub struct Arguments {
    /// Of what kind of file
    what: Kind,
    /// A column of the row and its value, with its unit; for motor, gear and module, may be repeated. Nothing else is in the row then
    #[arg(long, value_name = "COLUMN=VALUE")]
    set: Vec<String>,
    /// Write the file; one that is there is never replaced
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

/// What there is a template of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A row of a motor catalogue
    Motor,
    /// A row of a gear catalogue
    Gear,
    /// A row of a catalogue of modules
    Module,
    /// What a robot needs: for optimize, sweep, explain
    Requirement,
    /// Readings and logs of a motor on a bench: for characterize and identify
    Bench,
    /// Design rules: for optimize and check
    Rules,
    /// What was chosen: for check and export
    Design,
}

/// The motor of the template: columns with their units and examples.
const MOTOR: &[(&str, &str)] = &[
    ("id", "my-motor"),
    ("manufacturer", "My maker"),
    ("model", "M8 KV100"),
    ("construction", "outrunner"),
    ("terminals", "line_to_line"),
    ("current", "phase_amplitude"),
    ("resistance [ohm]", "0.186"),
    ("inductance [uH]", "140"),
    ("torque_constant [N*m/A]", ""),
    ("speed_constant [rpm/V]", "100"),
    ("speed_constant_convention", "line_to_line_peak"),
    ("rotor_inertia [g*cm^2]", "1200"),
    ("mass [g]", "240"),
    ("pole_pairs", "21"),
    ("outer_diameter [mm]", "87"),
    ("length [mm]", "26"),
    ("price", ""),
    ("price_currency", ""),
    ("price_date", ""),
    ("lead_time [d]", ""),
    ("continuous_current [A]", "9"),
    ("peak_current [A]", "25"),
    ("max_speed [rpm]", "4000"),
    ("thermal_resistance_winding_housing [K/W]", ""),
    ("thermal_resistance_housing_ambient [K/W]", ""),
    ("max_winding_temperature [degC]", "110"),
    ("source", "data sheet M8, edition 3"),
    ("source_date", "2024-05"),
    ("source_kind", "datasheet"),
    ("note", ""),
];

/// The gear of the template.
const GEAR: &[(&str, &str)] = &[
    ("id", "my-gear-9"),
    ("manufacturer", "My maker"),
    ("model", "P42 9:1"),
    ("kind", "planetary"),
    ("ratio", "9"),
    ("stages", "2"),
    ("efficiency", "0.9"),
    ("mass [g]", "180"),
    ("outer_diameter [mm]", "42"),
    ("length [mm]", "38"),
    ("inertia [g*cm^2]", "8"),
    ("continuous_torque [N*m]", "14"),
    ("peak_torque [N*m]", "28"),
    ("max_input_speed [rpm]", "6000"),
    ("backlash [arcmin]", "10"),
    ("stiffness [N*m/rad]", ""),
    ("price", ""),
    ("price_currency", ""),
    ("price_date", ""),
    ("lead_time [d]", ""),
    ("fits", "my-*"),
    ("source", "data sheet P42, edition 2"),
    ("source_date", "2024"),
    ("source_kind", "datasheet"),
    ("note", ""),
];

/// The module of the template.
const MODULE: &[(&str, &str)] = &[
    ("id", "my-module-9"),
    ("manufacturer", "My maker"),
    ("model", "A80 9:1"),
    ("kind", "planetary"),
    ("drive", "built_in"),
    ("ratio", "9"),
    ("peak_torque [N*m]", "40"),
    ("rated_torque [N*m]", "12"),
    ("no_load_speed [rpm]", "200"),
    ("voltage [V]", "48"),
    ("min_voltage [V]", "24"),
    ("max_voltage [V]", "60"),
    ("driving_curve [rad/s : N*m]", "0:40 12:40 20.9:0"),
    ("armature [kg*m^2]", "0.0158"),
    ("armature_side", "output"),
    ("torque_constant [N*m/A]", ""),
    ("torque_constant_current", ""),
    ("torque_constant_side", ""),
    ("torque_constant_loss", ""),
    ("resistance [ohm]", ""),
    ("terminals", ""),
    ("mass [g]", "900"),
    ("outer_diameter [mm]", "98"),
    ("length [mm]", "62"),
    ("price", "600"),
    ("price_currency", "EUR"),
    ("price_date", "2026-01-31"),
    ("lead_time [d]", ""),
    ("source", "data sheet A80, 2026"),
    ("source_date", "2026-01-31"),
    ("source_kind", "datasheet"),
    ("note", ""),
];

const REQUIREMENT: &str = include_str!("templates/requirement.toml");
const BENCH: &str = include_str!("templates/bench.toml");
const RULES: &str = include_str!("templates/rules.toml");
const DESIGN: &str = include_str!("templates/design.toml");

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let text = match (arguments.what, arguments.set.is_empty()) {
        (Kind::Motor, true) => template::<MotorRow>("motor", MOTOR),
        (Kind::Gear, true) => template::<Gear>("gear", GEAR),
        (Kind::Module, true) => template::<Module>("module", MODULE),
        (Kind::Module, false) => row::<Module>(&arguments.set)?,
        (Kind::Motor, false) => row::<MotorRow>(&arguments.set)?,
        (Kind::Gear, false) => row::<Gear>(&arguments.set)?,
        (Kind::Requirement, true) => REQUIREMENT.into(),
        (Kind::Bench, true) => BENCH.into(),
        (Kind::Rules, true) => RULES.into(),
        (Kind::Design, true) => DESIGN.into(),
        (_, false) => return Err(Failure::Argument("`--set` makes a row of a motor, a gear or a module".into())),
    };
    if !arguments.set.is_empty() {
        // The row is one that the reader takes.
        let source = Arc::new(Source::new("the row of --set", text.clone()));
        let read = match arguments.what {
            Kind::Motor => read_motors(&source).map(drop),
            Kind::Module => read_modules(&source).map(drop),
            _ => read_gears(&source).map(drop),
        };
        read.map_err(|error| Failure::Input(vec![error]))?;
    }
    let Some(path) = &arguments.write else { return Ok(Done { text, satisfied: true }) };
    output::write_new(path, text.as_bytes()).map_err(Failure::Argument)?;
    Ok(Done { text: format!("{}\n", path.display()), satisfied: true })
}

/// The name of a column without its unit.
fn name_of(head: &str) -> &str {
    head.split('[').next().unwrap_or(head).trim()
}

/// A commented table with one row.
fn template<R: Row>(what: &str, cells: &[(&str, &str)]) -> String {
    let mut out = format!(
        "# gearwise catalogue {VERSION}\n# A {what} as its data sheet prints it: replace the example values, or add rows. A blank cell is unknown, not zero.\n\
         # Units are in the header, in brackets; any unit of the kind is accepted. Texts with commas need double quotes.\n\
         # gearwise audit FILE says whether the row adds up; gearwise catalog add FILE puts it into your own catalogue.\n#\n"
    );
    let there: Vec<&str> = cells.iter().map(|(head, _)| name_of(head)).collect();
    for name in &there {
        let words = choices::<R>(name);
        let words = if words.is_empty() { String::new() } else { format!(": {}", words.join(", ")) };
        let others: Vec<&str> = aliases_of(name).collect();
        let others = if others.is_empty() { String::new() } else { format!("; also headed {}", others.join(", ")) };
        let about = about::<R>(name).unwrap_or_default().replace('\\', "");
        let about = about.trim().trim_end_matches('.');
        let stated = R::fields().iter().find(|f| f.name == *name).map(|f| f.states);
        let stated = match stated {
            Some(States::Convention(Convention::Resistance | Convention::Inductance)) => {
                "; between what `terminals` says, or [unit line_to_line], [unit winding], [unit q_axis]"
            }
            Some(States::Convention(
                Convention::TorqueConstant | Convention::ContinuousCurrent | Convention::PeakCurrent,
            )) => "; ampere as `current` says, or [unit rms], [unit dc], …",
            _ => "",
        };
        out.push_str(&format!("#   {name}: {about}{words}{stated}{others}\n"));
    }
    let more: Vec<&str> = names::<R>().filter(|name| !there.contains(name)).collect();
    out.push_str(&format!("# More columns: {}.\n", more.join(", ")));
    let has_tolerance = R::fields().iter().any(|f| f.tolerance.is_some());
    if has_tolerance {
        out.push_str("# A number may have a column with its ±: torque_constant_tolerance [%].\n");
    }
    let header: Vec<&str> = cells.iter().map(|(head, _)| *head).collect();
    out + &csv_text(&header, [cells.iter().map(|(_, cell)| (*cell).to_string()).collect()])
}

/// A row of columns with their values.
fn row<R: Row>(set: &[String]) -> Result<String, Failure> {
    let (mut header, mut cells) = (Vec::new(), Vec::new());
    for text in set {
        let wrong = |why: String| Failure::Argument(format!("`--set {text}`: {why}"));
        let Some((head, value)) = text.split_once('=') else {
            return Err(wrong("write it like mass=240g".into()));
        };
        // Of a curve both units are behind the name.
        let (name, value, units) =
            (name_of(head), value.trim(), head.trim().strip_prefix(name_of(head)).unwrap_or_default());
        let column = column_of(name).unwrap_or(name);
        let own = column.strip_suffix("_tolerance").unwrap_or(column);
        let is_number = R::fields().iter().any(|f| f.name == own);
        if !is_number && !names::<R>().any(|n| n == column) {
            let help = match nearest(name, names::<R>()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are: {}", names::<R>().collect::<Vec<_>>().join(", ")),
            };
            return Err(wrong(format!("there is no column `{name}`; {help}")));
        }
        if value.is_empty() {
            return Err(wrong("it has no value; leave out what is not known".into()));
        }
        let (cell, unit) = if is_number { number_and_unit(value) } else { (value, "") };
        header.push(match (unit.is_empty(), units.trim()) {
            (true, "") => column.to_string(),
            (true, units) => format!("{column} {units}"),
            (false, _) => format!("{column} [{unit}]"),
        });
        cells.push(cell.to_string());
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    Ok(csv_text(&header, [cells]))
}

/// `"240 g rms"` as `240` and `g rms`.
fn number_and_unit(value: &str) -> (&str, &str) {
    let mut end = 0;
    let bytes = value.as_bytes();
    while end < bytes.len() {
        let after_digit = end > 0 && bytes[end - 1].is_ascii_digit();
        let exponent = matches!(bytes[end], b'e' | b'E')
            && after_digit
            && bytes.get(end + 1).is_some_and(|n| n.is_ascii_digit() || matches!(n, b'+' | b'-'));
        let sign = matches!(bytes[end], b'+' | b'-') && (end == 0 || matches!(bytes[end - 1], b'e' | b'E'));
        if !(bytes[end].is_ascii_digit() || matches!(bytes[end], b'.' | b',') || exponent || sign) {
            break;
        }
        end += 1;
    }
    (value[..end].trim(), value[end..].trim())
}
