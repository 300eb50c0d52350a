//! What the motor shaft must supply, and what that takes electrically: the equations of one sample.
//!
//! Torque and quadrature voltage are *linear* in a few features of a sample, each with its own power
//! of the ratio N:
//!
//! ```text
//! T   = φ τ/N + N (J α + b ω) + c sgn ω            J = J_m + J_g
//! Ṫ   = φ τ̇/N + N (J j + b α)                      jumps of φ and of c sgn ω are not differentiated
//! i   = T/K_T
//! v_q = R i + L di/dt + K_B N ω
//! v_d = −p N ω L i
//! P   = R i² + K_B N ω i                           without d(½ L i²)/dt, which is zero over a cycle
//! ```
//!
//! R in the power that is taken is that of the hottest winding that may be, in the power that comes back that of a winding at ambient
//! temperature, and in heat, loss and energy that of the reference temperature. The voltage is computed with both the hottest winding and
//! one at ambient temperature: |v|² is convex in R, so that the larger of the two bounds every temperature between them. While the motor
//! brakes the cold winding needs more.
//!
//! The coefficients are made here, once; the sweep weighs features with them at a ratio, the ratio
//! program takes the same coefficients as Laurent polynomials.

pub use crate::effects::features::{FEATURE_POWER, FEATURES, Feature, ShaftForm, USUAL_FEATURES, sign};

use super::fitted::{self, Shortfall};
use super::thermal;
use crate::catalog::Motor;
use crate::catalog::drag::Friction;
use crate::numerics::laurent::Laurent;
use crate::requirement::GearModel;

/// Which way power flows through the gear at a sample: does not depend on N.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// The motor drives the load (or holds it): `φ = 1/η`.
    Driving = 0,
    /// The load drives the motor: `φ = η_b`.
    Braking = 1,
    /// Nothing moves, in means: `φ = 1`. The gear's friction may hold for the motor or against it.
    Holding = 2,
}

/// How many ways power may flow.
pub(crate) const FLOWS: usize = 3;

impl Flow {
    /// Those of what moves.
    pub const MOVING: [Flow; 2] = [Flow::Driving, Flow::Braking];

    /// All.
    pub const ALL: [Flow; FLOWS] = [Flow::Driving, Flow::Braking, Flow::Holding];

    /// Of a load torque \[N·m\] and a speed \[rad/s\] as it counts in means over time.
    pub fn in_means(torque: f64, velocity: f64) -> Flow {
        if velocity == 0.0 { Flow::Holding } else { Flow::of(torque, velocity) }
    }

    /// Of a load torque \[N·m\] and a speed \[rad/s\] as it counts in limits at an instant: at standstill the motor
    /// drives.
    pub fn of(torque: f64, velocity: f64) -> Flow {
        if torque * velocity < 0.0 { Flow::Braking } else { Flow::Driving }
    }
}

/// An end of what is known of a motor's drag.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum End {
    /// All of it Coulomb friction; the only one where it is known.
    #[default]
    First,
    /// All of it viscous friction, or none of it where it is estimated.
    Other,
}

/// A motor with a gear: all coefficients that the equations of a sample need, SI, q axis.
#[derive(Debug, Clone, Copy)]
pub struct Actuator {
    /// Winding resistance at the reference temperature \[Ω\].
    pub resistance: f64,
    /// Winding resistance that voltage and power taken are computed with \[Ω\]: that at the reference temperature until
    /// [`Actuator::with_winding_at`].
    pub hot_resistance: f64,
    /// Winding resistance at ambient temperature \[Ω\], which voltage and power returned are computed with as well: that at the reference
    /// temperature until [`Actuator::with_coldest_winding`].
    pub cold_resistance: f64,
    /// Torque constant of the cold motor \[N·m/A\].
    cold_torque_constant: f64,
    /// Torque constant \[N·m/A\].
    pub torque_constant: f64,
    /// Back-EMF constant \[V·s/rad\].
    pub back_emf_constant: f64,
    /// Inertia at the motor shaft \[kg·m²\], J_m + J_g.
    pub inertia: f64,
    /// `p L / K_T` \[V·s²/(rad·N·m)\]: d-axis voltage per torque and output speed; zero where unknown.
    pub cross_coupling: f64,
    /// What fitted effects take of currents and voltages.
    pub shortfall: Shortfall,
    /// Torque of the motor's own drag at its shaft: what of the torque is neither load nor inertia.
    drag: ShaftForm,
    /// The same of the gear at its input.
    gear_drag: ShaftForm,
    /// Resistance of drive and leads per phase \[Ω\].
    drive_resistance: f64,
    /// Inductance over torque constant \[H·A/(N·m)\]; zero where unknown.
    rate: f64,
    torque: [ShaftForm; FLOWS],
    voltage: [ShaftForm; FLOWS],
}

