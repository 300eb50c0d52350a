//! One row as a card: its numbers in every convention, what it lacks and what that prevents, where it comes from.

use super::lacks::{LACKS, Lack};
use super::{shown, unit_for};
use crate::audit::word as severity;
use crate::number;
use crate::table::{Column, Table, paragraph};
use gearwise_model::actuator::estimate::{ASSUMED_WINDING_TEMPERATURE, builtin_laws, completed};
use gearwise_model::catalog::audit::{Finding, audit_motor, conventions_line};
use gearwise_model::catalog::convention::{Commutation, Winding, word};
use gearwise_model::catalog::estimate::Estimate;
use gearwise_model::catalog::row::{Convention, Field, Row, States};
use gearwise_model::catalog::{
    Alternative, Catalog, Construction, ContinuousTorque, FIELDS, GEAR_FIELDS, Gear, GearKind, LifeQuantile, Motor,
    Offer, PeakTorqueOf, Price, SourceKind,
};
use gearwise_model::units::in_unit;
use gearwise_model::words::with_unit;

/// How heat of a motor can be judged.
#[derive(Debug, Clone, PartialEq)]
pub enum Heat {
    /// By what its row says.
    Said(Vec<&'static str>),
    /// By an estimate.
    Estimated,
    /// Not at all.
    Unknown,
}

impl Heat {
    /// Its word in JSON.
    pub fn word(&self) -> &'static str {
        match self {
            Heat::Said(_) => "known",
            Heat::Estimated => "estimated",
            Heat::Unknown => "unknown",
        }
    }
}

/// A number in one of its conventions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Said {
    /// The column.
    pub column: &'static str,
    /// The convention.
    pub convention: &'static str,
    /// The windings that it is for, where the row does not say how they are connected.
    pub winding: Option<Winding>,
    /// The number, SI.
    pub value: f64,
    /// Its SI unit.
    pub unit: &'static str,
    /// Whether the row gives it so.
    pub printed: bool,
}

/// What is said of a motor.
#[derive(Debug)]
pub struct Card<'c> {
    /// The row.
    pub motor: &'c Motor,
    /// What it lacks, with what fills it.
    pub lacks: Vec<(&'static Lack, Option<Estimate>)>,
    /// Ids of other rows of the same motor.
    pub twins: Vec<&'c str>,
    /// How heat can be judged.
    pub heat: Heat,
    /// What the audit finds.
    pub findings: Vec<Finding>,
}

impl<'c> Card<'c> {
    /// The card of a motor of a catalogue whose rows stand as they were read.
    pub fn new(catalog: &'c Catalog, motor: &'c Motor) -> Card<'c> {
        let of = |lack: &'static Lack| (lack.is_lacking)(motor).then(|| (lack, lack.filled(motor)));
        let same = motor.about.same_as.as_str();
        let is_twin = |other: &&Motor| {
            let theirs = other.about.same_as.as_str();
            other.id != motor.id && (other.id == same || theirs == motor.id || !same.is_empty() && theirs == same)
        };
        let said = [
            (motor.continuous_current.is_some(), "continuous current"),
            (motor.continuous_torque.is_some(), "continuous torque"),
            (motor.thermal_resistance.is_some(), "thermal resistances"),
        ];
        let said: Vec<&'static str> = said.iter().filter(|(is, _)| *is).map(|(_, what)| *what).collect();
        let heat = match said.is_empty() {
            false => Heat::Said(said),
            true if completed(motor.clone()).thermal_resistance.is_some() => Heat::Estimated,
            true => Heat::Unknown,
        };
        Card {
            motor,
            lacks: LACKS.iter().filter_map(of).collect(),
            twins: catalog.motors.iter().filter(is_twin).map(|m| m.id.as_str()).collect(),
            heat,
            findings: audit_motor(motor),
        }
    }

    /// Its numbers that have a convention, in every one that they have; the same word once. Of a brushed motor there is one.
    pub fn in_conventions(&self) -> Vec<Said> {
        let motor = self.motor;
        let brushed = motor.conventions.commutation == Commutation::Brushed;
        let mut found = Vec::new();
        for field in FIELDS {
            let States::Convention(of) = field.states else { continue };
            let printed = (field.get)(&motor.sheet).map(|_| printed_as(motor, field, of));
            for convention in of.words() {
                // Of a brushed motor all are the same number.
                if brushed && *convention != if of.words().contains(&"dc") { "dc" } else { "line_to_line" } {
                    continue;
                }
                let windings: &[Option<Winding>] = match (*convention, motor.conventions.winding) {
                    ("winding", None) => &[Some(Winding::Wye), Some(Winding::Delta)],
                    (_, _) => &[None],
                };
                for winding in windings {
                    let as_if = winding.or(motor.conventions.winding);
                    let Some(value) = motor.in_convention_with(of, convention, as_if) else { continue };
                    let printed = printed == Some(convention) || brushed && printed.is_some();
                    let (column, unit) = (field.name, field.kind.si);
                    found.push(Said { column, convention, winding: *winding, value, unit, printed });
                }
            }
        }
        found
    }
}

