//! A family of gears over the ratio: random families on random joints against a scan of the raw waveforms that interpolates the
//! gear by itself, a family that does not change against the plain gear, and its rows against gears of the catalogue.

use std::sync::Arc;

use gearwise::catalog::Catalog;
use gearwise::design::answer::Reason;
use gearwise::design::program::{Certificate, Optimum};
use gearwise::design::{Mount, load_through};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::brute_force::{dragged, run, supplied};
use crate::cases::{cases, quarter};
use crate::common;
use crate::raw::{Case, draw};
use crate::solved::solve;

/// A random family for a joint: two to six rows, some with a jump; efficiency, inertia, mass and limits that rise or fall.
fn family(case: &Case, i: u64) -> Vec<MapRow> {
    let mut random = Pcg64::seed_from_u64(i + 77);
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let middle = (min * max).sqrt();
    let at = case.look(middle);
    let need = |name: &str| at.limits.iter().find(|limit| limit.0 == name).unwrap().1.max(1e-9);
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
            no_load_torque: number(says[3] && i.is_multiple_of(4), 1e-3 * rub, 0.2 * rub),
            mass: number(says[4], 0.05, 2.0),
            peak_torque: number(says[5], 0.8 * need("gear_peak_torque"), 4.0 * need("gear_peak_torque")),
            continuous_torque: number(
                says[6],
                0.8 * need("gear_continuous_torque"),
                4.0 * need("gear_continuous_torque"),
            ),
            max_input_speed: number(says[7], 0.4 * need("gear_input_speed"), 4.0 * need("gear_input_speed")),
        }
    };
    ratios.iter().map(row).collect()
}

/// A joint with a random family in place of its gear.
pub fn mapped(case: Case, i: u64) -> Case {
    let rows = family(&case, i);
    let map = GearMap::new(&rows).expect("a family");
    let Case { motor, mut robot, raw, .. } = case;
    let joint = &mut robot.joints[0];
    let RatioChoice::Continuous { min, .. } = joint.ratio else { unreachable!() };
    joint.gear = map.gear(&joint.gear, min);
    joint.gear_map = Some(Arc::new(map));
    Case { family: rows, ..Case::new(motor, robot, raw) }
}

/// A joint with a random named family in place of its gear.
fn named(case: Case, i: u64) -> Case {
    let mut rows = family(&case, i);
    rows.dedup_by(|a, b| a.ratio == b.ratio);
    let inertia = case.robot.joints[0].gear.inertia;
    // What a published gear does not say is not known: of what limits ask, all is said.
    rows.iter_mut().for_each(|row| row.inertia = row.inertia.or(Some(inertia)));
    let points: Vec<(MapRow, String)> = rows.iter().enumerate().map(|(k, row)| (*row, format!("point-{k}"))).collect();
    let map = GearMap::of_points("random", &points).expect("a family");
    let Case { motor, mut robot, raw, .. } = case;
    let joint = &mut robot.joints[0];
    let RatioChoice::Continuous { min, .. } = joint.ratio else { unreachable!() };
    joint.gear = map.gear(&joint.gear, min);
    joint.gear_map = Some(Arc::new(map));
    Case { family: rows, named: true, ..Case::new(motor, robot, raw) }
}

#[test]
fn named_families_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(680_000, 240), false, 12, |i| named(draw(i, true), i * 4 + 1));
}

#[test]
fn named_families_with_friction_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(700_000, 120), false, 9, |i| named(dragged(i), i));
}

#[test]
fn families_without_friction_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(600_000, 320), false, 16, |i| mapped(draw(i, true), i * 4 + 1));
}

#[test]
fn families_with_friction_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(620_000, 160), false, 12, |i| mapped(dragged(i), i));
}

#[test]
fn families_on_a_supply_that_sags_agree_with_a_scan_of_the_raw_waveforms() {
    run(cases(640_000, 120), false, 10, |i| mapped(supplied(i), i));
}

/// The rows of a family that is the same gear at all ratios.
fn constant(gear: &GearModel, (min, max): (f64, f64)) -> Vec<MapRow> {
    let middle = (min * max).sqrt();
    let row = |ratio: f64| MapRow {
        ratio,
        mass: gear.mass.filter(|_| gear.mass_per_stage.is_none()),
        inertia: Some(gear.inertia),
        driving: Some(1.0 / gear.efficiency),
        braking: Some(gear.backdrive_efficiency),
        no_load_torque: Some(gear.no_load.coulomb),
        peak_torque: gear.peak_torque,
        continuous_torque: gear.continuous_torque,
        max_input_speed: gear.max_input_speed,
    };
    // One jump, which changes nothing.
    [min, middle, middle, middle.powf(0.4) * max.powf(0.6), max].map(row).to_vec()
}

