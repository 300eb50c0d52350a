//! What has a slider: the keys of a requirement that people turn first, each with its unit and range.
//!
//! The one idea: a control is a row of [`CONTROLS`], and its key is the one that a requirement has, so that a link, `--set` and the
//! grid of a study say the same. Any other key of a requirement may stand in a link too; it has no slider.

use serde_json::{Value, json};

use crate::requirement::{Joint, RatioChoice, Robot};
use crate::units::in_unit;

/// Stands in a key for the name of the joint that is viewed.
pub const JOINT: &str = "{joint}";

/// A number that can be turned.
#[derive(Debug)]
pub struct Control {
    /// The key of a requirement, with [`JOINT`] in it where it is a joint's.
    pub key: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// Its unit; empty for a bare number.
    pub unit: &'static str,
    /// Its value in SI; `None` where the requirement has none.
    of: fn(&Robot, &Joint) -> Option<f64>,
    /// From where to where it goes, in its unit.
    range: Range,
    /// What it does, in a sentence.
    pub help: &'static str,
}

/// From where to where a slider goes.
#[derive(Debug)]
enum Range {
    /// From one value to another, in equal steps.
    Linear(f64, f64),
    /// From one value to another, in equal factors.
    Log(f64, f64),
    /// By so many times less and more than what the file says, in equal factors; from one value to another where it says nothing.
    About(f64, (f64, f64)),
}

/// Every control, in the order of the page.
pub const CONTROLS: &[Control] = &[
    Control {
        key: "bus.voltage",
        name: "bus voltage",
        unit: "V",
        of: |robot, _| Some(robot.bus.voltage),
        range: Range::About(3.0, (6.0, 100.0)),
        help: "What the supply gives. More lets a motor turn faster, or with a larger ratio.",
    },
    Control {
        key: "bus.drive_current",
        name: "drive current",
        unit: "A",
        of: |robot, _| robot.bus.drive_current,
        range: Range::About(4.0, (1.0, 300.0)),
        help: "The largest current of a phase (amplitude) that the drives give.",
    },
    Control {
        key: "scale.torque",
        name: "all torques",
        unit: "",
        of: |_, _| Some(1.0),
        range: Range::Log(0.5, 2.0),
        help: "A factor on the torques of every motion, as for more payload: 1.1 is ten per cent more.",
    },
    Control {
        key: "scale.speed",
        name: "all speeds",
        unit: "",
        of: |_, _| Some(1.0),
        range: Range::Log(0.5, 2.0),
        help: "A factor on the speeds of every motion: the same positions, sooner. Torques stay as they are.",
    },
    Control {
        key: "ambient.temperature",
        name: "surroundings",
        unit: "degC",
        of: |robot, _| Some(robot.ambient),
        range: Range::Linear(-20.0, 70.0),
        help: "The temperature of the surroundings.",
    },
    Control {
        key: "joint.{joint}.limits.safety",
        name: "safety factor",
        unit: "",
        of: |_, joint| Some(joint.limits.safety),
        range: Range::Linear(1.0, 3.0),
        help: "A factor on what the motion asks of motor, drive and gear.",
    },
    Control {
        key: "joint.{joint}.limits.actuator_mass",
        name: "actuator mass, at most",
        unit: "kg",
        of: |_, joint| joint.limits.actuator_mass,
        range: Range::About(4.0, (0.05, 20.0)),
        help: "Motor and gear may weigh so much.",
    },
    Control {
        key: "joint.{joint}.limits.reflected_inertia",
        name: "reflected inertia, at most",
        unit: "kg*m^2",
        of: |_, joint| joint.limits.reflected_inertia,
        range: Range::About(10.0, (1e-5, 10.0)),
        help: "What the rotor and the gear add to the inertia of the joint: less lets it give way.",
    },
    Control {
        key: "joint.{joint}.limits.winding_temperature",
        name: "winding, at most",
        unit: "degC",
        of: |_, joint| joint.limits.winding_temperature,
        range: Range::Linear(50.0, 180.0),
        help: "The hottest that a winding may become, where its row says no less.",
    },
    Control {
        key: "joint.{joint}.ratio.min",
        name: "ratio, at least",
        unit: "",
        of: |_, joint| free(joint).map(|range| range.0),
        range: Range::Log(1.0, 200.0),
        help: "The smallest ratio that may be chosen.",
    },
    Control {
        key: "joint.{joint}.ratio.max",
        name: "ratio, at most",
        unit: "",
        of: |_, joint| free(joint).map(|range| range.1),
        range: Range::Log(1.0, 200.0),
        help: "The largest ratio that may be chosen.",
    },
];

/// The key of the joint's objective, which is chosen and has no slider.
pub const OBJECTIVE: &str = "joint.{joint}.objective";

/// The range of a ratio that is free.
fn free(joint: &Joint) -> Option<(f64, f64)> {
    match joint.ratio {
        RatioChoice::Continuous { min, max } => Some((min, max)),
        _ => None,
    }
}

