//! The checks of a scenario, each about a single subject.

use crate::diagnostic::Diagnostic;
use crate::property::{PropertyKind, data, resolve};

use crate::scn::ast::{Bound, ChainKind, ChainPath, Check, CheckKind, Path, Pattern, Pred};
use crate::scn::names::Names;
use crate::system::flow;
use crate::system::indexed::Built;
use crate::system::indexed::DeclaredTask;
use crate::system::settings::Settings;

/// A check of a single subject.
pub(super) struct Single<'c> {
    pub(super) check: &'c Check,
    /// Index among the checks of the scenario.
    pub(super) written: usize,
    pub(super) what: What<'c>,
    /// Components that the check is about; empty for all of them.
    pub(super) components: Vec<usize>,
}

impl Single<'_> {
    /// Returns true if the check is about a task, rather than about predicates or the whole system.
    pub(super) fn is_of_task(&self) -> bool {
        self.what.task().is_some()
    }
}

impl What<'_> {
    pub(super) fn kind(&self) -> PropertyKind {
        match self {
            What::Schedulable(_) => PropertyKind::Schedulable,
            What::NoOverdue(_) => PropertyKind::NoOverdue,
            What::Response(..) => PropertyKind::Response,
            What::Within(..) => PropertyKind::Within,
            What::Chain(chain) => match chain.kind {
                ChainKind::Reaction => PropertyKind::Reaction,
                ChainKind::Age => PropertyKind::Age,
            },
            What::LeadsTo(..) => PropertyKind::LeadsTo,
            What::Eventually(_) => PropertyKind::Eventually,
            What::Always(_) => PropertyKind::Always,
            What::Reachable(_) => PropertyKind::Reachable,
            What::Pattern(_) => PropertyKind::Pattern,
            What::Deadlock => PropertyKind::Deadlock,
        }
    }

    /// Returns true if single states do not answer the check, so that it is explored on its own.
    pub(super) fn is_lasting(&self) -> bool {
        matches!(self, What::Chain(_) | What::LeadsTo(..) | What::Eventually(_))
    }

    /// Returns the task of the check.
    pub(super) fn task(&self) -> Option<DeclaredTask> {
        match *self {
            What::Schedulable(pair) | What::NoOverdue(pair) | What::Response(pair, _) => Some(pair),
            _ => None,
        }
    }
}

