//! `cargo xtask dist`: every package of a release, for Linux on this architecture.
//!
//! | file | made by | for |
//! | --- | --- | --- |
//! | `dotgen-TARGET.tar.gz` | `packaging/archive.sh` | any Linux |
//! | `dotgen_VERSION_ARCH.deb` | cargo-deb | Debian and Ubuntu |
//! | `dotgen-VERSION-*.whl` | maturin, wheel | `pip install` |
//! | `dotgen-linux-ARCH.vsix` | vsce | VS Code, with the program |
//! | `dotgen-universal.vsix` | vsce | VS Code on other systems, without the program |
//! | `dotgen.cdx.json` | cargo-cyclonedx | the bill of materials (CycloneDX) |
//! | `SHA256SUMS` | `sha256sum` | checksums |
//!
//! The program is linked by Zig against the C library of [`GLIBC`], so that it runs on older systems than
//! this.

mod check;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;

use xtask::extension::{self, FEATURES};
use xtask::run::{self, step};
use xtask::tools;

/// The oldest version of the C library that the programs run with: that of Debian 10 and Red Hat 8.
const GLIBC: &str = "2.28";

/// Tools from PyPI, with their versions.
const PIP_TOOLS: [&str; 4] =
    ["ziglang==0.15.1", "cargo-zigbuild==0.24.1", "maturin==1.16.0", "wheel==0.45.1"];
/// Tools from crates.io, with their versions.
const CARGO_TOOLS: [(&str, &str); 2] = [("cargo-deb", "3.8.0"), ("cargo-cyclonedx", "0.5.9")];

#[derive(Args)]
pub(crate) struct Options {
    /// Install and use each package in a clean root as well (as root, on Debian)
    #[arg(long)]
    check: bool,
    /// Use the packages that an earlier run made
    #[arg(long)]
    no_build: bool,
}

/// The folder of the packages.
fn folder() -> PathBuf {
    xtask::target().join("packages")
}

/// Rust's name of the system that is built for.
fn target() -> String {
    format!("{}-unknown-linux-gnu", std::env::consts::ARCH)
}

pub(crate) fn dist(options: &Options) -> Result<()> {
    if std::env::consts::OS != "linux" {
        bail!(
            "packages are made on Linux; on other systems, `cargo xtask package` makes the extension"
        );
    }
    if !options.no_build {
        make()?;
    }
    if options.check {
        check::check(&folder())?;
    }
    Ok(())
}

fn make() -> Result<()> {
    let out = folder();
    if out.exists() {
        std::fs::remove_dir_all(&out)?;
    }
    std::fs::create_dir_all(&out)?;
    let tools = Tools::install()?;
    let program = tools.program(true)?;
    archive(&program, &out)?;
    tools.debian(&program, &out)?;
    tools.wheel(&program, &out)?;
    bill_of_materials(&tools, &out)?;
    let program = tools.program(false)?;
    for vsix in [extension::package(&program)?, extension::package_universal()?] {
        std::fs::copy(&vsix, out.join(vsix.file_name().context("a file")?))?;
    }
    checksums(&out)
}

/// The tools that make packages, in a folder of their own.
struct Tools {
    directory: PathBuf,
}

impl Tools {
    /// Installs the tools; those that are there in the right version stay.
    fn install() -> Result<Tools> {
        tools::ensure(tools::PYTHON)?;
        let directory = xtask::target().join("tools/dist");
        let tools = Tools { directory };
        let stamp = tools.directory.join("installed");
        let wanted = format!("{PIP_TOOLS:?} {CARGO_TOOLS:?}");
        if std::fs::read_to_string(&stamp).is_ok_and(|text| text == wanted) {
            return Ok(tools);
        }
        step("Installing the tools that make packages");
        let place = tools.directory.to_string_lossy().into_owned();
        let root = xtask::root();
        run::capture(run::command(root, "python3", &["-m", "venv", "--clear", &place]))?;
        let mut pip = vec!["install", "--quiet", "--disable-pip-version-check"];
        pip.extend(PIP_TOOLS);
        let program = tools.directory.join("bin/pip");
        run::capture(run::command(root, &program.to_string_lossy(), &pip))?;
        for (name, version) in CARGO_TOOLS {
            let arguments = ["install", "--locked", "--root", &place, "--version", version, name];
            run::capture(run::cargo(&arguments))?;
        }
        std::fs::write(stamp, wanted)?;
        Ok(tools)
    }

    /// Adds the tools to the programs that `command` finds.
    fn in_path(&self, mut command: Command) -> Command {
        let old = std::env::var_os("PATH").unwrap_or_default();
        let own = std::iter::once(self.directory.join("bin"));
        let path = std::env::join_paths(own.chain(std::env::split_paths(&old)));
        command.env("PATH", path.unwrap_or(old));
        command
    }

    /// Builds the program, with or without the exchange of ports between machines.
    fn program(&self, with_zenoh: bool) -> Result<PathBuf> {
        let target = target();
        let versioned = format!("{target}.{GLIBC}");
        let mut arguments = vec!["zigbuild", "--locked", "--profile=dist", "--target", &versioned];
        arguments.extend(["--package", "dotgen", "--bin", "dotgen"]);
        if with_zenoh {
            arguments.extend(["--features", FEATURES]);
        }
        step("Building the program (a first build takes ten minutes or more)");
        run::run(self.in_path(run::cargo(&arguments)))?;
        Ok(xtask::target().join(target).join("dist/dotgen"))
    }

