//! Types of expressions, as far as needed to find the structure of the member in `x.y`.
//!
//! [`Types`] collects the declarations of texts outside functions: structures with their members, aliases,
//! functions and variables. [`Scope`] adds the variables of one function. An unknown type is `None`, never a
//! guess.

use rustc_hash::FxHashMap;
use smol_str::SmolStr;
use tree_sitter::Node;

use super::{
    CType, Grammar, Layer, SourceIndex,
    ctype::{compact, declared_name, of_declaration, source},
    parse, preorder,
};

/// Maximum depth of expressions and types that are followed.
const DEPTH: usize = 64;

/// The declarations of some texts.
#[derive(Debug, Default)]
pub(crate) struct Types {
    /// Members by the name of the structure, scopes included. A structure without a name has the name of the
    /// member that contains it.
    members: FxHashMap<SmolStr, FxHashMap<SmolStr, CType>>,
    aliases: FxHashMap<SmolStr, CType>,
    /// The return types of functions, and the types of variables; `None` if two declarations differ.
    values: FxHashMap<SmolStr, Option<CType>>,
}

impl Types {
    /// Adds the declarations of a text.
    pub(crate) fn read(&mut self, text: &str, grammar: Grammar) {
        let Some(tree) = parse(text, grammar) else {
            return;
        };
        preorder(tree.root_node(), |node| {
            match node.kind() {
                "compound_statement" => return false,
                "struct_specifier" | "union_specifier" | "class_specifier" => {
                    let name = node.child_by_field_name("name");
                    if let Some(name) = name {
                        let owner = scoped(node, source(name, text), text);
                        self.structure(node, &owner, text);
                    }
                }
                "type_definition" | "alias_declaration" => self.alias(node, text),
                "declaration" | "function_definition" if !inside_structure(node) => {
                    declared(node, text, |name, ty| self.value(name, ty));
                }
                _ => {}
            }
            true
        });
    }

    fn value(&mut self, name: SmolStr, ty: CType) {
        self.values
            .entry(name)
            .and_modify(|known| {
                if known.as_ref() != Some(&ty) {
                    *known = None;
                }
            })
            .or_insert(Some(ty));
    }

    fn alias(&mut self, node: Node<'_>, text: &str) {
        let Some(ty) = node.child_by_field_name("type") else {
            return;
        };
        if let Some(name) = node.child_by_field_name("name") {
            // `using a = b;`
            let declarator = ty.child_by_field_name("declarator");
            let of = of_declaration(ty, declarator, text);
            self.aliases.insert(scoped(node, source(name, text), text), of);
            return;
        }
        let mut cursor = node.walk();
        for declarator in node.children_by_field_name("declarator", &mut cursor) {
            let Some(name) = declared_name(declarator) else {
                continue;
            };
            let name = scoped(node, source(name, text), text);
            let mut of = typed(node, declarator, text);
            let nameless = is_structure(ty) && ty.child_by_field_name("name").is_none();
            if nameless {
                // `typedef struct { … } name;`
                of.base = name.clone();
                self.structure(ty, &name, text);
            }
            if of.base != name || !of.layers.is_empty() {
                self.aliases.insert(name, of);
            }
        }
    }

    fn structure(&mut self, node: Node<'_>, owner: &SmolStr, text: &str) {
        let mut work = vec![(node, owner.clone())];
        while let Some((node, owner)) = work.pop() {
            let Some(body) = node.child_by_field_name("body") else {
                continue;
            };
            self.members.entry(owner.clone()).or_default();
            let mut fields = Vec::new();
            preorder(body, |node| match node.kind() {
                "field_declaration" => {
                    fields.push(node);
                    false
                }
                "function_definition" => false,
                _ => true,
            });
            for field in fields {
                let ty = field.child_by_field_name("type");
                let nameless =
                    ty.filter(|ty| is_structure(*ty) && ty.child_by_field_name("name").is_none());
                let mut cursor = field.walk();
                let mut any = false;
                for declarator in field.children_by_field_name("declarator", &mut cursor) {
                    any = true;
                    let Some(name) = declared_name(declarator) else {
                        continue;
                    };
                    let name: SmolStr = source(name, text).into();
                    let mut of = typed(field, declarator, text);
                    if let Some(nameless) = nameless {
                        of.base = format!("{owner}.{name}").into();
                        work.push((nameless, of.base.clone()));
                    }
                    let members = self.members.entry(owner.clone()).or_default();
                    members.insert(name, of);
                }
                // Members of an anonymous structure belong to the enclosing structure.
                if let Some(nameless) = nameless.filter(|_| !any) {
                    work.push((nameless, owner.clone()));
                }
            }
        }
    }

