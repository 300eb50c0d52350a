//! How many turns the windings of a joint's motors may have.

/// Turns of a motor's winding, in place of those of its row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Turns {
    /// As it is wound.
    #[default]
    AsWound,
    /// Any number: what depends on it (voltage, the drive's current) is no limit.
    Any,
}
