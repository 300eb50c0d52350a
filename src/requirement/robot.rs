//! What a requirement file says, in SI.

use super::mechanism::Driven;
use crate::catalog::convention::Modulation;
use crate::motion::Motion;
use crate::units::{self, Kind};

/// A robot: its supply, its surroundings and its joints.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// The supply.
    pub bus: Bus,
    /// Ambient temperature \[K\].
    pub ambient: f64,
    /// What the whole robot may have.
    pub budget: Budget,
    /// The joints.
    pub joints: Vec<Joint>,
    /// Where motions come from a description of the robot: what was done with it.
    pub driven: Option<Driven>,
}

/// The electrical supply that all joints share.
#[derive(Debug, Clone, Copy)]
pub struct Bus {
    /// Bus voltage \[V\].
    pub voltage: f64,
    /// How the drives make phase voltages of it.
    pub modulation: Modulation,
    /// Share of the ideal voltage that the drive can use.
    pub modulation_limit: f64,
    /// Largest current of the drive, phase amplitude (DC ampere for a brushed motor) \[A\].
    pub drive_current: Option<f64>,
    /// Largest power that the bus delivers to one joint; [`Budget::power`] is that of all together \[W\].
    pub power: Option<f64>,
    /// Largest current that the bus delivers to one joint \[A\].
    pub current: Option<f64>,
    /// What the bus takes back.
    pub regeneration: Regeneration,
    /// Efficiency of the drive, η_d.
    pub drive_efficiency: f64,
}

/// What the bus does with power that comes back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Regeneration {
    /// It takes all of it.
    Allowed,
    /// It takes at most this much at any instant \[W\]; zero is "none".
    Limited(f64),
}

/// Limits of the whole robot.
#[derive(Debug, Clone, Copy, Default)]
pub struct Budget {
    /// Mass of all actuators together \[kg\].
    pub actuator_mass: Option<f64>,
    /// Number of different motors.
    pub max_distinct_motors: Option<u32>,
    /// Power that the bus delivers to all joints together at any instant \[W\].
    pub power: Option<f64>,
    /// Current that the bus delivers to all joints together at any instant \[A\].
    pub current: Option<f64>,
}

impl Robot {
    /// Power that all joints together may draw at any instant \[W\]: the smaller of the budgets of power
    /// and of current.
    pub fn shared_power(&self) -> Option<f64> {
        let of_current = self.budget.current.map(|i| i * self.bus.voltage);
        self.budget.power.into_iter().chain(of_current).reduce(f64::min)
    }

    /// Whether another joint carries the actuator of a joint.
    pub fn carries(&self, joint: &Joint) -> bool {
        let carried = |j: &Joint| j.carries.iter().any(|c| self.joints[c.joint].name == joint.name);
        self.joints.iter().any(carried)
    }

    /// Whether the joints' choices depend on each other: a budget, or actuators that carry actuators.
    pub fn is_coupled(&self) -> bool {
        let Budget { actuator_mass, max_distinct_motors, power, current } = self.budget;
        let budgets = [actuator_mass, power, current].iter().any(Option::is_some) || max_distinct_motors.is_some();
        budgets || self.joints.iter().any(|j| !j.carries.is_empty())
    }
}

/// Another joint's actuator that a joint carries.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried {
    /// Index of the joint whose actuator is carried.
    pub joint: usize,
    /// How much the load torque rises per kilogram of one such actuator, at each sample \[N·m/kg\].
    pub torque_per_mass: Vec<f64>,
    /// Its rate \[N·m/(kg·s)\].
    pub rate: Vec<f64>,
    /// Whether it is the same at every sample.
    pub constant: bool,
}

/// One joint, or several alike.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// How many joints like this the robot has.
    pub count: u32,
    /// Which ratios may be chosen.
    pub ratio: RatioChoice,
    /// The gear that goes with a continuous ratio.
    pub gear: GearModel,
    /// What the joint does.
    pub motion: Motion,
    /// What makes a choice good.
    pub objective: Objective,
    /// What a choice must keep.
    pub limits: Limits,
    /// Largest drive current of this joint, in place of the bus's \[A\].
    pub drive_current: Option<f64>,
    /// By how much of the period each of the `count` joints is late; empty where all move alike.
    pub phases: Vec<f64>,
    /// Whose actuators this joint carries.
    pub carries: Vec<Carried>,
}