/// The convention that a row gives a number in.
fn printed_as(motor: &Motor, field: &Field, of: Convention) -> &'static str {
    use gearwise_model::catalog::convention::{
        BackEmfConvention, CurrentConvention, SpeedConstantConvention, Terminals,
    };
    let c = &motor.conventions;
    let own = gearwise_model::catalog::row::MotorRow::of(motor).states(field).convention;
    own.unwrap_or_else(|| match of {
        Convention::Resistance | Convention::Inductance => word(Terminals::NAMES, &c.terminals),
        Convention::TorqueConstant | Convention::ContinuousCurrent | Convention::PeakCurrent => {
            word(CurrentConvention::NAMES, &c.current)
        }
        Convention::BackEmf => c.back_emf.map_or("", |b| word(BackEmfConvention::NAMES, &b)),
        Convention::SpeedConstant => c.speed_constant.map_or("", |s| word(SpeedConstantConvention::NAMES, &s)),
    })
}

/// An estimate in words, behind the name of what it is of.
pub fn estimate_line(estimate: &Estimate) -> String {
    format!("{}: {}", estimate.of.name().replace('_', " "), estimated(estimate))
}

/// An estimate in words: its value, its law, its pessimistic end.
pub fn estimated(estimate: &Estimate) -> String {
    let law = builtin_laws().iter().find(|l| l.of == estimate.of && l.construction == estimate.construction);
    let by = law.map_or_else(String::new, |law| format!(" by {}", law.formula()));
    let shown = |value: f64| {
        let (value, unit) = gearwise_model::words::handy::handy(value, estimate.of.unit());
        with_unit(value, unit)
    };
    format!(
        "estimated: {} (pessimistic end of 90 %; middle {}){by}, from {} {}",
        shown(estimate.value),
        shown(estimate.middle),
        estimate.rows,
        match (law, word(Construction::NAMES, &estimate.construction)) {
            (Some(law), own) if law.of_others => format!("rows that are not {own}: too few {own} rows say it"),
            (_, own) => format!("{own} rows"),
        }
    )
}

pub(super) fn titled(out: &mut String, title: &str) {
    out.push('\n');
    out.push_str(&paragraph(title, 0, 2));
}

/// Price and lead time of a row.
pub(super) fn price_line(out: &mut String, offer: &Offer) {
    if let Some(price) = offer.price() {
        line(out, "price", &priced(&price));
    }
    if let Some(time) = offer.lead_time {
        line(out, "lead time", &with_unit(in_unit(time, "d"), "d"));
    }
}

/// A price with its currency, its day, and how many have to be bought for it.
pub(crate) fn priced(price: &Price) -> String {
    let Price { value, currency, date, quantity } = price;
    let each = if *quantity > 1.0 { format!(" each of {}", number(*quantity)) } else { String::new() };
    format!("{} {currency}{each}, {date}", number(*value))
}

/// A label and a text.
pub(super) fn line(out: &mut String, label: &str, text: &str) {
    if !text.is_empty() {
        out.push_str(&paragraph(&format!("{label}: {text}"), 0, 4));
    }
}

