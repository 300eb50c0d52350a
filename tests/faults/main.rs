//! What goes wrong around the program, and inputs that once broke it. A program of its own: it waits for others to be killed, and `fuzz/`,
//! whose inputs and targets it reads, is no part of the package.

#[path = "../../fuzz/src/bodies/mod.rs"]
mod bodies;
#[path = "../cases/mod.rs"]
mod cases;
#[path = "../raw/mod.rs"]
mod raw;

mod fuzz_corpus;
#[cfg(unix)]
mod program;
