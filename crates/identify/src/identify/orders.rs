//! Orders of ripple that were found at full bandwidth, with their values.

use super::balance::Balance;
use gearwise_model::effects::{Effect, FittedEffect};
use gearwise_model::words::number;

/// Share of its power that an order keeps in the band to be fitted there.
const IN_BAND: f64 = 0.25;

/// An order of an effect, with its values.
#[derive(Debug, Clone)]
pub struct Line {
    /// The effect with cosine, sine and order.
    pub fitted: FittedEffect,
    /// Covariance of cosine and sine.
    pub covariance: [[f64; 2]; 2],
    /// Other effects that have the same columns: an order of the motor that is one of the output too, or at one current.
    pub twins: Vec<&'static dyn Effect>,
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
    /// What lies above the band, and what it takes away at full bandwidth; one line for each effect.
    pub fn said(&self, band: Option<f64>, unit: &str) -> Vec<String> {
        let one = |(effect, without, _): &(&'static dyn Effect, Option<f64>, Option<f64>)| {
            let own = self.lines.iter().filter(|l| l.fitted.effect == *effect);
            let orders: Vec<String> = own.filter_map(|l| l.fitted.values.last()).map(|h| number(*h)).collect();
            let plural = if orders.len() == 1 { "" } else { "s" };
            Some(format!(
                "{} of order{plural} {} lies above the band of {} Hz: its values are those up to {} Hz, where the error is {} {unit} \
                 without and {} with all that repeats with an angle",
                effect.title(),
                orders.join(", "),
                number(band?),
                number(self.band),
                number((*without)?),
                number(self.after.0?)
            ))
        };
        self.without.iter().filter_map(one).collect()
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use gearwise_model::effects::effect;

    #[test]
    fn what_lies_above_the_band_is_told_with_its_error_at_full_bandwidth() {
        let cogging = effect("cogging").unwrap();
        let line = |order: f64| Line {
            fitted: FittedEffect { effect: cogging, values: vec![0.1, 0.0, order] },
            covariance: [[0.0; 2]; 2],
            twins: Vec::new(),
        };
        let ripple = |orders: &[f64]| Ripple {
            lines: orders.iter().map(|h| line(*h)).collect(),
            lag: 0.0,
            band: 200.0,
            after: (Some(0.02), None),
            without: vec![(cogging, Some(0.5), None)],
        };
        let told = "cogging of orders 42, 84 lies above the band of 10 Hz: its values are those up to 200 Hz, where the error is 0.5 \
                    N*m without and 0.02 with all that repeats with an angle";
        assert_eq!(ripple(&[42.0, 84.0]).said(Some(10.0), "N*m"), [told]);
        assert!(ripple(&[42.0]).said(Some(10.0), "N*m")[0].starts_with("cogging of order 42 lies above"));
        // Without a band nothing lies above it.
        assert!(ripple(&[42.0]).said(None, "N*m").is_empty());
    }
}
