//! The program `pellucid-mpi`: `pellucid` on many machines.

/// Points come and go in large pieces, of which glibc's allocator gives few back to the system: ranks share its memory.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    pellucid_cli::main_of_ranks()
}
