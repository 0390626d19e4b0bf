//! Replaces every use of a typedef by its type.

use dotgen_syntax::{
    SyntaxNode, TextRange,
    ast::{self, AstNode},
};

use super::{Assist, AssistKind, Cx};
use crate::{
    diagnostic::FileEdit,
    elab::DefKind,
    ide::{
        FileView,
        references::references,
        resolve::{Target, targets_at},
        speculate::compare,
    },
    source_map::{bytes, text_range},
};

/// `typedef long t; typedef t u;` → `typedef long u;`
pub(super) fn inline_typedef(cx: &Cx<'_, '_>) -> Option<Assist> {
    let (_, targets) = targets_at(cx.view, cx.range.start)?;
    let elaborated = cx.view.elaborated();
    let target = targets.iter().find_map(|target| match target {
        Target::Definition(id) => {
            let definition = elaborated.definition(*id);
            (definition.kind == DefKind::Typedef).then_some(definition)
        }
        _ => None,
    })?;
    let (file, name) = cx.view.place(target.src)?;
    if file != cx.view.file {
        return None;
    }
    let root = cx.view.root();
    let declaration = parent(&root, name)?.ancestors().find_map(ast::TypedefDecl::cast)?;
    let mut declarators = declaration.declarators();
    let declarator = declarators.next()?;
    let ty = declaration.type_spec()?;
    if declarators.next().is_some()
        || declarator.dimensions().next().is_some()
        || !cx.is_plain(declaration.syntax())
        || matches!(ty, ast::TypeSpec::Struct(_) | ast::TypeSpec::Union(_) | ast::TypeSpec::Enum(_))
    {
        return None;
    }
    let named = matches!(ty, ast::TypeSpec::NamedType(_));
    let text = cx.text(ty.syntax()).to_owned();
    let mut edits = vec![cx.edit(cx.whole_lines(cx.node_range(declaration.syntax())), "")];
    for reference in references(cx.view, name.start().into(), false)? {
        let path = reference.place.path;
        let other;
        let there = if path == *cx.view.file.path(cx.view.db) {
            cx.view
        } else {
            other = FileView::new(cx.view.db, cx.view.db.file(&path))?;
            &other
        };
        let node = parent(&there.root(), text_range(&reference.place.range))?;
        let used = node.ancestors().find_map(ast::NamedType::cast)?;
        let range = bytes(there.node_range(used.syntax()));
        let written = there.text().get(range.clone())?;
        let last = written.rsplit("::").next()?.trim();
        let port = used.syntax().parent().is_some_and(|parent| ast::Port::can_cast(parent.kind()));
        // A port needs a named type; text from a macro cannot be replaced.
        if last != target.name || port && !named {
            return None;
        }
        edits.push(FileEdit { path, range, new_text: text.clone() });
    }
    // The name in the type may mean something else elsewhere.
    let wrong = compare(cx.view.db, &edits, |_, comparison| {
        (!comparison.new_errors.is_empty()).then_some(())
    });
    wrong.is_empty().then(|| Assist {
        id: "inline-typedef",
        title: format!("Inline typedef `{}`", target.name),
        kind: AssistKind::Inline,
        edits,
    })
}

fn parent(root: &SyntaxNode, range: TextRange) -> Option<SyntaxNode> {
    if !root.text_range().contains_range(range) {
        return None;
    }
    root.token_at_offset(range.start()).right_biased()?.parent()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn every_use() {
        check(
            "inline-typedef",
            "typedef sequence<long, 4> t$0;\nmodule m { struct s { t x; ::t y; }; };\n",
            "module m { struct s { sequence<long, 4> x; sequence<long, 4> y; }; };\n",
        );
        check(
            "inline-typedef",
            "struct s { long x; };\ntypedef s t;\ncomponent c { port in t$0 p; };\n",
            "struct s { long x; };\ncomponent c { port in s p; };\n",
        );
    }

    #[test]
    fn not_where_a_name_is_needed() {
        assert_not_offered("inline-typedef", "typedef long t$0;\ncomponent c { port in t p; };\n");
        assert_not_offered("inline-typedef", "typedef long t$0[2];\nstruct s { t x; };\n");
        // The name would mean `u` of the module.
        assert_not_offered(
            "inline-typedef",
            "typedef string u;\ntypedef u t$0;\nmodule m { struct u { long x; }; const t x = \"a\"; };\n",
        );
    }
}