/// The card of a motor, for people.
pub fn motor_text(card: &Card) -> String {
    let motor = card.motor;
    let about = &motor.about;
    let mut out = paragraph(&motor.id, 0, 2);
    let built = about.construction.map_or("construction not said", |c| word(Construction::NAMES, &c));
    let commutation = word(Commutation::NAMES, &motor.conventions.commutation);
    let name = [motor.manufacturer.as_str(), motor.model.as_str()].join(" ");
    line(&mut out, "motor", &format!("{}; {built}, {commutation}", name.trim()));
    line(&mut out, "source", &sourced(&motor.source, &motor.source_date, motor.source_kind));
    line(&mut out, "note", &motor.note);
    price_line(&mut out, &motor.sheet.offer);
    line(
        &mut out,
        "peak torque",
        match (about.peak_torque_of, motor.saturation_current().is_some()) {
            (Some(PeakTorqueOf::Motor), true) => {
                "of the motor by itself: less than K_T I_peak, so that its iron saturates"
            }
            (Some(PeakTorqueOf::Motor), false) => "of the motor by itself",
            (Some(PeakTorqueOf::Module), _) => "of a module, with the loss of its gear",
            (None, _) => "",
        },
    );
    if !about.only_inside.is_empty() {
        line(
            &mut out,
            "only inside",
            &format!("{}; it is no free choice (`--also-inside-modules`)", about.only_inside),
        );
    }
    if !card.twins.is_empty() {
        let counts = if about.same_as.is_empty() { "this row" } else { about.same_as.as_str() };
        let text = format!(
            "{}; {counts} counts where both have a value, the other fills what it lacks",
            card.twins.join(", ")
        );
        line(&mut out, "the same motor", &text);
    }
    titled(&mut out, &format!("In every convention (the row: {})", conventions_line(motor)));
    out.push_str(&conventions(card).text());
    let rows = FIELDS.iter().filter(|f| matches!(f.states, States::Nothing) && !PRICED.contains(&f.name)).filter_map(
        |field| {
            let printed = (field.get)(&motor.sheet)?;
            Some(number_row(field, printed.value, printed.tolerance))
        },
    );
    let pairs =
        motor.pole_pairs.filter(|p| *p > 0).map(|p| vec!["pole_pairs".to_string(), p.to_string(), String::new()]);
    let rows: Vec<Vec<String>> = pairs.into_iter().chain(rows).collect();
    if !rows.is_empty() {
        titled(&mut out, "Other numbers, as in the row");
        out.push_str(&numbers_table().rows(rows).text());
    }
    titled(&mut out, "What is not known");
    for (lack, estimate) in &card.lacks {
        let what = estimate.as_ref().map_or_else(|| lack.prevents.to_string(), estimated);
        out.push_str(&paragraph(&format!("{}: {what}", lack.name), 2, 6));
    }
    let heat = match &card.heat {
        Heat::Said(by) => format!("Heat is judged by the row's {}.", by.join(", ")),
        Heat::Estimated => "Heat is judged by the estimate; `--no-estimates` leaves it unknown.".into(),
        Heat::Unknown => "Heat cannot be judged: nothing in the row says it, and no law estimates it.".into(),
    };
    if card.lacks.is_empty() {
        out.push_str(&paragraph("nothing that a limit asks for", 2, 6));
    }
    out.push_str(&paragraph(&heat, 2, 6));
    if motor.max_winding_temperature.is_none() && card.heat != Heat::Unknown {
        let assumed = number(in_unit(ASSUMED_WINDING_TEMPERATURE, "degC"));
        let text = format!("Highest winding temperature: {assumed} degC is assumed, unless a requirement states one.");
        out.push_str(&paragraph(&text, 2, 6));
    }
    for assumed in motor.assumptions.iter() {
        out.push_str(&paragraph(&format!("Assumed: {assumed}."), 2, 6));
    }
    audit_text(&mut out, &card.findings);
    out
}

/// What the audit finds in a row.
pub(super) fn audit_text(out: &mut String, findings: &[Finding]) {
    titled(out, "Audit");
    if findings.is_empty() {
        out.push_str(&paragraph("nothing is found", 2, 6));
    }
    for finding in findings {
        let text = format!("{} [{}] {}", severity(finding), finding.code, finding.message);
        out.push_str(&paragraph(&text, 2, 6));
        if let Some(why) = &finding.explanation {
            out.push_str(&paragraph(&format!("→ {why}"), 6, 8));
        }
    }
}

/// What other sources say of the numbers of a row, with their sources; nothing where there are none.
pub fn elsewhere_text(alternatives: &[&Alternative]) -> String {
    let mut out = String::new();
    if alternatives.is_empty() {
        return out;
    }
    titled(&mut out, "What other sources say (not computed with)");
    for a in alternatives {
        let from = sourced(&a.source, &a.source_date, a.source_kind);
        out.push_str(&paragraph(&format!("{}: {}; {from}", a.column, a.said()), 2, 6));
        if !a.note.is_empty() {
            out.push_str(&paragraph(&a.note, 6, 6));
        }
    }
    out
}

/// Columns that the lines of price and lead time say.
pub(super) const PRICED: &[&str] = &["price", "price_quantity", "lead_time"];

pub(crate) fn sourced(source: &str, date: &str, kind: SourceKind) -> String {
    let from = [source, date].join(", ");
    format!("{} ({})", from.trim_end_matches(", "), word(SourceKind::NAMES, &kind))
}

pub(super) fn numbers_table() -> Table {
    Table::new(vec![Column::name("column"), Column::number("value", ""), Column::number("±", "")]).indented(2)
}

pub(super) fn number_row<S>(field: &Field<S>, value: f64, tolerance: Option<f64>) -> Vec<String> {
    let unit = unit_for(field.kind, value);
    // A difference of temperatures has no offset.
    let scaled = |t: f64| if unit == "degC" { t } else { in_unit(t, unit) };
    let tolerance = tolerance.map(|t| with_unit(scaled(t), unit)).unwrap_or_default();
    vec![field.name.to_string(), shown(field.kind, value), tolerance]
}

