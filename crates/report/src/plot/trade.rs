//! What there is to trade at a joint: loss, reflected inertia and mass of every design, each at the ratio that is best for the
//! joint's objective.
//!
//! The one idea: the eye sees two axes and the size of a mark. A design stands out where no other one is better in all three.

use super::{Axis, Figure, Group, Mark, Panel, Scale, Series, Shape, Tone};
use crate::{design_ratio, number};
use gearwise_select::answer::{Design, JointResult};

/// The largest and the smallest mark, over the usual one: a mark's area goes with the mass.
const SIZES: (f64, f64) = (2.4, 0.7);

/// Loss \[W\], inertia \[kg·m²\], and mass \[kg\] where it is known.
type Place = (f64, f64, Option<f64>);

/// Where a design stands; `None` where one of the axes is not known.
fn place(design: &Design) -> Option<Place> {
    let e = &design.evaluation;
    (e.loss.is_finite() && e.reflected_inertia.is_finite()).then_some((e.loss, e.reflected_inertia, e.mass))
}

/// Whether one design is no worse than another in all three, and better in one.
fn is_better(one: [f64; 3], other: [f64; 3]) -> bool {
    let pairs = || one.iter().zip(&other);
    pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
}

/// How a design stands among the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    /// No other has less of one without more of another.
    Front,
    /// Another is no worse in all three, and better in one.
    Behind,
    /// Its mass is not known, and so not whether another is better.
    NoMass,
}

impl Standing {
    const ALL: [(Standing, Tone, Shape, &'static str); 3] = [
        (Standing::Front, Tone::Blue, Shape::Circle, "on the front: less of one costs more of another"),
        (Standing::Behind, Tone::Grey, Shape::Circle, "behind the front: another is no worse in all, better in one"),
        (Standing::NoMass, Tone::Orange, Shape::Square, "mass not known: not compared"),
    ];
}

/// The designs of a joint as a figure without a title.
pub fn figure(result: &JointResult) -> Figure {
    let group = Group { panels: vec![panel(result)], ..Group::default() };
    Figure { groups: vec![group], columns: 1, panel: (560.0, 400.0), ..Figure::default() }
}

/// The designs of a joint.
fn panel(result: &JointResult) -> Panel {
    let all: Vec<(&Design, Place)> =
        result.candidates.iter().filter_map(|design| Some((design, place(design)?))).collect();
    let triples: Vec<[f64; 3]> =
        all.iter().filter_map(|(_, (loss, inertia, mass))| Some([*loss, *inertia, (*mass)?])).collect();
    let standing = |(loss, inertia, mass): Place| match mass {
        None => Standing::NoMass,
        Some(mass) if triples.iter().any(|other| is_better(*other, [loss, inertia, mass])) => Standing::Behind,
        Some(_) => Standing::Front,
    };
    let heaviest = triples.iter().map(|t| t[2]).fold(0.0, f64::max);
    let size = |mass: Option<f64>| match mass {
        Some(mass) if heaviest > 0.0 => (SIZES.0 * (mass / heaviest).sqrt()).max(SIZES.1),
        _ => 1.0,
    };
    let axis = |label: &str, values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        let scale = if low > 0.0 && high > 3.0 * low { Scale::Log } else { Scale::Linear };
        let room = match scale {
            Scale::Log => Some((low / 1.15, high * 1.15)),
            Scale::Linear if high > 0.0 => Some((0.0, 1.1 * high)),
            Scale::Linear => None,
        };
        Axis { scale, range: room, ..Axis::linear(label) }
    };
    let mut panel = Panel {
        title: "loss, reflected inertia and mass of every design, at its best ratio".into(),
        x: axis("loss [W]", &mut all.iter().map(|(_, p)| p.0)),
        y: axis("reflected inertia [kg·m²]", &mut all.iter().map(|(_, p)| p.1)),
        empty: if result.unjudged.is_empty() { "no motor can do it" } else { "no motor that can be judged can do it" }
            .into(),
        ..Panel::default()
    };
    // What stands out is drawn last, over the others.
    for (class, tone, shape, name) in Standing::ALL.into_iter().rev() {
        for estimated in [true, false] {
            let of: Vec<_> = all
                .iter()
                .filter(|(design, at)| standing(*at) == class && design.motor.estimates.is_empty() != estimated)
                .collect();
            if of.is_empty() {
                continue;
            }
            let points = of.iter().map(|(_, at)| (at.0, at.1)).collect();
            let notes = of.iter().map(|(design, at)| {
                let mass = at.2.map_or_else(|| "mass not known".into(), |mass| format!("{} kg", number(mass)));
                let gear = design.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
                format!("{}{gear} at N = {}, {mass}", design.motor.id, design_ratio(design))
            });
            let series = Series::new(tone, Mark::Points(shape), points)
                .of(of.iter().map(|(design, _)| design.motor.id.clone()).collect())
                .noted(notes.collect())
                .sized(of.iter().map(|(_, at)| size(at.2)).collect());
            panel.series.push(series.named(name).hollow(estimated));
        }
    }
    if let Some((first, at)) = all.first() {
        panel.labels.push(super::Label { at: (at.0, at.1), text: first.motor.id.clone(), chosen: true });
    }
    panel.explain_hollow();
    panel
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_design_is_better_only_where_it_is_no_worse_in_all() {
        assert!(is_better([1.0, 1.0, 1.0], [1.0, 2.0, 1.0]));
        assert!(!is_better([1.0, 1.0, 1.0], [1.0, 1.0, 1.0]), "what is alike is not better");
        assert!(!is_better([0.5, 3.0, 1.0], [1.0, 2.0, 1.0]), "less of one and more of another is a trade");
    }
}
