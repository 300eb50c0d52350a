//! What a limit is: what is demanded, what may be had, and what kind of set of ratios that leaves.

use crate::actuator::candidate::Candidate;
use crate::actuator::parts::Whole;
use crate::actuator::shaft::End;
use crate::actuator::thermal_motion::TwoNode;
use crate::actuator::waveform::Functional;
use crate::numerics::laurent::Laurent;
use crate::requirement::{Joint, Robot};

/// Which ratios a limit leaves, as a function of u = N² with all else fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// All or none: the demand does not depend on the ratio.
    Fixed,
    /// All ratios up to one: an upper bound on N.
    UpperBound,
    /// Convex rows in (1/u, u, u²), exact under `u w ≥ 1`, `t ≥ u²`, as long as the shaft torque has
    /// no term of power zero (motor Coulomb friction); one interval of ratios.
    Convex,
    /// The complement of a convex set: up to two intervals of ratios.
    ReverseConvex,
}

impl Class {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Class::Fixed => "all ratios or none",
            Class::UpperBound => "all ratios up to one",
            Class::Convex => "one interval of ratios, convex in N²",
            Class::ReverseConvex => "up to two intervals of ratios: the complement of a convex set",
        }
    }
}

/// What is compared with the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Demand {
    /// Root mean square of the load torque, or with its sample the largest \[N·m\].
    Fixed(f64, Option<usize>),
    /// A number that depends on neither ratio nor motion.
    Constant(f64),
    /// A number of the parts that the actuator is made of.
    Parts(Whole),
    /// The average torque at the gear's output, ∛(mean(|ω||τ|³)/mean|ω|) \[N·m\].
    AverageTorque(f64),
    /// One polynomial in N.
    Polynomial(Laurent, Option<usize>),
    /// The largest of a functional over all samples.
    Samples(Functional),
    /// The same with the bandwidth torque on top.
    Bandwidth(Functional),
    /// Mass of motor and gear, by stages \[kg\].
    Mass,
    /// Largest rise of the winding's temperature over the motion \[K\].
    WindingPeak(TwoNode),
    /// Mean of the squared current of a motor whose iron saturates \[A²\], with so much of that at standstill counted
    /// once more.
    MeanCurrentSquared(f64),
}

impl Demand {
    /// The same of samples that come so many later.
    pub(super) fn later(self, by: usize) -> Demand {
        match self {
            Demand::Fixed(value, sample) => Demand::Fixed(value, sample.map(|k| k + by)),
            Demand::Polynomial(polynomial, sample) => Demand::Polynomial(polynomial, sample.map(|k| k + by)),
            other => other,
        }
    }

    /// True if neither ratio nor motion enters it.
    pub fn is_constant(&self) -> bool {
        matches!(self, Demand::Constant(_))
    }

    /// Whether it is dear at every ratio: a walk over all samples, or many where heat runs away. Such a limit is looked at
    /// where the others are kept.
    pub fn takes_a_walk(&self) -> bool {
        matches!(self, Demand::WindingPeak(_))
    }
}

/// A limit that applies to a candidate. In its natural unit the demand is `factor · √x` where
/// squared, else `factor · x`, x being the functional or polynomial.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Which limit.
    pub limit: &'static Limit,
    /// What is demanded.
    pub demand: Demand,
    /// Whether the functional is the square of the demand.
    pub squared: bool,
    /// Natural unit per functional (or per its root).
    pub factor: f64,
    /// Natural unit per positive functional; differs from `factor` where a negative bound asks for regenerative power.
    pub above_zero: f64,
    /// What may be had, natural unit.
    pub bound: f64,
    /// Whose limit it is.
    pub owner: &'static str,
    /// Of heat: the share of that at standstill that counts once more.
    pub standing: f64,
    /// At which end of what is known of the motor's drag the demand is.
    pub end: End,
    /// Of which of two actuators that do different things at the same time it is; `None` where it is of all.
    pub actuator: Option<usize>,
}

