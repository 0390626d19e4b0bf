//! `--certificate`: the checks that invariants prove, for `dotgen-check`.

use std::io::Write;

use anyhow::Context;
use camino::Utf8Path;
use dotgen_platform::files::disk::Stream;
use dotgen_timing::invariants::certificate::{Certificate, FORMAT};
use dotgen_timing::verify::{SystemInput, certificate};

use super::Answer;

/// Writes the certificate of all answers, and prints the number of checks in it to standard error.
pub(super) fn write(path: &Utf8Path, answers: &[Answer]) -> anyhow::Result<()> {
    let scenarios = answers.iter().map(|answer| {
        let input = SystemInput { specs: answer.problem.specs() };
        certificate(&input, &answer.problem.scenario, &answer.options, &answer.report)
    });
    let document = Certificate { format: FORMAT, scenarios: scenarios.collect() };
    let wrong = || format!("cannot write `{path}`");
    let mut out = Stream::create(path.as_std_path()).with_context(wrong)?;
    serde_json::to_writer_pretty(&mut out, &document).with_context(wrong)?;
    out.write_all(b"\n").with_context(wrong)?;
    out.finish().with_context(wrong)?;
    let all: usize = answers.iter().map(|answer| answer.report.checks.len()).sum();
    let rest = document.scenarios.iter().map(|scenario| scenario.uncertified.len());
    let rest: usize = rest.sum();
    let certified = all - rest;
    anstream::eprintln!("`{path}`: {certified} of {all} checks certified, {rest} not");
    Ok(())
}
