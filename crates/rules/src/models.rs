//! What rules of robot models look at: every joint of every model with what the model states and what its hardware can do.

use std::ops::Range as Span;

use crate::hardware::{Fact, Hardware, HardwareFile, Holds};
use gearwise_model::mechanism::stated::{Joint, Model, Quantity, Stated};
use gearwise_model::words::number;

/// Robot models with the hardware of their joints.
#[derive(Debug)]
pub struct ModelFacts<'a> {
    /// The models.
    pub models: &'a [Model],
    /// The file of hardware.
    pub file: &'a HardwareFile,
    /// What its entries can do, in their order.
    pub hardware: &'a [Hardware],
    /// Every joint of every model, in their order.
    pub joints: Vec<ModelJoint<'a>>,
    /// Joints behind one row whose transmissions differ and that carry the same effort and velocity: each with the joint
    /// of the least r. What that explains is not found twice.
    pub same_limits: Vec<(usize, usize)>,
}

/// A joint of a model with its hardware.
#[derive(Debug)]
pub struct ModelJoint<'a> {
    /// The model, by its index.
    pub model: usize,
    /// What the model states.
    pub joint: &'a Joint,
    /// The entry of the file of hardware, by its index.
    pub mount: Option<usize>,
    /// What its hardware can do.
    pub hardware: Option<&'a Hardware>,
    /// The coupling that it is part of, by its index.
    pub coupling: Option<usize>,
    /// Terms that its hardware adds to its equation of motion.
    pub reflected: Reflected,
}

/// Inertia and friction that all actuators which move a joint have there.
#[derive(Debug, Clone, Default)]
pub struct Reflected {
    /// Inertia of rotors and gears \[kg·m²\].
    pub armature: Option<Fact>,
    /// Coulomb friction \[N·m\].
    pub friction: Option<Fact>,
    /// Viscous friction \[N·m·s/rad\].
    pub damping: Option<Fact>,
}

impl Reflected {
    /// Terms of the only actuator of a joint.
    fn alone(hardware: &Hardware) -> Reflected {
        Reflected {
            armature: hardware.armature.clone(),
            friction: hardware.friction.clone(),
            damping: hardware.damping.clone(),
        }
    }

    /// Terms of two actuators that turn with a joint, each by its factor of J, while the other joint of the coupling stands: the
    /// diagonal of `Jᵀ diag(a, b) J`, and `|J|` for the Coulomb friction.
    fn coupled(both: [(f64, Option<&Hardware>); 2]) -> Reflected {
        let sum = |of: fn(&Hardware) -> &Option<Fact>, power: i32| {
            let sign = if power == 2 { "²" } else { "" };
            let mut found: Option<Fact> = None;
            let mut holds = Holds::Exactly;
            for (factor, hardware) in both.into_iter().filter(|(factor, _)| *factor != 0.0) {
                let Some(fact) = hardware.and_then(|hardware| of(hardware).as_ref()) else {
                    holds = Holds::AtLeast;
                    continue;
                };
                if fact.holds == Holds::AtLeast {
                    holds = Holds::AtLeast;
                }
                let value = factor.abs().powi(power) * fact.value;
                let how = format!("{}{sign} × {}", number(factor.abs()), fact.how);
                found = Some(match found {
                    None => Fact { value, how, ..fact.clone() },
                    Some(first) => {
                        let both = |a: String, b: &str| if a == b { a } else { format!("{a}; {b}") };
                        Fact {
                            value: first.value + value,
                            how: format!("{} + {how}, of both actuators of the coupling", first.how),
                            row: both(first.row, &fact.row),
                            source: both(first.source, &fact.source),
                            holds,
                        }
                    }
                });
            }
            found.map(|fact| Fact { holds, ..fact })
        };
        Reflected {
            armature: sum(|hardware| &hardware.armature, 2),
            friction: sum(|hardware| &hardware.friction, 1),
            damping: sum(|hardware| &hardware.damping, 2),
        }
    }
}

