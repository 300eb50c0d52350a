//! Quantities at the edges: text with a unit comes in, an SI number goes on.
//!
//! The one idea of this room: a number with a dimension is never accepted without its unit, and
//! nothing but SI leaves this file inwards. A unit is an expression (`N*m/A`, `g*cm^2`,
//! `N*m/sqrt(W)`) that is reduced to a scale and exponents of the base units; a [`Kind`] says
//! which exponents a quantity must have. The plane angle is carried as a base unit of its own, so
//! that `60 Hz` is not taken for `60 rad/s`.

use std::fmt;

use crate::words::shorten;

/// Exponents of kilogram, metre, second, ampere, kelvin.
type Dims = [f64; 5];

const NONE: Dims = [0.0; 5];

/// What a quantity measures: its exponents, whether an angle may or must appear, its SI unit.
#[derive(Debug, PartialEq)]
pub struct Kind {
    /// Name for messages, e.g. "torque".
    pub name: &'static str,
    dims: Dims,
    angle: Angle,
    /// The SI unit that values of this kind have inside the program.
    pub si: &'static str,
    /// Something a user could have written, for messages.
    pub example: &'static str,
}

/// Which power of the plane angle a unit of this kind has.
#[derive(Debug, PartialEq)]
enum Angle {
    /// Exactly this power (a speed has one).
    Exactly(f64),
    /// This power, or the angle left out (`N*m/rad` and `N*m`).
    Optional(f64),
    /// A frequency: cycles per second, or an angular frequency divided by 2π.
    Frequency,
    /// A temperature: an offset scale is allowed.
    Temperature,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $id:ident = $name:literal, [$kg:expr, $m:expr, $s:expr, $a:expr, $k:expr], $angle:expr, $si:literal, $example:literal;)*) => {
        $($(#[$doc])* pub const $id: Kind = Kind {
            name: $name, dims: [$kg as f64, $m as f64, $s as f64, $a as f64, $k as f64], angle: $angle, si: $si, example: $example,
        };)*
        /// Every kind, for tests.
        pub const KINDS: &[&Kind] = &[$(&$id),*];
    };
}

use Angle::{Exactly, Frequency, Optional, Temperature};

