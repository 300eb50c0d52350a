//! What a requirement file says, in SI.

use std::path::PathBuf;
use std::sync::Arc;

use super::bus::Bus;
use super::drive::{Drive, MotorDrag};
use super::driven::Driven;
use super::gear::{GearModel, RatioChoice};
use super::gear_map::GearMap;
use super::limits::{Limits, Ripple};
use super::objective::{Balancing, Objective};
use super::prices::Prices;
use super::turns::{Turns, Windings};
use crate::catalog::{Module, Motor, is_named, matches_pattern};
use crate::input::{InputFile, Source};
use crate::motion::Motion;
use crate::transmission::{Passed, SpringAt, Transmission, Via};

/// A robot: its supply, its surroundings and its joints.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// The supply.
    pub bus: Bus,
    /// Ambient temperature \[K\].
    pub ambient: f64,
    /// What the whole robot may have.
    pub budget: Budget,
    /// In what currency prices are counted; without it no price is.
    pub prices: Option<Prices>,
    /// The joints.
    pub joints: Vec<Joint>,
    /// Load cases of the joints that happen together; empty where those of one name do.
    pub cases: Vec<RobotCase>,
    /// Where motions come from a description of the robot: what was done with it.
    pub driven: Option<Driven>,
    /// The rules file that designs for it have to keep, where it names one.
    pub rules: Option<PathBuf>,
    /// The files that it was read from: the requirement, its motions, the description of the robot.
    pub sources: Vec<Arc<Source>>,
    /// What was put in the place of the requirement's own values: path, and value as TOML.
    pub set: Vec<(String, String)>,
}

/// Limits of the whole robot.
#[derive(Debug, Clone, Copy, Default)]
pub struct Budget {
    /// Mass of all actuators together \[kg\].
    pub actuator_mass: Option<f64>,
    /// Number of different motors.
    pub max_distinct_motors: Option<u32>,
    /// Power that the bus delivers to all joints together at any instant \[W\].
    pub power: Option<f64>,
    /// Current that the bus delivers to all joints together at any instant \[A\].
    pub current: Option<f64>,
    /// Power that the bus takes back from all joints together at any instant \[W\], beside what a brake burns.
    pub regeneration: Option<f64>,
}

impl Robot {
    /// The files that it was read from, each with its hash.
    pub fn files(&self) -> Vec<InputFile> {
        self.sources.iter().map(|source| source.file()).collect()
    }

    /// Power that may come back from all joints together at any instant \[W\]: what the bus takes and what a brake burns.
    pub fn shared_regeneration(&self) -> Option<f64> {
        self.budget.regeneration.map(|most| most + self.bus.brake_power.unwrap_or(0.0))
    }

    /// Power that all joints together may draw at any instant \[W\]: the smaller of the budgets of power
    /// and of current.
    pub fn shared_power(&self) -> Option<f64> {
        let of_current = self.budget.current.map(|i| i * self.bus.voltage);
        self.budget.power.into_iter().chain(of_current).reduce(f64::min)
    }

    /// The resistance of the supply \[Ω\] that all joints draw through, where one is said and there is more than one actuator.
    pub fn shared_resistance(&self) -> Option<f64> {
        let actuators: u32 = self.joints.iter().map(|joint| joint.count).sum();
        self.bus.internal_resistance.filter(|resistance| *resistance > 0.0 && actuators > 1)
    }

    /// Whether another joint carries the actuator of a joint.
    pub fn carries(&self, joint: &Joint) -> bool {
        let carried = |j: &Joint| j.carries.iter().any(|c| self.joints[c.joint].name == joint.name);
        self.joints.iter().any(carried)
    }

    /// Whether the joints' choices depend on each other: a budget, a supply that sags under all of them, or actuators that carry
    /// actuators.
    pub fn is_coupled(&self) -> bool {
        let Budget { actuator_mass, max_distinct_motors, power, current, regeneration } = self.budget;
        let budgets =
            [actuator_mass, power, current, regeneration].iter().any(Option::is_some) || max_distinct_motors.is_some();
        budgets || self.shared_resistance().is_some() || self.joints.iter().any(|j| !j.carries.is_empty())
    }
}

/// Another joint's actuator that a joint carries.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried {
    /// Index of the joint whose actuator is carried.
    pub joint: usize,
    /// How much the load torque rises per kilogram of one such actuator, at each sample \[N·m/kg\].
    pub torque_per_mass: Vec<f64>,
    /// Its rate \[N·m/(kg·s)\].
    pub rate: Vec<f64>,
    /// Whether it is the same at every sample.
    pub constant: bool,
}

