//! How things are written: numbers, counts, cells, markup, and the name that somebody may have meant.

pub mod csv;
pub mod handy;
pub mod xml;

use std::borrow::Cow;
use std::io;

/// Below this a number is what rounding leaves of zero.
const ROUNDING: f64 = 1e-15;
/// No winding is as hot as this \[°C\], and none is by this hotter than what is around it \[K\]: the model has left its range.
const HOTTEST: f64 = 1000.0;

/// A number with its unit, where it may be a temperature, or a rise of one \[K\], that no winding has: that is thermal runaway.
///
/// ```
/// use gearwise_model::words::heat_or;
/// assert_eq!((heat_or(85.0, "degC").as_str(), heat_or(4e4, "degC").as_str()), ("85 degC", "thermal runaway"));
/// assert_eq!(heat_or(4e4, "A"), "40000 A");
/// ```
pub fn heat_or(value: f64, unit: &str) -> String {
    match unit {
        "degC" | "K" if value >= HOTTEST => "thermal runaway".into(),
        _ => with_unit(value, unit),
    }
}

/// Message that this build lacks a feature, with the command that adds it.
///
/// ```
/// use gearwise_model::words::not_built;
/// let said = "this build was made without PNG; install with `cargo install --path . --features full`";
/// assert_eq!(not_built("PNG"), said);
/// ```
pub fn not_built(feature: &str) -> String {
    format!("this build was made without {feature}; install with `cargo install --path . --features full`")
}

/// A number with four significant digits, without needless zeros.
///
/// ```
/// use gearwise_model::words::number;
/// assert_eq!(number(0.064366), "0.06437");
/// assert_eq!(number(1200.0), "1200");
/// assert_eq!(number(9.01e-6), "9.010e-6");
/// assert_eq!(number(-2.2e-16), "0");
/// ```
///
/// What rounding leaves of a zero is zero: nothing that is measured in SI units is so small.
pub fn number(value: f64) -> String {
    if value.abs() < ROUNDING {
        return "0".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞".into() } else { "−∞".into() };
    }
    if value.is_nan() {
        return "–".into();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let digits = (3 - magnitude).max(0) as usize;
    trimmed(&format!("{value:.digits$}"))
}

/// A number without the zeros that its decimals end with.
fn trimmed(text: &str) -> String {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }.to_string()
}

/// A number in ten digits, rounded downwards and without an exponent: for what a value is nowhere below.
///
/// ```
/// use gearwise_model::words::number_below;
/// assert_eq!(number_below(0.123456789999), "0.1234567899");
/// assert_eq!((number_below(3.31).as_str(), number_below(-1.5).as_str(), number_below(0.0).as_str()), ("3.31", "-1.5", "0"));
/// ```
pub fn number_below(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value);
    }
    let decimals = (9 - value.abs().log10().floor() as i32).clamp(0, 300);
    let step = 10.0_f64.powi(-decimals);
    trimmed(&format!("{:.*}", decimals as usize, (value / step).floor() * step))
}

/// A number between two others, with as few digits as [`number`] or as many more as it takes to stay between them when it is
/// read again.
///
/// ```
/// use gearwise_model::words::number_between;
/// assert_eq!(number_between(9.84376, 3.0, 20.0), "9.844");
/// assert_eq!(number_between(9.84376, 3.0, 9.84376), "9.843");
/// assert_eq!(number_between(9.84376, 9.84376, 20.0), "9.844");
/// assert_eq!(number_between(9.843764, 9.84371, 9.843764), "9.84376");
/// ```
pub fn number_between(value: f64, min: f64, max: f64) -> String {
    let plain = number(value);
    let is_between = |text: &String| text.parse().is_ok_and(|read: f64| min <= read && read <= max);
    if is_between(&plain) || !(min <= value && value <= max) || value <= 0.0 {
        return plain;
    }
    let magnitude = value.log10().floor() as i32;
    let rounded = (4..=17).flat_map(|digits: i32| {
        let decimals = (digits - 1 - magnitude).max(0);
        let step = 10.0_f64.powi(-decimals);
        let near = value / step;
        let decimals = decimals as usize;
        [near.round(), near.floor(), near.ceil()].map(|n| trimmed(&format!("{:.decimals$}", n * step)))
    });
    rounded.into_iter().find(is_between).unwrap_or_else(|| value.to_string())
}

/// The ends of a range, rounded inwards.
pub fn range_inwards(min: f64, max: f64) -> [String; 2] {
    [min, max].map(|end| number_between(end, min, max))
}

/// `number`, or a dash where the value is unknown.
pub fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), number)
}

/// A value with its unit; a pure number has none.
pub fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {}", number(value), if unit == "1" { "" } else { unit }).trim_end().to_string()
}

/// At most 60 characters of a text, for messages.
pub fn shorten(text: &str) -> String {
    cut(text, 60).into_owned()
}

/// At most so many characters of a text; a mark at its end says that there were more.
pub(crate) fn cut(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((at, _)) => Cow::Owned(format!("{}…", &text[..at])),
        None => Cow::Borrowed(text),
    }
}

/// True for a character that changes the direction of the text around it: what a person reads is not what is written.
pub(crate) fn is_bidirectional_control(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// `1 joint`, `2 joints`.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The name in `names` that is most like `text`, if any is near enough to be what was meant.
///
/// ```
/// assert_eq!(gearwise_model::words::nearest("reisstance", ["resistance", "mass"]), Some("resistance"));
/// assert_eq!(gearwise_model::words::nearest("colour", ["resistance", "mass"]), None);
/// ```
pub fn nearest<'a>(text: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |s: &str| s.to_lowercase().replace(['-', ' ', '*', '^', '·'], "_").replace('_', "");
    if text.len() > 100 {
        return None;
    }
    let wanted = plain(text);
    let mut best: Option<(f64, &str)> = None;
    // The table of edits of a long name would take more memory than the file that it is of.
    for name in names.into_iter().filter(|name| name.len() <= 300) {
        let score = strsim::jaro_winkler(&wanted, &plain(name));
        let edits = strsim::damerau_levenshtein(&wanted, &plain(name));
        let near = edits <= 1 || (edits <= wanted.len().max(name.len()) / 3) || score > 0.9;
        if near && best.is_none_or(|(b, _)| score > b) {
            best = Some((score, name));
        }
    }
    best.map(|(_, name)| name)
}

/// Why a file cannot be read or written, in words without the numbers of the system.
pub fn reason(error: &io::Error) -> String {
    use io::ErrorKind as Kind;
    let words = match error.kind() {
        Kind::NotFound => "there is no such file",
        Kind::AlreadyExists => "there is a file of this name",
        Kind::PermissionDenied => "permission denied",
        Kind::StorageFull => "the disk is full",
        Kind::QuotaExceeded => "the quota is used up",
        Kind::FileTooLarge => "the system does not allow files of this size",
        Kind::ReadOnlyFilesystem => "the file system is read-only",
        Kind::NotADirectory => "a part of the path is not a folder",
        Kind::InvalidFilename => "the name is too long",
        _ if is_loop(error) => "its symbolic links lead in a circle",
        _ => return error.to_string(),
    };
    words.into()
}

// `ErrorKind::FilesystemLoop` is not stable.
fn is_loop(error: &io::Error) -> bool {
    format!("{:?}", error.kind()) == "FilesystemLoop"
}
