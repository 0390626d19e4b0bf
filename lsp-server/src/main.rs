//! The `dotgen` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    dotgen_lsp_server::cli::main()
}
