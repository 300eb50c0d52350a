//! The row of a motor.

use super::{Column, Field, Holds, Need, Row, find, identity, listed};
use crate::catalog::about::{About, Construction, PeakTorqueOf};
use crate::catalog::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding, word,
};
use crate::catalog::motor::{Identity, Incomplete, Motor};
use crate::catalog::offer::Sold;
use crate::catalog::sheet::{Conventions, FIELDS, OwnConventions, Printed, Sheet, SourceKind};
use crate::input::Stated;

/// A motor's row as it is written: its texts, and its numbers in the conventions that it declares.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorRow {
    /// Unique name.
    pub id: String,
    /// Who makes it.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// Where the numbers come from.
    pub source: String,
    /// Day, month or year of the source, as 2026-11-01; of one without a date the day on which it was read. Empty: not said.
    pub source_date: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// What the reader of the row should know.
    pub note: String,
    /// Audit findings that the note explains, by code.
    pub accepted_findings: Vec<String>,
    /// How it is built, and how the row belongs with others.
    pub about: About,
    /// What its numbers refer to.
    pub conventions: Conventions,
    /// Pole pairs, where the row says them.
    pub pole_pairs: Option<u32>,
    /// The numbers.
    pub sheet: Sheet,
}

impl Default for MotorRow {
    /// A blank row, on the q axis.
    fn default() -> MotorRow {
        MotorRow {
            id: String::new(),
            manufacturer: String::new(),
            model: String::new(),
            source: String::new(),
            source_date: String::new(),
            source_kind: SourceKind::Datasheet,
            note: String::new(),
            accepted_findings: Vec::new(),
            about: About::default(),
            conventions: Conventions {
                commutation: Commutation::Brushless,
                terminals: Terminals::QAxis,
                winding: None,
                current: CurrentConvention::QAxis,
                back_emf: None,
                speed_constant: None,
                own: OwnConventions::default(),
            },
            pole_pairs: None,
            sheet: Sheet::default(),
        }
    }
}

impl MotorRow {
    /// The row of a motor. Pole pairs of a brushed motor are not kept: nothing asks for them.
    pub fn of(motor: &Motor) -> MotorRow {
        let pole_pairs = motor.pole_pairs.filter(|_| motor.conventions.commutation == Commutation::Brushless);
        MotorRow::new(motor.identity(), motor.conventions, motor.sheet.clone(), pole_pairs)
    }

    /// The row of an identity with conventions and numbers.
    pub fn new(identity: Identity, conventions: Conventions, sheet: Sheet, pole_pairs: Option<u32>) -> MotorRow {
        MotorRow {
            id: identity.id,
            manufacturer: identity.manufacturer,
            model: identity.model,
            source: identity.source,
            source_date: identity.source_date,
            source_kind: identity.source_kind,
            note: identity.note,
            accepted_findings: identity.accepted_findings,
            about: identity.about,
            conventions,
            pole_pairs,
            sheet,
        }
    }

    /// The motor.
    ///
    /// # Errors
    /// What is missing for its q-axis equivalent.
    pub fn motor(self) -> Result<Motor, Incomplete> {
        let identity = Identity {
            id: self.id,
            manufacturer: self.manufacturer,
            model: self.model,
            source: self.source,
            source_date: self.source_date,
            source_kind: self.source_kind,
            note: self.note,
            accepted_findings: self.accepted_findings,
            about: self.about,
        };
        Motor::new(identity, self.conventions, self.sheet, self.pole_pairs)
    }
}

/// The convention that a number is given in, by the column that it is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convention {
    /// Of the resistance: `terminals`, where it states none.
    Resistance,
    /// Of the inductance: `terminals`, where it states none.
    Inductance,
    /// Of the torque constant: `current`, where it states none.
    TorqueConstant,
    /// Of the continuous current: `current`, where it states none.
    ContinuousCurrent,
    /// Of the peak current: `current`, where it states none.
    PeakCurrent,
    /// Of the back-EMF constant: `back_emf_convention`, where it states none.
    BackEmf,
    /// Of the speed constant: `speed_constant_convention`, where it states none.
    SpeedConstant,
}

