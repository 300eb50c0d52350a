//! A supply that sags, and what is kept of the power that comes back: on paper, and against a bus that is solved by itself.

use gearwise::actuator::Load;
use gearwise::actuator::supply::{Drawn, Supply};
use gearwise::catalog::Catalog;
use gearwise::catalog::rewound::NoTurns;
use gearwise::design::optimize::optimize;
use gearwise::design::turns::can_be_asked;
use gearwise::design::{Mount, Prepared};
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::cases::cases;
use crate::common;
use crate::raw::{Case, draw};

/// The bus voltage by repeating V = V_oc − R P/V from V_oc on: its larger solution; `None` where it runs away.
fn fixed_point(open: f64, resistance: f64, power: f64) -> Option<f64> {
    let mut voltage = open;
    for _ in 0..200_000 {
        let next = open - resistance * power / voltage;
        if next.is_nan() || next <= 0.0 {
            return None;
        }
        if (next - voltage).abs() <= 1e-15 * open {
            return Some(next);
        }
        voltage = next;
    }
    // It only creeps where both solutions are one.
    (voltage > 0.499 * open).then_some(voltage)
}

fn bus(open: f64) -> Bus {
    let mut bus = common::robot(common::hold(1.0, 1.0, 0.0), GearModel::IDEAL).bus;
    bus.voltage = open;
    bus
}

/// 48 V behind 0.1 Ω: 480 W draw 13.09 A or 466.9 A of it, the drive sees 46.69 V; 5760 W are the most, at half the voltage.
#[test]
fn the_voltage_of_a_loaded_supply_is_that_on_paper() {
    let supply = Supply::new(&bus(48.0), 0.1, (1.0, 0.0), 0.0, 0.0);
    let current = (48.0 - (48.0_f64 * 48.0 - 4.0 * 0.1 * 480.0).sqrt()) / 0.2;
    assert!((supply.voltage(480.0).unwrap() - (48.0 - 0.1 * current)).abs() < 1e-12);
    assert!((supply.voltage(5760.0).unwrap() - 24.0).abs() < 1e-6 && supply.voltage(5760.1).is_none());
    // What comes back lifts it; and it does not where a brake takes it.
    assert!((supply.voltage(-480.0).unwrap() - fixed_point(48.0, 0.1, -480.0).unwrap()).abs() < 1e-12);
    let braked = Bus { regeneration: Regeneration::Dissipated, ..bus(48.0) };
    assert_eq!(Supply::new(&braked, 0.1, (1.0, 0.0), 0.0, 0.0).voltage(-480.0), Some(48.0));
    // The voltage that a sample needs with what it draws: 40 V and 480 W take 40 + 0.1 · 480/40 = 41.2 V.
    assert!((supply.needed(40.0 * 40.0, 480.0) - 41.2).abs() < 1e-12);
}

