//! The program `pellucid`.

fn main() -> std::process::ExitCode {
    pellucid_cli::main()
}
