//! A family of gears over the ratio: random families on random joints against a scan of the raw waveforms that interpolates the
//! gear by itself, a family that does not change against the plain gear, and its rows against gears of the catalogue.

use std::sync::Arc;

use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::brute_force::{dragged, run, supplied};
use crate::cases::cases;
use crate::raw::{Case, draw};

/// A random family for a joint: two to six rows, some with a jump; efficiency, inertia, mass and limits that rise or fall.
fn family(case: &Case, i: u64) -> Vec<MapRow> {
    let mut random = Pcg64::seed_from_u64(i + 77);
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let middle = (min * max).sqrt();
    let at = case.look(middle);
    let need = |name: &str| at.limits.iter().find(|limit| limit.0 == name).unwrap().1.max(1e-9);
    let base = case.robot.joints[0].gear;
    let rotor = case.motor.rotor_inertia.unwrap();
    let rub = (case.raw.iter().map(|p| p.torque.powi(2)).sum::<f64>() / case.raw.len() as f64).sqrt() / middle;
    let pieces = 1 + random.random_range(0..5);
    let mut inner: Vec<f64> = (1..pieces).map(|_| min * (max / min).powf(random.random_range(0.1..0.9))).collect();
    inner.sort_by(f64::total_cmp);
    inner.dedup_by(|a, b| *a < *b * 1.01);
    let mut ratios = vec![min * random.random_range(0.5..1.0)];
    for ratio in inner {
        ratios.push(ratio);
        if random.random_bool(0.3) {
            ratios.push(ratio);
        }
    }
    // Some ranges end at the family's own ends.
    ratios[0] = if random.random_bool(0.3) { min } else { ratios[0] };
    ratios.push(if random.random_bool(0.3) { max } else { max * random.random_range(1.0..2.0) });
    let says: [bool; 8] = std::array::from_fn(|k| random.random_bool([0.8, 0.5, 0.6, 0.4, 0.5, 0.3, 0.3, 0.3][k]));
    let mut number = |says: bool, low: f64, high: f64| {
        let value = low * (high / low).powf(random.random_range(0.0..1.0));
        Some(value).filter(|_| says)
    };
    let row = |ratio: &f64| {
        let driving = number(says[0], 1.0, 1.8);
        let braking = match says[1] {
            true => number(true, 0.05, 1.0),
            false => driving.map(|driving| 2.0 - driving),
        };
        MapRow {
            ratio: *ratio,
            driving,
            braking,
            inertia: number(says[2], 0.02 * rotor, 2.0 * rotor),
            no_load_torque: number(says[3] && i % 4 == 0, 1e-3 * rub, 0.2 * rub),
            mass: number(says[4], 0.05, 2.0),
            peak_torque: number(says[5], 0.8 * need("gear_peak_torque"), 4.0 * need("gear_peak_torque")),
            continuous_torque: number(says[6], 0.8 * need("gear_continuous_torque"), 4.0 * need("gear_continuous_torque")),
            max_input_speed: number(says[7], 0.4 * need("gear_input_speed"), 4.0 * need("gear_input_speed")),
        }
    };
    let _ = base;
    ratios.iter().map(row).collect()
}

/// A joint with a random family in place of its gear.
fn mapped(case: Case, i: u64) -> Case {
    let rows = family(&case, i);
    let map = GearMap::new(&rows).expect("a family");
    let Case { motor, mut robot, raw, .. } = case;
    let joint = &mut robot.joints[0];
    let RatioChoice::Continuous { min, .. } = joint.ratio else { unreachable!() };
    joint.gear = map.gear(&joint.gear, min);
    joint.gear_map = Some(Arc::new(map));
    Case { family: rows, ..Case::new(motor, robot, raw) }
}

#[test]
fn families_without_friction_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(600_000, 400), false, 18, |i| mapped(draw(i, true), i * 4 + 1));
}

#[test]
fn families_with_friction_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(620_000, 240), false, 18, |i| mapped(dragged(i), i));
}

#[test]
fn families_on_a_supply_that_sags_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(640_000, 160), false, 18, |i| mapped(supplied(i), i));
}