    /// The structure with that full name; after `using namespace` a name may lack its scopes.
    fn find(&self, name: &str) -> Option<(&SmolStr, &FxHashMap<SmolStr, CType>)> {
        if let Some(found) = self.members.get_key_value(name) {
            return Some(found);
        }
        let mut all = self.members.iter().filter(|member| ends_with(member.0, name));
        let found = all.next()?;
        all.next().is_none().then_some(found)
    }

    fn alias_of(&self, name: &str) -> Option<&CType> {
        if let Some(found) = self.aliases.get(name) {
            return Some(found);
        }
        let mut all = self.aliases.iter().filter(|alias| ends_with(alias.0, name));
        let found = all.next()?.1;
        all.next().is_none().then_some(found)
    }

    /// The type with aliases replaced by their definitions.
    fn canonical(&self, ty: &CType) -> CType {
        let mut ty = ty.clone();
        for _ in 0..DEPTH {
            match self.alias_of(&ty.base) {
                Some(alias) if alias.base != ty.base || !alias.layers.is_empty() => {
                    ty = ty.expand(alias);
                }
                _ => break,
            }
        }
        ty
    }

    /// The structure whose members `.` and `->` access in a value of a type.
    pub(crate) fn structure_of(&self, ty: &CType) -> Option<SmolStr> {
        let ty = self.canonical(ty);
        let plain =
            |layer: &Layer| matches!(layer, Layer::Pointer { .. } | Layer::Reference { .. });
        if !ty.layers.iter().all(plain) {
            return None;
        }
        Some(match self.find(&ty.base) {
            Some((name, _)) => name.clone(),
            None => ty.base,
        })
    }

    fn member(&self, structure: &str, name: &str) -> Option<&CType> {
        self.find(structure)?.1.get(name)
    }

    /// The type of `[]` and `*` applied to a value.
    pub(crate) fn element(&self, ty: &CType) -> Option<CType> {
        let mut ty = self.canonical(ty);
        if matches!(ty.layers.first(), Some(Layer::Reference { .. })) {
            ty.layers.remove(0);
        }
        match ty.layers.first() {
            Some(Layer::Pointer { .. } | Layer::Array { .. }) => {
                ty.layers.remove(0);
                Some(ty)
            }
            Some(_) => None,
            None => argument_of(&ty.base),
        }
    }
}

/// The first argument of a template: the element type of the mapping's containers.
fn argument_of(base: &str) -> Option<CType> {
    let (_, rest) = base.split_once('<')?;
    let rest = rest.strip_suffix('>')?;
    let mut depth = 0i32;
    let end = rest.find(|c| {
        match c {
            '<' | '(' => depth += 1,
            '>' | ')' => depth -= 1,
            _ => {}
        }
        c == ',' && depth == 0
    });
    let first = &rest[..end.unwrap_or(rest.len())];
    let index = SourceIndex::new(&format!("void f({first} x);\n"), Grammar::Cxx);
    let parameter = index.functions.into_iter().next()?.parameters.into_iter().next()?;
    Some(parameter.ty)
}

/// `a::b` ends with `b`.
fn ends_with(long: &str, short: &str) -> bool {
    let rest = long.strip_suffix(short);
    !short.is_empty() && rest.is_some_and(|stem| stem.ends_with("::"))
}

fn is_structure(node: Node<'_>) -> bool {
    matches!(node.kind(), "struct_specifier" | "union_specifier" | "class_specifier")
}

fn inside_structure(node: Node<'_>) -> bool {
    node.parent().is_some_and(|parent| parent.kind() == "field_declaration_list")
}

/// The namespaces and structures around a node, outermost first.
pub(crate) fn scopes(node: Node<'_>, text: &str) -> Vec<SmolStr> {
    let mut out = Vec::new();
    let mut at = node.parent();
    while let Some(node) = at {
        let opens = node.kind() == "namespace_definition" || is_structure(node);
        if let Some(name) = node.child_by_field_name("name").filter(|_| opens) {
            let parts = source(name, text).rsplit("::");
            out.extend(parts.map(|part| SmolStr::from(part.trim())));
        }
        at = node.parent();
    }
    out.reverse();
    out
}

fn scoped(node: Node<'_>, name: &str, text: &str) -> SmolStr {
    let mut path = scopes(node, text);
    path.push(name.into());
    path.join("::").into()
}

