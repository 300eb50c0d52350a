//! Pictures: a figure is panels of series over two axes, drawn as SVG; a PNG is that SVG, rendered.
//!
//! The one idea: what is drawn is data ([`Figure`]), and one place draws it (`draw`), so that every picture
//! has the same look, and a page can show the same data in another way: units on the axes, tones that
//! the colour-blind can tell apart and that come each with a dash or a shape of its own so that grey
//! print can be read, labels that do not cover each other, a bounded number of points, chosen without chance.
//! A picture of its own is one file beside this one, which makes a [`Figure`].

pub mod asked;
mod axis;
pub mod characterize;
pub mod choice;
pub mod design;
mod draw;
mod labels;
mod legend;
pub mod over_ratio;
mod paint;
pub mod pareto;
mod pen;
#[cfg(feature = "png")]
mod png;
pub mod rank;
pub mod residual;
pub mod step;
pub mod sweep;
pub mod temperature;
pub mod torque_speed;
pub mod trade;
mod widths;

use std::path::Path;

pub use axis::{Axis, Scale, Ticks, ticks};
pub use draw::{Layout, svg, svg_and_layout};
pub(crate) use draw::{described, ranges};
pub use labels::{Placed, Rect, Wanted, overlap, place};
pub use pen::{escaped, text_width};
#[cfg(feature = "png")]
pub use png::png;

use gearwise_model::output;
use gearwise_model::requirement::Objective;

/// The colours, of the palette of Okabe and Ito: the colour-blind can tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Tone {
    /// The first choice, and what is.
    Blue,
    /// What was; light in grey.
    Orange,
    /// Bluish green.
    Green,
    /// Vermilion: what must not be.
    Vermilion,
    /// Reddish purple.
    Purple,
    /// Sky blue; light in grey.
    Sky,
    /// Yellow; very light in grey: for areas.
    Yellow,
    /// Black.
    Black,
    /// Grey: the background of the story.
    Grey,
}

impl Tone {
    /// Those that tell series apart, in the order in which they are taken.
    pub const SERIES: [Tone; 7] =
        [Tone::Blue, Tone::Orange, Tone::Green, Tone::Vermilion, Tone::Purple, Tone::Sky, Tone::Black];

    /// The k-th series' tone; they repeat.
    pub fn nth(k: usize) -> Tone {
        Tone::SERIES[k % Tone::SERIES.len()]
    }

    /// Of dots and areas, `#rrggbb`.
    pub fn colour(self) -> &'static str {
        match self {
            Tone::Blue => "#0072b2",
            Tone::Orange => "#e69f00",
            Tone::Green => "#009e73",
            Tone::Vermilion => "#d55e00",
            Tone::Purple => "#cc79a7",
            Tone::Sky => "#56b4e9",
            Tone::Yellow => "#f0e442",
            Tone::Black => "#000000",
            Tone::Grey => "#888888",
        }
    }

    /// Of outlines, and of lines over dots of the same tone: darker.
    pub fn dark(self) -> &'static str {
        match self {
            Tone::Blue => "#002850",
            Tone::Orange => "#8c5000",
            Tone::Green => "#00503a",
            Tone::Vermilion => "#7a3600",
            Tone::Purple => "#7a3a60",
            Tone::Sky => "#1f5f8b",
            Tone::Yellow => "#807600",
            Tone::Black => "#000000",
            Tone::Grey => "#555555",
        }
    }
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Dash {
    /// Not at all.
    #[default]
    Solid,
    /// Into dashes.
    Dashed,
    /// Into dots.
    Dotted,
    /// Into dashes and dots.
    DashDot,
    /// Into long dashes.
    Long,
    /// Into long dashes with two dots.
    DashDotDot,
}

impl Dash {
    /// Those that tell series apart, in the order in which they are taken.
    pub const SERIES: [Dash; 6] =
        [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted, Dash::Long, Dash::DashDotDot];

    /// The k-th series' dash; they repeat with another period than [`Tone::nth`].
    pub fn nth(k: usize) -> Dash {
        Dash::SERIES[k % Dash::SERIES.len()]
    }

    /// Lengths of strokes and gaps \[px\]; empty for a solid line.
    pub fn pattern(self) -> &'static str {
        match self {
            Dash::Solid => "",
            Dash::Dashed => "7 4",
            Dash::Dotted => "2 3",
            Dash::DashDot => "8 3 2 3",
            Dash::Long => "14 5",
            Dash::DashDotDot => "12 3 2 3 2 3",
        }
    }

    fn attribute(self) -> String {
        match self.pattern() {
            "" => String::new(),
            pattern => format!(" stroke-dasharray=\"{pattern}\""),
        }
    }
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shape {
    /// ●
    #[default]
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    Down,
    /// ×
    Cross,
    /// +
    Plus,
    /// ◀
    Left,
}

impl Shape {
    /// Those that tell series apart, in the order in which they are taken: those that can be hollow first.
    pub const SERIES: [Shape; 8] = [
        Shape::Circle,
        Shape::Square,
        Shape::Triangle,
        Shape::Diamond,
        Shape::Down,
        Shape::Left,
        Shape::Cross,
        Shape::Plus,
    ];

