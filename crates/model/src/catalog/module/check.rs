//! What a module's row cannot say: numbers without their side or convention, curves and tables that contradict themselves.

use super::{Module, Points, TorqueLoss};
use crate::catalog::convention::Terminals;
use crate::catalog::row::Side;
pub use crate::catalog::wrong::Wrong;
use crate::words::number;

/// By how much a curve may reach beyond the speed without load.
const BEYOND_NO_LOAD: f64 = 1.05;

/// All mistakes of a row.
pub fn wrong(module: &Module) -> Vec<Wrong> {
    let mut found = undeclared(module);
    found.extend(curves(module));
    found.extend(tables(module));
    let sheet = &module.sheet;
    let mut order = |low: Option<f64>, high: Option<f64>, column: &'static str, message: &str| {
        if let (Some(low), Some(high)) = (low, high)
            && low > high
        {
            let (label, help) = ("the two may be swapped", "look at the source");
            found.push(Wrong { column, message: message.into(), label, help: help.into() });
        }
    };
    let value = |p: Option<crate::catalog::Printed>| p.map(|p| p.value);
    order(
        value(sheet.rated_torque),
        value(sheet.peak_torque),
        "peak_torque",
        "`peak_torque` is less than `rated_torque`",
    );
    order(
        value(sheet.rated_current),
        value(sheet.peak_current),
        "peak_current",
        "`peak_current` is less than `rated_current`",
    );
    order(
        value(sheet.min_voltage),
        value(sheet.max_voltage),
        "max_voltage",
        "`max_voltage` is less than `min_voltage`",
    );
    if value(sheet.backdrive_efficiency).is_some_and(|b| b > 1.0) {
        found.push(Wrong {
            column: "backdrive_efficiency",
            message: "`backdrive_efficiency` is out of range".into(),
            label: "expected at most 1",
            help: "it is that of the gear when the load drives".into(),
        });
    }
    found
}

/// Numbers that say neither at which side nor in which convention they are.
fn undeclared(module: &Module) -> Vec<Wrong> {
    let (sheet, refers) = (&module.sheet, &module.refers);
    let mut found = Vec::new();
    let mut need = |given: bool, said: bool, column: &'static str, message: String, help: &'static str| {
        if given && !said {
            found.push(Wrong { column, message, label: "what does it refer to?", help: help.into() });
        }
    };
    let without = |column: &str, of: &str| format!("`{column}` is given without `{of}`");
    if let (Some(armature), None) = (sheet.armature, refers.armature_side) {
        let times = number(module.ratio().powi(2));
        let message = format!(
            "`armature` is given without `armature_side`: {} kg*m^2 is {times} times as much at the other side",
            number(armature.value)
        );
        need(
            true,
            false,
            "armature",
            message,
            "say `motor` or `output`; where the source does not say it, leave it out",
        );
    }
    for (column, given) in [
        ("static_friction", sheet.static_friction.is_some()),
        ("dynamic_friction", sheet.dynamic_friction.is_some()),
        ("viscous_friction", sheet.viscous_friction.is_some()),
    ] {
        need(
            given,
            refers.friction_side.is_some(),
            column,
            without(column, "friction_side"),
            "say `motor` or `output`",
        );
    }
    let torque = sheet.torque_constant.is_some();
    let current = "say what its ampere is: rms, phase_amplitude, dc or q_axis";
    for (of, said, help) in [
        ("torque_constant_current", refers.torque_constant_current.is_some(), current),
        ("torque_constant_side", refers.torque_constant_side.is_some(), "say `motor` or `output`"),
        (
            "torque_constant_loss",
            refers.torque_constant_loss.is_some() || refers.torque_constant_side == Some(Side::Motor),
            "`nominal` is N K_T without the gear's loss, `measured` what arrives at the flange",
        ),
    ] {
        need(torque, said, "torque_constant", without("torque_constant", of), help);
    }
    if torque
        && refers.torque_constant_side == Some(Side::Motor)
        && refers.torque_constant_loss == Some(TorqueLoss::Measured)
    {
        let message = "a torque constant at the motor has no gear's loss in it".to_string();
        need(true, false, "torque_constant", message, "leave `torque_constant_loss` blank, or say `nominal`");
    }
    for (column, given, of, said) in [
        (
            "back_emf_constant",
            sheet.back_emf_constant.is_some(),
            "back_emf_convention",
            refers.back_emf_convention.is_some(),
        ),
        ("back_emf_constant", sheet.back_emf_constant.is_some(), "back_emf_side", refers.back_emf_side.is_some()),
        (
            "speed_constant",
            sheet.speed_constant.is_some(),
            "speed_constant_convention",
            refers.speed_constant_convention.is_some(),
        ),
        ("speed_constant", sheet.speed_constant.is_some(), "speed_constant_side", refers.speed_constant_side.is_some()),
        ("resistance", sheet.resistance.is_some(), "terminals", refers.terminals.is_some()),
        ("inductance", sheet.inductance.is_some(), "terminals", refers.terminals.is_some()),
        ("rated_current", sheet.rated_current.is_some(), "current", refers.current.is_some()),
        ("peak_current", sheet.peak_current.is_some(), "current", refers.current.is_some()),
        ("rated_power", sheet.rated_power.is_some(), "rated_power_is", refers.rated_power_is.is_some()),
        ("no_load_current", sheet.no_load_current.is_some(), "no_load_current_is", refers.no_load_current_is.is_some()),
    ] {
        need(given, said, column, without(column, of), "give both, or leave the number out and say it in the note");
    }
    need(
        refers.terminals == Some(Terminals::Winding),
        refers.winding.is_some(),
        "terminals",
        "`terminals` is `winding`, but `winding` does not say wye or delta".into(),
        "give winding as wye or delta",
    );
    found
}