impl Convention {
    /// The words of its conventions.
    pub const fn words(self) -> &'static [&'static str] {
        match self {
            Convention::Resistance | Convention::Inductance => Terminals::WORDS,
            Convention::TorqueConstant | Convention::ContinuousCurrent | Convention::PeakCurrent => {
                CurrentConvention::WORDS
            }
            Convention::BackEmf => BackEmfConvention::WORDS,
            Convention::SpeedConstant => SpeedConstantConvention::WORDS,
        }
    }

    /// What a column states that is not the row's; a convention with a column of its own is written there.
    fn stated(self, own: &OwnConventions) -> Option<&'static str> {
        let terminals = |t: Option<Terminals>| t.map(|t| word(Terminals::NAMES, &t));
        let current = |c: Option<CurrentConvention>| c.map(|c| word(CurrentConvention::NAMES, &c));
        match self {
            Convention::Resistance => terminals(own.resistance),
            Convention::Inductance => terminals(own.inductance),
            Convention::TorqueConstant => current(own.torque_constant),
            Convention::ContinuousCurrent => current(own.continuous_current),
            Convention::PeakCurrent => current(own.peak_current),
            Convention::BackEmf | Convention::SpeedConstant => None,
        }
    }

    /// Lets a column state its own.
    fn state(self, conventions: &mut Conventions, word: &'static str) -> Result<(), (String, String)> {
        let own = &mut conventions.own;
        let current = find(CurrentConvention::NAMES, word);
        let ampere = match self {
            Convention::Resistance => {
                own.resistance = find(Terminals::NAMES, word);
                return Ok(());
            }
            Convention::Inductance => {
                own.inductance = find(Terminals::NAMES, word);
                return Ok(());
            }
            Convention::TorqueConstant => &mut own.torque_constant,
            Convention::ContinuousCurrent => &mut own.continuous_current,
            Convention::PeakCurrent => &mut own.peak_current,
            Convention::BackEmf => {
                return once(&mut conventions.back_emf, BackEmfConvention::NAMES, word, "back_emf_convention");
            }
            Convention::SpeedConstant => {
                let names = SpeedConstantConvention::NAMES;
                return once(&mut conventions.speed_constant, names, word, "speed_constant_convention");
            }
        };
        if conventions.commutation == Commutation::Brushed && current != Some(CurrentConvention::Dc) {
            return Err((format!("a brushed motor has DC amperes, not `{word}`"), "leave the word out".into()));
        }
        *ampere = current;
        Ok(())
    }
}

