//! Inertia, friction and mass that a model states.

use super::said::{about, alone, backing, factors, stated_as};
use crate::models::{ModelFacts, differs, explained, within};
use crate::rule::{Judgement, ModelRemark, Rule, Severity, Test};
use gearwise_model::mechanism::stated::{Form, Quantity};
use gearwise_model::words::number;

const NO_ARMATURE: &str = "no row of its hardware gives an inertia, or not at which side";

pub(in crate::registry) const ARMATURE_MISSING: Rule = Rule {
    code: "GW405",
    name: "armature-missing",
    summary: "a model states the inertia of its actuators",
    severity: Severity::Warning,
    what: "Finds joints whose armature is missing or 0 while their hardware has one. URDF and SDFormat have no armature but that of Drake; one without it is not judged. In MJCF the armature of an actuator times its gear² counts with that of its joint.",
    why: "Behind a gear the rotor is often heavier than the limb: without it the joint is far too quick, and contacts are far too hard.",
    example: "An MJCF joint without `armature` on an actuator with 0.01 kg*m^2 at the flange.",
    fix: "Write r² times the inertia at the flange, or (r N)² (J_m + J_g).",
    test: Test::ModelJoint(armature_missing),
};

fn armature_missing(facts: &ModelFacts, k: usize) -> Judgement {
    let joint = &facts.joints[k];
    if alone(joint).is_none() {
        return Judgement::NotAsked;
    }
    let stated = joint.get(Quantity::Armature);
    if stated.is_none() && matches!(facts.models[joint.model].form, Form::Urdf | Form::Sdf) {
        return Judgement::NotJudged("URDF and SDFormat have no armature");
    }
    if stated.is_some_and(|stated| stated.value > 0.0) {
        return Judgement::NotAsked;
    }
    let Some(fact) = &joint.reflected.armature else { return Judgement::NotJudged(NO_ARMATURE) };
    let span = stated.map_or(&joint.joint.span, |stated| &stated.span);
    let message = match stated {
        Some(_) => "armature is 0".to_string(),
        None => "armature is not stated, so it is 0".to_string(),
    };
    let remark = ModelRemark {
        joint: Some(k),
        value: Some(0.0),
        unit: Quantity::Armature.unit(),
        ..ModelRemark::new(message, Quantity::Armature.name(), joint.at(span))
    };
    Judgement::Judged(vec![remark.against(fact, "inertia").write(Quantity::Armature, fact.value)])
}

pub(in crate::registry) const ARMATURE_DIFFERS: Rule = Rule {
    code: "GW406",
    name: "armature-differs",
    summary: "the armature of a model is the inertia of its hardware at the joint",
    severity: Severity::Warning,
    what: "Compares the armature with the inertia of rotor and gear at the joint, r² J or (r N)² (J_m + J_g); of a joint of a [[coupling]] the diagonal of Jᵀ diag(a, b) J, of both actuators; more than 20 % apart (`armature_tolerance`) is a finding. Every factor that would explain it is named: N, N², their inverses, r, r², 2, powers of ten, or the inertia of another entry of the file.",
    why: "The inertia at the motor and that at the joint differ by N²: 81 times at 9:1. openarm #336: an armature of another actuator.",
    example: "armature=\"0.00018\" at 9:1, where 0.0146 kg*m^2 are at the joint.",
    fix: "Write the inertia at the joint.",
    test: Test::ModelJoint(armature_differs),
};

fn armature_differs(facts: &ModelFacts, k: usize) -> Judgement {
    let joint = &facts.joints[k];
    let (Some(hardware), Some(stated)) = (alone(joint), joint.get(Quantity::Armature)) else {
        return Judgement::NotAsked;
    };
    if stated.value <= 0.0 {
        return Judgement::NotAsked;
    }
    let Some(fact) = &joint.reflected.armature else { return Judgement::NotJudged(NO_ARMATURE) };
    if !differs(stated.value, fact.value, fact.holds, facts.file.tolerances.armature) {
        return Judgement::Judged(Vec::new());
    }
    let why =
        explained(stated.value / fact.value, &factors(hardware, 2)).map_or(String::new(), |why| format!("; {why}"));
    let same = |other: &&crate::hardware::Hardware| {
        other.label != hardware.label
            && other.armature.as_ref().is_some_and(|other| within(stated.value, other.value, 0.05))
    };
    let other =
        facts.hardware.iter().find(same).map_or(String::new(), |other| format!("; it is that of {}", other.label));
    let message =
        format!("{} is not the inertia at the joint, {} kg*m^2{why}{other}", stated_as(stated), number(fact.value));
    let remark = about(k, facts, stated, message).against(fact, "inertia");
    Judgement::Judged(vec![remark.write(Quantity::Armature, fact.value)])
}

