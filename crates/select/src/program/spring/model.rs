//! The equations of one sample as functions of ratio and spring, and as forms on a region.
//!
//! In the direction of motion (d = sgn ω) the shaft supplies `T = h/N + N m + c`, with the load torque
//! `e = τ + k q − s` linear in (k, s) and `h = φ e`. Its square, the power and the voltage are sums of
//! terms that are convex in (u, k, s) but for those with c, and for samples whose direction of power the
//! region leaves open: these are bounded from below. Where there are none, every form is exact.

use super::form::{Affine, Form, Point, at, times};
use super::region::{Geared, Region};
use gearwise_model::actuator::Actuator;
use gearwise_model::actuator::shaft::{Feature, Flow};
use gearwise_model::actuator::supply::Drawn;
use gearwise_model::actuator::waveform::Functional;

/// A sample of the motion with the spring's torque left open.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Load torque e \[N·m\].
    pub(super) torque: Affine,
    /// Its rate \[N·m/s\].
    pub(super) rate: Affine,
    /// Acceleration \[rad/s²\], jerk \[rad/s³\], speed \[rad/s\].
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
    pub(super) velocity: f64,
    /// Sign of the speed; at standstill ±1 in limits, 0 in means.
    pub(super) sign: f64,
    /// Its place in the motion; none of its own where a torque is superposed.
    pub(super) place: usize,
}

/// The shaft torque of a sample in the direction of motion: `h/N + N m + c`.
struct Shaft {
    geared: Geared,
    m: f64,
    c: f64,
}

pub(super) fn direction(sample: &Sample) -> f64 {
    if sample.velocity < 0.0 { -1.0 } else { 1.0 }
}

/// Whether a sample is one of a mean over time, and nothing moves.
fn holds(sample: &Sample) -> bool {
    sample.velocity == 0.0 && sample.sign == 0.0
}

fn shaft(actuator: &Actuator, sample: &Sample, region: &Region) -> Shaft {
    let form = actuator.torque_form(Flow::Driving);
    let load = |flow| actuator.torque_form(flow)[Feature::Load];
    let d = direction(sample);
    let e = times(&sample.torque, d);
    let geared = match holds(sample) {
        true => Geared::Fixed(Flow::Holding, times(&e, load(Flow::Holding))),
        false => Geared::new(region, sample.place, e, sample.velocity != 0.0, load(Flow::Driving), load(Flow::Braking)),
    };
    Shaft {
        geared,
        m: d * (form[Feature::Acceleration] * sample.acceleration + form[Feature::Velocity] * sample.velocity),
        c: d * form[Feature::Sign] * sample.sign,
    }
}

impl Shaft {
    /// Adds a lower bound of `weight T²`, weight not negative.
    fn add_square(&self, form: &mut Form, weight: f64, region: &Region, z: Point) {
        let Shaft { geared, m, c } = self;
        geared.add_square_over_u(form, weight, z);
        form.add_affine(&times(&geared.below(*m, z), 2.0 * weight * m));
        form.add_u(weight * m * m);
        form.add_constant(weight * c * c);
        region.add_product(form, 2.0 * weight * c, &geared.below(*c, z), -1, z);
        region.add_power(form, 2.0 * weight * c * m, 1, z);
    }

    /// Adds a lower bound of `coefficient T`.
    fn add_linear(&self, form: &mut Form, coefficient: f64, region: &Region, z: Point) {
        region.add_product(form, coefficient, &self.geared.below(coefficient, z), -1, z);
        region.add_power(form, coefficient * self.m, 1, z);
        form.add_constant(coefficient * self.c);
    }

    /// Adds a lower bound of `coefficient N T`.
    fn add_times_ratio(&self, form: &mut Form, coefficient: f64, region: &Region, z: Point) {
        form.add_affine(&times(&self.geared.below(coefficient, z), coefficient));
        form.add_u(coefficient * self.m);
        region.add_power(form, coefficient * self.c, 1, z);
    }

    /// Smallest and largest T on the region.
    fn range(&self, region: &Region) -> (f64, f64) {
        let (low, high) = self.geared.range(region);
        let [a, b] = region.ratio;
        let (n_m, n_m_other) = (a * self.m, b * self.m);
        let low = (low / a).min(low / b) + n_m.min(n_m_other) + self.c;
        let high = (high / a).max(high / b) + n_m.max(n_m_other) + self.c;
        let size = 1e-14 * (low.abs() + high.abs());
        (low - size, high + size)
    }
}

/// The torque in the direction of motion of a sample whose direction of power a region leaves open.
pub(super) fn open(actuator: &Actuator, sample: &Sample, region: &Region) -> Option<Affine> {
    match shaft(actuator, sample, region).geared {
        Geared::Open { e, .. } => Some(e),
        Geared::Fixed(..) => None,
    }
}

/// Adds a lower bound of `weight T²`.
pub(super) fn add_torque_squared(
    actuator: &Actuator,
    sample: &Sample,
    form: &mut Form,
    weight: f64,
    region: &Region,
    z: Point,
) {
    shaft(actuator, sample, region).add_square(form, weight, region, z);
}

