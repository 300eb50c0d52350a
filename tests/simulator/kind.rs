//! Kinds of bench: what each measures.

use super::sense::Channel;

/// Kind of bench, as in the bench file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Dynamometer,
    Free,
    Electrical,
    SteadyTable,
    Stall,
    Backdrive,
    Servo,
    Linear,
    /// Driven from outside without current: torque sensor, speed and position.
    Drag,
    /// A driving machine is told a random torque; the motor has no current.
    RandomTorque,
}

impl Kind {
    /// Its name in the bench file.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Dynamometer => "dynamometer",
            Kind::Free => "free",
            Kind::Electrical => "electrical",
            Kind::SteadyTable => "steady_table",
            Kind::Stall => "stall",
            Kind::Backdrive => "backdrive",
            Kind::Servo => "servo",
            Kind::Linear => "linear",
            Kind::Drag => "drag",
            Kind::RandomTorque => "random_torque",
        }
    }

    /// The channel whose noise counts.
    pub fn target_channel(self) -> Channel {
        match self {
            Kind::Dynamometer | Kind::SteadyTable | Kind::Stall | Kind::Drag | Kind::RandomTorque => Channel::Torque,
            Kind::Free => Channel::Current,
            Kind::Electrical | Kind::Backdrive => Channel::Voltage,
            Kind::Servo => Channel::Position,
            Kind::Linear => Channel::Force,
        }
    }

    /// Unit of sizes and noise.
    pub fn unit(self) -> &'static str {
        match self {
            Kind::Dynamometer | Kind::SteadyTable | Kind::Stall | Kind::Free | Kind::Drag | Kind::RandomTorque => "N*m",
            Kind::Electrical | Kind::Backdrive => "V",
            Kind::Servo => "rad",
            Kind::Linear => "N",
        }
    }

    /// The channels that its log has.
    pub fn channels(self) -> &'static [Channel] {
        use Channel::{
            Command, Current, Duty, Force, Goal, HousingTemperature, OutputPosition, OutputVelocity, Position, Supply,
            Torque, Velocity, Voltage, WindingTemperature,
        };
        match self {
            Kind::Dynamometer => &[
                Position,
                Velocity,
                OutputPosition,
                OutputVelocity,
                Current,
                Torque,
                WindingTemperature,
                HousingTemperature,
            ],
            Kind::Free => {
                &[Position, Velocity, OutputPosition, OutputVelocity, Current, WindingTemperature, HousingTemperature]
            }
            Kind::Electrical => &[Position, Velocity, Current, Voltage, WindingTemperature, HousingTemperature],
            Kind::SteadyTable => &[Velocity, Current, Torque, WindingTemperature, HousingTemperature],
            Kind::Stall => &[Current, Torque, WindingTemperature, HousingTemperature],
            Kind::Backdrive => &[Velocity, Voltage],
            Kind::Servo => &[Position, Duty, Goal, Supply],
            Kind::Linear => &[Position, Velocity, Force],
            Kind::Drag => &[Position, Velocity, OutputPosition, OutputVelocity, Torque, HousingTemperature],
            Kind::RandomTorque => &[Position, Velocity, OutputPosition, OutputVelocity, Torque, Command],
        }
    }

    /// Whether its sensor has a zero that belongs to the log.
    pub fn has_zero(self) -> bool {
        self.target_channel() == Channel::Torque
    }
}
