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

/// What is found of a row beside the other rows of its catalogue: worth knowing, not wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Beside {
    /// Id of the row.
    pub id: String,
    /// Code of the check.
    pub code: &'static str,
    /// What does not fit, with numbers.
    pub message: String,
    /// What would explain it, and what to do.
    pub explanation: &'static str,
}

/// What a check says.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    pub severity: Severity,
    pub message: String,
    pub explanation: Option<String>,
}

/// A row that is audited: its id, the codes that it accepts, and its note.
#[derive(Debug)]
pub(super) struct Audited<'r> {
    pub id: &'r str,
    pub accepts: Vec<&'r str>,
    pub note: &'r str,
}

impl Audited<'_> {
    /// What checks found in the row, and what is wrong with what it accepts; of codes that no check has, too.
    pub fn findings(
        &self,
        outcomes: impl Iterator<Item = (&'static str, Outcome)>,
        is_code: impl Fn(&str) -> bool,
    ) -> Vec<Finding> {
        let finding = |code, Outcome { severity, message, explanation }| Finding {
            id: self.id.to_string(),
            code,
            severity,
            message,
            explanation,
            accepted: self.accepts.contains(&code),
        };
        let mut findings: Vec<Finding> = outcomes.map(|(code, outcome)| finding(code, outcome)).collect();
        for code in &self.accepts {
            let (wrong, message) = match (findings.iter().any(|f| f.code == *code), is_code(code)) {
                (false, true) => ("stale-accept", format!("the row accepts `{code}`, but there is nothing to accept")),
                (false, false) => {
                    ("stale-accept", format!("the row accepts `{code}`, which is not the code of a check"))
                }
                (true, _) if self.note.is_empty() => {
                    ("accept-without-note", format!("the row accepts `{code}` but has no note that explains it"))
                }
                (true, _) => continue,
            };
            findings.push(finding(wrong, Outcome { severity: Severity::Error, message, explanation: None }));
        }
        findings
    }
}
