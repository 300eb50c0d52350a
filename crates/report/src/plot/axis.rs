//! Axes: from values to pixels, and where the ticks stand.

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; values that are not positive are left out.
    Log,
}

/// An axis: what it measures, and how.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// First and last value; from the data where not given.
    pub range: Option<(f64, f64)>,
    /// Names of the values 0, 1, 2, … of an axis that counts things; empty for numbers.
    pub names: Vec<String>,
}

impl From<&str> for Axis {
    fn from(label: &str) -> Axis {
        Axis::linear(label)
    }
}

impl Axis {
    /// A linear axis over the data.
    pub fn linear(label: impl Into<String>) -> Axis {
        Axis { label: label.into(), ..Axis::default() }
    }

    /// A logarithmic axis over the data.
    pub fn log(label: impl Into<String>) -> Axis {
        Axis { label: label.into(), scale: Scale::Log, ..Axis::default() }
    }

    /// The same with a range of its own.
    #[must_use]
    pub fn within(mut self, low: f64, high: f64) -> Axis {
        self.range = Some((low, high));
        self
    }

    /// An axis of things with names, one unit each.
    pub fn named(label: impl Into<String>, names: Vec<String>) -> Axis {
        let range = Some((-0.6, names.len() as f64 - 0.4));
        Axis { label: label.into(), range, names, ..Axis::default() }
    }

    /// Whether a value can stand on the axis.
    pub fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    /// The range: its own, or that of the values with a margin; `with_zero` starts at zero.
    pub(super) fn span(&self, values: impl Iterator<Item = f64>, with_zero: bool) -> Option<(f64, f64)> {
        if let Some((low, high)) = self.range {
            let usable = self.shows(low) && self.shows(high) && low < high && (high - low).is_finite();
            return usable.then_some((low, high));
        }
        let with_zero = with_zero && self.scale == Scale::Linear;
        let start = if with_zero { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        let (low, high) = values.filter(|v| self.shows(*v)).fold(start, |(l, h), v| (l.min(v), h.max(v)));
        if self.scale == Scale::Log && low.is_finite() {
            let factor = (high / low).powf(0.04).max(1.05);
            // Decades are counted: the ends must stay numbers.
            return Some(((low / factor).max(1e-300), (high * factor).min(1e300)));
        }
        (high > low).then(|| {
            let margin = 0.04 * (high - low);
            (if with_zero && low == 0.0 { 0.0 } else { low - margin }, high + margin)
        })
    }
}

/// An axis with its place in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mapped {
    scale: Scale,
    pub range: (f64, f64),
    pixels: (f64, f64),
}

impl Mapped {
    pub fn new(axis: &Axis, range: (f64, f64), pixels: (f64, f64)) -> Mapped {
        Mapped { scale: axis.scale, range, pixels }
    }

    fn position(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Log => (value / low).ln() / (high / low).ln(),
        }
    }

    /// The pixel of a value; not a number where it has none.
    pub fn pixel(&self, value: f64) -> f64 {
        let (from, to) = self.pixels;
        if self.scale == Scale::Log && value <= 0.0 { f64::NAN } else { from + (to - from) * self.position(value) }
    }

    /// Whether a value lies in the range.
    pub fn holds(&self, value: f64) -> bool {
        let (low, high) = self.range;
        let rounding = 1e-9 * (high - low);
        value >= low - rounding && value <= high + rounding
    }
}

/// Where an axis has ticks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ticks {
    /// Values with their text.
    pub labelled: Vec<(f64, String)>,
    /// Values without.
    pub minor: Vec<f64>,
}

