//! No constraint vanishes and none is satisfied by a number that says otherwise.

use std::collections::BTreeSet;
use std::sync::Arc;

use approx::assert_relative_eq;
use gearwise::actuator::Load;
use gearwise::actuator::limits::{Check, LIMITS};
use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize;
use gearwise::design::simulated::SimulatedJoint;
use gearwise::design::{Evaluation, Mount, Prepared};
use gearwise::input::Source;
use gearwise::requirement::{self, Robot};

use crate::cases::share;
use crate::common::repository;

fn robot(text: &str) -> Robot {
    requirement::read_source(&Source::new("x.toml", text).into())
        .unwrap_or_else(|e| panic!("{}", e.iter().map(ToString::to_string).collect::<String>()))
}

fn catalog(text: &str) -> Catalog {
    Catalog::from_sources(vec![Arc::new(Source::new("m.csv", text))]).unwrap_or_else(|e| panic!("{}", e[0]))
}

/// The only motor or module of a table at a ratio.
fn at(robot: &Robot, table: &str, ratio: f64) -> Evaluation {
    let catalog = catalog(table).with_modules([&"*".to_string()].into_iter(), |m| m);
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    Prepared::new(Mount::new(robot, joint, &load, &catalog.motors[0]).candidate().unwrap()).at(ratio)
}

fn margin(evaluation: &Evaluation, limit: &str) -> (f64, f64) {
    let found = evaluation.margins.iter().find(|m| m.limit == limit).unwrap_or_else(|| panic!("no {limit}"));
    (found.demand, found.margin)
}

const HEAD: &str =
    "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],source,source_kind";

fn motor(columns: &str, cells: &str) -> String {
    format!("{HEAD}{columns}\nm,q_axis,q_axis,1,0.1,1e-9,s,derived{cells}\n")
}

fn joint(bus: &str, joint: &str, points: &str) -> Robot {
    robot(&format!(
        "name = 'x'\nambient = {{ temperature = '25 degC' }}\nbus = {{ {bus} }}\n[[joint]]\nname = 'j'\nratio = {{ min = 1, max = 50 }}\nobjective = 'copper_loss'\npoints = [{points}]\n{joint}"
    ))
}

#[test]
fn the_voltage_of_braking_is_that_of_the_cold_winding() {
    let table =
        motor(",max_winding_temperature [degC],reference_temperature [degC],continuous_current [A]", ",150,25,20");
    // 1 Ω at 25 °C, 1.48 Ω at 150 °C; 10 A at 400 rad/s of the motor against the motion, then with it.
    let points = "{ torque = '-10 N*m', speed = '40 rad/s', duration = '1 s' }";
    let robot = joint("voltage = '48 V'", "", points);
    let hot = 1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * 125.0;
    assert_relative_eq!(margin(&at(&robot, &table, 10.0), "voltage").0, 40.0 - 10.0, max_relative = 1e-9);
    let driving = joint("voltage = '100 V'", "", &points.replace("-10", "10"));
    assert_relative_eq!(margin(&at(&driving, &table, 10.0), "voltage").0, 40.0 + 10.0 * hot, max_relative = 1e-9);
    // Power returned too is the most of a winding at ambient: −20 °C.
    let cold = robot_at(-20.0, points);
    let r = 1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * -45.0;
    assert_relative_eq!(margin(&at(&cold, &table, 10.0), "regeneration").0, 400.0 - 100.0 * r, max_relative = 1e-9);
    assert_relative_eq!(margin(&at(&cold, &table, 10.0), "voltage").0, 40.0 - 10.0 * r, max_relative = 1e-9);
    // Of a supply that sags: 30 V in the q axis are 42.4 V of the bus; what is returned lifts it.
    let sags = joint("voltage = '48 V', internal_resistance = '0.1 ohm'", "", points);
    let (bus, given) = (30.0 * 2.0_f64.sqrt(), 10.0 * 30.0);
    assert_relative_eq!(margin(&at(&sags, &table, 10.0), "voltage").0, bus - 0.1 * given / bus, max_relative = 1e-9);
}

fn robot_at(ambient: f64, points: &str) -> Robot {
    robot(&format!(
        "name = 'x'\nambient = {{ temperature = '{ambient} degC' }}\nbus = {{ voltage = '100 V', regeneration = '50 W' }}\n[[joint]]\nname = 'j'\nratio = {{ min = 1, max = 50 }}\nobjective = 'copper_loss'\npoints = [{points}]\n"
    ))
}

