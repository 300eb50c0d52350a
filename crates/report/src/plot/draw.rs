//! The one place that draws: a figure in, SVG out.
//!
//! Written directly, as SVG is a simple text: whole curves are single elements with dash patterns, what lies
//! outside a panel is clipped, points carry their names. Everything is first measured, then drawn, so that
//! titles, legends and tick texts have the room that they need.

use super::axis::{Mapped, Ticks, ticks};
use super::labels::{Placed, Rect, Wanted, overlap, place};
use super::legend::{draw_legend, legend, legend_height};
use super::paint::{GRID, LINE, STRIPE, TEXT, bar, colours};
use super::pen::{Anchor, Pen, TextStyle, clipped, escaped, px, text_width, wrapped};
use super::{Along, Figure, Group, Label, Mark, Panel, Rule, Series, Stripe, Tone};

/// Sizes of text \[px\].
const TITLE: f64 = 16.0;
const PANEL_TITLE: f64 = 13.0;
const SMALL: f64 = 11.0;
const MARGIN: f64 = 14.0;
const FRAME: &str = "#5a5a5a";

/// Where things came to stand: for tests, and for whoever wants to know.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// Plotting area of each panel \[px\].
    pub frames: Vec<Rect>,
    /// Every text in a panel (labels, texts along lines and at rules) with its rectangle \[px\].
    pub texts: Vec<(String, Rect)>,
    /// Every labelled point \[px\].
    pub points: Vec<(f64, f64)>,
    /// Labels that found no place.
    pub left_out: Vec<String>,
}

/// A figure as SVG.
pub fn svg(figure: &Figure) -> String {
    svg_and_layout(figure).0
}

/// A figure as SVG, and where its labels stand.
pub fn svg_and_layout(figure: &Figure) -> (String, Layout) {
    let mut layout = Layout::default();
    let columns = figure.columns.max(1);
    let width = figure.panel.0 * columns as f64;
    let mut pen = Pen::default();
    let mut top = 0.0;
    for group in &figure.groups {
        top = draw_group(&mut pen, figure, group, top, (width, columns), &mut layout);
    }
    let height = top.max(1.0);
    let titles = || figure.groups.iter().map(|g| g.title.as_str()).collect::<Vec<_>>().join("; ");
    let title = if figure.title.is_empty() { titles() } else { figure.title.clone() };
    let description = if figure.description.is_empty() { described(figure) } else { figure.description.clone() };
    let (w, h) = (px(width.ceil()), px(height.ceil()));
    let (title, description) = (escaped(&title), escaped(&description));
    let text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\" \
         aria-label=\"{title}\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<title>{title}</title>\n\
         <desc>{description}</desc>\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
        pen.out
    );
    (text, layout)
}