kinds! {
    /// Torque \[N·m\].
    TORQUE = "torque", [1, 2, -2, 0, 0], Exactly(0.0), "N*m", "18 N*m";
    /// Torque per time \[N·m/s\].
    TORQUE_RATE = "torque rate", [1, 2, -3, 0, 0], Exactly(0.0), "N*m/s", "200 N*m/s";
    /// Torque per mass \[N·m/kg\]: what a carried kilogram asks of a joint.
    TORQUE_PER_MASS = "torque per mass", [0, 2, -2, 0, 0], Optional(-1.0), "N*m/kg", "2.1 N*m/kg";
    /// Angular speed \[rad/s\].
    SPEED = "speed", [0, 0, -1, 0, 0], Exactly(1.0), "rad/s", "300 rpm";
    /// Angular acceleration \[rad/s²\].
    ACCELERATION = "angular acceleration", [0, 0, -2, 0, 0], Exactly(1.0), "rad/s^2", "50 rad/s^2";
    /// Angular jerk \[rad/s³\].
    JERK = "angular jerk", [0, 0, -3, 0, 0], Exactly(1.0), "rad/s^3", "900 rad/s^3";
    /// Angle \[rad\].
    ANGLE = "angle", [0, 0, 0, 0, 0], Exactly(1.0), "rad", "30 deg";
    /// Time \[s\].
    TIME = "time", [0, 0, 1, 0, 0], Exactly(0.0), "s", "1.2 s";
    /// Frequency \[Hz\].
    FREQUENCY = "frequency", [0, 0, -1, 0, 0], Frequency, "Hz", "60 Hz";
    /// Mass \[kg\].
    MASS = "mass", [1, 0, 0, 0, 0], Exactly(0.0), "kg", "150 g";
    /// Length \[m\].
    LENGTH = "length", [0, 1, 0, 0, 0], Exactly(0.0), "m", "14.6 mm";
    /// Moment of inertia \[kg·m²\].
    INERTIA = "inertia", [1, 2, 0, 0, 0], Exactly(0.0), "kg*m^2", "90.1 g*cm^2";
    /// Voltage \[V\].
    VOLTAGE = "voltage", [1, 2, -3, -1, 0], Exactly(0.0), "V", "48 V";
    /// Current \[A\].
    CURRENT = "current", [0, 0, 0, 1, 0], Exactly(0.0), "A", "40 A";
    /// Power \[W\].
    POWER = "power", [1, 2, -3, 0, 0], Exactly(0.0), "W", "500 W";
    /// Energy \[J\].
    ENERGY = "energy", [1, 2, -2, 0, 0], Exactly(0.0), "J", "10 J";
    /// Resistance \[Ω\].
    RESISTANCE = "resistance", [1, 2, -3, -2, 0], Exactly(0.0), "ohm", "0.705 ohm";
    /// Inductance \[H\].
    INDUCTANCE = "inductance", [1, 2, -2, -2, 0], Exactly(0.0), "H", "2.559 mH";
    /// Torque constant \[N·m/A\].
    TORQUE_CONSTANT = "torque constant", [1, 2, -2, -1, 0], Optional(-1.0), "N*m/A", "0.105 N*m/A";
    /// Back-EMF constant \[V·s/rad\].
    BACK_EMF_CONSTANT = "back-EMF constant", [1, 2, -2, -1, 0], Exactly(-1.0), "V*s/rad", "0.094 V*s/rad";
    /// Speed constant \[rad/(V·s)\].
    SPEED_CONSTANT = "speed constant", [-1, -2, 2, 1, 0], Exactly(1.0), "rad/(V*s)", "100 rpm/V";
    /// Motor constant \[N·m/√W\].
    MOTOR_CONSTANT = "motor constant", [0.5, 1, -0.5, 0, 0], Exactly(0.0), "N*m/W^0.5", "0.118 N*m/W^0.5";
    /// Torque-specific inertia J/K_T² \[kg·m²·A²/(N·m)²\].
    TORQUE_SPECIFIC_INERTIA = "torque-specific inertia", [-1, -2, 4, 2, 0], Exactly(0.0), "kg*m^2*A^2/(N*m)^2", "0.82 g*(A/N)^2";
    /// Thermal resistance \[K/W\].
    THERMAL_RESISTANCE = "thermal resistance", [-1, -2, 3, 0, 1], Exactly(0.0), "K/W", "2.5 K/W";
    /// Temperature \[K\].
    TEMPERATURE = "temperature", [0, 0, 0, 0, 1], Temperature, "K", "110 degC";
    /// Viscous friction \[N·m·s/rad\].
    VISCOUS_FRICTION = "viscous friction", [1, 2, -1, 0, 0], Optional(-1.0), "N*m*s/rad", "1e-5 N*m*s/rad";
    /// Torsional stiffness \[N·m/rad\].
    STIFFNESS = "stiffness", [1, 2, -2, 0, 0], Optional(-1.0), "N*m/rad", "50 N*m/rad";
    /// Torsional compliance \[rad/(N·m)\].
    COMPLIANCE = "compliance", [-1, -2, 2, 0, 0], Optional(1.0), "rad/(N*m)", "1e-3 rad/(N*m)";
    /// Change of a torque constant with temperature \[N·m/(A·K)\].
    TORQUE_CONSTANT_SLOPE = "torque constant slope", [1, 2, -2, -1, -1], Optional(-1.0), "N*m/(A*K)", "1e-4 N*m/(A*K)";
    /// Change of a resistance with temperature \[Ω/K\].
    RESISTANCE_SLOPE = "resistance slope", [1, 2, -3, -2, -1], Exactly(0.0), "ohm/K", "2 mohm/K";
    /// Force \[N\], of a linear axis.
    FORCE = "force", [1, 1, -2, 0, 0], Exactly(0.0), "N", "30 N";
    /// Mechanical stress \[Pa\].
    STRESS = "stress", [1, -1, -2, 0, 0], Exactly(0.0), "Pa", "70 MPa";
    /// Speed along a line \[m/s\].
    LINEAR_SPEED = "linear speed", [0, 1, -1, 0, 0], Exactly(0.0), "m/s", "0.2 m/s";
    /// Acceleration along a line \[m/s²\].
    LINEAR_ACCELERATION = "linear acceleration", [0, 1, -2, 0, 0], Exactly(0.0), "m/s^2", "3 m/s^2";
    /// Viscous friction along a line \[N·s/m\].
    LINEAR_VISCOUS_FRICTION = "linear viscous friction", [1, 0, -1, 0, 0], Exactly(0.0), "N*s/m", "200 N*s/m";
    /// Drive force per volt of the demand \[N/V\].
    FORCE_PER_VOLTAGE = "force per voltage", [0, -1, 1, 1, 0], Exactly(0.0), "N/V", "35.15 N/V";
    /// Drive force per ampere \[N/A\].
    FORCE_PER_CURRENT = "force per current", [1, 1, -2, -1, 0], Exactly(0.0), "N/A", "12 N/A";
    /// Change of a drive's force per ampere with temperature \[N/(A·K)\].
    FORCE_PER_CURRENT_SLOPE = "force per current slope", [1, 1, -2, -1, -1], Exactly(0.0), "N/(A*K)", "1e-3 N/(A*K)";
    /// Compliance along a line \[m/N\].
    LINEAR_COMPLIANCE = "linear compliance", [-1, 0, 2, 0, 0], Exactly(0.0), "m/N", "1e-6 m/N";
    /// Duty cycle per angle \[1/rad\].
    PER_ANGLE = "gain per angle", [0, 0, 0, 0, 0], Exactly(-1.0), "1/rad", "0.3 1/rad";
    /// Duty cycle per speed \[s/rad\].
    PER_SPEED = "gain per speed", [0, 0, 1, 0, 0], Exactly(-1.0), "s/rad", "0.01 s/rad";
    /// A pure number; `%` is accepted.
    RATIO = "pure number", [0, 0, 0, 0, 0], Exactly(0.0), "1", "0.95";
}

