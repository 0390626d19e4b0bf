//! A reader of one C or C++ text, for codels: its functions, their return values and exceptions, and the
//! declared names.
//!
//! [`SourceIndex::new`] is a pure function of the text, and it never fails. Text that cannot be parsed is
//! skipped, and every part about which something is unknown is marked ([`Body::broken`], [`Function::known`],
//! [`Value::Unknown`], [`SourceIndex::loose`]).

mod body;
pub(crate) mod comment;
pub(crate) mod ctype;
mod declare;
pub(crate) mod place;
pub(crate) mod types;

use std::borrow::Cow;
use std::ops::Range;

use rustc_hash::FxHashSet;
use smol_str::SmolStr;
use tree_sitter::Parser;

pub use comment::{Comment, Generated};
pub(crate) use ctype::compact;
pub use ctype::{CType, Layer};

/// Byte offsets of start and end.
pub type Span = Range<usize>;

/// Maximum length of a text in bytes; longer texts are generated and not read.
const MAX_LEN: usize = 8 << 20;

/// The grammar a text is read with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Grammar {
    C,
    Cxx,
}

impl Grammar {
    /// The grammar of a file, by its extension. Headers of C components are C.
    pub fn of_path(path: &str) -> Option<Grammar> {
        match path.rsplit_once('.')?.1 {
            "c" | "h" => Some(Grammar::C),
            "cc" | "cpp" | "cxx" | "C" | "c++" | "hh" | "hpp" | "hxx" => Some(Grammar::Cxx),
            _ => None,
        }
    }
}

/// The content of one text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceIndex {
    /// The grammar it was read with.
    pub grammar: Grammar,
    /// Definitions and prototypes, in text order.
    pub functions: Vec<Function>,
    /// The macros it defines.
    pub macros: Vec<Macro>,
    /// Types, variables and functions declared outside functions.
    pub names: FxHashSet<SmolStr>,
    /// Identifiers outside functions that are not in a recognized declaration: arguments of macros, and parts
    /// that cannot be parsed. Each may be the name of a function.
    pub loose: FxHashSet<SmolStr>,
    /// Words in the definitions of macros, also inside functions.
    pub in_macros: FxHashSet<SmolStr>,
    /// `#include` directives, in text order.
    pub includes: Vec<Include>,
}

/// `#include "path"`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Include {
    /// The path without the quotes or angle brackets.
    pub path: String,
    /// The directive.
    pub span: Span,
}

/// `#define NAME …`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Macro {
    pub name: SmolStr,
    /// True if it may leave the function that uses it.
    pub returns: bool,
    /// True if it builds names with `##`.
    pub pastes: bool,
}

/// A function definition or a prototype.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Function {
    /// Name without scopes.
    pub name: SmolStr,
    pub name_span: Span,
    /// Enclosing namespaces, classes and qualifiers, outermost first; an anonymous namespace is
    /// empty.
    pub scope: Vec<SmolStr>,
    /// True in an `extern "C"` block.
    pub extern_c: bool,
    /// `static`
    pub is_static: bool,
    /// The return type; without storage classes.
    pub result: CType,
    /// In order; `(void)` is empty.
    pub parameters: Vec<Parameter>,
    /// True if the list ends with `...`.
    pub variadic: bool,
    /// True if the signature was parsed without an error.
    pub known: bool,
    /// From the return type to the closing parenthesis: the part that a new signature replaces.
    pub signature_span: Span,
    /// The whole definition or declaration.
    pub span: Span,
    /// `None` for a prototype.
    pub body: Option<Body>,
    /// Comments directly above, nearest first.
    pub comments: Vec<Comment>,
}

/// A function parameter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Its name, if it has one.
    pub name: Option<SmolStr>,
    /// Its type.
    pub ty: CType,
    /// The whole parameter.
    pub span: Span,
}

