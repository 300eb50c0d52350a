//! Two motors side by side: the case study of Urs et al. for any pair.

use super::catalog::card::{estimate_line, priced};
use super::rank::with_tolerance;
use super::table::{Column, Table, paragraph};
use super::{number, optional};
use gearwise_model::actuator::metrics::{METRICS, MatchedInertia, at_matched_inertia, metric};
use gearwise_model::actuator::step_response::{StepResponse, simulate};
use gearwise_model::catalog::audit::{audit_motor, conventions_line};
use gearwise_model::catalog::estimate::Estimated;
use gearwise_model::catalog::{Module, Motor, Printed};
use gearwise_model::units::in_unit;

/// Two motors, made ready for comparison.
#[derive(Debug)]
pub struct Comparison<'a> {
    /// The motors.
    pub motors: [&'a Motor; 2],
    /// Actuator inertia that both are matched to \[kg·m²\].
    pub inertia: f64,
    pub(super) matched: [Option<MatchedInertia>; 2],
    pub(super) without_inductance: [Option<StepResponse>; 2],
    pub(super) with_inductance: [Option<StepResponse>; 2],
}

impl<'a> Comparison<'a> {
    /// Compares at an actuator inertia; without one, at the larger rotor inertia of the two.
    pub fn new(a: &'a Motor, b: &'a Motor, inertia: Option<f64>) -> Comparison<'a> {
        let larger = a.rotor_inertia.unwrap_or(0.0).max(b.rotor_inertia.unwrap_or(0.0));
        let inertia = inertia.unwrap_or(larger);
        let motors = [a, b];
        Comparison {
            motors,
            inertia,
            matched: motors.map(|m| at_matched_inertia(known(m)?, inertia).filter(|_| inertia > 0.0)),
            without_inductance: motors.map(|m| simulate(known(m)?, 0.0)),
            with_inductance: motors.map(|m| simulate(known(m)?, m.inductance?)),
        }
    }
}

/// A motor of which constants are known: of a module that says ratings alone none are.
fn known(motor: &Motor) -> Option<&Motor> {
    (motor.resistance.is_finite() && motor.back_emf_constant.is_finite()).then_some(motor)
}

/// How much better the first is, as a factor; `None` where one value is missing.
fn advantage(a: Option<f64>, b: Option<f64>, lower_is_better: bool) -> String {
    match (a, b) {
        (Some(a), Some(b)) if a > 0.0 && b > 0.0 => format!("{}×", number(if lower_is_better { b / a } else { a / b })),
        _ => "–".into(),
    }
}

fn row(what: &str, values: [Option<f64>; 2], unit: &str, lower_is_better: Option<bool>) -> Vec<String> {
    let shown = values.map(|v| optional(v.map(|v| in_unit(v, unit))));
    let better = lower_is_better.map_or_else(String::new, |lower| advantage(values[0], values[1], lower));
    let [a, b] = shown;
    vec![format!("{what} [{unit}]"), a, b, better]
}

/// What stands behind a number that is estimated.
const ESTIMATED: &str = "estimated";

/// A row whose numbers are marked where they are estimates, or made from one.
fn marked(mut cells: Vec<String>, guessed: [bool; 2]) -> Vec<String> {
    for (cell, _) in cells[1..3].iter_mut().zip(guessed).filter(|(cell, guessed)| *guessed && *cell != "–") {
        cell.push_str(&format!(" {ESTIMATED}"));
    }
    cells
}

/// A table under its title: columns and rows.
pub(super) type Titled = (String, Vec<Column>, Vec<Vec<String>>);

