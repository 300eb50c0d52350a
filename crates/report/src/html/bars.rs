//! Stacked bars of a page: what a sum is made of, a line for each thing.

use std::fmt::Write as _;

use super::render::printed;
use crate::losses::name;
use crate::number;
use crate::plot::Tone;
use gearwise_model::actuator::losses::Losses;

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

/// Length of the longest bar in its own unit, which is stretched over the page.
const LONGEST: f64 = 1000.0;
/// Height of a bar.
const HEIGHT: f64 = 16.0;

impl Bars {
    /// Where the losses of designs are, by their names; nothing where none has any.
    pub(super) fn of_losses(title: String, designs: &[(String, &Losses)]) -> Option<Bars> {
        let (_, first) = designs.first()?;
        let parts = first.parts().map(|(key, _)| name(key)).to_vec();
        let values = |of: &Losses| of.parts().iter().map(|(_, watts)| *watts).collect();
        let rows = designs.iter().map(|(of, losses)| (of.clone(), values(losses))).collect();
        let any = designs.iter().any(|(_, losses)| losses.total() > 0.0);
        any.then_some(Bars { title, unit: "W", parts, rows })
    }

    /// The drawing: of each bar its name and parts in text, which breaks where there is no room, and the bar; nothing where
    /// every sum is zero.
    pub(super) fn html(&self) -> String {
        let sum = |parts: &[f64]| parts.iter().map(|part| part.max(0.0)).sum::<f64>();
        let largest = self.rows.iter().map(|(_, parts)| sum(parts)).fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return String::new();
        }
        let shown: Vec<usize> = (0..self.parts.len()).filter(|k| self.rows.iter().any(|row| row.1[*k] > 0.0)).collect();
        let (title, unit) = (printed(&self.title), printed(self.unit));
        let mut out = format!("<figure class=\"stack\"><figcaption>{title}</figcaption>\n<ul class=\"keys\">");
        for k in &shown {
            let (colour, name) = (Tone::nth(*k).colour(), printed(self.parts[*k]));
            let _ = write!(
                out,
                "<li><svg viewBox=\"0 0 12 12\" aria-hidden=\"true\"><rect width=\"12\" height=\"12\" fill=\"{colour}\"/></svg> {name}</li>"
            );
        }
        out.push_str("</ul>\n");
        for (name, parts) in &self.rows {
            let said: Vec<String> = shown
                .iter()
                .filter(|k| parts[**k] > 0.0)
                .map(|k| format!("{} {}", printed(self.parts[*k]), number(parts[*k])))
                .collect();
            let (name, said) = (printed(name), said.join(" + "));
            let _ = write!(
                out,
                "<p>{name}: {} {unit}<span class=\"note\"> = {said}</span></p>\n<svg viewBox=\"0 0 {LONGEST} {HEIGHT}\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{said} {unit}\">",
                number(sum(parts))
            );
            let mut x = 0.0;
            for k in &shown {
                let wide = LONGEST * parts[*k].max(0.0) / largest;
                let colour = Tone::nth(*k).colour();
                let _ = write!(
                    out,
                    "<rect x=\"{x:.1}\" width=\"{wide:.1}\" height=\"{HEIGHT}\" fill=\"{colour}\"><title>{} {} {unit}</title></rect>",
                    printed(self.parts[*k]),
                    number(parts[*k])
                );
                x += wide;
            }
            out.push_str("</svg>\n");
        }
        out.push_str("</figure>\n");
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_are_drawn_where_there_are_any() {
        let none = Losses::default();
        let some = Losses { copper: 3.0, gear_load: 1.0, ..none };
        assert_eq!(Bars::of_losses(String::new(), &[]), None);
        assert_eq!(Bars::of_losses(String::new(), &[("a".into(), &none)]), None);
        let html = Bars::of_losses("losses".into(), &[("a".into(), &some)]).unwrap().html();
        assert!(html.contains("= copper 3 + gear under load 1") && !html.contains("motor drag"));
    }

    #[test]
    fn bars_are_as_long_as_their_sums() {
        let bars = Bars {
            title: "Where the loss is <b>".into(),
            unit: "W",
            parts: vec!["copper", "drag", "gear"],
            rows: vec![("a".into(), vec![3.0, 0.0, 1.0]), ("b".into(), vec![1.0, 0.0, 1.0])],
        };
        let html = bars.html();
        // The longest fills the width, three of its four parts are copper; a part that nobody has is not named.
        assert!(html.contains("width=\"750.0\"") && html.contains("width=\"250.0\""));
        assert!(!html.contains("drag") && !html.contains("<b>"));
        assert!(
            html.contains("a: 4 W<span")
                && html.contains("= copper 3 + gear 1")
                && html.contains("<title>copper 3 W</title>")
        );
        assert_eq!(Bars { rows: vec![("a".into(), vec![0.0; 3])], ..bars }.html(), "");
    }
}
