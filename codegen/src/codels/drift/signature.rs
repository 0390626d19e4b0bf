//! Comparison of prototypes after normalization.

use dotgen_analysis::model::UnknownDependencies;

use super::finding::{Clauses, Difference};
use super::{Check, Drift, FunctionIn, Repair};
use crate::codels::{
    files::Sources,
    source::{CType, Function, Layer, Parameter, Span, compact},
};

/// One difference between two prototypes.
struct PrototypeDifference {
    /// A clause of the message.
    text: String,
    /// The parameter in the source, if the difference is about one.
    parameter: Option<Span>,
}

impl PrototypeDifference {
    fn of_function(text: impl Into<String>) -> PrototypeDifference {
        PrototypeDifference { text: text.into(), parameter: None }
    }
}

/// The result of a comparison of two types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Same,
    /// The types differ only in `const`.
    Constness,
    Different,
    /// The definition of one of the types is not available.
    Unknown,
}

pub(super) fn check(check: &Check<'_>, definitions: &[FunctionIn<'_>], out: &mut Vec<Drift>) {
    let Some(shape) = &check.function.shape else {
        return;
    };
    // With conditional compilation or overloading, one of several definitions is the codel.
    let all: Vec<Vec<PrototypeDifference>> = definitions
        .iter()
        .map(|definition| differences(check, shape, definition.function))
        .collect();
    let best = all.iter().zip(definitions).min_by_key(|(found, _)| found.len());
    if let Some((differences, found)) = best.filter(|(found, _)| !found.is_empty()) {
        out.push(report(check, *found, differences));
        return;
    }
    // Prototypes that contradict the definition do not compile.
    for file in check.sources.all() {
        for function in &file.index().functions {
            if function.body.is_some()
                || function.name != check.function.name
                || !function.is_global()
            {
                continue;
            }
            let differences = differences(check, shape, function);
            if !differences.is_empty() {
                out.push(report(check, FunctionIn { file, function }, &differences));
            }
        }
    }
}

fn report(check: &Check<'_>, found: FunctionIn<'_>, differences: &[PrototypeDifference]) -> Drift {
    let name = &check.function.name;
    let texts = differences.iter().map(|difference| difference.text.clone());
    let mut drift = check.drift(Difference::Signature {
        function: name.clone(),
        differences: Clauses(texts.collect()),
    });
    // The parameters that differ, or the name.
    let spans: Option<Vec<Span>> =
        differences.iter().map(|difference| difference.parameter.clone()).collect();
    let place = spans
        .and_then(|spans| spans.into_iter().reduce(|all, span| all.start..span.end))
        .unwrap_or_else(|| found.function.name_span.clone());
    drift.source = Some(found.at(place));
    drift.expected = check.function.signature.clone().ok();
    let text = found.file.text.get(found.function.signature_span.clone());
    drift.found = text.map(str::to_owned);
    // The types of the other parameters are unknown. A guess must not replace the written types.
    if check.function.awaits == UnknownDependencies::default() {
        drift.repairs.push(Repair::UpdateSignature {
            name: name.clone(),
            path: found.file.path.clone(),
            start: found.function.span.start,
        });
        if let [at] = check.function.uses.as_slice() {
            drift.repairs.push(Repair::AdaptParameters {
                at: *at,
                path: found.file.path.clone(),
                start: found.function.span.start,
            });
        }
    }
    drift
}

