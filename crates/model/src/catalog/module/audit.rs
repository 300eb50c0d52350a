//! Does a module's row add up? Redundant numbers are compared as the row declares them; where they do not fit, every other
//! reading that does is named.

use super::overload::{BENDS, bends};
use super::{MODULE_FIELDS, Module, RatedPower, TorqueLoss, on_curve};
use crate::catalog::alternative::Alternative;
use crate::catalog::alternative::spread::{Spread, spreads};
use crate::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention};
use crate::catalog::finding::{Audited, Finding, Outcome, Severity};
use crate::catalog::row::Side;
use crate::catalog::{Motor, Printed};
use crate::words::{number, with_unit};

/// One comparison of redundant numbers.
pub struct ModuleCheck {
    /// Code, also in the catalogue's `audit_accept` column.
    pub code: &'static str,
    /// What is compared.
    pub compares: &'static str,
    run: fn(&Of) -> Option<Outcome>,
}

/// A row and what it stands among.
struct Of<'c> {
    module: &'c Module,
    all: &'c [Module],
    motors: &'c [Motor],
    alternatives: &'c [Alternative],
}

impl<'c> Of<'c> {
    /// The other rows of its family.
    fn siblings(&self) -> impl Iterator<Item = &'c Module> {
        let module = self.module;
        let is_sibling = move |other: &&Module| other.id != module.id && other.family == module.family;
        self.all.iter().filter(|_| !module.family.is_empty()).filter(is_sibling)
    }
}

/// Every check of a module's row.
pub const MODULE_CHECKS: &[ModuleCheck] = &[
    ModuleCheck {
        code: "module-inertia-side",
        compares: "armature against the bare rotor's inertia times N²: 1 to 1.6 times",
        run: inertia_side,
    },
    ModuleCheck {
        code: "module-inertia-size",
        compares: "inertia at the motor against mass and diameter, m (D/2)²: 0.02 to 0.25 of it",
        run: inertia_size,
    },
    ModuleCheck {
        code: "module-torque-constant",
        compares: "rated and peak torque against K_T times their currents: 0.7 (0.85 if measured at the output) to 1.06, 0.55 to 1.06",
        run: torque_constant,
    },
    ModuleCheck {
        code: "module-back-emf",
        compares: "torque constant at the output against N K_B: the gear's efficiency, 0.6 to 1",
        run: back_emf,
    },
    ModuleCheck {
        code: "module-no-load-speed",
        compares: "no-load speed times K_B against the largest voltage, V/√2: 0.75 to 1.03",
        run: no_load_speed,
    },
    ModuleCheck {
        code: "module-speed-constant",
        compares: "no-load speed against speed constant times voltage: 0.75 to 1.08",
        run: speed_constant,
    },
    ModuleCheck {
        code: "module-power",
        compares: "rated power against rated torque times rated speed: 0.95 to 1.05 mechanical, up to 2 electrical",
        run: power,
    },
    ModuleCheck {
        code: "module-braking",
        compares: "peak torque while it is driven against that while it drives: not less",
        run: braking,
    },
    ModuleCheck {
        code: "module-no-loss",
        compares: "output torque against N times that of the bare motor: less, by what the gear loses",
        run: no_loss,
    },
    ModuleCheck {
        code: "module-overload",
        compares: "overload times against a concave answer, which any passive body has",
        run: overload,
    },
    ModuleCheck {
        code: "module-rated-point",
        compares: "rated point under the driving curve and below the no-load speed",
        run: rated_point,
    },
    ModuleCheck { code: "module-siblings", compares: "K_T/N and J/N² of rows of one family: the same", run: siblings },
    ModuleCheck {
        code: "module-curve",
        compares: "driving curve against peak torque and no-load speed: not above the one, ending at the other, within 1.06",
        run: curve,
    },
    ModuleCheck {
        code: "module-inside",
        compares: "mass against that of motor and gear rows inside: not less; peak current against the motor row's: within 1.06",
        run: inside,
    },
    ModuleCheck {
        code: "module-alternatives",
        compares: "what several sources print of one number: within their ±, or within 1.2 times",
        run: alternatives,
    },
];