/// For random supplies and samples: what is needed is at most the open-circuit voltage where a bus that is solved by itself holds
/// the sample's voltage, and nowhere else; and no row leaves out a sample that is held.
#[test]
fn a_sample_is_held_where_the_bus_by_itself_holds_it() {
    let mut random = Pcg64::seed_from_u64(19);
    let mut held_at_all = 0;
    for k in 0..20_000 {
        let mut around = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
        let open = around(5.0, 100.0);
        let (resistance, circle) = (around(1e-3, 1.0), around(0.4, 1.0));
        let lost = if k % 3 == 0 { open * around(1e-3, 0.2) } else { 0.0 };
        let most = open * open / (4.0 * resistance);
        let needs = open * around(0.05, 1.2);
        let power = if k % 2 == 0 { most * around(1e-3, 1.3) } else { -most * around(1e-3, 1.0) };
        let bus = Bus { drive_efficiency: 0.9, ..bus(open) };
        let supply = Supply::new(&bus, resistance, (circle, lost * circle), 0.5, 0.0);
        let drawn = if power > 0.0 { power / 0.9 } else { 0.9 * power } + 0.5;
        let squared = (circle * (needs - lost).max(0.0)).powi(2);
        let needs = squared.sqrt() / circle + lost;
        let holds = fixed_point(open, resistance, drawn).is_some_and(|voltage| voltage >= needs);
        let needed = supply.needed(squared, power);
        if (needed / open - 1.0).abs() > 1e-6 {
            assert_eq!(needed <= open, holds, "{k}: {needed} of {open}, {needs} V, {drawn} W, {resistance} ohm");
        }
        held_at_all += u32::from(holds);
        assert!(supply.needed_at_most(squared, power) >= needed * (1.0 - 1e-12));
        // Rows of other samples leave it in where it is held, and its own touches.
        let row = |[v, p, c]: [f64; 3]| v * squared + p * power + c;
        assert!((row(supply.row(squared, power)) - needed).abs() <= 1e-9 * (open + needed), "{k}");
        for _ in 0..8 {
            let other = ((open * around(0.02, 1.5)).powi(2), (if around(0.5, 2.0) > 1.0 { 1.0 } else { -1.0 }) * most);
            assert!(!holds || row(supply.row(other.0, other.1)) <= open * (1.0 + 1e-9), "{k}");
        }
    }
    assert!(held_at_all > 5000, "{held_at_all}");
}

fn with<T>(case: &Case, look: impl FnOnce(&Prepared) -> T) -> T {
    let joint = &case.robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let candidate = Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap();
    look(&Prepared::new(candidate))
}

/// The verdict on the voltage is that of a bus solved sample by sample, for random joints at several ratios.
#[test]
fn the_voltage_is_kept_where_the_bus_of_every_sample_holds_it() {
    let (mut kept, mut broken) = (0, 0);
    for i in cases(420_000, 1000) {
        let mut case = draw(i, i.is_multiple_of(2));
        let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
        let (low, high) = (min.max(0.05 * max), max);
        let n = (low * high).sqrt();
        let peak = case.look(n).limits.iter().find(|l| l.0 == "bus_power").unwrap().1.abs().max(1e-9);
        let open = case.robot.bus.voltage;
        case.robot.bus.internal_resistance = Some(open * open / peak * [0.01, 0.05, 0.1, 0.3][(i % 4) as usize]);
        for n in [low, n, high] {
            let look = case.look(n);
            let resistance = case.robot.bus.internal_resistance.unwrap();
            let holds = |[needs, power]: &[f64; 2]| {
                fixed_point(open, resistance, *power).is_some_and(|voltage| voltage >= *needs)
            };
            let margin =
                with(&case, |p| p.at(n).margins.iter().find(|m| m.limit == "voltage").copied()).expect("it is asked");
            if margin.margin.abs() < 1e-6 {
                continue;
            }
            let all = look.bus.iter().all(holds);
            assert_eq!(margin.margin > 0.0, all, "case {i} at {n}: {margin:?}");
            if all { kept += 1 } else { broken += 1 }
        }
    }
    println!("{kept} kept, {broken} broken");
    assert!(kept > 100 && broken > 100, "{kept} {broken}");
}

