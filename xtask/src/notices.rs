//! `cargo xtask notices`: the licences of the contents of the program and the extension, as one file.
//!
//! The crates are those that `cargo metadata` reaches from the program by normal dependencies, on any system.
//! The npm packages are those that the lock file reaches from the language client, which is bundled. Each
//! must have a licence that `deny.toml` allows, because the package contains the texts of licences and can
//! meet no further conditions.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use cargo_metadata::{CargoOpt, DependencyKind, Metadata, MetadataCommand, PackageId};
use clap::Args;
use serde_json::Value;
use spdx::{Expression, LicenseItem};

use xtask::extension::{self, NOTICES};
use xtask::run::step;

/// Options of `cargo xtask notices`.
#[derive(Args)]
pub(crate) struct Options {
    /// Write nothing; fail when the file is not what it should be.
    #[arg(long)]
    pub(crate) check: bool,
}

/// The distributed program.
const PROGRAM: &str = "dotgen";
/// The npm packages that are bundled with the extension; the others are tools.
const BUNDLED: &[&str] = &["vscode-languageclient"];

/// A package of another author.
struct Part {
    name: String,
    version: String,
    licence: String,
    home: Option<String>,
    /// The directory of its sources.
    directory: PathBuf,
}

/// Writes the notices, or checks them. Returns false if they are out of date.
pub(crate) fn notices(options: &Options) -> Result<bool> {
    let mut parts = crates()?;
    parts.extend(npm_packages()?);
    let allowed = allowed()?;
    let refused = parts.iter().filter_map(|part| refusal(part, &allowed));
    let refused: Vec<String> = refused.collect();
    if !refused.is_empty() {
        bail!("licences that are not accepted (the list is in deny.toml):\n{}", refused.join("\n"));
    }
    let text = render(&parts)?;
    let path = xtask::root().join(NOTICES);
    if !options.check {
        std::fs::write(&path, text)?;
        println!("{}: {} packages", path.display(), parts.len());
        return Ok(true);
    }
    let same = std::fs::read_to_string(&path).is_ok_and(|content| content == text);
    if !same {
        eprintln!("{NOTICES} is out of date: run `cargo xtask notices` and commit it");
    }
    Ok(same)
}

/// SPDX identifiers of the licences that `deny.toml` allows.
///
/// # Errors
/// The file cannot be read, or does not contain the list.
fn allowed() -> Result<Vec<String>> {
    #[derive(serde::Deserialize)]
    struct Deny {
        licenses: Licenses,
    }
    #[derive(serde::Deserialize)]
    struct Licenses {
        allow: Vec<String>,
    }
    let text = std::fs::read_to_string(xtask::root().join("deny.toml"))?;
    let deny: Deny = toml::from_str(&text).context("deny.toml")?;
    Ok(deny.licenses.allow)
}

/// The line of a package that cannot be distributed, because its licence is not allowed.
fn refusal(part: &Part, allowed: &[String]) -> Option<String> {
    let accepted = |licence: &LicenseItem| match licence {
        LicenseItem::Spdx { id, .. } => allowed.iter().any(|name| name == id.name),
        LicenseItem::Other { .. } => false,
    };
    let lax = spdx::ParseMode::LAX;
    let fine = Expression::parse_mode(&part.licence, lax)
        .is_ok_and(|mode| mode.evaluate(|requirement| accepted(&requirement.license)));
    (!fine).then(|| format!("  {} {}: {}", part.name, part.version, part.licence))
}

fn crates() -> Result<Vec<Part>> {
    step("Crates of the program");
    let metadata = MetadataCommand::new()
        .manifest_path(xtask::root().join("Cargo.toml"))
        .other_options(["--locked".to_owned()])
        .features(CargoOpt::SomeFeatures(vec![extension::FEATURES.to_owned()]))
        .exec()?;
    let program = metadata
        .workspace_packages()
        .into_iter()
        .find(|package| package.name.as_str() == PROGRAM)
        .context("the workspace has the program")?;
    let reached = reached(&metadata, &program.id)?;
    let ours: BTreeSet<&PackageId> = metadata.workspace_members.iter().collect();
    let mut parts = Vec::new();
    for package in metadata.packages.iter().filter(|package| reached.contains(&package.id)) {
        if ours.contains(&package.id) {
            continue;
        }
        parts.push(Part {
            name: package.name.to_string(),
            version: package.version.to_string(),
            licence: package.license.clone().unwrap_or_default(),
            home: package.repository.clone().or(package.homepage.clone()),
            directory: package
                .manifest_path
                .parent()
                .context("a manifest lies in a folder")?
                .into(),
        });
    }
    parts.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(parts)
}