impl Joint {
    /// Whether another joint, looked at by itself, asks the same of its actuator: whatever its name, however
    /// many there are, when they move and whatever they carry.
    pub fn asks_the_same(&self, other: &Joint) -> bool {
        let Joint { name: _, count: _, ratio, gear, motion, objective, limits, drive_current, phases: _, carries: _ } =
            self;
        *ratio == other.ratio
            && *gear == other.gear
            && *objective == other.objective
            && *limits == other.limits
            && *drive_current == other.drive_current
            && *motion == other.motion
    }
}

/// Where the ratio of a joint comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum RatioChoice {
    /// Any ratio in an interval.
    Continuous {
        /// Smallest ratio.
        min: f64,
        /// Largest ratio.
        max: f64,
    },
    /// The gears of the catalogue whose id matches one of the patterns.
    Catalog {
        /// The patterns, `*` for any run of characters.
        patterns: Vec<String>,
        /// What a gear's efficiency acts on.
        efficiency_covers: EfficiencyCovers,
    },
}

/// What torque a gear's efficiency acts on, and whose direction of power it flips with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EfficiencyCovers {
    /// The load torque alone.
    Load,
    /// Load torque and the gear's own inertia (the convention of CORDS): the flip depends on the ratio.
    LoadAndGear,
}

impl EfficiencyCovers {
    /// Both with the word a requirement uses for them.
    pub const NAMES: &[(&str, EfficiencyCovers)] =
        &[("load", EfficiencyCovers::Load), ("load_and_gear", EfficiencyCovers::LoadAndGear)];
}

/// The gear assumed at a continuous ratio. SI; torques at the output, inertia and speed at the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearModel {
    /// Efficiency when the motor drives, η.
    pub efficiency: f64,
    /// Efficiency when the load drives, η_b; `2 − 1/η` unless given.
    pub backdrive_efficiency: f64,
    /// Mass, where it does not depend on the ratio \[kg\].
    pub mass: Option<f64>,
    /// Mass per stage \[kg\] and the largest ratio of a stage.
    pub mass_per_stage: Option<(f64, f64)>,
    /// Inertia at the input \[kg·m²\], J_g.
    pub inertia: f64,
    /// Largest output torque \[N·m\].
    pub peak_torque: Option<f64>,
    /// Output torque that can be carried for ever \[N·m\].
    pub continuous_torque: Option<f64>,
    /// Largest input speed \[rad/s\].
    pub max_input_speed: Option<f64>,
}

impl GearModel {
    /// A gear without loss, mass and inertia.
    pub const IDEAL: GearModel = GearModel {
        efficiency: 1.0,
        backdrive_efficiency: 1.0,
        mass: Some(0.0),
        mass_per_stage: None,
        inertia: 0.0,
        peak_torque: None,
        continuous_torque: None,
        max_input_speed: None,
    };

    /// Mass at a ratio \[kg\]: the fixed one, or as many stages as the ratio takes.
    pub fn mass_at(&self, ratio: f64) -> Option<f64> {
        match self.mass_per_stage {
            Some((mass, stage_ratio)) => Some(mass * f64::from(stages(ratio, stage_ratio))),
            None => self.mass,
        }
    }
}

/// Number of stages of at most `stage_ratio` that make `ratio`: none up to a ratio of one.
pub fn stages(ratio: f64, stage_ratio: f64) -> u32 {
    if ratio <= 1.0 {
        return 0;
    }
    let exact = ratio.ln() / stage_ratio.ln();
    // A ratio that is a power of the stage ratio needs no further stage for rounding's sake.
    (exact - 1e-9).ceil().max(1.0) as u32
}

/// Backdrive efficiency that belongs to a forward efficiency where friction is the same both ways:
/// `2 − 1/η`; below η = ½ the gear locks and it is negative.
pub fn backdrive_efficiency(efficiency: f64) -> f64 {
    2.0 - 1.0 / efficiency
}

/// What an objective can be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Mean copper loss \[W\].
    Loss,
    /// Inertia at the output \[kg·m²\], N²(J_m + J_g).
    ReflectedInertia,
    /// Largest q-axis current \[A\].
    PeakCurrent,
    /// Mass of motor and gear \[kg\].
    Mass,
    /// Electrical energy drawn from the bus per cycle \[J\]; what comes back counts as far as the
    /// drive's efficiency lets it.
    Energy,
    /// Largest electrical power drawn from the bus \[W\].
    PeakPower,
}

