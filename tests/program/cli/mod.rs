//! The command line: what it takes, prints, writes and refuses.

mod basics;
mod catalogs;
mod characterize_cli;
mod check;
mod export;
mod help;
mod html;
mod identify_cli;
mod import_mgdb;
mod json;
mod mistakes;
mod plots;
mod study;
mod tables;
mod words;
