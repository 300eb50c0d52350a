//! How many random cases a test draws. `GEARWISE_CASES=all` is what docs/reliability.md tells and `.ci/cases` asks for; a
//! number is that many times all (`10` ten times, `0.1` a tenth); by default it is 15 %, so that `cargo test` is
//! quick. How often what occurs is only asserted of all.
#![allow(dead_code, reason = "each test file uses its part")]

use std::ops::Range;

/// Cases to draw, as a share of all.
pub fn share() -> f64 {
    match std::env::var("GEARWISE_CASES") {
        Err(_) => 0.15,
        Ok(all) if all == "all" => 1.0,
        Ok(times) => times.parse().expect("GEARWISE_CASES is `all` or a number"),
    }
}

/// Whether at least all cases are drawn.
pub fn are_all() -> bool {
    share() >= 1.0
}

/// The same of a test that has to see more before it has seen all that it asks for: by default a quarter.
pub fn quarter(first: u64, all: u64) -> Range<u64> {
    match std::env::var("GEARWISE_CASES") {
        Err(_) => first..first + all.div_ceil(4),
        Ok(_) => cases(first, all),
    }
}

/// Numbers of the cases to draw, of `all` from `first` on.
pub fn cases(first: u64, all: u64) -> Range<u64> {
    first..first + (all as f64 * share()).ceil() as u64
}

/// The first few items of a list; all of it if all cases are drawn.
pub fn few<T>(count: usize, all: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    all.into_iter().take(if are_all() { usize::MAX } else { count })
}

/// Numbers of the cases of a test whose cases each take long: 4 % of all by default.
pub fn long_cases(first: u64, all: u64) -> Range<u64> {
    match std::env::var("GEARWISE_CASES") {
        Err(_) => first..first + all.div_ceil(25),
        Ok(_) => cases(first, all),
    }
}
