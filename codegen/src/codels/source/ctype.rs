//! C and C++ types, for the comparison of two spellings of one function parameter.

use smol_str::SmolStr;
use tree_sitter::Node;

/// One step from a declared name outwards to its base type.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Layer {
    /// `*`, with the `const` that follows it.
    Pointer {
        /// `* const`
        constant: bool,
    },
    /// `&` or `&&`.
    Reference {
        /// `&&`
        rvalue: bool,
    },
    /// `[length]`
    Array {
        /// Text between the brackets without blanks, `None` if empty.
        length: Option<SmolStr>,
    },
    /// `(parameters)`, stored as text.
    Function {
        /// The parameters without blanks.
        parameters: SmolStr,
    },
}

/// A type: its base and the layers around it, from the declared name outwards.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct CType {
    /// Base type without qualifiers, storage classes and `struct`, with normalized blanks.
    pub base: SmolStr,
    /// True if the base type is `const`.
    pub constant: bool,
    /// Outermost first: `const T (*v)[3]` is a pointer to an array.
    pub layers: Vec<Layer>,
}

impl CType {
    /// A base type without layers.
    pub fn plain(base: &str) -> CType {
        CType { base: base.into(), ..CType::default() }
    }

    /// The type that the compiler uses for a function parameter: the outermost array is a pointer, and the
    /// outermost `const` is removed. The second part is the length of the array.
    pub(crate) fn as_parameter(&self) -> (CType, Option<SmolStr>) {
        let mut ty = self.clone();
        let mut length = None;
        match ty.layers.first_mut() {
            None => ty.constant = false,
            Some(Layer::Pointer { constant }) => *constant = false,
            Some(layer @ Layer::Array { .. }) => {
                let pointer = Layer::Pointer { constant: false };
                if let Layer::Array { length: found } = std::mem::replace(layer, pointer) {
                    length = found;
                }
            }
            Some(Layer::Reference { .. } | Layer::Function { .. }) => {}
        }
        (ty, length)
    }

    /// The type without any `const`.
    pub(crate) fn without_const(&self) -> CType {
        let mut ty = self.clone();
        ty.constant = false;
        for layer in &mut ty.layers {
            if let Layer::Pointer { constant } = layer {
                *constant = false;
            }
        }
        ty
    }

    /// Replaces the base type by the definition of an alias.
    pub fn expand(&self, alias: &CType) -> CType {
        let mut alias = alias.clone();
        if self.constant {
            match alias.layers.iter_mut().find(|layer| !matches!(layer, Layer::Array { .. })) {
                Some(Layer::Pointer { constant }) => *constant = true,
                Some(_) => {}
                None => alias.constant = true,
            }
        }
        let mut layers = self.layers.clone();
        layers.append(&mut alias.layers);
        CType { base: alias.base, constant: alias.constant, layers }
    }
}

/// Reads the type that a declaration node gives to its declarator (or abstract declarator).
pub(super) fn of_declaration(node: Node<'_>, declarator: Option<Node<'_>>, text: &str) -> CType {
    let mut words = Words::default();
    let mut cursor = node.walk();
    for child in node.children(&mut cursor) {
        if declarator.is_some_and(|declarator| declarator.id() == child.id()) {
            break;
        }
        specifier(child, text, &mut words);
    }
    let mut ty =
        CType { base: base_name(&words.words), constant: words.constant, layers: Vec::new() };
    if let Some(declarator) = declarator {
        let mut layers = Vec::new();
        collect_layers(declarator, text, &mut layers);
        layers.reverse();
        ty.layers = layers;
    }
    ty
}

#[derive(Default)]
struct Words {
    words: Vec<String>,
    constant: bool,
}

fn specifier(node: Node<'_>, text: &str, out: &mut Words) {
    match node.kind() {
        "comment"
        | "storage_class_specifier"
        | "attribute_specifier"
        | "attribute_declaration"
        | "ms_declspec_modifier"
        | "virtual"
        | "explicit_function_specifier"
        | "=" => {}
        "type_qualifier" => {
            if matches!(source(node, text), "const" | "constexpr") {
                out.constant = true;
            }
        }
        "struct_specifier" | "union_specifier" | "enum_specifier" | "class_specifier" => {
            if let Some(name) = node.child_by_field_name("name") {
                out.words.push(compact(source(name, text)));
            }
        }
        "sized_type_specifier" => {
            out.words.extend(source(node, text).split_whitespace().map(str::to_owned));
        }
        _ if node.is_error() => {}
        _ => out.words.push(compact(source(node, text))),
    }
}

/// Declarator layers, innermost node (nearest to the base type) first.
fn collect_layers(node: Node<'_>, text: &str, out: &mut Vec<Layer>) {
    let mut node = node;
    // Deep nesting does not occur in valid code, and each level costs time.
    for _ in 0..64 {
        match node.kind() {
            "pointer_declarator" | "abstract_pointer_declarator" => {
                let mut cursor = node.walk();
                let constant = node.children(&mut cursor).any(|child| {
                    child.kind() == "type_qualifier" && source(child, text) == "const"
                });
                out.push(Layer::Pointer { constant });
            }
            "reference_declarator" | "abstract_reference_declarator" => {
                let rvalue = node.child(0).is_some_and(|child| child.kind() == "&&");
                out.push(Layer::Reference { rvalue });
            }
            "array_declarator" | "abstract_array_declarator" => {
                let length = node.child_by_field_name("size");
                let length = length.map(|length| compact(source(length, text)).into());
                out.push(Layer::Array { length });
            }
            "function_declarator" | "abstract_function_declarator" => {
                let parameters = node.child_by_field_name("parameters");
                let parameters = parameters.map_or("", |parameter| source(parameter, text));
                out.push(Layer::Function { parameters: compact(parameters).into() });
            }
            "parenthesized_declarator"
            | "abstract_parenthesized_declarator"
            | "attributed_declarator" => {}
            _ => return,
        }
        let Some(inner) = inner_declarator(node) else {
            return;
        };
        node = inner;
    }
}

