//! What an audit finds.

/// How much a finding weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The row contradicts itself.
    Error,
    /// Worth knowing, not wrong.
    Note,
}

/// What a check found in a row.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Id of the motor, gear or module.
    pub id: String,
    /// Code of the check.
    pub code: &'static str,
    /// How much it weighs.
    pub severity: Severity,
    /// What does not fit, with numbers.
    pub message: String,
    /// What would explain it.
    pub explanation: Option<String>,
    /// Whether the row's note already explains it.
    pub accepted: bool,
}

/// What a check says.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    pub severity: Severity,
    pub message: String,
    pub explanation: Option<String>,
}
