//! Random joints and a second look at them, straight from the raw waveforms.
//!
//! Nothing of the crate's model is called here: torque, current, voltage, power, means over time,
//! temperature, efficiency, friction and every limit are computed in the plainest way, without
//! polynomials, convexity or solver; only data types are shared. The number of a case is the seed it is
//! drawn from.
#![allow(dead_code, reason = "each test file uses its part")]

use std::{cell::RefCell, collections::BTreeMap, f64::consts::TAU, sync::Arc};

use gearwise::actuator::Load;
use gearwise::catalog::convention::{Commutation, Modulation};
use gearwise::catalog::{Catalog, Motor, Printed};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Ratios that are looked at before refining.
const RATIOS: usize = 1201;
/// Limits of the model; the two ends of the range come on top.
pub const LIMITS: usize = 22;

/// A motor at the only joint of a robot, the motion sample by sample, the same with the superposed torque
/// at all its phases, and each sample's share of the time (in all, at rest).
pub struct Case {
    pub motor: Motor,
    pub robot: Robot,
    pub raw: Vec<Point>,
    pub rippled: Vec<Point>,
    pub shares: Vec<[f64; 2]>,
    /// The motion as the library has it, for the degrees to which slow samples are at rest.
    pub load: Load,
    /// Rows of a family of gears, where the joint has one: the gear goes with the ratio.
    pub family: Vec<MapRow>,
    /// Whether these rows are the points of a named family: between two the efficiencies are those of the worse.
    pub named: bool,
}

