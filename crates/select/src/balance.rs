//! The balanced objective: what an engineer builds who is told neither to save every gram nor every watt.
//!
//! The one idea: the lightest design and the design with the least loss span what there is to trade. Loss and mass over the
//! geometric means of these two designs are two pure numbers of like size; their sum is an ordinary weighted objective,
//! with the certificate of one.

use std::borrow::Cow;

use super::answer::Design;
use super::optimize::optimize_with;
use super::options::{Options, Stopped};
use super::windings;
use gearwise_model::catalog::module::Inside;
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::requirement::{Balance, Balancing, Extreme, Joint, Objective, Quantity, Robot};

/// The robot with the balanced objectives that its joints ask for, found over a catalogue.
///
/// # Errors
/// It was stopped.
pub fn balanced(robot: &Robot, catalog: &Catalog, options: Options) -> Result<Robot, Stopped> {
    let asks = |joint: &Joint| joint.balancing == Balancing::Asked;
    let wanted = |place: usize| options.joint.is_none_or(|only| only == place);
    let mut made = robot.clone();
    for (index, joint) in robot.joints.iter().enumerate().filter(|(j, joint)| wanted(*j) && asks(joint)) {
        let (lightest, least_loss) = ends(robot, joint, catalog, options)?;
        let joint = &mut made.joints[index];
        let balance = match (lightest, least_loss) {
            (Some(Some(lightest)), Some(Some(least_loss))) => Ok(Balance::between(lightest, least_loss)),
            (_, Some(None)) | (Some(None), _) => Err("the mass of the design with the least loss is not known"),
            (None, Some(_)) => Err("no design's mass is known"),
            (_, None) => Err("no design can do it"),
        };
        joint.balancing = match balance {
            Ok(balance) if balance.loss > 0.0 && balance.mass > 0.0 => {
                joint.objective = balance.objective();
                Balancing::Made(Box::new(balance))
            }
            Ok(_) => Balancing::Cannot("there is neither loss nor mass to balance"),
            Err(why) => Balancing::Cannot(why),
        };
    }
    Ok(made)
}

/// The lightest design of a joint and that with the least loss: outside, whether there is one; inside, whether its mass is
/// known.
type Ends = (Option<Option<Extreme>>, Option<Option<Extreme>>);

fn ends(robot: &Robot, joint: &Joint, catalog: &Catalog, options: Options) -> Result<Ends, Stopped> {
    let alone = |quantity: Quantity| {
        // Whom the joint carries does not change its own ends, and is counted among all joints.
        let (carries, phases) = (Vec::new(), Vec::new());
        let joint = Joint { objective: Objective::single(quantity), carries, phases, count: 1, ..joint.clone() };
        Robot { joints: vec![joint], ..robot.clone() }
    };
    let options = Options { reasons: false, tick: &|| {}, joint: None, ..options };
    // A module whose loss nobody knows is no choice by it, and no end of the trade either.
    let says_loss = |motor: &Motor| motor.inside.as_deref().is_none_or(Inside::says_loss);
    let without = || {
        let mut other = catalog.clone();
        other.motors.retain(says_loss);
        other
    };
    let own = (!catalog.motors.iter().all(says_loss)).then(without);
    let catalog = own.as_ref().unwrap_or(catalog);
    // Of each motor the winding that is best for that end.
    let wound = |mut robot: Robot| {
        let wound = windings::wind(&mut robot, catalog, options.only_checked);
        let catalog = wound.unwrap_or(Cow::Borrowed(catalog));
        (robot, catalog)
    };
    // A spring is searched for at length: once, for the least loss; no spring changes a mass.
    if joint.limits.spring.is_some() {
        let (robot, catalog) = wound(alone(Quantity::Loss));
        let found = optimize_with(&robot, &catalog, Options { keep: None, ..options })?;
        let all = &found.joints[0].candidates;
        let mass = |design: &&Design| design.evaluation.mass.unwrap_or(f64::INFINITY);
        let lightest = all.iter().min_by(|a, b| mass(a).total_cmp(&mass(b)));
        return Ok((lightest.map(extreme), all.first().map(extreme)));
    }
    let first = |quantity: Quantity| {
        let (robot, catalog) = wound(alone(quantity));
        let found = optimize_with(&robot, &catalog, Options { keep: Some(1), ..options })?;
        Ok(found.joints[0].candidates.first().map(extreme))
    };
    Ok((first(Quantity::Mass)?, first(Quantity::Loss)?))
}

/// A design as an end of the trade; `None` where its mass is not known.
fn extreme(design: &Design) -> Option<Extreme> {
    Some(Extreme {
        motor: design.motor.id.clone(),
        gear: design.gear.map(str::to_string),
        ratio: design.evaluation.ratio,
        window: (design.optimum.window().min, design.optimum.window().max),
        loss: design.evaluation.loss,
        mass: design.evaluation.mass?,
    })
}
