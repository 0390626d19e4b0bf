//! The names of the mapping before and after a change of the specification.
//!
//! There is no list of derived names. The whole mapping and all prototypes are generated before and after,
//! and compared token by token. They must differ only in names; otherwise the change is more than a rename.

use rustc_hash::FxHashMap;
use smol_str::SmolStr;

use crate::codels::{
    expected::{Expected, owner_words},
    mapping,
    source::{Grammar, Span, parse, place::is_function_name, types},
    stub::types_header,
};
use crate::lang::LangError;

/// A name with its enclosing scopes, outermost first; in C there are none.
pub(super) type ScopedName = (Vec<SmolStr>, SmolStr);

/// New names, by old ones.
#[derive(Debug, Default)]
pub(super) struct NewNames {
    /// Types, events, exceptions, enumerators, constants, functions, macros.
    pub(super) globals: FxHashMap<ScopedName, SmolStr>,
    /// Codels whose names are those of events too, which is possible in C, with their new names.
    /// [`NewNames::globals`] has the events.
    pub(super) clashing: FxHashMap<SmolStr, Option<SmolStr>>,
    /// Members, by structure and name.
    pub(super) members: FxHashMap<(SmolStr, SmolStr), SmolStr>,
    /// Parameters of codels: function (by its old name), position, old and new name.
    pub(super) parameters: Vec<(SmolStr, usize, SmolStr, SmolStr)>,
    /// Tasks and services, by their names in comments of the skeleton.
    pub(super) owners: FxHashMap<SmolStr, SmolStr>,
    /// Generated headers, without extension.
    pub(super) files: FxHashMap<SmolStr, SmolStr>,
    /// The mapping before the change, for the types of expressions.
    pub(super) before: String,
    /// The grammar of the mapping.
    pub(super) grammar: Option<Grammar>,
}

/// A reason why new names cannot be determined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MissingNames {
    /// A type has no mapping.
    Mapping(String),
    /// The two mappings differ in more than names.
    Structure,
}

impl std::fmt::Display for MissingNames {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MissingNames::Mapping(why) => write!(f, "the types cannot be mapped: {why}"),
            MissingNames::Structure => {
                f.write_str("more than names would change in the generated code")
            }
        }
    }
}

/// The mapped types and the prototypes.
fn mapping(expected: &Expected<'_>) -> Result<String, LangError> {
    let mut out = mapping::types(expected)?;
    out.push('\n');
    for function in &expected.functions {
        if let Ok(signature) = &function.signature {
            out += &format!("{signature};\n");
        }
    }
    Ok(out)
}

impl NewNames {
    /// The names of a component before and after.
    pub(super) fn new(
        before: &Expected<'_>,
        after: &Expected<'_>,
    ) -> Result<NewNames, MissingNames> {
        let text =
            |expected| mapping(expected).map_err(|error| MissingNames::Mapping(error.message));
        let (old, new) = (text(before)?, text(after)?);
        let grammar = mapping::grammar(before);
        let functions = before.functions.iter().map(|function| SmolStr::from(&*function.name));
        let clashing = functions.filter(|name| before.events.contains_key(name));
        let clashing = clashing.map(|name| (name, None)).collect();
        let mut out = NewNames { grammar: Some(grammar), clashing, ..NewNames::default() };
        let (words, new_words) = (words(&old), words(&new));
        if words.len() != new_words.len() {
            return Err(MissingNames::Structure);
        }
        let tree = parse(&old, grammar).ok_or(MissingNames::Structure)?;
        for (span, new_span) in words.into_iter().zip(new_words) {
            let (from, to) = (&old[span.clone()], &new[new_span]);
            if from != to {
                let node = tree.root_node().descendant_for_byte_range(span.start, span.end);
                let node = node.ok_or(MissingNames::Structure)?;
                match out.clashing.get_mut(from) {
                    Some(function) if is_function_name(node) => *function = Some(to.into()),
                    _ => out.add(node, from, to, &old, grammar),
                }
            }
        }
        out.owners(before, after)?;
        out.before = old;
        Ok(out)
    }

