//! The verification problems of documents.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Cancellable, FileContent};
use dotgen_analysis::language;
use dotgen_analysis::model::{CodelKind, Spec};
use dotgen_timing::scn;

use crate::workspace::snapshot::Snapshot;
use dotgen_platform::files::vfs;
use dotgen_views::verification::Problem;
use dotgen_views::verification::problem;
use dotgen_views::verification::results::Entry;

/// Maximum number of scenarios that are verified without being open, because they use an open specification.
const MAX_CLOSED_SCENARIOS: usize = 8;

/// A problem to verify.
pub(crate) struct VerificationRequest {
    pub(crate) path: Utf8PathBuf,
    pub(crate) version: Option<i32>,
    pub(crate) problem: Problem,
}

/// The problems of the open documents: open scenarios; scenarios of the workspace that use an open
/// specification; open specifications with timing that no such scenario uses.
pub(crate) fn wanted(snapshot: &Snapshot) -> Cancellable<Vec<VerificationRequest>> {
    let mut out: Vec<VerificationRequest> = Vec::new();
    let mut open: Vec<_> = snapshot.open.keys().collect();
    open.sort();
    let version = |path: &Utf8Path| snapshot.open.get(path).map(|file| file.version);
    for path in open.iter().filter(|path| language::is_scenario(path)) {
        let problem = problem_of(snapshot, path)?;
        out.extend(problem.map(|problem| VerificationRequest {
            path: (*path).clone(),
            version: version(path),
            problem,
        }));
    }
    let mut unopened = 0;
    for path in snapshot.scenarios.iter() {
        if snapshot.open.contains_key(path) || unopened == MAX_CLOSED_SCENARIOS {
            continue;
        }
        let FileContent::Text(text) = vfs::read(path) else {
            continue;
        };
        let files = problem::used(&scn::parse(&text).scenario, path);
        if files.iter().any(|file| snapshot.open.contains_key(&file.path)) {
            unopened += 1;
            let problem = scenario(snapshot, path, text)?;
            out.push(VerificationRequest { path: path.clone(), version: None, problem });
        }
    }
    let specifications = open.iter().filter(|path| language::is_specification(path));
    for &path in specifications {
        if out.iter().any(|request| request.problem.uses(path)) {
            continue;
        }
        if let Some(problem) = problem_of(snapshot, path)?
            && (problem.units.iter().any(|unit| is_timed(&unit.spec)) || !problem.times.is_empty())
        {
            out.push(VerificationRequest { path: path.clone(), version: version(path), problem });
        }
    }
    Ok(out)
}

/// The problem of one document: a scenario as written, or a specification with the default scenario
/// on the configured platform.
pub(crate) fn problem_of(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Option<Problem>> {
    if language::is_scenario(path) {
        let Some(text) = snapshot.analysis.text(path)? else {
            return Ok(None);
        };
        return scenario(snapshot, path, text.to_string()).map(Some);
    }
    if !language::is_specification(path) {
        return Ok(None);
    }
    let unit = snapshot.analysis.root_unit(path)?;
    let name = path.file_name().unwrap_or_default().to_owned();
    let platform = scn::Platform {
        cores: snapshot.config.lints.cores.filter(|&core| core > 0),
        policy: snapshot.config.verification.policy(),
        semantics: snapshot.config.verification.semantics(),
    };
    Ok(Some(Problem::default_scenario_on(platform, path, &[name], vec![unit], vfs::read)))
}

/// A scenario and the specifications it uses, open documents included.
pub(crate) fn scenario(snapshot: &Snapshot, path: &Utf8Path, text: String) -> Cancellable<Problem> {
    let exists = |file: &Utf8Path| {
        if snapshot.open.contains_key(file) {
            FileContent::Text(String::new())
        } else {
            vfs::read(file)
        }
    };
    Problem::from_scenario(path, text, &snapshot.analysis, exists)
}

/// True if a specification has timing: a period, and the duration of a codel.
fn is_timed(spec: &Spec) -> bool {
    problem::components(spec).any(|component| {
        component.tasks.iter().any(|task| task.period.is_some())
            && component.all_codels().any(|codel| {
                let codel = component.codel(codel);
                codel.kind == CodelKind::Fsm && codel.wcet.is_some()
            })
    })
}

/// The verifications of a document: its own, else those of the scenarios that use it.
pub(crate) fn about<'s>(
    snapshot: &'s Snapshot,
    path: &'s Utf8Path,
) -> Vec<(&'s Utf8Path, &'s Entry)> {
    let all = &snapshot.verification;
    if let Some(entry) = all.get(path) {
        return vec![(path, entry)];
    }
    let uses = all.iter().filter(|(_, entry)| entry.problem.reads(path));
    uses.map(|(path, entry)| (path.as_path(), entry)).collect()
}
