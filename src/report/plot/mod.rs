//! Pictures: a figure is panels of series over two axes, drawn as SVG; a PNG is that SVG, rendered.
//!
//! The one idea: what is drawn is data ([`Figure`]), and one place draws it, so that every picture has the
//! same look: units on the axes, two colours that also differ in grey and to the colour-blind, a bounded
//! number of points, chosen without chance.

pub mod characterize;
pub mod residual;

use std::path::Path;
use std::sync::Arc;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::file;

/// Width of a panel \[px\].
const WIDTH: u32 = 420;
/// Height of a panel \[px\].
const HEIGHT: u32 = 300;
/// Height of the title of a group of panels \[px\].
const TITLE: u32 = 56;
/// Pixels of a PNG for each pixel of the SVG.
const PNG_SCALE: f32 = 1.5;
/// Latin and Greek letters of DejaVu Sans (free; its licence lies beside it), so that a PNG looks the same
/// everywhere.
const FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

/// The two looks that a series can have: light and dark in grey, orange and blue in colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// What was: light.
    Light,
    /// What is: dark.
    Dark,
}

impl Tone {
    /// Orange and blue of the palette of Okabe and Ito.
    fn colour(self) -> RGBColor {
        match self {
            Tone::Light => RGBColor(230, 159, 0),
            Tone::Dark => RGBColor(0, 114, 178),
        }
    }

    /// For lines over dots of the same tone.
    fn line(self) -> RGBColor {
        match self {
            Tone::Light => RGBColor(140, 80, 0),
            Tone::Dark => RGBColor(0, 40, 80),
        }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A dot for each point.
    Dots,
    /// A line through the points, dashed where light.
    Line,
    /// A bar from zero for each point.
    Bars,
}

/// Points that are drawn alike.
#[derive(Debug, Clone)]
pub struct Series {
    /// Light or dark.
    pub tone: Tone,
    /// How.
    pub mark: Mark,
    /// Abscissa and ordinate; points that are not finite are left out.
    pub points: Vec<(f64, f64)>,
}

/// Two axes and what is drawn over them.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Abscissa, with its unit.
    pub x: String,
    /// Ordinate, with its unit.
    pub y: String,
    /// Abscissae of vertical lines.
    pub lines: Vec<f64>,
    /// What is drawn, first the lowest.
    pub series: Vec<Series>,
    /// What is said where there is nothing to draw.
    pub empty: String,
}

/// Panels under a title.
#[derive(Debug, Clone, Default)]
pub struct Group {
    /// Title.
    pub title: String,
    /// What light and dark mean.
    pub legend: Vec<(Tone, String)>,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// A figure: groups of panels, one below the other.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// The groups.
    pub groups: Vec<Group>,
    /// Panels in a row.
    pub columns: usize,
}

/// At most `most` of `count` indices, evenly spread.
///
/// ```
/// use gearwise::report::plot::thinned;
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
    /// Pixels.
    Png,
}

impl Format {
    /// From the name's ending.
    ///
    /// # Errors
    /// An ending that is neither.
    pub fn of(path: &Path) -> Result<Format, String> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(Format::Svg),
            Some("png") => Ok(Format::Png),
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
        Format::Svg => svg(figure)?.into_bytes(),
        Format::Png => png(figure)?,
    };
    file::write_whole(path, &bytes)
}

/// A figure as SVG.
///
/// # Errors
/// In words, where it cannot be drawn.
pub fn svg(figure: &Figure) -> Result<String, String> {
    let columns = figure.columns.max(1);
    let rows: Vec<usize> = figure.groups.iter().map(|g| g.panels.len().div_ceil(columns)).collect();
    let heights: Vec<u32> = rows.iter().map(|r| TITLE + HEIGHT * u32::try_from(*r).unwrap_or(1)).collect();
    let size = (WIDTH * u32::try_from(columns).unwrap_or(1), heights.iter().sum::<u32>().max(1));
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(cannot)?;
        let mut top = 0;
        for ((group, height), rows) in figure.groups.iter().zip(&heights).zip(&rows) {
            let area = root.clone().shrink((0, top), (size.0, *height));
            top += *height as i32;
            let (title, body) = area.split_vertically(TITLE);
            draw_title(&title, group).map_err(cannot)?;
            for (panel, area) in group.panels.iter().zip(body.split_evenly((*rows, columns))) {
                draw_panel(&area, panel).map_err(cannot)?;
            }
        }
        root.present().map_err(cannot)?;
    }
    Ok(text)
}

/// A figure as PNG.
///
/// # Errors
/// In words, where it cannot be drawn.
pub fn png(figure: &Figure) -> Result<Vec<u8>, String> {
    use resvg::{tiny_skia, usvg};
    let text = svg(figure)?;
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    let options = usvg::Options { fontdb: Arc::new(fonts), font_family: "DejaVu Sans".into(), ..Default::default() };
    let tree = usvg::Tree::from_str(&text, &options).map_err(cannot)?;
    let size = tree.size().to_int_size().scale_by(PNG_SCALE).ok_or("the picture has no size")?;
    let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height()).ok_or("the picture is too large")?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(cannot)
}

