//! The command line: what it takes, prints, writes and refuses.

mod answer;
mod basics;
mod budgets;
mod catalog_cli;
mod catalogs;
mod characterize_cli;
mod check;
mod check_input;
mod colour;
mod export;
mod folder;
mod help;
mod honest;
mod html;
mod identify_cli;
mod import_mgdb;
mod json;
mod kinds;
mod mistakes;
mod plain;
mod plots;
mod set;
mod stdin;
mod study;
mod tables;
mod words;
