//! Tests of what the default build leaves out, with `cargo test --features full --test full`: Parquet, PNG, the schema of JSON, manual pages and
//! completions.

#[path = "../common/mod.rs"]
mod common;
#[path = "../shell/mod.rs"]
mod shell;

mod log_formats;
mod packaging;
mod pictures;
mod schema;
mod study;
