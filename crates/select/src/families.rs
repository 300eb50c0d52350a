//! Families of gears at a joint: which a requirement may name, and ratios between their points.
//!
//! The one idea: a point of a family is a gear and needs nothing here. Where ratios between the points may be chosen, the
//! family becomes the gear map of the joint and its ratio free, so that all behind sees an ordinary joint. That takes the
//! catalogue, and is done once, when requirement and catalogue are read.

use std::sync::Arc;

use super::mount::gear_model;
use gearwise_model::catalog::family::{Covers, Family};
use gearwise_model::catalog::{Catalog, GEAR_FIELDS, Gear};
use gearwise_model::requirement::{
    Arrangement, Filter, GearMap, GearModel, GearsFrom, Joint, MapRow, Prices, RatioChoice, Robot,
};
use gearwise_model::words::nearest;

/// The columns that are interpolated between two points: all say them, or none.
const INTERPOLATED: &[&str] = &[
    "ratio",
    "mass",
    "inertia",
    "efficiency",
    "backdrive_efficiency",
    "no_load_torque",
    "peak_torque",
    "continuous_torque",
    "max_input_speed",
];

/// The columns that hold between two points where all points say the same, and are not known where they do not.
const SHARED: &[&str] =
    &["outer_diameter", "length", "width", "height", "backlash", "stiffness", "price", "price_quantity", "lead_time"];

/// A robot whose joints are ready for a catalogue: every pattern names a row, and a joint with ratios between the points of a family
/// has them as its gear map.
///
/// # Errors
/// In words: a pattern that names nothing, families that do not go together, points that cannot be interpolated.
pub fn settled(robot: Robot, catalog: &Catalog) -> Result<Robot, String> {
    super::check_patterns(&robot, catalog)?;
    settle(robot, catalog)
}

/// As [`settled`], of a robot whose patterns need not name a row: that of a design.
///
/// # Errors
/// As of [`settled`].
pub fn settle(robot: Robot, catalog: &Catalog) -> Result<Robot, String> {
    let prices = robot.prices.clone();
    let joints =
        robot.joints.into_iter().map(|joint| with_map(joint, catalog, prices.as_ref())).collect::<Result<_, _>>()?;
    Ok(Robot { joints, ..robot })
}

/// That the families which a joint names exist, go together and are made for a motor of the joint.
pub(super) fn check(joint: &Joint, patterns: &[String], catalog: &Catalog) -> Result<(), String> {
    let wrong = |why: String| Err(format!("joint `{}`: {why}", joint.name));
    for pattern in patterns {
        if catalog.families_of(std::slice::from_ref(pattern)).next().is_some() {
            continue;
        }
        let names = catalog.families.iter().map(|family| family.name.as_str());
        let help = match nearest(pattern, names) {
            _ if catalog.families.is_empty() => "it has no families at all; `--also` adds a file".to_string(),
            Some(near) => format!("did you mean `{near}`?"),
            None => "`gearwise catalog list families` lists them".to_string(),
        };
        return wrong(format!(
            "no gear family of the catalogue matches `{}`; {help}",
            gearwise_model::words::shorten(pattern)
        ));
    }
    let named: Vec<&Family> = catalog.families_of(patterns).collect();
    let Some((first, others)) = named.split_first() else { return wrong("`family` names none".into()) };
    if let Some(other) = others.iter().find(|other| other.stress_limit != first.stress_limit) {
        return wrong(format!(
            "the families `{}` ({}) and `{}` ({}) are made for two stress limits: their masses do not compare; name those of one",
            first.name,
            first.stress(),
            other.name,
            other.stress()
        ));
    }
    if joint.limits.axial_length.is_some()
        && joint.limits.arrangement == Arrangement::SideBySide
        && let Some(family) = named.iter().find(|family| family.length_covers == Covers::Actuator)
    {
        return wrong(format!(
            "the lengths of `{}` are those of motor and gear one behind the other, and `arrangement` says side by side",
            family.name
        ));
    }
    let may_be = |motor: &&gearwise_model::catalog::Motor| joint.motors.allows(motor) && motor.inside.is_none();
    let is_for = |family: &Family| {
        let fits = |motor: &gearwise_model::catalog::Motor| family.gear.fits(motor.machine_id()) != Some(false);
        catalog.motors.iter().chain(&catalog.aside).filter(may_be).any(fits)
    };
    if let Some(family) = named.iter().find(|family| !is_for(family)) {
        let of = family.gear.fits.join(", ");
        return wrong(format!("`{}` is made for {of}, and none of the joint's motors is that", family.name));
    }
    Ok(())
}

