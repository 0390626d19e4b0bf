//! `dotgen/diagram`, the picture in hovers, and the commands that return a picture as text.

mod system;

use std::cell::RefCell;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

use camino::Utf8PathBuf;
use dotgen_analysis::host::{Cancellable, UnitResult};
use dotgen_analysis::ide::{DocumentSymbol, FilePosition, SymbolKind};
use dotgen_diagram::system::Chain;
use dotgen_diagram::theme::Theme;
use dotgen_syntax::codes;
use dotgen_timing::scn::ast::CheckKind;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use self::system::WorkspaceSystem;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::pictures::{self, Form, Kind, PictureRequest, SystemContext};
use dotgen_views::verification::view::View;

/// Parameters of `dotgen/diagram`.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct DiagramParams {
    pub(crate) text_document: TextDocumentIdentifier,
    /// A place: the declaration around it is drawn, and takes precedence over the names in the wish.
    #[serde(default)]
    pub(crate) position: Option<Position>,
    /// Only if the place names a task, activity or state: its machine, with the state as the way.
    #[serde(default)]
    pub(crate) named: bool,
    /// The subject of the picture.
    #[serde(flatten)]
    pub(crate) wish: PictureRequest,
    /// Colours.
    #[serde(default = "editor_theme")]
    pub(crate) theme: Theme,
    /// Format of the picture.
    #[serde(default)]
    pub(crate) format: Form,
}

fn editor_theme() -> Theme {
    Theme::Editor
}

/// A request with the earlier answers.
pub(crate) struct Question {
    pub(crate) params: DiagramParams,
    pub(crate) last: Arc<LastGood>,
}

/// The last answers that were drawn from texts without syntax errors.
#[derive(Default)]
pub(crate) struct LastGood(Mutex<VecDeque<(String, Value)>>);

impl LastGood {
    /// Maximum number of stored pictures.
    const CAPACITY: usize = 64;

    fn get(&self, key: &str) -> Option<Value> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = all.iter().find(|entry| entry.0 == key);
        found.map(|(_, value)| value.clone())
    }

    fn set(&self, key: String, value: Value) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|entry| entry.0 != key);
        all.push_back((key, value));
        if all.len() > LastGood::CAPACITY {
            all.pop_front();
        }
    }
}

/// `dotgen/diagram`
pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    question: &Question,
) -> Cancellable<Option<Value>> {
    let params = &question.params;
    let mut wish = params.wish.clone();
    let symbols = snapshot.analysis.document_symbols(&subject.path)?;
    if let Some(position) = params.position
        && let Some(at) = snapshot.cursor(subject, position)?
    {
        around(&symbols, at.offset, &mut wish);
        if params.named && !named(snapshot, &at, &mut wish)? {
            return Ok(None);
        }
    }
    // A machine with another mark is the same machine.
    let machine = PictureRequest { way: Vec::new(), ..wish.clone() };
    let key = format!("{} {:?} {:?} {:?}", subject.path, machine, params.theme, params.format);
    let broken = syntax_error(snapshot, subject)?;
    if let Some(reason) = &broken
        && let Some(mut last) = question.last.get(&key)
    {
        last["stale"] = json!(reason);
        last["version"] = json!(subject.version);
        return Ok(Some(last));
    }
    let (units, around) = content(snapshot, subject, &wish)?;
    let drawn = pictures::draw(&units, &around, &wish);
    let Some(picture) = drawn.first() else {
        return Ok(None);
    };
    let (nodes, edges) = nodes_and_edges(snapshot, &units, picture);
    let declared = declared(&symbols, picture.component.as_deref(), picture.owner.as_deref());
    let place = match (declared, snapshot.lines(&subject.path)?) {
        (Some(symbol), Some(lines)) => json!({
            "uri": snapshot.uri(&subject.path),
            "range": lines.range(&symbol.range),
            "selectionRange": lines.range(&symbol.selection_range),
        }),
        _ => Value::Null,
    };
    let answer = json!({
        "kind": wish.kind,
        "place": place,
        "title": picture.graph.title,
        "component": picture.component,
        "owner": picture.owner,
        "way": wish.way,
        "notes": picture.graph.notes,
        "picture": picture.text(params.format, params.theme),
        "width": picture.layout.width,
        "height": picture.layout.height,
        "nodes": nodes,
        "edges": edges,
        "version": subject.version,
        "stale": Value::Null,
        "incomplete": broken,
    });
    if broken.is_none() {
        question.last.set(key, answer.clone());
    }
    Ok(Some(answer))
}

/// The nodes and edges of a picture, with their places.
fn nodes_and_edges(
    snapshot: &Snapshot,
    units: &[UnitResult],
    picture: &pictures::Picture,
) -> (Value, Value) {
    let outlines: RefCell<BTreeMap<Utf8PathBuf, Vec<DocumentSymbol>>> = RefCell::default();
    pictures::data(units, picture, &|location| {
        let uri = snapshot.uri(&location.path)?;
        let lines = snapshot.lines(&location.path).ok()??;
        // The whole codel, component or other declaration, if the outline of its document contains it.
        let mut outlines = outlines.borrow_mut();
        let outline = match outlines.entry(location.path.clone()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                new.insert(snapshot.analysis.document_symbols(&location.path).ok()?)
            }
        };
        let whole = whole(outline, location.range.start).unwrap_or(location.range.clone());
        Some(json!({
            "uri": uri,
            "range": lines.range(&whole),
            "selectionRange": lines.range(&location.range),
        }))
    })
}

/// The picture without the rest of the answer, for editors that show text.
pub(crate) fn text(
    snapshot: &Snapshot,
    subject: &Subject,
    question: &Question,
) -> Cancellable<Option<Value>> {
    let answer = handle(snapshot, subject, question)?;
    Ok(answer.map(|mut answer| answer["picture"].take()))
}