    fn add(
        &mut self,
        node: tree_sitter::Node<'_>,
        from: &str,
        to: &str,
        text: &str,
        grammar: Grammar,
    ) {
        let (from, to) = (SmolStr::from(from), SmolStr::from(to));
        let mut kinds = Vec::new();
        let mut at = node.parent();
        while let Some(node) = at {
            kinds.push(node);
            at = node.parent();
        }
        let within = |kind: &str| kinds.iter().find(|node| node.kind() == kind);
        if let Some(declaration) = within("parameter_declaration")
            && node.kind() == "identifier"
        {
            self.parameter(*declaration, from, to, text);
            return;
        }
        if node.kind() == "field_identifier" {
            if let Some(owner) = types::owner_of(node, text) {
                self.members.insert((owner, from), to);
            }
            return;
        }
        // A use has its scopes as a prefix; a declaration is inside of them.
        let qualified = node.parent().is_some_and(|parent| parent.kind() == "qualified_identifier");
        if grammar == Grammar::Cxx && qualified {
            return;
        }
        let scopes = match grammar {
            Grammar::C => Vec::new(),
            Grammar::Cxx => {
                let mut scopes = types::scopes(node, text);
                // The name of a structure or namespace is not in its own scope.
                if node
                    .parent()
                    .and_then(|parent| parent.child_by_field_name("name"))
                    .is_some_and(|child| child.id() == node.id())
                    && scopes.last() == Some(&from)
                {
                    scopes.pop();
                }
                scopes
            }
        };
        self.globals.insert((scopes, from), to);
    }

    fn parameter(
        &mut self,
        declaration: tree_sitter::Node<'_>,
        from: SmolStr,
        to: SmolStr,
        text: &str,
    ) {
        let Some(list) = declaration.parent() else {
            return;
        };
        let mut cursor = list.walk();
        let mut all = list
            .named_children(&mut cursor)
            .filter(|child| child.kind() == "parameter_declaration");
        let position = all.position(|child| child.id() == declaration.id());
        let function = list.parent().and_then(|parent| parent.child_by_field_name("declarator"));
        if let (Some(position), Some(function)) = (position, function) {
            let function = text.get(function.byte_range()).unwrap_or_default();
            let entry = (function.into(), position, from, to);
            if !self.parameters.contains(&entry) {
                self.parameters.push(entry);
            }
        }
    }

    fn owners(&mut self, before: &Expected<'_>, after: &Expected<'_>) -> Result<(), MissingNames> {
        let (old, new) = (before.component(), after.component());
        if old.tasks.len() != new.tasks.len() || old.services.len() != new.services.len() {
            return Err(MissingNames::Structure);
        }
        use dotgen_analysis::model::Owner;
        let tasks = old.tasks.keys().map(Owner::Task);
        let services = old.services.keys().map(Owner::Service);
        for owner in tasks.chain(services) {
            let (from, to) = (owner_words(old, owner).1, owner_words(new, owner).1);
            if from != to {
                self.owners.insert(from.as_str().into(), to.as_str().into());
            }
        }
        let stem = |text: String| SmolStr::from(text.trim_end_matches(".h"));
        let configuration = |text: &str| SmolStr::from(format!("ac{text}"));
        if old.name != new.name {
            self.files.insert(stem(types_header(before)), stem(types_header(after)));
            self.files.insert(configuration(&old.name), configuration(&new.name));
        }
        Ok(())
    }

    /// True if no name in the sources changes.
    pub(super) fn is_empty(&self) -> bool {
        self.globals.is_empty()
            && self.clashing.values().all(Option::is_none)
            && self.members.is_empty()
            && self.parameters.is_empty()
            && self.owners.is_empty()
            && self.files.is_empty()
    }
}

/// The identifiers of a text, except those in comments and literals.
pub(super) fn words(text: &str) -> Vec<Span> {
    let bytes = text.as_bytes();
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = &bytes[at..];
        let find = |what: &[u8]| rest.windows(what.len()).position(|window| window == what);
        at += match byte {
            b'/' if rest.starts_with(b"/*") => find(b"*/").map_or(rest.len(), |end| end + 2),
            b'/' if rest.starts_with(b"//") => find(b"\n").unwrap_or(rest.len()),
            b'"' | b'\'' => {
                let mut end = 1;
                while end < rest.len() && rest[end] != byte && rest[end] != b'\n' {
                    end += 1 + usize::from(rest[end] == b'\\');
                }
                (end + 1).min(rest.len())
            }
            _ if byte.is_ascii_alphanumeric() || byte == b'_' || !byte.is_ascii() => {
                let part =
                    |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_' || !byte.is_ascii();
                let length = rest.iter().take_while(|byte| part(byte)).count();
                if !byte.is_ascii_digit() {
                    out.push(at..at + length);
                }
                length
            }
            _ => 1,
        };
    }
    out
}
