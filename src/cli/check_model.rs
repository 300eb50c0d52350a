use std::path::{Path, PathBuf};

use clap::Args;

use super::check::Forms;
use super::{CatalogPaths, Done, Failure};
use crate::catalog::Catalog;
use crate::hardware::{self, Hardware, HardwareFile};
use crate::input::{InputError, Source};
use crate::mechanism::stated::Model;
use crate::output;
use crate::report::check::{Checked, model as text};
use crate::report::json::check_model as json;
use crate::report::table::paragraph;
use crate::rules::file::{RulesFile, read};
use crate::rules::models::ModelFacts;
use crate::rules::{ModelReport, check_models};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise check-model robot.urdf --against hardware.toml\n  gearwise check-model robot.urdf robot.xml limits.json --against hardware.toml --strict\n  gearwise check-model robot.xml --against hardware.toml --sarif check.sarif --junit check.xml --github\n  gearwise check-model robot.xml --against hardware.toml --fix --out robot_fixed.xml\n\nA hardware file names what drives which joints:\n  [[joint]]\n  names = [\"*_calf_joint\"]\n  module = \"robstride-rs04\"            # or motor = \"…\" with gear = \"…\" or ratio = 9\n  transmission = { ratio = 1.917 }    # where something is between module and joint\n\nExit status 0 if no rule with severity `error` is broken, 1 if one is, or if nothing could be judged; 2 if the input is wrong. With --strict, warnings and limits of torque or speed that could not be judged give 1, too."
)]
pub struct Arguments {
    /// Robot models: URDF, MJCF, or a JSON table of limits in SI; `-` is standard input. Several are compared with each other
    #[arg(required = true, value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// Hardware file (TOML): which module, or motor and gear, drives which joints
    #[arg(long, value_name = "FILE")]
    against: PathBuf,
    /// Rules file: severities of GW401 to GW416, and exceptions
    #[arg(long, value_name = "FILE")]
    rules: Option<PathBuf>,
    /// Warnings fail the check too, and limits of torque or speed that could not be judged
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    catalog: CatalogPaths,
    #[command(flatten)]
    forms: Forms,
    /// Write a copy of the model with what findings say to write: effort, velocity, armature. The model itself stays as it is, unless
    /// `--in-place` is given too
    #[arg(long)]
    fix: bool,
    /// Name of the copy; else `robot.fixed.urdf` next to `robot.urdf`
    #[arg(long, value_name = "FILE", requires = "fix")]
    out: Option<PathBuf>,
    /// Write what `--fix` writes into the model itself, in place of a copy
    #[arg(long, requires = "fix", conflicts_with = "out")]
    in_place: bool,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let main = arguments.models.first().map_or(Path::new(""), PathBuf::as_path);
    let inputs = arguments.forms.reported("check-model", main, Inputs::read(arguments))?;
    let facts = ModelFacts::new(&inputs.models, &inputs.file, &inputs.hardware);
    let report = check_models(facts, &inputs.rules);
    let checked: Checked = (&report).into();
    arguments.forms.write(&checked, arguments.strict)?;
    let strict = arguments.strict;
    let mut text = arguments.forms.print(&checked, || json::json(&report, strict), || text::text(&report, strict));
    if arguments.fix {
        let said = fix(arguments, &report)?;
        // What machines read stays what it is.
        match arguments.forms.is_text() {
            true => text.push_str(&said.iter().map(|line| paragraph(line, 0, 2)).collect::<String>()),
            false => said.iter().for_each(|line| tell!("{line}")),
        }
    }
    Ok(Done { text, satisfied: report.passes(strict) })
}

/// What is checked, and against what.
struct Inputs {
    models: Vec<Model>,
    file: HardwareFile,
    hardware: Vec<Hardware>,
    rules: RulesFile,
}

impl Inputs {
    fn read(arguments: &Arguments) -> Result<Inputs, Failure> {
        if arguments.out.is_some() && arguments.models.len() > 1 {
            return Err(Failure::Argument("`--out` names one copy: give one model".into()));
        }
        if arguments.fix && arguments.out.is_none() && arguments.models.iter().any(|m| m.as_os_str() == Source::STDIN) {
            return Err(Failure::Argument("a model from standard input has no name: say `--out FILE`".into()));
        }
        let mut errors: Vec<InputError> = Vec::new();
        let mut models = Vec::new();
        for path in &arguments.models {
            match Model::read(path) {
                Ok(model) => models.push(model),
                Err(error) => errors.push(error),
            }
        }
        let file = hardware::read(&arguments.against).map_err(|all| errors.extend(all)).ok();
        let rules = match &arguments.rules {
            Some(path) => read(path).map_err(|error| errors.push(error)).ok(),
            None => Some(RulesFile::default()),
        };
        let catalog = match super::catalog(&arguments.catalog.catalog) {
            Ok(catalog) => Some(catalog),
            Err(Failure::Input(more)) => {
                errors.extend(more);
                None
            }
            Err(other) => return Err(other),
        };
        let (Some(file), Some(rules), Some(catalog)) = (file, rules, catalog) else { return Err(errors.into()) };
        let hardware = resolved(&file, &catalog, &mut errors);
        errors.extend(driven_twice(&file, &models));
        if !errors.is_empty() {
            return Err(errors.into());
        }
        Ok(Inputs { models, file, hardware, rules })
    }
}

/// The hardware of every entry.
fn resolved(file: &HardwareFile, catalog: &Catalog, errors: &mut Vec<InputError>) -> Vec<Hardware> {
    let mut problems = Vec::new();
    let mut hardware = Vec::new();
    for mount in &file.mounts {
        match hardware::of(mount, catalog) {
            Ok(of) => hardware.push(of),
            Err(problem) => problems.push(problem),
        }
    }
    errors.extend(InputError::unless_empty(&file.source, problems).err());
    hardware
}

/// Joints that two entries name.
fn driven_twice(file: &HardwareFile, models: &[Model]) -> Option<InputError> {
    let joints = models.iter().flat_map(|model| &model.joints);
    InputError::unless_empty(&file.source, file.driven_twice(joints.map(|joint| joint.name.as_str()))).err()
}

/// Writes the copies; what is said of it.
fn fix(arguments: &Arguments, report: &ModelReport) -> Result<Vec<String>, Failure> {
    let mut said = Vec::new();
    for (k, model) in report.facts.models.iter().enumerate() {
        let written = model.written(&report.changes(k));
        let path = match arguments.in_place {
            true => arguments.models[k].clone(),
            false => arguments.out.clone().unwrap_or_else(|| copy_of(&arguments.models[k])),
        };
        said.extend(written.left);
        if written.changed.is_empty() {
            said.push(format!("{}: nothing to fix, nothing written", model.source.name()));
            continue;
        }
        let write = if arguments.in_place { output::write_over } else { output::write_whole };
        write(&path, written.text.as_bytes()).map_err(Failure::Argument)?;
        said.extend(written.changed);
        said.push(format!("written to {}", path.display()));
    }
    Ok(said)
}

/// `robot.fixed.urdf` for `robot.urdf`.
fn copy_of(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = match path.extension() {
        Some(extension) => format!("{stem}.fixed.{}", extension.to_string_lossy()),
        None => format!("{stem}.fixed"),
    };
    path.with_file_name(name)
}
