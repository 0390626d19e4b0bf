//! A new prototype for a function, with the necessary changes of its body and of its calls.

mod comments;

use std::fmt;
use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::FxHashSet;
use serde::Serialize;
use smol_str::SmolStr;
use tree_sitter::Node;

use super::Repairs;
use crate::codels::{
    edit::{Edit, TextEdit},
    files::IndexedFile,
    source::{CType, Function, Layer, Parameter, parse, place::is_declared, preorder},
};
use crate::lang::Language;
use comments::{split, with_comments};

/// A change after a new signature that has to be made by hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ManualChange {
    /// The source.
    pub path: Utf8PathBuf,
    /// Line, from 1, in the text of [`ManualChange::offset`].
    pub line: usize,
    /// Byte offset in the text before the repair; after [`ManualChange::follow`], in the text after it.
    #[serde(skip)]
    pub offset: usize,
    pub function: SmolStr,
    /// The expression at that place.
    pub what: UnadaptedUse,
}

/// An expression that cannot be adapted to a new signature.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum UnadaptedUse {
    /// A use of a parameter that is removed.
    Parameter(SmolStr),
    /// A call with an unknown argument, a call that would lose a comment, or a call inside of another one or
    /// of the function itself.
    Call,
}

impl ManualChange {
    /// Adapts the offset to edits of its file.
    pub fn follow(&mut self, edits: &[TextEdit]) {
        let mut offset = self.offset;
        for edit in edits.iter().filter(|edit| edit.range.end <= self.offset) {
            offset = offset + edit.text.len() - edit.range.len();
        }
        self.offset = offset;
    }

    /// Sets the line, from the present text of its file.
    pub(crate) fn set_line(&mut self, text: &str) {
        self.line = line_of(text, self.offset);
    }
}

impl fmt::Display for ManualChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, line, function) = (&self.path, self.line, &self.function);
        write!(f, "{path}:{line}: ")?;
        match &self.what {
            UnadaptedUse::Parameter(parameter) => write!(
                f,
                "`{function}` has no parameter `{parameter}` any more; take the use away, or put the parameter back \
                 into the specification"
            ),
            UnadaptedUse::Call => write!(
                f,
                "`{function}` has other parameters now; give this call the arguments for them"
            ),
        }
    }
}

/// A parameter of the specification and the corresponding parameter of the function.
struct Pair {
    /// Index into the parameters of the function; `None` for a new one.
    found: Option<usize>,
    /// The new name in the function.
    name: SmolStr,
    change: Change,
}

/// A change of a parameter that affects the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    Same,
    /// `T x` becomes `T *x`.
    ToPointer,
    /// `T *x` becomes `T x`.
    ToValue,
}

