//! The page of file formats. Columns come from the readers; keys of TOML tables stand here, and a test asks the
//! readers whether they know these and no others.

use super::{MADE, code, plain, table};
use crate::catalog::convention::{
    BLOCK, BackEmfConvention, Commutation, CurrentConvention, Modulation, SpeedConstantConvention, Terminals, Winding,
};
use crate::catalog::{FIELDS, GearKind, SourceKind, gear_columns, motor_columns};
use crate::effects::EFFECTS;
use crate::input::Range;
use crate::input::csv::{Column, Content};
use crate::measured::BenchKind;
use crate::motion;
use crate::report::currents;

/// A table of a TOML file with its keys.
#[derive(Debug)]
pub struct Table {
    /// As a message of the reader names it: `[bus]`, `[[joint]]`; empty at the top.
    pub path: &'static str,
    /// Key, what it may be, what it is. The reader knows these and no others.
    pub keys: &'static [(&'static str, &'static str, &'static str)],
}

/// Requirement files.
pub const REQUIREMENT: &[Table] = &[
    Table {
        path: "",
        keys: &[
            ("name", "text", "name of the robot; required"),
            ("bus", "table", "the supply; required"),
            ("ambient", "table", "the surroundings"),
            ("budget", "table", "what the whole robot may have"),
            ("joint", "list of tables", "the joints; at least one"),
            ("mechanism", "table", "a description of the robot that torques are computed from"),
        ],
    },
    Table {
        path: "[bus]",
        keys: &[
            ("voltage", "voltage", "bus voltage; required"),
            ("modulation", "`space_vector`, `sine`", "how the drive makes phase voltages; `space_vector` unless said"),
            ("modulation_limit", "0 to 1", "share of the ideal voltage that may be used; a reserve goes here"),
            ("drive_current", "current", "largest drive current, phase amplitude (DC ampere of a brushed motor)"),
            ("power", "power", "largest power that the bus gives one joint"),
            ("current", "current", "largest current that the bus gives one joint"),
            ("regeneration", "`allowed`, `none`, power", "what the bus takes back at any instant; all unless said"),
            ("drive_efficiency", "0 to 1", "efficiency of the drive, η_d; 1 unless said"),
        ],
    },
    Table { path: "[ambient]", keys: &[("temperature", "temperature", "25 degC unless said")] },
    Table {
        path: "[budget]",
        keys: &[
            ("actuator_mass", "mass", "all actuators together, counts included"),
            ("max_distinct_motors", "whole number", "how many different motors"),
            ("power", "power", "what all joints together may take from the bus at any instant"),
            ("current", "current", "the same as a current of the bus"),
        ],
    },
    Table {
        path: "[[joint]]",
        keys: &[
            ("name", "text", "name of the joint; required"),
            ("count", "whole number", "how many joints like this; 1 unless said"),
            ("ratio", "table", "a continuous ratio; this or `gears`"),
            (
                "gears",
                "list of patterns",
                "gears of the catalogue by id, `*` for any run of characters; this or `ratio`",
            ),
            ("gear", "table", "the gear that goes with a continuous ratio; ideal unless said"),
            ("motion", "file", "CSV file beside this one; this or `points`"),
            ("points", "list of tables", "operating points, each for itself; this or `motion`"),
            ("periodic", "true, false", "whether the motion repeats; true unless said"),
            ("period", "time", "of a motion whose last row does not repeat the first"),
            (
                "repeat_every",
                "time",
                "of a motion that happens once (`periodic = false`): from one start to the next, with rest in between; heat starts cold unless said",
            ),
            (
                "objective",
                "name or table of weights",
                "what is minimised; `loss` unless said; of weights (of one, too) a pure number",
            ),
            ("reference", "table", "what each weighted quantity is divided by"),
            ("limits", "table", "what a choice must keep"),
            ("spring", "table", "a parallel spring to be chosen; may stand under `limits`"),
            ("drive", "table", "the drive of this joint, in place of the bus's"),
            (
                "torque_per_mass",
                "table of torque per mass",
                "by joint: what a kilogram of its actuator adds to this joint's torque",
            ),
            ("phases", "list of numbers", "by how much of the period each of the `count` joints is late, 0 to 1"),
            (
                "mechanism_joint",
                "name",
                "a joint of `[mechanism]`, in place of `motion`; with it `lead` (travel per turn of the gear's output, where it slides) and `actuator_at` (`link`, `at`: where the actuator sits; at the joint unless said)",
            ),
            ("actuator", "", "refused by this version"),
        ],
    },
    Table {
        path: "[mechanism]",
        keys: &[
            ("model", "file", "URDF or MJCF; required"),
            ("trajectory", "file", "CSV, a column for each joint; required"),
            (
                "actuators",
                "`included`, `separate`",
                "whether the masses of the model contain the actuators; `included` unless said",
            ),
            ("payload", "table or list of tables", "masses that a link carries"),
            ("gravity", "three accelerations", "in the world; the model's unless said"),
            ("periodic", "true, false", "whether the trajectory repeats; true unless said"),
            ("period", "time", "of a trajectory whose last row does not repeat the first"),
            (
                "repeat_every",
                "time",
                "of a trajectory that happens once: from one start to the next, with rest in between",
            ),
            (
                "joint_friction",
                "true, false",
                "whether damping and dry friction of the model's joints count as load; true unless said",
            ),
        ],
    },
    Table {
        path: "[payload]",
        keys: &[
            ("link", "name", "the link that carries it; required"),
            ("mass", "mass", "required"),
            ("at", "three lengths", "on the link; its origin unless said"),
        ],
    },
    Table {
        path: "[ratio]",
        keys: &[("min", "number", "smallest ratio; required"), ("max", "number", "largest ratio; required")],
    },
    Table {
        path: "[gear]",
        keys: &[
            ("efficiency", "0 to 1", "when the motor drives, η; 1 unless said"),
            ("backdrive_efficiency", "at most 1", "when the load drives, η_b; 2 − 1/η unless said"),
            ("mass", "mass", "where it does not depend on the ratio; none unless said"),
            ("mass_per_stage", "mass", "in place of `mass`"),
            ("stage_ratio", "from 1.1", "largest ratio of a stage; with `mass_per_stage`"),
            ("inertia", "inertia", "at the input, J_g; none unless said"),
            ("peak_torque", "torque", "largest, at the output"),
            ("continuous_torque", "torque", "for ever, at the output"),
            ("max_input_speed", "speed", "largest, at the input"),
            (
                "efficiency_covers",
                "`load`",
                "`load_and_gear` needs gears of the catalogue, and stands in the joint there",
            ),
        ],
    },
    Table {
        path: "[[points]]",
        keys: &[
            ("torque", "torque", "at the output; required"),
            ("speed", "speed", "at the output; required"),
            ("acceleration", "angular acceleration", "zero unless said"),
            ("torque_rate", "torque rate", "zero unless said"),
            ("jerk", "angular jerk", "zero unless said"),
            ("duration", "time", "of all points or of none; heat is checked only with it"),
        ],
    },
    Table {
        path: "[objective]",
        keys: &[
            ("loss", "weight", "mean copper loss [W]"),
            ("energy", "weight", "drawn from the bus per cycle [J]"),
            ("peak_power", "weight", "largest drawn from the bus [W]"),
            ("peak_current", "weight", "largest q-axis current [A], as limits on currents compare it"),
            ("reflected_inertia", "weight", "N² (J_m + J_g) [kg*m^2]"),
            ("mass", "weight", "of motor and gear [kg]"),
        ],
    },
    Table {
        path: "[reference]",
        keys: &[
            ("loss", "power", ""),
            ("energy", "energy", ""),
            ("peak_power", "power", ""),
            ("peak_current", "current", "q axis"),
            ("reflected_inertia", "inertia", ""),
            ("mass", "mass", ""),
        ],
    },
    Table {
        path: "[limits]",
        keys: &[
            (
                "actuator_mass",
                "mass",
                "of motor and gear; like every limit here it has to be judged, or the motor is no choice",
            ),
            ("reflected_inertia", "inertia", "N² (J_m + J_g) at the output"),
            ("torque_bandwidth", "table", "a sinusoidal torque on top of the motion"),
            ("winding_temperature", "temperature", "highest; the motor's own holds too"),
            ("safety", "number", "factor on demanded torque and current, not on heat; 1 unless said"),
            ("spring", "table", "a parallel spring to be chosen"),
        ],
    },
    Table {
        path: "[torque_bandwidth]",
        keys: &[("frequency", "frequency", "required"), ("amplitude", "torque", "at the output; required")],
    },
    Table {
        path: "[spring]",
        keys: &[
            ("stiffness", "[least, most] stiffness", "k; required"),
            ("rest_angle", "[least, most] angle", "q_0 on the scale of the motion's position; required"),
        ],
    },
    Table { path: "[drive]", keys: &[("current", "current", "largest, phase amplitude; required")] },
];

