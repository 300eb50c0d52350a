//! Any small joint with any motor, solved, and the answer held against a plain scan.
//!
//! The one idea: bytes become a requirement and a catalogue as text, so that only what a user can write is asked;
//! the scan is that of `tests/raw`, which shares no formula with the program. Numbers go over many decades around a
//! scale on which motor and motion suit each other, limits lie around what the middle ratio needs, and both are
//! often exactly zero, exactly equal or exactly at a bound.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use arbitrary::Unstructured;
use gearwise::catalog::{Catalog, Gear, Motor};
use gearwise::design::answer::{Design, Reason};
use gearwise::design::optimize::optimize as solve_all;
use gearwise::design::program::Certificate;
use gearwise::input::Source;
use gearwise::requirement::{
    self, Course, GearModel, Joint, Motion, Point, Quantity, RatioChoice, Robot, backdrive_efficiency,
};

use super::super::raw::{Case, Scan};
use super::parts::Parts;
use super::solve::numbers;

/// Ratios that the scan looks at before it refines.
const RATIOS: usize = 100;
/// Stiffnesses and rest angles of a spring that are looked at, each.
const SPRINGS: usize = 5;

/// Numbers from bytes; when they run out, the plainest there are.
struct Draw<'a>(Unstructured<'a>);

impl Draw<'_> {
    fn below(&mut self, count: usize) -> usize {
        usize::from(self.0.arbitrary::<u8>().unwrap_or(0)) % count
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// True once in so many times.
    fn once_in(&mut self, count: usize) -> bool {
        self.below(count) == count - 1
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.arbitrary::<u16>().unwrap_or(1 << 15)) / 65536.0
    }

    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(self.within(low, high))
    }

    /// A share of one, often one of the ends or a half.
    fn share(&mut self) -> f64 {
        match self.below(6) {
            0 => 0.0,
            1 => 1.0,
            2 => -1.0,
            3 => 0.5,
            _ => self.within(-1.0, 1.0),
        }
    }
}

/// A joint and a motor as texts.
struct Asked {
    /// Column of the motor's row, with unit, and value.
    motor: BTreeMap<&'static str, String>,
    /// Keys of the tables, in TOML.
    bus: String,
    gear: String,
    joint: String,
    limits: String,
    motion: Option<String>,
    gears: Option<String>,
}

impl Asked {
    fn catalog(&self) -> Option<Catalog> {
        let header: Vec<&str> = self.motor.keys().copied().collect();
        let row: Vec<&str> = self.motor.values().map(String::as_str).collect();
        let text = format!(
            "id,source,source_kind,terminals,current,{}\nm,-,derived,q_axis,q_axis,{}\n",
            header.join(","),
            row.join(",")
        );
        let mut sources = vec![Arc::new(Source::new("motors.csv", text))];
        sources.extend(self.gears.as_ref().map(|text| Arc::new(Source::new("gears.csv", text.as_str()))));
        super::sane::accepted(Catalog::from_sources(sources))
    }

    fn text(&self) -> String {
        let Asked { bus, gear, joint, limits, .. } = self;
        let gear = if self.gears.is_some() { String::new() } else { format!("gear = {{ {gear} }}\n") };
        format!("name = 'r'\nbus = {{ {bus} }}\n[[joint]]\nname = 'j'\n{joint}{gear}limits = {{ {limits} }}\n")
    }

    fn robot(&self) -> Option<Robot> {
        let others = self.motion.iter().map(|text| ("motion.csv".to_string(), text.as_str())).collect();
        let mut files = Parts { main: "", others };
        let source = Arc::new(Source::new("requirement.toml", self.text()));
        super::sane::accepted(requirement::read_changed(&source, &[], &mut files))
    }

    /// Everything that was asked.
    fn shown(&self) -> String {
        let none = String::new();
        format!(
            "{}\n== motion.csv ==\n{}\n== motor ==\n{:#?}\n== gears ==\n{}",
            self.text(),
            self.motion.as_ref().unwrap_or(&none),
            self.motor,
            self.gears.as_ref().unwrap_or(&none)
        )
    }
}

