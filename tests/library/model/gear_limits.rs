//! What a gear takes without load, what it may bear, and what a requirement wants of it: on paper.

use std::sync::Arc;

use approx::assert_relative_eq;
use gearwise::actuator::Load;
use gearwise::actuator::gear_figures::GearFigures;
use gearwise::actuator::limits::{Check, LIMITS, is_stated};
use gearwise::actuator::shaft::{Feature, Flow};
use gearwise::catalog::audit::{Severity, audit};
use gearwise::catalog::{Catalog, Gear};
use gearwise::design::optimize::optimize;
use gearwise::design::simulated::SimulatedJoint;
use gearwise::design::{Mount, Prepared};
use gearwise::input::Source;
use gearwise::requirement::{self, Course, Robot, Spring};

use crate::raw::{self, draw};

/// A row of a strain wave gear of 50:1 with further columns.
fn row(columns: &str, cells: &str) -> String {
    format!(
        "id,kind,ratio,efficiency,mass [kg],inertia [kg*m^2],source,source_kind{columns}\n\
         g,strain_wave,50,0.8,0.1,1e-6,s,derived{cells}\n"
    )
}

const MOTOR: &str = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],continuous_current [A],\
     peak_current [A],inductance [H],pole_pairs,coulomb_friction [N*m],source,source_kind\n\
     m,q_axis,q_axis,0.1,0.1,1e-5,0.5,90,200,1e-5,7,0.02,s,derived\n";

/// Three points: 10 N·m at 2 rad/s for a second, −4 N·m at −1 rad/s for two, 20 N·m at rest for one.
fn robot(limits: &str) -> Result<Robot, String> {
    let text = format!(
        "name = \"x\"\nbus = {{ voltage = \"400 V\" }}\n[[joint]]\nname = \"j\"\ngears = [\"*\"]\nobjective = \"copper_loss\"\npoints = [\n\
         {{ torque = \"10 N*m\", speed = \"2 rad/s\", duration = \"1 s\" }},\n\
         {{ torque = \"-4 N*m\", speed = \"-1 rad/s\", duration = \"2 s\" }},\n\
         {{ torque = \"20 N*m\", speed = \"0 rad/s\", duration = \"1 s\" }},\n]\n[joint.limits]\n{limits}\n"
    );
    requirement::read_source(&Source::new("x.toml", text).into())
        .map_err(|e| e.iter().map(ToString::to_string).collect())
}

fn catalog(gears: &str) -> Result<Catalog, String> {
    let sources = vec![Arc::new(Source::new("m.csv", MOTOR)), Arc::new(Source::new("g.csv", gears))];
    Catalog::from_sources(sources).map_err(|e| format!("{} {}", e.len(), e[0]))
}

/// What a limit says of motor and gear: the margin, or why there is none.
fn said(robot: &Robot, catalog: &Catalog, name: &str) -> Result<f64, &'static str> {
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let gear = &catalog.gears[0];
    let candidate = Mount::new(robot, joint, &load, &catalog.motors[0]).with_gear(Some(gear)).candidate().unwrap();
    let limit = LIMITS.iter().find(|l| l.name == name).unwrap();
    match limit.check(&candidate) {
        Check::Asked(asked) => Ok(asked.margin(&candidate, gear.ratio, asked.raw_demand(&candidate, gear.ratio).0)),
        Check::Unknown(why) => {
            // What is not known is said with the design, and where the requirement states it the design is no choice.
            let prepared = Prepared::new(candidate);
            assert!(prepared.unchecked.contains(&(name, why)), "{name}");
            let result = optimize(robot, catalog);
            let found = &result.joints[0];
            let is_choice = !found.candidates.is_empty();
            assert_eq!(is_choice, !is_stated(name, robot, joint), "{name}: {why}");
            if !is_choice {
                assert!(found.unjudged[0].because.contains(&(name, why)), "{:?}", found.unjudged[0].because);
            }
            Err(why)
        }
        Check::NotAsked => Err("not asked"),
        Check::AtRatio(_) => unreachable!(),
    }
}

fn check(limits: &str, columns: &str, cells: &str, name: &str) -> Result<f64, &'static str> {
    said(&robot(limits).unwrap(), &catalog(&row(columns, cells)).unwrap(), name)
}

