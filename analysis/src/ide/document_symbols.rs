//! The outline of a file: the nesting of its declarations.

use dotgen_syntax::{
    SyntaxNode,
    ast::{self, AstNode, HasBody},
};

use super::{DocumentSymbol, FileView, SymbolKind, render::one_line};
use crate::source_map::bytes;

pub(crate) fn document_symbols(view: &FileView<'_>) -> Vec<DocumentSymbol> {
    let mut out = Vec::new();
    items(view, view.parse().tree().items(), &mut out);
    out
}

fn items(
    view: &FileView<'_>,
    items: impl Iterator<Item = ast::Item>,
    out: &mut Vec<DocumentSymbol>,
) {
    for item in items {
        item_symbols(view, &item, out);
    }
}

fn item_symbols(view: &FileView<'_>, item: &ast::Item, out: &mut Vec<DocumentSymbol>) {
    let node = item.syntax();
    match item {
        ast::Item::Directive(directive) => out.extend(macro_symbol(view, directive)),
        ast::Item::Module(module) => {
            out.extend(with_body(view, module, module.name(), SymbolKind::Module));
        }
        ast::Item::Component(component) => {
            let kind = if component.is_interface() {
                SymbolKind::Interface
            } else {
                SymbolKind::Component
            };
            out.extend(with_body(view, component, component.name(), kind));
        }
        ast::Item::ConstDecl(constant) => {
            let ty = text(view, constant.type_spec());
            out.extend(symbol(view, node, constant.name(), SymbolKind::Const, ty));
        }
        ast::Item::TypedefDecl(typedef) => {
            let ty = typedef.type_spec();
            declarators(view, node, ty, typedef.declarators(), SymbolKind::Typedef, out);
        }
        ast::Item::NativeDecl(native) => {
            out.extend(symbol(view, node, native.name(), SymbolKind::Native, None));
        }
        ast::Item::ExceptionDecl(exception) => {
            for node in exception.exceptions() {
                out.extend(with_body(view, &node, node.name(), SymbolKind::Exception));
            }
        }
        ast::Item::TypeDecl(ty) => out.extend(type_symbols(view, ty.type_spec())),
        ast::Item::ForwardDecl(declaration) => out.extend(forward_symbol(view, declaration)),
        ast::Item::Ids(ids) => out.push(ids_symbol(view, ids)),
        ast::Item::Task(task) => {
            let mut found = with_body(view, task, task.name(), SymbolKind::Task);
            if let Some(found) = &mut found {
                found.detail = period(view, task.items());
            }
            out.extend(found);
        }
        ast::Item::Port(port) => port_symbols(view, port, out),
        ast::Item::Service(service) => out.extend(service_symbol(view, service)),
        ast::Item::Member(member) => {
            let ty = member.type_spec();
            declarators(view, node, ty, member.declarators(), SymbolKind::Member, out);
        }
        ast::Item::Case(case) => {
            let declared = case.declarator().into_iter();
            declarators(view, node, case.type_spec(), declared, SymbolKind::Member, out);
        }
        ast::Item::Property(node) => property(view, node, out),
    }
}

/// The forward declaration of a struct or union.
fn forward_symbol(view: &FileView<'_>, declaration: &ast::ForwardDecl) -> Option<DocumentSymbol> {
    let kind = match declaration.union_token() {
        Some(_) => SymbolKind::Union,
        None => SymbolKind::Struct,
    };
    let detail = Some("forward declaration".to_owned());
    symbol(view, declaration.syntax(), declaration.name(), kind, detail)
}

/// The macro that a directive defines.
fn macro_symbol(view: &FileView<'_>, directive: &ast::Directive) -> Option<DocumentSymbol> {
    if directive.kind() != ast::DirectiveKind::Define {
        return None;
    }
    let params = directive.params().map(|param| param.syntax().text().to_string());
    let node = directive.syntax();
    symbol(view, node, directive.name(), SymbolKind::Macro, params)
}

