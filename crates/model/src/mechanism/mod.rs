//! The robot as a tree of rigid bodies, and the joint torques that a trajectory takes.
//!
//! The one idea of this room: a description (URDF or MJCF) becomes a list of bodies, parents before
//! children, each hung on its parent by at most one joint; one recursive Newton-Euler pass over that list
//! ([`dynamics`]) gives the torques, and because it is linear in mass it also says what a kilogram of
//! actuator anywhere on the robot costs every joint that carries it ([`torques`]). Motors are not part of
//! this room: their rotors, friction and gears come with the actuator.
//!
//! There are Rust crates for rigid bodies; none fitted when this was written: `featherstone` 0.1 and
//! `rapier3d` compute in single precision, `dynamics-rs` 0.0.3, `phyz-rigid` 0.1 and `nabled-dynamics` 0.0.9
//! are first releases, `k` 0.32 has kinematics alone, and `urdf-rs` 0.10 does not say where in the file a
//! mistake is. The pass is forty lines.

pub mod described;
pub mod dynamics;
mod geom;
mod mjcf;
pub mod stated;
pub mod torques;
pub mod trajectory;
mod urdf;
mod xml;

use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, UnitVector3, Vector3};

use crate::input::kind::{self, FileKind};
use crate::input::{InputError, Problem, Source};
pub use xml::document;

/// A tree of rigid bodies on a base that does not move.
#[derive(Debug, Clone)]
pub struct Mechanism {
    /// Name of the model.
    pub name: String,
    /// The bodies, parents before children.
    pub bodies: Vec<Body>,
    /// Gravity \[m/s²\], world axes.
    pub gravity: Vector3<f64>,
    /// What of the description was left aside, for people.
    pub notes: Vec<String>,
}

/// A rigid body, or only a frame.
#[derive(Debug, Clone)]
pub struct Body {
    /// Its name: the link, body or site; `None` between two joints of one MJCF body.
    pub name: Option<String>,
    /// The body that it hangs on; `None` for what stands in the world.
    pub parent: Option<usize>,
    /// Where its frame is in the parent's frame while the joint is at zero \[m\].
    pub placement: Isometry3<f64>,
    /// How it moves against its parent; `None` where it is fixed to it.
    pub joint: Option<Joint>,
    /// Its mass, in its own frame.
    pub inertia: Inertia,
}

/// What a joint does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// It turns about its axis (revolute, continuous, hinge).
    Turns,
    /// It moves along its axis (prismatic, slide).
    Slides,
}

/// A joint with one degree of freedom. Angles \[rad\] and torques \[N·m\] where it turns, lengths \[m\] and
/// forces \[N\] where it slides.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Whether it turns or slides.
    pub motion: Motion,
    /// Its axis in the body's frame.
    pub axis: UnitVector3<f64>,
    /// The position at which the body is at its placement (`ref` of MJCF).
    pub reference: f64,
    /// Viscous friction of the joint \[N·m·s/rad\].
    pub damping: f64,
    /// Coulomb friction of the joint \[N·m\].
    pub friction: f64,
    /// Stiffness of a spring in the joint \[N·m/rad\].
    pub stiffness: f64,
    /// Where that spring is at rest \[rad\].
    pub spring_reference: f64,
    /// Rotor inertia at the output that the description assumes \[kg·m²\].
    pub armature: f64,
    /// Smallest and largest position that the description allows \[rad\].
    pub range: Option<[f64; 2]>,
    /// Largest torque that the description allows \[N·m\].
    pub effort: Option<f64>,
    /// Largest speed that the description allows \[rad/s\].
    pub speed: Option<f64>,
}

impl Joint {
    fn new(name: String, motion: Motion, axis: UnitVector3<f64>) -> Joint {
        Joint {
            name,
            motion,
            axis,
            reference: 0.0,
            damping: 0.0,
            friction: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            armature: 0.0,
            range: None,
            effort: None,
            speed: None,
        }
    }

    /// Unit of its position.
    pub fn position_unit(&self) -> &'static str {
        if self.motion == Motion::Turns { "rad" } else { "m" }
    }

    /// Unit of what drives it.
    pub fn effort_unit(&self) -> &'static str {
        if self.motion == Motion::Turns { "N*m" } else { "N" }
    }
}

/// Mass, centre of mass and inertia about it, in the frame of the body.
#[derive(Debug, Clone, Copy)]
pub struct Inertia {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass \[kg·m²\].
    pub about_centre: Matrix3<f64>,
}

impl Inertia {
    /// No mass.
    pub fn none() -> Inertia {
        Inertia { mass: 0.0, centre: Vector3::zeros(), about_centre: Matrix3::zeros() }
    }

    /// A point.
    pub fn point(mass: f64, at: Vector3<f64>) -> Inertia {
        Inertia { mass, centre: at, about_centre: Matrix3::zeros() }
    }

