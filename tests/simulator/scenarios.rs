//! Benches by name: one that can show an effect, a clean one, a pair, what is outside the library, a null.

use super::{Bench, Channel, Effect, Kind, Size};

/// A bench that can show an effect, at a size in rms of the noise.
pub fn scenario(name: &str, size: f64, seed: u64) -> Bench {
    let effect = Effect::named(name).unwrap_or_else(|| panic!("no effect {name}"));
    fit_for(&[effect], seed).with(effect, Size::Noise(size))
}

/// A bench of a kind with nothing missing.
pub fn clean(kind: Kind, seed: u64) -> Bench {
    Bench::new(kind, seed)
}

/// A bench with something that no effect of the library is, clearly (5 × noise unless changed).
pub fn outside(name: &str, seed: u64) -> Bench {
    scenario(name, 5.0, seed)
}

/// Two effects on one bench that can show both.
pub fn pair(a: &str, b: &str, size: f64, seed: u64) -> Bench {
    let find = |name| Effect::named(name).unwrap_or_else(|| panic!("no effect {name}"));
    let (a, b) = (find(a), find(b));
    fit_for(&[a, b], seed).with(a, Size::Noise(size)).with(b, Size::Noise(size))
}

/// A null: what an effect contributed, cut into pieces and put in random order with random signs, so
/// that it depends on nothing.
pub fn shuffled(name: &str, size: f64, seed: u64) -> Bench {
    Bench { shuffled: true, ..scenario(name, size, seed) }
}

/// The kinds of bench that can show an effect, the best first. Two masses show in torque only where
/// the load, not a dynamometer, is behind the spring or the gap: with a sensor at the output the
/// motor's own motion balances whatever the gear does.
pub fn benches_for(effect: Effect) -> &'static [Kind] {
    match effect {
        Effect::WindingTemperature | Effect::InverterDeadTime => &[Kind::Electrical],
        Effect::SupplySag => &[Kind::Servo],
        Effect::Gravity | Effect::TorqueOffset | Effect::GearCompliance | Effect::Backlash => &[Kind::Free],
        Effect::TorqueConstantSaturation | Effect::TorqueConstantTemperature => &[Kind::Dynamometer],
        Effect::ZeroStep | Effect::LoadMemory => &[Kind::Dynamometer],
        Effect::LoadDependentFriction => &[Kind::Dynamometer, Kind::Servo],
        _ => &[Kind::Dynamometer, Kind::Free],
    }
}

/// A bench fit for all of some effects.
fn fit_for(effects: &[Effect], seed: u64) -> Bench {
    let kinds = benches_for(effects[0]);
    let kind = kinds
        .iter()
        .find(|kind| effects.iter().all(|e| benches_for(*e).contains(kind)))
        .unwrap_or_else(|| panic!("no bench shows all of {effects:?}"));
    let mut bench = Bench::new(*kind, seed);
    for effect in effects {
        match effect {
            // Slow enough for the sampling to see the teeth.
            Effect::Cogging { order } | Effect::TorqueRipple { order } => {
                let fastest = 0.5 * bench.rate * std::f64::consts::TAU / (4.0 * f64::from(*order));
                bench.excitation.speed = bench.excitation.speed.min(fastest / bench.machine.peak_speed);
            }
            Effect::StribeckFriction => {
                bench.excitation.slow = 0.5;
                bench.excitation.slow_level = 0.1;
            }
            Effect::GearCompliance | Effect::Backlash => {
                (bench.rate, bench.duration) = (1000.0, 20.0);
                bench.sensors.hidden.retain(|c| !matches!(c, Channel::OutputPosition | Channel::OutputVelocity));
            }
            Effect::SupplySag => bench.sensors.hidden.push(Channel::Supply),
            _ => {}
        }
        match effect {
            Effect::ViscousFriction => bench.declared.viscous = None,
            Effect::CoulombFriction => bench.declared.coulomb = None,
            _ => {}
        }
    }
    bench
}
