//! URDF (Unified Robot Description Format, ROS): links and joints by name, put in order as a tree.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::xml::{El, Sheet, children, span};
use super::{Body, Inertia, Joint, Mechanism, Motion, pose};
use crate::input::{Problem, Range};

/// Gravity where a description says none, as URDF never does \[m/s²\].
const GRAVITY: f64 = 9.81;

/// Elements of a robot; the first two are read, the others do not touch the rigid bodies.
const OF_ROBOT: &[&str] = &[
    "link",
    "joint",
    "material",
    "transmission",
    "gazebo",
    "sensor",
    "ros2_control",
    "mujoco",
    "group",
    "group_state",
    "disable_collisions",
    "end_effector",
];
const OF_LINK: &[&str] = &["inertial", "visual", "collision", "sensor", "material", "contact"];
const OF_JOINT: &[&str] =
    &["origin", "parent", "child", "axis", "dynamics", "limit", "mimic", "calibration", "safety_controller"];

struct Hanging<'a> {
    node: El<'a>,
    parent: &'a str,
    child: &'a str,
    placement: Isometry3<f64>,
    joint: Option<Joint>,
}

pub(super) fn read(sheet: &Sheet, root: El) -> Option<Mechanism> {
    let (mut links, mut hangings) = (Vec::new(), Vec::new());
    let (mut link_names, mut joint_names) = (HashSet::new(), HashSet::new());
    for node in children(root) {
        match node.tag_name().name() {
            "link" => {
                let Some(name) = sheet.required(node, "name") else { continue };
                sheet.unique(node, "links", name, &mut link_names);
                links.push((node, name, read_link(sheet, node)));
            }
            "joint" => {
                let Some(name) = sheet.required(node, "name") else { continue };
                sheet.unique(node, "joints", name, &mut joint_names);
                hangings.extend(read_joint(sheet, node, name));
            }
            "gazebo" => refuse_loops(sheet, node),
            other => leave_aside(sheet, node, other, OF_ROBOT),
        }
    }
    if sheet.has_problems() {
        return None;
    }
    let bodies = tree(sheet, root, &links, hangings)?;
    let name = root.attribute("name").unwrap_or("robot").to_string();
    Some(Mechanism { name, bodies, gravity: Vector3::new(0.0, 0.0, -GRAVITY), notes: Vec::new() })
}

/// URDF may be extended by anyone: what resembles a known name is a mistake, the rest is counted.
fn leave_aside(sheet: &Sheet, node: El, name: &str, known: &[&str]) {
    if known.contains(&name) || node.tag_name().namespace().is_some() {
        return;
    }
    match crate::words::nearest(name, known.iter().copied()) {
        Some(_) => sheet.unknown(node, known),
        None => sheet.skip(node),
    }
}

/// Simulator extensions are passed over, but a joint among them closes a loop.
fn refuse_loops(sheet: &Sheet, node: El) {
    for joint in node.descendants().filter(|n| n.has_tag_name("joint") && n.has_attribute("type")) {
        sheet.refuse(
            joint,
            "a joint in `gazebo` closes a loop of the mechanism",
            "inverse dynamics needs a tree; cut the loop and give its force as an external force",
        );
    }
}

fn read_link(sheet: &Sheet, link: El) -> Inertia {
    let mut inertia = Inertia::none();
    for node in children(link) {
        match node.tag_name().name() {
            "inertial" => inertia = read_inertial(sheet, node),
            other => leave_aside(sheet, node, other, OF_LINK),
        }
    }
    inertia
}

fn read_inertial(sheet: &Sheet, inertial: El) -> Inertia {
    const PARTS: &[&str] = &["origin", "mass", "inertia"];
    let (mut at, mut mass, mut moments) = (Isometry3::identity(), None, None);
    for node in children(inertial) {
        match node.tag_name().name() {
            "origin" => at = read_origin(sheet, node),
            "mass" => {
                sheet.only(node, &["value"]);
                if sheet.required(node, "value").is_some() {
                    mass = node.attribute_node("value").and_then(|a| sheet.number(a, Range::NonNegative));
                }
            }
            "inertia" => moments = Some((node, read_moments(sheet, node))),
            _ => sheet.unknown(node, PARTS),
        }
    }
    if mass.is_none() && !children(inertial).any(|n| n.has_tag_name("mass")) {
        sheet.note(Problem::at(span(inertial), "`inertial` has no `mass`", "expected <mass value=\"…\"/>"));
    }
    let moments = moments.and_then(|(node, moments)| Some((node, moments?)));
    let about_centre = moments.map_or_else(Matrix3::zeros, |(_, m)| m);
    let inertia = Inertia { mass: mass.unwrap_or(0.0), centre: Vector3::zeros(), about_centre };
    if let (Some((node, _)), Some(what)) = (moments, inertia.impossible()) {
        let problem = Problem::at(span(node), "no rigid body has this inertia", what);
        sheet.note(problem.help("check units (kg*m^2), signs, and that it is about the centre of mass"));
    }
    inertia.at(&at)
}

