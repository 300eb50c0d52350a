//! What is said of a first choice beside the choice: flatness, own bound, gears near by, the front.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;

use super::design::{Limit, NotChecked, limits, not_checked};
use super::finite;
use super::turns::OtherTurns;
use gearwise_model::catalog::Gear;
use gearwise_model::requirement::Joint;
use gearwise_select::answer::JointResult;
use gearwise_select::evaluate::Evaluation;
use gearwise_select::flatness;
use gearwise_select::nearby;
use gearwise_select::outlook;

/// What is said of the first candidate beside the choice.
#[derive(Debug, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Outlook<'a> {
    /// Ratios that are nearly as good; left out where only certain ratios may be chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flatness: Option<Flatness>,
    /// The requirement's own range of ratios decided; left out where it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_bound: Option<OwnBound>,
    /// Gears of the catalogue near the best ratio; left out where the catalogue fixes the gear.
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
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NearGears<'a> {
    /// How many were looked at: those of a ratio that is feasible or within 30 % of the best one, that fit the motor or do not
    /// say what they fit, and whose ratio the requirement allows.
    pub looked_at: usize,
    /// The first of them: by how they stand, then by the objective, those that exceed a limit by how far.
    pub gears: Vec<NearGear<'a>>,
    /// Where none was looked at: between which gears there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap<'a>>,
}

/// Between which gears of the catalogue there is none that fits the motor and the requirement's ratios.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Gap<'a> {
    /// The next one of a smaller ratio; `null` where there is none.
    pub below: Option<GearAt<'a>>,
    /// The next one of a larger ratio; `null` where there is none.
    pub above: Option<GearAt<'a>>,
}

/// A gear of the catalogue with its ratio.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct GearAt<'a> {
    /// Its id.
    pub gear: &'a str,
    /// Its ratio.
    pub ratio: f64,
}

/// What a ratio near the best one costs.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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

/// A gear of the catalogue, evaluated with its own efficiency, inertia, mass and ratings.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NearGear<'a> {
    /// Its id.
    pub gear: &'a str,
    /// Its ratio.
    pub ratio: f64,
    /// `keeps`: every limit that is judged of the best design; `less_known`: what can be judged, which is less than of the best
    /// design; `unjudged`: the same, and the requirement states what cannot be; `exceeds`: not every limit; `unusable`: it
    /// cannot be evaluated.
    pub standing: &'static str,
    /// Whether every limit could be judged and is kept.
    pub keeps_all: bool,
    /// The limits that it exceeds, the worst first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exceeds: Vec<Limit<'a>>,
    /// Limits that could not be checked with it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_checked: Vec<NotChecked<'a>>,
    /// Why it cannot be evaluated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub because: Option<&'static str>,
    /// Mean loss with it; `null` where it is not known.
    pub loss_w: Option<f64>,
    /// Mass of motor and gear; `null` where it is not known.
    pub mass_kg: Option<f64>,
    /// That less the mass of the best design; `null` where one of them is not known.
    pub more_mass_kg: Option<f64>,
    /// The objective with it; `null` where it is not known.
    pub objective: Option<f64>,
    /// That less the objective of the best design, in its unit.
    pub more: Option<f64>,
    /// The same relative to the best; `null` where that is not above zero.
    pub above: Option<f64>,
    /// Where it comes from, in the unit of the objective; `null` where nothing is to be taken apart, or the described gear is not
    /// known at this ratio.
    pub parts: Option<Parts>,
}

/// What of the objective is more, by what is changed one after the other. The parts add up to `more`, unless the gear's inertia is
/// not known.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Parts {
    /// The described gear at the other ratio.
    pub ratio: f64,
    /// With the efficiencies and the torque without load of the other gear.
    pub efficiency: f64,
    /// With its inertia; `null` where that is not known: it is left out.
    pub inertia: Option<f64>,
    /// With its mass; left out where the objective does not count it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
}

/// A gear of simple planetary stages.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Planetary {
    /// Teeth of sun and ring of each stage, the motor's first.
    pub teeth: Vec<[u32; 2]>,
    /// What it costs.
    #[serde(flatten)]
    pub at: Nearly,
}

/// A design between the lightest and the least loss.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
            near_gears: of.nearby.as_ref().map(|nearby| NearGears::new(nearby, result.joint)),
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

impl<'a> NearGears<'a> {
    fn new(of: &'a nearby::Nearby<'a>, joint: &'a Joint) -> NearGears<'a> {
        let at = |gear: &'a Gear| GearAt { gear: &gear.id, ratio: gear.ratio };
        NearGears {
            looked_at: of.looked_at,
            gears: of.gears.iter().map(|near| NearGear::new(near, joint)).collect(),
            gap: of.gap.as_ref().map(|gap| Gap { below: gap.below.map(at), above: gap.above.map(at) }),
        }
    }
}

impl<'a> NearGear<'a> {
    fn new(near: &'a nearby::NearGear<'a>, joint: &'a Joint) -> NearGear<'a> {
        let exceeded: Vec<_> = near.exceeded().into_iter().copied().collect();
        let there = near.evaluation.as_ref();
        NearGear {
            gear: &near.gear.id,
            ratio: near.gear.ratio,
            standing: near.standing.word(),
            keeps_all: near.keeps_all(),
            exceeds: limits(&exceeded, joint),
            not_checked: not_checked(&near.unchecked),
            because: match &near.standing {
                nearby::Standing::Unusable(why) => Some(why.reason()),
                _ => None,
            },
            loss_w: there.and_then(|e| finite(e.loss)),
            mass_kg: there.and_then(|e| e.mass),
            more_mass_kg: near.mass,
            objective: near.objective.and_then(finite),
            more: near.more.and_then(finite),
            above: near.above.and_then(finite),
            parts: near.parts.map(|parts| Parts {
                ratio: parts.ratio,
                efficiency: parts.efficiency,
                inertia: parts.inertia,
                mass: parts.mass,
            }),
        }
    }
}

impl<'a> From<&'a outlook::FrontDesign<'a>> for FrontDesign<'a> {
    fn from(of: &'a outlook::FrontDesign<'a>) -> FrontDesign<'a> {
        let design = &of.design;
        let gap = design.optimum.certificate.gap();
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