    /// Both together, about their common centre of mass (parallel axes).
    pub fn with(&self, other: &Inertia) -> Inertia {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Inertia { about_centre: self.about_centre + other.about_centre, ..*self };
        }
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let shifted = |part: &Inertia| {
            let d = part.centre - centre;
            part.about_centre + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * part.mass
        };
        Inertia { mass, centre, about_centre: shifted(self) + shifted(other) }
    }

    /// The same in a frame in which this one's frame is at `pose`.
    fn at(&self, pose: &Isometry3<f64>) -> Inertia {
        let turn = pose.rotation.to_rotation_matrix();
        Inertia {
            mass: self.mass,
            centre: pose * nalgebra::Point3::from(self.centre) - nalgebra::Point3::origin(),
            about_centre: turn * self.about_centre * turn.transpose(),
        }
    }

    /// What no rigid body can have: a principal moment below zero, or one larger than the other two
    /// together. Numbers with three digits may miss the second by their rounding.
    fn impossible(&self) -> Option<String> {
        let mut moments = self.about_centre.symmetric_eigenvalues();
        moments.as_mut_slice().sort_by(f64::total_cmp);
        let [small, middle, large] = [moments[0], moments[1], moments[2]];
        let shown = [small, middle, large].map(crate::words::number).join(", ");
        if small < -1e-9 * large.abs().max(small.abs()) {
            return Some(format!("a principal moment is not positive: {shown} kg*m^2"));
        }
        let rounding = 2e-3 * large;
        (large > small + middle + rounding)
            .then(|| format!("the largest principal moment is more than the other two together: {shown} kg*m^2"))
    }
}

/// A point mass carried by the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Payload {
    /// The link, body or site that carries it.
    pub link: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Where, in the link's frame \[m\].
    pub at: [f64; 3],
}

impl Mechanism {
    /// Reads a description (`-` is standard input): MJCF where the root element is `mujoco`, URDF where it is `robot`.
    ///
    /// # Errors
    /// All mistakes of the file, and everything in it that would change the motion and is not modelled.
    pub fn read(path: &Path) -> Result<Mechanism, InputError> {
        Mechanism::read_source(&Source::argument(path)?)
    }

    /// As [`Mechanism::read`], from a source at hand.
    ///
    /// # Errors
    /// As [`Mechanism::read`].
    pub fn read_source(source: &Arc<Source>) -> Result<Mechanism, InputError> {
        xml::Sheet::read(source, |sheet, root| match root.tag_name().name() {
            "robot" => urdf::read(sheet, root),
            "mujoco" => mjcf::read(sheet, root),
            other => {
                sheet.note(
                    Problem::at(xml::span(root), format!("`{other}` is not the description of a robot"), "the root")
                        .help("expected `robot` (URDF) or `mujoco` (MJCF)"),
                );
                None
            }
        })
        .map_err(|error| kind::instead(error, &[FileKind::Description, FileKind::Xml]))
    }

    /// Indices of the bodies that have a joint, in their order. A joint's number is its place in this list.
    pub fn moving(&self) -> Vec<usize> {
        (0..self.bodies.len()).filter(|b| self.bodies[*b].joint.is_some()).collect()
    }

    /// The joints in their order.
    pub fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.bodies.iter().filter_map(|b| b.joint.as_ref())
    }

    /// Number of a joint.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints().position(|j| j.name == name)
    }

    /// Index of the body with this name.
    pub fn body(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name.as_deref() == Some(name))
    }

    /// Names of the links, bodies and sites.
    pub fn frames(&self) -> impl Iterator<Item = &str> + Clone {
        self.bodies.iter().filter_map(|b| b.name.as_deref())
    }

    /// Mass of all bodies together \[kg\].
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.inertia.mass).sum()
    }

    /// Hangs a payload on; false where there is no such link.
    #[must_use]
    pub fn carry(&mut self, payload: &Payload) -> bool {
        let Some(body) = self.body(&payload.link) else { return false };
        let point = Inertia::point(payload.mass, Vector3::from(payload.at));
        self.bodies[body].inertia = self.bodies[body].inertia.with(&point);
        true
    }

    /// Whether a joint moves a body, by its index.
    pub fn moves(&self, joint: usize, body: usize) -> bool {
        let Some(mover) = self.moving().get(joint).copied() else { return false };
        std::iter::successors(Some(body), |b| self.bodies[*b].parent).any(|b| b == mover)
    }

    /// Where the actuator of a joint sits unless told otherwise: on the body that the joint hangs on, at the
    /// joint. `None` where that is the world, which carries it for nothing.
    pub fn actuator_place(&self, joint: usize) -> Option<Place> {
        let mut body = *self.moving().get(joint)?;
        // Two joints of one MJCF body have a frame without mass between them: its parent carries as well.
        let mut at = self.bodies[body].placement.translation.vector;
        loop {
            let parent = self.bodies[body].parent?;
            if self.bodies[parent].name.is_some() || self.bodies[parent].joint.is_some() {
                return Some(Place { body: parent, at });
            }
            body = parent;
            at = (self.bodies[body].placement * nalgebra::Point3::from(at)).coords;
        }
    }

    /// Notes on joints that move nothing: their torque is zero whatever the trajectory.
    fn note_the_massless(&mut self) {
        let mut carried: Vec<bool> =
            self.bodies.iter().map(|b| b.inertia.mass > 0.0 || b.inertia.about_centre.trace() > 0.0).collect();
        for b in (0..self.bodies.len()).rev() {
            if let (true, Some(parent)) = (carried[b], self.bodies[b].parent) {
                carried[parent] = true;
            }
        }
        let idle: Vec<&str> = self
            .bodies
            .iter()
            .zip(&carried)
            .filter(|(_, carried)| !**carried)
            .filter_map(|(b, _)| Some(b.joint.as_ref()?.name.as_str()))
            .collect();
        if !idle.is_empty() {
            let note = format!("nothing with mass hangs on {}: torque zero", idle.join(", "));
            self.notes.push(note);
        }
    }
}

/// A point of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the body.
    pub body: usize,
    /// The point in its frame \[m\].
    pub at: Vector3<f64>,
}

/// A pose from where and how.
fn pose(at: [f64; 3], turned: UnitQuaternion<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(Vector3::from(at)), turned)
}
