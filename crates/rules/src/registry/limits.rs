//! One rule for each limit of the model, and for what cannot be checked. The limits themselves are those of
//! [`LIMITS`](gearwise_model::actuator::limits::LIMITS); nothing is computed here.

use crate::facts::JointFacts;
use crate::place::{Place, asked_for};
use crate::rule::{Remark, Rule, Severity, Test};
use gearwise_model::actuator::limits::is_of_gear;
use gearwise_model::catalog::drag::Drag;
use gearwise_model::requirement::MotorDrag;
use gearwise_model::words::with_unit;
use gearwise_select::judge::unjudged;

macro_rules! limits {
    ($all:ident: $($code:literal $name:literal $limit:literal, $summary:literal, why $why:literal, example $example:literal, fix $fix:literal;)*) => {
        /// Rules of limits, in the order of their codes.
        pub(super) const $all: &[Rule] = &[$(Rule {
            code: $code,
            name: $name,
            summary: $summary,
            severity: Severity::Error,
            what: concat!("Compares the design with the limit `", $limit, "`, the same that `optimize` and `sweep` keep. It is broken where the demand is more than the limit; where data are missing to compute it, GW031 or GW033 says so."),
            why: $why,
            example: $example,
            fix: $fix,
            test: Test::Limit($limit),
        }),*];
    };
}

