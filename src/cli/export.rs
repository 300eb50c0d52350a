use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::{Call, CatalogChoice, Done, Failure, Html, Set};
use crate::ask::export::{Asked, Made, of_design, of_motor};
use crate::ask::{balanced, chosen, settled};
use crate::catalog::Catalog;
use crate::design::options::Options;
use crate::input::Source;
use crate::output;
use crate::report::export::FORMATS;
use crate::report::html;
use crate::requirement::{DesignFile, Robot};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise export requirements/designs/quadruped_mini_cheetah/design.toml --to mjcf\n  gearwise export design.toml --into robot.urdf --out with_limits.urdf\n  gearwise export t-motor-ri50@9 requirements/quadruped_mini_cheetah.toml --joint knee --to mjcf\n  gearwise export t-motor-u8-lee requirements/quadruped_mini_cheetah.toml --joint knee --to json\n  gearwise export t-motor-ri50@9 robot.toml --joint knee --into model.xml --map 'knee=*_knee' --out with_motors.xml\n\nExit status 1 if a design is not feasible; it is exported all the same."
)]
pub struct Arguments {
    /// Design file (TOML; `-` is standard input); or a motor's id, with `@RATIO` or `@GEAR`, else at its best ratio
    design: String,
    /// Requirement file (TOML), where no design file names it; `-` is standard input
    requirement: Option<PathBuf>,
    /// Joint, several times for several: by default all of a design file; may be left out where the requirement has only one
    #[arg(long, value_name = "NAME")]
    joint: Vec<String>,
    /// Format: MuJoCo, URDF, or all facts in SI
    #[arg(long, value_name = "FORMAT", required_unless_present = "into", value_parser = PossibleValuesParser::new(FORMATS.iter().map(|f| PossibleValue::new(f.name).help(f.about))))]
    to: Option<String>,
    /// Write into this model, MJCF, URDF or SDFormat by its root; the result goes to `--out` or stdout. With `--to dcmotor` MJCF
    /// gets that
    #[arg(long, value_name = "MODEL")]
    into: Option<PathBuf>,
    /// Which joints of the model a joint of the design is, `*` for any run of characters; else those of its name. For USD the
    /// path of its prim
    #[arg(long, value_name = "JOINT=PATTERN", num_args = 1..)]
    map: Vec<String>,
    /// Write torques behind the gear's loss: right while the motor drives, too little while the load drives
    #[arg(long)]
    with_efficiency: bool,
    /// Line of torque over speed: through the corner, or the highest `below` the motor's own curve
    #[arg(long, value_name = "LINE", default_value = "corner", value_parser = ["corner", "below"])]
    line: String,
    /// dcmotor: how hot the winding is, as a state
    #[arg(long)]
    thermal: bool,
    /// dcmotor: the current takes its time, L/R
    #[arg(long)]
    electrical: bool,
    /// URDF: without the `mechanicalReduction` of older readers, of which Drake warns
    #[arg(long)]
    drake: bool,
    /// MJCF with --into: elasticity or play of the gear as a second joint
    #[arg(long, requires = "into")]
    gear_joint: bool,
    /// Write ranges of 95 % where rows or fits have a ±
    #[arg(long)]
    ranges: bool,
    /// Write so many draws of all numbers together, by their ± and covariance: JSON and Python
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1000))]
    draws: Option<u16>,
    /// Write to this file instead of stdout
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    catalog: CatalogChoice,
}

impl Arguments {
    fn asked(&self) -> Asked {
        Asked {
            joint: self.joint.clone(),
            to: self.to.clone(),
            into: self.into.clone(),
            map: self.map.clone(),
            with_efficiency: self.with_efficiency,
            line_below: self.line == "below",
            thermal: self.thermal,
            electrical: self.electrical,
            drake: self.drake,
            gear_joint: self.gear_joint,
            ranges: self.ranges,
            draws: self.draws,
        }
    }
}

pub fn run(arguments: &Arguments, call: &Call) -> Result<Done, Failure> {
    arguments.html.check()?;
    let asked = arguments.asked();
    match &arguments.requirement {
        Some(path) => one_motor(arguments, &asked, path, call),
        None => design_file(arguments, &asked, call),
    }
}

/// A motor at a joint of a requirement.
fn one_motor(arguments: &Arguments, asked: &Asked, path: &Path, call: &Call) -> Result<Done, Failure> {
    let settings = arguments.set.settings()?;
    let source = Source::argument(path).map_err(|e| vec![e])?;
    let robot = settings.read(&source, None)?;
    let catalog = arguments.catalog.rows()?.with_named(&robot, std::iter::once(chosen::id(&arguments.design)));
    let robot = settled(robot, &catalog)?;
    let robot = balanced(&robot, &catalog, Options::default())?;
    let made = of_motor(asked, &arguments.design, &robot, &catalog, &source)?;
    finish(arguments, call, (&robot, &catalog), made)
}

/// The joints of a design file.
fn design_file(arguments: &Arguments, asked: &Asked, call: &Call) -> Result<Done, Failure> {
    let path = Path::new(&arguments.design);
    let settings = arguments.set.settings()?;
    let stdin = path.as_os_str() == Source::STDIN;
    if !stdin && !path.exists() && path.extension().is_none_or(|e| e != "toml") {
        return Err(Failure::Argument(format!(
            "`{0}` is no design file; a motor needs its requirement: gearwise export {0} robot.toml --joint NAME",
            arguments.design
        )));
    }
    let mut design = DesignFile::read_set(&Source::argument(path).map_err(|e| vec![e])?, &settings)?;
    let named = arguments.catalog.paths();
    let paths = if named.is_empty() { &design.catalog } else { &named };
    let rows = arguments.catalog.prepared(super::catalog(paths)?);
    let catalog = rows.for_design(&mut design);
    design.robot = crate::design::families::settle(design.robot, &catalog).map_err(Failure::Argument)?;
    let made = of_design(asked, &design, &catalog)?;
    finish(arguments, call, (&design.robot, &catalog), made)
}

/// Warns, and puts the text where it belongs.
fn finish(
    arguments: &Arguments,
    call: &Call,
    (robot, catalog): (&Robot, &Catalog),
    made: Made,
) -> Result<Done, Failure> {
    for warning in &made.warnings {
        tell!("warning: {warning}");
    }
    if let Some(format) = made.format {
        let inputs = || [catalog.files(), robot.files()].concat();
        arguments.html.write(call, inputs, || html::export::page(format, &made.origin, &made.joints))?;
    }
    let satisfied = made.is_satisfied();
    let Made { joints, text, written, .. } = made;
    let Some(out) = &arguments.out else { return Ok(Done { text, satisfied }) };
    output::write_whole(out, text.as_bytes()).map_err(Failure::Argument)?;
    let mut said: Vec<String> = written.iter().map(|(joint, names)| format!("{joint}: {}", names.join(", "))).collect();
    said.extend(joints.iter().map(|j| {
        let number = crate::words::number;
        let s = &j.simulated;
        format!(
            "{}: {} at N = {}, armature {} kg*m^2, effort {} N*m, velocity {} rad/s",
            j.joint,
            j.motor.id,
            number(s.ratio),
            crate::report::optional(s.armature),
            crate::report::optional(s.effort().map(|b| b.value)),
            number(s.speed.value)
        )
    }));
    said.push(format!("written to {}", out.display()));
    let text = said.iter().map(|line| crate::report::table::paragraph(line, 0, 2)).collect();
    Ok(Done { text, satisfied })
}
