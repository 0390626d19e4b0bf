//! Names that a function uses and does not declare, and writes to its constant parameters.

use rustc_hash::FxHashSet;
use smol_str::SmolStr;
use tree_sitter::Node;

use super::is_idle;
use crate::codels::source::{
    Layer, Parameter, Span,
    ctype::{declared_name, source},
};

/// The names that a block declares, uses and writes.
#[derive(Default)]
pub(super) struct BlockNames {
    declared: FxHashSet<SmolStr>,
    /// Values, in text order.
    used: Vec<(SmolStr, Span)>,
    /// Names that a macro may declare.
    in_macros: FxHashSet<SmolStr>,
    /// Left sides with one dereference: the pointer, and the whole left side.
    written: Vec<(SmolStr, Span)>,
    /// Parameters with a use that may write a port.
    pub(super) escaping: FxHashSet<SmolStr>,
}

#[derive(Clone, Copy, Default)]
struct NodeContext {
    /// The kind of the parent.
    parent: &'static str,
    /// True if it is compiled only under a preprocessor condition.
    conditional: bool,
    /// True inside the arguments of a possible macro, or in a lambda: names may be declared there.
    declares: bool,
}

impl BlockNames {
    pub(super) fn of(block: Node<'_>, parameters: &[Parameter], text: &str) -> BlockNames {
        let mut out = BlockNames::default();
        let mut cursor = block.walk();
        let mut around = vec![NodeContext::default()];
        loop {
            let node = cursor.node();
            let here = around.last().copied().unwrap_or_default();
            out.node(node, cursor.field_name(), here, text);
            if node.kind() == "identifier" {
                let name = source(node, text);
                let mut names = parameters.iter().filter_map(|parameter| parameter.name.as_ref());
                if names.any(|parameter| parameter == name) && !is_idle(node, text) {
                    out.escaping.insert(name.into());
                }
            }
            if cursor.goto_first_child() {
                around.push(NodeContext {
                    parent: node.kind(),
                    conditional: here.conditional || node.kind().starts_with("preproc"),
                    declares: here.declares || declares(node),
                });
                continue;
            }
            while !cursor.goto_next_sibling() {
                around.pop();
                if !cursor.goto_parent() {
                    return out;
                }
            }
        }
    }

    fn node(&mut self, node: Node<'_>, field: Option<&str>, around: NodeContext, text: &str) {
        let name = |node: Node<'_>| SmolStr::from(source(node, text));
        match node.kind() {
            "declaration" => {
                let mut cursor = node.walk();
                for child in node.children_by_field_name("declarator", &mut cursor) {
                    self.declare(child, text);
                }
            }
            "parameter_declaration" | "optional_parameter_declaration" | "for_range_loop" => {
                if let Some(child) = node.child_by_field_name("declarator") {
                    self.declare(child, text);
                }
            }
            "enumerator" | "preproc_def" | "preproc_function_def" => {
                self.declared.extend(node.child_by_field_name("name").map(name));
            }
            "assignment_expression" if !around.conditional && !around.declares => {
                let left = node.child_by_field_name("left");
                self.written.extend(left.and_then(|child| through(child, text)));
            }
            "update_expression" if !around.conditional && !around.declares => {
                let of = node.child_by_field_name("argument");
                self.written.extend(of.and_then(|child| through(child, text)));
            }
            // Members of local classes are names in the functions of these classes.
            "field_identifier" => {
                self.declared.insert(name(node));
            }
            "using_declaration" => {
                let last = source(node, text).rsplit("::").next().unwrap_or_default();
                let last = last.trim_end_matches(';').trim();
                self.declared.insert(last.into());
            }
            "identifier" if around.declares => {
                self.in_macros.insert(name(node));
            }
            "identifier" if is_value(around.parent, field) && !around.conditional => {
                self.used.push((name(node), node.byte_range()));
            }
            _ => {}
        }
    }

    fn declare(&mut self, declarator: Node<'_>, text: &str) {
        let inner = declarator.child_by_field_name("declarator");
        let several = [Some(declarator), inner].into_iter().flatten();
        let several =
            several.filter(|declarator| declarator.kind() == "structured_binding_declarator");
        for declarator in several {
            let mut cursor = declarator.walk();
            let names = declarator.named_children(&mut cursor);
            self.declared.extend(names.map(|name| SmolStr::from(source(name, text))));
        }
        if let Some(name) = declared_name(declarator) {
            self.declared.insert(source(name, text).into());
        }
    }

    /// Names that are not declared in the function, each at its first use.
    pub(super) fn free(&self, parameters: &[Parameter]) -> Vec<(SmolStr, Span)> {
        let parameters = parameters.iter().filter_map(|parameter| parameter.name.as_ref());
        let mut known: FxHashSet<&SmolStr> = parameters.collect();
        known.extend(self.declared.iter().chain(&self.in_macros));
        let used = self.used.iter();
        used.filter(|(name, _)| known.insert(name)).cloned().collect()
    }

    /// Writes through parameters that point to constants.
    pub(super) fn constant_writes(&self, parameters: &[Parameter]) -> Vec<(SmolStr, Span)> {
        let constant = |parameter: &Parameter| {
            parameter.ty.constant
                && matches!(
                    parameter.ty.layers.as_slice(),
                    [Layer::Pointer { .. } | Layer::Array { .. }]
                )
        };
        let constant = parameters.iter().filter(|parameter| constant(parameter));
        let names: FxHashSet<&SmolStr> = constant
            .filter_map(|constant| constant.name.as_ref())
            .filter(|name| !self.declared.contains(*name))
            .collect();
        let written = self.written.iter();
        written.filter(|(name, _)| names.contains(name)).cloned().collect()
    }
}

/// True if an identifier is a value: neither a called function, nor part of another name.
fn is_value(parent: &str, field: Option<&str>) -> bool {
    match parent {
        "call_expression" => field != Some("function"),
        "qualified_identifier" | "template_function" => false,
        kind => !kind.starts_with("preproc"),
    }
}

/// True if the node may contain declarations that cannot be read.
fn declares(node: Node<'_>) -> bool {
    if node.kind() == "lambda_expression" {
        return true;
    }
    let function = node.child_by_field_name("function");
    let function = function
        .filter(|function| node.kind() == "call_expression" && function.kind() == "identifier");
    function.is_some()
}

/// Maximum number of parentheses and members of a left side that are followed.
const MEMBERS: usize = 16;

/// The pointer that a left side dereferences, if it dereferences no other: `*p`, `p->a.b`, `p[0].a`.
fn through(left: Node<'_>, text: &str) -> Option<(SmolStr, Span)> {
    let mut node = left;
    for _ in 0..MEMBERS {
        let inner = match node.kind() {
            "parenthesized_expression" => node.named_child(0)?,
            "field_expression" => {
                let of = node.child_by_field_name("argument")?;
                let arrow = node.child_by_field_name("operator")?.kind() == "->";
                if arrow {
                    return pointer(of, left, text);
                }
                of
            }
            "pointer_expression" if node.child(0)?.kind() == "*" => {
                return pointer(node.child_by_field_name("argument")?, left, text);
            }
            "subscript_expression" => {
                return pointer(node.child_by_field_name("argument")?, left, text);
            }
            _ => return None,
        };
        node = inner;
    }
    None
}

fn pointer(node: Node<'_>, left: Node<'_>, text: &str) -> Option<(SmolStr, Span)> {
    let is_name = node.kind() == "identifier";
    is_name.then(|| (source(node, text).into(), left.byte_range()))
}
