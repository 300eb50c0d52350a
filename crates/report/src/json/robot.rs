//! The choice for a whole robot, inside of `optimize --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;

use super::Design;
use super::design::{Pairs, Unjudged};
use gearwise_model::requirement;
use gearwise_select::robot::{self, Apart, Wanting};

/// The choice for a whole robot.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Choice<'a> {
    /// Whether there is a combination that keeps everything.
    pub satisfied: bool,
    /// What is minimised over the robot.
    pub total: Total<'a>,
    /// What the combination has to keep.
    pub budget: Budget,
    /// How power was added up.
    pub power_is: &'static str,
    /// Joints that share a time base.
    pub time_bases: &'a [Vec<String>],
    /// How sure it is that no combination is better.
    pub certificate: Proof<'a>,
    /// The best combination.
    pub best: Option<Combination<'a>>,
    /// The next ones, each with another motor somewhere.
    pub runner_ups: Vec<Combination<'a>>,
    /// What would have to give way where there is none: any of these alone.
    pub wanting: Vec<Missing<'a>>,
    /// What other budgets would give.
    pub other_budgets: Vec<OtherBudget<'a>>,
    /// Whether other budgets were not looked at.
    pub other_budgets_left_out: bool,
    /// The best total for less and less mass.
    pub front: Vec<Combination<'a>>,
    /// Motors that cannot be judged.
    pub unjudged: Vec<UnjudgedAt<'a>>,
}

/// What is minimised over the robot.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Total<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its unit.
    pub unit: &'a str,
    /// Whether each joint's objective is taken over the best that the joint could have alone.
    pub relative: bool,
    /// What each joint's objective is divided by.
    pub scale: &'a [f64],
}

/// The budgets of the requirement; `null` for none.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Budget {
    /// Mass of all actuators.
    pub actuator_mass_kg: Option<f64>,
    /// Number of different motors.
    pub max_distinct_motors: Option<u32>,
    /// Power of all joints together.
    pub power_w: Option<f64>,
    /// Power that may come back from all joints together, what a brake burns included.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regeneration_w: Option<f64>,
}

/// How sure the best combination is.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Proof<'a> {
    /// Whether it is proved.
    pub certified: bool,
    /// No combination is below this.
    pub lower_bound: Option<f64>,
    /// `(objective − lower bound)/|objective|`.
    pub gap: Option<f64>,
    /// Why it is not proved.
    pub not_proved: &'a [String],
    /// Branches of the search.
    pub branches: usize,
    /// Where the search did not end: joints with the motors of combinations that may be better than the best.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub may_be_better: Vec<MayBeBetter<'a>>,
    /// Where actuators load one another and the search did not end: parts of all combinations that were settled, and that were left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<PartsOfAll>,
}

/// What may be better at a joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct MayBeBetter<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// The motors.
    pub motors: &'a [String],
}

/// How far a search came.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct PartsOfAll {
    /// Parts of all combinations that were settled.
    pub settled: usize,
    /// Parts that were left.
    pub left: usize,
}

/// What all actuators cost together.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Bill {
    /// Currency of the sums.
    pub currency: &'static str,
    /// The sum; `null` where a price is not known.
    pub total: Option<f64>,
    /// The sum of what is known.
    pub at_least: f64,
    /// Number of actuators of which all of the price is known.
    pub known_actuators: u32,
    /// Number of actuators.
    pub actuators: u32,
}

impl From<robot::Bill> for Bill {
    fn from(bill: robot::Bill) -> Bill {
        Bill {
            currency: bill.currency.code(),
            total: bill.total(),
            at_least: bill.at_least,
            known_actuators: bill.known,
            actuators: bill.of,
        }
    }
}

