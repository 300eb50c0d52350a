//! Every limit of the model, once: what is demanded, what may be had, and what kind of set of
//! ratios that leaves. Sweep, ratio program and design rules all read [`LIMITS`].

use super::fitted;
use super::load::Load;
use super::shaft::{Actuator, Flow};
use super::stretch;
use super::thermal;
use super::thermal_motion::TwoNode;
use super::waveform::Functional;
use crate::catalog::convention::{Commutation, CurrentConvention};
use crate::catalog::{Gear, Motor};
use crate::numerics::laurent::Laurent;
use crate::requirement::{GearModel, Joint, RatioChoice, Regeneration, Robot};

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
    /// The equations of motor and gear together.
    pub actuator: Actuator,
    /// Whether load and actuator are those of one ratio, with the evaluated effects in them.
    pub folded: bool,
}

/// Which ratios a limit leaves, as a function of u = N² with all else fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// All or none: the demand does not depend on the ratio.
    Fixed,
    /// All ratios up to one: an upper bound on N.
    UpperBound,
    /// Convex rows in (1/u, u, u²), exact under `u w ≥ 1`, `t ≥ u²`, as long as the shaft torque has
    /// no term of power zero (motor Coulomb friction); one interval of ratios.
    Convex,
    /// The complement of a convex set: up to two intervals of ratios.
    ReverseConvex,
}

impl Class {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Class::Fixed => "all ratios or none",
            Class::UpperBound => "all ratios up to one",
            Class::Convex => "one interval of ratios, convex in N²",
            Class::ReverseConvex => "up to two intervals of ratios: the complement of a convex set",
        }
    }
}

/// What is compared with the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Demand {
    /// A number that does not depend on the ratio, and the sample that has it.
    Fixed(f64, Option<usize>),
    /// One polynomial in N.
    Polynomial(Laurent, Option<usize>),
    /// The largest of a functional over all samples.
    Samples(Functional),
    /// The same with the bandwidth torque on top.
    Bandwidth(Functional),
    /// Mass of motor and gear, by stages \[kg\].
    Mass,
    /// Largest rise of the winding's temperature over the motion \[K\].
    WindingPeak(TwoNode),
    /// Mean of the squared current of a motor whose iron saturates \[A²\], with so much of that at standstill counted
    /// once more.
    MeanCurrentSquared(f64),
}

/// A limit that applies to a candidate. In its natural unit the demand is `factor · √x` where
/// squared, else `factor · x`, x being the functional or polynomial.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Which limit.
    pub limit: &'static Limit,
    /// What is demanded.
    pub demand: Demand,
    /// Whether the functional is the square of the demand.
    pub squared: bool,
    /// Natural unit per functional (or per its root).
    pub factor: f64,
    /// What may be had, natural unit.
    pub bound: f64,
    /// Whose limit it is.
    pub owner: &'static str,
}

