//! What ends a window of ratios.

/// What ends a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Bind {
    /// Name of the limit; `ratio_min` and `ratio_max` are the requirement's own.
    pub limit: &'static str,
    /// The sample at which it binds.
    pub sample: Option<usize>,
    /// Why what lies beyond cannot be judged by this limit; `None` where what lies beyond exceeds it.
    pub unjudged: Option<&'static str>,
}

impl Bind {
    /// A limit that is exceeded beyond, at a sample.
    pub fn of(limit: &'static str, sample: Option<usize>) -> Bind {
        Bind { limit, sample, unjudged: None }
    }
}