/// The joint without limits; on what scale torque and the middle ratio are.
fn draw_asked(draw: &mut Draw) -> (Asked, f64) {
    let (torque, speed, period) = (draw.decades(-3.0, 4.0), draw.decades(-2.0, 3.0), draw.decades(-2.0, 1.0));
    let matched = draw.decades(-0.5, 2.5);
    let spring = draw.once_in(8);
    let geared = draw.once_in(4);
    let mut asked = Asked {
        motor: BTreeMap::new(),
        bus: String::new(),
        gear: String::new(),
        joint: String::new(),
        limits: String::new(),
        motion: None,
        gears: None,
    };
    draw_motion(draw, &mut asked, [torque, speed, period], spring);
    // The motor.
    let wild = if draw.once_in(8) { 4.0 } else { 1.0 };
    let inertia = torque * period / (speed * matched * matched) * draw.decades(-2.0 * wild, wild);
    let resistance = draw.decades(-2.5, 1.5);
    let constant = (resistance * torque / speed).sqrt() / matched * draw.decades(-0.5 * wild, wild);
    let motor = &mut asked.motor;
    let mut set = |column, value: f64| motor.insert(column, format!("{value:e}"));
    set("rotor_inertia [kg*m^2]", inertia);
    set("resistance [ohm]", resistance);
    set("torque_constant [N*m/A]", constant);
    set("mass [kg]", draw.decades(-2.0, 1.0));
    if draw.once_in(2) {
        set("inductance [H]", if draw.once_in(4) { 0.0 } else { resistance * draw.decades(-6.0, -1.5) });
    }
    if draw.once_in(2) {
        set(
            "viscous_friction [N*m*s/rad]",
            if draw.once_in(4) { 0.0 } else { inertia / period * draw.decades(-3.0, 1.0) },
        );
    }
    if draw.once_in(3) {
        set("coulomb_friction [N*m]", torque / matched * if draw.once_in(4) { 0.0 } else { draw.decades(-3.0, 0.5) });
    }
    if draw.once_in(3) {
        let back = constant * draw.pick(&[1.0, 0.9, 1.1, 0.1]);
        set("back_emf_constant [V*s/rad]", back);
        asked.motor.insert("back_emf_convention", "q_axis".into());
    }
    match draw.below(4) {
        0 => drop(asked.motor.insert("commutation", "brushed".into())),
        1 => {}
        _ => drop(asked.motor.insert("pole_pairs", (1 + draw.below(20)).to_string())),
    }
    let middle = matched * draw.decades(-0.5, 0.5);
    let middle = middle.clamp(1e-3, 1e4);
    draw_reduction(draw, &mut asked, [torque, inertia, middle], geared);
    let amplitude = 10.0 * torque * speed / constant.max(torque / speed * 1e-6);
    write!(asked.bus, "voltage = '{:e} V'", amplitude.clamp(1e-6, 1e6)).unwrap();
    if draw.once_in(4) {
        asked.bus += ", modulation = 'sine'";
    }
    if draw.once_in(4) {
        write!(asked.bus, ", drive_efficiency = {}, modulation_limit = 0.9", draw.pick(&[0.9, 0.5, 1.0])).unwrap();
    }
    if draw.once_in(6) {
        let (frequency, amplitude) = (draw.decades(-1.0, 1.5) / period, torque * draw.decades(-2.0, 0.0));
        write!(
            asked.limits,
            "torque_bandwidth = {{ frequency = '{frequency:e} Hz', amplitude = '{amplitude:e} N*m' }},"
        )
        .unwrap();
    }
    write!(asked.limits, "safety = {}", draw.pick(&[1.0, 1.2, 1.5])).unwrap();
    if spring {
        let angle = speed * period / 6.0;
        let (stiffness, rest) = (torque / angle * draw.decades(-1.0, 1.0), angle * draw.decades(-1.0, 0.5));
        let least = stiffness * draw.pick(&[0.0, 0.0, 0.5, 1.0]);
        write!(
            asked.limits,
            ", spring = {{ stiffness = ['{least:e} N*m/rad', '{stiffness:e} N*m/rad'], rest_angle = ['{:e} rad', '{rest:e} rad'] }}",
            -rest * draw.pick(&[1.0, -0.5, 0.0])
        )
        .unwrap();
    }
    (asked, middle)
}