limits! { OF_LIMITS:
    "GW001" "peak-current" "peak_current",
        "the largest current stays within that of motor and drive",
        why "The drive cuts off or limits the current, so the torque is not delivered at the very moment it is needed; above the motor's own limit magnets demagnetise.",
        example "A knee that needs 52 A at touch-down from a drive of 40 A.",
        fix "A larger ratio, a motor with a larger torque constant, or a larger drive.";
    "GW002" "peak-torque" "peak_torque",
        "the largest shaft torque stays within the motor's peak torque",
        why "Beyond its peak torque a motor saturates: more current gives heat, not torque, and the row's torque constant no longer holds.",
        example "A landing that asks 3.1 N*m of a motor with a peak torque of 2.7 N*m.",
        fix "A larger ratio or a larger motor.";
    "GW003" "continuous-current" "continuous_current",
        "the rms current stays within the motor's continuous current",
        why "The continuous current is what the maker warrants without a limit in time; above it the winding ends hotter than its class.",
        example "A hip with 9 A rms on a motor of 7.2 A.",
        fix "A larger ratio (less current, more speed), a motor with a higher K_M, or pauses in the motion.";
    "GW004" "continuous-torque" "continuous_torque",
        "the rms shaft torque stays within the motor's continuous torque",
        why "As for the continuous current: it is the torque that the maker warrants without a limit in time.",
        example "0.9 N*m rms at the shaft of a motor rated 0.7 N*m.",
        fix "A larger ratio, or a motor with a higher continuous torque.";
    "GW005" "winding-temperature" "winding_temperature",
        "in steady state the winding stays below its highest temperature",
        why "Copper loss is computed with hot copper, whose resistance is higher: near the limit the temperature runs away from what a cold calculation says. Insulation that is too hot fails early.",
        example "A shoulder that holds a load and settles at 138 degC with a limit of 100 degC.",
        fix "A larger ratio, a motor with a higher K_M or a lower thermal resistance, or better cooling (measured, and in the row).";
    "GW006" "winding-peak-temperature" "winding_peak_temperature",
        "over the motion the winding stays below its highest temperature",
        why "The winding is light and follows single pushes within seconds: the mean may be cool while each jump is too hot.",
        example "A jump that takes the winding from 60 degC to 130 degC in two seconds.",
        fix "A motor with a larger winding, a larger ratio, or longer pauses.";
    "GW007" "standstill-holding" "standstill_holding",
        "holding at standstill stays within what the hottest phase can carry",
        why "At standstill one phase carries up to two thirds of the heat (2 R i_phase² of 3/2 R î²), so a motor holds less than its continuous torque.",
        example "An arm that holds its payload for minutes at 90 % of the continuous current.",
        fix "A brake, a counterbalance or spring, a larger ratio, or a larger motor.";
    "GW008" "voltage" "voltage",
        "the voltage for speed, current and its changes is there",
        why "Where the voltage circle is left the current controller saturates: the joint lags and torque ripple rises, first when the battery is low.",
        example "A swing phase at 40 rad/s whose back-EMF leaves nothing for the current.",
        fix "A smaller ratio, a winding with a smaller K_T, or a higher bus voltage.";
    "GW009" "max-speed" "max_speed",
        "the motor stays below its largest speed",
        why "Bearings, magnets and rotor bandage are made for it.",
        example "A ratio of 20 that takes the rotor to 9000 rpm with 8000 rpm allowed.",
        fix "A smaller ratio.";
    "GW010" "gear-input-speed" "gear_input_speed",
        "the gear's input stays below its largest speed",
        why "Lubrication and wear are rated up to it; a strain-wave gear heats up quickly above.",
        example "A strain-wave gear at 7000 rpm with 5600 rpm allowed.",
        fix "A smaller ratio, or a gear made for the speed.";
    "GW011" "gear-peak-torque" "gear_peak_torque",
        "the largest torque stays within the gear's peak torque",
        why "Above it teeth skip or break; the ratio does not help, because the torque is that of the output.",
        example "A 17 N*m landing through a gear of 12 N*m.",
        fix "A stronger gear, or a slip clutch or compliance that takes the peak.";
    "GW012" "gear-continuous-torque" "gear_continuous_torque",
        "the rms torque stays within the gear's continuous torque",
        why "The gear's life is rated at it, and falls with about the third power of the torque (rolling bearings, ISO 281).",
        example "An rms of 9 N*m through a gear rated 6 N*m.",
        fix "A stronger gear.";
    "GW013" "reflected-inertia" "reflected_inertia",
        "rotor and gear, seen at the output, stay within the allowed inertia",
        why "Reflected inertia is what hits the ground with the foot and what a person feels at an exoskeleton; it cannot be controlled away above the bandwidth.",
        example "A ratio of 20 that makes 0.02 kg*m^2 of a small rotor where 0.01 are allowed.",
        fix "A smaller ratio, or a motor with a lower S_M.";
    "GW014" "torque-bandwidth-current" "torque_bandwidth_current",
        "the current for the asked torque bandwidth is there",
        why "The torque that was asked for on top of the motion is needed to balance or to feel; without current it is not there.",
        example "2 N*m at 30 Hz on top of a motion that uses all of the drive's current.",
        fix "A larger drive, or a motor with more torque per ampere.";
    "GW015" "torque-bandwidth-voltage" "torque_bandwidth_voltage",
        "the voltage for the asked torque bandwidth is there",
        why "Current through an inductance needs L di/dt: at speed little of the bus is left for it. A motor with a good S_M and a large inductance fails here.",
        example "5 N*m at 60 Hz with a winding of 2.6 mH on 48 V.",
        fix "A winding with fewer turns (the same motor at a smaller K_T), a higher bus voltage, or a smaller ratio.";
    "GW016" "bus-power" "bus_power",
        "the joint's largest electrical power stays within the bus's",
        why "The bus sags or its protection trips.",
        example "A push-off of 620 W on a bus that gives one joint 500 W.",
        fix "A motor with less loss, or a stronger supply.";
    "GW017" "bus-current" "bus_current",
        "the joint's largest bus current stays within the bus's",
        why "Wires, connectors and fuses are made for it.",
        example "31 A through a connector of 30 A.",
        fix "A higher bus voltage, or a motor with less loss.";
    "GW018" "regeneration" "regeneration",
        "what the joint gives back stays within what the bus takes",
        why "Power that the supply does not take raises the bus voltage until a drive shuts down, often in a landing.",
        example "180 W of braking on a bench supply, which takes none.",
        fix "A brake resistor or a battery on the bus, or a gear that wastes more of it.";
    "GW019" "actuator-mass" "actuator_mass",
        "motor and gear stay within the joint's mass",
        why "Mass at a joint is carried by all joints before it.",
        example "A 720 g actuator at a knee that may have 550 g.",
        fix "A lighter motor or gear; `optimize --pareto loss,mass` shows what it costs.";
    "GW020" "outer-diameter" "outer_diameter",
        "motor and gear, or a module, stay within the joint's outer diameter",
        why "An actuator that does not fit into the joint is no choice, however good it is.",
        example "A motor of 80 mm with a gear of 96 mm in a knee whose tube has 85 mm.",
        fix "A longer motor of less diameter, a smaller gear, or a larger ratio with a smaller motor. Of a box the diagonal across the axis counts.";
    "GW021" "axial-length" "axial_length",
        "motor and gear together, or a module, stay within the joint's axial length",
        why "Width at a joint is what collides first: knees touch, arms cannot fold.",
        example "A motor of 35 mm behind a gear of 40 mm in a knee that is 60 mm wide.",
        fix "A flat motor of more diameter, a gear of fewer stages, or motor and gear side by side with a belt (arrangement = \"side_by_side\").";
    "GW022" "gear-average-torque" "gear_average_torque",
        "the average torque stays within the gear's average torque",
        why "It is the maker's own limit for a torque that changes: what wears a gear is the cube of the torque times the speed, so that moments under load at speed count and holding does not.",
        example "An average of 40 N*m through a strain wave gear whose average torque is 34 N*m.",
        fix "A larger gear, or a motion that is slower where the torque is large.";
    "GW023" "gear-momentary-torque" "gear_momentary_torque",
        "shocks stay within the gear's momentary peak torque",
        why "A stumble or a stop of emergency happens a few times in a life; beyond the momentary peak it is the last time.",
        example "A fall of 120 N*m on a gear that bears 91 N*m for a moment.",
        fix "A larger gear, a slip clutch, or compliance that takes the shock.";
    "GW024" "gear-ratcheting-torque" "gear_ratcheting_torque",
        "no torque makes the teeth of the gear skip",
        why "A strain wave gear whose teeth skip keeps running, off centre and for a short life.",
        example "A fall of 200 N*m on a gear that skips at 190 N*m.",
        fix "A larger gear, or a slip clutch that gives way before.";
    "GW025" "gear-average-speed" "gear_average_speed",
        "the gear's input stays below its largest average speed",
        why "Grease gets warm and thin: what a gear bears for a moment it does not bear for hours.",
        example "4000 rpm on average at the input of a gear that may have 3500 rpm.",
        fix "A smaller ratio, or a gear made for the speed.";
    "GW026" "gear-life" "gear_life",
        "the gear lasts as long as the joint has to",
        why "A rated torque is that of a rated life at a rated speed, of nine gears in ten. Life falls with the speed and with the cube of the torque.",
        example "10 000 h are asked for, and the motion leaves 6000 h of the rated 7000 h at 2000 rpm.",
        fix "A smaller ratio, a larger gear, or a slower motion under load.";
    "GW027" "gear-backlash" "gear_backlash",
        "the gear's backlash stays within the joint's",
        why "Within its backlash a joint has no stiffness: a controller hunts there, and a foot rattles.",
        example "A planetary gear of 48 arcmin where 10 are allowed.",
        fix "A gear with less backlash: strain wave, cycloidal, or a planetary one that is preloaded.";
    "GW028" "gear-stiffness" "gear_stiffness",
        "the gear is at least as stiff as the joint has to be",
        why "Gear and load are a spring and an inertia: their frequency is above what the position controller can reach, or the arm swings.",
        example "A gear of 13 000 N*m/rad where 20 000 N*m/rad are needed.",
        fix "A larger gear, or one of a stiffer kind.";
    "GW029" "backdriving-torque" "backdriving_torque",
        "a person or the ground can move the actuator that has no current",
        why "What the motor's and the gear's friction hold at the output is what a leg cannot feel, and what a person has to overcome.",
        example "A strain wave gear of 9 N*m at a wrist that is to be led by hand with 3 N*m.",
        fix "A smaller ratio, a gear with a smaller starting torque, or a motor with less drag.";
}

