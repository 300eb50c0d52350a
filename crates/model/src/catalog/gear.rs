//! A gearbox of the catalogue.

use super::convention::has_words;
use super::drag::Friction;
use super::offer::{Offer, Sold};
use super::row::{Field, Side, States};
use super::sheet::{Printed, SourceKind, across};
use crate::input::Range;
use crate::units;

/// How a gear reduces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GearKind {
    /// Planetary.
    Planetary,
    /// Strain wave.
    StrainWave,
    /// Cycloidal.
    Cycloidal,
    /// Spur.
    Spur,
    /// Belt.
    Belt,
    /// No gear: the motor drives the output.
    Direct,
}

impl GearKind {
    /// Every kind with the word a catalogue uses for it.
    pub const NAMES: &[(&str, GearKind)] = &[
        ("planetary", GearKind::Planetary),
        ("strain_wave", GearKind::StrainWave),
        ("cycloidal", GearKind::Cycloidal),
        ("spur", GearKind::Spur),
        ("belt", GearKind::Belt),
        ("direct", GearKind::Direct),
    ];
}

/// What a rated life is: how many of many gears are still good after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LifeQuantile {
    /// Nine in ten.
    L10,
    /// Half of them.
    L50,
}

/// L50 of a strain wave gear's bearing over its L10: Harmonic Drive prints 7000 and 35 000 h, and 10 000 and 50 000 h.
const L50_PER_L10: f64 = 5.0;

impl LifeQuantile {
    /// Both with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, LifeQuantile)] = &[("L10", LifeQuantile::L10), ("L50", LifeQuantile::L50)];

    /// The L10 of a life of this quantile, in the unit of the life.
    pub fn l10(self, life: f64) -> f64 {
        match self {
            LifeQuantile::L10 => life,
            LifeQuantile::L50 => life / L50_PER_L10,
        }
    }
}

/// What a gear's continuous torque is a limit of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContinuousTorque {
    /// At it, and at the rated speed, the gear has its rated life.
    RatedLife,
    /// At it the gear gets as warm as it may.
    Thermal,
}

impl ContinuousTorque {
    /// Both with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, ContinuousTorque)] =
        &[("rated_life", ContinuousTorque::RatedLife), ("thermal", ContinuousTorque::Thermal)];
}

has_words!(GearKind, LifeQuantile, ContinuousTorque);

/// What a gear may bear beyond its continuous and its peak torque: SI, torques at the output, speeds at the input.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GearRatings {
    /// Largest average torque \[N·m\], by the maker's rule ∛(mean(|ω||τ|³)/mean|ω|).
    pub average_torque: Option<f64>,
    /// Largest torque of a few shocks in a life \[N·m\].
    pub momentary_peak_torque: Option<f64>,
    /// Torque at which teeth skip \[N·m\].
    pub ratcheting_torque: Option<f64>,
    /// Largest average speed at the input \[rad/s\].
    pub average_input_speed: Option<f64>,
    /// Speed at the input that the rated life holds at \[rad/s\].
    pub rated_speed: Option<f64>,
    /// Rated life \[s\].
    pub rated_life: Option<f64>,
    /// What that life is.
    pub life_quantile: Option<LifeQuantile>,
    /// What the continuous torque is a limit of.
    pub continuous_torque_is: Option<ContinuousTorque>,
}

