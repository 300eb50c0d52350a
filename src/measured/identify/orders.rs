//! Orders of ripple that were found at full bandwidth, with their values.

use super::balance::Balance;
use crate::effects::{Effect, FittedEffect};

/// Share of its power that an order keeps in the band to be fitted there.
const IN_BAND: f64 = 0.25;

/// An order of an effect, with its values.
#[derive(Debug, Clone)]
pub struct Line {
    /// The effect with cosine, sine and order.
    pub fitted: FittedEffect,
    /// Covariance of cosine and sine.
    pub covariance: [[f64; 2]; 2],
    /// Another effect that has the same columns: an order of the motor that is one of the output, too.
    pub twin: Option<&'static dyn Effect>,
}

/// What repeats with an angle.
#[derive(Debug, Clone)]
pub struct Ripple {
    /// The orders, the strongest first.
    pub lines: Vec<Line>,
    /// How much later than so far thought the angle is \[s\]: where the strongest order stands out most.
    pub lag: f64,
    /// The full band \[Hz\].
    pub band: f64,
    /// Error at full bandwidth on the logs for fitting and on what was held out, with all orders.
    pub after: (Option<f64>, Option<f64>),
    /// The same without the orders of one effect.
    pub without: Vec<(&'static dyn Effect, Option<f64>, Option<f64>)>,
}

impl Ripple {
    /// Orders whose columns keep enough in the band of a balance are terms like any other; the rest stays as found here.
    pub fn split(mut self, balance: &Balance) -> (Vec<FittedEffect>, Option<Ripple>) {
        let share = |fitted: &FittedEffect| {
            let square = |filtered: bool| -> f64 {
                let column = balance.variable(filtered, |at| fitted.effect.value(&fitted.values, at));
                column.iter().map(|v| v * v).sum()
            };
            square(true) / square(false).max(f64::MIN_POSITIVE)
        };
        let (inside, above): (Vec<Line>, Vec<Line>) =
            std::mem::take(&mut self.lines).into_iter().partition(|l| share(&l.fitted) > IN_BAND);
        self.without.retain(|(e, ..)| above.iter().any(|l| l.fitted.effect == *e));
        self.lines = above;
        let inside = inside.into_iter().map(|l| l.fitted).collect();
        (inside, (!self.lines.is_empty()).then_some(self))
    }

    /// The orders as effects.
    pub fn effects(&self) -> Vec<FittedEffect> {
        self.lines.iter().map(|l| l.fitted.clone()).collect()
    }
}