/// A design for each joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Combination<'a> {
    /// The designs.
    pub joints: Vec<At<'a>>,
    /// The total.
    pub objective: f64,
    /// The total of these motors is nowhere below this.
    pub lower_bound: Option<f64>,
    /// Mass of all actuators.
    pub actuator_mass_kg: Option<f64>,
    /// Price of all actuators, where the requirement has `[prices]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub price: Option<Bill>,
    /// Largest power of all joints together.
    pub peak_power_w: Option<f64>,
    /// The most that comes back to the bus from all joints together, less what others draw then; below zero where they always draw some.
    pub most_returned_w: Option<f64>,
    /// The same in each load case, by name, where joints have cases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_power_of_cases_w: Option<Pairs<'a>>,
    /// What a supply with a resistance makes of all joints together; left out where it is stiff, or feeds one actuator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sag: Option<Sag<'a>>,
    /// Change of the total per watt more.
    pub objective_per_watt: Option<f64>,
    /// Change of the total per kilogram more of one actuator, by joint, with the same motors at their best ratios; left out where nothing is
    /// carried, and where joints share more than that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub objective_per_kilogram: Option<Pairs<'a>>,
    /// Number of different motors.
    pub distinct_motors: usize,
}

/// A supply that sags under all joints together. What some give back to the bus is not counted on.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Sag<'a> {
    /// Lowest voltage of the bus, before the leads of a joint; null where the supply cannot give what all joints take.
    pub lowest_v: Option<f64>,
    /// The share of the supply's open-circuit voltage that is left at the drive that has least; below zero it is too little.
    pub left: f64,
    /// The joint of that drive.
    pub joint: &'a str,
}

/// A design of a combination.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct At<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// How many alike the robot has.
    pub count: u32,
    #[serde(flatten)]
    design: Design<'a>,
    /// Constant torque that carried actuators add.
    pub carried_torque_nm: Option<f64>,
}

/// What stands in the way; any of these alone.
#[derive(Debug, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Missing<'a> {
    /// No motor can do these joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<&'a [String]>,
    /// It can be done with so much mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator_mass_kg: Option<f64>,
    /// It can be done with so many different motors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_distinct_motors: Option<usize>,
    /// Whether another budget would do was not settled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_settled: Option<bool>,
    /// Without the limit on what comes back a combination gives back so much.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unlimited_returned_w: Option<f64>,
    /// A combination that was tried can do with so much power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_power_tried_w: Option<f64>,
    /// The best that is not limited draws so much.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unlimited_power_w: Option<f64>,
    /// It can be done with a supply that does not sag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiff_supply: Option<bool>,
}

/// What another budget would give.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OtherBudget<'a> {
    /// Name of the budget.
    pub budget: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it would be.
    pub value: f64,
    /// Whether the combination is proved to be the best then.
    pub certified: bool,
    /// The best combination then.
    pub best: Option<Combination<'a>>,
}

/// A motor that cannot be judged, at a joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct UnjudgedAt<'a> {
    #[serde(flatten)]
    motor: Unjudged<'a>,
    /// Name of the joint.
    pub joint: &'a str,
}

impl<'a> Choice<'a> {
    /// What was chosen.
    pub fn new(choice: &'a robot::Choice<'a>) -> Choice<'a> {
        let (robot, proof) = (choice.robot, &choice.proof);
        let combination = |c: &'a robot::Combination<'a>| Combination::new(robot, c);
        Choice {
            satisfied: !choice.combinations.is_empty(),
            total: Total {
                name: &choice.total.name,
                unit: choice.total.unit,
                relative: choice.total.relative,
                scale: &choice.total.scale,
            },
            budget: Budget {
                actuator_mass_kg: robot.budget.actuator_mass,
                max_distinct_motors: robot.budget.max_distinct_motors,
                power_w: robot.shared_power(),
                regeneration_w: robot.shared_regeneration(),
            },
            power_is: match choice.instant_by_instant {
                true => "largest at any instant",
                false => "sum of peaks over time bases",
            },
            time_bases: &choice.time_bases,
            certificate: Proof {
                certified: proof.certified(),
                lower_bound: proof.lower_bound,
                gap: proof.gap,
                not_proved: &proof.not_proved,
                branches: proof.branches,
                may_be_better: robot
                    .joints
                    .iter()
                    .zip(&proof.open)
                    .filter(|(_, motors)| !motors.is_empty())
                    .map(|(joint, motors)| MayBeBetter { joint: &joint.name, motors })
                    .collect(),
                parts: (proof.regions.1 > 0).then_some(PartsOfAll { settled: proof.regions.0, left: proof.regions.1 }),
            },
            best: choice.combinations.first().map(combination),
            runner_ups: choice.combinations.iter().skip(1).map(combination).collect(),
            wanting: choice.wanting.iter().map(Missing::from).collect(),
            other_budgets: choice.changes.iter().map(|change| OtherBudget::new(robot, change)).collect(),
            other_budgets_left_out: choice.others_left_out,
            front: choice.front.iter().map(combination).collect(),
            unjudged: choice.unjudged.iter().map(UnjudgedAt::new).collect(),
        }
    }
}

