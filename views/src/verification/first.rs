//! The first answers for a specification without a scenario: about its permanent activities, then about each
//! activity alone. They are exact and quick, and each names its assumption. The answer for any client at any
//! time comes later.

use dotgen_analysis::model::ServiceKind;
use dotgen_timing::report::Report;
use dotgen_timing::scn::ast::{
    Client, Ending, Interval, Item, Path, Spanned, Step, StepKind, Unit,
};
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::{Cancel, Options};
use serde::Serialize;

use super::Problem;
use super::view::{CheckView, View};
use dotgen_timing::report::Verdict;

/// Maximum number of states explored for one of them.
const STATES: usize = 4_000;

/// Maximum number of activities that are each looked at alone; with more, none is.
const MOST_ALONE: usize = 12;

/// A result under an assumption about requests.
#[derive(Debug, Clone, Serialize)]
pub struct FirstAnswer {
    /// The assumed requests.
    pub assuming: String,
    #[serde(serialize_with = "counted")]
    pub outcome: Verdict,
    /// The checks that fail or are not settled.
    pub open: Vec<String>,
}

fn counted<S: serde::Serializer>(outcome: &Verdict, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(outcome.counted())
}

/// The first answers, in order of exploration; none if there is a scenario, or if no request is possible.
pub fn answers(problem: &Problem, options: &Options, cancel: &Cancel) -> Vec<FirstAnswer> {
    if problem.is_written() {
        return Vec::new();
    }
    let activities = activities(problem);
    if activities.is_empty() {
        return Vec::new();
    }
    let few = activities.len() <= MOST_ALONE;
    let mut options = options.clone();
    options.limits.states = options.limits.states.min(STATES);
    let permanent = ("permanent activities only, no requests".to_owned(), None);
    let alone = activities.into_iter();
    let alone = alone.filter(|_| few).map(|activity| {
        let assuming = format!("{activity} alone, requested again at any time after it has ended");
        (assuming, Some(activity))
    });
    let mut out = Vec::new();
    for (assuming, activity) in std::iter::once(permanent).chain(alone) {
        if cancel.is_over() {
            break;
        }
        let varied = with_repeated_request(problem, activity.as_deref());
        let report = varied.verify(&options, cancel, &|_| {});
        out.push(answer(assuming, &varied, &options, &report));
    }
    out
}

fn answer(assuming: String, problem: &Problem, options: &Options, report: &Report) -> FirstAnswer {
    let view = View::new(problem, options, report, &[]);
    let open = |outcome: &Verdict| *outcome != Verdict::Proved;
    let worst = [
        Verdict::Refuted,
        Verdict::Exceeds,
        Verdict::Bounded,
        Verdict::Unknown,
        Verdict::Open,
        Verdict::Vacuous,
        Verdict::Nothing,
        Verdict::Conditional,
    ];
    let has = |outcome: &Verdict| view.checks.iter().any(|check| check.verdict == *outcome);
    let outcome = worst.into_iter().find(has).unwrap_or(Verdict::Proved);
    let checks = view.checks.iter().filter(|check| open(&check.verdict));
    FirstAnswer { assuming, outcome, open: checks.map(CheckView::title).collect() }
}

/// The activities that can be executed, as `component.activity`.
fn activities(problem: &Problem) -> Vec<String> {
    let specs = problem.specs();
    let names = Names::new(&specs);
    let all = names.components.iter().flat_map(|component| {
        let services = component.component.services.iter();
        let activities = services
            .filter(|service| service.kind == ServiceKind::Activity && service.task.is_some());
        let name = &component.component.name;
        activities.map(move |activity| format!("{name}.{}", activity.name))
    });
    all.collect()
}

/// The problem with a client that requests one activity repeatedly, each time after the end of the instance
/// before, or with no client. Several instances at once are left to the check with any client, which seldom
/// is quick.
fn with_repeated_request(problem: &Problem, activity: Option<&str>) -> Problem {
    let mut out = problem.clone();
    let items = &mut out.scenario.items;
    items.retain(|item| !matches!(item, Item::Client(_)));
    if let Some(activity) = activity {
        // The services in `after` are requested first; otherwise the request would be rejected.
        items.push(Item::Order(false));
        let step = |kind| Step { label: None, kind, range: 0..0 };
        let any_time = Interval { lower: 0, upper: None };
        let body = vec![
            step(StepKind::Delay(any_time, Unit::Milliseconds)),
            step(StepKind::Send(Path::of(activity))),
            step(StepKind::AwaitEnded(Ending::Any, None)),
        ];
        items.push(Item::Client(Client {
            name: Spanned { value: "alone".to_owned(), range: 0..0 },
            steps: vec![step(StepKind::Repeat(None, body))],
            trigger: None,
        }));
    }
    out
}
