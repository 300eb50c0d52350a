//! The hardware of a joint in numbers at the joint: of a module, or of a motor with a gear, behind a transmission.

use super::file::{Mount, Reduction, Turns, Which};
use gearwise_model::catalog::convention::{Commutation, CurrentConvention};
use gearwise_model::catalog::module::on_curve;
use gearwise_model::catalog::{Catalog, Gear, Module, Motor};
use gearwise_model::input::Problem;
use gearwise_model::words::number;

/// Whether a number is the hardware's own or a bound on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// It is the number.
    Exactly,
    /// The number is at least this: a part of it is not known.
    AtLeast,
    /// The number is at most this: what the gear allows is not known.
    AtMost,
}

/// A number that hardware has at a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    /// At the joint, SI.
    pub value: f64,
    /// Ids of the rows.
    pub row: String,
    /// Where the rows have it from.
    pub source: String,
    /// How it was taken to the joint, in one line.
    pub how: String,
    /// Whether it is known in full.
    pub holds: Holds,
}

/// What the hardware of a joint can do, at the joint. `None` is what no row says.
#[derive(Debug, Clone, PartialEq)]
pub struct Hardware {
    /// Its ids, as the file of hardware names them.
    pub label: String,
    /// Turns of the actuator for one of the joint, r; the most of them where they go with the angle.
    pub transmission: f64,
    /// Whether r goes with the angle: torque and speed are then the largest over the joint's range, and what is one number at every angle
    /// is not known.
    pub varies: bool,
    /// Turns of the motor for one of the actuator, N.
    pub gear: Option<f64>,
    /// Largest torque \[N·m\].
    pub peak: Option<Fact>,
    /// The torque above which it certainly gives nothing, where `peak` is not known: what its gear carries, or carries for a moment \[N·m\].
    pub peak_most: Option<Fact>,
    /// The same before the gear's loss, N K_T I, where a loss is known: what a simulator whose joints have none is told \[N·m\].
    pub before_loss: Option<Fact>,
    /// Torques of other meanings that a row prints, each with its name \[N·m\].
    pub others: Vec<(&'static str, Fact)>,
    /// No-load speed at the voltage \[rad/s\].
    pub no_load: Option<Fact>,
    /// Largest speed: the least of the no-load speed, the motor's `max_speed` and the gear's `max_input_speed` \[rad/s\].
    pub largest_speed: Option<Fact>,
    /// Upper bound of the largest speed, if that is known as a lower bound only \[rad/s\].
    pub largest_speed_most: Option<Fact>,
    /// Inertia of rotor and gear \[kg·m²\].
    pub armature: Option<Fact>,
    /// Coulomb friction \[N·m\].
    pub friction: Option<Fact>,
    /// Viscous friction \[N·m·s/rad\].
    pub damping: Option<Fact>,
    /// Mass of the actuator \[kg\].
    pub mass: Option<Fact>,
    /// Largest torque over speed \[rad/s, N·m\], with what it is; from standstill on, the speed rises.
    pub curve: Option<(Vec<[f64; 2]>, Fact)>,
}

impl Hardware {
    /// The torque above which it certainly gives nothing; `None` where no row says one.
    pub fn strongest(&self) -> Option<&Fact> {
        let all = self.peak.iter().chain(&self.peak_most);
        all.min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// The speed above which it certainly gives nothing; `None` where no row says one.
    pub fn fastest(&self) -> Option<&Fact> {
        self.largest_speed_most.as_ref().or(self.largest_speed.as_ref())
    }
}

/// The hardware that an entry of the file names.
///
/// # Errors
/// Ids that no row has, with the nearest that exists.
pub fn of(mount: &Mount, catalog: &Catalog) -> Result<Hardware, Problem> {
    let unknown = |kind: &str, id: &str, span: &std::ops::Range<usize>, ids: Vec<&str>| {
        let problem = Problem::at(span.clone(), format!("there is no {kind} `{id}` in the catalogue"), "named here");
        match gearwise_model::words::nearest(id, ids.iter().copied()) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help("`gearwise catalog list` lists them, and `--catalog` adds a catalogue of your own"),
        }
    };
    match &mount.which {
        Which::Module(id, span) => {
            let found = catalog.modules.iter().find(|m| m.id == *id);
            let module = found
                .ok_or_else(|| unknown("module", id, span, catalog.modules.iter().map(|m| m.id.as_str()).collect()))?;
            Ok(over_the_range(mount, |r| of_module(mount, r, module)))
        }
        Which::Motor(id, span, reduction) => {
            let motors = || catalog.motors.iter().chain(&catalog.aside);
            let motor = motors()
                .find(|m| m.id == *id)
                .ok_or_else(|| unknown("motor", id, span, motors().map(|m| m.id.as_str()).collect()))?;
            let (gear, ratio) = match reduction {
                Reduction::Ratio(ratio) => (None, *ratio),
                Reduction::Gear(id, span) => {
                    let found = catalog.gear(id);
                    let gear = found.ok_or_else(|| {
                        unknown("gear", id, span, catalog.all_gears().map(|g| g.id.as_str()).collect())
                    })?;
                    (Some(gear), gear.ratio)
                }
            };
            Ok(over_the_range(mount, |r| of_motor(mount, r, motor, gear, ratio)))
        }
    }
}

/// Hardware whose transmission goes with the angle: torque at the largest r, speed at the smallest.
fn over_the_range(mount: &Mount, of: impl Fn(f64) -> Hardware) -> Hardware {
    let Turns { least, most } = mount.transmission;
    let strongest = of(most);
    if least == most {
        return strongest;
    }
    let fastest = of(least);
    let there = |fact: Option<Fact>, which: &str| {
        fact.map(|fact| Fact { how: format!("{}, the {which} over the joint's range", fact.how), ..fact })
    };
    Hardware {
        varies: true,
        peak: there(strongest.peak, "largest"),
        peak_most: there(strongest.peak_most, "largest"),
        before_loss: there(strongest.before_loss, "largest"),
        no_load: there(fastest.no_load, "smallest"),
        largest_speed: there(fastest.largest_speed, "smallest"),
        largest_speed_most: there(fastest.largest_speed_most, "smallest"),
        others: Vec::new(),
        armature: None,
        friction: None,
        damping: None,
        curve: None,
        ..strongest
    }
}

/// `r 1.917 × `, where there is a transmission.
fn times(r: f64, power: &str) -> String {
    if r == 1.0 { String::new() } else { format!("r{power} × ") }
}

/// What r is, behind a conversion, where there is a transmission.
fn with_r(r: f64) -> String {
    if r == 1.0 { String::new() } else { format!(", r = {}", number(r)) }
}

fn of_module(mount: &Mount, r: f64, module: &Module) -> Hardware {
    let (sheet, refers) = (&module.sheet, &module.refers);
    let fact = |value: f64, how: String| Fact {
        value,
        row: module.id.clone(),
        source: module.source.clone(),
        how,
        holds: Holds::Exactly,
    };
    let torque = |printed: Option<gearwise_model::catalog::Printed>, name: &str| {
        let torque = printed?.value;
        Some(fact(r * torque, format!("{}{name} {} N*m{}", times(r, ""), number(torque), with_r(r))))
    };
    let stall = torque(sheet.stall_torque, "stall_torque");
    let of_curve = || {
        let most = module.largest_of_curve()?;
        let how = format!("{}the largest torque of driving_curve {} N*m{}", times(r, ""), number(most), with_r(r));
        Some(fact(r * most, how))
    };
    let peak = torque(sheet.peak_torque, "peak_torque").or_else(of_curve).or_else(|| stall.clone());
    let mut others = Vec::new();
    others.extend(torque(sheet.rated_torque, "rated_torque").map(|fact| ("rated torque", fact)));
    others.extend(stall.map(|fact| ("stall torque", fact)));
    others.extend(of_curve().map(|fact| ("largest torque of its curve", fact)));
    let constants = module.constants();
    let current = refers.current.zip(sheet.peak_current);
    if let (Some(k), Some((is, current))) = (constants.torque_constant, current) {
        let current = current.value * is.torque_current(Commutation::Brushless);
        let how =
            format!("{}K_T I_peak, {} N*m/A × {} A (q axis){}", times(r, ""), number(k), number(current), with_r(r));
        others.push(("torque at its peak current", fact(r * k * current, how)));
    }
    // A lower voltage takes from the speed; what a higher one would give nobody printed.
    let printed_at = sheet.voltage.map(|v| v.value);
    let share = match (mount.voltage, printed_at) {
        (Some(voltage), Some(printed)) if voltage < printed => voltage / printed,
        _ => 1.0,
    };
    let holds = match (mount.voltage, printed_at) {
        (Some(voltage), Some(printed)) if voltage > printed => Holds::AtLeast,
        _ => Holds::Exactly,
    };
    let at = match (mount.voltage, printed_at) {
        (Some(voltage), Some(printed)) if voltage < printed => {
            format!(" at {} V × {}/{}", number(printed), number(voltage), number(printed))
        }
        (_, Some(printed)) => format!(" at {} V", number(printed)),
        (_, None) => " at a voltage that the row does not say".into(),
    };
    let free = sheet.no_load_speed.map(|p| (p.value, "no_load_speed"));
    let free = free.or_else(|| Some((module.end_of_curve()?, "the end of driving_curve")));
    let divided = if r == 1.0 { "" } else { " / r" };
    let no_load = free.map(|(speed, name)| {
        let how = format!("{name} {} rad/s{at}{divided}{}", number(speed), with_r(r));
        Fact { holds, ..fact(speed * share / r, how) }
    });
    // Twice the voltage is no more than twice the speed.
    let more = mount.voltage.zip(printed_at).map(|(voltage, printed)| voltage / printed).filter(|more| *more > 1.0);
    let largest_speed_most = free.zip(more).map(|((speed, name), more)| {
        let how = format!("{} × {name} {} rad/s{at}{divided}{}", number(more), number(speed), with_r(r));
        fact(more * speed / r, how)
    });
    let curve = (!module.driving_curve.is_empty()).then(|| {
        // C(ω; V) = C(ω + ω₀ (1 − V/V_c); V_c).
        let shift = free.map_or(0.0, |(speed, _)| speed * (1.0 - share));
        let mut points = module.driving_curve.clone();
        if let (Some((speed, _)), Some(last)) = (free, points.last().copied())
            && last[1] > 0.0
            && speed > last[0]
        {
            points.push([speed, 0.0]);
        }
        let start = on_curve(&points, shift);
        let mut moved = vec![[0.0, r * start]];
        moved.extend(points.iter().filter(|p| p[0] > shift).map(|p| [(p[0] - shift) / r, p[1] * r]));
        (moved, Fact { holds, ..fact(0.0, format!("driving_curve of the row{at}{}", with_r(r))) })
    });
    let ratio = module.ratio();
    let armature = module.constants().inertia.map(|inertia| {
        let printed = sheet.armature.map_or(inertia, |p| p.value);
        let of_motor = refers.armature_side == Some(gearwise_model::catalog::row::Side::Motor);
        let gear = if of_motor {
            format!("N² × armature {}", number(printed))
        } else {
            format!("armature {}", number(printed))
        };
        let n = if of_motor { format!(", N = {}", number(ratio)) } else { String::new() };
        fact(r * r * inertia, format!("{}{gear} kg*m^2{n}{}", times(r, "²"), with_r(r)))
    });
    let friction = |name: &'static str, printed: Option<gearwise_model::catalog::Printed>, unit: &str, power: i32| {
        let at_flange = module.at_output(printed, refers.friction_side, power)?;
        let factor = r.powi(power);
        let sign = if power == 1 { "" } else { "²" };
        let how = format!("{}{name} {} {unit} at the flange{}", times(r, sign), number(at_flange), with_r(r));
        Some(fact(factor * at_flange, how))
    };
    Hardware {
        label: module.id.clone(),
        transmission: r,
        varies: false,
        gear: Some(ratio).filter(|n| n.is_finite()),
        peak,
        peak_most: None,
        before_loss: None,
        others,
        largest_speed: no_load.clone(),
        no_load,
        largest_speed_most,
        armature,
        friction: friction("dynamic_friction", sheet.dynamic_friction, "N*m", 1)
            .or_else(|| friction("static_friction", sheet.static_friction, "N*m", 1)),
        damping: friction("viscous_friction", sheet.viscous_friction, "N*m*s/rad", 2),
        mass: sheet.mass.map(|p| fact(p.value, "mass of the row".into())),
        curve,
    }
}