#[test]
fn a_limit_below_zero_asks_for_power_returned() {
    let table = motor(",continuous_current [A]", ",50");
    let bus = "voltage = '100 V', drive_efficiency = 0.8, drive_standby_power = '5 W', power = '3 W'";
    // 1 A per N·m at the joint, 1 Ω at 25 °C and hot at 100 °C: power at the joint less the heat.
    let hot = 1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * 75.0;
    for (torque, returned) in [(1.0, 10.0 - hot), (0.1, 1.0 - 0.01 * hot), (-2.0, -20.0 - 4.0 * hot)] {
        let points = format!("{{ torque = '{} N*m', speed = '10 rad/s', duration = '1 s' }}", -torque);
        let evaluation = at(&joint(bus, "", &points), &table, 10.0);
        let (demand, margin) = margin(&evaluation, "bus_power");
        // The drive takes its share both ways.
        let drawn = if returned > 0.0 { -returned * 0.8 } else { -returned / 0.8 };
        assert_relative_eq!(demand, drawn, max_relative = 1e-9);
        assert_relative_eq!(margin, (-2.0 - drawn) / 2.0, max_relative = 1e-9);
        assert_eq!(evaluation.feasible, drawn <= -2.0, "{torque}");
    }
}

/// A row that prints neither a maximum nor a no-load speed lets a motor turn as fast as its rated voltage drives it.
#[test]
fn an_unknown_maximum_speed_is_not_checked() {
    let points = "{ torque = '1 N*m', speed = '20 rad/s', duration = '1 s' }";
    let told = |columns: &str, cells: &str, volt: &str| {
        let robot = joint(&format!("voltage = '{volt}'"), "", points);
        let catalog = catalog(&motor(columns, cells));
        let load = Load::new(&robot.joints[0].motion, None);
        let candidate = Mount::new(&robot, &robot.joints[0], &load, &catalog.motors[0]).candidate().unwrap();
        let found = candidate.checks().find(|(limit, _)| limit.name == "max_speed").map(|(_, check)| check);
        matches!(found, Some(Check::Unknown(_)))
    };
    assert!(told("", "", "24 V"));
    assert!(told(",voltage [V]", ",24", "48 V"));
    assert!(!told(",voltage [V]", ",24", "24 V"));
    assert!(!told(",max_speed [rpm]", ",20000", "24 V"));
    // The largest ratio asks for 50 × 20 rad/s: below the first no-load speed, above the second, whose voltage is unknown.
    assert!(!told(",no_load_speed [rad/s]", ",1500", "24 V"));
    assert!(told(",no_load_speed [rad/s]", ",900", "24 V"));
}

#[test]
fn a_locked_gear_has_no_ratio() {
    let table = motor(",continuous_current [A],coulomb_friction [N*m],mass [kg]", ",50,0.001,0.1");
    let points = "{ torque = '1 N*m', speed = '1 rad/s', duration = '1 s' }";
    let gear = |efficiency: f64| {
        format!(
            "gear = {{ efficiency = {efficiency}, starting_torque = '0.001 N*m' }}\nlimits = {{ max_backdriving_torque = '5 N*m' }}\n"
        )
    };
    let catalog = catalog(&table);
    for (efficiency, feasible) in [(0.9, true), (0.4, false)] {
        let robot = joint("voltage = '48 V'", &gear(efficiency), points);
        assert_eq!(optimize(&robot, &catalog).joints[0].candidates.is_empty(), !feasible, "{efficiency}");
    }
}