impl Repairs<'_> {
    /// Gives a function the prototype of the specification. Parameters with another name are renamed in the
    /// body. If a parameter becomes a pointer or a value, its uses are adapted. Calls are adapted too.
    pub(super) fn update_signature(
        &self,
        name: &str,
        file: &IndexedFile,
        function: &Function,
    ) -> Option<Edit> {
        let expected = self.expected.function(name)?;
        let wanted = &expected.shape.as_ref()?.parameters;
        let pairs = pairs(wanted, function);
        let mut codel = self.expected.component().codel(*expected.uses.first()?).clone();
        for (param, pair) in codel.params.iter_mut().zip(&pairs) {
            param.name = pair.name.as_str().into();
        }
        let old = file.text.get(function.signature_span.clone())?;
        // The name stays on its line.
        let head = file.text.get(function.signature_span.start..function.name_span.start)?;
        let separator = if head.contains('\n') { "\n" } else { " " };
        let mapper = self.expected.mapper();
        let text = mapper.prototype(self.expected.component, &codel, separator).ok()?;
        let text = match pairs.get(codel.params.len()) {
            Some(context) if self.expected.language == Language::C => {
                text.replacen("genom_context self)", &format!("genom_context {})", context.name), 1)
            }
            _ => text,
        };
        let text = adapted_prototype(file, function, wanted, &pairs, &text)
            .or_else(|| with_comments(file, function, &pairs, &text))
            .unwrap_or(text);
        let mut edit = Edit::default();
        if function.is_static {
            let start = function.span.start;
            let before = file.text.get(start..function.signature_span.start)?;
            edit.replace(
                &file.path,
                start..function.signature_span.start,
                before.replacen("static", "", 1).trim_start().to_owned(),
            );
        }
        if text != old {
            edit.replace(&file.path, function.signature_span.clone(), text);
        }
        if function.body.is_some() {
            follow_body(file, function, &pairs, &mut edit);
            for (path, span, text) in self.calls(name, file, function, &pairs).edits {
                edit.replace(path, span, text);
            }
        }
        Some(edit)
    }

    /// Calls in the sources: the edits for calls with known arguments, and the places of the others.
    fn calls(
        &self,
        name: &str,
        own: &IndexedFile,
        function: &Function,
        pairs: &[Pair],
    ) -> Calls<'_> {
        let mut out = Calls::default();
        let same = in_place(pairs, function.parameters.len());
        if same && pairs.iter().all(|pair| pair.change == Change::Same) {
            return out;
        }
        for file in self.sources.all() {
            if !file.text.contains(name) {
                continue;
            }
            let Some(tree) = parse(&file.text, file.grammar) else {
                continue;
            };
            // Uses of parameters in the body have edits of their own, and edits must not overlap.
            let body = function.body.as_ref().filter(|_| file.path == own.path);
            let mut followed: Range<usize> = 0..0;
            preorder(tree.root_node(), |node| {
                if node.kind() == "call_expression"
                    && let Some(called) = node.child_by_field_name("function")
                    && file.text.get(called.byte_range()) == Some(name)
                    && let Some(list) = node.child_by_field_name("arguments")
                {
                    let inside = body.is_some_and(|body| body.span.contains(&node.start_byte()))
                        || followed.contains(&node.start_byte());
                    match arguments(file, list, function, pairs).filter(|_| !inside) {
                        Some(edits) => {
                            followed = list.byte_range();
                            let edits = edits.into_iter();
                            out.edits.extend(edits.map(|edit| (&*file.path, edit.0, edit.1)));
                        }
                        None => out.left.push((file, node.start_byte())),
                    }
                }
                true
            });
        }
        out
    }

    /// The places that are not adapted to the new signature of a function: uses of removed parameters, and
    /// calls.
    pub(crate) fn manual_changes(
        &self,
        name: &str,
        path: &Utf8Path,
        start: usize,
    ) -> Vec<ManualChange> {
        let Some((file, function)) = self.function(path, start) else {
            return Vec::new();
        };
        let expected = self.expected.function(name);
        let Some(shape) = expected.and_then(|function| function.shape.as_ref()) else {
            return Vec::new();
        };
        let pairs = pairs(&shape.parameters, function);
        let kept: FxHashSet<usize> = pairs.iter().filter_map(|pair| pair.found).collect();
        let by_hand = |file: &IndexedFile, offset, what| ManualChange {
            path: file.path.clone(),
            line: line_of(&file.text, offset),
            offset,
            function: name.into(),
            what,
        };
        let mut out = Vec::new();
        for (index, parameter) in function.parameters.iter().enumerate() {
            let Some(lost) = parameter.name.as_ref().filter(|_| !kept.contains(&index)) else {
                continue;
            };
            let tree = parse(&file.text, file.grammar);
            for span in uses(file, function, lost).unwrap_or_default() {
                // The repair removes this use.
                if tree
                    .as_ref()
                    .is_some_and(|tree| discard(tree.root_node(), &span, &file.text).is_some())
                {
                    continue;
                }
                out.push(by_hand(file, span.start, UnadaptedUse::Parameter(lost.clone())));
            }
        }
        if function.body.is_some() {
            let calls = self.calls(name, file, function, &pairs).left.into_iter();
            out.extend(calls.map(|(file, offset)| by_hand(file, offset, UnadaptedUse::Call)));
        }
        out
    }
}