/// The ids with their members.
fn ids_symbol(view: &FileView<'_>, ids: &ast::Ids) -> DocumentSymbol {
    let range = bytes(view.node_range(ids.syntax()));
    let keyword = ids.ids_token().map(|token| bytes(view.token_range(&token)));
    let selection_range = keyword.unwrap_or(range.clone());
    let mut children = Vec::new();
    items(view, ids.items(), &mut children);
    DocumentSymbol {
        name: "ids".into(),
        detail: None,
        kind: SymbolKind::Ids,
        range: cover(&range, &selection_range),
        selection_range,
        children,
    }
}

/// A port, and the types declared in the place of its type.
fn port_symbols(view: &FileView<'_>, port: &ast::Port, out: &mut Vec<DocumentSymbol>) {
    out.extend(type_symbols(view, port.type_spec()));
    let dir = match (port.in_token(), port.out_token()) {
        (Some(_), _) => "in ",
        (_, Some(_)) => "out ",
        _ => "",
    };
    let multiple = if port.multiple_token().is_some() { "multiple " } else { "" };
    let ty = type_detail(view, port.type_spec()).unwrap_or_default();
    let detail = Some(format!("{multiple}{dir}{ty}"));
    out.extend(symbol(view, port.syntax(), port.name(), SymbolKind::Port, detail));
}

/// A service with its parameters as written.
fn service_symbol(view: &FileView<'_>, service: &ast::Service) -> Option<DocumentSymbol> {
    let kind = if service.attribute_token().is_some() {
        SymbolKind::Attribute
    } else if service.function_token().is_some() {
        SymbolKind::Function
    } else {
        SymbolKind::Activity
    };
    let mut found = with_body(view, service, service.name(), kind)?;
    found.detail = service.param_list().map(|param| one_line(view, param.syntax()));
    Some(found)
}

/// The declarators of an item, and the types declared in the place of its type.
fn declarators(
    view: &FileView<'_>,
    owner: &SyntaxNode,
    ty: Option<ast::TypeSpec>,
    declared: impl Iterator<Item = ast::Declarator>,
    kind: SymbolKind,
    out: &mut Vec<DocumentSymbol>,
) {
    out.extend(type_symbols(view, ty.clone()));
    let detail = type_detail(view, ty);
    out.extend(declared.filter_map(|one| declarator(view, owner, &one, kind, &detail)));
}

fn property(view: &FileView<'_>, property: &ast::Property, out: &mut Vec<DocumentSymbol>) {
    let node = property.syntax();
    let codel = match property {
        ast::Property::CodelProperty(property) => property.codel(),
        ast::Property::ValidateProperty(property) => property.codel(),
        ast::Property::LocalProperty(property) => {
            let detail = type_detail(view, property.type_spec());
            for declared in property.declarators() {
                out.extend(declarator(view, node, &declared, SymbolKind::Local, &detail));
            }
            None
        }
        _ => None,
    };
    if let Some(codel) = codel {
        let states = |node: Option<SyntaxNode>| node.map(|node| one_line(view, &node));
        let triggers = states(codel.triggers().map(|trigger| trigger.syntax().clone()));
        let yields = states(codel.yields().map(|yields| yields.syntax().clone()));
        let detail: Vec<String> = triggers.into_iter().chain(yields).collect();
        let detail = (!detail.is_empty()).then(|| detail.join(" "));
        out.extend(symbol(view, node, codel.name(), SymbolKind::Codel, detail));
    }
}

