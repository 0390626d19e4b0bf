//! The arrows between crates go one way; a new one is a decision, not an accident.

use std::collections::BTreeSet;

use dotgen_tests::workspace_root;

/// For each crate of the product, the crates of the workspace it may depend on.
const ALLOWED: &[(&str, &[&str])] = &[
    ("syntax", &[]),
    ("analysis", &["dotgen-syntax"]),
    ("diagram", &["dotgen-analysis"]),
    ("codegen", &["dotgen-syntax", "dotgen-analysis"]),
    ("timing", &["dotgen-analysis"]),
    (
        "lsp-server",
        &[
            "dotgen-syntax",
            "dotgen-analysis",
            "dotgen-diagram",
            "dotgen-codegen",
            "dotgen-timing",
        ],
    ),
    (
        "tests",
        &[
            "dotgen-syntax",
            "dotgen-analysis",
            "dotgen-diagram",
            "dotgen-codegen",
            "dotgen-timing",
            "dotgen-lsp-server",
        ],
    ),
    ("xtask", &[]),
];

fn manifest(folder: &str) -> toml::Table {
    let path = workspace_root().join(folder).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse()
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names of the dependencies of one manifest, `package = "…"` renames followed.
fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    ["dependencies", "dev-dependencies", "build-dependencies"]
        .iter()
        .filter_map(|section| manifest.get(*section)?.as_table())
        .flat_map(|table| {
            table.iter().map(|(key, value)| {
                value
                    .get("package")
                    .and_then(toml::Value::as_str)
                    .unwrap_or(key)
                    .to_owned()
            })
        })
        .collect()
}

#[test]
fn crates_depend_in_one_direction_only() {
    let members: Vec<String> = manifest("")["workspace"]["members"]
        .as_array()
        .expect("workspace.members is a list")
        .iter()
        .filter_map(|it| it.as_str().map(str::to_owned))
        .collect();
    let known: BTreeSet<&str> = ALLOWED.iter().map(|(folder, _)| *folder).collect();
    for member in &members {
        assert!(
            known.contains(member.as_str()),
            "crate `{member}` has no row in ALLOWED"
        );
    }
    for (folder, allowed) in ALLOWED {
        for dependency in dependencies(&manifest(folder)) {
            let ours = dependency.starts_with("dotgen-") || dependency == "xtask";
            assert!(
                !ours || allowed.contains(&dependency.as_str()),
                "`{folder}` must not depend on `{dependency}`: see docs/architecture.md"
            );
        }
    }
}

/// What only one layer may know: tokio and the protocol in the server, salsa in the analysis, the
/// tree library in the syntax crate.
#[test]
fn libraries_stay_in_their_layer() {
    let only = [
        ("tower-lsp", &["lsp-server"][..]),
        ("tokio", &["lsp-server", "tests"][..]),
        ("salsa", &["analysis"][..]),
        ("logos", &["syntax", "timing"][..]),
        ("rowan", &["syntax", "timing"][..]),
    ];
    for (folder, _) in ALLOWED {
        for dependency in dependencies(&manifest(folder)) {
            for (library, layers) in only {
                assert!(
                    dependency != library || layers.contains(folder),
                    "`{folder}` must not depend on `{library}`: see docs/architecture.md"
                );
            }
        }
    }
}

/// The Rust files below a folder, without those of tests.
fn sources(folder: &str) -> Vec<(String, String)> {
    let root = workspace_root();
    let mut waiting = vec![root.join(folder).join("src")];
    let mut out = Vec::new();
    while let Some(at) = waiting.pop() {
        if at.is_dir() {
            let entries = std::fs::read_dir(&at).expect("a folder");
            waiting.extend(entries.flatten().map(|it| it.path()));
            continue;
        }
        let name = at
            .strip_prefix(&root)
            .expect("below it")
            .display()
            .to_string();
        // The generator of the typed tree runs in a test.
        let tests = name.contains("/tests") || name.ends_with("/generator.rs");
        if name.ends_with(".rs") && !tests {
            let text = std::fs::read_to_string(&at).expect("UTF-8");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            out.push((name, code.to_owned()));
        }
    }
    assert!(!out.is_empty(), "no sources in {folder}");
    out
}

#[test]
fn programs_are_started_in_one_place() {
    for (folder, _) in ALLOWED
        .iter()
        .filter(|it| !["tests", "xtask"].contains(&it.0))
    {
        for (name, code) in sources(folder) {
            let starts =
                code.contains("process::Command") || code.contains("process::{Child, Command");
            let starts =
                starts || code.contains("Command, Stdio") || code.contains("Command, ExitCode");
            let allowed = name.starts_with("lsp-server/src/process");
            assert!(
                !starts || allowed,
                "{name} starts programs; `lsp-server/src/process` does that"
            );
        }
    }
}
