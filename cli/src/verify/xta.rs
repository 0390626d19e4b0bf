//! `dotgen verify --xta`: queries about networks of timed automata.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{anyhow, bail};
use camino::Utf8Path;
use dotgen_xta::{Answer, Error, Extreme, Limits, Query, Reason, Trace, Value};
use serde_json::json;

use super::Arguments;
use super::interrupt;
use crate::outputs;
use crate::report::TextOrJson;
use crate::width::{Table, wrapped};
use crate::{CommandExit, session};

/// Time between two looks at the limit of time and at the interruption of the user.
const POLL: Duration = Duration::from_millis(20);

/// Greatest size of a model, in megabytes.
const MAX_MEGABYTES: usize = 16;

/// Most steps of a trace that are shown.
const MAX_STEPS: usize = 200;

pub(super) fn run(file: &Utf8Path, arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let network =
        dotgen_xta::read(&session::text(file, MAX_MEGABYTES)?).map_err(|error| at(file, &error))?;
    let queries = if arguments.checks.is_empty() {
        let path = file.with_extension("q");
        if !path.exists() {
            bail!("`{path}` is missing; give queries with `--check 'A[] …'`");
        }
        dotgen_xta::queries(&session::text(&path, 1)?).map_err(|error| at(&path, &error))?
    } else {
        let given = Utf8Path::new("--check");
        dotgen_xta::queries(&arguments.checks.join("\n")).map_err(|error| at(given, &error))?
    };
    for query in &queries {
        network.check(query).map_err(|error| anyhow!("in `{}`: {error}", query.text))?;
    }
    let flag = Arc::new(AtomicBool::new(false));
    let limits = Limits {
        states: (arguments.max_states.unwrap_or(Limits::default().states))
            .min((arguments.max_memory.saturating_mul(1 << 20)) / network.state_bytes()),
        cancel: Some(flag.clone()),
    };
    let interrupt = interrupt::on_terminal();
    let ended = AtomicBool::new(false);
    let answers: Vec<(&Query, Answer)> = std::thread::scope(|scope| {
        scope.spawn(|| {
            let begun = Instant::now();
            while !ended.load(Ordering::Relaxed) {
                let late = arguments.timeout.is_some_and(|limit| begun.elapsed() >= limit);
                if late || interrupt.is_raised() {
                    flag.store(true, Ordering::Relaxed);
                }
                std::thread::sleep(POLL);
            }
        });
        let answers = queries.iter().map(|query| (query, network.answer(query, &limits)));
        let answers = answers.collect();
        ended.store(true, Ordering::Relaxed);
        answers
    });
    match arguments.format {
        TextOrJson::Text => print(&answers)?,
        TextOrJson::Json => {
            let all: Vec<serde_json::Value> = answers.iter().map(to_json).collect();
            outputs::print_json(&json!({ "queries": all }))?;
        }
    }
    Ok(outcome(&answers))
}

fn at(path: &Utf8Path, error: &Error) -> anyhow::Error {
    anyhow!("{path}:{error}")
}

fn outcome(answers: &[(&Query, Answer)]) -> CommandExit {
    let any = |wanted: fn(&Answer) -> bool| answers.iter().any(|(_, answer)| wanted(answer));
    if any(|answer| matches!(answer, Answer::Fails { .. } | Answer::Invalid { .. })) {
        CommandExit::Errors
    } else if any(|answer| matches!(answer, Answer::Refused(_))) {
        CommandExit::Unusable
    } else if any(|answer| matches!(answer, Answer::GaveUp { .. })) {
        CommandExit::GaveUp
    } else {
        CommandExit::Fine
    }
}

