//! The suites of the extension without VS Code, and of clients of the protocol.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::{TestCounts, count};
use xtask::extension::{self, Profile};
use xtask::run::{self, step};
use xtask::tools;

/// Type checks and unit tests of the extension.
pub(super) fn extension() -> Result<TestCounts> {
    let directory = extension::directory();
    extension::install_packages(&directory)?;
    let mut outcome = TestCounts::one(run::watch(
        extension::npm(&directory, &["run", "--silent", "typecheck"]),
        |_| (),
    )?);
    run::capture(extension::npm(&directory, &["run", "--silent", "bundle"]))?;
    let succeeded =
        run::watch(extension::npm(&directory, &["run", "--silent", "test:unit"]), |line| {
            if let Some((_, number)) = line.split_once(" pass ") {
                outcome.passed += number.trim().parse().unwrap_or(0);
            }
            if let Some((_, number)) = line.split_once(" fail ") {
                outcome.failed += number.trim().parse().unwrap_or(0);
            }
        })?;
    Ok(outcome.ended(succeeded))
}

/// The TextMate grammar against its snapshots.
pub(super) fn grammar() -> Result<TestCounts> {
    let directory = extension::directory();
    extension::install_packages(&directory)?;
    let snapshots = directory.join("test/grammar/snap");
    // The snapshot tool writes a missing snapshot and passes.
    for source in files(&snapshots, "gen")? {
        let snapshot = PathBuf::from(format!("{}.snap", source.display()));
        if !snapshot.exists() {
            bail!("{} is missing: run `npm run test:grammar` and commit it", snapshot.display());
        }
    }
    let sources = directory.join("test/grammar");
    let tests = files(&sources, "gen")?.len()
        + files(&sources, "scn")?.len()
        + files(&snapshots, "gen")?.len();
    let succeeded =
        run::watch(extension::npm(&directory, &["run", "--silent", "test:grammar"]), |_| ())?;
    Ok(if succeeded {
        TestCounts { passed: tests, ..TestCounts::default() }
    } else {
        TestCounts::one(false)
    })
}

/// The server with a client of another author, and the clients in Python and Tcl.
pub(super) fn client() -> Result<TestCounts> {
    tools::ensure(tools::PYTHON)?;
    let server = extension::build_server(Profile::Dev)?;
    let python = python()?;
    let scripts = scripts();
    let arguments = ["-m", "pytest", "-q", "-p", "no:cacheprovider"];
    let mut command = run::command(&scripts, &python.to_string_lossy(), &arguments);
    command
        .env("DOTGEN", server)
        .env("WORKSPACE", xtask::example())
        .env("PYTHONDONTWRITEBYTECODE", "1");
    let mut outcome = TestCounts::default();
    let succeeded = run::watch(command, |line| {
        // After a minute the time is also in hours: `in 96.14s (0:01:36)`.
        let is_summary = [" passed", " failed", " error"].iter().any(|word| line.contains(word));
        if is_summary && line.contains(" in ") && line.ends_with(['s', ')']) {
            outcome.passed = count(line, " passed");
            outcome.failed = count(line, " failed") + count(line, " error");
            let skipped = count(line, " skipped");
            outcome.skipped = vec!["client: see its output".to_owned(); skipped];
        }
    })?;
    Ok(outcome.ended(succeeded))
}

fn scripts() -> PathBuf {
    xtask::root().join("tests/editors/client")
}

/// Creates a virtual environment with the test's packages, and returns its Python.
pub(super) fn python() -> Result<PathBuf> {
    let requirements = scripts().join("requirements.txt");
    let wanted = std::fs::read_to_string(&requirements)?;
    let directory = xtask::target().join("tools/python");
    let (python, stamp) = (directory.join("bin/python"), directory.join("requirements.txt"));
    if std::fs::read_to_string(&stamp).ok().as_ref() != Some(&wanted) {
        step("Installing pytest-lsp");
        let venv = ["-m", "venv", "--clear", &*directory.to_string_lossy()];
        run::capture(run::command(xtask::root(), "python3", &venv))?;
        let pip = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "-r",
            &*requirements.to_string_lossy(),
        ];
        run::capture(run::command(xtask::root(), &python.to_string_lossy(), &pip))?;
        std::fs::write(&stamp, wanted)?;
    }
    Ok(python)
}

fn files(directory: &Path, extension: &str) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let path = entry?.path();
        if path.is_file() && path.extension().is_some_and(|name| name == extension) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