fn read_moments(sheet: &Sheet, node: El) -> Option<Matrix3<f64>> {
    const NAMES: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
    sheet.only(node, &NAMES);
    let mut moments = [0.0; 6];
    let mut complete = true;
    for (value, name) in moments.iter_mut().zip(NAMES) {
        let number =
            sheet.required(node, name).and(node.attribute_node(name)).and_then(|a| sheet.number(a, Range::Any));
        complete &= number.is_some();
        *value = number.unwrap_or(0.0);
    }
    let [ixx, ixy, ixz, iyy, iyz, izz] = moments;
    complete.then(|| Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz))
}

/// Fixed axes x, y, z: roll, pitch, yaw.
fn read_origin(sheet: &Sheet, node: El) -> Isometry3<f64> {
    sheet.only(node, &["xyz", "rpy"]);
    let triple = |name| node.attribute_node(name).and_then(|a| sheet.numbers::<3>(a)).unwrap_or([0.0; 3]);
    let [roll, pitch, yaw] = triple("rpy");
    pose(triple("xyz"), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

fn read_joint<'a>(sheet: &Sheet, joint: El<'a>, name: &str) -> Option<Hanging<'a>> {
    sheet.only(joint, &["name", "type"]);
    let kind = sheet.required(joint, "type")?;
    let place = joint.attribute_node("type").map_or_else(|| span(joint), |a| a.range_value());
    let motion = match kind {
        "revolute" | "continuous" => Some(Motion::Turns),
        "prismatic" => Some(Motion::Slides),
        "fixed" => None,
        "floating" | "planar" | "spherical" => {
            sheet.note(
                Problem::at(
                    place,
                    format!("joint `{name}` is {kind}: it has more than one degree of freedom"),
                    "not supported",
                )
                .help("make a moving base fixed; write a joint with several axes as several joints"),
            );
            return None;
        }
        other => {
            let kinds = ["revolute", "continuous", "prismatic", "fixed"];
            let shown: String = other.chars().take(40).collect();
            sheet.note(
                Problem::at(place, format!("`{shown}` is not a type of joint"), "not one of the choices")
                    .suggest(&shown, kinds),
            );
            return None;
        }
    };
    let mut axis = Some(Vector3::x_axis());
    let mut made = motion.map(|motion| Joint::new(name.to_string(), motion, Vector3::x_axis()));
    let (mut parent, mut child, mut placement) = (None, None, Isometry3::identity());
    for node in children(joint) {
        let number = |key: &str, range| node.attribute_node(key).and_then(|a| sheet.number(a, range));
        match node.tag_name().name() {
            "origin" => placement = read_origin(sheet, node),
            "parent" => parent = sheet.required(node, "link"),
            "child" => child = sheet.required(node, "link"),
            "axis" => {
                sheet.only(node, &["xyz"]);
                // A fixed joint may have any axis, also none.
                if let (Some(attribute), true) = (node.attribute_node("xyz"), made.is_some()) {
                    axis = sheet.direction(attribute);
                }
            }
            "dynamics" => {
                sheet.only(node, &["damping", "friction", "spring_reference", "spring_stiffness"]);
                if let Some(joint) = &mut made {
                    joint.damping = number("damping", Range::NonNegative).unwrap_or(0.0);
                    joint.friction = number("friction", Range::NonNegative).unwrap_or(0.0);
                    joint.stiffness = number("spring_stiffness", Range::NonNegative).unwrap_or(0.0);
                    joint.spring_reference = number("spring_reference", Range::Any).unwrap_or(0.0);
                }
            }
            "limit" => {
                sheet.only(node, &["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"]);
                if let Some(joint) = &mut made {
                    let positive = |value: Option<f64>| value.filter(|v| *v > 0.0);
                    joint.effort = positive(number("effort", Range::Any));
                    joint.speed = positive(number("velocity", Range::Any));
                    let ends = (number("lower", Range::Any), number("upper", Range::Any));
                    if let ((Some(low), Some(high)), true) = (ends, kind != "continuous") {
                        joint.range = Some([low, high]).filter(|_| low < high);
                    }
                }
            }
            "mimic" => sheet.refuse(
                node,
                &format!("joint `{name}` mimics another: one actuator moves both"),
                &format!(
                    "remove `mimic` and give each joint its column in the trajectory; one actuator then gives the torque of the other joint \
                     and {0} times that of this one. Where each has an actuator, [[coupling]] of the requirement says how they go \
                     together: matrix = [[1, 0], [{0}, 1]]",
                    node.attribute("multiplier").unwrap_or("1")
                ),
            ),
            "calibration" | "safety_controller" => {}
            other => leave_aside(sheet, node, other, OF_JOINT),
        }
    }
    for (found, element) in [(parent, "parent"), (child, "child")] {
        if found.is_none() && !children(joint).any(|n| n.has_tag_name(element)) {
            let message = format!("joint `{name}` has no `{element}`");
            sheet.note(Problem::at(span(joint), message, format!("expected <{element} link=\"…\"/>")));
        }
    }
    if let Some(joint) = &mut made {
        joint.axis = axis?;
    }
    Some(Hanging { node: joint, parent: parent?, child: child?, placement, joint: made })
}

