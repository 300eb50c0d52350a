//! Figures of a design: every number that tables, JSON, CSV, studies, pages and rules show of one is declared here, once.
//!
//! The one idea: an answer says what it knows of a design as [`Facts`]; a figure is a name, a unit and how it is read from
//! them. A new figure is one entry of [`FIGURES`].

use super::answer::{Design, SpringChoice, SweptDesign};
use super::evaluate::Evaluation;
use super::examine::Examined;
use super::explain::Explanation;
use super::pareto::FrontPoint;
use super::program::Optimum;
use super::robust::RobustDesign;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::actuator::thermal::Winding;
use gearwise_model::catalog::convention::{Commutation, CurrentConvention};
use gearwise_model::catalog::{Currency, Motor};
use gearwise_model::requirement::{Choice, Joint};
use gearwise_model::units::{self, Kind};

/// What an answer knows of a design.
#[derive(Debug, Clone, Copy)]
pub struct Facts<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The design at its ratio.
    pub evaluation: &'a Evaluation,
    /// The objective there, SI.
    pub objective: Option<f64>,
    /// The best ratio and its proof, where the ratio was solved for.
    pub optimum: Option<&'a Optimum>,
    /// Steady state of the winding, where it was worked out.
    pub winding_temperature: Winding,
    /// Longest time that the current needs at a reversal \[s\]; infinite where no voltage is left.
    pub reversal_time: Option<f64>,
    /// The parallel spring, where the joint asks for one.
    pub spring: Option<&'a SpringChoice>,
    /// Limits that could not be checked, and why.
    pub unchecked: &'a [Remark],
    /// Limits that count as kept, and as far as what holds.
    pub assumed: &'a [Remark],
}

impl<'a> Facts<'a> {
    /// A design as it was evaluated: what takes solving for the ratio or more work is not known.
    fn new(
        motor: &'a Motor,
        gear: Option<&'a str>,
        evaluation: &'a Evaluation,
        unchecked: &'a [Remark],
        assumed: &'a [Remark],
    ) -> Facts<'a> {
        Facts {
            motor,
            gear,
            evaluation,
            objective: None,
            optimum: None,
            winding_temperature: Winding::NotAsked,
            reversal_time: None,
            spring: None,
            unchecked,
            assumed,
        }
    }
}

impl Design<'_> {
    /// What is known of it.
    pub fn facts(&self) -> Facts<'_> {
        Facts {
            objective: Some(self.optimum.objective).filter(|value| value.is_finite()),
            optimum: Some(&self.optimum),
            winding_temperature: self.winding_temperature,
            reversal_time: self.reversal_time,
            spring: self.spring.as_ref(),
            ..Facts::new(self.motor, self.gear, &self.evaluation, &self.unchecked, &self.assumed)
        }
    }
}

impl SweptDesign<'_> {
    /// What is known of it.
    pub fn facts(&self, joint: &Joint) -> Facts<'_> {
        Facts {
            objective: self.evaluation.objective(&joint.objective),
            ..Facts::new(self.motor, self.gear, &self.evaluation, &self.unchecked, &self.assumed)
        }
    }
}

impl FrontPoint<'_> {
    /// What is known of it.
    pub fn facts(&self, joint: &Joint) -> Facts<'_> {
        Facts {
            objective: self.evaluation.objective(&joint.objective),
            ..Facts::new(self.motor, self.gear, &self.evaluation, &self.unchecked, &self.assumed)
        }
    }
}

impl RobustDesign<'_> {
    /// What is known of it at its robust ratio, for the printed numbers.
    pub fn facts(&self) -> Facts<'_> {
        Facts {
            objective: Some(self.optimum.objective),
            optimum: Some(&self.optimum),
            ..Facts::new(self.nominal.motor, self.gear, &self.evaluation, &self.unchecked, &self.assumed)
        }
    }
}

