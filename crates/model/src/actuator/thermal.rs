//! Winding temperature in steady state, with the resistance of copper rising with temperature.

/// Temperature coefficient of copper's resistance \[1/K\], of the resistance at 20 °C (IEC 60028).
pub const AT_20_DEGREES: f64 = 0.003_93;

/// 20 °C \[K\].
pub const TWENTY_DEGREES: f64 = 293.15;

/// Least thermal time constant of a winding in the catalogue \[s\]. Heat that comes at once warms a winding by no more than
/// the steady limit's rise where it is no more than the steady limit's heat over that time.
pub(super) const LEAST_TIME_CONSTANT: f64 = 5.1;

/// Temperature coefficient of copper's resistance \[1/K\], of the resistance at a reference temperature \[K\]: the
/// resistance is a straight line in temperature, so that `α(T_0) = α_20/(1 + α_20 (T_0 − 20 °C))`. Only above 40 K or so;
/// below it is held at what it is there.
///
/// ```
/// assert!((gearwise_model::actuator::thermal::copper(298.15) - 0.003_854).abs() < 1e-6);
/// ```
pub fn copper(reference: f64) -> f64 {
    AT_20_DEGREES / (1.0 + AT_20_DEGREES * (reference - TWENTY_DEGREES)).max(0.01)
}

/// Copper's resistance at a temperature over that at the reference temperature \[both K\], not negative.
pub fn resistance_factor(temperature: f64, reference: f64) -> f64 {
    (1.0 + copper(reference) * (temperature - reference)).max(f64::MIN_POSITIVE)
}

/// Winding temperature \[K\] where the heat `R_th R(T) i²` flows to ambient for ever; `None` where no
/// temperature balances it (thermal runaway).
///
/// `T = T_a + R_th R_0 i² (1 + α (T − T_0))` is linear in T: it is solved, not iterated.
///
/// ```
/// // A hold of 2.4525 A in 1 Ω over 10 K/W: 60.1 K at constant resistance, 78.3 K with hot copper.
/// let hot = gearwise_model::actuator::thermal::winding_temperature(2.4525_f64.powi(2), 1.0, 298.15, 10.0, 298.15);
/// assert!((hot.unwrap() - 298.15 - 78.30).abs() < 0.01);
/// ```
pub fn winding_temperature(
    mean_current_squared: f64,
    resistance: f64,
    reference: f64,
    thermal_resistance: f64,
    ambient: f64,
) -> Option<f64> {
    let rise = thermal_resistance * resistance * mean_current_squared;
    let coefficient = copper(reference);
    let denominator = 1.0 - coefficient * rise;
    (denominator > 0.0).then(|| (ambient + rise * (1.0 - coefficient * reference)) / denominator)
}

/// What the steady temperature of a winding is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Winding {
    /// It cannot be told, or there is no steady state.
    NotAsked,
    /// It settles at this \[K\].
    At(f64),
    /// No temperature balances the heat: thermal runaway.
    Runaway,
}

impl Winding {
    /// Its temperature \[K\], where it settles.
    pub fn kelvin(self) -> Option<f64> {
        match self {
            Winding::At(kelvin) => Some(kelvin),
            Winding::NotAsked | Winding::Runaway => None,
        }
    }

    /// Its temperature \[K\], infinite where it runs away; `None` where nothing is known.
    pub fn kelvin_or_infinite(self) -> Option<f64> {
        match self {
            Winding::NotAsked => None,
            Winding::At(kelvin) => Some(kelvin),
            Winding::Runaway => Some(f64::INFINITY),
        }
    }

    /// Whether it runs away.
    pub fn runs_away(self) -> bool {
        self == Winding::Runaway
    }
}

/// Mean squared current \[A²\] that heats the winding to `limit` \[K\] in steady state; not positive
/// where ambient is already too hot.
pub fn allowed_current_squared(
    limit: f64,
    resistance: f64,
    reference: f64,
    thermal_resistance: f64,
    ambient: f64,
) -> f64 {
    let hot = resistance * resistance_factor(limit, reference);
    (limit - ambient) / (thermal_resistance * hot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_allowed_current_leads_to_the_limit() {
        let (limit, r, reference, r_th, ambient) = (398.15, 0.16, 295.642, 1.1752, 303.15);
        let squared = allowed_current_squared(limit, r, reference, r_th, ambient);
        assert_relative_eq!(
            winding_temperature(squared, r, reference, r_th, ambient).unwrap(),
            limit,
            max_relative = 1e-12
        );
    }

    #[test]
    fn too_much_heat_runs_away() {
        assert_eq!(winding_temperature(30.0, 1.0, 298.15, 10.0, 298.15), None);
    }
}
