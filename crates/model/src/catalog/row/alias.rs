//! Other names of columns, as people head them.
//!
//! The one idea: an alias is a name and nothing more. It says no convention and no unit: a torque constant that is headed
//! `Kt` states what an ampere is like one that is headed in full. What may mean two things is no alias (`poles` is not
//! `pole_pairs`). Only readers know aliases; what the program writes has the names of the columns.

macro_rules! aliases {
    ($($column:literal: $($alias:literal)*;)*) => {
        /// Each alias with its column, their `…_tolerance` too.
        pub const ALIASES: &[(&str, &str)] = &[$($(
            ($alias, $column),
            (concat!($alias, "_tolerance"), concat!($column, "_tolerance")),
        )*)*];
    };
}

aliases! {
    "id": "name";
    "manufacturer": "maker" "brand";
    "resistance": "R";
    "inductance": "L";
    "torque_constant": "Kt" "KT" "K_T" "kt";
    "back_emf_constant": "Ke" "KE" "K_e" "Kb" "K_B";
    "speed_constant": "KV" "Kv" "K_V" "kv";
    "motor_constant": "Km" "KM" "K_M";
    "rotor_inertia": "J" "Jm" "J_m";
    "mass": "weight";
    "outer_diameter": "diameter" "OD";
    "length": "axial_length";
    "construction": "built";
    "continuous_current": "I_cont";
    "peak_current": "I_peak";
    "continuous_torque": "T_cont";
    "peak_torque": "T_peak";
    "no_load_current": "I0" "I_0";
    "reference_temperature": "T_ref";
    "ratio": "N";
    "efficiency": "eta";
}

/// The column that a name is another one of.
///
/// ```
/// use gearwise_model::catalog::row::column_of;
/// assert_eq!((column_of("Kt"), column_of("torque_constant")), (Some("torque_constant"), None));
/// ```
pub fn column_of(name: &str) -> Option<&'static str> {
    ALIASES.iter().find(|(alias, _)| *alias == name).map(|(_, column)| *column)
}

/// The other names of a column.
pub fn aliases_of(column: &str) -> impl Iterator<Item = &'static str> {
    ALIASES.iter().filter(move |(_, of)| *of == column).map(|(alias, _)| *alias)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::catalog::{gear_columns, motor_columns};

    #[test]
    fn an_alias_is_no_column_and_means_one() {
        let columns: HashSet<String> = motor_columns().into_iter().chain(gear_columns()).map(|c| c.name).collect();
        let mut seen = HashSet::new();
        for (alias, column) in ALIASES {
            assert!(seen.insert(alias), "{alias} stands twice");
            assert!(!columns.contains(*alias), "{alias} is a column");
            assert!(columns.contains(*column) || column.ends_with("_tolerance"), "{column} is none");
        }
    }
}
