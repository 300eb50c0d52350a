//! What makes a choice good: `objective` and `reference` of a joint.

use crate::input::{Key, Problem, Range, Section, key};
use crate::units::{self, Kind};

/// What an objective can be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Mean of all losses that are known \[W\].
    Loss,
    /// Mean copper loss \[W\].
    CopperLoss,
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
        ("copper_loss", Quantity::CopperLoss),
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
            Quantity::Loss | Quantity::CopperLoss | Quantity::PeakPower => &units::POWER,
            Quantity::ReflectedInertia => &units::INERTIA,
            Quantity::PeakCurrent => &units::CURRENT,
            Quantity::Mass => &units::MASS,
            Quantity::Energy => &units::ENERGY,
        }
    }

    /// What it is, in a few words with its unit.
    pub fn about(self) -> &'static str {
        match self {
            Quantity::Loss => "mean of all losses that are known [W]: copper, motor drag, gear, drive",
            Quantity::CopperLoss => "mean copper loss [W]",
            Quantity::ReflectedInertia => "N² (J_m + J_g) [kg*m^2]",
            Quantity::PeakCurrent => "largest q-axis current [A], as limits on currents compare it",
            Quantity::Mass => "of motor and gear [kg]",
            Quantity::Energy => {
                "drawn from the bus per cycle [J]: what is drawn over the drive's efficiency, less what comes back times it"
            }
            Quantity::PeakPower => "largest drawn from the bus [W], over the drive's efficiency",
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

    /// The objective without its mass, for an actuator whose mass is not known: loss, where nothing else is left.
    pub fn without_mass(&self) -> Objective {
        let terms: Vec<_> = self.terms.iter().filter(|(q, _)| *q != Quantity::Mass).copied().collect();
        if terms.is_empty() { Objective::single(Quantity::Loss) } else { Objective { terms } }
    }

    /// The objective apart from its mass, and the mass's weight, where it counts beside another quantity.
    pub fn apart_from_mass(&self) -> Option<(Objective, f64)> {
        let weight = self.weight(Quantity::Mass);
        let others = self.terms.iter().any(|(q, w)| *q != Quantity::Mass && *w > 0.0);
        (weight > 0.0 && others).then(|| (self.without_mass(), weight))
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

/// A design at an end of what loss and mass can be traded for.
#[derive(Debug, Clone, PartialEq)]
pub struct Extreme {
    /// Id of the motor.
    pub motor: String,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<String>,
    /// Ratio, N.
    pub ratio: f64,
    /// The feasible ratios about it.
    pub window: (f64, f64),
    /// Mean loss \[W\].
    pub loss: f64,
    /// Mass of motor and gear \[kg\].
    pub mass: f64,
}

/// What a balanced objective is made from: loss/L₀ + mass/M₀, where L₀ and M₀ are the geometric means of the lightest design's
/// and the least-loss design's values.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// L₀ \[W\].
    pub loss: f64,
    /// M₀ \[kg\].
    pub mass: f64,
    /// The lightest design.
    pub lightest: Extreme,
    /// The design with the least loss.
    pub least_loss: Extreme,
}

impl Balance {
    /// Between two designs.
    pub fn between(lightest: Extreme, least_loss: Extreme) -> Balance {
        let mean = |a: f64, b: f64| (a * b).sqrt();
        let (loss, mass) = (mean(lightest.loss, least_loss.loss), mean(lightest.mass, least_loss.mass));
        Balance { loss, mass, lightest, least_loss }
    }

    /// The objective: an ordinary weighted sum.
    pub fn objective(&self) -> Objective {
        Objective { terms: vec![(Quantity::Loss, 1.0 / self.loss), (Quantity::Mass, 1.0 / self.mass)] }
    }
}

/// Whether the objective of a joint is balanced between loss and mass.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Balancing {
    /// Another objective is stated.
    #[default]
    No,
    /// It is to be: what it is made from is found with the catalogue; until then the objective is the loss.
    Asked,
    /// It is.
    Made(Box<Balance>),
    /// It would be, and cannot: why; the objective is the loss.
    Cannot(&'static str),
}

const OBJECTIVE: Key = key("objective", "what is minimised; a weight, also a single one, is a pure number")
    .value("name of a quantity, or table of weights")
    .default("`balanced`");

/// Reads `objective` of a joint, with its `reference`.
pub(super) fn read(section: &Section) -> Option<(Objective, Balancing)> {
    if !section.has("objective") {
        return Some((Objective::single(Quantity::Loss), Balancing::Asked));
    }
    if !section.is_table("objective") {
        // The words of an objective: `balanced`, or a quantity.
        let quantities = Quantity::NAMES.iter().map(|(name, quantity)| (*name, Some(*quantity)));
        let words: Vec<_> = std::iter::once(("balanced", None)).chain(quantities).collect();
        return section.choice(OBJECTIVE, &words).map(|quantity| match quantity {
            Some(quantity) => (Objective::single(quantity), Balancing::No),
            None => (Objective::single(Quantity::Loss), Balancing::Asked),
        });
    }
    read_weights(section).map(|objective| (objective, Balancing::No))
}

/// Reads a table of weights.
fn read_weights(section: &Section) -> Option<Objective> {
    let table = section.section(OBJECTIVE)?;
    let weight = |(name, quantity): &(&'static str, Quantity)| {
        table
            .number(key(name, quantity.about()).value("weight"), Range::NonNegative)
            .map(|weight| (*name, *quantity, weight))
    };
    let weights: Vec<_> = Quantity::NAMES.iter().filter_map(weight).collect();
    let span = table.span();
    table.finish();
    let reference_span;
    let mut references = Vec::new();
    match section.section(key("reference", "what each weighted quantity is divided by")) {
        Some(reference) => {
            reference_span = reference.span();
            for (name, quantity) in Quantity::NAMES {
                if let Some(value) = reference.quantity(key(name, quantity.about()), quantity.kind(), Range::Positive) {
                    references.push((*name, value));
                }
            }
            reference.finish();
        }
        None => {
            reference_span = span.clone();
        }
    }
    if !weights.iter().any(|(.., weight)| *weight > 0.0) {
        section.note(Problem::at(
            span,
            "the objective has no weight above zero",
            "expected for example { loss = 1, reflected_inertia = 0.5 }",
        ));
        return None;
    }
    let mut terms = Vec::new();
    for (name, quantity, weight) in weights.into_iter().filter(|(.., weight)| *weight != 0.0) {
        match references.iter().find(|(n, _)| *n == name) {
            Some((_, reference)) => terms.push((quantity, weight / reference)),
            None => section.note(
                Problem::at(
                    reference_span.clone(),
                    format!("the weighted objective needs a reference for `{name}`"),
                    "not in `reference`",
                )
                .help(format!("for example reference = {{ {name} = \"1 {}\" }}", quantity.unit())),
            ),
        }
    }
    terms.sort_by_key(|(quantity, _)| *quantity);
    Some(Objective { terms })
}
