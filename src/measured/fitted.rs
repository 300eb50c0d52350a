//! From what identification found to an actuator that the design can use.
//!
//! The declared row keeps every number that the logs did not show; those that were fitted take their place, on
//! the sheet too, so that tolerances and metrics follow.

use super::bench::{Bench, Declared};
use super::identify::{Parameter, Report};
use crate::actuator::fitted::{FittedEffect, FittedGear};
use crate::catalog::{Fit, Motor, Printed, Provenance};
use crate::requirement::backdrive_efficiency;

/// The declared motor with the parameters that were fitted and the effects that were found; `None` for a linear
/// axis, which has no motor of a catalogue. Standard errors become tolerances: ± two of them.
pub fn fitted_motor(bench: &Bench, reports: &[Report]) -> Option<Motor> {
    let declared = &bench.declared;
    let mut motor = declared.motor.clone()?;
    // What the bench file declares beyond the row belongs to the actuator too.
    for (name, values) in &declared.effects {
        let known = motor.effects.iter().any(|e| e.name() == name);
        match (name.as_str(), known) {
            ("viscous_friction", _) => set_viscous(&mut motor, values[0], None),
            ("coulomb_friction", _) => set_coulomb(&mut motor, values[0], None),
            (_, false) => motor.effects.extend(FittedEffect::new(name, values.clone())),
            _ => {}
        }
    }
    let mut gear = FittedGear { ratio: Some(declared.ratio), ..motor.fitted_gear.unwrap_or_default() };
    let mut fit = Fit { version: env!("CARGO_PKG_VERSION").to_string(), ..Fit::default() };
    let constants_alike = motor.sheet.back_emf_constant.is_none() && motor.sheet.speed_constant.is_none();
    for report in reports {
        for parameter in report.parameters.iter().filter(|p| p.standard_error.is_some() && p.fitted.is_finite()) {
            set_parameter(&mut motor, &mut gear, declared, parameter, constants_alike);
        }
        for found in &report.effects {
            for values in &found.instances {
                match found.name {
                    "viscous_friction" => set_viscous(&mut motor, values[0], error_of(&found.parameters)),
                    "coulomb_friction" => set_coulomb(&mut motor, values[0], error_of(&found.parameters)),
                    name => motor.effects.extend(FittedEffect::new(name, values.clone())),
                }
            }
        }
    }
    if let [only] = reports {
        fit.names.clone_from(&only.fitted_names);
        fit.covariance.clone_from(&only.covariance);
    }
    fit.provenance = bench
        .logs
        .iter()
        .map(|log| Provenance {
            log: log.name.clone(),
            sha256: Some(log.hash.clone()),
            usage: Some(if log.usage == super::bench::Use::Fit { "fit" } else { "held_out" }.into()),
        })
        .collect();
    motor.fitted_gear = Some(gear);
    motor.fit = Some(fit);
    Some(motor)
}

fn error_of(parameters: &[Parameter]) -> Option<f64> {
    parameters.first().and_then(|p| p.standard_error)
}

fn set_viscous(motor: &mut Motor, value: f64, error: Option<f64>) {
    motor.viscous_friction = Some(value);
    motor.sheet.viscous_friction = Some(Printed { value, tolerance: error.map(|e| 2.0 * e) });
}

fn set_coulomb(motor: &mut Motor, value: f64, error: Option<f64>) {
    motor.coulomb_friction = Some(value);
    motor.sheet.coulomb_friction = Some(Printed { value, tolerance: error.map(|e| 2.0 * e) });
}

/// A printed number scaled with the change of its q-axis value.
fn rescale(printed: &mut Option<Printed>, value: f64, old: f64, error: Option<f64>) {
    if let Some(p) = printed {
        let unit = p.value / old;
        *p = Printed { value: value * unit, tolerance: error.map(|e| 2.0 * e * unit) };
    }
}

fn set_parameter(
    motor: &mut Motor,
    gear: &mut FittedGear,
    declared: &Declared,
    parameter: &Parameter,
    constants_alike: bool,
) {
    let (value, error) = (parameter.fitted, parameter.standard_error);
    match parameter.name.as_str() {
        "torque_constant" if value > 0.0 => {
            rescale(&mut motor.sheet.torque_constant, value, motor.torque_constant, error);
            motor.torque_constant = value;
            // A row that gives only one of the two constants takes the other from it.
            if constants_alike {
                motor.back_emf_constant = value;
            }
        }
        "back_emf_constant" if value > 0.0 => {
            rescale(&mut motor.sheet.back_emf_constant, value, motor.back_emf_constant, error);
            motor.back_emf_constant = value;
        }
        "resistance" if value > 0.0 => {
            rescale(&mut motor.sheet.resistance, value, motor.resistance, error);
            motor.resistance = value;
        }
        "inductance" if value >= 0.0 => {
            if let Some(old) = motor.inductance.filter(|l| *l > 0.0) {
                rescale(&mut motor.sheet.inductance, value, old, error);
            }
            motor.inductance = Some(value);
        }
        "inertia" => {
            // J_m + J_g was seen: the gear keeps what it declares. Less than that is no rotor.
            let rotor = value - declared.gear.inertia;
            if rotor > 0.0 {
                motor.rotor_inertia = Some(rotor);
                motor.sheet.rotor_inertia = Some(Printed { value: rotor, tolerance: error.map(|e| 2.0 * e) });
            }
        }
        "viscous_friction.coefficient" if value >= 0.0 => set_viscous(motor, value, error),
        "coulomb_friction.torque" if value >= 0.0 => set_coulomb(motor, value, error),
        "load_dependent_friction.factor" if value >= 0.0 => {
            motor.effects.retain(|e| e.name() != "load_dependent_friction");
            gear.efficiency = Some(1.0 / (1.0 + value));
            gear.backdrive_efficiency = Some(backdrive_efficiency(1.0 / (1.0 + value)));
        }
        // A declared effect that was refitted: `effect.parameter`, or `effect.order.parameter`.
        name => {
            let mut parts = name.splitn(2, '.');
            let (Some(effect), Some(rest)) = (parts.next(), parts.next()) else { return };
            let number = rest.rsplit_once('.').map_or(rest, |(_, last)| last);
            let order = rest.rsplit_once('.').and_then(|(order, _)| order.parse::<f64>().ok());
            for fitted in motor.effects.iter_mut().filter(|e| e.name() == effect) {
                let linear = fitted.effect.linear();
                let same = order.is_none_or(|order| fitted.values.get(linear) == Some(&order));
                let place = fitted.effect.parameters()[..linear].iter().position(|p| p.name == number);
                if let (true, Some(place)) = (same, place) {
                    fitted.values[place] = value;
                }
            }
        }
    }
}
