//! The torque-speed diagram of a design, at its output: what each limit leaves, and what the motion asks.
//!
//! The one idea: what a sample asks of the *motor* is drawn as the steady torque at the output that would ask the
//! same torque of the motor's shaft, so that accelerating the rotor counts, and a sample lies
//! outside a current limit exactly where that limit is exceeded. Driving is above zero, braking below.

use super::{Along, Axis, Dash, Label, Mark, Panel, Rule, Series, Shape, Tone, thinned};
use crate::number;
use gearwise_model::actuator::envelope::Steady;
use gearwise_model::actuator::limits::{Asked, Candidate, Demand, is_of_gear};
use gearwise_model::actuator::shaft::{End, Flow};
use gearwise_model::actuator::waveform::Functional;
use gearwise_model::catalog::estimate::Estimated;
use gearwise_model::requirement::{Course, Joint};
use gearwise_select::Prepared;

/// Points of a boundary.
const POINTS: usize = 121;
/// Most samples of the motion that are drawn.
const SAMPLES: usize = 1500;

/// What stands under the diagram.
pub const CAPTION: &str = "At the output, at steady speed and torque (α = 0, dτ/dt = 0); driving above zero, braking below. \
    The motion: for each sample the steady torque that asks the same torque of the motor's shaft, the rotor's \
    acceleration included; times are written at it. Each line says what it bounds: \"motion ≤\" every sample of the motion \
    with the rotor, \"rms motion ≤\" its rms, \"load ≤\" the load torque alone; safety and reserves are in the lines. The voltage that changes the current (L di/dt) is not in the diagram; the limit in the table has it.";

