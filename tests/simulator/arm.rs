//! A whole arm: six joints that turn, a description (URDF), logs of all of them at once.
//!
//! It shares no line with the library: torques follow from d'Alembert's principle, with accelerations and angular momenta from
//! differences of places in time, and not from a recursion over bodies.

use super::random::Random;
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Number of joints.
pub const JOINTS: usize = 6;
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.806_65);
/// Step of the differences in time [s].
const STEP: f64 = 2e-4;

/// A link with the joint before it.
#[derive(Debug, Clone)]
pub struct Link {
    pub name: &'static str,
    /// Where the joint is on the link before [m].
    pub at: Vector3<f64>,
    /// Its axis.
    pub axis: Vector3<f64>,
    pub mass: f64,
    pub centre: Vector3<f64>,
    /// Principal moments about the centre [kg m2].
    pub moments: Vector3<f64>,
}

/// A motor with its gear and its friction at the output.
#[derive(Debug, Clone, Copy)]
pub struct Drive {
    pub ratio: f64,
    /// N·m/A on the q axis.
    pub torque_constant: f64,
    /// kg m2.
    pub rotor: f64,
    /// N·m at the motor.
    pub coulomb: f64,
    /// N·m·s/rad at the motor.
    pub viscous: f64,
    /// Share of what the gear transmits that is lost.
    pub load_friction: f64,
    /// Times the declared torque constant.
    pub constant_error: f64,
}

/// The arm and how it is driven and read.
#[derive(Debug, Clone)]
pub struct Arm {
    pub seed: u64,
    pub links: Vec<Link>,
    pub drives: Vec<Drive>,
    /// Mass [kg] and place [m] on the last link of what it carries; what the bench file says of it.
    pub payload: (f64, Vector3<f64>),
    pub declared_payload: Option<(f64, Vector3<f64>)>,
    /// Masses of links are so many times what the description says.
    pub mass_error: [f64; JOINTS],
    /// Hz, s.
    pub rate: f64,
    pub duration: f64,
    /// Encoder step at the output [rad], noise of the current as a share of its size.
    pub encoder: f64,
    pub current_noise: f64,
    /// Joints that move; the others rest.
    pub moves: [bool; JOINTS],
}

impl Arm {
    /// An arm of about the size of a collaborative robot that carries 2 kg as declared, whose description is right.
    pub fn new(seed: u64) -> Arm {
        let mut random = Random::new(seed, "arm");
        let mut link = |name, at: [f64; 3], axis: [f64; 3], mass: f64, centre: [f64; 3]| {
            let size = 0.1 * mass * random.within(0.05, 0.15);
            Link {
                name,
                at: Vector3::from(at),
                axis: Vector3::from(axis),
                mass: mass * random.within(0.8, 1.25),
                centre: Vector3::from(centre),
                moments: Vector3::new(size, size * random.within(0.8, 1.0), size * random.within(0.5, 0.9)),
            }
        };
        let links = vec![
            link("shoulder", [0.0, 0.0, 0.16], [0.0, 0.0, 1.0], 3.8, [0.0, -0.02, 0.0]),
            link("upper_arm", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 8.4, [0.21, 0.0, 0.13]),
            link("forearm", [0.42, 0.0, 0.0], [0.0, 1.0, 0.0], 2.3, [0.19, 0.0, 0.04]),
            link("wrist_1", [0.39, 0.0, 0.0], [0.0, 1.0, 0.0], 1.2, [0.0, 0.1, 0.01]),
            link("wrist_2", [0.0, 0.11, 0.0], [0.0, 0.0, 1.0], 1.2, [0.0, 0.01, -0.05]),
            link("wrist_3", [0.0, 0.0, -0.1], [0.0, 1.0, 0.0], 0.4, [0.01, 0.05, 0.0]),
        ];
        let mut drive = |large: f64| Drive {
            ratio: 100.0,
            torque_constant: large * random.within(0.9, 1.1),
            rotor: 4e-5 * large / 0.12 * random.within(0.8, 1.2),
            coulomb: large * random.within(0.25, 0.5),
            viscous: 2e-3 * large * random.within(0.5, 1.0),
            load_friction: 0.0,
            constant_error: 1.0,
        };
        let drives = [0.12, 0.12, 0.12, 0.06, 0.06, 0.06].map(&mut drive).to_vec();
        let payload = (2.0, Vector3::new(0.0, 0.12, 0.03));
        Arm {
            seed,
            links,
            drives,
            payload,
            declared_payload: Some(payload),
            mass_error: [1.0; JOINTS],
            rate: 200.0,
            duration: 40.0,
            encoder: 2e-5,
            current_noise: 0.01,
            moves: [true; JOINTS],
        }
    }

