//! Mass and inertia of MJCF's primitive shapes from their sizes and density.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::Inertia;

/// A solid shape about its own centre, sizes as MJCF gives them \[m\].
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    /// Radius.
    Sphere(f64),
    /// Radius, half of the length of the straight part; along z.
    Capsule(f64, f64),
    /// Radius, half of the length; along z.
    Cylinder(f64, f64),
    /// Half axes.
    Ellipsoid([f64; 3]),
    /// Half edges.
    Box([f64; 3]),
}

impl Shape {
    /// Volume \[m³\].
    pub fn volume(self) -> f64 {
        let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        match self {
            Shape::Sphere(r) => ball(r),
            Shape::Capsule(r, h) => ball(r) + 2.0 * PI * r * r * h,
            Shape::Cylinder(r, h) => 2.0 * PI * r * r * h,
            Shape::Ellipsoid([a, b, c]) => 4.0 / 3.0 * PI * a * b * c,
            Shape::Box([a, b, c]) => 8.0 * a * b * c,
        }
    }

    /// The solid shape with a mass \[kg\].
    pub fn solid(self, mass: f64) -> Inertia {
        let sums = |share: f64, [a, b, c]: [f64; 3]| {
            Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (mass * share)
        };
        let moments = match self {
            Shape::Sphere(r) => sums(0.2, [r; 3]),
            Shape::Ellipsoid(axes) => sums(0.2, axes),
            Shape::Box(edges) => sums(1.0 / 3.0, edges),
            Shape::Cylinder(r, h) => cylinder(mass, r, h),
            Shape::Capsule(r, h) => {
                let straight = mass * Shape::Cylinder(r, h).volume() / self.volume();
                let ends = mass - straight;
                // Two half balls, their flat sides h from the centre, their centres of mass 3r/8 further out.
                let along = 0.4 * ends * r * r;
                let across = along + ends * (h * h + 0.75 * r * h);
                cylinder(straight, r, h) + Vector3::new(across, across, along)
            }
        };
        Inertia { mass, centre: Vector3::zeros(), about_centre: Matrix3::from_diagonal(&moments) }
    }
}

fn cylinder(mass: f64, r: f64, h: f64) -> Vector3<f64> {
    let across = mass * (r * r / 4.0 + h * h / 3.0);
    Vector3::new(across, across, mass * r * r / 2.0)
}