/// Descriptions of all differences; empty if there are none or if nothing is known.
fn differences(check: &Check<'_>, wanted: &Function, found: &Function) -> Vec<PrototypeDifference> {
    let mut out = Vec::new();
    if !found.known {
        return out;
    }
    if found.is_static {
        out.push(PrototypeDifference::of_function(
            "it is `static`, so that the component cannot call it",
        ));
    }
    let compare = |a: &CType, b: &CType| compare(check, a, b);
    if matches!(compare(&wanted.result, &found.result), Verdict::Different | Verdict::Constness) {
        out.push(PrototypeDifference::of_function(format!(
            "expected return type `{}`, found `{}`",
            show(&wanted.result, None),
            show(&found.result, None)
        )));
    }
    if found.variadic {
        out.push(PrototypeDifference::of_function("a codel has no variable arguments"));
    }
    let (w, f) = (&wanted.parameters, &found.parameters);
    if w.len() != f.len() {
        out.push(arity(check, w, f));
        return out;
    }
    if let Some(order) = permuted(check, w, f) {
        out.push(PrototypeDifference::of_function(order));
        return out;
    }
    for (number, (w, f)) in (1..).zip(w.iter().zip(f)) {
        let wrong = match compare(&w.ty, &f.ty) {
            Verdict::Same | Verdict::Unknown => false,
            Verdict::Constness | Verdict::Different => true,
        };
        if wrong {
            let text = format!(
                "parameter {number}: expected `{}`, found `{}`",
                show(&w.ty, w.name.as_deref()),
                show(&f.ty, f.name.as_deref())
            );
            out.push(PrototypeDifference { text, parameter: Some(f.span.clone()) });
        }
    }
    out
}

fn arity(check: &Check<'_>, wanted: &[Parameter], found: &[Parameter]) -> PrototypeDifference {
    let count = format!(
        "expected {}, found {}",
        match wanted.len() {
            1 => "1 parameter".to_owned(),
            n => format!("{n} parameters"),
        },
        found.len()
    );
    let (more, less, word) = if wanted.len() > found.len() {
        (wanted, found, "missing")
    } else {
        (found, wanted, "too many")
    };
    let extra = unmatched(check, more, less);
    let parameter = match extra.as_slice() {
        [one] if found.len() > wanted.len() => Some(one.span.clone()),
        _ => None,
    };
    let extra: Vec<String> = extra
        .into_iter()
        .map(|parameter| format!("`{}`", show(&parameter.ty, parameter.name.as_deref())))
        .collect();
    let text =
        if extra.is_empty() { count } else { format!("{count} ({word}: {})", extra.join(", ")) };
    PrototypeDifference { text, parameter }
}

/// Parameters of the first list without a counterpart in the second: by name, then by type.
fn unmatched<'p>(check: &Check<'_>, of: &'p [Parameter], by: &[Parameter]) -> Vec<&'p Parameter> {
    let mut partners: Vec<Option<&Parameter>> = by.iter().map(Some).collect();
    let mut rest: Vec<&Parameter> = Vec::new();
    for parameter in of {
        let same = |other: &&Parameter| parameter.name.is_some() && other.name == parameter.name;
        match partners.iter_mut().find(|other| other.as_ref().is_some_and(same)) {
            Some(partner) => *partner = None,
            None => rest.push(parameter),
        }
    }
    rest.retain(|parameter| {
        let same = |other: &&Parameter| compare(check, &parameter.ty, &other.ty) == Verdict::Same;
        match partners.iter_mut().find(|other| other.as_ref().is_some_and(same)) {
            Some(partner) => {
                *partner = None;
                false
            }
            None => true,
        }
    });
    rest
}

/// A description of parameters in another order: by name if all have names, else by type.
fn permuted(check: &Check<'_>, wanted: &[Parameter], found: &[Parameter]) -> Option<String> {
    let names = |all: &[Parameter]| -> Option<Vec<String>> {
        all.iter().map(|parameter| parameter.name.as_ref().map(ToString::to_string)).collect()
    };
    let (w, f) = (names(wanted)?, names(found)?);
    let sorted = |all: &[String]| {
        let mut all = all.to_vec();
        all.sort();
        all
    };
    if w == f || sorted(&w) != sorted(&f) {
        return None;
    }
    // Each parameter must keep its type; otherwise more than the order differs.
    let kept = wanted.iter().all(|parameter| {
        let other = found.iter().find(|other| other.name == parameter.name);
        other.is_some_and(|other| {
            matches!(compare(check, &parameter.ty, &other.ty), Verdict::Same | Verdict::Unknown)
        })
    });
    kept.then(|| format!("order: expected ({}), found ({})", w.join(", "), f.join(", ")))
}