/// What is compared, table by table: as computed, metrics, at matched inertia, step response, and of modules what they are rated.
pub(super) fn tables(comparison: &Comparison) -> Vec<Titled> {
    let [a, b] = comparison.motors;
    let pair = |f: fn(&Motor) -> Option<f64>| comparison.motors.map(f);
    let header = || {
        let [a, b] = [a, b].map(|motor| Column::number(&*motor.id, ""));
        vec![Column::name(""), a, b, Column::number("advantage\nof the first", "")]
    };
    let guessed = |of: Estimated| comparison.motors.map(|m| m.is_estimated(of));
    let computed = vec![
        row("resistance R", pair(|m| Some(m.resistance).filter(|v| v.is_finite())), "ohm", None),
        marked(row("inductance L", pair(|m| m.inductance), "mH", None), guessed(Estimated::Inductance)),
        row("torque constant K_T", pair(|m| Some(m.torque_constant).filter(|v| v.is_finite())), "N*m/A", None),
        row("back-EMF constant K_B", pair(|m| Some(m.back_emf_constant).filter(|v| v.is_finite())), "V*s/rad", None),
        marked(row("rotor inertia J_m", pair(|m| m.rotor_inertia), "g*cm^2", None), guessed(Estimated::RotorInertia)),
        row("mass m", pair(|m| m.mass), "g", None),
    ];
    let metrics = METRICS
        .iter()
        .filter(|m| !matches!(m.name, "rotor_inertia" | "mass" | "k_t"))
        .map(|m| {
            let estimates = comparison.motors.map(|motor| m.of(motor));
            let values = estimates.map(|e| e.map(|e| e.value));
            let cells = vec![
                format!("{} [{}]", m.symbol, m.unit),
                with_tolerance(m, estimates[0]),
                with_tolerance(m, estimates[1]),
                advantage(values[0], values[1], m.lower_is_better),
            ];
            marked(cells, comparison.motors.map(|motor| m.rests_on_estimate(motor)))
        })
        .collect();
    let matched = |f: fn(&MatchedInertia) -> f64| comparison.matched.map(|m| m.as_ref().map(f));
    let at_matched = [
        row("ratio N", matched(|m| m.ratio), "1", None),
        row("actuator torque constant K_Ta", matched(|m| m.torque_constant), "N*m/A", Some(false)),
        row("actuator motor constant K_Ma", matched(|m| m.motor_constant), "N*m/W^0.5", Some(false)),
    ];
    let at_matched = at_matched.map(|cells| marked(cells, guessed(Estimated::RotorInertia))).to_vec();
    let time = |r: &[Option<StepResponse>; 2]| r.map(|r| r.map(|r| r.rise_time));
    let overshoot = comparison.with_inductance.map(|r| r.map(|r| r.overshoot));
    let inertia = guessed(Estimated::RotorInertia);
    let either = comparison
        .motors
        .map(|m| [Estimated::RotorInertia, Estimated::Inductance].iter().any(|of| m.is_estimated(*of)));
    let step = vec![
        marked(row("63 % without inductance", time(&comparison.without_inductance), "ms", Some(true)), inertia),
        marked(row("63 % with inductance", time(&comparison.with_inductance), "ms", Some(true)), either),
        marked(row("overshoot with inductance", overshoot, "%", None), either),
    ];
    let inertia = number(comparison.inertia * 1e7);
    let rated = |f: fn(&Module) -> Option<f64>| comparison.motors.map(|m| f(&m.inside.as_deref()?.module));
    let ratings = || {
        let printed = |f: fn(&Module) -> Option<Printed>| {
            comparison.motors.map(|m| f(&m.inside.as_deref()?.module).map(|p| p.value))
        };
        vec![
            row("ratio N", rated(|m| Some(m.ratio())), "1", None),
            row("peak torque", printed(|m| m.sheet.peak_torque), "N*m", Some(false)),
            row("rated torque", printed(|m| m.sheet.rated_torque), "N*m", Some(false)),
            row("speed without load", rated(Module::no_load_speed), "rpm", Some(false)),
            row("at a voltage of", printed(|m| m.sheet.voltage), "V", None),
            row("own inertia at the output", rated(|m| m.constants().inertia), "kg*m^2", Some(true)),
        ]
    };
    let mut all = vec![
        ("As the program computes with them: power-invariant q axis".into(), header(), computed),
        ("Metrics that no ratio changes".into(), header(), metrics),
        (
            match comparison.inertia > 0.0 {
                true => format!("At matched actuator inertia J_a = {inertia} g*cm^2 (massless gears without loss)"),
                false => "At matched actuator inertia: neither inertia is known; `--inertia` gives one".into(),
            },
            header(),
            at_matched,
        ),
        ("Speed response to a voltage step of the free motor, simulated".into(), header(), step),
    ];
    let bought = bought(comparison);
    if !bought.is_empty() {
        all.push(("Size, price and lead time, as the rows print them".into(), header(), bought));
    }
    if comparison.motors.iter().any(|m| m.inside.is_some()) {
        all.push(("What the modules' rows rate, at the output".into(), header(), ratings()));
    }
    all
}

