//! What a study answers: that of the whole, and of a shard.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::assemble::{Shards, assemble};
use super::journal::{Journal, Lock};
use super::output::{self, Manifest, read_manifest};
use super::plan::Shard;
use super::{StudyError, Summary, page, plot, text};
use crate::ask::Answer;
use crate::input::InputFile;
use crate::report::html::Page;
use crate::report::json::document;
use crate::report::plot::Figure;
use crate::report::{self, table};

/// The results of a whole study, in its folder.
#[derive(Debug)]
pub struct Finished {
    /// The folder.
    pub out: PathBuf,
    /// The summary.
    pub summary: Summary,
    /// What it was made of.
    pub manifest: Manifest,
}

impl Finished {
    /// Of a journal that has every robot: writes the results. The journal goes where no robot is broken.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn of(journal: Journal, out: &Path) -> Result<Finished, StudyError> {
        let shards = Shards::whole(journal);
        let summary = assemble(&shards, out)?;
        let finished = Finished::with(out, summary)?;
        if finished.manifest.broken == 0 {
            Journal::remove(out)?;
        }
        Ok(finished)
    }

    /// Of the folders of all shards of a study; with `replaces` in place of results that are there.
    ///
    /// # Errors
    /// Results that may not be replaced, shards that are not all of one study, a file that cannot be written.
    pub fn merged(out: &Path, shards: &[PathBuf], replaces: bool) -> Result<Finished, StudyError> {
        if replaces {
            output::check_own(out)?;
        } else if let Some(file) = output::there(out) {
            let why = format!("`{}` has results already (`{file}`): `--force` replaces them", out.display());
            return Err(StudyError::Argument(why));
        }
        // Shards first: where they are wrong no folder is made.
        let shards = Shards::open(shards)?;
        let lock = Lock::take(out)?;
        lock.mark(out)?;
        let summary = assemble(&shards, out)?;
        Finished::with(out, summary)
    }

    /// Of results that are there already.
    ///
    /// # Errors
    /// They cannot be read, or are of another version.
    pub fn there(out: &Path) -> Result<Finished, StudyError> {
        let path = out.join("summary.json");
        let text = std::fs::read_to_string(&path).map_err(|e| StudyError::file("read", &path, &e))?;
        let summary = serde_json::from_str(&text).map_err(|_| {
            StudyError::Argument(format!("`{}` is not the summary of a study of this version", path.display()))
        })?;
        Finished::with(out, summary)
    }

    fn with(out: &Path, summary: Summary) -> Result<Finished, StudyError> {
        let manifest = read_manifest(out)?;
        let none = || StudyError::Argument(format!("`{}` has no finished study", out.display()));
        Ok(Finished { out: out.to_path_buf(), manifest: manifest.ok_or_else(none)?, summary })
    }

    /// The page, without how it was called.
    ///
    /// # Errors
    /// The results cannot be read.
    pub fn own_page(&self) -> Result<Page, StudyError> {
        page::page(&self.out, &self.summary, &self.manifest)
    }
}

impl Answer for Finished {
    fn is_satisfied(&self) -> bool {
        self.manifest.broken == 0
    }

    fn json(&self) -> Value {
        report::json::value(document("study", &self.summary))
    }

    fn csv(&self) -> String {
        std::fs::read_to_string(self.out.join("results.csv")).unwrap_or_default()
    }

    fn text(&self) -> String {
        let parquet = if cfg!(feature = "parquet") { ", results.parquet" } else { "" };
        let files = format!(
            "In {}: results.csv{parquet}, summary.json, summary.svg, inputs.csv, errors.csv, manifest.json",
            self.out.display()
        );
        format!("{}\n{}", text::text(&self.summary), table::paragraph(&files, 0, 2))
    }

    fn page(&self) -> Page {
        self.own_page().unwrap_or_else(|_| Page {
            command: "study",
            headline: format!("The results in `{}` cannot be read.", self.out.display()),
            ..Page::default()
        })
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::figure(&self.summary))
    }

    fn remarks(&self) -> Vec<String> {
        let broken = |them: String| {
            let errors = self.out.join("errors.csv");
            let errors = errors.display();
            format!(
                "{them} could not be worked on, see `{errors}`; fix them, and `--resume` does those again and keeps the rest"
            )
        };
        let count = self.manifest.broken;
        (count > 0).then(|| broken(text::robots(count))).into_iter().collect()
    }

    fn files(&self) -> Vec<InputFile> {
        page::inputs(&self.manifest)
    }
}

/// A shard that is done: its results come with those of all others.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// Which shard.
    pub shard: Shard,
    /// Its robots.
    pub robots: u64,
    /// Those of them that could not be worked on.
    pub broken: u64,
}

impl Part {
    /// Of the journal of a shard whose robots are all finished.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn of(journal: &Journal, robots: u64) -> Result<Part, StudyError> {
        let mut broken = 0;
        for block in (0..journal.plan.blocks()).filter(|b| journal.shard.has(*b)) {
            broken += journal.read(block)?.iter().filter(|r| r.broken.is_some()).count() as u64;
        }
        Ok(Part { shard: journal.shard, robots, broken })
    }
}

impl Answer for Part {
    fn is_satisfied(&self) -> bool {
        self.broken == 0
    }

    fn json(&self) -> Value {
        json!({ "shard": self.shard.to_string(), "robots": self.robots, "broken": self.broken })
    }

    fn csv(&self) -> String {
        String::new()
    }

    fn text(&self) -> String {
        let Part { shard, robots, broken } = self;
        format!("shard {shard}: {} finished, {broken} of them could not be worked on\n", text::robots(*robots))
    }

    fn page(&self) -> Page {
        Page { command: "study", headline: self.text(), ..Page::default() }
    }

    fn figure(&self) -> Option<Figure> {
        None
    }

    fn files(&self) -> Vec<InputFile> {
        Vec::new()
    }
}