/// The units that a picture is drawn from, and the facts about them.
fn content(
    snapshot: &Snapshot,
    subject: &Subject,
    wish: &PictureRequest,
) -> Cancellable<(Vec<UnitResult>, SystemContext)> {
    if wish.kind != Kind::System {
        return Ok((vec![snapshot.analysis.unit(&subject.path)?], SystemContext::default()));
    }
    let system = WorkspaceSystem::new(snapshot, &subject.path)?;
    let chains = if wish.chains { chains(snapshot, &system) } else { Vec::new() };
    Ok((system.units, SystemContext { connections: system.connections, chains }))
}

/// The cause-effect chains in the scenarios of these specifications, with their results.
fn chains(snapshot: &Snapshot, system: &WorkspaceSystem) -> Vec<Chain> {
    let mut out: Vec<Chain> = Vec::new();
    for (scenario, entry) in &*snapshot.verification {
        let problem = entry.places();
        let of_system =
            |path: &Utf8PathBuf| system.units.iter().any(|unit| unit.files.contains(path));
        let mut used = problem.units.iter().filter_map(|unit| unit.files.first());
        if !used.any(of_system) {
            continue;
        }
        for check in problem.scenario.checks() {
            let CheckKind::Chain(_, path, _) = &check.kind else {
                continue;
            };
            let through = [&path.from].into_iter().chain(&path.via).chain([&path.to]);
            let ports = through.filter_map(|via| match &via.names[..] {
                [component, port] => {
                    Some((system.name(scenario, &component.value), port.value.clone()))
                }
                _ => None,
            });
            let says = match entry.known().and_then(|answer| said(answer.view(), &check.range)) {
                Some(answer) => answer,
                None => format!("{}: not known yet", path.text()),
            };
            let ports = ports.collect();
            out.push(Chain { ports, says });
        }
    }
    out
}

/// The answer to the check at a place: `age a.x -> b.y: ≤ 20 ms of 30 ms, proved`.
fn said(view: View, written: &std::ops::Range<usize>) -> Option<String> {
    let mut checks = view.checks.iter();
    let check = checks.find(|check| check.written.as_ref() == Some(written))?;
    let mut text = format!("{} {}", check.report.kind, check.report.of);
    if let Some(value) = &check.value {
        text += &format!(": {value}");
    }
    if let Some(limit) = &check.limit {
        text += &format!(" of {limit}");
    }
    Some(format!("{text}, {}", check.verdict.word()))
}

/// Sets the names in a wish to the declaration around an offset. Without a declaration there, the names are
/// unchanged.
fn around(symbols: &[DocumentSymbol], offset: usize, wish: &mut PictureRequest) {
    for symbol in symbols.iter().filter(|symbol| symbol.range.contains(&offset)) {
        match symbol.kind {
            SymbolKind::Component if wish.component.as_deref() != Some(&symbol.name) => {
                wish.component = Some(symbol.name.clone());
                wish.owner = None;
            }
            SymbolKind::Task | SymbolKind::Activity if wish.kind == Kind::Fsm => {
                let machine = symbol.children.iter().any(|child| child.kind == SymbolKind::Codel);
                if machine {
                    wish.owner = Some(symbol.name.clone());
                }
            }
            _ => {}
        }
        around(&symbol.children, offset, wish);
    }
}

/// The whole declaration whose name starts at an offset.
fn whole(symbols: &[DocumentSymbol], offset: usize) -> Option<std::ops::Range<usize>> {
    symbols.iter().find_map(|symbol| {
        if symbol.selection_range.start == offset {
            Some(symbol.range.clone())
        } else {
            whole(&symbol.children, offset)
        }
    })
}

/// The declaration, in the document, of a picture's component, task or activity.
fn declared<'s>(
    symbols: &'s [DocumentSymbol],
    component: Option<&str>,
    owner: Option<&str>,
) -> Option<&'s DocumentSymbol> {
    let component = symbols.iter().find(|symbol| {
        symbol.kind == SymbolKind::Component && Some(symbol.name.as_str()) == component
    })?;
    let Some(owner) = owner else {
        return Some(component);
    };
    component.children.iter().find(|child| {
        matches!(child.kind, SymbolKind::Task | SymbolKind::Activity | SymbolKind::Function)
            && child.name == owner
    })
}

/// The first syntax error, if there is one.
fn syntax_error(snapshot: &Snapshot, subject: &Subject) -> Cancellable<Option<String>> {
    let diagnostics = snapshot.analysis.diagnostics(&subject.path)?;
    let first = diagnostics
        .iter()
        .find(|diagnostic| codes::stage(diagnostic.code) == Some(codes::Stage::Parser));
    let Some(first) = first else {
        return Ok(None);
    };
    let lines = snapshot.lines(&subject.path)?;
    let line = lines.map_or(0, |line| line.position(first.range.start).line) + 1;
    Ok(Some(format!("line {line}: {}", first.message)))
}

/// Sets the names in a wish to the task, activity or state that is named at a place. Returns false if none
/// is.
fn named(snapshot: &Snapshot, at: &FilePosition, wish: &mut PictureRequest) -> Cancellable<bool> {
    let Some(targets) = snapshot.analysis.goto_definition(at)? else {
        return Ok(false);
    };
    for target in &targets.info {
        match target.kind {
            SymbolKind::State => wish.way = vec![target.name.to_string()],
            SymbolKind::Task | SymbolKind::Activity => wish.owner = Some(target.name.to_string()),
            _ => continue,
        }
        return Ok(wish.owner.is_some());
    }
    Ok(false)
}