/// The names and types in a declaration or in the head of a function. A function has the type of its result.
fn declared(node: Node<'_>, text: &str, mut found: impl FnMut(SmolStr, CType)) {
    let mut cursor = node.walk();
    for declarator in node.children_by_field_name("declarator", &mut cursor) {
        let inner = match declarator.kind() {
            "init_declarator" => declarator.child_by_field_name("declarator"),
            _ => Some(declarator),
        };
        let Some(name) = inner.and_then(declared_name) else {
            continue;
        };
        let mut ty = typed(node, declarator, text);
        if matches!(ty.layers.first(), Some(Layer::Function { .. })) {
            ty.layers.remove(0);
        }
        found(source(name, text).into(), ty);
    }
}

/// The variables of one function.
#[derive(Debug)]
pub(crate) struct Scope<'a> {
    types: &'a Types,
    text: &'a str,
    /// `None` if several variables of one name have different types, or if the type is unknown.
    variables: FxHashMap<SmolStr, Option<CType>>,
}

impl<'a> Scope<'a> {
    /// The variables of a function; without a function, those of the file.
    pub(crate) fn new(function: Option<Node<'a>>, text: &'a str, types: &'a Types) -> Scope<'a> {
        let mut scope = Scope { types, text, variables: FxHashMap::default() };
        if let Some(function) = function {
            preorder(function, |node| {
                scope.declare(node);
                true
            });
        }
        scope
    }

    /// True if the function has a variable of that name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.variables.contains_key(name)
    }

    fn declare(&mut self, node: Node<'a>) {
        let mut found: Vec<(SmolStr, Option<CType>)> = Vec::new();
        match node.kind() {
            "parameter_declaration" | "optional_parameter_declaration" => {
                declared(node, self.text, |name, ty| found.push((name, Some(ty))));
            }
            "declaration" => {
                let mut cursor = node.walk();
                let values: Vec<Option<Node<'_>>> = node
                    .children_by_field_name("declarator", &mut cursor)
                    .map(|child| child.child_by_field_name("value"))
                    .collect();
                let mut values = values.into_iter();
                let mut all = Vec::new();
                declared(node, self.text, |name, ty| all.push((name, ty)));
                for (name, ty) in all {
                    let value = values.next().flatten();
                    let ty = match ty.base.as_str() {
                        "auto" => value.and_then(|child| self.ty(child, 0)),
                        _ => Some(ty),
                    };
                    found.push((name, ty));
                }
            }
            "for_range_loop" => {
                let right = node.child_by_field_name("right");
                let declarator = node.child_by_field_name("declarator");
                if let Some(name) = declarator.and_then(declared_name) {
                    let ty = node.child_by_field_name("type");
                    let ty = ty.map_or("", |ty| source(ty, self.text));
                    let ty = match ty {
                        "auto" => right
                            .and_then(|child| self.ty(child, 0))
                            .and_then(|ty| self.types.element(&ty)),
                        ty => Some(CType::plain(&compact(ty))),
                    };
                    found.push((source(name, self.text).into(), ty));
                }
            }
            _ => {}
        }
        for (name, ty) in found {
            self.variables
                .entry(name)
                .and_modify(|known| {
                    if *known != ty {
                        *known = None;
                    }
                })
                .or_insert(ty);
        }
    }

    /// The type of an expression, if it is known.
    pub(crate) fn type_of(&self, node: Node<'_>) -> Option<CType> {
        self.ty(node, 0)
    }

    fn ty(&self, node: Node<'_>, depth: usize) -> Option<CType> {
        if depth > DEPTH {
            return None;
        }
        let inner = |field: &str| self.ty(node.child_by_field_name(field)?, depth + 1);
        match node.kind() {
            "identifier" | "qualified_identifier" => {
                let name = source(node, self.text);
                match self.variables.get(name) {
                    Some(known) => known.clone(),
                    None => self.types.values.get(name).cloned().flatten(),
                }
            }
            "parenthesized_expression" => self.ty(node.named_child(0)?, depth + 1),
            "pointer_expression" => {
                let ty = inner("argument")?;
                if node.child(0)?.kind() == "*" {
                    self.types.element(&ty)
                } else {
                    let mut ty = ty;
                    ty.layers.insert(0, Layer::Pointer { constant: false });
                    Some(ty)
                }
            }
            "subscript_expression" => self.types.element(&inner("argument")?),
            "field_expression" => {
                let structure = self.types.structure_of(&inner("argument")?)?;
                let field = node.child_by_field_name("field")?;
                let member = self.types.member(&structure, source(field, self.text));
                member.cloned()
            }
            "call_expression" => {
                let function = node.child_by_field_name("function")?;
                if function.kind() != "field_expression" {
                    return self.ty(function, depth + 1);
                }
                if let Some(mut ty) = self.ty(function, depth + 1) {
                    // A pointer to a function, or a method.
                    if matches!(ty.layers.first(), Some(Layer::Pointer { .. })) {
                        ty.layers.remove(0);
                    }
                    if !matches!(ty.layers.first(), Some(Layer::Function { .. })) {
                        return None;
                    }
                    ty.layers.remove(0);
                    return Some(ty);
                }
                let field = function.child_by_field_name("field")?;
                let of = self.ty(function.child_by_field_name("argument")?, depth + 1)?;
                let of = self.types.canonical(&of);
                matches!(source(field, self.text), "at" | "front" | "back" | "value" | "get")
                    .then(|| argument_of(&of.base))?
            }
            "cast_expression" | "compound_literal_expression" => {
                let ty = node.child_by_field_name("type")?;
                Some(of_descriptor(ty, self.text))
            }
            "assignment_expression" | "binary_expression" => inner("left"),
            "update_expression" => inner("argument"),
            "comma_expression" => inner("right"),
            "conditional_expression" => inner("alternative"),
            _ => None,
        }
    }