    /// The package for Debian. Its contents are listed in cli/Cargo.toml.
    fn debian(&self, program: &Path, out: &Path) -> Result<()> {
        step("Packaging for Debian");
        // cli/Cargo.toml names this folder.
        let stage = xtask::root().join("target/deb");
        if stage.exists() {
            std::fs::remove_dir_all(&stage)?;
        }
        std::fs::create_dir_all(stage.join("man"))?;
        std::fs::copy(program, stage.join("dotgen"))?;
        let pages = stage.join("man").to_string_lossy().into_owned();
        let program = program.to_string_lossy();
        run::capture(run::command(xtask::root(), &program, &["man", &pages]))?;
        for shell in ["bash", "zsh", "fish"] {
            let text =
                run::capture(run::command(xtask::root(), &program, &["completions", shell]))?;
            std::fs::write(stage.join(format!("dotgen.{shell}")), text)?;
        }
        let out = out.to_string_lossy();
        let arguments = ["deb", "--no-build", "--no-strip", "-p", "dotgen", "--output", &out];
        run::capture(self.in_path(run::cargo(&arguments))).map(drop)
    }

    /// The wheel: the program, and the Python client as the module `dotgen`. maturin writes its metadata; a
    /// build by maturin would build the program a second time.
    fn wheel(&self, program: &Path, out: &Path) -> Result<()> {
        step("Packaging for pip");
        let stage = xtask::target().join("wheel");
        if stage.exists() {
            std::fs::remove_dir_all(&stage)?;
        }
        std::fs::create_dir_all(&stage)?;
        let project = xtask::root().join("packaging/pypi");
        let place = stage.to_string_lossy();
        let in_project = |program: &str, arguments: &[&str]| {
            run::capture(self.in_path(run::command(&project, program, arguments)))
        };
        let metadata = ["pep517", "write-dist-info", "--metadata-directory", &place];
        let client = xtask::root().join("clients/python/dotgen");
        extension::copy(&client, &stage.join("dotgen"), &["py", "typed"])?;
        // pyproject.toml names this folder for builds by maturin alone.
        let python = project.join("python");
        extension::copy(&client, &python.join("dotgen"), &["py", "typed"])?;
        let written = in_project("maturin", &metadata)?;
        std::fs::remove_dir_all(python)?;
        let name = written.trim().lines().last().unwrap_or_default();
        let name = name.strip_suffix(".dist-info").context("metadata of the wheel")?;
        let licences = stage.join(format!("{name}.dist-info/licenses"));
        std::fs::create_dir_all(&licences)?;
        for text in ["LICENSE", extension::NOTICES] {
            std::fs::copy(xtask::root().join(text), licences.join(text))?;
        }
        let scripts = stage.join(format!("{name}.data/scripts"));
        std::fs::create_dir_all(&scripts)?;
        std::fs::copy(program, scripts.join("dotgen"))?;
        let out = out.to_string_lossy();
        in_project("wheel", &["pack", &place, "--dest-dir", &out])?;
        // The name that `pack` gives is that of the system on which the wheel was made.
        let packed = std::fs::read_dir(&*out)?.flatten().map(|entry| entry.path());
        let packed: Vec<PathBuf> = packed
            .filter(|path| path.extension().is_some_and(|extension| extension == "whl"))
            .collect();
        let [packed] = &packed[..] else {
            bail!("not one wheel in {out}");
        };
        let architecture = std::env::consts::ARCH;
        let platform = format!("manylinux_{}_{architecture}", GLIBC.replace('.', "_"));
        let tags = ["tags", "--remove", "--platform-tag", &platform, &packed.to_string_lossy()];
        in_project("wheel", &tags).map(drop)
    }
}

/// The archive for any Linux.
fn archive(program: &Path, out: &Path) -> Result<()> {
    step("Packing the archive");
    let script = xtask::root().join("packaging/archive.sh");
    let (program, out) = (program.to_string_lossy(), out.to_string_lossy());
    let arguments = [&*program, &*target(), &*out];
    run::capture(run::command(xtask::root(), &script.to_string_lossy(), &arguments)).map(drop)
}

/// What the program is made of.
fn bill_of_materials(tools: &Tools, out: &Path) -> Result<()> {
    step("Listing what the program is made of");
    let arguments = [
        "cyclonedx",
        "--format",
        "json",
        "--manifest-path",
        "cli/Cargo.toml",
        "--features",
        "zenoh",
        "--target",
        &target(),
        "--override-filename",
        "dotgen.cdx",
    ];
    run::capture(tools.in_path(run::cargo(&arguments)))?;
    // The tool writes a file next to each manifest of the workspace.
    for folder in
        std::fs::read_dir(xtask::root())?.chain(std::fs::read_dir(xtask::root().join("tests"))?)
    {
        let file = folder?.path().join("dotgen.cdx.json");
        if file.is_file() {
            if file.starts_with(xtask::root().join("cli")) {
                std::fs::copy(&file, out.join("dotgen.cdx.json"))?;
            }
            std::fs::remove_file(file)?;
        }
    }
    Ok(())
}

fn checksums(out: &Path) -> Result<()> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(out)? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    let arguments: Vec<&str> = names.iter().map(String::as_str).collect();
    let sums = run::capture(run::command(out, "sha256sum", &arguments))?;
    std::fs::write(out.join("SHA256SUMS"), &sums)?;
    for name in names {
        let bytes = out.join(&name).metadata()?.len();
        println!("{:>8.1} MB  {name}", bytes as f64 / 1e6);
    }
    println!("in {}", out.display());
    Ok(())
}
