use std::path::PathBuf;

use clap::Args;

use super::{CatalogChoice, Done, Failure, Html};
use crate::design::explain::explain;
use crate::input::nearest;
use crate::report::explain as report;
use crate::report::html;
use crate::report::plot::design as plot;
use crate::requirement;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Exit status 1 if the design is not feasible.\n\nExamples:\n  gearwise explain t-motor-ri50 requirements/quadruped_mini_cheetah.toml --joint knee\n  gearwise explain t-motor-ri50@9 requirements/quadruped_mini_cheetah.toml --joint hip\n  gearwise explain tq-robodrive-ilm-85x26@planetary-apex-af042-20 robot.toml"
)]
pub struct Arguments {
    /// Motor id, with `@RATIO` or `@GEAR` for a certain design; else the best ratio
    design: String,
    /// Requirement file (TOML)
    requirement: PathBuf,
    /// Joint; may be left out where the requirement has only one
    #[arg(long, value_name = "NAME")]
    joint: Option<String>,
    #[command(flatten)]
    catalog: CatalogChoice,
    /// Draw the design: torque over speed, temperature, objective and limits over the ratio: an .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    html: Html,
    /// Print JSON (SI units, the unit in the key)
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let recording = arguments.html.start()?;
    super::check_plot(arguments.plot.as_ref())?;
    let robot = requirement::read(&arguments.requirement)?;
    let catalog = super::motors(&arguments.catalog.catalog)?;
    super::check_gears(&robot, &catalog)?;
    let near = |what: &str, name: &str, names: Vec<&str>| {
        let help = nearest(name, names.iter().copied())
            .map_or_else(|| format!("there are: {}", names.join(", ")), |n| format!("did you mean `{n}`?"));
        Failure::Argument(format!("there is no {what} `{name}`; {help}"))
    };
    let joint_names: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
    let joint = match &arguments.joint {
        Some(name) => robot.joints.iter().find(|j| &j.name == name).ok_or_else(|| near("joint", name, joint_names))?,
        None if robot.joints.len() == 1 => &robot.joints[0],
        None => return Err(Failure::Argument(format!("which joint? `--joint` is one of {}", joint_names.join(", ")))),
    };
    let (id, place) =
        arguments.design.split_once('@').map_or((arguments.design.as_str(), None), |(id, place)| (id, Some(place)));
    let motor = super::find_motor(&catalog, id)?;
    let mut gear = None;
    let mut ratio = None;
    match place.map(|p| (p, p.parse::<f64>())) {
        None => {}
        Some((_, Ok(number))) if (1e-6..=1e6).contains(&number) => ratio = Some(number),
        Some((text, Ok(_))) => {
            return Err(Failure::Argument(format!("`{text}` is not a ratio: expected a number from 1e-6 to 1e6")));
        }
        Some((name, Err(_))) => {
            let ids = catalog.gears.iter().map(|g| g.id.as_str());
            let found = catalog.gears.iter().find(|g| g.id == name);
            let help = nearest(name, ids).map_or_else(String::new, |n| format!("; did you mean `{n}`?"));
            gear = Some(found.ok_or_else(|| {
                Failure::Argument(format!("`{name}` is neither a ratio nor a gear of the catalogue{help}"))
            })?);
        }
    }
    if gear.is_none() && matches!(joint.ratio, requirement::RatioChoice::Catalog { .. }) {
        let message = format!("joint `{}` takes gears of the catalogue: name one, as in {id}@GEAR", joint.name);
        return Err(Failure::Argument(message));
    }
    let story = explain(&robot, joint, motor, gear, ratio)
        .map_err(|why| Failure::Argument(format!("{id} cannot be explained at this joint: {}", why.reason())))?;
    super::draw_plot(arguments.plot.as_ref(), || plot::explained(&robot, &story))?;
    arguments.html.write(&recording, || html::explain::page(&robot, &story))?;
    let text = if arguments.json { crate::report::json_text(&report::json(&story)) } else { report::text(&story) };
    Ok(Done { text, satisfied: story.evaluation.feasible })
}
