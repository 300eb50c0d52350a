//! How a number of a model is compared with a fact of hardware, and said.

use crate::hardware::{Fact, Hardware, Holds};
use crate::models::{ModelFacts, ModelJoint};
use crate::rule::{Backing, Instead, Judgement, ModelRemark};
use gearwise_model::mechanism::stated::{Form, Quantity, Stated};
use gearwise_model::words::{number, with_unit};

/// Why an effort is not judged.
pub(super) const NO_TORQUE: &str = "no row of its hardware gives a peak torque";

/// What hardware allows, with its row.
pub(super) fn backing(fact: &Fact, what: &str, unit: &str) -> Backing {
    let least = match fact.holds {
        Holds::AtLeast => "at least ",
        Holds::AtMost => "at most ",
        Holds::Exactly => "",
    };
    Backing {
        allows: format!("{what} {least}{}", with_unit(fact.value, unit)),
        row: fact.row.clone(),
        source: fact.source.clone(),
        conversion: fact.how.clone(),
    }
}

/// A remark about a number that a model states of a joint.
pub(super) fn about(joint: usize, facts: &ModelFacts, stated: &Stated, message: String) -> ModelRemark {
    ModelRemark {
        joint: Some(joint),
        value: Some(stated.value),
        unit: stated.quantity.unit(),
        ..ModelRemark::new(message, stated.quantity.name(), facts.joints[joint].at(&stated.span))
    }
}

impl ModelRemark {
    /// With the fact that it rests on.
    pub(super) fn against(self, fact: &Fact, what: &str) -> ModelRemark {
        let backing = Some(backing(fact, what, self.unit));
        ModelRemark { bound: Some(fact.value), backing, ..self }
    }

    /// With what to write in place of it, and a fix that writes it.
    pub(super) fn write(mut self, quantity: Quantity, value: f64) -> ModelRemark {
        self.help = Some(format!("write {}", with_unit(value, quantity.unit())));
        if let Some(joint) = self.joint {
            self.instead.push(Instead { joint, quantity, value });
        }
        self
    }
}

/// A number of a model with what it is called there.
pub(super) fn stated_as(stated: &Stated) -> String {
    let value = with_unit(stated.value, stated.quantity.unit());
    if stated.called == stated.quantity.name() {
        format!("{} {value}", stated.quantity.name())
    } else {
        format!("{} {value} ({})", stated.quantity.name(), stated.called)
    }
}

/// What a model states of a joint with hardware that is judged, or why there is nothing to judge.
pub(super) fn asked<'f, 'a>(
    facts: &'f ModelFacts<'a>,
    joint: usize,
    quantity: Quantity,
) -> Result<(&'a Hardware, &'f Stated), Judgement> {
    let of = &facts.joints[joint];
    let hardware = of.hardware.ok_or(Judgement::NotAsked)?;
    if !of.joint.turns {
        return Err(Judgement::NotJudged("it slides, and rows give torques"));
    }
    // Of a table of limits what is left out is not meant; MJCF has no velocity.
    let form = facts.models[of.model].form;
    // A limit of 0 is a placeholder.
    let stated = of.get(quantity).filter(|stated| stated.value > 0.0);
    let stated = stated.ok_or(match (form, form.has(quantity)) {
        (Form::Limits, _) | (_, false) => Judgement::NotAsked,
        (_, true) => Judgement::NotJudged("the model does not state it"),
    })?;
    if of.coupling.is_some() {
        return Err(Judgement::NotJudged("two actuators drive it together with another joint"));
    }
    Ok((hardware, stated))
}

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", number((1000.0 * share).round() / 10.0))
}

/// Factors of gear and transmission to a power, upwards and downwards, for a quotient that shall be explained.
pub(super) fn factors(hardware: &Hardware, power: i32) -> Vec<(f64, String)> {
    let sign = if power == 2 { "²" } else { "" };
    let (r, n) = (hardware.transmission, hardware.gear);
    let mut all = Vec::new();
    let mut add = |value: f64, name: &str| {
        let product = if name.contains(' ') { format!("({name})") } else { name.to_string() };
        let (up, down) = (if power == 1 { name } else { product.as_str() }, product.as_str());
        all.push((value.powi(power), format!("{up}{sign} ({name} = {})", number(value))));
        all.push((value.powi(-power), format!("1/{down}{sign} ({name} = {})", number(value))));
        if power == 2 {
            all.push((value, format!("{name} ({name} = {})", number(value))));
            all.push((1.0 / value, format!("1/{product} ({name} = {})", number(value))));
        }
    };
    if let Some(n) = n.filter(|n| *n != 1.0) {
        add(n, "N");
        if r != 1.0 {
            add(n * r, "N r");
        }
    }
    if r != 1.0 {
        add(r, "r");
    }
    all.push((2.0, "a factor of 2".into()));
    all.push((0.5, "a factor of 1/2".into()));
    all
}

/// The hardware of a joint whose limits are judged one by one.
pub(super) fn alone<'a>(joint: &ModelJoint<'a>) -> Option<&'a Hardware> {
    joint.hardware.filter(|_| joint.joint.turns)
}

/// Whether a finding between joints explains what is wrong with the limits of this one.
pub(super) fn is_explained(facts: &ModelFacts, joint: usize) -> bool {
    facts.same_limits.iter().any(|(of, _)| *of == joint)
}