#[test]
fn drive_and_leads_are_heated_by_the_current_of_saturated_iron() {
    let table = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],peak_torque [N*m],peak_torque_of,peak_current [A],continuous_current [A],source,source_kind\n\
        m,q_axis,q_axis,0.05,0.1,1e-9,3,motor,60,60,s,derived\n";
    let points = "{ torque = '28 N*m', speed = '5 rad/s', duration = '1 s' }";
    let robot = joint("voltage = '400 V', drive_phase_resistance = '0.2 ohm'", "", points);
    let here = at(&robot, table, 10.0);
    // tanh(x)/x = 3/(0.1 · 60) with x = 60/i_s, by bisection; i = i_s atanh(T/(K_T i_s)).
    let (mut low, mut high) = (1e-6, 20.0);
    for _ in 0..200 {
        let x: f64 = 0.5 * (low + high);
        if x.tanh() / x > 0.5 { low = x } else { high = x }
    }
    let i_s = 60.0 / low;
    let current = i_s * (2.8 / (0.1 * i_s)).atanh();
    assert_relative_eq!(here.losses.drive, 0.2 * current * current, max_relative = 1e-6);
    assert_relative_eq!(here.losses.copper, 0.05 * current * current, max_relative = 1e-6);
    // Mean bus power is mean output power and the loss.
    let catalog = catalog(table);
    let load = Load::new(&robot.joints[0].motion, None);
    let mount = Mount::new(&robot, &robot.joints[0], &load, &catalog.motors[0]);
    let energy = mount.prepared().unwrap().at_in_full(10.0).energy.unwrap();
    assert_relative_eq!(energy, 140.0 + here.losses.total(), max_relative = 1e-9);
}

const MODULE: &str = "id,drive,ratio,source,source_kind,rated_torque [N*m],peak_torque [N*m],no_load_speed [rad/s],voltage [V],driving_curve [rad/s : N*m],overload [N*m : s],overload_stall [N*m : s]\n";

fn module(overload: &str, stall: &str) -> String {
    format!("{MODULE}mm,built_in,9,s,derived,20,60,35,48,0:60 20:60 35:0,{overload},{stall}\n")
}

#[test]
fn a_module_cannot_be_controlled_beyond_its_no_load_speed() {
    for (speed, torque, feasible) in
        [(30.0, 0.0, true), (30.0, -1.0, true), (100.0, 0.0, false), (100.0, -1.0, false), (100.0, 1.0, false)]
    {
        let points = format!("{{ torque = '{torque} N*m', speed = '{speed} rad/s', duration = '1 s' }}");
        let here = at(&joint("voltage = '48 V'", "modules = ['*']\n", &points), &module("", ""), 9.0);
        assert_eq!(here.feasible, feasible, "{speed} {torque}: {:?}", margin(&here, "torque_speed"));
        if !feasible && torque <= 0.0 {
            assert_relative_eq!(margin(&here, "torque_speed").0, 100.0 / 35.0, max_relative = 1e-9);
        }
    }
}

#[test]
fn a_hold_of_a_module_is_judged_by_its_table_at_standstill() {
    let (turning, stall) = ("25:900 30:393 40:60", "20:190 30:25 40:9");
    let hold = |torque: f64, speed: f64, time: f64| {
        robot(&format!(
            "name = 'x'\nbus = {{ voltage = '48 V' }}\n[[joint]]\nname = 'j'\nmodules = ['*']\nratio = {{ min = 9, max = 9 }}\nobjective = 'copper_loss'\norder = [{{ case = 'hold', count = 1 }}]\nperiodic = false\n[[joint.case]]\nname = 'hold'\npoints = [{{ torque = '{torque} N*m', speed = '{speed} rad/s', duration = '{time} s' }}]\n"
        ))
    };
    for (torque, speed, time, both, alone) in [
        (30.0, 0.0, 20.0, true, true),
        (30.0, 0.0, 40.0, false, false),
        (20.0, 0.0, 400.0, false, false),
        // Turning it holds as long as the other table says, where there is one.
        (30.0, 5.0, 300.0, true, false),
        (30.0, 5.0, 500.0, false, false),
    ] {
        let of = |overload: &str| {
            let here = at(&hold(torque, speed, time), &module(overload, stall), 9.0);
            margin(&here, "overload").1 >= 0.0
        };
        assert_eq!((of(turning), of("")), (both, alone), "{torque} N·m at {speed} rad/s for {time} s");
    }
}

