//! The templates of GenoM3 itself: dotgen's own run of a known template, compared with the run by Tcl.
//!
//! A template is recognized by the contents of its folder. A copy with one more file is not recognized, so
//! Tcl runs it. Both outputs must be equal.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use super::{median, milliseconds};
use xtask::run::{self, step};
use xtask::{example, root, target};

/// Releases, and the environment variable with the templates of each.
const RELEASES: [(&str, &str); 2] =
    [("2.99.39", "DOTGEN_TEST_TEMPLATES"), ("2.99.41", "DOTGEN_TEST_TEMPLATES_2_99_41")];

/// Templates that run without Tcl, with arguments that are supported.
const CALLS: [(&str, &[&str]); 4] = [
    ("mappings", &["-l", "c"]),
    ("mappings", &["-l", "c++", "--signature"]),
    ("skeleton", &["-f", "-C", OUTPUT]),
    ("skeleton", &["-f", "-l", "c++", "-C", OUTPUT]),
];

/// The output folder. After the first call the files exist and later calls write nothing: only the generation
/// is compared.
const OUTPUT: &str = "target/bench-templates/output";

/// Minimum factor by which a run without Tcl must be faster.
const FASTER: f64 = 5.0;

/// Measures and prints. Returns true if every run is fast enough.
pub(crate) fn templates(dotgen: &Path, runs: usize) -> Result<bool> {
    step("Templates without Tcl and with it, alternating");
    println!("{:<36} {:>10} {:>10}", "", "without", "Tcl");
    let mut fast = true;
    let mut measured = false;
    for (release, variable) in RELEASES {
        let Some(folder) = std::env::var_os(variable).map(PathBuf::from) else {
            println!("SKIPPED {release}: {variable} does not name its templates");
            continue;
        };
        measured = true;
        let copies = target().join("bench-templates").join(release);
        for (template, arguments) in CALLS {
            let altered = copies.join(template);
            copy(&folder.join(template), &altered)?;
            std::fs::write(altered.join("one-more"), "")?;
            let call = |folder: &Path| call(dotgen, release, folder, template, arguments);
            let mut times = [Vec::with_capacity(runs), Vec::with_capacity(runs)];
            for _ in 0..runs {
                let (native, output) = call(&folder)?;
                let (tcl, expected) = call(&copies)?;
                ensure!(
                    output.stdout == expected.stdout,
                    "{template} of {release} prints something else without Tcl"
                );
                times[0].push(native);
                times[1].push(tcl);
            }
            let [native, tcl] = times.each_mut().map(|change| median(change));
            let ratio = tcl.as_secs_f64() / native.as_secs_f64();
            let words = [&[template], arguments].concat().join(" ");
            println!(
                "{:<36} {:>7.2} ms {:>7.2} ms  {ratio:>5.1} x",
                format!("{release} {words}"),
                milliseconds(native),
                milliseconds(tcl)
            );
            fast &= ratio >= FASTER;
        }
    }
    Ok(fast && measured)
}

fn call(
    dotgen: &Path,
    release: &str,
    folder: &Path,
    template: &str,
    arguments: &[&str],
) -> Result<(Duration, Output)> {
    let file = example().join("maneuver.gen");
    let (folder, file) = (folder.to_string_lossy(), file.to_string_lossy());
    let idl = format!("-I{}", example().join("idl").display());
    let words = [&["genom3", "-t", &folder, &idl, template], arguments, &[&file]].concat();
    let mut command = run::command(root(), &dotgen.to_string_lossy(), &words);
    command.env("DOTGEN_GENOM_RELEASE", release);
    let started = Instant::now();
    let output = command.output().with_context(|| format!("cannot run {}", dotgen.display()))?;
    let time = started.elapsed();
    ensure!(
        output.status.success(),
        "{template} of {release} fails: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    Ok((time, output))
}

/// Copies the files of a folder.
fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in from.read_dir().with_context(|| format!("cannot read {}", from.display()))? {
        let entry = entry?;
        if entry.path().is_file() {
            std::fs::copy(entry.path(), to.join(entry.file_name()))?;
        }
    }
    Ok(())
}