/// One joint, or several alike.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// How many joints like this the robot has.
    pub count: u32,
    /// Which ratios may be chosen.
    pub ratio: RatioChoice,
    /// The gear that goes with a continuous ratio.
    pub gear: GearModel,
    /// The gear over the ratio, where it is one of a family; `gear` is then that of the smallest ratio.
    pub gear_map: Option<Arc<GearMap>>,
    /// Which motors may be chosen: patterns of ids or makers.
    pub motors: Filter,
    /// What the actuator does: what the joint does, through its transmission where it has one.
    pub motion: Arc<Motion>,
    /// What is between actuator and joint, and the motion at the joint.
    pub passed: Option<Arc<Passed>>,
    /// What makes a choice good.
    pub objective: Objective,
    /// Whether that is balanced between loss and mass.
    pub balancing: Balancing,
    /// What a choice must keep.
    pub limits: Limits,
    /// Largest drive current of this joint, in place of the bus's \[A\].
    pub drive_current: Option<f64>,
    /// What its drive loses, in place of what the bus says.
    pub drive: Drive,
    /// Whether what no-load currents and estimates say of a motor's drag counts.
    pub motor_drag: MotorDrag,
    /// How many turns the winding of its motor may have.
    pub turns: Turns,
    /// By how much of the period each of the `count` joints is late; empty where all move alike.
    pub phases: Vec<f64>,
    /// Whose actuators this joint carries.
    pub carries: Vec<Carried>,
}

/// Largest torque and speed on one side of a transmission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peaks<'j> {
    /// Whose, where there are two.
    pub of: &'j str,
    /// \[N·m\]
    pub torque: f64,
    /// \[rad/s\]
    pub speed: f64,
}

/// How a spring parallel to an actuator pulls at it: with k (q − q_0)/r at each sample, r = 1 where nothing is between.
#[derive(Debug, Clone, Copy)]
pub struct Pull<'j> {
    /// The spring's angle at each sample \[rad\], q.
    pub position: &'j [f64],
    velocity: &'j [f64],
    passed: Option<&'j Passed>,
}

impl Pull<'_> {
    /// Of a spring of 1 N·m/rad at sample k: what its angle gives at the actuator \[N·m\], and what one radian of its rest angle
    /// takes of that.
    pub fn torque(&self, k: usize) -> [f64; 2] {
        let per = self.passed.map_or(1.0, |passed| passed.per_torque(k).0);
        [self.position[k] * per, per]
    }

    /// Rates of the two \[N·m/s\].
    pub fn rate(&self, k: usize) -> [f64; 2] {
        let (per, rate) = self.passed.map_or((1.0, 0.0), |passed| passed.per_torque(k));
        [self.velocity[k] * per + self.position[k] * rate, rate]
    }
}

/// Which rows of a catalogue may be chosen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Filter {
    /// Patterns of which one has to match; empty for all.
    pub allowed: Vec<String>,
    /// Patterns of which none may match.
    pub excluded: Vec<String>,
    /// Which windings of them.
    pub turns: Windings,
    /// Patterns of modules of which one has to match; empty for none.
    pub modules: Vec<String>,
    /// Whether modules alone may be chosen.
    pub only_modules: bool,
    /// Patterns of the motors that the joint's family of gears is made for; empty for all.
    pub made_for: Vec<String>,
}

impl Filter {
    /// Whether a motor may be chosen: by its id, or by its maker in letters of either case.
    pub fn allows(&self, motor: &Motor) -> bool {
        let is = |pattern: &String| Filter::matches(pattern, motor);
        if let Some(inside) = motor.inside.as_deref() {
            return self.takes(&inside.module);
        }
        !self.only_modules
            && self.turns.allow(motor)
            && (self.allowed.is_empty() || self.allowed.iter().any(is))
            && !self.excluded.iter().any(is)
    }

    /// Whether the joint's family of gears is made for a motor.
    pub fn is_made_for(&self, motor: &Motor) -> bool {
        self.made_for.is_empty() || self.made_for.iter().any(|pattern| matches_pattern(pattern, motor.machine_id()))
    }

    /// Whether a module may be chosen.
    pub fn takes(&self, module: &Module) -> bool {
        let is = |pattern: &String| module.matches(pattern);
        self.modules.iter().any(is) && !self.excluded.iter().any(is)
    }

    /// Whether a motor is passed over without a word: a winding that is none of this joint, a module where none is asked for, or a
    /// motor where modules alone are.
    pub fn pass_over(&self, motor: &Motor) -> bool {
        match motor.inside.is_some() {
            true => !self.allows(motor),
            false => self.only_modules || self.turns.pass_over(motor),
        }
    }

