//! A motor mounted at a joint: the one place where a candidate is made.
//!
//! The one idea: a [`Mount`] says which motor drives which joint through which gear, and makes the candidate of it.
//! A [`Site`] is a joint with its load made ready once, and goes through the mounts that the requirement allows a
//! motor there: one with a ratio that is still free, or one for each gear of the catalogue.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Prepared;
use super::answer::Unusable;
use super::loads::{Loads, MANY, of_large};
use super::options::Stop;
use gearwise_model::actuator::candidate::MapPart;
use gearwise_model::actuator::fitted::gear_with_fit;
use gearwise_model::actuator::gearing::{complete, described};
use gearwise_model::actuator::limits::{Candidate, hottest};
use gearwise_model::actuator::{Actuator, Load};
use gearwise_model::catalog::{Catalog, Gear, Motor, matches_pattern};
use gearwise_model::requirement::{
    EfficiencyCovers, GearModel, Joint, Motion, RatioChoice, Robot, backdrive_efficiency,
};

/// A motor at a joint, with a gear of the catalogue or with a ratio that is still free.
#[derive(Debug, Clone, Copy)]
pub struct Mount<'a, 'l> {
    /// The robot, for bus and surroundings.
    pub robot: &'a Robot,
    /// The joint.
    pub joint: &'a Joint,
    /// The joint's load, as the gear passes it on.
    pub load: &'l Load,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear of the catalogue; `None` where the ratio is free.
    pub gear: Option<&'a Gear>,
    /// Whether searches over it are to stop.
    pub stop: Stop<'l>,
    /// As that of its [`Site`].
    pub whole_windows: bool,
}

impl<'a: 'l, 'l> Mount<'a, 'l> {
    /// A motor at a joint with a ratio that is still free.
    pub fn new(robot: &'a Robot, joint: &'a Joint, load: &'l Load, motor: &'a Motor) -> Mount<'a, 'l> {
        // A module has its gear in it.
        let gear = motor.inside.as_deref().map(|inside| &inside.gear);
        Mount { robot, joint, load, motor, gear, stop: Stop::NEVER, whole_windows: false }
    }

    /// The same with a gear of the catalogue, where one is given; `load` has to be as that gear passes it on
    /// ([`load_through`]).
    pub fn with_gear(self, gear: Option<&'a Gear>) -> Mount<'a, 'l> {
        Mount { gear: self.motor.inside.as_deref().map(|inside| &inside.gear).or(gear), ..self }
    }

    /// Id of the gear, where it is one of the catalogue.
    pub fn gear_id(&self) -> Option<&'a str> {
        self.gear.map(|gear| gear.id.as_str())
    }

    /// The ratios that are open: the gear's own, or those that the requirement allows, from the smallest to the largest
    /// where it lists them ([`RatioChoice::listed`]). `None` where only a gear
    /// could tell, and none is mounted.
    pub fn range(&self) -> Option<(f64, f64)> {
        self.gear.map(|gear| (gear.ratio, gear.ratio)).or_else(|| self.joint.ratio.range())
    }

    /// The candidate.
    ///
    /// # Errors
    /// Motor or gear lack a number that every evaluation needs.
    pub fn candidate(self) -> Result<Candidate<'l>, Unusable> {
        let Mount { robot, joint, load, motor, gear: catalog_gear, .. } = self;
        if !joint.motors.allows(motor) {
            return Err(Unusable::NotAllowed);
        }
        if catalog_gear.is_none() && !joint.motors.is_made_for(motor) {
            return Err(Unusable::NoGearFits);
        }
        let rotor = match motor.inside.as_deref() {
            // Of a module that does not say it, torques are looked at without it, which is said.
            Some(inside) if !inside.says_inertia => 0.0,
            _ => motor.rotor_inertia.ok_or(Unusable::RotorInertia)?,
        };
        let hottest = hottest(motor, joint).0;
        let (gear, actuator) = match catalog_gear {
            None if joint.gear_map.is_some() && (motor.fitted_gear.is_some() || !motor.effects.is_empty()) => {
                return Err(Unusable::GearMap);
            }
            None => {
                let gear = gear_with_fit(motor, &joint.gear);
                (gear, described(motor, joint, rotor, &gear))
            }
            Some(printed) => {
                let gear = gear_model(printed).ok_or(Unusable::GearEfficiency)?;
                // Where the efficiency covers the gear's inertia, the load has it already.
                let inertia = if covers_gear(joint) { 0.0 } else { gear.inertia };
                let at_the_shaft = GearModel { inertia, ..gear };
                let actuator = Actuator::at_temperature(motor, rotor, &at_the_shaft, Some(hottest), false);
                let mut actuator = actuator.with_winding_at(hottest, motor.reference_temperature);
                actuator.inertia = rotor + gear.inertia;
                (gear, actuator)
            }
        };
        let (actuator, other) = complete(actuator, robot, joint, motor, &gear);
        let map = joint.gear_map.as_deref().filter(|_| catalog_gear.is_none()).map(MapPart::Whole);
        let candidate = Candidate {
            robot,
            joint,
            load,
            motor,
            catalog_gear,
            gear,
            actuator,
            other,
            map,
            folded: false,
            by_ratio: None,
        };
        Ok(candidate.standing_between(self.range()))
    }

    /// The candidate with its limits gathered.
    ///
    /// # Errors
    /// As [`Mount::candidate`].
    pub fn prepared(self) -> Result<Prepared<'l>, Unusable> {
        let stop = self.stop;
        self.candidate().map(|candidate| Prepared::new(candidate).stopping(stop))
    }
}