/// mean|ω| = (2·1 + 1·2)/4 = 1, mean(|ω||τ|³) = (2·1000 + 2·64)/4 = 532: an average of ∛532 = 8.103 N·m.
#[test]
fn the_average_torque_is_the_makers_mean() {
    let average = |bound: &str| check("", ",average_torque [N*m]", bound, "gear_average_torque");
    assert_relative_eq!(average(",16.2").unwrap(), 1.0 - 532.0_f64.cbrt() / 16.2, max_relative = 1e-12);
    assert!(average(",8.2").unwrap() > 0.0 && average(",8.0").unwrap() < 0.0);
    assert_eq!(average(","), Err("not asked"));
    // Points without durations have no mean: it is said, and not kept.
    let mut untimed = robot("").unwrap();
    let points: Vec<requirement::Point> = [(10.0, 2.0), (4.0, 1.0)]
        .map(|(torque, velocity)| requirement::Point { torque, velocity, ..Default::default() })
        .to_vec();
    untimed.joints[0].motion = requirement::Motion::from_points(&points).into();
    for (column, name) in
        [("average_torque [N*m]", "gear_average_torque"), ("average_input_speed [rpm]", "gear_average_speed")]
    {
        let gears = catalog(&row(&format!(",{column}"), ",1000")).unwrap();
        assert_eq!(said(&untimed, &gears, name), Err("the operating points have no durations"));
    }
    // Where the continuous torque is that of the rated life, the average torque takes its place; else both are limits.
    let columns = ",continuous_torque [N*m],average_torque [N*m],continuous_torque_is";
    assert_eq!(check("", columns, ",5,20,rated_life", "gear_continuous_torque"), Err("not asked"));
    assert!(check("", columns, ",5,20,thermal", "gear_continuous_torque").unwrap() < 0.0);
    assert!(check("", columns, ",5,20,", "gear_continuous_torque").unwrap() < 0.0);
    assert!(check("", columns, ",5,,rated_life", "gear_continuous_torque").unwrap() < 0.0);
}

/// The input turns at 50 · 4/3 rad/s on average over the three seconds in which it turns.
#[test]
fn the_average_speed_leaves_pauses_out() {
    let speed = |bound: &str| check("", ",average_input_speed [rad/s]", bound, "gear_average_speed");
    assert_relative_eq!(speed(",100").unwrap(), 1.0 - 200.0 / 300.0, max_relative = 1e-12);
    assert!(speed(",67").unwrap() > 0.0 && speed(",66").unwrap() < 0.0);
    assert_eq!(speed(","), Err("not asked"));
}

#[test]
fn shocks_are_compared_with_what_a_gear_bears_for_a_moment() {
    let columns = ",momentary_peak_torque [N*m],ratcheting_torque [N*m]";
    let shock = |limits: &str, cells: &str, name: &str| check(limits, columns, cells, name);
    const SHOCK: &str = "shock_torque = \"30 N*m\"";
    assert_relative_eq!(shock(SHOCK, ",60,90", "gear_momentary_torque").unwrap(), 0.5, max_relative = 1e-12);
    assert!(shock(SHOCK, ",31,90", "gear_momentary_torque").unwrap() > 0.0);
    assert!(shock(SHOCK, ",29,90", "gear_momentary_torque").unwrap() < 0.0);
    let safe = "shock_torque = \"30 N*m\"\nsafety = 1.2";
    assert!(shock(safe, ",31,90", "gear_momentary_torque").unwrap() < 0.0);
    assert_eq!(shock("", ",60,90", "gear_momentary_torque"), Err("not asked"));
    let unknown = "the gear's momentary peak torque is not known";
    assert_eq!(shock(SHOCK, ",,90", "gear_momentary_torque"), Err(unknown));
    // Teeth skip at any torque: without a shock the largest of the motion counts, which is 20 N·m.
    assert_relative_eq!(shock(SHOCK, ",60,60", "gear_ratcheting_torque").unwrap(), 0.5, max_relative = 1e-12);
    assert_relative_eq!(shock("", ",60,40", "gear_ratcheting_torque").unwrap(), 0.5, max_relative = 1e-12);
    let small = "shock_torque = \"10 N*m\"";
    assert_relative_eq!(shock(small, ",60,40", "gear_ratcheting_torque").unwrap(), 0.5, max_relative = 1e-12);
    assert!(shock("", ",60,19", "gear_ratcheting_torque").unwrap() < 0.0);
    assert!(shock(SHOCK, ",60,29", "gear_ratcheting_torque").unwrap() < 0.0);
    assert_eq!(shock("", ",60,", "gear_ratcheting_torque"), Err("not asked"));
    let unknown = "the gear's ratcheting torque is not known";
    assert_eq!(shock(SHOCK, ",60,", "gear_ratcheting_torque"), Err(unknown));
    // Teeth of a planetary gear do not skip.
    let planetary = row(columns, ",60,").replace("strain_wave", "planetary");
    let found = said(&robot(SHOCK).unwrap(), &catalog(&planetary).unwrap(), "gear_ratcheting_torque");
    assert_eq!(found, Err("not asked"));
}

