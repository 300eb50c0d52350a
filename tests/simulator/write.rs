//! A bench on disk: bench file, catalogue, logs.

use super::random::Random;
use super::world::{Nature, Trace};
use super::{Bench, Channel, EffectTruth, Kind, LogTruth, Truth, sense, unfriendly};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The motor's name in the catalogue.
const MOTOR: &str = "bench-motor";

/// Key of a channel in the bench file, column of the log, unit, and further keys.
fn column(bench: &Bench, channel: Channel) -> (&'static str, &'static str, &'static str, &'static str) {
    let linear = bench.kind == Kind::Linear;
    let output = bench.kind == Kind::Servo;
    match channel {
        Channel::Position if linear => ("position", "x_m", "m", ""),
        Channel::Velocity if linear => ("velocity", "v_mps", "m/s", ""),
        Channel::Position if output => ("position", "q_rad", "rad", ", side = \"output\""),
        Channel::Position => ("position", "q_rad", "rad", ", side = \"motor\""),
        Channel::Velocity => ("velocity", "w_radps", "rad/s", ", side = \"motor\""),
        Channel::OutputPosition => ("output_position", "q_out_rad", "rad", ", side = \"output\""),
        Channel::OutputVelocity => ("output_velocity", "w_out_radps", "rad/s", ", side = \"output\""),
        Channel::Current if bench.sensors.phase_amplitude => {
            ("current", "iq_a", "A", ", convention = \"phase_amplitude\"")
        }
        Channel::Current => ("current", "iq_a", "A", ", convention = \"q_axis\""),
        Channel::Torque => ("torque", "tau_nm", "N*m", ", side = \"output\""),
        Channel::Voltage => ("voltage", "vq_v", "V", ", convention = \"q_axis\""),
        Channel::WindingTemperature => ("winding_temperature", "t_winding_c", "degC", ""),
        Channel::HousingTemperature => ("housing_temperature", "t_housing_c", "degC", ""),
        // This servo is analogue: its duty and goal go on between the rows.
        Channel::Duty => ("duty", "duty", "1", ", held = false"),
        Channel::Goal => ("goal", "goal_rad", "rad", ", side = \"output\", held = false"),
        Channel::Supply => ("supply", "supply_v", "V", ""),
        Channel::Force => ("force", "force_n", "N", ""),
        Channel::Command => ("command", "command_a", "A", ""),
    }
}

/// Unit of the target per unit of its channel: noise is said in the target's unit.
fn target_per_channel(bench: &Bench) -> f64 {
    match bench.kind {
        Kind::Free if bench.sensors.phase_amplitude => {
            bench.machine.ratio * bench.machine.torque_constant * 1.5_f64.sqrt()
        }
        Kind::Free => bench.machine.ratio * bench.machine.torque_constant,
        _ => 1.0,
    }
}

pub fn write(bench: &Bench, directory: &Path) -> Truth {
    let (nature, noise_rms, sizes, bases) = bench.settle();
    let effects = bench
        .effects
        .iter()
        .zip(&sizes)
        .map(|(&(effect, _), &rms)| EffectTruth {
            effect,
            name: effect.name(),
            parameters: nature.parameters(effect),
            rms,
        })
        .collect();
    let logs: Vec<LogTruth> = bases
        .into_iter()
        .enumerate()
        .map(|(log, base)| write_log(bench, &nature, noise_rms, log, base, directory))
        .collect();
    if bench.one_file {
        join(&logs, directory);
    }
    fs::write(directory.join("motors.csv"), catalog(bench)).expect("the catalogue can be written");
    let path = directory.join("bench.toml");
    fs::write(&path, bench_file(bench, &logs)).expect("the bench file can be written");
    Truth {
        kind: bench.kind,
        seed: bench.seed,
        bench: path,
        effects: if bench.shuffled { Vec::new() } else { effects },
        noise_rms,
        unit: bench.kind.unit(),
        motor: MOTOR.into(),
        machine: bench.machine.clone(),
        nature,
        declared: bench.declared,
        sensors: bench.sensors.clone(),
        logs,
    }
}

