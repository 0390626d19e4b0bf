//! The log, on standard error; standard output belongs to the protocol. `DOTGEN_LOG` filters the log, in the
//! syntax of `RUST_LOG` (`DOTGEN_LOG=debug`, `DOTGEN_LOG=dotgen_lsp_server=trace`).

use tracing_subscriber::EnvFilter;

/// Starts logging. `default` is the filter without `DOTGEN_LOG`: an editor keeps a log, and a terminal shows
/// it.
pub(crate) fn install(default: &str) {
    let filter = EnvFilter::try_from_env("DOTGEN_LOG").unwrap_or_else(|_| EnvFilter::new(default));
    // A second call, as in tests, keeps the first log.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::IsTerminal::is_terminal(&std::io::stderr()))
        .try_init();
}
