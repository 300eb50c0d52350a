//! An XML description read as a sheet: every element and attribute knows its place, every mistake is
//! collected, and what no reader asked for is not passed over in silence.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range as Span;
use std::sync::Arc;

use nalgebra::{UnitVector3, Vector3};
use roxmltree::{Attribute, Document, Error, Node, ParsingOptions};

use super::Mechanism;
use crate::input::{InputError, Problem, Range, Source, limits};
use crate::units;
use crate::words::shorten;

/// An element of a document that outlives the reader.
pub(super) type El<'a> = Node<'a, 'a>;

/// The file as it is read.
pub(super) struct Sheet {
    problems: RefCell<Vec<Problem>>,
    skipped: RefCell<BTreeMap<String, usize>>,
}

impl Sheet {
    /// Parses the file and lets `read` take what it knows of a mechanism.
    pub fn read(
        source: &Arc<Source>,
        read: impl for<'a> FnOnce(&Sheet, El<'a>) -> Option<Mechanism>,
    ) -> Result<Mechanism, InputError> {
        let (mut mechanism, skipped) = Sheet::parse(source, read)?;
        for (name, count) in skipped {
            mechanism.notes.push(format!("`{name}` of the description was not read ({count} times)"));
        }
        if mechanism.moving().is_empty() {
            let problem = Problem::whole("no joint of this description moves").help("every joint is fixed");
            return Err(InputError { source: source.clone(), problems: vec![problem] });
        }
        mechanism.note_the_massless();
        Ok(mechanism)
    }

    /// Parses the file and lets `read` take what it knows; with the elements that were left aside, and how often.
    pub fn parse<T>(
        source: &Arc<Source>,
        read: impl for<'a> FnOnce(&Sheet, El<'a>) -> Option<T>,
    ) -> Result<(T, BTreeMap<String, usize>), InputError> {
        let sheet = Sheet { problems: RefCell::default(), skipped: RefCell::default() };
        let text = source.text();
        if let Some(at) = text.find("<xacro:") {
            let problem = Problem::at(at..at + 7, "this is a xacro file, not yet a description", "macros are not run");
            sheet.note(problem.help("run `xacro robot.urdf.xacro > robot.urdf` first"));
        }
        let mut taken = None;
        if sheet.problems.borrow().is_empty() {
            match document(text) {
                Ok(document) => taken = read(&sheet, document.root_element()),
                Err(problem) => sheet.note(problem),
            }
        }
        InputError::unless_empty(source, sheet.problems.into_inner())?;
        let taken = taken.ok_or_else(|| InputError {
            source: source.clone(),
            problems: vec![Problem::whole("the description could not be read")],
        })?;
        Ok((taken, sheet.skipped.into_inner()))
    }

    pub fn note(&self, problem: Problem) {
        let mut problems = self.problems.borrow_mut();
        if problems.len() < limits::PROBLEMS {
            problems.push(problem);
        }
    }

    pub fn has_problems(&self) -> bool {
        !self.problems.borrow().is_empty()
    }

    /// Counts an element that is left aside although nobody knows what it is for.
    pub fn skip(&self, node: El) {
        *self.skipped.borrow_mut().entry(tag(node)).or_default() += 1;
    }

    /// Notes something that would change the motion and is not modelled.
    pub fn refuse(&self, node: El, what: &str, help: &str) {
        self.note(Problem::at(span(node), what, "not supported").help(help));
    }

    /// Notes every attribute that is not among `known`.
    pub fn only(&self, node: El, known: &[&str]) {
        for attribute in node.attributes().filter(|a| a.namespace().is_none()) {
            if !known.contains(&attribute.name()) {
                let name = shorten(attribute.name());
                let message = format!("unknown attribute `{name}` of `{}`", tag(node));
                let place = attribute.range_qname();
                self.note(Problem::at(place, message, "not known here").suggest(&name, known.iter().copied()));
            }
        }
    }

    /// Notes an element that is not known here, with the nearest that is.
    pub fn unknown(&self, node: El, known: &[&str]) {
        let name = tag(node);
        let inside = node.parent_element().map_or(String::new(), |parent| format!(" in `{}`", tag(parent)));
        self.note(
            Problem::at(span(node), format!("unknown element `{name}`{inside}"), "not known here")
                .suggest(&name, known.iter().copied()),
        );
    }

    /// An attribute that must be there.
    pub fn required<'a>(&self, node: El<'a>, name: &str) -> Option<&'a str> {
        let found = node.attribute(name).filter(|t| !t.trim().is_empty());
        if found.is_none() {
            let message = format!("`{}` has no `{name}`", tag(node));
            self.note(Problem::at(span(node), message, format!("expected {name}=\"…\"")));
        }
        found
    }

    /// Numbers of an attribute, separated by blanks.
    pub fn list(&self, attribute: Attribute) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        for word in attribute.value().split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() && units::is_sane(number) => numbers.push(number),
                _ => {
                    let word: String = word.chars().take(40).collect();
                    let message = format!("`{}`: `{word}` is not a number", attribute.name());
                    let mut problem = Problem::at(attribute.range_value(), message, "expected numbers");
                    if word.contains(',') {
                        problem = problem.help("numbers have a decimal point and are separated by blanks, not commas");
                    }
                    self.note(problem);
                    return None;
                }
            }
        }
        Some(numbers)
    }

    /// Exactly `N` numbers of an attribute.
    pub fn numbers<const N: usize>(&self, attribute: Attribute) -> Option<[f64; N]> {
        let numbers = self.list(attribute)?;
        let count = numbers.len();
        let fixed = <[f64; N]>::try_from(numbers).ok();
        if fixed.is_none() {
            let message = format!("`{}` has {count} numbers", attribute.name());
            self.note(Problem::at(attribute.range_value(), message, format!("expected {N}")));
        }
        fixed
    }

    /// One number of an attribute, in a range.
    pub fn number(&self, attribute: Attribute, range: Range) -> Option<f64> {
        let [number] = self.numbers::<1>(attribute)?;
        if !range.contains(number) {
            let message = format!("`{}` is out of range", attribute.name());
            self.note(Problem::at(attribute.range_value(), message, format!("expected {}", range.expected())));
            return None;
        }
        Some(number)
    }

    /// A direction; zero has none.
    pub fn direction(&self, attribute: Attribute) -> Option<UnitVector3<f64>> {
        let direction = UnitVector3::try_new(Vector3::from(self.numbers::<3>(attribute)?), 1e-10);
        if direction.is_none() {
            let message = format!("`{}` is zero: it points nowhere", attribute.name());
            self.note(Problem::at(attribute.range_value(), message, "expected a direction"));
        }
        direction
    }

    /// Notes a name that stood before, or that is too long; names are how a trajectory finds its joints.
    pub fn unique(&self, node: El, kind: &str, name: &str, names: &mut std::collections::HashSet<String>) {
        let place = || node.attribute_node("name").map_or_else(|| span(node), |a| a.range_value());
        if name.chars().nth(limits::NAME_CHARACTERS).is_some() {
            let message = format!("a name of {kind} is too long: `{}`", shorten(name));
            let label = format!("expected at most {} characters", limits::NAME_CHARACTERS);
            self.note(Problem::at(place(), message, label));
        } else if !names.insert(name.to_string()) {
            self.note(Problem::at(place(), format!("two {kind} are called `{name}`"), "second time"));
        }
    }
}