/// Bounds that no machine of this field comes near; of other kinds [`LARGEST`] alone holds. Copper has no resistance left at
/// 39 K in the law by which it is computed.
const BOUNDS: &[(&Kind, [f64; 2])] = &[
    (&TORQUE, [-1e12, 1e12]),
    (&SPEED, [-1e9, 1e9]),
    (&TIME, [-1e12, 1e12]),
    (&MASS, [-1e9, 1e9]),
    (&LENGTH, [-1e6, 1e6]),
    (&INERTIA, [-1e9, 1e9]),
    (&VOLTAGE, [-1e6, 1e6]),
    (&CURRENT, [-1e9, 1e9]),
    (&POWER, [-1e12, 1e12]),
    (&TEMPERATURE, [100.0, 1e4]),
];

impl Kind {
    /// "a torque", "an inertia".
    pub fn with_article(&self) -> String {
        let article = if self.name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
        format!("{article} {}", self.name)
    }

    /// Least and largest plausible value \[SI\]: a number beyond them is a slip of the pen or of the unit.
    pub fn bounds(&self) -> [f64; 2] {
        let known = BOUNDS.iter().find(|(kind, _)| kind.name == self.name);
        known.map_or([-LARGEST, LARGEST], |(_, bounds)| *bounds)
    }

    /// True if a number of it \[SI\] is within its bounds.
    pub fn holds(&self, value: f64) -> bool {
        let [least, most] = self.bounds();
        (least..=most).contains(&value)
    }

    /// Its bounds in words.
    pub fn bounds_words(&self) -> String {
        let number = crate::words::number;
        match self.bounds() {
            [least, most] if least == -most => {
                format!("{} of at most {} {}", self.with_article(), number(most), self.si)
            }
            [least, most] if self.angle == Temperature => {
                let [least, most] = [least, most].map(|kelvin| number(in_unit(kelvin, "degC")));
                format!("{} of {least} to {most} degC", self.with_article())
            }
            [least, most] => format!("{} of {} to {} {}", self.with_article(), number(least), number(most), self.si),
        }
    }

