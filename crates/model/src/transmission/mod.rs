//! What is between an actuator and its joint: belts, linkages, levers with a screw.
//!
//! The one idea: the actuator turns by θ = g(q) where the joint turns by q. With r = dθ/dq the motion of the joint becomes that of
//! the actuator before a ratio is looked for: θ̇ = r q̇, θ̈ = r q̈ + r' q̇², torque over r. Whatever comes after sees a motion, so that limits,
//! program and certificate stay as they are.

mod both;
mod coupled;
mod coupler;
mod four_bar;
mod lever;
mod passed;
mod range;
pub mod read;
mod table;

pub use both::Both;
pub use coupler::{Coupler, JacobianTable, Rod};
pub use four_bar::{Branch, FourBar};
pub use lever::Lever;
pub use passed::{Levers, Passed, SpringAt, Via, Ways};
pub use range::Range;
pub use table::Table;

/// A transmission at one angle of the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// Angle of the actuator \[rad\], θ.
    pub angle: f64,
    /// r = dθ/dq: more than one reduces further.
    pub ratio: f64,
    /// dr/dq \[1/rad\].
    pub slope: f64,
    /// d²r/dq² \[1/rad²\].
    pub bend: f64,
    /// Moment arm about the joint of the rod or screw \[m\]: its force is the joint's torque over it. `None` where nothing says it.
    pub arm: Option<f64>,
}

/// How the joint's angle gives the actuator's.
#[derive(Debug, Clone, PartialEq)]
pub enum Way {
    /// One ratio: belt, chain, bevel gear.
    Ratio(f64),
    /// Over the joint's angle, from a table.
    Table(Table),
    /// A planar linkage: a crank on the actuator, a coupler, a rocker on the joint.
    FourBar(FourBar),
    /// A screw or linear actuator on a lever of the joint.
    Lever(Lever),
}

/// Why a transmission cannot be at an angle of the joint \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// The links do not reach: there is no such position.
    Open(f64),
    /// The rod is in line with the crank: the joint is at the end of its way.
    CrankInLine(f64),
    /// The rod is in line with the joint's axis: no torque of the actuator reaches the joint.
    NoArm(f64),
    /// The ratio is zero or changes its sign.
    Reverses(f64),
    /// The angle is outside of the table, from its smallest to its largest angle \[rad\].
    Outside(f64, [f64; 2]),
    /// Of two joints: the rod of an actuator, counted from one, does not reach.
    OpenAt([f64; 2], usize),
    /// Of two joints: the rod of an actuator is in line with its crank.
    InLineAt([f64; 2], usize),
    /// Of two joints: both actuators pull in nearly the same direction.
    SingularAt([f64; 2]),
    /// Of two joints: the angles are outside of the table.
    OutsideAt([f64; 2]),
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let number = crate::words::number;
        let angle = |q: f64| format!("{} rad ({} deg)", number(q), number(q.to_degrees()));
        let both = |[a, b]: [f64; 2]| format!("{} and {}", angle(a), angle(b));
        match *self {
            Fault::OpenAt(q, of) => write!(f, "at {} the rod of actuator {of} does not reach", both(q)),
            Fault::InLineAt(q, of) => {
                write!(f, "at {} the rod of actuator {of} is in line with its crank: a dead point", both(q))
            }
            Fault::SingularAt(q) => {
                write!(f, "at {} both actuators pull in nearly the same direction: one torque cannot be made", both(q))
            }
            Fault::OutsideAt(q) => write!(f, "the motion is at {}, outside of the table", both(q)),
            Fault::Open(q) => write!(f, "at {} the links do not reach each other", angle(q)),
            Fault::CrankInLine(q) => write!(f, "at {} the crank is in line with the coupler: a dead point", angle(q)),
            Fault::NoArm(q) => {
                write!(f, "at {} the rod is in line with the joint's axis: no torque reaches the joint", angle(q))
            }
            Fault::Reverses(q) => write!(f, "at {} the ratio is zero or changes its sign", angle(q)),
            Fault::Outside(q, [low, high]) => write!(
                f,
                "the motion is at {}, outside of the table, which is from {} to {} rad",
                angle(q),
                number(low),
                number(high)
            ),
        }
    }
}

/// A moment arm that is a smaller share of its link than this is none: 0.6 degrees from a dead point.
const LEAST_ARM: f64 = 0.01;

