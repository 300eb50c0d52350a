//! Joint torques of a trajectory: what each joint asks, what carries what, and motion files for requirements.

use std::collections::HashSet;

use super::table::{Column, Table, paragraph};
use super::{counted, csv_number, number, optional};
use gearwise_model::mechanism::torques::{Carried, Torques};
use gearwise_model::mechanism::trajectory::Trajectory;
use gearwise_model::mechanism::{Joint, Mechanism, Motion as Degree};
use gearwise_model::requirement::{Course, Driven, Motion, Robot};

/// What the command found.
#[derive(Debug)]
pub struct Answer<'a> {
    /// The robot.
    pub mechanism: &'a Mechanism,
    /// What it does.
    pub trajectory: &'a Trajectory,
    /// What its joints ask for that.
    pub torques: &'a Torques,
    /// What the actuators' masses add.
    pub carried: Vec<Carried>,
    /// What was left aside or exceeded.
    pub notes: Vec<String>,
    /// Numbers of the joints to show.
    pub shown: Vec<usize>,
}

/// Peaks and means of one joint. SI.
pub(super) struct Row<'a> {
    pub(super) joint: &'a Joint,
    pub(super) peak: f64,
    pub(super) peak_at: usize,
    pub(super) rms: f64,
    pub(super) speed: f64,
    pub(super) mean_power: f64,
    pub(super) peak_power: f64,
    pub(super) motion: Motion,
    pub(super) worst: Option<&'a Carried>,
}

impl<'a> Answer<'a> {
    pub(super) fn rows(&'a self) -> Vec<Row<'a>> {
        self.shown.iter().filter_map(|j| Some(self.row(*j, self.mechanism.joints().nth(*j)?))).collect()
    }

    fn row(&'a self, number: usize, joint: &'a Joint) -> Row<'a> {
        let motion = self.torques.motion(self.trajectory, number);
        let mut peak_at = 0;
        for (k, t) in motion.torque.iter().enumerate() {
            if t.abs() > motion.torque[peak_at].abs() {
                peak_at = k;
            }
        }
        let power = |k: usize| motion.torque[k] * motion.velocity[k];
        let of = |c: &&Carried| c.carrying == number;
        Row {
            joint,
            peak: motion.torque[peak_at],
            peak_at,
            rms: motion.mean(|k| motion.torque[k].powi(2)).sqrt(),
            speed: motion.velocity.iter().fold(0.0, |a, v| a.max(v.abs())),
            mean_power: motion.mean(power),
            peak_power: (0..motion.len()).map(power).fold(f64::NEG_INFINITY, f64::max),
            worst: self.carried.iter().filter(of).max_by(|a, b| a.largest().abs().total_cmp(&b.largest().abs())),
            motion,
        }
    }

    pub(super) fn name(&self, joint: usize) -> &str {
        self.mechanism.joints().nth(joint).map_or("", |j| j.name.as_str())
    }
}