/// What is to be seen, from the axes and the legend.
pub(crate) fn described(figure: &Figure) -> String {
    let panel = |p: &Panel| {
        let mut names: Vec<&str> = Vec::new();
        for name in p.series.iter().map(|s| s.name.as_str()).filter(|n| !n.is_empty()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let names = if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
        format!("{} over {}{names}.", p.y.label, p.x.label)
    };
    figure.groups.iter().flat_map(|g| &g.panels).map(panel).collect::<Vec<_>>().join(" ")
}

fn draw_group(
    pen: &mut Pen,
    figure: &Figure,
    group: &Group,
    top: f64,
    (width, columns): (f64, usize),
    layout: &mut Layout,
) -> f64 {
    let mut y = top + 10.0;
    let inner = width - 2.0 * MARGIN;
    let titles = wrapped(&group.title, TITLE * 1.1, inner);
    for line in &titles {
        y += TITLE + 4.0;
        pen.text((MARGIN, y), line, TextStyle { bold: true, ..TextStyle::new(TITLE, Anchor::Start) });
    }
    for line in wrapped(&group.caption, SMALL, inner) {
        y += SMALL + 4.0;
        pen.text((MARGIN, y), &line, TextStyle { colour: "#444444", ..TextStyle::new(SMALL, Anchor::Start) });
    }
    if !group.own_legends {
        let entries = legend(group.panels.iter());
        y = draw_legend(pen, &entries, (MARGIN, y + 6.0), inner);
    }
    y += 8.0;
    let (panel_width, panel_height) = figure.panel;
    for row in group.panels.chunks(columns) {
        let inner = panel_width - 2.0 * MARGIN;
        // Panels of a row share their upper edge.
        let head = |p: &Panel| {
            let title = wrapped(&p.title, PANEL_TITLE * 1.1, inner).len() as f64 * (PANEL_TITLE + 4.0);
            let legend = if group.own_legends { legend_height(&legend([p].into_iter()), inner) } else { 0.0 };
            title + legend
        };
        let head = row.iter().map(head).fold(0.0, f64::max);
        for (k, panel) in row.iter().enumerate() {
            let left = k as f64 * panel_width;
            let mut at = y;
            for line in wrapped(&panel.title, PANEL_TITLE * 1.1, inner) {
                at += PANEL_TITLE + 4.0;
                let style = TextStyle { bold: true, ..TextStyle::new(PANEL_TITLE, Anchor::Start) };
                pen.text((left + MARGIN, at), &line, style);
            }
            if group.own_legends {
                draw_legend(pen, &legend([panel].into_iter()), (left + MARGIN, at), inner);
            }
            draw_panel(pen, panel, [left, y + head, left + panel_width, y + head + panel_height], layout);
        }
        y += head + panel_height;
    }
    y + 4.0
}

/// What the two axes of a panel run over; `None` where there is nothing to draw.
pub(crate) fn ranges(panel: &Panel) -> Option<((f64, f64), (f64, f64))> {
    let shown = |p: &(f64, f64)| panel.x.shows(p.0) && panel.y.shows(p.1);
    let points = || panel.series.iter().flat_map(|s| &s.points).filter(|p| shown(p));
    let uppers = || panel.series.iter().flat_map(|s| &s.upper).copied();
    let bars = panel.series.iter().any(|s| s.mark == Mark::Bars);
    points().next()?;
    let x = panel.x.span(points().map(|p| p.0), false)?;
    let y = panel.y.span(points().map(|p| p.1).chain(uppers()), bars)?;
    Some((x, y))
}

/// The two axes of a panel with their place, and what stands at them.
struct Axes {
    x: Mapped,
    y: Mapped,
    x_ticks: Ticks,
    y_ticks: Ticks,
    frame: Rect,
    /// Whether the abscissa counts things.
    counts: bool,
}

impl Axes {
    fn new(panel: &Panel, [left, top, right, bottom]: Rect) -> Option<Axes> {
        let (x, y) = ranges(panel)?;
        let (top, bottom) = (top + 8.0, bottom - if panel.x.label.is_empty() { 26.0 } else { 44.0 });
        let y_most = if panel.y.names.is_empty() { ((bottom - top) / 38.0) as usize } else { usize::MAX };
        let y_ticks = ticks(&panel.y, y, y_most);
        let widest = y_ticks.labelled.iter().map(|t| text_width(&t.1, SMALL)).fold(0.0, f64::max);
        let left = left + 10.0 + widest + if panel.y.label.is_empty() { 6.0 } else { 26.0 };
        let right = right - 18.0;
        let room = (right - left).max(10.0);
        // As many ticks as have room beside each other.
        let mut most = (room / 48.0) as usize + 1;
        let x_ticks = loop {
            let found = ticks(&panel.x, x, most);
            let widest = found.labelled.iter().map(|t| text_width(&t.1, SMALL)).fold(0.0, f64::max);
            if most <= 2 || (widest + 10.0) * found.labelled.len() as f64 <= room {
                break found;
            }
            most -= 1;
        };
        Some(Axes {
            x: Mapped::new(&panel.x, x, (left, right)),
            y: Mapped::new(&panel.y, y, (bottom, top)),
            x_ticks,
            y_ticks,
            frame: [left, top, right, bottom],
            counts: !panel.x.names.is_empty(),
        })
    }

    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.pixel(x), self.y.pixel(y))
    }

    fn holds(&self, (x, y): (f64, f64)) -> bool {
        x.is_finite() && y.is_finite() && self.x.holds(x) && self.y.holds(y)
    }

    fn draw(&self, pen: &mut Pen, panel: &Panel, outer: Rect) {
        let [left, top, right, bottom] = self.frame;
        for (ticks, axis, upright) in [(&self.x_ticks, &self.x, true), (&self.y_ticks, &self.y, false)] {
            let minor = ticks.minor.iter().map(|v| (*v, "#f1f1f1"));
            for (value, colour) in minor.chain(ticks.labelled.iter().map(|t| (t.0, GRID))) {
                let p = axis.pixel(value);
                let line = if upright { [(p, top), (p, bottom)] } else { [(left, p), (right, p)] };
                pen.line(&line, colour, 1.0, super::Dash::Solid, "");
            }
        }
        for (value, text) in &self.x_ticks.labelled {
            pen.text((self.x.pixel(*value), bottom + 15.0), text, TextStyle::new(SMALL, Anchor::Middle));
        }
        for (value, text) in &self.y_ticks.labelled {
            pen.text((left - 5.0, self.y.pixel(*value) + 4.0), text, TextStyle::new(SMALL, Anchor::End));
        }
        let style = TextStyle::new(TEXT, Anchor::Middle);
        if !panel.x.label.is_empty() {
            pen.text((0.5 * (left + right), bottom + 34.0), &panel.x.label, style);
        }
        if !panel.y.label.is_empty() {
            let at = (outer[0] + 18.0, 0.5 * (top + bottom));
            pen.text(at, &panel.y.label, TextStyle { turn: -90.0, ..style });
        }
    }
}

