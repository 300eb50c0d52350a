//! SVG, element by element, and how wide text is.
//!
//! The one idea: coordinates are rounded to a tenth of a pixel as they are written, so that the same figure
//! is the same text on every machine; all text passes one escape.

use std::fmt::Write as _;

use super::widths::{EM, WIDTHS};
use super::{Dash, Shape};

/// Latin and Greek letters of DejaVu Sans (free; its licence lies beside it), so that a PNG looks the same
/// everywhere.
#[cfg(feature = "png")]
pub(super) const FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

/// Advance of each character in ems; DejaVu Sans is among the widest, so that text in another font fits too.
fn advance(character: char) -> f64 {
    WIDTHS.binary_search_by_key(&character, |(c, _)| *c).map_or(0.7, |k| f64::from(WIDTHS[k].1) / EM)
}

/// A raised figure or minus as the plain one: the font has not all of them, and they shall look alike.
fn lowered(character: char) -> Option<char> {
    let raised = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻";
    raised.chars().zip("0123456789−".chars()).find(|(r, _)| *r == character).map(|(_, plain)| plain)
}

/// Size of raised figures against the rest.
const RAISED: f64 = 0.72;

/// Text with its raised figures as smaller ones, lifted.
fn with_raised(text: &str, size: f64) -> String {
    let (mut out, mut up) = (String::new(), false);
    let lift = px(0.38 * size);
    for c in text.chars() {
        let plain = lowered(c);
        match (plain.is_some(), up) {
            (true, false) => {
                if out.contains("<tspan") {
                    out.push_str("</tspan>");
                }
                let _ = write!(out, "<tspan dy=\"-{lift}\" font-size=\"{}\">", px(RAISED * size));
            }
            (false, true) => {
                let _ = write!(out, "</tspan><tspan dy=\"{lift}\">");
            }
            _ => {}
        }
        up = plain.is_some();
        out.push_str(&escaped(&plain.unwrap_or(c).to_string()));
    }
    // Every tspan that was opened is closed: a lifted one, or the one that came back down.
    if out.contains("<tspan") {
        out.push_str("</tspan>");
    }
    out
}

/// Width of a line of text \[px\] at a size \[px\].
pub fn text_width(text: &str, size: f64) -> f64 {
    size * text.chars().map(|c| lowered(c).map_or_else(|| advance(c), |plain| RAISED * advance(plain))).sum::<f64>()
}

/// Text broken at spaces into lines of at most `width` \[px\].
pub(super) fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_string()),
        }
    }
    lines
}

/// Text that stands safely in SVG: markup escaped, characters that XML forbids left out.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c < ' ' || matches!(c, '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A coordinate, rounded to a tenth of a pixel.
pub(super) fn px(value: f64) -> String {
    let tenths = (value * 10.0).round();
    let tenths = if tenths == 0.0 { 0.0 } else { tenths };
    format!("{}", tenths / 10.0)
}

/// Where text stands against its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How text looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct TextStyle {
    pub size: f64,
    pub colour: &'static str,
    pub anchor: Anchor,
    /// Clockwise \[degrees\].
    pub turn: f64,
    pub bold: bool,
    /// White around the letters, so that they can be read over lines.
    pub halo: bool,
}

impl TextStyle {
    pub fn new(size: f64, anchor: Anchor) -> TextStyle {
        TextStyle { size, colour: "#222222", anchor, turn: 0.0, bold: false, halo: false }
    }
}

/// A picture being written.
#[derive(Debug, Default)]
pub(super) struct Pen {
    pub out: String,
}

impl Pen {
    /// Opens an element that holds others.
    pub fn open(&mut self, tag: &str) {
        let _ = writeln!(self.out, "<{tag}>");
    }

    /// Closes it.
    pub fn close(&mut self, name: &str) {
        let _ = writeln!(self.out, "</{name}>");
    }

    pub fn element(&mut self, name: &str, attributes: &str, title: &str) {
        let _ = match title {
            "" => writeln!(self.out, "<{name} {attributes}/>"),
            title => writeln!(self.out, "<{name} {attributes}><title>{}</title></{name}>", escaped(title)),
        };
    }

    pub fn rect(&mut self, [left, top, right, bottom]: [f64; 4], paint: &str) {
        let (x, y, w, h) = (px(left), px(top), px(right - left), px(bottom - top));
        self.element("rect", &format!("x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {paint}"), "");
    }

    pub fn line(&mut self, points: &[(f64, f64)], colour: &str, width: f64, dash: Dash, title: &str) {
        let path = path(points);
        if path.contains('L') {
            let width = px(width);
            let paint = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{}", dash.attribute());
            self.element("path", &format!("d=\"{path}\" {paint}"), title);
        }
    }

    pub fn area(&mut self, points: &[(f64, f64)], colour: &str, opacity: f64, title: &str) {
        let path = path(points);
        if path.contains('L') {
            let paint = format!("fill=\"{colour}\" fill-opacity=\"{opacity}\" stroke=\"none\"");
            self.element("path", &format!("d=\"{path}Z\" {paint}"), title);
        }
    }

