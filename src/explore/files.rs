//! The files of the requirement: they were read before, and no others are.

use std::path::Path;
use std::sync::Arc;

use crate::input::{InputError, Problem, Source};
use crate::motion::{CarriedColumn, Motion};
use crate::requirement::Motions;
use crate::study::worker::Store;

/// What is said where a state names another file.
pub const REFUSED: &str = "a page names no files: change the requirement's file, and start again";

/// The files that a store knows, and no others.
pub struct Known<'s, M> {
    /// What was read before.
    pub store: &'s Store,
    /// How it is read.
    pub reading: M,
}

impl<M: Motions> Motions for Known<'_, M> {
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        if self.store.knows(path) {
            return self.reading.open(path);
        }
        let source = Arc::new(Source::new(path.display().to_string(), ""));
        Err(InputError { source, problems: vec![Problem::whole(REFUSED)] })
    }

    fn motion(
        &mut self,
        source: &Arc<Source>,
        periodic: bool,
        period: Option<f64>,
        joints: &[String],
    ) -> Result<(Arc<Motion>, Vec<CarriedColumn>), InputError> {
        self.reading.motion(source, periodic, period, joints)
    }
}