/// A rated torque stays a limit of a module whose row has thermal resistances, unless the requirement states a temperature.
#[test]
fn a_rated_torque_is_asked_beside_thermal_resistances() {
    let table = "id,drive,ratio,source,source_kind,rated_torque [N*m],peak_torque [N*m],no_load_speed [rad/s],voltage [V],terminals,current,torque_constant [N*m/A],torque_constant_current,torque_constant_side,resistance [ohm],thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],max_winding_temperature [degC]\n\
                 mm,external,9,s,derived,2,60,35,48,q_axis,q_axis,0.1,q_axis,motor,0.1,0.1,0.5,130\n";
    let points = "{ torque = '6 N*m', speed = '5 rad/s', duration = '1 s' }";
    let of = |limits: &str| {
        let here = at(&joint("voltage = '48 V'", &format!("modules = ['*']\n{limits}"), points), table, 9.0);
        here.margins.iter().find(|m| m.limit == "rated_torque").map(|m| (m.demand, m.margin))
    };
    let (demand, margin) = of("").unwrap();
    assert!((demand - 6.0).abs() < 1e-9 && margin < 0.0, "{demand} {margin}");
    assert!(of("limits = { winding_temperature = '100 degC' }\n").is_none());
}

/// A joint that does its points once, from cold.
fn once(table: &str, bus: &str, torque: f64, limits: &str) -> Robot {
    robot(&format!(
        "name = 'x'\nambient = {{ temperature = '25 degC' }}\nbus = {{ voltage = '48 V'{bus} }}\n[[joint]]\nname = 'j'\n{table}ratio = {{ min = 9, max = 9 }}\nobjective = 'copper_loss'\norder = [{{ case = 'hold', count = 1 }}]\nperiodic = false\nlimits = {{ {limits} }}\n[[joint.case]]\nname = 'hold'\npoints = [{{ torque = '{torque} N*m', speed = '1 rad/s', duration = '40000 s' }}]\n"
    ))
}

/// True if the winding temperature history of the only motor or module of a table cannot be evaluated at N = 9.
fn heat_is_open(robot: &Robot, table: &str) -> bool {
    let catalog = catalog(table).with_modules([&"*".to_string()].into_iter(), |m| m);
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let prepared = Prepared::new(Mount::new(robot, joint, &load, &catalog.motors[0]).candidate().unwrap());
    let unchecked = prepared.unchecked_at(9.0);
    unchecked.iter().any(|(name, _)| ["winding_peak_temperature", "module_heat"].contains(name))
}

#[test]
fn a_reserve_is_kept_of_heat_that_is_judged_at_the_ratio() {
    // 1 Ω at 25 °C and R_th = 3 K/W: of 75 K of rise 60 K, at the resistance there.
    let columns = ",thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],max_winding_temperature [degC],reference_temperature [degC]";
    let table = motor(columns, ",1,2,100,25");
    let resistance = |rise: f64| 1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * rise;
    let torque = |rise: f64| 0.1 * 9.0 * (rise / (3.0 * resistance(rise))).sqrt();
    for (limits, rise) in [("", 75.0), ("reserve = { all = 0.2 }", 60.0)] {
        for (share, open) in [(0.9999, false), (1.0001, true)] {
            let robot = once("", "", share * torque(rise), limits);
            assert_eq!(heat_is_open(&robot, &table), open, "{limits} {share}");
        }
    }
    // A rating gives its share of heat, a module its share of torque.
    let rated = motor(",continuous_current [A]", ",4");
    let share = 0.8_f64.sqrt();
    for (torque, open) in [(0.9999 * 3.6 * share, false), (1.0001 * 3.6 * share, true)] {
        assert_eq!(heat_is_open(&once("", "", torque, "reserve = { all = 0.2 }"), &rated), open, "{torque}");
    }
    for (torque, open) in [(15.99, false), (16.01, true)] {
        let robot = once("modules = ['*']\n", "", torque, "reserve = { all = 0.2 }");
        assert_eq!(heat_is_open(&robot, &module("", "")), open, "{torque}");
    }
    // Heat that repeats is no higher than the reserve of temperature lets it, though nothing follows it.
    let limits = "limits = { reserve = { winding_peak_temperature = 0.2 } }\n";
    let points = format!("{{ torque = '{} N*m', speed = '1 rad/s', duration = '1 s' }}", torque(60.0));
    let found = margin(&at(&joint("voltage = '48 V'", limits, &points), &table, 9.0), "winding_temperature");
    assert_relative_eq!(found.1, 0.0, epsilon = 1e-9);
}

