//! A check whose input is wrong, in the forms that machines read: a pipeline that waits for findings gets the mistakes
//! as findings, each with its place, and not a missing or yesterday's file.

use std::path::Path;

use serde_json::{Value, json};

use super::{github, relative, sarif};
use crate::json::check::{Mistake, WrongInput};
use crate::json::document;
use gearwise_model::input::{InputError, Problem};
use gearwise_model::words::xml::escape;
use gearwise_rules::{Location, clean};

/// Name of the finding, in place of a rule's code.
const RULE: &str = "wrong-input";
/// What it says.
const SUMMARY: &str = "an input file is wrong: nothing was checked";

/// Every mistake with its file, and its place where it has one.
fn mistakes(errors: &[InputError]) -> impl Iterator<Item = (String, Option<Location>, &Problem)> {
    errors.iter().flat_map(|error| {
        error.problems.iter().map(|problem| {
            let place = problem.span.as_ref().map(|span| Location::of(&error.source, span));
            (clean(error.source.name()), place, problem)
        })
    })
}

/// What is wrong and what to do about it.
fn sentence(problem: &Problem) -> String {
    let label = if problem.label.is_empty() { String::new() } else { format!(": {}", problem.label) };
    let help = problem.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
    format!("{}{label}{help}", problem.message)
}

/// Annotations of GitHub Actions.
pub fn github(errors: &[InputError], root: &Path) -> String {
    let line = |(file, place, problem): (String, Option<Location>, &Problem)| {
        let at = place.map_or_else(String::new, |at| {
            format!(",line={},col={},endLine={},endColumn={}", at.line, at.column, at.end_line, at.end_column)
        });
        let file = github::property(&relative(&file, root));
        format!("::error file={file}{at},title={RULE}::{}\n", github::data(&sentence(problem)))
    };
    mistakes(errors).map(line).collect()
}

/// A SARIF log of a run that did not come to its end.
pub fn sarif(errors: &[InputError], root: &Path) -> Value {
    let result = |(file, place, problem): (String, Option<Location>, &Problem)| {
        let place = match &place {
            Some(place) => sarif::physical(place, root),
            None => json!({ "artifactLocation": sarif::artifact(&file, root) }),
        };
        json!({
            "ruleId": RULE, "ruleIndex": 0, "level": "error", "message": { "text": sentence(problem) },
            "locations": [{ "physicalLocation": place }],
        })
    };
    let rule = json!({
        "id": RULE, "name": RULE, "shortDescription": { "text": SUMMARY }, "fullDescription": { "text": SUMMARY },
        "help": { "text": "Correct the file at the place of the finding." },
        "defaultConfiguration": { "level": "error", "enabled": true },
    });
    sarif::log(json!([rule]), mistakes(errors).map(result).collect(), Some(false))
}

/// A JUnit document with one case that could not be run.
pub fn junit(errors: &[InputError], command: &str) -> String {
    let lines: Vec<String> = mistakes(errors)
        .map(|(file, place, problem)| {
            let at = place.map_or_else(String::new, |at| format!(":{}:{}", at.line, at.column));
            format!("{file}{at}: error: {}", sentence(problem))
        })
        .collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"gearwise {command}\" tests=\"1\" failures=\"0\" errors=\"1\">\n  \
         <testsuite name=\"input\" tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\">\n    \
         <testcase name=\"{RULE}\" classname=\"input\">\n      <error message=\"{}\" type=\"{RULE}\">{}</error>\n    </testcase>\n  \
         </testsuite>\n</testsuites>\n",
        escape(lines.first().map_or(SUMMARY, String::as_str)),
        escape(&lines.join("\n")).replace("&#10;", "\n")
    )
}

/// The same for programs.
pub fn json(errors: &[InputError], command: &'static str) -> Value {
    let input_errors = mistakes(errors).map(|(file, place, problem)| mistake(file, place.as_ref(), problem)).collect();
    document(command, WrongInput { passes: false, input_errors })
}

fn mistake<'a>(file: String, place: Option<&Location>, problem: &'a Problem) -> Mistake<'a> {
    Mistake {
        file,
        line: place.map(|p| p.line),
        column: place.map(|p| p.column),
        message: &problem.message,
        expected: &problem.label,
        help: problem.help.as_deref(),
    }
}
