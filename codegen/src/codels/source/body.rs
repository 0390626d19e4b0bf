//! The events that a function body returns, and the exceptions it raises.

mod names;

use rustc_hash::{FxHashMap, FxHashSet};
use smol_str::SmolStr;
use tree_sitter::Node;

use super::{
    Body, Call, Parameter, Return, Throw, Value,
    ctype::{compact, declared_name, source},
    preorder,
};

/// The text in the samples of the skeleton.
const SAMPLE: &str = "skeleton sample: insert your code";

/// Reads the block of a function.
pub(super) fn read(block: Node<'_>, parameters: &[Parameter], text: &str) -> Body {
    let mut reader = Reader {
        text,
        body: Body {
            span: block.byte_range(),
            broken: block.has_error(),
            sample: source(block, text).contains(SAMPLE),
            returns: Vec::new(),
            calls: Vec::new(),
            throws: Vec::new(),
            mentions: FxHashSet::default(),
            escaping: FxHashSet::default(),
            free: Vec::new(),
            constant_writes: Vec::new(),
        },
        variables: FxHashMap::default(),
        calls: FxHashMap::default(),
    };
    for name in parameters.iter().filter_map(|parameter| parameter.name.as_ref()) {
        reader.variable(name.clone()).unknown = true;
    }
    let mut returns = Vec::new();
    preorder(block, |node| reader.node(node, &mut returns));
    let names = names::BlockNames::of(block, parameters, text);
    reader.body.escaping.clone_from(&names.escaping);
    reader.body.free = names.free(parameters);
    reader.body.constant_writes = names.constant_writes(parameters);
    for node in returns {
        let values = node.named_child(0).filter(|child| child.kind() != "comment");
        let Some(value) = values else { continue };
        let mut out = Vec::new();
        reader.values(value, false, &mut FxHashSet::default(), &mut out);
        reader.body.returns.push(Return { span: node.byte_range(), values: out });
    }
    reader.body
}

/// Members of a port that write nothing.
const IDLE_MEMBERS: [&str; 4] = ["data", "read", "open", "close"];

/// True if the use of a name writes no port: a call `NAME->data(…)`, or `(void)NAME;`.
pub(super) fn is_idle(node: Node<'_>, text: &str) -> bool {
    let Some(around) = node.parent() else {
        return false;
    };
    let Some(outer) = around.parent() else {
        return false;
    };
    let field = |of: Node<'_>, name, value: Node<'_>| of.child_by_field_name(name) == Some(value);
    match around.kind() {
        "field_expression" => {
            let member = around.child_by_field_name("field").map(|member| source(member, text));
            field(around, "argument", node)
                && member.is_some_and(|member| IDLE_MEMBERS.contains(&member))
                && outer.kind() == "call_expression"
                && field(outer, "function", around)
        }
        "cast_expression" => {
            let ty = around.child_by_field_name("type").map(|ty| source(ty, text));
            ty.is_some_and(|ty| ty.trim() == "void") && outer.kind() == "expression_statement"
        }
        _ => false,
    }
}

struct Reader<'t> {
    text: &'t str,
    body: Body,
    variables: FxHashMap<SmolStr, Variable<'t>>,
    /// Index of the call of a node.
    calls: FxHashMap<usize, usize>,
}

/// A variable of the function; inner scopes are not distinguished.
#[derive(Default)]
struct Variable<'t> {
    /// The expressions assigned to it.
    assigned: Vec<Node<'t>>,
    /// True if it may have another value: it is a parameter, or its address is taken.
    unknown: bool,
}

