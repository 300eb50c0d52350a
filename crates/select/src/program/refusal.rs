//! Why a ratio program gave no optimum.

use std::fmt;

use super::bind::Bind;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::words::number;

/// Why no ratio keeps all limits.
#[derive(Debug, Clone, PartialEq)]
pub enum Infeasible {
    /// One limit is exceeded at every ratio: by how much at its best ratio.
    Never {
        /// The limit, with its sample.
        bind: Bind,
        /// Least demand over the limit, at the ratio where it is least.
        least: f64,
        /// The limit, in its natural unit; of one of zero there are no multiples.
        allowed: f64,
        /// That ratio.
        ratio: f64,
    },
    /// One limit needs at least a ratio, another allows only a smaller one.
    Contradiction {
        /// Needs `N ≥ at_least`.
        low: Bind,
        /// The smallest ratio it allows.
        at_least: f64,
        /// Needs `N ≤ at_most`.
        high: Bind,
        /// The largest ratio it allows.
        at_most: f64,
    },
    /// No ratio of the grid keeps all limits; the best one breaks this limit.
    Nowhere {
        /// The limit, with its sample.
        bind: Bind,
        /// Demand over limit there.
        least: f64,
        /// The limit, in its natural unit; of one of zero there are no multiples.
        allowed: f64,
        /// That ratio.
        ratio: f64,
    },
}

/// Why there is no optimum.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// No ratio keeps all limits; why.
    Infeasible(Infeasible),
    /// The objective has no lower bound over the feasible ratios.
    Unbounded,
    /// There is no answer that could be verified; why.
    NotSolved(Unsolved),
}

/// Why a search has no answer that could be verified.
#[derive(Debug, Clone, PartialEq)]
pub enum Unsolved {
    /// The mass of motor or gear is not known.
    NoMass,
    /// A spring needs the position, and the motion says none.
    NoPosition,
    /// A spring is wanted of a joint that asks for none.
    NoSpringAsked,
    /// A spring is not chosen for a motor with the effects that were fitted to it.
    SpringWithEffects,
    /// The window of feasible ratios was not found in so many steps.
    NoWindow(usize),
    /// A family of gears says nothing of some ratio that may be chosen.
    OutsideMap,
    /// The solver's answer is not a finite number.
    NotFinite,
    /// The solver's answer breaks a limit.
    BreaksLimit,
    /// The solver's answer is further from its bound than a proof allows: the relative gap.
    Gap(f64),
    /// No feasible ratio was found, and none was ruled out.
    NothingRuledOut,
    /// The same with a spring.
    NothingRuledOutWithSpring,
    /// No feasible ratio was found, but a limit is nearly kept at one.
    Nearly {
        /// The limit.
        limit: &'static str,
        /// The least demand over limit.
        least: f64,
        /// The ratio that has it.
        ratio: f64,
    },
    /// No ratio between the best ones of two quantities keeps every limit.
    NoneBetween,
    /// The tolerance of a column of the catalogue reaches zero.
    ToleranceReachesZero(std::borrow::Cow<'static, str>),
}

/// What a spring that nobody found is of.
const SPRING: &str = "spring";
const NO_SPRING: &str = "no feasible ratio and spring was found, and none was ruled out";

impl Unsolved {
    /// What is not settled by a search for a spring: whether there is a design is not known then.
    pub fn unknown(&self) -> Option<Remark> {
        match self {
            Unsolved::SpringWithEffects => Some((SPRING, "none is chosen for a motor with these effects")),
            Unsolved::NothingRuledOutWithSpring => Some((SPRING, NO_SPRING)),
            _ => None,
        }
    }
}

impl fmt::Display for Unsolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unsolved::NoMass => f.write_str("the mass of motor or gear is not known"),
            Unsolved::NoPosition => f.write_str("a spring needs a motion with a position"),
            Unsolved::NoSpringAsked => f.write_str("the joint asks for no spring"),
            Unsolved::SpringWithEffects => f.write_str("a spring is not chosen for a motor with these fitted effects"),
            Unsolved::NoWindow(steps) => write!(f, "the window was not found in {steps} steps"),
            Unsolved::OutsideMap => f.write_str("the gear's `map` or family says nothing of some of the ratios"),
            Unsolved::NotFinite => f.write_str("the solution is not a finite number"),
            Unsolved::BreaksLimit => f.write_str("the solution breaks a limit"),
            Unsolved::Gap(gap) => write!(f, "the duality gap is {gap:.1e}"),
            Unsolved::NothingRuledOut => f.write_str("no feasible ratio was found, and none was ruled out"),
            Unsolved::NothingRuledOutWithSpring => f.write_str(NO_SPRING),
            Unsolved::Nearly { limit, least, ratio } => {
                let (least, ratio) = (number(*least), number(*ratio));
                write!(
                    f,
                    "no feasible ratio was found, and none was ruled out; nearest is N = {ratio} with {least} times what \
                     {limit} allows"
                )
            }
            Unsolved::NoneBetween => f.write_str("no ratio between the two best ones keeps every limit"),
            Unsolved::ToleranceReachesZero(column) => write!(f, "the tolerance of {column} reaches zero"),
        }
    }
}