impl Explanation<'_> {
    /// What is known of the design that was asked about.
    pub fn facts(&self) -> Facts<'_> {
        Facts {
            objective: self.evaluation.objective(&self.joint.objective),
            winding_temperature: self.winding_temperature,
            reversal_time: self.reversal_time,
            spring: self.spring.as_ref().and_then(|spring| spring.as_ref().ok()),
            ..Facts::new(
                self.motor,
                self.gear.map(|gear| gear.id.as_str()),
                &self.evaluation,
                &self.unchecked,
                &self.assumed,
            )
        }
    }
}

impl Examined {
    /// What is known of a design that was examined.
    pub fn facts<'a>(&'a self, choice: &'a Choice) -> Facts<'a> {
        Facts {
            objective: self.evaluation.objective(&choice.joint.objective),
            winding_temperature: self.winding_temperature,
            reversal_time: self.reversal_time,
            ..Facts::new(
                choice.motor,
                choice.gear.map(|gear| gear.id.as_str()),
                &self.evaluation,
                &self.unchecked,
                &self.assumed,
            )
        }
    }
}

/// What the unit of a figure leaves open: in which frame a current is counted, in which currency a price.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// As the drive is bought: amplitude of a phase, DC of a brushed motor.
    Phase,
    /// As the model, its limits and its objective count it: q axis, power invariant.
    QAxis,
    /// In the currency of the requirement.
    Money,
}

/// A number of a design.
#[derive(Debug)]
pub struct Figure {
    /// Key in JSON, CSV and studies; the SI unit is in it.
    pub key: &'static str,
    /// Name of the measure in rules files.
    pub name: &'static str,
    /// Heading of a table.
    pub heading: &'static str,
    /// What it is, in a few words.
    pub words: &'static str,
    /// What it is, in full.
    pub meaning: &'static str,
    /// What it measures.
    pub kind: &'static Kind,
    /// Unit in which people read it.
    pub unit: &'static str,
    /// Frame of a current, or that it is money.
    pub frame: Option<Frame>,
    /// Where tables of a terminal show it: the place in which it gives way where there is no room, the least first.
    /// `None`: pages and files show it, tables of a terminal do not.
    pub in_tables: Option<u8>,
    value: fn(&Facts) -> Option<f64>,
}

/// Figures of what a requirement may ask for, or that few gears say: where they do not, they are no unknowns.
const WHERE_ASKED: &[&str] = &[
    "gear_efficiency_at_mean",
    "gear_efficiency_at_peak",
    "gear_backdriving_torque_nm",
    "gear_l10_life_s",
    "field_weakening_current_a",
    "field_weakening_loss_w",
    "field_weakening_rate",
    "lowest_bus_voltage_v",
    "highest_bus_voltage_v",
    "supply_heat_w",
    "price",
    "lead_time_s",
];

impl Figure {
    /// Whether it says something of every design; others are left out of a text where they have no value.
    pub fn is_of_every_design(&self) -> bool {
        !WHERE_ASKED.contains(&self.key)
    }

    /// Its value, SI: infinite where it grows without end, `None` where it is not known or was not worked out.
    pub fn value(&self, facts: &Facts) -> Option<f64> {
        (self.value)(facts)
    }

    /// Its value as a number for files, SI: `None` also where it grows without end.
    pub fn finite(&self, facts: &Facts) -> Option<f64> {
        self.value(facts).filter(|value| value.is_finite())
    }

    /// Its value in the unit that people read it in.
    pub fn shown(&self, facts: &Facts) -> Option<f64> {
        self.finite(facts).map(|value| units::in_unit(value, self.unit))
    }

    /// The unit that people read it in where a requirement counts prices in a currency.
    pub fn unit_in(&self, currency: Option<Currency>) -> &'static str {
        match (self.frame, currency) {
            (Some(Frame::Money), Some(currency)) => currency.code(),
            _ => self.unit,
        }
    }

    /// The unit that people read it in, with the frame of a current, or the currency of a price.
    pub fn unit_of(&self, facts: &Facts) -> &'static str {
        match (self.frame, facts.motor.conventions.commutation) {
            (None, _) => self.unit,
            (Some(Frame::Money), _) => self.unit_in(facts.evaluation.price.map(|cost| cost.currency)),
            (Some(Frame::QAxis), _) => "A (q axis)",
            (Some(Frame::Phase), Commutation::Brushless) => "A (phase amplitude)",
            (Some(Frame::Phase), Commutation::Brushed) => "A (DC)",
        }
    }
}