/// A convention that a number states and that has a column of its own: the two must agree.
fn once<T: Copy + PartialEq>(
    place: &mut Option<T>,
    names: &[(&'static str, T)],
    word: &'static str,
    column: &str,
) -> Result<(), (String, String)> {
    let said = find(names, word);
    match *place {
        Some(other) if Some(other) != said => Err((
            format!(
                "it states `{word}`, but `{column}` of this row says `{}`",
                crate::catalog::convention::word(names, &other)
            ),
            format!("leave `{column}` blank, or let the two agree"),
        )),
        _ => {
            *place = said;
            Ok(())
        }
    }
}

impl Row for MotorRow {
    type Numbers = Sheet;

    const REQUIRED: &'static [&'static str] = &["resistance"];

    const BEFORE: &'static [Column<MotorRow>] = &[
        identity!(id),
        identity!(manufacturer),
        identity!(model),
        Column {
            name: "construction",
            about: "how it is built; what its row lacks is estimated from rows that are built alike",
            need: Need::May,
            holds: Holds::Choice(
                Construction::WORDS,
                |r| r.about.construction.map(|c| word(Construction::NAMES, &c)),
                |r, text| r.about.construction = find(Construction::NAMES, text),
            ),
        },
        Column {
            name: "peak_torque_of",
            about: "what `peak_torque` is the torque of: where it is the motor's own and less than K_T I_peak, its iron saturates; of a module a gear's loss is in it",
            need: Need::May,
            holds: Holds::Choice(
                PeakTorqueOf::WORDS,
                |r| r.about.peak_torque_of.map(|of| word(PeakTorqueOf::NAMES, &of)),
                |r, text| r.about.peak_torque_of = find(PeakTorqueOf::NAMES, text),
            ),
        },
        Column {
            name: "only_inside",
            about: "the module that it is only sold in: it is no free choice then",
            need: Need::May,
            holds: Holds::Text(|r| r.about.only_inside.clone(), |r, text| r.about.only_inside = text),
        },
        Column {
            name: "same_as",
            about: "id of another row of the same motor: the two are one motor, that row counts where both have a value",
            need: Need::May,
            holds: Holds::Text(|r| r.about.same_as.clone(), |r, text| r.about.same_as = text),
        },
        Column {
            name: "commutation",
            about: "how it commutates; brushless by default",
            need: Need::May,
            holds: Holds::Choice(
                Commutation::WORDS,
                |r| Some(word(Commutation::NAMES, &r.conventions.commutation)),
                |r, text| r.conventions.commutation = find(Commutation::NAMES, text).unwrap_or(Commutation::Brushless),
            ),
        },
        Column {
            name: "winding",
            about: "how its windings are connected; needed where `terminals` is `winding`",
            need: Need::May,
            holds: Holds::Choice(
                Winding::WORDS,
                |r| r.conventions.winding.map(|w| word(Winding::NAMES, &w)),
                |r, text| r.conventions.winding = find(Winding::NAMES, text),
            ),
        },
        Column {
            name: "terminals",
            about: "between what resistance and inductance are",
            need: Need::Convention("\"q_axis\""),
            holds: Holds::Choice(
                Terminals::WORDS,
                |r| Some(word(Terminals::NAMES, &r.conventions.terminals)),
                |r, text| r.conventions.terminals = find(Terminals::NAMES, text).unwrap_or(r.conventions.terminals),
            ),
        },
        Column {
            name: "current",
            about: "what ampere means in the torque constant and the currents",
            need: Need::Convention("\"q_axis\""),
            holds: Holds::Choice(
                CurrentConvention::WORDS,
                |r| Some(word(CurrentConvention::NAMES, &r.conventions.current)),
                |r, text| r.conventions.current = find(CurrentConvention::NAMES, text).unwrap_or(r.conventions.current),
            ),
        },
        Column {
            name: "back_emf_convention",
            about: "what `back_emf_constant` is measured between; needed with it",
            need: Need::May,
            holds: Holds::Choice(
                BackEmfConvention::WORDS,
                |r| r.conventions.back_emf.map(|c| word(BackEmfConvention::NAMES, &c)),
                |r, text| r.conventions.back_emf = find(BackEmfConvention::NAMES, text),
            ),
        },
        Column {
            name: "speed_constant_convention",
            about: "what voltage `speed_constant` refers to; needed with it",
            need: Need::May,
            holds: Holds::Choice(
                SpeedConstantConvention::WORDS,
                |r| r.conventions.speed_constant.map(|c| word(SpeedConstantConvention::NAMES, &c)),
                |r, text| r.conventions.speed_constant = find(SpeedConstantConvention::NAMES, text),
            ),
        },
        Column {
            name: "pole_pairs",
            about: "number of pole pairs, p",
            need: Need::May,
            holds: Holds::Count(|r| r.pole_pairs, |r, count| r.pole_pairs = Some(count)),
        },
        identity!(price_currency),
        identity!(price_date),
    ];

    const AFTER: &'static [Column<MotorRow>] = &[
        identity!(source),
        identity!(source_date),
        identity!(source_kind),
        Column {
            name: "audit_accept",
            about: "codes of audit findings that the note explains",
            need: Need::May,
            holds: Holds::Text(|r| r.accepted_findings.join(";"), |r, text| r.accepted_findings = listed(&text)),
        },
        identity!(note),
    ];

    fn fields() -> &'static [Field<Sheet>] {
        FIELDS
    }

    fn numbers(&self) -> &Sheet {
        &self.sheet
    }

    fn numbers_mut(&mut self) -> &mut Sheet {
        &mut self.sheet
    }

    fn source_date(&self) -> &str {
        &self.source_date
    }

    fn take(&mut self, field: &Field, stated: Stated, number: Printed) -> Result<Printed, (String, String)> {
        if let (super::States::Convention(convention), Some(word)) = (field.states, stated.convention) {
            convention.state(&mut self.conventions, word)?;
        }
        Ok(number)
    }

    fn states(&self, field: &Field) -> Stated {
        match field.states {
            super::States::Convention(convention) => {
                Stated { convention: convention.stated(&self.conventions.own), side: None }
            }
            _ => Stated::default(),
        }
    }
}
