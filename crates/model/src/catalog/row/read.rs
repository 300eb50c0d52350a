//! The one reader of rows.

use super::cells::{Cells, Missing};
use super::{Column, Field, Holds, MotorRow, Need, Row};
use crate::catalog::convention::{Commutation, CurrentConvention};
use crate::catalog::gear::{Gear, GearKind, GearRatings};
use crate::catalog::module::Module;
use crate::catalog::module::check;
use crate::catalog::motor::{Incomplete, Motor};
use crate::catalog::offer::{Offer, Sold, wrong_day};
use crate::catalog::sheet::{Printed, SourceKind};
use crate::catalog::wrong::Wrong;
use crate::input::{Problem, key};

/// Name and source, which are asked for first.
const IDENTITY: &[&str] = &["id", "manufacturer", "model", "source", "source_kind", "note", "audit_accept"];

/// Two currents of which the first is the larger one by no more than this factor, on the q axis, may be those of one DC
/// sheet: what heats and what makes torque are converted by different factors, √2 and 3 √2/π.
const BY_CONVERSION: f64 = std::f64::consts::FRAC_PI_3;

/// Puts every column that is there into a row. What may be left out although a row must have it, is in `spared`.
fn read<R: Row>(cells: &dyn Cells, row: &mut R, spared: &[&str]) {
    let columns = || R::BEFORE.iter().chain(R::AFTER);
    let of_identity = |c: &&Column<R>| IDENTITY.contains(&c.name);
    for column in columns().filter(of_identity).chain(columns().filter(|c| !of_identity(c))) {
        read_column(cells, column, row, spared);
    }
    numbers(cells, row, R::fields().iter());
    refuse(cells, row.numbers().offer().wrong());
    refuse(cells, wrong_day("source_date", row.source_date()).into_iter().collect());
}

/// Notes mistakes of a row.
fn refuse(cells: &dyn Cells, wrong: Vec<Wrong>) {
    for Wrong { column, message, label, help } in wrong {
        cells.note(Problem::at(cells.span(column), message, label).help(help));
    }
}

/// Puts numbers that are there into a row.
pub fn numbers<R: Row>(cells: &dyn Cells, row: &mut R, fields: impl Iterator<Item = &'static Field<R::Numbers>>) {
    for field in fields {
        let tolerance = field.tolerance.map(|name| (name, cells.tolerance(key(name, "±"), field.kind)));
        let asked = key(field.name, field.about);
        let Some((value, stated)) = cells.number(asked, field.kind, field.range, field.states.words()) else {
            if let Some((name, _)) = tolerance.filter(|(name, _)| cells.is_given(name) && !cells.is_given(field.name)) {
                let message = format!("`{name}` is given without `{}`", field.name);
                cells.note(Problem::at(cells.span(name), message, "a tolerance of nothing"));
            }
            continue;
        };
        let share = |(t, relative): (f64, bool)| if relative { t * value.abs() } else { t };
        let printed = Printed { value, tolerance: tolerance.and_then(|(_, found)| found).map(share) };
        match row.take(field, stated, printed) {
            Ok(printed) => (field.set)(row.numbers_mut(), printed),
            Err((message, help)) => {
                let message = format!("`{}`: {message}", field.name);
                cells.note(Problem::at(cells.span(field.name), message, "in this column").help(help));
            }
        }
    }
}

fn read_column<R: Row>(cells: &dyn Cells, column: &Column<R>, row: &mut R, spared: &[&str]) {
    let (name, asked) = (column.name, key(column.name, column.about));
    if !cells.is_given(name) {
        let words = if let Holds::Choice(words, ..) = column.holds { words } else { &[] };
        if column.need != Need::May && !spared.contains(&name) {
            cells.blank(name, column.need, words);
        }
        return;
    }
    match column.holds {
        Holds::Text(_, set) => {
            if let Some(text) = cells.text(asked) {
                if text.is_empty() && column.need != Need::May {
                    cells.blank(name, column.need, &[]);
                }
                set(row, text);
            }
        }
        Holds::Choice(words, _, set) => {
            if let Some(word) = cells.choice(asked, words) {
                set(row, word);
            }
        }
        Holds::Count(_, set) => {
            if let Some(count) = cells.count(asked) {
                set(row, count);
            }
        }
        Holds::Pairs(kinds, _, set) => {
            if let Some(pairs) = cells.pairs(asked, kinds) {
                set(row, pairs);
            }
        }
    }
}