/// A number without what the conversion of its unit left behind the twelfth digit.
fn round(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

impl Control {
    /// Its key at a joint.
    pub fn key_of(&self, joint: &str) -> String {
        self.key.replace(JOINT, joint)
    }

    /// Whether it is of the joint that is viewed.
    fn is_of_joint(&self) -> bool {
        self.key.contains(JOINT)
    }

    /// Whether it has something to turn at a joint: a ratio that is not free has no ends.
    fn is_there(&self, joint: &Joint) -> bool {
        !self.key.contains(".ratio.") || free(joint).is_some()
    }

    /// What the page makes a slider of; `file` is the requirement as it is in its file.
    fn json(&self, file: (&Robot, &Joint), now: (&Robot, &Joint)) -> Value {
        let value = |(robot, joint): (&Robot, &Joint)| {
            (self.of)(robot, joint).map(|si| match self.unit {
                "" => si,
                unit => round(in_unit(si, unit)),
            })
        };
        let said = value(file);
        let (low, high, log) = match (&self.range, said) {
            (Range::Linear(low, high), _) => (*low, *high, false),
            (Range::Log(low, high), _) => (*low, *high, true),
            (Range::About(times, _), Some(value)) if value > 0.0 => (round(value / times), round(value * times), true),
            (Range::About(_, (low, high)), _) => (*low, *high, true),
        };
        let (low, high) = said.map_or((low, high), |value| (low.min(value), high.max(value)));
        json!({
            "key": self.key_of(&now.1.name), "name": self.name, "unit": self.unit, "help": self.help,
            "joint": self.is_of_joint(), "low": low, "high": high, "log": log && low > 0.0, "file": said,
            "now": if self.key.starts_with("scale.") { Value::Null } else { json!(value(now)) },
        })
    }
}

/// The controls of a joint, by what its file says and by what is set now.
pub fn json(file: (&Robot, &Joint), now: (&Robot, &Joint)) -> Value {
    CONTROLS.iter().filter(|control| control.is_there(now.1)).map(|control| control.json(file, now)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requirement::{Settings, read_source};

    /// The requirement that the tests below turn.
    const TEXT: &str = "name = \"r\"\n[bus]\nvoltage = \"24 V\"\n[[joint]]\nname = \"knee\"\nratio = { min = 3, max = 20 }\n\
        gear = { efficiency = 0.9, mass = \"100 g\", inertia = \"1e-6 kg*m^2\" }\npoints = [{ torque = \"1 N*m\", speed = \"1 rad/s\", duration = \"1 s\" }]\n";

    #[test]
    fn every_control_sets_what_it_shows() {
        let source = std::sync::Arc::new(crate::input::Source::new("r.toml", TEXT));
        let plain = read_source(&source).unwrap();
        for control in CONTROLS {
            let (low, high) = match control.range {
                Range::Linear(low, high) | Range::Log(low, high) => (low, high),
                Range::About(..) if control.key == "bus.voltage" => (8.0, 72.0),
                Range::About(_, (low, high)) => (low, high),
            };
            for value in [low, 0.5 * (low + high), high] {
                // The two ends of the ratio may not cross.
                let value = match control.key {
                    "joint.{joint}.ratio.min" => value.min(19.0),
                    "joint.{joint}.ratio.max" => value.max(4.0),
                    _ => value,
                };
                let text =
                    if control.unit.is_empty() { value.to_string() } else { format!("{value} {}", control.unit) };
                let set = Settings::of_arguments(&[format!("{}={text}", control.key_of("knee"))]).unwrap();
                let robot = set.read(&source, None).unwrap_or_else(|e| panic!("{}: {e:?}", control.key));
                if control.key.starts_with("scale.") {
                    let (now, before) = (&robot.joints[0].motion, &plain.joints[0].motion);
                    let of = |m: &crate::motion::Motion| {
                        if control.key == "scale.torque" { m.torque[0] } else { m.velocity[0] }
                    };
                    assert!((of(now) / of(before) - value).abs() < 1e-12, "{}", control.key);
                    continue;
                }
                let said = json((&plain, &plain.joints[0]), (&robot, &robot.joints[0]));
                let shown = said.as_array().unwrap().iter().find(|c| c["name"] == control.name).unwrap();
                assert!((shown["now"].as_f64().unwrap() / value - 1.0).abs() < 1e-3, "{}: {shown}", control.key);
            }
        }
    }

    #[test]
    fn what_the_file_does_not_say_has_no_value() {
        let robot = read_source(&std::sync::Arc::new(crate::input::Source::new("r.toml", TEXT))).unwrap();
        let said = json((&robot, &robot.joints[0]), (&robot, &robot.joints[0]));
        let of = |key: &str| said.as_array().unwrap().iter().find(|c| c["key"] == key).unwrap().clone();
        assert!(of("bus.drive_current")["file"].is_null());
        assert_eq!(of("bus.voltage")["file"], 24.0);
        assert_eq!((of("bus.voltage")["low"].as_f64(), of("bus.voltage")["high"].as_f64()), (Some(8.0), Some(72.0)));
    }
}
