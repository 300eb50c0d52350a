//! Where a key stands in a TOML file that was read before: for reports that point into it.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::Source;

/// One step down into a TOML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step<'a> {
    /// The value of a key.
    Key(&'a str),
    /// The table of a list of tables whose `name` is this.
    Named(&'a str),
}

/// The bytes of the deepest value on a path that is there: of the whole path, or of the last step that can
/// be made. `None` where not even the first step can.
///
/// ```
/// use gearwise_model::input::{Source, Step, locate};
/// let source = Source::new("robot.toml", "[[joint]]\nname = \"knee\"\n[joint.limits]\nsafety = 1.2\n");
/// let path = [Step::Key("joint"), Step::Named("knee"), Step::Key("limits"), Step::Key("safety")];
/// let span = locate(&source, &path).unwrap();
/// assert_eq!(&source.text()[span], "1.2");
/// ```
pub fn locate(source: &Source, path: &[Step]) -> Option<Range<usize>> {
    let (table, _) = DeTable::parse_recoverable(source.text());
    let mut found = None;
    let mut here: Option<&DeValue> = None;
    for step in path {
        let next = match (step, here) {
            (Step::Key(key), None) => table.get_ref().get(*key),
            (Step::Key(key), Some(value)) => value.as_table().and_then(|t| t.get(*key)),
            (Step::Named(name), Some(value)) => value.as_array().and_then(|list| {
                let called = |v: &DeValue| v.as_table().and_then(|t| t.get("name")?.get_ref().as_str()) == Some(*name);
                list.iter().find(|item| called(item.get_ref()))
            }),
            (Step::Named(_), None) => None,
        };
        let Some(next) = next else { break };
        found = Some(next.span());
        here = Some(next.get_ref());
    }
    let end = source.text().len();
    found.map(|s| s.start.min(end)..s.end.min(end))
}