/// The numbers of a gear of the catalogue; `None` where its efficiency is not known.
pub(super) fn gear_model(gear: &Gear) -> Option<GearModel> {
    let efficiency = gear.load_efficiency()?;
    Some(GearModel {
        efficiency,
        backdrive_efficiency: gear.load_backdrive_efficiency().unwrap_or_else(|| backdrive_efficiency(efficiency)),
        mass: gear.mass,
        mass_per_stage: None,
        inertia: gear.inertia.unwrap_or(0.0),
        peak_torque: gear.peak_torque,
        continuous_torque: gear.continuous_torque,
        max_input_speed: gear.max_input_speed,
        ratings: gear.ratings,
        backlash: gear.backlash,
        stiffness: gear.stiffness,
        no_load: gear.no_load(),
        friction_at_rest: gear.friction_at_rest(),
        backdriving_torque: gear.backdriving_torque,
        says_loss: true,
        outer_diameter: gear.across(),
        length: gear.length,
        price: None,
        lead_time: gear.offer.lead_time,
    })
}

fn covers_gear(joint: &Joint) -> bool {
    matches!(joint.ratio, RatioChoice::Catalog { efficiency_covers: EfficiencyCovers::LoadAndGear, .. })
}

/// Inertia at the output \[kg·m²\] that a gear's efficiency covers at a joint as it covers the load; `None` where it
/// covers none, or the inertia is not known.
pub(crate) fn covered_inertia(joint: &Joint, gear: &Gear) -> Option<f64> {
    let inertia = gear.inertia.filter(|_| covers_gear(joint))?;
    Some(inertia * gear.ratio * gear.ratio)
}

/// The load of a joint as a gear passes it on: with the torque that accelerates the gear's inertia, where its
/// efficiency covers that too.
pub fn load_through(joint: &Joint, gear: Option<&Gear>) -> Load {
    load_covering(joint, gear.and_then(|gear| covered_inertia(joint, gear)))
}

/// The load of a joint with an inertia at the output \[kg·m²\] that the gear's efficiency covers.
pub(crate) fn load_covering(joint: &Joint, covered: Option<f64>) -> Load {
    let sprung = joint.limits.spring.is_some().then(|| Motion { sprung: true, ..Motion::clone(&joint.motion) });
    let motion = sprung.as_ref().unwrap_or(&joint.motion);
    let make = || Load::with_inertia(motion, joint.ripple(), covered.unwrap_or(0.0));
    let is_plain = covered.is_none() && joint.ripple().is_none();
    let load = if is_plain && joint.motion.len() > MANY { of_large(&joint.motion, make) } else { make() };
    match &joint.gear_map {
        Some(map) if covered.is_none() => load.with_pieces(map, &joint.gear),
        _ => load,
    }
}

/// What a joint asks, made ready once for all motors: its load, and the gears it allows, each with the
/// load as that gear passes it on.
#[derive(Debug)]
pub struct JointDemand<'a> {
    /// The load at the joint.
    pub load: Load,
    /// The gears of the catalogue that the joint allows, in the order of their ids; a load of its own
    /// where the gear's efficiency covers its inertia.
    gears: Vec<(&'a Gear, Option<Load>)>,
    /// Of them those that name motors that they fit, by motor or pattern.
    by_pattern: BTreeMap<&'a str, Vec<usize>>,
    /// Those that name none.
    for_any: Vec<usize>,
    /// The number of motors that the joint allows.
    motors: usize,
}

