//! The program: see `relcp --help`.

fn main() -> std::process::ExitCode {
    relcp::cli::main()
}
