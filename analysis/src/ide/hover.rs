//! A short description of the name under the cursor: declaration, type, value, documentation.

mod facts;
mod own;

use dotgen_syntax::{SyntaxKind, SyntaxNode, TextRange, preproc::MacroSite};

use super::{
    FileView, Hover, RangeInfo, SymbolKind,
    document_links::missing_includes,
    goto::value_type,
    render::{self, normalized, one_line},
    resolve::{Target, container_name, meanings_at},
};
use crate::{
    base::{SourceFile, lexed},
    elab::{DefId, DefKind, Definition, Elaborated, Entity},
    markdown,
    model::{Component, ComponentId, TypeKind, Value},
    source_map::bytes,
    unit::define,
};

pub(crate) fn hover(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Hover>> {
    let Some((range, targets)) = meanings_at(view, at) else {
        return missing_include(view, at);
    };
    let mut parts: Vec<String> = Vec::new();
    let mut codels: Vec<(String, String)> = Vec::new();
    for target in &targets {
        if let Target::Definition(id) = target {
            codels.extend(codel(view.elaborated(), *id));
        }
        let part = match target {
            Target::Definition(id) => {
                own::completion(view, range, *id).or_else(|| mentioned(view, *id, Some(range)))
            }
            Target::Macro(name, site) => macro_hover(view, range, name, site.as_ref()),
            Target::File(file) => Some(markdown::code(file.path(view.db).as_str())),
        };
        parts.extend(part.filter(|part| !parts.contains(part)));
    }
    if parts.is_empty() {
        return None;
    }
    let mut text = parts.join("\n\n---\n\n");
    let unit = crate::unit::roots_of(view.db, view.file);
    if let Some(root) = unit.first().filter(|unit| **unit != view.file) {
        let name = root.path(view.db).file_name().unwrap_or_default();
        text += &format!("\n\n*as included by {}*", markdown::code(name));
    }
    Some(RangeInfo { range: bytes(range), info: Hover { markdown: text, codels } })
}

/// The searched directories of an included file that is not found.
fn missing_include(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Hover>> {
    let mut all = missing_includes(view).into_iter();
    let include = all.find(|include| include.range.contains(&at))?;
    // A file that is not read was not searched.
    if include.searched.is_empty() {
        return None;
    }
    let path = markdown::code(&include.path);
    let mut text = format!("{path} is not found. Looked for in, in order:\n");
    for directory in &include.searched {
        text += &format!("\n- {}", markdown::code(directory.as_str()));
    }
    Some(RangeInfo { range: include.range, info: Hover { markdown: text, codels: Vec::new() } })
}

/// The names of component and codel, if the definition is a codel.
fn codel(elaborated: &Elaborated, id: DefId) -> Option<(String, String)> {
    let definition = elaborated.definitions.get(id)?;
    let component = facts::component_of(elaborated, definition)?;
    let found = || (component.name.to_string(), definition.name.to_string());
    (definition.kind == DefKind::Codel).then(found)
}

pub(crate) fn definition(view: &FileView<'_>, id: DefId) -> Option<String> {
    mentioned(view, id, None)
}

/// The text of a definition, shown at a mention of it.
fn mentioned(view: &FileView<'_>, id: DefId, mention: Option<TextRange>) -> Option<String> {
    let elaborated = view.elaborated();
    let definition = elaborated.definitions.get(id)?;
    let mut out = code(&declaration_text(view, definition)?);
    let mut facts: Vec<String> = Vec::new();
    if let Some(container) = container_name(elaborated, definition) {
        facts.push(format!("in `{container}`"));
    }
    facts.extend(type_facts(elaborated, definition));
    if let Some(file) = elsewhere(view, definition) {
        facts.push(format!("from {}", markdown::code(&file)));
    }
    if !facts.is_empty() {
        out += &format!("\n\n{}", facts.join(" · "));
    }
    if let Some(doc) = doc(elaborated, definition) {
        out += &format!("\n\n{}", markdown::text(&doc));
    }
    let owner = mention.and_then(|mention| owner_around(view, mention));
    if let Some(facts) = facts::facts(
        elaborated,
        definition,
        owner.as_ref().map(|owner| (owner.0, owner.1.as_str())),
    ) {
        out += &format!("\n\n{facts}");
    }
    Some(out)
}

/// The task (`true`) or service around a place, by name.
fn owner_around(view: &FileView<'_>, place: TextRange) -> Option<(bool, String)> {
    let root = view.root();
    let inner = root.text_range().contains_range(place).then(|| root.covering_element(place))?;
    let mut around = inner.ancestors();
    let owner = around
        .find(|ancestor| matches!(ancestor.kind(), SyntaxKind::TASK | SyntaxKind::SERVICE))?;
    let name = owner.children().find(|child| child.kind() == SyntaxKind::NAME)?;
    Some((owner.kind() == SyntaxKind::TASK, name.text().to_string()))
}

/// The declaration in a standard layout.
fn declaration_text(view: &FileView<'_>, definition: &Definition) -> Option<String> {
    let (file, range) = view.place(definition.node)?;
    let there = &view_of(view, file)?;
    let kind = SymbolKind::from(definition.kind);
    let node = node_at(there, range);
    let text = match (kind, node) {
        (SymbolKind::Component, _) => format!("component {} {{ … }};", definition.name),
        (SymbolKind::Interface, _) => format!("interface {} {{ … }};", definition.name),
        (SymbolKind::Module, _) => format!("module {} {{ … }};", definition.name),
        (SymbolKind::State, _) => format!("state {}", definition.name),
        (SymbolKind::Enumerator, _) => definition.name.to_string(),
        (SymbolKind::Parameter, Some(node)) if node.kind() == SyntaxKind::NAME => {
            let param = node.ancestors().find(|ancestor| ancestor.kind() == SyntaxKind::PATH_PARAM);
            one_line(there, &param.unwrap_or(node))
        }
        (SymbolKind::Local, Some(node)) => {
            let local = node.ancestors();
            let mut local = local.filter(|local| local.kind() == SyntaxKind::LOCAL_PROPERTY);
            normalized(there, &local.next().unwrap_or(node))
        }
        (SymbolKind::Codel, Some(node)) => {
            // With the word before it.
            let property = node.parent().filter(|parent| {
                matches!(parent.kind(), SyntaxKind::CODEL_PROPERTY | SyntaxKind::VALIDATE_PROPERTY)
            });
            normalized(there, &property.unwrap_or(node))
        }
        (_, Some(node)) => normalized(there, &node),
        (_, None) => definition.name.to_string(),
    };
    Some(text)
}

/// A file as the unit of a view sees it.
fn view_of<'db>(view: &FileView<'db>, file: SourceFile) -> Option<FileView<'db>> {
    let key = if file == view.file {
        view.key
    } else {
        crate::unit::serving_visit(view.db, view.unit, file)?.1
    };
    Some(FileView { db: view.db, file, unit: view.unit, key })
}

