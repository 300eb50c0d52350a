//! What may be added to the model of a servo.

use crate::answer::Step;
use crate::simulate::model::{LONGEST_LAG, Model, Slot};
use gearwise_model::effects::{Doubt, Effect, Search, Shape};

/// Least lag that is one \[s\].
const LEAST_LAG: f64 = 2e-4;
/// Where the search for one starts \[s\].
pub(super) const FIRST_LAG: f64 = 0.003;
/// Share of the longest lag that is looked for beyond which it is none: it lies at the end of its range.
const MOST_OF_LAG: f64 = 0.95;

/// Something that may be added to the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Candidate {
    Effect(&'static dyn Effect),
    Lag,
}

impl Candidate {
    /// Its name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Candidate::Effect(effect) => effect.name(),
            Candidate::Lag => "lag",
        }
    }

    /// Its step in the story.
    pub fn step(self) -> Step {
        match self {
            Candidate::Effect(effect) => Step::Added(effect, 0.0),
            Candidate::Lag => Step::Lag,
        }
    }

    /// Whether a model has it.
    pub fn is_in(self, model: &Model) -> bool {
        match self {
            Candidate::Effect(effect) => model.machine.terms.iter().any(|t| t.effect == effect),
            Candidate::Lag => model.slots.contains(&Slot::Lag),
        }
    }

    /// The model with it, at each place to start from.
    pub fn added(self, model: &Model) -> Vec<Model> {
        let mut with = model.clone();
        match self {
            Candidate::Lag => {
                with.machine.lag = FIRST_LAG;
                with.slots.push(Slot::Lag);
                vec![with]
            }
            Candidate::Effect(effect) => {
                let mut starts = Vec::new();
                for shape in shapes(effect, model) {
                    for share in [0.2, 1.0] {
                        let mut start = model.clone();
                        let mut values = vec![0.0; effect.linear()];
                        if shape.is_finite() {
                            values.push(shape);
                        }
                        start.add(effect, values);
                        let term = start.machine.terms.len() - 1;
                        let first = start.slots.iter().position(|s| *s == Slot::Value(term, 0)).unwrap_or(0);
                        let unknown = &start.unknowns(&[])[first];
                        // A tenth of the largest torque and a fiftieth, where its sign is known.
                        let value = if unknown.lower == 0.0 { share * unknown.scale } else { 0.0 };
                        start.machine.terms[term].values[0] = value;
                        starts.push(start);
                    }
                }
                starts
            }
        }
    }

    /// The model with an effect of a shape, at each shape to start from, as nothing yet.
    pub fn starting_at_nothing(self, model: &Model) -> Vec<Model> {
        let Candidate::Effect(effect) = self else { return Vec::new() };
        let with = |shape: f64| {
            let mut start = model.clone();
            start.add(effect, vec![0.0; effect.linear()].into_iter().chain([shape]).collect());
            start
        };
        shapes(effect, model).into_iter().filter(|s| s.is_finite()).map(with).collect()
    }

    /// Whether an unknown of a model says how much of it there is.
    pub fn is_amount(self, model: &Model, slot: Slot) -> bool {
        match (self, slot) {
            (Candidate::Lag, Slot::Lag) => true,
            (Candidate::Effect(effect), Slot::Value(term, index)) => {
                model.machine.terms[term].effect == effect && index < effect.linear()
            }
            _ => false,
        }
    }

    /// Whether an unknown of a model is its shape.
    pub fn is_shape(self, model: &Model, slot: Slot) -> bool {
        match (self, slot) {
            (Candidate::Effect(effect), Slot::Value(term, index)) => {
                model.machine.terms[term].effect == effect && index >= effect.linear()
            }
            _ => false,
        }
    }

    /// The model without it.
    pub fn removed(self, model: &Model) -> Model {
        let mut without = model.clone();
        match self {
            Candidate::Lag => {
                without.machine.lag = 0.0;
                without.slots.retain(|s| *s != Slot::Lag);
            }
            Candidate::Effect(effect) => {
                if let Some(t) = without.machine.terms.iter().position(|t| t.effect == effect) {
                    without.remove(t);
                }
            }
        }
        without
    }

    /// Whether its values in a model are plausible.
    pub fn plausible(self, model: &Model) -> Result<(), Doubt> {
        match self {
            Candidate::Lag if model.machine.lag <= LEAST_LAG => Err(Doubt::Unnatural("it would be zero".into())),
            Candidate::Lag if !is_a_lag(model.machine.lag) => {
                Err(Doubt::Unnatural("it would be at the end of its range".into()))
            }
            Candidate::Lag => Ok(()),
            Candidate::Effect(effect) => {
                let values = model.machine.terms.iter().find(|t| t.effect == effect);
                effect.plausible(values.map_or(&[], |t| &t.values), &model.scale)
            }
        }
    }
}

/// Shapes that the search for an effect starts from; no number where it has none.
fn shapes(effect: &dyn Effect, model: &Model) -> Vec<f64> {
    let of = |search: Search, largest: f64| search.starts.iter().map(|s| s * largest).collect();
    match effect.shape() {
        Shape::Speed(search) => of(search, model.scale.speed),
        Shape::Current(search) => of(search, model.scale.current),
        Shape::None | Shape::Order => vec![f64::NAN],
    }
}

/// Whether a lag \[s\] is one: above zero, and not at the end of its range.
pub(super) fn is_a_lag(lag: f64) -> bool {
    (LEAST_LAG..MOST_OF_LAG * LONGEST_LAG).contains(&lag)
}