    /// The power of the ampere in its unit: what another unit of current makes of a number.
    pub fn powers_of_ampere(&self) -> f64 {
        self.dims[3]
    }

    /// Whether the quantity has a dimension, so that a bare number is not enough.
    pub fn needs_unit(&self) -> bool {
        *self != RATIO
    }

    fn accepts(&self, unit: &Unit) -> bool {
        let same = self.dims.iter().zip(unit.dims).all(|(a, b)| (a - b).abs() < 1e-9);
        let angle = match self.angle {
            Exactly(power) => unit.angle == power,
            Optional(power) => unit.angle == power || unit.angle == 0.0,
            Frequency => unit.angle == 0.0 || unit.angle == 1.0,
            Temperature => unit.angle == 0.0,
        };
        same && angle
    }
}

/// A unit expression reduced to base units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    scale: f64,
    offset: f64,
    dims: Dims,
    angle: f64,
}

impl Unit {
    const ONE: Unit = Unit { scale: 1.0, offset: 0.0, dims: NONE, angle: 0.0 };

    /// The value in SI units of `value` in this unit, as a quantity of `kind`.
    pub fn to_si(&self, value: f64, kind: &Kind) -> f64 {
        let frequency = kind.angle == Frequency && self.angle == 1.0;
        let scale = if frequency { self.scale / std::f64::consts::TAU } else { self.scale };
        value * scale + self.offset
    }

    /// Factor from this unit to SI, without offset: for differences and tolerances.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    fn times(mut self, other: Unit, power: f64) -> Unit {
        self.scale *= other.scale.powf(power);
        for (mine, theirs) in self.dims.iter_mut().zip(other.dims) {
            *mine += power * theirs;
        }
        self.angle += power * other.angle;
        self
    }
}

/// Why a quantity could not be read.
#[derive(Debug, Clone, PartialEq)]
pub enum UnitError {
    /// The number itself cannot be read, or is not finite.
    NotANumber(String),
    /// A number with a comma in the place of the point.
    DecimalComma(String),
    /// A number with a dimension stands without its unit.
    MissingUnit,
    /// A unit symbol that does not exist, with the nearest that does.
    UnknownUnit(String, Option<&'static str>),
    /// The expression itself is broken (a missing parenthesis, a stray operator).
    BadExpression(String),
    /// The unit exists, but measures something else.
    WrongDimension(String),
}

impl UnitError {
    /// One sentence on what is wrong, given the kind that was wanted.
    pub fn message(&self, kind: &Kind) -> String {
        match self {
            UnitError::NotANumber(text) => {
                format!("`{text}` is not a number (of at most 1e18 in SI units)")
            }
            UnitError::DecimalComma(text) => format!("`{text}` has a decimal comma"),
            UnitError::MissingUnit => format!("{} needs its unit", kind.with_article()),
            UnitError::UnknownUnit(unit, _) => format!("unknown unit `{unit}`"),
            UnitError::BadExpression(text) => format!("`{text}` is not a unit"),
            UnitError::WrongDimension(unit) => format!("`{unit}` is not a unit of {}", kind.name),
        }
    }

    /// What to write instead.
    pub fn help(&self, kind: &Kind) -> String {
        match self {
            UnitError::DecimalComma(text) => {
                format!("numbers have a decimal point: {}", text.replacen(',', ".", 1))
            }
            UnitError::UnknownUnit(_, Some(near)) => {
                format!("did you mean `{near}`? For example \"{}\"", kind.example)
            }
            UnitError::WrongDimension(unit) if kind.angle == Exactly(1.0) && matches!(unit.trim(), "Hz" | "1/s") => {
                format!("write rad/s, rpm or deg/s: {} reads like \"{}\"", kind.with_article(), kind.example)
            }
            _ => format!("{} reads like \"{}\"", kind.with_article(), kind.example),
        }
    }
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message(&RATIO))
    }
}