/// The diagram of a design at a ratio.
pub fn panel(prepared: &Prepared, ratio: f64, title: String) -> Panel {
    if prepared.candidate.whole_map().is_some() {
        return prepared.candidate.at_ratio(ratio, |here| panel(&Prepared::new(*here), ratio, title));
    }
    let candidate = &prepared.candidate;
    let all = cloud(candidate, ratio);
    let motion: Vec<(usize, (f64, f64))> = thinned(all.len(), SAMPLES).map(|k| all[k]).collect();
    let loads: Vec<(f64, f64)> = {
        let m = &candidate.joint.motion;
        let of = |k: usize| {
            let sign = if m.velocity[k] == 0.0 { m.torque[k].signum() } else { m.velocity[k].signum() };
            (m.velocity[k].abs(), sign * m.torque[k])
        };
        thinned(m.len(), SAMPLES).map(of).collect()
    };
    let fastest = motion.iter().map(|(_, p)| p.0).fold(0.0, f64::max);
    let strongest = motion.iter().map(|(_, p)| p.1.abs()).chain(loads.iter().map(|p| p.1.abs())).fold(0.0, f64::max);
    let speed = speed_range(prepared, ratio, fastest);
    let speeds: Vec<f64> = (0..POINTS).map(|k| speed * k as f64 / (POINTS - 1) as f64).collect();
    let mut panel = Panel { title, ..Panel::default() };
    let (boundaries, rms) = boundaries(prepared, ratio, &speeds);
    // The peak limits must be seen, unless they are so far off that the motion would vanish.
    let farthest = boundaries
        .iter()
        .filter(|b| b.peak)
        .flat_map(|b| &b.series.points)
        .map(|p| p.1.abs())
        .filter(|t| t.is_finite() && *t <= 4.0 * strongest)
        .fold(strongest, f64::max);
    let deepest = motion.iter().map(|(_, p)| -p.1).fold(0.0, f64::max);
    let up = 1.12 * farthest;
    panel.x = Axis::linear("speed of the output [rad/s]").within(0.0, speed);
    panel.y = Axis::linear("torque at the output [N·m]").within(-(1.25 * deepest).max(0.25 * up).min(up), up);
    panel.series.push(Series::new(Tone::Grey, Mark::Dots, loads).named("load alone"));
    let order: Vec<(f64, f64)> = motion.iter().map(|(_, p)| *p).collect();
    for (samples, course) in candidate.joint.motion.courses() {
        let of_it: Vec<(f64, f64)> = motion.iter().filter(|(k, _)| samples.contains(k)).map(|(_, p)| *p).collect();
        if !matches!(course, Course::Points(_)) {
            panel.series.push(Series::new(Tone::Sky, Mark::Thin(Dash::Solid), of_it));
        }
    }
    let notes = motion.iter().map(|(k, _)| candidate.joint.motion.name_sample(*k)).collect();
    panel.series.push(Series::new(Tone::Blue, Mark::Dots, order).named("motion, with the rotor").noted(notes));
    // What lies beyond the panel is said, and not in the legend.
    let (lowest, highest) = panel.y.range.unwrap_or_default();
    let visible = |s: &Series| s.points.iter().any(|p| p.1 >= lowest && p.1 <= highest && p.0 <= speed);
    let (seen, beyond): (Vec<Boundary>, Vec<Boundary>) = boundaries.into_iter().partition(|b| visible(&b.series));
    if !beyond.is_empty() {
        let names: Vec<&str> = beyond.iter().map(|b| b.short.as_str()).collect();
        panel.title.push_str(&format!(" (farther off than drawn: {})", names.join(", ")));
    }
    panel.series.extend(rms.filter(&visible));
    let lines = seen.into_iter().map(|b| b.series.named(format!("{} ≤ {}", b.of, b.short))).collect();
    panel.series.extend(super::merge_coincident(lines, highest - lowest));
    panel.rules = straight(prepared, ratio, (speed, up, lowest));
    let binding = binding(prepared, ratio, &all);
    let times = instants(candidate, &motion);
    let marks = |of: &[Label]| of.iter().map(|l| (l.at, l.text.clone())).unzip::<_, _, Vec<_>, Vec<_>>();
    let (at, notes) = marks(&times);
    panel.series.push(Series::new(Tone::Blue, Mark::Points(Shape::Circle), at).noted(notes));
    if !binding.is_empty() {
        let (at, notes) = marks(&binding);
        let binds = Series::new(Tone::Vermilion, Mark::Points(Shape::Diamond), at);
        panel.series.push(binds.noted(notes).named("where a limit binds"));
    }
    panel.labels = binding;
    // One instant has one label: what binds there says when it is.
    let apart = |l: &Label| panel.labels.iter().all(|other| other.at != l.at);
    let times: Vec<Label> = times.into_iter().filter(apart).collect();
    panel.labels.extend(times);
    panel
}

/// A limit leaves no more than this share, and its instant is labelled.
const BINDS: f64 = 0.05;