// Of limits that came after the rules below.
limits! { OF_MORE_LIMITS:
    "GW034" "drive-continuous-current" "drive_continuous_current",
        "the rms current stays within the drive's continuous current",
        why "A drive's large current is for seconds: its switches warm up and it falls back to the continuous one, in the middle of the work.",
        example "A hip with 24 A rms (amplitude) on a drive of 60 A for a second and 20 A continuously.",
        fix "A larger drive or a better cooled one, or a motor with more torque per ampere.";
    "GW035" "open-circuit-voltage" "open_circuit_voltage",
        "the motor's own voltage at its top speed stays within what the bus bears",
        why "When the drive lets go at speed, the motor charges the bus through the diodes of the drive up to its own voltage between two phases; drives and capacitors burst above theirs.",
        example "A motor that is run to twice its base speed with a weakened field: 92 V on drives of 60 V when a fault switches them off.",
        fix "A smaller ratio, a winding with fewer turns, or a brake that holds the bus.";
    "GW036" "bus-overvoltage" "bus_overvoltage",
        "what comes back does not lift the bus above what it bears",
        why "A battery behind its own resistance and long leads rises with what flows back into it; drives switch off or burst above their voltage, in a landing.",
        example "A landing that gives back 160 W through 1 ohm: a bus of 24 V is lifted to 29.5 V where drives bear 28 V.",
        fix "Shorter or thicker leads, a braking resistor, or drives for a higher voltage.";
}

