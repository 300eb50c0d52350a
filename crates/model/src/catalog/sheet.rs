//! A motor's data sheet as printed: its numbers in the sheet's own conventions.
//!
//! [`FIELDS`] is the one list of numeric columns: a new one is one line here; reader, writers, audit, locks and
//! documentation follow.

use super::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding, has_words,
};
use super::offer::{Offer, Sold};
use super::row::{Convention, Field, States};
use crate::input::Range;
use crate::units;

/// A printed number in SI (in the sheet's convention) and its ±, where one is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// The number, SI.
    pub value: f64,
    /// Its tolerance (half-width of the interval that the source states), in the same unit.
    pub tolerance: Option<f64>,
}

impl Printed {
    /// A number without a ±.
    pub const fn exact(value: f64) -> Printed {
        Printed { value, tolerance: None }
    }

    /// The number times another one.
    #[must_use]
    pub fn times(self, by: f64) -> Printed {
        Printed { value: self.value * by, tolerance: self.tolerance.map(|t| t * by.abs()) }
    }

    /// Tolerance over value; `None` where no tolerance is given.
    pub fn relative_tolerance(&self) -> Option<f64> {
        self.tolerance.filter(|_| self.value != 0.0).map(|t| t / self.value.abs())
    }
}

/// The diameter of the tube that a part goes through along its axis \[m\]: its outer diameter, of one that is not round the
/// diagonal of width and height, of one that says both (a flange on a round body) the larger. `None` where neither is known.
///
/// ```
/// use gearwise_model::catalog::{Printed, across};
/// let mm = |value: f64| Some(Printed::exact(value));
/// assert_eq!(across(None, mm(30.0), mm(40.0)), mm(50.0));
/// assert_eq!(across(mm(42.0), mm(30.0), mm(40.0)), mm(50.0));
/// assert_eq!(across(mm(42.0), mm(30.0), None), mm(42.0));
/// ```
pub fn across(outer: Option<Printed>, width: Option<Printed>, height: Option<Printed>) -> Option<Printed> {
    let diagonal = width.zip(height).map(|(w, h)| {
        let value = w.value.hypot(h.value);
        let spread = w.value * w.tolerance.unwrap_or(0.0) + h.value * h.tolerance.unwrap_or(0.0);
        Printed { value, tolerance: w.tolerance.or(h.tolerance).map(|_| spread / value) }
    });
    match (outer, diagonal) {
        (Some(outer), Some(diagonal)) => Some(if diagonal.value > outer.value { diagonal } else { outer }),
        (outer, diagonal) => outer.or(diagonal),
    }
}

/// Where a number comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SourceKind {
    /// The maker's data sheet.
    Datasheet,
    /// Someone measured it and published it.
    Measured,
    /// Computed from other published numbers.
    Derived,
    /// Quoted at second hand.
    Secondary,
}

impl SourceKind {
    /// Every kind with the word a catalogue uses for it.
    pub const NAMES: &[(&str, SourceKind)] = &[
        ("datasheet", SourceKind::Datasheet),
        ("measured", SourceKind::Measured),
        ("derived", SourceKind::Derived),
        ("secondary", SourceKind::Secondary),
    ];
}

has_words!(SourceKind);

/// The conventions that a row declares for its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conventions {
    /// Brushless or brushed.
    pub commutation: Commutation,
    /// Between what resistance and inductance are.
    pub terminals: Terminals,
    /// How the windings are connected, where said.
    pub winding: Option<Winding>,
    /// What ampere means.
    pub current: CurrentConvention,
    /// What the back-EMF constant is measured between, where there is one.
    pub back_emf: Option<BackEmfConvention>,
    /// What voltage the speed constant refers to, where there is one.
    pub speed_constant: Option<SpeedConstantConvention>,
    /// What single columns state otherwise.
    pub own: OwnConventions,
}

/// Conventions of single columns that are not the row's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OwnConventions {
    /// Of the resistance.
    pub resistance: Option<Terminals>,
    /// Of the inductance.
    pub inductance: Option<Terminals>,
    /// Of the torque constant.
    pub torque_constant: Option<CurrentConvention>,
    /// Of the continuous current.
    pub continuous_current: Option<CurrentConvention>,
    /// Of the peak current.
    pub peak_current: Option<CurrentConvention>,
}

impl Conventions {
    /// Between what the resistance is.
    pub fn of_resistance(&self) -> Terminals {
        self.own.resistance.unwrap_or(self.terminals)
    }

    /// Between what the inductance is.
    pub fn of_inductance(&self) -> Terminals {
        self.own.inductance.unwrap_or(self.terminals)
    }

    /// What ampere means in the torque constant.
    pub fn of_torque_constant(&self) -> CurrentConvention {
        self.own.torque_constant.unwrap_or(self.current)
    }

    /// What ampere means in the continuous current.
    pub fn of_continuous_current(&self) -> CurrentConvention {
        self.own.continuous_current.unwrap_or(self.current)
    }

    /// What ampere means in the peak current.
    pub fn of_peak_current(&self) -> CurrentConvention {
        self.own.peak_current.unwrap_or(self.current)
    }
}

