//! Inverse dynamics by the recursive Newton-Euler algorithm (R. Featherstone, *Rigid Body Dynamics
//! Algorithms*, Springer 2008, ch. 5), written in world axes: speeds and accelerations go out along the
//! tree, forces come back.

use nalgebra::{DMatrix, Isometry3, Matrix3, Point3, Vector3};

use super::{Mechanism, Motion, Place};

/// Positions, speeds and accelerations of the joints, in their order \[rad, rad/s, rad/s²; m where they slide\].
#[derive(Debug, Clone, Copy)]
pub struct State<'a> {
    /// Positions, q.
    pub position: &'a [f64],
    /// Speeds, q̇.
    pub velocity: &'a [f64],
    /// Accelerations, q̈.
    pub acceleration: &'a [f64],
}

/// Force and moment that the surroundings put on a body at the origin of its frame, world axes.
#[derive(Debug, Clone, Copy)]
pub struct Wrench {
    /// Index of the body.
    pub body: usize,
    /// Force \[N\].
    pub force: Vector3<f64>,
    /// Moment \[N·m\].
    pub moment: Vector3<f64>,
}

/// How a body moves, world axes.
#[derive(Debug, Clone, Copy)]
pub struct Moving {
    /// Its frame in the world \[m\].
    pub pose: Isometry3<f64>,
    /// Its joint's axis; zero without a joint.
    pub axis: Vector3<f64>,
    /// Angular velocity \[rad/s\], ω.
    pub turning: Vector3<f64>,
    /// Angular acceleration \[rad/s²\], ω̇.
    pub spinning_up: Vector3<f64>,
    /// Velocity of its origin \[m/s\].
    pub velocity: Vector3<f64>,
    /// Acceleration of its origin less gravity \[m/s²\]: what a mass there feels.
    pub acceleration: Vector3<f64>,
}

impl Moving {
    /// Acceleration less gravity of a point at `r` from the origin, world axes \[m/s²\].
    pub fn acceleration_at(&self, r: &Vector3<f64>) -> Vector3<f64> {
        self.acceleration + self.spinning_up.cross(r) + self.turning.cross(&self.turning.cross(r))
    }
}

/// How every body moves: the outward half of the algorithm.
pub fn kinematics(mechanism: &Mechanism, state: State) -> Vec<Moving> {
    let world = Moving {
        pose: Isometry3::identity(),
        axis: Vector3::zeros(),
        turning: Vector3::zeros(),
        spinning_up: Vector3::zeros(),
        velocity: Vector3::zeros(),
        acceleration: -mechanism.gravity,
    };
    let mut moving: Vec<Moving> = Vec::with_capacity(mechanism.bodies.len());
    let mut next = 0;
    for body in &mechanism.bodies {
        let parent = body.parent.map_or(world, |p| moving[p]);
        let mut here = Moving { pose: parent.pose * body.placement, axis: Vector3::zeros(), ..parent };
        let (mut slide, mut slide_speed) = (Vector3::zeros(), Vector3::zeros());
        if let Some(joint) = &body.joint {
            let (q, qd, qdd) = (state.position[next], state.velocity[next], state.acceleration[next]);
            next += 1;
            let moved = q - joint.reference;
            let axis = here.pose.rotation * joint.axis.into_inner();
            here.axis = axis;
            match joint.motion {
                Motion::Turns => {
                    here.pose.rotation *= nalgebra::UnitQuaternion::from_axis_angle(&joint.axis, moved);
                    here.turning += axis * qd;
                    here.spinning_up += axis * qdd + parent.turning.cross(&(axis * qd));
                }
                Motion::Slides => {
                    here.pose.translation.vector += axis * moved;
                    slide_speed = axis * qd;
                    slide = axis * qdd + 2.0 * parent.turning.cross(&slide_speed);
                }
            }
        }
        let r = here.pose.translation.vector - parent.pose.translation.vector;
        here.velocity = parent.velocity + parent.turning.cross(&r) + slide_speed;
        here.acceleration = parent.acceleration_at(&r) + slide;
        moving.push(here);
    }
    moving
}

