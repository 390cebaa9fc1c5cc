//! The program of the laboratory: see `cargo run --release -p relcp-lab -- --help`.

mod program;

fn main() -> std::process::ExitCode {
    program::main()
}
