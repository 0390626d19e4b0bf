//! Programs that must be installed. Missing ones are installed with apt if possible (root on Debian), and
//! otherwise named in one line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use crate::run;

/// A program and its Debian package.
pub struct Tool {
    program: &'static str,
    package: &'static str,
}

pub const CHROMIUM: &[Tool] = &[
    Tool::new("chromium", "chromium"),
    // Without any font the workbench draws no text.
    Tool::new("/usr/share/fonts/truetype/dejavu/DejaVuSansMono.ttf", "fonts-dejavu-core"),
];
/// The language of GenoM3's templates.
pub const TCL: &[Tool] = &[Tool::new("tclsh", "tcl")];
pub const VALGRIND: &[Tool] = &[Tool::new("valgrind", "valgrind")];
/// Reports the peak memory of a process.
pub const TIME: &[Tool] = &[Tool::new("/usr/bin/time", "time")];
pub const NEOVIM: &[Tool] = &[Tool::new("nvim", "neovim")];
pub const EMACS: &[Tool] =
    &[Tool::new("emacs", "emacs-nox"), Tool::new("/usr/share/doc/elpa-eglot", "elpa-eglot")];
/// Attached to components to inspect codels; tests are skipped without it, with a message.
pub const DEBUGGER: &[Tool] = &[Tool::new("gdb", "gdb")];
pub const PYTHON: &[Tool] =
    &[Tool::new("python3", "python3"), Tool::new("/usr/share/doc/python3-venv", "python3-venv")];
/// Sets up a clean Debian; `objdump` lists the symbols of a program.
pub const DEBOOTSTRAP: &[Tool] =
    &[Tool::new("/usr/sbin/debootstrap", "debootstrap"), Tool::new("objdump", "binutils")];
/// For the native modules of the workbench.
pub const NATIVE_MODULES: &[Tool] =
    &[Tool::new("python3", "python3"), Tool::new("make", "make"), Tool::new("g++", "g++")];
/// Node is not installed automatically: Debian's is too old.
const NODE: &str = "Node.js 20 or later with npm";

impl Tool {
    const fn new(program: &'static str, package: &'static str) -> Tool {
        Tool { program, package }
    }

    /// A program on `PATH`, or an absolute path.
    fn is_installed(&self) -> bool {
        if self.program.starts_with('/') {
            Path::new(self.program).exists()
        } else {
            find(self.program).is_some()
        }
    }
}

/// A program on `PATH`.
pub fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|directory| directory.join(program))
        .find(|path| path.is_file())
}

/// Ensures that `tools` are installed.
///
/// # Errors
/// One line that names the packages to install, if they cannot be installed automatically.
pub fn ensure(tools: &[Tool]) -> Result<()> {
    let missing = missing(tools);
    if missing.is_empty() {
        return Ok(());
    }
    let packages: Vec<&str> = missing.into_iter().collect();
    if is_root() && find("apt-get").is_some() {
        run::step(&format!("Installing {}", packages.join(", ")));
        // A missing package is usually caused by an outdated list, which is refreshed once.
        let mut arguments = vec!["install", "-y", "-qq", "--no-install-recommends"];
        arguments.extend(&packages);
        if run::capture(apt(&arguments)).is_err() {
            run::capture(apt(&["update", "-qq"]))?;
            run::capture(apt(&arguments))?;
        }
        let missing = self::missing(tools);
        if !missing.is_empty() {
            bail!("still missing after its installation: {missing:?}");
        }
        return Ok(());
    }
    bail!("missing: sudo apt-get install {}", packages.join(" "));
}

/// Ensures that Node and npm are installed.
///
/// # Errors
/// One line that names what to install.
pub fn ensure_node() -> Result<()> {
    let version = run::command(crate::root(), "node", &["--version"]).output();
    let major = version.ok().and_then(|output| {
        let text = String::from_utf8(output.stdout).ok()?;
        text.trim().strip_prefix('v')?.split('.').next()?.parse::<u32>().ok()
    });
    match major {
        Some(20..) if find("npm").is_some() => Ok(()),
        Some(major) if major < 20 => bail!("Node.js {major} is too old: install {NODE}"),
        _ => bail!("missing: install {NODE}"),
    }
}

fn missing(tools: &[Tool]) -> BTreeSet<&'static str> {
    let missing = tools.iter().filter(|tool| !tool.is_installed());
    missing.map(|tool| tool.package).collect()
}

fn apt(arguments: &[&str]) -> std::process::Command {
    let mut command = run::command(Path::new("/"), "apt-get", arguments);
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn is_root() -> bool {
    let id = run::command(Path::new("/"), "id", &["-u"]).output();
    id.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