/// Whether a limit applies.
#[derive(Debug, Clone, Copy)]
pub enum Check {
    /// Nobody asked for it.
    NotAsked,
    /// It should be checked but cannot be: what is missing.
    Unknown(&'static str),
    /// It applies.
    Asked(Asked),
    /// What is known cannot reject a ratio: of the ratio that was chosen it is told what can be said.
    AtRatio(Judge),
}

/// What can be said of a limit at a ratio that was chosen.
pub type Judge = fn(&Candidate, f64) -> Verdict;

/// How a design stands against a limit that no ratio is rejected by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is certainly kept.
    Kept,
    /// It counts as kept, as far as this holds.
    Assumed(&'static str),
    /// It cannot be judged: why.
    Unknown(&'static str),
}

/// The name of a limit, and what is to be said of it.
pub type Remark = (&'static str, &'static str);

/// What a limit or a need is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// Currents of the power-invariant q axis, the motor's own.
    QAxis,
    /// Ratings of the gear.
    Gear,
    /// Anything else.
    Other,
}

/// A limit of the model.
pub struct Limit {
    /// Name, also in JSON.
    pub name: &'static str,
    /// Unit of demand and bound.
    pub unit: &'static str,
    /// What is compared.
    pub formula: &'static str,
    /// Whether the demand has the requirement's safety factor in it.
    pub safety: bool,
    /// What it is a limit of.
    pub of: Of,
    /// Which ratios it leaves.
    pub class: Class,
    /// Whether the requirement itself asks for it: then a design of which it cannot be judged is no choice.
    pub stated: fn(&Robot, &Joint) -> bool,
    prepare: fn(&Candidate) -> Prepared,
}

impl std::fmt::Debug for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What a limit says of a candidate, before it is tied to its name.
enum Prepared {
    NotAsked,
    Unknown(&'static str),
    Asked { demand: Demand, squared: bool, factor: f64, bound: f64, owner: &'static str },
    AtRatio(Judge),
}

impl Limit {
    /// Whether demand and bound are q-axis amperes (power invariant), not those of a phase or of the bus.
    pub fn is_q_axis(&self) -> bool {
        self.of == Of::QAxis
    }

    /// Whether the limit applies to a candidate, and how.
    pub fn check(&'static self, candidate: &Candidate) -> Check {
        match (self.prepare)(candidate) {
            Prepared::NotAsked => Check::NotAsked,
            Prepared::Unknown(what) => Check::Unknown(what),
            Prepared::Asked { demand, squared, factor, bound, owner } => {
                Check::Asked(Asked { limit: self, demand, squared, factor, bound, owner })
            }
            Prepared::AtRatio(judge) => Check::AtRatio(judge),
        }
    }
}

/// What a demand may be of the terms whose sum it is and still count as nothing.
const ROUNDING: f64 = 1e-9;

impl Asked {
    /// The functional's value that the bound corresponds to.
    pub fn raw_bound(&self) -> f64 {
        let raw = self.bound / self.factor;
        if self.squared { raw.powi(2).copysign(raw) } else { raw }
    }

    /// The demand in its natural unit for a value of the functional.
    pub fn natural(&self, raw: f64) -> f64 {
        self.factor * if self.squared { raw.max(0.0).sqrt() } else { raw }
    }

    /// The functional's value at a ratio, and the sample of the motion that has it.
    pub fn raw_demand(&self, candidate: &Candidate, ratio: f64) -> (f64, Option<usize>) {
        if candidate.is_evaluated() {
            return candidate.at_ratio(ratio, |here| match self.limit.check(here) {
                Check::Asked(asked) => asked.raw_demand(here, ratio),
                _ => (0.0, None),
            });
        }
        let over = |waveform: &super::waveform::Waveform, functional| {
            let largest = waveform.largest(functional, &candidate.actuator, ratio);
            (largest.value, Some(waveform.origin(largest.index)))
        };
        match self.demand {
            Demand::Fixed(value, sample) => (value, sample),
            Demand::Polynomial(polynomial, sample) => (polynomial.at(ratio), sample),
            Demand::Samples(functional) => over(&candidate.load.waveform, functional),
            Demand::Bandwidth(functional) => match &candidate.load.bandwidth {
                Some(waveform) => over(waveform, functional),
                None => (0.0, None),
            },
            Demand::Mass => (candidate.known_mass_at(ratio), None),
            Demand::WindingPeak(node) => candidate.load.winding_peak(&candidate.actuator, &node, ratio),
            Demand::MeanCurrentSquared(standing) => {
                let Candidate { load, actuator, .. } = candidate;
                (load.share_of_time * load.mean_current_squared(actuator, standing, ratio), None)
            }
        }
    }

    /// Whether the limit is certainly kept at a ratio, where that is seen without computing the demand.
    pub fn is_certainly_kept(&self, candidate: &Candidate, ratio: f64) -> bool {
        match self.demand {
            Demand::WindingPeak(node) if !candidate.is_evaluated() => {
                candidate.load.winding_peak_is_within(&candidate.actuator, &node, ratio, self.bound)
            }
            _ => false,
        }
    }

    /// The polynomial of the ratio that is the demand's functional at a ratio (of a limit over samples: that of the
    /// sample that has it), and its sample. It is nowhere above the functional. `None` for limits that are no
    /// polynomial, or certainly kept.
    pub fn polynomial_at(&self, candidate: &Candidate, ratio: f64) -> Option<(Laurent, Option<usize>)> {
        match self.demand {
            Demand::Polynomial(polynomial, sample) => Some((polynomial, sample)),
            Demand::Samples(functional) | Demand::Bandwidth(functional) => {
                let bandwidth = matches!(self.demand, Demand::Bandwidth(_));
                let waveform = if bandwidth { candidate.load.bandwidth.as_ref()? } else { &candidate.load.waveform };
                let point = waveform.point(waveform.largest(functional, &candidate.actuator, ratio).index);
                Some((functional.polynomial(&candidate.actuator, point.flow, &point.features), Some(point.origin)))
            }
            Demand::WindingPeak(_) if self.is_certainly_kept(candidate, ratio) => None,
            Demand::WindingPeak(node) => {
                let cut = candidate.load.winding_peak_cut(&candidate.actuator, &node, ratio, self.raw_bound());
                Some((cut, self.raw_demand(candidate, ratio).1))
            }
            Demand::MeanCurrentSquared(standing) => {
                let Candidate { load, actuator, .. } = candidate;
                Some((load.mean_current_squared_cut(actuator, standing, ratio) * load.share_of_time, None))
            }
            Demand::Fixed(..) | Demand::Mass => None,
        }
    }

    /// `1 − demand/limit` at a ratio, for the functional's value there. A limit of zero has margin 0 where it is kept
    /// and −1 where it is not: what rounding leaves of terms that cancel does not break it. A demand without end has
    /// −10⁶.
    pub fn margin(&self, candidate: &Candidate, ratio: f64, raw: f64) -> f64 {
        let demand = self.natural(raw);
        // Thermal runaway is beyond any limit; a finite number is what programs can read.
        if demand == f64::INFINITY {
            return -1e6;
        }
        if self.bound == 0.0 {
            let rounding =
                || self.polynomial_at(candidate, ratio).is_some_and(|(terms, _)| raw <= ROUNDING * terms.size(ratio));
            return if demand <= 0.0 || rounding() { 0.0 } else { -1.0 };
        }
        1.0 - demand.max(0.0) / self.bound
    }
}

impl Candidate<'_> {
    /// Mass of motor and gear at a ratio \[kg\]; `None` where either is unknown.
    pub fn mass_at(&self, ratio: f64) -> Option<f64> {
        Some(self.motor.mass? + self.gear.mass_at(ratio)?)
    }

    /// What is known of that mass \[kg\]: the actuator weighs at least this.
    pub fn known_mass_at(&self, ratio: f64) -> f64 {
        self.motor.mass.unwrap_or(0.0) + self.gear.mass_at(ratio).unwrap_or(0.0)
    }

    /// What is needed beside the limits and not known: name and why.
    pub fn lacking(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        NEEDS.iter().filter_map(|need| Some((need.name, (need.missing)(self)?)))
    }

    /// All limits with what they say of this candidate.
    pub fn checks(&self) -> impl Iterator<Item = (&'static Limit, Check)> + '_ {
        LIMITS.iter().map(|limit| (limit, limit.check(self)))
    }

    /// The smaller of the motor's and the drive's largest current, q axis \[A\], and whose it is.
    pub fn peak_current(&self) -> Option<(f64, &'static str)> {
        let amplitude = match self.motor.conventions.commutation {
            Commutation::Brushless => CurrentConvention::PhaseAmplitude,
            Commutation::Brushed => CurrentConvention::Dc,
        };
        let per_ampere = amplitude.torque_current(self.motor.conventions.commutation);
        let drive = self.joint.drive_current.or(self.robot.bus.drive_current).map(|i| (i * per_ampere, "drive"));
        let motor = self.motor.peak_current.map(|i| (i, "motor"));
        match (motor, drive) {
            (Some(m), Some(d)) => Some(if d.0 < m.0 { d } else { m }),
            (m, d) => m.or(d),
        }
    }

    /// Voltage that the drive can apply, radius of the q-axis circle \[V\].
    pub fn voltage(&self) -> f64 {
        let bus = &self.robot.bus;
        let circle = bus.voltage * bus.modulation.voltage(self.motor.conventions.commutation) * bus.modulation_limit;
        (circle - self.actuator.shortfall.voltage).max(0.0)
    }

    /// Whether some effect of the motor has to be evaluated at each ratio.
    pub fn is_evaluated(&self) -> bool {
        !self.folded && fitted::evaluated(self.motor).next().is_some()
    }

    /// The candidate at one ratio, with the effects that have to be evaluated there in its samples.
    pub fn at_ratio<T>(&self, ratio: f64, look: impl FnOnce(&Candidate) -> T) -> T {
        let form = self.actuator.torque_form(Flow::Driving);
        let load = self.load.folded(|velocity, towards, acceleration| {
            fitted::folded(self.motor, form, ratio, velocity, towards, acceleration)
        });
        look(&Candidate { load: &load, actuator: self.actuator.folded(), folded: true, ..*self })
    }

    /// Mean heat in the copper as a limit on a current \[A\], with the share `standing` of that at standstill counted
    /// once more.
    fn heating(&self, standing: f64, bound: f64, owner: &'static str) -> Prepared {
        if self.actuator.shortfall.saturates() {
            return torque(Demand::MeanCurrentSquared(standing), 1.0, bound, owner);
        }
        let mean = self.load.mean_torque_squared_standing(&self.actuator, standing) * self.load.share_of_time;
        torque(Demand::Polynomial(mean, None), self.actuator.rms_current_per_torque(), bound, owner)
    }

    /// What part of the thermal resistance to ambient lies between winding and housing; `None` where it is not known.
    fn share_of_winding(&self) -> Option<f64> {
        let winding = self.motor.sheet.thermal_resistance_winding_housing?.value;
        let housing = self.motor.sheet.thermal_resistance_housing_ambient?.value;
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

    /// By how much the phase that carries two thirds of the heat at standstill can be hotter than the mean of the three
    /// \[K\], where the winding stays below `hottest` \[K\]: from above, as if all the time at standstill were one.
    ///
    /// Its own way to the housing has three times the winding's resistance and a third of its capacity, and twice the
    /// mean phase's heat: what it has more is a first order with the winding's resistance and time constant.
    fn rise_at_standstill(&self, node: &TwoNode, hottest: f64, ratio: f64) -> f64 {
        if self.standing_share() == 0.0 {
            return 0.0;
        }
        let (heat, stands, cycle) = self.load.standing(&self.actuator, ratio);
        let answer = |time: f64| -(-time / node.time_constant_winding).exp_m1();
        let share = if stands == 0.0 { 0.0 } else { answer(stands) / answer(cycle) };
        heat * thermal::resistance_factor(hottest, node.reference) * node.resistance_winding_housing * share
    }

    /// A limit on the largest current \[A\], of what the ripple leaves of it.
    fn peak(&self, demand: Demand, bound: f64, owner: &'static str) -> Prepared {
        let safety = self.joint.limits.safety;
        let bound = self.actuator.shortfall.left_of_current(bound, safety);
        torque(demand, safety / self.actuator.torque_constant, bound, owner)
    }

    /// Highest winding temperature: the lower of the motor's and the requirement's \[K\], and whose.
    fn winding_temperature(&self) -> Option<(f64, &'static str)> {
        hottest(self.motor, self.joint)
    }

    /// The two thermal nodes, where the sheet gives both resistances and both time constants.
    pub fn two_node(&self) -> Option<TwoNode> {
        let sheet = &self.motor.sheet;
        Some(TwoNode {
            resistance_winding_housing: sheet.thermal_resistance_winding_housing?.value,
            resistance_housing_ambient: sheet.thermal_resistance_housing_ambient?.value,
            time_constant_winding: sheet.thermal_time_constant_winding?.value,
            time_constant_housing: sheet.thermal_time_constant_housing?.value,
            ambient: self.robot.ambient,
            reference: self.motor.reference_temperature,
        })
    }

    /// Rms current that heats the winding to its limit in steady state \[A\]; zero where ambient is
    /// too hot already.
    pub fn thermal_current(&self) -> Option<(f64, &'static str)> {
        let (limit, owner) = self.winding_temperature()?;
        let motor = self.motor;
        let squared = thermal::allowed_current_squared(
            limit,
            motor.resistance,
            motor.reference_temperature,
            motor.thermal_resistance?,
            self.robot.ambient,
        );
        Some((squared.max(0.0).sqrt(), owner))
    }

    /// Largest root mean square current that may flow for ever \[A\], by whatever the row tells it from: its
    /// continuous current or torque, its thermal resistances with a highest temperature. `None` where nothing does.
    pub fn steady_current(&self) -> Option<f64> {
        let of_torque = |torque: f64| match self.actuator.shortfall.saturates() {
            true => self.actuator.shortfall.current_squared(torque * torque).0.sqrt(),
            false => torque * self.actuator.rms_current_per_torque(),
        };
        let Motor { continuous_current, continuous_torque, .. } = self.motor;
        let told = [*continuous_current, continuous_torque.map(of_torque), self.thermal_current().map(|(i, _)| i)];
        told.into_iter().flatten().reduce(f64::min)
    }

    /// What the limits that are asked of this candidate assume at every ratio.
    pub fn assumptions(&self, asked: &[Asked]) -> Vec<Remark> {
        let mut assumed = Vec::new();
        let resistance = match (
            hottest(self.motor, self.joint),
            hot_winding(self.motor, self.joint, self.robot.ambient),
        ) {
            (Some(_), _) => None,
            (None, Some(_)) => Some(
                "no highest winding temperature is known: its resistance is that of the temperature at which the continuous current settles, and the motion may heat it further for a while",
            ),
            (None, None) => {
                Some("no temperature of the winding is known: its resistance is taken at the reference temperature")
            }
        };
        let power = [("bus_power", self.robot.bus.power), ("bus_current", self.robot.bus.current)];
        let takes = power.into_iter().filter(|(_, bound)| bound.is_some()).map(|(name, _)| name);
        assumed.extend(std::iter::once("voltage").chain(takes).filter_map(|name| Some((name, resistance?))));
        let heat = ["winding_temperature", "winding_peak_temperature", "standstill_holding"];
        let stated = self.joint.limits.winding_temperature.is_some() && self.motor.max_winding_temperature.is_none();
        if let (true, Some(of_heat)) = (stated, asked.iter().find(|a| heat.contains(&a.limit.name))) {
            assumed.push((
                of_heat.limit.name,
                "the motor's own highest temperature is not known: that of the requirement is taken alone",
            ));
        }
        if asked.iter().any(|a| a.limit.name == "standstill_holding") && self.share_of_winding().is_none() {
            assumed.push((
                "standstill_holding",
                "what part of the thermal resistance is the winding's own is not known: all of it is taken to be",
            ));
        }
        assumed
    }
}

/// Highest winding temperature: the lower of the motor's and the requirement's \[K\], and whose.
pub fn hottest(motor: &Motor, joint: &Joint) -> Option<(f64, &'static str)> {
    let motor = motor.max_winding_temperature.map(|t| (t, "motor"));
    let asked = joint.limits.winding_temperature.map(|t| (t, "requirement"));
    match (motor, asked) {
        (Some(m), Some(a)) => Some(if a.0 < m.0 { a } else { m }),
        (m, a) => m.or(a),
    }
}

/// The temperature of the winding \[K\] that voltage and power taken are judged at: the highest that motor and
/// requirement allow; where none is known that which the continuous current leads to in steady state, as no design that
/// keeps its limits is hotter. `None` where neither is known.
pub fn hot_winding(motor: &Motor, joint: &Joint, ambient: f64) -> Option<f64> {
    let rated = || {
        let (current, r_th) = (motor.continuous_current?, motor.thermal_resistance?);
        let reference = motor.reference_temperature;
        thermal::winding_temperature(current * current, motor.resistance, reference, r_th, ambient)
    };
    hottest(motor, joint).map(|(kelvin, _)| kelvin).or_else(rated)
}

/// A limit on the square of the shaft torque.
fn torque(demand: Demand, factor: f64, bound: f64, owner: &'static str) -> Prepared {
    Prepared::Asked { demand, squared: true, factor, bound, owner }
}

/// A limit on something that needs no square.
fn plain(demand: Demand, factor: f64, bound: f64, owner: &'static str) -> Prepared {
    Prepared::Asked { demand, squared: false, factor, bound, owner }
}

/// Nothing in a requirement asks for it: a data sheet does.
fn by_data_sheets(_: &Robot, _: &Joint) -> bool {
    false
}

/// The voltage is what every requirement has, not a limit that somebody put; without inductance it is checked
/// without it, which is said (see [`NEEDS`]).
fn the_supply(_: &Robot, _: &Joint) -> bool {
    false
}

fn a_temperature(_: &Robot, joint: &Joint) -> bool {
    joint.limits.winding_temperature.is_some()
}

/// A rating of the gear that the requirement describes, not of one from the catalogue.
fn described(joint: &Joint, rating: Option<f64>) -> bool {
    rating.is_some() && matches!(joint.ratio, RatioChoice::Continuous { .. })
}

const NO_DURATIONS: &str = "the operating points have no durations";

const NO_MASS: &str = "the mass of motor or gear is not known";

/// Something that is asked of a candidate and that no limit of the model asks for: a number without which a limit
/// says less, or one that the whole robot needs.
pub struct Need {
    /// Name, beside those of the limits.
    pub name: &'static str,
    /// What it is about.
    pub of: Of,
    /// Whether the requirement asks for what cannot be judged without it.
    pub stated: fn(&Robot, &Joint) -> bool,
    /// What is missing, if anything.
    pub missing: fn(&Candidate) -> Option<&'static str>,
}

impl std::fmt::Debug for Need {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

fn no_mass(candidate: &Candidate) -> Option<&'static str> {
    candidate.mass_at(1.0).is_none().then_some(NO_MASS)
}

/// Every need.
pub const NEEDS: &[Need] = &[
    Need {
        name: "inductance",
        of: Of::Other,
        stated: the_supply,
        missing: |c| match (c.motor.inductance, c.motor.pole_pairs) {
            (Some(_), Some(_)) => None,
            (None, _) => Some("the motor's inductance is not known: voltage is checked without it"),
            (Some(_), None) => Some(
                "the motor's pole pairs are not known: voltage is checked with L di/dt, but without p N ω L i across it",
            ),
        },
    },
    Need {
        name: "demagnetisation",
        of: Of::Other,
        stated: by_data_sheets,
        missing: |c| {
            let by_drive =
                c.motor.peak_current.is_none() && c.joint.drive_current.or(c.robot.bus.drive_current).is_some();
            by_drive.then_some(
                "the motor's peak current is not known: only the drive's is checked, which may be more than its magnets bear",
            )
        },
    },
    Need {
        name: "torque_bandwidth_voltage",
        of: Of::Other,
        stated: |_, joint| joint.limits.torque_bandwidth.is_some(),
        missing: |c| {
            let Motor { inductance, pole_pairs, conventions, .. } = c.motor;
            let brushless = conventions.commutation == Commutation::Brushless;
            let lacks = c.load.bandwidth.is_some() && inductance.is_some() && pole_pairs.is_none() && brushless;
            lacks.then_some(
                "the motor's pole pairs are not known: torque_bandwidth_voltage is checked without p N ω L i",
            )
        },
    },
    Need {
        name: "gear_inertia",
        of: Of::Gear,
        stated: |_, joint| joint.limits.reflected_inertia.is_some(),
        missing: |c| {
            let unknown = c.catalog_gear.is_some_and(|gear| gear.inertia.is_none());
            unknown.then_some("the gear's inertia is not known: it is left out")
        },
    },
    Need {
        name: "mass_budget",
        of: Of::Other,
        stated: |robot, _| robot.budget.actuator_mass.is_some(),
        missing: |c| c.robot.budget.actuator_mass.and_then(|_| no_mass(c)),
    },
    Need {
        name: "carried_mass",
        of: Of::Other,
        stated: |robot, joint| robot.carries(joint) || !joint.carries.is_empty(),
        missing: |c| if c.robot.carries(c.joint) { no_mass(c) } else { None },
    },
];

/// Whether a limit or a need is about the gear, by its name.
pub fn is_of_gear(name: &str) -> bool {
    LIMITS.iter().any(|limit| limit.name == name && limit.of == Of::Gear)
        || NEEDS.iter().any(|need| need.name == name && need.of == Of::Gear)
}

/// Whether the requirement itself asks for something, by the name of the limit or of the need.
pub fn is_stated(name: &str, robot: &Robot, joint: &Joint) -> bool {
    LIMITS.iter().any(|limit| limit.name == name && (limit.stated)(robot, joint))
        || NEEDS.iter().any(|need| need.name == name && (need.stated)(robot, joint))
}

/// A stretch above the steady limit shorter than this \[s\] is averaged by the winding: the least thermal time constant
/// of a winding in the catalogue is 5.1 s.
const SHORT_STRETCH: f64 = 1.0;

/// Least thermal time constant of a winding in the catalogue \[s\]. Heat that comes at once warms a winding by no more than
/// the steady limit's rise where it is no more than the steady limit's heat over that time.
const LEAST_TIME_CONSTANT: f64 = 5.1;

/// The same as a share of the winding's own time constant, where that is known.
const SHORT_SHARE: f64 = 0.2;

/// Heat over the motion, of a motor or motion whose winding's temperature cannot be followed. Without a heat capacity
/// nothing can be rejected.
fn heat_over_the_motion(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| heat_over_the_motion(here, ratio));
    }
    let (load, actuator) = (candidate.load, &candidate.actuator);
    let Some(limit) = candidate.steady_current() else {
        return Verdict::Unknown(match (candidate.motor.thermal_resistance, candidate.winding_temperature()) {
            (Some(_), None) => "neither a highest winding temperature nor the motor's continuous current is known",
            _ => "neither the motor's thermal resistances nor its continuous current is known",
        });
    };
    // A continuous current says nothing of the temperature that a requirement states.
    if candidate.joint.limits.winding_temperature.is_some() && candidate.thermal_current().is_none() {
        return Verdict::Unknown("the motor's thermal resistances are not known");
    }
    let limit = limit * limit;
    // Even the largest heat, held for ever, would be carried.
    let largest = load.largest_squared_current(actuator, candidate.standing_share(), ratio);
    if stretch::is_within(largest, limit) {
        return Verdict::Kept;
    }
    let (course, repeats) = load.squared_current_course(actuator, candidate.standing_share(), ratio);
    let nodes = candidate.two_node();
    match (nodes, candidate.winding_temperature()) {
        _ if !load.has_durations => {
            return Verdict::Unknown(
                "the operating points have no durations, and the hottest could not be held for ever",
            );
        }
        (Some(node), Some((hottest, _))) => {
            // The phase that is worst off at standstill is told apart: its own way to the housing answers at once.
            let (course, _) = load.squared_current_course(actuator, 0.0, ratio);
            let standing = candidate.rise_at_standstill(&node, hottest, ratio);
            let holds = course.iter().map(|piece| (piece.duration, actuator.resistance * piece.from));
            return match node.rise_at_the_end(holds, hottest) + standing <= hottest - node.ambient {
                true => Verdict::Kept,
                false => Verdict::Unknown(
                    "the order of the operating points is not known, and the hottest last may be too hot",
                ),
            };
        }
        _ => {}
    }
    let own = candidate.motor.sheet.thermal_time_constant_winding.map(|t| SHORT_SHARE * t.value);
    let short = own.map_or(SHORT_STRETCH, |own| own.min(SHORT_STRETCH));
    let longest = stretch::longest(&course, limit, repeats);
    let least = candidate.motor.sheet.thermal_time_constant_winding.map_or(LEAST_TIME_CONSTANT, |t| t.value);
    if longest < short && largest * longest > least * limit {
        return Verdict::Unknown(match nodes {
            None => {
                "the thermal time constants are not known, and a short stretch is so far above the steady limit that it may warm the winding beyond it at once"
            }
            Some(_) => {
                "no highest winding temperature is known, and a short stretch is so far above the steady limit that it may warm the winding beyond it at once"
            }
        });
    }
    match (longest < short, nodes.is_some(), load.starts_cold()) {
        (true, false, false) => Verdict::Assumed(
            "judged by its mean heat: the thermal time constants are not known, and heat stays above its steady limit for less than 1 s at a time",
        ),
        (true, true, false) => Verdict::Assumed(
            "judged by its mean heat: no highest winding temperature is known, and heat stays above its steady limit for less than 1 s at a time",
        ),
        (true, _, true) => {
            Verdict::Assumed("taken as kept: from cold heat stays above its steady limit for less than 1 s at a time")
        }
        (false, false, _) => Verdict::Unknown(match short < SHORT_STRETCH {
            false => {
                "the thermal time constants are not known, and heat stays above its steady limit for 1 s or longer"
            }
            true => {
                "not all thermal time constants are known, and heat stays above its steady limit for a fifth of the winding's or longer"
            }
        }),
        (false, true, _) => {
            Verdict::Unknown("no highest winding temperature is known, and heat stays above its steady limit for long")
        }
    }
}

/// Heat at standstill of a motor whose winding is followed over the motion: what is followed is the mean of the three
/// phases, and one of them carries two thirds of the heat.
pub fn heat_at_standstill(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| heat_at_standstill(here, ratio));
    }
    let load = candidate.load;
    let (Some(node), Some((hottest, _)), true) =
        (candidate.two_node(), candidate.winding_temperature(), load.has_course())
    else {
        return Verdict::Kept;
    };
    let more = candidate.rise_at_standstill(&node, hottest, ratio);
    match more == 0.0 || load.winding_peak(&candidate.actuator, &node, ratio).0 + more <= hottest - node.ambient {
        true => Verdict::Kept,
        false => Verdict::Unknown(
            "at standstill one phase carries two thirds of the heat and may be hotter than the mean of the three, which is followed over the motion",
        ),
    }
}