impl Actuator {
    /// The actuator of a motor and a gear, with the effects that the motor's row declares. An
    /// unknown inductance is left out altogether; unknown pole pairs leave out what it couples across.
    pub fn new(motor: &Motor, rotor_inertia: f64, gear: &GearModel) -> Actuator {
        Actuator::at_temperature(motor, rotor_inertia, gear, motor.max_winding_temperature, true)
    }

    /// As [`Actuator::new`] where the magnets may be as hot as `hottest` \[K\]; `fitted_gear` says whether the
    /// gear is the one that the motor was fitted with.
    pub fn at_temperature(
        motor: &Motor,
        rotor_inertia: f64,
        gear: &GearModel,
        hottest: Option<f64>,
        fitted_gear: bool,
    ) -> Actuator {
        let torque_constant = fitted::hot_torque_constant(motor, hottest);
        let inertia = rotor_inertia + gear.inertia;
        let inductance = motor.inductance.unwrap_or(0.0);
        let pole_pairs = motor.pole_pairs.map_or(0.0, f64::from);
        let form = |load: f64| {
            let mut torque = ShaftForm::default();
            torque[Feature::Load] = load;
            torque[Feature::Acceleration] = inertia;
            fitted::add_features(motor, &mut torque);
            let current = 1.0 / torque_constant;
            let mut voltage = ShaftForm::default()
                .plus(motor.resistance * current, &torque)
                .plus(inductance * current, &torque.rate());
            voltage[Feature::Velocity] += motor.emf_constant();
            (torque, voltage)
        };
        let forms = [1.0 / gear.efficiency, gear.backdrive_efficiency, 1.0].map(form);
        let mut drag = ShaftForm::default();
        fitted::add_features(motor, &mut drag);
        Actuator {
            resistance: motor.resistance,
            hot_resistance: motor.resistance,
            cold_resistance: motor.resistance,
            cold_torque_constant: motor.torque_constant,
            torque_constant,
            back_emf_constant: motor.emf_constant(),
            inertia,
            cross_coupling: pole_pairs * inductance / torque_constant,
            shortfall: Shortfall::new(motor, torque_constant, fitted_gear),
            drag,
            gear_drag: ShaftForm::default(),
            drive_resistance: 0.0,
            rate: inductance / torque_constant,
            torque: forms.map(|form| form.0),
            voltage: forms.map(|form| form.1),
        }
    }

    /// The same with the resistance in voltage and power taken that of a winding at a temperature \[K\], for a
    /// resistance at `reference` \[K\].
    #[must_use]
    pub fn with_winding_at(mut self, temperature: f64, reference: f64) -> Actuator {
        let hot = self.resistance * thermal::resistance_factor(temperature, reference);
        let more = (hot - self.hot_resistance) / self.torque_constant;
        for (voltage, torque) in self.voltage.iter_mut().zip(&self.torque) {
            *voltage = voltage.plus(more, torque);
        }
        self.hot_resistance = hot;
        self
    }

    /// Set the resistance of the coldest winding \[Ω\], at most that of the hottest; until then it is that at the reference temperature.
    #[must_use]
    pub fn with_coldest_winding(mut self, resistance: f64) -> Actuator {
        self.cold_resistance = resistance.min(self.hot_resistance);
        self
    }