/// Where the limits bind that leave least, each at the sample that asks most of it.
fn binding(prepared: &Prepared, ratio: f64, motion: &[(usize, (f64, f64))]) -> Vec<Label> {
    let candidate = &prepared.candidate;
    let m = &candidate.joint.motion;
    let mut found: Vec<(f64, usize, &'static str)> = Vec::new();
    for asked in prepared.asked.iter().filter(|asked| asked.end == End::First) {
        let (raw, sample) = asked.raw_demand(candidate, ratio);
        let margin = asked.margin(candidate, ratio, raw);
        // The torque that a bandwidth asks for on top is in no dot.
        let drawn = !matches!(asked.demand, Demand::Bandwidth(_));
        if let Some(sample) = sample.filter(|k| drawn && margin <= BINDS && *k < m.len()) {
            found.push((margin, sample, asked.limit.name));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(b.2)));
    let label = |(margin, sample, limit): &(f64, usize, &'static str)| {
        let sign = if m.velocity[*sample] == 0.0 { m.torque[*sample].signum() } else { m.velocity[*sample].signum() };
        let load = (m.velocity[*sample].abs(), sign * m.torque[*sample]);
        let with_rotor = || motion.iter().find(|(k, _)| k == sample).map(|(_, p)| *p);
        let at = if is_of_gear(limit) { load } else { with_rotor()? };
        let how = match margin {
            m if *m < -1e-6 => "exceeded".to_string(),
            m if *m < 0.0005 => "binds".to_string(),
            m => format!("{} % left", number((1000.0 * m).round() / 10.0)),
        };
        Some(Label { at, text: format!("{limit} {how}, {}", m.name_sample(*sample)), chosen: false })
    };
    found.iter().filter_map(label).take(LABELLED).collect()
}

/// Most instants at which limits bind that are labelled.
const LABELLED: usize = 3;

/// A boundary of the diagram.
struct Boundary {
    series: Series,
    /// Which dots it bounds.
    of: &'static str,
    /// What it is, in few words.
    short: String,
    /// Whether it must be seen: a peak limit.
    peak: bool,
}

/// What of a limit is not to be used: safety factor and reserve, to go on its name.
fn held_back(asked: &Asked, joint: &Joint) -> String {
    let safety = joint.limits.safety;
    let reserve = joint.limits.reserve(asked.limit.name);
    let safety =
        if asked.limit.safety && safety != 1.0 { format!(" / safety {}", number(safety)) } else { String::new() };
    let reserve = if reserve > 0.0 { format!(" less {} % reserve", number(100.0 * reserve)) } else { String::new() };
    safety + &reserve
}

/// The samples with what each asks of the motor, as speed and torque at the output.
fn cloud(candidate: &Candidate, ratio: f64) -> Vec<(usize, (f64, f64))> {
    let steady = Steady::new(candidate, ratio);
    let shaft = |here: &Candidate| {
        let wave = &here.load.waveform;
        let mut all: Vec<(usize, f64, f64)> = (0..wave.len())
            .map(|i| {
                let point = wave.point(i);
                let form = here.actuator.torque_form(point.flow);
                let sign = point.features[gearwise_model::actuator::shaft::Feature::Sign as usize];
                let torque = form.polynomial(&point.features).at(ratio);
                let speed = point.features[gearwise_model::actuator::shaft::Feature::Velocity as usize].abs();
                (point.origin, speed, sign * torque)
            })
            .collect();
        all.sort_by_key(|p| p.0);
        // At standstill friction may oppose either way: the greater torque is what counts.
        let mut kept: Vec<(usize, f64, f64)> = Vec::with_capacity(all.len());
        for p in all {
            match kept.last_mut() {
                Some(last) if last.0 == p.0 => {
                    let torque = last.2.abs().max(p.2.abs());
                    last.2 = torque;
                }
                _ => kept.push(p),
            }
        }
        kept
    };
    let all = if candidate.is_evaluated() { candidate.at_ratio(ratio, shaft) } else { shaft(candidate) };
    all.into_iter()
        .filter_map(|(origin, speed, torque)| Some((origin, (speed, steady.load_torque(torque, speed)?))))
        .collect()
}

/// To where speeds are drawn: beyond the motion, to where the voltage ends if that is not too far.
fn speed_range(prepared: &Prepared, ratio: f64, fastest: f64) -> f64 {
    let steady = Steady::new(&prepared.candidate, ratio);
    let bound = prepared.candidate.robot.bus.voltage;
    let (functional, bound) = match prepared.candidate.supply(0.0) {
        Some(supply) => (Functional::OpenVoltage(supply), bound),
        None => (Functional::VoltageSquared, prepared.candidate.voltage().powi(2)),
    };
    let reaches = |speed: f64| {
        let driving = steady.largest_torque(functional, bound, Flow::Driving, speed);
        driving.is_some_and(|t| t > 0.0)
    };
    let mut speed = 1.15 * fastest.max(1e-3);
    while speed < 2.2 * fastest && reaches(speed) {
        speed *= 1.05;
    }
    // Where the voltage ends much farther on, the motion is what fills the diagram.
    if reaches(speed) { 1.3 * fastest.max(1e-3) } else { speed }
}

/// A limit on the torque of the motor's shaft: its name in the legend, whether it is on every sample (else on their rms),
/// and the torque \[N·m\].
fn shaft_limit(asked: &Asked) -> Option<(&'static str, bool, f64)> {
    let bound = asked.raw_bound().max(0.0).sqrt();
    let (name, peak) = match (asked.limit.name, asked.owner) {
        ("peak_current", "drive") => ("peak current of the drive", true),
        ("peak_current", _) => ("peak current of the motor", true),
        ("peak_torque", _) => ("peak torque of the motor", true),
        ("continuous_current", _) => ("rated current", false),
        ("continuous_torque", _) => ("rated torque", false),
        ("winding_temperature", _) => ("winding temperature", false),
        _ => return None,
    };
    matches!(asked.demand, Demand::Samples(Functional::TorqueSquared) | Demand::Polynomial(..))
        .then_some((name, peak, bound))
}

/// The boundaries, and the rms of the motion as a line where a continuous limit bounds it.
fn boundaries(prepared: &Prepared, ratio: f64, speeds: &[f64]) -> (Vec<Boundary>, Option<Series>) {
    let candidate = &prepared.candidate;
    let steady = Steady::new(candidate, ratio);
    let both = |at: &dyn Fn(Flow, f64) -> Option<f64>| -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for flow in Flow::MOVING {
            let finite = |speed: f64| at(flow, speed).filter(|t| t.is_finite());
            for (k, speed) in speeds.iter().enumerate() {
                // Where the boundary ends between two speeds, to its very end.
                let end = (k > 0 && finite(*speed).is_none())
                    .then(|| finite(speeds[k - 1]).map(|_| last(&finite, speeds[k - 1], *speed)))
                    .flatten();
                points.extend(end);
                points.push((*speed, finite(*speed).unwrap_or(f64::NAN)));
            }
            points.push((f64::NAN, f64::NAN));
        }
        points
    };
    let (mut all, mut rms) = (Vec::new(), None);
    for asked in prepared.asked.iter().filter(|asked| asked.end == End::First) {
        let held = held_back(asked, candidate.joint);
        let bound = asked.raw_bound();
        if let Some((name, peak, torque)) = shaft_limit(asked) {
            let tone = if peak { Tone::Vermilion } else { Tone::Green };
            let dash = match asked.limit.name {
                // No two alike: in grey the dash is all that tells them apart.
                "peak_torque" => Dash::Dashed,
                "continuous_current" => Dash::Long,
                "winding_temperature" => Dash::DashDot,
                "continuous_torque" => Dash::DashDotDot,
                _ => Dash::Solid,
            };
            let line = |torque: f64| {
                both(&|flow: Flow, speed: f64| {
                    let signed = if flow == Flow::Driving { torque } else { -torque };
                    steady.load_torque(signed, speed).filter(|t| (*t >= 0.0) == (flow == Flow::Driving))
                })
            };
            if !peak && rms.is_none() {
                let asks = asked.raw_demand(candidate, ratio).0.max(0.0).sqrt();
                rms = Some(Series::new(Tone::Blue, Mark::Thin(Dash::Dotted), line(asks)).named("rms motion"));
            }
            let heat = asked.limit.name == "winding_temperature";
            let guessed = heat && candidate.motor.is_estimated(Estimated::ThermalResistance);
            let short = format!("{name}{}{held}", if guessed { " (estimated)" } else { "" });
            let of = if peak { "motion" } else { "rms motion" };
            all.push(Boundary { series: Series::new(tone, Mark::Line(dash), line(torque)), of, short, peak });
        }
        let (functional, name, tone, dash) = match asked.limit.name {
            "voltage" => match asked.demand {
                Demand::Samples(functional) => (functional, "voltage", Tone::Black, Dash::Solid),
                _ => continue,
            },
            "bus_power" => (Functional::Power, "power of the bus", Tone::Purple, Dash::DashDot),
            "bus_current" => (Functional::Power, "current of the bus", Tone::Purple, Dash::DashDotDot),
            _ => continue,
        };
        let boundary = |steady: Steady| both(&|flow, speed| steady.largest_torque(functional, bound, flow, speed));
        let inductance = asked.limit.name == "voltage" && candidate.motor.inductance_and_poles().is_some();
        let name = if inductance { "voltage, with inductance" } else { name };
        let of_bus =
            |series, name: &str| Boundary { series, of: "motion", short: format!("{name}{held}"), peak: false };
        all.push(of_bus(Series::new(tone, Mark::Line(dash), boundary(steady)), name));
        if inductance {
            let without = Series::new(tone, Mark::Line(Dash::Dotted), boundary(steady.without_inductance()));
            all.push(of_bus(without, "voltage, without inductance"));
        }
    }
    all.retain(|b| b.series.points.iter().any(|p| p.1.is_finite()));
    (all, rms)
}

