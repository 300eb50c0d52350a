//! What another number of turns would do, in words: with how many, and which constant to ask the maker for.

use super::number;
use super::reason::reason_text;
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::rewound::NoTurns;
use gearwise_model::requirement::Joint;
use gearwise_model::units;
use gearwise_model::words::{number_between, range_inwards};
use gearwise_select::answer::{Reason, RobotResult};
use gearwise_select::outlook::Outlook;
use gearwise_select::turns::{OtherTurns, Rewinding, TurnsRange};

/// What a motor's turns are told by: a constant of its row, as its sheet prints it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// Its symbol.
    pub symbol: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What the row says, in that unit.
    pub value: f64,
    /// The power of the turns that it goes with.
    power: i32,
}

impl Constant {
    /// Of a motor: Kv where its row has it, else the torque constant, else the back-EMF constant.
    pub fn of(motor: &Motor) -> Option<Constant> {
        let sheet = &motor.sheet;
        let rpm = std::f64::consts::TAU / 60.0;
        let kv =
            sheet.speed_constant.map(|k| Constant { symbol: "Kv", unit: "rpm/V", value: k.value / rpm, power: -1 });
        let torque = || sheet.torque_constant.map(|k| (k.value, "K_T", units::TORQUE_CONSTANT.si));
        let emf = || sheet.back_emf_constant.map(|k| (k.value, "K_B", units::BACK_EMF_CONSTANT.si));
        kv.or_else(|| torque().or_else(emf).map(|(value, symbol, unit)| Constant { symbol, unit, value, power: 1 }))
    }

    /// The least and the most of it that some numbers of turns give; `None` where it has no such end.
    pub fn range(&self, turns: &TurnsRange) -> [Option<f64>; 2] {
        let at = |turns: f64| (turns > 0.0 && turns.is_finite()).then(|| self.value * turns.powi(self.power));
        match self.power {
            1 => [at(turns.min), at(turns.max)],
            _ => [at(turns.max), at(turns.min)],
        }
    }

    /// What to ask for.
    fn text(&self, turns: &TurnsRange) -> String {
        let Constant { symbol, unit, .. } = self;
        match self.range(turns) {
            [Some(low), Some(high)] => {
                let [from, to] = range_inwards(low, high);
                format!("{symbol} of {from} to {to} {unit}")
            }
            [Some(low), None] => format!("{symbol} of {} {unit} or more", number_between(low, low, f64::INFINITY)),
            [None, Some(high)] => format!("{symbol} of at most {} {unit}", number_between(high, 0.0, high)),
            [None, None] => format!("any {symbol}"),
        }
    }
}

/// Numbers of turns, and the constant to ask for.
pub(super) fn range_text(turns: &TurnsRange, motor: &Motor) -> String {
    let how_many = match (turns.min > 0.0, turns.max.is_finite()) {
        (true, true) => {
            let [from, to] = range_inwards(turns.min, turns.max);
            format!("{from} to {to} times its turns")
        }
        (false, true) => format!("up to {} times its turns", number_between(turns.max, 0.0, turns.max)),
        (true, false) => format!("{} times its turns or more", number_between(turns.min, turns.min, f64::INFINITY)),
        (false, false) => "any number of turns".into(),
    };
    let ask = Constant::of(motor).map_or_else(String::new, |constant| format!(" ({})", constant.text(turns)));
    format!("{how_many}{ask}")
}

/// What numbers of turns keep voltage and the drive's current at a ratio; nothing where those of the row do.
pub(super) fn here(turns: &TurnsRange, motor: &Motor) -> Option<String> {
    let names = || [turns.min_by, turns.max_by].into_iter().flatten().collect::<Vec<_>>().join(" and ");
    match (turns.holds(1.0), turns.is_possible()) {
        (true, _) => None,
        (false, true) => Some(format!("At this ratio {} would be kept with {}.", names(), range_text(turns, motor))),
        (false, false) => Some(format!("At this ratio no number of turns keeps both {}.", names())),
    }
}