/// Reads `"18 N*m"` as a quantity of `kind`, in SI.
///
/// # Errors
/// A missing, unknown or wrong unit, and anything that is not a finite number.
///
/// ```
/// use gearwise_model::units::{self, INERTIA, SPEED};
/// assert!((units::quantity("90.1 g*cm^2", &INERTIA).unwrap() - 9.01e-6).abs() < 1e-18);
/// assert!(units::quantity("60 Hz", &SPEED).is_err());
/// ```
pub fn quantity(text: &str, kind: &Kind) -> Result<f64, UnitError> {
    let text = text.trim();
    let split = number_length(text);
    let (number, unit) = text.split_at(split);
    let value = number_value(if split == 0 { text } else { number })?;
    if split > 0 && unit.strip_prefix(',').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
        return Err(UnitError::DecimalComma(shorten(text)));
    }
    let unit = unit.trim();
    if unit.is_empty() {
        return if kind.needs_unit() { Err(UnitError::MissingUnit) } else { Ok(value) };
    }
    finite(unit_of(unit, kind)?.to_si(value, kind), text)
}

/// Reads a difference of two quantities of `kind`, a tolerance, in SI: `"2 degC"` is two kelvin.
///
/// # Errors
/// As of [`quantity`].
///
/// ```
/// use gearwise_model::units::{self, TEMPERATURE};
/// assert_eq!(units::difference("2 degC", &TEMPERATURE).unwrap(), 2.0);
/// ```
pub fn difference(text: &str, kind: &Kind) -> Result<f64, UnitError> {
    let text = text.trim();
    let value = quantity(text, kind)?;
    let unit = text[number_length(text)..].trim();
    let offset = if unit.is_empty() { 0.0 } else { unit_of(unit, kind)?.offset };
    Ok(if offset == 0.0 { value } else { number_value(&text[..number_length(text)])? })
}

/// The number at the beginning of a text, and what follows it: a blank between the two is not needed.
///
/// ```
/// assert_eq!(gearwise_model::units::apart("5kg"), ("5", "kg"));
/// ```
pub fn apart(text: &str) -> (&str, &str) {
    let text = text.trim();
    let (number, unit) = text.split_at(number_length(text));
    (number, unit.trim())
}

/// Reads a bare number: finite, with a decimal point (a decimal comma is refused, not guessed).
///
/// # Errors
/// [`UnitError::NotANumber`].
pub fn number_value(text: &str) -> Result<f64, UnitError> {
    let text = text.trim();
    let plain = text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'+' | b'-' | b'e' | b'E'));
    let value: f64 = if plain { text.parse().unwrap_or(f64::NAN) } else { f64::NAN };
    finite(value, text)
}

/// Numbers beyond this magnitude (SI) are slips, and would leave the range of the arithmetic when
/// squared.
pub(crate) const LARGEST: f64 = 1e18;
/// What must be greater than zero is at least this (SI).
pub const SMALLEST: f64 = 1e-18;

/// Whether a number is one that the program computes with.
pub fn is_sane(value: f64) -> bool {
    value.abs() <= LARGEST
}

fn finite(value: f64, text: &str) -> Result<f64, UnitError> {
    if is_sane(value) { Ok(value) } else { Err(UnitError::NotANumber(shorten(text))) }
}

/// Length in bytes of the number at the start of `text`: digits, sign, point, exponent.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut end = 0;
    while end < bytes.len() {
        let b = bytes[end];
        let sign = matches!(b, b'+' | b'-') && (end == 0 || matches!(bytes[end - 1], b'e' | b'E'));
        let exponent = matches!(b, b'e' | b'E')
            && end > 0
            && bytes.get(end + 1).is_some_and(|n| n.is_ascii_digit() || matches!(n, b'+' | b'-'));
        if !(b.is_ascii_digit() || b == b'.' || sign || exponent) {
            break;
        }
        end += 1;
    }
    end
}

/// Reads a unit expression and checks that it measures `kind`.
///
/// # Errors
/// An unknown symbol, a broken expression, or a unit of something else.
pub fn unit_of(text: &str, kind: &Kind) -> Result<Unit, UnitError> {
    if kind.angle == Temperature {
        match text.trim() {
            "degC" | "°C" | "C" => return Ok(Unit { offset: 273.15, dims: kind.dims, ..Unit::ONE }),
            _ => {}
        }
    }
    let unit = parse_unit(text)?;
    if kind.accepts(&unit) { Ok(unit) } else { Err(UnitError::WrongDimension(shorten(text.trim()))) }
}