    /// The k-th series' shape; they repeat with another period than [`Tone::nth`].
    pub fn nth(k: usize) -> Shape {
        Shape::SERIES[k % Shape::SERIES.len()]
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mark {
    /// A small dot for each point, half seen through: for clouds.
    Dots,
    /// A shape for each point.
    Points(Shape),
    /// A line through the points, with a break at a point that is not finite.
    Line(Dash),
    /// A thin line: the background of the story.
    Thin(Dash),
    /// A bar from zero for each point.
    Bars,
    /// The area from the points up to [`Series::upper`].
    Band,
}

/// Points that are drawn alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend says; empty for a series that is not in it. Series of one name share a line.
    pub name: String,
    /// Colour.
    pub tone: Tone,
    /// How.
    pub mark: Mark,
    /// Abscissa and ordinate; points that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// Upper ordinate of each point of a band; else empty.
    pub upper: Vec<f64>,
    /// The id of the thing (a motor, a log) that each point belongs to, or one for all; may be empty. What has
    /// the same id is the same thing in every panel and table.
    pub ids: Vec<String>,
    /// What is said of each point where a pointer rests on it; may be empty.
    pub notes: Vec<String>,
    /// Text that stands along the line, at its end; empty for none.
    pub along: String,
    /// Whether its marks are hollow: what they stand for rests on an estimate.
    pub hollow: bool,
    /// How large the mark of each point is, over the usual one; empty for all alike.
    pub sizes: Vec<f64>,
}

impl Series {
    /// A series without names.
    pub fn new(tone: Tone, mark: Mark, points: Vec<(f64, f64)>) -> Series {
        Series {
            name: String::new(),
            tone,
            mark,
            points,
            upper: Vec::new(),
            ids: Vec::new(),
            notes: Vec::new(),
            along: String::new(),
            hollow: false,
            sizes: Vec::new(),
        }
    }

    /// A band between two ordinates for each abscissa: (x, lower, upper).
    pub fn band(tone: Tone, edges: impl IntoIterator<Item = (f64, f64, f64)>) -> Series {
        let (points, upper) = edges.into_iter().map(|(x, low, high)| ((x, low), high)).unzip();
        Series { upper, ..Series::new(tone, Mark::Band, points) }
    }

    /// With an entry in the legend.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Series {
        self.name = name.into();
        self
    }

    /// With the ids of the things that the points belong to.
    #[must_use]
    pub fn of(mut self, ids: Vec<String>) -> Series {
        self.ids = ids;
        self
    }

    /// With what is said of each point.
    #[must_use]
    pub fn noted(mut self, notes: Vec<String>) -> Series {
        self.notes = notes;
        self
    }

    /// With a text along the line.
    #[must_use]
    pub fn along(mut self, text: impl Into<String>) -> Series {
        self.along = text.into();
        self
    }

    /// With hollow marks, where what they stand for rests on an estimate.
    #[must_use]
    pub fn hollow(mut self, estimated: bool) -> Series {
        self.hollow = estimated;
        self
    }

    /// With marks of these sizes, each over the usual one.
    #[must_use]
    pub fn sized(mut self, sizes: Vec<f64>) -> Series {
        self.sizes = sizes;
        self
    }

    /// How large the k-th point's mark is, over the usual one.
    pub fn size(&self, k: usize) -> f64 {
        self.sizes.get(k).copied().unwrap_or(1.0)
    }

    /// The id of the k-th point.
    pub fn id(&self, k: usize) -> Option<&str> {
        if self.ids.len() == 1 { self.ids.first() } else { self.ids.get(k) }.map(String::as_str)
    }

    /// What is said of the k-th point: its note, else its id.
    pub fn note(&self, k: usize) -> &str {
        self.notes.get(k).map(String::as_str).or(self.id(k)).unwrap_or("")
    }
}

/// What the legend says of hollow marks.
const HOLLOW: &str = "hollow: rests on an estimate";

impl Panel {
    /// Says in the legend what hollow marks are, where there are any.
    fn explain_hollow(&mut self) {
        if self.series.iter().any(|s| s.hollow) {
            let sample = Series::new(Tone::Grey, Mark::Points(Shape::Circle), Vec::new());
            self.series.push(sample.named(HOLLOW).hollow(true));
        }
    }
}

/// A point with its name beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The point.
    pub at: (f64, f64),
    /// Its name.
    pub text: String,
    /// Whether the point gets a ring and the text is bold: it was chosen.
    pub chosen: bool,
}

/// Which axis something is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// At an abscissa: upright.
    X,
    /// At an ordinate: lying.
    Y,
}

/// A straight line across the panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Upright or lying.
    pub along: Along,
    /// Where.
    pub at: f64,
    /// Colour.
    pub tone: Tone,
    /// How it is broken.
    pub dash: Dash,
    /// What it is; may be empty.
    pub text: String,
}

