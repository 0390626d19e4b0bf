//! `dotgen wcet import`

mod given;
mod output;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use anyhow::{bail, ensure};
use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, ValueEnum};
use dotgen_analysis::diagnostic::{FileEdit, Severity};
use dotgen_analysis::host::{Change, FileContent, UnitResult};
use dotgen_analysis::language;
use dotgen_analysis::model::{CodelRef, Seconds};
use dotgen_analysis::source_map::{Location, Locations};
use dotgen_recording::edits::{self, NewWcet, Refusal, WcetForm};
use dotgen_recording::log::{LineKind, SkippedLines};
use dotgen_recording::matching::{Mismatch, Site, path};
use dotgen_recording::measurements::{ExecutionTimes, LogMeasurements};
use dotgen_recording::proposal::{Decision, Margin, decide, micros, seconds};
use dotgen_timing::scn::ast::{Item, Scenario};
use dotgen_timing::scn::names::Names;
use num_rational::Ratio;

use self::given::Given;
use super::{input_files, read_log};
use crate::report::TextOrJson;
use crate::session::{Session, display};
use crate::verify::one_problem;
use crate::{CommandExit, SpecificationOptions, fmt, report};
use dotgen_platform::files::vfs;
use dotgen_views::verification::Problem;

/// Write measured execution times into a specification
///
/// Each measured codel gets its longest time, multiplied by the margin and rounded up to two digits. A file
/// of worst cases (NAME.wcet: each line has the function of a codel and its time in seconds) is taken as it
/// is, without a margin. Existing times are only raised; `--replace` lowers them too. Nothing else changes:
/// bytes, line ends and comments stay.
///
/// Exit status: 0 if all times are written, 1 if some must be written by hand, 2 if nothing could be done.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Logs of GenoM3's profiler (`-` is standard input) or files of worst cases (.wcet), and a specification
    /// (.gen) or scenario (.scn)
    /// [default: the only specification in the current directory]
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    /// Specification or scenario, if not among the FILEs
    #[arg(long, value_name = "FILE")]
    spec: Vec<Utf8PathBuf>,

    /// Factor for the longest measured time
    #[arg(long, value_name = "FACTOR", default_value = "1.2", value_parser = Margin::parse)]
    margin: Margin,

    /// Form of new times
    #[arg(long = "as", value_enum, default_value_t = FormName::Clause)]
    form: FormName,

    /// Also replace times that are longer than the proposed ones
    #[arg(long)]
    replace: bool,

    /// Write nothing; print the changes
    #[arg(long, visible_alias = "dry-run")]
    diff: bool,

    /// Output format
    #[arg(long, value_enum, default_value_t = TextOrJson::Text)]
    format: TextOrJson,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormName {
    /// `wcet 1 ms` in the declaration of the codel
    Clause,
    /// `#pragma wcet CODEL 1 ms`, which genom3 ignores
    Pragma,
    /// `duration PATH [0,1000] us;` in the scenario, for each state
    Sidecar,
}

/// A codel in one of its states.
struct Row {
    path: String,
    /// The place of the declaration of the codel.
    place: Option<Location>,
    function: String,
    measure: ExecutionTimes,
    declared: Option<Seconds>,
    proposed: Option<u64>,
    decision: Decision,
}

/// The result of an import.
struct Answer {
    /// Result of files of worst cases; `None` if logs were read.
    given: Option<Given>,
    logs: Vec<Utf8PathBuf>,
    rows: Vec<Row>,
    strays: Vec<(LineKind, Mismatch, u64)>,
    /// Simulated codels, with the number of their executions.
    simulated: BTreeMap<String, u64>,
    left: SkippedLines,
    refused: Vec<(String, Refusal)>,
    edits: Vec<FileEdit>,
    /// Original and new texts, by file.
    changed: BTreeMap<Utf8PathBuf, (String, String)>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let mut files = input_files(&arguments.files)?;
    files.texts.extend(arguments.spec.iter().cloned());
    if files.texts.is_empty() {
        files.texts.push(only_specification()?);
    }
    let Some((mut session, problem)) = one_problem(&files.texts, &arguments.reading)? else {
        return Ok(CommandExit::Unusable);
    };
    let is_scenario = problem.is_written();
    ensure!(
        is_scenario || arguments.form != FormName::Sidecar,
        "`--as sidecar` writes into a scenario: name one (.scn) that uses the specification"
    );
    let answer = answer(arguments, &mut session, &problem, files.logs)?;
    if arguments.diff && arguments.format == TextOrJson::Text {
        for (path, (old, new)) in &answer.changed {
            fmt::print_diff(&display(path), old, new)?;
        }
    }
    match arguments.format {
        TextOrJson::Json => output::print_json(&answer)?,
        TextOrJson::Text => output::print(&answer, arguments.diff)?,
    }
    if !arguments.diff {
        let files = answer.changed.iter();
        let files = files.map(|(path, (old, new))| report::edited(path, Some(old), new)).collect();
        report::write_files(files, &session.writable())?;
    }
    Ok(if answer.refused.is_empty() { CommandExit::Fine } else { CommandExit::Errors })
}