    /// Split into an actuator with the hottest winding and one with the coldest: its resistance gives the cold motor's R/K_T at the torque
    /// constant of the hottest.
    pub fn windings(&self) -> [Actuator; 2] {
        let [mut hot, mut cold] = [*self; 2];
        (hot.cold_resistance, hot.cold_torque_constant) = (self.hot_resistance, self.torque_constant);
        let cooler = self.cooler();
        for (voltage, torque) in cold.voltage.iter_mut().zip(&self.torque) {
            *voltage = voltage.plus(-cooler, torque);
        }
        cold.hot_resistance -= cooler * self.torque_constant;
        (cold.cold_resistance, cold.cold_torque_constant) = (cold.hot_resistance, self.torque_constant);
        [hot, cold]
    }

    /// Difference of the resistive voltage per shaft torque between hottest and coldest winding \[V/(N·m)\]: leads and drive do not change,
    /// and cold magnets need less current.
    pub fn cooler(&self) -> f64 {
        self.resistance_per_torque() - self.cold_resistance_per_torque()
    }

    /// Resistance of the coldest winding, drive and leads over the torque constant of the cold motor \[V/(N·m)\].
    pub fn cold_resistance_per_torque(&self) -> f64 {
        (self.cold_resistance + self.drive_resistance) / self.cold_torque_constant
    }

    /// The same with more friction of the motor at its shaft.
    #[must_use]
    pub fn with_friction(mut self, friction: Friction) -> Actuator {
        let own = friction_form(friction);
        self.add_torque(&own);
        self.drag = self.drag.plus(1.0, &own);
        self
    }

    /// The same with friction of the gear at its input.
    #[must_use]
    pub fn with_gear_friction(mut self, friction: Friction) -> Actuator {
        let own = friction_form(friction);
        self.add_torque(&own);
        self.gear_drag = self.gear_drag.plus(1.0, &own);
        self
    }

    /// The same with a resistance of drive and leads per phase \[Ω\]: it counts for voltage and power, not for the
    /// winding's heat.
    #[must_use]
    pub fn with_drive_resistance(mut self, resistance: f64) -> Actuator {
        let more = resistance / self.torque_constant;
        for (voltage, torque) in self.voltage.iter_mut().zip(&self.torque) {
            *voltage = voltage.plus(more, torque);
        }
        self.drive_resistance += resistance;
        self
    }

    /// The same for samples whose features `Speed` and `SpeedRate` are a load torque, and its rate, that comes with N in place
    /// of 1/N: see [`Load::on_piece`](super::Load::on_piece).
    #[must_use]
    pub(crate) fn with_rising_load(mut self) -> Actuator {
        self.add_torque(&ShaftForm::of(Feature::Speed, 1.0));
        self
    }

    fn add_torque(&mut self, own: &ShaftForm) {
        let per_torque = (self.hot_resistance + self.drive_resistance) / self.torque_constant;
        for (torque, voltage) in self.torque.iter_mut().zip(&mut self.voltage) {
            *torque = torque.plus(1.0, own);
            *voltage = voltage.plus(per_torque, own).plus(self.rate, &own.rate());
        }
    }

    /// Torque of the motor's own drag as a linear form.
    pub fn drag_form(&self) -> &ShaftForm {
        &self.drag
    }

    /// Torque of the gear without load, at its input, as a linear form.
    pub fn gear_drag_form(&self) -> &ShaftForm {
        &self.gear_drag
    }

    /// Torque at the motor shaft as a linear form.
    pub fn torque_form(&self, flow: Flow) -> &ShaftForm {
        &self.torque[flow as usize]
    }

    /// Quadrature voltage as a linear form.
    pub fn voltage_form(&self, flow: Flow) -> &ShaftForm {
        &self.voltage[flow as usize]
    }

    /// Coulomb friction at the shaft \[N·m\]: what makes odd powers of N.
    pub fn has_odd_powers(&self) -> bool {
        self.torque[0][Feature::Sign] != 0.0 || self.torque[0][Feature::One] != 0.0
    }

