//! The columns of designs: what files, studies and tables show of one, each column once.
//!
//! The one idea: an [`Entry`] is one motor at one joint, whatever became of it; a column is a key, a type and how its cell
//! is found. CSV files and studies have all columns in this order; tables of a terminal and of pages show the
//! [figures](FIGURES) among them. A figure that is added there is in all of them.

use std::sync::LazyLock;

use super::table;
use super::unjudged::names;
use gearwise_model::actuator::metrics::{METRICS, Metric, Shown};
use gearwise_model::catalog::{Currency, Motor};
use gearwise_model::requirement::Joint;
use gearwise_model::units::in_unit;
use gearwise_model::words::csv::csv_number;
use gearwise_model::words::optional;
use gearwise_select::figures::{FIGURES, Facts, Figure};
use gearwise_select::program::Certificate;

/// What became of a motor at a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// A design that keeps every limit that the requirement states.
    Candidate,
    /// A design that keeps all that can be judged; a limit that the requirement states cannot be.
    Unjudged,
    /// It cannot do it.
    Rejected,
    /// It was not solved: it is not among the designs that were asked for.
    NotSolved,
}

impl State {
    /// Its word in files.
    pub fn word(self) -> &'static str {
        match self {
            State::Candidate => "candidate",
            State::Unjudged => "unjudged",
            State::Rejected => "rejected",
            State::NotSolved => "not_solved",
        }
    }
}

/// A row: a motor at a joint, or a joint that has no design.
#[derive(Debug, Clone)]
pub struct Entry<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// What became of the motor; `None` for a joint without a design.
    pub state: Option<State>,
    /// Place among the candidates, from 1.
    pub rank: Option<usize>,
    /// The motor.
    pub motor: Option<&'a Motor>,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The design, where there is one.
    pub facts: Option<Facts<'a>>,
    /// Why it is no candidate; empty where it is.
    pub because: String,
}

impl<'a> Entry<'a> {
    /// A design.
    pub fn design(joint: &'a Joint, state: State, rank: Option<usize>, facts: Facts<'a>) -> Entry<'a> {
        let (motor, gear) = (Some(facts.motor), facts.gear);
        Entry { joint, state: Some(state), rank, motor, gear, facts: Some(facts), because: String::new() }
    }

    /// A motor without a design, and why.
    pub fn without(
        joint: &'a Joint,
        state: State,
        motor: &'a Motor,
        gear: Option<&'a str>,
        because: String,
    ) -> Entry<'a> {
        Entry { joint, state: Some(state), rank: None, motor: Some(motor), gear, facts: None, because }
    }

    /// A joint without any design, and why.
    pub fn joint(joint: &'a Joint, because: String) -> Entry<'a> {
        Entry { joint, state: None, rank: None, motor: None, gear: None, facts: None, because }
    }

    /// The same, with the reason why it is no candidate.
    #[must_use]
    pub fn because(self, because: String) -> Entry<'a> {
        Entry { because, ..self }
    }
}

/// Type of a column in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Integer,
    /// Numbers, in the unit that the key says (SI).
    Number,
    /// Text.
    Text,
}

type Cell = Box<dyn Fn(&Entry) -> String + Send + Sync>;

/// A column of files. A cell is blank where it is not known or says nothing.
pub struct Column {
    /// Its key, with the SI unit in it.
    pub key: String,
    /// Its type.
    pub kind: Kind,
    /// What it holds.
    pub about: String,
    /// Whether it says something only where a joint asks for a spring.
    pub sprung: bool,
    cell: Cell,
}

impl Column {
    /// The cell of a row.
    pub fn cell(&self, entry: &Entry) -> String {
        (self.cell)(entry)
    }
}

/// Every column of a design in files, in order.
pub fn columns() -> &'static [Column] {
    static ALL: LazyLock<Vec<Column>> = LazyLock::new(|| {
        let figures = FIGURES.iter().map(|figure| number(figure.key, figure.meaning, move |d| figure.finite(d)));
        let metrics = file_metrics().map(|metric| Column {
            key: metric_key(metric),
            kind: Kind::Number,
            about: metric.meaning.into(),
            sprung: false,
            cell: Box::new(move |e| csv_number(e.motor.and_then(|motor| metric.value(motor)))),
        });
        of_choice()
            .into_iter()
            .chain(figures)
            .chain(of_price())
            .chain(of_limits())
            .chain(metrics)
            .chain(of_spring())
            .chain(why())
            .collect()
    });
    &ALL
}

/// The metrics that files have beside the figures.
fn file_metrics() -> impl Iterator<Item = &'static Metric> {
    METRICS.iter().filter(|m| m.shown == Shown::AsOrder)
}