/// Bench files.
pub const BENCH: &[Table] = &[
    Table {
        path: "",
        keys: &[
            ("name", "text", "name of the bench; the file's unless said"),
            ("kind", "kind of bench", "may stand in each log instead"),
            ("actuator", "table", "the declared model; required"),
            ("catalog", "list of paths", "beside this file; the built-in catalogue unless said"),
            ("columns", "table", "what the columns of the logs are; may stand in each log"),
            ("load", "table", "what hangs at the output"),
            ("pendulum", "table", "a pendulum at the output, in place of `load`"),
            ("controller", "table", "of kind `servo`: what makes duty of the goal"),
            ("log", "list of tables", "the logs; at least one"),
            ("ambient", "temperature", "around the bench"),
            (
                "motor",
                "table",
                "for `characterize`: `id` and any column of a motor catalogue, `…_tolerance` too, that no test gives",
            ),
            (
                "terminals",
                "table",
                "for `characterize`: `winding`, three readings each of `resistance` and `inductance`, `…_tolerance` (95 %), `temperature`",
            ),
            (
                "rotor",
                "table",
                "for `characterize`: `mass` and `radius` of the rotor as a thin ring, `…_tolerance` (95 %)",
            ),
        ],
    },
    Table {
        path: "[actuator]",
        keys: &[
            ("motor", "id", "of the catalogue; required unless the axis is linear"),
            ("ratio", "number", "of the gear; 1 unless said"),
            ("gear", "id or table", "of the catalogue, or its numbers"),
            ("efficiency", "0 to 1", "when the motor drives"),
            ("backdrive_efficiency", "at most 1", "when the load drives"),
            ("gear_inertia", "inertia", "at the input"),
            ("fixture_inertia", "inertia", "of what is bolted to the motor's shaft"),
            ("effects", "table or list", "what is declared beyond the row; see [effects](effects.md)"),
            ("mass", "mass", "of a linear axis"),
            ("force_gain", "force per voltage or current", "of a linear axis"),
        ],
    },
    Table {
        path: "[columns]",
        keys: &[
            ("time", "column", "required"),
            ("current", "column", "with `convention`"),
            ("bus_current", "column", ""),
            ("voltage", "column", "with `convention`"),
            ("supply", "column", "bus voltage"),
            ("duty", "column", "−1 to 1"),
            ("position", "column", "with `side`"),
            ("motor_position", "column", ""),
            ("output_position", "column", ""),
            ("velocity", "column", "with `side`"),
            ("motor_velocity", "column", ""),
            ("output_velocity", "column", ""),
            ("acceleration", "column", "with `side`"),
            ("torque", "column", "with `side`"),
            ("force", "column", "of a linear axis"),
            ("goal", "column", "of kind `servo`"),
            ("command", "column", "torque that was asked of the driving machine, of kind `random_torque`"),
            ("winding_temperature", "column", ""),
            ("magnet_temperature", "column", ""),
            ("housing_temperature", "column", ""),
            ("motor_temperature", "column", ""),
            ("temperature", "column", ""),
        ],
    },
    Table {
        path: "[time]",
        keys: &[
            ("name", "text", "in the log's header; required"),
            ("unit", "unit", "required where the quantity has one"),
            ("scale", "number", "factor on the column"),
            ("sign", "1, -1", ""),
            ("bits", "whole number", "width of a counter that wraps"),
        ],
    },
    Table {
        path: "[velocity]",
        keys: &[
            ("name", "text", "in the log's header; required"),
            ("unit", "unit", "required"),
            ("side", "`motor`, `output`", "where it was measured; the output unless said"),
            ("scale", "number", "factor on the column"),
            ("sign", "1, -1", ""),
            ("bits", "whole number", "width of a counter that wraps"),
            (
                "gain_tolerance",
                "share",
                "± (95 %) of the instrument's gain, for `characterize`; of every column but time",
            ),
            ("difference", "time", "over how long it is a difference of positions, or a mean; 0 s: that of an instant"),
        ],
    },
    Table {
        path: "[duty]",
        keys: &[
            ("name", "text", "in the log's header; required"),
            ("unit", "unit", "a pure number unless said"),
            ("scale", "number", "factor on the column"),
            ("sign", "1, -1", ""),
            ("bits", "whole number", "width of a counter that wraps"),
            ("gain_tolerance", "share", "as of `velocity`"),
            (
                "held",
                "true, false",
                "whether a row's value holds until the next row, as a digital drive holds a command. Also of `goal`, `current` \
                 and `force`. Unless said, `duty` and `goal` are held; `current` and `force` are taken for measured, and lie on \
                 a line between rows. A current that was commanded: `held = true`. A duty of a loop much faster than the log: \
                 `held = false`",
            ),
        ],
    },
    Table {
        path: "[load]",
        keys: &[
            ("inertia", "inertia", "at the output"),
            ("mass", "mass", "of what hangs there"),
            ("distance", "length", "of its centre"),
            ("gravity_torque", "torque", "in place of mass and distance"),
        ],
    },
    Table {
        path: "[[log]]",
        keys: &[
            ("file", "file", "CSV beside this file; required"),
            ("use", "`fit`, `held_out`", "`fit` unless said; what is held out has no part in the choice"),
            ("select", "table", "several logs in one file: `column`, `equals`"),
            ("kind", "kind of bench", "of this log"),
            ("columns", "table", "of this log, over the common ones"),
            ("load", "table", "of this log"),
            ("pendulum", "table", "of this log"),
            ("controller", "table", "of this log"),
            ("rotor", "`removed`, `installed`", "of kind `random_torque`: whether the rotor was in"),
        ],
    },
];