impl Quantity {
    /// Every quantity with its name.
    pub const NAMES: &[(&str, Quantity)] = &[
        ("loss", Quantity::Loss),
        ("reflected_inertia", Quantity::ReflectedInertia),
        ("peak_current", Quantity::PeakCurrent),
        ("mass", Quantity::Mass),
        ("energy", Quantity::Energy),
        ("peak_power", Quantity::PeakPower),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Quantity::NAMES.iter().find(|(_, q)| *q == self).map_or("", |(name, _)| name)
    }

    /// What it measures.
    pub fn kind(self) -> &'static Kind {
        match self {
            Quantity::Loss | Quantity::PeakPower => &units::POWER,
            Quantity::ReflectedInertia => &units::INERTIA,
            Quantity::PeakCurrent => &units::CURRENT,
            Quantity::Mass => &units::MASS,
            Quantity::Energy => &units::ENERGY,
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        self.kind().si
    }
}

/// What is minimised: a sum of quantities, each times a weight. A single quantity with weight one reads in its own
/// unit; with another weight it is a pure number like any weighted sum.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    /// Quantities with weight over reference \[1/unit of the quantity\].
    pub terms: Vec<(Quantity, f64)>,
}

impl Objective {
    /// A single quantity.
    pub fn single(quantity: Quantity) -> Objective {
        Objective { terms: vec![(quantity, 1.0)] }
    }

    /// The quantity, where there is only one and it has weight one.
    pub fn sole(&self) -> Option<Quantity> {
        match self.terms.as_slice() {
            [(quantity, weight)] if *weight == 1.0 => Some(*quantity),
            _ => None,
        }
    }

    /// The quantity and its weight, where there is only one and its weight is another than one: the program is that of
    /// the quantity alone, its value times the weight.
    pub fn weighed(&self) -> Option<(Quantity, f64)> {
        match self.terms.as_slice() {
            [(quantity, weight)] if *weight != 1.0 => Some((*quantity, *weight)),
            _ => None,
        }
    }

    /// Weight of a quantity; zero where it does not count.
    pub fn weight(&self, quantity: Quantity) -> f64 {
        self.terms.iter().find(|(q, _)| *q == quantity).map_or(0.0, |(_, w)| *w)
    }

    /// Name for people, e.g. `loss`, `loss + reflected_inertia`, or `weighted loss` for one quantity with a weight.
    pub fn name(&self) -> String {
        if let Some((quantity, _)) = self.weighed() {
            return format!("weighted {}", quantity.name());
        }
        self.terms.iter().map(|(q, _)| q.name()).collect::<Vec<_>>().join(" + ")
    }

    /// Unit of the value: that of the quantity, or `1` for a weighted sum.
    pub fn unit(&self) -> &'static str {
        self.sole().map_or("1", Quantity::unit)
    }
}

/// Limits that a requirement puts on a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Mass of motor and gear \[kg\].
    pub actuator_mass: Option<f64>,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: Option<f64>,
    /// Torque to be delivered on top of the motion.
    pub torque_bandwidth: Option<TorqueBandwidth>,
    /// Highest winding temperature \[K\].
    pub winding_temperature: Option<f64>,
    /// Factor on demanded torque and current in peak checks (not on heat).
    pub safety: f64,
    /// A spring parallel to the actuator, to be chosen.
    pub spring: Option<Spring>,
}

/// What a spring parallel to the actuator may be: it pulls the joint towards its rest angle with
/// `k (q_0 − q)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Smallest and largest stiffness \[N·m/rad\], k.
    pub stiffness: [f64; 2],
    /// Smallest and largest rest angle \[rad\], q_0, on the scale of the motion's position.
    pub rest_angle: [f64; 2],
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            actuator_mass: None,
            reflected_inertia: None,
            torque_bandwidth: None,
            winding_temperature: None,
            safety: 1.0,
            spring: None,
        }
    }
}

/// A sinusoidal torque at the output on top of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueBandwidth {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Amplitude \[N·m\].
    pub amplitude: f64,
}
