//! Whether a measurement becomes the right figures, effects and verdicts.

mod bench_files;
mod characterize;
mod forward;
mod held_commands;
mod identification;
mod identification_numbers;
mod negative_controls;
mod other_logs;
mod planned;
mod remade_parts;
mod robot;
mod scoring;
mod simulator_selftest;
mod simulator_unfriendly;