// Of all parts together.
limits! { OF_PARTS:
    "GW037" "price" "price",
        "motor and gear, or a module, cost no more than the joint may",
        why "A price that is found out after the choice makes the choice again. Prices are those of the rows, at the rates and the day that the requirement states: neither is known to the program by itself.",
        example "A motor of 240 EUR and a gear of 310 EUR at a knee that may cost 400 EUR.",
        fix "Another motor or gear, a module, or a price for the number of pieces that is bought (`price_quantity`, `quantity` of [prices]).";
    "GW038" "lead-time" "lead_time",
        "every part is delivered in time",
        why "The last part decides when the joint is built.",
        example "A gear with 10 weeks of lead time for a prototype in 30 days.",
        fix "A part that is on stock, or a later date.";
}

limits! { OF_MODULES:
    "GW046" "module-torque-speed" "torque_speed",
        "at every speed the torque stays below the module's torque–speed curve",
        why "A module's drive and voltage are fixed: beyond its curve the torque is not there, however the load looks. The box of peak torque and no-load speed promises more than it has.",
        example "A knee that asks 60 N*m at 16 rad/s of a module that has 43 N*m there.",
        fix "A larger module, a higher supply voltage (up to that of the curve), or a slower motion.";
    "GW047" "module-rated-torque" "rated_torque",
        "the rms torque stays within the module's rated torque",
        why "It is what the maker rates as continuous; above it the winding or the drive ends too hot.",
        example "An rms of 26 N*m on a module rated 20 N*m.",
        fix "A larger module, pauses in the motion, or a spring.";
    "GW048" "module-overload" "overload",
        "over the motion the module stays within its overload table",
        why "The table says how long a torque may last from ambient; a motion that repeats begins warmer each time.",
        example "120 N*m for 3 s, again after 10 s.",
        fix "Longer pauses, a larger module, or better cooling than that of the maker's test.";
    "GW049" "module-supply-range" "supply_range",
        "the bus voltage is within the module's range",
        why "Below its range the drive inside does not start; above it, it switches off or breaks.",
        example "A module for 24 to 50 V on a 58 V pack.",
        fix "Another module, or another supply.";
}

limits! { OF_TRANSMISSIONS:
    "GW050" "transmission-torque" "transmission_torque",
        "the torque at the joint stays within what the transmission bears",
        why "A belt jumps and a rod buckles at the torque of the joint, whatever motor and gear could give.",
        example "A knee that asks 60 N*m of a belt that is made for 45 N*m.",
        fix "A wider belt or a stronger linkage, or a spring that takes part of the load.";
    "GW051" "transmission-force" "transmission_force",
        "the force in rod or screw stays within what it bears",
        why "Near the ends of its way a linkage has little moment arm: the same torque needs several times the force there.",
        example "An ankle whose rod sees 2100 N at 40 degrees of flexion, and is made for 1500 N.",
        fix "Longer levers, other angles of the links, or a stronger rod.";
    "GW052" "transmission-speed" "transmission_speed",
        "the input of the transmission stays below its largest speed",
        why "A screw whips and a belt throws off above their speed.",
        example "A ball screw at 3600 rpm that may turn 3000 rpm.",
        fix "A larger lead or a smaller ratio of the transmission.";
}

/// A motor and gear that cannot be evaluated at all.
pub(crate) const NOT_EVALUATED: Rule = Rule {
    code: "GW030",
    name: "not-evaluated",
    summary: "the design can be evaluated",
    severity: Severity::Error,
    what: "Reports a joint whose motor or gear lacks what every equation needs: the rotor's inertia, or the gear's efficiency. No other rule can judge such a joint.",
    why: "A design that nobody can evaluate is not shown to keep anything.",
    example: "A motor whose row has no `rotor_inertia`.",
    fix: "Complete the row: from the maker, from the rotor's mass and radius, or measured (`gearwise characterize`).",
    test: Test::Joint(|facts| match &facts.examined {
        Ok(_) => Vec::new(),
        Err(why) => {
            let message = format!("{} cannot be evaluated: {}", facts.choice.motor.id, why.reason());
            vec![Remark::new(message, "evaluation", Place::Motor)]
        }
    }),
};

