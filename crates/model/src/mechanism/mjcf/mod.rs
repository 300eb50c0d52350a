//! MJCF (MuJoCo's XML): nested bodies, default classes, inertias given or taken from primitive shapes.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Vector3};
use roxmltree::Attribute;

use super::xml::{El, Sheet, children, span};
use super::{Body, Inertia, Mechanism};
use crate::input::Problem;
use words::TOP;

mod body;
mod mass;
mod place;
mod settings;
mod words;

#[derive(Clone, Copy, PartialEq)]
enum FromGeom {
    Auto,
    Always,
    Never,
}

struct Compiler {
    /// Radians in the unit of angles.
    angle: f64,
    sequence: [char; 3],
    from_geom: FromGeom,
    groups: [f64; 2],
    total_mass: Option<f64>,
}

/// The elements whose attributes hold for an element, its own first, then its classes' outwards.
struct Layers<'a>(Vec<El<'a>>);

impl<'a> Layers<'a> {
    fn get(&self, name: &str) -> Option<Attribute<'a, 'a>> {
        self.0.iter().find_map(|node| node.attribute_node(name))
    }

    fn word(&self, name: &str) -> Option<&'a str> {
        self.get(name).map(|a| a.value())
    }
}

struct Reader<'a, 's> {
    sheet: &'s Sheet,
    compiler: Compiler,
    /// Per class: the class that it inherits from, and its elements.
    classes: HashMap<&'a str, (Option<&'a str>, Vec<El<'a>>)>,
    bodies: Vec<Body>,
    body_names: HashSet<String>,
    joint_names: HashSet<String>,
    sites: Vec<(usize, String, Isometry3<f64>)>,
}

pub(super) fn read<'a>(sheet: &Sheet, root: El<'a>) -> Option<Mechanism> {
    let mut reader = Reader {
        sheet,
        compiler: Compiler {
            angle: 1.0_f64.to_radians(),
            sequence: ['x', 'y', 'z'],
            from_geom: FromGeom::Auto,
            groups: [0.0, 5.0],
            total_mass: None,
        },
        classes: HashMap::from([("main", (None, Vec::new()))]),
        bodies: Vec::new(),
        body_names: HashSet::new(),
        joint_names: HashSet::new(),
        sites: Vec::new(),
    };
    let mut gravity = Vector3::new(0.0, 0.0, -9.81);
    for node in children(root) {
        match node.tag_name().name() {
            "compiler" => reader.compiler(node),
            "option" => reader.option(node, &mut gravity),
            "default" => reader.class(node, None, 0),
            name @ ("equality" | "tendon" | "deformable") => {
                if let Some(first) = children(node).find(|n| n.attribute("active") != Some("false")) {
                    let what =
                        format!("`{}` of `{name}` couples joints outside the tree of bodies", first.tag_name().name());
                    let help = match first.tag_name().name() {
                        "joint" => {
                            let terms: Vec<&str> =
                                first.attribute("polycoef").unwrap_or("0 1").split_whitespace().collect();
                            let per = terms.get(1).copied().unwrap_or("1");
                            format!(
                                "inverse dynamics needs a tree: remove it and give each joint its column in the trajectory. Where each \
                                 has an actuator, [[coupling]] of the requirement says how they go together: matrix = [[1, 0], [{per}, 1]]"
                            )
                        }
                        _ => "inverse dynamics needs a tree: cut the loop, and describe its links in the requirement: \
                              [joint.transmission] four_bar = { … } where they move one joint, [[coupling]] rods = [ { … }, { … } ] \
                              where they move two"
                            .to_string(),
                    };
                    sheet.refuse(first, &what, &help);
                }
            }
            "include" => sheet.refuse(node, "an included file is not read", "put its text in place of `include`"),
            other if TOP.contains(&other) => {}
            _ => sheet.unknown(node, TOP),
        }
    }
    let mut world = 0;
    for node in children(root).filter(|n| n.has_tag_name("worldbody")) {
        reader.inside(node, None, None, Isometry3::identity(), &mut Vec::new(), 0);
        world += 1;
    }
    if world == 0 {
        sheet.note(Problem::at(span(root), "the model has no `worldbody`", "expected <worldbody>"));
    }
    if sheet.has_problems() {
        return None;
    }
    let Reader { mut bodies, sites, compiler, .. } = reader;
    for (parent, name, placement) in sites {
        if !bodies.iter().any(|b| b.name.as_ref() == Some(&name)) {
            bodies.push(Body {
                name: Some(name),
                parent: Some(parent),
                placement,
                joint: None,
                inertia: Inertia::none(),
            });
        }
    }
    let mass: f64 = bodies.iter().map(|b| b.inertia.mass).sum();
    if let Some(total) = compiler.total_mass.filter(|_| mass > 0.0) {
        for body in &mut bodies {
            body.inertia.mass *= total / mass;
            body.inertia.about_centre *= total / mass;
        }
    }
    let name = root.attribute("model").unwrap_or("MuJoCo Model").to_string();
    Some(Mechanism { name, bodies, gravity, notes: Vec::new() })
}
