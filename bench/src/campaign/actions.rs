//! The campaign over edits: each is applied, and the findings before and after are compared.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::Options;
use super::compare::{ChangedLines, Finding, Findings};
use super::edits;
use super::mutate::mutate;
use super::report::Report;
use super::sets::{Set, is_specification};
use super::workspace::Workspace;

/// Findings of a mutated document at which actions are requested.
const MAX_FINDINGS: usize = 6;

/// The present case.
struct Case<'c> {
    report: &'c mut Report,
    /// Row of the table.
    group: &'static str,
    /// Mutation of the text, for the line of an offender.
    context: String,
    /// Edits that were tried on the present texts.
    tried: BTreeSet<String>,
}

/// Measures a set.
pub(super) fn actions(
    options: &Options,
    dotgen: &Path,
    set: &Set,
    report: &mut Report,
) -> Result<()> {
    let mut random = fastrand::Rng::with_seed(options.seed);
    let mut workspace = Workspace::open(dotgen, set)?;
    let mut case =
        Case { report, group: "as published", context: String::new(), tried: BTreeSet::new() };
    let before = workspace.findings()?;
    for (path, findings) in &before.0 {
        for finding in findings {
            at_finding(&mut workspace, &mut case, &before, path, finding, None)?;
        }
        everything(&mut workspace, &mut case, &before, path)?;
        let lines = workspace.texts[path].lines().count().max(1);
        for _ in 0..options.places {
            let (line, character) = (random.usize(..lines), random.usize(..60));
            let text = workspace.texts[path].lines().nth(line).unwrap_or_default();
            let place = json!({ "line": line, "character": character.min(text.len()) });
            let range = json!({ "start": place, "end": place });
            let offered = workspace.actions(path, &range, &[], None)?;
            each(&mut workspace, &mut case, &before, path, line, offered)?;
        }
    }
    let specifications: Vec<PathBuf> =
        before.0.into_keys().filter(|key| is_specification(key)).collect();
    for path in specifications {
        for number in 0..options.mutations {
            let seed = options.seed.wrapping_mul(1000).wrapping_add(number as u64);
            mutated(&mut workspace, &mut case, dotgen, &path, seed)?;
        }
    }
    workspace.end()
}

/// Measures one mutation of a specification.
fn mutated(
    workspace: &mut Workspace,
    case: &mut Case<'_>,
    dotgen: &Path,
    path: &Path,
    seed: u64,
) -> Result<()> {
    let text = workspace.texts[path].clone();
    let Some((new, what)) = mutate(&text, &mut fastrand::Rng::with_seed(seed)) else {
        return Ok(());
    };
    case.group = "mutated";
    case.context = format!(" [mutation: {what}]");
    case.tried.clear();
    case.report.count(case.group, "mutations", 1);
    workspace.set(path, new.clone())?;
    let before = workspace.findings()?;
    let findings = before.0.get(path).cloned().unwrap_or_default();
    for finding in findings.iter().take(MAX_FINDINGS) {
        at_finding(workspace, case, &before, path, finding, Some("quickfix"))?;
    }
    everything(workspace, case, &before, path)?;
    case.group = "check --fix of mutated";
    check_fix(workspace, case, dotgen, path, &new)?;
    workspace.set(path, text)
}

/// Tries the actions at a finding.
fn at_finding(
    workspace: &mut Workspace,
    case: &mut Case<'_>,
    before: &Findings,
    path: &Path,
    finding: &Finding,
    only: Option<&str>,
) -> Result<()> {
    let diagnostics = [finding.raw.clone()];
    let range = finding.raw["range"].clone();
    let offered = workspace.actions(path, &range, &diagnostics, only)?;
    each(workspace, case, before, path, finding.lines[0], offered)
}

/// Tries the actions that change a whole file.
fn everything(
    workspace: &mut Workspace,
    case: &mut Case<'_>,
    before: &Findings,
    path: &Path,
) -> Result<()> {
    let last = workspace.texts[path].lines().count();
    let range = json!({ "start": { "line": 0, "character": 0 },
        "end": { "line": last, "character": 0 } });
    for only in ["source.fixAll", "source.fixFindings", "source.organizeImports"] {
        let offered = workspace.actions(path, &range, &[], Some(only))?;
        each(workspace, case, before, path, 0, offered)?;
    }
    Ok(())
}

fn each(
    workspace: &mut Workspace,
    case: &mut Case<'_>,
    before: &Findings,
    path: &Path,
    line: usize,
    offered: Vec<Value>,
) -> Result<()> {
    for action in offered {
        if action["edit"].is_null() {
            case.report.count(case.group, "without an edit", 1);
            continue;
        }
        if case.tried.insert(action["edit"].to_string()) {
            let result = one(workspace, case, before, path, line, &action);
            let title = action["title"].as_str().unwrap_or_default();
            result.with_context(|| format!("{}:{}: {title}", path.display(), line + 1))?;
        }
    }
    Ok(())
}