/// A family that does not change gives the answer of the plain gear: verdict, objective, windows, proof.
#[test]
fn a_family_that_does_not_change_is_the_plain_gear() {
    let mut feasible = 0;
    for i in quarter(660_000, 120) {
        let case = if i % 3 == 0 { dragged(i) } else { draw(i, true) };
        let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
        let mut robot = case.robot.clone();
        let joint = &mut robot.joints[0];
        let map = GearMap::new(&constant(&joint.gear, (min, max))).expect("a family");
        joint.gear_map = Some(Arc::new(map));
        let (plain, family) = (solve(&case.motor, &case.robot), solve(&case.motor, &robot));
        let (plain, family) = match (plain, family) {
            (Ok(plain), Ok(family)) => (plain, family),
            (Err(plain), Err(family)) => {
                let said = |why: &Reason| matches!(why, Reason::Infeasible(_));
                assert_eq!(said(&plain), said(&family), "case {i}: {plain:?} {family:?}");
                continue;
            }
            (plain, family) => panic!("case {i}: {:?} {:?}", plain.is_ok(), family.is_ok()),
        };
        feasible += 1;
        let near = |a: f64, b: f64, most: f64| {
            assert!((a - b).abs() <= most * a.abs().max(b.abs()).max(1e-12), "case {i}: {a} {b}");
        };
        near(plain.optimum.objective, family.optimum.objective, 1e-8);
        let proved = |o: &Optimum| matches!(o.certificate, Certificate::Certified { .. });
        assert_eq!(proved(&plain.optimum), proved(&family.optimum), "case {i}");
        assert_eq!(plain.optimum.windows.len(), family.optimum.windows.len(), "case {i}");
        for (a, b) in plain.optimum.windows.iter().zip(&family.optimum.windows) {
            near(a.min, b.min, 1e-9);
            near(a.max, b.max, 1e-9);
            assert_eq!((a.low.limit, a.high.limit), (b.low.limit, b.high.limit), "case {i}");
        }
        let there = family.optimum.ratio;
        let at = |robot: &Robot| common::evaluate(robot, &case.motor, there);
        let (plain, family) = (at(&case.robot), at(&robot));
        near(plain.loss, family.loss, 1e-12);
        for (a, b) in plain.margins.iter().zip(&family.margins) {
            assert_eq!(a.limit, b.limit);
            near(a.demand, b.demand, 1e-9);
            near(a.bound, b.bound, 1e-12);
        }
    }
    assert!(feasible > 20, "{feasible}");
}

/// At its rows a family is the gear of the catalogue with these numbers.
#[test]
fn at_its_rows_a_family_is_a_gear_of_the_catalogue() {
    for i in cases(670_000, 60) {
        let case = mapped(draw(i, true), i * 4 + 1);
        let (robot, family) = (&case.robot, &case.family);
        for k in 0..family.len() {
            let row = family[k];
            // Of two rows of one ratio the first holds there.
            let is_second = k > 0 && family[k - 1].ratio == row.ratio;
            let base = &robot.joints[0].gear;
            let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:e}"));
            let cells = [
                ("ratio", Some(row.ratio)),
                ("efficiency", Some(row.driving.map_or(base.efficiency, |driving| 1.0 / driving))),
                ("backdrive_efficiency", row.braking.or(Some(base.backdrive_efficiency))),
                ("mass [kg]", row.mass.or(base.mass)),
                ("inertia [kg*m^2]", row.inertia.or(Some(base.inertia))),
                ("peak_torque [N*m]", row.peak_torque.or(base.peak_torque)),
                ("continuous_torque [N*m]", row.continuous_torque.or(base.continuous_torque)),
                ("max_input_speed [rad/s]", row.max_input_speed.or(base.max_input_speed)),
            ];
            // The audit refuses a peak torque below the continuous one.
            let torques = [row.continuous_torque.or(base.continuous_torque), row.peak_torque.or(base.peak_torque)];
            let is_swapped = matches!(torques, [Some(continuous), Some(peak)] if peak < continuous);
            if is_second || is_swapped || base.no_load.coulomb > 0.0 {
                continue;
            }
            let header: Vec<&str> = cells.iter().map(|cell| cell.0).collect();
            let values: Vec<String> = cells.iter().map(|cell| number(cell.1)).collect();
            let text = format!(
                "id,kind,source,source_kind,{}\ng,planetary,a test,derived,{}\n",
                header.join(","),
                values.join(",")
            );
            let catalog = Catalog::from_sources(vec![Arc::new(Source::new("gears.csv", text))]);
            let catalog = catalog.unwrap_or_else(|e| panic!("{}", e[0]));
            let mut plain = robot.clone();
            plain.joints[0].gear_map = None;
            let joint = &plain.joints[0];
            let load = load_through(joint, Some(&catalog.gears[0]));
            let mount = Mount::new(&plain, joint, &load, &case.motor).with_gear(catalog.gears.first());
            let printed = mount.prepared().expect("a candidate").at_in_full(row.ratio);
            let own = common::evaluate(robot, &case.motor, row.ratio);
            let near = |what: &str, a: f64, b: f64| {
                assert!(a == b || (a - b).abs() <= 1e-9 * a.abs().max(b.abs()), "case {i}, {what}: {a} {b}");
            };
            near("loss", own.loss, printed.loss);
            near("copper", own.copper_loss, printed.copper_loss);
            near("inertia", own.reflected_inertia, printed.reflected_inertia);
            if base.mass_per_stage.is_none() {
                near("mass", own.mass.unwrap(), printed.mass.unwrap());
            }
            for margin in own.margins.iter().filter(|m| m.limit != "actuator_mass") {
                let other = printed.margins.iter().find(|m| m.limit == margin.limit).expect("the same limits");
                near(margin.limit, margin.demand, other.demand);
                near(margin.limit, margin.bound, other.bound);
            }
        }
    }
}
