//! `cargo xtask bench`, `budgets`, `campaign`: commands of the workspace in `bench/`.

use anyhow::Result;
use clap::Args;

use xtask::run;

/// The arguments of a measurement, which its own program reads.
#[derive(Args)]
pub(crate) struct Rest {
    /// Options: `--help` lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Builds the program of the measurements if need be, and runs its command. False if it failed.
pub(crate) fn forward(command: &str, rest: &Rest) -> Result<bool> {
    let manifest = xtask::root().join("bench/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let arguments = ["run", "--quiet", "--locked", "--manifest-path", &manifest, "--", command];
    let mut cargo = run::cargo(&arguments);
    cargo.args(&rest.arguments).env("CARGO_TARGET_DIR", xtask::target());
    Ok(cargo.status()?.success())
}