/// What a q-axis current is on the drive: phase amplitude, or DC of a brushed motor \[A\].
pub(crate) fn on_the_drive(motor: &Motor, q_axis: f64) -> f64 {
    let commutation = motor.conventions.commutation;
    let convention = match commutation {
        Commutation::Brushless => CurrentConvention::PhaseAmplitude,
        Commutation::Brushed => CurrentConvention::Dc,
    };
    q_axis / convention.torque_current(commutation)
}

/// Every figure.
pub const FIGURES: &[Figure] = &[
    Figure {
        key: "loss_w",
        name: "loss",
        heading: "loss",
        words: "loss",
        meaning: "mean of all losses that are known: copper, motor drag, gear, drive",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: Some(8),
        value: |d| Some(d.evaluation.loss),
    },
    Figure {
        key: "copper_loss_w",
        name: "copper_loss",
        heading: "copper",
        words: "copper loss",
        meaning: "mean copper loss",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: Some(4),
        value: |d| Some(d.evaluation.copper_loss),
    },
    Figure {
        key: "loss_at_least_w",
        name: "loss_at_least",
        heading: "loss, least",
        words: "loss, at least",
        meaning: "the least that the loss may be, by what is known of the motor's drag",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.loss_low),
    },
    Figure {
        key: "motor_drag_loss_w",
        name: "motor_drag_loss",
        heading: "drag",
        words: "motor drag",
        meaning: "part of the loss: bearings, hysteresis and eddy currents of the motor",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.losses.motor_drag),
    },
    Figure {
        key: "gear_loss_w",
        name: "gear_loss",
        heading: "gear",
        words: "gear loss",
        meaning: "part of the loss: the gear's, under load and without",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.losses.gear_load + d.evaluation.losses.gear_no_load),
    },
    Figure {
        key: "gear_efficiency_at_mean",
        name: "gear_efficiency_at_mean",
        heading: "η mean",
        words: "gear's efficiency at the mean load",
        meaning: "efficiency of the gear with its torque without load, at the means of torque and speed over the time that is not at standstill; where both are known",
        kind: &units::RATIO,
        unit: "%",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.gear.efficiency_at_mean,
    },
    Figure {
        key: "gear_efficiency_at_peak",
        name: "gear_efficiency_at_peak",
        heading: "η peak",
        words: "gear's efficiency at the peak load",
        meaning: "efficiency of the gear with its torque without load, at the largest load torque and the speed there; where both are known",
        kind: &units::RATIO,
        unit: "%",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.gear.efficiency_at_peak,
    },
    Figure {
        key: "gear_backdriving_torque_nm",
        name: "gear_backdriving_torque",
        heading: "τ back",
        words: "torque that turns it from the output",
        meaning: "torque at the output that sets motor and gear going without current, N (c + c_g)/η_b, the motor's friction at its worse end; behind a transmission at the joint; where it is known",
        kind: &units::TORQUE,
        unit: "N*m",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.gear.backdriving_torque.filter(|torque| torque.is_finite()),
    },
    Figure {
        key: "gear_l10_life_s",
        name: "gear_l10_life",
        heading: "L10",
        words: "gear's life in this motion (L10)",
        meaning: "how long nine in ten gears last in this motion with its pauses, from the rated life; where that is known",
        kind: &units::TIME,
        unit: "h",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.gear.life,
    },
    Figure {
        key: "drive_loss_w",
        name: "drive_loss",
        heading: "drive",
        words: "drive loss",
        meaning: "part of the loss: resistance of drive and leads, standby, and what the drive's efficiency takes",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.losses.drive),
    },
    Figure {
        key: "braking_loss_w",
        name: "braking_loss",
        heading: "braking",
        words: "braking loss",
        meaning: "part of the loss: what comes back to the bus and is not kept, in a braking resistor or in the supply",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.losses.braking),
    },
    Figure {
        key: "field_weakening_current_a",
        name: "field_weakening_current",
        heading: "i_d",
        words: "largest current along d (amplitude)",
        meaning: "largest current against the magnets, amplitude of a phase; where `field_weakening_current` or `flux_braking` is given",
        kind: &units::CURRENT,
        unit: "A",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.weakening?.largest / 1.5_f64.sqrt()),
    },
    Figure {
        key: "field_weakening_loss_w",
        name: "field_weakening_loss",
        heading: "loss i_d",
        words: "loss of the current along d",
        meaning: "part of the copper loss: that of the current against the magnets",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.weakening?.loss),
    },
    Figure {
        key: "field_weakening_rate",
        name: "field_weakening_rate",
        heading: "L di_d/dt",
        words: "largest L di_d/dt, share of the voltage limit",
        meaning: "largest voltage of a changing current against the magnets, which the voltage leaves out, as a share of the voltage limit; from one sample to the next",
        kind: &units::RATIO,
        unit: "%",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.weakening?.rate,
    },
    Figure {
        key: "lowest_bus_voltage_v",
        name: "lowest_bus_voltage",
        heading: "V low",
        words: "lowest bus voltage",
        meaning: "voltage of the bus at the instant of most power, by this joint alone; where `internal_resistance` is given",
        kind: &units::VOLTAGE,
        unit: "V",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.bus_voltage?.lowest,
    },
    Figure {
        key: "highest_bus_voltage_v",
        name: "highest_bus_voltage",
        heading: "V high",
        words: "highest bus voltage",
        meaning: "voltage of the bus at the instant of most power that comes back, by this joint alone; where `internal_resistance` is given",
        kind: &units::VOLTAGE,
        unit: "V",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.bus_voltage?.highest),
    },
    Figure {
        key: "supply_heat_w",
        name: "supply_heat",
        heading: "supply",
        words: "heat in the supply's resistance",
        meaning: "mean heat in the resistance of the supply and its leads, by this joint alone; not in the loss; where `internal_resistance` is given",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.bus_voltage?.heat,
    },
    Figure {
        key: "mean_electrical_power_w",
        name: "mean_power",
        heading: "P mean",
        words: "mean power at the motor",
        meaning: "mean electrical power at the motor's terminals",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| Some(d.evaluation.mean_power),
    },
    Figure {
        key: "energy_per_cycle_j",
        name: "energy",
        heading: "E",
        words: "energy per cycle",
        meaning: "energy drawn from the bus per cycle",
        kind: &units::ENERGY,
        unit: "J",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.energy,
    },
    Figure {
        key: "peak_electrical_power_w",
        name: "peak_power",
        heading: "P peak",
        words: "peak power from the bus",
        meaning: "largest electrical power drawn from the bus",
        kind: &units::POWER,
        unit: "W",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.peak_power,
    },
    Figure {
        key: "rms_current_phase_a",
        name: "rms_current_phase",
        heading: "I rms",
        words: "current, rms",
        meaning: "root mean square of the current as the drive is bought: phase amplitude, DC of a brushed motor",
        kind: &units::CURRENT,
        unit: "A",
        frame: Some(Frame::Phase),
        in_tables: None,
        value: |d| Some(on_the_drive(d.motor, d.evaluation.rms_current)),
    },
    Figure {
        key: "rms_current_q_a",
        name: "rms_current",
        heading: "I rms, q axis",
        words: "current, rms",
        meaning: "root mean square of the q-axis current",
        kind: &units::CURRENT,
        unit: "A",
        frame: Some(Frame::QAxis),
        in_tables: None,
        value: |d| Some(d.evaluation.rms_current),
    },
    Figure {
        key: "peak_current_phase_a",
        name: "peak_current_phase",
        heading: "I peak",
        words: "current, peak",
        meaning: "largest current as the drive is bought: phase amplitude, DC of a brushed motor",
        kind: &units::CURRENT,
        unit: "A",
        frame: Some(Frame::Phase),
        in_tables: Some(6),
        value: |d| Some(on_the_drive(d.motor, d.evaluation.peak_current)),
    },
    Figure {
        key: "peak_current_q_a",
        name: "peak_current",
        heading: "I peak, q axis",
        words: "current, peak",
        meaning: "largest q-axis current",
        kind: &units::CURRENT,
        unit: "A",
        frame: Some(Frame::QAxis),
        in_tables: None,
        value: |d| Some(d.evaluation.peak_current),
    },
    Figure {
        key: "reflected_inertia_kgm2",
        name: "reflected_inertia",
        heading: "J",
        words: "reflected inertia",
        meaning: "inertia of rotor and gear at the output, N² (J_m + J_g); behind a transmission that at the joint, r² (N² (J_m + J_g) + J_t) + J_j at the largest r of the motion",
        kind: &units::INERTIA,
        unit: "kg*m^2",
        frame: None,
        in_tables: Some(5),
        value: |d| Some(d.evaluation.reflected_inertia),
    },
    Figure {
        key: "mass_kg",
        name: "mass",
        heading: "mass",
        words: "mass",
        meaning: "mass of motor and gear",
        kind: &units::MASS,
        unit: "kg",
        frame: None,
        in_tables: Some(7),
        value: |d| d.evaluation.mass,
    },
    Figure {
        key: "price",
        name: "price",
        heading: "price",
        words: "price",
        meaning: "price of motor and gear, or of a module, in the currency of `[prices]`; where all of it is known",
        kind: &units::RATIO,
        unit: "1",
        frame: Some(Frame::Money),
        in_tables: None,
        value: |d| d.evaluation.price?.whole.value(),
    },
    Figure {
        key: "lead_time_s",
        name: "lead_time",
        heading: "lead time",
        words: "lead time",
        meaning: "longest lead time of motor and gear, or that of a module; where all of it is known",
        kind: &units::TIME,
        unit: "d",
        frame: None,
        in_tables: None,
        value: |d| d.evaluation.lead_time.value(),
    },
    Figure {
        key: "winding_temperature_k",
        name: "winding_temperature",
        heading: "winding",
        words: "winding, steady state",
        meaning: "steady winding temperature",
        kind: &units::TEMPERATURE,
        unit: "degC",
        frame: None,
        in_tables: None,
        value: |d| d.winding_temperature.kelvin_or_infinite(),
    },
    Figure {
        key: "reversal_time_s",
        name: "reversal_time",
        heading: "reversal",
        words: "current's reversal",
        meaning: "longest time the current needs for its jump where the motion reverses, L Δi/(V − R i)",
        kind: &units::TIME,
        unit: "ms",
        frame: None,
        in_tables: None,
        value: |d| d.reversal_time,
    },
];

/// The figure of a key.
///
/// # Panics
/// There is none: the key is a literal of the program.
pub fn figure(key: &str) -> &'static Figure {
    FIGURES.iter().find(|f| f.key == key).expect("a figure")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use gearwise_model::requirement::Quantity;

    /// Keys, names and headings tell figures apart, and what can be minimised has a figure of its name.
    #[test]
    fn a_figure_has_its_own_key_name_and_heading_and_every_quantity_one_of_its_name() {
        for of in [|f: &Figure| f.key, |f: &Figure| f.name, |f: &Figure| f.heading] {
            assert_eq!(FIGURES.iter().map(of).collect::<BTreeSet<_>>().len(), FIGURES.len());
        }
        for (name, quantity) in Quantity::NAMES {
            let figure = FIGURES.iter().find(|f| f.name == *name).unwrap_or_else(|| panic!("no figure `{name}`"));
            assert_eq!(figure.kind.name, quantity.kind().name, "{name}");
        }
        for figure in FIGURES {
            assert!(units::unit_of(figure.unit, figure.kind).is_ok(), "{}: {}", figure.key, figure.unit);
        }
    }
}
