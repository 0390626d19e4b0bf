//! The context of an identifier: its qualifiers, and the declaration it may belong to.

use smol_str::SmolStr;
use tree_sitter::Node;

use super::{Function, Grammar, Span, parse, preorder};

/// The scopes that are written before a name: `a` and `b` of `a::b::c`.
pub(crate) fn qualifiers(node: Node<'_>, text: &str) -> Vec<SmolStr> {
    let mut out = Vec::new();
    let mut at = node;
    while let Some(parent) = at.parent() {
        if parent.kind() != "qualified_identifier" {
            break;
        }
        let scope = parent.child_by_field_name("scope");
        if let Some(scope) = scope.filter(|scope| scope.id() != at.id()) {
            let name = text.get(scope.byte_range()).unwrap_or_default();
            out.push(SmolStr::from(name.trim()));
        }
        at = parent;
    }
    out.reverse();
    out
}

/// The scopes that `using namespace` opens in a file.
pub(crate) fn opened(root: Node<'_>, text: &str) -> Vec<Vec<SmolStr>> {
    let mut out = Vec::new();
    preorder(root, |node| {
        if node.kind() == "using_declaration" {
            let mut cursor = node.walk();
            let is_namespace = node.children(&mut cursor).any(|child| child.kind() == "namespace");
            let name = node.named_child(0).filter(|_| is_namespace);
            if let Some(name) = name.and_then(|name| text.get(name.byte_range())) {
                let path = name.trim_start_matches("::").split("::");
                out.push(path.map(|path| SmolStr::from(path.trim())).collect());
            }
        }
        true
    });
    out
}

/// True if the node is the name of a structure, enumeration or namespace that is defined there.
pub(crate) fn names_structure(node: Node<'_>) -> bool {
    node.parent().is_some_and(|parent| {
        parent.child_by_field_name("body").is_some()
            && parent.child_by_field_name("name") == Some(node)
    })
}

/// True if the node is the name of a function that is declared, defined or called.
pub(crate) fn is_function_name(node: Node<'_>) -> bool {
    node.parent().is_some_and(|parent| {
        let field = match parent.kind() {
            "function_declarator" => "declarator",
            "call_expression" => "function",
            _ => return false,
        };
        parent.child_by_field_name(field).is_some_and(|child| child.id() == node.id())
    })
}

/// True if the node is the name that a parameter declares.
pub(crate) fn names_parameter(node: Node<'_>) -> bool {
    let mut at = node;
    while let Some(parent) = at.parent() {
        match parent.kind() {
            "parameter_declaration" | "optional_parameter_declaration" => {
                return parent
                    .child_by_field_name("declarator")
                    .is_some_and(|child| child.id() == at.id());
            }
            // The length of an array is not a declared name.
            "array_declarator" if parent.child_by_field_name("size") == Some(at) => return false,
            kind if kind.ends_with("declarator") => at = parent,
            _ => return false,
        }
    }
    false
}

/// True if the node is the name that a parameter or variable declares.
pub(crate) fn is_declared(node: Node<'_>) -> bool {
    let mut at = node;
    while let Some(parent) = at.parent() {
        match parent.kind() {
            "parameter_declaration" | "optional_parameter_declaration" | "declaration" => {
                let mut cursor = parent.walk();
                return parent
                    .children_by_field_name("declarator", &mut cursor)
                    .any(|child| child.id() == at.id());
            }
            "init_declarator" if parent.child_by_field_name("value") == Some(at) => return false,
            "array_declarator" if parent.child_by_field_name("size") == Some(at) => return false,
            kind if kind.ends_with("declarator") => at = parent,
            _ => return false,
        }
    }
    false
}

/// The places of a parameter in a function: its declaration and its uses. Empty if the function declares
/// another variable of its name, or uses the new name for something else.
pub(crate) fn renamable(
    text: &str,
    grammar: Grammar,
    function: &Function,
    from: &str,
    to: &str,
) -> Vec<Span> {
    let tree = parse(text, grammar);
    let found = tree.as_ref().and_then(|tree| {
        let span = &function.span;
        let root = tree.root_node();
        root.descendant_for_byte_range(span.start, span.end)
    });
    let mut places = Vec::new();
    let (mut taken, mut declared) = (false, 0);
    if let Some(node) = found {
        preorder(node, |node| {
            if matches!(node.kind(), "identifier" | "preproc_arg") {
                let span = node.byte_range();
                let name = text.get(span.clone()).unwrap_or_default();
                taken |= name == to;
                if name == from && qualifiers(node, text).is_empty() {
                    declared += usize::from(is_declared(node));
                    places.push(span);
                }
            }
            true
        });
    }
    if taken || declared != 1 {
        places.clear();
    }
    places
}
