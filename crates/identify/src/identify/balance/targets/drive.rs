use super::known_load::known_load;
use super::{Balanced, BaseTerm, Seen, Sides, inertia_term, moves};
use crate::answer::{Base, Target};
use crate::identify::balance::model::Model;
use crate::identify::noise::Reading;
use crate::identify::origin::Channels;
use crate::{Bench, BenchKind, Channel, Declared, Log};
use gearwise_model::effects::Variable;

/// Torque that the drive makes, at the output, where the load is known: friction is needed there.
pub(super) struct Drive;

impl Balanced for Drive {
    fn target(&self) -> Target {
        Target::Drive
    }

    fn serves(&self, log: &Log, _bench: &Bench) -> bool {
        let has = |c: Channel| log.channels.contains_key(&c);
        match log.kind {
            BenchKind::Free | BenchKind::Linear => has(Channel::Current) && moves(log),
            // Duty alone makes the current a function of the target: such logs are simulated instead.
            BenchKind::Servo => has(Channel::Current) && moves(log),
            BenchKind::Drag => !has(Channel::Torque) && has(Channel::Current) && moves(log),
            _ => false,
        }
    }

    fn unit(&self, linear: bool) -> &'static str {
        if linear { "N" } else { "N*m" }
    }

    fn factor(&self, ratio: f64) -> f64 {
        ratio
    }

    fn parameters(&self, model: &Model, declared: &Declared, log: &Log) -> Vec<BaseTerm> {
        let mut terms = vec![inertia_term(model, declared)];
        if log.channel(Channel::Current).is_none() {
            let damping = model.torque_constant * model.back_emf / model.resistance;
            terms.push(BaseTerm { which: Base::Damping, declared: Some(damping) });
        }
        if has_load_scale(log) {
            terms.push(BaseTerm { which: Base::LoadScale, declared: Some(1.0) });
        }
        terms
    }

    fn reading(&self, seen: &Seen) -> Reading {
        match seen.measured_current {
            Some(_) => seen.read(Channel::Current, seen.declared.ratio * seen.model.torque_constant),
            None => seen.read_volts(),
        }
    }

    fn sides(&self, seen: &Seen) -> Option<Sides> {
        let (moved, model, ratio, load) = (seen.moved, seen.model, seen.declared.ratio, seen.grid.log.load);
        let drive = match seen.measured_current {
            Some(i) => i.map(|i| ratio * model.torque_constant * i),
            None => {
                let per_volt = ratio * model.torque_constant / model.resistance;
                seen.applied?.map(|v| per_volt * v)
            }
        };
        let mut base = vec![moved.motor_acceleration.map(|a| ratio * a).values];
        if seen.measured_current.is_none() {
            base.push(moved.motor.map(|w| ratio * w).values);
        }
        let transmitted = known_load(seen);
        let mut known = seen.zeros();
        if has_load_scale(seen.grid.log) {
            base.push(transmitted.clone()?.values);
        } else if let Some(load) = &transmitted {
            known.clone_from(&load.values);
        }
        let made_of = transmitted.as_ref().map_or(Channels::NONE, |t| t.made_of);
        let inertia = seen.inertia();
        let curvature = match (&transmitted, seen.has_motor, seen.has_output) {
            (Some(t), true, false) => {
                Some(seen.grid.second_derivative(t).map(|s| -load.inertia.unwrap_or(0.0) * s / ratio))
            }
            (Some(t), false, true) => Some(seen.grid.second_derivative(t).map(|s| inertia * ratio * s)),
            _ => None,
        };
        let transmitted = transmitted.map(|t| t.map(|t| t / ratio));
        // A weight that was fitted is transmitted as a known one is.
        let weight = seen.weight.zip(seen.turned).map(|(w, q)| {
            let hangs = q.map(|q| w.sine * q.sin() + w.cosine * q.cos());
            hangs.with(&moved.motor_acceleration, |hangs, a| hangs + w.inertia * a)
        });
        let transmitted = match (transmitted, weight) {
            (Some(known), Some(weight)) => Some(known.with(&weight, |a, b| a + b)),
            (known, weight) => known.or(weight),
        };
        Some(Sides { response: drive, base, known, load: made_of, transmitted, curvature })
    }

    fn shown_by(&self, variable: Variable, linear: bool) -> &'static str {
        match variable {
            Variable::TorqueCurvature => "positions on both sides of the gear",
            _ if linear => "a force sensor at the output",
            _ => "a torque sensor at the output",
        }
    }
}

/// Whether the known load has a scale that is fitted: of a weight, and of what a robot's description says.
fn has_load_scale(log: &Log) -> bool {
    log.load.gravity_torque.is_some() || log.channel(Channel::LoadTorque).is_some()
}
