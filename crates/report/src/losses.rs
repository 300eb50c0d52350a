//! Where the loss of a design is, in words.

use super::number;
use gearwise_model::actuator::gear_figures::GearFigures;
use gearwise_model::actuator::losses::UnknownLoss;
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::drag::Drag;
use gearwise_select::break_even::{BreakEven, OpenOrder};
use gearwise_select::evaluate::Evaluation;

/// What a part is called.
pub fn name(key: &str) -> &'static str {
    match key {
        "copper" => "copper",
        "motor_drag" => "motor drag",
        "gear_load" => "gear under load",
        "gear_no_load" => "gear without load",
        "braking" => "not kept of what comes back",
        _ => "drive",
    }
}

/// A loss that another end of the motor's drag changes by less than this is not told as a range (relative).
const SAME: f64 = 0.005;

/// The parts of the loss, what it is at least, and what nobody knows of it.
pub(super) fn sentence(of: &Evaluation) -> String {
    let parts: Vec<String> = of
        .losses
        .parts()
        .into_iter()
        .filter(|(_, watts)| *watts != 0.0)
        .map(|(key, watts)| format!("{} {}", name(key), number(watts)))
        .collect();
    let parts = match parts.len() {
        0 => "nothing".to_string(),
        _ => format!("{} W", parts.join(", ")),
    };
    let least = match of.loss_low < of.loss * (1.0 - SAME) {
        true => format!("; at least {} W in all, by what is known of the motor's drag", number(of.loss_low)),
        false => String::new(),
    };
    format!("loss {} W: {parts}{least}{}", number(of.loss), without(&of.unknown_losses))
}

/// Between what voltages a bus moves whose supply has a resistance, and what weakening of the field takes: a sentence each.
pub(super) fn of_supply(of: &Evaluation) -> Vec<String> {
    let bus = of.bus_voltage.map(|bus| match bus.lowest {
        Some(lowest) => {
            let heat = bus.heat.map_or_else(String::new, |watts| {
                format!("; {} W of heat in the supply's resistance, which the loss leaves out", number(watts))
            });
            format!(
                "bus voltage {} to {} V, by the power of this joint alone{heat}",
                number(lowest),
                number(bus.highest)
            )
        }
        None => "the supply cannot give the power: more than at half of its voltage".into(),
    });
    let weakened = of.weakening.map(|weakening| match weakening.largest > 0.0 {
        true => format!(
            "{} for {} % of the time, by at most {} A (amplitude): {} W of the copper loss{}",
            if weakening.burns { "power that comes back burned along d" } else { "field weakened" },
            number(100.0 * weakening.share),
            number(weakening.largest / 1.5_f64.sqrt()),
            number(weakening.loss),
            weakening.rate.map_or_else(String::new, |rate| format!(
                "; L di_d/dt, left out, comes to {} % of the voltage limit as it is from sample to sample",
                number(100.0 * rate)
            ))
        ),
        false if weakening.burns => "nothing is burned along d: the bus takes what comes back".into(),
        false => "the field is not weakened at any instant: the voltage is enough".into(),
    });
    bus.into_iter().chain(weakened).collect()
}

/// What is known of the gear at a design beside its limits; nothing where that is nothing.
pub(super) fn of_gear(of: &Evaluation) -> Option<String> {
    let GearFigures { efficiency_at_mean, efficiency_at_peak, backdriving_torque, life } = of.gear;
    let share = |value: Option<f64>, at: &str| value.map(|value| format!("{} % at {at}", number(100.0 * value)));
    let efficiency: Vec<String> =
        [share(efficiency_at_mean, "the mean load"), share(efficiency_at_peak, "the peak load")]
            .into_iter()
            .flatten()
            .collect();
    let efficiency = (!efficiency.is_empty()).then(|| format!("efficiency {}", efficiency.join(", ")));
    let back = backdriving_torque.map(|torque| match torque.is_finite() {
        true => format!("{} at the output turn it and the motor without current", super::with_unit(torque, "N*m")),
        false => "no torque at the output turns it".into(),
    });
    let life = life.map(|seconds| format!("life (L10) {} h of this motion", number(seconds / 3600.0)));
    let said: Vec<String> = [efficiency, back, life].into_iter().flatten().collect();
    (!said.is_empty()).then(|| format!("gear: {}", said.join("; ")))
}

/// What nobody knows of a loss, to go on a sentence.
pub(super) fn without(unknown: &[UnknownLoss]) -> String {
    let names: Vec<&str> = unknown.iter().map(|part| part.words()).collect();
    if names.is_empty() { String::new() } else { format!("; without: {}", names.join(", ")) }
}

/// Up to what drag a motor whose drag is not known, or estimated, is ahead.
pub(super) fn break_even(of: &BreakEven, motor: &Motor) -> String {
    let known = match motor.drag() {
        Drag::Estimated { torque } => format!("; {} is estimated", super::with_unit(torque, "N*m")),
        _ => String::new(),
    };
    let current = of.current.map_or_else(String::new, |i| format!(" (no-load current {})", super::with_unit(i, "A")));
    let other = match () {
        () if of.other_is_estimated => " (with its own drag at the estimated end)",
        () if of.other_is_open => " (with its own drag at the worse end)",
        () => "",
    };
    format!("ahead of {}{other} up to a drag of {}{current}{known}", of.other, super::with_unit(of.torque, "N*m"))
}

/// Up to what share of a no-load torque, or from what share on, a first choice is ahead of the next.
pub(super) fn open_order(of: &OpenOrder, motor: &Motor) -> String {
    let other = &of.other;
    let (where_else, whose) = match (of.of_first, motor.drag()) {
        (true, _) => (format!(", wherever the drag of {other} lies,"), motor.id.as_str()),
        (false, Drag::NoLoad { speed: Some(_), .. }) => {
            (", with its own drag at the worse end,".into(), other.as_str())
        }
        (false, _) => (String::new(), other.as_str()),
    };
    // Rounded to the side where it is ahead.
    let tenths = 1000.0 * of.share;
    let (word, share) = if of.at_most { ("most", tenths.floor()) } else { ("least", tenths.ceil()) };
    format!(
        "ahead of {other}{where_else} while at {word} {} % of the no-load torque of {whose}, {}, is Coulomb friction and the rest viscous: the row does not say what part is",
        number(share / 10.0),
        super::with_unit(of.torque, "N*m")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_rounded_to_the_side_where_the_first_is_ahead() {
        let motor = gearwise_model::catalog::Catalog::builtin().unwrap().motors.remove(0);
        let most = OpenOrder { other: "b".into(), of_first: true, torque: 0.05, share: 0.59996, at_most: true };
        let text = open_order(&most, &motor);
        let own =
            format!("the drag of b lies, while at most 59.9 % of the no-load torque of {}, 0.05 N*m, is", motor.id);
        assert!(text.contains(&own), "{text}");
        let text = open_order(&OpenOrder { of_first: false, at_most: false, share: 0.40004, ..most }, &motor);
        assert!(text.contains("at least 40.1 % of the no-load torque of b, 0.05 N*m,"), "{text}");
    }
}