/// Operating points, or a motion of few samples that repeats or happens once.
fn draw_motion(draw: &mut Draw, asked: &mut Asked, [torque, speed, period]: [f64; 3], spring: bool) {
    let kind = if spring { 3 } else { draw.below(4) };
    let timed = draw.below(4) > 0;
    let count = 1 + draw.below(if kind < 2 { 5 } else { 8 });
    let mut rows: Vec<[f64; 5]> = Vec::new();
    for _ in 0..count {
        let given = [torque * draw.share(), speed * draw.share(), speed / period * draw.share()];
        rows.push([given[0], given[1], given[2], torque / period * draw.share(), draw.within(0.1, 2.0) * period]);
    }
    if kind < 2 {
        let point = |[torque, speed, acceleration, rate, duration]: &[f64; 5]| {
            let duration = if timed { format!(", duration = '{duration:e} s'") } else { String::new() };
            format!(
                "{{ torque = '{torque:e} N*m', speed = '{speed:e} rad/s', acceleration = '{acceleration:e} rad/s^2', \
                 torque_rate = '{rate:e} N*m/s'{duration} }}"
            )
        };
        let points: Vec<String> = rows.iter().map(point).collect();
        writeln!(asked.joint, "points = [{}]", points.join(", ")).unwrap();
        return;
    }
    let periodic = kind == 3;
    let all = draw.once_in(2) && !spring;
    let mut text = String::from("time [s],torque [N*m],");
    text += if spring { "position [rad]" } else { "velocity [rad/s]" };
    text += if all { ",acceleration [rad/s^2],torque_rate [N*m/s]\n" } else { "\n" };
    let mut time = 0.0;
    let first = rows[0];
    let closing = periodic.then_some(first);
    for [torque, speed, acceleration, rate, step] in rows.into_iter().chain(closing) {
        let moved = if spring { speed * period / 6.0 } else { speed };
        write!(text, "{time:e},{torque:e},{moved:e}").unwrap();
        if all {
            write!(text, ",{acceleration:e},{rate:e}").unwrap();
        }
        text.push('\n');
        time += step;
    }
    asked.motion = Some(text);
    writeln!(asked.joint, "motion = 'motion.csv'\nperiodic = {periodic}").unwrap();
}

/// A continuous ratio with its gear, or gears of a list.
fn draw_reduction(draw: &mut Draw, asked: &mut Asked, [torque, inertia, middle]: [f64; 3], geared: bool) {
    if geared {
        let mut text = String::from(
            "id,kind,ratio,efficiency,backdrive_efficiency,mass [kg],inertia [kg*m^2],peak_torque [N*m],source,source_kind\n",
        );
        for k in 0..1 + draw.below(4) {
            let (ratio, efficiency) = (middle * draw.decades(-1.0, 1.0), draw.pick(&[1.0, 0.9, 0.6, 0.3]));
            let back = draw.pick(&["", "0.5", "0", "1"]);
            let of_gear = if draw.once_in(2) { inertia * draw.decades(-2.0, 1.0) } else { 0.0 };
            let most = if draw.once_in(3) { format!("{:e}", torque * draw.decades(-0.3, 1.0)) } else { String::new() };
            writeln!(
                text,
                "spur-{k},spur,{ratio:e},{efficiency},{back},{:e},{of_gear:e},{most},-,derived",
                draw.decades(-2.0, 0.5)
            )
            .unwrap();
        }
        asked.gears = Some(text);
        asked.joint += "gears = ['spur-*']\n";
        return;
    }
    let (low, high) = match draw.below(6) {
        0 => (0.0, 0.0),
        _ => (draw.within(-2.0, 0.0), draw.within(0.0, 2.0)),
    };
    let (min, max) = (middle * 10_f64.powf(low), middle * 10_f64.powf(high));
    writeln!(asked.joint, "ratio = {{ min = {min:e}, max = {max:e} }}").unwrap();
    write!(asked.gear, "efficiency = {}", draw.pick(&[1.0, 0.95, 0.8, 0.5, 0.3])).unwrap();
    if draw.once_in(3) {
        write!(asked.gear, ", backdrive_efficiency = {}", draw.pick(&[0.9, 0.0, -0.5, 1.0])).unwrap();
    }
    if draw.once_in(2) {
        write!(asked.gear, ", inertia = '{:e} kg*m^2'", inertia * draw.decades(-2.0, 1.0)).unwrap();
    }
    match draw.below(3) {
        0 => {}
        1 => write!(asked.gear, ", mass = '{:e} kg'", draw.decades(-2.0, 0.5)).unwrap(),
        _ => {
            let stage = draw.pick(&[3.0, 5.0, 10.0, 1.1]);
            write!(asked.gear, ", mass_per_stage = '{:e} kg', stage_ratio = {stage}", draw.decades(-2.0, 0.5)).unwrap();
        }
    }
}