/// The outermost node that covers exactly a range.
fn node_at(view: &FileView<'_>, range: TextRange) -> Option<SyntaxNode> {
    let root = view.root();
    if !root.text_range().contains_range(range) || range.is_empty() {
        return None;
    }
    let inner = root.covering_element(range);
    let inner = match inner {
        dotgen_syntax::SyntaxElement::Node(node) => node,
        dotgen_syntax::SyntaxElement::Token(token) => token.parent()?,
    };
    let same = inner
        .ancestors()
        .take_while(|ancestor| ancestor.parent().is_some() && view.node_range(ancestor) == range);
    same.last().or_else(|| {
        // If the tree has an enclosing node (such as a body), that node is shown.
        Some(inner).filter(|node| node.parent().is_some() && node.kind() != SyntaxKind::BODY)
    })
}

fn type_facts(elaborated: &Elaborated, definition: &Definition) -> Vec<String> {
    let spec = &elaborated.spec;
    let Some(ty) = definition.ty else {
        return Vec::new();
    };
    let mut out = Vec::new();
    let value_of = match definition.kind {
        DefKind::Parameter | DefKind::CodelParameter | DefKind::Local => Some(ty),
        DefKind::Member
        | DefKind::IdsMember
        | DefKind::Const
        | DefKind::Port
        | DefKind::Typedef => value_type(spec, ty),
        DefKind::Struct | DefKind::Union | DefKind::Exception => Some(ty),
        _ => None,
    };
    if let Some(value) = value_of {
        let resolved = render::resolved_type_text(spec, value);
        let declares =
            matches!(definition.kind, DefKind::Struct | DefKind::Union | DefKind::Exception);
        if let Some(resolved) = resolved.filter(|_| !declares) {
            out.push(format!("type `{resolved}`"));
        }
        if let Some(size) =
            render::packed_size(spec, value).filter(|_| definition.kind != DefKind::Const)
        {
            out.push(format!("{size} byte{} packed", if size == 1 { "" } else { "s" }));
        }
    }
    match spec.types.get(ty).map(|ty| &ty.kind) {
        Some(TypeKind::Const { value, .. }) => {
            let hexadecimal = match value {
                Value::Uint(number) if *number > 9 => format!(" (`{number:#x}`)"),
                Value::Int(number) if *number > 9 => format!(" (`{number:#x}`)"),
                _ => String::new(),
            };
            out.push(format!("value {}{hexadecimal}", markdown::code(&render::value(spec, value))));
        }
        Some(TypeKind::Enumerator { enumeration, value }) => {
            let of = render::type_text(spec, *enumeration);
            out.push(format!("value {value} of enum `{of}`"));
        }
        _ => {}
    }
    out
}

