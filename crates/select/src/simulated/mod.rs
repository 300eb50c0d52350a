//! A chosen design as a simulator has it: what the actuator is at its joint, in numbers at the output.
//!
//! The one idea: the electromagnetic torque `K_T i` is what a simulator's actuator commands. It turns, times N,
//! the armature `N² (J_m + J_g)` against damping, friction loss and the load. Everything of the model that has
//! no place in that equation is listed with the reason, never dropped.

mod facts;
mod figures;
mod line;
pub mod spread;

pub use facts::Fact;
pub use figures::Figures;
pub use line::Line;

use gearwise_model::actuator::limits::{Candidate, hottest};
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::convention::Commutation;
use gearwise_model::catalog::drag::Drag;
use gearwise_model::catalog::module::{BUILT_IN, Inside};
use gearwise_model::effects::{EFFECTS, Effect, Side, SimulatorField};
use gearwise_model::requirement::FamilyPlace;
use gearwise_model::transmission::{Passed, Via};

/// A largest value and whose limit it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The value, SI.
    pub value: f64,
    /// Whose limit it is.
    pub owner: &'static str,
}

/// Something that the simulator's joint does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// The fact that it is of: a format that says it does not leave it out. `None` for what is not known, which none can say.
    pub fact: Option<Fact>,
    /// What.
    pub what: String,
    /// Why, or where it would have to go.
    pub why: String,
}

/// Cogging of one order, at the motor: torque `amplitude sin(order θ + phase)` on the rotor at its angle θ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cog {
    /// Periods a revolution of the rotor.
    pub order: f64,
    /// Amplitude \[N·m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// Numbers of a joint by name.
pub type Numbers = [(&'static str, Option<f64>); 7];

/// How the winding heats, as one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat {
    /// Thermal resistance from winding to ambient \[K/W\].
    pub resistance: f64,
    /// Time constant of the housing, with which the winding follows in the long run \[s\]; `None` where the row says none.
    pub time_constant: Option<f64>,
    /// Ambient temperature \[K\].
    pub ambient: f64,
}

/// The winding as a simulator of motors takes it, at the motor, on the q axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Resistance at the reference temperature \[Ω\].
    pub resistance: f64,
    /// Temperature of that resistance \[K\].
    pub reference: f64,
    /// Temperature that the torque–speed line is made for: the highest allowed \[K\].
    pub hottest: f64,
    /// L/R \[s\]; `None` where the inductance is not known.
    pub time_constant: Option<f64>,
}

/// An actuator at its joint. SI; at the output unless said.
#[derive(Debug, Clone)]
pub struct SimulatedJoint {
    /// Ratio, N; behind a transmission of one ratio N r.
    pub ratio: f64,
    /// Rotor inertia J_m and the gear's at its input, J_g, both at the motor \[kg·m²\]; `None` for a module that does not say its own.
    pub inertias: Option<(f64, f64)>,
    /// Reflected inertia \[kg·m²\], `N² (J_m + J_g)`; likewise.
    pub armature: Option<f64>,
    /// Viscous friction of motor and gear \[N·m·s/rad\], `N² b`; `None` where neither is known.
    pub damping: Option<f64>,
    /// Coulomb friction of motor and gear \[N·m\], `N c`; `None` where neither is known.
    pub friction_loss: Option<f64>,
    /// What friction has more at rest \[N·m\], where that is known.
    pub friction_at_rest: Option<f64>,
    /// Largest electromagnetic torque \[N·m\] at the motor that motor, drive and gear allow.
    pub motor_torque: Option<Bound>,
    /// Torque at the motor that can be held for ever \[N·m\].
    pub continuous_motor_torque: Option<Bound>,
    /// Largest speed \[rad/s\] that motor, gear and voltage allow.
    pub speed: Bound,
    /// Speed up to which the voltage suffices for the largest torque \[rad/s\]; `None` where no largest torque
    /// is known.
    pub speed_at_motor_torque: Option<f64>,
    /// Largest torque at the motor whatever the voltage \[N·m\]: while the load drives, the back-EMF helps.
    pub braking_motor_torque: Option<Bound>,
    /// Largest speed that motor, gear and transmission allow whatever the voltage \[rad/s\].
    pub mechanical_speed: Option<Bound>,
    /// Torque over speed as simulators draw it; `None` where largest torque, its speed or the speed without load is not known.
    pub line: Option<Line>,
    /// The highest line that promises nothing too much.
    pub line_below: Option<Line>,
    /// Elasticity of the gear \[N·m/rad\], where it is known.
    pub stiffness: Option<f64>,
    /// Play of the gear, from stop to stop \[rad\], where it is known.
    pub backlash: Option<f64>,
    /// Cogging, the largest order first.
    pub cogging: Vec<Cog>,
    /// The winding; `None` for a module that says ratings alone.
    pub winding: Option<Winding>,
    /// How it heats, where that is known.
    pub heat: Option<Heat>,
    /// Torque constant \[N·m/A\] on the q axis; `None` for a module that says ratings alone.
    pub torque_constant: Option<f64>,
    /// Gear efficiencies when the motor drives, η, and when the load drives, η_b; `None` for a module whose row does not say them.
    pub efficiencies: Option<(f64, f64)>,
    /// Efficiencies of the transmission behind it, driving and driven; one where nothing is said.
    pub transmission_efficiencies: (f64, f64),
    /// Whether the joint turns against the actuator, by a transmission.
    pub is_reversed: bool,
    /// Whether the largest torque is a module's rating at its flange, with its gear's loss in it.
    pub is_behind_loss: bool,
    /// Of a transmission whose ratio goes with the angle, over the angles of the motion: angle of the joint \[rad\], turns of the motor
    /// for one of the joint there, and the largest torque at the joint there \[N·m\], before the gear's loss. Empty for others.
    pub over_angle: Vec<[f64; 3]>,
    /// Whether the numbers are those of the actuator before a transmission, because at the joint they go with the angle.
    pub is_before_the_joint: bool,
    /// What has no place at a simulator's joint.
    pub left_out: Vec<LeftOut>,
}