impl<'a> JointDemand<'a> {
    /// Prepares a joint.
    pub fn new(joint: &Joint, catalog: &'a Catalog) -> JointDemand<'a> {
        JointDemand::among(joint, catalog, None)
    }

    /// The same with a load that may have been made ready before.
    pub fn among(joint: &Joint, catalog: &'a Catalog, loads: Option<&Loads>) -> JointDemand<'a> {
        let gears = match &joint.ratio {
            RatioChoice::Continuous { .. } | RatioChoice::Listed { .. } => Vec::new(),
            RatioChoice::Catalog { patterns, from, .. } => from.of(patterns, catalog),
        };
        let own = |gear| covered_inertia(joint, gear).map(|inertia| load_covering(joint, Some(inertia)));
        let mut by_pattern: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (k, gear) in gears.iter().enumerate() {
            gear.fits.iter().for_each(|pattern| by_pattern.entry(pattern).or_default().push(k));
        }
        let for_any = (0..gears.len()).filter(|k| gears[*k].fits.is_empty()).collect();
        let gears = gears.into_par_iter().map(|gear| (gear, own(gear))).collect();
        let make = || load_covering(joint, None);
        let load = loads.map_or_else(make, |loads| loads.of(joint, make));
        let motors = catalog.motors.iter().filter(|motor| !joint.motors.pass_over(motor)).count();
        JointDemand { load, gears, by_pattern, for_any, motors }
    }

    /// A gear that the joint allows, by its id.
    pub(super) fn gear(&self, id: &str) -> Option<&'a Gear> {
        self.gears.iter().find(|(gear, _)| gear.id == id).map(|(gear, _)| *gear)
    }

    /// The load as a gear passes it on, by its id.
    pub(super) fn load_with(&self, id: Option<&str>) -> &Load {
        let own = id.and_then(|id| self.gears.iter().find(|(gear, _)| gear.id == id)).and_then(|(_, own)| own.as_ref());
        own.unwrap_or(&self.load)
    }

    /// Ids of the gears that the joint allows and that cannot be evaluated: their rows say no efficiency.
    pub fn without_efficiency(&self) -> Vec<&'a str> {
        self.gears.iter().filter(|(gear, _)| gear_model(gear).is_none()).map(|(gear, _)| gear.id.as_str()).collect()
    }

    /// The gears that may be mounted on a motor, each with its load.
    pub fn gears_for<'d>(&'d self, motor: &Motor) -> impl Iterator<Item = (&'a Gear, &'d Load)> + use<'a, 'd> {
        let id = motor.machine_id();
        let named = self.by_pattern.iter().filter(|(pattern, _)| matches_pattern(pattern, id));
        let mut fitting: Vec<usize> = named.flat_map(|(_, gears)| gears).chain(&self.for_any).copied().collect();
        fitting.sort_unstable();
        // Several patterns of a gear may be those of a motor.
        fitting.dedup();
        fitting.into_iter().map(|k| {
            let (gear, own) = &self.gears[k];
            (*gear, own.as_ref().unwrap_or(&self.load))
        })
    }
}

/// A joint of a robot with what it asks made ready.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a, 'd> {
    /// The robot.
    pub robot: &'a Robot,
    /// The joint.
    pub joint: &'a Joint,
    /// What the joint asks.
    pub demand: &'d JointDemand<'a>,
    /// Whether searches here are to stop.
    pub stop: Stop<'d>,
    /// Whether windows stay as the limits give them, where the best ratio can be judged: of a design that nobody is shown it does not
    /// matter where its windows can.
    pub whole_windows: bool,
}

impl<'a: 'd, 'd> Site<'a, 'd> {
    /// A joint of a robot with what it asks.
    pub fn new(robot: &'a Robot, joint: &'a Joint, demand: &'d JointDemand<'a>) -> Site<'a, 'd> {
        Site { robot, joint, demand, whole_windows: false, stop: Stop::NEVER }.stopping(Stop::NEVER)
    }

    /// The same for searches that may be stopped.
    pub fn stopping(self, stop: Stop<'d>) -> Site<'a, 'd> {
        let programs = self.demand.motors * self.robot.joints.len();
        Site { stop: stop.among(programs), ..self }
    }

    /// Whether gears of the catalogue are asked for, and the ratio is not free.
    pub fn is_geared(&self) -> bool {
        matches!(self.joint.ratio, RatioChoice::Catalog { .. })
    }

    /// Whether a motor has no free ratio here: gears of the catalogue are asked for, or it is a module.
    pub fn is_geared_with(&self, motor: &Motor) -> bool {
        self.is_geared() || motor.inside.is_some()
    }

    /// A motor with a free ratio, whatever the joint asks for.
    pub fn direct(self, motor: &'a Motor) -> Mount<'a, 'd> {
        Mount {
            stop: self.stop,
            whole_windows: self.whole_windows,
            ..Mount::new(self.robot, self.joint, &self.demand.load, motor)
        }
    }

    /// All that the requirement lets a motor be here: with a free ratio, or with each gear that is allowed and fits.
    pub fn mounts(self, motor: &'a Motor) -> impl Iterator<Item = Mount<'a, 'd>> {
        let free = (!self.is_geared() || motor.inside.is_some()).then(|| self.direct(motor));
        let geared = self.demand.gears_for(motor).filter(|_| motor.inside.is_none()).map(move |(gear, load)| Mount {
            gear: Some(gear),
            load,
            ..self.direct(motor)
        });
        free.into_iter().chain(geared)
    }

    /// A motor with a gear of a name, or with a free ratio.
    ///
    /// # Errors
    /// The gear is none that is allowed and fits.
    pub fn mount(self, motor: &'a Motor, gear: Option<&str>) -> Result<Mount<'a, 'd>, Unusable> {
        match gear {
            None => Ok(self.direct(motor)),
            Some(_) if motor.inside.is_some() => Ok(self.direct(motor)),
            Some(id) => self.mounts(motor).find(|m| m.gear_id() == Some(id)).ok_or(Unusable::NoGearFits),
        }
    }
}