    /// Angles at a time: three sines for each joint.
    fn angles(&self, log: usize) -> impl Fn(f64) -> Vec<f64> + use<> {
        let mut random = Random::new(self.seed, &format!("motion {log}"));
        let rest = [0.3, -0.7, 0.9, -0.4, 0.5, 0.2];
        let moves = self.moves;
        let sines: Vec<[(f64, f64, f64); 3]> = (0..JOINTS)
            .map(|_| {
                [(0.05, 0.12, 0.5), (0.15, 0.35, 0.35), (0.4, 0.7, 0.12)].map(|(low, high, size)| {
                    (TAU * random.within(low, high), size * random.within(0.7, 1.3), random.within(0.0, TAU))
                })
            })
            .collect();
        move |t| {
            (0..JOINTS)
                .map(|j| {
                    let sum: f64 = sines[j].iter().map(|(w, a, p)| a * (w * t + p).sin()).sum();
                    rest[j] + if moves[j] { sum } else { 0.0 }
                })
                .collect()
        }
    }

    /// The frames of the links at angles.
    fn frames(&self, angles: &[f64]) -> Vec<Isometry3<f64>> {
        let mut frames = Vec::new();
        let mut pose = Isometry3::identity();
        for (link, q) in self.links.iter().zip(angles) {
            let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(link.axis), *q);
            pose *= Isometry3::from_parts(Translation3::from(link.at), turn);
            frames.push(pose);
        }
        frames
    }

    /// Torques of the joints at a time, with the true masses and payload.
    fn torques(&self, angles: &dyn Fn(f64) -> Vec<f64>, t: f64) -> Vec<f64> {
        let frames: Vec<Vec<Isometry3<f64>>> =
            (-2..=2).map(|k| self.frames(&angles(t + f64::from(k) * STEP))).collect();
        let mut torques = vec![0.0; JOINTS];
        for (b, link) in self.links.iter().enumerate() {
            let mass = link.mass * self.mass_error[b];
            let mut points = vec![(mass, link.centre)];
            if b == JOINTS - 1 {
                points.push((self.payload.0, self.payload.1));
            }
            for (mass, place) in points {
                let at = |k: usize| (frames[k][b] * Point3::from(place)).coords;
                let acceleration = (at(3) - 2.0 * at(2) + at(1)) / (STEP * STEP);
                let force = mass * (acceleration - GRAVITY);
                for (j, torque) in torques.iter_mut().enumerate().take(b + 1) {
                    let arm = at(2) - frames[2][j].translation.vector;
                    *torque += (frames[2][j].rotation * self.links[j].axis).dot(&arm.cross(&force));
                }
            }
            // Angular momentum about the centre at half steps before and after.
            let momentum = |k: usize| {
                let (before, after) = (frames[k - 1][b].rotation, frames[k + 1][b].rotation);
                let speed = (after * before.inverse()).scaled_axis() / (2.0 * STEP);
                let turn: Matrix3<f64> = frames[k][b].rotation.to_rotation_matrix().into();
                turn * Matrix3::from_diagonal(&(link.moments * self.mass_error[b])) * turn.transpose() * speed
            };
            let moment = (momentum(3) - momentum(1)) / (2.0 * STEP);
            for (j, torque) in torques.iter_mut().enumerate().take(b + 1) {
                *torque += (frames[2][j].rotation * self.links[j].axis).dot(&moment);
            }
        }
        torques
    }

    /// The description, with the masses that it says.
    pub fn urdf(&self) -> String {
        let mut out = String::from("<robot name=\"arm\">\n<link name=\"base\"/>\n");
        let text = |v: &Vector3<f64>| format!("{} {} {}", v.x, v.y, v.z);
        for (k, link) in self.links.iter().enumerate() {
            let parent = if k == 0 { "base" } else { self.links[k - 1].name };
            let _ = writeln!(
                out,
                "<link name=\"{name}\"><inertial><origin xyz=\"{centre}\"/><mass value=\"{mass}\"/>\
                 <inertia ixx=\"{x}\" iyy=\"{y}\" izz=\"{z}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n\
                 <joint name=\"{name}_joint\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{name}\"/>\
                 <origin xyz=\"{at}\"/><axis xyz=\"{axis}\"/><limit lower=\"-6\" upper=\"6\" effort=\"300\" velocity=\"6\"/></joint>",
                name = link.name,
                centre = text(&link.centre),
                mass = link.mass,
                x = link.moments.x,
                y = link.moments.y,
                z = link.moments.z,
                at = text(&link.at),
                axis = text(&link.axis),
            );
        }
        out.push_str("</robot>\n");
        out
    }

    /// Writes description, catalogue, logs (the last held out) and the bench file, and says where that is.
    pub fn write(&self, folder: &Path, logs: usize) -> PathBuf {
        fs::write(folder.join("arm.urdf"), self.urdf()).expect("the description can be written");
        let mut catalog = String::from(
            "id,manufacturer,model,construction,commutation,winding,terminals,current,resistance [ohm],\
             torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],continuous_torque [N*m],peak_torque [N*m],source,source_kind\n",
        );
        let mut bench = String::from(
            "name = \"arm\"\nkind = \"free\"\ncatalog = [\"motors.csv\"]\n\
             mechanism = { model = \"arm.urdf\"",
        );
        if let Some((mass, at)) = self.declared_payload {
            let _ = write!(
                bench,
                ", payload = {{ link = \"wrist_3\", mass = \"{mass} kg\", at = [\"{} m\", \"{} m\", \"{} m\"] }}",
                at.x, at.y, at.z
            );
        }
        bench.push_str(
            " }\n[columns]\ntime = { name = \"t\", unit = \"s\" }\n\
             position = { name = \"q_{joint}\", unit = \"rad\", side = \"output\" }\n\
             current = { name = \"i_{joint}\", unit = \"A\", convention = \"q_axis\" }\n",
        );
        for (link, drive) in self.links.iter().zip(&self.drives) {
            let Drive { ratio, torque_constant, rotor, .. } = drive;
            let name = link.name;
            let _ = writeln!(
                catalog,
                "m-{name},the test suite,simulated,frameless,brushless,wye,winding,q_axis,0.3,{torque_constant},{rotor},0.5,1,3,\
                 simulated,measured"
            );
            let _ = writeln!(
                bench,
                "[[joint]]\nname = \"{name}\"\nmechanism_joint = \"{name}_joint\"\n\
                 actuator = {{ motor = \"m-{name}\", ratio = {ratio} }}"
            );
        }
        fs::write(folder.join("motors.csv"), catalog).expect("the catalogue can be written");
        for log in 0..logs {
            let file = format!("run{}.csv", log + 1);
            fs::write(folder.join(&file), self.log(log)).expect("a log can be written");
            let held = if log + 1 == logs && logs > 1 { "held_out" } else { "fit" };
            let _ = writeln!(bench, "[[log]]\nfile = \"{file}\"\nuse = \"{held}\"");
        }
        let path = folder.join("arm.toml");
        fs::write(&path, bench).expect("the bench file can be written");
        path
    }

    fn log(&self, log: usize) -> String {
        let angles = self.angles(log);
        let mut random = Random::new(self.seed, &format!("instruments {log}"));
        let count = (self.rate * self.duration) as usize;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for k in 0..count {
            let t = k as f64 / self.rate;
            let (before, now, after) = (angles(t - STEP), angles(t), angles(t + STEP));
            let loads = self.torques(&angles, t);
            let mut row = vec![t];
            row.extend(now.iter().map(|q| (q / self.encoder).round() * self.encoder));
            for j in 0..JOINTS {
                let drive = &self.drives[j];
                let speed = drive.ratio * (after[j] - before[j]) / (2.0 * STEP);
                let acceleration = drive.ratio * (after[j] - 2.0 * now[j] + before[j]) / (STEP * STEP);
                let carried = loads[j] / drive.ratio;
                // A joint that rests is held by its drive.
                let turns = if self.moves[j] { (speed / 0.05).clamp(-1.0, 1.0) } else { 0.0 };
                let torque = carried
                    + drive.rotor * acceleration
                    + (drive.coulomb + drive.load_friction * carried.abs()) * turns
                    + drive.viscous * speed;
                row.push(torque / (drive.torque_constant * drive.constant_error));
            }
            rows.push(row);
        }
        for j in 1 + JOINTS..1 + 2 * JOINTS {
            let size = (rows.iter().map(|r| r[j] * r[j]).sum::<f64>() / rows.len() as f64).sqrt();
            rows.iter_mut().for_each(|r| r[j] += self.current_noise * size * random.normal());
        }
        let names = |letter: char| self.links.iter().map(move |l| format!("{letter}_{}_joint", l.name));
        let header: Vec<String> = std::iter::once("t".to_string()).chain(names('q')).chain(names('i')).collect();
        let mut text = header.join(",");
        for row in rows {
            text.push('\n');
            text.push_str(&row.iter().map(|v| format!("{v:.7}")).collect::<Vec<_>>().join(","));
        }
        text.push('\n');
        text
    }
}
