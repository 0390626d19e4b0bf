//! Moves members of the ids to a struct of their own.

use dotgen_syntax::ast::{self, AstNode, HasBody};

use super::{Assist, AssistKind, Cx};
use crate::ide::references::references;

/// ```text
/// ids { double x; double y; };          struct data { double x; double y; };
/// codel f(in x);                   →    ids { data group; };
///                                       codel f(in group.x);
/// ```
pub(super) fn extract_struct(cx: &Cx<'_, '_>) -> Option<Assist> {
    let ids: ast::Ids = cx.ancestor()?;
    let members: Vec<ast::Member> = ids
        .items()
        .filter_map(|item| match item {
            ast::Item::Member(member) => Some(member),
            _ => None,
        })
        .filter(|member| cx.touches(member.syntax()))
        .collect();
    let (first, last) = (members.first()?, members.last()?);
    let start = cx.node_range(first.syntax()).start;
    let end = cx.node_range(last.syntax()).end;
    let at = cx.node_range(ids.syntax()).start;
    // A type declared in the ids is visible only there.
    let plain = members.iter().all(|member| {
        cx.is_plain(member.syntax())
            && matches!(
                member.type_spec(),
                Some(
                    ast::TypeSpec::BaseType(_)
                        | ast::TypeSpec::StringType(_)
                        | ast::TypeSpec::SequenceType(_)
                        | ast::TypeSpec::OptionalType(_)
                        | ast::TypeSpec::NamedType(_)
                )
            )
    });
    if !plain {
        return None;
    }
    let name = cx.unused_name("data");
    let member = cx.unused_name("group");
    let indent = cx.indent(at).to_owned();
    let body: String =
        members.iter().map(|member| format!("{indent}  {}\n", cx.text(member.syntax()))).collect();
    let mut edits = vec![
        cx.edit(at..at, format!("struct {name} {{\n{body}{indent}}};\n{indent}")),
        cx.edit(start..end, format!("{name} {member};")),
    ];
    for declarator in members.iter().flat_map(ast::Member::declarators) {
        let declared = declarator.name()?;
        let range = declared.range(cx.view.map());
        for reference in references(cx.view, range.start().into(), false)? {
            let file = cx.view.db.file(&reference.place.path);
            let written = file.text(cx.view.db).get(reference.place.range.clone())?;
            if written != declared.text(cx.view.map()) {
                return None;
            }
            edits.push(crate::diagnostic::FileEdit {
                path: reference.place.path,
                range: reference.place.range.start..reference.place.range.start,
                new_text: format!("{member}."),
            });
        }
    }
    Some(Assist {
        id: "extract-struct",
        title: "Extract struct from members of the ids".to_owned(),
        kind: AssistKind::Extract,
        edits,
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn uses_follow() {
        check(
            "extract-struct",
            "component c {
  ids {
    $0double x;
    long y[2];$0
    long z;
  };
  attribute set(in x, in z);
  task t { codel<start> f(in x, out y[0]::first, in z) yield ether; };
};
",
            "component c {
  struct data {
    double x;
    long y[2];
  };
  ids {
    data group;
    long z;
  };
  attribute set(in group.x, in z);
  task t { codel<start> f(in group.x, out group.y[0]::first, in z) yield ether; };
};
",
        );
    }

    #[test]
    fn types_of_the_ids_stay() {
        assert_not_offered(
            "extract-struct",
            "component c { ids { struct s { long x; } $0v; }; };\n",
        );
        assert_not_offered("extract-struct", "struct s { long x$0; };\n");
    }
}
