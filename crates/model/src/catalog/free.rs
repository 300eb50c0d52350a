//! The motors that are a free choice: without what is only sold inside a module, and each motor once.

use std::collections::{HashMap, HashSet};

use super::row::States;
use super::{Catalog, FIELDS, Motor};

impl Catalog {
    /// The catalogue as one chooses from it. A row that is `only_inside` a module leaves the choice, unless
    /// `also_inside`; a row that is `same_as` another is joined with it. Both can still be named ([`Catalog::motor`]):
    /// they stand in `aside`.
    pub fn free(self, also_inside: bool) -> Catalog {
        let is_inside = |m: &Motor| !also_inside && !m.about.only_inside.is_empty();
        // A row that is the same as one inside a module stays where that one leaves.
        let ids: HashSet<String> = self.motors.iter().filter(|m| !is_inside(m)).map(|m| m.id.clone()).collect();
        let is_twin = |m: &Motor| ids.contains(&m.about.same_as);
        let (aside, motors): (Vec<Motor>, Vec<Motor>) =
            self.motors.into_iter().partition(|m| is_twin(m) || is_inside(m));
        let mut twins: HashMap<&str, Vec<&Motor>> = HashMap::new();
        aside.iter().for_each(|twin| twins.entry(&twin.about.same_as).or_default().push(twin));
        let join = |motor: Motor| {
            let own = twins.get(motor.id.as_str()).map_or(&[][..], Vec::as_slice);
            own.iter().copied().fold(motor, joined)
        };
        let motors = motors.into_iter().map(join).collect();
        Catalog { motors, aside: [self.aside, aside].concat(), ..self }
    }

    /// Of a motor of the choice, the other rows of it.
    pub fn twins<'c>(&'c self, id: &'c str) -> impl Iterator<Item = &'c Motor> {
        self.aside.iter().filter(move |twin| twin.about.same_as == id)
    }
}

/// Columns that say the same in any row of a motor: sizes, and what the model follows heat with. Numbers that a sheet is
/// checked by (its K_M, its no-load point) stay with their sheet.
const OF_THE_MOTOR: &[&str] = &[
    "rotor_inertia",
    "rotor_mass",
    "mass",
    "gap_radius",
    "outer_diameter",
    "max_speed",
    "thermal_resistance_winding_housing",
    "thermal_resistance_housing_ambient",
    "thermal_time_constant_winding",
    "thermal_time_constant_housing",
    "max_winding_temperature",
    "coulomb_friction",
    "viscous_friction",
];

/// A motor with what only another row of it says. A current of the other row counts by its torque: the two may not mean
/// the same by an ampere.
fn joined(motor: Motor, twin: &Motor) -> Motor {
    let current = |current: Option<f64>| current.map(|i| i * twin.torque_constant / motor.torque_constant);
    let twin = Motor {
        continuous_current: current(twin.continuous_current),
        peak_current: current(twin.peak_current),
        demagnetization_current: current(twin.demagnetization_current),
        ..twin.clone()
    };
    let mut sheet = motor.sheet.clone();
    for field in FIELDS.iter().filter(|f| f.states == States::Nothing && OF_THE_MOTOR.contains(&f.name)) {
        if let (None, Some(printed)) = ((field.get)(&sheet), (field.get)(&twin.sheet)) {
            (field.set)(&mut sheet, printed);
        }
    }
    sheet.offer = sheet.offer.or(&twin.sheet.offer);
    Motor { sheet, ..motor }.filled_from(&twin)
}

impl Motor {
    /// The motor with what another has and it lacks; its sheet stays.
    pub fn filled_from(self, other: &Motor) -> Motor {
        Motor {
            inductance: self.inductance.or(other.inductance),
            rotor_inertia: self.rotor_inertia.or(other.rotor_inertia),
            mass: self.mass.or(other.mass),
            pole_pairs: self.pole_pairs.or(other.pole_pairs),
            continuous_current: self.continuous_current.or(other.continuous_current),
            peak_current: self.peak_current.or(other.peak_current),
            demagnetization_current: self.demagnetization_current.or(other.demagnetization_current),
            continuous_torque: self.continuous_torque.or(other.continuous_torque),
            peak_torque: self.peak_torque.or(other.peak_torque),
            max_speed: self.max_speed.or(other.max_speed),
            thermal_resistance: self.thermal_resistance.or(other.thermal_resistance),
            rated_thermal_resistance: self.rated_thermal_resistance.or(other.rated_thermal_resistance),
            max_winding_temperature: self.max_winding_temperature.or(other.max_winding_temperature),
            coulomb_friction: self.coulomb_friction.or(other.coulomb_friction),
            viscous_friction: self.viscous_friction.or(other.viscous_friction),
            no_load_torque: self.no_load_torque.or(other.no_load_torque),
            estimates: if self.estimates.is_empty() { other.estimates.clone() } else { self.estimates },
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_motor_stands_once_and_modules_insides_are_named_but_not_chosen() {
        let all = Catalog::builtin().unwrap();
        let count = all.motors.len();
        let free = all.clone().free(false);
        assert_eq!(free.motors.len() + free.aside.len(), count);
        assert!(free.motors.iter().all(|m| m.about.only_inside.is_empty() && m.about.same_as.is_empty()));
        assert_eq!(free.aside.iter().filter(|m| !m.about.only_inside.is_empty()).count(), 9);
        assert_eq!(free.motor("mit-mini-cheetah").unwrap().id, "mit-mini-cheetah");
        assert_eq!(free.twins("t-motor-u8-lee").map(|m| m.id.as_str()).collect::<Vec<_>>(), ["t-motor-u8"]);
        assert_eq!(all.free(true).motors.len(), count - 1);
    }

    #[test]
    fn a_joined_motor_has_what_either_row_says_and_the_newer_where_both_do() {
        let all = Catalog::builtin().unwrap();
        let (mut newer, mut older) =
            (all.motor("t-motor-u8-lee").unwrap().clone(), all.motor("t-motor-u8").unwrap().clone());
        let (torque, resistance) = (newer.continuous_current.unwrap() * newer.torque_constant, newer.resistance);
        (older.continuous_current, newer.continuous_current) = (newer.continuous_current, None);
        let torque = torque / newer.torque_constant * older.torque_constant;
        let both = joined(newer, &older);
        assert_eq!(both.resistance, resistance);
        assert!((both.continuous_current.unwrap() * both.torque_constant - torque).abs() < 1e-12);
    }

    #[test]
    fn a_row_whose_other_row_is_not_there_is_a_motor_of_its_own() {
        let all = Catalog::builtin().unwrap();
        let alone = Catalog::of(vec![all.motor("t-motor-u8").unwrap().clone()], Vec::new());
        assert_eq!(alone.free(false).motors.len(), 1);
    }
}