/// A stripe across the panel: a window, or what is forbidden.
#[derive(Debug, Clone, PartialEq)]
pub struct Stripe {
    /// From and to on this axis.
    pub along: Along,
    /// From.
    pub from: f64,
    /// To.
    pub to: f64,
    /// Colour, drawn very light.
    pub tone: Tone,
    /// What the legend says; may be empty.
    pub name: String,
}

/// Two axes and what is drawn over them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// Title; may be empty.
    pub title: String,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// Stripes, the lowest of all.
    pub stripes: Vec<Stripe>,
    /// Straight lines.
    pub rules: Vec<Rule>,
    /// What is drawn, first the lowest.
    pub series: Vec<Series>,
    /// Named points, the most important first.
    pub labels: Vec<Label>,
    /// What is said where there is nothing to draw.
    pub empty: String,
}

/// Panels under a title.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Group {
    /// Title.
    pub title: String,
    /// What has to be known to read it; wrapped.
    pub caption: String,
    /// Whether each panel has a legend of its own, instead of one for all.
    pub own_legends: bool,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// A figure: groups of panels, one below the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it is, for those who do not see it; the groups' titles where empty.
    pub title: String,
    /// What is to be seen, for those who do not see it.
    pub description: String,
    /// The groups.
    pub groups: Vec<Group>,
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a panel, axes included \[px\].
    pub panel: (f64, f64),
}

impl Default for Figure {
    fn default() -> Figure {
        Figure {
            title: String::new(),
            description: String::new(),
            groups: Vec::new(),
            columns: 1,
            panel: (420.0, 300.0),
        }
    }
}

/// A unit as print has it.
///
/// ```
/// assert_eq!(gearwise_report::plot::unit("kg*m^2"), "kg·m²");
/// ```
pub fn unit(text: &str) -> String {
    text.replace('*', "·").replace("^2", "²").replace("^3", "³")
}

/// The axis of an objective, with its unit.
fn objective_axis(goal: &Objective) -> Axis {
    Axis::linear(match goal.unit() {
        "1" => format!("{}, weighted [1]", goal.name()),
        si => format!("{} [{}]", goal.name(), unit(si)),
    })
}

/// Lines that lie over each other become one, with all their names: a legend of two lines of which one is seen would
/// have its reader look for the other. `height` is that of the panel, in the ordinate's unit.
fn merge_coincident(all: Vec<Series>, height: f64) -> Vec<Series> {
    let near = |a: f64, b: f64| (a - b).abs() <= 2e-3 * height || (!a.is_finite() && !b.is_finite());
    let same = |a: &Series, b: &Series| {
        let pairs = || a.points.iter().zip(&b.points);
        a.points.len() == b.points.len() && pairs().all(|(p, q)| near(p.1, q.1) && (p.0 == q.0 || !p.0.is_finite()))
    };
    let mut kept: Vec<Series> = Vec::new();
    for series in all {
        match kept.iter_mut().find(|k| same(k, &series)) {
            Some(first) if !series.name.is_empty() => first.name = together(&first.name, &series.name),
            Some(_) => {}
            None => kept.push(series),
        }
    }
    kept
}

/// Two names of one line: `a ≤ b` and `a ≤ c` are `a ≤ b = c`.
fn together(first: &str, second: &str) -> String {
    let bounded = |name: &str| name.split_once(" ≤ ").map(|(of, by)| (of.to_string(), by.to_string()));
    match (bounded(first), bounded(second)) {
        (Some((of, _)), Some((other, by))) if of == other => format!("{first} = {by}"),
        _ => format!("{first} = {second}"),
    }
}

/// At most `most` of `count` indices, evenly spread.
///
/// ```
/// use gearwise_report::plot::thinned;
/// assert_eq!(thinned(5, 10).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
/// assert_eq!(thinned(9, 3).collect::<Vec<_>>(), [0, 3, 6]);
/// ```
pub fn thinned(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let drawn = count.min(most);
    (0..drawn).map(move |k| k * count / drawn)
}

/// Whether a file is to be SVG or PNG, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Lines and text.
    Svg,
    /// Pixels: only where the feature `png` is on.
    #[cfg(feature = "png")]
    Png,
}

impl Format {
    /// From the name's ending.
    ///
    /// # Errors
    /// An ending that is neither, or that of a format which this program was built without.
    pub fn of(path: &Path) -> Result<Format, String> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(Format::Svg),
            #[cfg(feature = "png")]
            Some("png") => Ok(Format::Png),
            #[cfg(not(feature = "png"))]
            Some("png") => {
                Err(format!("`{}`: {}, or draw an .svg", path.display(), gearwise_model::words::not_built("PNG")))
            }
            _ => Err(format!("`{}`: a picture's name ends in .svg or .png", path.display())),
        }
    }
}

/// Draws a figure into a file, whole or not at all.
///
/// # Errors
/// In words, where it cannot be drawn or written.
pub fn write(figure: &Figure, path: &Path) -> Result<(), String> {
    let bytes = match Format::of(path)? {
        Format::Svg => svg(figure).into_bytes(),
        #[cfg(feature = "png")]
        Format::Png => png(figure)?,
    };
    output::write_whole(path, &bytes)
}