/// 100 W at the terminals cost 125 W at η_d = 0.8. Of 100 W that come back 80 W are kept; or half where that is said; no more
/// than the bus takes where a brake has the rest; nothing where all is braked.
#[test]
fn what_is_kept_of_what_comes_back() {
    let at = |bus: &Bus, power: f64| {
        let (slope, constant) = Drawn::new(bus).line(power);
        slope * power + constant
    };
    let plain = Bus { drive_efficiency: 0.8, ..bus(48.0) };
    assert!((at(&plain, 100.0) - 125.0).abs() < 1e-12 && (at(&plain, -100.0) + 80.0).abs() < 1e-12);
    let half = Bus { regeneration_efficiency: Some(0.5), ..plain };
    assert!((at(&half, 100.0) - 125.0).abs() < 1e-12 && (at(&half, -100.0) + 50.0).abs() < 1e-12);
    let braked = Bus { regeneration: Regeneration::Limited(30.0), brake_power: Some(200.0), ..plain };
    assert!((at(&braked, -100.0) + 30.0).abs() < 1e-12 && (at(&braked, -20.0) + 16.0).abs() < 1e-12);
    // Of the 30 W that the supply takes at the bus it keeps what it keeps: 0.5/0.8.
    let both = Bus { regeneration_efficiency: Some(0.5), ..braked };
    assert!((at(&both, -100.0) + 30.0 * 0.5 / 0.8).abs() < 1e-12);
    assert_eq!(at(&Bus { regeneration: Regeneration::Dissipated, ..plain }, -100.0), 0.0);
    // Without a brake what is more is not lost, but not allowed.
    let limited = Bus { regeneration: Regeneration::Limited(30.0), ..plain };
    assert!((at(&limited, -100.0) + 80.0).abs() < 1e-12);
    // What the drive alone takes of it, and what the bus sees.
    assert!((Drawn::new(&half).by_drive().line(-1.0).0 - 0.8).abs() < 1e-12 && Drawn::new(&half).arrives() == 0.8);
    assert!(Drawn::new(&bus(48.0)).is_lossless() && !Drawn::new(&half).is_lossless());
}

/// 60 W that come back to 24 V behind 1 Ω lift the bus to 26.27 V. A brake takes what the supply does not, and no more: where the
/// supply takes 200 W and the brake 1 W, the bus still rises.
#[test]
fn a_small_brake_does_not_hold_the_bus() {
    let lifted = |bus: &Bus| Supply::new(bus, 1.0, (1.0, 0.0), 0.0, 0.0).lifted(60.0);
    let alone = 0.5 * (24.0 + (24.0_f64 * 24.0 + 240.0).sqrt());
    assert!((lifted(&bus(24.0)) - alone).abs() < 1e-12);
    // What the supply loses of it has lifted it before; it is from above.
    let lossy = Bus { regeneration_efficiency: Some(0.5), ..bus(24.0) };
    assert!((lifted(&lossy) - alone).abs() < 1e-12);
    let braked = |watts: f64| Bus { regeneration: Regeneration::Limited(watts), brake_power: Some(1.0), ..bus(24.0) };
    assert!((lifted(&braked(200.0)) - alone).abs() < 1e-12);
    assert!((lifted(&braked(20.0)) - 0.5 * (24.0 + (24.0_f64 * 24.0 + 80.0).sqrt())).abs() < 1e-12);
    assert_eq!(lifted(&Bus { regeneration: Regeneration::Dissipated, ..bus(24.0) }), 24.0);
    // As a limit: V_max (V_max − V)/R of the supply's part, and the brake on top.
    let catalog = Catalog::builtin().unwrap();
    let motor = catalog.motor("t-motor-ri50").unwrap();
    let limit = |change: &dyn Fn(&mut Bus)| {
        let mut robot = common::robot(common::hold(-3.0, 30.0, 0.0), common::gear(1.0));
        (robot.bus.voltage, robot.bus.internal_resistance, robot.bus.max_voltage) = (24.0, Some(1.0), Some(25.0));
        change(&mut robot.bus);
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let candidate = Mount::new(&robot, joint, &load, motor).candidate().unwrap();
        let at = Prepared::new(candidate).at(7.0);
        at.margins.iter().find(|m| m.limit == "bus_overvoltage").map(|m| (m.bound, m.margin > 0.0))
    };
    assert_eq!(limit(&|_| {}), Some((25.0, false)));
    let set = |regeneration: Regeneration, brake: Option<f64>| {
        limit(&move |bus: &mut Bus| (bus.regeneration, bus.brake_power) = (regeneration, brake))
    };
    assert_eq!(set(Regeneration::Limited(200.0), Some(1.0)), Some((26.0, false)));
    assert_eq!(set(Regeneration::Limited(20.0), Some(1.0)), None);
    assert_eq!(set(Regeneration::Dissipated, None), None);
}