impl ModelJoint<'_> {
    /// What the model states of a quantity.
    pub fn get(&self, quantity: Quantity) -> Option<&Stated> {
        self.joint.get(quantity)
    }

    /// Where something is, in this joint's model.
    pub fn at(&self, span: &Span<usize>) -> (Option<usize>, Span<usize>) {
        (Some(self.model), span.clone())
    }
}

impl<'a> ModelFacts<'a> {
    /// Models with the hardware of their joints; `hardware` is that of the entries of the file, in their order.
    pub fn new(models: &'a [Model], file: &'a HardwareFile, hardware: &'a [Hardware]) -> ModelFacts<'a> {
        let mut joints = Vec::new();
        for (k, model) in models.iter().enumerate() {
            joints.extend(model.joints.iter().map(|joint| {
                let mount = file.mounts.iter().position(|mount| mount.drives(&joint.name));
                let coupling = file.couplings.iter().position(|coupling| coupling.joints.contains(&joint.name));
                let of = |name: &str| {
                    let mount = file.mounts.iter().position(|mount| mount.drives(name));
                    mount.and_then(|mount| hardware.get(mount))
                };
                let reflected = match coupling.map(|coupling| &file.couplings[coupling]) {
                    Some(coupling) => {
                        let column = usize::from(coupling.joints[0] != joint.name);
                        Reflected::coupled([0, 1].map(|k| (coupling.matrix[k][column], of(&coupling.joints[k]))))
                    }
                    None => of(&joint.name).map(Reflected::alone).unwrap_or_default(),
                };
                ModelJoint { model: k, joint, mount, hardware: of(&joint.name), coupling, reflected }
            }));
        }
        let mut facts = ModelFacts { models, file, hardware, joints, same_limits: Vec::new() };
        facts.same_limits = facts.find_same_limits();
        facts
    }

    /// Joints of one model.
    pub fn of_model(&self, model: usize) -> impl Iterator<Item = (usize, &ModelJoint<'a>)> {
        self.joints.iter().enumerate().filter(move |(_, joint)| joint.model == model)
    }

    /// Gears of a joint's actuator that are none: neither 1 (the force is the joint's torque), nor r (the actuator's), nor N r
    /// (the motor's).
    pub fn wrong_gears(&self, joint: usize) -> Vec<&Stated> {
        let joint = &self.joints[joint];
        let Some((hardware, n)) = joint.hardware.and_then(|h| Some((h, h.gear?))) else { return Vec::new() };
        let r = hardware.transmission;
        let tolerance = self.file.tolerances.limits;
        let fits = |gear: f64| [1.0, r, n * r].iter().any(|right| within(gear, *right, tolerance));
        joint.joint.all(Quantity::Gear).filter(|gear| !fits(gear.value)).collect()
    }

    fn find_same_limits(&self) -> Vec<(usize, usize)> {
        fn key<'a>(joint: &ModelJoint<'a>) -> Option<(&'a Hardware, f64, f64)> {
            // Where r goes with the angle no one torque and speed belong together.
            let hardware = joint.hardware.filter(|hardware| joint.coupling.is_none() && !hardware.varies)?;
            let (effort, velocity) = (joint.get(Quantity::Effort)?.value, joint.get(Quantity::Velocity)?.value);
            Some((hardware, effort, velocity)).filter(|_| effort > 0.0 && velocity > 0.0)
        }
        let mut found = Vec::new();
        for (k, joint) in self.joints.iter().enumerate() {
            let Some((hardware, effort, velocity)) = key(joint) else { continue };
            let others = self.of_model(joint.model).filter_map(|(other, of)| Some((other, key(of)?)));
            let same = others.filter(|(_, (h, e, v))| {
                h.label == hardware.label
                    && !within(h.transmission, hardware.transmission, 0.02)
                    && within(*e, effort, 1e-3)
                    && within(*v, velocity, 1e-3)
            });
            let least = same.min_by(|a, b| a.1.0.transmission.total_cmp(&b.1.0.transmission));
            found.extend(
                least.filter(|(_, (h, ..))| h.transmission < hardware.transmission).map(|(other, _)| (k, other)),
            );
        }
        found
    }