impl GearRatings {
    /// The point that its life is rated at, of a gear with a continuous torque \[N·m\].
    ///
    /// # Errors
    /// What is not known.
    pub fn rated(&self, continuous: Option<f64>) -> Result<Rated, &'static str> {
        let (Some(life), Some(speed), Some(torque)) = (self.rated_life, self.rated_speed, continuous) else {
            return Err("the gear's rated life, its rated speed or its continuous torque is not known");
        };
        if self.continuous_torque_is != Some(ContinuousTorque::RatedLife) {
            return Err("the gear's continuous torque is not said to be that of its rated life");
        }
        let quantile = self.life_quantile.ok_or("it is not said whether the gear's rated life is L10 or L50")?;
        Ok(Rated { life: quantile.l10(life), speed, torque })
    }

    /// Torques and speeds of a gear that contradict each other: the name and the value of one that may not be more than the
    /// next, those of the next, and the unit that they are told in.
    pub fn contradictions(
        &self,
        continuous_torque: Option<f64>,
        peak_torque: Option<f64>,
        max_input_speed: Option<f64>,
    ) -> Vec<([(&'static str, f64); 2], &'static str)> {
        let torques = [
            ("continuous_torque", continuous_torque),
            ("average_torque", self.average_torque),
            ("peak_torque", peak_torque),
            ("momentary_peak_torque", self.momentary_peak_torque),
            ("ratcheting_torque", self.ratcheting_torque),
        ];
        let speeds = [("average_input_speed", self.average_input_speed), ("max_input_speed", max_input_speed)];
        let of = |ratings: &[(&'static str, Option<f64>)], unit: &'static str| {
            let known: Vec<(&'static str, f64)> =
                ratings.iter().filter_map(|(name, value)| Some((*name, (*value)?))).collect();
            let pairs = known.windows(2).filter(|pair| pair[0].1 > pair[1].1);
            pairs.map(|pair| ([pair[0], pair[1]], unit)).collect::<Vec<_>>()
        };
        [of(&torques, "N*m"), of(&speeds, "rpm")].concat()
    }

    /// Whether the average torque replaces the continuous torque, which then is the torque of the rated life and no limit by
    /// itself.
    pub fn average_replaces_continuous(&self) -> bool {
        self.average_torque.is_some() && self.continuous_torque_is == Some(ContinuousTorque::RatedLife)
    }
}

/// The point that a gear's life is rated at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rated {
    /// L10 \[s\].
    pub life: f64,
    /// Speed at the input \[rad/s\].
    pub speed: f64,
    /// Torque at the output \[N·m\].
    pub torque: f64,
}

/// Friction of a gear at its input, of its starting torque \[N·m\] and its running torque without load \[N·m\] at a speed
/// \[rad/s\]: c_g = T_s, b_g = (T_0 − T_s)/n_0. Of one of the two alone all is Coulomb friction; so it is where running
/// takes no more than starting.
pub fn no_load_friction(starting: Option<f64>, running: Option<f64>, speed: Option<f64>) -> Friction {
    match (starting, running, speed) {
        (Some(starting), Some(running), Some(speed)) if running > starting => {
            Friction { coulomb: starting, viscous: (running - starting) / speed }
        }
        (starting, running, _) => Friction { coulomb: starting.or(running).unwrap_or(0.0), viscous: 0.0 },
    }
}

/// A gearbox: SI, torques at the output, inertia and speed at the input.
#[derive(Debug, Clone, PartialEq)]
pub struct Gear {
    /// Unique name.
    pub id: String,
    /// Who makes it.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// The family that it is a point of; empty for a gear that can be bought.
    pub family: String,
    /// The length of the motor that its family is made for, where the family says it \[m\].
    pub motor_length: Option<f64>,
    /// How it reduces.
    pub kind: GearKind,
    /// Reduction, N.
    pub ratio: f64,
    /// Number of stages.
    pub stages: Option<u32>,
    /// Efficiency when the motor drives, η.
    pub efficiency: Option<f64>,
    /// Efficiency when the load drives, η_b.
    pub backdrive_efficiency: Option<f64>,
    /// Mass \[kg\].
    pub mass: Option<f64>,
    /// Outer diameter of a round one \[m\].
    pub outer_diameter: Option<f64>,
    /// Length along the axis \[m\].
    pub length: Option<f64>,
    /// Width of one that is not round, across the axis \[m\].
    pub width: Option<f64>,
    /// Height of one that is not round, across the axis \[m\].
    pub height: Option<f64>,
    /// Moment of inertia at the input \[kg·m²\], J_g.
    pub inertia: Option<f64>,
    /// Output torque that can be carried for ever \[N·m\].
    pub continuous_torque: Option<f64>,
    /// Largest output torque \[N·m\].
    pub peak_torque: Option<f64>,
    /// Largest speed at the input \[rad/s\].
    pub max_input_speed: Option<f64>,
    /// Backlash at the output \[rad\].
    pub backlash: Option<f64>,
    /// Torsional stiffness at the output \[N·m/rad\].
    pub stiffness: Option<f64>,
    /// Torque at the input that sets it going without load \[N·m\], T_s.
    pub starting_torque: Option<f64>,
    /// Torque at the input that keeps it going without load \[N·m\], T_0.
    pub no_load_torque: Option<f64>,
    /// Speed at the input that this holds at \[rad/s\], n_0.
    pub no_load_torque_speed: Option<f64>,
    /// Torque at the output that sets it going, with nothing at the input \[N·m\], T_b.
    pub backdriving_torque: Option<f64>,
    /// Torque at the output that `efficiency` holds at \[N·m\], τ_η.
    pub efficiency_torque: Option<f64>,
    /// Speed at the input that `efficiency` holds at \[rad/s\], n_η.
    pub efficiency_speed: Option<f64>,
    /// What else it may bear.
    pub ratings: GearRatings,
    /// Patterns of motor ids that it is made for; empty where nothing is said.
    pub fits: Vec<String>,
    /// What it costs.
    pub offer: Offer,
    /// Where the numbers come from.
    pub source: String,
    /// Day, month or year of the source, as 2026-11-01; of one without a date the day on which it was read. Empty: not said.
    pub source_date: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// What the reader of the row should know.
    pub note: String,
}

impl Sold for Gear {
    fn offer(&self) -> &Offer {
        &self.offer
    }

    fn offer_mut(&mut self) -> &mut Offer {
        &mut self.offer
    }
}

impl Gear {
    /// Its diameter across the axis \[m\]: see [`across`].
    pub fn across(&self) -> Option<f64> {
        let exact = |value: Option<f64>| value.map(Printed::exact);
        across(exact(self.outer_diameter), exact(self.width), exact(self.height)).map(|across| across.value)
    }

    /// What it takes without load at its input, as the model has it: nothing where the row does not say at which load its
    /// efficiency holds, which then has all of the loss in it.
    pub fn no_load(&self) -> Friction {
        if self.loss_is_in_efficiency() { Friction::default() } else { self.printed_friction() }
    }

    /// What it takes without load at its input, as printed.
    pub fn printed_friction(&self) -> Friction {
        no_load_friction(self.starting_torque, self.no_load_torque, self.no_load_torque_speed)
    }

    /// Whether it says a torque without load, but not at which load its efficiency holds.
    pub fn loss_is_in_efficiency(&self) -> bool {
        let says = self.starting_torque.is_some() || self.no_load_torque.is_some();
        says && self.efficiency.is_some() && self.efficiency_torque.is_none()
    }

    /// Efficiency of the load alone when the motor drives, η_∞: 1/η_∞ = 1/η − N T_0(n_η)/τ_η. More than one where the row
    /// contradicts itself.
    pub fn load_efficiency(&self) -> Option<f64> {
        let efficiency = self.efficiency?;
        let Some(torque) = self.efficiency_torque else { return Some(efficiency) };
        Some(1.0 / (1.0 / efficiency - self.ratio * self.running_torque_at_efficiency() / torque))
    }

    /// T_0(n_η), what it takes at its input without load at the speed that its efficiency holds at \[N·m\].
    pub fn running_torque_at_efficiency(&self) -> f64 {
        let Friction { coulomb, viscous } = self.printed_friction();
        coulomb + viscous * self.efficiency_speed.unwrap_or(0.0)
    }

    /// Efficiency of the load alone when the load drives, η_b: as printed, else N T_s/T_b where the torques without load
    /// count and say it; `None` where it follows from the other efficiency.
    pub fn load_backdrive_efficiency(&self) -> Option<f64> {
        let by_torques =
            || self.backdriving_ratio().filter(|_| !self.loss_is_in_efficiency()).map(|ratio| ratio.min(1.0));
        self.backdrive_efficiency.or_else(by_torques)
    }

    /// `N T_s/T_b`: what arrives at the input of a torque that sets the gear going from its output.
    pub fn backdriving_ratio(&self) -> Option<f64> {
        Some(self.ratio * self.starting_torque? / self.backdriving_torque?)
    }

    /// Coulomb friction at the input at rest \[N·m\], where the row says one.
    pub fn friction_at_rest(&self) -> Option<f64> {
        self.starting_torque.or(self.no_load_torque)
    }

    /// Whether the gear can be mounted on the motor: `None` where the catalogue does not say.
    pub fn fits(&self, motor_id: &str) -> Option<bool> {
        if self.fits.is_empty() { None } else { Some(self.fits.iter().any(|p| matches_pattern(p, motor_id))) }
    }
}

/// Whether `text` matches a pattern in which `*` stands for any run of characters.
///
/// ```
/// use gearwise_model::catalog::matches_pattern;
/// assert!(matches_pattern("maxon-*-574741", "maxon-ec-i-52-574741"));
/// assert!(!matches_pattern("maxon-*", "faulhaber-3274g024bp4"));
/// ```
pub fn matches_pattern(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let mut last = None;
    for part in parts {
        if let Some(previous) = last.replace(part) {
            match rest.find(previous) {
                Some(at) => rest = &rest[at + previous.len()..],
                None => return false,
            }
        }
    }
    match last {
        None => rest.is_empty(),
        Some(last) => rest.ends_with(last),
    }
}

/// Whether a pattern is of a row with this id and maker, that in letters of either case.
pub fn is_named(pattern: &str, id: &str, maker: &str) -> bool {
    matches_pattern(pattern, id) || matches_pattern(&pattern.to_lowercase(), &maker.to_lowercase())
}

/// One numeric column of a gear catalogue; the number of stages, a whole one, stands beside them.
pub type GearField = Field<Gear>;

macro_rules! gear_fields {
    ($($name:ident, $about:literal, $kind:ident, $range:ident, $states:expr, $get:expr, $set:expr;)*) => {
        /// The numeric columns of a gear catalogue: what is read, written and kept by locks.
        pub const GEAR_FIELDS: &[GearField] = &[
            $(Field {
                name: stringify!($name),
                tolerance: None,
                about: $about,
                kind: &units::$kind,
                range: Range::$range,
                states: $states,
                get: |g| {
                    let get: fn(&Gear) -> Option<f64> = $get;
                    get(g).map(Printed::exact)
                },
                set: |g, printed| {
                    let set: fn(&mut Gear, f64) = $set;
                    set(g, printed.value);
                },
            },)*
            Field::PRICE,
            Field::PRICE_QUANTITY,
            Field::LEAD_TIME,
        ];
    };
}

/// At the motor; at the output the same number times N to this power.
const fn at_motor(power: i32) -> States {
    States::Side { kept: Side::Motor, power: Some(power) }
}

/// At the output; at the motor the same number times N to this power.
const fn at_output(power: i32) -> States {
    States::Side { kept: Side::Output, power: Some(power) }
}

/// Of one side alone.
const fn only(kept: Side) -> States {
    States::Side { kept, power: None }
}

// `ratio` comes first: what is given at the other side is converted by it.
gear_fields! {
    ratio, "reduction, N", RATIO, Positive, States::Nothing, |g| Some(g.ratio), |g, v| g.ratio = v;
    efficiency, "when the motor drives, η", RATIO, Fraction, States::Nothing,
        |g| g.efficiency, |g, v| g.efficiency = Some(v);
    backdrive_efficiency, "when the load drives, η_b; 2 − 1/η by default; at most 1", RATIO, Any, States::Nothing,
        |g| g.backdrive_efficiency, |g, v| g.backdrive_efficiency = Some(v);
    mass, "of the gear", MASS, NonNegative, States::Nothing, |g| g.mass, |g, v| g.mass = Some(v);
    outer_diameter, "across the axis, of a round one", LENGTH, Positive, States::Nothing,
        |g| g.outer_diameter, |g, v| g.outer_diameter = Some(v);
    length, "along the axis, without the shaft", LENGTH, Positive, States::Nothing,
        |g| g.length, |g, v| g.length = Some(v);
    width, "across the axis, of one that is not round; a limit on the diameter takes the diagonal of width and height",
        LENGTH, Positive, States::Nothing, |g| g.width, |g, v| g.width = Some(v);
    height, "across the axis, of one that is not round", LENGTH, Positive, States::Nothing,
        |g| g.height, |g, v| g.height = Some(v);
    inertia, "at the input, J_g", INERTIA, NonNegative, at_motor(-2), |g| g.inertia, |g, v| g.inertia = Some(v);
    continuous_torque, "at the output, continuous", TORQUE, Positive, only(Side::Output),
        |g| g.continuous_torque, |g, v| g.continuous_torque = Some(v);
    peak_torque, "at the output, largest", TORQUE, Positive, only(Side::Output),
        |g| g.peak_torque, |g, v| g.peak_torque = Some(v);
    max_input_speed, "at the input", SPEED, Positive, only(Side::Motor),
        |g| g.max_input_speed, |g, v| g.max_input_speed = Some(v);
    backlash, "at the output", ANGLE, NonNegative, at_output(-1), |g| g.backlash, |g, v| g.backlash = Some(v);
    stiffness, "torsional, at the output", STIFFNESS, Positive, at_output(2),
        |g| g.stiffness, |g, v| g.stiffness = Some(v);
    starting_torque, "at the input, sets it going without load, T_s", TORQUE, NonNegative, only(Side::Motor),
        |g| g.starting_torque, |g, v| g.starting_torque = Some(v);
    no_load_torque, "at the input, keeps it going without load, T_0", TORQUE, NonNegative, only(Side::Motor),
        |g| g.no_load_torque, |g, v| g.no_load_torque = Some(v);
    no_load_torque_speed, "at the input, that `no_load_torque` holds at", SPEED, Positive, only(Side::Motor),
        |g| g.no_load_torque_speed, |g, v| g.no_load_torque_speed = Some(v);
    backdriving_torque, "at the output, sets it going with nothing at the input, T_b", TORQUE, Positive,
        only(Side::Output), |g| g.backdriving_torque, |g, v| g.backdriving_torque = Some(v);
    efficiency_torque, "at the output, that `efficiency` holds at", TORQUE, Positive, only(Side::Output),
        |g| g.efficiency_torque, |g, v| g.efficiency_torque = Some(v);
    efficiency_speed, "at the input, that `efficiency` holds at", SPEED, Positive, only(Side::Motor),
        |g| g.efficiency_speed, |g, v| g.efficiency_speed = Some(v);
    average_torque, "at the output, largest average", TORQUE, Positive, only(Side::Output),
        |g| g.ratings.average_torque, |g, v| g.ratings.average_torque = Some(v);
    momentary_peak_torque, "at the output, of a few shocks in a life", TORQUE, Positive, only(Side::Output),
        |g| g.ratings.momentary_peak_torque, |g, v| g.ratings.momentary_peak_torque = Some(v);
    ratcheting_torque, "at the output, at which teeth skip", TORQUE, Positive, only(Side::Output),
        |g| g.ratings.ratcheting_torque, |g, v| g.ratings.ratcheting_torque = Some(v);
    average_input_speed, "at the input, largest average", SPEED, Positive, only(Side::Motor),
        |g| g.ratings.average_input_speed, |g, v| g.ratings.average_input_speed = Some(v);
    rated_speed, "at the input, that `rated_life` holds at", SPEED, Positive, only(Side::Motor),
        |g| g.ratings.rated_speed, |g, v| g.ratings.rated_speed = Some(v);
    rated_life, "at `continuous_torque` and `rated_speed`", TIME, Positive, States::Nothing,
        |g| g.ratings.rated_life, |g, v| g.ratings.rated_life = Some(v);
}
