//! The arrows between crates go one way; a new one is a decision, not an accident.

#[path = "architecture/imports.rs"]
mod imports;

use std::collections::{BTreeMap, BTreeSet};

use dotgen_tests::workspace_root;

use imports::Imports;

/// For each crate of the product, the crates of the workspace it may depend on.
const ALLOWED: &[(&str, &[&str])] = &[
    ("syntax", &[]),
    ("analysis", &["dotgen-syntax"]),
    ("diagram", &["dotgen-analysis"]),
    ("codegen", &["dotgen-syntax", "dotgen-analysis"]),
    // The checker of certificates shares no code with the verifier. Tests use it.
    ("check", &[]),
    ("timing", &["dotgen-syntax", "dotgen-analysis", "dotgen-check"]),
    // The reader of UPPAAL's models shares no code with the verifier, so that it can check its exports.
    ("xta", &[]),
    ("recording", &["dotgen-syntax", "dotgen-analysis", "dotgen-timing"]),
    ("export", &["dotgen-analysis", "dotgen-timing", "dotgen-xta"]),
    ("runtime", &["dotgen-analysis", "dotgen-codegen", "dotgen-timing", "dotgen-recording"]),
    ("platform", &["dotgen-syntax", "dotgen-analysis", "dotgen-codegen"]),
    ("ros2", &["dotgen-syntax", "dotgen-analysis", "dotgen-codegen"]),
    (
        "hosting",
        &[
            "dotgen-platform",
            "dotgen-syntax",
            "dotgen-analysis",
            "dotgen-codegen",
            "dotgen-timing",
            "dotgen-runtime",
            "dotgen-ros2",
        ],
    ),
    (
        "views",
        &[
            "dotgen-platform",
            "dotgen-syntax",
            "dotgen-analysis",
            "dotgen-codegen",
            "dotgen-diagram",
            "dotgen-timing",
        ],
    ),
    (
        "lsp-server",
        &[
            "dotgen-platform",
            "dotgen-ros2",
            "dotgen-views",
            "dotgen-syntax",
            "dotgen-analysis",
            "dotgen-codegen",
            "dotgen-diagram",
            "dotgen-timing",
            "dotgen-export",
        ],
    ),
    (
        "cli",
        &[
            "dotgen-check",
            "dotgen-platform",
            "dotgen-ros2",
            "dotgen-hosting",
            "dotgen-views",
            "dotgen-lsp-server",
            "dotgen-syntax",
            "dotgen-analysis",
            "dotgen-codegen",
            "dotgen-diagram",
            "dotgen-timing",
            "dotgen-export",
            "dotgen-xta",
            "dotgen-runtime",
            "dotgen-recording",
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
            "dotgen-loaders",
        ],
    ),
    ("tests/loaders", &["dotgen-analysis"]),
    ("xtask", &[]),
];

/// Crates that the tests of every crate may use.
const OF_TESTS: [&str; 2] = ["dotgen-loaders", "dotgen-platform"];

