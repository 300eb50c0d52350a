//! Motion files: CSV to a motion, every mistake with its place.

use std::sync::Arc;

use super::{Course, Motion, Samples};
use crate::input::csv::{Column, Content, Table};
use crate::input::kind::{self, FileKind};
use crate::input::{InputError, Problem, Range, Source};
use crate::numerics::spline;
use crate::units;

/// Reads a motion file.
///
/// # Errors
/// Every mistake of the file: columns, units, cells, order of time, too few rows, and a periodic
/// motion whose last row does not repeat the first.
pub fn read(source: &Arc<Source>, periodic: bool, period: Option<f64>) -> Result<Motion, InputError> {
    read_carrying(source, periodic, period, &[]).map(|(motion, _)| motion)
}

/// A column of torque per mass: joint, values \[N·m/kg\], rates \[N·m/(kg·s)\].
pub type CarriedColumn = (String, Vec<f64>, Vec<f64>);

/// Name of a column of torque per mass, without the joint's name.
const TORQUE_PER_MASS: &str = "torque_per_mass_";

/// As [`read`], with what carried actuators ask at each sample: a column `torque_per_mass_NAME [N*m/kg]` for
/// any of `joints`, with its rate.
///
/// # Errors
/// As [`read`].
pub fn read_carrying(
    source: &Arc<Source>,
    periodic: bool,
    period: Option<f64>,
    joints: &[String],
) -> Result<(Motion, Vec<CarriedColumn>), InputError> {
    let mut problems = Vec::new();
    let read = read_samples(source, periodic, period, joints, &mut problems);
    let wanted = [FileKind::Motion, FileKind::OverTime, FileKind::Table, FileKind::Empty];
    InputError::unless_empty(source, problems).map_err(|error| kind::instead(error, &wanted))?;
    let (motion, carried) = read.expect("a motion without problems was read");
    let with_rate = |(name, values): (String, Vec<f64>)| {
        let (values, rates) = motion.at_every_sample(&values[..motion.given.len()]);
        (name, values, rates)
    };
    let carried = carried.into_iter().map(with_rate).collect();
    Ok((motion, carried))
}

/// A column of torque per mass: the joint that is carried, and the values \[N·m/kg\].
type Named = (String, Vec<f64>);

/// Whether a motion has a column of torque per mass, or one that could be meant for it.
pub(crate) fn may_carry(source: &Source) -> bool {
    let header = source.text().lines().find(|line| !line.starts_with('#') && !line.trim().is_empty());
    header.is_some_and(|header| header.contains("mass"))
}

/// The columns that every motion may have: name, kind, whether it must be there, and what it is.
pub const OWN_COLUMNS: &[(&str, &units::Kind, bool, &str)] = &[
    ("time", &units::TIME, true, "increasing"),
    ("torque", &units::TORQUE, true, "that the load needs, at the output"),
    ("velocity", &units::SPEED, false, "at the output"),
    ("position", &units::ANGLE, false, "at the output; a spring needs it"),
    ("acceleration", &units::ACCELERATION, false, "at the output"),
    ("torque_rate", &units::TORQUE_RATE, false, "dτ/dt"),
    ("jerk", &units::JERK, false, "dα/dt"),
];

/// The columns that a motion may have, with those for actuators of `joints` that are carried.
pub fn columns(joints: &[String]) -> Vec<Column> {
    let column = |name: &str, kind, required| Column {
        name: name.into(),
        content: Content::Quantity(kind, Range::Any),
        required,
    };
    let carried = joints.iter().map(|j| column(&format!("{TORQUE_PER_MASS}{j}"), &units::TORQUE_PER_MASS, false));
    let own = OWN_COLUMNS.iter().map(|(name, kind, required, _)| column(name, *kind, *required));
    own.chain(carried).collect()
}