/// Whether a text is an id; what is wrong is noted.
fn check_id(cells: &dyn Cells, id: &str) {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.' | '_');
    if !id.chars().all(good) {
        cells.note(
            Problem::at(
                cells.span("id"),
                "an id has lower-case letters, digits, `-`, `_` and `.` only",
                "other characters here",
            )
            .help(format!("for example `{}`", id.to_lowercase().replace(|c| !good(c), "-"))),
        );
    }
}

/// Reads the row of a motor into `blank`, which has what is there by default; columns of `spared` may be missing.
pub fn motor(cells: &dyn Cells, blank: MotorRow, spared: &[&str]) -> Option<Motor> {
    let before = cells.noted();
    let mut row = blank;
    read(cells, &mut row, spared);
    check_id(cells, &row.id);
    let other = |text: &String| text != "dc" && CurrentConvention::WORDS.contains(&text.as_str());
    if row.conventions.commutation == Commutation::Brushed && cells.text("current".into()).as_ref().is_some_and(other) {
        cells.note(Problem::at(cells.span("current"), "a brushed motor has DC amperes", "expected `dc`"));
    }
    if swapped_currents(&row) {
        cells.note(Problem::at(
            cells.span("peak_current"),
            "`peak_current` is less than `continuous_current`",
            "the two may be swapped",
        ));
    }
    let clean = cells.noted() == before;
    match row.motor() {
        Ok(motor) => clean.then_some(motor),
        Err(incomplete) => {
            cells.incomplete(missing(incomplete), clean);
            None
        }
    }
}

/// Whether the continuous current is more than the peak current.
fn swapped_currents(row: &MotorRow) -> bool {
    let (Some(continuous), Some(peak)) = (row.sheet.continuous_current, row.sheet.peak_current) else { return false };
    let conventions = &row.conventions;
    let (own, other) = (conventions.of_continuous_current(), conventions.of_peak_current());
    if own == CurrentConvention::QAxis && other == own {
        return continuous.value > peak.value * BY_CONVERSION;
    }
    let torque = |c: CurrentConvention| if own == other { 1.0 } else { c.torque_current(conventions.commutation) };
    continuous.value * torque(own) > peak.value * torque(other)
}

fn missing(incomplete: Incomplete) -> Missing {
    match incomplete {
        Incomplete::Resistance => Missing {
            column: "resistance",
            at: "resistance",
            message: "`resistance` is blank",
            help: "without a resistance nothing can be said of a motor; leave the row out",
            example: "\"0.7 ohm\"",
        },
        Incomplete::TorqueConstant => Missing {
            column: "torque_constant",
            at: "torque_constant",
            message: "no torque constant, and nothing to derive it from",
            help: "give torque_constant, back_emf_constant or speed_constant",
            example: "\"0.1 N*m/A\"",
        },
        Incomplete::Winding => Missing {
            column: "winding",
            at: "terminals",
            message: "`terminals` is `winding`, but `winding` does not say wye or delta",
            help: "give winding as wye or delta",
            example: "\"wye\"  # or \"delta\"",
        },
        Incomplete::BackEmfConvention => Missing {
            column: "back_emf_convention",
            at: "back_emf_constant",
            message: "`back_emf_constant` is given without `back_emf_convention`",
            help: "one of q_axis, line_to_line_peak, line_to_line_rms, phase_peak, phase_rms, dc",
            example: "\"q_axis\"",
        },
        Incomplete::SpeedConstantConvention => Missing {
            column: "speed_constant_convention",
            at: "speed_constant",
            message: "`speed_constant` is given without `speed_constant_convention`",
            help: "line_to_line_peak (outrunners) or dc (maxon, FAULHABER, brushed)",
            example: "\"line_to_line_peak\"",
        },
    }
}

/// Reads the row of a gear.
pub fn gear(cells: &dyn Cells) -> Option<Gear> {
    let before = cells.noted();
    let mut gear = Gear::blank();
    read(cells, &mut gear, &[]);
    check_id(cells, &gear.id);
    if !cells.is_given("ratio") {
        cells.blank("ratio", Need::Must("9"), &[]);
    }
    check_gear(cells, &gear);
    (cells.noted() == before).then_some(gear)
}

/// Reads a point of a family of gears into `blank`, which has what the family says for all: the columns in `of_family`.
pub fn point(cells: &dyn Cells, blank: Gear, of_family: &[&str]) -> Option<Gear> {
    let before = cells.noted();
    let mut gear = blank;
    read(cells, &mut gear, of_family);
    if !cells.is_given("ratio") {
        cells.blank("ratio", Need::Must("9"), &[]);
    }
    check_gear(cells, &gear);
    (cells.noted() == before).then_some(gear)
}

