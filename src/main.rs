//! The program: see `relcp --help`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