/// Tables of a bench file that stand in place of others, or below a log.
pub const BENCH_MORE: &[Table] = &[
    Table {
        path: "[pendulum]",
        keys: &[
            ("mass", "mass", "at the end; required"),
            ("length", "length", "to it; required"),
            ("arm_mass", "mass", "of the arm"),
        ],
    },
    Table {
        path: "[select]",
        keys: &[
            ("column", "text", "in the log's header; required"),
            ("equals", "text, number or list", "rows with one of these cells"),
            ("min", "number", "rows from this value on"),
            ("max", "number", "rows up to this value"),
        ],
    },
];

/// Fitted actuators. Keys of `[motor]` are the columns of a motor catalogue, those of `[effects]` the effects.
pub const FITTED: &[Table] = &[
    Table {
        path: "",
        keys: &[
            ("gearwise", "text", "version that fitted it; required"),
            (
                "motor",
                "table",
                "the columns of a motor catalogue, values with their units; `…_tolerance` too; required but for an axis",
            ),
            ("axis", "table", "of a linear axis, in place of `motor`: it cannot be chosen"),
            ("gear", "table", "numbers of the gear on the bench"),
            ("effects", "table of tables", "what was found, by name; `[[effects.cogging]]` for several orders"),
            ("covariance", "table", "of the fitted numbers"),
            ("provenance", "list of tables", "the logs"),
        ],
    },
    Table {
        path: "[gear]",
        keys: &[
            ("ratio", "number", "on the bench"),
            ("efficiency", "0 to 1", "when the motor drives"),
            ("backdrive_efficiency", "at most 1", "when the load drives"),
            ("inertia", "inertia", "at the input"),
        ],
    },
    Table {
        path: "[covariance]",
        keys: &[
            (
                "names",
                "list of texts",
                "numbers of this file, in order: `motor.resistance`, `effects.eddy_drag.torque`, of an order `effects.cogging.12.cosine`",
            ),
            ("matrix", "list of lists of numbers", "SI; a `…_tolerance` is two square roots of its diagonal"),
        ],
    },
    Table {
        path: "[[provenance]]",
        keys: &[
            ("log", "text", "file name; required"),
            ("sha256", "text", "of the file"),
            ("use", "text", "`fit` or `held_out`"),
        ],
    },
];