fn cannot(error: impl std::fmt::Display) -> String {
    format!("cannot draw the picture: {error}")
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type DrawResult = Result<(), Box<dyn std::error::Error>>;

fn draw_title(area: &Area, group: &Group) -> DrawResult {
    let style = ("sans-serif", 17).into_text_style(area);
    area.draw(&Text::new(group.title.clone(), (14, 8), style))?;
    let style = ("sans-serif", 13).into_text_style(area);
    for (k, (tone, meaning)) in group.legend.iter().enumerate() {
        let x = 22 + 330 * i32::try_from(k).unwrap_or(0);
        area.draw(&Circle::new((x, 43), 4, tone.colour().filled()))?;
        let dashes: &[(i32, i32)] = if *tone == Tone::Light { &[(9, 15), (18, 24), (27, 33)] } else { &[(9, 33)] };
        for (from, to) in dashes {
            area.draw(&PathElement::new(vec![(x + from, 43), (x + to, 43)], tone.line().stroke_width(2)))?;
        }
        area.draw(&Text::new(meaning.clone(), (x + 40, 36), style.clone()))?;
    }
    Ok(())
}

/// The interval of finite values with a margin.
fn interval(values: impl Iterator<Item = f64>, with_zero: bool) -> Option<(f64, f64)> {
    let start = if with_zero { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
    let (low, high) = values.filter(|v| v.is_finite()).fold(start, |(l, h), v| (l.min(v), h.max(v)));
    (high > low).then(|| {
        let margin = 0.04 * (high - low);
        (if with_zero && low == 0.0 { 0.0 } else { low - margin }, high + margin)
    })
}

fn draw_panel(area: &Area, panel: &Panel) -> DrawResult {
    let points = || panel.series.iter().flat_map(|s| &s.points).filter(|p| p.0.is_finite() && p.1.is_finite());
    let bars = panel.series.iter().any(|s| s.mark == Mark::Bars);
    let (Some(x), Some(y)) = (interval(points().map(|p| p.0), false), interval(points().map(|p| p.1), bars)) else {
        let (width, height) = area.dim_in_pixel();
        let style = ("sans-serif", 13).into_text_style(area).color(&RGBColor(90, 90, 90));
        let centre = style.pos(Pos::new(HPos::Center, VPos::Center));
        let at = (width as i32 / 2, height as i32 / 2);
        area.draw(&Text::new(format!("{}: {}", panel.x, panel.empty), at, centre))?;
        return Ok(());
    };
    let (x_step, y_step) = ((x.1 - x.0) / 6.0, (y.1 - y.0) / 6.0);
    let mut chart = ChartBuilder::on(area)
        .margin_right(16)
        .margin_top(6)
        .margin_bottom(4)
        .margin_left(4)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .x_labels(7)
        .y_labels(7)
        .max_light_lines(0)
        .bold_line_style(RGBColor(225, 225, 225))
        .axis_style(RGBColor(90, 90, 90))
        .x_desc(panel.x.as_str())
        .y_desc(panel.y.as_str())
        .label_style(("sans-serif", 12))
        .axis_desc_style(("sans-serif", 13))
        .x_label_formatter(&|v| tick(*v, x_step))
        .y_label_formatter(&|v| tick(*v, y_step))
        .draw()?;
    for line in &panel.lines {
        let style = RGBColor(120, 120, 120).stroke_width(1);
        chart.draw_series(std::iter::once(PathElement::new(vec![(*line, y.0), (*line, y.1)], style)))?;
    }
    for series in &panel.series {
        let finite = series.points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite());
        let (colour, line) = (series.tone.colour(), series.tone.line());
        match (series.mark, series.tone) {
            (Mark::Dots, _) => {
                chart.draw_series(finite.map(|p| Circle::new(p, 2, colour.mix(0.55).filled())))?;
            }
            (Mark::Line, Tone::Light) => {
                chart.draw_series(DashedLineSeries::new(finite, 6, 4, line.stroke_width(2)))?;
            }
            (Mark::Line, Tone::Dark) => {
                chart.draw_series(LineSeries::new(finite, line.stroke_width(2)))?;
            }
            (Mark::Bars, tone) => {
                let width = if tone == Tone::Light { 3 } else { 2 };
                let style = if tone == Tone::Light { colour } else { line };
                chart.draw_series(
                    finite.map(|(x, y)| PathElement::new(vec![(x, 0.0), (x, y)], style.stroke_width(width))),
                )?;
            }
        }
    }
    Ok(())
}

/// The text of a tick: as many digits as steps of this size need.
fn tick(value: f64, step: f64) -> String {
    if value.abs() < 1e-6 * step {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&step) {
        return format!("{value:.1e}");
    }
    let digits = (1.0 - step.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}
