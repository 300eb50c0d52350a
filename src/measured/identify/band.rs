//! Whether the values of named effects depend on the band.
//!
//! The one idea: a physical value is the same in every band. So each is fitted again in half the band; where the two differ
//! by more than the information that was cut off allows, something else is in it, and the band goes down until two agree.

use super::balance::{Balance, Setting};
use super::numbers::errors;
use super::work::Work;
use crate::effects::{Effect, Named, Shape};
use crate::words::number;

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
    let (names, matrix, values, _) = errors(work);
    let (other_names, other_matrix, other_values, _) = errors(&other);
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