    /// A dot; its colour is that of the group that it is in.
    pub fn dot(&mut self, (x, y): (f64, f64), radius: f64, title: &str) {
        let (x, y, r) = (px(x), px(y), px(radius));
        self.element("circle", &format!("cx=\"{x}\" cy=\"{y}\" r=\"{r}\""), title);
    }

    /// A shape with an outline, of about the same area whatever its kind.
    pub fn shape(&mut self, (x, y): (f64, f64), shape: Shape, r: f64, colours: (&str, &str), title: &str) {
        let (fill, outline) = colours;
        // White inside: only the outline is seen.
        let width = if fill == "#ffffff" { 1.5 } else { 0.8 };
        let closed = |corners: &[(f64, f64)]| -> String {
            let points: Vec<(f64, f64)> = corners.iter().map(|(dx, dy)| (x + r * dx, y + r * dy)).collect();
            format!("{}Z", path(&points))
        };
        let crossed = |a: [(f64, f64); 4]| -> String {
            let at = |k: usize| format!("{} {}", px(x + r * a[k].0), px(y + r * a[k].1));
            format!("M{}L{}M{}L{}", at(0), at(1), at(2), at(3))
        };
        let d = match shape {
            Shape::Circle => {
                let (x, y, r) = (px(x), px(y), px(r));
                let paint = format!("fill=\"{fill}\" stroke=\"{outline}\" stroke-width=\"{width}\"");
                return self.element("circle", &format!("cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {paint}"), title);
            }
            Shape::Square => closed(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Shape::Triangle => closed(&[(0.0, -1.25), (1.15, 0.8), (-1.15, 0.8)]),
            Shape::Down => closed(&[(0.0, 1.25), (1.15, -0.8), (-1.15, -0.8)]),
            Shape::Diamond => closed(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            Shape::Left => closed(&[(-1.25, 0.0), (0.8, -1.15), (0.8, 1.15)]),
            Shape::Cross => crossed([(-0.9, -0.9), (0.9, 0.9), (-0.9, 0.9), (0.9, -0.9)]),
            Shape::Plus => crossed([(-1.2, 0.0), (1.2, 0.0), (0.0, -1.2), (0.0, 1.2)]),
        };
        let paint = match shape {
            Shape::Cross | Shape::Plus => format!("fill=\"none\" stroke=\"{outline}\" stroke-width=\"1.8\""),
            _ => format!("fill=\"{fill}\" stroke=\"{outline}\" stroke-width=\"{width}\""),
        };
        self.element("path", &format!("d=\"{d}\" {paint}"), title);
    }

    /// A line of text; `y` is its baseline.
    pub fn text(&mut self, (x, y): (f64, f64), text: &str, style: TextStyle) {
        let anchor = match style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (x, y) = (px(x), px(y));
        let turn = match style.turn {
            0.0 => String::new(),
            angle => format!(" transform=\"rotate({} {x} {y})\"", px(angle)),
        };
        let bold = if style.bold { " font-weight=\"bold\"" } else { "" };
        let halo = match style.halo {
            true => " stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
            false => "",
        };
        let (size, colour) = (px(style.size), style.colour);
        let text = with_raised(text, style.size);
        let _ = writeln!(
            self.out,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{colour}\"{anchor}{bold}{halo}{turn}>{text}</text>"
        );
    }
}

/// The parts of a line that lie in a rectangle: else a dashed line that runs far out would have dashes without end.
pub(super) fn clipped(points: &[(f64, f64)], [left, top, right, bottom]: [f64; 4]) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    for pair in points.windows(2) {
        let ((x, y), (dx, dy)) = (pair[0], (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1));
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (start, change, low, high) in [(x, dx, left, right), (y, dy, top, bottom)] {
            let (p, q) = ((low - start) / change, (high - start) / change);
            match change {
                0.0 if start < low || start > high => to = f64::NEG_INFINITY,
                0.0 => {}
                _ => (from, to) = (from.max(p.min(q)), to.min(p.max(q))),
            }
        }
        // What is not finite is in no rectangle.
        if !(dx.is_finite() && dy.is_finite() && from <= to) {
            out.push((f64::NAN, f64::NAN));
            continue;
        }
        let at = |share: f64| if share == 1.0 { pair[1] } else { (x + share * dx, y + share * dy) };
        if out.last() != Some(&at(from)) {
            out.extend([(f64::NAN, f64::NAN), at(from)]);
        }
        out.push(at(to));
    }
    out
}

/// `M … L …` through the points; where one is not finite the line is broken, points that fall together
/// after rounding are written once.
fn path(points: &[(f64, f64)]) -> String {
    let (mut out, mut last, mut drawing) = (String::new(), (String::new(), String::new()), false);
    for (x, y) in points {
        if !x.is_finite() || !y.is_finite() {
            drawing = false;
            continue;
        }
        // A nested SVG clips; numbers without end must still stay readable for it.
        let here = (px(x.clamp(-1e5, 1e5)), px(y.clamp(-1e5, 1e5)));
        if drawing && here == last {
            continue;
        }
        let _ = write!(out, "{}{} {}", if drawing { 'L' } else { 'M' }, here.0, here.1);
        (last, drawing) = (here, true);
    }
    out
}
