//! What a ratio program finds, as facts.

use std::borrow::Cow;
use std::fmt;

use super::bind::Bind;
use super::refusal::Refusal;

/// What came of a ratio program: the best ratio, or why there is none.
pub type Outcome = Result<Optimum, Refusal>;

/// The best ratio and its proof.
#[derive(Debug, Clone)]
pub struct Optimum {
    /// N*.
    pub ratio: f64,
    /// The objective there.
    pub objective: f64,
    /// Feasible ratios: one interval where the program is convex.
    pub windows: Vec<Window>,
    /// The proof, or why there is none.
    pub certificate: Certificate,
    /// `∂objective/∂limit` of the limits that bind at N*, in SI.
    pub shadow_prices: Vec<ShadowPrice>,
}

impl Optimum {
    /// The same optimum of the objective times a weight above zero.
    pub(super) fn times(mut self, weight: f64) -> Optimum {
        self.objective *= weight;
        if let Certificate::Certified { lower_bound, .. } = &mut self.certificate {
            *lower_bound *= weight;
        }
        for price in &mut self.shadow_prices {
            price.price *= weight;
        }
        self
    }

    /// The same optimum of the objective and a constant.
    pub(super) fn plus(mut self, constant: f64) -> Optimum {
        let before = self.objective;
        self.objective += constant;
        if let Certificate::Certified { lower_bound, gap, .. } = &mut self.certificate {
            *lower_bound += constant;
            *gap *= if self.objective == 0.0 { 1.0 } else { (before / self.objective).abs() };
        }
        for price in &mut self.shadow_prices {
            price.elasticity *= if self.objective == 0.0 { 1.0 } else { before / self.objective };
        }
        self
    }

    /// The window that N* lies in.
    pub fn window(&self) -> &Window {
        let inside = |w: &&Window| w.min <= self.ratio * (1.0 + 1e-9) && self.ratio <= w.max * (1.0 + 1e-9);
        self.windows.iter().find(inside).unwrap_or(&self.windows[0])
    }
}

/// An interval of feasible ratios and what ends it.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Smallest ratio.
    pub min: f64,
    /// Largest ratio.
    pub max: f64,
    /// What forbids a smaller one.
    pub low: Bind,
    /// What forbids a larger one.
    pub high: Bind,
}

/// How sure the optimum is.
#[derive(Debug, Clone, PartialEq)]
pub enum Certificate {
    /// No ratio is better than `lower_bound`; `gap` is relative.
    Certified {
        /// Lower bound of the objective.
        lower_bound: f64,
        /// `(objective − lower_bound)/|objective|`.
        gap: f64,
        /// How the bound was found.
        method: &'static str,
    },
    /// The best that was found; why there is no proof.
    NotCertified(NotProved),
}

/// Why an optimum is not proved.
#[derive(Debug, Clone, PartialEq)]
pub enum NotProved {
    /// The search ended after its share of the work.
    Ended {
        /// No ratio is better by more than this (relative); `None` where that is not known.
        gap: Option<f64>,
        /// The objective is nowhere below this; `None` where that is not known.
        lower_bound: Option<f64>,
    },
    /// The bounds did not meet, or there are none.
    Because(Cow<'static, str>),
}

impl From<&'static str> for NotProved {
    fn from(why: &'static str) -> NotProved {
        NotProved::Because(why.into())
    }
}

impl From<String> for NotProved {
    fn from(why: String) -> NotProved {
        NotProved::Because(why.into())
    }
}

impl fmt::Display for NotProved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ended = "the search ended after its share of the work";
        match self {
            NotProved::Ended { gap: Some(gap), .. } => {
                write!(f, "{ended}; no ratio is better by more than {} %", gearwise_model::words::number(100.0 * gap))
            }
            NotProved::Ended { gap: None, .. } => {
                write!(f, "{ended}; how much better another ratio may be is not known")
            }
            NotProved::Because(why) => f.write_str(why),
        }
    }
}

impl Certificate {
    /// The certificate of a program that did its share of the work before its bounds met, at a relative gap and a bound of the objective.
    pub(super) fn ended(gap: f64, lower_bound: f64) -> Certificate {
        let [gap, lower_bound] = [gap, lower_bound].map(|number| number.is_finite().then_some(number));
        Certificate::NotCertified(NotProved::Ended { gap, lower_bound })
    }

    /// Relative gap between the objective and the least that it may be, where that is known.
    pub fn gap(&self) -> Option<f64> {
        match self {
            Certificate::Certified { gap, .. } => Some(*gap),
            Certificate::NotCertified(NotProved::Ended { gap, .. }) => *gap,
            Certificate::NotCertified(NotProved::Because(_)) => None,
        }
    }

    /// True if the search ended after its share of the work.
    pub(crate) fn is_ended(&self) -> bool {
        matches!(self, Certificate::NotCertified(NotProved::Ended { .. }))
    }

    /// The certificate of the least mass, from that of the smallest ratio or of any at all.
    pub(super) fn of_mass(self, mass: f64) -> Certificate {
        match self {
            Certificate::Certified { .. } => {
                Certificate::Certified { lower_bound: mass, gap: 0.0, method: "mass does not fall with the ratio" }
            }
            // The bound is that of a ratio.
            Certificate::NotCertified(NotProved::Ended { gap, .. }) => {
                Certificate::NotCertified(NotProved::Ended { gap, lower_bound: None })
            }
            not => not,
        }
    }
}

/// What one more unit of a limit is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowPrice {
    /// Name of the limit.
    pub limit: &'static str,
    /// Change of the objective per unit of the limit, SI.
    pub price: f64,
    /// Per cent of the objective per per cent of the limit.
    pub elasticity: f64,
}