/// A lower bound of `|T|`.
pub(super) fn torque_magnitude(actuator: &Actuator, sample: &Sample, region: &Region, z: Point) -> Form {
    let mut form = Form::default();
    let towards = direction(sample) * torque_at(actuator, sample, z).signum();
    shaft(actuator, sample, region).add_linear(&mut form, towards, region, z);
    form
}

/// Adds a lower bound of `weight P`, the terminal power with so much copper loss per squared torque.
pub(super) fn add_power(
    (actuator, copper): (&Actuator, f64),
    sample: &Sample,
    form: &mut Form,
    weight: f64,
    region: &Region,
    z: Point,
) {
    let shaft = shaft(actuator, sample, region);
    let emf = actuator.back_emf_constant / actuator.torque_constant * sample.velocity.abs();
    shaft.add_square(form, weight * copper, region, z);
    shaft.add_times_ratio(form, weight * emf, region, z);
}

/// What motor and gear take without load at a point, and what the gear's efficiency takes \[W\].
fn mechanical_loss_at(actuator: &Actuator, sample: &Sample, z: Point) -> f64 {
    let n = z[0].sqrt();
    let (coulomb, viscous) = unloaded(actuator, sample);
    let (factor, load) = through_gear(actuator, sample, z);
    n * coulomb + z[0] * viscous + factor * at(&load, z[1], z[2])
}

/// Power per N and per N² that motor and gear take without load at a sample \[W\].
fn unloaded(actuator: &Actuator, sample: &Sample) -> (f64, f64) {
    let of = |feature| actuator.drag_form()[feature] + actuator.gear_drag_form()[feature];
    let speed = sample.velocity;
    (of(Feature::Sign) * sample.sign * speed, of(Feature::Velocity) * speed * speed)
}

/// What the gear's efficiency takes at a sample: so much times a load torque \[W/(N·m)\]. It is convex in that torque.
fn through_gear(actuator: &Actuator, sample: &Sample, z: Point) -> (f64, Affine) {
    let load = actuator.torque_form(flow_at(sample, z))[Feature::Load];
    ((load - 1.0) * sample.velocity, sample.torque)
}

/// All losses of a sample at a point \[W\], without standby.
pub(super) fn loss_at(actuator: &Actuator, drawn: Drawn, sample: &Sample, torque: f64, z: Point) -> f64 {
    let power = power_at((actuator, actuator.loss_given()), sample, torque, z);
    let (factor, kept) = drawn.line(power);
    actuator.loss_given() * torque * torque + (factor - 1.0) * power + kept + mechanical_loss_at(actuator, sample, z)
}

/// Adds a lower bound of `weight` times all losses of a sample, without standby; it touches them at `z` where the program is
/// convex.
pub(super) fn add_loss(
    actuator: &Actuator,
    drawn: Drawn,
    sample: &Sample,
    form: &mut Form,
    weight: f64,
    region: &Region,
    z: Point,
) {
    let torque = torque_at(actuator, sample, z);
    let (factor, kept) = drawn.line(power_at((actuator, actuator.loss_given()), sample, torque, z));
    form.add_constant(weight * kept);
    let shaft = shaft(actuator, sample, region);
    let emf = actuator.back_emf_constant / actuator.torque_constant * sample.velocity.abs();
    shaft.add_square(form, weight * factor * actuator.loss_given(), region, z);
    if factor != 1.0 {
        shaft.add_times_ratio(form, weight * (factor - 1.0) * emf, region, z);
    }
    let (coulomb, viscous) = unloaded(actuator, sample);
    region.add_power(form, weight * coulomb, 1, z);
    form.add_u(weight * viscous);
    let (per_torque, load) = through_gear(actuator, sample, z);
    form.add_affine(&times(&load, weight * per_torque));
}

/// A functional of a sample as a form that is nowhere above it on the region; `None` where there is none
/// worth having.
pub(super) fn functional(
    what: Functional,
    actuator: &Actuator,
    sample: &Sample,
    region: &Region,
    z: Point,
) -> Option<Form> {
    let mut form = Form::default();
    match what {
        Functional::TorqueSquared | Functional::CurrentSquared => {
            add_torque_squared(actuator, sample, &mut form, 1.0, region, z)
        }
        Functional::Power => add_power((actuator, actuator.loss_taken()), sample, &mut form, 1.0, region, z),
        Functional::PowerBack => {
            let shaft = shaft(actuator, sample, region);
            // −T² lies above the chord over the range of T.
            let (low, high) = shaft.range(region);
            let copper = actuator.loss_returned();
            let emf = actuator.back_emf_constant / actuator.torque_constant * sample.velocity.abs();
            shaft.add_linear(&mut form, -copper * (low + high), region, z);
            form.add_constant(copper * low * high);
            shaft.add_times_ratio(&mut form, -emf, region, z);
        }
        // Of a weakened field, which springs are not chosen with.
        Functional::LeastVoltage(_) => return None,
        Functional::VoltageSquared => {
            let torque = torque_at(actuator, sample, z);
            let [hot, cold] = actuator.windings();
            let at = |winding| voltage_squared_at(winding, sample, torque, z);
            let winding = if at(&cold) > at(&hot) { cold } else { hot };
            return voltage_squared(&winding, sample, region, z);
        }
        Functional::OpenVoltage(supply) => {
            let torque = torque_at(actuator, sample, z);
            let [hot, cold] = actuator.windings().map(|winding| (winding, terminals_at(&winding, sample, torque, z)));
            let needed = |(voltage, power): (f64, f64)| supply.needed(voltage, power);
            let (winding, (voltage, power)) = if needed(cold.1) > needed(hot.1) { cold } else { hot };
            let [of_voltage, of_power, constant] = supply.row(voltage, power);
            add_power((&winding, winding.loss_taken()), sample, &mut form, of_power, region, z);
            if of_voltage > 0.0 {
                form.add(of_voltage, &voltage_squared(&winding, sample, region, z)?);
            }
            form.add_constant(constant);
        }
    }
    Some(form)
}