/// The last point that there is between a speed that has one and a speed that has none.
fn last(at: &dyn Fn(f64) -> Option<f64>, with: f64, without: f64) -> (f64, f64) {
    let (mut low, mut high) = (with, without);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if at(middle).is_some() { low = middle } else { high = middle }
    }
    (low, at(low).unwrap_or(f64::NAN))
}

/// Limits of speed, and of the gear's torque, which holds for driving and for braking.
fn straight(prepared: &Prepared, ratio: f64, (fastest, strongest, lowest): (f64, f64, f64)) -> Vec<Rule> {
    let joint = prepared.candidate.joint;
    let rules = |asked: &Asked| {
        let (along, at, name, dash) = match asked.limit.name {
            "max_speed" => (Along::X, asked.bound / ratio, "motion ≤ speed of the motor", Dash::Dashed),
            "gear_input_speed" => (Along::X, asked.bound / ratio, "motion ≤ speed of the gear", Dash::DashDot),
            "gear_peak_torque" => (Along::Y, asked.bound / joint.limits.safety, "load ≤ peak of the gear", Dash::Long),
            "gear_continuous_torque" => (Along::Y, asked.bound, "rms load ≤ continuous of the gear", Dash::Dotted),
            _ => return Vec::new(),
        };
        let rule = |at: f64, text: String| Rule { along, at, tone: Tone::Orange, dash, text };
        let upper = if along == Along::X { at <= fastest } else { at <= strongest };
        let upper = upper.then(|| rule(at, format!("{name}{}", held_back(asked, joint))));
        let lower = (along == Along::Y && -at >= lowest).then(|| rule(-at, String::new()));
        upper.into_iter().chain(lower).collect()
    };
    prepared.asked.iter().filter(|asked| asked.end == End::First).flat_map(rules).collect()
}