/// Adds a log of a machine that was written before to its bench file.
pub fn add(bench: &Bench, truth: &Truth, log: usize, directory: &Path) {
    let effects: Vec<_> = bench.effects.iter().map(|(effect, _)| *effect).collect();
    let base = Nature::new(bench.machine.clone(), &effects, &mut Random::new(bench.seed, "nature"));
    let base = bench.simulate(&base, log);
    // The log after the last is none that judges.
    let bench = &Bench { logs: usize::MAX, ..bench.clone() };
    let written = write_log(bench, &truth.nature, truth.noise_rms, log, base, directory);
    let name = written.file.file_name().expect("a file").to_string_lossy();
    let mut text = fs::read_to_string(&truth.bench).expect("it was written");
    let _ = writeln!(text, "[[log]]\nfile = \"{name}\"\nuse = \"fit\"");
    fs::write(&truth.bench, text).expect("the bench file can be written");
}

fn write_log(bench: &Bench, nature: &Nature, noise_rms: f64, log: usize, base: Trace, directory: &Path) -> LogTruth {
    let mut random = Random::new(bench.seed, &format!("instruments {log}"));
    let target = bench.kind.target_channel();
    let file = directory.join(format!("log{}.csv", log + 1));
    let held_out = bench.logs > 1 && log + 1 == bench.logs;
    let zero = bench.sensors.zeros * noise_rms * random.normal();
    let gain = bench.sensors.gain_error.filter(|(which, _)| *which == log).map_or(1.0, |(_, gain)| gain);
    let scale = target_per_channel(bench);
    let channels: Vec<Channel> =
        bench.kind.channels().iter().copied().filter(|c| !bench.sensors.hidden.contains(c)).collect();
    let times = sense::times(bench.rate, bench.duration, &bench.sensors, &mut random);
    let unfriendly = &bench.sensors.unfriendly;
    let plain = sense::noise(&times, bench.sensors.colored, &mut random);
    let mut own = Random::new(bench.seed, &format!("unfriendly noise {log}"));
    let mut noise: Vec<f64> = unfriendly
        .noise(&times, base.step, bench.sensors.colored, &mut own)
        .unwrap_or(plain)
        .iter()
        .map(|n| n * noise_rms)
        .collect();
    let full = bench.simulate(nature, log);
    let mut contribution = difference(bench, &full, &base, &times);
    let mut apart = apart(bench, nature, log, &base, &times, &contribution);
    // In a shuffled log the machine is the plain one and the pieces come as noise.
    let mut trace = if bench.shuffled { base } else { full };
    let noise_free = trace.clone();
    if let Some(corner) = unfriendly.anti_alias {
        filter_target(bench.kind, &mut trace, corner);
    }
    if bench.shuffled {
        contribution = shuffle(&contribution, (0.25 * bench.rate) as usize, &mut random);
    }
    let mut table: Vec<Vec<f64>> = channels
        .iter()
        .map(|&channel| {
            // A servo's position is that of its output.
            let read = if bench.kind == Kind::Servo && channel == Channel::Position {
                Channel::OutputPosition
            } else {
                channel
            };
            sense::read(read, &trace, &times, &bench.sensors, &mut random)
        })
        .collect();
    let mut rounding = Vec::new();
    for (channel, values) in channels.iter().zip(&mut table) {
        if *channel == target {
            for (k, value) in values.iter_mut().enumerate() {
                let extra = if bench.shuffled { contribution[k] } else { 0.0 };
                *value = (*value + (zero + noise[k] + extra) / scale) * gain;
            }
            let before = values.clone();
            if bench.kind == Kind::Servo {
                unfriendly::quantise(values, TAU / bench.sensors.output_counts);
            }
            if let Some(quantum) = unfriendly.quantum {
                unfriendly::quantise(values, quantum * noise_rms / scale);
            }
            rounding = values.iter().zip(&before).map(|(v, b)| (v - b) * scale).collect();
        } else if *channel == Channel::Current {
            // A current sensor of a hundredth of a percent beside a better judge.
            values.iter_mut().for_each(|v| *v += 1e-4 * bench.machine.peak_current * random.normal());
        }
    }
    for (channel, values) in channels.iter().zip(&mut table) {
        for turned in [bench.sensors.wrong_sign, bench.sensors.reversed] {
            if turned == Some(*channel) {
                values.iter_mut().for_each(|v| *v = -*v);
            }
        }
    }
    for (channel, values) in channels.iter().zip(&mut table) {
        unfriendly.spoil(*channel, log, &times, values);
    }
    // What the rows repeat of the target they repeat of its parts.
    for part in [&mut noise, &mut contribution, &mut rounding].into_iter().chain(&mut apart) {
        unfriendly::hold(part, unfriendly.rows_held(target));
    }
    let mut text = String::new();
    let header: Vec<&str> = channels.iter().map(|&c| column(bench, c).1).collect();
    let timed = bench.kind != Kind::SteadyTable;
    let _ = writeln!(text, "{}{}", if timed { "t_s," } else { "" }, header.join(","));
    for (k, time) in times.iter().enumerate() {
        if timed {
            let _ = write!(text, "{time:.6},");
        }
        for (c, values) in table.iter().enumerate() {
            let comma = if c == 0 { "" } else { "," };
            let blank = bench.sensors.dropouts > 0.0 && random.chance(bench.sensors.dropouts);
            let _ = if blank { write!(text, "{comma}") } else { write!(text, "{comma}{}", Short(values[k])) };
        }
        text.push('\n');
    }
    fs::write(&file, text).expect("the log can be written");
    LogTruth { file, held_out, times, noise, contribution, apart, rounding, zero, trace: noise_free }
}

