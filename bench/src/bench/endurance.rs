//! Memory of a server during an hour of edits.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Result;
use serde_json::json;

use super::size::{Session, workspace};
use xtask::run::step;
use xtask::target;

/// Components of the workspace.
const COMPONENTS: usize = 100;
/// Edits of one round: typing in a component, in the shared file, a document opened and closed.
const TYPED: usize = 40;

/// Edits for a number of minutes and prints memory at intervals, then its slope over the second half.
pub(super) fn endurance(dotgen: &Path, minutes: f64) -> Result<()> {
    step(&format!("Editing {COMPONENTS} components for {minutes} minutes"));
    let folder = target().join("endurance");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    workspace::write(&folder, COMPONENTS)?;
    let mut session = Session::start(dotgen, &folder)?;
    let mut shared = session.editor.open(workspace::SHARED, &workspace::shared())?;
    let (started, length) = (Instant::now(), Duration::from_secs_f64(minutes * 60.0));
    let mut samples: Vec<(f64, f64)> = Vec::new();
    let mut edits = 0;
    println!("{:>8} {:>8} {:>9}", "minutes", "edits", "MB");
    for round in 0.. {
        if started.elapsed() >= length {
            break;
        }
        let i = round * 7 % COMPONENTS;
        let mut component = session.editor.open(&workspace::name(i), &workspace::component(i))?;
        for at in 0..TYPED {
            session.editor.edit(&mut component, 13, [0, 0], "x")?;
            session.pull(&component)?;
            if at % 10 == 0 {
                let params = json!({ "textDocument": { "uri": component.uri },
                    "position": { "line": 20, "character": 12 } });
                session.editor.request("textDocument/hover", params)?;
            }
        }
        session.editor.edit(&mut shared, 6, [2, 2], "/*x*/ ")?;
        session.everything_anew()?;
        session.editor.edit(&mut shared, 6, [2, 8], "")?;
        session.editor.close(&component)?;
        edits += TYPED + 2;
        if round % 10 == 0 {
            let sample = (started.elapsed().as_secs_f64() / 60.0, session.resident()?);
            println!("{:>8.1} {edits:>8} {:>9.1}", sample.0, sample.1);
            samples.push(sample);
        }
    }
    session.editor.end()?;
    println!(
        "slope of the second half: {:+.2} MB an hour",
        60.0 * slope(&samples[samples.len() / 2..])
    );
    Ok(std::fs::remove_dir_all(&folder)?)
}

/// The slope of the line that fits best, by least squares.
fn slope(samples: &[(f64, f64)]) -> f64 {
    let count = samples.len().max(1) as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| samples.iter().map(f).sum::<f64>() / count;
    let (x, y) = (mean(|(x, _)| *x), mean(|(_, y)| *y));
    let covariance: f64 = samples.iter().map(|sample| (sample.0 - x) * (sample.1 - y)).sum();
    let variance: f64 = samples.iter().map(|sample| (sample.0 - x).powi(2)).sum();
    covariance / variance.max(1e-9)
}
