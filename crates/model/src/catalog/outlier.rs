//! Numbers that do not fit those of rows built alike: K_M of a motor grows with a power of its mass, the inertia of its rotor with
//! mass times diameter squared, the mass of a gear with its torque.

use super::finding::Beside;
use super::{Catalog, Construction, Gear, GearKind, Motor};
use crate::words::with_unit;

/// Every comparison: its code, and what is compared.
pub fn comparisons() -> impl Iterator<Item = (&'static str, String)> {
    let line = |of: &str, at: &str| format!("{of} against that of rows built alike at the same {at}");
    let motors = OF_MOTORS.iter().map(move |r| (r.code, line(r.of.0, r.at.0)));
    motors.chain(OF_GEARS.iter().map(move |r| (r.code, line(r.of.0, r.at.0))))
}

/// Whether a code is that of a remark that only other rows allow.
pub fn is_code(code: &str) -> bool {
    comparisons().any(|(own, _)| own == code)
}

/// Fewest rows built alike that a row is compared with.
const FEWEST: usize = 8;

/// Deviations from the line of others, in typical ones, from which on a row is remarkable.
const DEVIATIONS: f64 = 3.5;

/// A median deviation is this many times less than a standard one, of normal scatter.
const NORMAL: f64 = 1.4826;

/// Most points that a line is laid through: of more, evenly many.
const MOST: usize = 400;

/// Two numbers of a row, of which the second grows with a power of the first among rows built alike.
struct Relation<R> {
    code: &'static str,
    /// What is looked at, and its SI unit.
    of: (&'static str, &'static str),
    /// What it is compared at, and its SI unit.
    at: (&'static str, &'static str),
    /// A row is remarkable from this factor on.
    factor: f64,
    /// Both numbers, at and of, SI.
    numbers: fn(&R) -> Option<(f64, f64)>,
    explanation: &'static str,
}

const OF_MOTORS: &[Relation<Motor>] = &[
    Relation {
        code: "motor-constant-for-mass",
        of: ("K_M", "N*m/W^0.5"),
        at: ("mass", "kg"),
        factor: 2.0,
        numbers: |m| Some((m.mass?, m.motor_constant())),
        explanation: "an unusual motor, a mass of the active parts alone or of a whole module, or K_T, R or mass in another unit or convention",
    },
    Relation {
        code: "rotor-inertia-for-size",
        of: ("rotor inertia", "kg*m^2"),
        at: ("m D^2", "kg*m^2"),
        factor: 6.0,
        numbers: |m| Some((m.mass? * m.sheet.outer_diameter?.value.powi(2), m.rotor_inertia?)),
        explanation: "an unusual motor, or inertia, mass or diameter in another unit",
    },
    Relation {
        code: "thermal-resistance-for-mass",
        of: ("thermal resistance to ambient", "K/W"),
        at: ("mass", "kg"),
        factor: 4.0,
        numbers: |m| {
            let (winding, housing) =
                (m.sheet.thermal_resistance_winding_housing?, m.sheet.thermal_resistance_housing_ambient?);
            Some((m.mass?, winding.value + housing.value))
        },
        explanation: "another cooling than the other rows have (a fan, water, a large plate), or another unit",
    },
    Relation {
        code: "continuous-torque-for-mass",
        of: ("K_T times the continuous current", "N*m"),
        at: ("mass", "kg"),
        factor: 5.0,
        numbers: |m| Some((m.mass?, m.torque_constant * m.continuous_current?)),
        explanation: "another cooling than the other rows have, a current of another duration, or another unit or convention",
    },
    Relation {
        code: "diameter-for-mass",
        of: ("outer diameter", "m"),
        at: ("mass", "kg"),
        factor: 2.5,
        numbers: |m| Some((m.mass?, m.sheet.outer_diameter?.value)),
        explanation: "an unusual motor, or diameter or mass in another unit",
    },
    Relation {
        code: "max-speed-for-mass",
        of: ("largest speed", "rad/s"),
        at: ("mass", "kg"),
        factor: 5.0,
        numbers: |m| Some((m.mass?, m.max_speed?)),
        explanation: "an unusual motor, or a speed in another unit",
    },
];

const OF_GEARS: &[Relation<Gear>] = &[
    Relation {
        code: "gear-mass-for-torque",
        of: ("mass", "kg"),
        at: ("peak torque", "N*m"),
        factor: 6.0,
        numbers: |g| Some((g.peak_torque?, g.mass?)),
        explanation: "a gear of another build (a component set, a servo gearhead), or mass or torque in another unit",
    },
    Relation {
        code: "gear-inertia-for-mass",
        of: ("inertia at the input", "kg*m^2"),
        at: ("mass", "kg"),
        factor: 12.0,
        numbers: |g| Some((g.mass?, g.inertia.filter(|j| *j > 0.0)?)),
        explanation: "an inertia at the output, or in another unit",
    },
    Relation {
        code: "gear-stiffness-for-torque",
        of: ("stiffness", "N*m/rad"),
        at: ("peak torque", "N*m"),
        factor: 8.0,
        numbers: |g| Some((g.peak_torque?, g.stiffness?)),
        explanation: "a stiffness per arc minute, or in another unit",
    },
    Relation {
        code: "gear-speed-for-mass",
        of: ("largest input speed", "rad/s"),
        at: ("mass", "kg"),
        factor: 5.0,
        numbers: |g| Some((g.mass?, g.max_input_speed?)),
        explanation: "a speed at the output, or in another unit",
    },
];