/// Key of a metric in JSON and CSV.
pub fn metric_key(metric: &Metric) -> String {
    format!("{}_{}", metric.name, metric.si_suffix)
}

/// Which joint, which motor, which ratios.
fn of_choice() -> Vec<Column> {
    vec![
        text("joint", "name of the joint", |e| e.joint.name.clone()),
        of_entry("joint_count", Kind::Integer, "how many alike the robot has", |e| e.joint.count.to_string()),
        text("state", "candidate, unjudged, rejected or not_solved; blank for a joint without a design", |e| {
            e.state.map_or_else(String::new, |state| state.word().into())
        }),
        of_entry("rank", Kind::Integer, "place among the candidates", |e| {
            e.rank.map_or_else(String::new, |rank| rank.to_string())
        }),
        text("motor", "id of the motor", |e| e.motor.map_or_else(String::new, |m| m.id.clone())),
        text(
            "gear",
            "id of the gear, where it is one of the catalogue; of a family the point, or both that it lies between",
            |e| {
                let of_family = || super::family::cell(e.joint, e.facts.as_ref()?.evaluation.ratio);
                e.gear.map(str::to_string).or_else(of_family).unwrap_or_default()
            },
        ),
        number("ratio", "ratio N", |d| Some(d.evaluation.ratio)),
        number("ratio_min", "smallest feasible ratio of the window", |d| Some(d.optimum?.window().min)),
        number("ratio_max", "largest feasible ratio of the window", |d| Some(d.optimum?.window().max)),
        text("bound_low", "limit that ends the window below", |e| {
            solved(e).map_or_else(String::new, |optimum| optimum.window().low.limit.into())
        }),
        text("bound_high", "limit that ends the window above", |e| {
            solved(e).map_or_else(String::new, |optimum| optimum.window().high.limit.into())
        }),
        text("objective_is", "what is minimised", |e| e.joint.goal()),
        number("objective", "its value", |d| d.objective),
        number("gap", "relative gap between objective and lower bound; blank where it is not certified", |d| {
            match d.optimum?.certificate {
                Certificate::Certified { gap, .. } => Some(gap),
                Certificate::NotCertified(_) => None,
            }
        }),
    ]
}

fn solved<'e>(entry: &'e Entry) -> Option<&'e gearwise_select::program::Optimum> {
    entry.facts.as_ref()?.optimum
}

/// What a price means, and what is known of one that is not known whole.
fn of_price() -> Vec<Column> {
    let cost = |d: &Facts| d.evaluation.price;
    vec![
        text("price_currency", "currency of the price; blank where the requirement has no `[prices]`", move |e| {
            e.facts.as_ref().and_then(cost).map_or_else(String::new, |cost| cost.currency.to_string())
        }),
        number("price_at_least", "price of the parts of which it is known", move |d| Some(cost(d)?.whole.known)),
    ]
}

/// What is near its limit, and what of the limits is not known.
fn of_limits() -> Vec<Column> {
    let tightest = |e: &Entry| e.facts.as_ref().and_then(|d| d.evaluation.tightest()).map(|m| m.limit.to_string());
    let remarks = |e: &Entry, of: for<'f> fn(&Facts<'f>) -> &'f [gearwise_model::actuator::limits::Remark]| {
        e.facts.as_ref().map_or_else(String::new, |d| names(of(d)))
    };
    vec![
        text("tightest_limit", "limit with the smallest margin", move |e| tightest(e).unwrap_or_default()),
        number("tightest_margin", "that margin, 1 − demand/limit", |d| d.evaluation.tightest().map(|m| m.margin)),
        text("not_checked", "limits that could not be checked", move |e| remarks(e, |d| d.unchecked)),
        text("assumed", "limits that count as kept as far as something holds", move |e| remarks(e, |d| d.assumed)),
        text("estimated", "numbers of the motor that are estimated from rows built alike", |e| {
            e.motor.map_or_else(String::new, |m| {
                m.estimates.iter().map(|estimate| estimate.of.name()).collect::<Vec<_>>().join(" ")
            })
        }),
    ]
}

/// The parallel spring, and what it is worth.
fn of_spring() -> Vec<Column> {
    let columns = vec![
        number("spring_stiffness_nm_per_rad", "stiffness of the parallel spring", |d| Some(d.spring?.stiffness)),
        number("spring_rest_angle_rad", "its rest angle", |d| d.spring?.rest_angle),
        number("loss_without_spring_w", "loss of the same motor without a spring", |d| Some(d.spring?.without?.loss)),
        number("objective_without_spring", "objective of the same motor without a spring", |d| {
            Some(d.spring?.without?.objective)
        }),
        number("loss_saved_by_spring", "share of that loss that the spring saves", |d| {
            d.spring?.saving(d.evaluation.loss)
        }),
    ];
    columns.into_iter().map(|column| Column { sprung: true, ..column }).collect()
}

