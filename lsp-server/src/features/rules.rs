//! Names of specifications in the rules of `dotgen.toml` (`[ros2.messages.COMPONENT.PORT]`), for renames.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::{Cancellable, UnitResult};
use dotgen_analysis::model::{ComponentKind, Spec, Src, TypeId, TypeKind};
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::rename::{UnchangedPlace, UnchangedReason};
use dotgen_platform::files::vfs;
use dotgen_timing::scn;
use dotgen_views::verification::problem;
use toml_parser::Source;
use toml_parser::parser::{Event, EventKind, parse_document};

use crate::config;
use crate::features::mentions;
use crate::workspace::snapshot::Snapshot;

/// Maximum nesting of types that is followed.
const MAX_DEPTH: usize = 16;

/// The changes of rules for a rename.
#[derive(Debug, Default)]
pub(crate) struct RuleRenames {
    pub(crate) edits: Vec<FileEdit>,
    /// Places that the user has to check.
    pub(crate) left: Vec<UnchangedPlace>,
}

/// The changes of rules for a rename whose edits of specifications are `edits`.
pub(crate) fn renames(
    snapshot: &Snapshot,
    edits: &[FileEdit],
    new_name: &str,
) -> Cancellable<RuleRenames> {
    let mut roots: BTreeSet<Utf8PathBuf> = BTreeSet::new();
    for path in edits.iter().map(|edit| &edit.path).collect::<BTreeSet<_>>() {
        roots.extend(snapshot.analysis.roots_containing(path)?);
    }
    // The rules of a directory are for all specifications below it.
    let mut files: BTreeMap<Utf8PathBuf, Vec<Utf8PathBuf>> = BTreeMap::new();
    for root in roots {
        let directories = root.ancestors().skip(1);
        let configs = directories.map(|directory| directory.join(config::FILE_NAME));
        for file in configs.filter(|file| file.is_file()) {
            files.entry(file).or_default().push(root.clone());
        }
    }
    let mut out = RuleRenames::default();
    for (file, roots) in files {
        let Some(text) = snapshot.analysis.text(&file)? else { continue };
        let is_rule = |word: &Word| word.path.iter().take(RULES.len()).eq(RULES);
        let words: Vec<Word> = words(&text).into_iter().filter(|word| is_rule(word)).collect();
        if words.is_empty() {
            continue;
        }
        let is_ours = snapshot.folders.is_empty()
            || snapshot.in_workspace(&file)
            || snapshot.open.contains_key(&file);
        let mut found = Found::default();
        for root in roots {
            let unit = snapshot.analysis.root_unit(&root)?;
            Renamed { unit: &unit, edits }.mentions(&text, &words, &mut found);
        }
        let (renamed, left) = if is_ours {
            (found.renamed, found.left)
        } else {
            (BTreeSet::new(), found.renamed.into_iter().chain(found.left).collect())
        };
        out.edits.extend(renamed.into_iter().map(|(start, end)| FileEdit {
            path: file.clone(),
            range: start..end,
            new_text: new_name.to_owned(),
        }));
        out.left.extend(left.into_iter().map(|(start, end)| UnchangedPlace {
            path: file.clone(),
            line: 1 + text[..start].matches('\n').count(),
            name: text[start..end].into(),
            why: UnchangedReason::Rule,
        }));
    }
    Ok(out)
}

/// The tables above the rules.
const RULES: [&str; 2] = ["ros2", "messages"];

/// A key or value of a file.
#[derive(Debug, PartialEq, Eq)]
struct Word {
    /// The keys that lead to it. The last key of a key is the key itself.
    path: Vec<String>,
    is_key: bool,
    /// The range without quotes.
    range: Range<usize>,
}