/// A load that is lowered at 10 W: what is not kept is a part of the loss by itself.
#[test]
fn what_is_not_kept_is_a_part_of_the_loss() {
    let lowered = common::hold(-1.0, 10.0, 0.0);
    let catalog = Catalog::builtin().unwrap();
    let mut robot = common::robot(lowered, common::gear(1.0));
    let motor = catalog.motor("t-motor-ri50").unwrap();
    let at = |robot: &Robot| {
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let candidate = Mount::new(robot, joint, &load, motor).candidate().unwrap();
        Prepared::new(candidate).at(5.0)
    };
    let free = at(&robot);
    assert_eq!(free.losses.braking, 0.0);
    let back = -free.mean_power;
    assert!(back > 0.0);
    robot.bus.regeneration = Regeneration::Dissipated;
    let braked = at(&robot);
    assert!((braked.losses.braking - back).abs() < 1e-9 * back && braked.losses.drive == 0.0);
    assert!((braked.loss - free.loss - back).abs() < 1e-9 * back);
    (robot.bus.regeneration, robot.bus.regeneration_efficiency) = (Regeneration::Allowed, Some(0.75));
    let part = at(&robot);
    assert!((part.losses.braking - 0.25 * back).abs() < 1e-9 * back);
    robot.bus.drive_efficiency = 0.9;
    let both = at(&robot);
    assert!((both.losses.drive - 0.1 * back).abs() < 1e-9 * back);
    assert!((both.losses.braking - 0.15 * back).abs() < 1e-9 * back);
}

/// What must not be said: that a stiff bus holds what a sagging one does not; that other turns help there; and nothing at all of
/// other joints, whose power sags the bus as well.
#[test]
fn a_supply_that_sags_is_not_called_stiff() {
    let catalog = Catalog::builtin().unwrap();
    let motor = catalog.motor("t-motor-ri50").unwrap();
    let mut robot = common::robot(common::hold(10.0, 8.0, 0.0), common::gear(0.9));
    (robot.bus.voltage, robot.joints[0].ratio) =
        (48.0, RatioChoice::Listed { values: vec![7.0], step: None, teeth: None });
    let case = |robot: &Robot| {
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let candidate = Mount::new(robot, joint, &load, motor).candidate().unwrap();
        let prepared = Prepared::new(candidate);
        let at = prepared.at(7.0);
        let voltage = at.margins.iter().find(|m| m.limit == "voltage").copied().unwrap();
        (voltage, at.bus_voltage, prepared.judged(7.0).assumed)
    };
    let (stiff, none, _) = case(&robot);
    assert!(stiff.margin > 0.0 && none.is_none());
    robot.bus.internal_resistance = Some(2.0);
    let (sagging, voltage, assumed) = case(&robot);
    assert!(sagging.margin < 0.0 && voltage.unwrap().lowest.is_none(), "{sagging:?} {voltage:?}");
    assert!(assumed.iter().all(|(name, _)| *name != "voltage"));
    assert_eq!(can_be_asked(&robot, &robot.joints[0], motor), Err(NoTurns::SupplyResistance));
    robot.joints[0].count = 4;
    assert!(case(&robot).2.iter().any(|(name, what)| *name == "voltage" && what.contains("this joint alone")));
}

/// A drive that gives 8 A for ever is no choice at 10 A, and one without it is not checked; without durations nothing is said
/// to be kept.
#[test]
fn the_current_that_a_drive_gives_for_ever_is_a_limit() {
    let catalog = Catalog::builtin().unwrap();
    let motor = catalog.motor("t-motor-ri50").unwrap().clone();
    let mut robot = common::robot(common::hold(5.0, 1.0, 0.0), common::gear(1.0));
    robot.joints[0].ratio = RatioChoice::Listed { values: vec![5.0], step: None, teeth: None };
    let only = Catalog::of(vec![motor.clone()], Vec::new());
    let amplitude = 1.0 / motor.torque_constant / 1.5_f64.sqrt();
    let design = |robot: &Robot| optimize(robot, &only).joints[0].designs().next().map(|d| d.evaluation.clone());
    let margin = |robot: &Robot| {
        let of = design(robot)?;
        of.margins.iter().find(|m| m.limit == "drive_continuous_current").map(|m| m.margin)
    };
    assert_eq!(margin(&robot), None);
    robot.bus.drive.continuous_current = Some(1.25 * amplitude);
    assert!((margin(&robot).unwrap() - 0.2).abs() < 1e-9);
    robot.joints[0].drive.continuous_current = Some(0.8 * amplitude);
    assert!(design(&robot).is_none());
    let free = Motion::from_points(&[Point { torque: 5.0, velocity: 1.0, ..Point::default() }]);
    robot.joints[0].drive.continuous_current = Some(1.25 * amplitude);
    robot.joints[0].motion = free.into();
    assert!(optimize(&robot, &only).joints[0].candidates.is_empty(), "it cannot be judged");
}

