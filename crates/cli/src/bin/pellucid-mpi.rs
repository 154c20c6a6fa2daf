//! The program `pellucid-mpi`: `pellucid` on many machines.

fn main() -> std::process::ExitCode {
    pellucid_cli::main_of_ranks()
}
