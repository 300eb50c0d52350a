//! What a body weighs: its inertial, or the shapes that it is made of.

use nalgebra::{Matrix3, UnitVector3, Vector3};

use super::place::from_z;
use super::words::*;
use super::{FromGeom, Layers, Reader};
use crate::input::{Problem, Range};
use crate::mechanism::geom::Shape;
use crate::mechanism::xml::{El, children, span};
use crate::mechanism::{Inertia, pose};

impl<'a> Reader<'a, '_> {
    pub(super) fn inertial(&self, node: El<'a>) -> Inertia {
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
                sheet.note(Problem::at(a.range(), "`fullinertia` next to `diaginertia`", "expected one of them"));
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
    pub(super) fn geom(&self, node: El<'a>, class: Option<&'a str>) -> Option<Inertia> {
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
}
