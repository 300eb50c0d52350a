//! What is found for a whole robot, as facts.

use super::total::Total;
use crate::answer::Design;
use crate::options::Stopped;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::{Currency, Motor};
use gearwise_model::requirement::{Joint, Robot};

/// Steps of a search that nobody ends: at most some 30 seconds of one processor of 2020.
const STEPS: u64 = 25_000_000;

/// How a robot's choice is made.
#[derive(Clone, Copy)]
pub struct Options<'p> {
    /// Only designs of which every limit could be checked.
    pub only_checked: bool,
    /// How many further combinations are wanted, each different in a motor.
    pub runner_ups: usize,
    /// Whether it is also told what the budgets cost.
    pub budgets: bool,
    /// Called once for each joint that is done.
    pub tick: &'p (dyn Fn() + Sync),
    /// Called at each branch of a search: how many were looked at in it, and how many complete combinations solved.
    pub searched: &'p (dyn Fn(usize, usize) + Sync),
    /// As [`stop`](crate::Options::stop) of a joint's search; also asked for each combination.
    pub stop: &'p (dyn Fn() -> bool + Sync),
    /// When a search that has not ended gives what it has, e.g. after some time: asked for each combination, and once true it stays so.
    /// Without it a search ends after so many steps, and the answer is the same each time.
    pub enough: Option<&'p (dyn Fn() -> bool + Sync)>,
    /// Steps of work after which the search for the best combination ends; those under other budgets together take a third of them.
    pub steps: u64,
}

/// Why there is no choice.
#[derive(Debug, Clone, PartialEq)]
pub enum NoChoice {
    /// It was stopped.
    Stopped,
    /// It is not asked for in a way that can be answered: in words.
    Cannot(String),
}

impl From<Stopped> for NoChoice {
    fn from(_: Stopped) -> NoChoice {
        NoChoice::Stopped
    }
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            only_checked: false,
            runner_ups: 3,
            budgets: true,
            tick: &|| {},
            searched: &|_, _| {},
            stop: &|| false,
            enough: None,
            steps: STEPS,
        }
    }
}

/// One design for each joint.
#[derive(Debug, Clone)]
pub struct Combination<'a> {
    /// In the order of the requirement. Where power is shared the ratio may not be the joint's own best.
    pub joints: Vec<Design<'a>>,
    /// The total that is minimised.
    pub objective: f64,
    /// The total of these motors is nowhere below this.
    pub lower_bound: f64,
    /// Mass of all actuators \[kg\].
    pub mass: Option<f64>,
    /// Largest power that all joints draw together \[W\]: at one instant where they share a time base, else
    /// the sum of their peaks.
    pub peak_power: f64,
    /// The same in each load case \[W\], by name; empty where joints have no cases.
    pub peak_power_by_case: Vec<(String, f64)>,
    /// The most that comes back to the bus from all joints together \[W\], less what others draw then: at one instant where they share a
    /// time base; less than zero where they always draw some.
    pub most_returned: f64,
    /// What a supply with a resistance makes of it; `None` where it is stiff, or feeds one actuator.
    pub sag: Option<Sag>,
    /// Change of the total per watt more of shared power, where that is limited.
    pub power_price: Option<f64>,
    /// Change of the total per kilogram more of each actuator of a joint, by the load that it is to others \[objective/kg\], with the same
    /// motors at their best ratios; empty where nothing is carried, and where joints share more than that.
    pub per_mass: Vec<f64>,
    /// Number of different motors.
    pub distinct_motors: usize,
    /// What carried actuators add to each joint's load: for constant torques per mass the torque \[N·m\], for
    /// others the mass \[kg\].
    pub carried: Vec<Vec<f64>>,
}

/// What all actuators of a robot cost together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bill {
    /// The currency that it is counted in.
    pub currency: Currency,
    /// What is known of it: it is at least this.
    pub at_least: f64,
    /// Number of actuators of which all of the price is known.
    pub known: u32,
    /// Number of actuators.
    pub of: u32,
}

impl Bill {
    /// The sum, where every price is known.
    pub fn total(&self) -> Option<f64> {
        (self.known == self.of).then_some(self.at_least)
    }
}

