//! Completes the services of an interface that a component provides.

use dotgen_syntax::ast::{self, AstNode};

use super::{Assist, AssistKind, Cx};
use crate::{
    elab::DefKind,
    ide::{
        render,
        resolve::{Target, targets_at},
    },
    model::{Param, ParamDir, Service, ServiceKind, Spec, TypeId, TypeKind, fsm::Machine},
};

/// On the name of an interface after `provides` or `extends`: declares every activity that lacks its task or
/// its `start`, and every function without a codel.
pub(super) fn implement_interface(cx: &Cx<'_, '_>) -> Option<Assist> {
    let property: ast::InterfacesProperty = cx.ancestor()?;
    let component: ast::Component = cx.ancestor()?;
    if component.is_interface() || property.uses_token().is_some() {
        return None;
    }
    let (_, targets) = targets_at(cx.view, cx.range.start)?;
    let elaborated = cx.view.elaborated();
    let interface = targets.iter().find_map(|target| match target {
        Target::Definition(id) => {
            let definition = elaborated.definition(*id);
            (definition.kind == DefKind::Interface).then_some(&definition.name)
        }
        _ => None,
    })?;
    let spec = &elaborated.spec;
    let index = spec.components.position(|component| component.name == *interface)?;
    let name = component.name()?.text(cx.view.map());
    let model = spec.components.iter().find(|component| component.name == name)?;
    let mut text = String::new();
    for service in model.services.iter().filter(|service| service.imported_from == Some(index)) {
        text += &completion(spec, service, model.tasks.first().map(|task| task.name.as_str()))
            .unwrap_or_default();
    }
    let body = component.body()?.syntax().clone();
    let close = cx.node_range(&body).end.checked_sub(1)?;
    if text.is_empty() || cx.slice(close..close + 1) != "}" {
        return None;
    }
    // On a line of its own, before the brace.
    let before = cx.slice(0..close).trim_end_matches([' ', '\t']).len();
    let (at, lead) = if cx.slice(0..before).ends_with('\n') { (before, "") } else { (close, "\n") };
    Some(Assist {
        id: "implement-interface",
        title: format!("Implement interface `{interface}`"),
        kind: AssistKind::Rewrite,
        edits: vec![cx.edit(at..at, format!("{lead}{text}"))],
    })
}

/// The declaration that completes a service; `None` if nothing is missing.
fn completion(spec: &Spec, service: &Service, task: Option<&str>) -> Option<String> {
    let name = &service.name;
    let declared: Vec<&Param> =
        service.params.iter().filter(|param| param.dir != ParamDir::Local).collect();
    let params: Option<Vec<String>> =
        declared.iter().map(|param| declaration(spec, param)).collect();
    let params = params?.join(", ");
    let uses: Vec<String> =
        declared.iter().map(|param| format!("local {} {}", param.dir.word(), param.name)).collect();
    let uses = uses.join(", ");
    match service.kind {
        ServiceKind::Attribute => None,
        ServiceKind::Function => {
            if !service.codels.is_empty() {
                return None;
            }
            Some(format!(
                "\n  function {name}({params}) {{\n    codel {name}_codel({uses});\n  }};\n"
            ))
        }
        ServiceKind::Activity => {
            let starts = Machine::new(&service.codels).codel("start").is_some();
            let task_line = match (service.task, task) {
                (None, Some(task)) => format!("    task {task};\n"),
                (None, None) => "    task main;\n".to_owned(),
                (Some(_), _) => String::new(),
            };
            let codel = if starts {
                String::new()
            } else {
                format!("    codel<start> {name}_start({uses})\n      yield ether;\n")
            };
            if task_line.is_empty() && codel.is_empty() {
                return None;
            }
            Some(format!("\n  activity {name}({params}) {{\n{task_line}{codel}  }};\n"))
        }
    }
}

/// `in m::t name[2]`
fn declaration(spec: &Spec, param: &Param) -> Option<String> {
    let (mut ty, mut dimensions): (TypeId, String) = (param.ty, String::new());
    for _ in 0..spec.types.len() {
        let inner = spec.types.get(ty)?;
        match (&inner.name, &inner.kind) {
            (None, TypeKind::Array { element, length }) => {
                dimensions += &format!("[{length}]");
                ty = *element;
            }
            (_, TypeKind::Unknown) => return None,
            _ => break,
        }
    }
    let ty = render::type_text(spec, ty);
    Some(format!("{} {ty} {}{dimensions}", param.dir.word(), param.name))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn what_is_missing() {
        check(
            "implement-interface",
            "interface i {
  typedef long t;
  activity go(in t speed, out double left[2]);
  function reset();
  activity done();
};
component c {
  task t;
  provides i$0;
  activity done() { task t; codel<start> d() yield ether; };
};
",
            "interface i {
  typedef long t;
  activity go(in t speed, out double left[2]);
  function reset();
  activity done();
};
component c {
  task t;
  provides i;
  activity done() { task t; codel<start> d() yield ether; };

  activity go(in i::t speed, out double left[2]) {
    task t;
    codel<start> go_start(local in speed, local out left)
      yield ether;
  };

  function reset() {
    codel reset_codel();
  };
};
",
        );
    }

    #[test]
    fn nothing_is_missing() {
        assert_not_offered(
            "implement-interface",
            "interface i { };\ncomponent c { provides i$0; };\n",
        );
        assert_not_offered(
            "implement-interface",
            "interface i { function f(); };\ncomponent c { uses i$0; };\n",
        );
    }
}