/// A struct, union or enum declared in the place of a type.
fn type_symbols(view: &FileView<'_>, ty: Option<ast::TypeSpec>) -> Option<DocumentSymbol> {
    match ty? {
        ast::TypeSpec::Struct(structure) => {
            with_body(view, &structure, structure.name(), SymbolKind::Struct)
        }
        ast::TypeSpec::Union(union) => {
            let mut found = with_body(view, &union, union.name(), SymbolKind::Union)?;
            found.detail = text(view, union.switch_type());
            // An enum declared as the switch type is part of the union.
            found.children.splice(0..0, type_symbols(view, union.switch_type()));
            Some(found)
        }
        ast::TypeSpec::Enum(enumeration) => {
            let mut found =
                symbol(view, enumeration.syntax(), enumeration.name(), SymbolKind::Enum, None)?;
            let enumerators = enumeration
                .enumerator_list()
                .into_iter()
                .flat_map(|enumerator| enumerator.enumerators());
            found.children = enumerators
                .filter_map(|enumerator| {
                    symbol(
                        view,
                        enumerator.syntax(),
                        enumerator.name(),
                        SymbolKind::Enumerator,
                        None,
                    )
                })
                .collect();
            Some(found)
        }
        _ => None,
    }
}

/// The type as written, without the body of one declared in place.
fn type_detail(view: &FileView<'_>, ty: Option<ast::TypeSpec>) -> Option<String> {
    let name = match ty.as_ref()? {
        ast::TypeSpec::Struct(structure) => structure.name(),
        ast::TypeSpec::Union(union) => union.name(),
        ast::TypeSpec::Enum(enumeration) => enumeration.name(),
        _ => return text(view, ty),
    };
    Some(name?.text(view.map()).to_string())
}

fn declarator(
    view: &FileView<'_>,
    owner: &SyntaxNode,
    declarator: &ast::Declarator,
    kind: SymbolKind,
    detail: &Option<String>,
) -> Option<DocumentSymbol> {
    let dimensions: String =
        declarator.dimensions().map(|dimension| one_line(view, dimension.syntax())).collect();
    let detail = detail.as_ref().map(|detail| format!("{detail}{dimensions}"));
    symbol(view, owner, declarator.name(), kind, detail)
}

fn with_body(
    view: &FileView<'_>,
    body: &impl HasBody,
    name: Option<ast::Name>,
    kind: SymbolKind,
) -> Option<DocumentSymbol> {
    let mut children = Vec::new();
    items(view, body.items(), &mut children);
    let mut found = match symbol(view, body.syntax(), name, kind, None) {
        Some(found) => found,
        // While the name is being typed, the nested declarations keep their place.
        None if children.is_empty() => return None,
        None => unnamed(view, body.syntax(), kind)?,
    };
    found.children = children;
    Some(found)
}

fn unnamed(view: &FileView<'_>, node: &SyntaxNode, kind: SymbolKind) -> Option<DocumentSymbol> {
    let keyword =
        node.children_with_tokens().find(|element| element.kind().is_keyword())?.into_token()?;
    let selection_range = bytes(view.token_range(&keyword));
    Some(DocumentSymbol {
        name: format!("({} without name)", keyword.text()),
        detail: None,
        kind,
        range: cover(&bytes(view.node_range(node)), &selection_range),
        selection_range,
        children: Vec::new(),
    })
}

fn symbol(
    view: &FileView<'_>,
    node: &SyntaxNode,
    name: Option<ast::Name>,
    kind: SymbolKind,
    detail: Option<String>,
) -> Option<DocumentSymbol> {
    let token = name?.ident_token()?;
    let text = view.map().text(&token);
    if text.is_empty() {
        return None;
    }
    let selection_range = bytes(view.token_range(&token));
    Some(DocumentSymbol {
        name: text.to_string(),
        detail,
        kind,
        range: cover(&bytes(view.node_range(node)), &selection_range),
        selection_range,
        children: Vec::new(),
    })
}

fn cover(a: &std::ops::Range<usize>, b: &std::ops::Range<usize>) -> std::ops::Range<usize> {
    a.start.min(b.start)..a.end.max(b.end)
}

fn text(view: &FileView<'_>, node: Option<impl AstNode>) -> Option<String> {
    Some(one_line(view, node?.syntax()))
}

