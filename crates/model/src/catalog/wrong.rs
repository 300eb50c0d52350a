//! What a row cannot say.

/// A mistake of a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// The column that it stands in.
    pub column: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to see there.
    pub label: &'static str,
    /// What to do.
    pub help: String,
}
