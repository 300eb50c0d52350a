//! Where a part is, and how it is turned.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, UnitVector3, Vector3};
use roxmltree::Attribute;

use super::words::*;
use super::{Layers, Reader};
use crate::input::Problem;

impl<'a> Reader<'a, '_> {
    /// Which way an element is turned: by the first layer that says so.
    pub(super) fn orientation(&self, layers: &Layers<'a>) -> UnitQuaternion<f64> {
        let said = layers.0.iter().find(|node| ORIENTATION.iter().any(|name| node.has_attribute(*name)));
        let Some(node) = said else { return UnitQuaternion::identity() };
        let given: Vec<Attribute> = ORIENTATION.iter().filter_map(|name| node.attribute_node(*name)).collect();
        if let [_, second, ..] = given.as_slice() {
            self.sheet.note(Problem::at(second.range(), "two orientations of one element", "expected one of them"));
        }
        self.turned(given[0]).unwrap_or_default()
    }

    pub(super) fn turned(&self, a: Attribute) -> Option<UnitQuaternion<f64>> {
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

    pub(super) fn at(&self, layers: &Layers<'a>) -> [f64; 3] {
        layers.get("pos").and_then(|a| self.sheet.numbers::<3>(a)).unwrap_or([0.0; 3])
    }
}

/// The smallest turn that brings z to a direction.
pub(super) fn from_z(direction: &UnitVector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}
