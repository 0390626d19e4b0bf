//! Writes `generated.rs` from `genom.ungram`.
//!
//! Runs as a test: the test rewrites the file if it is stale and then fails, so that the change is reviewed
//! and committed.

use std::{
    fmt::Write as _,
    io::Write as _,
    path::Path,
    process::{Command, Stdio},
};

use ungrammar::{Grammar, Node, Rule};

use crate::kind::SyntaxKind;

#[test]
fn generated_ast_is_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(root.join("genom.ungram")).expect("genom.ungram");
    let grammar: Grammar = source.parse().expect("genom.ungram parses");
    let new = rustfmt(&generate(&grammar));
    let target = root.join("src/ast/generated.rs");
    let old = std::fs::read_to_string(&target).unwrap_or_default();
    if old != new {
        std::fs::write(&target, new).expect("write generated.rs");
        panic!(
            "src/ast/generated.rs was not up to date; it is now: look at the change and commit it"
        );
    }
}

/// One accessor of a node.
struct Field {
    name: String,
    shape: Shape,
}

#[derive(PartialEq)]
enum Shape {
    /// First token of this kind.
    Token(SyntaxKind),
    /// First child of this type.
    Child(String),
    /// All children of this type.
    Children(String),
}

fn generate(grammar: &Grammar) -> String {
    let mut out = String::from(
        "//! Typed nodes. Generated from `genom.ungram` by `ast/generator.rs`; do not edit.\n\n\
         use crate::{SyntaxKind::*, SyntaxToken, ast::traits::{AstChildren, AstNode, choice, node, support}};\n\n",
    );
    for node in grammar.iter() {
        let name = &grammar[node].name;
        if let Some(variants) = enum_variants(grammar, node) {
            let _ = writeln!(out, "choice! {{ {name}: {} }}\n", variants.join(", "));
        } else {
            let mut fields = Vec::new();
            collect(grammar, &grammar[node].rule, None, false, &mut fields);
            generate_struct(&mut out, name, &fields);
        }
    }
    out
}

/// The alternatives of a rule that only chooses between nodes.
fn enum_variants(grammar: &Grammar, node: Node) -> Option<Vec<String>> {
    let Rule::Alt(alternatives) = &grammar[node].rule else {
        return None;
    };
    alternatives
        .iter()
        .map(|alternative| match alternative {
            Rule::Node(node) => Some(grammar[*node].name.clone()),
            _ => None,
        })
        .collect()
}

fn collect(grammar: &Grammar, rule: &Rule, label: Option<&str>, many: bool, acc: &mut Vec<Field>) {
    match rule {
        Rule::Labeled { label, rule } => collect(grammar, rule, Some(label), many, acc),
        Rule::Node(node) => {
            let ty = grammar[*node].name.clone();
            let default = snake(&ty);
            let (name, shape) = if many {
                let name = label.map_or_else(|| plural(&default), str::to_owned);
                (name, Shape::Children(ty))
            } else {
                (label.map_or(default, str::to_owned), Shape::Child(ty))
            };
            push(acc, Field { name, shape });
        }
        Rule::Token(token) => {
            if let Some(label) = label {
                let kind = token_kind(&grammar[*token].name);
                push(acc, Field { name: format!("{label}_token"), shape: Shape::Token(kind) });
            }
        }
        Rule::Seq(rules) => {
            // `A (',' A)*` is a list of `A`.
            if let [Rule::Node(first), Rule::Rep(rest)] = rules.as_slice()
                && let Rule::Seq(rest) = &**rest
                && let [Rule::Token(_), Rule::Node(next)] = rest.as_slice()
                && first == next
            {
                collect(grammar, &rules[0], label, true, acc);
                return;
            }
            for rule in rules {
                collect(grammar, rule, label, many, acc);
            }
        }
        Rule::Alt(rules) => {
            for rule in rules {
                collect(grammar, rule, label, many, acc);
            }
        }
        Rule::Opt(rule) => collect(grammar, rule, label, many, acc),
        Rule::Rep(rule) => collect(grammar, rule, label, true, acc),
    }
}

fn push(acc: &mut Vec<Field>, field: Field) {
    match acc.iter().find(|other| other.name == field.name) {
        Some(old) => assert!(old.shape == field.shape, "two meanings of {}", field.name),
        None => acc.push(field),
    }
}

fn token_kind(text: &str) -> SyntaxKind {
    if text == "#ident" {
        return SyntaxKind::IDENT;
    }
    let found = SyntaxKind::spellings().iter().find(|(_, spelling)| *spelling == text);
    found.unwrap_or_else(|| panic!("unknown token {text}")).0
}

fn generate_struct(out: &mut String, name: &str, fields: &[Field]) {
    let _ = writeln!(out, "node! {{ {name}: {} }}", snake(name).to_uppercase());
    if fields.is_empty() {
        return;
    }
    let _ = writeln!(out, "impl {name} {{");
    for Field { name, shape } in fields {
        let _ = match shape {
            Shape::Token(kind) => writeln!(
                out,
                "pub fn {name}(&self) -> Option<SyntaxToken> {{ support::token(self.syntax(), {kind:?}) }}"
            ),
            Shape::Child(ty) => writeln!(
                out,
                "pub fn {name}(&self) -> Option<{ty}> {{ support::child(self.syntax()) }}"
            ),
            Shape::Children(ty) => writeln!(
                out,
                "pub fn {name}(&self) -> AstChildren<{ty}> {{ support::children(self.syntax()) }}"
            ),
        };
    }
    out.push_str("}\n\n");
}

fn snake(name: &str) -> String {
    let mut out = String::new();
    for (index, c) in name.char_indices() {
        if c.is_uppercase() && index > 0 {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
    }
    out
}

fn plural(name: &str) -> String {
    match name.strip_suffix('y') {
        Some(stem) => format!("{stem}ies"),
        None => format!("{name}s"),
    }
}

fn rustfmt(text: &str) -> String {
    let mut child = Command::new("rustfmt")
        .args(["--edition", "2024", "--config", "use_small_heuristics=Max"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("rustfmt runs (rustup component add rustfmt)");
    child.stdin.take().expect("piped").write_all(text.as_bytes()).expect("rustfmt reads");
    let output = child.wait_with_output().expect("rustfmt ends");
    assert!(output.status.success(), "rustfmt rejects the generated text:\n{text}");
    String::from_utf8(output.stdout).expect("UTF-8")
}