impl SimulatedJoint {
    /// The actuator of a candidate at a ratio.
    pub fn new(candidate: &Candidate, ratio: f64) -> SimulatedJoint {
        if candidate.whole_map().is_some() {
            return candidate.at_ratio(ratio, |here| SimulatedJoint::new(here, ratio));
        }
        let motor = candidate.motor;
        let rotor_inertia = motor.rotor_inertia.unwrap_or(candidate.actuator.inertia);
        let says_inertia = inside(candidate).is_none_or(|inside| inside.says_inertia);
        let says_currents = inside(candidate).is_none_or(Inside::says_currents);
        let inertia = candidate.actuator.inertia;
        let mut joint = SimulatedJoint {
            ratio,
            inertias: says_inertia.then_some((rotor_inertia, inertia - rotor_inertia)),
            armature: says_inertia.then_some(ratio * ratio * inertia),
            damping: None,
            friction_loss: None,
            motor_torque: peak_torque(candidate, ratio),
            continuous_motor_torque: continuous_torque(candidate, ratio),
            speed: largest_speed(candidate, ratio),
            speed_at_motor_torque: None,
            friction_at_rest: None,
            braking_motor_torque: braking_torque(candidate, ratio),
            mechanical_speed: mechanical_speed(candidate, ratio),
            line: None,
            line_below: None,
            stiffness: candidate.catalog_gear.and_then(|gear| gear.stiffness),
            backlash: candidate.catalog_gear.and_then(|gear| gear.backlash),
            cogging: Vec::new(),
            winding: says_currents.then(|| winding(candidate)),
            heat: heat(candidate),
            torque_constant: says_currents.then_some(candidate.actuator.torque_constant),
            efficiencies: inside(candidate)
                .is_none_or(|inside| inside.gear_loss.is_some())
                .then_some((candidate.gear.efficiency, candidate.gear.backdrive_efficiency)),
            transmission_efficiencies: (1.0, 1.0),
            is_reversed: false,
            is_behind_loss: false,
            over_angle: Vec::new(),
            is_before_the_joint: false,
            left_out: Vec::new(),
        };
        joint.is_behind_loss = joint.motor_torque.is_some_and(|torque| torque.owner == MODULE);
        joint.speed_at_motor_torque =
            joint.motor_torque.and_then(|torque| speed_at_torque(candidate, torque.value, ratio));
        for (effect, values) in effects(candidate) {
            joint.add(effect, &values);
        }
        let drag = no_load_friction(motor);
        if let NoLoad::Coulomb(torque) = drag {
            *joint.friction_loss.get_or_insert(0.0) += torque * ratio;
        }
        if let Some(module) = inside(candidate).map(|inside| &inside.module).filter(|_| joint.friction_loss.is_none())
            && let Some(at_rest) = module.at_output(module.sheet.static_friction, module.refers.friction_side, 1)
        {
            joint.friction_loss = Some(at_rest);
            joint.leave_out(None, "friction while it moves", "the row says friction at rest alone, which is written");
        }
        let of_gear = candidate.gear.no_load;
        let frictions = [
            ("viscous friction", &mut joint.damping, of_gear.viscous * ratio * ratio),
            (COULOMB, &mut joint.friction_loss, of_gear.coulomb * ratio),
        ];
        let mut unknown = Vec::new();
        for (name, value, of_gear) in frictions {
            if value.is_none() {
                let what = if of_gear > 0.0 { "only the gear's" } else { "nothing" };
                let number = gearwise_model::words::number;
                let known = match drag {
                    NoLoad::AtMost(torque) if name == COULOMB => {
                        format!(
                            "the motor's is 0 to {} N*m: how much of its drag grows with speed is not known",
                            number(torque * ratio)
                        )
                    }
                    _ => "the motor's is not known".into(),
                };
                unknown.push((name, format!("{known}; {what} is written")));
            }
            if of_gear > 0.0 {
                *value.get_or_insert(0.0) += of_gear;
            }
        }
        unknown.into_iter().for_each(|(name, why)| joint.leave_out(None, name, why));
        joint.cogging.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        joint.pass_on(candidate);
        joint.draw_lines(candidate, ratio);
        joint.leave_out_the_gear(candidate);
        joint.leave_out_the_drive(candidate);
        joint
    }

