//! Whether documentation, sources and their order say the same.

mod floors;
mod network;
mod pages;
mod reliability;
mod sentences;
mod tour;