/// A limit that should be checked but cannot be.
pub(crate) const UNCHECKED_LIMIT: Rule = Rule {
    code: "GW031",
    name: "unchecked-limit",
    summary: "every limit that applies can be checked",
    severity: Severity::Warning,
    what: "Reports each limit that should be checked but cannot be, because the row of motor or gear or the requirement does not say enough: an unknown inductance, pole pairs, continuous current, a gear's rating. What the requirement itself states is GW033.",
    why: "What is not checked is not kept. A blank cell is unknown, not zero: without its inductance a motor seems to have any torque bandwidth.",
    example: "A motor without `inductance`: its voltage limit is checked as if the current could jump.",
    fix: "Find or measure the number and fill the cell; or accept the gap in the rules file with [[allow]] and a reason.",
    test: Test::Joint(|facts| match &facts.examined {
        Ok(examined) => {
            let stated = unjudged(facts.robot, facts.choice.joint, &examined.unchecked);
            let plain = examined.unchecked.iter().filter(|what| !stated.contains(what));
            plain.map(|(limit, why)| unknown(limit, format!("`{limit}` is not checked: {why}"))).collect()
        }
        Err(_) => Vec::new(),
    }),
};

fn unknown(limit: &'static str, message: String) -> Remark {
    let place = if is_of_gear(limit) { Place::Reduction } else { Place::Motor };
    Remark::new(message, limit, place)
}

/// A limit of the requirement that cannot be judged.
pub(crate) const UNJUDGED_LIMIT: Rule = Rule {
    code: "GW033",
    name: "unjudged-limit",
    summary: "every limit that the requirement states can be judged",
    severity: Severity::Error,
    what: "Reports each limit that the requirement itself states and that cannot be judged of this design: a mass or an inertia where motor or gear do not say theirs, a winding temperature without thermal resistances, a torque bandwidth without inductance or without any largest current, heat where the operating points have no durations.",
    why: "Whoever writes a limit wants it kept. A design of which nobody knows whether it keeps the limit is not shown to be a choice, and `optimize` does not choose it.",
    example: "actuator_mass = \"600 g\" and a motor whose row has no `mass`.",
    fix: "Find or measure the number and fill the cell; take a motor that can be judged; or take the limit out of the requirement.",
    test: Test::Joint(|facts| match &facts.examined {
        Ok(examined) => {
            let stated = unjudged(facts.robot, facts.choice.joint, &examined.unchecked);
            let remark = |(limit, why): (&'static str, &'static str)| Remark {
                asked: asked_for(limit, "requirement"),
                ..unknown(limit, format!("`{limit}` cannot be judged: {why}"))
            };
            stated.into_iter().map(remark).collect()
        }
        Err(_) => Vec::new(),
    }),
};

/// Friction that was left out because nobody knows it.
pub(crate) const FRICTION_UNKNOWN: Rule = Rule {
    code: "GW032",
    name: "friction-unknown",
    summary: "the motor's own friction is known",
    severity: Severity::Note,
    what: "Notes a motor whose row gives neither a no-load current nor friction: its drag is estimated from motors built alike, or left out where it cannot be.",
    why: "Friction and iron loss of a high-pole motor can be as large as the copper loss at speed (a drag of a few hundredths of N*m, times the ratio). Left out, it makes every margin too good.",
    example: "A gimbal motor whose data sheet gives no no-load current.",
    fix: "Take the no-load current and its speed from the sheet (`no_load_current`, `no_load_speed`), or fit it from logs: `gearwise identify --write`.",
    test: Test::Joint(friction),
};

fn friction(facts: &JointFacts) -> Vec<Remark> {
    let motor = facts.choice.motor;
    // What a module gives by its ratings has its friction in it already.
    if motor.inside.as_deref().is_some_and(|inside| !inside.says_currents()) {
        return Vec::new();
    }
    let how = match motor.drag() {
        Drag::Declared | Drag::NoLoad { .. } => return Vec::new(),
        Drag::Unknown => " and is left out".to_string(),
        Drag::Estimated { .. } if facts.choice.joint.motor_drag == MotorDrag::Off => " and is left out".to_string(),
        Drag::Estimated { torque } => format!(": {} is estimated, from above", with_unit(torque, "N*m")),
    };
    let message = format!("the friction of {} is not known{how}", motor.id);
    vec![Remark::new(message, "friction", Place::Motor)]
}
