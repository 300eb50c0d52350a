//! A joint and a design as they are named on the command line.

use super::Failure;
use super::rows::find_motor;
use crate::catalog::{Catalog, Gear, Motor};
use crate::requirement::{Joint, RatioChoice, Robot};
use crate::words::nearest;

/// A motor, with the gear or the ratio that was named after `@`.
pub struct Chosen<'c> {
    /// The motor.
    pub motor: &'c Motor,
    /// The gear of the catalogue.
    pub gear: Option<&'c Gear>,
    /// The ratio.
    pub ratio: Option<f64>,
}

/// The joint of a name; the only one where none is named.
pub fn joint<'r>(robot: &'r Robot, name: Option<&str>) -> Result<&'r Joint, Failure> {
    let names: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
    match name {
        Some(name) => robot.joints.iter().find(|j| j.name == name).ok_or_else(|| {
            let help = nearest(name, names.iter().copied())
                .map_or_else(|| format!("there are: {}", names.join(", ")), |n| format!("did you mean `{n}`?"));
            Failure::Argument(format!("there is no joint `{name}`; {help}"))
        }),
        None if robot.joints.len() == 1 => Ok(&robot.joints[0]),
        None => Err(Failure::Argument(format!("which joint? `--joint` is one of {}", names.join(", ")))),
    }
}

/// The motor's id in `MOTOR`, `MOTOR@RATIO` or `MOTOR@GEAR`.
pub fn id(text: &str) -> &str {
    text.split_once('@').map_or(text, |(id, _)| id)
}

/// The design `MOTOR`, `MOTOR@RATIO` or `MOTOR@GEAR` at a joint.
pub fn design<'c>(text: &str, joint: &Joint, catalog: &'c Catalog) -> Result<Chosen<'c>, Failure> {
    let (id, place) = (id(text), text.split_once('@').map(|(_, place)| place));
    let motor = find_motor(catalog, id)?;
    let mut gear = None;
    let mut ratio = None;
    match place.map(|p| (p, p.parse::<f64>())) {
        None => {}
        Some((_, Ok(number))) if (1e-6..=1e6).contains(&number) => {
            ratio = Some(joint.ratio.as_printed(number));
        }
        Some((text, Ok(_))) => {
            return Err(Failure::Argument(format!("`{text}` is not a ratio: expected a number from 1e-6 to 1e6")));
        }
        Some((name, Err(_))) if motor.inside.as_deref().is_some_and(|inside| inside.gear.id == name) => {}
        Some((name, Err(_))) => {
            let ids = catalog.all_gears().map(|g| g.id.as_str());
            let found = catalog.gear(name);
            let help = nearest(name, ids).map_or_else(String::new, |n| format!("; did you mean `{n}`?"));
            gear = Some(found.ok_or_else(|| {
                Failure::Argument(format!("`{name}` is neither a ratio nor a gear of the catalogue{help}"))
            })?);
        }
    }
    if let Some(inside) = motor.inside.as_deref() {
        if ratio.is_some_and(|ratio: f64| (ratio / inside.gear.ratio - 1.0).abs() > 1e-3) {
            let message = format!("the module `{id}` has a ratio of {}: name it alone", inside.gear.ratio);
            return Err(Failure::Argument(message));
        }
        return Ok(Chosen { motor, gear: Some(&inside.gear), ratio: None });
    }
    if gear.is_none() && matches!(joint.ratio, RatioChoice::Catalog { .. }) {
        let message = match joint.motors.only_modules {
            true => format!(
                "joint `{}` has modules alone, and `{id}` is a motor: give the joint a `ratio` or `gears` for it",
                joint.name
            ),
            false => format!("joint `{}` takes gears of the catalogue: name one, as in {id}@GEAR", joint.name),
        };
        return Err(Failure::Argument(message));
    }
    Ok(Chosen { motor, gear, ratio })
}
