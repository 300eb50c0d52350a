//! What an actuator is made of, part by part: how large each part is, what it costs, how long one waits for it.
//!
//! The one idea: a limit on the whole asks a list of parts, of which each says what is known of it. What else belongs to an
//! actuator (a transmission behind the gear) is one more part of a candidate, and nothing else changes.

use super::candidate::Candidate;
use crate::catalog::{Currency, GearKind};
use crate::requirement::{Arrangement, GearModel, NoPrice};

/// A part of an actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartKind {
    /// The motor.
    Motor,
    /// The gear.
    Gear,
    /// Motor and gear, bought as one.
    Module,
    /// What is between actuator and joint.
    Transmission,
}

/// What of a part is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lacks {
    Diameter,
    Length,
    LeadTime,
    Price(NoPrice),
}

impl PartKind {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            PartKind::Motor => "motor",
            PartKind::Gear => "gear",
            PartKind::Module => "module",
            PartKind::Transmission => "transmission",
        }
    }

    /// That something of it is not known.
    fn lacks(self, what: Lacks) -> &'static str {
        macro_rules! of {
            ($text:literal) => {
                match self {
                    PartKind::Motor => concat!("the motor's ", $text),
                    PartKind::Gear => concat!("the gear's ", $text),
                    PartKind::Module => concat!("the module's ", $text),
                    PartKind::Transmission => concat!("the transmission's ", $text),
                }
            };
        }
        match what {
            Lacks::Diameter => of!("outer diameter is not known"),
            Lacks::Length => of!("axial length is not known"),
            Lacks::LeadTime => of!("lead time is not known"),
            Lacks::Price(NoPrice::Blank) => of!("price is not known"),
            Lacks::Price(NoPrice::Rate) => of!("price is in a currency that [prices] has no rate for"),
            Lacks::Price(NoPrice::Date) => of!("price is more than two years from the date of [prices]"),
            Lacks::Price(NoPrice::Quantity) => of!("price is that of more pieces than the quantity of [prices]"),
        }
    }
}

/// A part with what is known of it. SI; a price in the currency of `[prices]`.
#[derive(Debug, Clone, Copy)]
struct Part {
    kind: PartKind,
    /// Across the axis \[m\].
    diameter: Option<f64>,
    /// Along the axis \[m\].
    length: Option<f64>,
    price: Result<f64, NoPrice>,
    /// \[s\].
    lead_time: Option<f64>,
}

impl Part {
    fn number(&self, value: Option<f64>, what: Lacks) -> (PartKind, Result<f64, &'static str>) {
        (self.kind, value.ok_or_else(|| self.kind.lacks(what)))
    }
}

/// A number of all parts together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whole {
    /// What of it is known: all together it is at least this.
    pub known: f64,
    /// The part whose number that is; `None` where several add up.
    pub part: Option<PartKind>,
    /// What is not known, where something is not.
    pub missing: Option<&'static str>,
}

impl Whole {
    const NOTHING: Whole = Whole { known: 0.0, part: None, missing: None };

    /// The number, where all of it is known.
    pub fn value(&self) -> Option<f64> {
        self.missing.is_none().then_some(self.known)
    }