/// What a ratio comes to: the quantities in the order of their type; limits with name, demand and, where
/// they apply, bound.
pub struct Look {
    pub quantities: [f64; 7],
    pub objective: f64,
    pub limits: [(&'static str, f64, Option<f64>); LIMITS + 2],
    /// Of a supply with a resistance: bus voltage that each sample needs and power that it draws, hot and cold.
    pub bus: Vec<[f64; 2]>,
    /// Currents along d of the samples, and of those with the superposed torque.
    pub direct: [Vec<f64>; 2],
}

/// Shares of the time by the trapezoid rule (points: by duration): half an interval for each of its ends.
/// It is at rest if it is so at both.
pub fn shares(raw: &[Point], time: &[f64], course: Course) -> Vec<[f64; 2]> {
    let (n, mut shares) = (raw.len(), vec![[0.0; 2]; raw.len()]);
    for k in 0..n {
        let (next, length) = match course {
            Course::Points(_) => (k, raw[k].duration.unwrap_or(1.0)),
            Course::Periodic(period) => ((k + 1) % n, (time[(k + 1) % n] - time[k]).rem_euclid(period)),
            Course::Once(_) => ((k + 1).min(n - 1), time[(k + 1).min(n - 1)] - time[k]),
            Course::Cases => unreachable!("a drawn motion has no cases"),
        };
        let rests = raw[k].velocity == 0.0 && raw[next].velocity == 0.0;
        for end in [k, next] {
            shares[end] = [shares[end][0] + length, shares[end][1] + if rests { length } else { 0.0 }];
        }
    }
    let total: f64 = shares.iter().map(|share| share[0]).sum();
    shares.iter().map(|share| share.map(|length| length / total)).collect()
}

impl Case {
    pub fn new(motor: Motor, robot: Robot, raw: Vec<Point>) -> Case {
        let joint = &robot.joints[0];
        let (time, course) = (&joint.motion.time, joint.motion.course);
        let shares = shares(&raw, time, course);
        let mut rippled = Vec::new();
        if let Some(TorqueBandwidth { frequency, amplitude }) = robot.joints[0].limits.torque_bandwidth {
            for (p, step) in raw.iter().flat_map(|p| (0..32).map(move |step| (p, step))) {
                let (sin, cos) = (TAU * f64::from(step) / 32.0).sin_cos();
                let torque_rate = p.torque_rate - amplitude * TAU * frequency * sin;
                rippled.push(Point { torque: p.torque + amplitude * cos, torque_rate, ..*p });
            }
        }
        let load = Load::new(&joint.motion, None);
        Case { motor, robot, raw, rippled, shares, load, family: Vec::new(), named: false }
    }

    /// Shares of the time at a ratio: slow samples are at rest to the degree that the library gives, which its own tests compare
    /// with an integration over the angle of the field.
    pub fn shares_at(&self, n: f64) -> Vec<[f64; 2]> {
        let (pairs, tau) = self.field();
        let load = self.load.standing(2.0 * pairs * n, tau);
        if pairs == 0.0 || !load.counts_slow_motion() {
            return self.shares.clone();
        }
        self.shares.iter().enumerate().map(|(k, [all, _])| [*all, load.share(k, 1.0) - load.share(k, 0.0)]).collect()
    }

    /// Pole pairs, none of a brushed motor, and the winding's time constant.
    fn field(&self) -> (f64, f64) {
        let motor = &self.motor;
        let tau = motor.sheet.thermal_time_constant_winding.map_or(5.1, |tau| tau.value);
        let pairs = motor.pole_pairs.filter(|pairs| *pairs > 0).unwrap_or(2);
        (if motor.conventions.commutation == Commutation::Brushed { 0.0 } else { f64::from(pairs) }, tau)
    }

    /// True if slow samples have a degree of standstill at some ratio of the range.
    pub fn has_slow_motion(&self) -> bool {
        let (min, _) = self.robot.joints[0].ratio.range().unwrap();
        let (pairs, tau) = self.field();
        pairs > 0.0 && self.load.standing(2.0 * pairs * min, tau).counts_slow_motion()
    }

    /// The joint's gear at a ratio, from the two rows about it: numbers of the load, of mass and of limits go with the square
    /// of the ratio, inertia with its inverse, torque without load with the inverse of the ratio.
    pub fn gear(&self, n: f64) -> GearModel {
        let (mut gear, rows) = (self.robot.joints[0].gear, &self.family);
        let Some(k) = (1..rows.len()).find(|k| n <= rows[*k].ratio && rows[*k].ratio > rows[k - 1].ratio) else {
            return gear;
        };
        let (mut a, mut b) = (rows[k - 1], rows[k]);
        let point = rows.iter().find(|row| self.named && row.ratio == n);
        if self.named {
            let worse = |a: Option<f64>, b: Option<f64>, of: fn(f64, f64) -> f64| Some(of(a?, b?));
            a.driving = worse(a.driving, b.driving, f64::max);
            a.braking = worse(a.braking, b.braking, f64::min);
            (b.driving, b.braking) = (a.driving, a.braking);
        }
        // At a point both ends are that point; of the numbers of two equal ends any share of the way is the number.
        if let Some(point) = point {
            let there = |row: &MapRow| MapRow { ratio: row.ratio, ..*point };
            (a, b) = (there(&a), there(&b));
        }
        let (a, b) = (&a, &b);
        let along = |power: f64, of: fn(&MapRow) -> Option<f64>| {
            let way = (n.powf(power) - a.ratio.powf(power)) / (b.ratio.powf(power) - a.ratio.powf(power));
            Some(of(a)? + (of(b)? - of(a)?) * way)
        };
        gear.efficiency = along(2.0, |r| r.driving).map_or(gear.efficiency, |per_load| 1.0 / per_load);
        gear.backdrive_efficiency = along(2.0, |r| r.braking).unwrap_or(gear.backdrive_efficiency);
        gear.inertia = along(-2.0, |r| r.inertia).unwrap_or(gear.inertia);
        gear.no_load.coulomb = along(-1.0, |r| r.no_load_torque).unwrap_or(gear.no_load.coulomb);
        gear.mass = along(2.0, |r| r.mass).or(gear.mass);
        gear.peak_torque = along(2.0, |r| r.peak_torque).or(gear.peak_torque);
        gear.continuous_torque = along(2.0, |r| r.continuous_torque).or(gear.continuous_torque);
        gear.max_input_speed = along(2.0, |r| r.max_input_speed).or(gear.max_input_speed);
        gear
    }

    /// The ends between which the motor's drag lies that its row does not declare as friction: Coulomb and viscous.
    fn drags(&self) -> Vec<[f64; 2]> {
        let motor = &self.motor;
        let declared = motor.coulomb_friction.is_some() || motor.viscous_friction.is_some();
        let rubs = motor.effects.iter().any(|effect| effect.is_friction());
        let counts = self.robot.joints[0].motor_drag == MotorDrag::Counted && !declared && !rubs;
        match (motor.no_load_torque.filter(|_| counts), motor.sheet.no_load_speed) {
            (None, _) => vec![[0.0; 2]],
            (Some(torque), _) if !motor.estimates.is_empty() => vec![[torque, 0.0], [0.0; 2]],
            (Some(torque), Some(speed)) if motor.conventions.commutation == Commutation::Brushless => {
                vec![[torque, 0.0], [0.0, torque / speed.value]]
            }
            (Some(torque), _) => vec![[torque, 0.0]],
        }
    }

    /// A ratio: of what depends on the motor's drag the worst.
    pub fn look(&self, n: f64) -> Look {
        let limits = [("", f64::MIN, None); LIMITS + 2];
        let mut worst =
            Look { quantities: [f64::MIN; 7], objective: 0.0, limits, bus: Vec::new(), direct: [vec![], vec![]] };
        // The drive does not know the drag: its currents along d are those of the end that asks for more.
        let drags = self.drags();
        let mut shared: Option<[Vec<f64>; 2]> = None;
        if drags.len() > 1 {
            for drag in &drags {
                let here = self.look_at(n, *drag, None).direct;
                let Some(most) = &mut shared else {
                    shared = Some(here);
                    continue;
                };
                for (most, here) in most.iter_mut().flatten().zip(here.into_iter().flatten()) {
                    *most = most.min(here);
                }
            }
        }
        for look in drags.into_iter().map(|drag| self.look_at(n, drag, shared.as_ref())) {
            worst.bus.extend(look.bus);
            for (most, here) in worst.quantities.iter_mut().zip(look.quantities) {
                *most = most.max(here);
            }
            for (most, (name, demand, bound)) in worst.limits.iter_mut().zip(look.limits) {
                *most = (name, most.1.max(demand), bound);
            }
        }
        let terms = &self.robot.joints[0].objective.terms;
        worst.objective = terms.iter().map(|(q, weight)| weight * worst.quantities[*q as usize]).sum();
        worst
    }

    /// The same with so much more Coulomb and viscous friction of the motor, and the currents along d that `shared` says.
    fn look_at(&self, n: f64, drag: [f64; 2], shared: Option<&[Vec<f64>; 2]>) -> Look {
        let (motor, bus, joint, raw) = (&self.motor, &self.robot.bus, &self.robot.joints[0], &self.raw);
        let (gear, asked, r, k_t) = (&self.gear(n), &joint.limits, motor.resistance, motor.torque_constant);
        // A brushed motor has no d axis. Without inductance the voltage is R i + K_B N ω, without pole pairs v_q alone.
        let brushless = motor.conventions.commutation == Commutation::Brushless;
        let l = motor.inductance.unwrap_or(0.0);
        let poles = motor.pole_pairs.filter(|_| brushless).unwrap_or(0);
        let j = motor.rotor_inertia.unwrap() + gear.inertia;
        let own = [motor.coulomb_friction.unwrap_or(0.0) + drag[0], motor.viscous_friction.unwrap_or(0.0) + drag[1]];
        let [rubbing, b] = [own[0] + gear.no_load.coulomb, own[1] + gear.no_load.viscous];
        // Shaft torque and its rate. At standstill friction is nothing in means, and opposes the motor in limits.
        let braking = |p: &Point| p.torque * p.velocity < 0.0;
        let phi = |p: &Point| if braking(p) { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
        let smooth = |p: &Point| phi(p) * p.torque / n + n * (j * p.acceleration + b * p.velocity);
        let rate = |p: &Point| phi(p) * p.torque_rate / n + n * (j * p.jerk + b * p.acceleration);
        let friction = |towards: f64| rubbing.copysign(towards);
        // What stands needs no more and no less than the load, in means.
        let held = |p: &Point| p.torque / n + n * j * p.acceleration;
        let usual = |p: &Point| if p.velocity == 0.0 { held(p) } else { smooth(p) + friction(p.velocity) };
        let most = |p: &Point| smooth(p) + friction(if p.velocity == 0.0 { smooth(p) } else { p.velocity });
        // Voltage and power taken see the winding at its hottest, all else at the reference of its resistance.
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        let of_drive = joint.drive.or(bus.drive);
        let (lead, standby) = (of_drive.phase_resistance.unwrap_or(0.0), of_drive.standby_power.unwrap_or(0.0));
        let r_hot = r * hottest_factor(motor, asked.winding_temperature) + lead;
        // Voltage and power returned see it at ambient, too.
        let ambient = self.robot.ambient - motor.reference_temperature;
        let r_cold = (r * (1.0 + copper(motor.reference_temperature) * ambient) + lead).min(r_hot);
        let windings = [r_hot, r_cold];
        let work = |p: &Point| motor.emf_constant() * n * p.velocity * most(p) / k_t;
        let power_of = |p: &Point, r: f64| r * (most(p) / k_t).powi(2) + work(p);
        let (power, cold_power) = (|p: &Point| power_of(p, r_hot), |p: &Point| power_of(p, r_cold));
        let v_q = |p: &Point, r: f64| r * most(p) / k_t + l * rate(p) / k_t + motor.emf_constant() * n * p.velocity;
        let v_d = |p: &Point| -f64::from(poles) * n * p.velocity * l * most(p) / k_t;
        let worse = |of: &dyn Fn(f64) -> f64| windings.map(of).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let voltage = |p: &Point| worse(&|r| v_q(p, r).hypot(v_d(p)));
        // A current against the magnets, where it may flow and the voltage asks for it: the least that does, or what comes
        // nearest. All phases of a superposed torque have the largest of them.
        let per_volt = bus.modulation_limit * self.circle();
        let sags = bus.internal_resistance.unwrap_or(0.0) + of_drive.supply_lead_resistance.unwrap_or(0.0) > 0.0;
        let allowed = of_drive.field_weakening_current.filter(|_| brushless && l > 0.0 && poles > 0 && !sags);
        let allowed = allowed.map(|i| (i * 1.5_f64.sqrt()).min(motor.demagnetization_current.unwrap_or(f64::INFINITY)));
        // Squared voltage with a current along d, from both voltages without it and what couples across.
        let parts = |p: &Point, r: f64| [v_q(p, r), v_d(p), f64::from(poles) * n * p.velocity * l, r];
        let turned = |[q, d, across, r]: [f64; 4], x: f64| (q + across * x).powi(2) + (d + r * x).powi(2);
        let lowest = |of: [f64; 4], x: f64| {
            let (mut a, mut b) = (-x, 0.0);
            for _ in 0..70 {
                let (c, d) = (a + 0.382 * (b - a), a + 0.618 * (b - a));
                if turned(of, c) < turned(of, d) { b = d } else { a = c }
            }
            [-x, a, 0.0].into_iter().min_by(|a, b| turned(of, *a).total_cmp(&turned(of, *b))).unwrap()
        };
        // A hair less than there is, so that rounding does not break what is met with equality.
        let enough_voltage = (bus.voltage * per_volt).powi(2) * (1.0 - 1e-13);
        // Or one that burns what would come back beyond what the bus takes, with the winding cold.
        let can = brushless && l > 0.0 && poles > 0 && !sags && of_drive.field_weakening_current.is_none();
        let takes = match bus.regeneration {
            Regeneration::Limited(watt) => Some(watt + bus.brake_power.unwrap_or(0.0)),
            Regeneration::Dissipated => bus.brake_power,
            Regeneration::Allowed => None,
        };
        let burns = takes.filter(|_| bus.flux_braking && can).map(|watt| watt / bus.drive_efficiency);
        let against = |p: &Point| {
            if let Some(beyond) = burns {
                // A hair more than that, so that rounding does not break what is met with equality.
                let heat = (-cold_power(p) - beyond).max(0.0) * (1.0 + 1e-12);
                return -(heat / r_cold).sqrt().min(motor.demagnetization_current.unwrap_or(f64::INFINITY));
            }
            let of_winding = |r: f64| {
                let of = parts(p, r);
                let Some(x) = allowed.filter(|_| turned(of, 0.0) > enough_voltage) else { return 0.0 };
                let (mut enough, mut less) = (lowest(of, x), 0.0);
                if turned(of, enough) > enough_voltage {
                    return enough;
                }
                for _ in 0..55 {
                    let middle = 0.5 * (enough + less);
                    if turned(of, middle) <= enough_voltage { enough = middle } else { less = middle }
                }
                enough
            };
            windings.map(of_winding).into_iter().fold(0.0, f64::min)
        };
        let direct: Vec<f64> = raw.iter().map(against).collect();
        let rippled_direct: Vec<f64> = self
            .rippled
            .chunks(32)
            .flat_map(|phases| vec![phases.iter().map(against).fold(0.0, f64::min); phases.len()])
            .collect();
        // The voltage of a motor that burns power is that of its own currents.
        let own = [direct.clone(), rippled_direct.clone()];
        let [direct, rippled_direct] = shared.cloned().unwrap_or([direct, rippled_direct]);
        let torque = |p: &Point| most(p).abs();
        let largest = |list: &[Point], f: &dyn Fn(&Point) -> f64| list.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
        let shares = self.shares_at(n);
        let timed = raw.iter().zip(&shares);
        let mean = |at: usize, f: &dyn Fn(&Point) -> f64| timed.clone().map(|(p, s)| s[at] * f(p).powi(2)).sum::<f64>();
        let weakened: f64 = self.shares.iter().zip(&direct).map(|(share, x)| share[0] * (k_t * x).powi(2)).sum();
        let (square, at_rest, load) = (mean(0, &usual) + weakened, mean(1, &usual), mean(0, &|p| p.torque));
        let (most_torque, most_load) = (largest(raw, &torque), largest(raw, &|p| p.torque.abs()));
        let with = |list: &[Point], direct: &[f64]| -> f64 {
            list.iter().zip(direct).map(|(p, x)| most(p).hypot(k_t * x)).fold(f64::NEG_INFINITY, f64::max)
        };
        let (most_current, most_ripple) = (with(raw, &direct), with(&self.rippled, &rippled_direct));
        let with_heat = |power: f64, r: f64, k: usize| power + r * direct[k].powi(2);
        let most_power = |f: &dyn Fn(&Point, usize) -> f64| {
            raw.iter().enumerate().map(|(k, p)| f(p, k)).fold(f64::NEG_INFINITY, f64::max)
        };
        let watt = most_power(&|p, k| with_heat(power(p), r_hot, k)) / bus.drive_efficiency;
        // What is kept of what comes back, and what of it reaches the bus.
        let kept = bus.regeneration_efficiency.unwrap_or(bus.drive_efficiency);
        let back = most_power(&|p, k| -with_heat(cold_power(p), r_cold, k)) * bus.drive_efficiency;
        let speed = n * largest(raw, &|p| p.velocity.abs());
        let stages = |ratio: f64| (0..300).map(f64::from).find(|k| n <= ratio.powf(k + 1e-12)).unwrap();
        let of_gear = gear.mass_per_stage.map_or(gear.mass.unwrap_or(0.0), |(mass, ratio)| mass * stages(ratio));
        let (inertia, mass) = (n * n * j, motor.mass.unwrap() + of_gear);
        // Bounds.
        let amplitude = if brushless { 1.5_f64.sqrt() } else { 1.0 };
        let current = least(motor.peak_current, joint.drive_current.or(bus.drive_current).map(|i| i * amplitude));
        // With a resistance of the supply: the open-circuit voltage that a sample needs, no less than with half of what there
        // is at the drive. A brake takes what comes back without lifting the bus.
        let series = bus.internal_resistance.unwrap_or(0.0) + of_drive.supply_lead_resistance.unwrap_or(0.0);
        let lifted = bus.brake_power.is_none() && bus.regeneration != Regeneration::Dissipated;
        let from_bus = |p: &Point, r: f64| match power_of(p, r) {
            taken if taken > 0.0 => taken / bus.drive_efficiency + standby,
            given if lifted => given * kept.min(bus.drive_efficiency) + standby,
            _ => standby,
        };
        let open_of = |p: &Point, r: f64| match v_q(p, r).hypot(v_d(p)) / per_volt {
            needs if needs > bus.voltage / 2.0 => needs + series * from_bus(p, r) / needs,
            _ => bus.voltage / 2.0 + series * from_bus(p, r) / (bus.voltage / 2.0),
        };
        let open = |p: &Point| worse(&|r| open_of(p, r));
        let volt = Some(if sags { bus.voltage } else { bus.voltage * per_volt });
        let voltages = |list: &[Point]| match (allowed, sags) {
            (_, true) => largest(list, &open),
            (Some(x), _) => largest(list, &|p| worse(&|r| turned(parts(p, r), lowest(parts(p, r), x)))).sqrt(),
            (None, _) => largest(list, &voltage),
        };
        let with_direct = |list: &[Point], direct: &[f64]| {
            let squares = list.iter().zip(direct).map(|(p, x)| worse(&|r| turned(parts(p, r), *x)));
            squares.fold(f64::NEG_INFINITY, f64::max).sqrt()
        };
        let own_voltage = if burns.is_some() { with_direct(raw, &own[0]) } else { voltages(raw) };
        let ripple_voltage = match (allowed, burns) {
            (Some(_), _) => with_direct(&self.rippled, &rippled_direct).max(0.0),
            (_, Some(_)) => with_direct(&self.rippled, &own[1]).max(0.0),
            _ => voltages(&self.rippled),
        };
        let through = bus.current.map(|i| if sags { i.min(bus.voltage / (2.0 * series)) } else { i });
        let hot = motor.thermal_resistance.map(|r_th| (hottest(motor, asked.winding_temperature), r_th));
        let t_0 = motor.reference_temperature;
        let resistance = |kelvin: f64| r * (1.0 + copper(t_0) * (kelvin - t_0));
        let hot = hot.map(|(hot, r_th)| ((hot - self.robot.ambient) / (r_th * resistance(hot))).sqrt());
        // A motion that happens once, from cold, has no steady state of heat.
        let once = matches!(joint.motion.course, Course::Once(_));
        let timed_bound = |bound: Option<f64>| bound.filter(|_| joint.motion.course != Course::Points(None));
        let meant = |bound: Option<f64>| timed_bound(bound).filter(|_| !once);
        let stands = brushless && shares.iter().any(|share| share[1] > 0.0);
        // Of a motor with a continuous torque alone, the current that it takes.
        let of_torque = motor.continuous_torque.map(|torque| torque / k_t);
        let held = meant(least(motor.continuous_current, hot).or(of_torque)).filter(|_| stands);
        // The phase that carries twice its share warms over its own way to the housing alone.
        let ways = [motor.sheet.thermal_resistance_winding_housing, motor.sheet.thermal_resistance_housing_ambient];
        let own = match ways.map(|way| way.map(|p| p.value)) {
            [Some(inner), Some(outer)] => inner / (inner + outer),
            _ => 1.0,
        };
        let rippled = |bound: Option<f64>| bound.filter(|_| asked.torque_bandwidth.is_some());
        let taken = match bus.regeneration {
            Regeneration::Limited(watt) => Some(watt + bus.brake_power.unwrap_or(0.0)),
            Regeneration::Dissipated => bus.brake_power,
            Regeneration::Allowed => None,
        };
        let supply_takes = match bus.regeneration {
            Regeneration::Limited(watt) => watt,
            Regeneration::Dissipated => 0.0,
            Regeneration::Allowed => f64::INFINITY,
        };
        let lift = bus.max_voltage.filter(|_| sags).map(|most| most * (most - bus.voltage) / series);
        let lift = lift.filter(|lift| supply_takes > *lift).map(|lift| lift + bus.brake_power.unwrap_or(0.0));
        let braked = bus.brake_power.is_some() || bus.regeneration == Regeneration::Dissipated;
        let most_kept = match bus.regeneration {
            Regeneration::Dissipated => 0.0,
            Regeneration::Limited(watt) if braked => watt * kept / bus.drive_efficiency,
            _ => f64::INFINITY,
        };
        let rise = self.nodes().map(|nodes| {
            let mut heat = self.copper_heat_at(n, drag);
            heat.watt.iter_mut().zip(&direct).for_each(|(watt, x)| *watt += r * x * x);
            nodes.peak(&heat)
        });
        let hottest = rise.map(|_| (hottest(motor, asked.winding_temperature) - self.robot.ambient).max(0.0));
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let limits = [
            ("peak_current", asked.safety * most_current / k_t, current),
            ("peak_torque", asked.safety * most_torque, motor.peak_torque),
            ("continuous_current", square.sqrt() / k_t, meant(motor.continuous_current)),
            (
                "drive_continuous_current",
                square.sqrt() / k_t,
                timed_bound(of_drive.continuous_current.map(|i| i * amplitude)),
            ),
            ("continuous_torque", square.sqrt(), meant(motor.continuous_torque)),
            ("winding_temperature", square.sqrt() / k_t, meant(hot)),
            ("winding_peak_temperature", rise.unwrap_or(0.0), hottest),
            ("standstill_holding", (square + own * at_rest).sqrt() / k_t, held),
            ("voltage", own_voltage, volt),
            (
                "open_circuit_voltage",
                speed * motor.emf_constant() * if brushless { 2.0_f64.sqrt() } else { 1.0 },
                bus.max_voltage,
            ),
            ("max_speed", speed, motor.max_speed),
            ("gear_input_speed", speed, gear.max_input_speed),
            ("gear_peak_torque", asked.safety * most_load, gear.peak_torque),
            ("gear_continuous_torque", load.sqrt(), timed_bound(gear.continuous_torque)),
            ("reflected_inertia", inertia, asked.reflected_inertia),
            ("torque_bandwidth_current", asked.safety * most_ripple / k_t, rippled(current)),
            ("torque_bandwidth_voltage", ripple_voltage, rippled(volt).filter(|_| motor.inductance.is_some())),
            ("bus_power", watt, bus.power.map(|most| most - standby)),
            (
                "bus_current",
                watt / bus.voltage,
                through.map(|i| i - series * i * i / bus.voltage - standby / bus.voltage),
            ),
            ("regeneration", back, taken),
            ("bus_overvoltage", back, lift),
            ("actuator_mass", mass, asked.actuator_mass),
            ("ratio_min", min, Some(n)),
            ("ratio_max", n, Some(max)),
        ];
        let drawn = |p: &Point, k: usize| {
            let current = (usual(p) / k_t).powi(2) + direct[k].powi(2);
            let watt = (r + lead) * current + motor.emf_constant() * n * p.velocity * usual(p) / k_t;
            let from_bus = if watt > 0.0 { watt / bus.drive_efficiency } else { (watt * kept).max(-most_kept) };
            (from_bus, watt)
        };
        // All that is lost at an instant: copper and leads, the motor's and the gear's friction, load that the gear's
        // efficiency takes, and what the drive's takes.
        let lost = |p: &Point, k: usize| {
            let speed = n * p.velocity.abs();
            let gearing = (phi(p) - 1.0) * p.torque * p.velocity;
            let (bus, terminals) = drawn(p, k);
            let current = (usual(p) / k_t).powi(2) + direct[k].powi(2);
            (r + lead) * current + speed * (rubbing + b * speed) + gearing + (bus - terminals)
        };
        let duration = match joint.motion.course {
            Course::Periodic(duration) | Course::Once(duration) => duration,
            Course::Points(total) => total.unwrap_or(0.0),
            Course::Cases => unreachable!("a drawn motion has no cases"),
        };
        let over_time = |f: &dyn Fn(&Point, usize) -> f64| {
            timed.clone().enumerate().map(|(k, (p, s))| s[0] * f(p, k)).sum::<f64>() + standby
        };
        let (energy, loss) = (duration * over_time(&|p, k| drawn(p, k).0), over_time(&lost));
        let copper = r * square / (k_t * k_t);
        let quantities = [loss, copper, inertia, most_current / k_t, mass, energy, watt.max(0.0) + standby];
        let objective = joint.objective.terms.iter().map(|(q, weight)| weight * quantities[*q as usize]).sum();
        let needs = |p: &Point| windings.map(|r| [v_q(p, r).hypot(v_d(p)) / per_volt, from_bus(p, r)]);
        let bus = if sags { raw.iter().flat_map(needs).collect() } else { Vec::new() };
        Look { quantities, objective, limits, bus, direct: [direct, rippled_direct] }
    }

    /// Radius of the q-axis circle per volt of the bus.
    fn circle(&self) -> f64 {
        match (self.motor.conventions.commutation, self.robot.bus.modulation) {
            (Commutation::Brushed, _) => 1.0,
            (_, Modulation::Sine) => 0.375_f64.sqrt(),
            _ => 0.5_f64.sqrt(),
        }
    }

    /// The two thermal nodes, where the sheet has them and the motion has a course.
    pub fn nodes(&self) -> Option<Nodes> {
        let (sheet, value) = (&self.motor.sheet, |printed: Option<Printed>| printed.map(|p| p.value));
        if matches!(self.robot.joints[0].motion.course, Course::Points(_)) {
            return None;
        }
        Some(Nodes {
            between: value(sheet.thermal_resistance_winding_housing)?,
            outside: value(sheet.thermal_resistance_housing_ambient)?,
            winding: value(sheet.thermal_time_constant_winding)?,
            housing: value(sheet.thermal_time_constant_housing)?,
            copper: copper(self.motor.reference_temperature),
            warm: 1.0
                + copper(self.motor.reference_temperature) * (self.robot.ambient - self.motor.reference_temperature),
        })
    }

    /// Share of the time of each sample at standstill.
    fn stands(&self, n: f64) -> Vec<f64> {
        let brushless = self.motor.conventions.commutation == Commutation::Brushless;
        self.shares_at(n).iter().map(|[all, rest]| if brushless && *all > 0.0 { rest / all } else { 0.0 }).collect()
    }

    /// A heat over the course of the motion at a ratio.
    pub fn heat(&self, n: f64, watt: impl FnMut(&Point) -> f64) -> Heat {
        let motion = &self.robot.joints[0].motion;
        let period = if let Course::Periodic(period) = motion.course { Some(period) } else { None };
        Heat { time: motion.time.clone(), watt: self.raw.iter().map(watt).collect(), still: self.stands(n), period }
    }

    /// Copper heat at a ratio.
    pub fn copper_heat(&self, n: f64) -> Heat {
        self.copper_heat_at(n, [0.0; 2])
    }

    fn copper_heat_at(&self, n: f64, drag: [f64; 2]) -> Heat {
        let (motor, gear) = (&self.motor, &self.gear(n));
        let j = motor.rotor_inertia.unwrap() + gear.inertia;
        let b = motor.viscous_friction.unwrap_or(0.0) + gear.no_load.viscous + drag[1];
        let rubbing = motor.coulomb_friction.unwrap_or(0.0) + gear.no_load.coulomb + drag[0];
        self.heat(n, |p| {
            let phi = if p.torque * p.velocity < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
            if p.velocity == 0.0 {
                return motor.resistance * ((p.torque / n + n * j * p.acceleration) / motor.torque_constant).powi(2);
            }
            let rubs = rubbing.copysign(p.velocity);
            let torque = phi * p.torque / n + n * (j * p.acceleration + b * p.velocity) + rubs;
            motor.resistance * (torque / motor.torque_constant).powi(2)
        })
    }

    /// By how much each limit that applies is exceeded (absolutely, where nothing is allowed).
    pub fn excess(&self, n: f64) -> impl Iterator<Item = (f64, &'static str)> {
        let over = |demand: f64, bound: f64| if bound > 0.0 { demand / bound - 1.0 } else { demand };
        self.look(n).limits.into_iter().filter_map(move |(name, demand, bound)| Some((over(demand, bound?), name)))
    }

    pub fn worst(&self, n: f64) -> (f64, &'static str) {
        self.excess(n).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}

/// Temperature coefficient of copper's resistance at a temperature: 0.00393 of the resistance at 20 °C.
pub fn copper(reference: f64) -> f64 {
    1.0 / (1.0 / 0.003_93 + reference - 293.15)
}

/// The highest temperature of the winding: the lower of the motor's and the requirement's, else 100 °C.
pub fn hottest(motor: &Motor, asked: Option<f64>) -> f64 {
    motor.max_winding_temperature.into_iter().chain(asked).reduce(f64::min).unwrap_or(373.15)
}

/// Resistance over that at the reference, at the highest temperature that motor and requirement allow, or else at the
/// one that the rated current settles at.
pub fn hottest_factor(motor: &Motor, asked: Option<f64>) -> f64 {
    let (t_0, a) = (motor.reference_temperature, copper(motor.reference_temperature));
    1.0 + a * (hottest(motor, asked) - t_0)
}

/// Copper's resistance at ambient over that at the reference.
pub fn ambient_factor(motor: &Motor, ambient: f64) -> f64 {
    1.0 + copper(motor.reference_temperature) * (ambient - motor.reference_temperature)
}

/// Winding and housing: resistances and time constants, and resistance at ambient over the reference's.
pub struct Nodes {
    between: f64,
    outside: f64,
    pub winding: f64,
    housing: f64,
    copper: f64,
    warm: f64,
}

/// Heat at the samples, at the resistance's reference temperature; a period where it repeats.
pub struct Heat {
    time: Vec<f64>,
    watt: Vec<f64>,
    /// How nearly the rotor stands still.
    still: Vec<f64>,
    period: Option<f64>,
}

/// An affine map of the rises of winding and housing.
type Affine = ([[f64; 2]; 2], [f64; 2]);

fn apply((m, c): &Affine, x: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| m[i][0] * x[0] + m[i][1] * x[1] + c[i])
}

impl Heat {
    /// Start, length and heat at the ends of every interval; the last closes the period.
    fn intervals(&self) -> Vec<(f64, f64, [f64; 2])> {
        self.intervals_of(&self.watt)
    }

    /// The same of three times the heat of the phase that is worst off: at standstill twice the mean.
    fn intervals_of_phase(&self) -> Vec<(f64, f64, [f64; 2])> {
        let phase: Vec<f64> = self.watt.iter().zip(&self.still).map(|(watt, still)| (1.0 + still) * watt).collect();
        self.intervals_of(&phase)
    }

    fn stands(&self) -> bool {
        self.still.iter().any(|still| *still > 0.0)
    }

    fn intervals_of(&self, q: &[f64]) -> Vec<(f64, f64, [f64; 2])> {
        let (t, n) = (&self.time, self.time.len());
        let mut list: Vec<_> = (1..n).map(|k| (t[k - 1], t[k] - t[k - 1], [q[k - 1], q[k]])).collect();
        list.extend(self.period.map(|period| (t[n - 1], t[0] + period - t[n - 1], [q[n - 1], q[0]])));
        list
    }
}

impl Nodes {
    /// Rates of both rises per rise and on their own at a heat.
    fn rates(&self, watt: f64) -> Affine {
        let (c_w, c_h) = (self.winding / self.between, self.housing / self.outside);
        let exchange = 1.0 / (self.between * c_h);
        let a = [
            [self.copper * watt / c_w - 1.0 / self.winding, 1.0 / self.winding],
            [exchange, -exchange - 1.0 / self.housing],
        ];
        (a, [watt * self.warm / c_w, 0.0])
    }

    /// The map over a time of constant heat, from the eigenvalues `m ± d`.
    fn hold(&self, watt: f64, h: f64) -> Affine {
        let (a, b) = self.rates(watt);
        let (m, half) = (0.5 * (a[0][0] + a[1][1]), 0.5 * (a[0][0] - a[1][1]));
        let d = (half * half + a[0][1] * a[1][0]).sqrt();
        let (even, odd) = ((m * h).exp() * (d * h).cosh(), (m * h).exp() * (d * h).sinh() / d);
        let e = [[even + odd * half, odd * a[0][1]], [odd * a[1][0], even - odd * half]];
        // (e^{Ah} − I) A⁻¹ b
        let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
        let x = [a[1][1] * b[0] / determinant, -a[1][0] * b[0] / determinant];
        (e, [(e[0][0] - 1.0) * x[0] + e[0][1] * x[1], e[1][0] * x[0] + (e[1][1] - 1.0) * x[1]])
    }

    /// The parts of an interval, with the heats at their ends: at most 1/16 of the winding's time constant long.
    fn parts(&self, length: f64, [q, then]: [f64; 2]) -> impl Iterator<Item = (f64, [f64; 2])> {
        let count = (16.0 * length / self.winding).ceil().clamp(1.0, 256.0);
        let at = move |k: u32| q + (then - q) * f64::from(k) / count;
        (0..count as u32).map(move |k| (length / count, [at(k), at(k + 1)]))
    }

    /// The largest rise of the winding, in the periodic state or from cold; infinite where it runs away.
    /// As the model declares it: each part in two halves with its mean heat and its first moment, or at its mean where it is
    /// short; and between the ends of a part steps of 1/4096 of the time constant (4 to 256) at the larger heat of their ends.
    pub fn peak(&self, heat: &Heat) -> f64 {
        let mut parts = Vec::new();
        for (_, length, ends) in heat.intervals() {
            for (h, [q, then]) in self.parts(length, ends) {
                let mean = 0.5 * (q + then);
                // A straight line has the moment Δ h²/12; two halves at ± x have x h²/4.
                let off = (then - q) / 3.0;
                let halves = match h <= self.winding / 1024.0 {
                    true => vec![self.hold(mean, h)],
                    false => vec![self.hold(mean - off, 0.5 * h), self.hold(mean + off, 0.5 * h)],
                };
                parts.push((h, [q, then], halves));
            }
        }
        let mut rise = [0.0; 2];
        if heat.period.is_some() {
            // x = Φ x + d: the columns of Φ from two starts, d from cold.
            let all = || parts.iter().flat_map(|part| &part.2);
            let end = |start: [f64; 2]| all().fold(start, |x, part| apply(part, x));
            let linear = |start: [f64; 2]| all().fold(start, |x, (m, _)| apply(&(*m, [0.0; 2]), x));
            let (d, first, second) = (end([0.0; 2]), linear([1.0, 0.0]), linear([0.0, 1.0]));
            let (a, b, c, e) = (1.0 - first[0], -second[0], -first[1], 1.0 - second[1]);
            let determinant = a * e - b * c;
            if !(a > 0.0 && e > 0.0 && determinant > 0.0) {
                return f64::INFINITY;
            }
            rise = [(e * d[0] - b * d[1]) / determinant, (a * d[1] - c * d[0]) / determinant];
        }
        // The starts of all parts, and the largest of them: what cannot come up to that within a part is not looked at.
        let mut starts = vec![rise];
        for (_, _, halves) in &parts {
            starts.push(halves.iter().fold(*starts.last().unwrap(), |x, half| apply(half, x)));
        }
        let mut peak = starts.iter().map(|x| x[0]).fold(f64::NEG_INFINITY, f64::max);
        let of_phase = if heat.stands() { self.phase_peak(heat, rise) } else { f64::NEG_INFINITY };
        for ((h, [q, then], _), rise) in parts.iter().zip(starts) {
            // The hotter of both nodes is heated by no more than the copper, and that is below the peak.
            let warms = h * q.max(*then) * (self.warm + self.copper * peak) * self.between / self.winding;
            if rise[0].max(rise[1]) + warms < peak {
                continue;
            }
            let count = (4096.0 * h / self.winding).ceil().clamp(4.0, 256.0);
            let at = |k: u32| q + (then - q) * f64::from(k) / count;
            (0..count as u32).fold(rise, |x, k| {
                let x = apply(&self.hold(at(k).max(at(k + 1)), h / count), x);
                peak = peak.max(x[0]);
                x
            });
        }
        let peak = peak.max(of_phase);
        if peak.is_finite() { peak } else { f64::INFINITY }
    }

    /// The largest rise of the hottest phase: its own node between its heat and the housing. As the model declares it, with the parts, halves
    /// and steps of the winding; by the classic Runge-Kutta rule beside the exact winding and housing.
    fn phase_peak(&self, heat: &Heat, start: [f64; 2]) -> f64 {
        // Rises of both nodes and of the phase after a time at constant heats of both.
        let held = |(x, z): ([f64; 2], f64), watt: f64, of_phase: f64, length: f64| {
            let (a, b) = self.rates(of_phase);
            let count = (128.0 * length * a[0][0].abs().max(1.0 / self.winding)).ceil().max(1.0);
            let h = length / count;
            let half = self.hold(watt, 0.5 * h);
            let slope = |x: [f64; 2], z: f64| a[0][0] * z + a[0][1] * x[1] + b[0];
            (0..count as u32).fold((x, z), |(x, z), _| {
                let middle = apply(&half, x);
                let end = apply(&half, middle);
                let k1 = slope(x, z);
                let k2 = slope(middle, z + 0.5 * h * k1);
                let k3 = slope(middle, z + 0.5 * h * k2);
                let k4 = slope(end, z + h * k3);
                (end, z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
            })
        };
        let intervals = heat.intervals().into_iter().zip(heat.intervals_of_phase());
        let parts: Vec<(f64, [f64; 2], [f64; 2])> = intervals
            .flat_map(|((_, length, ends), (_, _, of_phase))| {
                let both = self.parts(length, ends).zip(self.parts(length, of_phase));
                both.map(|((h, ends), (_, of_phase))| (h, ends, of_phase)).collect::<Vec<_>>()
            })
            .collect();
        let part = |state, (h, ends, of_phase): &(f64, [f64; 2], [f64; 2])| {
            let at = |[q, then]: [f64; 2], side: f64| 0.5 * (q + then) + side * (then - q) / 3.0;
            if *h <= self.winding / 1024.0 {
                return held(state, at(*ends, 0.0), at(*of_phase, 0.0), *h);
            }
            [-1.0, 1.0]
                .into_iter()
                .fold(state, |state, side| held(state, at(*ends, side), at(*of_phase, side), 0.5 * h))
        };
        let over = |z: f64| parts.iter().fold((start, z), part).1;
        let mut z = 0.0;
        if heat.period.is_some() {
            let (from_nothing, from_one) = (over(0.0), over(1.0));
            let decay = from_one - from_nothing;
            if decay >= 1.0 {
                return f64::INFINITY;
            }
            z = from_nothing / (1.0 - decay);
        }
        let mut state = (start, z);
        let mut peak = z;
        for now in &parts {
            let (h, [q, then], [phase, next]) = *now;
            let count = (4096.0 * h / self.winding).ceil().clamp(4.0, 256.0);
            let larger = |q: f64, then: f64, k: u32| {
                let at = |k: u32| q + (then - q) * f64::from(k) / count;
                at(k).max(at(k + 1))
            };
            if q != then || phase != next {
                (0..count as u32).fold(state, |state, k| {
                    let state = held(state, larger(q, then, k), larger(phase, next, k), h / count);
                    peak = peak.max(state.1);
                    state
                });
            }
            state = part(state, now);
            peak = peak.max(state.1);
        }
        peak
    }

    /// What the bound from above may give away \[K\], at a rise: within a part of length h, whose heat changes by Δq, each
    /// of n steps has `Δq/(2 n)` too much, `h Δq/(2 n C_w)` in all; also of the hottest phase, whose heat and whose mean heat are too large.
    pub fn given_away(&self, heat: &Heat, rise: f64) -> f64 {
        let mut most = 0.0_f64;
        for (_, length, ends) in heat.intervals().into_iter().chain(heat.intervals_of_phase()) {
            for (h, [q, then]) in self.parts(length, ends) {
                let count = (4096.0 * h / self.winding).ceil().clamp(4.0, 256.0);
                most = most.max(h / self.winding * (then - q).abs() / (2.0 * count));
            }
        }
        most * self.between * (self.warm + self.copper * rise)
    }

    /// The largest rise by the classic Runge-Kutta rule for heat that is linear between samples: no parts, and
    /// the periodic state by repeating until it repeats.
    pub fn integrated_peak(&self, heat: &Heat, steps: f64) -> f64 {
        let (mut start, mut peak) = ([0.0_f64; 3], f64::INFINITY);
        let both: Vec<_> = heat.intervals().into_iter().zip(heat.intervals_of_phase()).collect();
        for _ in 0..if heat.period.is_some() { 100_000 } else { 1 } {
            let mut x = start;
            peak = x[0];
            for ((_, length, [q, then]), (_, _, [phase, next])) in both.iter().copied() {
                let count = (steps * length / self.winding).ceil().max(1.0);
                let h = length / count;
                // Winding, housing, and the hottest phase as a winding of its own between its heat and that housing.
                let slope = |t: f64, x: [f64; 3]| {
                    let [w, h] = apply(&self.rates(q + (then - q) * t / length), [x[0], x[1]]);
                    [w, h, apply(&self.rates(phase + (next - phase) * t / length), [x[2], x[1]])[0]]
                };
                for step in 0..count as u32 {
                    let t = f64::from(step) * h;
                    let moved = |k: [f64; 3], by: f64| [0, 1, 2].map(|i| x[i] + by * k[i]);
                    let k1 = slope(t, x);
                    let k2 = slope(t + 0.5 * h, moved(k1, 0.5 * h));
                    let k3 = slope(t + 0.5 * h, moved(k2, 0.5 * h));
                    let k4 = slope(t + h, moved(k3, h));
                    x = [0, 1, 2].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
                    peak = peak.max(x[0]).max(x[2]);
                }
            }
            let moved = (0..3).map(|i| (x[i] - start[i]).abs()).fold(0.0, f64::max);
            if heat.period.is_none() || moved < 1e-9 || x[0] > 1e6 {
                break;
            }
            start = x;
        }
        peak
    }
}

/// Golden section for the least of `f` between two ratios.
pub fn golden(f: impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> f64 {
    let halfway = |(a, b), _| {
        let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
        if f(c) <= f(d) { (a, d) } else { (c, b) }
    };
    (0..60).fold((a, b), halfway).0
}

/// The neighbours of each local minimum in a list of ratios with values.
fn dips(seen: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let around = |i: usize| [seen[i.saturating_sub(1)], seen[i], seen[(i + 1).min(seen.len() - 1)]];
    let dip = |[a, b, c]: [[f64; 2]; 3]| ((a == b || b[1] < a[1]) && b[1] <= c[1]).then_some([a[0], c[0]]);
    (0..seen.len()).filter_map(|i| dip(around(i))).collect()
}

/// What the scan found: the feasible intervals, the ratios it looked at, the least violation.
pub struct Scan {
    pub windows: Vec<[f64; 2]>,
    pub grid: Vec<f64>,
    pub least: (f64, &'static str),
}

impl Scan {
    pub fn new(case: &Case) -> Scan {
        Scan::over(case, RATIOS)
    }

    /// As [`Scan::new`], with so many ratios to begin with.
    pub fn over(case: &Case, ratios: usize) -> Scan {
        let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
        let mut grid: Vec<f64> = (1..ratios).map(|i| min * (max / min).powf(i as f64 / ratios as f64)).collect();
        grid.extend([min, max]);
        let stages = case.robot.joints[0].gear.mass_per_stage.map(|(_, ratio)| (0..30).map(move |k| ratio.powi(k)));
        grid.extend(stages.into_iter().flatten().filter(|n| (min..max).contains(n)));
        let rows = case.family.iter().flat_map(|row| [row.ratio.next_down(), row.ratio, row.ratio.next_up()]);
        grid.extend(rows.filter(|n| (min..max).contains(n)));
        grid.sort_by(f64::total_cmp);
        // A feasible ratio may hide between infeasible ones, and the other way round.
        let seen: Vec<[f64; 2]> = grid.iter().map(|n| [*n, case.worst(*n).0]).collect();
        let upside_down: Vec<[f64; 2]> = seen.iter().map(|[n, over]| [*n, -over]).collect();
        grid.extend(dips(&seen).into_iter().map(|between| golden(|n| case.worst(n).0, between)));
        grid.extend(dips(&upside_down).into_iter().map(|between| golden(|n| -case.worst(n).0, between)));
        grid.sort_by(f64::total_cmp);
        // Bisection between an infeasible and a feasible ratio ends on the feasible side.
        let halve = |(bad, good), _| {
            let n = 0.5 * (bad + good);
            if case.worst(n).0 > 0.0 { (n, good) } else { (bad, n) }
        };
        let worst: Vec<(f64, &str)> = grid.iter().map(|n| case.worst(*n)).collect();
        let mut ends = Vec::from_iter((worst[0].0 <= 0.0).then_some(min));
        for i in 1..grid.len() {
            match (worst[i - 1].0 > 0.0, worst[i].0 > 0.0) {
                (true, false) => ends.push((0..60).fold((grid[i - 1], grid[i]), halve).1),
                (false, true) => ends.push((0..60).fold((grid[i], grid[i - 1]), halve).1),
                _ => {}
            }
        }
        ends.extend((worst[grid.len() - 1].0 <= 0.0).then_some(max));
        let windows = ends.chunks(2).map(|window| [window[0], window[1]]).collect();
        Scan { windows, grid, least: worst.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap() }
    }

    /// The least of `f` over the windows: their ends, the grid between them, and refined around its dips.
    pub fn least_of(&self, f: impl Fn(f64) -> f64) -> f64 {
        let least = |&[a, b]: &[f64; 2]| {
            let inside = self.grid.iter().copied().filter(|n| a < *n && *n < b);
            let seen: Vec<[f64; 2]> = [a].into_iter().chain(inside).chain([b]).map(|n| [n, f(n)]).collect();
            let refined = dips(&seen).into_iter().map(|between| f(golden(&f, between)));
            seen.iter().map(|at| at[1]).chain(refined).fold(f64::INFINITY, f64::min)
        };
        self.windows.iter().map(least).fold(f64::INFINITY, f64::min)
    }
}

/// What every case starts from.
const MOTOR: &str =
    "id,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A]\nm,-,derived,q_axis,q_axis,1,1";
const ROBOT: &str = "name='r'\nbus={voltage='1 V'}\njoint=[{name='j',ratio={min=1,max=2},motor_drag='off',points=[{torque='1 N*m',speed='1 rad/s'}]}]";

/// Draws a case: a motor and a motion that suit each other at some ratio, and limits around what is
/// needed near it. A convex one has neither Coulomb friction nor a regeneration limit nor a weighted
/// objective that bends the wrong way; the others have at least one of them.
pub fn draw(index: u64, convex: bool) -> Case {
    let generator = RefCell::new(Pcg64::seed_from_u64(index));
    let within = |a: f64, b: f64| generator.borrow_mut().random_range(a..b);
    let around = |a: f64, b: f64| a * (b / a).powf(within(0.0, 1.0));
    let chance = |share: f64| within(0.0, 1.0) < share;
    let below = |count: f64| within(0.0, count) as usize;
    let [rubs, regenerates, peaked, stepped] = [0, 1, 2, 3].map(|kind| !convex && (index % 4 == kind || chance(0.15)));
    // The motion: harmonics at uneven times with stretches and single samples at standstill, or points.
    let (period, speed, matched) = (around(0.2, 3.0), around(0.5, 30.0), around(3.0, 60.0));
    let (form, ripples, heated) = (within(0.0, 1.0), chance(0.2), chance(0.3));
    let count = if form > 0.8 {
        around(1.0, 12.0)
    } else {
        around(
            8.0,
            if ripples {
                24.0
            } else if heated {
                80.0
            } else {
                301.0
            },
        )
    } as usize;
    let (rotor, of_gear) = (around(1e-7, 1e-3), if chance(0.5) { around(1e-8, 1e-4) } else { 0.0 });
    let torque = (rotor + of_gear) * speed * TAU / period * matched * matched * around(0.2, 5.0);
    // One to four harmonics: value, first and second derivative. Each brings a factor w and a quarter of a turn.
    let harmonic = |size| [size * within(0.1, 1.0), TAU / period * within(1.0, 6.0).floor(), within(0.0, TAU)];
    let wave = |size| (0..=below(4.0)).map(|_| harmonic(size)).collect::<Vec<[f64; 3]>>();
    let sine = |[a, w, x]: &[f64; 3], t: f64, k: i32| a * w.powi(k) * (w * t + x + f64::from(k) * TAU / 4.0).sin();
    let at = |wave: &[[f64; 3]], t: f64| [0, 1, 2].map(|k| wave.iter().map(|h| sine(h, t, k)).sum::<f64>());
    let (load, turn, offset) = (wave(torque), wave(speed), within(-torque, torque));
    let (rest, rests) = (below(count as f64), below(3.0) * count / 8);
    let (mut time, mut raw) = (Vec::new(), Vec::new());
    for k in 0..count {
        let t = period * (k as f64 + within(0.0, 0.5)) / count as f64;
        let ([tau, torque_rate, _], turning) = (at(&load, t), at(&turn, t));
        let [omega, acceleration, jerk] = if (rest..rest + rests).contains(&k) { [0.0; 3] } else { turning };
        let velocity = if chance(0.02) { 0.0 } else { omega };
        let duration = (form < 0.93).then(|| around(0.1, 2.0));
        raw.push(Point { torque: tau + offset, velocity, acceleration, torque_rate, jerk, duration });
        time.push(t);
    }
    let course = if form < 0.55 { Course::Periodic(period) } else { Course::Once(time[count - 1] - time[0]) };
    // What stands at two neighbouring samples has no acceleration (tests/library/proof/instants.rs looks at holds that begin with some).
    let around_the_end = matches!(course, Course::Periodic(_));
    let stands: Vec<bool> = raw.iter().map(|p: &Point| p.velocity == 0.0).collect();
    let beside = |k: usize, other: usize| (around_the_end || k.abs_diff(other) == 1) && stands[other];
    for k in (0..count).filter(|k| stands[*k]) {
        if count > 1 && (beside(k, (k + 1) % count) || beside(k, (k + count - 1) % count)) {
            (raw[k].acceleration, raw[k].jerk) = (0.0, 0.0);
        }
    }
    // In one case of five, what would stand creeps to and fro: from far below to far above what counts as standstill.
    if index % 5 == 2 {
        let mut creeps = Pcg64::seed_from_u64(index ^ 0xc4ee);
        let most = 10.0_f64.powf(creeps.random_range(-4.0..0.0)) / matched;
        for k in (0..count).filter(|k| stands[*k]) {
            let size = most * creeps.random_range(0.2..1.0);
            raw[k].velocity = if creeps.random_range(0.0..1.0) < 0.5 { size } else { -size };
        }
    }
    let column = |f: fn(&Point) -> f64| Some(raw.iter().map(f).collect::<Vec<f64>>());
    let (acceleration, torque_rate, jerk) = (column(|p| p.acceleration), column(|p| p.torque_rate), column(|p| p.jerk));
    let (torques, velocity) = (column(|p| p.torque).unwrap(), column(|p| p.velocity));
    let given = Samples { time, torque: torques, position: None, velocity, acceleration, torque_rate, jerk };
    // The motor: R i and K_B N ω of like size.
    let mut motor = Catalog::from_sources(vec![Arc::new(Source::new("motor.csv", MOTOR))]).unwrap().motors.remove(0);
    let mut robot = read_source(&Arc::new(Source::new("robot.toml", ROBOT))).unwrap();
    (motor.resistance, motor.reference_temperature) = (around(0.02, 5.0), within(288.0, 300.0));
    motor.torque_constant = (motor.resistance * torque / speed * around(0.5, 50.0)).sqrt() / matched;
    motor.back_emf_constant = motor.torque_constant * within(0.85, 1.15).min(1.0);
    motor.inductance = [None, Some(0.0), Some(motor.resistance * around(1e-5, 4e-3))][below(12.0).min(2)];
    motor.pole_pairs = if chance(0.9) { Some(1 + below(22.0) as u32).filter(|pairs| *pairs < 22) } else { Some(0) };
    motor.conventions.commutation =
        if motor.pole_pairs == Some(0) { Commutation::Brushed } else { Commutation::Brushless };
    (motor.rotor_inertia, motor.mass, robot.ambient) = (Some(rotor), Some(around(0.05, 2.0)), within(285.0, 313.0));
    motor.viscous_friction = chance(0.4).then(|| rotor * around(0.1, 10.0));
    motor.coulomb_friction = rubs.then(|| torque / matched * around(0.01, 0.5));
    // Bus and joint.
    robot.bus.modulation = if chance(0.3) { Modulation::Sine } else { Modulation::SpaceVector };
    (robot.bus.modulation_limit, robot.bus.drive_efficiency) = (within(0.85, 1.0), within(0.85, 1.0));
    let (joint, middle) = (&mut robot.joints[0], matched * around(0.4, 2.5));
    joint.motion =
        if form > 0.8 { Motion::from_points(&raw).into() } else { Motion::from_samples(given, course).into() };
    (joint.gear.efficiency, joint.gear.inertia) = (within(0.5, 1.3).min(1.0), of_gear);
    joint.gear.backdrive_efficiency = [2.0 - 1.0 / joint.gear.efficiency, within(-0.2, 1.0)][below(2.0)];
    joint.gear.mass = Some(around(0.05, 2.0));
    joint.gear.mass_per_stage = Some((around(0.05, 2.0), within(3.0, 10.0))).filter(|_| stepped || chance(0.4));
    joint.ratio = RatioChoice::Continuous { min: middle * around(0.01, 0.8), max: middle * around(1.25, 100.0) };
    let ripple = TorqueBandwidth { frequency: around(1.0, 60.0), amplitude: torque * around(0.05, 1.0) };
    (joint.limits.torque_bandwidth, joint.limits.safety) = (ripples.then_some(ripple), within(0.5, 1.5).max(1.0));
    // Limits: each is there or not, and allows more or less than the middle ratio needs.
    let mut case = Case::new(motor, robot, raw);
    let at = case.look(middle);
    let need: BTreeMap<&str, f64> = at.limits.iter().map(|limit| (limit.0, limit.1)).collect();
    let (often, low, high) = ([0.1, 0.25, 0.5][below(3.0)], [0.5, 0.95][below(2.0)], around(1.1, 4.0));
    let allow = |name: &str| Some(need[name] * around(low, high)).filter(|most| chance(often) && *most > 0.0);
    let rippled = ("torque_bandwidth_current", "torque_bandwidth_voltage");
    let (current, voltage) = if ripples { rippled } else { ("peak_current", "voltage") };
    let (joint, bus, motor) = (&mut case.robot.joints[0], &mut case.robot.bus, &mut case.motor);
    bus.voltage = allow(voltage).unwrap_or(4.0 * need["voltage"]) / 0.6;
    (bus.power, bus.current) = (allow("bus_power"), allow("bus_power").map(|watt| watt / bus.voltage));
    let taken = Regeneration::Limited(allow("regeneration").unwrap_or(0.0));
    bus.regeneration = if regenerates { taken } else { Regeneration::Allowed };
    (bus.drive_current, joint.drive_current) = (allow(current).map(|i| i / 1.2), allow(current).map(|i| i / 1.2));
    (motor.peak_current, motor.peak_torque) = (allow(current), allow("peak_torque"));
    (motor.continuous_current, motor.continuous_torque) = (allow("standstill_holding"), allow("continuous_torque"));
    motor.thermal_resistance = allow("standstill_holding").map(|i| 60.0 / (i * i * motor.resistance));
    motor.max_winding_temperature = Some(within(380.0, 420.0)).filter(|_| chance(0.7));
    if heated {
        let i = motor.thermal_resistance.is_none().then(|| need["standstill_holding"] * around(low, high));
        let total = motor.thermal_resistance.unwrap_or_else(|| 60.0 / (i.unwrap().powi(2) * motor.resistance));
        let (share, winding) = (within(0.1, 0.9), period * around(0.3, 30.0));
        let printed = |value: f64| Some(Printed { value, tolerance: None });
        motor.thermal_resistance = Some(total * share + total * (1.0 - share));
        motor.sheet.thermal_resistance_winding_housing = printed(total * share);
        motor.sheet.thermal_resistance_housing_ambient = printed(total * (1.0 - share));
        motor.sheet.thermal_time_constant_winding = printed(winding);
        motor.sheet.thermal_time_constant_housing = printed(winding * around(3.0, 50.0));
    }
    joint.limits.winding_temperature = Some(within(380.0, 420.0));
    (motor.max_speed, joint.gear.max_input_speed) = (allow("max_speed"), allow("gear_input_speed"));
    (joint.gear.peak_torque, joint.gear.continuous_torque) =
        (allow("gear_peak_torque"), allow("gear_continuous_torque"));
    (joint.limits.reflected_inertia, joint.limits.actuator_mass) = (allow("reflected_inertia"), allow("actuator_mass"));
    let (loss, inertia, power) = (Quantity::CopperLoss, Quantity::ReflectedInertia, Quantity::PeakPower);
    // Energy needs durations.
    let energy = if form < 0.93 { Quantity::Energy } else { loss };
    let alone =
        [loss, loss, Quantity::PeakCurrent, Quantity::PeakCurrent, inertia, Quantity::Mass, energy, energy, power];
    let alone = alone[below(9.0)];
    let drawn = [inertia, power, if form < 0.93 { Quantity::Energy } else { inertia }][below(3.0)];
    let with_loss = [(peaked, Quantity::PeakCurrent), (stepped, Quantity::Mass), (chance(0.25), drawn)];
    let both = |q: Quantity| {
        vec![(loss, 1.0), (q, at.quantities[1] / at.quantities[q as usize].abs().max(1e-3 * at.quantities[1]) / high)]
    };
    joint.objective.terms = with_loss.into_iter().find(|x| x.0).map_or(vec![(alone, 1.0)], |x| both(x.1));
    // How nearly the rotor stands depends on all of it.
    Case::new(case.motor, case.robot, case.raw)
}
