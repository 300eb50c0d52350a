//! What the field calls good practice, with bounds that a rules file may move.

use crate::facts::JointFacts;
use crate::place::Place;
use crate::rule::{Remark, Rule, Severity, Test};
use gearwise_model::words::number;

pub(super) const TORQUE_RESERVE: Rule = Rule {
    code: "GW101",
    name: "torque-reserve",
    summary: "peak torque of motor and gear keeps 10 % in reserve",
    severity: Severity::Warning,
    what: "Asks for a reserve of at least 0.1 on the peak torque of motor and gear, and on the torque–speed curve of a module. Reserve is 1 − demand/limit without the requirement's `safety` factor.",
    why: "K_T spreads by several per cent from motor to motor and falls by about 0.1 to 0.2 % per kelvin of the magnets (NdFeB remanence, about −0.11 %/K), 5 to 10 % over 50 K; load, friction and model are no better known. With less than 10 % the limit is kept on paper only.",
    example: "A requirement with safety = 1.0 and a motor that is used to 98 % of its peak torque.",
    fix: "Write `safety = 1.2` into the requirement, so that optimize chooses with it; or a stronger motor or gear.",
    test: Test::Bounds {
        measures: &["peak_torque_reserve", "gear_peak_torque_reserve", "torque_speed_reserve"],
        min: Some(0.1),
        max: None,
    },
};

pub(super) const CURRENT_RESERVE: Rule = Rule {
    code: "GW102",
    name: "current-reserve",
    summary: "peak current keeps 10 % in reserve",
    severity: Severity::Warning,
    what: "Asks for a reserve of at least 0.1 on the peak current of motor and drive, without the requirement's `safety` factor.",
    why: "The current controller overshoots, current sensors have a gain error of a few per cent, and a drive that trips on overcurrent drops the joint.",
    example: "A design that uses 39 A of a drive of 40 A.",
    fix: "A larger drive, a larger ratio, or `safety = 1.2` in the requirement.",
    test: Test::Bounds { measures: &["peak_current_reserve"], min: Some(0.1), max: None },
};

pub(super) const HEAT_RESERVE: Rule = Rule {
    code: "GW103",
    name: "heat-reserve",
    summary: "continuous current and torque keep 10 % in reserve",
    severity: Severity::Warning,
    what: "Asks for a reserve of at least 0.1 on continuous current, continuous torque and standstill holding, and on rated torque or overload of a module. The requirement's `safety` does not act on heat.",
    why: "Heat goes with the square: 10 % of current are 20 % of heat, about what a warmer day, a closed housing or a flange smaller than the maker's test plate takes away.",
    example: "A wrist at 97 % of its continuous current.",
    fix: "A larger ratio, a motor with a higher K_M, or a thermal model in the row that shows that the heat is carried off.",
    test: Test::Bounds {
        measures: &[
            "continuous_current_reserve",
            "continuous_torque_reserve",
            "standstill_holding_reserve",
            "rated_torque_reserve",
            "overload_reserve",
        ],
        min: Some(0.1),
        max: None,
    },
};

pub(super) const SPEED_RESERVE: Rule = Rule {
    code: "GW104",
    name: "speed-reserve",
    summary: "motor and gear speed keep 10 % in reserve",
    severity: Severity::Warning,
    what: "Asks for a reserve of at least 0.1 on the largest speed of the motor and of the gear's input.",
    why: "The controller overshoots its speed, and a foot that slips or a hand that is let go goes faster than planned.",
    example: "A ratio that takes the motor to 99 % of its largest speed.",
    fix: "A smaller ratio.",
    test: Test::Bounds { measures: &["max_speed_reserve", "gear_input_speed_reserve"], min: Some(0.1), max: None },
};

pub(super) const TEMPERATURE_RESERVE: Rule = Rule {
    code: "GW105",
    name: "temperature-reserve",
    summary: "the winding stays 10 K below its limit",
    severity: Severity::Warning,
    what: "Asks that the winding's temperature, in steady state and over the motion where that is computed, stays at least 10 K below the lower of the motor's and the requirement's limit.",
    why: "Insulation lives half as long for each 10 K more (Arrhenius' law as the ten-degree rule, the basis of the thermal classes of IEC 60085), hot spots are 5 to 15 K above the mean that is computed, and ambient is rarely the one of the requirement.",
    example: "A winding that settles at 98 degC where 100 degC are allowed.",
    fix: "As for GW005: a larger ratio, a higher K_M, better cooling.",
    test: Test::Bounds { measures: &["temperature_reserve"], min: Some(10.0), max: None },
};

pub(super) const VOLTAGE_HEADROOM: Rule = Rule {
    code: "GW106",
    name: "voltage-headroom",
    summary: "10 % of the voltage are left for control",
    severity: Severity::Warning,
    what: "Asks for a reserve of at least 0.1 on the voltage circle over the whole motion.",
    why: "A controller that follows a motion needs voltage beyond the motion's own to correct errors, K_B spreads by several per cent, and a battery sags: one of lithium ions goes from 4.2 V full to about 3.3 V empty per cell, 11 % below its nominal 3.7 V.",
    example: "A swing phase that needs 47 V of 48 V.",
    fix: "A smaller ratio, a winding with a smaller K_T, or the bus voltage of the empty battery in the requirement.",
    test: Test::Bounds { measures: &["voltage_reserve"], min: Some(0.1), max: None },
};

