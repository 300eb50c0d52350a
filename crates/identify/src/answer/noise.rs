//! What the ways to find the instrument's noise say.

/// How far apart two estimates may be.
const APART: f64 = 2.0;

/// A way to find the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// What differs between times at which the motion repeats.
    Repeats,
    /// What a standing machine's target does in the band.
    Standstill,
    /// The spectrum from the end of the band to three times that, taken into the band.
    AboveTheBand,
    /// Second differences from sample to sample, taken into the band.
    SecondDifferences,
}

impl Method {
    /// Its name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Method::Repeats => "repeats",
            Method::Standstill => "standstill",
            Method::AboveTheBand => "above_the_band",
            Method::SecondDifferences => "second_differences",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Method::Repeats => "repeated motion",
            Method::Standstill => "standstill",
            Method::AboveTheBand => "spectrum above the band",
            Method::SecondDifferences => "second differences",
        }
    }
}

/// What one way says: noise in the band \[unit of the target\], or why it says nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The way.
    pub method: Method,
    /// Root mean square in the band, or why not.
    pub value: Result<f64, &'static str>,
}

/// The instrument's own noise.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// All ways.
    pub estimates: Vec<Estimate>,
    /// Frequency of a line that stands out above the band \[Hz\].
    pub line: Option<f64>,
}

impl Noise {
    /// The smallest of two or more estimates that agree; `None` where the noise cannot be told.
    pub fn floor(&self) -> Option<f64> {
        self.told().ok()
    }

    /// The noise, or why it cannot be told.
    ///
    /// # Errors
    /// In words.
    pub fn told(&self) -> Result<f64, &'static str> {
        let values: Vec<f64> = self.estimates.iter().filter_map(|e| e.value.ok()).collect();
        let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
        match values.len() {
            0 => Err("nothing in these logs shows it"),
            1 => Err("only one way to find it holds here"),
            _ if high > APART * low => Err("the ways to find it are more than a factor of two apart"),
            _ => Ok(low),
        }
    }
}
