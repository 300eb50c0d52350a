//! The facts of an actuator that a simulator may be able to say.

/// A fact of an actuator at its joint. Every format of an export says of each what it makes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fact {
    /// Inertia of rotor and gear at the joint, `N² (J_m + J_g)`.
    Armature,
    /// Viscous friction at the joint.
    Damping,
    /// Coulomb friction at the joint while it moves.
    Friction,
    /// What friction has more at rest.
    FrictionAtRest,
    /// Largest torque while the motor drives, at low speed.
    PeakTorque,
    /// Torque that falls with speed, to none at the speed without load.
    TorqueSpeed,
    /// More torque against the motion than with it: the back-EMF helps to brake.
    Braking,
    /// Torque that can be held for ever.
    ContinuousTorque,
    /// Largest speed that motor and gear allow, whatever the voltage.
    MechanicalSpeed,
    /// What the gear loses in proportion to the load, while the motor drives and while the load drives.
    GearLoss,
    /// The gear's elasticity.
    Compliance,
    /// The gear's play.
    Backlash,
    /// Cogging of the motor.
    Cogging,
    /// Friction, ripple and saturation of other forms.
    OtherEffects,
    /// How fast the current follows its command.
    ElectricalTime,
    /// How the winding heats.
    Heating,
    /// A transmission whose ratio goes with the angle, or that couples two joints.
    Transmission,
    /// A spring parallel to the joint.
    Spring,
    /// How sure the numbers are.
    Ranges,
}

impl Fact {
    /// All, in the order of tables.
    pub const ALL: &[Fact] = &[
        Fact::Armature,
        Fact::Damping,
        Fact::Friction,
        Fact::FrictionAtRest,
        Fact::PeakTorque,
        Fact::TorqueSpeed,
        Fact::Braking,
        Fact::ContinuousTorque,
        Fact::MechanicalSpeed,
        Fact::GearLoss,
        Fact::Compliance,
        Fact::Backlash,
        Fact::Cogging,
        Fact::OtherEffects,
        Fact::ElectricalTime,
        Fact::Heating,
        Fact::Transmission,
        Fact::Spring,
        Fact::Ranges,
    ];

    /// What it is called in tables.
    pub fn title(self) -> &'static str {
        match self {
            Fact::Armature => "armature",
            Fact::Damping => "viscous friction",
            Fact::Friction => "Coulomb friction",
            Fact::FrictionAtRest => "friction at rest",
            Fact::PeakTorque => "peak torque",
            Fact::TorqueSpeed => "torque over speed",
            Fact::Braking => "torque while braking",
            Fact::ContinuousTorque => "continuous torque",
            Fact::MechanicalSpeed => "mechanical speed limit",
            Fact::GearLoss => "gear loss by direction",
            Fact::Compliance => "gear compliance",
            Fact::Backlash => "backlash",
            Fact::Cogging => "cogging",
            Fact::OtherEffects => "other effects",
            Fact::ElectricalTime => "electrical time constant",
            Fact::Heating => "heating",
            Fact::Transmission => "ratio over the angle",
            Fact::Spring => "parallel spring",
            Fact::Ranges => "ranges (±)",
        }
    }
}