/// The content of a function, as far as it concerns the state machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Body {
    /// The braces and the text between them.
    pub span: Span,
    /// True if it has syntax errors.
    pub broken: bool,
    /// True if it is the sample of the skeleton, still to be written.
    pub sample: bool,
    /// Every `return` with a value, in text order.
    pub returns: Vec<Return>,
    /// Every call by name, in text order.
    pub calls: Vec<Call>,
    /// Every `throw` of a named type, in text order (C++).
    pub throws: Vec<Throw>,
    /// Every identifier.
    pub mentions: FxHashSet<SmolStr>,
    /// Parameters with a use that may write a port: every use except `NAME->data(…)` and other calls of a
    /// port that write nothing.
    pub escaping: FxHashSet<SmolStr>,
    /// Names used as values that the function does not declare, each at its first use. Names under a
    /// preprocessor condition, and arguments of calls, which may be macros, are absent.
    pub free: Vec<(SmolStr, Span)>,
    /// Writes through a parameter to constant data: the parameter's name, and the left side.
    pub constant_writes: Vec<(SmolStr, Span)>,
}

/// A `return` statement.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Return {
    /// The statement.
    pub span: Span,
    /// The values it may return: several for conditional expressions and variables.
    pub values: Vec<Value>,
}

/// A value that a function may return.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Value {
    /// A name that is not a variable of the function.
    Name {
        /// The name as written, scopes included.
        name: SmolStr,
        /// Its place.
        span: Span,
        /// True if it was assigned to a variable first: it probably, but not certainly, reaches the `return`.
        variable: bool,
    },
    /// The result of a function or macro.
    Call {
        /// Index into [`Body::calls`].
        call: usize,
        /// See [`Value::Name`].
        variable: bool,
    },
    /// Anything else.
    Unknown,
}

/// A call by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Call {
    /// The name as written, scopes included.
    pub name: SmolStr,
    /// The place of the name.
    pub span: Span,
    /// Number of arguments.
    pub arguments: usize,
    /// The last argument, if it is a plain name.
    pub last: Option<SmolStr>,
    /// True if it is a statement by itself.
    pub statement: bool,
}

/// `throw name(…)` or `throw name`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Throw {
    /// The name as written, scopes included.
    pub name: SmolStr,
    /// The place of the name.
    pub span: Span,
}

impl SourceIndex {
    /// Reads a text.
    pub fn new(text: &str, grammar: Grammar) -> SourceIndex {
        let mut index = SourceIndex {
            grammar,
            functions: Vec::new(),
            macros: Vec::new(),
            names: FxHashSet::default(),
            loose: FxHashSet::default(),
            in_macros: words_in_macros(text),
            includes: Vec::new(),
        };
        if let Some(tree) = parse(text, grammar) {
            declare::declarations(tree.root_node(), text, &mut index);
            index.functions.sort_by_key(|function| function.span.start);
        }
        index
    }

    /// Definitions of a name that have this name for the linker.
    pub fn definitions<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Function> + 'a {
        self.functions.iter().filter(move |function| {
            function.name == name && function.body.is_some() && function.is_global()
        })
    }

    /// The function around an offset.
    pub(crate) fn function_at(&self, offset: usize) -> Option<&Function> {
        self.functions
            .iter()
            .find(|function| function.span.start <= offset && offset <= function.span.end)
    }
}

impl Function {
    /// True if its symbol is its plain name: it is in no namespace or class, or is `extern "C"`.
    pub(crate) fn is_global(&self) -> bool {
        self.scope.is_empty() || self.extern_c
    }
}

/// Places where an identifier is used (not in comments or strings), in text order.
pub fn mentions(text: &str, grammar: Grammar, name: &str) -> Vec<Span> {
    places(text, grammar, name, |_| true)
}

/// Places where a function is declared, defined or called, in text order.
pub(crate) fn function_mentions(text: &str, grammar: Grammar, name: &str) -> Vec<Span> {
    places(text, grammar, name, place::is_function_name)
}