    /// Whether a number of a joint is wrong against its hardware: what is found there is not said again elsewhere.
    pub fn is_wrong(&self, joint: usize, quantity: Quantity) -> bool {
        let of = &self.joints[joint];
        let Some(hardware) = of.hardware else { return false };
        let value = of.get(quantity).map(|stated| stated.value);
        let tolerances = self.file.tolerances;
        match (quantity, value) {
            (Quantity::Gear, _) => !self.wrong_gears(joint).is_empty(),
            (Quantity::Effort, Some(value)) => {
                let gear = of.get(quantity).is_some_and(|s| s.by_gear) && !self.wrong_gears(joint).is_empty();
                gear || hardware.peak.as_ref().is_some_and(|fact| !within(value, fact.value, tolerances.limits))
            }
            (Quantity::Velocity, Some(value)) => {
                let above = |fact: &&crate::hardware::Fact| value > fact.value * (1.0 + tolerances.limits);
                hardware.fastest().filter(above).is_some()
                    || of.get(Quantity::Saturation).is_some()
                        && hardware
                            .largest_speed
                            .as_ref()
                            .is_some_and(|fact| value < fact.value * (1.0 - tolerances.limits))
            }
            (Quantity::Armature, value) => {
                let value = value.unwrap_or(0.0);
                let fact = of.reflected.armature.as_ref();
                fact.is_some_and(|fact| differs(value, fact.value, fact.holds, tolerances.armature))
            }
            (Quantity::Friction | Quantity::Damping, value) => {
                let fact = if quantity == Quantity::Friction { &of.reflected.friction } else { &of.reflected.damping };
                let value = value.unwrap_or(0.0);
                fact.as_ref().is_some_and(|fact| differs(value, fact.value, fact.holds, tolerances.friction))
            }
            _ => false,
        }
    }

    /// The factor by which the efforts of one model are those of another (by their indices), with how many joints show it.
    pub fn scale(&self, model: usize, other: usize) -> Option<(f64, usize)> {
        let effort = |joint: &ModelJoint| joint.get(Quantity::Effort).map(|s| s.value).filter(|e| *e > 0.0);
        let quotients: Vec<f64> = self
            .of_model(model)
            .filter_map(|(_, joint)| {
                let (_, twin) = self.of_model(other).find(|(_, twin)| twin.joint.name == joint.joint.name)?;
                Some(effort(joint)? / effort(twin)?)
            })
            .collect();
        let first = *quotients.first()?;
        let all = quotients.iter().all(|q| within(*q, first, 0.01));
        (all && quotients.len() >= 3 && !within(first, 1.0, 0.01)).then_some((first, quotients.len()))
    }
}

/// Whether two numbers are the same within a share.
pub fn within(a: f64, b: f64, share: f64) -> bool {
    (a - b).abs() <= share * b.abs() + 1e-12
}

/// Whether a number of the model differs from that of hardware by more than a share.
pub fn differs(value: f64, of: f64, holds: Holds, share: f64) -> bool {
    value < of * (1.0 - share) || holds == Holds::Exactly && value > of * (1.0 + share)
}

/// What a quotient of a model's number and the hardware's would be explained by: every factor that fits within 5 %, in words.
pub fn explained(quotient: f64, factors: &[(f64, String)]) -> Option<String> {
    let fits = |factor: f64| (quotient / factor - 1.0).abs() <= 0.05;
    let mut named: Vec<String> = factors
        .iter()
        .filter(|(factor, _)| fits(*factor) && !within(*factor, 1.0, 0.05))
        .map(|(_, n)| n.clone())
        .collect();
    for power in (-6..=6).filter(|power| *power != 0) {
        if fits(10.0_f64.powi(power)) {
            named.push(format!("a factor of {}", number(10.0_f64.powi(power))));
        }
    }
    named.dedup();
    (!named.is_empty()).then(|| format!("{} times as much: {} would explain it", number(quotient), named.join(" or ")))
}