/// Returns the only specification of the current directory.
fn only_specification() -> anyhow::Result<Utf8PathBuf> {
    let entries = std::fs::read_dir(".")?.flatten();
    let paths = entries.filter_map(|entry| Utf8PathBuf::from_path_buf(entry.path()).ok());
    let mut all = paths.filter(|path| language::is_specification(path) && path.is_file());
    match (all.next(), all.next()) {
        (Some(only), None) => Ok(only),
        (None, _) => bail!("no specification is here: name one (.gen), or a scenario (.scn)"),
        _ => bail!("several specifications are here: name the one that was measured"),
    }
}

fn answer(
    arguments: &Arguments,
    session: &mut Session,
    problem: &Problem,
    logs: Vec<Utf8PathBuf>,
) -> anyhow::Result<Answer> {
    let specs = problem.specs();
    let names = Names::new(&specs);
    let given = given::read(&logs)?;
    let mut measured = LogMeasurements::default();
    if given.is_none() {
        for (file, log) in logs.iter().enumerate() {
            read_log(log, |number, line, ended| measured.line(file, number, line, ended))?;
        }
    }
    let mut found = measured.found(&names);
    let given = given.map(|times| Given::assign(&times, &names, &mut found.sites)).transpose()?;
    let margin = given.is_none().then_some(arguments.margin);
    let (rows, wanted) = rows(arguments, margin, problem, &names, found.sites);
    let is_measured = rows.iter().any(|row| row.measure.runs > 0);
    ensure!(
        is_measured || found.simulated.is_empty(),
        "these times were simulated, not measured: nothing to import; run the codels with `dotgen run --clock \
         real --profile FILE`"
    );
    if !is_measured {
        let strays: u64 = found.strays.iter().map(|stray| stray.2).sum();
        let why = match (strays, measured.left.total()) {
            (0, 0) => "the log is empty".to_owned(),
            (0, n) => format!("none of its {n} lines is one of a codel"),
            (n, _) => format!("its {n} runs are of other components or other codels"),
        };
        bail!("no codel of the specification was measured: {why}");
    }
    let mut answer = Answer {
        given,
        logs,
        rows,
        strays: found.strays,
        simulated: found.simulated,
        left: measured.left,
        refused: Vec::new(),
        edits: Vec::new(),
        changed: BTreeMap::new(),
    };
    let form = match arguments.form {
        FormName::Sidecar => {
            edit_scenario(&mut answer, problem, &names, &wanted)?;
            return Ok(answer);
        }
        FormName::Pragma => WcetForm::Pragma,
        FormName::Clause => WcetForm::Clause,
    };
    let mut of_units: Vec<Vec<NewWcet>> =
        (0..problem.units.len()).map(|unit| of_unit(problem, &names, unit, &wanted)).collect();
    unify_declarations(&problem.units, &mut of_units);
    edit_specifications(&mut answer, problem, &of_units, form)?;
    for (unit, of_unit) in problem.units.iter().zip(&of_units) {
        check_unit(session, unit, of_unit, &answer)?;
    }
    Ok(answer)
}

/// Returns a row for each codel, and the times to write, in microseconds.
fn rows(
    arguments: &Arguments,
    margin: Option<Margin>,
    problem: &Problem,
    names: &Names<'_>,
    sites: Vec<(Site, ExecutionTimes)>,
) -> (Vec<Row>, Vec<(Site, u64)>) {
    let sidecar = arguments.form == FormName::Sidecar;
    // A declaration applies to all of its states: the greatest time counts.
    let mut greatest: BTreeMap<(usize, CodelRef), i64> = BTreeMap::new();
    for (site, measure) in sites.iter().filter(|site| site.1.runs > 0) {
        let entry = greatest.entry((site.component, site.codel)).or_default();
        *entry = measure.greatest.max(*entry);
    }
    let (mut rows, mut wanted) = (Vec::new(), Vec::new());
    for (site, measure) in sites {
        let Some(member) = names.components.get(site.component) else {
            continue;
        };
        let codel = member.component.codel(site.codel);
        let of = if sidecar {
            (measure.runs > 0).then_some(measure.greatest)
        } else {
            greatest.get(&(site.component, site.codel)).copied()
        };
        let path = path(names, &site);
        let of_scenario = sidecar.then(|| declared_bound(&problem.scenario, &path)).flatten();
        let declared = match of_scenario {
            Some(upper) => upper,
            None => codel.wcet.as_ref().map(|wcet| wcet.value),
        };
        let proposed = of.map(|number| match margin {
            Some(margin) => micros(number, margin),
            None => given::micros(number),
        });
        // A duration without an upper bound is greater than any other.
        let endless = of_scenario == Some(None);
        let decision = if endless && proposed.is_some() && !arguments.replace {
            Decision::Kept
        } else {
            decide(declared, proposed, arguments.replace)
        };
        if let (true, Some(micros)) = (decision.must_write(), proposed) {
            wanted.push((site.clone(), micros));
        }
        let unit = problem.units.get(member.spec_index);
        rows.push(Row {
            place: unit.and_then(|unit| unit.locations.locate(codel.node)),
            path,
            function: codel.name.to_string(),
            measure,
            declared,
            proposed,
            decision,
        });
    }
    (rows, wanted)
}

