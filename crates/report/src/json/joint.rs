//! A joint with what became of the motors: what `optimize`, `sweep`, `optimize --pareto` and `optimize --robust` have in
//! common.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;

use gearwise_model::catalog::Motor;
use gearwise_model::requirement::{self, Balancing, Between};
use gearwise_model::transmission::Ways;
use gearwise_select::answer;

/// What is said of the joint itself.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Joint<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// How many alike the robot has.
    pub count: u32,
    /// What is minimised: names of quantities, or `balanced`.
    pub objective: String,
    /// What loss and mass are divided by where the objective is balanced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Where the requirement lists planetary stages: how many ratios these have, and how many of them are looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<Stages>,
    /// What of the motion was not given but taken from a spline.
    pub derived_by_spline: &'a [&'static str],
    /// What is known of the motion between its samples; `null` where there is nothing between.
    pub between_samples: Option<BetweenSamples>,
    /// The load cases, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cases: Option<Cases<'a>>,
    /// What is between actuator and joint; torques, speeds and gear ratios of designs are those of the actuator then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmission: Option<Transmission<'a>>,
}

/// What is between actuators and joints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Transmission<'a> {
    /// What it is: `ratio`, `table`, `four-bar linkage`, `lever with a screw`, or a coupling of two joints.
    pub kind: &'static str,
    /// Smallest turn of the actuator per turn of the joint over the motion, |dθ/dq|; `null` of a coupling.
    pub least_ratio: Option<f64>,
    /// The angle of the joint that has it; `null` where the motion says no position.
    pub least_ratio_at_rad: Option<f64>,
    /// The largest.
    pub largest_ratio: Option<f64>,
    /// Smallest |det J| of a coupling over the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_determinant: Option<f64>,
    /// What is largest at each joint.
    pub joints: Vec<Peaks<'a>>,
    /// What is largest at the output of each actuator.
    pub actuators: Vec<Peaks<'a>>,
    /// Mean loss of the transmission, which is not in the designs' loss; `null` where no efficiency is given.
    pub loss_w: Option<f64>,
    /// Its mass, which is in that of the actuators; `null` where it is not given and counts as nothing.
    pub mass_kg: Option<f64>,
}

/// Largest torque and speed on one side of a transmission.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Peaks<'a> {
    /// Whose: a joint's name, `actuator 1` or `actuator 2` where there are two.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub of: &'a str,
    /// Largest torque.
    pub peak_torque_nm: f64,
    /// Largest speed.
    pub peak_speed_rad_s: f64,
}

impl<'a> Transmission<'a> {
    fn new(joint: &'a requirement::Joint) -> Option<Transmission<'a>> {
        let passed = joint.passed.as_deref()?;
        let peaks = |all: Vec<requirement::Peaks<'a>>| {
            let of =
                |p: requirement::Peaks<'a>| Peaks { of: p.of, peak_torque_nm: p.torque, peak_speed_rad_s: p.speed };
            all.into_iter().map(of).collect()
        };
        let [joints, actuators] = joint.peaks();
        let ratio = passed.ratio();
        let angle = |k: usize| passed.motion().position.as_ref().map(|q| q[k]);
        Some(Transmission {
            kind: passed.word(),
            least_ratio: ratio.map(|range| range.least.0),
            least_ratio_at_rad: ratio.and_then(|range| angle(range.least.1)),
            largest_ratio: ratio.map(|range| range.most.0),
            least_determinant: match &passed.ways {
                Ways::Two(both) => Some(both.determinant.least.0),
                Ways::One { .. } => None,
            },
            joints: peaks(joints),
            actuators: peaks(actuators),
            loss_w: passed.numbers.says_loss.then_some(passed.loss),
            mass_kg: passed.numbers.mass,
        })
    }
}

/// Ratios of planetary stages.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Stages {
    /// How many ratios can be assembled.
    pub ratios: usize,
    /// How many of them are looked at.
    pub looked_at: usize,
    /// Where that is not all: each other one is within this share of one that is looked at, which has no more teeth.
    pub within: Option<f64>,
}

/// The load cases of a joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Cases<'a> {
    /// Each of them.
    pub list: Vec<Case<'a>>,
    /// Whether the requirement states the sequence in which heat is followed.
    pub order_is_stated: bool,
    /// Whether the sequence is made once, from cold.
    pub once: bool,
    /// The sequence in which heat is followed.
    pub heat_sequence: Vec<Step<'a>>,
}

/// One load case.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Case<'a> {
    /// Name.
    pub name: &'a str,
    /// Share of the time, the rest after it included.
    pub share: f64,
    /// How long it moves in one repetition.
    pub lasts_s: f64,
    /// From one repetition to the next, rest included.
    pub cycle_s: f64,
    /// Largest load torque.
    pub peak_torque_nm: f64,
    /// Largest speed.
    pub peak_speed_rad_s: f64,
}

/// A case that is repeated before the next one comes.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Step<'a> {
    /// Name of the case.
    pub case: &'a str,
    /// How many times.
    pub repetitions: f64,
}