/// All keys and values, in order. Each mention of a table is a key.
fn words(text: &str) -> Vec<Word> {
    let source = Source::new(text);
    let tokens: Vec<_> = source.lex().collect();
    let mut events: Vec<Event> = Vec::new();
    parse_document(&tokens, &mut events, &mut ());
    let mut words = Vec::new();
    let (mut tables, mut key) = (vec![Vec::new()], Vec::new());
    let mut is_header = false;
    let mut after_point = false;
    for event in events {
        let (start, end) = (event.span().start(), event.span().end());
        let spelled = text.get(start..end).unwrap_or_default();
        let is_quoted = spelled.len() > 1 && spelled.starts_with(['"', '\'']);
        let range = if is_quoted { start + 1..end - 1 } else { start..end };
        match event.kind() {
            EventKind::StdTableOpen | EventKind::ArrayTableOpen => {
                is_header = true;
                (tables, key) = (vec![Vec::new()], Vec::new());
            }
            EventKind::StdTableClose | EventKind::ArrayTableClose => {
                is_header = false;
                tables = vec![std::mem::take(&mut key)];
            }
            EventKind::SimpleKey => {
                if !(std::mem::take(&mut after_point) || is_header && key.is_empty()) {
                    key = tables.last().cloned().unwrap_or_default();
                }
                key.push(text[range.clone()].to_owned());
                words.push(Word { path: key.clone(), is_key: true, range });
            }
            EventKind::KeySep => after_point = true,
            EventKind::InlineTableOpen => tables.push(key.clone()),
            EventKind::InlineTableClose => _ = tables.pop(),
            EventKind::Scalar => words.push(Word { path: key.clone(), is_key: false, range }),
            _ => {}
        }
    }
    words
}

#[derive(Default)]
struct Found {
    /// Ranges with the old name.
    renamed: BTreeSet<(usize, usize)>,
    /// Values that take members by name, and lose the renamed one.
    left: BTreeSet<(usize, usize)>,
}

/// A unit, and the edits of its files that rename a declaration.
struct Renamed<'a> {
    unit: &'a UnitResult,
    edits: &'a [FileEdit],
}

impl Renamed<'_> {
    fn has(&self, src: Src) -> bool {
        let place = self.unit.locations.locate(src);
        place.is_some_and(|place| {
            let mut edits = self.edits.iter();
            edits.any(|edit| edit.path == place.path && edit.range == place.range)
        })
    }

    fn mentions(&self, text: &str, words: &[Word], found: &mut Found) {
        let spec = &*self.unit.spec;
        let components = spec.components.iter();
        for component in components.filter(|one| one.kind == ComponentKind::Component) {
            let of_component =
                |word: &&Word| word.path.get(2).is_some_and(|key| *key == *component.name);
            for word in words.iter().filter(of_component) {
                if word.is_key && word.path.len() == 3 && self.has(component.src) {
                    found.renamed.insert((word.range.start, word.range.end));
                }
                let port = word.path.get(3);
                let port =
                    port.and_then(|key| component.ports.iter().find(|port| *port.name == **key));
                let Some(port) = port else { continue };
                if word.is_key && word.path.len() == 4 && self.has(port.src) {
                    found.renamed.insert((word.range.start, word.range.end));
                }
                let is_member = word.path.get(4).is_some_and(|key| key == "fields");
                if is_member && !word.is_key {
                    self.members(spec, port.data, text, &word.range, found);
                }
            }
        }
    }

    /// Finds the renamed members in a value such as `pos.q[2].x`.
    fn members(
        &self,
        spec: &Spec,
        mut ty: TypeId,
        text: &str,
        range: &Range<usize>,
        found: &mut Found,
    ) {
        let mut start = range.start;
        for step in text[range.clone()].split('.') {
            let name = step.split('[').next().unwrap_or(step);
            let Some(member) = member(spec, ty, name) else { return };
            if self.has(spec.ty(member).src) {
                found.renamed.insert((start, start + name.len()));
            }
            start += step.len() + 1;
            ty = member;
        }
        if self.contains(spec, ty, MAX_DEPTH) {
            found.left.insert((range.start, range.end));
        }
    }

    /// True if a member of a type, or of one of its parts, is renamed.
    fn contains(&self, spec: &Spec, ty: TypeId, depth: usize) -> bool {
        let members = members(spec, ty).iter();
        let mut members = members.take_while(|_| depth > 0);
        members
            .any(|member| self.has(spec.ty(*member).src) || self.contains(spec, *member, depth - 1))
    }
}