/// L = L_n (n_N/n_av)(T_N/T_av)³ = 875 h · (209.4/50) · (18/8.103)³ = 40 180 h.
#[test]
fn life_is_the_makers_law() {
    const COLUMNS: &str =
        ",continuous_torque [N*m],rated_speed [rpm],rated_life [h],life_quantile,continuous_torque_is";
    let life = |limits: &str, cells: &str| check(limits, COLUMNS, cells, "gear_life");
    let n_av = 50.0 * 1.0;
    let expected = 875.0 * (2000.0 * std::f64::consts::TAU / 60.0 / n_av) * 18.0_f64.powi(3) / 532.0;
    assert!((40_100.0..40_200.0).contains(&expected), "{expected}");
    const RATED: &str = ",18,2000,875,L10,rated_life";
    assert_relative_eq!(life("life = \"20000 h\"", RATED).unwrap(), 1.0 - 20_000.0 / expected, max_relative = 1e-12);
    assert!(life("life = \"40000 h\"", RATED).unwrap() > 0.0 && life("life = \"41000 h\"", RATED).unwrap() < 0.0);
    // 4375 h L50 are 875 h L10, of the gear and of what is asked for.
    let same = life("life = \"20000 h\"", ",18,2000,4375,L50,rated_life").unwrap();
    assert_relative_eq!(same, life("life = \"20000 h\"", RATED).unwrap(), max_relative = 1e-12);
    let same = life("life = \"100000 h\"\nlife_quantile = \"L50\"", RATED).unwrap();
    assert_relative_eq!(
        same,
        life("life = \"20000 h\"\nlife_quantile = \"L10\"", RATED).unwrap(),
        max_relative = 1e-12
    );
    // Nobody asks; and whatever is missing leaves it unknown.
    assert_eq!(life("", RATED), Err("not asked"));
    for (cells, why) in [
        (",,2000,875,L10,rated_life", "is not known"),
        (",18,,875,L10,rated_life", "is not known"),
        (",18,2000,,L10,rated_life", "is not known"),
        (",18,2000,875,,rated_life", "whether the gear's rated life is L10 or L50"),
        (",18,2000,875,L10,thermal", "is not said to be that of its rated life"),
        (",18,2000,875,L10,", "is not said to be that of its rated life"),
    ] {
        let found = life("life = \"1 h\"", cells).unwrap_err();
        assert!(found.contains(why), "{cells}: {found}");
    }
    // A spring that is to be chosen changes the torque of every instant.
    let mut sprung = robot("life = \"1 h\"").unwrap();
    sprung.joints[0].limits.spring =
        Some(Spring { stiffness: [0.0, 1.0], rest_angle: [0.0, 1.0], ..crate::common::SPRING });
    let joint = &sprung.joints[0];
    let (load, catalog) = (Load::new(&joint.motion, None), catalog(&row(COLUMNS, RATED)).unwrap());
    let mount = Mount::new(&sprung, joint, &load, &catalog.motors[0]).with_gear(Some(&catalog.gears[0]));
    let limit = LIMITS.iter().find(|l| l.name == "gear_life").unwrap();
    assert!(matches!(limit.check(&mount.candidate().unwrap()), Check::Unknown(why) if why.contains("spring")));
}

#[test]
fn backlash_and_stiffness_are_the_gears() {
    let columns = ",backlash [arcmin],stiffness [N*m/rad]";
    let asked = "max_backlash = \"10 arcmin\"\nmin_stiffness = \"5000 N*m/rad\"";
    for (cells, backlash, stiffness) in [(",5,10000", 0.5, 0.5), (",15,4000", -0.5, -0.25), (",10,5000", 0.0, 0.0)] {
        let margin = |name: &str| check(asked, columns, cells, name).unwrap();
        assert!((margin("gear_backlash") - backlash).abs() < 1e-12, "{cells}");
        assert!((margin("gear_stiffness") - stiffness).abs() < 1e-12, "{cells}");
    }
    assert_eq!(check(asked, columns, ",,10000", "gear_backlash"), Err("the gear's backlash is not known"));
    assert_eq!(check(asked, columns, ",5,", "gear_stiffness"), Err("the gear's stiffness is not known"));
    for name in ["gear_backlash", "gear_stiffness"] {
        assert_eq!(check("", columns, ",5,10000", name), Err("not asked"));
    }
}

/// N (c + c_g)/η_b: 50 · (0.02 + 0.03)/0.75 with η = 0.8.
#[test]
fn backdriving_takes_the_friction_of_motor_and_gear() {
    const ASKED: &str = "max_backdriving_torque = \"10 N*m\"";
    let torque = |columns: &str, cells: &str| {
        check(ASKED, columns, cells, "backdriving_torque").map(|margin| 10.0 * (1.0 - margin))
    };
    assert_relative_eq!(torque(",starting_torque [N*m]", ",0.03").unwrap(), 50.0 * 0.05 / 0.75, max_relative = 1e-12);
    assert!(
        check("max_backdriving_torque = \"3 N*m\"", ",starting_torque [N*m]", ",0.03", "backdriving_torque").unwrap()
            < 0.0
    );
    // What the maker prints for the gear wins for the gear's part.
    let both = ",starting_torque [N*m],backdriving_torque [N*m]";
    assert_relative_eq!(torque(both, ",0.03,2").unwrap(), 2.0 + 50.0 * 0.02 / 0.75, max_relative = 1e-12);
    assert_relative_eq!(torque(both, ",,2").unwrap(), 2.0 + 50.0 * 0.02 / 0.75, max_relative = 1e-12);
    assert_eq!(torque(both, ",,"), Err("neither starting nor backdriving torque of the gear is known"));
    assert_eq!(check("", both, ",0.03,2", "backdriving_torque"), Err("not asked"));
    // A gear that locks is moved by no torque.
    let locks = catalog(&row(",starting_torque [N*m]", ",0.03").replace("50,0.8", "50,0.4")).unwrap();
    assert_eq!(said(&robot(ASKED).unwrap(), &locks, "backdriving_torque"), Ok(-1e6));
    assert!(optimize(&robot(ASKED).unwrap(), &locks).joints[0].candidates.is_empty());
    // Of a no-load current of which nobody knows whether it is Coulomb friction, the worse end; without any, nothing.
    let mut loose = catalog(&row(",starting_torque [N*m]", ",0.03")).unwrap();
    let motor = &mut loose.motors[0];
    motor.coulomb_friction = None;
    (motor.no_load_torque, motor.sheet.no_load_speed) = (Some(0.02), Some(gearwise::catalog::Printed::exact(100.0)));
    let asked = robot(ASKED).unwrap();
    let prepared = |robot: &Robot, catalog: &Catalog| {
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let mount = Mount::new(robot, joint, &load, &catalog.motors[0]).with_gear(Some(&catalog.gears[0]));
        let at = Prepared::new(mount.candidate().unwrap()).at(50.0);
        at.margins.iter().find(|m| m.limit == "backdriving_torque").map(|m| m.demand)
    };
    assert_relative_eq!(prepared(&asked, &loose).unwrap(), 50.0 * 0.05 / 0.75, max_relative = 1e-12);
    let mut off = robot(ASKED).unwrap();
    off.joints[0].motor_drag = requirement::MotorDrag::Off;
    let why = said(&off, &loose, "backdriving_torque").unwrap_err();
    assert!(why.contains("`motor_drag` is off"), "{why}");
    loose.motors[0].no_load_torque = None;
    assert_eq!(said(&asked, &loose, "backdriving_torque"), Err("the motor's drag is not known"));
}

