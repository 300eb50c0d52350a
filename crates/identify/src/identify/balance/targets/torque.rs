use super::{Balanced, BaseTerm, Seen, Sides, inertia_term, moves};
use crate::answer::{Base, Target};
use crate::identify::balance::model::Model;
use crate::identify::noise::Reading;
use crate::identify::origin::Channels;
use crate::{Bench, BenchKind, Channel, Declared, Log};
use gearwise_model::effects::Variable;

/// Torque at the output, as a sensor has it: friction is missing there.
pub(super) struct Torque;

impl Balanced for Torque {
    fn target(&self) -> Target {
        Target::Torque
    }

    fn serves(&self, log: &Log, _bench: &Bench) -> bool {
        let has = |c: Channel| log.channels.contains_key(&c);
        match log.kind {
            BenchKind::Dynamometer | BenchKind::SteadyTable | BenchKind::RandomTorque => {
                has(Channel::Torque) && (has(Channel::Current) || moves(log))
            }
            BenchKind::Stall => has(Channel::Torque) && has(Channel::Current),
            BenchKind::Backdrive | BenchKind::Drag => has(Channel::Torque) && moves(log),
            _ => false,
        }
    }

    fn unit(&self, linear: bool) -> &'static str {
        if linear { "N" } else { "N*m" }
    }

    fn factor(&self, ratio: f64) -> f64 {
        -ratio
    }

    fn parameters(&self, model: &Model, declared: &Declared, _log: &Log) -> Vec<BaseTerm> {
        let constant = BaseTerm { which: Base::TorqueConstant, declared: Some(model.torque_constant) };
        vec![constant, inertia_term(model, declared)]
    }

    fn reading(&self, seen: &Seen) -> Reading {
        seen.read(Channel::Torque, seen.gain)
    }

    fn sides(&self, seen: &Seen) -> Option<Sides> {
        let (moved, ratio) = (seen.moved, seen.declared.ratio);
        let sensor = seen.sensor?.map(|t| t * seen.gain);
        let base = vec![
            seen.current.map_or_else(|| seen.zeros(), |i| i.map(|i| ratio * i).values),
            moved.motor_acceleration.map(|a| -ratio * a).values,
        ];
        let known = moved.output_acceleration.values.iter().map(|a| -seen.declared.fixture_inertia * a).collect();
        let inertia = seen.inertia();
        let curvature = (seen.has_output && !seen.has_motor)
            .then(|| seen.grid.second_derivative(&sensor).map(|s| inertia * ratio * s));
        // What the gear transmits, from the current: the sensor is the target itself and would explain its own
        // noise.
        let transmitted = seen.measured_current.map(|i| {
            let mut torque = seen.motor_torque(i);
            for (t, direction) in torque.values.iter_mut().zip(&moved.direction) {
                *t /= 1.0 + seen.gear_loss * (*t * direction).signum();
            }
            torque
        });
        Some(Sides { response: sensor, base, known, load: Channels::NONE, transmitted, curvature })
    }

    fn shown_by(&self, _variable: Variable, _linear: bool) -> &'static str {
        "positions on both sides of the gear"
    }
}
