//! What the benchmarks measure on.

use gearwise::catalog::convention::Modulation;
use gearwise::requirement::{
    Budget, Bus, Course, GearModel, Joint, Limits, Motion, Objective, Quantity, RatioChoice, Regeneration, Robot,
    Samples, backdrive_efficiency,
};

/// A periodic motion of a few harmonics, like a leg's.
pub fn motion(samples: usize, seed: f64) -> Motion {
    let period = 0.6;
    let at = |k: usize| std::f64::consts::TAU * k as f64 / samples as f64;
    let sum = |k: usize, terms: &[(f64, f64, f64)]| {
        terms.iter().map(|(a, n, p)| a * (n * at(k) + p + seed).sin()).sum::<f64>()
    };
    let torque = [(9.0, 1.0, 0.3), (4.0, 2.0, 1.1), (2.0, 3.0, 2.0), (0.7, 7.0, 0.2)];
    let velocity = [(5.0, 1.0, 1.0), (3.0, 2.0, 0.4), (1.0, 5.0, 0.9)];
    let series = |terms: &[(f64, f64, f64)]| (0..samples).map(|k| sum(k, terms)).collect::<Vec<_>>();
    let time = (0..samples).map(|k| period * k as f64 / samples as f64).collect();
    let samples = Samples { time, torque: series(&torque), velocity: Some(series(&velocity)), ..Samples::default() };
    Motion::from_samples(samples, Course::Periodic(period))
}

/// Joints with motions of their own and a continuous ratio, and limits that leave the program convex.
pub fn robot(samples: usize, joints: usize) -> Robot {
    let joint = |i: usize| Joint {
        name: format!("joint {i}"),
        count: 1,
        ratio: RatioChoice::Continuous { min: 3.0, max: 60.0 },
        gear: GearModel {
            efficiency: 0.92,
            backdrive_efficiency: backdrive_efficiency(0.92),
            inertia: 2e-6,
            ..GearModel::IDEAL
        },
        gear_map: None,
        motors: gearwise::requirement::Filter::default(),
        motion: motion(samples, i as f64).into(),
        objective: Objective::single(Quantity::CopperLoss),
        balancing: gearwise::requirement::Balancing::No,
        limits: Limits {
            reflected_inertia: Some(0.05),
            winding_temperature: Some(383.15),
            safety: 1.2,
            ..Limits::default()
        },
        drive_current: None,
        drive: gearwise::requirement::Drive::default(),
        motor_drag: gearwise::requirement::MotorDrag::Off,
        turns: gearwise::requirement::Turns::AsWound,
        phases: Vec::new(),
        carries: Vec::new(),
        passed: None,
    };
    Robot {
        name: "bench".into(),
        bus: Bus {
            voltage: 48.0,
            modulation: Modulation::SpaceVector,
            modulation_limit: 0.95,
            drive_current: Some(40.0),
            power: None,
            current: None,
            regeneration: Regeneration::Allowed,
            regeneration_efficiency: None,
            brake_power: None,
            flux_braking: false,
            internal_resistance: None,
            max_voltage: None,
            drive_efficiency: 1.0,
            drive: gearwise::requirement::Drive::default(),
            says_drive_loss: false,
        },
        ambient: 298.15,
        budget: Budget::default(),
        prices: None,
        joints: (0..joints).map(joint).collect(),
        cases: Vec::new(),
        set: Vec::new(),
        driven: None,
        rules: None,
        sources: Vec::new(),
    }
}