    /// `T²` of a sample \[N²·m²\].
    pub fn torque_squared(&self, flow: Flow, features: &[f64; FEATURES]) -> Laurent {
        self.torque_form(flow).polynomial(features).squared()
    }

    /// `v_q² + v_d²` of a sample \[V²\].
    pub fn voltage_squared(&self, flow: Flow, features: &[f64; FEATURES]) -> Laurent {
        let direct = Laurent::monomial(self.cross_coupling * features[Feature::Velocity as usize], 1);
        let direct = direct * self.torque_form(flow).polynomial(features);
        self.voltage_form(flow).polynomial(features).squared() + direct.squared()
    }

    /// Power of a sample at the drive's output stage \[W\], with so much resistive loss per squared torque
    /// \[W/(N·m)²\]: [`Actuator::loss_taken`] for what is taken.
    pub fn power(&self, copper: f64, flow: Flow, features: &[f64; FEATURES]) -> Laurent {
        let torque = self.torque_form(flow).polynomial(features);
        let speed = Laurent::monomial(features[Feature::Velocity as usize], 1);
        torque.squared() * copper + speed * torque * (self.back_emf_constant / self.torque_constant)
    }

    /// [`Self::voltage_squared`] with the true current in the ohmic drop where the iron saturates: a polynomial that touches it at a ratio
    /// and is nowhere above it. Inductive voltages are those of `T/K_T`, because the flux saturates with the torque. Where the drop
    /// opposes the other voltages, the larger of the values with and without saturation counts.
    pub fn voltage_squared_near(&self, flow: Flow, features: &[f64; FEATURES], ratio: f64) -> Laurent {
        let plain = self.voltage_squared(flow, features);
        if !self.shortfall.saturates() {
            return plain;
        }
        let (torque, quadrature) =
            (self.torque_form(flow).polynomial(features), self.voltage_form(flow).polynomial(features));
        let here = torque.at(ratio);
        let (without, slope) = self.shortfall.without_saturation(here.abs());
        let (along, sign) = (self.resistance_per_torque(), here.signum());
        let voltage = sign * quadrature.at(ratio);
        // (x + e)² ≥ 2 f (x + e) − f², and e(|T|) is above its tangent.
        let f = voltage + along * (without - here.abs());
        if f <= voltage.abs() {
            return plain;
        }
        let more = torque * (sign * along * (slope - 1.0)) + Laurent::constant(along * (without - slope * here.abs()));
        let direct = plain + quadrature.squared() * -1.0;
        (quadrature * sign + more) * (2.0 * f) + Laurent::constant(-f * f) + direct
    }

    /// [`Self::power`] with the true current in the loss where the iron saturates: a polynomial that touches it at a ratio and is nowhere
    /// above it.
    pub fn power_near(&self, copper: f64, flow: Flow, features: &[f64; FEATURES], ratio: f64) -> Laurent {
        let plain = self.power(copper, flow, features);
        if !self.shortfall.saturates() {
            return plain;
        }
        let torque = self.torque_form(flow).polynomial(features);
        let here = torque.at(ratio).abs();
        let (without, slope) = self.shortfall.without_saturation(here);
        // d(K_T i)²/d(T²), which is 1 where both vanish.
        let per_square = if here > 0.0 { without * slope / here } else { 1.0 };
        let constant = without * without - per_square * here * here;
        plain + torque.squared() * (copper * (per_square - 1.0)) + Laurent::constant(copper * constant)
    }

    /// `T` of a sample as coefficients of N⁻¹, 1 and N \[N·m\].
    #[inline]
    pub fn torque_terms(&self, flow: Flow, features: &[f64; FEATURES]) -> [f64; 3] {
        self.torque[flow as usize].terms(features)
    }

    /// Whether any feature beyond the usual ones counts.
    pub fn has_unusual_features(&self) -> bool {
        let unusual = |form: &ShaftForm| form.0[USUAL_FEATURES..].iter().any(|c| *c != 0.0);
        self.torque.iter().chain(&self.voltage).any(unusual)
    }

