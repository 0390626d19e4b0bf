//! VS Code for the browser (code-server), set up from the npm registry, and the programs that drive it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use xtask::extension;
use xtask::run::{self, step};
use xtask::tools;

/// The variable with the folder of an existing workbench, so that several clones can share one.
const CACHE_VARIABLE: &str = "DOTGEN_WORKBENCH";

/// An installed code-server.
pub(crate) struct Workbench {
    /// The path of the Node that runs it.
    pub(crate) node: String,
    /// Its entry script.
    pub(crate) entry: String,
}

/// The folder of the test's scripts.
pub(crate) fn scripts() -> PathBuf {
    xtask::root().join("tests/editors/vscode")
}

impl Workbench {
    /// Sets it up, unless it exists.
    pub(crate) fn set_up() -> Result<Workbench> {
        let directory = match std::env::var_os(CACHE_VARIABLE) {
            Some(directory) => PathBuf::from(directory),
            None => xtask::target().join("tools/workbench"),
        };
        let env = directory.join("env");
        tools::ensure_node()?;
        if !env.exists() {
            tools::ensure(tools::NATIVE_MODULES)?;
            step(
                "Setting up VS Code for the browser from the npm registry (about a minute, 800 MB)",
            );
        }
        let setup = scripts().join("setup.sh");
        let arguments = [&*setup.to_string_lossy(), &*directory.to_string_lossy()];
        run::capture(run::command(xtask::root(), "sh", &arguments))?;
        let text = std::fs::read_to_string(&env)
            .with_context(|| format!("{} was not written", env.display()))?;
        let value = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            Some(line.strip_prefix('=')?.trim_matches('\'').to_owned())
        };
        Ok(Workbench {
            node: value("CS_NODE").context("no CS_NODE in the workbench's env file")?,
            entry: value("CS_ENTRY").context("no CS_ENTRY in the workbench's env file")?,
        })
    }

    /// The command that runs the scenario on `vsix` in a headless browser.
    pub(crate) fn scenario(
        &self,
        vsix: &Path,
        arguments: &[&str],
    ) -> Result<std::process::Command> {
        tools::ensure(tools::CHROMIUM)?;
        extension::install_packages(&scripts())?;
        let mut command = run::command(&scripts(), "node", &["scenario.mjs"]);
        command
            .args(arguments)
            .env("CS_NODE", &self.node)
            .env("CS_ENTRY", &self.entry)
            .env("VSIX", vsix)
            .env("EXAMPLES", xtask::root().join("examples"))
            .env("SHOTS", xtask::target().join("shots"));
        Ok(command)
    }
}
