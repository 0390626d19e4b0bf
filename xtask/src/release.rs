//! `cargo xtask release VERSION`: the commit and the tag of a release. Pushing the tag makes the packages.

use std::path::Path;

use anyhow::{Context, Result, bail};
use clap::Args;

use xtask::run::{self, step};

#[derive(Args)]
pub(crate) struct Options {
    /// The version: MAJOR.MINOR.PATCH
    version: String,
    /// Show what would change
    #[arg(long)]
    dry_run: bool,
}

/// Files that repeat the version of Cargo.toml, with the text around it.
const PLACES: [(&str, &str, &str); 14] = [
    ("Cargo.toml", "version = \"", "\"\nedition"),
    ("vscode-extension/package.json", "\"version\": \"", "\""),
    ("vscode-extension/package-lock.json", "\"version\": \"", "\""),
    ("editors/tree-sitter-genom3/package.json", "\"version\": \"", "\""),
    ("editors/tree-sitter-genom3/tree-sitter.json", "\"version\": \"", "\""),
    ("editors/zed/Cargo.toml", "version = \"", "\""),
    ("editors/zed/extension.toml", "\nversion = \"", "\""),
    ("clients/python/pyproject.toml", "\nversion = \"", "\""),
    ("packaging/robotpkg/Makefile", "VERSION=\t", "\n"),
    (".github/ISSUE_TEMPLATE/bug.yml", "placeholder: dotgen ", "\n"),
    ("docs/ci.md", "/dotgen@v", "\n"),
    ("docs/ci.md", "version: v", "\n"),
    ("docs/ci.md", "releases/download/v", "\n"),
    ("docs/ci.md", "rev: v", "\n"),
];

/// Makes the commit and the tag.
pub(crate) fn release(options: &Options) -> Result<()> {
    let version = &options.version;
    let current = current(xtask::root())?;
    if parsed(version).context("a version is MAJOR.MINOR.PATCH")?
        < parsed(&current).unwrap_or_default()
    {
        bail!("{version} is earlier than {current}");
    }
    let git = |arguments: &[&str]| run::capture(run::command(xtask::root(), "git", arguments));
    if !git(&["status", "--porcelain"])?.is_empty() {
        bail!("commit your changes first");
    }
    let tag = format!("v{version}");
    if !git(&["tag", "--list", &tag])?.is_empty() {
        bail!("the tag {tag} exists");
    }
    let today = run::capture(run::command(xtask::root(), "date", &["-u", "+%Y-%m-%d"]))?;
    let mut changelogs = Vec::new();
    for file in ["CHANGELOG.md", "vscode-extension/CHANGELOG.md"] {
        let path = xtask::root().join(file);
        let changes =
            dated(&std::fs::read_to_string(&path)?, version, today.trim()).context(file)?;
        changelogs.push((path, changes));
    }
    if options.dry_run {
        println!("{current} -> {version} in {} places", PLACES.len());
        for (path, changes) in changelogs {
            let head: Vec<&str> = changes.lines().take(12).collect();
            println!("{}:\n{}", path.display(), head.join("\n"));
        }
        return Ok(());
    }
    for (path, changes) in changelogs {
        std::fs::write(path, changes)?;
    }
    for (file, before, after) in PLACES {
        let path = xtask::root().join(file);
        let text = std::fs::read_to_string(&path).context(file)?;
        let (from, to) = (format!("{before}{current}{after}"), format!("{before}{version}{after}"));
        std::fs::write(path, text.replacen(&from, &to, 2))?;
    }
    step("Lock files");
    run::capture(run::cargo(&["update", "--workspace"]))?;
    run::capture(run::cargo(&["update", "--workspace", "--manifest-path", "fuzz/Cargo.toml"]))?;
    git(&["commit", "--all", "--message", &format!("release: {version}")])?;
    git(&["tag", "--annotate", &tag, "--message", version])?;
    println!("Check `git show`, then: git push --follow-tags");
    Ok(())
}

/// The version in Cargo.toml.
fn current(root: &Path) -> Result<String> {
    let text = std::fs::read_to_string(root.join("Cargo.toml"))?;
    let (_, before, after) = PLACES[0];
    let version = text.split_once(before).and_then(|(_, rest)| rest.split_once(after));
    Ok(version.context("Cargo.toml has no version")?.0.to_owned())
}

fn parsed(version: &str) -> Option<[u32; 3]> {
    if !version.bytes().all(|byte| byte == b'.' || byte.is_ascii_digit()) {
        return None;
    }
    let numbers: Option<Vec<u32>> = version.split('.').map(|part| part.parse().ok()).collect();
    numbers?.try_into().ok()
}

/// The changelog with the changes of `version` under a dated heading, and an empty section for the next
/// ones. A part without changes says so: all parts have one version.
fn dated(changes: &str, version: &str, date: &str) -> Result<String> {
    let (head, rest) =
        changes.split_once("## Unreleased\n").context("no section `## Unreleased`")?;
    let heading = format!("## {version} - ");
    if rest.contains(&heading) {
        bail!("the changelog has a release {version} already");
    }
    let unreleased = rest[..rest.find("\n## ").map_or(rest.len(), |at| at + 1)].trim();
    let none = if unreleased.is_empty() { "\nNo changes.\n" } else { "" };
    let rest = format!("\n{heading}{date}\n{none}{rest}");
    Ok(format!("{head}## Unreleased\n{rest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_the_same_everywhere() {
        let version = current(xtask::root()).expect("a version");
        for (file, before, after) in PLACES {
            let text = std::fs::read_to_string(xtask::root().join(file)).expect(file);
            let place = format!("{before}{version}{after}");
            assert!(text.contains(&place), "{file} has no {place:?}");
        }
    }

    #[test]
    fn changes_get_a_date() {
        let next = dated("# Changes\n\n## Unreleased\n\n* A.\n\n## 0.1.0\n", "0.2.0", "2026-01-02")
            .unwrap();
        assert_eq!(
            next,
            "# Changes\n\n## Unreleased\n\n## 0.2.0 - 2026-01-02\n\n* A.\n\n## 0.1.0\n"
        );
        let first = dated("## Unreleased\n\n* A.\n", "0.1.0", "2026-01-02").unwrap();
        assert_eq!(first, "## Unreleased\n\n## 0.1.0 - 2026-01-02\n\n* A.\n");
        let none =
            dated("## Unreleased\n\n## 0.1.0 - 2026-01-01\n", "0.2.0", "2026-01-02").unwrap();
        assert_eq!(
            none,
            "## Unreleased\n\n## 0.2.0 - 2026-01-02\n\nNo changes.\n\n## 0.1.0 - 2026-01-01\n"
        );
        for (changes, version) in [
            ("## Unreleased\n\n## 0.1.0 - 2026-01-01\n\n* A.\n", "0.1.0"),
            ("# Changes\n", "0.1.0"),
        ] {
            assert!(dated(changes, version, "2026-01-02").is_err(), "{changes:?}");
        }
    }
}
