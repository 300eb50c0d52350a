//! The `gearwise` program.

fn main() -> std::process::ExitCode {
    gearwise::cli::run()
}
