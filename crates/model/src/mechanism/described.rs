//! What a file says of the robot that it is about: `model`, `gravity` and `payload` of a table `[mechanism]`.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;
use toml::Spanned;

use super::{Mechanism, Payload};
use crate::input::{InputError, Key, Problem, Range, Section, Source, key};
use crate::units;

/// A description with what the table says of it.
pub struct Described {
    /// The file, as the table names it.
    pub model: String,
    /// The tree of bodies, payloads on it.
    pub mechanism: Mechanism,
    /// The same without them.
    pub bare: Mechanism,
    /// The payloads.
    pub payloads: Vec<Payload>,
}

const PAYLOAD: Key = key("payload", "masses that a link carries").value("table or list of tables");

/// The name of the description.
pub fn model(section: &Section) -> Option<Spanned<String>> {
    section.required_text(key("model", "URDF or MJCF").value("file"), "\"robots/arm.urdf\"")
}

/// Reads the description, by [`model`], and what the table says of it. What is wrong in the file itself goes to `errors`.
pub fn read(
    section: &Section,
    model: Option<Spanned<String>>,
    open: &mut dyn FnMut(&Path) -> Result<Arc<Source>, InputError>,
    errors: &mut Vec<InputError>,
) -> Option<Described> {
    let gravity =
        section.vector(key("gravity", "in the world").default("that of the model"), &units::LINEAR_ACCELERATION);
    let payloads = payloads(section);
    let model = model?;
    let path = section.source().folder().join(model.get_ref());
    let read = match open(&path) {
        Ok(source) => Mechanism::read_source(&source),
        Err(error) => {
            section.note(error.where_named("model", model.get_ref(), model.span()));
            return None;
        }
    };
    let mut mechanism = read.map_err(|error| errors.push(error)).ok()?;
    if let Some(gravity) = gravity {
        mechanism.gravity = Vector3::from(gravity);
    }
    let bare = mechanism.clone();
    let payloads = hang(section, &mut mechanism, payloads, model.get_ref());
    Some(Described { model: model.into_inner(), mechanism, bare, payloads })
}

/// The payloads of a table, each with the place of its link; what is wrong with one is noted.
pub fn payloads(section: &Section) -> Vec<Spanned<Payload>> {
    let tables = if section.is_list("payload") {
        section.sections(PAYLOAD)
    } else {
        section.section(PAYLOAD).into_iter().collect()
    };
    tables.into_iter().filter_map(one).collect()
}

fn one(table: Section) -> Option<Spanned<Payload>> {
    let link = table.required_text(key("link", "the link that carries it"), "\"tool0\"");
    let mass = table.required_quantity(key("mass", "of the payload"), &units::MASS, Range::Positive);
    let at = table.vector(key("at", "where on the link").default("its origin"), &units::LENGTH).unwrap_or([0.0; 3]);
    table.finish();
    let (link, mass) = (link?, mass?);
    let span = link.span();
    Some(Spanned::new(span, Payload { link: link.into_inner(), mass, at }))
}

/// Lets the robot carry payloads, and says which it does; a link that is not there is noted.
pub fn hang(
    section: &Section,
    mechanism: &mut Mechanism,
    payloads: Vec<Spanned<Payload>>,
    model: &str,
) -> Vec<Payload> {
    let mut hung = Vec::new();
    for payload in payloads {
        let span = payload.span();
        let payload = payload.into_inner();
        if mechanism.carry(&payload) {
            hung.push(payload);
        } else {
            let message = format!("there is no link `{}` in `{model}`", payload.link);
            section.note(Problem::at(span, message, "named here").suggest(&payload.link, mechanism.frames()));
        }
    }
    hung
}
