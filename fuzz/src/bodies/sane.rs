//! What every answer of a reader keeps: mistakes are told with their place, and numbers are numbers.

use gearwise::input::InputError;
use gearwise::requirement::{Course, Motion, RatioChoice, Robot};

/// The largest report of one file that a person could still be shown \[bytes\].
const LONGEST: usize = 1 << 20;

/// Mistakes are told: file and line of each are in a report that prints, and that cannot drive a terminal.
pub fn told(errors: &[InputError]) {
    assert!(!errors.is_empty(), "refused without a reason");
    for error in errors {
        assert!(!error.problems.is_empty(), "refused without a problem");
        let report = error.to_string();
        let name = error.source.name();
        assert!(report.contains(name), "the report does not name {name}:\n{report}");
        assert!(report.len() < LONGEST, "a report of {} bytes", report.len());
        for problem in error.problems.iter().take(50) {
            assert!(!problem.message.is_empty());
            let Some(span) = &problem.span else { continue };
            assert!(span.start <= span.end && span.end <= error.source.text().len(), "{problem:?} lies outside");
            let (line, _) = error.source.position(span.start);
            assert!(report.contains(&format!("{name}:{line}:")), "line {line} of {problem:?} is not in\n{report}");
        }
        let driving = report.chars().find(|c| c.is_control() && *c != '\n');
        assert!(driving.is_none(), "{driving:?} is in the report\n{report:?}");
    }
}

/// The value, or nothing where it was refused in good order.
pub fn accepted<T>(result: Result<T, Vec<InputError>>) -> Option<T> {
    result.map_err(|errors| told(&errors)).ok()
}

/// As [`accepted`], for a single file.
pub fn accepted_one<T>(result: Result<T, InputError>) -> Option<T> {
    accepted(result.map_err(|e| vec![e]))
}

pub fn finite(what: &str, values: impl IntoIterator<Item = f64>) {
    for value in values {
        assert!(value.is_finite(), "{what} is {value}");
    }
}

pub fn positive(what: &str, values: impl IntoIterator<Item = f64>) {
    for value in values {
        assert!(value.is_finite() && value > 0.0, "{what} is {value}");
    }
}

pub fn not_negative(what: &str, values: impl IntoIterator<Item = f64>) {
    for value in values {
        assert!(value.is_finite() && value >= 0.0, "{what} is {value}");
    }
}

/// A motion: columns of one length, time that goes forwards, shares that make a whole.
pub fn motion(motion: &Motion) {
    let Motion { time, torque, velocity, acceleration, torque_rate, jerk, weight, dwell, position, .. } = motion;
    let columns = [torque, velocity, acceleration, torque_rate, jerk, weight, dwell];
    for column in columns.into_iter().chain(position) {
        assert_eq!(column.len(), time.len());
        finite("a sample", column.iter().copied());
    }
    finite("a time", time.iter().copied());
    assert!(!time.is_empty());
    for (samples, course) in motion.courses() {
        let time = &time[samples];
        assert!(!time.is_empty() && time.windows(2).all(|w| w[0] < w[1]), "time does not go forwards: {time:?}");
        match course {
            Course::Periodic(duration) | Course::Once(duration) => positive("a duration", [duration]),
            Course::Points(duration) => positive("a duration", duration),
            Course::Cases => panic!("a case has no cases"),
        }
    }
    if let Some(cases) = &motion.cases {
        assert!((cases.list.iter().map(|case| case.share).sum::<f64>() - 1.0).abs() < 1e-6);
        positive("repetitions", cases.sequence.iter().map(|step| step.repetitions));
    }
    assert!((weight.iter().sum::<f64>() - 1.0).abs() < 1e-9, "shares of time {weight:?}");
    assert!(weight.iter().zip(dwell).all(|(w, d)| *d >= 0.0 && *w >= 0.0 && *d <= w * (1.0 + 1e-12)));
}

/// A robot that a requirement describes.
pub fn robot(robot: &Robot) {
    let bus = &robot.bus;
    positive("bus", [bus.voltage, bus.modulation_limit, bus.drive_efficiency, robot.ambient]);
    positive("bus", [bus.drive_current, bus.power, bus.current].into_iter().flatten());
    let budget = &robot.budget;
    positive("budget", [budget.actuator_mass, budget.power, budget.current].into_iter().flatten());
    assert!(!robot.joints.is_empty());
    for joint in &robot.joints {
        motion(&joint.motion);
        if let RatioChoice::Continuous { min, max } = joint.ratio {
            positive("ratio", [min, max]);
            assert!(min <= max);
        }
        let gear = &joint.gear;
        positive("efficiency", [gear.efficiency]);
        assert!(gear.efficiency <= 1.0 && gear.backdrive_efficiency <= 1.0 && gear.backdrive_efficiency.is_finite());
        not_negative("gear", [gear.inertia].into_iter().chain(gear.mass));
        positive("gear", [gear.peak_torque, gear.continuous_torque, gear.max_input_speed].into_iter().flatten());
        let limits = &joint.limits;
        positive(
            "limit",
            [limits.actuator_mass, limits.reflected_inertia, limits.winding_temperature].into_iter().flatten(),
        );
        positive("safety", [limits.safety]);
        if let Some(spring) = limits.spring {
            assert!(spring.stiffness[0] <= spring.stiffness[1] && spring.rest_angle[0] <= spring.rest_angle[1]);
        }
        assert!(!joint.objective.terms.is_empty());
        positive("weight", joint.objective.terms.iter().map(|(_, weight)| *weight));
        assert!(joint.phases.is_empty() || joint.phases.len() == joint.count as usize);
        for carried in &joint.carries {
            assert!(carried.joint < robot.joints.len());
            assert_eq!(carried.torque_per_mass.len(), joint.motion.len());
            finite("torque per mass", carried.torque_per_mass.iter().chain(&carried.rate).copied());
        }
    }
}