/// Limits around what the middle ratio needs, and what is minimised.
fn draw_limits(
    draw: &mut Draw,
    asked: &mut Asked,
    need: &BTreeMap<&str, f64>,
    quantities: [f64; 7],
    [resistance, duration]: [f64; 2],
) {
    let often = draw.pick(&[8, 4, 2]);
    let mut allow = |name: &str| {
        let there = draw.once_in(often);
        let factor = match draw.below(4) {
            0 => 1.0,
            1 => draw.decades(-2.0, 2.0),
            _ => draw.decades(-0.2, 0.8),
        };
        Some(need[name] * factor).filter(|most| there && (1e-15..1e15).contains(most))
    };
    let columns = [
        ("peak_current [A]", "peak_current"),
        ("peak_torque [N*m]", "peak_torque"),
        ("continuous_current [A]", "continuous_current"),
        ("continuous_torque [N*m]", "continuous_torque"),
        ("max_speed [rad/s]", "max_speed"),
    ];
    for (column, name) in columns {
        if let Some(most) = allow(name) {
            asked.motor.insert(column, format!("{most:e}"));
        }
    }
    let heat = allow("continuous_current").map(|i| 60.0 / (i * i * resistance)).filter(|r| (1e-12..1e12).contains(r));
    type Table = fn(&mut Asked) -> &mut String;
    let (bus, gear, limits): (Table, Table, Table) = (|a| &mut a.bus, |a| &mut a.gear, |a| &mut a.limits);
    let keys = [
        (bus, "power", "bus_power", "W"),
        (bus, "current", "bus_current", "A"),
        (bus, "drive_current", "peak_current", "A"),
        (gear, "peak_torque", "gear_peak_torque", "N*m"),
        (gear, "continuous_torque", "gear_continuous_torque", "N*m"),
        (gear, "max_input_speed", "gear_input_speed", "rad/s"),
        (limits, "reflected_inertia", "reflected_inertia", "kg*m^2"),
        (limits, "actuator_mass", "actuator_mass", "kg"),
    ];
    // A gear whose continuous torque is above its peak is refused.
    let mut gear_peak = f64::INFINITY;
    for (table, key, name, unit) in keys {
        if let Some(mut most) = allow(name) {
            match key {
                "peak_torque" => gear_peak = most,
                "continuous_torque" => most = most.min(gear_peak),
                _ => {}
            }
            write!(table(asked), ", {key} = '{most:e} {unit}'").unwrap();
        }
    }
    let (voltage, back) = (allow("voltage"), allow("regeneration"));
    if let Some(volt) = voltage {
        let rest = asked.bus.split_once(',').map_or(String::new(), |(_, rest)| format!(",{rest}"));
        asked.bus = format!("voltage = '{:e} V'{rest}", (volt / 0.6).clamp(1e-12, 1e6));
    }
    match draw.below(6) {
        0 => asked.bus += ", regeneration = 'none'",
        1 => back.map_or((), |watt| write!(asked.bus, ", regeneration = '{watt:e} W'").unwrap()),
        _ => {}
    }
    if let Some(total) = heat {
        let share = draw.pick(&[0.5, 0.1, 0.9]);
        asked.motor.insert("thermal_resistance_winding_housing [K/W]", format!("{:e}", total * share));
        asked.motor.insert("thermal_resistance_housing_ambient [K/W]", format!("{:e}", total * (1.0 - share)));
        if draw.once_in(2) {
            asked
                .motor
                .insert("thermal_time_constant_winding [s]", format!("{:e}", duration * draw.decades(-1.0, 2.0)));
            asked.motor.insert("thermal_time_constant_housing [s]", format!("{:e}", duration * draw.decades(1.0, 4.0)));
        }
        asked.motor.insert("max_winding_temperature [degC]", draw.pick(&["120", "60", "155"]).into());
        if draw.once_in(2) {
            asked.limits += ", winding_temperature = '100 degC'";
        }
    }
    let objectives = ["copper_loss", "loss", "reflected_inertia", "peak_current", "mass", "energy", "peak_power"];
    // No row of it says a no-load current.
    asked.joint += "motor_drag = 'off'\n";
    match draw.below(3) {
        0 => writeln!(asked.joint, "objective = '{}'", draw.pick(&objectives)).unwrap(),
        _ if quantities[1] <= 0.0 => {}
        _ => {
            let (name, quantity) = draw.pick(&Quantity::NAMES[2..]);
            let usual = quantities[quantity as usize].abs().max(1e-3 * quantities[1]);
            let (of_loss, other) = (quantities[1], usual * draw.decades(-1.0, 1.0));
            let one = |x: f64, quantity: Quantity| format!("'{:e} {}'", x.clamp(1e-15, 1e15), quantity.unit());
            writeln!(
                asked.joint,
                "objective = {{ copper_loss = 1, {name} = 1 }}\nreference = {{ copper_loss = {}, {name} = {} }}",
                one(of_loss, Quantity::CopperLoss),
                one(other, quantity)
            )
            .unwrap();
        }
    }
}

