use super::{MADE, code, table};
use crate::effects::{Doubt, EFFECTS, Effect, Equation, Proof, Scale, Shape, SimulatorField, Variable};

/// The page of effects.
pub fn text() -> String {
    let mut out = format!(
        "{MADE}# Effects\n\nWhat an actuator can have beyond resistance, inductance, torque constant and inertia. `identify` asks \
         logs for them in this order; a [fitted actuator](formats.md#fitted-actuator-toml) carries them; sweep and ratio program keep \
         them as said here. Values are by default at the motor; a new effect is one file in `crates/model/src/effects`.\n\n"
    );
    let rows = EFFECTS.iter().map(|e| {
        vec![
            format!("[{0}](#{0})", e.name()),
            format!("`{}`", e.equation()),
            e.kind_of_entry().detail(),
            proof(*e).into(),
            exported(*e),
        ]
    });
    out.push_str(&table(&["effect", "adds", "how it enters the limits", "proof of N*", "exported as"], rows));
    for effect in EFFECTS {
        out.push_str(&one(*effect));
    }
    out
}

fn proof(effect: &dyn Effect) -> &'static str {
    match effect.kind_of_entry().proof() {
        Proof::Conic => "certified",
        Proof::BranchAndBound => "certified, branch and bound",
        Proof::None => "not certified",
        Proof::NotNeeded => "",
    }
}

/// What a simulator is told of it: asked of the effect itself, at a ratio of two with values of one.
fn exported(effect: &dyn Effect) -> String {
    match effect.export(&vec![1.0; effect.parameters().len()], 2.0) {
        SimulatorField::Damping(_) => "damping".into(),
        SimulatorField::FrictionLoss(_) => "friction loss".into(),
        SimulatorField::FrictionAtRest(_) => "friction at rest, where the format has one".into(),
        SimulatorField::Stiffness(_) => "a joint of its own where the format can, else a comment".into(),
        SimulatorField::Play(_) => "a joint of its own where the format can, else a comment".into(),
        SimulatorField::Cogging { .. } => "the largest order, where the format has one".into(),
        SimulatorField::Efficiency | SimulatorField::Nowhere => "comment: no place for it".into(),
    }
}

fn one(effect: &dyn Effect) -> String {
    let acts_on = match effect.acts_on() {
        Equation::Torque => "the torque that the motor supplies [N*m]",
        Equation::Voltage => "the terminal voltage [V, q axis]",
        Equation::Angle => "the angle by which the motor, over N, leads the output [rad]",
    };
    let shape = match effect.shape() {
        Shape::None => "",
        Shape::Speed(_) => " The last one is looked for among speeds of the logs.",
        Shape::Current(_) => " The last one is looked for around the largest current of the logs.",
        Shape::Order => " The last one is a whole number of periods a turn; several orders are several tables.",
    };
    let needs: Vec<&str> = effect.needs().iter().filter(|v| **v != Variable::Constant).map(|v| v.name()).collect();
    let needs = if needs.is_empty() { "nothing beyond the equation itself".into() } else { needs.join(", ") };
    let mut out = format!(
        "\n## {}\n\n`{}`, added to {acts_on}. A log must have: {needs}.{shape}\n\n",
        effect.name(),
        effect.equation()
    );
    let rows = effect
        .parameters()
        .iter()
        .enumerate()
        .map(|(k, p)| vec![code(p.name), code(p.symbol), code(p.kind.si), believed(effect, k)]);
    out.push_str(&table(&["parameter", "symbol", "SI unit", "believed"], rows));
    out
}

/// Which values of a parameter are believed: the effect is asked, with values far out on either side.
fn believed(effect: &dyn Effect, index: usize) -> String {
    const SCALE: Scale =
        Scale { torque_constant: 1.0, resistance: 1.0, torque: 1.0, speed: 1.0, current: 1.0, voltage: 1.0 };
    // The others are as small as may be, and a shape as a bench of this scale would show it.
    let with = |value: f64| {
        let mut values = vec![1e-12; effect.parameters().len()];
        if effect.shape() != Shape::None {
            values[effect.linear()] = if effect.shape() == Shape::Order { 6.0 } else { 0.2 };
        }
        values[index] = value;
        effect.plausible(&values, &SCALE)
    };
    let above = match with(-1e-9) {
        Err(Doubt::NotPositive { .. }) => "above zero",
        _ => "either sign",
    };
    match with(1e30) {
        Err(Doubt::TooLarge { of, .. }) => format!("{above}, up to {of}"),
        _ => above.into(),
    }
}
