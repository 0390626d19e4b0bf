//! The examples are sound, and their READMEs tell what dotgen remarks about them.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

#[test]
fn examples_are_sound_and_every_remark_is_explained() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut count = 0;
    for entry in std::fs::read_dir(&examples).expect("examples") {
        let directory = entry.expect("an entry").path();
        // What `drift` shows is not in the specification but in the sources beside it.
        if !directory.is_dir() || directory.ends_with("drift") {
            continue;
        }
        let output = Command::new(env!("CARGO_BIN_EXE_dotgen"))
            .args(["check", "--format", "json", "."])
            .current_dir(&directory)
            .output()
            .expect("dotgen runs");
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let readme = std::fs::read_to_string(directory.join("README.md")).expect("a README");
        for diagnostic in found["diagnostics"].as_array().expect("diagnostics") {
            let severity = diagnostic["severity"].as_str().expect("a severity");
            assert!(!["error", "warning"].contains(&severity), "{diagnostic:#}");
            // What is said of an included example is explained there.
            let file = diagnostic["file"].as_str().expect("a file");
            let code = diagnostic["code"].as_str().expect("a code");
            let elsewhere = Path::new(file).is_absolute() || file.starts_with("..");
            let explained = elsewhere || readme.contains(code);
            assert!(explained, "{}: {diagnostic:#}", directory.display());
        }
        count += 1;
    }
    assert!(count >= 4, "{count} examples");
}

#[test]
fn examples_are_in_shape() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let output = Command::new(env!("CARGO_BIN_EXE_dotgen"))
        .args(["fmt", "--check", "."])
        .current_dir(&examples)
        .output()
        .expect("dotgen runs");
    let would_change = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "run `dotgen fmt examples`:\n{would_change}");
}