pub(super) const INERTIA_RATIO: Rule = Rule {
    code: "GW107",
    name: "inertia-ratio",
    summary: "the load's inertia is at most ten times the reflected one",
    severity: Severity::Warning,
    what: "Divides the inertia of the load by N² (J_m + J_g), and asks for at most 10. The load's inertia is `load_inertia` of the design, else the slope of torque over acceleration where gravity, drag and inertia explain nine tenths of the motion's torque; where they do not, the rule is not judged.",
    why: "Makers of servo drives advise load-to-rotor ratios up to about 10 (5 and less for the fastest loops): the compliance between rotor and load makes a resonance whose distance from its antiresonance is the root of 1 + ratio, and a large one can only be tuned slowly. There is no lower bound: legged robots want a small reflected inertia (GW013), and a strain-wave arm has ratios below one.",
    example: "A direct drive of 1e-4 kg*m^2 at a link of 0.02 kg*m^2.",
    fix: "A larger ratio (it acts squared), a stiffer gear; or accept it where sensors sit at the load.",
    test: Test::Bounds { measures: &["inertia_ratio"], min: None, max: Some(10.0) },
};

pub(super) const BANDWIDTH_RESERVE: Rule = Rule {
    code: "GW108",
    name: "bandwidth-reserve",
    summary: "the torque bandwidth that is asked for keeps 10 % in reserve",
    severity: Severity::Warning,
    what: "Asks for a reserve of at least 0.1 on current and voltage of the torque bandwidth, where the requirement asks for one.",
    why: "At the end of the voltage the current loop is no longer linear: phase is lost before amplitude, and a balancing or force controller gets unstable before the amplitude is gone.",
    example: "2 N*m at 30 Hz that just fit into the voltage circle.",
    fix: "As for GW015: fewer turns, a higher voltage, a smaller ratio.",
    test: Test::Bounds {
        measures: &["torque_bandwidth_current_reserve", "torque_bandwidth_voltage_reserve"],
        min: Some(0.1),
        max: None,
    },
};

pub(super) const REVERSAL_TIME: Rule = Rule {
    code: "GW109",
    name: "reversal-time",
    summary: "the current's jump at a reversal takes at most 5 ms",
    severity: Severity::Warning,
    what: "Where the motion reverses, friction and gear efficiency change sides and the current has to jump. The voltage limit leaves that jump out; this rule asks that L Δi/(V − R i) is at most 5 ms.",
    why: "5 ms is half the rise time of a torque loop of 35 Hz (0.35/f = 10 ms), a slow one for legs: what takes longer is felt as a kick or a stick at each reversal, and the limits computed without it no longer show all.",
    example: "A winding of 5 mH that has to jump by 12 A with 8 V left.",
    fix: "A winding with fewer turns, a higher bus voltage, a gear with a better efficiency.",
    test: Test::Bounds { measures: &["reversal_time"], min: None, max: Some(0.005) },
};

pub(super) const GEAR_RATING_UNKNOWN: Rule = Rule {
    code: "GW110",
    name: "gear-rating-unknown",
    summary: "the gear's peak torque is said",
    severity: Severity::Note,
    what: "Notes a joint whose requirement describes a gear of a continuous ratio other than an ideal one, but gives no `peak_torque` for it: nothing then limits the torque at the gear. (A gear of the catalogue without one is reported by GW031.)",
    why: "The gear is often the weakest part; a choice of ratio without its rating can ask for a gear that does not exist at that mass.",
    example: "gear = { efficiency = 0.94, mass = \"150 g\" } with torques of 20 N*m.",
    fix: "Give `peak_torque` and `continuous_torque` of the gear that is meant, or take `gears` from the catalogue.",
    test: Test::Joint(gear_rating),
};

fn gear_rating(facts: &JointFacts) -> Vec<Remark> {
    let joint = facts.choice.joint;
    let described = !joint.has_published_gears() && facts.choice.gear.is_none();
    let ideal = joint.gear.efficiency == 1.0 && joint.gear.mass == Some(0.0) && joint.gear.inertia == 0.0;
    if !described || ideal || joint.gear.peak_torque.is_some() {
        return Vec::new();
    }
    let largest = joint.motion.torque.iter().fold(0.0_f64, |most, torque| most.max(torque.abs()));
    let message = format!("the gear has no `peak_torque`, but carries up to {} N*m", number(largest));
    let mut remark = Remark::new(message, "gear_peak_torque", Place::JointKey(&["gear"]));
    remark.value = Some(largest);
    vec![remark]
}

pub(super) const FAR_FROM_BEST: Rule = Rule {
    code: "GW111",
    name: "far-from-best",
    summary: "the ratio is not far worse than the motor's best",
    severity: Severity::Note,
    what: "Solves the ratio program for the chosen motor and notes a ratio whose objective is more than 25 % above that of the best one that keeps the limits and the bounds of these rules. Not for gears of the catalogue; where no ratio keeps them all nothing is compared.",
    why: "The optimum is flat (loss within 2 % over ±10 % of ratio where heat of torque and inertia balance), so 25 % are no rounding to the next gear, but a choice that something else should explain.",
    example: "A ratio of 6 where 11 would halve the loss.",
    fix: "Take the best ratio (`gearwise explain` shows it), or say with [[allow]] why not.",
    test: Test::Bounds { measures: &["objective_excess"], min: None, max: Some(0.25) },
};