/// The result for the calls of a function.
#[derive(Default)]
struct Calls<'a> {
    edits: Vec<(&'a Utf8Path, Range<usize>, String)>,
    /// Files and places of calls that are unchanged.
    left: Vec<(&'a IndexedFile, usize)>,
}

/// The line of an offset, from 1.
fn line_of(text: &str, offset: usize) -> usize {
    1 + text.get(..offset).unwrap_or_default().matches('\n').count()
}

/// True if every parameter keeps its place, and there is no additional one.
fn in_place(pairs: &[Pair], count: usize) -> bool {
    pairs.len() == count
        && (pairs.iter().enumerate()).all(|(index, pair)| pair.found == Some(index))
}

/// The corresponding parameter of the function for each required one: by name, else by type, in order.
fn pairs(wanted: &[Parameter], function: &Function) -> Vec<Pair> {
    let found = &function.parameters;
    let mut free: Vec<usize> = (0..found.len()).collect();
    let mut out: Vec<Option<usize>> = wanted
        .iter()
        .map(|parameter| {
            let same =
                |&index: &usize| parameter.name.is_some() && found[index].name == parameter.name;
            let at = free.iter().position(same)?;
            Some(free.remove(at))
        })
        .collect();
    let by_type = |a: &CType, b: &CType| a.without_const() == b.without_const();
    let by_base = |a: &CType, b: &CType| a.base == b.base;
    // The stricter comparison of types goes first.
    for same in [&by_type as &dyn Fn(&CType, &CType) -> bool, &by_base] {
        for (parameter, pair) in wanted.iter().zip(&mut out) {
            if pair.is_none()
                && let Some(at) = free.iter().position(|&old| same(&parameter.ty, &found[old].ty))
            {
                *pair = Some(free.remove(at));
            }
        }
    }
    let mentioned = |name: &str| {
        let body = function.body.as_ref();
        body.is_some_and(|body| body.mentions.contains(name))
    };
    let named =
        |name: &SmolStr| found.iter().any(|parameter| parameter.name.as_ref() == Some(name));
    wanted
        .iter()
        .zip(out)
        .map(|(parameter, index)| {
            let old = index.and_then(|old| found[old].name.clone());
            let new = parameter.name.clone().unwrap_or_default();
            // The context is not in the specification. The body may use its usual name for another variable,
            // which would hide it.
            let context = parameter.ty.base == "genom_context";
            let taken = context || old.as_ref() != Some(&new) && (mentioned(&new) || named(&new));
            let change = index.map_or(Change::Same, |old| change(&found[old].ty, &parameter.ty));
            Pair { found: index, name: old.filter(|_| taken).unwrap_or(new), change }
        })
        .collect()
}

fn change(from: &CType, to: &CType) -> Change {
    let pointer = |ty: &CType| matches!(ty.layers.as_slice(), [Layer::Pointer { .. }]);
    match (from.layers.is_empty(), to.layers.is_empty()) {
        (true, false) if pointer(to) => Change::ToPointer,
        (false, true) if pointer(from) => Change::ToValue,
        _ => Change::Same,
    }
}

/// The function's own prototype with the necessary changes: its parameters keep their text and the text
/// between them. A new parameter is laid out like the others. `None` if a comment would lose its parameter,
/// or if the head changes.
fn adapted_prototype(
    file: &IndexedFile,
    function: &Function,
    wanted: &[Parameter],
    pairs: &[Pair],
    prototype: &str,
) -> Option<String> {
    let text = &file.text;
    let found = &function.parameters;
    let (first, last) = (found.first()?, found.last()?);
    let head = text.get(function.signature_span.start..first.span.start)?;
    let tail = text.get(last.span.end..function.signature_span.end)?;
    let open = prototype.find('(')?;
    let declarations = split(prototype[open + 1..].strip_suffix(')')?);
    if words(head) != words(&prototype[..=open]) || declarations.len() != pairs.len() {
        return None;
    }
    let gaps = found.windows(2);
    let gaps = gaps.map(|gap| text.get(gap[0].span.end..gap[1].span.start));
    let gaps: Vec<&str> = gaps.collect::<Option<_>>()?;
    let is_plain = |text: &&str| !text.contains(['/', '#', '"']);
    let kept = in_place(pairs, found.len());
    if !kept && !gaps.iter().chain([&head, &tail]).all(is_plain) {
        return None;
    }
    let mut out = head.to_owned();
    for (index, ((pair, wanted), declaration)) in
        pairs.iter().zip(wanted).zip(&declarations).enumerate()
    {
        if let Some(before) = index.checked_sub(1) {
            let usual = gaps.last().copied().unwrap_or(", ");
            out += gaps.get(before).copied().unwrap_or(usual);
        }
        let same = pair.found.map(|parameter| &found[parameter]).filter(|parameter| {
            // A parameter passed by value may be `const` or not.
            let by_value = parameter.ty.layers.is_empty() && wanted.ty.layers.is_empty();
            let same_type =
                parameter.ty == wanted.ty || by_value && parameter.ty.base == wanted.ty.base;
            same_type && parameter.name.as_deref().unwrap_or_default() == pair.name
        });
        match same {
            Some(same) => out += text.get(same.span.clone())?,
            None => out += declaration,
        }
    }
    Some(out + tail)
}

/// A text without blanks, except those that separate words.
fn words(text: &str) -> String {
    let mut out = String::new();
    for word in text.split_whitespace() {
        let part = |character: char| character.is_alphanumeric() || character == '_';
        if out.ends_with(part) && word.starts_with(part) {
            out.push(' ');
        }
        out += word;
    }
    out
}

/// The places of a parameter in the body; `None` if the body declares another variable of that name.
fn uses(file: &IndexedFile, function: &Function, name: &str) -> Option<Vec<Range<usize>>> {
    let tree = parse(&file.text, file.grammar)?;
    let body = function.body.as_ref()?.span.clone();
    let (mut out, mut hidden) = (Vec::new(), false);
    preorder(tree.root_node(), |node| {
        let span = node.byte_range();
        if span.end <= body.start || span.start >= body.end {
            return false;
        }
        if node.kind() == "identifier" && file.text.get(span.clone()) == Some(name) {
            hidden |= is_declared(node);
            if span.start >= body.start {
                out.push(span);
            }
        }
        true
    });
    (!hidden).then_some(out)
}

fn follow_body(file: &IndexedFile, function: &Function, pairs: &[Pair], edit: &mut Edit) {
    let Some(tree) = parse(&file.text, file.grammar) else {
        return;
    };
    remove_discards(file, function, (pairs, tree.root_node()), edit);
    for pair in pairs {
        let parameter = pair.found.and_then(|place| function.parameters.get(place));
        let Some(old) = parameter.and_then(|parameter| parameter.name.as_ref()) else {
            continue;
        };
        if *old == pair.name && pair.change == Change::Same {
            continue;
        }
        for span in uses(file, function, old).unwrap_or_default() {
            let node = tree.root_node().descendant_for_byte_range(span.start, span.end);
            if let Some(node) = node {
                let (span, text) = respelled(node, &pair.name, pair.change, &file.text);
                edit.replace(&file.path, span, text);
            }
        }
    }
}

/// Removes the statements `(void)x;` of removed parameters.
fn remove_discards(
    file: &IndexedFile,
    function: &Function,
    (pairs, root): (&[Pair], Node<'_>),
    edit: &mut Edit,
) {
    for (index, parameter) in function.parameters.iter().enumerate() {
        let kept = pairs.iter().any(|pair| pair.found == Some(index));
        let Some(lost) = parameter.name.as_ref().filter(|_| !kept) else { continue };
        for span in uses(file, function, lost).unwrap_or_default() {
            if let Some(statement) = discard(root, &span, &file.text) {
                edit.replace(&file.path, statement, String::new());
            }
        }
    }
}

/// Returns the statement `(void)x;` around a use, with its line if the line has nothing else.
fn discard(root: Node<'_>, span: &Range<usize>, text: &str) -> Option<Range<usize>> {
    let cast = root.descendant_for_byte_range(span.start, span.end)?.parent()?;
    let target = text.get(cast.child_by_field_name("type")?.byte_range())?;
    let statement = cast.parent()?;
    let kinds = (cast.kind(), statement.kind(), statement.parent()?.kind());
    if kinds != ("cast_expression", "expression_statement", "compound_statement")
        || target != "void"
    {
        return None;
    }
    let range = statement.byte_range();
    let start = text.get(..range.start)?.trim_end_matches([' ', '\t']).len();
    let after = text.get(range.end..)?;
    let blank = after.len() - after.trim_start_matches([' ', '\t', '\r']).len();
    let alone = text[..start].ends_with('\n') && after[blank..].starts_with('\n');
    Some(if alone { start..range.end + blank + 1 } else { range })
}

/// The new spelling of a use.
fn respelled(node: Node<'_>, name: &str, change: Change, text: &str) -> (Range<usize>, String) {
    let own = node.byte_range();
    let parent = node.parent();
    let kind = parent.map_or("", |parent| parent.kind());
    let operator = |field: &str| {
        let at = parent.and_then(|parent| parent.child_by_field_name(field));
        at.map_or("", |child| text.get(child.byte_range()).unwrap_or_default())
    };
    let argument =
        parent.is_some_and(|parent| parent.child_by_field_name("argument") == Some(node));
    let whole = parent.map_or(own.clone(), |parent| parent.byte_range());
    let member = |to: &str| {
        let operator = parent.and_then(|parent| parent.child_by_field_name("operator"));
        let end = operator.map_or(own.end, |operator| operator.end_byte());
        (own.start..end, format!("{name}{to}"))
    };
    match (change, kind) {
        (Change::Same, _) => (own, name.to_owned()),
        (Change::ToPointer, "field_expression") if argument && operator("operator") == "." => {
            member("->")
        }
        (Change::ToPointer, "pointer_expression") if operator("operator") == "&" => {
            (whole, name.to_owned())
        }
        (Change::ToPointer, _) => {
            let postfix = argument && matches!(kind, "subscript_expression" | "update_expression");
            // A `*` after a `/` would begin a comment.
            let division = text.get(..own.start).is_some_and(|text| text.ends_with('/'));
            if postfix || division {
                (own, format!("(*{name})"))
            } else {
                (own, format!("*{name}"))
            }
        }
        (Change::ToValue, "field_expression") if argument && operator("operator") == "->" => {
            member(".")
        }
        (Change::ToValue, "pointer_expression") if operator("operator") == "*" => {
            (whole, name.to_owned())
        }
        (Change::ToValue, "subscript_expression") if argument => (own, format!("(&{name})")),
        (Change::ToValue, _) => (own, format!("&{name}")),
    }
}

/// The edits for the arguments of a call: each at its place, or the whole list if their order or number
/// changes. `None` if the argument for a new parameter is unknown, or if a comment would lose its place.
fn arguments(
    file: &IndexedFile,
    list: Node<'_>,
    function: &Function,
    pairs: &[Pair],
) -> Option<Vec<(Range<usize>, String)>> {
    let mut cursor = list.walk();
    let (notes, old): (Vec<Node<'_>>, Vec<Node<'_>>) = list
        .named_children(&mut cursor)
        .partition(|child| child.kind() == "comment" || child.kind().starts_with("preproc"));
    if old.len() != function.parameters.len() {
        return None;
    }
    let in_place = in_place(pairs, old.len());
    if !in_place && !notes.is_empty() {
        return None;
    }
    // A variable of the caller with the name of the new parameter is passed.
    let caller = file.index().function_at(list.start_byte())?;
    let out: Option<Vec<String>> = pairs
        .iter()
        .map(|pair| {
            let Some(index) = pair.found else {
                let known = caller.parameters.iter();
                let known = known.filter_map(|parameter| parameter.name.as_ref());
                return known.into_iter().find(|name| **name == pair.name).map(ToString::to_string);
            };
            let node = old[index];
            let text = file.text.get(node.byte_range())?;
            Some(match (pair.change, node.kind()) {
                (Change::Same, _) => text.to_owned(),
                (Change::ToPointer, "identifier" | "field_expression" | "subscript_expression") => {
                    format!("&{text}")
                }
                // The value is not an lvalue and has no address.
                (Change::ToPointer, _) => return None,
                (Change::ToValue, "pointer_expression") if text.starts_with('&') => {
                    text[1..].trim_start().to_owned()
                }
                (Change::ToValue, "identifier") => format!("*{text}"),
                (Change::ToValue, _) => format!("*({text})"),
            })
        })
        .collect();
    let out = out?;
    Some(if in_place {
        let all = pairs.iter().zip(&old).zip(out);
        let changed = all.filter(|((pair, _), _)| pair.change != Change::Same);
        changed.map(|((_, node), text)| (node.byte_range(), text)).collect()
    } else {
        vec![(list.byte_range(), format!("({})", out.join(", ")))]
    })
}