    /// The same for samples into which constant, asymmetry and drag were folded at one ratio: their torque is
    /// the feature `One`, their rate `SpeedRate`.
    pub fn folded(&self) -> Actuator {
        let mut actuator = *self;
        for flow in 0..FLOWS {
            for (form, per_torque, per_rate) in [
                (&mut actuator.torque[flow], 1.0, 0.0),
                (
                    &mut actuator.voltage[flow],
                    (self.hot_resistance + self.drive_resistance) / self.torque_constant,
                    self.rate,
                ),
            ] {
                form[Feature::Speed] = 0.0;
                form[Feature::One] = per_torque;
                form[Feature::SpeedRate] = per_rate;
            }
        }
        (actuator.drag[Feature::Speed], actuator.drag[Feature::One]) = (0.0, 1.0);
        actuator
    }

    /// Actuator whose iron does not saturate. Its current and the power it draws are lower bounds at any torque.
    #[must_use]
    pub fn unsaturated(&self) -> Actuator {
        Actuator { shortfall: self.shortfall.unsaturated(), ..*self }
    }

    /// Copper loss per squared torque in the mean \[W/(N·m)²\]: with what ripple in proportion to current adds.
    pub fn heating(&self) -> f64 {
        self.copper() * self.shortfall.heat_factor()
    }

    /// Root mean square current per root mean square torque \[A/(N·m)\].
    pub fn rms_current_per_torque(&self) -> f64 {
        self.shortfall.heat_factor().sqrt() / self.torque_constant
    }

    /// Copper heat of a squared torque \[W\] and its derivative: a straight line unless the iron saturates.
    pub fn heat(&self, torque_squared: f64) -> (f64, f64) {
        if !self.shortfall.saturates() {
            return ((torque_squared + self.shortfall.mean_square()) * self.heating(), self.heating());
        }
        let (squared, slope) = self.shortfall.current_squared(torque_squared);
        (self.resistance * squared, self.resistance * slope)
    }

    /// Loss in drive and leads per squared torque in the mean \[W/(N·m)²\].
    pub fn conduction(&self) -> f64 {
        self.per_square(self.drive_resistance) * self.shortfall.heat_factor()
    }

    /// Inductance over the torque constant \[H·A/(N·m)\]; zero where unknown.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Resistance of the hottest winding, drive and leads over the torque constant \[V/(N·m)\].
    pub fn resistance_per_torque(&self) -> f64 {
        (self.hot_resistance + self.drive_resistance) / self.torque_constant
    }

    /// Loss in copper, drive and leads per squared torque \[W/(N·m)²\] of power that is taken: with the hottest winding.
    pub fn loss_taken(&self) -> f64 {
        self.per_square(self.hot_resistance + self.drive_resistance)
    }

    /// Loss per squared torque at the reference temperature, for mean losses \[W/(N·m)²\].
    pub fn loss_given(&self) -> f64 {
        self.per_square(self.resistance + self.drive_resistance)
    }

    /// Loss per squared torque of the coldest winding, for the largest regenerative power \[W/(N·m)²\].
    pub fn loss_returned(&self) -> f64 {
        self.cold_resistance_per_torque() / self.torque_constant
    }

    /// What of a loss in copper a loss with drive and leads is.
    pub fn with_leads(&self) -> f64 {
        1.0 + self.drive_resistance / self.resistance
    }

    fn per_square(&self, resistance: f64) -> f64 {
        resistance / (self.torque_constant * self.torque_constant)
    }

    /// Copper loss per squared torque of the hottest winding \[W/(N·m)²\].
    pub fn hot_copper(&self) -> f64 {
        self.hot_resistance / (self.torque_constant * self.torque_constant)
    }

    /// Copper loss per squared torque at the reference temperature \[W/(N·m)²\], `R/K_T²`.
    pub fn copper(&self) -> f64 {
        self.resistance / (self.torque_constant * self.torque_constant)
    }
}

fn friction_form(friction: Friction) -> ShaftForm {
    let mut form = ShaftForm::default();
    form[Feature::Sign] = friction.coulomb;
    form[Feature::Velocity] = friction.viscous;
    form
}