impl<'t> Reader<'t> {
    fn variable(&mut self, name: SmolStr) -> &mut Variable<'t> {
        self.variables.entry(name).or_default()
    }

    fn node(&mut self, node: Node<'t>, returns: &mut Vec<Node<'t>>) -> bool {
        match node.kind() {
            // A `return` inside returns from the lambda, not from the codel.
            "lambda_expression" => return false,
            "identifier" => {
                self.body.mentions.insert(source(node, self.text).into());
            }
            "return_statement" => returns.push(node),
            "throw_statement" => self.throw(node),
            "call_expression" => self.call(node),
            "declaration" => {
                let mut cursor = node.walk();
                for declarator in node.children_by_field_name("declarator", &mut cursor) {
                    self.declarator(declarator);
                }
            }
            "for_range_loop" | "parameter_declaration" => {
                let declarator = node.child_by_field_name("declarator");
                if let Some(name) = declarator.and_then(declared_name) {
                    self.variable(source(name, self.text).into()).unknown = true;
                }
            }
            "assignment_expression" => {
                let left = node.child_by_field_name("left");
                if let Some(left) = left.filter(|child| child.kind() == "identifier") {
                    let name: SmolStr = source(left, self.text).into();
                    let plain = node.child_by_field_name("operator");
                    let plain = plain.is_none_or(|child| child.kind() == "=");
                    let right = node.child_by_field_name("right").filter(|_| plain);
                    // An assignment alone does not declare a variable of the function.
                    let variable = self.variable(name);
                    match right {
                        Some(right) => variable.assigned.push(right),
                        None => variable.unknown = true,
                    }
                }
            }
            "pointer_expression" => {
                let address = node.child(0).is_some_and(|child| child.kind() == "&");
                let argument = node.child_by_field_name("argument").filter(|_| address);
                if let Some(name) = argument.filter(|argument| argument.kind() == "identifier") {
                    self.variable(source(name, self.text).into()).unknown = true;
                }
            }
            _ => {}
        }
        true
    }

    fn declarator(&mut self, declarator: Node<'t>) {
        let value = declarator.child_by_field_name("value");
        let Some(name) = declared_name(declarator) else {
            return;
        };
        let variable = self.variable(source(name, self.text).into());
        variable.assigned.extend(value);
    }

    fn call(&mut self, node: Node<'t>) {
        let Some(function) = node.child_by_field_name("function") else {
            return;
        };
        if !matches!(function.kind(), "identifier" | "qualified_identifier") {
            return;
        }
        let arguments = node.child_by_field_name("arguments");
        let mut all = Vec::new();
        if let Some(arguments) = arguments {
            let mut cursor = arguments.walk();
            let found = arguments.named_children(&mut cursor);
            all.extend(found.filter(|child| child.kind() != "comment"));
        }
        let last = all.last().filter(|node| node.kind() == "identifier");
        let parent = node.parent();
        self.calls.insert(node.id(), self.body.calls.len());
        self.body.calls.push(Call {
            name: compact(source(function, self.text)).into(),
            span: function.byte_range(),
            arguments: all.len(),
            last: last.map(|node| source(*node, self.text).into()),
            statement: parent.is_some_and(|parent| parent.kind() == "expression_statement"),
        });
    }

    fn throw(&mut self, node: Node<'t>) {
        let Some(value) = node.named_child(0) else {
            // A rethrow of a caught exception.
            return;
        };
        let name = match value.kind() {
            "call_expression" => value.child_by_field_name("function"),
            "compound_literal_expression" => value.child_by_field_name("type"),
            _ => None,
        };
        let named = name.filter(|name| {
            matches!(name.kind(), "identifier" | "qualified_identifier" | "type_identifier")
        });
        self.body.throws.extend(named.map(|name| Throw {
            name: compact(source(name, self.text)).into(),
            span: name.byte_range(),
        }));
    }

    /// The possible values of an expression.
    fn values(
        &self,
        node: Node<'t>,
        variable: bool,
        seen: &mut FxHashSet<SmolStr>,
        out: &mut Vec<Value>,
    ) {
        // Deeper nesting does not occur in written code.
        if out.len() > 256 || seen.len() > 64 {
            out.push(Value::Unknown);
            return;
        }
        let mut node = node;
        loop {
            let inner = match node.kind() {
                "parenthesized_expression" => node.named_child(0),
                "cast_expression" => node.child_by_field_name("value"),
                "comma_expression" | "assignment_expression" => node.child_by_field_name("right"),
                _ => break,
            };
            match inner {
                Some(inner) => node = inner,
                None => break,
            }
        }
        match node.kind() {
            "identifier" => {
                let name: SmolStr = source(node, self.text).into();
                let Some(known) = self.variables.get(&name) else {
                    out.push(Value::Name { name, span: node.byte_range(), variable });
                    return;
                };
                if known.unknown {
                    out.push(Value::Unknown);
                }
                if seen.insert(name) {
                    for assigned in &known.assigned {
                        self.values(*assigned, true, seen, out);
                    }
                }
            }
            "qualified_identifier" => out.push(Value::Name {
                name: compact(source(node, self.text)).into(),
                span: node.byte_range(),
                variable,
            }),
            "conditional_expression" => {
                for field in ["consequence", "alternative"] {
                    match node.child_by_field_name(field) {
                        Some(branch) if !is_long_conditional_chain(branch) => {
                            self.values(branch, variable, seen, out);
                        }
                        _ => out.push(Value::Unknown),
                    }
                }
            }
            "call_expression" => match self.calls.get(&node.id()) {
                Some(&call) => out.push(Value::Call { call, variable }),
                None => out.push(Value::Unknown),
            },
            _ => out.push(Value::Unknown),
        }
    }
}

/// True for longer chains of conditionals, which are generated and not followed.
fn is_long_conditional_chain(node: Node<'_>) -> bool {
    let mut depth = 0;
    let mut at = Some(node);
    while let Some(node) = at {
        depth += 1;
        if depth > 48 {
            return true;
        }
        at = match node.kind() {
            "parenthesized_expression" => node.named_child(0),
            "conditional_expression" => node.child_by_field_name("alternative"),
            _ => None,
        };
    }
    false
}