    /// The largest of the parts; the first of several.
    fn largest(parts: impl Iterator<Item = (PartKind, Result<f64, &'static str>)>) -> Whole {
        parts.fold(Whole::NOTHING, |whole, (part, number)| match number {
            Ok(value) if value > whole.known => Whole { known: value, part: Some(part), ..whole },
            Ok(_) => whole,
            Err(why) => Whole { missing: whole.missing.or(Some(why)), ..whole },
        })
    }

    /// The sum of the parts.
    fn sum(parts: impl Iterator<Item = (PartKind, Result<f64, &'static str>)>) -> Whole {
        let mut counted = 0;
        let whole = parts.fold(Whole::NOTHING, |whole, (part, number)| match number {
            Ok(value) if value > 0.0 => {
                counted += 1;
                Whole { known: whole.known + value, part: Some(part), ..whole }
            }
            Ok(_) => whole,
            Err(why) => Whole { missing: whole.missing.or(Some(why)), ..whole },
        });
        Whole { part: whole.part.filter(|_| counted == 1), ..whole }
    }
}

/// A price of all parts together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// What is known of it.
    pub whole: Whole,
    /// The currency that it is counted in.
    pub currency: Currency,
}

impl Candidate<'_> {
    /// Every part. A module is one part; a gear that is none (direct drive) has nothing that its row does not say.
    fn parts(&self) -> impl Iterator<Item = Part> {
        let sheet = &self.motor.sheet;
        let is_module = self.motor.inside.is_some();
        let price = |offer| self.robot.prices.as_ref().map_or(Err(NoPrice::Blank), |prices| prices.of(offer));
        // The row of a module stands in the motor's sheet.
        let motor = Part {
            kind: if is_module { PartKind::Module } else { PartKind::Motor },
            diameter: sheet.outer_diameter.map(|p| p.value),
            // What a family says of the motor that it is made for fills what the motor's row lacks.
            length: sheet.length.map(|p| p.value).or_else(|| self.catalog_gear.and_then(|gear| gear.motor_length)),
            price: price(&sheet.offer),
            lead_time: sheet.offer.lead_time,
        };
        let none = self.catalog_gear.is_some_and(|gear| gear.kind == GearKind::Direct).then_some(0.0);
        let of_gear = match self.catalog_gear {
            Some(gear) => price(&gear.offer),
            None => self.gear.price.ok_or(NoPrice::Blank),
        };
        let gear = Part {
            kind: PartKind::Gear,
            diameter: self.gear.outer_diameter.or(none),
            length: self.gear.length.or(none),
            price: of_gear.or_else(|why| none.filter(|_| why == NoPrice::Blank).ok_or(why)),
            lead_time: self.gear.lead_time.or(none),
        };
        let transmission = self.joint.passed.as_deref().map(|passed| {
            let numbers = passed.numbers;
            // One coupling belongs to two actuators.
            let each = passed.joints.len() as f64;
            Part {
                kind: PartKind::Transmission,
                diameter: numbers.outer_diameter,
                length: numbers.length,
                price: numbers.price.map(|price| price / each).ok_or(NoPrice::Blank),
                lead_time: numbers.lead_time,
            }
        });
        [Some(motor), (!is_module).then_some(gear), transmission].into_iter().flatten()
    }

    /// The diameter of the largest part \[m\].
    pub fn outer_diameter(&self) -> Whole {
        Whole::largest(self.parts().map(|part| part.number(part.diameter, Lacks::Diameter)))
    }

    /// The length of all parts as they lie to each other \[m\].
    pub fn axial_length(&self) -> Whole {
        let lengths = self.parts().map(|part| part.number(part.length, Lacks::Length));
        match self.joint.limits.arrangement {
            Arrangement::Coaxial => Whole::sum(lengths),
            Arrangement::SideBySide => Whole::largest(lengths),
        }
    }

    /// The price of all parts, in the currency of `[prices]`; `None` where the requirement has none.
    pub fn price(&self) -> Option<Cost> {
        let currency = self.robot.prices.as_ref()?.currency;
        let price = |part: Part| (part.kind, part.price.map_err(|why| part.kind.lacks(Lacks::Price(why))));
        Some(Cost { whole: Whole::sum(self.parts().map(price)), currency })
    }

    /// The longest time until a part is delivered \[s\].
    pub fn lead_time(&self) -> Whole {
        Whole::largest(self.parts().map(|part| part.number(part.lead_time, Lacks::LeadTime)))
    }

    /// Whether the requirement describes no gear where a ratio other than 1 may be chosen: an ideal one then has no size and costs
    /// nothing, which is an assumption.
    pub fn assumes_ideal_gear(&self) -> bool {
        let described = self.catalog_gear.is_some() || self.motor.inside.is_some() || self.joint.gear_map.is_some();
        let direct = self.joint.ratio.range() == Some((1.0, 1.0));
        !described && !direct && self.joint.gear == GearModel::IDEAL
    }
}
