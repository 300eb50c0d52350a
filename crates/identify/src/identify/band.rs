//! Whether the values of named effects depend on the band.
//!
//! The one idea: a physical value is the same in every band. So each is fitted again in half the band; where the two differ
//! by more than the information that was cut off allows, something else is in it, and the band goes down until two agree.

use super::balance::{Balance, Setting};
use super::numbers::{Numbers, errors};
use super::work::Work;
use gearwise_model::effects::{Effect, Named, Shape};
use gearwise_model::words::number;

/// Half the band must keep a quarter of the information: an error at most twice as large.
const KEEPS: f64 = 2.0;
/// Values differ where they do so by so many standard errors of the difference, and by this share.
const DIFFERS: (f64, f64) = (3.0, 0.05);
/// Least share of the half band's own variance that is taken for that of the difference.
const LEAST: f64 = 0.25;

/// An effect whose value depends on the band.
#[derive(Debug, Clone)]
pub struct Dependent {
    /// Which.
    pub effect: &'static dyn Effect,
    /// Its value in the band and in half of it.
    pub values: (f64, f64),
}

impl Dependent {
    /// That the band is narrowed, and why.
    pub fn narrowed(&self, band: f64) -> String {
        format!("{}: the band is narrowed to {} Hz", self.said(band), number(0.5 * band))
    }

    /// Why it is refused.
    pub fn refused(&self, band: f64) -> String {
        format!("its value depends on the band: {} is no property of the machine", self.said(band))
    }

    fn said(&self, band: f64) -> String {
        let unit = self.effect.parameters()[0].kind.si;
        format!(
            "{} is {} {unit} up to {} Hz and {} up to {} Hz",
            self.effect.title(),
            number(self.values.0),
            number(band),
            number(self.values.1),
            number(0.5 * band)
        )
    }
}

/// Effects of a model whose values differ between the band and half of it.
pub fn dependent(work: &Work, setting: &Setting) -> Vec<Dependent> {
    let (Some(band), target) = (work.balance.band, work.balance.target) else { return Vec::new() };
    let is_asked = |e: &dyn Effect| e.shape() != Shape::Order && !e.drifts_with_band();
    let asked: Vec<&'static dyn Effect> = work
        .terms
        .iter()
        .filter(|t| t.declared.is_none())
        .filter_map(|t| t.effect().map(|(e, _)| e))
        .filter(|e| is_asked(*e))
        .collect();
    if asked.is_empty() {
        return Vec::new();
    }
    let half = Setting { band: Some(0.5 * band), ..setting.clone() };
    let Some(balance) = Balance::new(work.bench, target, &half) else { return Vec::new() };
    let mut other = Work::new(work.bench, balance);
    other.hold_as(work);
    if let Some(ripple) = &work.ripple {
        other.take_out(ripple);
    }
    other.add_again(work.terms.clone());
    let Numbers { names, covariance: matrix, values, .. } = errors(work);
    let Numbers { names: other_names, covariance: other_matrix, values: other_values, .. } = errors(&other);
    let find = |names: &[String], name: &str| names.iter().position(|n| n == name);
    let mut found = Vec::new();
    for effect in asked {
        for parameter in &effect.parameters()[..effect.linear()] {
            let name = Named::new(effect, None, parameter.name).to_string();
            let (Some(a), Some(b)) = (find(&names, &name), find(&other_names, &name)) else { continue };
            let (here, there) = (matrix[(a, a)].max(0.0), other_matrix[(b, b)].max(0.0));
            if there.sqrt() > KEEPS * here.sqrt() {
                continue;
            }
            let error = (there - here).max(LEAST * there).sqrt();
            let off = (values[a] - other_values[b]).abs();
            if off > DIFFERS.0 * error && off > DIFFERS.1 * values[a].abs() {
                found.push(Dependent { effect, values: (values[a], other_values[b]) });
                break;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::steady::{CONSTANT, OVER_TIME, add, bench_of, noise};
    use super::*;
    use crate::answer::Target;

    /// Friction of either sign on a machine that turns back and forth, seen so much later \[s\].
    fn dependent_with(late: f64) -> Vec<&'static str> {
        let row = |k: usize| {
            let t = 2e-3 * k as f64;
            let speed = |t: f64| 40.0 * (25.0 * t).sin() + 15.0 * (14.3 * t).cos();
            let i = 3.0 * (4.0 * t).sin() + 2.0 * (2.3 * t).cos();
            let friction = 0.1 * f64::tanh(speed(t - late) / 0.5);
            vec![t, speed(t), i, 6.0 * (CONSTANT * i - friction) + 0.01 * noise(k)]
        };
        let bench = bench_of("dynamometer", 6.0, &OVER_TIME, &[(0..6000).map(row).collect()], 0);
        let setting = Setting::uncorrected(&bench, Some(20.0));
        let mut work = Work::new(&bench, Balance::new(&bench, Target::Torque, &setting).expect("rows"));
        add(&mut work, "coulomb_friction", 0.0);
        dependent(&work, &setting).iter().map(|d| d.effect.name()).collect()
    }

    #[test]
    fn a_value_that_depends_on_the_band_is_none_of_the_machine() {
        assert!(dependent_with(0.0).is_empty());
        assert_eq!(dependent_with(0.02), ["coulomb_friction"]);
    }

    #[test]
    fn what_depends_is_told_with_both_values() {
        let depends =
            Dependent { effect: gearwise_model::effects::effect("coulomb_friction").unwrap(), values: (0.5, 0.25) };
        assert_eq!(
            depends.narrowed(20.0),
            "Coulomb friction is 0.5 N*m up to 20 Hz and 0.25 up to 10 Hz: the band is narrowed to 10 Hz"
        );
        assert!(depends.refused(20.0).ends_with("is no property of the machine"));
    }
}
