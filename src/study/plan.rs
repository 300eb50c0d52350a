//! What a study is: its list, grid, catalogue and settings. Two runs with the same plan have the same
//! results; the journal keeps the plan, so that no other is continued or merged with it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::grid::Grid;

/// Most robots of a block. Shards get whole blocks in turn.
pub const BLOCK: u64 = 16;
/// So many blocks are made before they grow: shards of a small study get the same number of robots too.
const BLOCKS: u64 = 64;

/// How a study is run, as far as its results depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// How many designs of each joint are wanted; `None` for all.
    pub top: Option<u32>,
    /// Whether motors whose rows do not say enough to check every limit are left out.
    pub only_checked: bool,
    /// Whether what rows lack was estimated.
    pub estimates: bool,
}

/// A file and what was in it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hashed {
    /// Its name, as given.
    pub file: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// A parameter of the grid as it stands in plan and manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedParameter {
    /// Its key.
    pub key: String,
    /// Its column in the results.
    pub column: String,
    /// Its values as written.
    pub values: Vec<String>,
    /// Its cells in the results.
    pub cells: Vec<String>,
    /// Whether the cells are numbers.
    pub numeric: bool,
}

/// Everything that the results depend on, but for the requirements' and motions' own contents: those are
/// noted with each robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of the program.
    pub gearwise: String,
    /// Settings.
    pub settings: Settings,
    /// The study file, where there is one.
    pub study: Option<Hashed>,
    /// The parameters.
    pub grid: Vec<PlannedParameter>,
    /// The catalogue's files.
    pub catalog: Vec<Hashed>,
    /// Ids of the catalogue's motors, in order.
    pub motors: Vec<String>,
    /// Ids of the catalogue's modules, in order.
    #[serde(default)]
    pub modules: Vec<String>,
    /// Number of requirement files.
    pub requirements: u64,
    /// SHA-256 of the list of their names.
    pub list_sha256: String,
    /// Number of robots: requirements times points of the grid.
    pub robots: u64,
}

impl Plan {
    /// The grid as it stands in a plan.
    pub fn planned(grid: &Grid) -> Vec<PlannedParameter> {
        let planned = |p: &super::grid::Parameter| PlannedParameter {
            key: p.key.clone(),
            column: p.column.clone(),
            values: (0..p.changes.len()).map(|v| p.text(v).to_string()).collect(),
            cells: (0..p.changes.len()).map(|v| p.cell(v)).collect(),
            numeric: p.numbers.is_some(),
        };
        grid.parameters.iter().map(planned).collect()
    }

    /// Ids of what may be chosen, in the order of the letters of a record: motors, then modules.
    pub fn choices(&self) -> impl Iterator<Item = &String> {
        self.motors.iter().chain(&self.modules)
    }

    /// Number of points of the grid.
    pub fn points(&self) -> u64 {
        self.grid.iter().map(|p| p.values.len() as u64).product()
    }

    /// How many points apart two neighbouring values of a parameter are.
    pub fn stride(&self, parameter: usize) -> u64 {
        self.grid[parameter + 1..].iter().map(|p| p.values.len() as u64).product()
    }

    /// Which value a parameter has at a point.
    pub fn value(&self, parameter: usize, point: u64) -> usize {
        (point / self.stride(parameter) % self.grid[parameter].values.len() as u64) as usize
    }

    /// Robots of a block, but for the last.
    fn block(&self) -> u64 {
        (self.robots / BLOCKS).clamp(1, BLOCK)
    }

    /// Number of blocks.
    pub fn blocks(&self) -> u64 {
        self.robots.div_ceil(self.block())
    }

    /// The robots of a block.
    pub fn robots_of(&self, block: u64) -> std::ops::Range<u64> {
        block * self.block()..((block + 1) * self.block()).min(self.robots)
    }

    /// Robots of a shard.
    pub fn robots_in(&self, shard: Shard) -> u64 {
        let robots = |block| self.robots_of(block).end - self.robots_of(block).start;
        (0..self.blocks()).filter(|b| shard.has(*b)).map(robots).sum()
    }

    /// In what another plan differs, in words; `None` where it does not. `self` is the one that is there.
    pub fn difference(&self, other: &Plan) -> Option<String> {
        if self.gearwise != other.gearwise {
            return Some(format!("it was begun by gearwise {}, this is {}", self.gearwise, other.gearwise));
        }
        if self.settings.top != other.settings.top {
            let top = |s: &Settings| s.top.map_or_else(|| "--all".to_string(), |k| format!("--top {k}"));
            return Some(format!("it was begun with {}, now it is {}", top(&self.settings), top(&other.settings)));
        }
        if self.settings.only_checked != other.settings.only_checked {
            return Some("it was begun with another `--only-checked`".into());
        }
        if self.settings.estimates != other.settings.estimates {
            return Some("it was begun with another `--no-estimates`".into());
        }
        if self.catalog != other.catalog || self.motors != other.motors || self.modules != other.modules {
            let changed = other.catalog.iter().find(|f| !self.catalog.contains(f));
            let changed = changed.or_else(|| self.catalog.iter().find(|f| !other.catalog.contains(f)));
            return Some(match changed {
                Some(file) => format!("the catalogue is another: `{}` differs", file.file),
                None => "the catalogue is another".into(),
            });
        }
        if self.grid != other.grid {
            return Some("the grid is another".into());
        }
        if (self.requirements, &self.list_sha256) != (other.requirements, &other.list_sha256) {
            return Some(format!(
                "the list of requirements is another: it had {} files, now it has {}",
                self.requirements, other.requirements
            ));
        }
        if self.study != other.study {
            return Some("the study file has changed".into());
        }
        (self != other).then(|| "its plan is another".into())
    }
}

/// Which part of a study is run: 1 of 1 is all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which, from 1.
    pub number: u64,
    /// Of how many.
    pub of: u64,
}

impl Shard {
    /// The whole study.
    pub const WHOLE: Shard = Shard { number: 1, of: 1 };

    /// From `2/3`.
    ///
    /// # Errors
    /// In words, where it is not that.
    pub fn parse(text: &str) -> Result<Shard, String> {
        let wrong = || format!("`{text}` is not a shard; write i/n with i from 1 to n, as in 2/8");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of) = (number.trim().parse().map_err(|_| wrong())?, of.trim().parse().map_err(|_| wrong())?);
        if number < 1 || number > of || of > 1_000_000 { Err(wrong()) } else { Ok(Shard { number, of }) }
    }

    /// Whether a block belongs to it.
    pub fn has(self, block: u64) -> bool {
        block % self.of == self.number - 1
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// The name of a path for people and files: with `/`, whatever the system.
pub fn path_name(path: &Path) -> String {
    path.display().to_string()
}

/// Where the requirements of a study are, and how they are named.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The folder that the names start from.
    pub base: PathBuf,
    /// Files, folders and patterns, as written.
    pub paths: Vec<String>,
    /// The grid.
    pub grid: Grid,
}
