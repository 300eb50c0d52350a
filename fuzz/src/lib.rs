//! What the fuzzer runs: each target is one function of bytes that panics where the program breaks a promise.
//!
//! The functions stand in [`bodies`], which `tests/faults/fuzz_corpus.rs` includes as well, so that every input that is
//! kept here is also a test of the ordinary test run.

pub mod bodies;
#[path = "../../tests/raw/mod.rs"]
pub mod raw;