/// Runs every check over one module.
pub fn audit_module(module: &Module, all: &[Module], motors: &[Motor], alternatives: &[Alternative]) -> Vec<Finding> {
    let of = Of { module, all, motors, alternatives };
    let outcomes = MODULE_CHECKS.iter().filter_map(|check| Some((check.code, (check.run)(&of)?)));
    let accepts = module.accepted_findings.iter().map(String::as_str).collect();
    let row = Audited { id: &module.id, accepts, note: &module.note };
    row.findings(outcomes, |code| MODULE_CHECKS.iter().any(|check| check.code == code))
}

fn value(p: Option<Printed>) -> Option<f64> {
    p.map(|p| p.value)
}

fn error(message: String, explanation: Option<String>) -> Option<Outcome> {
    Some(Outcome { severity: Severity::Error, message, explanation })
}

fn note(message: String, explanation: Option<String>) -> Option<Outcome> {
    Some(Outcome { severity: Severity::Note, message, explanation })
}

/// What readings fit, in words; that several do is said.
fn fitting(readings: Vec<String>) -> Option<String> {
    match readings.as_slice() {
        [] => None,
        [one] => Some(format!("it fits as {one}")),
        several => Some(format!("it fits as {}; these numbers do not separate them", several.join(", or as "))),
    }
}

/// The factor between two numbers, where it is one that slips make: N, N², powers of ten.
fn named_factor(factor: f64, ratio: f64) -> Option<String> {
    let near = |of: f64| (factor / of - 1.0).abs() < 0.06;
    let of_ratio = [("N", ratio), ("N²", ratio * ratio), ("1/N", 1.0 / ratio), ("1/N²", 1.0 / (ratio * ratio))];
    let found = of_ratio.into_iter().find(|(_, of)| near(*of)).map(|(name, _)| name.to_string());
    found.or_else(|| (-4..=4).filter(|k| *k != 0).find(|k| near(10.0_f64.powi(*k))).map(|k| format!("10^{k}")))
}

fn inertia_side(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let (output, rotor) = (module.constants().inertia?, value(module.sheet.rotor_inertia)?);
    let ratio = module.ratio();
    let share = output / (rotor * ratio * ratio);
    if (0.97..1.6).contains(&share) {
        return None;
    }
    let factor = named_factor(share, ratio).map(|name| format!("the factor between them is {name}"));
    error(format!("the armature is {} times the bare rotor's inertia times N²", number(share)), factor)
}

fn inertia_size(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let (mass, diameter) = (value(module.sheet.mass)?, value(module.sheet.outer_diameter)?);
    let at_motor = module.constants().inertia? / module.ratio().powi(2);
    let share = at_motor / (mass * (diameter / 2.0).powi(2));
    if (0.02..0.25).contains(&share) {
        return None;
    }
    let (rows, wide) = ("of eight modules of one maker it is 0.068 to 0.12", (at_motor / (0.12 * mass)).sqrt() * 2e3);
    note(
        format!("the inertia at the motor is {} of m (D/2)²; {rows}", number(share)),
        Some(format!("at 0.12 the rotor's diameter would be {} mm", number(wide))),
    )
}

/// q-axis torque per ampere at the output under a reading.
fn torque_per_ampere(module: &Module, current: CurrentConvention, side: Side) -> Option<f64> {
    let printed = value(module.sheet.torque_constant)?;
    let at_output = if side == Side::Motor { printed * module.ratio() } else { printed };
    Some(at_output * current.torque_constant(Commutation::Brushless))
}

const CURRENTS: [CurrentConvention; 3] =
    [CurrentConvention::Rms, CurrentConvention::PhaseAmplitude, CurrentConvention::Dc];

fn said(current: CurrentConvention) -> &'static str {
    crate::catalog::convention::word(CurrentConvention::NAMES, &current)
}