fn draw_panel(pen: &mut Pen, panel: &Panel, outer: Rect, layout: &mut Layout) {
    let Some(axes) = Axes::new(panel, outer) else {
        let of = if panel.x.label.is_empty() { String::new() } else { format!("{}: ", panel.x.label) };
        let text = format!("{of}{}", panel.empty);
        // A frame, so that it is seen that here is nothing, and not that something was forgotten.
        let [left, top, right, bottom] = outer;
        pen.rect(
            [left + MARGIN, top + 8.0, right - MARGIN, bottom - 26.0],
            &format!("fill=\"none\" stroke=\"{GRID}\""),
        );
        let lines = wrapped(&text, TEXT, outer[2] - outer[0] - 4.0 * MARGIN);
        let centre = 0.5 * (outer[0] + outer[2]);
        let mut y = 0.5 * (outer[1] + outer[3]) - 0.5 * LINE * lines.len() as f64;
        for line in lines {
            y += LINE;
            pen.text((centre, y), &line, TextStyle { colour: FRAME, ..TextStyle::new(TEXT, Anchor::Middle) });
        }
        return;
    };
    axes.draw(pen, panel, outer);
    let frame = axes.frame;
    layout.frames.push(frame);
    let [x, y, w, h] = [frame[0], frame[1], frame[2] - frame[0], frame[3] - frame[1]].map(px);
    // An inner picture clips what lies outside.
    pen.open(&format!("svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" viewBox=\"{x} {y} {w} {h}\""));
    for stripe in &panel.stripes {
        draw_stripe(pen, &axes, stripe);
    }
    for rule in &panel.rules {
        pen.line(&rule_ends(&axes, rule), rule.tone.dark_line(), 1.2, rule.dash, &rule.text);
    }
    for series in &panel.series {
        // A line over dots of its own tone has to be darker than they are.
        let over = panel.series.iter().any(|s| s.mark == Mark::Dots && s.tone == series.tone);
        let line = if over { series.tone.dark() } else { series.tone.dark_line() };
        draw_series(pen, &axes, series, line);
    }
    pen.close("svg");
    pen.rect(frame, &format!("fill=\"none\" stroke=\"{FRAME}\""));
    draw_texts(pen, panel, &axes, layout);
}

fn draw_stripe(pen: &mut Pen, axes: &Axes, stripe: &Stripe) {
    let f = axes.frame;
    let rect = match stripe.along {
        Along::X => {
            let ends = [stripe.from, stripe.to].map(|v| axes.x.pixel(v).clamp(f[0], f[2]));
            [ends[0], f[1], ends[1], f[3]]
        }
        Along::Y => {
            let ends = [stripe.from, stripe.to].map(|v| axes.y.pixel(v).clamp(f[1], f[3]));
            [f[0], ends[1], f[2], ends[0]]
        }
    };
    if rect[2] > rect[0] && rect[3] > rect[1] {
        pen.rect(rect, &format!("fill=\"{}\" fill-opacity=\"{STRIPE}\"", stripe.tone.colour()));
    }
}