/// Parse a description of bounded width and depth: the parser compares the attributes of an element pairwise.
///
/// # Errors
/// It is not XML, or an element has too many attributes or is nested too deep.
pub fn document(text: &str) -> Result<Document<'_>, Problem> {
    if let Some(problem) = oversized(text) {
        return Err(problem);
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: limits::ELEMENTS, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| not_xml(text, &error))
}

/// An element with too many attributes or too deep inside others, found without a parser. Text that is no XML is left
/// to the parser.
fn oversized(text: &str) -> Option<Problem> {
    let (mut at, mut depth) = (0, 0_usize);
    while let Some(start) = text[at..].find('<').map(|found| at + found) {
        let rest = &text[start..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")];
        if let Some((begin, end)) = skipped.iter().find(|(begin, _)| rest.starts_with(begin)) {
            at = start + begin.len() + rest[begin.len()..].find(end)? + end.len();
            continue;
        }
        let (mut quote, mut attributes, mut end) = (None, 0, None);
        for (k, byte) in rest.bytes().enumerate() {
            match (byte, quote) {
                (b'"' | b'\'', None) => quote = Some(byte),
                (byte, Some(open)) if byte == open => quote = None,
                (b'=', None) => attributes += 1,
                (b'>', None) => {
                    end = Some(k);
                    break;
                }
                _ => {}
            }
        }
        let end = end?;
        depth = match rest.as_bytes() {
            [_, b'/', ..] => depth.saturating_sub(1),
            bytes if bytes[end - 1] == b'/' => depth,
            _ => depth + 1,
        };
        let what = |what, found, most| Some((limits::too_many(what, found, most), "this element"));
        let wrong = match () {
            () if attributes > limits::ATTRIBUTES => what("attributes of an element", attributes, limits::ATTRIBUTES),
            () if depth > limits::DEPTH => what("elements inside one another", depth, limits::DEPTH),
            () => None,
        };
        if let Some((message, label)) = wrong {
            return Some(Problem::at(start..start + 1, message, label));
        }
        at = start + end + 1;
    }
    None
}

/// The name of an element, for messages.
fn tag(node: El) -> String {
    shorten(node.tag_name().name())
}

/// The opening of an element, without its attributes.
pub(super) fn span(node: El) -> Span<usize> {
    let start = node.range().start;
    start..(start + 1 + node.tag_name().name().len()).min(node.range().end)
}

/// Child elements.
pub(super) fn children<'a>(node: El<'a>) -> impl Iterator<Item = El<'a>> {
    node.children().filter(Node::is_element)
}

