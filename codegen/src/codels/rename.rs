//! Renames in the C and C++ sources and the build files, after a rename in the specification.
//!
//! The renamed names are found by a comparison of the whole mapping before and after (`names`), so that every
//! name derived by the mapping is covered: events, exceptions with their details, types, enumerators,
//! prototypes, ports. Names of the mapping are renamed token by token in the parsed sources. A member is
//! renamed only if the type of its value is known (`super::source::types`). Ambiguous names are unchanged,
//! and listed.

mod build;
mod names;

use std::fmt;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::UnitResult;
use smol_str::SmolStr;
use tree_sitter::Node;

use self::names::{NewNames, words};
use super::{
    edit::Edit,
    expected::Expected,
    files::{Files, IndexedFile},
    folder::Folder,
    source::{
        Generated, Span, comment, parse,
        place::{
            is_function_name, names_parameter, names_structure, opened, qualifiers, renamable,
        },
        preorder,
        types::{Scope, Types, scopes},
    },
};

pub use names::MissingNames;

/// Edits of sources and build files for a rename.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Renaming {
    /// The certain edits.
    pub edit: Edit,
    /// The ambiguous places, which are unchanged, by file and line.
    pub left: Vec<UnchangedPlace>,
}

/// A place that may have to be changed by hand.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct UnchangedPlace {
    /// The file.
    pub path: Utf8PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// The old name at this place.
    pub name: SmolStr,
    pub why: UnchangedReason,
}

/// A reason why a mention is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnchangedReason {
    /// A member of a value whose type is unknown.
    Receiver,
    /// The sources have another declaration of that name.
    Homonym,
    /// In the text of a macro, where types are unknown and names may be built of parts.
    Macro,
    /// In a string or character.
    String,
    /// In a rule of `dotgen.toml` that takes members by name.
    Rule,
    /// In a comment that is not the one of the skeleton.
    Comment,
    /// In a file of the build, as a part of another name.
    Build,
}

impl fmt::Display for UnchangedPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let why = match self.why {
            UnchangedReason::Receiver => "a member of something whose type is not known",
            UnchangedReason::Homonym => "may be the one that the sources declare",
            UnchangedReason::Macro => "in a macro",
            UnchangedReason::String => "in a string",
            UnchangedReason::Rule => "takes a member of the old name for a field of a message",
            UnchangedReason::Comment => "in a comment",
            UnchangedReason::Build => "in a file of the build",
        };
        write!(f, "{}:{}: `{}` {why}", self.path, self.line, self.name)
    }
}

/// A reason why the sources cannot be renamed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RenameRefusal {
    /// The new names cannot be determined.
    Names(MissingNames),
    /// The sources already declare a new name.
    Taken {
        name: SmolStr,
        /// The file that declares it.
        path: Utf8PathBuf,
    },
}

impl fmt::Display for RenameRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RenameRefusal::Names(why) => write!(f, "The codels cannot follow: {why}"),
            RenameRefusal::Taken { name, path } => write!(
                f,
                "`{name}` exists already, in {path}; choose another name, or rename that one first"
            ),
        }
    }
}

impl std::error::Error for RenameRefusal {}

/// The edits of the sources of a folder, whose unit is going to be `after`. Empty if no name in the sources
/// changes.
///
/// # Errors
/// The sources cannot be renamed. The rename should then not be made at all.
pub fn rename(
    folder: &Folder,
    after: &UnitResult,
    texts: &dyn Files,
) -> Result<Renaming, RenameRefusal> {
    let mut out = Renaming::default();
    if !folder.sources.exists {
        return Ok(out);
    }
    for before in folder.expected() {
        if after.spec.components.len() != folder.unit.spec.components.len() {
            return Err(RenameRefusal::Names(MissingNames::Structure));
        }
        let new = Expected::in_language(&after.spec, before.component, before.language);
        let names = NewNames::new(&before, &new).map_err(RenameRefusal::Names)?;
        if names.is_empty() {
            continue;
        }
        check_free(folder, &names)?;
        let mut types = Types::default();
        if let Some(grammar) = names.grammar {
            types.read(&names.before, grammar);
        }
        for file in folder.sources.all() {
            types.read(&file.text, file.grammar);
        }
        for file in folder.sources.all() {
            File { file, names: &names, types: &types, out: &mut out }.rename();
        }
        build::rename(folder, &before, &names, texts, &mut out);
    }
    out.left.sort();
    out.left.dedup();
    Ok(out)
}

