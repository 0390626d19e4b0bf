//! The `dotgen` program.

use std::process::ExitCode;

/// Faster where many threads work on many small things, and it gives back what is not used.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    dotgen_lsp_server::cli::main()
}