/// What one world's target has more than another's, at the rows, behind the filter of the target.
fn difference(bench: &Bench, one: &Trace, other: &Trace, times: &[f64]) -> Vec<f64> {
    let mut fine: Vec<f64> =
        (0..one.motor_angle.len()).map(|k| bench.balance(one, k) - bench.balance(other, k)).collect();
    if let Some(corner) = bench.sensors.unfriendly.anti_alias {
        fine = sense::low_pass(&fine, one.step, corner);
    }
    times.iter().map(|&t| sense::at(&fine, one.step, t)).collect()
}

/// What each effect alone contributes.
fn apart(bench: &Bench, nature: &Nature, log: usize, base: &Trace, times: &[f64], all: &[f64]) -> Vec<Vec<f64>> {
    if bench.effects.len() < 2 {
        return bench.effects.iter().map(|_| all.to_vec()).collect();
    }
    let without = |kept: usize| {
        let mut alone = nature.clone();
        for (k, (effect, _)) in bench.effects.iter().enumerate() {
            if k != kept {
                alone.set(*effect, 0.0);
            }
        }
        alone
    };
    (0..bench.effects.len()).map(|k| difference(bench, &bench.simulate(&without(k), log), base, times)).collect()
}

/// The filter before the sampling, on what the target's instrument sees.
fn filter_target(kind: Kind, trace: &mut Trace, corner: f64) {
    let step = trace.step;
    let seen = match kind.target_channel() {
        Channel::Torque => &mut trace.torque,
        Channel::Voltage => &mut trace.voltage,
        Channel::Position => &mut trace.output_angle,
        _ => &mut trace.current,
    };
    *seen = sense::low_pass(seen, step, corner);
}

/// A number with seven digits, as a logger writes it.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = if self.0 == 0.0 { 0 } else { self.0.abs().log10().floor() as i32 };
        if (-4..7).contains(&digits) {
            write!(f, "{:.*}", (6 - digits).max(0) as usize, self.0)
        } else {
            write!(f, "{:.6e}", self.0)
        }
    }
}

/// Pieces of `length` rows in random order, with random signs.
fn shuffle(values: &[f64], length: usize, random: &mut Random) -> Vec<f64> {
    let mut pieces: Vec<&[f64]> = values.chunks(length.max(1)).collect();
    for k in (1..pieces.len()).rev() {
        pieces.swap(k, random.index(k + 1));
    }
    pieces
        .into_iter()
        .flat_map(|piece| {
            let sign = random.sign();
            piece.iter().map(move |v| sign * v).collect::<Vec<f64>>()
        })
        .collect()
}

fn join(logs: &[LogTruth], directory: &Path) {
    let mut all = String::new();
    for (k, log) in logs.iter().enumerate() {
        let text = fs::read_to_string(&log.file).expect("the log was just written");
        for (row, line) in text.lines().enumerate() {
            if row > 0 {
                let _ = writeln!(all, "run{},{line}", k + 1);
            } else if k == 0 {
                let _ = writeln!(all, "run,{line}");
            }
        }
        fs::remove_file(&log.file).expect("the log was just written");
    }
    fs::write(directory.join("logs.csv"), all).expect("the logs can be written");
}

