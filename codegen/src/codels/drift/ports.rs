//! Output ports that no codel publishes: parameters on which no path of the functions calls `write`.
//!
//! A codel may leave the writing to another one, so a port is reported only if none of its codels can write.

use dotgen_analysis::model::{ParamDir, ParamSource, PortDir, PortId};

use super::finding::Difference;
use super::{Check, Drift, DriftOptions, FunctionIn};
use crate::codels::{
    expected::{Expected, ExpectedFunction},
    files::Sources,
    source::Parameter,
};

pub(super) fn check(
    expected: &Expected<'_>,
    sources: &Sources,
    options: &DriftOptions,
    out: &mut Vec<Drift>,
) {
    if sources.incomplete {
        return;
    }
    for (index, port) in expected.component().ports.iter_enumerated() {
        if port.dir == PortDir::Out {
            out.extend(unwritten(expected, sources, options, index).unwrap_or_default());
        }
    }
}

/// The findings at all functions that could write a port; `None` if some function writes, or may write.
fn unwritten(
    expected: &Expected<'_>,
    sources: &Sources,
    options: &DriftOptions,
    port: PortId,
) -> Option<Vec<Drift>> {
    let component = expected.component();
    let mut out = Vec::new();
    for function in &expected.functions {
        let positions = positions(expected, function, port)?;
        if positions.is_empty() {
            continue;
        }
        if options.trust.is_faulty(expected, function) || options.trust.lacks_text {
            return None;
        }
        let check = Check { expected, function, sources, options };
        let definitions = check.definitions();
        if definitions.is_empty() {
            return None;
        }
        for found in definitions {
            let mut at = None;
            for position in &positions {
                at = Some(idle(found, function, *position, sources)?);
            }
            let kind = Difference::UnwrittenPort {
                function: function.name.clone(),
                port: component.ports[port].name.clone(),
                component: component.name.clone(),
            };
            let source = at.map(|parameter| found.at(parameter.span.clone()));
            out.push(Drift { source, ..check.drift(kind) });
        }
    }
    Some(out)
}

/// The parameters of a function for a port to write; `None` if its codels disagree about them.
fn positions(
    expected: &Expected<'_>,
    function: &ExpectedFunction,
    port: PortId,
) -> Option<Vec<usize>> {
    let of_codel = |codel: &dotgen_analysis::model::CodelRef| -> Vec<usize> {
        let params = expected.component().codel(*codel).params.iter().enumerate();
        let written = params.filter(|(_, param)| {
            param.source == ParamSource::Port(port)
                && matches!(param.dir, ParamDir::Out | ParamDir::Inout)
        });
        written.map(|(position, _)| position).collect()
    };
    let mut all = function.uses.iter().map(of_codel);
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// The parameter at a position, if the function certainly does not write it.
fn idle<'a>(
    found: FunctionIn<'a>,
    function: &ExpectedFunction,
    position: usize,
    sources: &Sources,
) -> Option<&'a Parameter> {
    let parameters = &found.function.parameters;
    let shape = function.shape.as_ref()?;
    let body = found.function.body.as_ref()?;
    if !found.function.known
        || parameters.len() != shape.parameters.len()
        || body.broken
        || body.sample
    {
        return None;
    }
    let parameter = parameters.get(position)?;
    if let Some(name) = &parameter.name {
        // A macro that the sources define may use the name, and one of another header may be anything.
        let opaque = body.calls.iter().any(|call| is_shouted(&call.name));
        let in_macro = sources.all().any(|file| file.index().in_macros.contains(name));
        if opaque || in_macro || body.escaping.contains(name) {
            return None;
        }
    }
    Some(parameter)
}

/// True if a name has no small letter, as names of macros.
fn is_shouted(name: &str) -> bool {
    !name.chars().any(char::is_lowercase)
}