/// Torques \[N·m\] (forces \[N\] where a joint slides) that make the state, in the order of the joints:
/// `τ = M(q) q̈ + h(q, q̇) + g(q) − Jᵀ f`. Without friction, springs and rotors of the joints.
pub fn inverse_dynamics(mechanism: &Mechanism, state: State, wrenches: &[Wrench]) -> Vec<f64> {
    let moving = kinematics(mechanism, state);
    forces(mechanism, &moving, wrenches)
}

/// The inward half of the algorithm.
fn forces(mechanism: &Mechanism, moving: &[Moving], wrenches: &[Wrench]) -> Vec<f64> {
    // What each body asks of its joint: force, and moment about the body's origin.
    let mut asked: Vec<(Vector3<f64>, Vector3<f64>)> = mechanism
        .bodies
        .iter()
        .zip(moving)
        .map(|(body, moving)| {
            let (c, inertia) = in_world(body, moving);
            let force = moving.acceleration_at(&c) * body.inertia.mass;
            let spin = inertia * moving.spinning_up + moving.turning.cross(&(inertia * moving.turning));
            (force, spin + c.cross(&force))
        })
        .collect();
    for wrench in wrenches {
        asked[wrench.body].0 -= wrench.force;
        asked[wrench.body].1 -= wrench.moment;
    }
    let mut torques = Vec::new();
    for (b, body) in mechanism.bodies.iter().enumerate().rev() {
        let (force, moment) = asked[b];
        if let Some(joint) = &body.joint {
            torques.push(moving[b].axis.dot(if joint.motion == Motion::Turns { &moment } else { &force }));
        }
        if let Some(p) = body.parent {
            let r = moving[b].pose.translation.vector - moving[p].pose.translation.vector;
            asked[p].0 += force;
            asked[p].1 += moment + r.cross(&force);
        }
    }
    torques.reverse();
    torques
}

/// Centre of mass from the origin of the body, and inertia about it, in world axes.
fn in_world(body: &super::Body, moving: &Moving) -> (Vector3<f64>, Matrix3<f64>) {
    let turn = moving.pose.rotation.to_rotation_matrix();
    (turn * body.inertia.centre, turn * body.inertia.about_centre * turn.transpose())
}

/// What one kilogram at a place asks of the joints that carry it \[N·m/kg\], each joint by its number: the
/// torque of a point mass alone. Torques are linear in mass, so this is ∂τ/∂m exactly, at any mass.
pub fn per_mass(mechanism: &Mechanism, moving: &[Moving], place: Place) -> Vec<(usize, f64)> {
    let pose = &moving[place.body].pose;
    let point = pose * Point3::from(place.at);
    let force = moving[place.body].acceleration_at(&(pose.rotation * place.at));
    let mut on_the_way = Vec::new();
    let mut at = Some(place.body);
    while let Some(b) = at {
        if let Some(joint) = &mechanism.bodies[b].joint {
            let arm = point.coords - moving[b].pose.translation.vector;
            let asked = if joint.motion == Motion::Turns { arm.cross(&force) } else { force };
            on_the_way.push((b, moving[b].axis.dot(&asked)));
        }
        at = mechanism.bodies[b].parent;
    }
    let numbers = mechanism.moving();
    on_the_way.reverse();
    on_the_way.into_iter().filter_map(|(b, t)| Some((numbers.binary_search(&b).ok()?, t))).collect()
}