/// The scale of the SI unit shown to people, e.g. `display(9.01e-6, "g*cm^2")` is 90.1.
///
/// # Panics
/// If `unit` is not a unit: it is a literal of the program, not input.
pub fn in_unit(si: f64, unit: &str) -> f64 {
    if unit == "degC" {
        return si - 273.15;
    }
    si / parse_unit(unit).expect("a unit literal of the program").scale
}

// symbol, scale, [kg, m, s, A, K], angle
type Symbol = (&'static str, f64, [i8; 5], i8);
const PREFIXES: &[(&str, f64)] =
    &[("n", 1e-9), ("u", 1e-6), ("µ", 1e-6), ("μ", 1e-6), ("m", 1e-3), ("c", 1e-2), ("k", 1e3), ("M", 1e6)];
/// Symbols that may carry a prefix.
const PREFIXED: &[Symbol] = &[
    ("g", 1e-3, [1, 0, 0, 0, 0], 0),
    ("m", 1.0, [0, 1, 0, 0, 0], 0),
    ("s", 1.0, [0, 0, 1, 0, 0], 0),
    ("A", 1.0, [0, 0, 0, 1, 0], 0),
    ("N", 1.0, [1, 1, -2, 0, 0], 0),
    ("Nm", 1.0, [1, 2, -2, 0, 0], 0),
    ("J", 1.0, [1, 2, -2, 0, 0], 0),
    ("W", 1.0, [1, 2, -3, 0, 0], 0),
    ("V", 1.0, [1, 2, -3, -1, 0], 0),
    ("ohm", 1.0, [1, 2, -3, -2, 0], 0),
    ("Ω", 1.0, [1, 2, -3, -2, 0], 0),
    ("H", 1.0, [1, 2, -2, -2, 0], 0),
    ("Wb", 1.0, [1, 2, -2, -1, 0], 0),
    ("Hz", 1.0, [0, 0, -1, 0, 0], 0),
    ("Pa", 1.0, [1, -1, -2, 0, 0], 0),
    ("rad", 1.0, [0, 0, 0, 0, 0], 1),
    ("rpm", std::f64::consts::TAU / 60.0, [0, 0, -1, 0, 0], 1),
];
/// Symbols that stand as they are.
const PLAIN: &[Symbol] = &[
    ("K", 1.0, [0, 0, 0, 0, 1], 0),
    ("degC", 1.0, [0, 0, 0, 0, 1], 0),
    ("min", 60.0, [0, 0, 1, 0, 0], 0),
    ("h", 3600.0, [0, 0, 1, 0, 0], 0),
    ("d", 86_400.0, [0, 0, 1, 0, 0], 0),
    ("deg", std::f64::consts::PI / 180.0, [0, 0, 0, 0, 0], 1),
    ("arcmin", std::f64::consts::PI / 10_800.0, [0, 0, 0, 0, 0], 1),
    ("rev", std::f64::consts::TAU, [0, 0, 0, 0, 0], 1),
    ("lb", 0.453_592_37, [1, 0, 0, 0, 0], 0),
    ("oz", 0.028_349_523_125, [1, 0, 0, 0, 0], 0),
    ("lbf", 4.448_221_615_260_5, [1, 1, -2, 0, 0], 0),
    ("ozf", 0.278_013_850_953_781_2, [1, 1, -2, 0, 0], 0),
    ("kgf", 9.806_65, [1, 1, -2, 0, 0], 0),
    ("in", 0.0254, [0, 1, 0, 0, 0], 0),
    ("ft", 0.3048, [0, 1, 0, 0, 0], 0),
    ("%", 0.01, [0, 0, 0, 0, 0], 0),
    ("1", 1.0, [0, 0, 0, 0, 0], 0),
];
/// Whole units offered when a symbol is not known.
const SUGGESTIONS: &[&str] = &[
    "N*m", "mN*m", "rad/s", "rpm", "deg/s", "rad/s^2", "g*cm^2", "kg*m^2", "kg*cm^2", "ohm", "mohm", "mH", "uH", "V",
    "A", "W", "kg", "g", "mm", "s", "ms", "Hz", "degC", "K", "K/W", "rpm/V", "N*m/A", "mN*m/A", "V*s/rad", "N*m/rad",
    "deg", "rad", "MPa",
];

fn symbol(name: &str) -> Option<Unit> {
    let unit = |(_, scale, dims, angle): &Symbol, factor: f64| Unit {
        scale: scale * factor,
        offset: 0.0,
        dims: dims.map(f64::from),
        angle: f64::from(*angle),
    };
    if let Some(found) = PLAIN.iter().chain(PREFIXED).find(|s| s.0 == name) {
        return Some(unit(found, 1.0));
    }
    PREFIXES.iter().find_map(|(prefix, factor)| {
        let rest = name.strip_prefix(prefix)?;
        PREFIXED.iter().find(|s| s.0 == rest).map(|s| unit(s, *factor))
    })
}

fn unknown(name: &str) -> UnitError {
    let near = crate::words::nearest(name, SUGGESTIONS.iter().copied());
    UnitError::UnknownUnit(shorten(name), near)
}

/// Recursive descent over `unit := factor (('*'|'·'|' '|'/') factor)*`.
fn parse_unit(text: &str) -> Result<Unit, UnitError> {
    let mut parser = UnitParser { rest: text.trim(), depth: 0 };
    let unit = parser.product()?;
    if parser.rest.is_empty() { Ok(unit) } else { Err(UnitError::BadExpression(shorten(text.trim()))) }
}

struct UnitParser<'a> {
    rest: &'a str,
    depth: u32,
}