/// Applies one action, judges the action and restores the texts.
fn one(
    workspace: &mut Workspace,
    case: &mut Case<'_>,
    before: &Findings,
    path: &Path,
    line: usize,
    action: &Value,
) -> Result<()> {
    let findings = action["diagnostics"].as_array().into_iter().flatten();
    let mends: Vec<Finding> = findings.map(Finding::read).collect();
    let about: Vec<_> = mends.iter().flat_map(|finding| edits::places(path, finding)).collect();
    let applied = match edits::apply(&action["edit"], |path| workspace.text(path), &about) {
        Ok(applied) => applied,
        Err(error) => {
            let title = &action["title"];
            let line = format!("{}:{}: {title}: {error:#}", path.display(), line + 1);
            case.report.count(case.group, "not applied", 1);
            case.report.report_offender("not applied", &line);
            return Ok(());
        }
    };
    let mut restore = BTreeMap::new();
    for (path, text) in &applied.texts {
        restore.insert(path.clone(), workspace.text(path));
        match workspace.texts.contains_key(path) {
            true => workspace.set(path, text.clone())?,
            false => workspace.write(path, Some(text))?,
        }
    }
    let after = workspace.findings()?;
    for (path, text) in restore {
        match text {
            Some(text) if workspace.texts.contains_key(&path) => workspace.set(&path, text)?,
            text => workspace.write(&path, text.as_deref())?,
        }
    }
    let title = action["title"].as_str().unwrap_or_default();
    let kind = action["kind"].as_str().unwrap_or_default();
    let root = &workspace.copy.root;
    let shown = path.strip_prefix(root).unwrap_or(path).display();
    let head = format!("{shown}:{}: «{title}» ({kind}){}", line + 1, case.context);
    case.judge(root, &head, before, &after, &applied.touched);
    if !mends.is_empty() {
        if let Some(finding) =
            mends.iter().find(|finding| after.count(&finding.code) >= before.count(&finding.code))
        {
            case.report.count(case.group, "useless", 1);
            case.report.code("useless", &finding.code);
            case.report.report_offender(
                "useless",
                &format!("{head} keeps {}: {}", finding.code, finding.message),
            );
        }
        if !applied.lost.is_empty() {
            let code = &mends[0].code;
            case.report.count(case.group, "losing text", 1);
            case.report.code("losing text", code);
            let lost = applied.lost.join(" ");
            case.report
                .report_offender("losing text", &format!("{head} for {code} removes: {lost}"));
        }
    }
    Ok(())
}

impl Case<'_> {
    /// Compares findings.
    fn judge(
        &mut self,
        root: &Path,
        head: &str,
        before: &Findings,
        after: &Findings,
        touched: &ChangedLines,
    ) {
        let (worse, revealed) = before.judged(after, touched);
        self.report.count(self.group, "judged", 1);
        self.report.count(self.group, "worse", usize::from(!worse.is_empty()));
        self.report.count(self.group, "revealed", usize::from(!revealed.is_empty()));
        for (kind, found) in [("worse", worse), ("revealed", revealed)] {
            for (path, finding) in found {
                self.report.code(kind, &finding.code);
                let shown = path.strip_prefix(root).unwrap_or(path).display();
                let line = finding.lines[0] + 1;
                let message = finding.message.replace(&format!("{}/", root.display()), "");
                let added = format!("{head} adds {} at {shown}:{line}: {message}", finding.code);
                if kind == "worse" {
                    self.report.report_offender(kind, &added);
                }
            }
        }
    }
}

/// Runs `dotgen check --fix` on a mutated specification.
fn check_fix(
    workspace: &Workspace,
    case: &mut Case<'_>,
    dotgen: &Path,
    path: &Path,
    text: &str,
) -> Result<()> {
    let original = std::fs::read(path).with_context(|| format!("read {}", path.display()))?;
    std::fs::write(path, text)?;
    let run = |fix: bool| -> Result<Findings> {
        let mut command = Command::new(dotgen);
        command.args(["check", "--format", "json"]).arg(path);
        command.args(fix.then_some("--fix")).current_dir(&workspace.copy.root);
        let output = command.output().context("cannot run dotgen check")?;
        let report: Value = serde_json::from_slice(&output.stdout)
            .with_context(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
        let mut out = Findings::default();
        for diagnostic in report["diagnostics"].as_array().into_iter().flatten() {
            let file = workspace.copy.root.join(diagnostic["file"].as_str().unwrap_or_default());
            out.0.entry(file).or_default().push(Finding::read(diagnostic));
        }
        Ok(out)
    };
    let result = (|| {
        let before = run(false)?;
        run(true)?;
        let fixed = std::fs::read_to_string(path)?;
        let after = run(false)?;
        anyhow::Ok((before, after, fixed))
    })();
    std::fs::write(path, original)?;
    let (before, after, fixed) = result?;
    if fixed == text {
        case.report.count(case.group, "nothing fixed", 1);
        return Ok(());
    }
    let differs = |(a, b): &(&str, &str)| a != b;
    let zip = || std::iter::zip(text.lines(), fixed.lines());
    let first = zip().take_while(|lines| !differs(lines)).count();
    let backwards = std::iter::zip(text.lines().rev(), fixed.lines().rev());
    let same = backwards.take_while(|lines| !differs(lines)).count();
    let last = fixed.lines().count().saturating_sub(same).max(first);
    let touched = ChangedLines::from([(path.to_owned(), vec![[first, last]])]);
    let root = &workspace.copy.root;
    let shown = path.strip_prefix(root).unwrap_or(path).display();
    let head = format!("{shown}: `check --fix`{}", case.context);
    case.judge(root, &head, &before, &after, &touched);
    Ok(())
}