/// The packages in a package. Build scripts and tests do not count: they are not part of the program.
fn reached<'a>(metadata: &'a Metadata, from: &'a PackageId) -> Result<BTreeSet<&'a PackageId>> {
    let resolve = metadata.resolve.as_ref().context("cargo resolves dependencies")?;
    let nodes: BTreeMap<&PackageId, _> =
        resolve.nodes.iter().map(|node| (&node.id, node)).collect();
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(id) = open.pop() {
        if !reached.insert(id) {
            continue;
        }
        let normal = nodes[id].deps.iter().filter(|dependency| {
            let kinds = &dependency.dep_kinds;
            kinds.iter().any(|kind| kind.kind == DependencyKind::Normal)
        });
        open.extend(normal.map(|dependency| &dependency.pkg));
    }
    Ok(reached)
}

fn npm_packages() -> Result<Vec<Part>> {
    let directory = extension::directory();
    extension::install_packages(&directory)?;
    let lock = std::fs::read_to_string(directory.join("package-lock.json"))?;
    let lock: Value = serde_json::from_str(&lock)?;
    let packages = lock["packages"].as_object().context("the lock file lists packages")?;
    let mut reached = BTreeSet::new();
    let mut open: Vec<String> = BUNDLED.iter().map(|text| format!("node_modules/{text}")).collect();
    while let Some(place) = open.pop() {
        let Some(package) = packages.get(&place) else {
            bail!("{place} is not in package-lock.json");
        };
        if !reached.insert(place.clone()) {
            continue;
        }
        let names = package["dependencies"].as_object().into_iter().flatten();
        open.extend(names.map(|(name, _)| {
            // Node searches next to the package first, then in outer folders.
            let own = format!("{place}/node_modules/{name}");
            if packages.contains_key(&own) { own } else { format!("node_modules/{name}") }
        }));
    }
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let part = |place: String| {
        let name = place.rsplit("node_modules/").next().unwrap_or_default().to_owned();
        Part {
            version: text(&packages[&place]["version"]),
            licence: text(&packages[&place]["license"]),
            home: Some(format!("https://www.npmjs.com/package/{name}")),
            directory: directory.join(&place),
            name,
        }
    };
    Ok(reached.into_iter().map(part).collect())
}

/// The whole file: the list of packages, then every text once, with its packages.
fn render(parts: &[Part]) -> Result<String> {
    let mut out = String::from(
        "dotgen contains the work of others. This file names it, with the licences and their texts.\n\
         Made by `cargo xtask notices`.\n\n",
    );
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for part in parts {
        let (name, version) = (&part.name, &part.version);
        let home = part.home.as_deref().unwrap_or_default();
        writeln!(out, "{name} {version}  ({})  {home}", part.licence)?;
        let own = licence_texts(&part.directory)
            .with_context(|| format!("cannot read {}", part.directory.display()))?;
        if own.is_empty() {
            writeln!(out, "    the package has no text of its licence; its home may")?;
        }
        for text in own {
            texts.entry(text).or_default().push(format!("{name} {version}"));
        }
    }
    let mut texts: Vec<(Vec<String>, String)> = texts.into_iter().map(|(a, b)| (b, a)).collect();
    texts.sort();
    for (names, text) in texts {
        let rule = "-".repeat(80);
        write!(out, "\n{rule}\n{}\n{rule}\n\n{}\n", names.join(", "), text)?;
    }
    Ok(out)
}

/// The texts of the licences in a package, without blanks at the ends of lines. Licences of fonts are in a
/// separate folder.
fn licence_texts(directory: &Path) -> Result<BTreeSet<String>> {
    const WORDS: &[&str] = &["license", "licence", "copying", "copyright", "notice"];
    const FONTS: &[&str] = &["ofl.txt", "ufl.txt", "hack-regular.txt"];
    let mut texts = BTreeSet::new();
    for folder in [directory.to_owned(), directory.join("fonts")] {
        if !folder.is_dir() {
            continue;
        }
        for entry in std::fs::read_dir(&folder)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().to_lowercase();
            let source = name.ends_with(".rs") || name.ends_with(".js");
            let named = WORDS.iter().any(|word| name.contains(word)) || FONTS.contains(&&*name);
            if entry.file_type()?.is_file() && named && !source {
                let text = String::from_utf8_lossy(&std::fs::read(entry.path())?).into_owned();
                let lines: Vec<&str> = text.trim().lines().map(str::trim_end).collect();
                texts.insert(lines.join("\n"));
            }
        }
    }
    Ok(texts)
}