#[test]
fn a_limit_on_power_that_comes_back_is_dropped_for_a_stricter_one_alone() {
    // 48.6 V on 0.5 Ω: 58.32 W may come back, less a fifth, which is less than 55 W.
    let table = motor(",continuous_current [A]", ",50");
    let points = "{ torque = '-6 N*m', speed = '10 rad/s', duration = '1 s' }";
    for (regeneration, reserve, asked) in [
        ("", 0.2, true),
        (", regeneration = '55 W'", 0.2, true),
        (", regeneration = '55 W'", 0.0, false),
        (", regeneration = '60 W'", 0.0, true),
        (", regeneration = 'dissipated', brake_power = '20 W'", 0.2, false),
    ] {
        let bus = format!("voltage = '48 V', internal_resistance = '0.5 ohm', max_voltage = '48.6 V'{regeneration}");
        let limits = format!("limits = {{ reserve = {{ bus_overvoltage = {reserve} }} }}\n");
        let found = at(&joint(&bus, &limits, points), &table, 10.0);
        let bound = found.margins.iter().find(|m| m.limit == "bus_overvoltage").map(|m| m.bound);
        assert_eq!(bound.is_some(), asked, "{regeneration} {reserve}");
        if let Some(bound) = bound {
            assert_relative_eq!(bound, 48.6 * 0.6 / 0.5 * (1.0 - reserve), max_relative = 1e-9);
        }
    }
}

#[test]
fn a_reserve_narrows_the_supply_range_of_a_module_at_both_ends() {
    let points = "{ torque = '5 N*m', speed = '1 rad/s', duration = '1 s' }";
    let (low, high) = (20.0, 60.0);
    let table = module("", "");
    let (head, row) = table.trim_end().split_once('\n').unwrap();
    let table = format!("{head},min_voltage [V],max_voltage [V]\n{row},{low},{high}\n");
    let found = |volt: f64, reserve: f64| {
        let limits = format!("modules = ['*']\nlimits = {{ reserve = {{ supply_range = {reserve} }} }}\n");
        let found = at(&joint(&format!("voltage = '{volt} V'"), &limits, points), &table, 9.0);
        found.margins.iter().find(|m| m.limit == "supply_range").map(|m| m.margin)
    };
    assert_eq!((found(low, 0.0), found(high, 0.0)), (None, None));
    assert_relative_eq!(found(high, 0.2).unwrap(), 1.0 - 1.0 / 0.8, max_relative = 1e-9);
    assert_relative_eq!(found(low, 0.2).unwrap(), 1.0 - 1.0 / 0.8, max_relative = 1e-9);
    assert_eq!((found(low / 0.79, 0.2), found(high * 0.79, 0.2)), (None, None));
}

#[test]
fn a_module_bears_less_in_hot_surroundings() {
    let points = "{ torque = '9.5 N*m', speed = '3 rad/s', duration = '1 s' }";
    let of = |ambient: f64| {
        let mut robot = robot_at(ambient, points);
        robot.joints[0].motors.modules = vec!["*".into()];
        let here = at(&robot, &module("", ""), 9.0);
        let bound = here.margins.iter().find(|m| m.limit == "rated_torque").unwrap().bound;
        // A simulator is told the same.
        let (joint, catalog) =
            (&robot.joints[0], catalog(&module("", "")).with_modules(["*".to_string()].iter(), |m| m));
        let load = Load::new(&joint.motion, joint.ripple());
        let candidate = Mount::new(&robot, joint, &load, &catalog.motors[0]).candidate().unwrap();
        let held = SimulatedJoint::new(&candidate, 9.0).continuous_effort().unwrap();
        assert_relative_eq!(held.value, bound, max_relative = 1e-12);
        bound
    };
    assert_eq!((of(25.0), of(40.0)), (20.0, 20.0));
    assert_relative_eq!(of(95.0), 20.0 * (5.0_f64 / 60.0).sqrt(), max_relative = 1e-12);
}