/// The samples of a motion one by one, as the scan takes them.
fn points(motion: &Motion) -> Vec<Point> {
    let total = motion.duration().filter(|_| matches!(motion.course, Course::Points(_)));
    let point = |k: usize| Point {
        torque: motion.torque[k],
        velocity: motion.velocity[k],
        acceleration: motion.acceleration[k],
        torque_rate: motion.torque_rate[k],
        jerk: motion.jerk[k],
        duration: total.map(|total| total * motion.weight[k]),
    };
    (0..motion.len()).map(point).collect()
}

/// The joint with a ratio in a range, and a gear, for the scan.
fn case_of(robot: &Robot, motor: &Motor, gear: GearModel, range: (f64, f64)) -> Case {
    let mut robot = robot.clone();
    let joint = &mut robot.joints[0];
    (joint.gear, joint.ratio) = (gear, RatioChoice::Continuous { min: range.0, max: range.1 });
    let motion = &joint.motion;
    let raw = points(motion);
    // Between given samples there are instants with weights of their own (tests/library/proof/instants.rs looks at those).
    let own = (motion.given.len() < motion.len())
        .then(|| motion.weight.iter().zip(&motion.dwell).map(|(all, rest)| [*all, *rest]).collect());
    let mut case = Case::new(motor.clone(), robot, raw);
    case.shares = own.unwrap_or(case.shares);
    case
}