/// Checks that no source declares one of the new names.
fn check_free(folder: &Folder, names: &NewNames) -> Result<(), RenameRefusal> {
    let functions = names.clashing.values().flatten().map(|to| (true, to));
    let globals = names.globals.iter().map(|((scopes, _), to)| (scopes.is_empty(), to));
    for (is_global, to) in globals.chain(functions) {
        let free = |file: &&IndexedFile| {
            !file.index().names.contains(to)
                && !file.index().macros.iter().any(|definition| definition.name == *to)
        };
        let given_up = names.globals.contains_key(&(Vec::new(), to.clone()));
        if is_global
            && !given_up
            && let Some(file) = folder.sources.all().find(|file| !free(file))
        {
            return Err(RenameRefusal::Taken { name: to.clone(), path: file.path.clone() });
        }
    }
    Ok(())
}

/// One source.
struct File<'a> {
    file: &'a IndexedFile,
    names: &'a NewNames,
    types: &'a Types,
    out: &'a mut Renaming,
}

impl<'a> File<'a> {
    fn rename(mut self) {
        let text: &'a str = &self.file.text;
        let Some(tree) = parse(text, self.file.grammar) else {
            return;
        };
        let open = opened(tree.root_node(), text);
        let outside = Scope::new(None, text, self.types);
        let mut functions = Vec::new();
        preorder(tree.root_node(), |node| {
            if node.kind() == "function_definition" {
                functions.push(node);
                return false;
            }
            self.node(node, &outside, &open)
        });
        for function in functions {
            let scope = Scope::new(Some(function), text, self.types);
            preorder(function, |node| self.node(node, &scope, &open));
            self.parameters(function);
        }
        let functions = self.file.index().functions.iter();
        for comment in functions.flat_map(|function| &function.comments) {
            if let Some(generated) = &comment.generated {
                self.generated(generated);
            }
        }
    }

