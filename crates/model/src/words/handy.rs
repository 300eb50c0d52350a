//! SI numbers in units that people use: 90.1 g*cm^2 rather than 9.01e-6 kg*m^2.

use super::number;

/// For each SI unit what is offered in its place, the largest first.
const HANDY: &[(&str, &[(&str, f64)])] = &[
    ("N*m", &[("N*m", 1.0), ("mN*m", 1e-3), ("uN*m", 1e-6)]),
    ("N*m/A", &[("N*m/A", 1.0), ("mN*m/A", 1e-3)]),
    ("N*m*s/rad", &[("N*m*s/rad", 1.0), ("mN*m*s/rad", 1e-3), ("uN*m*s/rad", 1e-6)]),
    ("V*s/rad", &[("V*s/rad", 1.0), ("mV*s/rad", 1e-3)]),
    ("kg*m^2", &[("kg*m^2", 1.0), ("g*cm^2", 1e-7)]),
    ("ohm", &[("ohm", 1.0), ("mohm", 1e-3)]),
    ("ohm/K", &[("ohm/K", 1.0), ("mohm/K", 1e-3)]),
    ("N*m/(A*K)", &[("N*m/(A*K)", 1.0), ("mN*m/(A*K)", 1e-3), ("uN*m/(A*K)", 1e-6)]),
    ("rad/(N*m)", &[("rad/(N*m)", 1.0), ("mrad/(N*m)", 1e-3), ("urad/(N*m)", 1e-6)]),
    ("H", &[("mH", 1e-3), ("uH", 1e-6)]),
    ("V", &[("V", 1.0), ("mV", 1e-3)]),
    ("A", &[("A", 1.0), ("mA", 1e-3)]),
    ("s", &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6)]),
    ("rad", &[("rad", 1.0), ("mrad", 1e-3)]),
];

/// A unit is taken from this many of it on.
const LEAST: f64 = 0.05;

/// A value in the unit in which it reads best, and that unit.
///
/// ```
/// use gearwise_model::words::handy::handy;
/// assert_eq!(handy(0.0125, "N*m").1, "mN*m");
/// assert_eq!(handy(9.01e-6, "kg*m^2").1, "g*cm^2");
/// assert_eq!(handy(0.0, "rad/s"), (0.0, "rad/s"));
/// ```
pub fn handy(value: f64, si: &'static str) -> (f64, &'static str) {
    let Some((_, offered)) = HANDY.iter().find(|(unit, _)| *unit == si) else { return (value, si) };
    let fits = |(_, scale): &&(&'static str, f64)| value.abs() >= LEAST * scale;
    let chosen = if value == 0.0 { offered.first() } else { offered.iter().find(fits).or(offered.last()) };
    chosen.map_or((value, si), |(unit, scale)| (value / scale, unit))
}

/// A value with its standard error in a handy unit, as in `12.5 ± 0.3 mN*m`.
pub fn with_error(value: f64, error: Option<f64>, si: &'static str) -> String {
    let (scaled, unit) = handy(value, si);
    let factor = if value == 0.0 { 1.0 } else { scaled / value };
    let error = error.map_or_else(String::new, |e| format!(" ± {}", number(e * factor)));
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    format!("{}{error}{unit}", number(scaled))
}
