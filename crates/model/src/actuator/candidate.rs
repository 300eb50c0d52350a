//! A motor and a gear for a joint, and what they can give.

use super::estimate::ASSUMED_WINDING_TEMPERATURE;
use super::fitted;
use super::load::Load;
use super::shaft::{Actuator, End, Feature};
use super::supply::{Drawn, Supply};
use super::thermal::{self, LEAST_TIME_CONSTANT};
use super::thermal_motion::TwoNode;
use super::weakening::{AlongD, Weakening};
use crate::catalog::convention::{Commutation, CurrentConvention};
use crate::catalog::drag::Drag;
use crate::catalog::estimate::Estimated;
use crate::catalog::module::Drive;
use crate::catalog::{Gear, Motor};
use crate::numerics::laurent::Laurent;
use crate::requirement::{GearMap, GearModel, GearPiece, Joint, MotorDrag, Robot, Turns};

/// Fewest pole pairs of a brushless motor in the catalogue.
const FEWEST_POLE_PAIRS: u32 = 2;

/// A motor and a gear for a joint, before the ratio is chosen.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'a> {
    /// The robot, for bus and surroundings.
    pub robot: &'a Robot,
    /// The joint.
    pub joint: &'a Joint,
    /// The joint's demand, made ready.
    pub load: &'a Load,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear of the catalogue, where the ratio is not continuous.
    pub catalog_gear: Option<&'a Gear>,
    /// The gear's numbers.
    pub gear: GearModel,
    /// The equations of motor and gear together: with the motor's drag at one end of what is known of it.
    pub actuator: Actuator,
    /// The same at the other end, where only a range is known.
    pub other: Option<Actuator>,
    /// What of a family of gears it has, where the gear is one of a family.
    pub map: Option<MapPart<'a>>,
    /// Whether load and actuator are those of one ratio, with the evaluated effects in them.
    pub folded: bool,
    /// The load without slow samples at standstill, where the ratio decides to what degree they are; then `load` has them as the
    /// smallest ratio does, to the largest degree.
    pub by_ratio: Option<&'a Load>,
}

