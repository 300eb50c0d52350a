//! How marks are painted, the same in a panel and in its legend.

use super::{Shape, Tone};

pub(super) const GRID: &str = "#e2e2e2";
/// Height of a line of legend or caption \[px\].
pub(super) const LINE: f64 = 18.0;
pub(super) const TEXT: f64 = 12.0;
pub(super) const STRIPE: f64 = 0.13;

impl Tone {
    /// Of lines: strong enough for a thin stroke on white.
    pub(crate) fn dark_line(self) -> &'static str {
        match self {
            Tone::Orange | Tone::Yellow | Tone::Sky | Tone::Purple => self.dark(),
            _ => self.colour(),
        }
    }
}

/// How a bar is painted.
pub(super) fn bar(tone: Tone, hollow: bool) -> String {
    let fill = if hollow { WHITE } else { tone.colour() };
    format!("fill=\"{fill}\" stroke=\"{}\" stroke-width=\"1.2\"", tone.dark_line())
}

pub(super) const WHITE: &str = "#ffffff";

/// What a shape is filled with, and its outline.
pub(super) fn colours(tone: Tone, shape: Shape, hollow: bool) -> (&'static str, &'static str) {
    if hollow { (WHITE, tone.dark_line()) } else { (tone.colour(), outline(tone, shape)) }
}

/// Strokes of crosses are in the tone itself; closed shapes have a dark outline.
pub(super) fn outline(tone: Tone, shape: Shape) -> &'static str {
    match shape {
        Shape::Cross | Shape::Plus => tone.dark_line(),
        _ => tone.dark(),
    }
}
