//! No constraint is satisfied by a number that says otherwise.

use std::sync::Arc;

use approx::assert_relative_eq;
use gearwise::actuator::Load;
use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize;
use gearwise::design::{Evaluation, Mount};
use gearwise::input::Source;
use gearwise::requirement::{self, Robot};

fn robot(text: &str) -> Robot {
    requirement::read_source(&Source::new("x.toml", text).into())
        .unwrap_or_else(|e| panic!("{}", e.iter().map(ToString::to_string).collect::<String>()))
}

fn catalog(text: &str) -> Catalog {
    Catalog::from_sources(vec![Arc::new(Source::new("m.csv", text))]).unwrap_or_else(|e| panic!("{}", e[0]))
}

/// The only motor of a table at a ratio.
fn at(robot: &Robot, table: &str, ratio: f64) -> Evaluation {
    let catalog = catalog(table);
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    Mount::new(robot, joint, &load, &catalog.motors[0]).prepared().unwrap().at(ratio)
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
fn a_limit_below_zero_asks_for_power_returned() {
    let table = motor(",continuous_current [A]", ",50");
    let bus = "voltage = '100 V', drive_efficiency = 0.8, drive_standby_power = '5 W', power = '3 W'";
    // 1 A per N·m at the joint, 1 Ω at 25 °C and hot at 100 °C: power at the joint less the heat.
    let hot = 1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * 75.0;
    for (torque, returned) in [(1.0, 10.0 - hot), (0.1, 1.0 - 0.01 * hot), (-2.0, -20.0 - 4.0 * hot)] {
        let points = format!("{{ torque = '{} N*m', speed = '10 rad/s', duration = '1 s' }}", -torque);
        let evaluation = at(&joint(bus, "", &points), &table, 10.0);
        let (demand, margin) = margin(&evaluation, "bus_power");
        let drawn = -returned * 0.8;
        assert_relative_eq!(demand, drawn, max_relative = 1e-9);
        assert_relative_eq!(margin, (-2.0 - drawn) / 2.0, max_relative = 1e-9);
        assert_eq!(evaluation.feasible, drawn <= -2.0, "{torque}");
    }
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