/// The table of a fitted linear axis.
pub const FITTED_AXIS: &[Table] = &[Table {
    path: "[axis]",
    keys: &[
        ("id", "text", "its name"),
        ("mass", "mass", "that moves"),
        ("mass_tolerance", "mass", "±"),
        ("viscous_friction", "linear viscous friction", ""),
        ("viscous_friction_tolerance", "linear viscous friction", "±"),
        ("coulomb_friction", "force", ""),
        ("coulomb_friction_tolerance", "force", "±"),
        ("note", "text", "what the reader should know"),
    ],
}];

/// Design files.
pub const DESIGN: &[Table] = &[
    Table {
        path: "",
        keys: &[
            ("requirement", "file", "beside this file; required"),
            ("catalog", "list of paths", "beside this file; the built-in catalogue unless said"),
            ("rules", "file", "rules file for `check`"),
            ("joint", "list of tables", "one for each joint of the requirement"),
        ],
    },
    Table {
        path: "[[joint]]",
        keys: &[
            ("name", "text", "a joint of the requirement; required"),
            ("motor", "id", "of the catalogue; this or `actuator`"),
            ("actuator", "file", "a fitted actuator; this or `motor`"),
            ("ratio", "number", "this or `gear`"),
            ("gear", "id", "of the catalogue; this or `ratio`"),
            ("spring", "table", "a parallel spring: `stiffness`, `rest_angle`"),
            ("load_inertia", "inertia", "about the joint, for the rules"),
        ],
    },
];