const LOSSES: &str = ",starting_torque [N*m],no_load_torque [N*m],no_load_torque_speed [rpm],backdriving_torque [N*m],efficiency_torque [N*m],efficiency_speed [rpm]";

fn gear(row: &str) -> Gear {
    catalog(row).unwrap_or_else(|e| panic!("{e}")).gears.remove(0)
}

/// Schaeffler RT1-H-CS, i = 100, sizes 14 to 25, 20 degC: what its sheet says of the torques without load makes the same of all four
/// backwards, and leaves the load an efficiency that rises with the size.
#[test]
fn published_points_of_schaeffler() {
    for (efficiency, cells, forward, backward) in [
        ("0.67", ",0.021,0.035,2000,2.21,10,2000", 0.875, 0.950),
        ("0.77", ",0.029,0.051,2000,3.06,31,2000", 0.882, 0.948),
        ("0.77", ",0.037,0.105,2000,3.89,52,2000", 0.912, 0.951),
        ("0.77", ",0.069,0.195,2000,7.26,87,2000", 0.931, 0.950),
    ] {
        let gear = gear(&row(LOSSES, cells).replace("50,0.8", &format!("100,{efficiency}")));
        assert!((gear.load_efficiency().unwrap() - forward).abs() < 6e-4, "{gear:?}");
        assert!((gear.load_backdrive_efficiency().unwrap() - backward).abs() < 6e-4, "{gear:?}");
        // With 0.95 for all of them the backdriving torque is that of the sheet to 0.3 %.
        let torque = gear.ratio * gear.starting_torque.unwrap() / 0.95;
        assert_relative_eq!(torque, gear.backdriving_torque.unwrap(), max_relative = 3e-3);
        let friction = gear.no_load();
        let running = friction.coulomb + friction.viscous * gear.no_load_torque_speed.unwrap();
        assert_relative_eq!(running, gear.no_load_torque.unwrap(), max_relative = 1e-12);
        // At its own point the model loses what the sheet says.
        let at = gear.efficiency_torque.unwrap();
        let input = at / gear.load_efficiency().unwrap() / gear.ratio + running;
        assert_relative_eq!(at / gear.ratio / input, gear.efficiency.unwrap(), max_relative = 1e-12);
    }
}

/// Harmonic Drive HFUC-20-80: 78 % at 34 N·m, and 0.93 of that at 0.57 of the torque. 56 mN·m without load say the same.
#[test]
fn a_published_point_of_harmonic_drive() {
    let gear = gear(&row(LOSSES, ",,0.056,1000,,34,1000").replace("50,0.8", "80,0.78"));
    let torque = 0.57 * 34.0;
    let efficiency = 1.0 / (1.0 / gear.load_efficiency().unwrap() + 80.0 * 0.056 / torque);
    assert_relative_eq!(efficiency, 0.93 * 0.78, max_relative = 3e-3);
    // Of one of two torques alone, all is Coulomb friction.
    assert_eq!((gear.no_load().coulomb, gear.no_load().viscous), (0.056, 0.0));
}

