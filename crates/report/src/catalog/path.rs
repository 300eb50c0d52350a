//! Where catalogues are looked for.

use std::path::PathBuf;

use crate::counted;
use crate::table::paragraph;

/// What the word `user` leads to.
#[derive(Debug)]
pub enum User {
    /// Nothing is there.
    Absent,
    /// A catalogue with so many motors, gears and modules.
    Read([usize; 3]),
    /// Something that is no catalogue: how many mistakes it has.
    Wrong(usize),
}

/// Where catalogues are.
#[derive(Debug)]
pub struct Places {
    /// Where `user` is looked for.
    pub user: PathBuf,
    /// Whether `$GEARWISE_CATALOG` says so.
    pub by_variable: bool,
    /// What is there.
    pub found: User,
    /// Motors, gears and modules of the built-in catalogue.
    pub builtin: [usize; 3],
    /// Files that it was made of.
    pub files: usize,
    /// The SHA-256 of all of them.
    pub sha256: String,
}

/// For people.
pub fn text(places: &Places) -> String {
    let rows = |[motors, gears, modules]: [usize; 3]| {
        format!("{}, {} and {}", counted(motors, "motor"), counted(gears, "gear"), counted(modules, "module"))
    };
    let by = match places.by_variable {
        true => "by $GEARWISE_CATALOG",
        false => "the system's configuration directory; $GEARWISE_CATALOG names another place",
    };
    let found = match places.found {
        User::Absent => "nothing is there yet; `gearwise catalog add ROW.csv` makes it".to_string(),
        User::Read(read) => rows(read),
        User::Wrong(mistakes) => {
            format!("cannot be read: {}; `gearwise audit user` shows them", counted(mistakes, "mistake"))
        }
    };
    let mut out = paragraph(&format!("user: {}", places.user.display()), 0, 2);
    out += &paragraph(by, 2, 2);
    out += &paragraph(&found, 2, 2);
    out += &paragraph(&format!("builtin: in the program itself, {}", counted(places.files, "file")), 0, 2);
    out += &paragraph(&rows(places.builtin), 2, 2);
    // As much as tells two versions apart, in a line of any width; JSON has all of it.
    let start = places.sha256.get(..16).unwrap_or(&places.sha256);
    out += &paragraph(&format!("sha256 {start}…"), 2, 2);
    out.push('\n');
    let line = "Both are words of `--catalog` and `--also`. `user` is never read unless it is named.";
    out + &paragraph(line, 0, 2)
}