/// Whether a limit applies.
#[derive(Debug, Clone, Copy)]
pub enum Check {
    /// Nobody asked for it.
    NotAsked,
    /// It should be checked but cannot be: what is missing.
    Unknown(&'static str),
    /// It applies.
    Asked(Asked),
    /// What is known cannot reject a ratio: of the ratio that was chosen it is told what can be said.
    AtRatio(Judge),
}

/// What can be said of a limit at a ratio that was chosen.
pub type Judge = fn(&Candidate, f64) -> Verdict;

/// How a design stands against a limit that no ratio is rejected by, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// It is certainly kept.
    Kept,
    /// It counts as kept, as far as this holds.
    Assumed(&'static str),
    /// It cannot be judged: why.
    Unknown(&'static str),
}

/// The name of a limit, and what is to be said of it.
pub type Remark = (&'static str, &'static str);

/// What a limit or a need is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// Currents of the power-invariant q axis, the motor's own.
    QAxis,
    /// Ratings of the gear.
    Gear,
    /// Anything else.
    Other,
}

/// Which numbers of a motor demand and bound of a limit depend on: what a tolerance of them does to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depends {
    /// As a current: what load and rotor demand, over the torque constant; rated current, or what heats the winding.
    Current,
    /// As the temperature of the winding over the motion.
    Temperature,
    /// As the torque at the shaft.
    Torque,
    /// As the voltage of resistance, inductance and both constants.
    Voltage,
    /// As the voltage of the windings when nothing flows in them.
    BackEmf,
    /// As power that is taken.
    Power,
    /// As power that comes back.
    PowerBack,
    /// As the rotor's inertia.
    Inertia,
    /// On a rating or a mass alone, whose worse end is known.
    Rating,
    /// In some other way: every corner of the tolerances counts.
    Anyhow,
}

impl Depends {
    /// Whether the motor's drag is part of what is demanded.
    pub fn is_of_drag(self) -> bool {
        match self {
            Depends::Current
            | Depends::Temperature
            | Depends::Torque
            | Depends::Voltage
            | Depends::Power
            | Depends::PowerBack
            | Depends::BackEmf
            | Depends::Anyhow => true,
            Depends::Inertia | Depends::Rating => false,
        }
    }
}

/// Where a requirement asks for something: the keys on the way to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// From the top of the requirement.
    Robot(&'static [&'static str]),
    /// From the joint.
    Joint(&'static [&'static str]),
}

/// A limit of the model.
#[derive(Clone, Copy)]
pub struct Limit {
    /// Name, also in JSON.
    pub name: &'static str,
    /// Unit of demand and bound; [`MONEY`] where it is the currency of the requirement.
    pub unit: &'static str,
    /// What is compared.
    pub formula: &'static str,
    /// Whether the demand has the requirement's safety factor in it.
    pub safety: bool,
    /// What it is a limit of.
    pub of: Of,
    /// Which ratios it leaves.
    pub class: Class,
    /// Which numbers of a motor it depends on.
    pub depends: Depends,
    /// Whether the requirement itself asks for it: then a design of which it cannot be judged is no choice.
    pub stated: fn(&Robot, &Joint) -> bool,
    /// Where a requirement asks for it, by whose the limit is; `None` where a data sheet does.
    pub key: fn(&str) -> Option<Key>,
    pub(super) prepare: fn(&Candidate) -> Prepared,
}