/// The friction is in the model's torque, and an efficiency that has it already keeps it out.
#[test]
fn no_loss_is_counted_twice() {
    let shaft = |cells: &str| {
        let (robot, catalog) = (robot("").unwrap(), catalog(&row(LOSSES, cells)).unwrap());
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let mount = Mount::new(&robot, joint, &load, &catalog.motors[0]).with_gear(Some(&catalog.gears[0]));
        let candidate = mount.candidate().unwrap();
        let form = *candidate.actuator.gear_drag_form();
        let load = |flow| candidate.actuator.torque_form(flow)[Feature::Load];
        let prepared = Prepared::new(candidate);
        let said = prepared.judged(50.0).assumed.iter().any(|(what, _)| *what == "gear_friction");
        let loads = [load(Flow::Driving), load(Flow::Braking)];
        (form[Feature::Sign], form[Feature::Velocity], loads, said)
    };
    let (coulomb, viscous, [driving, braking], said) = shaft(",0.03,0.05,1000,3,40,500");
    let per_speed = 0.02 / (1000.0 * std::f64::consts::TAU / 60.0);
    assert_relative_eq!(viscous, per_speed, max_relative = 1e-12);
    assert_relative_eq!(driving, 1.0 / 0.8 - 50.0 * 0.04 / 40.0, max_relative = 1e-12);
    assert_relative_eq!(braking, 50.0 * 0.03 / 3.0, max_relative = 1e-12);
    assert!(coulomb == 0.03 && !said);
    // No point of the efficiency: the starting torque is for backdriving alone, and that is said.
    let (coulomb, viscous, [driving, braking], said) = shaft(",0.03,,,3,,");
    assert_eq!((coulomb, viscous, driving, said), (0.0, 0.0, 1.25, true));
    assert_relative_eq!(braking, 0.75, max_relative = 1e-12);
    let (.., said) = shaft(",,,,3,,");
    assert!(!said);
}

/// A simulator's joint gets the gear's friction next to the motor's.
#[test]
fn a_simulated_joint_has_the_gears_friction() {
    let (robot, catalog) = (robot("").unwrap(), catalog(&row(LOSSES, ",0.03,0.05,1000,3,40,500")).unwrap());
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let mount = |motor| Mount::new(&robot, joint, &load, motor).with_gear(Some(&catalog.gears[0])).candidate().unwrap();
    let simulated = SimulatedJoint::new(&mount(&catalog.motors[0]), 50.0);
    assert_relative_eq!(simulated.friction_loss.unwrap(), 50.0 * (0.02 + 0.03), max_relative = 1e-12);
    let per_speed = 0.02 / (1000.0 * std::f64::consts::TAU / 60.0);
    assert_relative_eq!(simulated.damping.unwrap(), 2500.0 * per_speed, max_relative = 1e-12);
    let why = |joint: &SimulatedJoint, what: &str| {
        joint.left_out.iter().find(|left| left.what == what).map(|left| left.why.clone())
    };
    assert!(why(&simulated, "viscous friction").unwrap().contains("only the gear's is written"));
    assert_eq!(why(&simulated, "Coulomb friction"), None);
}

#[test]
fn what_contradicts_itself_is_refused_with_its_place() {
    for (cells, says) in [
        (",,0.05,1000,,,", "count the same loss twice without `efficiency_torque`"),
        (",0.03,0.05,1000,,,", "count the same loss twice without `efficiency_torque`"),
        (",0.03,0.05,,,40,500", "together need `no_load_torque_speed`"),
        (",0.03,,1000,,40,500", "`no_load_torque_speed` is given without `no_load_torque`"),
        (",0.03,0.05,1000,,40,", "`efficiency_torque` needs `efficiency_speed`"),
        // 50 · 0.05 of 9 N·m are 0.28, and 1/0.8 − 1 is 0.25.
        (",,0.05,1000,,9,500", "leaves no room for the torque without load"),
        (",-0.03,,,,,", "starting_torque"),
    ] {
        let error = catalog(&row(LOSSES, cells)).unwrap_err();
        assert!(error.starts_with("1 ") && error.contains(says) && error.contains("g.csv:2"), "{cells}: {error}");
    }
    let columns = ",rated_life [h],life_quantile,continuous_torque_is";
    for (cells, says) in
        [(",7000,L20,", "life_quantile"), (",7000,L10,warm", "rated_life"), (",-7000,L10,", "rated_life")]
    {
        let error = catalog(&row(columns, cells)).unwrap_err();
        assert!(error.starts_with("1 ") && error.contains(says) && error.contains("g.csv:2"), "{cells}: {error}");
    }
    for (limits, says) in [
        ("life = \"7000 h\"\nlife_quantile = \"L20\"", "life_quantile"),
        ("life_quantile = \"L50\"", "life"),
        ("life = \"-1 h\"", "life"),
        ("max_backlash = \"-1 deg\"", "max_backlash"),
        (
            "life = \"1 h\"\nspring = { stiffness = [\"0 N*m/rad\", \"5 N*m/rad\"], rest_angle = [\"0 rad\", \"1 rad\"] }",
            "cannot be asked for where a spring is to be chosen",
        ),
        ("min_stiffness = \"3 N*m\\\"\"", "min_stiffness"),
    ] {
        let error = robot(limits).unwrap_err();
        assert!(error.contains(says) && error.contains("x.toml"), "{limits}: {error}");
    }
}