macro_rules! sheet {
    ($($(#[doc = $doc:literal])* $name:ident: $kind:ident, $range:ident $(, $states:ident)?;)*) => {
        /// Everything a row can say in numbers; `None` is unknown, never zero.
        #[derive(Debug, Clone, Default, PartialEq)]
        pub struct Sheet {
            $($(#[doc = $doc])* pub $name: Option<Printed>,)*
            /// What it costs.
            pub offer: Offer,
        }

        /// The numeric columns of a motor catalogue.
        pub const FIELDS: &[Field] = &[
            $(Field {
                name: stringify!($name),
                tolerance: Some(concat!(stringify!($name), "_tolerance")),
                about: concat!($($doc),*),
                kind: &units::$kind,
                range: Range::$range,
                states: sheet!(@states $($states)?),
                get: |sheet| sheet.$name,
                set: |sheet, printed| sheet.$name = Some(printed),
            },)*
            Field::PRICE,
            Field::PRICE_QUANTITY,
            Field::LEAD_TIME,
        ];

        impl Sold for Sheet {
            fn offer(&self) -> &Offer {
                &self.offer
            }

            fn offer_mut(&mut self) -> &mut Offer {
                &mut self.offer
            }
        }
    };
    (@states) => { States::Nothing };
    (@states $states:ident) => { States::Convention(Convention::$states) };
}

sheet! {
    /// Resistance at the reference temperature \[Ω\], symbol R.
    resistance: RESISTANCE, Positive, Resistance;
    /// Inductance \[H\], symbol L.
    inductance: INDUCTANCE, NonNegative, Inductance;
    /// Torque constant \[N·m/A\], symbol K_T.
    torque_constant: TORQUE_CONSTANT, Positive, TorqueConstant;
    /// Back-EMF constant \[V·s/rad\], symbol K_B.
    back_emf_constant: BACK_EMF_CONSTANT, Positive, BackEmf;
    /// Speed constant \[rad/(V·s)\], symbol Kv.
    speed_constant: SPEED_CONSTANT, Positive, SpeedConstant;
    /// Motor constant \[N·m/√W\], symbol K_M.
    motor_constant: MOTOR_CONSTANT, Positive;
    /// Responsiveness metric as printed \[s\], symbol S_M.
    responsiveness_metric: TIME, Positive;
    /// Torque-specific inertia as printed \[kg·m²·A²/(N·m)²\], symbol S_T.
    torque_specific_inertia: TORQUE_SPECIFIC_INERTIA, Positive;
    /// Rotor inertia \[kg·m²\], symbol J_m.
    rotor_inertia: INERTIA, Positive;
    /// Mass of the rotor \[kg\].
    rotor_mass: MASS, Positive;
    /// Mass of the motor \[kg\], symbol m.
    mass: MASS, Positive;
    /// Radius of the air gap \[m\], symbol r_g.
    gap_radius: LENGTH, Positive;
    /// Outer diameter \[m\].
    outer_diameter: LENGTH, Positive;
    /// Axial length \[m\].
    length: LENGTH, Positive;
    /// Nominal voltage that the no-load and stall numbers refer to \[V\].
    voltage: VOLTAGE, Positive;
    /// Continuous current \[A\].
    continuous_current: CURRENT, Positive, ContinuousCurrent;
    /// Current that must never be exceeded \[A\].
    peak_current: CURRENT, Positive, PeakCurrent;
    /// Current against the magnets that they bear at their hottest \[A\].
    demagnetization_current: CURRENT, Positive;
    /// Continuous torque \[N·m\].
    continuous_torque: TORQUE, Positive;
    /// Torque that must never be exceeded \[N·m\].
    peak_torque: TORQUE, Positive;
    /// Share of K_T times the current that the motor gives at its peak torque, as iron saturates: 0.8 of one at 20 % deviation from
    /// linearity.
    peak_torque_linearity: RATIO, Fraction;
    /// Stall torque at the nominal voltage \[N·m\].
    stall_torque: TORQUE, Positive;
    /// Speed that must never be exceeded \[rad/s\].
    max_speed: SPEED, Positive;
    /// No-load speed at the nominal voltage \[rad/s\].
    no_load_speed: SPEED, Positive;
    /// No-load current at the nominal voltage \[A\].
    no_load_current: CURRENT, NonNegative;
    /// Mechanical time constant \[s\].
    mechanical_time_constant: TIME, Positive;
    /// Thermal resistance from winding to housing \[K/W\].
    thermal_resistance_winding_housing: THERMAL_RESISTANCE, Positive;
    /// Thermal resistance from housing to ambient \[K/W\].
    thermal_resistance_housing_ambient: THERMAL_RESISTANCE, Positive;
    /// Thermal time constant of the winding \[s\].
    thermal_time_constant_winding: TIME, Positive;
    /// Thermal time constant of the housing \[s\].
    thermal_time_constant_housing: TIME, Positive;
    /// Highest winding temperature \[K\].
    max_winding_temperature: TEMPERATURE, Positive;
    /// Winding temperature that the resistance refers to \[K\].
    reference_temperature: TEMPERATURE, Positive;
    /// Coulomb friction of the motor \[N·m\], symbol c.
    coulomb_friction: TORQUE, NonNegative;
    /// Viscous friction of the motor \[N·m·s/rad\], symbol b.
    viscous_friction: VISCOUS_FRICTION, NonNegative;
}