impl Way {
    /// The transmission at an angle of the joint \[rad\].
    ///
    /// # Errors
    /// It cannot be there, or passes no torque.
    pub fn at(&self, q: f64) -> Result<At, Fault> {
        let at = match self {
            Way::Ratio(r) => At { angle: r * q, ratio: *r, slope: 0.0, bend: 0.0, arm: None },
            Way::Table(table) => table.at(q)?,
            Way::FourBar(linkage) => linkage.at(q)?,
            Way::Lever(lever) => lever.at(q)?,
        };
        if at.ratio == 0.0 || !at.ratio.is_finite() { Err(Fault::Reverses(q)) } else { Ok(at) }
    }

    /// The same on its branch where the joint is at `q` \[rad\], where it has branches.
    #[must_use]
    pub fn around(self, q: f64) -> Way {
        match self {
            Way::FourBar(linkage) => Way::FourBar(linkage.on(q)),
            other => other,
        }
    }

    /// Whether the ratio is the same at every angle.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Way::Ratio(ratio) => Some(*ratio),
            _ => None,
        }
    }

    /// What it is, in a word or two.
    pub fn word(&self) -> &'static str {
        match self {
            Way::Ratio(_) => "ratio",
            Way::Table(_) => "table",
            Way::FourBar(_) => "four-bar linkage",
            Way::Lever(_) => "lever with a screw",
        }
    }

    /// The smallest and the largest |r| over all angles between two \[rad\], which can be reached with a ratio of one sign.
    ///
    /// # Errors
    /// The first angle of a fine grid at which that is not so.
    pub fn ratios(&self, low: f64, high: f64) -> Result<[f64; 2], Fault> {
        const LOOKS: usize = 2000;
        let (mut sign, mut ends) = (0.0, [f64::INFINITY, 0.0_f64]);
        for k in 0..=LOOKS {
            let q = low + (high - low) * k as f64 / LOOKS as f64;
            let at = self.at(q)?;
            if sign * at.ratio < 0.0 {
                return Err(Fault::Reverses(q));
            }
            sign = at.ratio.signum();
            ends = [ends[0].min(at.ratio.abs()), ends[1].max(at.ratio.abs())];
        }
        Ok(ends)
    }
}

/// What is between an actuator and its joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Transmission {
    /// How the angles go together.
    pub way: Way,
    /// What it loses, weighs and bears.
    pub numbers: Numbers,
}

/// What is between two actuators and two joints that both of them drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// How the angles go together.
    pub coupler: Coupler,
    /// What it loses, weighs and bears; the mass is that of all of it, inertias are those of one actuator and of each joint.
    pub numbers: Numbers,
}

/// What a transmission loses, weighs and bears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers {
    /// Efficiency when the actuator drives.
    pub efficiency: f64,
    /// Efficiency when the joint drives.
    pub backdrive_efficiency: f64,
    /// Whether an efficiency is said.
    pub says_loss: bool,
    /// Inertia that turns with the actuator \[kg·m²\], J_t.
    pub inertia: f64,
    /// Inertia that turns with the joint \[kg·m²\], J_j.
    pub joint_inertia: f64,
    /// Mass \[kg\]; `None` where it is not said.
    pub mass: Option<f64>,
    /// Largest torque at the joint \[N·m\].
    pub peak_torque: Option<f64>,
    /// Largest force of rod or screw \[N\].
    pub max_force: Option<f64>,
    /// Largest speed of its input \[rad/s\].
    pub max_input_speed: Option<f64>,
    /// Backlash of its own at the joint \[rad\].
    pub backlash: Option<f64>,
    /// Stiffness of its own at the joint \[N·m/rad\].
    pub stiffness: Option<f64>,
    /// Its size across the actuator's axis \[m\].
    pub outer_diameter: Option<f64>,
    /// What it adds to the actuator along its axis \[m\].
    pub length: Option<f64>,
    /// What it costs, in the currency of the requirement.
    pub price: Option<f64>,
    /// How long until it is delivered \[s\].
    pub lead_time: Option<f64>,
}

impl Numbers {
    /// No loss, no inertia, and nothing else known.
    pub const IDEAL: Numbers = Numbers {
        efficiency: 1.0,
        backdrive_efficiency: 1.0,
        says_loss: false,
        inertia: 0.0,
        joint_inertia: 0.0,
        mass: None,
        peak_torque: None,
        max_force: None,
        max_input_speed: None,
        backlash: None,
        stiffness: None,
        outer_diameter: None,
        length: None,
        price: None,
        lead_time: None,
    };

    /// Whether power is lost.
    pub fn is_lossy(&self) -> bool {
        self.efficiency != 1.0 || self.backdrive_efficiency != 1.0
    }

    /// What the actuator gives of what the joint takes: 1/η where it drives or holds, η_b where the joint drives.
    fn factor(&self, torque: f64, velocity: f64) -> f64 {
        if torque * velocity < 0.0 { self.backdrive_efficiency } else { 1.0 / self.efficiency }
    }
}