impl UnitParser<'_> {
    fn product(&mut self) -> Result<Unit, UnitError> {
        self.depth += 1;
        if self.depth > 8 {
            return Err(UnitError::BadExpression(shorten(self.rest)));
        }
        let mut unit = self.factor()?;
        loop {
            self.rest = self.rest.trim_start();
            let power = match self.rest.chars().next() {
                None | Some(')') => break,
                Some('/') => {
                    self.rest = &self.rest[1..];
                    -1.0
                }
                Some(c @ ('*' | '·' | '.')) => {
                    self.rest = &self.rest[c.len_utf8()..];
                    1.0
                }
                Some(_) => 1.0,
            };
            let next = self.factor()?;
            unit = unit.times(next, power);
        }
        self.depth -= 1;
        Ok(unit)
    }

    fn factor(&mut self) -> Result<Unit, UnitError> {
        self.rest = self.rest.trim_start();
        let root = self.rest.strip_prefix("sqrt(").or_else(|| self.rest.strip_prefix("√("));
        let (base, root) = if let Some(rest) = root.or_else(|| self.rest.strip_prefix('(')) {
            self.rest = rest;
            let inner = self.product()?;
            self.rest = self.rest.strip_prefix(')').ok_or_else(|| UnitError::BadExpression(shorten(rest)))?;
            (inner, if root.is_some() { 0.5 } else { 1.0 })
        } else {
            let length = self
                .rest
                .char_indices()
                .find(|(_, c)| !(c.is_alphabetic() || matches!(c, '%' | '°' | '1')))
                .map_or(self.rest.len(), |(at, _)| at);
            let (name, rest) = self.rest.split_at(length);
            if name.is_empty() {
                return Err(UnitError::BadExpression(shorten(self.rest)));
            }
            self.rest = rest;
            (symbol(name).ok_or_else(|| unknown(name))?, 1.0)
        };
        Ok(Unit::ONE.times(base, root * self.power()?))
    }

    fn power(&mut self) -> Result<f64, UnitError> {
        if let Some((power, length)) =
            [("²", 2.0), ("³", 3.0)].iter().find_map(|(s, p)| self.rest.starts_with(s).then_some((*p, s.len())))
        {
            self.rest = &self.rest[length..];
            return Ok(power);
        }
        let Some(rest) = self.rest.strip_prefix('^') else { return Ok(1.0) };
        let (open, rest) = rest.strip_prefix('(').map_or((false, rest), |r| (true, r));
        let length = rest.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-'))).unwrap_or(rest.len());
        let (digits, rest) = rest.split_at(length);
        let power = digits.parse::<f64>().ok().filter(|p| p.abs() <= 9.0);
        let power = power.ok_or_else(|| UnitError::BadExpression(format!("^{digits}")))?;
        self.rest =
            if open { rest.strip_prefix(')').ok_or_else(|| UnitError::BadExpression(shorten(rest)))? } else { rest };
        Ok(power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(text: &str, kind: &Kind, si: f64) {
        let got = quantity(text, kind).unwrap_or_else(|e| panic!("{text}: {e:?}"));
        assert!((got - si).abs() <= 1e-12 * si.abs(), "{text}: {got} is not {si}");
    }

    #[test]
    fn units_convert_to_si() {
        close("18 N*m", &TORQUE, 18.0);
        close("250 mNm", &TORQUE, 0.25);
        close("1 lbf*ft", &TORQUE, 1.355_817_948_331_400_4);
        close("60 rpm", &SPEED, std::f64::consts::TAU);
        close("180 deg/s", &SPEED, std::f64::consts::PI);
        close("90.1 g*cm^2", &INERTIA, 9.01e-6);
        close("90.1 g·cm²", &INERTIA, 9.01e-6);
        close("2.5e-6 kg m^2", &INERTIA, 2.5e-6);
        close("100 rpm/V", &SPEED_CONSTANT, 100.0 * std::f64::consts::TAU / 60.0);
        close("14 mN*m/A", &TORQUE_CONSTANT, 0.014);
        close("9.6 V/krpm", &BACK_EMF_CONSTANT, 9.6 * 60.0 / std::f64::consts::TAU / 1000.0);
        close("0.118 N*m/sqrt(W)", &MOTOR_CONSTANT, 0.118);
        close("0.118 N*m/W^0.5", &MOTOR_CONSTANT, 0.118);
        close("0.82 g*(A/N)^2", &TORQUE_SPECIFIC_INERTIA, 0.82e-3);
        close("110 degC", &TEMPERATURE, 383.15);
        close("60 Hz", &FREQUENCY, 60.0);
        close("2 rad/s", &FREQUENCY, 1.0 / std::f64::consts::PI);
        close("1.19 K/W", &THERMAL_RESISTANCE, 1.19);
        close("95 %", &RATIO, 0.95);
        close("0.95", &RATIO, 0.95);
        close("2559 µH", &INDUCTANCE, 2.559e-3);
    }

    #[test]
    fn every_example_is_a_quantity_of_its_kind() {
        for kind in KINDS {
            assert!(quantity(kind.example, kind).is_ok(), "{}: {}", kind.name, kind.example);
            assert!(kind.si == "1" || unit_of(kind.si, kind).is_ok(), "{}: {}", kind.name, kind.si);
        }
    }

    #[test]
    fn what_is_not_a_quantity_is_refused() {
        assert_eq!(quantity("18", &TORQUE), Err(UnitError::MissingUnit));
        assert!(matches!(quantity("60 Hz", &SPEED), Err(UnitError::WrongDimension(_))));
        assert!(matches!(quantity("3 N*m", &INERTIA), Err(UnitError::WrongDimension(_))));
        assert!(matches!(quantity("nan N*m", &TORQUE), Err(UnitError::NotANumber(_))));
        assert_eq!(quantity("1,5 N*m", &TORQUE), Err(UnitError::DecimalComma("1,5 N*m".into())));
        assert!(matches!(quantity("1e999 N*m", &TORQUE), Err(UnitError::NotANumber(_))));
        assert!(matches!(quantity("5 (N*m", &TORQUE), Err(UnitError::BadExpression(_))));
        assert!(matches!(quantity("5 ((((((((((m))))))))))", &LENGTH), Err(UnitError::BadExpression(_))));
        assert_eq!(quantity("5 gcm2", &INERTIA), Err(UnitError::UnknownUnit("gcm".into(), Some("g*cm^2"))));
        assert_eq!(quantity("5 degC", &THERMAL_RESISTANCE), Err(UnitError::WrongDimension("degC".into())));
    }
}
