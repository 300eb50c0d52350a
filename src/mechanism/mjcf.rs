//! MJCF (MuJoCo's XML): nested bodies, default classes, inertias given or taken from primitive shapes.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use roxmltree::Attribute;

use super::geom::Shape;
use super::xml::{El, Sheet, children, span};
use super::{Body, Inertia, Joint, Mechanism, Motion, pose};
use crate::input::{Problem, Range, limits};

const TOP: &[&str] = &[
    "compiler",
    "option",
    "size",
    "statistic",
    "visual",
    "default",
    "asset",
    "worldbody",
    "contact",
    "deformable",
    "equality",
    "tendon",
    "actuator",
    "sensor",
    "keyframe",
    "custom",
    "extension",
    "include",
];
const ORIENTATION: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
const OF_BODY: &[&str] = &[
    "name",
    "pos",
    "quat",
    "axisangle",
    "euler",
    "xyaxes",
    "zaxis",
    "childclass",
    "mocap",
    "gravcomp",
    "user",
    "sleep",
    "simple",
    "fuse",
];
const OF_INERTIAL: &[&str] =
    &["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "mass", "diaginertia", "fullinertia"];
const OF_JOINT: &[&str] = &[
    "name",
    "class",
    "type",
    "group",
    "pos",
    "axis",
    "springdamper",
    "limited",
    "actuatorfrclimited",
    "solreflimit",
    "solimplimit",
    "solreffriction",
    "solimpfriction",
    "stiffness",
    "range",
    "actuatorfrcrange",
    "actuatorgravcomp",
    "margin",
    "ref",
    "springref",
    "springyield",
    "armature",
    "damping",
    "frictionloss",
    "user",
];
const OF_GEOM: &[&str] = &[
    "name",
    "class",
    "type",
    "contype",
    "conaffinity",
    "condim",
    "group",
    "priority",
    "size",
    "material",
    "friction",
    "mass",
    "density",
    "shellinertia",
    "solmix",
    "solref",
    "solimp",
    "margin",
    "gap",
    "fromto",
    "pos",
    "quat",
    "axisangle",
    "euler",
    "xyaxes",
    "zaxis",
    "hfield",
    "mesh",
    "fitscale",
    "rgba",
    "fluidshape",
    "fluidcoef",
    "user",
    "adhesion",
    "castshadow",
    "surfacevel",
];
const OF_COMPILER: &[&str] = &[
    "autolimits",
    "boundmass",
    "boundinertia",
    "settotalmass",
    "balanceinertia",
    "strippath",
    "coordinate",
    "angle",
    "fitaabb",
    "eulerseq",
    "meshdir",
    "texturedir",
    "assetdir",
    "discardvisual",
    "usethread",
    "fusestatic",
    "inertiafromgeom",
    "inertiagrouprange",
    "saveinertial",
    "alignfree",
    "conflict",
    "passthrough",
    "savecanonical",
    "savecompiled",
    "convexhull",
    "exactmeshinertia",
];
/// What may stand in a body beside what is read.
const ASIDE: &[&str] = &["camera", "light"];
const IN_BODY: &[&str] = &["body", "inertial", "joint", "geom", "site", "frame", "camera", "light"];

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
                        format!("`{}` of `{name}` couples joints beside the tree of bodies", first.tag_name().name());
                    let help = "inverse dynamics needs a tree; cut the loop and give its force as an external force";
                    sheet.refuse(first, &what, help);
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

impl<'a> Reader<'a, '_> {
    fn choose<T: Copy>(&self, attribute: Attribute, choices: &[(&'static str, T)]) -> Option<T> {
        let found = choices.iter().find(|(word, _)| *word == attribute.value());
        if found.is_none() {
            let shown: String = attribute.value().chars().take(40).collect();
            let message = format!("`{}` cannot be `{shown}`", attribute.name());
            let names = choices.iter().map(|(word, _)| *word);
            self.sheet
                .note(Problem::at(attribute.range_value(), message, "not one of the choices").suggest(&shown, names));
        }
        found.map(|(_, value)| *value)
    }

    fn compiler(&mut self, node: El) {
        let sheet = self.sheet;
        sheet.only(node, OF_COMPILER);
        let get = |name: &str| node.attribute_node(name);
        if let Some(a) = get("angle") {
            let unit = self.choose(a, &[("degree", 1.0_f64.to_radians()), ("radian", 1.0)]);
            self.compiler.angle = unit.unwrap_or(self.compiler.angle);
        }
        if let Some(a) = get("eulerseq") {
            let letters: Vec<char> = a.value().chars().collect();
            match <[char; 3]>::try_from(letters) {
                Ok(letters) if letters.iter().all(|c| "xyzXYZ".contains(*c)) => self.compiler.sequence = letters,
                _ => sheet.note(Problem::at(
                    a.range_value(),
                    "`eulerseq` is not a sequence of axes",
                    "expected three of xyzXYZ",
                )),
            }
        }
        if let Some(a) = get("inertiafromgeom") {
            let choices = [("auto", FromGeom::Auto), ("true", FromGeom::Always), ("false", FromGeom::Never)];
            self.compiler.from_geom = self.choose(a, &choices).unwrap_or(FromGeom::Auto);
        }
        if let Some(groups) = get("inertiagrouprange").and_then(|a| sheet.numbers::<2>(a)) {
            self.compiler.groups = groups;
        }
        if let Some(total) = get("settotalmass").and_then(|a| sheet.number(a, Range::Any)) {
            self.compiler.total_mass = Some(total).filter(|t| *t > 0.0);
        }
        for name in ["boundmass", "boundinertia"] {
            if let Some(a) = get(name).filter(|a| a.value().trim().parse::<f64>().is_ok_and(|v| v > 0.0)) {
                let problem = Problem::at(a.range(), format!("`{name}` changes masses of the model"), "not supported");
                sheet.note(problem.help("write the masses that are meant into the bodies"));
            }
        }
        for (name, value) in [("balanceinertia", "true"), ("coordinate", "global")] {
            if let Some(a) = get(name).filter(|a| a.value() == value) {
                let message = format!("`{name}=\"{value}\"` changes bodies of the model");
                sheet.note(Problem::at(a.range(), message, "not supported").help("save the model compiled by MuJoCo"));
            }
        }
    }

    fn option(&mut self, node: El, gravity: &mut Vector3<f64>) {
        let sheet = self.sheet;
        if let Some(given) = node.attribute_node("gravity").and_then(|a| sheet.numbers::<3>(a)) {
            *gravity = Vector3::from(given);
        }
        for name in ["density", "viscosity"] {
            if let Some(a) =
                node.attribute_node(name).filter(|a| a.value().trim().parse::<f64>().is_ok_and(|v| v != 0.0))
            {
                let problem = Problem::at(a.range(), "forces of a fluid are not modelled", "not supported");
                sheet.note(problem.help("remove it, or give its force as an external force"));
            }
        }
        for flag in children(node).filter(|n| n.has_tag_name("flag")) {
            if flag.attribute("gravity") == Some("disable") {
                *gravity = Vector3::zeros();
            }
            for name in ["spring", "damper", "passive"] {
                if let Some(a) = flag.attribute_node(name).filter(|a| a.value() == "disable") {
                    let problem =
                        Problem::at(a.range(), format!("`{name}=\"disable\"` is not supported"), "changes the torques");
                    sheet.note(problem.help("remove springs and damping of the joints instead"));
                }
            }
        }
    }

    fn class(&mut self, node: El<'a>, inside: Option<&'a str>, depth: usize) {
        if depth > limits::DEPTH {
            self.sheet.refuse(node, "default classes are nested too deep", "at most 200 deep");
            return;
        }
        let name = match (node.attribute("class"), inside) {
            (Some(name), _) => name,
            (None, None) => "main",
            (None, Some(_)) => {
                self.sheet.required(node, "class");
                return;
            }
        };
        let above = inside.and_then(|name| self.classes.get_key_value(name).map(|(key, _)| *key));
        // The outermost class may have a name of its own; it still stands for elements without a class.
        let entry = self.classes.entry(name).or_insert((above, Vec::new()));
        let parts: Vec<El> = children(node).filter(|n| !n.has_tag_name("default")).collect();
        entry.1.extend(&parts);
        if inside.is_none()
            && name != "main"
            && let Some(main) = self.classes.get_mut("main")
        {
            main.1.extend(&parts);
        }
        for part in parts {
            match part.tag_name().name() {
                "joint" => self.sheet.only(part, OF_JOINT),
                "geom" => self.sheet.only(part, OF_GEOM),
                _ => {}
            }
        }
        for inner in children(node).filter(|n| n.has_tag_name("default")) {
            self.class(inner, Some(name), depth + 1);
        }
    }

    /// The elements whose attributes hold for an element of a body.
    fn layers(&self, node: El<'a>, child_class: Option<&str>) -> Option<Layers<'a>> {
        let mut layers = vec![node];
        let mut class = match node.attribute_node("class") {
            Some(a) => Some(self.known_class(a)?),
            None => Some(child_class.unwrap_or("main")),
        };
        while let Some((above, parts)) = class.and_then(|name| self.classes.get(name)) {
            // What stands later in a class wins.
            layers.extend(parts.iter().rev().filter(|p| p.tag_name() == node.tag_name()));
            class = *above;
        }
        Some(Layers(layers))
    }

    fn known_class(&self, attribute: Attribute<'a, 'a>) -> Option<&'a str> {
        let name = attribute.value();
        let found = self.classes.get_key_value(name).map(|(key, _)| *key);
        if found.is_none() {
            let shown: String = name.chars().take(60).collect();
            let mut names: Vec<&str> = self.classes.keys().copied().collect();
            names.sort_unstable();
            self.sheet.note(
                Problem::at(attribute.range_value(), format!("there is no default class `{shown}`"), "named here")
                    .suggest(&shown, names),
            );
        }
        found
    }

    /// Which way an element is turned: by the first layer that says so.
    fn orientation(&self, layers: &Layers<'a>) -> UnitQuaternion<f64> {
        let said = layers.0.iter().find(|node| ORIENTATION.iter().any(|name| node.has_attribute(*name)));
        let Some(node) = said else { return UnitQuaternion::identity() };
        let given: Vec<Attribute> = ORIENTATION.iter().filter_map(|name| node.attribute_node(*name)).collect();
        if let [_, second, ..] = given.as_slice() {
            self.sheet.note(Problem::at(second.range(), "two orientations of one element", "expected one of them"));
        }
        self.turned(given[0]).unwrap_or_default()
    }

    fn turned(&self, a: Attribute) -> Option<UnitQuaternion<f64>> {
        let (sheet, unit) = (self.sheet, self.compiler.angle);
        let nowhere = |what: &str| {
            sheet.note(Problem::at(a.range_value(), format!("`{}` {what}", a.name()), "expected a direction"))
        };
        match a.name() {
            "quat" => {
                let [w, x, y, z] = sheet.numbers::<4>(a)?;
                let turned = UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-10);
                if turned.is_none() {
                    nowhere("is zero");
                }
                turned
            }
            "axisangle" => {
                let [x, y, z, angle] = sheet.numbers::<4>(a)?;
                let axis = UnitVector3::try_new(Vector3::new(x, y, z), 1e-10);
                if axis.is_none() {
                    nowhere("has no axis");
                }
                Some(UnitQuaternion::from_axis_angle(&axis?, angle * unit))
            }
            "euler" => {
                let angles = sheet.numbers::<3>(a)?;
                let mut turned = UnitQuaternion::identity();
                for (letter, angle) in self.compiler.sequence.iter().zip(angles) {
                    let axis = match letter.to_ascii_lowercase() {
                        'x' => Vector3::x_axis(),
                        'y' => Vector3::y_axis(),
                        _ => Vector3::z_axis(),
                    };
                    let step = UnitQuaternion::from_axis_angle(&axis, angle * unit);
                    // Small letters turn with the frame, capitals about the fixed axes.
                    turned = if letter.is_ascii_lowercase() { turned * step } else { step * turned };
                }
                Some(turned)
            }
            "xyaxes" => {
                let [x1, x2, x3, y1, y2, y3] = sheet.numbers::<6>(a)?;
                let x = UnitVector3::try_new(Vector3::new(x1, x2, x3), 1e-10)?.into_inner();
                let given = Vector3::new(y1, y2, y3);
                let Some(y) = UnitVector3::try_new(given - x * x.dot(&given), 1e-10) else {
                    nowhere("has parallel axes");
                    return None;
                };
                let columns = Matrix3::from_columns(&[x, y.into_inner(), x.cross(&y)]);
                Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns)))
            }
            _ => Some(from_z(&sheet.direction(a)?)),
        }
    }

    fn at(&self, layers: &Layers<'a>) -> [f64; 3] {
        layers.get("pos").and_then(|a| self.sheet.numbers::<3>(a)).unwrap_or([0.0; 3])
    }

    /// Reads what stands in a body, in a frame of it, or in the world (`body` none). `outer` is where the
    /// frame is in the body.
    fn inside(
        &mut self,
        node: El<'a>,
        body: Option<usize>,
        class: Option<&'a str>,
        outer: Isometry3<f64>,
        masses: &mut Vec<Inertia>,
        depth: usize,
    ) {
        let sheet = self.sheet;
        if depth > limits::DEPTH {
            sheet.refuse(node, "bodies are nested too deep", "at most 200 deep");
            return;
        }
        let class = match node.attribute_node("childclass") {
            Some(a) => self.known_class(a).or(class),
            None => class,
        };
        for child in children(node) {
            match child.tag_name().name() {
                "body" => self.body(child, body, class, outer, depth + 1),
                "frame" => {
                    let Some(layers) = self.layers(child, None) else { continue };
                    let here = outer * pose(self.at(&layers), self.orientation(&layers));
                    self.inside(child, body, class, here, masses, depth + 1);
                }
                "geom" => {
                    if let Some(inertia) = body.and_then(|_| self.geom(child, class)) {
                        masses.push(inertia.at(&outer));
                    }
                }
                "site" => self.site(child, body, class, &outer),
                "freejoint" => self.refuse_free(child),
                // Read with the body that they belong to.
                "inertial" | "joint" if body.is_some() => {}
                "plugin" | "composite" | "flexcomp" | "replicate" | "attach" | "include" => {
                    let what = format!("`{}` in a body is not read", child.tag_name().name());
                    sheet.refuse(child, &what, "write out the bodies that it stands for");
                }
                other if ASIDE.contains(&other) => {}
                _ => sheet.unknown(child, IN_BODY),
            }
        }
    }

    fn refuse_free(&self, node: El) {
        self.sheet.refuse(
            node,
            "a free joint: the base of this model moves",
            "remove it: the base is then fixed, which is exact while the base moves without acceleration; forces on the feet are columns of the trajectory",
        );
    }

    /// All joints of a body, those in its frames with the frame.
    fn joints(
        &mut self,
        node: El<'a>,
        class: Option<&'a str>,
        outer: Isometry3<f64>,
        found: &mut Vec<(Joint, Vector3<f64>)>,
    ) {
        for child in children(node) {
            if child.has_tag_name("frame") {
                let class = child.attribute("childclass").or(class);
                let Some(layers) = self.layers(child, None) else { continue };
                let here = outer * pose(self.at(&layers), self.orientation(&layers));
                self.joints(child, class, here, found);
            } else if child.has_tag_name("joint")
                && let Some((joint, at)) = self.joint(child, class)
            {
                let axis = outer.rotation * joint.axis;
                let at = (outer * nalgebra::Point3::from(at)).coords;
                found.push((Joint { axis, ..joint }, at));
            }
        }
    }

    fn joint(&mut self, node: El<'a>, class: Option<&'a str>) -> Option<(Joint, Vector3<f64>)> {
        let sheet = self.sheet;
        sheet.only(node, OF_JOINT);
        let layers = self.layers(node, class)?;
        let kinds = [("hinge", Some(Motion::Turns)), ("slide", Some(Motion::Slides)), ("ball", None), ("free", None)];
        let kind = layers.get("type").map_or(Some(Some(Motion::Turns)), |a| self.choose(a, &kinds))?;
        let Some(motion) = kind else {
            if layers.word("type") == Some("free") {
                self.refuse_free(node);
            } else {
                sheet.refuse(node, "a ball joint has three degrees of freedom", "write it as three hinges");
            }
            return None;
        };
        let name = match node.attribute("name") {
            Some(name) => name.to_string(),
            None => format!("joint_{}", self.joint_names.len() + 1),
        };
        sheet.unique(node, "joints", &name, &mut self.joint_names);
        let axis = layers.get("axis").map_or(Some(Vector3::z_axis()), |a| sheet.direction(a))?;
        let unit = if motion == Motion::Turns { self.compiler.angle } else { 1.0 };
        let number = |name: &str, range| layers.get(name).and_then(|a| sheet.number(a, range)).unwrap_or(0.0);
        let mut joint = Joint::new(name, motion, axis);
        joint.reference = number("ref", Range::Any) * unit;
        joint.damping = number("damping", Range::NonNegative);
        joint.friction = number("frictionloss", Range::NonNegative);
        joint.stiffness = number("stiffness", Range::NonNegative);
        joint.spring_reference = number("springref", Range::Any) * unit;
        joint.armature = number("armature", Range::NonNegative);
        let range = layers.get("range").and_then(|a| sheet.numbers::<2>(a)).filter(|r| r[0] < r[1]);
        joint.range = range.filter(|_| layers.word("limited") != Some("false")).map(|r| r.map(|end| end * unit));
        for (name, zero) in [("springdamper", "0 0"), ("springyield", "0")] {
            let set =
                |a: &Attribute| a.value().split_whitespace().any(|w| w.parse() != Ok(0.0)) && a.value().trim() != zero;
            if let Some(a) = layers.get(name).filter(set) {
                let problem = Problem::at(a.range(), format!("`{name}` is not supported"), "changes the torques");
                sheet.note(problem.help("give `stiffness` and `damping`"));
            }
        }
        Some((joint, Vector3::from(self.at(&layers))))
    }

    fn body(
        &mut self,
        node: El<'a>,
        parent: Option<usize>,
        class: Option<&'a str>,
        outer: Isometry3<f64>,
        depth: usize,
    ) {
        let sheet = self.sheet;
        sheet.only(node, OF_BODY);
        if node.attribute("mocap") == Some("true") {
            sheet.refuse(node, "a mocap body is moved from outside", "remove it, or make it fixed");
        }
        if let Some(a) = node.attribute_node("gravcomp").filter(|a| a.value().trim().parse() != Ok(0.0)) {
            let problem = Problem::at(
                a.range(),
                "`gravcomp` takes weight off the actuators without saying what carries it",
                "not supported",
            );
            sheet.note(problem.help("remove it, or give its force as an external force"));
        }
        let name = node.attribute("name").map(str::to_string);
        if let Some(name) = &name {
            sheet.unique(node, "bodies", name, &mut self.body_names);
        }
        let inner_class = match node.attribute_node("childclass") {
            Some(a) => self.known_class(a).or(class),
            None => class,
        };
        let own = Layers(vec![node]);
        let mut placement = outer * pose(self.at(&own), self.orientation(&own));
        let mut joints = Vec::new();
        self.joints(node, inner_class, Isometry3::identity(), &mut joints);
        // Each joint turns about its own point: go there, turn, and go back.
        let mut hangs_on = parent;
        for (joint, at) in joints {
            placement *= Translation3::from(at);
            self.bodies.push(Body {
                name: None,
                parent: hangs_on,
                placement,
                joint: Some(joint),
                inertia: Inertia::none(),
            });
            hangs_on = Some(self.bodies.len() - 1);
            placement = Translation3::from(-at).into();
        }
        let here = match hangs_on {
            // The last joint's frame is the body's where nothing lies between them.
            Some(last) if hangs_on != parent && placement.translation.vector == Vector3::zeros() => {
                self.bodies[last].name = name;
                last
            }
            _ => {
                self.bodies.push(Body { name, parent: hangs_on, placement, joint: None, inertia: Inertia::none() });
                self.bodies.len() - 1
            }
        };
        let mut of_geoms = Vec::new();
        self.inside(node, Some(here), class, Isometry3::identity(), &mut of_geoms, depth);
        let given: Vec<El> = children(node).filter(|n| n.has_tag_name("inertial")).collect();
        if let [_, second, ..] = given.as_slice() {
            sheet.note(Problem::at(span(*second), "two `inertial` of one body", "expected one"));
        }
        let use_geoms = match self.compiler.from_geom {
            FromGeom::Auto => given.is_empty(),
            FromGeom::Always => true,
            FromGeom::Never => false,
        };
        self.bodies[here].inertia = if use_geoms {
            of_geoms.iter().fold(Inertia::none(), |sum, part| sum.with(part))
        } else {
            given.first().map_or_else(Inertia::none, |node| self.inertial(*node))
        };
    }

    fn inertial(&self, node: El<'a>) -> Inertia {
        let sheet = self.sheet;
        sheet.only(node, OF_INERTIAL);
        let own = Layers(vec![node]);
        let mass = sheet
            .required(node, "mass")
            .and(node.attribute_node("mass"))
            .and_then(|a| sheet.number(a, Range::NonNegative));
        let full = node.attribute_node("fullinertia").and_then(|a| Some((a, sheet.numbers::<6>(a)?)));
        let diagonal = node.attribute_node("diaginertia").and_then(|a| Some((a, sheet.numbers::<3>(a)?)));
        let (place, about_centre) = match (full, diagonal) {
            (Some((a, _)), Some(_)) => {
                sheet.note(Problem::at(a.range(), "`fullinertia` beside `diaginertia`", "expected one of them"));
                return Inertia::none();
            }
            (Some((a, [xx, yy, zz, xy, xz, yz])), None) => {
                (a.range(), Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
            }
            (None, Some((a, moments))) => (a.range(), Matrix3::from_diagonal(&Vector3::from(moments))),
            (None, None) => (span(node), Matrix3::zeros()),
        };
        let inertia = Inertia { mass: mass.unwrap_or(0.0), centre: Vector3::zeros(), about_centre };
        if let Some(what) = inertia.impossible() {
            let problem = Problem::at(place, "no rigid body has this inertia", what);
            sheet.note(problem.help("check units (kg*m^2), signs, and that it is about the centre of mass"));
        }
        inertia.at(&pose(self.at(&own), self.orientation(&own)))
    }

    /// What a geom adds to the mass of its body, in the body's frame; nothing where it has no mass, or where
    /// its body gives its inertia itself.
    fn geom(&self, node: El<'a>, class: Option<&'a str>) -> Option<Inertia> {
        let sheet = self.sheet;
        sheet.only(node, OF_GEOM);
        let mut owner = node.parent_element()?;
        while owner.has_tag_name("frame") {
            owner = owner.parent_element()?;
        }
        let has_inertial = children(owner).any(|n| n.has_tag_name("inertial"));
        let counts = match self.compiler.from_geom {
            FromGeom::Auto => !has_inertial,
            FromGeom::Always => true,
            FromGeom::Never => false,
        };
        let layers = self.layers(node, class)?;
        let number = |name: &str, range| layers.get(name).and_then(|a| sheet.number(a, range));
        let group = number("group", Range::Any).unwrap_or(0.0);
        let mass = number("mass", Range::NonNegative);
        let density = number("density", Range::NonNegative).unwrap_or(1000.0);
        let [least, most] = self.compiler.groups;
        if !counts || !(least..=most).contains(&group) || mass == Some(0.0) || (mass.is_none() && density == 0.0) {
            return None;
        }
        let mut here = pose(self.at(&layers), self.orientation(&layers));
        let size = layers.get("size").and_then(|a| Some((a, sheet.list(a)?)));
        let mut given = size.as_ref().map_or_else(Vec::new, |(_, s)| s.clone());
        let kind = layers.word("type").unwrap_or(if layers.word("mesh").is_some() { "mesh" } else { "sphere" });
        if let Some([x1, y1, z1, x2, y2, z2]) = layers.get("fromto").and_then(|a| sheet.numbers::<6>(a)) {
            let (from, to) = (Vector3::new(x1, y1, z1), Vector3::new(x2, y2, z2));
            let along = UnitVector3::try_new(from - to, 1e-10)?;
            let centre: [f64; 3] = ((from + to) / 2.0).into();
            here = pose(centre, from_z(&along));
            let half = (from - to).norm() / 2.0;
            let across = given.first().copied().unwrap_or(f64::NAN);
            given = if matches!(kind, "box" | "ellipsoid") { vec![across, across, half] } else { vec![across, half] };
        }
        let shape = match (kind, given.as_slice()) {
            ("sphere", [r, ..]) => Shape::Sphere(*r),
            ("capsule", [r, h, ..]) => Shape::Capsule(*r, *h),
            ("cylinder", [r, h, ..]) => Shape::Cylinder(*r, *h),
            ("ellipsoid", [a, b, c, ..]) => Shape::Ellipsoid([*a, *b, *c]),
            ("box", [a, b, c, ..]) => Shape::Box([*a, *b, *c]),
            ("sphere" | "capsule" | "cylinder" | "ellipsoid" | "box", few) => {
                let place = size.map_or_else(|| span(node), |(a, _)| a.range_value());
                sheet.note(Problem::at(place, format!("a {kind} of {} sizes", few.len()), "expected more of them"));
                return None;
            }
            ("plane" | "hfield", _) => return None,
            ("mesh" | "sdf", _) => {
                sheet.refuse(
                    node,
                    "the mass of this body would come from a mesh",
                    "give its `inertial`, or set mass=\"0\" on the geom",
                );
                return None;
            }
            (other, _) => {
                let kinds = ["sphere", "capsule", "cylinder", "ellipsoid", "box", "plane", "mesh"];
                let shown: String = other.chars().take(40).collect();
                sheet.note(
                    Problem::at(span(node), format!("`{shown}` is not a type of geom"), "not one of the choices")
                        .suggest(&shown, kinds),
                );
                return None;
            }
        };
        if shape.volume().is_nan() || shape.volume() <= 0.0 {
            let place = size.map_or_else(|| span(node), |(a, _)| a.range_value());
            sheet.note(Problem::at(place, format!("a {kind} without volume"), "sizes are greater than zero"));
            return None;
        }
        if layers.word("shellinertia") == Some("true") {
            sheet.refuse(node, "`shellinertia` is not supported", "give the `inertial` of the body");
        }
        Some(shape.solid(mass.unwrap_or(density * shape.volume())).at(&here))
    }

    /// A site is a frame at which forces can act; it is placed when all bodies have their names.
    fn site(&mut self, node: El<'a>, body: Option<usize>, class: Option<&'a str>, outer: &Isometry3<f64>) {
        let (Some(body), Some(name)) = (body, node.attribute("name")) else { return };
        let Some(layers) = self.layers(node, class) else { return };
        let here = outer * pose(self.at(&layers), self.orientation(&layers));
        self.sites.push((body, name.to_string(), here));
    }
}

/// The smallest turn that brings z to a direction.
fn from_z(direction: &UnitVector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}