/// Where the motion is at the start and after each quarter.
fn instants(candidate: &Candidate, motion: &[(usize, (f64, f64))]) -> Vec<Label> {
    let m = &candidate.joint.motion;
    if let Some(cases) = &m.cases {
        // Where each case begins.
        let first = |case: &gearwise_model::motion::Case| {
            let (_, p) = motion.iter().find(|(k, _)| case.samples.contains(k))?;
            Some(Label { at: *p, text: case.name.clone(), chosen: false })
        };
        return cases.list.iter().filter_map(first).collect();
    }
    let Some(duration) = m.duration().filter(|_| !matches!(m.course, Course::Points(_))) else {
        let points = motion.iter().take(6);
        return points.map(|(k, p)| Label { at: *p, text: m.name_sample(*k), chosen: false }).collect();
    };
    let start = m.time.first().copied().unwrap_or(0.0);
    let nearest = |quarter: u32| {
        let at = start + duration * f64::from(quarter) / 4.0;
        let far = |k: usize| (m.time[k] - at).abs();
        let (k, p) = motion.iter().min_by(|a, b| far(a.0).total_cmp(&far(b.0)))?;
        Some(Label { at: *p, text: format!("{} s", number(m.time[*k])), chosen: false })
    };
    (0..4).filter_map(nearest).collect()
}
