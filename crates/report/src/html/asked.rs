//! What was asked, with which the page of every answer about a robot begins: the supply, each joint's motion and limits.

use super::{Part, Table};
use crate::optimize::ratio_text;
use crate::plot::asked as plot;
use crate::{counted, different_motors, number};
use gearwise_model::requirement::{Course, Joint, Regeneration, Robot};
use gearwise_model::units::in_unit;

/// What a requirement asks of some of its joints: the supply in a sentence, the joints as a table, the motions drawn.
pub(super) fn parts(robot: &Robot, joints: &[&Joint]) -> Vec<Part> {
    let mut parts = vec![Part::Text(supply(robot))];
    parts.push(Part::Table(table(joints)));
    parts.push(Part::Figure(plot::figure(joints)));
    parts
}

/// The same of every joint.
pub(super) fn of_robot(robot: &Robot) -> Vec<Part> {
    parts(robot, &robot.joints.iter().collect::<Vec<_>>())
}

/// The supply, the surroundings and what the whole robot may have.
fn supply(robot: &Robot) -> String {
    let bus = &robot.bus;
    let mut all = vec![format!("Bus of {} V", number(bus.voltage))];
    if bus.modulation_limit < 1.0 {
        all.push(format!("of which the drive uses {} %", number(100.0 * bus.modulation_limit)));
    }
    all.extend(bus.drive_current.map(|i| format!("drives of at most {} A (amplitude of a phase)", number(i))));
    all.extend(bus.power.map(|p| format!("at most {} W for one joint", number(p))));
    all.extend(bus.current.map(|i| format!("at most {} A of the bus for one joint", number(i))));
    all.extend(bus.drive.continuous_current.map(|i| format!("drives of at most {} A continuously", number(i))));
    all.extend(bus.internal_resistance.map(|r| format!("internal resistance {} ohm", number(r))));
    all.extend(bus.max_voltage.map(|v| format!("it may rise to {} V", number(v))));
    all.push(match bus.regeneration {
        Regeneration::Dissipated => "what comes back goes into a brake: nothing of it is kept".into(),
        Regeneration::Allowed => "it takes back all that comes back".into(),
        Regeneration::Limited(0.0) => "it takes nothing back".into(),
        Regeneration::Limited(most) => format!("it takes back at most {} W", number(most)),
    });
    all.extend(
        bus.regeneration_efficiency
            .map(|share| format!("{} % of what a motor gives back is kept", number(100.0 * share))),
    );
    all.extend(bus.brake_power.map(|p| format!("a brake takes at most {} W of one joint", number(p))));
    all.push(format!("surroundings {} °C", number(in_unit(robot.ambient, "degC"))));
    let budget = &robot.budget;
    all.extend(budget.actuator_mass.map(|m| format!("all actuators together at most {} kg", number(m))));
    all.extend(budget.max_distinct_motors.map(|n| format!("at most {}", different_motors(n as usize))));
    all.extend(
        robot
            .shared_regeneration()
            .map(|p| format!("at most {} W back to the bus from all joints together", number(p))),
    );
    all.extend(robot.shared_power().map(|p| format!("at most {} W from the bus for all joints together", number(p))));
    format!("{}.", all.join("; "))
}

fn table(joints: &[&Joint]) -> Table {
    let header = [
        "joint",
        ">×",
        "motion",
        ">samples",
        ">peak torque [N*m]",
        ">rms torque [N*m]",
        ">peak speed [rad/s]",
        "ratio",
        "aim",
        "limits",
    ];
    let mut table = Table::new("What each joint asks for", &header);
    let each = joints.iter().flat_map(|joint| joint.own_motions().into_iter().map(move |(name, m)| (joint, name, m)));
    for (joint, of, m) in each {
        let name = if of.is_empty() { joint.name.clone() } else { format!("{}: {of}", joint.name) };
        let largest = |of: &[f64]| number(of.iter().fold(0.0_f64, |most, v| most.max(v.abs())));
        let rms = || number(m.mean(|k| m.torque[k].powi(2)).sqrt());
        let course = match m.course {
            Course::Periodic(period) => format!("repeats every {} s", number(period)),
            Course::Once(lasts) => match m.repeat_every {
                Some(every) => format!("{} s, again every {} s", number(lasts), number(every)),
                None => format!("once, {} s", number(lasts)),
            },
            Course::Points(Some(lasts)) => format!("operating points, {} s", number(lasts)),
            Course::Points(None) => "operating points without durations".into(),
            Course::Cases => {
                let cases = m.cases.iter().flat_map(|cases| &cases.list);
                let one =
                    |case: &gearwise_model::motion::Case| format!("{} {} %", case.name, number(100.0 * case.share));
                format!("load cases: {}", cases.map(one).collect::<Vec<_>>().join(", "))
            }
        };
        // Points that have no durations have no mean over time.
        let rms = if m.has_durations() { rms() } else { "–".into() };
        table.rows.push(super::Row {
            cells: vec![
                name,
                joint.count.to_string(),
                course,
                m.given.len().to_string(),
                largest(&m.torque),
                rms,
                largest(&m.velocity),
                ratio_text(joint).trim_start_matches("ratio ").to_string() + &through(joint),
                joint.aim(),
                limits(joint),
            ],
            ..super::Row::default()
        });
    }
    table
}