/// The declarator inside a declarator.
pub(super) fn inner_declarator(node: Node<'_>) -> Option<Node<'_>> {
    if let Some(inner) = node.child_by_field_name("declarator") {
        return Some(inner);
    }
    // References, parentheses and attributes have their declarator without a field name.
    let mut cursor = node.walk();
    node.named_children(&mut cursor).find(|child| {
        child.kind().ends_with("declarator")
            || matches!(child.kind(), "identifier" | "field_identifier" | "qualified_identifier")
    })
}

/// The name a declarator declares, if any.
pub(crate) fn declared_name(declarator: Node<'_>) -> Option<Node<'_>> {
    let mut node = declarator;
    for _ in 0..64 {
        match node.kind() {
            "identifier"
            | "field_identifier"
            | "qualified_identifier"
            | "type_identifier"
            | "destructor_name"
            | "operator_name"
            | "template_function" => return Some(node),
            _ => node = inner_declarator(node)?,
        }
    }
    None
}

pub(super) fn source<'t>(node: Node<'_>, text: &'t str) -> &'t str {
    text.get(node.byte_range()).unwrap_or_default()
}

/// A spelling without redundant blanks, and without comments.
pub(crate) fn compact(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        if let Some(comment) = rest.strip_prefix("/*") {
            rest = comment.split_once("*/").map_or("", |(_, rest)| rest);
            continue;
        }
        if let Some(comment) = rest.strip_prefix("//") {
            rest = comment.split_once('\n').map_or("", |(_, rest)| rest);
            continue;
        }
        rest = &rest[c.len_utf8()..];
        if !c.is_whitespace() {
            out.push(c);
            continue;
        }
        let word = |c: char| c.is_alphanumeric() || c == '_';
        let after = rest.trim_start().chars().next();
        if out.chars().next_back().is_some_and(word) && after.is_some_and(word) {
            out.push(' ');
        }
    }
    out
}

/// The common spelling of types that have several.
fn base_name(words: &[String]) -> SmolStr {
    let (mut long, mut short, mut unsigned, mut signed) = (0, 0, false, false);
    let mut rest: Vec<&str> = Vec::new();
    for word in words {
        match word.as_str() {
            "long" => long += 1,
            "short" => short += 1,
            "unsigned" => unsigned = true,
            "signed" | "__signed__" => signed = true,
            word => rest.push(word),
        }
    }
    let name = rest.join(" ");
    let name = name.strip_prefix("::").unwrap_or(&name);
    let name =
        name.strip_prefix("std::").filter(|rest| fixed_width(rest).is_some()).unwrap_or(name);
    let arithmetic = matches!(name, "" | "int" | "char");
    let number = match (name, long, short) {
        ("char", 0, 0) if unsigned => "uint8_t",
        ("char", 0, 0) if signed => "int8_t",
        ("" | "int", 0, 0) if unsigned => "uint32_t",
        ("" | "int", 0, 0) if signed || name == "int" => "int32_t",
        ("" | "int", 0, 1) => {
            if unsigned {
                "uint16_t"
            } else {
                "int16_t"
            }
        }
        ("" | "int", 1, 0) => {
            if unsigned {
                "unsigned long"
            } else {
                "long"
            }
        }
        ("" | "int", 2, 0) => {
            if unsigned {
                "unsigned long long"
            } else {
                "long long"
            }
        }
        ("double", 1, 0) => "long double",
        ("_Bool", 0, 0) => "bool",
        _ if arithmetic && name.is_empty() => "",
        _ => name,
    };
    number.into()
}

fn fixed_width(name: &str) -> Option<()> {
    let digits = name.strip_prefix('u').unwrap_or(name);
    let digits = digits.strip_prefix("int")?.strip_suffix("_t")?;
    matches!(digits, "8" | "16" | "32" | "64").then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_and_comments_do_not_count() {
        assert_eq!(compact("std::vector< T >"), "std::vector<T>");
        assert_eq!(compact("unsigned /* a */ int"), "unsigned int");
        assert_eq!(compact("a // b\n  c"), "a c");
    }

    #[test]
    fn numbers_have_one_spelling() {
        let name = |text: &str| base_name(&text.split(' ').map(String::from).collect::<Vec<_>>());
        for (text, wanted) in [
            ("unsigned", "uint32_t"),
            ("int unsigned", "uint32_t"),
            ("int", "int32_t"),
            ("long int", "long"),
            ("long long unsigned", "unsigned long long"),
            ("short", "int16_t"),
            ("char", "char"),
            ("unsigned char", "uint8_t"),
            ("std::int32_t", "int32_t"),
            ("_Bool", "bool"),
            ("std::string", "std::string"),
        ] {
            assert_eq!(name(text), wanted, "{text}");
        }
    }
}
