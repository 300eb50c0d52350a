//! The page of file formats: what the readers ask for, with what they say of it. No key or column is listed here.

use super::{MADE, code, plain, table};
use crate::catalog::alternative::written::COLUMNS as ALTERNATIVES;
use crate::catalog::convention::{
    BLOCK, BackEmfConvention, Commutation, CurrentConvention, Modulation, SpeedConstantConvention, Terminals, Winding,
};
use crate::catalog::row::{MotorRow, about, aliases_of, choices};
use crate::catalog::{Gear, Module, VERSION, family, fitted, gear_columns, module_columns, motor_columns};
use crate::effects::EFFECTS;
use crate::input::TableAsked;
use crate::input::csv::{Column, Content};
use crate::measured::{self, BenchKind};
use crate::report::currents;
use crate::requirement::{self, design_file};
use crate::study::file as study_file;
use crate::{hardware, motion, rules};

/// A kind of TOML file.
#[derive(Debug)]
pub struct Format {
    /// Its heading.
    pub title: &'static str,
    /// What such a file is for.
    pub about: &'static str,
    /// Its tables, as their reader asks for them.
    pub tables: Vec<TableAsked>,
}

/// Every kind of TOML file that is read.
pub fn formats() -> Vec<Format> {
    let format = |title, about, tables| Format { title, about, tables };
    let [row, axis] = fitted::describe();
    let mut of_fitted = row.tables;
    of_fitted.extend(axis.tables.into_iter().filter(|t| !t.path.is_empty()));
    vec![
        format(REQUIREMENT, "What a robot needs: for `optimize`, `sweep`, `explain`.", requirement::describe().tables),
        format(FITTED, "Written by `identify --write`; use it wherever a catalogue file may be used.", of_fitted),
        format(
            FAMILY,
            "Gears of one kind by one rule, each a point: a joint takes them with `family`; `--also` reads the file.",
            family::describe().tables,
        ),
        format(
            DESIGN,
            "What was chosen: for `check` and `export`; `optimize --write-design` makes one.",
            design_file::describe().tables,
        ),
        format(RULES, "For `check`; a design names it.", rules::file::describe().tables),
        format(
            HARDWARE,
            "Which hardware drives which joints of a robot model: for `check-model`.",
            hardware::describe().tables,
        ),
        format(STUDY, "Many robots from one: for `study`.", study_file::describe().tables),
        format(BENCH, "Logs of an actuator: for `identify` and `characterize`.", measured::read::describe().tables),
    ]
}

/// Requirement files.
pub const REQUIREMENT: &str = "Requirement (TOML)";
/// Fitted actuators.
pub const FITTED: &str = "Fitted actuator (TOML)";
/// Families of gears.
pub const FAMILY: &str = "Gear family (TOML)";
/// Design files.
pub const DESIGN: &str = "Design (TOML)";
/// Rules files.
pub const RULES: &str = "Rules (TOML)";
/// Files of hardware.
pub const HARDWARE: &str = "Hardware of a robot model (TOML)";
/// Study files.
pub const STUDY: &str = "Study (TOML)";
/// Bench files.
pub const BENCH: &str = "Bench (TOML)";

/// The page of file formats.
pub fn text() -> String {
    let mut out = format!(
        "{MADE}# File formats\n\nA number with a dimension has its unit: in quotes in TOML (`\"18 N*m\"`, `\"300 rpm\"`), in the header in \
         CSV (`torque [N*m]`); any unit of the kind is accepted. Numbers have a decimal point. Lines that begin with `#` are comments. An \
         unknown key or column is a mistake, reported with its place and the nearest name that exists. `[[joint]]` is a list of \
         tables: one for each joint.\n"
    );
    for format in formats() {
        out.push_str(&format!("\n## {}\n\n{}\n", format.title, format.about));
        tables(&mut out, &format.tables);
        out.push_str(&after(format.title));
    }
    out
}