#[test]
fn a_dwell_at_standstill_is_followed_in_the_winding_of_one_phase() {
    // A hold from cold, so short that the housing stays where it is: R_wh q (1 − e^{−t/τ}) with constant resistance, twice that standing.
    let columns = ",pole_pairs,thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],thermal_time_constant_winding [s],thermal_time_constant_housing [s],max_winding_temperature [degC]";
    let table = motor(columns, ",7,0.02,1e-6,12,60000,120");
    let rise = |speed: f64| {
        let motion = |t: f64| format!("{t},9,{speed}\n");
        let csv = format!("time [s],torque [N*m],velocity [rad/s]\n{}", [0.0, 10.0, 20.0, 30.0].map(motion).concat());
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("hold.csv"), csv).unwrap();
        let text = "name = 'x'\nambient = { temperature = '25 degC' }\nbus = { voltage = '400 V' }\n[[joint]]\nname = 'j'\nratio = { min = 1, max = 50 }\nobjective = 'copper_loss'\nmotion = 'hold.csv'\nperiodic = false\n";
        std::fs::write(folder.path().join("x.toml"), text).unwrap();
        let robot = requirement::read(&folder.path().join("x.toml")).unwrap_or_else(|e| panic!("{}", e[0]));
        margin(&at(&robot, &table, 10.0), "winding_peak_temperature").0
    };
    let (turning, standing) = (rise(5.0), rise(0.0));
    let mean = 0.02 * 81.0 * (1.0 - (-30.0_f64 / 12.0).exp());
    // Copper warms by one or three kelvin: half a per cent of resistance each.
    assert!((turning / mean - 1.0).abs() < 0.02 && turning > mean, "{turning} {mean}");
    assert!((standing / (2.0 * mean) - 1.0).abs() < 0.03 && standing > 2.0 * mean, "{standing} {mean}");
}

/// The constraints that a limit is one form of.
fn constraints(limit: &str) -> Vec<&str> {
    match limit {
        "peak_current" | "peak_torque" | "demagnetisation" => vec!["peak"],
        "torque_speed" | "module_curve" => vec!["peak", "voltage"],
        "continuous_current"
        | "continuous_torque"
        | "winding_temperature"
        | "winding_peak_temperature"
        | "standstill_holding"
        | "rated_torque"
        | "overload"
        | "module_heat" => vec!["heat"],
        "gear_continuous_torque" | "gear_average_torque" => vec!["gear heat"],
        "gear_average_speed" | "gear_input_speed" => vec!["gear speed"],
        other => vec![other],
    }
}

/// The constraints that are asked or reported as not evaluated, and those of the model's limits among them.
fn seen(robot: &Robot, catalog: &Catalog, motor: &str) -> Option<[BTreeSet<String>; 2]> {
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let motor = catalog.motors.iter().find(|m| m.id == motor)?;
    let candidate = Mount::new(robot, joint, &load, motor).with_gear(catalog.gears.first()).candidate().ok()?;
    let owned = |names: Vec<&str>| names.into_iter().flat_map(constraints).map(ToString::to_string).collect();
    let limits: Vec<&str> = candidate
        .checks()
        .filter(|(_, check)| !matches!(check, Check::NotAsked))
        .map(|(limit, _)| limit.name)
        .collect();
    let needs = candidate.lacking().map(|(name, _)| name).chain(candidate.told_at_a_ratio().map(|(name, _)| name));
    Some([owned(limits.clone()), owned(limits.into_iter().chain(needs).collect())])
}