/// For people.
pub fn text(answer: &Answer) -> String {
    let trajectory = answer.trajectory;
    let course = match trajectory.course {
        Course::Periodic(period) => format!("repeating every {} s", number(period)),
        Course::Once(duration) => format!("once, {} s", number(duration)),
        Course::Points(_) | Course::Cases => String::new(),
    };
    let heading = format!(
        "{}: {}, {} kg with payload, {}, {course}",
        answer.mechanism.name,
        counted(answer.mechanism.moving().len(), "joint"),
        number(answer.mechanism.mass()),
        counted(trajectory.len(), "sample")
    );
    let mut out = format!("{}\n", paragraph(&heading, 0, 2));
    let rows = answer.rows();
    let slides = rows.iter().any(|row| row.joint.motion == Degree::Slides);
    let (torque, speed, each) =
        if slides { ("N*m, N", "rad/s, m/s", "N*m/kg, N/kg") } else { ("N*m", "rad/s", "N*m/kg") };
    let columns = vec![
        Column::name("joint"),
        Column::number("peak torque", torque),
        Column::number("at t", "s").dropped(5),
        Column::number("rms torque", torque),
        Column::number("peak speed", speed),
        Column::number("mean power", "W").dropped(4),
        Column::number("peak power", "W").dropped(6),
        Column::number("per kg carried", each).dropped(3),
        Column::name("worst placed\nactuator").dropped(2),
        Column::number("at t", "s").dropped(1),
    ];
    let largest = answer.carried.iter().fold(0.0_f64, |a, c| a.max(c.largest().abs()));
    let rows = rows.iter().map(|row| {
        let felt = row.worst.filter(|c| rounded(c.largest(), largest) != 0.0);
        vec![
            row.joint.name.clone(),
            number(row.peak),
            number(trajectory.time[row.peak_at]),
            number(row.rms),
            number(row.speed),
            number(rounded(row.mean_power, row.peak_power)),
            number(row.peak_power),
            optional(row.worst.map(|c| rounded(c.largest(), largest))),
            row.worst.map_or_else(
                || "carries none".into(),
                |c| felt.map_or_else(|| "feels none".into(), |_| answer.name(c.actuator).to_string()),
            ),
            felt.map_or_else(|| "–".into(), |c| number(trajectory.time[c.worst()])),
        ]
    });
    out.push_str(&Table::new(columns).also_in("`--json`").rows(rows).text());
    out.push('\n');
    for note in ABOUT.iter().copied().chain(answer.notes.iter().map(String::as_str)) {
        out.push_str(&paragraph(note, 2, 2));
    }
    out
}

/// What the numbers are and are not.
const ABOUT: [&str; 2] = [
    "Torque is the load's, without the rotor: the motor that is chosen brings its own inertia, N^2 (J_m + J_g). The \
     rotors' gyroscopic torques and their reaction on other joints are neglected.",
    "Per kg carried: what one kilogram more of the worst placed actuator adds to this joint's torque; each actuator \
     sits at its joint, on the link that the joint hangs on. The masses of the description stay as they are: where \
     they contain motors already, only the difference in mass counts.",
];

/// What was done with the description that a requirement names, and what its joints carry.
pub(super) fn driven_text(driven: &Driven, robot: &Robot) -> String {
    let mut lines = vec![format!("Torques by inverse dynamics of `{}`. {}", driven.model, ABOUT[0])];
    lines.extend(driven.notes.iter().cloned());
    let mut carries: Vec<String> = Vec::new();
    for (j, joint) in robot.joints.iter().enumerate() {
        let of = driven.carried.iter().filter(|c| c.carrying == j);
        let Some(worst) = of.max_by(|a, b| a.largest().abs().total_cmp(&b.largest().abs())) else { continue };
        if worst.largest().abs() > 1e-9 {
            let size = number(worst.largest().abs());
            carries.push(format!("{} {size} N*m/kg of {}", joint.name, robot.joints[worst.actuator].name));
        }
    }
    if !carries.is_empty() {
        let counted = if driven.separate {
            "The description leaves the actuators out: their masses load the joints in the choice of the whole robot, not in the tables of single joints."
        } else {
            "The masses of the description are taken to contain the actuators; where they do not, say `actuators = \"separate\"` under [mechanism]."
        };
        lines.push(format!("Actuators carry actuators, at most: {}. {counted}", carries.join(", ")));
    }
    lines.iter().map(|line| paragraph(line, 2, 4)).collect()
}

/// Zero where only rounding is left.
fn rounded(value: f64, size: f64) -> f64 {
    if value.abs() <= 1e-9 * size.abs() { 0.0 } else { value }
}

