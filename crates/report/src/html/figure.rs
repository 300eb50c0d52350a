//! Figures as data for the page's script: the same series, tones, dashes and ranges that the SVG is drawn from.

use serde_json::{Map, Value, json};

use crate::plot::{Along, Axis, Figure, Mark, Panel, Scale, Series, Tone, described, ranges};

/// Every tone, in the order of its index in the page.
const TONES: [Tone; 9] = [
    Tone::Blue,
    Tone::Orange,
    Tone::Green,
    Tone::Vermilion,
    Tone::Purple,
    Tone::Sky,
    Tone::Yellow,
    Tone::Black,
    Tone::Grey,
];

/// A tone that stands out from a dark ground, with the contrast that the tone itself has on white.
fn on_dark(tone: Tone) -> &'static str {
    match tone {
        Tone::Blue => "#4da6e0",
        Tone::Orange => "#e69f00",
        Tone::Green => "#2bc496",
        Tone::Vermilion => "#f08a3c",
        Tone::Purple => "#dd98bd",
        Tone::Sky => "#8fd0f5",
        Tone::Yellow => "#f0e442",
        Tone::Black => "#f0f0f0",
        Tone::Grey => "#8c939b",
    }
}

/// `[area, line, outline]` of each tone, on light and on dark ground.
pub fn tones() -> Value {
    json!({
        "light": TONES.map(|t| [t.colour(), t.dark_line(), t.dark()]),
        "dark": TONES.map(|t| [on_dark(t), on_dark(t), "#0d1117"]),
    })
}

fn tone(tone: Tone) -> usize {
    TONES.iter().position(|t| *t == tone).unwrap_or(0)
}

/// Ids of the whole page, each with its index.
#[derive(Debug, Default)]
pub struct Ids {
    names: Vec<String>,
    places: std::collections::HashMap<String, usize>,
}

impl Ids {
    /// The index of an id.
    pub fn index(&mut self, id: &str) -> usize {
        if let Some(place) = self.places.get(id) {
            return *place;
        }
        self.names.push(id.into());
        self.places.insert(id.into(), self.names.len() - 1);
        self.names.len() - 1
    }

    /// All, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

/// A number with six significant digits: finer than a screen; `null` where it is not finite.
fn coordinate(value: f64) -> Value {
    let rounded = format!("{value:.5e}").parse::<f64>().unwrap_or(value);
    if !rounded.is_finite() {
        return Value::Null;
    }
    // Whole numbers are shorter without a fraction.
    if rounded.fract() == 0.0 && rounded.abs() < 1e15 { json!(rounded as i64) } else { json!(rounded) }
}

/// The figure for the script.
pub fn data(figure: &Figure, ids: &mut Ids) -> Value {
    let groups: Vec<Value> = figure
        .groups
        .iter()
        .map(|group| {
            let panels: Vec<Value> = group.panels.iter().map(|p| panel(p, ids)).collect();
            json!({ "title": group.title, "caption": group.caption, "own": group.own_legends, "panels": panels })
        })
        .collect();
    let title = if figure.title.is_empty() {
        figure.groups.iter().map(|g| g.title.as_str()).filter(|t| !t.is_empty()).collect::<Vec<_>>().join("; ")
    } else {
        figure.title.clone()
    };
    let description = if figure.description.is_empty() { described(figure) } else { figure.description.clone() };
    json!({
        "title": title, "description": description,
        "columns": figure.columns, "panel": [figure.panel.0, figure.panel.1], "groups": groups,
    })
}

fn panel(panel: &Panel, ids: &mut Ids) -> Value {
    let range = ranges(panel);
    let axis = |axis: &Axis, range: Option<(f64, f64)>| {
        json!({
            "label": axis.label, "log": axis.scale == Scale::Log, "names": axis.names,
            "range": range.map(|(low, high)| [low, high]),
        })
    };
    let along = |along: Along| if along == Along::X { "x" } else { "y" };
    json!({
        "title": panel.title,
        "x": axis(&panel.x, range.map(|r| r.0)),
        "y": axis(&panel.y, range.map(|r| r.1)),
        "empty": panel.empty,
        "stripes": panel.stripes.iter().map(|s| json!({
            "along": along(s.along), "from": coordinate(s.from), "to": coordinate(s.to), "tone": tone(s.tone), "name": s.name,
        })).collect::<Vec<_>>(),
        "rules": panel.rules.iter().map(|r| json!({
            "along": along(r.along), "at": coordinate(r.at), "tone": tone(r.tone), "dash": dash(r.dash.pattern()), "text": r.text,
        })).collect::<Vec<_>>(),
        "series": panel.series.iter().map(|s| series(s, ids)).collect::<Vec<_>>(),
        "labels": panel.labels.iter().map(|l| json!({
            "x": coordinate(l.at.0), "y": coordinate(l.at.1), "text": l.text, "chosen": l.chosen,
        })).collect::<Vec<_>>(),
    })
}

fn dash(pattern: &str) -> Vec<u32> {
    pattern.split_whitespace().filter_map(|n| n.parse().ok()).collect()
}

fn series(series: &Series, ids: &mut Ids) -> Value {
    let mut object = Map::new();
    let mut put = |key: &str, value: Value| object.insert(key.into(), value);
    let (mark, detail) = match series.mark {
        Mark::Dots => ("dots", Value::Null),
        Mark::Points(shape) => ("points", json!(format!("{shape:?}"))),
        Mark::Line(d) => ("line", json!(dash(d.pattern()))),
        Mark::Thin(d) => ("thin", json!(dash(d.pattern()))),
        Mark::Bars => ("bars", Value::Null),
        Mark::Band => ("band", Value::Null),
    };
    put("mark", json!(mark));
    if !detail.is_null() {
        put(if mark == "points" { "shape" } else { "dash" }, detail);
    }
    put("tone", json!(tone(series.tone)));
    if !series.name.is_empty() {
        put("name", json!(series.name));
    }
    put("x", series.points.iter().map(|p| coordinate(p.0)).collect());
    put("y", series.points.iter().map(|p| coordinate(p.1)).collect());
    if !series.upper.is_empty() {
        put("upper", series.upper.iter().map(|u| coordinate(*u)).collect());
    }
    if !series.ids.is_empty() {
        put("ids", series.ids.iter().map(|id| json!(ids.index(id))).collect());
    }
    // A note that only repeats the id is not written again.
    if series.notes.iter().enumerate().any(|(k, note)| series.id(k) != Some(note)) {
        put("notes", json!(series.notes));
    }
    if !series.along.is_empty() {
        put("along", json!(series.along));
    }
    if series.hollow {
        put("hollow", json!(true));
    }
    if !series.sizes.is_empty() {
        put("sizes", series.sizes.iter().map(|size| coordinate(*size)).collect());
    }
    Value::Object(object)
}
