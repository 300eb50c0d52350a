//! What a motor that was fitted to logs has beside its row.

/// Numbers of the gear that an actuator was fitted with.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FittedGear {
    /// Efficiency when the motor drives, η.
    pub efficiency: Option<f64>,
    /// Efficiency when the load drives, η_b.
    pub backdrive_efficiency: Option<f64>,
    /// Inertia at the input \[kg·m²\], J_g.
    pub inertia: Option<f64>,
    /// Its ratio on the bench: at another, friction at the output is another at the motor.
    pub ratio: Option<f64>,
}

/// Where a fitted actuator comes from, and how sure its numbers are.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fit {
    /// Id of the catalogue entry that was fitted; empty where the file does not say it.
    pub entry: String,
    /// Version of the program that fitted it.
    pub version: String,
    /// ± of effects' parameters by `effect.parameter`, of an order by `effect.order.parameter`, and of the gear's numbers by
    /// `gear.column`, in their SI unit.
    pub tolerances: Vec<(String, f64)>,
    /// Numbers of the file that were fitted, in the order of `covariance`: `motor.resistance`, `gear.efficiency`,
    /// `effects.cogging.12.cosine`.
    pub names: Vec<String>,
    /// Covariance of the fitted numbers, row by row, SI.
    pub covariance: Vec<Vec<f64>>,
    /// The logs.
    pub provenance: Vec<Provenance>,
}

impl Fit {
    /// The ± of a number by its name in [`Fit::tolerances`].
    pub fn tolerance(&self, name: &str) -> Option<f64> {
        self.tolerances.iter().find(|(other, _)| other == name).map(|(_, tolerance)| *tolerance)
    }
}

/// A log that an actuator was fitted to, or judged on.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Its name.
    pub log: String,
    /// SHA-256 of the file, where it is known.
    pub sha256: Option<String>,
    /// What it was used for, where it is said.
    pub usage: Option<String>,
}