fn not_xml(text: &str, error: &Error) -> Problem {
    let position = error.pos();
    let (row, column) = (position.row as usize, position.col as usize);
    let start: usize = text.split_inclusive('\n').take(row.saturating_sub(1)).map(str::len).sum();
    let line = text[start.min(text.len())..].lines().next().unwrap_or("");
    let inside: usize = line.chars().take(column.saturating_sub(1)).map(char::len_utf8).sum();
    let at = (start + inside).min(text.len());
    let mut message: String =
        error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).take(160).collect();
    if let Some(end) = message.rfind(" at ").filter(|_| message.ends_with(|c: char| c.is_ascii_digit())) {
        message.truncate(end);
    }
    let end = at + text[at..].chars().next().filter(|c| *c != '\n').map_or(0, char::len_utf8);
    Problem::at(at..end, format!("not an XML file: {message}"), "here")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_and_deep_elements_are_refused_before_they_are_parsed() {
        let wide = |count: usize| {
            let attributes: String = (0..count).map(|k| format!(" a{k}='>='")).collect();
            format!("<?xml version='1.0'?><!-- <a = > --><r><![CDATA[<b =]]><e{attributes}/></r>")
        };
        assert!(document(&wide(limits::ATTRIBUTES)).is_ok());
        let text = wide(limits::ATTRIBUTES + 1);
        let problem = document(&text).unwrap_err();
        assert_eq!(problem.span.unwrap().start, text.find("<e").unwrap());
        let deep = |depth: usize| "<e x='1'>".repeat(depth) + "<f/>" + &"</e>".repeat(depth);
        assert!(document(&deep(limits::DEPTH)).is_ok());
        let problem = document(&deep(limits::DEPTH + 1)).unwrap_err();
        assert_eq!(problem.span.unwrap().start, limits::DEPTH * "<e x='1'>".len());
        // Text that is not XML is left to the parser.
        for text in ["", "<", "<a", "<a x='", "<!-- ", "</a>", "<a></b>", "<>", "<é='\"é>"] {
            assert!(oversized(text).is_none() && document(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_name_that_is_too_long_is_marked() {
        let robot = |name: &str| {
            let link = |name: &str| {
                format!(
                    "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
                )
            };
            format!(
                "<robot name='r'>{}{}<joint name='{name}' type='revolute'><parent link='a'/><child link='b'/>\
                 <axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>",
                link("a"),
                link("b")
            )
        };
        let read = |name: &str| Mechanism::read_source(&Arc::new(Source::new("r.urdf", robot(name))));
        let most = "n".repeat(limits::NAME_CHARACTERS);
        assert!(read(&most).is_ok());
        let long = "n".repeat(1 << 20);
        let error = read(&long).unwrap_err();
        let at = robot(&long).find(&long).unwrap();
        assert_eq!(error.problems[0].span, Some(at..at + long.len()));
        assert!(error.to_string().len() < 10_000);
    }
}