impl<'a> Cases<'a> {
    /// Of a joint's motion; `None` where it has no cases.
    pub fn new(joint: &'a requirement::Joint) -> Option<Cases<'a>> {
        let (motion, cases) = (&joint.motion, joint.motion.cases.as_deref().filter(|cases| !cases.together)?);
        let case = |case: &'a gearwise_model::motion::Case| {
            let (peak_torque_nm, peak_speed_rad_s) = motion.peaks(case);
            Case {
                name: &case.name,
                share: case.share,
                lasts_s: case.lasts(),
                cycle_s: case.cycle(),
                peak_torque_nm,
                peak_speed_rad_s,
            }
        };
        let step = |step: &gearwise_model::motion::Step| Step {
            case: &cases.list[step.case].name,
            repetitions: step.repetitions,
        };
        Some(Cases {
            list: cases.list.iter().map(case).collect(),
            order_is_stated: cases.is_ordered(),
            once: cases.once,
            heat_sequence: cases.sequence.iter().map(step).collect(),
        })
    }
}

impl<'a> Joint<'a> {
    /// A joint of a requirement.
    pub fn new(joint: &'a requirement::Joint) -> Joint<'a> {
        Joint {
            joint: &joint.name,
            count: joint.count,
            objective: joint.goal(),
            reference: Reference::new(joint),
            stages: joint.ratio.teeth().map(|teeth| Stages {
                ratios: teeth.ratios,
                looked_at: teeth.gears.len(),
                within: teeth.within,
            }),
            derived_by_spline: &joint.motion.derived,
            between_samples: BetweenSamples::new(joint),
            cases: Cases::new(joint),
            transmission: Transmission::new(joint),
        }
    }
}

/// What a balanced objective divides loss and mass by: the geometric means of the two ends.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Reference {
    /// L₀.
    pub loss_w: f64,
    /// M₀.
    pub mass_kg: f64,
}

impl Reference {
    fn new(joint: &requirement::Joint) -> Option<Reference> {
        match &joint.balancing {
            Balancing::Made(balance) => Some(Reference { loss_w: balance.loss, mass_kg: balance.mass }),
            _ => None,
        }
    }
}

/// The three designs between which an engineer chooses: a balanced one, and the ends of what it is balanced from.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Choices<'a> {
    /// The lightest design.
    pub lightest: Chosen<'a>,
    /// The balanced design, the first candidate.
    pub balanced: Option<Chosen<'a>>,
    /// The design with the least loss.
    pub least_loss: Chosen<'a>,
}

/// One of them.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Chosen<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Ratio N.
    pub ratio: f64,
    /// Mean loss.
    pub loss_w: f64,
    /// Mass of motor and gear; `null` where it is not known.
    pub mass_kg: Option<f64>,
}

impl<'a> Choices<'a> {
    /// Of a joint with a balanced objective.
    pub fn new(result: &'a answer::JointResult<'a>) -> Option<Choices<'a>> {
        let Balancing::Made(balance) = &result.joint.balancing else { return None };
        let end = |of: &'a requirement::Extreme| Chosen {
            motor: &of.motor,
            gear: of.gear.as_deref(),
            ratio: of.ratio,
            loss_w: of.loss,
            mass_kg: Some(of.mass),
        };
        let balanced = result.candidates.first().map(|design| Chosen {
            motor: &design.motor.id,
            gear: design.gear,
            ratio: design.evaluation.ratio,
            loss_w: design.evaluation.loss,
            mass_kg: design.evaluation.mass,
        });
        Some(Choices { lightest: end(&balance.lightest), balanced, least_loss: end(&balance.least_loss) })
    }
}

/// Whether the motion is known between its samples.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct BetweenSamples {
    /// `spline` where it is; `not_resolved` where limits are kept at the samples alone.
    pub by: &'static str,
    /// Share of the largest values that is missed there: at most where it is resolved, else by estimate.
    pub missed_share: f64,
    /// How many samples the limits are kept at.
    pub samples: usize,
    /// How many of them the motion's file has.
    pub given_samples: usize,
}

impl BetweenSamples {
    /// Of a joint's motion.
    pub fn new(joint: &requirement::Joint) -> Option<BetweenSamples> {
        let (by, missed_share) = match joint.motion.between {
            Between::Nothing => return None,
            Between::Spline(share) => ("spline", share),
            Between::Given(share) => ("not_resolved", share),
        };
        let (samples, given_samples) = (joint.motion.len(), joint.motion.given.len());
        Some(BetweenSamples { by, missed_share, samples, given_samples })
    }
}

/// How alike the order by a metric and the order by the task are.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Agreement {
    /// The metric.
    pub metric: &'static str,
    /// Kendall's τ: 1 is the same order, −1 the opposite; `null` where it cannot be computed.
    pub kendall_tau: Option<f64>,
    /// How many motors were compared.
    pub motors: usize,
}

impl From<&answer::Agreement> for Agreement {
    fn from(of: &answer::Agreement) -> Agreement {
        Agreement { metric: of.metric, kendall_tau: of.tau, motors: of.motors }
    }
}

/// What was left out, where only the first designs were asked for.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Pruned<'a> {
    /// How many designs were asked for.
    pub keep: usize,
    /// Motors that were solved and can do it, but come after those.
    pub feasible_behind: usize,
    /// Motors that were not solved, because they are provably not among those.
    pub not_solved: Vec<NotSolved<'a>>,
}

/// A motor that was not solved.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NotSolved<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Its objective is not below this.
    pub lower_bound: f64,
}

impl<'a> From<&'a answer::Pruned<'a>> for Pruned<'a> {
    fn from(of: &'a answer::Pruned<'a>) -> Pruned<'a> {
        let one = |(motor, lower_bound): &(&'a Motor, f64)| NotSolved { motor: &motor.id, lower_bound: *lower_bound };
        Pruned { keep: of.keep, feasible_behind: of.behind, not_solved: of.not_solved.iter().map(one).collect() }
    }
}
