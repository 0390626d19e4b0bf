//! Adds a placeholder for the documentation of each parameter of a service.

use dotgen_syntax::ast::{self, AstNode};

use super::{Assist, AssistKind, Cx};

/// `in long a, in long b = 2` → `in long a = : "a", in long b = 2 : "b"`
pub(super) fn document_parameters(cx: &Cx<'_, '_>) -> Option<Assist> {
    let service: ast::Service = cx.ancestor()?;
    let params = service.param_list()?;
    // Applies from the keyword to the end of the parameters, not in the body.
    let head = cx.node_range(service.syntax()).start..cx.node_range(params.syntax()).end;
    if !(head.start <= cx.range.start && cx.range.end <= head.end) {
        return None;
    }
    let map = cx.view.map();
    let mut edits = Vec::new();
    for param in params.params() {
        let (name, initializer) = match &param {
            ast::Param::TypedParam(param) => {
                (param.declarator()?.name()?.text(map), param.initializer())
            }
            ast::Param::PathParam(param) => (path_name(cx, param)?, param.initializer()),
        };
        if !cx.is_plain(param.syntax()) {
            continue;
        }
        let text = match &initializer {
            Some(initializer) if initializer.doc().is_some() => continue,
            Some(_) => format!(" : \"{name}\""),
            None => format!(" = : \"{name}\""),
        };
        let end = cx.node_range(param.syntax()).end;
        edits.push(cx.edit(end..end, text));
    }
    let name = service.name()?.text(map);
    (!edits.is_empty()).then(|| Assist {
        id: "document-parameters",
        title: format!("Document the parameters of `{name}`"),
        kind: AssistKind::Rewrite,
        edits,
    })
}

fn path_name(cx: &Cx<'_, '_>, param: &ast::PathParam) -> Option<smol_str::SmolStr> {
    let map = cx.view.map();
    if let Some(rename) = param.rename().and_then(|rename| rename.name()) {
        return Some(rename.text(map));
    }
    let names = param.path()?.steps().filter_map(|step| match step {
        ast::PathStep::MemberStep(member_step) => member_step.name_ref(),
        ast::PathStep::IndexStep(_) => None,
    });
    Some(names.last()?.text(map))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn those_that_lack_it() {
        check(
            "document-parameters",
            "component c { ids { long x; }; function f$0(in long a, in long b = 2, in long d = : \"dee\"); };\n",
            "component c { ids { long x; }; function f(in long a = : \"a\", in long b = 2 : \"b\", in long d = : \"dee\"); };\n",
        );
        check(
            "document-parameters",
            "component c { ids { long x; }; attribute f$0(in x, out x::y); };\n",
            "component c { ids { long x; }; attribute f(in x = : \"x\", out x::y = : \"y\"); };\n",
        );
        assert_not_offered("document-parameters", "component c { function f$0(); };\n");
    }
}
