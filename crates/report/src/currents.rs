//! What is said of currents wherever limits on them are shown.

/// What is said once wherever limits on currents are shown.
pub const Q_AXIS: &str = "Limits on currents, and the objective `peak_current`, compare q-axis amperes (power invariant): √(3/2) times the \
                          phase amplitude, and the DC current of a brushed motor.";