/// What of a family of gears a candidate has.
#[derive(Debug, Clone, Copy)]
pub enum MapPart<'a> {
    /// All of it: at each ratio the gear is another, and is looked at there.
    Whole(&'a GearMap),
    /// What lies between two rows: the load has what goes with the ratio in it.
    Piece(&'a GearPiece),
}

impl<'a> Candidate<'a> {
    /// The family of gears, of which one is known at each ratio.
    pub fn whole_map(&self) -> Option<&'a GearMap> {
        match self.map {
            Some(MapPart::Whole(map)) => Some(map),
            _ => None,
        }
    }

    /// The piece of a family of gears that it is made for.
    pub fn piece(&self) -> Option<&'a GearPiece> {
        match self.map {
            Some(MapPart::Piece(piece)) => Some(piece),
            _ => None,
        }
    }

    /// By how much the mass rises with N² \[kg\]: within a piece of a family of gears.
    pub fn mass_slope(&self) -> f64 {
        self.piece().and_then(|piece| piece.mass()).map_or(0.0, |mass| mass.per_power)
    }

    /// Inertia at the output that no ratio changes \[kg·m²\]: within a piece of a family of gears.
    pub fn inertia_at_output(&self) -> f64 {
        self.piece().map_or(0.0, |piece| piece.inertia(&self.gear).per_power)
    }

    /// The equations at each end of what is known of the motor's drag: one, or two.
    pub fn ends(&self) -> impl Iterator<Item = &Actuator> {
        std::iter::once(&self.actuator).chain(&self.other)
    }

    /// Whether its gear is one that somebody published, and not one that the requirement describes: what is not said of it is not
    /// known.
    pub fn gear_is_published(&self) -> bool {
        self.catalog_gear.is_some() || self.joint.family_map().is_some()
    }

    /// Coulomb friction or a constant torque: what makes odd powers of N.
    pub fn has_odd_powers(&self) -> bool {
        self.ends().any(Actuator::has_odd_powers)
    }

    /// The equations at an end.
    pub fn end(&self, end: End) -> &Actuator {
        match (end, &self.other) {
            (End::Other, Some(other)) => other,
            _ => &self.actuator,
        }
    }

    /// The candidate with what one of two actuators does; itself where there is one.
    pub(crate) fn of_actuator(&self, which: Option<usize>) -> Candidate<'a> {
        let by_ratio = self.by_ratio.map(|load| load.of_actuator(which));
        Candidate { load: self.load.of_actuator(which), by_ratio, ..*self }
    }

    /// Twice the electrical angle per angle of the output at a ratio of one, 2 p, and the winding's time constant \[s\]; `None` of a
    /// brushed motor. Where either is not known, the value for which the most stands: the fewest pole pairs and the shortest time
    /// constant of the catalogue.
    fn field(&self) -> Option<(f64, f64)> {
        let motor = self.motor;
        let tau = motor.sheet.thermal_time_constant_winding.map_or(LEAST_TIME_CONSTANT, |tau| tau.value);
        let pairs = motor.pole_pairs.filter(|pairs| *pairs > 0).unwrap_or(FEWEST_POLE_PAIRS);
        (motor.conventions.commutation == Commutation::Brushless).then_some((2.0 * f64::from(pairs), tau))
    }

    /// The candidate with slow samples at standstill to the degree that the ratios of a range make them.
    #[must_use]
    pub fn standing_between(self, range: Option<(f64, f64)>) -> Candidate<'a> {
        let Some((kappa, tau)) = self.field() else { return self };
        let (min, max) = range.unwrap_or((0.0, f64::INFINITY));
        let [most, least] = [min, max].map(|ratio| self.load.standing(kappa * ratio.abs(), tau));
        let by_ratio = (!std::ptr::eq(most, least)).then_some(self.load);
        Candidate { load: most, by_ratio, ..self }
    }

    /// The candidate with slow samples at standstill as a ratio makes them.
    #[must_use]
    pub fn standing_at(&self, ratio: f64) -> Candidate<'a> {
        let Some((load, (kappa, tau))) = self.by_ratio.zip(self.field()) else { return *self };
        Candidate { load: load.standing(kappa * ratio.abs(), tau), by_ratio: None, ..*self }
    }

    /// The ratios between two at which the degree changes to which slow samples are at standstill, in rising order.
    pub fn standing_changes(&self, (min, max): (f64, f64)) -> Vec<f64> {
        let Some((load, (kappa, tau))) = self.by_ratio.zip(self.field()) else { return Vec::new() };
        load.changes_between((kappa * min, kappa * max), tau).into_iter().map(|at| at / kappa).collect()
    }

    /// The candidate as each of its actuators is: once, or for both of two.
    pub fn each_actuator(&self) -> impl Iterator<Item = Candidate<'a>> + use<'a> {
        let (this, count) = (*self, self.load.actuators().len());
        (0..count.max(1)).map(move |k| this.of_actuator((count > 0).then_some(k)))
    }

    /// Which sample of the joint's motion is the first of an actuator.
    pub(crate) fn first_sample(&self, of: Option<usize>) -> usize {
        let cases = self.joint.motion.cases.as_deref();
        of.and_then(|k| Some(cases?.list.get(k)?.samples.start)).unwrap_or(0)
    }

    /// The candidate with the drag at its other end alone, where there is one.
    pub fn at_other_end(&self) -> Option<Candidate<'a>> {
        self.other.map(|actuator| Candidate { actuator, other: None, ..*self })
    }

    /// Whether the requirement leaves out what is known of the motor's drag beyond its declared friction.
    pub fn drag_is_off(&self) -> bool {
        self.joint.motor_drag == MotorDrag::Off && self.motor.drag() != Drag::Declared
    }

    /// Whether nothing is known of the motor's drag.
    pub fn drag_is_unknown(&self) -> bool {
        self.motor.drag() == Drag::Unknown
    }

    /// What of the motor's drag has to be overcome at rest \[N·m\]: Coulomb friction, and what falls with speed. Cogging is left
    /// out.
    pub fn friction_at_rest(&self) -> f64 {
        self.actuator.drag_form()[Feature::Sign].abs() + fitted::drag(self.motor, 0.0, 1.0).0.abs()
    }

    /// What the drive takes whatever the motor does \[W\].
    pub fn standby_power(&self) -> f64 {
        self.joint.drive.or(self.robot.bus.drive).standby_power.unwrap_or(0.0)
    }
}