/// Rules files.
pub const RULES: &[Table] = &[
    Table {
        path: "",
        keys: &[
            ("rule", "list of tables", "rules that are moved, and rules of your own"),
            ("allow", "list of tables", "findings that are all right"),
        ],
    },
    Table {
        path: "[[rule]]",
        keys: &[
            ("rule", "code or name", "a rule of the [list](rules.md) to be moved; this, or `name` and `measure`"),
            ("name", "text", "of a rule of your own"),
            ("measure", "name", "what a rule of your own bounds; see [measures](rules.md#measures)"),
            ("min", "number or quantity", "least value"),
            ("max", "number or quantity", "largest value"),
            ("severity", "`error`, `warning`, `note`, `off`", "how much it weighs"),
            ("joints", "list of patterns", "at which joints; all unless said"),
            ("reason", "text", "why, for whoever reads it next; required"),
        ],
    },
    Table {
        path: "[[allow]]",
        keys: &[
            ("rule", "code or name", "what may be broken; required"),
            ("joints", "list of patterns", "at which joints; all unless said"),
            ("subject", "text", "only this limit, measure or finding"),
            ("reason", "text", "why it is all right; required"),
        ],
    },
];

/// The page of file formats.
pub fn text() -> String {
    let mut out = format!(
        "{MADE}# File formats\n\nA number with a dimension has its unit: in quotes in TOML (`\"18 N*m\"`, `\"300 rpm\"`), in the header in \
         CSV (`torque [N*m]`; any unit of the kind may stand there). Numbers have a decimal point. Lines that begin with `#` are comments. An \
         unknown key or column is a mistake, reported with its place and the nearest name that exists.\n"
    );
    section(&mut out, "Requirement (TOML)", "For `optimize`, `sweep`, `explain`.", REQUIREMENT);
    out.push_str(&format!(
        "\n### Currents in results\n\n{} JSON, CSV and studies give both: `{}` (phase amplitude, DC of a brushed motor: what a drive is \
         bought by), `{}`, `{}`, `{}`. In tables `I peak [A]` is the phase amplitude.\n",
        currents::Q_AXIS,
        currents::NAMES[0],
        currents::NAMES[1],
        currents::NAMES[2],
        currents::NAMES[3]
    ));
    out.push_str("\n## Motion (CSV)\n\nWhat the joint does, at the output, without the actuator's own rotor; torque × velocity > 0 means that the motor drives. Time increases; the last row repeats the first of a periodic motion. `velocity` or `position` must be there; what is missing comes from a cubic spline. Where no acceleration, torque rate or jerk is given, the spline of torque and that of speed are the motion, and limits hold between the samples too. (Of a position it is the speed's spline through the slopes of the position's: where a move takes four samples or fewer its peaks may be missed. Give more samples there.) Give rates only where they are known better than by a spline.\n\n");
    out.push_str(&columns(&motion::columns(&[]), |name| motion_about(name).into()));
    out.push_str("\n## Motor catalogue (CSV)\n\nOne row for each motor, as its sheet prints it; the row says in which conventions, and the reader converts to the power-invariant q axis. Blank is unknown, not zero. Every numeric column may have a `…_tolerance` beside it, in a unit of the same kind or in `%`.\n\n");
    let motor: Vec<Column> =
        motor_columns().into_iter().filter(|c| !matches!(c.content, Content::Tolerance(_))).collect();
    out.push_str(&columns(&motor, motor_about));
    out.push_str(&conventions());
    out.push_str("\n## Gear catalogue (CSV)\n\nTorques, backlash and stiffness at the output; inertia and speed at the input.\n\n");
    out.push_str(&columns(&gear_columns(), gear_about));
    section(
        &mut out,
        "Fitted actuator (TOML)",
        "Written by `identify --write`; stands wherever a catalogue file may stand.",
        FITTED,
    );
    tables(&mut out, FITTED_AXIS);
    let names: Vec<String> = EFFECTS.iter().map(|e| format!("`{}`", e.name())).collect();
    out.push_str(&format!(
        "\nTables of `[effects]`: {}; their parameters are on the page of [effects](effects.md).\n",
        names.join(", ")
    ));
    section(
        &mut out,
        "Design (TOML)",
        "What was chosen: for `check` and `export`; `optimize --write-design` makes one.",
        DESIGN,
    );
    section(&mut out, "Rules (TOML)", "For `check`; a design names it.", RULES);
    section(&mut out, "Bench (TOML)", "For `identify`.", BENCH);
    tables(&mut out, BENCH_MORE);
    let kinds: Vec<String> = BenchKind::NAMES.iter().map(|(name, _)| format!("`{name}`")).collect();
    out.push_str(&format!(
        "\nKinds of bench: {}. Every column is a table like that of `time`; those with a side take `side = \"motor\"` or `\"output\"`, \
         current and voltage a `convention` as in a catalogue.\n",
        kinds.join(", ")
    ));
    out
}