/// Writes the times into the scenario.
fn edit_scenario(
    answer: &mut Answer,
    problem: &Problem,
    names: &Names<'_>,
    wanted: &[(Site, u64)],
) -> anyhow::Result<()> {
    let times = wanted.iter().map(|(site, micros)| (path(names, site), *micros));
    let times: Vec<(String, u64)> = times.collect();
    let text = text(&problem.path).unwrap_or_default();
    let edits = edits::scenario(&problem.path, &text, &problem.scenario, &times);
    change(answer, &problem.path, &text, &edits);
    check_scenario(answer, problem, &times)
}

/// Returns the times that belong into one unit.
fn of_unit(
    problem: &Problem,
    names: &Names<'_>,
    index: usize,
    wanted: &[(Site, u64)],
) -> Vec<NewWcet> {
    let mut out: Vec<NewWcet> = Vec::new();
    for (site, micros) in wanted {
        let Some(member) = names.components.get(site.component) else {
            continue;
        };
        let components = &problem.units[index].spec.components;
        let place = components.position(|component| std::ptr::eq(component, member.component));
        if let (true, Some(place)) = (member.spec_index == index, place) {
            out.push(NewWcet { component: place, codel: site.codel, micros: *micros });
        }
    }
    out.dedup();
    out
}

/// Writes the times into the specifications. A file that several specifications include is edited once.
fn edit_specifications(
    answer: &mut Answer,
    problem: &Problem,
    of_units: &[Vec<NewWcet>],
    form: WcetForm,
) -> anyhow::Result<()> {
    let mut all: Vec<FileEdit> = Vec::new();
    for (unit, of_unit) in problem.units.iter().zip(of_units) {
        let written = edits::specification(unit, &text, of_unit, form);
        for refused in written.refused {
            if !answer.refused.contains(&refused) {
                answer.refused.push(refused);
            }
        }
        all.extend(written.edits);
    }
    all.sort_by_cached_key(|edit| {
        let (range, text) = (&edit.range, &edit.new_text);
        (edit.path.clone(), range.start, range.end, text.clone())
    });
    all.dedup();
    for edits in all.chunk_by(|a, b| a.path == b.path) {
        let Some(first) = edits.first() else { continue };
        // Several pragmas may stand at one place, such as the end of a file.
        let apart = |edits: &[FileEdit]| match edits {
            [a, b] => {
                let lines = form == WcetForm::Pragma && a.range.is_empty();
                a.range.end <= b.range.start && (lines || a.range != b.range)
            }
            _ => true,
        };
        ensure!(
            edits.windows(2).all(apart),
            "two specifications want different times at one place of `{}`; import the logs for one of them \
                at a time",
            display(&first.path)
        );
        let old = text(&first.path).unwrap_or_default();
        change(answer, &first.path, &old, edits);
    }
    Ok(())
}

