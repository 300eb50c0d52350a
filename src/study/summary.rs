//! What a study says as a whole: how often each motor wins, and what each parameter does.

use std::collections::HashMap;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::columns;
use super::effects::{Effect, FirstChoice};
use super::plan::Plan;
use super::worker::{Record, Standing};

/// Joints with different names that are told apart; further ones are put together.
const MOST_JOINTS: usize = 256;
/// Name of the joints that are put together.
const OTHERS: &str = "(other joints)";

/// What a study says as a whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Summary {
    /// Robots.
    pub robots: u64,
    /// Robots that could not be worked on.
    pub broken: u64,
    /// Rows of the results.
    pub rows: u64,
    /// How many designs of each joint were asked for; all where it is not given.
    pub top: Option<u32>,
    /// Joints by name, in the order in which they are met.
    pub joints: Vec<JointSummary>,
    /// What the parameters of the grid do.
    pub effects: Vec<Effect>,
}

/// All joints of one name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct JointSummary {
    /// Their name.
    pub joint: String,
    /// How many robots have one.
    pub robots: u64,
    /// How many of them have no design: no motor that can be judged can do it, or there is no combination.
    pub without_design: u64,
    /// Of how many of those no combination for the whole robot was found, whatever the joint itself could have.
    pub without_combination: u64,
    /// At how many of those some motor may, but a limit that the requirement states cannot be judged of it.
    pub unjudged: u64,
    /// Least loss of a first choice, in watts.
    pub least_loss_w: Option<f64>,
    /// Mean loss of the first choices, in watts.
    pub mean_loss_w: Option<f64>,
    /// Largest loss of a first choice, in watts.
    pub largest_loss_w: Option<f64>,
    /// Motors that are among the designs asked for at least once, the most frequent winners first.
    pub motors: Vec<MotorSummary>,
}

/// How one motor fares at the joints of one name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct MotorSummary {
    /// Its id.
    pub motor: String,
    /// Where it is the first choice.
    pub first: u64,
    /// Where it is among the designs asked for, the first included.
    pub among: u64,
    /// Where it can do it, as far as that was asked.
    pub can: u64,
    /// Where it cannot.
    pub cannot: u64,
    /// Where a limit that it must be judged by cannot be; with `--only-checked` any limit.
    pub unjudged: u64,
    /// Where it was not asked, because it cannot be among the designs asked for.
    pub not_asked: u64,
}

#[derive(Debug, Default)]
struct Gathered {
    name: String,
    robots: u64,
    without: u64,
    uncombined: u64,
    unjudged: u64,
    losses: Option<(f64, f64, f64)>,
    // First, among, behind, cannot, unknown, unjudged: for each motor.
    standings: Vec<[u64; 6]>,
}

/// Gathers a summary, robot by robot.
#[derive(Debug, Default)]
pub struct Gatherer {
    robots: u64,
    broken: u64,
    rows: u64,
    joints: Vec<Gathered>,
    places: HashMap<String, usize>,
}

impl Gatherer {
    /// Adds a robot; the first choice of each of its joints.
    pub fn robot(&mut self, plan: &Plan, record: &Record) -> Vec<(String, FirstChoice)> {
        self.robots += 1;
        self.broken += u64::from(record.broken.is_some());
        let loss_at = columns::position("loss_w");
        let mut choices = Vec::new();
        for joint in &record.joints {
            self.rows += joint.rows.len() as u64;
            let gathered = self.joint(plan, &joint.name);
            gathered.robots += 1;
            let mut choice = FirstChoice::NONE;
            // What is asked of nothing any more is not written.
            let letters = joint.motors.chars().map(Some).chain(std::iter::repeat(None)).take(plan.choices().count());
            for (motor, letter) in letters.enumerate() {
                let standing = letter.and_then(Standing::of).unwrap_or(Standing::Unknown);
                if standing == Standing::First {
                    let loss = joint.rows.first().and_then(|row| row.get(loss_at)?.parse().ok());
                    choice = FirstChoice { loss: loss.unwrap_or(f64::NAN), motor: motor as u32 };
                }
                if let Some(counts) = gathered.standings.get_mut(motor) {
                    counts[standing as usize] += 1;
                }
            }
            let without = choice.motor == u32::MAX;
            let apart = joint.motors.chars().any(|letter| Standing::of(letter) == Some(Standing::Unjudged));
            gathered.without += u64::from(without);
            let uncombined = record.combined == Some(false);
            gathered.uncombined += u64::from(uncombined);
            gathered.unjudged += u64::from(without && apart && !uncombined);
            if choice.loss.is_finite() {
                let (least, sum, most) = gathered.losses.unwrap_or((f64::INFINITY, 0.0, f64::NEG_INFINITY));
                gathered.losses = Some((least.min(choice.loss), sum + choice.loss, most.max(choice.loss)));
            }
            choices.push((gathered.name.clone(), choice));
        }
        choices
    }

    fn joint(&mut self, plan: &Plan, name: &str) -> &mut Gathered {
        let name = if self.places.contains_key(name) || self.places.len() < MOST_JOINTS { name } else { OTHERS };
        let place = *self.places.entry(name.to_string()).or_insert(self.joints.len());
        if place == self.joints.len() {
            let standings = vec![[0; 6]; plan.choices().count()];
            self.joints.push(Gathered { name: name.into(), standings, ..Gathered::default() });
        }
        &mut self.joints[place]
    }

    /// Rows of the results so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// The summary.
    pub fn finish(self, plan: &Plan, effects: Vec<Effect>) -> Summary {
        let joints = self.joints.into_iter().map(|joint| {
            let motors = plan.choices().zip(&joint.standings).map(|(motor, counts)| {
                let [first, among, behind, cannot, not_asked, unjudged] = *counts;
                let among = first + among;
                MotorSummary { motor: motor.clone(), first, among, can: among + behind, cannot, unjudged, not_asked }
            });
            let mut motors: Vec<MotorSummary> = motors.filter(|m| m.among > 0).collect();
            motors.sort_by(|a, b| b.first.cmp(&a.first).then(b.among.cmp(&a.among)).then(a.motor.cmp(&b.motor)));
            let with_design = joint.robots - joint.without;
            JointSummary {
                joint: joint.name,
                robots: joint.robots,
                without_design: joint.without,
                without_combination: joint.uncombined,
                unjudged: joint.unjudged,
                least_loss_w: joint.losses.map(|l| l.0),
                mean_loss_w: joint.losses.map(|l| l.1 / with_design as f64),
                largest_loss_w: joint.losses.map(|l| l.2),
                motors,
            }
        });
        Summary {
            robots: self.robots,
            broken: self.broken,
            rows: self.rows,
            top: plan.settings.top,
            joints: joints.collect(),
            effects,
        }
    }
}
