//! Searches and interpolants that know nothing of robots.

pub mod laurent;
pub mod line_search;
pub mod spline;
