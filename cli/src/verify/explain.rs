//! `--explain`: the reductions that the explorations used, and the reasons against the others.

use std::io::Write;

use clap::builder::styling::Style;
use dotgen_timing::reduction_use::ReductionUse;

use crate::width::wrapped;

const TITLE: Style = Style::new().bold();

pub(super) fn print(out: &mut impl Write, reduction: &ReductionUse) -> anyhow::Result<()> {
    let lines = reduction.lines();
    if lines.is_empty() {
        writeln!(out, "\n{TITLE}reductions{TITLE:#}\n  none: nothing had to be explored")?;
        return Ok(());
    }
    writeln!(out, "\n{TITLE}reductions{TITLE:#}")?;
    let width = lines.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    for (name, what) in lines {
        let what = wrapped(&what, width + 4, width + 4);
        writeln!(out, "  {name:<width$}  {what}")?;
    }
    Ok(())
}