#[test]
fn the_audit_finds_gears_that_make_energy_and_ratings_out_of_order() {
    let found = |columns: &str, cells: &str| {
        let catalog = catalog(&row(columns, cells)).unwrap();
        let of_gear = audit(&catalog).into_iter().filter(|f| f.id == "g");
        of_gear.map(|f| (f.code, f.severity)).collect::<Vec<_>>()
    };
    let both = ",starting_torque [N*m],backdriving_torque [N*m]";
    assert_eq!(found(both, ",,2"), []);
    let note = ("gear-efficiency-point", Severity::Note);
    assert_eq!(found(both, ",0.03,2"), [note]);
    assert_eq!(found(both, ",0.05,2"), [("gear-backdriving", Severity::Error), note]);
    let ratings = ",continuous_torque [N*m],average_torque [N*m],peak_torque [N*m],momentary_peak_torque [N*m],ratcheting_torque [N*m]";
    assert_eq!(found(ratings, ",10,14,30,60,90"), []);
    for cells in [",15,14,30,60,90", ",10,31,30,60,90", ",10,14,30,29,90", ",10,14,30,60,50", ",10,,,60,50"] {
        assert_eq!(found(ratings, cells), [("gear-ratings", Severity::Error)], "{cells}");
    }
    let speeds = ",max_input_speed [rpm],average_input_speed [rpm]";
    assert_eq!(found(speeds, ",5000,3500"), []);
    assert_eq!(found(speeds, ",3000,3500"), [("gear-ratings", Severity::Error)]);
}

/// A gear that the requirement describes says the same in its own keys.
#[test]
fn a_described_gear_has_the_same_keys() {
    let described = |gear: &str, limits: &str| {
        let text = format!(
            "name = \"x\"\nbus = {{ voltage = \"400 V\" }}\n[[joint]]\nname = \"j\"\nratio = {{ min = 1, max = 100 }}\nobjective = \"copper_loss\"\n\
             points = [ {{ torque = \"10 N*m\", speed = \"2 rad/s\", duration = \"1 s\" }} ]\n[joint.gear]\nefficiency = 0.8\n{gear}\n\
             [joint.limits]\n{limits}\n"
        );
        requirement::read_source(&Source::new("x.toml", text).into()).map_err(|e| e[0].to_string())
    };
    let all = described(
        "starting_torque = \"0.03 N*m\"\nno_load_torque = \"0.05 N*m\"\nno_load_torque_speed = \"100 rad/s\"\n\
         average_torque = \"9 N*m\"\nmomentary_peak_torque = \"50 N*m\"\nratcheting_torque = \"80 N*m\"\naverage_input_speed = \"100 rad/s\"\n\
         continuous_torque = \"8 N*m\"\ncontinuous_torque_is = \"rated_life\"\nrated_life = \"7000 h\"\nrated_speed = \"200 rad/s\"\nlife_quantile = \"L10\"\n\
         backlash = \"1 arcmin\"\nstiffness = \"1000 N*m/rad\"",
        "max_backdriving_torque = \"4 N*m\"\nlife = \"1000 h\"\nshock_torque = \"30 N*m\"\nmax_backlash = \"2 arcmin\"\nmin_stiffness = \"500 N*m/rad\"",
    )
    .unwrap();
    let gear = all.joints[0].gear;
    assert_eq!((gear.no_load.coulomb, gear.friction_at_rest), (0.03, Some(0.03)));
    assert_relative_eq!(gear.no_load.viscous, 2e-4, max_relative = 1e-12);
    let motors = catalog(&row("", "")).unwrap().motors;
    let at = |robot: &Robot, ratio: f64| {
        let load = Load::new(&robot.joints[0].motion, None);
        let candidate = Mount::new(robot, &robot.joints[0], &load, &motors[0]).candidate().unwrap();
        let evaluated = Prepared::new(candidate).at(ratio);
        let margin = |name: &str| evaluated.margins.iter().find(|m| m.limit == name).map(|m| m.demand);
        ["gear_average_torque", "gear_average_speed", "gear_life", "backdriving_torque", "gear_momentary_torque"]
            .map(margin)
    };
    // 10 N·m at 2 rad/s; 1000 h at 20 · 2 rad/s and 10 N·m are as many as 1000 · 40/200 · (10/8)³ at the rated point.
    let [average, speed, life, backdriving, shock] = at(&all, 20.0).map(Option::unwrap);
    for (found, expected) in
        [(average, 10.0), (speed, 40.0), (life, 390.625), (backdriving, 20.0 * 0.05 / 0.75), (shock, 30.0)]
    {
        assert_relative_eq!(found, expected, max_relative = 1e-12);
    }
    // What the requirement describes it states: no design keeps 9 N·m on average.
    let found = Catalog::of(motors.clone(), Vec::new());
    assert!(optimize(&all, &found).joints[0].candidates.is_empty());
    let mut free = all.clone();
    free.joints[0].gear.ratings.average_torque = Some(11.0);
    free.joints[0].limits.max_backdriving_torque = Some(1.0);
    let result = optimize(&free, &found);
    assert_relative_eq!(result.joints[0].candidates[0].optimum.windows[0].max, 15.0, max_relative = 1e-9);
    // Without a word on friction, nobody knows whether it can be driven back.
    let silent = described("", "max_backdriving_torque = \"1 N*m\"").unwrap();
    let found = optimize(&silent, &found);
    assert!(found.joints[0].candidates.is_empty() && found.joints[0].unjudged[0].because[0].0 == "backdriving_torque");
    for (gear, says) in [
        ("starting_torque = \"0.03 N*m\"\nno_load_torque = \"0.05 N*m\"", "no_load_torque_speed"),
        (
            "starting_torque = \"0.03 N*m\"\nno_load_torque = \"0.05 N*m\"\nno_load_torque_speed = \"9 rpm\"\nno_load_viscous = \"1 N*m*s/rad\"",
            "no_load_viscous",
        ),
        ("starting_torque = \"-0.03 N*m\"", "starting_torque"),
        ("life_quantile = \"L20\"", "life_quantile"),
    ] {
        let error = described(gear, "").unwrap_err();
        assert!(error.contains(says) && error.contains("x.toml"), "{gear}: {error}");
    }
}