    /// Takes an actuator to the joint behind its transmission, where that has one ratio; where it has none the numbers stay those of the
    /// actuator, which is said.
    fn pass_on(&mut self, candidate: &Candidate) {
        let Some(passed) = candidate.joint.passed.as_deref() else { return };
        let number = gearwise_model::words::number;
        self.transmission_efficiencies = (passed.numbers.efficiency, passed.numbers.backdrive_efficiency);
        if passed.numbers.is_lossy() {
            let what = format!("efficiency {} of the transmission", number(passed.numbers.efficiency));
            self.leave_out(Fact::GearLoss, what, "a joint has no loss in proportion to the load");
        }
        let Some(signed) = passed.constant() else {
            self.is_before_the_joint = true;
            self.over_angle = self.along(passed);
            let range = match passed.ratio() {
                Some(range) => {
                    format!("torque at the joint is r times, speed 1/r times, armature r² times, with r = {} to {} over the motion", number(range.least.0), number(range.most.0))
                }
                None => "two actuators move two joints: at the joints torque is Jᵀ, armature Jᵀ J times that of the actuators".into(),
            };
            let why = format!(
                "the numbers written are those of the actuator before it; {range}; a model needs the links themselves"
            );
            return self.leave_out(Fact::Transmission, format!("transmission ({})", passed.word()), why);
        };
        let r = signed.abs();
        self.is_reversed = signed < 0.0;
        if self.is_reversed {
            self.leave_out(None, "direction", format!("r = {}: the joint turns against the actuator", number(signed)));
        }
        let at_joint = |bound: Bound| Bound { value: bound.value / r, ..bound };
        self.armature = self.armature.map(|own| passed.inertia_at_joint(own));
        self.damping = self.damping.map(|b| b * r * r);
        self.friction_loss = self.friction_loss.map(|c| c * r);
        self.friction_at_rest = self.friction_at_rest.map(|c| c * r);
        // In series with what the transmission has of its own.
        let own = passed.numbers;
        self.stiffness = match (self.stiffness.map(|k| k * r * r), own.stiffness) {
            (Some(gear), Some(own)) => Some(gear * own / (gear + own)),
            (gear, own) => gear.or(own),
        };
        self.backlash = match (self.backlash.map(|play| play / r), own.backlash) {
            (Some(gear), Some(own)) => Some(gear + own),
            (gear, own) => gear.or(own),
        };
        self.speed = at_joint(self.speed);
        self.mechanical_speed = self.mechanical_speed.map(at_joint);
        self.speed_at_motor_torque = self.speed_at_motor_torque.map(|speed| speed / r);
        let gear_ratio = self.ratio;
        self.ratio *= r;
        // What turns with the transmission counts as if it were the gear's: N r squared times both is the armature.
        let squared = self.ratio * self.ratio;
        self.inertias = self.inertias.zip(self.armature).map(|((rotor, _), all)| (rotor, all / squared - rotor));
        if let Some(most) = passed.numbers.max_input_speed.map(|most| most / r).filter(|most| *most < self.speed.value)
        {
            self.speed = Bound { value: most, owner: "transmission" };
            self.speed_at_motor_torque = self.speed_at_motor_torque.map(|speed| speed.min(most));
        }
        let most = passed.numbers.max_input_speed.map(|most| Bound { value: most / r, owner: "transmission" });
        self.mechanical_speed = least([self.mechanical_speed, most]);
        if let Some(most) = passed.numbers.peak_torque.map(|most| most / self.ratio) {
            for torque in [&mut self.motor_torque, &mut self.braking_motor_torque, &mut self.continuous_motor_torque] {
                // An unknown continuous torque stays unknown: it may be below the peak torque of the transmission.
                let known =
                    torque.map(|torque| least([Some(torque), Some(Bound { value: most, owner: "transmission" })]));
                *torque = known.unwrap_or(None);
            }
            // The corner is that of the torque that is left.
            let corner = self.motor_torque.and_then(|torque| speed_at_torque(candidate, torque.value, gear_ratio));
            self.speed_at_motor_torque = corner.map(|speed| (speed / r).min(self.speed.value));
        }
    }