fn torque_constant(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let (sheet, refers) = (&module.sheet, &module.refers);
    // What was measured at the output has the gear's loss in it already.
    let measured = refers.torque_constant_loss == Some(TorqueLoss::Measured);
    let points = [
        ("rated", value(sheet.rated_torque), value(sheet.rated_current), (if measured { 0.85 } else { 0.7 }, 1.06)),
        ("peak", value(sheet.peak_torque), value(sheet.peak_current), (0.55, 1.06)),
    ];
    let share = |constant: CurrentConvention, side: Side, rating: CurrentConvention, torque: f64, current: f64| {
        let per_ampere = torque_per_ampere(module, constant, side)?;
        Some(torque / (per_ampere * current * rating.torque_current(Commutation::Brushless)))
    };
    let (constant, side, rating) = (refers.torque_constant_current?, refers.torque_constant_side?, refers.current?);
    let known: Vec<_> = points
        .iter()
        .filter_map(|(what, torque, current, within)| Some((*what, (*torque)?, (*current)?, *within)))
        .collect();
    let fits = |constant, side, rating| {
        known.iter().all(|(_, torque, current, (low, high))| {
            share(constant, side, rating, *torque, *current).is_some_and(|s| (*low..=*high).contains(&s))
        })
    };
    if known.is_empty() || fits(constant, side, rating) {
        return None;
    }
    let shares: Vec<String> = known
        .iter()
        .filter_map(|(what, torque, current, _)| {
            Some(format!("{what} {}", number(share(constant, side, rating, *torque, *current)?)))
        })
        .collect();
    let mut readings = Vec::new();
    for other in [Side::Output, Side::Motor] {
        for of_constant in CURRENTS {
            for of_rating in CURRENTS {
                if fits(of_constant, other, of_rating) {
                    let place = other.word();
                    readings.push(format!(
                        "K_T per {} at the {place} with currents that are {}",
                        said(of_constant),
                        said(of_rating)
                    ));
                }
            }
        }
    }
    error(format!("torque over K_T times current is: {}", shares.join(", ")), fitting(readings))
}

fn back_emf(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let refers = &module.refers;
    let (constant, side) = (refers.torque_constant_current?, refers.torque_constant_side?);
    let (convention, emf_side) = (refers.back_emf_convention?, refers.back_emf_side?);
    let printed = value(module.sheet.back_emf_constant)?;
    let efficiency = |constant, side, convention: BackEmfConvention, emf_side| {
        let at_output = if emf_side == Side::Motor { printed * module.ratio() } else { printed };
        Some(
            torque_per_ampere(module, constant, side)?
                / (at_output * convention.back_emf_constant(Commutation::Brushless)),
        )
    };
    // N K_T has no loss in it.
    let within = match refers.torque_constant_loss {
        Some(TorqueLoss::Measured) => 0.6..=1.02,
        _ => 0.95..=1.05,
    };
    let found = efficiency(constant, side, convention, emf_side)?;
    if within.contains(&found) {
        return None;
    }
    let mut readings = Vec::new();
    for other in [BackEmfConvention::LineToLineRms, BackEmfConvention::LineToLinePeak, BackEmfConvention::PhasePeak] {
        for at in [Side::Motor, Side::Output] {
            for of_constant in CURRENTS {
                if efficiency(of_constant, side, other, at).is_some_and(|e| within.contains(&e)) {
                    let name = crate::catalog::convention::word(BackEmfConvention::NAMES, &other);
                    readings.push(format!("K_B {name} at the {} with K_T per {}", at.word(), said(of_constant)));
                }
            }
        }
    }
    error(format!("the torque constant at the output is {} of N K_B", number(found)), fitting(readings))
}

fn no_load_speed(of: &Of) -> Option<Outcome> {
    let sheet = &of.module.sheet;
    let (volt, speed) = (value(sheet.voltage)?, value(sheet.no_load_speed)?);
    let share = speed * of.module.constants().back_emf_constant? / (volt / 2.0_f64.sqrt());
    if (0.75..=1.03).contains(&share) {
        return None;
    }
    let explanation = match share {
        share if (0.65..0.75).contains(&share) => Some("0.75 to 0.866 is sine modulation".to_string()),
        share if share > 1.0 => {
            Some(format!("it takes {} V: the speed may be that of another voltage", number(volt * share)))
        }
        _ => None,
    };
    error(format!("the no-load speed takes {} of what {} V can make", number(share), number(volt)), explanation)
}