fn read_samples(
    source: &Arc<Source>,
    periodic: bool,
    period: Option<f64>,
    joints: &[String],
    problems: &mut Vec<Problem>,
) -> Option<(Motion, Vec<Named>)> {
    let table = Table::read(source, columns(joints), problems)?;
    let mut read = |name: &str| table.whole_column(name, "a motion has no gaps", problems);
    let mut samples = Samples {
        time: read("time")?,
        torque: read("torque")?,
        velocity: read("velocity"),
        position: read("position"),
        acceleration: read("acceleration"),
        torque_rate: read("torque_rate"),
        jerk: read("jerk"),
    };
    let column = |name: &String| Some((name.clone(), read(&format!("{TORQUE_PER_MASS}{name}"))?));
    let carried: Vec<(String, Vec<f64>)> = joints.iter().filter_map(column).collect();
    if samples.velocity.is_none() && samples.position.is_none() {
        problems.push(
            Problem::at(0..0, "a motion needs a column `velocity` or `position`", "neither is in the header")
                .help("for example `velocity [rad/s]`"),
        );
    }
    if !problems.is_empty() {
        return None;
    }
    if !check_time(&table, &samples.time, problems) {
        return None;
    }
    let course = take_course(&table, &mut samples, &carried, periodic, period, problems)?;
    if !check_length(&table, samples.time.len(), periodic, period, problems) {
        return None;
    }
    if let Some(problem) = contradiction(&table, &samples) {
        problems.push(problem);
        return None;
    }
    Some((Motion::from_samples(samples, course), carried))
}

/// A column that is not the rate of another one given beside it: a wrong unit, sign or column.
fn contradiction(table: &impl Rows, samples: &Samples) -> Option<Problem> {
    let Samples { time, torque, position, velocity, acceleration, torque_rate, jerk } = samples;
    let differs = |worst: usize, [rate, of]: [&str; 2]| {
        table.problem(worst, rate, format!("{rate} is not the rate of {of}"), "differs most here".into())
    };
    if let (Some(position), Some(velocity)) = (position, velocity)
        && let Some(worst) = disagreement(time, position, velocity)
    {
        return Some(differs(worst, ["velocity", "position"]).help(
            "deg for rad, rpm for rad/s, a wrong sign, or the wrong column? Leave position out if it is not needed",
        ));
    }
    let pairs = [
        (["acceleration", "velocity"], velocity.as_ref(), acceleration),
        (["jerk", "acceleration"], acceleration.as_ref(), jerk),
        (["torque_rate", "torque"], Some(torque), torque_rate),
    ];
    pairs.into_iter().find_map(|(names, of, rate)| {
        let worst = scaled_rate(time, of?, rate.as_ref()?)?;
        let help = format!("a wrong unit or a wrong sign? Leave {} out: it is computed from {}", names[0], names[1]);
        Some(differs(worst, names).help(help))
    })
}

/// Correlation from which two signals are proportional.
const SAME_COURSE: f64 = 0.9;
/// Factor within which measured rates agree.
const SAME_SIZE: f64 = 2.0;
/// Fewest samples for a correlation.
const SAMPLES: usize = 12;

/// The sample at which a rate differs most from the finite differences of its signal, where the two are proportional with another
/// sign or a factor far from one. Noise in either lowers their correlation, and nothing is claimed.
fn scaled_rate(time: &[f64], of: &[f64], rate: &[f64]) -> Option<usize> {
    let pair = |k: usize| [(of[k] - of[k - 1]) / (time[k] - time[k - 1]), 0.5 * (rate[k] + rate[k - 1])];
    let pairs = || (1..of.len()).map(pair);
    let sum = |product: fn([f64; 2]) -> f64| pairs().map(product).sum::<f64>();
    let (size, other) = (sum(|[a, _]| a * a).sqrt(), sum(|[_, b]| b * b).sqrt());
    let correlation = sum(|[a, b]| a * b) / (size * other);
    let is_scaled = !(1.0 / SAME_SIZE..=SAME_SIZE).contains(&(other / size));
    let apart = |k: &usize| (pair(*k)[0] - pair(*k)[1]).abs();
    (of.len() >= SAMPLES && (correlation < -SAME_COURSE || (correlation > SAME_COURSE && is_scaled)))
        .then(|| (1..of.len()).max_by(|a, b| apart(a).total_cmp(&apart(b))))
        .flatten()
}

/// The sample at which velocity differs most from the rate of position, where the two do not belong together.
pub(crate) fn disagreement(time: &[f64], position: &[f64], velocity: &[f64]) -> Option<usize> {
    let (mut apart, mut size, mut worst) = (0.0, 0.0, (0.0, 0));
    for k in 1..position.len() {
        let rate = (position[k] - position[k - 1]) / (time[k] - time[k - 1]);
        let mean = 0.5 * (velocity[k] + velocity[k - 1]);
        apart += (rate - mean).powi(2);
        size += rate.powi(2).max(mean.powi(2));
        if (rate - mean).abs() > worst.0 {
            worst = ((rate - mean).abs(), k);
        }
    }
    (apart > 0.25 * size).then_some(worst.1)
}

