//! Tests that call the library, in folders by what they ask: is the answer the best there is (`proof`), are the equations those of the
//! literature (`model`), does a measurement become the right figures (`measured`), do joints of one robot go together (`robot`).
//!
//! One program, so that it is linked once; what starts `gearwise` itself is in `tests/program`.

#[path = "../cases/mod.rs"]
mod cases;
#[path = "../common/mod.rs"]
mod common;
#[path = "../motor_bench/mod.rs"]
mod motor_bench;
#[path = "../raw/mod.rs"]
mod raw;
#[path = "../simulator/mod.rs"]
mod simulator;
#[path = "../raw/solved.rs"]
mod solved;

mod measured;
mod model;
mod proof;
mod robot;