/// Random joints: the new demands are those that the raw waveforms have.
#[test]
fn demands_are_those_of_the_waveforms() {
    let mut looked = 0;
    for seed in 0..150 {
        let mut case = draw(seed, true);
        if case.robot.joints[0].motion.course == Course::Points(None) {
            continue;
        }
        let joint = &mut case.robot.joints[0];
        joint.motor_drag = requirement::MotorDrag::Counted;
        case.motor.coulomb_friction = Some(0.013);
        joint.gear.friction_at_rest = Some(0.02);
        joint.gear.backdrive_efficiency = joint.gear.backdrive_efficiency.max(0.1);
        joint.gear.continuous_torque = Some(3.0);
        let ratings = &mut joint.gear.ratings;
        (ratings.average_torque, ratings.average_input_speed, ratings.ratcheting_torque) =
            (Some(1.0), Some(1.0), Some(1.0));
        (ratings.rated_life, ratings.rated_speed) = (Some(3.6e6), Some(200.0));
        ratings.life_quantile = Some(gearwise::catalog::LifeQuantile::L50);
        ratings.continuous_torque_is = Some(gearwise::catalog::ContinuousTorque::RatedLife);
        (joint.limits.life, joint.limits.max_backdriving_torque) = (Some(7.2e6), Some(1.0));
        let timed = || case.raw.iter().zip(&case.shares);
        let mean = |f: &dyn Fn(&requirement::Point) -> f64| timed().map(|(p, share)| share[0] * f(p)).sum::<f64>();
        let (wear, speed) = (mean(&|p| p.velocity.abs() * p.torque.abs().powi(3)), mean(&|p| p.velocity.abs()));
        let motion = &case.robot.joints[0].motion;
        let at_rest: f64 = raw::shares(&case.raw, &motion.time, motion.course).iter().map(|share| share[1]).sum();
        let peak = case.raw.iter().map(|p| p.torque.abs()).fold(0.0, f64::max);
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, joint.ripple());
        let prepared = Prepared::new(Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap());
        for n in [3.0, 70.0] {
            let at = prepared.at(n);
            let back = n * (0.013 + 0.02) / joint.gear.backdrive_efficiency;
            for (name, demand, bound) in [
                ("gear_average_torque", if speed > 0.0 { (wear / speed).cbrt() } else { 0.0 }, 1.0),
                ("gear_average_speed", if speed > 0.0 { n * speed / (1.0 - at_rest) } else { 0.0 }, 1.0),
                ("gear_ratcheting_torque", joint.limits.safety * peak, 1.0),
                ("gear_life", 2000.0 * n * wear / (200.0 * 27.0), 200.0),
                ("backdriving_torque", back, 1.0),
            ] {
                let found = at.margins.iter().find(|m| m.limit == name).unwrap_or_else(|| panic!("{seed}: {name}"));
                assert!(
                    (found.demand - demand).abs() <= 1e-9 * demand.abs(),
                    "{seed} {name}: {} {demand}",
                    found.demand
                );
                assert_relative_eq!(found.bound, bound, max_relative = 1e-12);
                looked += 1;
            }
        }
    }
    assert!(looked > 800, "{looked}");
}

/// Figures of the first gear with the first motor at the first joint.
fn figures(robot: &Robot, catalog: &Catalog) -> GearFigures {
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let gear = catalog.gears.first();
    let mount = Mount::new(robot, joint, &load, &catalog.motors[0]).with_gear(gear);
    Prepared::new(mount.candidate().unwrap()).at(gear.map_or(50.0, |gear| gear.ratio)).gear
}