/// What is said behind the tables of a format.
fn after(title: &str) -> String {
    match title {
        REQUIREMENT => currents_in_results() + &motions() + &motors() + &gears() + &modules() + &alternatives() + &rows_in_toml(),
        FITTED => {
            let names: Vec<String> = EFFECTS.iter().map(|e| code(e.name())).collect();
            format!(
                "\nKeys of `[motor]` are the columns of a motor catalogue. Tables of `[effects]`: {}; their parameters are on the \
                 page of [effects](effects.md), and each may have its `…_tolerance`.\n",
                names.join(", ")
            )
        }
        FAMILY => "\nKeys of `[[point]]` are the columns of a gear catalogue, but for those that the family says (id, manufacturer, model, \
                   kind, stages, fits, source, source_kind); `ratio` must be there. The id of a point is the name of the family and the \
                   ratio. `stress_limit` of a point has to be that of the family.\n"
            .into(),
        STUDY => "\nA key of `[grid]` is a path into the requirement with its values: `bus.voltage = [\"24 V\", \"48 V\"]`, \
                  `joint.knee.gear.efficiency`, `joint.*.ratio.max` for all joints, or a range \
                  `{ from = \"24 V\", to = \"48 V\", steps = 5 }`. `scale.torque` and `scale.speed` multiply the motions.\n"
            .into(),
        BENCH => {
            let kinds: Vec<String> = BenchKind::NAMES.iter().map(|(name, _)| code(name)).collect();
            format!(
                "\nKinds of bench: {}. Every column is a table like those of `time`, `velocity`, `current` and `duty`: positions, \
                 velocities, accelerations, torques and goals have a `side`, `current` and `voltage` a `convention`, and what drives \
                 the machine (`duty`, `goal`, `current`, `force`) has `held`.\n",
                kinds.join(", ")
            )
        }
        _ => String::new(),
    }
}

fn currents_in_results() -> String {
    format!(
        "\n### Currents in results\n\n{} JSON, CSV and studies give both, `…_phase_a` (phase amplitude, DC of a brushed motor: \
         what a drive is bought by) and `…_q_a`. In tables `I peak [A]` is the phase amplitude.\n",
        currents::Q_AXIS,
    )
}

fn motions() -> String {
    let of = |name: &str| {
        let own = motion::OWN_COLUMNS.iter().find(|(own, ..)| *own == name);
        own.map_or_else(String::new, |(.., about)| (*about).into())
    };
    let about = "What the joint does, at the output, without the actuator's own rotor; torque × velocity > 0 means that the motor \
                 drives. Time increases; the last row repeats the first of a periodic motion. `velocity` or `position` must be there; \
                 what is missing comes from a cubic spline. Where no acceleration, torque rate or jerk is given, the spline of torque \
                 and that of speed are the motion, and limits hold between the samples too. (Of a position it is the speed's spline \
                 through the slopes of the position's: where a move takes four samples or fewer its peaks may be missed. Give more \
                 samples there.) Give rates only where they are known better than by a spline.";
    format!("\n## Motion (CSV)\n\n{about}\n\n{}", columns(&motion::columns(&[]), of, |_| &[]))
}

fn motors() -> String {
    let all = motor_columns();
    let shown: Vec<Column> = all.iter().filter(|c| !matches!(c.content, Content::Tolerance(_))).cloned().collect();
    let of = |name: &str| plain(about::<MotorRow>(name).unwrap_or_default());
    format!(
        "\n## Motor catalogue (CSV)\n\nOne row for each motor, as its sheet prints it; the row says in which conventions, and the reader \
         converts to the power-invariant q axis. Blank is unknown, not zero. Every numeric column may have a `…_tolerance` next to it, in \
         a unit of the same kind or in `%`. {}\n\n{}{}{}",
        aliases(&shown),
        columns(&shown, of, choices::<MotorRow>),
        stated(
            &shown,
            "A column may be given in another convention than its row: the word is behind the unit, \
             `torque_constant [N*m/A rms]`. Where it states none, that of `terminals`, `current`, `back_emf_convention` or \
             `speed_constant_convention` holds."
        ),
        conventions()
    )
}

