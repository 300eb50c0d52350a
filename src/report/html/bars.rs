//! Stacked bars of a page: what a sum is made of, a line for each thing.

use std::fmt::Write as _;

use super::render::printed;
use crate::report::number;
use crate::report::plot::{Tone, text_width};

/// Sums of parts, each not negative.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bars {
    /// What they show.
    pub title: String,
    /// Unit of the parts.
    pub unit: &'static str,
    /// What the parts are, in the order in which they are stacked.
    pub parts: Vec<&'static str>,
    /// Name and parts of each bar.
    pub rows: Vec<(String, Vec<f64>)>,
}

/// Width of the drawing, and where bars begin and may end in it.
const WIDTH: f64 = 1000.0;
const LEFT: f64 = 10.0;
const LONGEST: f64 = 900.0;
/// Height of a bar with its name, of the bar alone, and of its text.
const STEP: f64 = 44.0;
const HEIGHT: f64 = 18.0;
const FONT: f64 = 13.0;

impl Bars {
    /// The drawing; nothing where every sum is zero.
    pub(super) fn svg(&self) -> String {
        let sum = |parts: &[f64]| parts.iter().map(|part| part.max(0.0)).sum::<f64>();
        let largest = self.rows.iter().map(|(_, parts)| sum(parts)).fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return String::new();
        }
        let shown: Vec<usize> = (0..self.parts.len()).filter(|k| self.rows.iter().any(|row| row.1[*k] > 0.0)).collect();
        let mut out = String::new();
        let mut y = 20.0;
        let mut x = LEFT;
        // What the colours mean, in the order of the bars; on as many lines as it takes.
        for k in &shown {
            let name = self.parts[*k];
            let wide = text_width(name, FONT) + 34.0;
            if x + wide > WIDTH {
                (x, y) = (LEFT, y + 22.0);
            }
            let _ = write!(
                out,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"12\" height=\"12\" fill=\"{}\"/><text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
                y - 10.5,
                Tone::nth(*k).colour(),
                x + 17.0,
                printed(name)
            );
            x += wide;
        }
        for (name, parts) in &self.rows {
            y += STEP;
            let total = sum(parts);
            let _ = write!(
                out,
                "<text x=\"{LEFT}\" y=\"{:.1}\">{}: {} {}</text>",
                y - HEIGHT - 4.0,
                printed(name),
                number(total),
                printed(self.unit)
            );
            let mut x = LEFT;
            for k in &shown {
                let value = parts[*k].max(0.0);
                let wide = LONGEST * value / largest;
                let text = number(value);
                let _ = write!(
                    out,
                    "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{wide:.1}\" height=\"{HEIGHT}\" fill=\"{}\"><title>{} {text} {}</title></rect>",
                    y - HEIGHT,
                    Tone::nth(*k).colour(),
                    printed(self.parts[*k]),
                    printed(self.unit)
                );
                if wide > text_width(&text, FONT) + 8.0 {
                    let ink = if is_light(Tone::nth(*k)) { "#000000" } else { "#ffffff" };
                    let _ = write!(
                        out,
                        "<text class=\"in\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{ink}\">{text}</text>",
                        x + 0.5 * wide,
                        y - 4.5
                    );
                }
                x += wide;
            }
        }
        format!(
            "<figure class=\"stack\"><figcaption>{}</figcaption><svg viewBox=\"0 0 {WIDTH} {:.0}\" role=\"img\" aria-label=\"{}\">{out}</svg></figure>\n",
            printed(&self.title),
            y + 8.0,
            printed(&self.title)
        )
    }
}

/// Whether black text is read on a tone, and white is not.
fn is_light(tone: Tone) -> bool {
    let value = |k: usize| u32::from_str_radix(tone.colour().get(k..k + 2).unwrap_or("00"), 16).unwrap_or(0) as f64;
    0.299 * value(1) + 0.587 * value(3) + 0.114 * value(5) > 140.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_sums() {
        let bars = Bars {
            title: "Where the loss is <b>".into(),
            unit: "W",
            parts: vec!["copper", "drag", "gear"],
            rows: vec![("a".into(), vec![3.0, 0.0, 1.0]), ("b".into(), vec![1.0, 0.0, 1.0])],
        };
        let svg = bars.svg();
        // The longest fills the width, three of its four parts are copper; a part that nobody has is not named.
        assert!(svg.contains("width=\"675.0\"") && svg.contains("width=\"225.0\""));
        assert!(!svg.contains("drag") && !svg.contains("<b>"));
        assert!(svg.contains("a: 4 W") && svg.contains("<title>copper 3 W</title>"));
        assert_eq!(Bars { rows: vec![("a".into(), vec![0.0; 3])], ..bars }.svg(), "");
        assert!(is_light(Tone::Orange) && !is_light(Tone::Blue));
    }
}