    /// Whether a pattern is of a motor.
    pub fn matches(pattern: &str, motor: &Motor) -> bool {
        is_named(pattern, &motor.id, &motor.manufacturer) || matches_pattern(pattern, motor.row_id())
    }

    /// Every pattern of motors.
    pub fn patterns(&self) -> impl Iterator<Item = &String> {
        self.allowed.iter().chain(&self.excluded)
    }
}

impl Robot {
    /// Patterns of the modules that joints may have.
    pub fn modules(&self) -> impl Iterator<Item = &String> {
        self.joints.iter().flat_map(|joint| &joint.motors.modules)
    }

    /// Whether a joint may have any number of turns between two.
    pub fn has_range_of_turns(&self) -> bool {
        self.joints.iter().any(|joint| joint.motors.turns.range().is_some())
    }

    /// Numbers of turns that joints list beside that of the row, each once, ascending.
    pub fn listed_turns(&self) -> Vec<f64> {
        let mut turns: Vec<f64> = self.joints.iter().flat_map(|joint| joint.motors.turns.listed()).copied().collect();
        turns.retain(|a| *a != 1.0);
        turns.sort_by(f64::total_cmp);
        turns.dedup();
        turns
    }
}

impl Joint {
    /// The gear map of a named family, where the ratio lies between its points or at one of them.
    pub fn family_map(&self) -> Option<&GearMap> {
        self.gear_map.as_deref().filter(|map| map.is_named())
    }

    /// Whether its gears are ones that somebody published, and not one that the requirement describes.
    pub fn has_published_gears(&self) -> bool {
        self.ratio.is_catalog() || self.family_map().is_some()
    }

    /// The same with a spring of a stiffness \[N·m/rad\] and a rest angle \[rad\] taking its part of the load; `None` where
    /// the motion says no position.
    pub fn with_spring(&self, stiffness: f64, rest_angle: f64) -> Option<Joint> {
        if let Some(passed) = self.passed.as_deref().filter(|p| p.numbers.is_lossy() && self.spring_is_at_joint()) {
            // What the transmission loses follows the direction of the power that is left.
            let moved = passed.motion().with_spring(stiffness, rest_angle)?;
            let Via::One(way) = passed.via.clone() else { return None };
            let (mut motion, passed) = Passed::new(&Transmission { way, numbers: passed.numbers }, &moved).ok()?;
            motion.sprung = true;
            return Some(Joint { motion: motion.into(), passed: Some(passed.into()), ..self.clone() });
        }
        let pull = self.pull()?;
        let mut motion = Motion::clone(&self.motion);
        motion.sprung = true;
        for k in 0..motion.len() {
            let ([q, per], [speed, per_rate]) = (pull.torque(k), pull.rate(k));
            motion.torque[k] += stiffness * (q - rest_angle * per);
            motion.torque_rate[k] += stiffness * (speed - rest_angle * per_rate);
        }
        Some(Joint { motion: motion.into(), ..self.clone() })
    }

    /// The same with all torques of its motion times `torque`, played `speed` times as fast ([`Motion::scaled`]).
    #[must_use]
    pub fn scaled(mut self, torque: f64, speed: f64) -> Joint {
        let again = self.passed.as_deref().and_then(|passed| {
            let motions: Vec<Motion> =
                passed.joints.iter().map(|(_, motion)| Motion::clone(motion).scaled(torque, speed)).collect();
            // The same angles as before: nothing of them can be wrong.
            passed.again(&motions).ok()
        });
        match again {
            Some((motion, passed)) => (self.motion, self.passed) = (motion.into(), Some(passed.into())),
            None => self.motion = Motion::clone(&self.motion).scaled(torque, speed).into(),
        }
        // What is carried weighs the same; only its course runs faster.
        for carried in &mut self.carries {
            carried.rate.iter_mut().for_each(|rate| *rate *= speed);
        }
        self
    }

    /// What the joint does itself, before its transmission where it has one; of two joints that are coupled each with its name.
    pub fn own_motions(&self) -> Vec<(&str, &Motion)> {
        match self.passed.as_deref() {
            None => vec![("", &self.motion)],
            Some(passed) => passed.joints.iter().map(|(name, motion)| (name.as_str(), motion.as_ref())).collect(),
        }
    }

    /// What is largest at each joint that a transmission moves, and at each of its actuators; both empty where nothing is between.
    pub fn peaks(&self) -> [Vec<Peaks<'_>>; 2] {
        if self.passed.is_none() {
            return Default::default();
        }
        let peaks = |of, (torque, speed)| Peaks { of, torque, speed };
        let joints = self.own_motions().into_iter().map(|(of, motion)| peaks(of, motion.peaks_in(0..motion.len())));
        let actuators = match self.motion.cases.as_deref().filter(|cases| cases.together) {
            Some(both) => both.list.iter().map(|case| peaks(case.name.as_str(), self.motion.peaks(case))).collect(),
            None => vec![peaks("", self.motion.peaks_in(0..self.motion.len()))],
        };
        [joints.collect(), actuators]
    }

