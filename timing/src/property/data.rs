//! The resolution of comparisons of data in a built system.

use dotgen_analysis::model::{PortDir, Spec, TypeId, TypeKind};
use dotgen_syntax::suggestion::nearest;

use crate::diagnostic::Diagnostic;
use crate::scn::ast::{Check, Comparison, Operator};
use crate::scn::names::{Names, Target};
use crate::system::data::DataFact;
use crate::system::indexed::Built;

/// Returns the finding for a comparison in a check that is to be verified.
pub(crate) fn not_in_model(comparison: &Comparison) -> Diagnostic {
    let message = format!(
        "not verified: `{}` is data, which the timed model does not have; `dotgen run` \
         and `dotgen replay` check this",
        comparison.path.text()
    );
    Diagnostic::warning("scn-data", comparison.path.range(), message)
}

/// Returns the facts that checks compare, each once. Comparisons with an error are left out.
pub(crate) fn facts(names: &Names, built: &Built, checks: &[Check]) -> Vec<DataFact> {
    let mut out = Vec::new();
    for comparison in checks.iter().flat_map(|check| check.kind.comparisons()) {
        if let Ok(fact) = resolve(names, built, comparison)
            && !out.contains(&fact)
        {
            out.push(fact);
        }
    }
    out
}

/// Resolves a comparison.
pub(crate) fn resolve(
    names: &Names,
    built: &Built,
    comparison: &Comparison,
) -> Result<DataFact, Diagnostic> {
    let path = &comparison.path;
    let wrong = |message: String| Err(Diagnostic::error("scn-wrong-kind", path.range(), message));
    if path.names.get(1).is_some_and(|name| name.value == "ids") {
        return wrong(format!(
            "`{}` is unknown outside its component; write it to an output port and compare the port",
            path.text()
        ));
    }
    let target = names.resolve(path)?;
    let (Target::Port(c, p) | Target::Member(c, p, _)) = target else {
        return wrong(format!(
            "`{}` is not data of a port; compare COMPONENT.PORT.MEMBER. A limit of time needs a unit, as in \
             `<= 5 ms`",
            path.text()
        ));
    };
    let member = &names.components[c];
    let port = &member.component.ports[p];
    let port_path = format!("{}.{}", member.component.name, port.name);
    if port.dir == PortDir::In {
        let message = format!("`{port_path}` is an input; compare the output that it reads");
        return Err(Diagnostic::error("scn-port-direction", path.range(), message));
    }
    if port.multiple {
        return wrong(format!(
            "`{port_path}` is `multiple`; only ports with one value are compared"
        ));
    }
    fits(member.spec, names.data_type(&target).unwrap_or(port.data), comparison)?;
    let members = if let Target::Member(_, _, members) = target { members } else { Vec::new() };
    Ok(DataFact {
        component: built.components[&c],
        port: p,
        path: port_path,
        members,
        operator: comparison.operator,
        operand: comparison.operand.value.clone(),
    })
}

/// Checks that values of a type can be compared with the operand.
fn fits(spec: &Spec, ty: TypeId, comparison: &Comparison) -> Result<(), Diagnostic> {
    let Comparison { path, operator, operand } = comparison;
    let text = path.text();
    let wrong = |range, message| Err(Diagnostic::error("scn-wrong-kind", range, message));
    let kind = &spec.ty(spec.resolve_alias(ty)).kind;
    let is_equality = matches!(operator, Operator::Equal | Operator::Unequal);
    match kind {
        kind if kind.is_number() => {
            if operand.value.starts_with(|first: char| first == '-' || first.is_ascii_digit()) {
                return Ok(());
            }
            wrong(operand.range.clone(), format!("`{text}` is a number; compare it with a number"))
        }
        TypeKind::Boolean | TypeKind::Enum { .. } if !is_equality => {
            let message = format!("values of `{text}` have no order; use `==` or `!=`");
            wrong(path.range(), message)
        }
        TypeKind::Boolean if matches!(&*operand.value, "true" | "false") => Ok(()),
        TypeKind::Boolean => {
            wrong(operand.range.clone(), format!("`{text}` is `true` or `false`, nothing else"))
        }
        TypeKind::Enum { enumerators } => {
            let names = enumerators.iter().filter_map(|&id| spec.ty(id).name.as_deref());
            let names: Vec<&str> = names.collect();
            if names.contains(&&*operand.value) {
                return Ok(());
            }
            let message = format!("`{text}` has no value `{}`", operand.value);
            let error =
                |message| Diagnostic::error("scn-unknown-name", operand.range.clone(), message);
            Err(match nearest(&operand.value, names.iter().copied()) {
                Some(near) => error(message).suggest_name(near),
                None => error(format!("{message}; there is {}", names.join(", "))),
            })
        }
        TypeKind::Struct { .. } => {
            wrong(path.range(), format!("`{text}` is a struct; compare one of its members"))
        }
        kind => {
            let message = format!(
                "`{text}` is of type {}; only numbers, Booleans and enumerators are compared",
                kind.word()
            );
            wrong(path.range(), message)
        }
    }
}