/// Puts the links in order, parents first, each with the joint that it hangs on.
fn tree(sheet: &Sheet, root: El, links: &[(El, &str, Inertia)], hangings: Vec<Hanging>) -> Option<Vec<Body>> {
    let index: HashMap<&str, usize> = links.iter().enumerate().map(|(i, (_, name, _))| (*name, i)).collect();
    let mut upward: Vec<Option<usize>> = vec![None; links.len()];
    let mut downward: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (h, hanging) in hangings.iter().enumerate() {
        for (name, element) in [(hanging.parent, "parent"), (hanging.child, "child")] {
            if !index.contains_key(name) {
                let node = children(hanging.node).find(|n| n.has_tag_name(element));
                let place =
                    node.and_then(|n| n.attribute_node("link")).map_or_else(|| span(hanging.node), |a| a.range_value());
                let shown: String = name.chars().take(60).collect();
                sheet.note(
                    Problem::at(place, format!("there is no link `{shown}`"), "named here")
                        .suggest(&shown, links.iter().map(|(_, n, _)| *n)),
                );
            }
        }
        let (Some(parent), Some(child)) = (index.get(hanging.parent), index.get(hanging.child)) else { continue };
        downward[*parent].push(h);
        if upward[*child].replace(h).is_some() {
            sheet.refuse(
                hanging.node,
                &format!("link `{}` hangs on two joints: the mechanism has a closed loop", hanging.child),
                "inverse dynamics needs a tree; cut the loop and give its force as an external force",
            );
        }
    }
    if sheet.has_problems() {
        return None;
    }
    let roots: Vec<usize> = (0..links.len()).filter(|l| upward[*l].is_none()).collect();
    let [base] = roots.as_slice() else {
        let what = if links.is_empty() {
            "the robot has no link".to_string()
        } else if roots.is_empty() {
            "every link hangs on another: the mechanism has a closed loop".to_string()
        } else {
            let names: Vec<&str> = roots.iter().take(5).map(|r| links[*r].1).collect();
            format!("{} links hang on nothing, but a robot has one base: {}", roots.len(), names.join(", "))
        };
        sheet.note(Problem::at(span(root), what, "expected one tree of links"));
        return None;
    };
    let mut hangings: Vec<Option<Hanging>> = hangings.into_iter().map(Some).collect();
    let mut bodies = Vec::with_capacity(links.len());
    let mut waiting = vec![(*base, None)];
    while let Some((link, parent)) = waiting.pop() {
        let hanging = upward[link].and_then(|h| hangings[h].take());
        let (placement, joint) = hanging.map_or((Isometry3::identity(), None), |h| (h.placement, h.joint));
        let (_, name, inertia) = &links[link];
        bodies.push(Body { name: Some((*name).to_string()), parent, placement, joint, inertia: *inertia });
        let here = bodies.len() - 1;
        // The last is taken first: children in the order of the file.
        for h in downward[link].iter().rev() {
            if let Some(hanging) = &hangings[*h] {
                waiting.push((index[hanging.child], Some(here)));
            }
        }
    }
    if bodies.len() < links.len() {
        let lost: Vec<&str> = (0..links.len())
            .filter(|l| upward[*l].is_some_and(|h| hangings[h].is_some()))
            .map(|l| links[l].1)
            .take(5)
            .collect();
        sheet.note(Problem::at(
            span(root),
            format!("a closed loop of links: {}", lost.join(", ")),
            "not reached from the base",
        ));
        return None;
    }
    Some(bodies)
}