/// T_s = 0.02 N·m and T_0 = 0.05 N·m at 100 rad/s make T_0(n) = 0.02 + 0.0003 n; 80 % at 34 N·m and 100 rad/s 1/η_∞ = 1.25 − 50 · 0.05/34.
/// Over the three seconds that are no pause the mean load is 6 N·m at 4/3 rad/s, that is 0.04 N·m at the input; the largest is
/// 20 N·m at rest.
#[test]
fn figures_of_a_gear_are_those_on_paper() {
    let columns = ",starting_torque [N*m],no_load_torque [N*m],no_load_torque_speed [rad/s],efficiency_torque [N*m],efficiency_speed [rad/s]";
    let of = |limits: &str, columns: &str, cells: &str| {
        figures(&robot(limits).unwrap(), &catalog(&row(columns, cells)).unwrap())
    };
    let found = of("", columns, ",0.02,0.05,100,34,100");
    let load = 1.25 - 50.0 * 0.05 / 34.0;
    assert_relative_eq!(found.efficiency_at_mean.unwrap(), 1.0 / (load + 50.0 * 0.04 / 6.0), max_relative = 1e-12);
    assert_relative_eq!(found.efficiency_at_peak.unwrap(), 1.0 / (load + 50.0 * 0.02 / 20.0), max_relative = 1e-12);
    // The motor's 0.02 N·m and the gear's 0.02 N·m through η_b = 2 − 1/η_∞.
    assert_relative_eq!(found.backdriving_torque.unwrap(), 50.0 * 0.04 / (2.0 - load), max_relative = 1e-12);
    assert_eq!(found.life, None);
    // At the point of its sheet it is the efficiency of its sheet.
    let mut steady = robot("").unwrap();
    steady.joints[0].motion = requirement::Motion::from_points(&[requirement::Point {
        torque: 34.0,
        velocity: 2.0,
        duration: Some(1.0),
        ..Default::default()
    }])
    .into();
    let at_its_point = figures(&steady, &catalog(&row(columns, ",0.02,0.05,100,34,100")).unwrap());
    assert_relative_eq!(at_its_point.efficiency_at_mean.unwrap(), 0.8, max_relative = 1e-12);
    assert_relative_eq!(at_its_point.efficiency_at_peak.unwrap(), 0.8, max_relative = 1e-12);
    // 7000 h at 30 N·m and 200 rad/s: mean(|ω||τ|³) = 532.
    let rated = ",continuous_torque [N*m],rated_speed [rad/s],rated_life [h],life_quantile,continuous_torque_is";
    let life = of("", rated, ",30,200,7000,L10,rated_life").life.unwrap();
    assert_relative_eq!(life / 3600.0, 7000.0 * 200.0 * 27_000.0 / (50.0 * 532.0), max_relative = 1e-12);
    let of_half = of("", rated, ",30,200,35000,L50,rated_life").life.unwrap();
    assert_relative_eq!(of_half, life, max_relative = 1e-12);
    // It is what the limit compares: asked for so many hours, nothing is left.
    let asked = format!("life = \"{} h\"", life / 3600.0);
    assert!(check(&asked, rated, ",30,200,7000,L10,rated_life", "gear_life").unwrap().abs() < 1e-9);
}

/// What is not known is not said: no efficiency from an efficiency alone, whose loss without load is not known or in it already; no
/// life without its point; nothing without durations; and no zero anywhere.
#[test]
fn no_figure_of_a_gear_is_a_guess() {
    let of = |columns: &str, cells: &str| figures(&robot("").unwrap(), &catalog(&row(columns, cells)).unwrap());
    assert_eq!(of("", ""), GearFigures::default());
    // A starting torque whose loss is in the efficiency says backdriving alone.
    let starting = of(",starting_torque [N*m]", ",0.02");
    let back = GearFigures { backdriving_torque: starting.backdriving_torque, ..GearFigures::default() };
    assert!(starting == back && starting.backdriving_torque.is_some_and(|torque| torque > 2.0), "{starting:?}");
    let rated = ",continuous_torque [N*m],rated_speed [rad/s],rated_life [h],life_quantile,continuous_torque_is";
    for cells in
        [",30,200,7000,L10,", ",30,200,7000,,rated_life", ",30,200,,L10,rated_life", ",30,,7000,L10,rated_life"]
    {
        assert_eq!(of(rated, cells).life, None, "{cells}");
    }
    let gears = catalog(&row(rated, ",30,200,7000,L10,rated_life")).unwrap();
    let mut untimed = robot("").unwrap();
    let point = requirement::Point { torque: 10.0, velocity: 2.0, ..Default::default() };
    untimed.joints[0].motion = requirement::Motion::from_points(&[point]).into();
    assert_eq!(figures(&untimed, &gears), GearFigures::default());
    // At rest nothing wears and nothing runs: a life without end is not said.
    let mut held = robot("").unwrap();
    let point = requirement::Point { torque: 10.0, duration: Some(1.0), ..Default::default() };
    held.joints[0].motion = requirement::Motion::from_points(&[point]).into();
    assert_eq!(figures(&held, &gears), GearFigures::default());
    // A motor of whose drag nobody says anything is not turned by the gear's friction alone.
    let mut catalog = catalog(&row(",starting_torque [N*m]", ",0.02")).unwrap();
    (catalog.motors[0].coulomb_friction, catalog.motors[0].viscous_friction) = (None, None);
    assert_eq!(figures(&robot("").unwrap(), &catalog), GearFigures::default());
}

/// Grease is stiffer in the cold: said of a gear of the catalogue from more than 10 K below 20 °C on, and of nothing else.
#[test]
fn cold_grease_is_said_where_a_gear_has_some() {
    let said = |kelvin: f64, gears: &str| {
        let mut robot = robot("").unwrap();
        robot.ambient = kelvin;
        let catalog = catalog(gears).unwrap();
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let mount = Mount::new(&robot, joint, &load, &catalog.motors[0]).with_gear(Some(&catalog.gears[0]));
        let assumed = Prepared::new(mount.candidate().unwrap()).judged(50.0).assumed;
        assumed.iter().any(|(_, what)| what.contains("grease"))
    };
    let plain = row("", "");
    assert!(said(283.14, &plain) && said(263.15, &plain));
    assert!(!said(283.15, &plain) && !said(298.15, &plain));
    // A belt has none, and a gear without loss takes no more of it.
    assert!(!said(263.15, &plain.replace("strain_wave", "belt")));
    assert!(!said(263.15, &plain.replace(",0.8,", ",1,")));
}