fn compare(check: &Check<'_>, wanted: &CType, found: &CType) -> Verdict {
    let expected = check.expected;
    if expected.is_opaque(wanted) {
        return Verdict::Unknown;
    }
    let (a, length_a) = expected.canonical(wanted).as_parameter();
    let (b, length_b) = expected.canonical(found).as_parameter();
    if same(&a, &b) {
        return match (length_a.as_deref(), length_b.as_deref()) {
            (Some(a), Some(b)) if a != b => match (a.parse::<u64>(), b.parse::<u64>()) {
                (Ok(_), Ok(_)) => Verdict::Different,
                _ => Verdict::Unknown,
            },
            _ => Verdict::Same,
        };
    }
    if is_declared_in(check.sources, &found.base) && !expected.knows_type(&found.base) {
        return Verdict::Unknown;
    }
    // A missing file may declare the type.
    if check.options.trust.lacks_files && !expected.has_type(&b.base) {
        return Verdict::Unknown;
    }
    // A length that is a name is a constant, whose value is not looked up.
    let named_length = b.layers.iter().any(
        |layer| matches!(layer, Layer::Array { length: Some(length) } if length.parse::<u64>().is_err()),
    );
    if named_length {
        return Verdict::Unknown;
    }
    if same(&a.without_const(), &b.without_const()) {
        return Verdict::Constness;
    }
    Verdict::Different
}

fn same(a: &CType, b: &CType) -> bool {
    a.constant == b.constant && a.layers == b.layers && same_base(&a.base, &b.base)
}

/// True for equal names, for a name that is the end of the other (after `using namespace`), and for integer
/// types that may be equal.
fn same_base(a: &str, b: &str) -> bool {
    let ends =
        |long: &str, short: &str| long.strip_suffix(short).is_some_and(|stem| stem.ends_with("::"));
    let wide = |a: &str, b: &str| {
        matches!(
            (a, b),
            ("int64_t", "long" | "long long")
                | ("uint64_t", "unsigned long" | "unsigned long long")
        )
    };
    a == b || ends(a, b) || ends(b, a) || wide(a, b) || wide(b, a)
}

/// True if the sources have a type or macro of that name.
fn is_declared_in(sources: &Sources, base: &str) -> bool {
    let short = base.rsplit("::").next().unwrap_or(base);
    let plain = short.split('<').next().unwrap_or(short);
    sources.all().any(|file| {
        file.index().names.contains(plain)
            || file.index().macros.iter().any(|definition| definition.name == plain)
    })
}

/// A type in the syntax of C.
fn show(ty: &CType, name: Option<&str>) -> String {
    let mut declarator = name.unwrap_or_default().to_owned();
    let mut pointer = false;
    for layer in &ty.layers {
        match layer {
            Layer::Pointer { constant } => {
                let constant = if *constant { "const " } else { "" };
                declarator = format!("*{constant}{declarator}");
                pointer = true;
            }
            Layer::Reference { rvalue } => {
                declarator = format!("{}{declarator}", if *rvalue { "&&" } else { "&" });
                pointer = true;
            }
            Layer::Array { length } => {
                if pointer {
                    declarator = format!("({declarator})");
                    pointer = false;
                }
                declarator = format!("{declarator}[{}]", length.as_deref().unwrap_or_default());
            }
            Layer::Function { parameters } => {
                declarator = format!("({declarator}){}", compact(parameters));
            }
        }
    }
    let constant = if ty.constant { "const " } else { "" };
    format!("{constant}{} {declarator}", ty.base).trim_end().to_owned()
}
