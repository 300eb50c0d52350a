//! What each format makes of each fact: the one table from which comments, reports and the documentation are made.

use super::Exported;
use crate::number;
use gearwise_select::simulated::{Bound, Fact};

/// What a format makes of a fact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// It says it: in which key.
    Said(&'static str),
    /// It says it nearly: how, and what is lost.
    Approximately(&'static str),
    /// It cannot say it: why.
    Not(&'static str),
}

impl Cell {
    /// One character of it, for tables.
    pub fn mark(self) -> &'static str {
        match self {
            Cell::Said(_) => "✓",
            Cell::Approximately(_) => "~",
            Cell::Not(_) => "–",
        }
    }

    /// Key, way or reason.
    pub fn words(self) -> &'static str {
        match self {
            Cell::Said(words) | Cell::Approximately(words) | Cell::Not(words) => words,
        }
    }
}

/// The value of a fact at a joint, in words; `None` where it is not known or does not apply.
pub fn value(e: &Exported, fact: Fact) -> Option<String> {
    let s = &e.simulated;
    let with = |value: Option<f64>, unit: &str| value.map(|v| format!("{} {unit}", number(v)));
    let bound = |b: Option<Bound>, unit: &str| b.map(|b| format!("{} {unit} (by the {})", number(b.value), b.owner));
    let left = || {
        let own = s.left_out.iter().filter(|l| l.fact == Some(fact)).map(|l| l.what.clone()).collect::<Vec<_>>();
        (!own.is_empty()).then(|| own.join("; "))
    };
    match fact {
        Fact::Armature => with(s.armature, "kg*m^2"),
        Fact::Damping => with(s.damping, "N*m*s/rad"),
        Fact::Friction => with(s.friction_loss, "N*m"),
        Fact::FrictionAtRest => with(s.friction_at_rest, "N*m more than while it moves"),
        Fact::PeakTorque => bound(s.effort(), "N*m"),
        Fact::TorqueSpeed => s.line.map(|line| {
            format!(
                "{} N*m up to {} rad/s, none at {} rad/s",
                number(line.effort),
                number(line.corner),
                number(line.no_load)
            )
        }),
        Fact::Braking => bound(s.braking_effort(), "N*m"),
        Fact::ContinuousTorque => bound(s.continuous_effort(), "N*m"),
        Fact::MechanicalSpeed => bound(s.mechanical_speed, "rad/s"),
        Fact::GearLoss => {
            let (efficiency, backwards) = s.efficiencies.filter(|both| *both != (1.0, 1.0))?;
            Some(format!("efficiency {}, backwards {}", number(efficiency), number(backwards)))
        }
        Fact::Compliance => with(s.stiffness, "N*m/rad"),
        Fact::Backlash => with(s.backlash, "rad"),
        Fact::Cogging => (!s.cogging.is_empty()).then(|| {
            let one = |c: &gearwise_select::simulated::Cog| format!("{} N*m of order {}", number(c.amplitude), c.order);
            format!("at the motor {}", s.cogging.iter().map(one).collect::<Vec<_>>().join(", "))
        }),
        Fact::ElectricalTime => with(s.winding.and_then(|w| w.time_constant).map(|t| 1e3 * t), "ms"),
        Fact::Heating => s.heat.map(|heat| {
            let time = heat.time_constant.map_or_else(|| "not known".into(), |t| format!("{} s", number(t)));
            format!("{} K/W from winding to ambient, time constant {time}", number(heat.resistance))
        }),
        Fact::Ranges => e.spread.as_ref().filter(|spread| !spread.ranges.is_empty()).map(|spread| {
            let one = |r: &gearwise_select::simulated::spread::Ranged| {
                format!("{} {} to {}", r.name, number(r.low), number(r.high))
            };
            spread.ranges.iter().map(one).collect::<Vec<_>>().join(", ")
        }),
        Fact::OtherEffects | Fact::Transmission | Fact::Spring => left(),
    }
}

/// What a format does not say of a joint, or says only nearly: a line for each fact that the joint has.
/// What was granted to a wish has remarks of its own.
pub fn lines(e: &Exported, says: fn(Fact) -> Cell, is_granted: impl Fn(Fact) -> bool) -> Vec<String> {
    let mut lines = Vec::new();
    for left in e.simulated.left_out.iter().filter(|left| !left.fact.is_some_and(&is_granted)) {
        match left.fact.map(says) {
            Some(Cell::Said(_)) => {}
            Some(Cell::Approximately(how)) => lines.push(format!("nearly: {}: {how}", left.what)),
            Some(Cell::Not(_)) | None => lines.push(format!("left out: {}: {}", left.what, left.why)),
        }
    }
    // What has a number of its own and no reason among those.
    for fact in Fact::ALL {
        if is_granted(*fact) || e.simulated.left_out.iter().any(|left| left.fact == Some(*fact)) {
            continue;
        }
        let Some(value) = value(e, *fact) else { continue };
        match says(*fact) {
            Cell::Said(_) => {}
            Cell::Approximately(how) => lines.push(format!("nearly: {} {value}: {how}", fact.title())),
            Cell::Not(why) => lines.push(format!("left out: {} {value}: {why}", fact.title())),
        }
    }
    lines
}
