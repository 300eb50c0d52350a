//! What the formats in USD share: a layer of prims over a stage that is there, as text (`.usda`).

use super::{Exported, Origin, Wishes, hashes, python::identifiers};

/// A prim of a layer: its name, its head (`over`, or `def` with a type), its metadata and attributes, and what hangs in it.
#[derive(Default)]
struct Prim {
    name: String,
    head: String,
    schemas: Vec<String>,
    lines: Vec<String>,
    children: Vec<Prim>,
}

impl Prim {
    fn child(&mut self, name: &str) -> &mut Prim {
        let at = self.children.iter().position(|c| c.name == name).unwrap_or_else(|| {
            self.children.push(Prim { name: name.into(), head: "over".into(), ..Prim::default() });
            self.children.len() - 1
        });
        &mut self.children[at]
    }

    fn write(&self, out: &mut String, depth: usize) {
        let indent = "    ".repeat(depth);
        out.push_str(&format!("{indent}{} \"{}\"", self.head, self.name));
        if !self.schemas.is_empty() {
            let schemas: Vec<String> = self.schemas.iter().map(|s| format!("\"{s}\"")).collect();
            out.push_str(" (\n");
            let inner = "    ".repeat(depth + 1);
            out.push_str(&format!("{inner}prepend apiSchemas = [{}]\n", schemas.join(", ")));
            out.push_str(&format!("{indent})"));
        }
        out.push_str(&format!("\n{indent}{{\n"));
        self.lines.iter().for_each(|line| out.push_str(&format!("{indent}    {line}\n")));
        self.children.iter().for_each(|child| child.write(out, depth + 1));
        out.push_str(&format!("{indent}}}\n"));
    }
}

/// What a joint gets: schemas and lines of its prim, and an actuator next to it.
#[derive(Default)]
pub struct Joint {
    /// API schemas of the joint.
    pub schemas: Vec<&'static str>,
    /// Attributes of the joint, one a line.
    pub lines: Vec<String>,
    /// Type, schemas and attributes of the actuator next to it, where there is one.
    pub actuator: Option<(&'static str, Vec<&'static str>, Vec<String>)>,
}

/// A path of a prim, checked: text of others stays out of the layer.
fn path(pattern: &str) -> Result<Vec<&str>, String> {
    let names: Vec<&str> = pattern.split('/').skip(1).collect();
    let is_name = |name: &&str| {
        name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if !pattern.starts_with('/') || names.is_empty() || !names.iter().all(is_name) {
        return Err(format!(
            "`{pattern}` is no path of a prim: give the joint's path in the stage, as in `--map knee=/Robot/joints/knee`"
        ));
    }
    Ok(names)
}

/// A layer of joints.
///
/// # Errors
/// In words: a path that is none, or of two joints; what a joint lacks.
pub fn layer(
    comments: &[String],
    origin: &Origin,
    joints: &[Exported],
    wishes: &Wishes,
    mut of: impl FnMut(&Exported) -> Result<Joint, String>,
) -> Result<String, String> {
    let mut root = Prim::default();
    let mut taken: Vec<String> = Vec::new();
    for (e, identifier) in joints.iter().zip(identifiers(joints)) {
        let given: Vec<&str> = wishes.names.iter().filter(|(j, _)| j == e.joint).map(|(_, p)| p.as_str()).collect();
        let default = format!("/Robot/joints/{identifier}");
        let paths = if given.is_empty() { vec![default.as_str()] } else { given };
        for at in paths {
            if taken.iter().any(|t| t == at) {
                return Err(format!("`{at}` is meant by two joints"));
            }
            taken.push(at.into());
            let names = path(at)?;
            let joint = of(e)?;
            let mut prim = &mut root;
            for name in &names[..names.len() - 1] {
                prim = prim.child(name);
            }
            let last = names[names.len() - 1];
            if let Some((kind, schemas, lines)) = joint.actuator {
                let actuator = prim.child(&format!("{last}_actuator"));
                actuator.head = format!("def {kind}");
                actuator.schemas = schemas.into_iter().map(Into::into).collect();
                actuator.lines = std::iter::once(format!("rel newton:targets = <{at}>")).chain(lines).collect();
            }
            if joint.lines.is_empty() {
                continue;
            }
            let own = prim.child(last);
            own.schemas = joint.schemas.into_iter().map(Into::into).collect();
            own.lines = joint.lines;
        }
    }
    let mut out = String::from("#usda 1.0\n");
    out.push_str(&hashes(comments));
    out.push_str(&hashes(&[format!(
        "a layer for the stage of {}: put it above the asset, as its sublayer",
        origin.robot
    )]));
    for prim in &root.children {
        out.push('\n');
        prim.write(&mut out, 0);
    }
    Ok(out)
}