    /// Ratio and largest torque over the angles of the motion; nothing of two joints on two actuators.
    fn along(&self, passed: &Passed) -> Vec<[f64; 3]> {
        let (Via::One(way), Some(effort)) = (&passed.via, self.effort()) else { return Vec::new() };
        let Some(position) = &passed.motion().position else { return Vec::new() };
        let ends = position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), q| (a.min(*q), b.max(*q)));
        let angles = (0..=ANGLES).map(|k| ends.0 + (ends.1 - ends.0) * k as f64 / ANGLES as f64);
        let most = passed.numbers.peak_torque.unwrap_or(f64::INFINITY);
        let at = |q: f64| {
            let r = way.at(q).ok()?.ratio.abs();
            Some([q, self.ratio * r, (effort.value * r).min(most)])
        };
        if ends.1 > ends.0 { angles.filter_map(at).collect() } else { Vec::new() }
    }

    /// The lines of torque over speed, through the corner at which the voltage leaves the largest torque: at the joint, or before
    /// a transmission that has no one ratio.
    fn draw_lines(&mut self, candidate: &Candidate, ratio: f64) {
        let Some((torque, no_load)) = self.motor_torque.zip(no_load_speed(candidate, ratio)) else { return };
        // What the output turns, the joint turns r times less; `ratio` is that of the gear alone.
        let behind = self.ratio / ratio;
        let speed_at = |at_output: f64| speed_at_torque(candidate, at_output / ratio, ratio);
        let Some(line) = Line::new(torque.value * ratio, no_load, speed_at) else {
            self.line_below = Line::triangle(torque.value * ratio, no_load).map(|line| line.behind(behind));
            return;
        };
        self.line_below = Some(line.below(speed_at).behind(behind));
        self.line = Some(line.behind(behind));
    }

    /// What arrives at a load that the motor drives, and what holds against a load that drives, per torque that is written; `None`
    /// where the gear's loss is not known.
    pub fn load_factors(&self) -> Option<(f64, f64)> {
        let gear = if self.is_behind_loss { Some((1.0, 1.0)) } else { self.efficiencies };
        let (behind, backwards) = self.transmission_efficiencies;
        gear.map(|(efficiency, driven)| (efficiency * behind, held(driven) * held(backwards)))
    }

    /// Largest torque at the output while the load drives \[N·m\], before the gear's loss.
    pub fn braking_effort(&self) -> Option<Bound> {
        self.braking_motor_torque.map(|b| Bound { value: b.value * self.ratio, ..b })
    }

    /// The numbers that ranges and draws are of, by name; SI, at the joint. Of the line that promises nothing too much, and behind the
    /// losses, where that is wished.
    pub fn numbers(&self, is_below: bool, is_behind_losses: bool) -> Numbers {
        let line = if is_below { self.line_below } else { self.line };
        let driving = self.load_factors().map_or(1.0, |(driving, _)| driving);
        let factor = if is_behind_losses { driving } else { 1.0 };
        let effort = line.filter(|_| is_below).map(|l| l.effort).or(self.effort().map(|b| b.value));
        [
            ("armature", self.armature),
            ("damping", self.damping),
            ("friction_loss", self.friction_loss),
            ("effort", effort.map(|effort| effort * factor)),
            ("saturation_effort", line.map(|l| l.stall * factor)),
            ("no_load_speed", line.map(|l| l.no_load)),
            ("torque_constant", self.torque_constant),
        ]
    }

    /// Largest torque at the output \[N·m\] before the gear's loss, `N T`.
    pub fn effort(&self) -> Option<Bound> {
        self.motor_torque.map(|b| Bound { value: b.value * self.ratio, ..b })
    }

    /// Torque at the output that can be held for ever \[N·m\], before the gear's loss.
    pub fn continuous_effort(&self) -> Option<Bound> {
        self.continuous_motor_torque.map(|b| Bound { value: b.value * self.ratio, ..b })
    }

    fn leave_out(&mut self, fact: impl Into<Option<Fact>>, what: impl Into<String>, why: impl Into<String>) {
        self.left_out.push(LeftOut { fact: fact.into(), what: what.into(), why: why.into() });
    }

    /// Puts an effect where it says that a simulator keeps it.
    fn add(&mut self, effect: &dyn Effect, values: &[f64]) {
        match effect.export(values, self.ratio) {
            SimulatorField::Damping(value) => *self.damping.get_or_insert(0.0) += value,
            SimulatorField::FrictionLoss(value) => *self.friction_loss.get_or_insert(0.0) += value,
            SimulatorField::FrictionAtRest(value) => {
                *self.friction_at_rest.get_or_insert(0.0) += value;
                self.leave_out(Fact::FrictionAtRest, told(effect, values), "a simulator's joint has no such term");
            }
            SimulatorField::Stiffness(value) => {
                self.stiffness = Some(value);
                self.leave_out(
                    Fact::Compliance,
                    told(effect, values),
                    format!(
                        "a stiffness of {} N*m/rad between motor and output needs a body for the rotor and a joint of its own",
                        gearwise_model::words::number(value)
                    ),
                );
            }
            SimulatorField::Play(value) => {
                self.backlash = Some(value);
                self.leave_out(Fact::Backlash, told(effect, values), "a simulator's joint has no such term");
            }
            SimulatorField::Cogging { order, cosine, sine } => {
                // The motor has to supply a cos + b sin more: that much pulls at the rotor the other way.
                let (amplitude, phase) = (cosine.hypot(sine), (-cosine).atan2(-sine));
                self.cogging.push(Cog { order, amplitude, phase });
                self.leave_out(Fact::Cogging, told(effect, values), "a simulator's joint has no such term");
            }
            SimulatorField::Efficiency => {
                self.leave_out(Fact::GearLoss, told(effect, values), "it is the gear's efficiency, see there");
            }
            SimulatorField::Nowhere => {
                self.leave_out(Fact::OtherEffects, told(effect, values), "a simulator's joint has no such term");
            }
        }
    }

    fn leave_out_the_gear(&mut self, candidate: &Candidate) {
        if self.armature.is_none() {
            let why = "the module's own inertia is not known: none is written, and a simulator takes none for it; measure or ask for it";
            self.leave_out(None, "armature", why);
        }
        let number = gearwise_model::words::number;
        if let Some((efficiency, backwards)) = self.efficiencies.filter(|both| *both != (1.0, 1.0)) {
            let what = format!("gear efficiency {}, backwards {}", number(efficiency), number(backwards));
            // What a module's row rates has the gear's loss in it.
            let before = self.effort().filter(|_| !self.is_behind_loss);
            let factor = self.load_factors().map_or(efficiency, |(driving, _)| driving);
            let loss = before.map_or_else(String::new, |effort| {
                format!(
                    ": of {} N*m at most {} N*m reach a load that the motor drives",
                    number(effort.value),
                    number(effort.value * factor)
                )
            });
            self.leave_out(Fact::GearLoss, what, format!("a joint has no loss in proportion to the load{loss}"));
        }
        if let Some(inside) = inside(candidate).filter(|inside| !inside.says_loss()) {
            let why = "the module's row does not say it: less than N K_T i may arrive at the output";
            self.leave_out(None, format!("loss of the gear of {}", inside.module.id), why);
        }
        let family = candidate.joint.family_map().filter(|_| candidate.catalog_gear.is_none());
        if let Some(FamilyPlace::Between(below, above)) = family.and_then(|map| map.place(self.ratio)) {
            self.leave_out(
                None,
                format!("that the gear lies between {} and {}", below.id, above.id),
                "nobody published it: its numbers are interpolated",
            );
        }
        if family.is_some_and(|map| !map.says(|row| row.inertia)) {
            self.leave_out(None, "gear inertia", "no point of its family says it; the armature is the rotor's alone");
        }
        let Some(gear) = candidate.catalog_gear else { return };
        if let Some(backlash) = gear.backlash {
            self.leave_out(
                Fact::Backlash,
                format!("backlash {} rad", number(backlash)),
                "a joint has no play; a second joint with that range in series would have it",
            );
        }
        if let Some(stiffness) = gear.stiffness {
            self.leave_out(
                Fact::Compliance,
                format!("gear stiffness {} N*m/rad", number(stiffness)),
                "it needs a body for the rotor and a joint of its own",
            );
        }
        if gear.inertia.is_none() && gear.id != BUILT_IN {
            self.leave_out(None, "gear inertia", "the catalogue does not say it; the armature is the rotor's alone");
        }
    }

    fn leave_out_the_drive(&mut self, candidate: &Candidate) {
        let number = gearwise_model::words::number;
        let motor = candidate.motor;
        let peak = self.speed_at_motor_torque.map_or_else(String::new, |speed| {
            format!(
                "; the largest torque can be had up to {} rad/s, with the winding as hot as it may be",
                number(speed)
            )
        });
        match inside(candidate) {
            Some(inside) => self.leave_out(
                Fact::TorqueSpeed,
                "torque that falls with speed",
                match inside.module.driving_curve.as_slice() {
                    [] => format!("without load it turns with {} rad/s{peak}", number(self.speed.value)),
                    curve => {
                        let point = |[speed, torque]: &[f64; 2]| format!("{} : {}", number(*speed), number(*torque));
                        let points = curve.iter().map(point).collect::<Vec<_>>().join(", ");
                        let volt = inside
                            .module
                            .sheet
                            .voltage
                            .map_or_else(String::new, |v| format!(" at {} V", number(v.value)));
                        format!("rad/s : N*m of its row{volt} are {points}{peak}")
                    }
                },
            ),
            None => self.leave_out(
                Fact::TorqueSpeed,
                "torque that falls with speed",
                format!(
                    "the voltage ends all torque at {} rad/s{peak}",
                    number(candidate.voltage() / motor.emf_constant() / self.ratio)
                ),
            ),
        }
        match motor.inductance.filter(|_| self.torque_constant.is_some()) {
            Some(inductance) => self.leave_out(
                Fact::ElectricalTime,
                format!("electrical time constant {} ms", number(1e3 * inductance / motor.resistance)),
                "the command is the torque itself: the drive's current loop is taken as ideal",
            ),
            None => self.leave_out(None, "electrical time constant", "the motor's inductance is not known"),
        }
        if candidate.weakening().is_some() {
            let why = "the line of torque over speed ends where the voltage without it ends: a drive that weakens the field goes on beyond";
            self.leave_out(None, "field weakening", why);
        }
        if self.motor_torque.is_none() {
            self.leave_out(None, "largest torque", "neither motor nor drive nor gear says one");
        }
        match self.continuous_effort() {
            Some(bound) => self.leave_out(
                Fact::ContinuousTorque,
                "heating",
                format!("{} N*m continuous (by the {})", number(bound.value), bound.owner),
            ),
            None => self.leave_out(None, "heating", "the continuous torque is not known"),
        }
    }
}