fn median(mut of: Vec<f64>) -> Option<f64> {
    of.sort_by(f64::total_cmp);
    let middle = of.len() / 2;
    match of.len() {
        0 => None,
        n if n % 2 == 1 => Some(of[middle]),
        _ => Some((of[middle - 1] + of[middle]) / 2.0),
    }
}

/// A line that single points do not move: the median of all slopes (Theil and Sen), and of what is left.
fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let drawn = points.len().min(MOST);
    let points: Vec<(f64, f64)> = (0..drawn).map(|k| points[k * points.len() / drawn]).collect();
    let pairs = points.iter().enumerate().flat_map(|(k, a)| points[..k].iter().map(move |b| (a, b)));
    let slopes = pairs.filter(|(a, b)| (a.0 - b.0).abs() > 0.05).map(|(a, b)| (a.1 - b.1) / (a.0 - b.0)).collect();
    let slope = median(slopes)?;
    Some((median(points.iter().map(|p| p.1 - slope * p.0).collect())?, slope))
}

/// The remark on each row whose numbers are far from what rows of the catalogue that are built alike have; of a kind with fewer
/// than eight rows that say both numbers there is none.
pub fn outliers(catalog: &Catalog) -> Vec<Beside> {
    let mut found = Vec::new();
    for relation in OF_MOTORS {
        for (built, construction) in Construction::NAMES {
            // Of a module its own row is looked at.
            let alike =
                catalog.motors.iter().filter(|m| m.inside.is_none() && m.about.construction == Some(*construction));
            off_the_line(relation, built, alike, |m| &m.id, &mut found);
        }
    }
    for relation in OF_GEARS {
        for (name, kind) in GearKind::NAMES {
            let alike = catalog.gears.iter().filter(|g| g.kind == *kind);
            off_the_line(relation, &name.replace('_', " "), alike, |g| &g.id, &mut found);
        }
    }
    found
}

fn off_the_line<'r, R: 'r>(
    relation: &Relation<R>,
    built: &str,
    alike: impl Iterator<Item = &'r R>,
    id: impl Fn(&R) -> &str,
    found: &mut Vec<Beside>,
) {
    let numbers = |row| (relation.numbers)(row).filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite());
    let rows: Vec<(&R, (f64, f64))> = alike.filter_map(|row| Some((row, numbers(row)?))).collect();
    if rows.len() < FEWEST {
        return;
    }
    let points: Vec<(f64, f64)> = rows.iter().map(|(_, (x, y))| (x.ln(), y.ln())).collect();
    let Some((intercept, slope)) = line(&points) else { return };
    let off = |point: &(f64, f64)| point.1 - intercept - slope * point.0;
    let Some(typical) = median(points.iter().map(|p| off(p).abs()).collect()) else { return };
    let least = relation.factor.ln().max(DEVIATIONS * NORMAL * typical);
    for ((row, (x, _)), point) in rows.iter().zip(&points).filter(|(_, point)| off(point).abs() > least) {
        let (factor, side) = (off(point).abs().exp(), if off(point) > 0.0 { "above" } else { "below" });
        let said = |value: f64, unit: &'static str| {
            let (value, unit) = crate::words::handy::handy(value, unit);
            with_unit(value, unit)
        };
        let ((of, unit), (at, at_unit)) = (relation.of, relation.at);
        found.push(Beside {
            id: id(row).to_string(),
            code: relation.code,
            message: format!(
                "{of} is a factor {} {side} that of the {} {built} rows here at a {at} of {}, {}",
                crate::words::number(factor),
                rows.len(),
                said(*x, at_unit),
                said((intercept + slope * point.0).exp(), unit),
            ),
            explanation: relation.explanation,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motors(masses: &[f64], spoiled: Option<usize>) -> Catalog {
        let blank = Catalog::builtin().unwrap().motor("t-motor-u8-lee").unwrap().clone();
        let of = |(k, mass): (usize, &f64)| {
            let mut motor = blank.clone();
            let k_m = 0.5 * mass.powf(0.8) * if spoiled == Some(k) { 3.0 } else { 1.05_f64.powi(k as i32 % 3) };
            motor.id = format!("m{k}");
            (motor.mass, motor.resistance) = (Some(*mass), 1.0);
            (motor.torque_constant, motor.back_emf_constant) = (k_m, k_m);
            motor
        };
        Catalog::of(masses.iter().enumerate().map(of).collect(), Vec::new())
    }

    #[test]
    fn one_row_that_does_not_fit_is_named_and_only_that() {
        let masses: Vec<f64> = (1..=12).map(|k| 0.1 * f64::from(k)).collect();
        assert!(outliers(&motors(&masses, None)).is_empty());
        let found = outliers(&motors(&masses, Some(4)));
        assert_eq!(found.iter().map(|f| f.id.as_str()).collect::<Vec<_>>(), ["m4"]);
        assert!(found[0].message.contains("above"), "{}", found[0].message);
        // Too few to say what is usual.
        assert!(outliers(&motors(&masses[..7], Some(4))).is_empty());
    }
}