/// The members of a type, or of its elements.
fn members(spec: &Spec, ty: TypeId) -> &[TypeId] {
    let mut ty = spec.resolve_alias(ty);
    for _ in 0..MAX_DEPTH {
        ty = match &spec.ty(ty).kind {
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => spec.resolve_alias(*element),
            TypeKind::ForwardStruct { definition: Some(definition) } => *definition,
            TypeKind::Struct { members } => return members,
            _ => break,
        };
    }
    &[]
}

fn member(spec: &Spec, ty: TypeId, name: &str) -> Option<TypeId> {
    let mut members = members(spec, ty).iter().copied();
    members.find(|member| spec.ty(*member).name.as_deref() == Some(name))
}

/// The edits of `use` in scenarios for moved files or folders: pairs of old and new path.
pub(crate) fn uses_moved(
    snapshot: &Snapshot,
    moves: &[(Utf8PathBuf, Utf8PathBuf)],
) -> Cancellable<Vec<FileEdit>> {
    let moved = |path: &Utf8Path| -> Option<Utf8PathBuf> {
        moves.iter().find_map(|(from, to)| {
            let rest = path.strip_prefix(from).ok()?;
            Some(if rest.as_str().is_empty() { to.clone() } else { to.join(rest) })
        })
    };
    let mut edits = Vec::new();
    for (path, text) in mentions::texts(snapshot)? {
        for used in problem::used(&scn::parse(&text).scenario, &path) {
            let (new_path, new_used) = (moved(&path), moved(&used.path));
            if new_path.is_none() && new_used.is_none() {
                continue;
            }
            let folder = new_path.as_deref().unwrap_or(&path).parent().unwrap_or(&path).to_owned();
            let target = new_used.as_deref().unwrap_or(&used.path);
            // The range has quotes.
            let range = used.range.start + 1..used.range.end - 1;
            if vfs::normalize(&folder.join(&text[range.clone()])) != *target {
                let name = relative(&folder, target);
                edits.push(FileEdit { path: path.clone(), range, new_text: name.into_string() });
            }
        }
    }
    Ok(edits)
}

fn relative(folder: &Utf8Path, file: &Utf8Path) -> Utf8PathBuf {
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(common).map(|_| "..");
    let down = file.components().skip(common).map(|part| part.as_str());
    up.chain(down).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mention_of_a_table_is_a_key() {
        let text = "[ros2.messages.pom.\"frame\"]\ntype = \"x\"\nfields = { a.b = 'pos.x', c = \"y\" }\n\
                    [ros2.messages.pom.other.fields]\nd = \"z\"\n[ros2]\nmessages.pom.third.type = \"t\"\n";
        let words = words(text);
        let found = |path: &str, is_key: bool| -> Vec<&str> {
            let words =
                words.iter().filter(|word| word.path.join(".") == path && word.is_key == is_key);
            words.map(|word| &text[word.range.clone()]).collect()
        };
        assert_eq!(found("ros2.messages.pom", true), ["pom", "pom", "pom"]);
        assert_eq!(found("ros2.messages.pom.frame", true), ["frame"]);
        assert_eq!(found("ros2.messages.pom.frame.fields.a.b", false), ["pos.x"]);
        assert_eq!(found("ros2.messages.pom.frame.fields.c", false), ["y"]);
        assert_eq!(found("ros2.messages.pom.other.fields.d", false), ["z"]);
        assert_eq!(found("ros2.messages.pom.third.type", false), ["t"]);
    }

    #[test]
    fn paths_are_relative_to_the_folder_of_the_scenario() {
        let of = |folder: &str, file: &str| relative(folder.into(), file.into()).into_string();
        assert_eq!(of("/a/b", "/a/b/c.gen"), "c.gen");
        assert_eq!(of("/a/b", "/a/c/d.gen"), "../c/d.gen");
    }
}