impl std::fmt::Debug for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What a limit says of a candidate, before it is tied to its name.
pub(super) enum Prepared {
    NotAsked,
    Unknown(&'static str),
    Asked { demand: Demand, squared: bool, factor: f64, bound: f64, owner: &'static str, standing: f64 },
    AtRatio(Judge),
}

impl Limit {
    /// Whether demand and bound are q-axis amperes (power invariant), not those of a phase or of the bus.
    pub fn is_q_axis(&self) -> bool {
        self.of == Of::QAxis
    }

    /// The unit of demand and bound for a robot.
    pub fn unit_for(&self, robot: &Robot) -> &'static str {
        match (self.unit, &robot.prices) {
            (MONEY, Some(prices)) => prices.currency.code(),
            (unit, _) => unit,
        }
    }

    /// Whether a drive's current may be what it is of.
    pub fn is_of_drive(&self) -> bool {
        self.depends == Depends::Current && (self.key)("drive") == by_drive("drive")
    }
}

/// A limit on the square of the shaft torque.
pub(super) fn torque(demand: Demand, factor: f64, bound: f64, owner: &'static str) -> Prepared {
    Prepared::Asked { demand, squared: true, factor, bound, owner, standing: 0.0 }
}

/// A limit on something that needs no square.
pub(super) fn plain(demand: Demand, factor: f64, bound: f64, owner: &'static str) -> Prepared {
    Prepared::Asked { demand, squared: false, factor, bound, owner, standing: 0.0 }
}

/// Nothing in a requirement asks for it: a data sheet does.
pub(super) fn by_data_sheets(_: &Robot, _: &Joint) -> bool {
    false
}

/// The voltage is what every requirement has, not a limit that somebody put; without inductance it is checked
/// without it, which is said (see [`NEEDS`]).
pub(super) fn the_supply(_: &Robot, _: &Joint) -> bool {
    false
}

/// Heat is always a limit, whoever says how much.
pub(super) fn always(_: &Robot, _: &Joint) -> bool {
    true
}

/// A rating of the gear that the requirement describes, not of one from the catalogue.
pub(super) fn described(joint: &Joint, rating: Option<f64>) -> bool {
    rating.is_some() && !joint.has_published_gears()
}

/// The unit of a limit on a price: the currency of `[prices]`.
pub const MONEY: &str = "currency";

pub(super) const NO_DURATIONS: &str = "the operating points have no durations";

pub(super) const NO_MASS: &str = "the mass of motor or gear is not known";

/// No requirement asks for it.
pub(super) fn by_nobody(_: &str) -> Option<Key> {
    None
}

/// The drive's own current.
pub(super) fn by_drive(owner: &str) -> Option<Key> {
    (owner == "drive").then_some(Key::Robot(&["bus", "drive_current"]))
}

/// A temperature that the requirement states.
pub(super) fn by_temperature(owner: &str) -> Option<Key> {
    (owner == "requirement").then_some(Key::Joint(&["limits", "winding_temperature"]))
}

/// Mean heat in the copper as a limit on a current \[A\], with the share `standing` of that at standstill counted
/// once more.
pub(super) fn heating(candidate: &Candidate, standing: f64, bound: f64, owner: &'static str) -> Prepared {
    let (demand, factor) = if candidate.actuator.shortfall.saturates() {
        (Demand::MeanCurrentSquared(standing), 1.0)
    } else {
        let mean = candidate.load.mean_torque_squared_standing(&candidate.actuator, standing);
        let factor = candidate.actuator.rms_current_per_torque();
        (Demand::Polynomial(mean * candidate.load.share_of_time, None), factor)
    };
    Prepared::Asked { demand, squared: true, factor, bound, owner, standing }
}

/// A limit on the voltage, by its name: of the motor where the supply is stiff, of the open circuit where it sags. The
/// reserve of that is in the supply already.
pub(super) fn voltage(candidate: &Candidate, name: &str, over: fn(Functional) -> Demand) -> Prepared {
    let reserve = candidate.joint.limits.reserve(name);
    match (candidate.supply(reserve), candidate.weakening()) {
        (None, None) => torque(over(Functional::VoltageSquared), 1.0, candidate.voltage(), "bus"),
        (None, Some(most)) => {
            // All phases of a superposed torque have one current against the magnets: that which the ratio asks for.
            let least = Functional::LeastVoltage(most * candidate.actuator.torque_constant);
            let functional = match over(least) {
                Demand::Samples(_) => least,
                _ => Functional::VoltageSquared,
            };
            torque(over(functional), 1.0, candidate.voltage(), "bus")
        }
        (Some(supply), _) => plain(over(Functional::OpenVoltage(supply)), 1.0, candidate.robot.bus.voltage, "bus"),
    }
}

/// A limit on the largest current \[A\], of what the ripple leaves of it.
pub(super) fn peak(candidate: &Candidate, demand: Demand, bound: f64, owner: &'static str) -> Prepared {
    let safety = candidate.joint.limits.safety;
    let bound = candidate.actuator.shortfall.left_of_current(bound, safety);
    torque(demand, safety / candidate.actuator.torque_constant, bound, owner)
}
