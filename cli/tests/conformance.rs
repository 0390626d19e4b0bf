//! The conformance suite, when it is beside the project: `dotgen check --format json` must accept
//! and reject as expected, errors on the expected lines.

use std::process::Command;

#[test]
fn every_case_of_2_99_39_passes() {
    every_case_passes("2.99.39", &[]);
}

#[test]
fn every_case_of_2_99_41_passes() {
    every_case_passes("2.99.41", &["--release", "2.99.41"]);
}

/// Runs the suite with dotgen reading specifications as a release; `options` say which one the suite expects.
fn every_case_passes(release: &str, options: &[&str]) {
    let Some(suite) = dotgen_loaders::shared("conformance/run") else {
        return;
    };
    let output = Command::new(&suite)
        .args(options)
        .args(["--warnings", "--", env!("CARGO_BIN_EXE_dotgen")])
        .args(["check", "--release", release, "--format", "json"])
        .output();
    let output = match output {
        Ok(output) => output,
        Err(error) => {
            eprintln!("SKIPPED: the conformance suite does not run: {error}");
            return;
        }
    };
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains(" passed, 0 failed"), "{text}");
}
