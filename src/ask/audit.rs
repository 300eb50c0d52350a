//! Whether the rows of a catalogue agree with themselves.

use serde_json::Value;

use super::Answer;
use crate::catalog::Catalog;
use crate::catalog::audit::{Finding, audit as findings};
use crate::input::InputFile;
use crate::report::audit as report;
use crate::report::html::{self, Page};
use crate::report::json;
use crate::report::plot::Figure;

/// A catalogue with what was found in it.
#[derive(Debug)]
pub struct Audited {
    catalog: Catalog,
    findings: Vec<Finding>,
}

/// Audits a catalogue as it was read.
pub fn audit(catalog: Catalog) -> Audited {
    let findings = findings(&catalog);
    Audited { catalog, findings }
}

impl Answer for Audited {
    fn is_satisfied(&self) -> bool {
        report::broken(&self.findings) == 0
    }

    fn json(&self) -> Value {
        json::motors::audited(&self.catalog, &self.findings)
    }

    fn csv(&self) -> String {
        report::csv(&self.findings)
    }

    fn text(&self) -> String {
        report::text(&self.catalog, &self.findings)
    }

    fn page(&self) -> Page {
        html::audit::page(&self.catalog, &self.findings)
    }

    fn figure(&self) -> Option<Figure> {
        None
    }

    fn files(&self) -> Vec<InputFile> {
        self.catalog.files()
    }
}