/// Samples of which something may be wrong: rows of a table, or entries of arrays.
pub(crate) trait Rows {
    /// How many there are.
    fn count(&self) -> usize;
    /// A problem with one value of a sample.
    fn problem(&self, row: usize, column: &str, message: String, label: String) -> Problem;
    /// A problem with all of them, which is shown at the last.
    fn last(&self, message: String, label: String) -> Problem;
}

impl Rows for Table {
    fn count(&self) -> usize {
        self.len()
    }

    fn problem(&self, row: usize, column: &str, message: String, label: String) -> Problem {
        Problem::at(self.cell_span(row, column), message, label)
    }

    fn last(&self, message: String, label: String) -> Problem {
        Problem::at(self.row_span(self.len() - 1), message, label)
    }
}

/// Arrays of so many entries.
struct Arrays(usize);

impl Rows for Arrays {
    fn count(&self) -> usize {
        self.0
    }

    fn problem(&self, row: usize, column: &str, message: String, label: String) -> Problem {
        Problem { label, ..Problem::whole(format!("`{column}`, sample {row}: {message}")) }
    }

    fn last(&self, message: String, label: String) -> Problem {
        Problem { label, ..Problem::whole(message) }
    }
}

/// A motion from arrays of a program, by the rules of a file.
///
/// # Errors
/// Every mistake: arrays of other lengths, numbers that are none, order of time, too few samples, and a periodic motion
/// whose last sample does not repeat the first. Samples are counted from zero.
pub fn of_arrays(mut samples: Samples, periodic: bool, period: Option<f64>) -> Result<Motion, InputError> {
    let mut problems = Vec::new();
    let read = checked_arrays(&mut samples, periodic, period, &mut problems);
    InputError::unless_empty(&Arc::new(Source::of_values("the motion", "")), problems)?;
    let course = read.expect("a motion without problems was read");
    Ok(Motion::from_samples(samples, course))
}

/// That arrays have one length, and numbers in them; that there is enough to say what the speed is.
pub(super) fn check_samples(samples: &Samples, problems: &mut Vec<Problem>) {
    let count = samples.time.len();
    let columns = {
        let Samples { time, torque, position, velocity, acceleration, torque_rate, jerk } = samples;
        let own = [("time", Some(time)), ("torque", Some(torque))];
        let more = [
            ("position", position.as_ref()),
            ("velocity", velocity.as_ref()),
            ("acceleration", acceleration.as_ref()),
            ("torque_rate", torque_rate.as_ref()),
            ("jerk", jerk.as_ref()),
        ];
        own.into_iter().chain(more).filter_map(|(name, values)| Some((name, values?)))
    };
    for (name, values) in columns {
        if values.len() != count {
            let message = format!("`{name}` has {} entries, and `time` has {count}", values.len());
            problems.push(Problem::whole(message));
        }
        if let Some(row) = values.iter().position(|value| !value.is_finite() || !units::is_sane(*value)) {
            let message = format!("{} is no number of a motion", values[row]);
            problems.push(Arrays(count).problem(row, name, message, "expected a finite number in SI".into()));
        }
    }
    if samples.velocity.is_none() && samples.position.is_none() {
        problems.push(Problem::whole("a motion needs `velocity` or `position`"));
    }
    if count == 0 {
        problems.push(Problem::whole("the motion has no samples"));
    }
}

/// That time increases in arrays, and that there are enough samples for the spline.
pub(super) fn time_order(samples: &Samples, problems: &mut Vec<Problem>) {
    let rows = Arrays(samples.time.len());
    if check_time(&rows, &samples.time, problems) {
        check_length(&rows, samples.time.len(), false, None, problems);
    }
}