/// An effect with its values, as people read it.
fn told(effect: &dyn Effect, values: &[f64]) -> String {
    let parts = effect.parameters().iter().zip(values).map(|(p, v)| {
        let unit = if p.kind.si == "1" { String::new() } else { format!(" {}", p.kind.si) };
        format!("{} = {}{unit}", p.symbol, gearwise_model::words::number(*v))
    });
    format!("{}: {} with {}", effect.name(), effect.equation(), parts.collect::<Vec<_>>().join(", "))
}

fn inside<'c>(candidate: &Candidate<'c>) -> Option<&'c Inside> {
    candidate.motor.inside.as_deref()
}

/// Owner of a bound that a module's row rates at its flange.
const MODULE: &str = "module";

/// What a module's row lets it give, as the motor's: its ratings are those of the flange, with its losses in them.
fn of_module(candidate: &Candidate, ratio: f64, rating: impl Fn(&Inside) -> Option<f64>) -> Option<Bound> {
    Some(Bound { value: rating(inside(candidate)?)? / ratio, owner: MODULE })
}

/// Intervals of a table over the angle.
const ANGLES: usize = 32;

fn least(bounds: impl IntoIterator<Item = Option<Bound>>) -> Option<Bound> {
    // A number that nobody knows is no bound.
    bounds.into_iter().flatten().filter(|b| b.value.is_finite()).min_by(|a, b| a.value.total_cmp(&b.value))
}

