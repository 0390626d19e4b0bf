//! Counts by kind, and offenders.

use std::collections::{BTreeMap, BTreeSet};

/// Kinds of offenders for which the campaign fails.
const FAILING_KINDS: [&str; 6] =
    ["worse", "useless", "losing text", "contradicted", "no longer compiles", "failed"];

/// The results of a campaign.
#[derive(Default)]
pub(super) struct Report {
    /// The present set, for the lines of offenders.
    pub(super) set: String,
    /// Numbers of cases, by group and kind.
    figures: BTreeMap<(String, &'static str), usize>,
    /// Lines that were printed.
    offenders: BTreeSet<(&'static str, String)>,
    /// Codes of new findings, by kind.
    codes: BTreeMap<(&'static str, String), usize>,
}

impl Report {
    /// Counts a case.
    pub(super) fn count(&mut self, group: &str, kind: &'static str, number: usize) {
        *self.figures.entry((group.to_owned(), kind)).or_default() += number;
    }

    /// Counts the code of a finding.
    pub(super) fn code(&mut self, kind: &'static str, code: &str) {
        *self.codes.entry((kind, code.to_owned())).or_default() += 1;
    }

    /// Prints an offender at once, unless the same line was printed before.
    pub(super) fn report_offender(&mut self, kind: &'static str, line: &str) {
        let line = format!("[{}] {line}", self.set);
        if self.offenders.insert((kind, line.clone())) {
            println!("{kind}: {line}");
        }
    }

    /// Number of cases that were judged.
    pub(super) fn cases(&self) -> usize {
        let judged = self.figures.iter().filter(|figure| figure.0.1 == "judged");
        judged.map(|figure| figure.1).sum()
    }

    /// Number of offenders of the kinds for which the campaign fails.
    pub(super) fn bad(&self) -> usize {
        let bad = |pair: &&(&str, String)| FAILING_KINDS.contains(&pair.0);
        self.offenders.iter().filter(bad).count()
    }

    /// True if there is no such offender.
    pub(super) fn is_clean(&self) -> bool {
        self.bad() == 0
    }

    /// Prints the table.
    pub(super) fn print(&self) {
        println!("\n| what | figure | number |\n| --- | --- | --- |");
        for ((group, kind), number) in &self.figures {
            println!("| {group} | {kind} | {number} |");
        }
        println!("\n| kind | code | number |\n| --- | --- | --- |");
        for ((kind, code), number) in &self.codes {
            println!("| {kind} | {code} | {number} |");
        }
        println!("\n{} cases, {} offenders", self.cases(), self.bad());
    }
}
