//! Tests that start `gearwise`, in folders by what they ask: the command line and its files (`cli`), the documentation and the order of the
//! sources (`docs`), and what `tests/library` asks of the library, here of the whole program (`proof`, `measured`, `robot`).

#[path = "../cases/mod.rs"]
mod cases;
#[path = "../common/mod.rs"]
mod common;
#[path = "../shell/mod.rs"]
mod shell;
#[path = "../simulator/mod.rs"]
mod simulator;

mod cli;
mod docs;
mod measured;
mod proof;
mod robot;