fn of_motor(mount: &Mount, r: f64, motor: &Motor, gear: Option<&Gear>, ratio: f64) -> Hardware {
    let row = gear.map_or_else(|| motor.id.clone(), |gear| format!("{} + {}", motor.id, gear.id));
    let source = match gear {
        Some(gear) if gear.source != motor.source => format!("{}; {}", motor.source, gear.source),
        _ => motor.source.clone(),
    };
    let fact =
        |value: f64, how: String, holds: Holds| Fact { value, row: row.clone(), source: source.clone(), how, holds };
    let efficiency = gear.and_then(|gear| gear.efficiency).or(mount.efficiency);
    let (eta, of_eta) = match efficiency {
        Some(eta) => (eta, format!(", η = {}", number(eta))),
        None => (1.0, ", η not known: 1 is taken, the most that it can be".into()),
    };
    let n_is = format!(", N = {}", number(ratio));
    let at_joint = |torque: f64, of: String| {
        let how = format!("{}N η × {of}{n_is}{of_eta}{}", times(r, ""), with_r(r));
        fact(r * ratio * eta * torque, how, Holds::Exactly)
    };
    let by_current = |current: f64, name: &str| {
        let of = format!("K_T {name}, {} N*m/A × {} A (q axis)", number(motor.torque_constant), number(current));
        (motor.torque_constant * current, of)
    };
    let printed = |torque: f64, name: &str| (torque, format!("{name} {} N*m", number(torque)));
    let peak = motor.peak_torque.map(|torque| printed(torque, "peak_torque"));
    let peak = peak.or_else(|| motor.peak_current.map(|current| by_current(current, "I_peak")));
    let by_drive = mount.drive_current.map(|amplitude| {
        let q_axis = CurrentConvention::PhaseAmplitude.torque_current(motor.conventions.commutation);
        by_current(amplitude * q_axis, "drive_current")
    });
    let peak = peak.into_iter().chain(by_drive).min_by(|a, b| a.0.total_cmp(&b.0));
    let mut before_loss = peak.clone().filter(|_| eta < 1.0).map(|(torque, of)| {
        let how = format!("{}N × {of}{n_is}, before the gear's loss{}", times(r, ""), with_r(r));
        fact(r * ratio * torque, how, Holds::Exactly)
    });
    let mut peak = peak.map(|(torque, of)| at_joint(torque, of));
    // A momentary peak is more than the repeated one.
    let momentary = gear.and_then(|gear| gear.ratings.momentary_peak_torque).map(|torque| ("momentary peak", torque));
    let of_gear = gear.and_then(|gear| Some((gear, gear.peak_torque.map(|torque| ("peak", torque)).or(momentary)?)));
    let by_gear = of_gear.map(|(gear, (name, torque))| {
        let how = format!("{}{name} torque of the gear {}, {} N*m{}", times(r, ""), gear.id, number(torque), with_r(r));
        fact(r * torque, how, Holds::Exactly)
    });
    let mut peak_most = None;
    if let Some(by_gear) = by_gear {
        if before_loss.as_ref().is_some_and(|before| by_gear.value < before.value) {
            before_loss = None;
        }
        match &peak {
            Some(own) if own.value <= by_gear.value => {}
            Some(_) if gear.is_some_and(|gear| gear.peak_torque.is_some()) => peak = Some(by_gear),
            _ => (peak, peak_most) = (None, Some(by_gear)),
        }
    }
    if let Some(peak) = &mut peak
        && gear.is_some_and(|gear| gear.peak_torque.is_none())
    {
        peak.holds = Holds::AtMost;
    }
    let continuous = motor.continuous_torque.map(|torque| printed(torque, "continuous_torque"));
    let continuous = continuous.or_else(|| motor.continuous_current.map(|current| by_current(current, "I_cont")));
    let others = continuous.map(|(torque, of)| ("continuous torque", at_joint(torque, of))).into_iter().collect();
    let root = match motor.conventions.commutation {
        Commutation::Brushless => std::f64::consts::SQRT_2,
        Commutation::Brushed => 1.0,
    };
    let divided = if r == 1.0 { "N" } else { "(r N)" };
    let holds = match gear {
        Some(gear) if gear.max_input_speed.is_none() => Holds::AtMost,
        _ => Holds::Exactly,
    };
    let speed = |speed: f64, of: String| fact(speed / ratio / r, format!("{of} / {divided}{n_is}{}", with_r(r)), holds);
    let by_voltage = mount.voltage.map(|voltage| {
        let free = voltage / (root * motor.emf_constant());
        speed(free, format!("speed without load at {} V, {} rad/s of the motor", number(voltage), number(free)))
    });
    let by_row = motor.max_speed.map(|most| speed(most, format!("max_speed {} rad/s of the motor", number(most))));
    let by_gear = gear.and_then(|gear| Some((&gear.id, gear.max_input_speed?)));
    let by_gear =
        by_gear.map(|(id, most)| speed(most, format!("largest input speed of the gear {id}, {} rad/s", number(most))));
    let no_load = by_voltage.clone();
    let largest_speed = by_voltage.into_iter().chain(by_row).chain(by_gear).min_by(|a, b| a.value.total_cmp(&b.value));
    let armature = motor.rotor_inertia.map(|rotor| {
        // Where nothing is between motor and flange there is no inertia of a gear.
        let inner = if gear.is_none() && ratio == 1.0 { Some(0.0) } else { gear.and_then(|gear| gear.inertia) };
        let squared = (r * ratio) * (r * ratio);
        let total = rotor + inner.unwrap_or(0.0);
        let (of_gear, holds) = match inner {
            Some(_) => (" of rotor and gear", Holds::Exactly),
            None => (" of the rotor; that of the gear is not known", Holds::AtLeast),
        };
        let how = format!("{}N² × {} kg*m^2{of_gear}{n_is}{}", times(r, "²"), number(total), with_r(r));
        fact(squared * total, how, holds)
    });
    let friction = motor.coulomb_friction.map(|c| {
        let how = format!("{}N × coulomb_friction {} N*m of the motor{n_is}{}", times(r, ""), number(c), with_r(r));
        fact(r * ratio * c, how, Holds::AtLeast)
    });
    let damping = motor.viscous_friction.map(|b| {
        let how =
            format!("{}N² × viscous_friction {} N*m*s/rad of the motor{n_is}{}", times(r, "²"), number(b), with_r(r));
        fact((r * ratio).powi(2) * b, how, Holds::AtLeast)
    });
    let mass = motor.mass.map(|mass| match gear.and_then(|gear| gear.mass) {
        Some(gear) => fact(mass + gear, "mass of motor and gear".into(), Holds::Exactly),
        None => fact(mass, "mass of the motor; that of the gear is not known".into(), Holds::AtLeast),
    });
    Hardware {
        label: match gear {
            Some(gear) => format!("{} + {}", motor.id, gear.id),
            None => format!("{} @ {}", motor.id, number(ratio)),
        },
        transmission: r,
        varies: false,
        gear: Some(ratio),
        peak,
        peak_most,
        before_loss,
        others,
        no_load,
        largest_speed,
        largest_speed_most: None,
        armature,
        friction,
        damping,
        mass,
        curve: None,
    }
}