/// `v_q² + v_d²` where the direction of power is the same everywhere on the region.
fn voltage_squared(actuator: &Actuator, sample: &Sample, region: &Region, z: Point) -> Option<Form> {
    let shaft = shaft(actuator, sample, region);
    let Geared::Fixed(flow, h) = shaft.geared else { return None };
    let mut form = Form::default();
    let q = actuator.voltage_form(flow);
    let d = direction(sample);
    let b: Affine =
        std::array::from_fn(|i| d * (q[Feature::Load] * sample.torque[i] + q[Feature::LoadRate] * sample.rate[i]));
    let a = d
        * (q[Feature::Acceleration] * sample.acceleration
            + q[Feature::Jerk] * sample.jerk
            + q[Feature::Velocity] * sample.velocity);
    let quadrature = Shaft { geared: Geared::Fixed(flow, b), m: a, c: d * q[Feature::Sign] * sample.sign };
    quadrature.add_square(&mut form, 1.0, region, z);
    // v_d = κ (h + u m + N c).
    let kappa = actuator.cross_coupling * sample.velocity;
    let Shaft { m, c, .. } = shaft;
    let squared = kappa * kappa;
    form.add_square(squared, &[h[0], h[1], h[2], m]);
    form.add_u(squared * c * c);
    region.add_product(&mut form, 2.0 * squared * c, &h, 1, z);
    region.add_power(&mut form, 2.0 * squared * c * m, 3, z);
    Some(form)
}

/// The flow of a sample at a point.
fn flow_at(sample: &Sample, z: Point) -> Flow {
    if holds(sample) {
        return Flow::Holding;
    }
    Flow::of(at(&sample.torque, z[1], z[2]), sample.velocity)
}

/// Shaft torque at a point \[N·m\].
pub(super) fn torque_at(actuator: &Actuator, sample: &Sample, z: Point) -> f64 {
    let form = actuator.torque_form(flow_at(sample, z));
    let n = z[0].sqrt();
    form[Feature::Load] * at(&sample.torque, z[1], z[2]) / n
        + n * (form[Feature::Acceleration] * sample.acceleration + form[Feature::Velocity] * sample.velocity)
        + form[Feature::Sign] * sample.sign
}

/// Terminal power at a point \[W\], with so much copper loss per squared torque.
pub(super) fn power_at((actuator, copper): (&Actuator, f64), sample: &Sample, torque: f64, z: Point) -> f64 {
    let emf = actuator.back_emf_constant / actuator.torque_constant;
    copper * torque * torque + emf * z[0].sqrt() * sample.velocity * torque
}

/// `v_q² + v_d²` \[V²\] and power taken \[W\] at a point.
pub(super) fn terminals_at(actuator: &Actuator, sample: &Sample, torque: f64, z: Point) -> (f64, f64) {
    let without = actuator.shortfall.without_saturation(torque.abs()).0;
    let saturated = actuator.loss_taken() * (without * without - torque * torque);
    let power = power_at((actuator, actuator.loss_taken()), sample, torque, z) + saturated;
    (voltage_squared_at(actuator, sample, torque, z), power)
}

/// `v_q² + v_d²` at a point \[V²\].
pub(super) fn voltage_squared_at(actuator: &Actuator, sample: &Sample, torque: f64, z: Point) -> f64 {
    let q = actuator.voltage_form(flow_at(sample, z));
    let n = z[0].sqrt();
    let b = q[Feature::Load] * at(&sample.torque, z[1], z[2]) + q[Feature::LoadRate] * at(&sample.rate, z[1], z[2]);
    let a = q[Feature::Acceleration] * sample.acceleration
        + q[Feature::Jerk] * sample.jerk
        + q[Feature::Velocity] * sample.velocity;
    let plain = b / n + n * a + q[Feature::Sign] * sample.sign;
    let drop =
        actuator.resistance_per_torque() * (actuator.shortfall.without_saturation(torque.abs()).0 - torque.abs());
    let with = plain + drop.copysign(torque);
    let quadrature = if with.abs() > plain.abs() { with } else { plain };
    let direct = actuator.cross_coupling * sample.velocity * n * torque;
    quadrature * quadrature + direct * direct
}
