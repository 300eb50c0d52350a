//! The page: its frame, and what it knows before it asks for the first time.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::Explorer;
use crate::report::html;
use crate::requirement::Quantity;

/// What stands in the frame before anything is asked.
const BODY: &str = include_str!("page.html");
/// What makes it move.
const SCRIPT: &str = include_str!("explore.js");
/// How it looks, beyond what every page has.
const STYLE: &str = include_str!("explore.css");

/// What a page without a program behind it holds: answers over a grid.
#[derive(Debug, Clone, Default)]
pub struct Demo {
    /// Key, name, unit and values of each parameter.
    pub axes: Vec<Value>,
    /// The answers, by the place on each axis and the joint: `1,0|knee`.
    pub answers: BTreeMap<String, Value>,
}

fn data(explorer: &Explorer, more: Value) -> Value {
    let source = &explorer.ground.source;
    let mut names = vec!["balanced"];
    names.extend(Quantity::NAMES.iter().map(|(name, _)| *name));
    let mut data = json!({
        "name": explorer.file.name, "file": source.name(), "hash": source.sha256()[..8], "objectives": names, "begin": explorer.ground.begin,
        "joints": explorer.file.joints.iter().map(|joint| html::shown(&joint.name)).collect::<Vec<_>>(),
    });
    if let (Some(data), Value::Object(more)) = (data.as_object_mut(), more) {
        data.extend(more);
    }
    data
}

/// The page that asks, with its policy; `link` is the state that it begins with.
pub fn live(explorer: &Explorer, link: &str) -> (String, String) {
    let frame = frame(data(explorer, json!({ "link": link })), &explorer.file.name, true);
    (html::application(&frame), html::policy(&frame))
}

/// The page that has its answers in it.
pub fn demo(explorer: &Explorer, demo: &Demo) -> String {
    let grid = json!({ "axes": demo.axes, "answers": demo.answers });
    html::application(&frame(data(explorer, json!({ "link": "", "grid": grid })), &explorer.file.name, false))
}

fn frame(data: Value, name: &str, asks: bool) -> html::Frame<'static> {
    let title = format!("explore: {name}");
    html::Frame { title, body: BODY, style: STYLE, script: SCRIPT, data, asks }
}