/// Every limit.
pub const LIMITS: &[Limit] = &[
    Limit {
        name: "peak_current",
        unit: "A",
        formula: "safety · max |T|/K_T ≤ I_peak",
        safety: true,
        of: Of::QAxis,
        class: Class::Convex,
        stated: |robot, joint| joint.drive_current.or(robot.bus.drive_current).is_some(),
        prepare: |c| match c.peak_current() {
            Some((bound, owner)) => c.peak(Demand::Samples(Functional::TorqueSquared), bound, owner),
            None => Prepared::Unknown("neither motor nor drive says a largest current"),
        },
    },
    Limit {
        name: "peak_torque",
        unit: "N*m",
        formula: "safety · max |T| ≤ T_peak",
        safety: true,
        of: Of::Other,
        class: Class::Convex,
        stated: by_data_sheets,
        prepare: |c| match c.motor.peak_torque {
            Some(bound) => {
                let safety = c.joint.limits.safety;
                let bound = c.actuator.shortfall.left_of_torque(bound, safety);
                torque(Demand::Samples(Functional::TorqueSquared), safety, bound, "motor")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "continuous_current",
        unit: "A",
        formula: "√mean(T²)/K_T ≤ I_continuous",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        stated: by_data_sheets,
        prepare: |c| match c.motor.continuous_current {
            _ if c.load.starts_cold() => Prepared::NotAsked,
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => c.heating(0.0, bound, "motor"),
            None => Prepared::Unknown("the motor's continuous current is not known"),
        },
    },
    Limit {
        name: "continuous_torque",
        unit: "N*m",
        formula: "√mean(T²) ≤ T_continuous",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        stated: by_data_sheets,
        prepare: |c| match c.motor.continuous_torque {
            None => Prepared::NotAsked,
            _ if c.load.starts_cold() => Prepared::NotAsked,
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => {
                let mean = c.load.mean_torque_squared(&c.actuator) * c.load.share_of_time;
                torque(Demand::Polynomial(mean, None), 1.0, bound, "motor")
            }
        },
    },
    Limit {
        name: "winding_temperature",
        unit: "A",
        formula: "√mean(T²)/K_T ≤ √((T_max − T_ambient)/(R_th R(T_max))): steady state, hot copper",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        stated: a_temperature,
        prepare: |c| match (c.thermal_current(), c.winding_temperature()) {
            // Even from cold a winding is not cooler than its surroundings.
            (_, limit) if c.load.starts_cold() && limit.is_none_or(|(kelvin, _)| kelvin > c.robot.ambient) => {
                Prepared::NotAsked
            }
            (Some(_), _) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            (Some((bound, owner)), _) => c.heating(0.0, bound, owner),
            (None, Some(_)) => Prepared::Unknown("the motor's thermal resistances are not known"),
            (None, None) if c.motor.thermal_resistance.is_some() => {
                Prepared::Unknown("no highest winding temperature is known")
            }
            (None, None) => Prepared::NotAsked,
        },
    },
    Limit {
        name: "winding_peak_temperature",
        unit: "K",
        formula: "max T_winding − T_ambient ≤ T_max − T_ambient over the motion: two nodes, hot copper, periodic state or from cold",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        stated: a_temperature,
        prepare: |c| match (c.two_node(), c.winding_temperature()) {
            (Some(node), Some((limit, owner))) if c.load.has_course() => {
                plain(Demand::WindingPeak(node), 1.0, (limit - node.ambient).max(0.0), owner)
            }
            _ => Prepared::AtRatio(heat_over_the_motion),
        },
    },
    Limit {
        name: "standstill_holding",
        unit: "A",
        formula: "√(mean(T²) + R_wh/R_th · mean over standstill(T²))/K_T ≤ I_continuous, I_thermal: the worst phase carries 2/3 of the heat",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        stated: a_temperature,
        prepare: |c| {
            if c.load.dwell == 0.0 || c.load.starts_cold() {
                return Prepared::NotAsked;
            }
            if !c.load.has_durations {
                return Prepared::Unknown(NO_DURATIONS);
            }
            let rated = c.motor.continuous_current.map(|i| (i, "motor"));
            let current = [rated, c.thermal_current()].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            match (current, c.motor.conventions.commutation) {
                (_, Commutation::Brushed) => Prepared::NotAsked,
                (Some((bound, owner)), _) => c.heating(c.standing_share(), bound, owner),
                (None, _) => Prepared::Unknown("neither continuous current nor thermal resistances are known"),
            }
        },
    },
    Limit {
        name: "voltage",
        unit: "V",
        formula: "max √(v_q² + v_d²) ≤ V, with R of the hottest winding allowed",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        stated: the_supply,
        prepare: |c| torque(Demand::Samples(Functional::VoltageSquared), 1.0, c.voltage(), "bus"),
    },
    Limit {
        name: "max_speed",
        unit: "rad/s",
        formula: "N max |ω| ≤ ω_max",
        safety: false,
        of: Of::Other,
        class: Class::UpperBound,
        stated: by_data_sheets,
        prepare: |c| match c.motor.max_speed {
            Some(bound) => {
                let (speed, sample) = c.load.peak_speed;
                plain(Demand::Polynomial(Laurent::monomial(speed, 1), Some(sample)), 1.0, bound, "motor")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_input_speed",
        unit: "rad/s",
        formula: "N max |ω| ≤ ω_gear",
        safety: false,
        of: Of::Gear,
        class: Class::UpperBound,
        stated: |_, joint| described(joint, joint.gear.max_input_speed),
        prepare: |c| match c.gear.max_input_speed {
            Some(bound) => {
                let (speed, sample) = c.load.peak_speed;
                plain(Demand::Polynomial(Laurent::monomial(speed, 1), Some(sample)), 1.0, bound, "gear")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_peak_torque",
        unit: "N*m",
        formula: "safety · max |τ| ≤ τ_gear peak",
        safety: true,
        of: Of::Gear,
        class: Class::Fixed,
        stated: |_, joint| described(joint, joint.gear.peak_torque),
        prepare: |c| match c.gear.peak_torque {
            Some(bound) => {
                let (torque, sample) = c.load.peak_torque;
                plain(Demand::Fixed(torque, Some(sample)), c.joint.limits.safety, bound, "gear")
            }
            None if c.catalog_gear.is_some() => Prepared::Unknown("the gear's peak torque is not known"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_continuous_torque",
        unit: "N*m",
        formula: "√mean(τ²) ≤ τ_gear continuous",
        safety: false,
        of: Of::Gear,
        class: Class::Fixed,
        stated: |_, joint| described(joint, joint.gear.continuous_torque),
        prepare: |c| match c.gear.continuous_torque {
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => plain(Demand::Fixed(c.load.rms_torque, None), 1.0, bound, "gear"),
            None if c.catalog_gear.is_some() => Prepared::Unknown("the gear's continuous torque is not known"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "reflected_inertia",
        unit: "kg*m^2",
        formula: "N² (J_m + J_g) ≤ J",
        safety: false,
        of: Of::Other,
        class: Class::UpperBound,
        stated: |_, joint| joint.limits.reflected_inertia.is_some(),
        prepare: |c| match c.joint.limits.reflected_inertia {
            Some(bound) => {
                plain(Demand::Polynomial(Laurent::monomial(c.actuator.inertia, 2), None), 1.0, bound, "requirement")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "torque_bandwidth_current",
        unit: "A",
        formula: "safety · max |T + superposed|/K_T ≤ I_peak, at 32 phases",
        safety: true,
        of: Of::QAxis,
        class: Class::Convex,
        stated: |_, joint| joint.limits.torque_bandwidth.is_some(),
        prepare: |c| match (&c.load.bandwidth, c.peak_current()) {
            (None, _) => Prepared::NotAsked,
            (Some(_), Some((bound, owner))) => c.peak(Demand::Bandwidth(Functional::TorqueSquared), bound, owner),
            (Some(_), None) => Prepared::Unknown("neither motor nor drive says a largest current"),
        },
    },
    Limit {
        name: "torque_bandwidth_voltage",
        unit: "V",
        formula: "max √(v_q² + v_d²) ≤ V with the superposed torque, at 32 phases and R of the hottest winding",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        stated: |_, joint| joint.limits.torque_bandwidth.is_some(),
        prepare: |c| match (&c.load.bandwidth, c.motor.inductance) {
            (None, _) => Prepared::NotAsked,
            (Some(_), Some(_)) => torque(Demand::Bandwidth(Functional::VoltageSquared), 1.0, c.voltage(), "bus"),
            (Some(_), None) => Prepared::Unknown("the motor's inductance is not known"),
        },
    },
    Limit {
        name: "bus_power",
        unit: "W",
        formula: "max (R i² + K_B N ω i)/η_d ≤ P, with R of the hottest winding",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        stated: |robot, _| robot.bus.power.is_some(),
        prepare: |c| match c.robot.bus.power {
            Some(bound) => plain(Demand::Samples(Functional::Power), 1.0 / c.robot.bus.drive_efficiency, bound, "bus"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "bus_current",
        unit: "A",
        formula: "max (R i² + K_B N ω i)/(η_d V_bus) ≤ I_bus, with R of the hottest winding",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        stated: |robot, _| robot.bus.current.is_some(),
        prepare: |c| match c.robot.bus.current {
            Some(bound) => {
                let factor = 1.0 / (c.robot.bus.drive_efficiency * c.robot.bus.voltage);
                plain(Demand::Samples(Functional::Power), factor, bound, "bus")
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "regeneration",
        unit: "W",
        formula: "max −η_d (R i² + K_B N ω i) ≤ P_regeneration, with R at its reference temperature",
        safety: false,
        of: Of::Other,
        class: Class::ReverseConvex,
        stated: |robot, _| robot.bus.regeneration != Regeneration::Allowed,
        prepare: |c| match c.robot.bus.regeneration {
            Regeneration::Allowed => Prepared::NotAsked,
            Regeneration::Limited(bound) => {
                plain(Demand::Samples(Functional::PowerBack), c.robot.bus.drive_efficiency, bound, "bus")
            }
        },
    },
    Limit {
        name: "actuator_mass",
        unit: "kg",
        formula: "m_motor + m_gear ≤ m",
        safety: false,
        of: Of::Other,
        class: Class::UpperBound,
        stated: |_, joint| joint.limits.actuator_mass.is_some(),
        prepare: |c| match (c.joint.limits.actuator_mass, c.mass_at(1.0)) {
            (None, _) => Prepared::NotAsked,
            (Some(bound), Some(_)) => plain(Demand::Mass, 1.0, bound, "requirement"),
            // What is known is too heavy already.
            (Some(bound), None) if c.known_mass_at(1.0) > bound => plain(Demand::Mass, 1.0, bound, "requirement"),
            (Some(_), None) => Prepared::Unknown(NO_MASS),
        },
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn limits_have_unique_names_and_say_what_they_compare() {
        let mut names = HashSet::new();
        for limit in LIMITS {
            assert!(names.insert(limit.name), "{} stands twice", limit.name);
            assert!(limit.formula.contains('≤'), "{}", limit.name);
        }
    }
}