impl Candidate<'_> {
    /// Mass of motor, gear and transmission at a ratio \[kg\]; `None` where motor or gear is unknown.
    pub fn mass_at(&self, ratio: f64) -> Option<f64> {
        let fixed = self.motor.mass? + self.gear.mass_at(ratio)? + self.transmission_mass();
        Some(fixed + self.mass_slope() * ratio * ratio)
    }

    /// Smallest and largest mass over a range of ratios \[kg\]; `None` where motor or gear is unknown.
    pub fn mass_between(&self, (min, max): (f64, f64)) -> Option<(f64, f64)> {
        let pieces = self.whole_map().map_or(&[][..], GearMap::pieces);
        let of_map = pieces.iter().filter(|piece| piece.from() <= max && min <= piece.to()).flat_map(|piece| {
            [min.max(piece.from()), max.min(piece.to())].map(|n| piece.gear(&self.gear, n).mass_at(n))
        });
        let masses: Vec<Option<f64>> = match pieces.is_empty() {
            true => [min, max].map(|n| Some(self.gear.mass_at(n)? + self.mass_slope() * n * n)).to_vec(),
            false => of_map.collect(),
        };
        let masses: Vec<f64> = masses.into_iter().collect::<Option<_>>()?;
        let fixed = self.motor.mass? + self.transmission_mass();
        let least = masses.iter().copied().reduce(f64::min)?;
        Some((fixed + least, fixed + masses.into_iter().fold(least, f64::max)))
    }

    /// What the requirement says that the transmission weighs \[kg\].
    fn transmission_mass(&self) -> f64 {
        self.joint.passed.as_ref().and_then(|passed| passed.mass_of_each()).unwrap_or(0.0)
    }

    /// The inertia of the actuator that the joint feels, over the ratio \[kg·m²\]: N² (J_m + J_g), and behind a transmission
    /// r² (N² (J_m + J_g) + J_t) + J_j at the largest r of the motion.
    pub fn reflected_inertia(&self) -> Laurent {
        let own = Laurent::monomial(self.actuator.inertia, 2) + Laurent::constant(self.inertia_at_output());
        match self.joint.passed.as_deref() {
            None => own,
            Some(passed) => {
                let constant = passed.inertia_at_joint(0.0);
                own * (passed.inertia_at_joint(1.0) - constant) + Laurent::constant(constant)
            }
        }
    }

    /// What is known of that mass \[kg\]: the actuator weighs at least this.
    pub fn known_mass_at(&self, ratio: f64) -> f64 {
        let gear = self.gear.mass_at(ratio).unwrap_or(0.0) + self.mass_slope() * ratio * ratio;
        self.motor.mass.unwrap_or(0.0) + gear + self.transmission_mass()
    }

    /// The smaller of the motor's and the drive's largest current, q axis \[A\], and whose it is. Where the winding is open,
    /// the drive's is no limit.
    pub fn peak_current(&self) -> Option<(f64, &'static str)> {
        let drive = self.drive_current().zip(self.joint.turns.of_current()).map(|(i, times)| (i * times, "drive"));
        let motor = self.motor.peak_current.map(|i| (i, "motor"));
        match (motor, drive) {
            (Some(m), Some(d)) => Some(if d.0 < m.0 { d } else { m }),
            (m, d) => m.or(d),
        }
    }

    /// Whether its drive is inside a module: what the requirement says of drives is not said of that.
    pub fn has_drive_inside(&self) -> bool {
        self.motor.inside.as_deref().is_some_and(|inside| inside.module.drive == Drive::BuiltIn)
    }

    /// The drive's largest current, q axis \[A\].
    pub fn drive_current(&self) -> Option<f64> {
        if self.has_drive_inside() {
            return None;
        }
        self.joint.drive_current.or(self.robot.bus.drive_current).map(|i| i * self.current_per_amplitude())
    }

    /// The current that the drive gives for ever, q axis \[A\].
    pub fn drive_continuous_current(&self) -> Option<f64> {
        if self.has_drive_inside() {
            return None;
        }
        let amplitude = self.joint.drive.or(self.robot.bus.drive).continuous_current;
        amplitude.map(|i| i * self.current_per_amplitude())
    }

    /// q-axis current per amplitude of a phase; of a brushed motor DC ampere.
    fn current_per_amplitude(&self) -> f64 {
        let amplitude = match self.motor.conventions.commutation {
            Commutation::Brushless => CurrentConvention::PhaseAmplitude,
            Commutation::Brushed => CurrentConvention::Dc,
        };
        amplitude.torque_current(self.motor.conventions.commutation)
    }

    /// Resistance from the supply's own source to the drive \[Ω\].
    pub fn supply_resistance(&self) -> f64 {
        let leads = self.joint.drive.supply_lead_resistance.unwrap_or(0.0);
        self.robot.bus.internal_resistance.unwrap_or(0.0) + leads
    }

    /// The supply where it sags, with so much of its voltage in reserve.
    pub fn supply(&self, reserve: f64) -> Option<Supply> {
        let bus = &self.robot.bus;
        let circle = bus.modulation.voltage(self.motor.conventions.commutation) * bus.modulation_limit;
        let shortfall = (circle, self.actuator.shortfall.voltage);
        let resistance = self.supply_resistance();
        (resistance > 0.0).then(|| Supply::new(bus, resistance, shortfall, self.standby_power(), reserve))
    }

    /// Voltage between two phases per speed of the motor \[V·s/rad\], of a brushed motor between its terminals.
    pub fn open_circuit_per_speed(&self) -> f64 {
        match self.motor.conventions.commutation {
            Commutation::Brushless => std::f64::consts::SQRT_2 * self.motor.emf_constant(),
            Commutation::Brushed => self.motor.emf_constant(),
        }
    }

    /// Voltage that the drive can apply, radius of the q-axis circle \[V\].
    pub fn voltage(&self) -> f64 {
        let bus = &self.robot.bus;
        let circle = bus.voltage * bus.modulation.voltage(self.motor.conventions.commutation) * bus.modulation_limit;
        (circle - self.actuator.shortfall.voltage).max(0.0)
    }

    /// The square of what a limit on the voltage leaves of it, by its name \[V²\].
    pub fn voltage_squared(&self, limit: &str) -> f64 {
        (self.voltage() * self.joint.limits.left_of(limit)).powi(2)
    }

    /// Whether some effect of the motor, or the current that weakens its field, has to be evaluated at each ratio.
    pub fn is_evaluated(&self) -> bool {
        !self.folded
            && (self.by_ratio.is_some()
                || self.has_evaluated_effects()
                || self.along_d().is_some()
                || self.whole_map().is_some())
    }

    /// Whether some effect of the motor has to be evaluated at each ratio.
    pub fn has_evaluated_effects(&self) -> bool {
        fitted::evaluated(self.motor).next().is_some()
    }

    /// What a current along d is for; `None` where there is none.
    #[inline]
    pub fn along_d(&self) -> Option<AlongD> {
        let bears = self.motor.demagnetization_current.unwrap_or(f64::INFINITY);
        if let Some(drive) = self.field_weakening_current() {
            return self.why_no_current_along_d().is_none().then(|| AlongD::Weakening(drive.min(bears)));
        }
        let beyond = self.beyond_which_braked()?;
        self.why_no_current_along_d().is_none().then_some(AlongD::Braking { beyond, most: bears })
    }

    /// The largest current against the magnets that may weaken the field \[A, q axis\]; `None` where it is not weakened.
    pub fn weakening(&self) -> Option<f64> {
        match self.along_d()? {
            AlongD::Weakening(most) => Some(most),
            AlongD::Braking { .. } => None,
        }
    }

    /// Power that comes back \[W, at the drive's output\] beyond which flux braking turns it into heat, where that is asked for.
    fn beyond_which_braked(&self) -> Option<f64> {
        let bus = &self.robot.bus;
        let taken = bus.takes_back().filter(|_| bus.flux_braking)?;
        Some(taken * self.joint.limits.left_of("regeneration") / Drawn::new(bus).arrives())
    }

    /// Why nothing is turned into heat by a current along d, where the requirement asks for that.
    pub fn why_not_braked(&self) -> Option<&'static str> {
        self.beyond_which_braked()?;
        match self.field_weakening_current() {
            Some(_) if self.why_no_current_along_d().is_none() => {
                Some("it is not combined with a weakened field: i_d is that of the voltage alone")
            }
            _ => self.why_no_current_along_d(),
        }
    }

    /// What currents along d take of a candidate at the ratio that its load is made for; `None` where there are none.
    pub fn what_weakening_takes(&self) -> Option<Weakening> {
        let burns = matches!(self.along_d()?, AlongD::Braking { .. });
        let voltage = self.voltage_squared("voltage").sqrt();
        Some(self.load.weakening(&self.actuator, voltage, burns))
    }

    fn field_weakening_current(&self) -> Option<f64> {
        let amplitude = self.joint.drive.or(self.robot.bus.drive).field_weakening_current?;
        Some(amplitude * self.current_per_amplitude())
    }

    /// Why the field is not weakened, where the requirement asks for it.
    pub fn why_not_weakened(&self) -> Option<&'static str> {
        self.field_weakening_current()?;
        self.why_no_current_along_d()
    }

    /// Why there is no current along d, whoever asks for one.
    fn why_no_current_along_d(&self) -> Option<&'static str> {
        let motor = self.motor;
        match () {
            () if motor.conventions.commutation == Commutation::Brushed => {
                Some("a brushed motor has no d axis: i_d = 0")
            }
            () if motor.inductance.is_none_or(|l| l == 0.0) || motor.pole_pairs.is_none_or(|p| p == 0) => {
                Some("inductance or pole pairs are not known: i_d = 0")
            }
            () if motor.is_estimated(Estimated::Inductance) => Some("the inductance is only estimated: i_d = 0"),
            () if self.supply_resistance() > 0.0 => Some("it is not combined with a resistance of the supply: i_d = 0"),
            () if self.joint.limits.spring.is_some() => {
                Some("it is not combined with a spring that is chosen: i_d = 0")
            }
            () if self.joint.gear_map.is_some() && self.catalog_gear.is_none() => {
                Some("it is not combined with a gear map: i_d = 0")
            }
            () if self.joint.turns != Turns::AsWound => Some("it is not combined with other turns: i_d = 0"),
            () => None,
        }
    }

    /// What part of the thermal resistance to ambient lies between winding and housing; `None` where it is not known.
    pub(super) fn share_of_winding(&self) -> Option<f64> {
        let winding = self.motor.sheet.thermal_resistance_winding_housing?.value;
        let housing = self.housing_resistance()?;
        (winding + housing > 0.0).then(|| winding / (winding + housing))
    }

    /// How much of the heat at standstill counts once more: the phase that carries two thirds of it instead of one
    /// warms over its own way to the housing by twice as much, and the housing by no more. All of it where nobody
    /// knows what part of the resistance that way has; none of a brushed motor.
    pub fn standing_share(&self) -> f64 {
        match self.motor.conventions.commutation {
            Commutation::Brushed => 0.0,
            Commutation::Brushless => self.share_of_winding().unwrap_or(1.0),
        }
    }

    /// The temperature that the winding has to keep below \[K\], and whose: see [`hottest`]; less what the joint keeps in
    /// reserve.
    pub(super) fn winding_temperature(&self) -> (f64, &'static str) {
        let (kelvin, owner) = hottest(self.motor, self.joint);
        (kelvin - self.joint.limits.temperature_reserve, owner)
    }

    /// Thermal resistance from winding to ambient \[K/W\]: with that of the mount in place of the row's own, where the
    /// joint says one and the row says what part is the winding's. Where the requirement states a temperature and the row
    /// gives a rating alone, what that says at most.
    pub fn thermal_resistance(&self) -> Option<f64> {
        let rated = self.motor.rated_thermal_resistance.filter(|_| self.is_rated());
        if self.is_mounted() {
            return self.mounted_resistance();
        }
        self.motor.thermal_resistance.or(rated)
    }

    /// Whether the thermal resistance is told from the motor's rating, because the requirement states a temperature and
    /// the row gives no resistance.
    pub fn is_rated(&self) -> bool {
        let Motor { thermal_resistance, rated_thermal_resistance, .. } = self.motor;
        let stated = self.joint.limits.winding_temperature.is_some() || self.is_mounted();
        stated && thermal_resistance.is_none() && rated_thermal_resistance.is_some()
    }

    /// The thermal resistance to ambient with the mount's, where the joint says one: added to the winding's own, or to
    /// all of the row's where it does not say what part that is. The winding's part is no more than the whole: that is
    /// from above.
    fn mounted_resistance(&self) -> Option<f64> {
        let mount = self.joint.limits.mount_resistance?;
        let own = self.motor.sheet.thermal_resistance_winding_housing.map(|p| p.value);
        let whole = self.motor.thermal_resistance.or(self.motor.rated_thermal_resistance);
        Some(own.or(whole)? + mount)
    }

    /// Whether what the row says of heat is that of another mounting than the joint's: its ratings do not count then.
    pub fn is_mounted(&self) -> bool {
        self.joint.limits.mount_resistance.is_some()
    }

    /// The motor's continuous current \[A\], where it counts.
    pub(super) fn continuous_current(&self) -> Option<f64> {
        self.motor.continuous_current.filter(|_| !self.is_mounted()).map(|rated| rated * self.derating())
    }

    /// What is left of a continuous rating in surroundings hotter than ratings are made for: the root of the rise that is
    /// left, to the motor's own highest temperature or the one that is assumed; nothing where there is none left.
    pub fn derating(&self) -> f64 {
        let hottest = self.motor.max_winding_temperature.unwrap_or(ASSUMED_WINDING_TEMPERATURE);
        match self.robot.ambient {
            ambient if ambient >= hottest => 0.0,
            ambient if ambient > RATED_UP_TO => ((hottest - ambient) / (hottest - RATED_UP_TO)).sqrt(),
            _ => 1.0,
        }
    }

    /// The motor's continuous torque \[N·m\], where it counts.
    pub(super) fn continuous_torque(&self) -> Option<f64> {
        self.motor.continuous_torque.filter(|_| !self.is_mounted()).map(|rated| rated * self.derating())
    }

    /// Thermal resistance from housing to ambient \[K/W\]: the mount's, or the row's.
    fn housing_resistance(&self) -> Option<f64> {
        let row = self.motor.sheet.thermal_resistance_housing_ambient.map(|p| p.value);
        self.joint.limits.mount_resistance.or(row)
    }

    /// The two thermal nodes, where the sheet gives both resistances and both time constants.
    pub fn two_node(&self) -> Option<TwoNode> {
        let sheet = &self.motor.sheet;
        let housing = self.housing_resistance()?;
        // The housing's heat capacity is the same on any mount.
        let row = sheet.thermal_resistance_housing_ambient?.value;
        Some(TwoNode {
            resistance_winding_housing: sheet.thermal_resistance_winding_housing?.value,
            resistance_housing_ambient: housing,
            time_constant_winding: sheet.thermal_time_constant_winding?.value,
            time_constant_housing: sheet.thermal_time_constant_housing?.value * housing / row,
            ambient: self.robot.ambient,
            reference: self.motor.reference_temperature,
            phases: self.motor.conventions.commutation == Commutation::Brushless,
        })
    }

    /// Rms current that heats the winding to its limit in steady state \[A\]; zero where ambient is
    /// too hot already.
    pub fn thermal_current(&self) -> Option<(f64, &'static str)> {
        self.current_for(1.0)
    }

    /// Rms current that heats the winding in steady state by a share of the rise to its limit \[A\].
    pub(super) fn current_for(&self, share: f64) -> Option<(f64, &'static str)> {
        let (limit, owner) = self.winding_temperature();
        let motor = self.motor;
        let squared = thermal::allowed_current_squared(
            limit - (1.0 - share) * (limit - self.robot.ambient),
            motor.resistance,
            motor.reference_temperature,
            self.thermal_resistance()?,
            self.robot.ambient,
        );
        Some((squared.max(0.0).sqrt(), owner))
    }

    /// Largest root mean square current that may flow continuously \[A\], by its witnesses, which are the row's continuous
    /// current, its continuous torque, and its thermal resistances with a highest temperature: the least of what they
    /// say. `None` where there is none, and nothing can be said of heat.
    pub fn steady_current(&self) -> Option<f64> {
        self.steady_current_for(1.0)
    }

    /// Largest root mean square current for a share of the rise to the limit \[A\]; a rating gives that share of its heat.
    pub(super) fn steady_current_for(&self, share: f64) -> Option<f64> {
        let of_torque = |torque: f64| match self.actuator.shortfall.saturates() {
            true => self.actuator.shortfall.current_squared(torque * torque).0.sqrt(),
            false => torque * self.actuator.rms_current_per_torque(),
        };
        let rated = [self.continuous_current(), self.continuous_torque().map(of_torque)];
        let rated = rated.map(|current| current.map(|i| i * share.sqrt()));
        let told = rated.into_iter().chain([self.current_for(share).map(|(i, _)| i)]);
        told.flatten().reduce(f64::min)
    }
}

/// Ambient temperature up to which continuous ratings are taken as they are printed \[K\]: 40 °C, the standard ambient of
/// rotating machines (IEC 60034-1).
pub const RATED_UP_TO: f64 = 313.15;

/// Owner of a highest winding temperature that neither motor nor requirement gives.
pub const ASSUMED: &str = "assumed";

/// Highest winding temperature \[K\], and whose: the lower of the motor's and the requirement's; where neither gives one,
/// 100 °C, assumed.
pub fn hottest(motor: &Motor, joint: &Joint) -> (f64, &'static str) {
    let motor = motor.max_winding_temperature.map(|t| (t, "motor"));
    let asked = joint.limits.winding_temperature.map(|t| (t, "requirement"));
    match (motor, asked) {
        (Some(m), Some(a)) if a.0 < m.0 => a,
        (m, a) => m.or(a).unwrap_or((ASSUMED_WINDING_TEMPERATURE, ASSUMED)),
    }
}
