//! Building the VS Code extension with its server.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock};

use anyhow::{Context, Result};

use crate::run::{self, step};
use crate::tools;

/// The way in which the server is compiled.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// The program of the tests.
    Dev,
    /// What people build themselves, in minutes.
    Release,
    /// What a release publishes: small and fast, but slow to build.
    Dist,
}

/// The sources of the extension.
pub fn directory() -> PathBuf {
    crate::root().join("vscode-extension")
}

/// The path of the notices of licences, relative to the root of the repository; the package has a copy.
pub const NOTICES: &str = "THIRD-PARTY-NOTICES.txt";

/// The features of the program that a release publishes.
pub const FEATURES: &str = "dotgen/zenoh";

/// The features of the tests: the allocator of releases takes two minutes to compile.
pub const TEST_FEATURES: [&str; 3] = ["--no-default-features", "--features", FEATURES];

/// Profiles in which the server is built in this run of xtask, during which no source changes.
static BUILT: [OnceLock<()>; 3] = [const { OnceLock::new() }; 3];

fn built(profile: Profile) -> &'static OnceLock<()> {
    &BUILT[profile as usize]
}

/// Says that the tests are built, and with them the server in [`Profile::Dev`]. A build of the server alone
/// has fewer features of libraries, and would compile zenoh and most of the workspace again.
pub fn is_built_with_tests() {
    let _ = built(Profile::Dev).set(());
}

/// Compiles the server, unless it is built, and returns the path of the program.
pub fn build_server(profile: Profile) -> Result<PathBuf> {
    if built(profile).get().is_some() {
        return Ok(server_program(profile));
    }
    let mut arguments = vec!["build", "--locked", "--package", "dotgen", "--bin", "dotgen"];
    // The extension does not exchange ports with other machines, and its package should be small.
    match profile {
        Profile::Dist => arguments.push("--profile=dist"),
        Profile::Release => arguments.push("--release"),
        Profile::Dev => arguments.extend(TEST_FEATURES),
    }
    step("Building the program (6 minutes at first, on two cores)");
    run::run(run::cargo(&arguments))?;
    let _ = built(profile).set(());
    Ok(server_program(profile))
}

/// The path of the built server.
pub fn server_program(profile: Profile) -> PathBuf {
    let directory = match profile {
        Profile::Dev => "debug",
        Profile::Release => "release",
        Profile::Dist => "dist",
    };
    let name = format!("dotgen{}", std::env::consts::EXE_SUFFIX);
    crate::target().join(directory).join(name)
}

/// Installs the npm packages of `directory`, unless they already agree with its lock file.
pub fn install_packages(directory: &Path) -> Result<()> {
    // Suites install side by side.
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    tools::ensure_node()?;
    let modified =
        |path: &str| directory.join(path).metadata().and_then(|metadata| metadata.modified());
    if let (Ok(installed), Ok(wanted)) =
        (modified("node_modules/.package-lock.json"), modified("package-lock.json"))
        && installed >= wanted
    {
        return Ok(());
    }
    let name = directory.strip_prefix(crate::root()).unwrap_or(directory);
    step(&format!("Installing the npm packages of {}", name.display()));
    run::capture(npm(directory, &["ci", "--no-audit", "--no-fund"])).map(drop)
}

pub fn npm(directory: &Path, arguments: &[&str]) -> std::process::Command {
    let name = if cfg!(windows) { "npm.cmd" } else { "npm" };
    let mut command = run::command(directory, name, arguments);
    command.env("npm_config_loglevel", "error");
    command
}

/// Bundles the extension with `server` inside and packages it for this system.
pub fn package(server: &Path) -> Result<PathBuf> {
    let platform = platform();
    pack(Some(server), &["--target", platform], &format!("dotgen-{platform}.vsix"))
}

/// Packages the extension without a program, for systems that have no package of their own.
pub fn package_universal() -> Result<PathBuf> {
    pack(None, &[], "dotgen-universal.vsix")
}

fn pack(server: Option<&Path>, options: &[&str], name: &str) -> Result<PathBuf> {
    let directory = directory();
    install_packages(&directory)?;
    step(&format!("Packaging the extension: {name}"));
    let inside = directory.join("server");
    if inside.exists() {
        std::fs::remove_dir_all(&inside)?;
    }
    if let Some(server) = server {
        std::fs::create_dir(&inside)?;
        // The copy keeps the permission to execute, and so does the package made on Unix.
        std::fs::copy(server, inside.join(server.file_name().context("a program has a name")?))?;
    }
    for text in ["LICENSE", NOTICES] {
        std::fs::copy(crate::root().join(text), directory.join(text))?;
    }
    copy(&crate::root().join("docs"), &directory.join("docs"), &["md", "svg", "png"])?;
    run::capture(npm(&directory, &["run", "--silent", "bundle"]))?;
    let vsix = crate::target().join(name);
    let out = vsix.to_string_lossy();
    let mut arguments = vec!["run", "--silent", "package", "--", "--out", &out];
    arguments.extend(options);
    run::capture(npm(&directory, &arguments))?;
    Ok(vsix)
}

/// Copies the files of a folder with these endings to another folder, which is replaced.
pub fn copy(from: &Path, to: &Path, endings: &[&str]) -> Result<()> {
    if to.exists() {
        std::fs::remove_dir_all(to)?;
    }
    let mut folders = vec![from.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if let Some(ending) = path.extension()
                && endings.iter().any(|known| ending == *known)
            {
                let copy = to.join(path.strip_prefix(from)?);
                std::fs::create_dir_all(copy.parent().context("it is below a folder")?)?;
                std::fs::copy(&path, &copy)?;
            }
        }
    }
    Ok(())
}

/// VS Code's name for this system.
fn platform() -> &'static str {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "aarch64") => "linux-arm64",
        ("linux", "arm") => "linux-armhf",
        ("macos", "aarch64") => "darwin-arm64",
        ("macos", _) => "darwin-x64",
        ("windows", "aarch64") => "win32-arm64",
        ("windows", _) => "win32-x64",
        _ => "linux-x64",
    }
}