fn checked_arrays(
    samples: &mut Samples,
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> Option<Course> {
    check_samples(samples, problems);
    if let Some(period) = period.filter(|period| !(period.is_finite() && *period > 0.0)) {
        problems.push(Problem::whole(format!("a period of {period} s is not greater than zero")));
    }
    if period.is_some() && !periodic {
        problems.push(Problem::whole("`period` says nothing of a motion that happens once"));
    }
    let rows = Arrays(samples.time.len());
    if !problems.is_empty() || !check_time(&rows, &samples.time, problems) {
        return None;
    }
    let course = take_course(&rows, samples, &[], periodic, period, problems)?;
    if !check_length(&rows, samples.time.len(), periodic, period, problems) {
        return None;
    }
    if let Some(problem) = contradiction(&rows, samples) {
        problems.push(problem);
        return None;
    }
    Some(course)
}

/// Whether time increases from row to row, by enough to differentiate; if not, notes where.
pub(crate) fn check_time(table: &impl Rows, time: &[f64], problems: &mut Vec<Problem>) -> bool {
    let wrong: Vec<usize> = (1..time.len()).filter(|row| time[*row] <= time[row - 1]).collect();
    if let Some(row) = wrong.first() {
        let message = match wrong.len() {
            1 => "time does not increase".into(),
            2 => "time does not increase, here and in another row".into(),
            rows => format!("time does not increase, here and in {} other rows", rows - 1),
        };
        let label = format!("not later than the row above, {} s", time[row - 1]);
        let problem = table.problem(*row, "time", message, label);
        problems.push(problem.help("sort the rows by time and remove duplicates"));
        return false;
    }
    let duration = time[time.len().max(1) - 1] - time[0];
    for row in 1..time.len() {
        if time[row] - time[row - 1] < 1e-9 * duration {
            let what = "two rows are at practically the same time: no derivative can be taken";
            let label = "less than 1e-9 of the motion after the row above";
            problems.push(table.problem(row, "time", what.into(), label.into()));
            return false;
        }
    }
    true
}

/// Whether there are enough samples for the spline; if not, notes it.
pub(crate) fn check_length(
    table: &impl Rows,
    distinct: usize,
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> bool {
    let fewest = if periodic { spline::MIN_PERIODIC } else { spline::MIN_OPEN };
    if distinct < fewest {
        problems.push(table.last(
            format!("the motion has {distinct} distinct samples: too few to differentiate"),
            format!("expected at least {}", if periodic && period.is_none() { fewest + 1 } else { fewest }),
        ));
    }
    distinct >= fewest
}

/// Whether the last value is the first again, but for the digits of a table.
pub(crate) fn repeats(values: &[f64]) -> bool {
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    (values[values.len() - 1] - values[0]).abs() <= 1e-4 * (high - low)
}

/// The course of a table, and whether its last row is the first again. Each of `columns` has to repeat its
/// first value at the end of the period.
pub(crate) fn course(
    table: &impl Rows,
    time: &[f64],
    columns: &[(&str, &[f64])],
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> Option<(Course, bool)> {
    let last = table.count().checked_sub(1)?;
    let duration = time[last] - time[0];
    if !periodic {
        return Some((Course::Once(duration), false));
    }
    if let Some(period) = period {
        if period < duration * (1.0 - 1e-12) {
            problems.push(table.problem(
                last,
                "time",
                format!("the motion lasts {duration} s, longer than its period of {period} s"),
                "after the end of the period".into(),
            ));
            return None;
        }
        if period > duration * (1.0 + 1e-9) {
            return Some((Course::Periodic(period), false));
        }
    }
    let before = problems.len();
    for (name, values) in columns {
        if !repeats(values) {
            problems.push(
                table
                    .problem(
                        last,
                        name,
                        format!("a periodic motion repeats its first row at the end, but `{name}` does not"),
                        "differs from the first row".into(),
                    )
                    .help(
                        "add the first row again at the end of the period, or give `period`, or set `periodic = false`",
                    ),
            );
        }
    }
    (problems.len() == before).then_some((Course::Periodic(duration), true))
}

/// Finds the period, and takes the repeated last row of a periodic motion away.
fn take_course(
    table: &impl Rows,
    samples: &mut Samples,
    carried: &[Named],
    periodic: bool,
    period: Option<f64>,
    problems: &mut Vec<Problem>,
) -> Option<Course> {
    let names: [(&str, Option<&Vec<f64>>); 6] = [
        ("torque", Some(&samples.torque)),
        ("position", samples.position.as_ref().filter(|_| samples.velocity.is_none())),
        ("velocity", samples.velocity.as_ref()),
        ("acceleration", samples.acceleration.as_ref()),
        ("torque_rate", samples.torque_rate.as_ref()),
        ("jerk", samples.jerk.as_ref()),
    ];
    let named: Vec<String> = carried.iter().map(|(joint, _)| format!("{TORQUE_PER_MASS}{joint}")).collect();
    let own = names.iter().filter_map(|(n, v)| Some((*n, v.as_ref()?.as_slice())));
    let more = named.iter().zip(carried).map(|(name, (_, values))| (name.as_str(), values.as_slice()));
    let columns: Vec<(&str, &[f64])> = own.chain(more).collect();
    let (course, last_is_first) = course(table, &samples.time, &columns, periodic, period, problems)?;
    if !last_is_first {
        return Some(course);
    }
    // Beside a velocity the position is only for a spring, which must find its start again: a wheel's is none.
    if samples.position.as_ref().is_some_and(|q| !repeats(q)) {
        samples.position = None;
    }
    samples.time.pop();
    samples.torque.pop();
    let Samples { position, velocity, acceleration, torque_rate, jerk, .. } = samples;
    for values in [position, velocity, acceleration, torque_rate, jerk].into_iter().flatten() {
        values.pop();
    }
    Some(course)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn source(text: &str) -> Arc<Source> {
        Arc::new(Source::new("motion.csv", text))
    }

    /// 40 samples of a sine in speed and torque; rates by a factor, and with noise on both.
    fn beside(acceleration: f64, torque_rate: f64, noise: f64) -> Option<Problem> {
        let (mut generator, count) = (0_u64, 40);
        let mut noise = || {
            generator = generator.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            noise * ((generator >> 11) as f64 * 2.0_f64.powi(-52) - 1.0)
        };
        let time: Vec<f64> = (0..count).map(|k| 0.025 * f64::from(k)).collect();
        let mut of = |size: f64, at: fn(f64) -> f64| -> Vec<f64> {
            time.iter().map(|t| size * at(std::f64::consts::TAU * t) + noise()).collect()
        };
        let samples = Samples {
            torque: of(1.0, f64::sin),
            velocity: Some(of(1.0, f64::sin)),
            acceleration: Some(of(acceleration * std::f64::consts::TAU, f64::cos)),
            torque_rate: Some(of(torque_rate * std::f64::consts::TAU, f64::cos)),
            time: time.clone(),
            ..Samples::default()
        };
        contradiction(&Arrays(count as usize), &samples)
    }

    #[test]
    fn a_rate_of_another_size_or_sign_is_refused_and_noise_is_not() {
        for factor in [57.3, 1.0 / 57.3, -1.0, -0.3, 3.0] {
            let [own, other] =
                [beside(factor, 1.0, 1e-4), beside(1.0, factor, 1e-4)].map(|found| found.unwrap().message);
            assert!(own.contains("acceleration is not the rate of velocity"), "{own}");
            assert!(other.contains("torque_rate is not the rate of torque"), "{other}");
        }
        for (factor, noise) in [(1.0, 0.0), (0.8, 0.01), (1.3, 0.01), (1.0, 0.3), (1.0, 5.0)] {
            assert!(beside(factor, factor, noise).is_none(), "{factor} {noise}");
        }
    }

    #[test]
    fn weights_are_those_of_the_trapezoid_rule() {
        let text = "time [s],torque [N*m],velocity [rad/s],acceleration [rad/s^2]\n\
                    0,1,0,0\n0.1,2,0,0\n0.4,3,1,0\n1,1,0,0\n";
        let motion = read(&source(text), true, None).unwrap();
        assert_eq!(motion.len(), 3);
        assert_relative_eq!(motion.weight.iter().sum::<f64>(), 1.0, max_relative = 1e-14);
        // By hand: 0.1·1.5 + 0.3·2.5 + 0.6·2 = 2.1
        assert_relative_eq!(motion.mean(|k| motion.torque[k]), 2.1, max_relative = 1e-12);
        assert_eq!(motion.dwell, vec![0.05, 0.05, 0.0]);
        assert_eq!(motion.derived, vec!["jerk", "torque_rate"]);
    }

    #[test]
    fn a_motion_that_does_not_close_is_refused() {
        let text = "time [s],torque [N*m],velocity [rad/s]\n0,1,0\n0.1,2,0\n0.4,3,1\n1,1.5,0\n";
        assert!(read(&source(text), true, None).is_err());
        assert!(read(&source(text), false, None).is_ok());
        assert_eq!(read(&source(text), true, Some(1.5)).unwrap().given.len(), 4);
    }
}
