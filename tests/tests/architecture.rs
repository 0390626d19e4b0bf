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