fn period(view: &FileView<'_>, items: impl Iterator<Item = ast::Item>) -> Option<String> {
    items.into_iter().find_map(|item| match item {
        ast::Item::Property(ast::Property::DurationProperty(property))
            if property.period_token().is_some() =>
        {
            Some(format!("period {}", text(view, property.quantity())?))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use expect_test::{Expect, expect};

    use crate::{ide::DocumentSymbol, test_support::Fixture};

    fn dump(text: &str, symbols: &[DocumentSymbol], depth: usize, out: &mut String) {
        for symbol in symbols {
            assert!(symbol.range.start <= symbol.selection_range.start, "{symbol:?}");
            assert!(symbol.selection_range.end <= symbol.range.end, "{symbol:?}");
            let detail = symbol.detail.as_deref().unwrap_or_default();
            let selected = &text[symbol.selection_range.clone()];
            let indent = "  ".repeat(depth);
            writeln!(out, "{indent}{:?} {} [{selected}] {detail}", symbol.kind, symbol.name)
                .unwrap();
            for child in &symbol.children {
                assert!(symbol.range.start <= child.range.start, "{child:?}");
                assert!(child.range.end <= symbol.range.end, "{child:?}");
            }
            dump(text, &symbol.children, depth + 1, out);
        }
    }

    #[track_caller]
    fn check(text: &str, expected: Expect) {
        let fixture = Fixture::new(text);
        let symbols = fixture.analysis().document_symbols("/main.gen".into()).unwrap();
        let mut out = String::new();
        dump(&fixture.text("/main.gen"), &symbols, 0, &mut out);
        expected.assert_eq(&out);
    }

    #[test]
    fn types() {
        check(
            r"
#define N 3
#define F(x, y) x
module m {
  const long a = 1;
  typedef struct s { long x, y[2]; } t, u[3];
  enum e { A, B };
  union v switch (e) { case A: long a; default: e b; };
  struct later;
  exception x, z { string<4> why; };
  native n;
};
",
            expect![[r"
                Macro N [N] 
                Macro F [F] (x, y)
                Module m [m] 
                  Const a [a] long
                  Struct s [s] 
                    Member x [x] long
                    Member y [y] long[2]
                  Typedef t [t] s
                  Typedef u [u] s[3]
                  Enum e [e] 
                    Enumerator A [A] 
                    Enumerator B [B] 
                  Union v [v] e
                    Member a [a] long
                    Member b [b] e
                  Struct later [later] forward declaration
                  Exception x [x] 
                  Exception z [z] 
                    Member why [why] string<4>
                  Native n [n] 
            "]],
        );
    }

    #[test]
    fn components() {
        check(
            r#"
interface i { port multiple in long q; };
component c {
  version "1";
  ids { long v; sequence<double, 4> w; };
  task t { period 10 ms; codel<start> idle() yield ether; };
  port out long p { doc "Out."; };
  attribute set(in v = 1, out w);
  function f() { codel g(ids in v); };
  activity go(in long speed) {
    local long tmp;
    validate check(local in speed);
    async codel<start, step> begin(local in speed) yield pause::start, ether;
  };
};
"#,
            expect![[r"
                Interface i [i] 
                  Port q [q] multiple in long
                Component c [c] 
                  Ids ids [ids] 
                    Member v [v] long
                    Member w [w] sequence<double, 4>
                  Task t [t] period 10 ms
                    Codel idle [idle] <start> yield ether
                  Port p [p] out long
                  Attribute set [set] (in v = 1, out w)
                  Function f [f] ()
                    Codel g [g] 
                  Activity go [go] (in long speed)
                    Local tmp [tmp] long
                    Codel check [check] 
                    Codel begin [begin] <start, step> yield pause::start, ether
            "]],
        );
    }

    #[test]
    fn names_from_macros_and_unfinished_text() {
        check(
            "#define T(n) task n { period 1 ms; }\ncomponent c { T(fast); };\n",
            expect![[r"
            Macro T [T] (n)
            Component c [c] 
              Task fast [fast] period 1 ms
        "]],
        );
        check(
            "component c { ids { long ; }; port in long",
            expect![[r"
            Component c [c] 
              Ids ids [ids] 
        "]],
        );
        check(
            "component { task t; };",
            expect![[r"
            Component (component without name) [component] 
              Task t [t] 
        "]],
        );
    }
}
