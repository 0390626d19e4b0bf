//! Creates an interface with the ports and services of a component, which then provides it.

use dotgen_syntax::ast::{self, AstNode, HasBody};

use super::{Assist, AssistKind, Cx};
use crate::{
    elab::DefKind,
    model::{TypeId, TypeKind},
    source_map::bytes,
};

/// Ports move, since a port is declared once; services stay and are completed in the component.
pub(super) fn generate_interface(cx: &Cx<'_, '_>) -> Option<Assist> {
    let component: ast::Component = cx.ancestor()?;
    let body = component.body()?;
    let open = cx.node_range(body.syntax()).start + 1;
    let start = cx.node_range(component.syntax()).start;
    if component.is_interface() || cx.range.end >= open {
        return None;
    }
    let map = cx.view.map();
    let name = component.name()?.text(map);
    let spec = &cx.view.elaborated().spec;
    let model = spec.components.iter().find(|component| component.name == name)?;
    let mut lines = Vec::new();
    let mut edits = Vec::new();
    for item in component.items() {
        if !cx.is_plain(item.syntax()) {
            continue;
        }
        match &item {
            ast::Item::Port(item) => {
                let port_name = item.name()?.text(map);
                let port = model.ports.iter().find(|port| port.name == port_name)?;
                let inline = !matches!(item.type_spec(), Some(ast::TypeSpec::NamedType(_)));
                if inline || is_local(cx, port.data, &name) {
                    continue;
                }
                lines.push(cx.text(item.syntax()).to_owned());
                edits.push(cx.edit(cx.whole_lines(cx.node_range(item.syntax())), ""));
            }
            ast::Item::Service(item) if item.attribute_token().is_none() => {
                let service_name = item.name()?.text(map);
                let service = model.services.iter().find(|service| service.name == service_name)?;
                if service.params.iter().any(|param| is_local(cx, param.ty, &name)) {
                    continue;
                }
                let params = item.param_list()?;
                if mentions_constants(cx, &params, &name) {
                    continue;
                }
                let word = item.keyword_token()?;
                let head = cx.text(params.syntax());
                lines.push(format!("{} {service_name}{head};", word.text()));
            }
            _ => {}
        }
    }
    if lines.is_empty() {
        return None;
    }
    let interface = cx.unused_name(&format!("{name}_interface"));
    let text: String = lines.iter().map(|line| format!("  {line}\n")).collect();
    edits.push(cx.edit(start..start, format!("interface {interface} {{\n{text}}};\n\n")));
    edits.push(cx.edit(open..open, format!("\n  provides {interface};")));
    edits.sort_by_key(|edit| edit.range.start);
    Some(Assist {
        id: "generate-interface",
        title: format!("Generate an interface from `{name}`"),
        kind: AssistKind::Extract,
        edits,
    })
}

/// Returns true if a type is declared in the component, so that an interface before it cannot name the type.
fn is_local(cx: &Cx<'_, '_>, ty: TypeId, component: &str) -> bool {
    let spec = &cx.view.elaborated().spec;
    let mut work = vec![ty];
    let mut seen = rustc_hash::FxHashSet::default();
    while let Some(id) = work.pop() {
        let Some(ty) = spec.types.get(id).filter(|_| seen.insert(id)) else {
            continue;
        };
        if ty.scope.first().is_some_and(|scope| scope.name == component) {
            return true;
        }
        if let TypeKind::Array { element, .. }
        | TypeKind::Sequence { element, .. }
        | TypeKind::Optional { element } = &ty.kind
        {
            work.push(*element);
        }
    }
    false
}

/// Returns true if a parameter list mentions a constant or enumerator of the component.
fn mentions_constants(cx: &Cx<'_, '_>, params: &ast::ParamList, component: &str) -> bool {
    let elaborated = cx.view.elaborated();
    let range = cx.node_range(params.syntax());
    elaborated.references.iter().any(|reference| {
        let target = elaborated.definition(reference.target);
        let here = cx.view.place(reference.at).is_some_and(|(file, place)| {
            let place = bytes(place);
            file == cx.view.file && range.start <= place.start && place.end <= range.end
        });
        here && matches!(target.kind, DefKind::Const | DefKind::Enumerator)
            && elaborated.containers(target).any(|around| around.name == component)
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn ports_move_and_services_are_completed() {
        check(
            "generate-interface",
            "struct s { long x; };

component arm$0 {
  port in s p;
  struct own { long y; };
  port out own q;
  task t { codel<start> f(port in p) yield ether; };
  activity go(in s where = { .x = 1 }) {
    task t;
    codel<start> g(in where) yield ether;
  };
};
",
            "struct s { long x; };

interface arm_interface {
  port in s p;
  activity go(in s where = { .x = 1 });
};

component arm {
  provides arm_interface;
  struct own { long y; };
  port out own q;
  task t { codel<start> f(port in p) yield ether; };
  activity go(in s where = { .x = 1 }) {
    task t;
    codel<start> g(in where) yield ether;
  };
};
",
        );
    }

    #[test]
    fn from_the_head_of_a_component_only() {
        assert_not_offered("generate-interface", "component c { function f$0(); };\n");
        assert_not_offered("generate-interface", "interface i$0 { function f(); };\n");
        assert_not_offered("generate-interface", "component c$0 { };\n");
    }
}
