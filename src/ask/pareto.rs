//! Fronts of several quantities.

use self_cell::self_cell;
use serde_json::Value;

use super::optimize::Ready;
use super::{Answer, Failure, Ground, Watch};
use crate::design::options::Options;
use crate::design::pareto::{Front, fronts};
use crate::input::InputFile;
use crate::report::html::Page;
use crate::report::pareto as report;
use crate::report::plot::{Figure, pareto as plot};
use crate::report::{html, json};
use crate::requirement::Quantity;
use crate::words::nearest;

type Fronts<'a> = Vec<Front<'a>>;

self_cell!(
    struct Cell {
        owner: Ground,
        #[covariant]
        dependent: Fronts,
    }
    impl {Debug}
);

/// The front of each joint.
#[derive(Debug)]
pub struct Pareto {
    cell: Cell,
}

/// Two or more different quantities by their names.
///
/// # Errors
/// In words: a name that is none, one that is there twice, fewer than two.
pub fn quantities<'n>(names: impl IntoIterator<Item = &'n str>) -> Result<Vec<Quantity>, String> {
    let all = || Quantity::NAMES.iter().map(|(name, _)| *name);
    let mut quantities: Vec<Quantity> = Vec::new();
    for (place, name) in names.into_iter().map(str::trim).enumerate() {
        let Some((_, quantity)) = Quantity::NAMES.iter().find(|(n, _)| *n == name) else {
            let help = nearest(name, all()).map_or_else(
                || format!("there are: {}", all().collect::<Vec<_>>().join(", ")),
                |n| format!("did you mean `{n}`?"),
            );
            return Err(match name {
                "" => format!("name {} is empty; {help}", place + 1),
                _ => format!("name {}, `{name}`, is not a quantity; {help}", place + 1),
            });
        };
        if let Some(before) = quantities.iter().position(|q| q == quantity) {
            return Err(format!("names {} and {} are both `{name}`: give each quantity once", before + 1, place + 1));
        }
        quantities.push(*quantity);
    }
    match quantities.len() {
        0 | 1 => Err("a front takes two or more quantities, e.g. loss,mass,reflected_inertia".into()),
        _ => Ok(quantities),
    }
}

/// The fronts of these quantities, with so many ratios along each motor's.
///
/// # Errors
/// It was stopped.
pub fn pareto(
    ready: Ready,
    quantities: &[Quantity],
    points: usize,
    only_checked: bool,
    watch: Watch,
) -> Result<Pareto, Failure> {
    let cell = Cell::try_new(ready.ground(watch), |ground| {
        let options = Options { tick: &|| (), ..ground.watch.options(only_checked) };
        fronts(&ground.robot, &ground.catalog, quantities, points, options)
    })?;
    Ok(Pareto { cell })
}

impl Pareto {
    /// The front of each joint.
    pub fn fronts(&self) -> &[Front<'_>] {
        self.cell.borrow_dependent()
    }

    /// The text with at most so many motors.
    pub fn text_of(&self, most: usize) -> String {
        self.cell.borrow_owner().told_set() + &report::text(self.fronts(), most)
    }
}

impl Answer for Pareto {
    fn is_satisfied(&self) -> bool {
        self.fronts().iter().all(|f| !f.points.is_empty())
    }

    fn json(&self) -> Value {
        json::pareto::json(&self.cell.borrow_owner().robot, self.fronts())
    }

    fn csv(&self) -> String {
        report::csv(self.fronts())
    }

    fn text(&self) -> String {
        self.text_of(report::MOTORS)
    }

    fn page(&self) -> Page {
        html::pareto::page(&self.cell.borrow_owner().robot, self.fronts())
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::figure(self.fronts()))
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }

    fn remarks(&self) -> Vec<String> {
        super::alone(&self.cell.borrow_owner().robot)
    }
}
