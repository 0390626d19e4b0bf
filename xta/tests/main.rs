//! Tests of the reader and of the explorer on small models.

mod errors;
mod functions;
mod queries;
mod random;
mod semantics;

use dotgen_xta::{Answer, Extreme, Limits, Network, Trace, Value, queries, read};

fn network(model: &str) -> Network {
    read(model).unwrap_or_else(|error| panic!("{error}\n{model}"))
}

fn answer(model: &str, query: &str) -> Answer {
    let network = network(model);
    let queries = queries(query).unwrap_or_else(|error| panic!("{error}\n{query}"));
    assert_eq!(queries.len(), 1, "{query}");
    network.check(&queries[0]).unwrap_or_else(|error| panic!("{error}\n{query}"));
    network.answer(&queries[0], &Limits::default())
}

/// Reports whether a query is true.
fn holds(model: &str, query: &str) -> bool {
    match answer(model, query) {
        Answer::Holds { .. } => true,
        Answer::Fails { .. } => false,
        other => panic!("{query}: {other:?}"),
    }
}

fn trace(model: &str, query: &str) -> Trace {
    match answer(model, query) {
        Answer::Holds { trace: Some(trace), .. } | Answer::Fails { trace: Some(trace), .. } => {
            trace
        }
        other => panic!("{query}: {other:?}"),
    }
}

/// The values of `sup` or `inf`, each with whether the value is attained. `None` is infinite.
fn values(model: &str, query: &str) -> Vec<Option<(i64, bool)>> {
    let Answer::Values { values, .. } = answer(model, query) else { panic!("{query}") };
    let value = |extreme: Extreme| match extreme.value {
        Some(Value::Finite { value, attained }) => Some((value, attained)),
        Some(Value::Infinite) => None,
        None => panic!("{query}: no state"),
    };
    values.into_iter().map(value).collect()
}

/// The message of a model with an error.
fn invalid(model: &str, query: &str) -> String {
    match answer(model, query) {
        Answer::Invalid { message, .. } => message,
        other => panic!("{query}: {other:?}"),
    }
}
