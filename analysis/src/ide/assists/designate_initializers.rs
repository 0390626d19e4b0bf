//! Replaces positions by names in the default value of a struct or union.

use dotgen_syntax::ast::{self, AstNode};

use super::{Assist, AssistKind, Cx};
use crate::{
    diagnostic::FileEdit,
    model::{InitValue, Initializer, PathElement},
    source_map::bytes,
};

/// `= { 1, 2 }` → `= { .x = 1, .y = 2 }`
pub(super) fn designate_initializers(cx: &Cx<'_, '_>) -> Option<Assist> {
    let list: ast::InitializerList = cx.ancestor()?;
    if !cx.is_plain(list.syntax()) {
        return None;
    }
    // The outermost braces contain the whole value.
    let lists = list.syntax().ancestors().filter_map(ast::InitializerList::cast);
    let outermost = lists.last()?;
    let all = &cx.view.elaborated().spec.components;
    let services = all.iter().flat_map(|component| &component.services);
    let inits =
        services.flat_map(|service| &service.params).filter_map(|param| param.init.as_ref());
    let range = cx.node_range(outermost.syntax());
    let mut edits = Vec::new();
    for init in inits {
        let here = cx.view.place(init.src).is_some_and(|(file, place)| {
            let place = bytes(place);
            file == cx.view.file && place.start <= range.start && range.end <= place.end
        });
        if here {
            name_parts(cx, init, &mut edits);
        }
    }
    edits.sort_by_key(|edit: &FileEdit| edit.range.start);
    edits.dedup();
    (!edits.is_empty()).then(|| Assist {
        id: "designate-initializers",
        title: "Name the members that are initialized".to_owned(),
        kind: AssistKind::Rewrite,
        edits,
    })
}

fn name_parts(cx: &Cx<'_, '_>, init: &Initializer, edits: &mut Vec<FileEdit>) {
    let InitValue::Compound(parts) = &init.value else {
        return;
    };
    for part in parts {
        if let Some(PathElement::Member(name)) = &part.member
            && let Some((file, place)) = cx.view.place(part.src)
            && file == cx.view.file
        {
            let place = bytes(place);
            let written = cx.slice(place.clone());
            if !written.is_empty() && !written.starts_with('.') {
                edits.push(cx.edit(place.start..place.start, format!(".{name} = ")));
            }
        }
        name_parts(cx, part, edits);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    const TYPES: &str = "struct p { long x, y; };\nstruct s { p a; long b[2]; string c; };\n";

    #[test]
    fn members_but_not_elements() {
        check(
            "designate-initializers",
            &format!(
                "{TYPES}component k {{ function f(in s v = {{ {{ 1, $02 }}, {{ 3, 4 }}, \"x\" : \"doc\" }}); }};\n"
            ),
            &format!(
                "{TYPES}component k {{ function f(in s v = {{ .a = {{ .x = 1, .y = 2 }}, .b = {{ 3, 4 }}, .c = \"x\" : \"doc\" }}); }};\n"
            ),
        );
        check(
            "designate-initializers",
            &format!("{TYPES}component k {{ function f(in p v = {{ .y = 1$0 }}, in p w = {{ : \"a\", 2 }}); }};\n").replace(".y = 1$0 }, in p w = {", ".y = 1 }, in p w = {$0"),
            &format!("{TYPES}component k {{ function f(in p v = {{ .y = 1 }}, in p w = {{ .x = : \"a\", .y = 2 }}); }};\n"),
        );
    }

    #[test]
    fn nothing_to_name() {
        assert_not_offered(
            "designate-initializers",
            "component k { function f(in sequence<long> v = { 1$0, 2 }); };\n",
        );
        assert_not_offered(
            "designate-initializers",
            &format!("{TYPES}component k {{ function f(in p v = {{ .y = 1$0 }}); }};\n"),
        );
    }
}