fn rule_ends(axes: &Axes, rule: &Rule) -> [(f64, f64); 2] {
    let [left, top, right, bottom] = axes.frame;
    match rule.along {
        Along::X => [(axes.x.pixel(rule.at), top), (axes.x.pixel(rule.at), bottom)],
        Along::Y => [(left, axes.y.pixel(rule.at)), (right, axes.y.pixel(rule.at))],
    }
}

fn draw_series(pen: &mut Pen, axes: &Axes, series: &Series, line: &'static str) {
    let (tone, note) = (series.tone, |k: usize| series.note(k));
    let held = || series.points.iter().enumerate().filter(|(_, p)| axes.holds(**p));
    let [left, top, right, bottom] = axes.frame;
    let near = [left - 20.0, top - 20.0, right + 20.0, bottom + 20.0];
    let through = || clipped(&series.points.iter().map(|p| axes.at(*p)).collect::<Vec<_>>(), near);
    match series.mark {
        Mark::Dots => {
            pen.open(&format!("g fill=\"{}\" fill-opacity=\"0.55\"", tone.colour()));
            held().for_each(|(k, p)| pen.dot(axes.at(*p), 2.0, note(k)));
            pen.close("g");
        }
        Mark::Points(shape) => {
            let colours = colours(tone, shape, series.hollow);
            held().for_each(|(k, p)| pen.shape(axes.at(*p), shape, 3.6 * series.size(k), colours, note(k)));
        }
        Mark::Line(dash) => pen.line(&through(), line, 2.0, dash, note(0)),
        Mark::Thin(dash) => pen.line(&through(), tone.colour(), 1.0, dash, note(0)),
        Mark::Bars => {
            let zero = axes.y.pixel(axes.y.range.0.max(0.0));
            // Of an axis of things each has a bar as wide as there is room for.
            if axes.counts {
                let half = 0.3 * (axes.x.pixel(1.0) - axes.x.pixel(0.0));
                for (k, p) in held() {
                    let (x, y) = axes.at(*p);
                    let [x, y, w, h] = [x - half, y.min(zero), 2.0 * half, (y - zero).abs()].map(px);
                    let size = format!("x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"");
                    pen.element("rect", &format!("{size} {}", bar(tone, series.hollow)), note(k));
                }
                return;
            }
            for (k, p) in held() {
                let (x, y) = axes.at(*p);
                let width = if tone == Tone::Orange { 3.0 } else { 2.0 };
                pen.line(&[(x, zero), (x, y)], tone.dark_line(), width, super::Dash::Solid, note(k));
            }
        }
        Mark::Band => {
            let finite = || series.points.iter().zip(&series.upper).filter(|(p, u)| p.1.is_finite() && u.is_finite());
            let lower = finite().map(|(p, _)| axes.at(*p));
            let upper: Vec<_> = finite().map(|(p, u)| axes.at((p.0, *u))).collect();
            let edge: Vec<(f64, f64)> = lower.chain(upper.into_iter().rev()).collect();
            pen.area(&edge, tone.colour(), 0.3, note(0));
        }
    }
}

/// Texts along lines and at rules first, as they have few places; then the labels around them.
fn draw_texts(pen: &mut Pen, panel: &Panel, axes: &Axes, layout: &mut Layout) {
    let labels: Vec<&Label> = panel.labels.iter().filter(|l| axes.holds(l.at)).collect();
    let wanted: Vec<Wanted> = labels.iter().map(|l| wanted(axes, l)).collect();
    let mut taken: Vec<Rect> =
        wanted.iter().map(|w| [w.at.0 - 6.0, w.at.1 - 6.0, w.at.0 + 6.0, w.at.1 + 6.0]).collect();
    let points = taken.len();
    for rule in panel.rules.iter().filter(|r| !r.text.is_empty()) {
        if let Some(rect) = rule_text(pen, axes, rule, &taken) {
            layout.texts.push((rule.text.clone(), rect));
            taken.push(rect);
        }
    }
    let crowd = crowd(panel, axes);
    for series in panel.series.iter().filter(|s| !s.along.is_empty()) {
        if let Some(rect) = along_text(pen, axes, series, &taken, &crowd) {
            layout.texts.push((series.along.clone(), rect));
            taken.push(rect);
        }
    }
    let placed = place(&wanted, axes.frame, &taken[points..], &crowd);
    for (label, w) in labels.iter().zip(&wanted) {
        layout.points.push(w.at);
        if label.chosen {
            let (x, y) = (px(w.at.0), px(w.at.1));
            let paint = "fill=\"none\" stroke=\"#000000\" stroke-width=\"1.8\"";
            pen.element("circle", &format!("cx=\"{x}\" cy=\"{y}\" r=\"7\" {paint}"), &label.text);
        }
    }
    for placed in placed.iter().flatten() {
        if let Some(leader) = &placed.leader {
            pen.line(leader, "#777777", 0.8, super::Dash::Solid, "");
        }
    }
    for (label, placed) in labels.iter().zip(&placed) {
        match placed {
            Some(Placed { rect, .. }) => {
                // The end that looks at the point stands fast, however wide the reader's font is.
                let left_of = 0.5 * (rect[0] + rect[2]) < axes.at(label.at).0;
                let (x, anchor) = if left_of { (rect[2] - 1.0, Anchor::End) } else { (rect[0] + 1.0, Anchor::Start) };
                let style = TextStyle { bold: label.chosen, halo: true, ..TextStyle::new(SMALL, anchor) };
                pen.text((x, rect[3] - 3.5), &label.text, style);
                layout.texts.push((label.text.clone(), *rect));
            }
            None => layout.left_out.push(label.text.clone()),
        }
    }
}

fn wanted(axes: &Axes, label: &Label) -> Wanted {
    let bold = if label.chosen { 1.12 } else { 1.0 };
    Wanted { at: axes.at(label.at), size: (bold * text_width(&label.text, SMALL) + 2.0, SMALL + 3.0) }
}

/// What labels had better not cover: points, and curves every few pixels.
fn crowd(panel: &Panel, axes: &Axes) -> Vec<(f64, f64)> {
    let mut all = Vec::new();
    for rule in &panel.rules {
        let [a, b] = rule_ends(axes, rule);
        all.extend(
            (0..100).map(|k| (a.0 + 0.01 * f64::from(k) * (b.0 - a.0), a.1 + 0.01 * f64::from(k) * (b.1 - a.1))),
        );
    }
    for series in &panel.series {
        let pixels: Vec<(f64, f64)> = series.points.iter().map(|p| axes.at(*p)).collect();
        match series.mark {
            Mark::Bars if axes.counts => {
                // A wide bar is in the way with all of its area.
                let half = 0.3 * (axes.x.pixel(1.0) - axes.x.pixel(0.0));
                let bottom = axes.frame[3];
                for (x, y) in pixels.iter().filter(|p| p.1.is_finite()) {
                    let rows = ((bottom - y) / 8.0).clamp(1.0, 100.0) as u32;
                    let across = [-0.9, -0.5, 0.0, 0.5, 0.9];
                    all.extend((0..rows).flat_map(|r| across.map(|s| (x + s * half, y + 1.0 + 8.0 * f64::from(r)))));
                }
            }
            Mark::Dots | Mark::Bars => all.extend(pixels),
            // A shape counts with its extent.
            Mark::Points(_) => all.extend(pixels.iter().flat_map(|(x, y)| {
                [(0.0, 0.0), (3.5, 0.0), (-3.5, 0.0), (0.0, 3.5), (0.0, -3.5)].map(|(dx, dy)| (x + dx, y + dy))
            })),
            Mark::Line(_) | Mark::Thin(_) | Mark::Band => {
                for pair in pixels.windows(2) {
                    let length = f64::hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
                    if !length.is_finite() {
                        continue;
                    }
                    let parts = (length / 6.0).ceil().clamp(1.0, 300.0);
                    all.extend((0..parts as usize).map(|k| {
                        let share = k as f64 / parts;
                        (pair[0].0 + share * (pair[1].0 - pair[0].0), pair[0].1 + share * (pair[1].1 - pair[0].1))
                    }));
                }
            }
        }
    }
    let [left, top, right, bottom] = axes.frame;
    all.retain(|p| p.0 >= left && p.0 <= right && p.1 >= top && p.1 <= bottom);
    all
}

/// The text at a rule's end, beside it; the first place that is free.
fn rule_text(pen: &mut Pen, axes: &Axes, rule: &Rule, taken: &[Rect]) -> Option<Rect> {
    let [left, top, right, bottom] = axes.frame;
    let (length, height) = (text_width(&rule.text, SMALL), SMALL + 3.0);
    let ends = rule_ends(axes, rule);
    let (places, turn): (Vec<Rect>, f64) = match rule.along {
        Along::Y => {
            let y = ends[0].1;
            let ups = [y - height - 1.0, y + 2.0];
            let lefts = [right - length - 4.0, left + 4.0, 0.5 * (left + right - length)];
            let rects = lefts.iter().flat_map(|l| ups.map(|t| [*l, t, l + length, t + height]));
            (rects.collect(), 0.0)
        }
        Along::X => {
            let x = ends[0].0;
            let sides = [x + 2.0, x - height - 1.0];
            let tops = [top + 4.0, bottom - length - 4.0, 0.5 * (top + bottom - length)];
            let rects = tops.iter().flat_map(|t| sides.map(|l| [l, *t, l + height, t + length]));
            (rects.collect(), -90.0)
        }
    };
    let free = |r: &&Rect| {
        r[0] >= left && r[1] >= top && r[2] <= right && r[3] <= bottom && !taken.iter().any(|t| overlap(t, r))
    };
    let rect = *places.iter().find(free)?;
    let style = TextStyle { turn, halo: true, colour: rule.tone.dark(), ..TextStyle::new(SMALL, Anchor::Start) };
    let at = if turn == 0.0 { (rect[0], rect[3] - 3.5) } else { (rect[2] - 3.5, rect[3]) };
    pen.text(at, &rule.text, style);
    Some(rect)
}

/// The text along a line, near one of its visible ends, turned as the line runs.
fn along_text(pen: &mut Pen, axes: &Axes, series: &Series, taken: &[Rect], crowd: &[(f64, f64)]) -> Option<Rect> {
    let [left, top, right, bottom] = axes.frame;
    let length = text_width(&series.along, SMALL);
    let pixels: Vec<(f64, f64)> = series.points.iter().map(|p| axes.at(*p)).collect();
    // Points every few pixels on the visible part.
    let mut trail: Vec<((f64, f64), f64)> = Vec::new();
    for pair in pixels.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let parts = (f64::hypot(dx, dy) / 4.0).ceil();
        if !(1.0..=5000.0).contains(&parts) {
            continue;
        }
        for k in 0..parts as usize {
            let share = k as f64 / parts;
            let at = (pair[0].0 + share * dx, pair[0].1 + share * dy);
            if at.0 > left && at.0 < right && at.1 > top && at.1 < bottom {
                trail.push((at, dy.atan2(dx)));
            }
        }
    }
    let shares = [0.92, 0.08, 0.85, 0.15, 0.75, 0.25, 0.65, 0.35, 0.5];
    let mut best: Option<(usize, Rect, (f64, f64), f64)> = None;
    for share in shares {
        let Some(&((x, y), angle)) = trail.get((share * trail.len() as f64) as usize) else { continue };
        // Readable from the left.
        let angle = if angle.cos() < 0.0 { angle + std::f64::consts::PI } else { angle };
        // Beside the line, on its upper side.
        let (x, y) = (x + 8.0 * angle.sin(), y - 8.0 * angle.cos());
        let (half_width, half_height) = (
            0.5 * (length * angle.cos().abs() + SMALL * angle.sin().abs()) + 1.0,
            0.5 * (length * angle.sin().abs() + SMALL * angle.cos().abs()) + 1.0,
        );
        let rect = [x - half_width, y - half_height, x + half_width, y + half_height];
        let within = rect[0] >= left && rect[1] >= top && rect[2] <= right && rect[3] <= bottom;
        if !within || taken.iter().any(|t| overlap(t, &rect)) {
            continue;
        }
        let covers = |p: &&(f64, f64)| p.0 > rect[0] && p.0 < rect[2] && p.1 > rect[1] && p.1 < rect[3];
        let covered = crowd.iter().filter(covers).count();
        if best.is_none_or(|(least, ..)| covered < least) {
            best = Some((covered, rect, (x, y), angle));
        }
    }
    let (_, rect, (x, y), angle) = best?;
    let style =
        TextStyle { turn: angle.to_degrees(), halo: true, colour: "#555555", ..TextStyle::new(SMALL, Anchor::Middle) };
    // The baseline lies a third of the letters' height below their middle.
    pen.text((x - 4.0 * angle.sin(), y + 4.0 * angle.cos()), &series.along, style);
    Some(rect)
}