/// Gives each shared declaration the greatest time of all specifications that include it, such as that of an
/// interface. The same holds for a function with several uses, because a pragma applies to a function.
fn unify_declarations(units: &[UnitResult], wanted: &mut [Vec<NewWcet>]) {
    let place = |unit: &UnitResult, wcet: &NewWcet| {
        let codel = (unit.spec.components.get(wcet.component)?).codel(wcet.codel);
        let place = unit.locations.locate(codel.node)?;
        Some((codel.name.to_string(), (place.path, place.range.start)))
    };
    type Place = (Utf8PathBuf, usize);
    let mut of_places: BTreeMap<Place, (BTreeSet<usize>, String)> = BTreeMap::new();
    for (number, (unit, wanted)) in units.iter().zip(&*wanted).enumerate() {
        for (function, place) in wanted.iter().filter_map(|wcet| place(unit, wcet)) {
            let entry = of_places.entry(place).or_insert((BTreeSet::new(), function));
            entry.0.insert(number);
        }
    }
    let shared = of_places.into_values().filter(|place| place.0.len() > 1);
    let shared: BTreeSet<String> = shared.map(|place| place.1).collect();
    let mut greatest: BTreeMap<&str, u64> = BTreeMap::new();
    let name = |unit: &UnitResult, wcet: &NewWcet| {
        let name = place(unit, wcet).map(|place| place.0)?;
        shared.get(&name).map(String::as_str)
    };
    for (unit, wanted) in units.iter().zip(&*wanted) {
        for wcet in wanted {
            if let Some(name) = name(unit, wcet) {
                let entry = greatest.entry(name).or_default();
                *entry = wcet.micros.max(*entry);
            }
        }
    }
    for (unit, wanted) in units.iter().zip(wanted) {
        for wcet in wanted {
            let most = name(unit, wcet).and_then(|name| greatest.get(name));
            wcet.micros = most.map_or(wcet.micros, |&most| most.max(wcet.micros));
        }
    }
}

/// Returns the upper bound that a scenario gives a codel, if there is one.
fn declared_bound(scenario: &Scenario, codel: &str) -> Option<Option<Seconds>> {
    scenario.items.iter().find_map(|item| match item {
        Item::Duration(path, interval, unit) if path.text() == codel => {
            let upper = interval.upper;
            Some(upper.map(|number| unit.seconds() * Ratio::from_integer(i128::from(number))))
        }
        _ => None,
    })
}

fn text(path: &Utf8Path) -> Option<Arc<str>> {
    match vfs::read(path) {
        FileContent::Text(text) | FileContent::NotUtf8(text) => Some(text.into()),
        _ => None,
    }
}

fn change(answer: &mut Answer, path: &Utf8Path, old: &str, edits: &[FileEdit]) {
    if edits.is_empty() {
        return;
    }
    let new = edits::apply_edits(old, edits);
    answer.edits.extend(edits.iter().cloned());
    let entry = answer.changed.entry(path.to_owned());
    entry.or_insert_with(|| (old.to_owned(), new));
}

/// Reads the new specification, and checks that it is the same except for the new times.
fn check_unit(
    session: &mut Session,
    unit: &UnitResult,
    wanted: &[NewWcet],
    answer: &Answer,
) -> anyhow::Result<()> {
    let Some(root) = unit.files.first().filter(|_| !answer.changed.is_empty()) else {
        return Ok(());
    };
    let files = answer.changed.iter();
    let files = files.map(|(path, (_, new))| (path.clone(), Some(new.clone())));
    session.host_mut().apply(Change { files: files.collect(), ..Change::default() });
    let new = session.ask(root, |analysis| analysis.root_unit(root))?;
    let errors = |unit: &UnitResult| {
        let all = unit.diagnostics.iter();
        all.filter(|diagnostic| diagnostic.severity == Severity::Error).count()
    };
    let refused = |name: &str| answer.refused.iter().any(|entry| entry.0 == name);
    for wcet in wanted {
        let component = new.spec.components.get(wcet.component);
        let Some(component) = component.filter(|of| of.all_codels().any(|one| one == wcet.codel))
        else {
            bail!("writing the times would change the specification; nothing was written");
        };
        let codel = component.codel(wcet.codel);
        let time = codel.wcet.as_ref().map(|quantity| quantity.value);
        // A pragma for several uses has the greatest time.
        if !refused(&codel.name) && time.is_none_or(|time| time < seconds(wcet.micros)) {
            bail!(
                "the time of `{}` cannot be written where it is declared; write it by hand",
                codel.name
            );
        }
    }
    ensure!(
        errors(&new) <= errors(unit),
        "writing the times would make errors in `{}`; nothing was written",
        display(root)
    );
    Ok(())
}

/// Checks a new scenario in the same way.
fn check_scenario(
    answer: &Answer,
    problem: &Problem,
    times: &[(String, u64)],
) -> anyhow::Result<()> {
    let Some((_, new)) = answer.changed.get(&problem.path) else {
        return Ok(());
    };
    let parsed = dotgen_timing::scn::parse(new);
    let stands = |(codel, micros): &(String, u64)| {
        declared_bound(&parsed.scenario, codel) == Some(Some(seconds(*micros)))
    };
    ensure!(
        parsed.errors.is_empty() && times.iter().all(stands),
        "the times cannot be written into `{}`, for example because a comment stands within a `duration`; nothing was \
         written: write them by hand",
        display(&problem.path)
    );
    Ok(())
}
