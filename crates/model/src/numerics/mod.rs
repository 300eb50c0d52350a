//! Searches, fits and interpolants that know nothing of robots.

pub(crate) mod cubic;
pub mod grid;
pub mod laurent;
pub mod least_squares;
pub mod line_search;
pub mod roots;
pub mod spline;
pub mod sums;
pub mod work;