/// What a body's ten inertial parameters ask of the joints that carry it, each joint by its number: torques are linear in them
/// (C. G. Atkeson, C. H. An and J. M. Hollerbach, *Int. J. Robotics Research* 5(3), 1986). In order, in the body's axes: its mass
/// \[N·m/kg\], its three first moments \[N·m/(kg·m)\], and its inertia about the origin of its frame, xx, yy, zz, xy, xz, yz
/// \[N·m/(kg·m²)\]; N in place of N·m where a joint slides.
pub fn regressor(mechanism: &Mechanism, moving: &[Moving], body: usize) -> Vec<(usize, [f64; 10])> {
    let here = &moving[body];
    let origin = here.pose.translation.vector;
    let axes = [0, 1, 2].map(|axis| here.pose.rotation * Vector3::ith(axis, 1.0));
    let turned = |e: &Vector3<f64>| here.spinning_up.cross(e) + here.turning.cross(&here.turning.cross(e));
    // Moment of a unit of inertia along e eᵀ: H ω̇ + ω × H ω.
    let spun = |e: &Vector3<f64>, f: &Vector3<f64>| {
        e * f.dot(&here.spinning_up) + here.turning.cross(e) * f.dot(&here.turning)
    };
    // Force, and moment about the body's origin, of each of the ten.
    let mut asked = [(here.acceleration, Vector3::zeros()); 10];
    for (k, e) in axes.iter().enumerate() {
        asked[1 + k] = (turned(e), e.cross(&here.acceleration));
        asked[4 + k] = (Vector3::zeros(), spun(e, e));
    }
    for (k, (i, j)) in [(0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
        asked[7 + k] = (Vector3::zeros(), spun(&axes[i], &axes[j]) + spun(&axes[j], &axes[i]));
    }
    let on_the_way = std::iter::successors(Some(body), |b| mechanism.bodies[*b].parent);
    let numbers = mechanism.moving();
    let mut of_joints: Vec<(usize, [f64; 10])> = on_the_way
        .filter_map(|b| {
            let joint = mechanism.bodies[b].joint.as_ref()?;
            let arm = origin - moving[b].pose.translation.vector;
            let torque = |(force, moment): (Vector3<f64>, Vector3<f64>)| {
                let whole = if joint.motion == Motion::Turns { moment + arm.cross(&force) } else { force };
                moving[b].axis.dot(&whole)
            };
            Some((numbers.binary_search(&b).ok()?, asked.map(torque)))
        })
        .collect();
    of_joints.reverse();
    of_joints
}

/// The ten inertial parameters, as [`regressor`] orders them, of one kilogram at a point of a body \[m\].
pub fn point_mass(at: &Vector3<f64>) -> [f64; 10] {
    let [x, y, z] = <[f64; 3]>::from(*at);
    let square = |a: f64, b: f64| a * a + b * b;
    [1.0, x, y, z, square(y, z), square(x, z), square(x, y), -x * y, -x * z, -y * z]
}

/// Kinetic and potential energy of the bodies \[J\].
pub fn energy(mechanism: &Mechanism, position: &[f64], velocity: &[f64]) -> (f64, f64) {
    let zero = vec![0.0; position.len()];
    let moving = kinematics(mechanism, State { position, velocity, acceleration: &zero });
    let (mut kinetic, mut potential) = (0.0, 0.0);
    for (body, moving) in mechanism.bodies.iter().zip(&moving) {
        let (c, inertia) = in_world(body, moving);
        let speed = moving.velocity + moving.turning.cross(&c);
        kinetic += 0.5 * (body.inertia.mass * speed.norm_squared() + moving.turning.dot(&(inertia * moving.turning)));
        potential -= body.inertia.mass * mechanism.gravity.dot(&(moving.pose.translation.vector + c));
    }
    (kinetic, potential)
}

/// Joint-space mass matrix M(q) \[kg·m²\]: the torques of unit accelerations at rest, without gravity.
pub fn mass_matrix(mechanism: &Mechanism, position: &[f64]) -> DMatrix<f64> {
    let weightless = Mechanism { gravity: Vector3::zeros(), ..mechanism.clone() };
    let n = position.len();
    let zero = vec![0.0; n];
    let columns = (0..n).flat_map(|j| {
        let unit: Vec<f64> = (0..n).map(|i| if i == j { 1.0 } else { 0.0 }).collect();
        inverse_dynamics(&weightless, State { position, velocity: &zero, acceleration: &unit }, &[])
    });
    DMatrix::from_iterator(n, n, columns)
}