fn why() -> Vec<Column> {
    vec![text("because", "why it is no candidate, or why the joint has no design", |e| e.because.clone())]
}

fn of_entry(key: &str, kind: Kind, about: &str, cell: impl Fn(&Entry) -> String + Send + Sync + 'static) -> Column {
    Column { key: key.into(), kind, about: about.into(), sprung: false, cell: Box::new(cell) }
}

fn text(key: &str, about: &str, cell: impl Fn(&Entry) -> String + Send + Sync + 'static) -> Column {
    of_entry(key, Kind::Text, about, cell)
}

fn number(key: &str, about: &str, value: impl Fn(&Facts) -> Option<f64> + Send + Sync + 'static) -> Column {
    of_entry(key, Kind::Number, about, move |e| csv_number(e.facts.as_ref().and_then(&value)))
}

/// A CSV file of rows; without the columns that only a spring fills where no joint asks for one.
pub fn csv<'a>(rows: impl Iterator<Item = Entry<'a>>, sprung: bool) -> String {
    csv_with(&[], rows.map(|row| (row, Vec::new())), sprung)
}

/// The same with further columns at the end: their keys, and the cells of each row.
pub fn csv_with<'a>(more: &[&str], rows: impl Iterator<Item = (Entry<'a>, Vec<String>)>, sprung: bool) -> String {
    let shown: Vec<&Column> = columns().iter().filter(|c| sprung || !c.sprung).collect();
    let header: Vec<&str> = shown.iter().map(|c| c.key.as_str()).chain(more.iter().copied()).collect();
    super::csv_text(
        &header,
        rows.map(|(row, cells)| shown.iter().map(|column| column.cell(&row)).chain(cells).collect::<Vec<_>>()),
    )
}

/// The figures that tables of a terminal show.
pub fn in_tables() -> impl Iterator<Item = &'static Figure> {
    FIGURES.iter().filter(|figure| figure.in_tables.is_some())
}

/// Heading of a figure in tables; the figure named `kept` is never dropped.
pub fn heading(figure: &Figure, kept: &str) -> table::Column {
    let column = table::Column::number(figure.heading, figure.unit);
    match figure.in_tables {
        Some(order) if figure.name != kept => column.dropped(order),
        _ => column,
    }
}

/// Heading of a metric in tables of designs, dropped in this place.
pub fn metric_heading(metric: &Metric, kept: &str, order: u8) -> table::Column {
    let column = table::Column::number(metric.symbol, metric.unit);
    if metric.name == kept { column } else { column.dropped(order) }
}

/// Cell of a figure.
pub fn cell(figure: &Figure, facts: &Facts) -> String {
    optional(figure.shown(facts))
}

/// Cell of a motor's metric.
pub fn metric_cell(metric: &Metric, motor: &Motor) -> String {
    optional(metric.value(motor).map(|value| in_unit(value, metric.unit)))
}

/// Headings of the figures and metrics that tables of pages show at once (those of a terminal's tables), or of all others;
/// a page leaves a column without an entry out. Prices are in the currency of the
/// requirement, where it has one.
pub fn of_pages(at_once: bool, currency: Option<Currency>) -> Vec<String> {
    let heading = |figure: &'static Figure| table::Column::number(figure.heading, figure.unit_in(currency));
    let figures = figures_of_pages(at_once).map(heading);
    let metrics = metrics_of_pages(at_once).map(|metric| table::Column::number(metric.symbol, metric.unit));
    figures.chain(metrics).map(|column| column.of_page()).collect()
}

/// Their cells: blank where it is not known.
pub fn cells_of_pages(at_once: bool, facts: &Facts) -> Vec<String> {
    let figures = figures_of_pages(at_once).map(|figure| figure.shown(facts));
    let metrics = metrics_of_pages(at_once).map(|m| m.value(facts.motor).map(|value| in_unit(value, m.unit)));
    figures.chain(metrics).map(|value| value.map_or_else(String::new, super::number)).collect()
}

fn figures_of_pages(at_once: bool) -> impl Iterator<Item = &'static Figure> {
    FIGURES.iter().filter(move |figure| figure.in_tables.is_some() == at_once)
}

/// Metrics are of the motor alone: they come after what the design is about.
fn metrics_of_pages(at_once: bool) -> impl Iterator<Item = &'static Metric> {
    file_metrics().filter(move |_| !at_once)
}