    /// How a parallel spring of the joint pulls at its actuator; `None` where the motion says no position.
    pub fn pull(&self) -> Option<Pull<'_>> {
        let passed = self.passed.as_deref().filter(|_| self.spring_is_at_joint());
        let motion = passed.map_or(&self.motion, |passed| passed.motion());
        Some(Pull { position: motion.position.as_deref()?, velocity: &motion.velocity, passed })
    }

    /// Whether a spring of the joint pulls behind its transmission.
    fn spring_is_at_joint(&self) -> bool {
        self.limits.spring.is_none_or(|spring| spring.at == SpringAt::Joint)
    }

    /// The torque on top of the motion that the joint asks for, as it arrives at the actuator.
    pub fn ripple(&self) -> Option<Ripple<'_>> {
        let passed = self.passed.as_deref();
        self.limits.torque_bandwidth.map(|bandwidth| Ripple { bandwidth, passed })
    }

    /// What is minimised, in a word or a few: `balanced`, or the name of the objective.
    pub fn goal(&self) -> String {
        match self.balancing {
            Balancing::Made(_) => "balanced".into(),
            _ => self.objective.name(),
        }
    }

    /// What is aimed at: `balanced loss and mass`, or the least of the objective.
    pub fn aim(&self) -> String {
        match self.balancing {
            Balancing::Made(_) => "balanced loss and mass".into(),
            _ => format!("least {}", self.objective.name()),
        }
    }

    /// Whether another joint, looked at by itself, asks the same of its actuator: whatever its name, however
    /// many there are, when they move and whatever they carry.
    pub fn asks_the_same(&self, other: &Joint) -> bool {
        let Joint {
            name: _,
            count: _,
            ratio,
            gear,
            gear_map,
            motors,
            motion,
            passed,
            objective,
            balancing,
            limits,
            drive_current,
            drive,
            motor_drag,
            turns,
            phases: _,
            carries: _,
        } = self;
        *ratio == other.ratio
            && *gear == other.gear
            && *gear_map == other.gear_map
            && *motors == other.motors
            && *objective == other.objective
            && *balancing == other.balancing
            && *limits == other.limits
            && *drive_current == other.drive_current
            && *drive == other.drive
            && *motor_drag == other.motor_drag
            && *turns == other.turns
            && *motion == other.motion
            && *passed == other.passed
    }
}

/// What all joints of a robot do at the same time.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotCase {
    /// Name.
    pub name: String,
    /// For each joint which of its cases it is in; `None` where it has none, or may be in any of them.
    pub cases: Vec<Option<usize>>,
}

impl Robot {
    /// What the joints do together: name, and which of its cases each joint is in (`None` where it has none, or may be in
    /// any). What `[[case]]` does not tell of, happens together by name.
    pub fn scenarios(&self) -> Vec<(Option<String>, Vec<Option<usize>>)> {
        let mut all: Vec<(Option<String>, Vec<Option<usize>>)> =
            self.cases.iter().map(|case| (Some(case.name.clone()), case.cases.clone())).collect();
        // What the robot's own cases leave out happens by its name.
        let is_told = |joint: usize, case: usize| self.cases.iter().any(|told| told.cases[joint] == Some(case));
        let is_left = |name: &str| {
            let of = |(j, joint): (usize, &Joint)| case_named(joint, name).is_some_and(|case| !is_told(j, case));
            self.joints.iter().enumerate().any(of)
        };
        let mut names: Vec<&str> = Vec::new();
        let load_cases = self.joints.iter().filter_map(|j| j.motion.cases.as_ref()).filter(|cases| !cases.together);
        for case in load_cases.flat_map(|cases| &cases.list) {
            if !names.contains(&case.name.as_str()) {
                names.push(&case.name);
            }
        }
        let together = |name: &str| self.joints.iter().map(|joint| case_named(joint, name)).collect();
        let left = names.into_iter().filter(|name| is_left(name));
        all.extend(left.map(|name| (Some(name.to_string()), together(name))));
        if all.is_empty() {
            return vec![(None, vec![None; self.joints.len()])];
        }
        all
    }
}

/// Which of a joint's load cases has a name.
pub(super) fn case_named(joint: &Joint, name: &str) -> Option<usize> {
    let cases = joint.motion.cases.as_ref().filter(|cases| !cases.together)?;
    cases.list.iter().position(|case| case.name == name)
}