/// What the best with another number of turns is.
fn found(other: &OtherTurns, motor: &Motor) -> String {
    let gear = other.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
    let ratio = if other.gear.is_some() { other.ratio.to_string() } else { number(other.ratio) };
    let sure = if other.proved { "" } else { ", as far as was looked" };
    let rows = match other.rows.as_slice() {
        [] => String::new(),
        rows => {
            let ids: Vec<&str> = rows.iter().map(|row| row.id.as_str()).collect();
            format!("; of the catalogue: {}", ids.join(", "))
        }
    };
    let unchecked = match other.unchecked.as_slice() {
        [] => String::new(),
        some => format!("; not checked: {}", super::unjudged::names(some).replace(' ', ", ")),
    };
    let (turns, loss) = (range_text(&other.turns, motor), number(other.loss));
    format!("{turns} at N = {ratio}{gear}, the best ratio: a loss of {loss} W{sure}{unchecked}{rows}")
}

/// What another number of turns would do for a motor; `refusal` is why it cannot do it as it is wound.
pub(super) fn refused(rewinding: &Rewinding, refusal: Option<&Reason>, motor: &Motor, joint: &Joint) -> String {
    match rewinding {
        Rewinding::Found(other) => format!("possible with {}", found(other, motor)),
        Rewinding::Useless(reason) if Some(reason) == refusal => "no number of turns helps".into(),
        Rewinding::Useless(reason) => format!("no number of turns helps: {}", reason_text(reason, joint).1),
        Rewinding::Unjudged(because) => {
            format!("with other turns it {}", super::unjudged::sentence(because))
        }
        Rewinding::NoneFound => "no number of turns helps, as far as was looked (not proved)".into(),
        Rewinding::NotAsked(why @ (NoTurns::DriveResistance | NoTurns::SupplyResistance | NoTurns::FieldWeakening)) => {
            why.reason().into()
        }
        Rewinding::NotAsked(why) => format!("it has no other number of turns: {}", why.reason()),
    }
}

/// What another number of turns would do for the first choice, whose ratio voltage or the drive's current holds back; empty
/// where it would not do better.
pub(super) fn first(rewinding: &Rewinding, motor: &Motor, objective: f64) -> Option<String> {
    match rewinding {
        Rewinding::Found(other) if other.objective.is_some_and(|o| o < objective) && !other.turns.holds(1.0) => {
            Some(format!(
                "its winding holds it back: better with {}; ask the maker, as R of another winding differs by some 10 % from this",
                found(other, motor)
            ))
        }
        _ => None,
    }
}

/// The least objective among motors that another number of turns makes possible, with the motor.
pub(super) fn best<'r>(all: &'r [(&Motor, Rewinding)]) -> Option<(&'r Motor, &'r OtherTurns<'r>)> {
    let found = all.iter().filter_map(|(motor, rewinding)| match rewinding {
        Rewinding::Found(other) => Some((*motor, &**other, other.objective?)),
        _ => None,
    });
    found.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(motor, other, _)| (motor, other))
}

/// What a better winding saves of the objective before it is told without being asked for (relative).
const LEAST_SAVED: f64 = 0.01;

/// What the best of the refused motors of each joint would do with another number of turns, as lines: in full of a joint
/// where no motor can do it as it is wound, and one line of the joints where it would be better than the first choice.
pub(super) fn summaries(result: &RobotResult, outlooks: &[Outlook]) -> Vec<String> {
    let (mut lines, mut better) = (Vec::new(), Vec::new());
    for (of, outlook) in result.joints.iter().zip(outlooks) {
        let Some((motor, other)) = best(&outlook.rewindings) else { continue };
        let name = &of.joint.name;
        match of.candidates.first() {
            None => {
                let is_found = |(_, how): &&(&Motor, Rewinding)| matches!(how, Rewinding::Found(_));
                let can = match outlook.rewindings.iter().filter(is_found).count() {
                    1 => "1 motor".to_string(),
                    n => format!("{n} motors"),
                };
                lines.push(format!(
                    "{name}: {can} could do it with another number of turns; the best is {} with {} (`--rejected` lists each).",
                    motor.id,
                    range_text(&other.turns, motor)
                ));
            }
            Some(first) => {
                let saves = other.objective.map_or(0.0, |objective| 1.0 - objective / first.optimum.objective);
                if saves > LEAST_SAVED {
                    better.push(format!("{} at {name} ({} less)", motor.id, super::said::per_cent(saves)));
                }
            }
        }
    }
    if !better.is_empty() {
        lines.push(format!("Better with another number of turns (`--rejected`): {}.", better.join(", ")));
    }
    lines
}
