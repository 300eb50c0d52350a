//! What is said of a first choice beside the choice: flatness, own bound, gears near by, the front.

use schemars::JsonSchema;
use serde::Serialize;

use super::turns::OtherTurns;
use crate::design::answer::JointResult;
use crate::design::evaluate::Evaluation;
use crate::design::flatness;
use crate::design::nearby;
use crate::design::outlook;
use crate::design::program::Certificate;

/// What is said of the first candidate beside the choice.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct Outlook<'a> {
    /// Ratios that are nearly as good; left out where only certain ratios may be chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flatness: Option<Flatness>,
    /// The requirement's own range of ratios decided; left out where it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_bound: Option<OwnBound>,
    /// Gears of the catalogue near the best ratio that keep every limit; left out where the catalogue fixes the gear.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_gears: Option<NearGears<'a>>,
    /// A simple planetary gear near the best ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_planetary: Option<Planetary>,
    /// What another number of turns would do, where voltage or the drive's current holds the ratio back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turns: Option<OtherTurns<'a>>,
    /// Designs from the lightest to the least loss (with `--why` or `--full`, where the objective is balanced).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub front: Vec<FrontDesign<'a>>,
}

/// Ratios about the best one that keep every limit and are nearly as good.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Flatness {
    /// Smallest of them.
    pub from: f64,
    /// Largest of them.
    pub to: f64,
    /// The objective is at most so much above its least (relative).
    pub within: f64,
    /// Whether it is proved of all between; else ratios on the way were evaluated.
    pub proved: bool,
}

/// The end of the requirement's range at which the best ratio stands, with better ones behind it.
#[derive(Debug, Serialize, JsonSchema)]
pub struct OwnBound {
    /// The end.
    pub ratio: f64,
    /// `max` or `min`.
    pub end: &'static str,
    /// A ratio beyond that keeps every limit.
    pub beyond: f64,
    /// How much less the objective is there (relative).
    pub saves: f64,
}

/// Gears of the catalogue near by.
#[derive(Debug, Serialize, JsonSchema)]
pub struct NearGears<'a> {
    /// How many were looked at: those near by that fit and state what torque they carry.
    pub looked_at: usize,
    /// The nearest that keep every limit.
    pub gears: Vec<NearGear<'a>>,
    /// Where none does: the nearest one.
    pub nearest: Option<&'a str>,
    /// The limit that it exceeds most.
    pub exceeds: Option<&'static str>,
}

/// What a ratio near the best one costs.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Nearly {
    /// Ratio N.
    pub ratio: f64,
    /// Mean loss with it.
    pub loss_w: f64,
    /// Mass of motor and gear; `null` where it is not known.
    pub mass_kg: Option<f64>,
    /// The objective with it.
    pub objective: f64,
    /// By how much that is above that of the best ratio (relative).
    pub above: Option<f64>,
}

/// A gear of the catalogue.
#[derive(Debug, Serialize, JsonSchema)]
pub struct NearGear<'a> {
    /// Its id.
    pub gear: &'a str,
    /// What it costs.
    #[serde(flatten)]
    pub at: Nearly,
}

/// A gear of simple planetary stages.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Planetary {
    /// Teeth of sun and ring of each stage, the motor's first.
    pub teeth: Vec<[u32; 2]>,
    /// What it costs.
    #[serde(flatten)]
    pub at: Nearly,
}

/// A design between the lightest and the least loss.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FrontDesign<'a> {
    /// Share of the loss in the weighted sum of loss/L₀ and mass/M₀: 0 is the lightest, 1 the least loss.
    pub share: f64,
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
    /// Relative gap of its weighted sum to the bound of its motor; `null` where it is not certified.
    pub gap: Option<f64>,
}

impl<'a> Outlook<'a> {
    /// Of a joint.
    pub fn new(result: &'a JointResult<'a>, outlook: Option<&'a outlook::Outlook<'a>>) -> Outlook<'a> {
        let (Some(design), Some(of)) = (result.candidates.first(), outlook) else { return Outlook::default() };
        let planetary = of.nearby.as_ref().and_then(|nearby| {
            let built = nearby.planetary.as_ref()?;
            let there = &built.design;
            Some(Planetary {
                teeth: built.train.as_ref()?.stages.iter().map(|stage| [stage.sun, stage.ring]).collect(),
                at: Nearly::new(&there.evaluation, there.optimum.objective, nearby.planetary_above(design)),
            })
        });
        Outlook {
            flatness: of.flatness.as_ref().map(Flatness::from),
            own_bound: of.own_bound.as_ref().map(OwnBound::from),
            near_gears: of.nearby.as_ref().map(NearGears::from),
            near_planetary: planetary,
            turns: of.rewound.as_ref().map(|how| OtherTurns::new(how, design.motor, None, result.joint)),
            front: of.front.iter().map(FrontDesign::from).collect(),
        }
    }
}

impl Nearly {
    fn new(there: &Evaluation, objective: f64, above: Option<f64>) -> Nearly {
        Nearly { ratio: there.ratio, loss_w: there.loss, mass_kg: there.mass, objective, above }
    }
}

impl From<&flatness::Flatness> for Flatness {
    fn from(of: &flatness::Flatness) -> Flatness {
        Flatness { from: of.from, to: of.to, within: of.within, proved: of.proved }
    }
}

impl From<&flatness::OwnBound> for OwnBound {
    fn from(of: &flatness::OwnBound) -> OwnBound {
        let end = if of.is_largest { "max" } else { "min" };
        OwnBound { ratio: of.ratio, end, beyond: of.beyond, saves: of.saves }
    }
}

impl<'a> From<&'a nearby::Nearby<'a>> for NearGears<'a> {
    fn from(of: &'a nearby::Nearby<'a>) -> NearGears<'a> {
        let gear = |near: &'a nearby::NearGear<'a>| NearGear {
            gear: &near.gear.id,
            at: Nearly::new(&near.evaluation, near.objective, near.above),
        };
        NearGears {
            looked_at: of.looked_at,
            gears: of.gears.iter().map(gear).collect(),
            nearest: of.exceeded.as_ref().map(|(gear, _)| gear.id.as_str()),
            exceeds: of.exceeded.as_ref().map(|(_, margin)| margin.limit),
        }
    }
}

impl<'a> From<&'a outlook::FrontDesign<'a>> for FrontDesign<'a> {
    fn from(of: &'a outlook::FrontDesign<'a>) -> FrontDesign<'a> {
        let design = &of.design;
        let gap = match design.optimum.certificate {
            Certificate::Certified { gap, .. } => Some(gap),
            Certificate::NotCertified(_) => None,
        };
        FrontDesign {
            share: of.share,
            motor: &design.motor.id,
            gear: design.gear,
            ratio: design.evaluation.ratio,
            loss_w: design.evaluation.loss,
            mass_kg: design.evaluation.mass,
            gap,
        }
    }
}