/// Ticks of an axis over a range, of which at most about `most` have a text; of a logarithmic axis at least three,
/// from fewer nobody can tell that it is one.
///
/// ```
/// use gearwise_report::plot::{ticks, Axis};
/// let texts = |axis: Axis, range| ticks(&axis, range, 6).labelled.into_iter().map(|t| t.1).collect::<Vec<_>>();
/// assert_eq!(texts(Axis::linear(""), (-0.1, 1.07)), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
/// assert_eq!(texts(Axis::log(""), (2e-7, 3e-4)), ["10⁻⁶", "10⁻⁵", "10⁻⁴"]);
/// assert_eq!(texts(Axis::log(""), (3.0, 70.0)), ["5", "10", "20", "50"]);
/// assert_eq!(texts(Axis::log(""), (11.0, 78.0)), ["20", "40", "60"]);
/// ```
pub fn ticks(axis: &Axis, (low, high): (f64, f64), most: usize) -> Ticks {
    if !axis.names.is_empty() {
        let step = axis.names.len().div_ceil(most.max(1)).max(1);
        let named = axis.names.iter().enumerate().step_by(step).map(|(k, name)| (k as f64, name.clone()));
        return Ticks { labelled: named.filter(|(k, _)| *k >= low && *k <= high).collect(), minor: Vec::new() };
    }
    match axis.scale {
        Scale::Linear => steps(low, high, most),
        Scale::Log => {
            let most = most.max(LEAST);
            let found = if high >= 5.0 * low { decades(low, high, most) } else { steps(low, high, most) };
            match found.labelled.len() {
                LEAST.. => found,
                _ => {
                    (most..most + 16).map(|k| steps(low, high, k)).find(|t| t.labelled.len() >= LEAST).unwrap_or(found)
                }
            }
        }
    }
}

/// Labelled ticks that a logarithmic axis has at least.
const LEAST: usize = 3;

/// Multiples of 1, 2 or 5 times a power of ten.
fn steps(low: f64, high: f64, most: usize) -> Ticks {
    let raw = (high - low) / most.max(2) as f64;
    let magnitude = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * magnitude).find(|s| *s >= raw * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * magnitude);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    // Counted in steps, so that rounding never doubles or loses a tick.
    let count = (last - first).clamp(-1.0, 200.0) as i64;
    let labelled = (0..=count).map(|k| {
        let value = (first + k as f64) * step;
        (value, tick(value, step))
    });
    Ticks { labelled: labelled.collect(), minor: Vec::new() }
}

/// Powers of ten; with 2 and 5 in between where there are few of them.
fn decades(low: f64, high: f64, most: usize) -> Ticks {
    let inside = |v: f64| v >= low * (1.0 - 1e-9) && v <= high * (1.0 + 1e-9);
    let exponents = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let full = exponents.clone().filter(|e| inside(10_f64.powi(*e))).count();
    let labelled =
        |every: i32| exponents.clone().filter(|e| inside(10_f64.powi(*e)) && e.rem_euclid(every) == 0).count();
    let mut per_label = full.div_ceil(most.max(1)).max(1) as i32;
    while per_label > 1 && labelled(per_label) < LEAST {
        per_label -= 1;
    }
    // Where there are few powers of ten, 2 and 5 between them.
    let in_between = full < LEAST || (3 * full <= most && high / low < 1.01e3);
    let plain = low >= 0.9e-3 && high <= 1.1e4;
    let mut ticks = Ticks::default();
    for exponent in exponents {
        for digit in 1..10 {
            let value = f64::from(digit) * 10_f64.powi(exponent);
            if !inside(value) {
                continue;
            }
            let text = match (plain, digit) {
                (true, _) => tick(value, value),
                (false, 1) => format!("10{}", superscript(exponent)),
                (false, _) => format!("{digit}·10{}", superscript(exponent)),
            };
            match digit {
                1 if exponent.rem_euclid(per_label) == 0 => ticks.labelled.push((value, text)),
                2 | 5 if in_between => ticks.labelled.push((value, text)),
                _ if per_label == 1 || digit == 1 => ticks.minor.push(value),
                _ => {}
            }
        }
    }
    ticks
}

/// An exponent in raised figures.
fn superscript(exponent: i32) -> String {
    let raised = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = exponent.unsigned_abs().to_string();
    let figures = digits.bytes().map(|d| raised[usize::from(d - b'0')]);
    if exponent < 0 { std::iter::once('⁻').chain(figures).collect() } else { figures.collect() }
}

/// The text of a tick: as many digits as steps of this size need.
fn tick(value: f64, step: f64) -> String {
    if value.abs() < 1e-6 * step {
        return "0".into();
    }
    if !(1e-4..1e6).contains(&step) {
        let text = format!("{value:.2e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        let exponent = superscript(exponent.parse().unwrap_or(0));
        return if mantissa == "1" { format!("10{exponent}") } else { format!("{mantissa}·10{exponent}") };
    }
    let digits = (1.0 - step.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}