/// Reads the row of a module.
pub fn module(cells: &dyn Cells) -> Option<Module> {
    let before = cells.noted();
    let mut module = Module::default();
    read(cells, &mut module, &[]);
    check_id(cells, &module.id);
    if !cells.is_given("ratio") {
        cells.blank("ratio", Need::Must("9"), &[]);
    }
    refuse(cells, check::wrong(&module));
    (cells.noted() == before).then_some(module)
}

/// What must hold between the numbers of a gear.
pub(crate) fn check_gear(cells: &dyn Cells, gear: &Gear) {
    if gear.backdrive_efficiency.is_some_and(|b| b > 1.0) {
        cells.note(Problem::at(
            cells.span("backdrive_efficiency"),
            "`backdrive_efficiency` is out of range",
            "expected at most 1",
        ));
    }
    if let (Some(continuous), Some(peak)) = (gear.continuous_torque, gear.peak_torque)
        && continuous > peak
    {
        cells.note(Problem::at(
            cells.span("peak_torque"),
            "`peak_torque` is less than `continuous_torque`",
            "the two may be swapped",
        ));
    }
    if let Some((column, message, label, help)) = contradiction(gear) {
        cells.note(Problem::at(cells.span(column), message, label).help(help));
    }
}

/// What does not go together in what a gear says of its loss: the column, the message, what to see there and what to do.
fn contradiction(gear: &Gear) -> Option<(&'static str, String, &'static str, &'static str)> {
    if gear.no_load_torque.is_none() && gear.no_load_torque_speed.is_some() {
        let message = "`no_load_torque_speed` is given without `no_load_torque`";
        return Some(("no_load_torque_speed", message.into(), "the speed of nothing", "give both, or neither"));
    }
    if gear.starting_torque.is_some() && gear.no_load_torque.is_some() && gear.no_load_torque_speed.is_none() {
        let message = "`no_load_torque` and `starting_torque` together need `no_load_torque_speed`";
        let help = "what the one is more than the other grows with speed: say at which speed it was measured";
        return Some(("no_load_torque", message.into(), "at which speed?", help));
    }
    gear.efficiency?;
    let Some(torque) = gear.efficiency_torque else {
        gear.no_load_torque?;
        let message = "`efficiency` and `no_load_torque` count the same loss twice without `efficiency_torque`";
        let help = "say at which output torque (and speed) the efficiency holds, or leave one of the two out";
        return Some(("efficiency", message.into(), "at which torque?", help));
    };
    if gear.printed_friction().viscous > 0.0 && gear.efficiency_speed.is_none() {
        let message = "`efficiency_torque` needs `efficiency_speed` where the torque without load grows with speed";
        return Some(("efficiency_torque", message.into(), "at which speed?", "give both"));
    }
    let (efficiency, lost) = (gear.efficiency?, gear.ratio * gear.running_torque_at_efficiency() / torque);
    if 1.0 / efficiency - lost >= 1.0 - ROUNDING {
        return None;
    }
    let message = format!(
        "`efficiency` leaves no room for the torque without load: that alone takes {} of the load, and all that is lost is {} of it",
        crate::words::number(lost),
        crate::words::number(1.0 / efficiency - 1.0),
    );
    let help = "look at the sides and speeds: `starting_torque` and `no_load_torque` are at the input, `efficiency_torque` at the output";
    Some(("efficiency", message, "less than what is lost without load", help))
}

/// What rounding may leave of a difference of two shares.
const ROUNDING: f64 = 1e-9;

impl Gear {
    /// A row in which nothing stands yet.
    pub(crate) fn blank() -> Gear {
        Gear {
            id: String::new(),
            manufacturer: String::new(),
            model: String::new(),
            family: String::new(),
            motor_length: None,
            kind: GearKind::Direct,
            ratio: f64::NAN,
            stages: None,
            efficiency: None,
            backdrive_efficiency: None,
            mass: None,
            outer_diameter: None,
            length: None,
            width: None,
            height: None,
            inertia: None,
            continuous_torque: None,
            peak_torque: None,
            max_input_speed: None,
            backlash: None,
            stiffness: None,
            starting_torque: None,
            no_load_torque: None,
            no_load_torque_speed: None,
            backdriving_torque: None,
            efficiency_torque: None,
            efficiency_speed: None,
            ratings: GearRatings::default(),
            fits: Vec::new(),
            offer: Offer::default(),
            source: String::new(),
            source_date: String::new(),
            source_kind: SourceKind::Datasheet,
            note: String::new(),
        }
    }
}