pub(in crate::registry) const FRICTION: Rule = Rule {
    code: "GW407",
    name: "model-friction",
    summary: "the friction of a model is about that of its hardware",
    severity: Severity::Note,
    what: "Compares Coulomb and viscous friction of the model with the row's at the joint (× r, × r²; × |J|, × J² and of both actuators in a [[coupling]]), where the row has them; more than 50 % apart (`friction_tolerance`) is a note, as is none at all.",
    why: "Friction of the gear decides whether a joint can be driven back, and what torque reaches the ground.",
    example: "frictionloss=\"0\" on an actuator with 1.6 N*m of static friction.",
    fix: "Write the friction at the joint; or a range around it where the friction is drawn at random.",
    test: Test::ModelJoint(friction),
};

fn friction(facts: &ModelFacts, k: usize) -> Judgement {
    let joint = &facts.joints[k];
    if alone(joint).is_none() {
        return Judgement::NotAsked;
    }
    let pairs = [(Quantity::Friction, &joint.reflected.friction), (Quantity::Damping, &joint.reflected.damping)];
    let mut remarks = Vec::new();
    let mut judged = false;
    for (quantity, fact) in pairs {
        let Some(fact) = fact else { continue };
        judged = true;
        let stated = joint.get(quantity);
        let value = stated.map_or(0.0, |stated| stated.value);
        if !differs(value, fact.value, fact.holds, facts.file.tolerances.friction) {
            continue;
        }
        let message = match stated {
            Some(stated) => format!("{} is not that of its hardware, {}", stated_as(stated), number(fact.value)),
            None => format!("{} is not stated; that of its hardware is {}", quantity.name(), number(fact.value)),
        };
        let span = stated.map_or(&joint.joint.span, |stated| &stated.span);
        let mut remark = ModelRemark {
            joint: Some(k),
            value: Some(value),
            unit: quantity.unit(),
            ..ModelRemark::new(message, quantity.name(), joint.at(span))
        };
        remark = remark.against(fact, quantity.name());
        remark.help = Some(format!("write {} {}", number(fact.value), quantity.unit()));
        remarks.push(remark);
    }
    if judged { Judgement::Judged(remarks) } else { Judgement::NotJudged("no row of its hardware gives friction") }
}

pub(in crate::registry) const LINK_MASS: Rule = Rule {
    code: "GW414",
    name: "link-mass",
    summary: "no link of a model is lighter than the actuators in it",
    severity: Severity::Warning,
    what: "Sums the masses of the actuators of all joints that hang on a link and compares them with the link's mass. That an actuator is mounted in the link that its joint hangs on is assumed.",
    why: "A link that is lighter than its motors was drawn without them: every dynamic quantity above it is wrong.",
    example: "A thigh of 0.5 kg that carries a knee actuator of 0.88 kg.",
    fix: "Put the mass of the actuators into the link, or except links whose actuators are mounted elsewhere with [[allow]].",
    test: Test::Models(link_mass),
};

fn link_mass(facts: &ModelFacts) -> Vec<ModelRemark> {
    let mut remarks = Vec::new();
    for (m, model) in facts.models.iter().enumerate() {
        for (l, link) in model.links.iter().enumerate() {
            let Some((mass, span)) = &link.mass else { continue };
            let mounted = || facts.of_model(m).filter(|(_, joint)| joint.joint.parent == Some(l));
            let known: Vec<_> =
                mounted().filter_map(|(_, joint)| Some((joint, joint.hardware?.mass.as_ref()?))).collect();
            let total: f64 = known.iter().map(|(_, fact)| fact.value).sum();
            // What rounding leaves of equal masses is no finding.
            let Some((_, first)) = known.first().filter(|_| *mass < total * (1.0 - 1e-6)) else { continue };
            let names: Vec<&str> = known.iter().map(|(joint, _)| joint.joint.name.as_str()).collect();
            let message = format!(
                "link {} has {} kg; the actuators of {}, assumed to be mounted in it, have {} kg",
                link.name,
                number(*mass),
                names.join(", "),
                number(total)
            );
            let mut remark = ModelRemark::new(message, "mass", (Some(m), span.clone()));
            (remark.value, remark.bound, remark.unit) = (Some(*mass), Some(total), "kg");
            let mut rows: Vec<&str> = known.iter().map(|(_, fact)| fact.row.as_str()).collect();
            rows.dedup();
            remark.backing = Some(crate::rule::Backing {
                allows: format!("actuators of {} kg", number(total)),
                row: rows.join(", "),
                conversion: known.iter().map(|(_, fact)| number(fact.value)).collect::<Vec<_>>().join(" + ") + " kg",
                ..backing(first, "mass", "kg")
            });
            remark.help = Some("put the mass of the actuators into the link, or say where they are".into());
            remarks.push(remark);
        }
    }
    remarks
}