fn speed_constant(of: &Of) -> Option<Outcome> {
    let (module, sheet) = (of.module, &of.module.sheet);
    let (printed, volt, speed) = (value(sheet.speed_constant)?, value(sheet.voltage)?, value(sheet.no_load_speed)?);
    let side = module.refers.speed_constant_side?;
    let share = |side: Side| {
        let at_output = if side == Side::Motor { printed / module.ratio() } else { printed };
        speed / (at_output * volt)
    };
    let fits = |side: Side| (0.75..=1.08).contains(&share(side));
    if fits(side) {
        return None;
    }
    let other = if side == Side::Motor { Side::Output } else { Side::Motor };
    let readings = if fits(other) { vec![format!("a constant at the {}", other.word())] } else { Vec::new() };
    let what = format!("the no-load speed is {} of speed constant times voltage", number(share(side)));
    error(what, fitting(readings))
}

fn power(of: &Of) -> Option<Outcome> {
    let sheet = &of.module.sheet;
    let made = value(sheet.rated_torque)? * value(sheet.rated_speed)?;
    let share = value(sheet.rated_power)? / made;
    let within = match of.module.refers.rated_power_is? {
        RatedPower::Mechanical => 0.95..=1.05,
        RatedPower::Electrical => 1.0..=2.0,
    };
    if within.contains(&share) {
        return None;
    }
    let speed = number(value(sheet.rated_power)? / value(sheet.rated_torque)? * 30.0 / std::f64::consts::PI);
    note(
        format!("the rated power is {} of rated torque times rated speed", number(share)),
        Some(format!("with the rated torque it is that of {speed} rpm")),
    )
}

fn most(points: &[[f64; 2]]) -> Option<f64> {
    points.iter().map(|point| point[1]).reduce(f64::max)
}

fn braking(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let (driving, braking) = (most(&module.driving_curve)?, most(&module.braking_curve)?);
    let efficiency = module.efficiency_of_braking()?;
    if braking < driving {
        return error(
            format!(
                "while it is driven it has {} N*m, less than the {} N*m while it drives: its gear would have an efficiency of {}",
                number(braking),
                number(driving),
                number(efficiency)
            ),
            Some("the two may be swapped, or a digit is missing".into()),
        );
    }
    let mut others = of.siblings().filter_map(Module::efficiency_of_braking);
    let unlike = others.find(|other| (efficiency - other).abs() > 0.06)?;
    note(
        format!(
            "its peak torques say a gear efficiency of {}, those of its family {}",
            number(efficiency),
            number(unlike)
        ),
        None,
    )
}

fn no_loss(of: &Of) -> Option<Outcome> {
    let module = of.module;
    // A motor row that was made from the module says nothing of its own.
    let motor = of.motors.iter().find(|m| m.id == module.motor && m.about.only_inside.is_empty())?;
    let ratio = module.ratio();
    let same = |a: Option<f64>, b: Option<f64>| Some((a? / (ratio * b?) - 1.0).abs() < 2e-3);
    let torques = [module.sheet.peak_torque, module.sheet.rated_torque].map(value);
    let own = [motor.peak_torque, motor.continuous_torque];
    let is = torques.iter().any(|torque| own.iter().any(|of| same(*torque, *of) == Some(true)));
    is.then(|| Outcome {
        severity: Severity::Note,
        message: "a torque at the output is N times that of the bare motor: nothing is lost in the gear".into(),
        explanation: Some("it may be computed, not measured".into()),
    })
}

fn overload(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let bent = bends(value(module.sheet.rated_torque)?, &module.overload);
    let message = format!("its overload table bends the wrong way: a time is {} times too long", number(1.0 + bent));
    match bent {
        bent if bent > BENDS => error(message, Some("it is not used; `rated_torque` takes its place".into())),
        bent if bent > 0.05 => note(message, Some("times are rounded".into())),
        _ => None,
    }
}