/// The ratio of what is between actuator and joint, behind that of the gear.
fn through(joint: &Joint) -> String {
    let Some(passed) = joint.passed.as_deref() else { return String::new() };
    match (passed.constant(), passed.ratio()) {
        (Some(ratio), _) => format!(", then {}", number(ratio)),
        (None, Some(range)) => format!(", then {} to {}", number(range.least.0), number(range.most.0)),
        (None, None) => format!(", then a {}", passed.word()),
    }
}

/// What a choice for the joint must keep, beyond what data sheets say.
fn limits(joint: &Joint) -> String {
    let l = &joint.limits;
    let mut all: Vec<String> = Vec::new();
    all.extend(l.actuator_mass.map(|m| format!("mass ≤ {} kg", number(m))));
    all.extend(l.reflected_inertia.map(|j| format!("reflected inertia ≤ {} kg·m²", number(j))));
    let bandwidth = |b: gearwise_model::requirement::TorqueBandwidth| {
        format!("{} N·m more at {} Hz", number(b.amplitude), number(b.frequency))
    };
    all.extend(l.torque_bandwidth.map(bandwidth));
    all.extend(l.winding_temperature.map(|t| format!("winding ≤ {} °C", number(in_unit(t, "degC")))));
    all.extend(l.shock_torque.map(|t| format!("shocks of {} N·m", number(t))));
    all.extend(l.life.map(|s| format!("gear life ≥ {} h (L10)", number(in_unit(s, "h")))));
    all.extend(l.max_backlash.map(|a| format!("backlash ≤ {} arcmin", number(in_unit(a, "arcmin")))));
    all.extend(l.min_stiffness.map(|k| format!("stiffness of the gear ≥ {} N·m/rad", number(k))));
    all.extend(l.max_backdriving_torque.map(|t| format!("backdriving torque ≤ {} N·m", number(t))));
    if l.temperature_reserve > 0.0 {
        all.push(format!("{} K below the highest winding temperature", number(l.temperature_reserve)));
    }
    all.extend(l.mount_resistance.map(|r| format!("{} K/W from housing to ambient as mounted", number(r))));
    all.extend(joint.drive_current.map(|i| format!("drive ≤ {} A", number(i))));
    if l.safety != 1.0 {
        all.push(format!("safety {} on peaks", number(l.safety)));
    }
    // A reserve that all limits have is said once.
    let mut shares: Vec<(f64, Vec<&str>)> = Vec::new();
    for (name, share) in &l.reserves {
        match shares.iter_mut().find(|(s, _)| s == share) {
            Some((_, names)) => names.push(name),
            None => shares.push((*share, vec![name])),
        }
    }
    for (share, names) in shares {
        let of = if names.len() > 3 { counted(names.len(), "limit") } else { names.join(", ") };
        all.push(format!("{} % of {of} in reserve", number(100.0 * share)));
    }
    all.extend(l.spring.as_ref().map(|_| "a parallel spring is chosen too".to_string()));
    let filter =
        |word: &str, patterns: &[String]| (!patterns.is_empty()).then(|| format!("{word} {}", patterns.join(", ")));
    all.extend(filter("only motors", &joint.motors.allowed));
    all.extend(filter("no motors", &joint.motors.excluded));
    if all.is_empty() { "those of data sheets and bus".into() } else { all.join("; ") }
}
