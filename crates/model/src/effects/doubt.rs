//! Why a value is not believed.

use std::fmt;

/// Why a value of an effect is not physically plausible.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// It is zero, negative or no number.
    NotPositive {
        /// What it is.
        what: &'static str,
        /// SI.
        value: f64,
    },
    /// It is larger than something lets one believe.
    TooLarge {
        /// What it is.
        what: &'static str,
        /// SI.
        value: f64,
        /// The largest that is believed, SI.
        largest: f64,
        /// What that comes from.
        of: &'static str,
    },
    /// Nature does not do that: why, in words.
    Unnatural(String),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::NotPositive { what, value } => {
                write!(f, "{what} would be {value:.3e} (SI), but it cannot be negative or zero")
            }
            Doubt::TooLarge { what, value, largest, of } => {
                write!(f, "{what} would be {value:.3e} (SI), more than {of} ({largest:.3e}) lets one believe")
            }
            Doubt::Unnatural(why) => f.write_str(why),
        }
    }
}

/// Plausible if positive and at most `largest`.
///
/// # Errors
/// Which of the two it is not.
pub fn positive(what: &'static str, value: f64, largest: f64, of: &'static str) -> Result<(), Doubt> {
    if value.is_nan() || value <= 0.0 {
        return Err(Doubt::NotPositive { what, value });
    }
    if value > largest {
        return Err(Doubt::TooLarge { what, value, largest, of });
    }
    Ok(())
}
