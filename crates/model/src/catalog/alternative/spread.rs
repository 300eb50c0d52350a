//! Numbers of one thing, compared: at the flange and on the q axis.

use super::Alternative;
use crate::catalog::Field;
use crate::catalog::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding, word,
};
use crate::catalog::module::{MODULE_FIELDS, Module, ModuleSheet, NoLoadCurrent};
use crate::catalog::row::{Side, find};
use crate::catalog::sheet::Printed;

/// What a module's number is at the flange and on the q axis: it, times this. `None` where its side or convention is not said.
fn factor(
    module: &Module,
    column: &str,
    side: Option<Side>,
    convention: Option<&str>,
    winding: Option<Winding>,
) -> Option<f64> {
    let brushless = Commutation::Brushless;
    let at_output = |power: i32| {
        Some(match side? {
            Side::Output => 1.0,
            Side::Motor => module.ratio().powi(power),
        })
    };
    let of_current = || find(CurrentConvention::NAMES, convention?);
    match column {
        "armature" | "viscous_friction" => at_output(2),
        "static_friction" | "dynamic_friction" => at_output(1),
        "torque_constant" => Some(at_output(1)? * of_current()?.torque_constant(brushless)),
        "rated_current" | "peak_current" | "no_load_current" => Some(of_current()?.torque_current(brushless)),
        "back_emf_constant" => {
            Some(at_output(1)? * find(BackEmfConvention::NAMES, convention?)?.back_emf_constant(brushless))
        }
        "speed_constant" => {
            Some(at_output(-1)? / find(SpeedConstantConvention::NAMES, convention?)?.back_emf_constant(brushless))
        }
        "resistance" | "inductance" => find(Terminals::NAMES, convention?)?.resistance(winding, brushless),
        _ => Some(1.0),
    }
}

impl Alternative {
    /// Its number at the flange of its module and on the q axis; `None` where its source does not say side or convention, and of
    /// curves and tables.
    pub fn at_flange(&self, module: &Module) -> Option<Printed> {
        let winding = module.refers.winding;
        Some(self.value?.times(factor(module, self.column, self.side, self.convention, winding)?))
    }

    /// Its number as the module's row would print it; `None` where the two cannot be compared.
    pub fn as_in(&self, module: &Module) -> Option<Printed> {
        Some(self.at_flange(module)?.times(1.0 / own_factor(module, self.column)?))
    }
}

fn own_factor(module: &Module, column: &str) -> Option<f64> {
    let refers = &module.refers;
    let convention = match column {
        "torque_constant" => refers.torque_constant_current.map(|is| word(CurrentConvention::NAMES, &is)),
        "back_emf_constant" => refers.back_emf_convention.map(|is| word(BackEmfConvention::NAMES, &is)),
        "speed_constant" => refers.speed_constant_convention.map(|is| word(SpeedConstantConvention::NAMES, &is)),
        "resistance" | "inductance" => refers.terminals.map(|is| word(Terminals::NAMES, &is)),
        "no_load_current" => refers.no_load_current_is.and_then(|is| match is {
            NoLoadCurrent::Winding(is) => Some(word(CurrentConvention::NAMES, &is)),
            NoLoadCurrent::Supply => None,
        }),
        _ => refers.current.map(|is| word(CurrentConvention::NAMES, &is)),
    };
    let side = match column {
        "armature" => refers.armature_side,
        "torque_constant" => refers.torque_constant_side,
        "back_emf_constant" => refers.back_emf_side,
        "speed_constant" => refers.speed_constant_side,
        _ => refers.friction_side,
    };
    factor(module, column, side, convention, refers.winding)
}

/// How far the published numbers of a column of a module are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The column.
    pub column: &'static str,
    /// The least and the largest, at the flange and on the q axis, SI.
    pub ends: [f64; 2],
    /// Whether their ± leave a gap between them.
    pub disagree: bool,
    /// How many numbers are compared, the row's own one among them where it has one.
    pub compared: usize,
}

/// How far the published numbers of a module are apart, by column: those that say their side and convention.
pub fn spreads(module: &Module, alternatives: &[Alternative]) -> Vec<Spread> {
    let mine = |a: &&Alternative| a.id == module.id;
    let of_column = |field: &Field<ModuleSheet>| {
        let others = alternatives.iter().filter(mine).filter(|a| a.column == field.name);
        let mut all: Vec<Printed> = others.filter_map(|a| a.at_flange(module)).collect();
        if all.is_empty() {
            return None;
        }
        let own = (field.get)(&module.sheet).zip(own_factor(module, field.name));
        all.extend(own.map(|(printed, by)| printed.times(by)));
        let least = all.iter().map(|p| p.value).fold(f64::INFINITY, f64::min);
        let most = all.iter().map(|p| p.value).fold(f64::NEG_INFINITY, f64::max);
        let low = |p: &Printed| p.value - p.tolerance.unwrap_or(0.0);
        let high = |p: &Printed| p.value + p.tolerance.unwrap_or(0.0);
        let disagree =
            all.iter().map(low).fold(f64::NEG_INFINITY, f64::max) > all.iter().map(high).fold(f64::INFINITY, f64::min);
        (all.len() > 1).then_some(Spread { column: field.name, ends: [least, most], disagree, compared: all.len() })
    };
    MODULE_FIELDS.iter().filter_map(of_column).collect()
}
