//! Motor constants that do not fit their mass: K_M of motors that are built alike grows with a power of the mass.

use super::{Catalog, Construction, Motor};
use crate::words::number;

/// Code of the remark.
pub const CODE: &str = "motor-constant-for-mass";

/// Fewest motors of a construction that a row is compared with.
const FEWEST: usize = 8;

/// A row is remarkable from this factor on,
const FACTOR: f64 = 2.0;

/// and from so many typical deviations on.
const DEVIATIONS: f64 = 3.5;

/// A median deviation is this many times less than a standard one, of normal scatter.
const NORMAL: f64 = 1.4826;

/// ln m and ln K_M of a motor.
fn point(motor: &Motor) -> Option<(f64, f64)> {
    let k_m = (motor.torque_constant * motor.back_emf_constant / motor.resistance).sqrt();
    Some((motor.mass?.ln(), k_m.ln()))
}

/// A motor whose K_M does not fit its mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlier {
    /// Its id.
    pub id: String,
    /// By how much, and beside what.
    pub message: String,
    /// What would explain it.
    pub explanation: &'static str,
}

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
    let pairs = points.iter().enumerate().flat_map(|(k, a)| points[..k].iter().map(move |b| (a, b)));
    let slopes = pairs.filter(|(a, b)| (a.0 - b.0).abs() > 0.05).map(|(a, b)| (a.1 - b.1) / (a.0 - b.0)).collect();
    let slope = median(slopes)?;
    Some((median(points.iter().map(|p| p.1 - slope * p.0).collect())?, slope))
}

/// The remark on each motor whose K_M is far from what rows of the catalogue that are built alike have at its mass; of a
/// construction with fewer than eight such rows there is none.
pub fn outliers(catalog: &Catalog) -> Vec<Outlier> {
    let mut found = Vec::new();
    for (word, construction) in Construction::NAMES {
        let alike = catalog.motors.iter().filter(|m| m.about.construction == Some(*construction));
        let rows: Vec<(&Motor, (f64, f64))> = alike.filter_map(|m| Some((m, point(m)?))).collect();
        if rows.len() < FEWEST {
            continue;
        }
        let points: Vec<(f64, f64)> = rows.iter().map(|(_, point)| *point).collect();
        let Some((intercept, slope)) = line(&points) else { continue };
        let off = |point: &(f64, f64)| point.1 - intercept - slope * point.0;
        let Some(typical) = median(points.iter().map(|p| off(p).abs()).collect()) else { continue };
        let least = FACTOR.ln().max(DEVIATIONS * NORMAL * typical);
        for (motor, point) in rows.iter().filter(|(_, point)| off(point).abs() > least) {
            let (factor, side) = (off(point).abs().exp(), if off(point) > 0.0 { "above" } else { "below" });
            let explanation = match off(point) > 0.0 {
                true => {
                    "an unusual motor, a mass of the active parts alone, or K_T, R or mass in another unit or convention"
                }
                false => {
                    "an unusual motor, the mass of a whole module, or K_T, R or mass in another unit or convention"
                }
            };
            found.push(Outlier {
                id: motor.id.clone(),
                message: format!(
                    "K_M is a factor {} {side} that of the {} {word} rows here at {} kg, {} N*m/W^0.5",
                    number(factor),
                    rows.len(),
                    number(point.0.exp()),
                    number((intercept + slope * point.0).exp()),
                ),
                explanation,
            });
        }
    }
    found
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