/// A joint with ratios between the points of a family: with the family as its gear map. Any other as it is.
fn with_map(joint: Joint, catalog: &Catalog, prices: Option<&Prices>) -> Result<Joint, String> {
    let RatioChoice::Catalog { patterns, from: GearsFrom::Families { between: true }, .. } = &joint.ratio else {
        return Ok(joint);
    };
    let wrong = |why: String| Err(format!("joint `{}`: {why}", joint.name));
    let named: Vec<&Family> = catalog.families_of(patterns).collect();
    let [family] = named[..] else {
        let names: Vec<&str> = named.iter().map(|family| family.name.as_str()).collect();
        let names = if names.is_empty() { "none".into() } else { names.join(", ") };
        return wrong(format!("`between = true` takes one family; {} names {names}", patterns.join(", ")));
    };
    let (map, base) = match map(family, prices) {
        Ok(made) => made,
        Err(why) => return wrong(format!("no ratios between the points of `{}`: {why}", family.name)),
    };
    let limits = &joint.limits;
    let asked = [
        ("outer_diameter", "outer_diameter", limits.outer_diameter.is_some() && base.outer_diameter.is_none()),
        ("axial_length", "length", limits.axial_length.is_some() && base.length.is_none()),
        ("max_backlash", "backlash", limits.max_backlash.is_some() && base.backlash.is_none()),
        ("min_stiffness", "stiffness", limits.min_stiffness.is_some() && base.stiffness.is_none()),
    ];
    // A price that is unknown at a point is unknown between the points as well: that is no difference.
    let is_priced = |point: &Gear| prices.is_some_and(|prices| prices.of(&point.offer).is_ok());
    let differs_in_price = base.price.is_none() && family.points.iter().all(is_priced);
    let asked = asked.into_iter().chain([
        ("price", "price", limits.price.is_some() && differs_in_price),
        ("lead_time", "lead_time", limits.lead_time.is_some() && base.lead_time.is_none()),
    ]);
    let says = |column: &str| {
        let field = GEAR_FIELDS.iter().find(|field| field.name == column);
        field.is_some_and(|field| family.points.iter().any(|point| (field.get)(point).is_some()))
    };
    if let Some((limit, ..)) = asked.into_iter().find(|(_, column, unknown)| *unknown && says(column)) {
        return wrong(format!(
            "the points of `{}` differ in what `{limit}` asks for, and between two of them it is not known; leave `between` out: the \
             points can be judged",
            family.name
        ));
    }
    let (min, max) = map.range();
    let motors = Filter { made_for: family.gear.fits.clone(), ..joint.motors.clone() };
    let gear = GearModel { says_loss: true, ..map.gear(&base, min) };
    let ratio = RatioChoice::Continuous { min, max };
    Ok(Joint { ratio, gear, gear_map: Some(Arc::new(map)), motors, ..joint })
}

/// The gear map through the points of a family, and what none of its columns says.
fn map(family: &Family, prices: Option<&Prices>) -> Result<(GearMap, GearModel), String> {
    for field in GEAR_FIELDS {
        let of = |point: &Gear| (field.get)(point).map(|printed| printed.value);
        let says = family.points.iter().filter(|point| of(point).is_some()).count();
        let known = INTERPOLATED.contains(&field.name);
        if says > 0 && !known && !SHARED.contains(&field.name) {
            return Err(format!("`{}` is not interpolated", field.name));
        }
        if known && says > 0 && says < family.points.len() {
            return Err(format!("`{}` is known of {says} of {} points alone", field.name, family.points.len()));
        }
    }
    let models: Option<Vec<GearModel>> = family.points.iter().map(gear_model).collect();
    let models = models.ok_or("the efficiency of its points is not known")?;
    let rows: Vec<(MapRow, String)> =
        family.points.iter().zip(&models).map(|(point, model)| (row(point, model), point.id.clone())).collect();
    let map = GearMap::of_points(&family.name, &rows).ok_or("it has one point alone")?;
    let price = |point: &Gear| prices.and_then(|prices| prices.of(&point.offer).ok());
    let first = family.points.first().and_then(price);
    let price = first.filter(|_| family.points.iter().all(|point| price(point) == first));
    Ok((map, GearModel { price, ..shared(&models) }))
}

/// A point as a row of the map: what it does not say, the map does not either.
fn row(point: &Gear, model: &GearModel) -> MapRow {
    MapRow {
        ratio: point.ratio,
        mass: point.mass,
        inertia: point.inertia,
        driving: Some(1.0 / model.efficiency),
        braking: Some(model.backdrive_efficiency),
        no_load_torque: point.no_load_torque.map(|_| model.no_load.coulomb),
        peak_torque: point.peak_torque,
        continuous_torque: point.continuous_torque,
        max_input_speed: point.max_input_speed,
    }
}

/// Values that all points share, but for the price; others are unknown.
fn shared(models: &[GearModel]) -> GearModel {
    let alike = |of: fn(&GearModel) -> Option<f64>| {
        let first = models.first().and_then(of);
        first.filter(|_| models.iter().all(|model| of(model) == first))
    };
    GearModel {
        outer_diameter: alike(|model| model.outer_diameter),
        length: alike(|model| model.length),
        backlash: alike(|model| model.backlash),
        stiffness: alike(|model| model.stiffness),
        lead_time: alike(|model| model.lead_time),
        price: None,
        mass: None,
        says_loss: true,
        ..GearModel::IDEAL
    }
}