    /// The structure that a designator `.x` in an initializer belongs to.
    pub(crate) fn designated(&self, designator: Node<'_>) -> Option<SmolStr> {
        let whole = self.initialized(designator, 0)?;
        let pair = designator.parent()?;
        let mut cursor = pair.walk();
        let steps = pair.children_by_field_name("designator", &mut cursor);
        let before = steps.take_while(|step| *step != designator);
        self.types.structure_of(&self.within(whole, before)?)
    }

    /// The type of the part of a value that some designators, one after the other, select.
    fn within<'t>(&self, of: CType, steps: impl Iterator<Item = Node<'t>>) -> Option<CType> {
        let mut ty = of;
        for step in steps {
            ty = match step.kind() {
                "field_designator" => {
                    let name = source(step.named_child(0)?, self.text);
                    let structure = self.types.structure_of(&ty)?;
                    self.types.member(&structure, name)?.clone()
                }
                _ => self.types.element(&ty)?,
            };
        }
        Some(ty)
    }

    /// The type that the initializer list around a node initializes.
    fn initialized(&self, node: Node<'_>, depth: usize) -> Option<CType> {
        if depth > DEPTH {
            return None;
        }
        let mut at = node.parent()?;
        while at.kind() != "initializer_list" {
            at = at.parent()?;
        }
        let outer = at.parent()?;
        match outer.kind() {
            "init_declarator" => Some(typed(outer.parent()?, outer, self.text)),
            "compound_literal_expression" => {
                Some(of_descriptor(outer.child_by_field_name("type")?, self.text))
            }
            "initializer_pair" => {
                let whole = self.initialized(outer, depth + 1)?;
                let mut cursor = outer.walk();
                self.within(whole, outer.children_by_field_name("designator", &mut cursor))
            }
            "initializer_list" => self.types.element(&self.initialized(at, depth + 1)?),
            _ => None,
        }
    }
}

/// The type that a declaration gives to one of its declarators, which may have an initial value.
fn typed(declaration: Node<'_>, declarator: Node<'_>, text: &str) -> CType {
    // Words after the first declarator are not part of the type.
    let first = declaration.child_by_field_name("declarator");
    let base = of_declaration(declaration, first, text);
    let inner = match declarator.kind() {
        "init_declarator" => declarator.child_by_field_name("declarator"),
        _ => Some(declarator),
    };
    let layers = inner.map(|child| of_declaration(declaration, Some(child), text).layers);
    CType {
        base: base.base.trim_start_matches("typedef ").into(),
        layers: layers.unwrap_or_default(),
        ..base
    }
}

fn of_descriptor(ty: Node<'_>, text: &str) -> CType {
    of_declaration(ty, ty.child_by_field_name("declarator"), text)
}

/// The structure that declares a member, with its name in [`Types`].
pub(crate) fn owner_of(member: Node<'_>, text: &str) -> Option<SmolStr> {
    let mut steps: Vec<SmolStr> = Vec::new();
    let mut at = member.parent();
    while let Some(node) = at {
        if is_structure(node) {
            let around = node.parent()?;
            let name = match node.child_by_field_name("name") {
                Some(name) => Some(scoped(node, source(name, text), text)),
                None if around.kind() == "type_definition" => around
                    .child_by_field_name("declarator")
                    .and_then(declared_name)
                    .map(|name| scoped(node, source(name, text), text)),
                None => None,
            };
            if let Some(name) = name {
                let mut path = vec![name];
                path.extend(steps.into_iter().rev());
                return Some(path.join(".").into());
            }
            // Named after the member that contains it, if there is one.
            let declarator = around.child_by_field_name("declarator");
            if let Some(name) = declarator.and_then(declared_name) {
                steps.push(source(name, text).into());
            }
        }
        at = node.parent();
    }
    None
}