/// Largest torque at the motor: of its row, of the current of motor, drive and voltage, of the gear's output over N.
/// No safety factor: it is the limit itself.
fn peak_torque(candidate: &Candidate, ratio: f64) -> Option<Bound> {
    let module = of_module(candidate, ratio, |inside| inside.module.largest_torque());
    let voltage = Bound { value: stall_torque(candidate), owner: "voltage at standstill" };
    least([module, braking_torque(candidate, ratio), Some(voltage)])
}

/// Torque at the motor \[N·m\] for which the voltage suffices at standstill, with the winding as hot as it may be, and drive, leads and
/// supply in series: as the line of torque over speed has it.
fn stall_torque(candidate: &Candidate) -> f64 {
    let actuator = &candidate.actuator;
    let resistance = actuator.resistance_per_torque() * actuator.torque_constant;
    let stiff = actuator.torque_constant * actuator.shortfall.left_of_current(candidate.voltage() / resistance, 1.0);
    if !stiff.is_finite() || candidate.supply(0.0).is_none() {
        return stiff;
    }
    let (mut enough, mut too_much) = (0.0, stiff);
    for _ in 0..60 {
        let middle = 0.5 * (enough + too_much);
        if speed_by_voltage(candidate, middle) > 0.0 { enough = middle } else { too_much = middle }
    }
    enough
}

/// The same whatever the voltage.
fn braking_torque(candidate: &Candidate, ratio: f64) -> Option<Bound> {
    let actuator = &candidate.actuator;
    let shortfall = &actuator.shortfall;
    let current = candidate.peak_current().map(|(current, owner)| Bound {
        value: actuator.torque_constant * shortfall.left_of_current(current, 1.0),
        owner,
    });
    let torque = candidate.motor.peak_torque.map(|t| Bound { value: shortfall.left_of_torque(t, 1.0), owner: "motor" });
    let gear = candidate.gear.peak_torque.map(|t| Bound { value: t / ratio, owner: "gear" });
    // While the load drives, a module has what its braking curve says, where it has one.
    let braking = |inside: &Inside| inside.module.braking_curve.iter().map(|point| point[1]).reduce(f64::max);
    let module = of_module(candidate, ratio, |inside| braking(inside).or_else(|| inside.module.largest_torque()));
    least([module, current, torque, gear])
}

