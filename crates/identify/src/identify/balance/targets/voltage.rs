use super::{Balanced, BaseTerm, Seen, Sides, moves};
use crate::answer::{Base, Target};
use crate::identify::balance::model::Model;
use crate::identify::noise::Reading;
use crate::identify::origin::Channels;
use crate::{Bench, BenchKind, Channel, Declared, Log};
use gearwise_model::effects::Variable;

/// Terminal voltage.
pub(super) struct Voltage;

impl Balanced for Voltage {
    fn target(&self) -> Target {
        Target::Voltage
    }

    fn serves(&self, log: &Log, _bench: &Bench) -> bool {
        let has = |c: Channel| log.channels.contains_key(&c);
        let volts = has(Channel::Voltage) || (has(Channel::Duty) && has(Channel::Supply));
        let wanted = log.kind == BenchKind::Electrical || log.kind == BenchKind::Backdrive || has(Channel::Voltage);
        wanted && log.kind != BenchKind::Linear && volts && (has(Channel::Current) || moves(log))
    }

    fn unit(&self, _linear: bool) -> &'static str {
        "V"
    }

    fn parameters(&self, model: &Model, _declared: &Declared, _log: &Log) -> Vec<BaseTerm> {
        vec![
            BaseTerm { which: Base::Resistance, declared: Some(model.resistance) },
            BaseTerm { which: Base::Inductance, declared: model.inductance },
            BaseTerm { which: Base::BackEmf, declared: Some(model.back_emf) },
        ]
    }

    fn reading(&self, seen: &Seen) -> Reading {
        seen.read_volts()
    }

    fn sides(&self, seen: &Seen) -> Option<Sides> {
        let base = vec![
            seen.measured_current.map_or_else(|| seen.zeros(), |i| i.values.clone()),
            seen.measured_current.map_or_else(|| seen.zeros(), |i| seen.grid.derivative(i).values),
            seen.moved.motor.values.clone(),
        ];
        let response = seen.grid.late(seen.applied?, seen.target_lag);
        Some(Sides { response, base, known: seen.zeros(), load: Channels::NONE, transmitted: None, curvature: None })
    }

    fn shown_by(&self, variable: Variable, _linear: bool) -> &'static str {
        match variable {
            Variable::Current => "a measured current",
            _ => "a measured supply voltage",
        }
    }
}
