//! The declarations of a text outside functions.

use smol_str::SmolStr;
use tree_sitter::Node;

use super::{
    CType, Function, Include, Macro, Parameter, SourceIndex, body,
    comment::comments_above,
    ctype::{self, declared_name, source},
    preorder,
};

/// The context of a declaration.
#[derive(Clone, Default)]
struct Context {
    scope: Vec<SmolStr>,
    extern_c: bool,
}

pub(super) fn declarations(root: Node<'_>, text: &str, index: &mut SourceIndex) {
    let mut work = vec![(root, Context::default())];
    while let Some((node, context)) = work.pop() {
        let mut cursor = node.walk();
        for child in node.children(&mut cursor) {
            if let Some(inner) = declaration(child, &context, text, index) {
                work.push((child, inner));
            }
        }
    }
}

/// Reads one node. Returns the context of its children if they may be declarations.
fn declaration(
    node: Node<'_>,
    context: &Context,
    text: &str,
    index: &mut SourceIndex,
) -> Option<Context> {
    match node.kind() {
        "function_definition" => {
            if !definition(node, context, text, index) {
                loose(node, text, index);
            }
            None
        }
        "declaration" => {
            let ty = node.child_by_field_name("type");
            let from_macro = ty.is_some_and(|ty| ty.kind() == "macro_type_specifier");
            if from_macro || node.has_error() {
                loose(node, text, index);
            }
            prototypes(node, context, text, index);
            None
        }
        "type_definition" | "alias_declaration" | "using_declaration" => {
            names_of(node, text, index);
            None
        }
        "struct_specifier" | "union_specifier" | "enum_specifier" | "class_specifier" => {
            if let Some(name) = node.child_by_field_name("name") {
                index.names.insert(source(name, text).into());
            }
            None
        }
        "preproc_def" | "preproc_function_def" => {
            index.macros.extend(macro_of(node, text));
            None
        }
        "preproc_include" => {
            if let Some(path) = node.child_by_field_name("path") {
                let path = source(path, text);
                index.includes.push(Include {
                    path: path.trim_matches(['"', '<', '>']).to_owned(),
                    span: node.byte_range(),
                });
            }
            None
        }
        "linkage_specification" => {
            let value = node.child_by_field_name("value");
            let c = value.is_some_and(|child| source(child, text) == "\"C\"");
            Some(Context { extern_c: context.extern_c || c, ..context.clone() })
        }
        "namespace_definition" => Some(inside_namespace(node, context, text)),
        "declaration_list" | "template_declaration" => Some(context.clone()),
        "expression_statement" => {
            loose(node, text, index);
            None
        }
        "ERROR" => {
            loose(node, text, index);
            Some(context.clone())
        }
        kind if kind.starts_with("preproc_if") || kind.starts_with("preproc_el") => {
            Some(context.clone())
        }
        "comment" => None,
        _ => {
            loose(node, text, index);
            None
        }
    }
}

/// A macro; `None` without a name.
fn macro_of(node: Node<'_>, text: &str) -> Option<Macro> {
    let name = node.child_by_field_name("name")?;
    let value = node.child_by_field_name("value");
    let value = value.map_or("", |child| source(child, text));
    Some(Macro {
        name: source(name, text).into(),
        returns: ["return", "goto", "throw"].iter().any(|text| value.contains(text)),
        pastes: value.contains("##"),
    })
}

/// The context of the declarations of a namespace.
fn inside_namespace(node: Node<'_>, context: &Context, text: &str) -> Context {
    let mut context = context.clone();
    match node.child_by_field_name("name") {
        Some(name) => {
            let name = source(name, text);
            context.scope.extend(name.split("::").map(|part| part.trim().into()));
        }
        None => context.scope.push(SmolStr::default()),
    }
    context
}

fn loose(node: Node<'_>, text: &str, index: &mut SourceIndex) {
    preorder(node, |node| {
        // A function inside is found separately.
        if node.kind() == "function_definition" && node.child_by_field_name("body").is_some() {
            return false;
        }
        if matches!(node.kind(), "identifier" | "type_identifier") {
            index.loose.insert(source(node, text).into());
        }
        true
    });
}

fn names_of(node: Node<'_>, text: &str, index: &mut SourceIndex) {
    let mut cursor = node.walk();
    for field in ["declarator", "name"] {
        for declarator in node.children_by_field_name(field, &mut cursor) {
            let name = declared_name(declarator);
            let name = name.map_or("", |name| source(name, text));
            index.names.insert(name.into());
        }
    }
    // `using a::b;`
    if let Some(name) = node.named_child(0).filter(|child| child.kind() == "qualified_identifier") {
        let name = source(name, text);
        index.names.insert(name.rsplit("::").next().unwrap_or(name).into());
    }
}