/// Curves of torque over speed.
fn curves(module: &Module) -> Vec<Wrong> {
    let no_load = module.sheet.no_load_speed.map(|p| p.value);
    let of = |column: &'static str, points: &Points, driving: bool| {
        let mut found = Vec::new();
        let mut wrong =
            |message: String, label, help: &str| found.push(Wrong { column, message, label, help: help.into() });
        let Some(first) = points.first() else { return found };
        if first[0] != 0.0 {
            wrong(format!("`{column}` does not begin at standstill"), "its first speed is not 0", "begin with 0:…");
        }
        if points.len() < 2 {
            wrong(format!("`{column}` has one point"), "a curve has two or more", "write speed:torque, from 0 on");
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            let message = format!(
                "`{column}`: the speed does not rise, {} after {} rad/s",
                number(pair[1][0]),
                number(pair[0][0])
            );
            wrong(message, "expected rising speeds", "each pair is speed:torque");
        }
        if points.iter().all(|point| point[1] == 0.0) {
            wrong(format!("`{column}` gives no torque at any speed"), "all torques are 0", "each pair is speed:torque");
        }
        let last = points.iter().rfind(|point| point[1] > 0.0);
        if let (true, Some(last), Some(no_load)) = (driving, last, no_load)
            && last[0] > no_load * BEYOND_NO_LOAD
        {
            let message = format!(
                "`{column}` gives torque at {} rad/s, beyond `no_load_speed`, {} rad/s",
                number(last[0]),
                number(no_load)
            );
            wrong(message, "faster than without load", "look at units and voltages");
        }
        found
    };
    [of("driving_curve", &module.driving_curve, true), of("braking_curve", &module.braking_curve, false)].concat()
}

/// Tables of overload: more torque is borne for less time.
fn tables(module: &Module) -> Vec<Wrong> {
    let of = |column: &'static str, points: &Points| {
        let mut found = Vec::new();
        if let Some(pair) = points.windows(2).find(|pair| pair[1][0] <= pair[0][0] || pair[1][1] > pair[0][1]) {
            let [[torque, time], [more, longer]] = [pair[0], pair[1]];
            found.push(Wrong {
                column,
                message: format!(
                    "`{column}`: {} N*m for {} s after {} N*m for {} s",
                    number(more),
                    number(longer),
                    number(torque),
                    number(time)
                ),
                label: "expected rising torques that are borne for less and less time",
                help: "each pair is torque:time".into(),
            });
        }
        found
    };
    [of("overload", &module.overload), of("overload_stall", &module.overload_stall)].concat()
}