impl Combination<'_> {
    /// What its actuators cost together; `None` where the requirement counts no prices.
    pub fn bill(&self, robot: &Robot) -> Option<Bill> {
        let currency = robot.prices.as_ref()?.currency;
        let costs =
            robot.joints.iter().zip(&self.joints).filter_map(|(j, d)| Some((j.count, d.evaluation.price?.whole)));
        Some(costs.fold(Bill { currency, at_least: 0.0, known: 0, of: 0 }, |bill, (count, whole)| Bill {
            at_least: bill.at_least + f64::from(count) * whole.known,
            known: bill.known + if whole.missing.is_none() { count } else { 0 },
            of: bill.of + count,
            ..bill
        }))
    }
}

/// A supply that sags under all joints together. What some give back to the bus is not counted on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sag {
    /// Lowest voltage of the bus \[V\], before the leads of a joint; `None` where the supply cannot give what all take.
    pub lowest: Option<f64>,
    /// The share of the open-circuit voltage that is left at the drive that is worst off: below zero it is too little.
    pub left: f64,
    /// The joint of that drive, by its place in the requirement.
    pub joint: usize,
}

/// How sure the best combination is.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// No combination is better than this; `None` where nothing is known.
    pub lower_bound: Option<f64>,
    /// `(objective − lower bound)/|objective|`.
    pub gap: Option<f64>,
    /// Why it is not proved; empty where it is.
    pub not_proved: Vec<String>,
    /// Branches looked at.
    pub branches: usize,
    /// Where the search did not end: of each joint the motors of combinations that may be better, but its own, in the order of the
    /// catalogue; empty where it ended.
    pub open: Vec<Vec<String>>,
    /// Where actuators load one another: how many parts of all combinations were settled, and how many were left.
    pub regions: (usize, usize),
}

impl Proof {
    /// Whether no combination can be better.
    pub fn certified(&self) -> bool {
        self.not_proved.is_empty()
    }
}

/// What another budget would give.
#[derive(Debug, Clone)]
pub struct Change<'a> {
    /// Name of the budget.
    pub budget: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it would be.
    pub value: f64,
    /// The best combination then; `None` where there is none.
    pub best: Option<Combination<'a>>,
    /// Whether that was proved.
    pub certified: bool,
}

/// What stands in the way where no combination keeps the budgets.
#[derive(Debug, Clone, PartialEq)]
pub enum Wanting {
    /// No motor can do these joints, whatever the budgets.
    Joints(Vec<String>),
    /// The least mass of all actuators with which it can be done \[kg\].
    Mass(f64),
    /// The least number of different motors with which it can be done.
    Motors(usize),
    /// The least power at the worst instant with which a combination that was tried can do \[W\], and what one
    /// draws that is not limited \[W\].
    Power(f64, f64),
    /// Without the limit on what comes back there is a combination, which gives back so much at most \[W\].
    Returned(f64),
    /// The resistance of the supply: without it there is a combination.
    Supply,
    /// Whether any would do was not settled: the searches were ended.
    NotSettled,
}

/// The choice for a whole robot.
#[derive(Debug)]
pub struct Choice<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What is minimised.
    pub total: Total,
    /// Best first; each differs from those before it in a motor.
    pub combinations: Vec<Combination<'a>>,
    /// How sure the first is.
    pub proof: Proof,
    /// What is wanting where there is none: any of these alone, the others as they are.
    pub wanting: Vec<Wanting>,
    /// What other budgets would give.
    pub changes: Vec<Change<'a>>,
    /// Whether other budgets were not looked at, because this one took long or was not settled.
    pub others_left_out: bool,
    /// The best total for less and less mass.
    pub front: Vec<Combination<'a>>,
    /// Motors left out because they cannot be judged, with the joint where that is so, what and why.
    pub unjudged: Vec<Apart<'a>>,
    /// Names of joints that share a time base, for each time base.
    pub time_bases: Vec<Vec<String>>,
    /// Whether power was added up instant by instant over all joints.
    pub instant_by_instant: bool,
}

/// A motor that is left out at a joint because it cannot be judged there.
#[derive(Debug, Clone)]
pub struct Apart<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// The motor.
    pub motor: &'a Motor,
    /// What cannot be judged, and why.
    pub because: Vec<Remark>,
}