/// One row for each number and convention.
fn conventions(card: &Card) -> Table {
    let columns =
        vec![Column::name("column"), Column::name("convention"), Column::number("value", ""), Column::name("printed")];
    let mut last = "";
    let all = card.in_conventions();
    let rows = all.iter().map(|said| {
        let kind = FIELDS.iter().find(|f| f.name == said.column).map(|f| f.kind);
        let value = kind.map_or_else(|| with_unit(said.value, said.unit), |kind| shown(kind, said.value));
        let winding = said.winding.map_or_else(String::new, |w| format!(" if {}", word(Winding::NAMES, &w)));
        let column = if said.column == last { String::new() } else { said.column.to_string() };
        last = said.column;
        let printed = if said.printed { "yes" } else { "" };
        vec![column, format!("{}{winding}", said.convention), value, printed.to_string()]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    Table::new(columns).indented(2).rows(rows)
}

/// What a gear lacks and what that prevents.
pub fn gear_lacks(gear: &Gear) -> Vec<(&'static str, &'static str)> {
    let rated = gear.ratings.rated(gear.continuous_torque);
    let skips = gear.kind == GearKind::StrainWave;
    let starts = gear.friction_at_rest().is_some() || gear.backdriving_torque.is_some();
    let all = [
        (gear.efficiency.is_none(), "efficiency", "the gear cannot be chosen"),
        (gear.mass.is_none(), "mass", "a limit on mass cannot be judged"),
        (gear.across().is_none(), "outer_diameter", "a limit on the diameter cannot be judged"),
        (gear.length.is_none(), "length", "a limit on the axial length cannot be judged"),
        (gear.inertia.is_none(), "inertia", "it is left out; a limit on reflected inertia cannot be judged"),
        (gear.peak_torque.is_none(), "peak_torque", "its largest torque is not checked"),
        (gear.continuous_torque.is_none(), "continuous_torque", "its continuous torque is not checked"),
        (gear.max_input_speed.is_none(), "max_input_speed", "its input speed is not checked"),
        (rated.is_err(), "rated_life, rated_speed, life_quantile, continuous_torque_is", "a `life` cannot be judged"),
        (gear.ratings.momentary_peak_torque.is_none(), "momentary_peak_torque", "a `shock_torque` cannot be judged"),
        (skips && gear.ratings.ratcheting_torque.is_none(), "ratcheting_torque", "a `shock_torque` cannot be judged"),
        (gear.backlash.is_none(), "backlash", "a `max_backlash` cannot be judged"),
        (gear.stiffness.is_none(), "stiffness", "a `min_stiffness` cannot be judged"),
        (!starts, "starting_torque or backdriving_torque", "a `max_backdriving_torque` cannot be judged"),
        (gear.offer.price.is_none(), "price (with price_currency and price_date)", "a limit on it cannot be judged"),
        (gear.offer.lead_time.is_none(), "lead_time", "a limit on it cannot be judged"),
        (gear.fits.is_empty(), "fits", "whether it can be mounted on a motor is not known"),
    ];
    all.into_iter().filter(|(is, ..)| *is).map(|(_, column, why)| (column, why)).collect()
}

/// The card of a gear, for people.
pub fn gear_text(gear: &Gear) -> String {
    let mut out = paragraph(&gear.id, 0, 2);
    let stages = gear.stages.map_or_else(String::new, |s| format!(", {}", crate::counted(s as usize, "stage")));
    let name = [gear.manufacturer.as_str(), gear.model.as_str()].join(" ");
    line(&mut out, "gear", &format!("{}; {}{stages}", name.trim(), word(GearKind::NAMES, &gear.kind)));
    line(&mut out, "source", &sourced(&gear.source, &gear.source_date, gear.source_kind));
    line(&mut out, "fits", &gear.fits.join(", "));
    line(&mut out, "note", &gear.note);
    price_line(&mut out, &gear.offer);
    titled(
        &mut out,
        "Numbers (torques, backlash and stiffness at the output; inertia, speed and torque without load at the input)",
    );
    let rows = GEAR_FIELDS.iter().filter(|f| !PRICED.contains(&f.name)).filter_map(|field| {
        let printed = (field.get)(gear.numbers())?;
        Some(number_row(field, printed.value, printed.tolerance))
    });
    out.push_str(&numbers_table().rows(rows).text());
    if let Some(quantile) = gear.ratings.life_quantile {
        line(&mut out, "rated_life is", word(LifeQuantile::NAMES, &quantile));
    }
    if let Some(is) = gear.ratings.continuous_torque_is {
        line(&mut out, "continuous_torque is that of", word(ContinuousTorque::NAMES, &is));
    }
    titled(&mut out, "What is not known");
    let lacks = gear_lacks(gear);
    for (column, why) in &lacks {
        out.push_str(&paragraph(&format!("{column}: {why}"), 2, 6));
    }
    if lacks.is_empty() {
        out.push_str(&paragraph("nothing that a limit asks for", 2, 6));
    }
    out
}