fn doc(elaborated: &Elaborated, definition: &Definition) -> Option<String> {
    let components = &elaborated.spec.components;
    let of = |c: ComponentId| -> Option<&Component> { components.get(c) };
    let doc = match definition.entity? {
        Entity::Component(c) => of(c)?.doc.clone(),
        Entity::Task(c, i) => of(c)?.tasks.get(i)?.doc.clone(),
        Entity::Port(c, i) => of(c)?.ports.get(i)?.doc.clone(),
        Entity::Service(c, i) => of(c)?.services.get(i)?.doc.clone(),
        Entity::Param(c, i, p) => {
            let service = of(c)?.services.get(i)?;
            service.params.get(p as usize)?.init.as_ref()?.doc.clone()
        }
    };
    doc.filter(|doc| !doc.is_empty())
}

fn elsewhere(view: &FileView<'_>, definition: &Definition) -> Option<String> {
    let (file, _) = view.place(definition.src)?;
    if file == view.file {
        return None;
    }
    Some(file.path(view.db).file_name()?.to_owned())
}

fn macro_hover(
    view: &FileView<'_>,
    range: TextRange,
    name: &str,
    site: Option<&MacroSite>,
) -> Option<String> {
    let mut out = match site.and_then(|site| define_text(view, site)) {
        Some(definition) => code(&definition),
        None if site.is_some() => format!("macro `{name}` (predefined or from the command line)"),
        None => format!("`{name}` is not a macro here"),
    };
    if let Some(expansion) = expansion(view, range) {
        out += &format!("\n\nexpands to\n\n{}", code(&expansion));
    }
    Some(out)
}

fn define_text(view: &FileView<'_>, site: &MacroSite) -> Option<String> {
    let file = view.db.file(camino::Utf8Path::new(site.file.as_ref()?.as_str()));
    let definition = define(view.db, file, site.ordinal)?;
    let text = file.text(view.db);
    let raw = &lexed(view.db, file).raw;
    let mut out = format!("#define {}", definition.name?.text);
    if let Some(params) = &definition.params {
        let mut names: Vec<&str> = params.names.iter().map(|name| name.text.as_str()).collect();
        if params.variadic {
            names.push("...");
        }
        out += &format!("({})", names.join(", "));
    }
    let mut blank = true;
    for i in definition.body.clone() {
        if raw.kind(i as usize).is_trivia() {
            blank = true;
        } else {
            if std::mem::take(&mut blank) {
                out.push(' ');
            }
            out += raw.text(text, i as usize);
        }
    }
    Some(out)
}

/// The expansion of the macro call that begins with a name.
pub(crate) fn expansion(view: &FileView<'_>, name: TextRange) -> Option<String> {
    let root = view.root();
    let token = root.token_at_offset(name.start()).right_biased()?;
    let call =
        token.parent_ancestors().find(|ancestor| ancestor.kind() == SyntaxKind::MACRO_CALL)?;
    if call.text_range().start() != name.start() {
        return None;
    }
    let mut out = String::new();
    for token in view.map().expansion(call.text_range()) {
        if !out.is_empty() && !token.glued {
            out.push(' ');
        }
        out += &token.text;
        if out.len() > 2_000 {
            out.push('…');
            break;
        }
    }
    Some(out)
}

fn code(text: &str) -> String {
    markdown::block("genom", text)
}

#[cfg(test)]
mod tests;