/// Torque at the motor that can be held for ever, by current, torque, temperature or gear.
fn continuous_torque(candidate: &Candidate, ratio: f64) -> Option<Bound> {
    let heat = candidate.steady_current().map(|steady| {
        let of_torque = candidate.motor.continuous_torque.map(|t| t * candidate.actuator.rms_current_per_torque());
        let rated = [candidate.motor.continuous_current, of_torque].into_iter().flatten();
        let by_row = !candidate.is_mounted() && rated.into_iter().any(|rated| rated <= steady * (1.0 + 1e-9));
        let by_heat = candidate.thermal_current().is_some_and(|(thermal, _)| thermal <= steady);
        let owner = if by_heat && !by_row { "winding temperature" } else { "motor" };
        Bound { value: torque_of_rms(candidate, steady), owner }
    });
    let drive = candidate.drive_continuous_current().zip(candidate.joint.turns.of_current());
    let drive =
        drive.map(|(current, times)| Bound { value: torque_of_rms(candidate, current * times), owner: "drive" });
    let gear = candidate.gear.continuous_torque.map(|t| Bound { value: t / ratio, owner: "gear" });
    let rated = |inside: &Inside| inside.module.sheet.rated_torque.map(|rated| rated.value * candidate.derating());
    let module = of_module(candidate, ratio, rated);
    let held = least([module, heat, drive, gear]);
    // A continuous torque does not exceed the peak torque.
    held.and_then(|held| least([Some(held), peak_torque(candidate, ratio)]))
}

/// Constant torque at the motor \[N·m\] whose current, ripple in its mean square, has this root mean square \[A\].
fn torque_of_rms(candidate: &Candidate, current: f64) -> f64 {
    let shortfall = &candidate.actuator.shortfall;
    let squared = |torque: f64| shortfall.current_squared(torque * torque).0;
    let most = candidate.actuator.torque_constant * current;
    if !shortfall.saturates() {
        let (least, slope) = shortfall.current_squared(0.0);
        return ((current * current - least) / slope).max(0.0).sqrt();
    }
    let (mut held, mut too_much) = (0.0, most);
    for _ in 0..60 {
        let middle = 0.5 * (held + too_much);
        if squared(middle) <= current * current { held = middle } else { too_much = middle }
    }
    held
}

/// Name of the friction that does not grow with speed.
const COULOMB: &str = "Coulomb friction";

/// Coulomb friction of a motor \[N·m\] whose row prints drag without load.
#[derive(Debug, Clone, Copy, PartialEq)]
enum NoLoad {
    /// It is this.
    Coulomb(f64),
    /// It is this or less: the rest grows with speed.
    AtMost(f64),
    /// Nothing.
    Silent,
}

/// All of a brushed motor's drag; the rest of it where the row declares viscous friction.
fn no_load_friction(motor: &Motor) -> NoLoad {
    let splits = motor.viscous_friction.is_some() || motor.conventions.commutation == Commutation::Brushed;
    match motor.drag() {
        Drag::NoLoad { torque, .. } if splits => NoLoad::Coulomb(torque),
        Drag::NoLoad { torque, .. } | Drag::Estimated { torque } => NoLoad::AtMost(torque),
        Drag::Declared | Drag::Unknown => NoLoad::Silent,
    }
}

/// Declared and fitted effects of the mounted hardware: those of a bench gear do not belong to another gear.
fn effects(candidate: &Candidate) -> impl Iterator<Item = (&'static dyn Effect, Vec<f64>)> {
    let (motor, another_gear) = (candidate.motor, candidate.catalog_gear.is_some());
    EFFECTS.iter().filter(move |effect| !another_gear || effect.side() != Side::Gear).flat_map(move |effect| {
        let fitted = motor.effects.iter().filter(|f| f.name() == effect.name()).map(|f| f.values.clone());
        motor.declared(*effect).into_iter().chain(fitted).map(|values| (*effect, values))
    })
}

/// Holding torque against a driving load per torque before the loss: infinite where the gear locks.
fn held(backdrive_efficiency: f64) -> f64 {
    if backdrive_efficiency > 0.0 { 1.0 / backdrive_efficiency } else { f64::INFINITY }
}