/// As rows: every sample, torque, speed and position of every joint.
pub fn csv(answer: &Answer) -> String {
    let rows = answer.rows();
    let mut header = vec!["time [s]".to_string()];
    for row in &rows {
        let (name, position, effort) = (&row.joint.name, row.joint.position_unit(), row.joint.effort_unit());
        header
            .push(format!("{name}.{} [{effort}]", if row.joint.motion == Degree::Turns { "torque" } else { "force" }));
        header.push(format!("{name}.velocity [{position}/s]"));
        header.push(format!("{name} [{position}]"));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let lines = (0..answer.trajectory.len()).map(|k| {
        let mut line = vec![csv_number(Some(answer.trajectory.time[k]))];
        for (row, j) in rows.iter().zip(&answer.shown) {
            let position = answer.trajectory.position[*j][k];
            line.extend([row.motion.torque[k], row.motion.velocity[k], position].map(|v| csv_number(Some(v))));
        }
        line
    });
    super::csv_text(&header, lines)
}

/// Motion files for requirements, one per joint that turns (of one that slides, its force), and the
/// coefficients of carried actuators. Names and contents.
pub fn files(answer: &Answer) -> Vec<(String, String)> {
    let mut taken = HashSet::from(["torque_per_mass.csv".to_string()]);
    let mut files = Vec::new();
    for (row, j) in answer.rows().iter().zip(&answer.shown) {
        let mut name = format!("{}.csv", file_name(&row.joint.name));
        while !taken.insert(name.clone()) {
            name = format!("_{name}");
        }
        files.push((name, motion_file(answer, row, *j)));
    }
    files.push(("torque_per_mass.csv".into(), carried_file(answer)));
    files
}

/// A joint's name without what could leave the folder or trouble a shell.
fn file_name(joint: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = joint.chars().map(safe).take(100).collect();
    if name.starts_with('.') || name.is_empty() { format!("_{name}") } else { name }
}

fn motion_file(answer: &Answer, row: &Row, number: usize) -> String {
    let (effort, unit) = (row.joint.effort_unit(), row.joint.position_unit());
    let what = if row.joint.motion == Degree::Turns { "torque" } else { "force" };
    let mut header = vec![
        "time [s]".to_string(),
        format!("{what} [{effort}]"),
        format!("velocity [{unit}/s]"),
        format!("position [{unit}]"),
    ];
    // Rates that are the spline's are left to it: a file that gives them says nothing of what lies between its
    // rows. Friction jumps where no spline does.
    let torques = &answer.torques;
    let by_spline = !answer.trajectory.gives_acceleration[number] && torques.torque[number] == torques.smooth[number];
    if !by_spline {
        header.extend([format!("acceleration [{unit}/s^2]"), format!("{what}_rate [{effort}/s]")]);
    }
    let columns = header.len() - 1;
    let motion = &row.motion;
    let position = &answer.trajectory.position[number];
    let line = |k: usize, time: f64| {
        let values = [motion.torque[k], motion.velocity[k], position[k], motion.acceleration[k], motion.torque_rate[k]];
        std::iter::once(time).chain(values.into_iter().take(columns)).map(|v| csv_number(Some(v))).collect::<Vec<_>>()
    };
    let mut lines: Vec<Vec<String>> = motion.time.iter().enumerate().map(|(k, t)| line(k, *t)).collect();
    if let Course::Periodic(period) = motion.course {
        lines.push(line(0, motion.time[0] + period));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    super::csv_text(&header, lines)
}

fn carried_file(answer: &Answer) -> String {
    let pairs: Vec<&Carried> = answer.carried.iter().filter(|c| answer.shown.contains(&c.carrying)).collect();
    let mut header = vec!["time [s]".to_string()];
    for pair in &pairs {
        let unit = answer.mechanism.joints().nth(pair.carrying).map_or("N*m", Joint::effort_unit);
        header.push(format!(
            "{} per mass of the actuator of {} [{unit}/kg]",
            answer.name(pair.carrying),
            answer.name(pair.actuator)
        ));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let line = |k: usize| {
        let values = pairs.iter().map(|pair| csv_number(Some(pair.coefficients[k])));
        std::iter::once(csv_number(Some(answer.trajectory.time[k]))).chain(values).collect::<Vec<_>>()
    };
    super::csv_text(&header, (0..answer.trajectory.len()).map(line))
}