fn section(out: &mut String, title: &str, about: &str, all: &[Table]) {
    out.push_str(&format!("\n## {title}\n\n{about}\n"));
    tables(out, all);
}

fn tables(out: &mut String, all: &[Table]) {
    for one in all {
        let title = if one.path.is_empty() { "At the top" } else { one.path };
        let title = if one.path.is_empty() { title.to_string() } else { format!("`{title}`") };
        let rows = one.keys.iter().map(|(key, value, about)| vec![code(key), (*value).into(), (*about).into()]);
        out.push_str(&format!("\n{title}\n\n{}", table(&["key", "value", "what it is"], rows)));
    }
}

fn columns(columns: &[Column], about: impl Fn(&str) -> String) -> String {
    let rows = columns.iter().map(|c| {
        let (unit, range) = match c.content {
            Content::Text => ("", "text".to_string()),
            Content::Count => ("", "a whole number from 1 on".into()),
            Content::Tolerance(kind) => (kind.si, "±".into()),
            Content::Quantity(kind, range) => (kind.si, words(range).into()),
        };
        let name = if c.required { format!("**`{}`**", c.name) } else { code(&c.name) };
        vec![name, if unit == "1" { String::new() } else { code(unit) }, range, about(&c.name)]
    });
    format!("{}\nBold columns must be there.\n", table(&["column", "SI unit", "values", "what it is"], rows))
}

