//! Whether documentation, sources and their order say the same.

mod network;
mod pages;
mod reliability;
mod sentences;
mod tour;