fn model(gear: &Gear) -> GearModel {
    let efficiency = gear.efficiency.expect("every gear of the list has one");
    GearModel {
        efficiency,
        backdrive_efficiency: gear.backdrive_efficiency.unwrap_or_else(|| backdrive_efficiency(efficiency)),
        mass: gear.mass,
        mass_per_stage: None,
        inertia: gear.inertia.unwrap_or(0.0),
        peak_torque: gear.peak_torque,
        continuous_torque: gear.continuous_torque,
        max_input_speed: gear.max_input_speed,
        ..GearModel::IDEAL
    }
}

/// What the terms of the copper loss come to if none takes away from another, over the loss: the digits that
/// any way of computing it may lose.
fn cancelled(case: &Case, n: f64) -> f64 {
    let (motor, gear) = (&case.motor, &case.robot.joints[0].gear);
    let j = motor.rotor_inertia.unwrap_or(0.0) + gear.inertia;
    let (b, c) = (motor.viscous_friction.unwrap_or(0.0), motor.coulomb_friction.unwrap_or(0.0));
    let through = (1.0 / gear.efficiency).max(gear.backdrive_efficiency.abs());
    let size = |p: &Point| through * p.torque.abs() / n + n * (j * p.acceleration.abs() + b * p.velocity.abs()) + c;
    let most: f64 = case.raw.iter().zip(&case.shares).map(|(p, s)| s[0] * size(p).powi(2)).sum();
    let loss = case.look(n).quantities[1];
    let terms = motor.resistance * most / motor.torque_constant.powi(2);
    if terms == 0.0 { 1.0 } else { terms / loss.max(f64::MIN_POSITIVE) }
}

/// The design's numbers are those of the plain look, and the limits are kept there.
fn looks_the_same(case: &Case, design: &Design) {
    let (n, at) = (design.optimum.ratio, &design.evaluation);
    let doubt = 1e-7 + 1e-12 * cancelled(case, n);
    if doubt > 1e-4 {
        return;
    }
    let (over, limit) = case.worst(n);
    assert!(over < doubt, "{limit} is exceeded by {over} at {n}");
    let look = case.look(n);
    let size = size_of(case, look.objective);
    let apart = (design.optimum.objective - look.objective).abs();
    assert!(apart <= doubt.max(1e-6) * size, "{:?}: the plain look has {}", design.optimum, look.objective);
    let losses = [Some(at.loss), Some(at.copper_loss)];
    let others = [Some(at.reflected_inertia), Some(at.peak_current), at.mass, at.energy, at.peak_power];
    let reported = losses.into_iter().chain(others);
    // The energy that comes back is taken from what is drawn: it is measured by both.
    let size = [0, 1, 2, 3, 4, 5, 6].map(|k| look.quantities[k].abs());
    for ((_, quantity), (plain, reported)) in Quantity::NAMES.iter().zip(look.quantities.into_iter().zip(reported)) {
        let Some(reported) = reported else { continue };
        let usual = match quantity {
            Quantity::Loss | Quantity::Energy | Quantity::PeakPower => size[5].max(size[6]).max(size[1]).max(size[0]),
            other => size[*other as usize],
        };
        let wrong = (reported - plain).abs() > doubt.max(1e-6) * usual;
        assert!(!wrong, "{quantity:?} at {n}: {reported}, the plain look has {plain}");
    }
}

/// Bytes as a robot with one joint, and a catalogue with one motor. `None` where the readers refuse them.
pub fn draw(bytes: &[u8]) -> Option<(Robot, Catalog)> {
    let mut draw = Draw(Unstructured::new(bytes));
    let (mut asked, middle) = draw_asked(&mut draw);
    // What the middle ratio needs.
    let (free, catalog) = (asked.robot()?, asked.catalog()?);
    let gear = catalog.gears.first().map_or(free.joints[0].gear, model);
    let at = case_of(&free, &catalog.motors[0], gear, (middle, middle)).look(middle);
    let need: BTreeMap<&str, f64> = at.limits.iter().map(|limit| (limit.0, limit.1)).collect();
    let scale = [catalog.motors[0].resistance, free.joints[0].motion.duration().unwrap_or(1.0)];
    draw_limits(&mut draw, &mut asked, &need, at.quantities, scale);
    let found = (asked.robot()?, asked.catalog()?);
    // For whoever looks into a finding.
    if std::env::var_os("FUZZ_SHOW").is_some() {
        eprintln!("{}", asked.shown());
    }
    Some(found)
}