/// A value that an entry lacks makes a constraint "not evaluated", never absent: for every value of every shipped entry.
#[test]
fn no_constraint_vanishes_with_a_missing_value() {
    let gear = "id,kind,ratio,efficiency,source,source_kind\ng,planetary,9,0.9,s,derived\n";
    let drive = motor(
        ",continuous_current [A],peak_current [A],coulomb_friction [N*m],mass [kg],max_speed [rpm],inductance [mH],pole_pairs",
        ",20,60,0.001,0.1,9000,0.1,7",
    );
    let asked = |more: &str| {
        robot(&format!(
            "name = 'x'\nbus = {{ voltage = '24 V', drive_current = '30 A', max_voltage = '60 V', power = '500 W', regeneration = '100 W' }}\n[[joint]]\nname = 'j'\nobjective = 'loss'\n{more}\nlimits = {{ max_backlash = '1 deg', min_stiffness = '100 N*m/rad', max_backdriving_torque = '5 N*m', shock_torque = '9 N*m', life = '100 h', actuator_mass = '9 kg', reflected_inertia = '1 kg*m^2', torque_bandwidth = {{ frequency = '5 Hz', amplitude = '0.1 N*m' }} }}\npoints = [{{ torque = '1 N*m', speed = '2 rad/s', duration = '1 s' }}, {{ torque = '-1 N*m', speed = '1 rad/s', duration = '1 s' }}, {{ torque = '1 N*m', speed = '0 rad/s', duration = '1 s' }}]\n"
        ))
    };
    let robot = asked("gears = ['*']");
    let (mut blanked, mut step) = (0, 0.0_f64);
    let mut vanished = Vec::new();
    for kind in ["motors", "gears", "modules"] {
        let mut files: Vec<_> =
            std::fs::read_dir(repository("catalogs").join(kind)).unwrap().map(|f| f.unwrap().path()).collect();
        files.sort();
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let lines: String = text.lines().filter(|l| !l.starts_with('#')).map(|l| format!("{l}\n")).collect();
            let mut reader = csv::Reader::from_reader(lines.as_bytes());
            let head = reader.headers().unwrap().clone();
            let place = |name: &str| head.iter().position(|h| h == name);
            for row in reader.records().map(Result::unwrap) {
                // A share of the entries, spread over all of them.
                step += share();
                if step < 1.0 {
                    continue;
                }
                step -= 1.0;
                // Alone: what other entries it is the same as or made of is another question.
                let mut cells: Vec<String> = row.iter().map(ToString::to_string).collect();
                for link in ["same_as", "motor", "gear", "fits", "only_inside", "family"] {
                    if let Some(at) = place(link) {
                        cells[at].clear();
                    }
                }
                let read = |cells: &[String]| {
                    let mut table = csv::Writer::from_writer(Vec::new());
                    table.write_record(&head).unwrap();
                    table.write_record(cells).unwrap();
                    let own = String::from_utf8(table.into_inner().unwrap()).unwrap();
                    let more = if kind == "gears" { drive.as_str() } else { gear };
                    let files = vec![Arc::new(Source::new("a.csv", own)), Arc::new(Source::new("b.csv", more))];
                    let catalog = Catalog::from_sources(files).ok()?;
                    Some(match kind {
                        "modules" => catalog.with_modules([&"*".to_string()].into_iter(), |m| m),
                        _ => catalog,
                    })
                };
                let id = if kind == "gears" { "m".to_string() } else { cells[place("id").unwrap()].clone() };
                let of = |cells: &[String]| seen(&robot, &read(cells)?, &id);
                let Some([whole, _]) = of(&cells) else { continue };
                for at in (0..cells.len()).filter(|at| head[*at].contains('[') && !cells[*at].is_empty()) {
                    let mut less = cells.clone();
                    less[at].clear();
                    // An entry that cannot be read, or not be used at all, is refused by name.
                    let Some([_, left]) = of(&less) else { continue };
                    blanked += 1;
                    // Up to its rated voltage and its no-load speed a motor's own maximum is known to be kept.
                    let is_kept = |name: &String| name == "max_speed" && head[at].starts_with("max_speed");
                    let gone: Vec<&String> = whole.difference(&left).filter(|name| !is_kept(name)).collect();
                    if !gone.is_empty() {
                        vanished.push(format!("{id}, {}: {gone:?}", &head[at]));
                    }
                }
            }
        }
    }
    assert!(vanished.is_empty(), "{} of {blanked}:\n{}", vanished.len(), vanished[..vanished.len().min(60)].join("\n"));
    assert!(blanked as f64 > 3000.0 * share(), "{blanked}");
    assert!(LIMITS.len() > 30);
}

/// Text of a fitted actuator with more in `[motor]` and effects.
fn fitted(motor: &str, more: &str) -> Catalog {
    let text = format!(
        "gearwise = '0.1.0'\nentry = 'bench-496660'\n[motor]\nid = 'bench-496660-fitted'\nresistance = '0.1 ohm'\ntorque_constant = '0.1 N*m/A'\nterminals = 'q_axis'\ncurrent = 'q_axis'\nrotor_inertia = '1e-5 kg*m^2'\ncontinuous_current = '50 A'\nmass = '0.2 kg'\nsource = 's'\nsource_kind = 'measured'\n{motor}\n{more}"
    );
    let gear = "id,kind,ratio,efficiency,fits,source,source_kind\ng,planetary,10,0.9,*-496660,s,derived\nother,planetary,10,0.9,*-1234,s,derived\n";
    let files = vec![Arc::new(Source::new("fit.toml", text)), Arc::new(Source::new("g.csv", gear))];
    Catalog::from_sources(files).unwrap_or_else(|e| panic!("{}", e[0]))
}