fn prototypes(node: Node<'_>, context: &Context, text: &str, index: &mut SourceIndex) {
    let mut cursor = node.walk();
    let declarators: Vec<Node<'_>> =
        node.children_by_field_name("declarator", &mut cursor).collect();
    for declarator in declarators {
        match signature(node, declarator, context, text) {
            Some(function) => {
                index.names.insert(function.name.clone());
                index.functions.push(function);
            }
            None => {
                if let Some(name) = declared_name(declarator) {
                    index.names.insert(source(name, text).into());
                }
            }
        }
    }
    // A structure that is defined inside the declaration.
    if let Some(ty) =
        node.child_by_field_name("type").and_then(|child| child.child_by_field_name("name"))
        && node
            .child_by_field_name("type")
            .is_some_and(|child| child.child_by_field_name("body").is_some())
    {
        index.names.insert(source(ty, text).into());
    }
}

fn definition(node: Node<'_>, context: &Context, text: &str, index: &mut SourceIndex) -> bool {
    let (Some(declarator), Some(block)) =
        (node.child_by_field_name("declarator"), node.child_by_field_name("body"))
    else {
        return false;
    };
    let Some(mut function) = signature(node, declarator, context, text) else {
        return false;
    };
    if !function.known {
        loose(declarator, text, index);
    }
    function.body = Some(body::read(block, &function.parameters, text));
    function.comments = comments_above(node, text);
    index.names.insert(function.name.clone());
    index.functions.push(function);
    true
}

/// Reads a declaration of a function; `None` if the declarator is not a function.
fn signature(
    node: Node<'_>,
    declarator: Node<'_>,
    context: &Context,
    text: &str,
) -> Option<Function> {
    // The layers around the function declarator belong to the return type.
    let mut function = declarator;
    for _ in 0..64 {
        if function.kind() == "function_declarator" {
            break;
        }
        function = ctype::inner_declarator(function)?;
    }
    if function.kind() != "function_declarator" {
        return None;
    }
    let name = function.child_by_field_name("declarator")?;
    let list = function.child_by_field_name("parameters")?;
    if !matches!(name.kind(), "identifier" | "field_identifier" | "qualified_identifier") {
        return None;
    }
    let mut scope = context.scope.clone();
    let written = source(name, text);
    let written = written.strip_prefix("::").unwrap_or(written);
    let (qualifiers, short) = written.rsplit_once("::").unwrap_or(("", written));
    scope.extend(
        qualifiers.split("::").map(str::trim).filter(|part| !part.is_empty()).map(SmolStr::from),
    );

    let mut is_static = false;
    let mut start = None;
    let mut cursor = node.walk();
    for child in node.children(&mut cursor) {
        match child.kind() {
            "storage_class_specifier" => is_static |= source(child, text) == "static",
            "attribute_specifier" | "attribute_declaration" | "comment" => {}
            _ => start = start.or(Some(child.start_byte())),
        }
    }
    let (parameters, variadic, known) = parameters(list, text);
    let mut result = ctype::of_declaration(node, Some(declarator), text);
    if let Some(at) =
        result.layers.iter().position(|layer| matches!(layer, super::Layer::Function { .. }))
    {
        result.layers.remove(at);
    }
    Some(Function {
        name: short.trim().into(),
        name_span: name.end_byte() - short.trim().len()..name.end_byte(),
        scope,
        extern_c: context.extern_c,
        is_static,
        result,
        parameters,
        variadic,
        known,
        signature_span: start.unwrap_or(node.start_byte())..list.end_byte(),
        span: node.byte_range(),
        body: None,
        comments: Vec::new(),
    })
}

/// The parameters of a list. The flags are true for a list that ends with `...`, and for one of which all is
/// understood.
fn parameters(list: Node<'_>, text: &str) -> (Vec<Parameter>, bool, bool) {
    let mut known = !list.has_error();
    let mut parameters = Vec::new();
    let mut variadic = false;
    let mut cursor = list.walk();
    for child in list.named_children(&mut cursor) {
        match child.kind() {
            "parameter_declaration" | "optional_parameter_declaration" => {
                parameters.push(parameter(child, text));
            }
            "variadic_parameter" | "variadic_parameter_declaration" => variadic = true,
            "comment" => {}
            _ => known = false,
        }
    }
    if let [only] = parameters.as_slice()
        && only.name.is_none()
        && only.ty == CType::plain("void")
    {
        parameters.clear();
    }
    (parameters, variadic, known)
}

fn parameter(node: Node<'_>, text: &str) -> Parameter {
    let declarator = node.child_by_field_name("declarator");
    let name = declarator.and_then(declared_name);
    Parameter {
        name: name.map(|name| source(name, text).into()),
        ty: ctype::of_declaration(node, declarator, text),
        span: node.byte_range(),
    }
}
