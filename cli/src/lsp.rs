//! `dotgen lsp`

use clap::Args;

use super::{CommandExit, logging};
use dotgen_lsp_server::session::server;
use dotgen_platform::process::{folders, memory};

/// Start the language server on standard input and output
///
/// The log goes to standard error; DOTGEN_LOG filters it (error, warn, info, debug, trace).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Accepted because many editors pass it; standard input and output are always used
    #[arg(long, hide = true)]
    stdio: bool,
}

pub(super) fn run() -> anyhow::Result<CommandExit> {
    let log = logging::install("warn,dotgen_lsp_server=info");
    memory::return_when_idle();
    // Removes files of sessions that ended without cleanup. The server does not wait for this.
    let cleaner = std::thread::Builder::new().name("cleaner".to_owned());
    if let Err(error) = cleaner.spawn(folders::clean_up) {
        tracing::warn!("temporary folders are not cleaned up: {error}");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .thread_name("dotgen")
        // Recursion in analysis follows the nesting of the text, whose limit is high.
        .thread_stack_size(16 << 20)
        .enable_all()
        .build()?;
    let shut_down = runtime.block_on(server::serve(tokio::io::stdin(), tokio::io::stdout()));
    // A pending read of standard input, or an abandoned request, must not delay the end of the process.
    runtime.shutdown_background();
    log.wait();
    // "exit with 0 if the shutdown request has been received before, otherwise with 1" (LSP 3.17).
    std::process::exit(i32::from(!shut_down));
}