fn places(
    text: &str,
    grammar: Grammar,
    name: &str,
    is_wanted: impl Fn(tree_sitter::Node<'_>) -> bool,
) -> Vec<Span> {
    let mut out = Vec::new();
    if name.is_empty() || !text.contains(name) {
        return out;
    }
    let Some(tree) = parse(text, grammar) else {
        return out;
    };
    preorder(tree.root_node(), |node| {
        if node.child_count() == 0
            && node.is_named()
            && node.kind().ends_with("identifier")
            && ctype::source(node, text) == name
            && is_wanted(node)
        {
            out.push(node.byte_range());
        }
        true
    });
    out
}

/// The words in definitions of macros.
fn words_in_macros(text: &str) -> FxHashSet<SmolStr> {
    let mut out = FxHashSet::default();
    let mut inside = false;
    for line in text.lines() {
        let directive = line.trim_start().strip_prefix('#').map(str::trim_start);
        let here = inside || directive.is_some_and(|directive| directive.starts_with("define"));
        inside = here && line.trim_end().ends_with('\\');
        if here {
            let words = line.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
            out.extend(words.filter(|word| !word.is_empty()).map(SmolStr::from));
        }
    }
    out
}

pub(crate) fn parse(text: &str, grammar: Grammar) -> Option<tree_sitter::Tree> {
    if text.len() > MAX_LEN {
        return None;
    }
    let language = match grammar {
        Grammar::C => tree_sitter_c::LANGUAGE.into(),
        Grammar::Cxx => tree_sitter_cpp::LANGUAGE.into(),
    };
    let mut parser = Parser::new();
    parser.set_language(&language).ok()?;
    parser.parse(without_attributes(text).as_ref(), None)
}

/// The text with blanks for each `__attribute__((…))`: compilers accept attributes in more places than the
/// grammars, and nothing here depends on one.
fn without_attributes(text: &str) -> Cow<'_, str> {
    const WORD: &str = "__attribute";
    let mut out = Cow::Borrowed(text);
    let mut from = 0;
    while let Some(found) = text[from..].find(WORD) {
        let start = from + found;
        from = start + WORD.len();
        let rest = text[from..].strip_prefix("__").unwrap_or(&text[from..]);
        let list = rest.trim_start();
        let within = text[..start]
            .ends_with(|character: char| character.is_alphanumeric() || character == '_');
        if let Some(length) = parenthesised(list)
            && !within
        {
            let end = text.len() - list.len() + length;
            // Lines of a macro are continued after a backslash.
            let is_splice =
                |at: usize| text[at..].starts_with("\\\n") || text[at..].starts_with("\\\r\n");
            // A character of several bytes becomes the same number of blanks.
            let blanks: String = text[start..end]
                .char_indices()
                .flat_map(|(at, letter)| {
                    let kept = letter.is_ascii_whitespace() || is_splice(start + at);
                    std::iter::repeat_n(if kept { letter } else { ' ' }, letter.len_utf8())
                })
                .collect();
            out.to_mut().replace_range(start..end, &blanks);
            from = end;
        }
    }
    out
}

/// Maximum length of a list of attributes in bytes; longer lists are unchanged.
const LONGEST_ATTRIBUTE: usize = 1024;

/// The length of the parentheses at the start of a text; `None` if they are not closed in the following code.
fn parenthesised(text: &str) -> Option<usize> {
    text.strip_prefix('(')?;
    let mut depth = 0_usize;
    let mut in_string = false;
    let mut before = ' ';
    for (at, letter) in text.char_indices().take(LONGEST_ATTRIBUTE) {
        match letter {
            '"' if before != '\\' => in_string = !in_string,
            _ if in_string => {}
            '(' => depth += 1,
            ')' => depth -= 1,
            '/' if before == '*' => return None,
            ';' | '{' | '}' => return None,
            _ => {}
        }
        if depth == 0 {
            return Some(at + 1);
        }
        before = letter;
    }
    None
}

/// Visits a tree in text order without recursion; `enter` returns true if the children have to be visited.
pub(crate) fn preorder<'t>(
    root: tree_sitter::Node<'t>,
    mut enter: impl FnMut(tree_sitter::Node<'t>) -> bool,
) {
    let mut cursor = root.walk();
    loop {
        if enter(cursor.node()) && cursor.goto_first_child() {
            continue;
        }
        while !cursor.goto_next_sibling() {
            if !cursor.goto_parent() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests;
