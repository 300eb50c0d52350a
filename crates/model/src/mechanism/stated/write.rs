//! Other numbers in the place of those that a model states; everything else of its text stays as it is.

use super::{Model, Quantity};
use crate::words::with_unit;

/// A number that shall be in a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// The joint, by its index.
    pub joint: usize,
    /// What of it.
    pub quantity: Quantity,
    /// At the joint, SI.
    pub value: f64,
}

/// A model's new text.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// The text.
    pub text: String,
    /// What was changed, a line for each.
    pub changed: Vec<String>,
    /// What has no place in the model, a line for each.
    pub left: Vec<String>,
}

impl Model {
    /// The text of the model with these numbers; of one place the first counts.
    pub fn written(&self, changes: &[Change]) -> Written {
        let mut edits: Vec<(std::ops::Range<usize>, String)> = Vec::new();
        let (mut changed, mut left) = (Vec::new(), Vec::new());
        let mut done: Vec<(usize, Quantity)> = Vec::new();
        for change in changes {
            if done.contains(&(change.joint, change.quantity)) {
                continue;
            }
            done.push((change.joint, change.quantity));
            let joint = &self.joints[change.joint];
            let name = change.quantity.name();
            let value = with_unit(change.value, change.quantity.unit());
            let Some(slot) = joint.slot(change.quantity) else {
                left.push(format!("{}: {name} {value} has no place in this model", joint.name));
                continue;
            };
            let of = joint.get(change.quantity).filter(|stated| stated.called != name);
            let of = of.map_or(String::new(), |stated| format!(" (as {})", stated.called));
            let before = joint.get(change.quantity).map_or("nothing".into(), |s| with_unit(s.value, s.quantity.unit()));
            changed.push(format!("{}: {name} {value} in place of {before}{of}", joint.name));
            edits.push((slot.at.clone(), slot.text(change.value)));
        }
        edits.sort_by_key(|(range, _)| (range.start, range.end));
        let text = self.source.text();
        let mut out = String::with_capacity(text.len() + 256);
        let mut from = 0;
        for (range, new) in edits {
            // Two joints may share one place; what was written there first stays.
            if range.start < from {
                continue;
            }
            out.push_str(&text[from..range.start]);
            out.push_str(&new);
            from = range.end;
        }
        out.push_str(&text[from..]);
        Written { text: out, changed, left }
    }
}