fn gears() -> String {
    let all = gear_columns();
    let of = |name: &str| about::<Gear>(name).unwrap_or_default().to_string();
    format!(
        "\n## Gear catalogue (CSV)\n\nTorques, backlash and stiffness at the output; inertia and speed at the input. A gear without `efficiency` cannot be \
         chosen. {}\n\n{}{}",
        aliases(&all),
        columns(&all, of, choices::<Gear>),
        stated(
            &all,
            "A column may state at which side of the gear its numbers are, `inertia [kg*m^2 output]`: inertia, backlash and stiffness \
             are converted by the ratio, torque and speed are accepted at their own side only."
        )
    )
}

fn modules() -> String {
    let all: Vec<Column> =
        module_columns().into_iter().filter(|c| !matches!(c.content, Content::Tolerance(_))).collect();
    let of = |name: &str| plain(about::<Module>(name).unwrap_or_default());
    format!(
        "\n## Module catalogue (CSV)\n\nMotor, gear and mostly a drive, bought as one ([modules.md](modules.md)). A file with the columns `ratio` and `drive` \
         holds modules. Torques, speeds, backlash and stiffness are those of the output flange. Every other number says at which side and in which \
         convention it is, in a column of its own; a number that does not is a mistake. Curves and tables are pairs in one cell, `0:71 22.6:71 35.5:0`, \
         with both units in the header, `driving_curve [rad/s : N*m]`; in TOML a list of pairs, `[[\"0 rad/s\", \"71 N*m\"], …]`. A number may have a column of its ±, `…_tolerance`.\n\n{}",
        columns(&all, of, choices::<Module>),
    )
}

/// What other sources say of rows.
fn alternatives() -> String {
    let rows = ALTERNATIVES.iter().map(|(name, required, about)| {
        let name = if *required { format!("**{}**", code(name)) } else { code(name) };
        vec![name, (*about).to_string()]
    });
    format!(
        "\n## Alternatives (CSV)\n\nWhat other sources say of numbers of motors, gears and modules ([modules.md](modules.md)): one line for each \
         number. A file with the columns `column` and `value` holds them; the rows must be in the same catalogue.\n\n{}",
        table(&["column", "what it is"], rows)
    )
}

/// Other names of columns.
fn aliases(columns: &[Column]) -> String {
    let of = |column: &Column| {
        let others: Vec<String> = aliases_of(&column.name).map(code).collect();
        (!others.is_empty()).then(|| format!("{} for {}", others.join(", "), code(&column.name)))
    };
    let all: Vec<String> = columns.iter().filter_map(of).collect();
    format!(
        "A column may have another name: {}. An alias says no convention and no unit; a column under two names is a mistake.",
        all.join("; ")
    )
}

fn rows_in_toml() -> String {
    format!(
        "\n## Catalogues in general\n\nThe first line may say the version of the columns, `# gearwise catalogue {VERSION}`; without it the \
         version is 1, and a later version than this gearwise reads is refused. A column may be there several times, each time with \
         other words behind its unit (`torque_constant [N*m/A rms]`, `torque_constant [N*m/A dc]`); a row fills one of them.\n\n\
         A catalogue may also be a TOML file with a table `[[motor]]`, `[[gear]]` or `[[module]]` for each row. Its keys are the columns, and its \
         values have their units and words:\n\n```toml\n[[motor]]\nid = \"my-motor\"\nterminals = \"line_to_line\"\n\
         current = \"phase_amplitude\"\nresistance = \"0.16 ohm\"\ntorque_constant = \"0.23 N*m/A rms\"\n\
         torque_constant_tolerance = \"5 %\"\nsource = \"data sheet\"\nsource_kind = \"datasheet\"\n```\n"
    )
}

