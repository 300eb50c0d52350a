use super::known_load::known_load;
use super::{Balanced, BaseTerm, Seen, Sides};
use crate::answer::Target;
use crate::identify::balance::model::Model;
use crate::identify::noise::Reading;
use crate::identify::origin::Channels;
use crate::{Bench, Channel, Declared, Log};
use gearwise_model::effects::Variable;

/// Angle by which the motor, over N, leads the output.
pub(super) struct WindUp;

impl Balanced for WindUp {
    fn target(&self) -> Target {
        Target::WindUp
    }

    fn serves(&self, log: &Log, bench: &Bench) -> bool {
        let has = |c: Channel| log.channels.contains_key(&c);
        bench.declared.motor.is_some() && has(Channel::MotorPosition) && has(Channel::OutputPosition)
    }

    fn unit(&self, _linear: bool) -> &'static str {
        "rad"
    }

    fn parameters(&self, _model: &Model, _declared: &Declared, _log: &Log) -> Vec<BaseTerm> {
        Vec::new()
    }

    fn reading(&self, seen: &Seen) -> Reading {
        let motor = seen.read(Channel::MotorPosition, 1.0 / seen.declared.ratio);
        motor.and(seen.read(Channel::OutputPosition, 1.0))
    }

    fn sides(&self, seen: &Seen) -> Option<Sides> {
        let ratio = seen.declared.ratio;
        let response = seen.motor_angle?.with(seen.output_angle?, |m, o| m / ratio - o);
        let torque = match (seen.sensor, known_load(seen), seen.current) {
            (Some(t), ..) => t.clone(),
            (None, Some(t), _) => t,
            (None, None, Some(i)) => seen.motor_torque(i).map(|t| ratio * t),
            _ => return None,
        };
        Some(Sides {
            response,
            base: Vec::new(),
            known: seen.zeros(),
            load: Channels::NONE,
            transmitted: Some(torque.map(|t| t / ratio)),
            curvature: Some(torque),
        })
    }

    fn shown_by(&self, _variable: Variable, _linear: bool) -> &'static str {
        "a torque sensor at the output"
    }
}
