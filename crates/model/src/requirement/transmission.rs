//! `[joint.transmission]`: what is between the actuator and the joint.

use std::sync::Arc;

use super::limits::Limits;
use super::motions::MotionReader;
use super::prices::{self, Money};
use crate::input::{Problem, Range, Section, key};
use crate::motion::{CarriedColumn, Course, Motion};
use crate::transmission::read::read;
use crate::transmission::{Numbers, Passed, SpringAt, Transmission};

/// Reads `transmission` of a joint; `None` where there is none, or one with mistakes, which are noted.
pub(super) fn read_joint(section: &Section, money: &Money, reader: &mut MotionReader) -> Option<Transmission> {
    let about = "what is between the actuator and the joint: one of `ratio`, `table`, `four_bar`, `lever`";
    let table = section.section(key("transmission", about).default("nothing"))?;
    let read = reader.with_files(|files| read(&table, files));
    let price = read_price(&table, money);
    table.finish();
    read.map(|read| Transmission { numbers: Numbers { price, ..read.numbers }, ..read })
}

/// Reads the price of a transmission, in the currency of the requirement.
pub(super) fn read_price(section: &Section, money: &Money) -> Option<f64> {
    let asked = key("price", "of the transmission; without it a limit on the price is not judged");
    prices::read_amount(section, asked, Range::NonNegative, money)
}

/// The motion of the actuator, and what is passed to it; what does not go together is a mistake of the joint.
pub(super) fn pass(
    section: &Section,
    transmission: &Transmission,
    motion: &Motion,
    limits: &Limits,
    columns: Vec<CarriedColumn>,
) -> Option<(Arc<Motion>, Arc<Passed>, Vec<CarriedColumn>)> {
    let span = section.span_of("transmission");
    let wrong = |message: String, label: &str, help: &str| {
        section.note(Problem::at(span.clone(), message, label).help(help.to_string()));
    };
    if transmission.way.constant().is_none() {
        let word = transmission.way.word();
        if motion.courses().iter().any(|(_, course)| matches!(course, Course::Points(_))) {
            wrong(
                format!("a transmission that is a {word} needs the position, and operating points have none"),
                "its ratio goes with the angle",
                "give a `motion` with a column `position`, or `ratio` in the transmission",
            );
            return None;
        }
        if !motion.placed {
            wrong(
                format!("a transmission that is a {word} needs the position, and the motion does not say it"),
                "its ratio goes with the angle",
                "give the motion a column `position`, on the scale of the transmission",
            );
            return None;
        }
    }
    if transmission.numbers.is_lossy() && limits.spring.is_some_and(|spring| spring.at == SpringAt::Joint) {
        wrong(
            "a spring at the joint cannot be chosen behind a transmission with an `efficiency`".into(),
            "which way power goes through it depends on the spring",
            "put the spring at the actuator (spring.at = \"actuator\"), or the loss into the gear (`gear.efficiency`)",
        );
        return None;
    }
    match Passed::new(transmission, motion) {
        Ok((behind, passed)) => {
            let columns = columns.into_iter().map(|column| carried(column, motion, &passed)).collect();
            Some((behind.into(), passed.into(), columns))
        }
        Err(fault) => {
            wrong(
                fault.to_string(),
                "not with this motion",
                "compare the motion's positions with the transmission's: their zero, their unit, their direction",
            );
            None
        }
    }
}

/// A torque per mass at the joint, with its rate, as the actuator has it.
fn carried((name, values, rates): CarriedColumn, joint: &Motion, passed: &Passed) -> CarriedColumn {
    let (values, rates) = at_samples(&values, rates, joint, passed.motion());
    let through = (0..values.len()).map(|k| passed_on(passed, k, values[k], rates[k]));
    let (values, rates) = through.unzip();
    (name, values, rates)
}

/// A torque \[N·m\] and its rate at the joint as the actuator has it, without loss.
pub(super) fn passed_on(passed: &Passed, k: usize, torque: f64, rate: f64) -> (f64, f64) {
    let (per, per_rate) = passed.per_torque(k);
    (torque * per, rate * per + torque * per_rate)
}

/// What is known at the samples of a motion, at those of another one over the same given samples.
fn at_samples(values: &[f64], rates: Vec<f64>, from: &Motion, to: &Motion) -> (Vec<f64>, Vec<f64>) {
    if from.time == to.time {
        return (values.to_vec(), rates);
    }
    let parts = from.parts().into_iter().zip(to.parts());
    let of = |((samples, from), (_, to)): ((std::ops::Range<usize>, Motion), (_, Motion))| {
        let given: Vec<f64> = from.given.iter().map(|k| values[samples.start + k]).collect();
        to.at_every_sample(&given)
    };
    let all: Vec<(Vec<f64>, Vec<f64>)> = parts.map(of).collect();
    all.into_iter().fold((Vec::new(), Vec::new()), |(mut v, mut r), (values, rates)| {
        v.extend(values);
        r.extend(rates);
        (v, r)
    })
}