#[test]
fn a_fitted_actuator_keeps_the_gears_and_the_friction_of_its_machine() {
    let cogging = "[[effects.cogging]]\norder = 12\ncosine = '0.001 N*m'\nsine = '0 N*m'\n";
    let catalog = fitted("no_load_current = '1 A'\nno_load_speed = '300 rad/s'\n", cogging);
    let points = "{ torque = '1 N*m', speed = '20 rad/s', duration = '1 s' }";
    let robot = robot(&format!(
        "name = 'x'\nbus = {{ voltage = '48 V' }}\n[[joint]]\nname = 'j'\ngears = ['*']\nobjective = 'copper_loss'\npoints = [{points}]\n"
    ));
    let found = optimize(&robot, &catalog);
    let gears: Vec<_> = found.joints[0].candidates.iter().filter_map(|design| design.gear).collect();
    assert_eq!(gears, ["g"]);
    let losses = found.joints[0].candidates[0].evaluation.losses;
    // K_T I_0 = 0.1 N·m at 200 rad/s, all Coulomb at one end.
    assert_relative_eq!(losses.motor_drag, 20.0, max_relative = 1e-9);
}

#[test]
fn torque_beyond_what_the_iron_gives_cannot_be_had() {
    // T = K_T i − k (i − i_s tanh(i/i_s)) with k = K_T ends at K_T i_s = 2 N·m.
    let effect = "[effects.torque_constant_saturation]\nslope = '0.1 N*m/A'\ncurrent = '20 A'\n";
    let catalog = fitted("", effect);
    let of = |torque: f64| {
        let robot = joint(
            "voltage = '400 V'",
            "",
            &format!("{{ torque = '{torque} N*m', speed = '1 rad/s', duration = '1 s' }}"),
        );
        let load = Load::new(&robot.joints[0].motion, None);
        Mount::new(&robot, &robot.joints[0], &load, &catalog.motors[0]).prepared().unwrap().at(10.0).feasible
    };
    assert_eq!((of(19.0), of(20.2)), (true, false));
}

/// 9 N·m at 10:1 for ten hours: at rest one phase carries two thirds of the heat, and at 1e-9 rad/s the field turns by 0.0025 rad.
#[test]
fn a_hold_is_judged_alike_at_rest_in_a_creep_and_with_noise() {
    let table = "id,terminals,current,source,source_kind,pole_pairs,resistance [ohm],inductance [H],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],continuous_current [A],coulomb_friction [N*m]
m,q_axis,q_axis,t,derived,7,0.2,1e-4,0.1,1e-6,0.3,10,0\n";
    let with = |motion: &str, ratio: &str| {
        robot(&format!(
            "name = 'x'\n[bus]\nvoltage = '48 V'\n[[joint]]\nname = 'j'\nratio = {ratio}\ngear = {{ efficiency = 1.0 }}\nobjective = 'copper_loss'\n{motion}"
        ))
    };
    let point = |speed: f64| format!("points = [{{ torque = '9 N*m', speed = '{speed:e} rad/s', duration = '10 h' }}]");
    let fixed = "{ min = 10, max = 10 }";
    let at_speed = |speed: f64| at(&with(&point(speed), fixed), table, 10.0);
    let held = margin(&at_speed(0.0), "standstill_holding");
    assert_relative_eq!(held.0, 9.0 * 2.0_f64.sqrt(), max_relative = 1e-12);
    assert_eq!(margin(&at_speed(1e-9), "standstill_holding"), held);
    assert!(at_speed(1e-3).margins.iter().any(|m| m.limit == "standstill_holding" && m.demand < 0.99 * held.0));
    assert!(at_speed(0.1).feasible && at_speed(0.1).margins.iter().all(|m| m.limit != "standstill_holding"));
    // A range of ratios has the same at each of them.
    let (range, creep) = ("{ min = 1, max = 1000 }", point(3e-3));
    for ratio in [1.0, 3.3, 10.0, 100.0, 1000.0] {
        let alone = at(&with(&creep, &format!("{{ min = {ratio}, max = {ratio} }}")), table, ratio);
        let within = at(&with(&creep, range), table, ratio);
        let demands = |e: &Evaluation| e.margins.iter().map(|m| (m.limit, m.demand)).collect::<Vec<_>>();
        assert_eq!(demands(&alone), demands(&within), "at {ratio}");
    }
}