/// Bytes as a joint; the answer against the scan.
pub fn optimize(bytes: &[u8]) {
    let Some((robot, catalog)) = draw(bytes) else { return };
    let found = solve_all(&robot, &catalog).joints.remove(0);
    let answer = match (found.designs().next(), found.rejected.first()) {
        (Some(design), None) => Ok(design),
        (None, Some(rejected)) => Err(&rejected.reason),
        other => panic!("one motor, one answer: {other:?}"),
    };
    if std::env::var_os("FUZZ_SHOW").is_some() {
        eprintln!("== answer ==\n{:?}", answer.map(|design| &design.optimum));
    }
    judge(&robot, &catalog, answer);
}

/// Holds an answer against the scan.
pub fn judge(robot: &Robot, catalog: &Catalog, answer: Result<&Design, &Reason>) {
    let (joint, motor) = (&robot.joints[0], &catalog.motors[0]);
    if let Ok(design) = answer {
        numbers(design);
    }
    match (&joint.ratio, joint.limits.spring) {
        (RatioChoice::Continuous { min, max }, None) => {
            one_ratio(&case_of(robot, motor, joint.gear, (*min, *max)), answer);
        }
        (RatioChoice::Continuous { min, max }, Some(_)) => with_springs(robot, motor, joint.gear, (*min, *max), answer),
        (RatioChoice::Catalog { .. }, None) => of_gears(robot, motor, &catalog.gears, answer),
        // What is listed is held against a plain look at each by the tests of the proof.
        (RatioChoice::Listed { .. }, _) => {}
        // A spring with gears of a list is each gear's own problem.
        (RatioChoice::Catalog { .. }, Some(_)) => {}
    }
}

/// The best that the scan has found within the limits, with room to spare, and by how much that may be wrong.
struct Best {
    ratio: f64,
    objective: f64,
}

fn best_of(case: &Case, scan: &Scan) -> Option<Best> {
    let mut best: Option<Best> = None;
    let ends = scan.windows.iter().flat_map(|w| [w[0], w[1], (w[0] * w[1]).sqrt()]);
    for ratio in scan.grid.iter().copied().chain(ends) {
        // Room to spare: what rounding leaves of a limit that binds is no better design.
        if case.worst(ratio).0 > -1e-8 || cancelled(case, ratio) > 1e5 {
            continue;
        }
        let objective = case.look(ratio).objective;
        if best.as_ref().is_none_or(|b| objective < b.objective) {
            best = Some(Best { ratio, objective });
        }
    }
    best
}

/// What differences of the objective are measured by.
fn size_of(case: &Case, value: f64) -> f64 {
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let usual =
        [min, (min * max).sqrt(), max].map(|n| case.look(n).objective.abs()).into_iter().fold(f64::MAX, f64::min);
    value.abs().max(1e-6 * usual).max(1e-300)
}

/// A continuous ratio against the scan.
fn one_ratio(case: &Case, answer: Result<&Design, &Reason>) {
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let scan = Scan::over(case, if min == max { 1 } else { RATIOS });
    let best = best_of(case, &scan);
    match answer {
        Ok(design) => {
            looks_the_same(case, design);
            let objective = design.optimum.objective;
            let Some(best) = best else { return };
            let size = size_of(case, objective);
            let (gap, bound) = match design.optimum.certificate {
                Certificate::Certified { gap, lower_bound, .. } => (gap, Some(lower_bound)),
                Certificate::NotCertified(_) => (0.0, None),
            };
            let Best { ratio, objective: value } = best;
            assert!(
                value >= objective - (gap + 1e-6) * size,
                "the scan has {value} at {ratio}, better than {:?}",
                design.optimum
            );
            assert!(
                bound.is_none_or(|b| value >= b - 1e-8 * size),
                "{value} at {ratio} is below the bound: {:?}",
                design.optimum
            );
        }
        Err(Reason::Unusable(_)) => {}
        Err(Reason::Infeasible(_)) => {
            assert!(best.is_none(), "said to be infeasible, but {} keeps all limits", best.map_or(0.0, |b| b.ratio));
        }
        Err(reason) => {
            let kept = best.map(|b| b.ratio);
            assert!(kept.is_none(), "not solved ({reason:?}), but {kept:?} keeps all limits");
        }
    }
}

