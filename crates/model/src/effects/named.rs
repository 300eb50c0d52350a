//! What a number of an effect is called wherever it is fitted, written or read again.

use std::fmt;

use super::{Effect, Shape, effect};

/// A number of an effect: of which, of which order where it has several, and which of its parameters. Written as
/// `effect.parameter`, of an order `effect.order.parameter`.
///
/// ```
/// use gearwise_model::effects::Named;
///
/// let sine = Named::read("cogging.12.sine").unwrap();
/// assert_eq!((sine.effect.name(), sine.order, sine.parameter), ("cogging", Some(12.0), "sine"));
/// assert_eq!(sine.to_string(), "cogging.12.sine");
/// assert!(Named::read("cogging.sine").is_none() && Named::read("torque_constant").is_none());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Named {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// The order, where the effect has orders.
    pub order: Option<f64>,
    /// The name of the parameter.
    pub parameter: &'static str,
}

impl Named {
    /// A parameter of an instance of an effect, by the value of the instance's shape.
    pub fn new(effect: &'static dyn Effect, shape: Option<f64>, parameter: &'static str) -> Named {
        Named { effect, order: shape.filter(|_| effect.shape() == Shape::Order), parameter }
    }

    /// Reads a name; `None` where it is not the name of a number of an effect.
    pub fn read(name: &str) -> Option<Named> {
        let (of, rest) = name.split_once('.')?;
        let effect = effect(of)?;
        let (order, parameter) = match effect.shape() {
            Shape::Order => {
                let (order, parameter) = rest.rsplit_once('.')?;
                (Some(order.parse().ok()?), parameter)
            }
            _ => (None, rest),
        };
        let parameter = effect.parameters().iter().find(|p| p.name == parameter)?.name;
        Some(Named { effect, order, parameter })
    }

    /// Its name among those of its effect: `parameter`, of an order `order.parameter`.
    pub fn within(&self) -> String {
        match self.order {
            Some(order) => format!("{order}.{}", self.parameter),
            None => self.parameter.to_string(),
        }
    }

    /// The place of the parameter among those of its effect.
    pub fn index(&self) -> usize {
        self.effect.parameters().iter().position(|p| p.name == self.parameter).unwrap_or(0)
    }

    /// Whether the values of an instance of the effect hold this number.
    pub fn is_of(&self, effect: &dyn Effect, values: &[f64]) -> bool {
        effect.name() == self.effect.name() && self.order.is_none_or(|order| values.last() == Some(&order))
    }
}

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}.{}", self.effect.name(), self.within())
    }
}
