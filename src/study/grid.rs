//! The grid: every combination of the parameters' values, numbered, the last parameter fastest.
//!
//! The one idea: a point of the grid is its number. Nothing is kept for it, so that a grid may have as
//! many as it likes.

use crate::input::Change;
use crate::input::limits::GRID_POINTS;
use crate::units;

/// One parameter and its values.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Its key, as in the study file.
    pub key: String,
    /// The values, each as the change that it makes.
    pub changes: Vec<Change>,
    /// Name of its column in the results, with the unit where it has one.
    pub column: String,
    /// The values in SI, where all are numbers or quantities of one kind.
    pub numbers: Option<Vec<f64>>,
}

impl Parameter {
    /// Keys that multiply a motion instead of replacing a value.
    pub const SCALES: [&'static str; 2] = crate::requirement::set::SCALES;

    /// A parameter from its changes.
    pub fn new(key: String, changes: Vec<Change>) -> Parameter {
        let texts: Vec<&str> = changes.iter().map(|c| c.text().trim_matches(['"', '\''])).collect();
        let quoted = changes.iter().any(|c| c.text().starts_with(['"', '\'']));
        let plain: Option<Vec<f64>> = texts
            .iter()
            .map(|t| units::number_value(&t.replace('_', "")).ok())
            .collect::<Option<_>>()
            .filter(|_| !quoted);
        let of_kind = |kind: &&units::Kind| texts.iter().all(|t| units::quantity(t, kind).is_ok());
        let base = key.replace(['.', ' ', '-'], "_").replace('*', "all");
        // A watt is a torque per second, too: nobody means that.
        let kinds = std::iter::once(&units::POWER).chain(units::KINDS.iter().copied());
        let (column, numbers) = match (plain, kinds.into_iter().find(of_kind)) {
            (Some(numbers), _) => (base, Some(numbers)),
            (None, Some(kind)) => {
                let numbers = texts.iter().filter_map(|t| units::quantity(t, kind).ok()).collect();
                let unit = kind.si.to_lowercase().replace('/', "_per_").replace(['*', '^'], "");
                (if unit.is_empty() || unit == "1" { base } else { format!("{base}_{unit}") }, Some(numbers))
            }
            (None, None) => (base, None),
        };
        Parameter { key, changes, column: format!("grid_{column}"), numbers }
    }

    /// The text of a value for people: without quotes.
    pub fn text(&self, value: usize) -> &str {
        self.changes[value].text().trim_matches(['"', '\''])
    }

    /// The cell of a value in the results: in SI where it is a number.
    pub fn cell(&self, value: usize) -> String {
        self.numbers.as_ref().map_or_else(|| self.text(value).to_string(), |numbers| numbers[value].to_string())
    }

    /// Whether it multiplies the motion.
    pub fn is_scale(&self) -> bool {
        Parameter::SCALES.contains(&self.key.as_str())
    }
}

/// All parameters.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    /// The parameters, in the order of the study file.
    pub parameters: Vec<Parameter>,
}

impl Grid {
    /// A grid of parameters.
    ///
    /// # Errors
    /// In words, where it has too many points.
    pub fn new(mut parameters: Vec<Parameter>) -> Result<Grid, String> {
        let points = parameters.iter().try_fold(1_u64, |n, p| n.checked_mul(p.changes.len() as u64));
        if points.is_none_or(|n| n > GRID_POINTS) {
            return Err(format!("the grid has more than {GRID_POINTS} points; take fewer values, or split the study"));
        }
        // Two keys may give one column's name: the later is numbered.
        for k in 0..parameters.len() {
            let twins = parameters[..k].iter().filter(|p| p.column == parameters[k].column).count();
            if twins > 0 {
                parameters[k].column = format!("{}_{}", parameters[k].column, twins + 1);
            }
        }
        Ok(Grid { parameters })
    }

    /// Number of points; one where there is no parameter.
    pub fn points(&self) -> u64 {
        self.parameters.iter().map(|p| p.changes.len() as u64).product()
    }

    /// How many points apart two neighbouring values of a parameter are.
    pub fn stride(&self, parameter: usize) -> u64 {
        self.parameters[parameter + 1..].iter().map(|p| p.changes.len() as u64).product()
    }

    /// Which value each parameter has at a point.
    pub fn values(&self, point: u64) -> Vec<usize> {
        let value = |k: usize| (point / self.stride(k) % self.parameters[k].changes.len() as u64) as usize;
        (0..self.parameters.len()).map(value).collect()
    }

    /// The changes that a point makes to the requirement, and the factors of torque and speed.
    pub fn at(&self, point: u64) -> (Vec<Change>, Scale) {
        let (mut changes, mut scale) = (Vec::new(), Scale::default());
        for (parameter, value) in self.parameters.iter().zip(self.values(point)) {
            match (parameter.key.as_str(), &parameter.numbers) {
                ("scale.torque", Some(numbers)) => scale.torque = numbers[value],
                ("scale.speed", Some(numbers)) => scale.speed = numbers[value],
                _ => changes.push(parameter.changes[value].clone()),
            }
        }
        (changes, scale)
    }

    /// A point for people: `bus.voltage = 24 V, scale.torque = 1.2`.
    pub fn name(&self, point: u64) -> String {
        let values = self.values(point);
        let name = |(p, v): (&Parameter, usize)| format!("{} = {}", p.key, p.text(v));
        self.parameters.iter().zip(values).map(name).collect::<Vec<_>>().join(", ")
    }
}

/// Factors on a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// On the load torque.
    pub torque: f64,
    /// On the speed at which it is played.
    pub speed: f64,
}

impl Default for Scale {
    fn default() -> Scale {
        Scale { torque: 1.0, speed: 1.0 }
    }
}