/// The word for an answer, its value, and what is to be said of it.
fn words(answer: &Answer) -> (&'static str, String, String) {
    match answer {
        Answer::Holds { .. } => ("holds", String::new(), String::new()),
        Answer::Fails { .. } => ("fails", String::new(), String::new()),
        Answer::Values { values, .. } => {
            let values: Vec<String> = values.iter().map(value).collect();
            ("value", values.join(", "), String::new())
        }
        Answer::GaveUp { reason, states } => {
            let why = match reason {
                Reason::States(limit) => format!("more than {limit} symbolic states"),
                Reason::Cancelled => format!("stopped after {states} symbolic states"),
                Reason::Clock(limit) => format!("a clock may exceed {limit}"),
            };
            ("gave up", String::new(), why)
        }
        Answer::Refused(why) => ("refused", String::new(), why.clone()),
        Answer::Invalid { message, .. } => ("error", String::new(), message.clone()),
    }
}

fn value(extreme: &Extreme) -> String {
    match extreme.value {
        None => "none".to_owned(),
        Some(Value::Infinite) => "unbounded".to_owned(),
        Some(Value::Finite { value, attained: true }) => value.to_string(),
        Some(Value::Finite { value, attained: false }) => format!("{value} (not reached)"),
    }
}

fn trace(answer: &Answer) -> Option<&Trace> {
    match answer {
        Answer::Holds { trace, .. }
        | Answer::Fails { trace, .. }
        | Answer::Invalid { trace, .. } => trace.as_ref(),
        _ => None,
    }
}

fn print(answers: &[(&Query, Answer)]) -> std::io::Result<()> {
    let mut out = anstream::stdout().lock();
    let rows: Vec<[String; 3]> = answers
        .iter()
        .map(|(query, answer)| {
            let (word, value, _) = words(answer);
            [word.to_owned(), query.text.clone(), value]
        })
        .collect();
    let head = ["answer", "query", "value"].map(str::to_owned);
    let rows: Vec<[&str; 3]> = std::iter::once(&head)
        .chain(&rows)
        .map(|[one, two, three]| [one.as_str(), two.as_str(), three.as_str()])
        .collect();
    let table = Table { texts: 2, long: 1, indent: 2 };
    for line in table.lines(&rows) {
        writeln!(out, "{line}")?;
    }
    for (query, answer) in answers {
        let (word, _, why) = words(answer);
        if !why.is_empty() {
            writeln!(out, "\n{}", wrapped(&format!("{word} {}: {why}", query.text), 0, 2))?;
        }
        // The trace of what fails, and of what was looked for.
        let Some(trace) = trace(answer) else { continue };
        writeln!(out, "\n{}", wrapped(&format!("{word} {}", query.text), 0, 2))?;
        for step in trace.steps.iter().take(MAX_STEPS) {
            let changes = step.changes.iter();
            let changes = changes.map(|change| format!("{} := {}", change.variable, change.after));
            let changes: Vec<String> = changes.collect();
            let line = format!("{:>6}  {}  {}", step.time, step.transition, changes.join(", "));
            writeln!(out, "{}", wrapped(line.trim_end(), 0, 8))?;
        }
        if trace.steps.len() > MAX_STEPS {
            writeln!(out, "  … {} more steps, see `--format json`", trace.steps.len() - MAX_STEPS)?;
        }
    }
    Ok(())
}

fn to_json((query, answer): &(&Query, Answer)) -> serde_json::Value {
    let (word, _, why) = words(answer);
    let states = match answer {
        Answer::Holds { states, .. }
        | Answer::Fails { states, .. }
        | Answer::Values { states, .. }
        | Answer::GaveUp { states, .. } => Some(*states),
        Answer::Refused(_) | Answer::Invalid { .. } => None,
    };
    let values = match answer {
        Answer::Values { values, .. } => values.iter().map(value).collect(),
        _ => Vec::new(),
    };
    let steps = trace(answer).map(|trace| {
        let steps = trace.steps.iter().map(|step| {
            let changes = step.changes.iter();
            let changes = changes.map(|change| {
                json!({ "variable": change.variable, "before": change.before, "after": change.after })
            });
            json!({
                "time": step.time,
                "transition": step.transition,
                "channel": step.channel,
                "changes": changes.collect::<Vec<_>>(),
            })
        });
        steps.collect::<Vec<_>>()
    });
    json!({
        "query": query.text,
        "answer": word,
        "values": values,
        "note": (!why.is_empty()).then_some(why),
        "states": states,
        "trace": steps,
    })
}