fn tables(out: &mut String, all: &[TableAsked]) {
    for one in all {
        let title = if one.path.is_empty() { "At the top".to_string() } else { code(&one.path) };
        let rows = one.keys.iter().map(|k| vec![code(k.name), k.value.clone(), k.meaning()]);
        out.push_str(&format!("\n{title}\n\n{}", table(&["key", "value", "what it is"], rows)));
    }
}

fn columns(
    columns: &[Column],
    about: impl Fn(&str) -> String,
    choices: impl Fn(&str) -> &'static [&'static str],
) -> String {
    let rows = columns.iter().map(|c| {
        let words = choices(&c.name);
        let (unit, values) = match c.content {
            Content::Text if words.is_empty() => ("", "text".to_string()),
            Content::Text => ("", words.iter().map(|w| code(w)).collect::<Vec<_>>().join(", ")),
            Content::Count => ("", "whole number from 1".into()),
            Content::Tolerance(kind) => (kind.si, "±".into()),
            Content::Quantity(kind, range) | Content::Stated(kind, range, _) => (kind.si, range.words().into()),
            Content::Pairs(_) => ("", "pairs `a:b`".into()),
        };
        let name = if c.required { format!("**`{}`**", c.name) } else { code(&c.name) };
        vec![name, if unit == "1" { String::new() } else { code(unit) }, values, about(&c.name)]
    });
    format!("{}\nBold columns must be there.\n", table(&["column", "SI unit", "values", "what it is"], rows))
}

/// The words that may stand behind units, by column.
fn stated(columns: &[Column], about: &str) -> String {
    let rows = columns.iter().filter_map(|c| {
        let Content::Stated(_, _, words) = c.content else { return None };
        Some(vec![code(&c.name), words.all().map(code).collect::<Vec<_>>().join(", ")])
    });
    format!("\n{about}\n\n{}", table(&["column", "words behind its unit"], rows))
}

/// Every convention with the factor that takes the printed number to the q axis, from the code that does it.
fn conventions() -> String {
    let b = Commutation::Brushless;
    let number = |x: f64| format!("{x:.4}");
    let mut out = format!(
        "\n### Conventions\n\nq-axis value = printed value × factor, for brushless motors (of a brushed one all are 1). Block commutation: \
         √(3/2) π/(3√3) = {}.\n\n",
        number(BLOCK)
    );
    let currents = CurrentConvention::NAMES.iter().map(|(name, c)| {
        vec![code(name), number(c.torque_constant(b)), number(c.torque_current(b)), number(c.heating_current(b))]
    });
    out.push_str(&table(&["`current`", "torque constant", "peak current", "continuous current"], currents));
    out.push('\n');
    let emf = BackEmfConvention::NAMES.iter().map(|(name, c)| vec![code(name), number(c.back_emf_constant(b))]);
    out.push_str(&table(&["`back_emf_convention`", "back-EMF constant"], emf));
    out.push('\n');
    let speed = SpeedConstantConvention::NAMES
        .iter()
        .map(|(name, c)| vec![code(name), format!("{}/Kv", number(c.back_emf_constant(b)))]);
    out.push_str(&table(&["`speed_constant_convention`", "back-EMF constant"], speed));
    out.push('\n');
    let terminals = Terminals::NAMES.iter().map(|(name, t)| {
        let of = |w| t.resistance(Some(w), b).map_or_else(String::new, number);
        vec![code(name), of(Winding::Wye), of(Winding::Delta)]
    });
    out.push_str(&table(&["`terminals`", "resistance, inductance: wye", "delta"], terminals));
    out.push('\n');
    let voltage = Modulation::NAMES.iter().map(|(name, m)| vec![code(name), number(m.voltage(b))]);
    out.push_str(&table(&["`modulation`", "voltage circle / bus voltage"], voltage));
    out
}
