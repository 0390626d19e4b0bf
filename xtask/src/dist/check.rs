//! `cargo xtask dist --check`: installs and uses each package in a clean root of an old Debian.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::GLIBC;
use xtask::run::{self, step};
use xtask::tools::{self, DEBOOTSTRAP};

/// The oldest release of Debian that its servers still offer.
const RELEASE: &str = "bullseye";

/// Largest extension, in bytes.
const LARGEST_EXTENSION: u64 = 18_000_000;

/// Checks the packages of a folder.
pub(super) fn check(packages: &Path) -> Result<()> {
    let root = Root::new()?;
    old_symbols_only(packages)?;
    root.try_archive(packages)?;
    root.try_debian(packages)?;
    root.try_wheel(packages)?;
    extensions(packages)?;
    root.try_extension(packages)?;
    println!("All packages are installed and used.");
    Ok(())
}

/// The one file of a folder with this ending.
fn only(packages: &Path, ending: &str) -> Result<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(packages)? {
        let path = entry?.path();
        if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    match found.pop() {
        Some(path) if found.is_empty() => Ok(path),
        _ => bail!("not exactly one `*{ending}` in {}: run `cargo xtask dist`", packages.display()),
    }
}

/// The program needs no symbol of a later C library.
fn old_symbols_only(packages: &Path) -> Result<()> {
    step("Versions of the symbols");
    let stage = xtask::target().join("tools/dist/symbols");
    std::fs::create_dir_all(&stage)?;
    let archive = only(packages, ".tar.gz")?;
    let arguments = ["-xzf", &*archive.to_string_lossy(), "--strip-components=1"];
    run::capture(run::command(&stage, "tar", &arguments))?;
    let symbols = run::capture(run::command(&stage, "objdump", &["-T", "dotgen"]))?;
    let newest = symbols.split("GLIBC_").skip(1).filter_map(version).max();
    let newest = newest.context("the program needs no symbol of the C library")?;
    let allowed = version(GLIBC).context("a version")?;
    if newest > allowed {
        bail!("the program needs the C library {newest:?}, and {allowed:?} is promised");
    }
    Ok(())
}

/// The version at the start of a text: `2.28) …`.
fn version(text: &str) -> Option<(u32, u32)> {
    let end = text.find(|c: char| c != '.' && !c.is_ascii_digit()).unwrap_or(text.len());
    let mut numbers = text[..end].split('.').map(|part| part.parse().ok());
    Some((numbers.next()??, numbers.next()??))
}

/// A clean Debian.
struct Root {
    directory: PathBuf,
}

