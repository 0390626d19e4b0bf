//! From the declarations of an interface to the components that provide it, and back.

use super::{
    FileView, NavTarget, RangeInfo,
    references::for_each_unit,
    resolve::{Target, definition_target, find_identities, identity, targets_at},
    view::place,
};
use crate::{
    elab::{DefKind, Definition, Elaborated},
    model::ComponentKind,
    queries::elaborated,
    source_map::bytes,
};

/// For an interface, the components that provide or extend it; for its services, tasks and ports, the places
/// where components complete them; on such a completion, the declaration of the interface.
pub(crate) fn implementations(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Vec<NavTarget>>> {
    let (range, targets) = targets_at(view, at)?;
    let mut out: Vec<NavTarget> = Vec::new();
    for target in &targets {
        let Target::Definition(id) = target else {
            continue;
        };
        let Some(wanted) = identity(view.db, view.unit, *id) else {
            continue;
        };
        let home = [wanted.file];
        for_each_unit(view, home, |unit| {
            let elaborated = elaborated(view.db, unit);
            for id in &find_identities(view.db, unit, elaborated, std::slice::from_ref(&wanted)) {
                let definition = elaborated.definition(*id);
                for (src, name) in completions(elaborated, definition) {
                    let Some((file, found)) = place(view.db, unit, src) else {
                        continue;
                    };
                    let here = file == view.file && found == range;
                    let target = NavTarget {
                        path: file.path(view.db).clone(),
                        full_range: bytes(found),
                        focus_range: bytes(found),
                        name: definition.name.clone(),
                        kind: definition.kind.into(),
                        container: Some(name),
                    };
                    if !here && !out.contains(&target) {
                        out.push(target);
                    }
                }
            }
        });
        // On a completion: back to the interface.
        let declared = definition_target(view.db, view.unit, *id);
        if let Some(declared) = declared
            && (declared.path != *view.file.path(view.db) || declared.focus_range != bytes(range))
            && !out.contains(&declared)
            && in_interface(view.elaborated(), view.elaborated().definition(*id))
        {
            out.insert(0, declared);
        }
    }
    out.sort_by(|a, b| (&a.path, a.focus_range.start).cmp(&(&b.path, b.focus_range.start)));
    (!out.is_empty()).then(|| RangeInfo { range: bytes(range), info: out })
}

fn in_interface(elaborated: &Elaborated, definition: &Definition) -> bool {
    let container = definition.container.map(|container| elaborated.definition(container));
    container.is_some_and(|container| container.kind == DefKind::Interface)
}

/// The places where components complete a declaration of an interface, with their names.
fn completions(
    elaborated: &Elaborated,
    definition: &Definition,
) -> Vec<(crate::model::Src, smol_str::SmolStr)> {
    let spec = &elaborated.spec;
    let interface = match definition.kind {
        DefKind::Interface => definition.name.clone(),
        _ if in_interface(elaborated, definition) => match definition.container {
            Some(container) => elaborated.definition(container).name.clone(),
            None => return Vec::new(),
        },
        _ => return Vec::new(),
    };
    let Some(index) = spec.components.position(|component| component.name == interface) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for (number, component) in spec.components.iter_enumerated() {
        let provides = component.provides.contains(&index) || component.extends.contains(&index);
        if number == index || !provides || component.kind != ComponentKind::Component {
            continue;
        }
        let declared = elaborated.references.iter().filter(|reference| {
            reference.target == definition.id
                && reference.is_declaration()
                && reference.component == Some(number)
        });
        let before = out.len();
        if definition.kind != DefKind::Interface {
            out.extend(declared.map(|reference| (reference.at, component.name.clone())));
        }
        // Not completed in the component: the property that imports it.
        if out.len() == before {
            out.push((component.src, component.name.clone()));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::test_support::{Fixture, annotations};

    #[track_caller]
    fn check(text: &str) {
        let fixture = Fixture::new(text);
        let found = fixture.analysis().goto_implementation(&fixture.at()).unwrap();
        let mut found: Vec<String> = found
            .map_or_else(Vec::new, |implementation| implementation.info)
            .iter()
            .map(|target| format!("{}:{:?}", target.path, target.focus_range))
            .collect();
        found.sort();
        let mut wanted = Vec::new();
        for path in fixture.paths() {
            for (range, _) in annotations(&fixture.text(path.as_str())) {
                wanted.push(format!("{path}:{range:?}"));
            }
        }
        wanted.sort();
        assert_eq!(found, wanted, "{}", fixture.all_diagnostics());
    }

    #[test]
    fn services_of_an_interface() {
        check(
            "interface i { function go$0(); };\ncomponent c {\n  provides i;\n  function go() { codel f(); };\n//         ^^\n};\ncomponent d { provides i; };\n//        ^\ncomponent e { uses i; };\n",
        );
    }

    #[test]
    fn interfaces() {
        check(
            "interface i$0 { };\ncomponent c { provides i; };\n//        ^\ncomponent d { extends i; };\n//        ^\ncomponent e { uses i; };\n",
        );
    }

    #[test]
    fn and_back() {
        check(
            "interface i { function go(); };\n//                     ^^\ncomponent c { provides i; function go$0() { codel f(); }; };\n",
        );
        check("component c { function go$0(); };\n");
    }

    #[test]
    fn in_other_files() {
        check(
            "//- /i.idl\ninterface i { function go$0(); };\n//- /main.gen\n#include \"i.idl\"\ncomponent c { provides i; };\n//        ^\n",
        );
    }
}