/// Gears of a list: each is looked at.
fn of_gears(robot: &Robot, motor: &Motor, gears: &[Gear], answer: Result<&Design, &Reason>) {
    let cases = gears.iter().map(|g| (g, case_of(robot, motor, model(g), (g.ratio, g.ratio))));
    let mut best: Option<(&Gear, f64)> = None;
    for (gear, case) in cases {
        if let Ok(design) = answer
            && design.gear == Some(gear.id.as_str())
        {
            looks_the_same(&case, design);
        }
        let objective = case.look(gear.ratio).objective;
        let kept = case.worst(gear.ratio).0 < -1e-8 && cancelled(&case, gear.ratio) < 1e5;
        if kept && best.is_none_or(|(_, value)| objective < value) {
            best = Some((gear, objective));
        }
    }
    let Some((gear, value)) = best else { return };
    match answer {
        Ok(design) => {
            let objective = design.optimum.objective;
            let size = objective.abs().max(1e-300);
            assert!(value >= objective - 1e-6 * size, "{} has {value}, better than {:?}", gear.id, design.optimum);
        }
        Err(Reason::Unusable(_)) => {}
        Err(reason) => panic!("{} keeps all limits, but: {reason:?}", gear.id),
    }
}

/// A spring: ratios, stiffnesses and rest angles are looked at.
fn with_springs(robot: &Robot, motor: &Motor, gear: GearModel, range: (f64, f64), answer: Result<&Design, &Reason>) {
    let spring = robot.joints[0].limits.spring.expect("a spring is asked for");
    let sprung = |stiffness: f64, rest: f64| {
        let mut robot = robot.clone();
        let joint: &mut Joint = &mut robot.joints[0];
        joint.motion = joint.motion.with_spring(stiffness, rest).expect("a motion with a position").into();
        case_of(&robot, motor, gear, range)
    };
    if let Ok(design) = answer {
        let choice = design.spring.expect("a spring was asked for");
        let rest = choice.rest_angle.unwrap_or(spring.rest_angle[0]);
        looks_the_same(&sprung(choice.stiffness, rest), design);
    }
    let between = |[low, high]: [f64; 2], k: usize| low + (high - low) * k as f64 / (SPRINGS - 1) as f64;
    for k in 0..SPRINGS * SPRINGS {
        let (stiffness, rest) = (between(spring.stiffness, k / SPRINGS), between(spring.rest_angle, k % SPRINGS));
        let case = sprung(stiffness, rest);
        let grid = (0..=20).map(|i| range.0 * (range.1 / range.0).powf(f64::from(i) / 20.0));
        for n in grid {
            if case.worst(n).0 > -1e-7 || cancelled(&case, n) > 1e5 {
                continue;
            }
            let value = case.look(n).objective;
            match answer {
                Ok(design) => {
                    let choice = design.spring.expect("a spring was asked for");
                    let size = size_of(&case, design.optimum.objective);
                    // Without a bound nothing was claimed.
                    let Some(bound) = choice.lower_bound else { continue };
                    assert!(
                        value >= bound - 1e-6 * size,
                        "{value} at {n} with {stiffness} N*m/rad at {rest} rad is below the bound of {choice:?}, {:?}",
                        design.optimum
                    );
                }
                Err(Reason::Infeasible(_)) => {
                    panic!("said to be infeasible, but {n} with {stiffness} N*m/rad at {rest} rad keeps all limits")
                }
                Err(_) => {}
            }
        }
    }
}