/// The subject of a check, with `*` expanded.
pub(super) enum What<'c> {
    Schedulable(DeclaredTask),
    NoOverdue(DeclaredTask),
    Response(DeclaredTask, Bound),
    Within(&'c Pred, &'c [Pred], Bound),
    Chain(ChainOf<'c>),
    LeadsTo(&'c Pred, &'c Pred),
    Eventually(&'c Pred),
    Always(&'c Pred),
    Reachable(&'c Pred),
    Pattern(&'c Pattern),
    Deadlock,
}

/// A cause-effect chain.
#[derive(Clone, Copy)]
pub(super) struct ChainOf<'c> {
    pub(super) kind: ChainKind,
    pub(super) path: &'c ChainPath,
    pub(super) bound: Bound,
}

impl<'c> ChainOf<'c> {
    pub(super) fn asked(&self) -> flow::ChainQuery<'c> {
        flow::ChainQuery {
            kind: self.kind,
            from: &self.path.from,
            to: &self.path.to,
            via: &self.path.via,
        }
    }
}

/// The message for a predicate that holds when a moment is over.
const MOMENT_IS_OVER: &str = "this check asks for the time after a moment (`tick`, in a pattern also `leave`); \
    ask for what holds at the moment, such as `never TASK.tick and P`";

/// Expands checks of `*` to one per task.
pub(super) fn expand<'c>(
    names: &Names,
    whole: &Built,
    settings: &'c Settings,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Single<'c>> {
    let mut out = Vec::new();
    let tasks = |path: &Option<Path>, periodic: bool| -> Result<Vec<DeclaredTask>, Diagnostic> {
        let has_period = |task: &DeclaredTask| {
            names.components[task.component].component.tasks[task.index].period.is_some()
        };
        if let Some(path) = path {
            let task = resolve::task(names, path)?;
            if periodic && !has_period(&task) {
                let message =
                    format!("`{}` has no period, so this does not apply to it", path.text());
                return Err(Diagnostic::error("scn-aperiodic", path.range(), message));
            }
            return Ok(vec![task]);
        }
        let all = names.components.iter().enumerate().flat_map(|(component, member)| {
            let indices = member.component.tasks.keys();
            indices.map(move |index| DeclaredTask { component, index })
        });
        Ok(all.filter(|task| !periodic || has_period(task)).collect())
    };
    for (written, check) in settings.checks.iter().enumerate() {
        if whole.data.is_none()
            && let Some(comparison) = check.kind.comparisons().next()
        {
            let errors = check.kind.comparisons();
            let errors: Vec<_> =
                errors.filter_map(|of| data::resolve(names, whole, of).err()).collect();
            if errors.is_empty() {
                diagnostics.push(data::not_in_model(comparison));
            }
            diagnostics.extend(errors);
            continue;
        }
        let mut push = |what, components| out.push(Single { check, written, what, components });
        let mut of_tasks = |path, is_periodic, what: &dyn Fn(DeclaredTask) -> What<'c>| {
            for task in tasks(path, is_periodic)? {
                push(what(task), vec![task.component]);
            }
            Ok(())
        };
        let result: Result<(), Diagnostic> = match &check.kind {
            CheckKind::Schedulable(path) => of_tasks(path, true, &What::Schedulable),
            CheckKind::NoOverdue(path) => of_tasks(path, true, &What::NoOverdue),
            CheckKind::Response(path, bound) => {
                of_tasks(path, false, &|task| What::Response(task, *bound))
            }
            CheckKind::Chain(kind, path, bound) => {
                let chain_of = ChainOf { kind: *kind, path, bound: *bound };
                flow::chain(names, settings, whole, &chain_of.asked())
                    .map(|found| push(What::Chain(chain_of), found.components))
            }
            kind => {
                let components = components_of_predicates(names, whole, check, diagnostics);
                let what = match kind {
                    CheckKind::Within(p, responses, bound) => What::Within(p, responses, *bound),
                    CheckKind::LeadsTo(p, q) => What::LeadsTo(p, q),
                    CheckKind::Eventually(p) => What::Eventually(p),
                    CheckKind::Always(p) => What::Always(p),
                    CheckKind::Reachable(p) => What::Reachable(p),
                    CheckKind::Pattern(pattern) => What::Pattern(pattern),
                    _ => What::Deadlock,
                };
                push(what, components);
                Ok(())
            }
        };
        if let Err(error) = result {
            diagnostics.push(error);
        }
    }
    if settings.checks.is_empty() {
        let message = "the scenario checks nothing; add `check schedulable *;`".to_owned();
        diagnostics.push(Diagnostic::warning("scn-no-check", 0..0, message));
    }
    out
}

/// Returns the components that the predicates of a check are about, and reports the errors in them.
fn components_of_predicates(
    names: &Names,
    whole: &Built,
    check: &Check,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<usize> {
    let mut components = Vec::new();
    let negated = matches!(check.kind, CheckKind::Always(_));
    let leaves = matches!(check.kind, CheckKind::Pattern(_));
    for pred in check.kind.predicates() {
        match resolve::resolve(names, whole, pred) {
            Ok(predicate) if predicate.needs_no_moment(negated, leaves) => {
                let message = MOMENT_IS_OVER.to_owned();
                let range = check.range.clone();
                diagnostics.push(Diagnostic::error("scn-wrong-status", range, message));
            }
            Ok(_) => {}
            Err(error) => diagnostics.push(error),
        }
        resolve::components_of(names, whole, pred, &mut components);
    }
    components
}
