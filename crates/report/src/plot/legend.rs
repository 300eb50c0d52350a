//! The legend: each name once, with all that has it.

use super::paint::{GRID, LINE, STRIPE, TEXT, bar, colours};
use super::pen::{Anchor, Pen, TextStyle, text_width};
use super::{Mark, Panel, Tone};

/// Width of a legend's sample \[px\].
const SAMPLE: f64 = 30.0;

/// A line of the legend: a name, and all that has it.
pub(super) struct Entry<'a> {
    name: &'a str,
    samples: Vec<Sample>,
}

/// A tone and a mark (none for a stripe), and whether that is hollow.
type Sample = (Tone, Option<Mark>, bool);

pub(super) fn legend<'a>(panels: impl Iterator<Item = &'a Panel>) -> Vec<Entry<'a>> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut add = |name: &'a str, sample: Sample| {
        if name.is_empty() {
            return;
        }
        match entries.iter_mut().find(|e| e.name == name) {
            Some(entry) if entry.samples.contains(&sample) => {}
            // Of one look full and hollow: the full one is the sample, and the legend says what hollow is.
            Some(entry) => match entry.samples.iter_mut().find(|s| (s.0, s.1) == (sample.0, sample.1)) {
                Some(same) => same.2 = false,
                None => entry.samples.push(sample),
            },
            None => entries.push(Entry { name, samples: vec![sample] }),
        }
    };
    for panel in panels {
        for series in &panel.series {
            add(&series.name, (series.tone, Some(series.mark), series.hollow));
        }
        for stripe in &panel.stripes {
            add(&stripe.name, (stripe.tone, None, false));
        }
    }
    entries
}

/// Where each entry stands: column offset and row.
fn legend_places(entries: &[Entry], width: f64) -> Vec<(f64, usize)> {
    let (mut x, mut row, mut places) = (0.0, 0, Vec::new());
    for entry in entries {
        let needed = SAMPLE + 8.0 + text_width(entry.name, TEXT);
        if x > 0.0 && x + needed > width {
            (x, row) = (0.0, row + 1);
        }
        places.push((x, row));
        x += needed + 18.0;
    }
    places
}

pub(super) fn legend_height(entries: &[Entry], width: f64) -> f64 {
    legend_places(entries, width).last().map_or(0.0, |(_, row)| (row + 1) as f64 * LINE + 4.0)
}

/// Draws the legend; gives its lower edge.
pub(super) fn draw_legend(pen: &mut Pen, entries: &[Entry], (left, top): (f64, f64), width: f64) -> f64 {
    for (entry, (x, row)) in entries.iter().zip(legend_places(entries, width)) {
        let (x, y) = (left + x, top + row as f64 * LINE + 0.5 * LINE + 2.0);
        // Bars have no look of their own where something else has the name too.
        let alone = entry.samples.len() == 1;
        for sample in entry.samples.iter().filter(|s| alone || s.1 != Some(Mark::Bars)) {
            draw_sample(pen, *sample, (x, y));
        }
        pen.text((x + SAMPLE + 6.0, y + 4.0), entry.name, TextStyle::new(TEXT, Anchor::Start));
    }
    top + legend_height(entries, width)
}

fn draw_sample(pen: &mut Pen, (tone, mark, hollow): Sample, (x, y): (f64, f64)) {
    let middle = (x + 0.5 * SAMPLE, y);
    let ends = [(x, y), (x + SAMPLE, y)];
    match mark {
        Some(Mark::Dots) => {
            pen.open(&format!("g fill=\"{}\" fill-opacity=\"0.8\"", tone.colour()));
            pen.dot(middle, 3.5, "");
            pen.close("g");
        }
        Some(Mark::Points(shape)) => pen.shape(middle, shape, 4.5, colours(tone, shape, hollow), ""),
        Some(Mark::Line(dash)) => pen.line(&ends, tone.dark_line(), 2.0, dash, ""),
        Some(Mark::Thin(dash)) => pen.line(&ends, tone.colour(), 1.0, dash, ""),
        Some(Mark::Bars) => pen.rect([x + 11.0, y - 6.0, x + 19.0, y + 6.0], &bar(tone, hollow)),
        Some(Mark::Band) => {
            pen.rect([x, y - 5.0, x + SAMPLE, y + 5.0], &format!("fill=\"{}\" fill-opacity=\"0.3\"", tone.colour()));
        }
        None => {
            let paint = format!("fill=\"{}\" fill-opacity=\"{STRIPE}\" stroke=\"{GRID}\"", tone.colour());
            pen.rect([x, y - 6.0, x + SAMPLE, y + 6.0], &paint);
        }
    }
}