/// Heat in the resistance against a bus that is solved by itself, point by point: taken, given back and standing still, with drive,
/// standby, a brake that takes all, and one that leaves a part.
#[test]
fn the_heat_in_the_supply_is_that_of_every_sample_by_itself() {
    let points = [(6.0, 20.0, 1.0), (2.0, 45.0, 2.0), (-9.0, 30.0, 0.5), (4.0, 0.0, 0.7)];
    let motion = points.map(|(torque, velocity, seconds)| Point {
        torque,
        velocity,
        duration: Some(seconds),
        ..Point::default()
    });
    let mut motor = Catalog::builtin().unwrap().motor("t-motor-ri50").unwrap().clone();
    motor.back_emf_constant = motor.torque_constant;
    (motor.coulomb_friction, motor.viscous_friction) = (Some(0.0), Some(0.0));
    let mut robot = common::robot(Motion::from_points(&motion), common::gear(1.0));
    robot.bus.drive_efficiency = 0.9;
    robot.joints[0].drive.standby_power = Some(3.0);
    let (open, ratio) = (48.0, 7.0);
    robot.bus.voltage = open;
    let evaluated = |robot: &Robot| common::evaluate(robot, &motor, ratio);
    assert!(evaluated(&robot).bus_voltage.is_none(), "a stiff supply has none");
    for (internal, lead) in [(0.2, 0.0), (0.0, 0.15), (0.4, 0.1)] {
        robot.bus.internal_resistance = Some(internal);
        robot.joints[0].drive.supply_lead_resistance = Some(lead);
        let resistance = internal + lead;
        // Of what comes back goes at most so much into the supply.
        for (regeneration, most) in [
            (Regeneration::Allowed, f64::INFINITY),
            (Regeneration::Dissipated, 0.0),
            (Regeneration::Limited(40.0), 40.0),
        ] {
            robot.bus.regeneration = regeneration;
            robot.bus.brake_power = matches!(regeneration, Regeneration::Limited(_)).then_some(1000.0);
            let (mut energy, mut lasts) = (0.0, 0.0);
            for (torque, velocity, seconds) in points {
                let current = torque / ratio / motor.torque_constant;
                let power = motor.resistance * current * current + torque * velocity;
                let bus = if power > 0.0 { power / 0.9 + 3.0 } else { f64::max(0.9 * power + 3.0, -most) };
                let volts = fixed_point(open, resistance, bus).unwrap();
                energy += seconds * resistance * (bus / volts).powi(2);
                lasts += seconds;
            }
            let found = evaluated(&robot).bus_voltage.unwrap().heat.unwrap();
            assert!((found - energy / lasts).abs() < 1e-9 * found, "{resistance} {regeneration:?}: {found}");
        }
    }
    // It is in no loss; and where the supply cannot give the power there is none to be said.
    let with = evaluated(&robot);
    (robot.bus.internal_resistance, robot.joints[0].drive.supply_lead_resistance) = (None, None);
    assert_eq!(with.loss, evaluated(&robot).loss);
    robot.bus.internal_resistance = Some(20.0);
    let none = evaluated(&robot).bus_voltage.unwrap();
    assert!(none.lowest.is_none() && none.heat.is_none());
}