impl<'a> Combination<'a> {
    fn new(robot: &'a requirement::Robot, of: &'a robot::Combination<'a>) -> Combination<'a> {
        let joints = robot.joints.iter().zip(&of.joints).zip(&of.carried).map(|((joint, design), carried)| {
            let constant = joint.carries.iter().any(|c| c.constant);
            At {
                joint: &joint.name,
                count: joint.count,
                design: Design::new(design.facts(), joint),
                carried_torque_nm: carried.first().copied().filter(|_| constant),
            }
        });
        Combination {
            joints: joints.collect(),
            objective: of.objective,
            lower_bound: Some(of.lower_bound).filter(|bound| bound.is_finite()),
            actuator_mass_kg: of.mass,
            price: of.bill(robot).map(Bill::from),
            peak_power_w: Some(of.peak_power).filter(|power| power.is_finite()),
            most_returned_w: Some(of.most_returned).filter(|power| power.is_finite()),
            peak_power_of_cases_w: (!of.peak_power_by_case.is_empty())
                .then(|| Pairs::of(of.peak_power_by_case.iter().map(|(name, power)| (name.as_str(), *power)))),
            sag: of.sag.map(|sag| Sag { lowest_v: sag.lowest, left: sag.left, joint: &robot.joints[sag.joint].name }),
            objective_per_watt: of.power_price,
            objective_per_kilogram: (!of.per_mass.is_empty()).then(|| {
                Pairs::of(robot.joints.iter().zip(&of.per_mass).map(|(joint, price)| (joint.name.as_str(), *price)))
            }),
            distinct_motors: of.distinct_motors,
        }
    }
}

impl<'a> From<&'a Wanting> for Missing<'a> {
    fn from(wanting: &'a Wanting) -> Missing<'a> {
        match wanting {
            Wanting::Joints(names) => Missing { joints: Some(names), ..Missing::default() },
            Wanting::Mass(mass) => Missing { actuator_mass_kg: Some(*mass), ..Missing::default() },
            Wanting::Motors(motors) => Missing { max_distinct_motors: Some(*motors), ..Missing::default() },
            Wanting::Power(least, draws) => {
                Missing { least_power_tried_w: Some(*least), unlimited_power_w: Some(*draws), ..Missing::default() }
            }
            Wanting::Returned(most) => Missing { unlimited_returned_w: Some(*most), ..Missing::default() },
            Wanting::NotSettled => Missing { not_settled: Some(true), ..Missing::default() },
            Wanting::Supply => Missing { stiff_supply: Some(true), ..Missing::default() },
        }
    }
}

impl<'a> OtherBudget<'a> {
    fn new(robot: &'a requirement::Robot, change: &'a robot::Change<'a>) -> OtherBudget<'a> {
        OtherBudget {
            budget: change.budget,
            unit: change.unit,
            value: change.value,
            certified: change.certified,
            best: change.best.as_ref().map(|best| Combination::new(robot, best)),
        }
    }
}

impl<'a> UnjudgedAt<'a> {
    fn new(apart: &'a Apart<'a>) -> UnjudgedAt<'a> {
        UnjudgedAt { motor: Unjudged::new(&apart.motor.id, None, &apart.because, None), joint: &apart.joint.name }
    }
}
