//! The numbers of a module's row. [`MODULE_FIELDS`] is the one list of them.

use crate::catalog::offer::{Offer, Sold};
use crate::catalog::row::{Field, States};
use crate::catalog::sheet::Printed;
use crate::input::Range;
use crate::units;

macro_rules! sheet {
    ($($(#[doc = $doc:literal])* $name:ident: $kind:ident, $range:ident;)*) => {
        /// Everything a module's row can say in numbers; `None` is unknown, never zero. Torques, speeds and stiffness are those
        /// of the output flange.
        #[derive(Debug, Clone, Default, PartialEq)]
        pub struct ModuleSheet {
            $($(#[doc = $doc])* pub $name: Option<Printed>,)*
            /// What it costs.
            pub offer: Offer,
        }

        /// The numeric columns of a catalogue of modules.
        pub const MODULE_FIELDS: &[Field<ModuleSheet>] = &[
            $(Field {
                name: stringify!($name),
                tolerance: Some(concat!(stringify!($name), "_tolerance")),
                about: concat!($($doc),*),
                kind: &units::$kind,
                range: Range::$range,
                states: States::Nothing,
                get: |sheet| sheet.$name,
                set: |sheet, printed| sheet.$name = Some(printed),
            },)*
            Field::PRICE,
            Field::PRICE_QUANTITY,
            Field::LEAD_TIME,
        ];

        impl Sold for ModuleSheet {
            fn offer(&self) -> &Offer {
                &self.offer
            }

            fn offer_mut(&mut self) -> &mut Offer {
                &mut self.offer
            }
        }
    };
}

sheet! {
    /// Reduction of the gear, N.
    ratio: RATIO, Positive;
    /// Torque that must never be exceeded \[N·m\].
    peak_torque: TORQUE, Positive;
    /// Torque that it gives for ever \[N·m\].
    rated_torque: TORQUE, Positive;
    /// Torque at standstill at `voltage` \[N·m\].
    stall_torque: TORQUE, Positive;
    /// Speed of the rated point \[rad/s\].
    rated_speed: SPEED, Positive;
    /// Speed without load at `voltage` \[rad/s\].
    no_load_speed: SPEED, Positive;
    /// Power of the rated point \[W\]: see `rated_power_is`.
    rated_power: POWER, Positive;
    /// Voltage that curve, no-load and rated speed refer to \[V\].
    voltage: VOLTAGE, Positive;
    /// Least supply voltage \[V\].
    min_voltage: VOLTAGE, Positive;
    /// Largest supply voltage \[V\].
    max_voltage: VOLTAGE, Positive;
    /// Speed of the overload test \[rad/s\].
    overload_speed: SPEED, Positive;
    /// Inertia of rotor and gear together \[kg·m²\], at the side that `armature_side` says.
    armature: INERTIA, Positive;
    /// Inertia of the bare rotor \[kg·m²\].
    rotor_inertia: INERTIA, Positive;
    /// Friction at rest \[N·m\].
    static_friction: TORQUE, NonNegative;
    /// Coulomb friction while it moves \[N·m\].
    dynamic_friction: TORQUE, NonNegative;
    /// Viscous friction \[N·m·s/rad\].
    viscous_friction: VISCOUS_FRICTION, NonNegative;
    /// Torque at the flange that sets it going from there \[N·m\].
    backdriving_torque: TORQUE, Positive;
    /// Torque constant \[N·m/A\].
    torque_constant: TORQUE_CONSTANT, Positive;
    /// Back-EMF constant \[V·s/rad\].
    back_emf_constant: BACK_EMF_CONSTANT, Positive;
    /// Speed constant \[rad/(V·s)\].
    speed_constant: SPEED_CONSTANT, Positive;
    /// Resistance of the motor \[Ω\].
    resistance: RESISTANCE, Positive;
    /// Inductance of the motor \[H\].
    inductance: INDUCTANCE, NonNegative;
    /// Current at the rated torque \[A\].
    rated_current: CURRENT, Positive;
    /// Current that must never be exceeded \[A\].
    peak_current: CURRENT, Positive;
    /// Current without load \[A\].
    no_load_current: CURRENT, NonNegative;
    /// Current from the supply at the rated point \[A\].
    supply_current: CURRENT, Positive;
    /// Efficiency of the gear when the motor drives, η.
    efficiency: RATIO, Fraction;
    /// Efficiency of the gear when the load drives, η_b.
    backdrive_efficiency: RATIO, Any;
    /// Backlash at the flange \[rad\].
    backlash: ANGLE, NonNegative;
    /// Torsional stiffness at the flange \[N·m/rad\].
    stiffness: STIFFNESS, Positive;
    /// Mass \[kg\].
    mass: MASS, Positive;
    /// Outer diameter of a round one \[m\].
    outer_diameter: LENGTH, Positive;
    /// Length along the output axis, of a box its depth, as printed \[m\].
    length: LENGTH, Positive;
    /// Width of a box, across the output axis \[m\]; a limit on the diameter takes the diagonal of width and height.
    width: LENGTH, Positive;
    /// Height of a box, across the output axis \[m\].
    height: LENGTH, Positive;
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
}