/// An example that has no error, and a session of an editor with it.
const EXAMPLE: &str = "examples/pump";
const SESSION: &str = r#"
import json, subprocess, sys
server = subprocess.Popen([sys.argv[1], "lsp"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
def send(message):
    text = json.dumps({"jsonrpc": "2.0", **message}).encode()
    server.stdin.write(b"Content-Length: %d\r\n\r\n" % len(text) + text)
    server.stdin.flush()
def receive():
    length = 0
    while (line := server.stdout.readline()) not in (b"\r\n", b""):
        name, value = line.split(b":")
        if name.lower() == b"content-length":
            length = int(value)
    return json.loads(server.stdout.read(length))
send({"id": 1, "method": "initialize", "params": {"processId": None, "rootUri": None, "capabilities": {}}})
assert receive()["result"]["serverInfo"]["name"] == "dotgen"
send({"method": "initialized", "params": {}})
send({"id": 2, "method": "shutdown"})
while receive().get("id") != 2:
    pass
send({"method": "exit"})
assert server.wait(10) == 0
"#;

impl Root {
    /// A fresh copy of the clean Debian, which is set up once.
    fn new() -> Result<Root> {
        tools::ensure(DEBOOTSTRAP)?;
        let clean = xtask::target().join("tools/dist").join(RELEASE);
        let directory = xtask::target().join("tools/dist/root");
        if !clean.join("etc/debian_version").exists() {
            step(&format!("Setting up a clean Debian ({RELEASE})"));
            let partial = clean.with_extension("partial");
            if partial.exists() {
                std::fs::remove_dir_all(&partial)?;
            }
            let place = partial.to_string_lossy();
            let packages = "--include=python3,python3-venv,man-db";
            let arguments = ["--variant=minbase", packages, RELEASE, &*place];
            run::capture(run::command(xtask::root(), "debootstrap", &arguments))?;
            std::fs::rename(&partial, &clean)?;
        }
        if directory.exists() {
            std::fs::remove_dir_all(&directory)?;
        }
        let (from, to) = (clean.to_string_lossy(), directory.to_string_lossy());
        run::capture(run::command(xtask::root(), "cp", &["-a", &*from, &*to]))?;
        let root = Root { directory };
        root.copy(&xtask::root().join(EXAMPLE), "work")?;
        std::fs::write(root.directory.join("work/session.py"), SESSION)?;
        Ok(root)
    }

    /// Copies a file or folder into the root.
    fn copy(&self, from: &Path, to: &str) -> Result<()> {
        let to = self.directory.join(to);
        let (from, to) = (from.to_string_lossy(), to.to_string_lossy());
        run::capture(run::command(xtask::root(), "cp", &["-r", &*from, &*to])).map(drop)
    }

    /// Runs a script of the shell inside, which ends at its first error.
    fn run(&self, script: &str) -> Result<String> {
        let script = format!("set -eu; cd /work; {script}");
        let place = self.directory.to_string_lossy();
        let arguments = [&*place, "/bin/sh", "-c", &*script];
        run::capture(run::command(Path::new("/"), "chroot", &arguments))
    }

    /// Checks an example and starts the language server with the installed `program`.
    fn use_program(&self, program: &str) -> Result<()> {
        self.run(&format!("{program} check pump.gen && python3 session.py {program}"))?;
        let page = self.run(&format!("{program} explain fsm/busy-loop"))?;
        if !page.starts_with("# fsm/busy-loop") {
            bail!("`{program} explain` prints another page:\n{page}");
        }
        Ok(())
    }

    fn try_archive(&self, packages: &Path) -> Result<()> {
        step("The archive, in a clean Debian");
        self.copy(&only(packages, ".tar.gz")?, "work/dotgen.tar.gz")?;
        self.run("tar -xzf dotgen.tar.gz --strip-components=1 --one-top-level=/opt/dotgen")?;
        self.use_program("/opt/dotgen/dotgen")
    }

    fn try_debian(&self, packages: &Path) -> Result<()> {
        step("The package for Debian, in a clean Debian");
        self.copy(&only(packages, ".deb")?, "work/dotgen.deb")?;
        self.run("dpkg -i dotgen.deb")?;
        self.use_program("/usr/bin/dotgen")?;
        let page = self.run("MANPAGER=cat man dotgen-check")?;
        if !page.contains("SYNOPSIS") {
            bail!("the manual has no page `dotgen-check`:\n{page}");
        }
        self.run("dpkg -r dotgen && test ! -e /usr/bin/dotgen").map(drop)
    }

    fn try_wheel(&self, packages: &Path) -> Result<()> {
        step("The wheel, in a clean Debian");
        let wheel = only(packages, ".whl")?;
        self.copy(&wheel, "work")?;
        self.run(
            "python3 -m venv /opt/trial && /opt/trial/bin/pip install --quiet --no-index *.whl",
        )?;
        self.use_program("/opt/trial/bin/dotgen")?;
        self.run("/opt/trial/bin/python -c 'import dotgen; dotgen.connect'").map(drop)
    }

    fn try_extension(&self, packages: &Path) -> Result<()> {
        step("The program of the extension, in a clean Debian");
        self.copy(&only(packages, with_program())?, "work/dotgen.vsix")?;
        let mode = "import zipfile; program = zipfile.ZipFile('dotgen.vsix').getinfo('extension/server/dotgen'); \
                    assert program.external_attr >> 16 & 0o111 == 0o111, 'the program cannot be executed'";
        self.run(&format!("python3 -c \"{mode}\""))?;
        // The module forgets permissions.
        let program = "/opt/vsix/extension/server/dotgen";
        self.run(&format!("python3 -m zipfile -e dotgen.vsix /opt/vsix && chmod +x {program}"))?;
        self.use_program(program)?;
        // ROS 2 is left out for the size. The message names the packages that have it.
        let ros2 =
            format!("{program} run pump.gen --simulate all --clock real --ros2 2>&1 || true");
        let message = self.run(&ros2)?;
        if !message.contains("the Debian package or the wheel") {
            bail!("`{program} run --ros2` does not name the packages with ROS 2:\n{message}");
        }
        Ok(())
    }
}

/// The ending of the extension that contains the program.
fn with_program() -> &'static str {
    match std::env::consts::ARCH {
        "aarch64" => "linux-arm64.vsix",
        _ => "linux-x64.vsix",
    }
}

/// The extensions are small, and contain what they should.
fn extensions(packages: &Path) -> Result<()> {
    step("The extensions");
    for (ending, has_program) in [(with_program(), true), ("universal.vsix", false)] {
        let vsix = only(packages, ending)?;
        let bytes = vsix.metadata()?.len();
        if bytes > LARGEST_EXTENSION {
            bail!("{} has {bytes} bytes, and {LARGEST_EXTENSION} are allowed", vsix.display());
        }
        let arguments = ["-m", "zipfile", "-l", &*vsix.to_string_lossy()];
        let names = run::capture(run::command(packages, "python3", &arguments))?;
        if names.contains("extension/server/dotgen") != has_program {
            bail!(
                "{}: the program should {}be inside",
                vsix.display(),
                if has_program { "" } else { "not " }
            );
        }
    }
    Ok(())
}