fn words(range: Range) -> &'static str {
    match range {
        Range::Any => "any",
        Range::Positive => "above zero",
        Range::NonNegative => "from zero",
        Range::Fraction => "above 0, at most 1",
        Range::AtLeastOne => "from 1",
    }
}

fn motion_about(name: &str) -> &'static str {
    match name {
        "time" => "increasing",
        "torque" => "that the load needs, at the output",
        "velocity" => "at the output",
        "position" => "at the output; a spring needs it",
        "acceleration" => "at the output",
        "torque_rate" => "dτ/dt",
        "jerk" => "dα/dt",
        _ => "",
    }
}

fn choices<T>(names: &[(&'static str, T)]) -> String {
    names.iter().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn motor_about(name: &str) -> String {
    if let Some(field) = FIELDS.iter().find(|f| f.name == name) {
        return plain(field.about);
    }
    match name {
        "id" => "unique; lower-case letters, digits, `-`, `_`, `.`".into(),
        "terminals" => format!("between what resistance and inductance are: {}", choices(Terminals::NAMES)),
        "current" => format!("what ampere means: {}", choices(CurrentConvention::NAMES)),
        "source" => "where the numbers come from".into(),
        "source_kind" => choices(SourceKind::NAMES),
        "manufacturer" => "who makes it".into(),
        "model" => "what its maker calls it".into(),
        "commutation" => format!("{}; brushless unless said", choices(Commutation::NAMES)),
        "winding" => format!("{}; needed where `terminals` is `winding`", choices(Winding::NAMES)),
        "back_emf_convention" => format!("needed with `back_emf_constant`: {}", choices(BackEmfConvention::NAMES)),
        "speed_constant_convention" => {
            format!("needed with `speed_constant`: {}", choices(SpeedConstantConvention::NAMES))
        }
        "note" => "what the reader of the row should know".into(),
        "audit_accept" => "codes of audit findings that the note explains".into(),
        "pole_pairs" => "p".into(),
        _ => String::new(),
    }
}

fn gear_about(name: &str) -> String {
    match name {
        "kind" => choices(GearKind::NAMES),
        "fits" => "motor ids or patterns, separated by blanks or `;`; blank where nothing is said".into(),
        "stages" => "number of stages".into(),
        "ratio" => "reduction, N".into(),
        "efficiency" => "when the motor drives, η; a gear without it cannot be chosen".into(),
        "backdrive_efficiency" => "when the load drives, η_b; 2 − 1/η unless said; at most 1".into(),
        "mass" => "of the gear".into(),
        "inertia" => "at the input, J_g".into(),
        "continuous_torque" => "at the output, for ever".into(),
        "peak_torque" => "at the output, largest".into(),
        "max_input_speed" => "at the input".into(),
        "backlash" => "at the output".into(),
        "stiffness" => "torsional, at the output".into(),
        other => motor_about(other),
    }
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