/// Largest speed at the output: the voltage's without load, the motor's, the gear's, the module's.
fn largest_speed(candidate: &Candidate, ratio: f64) -> Bound {
    let voltage =
        Bound { value: candidate.voltage() / candidate.motor.emf_constant() / ratio, owner: "voltage without load" };
    let says_emf = inside(candidate).is_none_or(|inside| inside.says_power());
    let volt = candidate.robot.bus.voltage;
    let module = of_module(candidate, 1.0, |inside| inside.module.no_load_speed_at(volt));
    least([Some(voltage).filter(|_| says_emf), mechanical_speed(candidate, ratio), module]).unwrap_or(voltage)
}

/// Largest speed at the output that motor and gear allow whatever the voltage.
fn mechanical_speed(candidate: &Candidate, ratio: f64) -> Option<Bound> {
    let motor = candidate.motor.max_speed.map(|s| Bound { value: s / ratio, owner: "motor" });
    let gear = candidate.gear.max_input_speed.map(|s| Bound { value: s / ratio, owner: "gear" });
    least([motor, gear])
}

/// Speed at the output \[rad/s\] at which the voltage leaves no torque: of the motor's back-EMF, or what a module's row says.
fn no_load_speed(candidate: &Candidate, ratio: f64) -> Option<f64> {
    let inside = inside(candidate);
    let voltage = candidate.voltage() / candidate.motor.emf_constant() / ratio;
    let by_voltage = inside.is_none_or(|inside| inside.says_power()).then_some(voltage);
    let of_row = inside.and_then(|inside| inside.module.no_load_speed_at(candidate.robot.bus.voltage));
    by_voltage.into_iter().chain(of_row).filter(|speed| speed.is_finite()).reduce(f64::min)
}

fn winding(candidate: &Candidate) -> Winding {
    let motor = candidate.motor;
    let (hottest, _) = hottest(motor, candidate.joint);
    Winding {
        resistance: motor.resistance,
        reference: motor.reference_temperature,
        hottest,
        time_constant: motor.inductance.map(|inductance| inductance / motor.resistance),
    }
}

fn heat(candidate: &Candidate) -> Option<Heat> {
    let resistance = candidate.thermal_resistance()?;
    let time_constant = candidate.two_node().map(|nodes| nodes.time_constant_housing);
    Some(Heat { resistance, time_constant, ambient: candidate.robot.ambient })
}

/// Speed at the output up to which a torque \[N·m\] at the motor can be had \[rad/s\]: of the curve of a module's row and of the voltage;
/// `None` where a module's row says neither.
fn speed_at_torque(candidate: &Candidate, torque: f64, ratio: f64) -> Option<f64> {
    let inside = inside(candidate);
    let by_voltage =
        inside.is_none_or(|inside| inside.says_power()).then(|| speed_by_voltage(candidate, torque) / ratio);
    let of_curve = inside.and_then(|inside| inside.module.speed_at_torque(torque * ratio, candidate.robot.bus.voltage));
    by_voltage.into_iter().chain(of_curve).reduce(f64::min)
}

/// Motor speed up to which the voltage suffices for a torque, steady state \[rad/s\]:
/// `(R i + K_B ω)² + (p L i ω)² = V²`, solved for ω ≥ 0, with R of the hottest winding that may be and of drive and leads; zero
/// where not even standstill has the voltage. Where the supply sags, V is what this takes leaves of it.
fn speed_by_voltage(candidate: &Candidate, torque: f64) -> f64 {
    let current = candidate.actuator.shortfall.peak_current(torque);
    let motor = candidate.motor;
    let resistance = candidate.actuator.resistance_per_torque() * candidate.actuator.torque_constant;
    let drop = resistance * current;
    let (inductance, pole_pairs) = motor.inductance_and_poles().unwrap_or((0.0, 0.0));
    let a = motor.emf_constant().powi(2) + (pole_pairs * inductance * current).powi(2);
    let half_b = motor.emf_constant() * drop;
    let c = drop * drop - candidate.voltage().powi(2);
    let stiff = if c >= 0.0 { 0.0 } else { -c / (half_b + (half_b * half_b - a * c).sqrt()) };
    let Some(supply) = candidate.supply(0.0) else { return stiff };
    let is_enough = |speed: f64| {
        let squared = a * speed * speed + 2.0 * half_b * speed + drop * drop;
        let power = (drop + motor.emf_constant() * speed) * current;
        supply.asks_beyond((squared, power), 1.0).0 <= 0.0
    };
    let (mut enough, mut too_fast) = (0.0, stiff);
    if !is_enough(enough) {
        return 0.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (enough + too_fast);
        if is_enough(middle) { enough = middle } else { too_fast = middle }
    }
    enough
}

#[cfg(test)]
mod tests {
    use super::held;

    #[test]
    fn a_gear_that_locks_holds_without_end_and_never_less_than_nothing() {
        assert_eq!([0.8, 0.0, -0.5].map(held), [1.25, f64::INFINITY, f64::INFINITY]);
    }
}