fn catalog(bench: &Bench) -> String {
    let (m, d) = (&bench.machine, &bench.declared);
    let cell = |value: f64, factor: Option<f64>| factor.map_or(String::new(), |f| format!("{:.8e}", value * f));
    let columns = [
        ("id", MOTOR.to_string()),
        ("manufacturer", "Bench".into()),
        ("model", "Bench motor".into()),
        ("commutation", "brushless".into()),
        ("winding", "wye".into()),
        ("terminals", "q_axis".into()),
        ("current", "q_axis".into()),
        ("resistance [ohm]", cell(m.resistance, Some(d.resistance))),
        ("inductance [H]", cell(m.inductance, Some(1.0))),
        ("torque_constant [N*m/A]", cell(m.torque_constant, Some(d.torque_constant))),
        ("rotor_inertia [kg*m^2]", cell(m.inertia, Some(d.inertia))),
        ("mass [g]", "500".into()),
        ("pole_pairs", m.pole_pairs.to_string()),
        ("peak_current [A]", cell(m.peak_current, Some(1.5))),
        ("continuous_current [A]", cell(m.peak_current, Some(0.5))),
        ("reference_temperature [degC]", "25".into()),
        ("coulomb_friction [N*m]", cell(m.coulomb, d.coulomb)),
        ("viscous_friction [N*m*s/rad]", cell(m.viscous, d.viscous)),
        ("source", "simulated bench".into()),
        ("source_kind", "measured".into()),
    ];
    let speed = d.max_speed.then(|| ("max_speed [rad/s]", cell(m.peak_speed, Some(1.0))));
    let columns: Vec<(&str, String)> = columns.into_iter().chain(speed).collect();
    let header: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let row: Vec<&str> = columns.iter().map(|(_, cell)| cell.as_str()).collect();
    format!("{}\n{}\n", header.join(","), row.join(","))
}

fn bench_file(bench: &Bench, logs: &[LogTruth]) -> String {
    let m = &bench.machine;
    let mut text = format!("# Simulated bench, seed {}\nkind = \"{}\"\n", bench.seed, bench.kind.name());
    if bench.kind != Kind::Linear {
        let _ = writeln!(text, "catalog = [\"motors.csv\"]");
        let gear = if m.gear_inertia > 0.0 {
            format!(", gear = {{ inertia = \"{:e} kg*m^2\" }}", m.gear_inertia)
        } else {
            String::new()
        };
        let _ = writeln!(text, "actuator = {{ motor = \"{MOTOR}\", ratio = {}{gear} }}", m.ratio);
    } else {
        let _ = writeln!(text, "[actuator]\nmass = \"{:.8} kg\"", m.load_inertia * bench.declared.inertia);
        if let Some(factor) = bench.declared.viscous {
            let _ = writeln!(text, "viscous_friction = \"{:.8} N*s/m\"", m.viscous * factor);
        }
        if let Some(factor) = bench.declared.coulomb {
            let _ = writeln!(text, "coulomb_friction = \"{:.8} N\"", m.coulomb * factor);
        }
    }
    text.push_str("[columns]\n");
    if bench.kind != Kind::SteadyTable {
        text.push_str("time = { name = \"t_s\", unit = \"s\" }\n");
    }
    for &channel in bench.kind.channels() {
        if !bench.sensors.hidden.contains(&channel) {
            let (key, name, unit, more) = column(bench, channel);
            let sign = if bench.sensors.reversed == Some(channel) { ", sign = -1" } else { "" };
            let _ = writeln!(text, "{key} = {{ name = \"{name}\", unit = \"{unit}\"{more}{sign} }}");
        }
    }
    match bench.kind {
        Kind::Free => {
            let _ = writeln!(text, "[load]\ninertia = \"{:.8e} kg*m^2\"", m.load_inertia);
        }
        Kind::Servo => {
            let servo = bench.servo;
            let _ = writeln!(text, "[controller]\ngain = \"{:.8} 1/rad\"\nsupply = \"{} V\"", servo.gain, m.bus);
            let _ = writeln!(text, "[pendulum]\nmass = \"{:.8} kg\"\nlength = \"{:.8} m\"", servo.mass, servo.length);
        }
        _ => {}
    }
    for (k, log) in logs.iter().enumerate() {
        let used = if log.held_out { "held_out" } else { "fit" };
        if bench.one_file {
            let _ = writeln!(
                text,
                "[[log]]\nfile = \"logs.csv\"\nselect = {{ column = \"run\", equals = \"run{}\" }}\nuse = \"{used}\"",
                k + 1
            );
        } else {
            let _ = writeln!(text, "[[log]]\nfile = \"log{}.csv\"\nuse = \"{used}\"", k + 1);
        }
    }
    text
}