fn manifest(folder: &str) -> toml::Table {
    let path = workspace_root().join(folder).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names of the dependencies of one manifest, `package = "…"` renames followed. True if only tests have it.
fn dependencies(manifest: &toml::Table) -> BTreeSet<(String, bool)> {
    let mut found = BTreeSet::new();
    for section in ["dependencies", "dev-dependencies", "build-dependencies"] {
        for (key, value) in
            manifest.get(section).and_then(toml::Value::as_table).into_iter().flatten()
        {
            let name = value.get("package").and_then(toml::Value::as_str).unwrap_or(key);
            found.insert((name.to_owned(), section == "dev-dependencies"));
        }
    }
    found
}

#[test]
fn crates_depend_in_one_direction_only() {
    let members: Vec<String> = manifest("")["workspace"]["members"]
        .as_array()
        .expect("workspace.members is a list")
        .iter()
        .filter_map(|member| member.as_str().map(str::to_owned))
        .collect();
    let known: BTreeSet<&str> = ALLOWED.iter().map(|(folder, _)| *folder).collect();
    for member in &members {
        assert!(known.contains(member.as_str()), "crate `{member}` has no row in ALLOWED");
    }
    for (folder, allowed) in ALLOWED {
        for (dependency, of_tests) in dependencies(&manifest(folder)) {
            let ours = dependency.starts_with("dotgen-") || dependency == "xtask";
            let ours = ours && !(of_tests && OF_TESTS.contains(&&*dependency));
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
        ("clap", &["views", "cli", "xtask"][..]),
        ("tokio", &["lsp-server", "cli", "tests"][..]),
        ("salsa", &["analysis"][..]),
        ("logos", &["syntax", "timing", "xta"][..]),
        ("rowan", &["syntax", "timing"][..]),
    ];
    for (folder, _) in ALLOWED {
        for (dependency, _) in dependencies(&manifest(folder)) {
            for (library, layers) in only {
                assert!(
                    dependency != library || layers.contains(folder),
                    "`{folder}` must not depend on `{library}`: see docs/architecture.md"
                );
            }
        }
    }
}

/// Modules of one folder do not import each other in a circle, they or what is below them.
#[test]
fn modules_import_in_one_direction_only() {
    let mut found = String::new();
    for (krate, _) in ALLOWED {
        let imports = Imports::of(&workspace_root().join(krate));
        for (folder, modules) in imports.circles() {
            let ties = imports.ties(&folder, &modules).join("\n  ");
            found += &format!("in {krate}/src/{}:\n  {ties}\n", folder.replace("::", "/"));
        }
    }
    assert!(found.is_empty(), "a circle of imports: move what both sides need below them\n{found}");
}

#[test]
fn scripts_of_the_extension_import_in_one_direction_only() {
    let found = imports::script_import_cycles(&workspace_root().join("vscode-extension/src"));
    assert!(found.is_empty(), "scripts import each other: {found:#?}");
}

#[test]
fn a_circle_of_imports_is_seen() {
    let circles = |texts: &[(&str, &str)]| {
        let module = |text: &str| -> Vec<String> {
            let names = text.split("::").filter(|part| !part.is_empty());
            names.map(str::to_owned).collect()
        };
        let texts: BTreeMap<Vec<String>, String> =
            texts.iter().map(|(path, text)| (module(path), (*text).to_owned())).collect();
        let all = Imports::read(&texts).circles();
        let all = all.into_iter().map(|circle| circle.1.into_iter().collect::<Vec<_>>());
        all.collect::<Vec<_>>()
    };
    let ab = vec![vec!["a".to_owned(), "b".to_owned()]];
    let two = [("", ""), ("a", "use crate::b::{self, X};"), ("b", "")];
    assert!(circles(&two).is_empty());
    // By paths in the code; by what is below; by a name that the parent passes on.
    let paths = [("", ""), ("a", "use crate::b::X;"), ("b", "fn f() -> crate::a::Y {}")];
    assert_eq!(circles(&paths), ab);
    let below = [
        ("", ""),
        ("a", ""),
        ("a::c", "use crate::{b::{X, Z}, other};"),
        ("b", ""),
        ("b::d", "use crate::a::Y;"),
    ];
    assert_eq!(circles(&below), ab);
    let passed =
        [("", "mod a;\nmod b;\npub use a::Y;"), ("a", "use super::b::X;"), ("b", "use super::Y;")];
    assert_eq!(circles(&passed), ab);
    // Parent and child; comments, texts and tests.
    let none = [
        ("", ""),
        ("a", "mod c;\nuse c::X;"),
        ("a::c", "use super::Y;\nuse crate::b::X;"),
        (
            "b",
            "// use crate::a::X;\nconst X: &str = \"crate::a::X\";\n\
             #[cfg(test)]\nmod tests {\n use crate::a::X;\n}",
        ),
    ];
    assert!(circles(&none).is_empty());
}

/// The Rust files below a folder, without those of tests.
fn sources(folder: &str) -> Vec<(String, String)> {
    let root = workspace_root();
    let mut waiting = vec![root.join(folder).join("src")];
    let mut out = Vec::new();
    while let Some(at) = waiting.pop() {
        if at.is_dir() {
            let entries = std::fs::read_dir(&at).expect("a folder");
            waiting.extend(entries.flatten().map(|entry| entry.path()));
            continue;
        }
        let name = at.strip_prefix(&root).expect("below it").display().to_string();
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
    for (folder, _) in ALLOWED.iter().filter(|(folder, _)| !["tests", "xtask"].contains(folder)) {
        for (name, code) in sources(folder) {
            let starts =
                code.contains("process::Command") || code.contains("process::{Child, Command");
            let starts =
                starts || code.contains("Command, Stdio") || code.contains("Command, ExitCode");
            let allowed = name.starts_with("platform/src/process");
            assert!(!starts || allowed, "{name} starts programs; `platform/src/process` does that");
        }
    }
}

/// The Rust sources below a folder.
fn walk(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    files(folder, "rs")
}

/// The files below a folder whose names have an ending.
fn files(folder: &std::path::Path, ending: &str) -> Vec<std::path::PathBuf> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            out.extend(files(&path, ending));
        } else if path.extension().is_some_and(|extension| extension == ending) {
            out.push(path);
        }
    }
    out.sort();
    out
}

/// Where shared test data lies is known in one place, so that one variable hides it.
#[test]
fn shared_test_data_is_found_in_one_place() {
    let place = concat!("../", "shared");
    let mut bad = Vec::new();
    for (folder, _) in ALLOWED {
        let sources = walk(&workspace_root().join(folder));
        for path in sources.iter().filter(|path| !path.ends_with("loaders/src/shared.rs")) {
            let source = std::fs::read_to_string(path).expect("a source");
            if source.contains(place) {
                bad.push(path.clone());
            }
        }
    }
    assert!(bad.is_empty(), "use `dotgen_loaders::shared`: {bad:#?}");
}

/// Where the tests of a crate are one program, every file of them belongs to it.
#[test]
fn no_file_of_tests_is_forgotten() {
    for (folder, _) in ALLOWED {
        let tests = workspace_root().join(folder).join("tests");
        let manifest = manifest(folder);
        let automatic = manifest["package"].get("autotests");
        if automatic.and_then(toml::Value::as_bool) != Some(false) {
            continue;
        }
        let main = std::fs::read_to_string(tests.join("main.rs")).expect("tests/main.rs");
        let own = manifest.get("test").and_then(toml::Value::as_array);
        let own: BTreeSet<_> =
            own.into_iter().flatten().filter_map(|test| test["path"].as_str()).collect();
        for entry in std::fs::read_dir(&tests).expect("a folder").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some(module) = name.strip_suffix(".rs").filter(|module| *module != "main") else {
                continue;
            };
            assert!(
                main.contains(&format!("mod {module};")) || own.contains(&*format!("tests/{name}")),
                "{folder}/tests/main.rs has no `mod {module};`"
            );
        }
    }
}
