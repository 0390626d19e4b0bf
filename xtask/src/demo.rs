//! `cargo xtask demo`: the example workspace in VS Code, with the extension and server of this tree.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use clap::Args;

use crate::workbench::Workbench;
use xtask::extension::{self, Profile};
use xtask::run::{self, step};
use xtask::tools;

/// Options of `cargo xtask demo`.
#[derive(Args)]
pub(crate) struct Options {
    /// Only prove that it works: headlessly, a typed error gets its squiggle and loses it when corrected.
    #[arg(long)]
    check: bool,
    /// Serve to the browser even if `code` is installed.
    #[arg(long)]
    browser: bool,
    /// Port of the browser's VS Code, on 127.0.0.1 [default: any free one].
    #[arg(long)]
    port: Option<u16>,
}

/// Runs the demo; false if the check failed.
pub(crate) fn demo(options: &Options) -> Result<bool> {
    tools::ensure_node()?;
    let server = extension::build_server(Profile::Release)?;
    let vsix = extension::package(&server)?;
    if options.check {
        let workbench = Workbench::set_up()?;
        step("Opening the example in a headless VS Code");
        return run::watch(workbench.scenario(&vsix, &["--demo"])?, |_| ());
    }
    match tools::find("code").filter(|_| !options.browser) {
        Some(code) => open_in_code(&code, &vsix)?,
        None => serve(&vsix, options.port)?,
    }
    Ok(true)
}

/// The profile of the demo, separate from the user's own settings and extensions, which are unchanged.
fn profile(name: &str) -> Result<(PathBuf, PathBuf)> {
    let directory = xtask::target().join("demo").join(name);
    let (user, extensions) = (directory.join("user"), directory.join("extensions"));
    for directory in [&user, &extensions] {
        std::fs::create_dir_all(directory)
            .with_context(|| format!("cannot create {}", directory.display()))?;
    }
    let settings = user.join("User/settings.json");
    if !settings.exists() {
        std::fs::create_dir_all(user.join("User"))?;
        std::fs::write(
            &settings,
            "{\n  \"security.workspace.trust.enabled\": false,\n  \"workbench.startupEditor\": \"none\",\n  \"telemetry.telemetryLevel\": \"off\"\n}\n",
        )?;
    }
    Ok((user, extensions))
}

fn open_in_code(code: &Path, vsix: &Path) -> Result<()> {
    let (user, extensions) = profile("code")?;
    let code = |arguments: &[&str]| {
        let mut command = run::command(xtask::root(), &code.to_string_lossy(), arguments);
        command.arg("--user-data-dir").arg(&user);
        command.arg("--extensions-dir").arg(&extensions);
        command
    };
    step("Opening examples/maneuver in VS Code");
    run::capture(code(&["--install-extension", &vsix.to_string_lossy(), "--force"]))?;
    let file = xtask::example().join("maneuver.gen");
    let (workspace, file) = (xtask::example(), file.to_string_lossy().into_owned());
    run::capture(code(&["--new-window", &workspace.to_string_lossy(), &file]))?;
    println!("VS Code is open on {}.", workspace.display());
    Ok(())
}

fn serve(vsix: &Path, port: Option<u16>) -> Result<()> {
    let workbench = Workbench::set_up()?;
    let (user, extensions) = profile("browser")?;
    let config = user.join("config.yaml");
    std::fs::write(&config, "auth: none\n")?;
    let code_server = || {
        let mut command = Command::new(&workbench.node);
        command.arg(&workbench.entry);
        command.arg("--config").arg(&config);
        command.arg("--user-data-dir").arg(&user);
        command.arg("--extensions-dir").arg(&extensions);
        command.stdin(std::process::Stdio::null());
        command
    };
    let mut install = code_server();
    install.arg("--install-extension").arg(vsix).arg("--force");
    run::capture(install)?;
    let port = match port {
        Some(port) => port,
        None => TcpListener::bind("127.0.0.1:0")?.local_addr()?.port(),
    };
    // Only this machine is served, because there is no password.
    let mut command = code_server();
    command.args(["--auth", "none", "--disable-telemetry", "--disable-update-check"]);
    command.args(["--disable-workspace-trust", "--disable-getting-started-override"]);
    command.arg("--bind-addr").arg(format!("127.0.0.1:{port}"));
    command.stdout(std::process::Stdio::null());
    let mut child = command.spawn().context("cannot start the workbench")?;
    println!();
    println!("  Open  http://127.0.0.1:{port}/?folder={}", xtask::example().display());
    println!("  Then open maneuver.gen and type. Ctrl-C ends the demo.");
    println!();
    child.wait()?;
    Ok(())
}
