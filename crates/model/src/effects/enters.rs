//! How an effect enters the limits of the model, as data.

use super::Operating;
use super::features::{FEATURE_POWER, ShaftForm};

/// How an effect with its values enters the limits of the model.
#[derive(Debug, Clone, Copy)]
pub enum Enters {
    /// Torque that the shaft must supply, linear in features of a sample: a polynomial in the ratio.
    Features(ShaftForm),
    /// Torque that depends on an angle alone: its amplitude \[N·m\].
    Ripple(f64),
    /// Torque that depends on the motor's angle and is proportional to current: its amplitude \[N·m/A\].
    RippleOfCurrent(f64),
    /// Torque falls short of the straight line at a current i: by `slope (i − current tanh(i/current))`.
    Saturation {
        /// \[N·m/A\].
        slope: f64,
        /// \[A\].
        current: f64,
    },
    /// Voltage that the motor does not get \[V, q axis\].
    Voltage(f64),
    /// Loss of the gear in proportion to the load: `1/η` grows by it.
    Efficiency {
        /// γ.
        loss: f64,
    },
    /// The torque constant falls with temperature.
    TorqueConstant {
        /// \[N·m/(A·K)\].
        per_kelvin: f64,
    },
    /// Torque that is no polynomial in the ratio: evaluated at every ratio of a refined grid. Its derivative by the speed
    /// of the motor \[N·m·s/rad\], from its values; the jump of a sign is left out.
    Evaluated(fn(&[f64], &Operating) -> f64),
    /// Not at all: why.
    NotAtAll(&'static str),
}

/// How the optimum is proved where an effect enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proof {
    /// The program stays conic.
    Conic,
    /// By branch and bound.
    BranchAndBound,
    /// Not certified.
    None,
    /// Nothing to prove.
    NotNeeded,
}

impl Enters {
    /// How the optimum is proved. Even powers of the ratio in the squares of torque and voltage keep the program conic: the
    /// load and the acceleration come with N^∓1, so a feature must have an odd power too.
    pub fn proof(&self) -> Proof {
        match self {
            Enters::Features(form) => {
                let odd = form.0.iter().zip(FEATURE_POWER).all(|(c, power)| *c == 0.0 || power % 2 != 0);
                if odd { Proof::Conic } else { Proof::BranchAndBound }
            }
            Enters::Ripple(_)
            | Enters::RippleOfCurrent(_)
            | Enters::Saturation { .. }
            | Enters::Voltage(_)
            | Enters::Efficiency { .. }
            | Enters::TorqueConstant { .. } => Proof::Conic,
            Enters::Evaluated(_) => Proof::None,
            Enters::NotAtAll(_) => Proof::NotNeeded,
        }
    }

    /// In a few words, with the proof.
    pub fn words(&self) -> &'static str {
        match (self, self.proof()) {
            (Enters::Features(_), Proof::Conic) => {
                "enters torque and voltage at every instant; the optimum is certified"
            }
            (Enters::Features(_), _) => "enters torque and voltage at every instant; certified by branch and bound",
            (Enters::Efficiency { .. }, _) => "enters as the gear's efficiency; the optimum is certified",
            (Enters::Evaluated(_), _) => "is evaluated on a refined grid of ratios; the optimum is not certified",
            (Enters::NotAtAll(_), _) => "does not enter the limits",
            (
                Enters::Ripple(_)
                | Enters::RippleOfCurrent(_)
                | Enters::Saturation { .. }
                | Enters::Voltage(_)
                | Enters::TorqueConstant { .. },
                _,
            ) => "enters as a bound; the optimum is certified",
        }
    }

    /// What it does to the limits, in words, where nothing stands in its way. Whether N* is proved is for all effects
    /// together to say.
    pub fn detail(&self) -> String {
        match self {
            Enters::Features(_) => "enters torque and voltage at every instant".into(),
            Enters::Ripple(_) | Enters::RippleOfCurrent(_) => {
                "enters peak torque and current by its amplitude and heat by its mean square (not voltage and power)"
                    .into()
            }
            Enters::Saturation { .. } => {
                "enters current, heat, voltage and power at every instant (regenerative power takes the straight line, which is more)".into()
            }
            Enters::Voltage(_) => "lowers the available voltage".into(),
            Enters::Efficiency { .. } => "enters as the gear's efficiency".into(),
            Enters::TorqueConstant { .. } => {
                "enters as the torque constant at the highest allowed winding temperature".into()
            }
            Enters::Evaluated(_) => self.words().into(),
            Enters::NotAtAll(why) => format!("does not enter the limits: {why}"),
        }
    }
}