/// How large the two are, what they cost and how long one waits for them; nothing where no row says any of it.
fn bought(comparison: &Comparison) -> Vec<Vec<String>> {
    let pair = |f: fn(&Motor) -> Option<f64>| comparison.motors.map(f);
    let numbers: [(&str, [Option<f64>; 2], &str); 3] = [
        ("outer diameter", pair(|m| m.sheet.outer_diameter.map(|p| p.value)), "mm"),
        ("axial length", pair(|m| m.sheet.length.map(|p| p.value)), "mm"),
        ("lead time", pair(|m| m.sheet.offer.lead_time), "d"),
    ];
    let said = |values: &[Option<f64>; 2]| values.iter().any(Option::is_some);
    let rows = numbers.iter().filter(|(_, values, _)| said(values));
    let mut rows: Vec<_> = rows.map(|(what, values, unit)| row(what, *values, unit, Some(true))).collect();
    let prices = comparison.motors.map(|m| m.sheet.offer.price());
    if prices.iter().any(Option::is_some) {
        let [a, b] = prices.map(|price| price.map_or_else(|| "–".into(), |price| priced(&price)));
        let same = prices[0].zip(prices[1]).filter(|(a, b)| a.currency == b.currency && a.quantity == b.quantity);
        let better = same.map_or_else(String::new, |(a, b)| advantage(Some(a.value), Some(b.value), true));
        rows.push(vec!["price".into(), a, b, better]);
    }
    rows
}

/// Which of the two is more responsive, by how much, and how sure that is.
pub(super) fn faster(comparison: &Comparison) -> Option<String> {
    let [a, b] = comparison.motors;
    let s_m = metric("s_m")?;
    let (x, y) = (s_m.of(a)?, s_m.of(b)?);
    let faster = if x.value <= y.value { (a, b, y.value / x.value) } else { (b, a, x.value / y.value) };
    let sure = s_m.probability_ahead(&x, &y).map_or_else(
        || "a ± is missing, so how sure that is cannot be said".to_string(),
        |p| format!("sure to {:.0} %", 100.0 * p.max(1.0 - p)),
    );
    let times = number(faster.2);
    let guessed: Vec<&str> =
        comparison.motors.iter().filter(|m| s_m.rests_on_estimate(m)).map(|m| m.id.as_str()).collect();
    let sure = match guessed.as_slice() {
        [] => sure,
        ids => format!("the rotor inertia of {} is estimated, from above: no row says it", ids.join(" and ")),
    };
    let line = format!("{} is {times} times as responsive as {} (ratio of S_M; {sure}).", faster.0.id, faster.1.id);
    Some(match a.about.same_as == b.id || b.about.same_as == a.id {
        true => format!("{} and {} are two rows of one motor: they differ by what was measured. {line}", a.id, b.id),
        false => line,
    })
}

/// For people.
pub fn text(comparison: &Comparison) -> String {
    let mut out = String::new();
    for (k, (title, header, rows)) in tables(comparison).into_iter().enumerate() {
        let gap = if k == 0 { "" } else { "\n" };
        out.push_str(&format!("{gap}{}\n{}", paragraph(&title, 0, 2), Table::new(header).rows(rows).text()));
        if k == 1
            && let Some(line) = faster(comparison)
        {
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
        }
    }
    let heading = "Where the numbers come from, and what is doubtful about them";
    out.push_str(&format!("\n{}\n", paragraph(heading, 0, 2)));
    for motor in comparison.motors {
        let line = format!("{}: {}; {}", motor.id, conventions_line(motor), motor.source);
        out.push_str(&paragraph(&line, 0, 2));
        if !motor.note.is_empty() {
            out.push_str(&paragraph(&motor.note, 2, 2));
        }
        for assumption in &motor.assumptions {
            out.push_str(&paragraph(&format!("assumed: {assumption}"), 2, 4));
        }
        for estimate in &motor.estimates {
            out.push_str(&paragraph(&estimate_line(estimate), 2, 4));
        }
        for finding in audit_motor(motor) {
            let why = finding.explanation.map_or_else(String::new, |w| format!(" ({w})"));
            let line = format!("audit [{}]: {}{why}", finding.code, finding.message);
            out.push_str(&paragraph(&line, 2, 4));
        }
    }
    out
}