    fn text(&self, span: &Span) -> &'a str {
        self.file.text.get(span.clone()).unwrap_or_default()
    }

    fn edit(&mut self, span: Span, to: &str) {
        self.out.edit.replace(&self.file.path, span, to);
    }

    fn leave(&mut self, at: usize, name: &str, why: UnchangedReason) {
        let before = self.file.text.get(..at).unwrap_or_default();
        self.out.left.push(UnchangedPlace {
            path: self.file.path.clone(),
            line: 1 + before.matches('\n').count(),
            name: name.into(),
            why,
        });
    }

    /// Renames in one node. Returns true if its children have to be visited.
    fn node(&mut self, node: Node<'_>, scope: &Scope<'_>, open: &[Vec<SmolStr>]) -> bool {
        let span = node.byte_range();
        match node.kind() {
            "preproc_include" => {
                self.include(node);
                return false;
            }
            "preproc_arg" => self.macro_text(&span),
            "string_literal" | "raw_string_literal" | "char_literal" => {
                self.prose(&span, UnchangedReason::String);
                return false;
            }
            "comment" => {
                let mut all =
                    self.file.index().functions.iter().flat_map(|function| &function.comments);
                let generated = |comment: &&super::source::Comment| comment.generated.is_some();
                let inside = |comment: &super::source::Comment| comment.span.contains(&span.start);
                if !all.by_ref().filter(generated).any(inside) {
                    // The comment of a codel stands alone if its function is in another file.
                    match comment::generated(&self.file.text, &span) {
                        Some(generated) => self.generated(&generated),
                        None => self.prose(&span, UnchangedReason::Comment),
                    }
                }
            }
            "identifier" | "type_identifier" | "namespace_identifier" => {
                if let Some(to) = self.global(node, scope) {
                    self.edit(span, &to);
                } else if let Some(to) = self.opened(node, scope, open) {
                    let name = self.text(&span);
                    let bare = qualifiers(node, &self.file.text).is_empty();
                    let homonym = bare && self.declares(name);
                    if homonym {
                        self.leave(span.start, name, UnchangedReason::Homonym);
                    } else {
                        self.edit(span, &to);
                    }
                }
            }
            "field_identifier" => self.member(node, scope),
            _ => {}
        }
        true
    }

    /// True if any source declares a name outside functions.
    fn declares(&self, name: &str) -> bool {
        self.file.index().names.contains(name)
    }

    /// True if an identifier may be a name of the mapping: it is neither a variable, nor the name of a
    /// declaration.
    fn may_be_mapped(&self, node: Node<'_>, scope: &Scope<'_>, path: &[SmolStr]) -> bool {
        let name = self.text(&node.byte_range());
        let variable = node.kind() == "identifier" && scope.has(name);
        !path.is_empty() || !variable && !names_parameter(node)
    }

    /// The new name of an identifier that is not a member, by its written and enclosing scopes.
    fn global(&self, node: Node<'_>, scope: &Scope<'_>) -> Option<SmolStr> {
        let name: SmolStr = self.text(&node.byte_range()).into();
        if let Some(to) = self.names.clashing.get(&name)
            && is_function_name(node)
        {
            return to.clone();
        }
        if !self.names.globals.keys().any(|key| key.1 == name) {
            return None;
        }
        let path = qualifiers(node, &self.file.text);
        if !self.may_be_mapped(node, scope, &path) {
            return None;
        }
        let get = |scopes: Vec<SmolStr>| self.names.globals.get(&(scopes, name.clone())).cloned();
        if let Some(to) = get(path.clone()) {
            return Some(to);
        }
        let mut around = scopes(node, &self.file.text);
        while !around.is_empty() {
            let full: Vec<SmolStr> = around.iter().chain(&path).cloned().collect();
            if let Some(to) = get(full) {
                return Some(to);
            }
            around.pop();
        }
        None
    }

    /// The new name of an identifier in a scope that the file opens by `using namespace`.
    fn opened(&self, node: Node<'_>, scope: &Scope<'_>, open: &[Vec<SmolStr>]) -> Option<SmolStr> {
        let path = qualifiers(node, &self.file.text);
        if open.is_empty() || !self.may_be_mapped(node, scope, &path) || names_structure(node) {
            return None;
        }
        let name: SmolStr = self.text(&node.byte_range()).into();
        open.iter().find_map(|smol_str| {
            let full: Vec<SmolStr> = smol_str.iter().chain(&path).cloned().collect();
            self.names.globals.get(&(full, name.clone())).cloned()
        })
    }

    fn member(&mut self, node: Node<'_>, scope: &Scope<'_>) {
        let span = node.byte_range();
        let name: SmolStr = self.text(&span).into();
        if !self.names.members.keys().any(|key| key.1 == name) {
            return;
        }
        let Some(parent) = node.parent() else { return };
        let structure = match parent.kind() {
            "field_expression" => {
                let of = parent.child_by_field_name("argument");
                let ty = of.and_then(|child| scope.type_of(child));
                ty.and_then(|ty| self.types.structure_of(&ty))
            }
            "field_designator" => scope.designated(parent),
            // A member of a structure that the sources declare.
            "field_declaration" => return,
            kind if kind.ends_with("declarator") => return,
            _ => None,
        };
        match structure {
            Some(structure) => {
                if let Some(to) = self.names.members.get(&(structure, name)).cloned() {
                    self.edit(span, &to);
                }
            }
            None => self.leave(span.start, &name, UnchangedReason::Receiver),
        }
    }

    /// Renames a parameter that has its name in the specification, unless the new name is in use.
    fn parameters(&mut self, function: Node<'_>) {
        let start = function.start_byte();
        let mut all = self.file.index().functions.iter();
        let Some(found) = all.find(|function| function.span.start == start && function.is_global())
        else {
            return;
        };
        let wanted = self.names.parameters.iter();
        let wanted: Vec<_> =
            wanted.filter(|parameter| parameter.0 == found.name).cloned().collect();
        for (_, position, from, to) in wanted {
            let named = found.parameters.get(position);
            if named.is_none_or(|parameter| parameter.name.as_ref() != Some(&from)) {
                continue;
            }
            let grammar = self.file.grammar;
            for span in renamable(&self.file.text, grammar, found, &from, &to) {
                self.edit(span, &to);
            }
        }
    }

    fn include(&mut self, node: Node<'_>) {
        let Some(path) = node.child_by_field_name("path") else {
            return;
        };
        let span = path.byte_range();
        let written = self.text(&span);
        let name = written.trim_matches(['"', '<', '>']);
        let (start, file) = match name.rfind('/') {
            Some(at) => (at + 1, &name[at + 1..]),
            None => (0, name),
        };
        let Some(stem) = file.strip_suffix(".h") else {
            return;
        };
        if let Some(to) = self.names.files.get(stem).cloned() {
            let start = span.start + 1 + start;
            self.edit(start..start + stem.len(), &to);
        }
    }

    /// Renames names of the mapping in the text of a macro, and lists all others, because the text has no
    /// types.
    fn macro_text(&mut self, span: &Span) {
        let text = self.text(span);
        for word in words(text) {
            let at = span.start + word.start;
            let name: SmolStr = text[word.clone()].into();
            let before = text[..word.start].trim_end();
            let after = text[word.end..].trim_start();
            let pasted = before.ends_with("##") || after.starts_with("##");
            let reached = before.ends_with('.') || before.ends_with("->");
            if pasted {
                let part = |global: &&(Vec<SmolStr>, SmolStr)| {
                    global.1.starts_with(name.as_str()) || global.1.ends_with(name.as_str())
                };
                if name.len() > 1 && self.names.globals.keys().any(|key| part(&key)) {
                    self.leave(at, &name, UnchangedReason::Macro);
                }
            } else if reached {
                if self.names.members.keys().any(|key| key.1 == name) {
                    self.leave(at, &name, UnchangedReason::Macro);
                }
            } else if let Some(function) = self.names.clashing.get(&name) {
                // The codel or the event.
                if function.is_some() || self.respelled(&name).is_some() {
                    self.leave(at, &name, UnchangedReason::Macro);
                }
            } else if let Some(to) = self.names.globals.get(&(Vec::new(), name.clone())).cloned() {
                self.edit(at..at + name.len(), &to);
            } else if self.names.globals.keys().any(|key| key.1 == name) {
                self.leave(at, &name, UnchangedReason::Macro);
            }
        }
    }

    /// Names of the mapping in strings and comments.
    fn prose(&mut self, span: &Span, why: UnchangedReason) {
        let text = self.text(span);
        for (at, word) in spelled(text) {
            let is_name = word.contains('_') || word.contains("::");
            if is_name && self.respelled(word).is_some() {
                self.leave(span.start + at, word, why);
            }
        }
    }

    /// The new spelling of a name of the mapping, scopes included; `None` if it is unchanged.
    fn respelled(&self, word: &str) -> Option<String> {
        let (colons, path) = match word.strip_prefix("::") {
            Some(path) => ("::", path),
            None => ("", word),
        };
        let path: Vec<SmolStr> = path.split("::").map(SmolStr::from).collect();
        let mut changed = false;
        let steps = (0..path.len()).map(|step| {
            let key = (path[..step].to_vec(), path[step].clone());
            match self.names.globals.get(&key) {
                Some(to) => {
                    changed = true;
                    to.to_string()
                }
                None => path[step].to_string(),
            }
        });
        let spelled = steps.collect::<Vec<_>>().join("::");
        changed.then(|| format!("{colons}{spelled}"))
    }

    /// Renames in the comment of the skeleton: codel and owner, and the events and exceptions of its
    /// sentences.
    fn generated(&mut self, generated: &Generated) {
        let header = self.text(&generated.header);
        let all: Vec<(usize, &str)> = spelled(header).collect();
        let last = all.len().saturating_sub(1);
        for (number, (at, word)) in all.into_iter().enumerate() {
            let to = match number == last {
                true => self.names.owners.get(word).map(ToString::to_string),
                false if word == generated.codel.as_str() => match self.names.clashing.get(word) {
                    Some(function) => function.as_ref().map(ToString::to_string),
                    None => self.respelled(word),
                },
                false => None,
            };
            if let Some(to) = to {
                let start = generated.header.start + at;
                self.edit(start..start + word.len(), &to);
            }
        }
        let sentences = self.text(&generated.sentences);
        for (at, word) in spelled(sentences) {
            if let Some(to) = self.respelled(word) {
                let start = generated.sentences.start + at;
                self.edit(start..start + word.len(), &to);
            }
        }
    }
}

/// Words of prose with their places; a word includes its scopes.
fn spelled(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = text.split(move |c| !part(c)).filter(|part| !part.is_empty());
    // Each word is a part of `text`, so the distance is its place.
    words.map(move |word| {
        let name = word.trim_end_matches(':');
        (name.as_ptr() as usize - text.as_ptr() as usize, name)
    })
}

/// The lines that list the unchanged places, at most `most` of them.
pub fn listed(left: &[UnchangedPlace], most: usize, root: &Utf8Path) -> String {
    let short = |place: &UnchangedPlace| UnchangedPlace {
        path: place.path.strip_prefix(root).unwrap_or(&place.path).to_owned(),
        ..place.clone()
    };
    let mut out: Vec<String> =
        left.iter().take(most).map(|place| short(place).to_string()).collect();
    if left.len() > most {
        out.push(format!("and {} more", left.len() - most));
    }
    out.join("\n")
}