fn rated_point(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let (torque, speed) = (value(module.sheet.rated_torque)?, value(module.sheet.rated_speed)?);
    if value(module.sheet.no_load_speed).is_some_and(|free| speed > free * 1.001) {
        return error("the rated speed is beyond the speed without load".into(), None);
    }
    let curve = &module.driving_curve;
    if curve.is_empty() {
        return None;
    }
    let gives = on_curve(curve, speed);
    if torque <= gives * 1.02 {
        return None;
    }
    error(
        format!("at the rated speed the curve gives {} N*m, less than the rated {} N*m", number(gives), number(torque)),
        None,
    )
}

fn siblings(of: &Of) -> Option<Outcome> {
    let of_motor = |module: &Module| {
        let (constants, ratio) = (module.constants(), module.ratio());
        [constants.torque_constant.map(|k| k / ratio), constants.inertia.map(|j| j / (ratio * ratio))]
    };
    let own = of_motor(of.module);
    for other in of.siblings() {
        for ((what, a), b) in ["K_T/N", "J/N²"].into_iter().zip(own).zip(of_motor(other)) {
            let Some((a, b)) = a.zip(b) else { continue };
            if (a / b - 1.0).abs() > 0.1 {
                return note(
                    format!("{what} is {} times that of `{}`, of the same family", number(a / b), other.id),
                    Some("one of the two may be that of the other ratio".into()),
                );
            }
        }
    }
    None
}

/// By how many times published numbers of one thing may differ.
const SPREAD: f64 = 1.2;

fn alternatives(of: &Of) -> Option<Outcome> {
    let apart = |spread: &Spread| {
        let [least, most] = spread.ends;
        spread.disagree && (least <= 0.0 || most / least > SPREAD)
    };
    let spreads = spreads(of.module, of.alternatives);
    let told = |spread: &Spread| {
        let [least, most] = spread.ends;
        let field = MODULE_FIELDS.iter().find(|f| f.name == spread.column);
        let unit = field.map_or("1", |f| f.kind.si);
        let times = if least > 0.0 { format!(", {} times", number(most / least)) } else { String::new() };
        let (least, most) = (number(least), with_unit(most, unit));
        format!("`{}`: {} published numbers are between {least} and {most}{times}", spread.column, spread.compared)
    };
    let told: Vec<String> = spreads.iter().filter(|spread| apart(spread)).map(told).collect();
    let explanation = "`gearwise catalog show` prints them with their sources; the row's own number counts".to_string();
    if told.is_empty() { None } else { note(told.join("; "), Some(explanation)) }
}

/// By how much numbers of one thing differ by rounding and reading off pictures.
const READ_OFF: f64 = 1.06;

fn curve(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let most = module.largest_of_curve()?;
    if let Some(peak) = value(module.sheet.peak_torque).filter(|peak| most > peak * READ_OFF) {
        let message =
            format!("its driving curve reaches {} N*m, above its peak torque {} N*m", number(most), number(peak));
        return error(message, None);
    }
    let (end, free) = (module.end_of_curve()?, value(module.sheet.no_load_speed)?);
    if (1.0 / READ_OFF..READ_OFF).contains(&(end / free)) {
        return None;
    }
    error(format!("its driving curve ends at {} rad/s, its no-load speed is {} rad/s", number(end), number(free)), None)
}

fn inside(of: &Of) -> Option<Outcome> {
    let module = of.module;
    let motor = of.motors.iter().find(|m| m.id == module.motor && !m.id.is_empty())?;
    let own = module.refers.current.zip(module.sheet.peak_current);
    let own = own.map(|(is, p)| p.value * is.torque_current(Commutation::Brushless));
    let mut found = Vec::new();
    if let (Some(whole), Some(part)) = (value(module.sheet.mass), motor.mass)
        && whole < part / READ_OFF
    {
        found.push(format!("its mass {} kg is less than that of its motor row, {} kg", number(whole), number(part)));
    }
    if let (Some(own), Some(other)) = (own, motor.peak_current)
        && !(1.0 / READ_OFF..READ_OFF).contains(&(own / other))
    {
        found.push(format!(
            "its peak current is {} A, that of its motor row {} A (q axis)",
            number(own),
            number(other)
        ));
    }
    if found.is_empty() {
        None
    } else {
        note(found.join("; "), Some("the smaller current counts, and its own mass".into()))
    }
}
