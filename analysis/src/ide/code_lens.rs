//! Lines above declarations: the state machine of tasks and activities, and the readers and writers of a port
//! or a member of the ids.
//!
//! The places of lenses are cheap; their targets are computed one by one when they become visible.

use std::ops::Range;

use dotgen_syntax::line_index::line_start;
use serde::{Deserialize, Serialize};
use smol_str::SmolStr;

use super::{AccessKind, FileRange, FileView, inlay_hints::is_machine, references::references};
use crate::{
    elab::{DefKind, Definition, Elaborated, Entity},
    model::{ComponentId, Owner, Param, ParamSource, PathElement, ServiceKind},
    source_map::bytes,
};

/// The lenses to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LensConfig {
    /// Results of verification, above tasks.
    pub verdicts: bool,
    /// State machines, above tasks and activities.
    pub machines: bool,
    /// Readers and writers, above ports and members of the ids.
    pub accesses: bool,
    /// The declaration of a codel, above its function.
    pub codels: bool,
}

impl LensConfig {
    /// All kinds, or none.
    pub fn all(shown: bool) -> LensConfig {
        LensConfig { verdicts: shown, machines: shown, accesses: shown, codels: shown }
    }
}

impl Default for LensConfig {
    fn default() -> LensConfig {
        LensConfig::all(true)
    }
}

/// The content of a lens.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", tag = "kind")]
pub enum LensKind {
    /// The readers and writers of the port or member of the ids at an offset.
    Accesses {
        /// Byte offset of the name.
        offset: usize,
    },
    /// The state machine of a task or activity.
    StateMachine {
        component: SmolStr,
        /// The task or activity.
        owner: SmolStr,
    },
}

/// A line above a declaration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodeLens {
    /// The name of the declaration.
    pub range: Range<usize>,
    /// The content.
    pub kind: LensKind,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LensText {
    /// The text.
    pub title: String,
    /// For accesses: their places.
    pub references: Vec<FileRange>,
    /// For accesses: all names, a line for each declaration.
    pub details: String,
}

/// Maximum number of lenses above a line. The details of the first have the others.
const MOST_IN_A_LINE: usize = 3;

/// Maximum number of declarations in the details of a lens.
const MOST_DETAILS: usize = 20;

/// Maximum number of characters of all lenses above a line: they fit beside the explorer of a window with a
/// width of 1000 pixels.
const LINE: usize = 90;

/// The lenses of a file, by place.
pub(crate) fn code_lenses(view: &FileView<'_>, config: &LensConfig) -> Vec<CodeLens> {
    let elaborated = view.elaborated();
    let mut out = Vec::new();
    for definition in &elaborated.definitions {
        use DefKind::*;
        if !matches!(definition.kind, Task | Activity | Port | IdsMember) {
            continue;
        }
        let Some(range) = written(view, definition) else {
            continue;
        };
        let kind = match definition.entity {
            Some(Entity::Task(component, task)) => {
                machine(elaborated, component, Owner::Task(task), &definition.name)
                    .filter(|_| config.machines)
            }
            Some(Entity::Service(component, service)) => {
                machine(elaborated, component, Owner::Service(service), &definition.name)
                    .filter(|_| config.machines)
            }
            // Unused declarations are reported as findings.
            _ => (config.accesses && !accesses(elaborated, definition).is_empty())
                .then_some(LensKind::Accesses { offset: range.start }),
        };
        out.extend(kind.map(|kind| CodeLens { range, kind }));
    }
    out.sort_by_key(|lens| lens.range.start);
    let (mut last, mut in_line) = (0, 0);
    out.retain(|lens| {
        let start = lens.range.start;
        if view.text()[last..start].contains('\n') {
            in_line = 0;
        }
        (last, in_line) = (start, in_line + 1);
        in_line <= MOST_IN_A_LINE
    });
    out
}

/// The name of a definition in the text of the file. `None` for a name that comes out of a macro: it has no
/// line of its own.
fn written(view: &FileView<'_>, definition: &Definition) -> Option<Range<usize>> {
    let (file, place) = view.place(definition.src)?;
    let range = bytes(place);
    let is_here = file == view.file && view.text().get(range.clone()) == Some(&definition.name);
    is_here.then_some(range)
}

/// The line of an offset.
fn line(view: &FileView<'_>, offset: usize) -> Range<usize> {
    let text = view.text();
    let start = line_start(text, offset);
    start..text[offset..].find('\n').map_or(text.len(), |at| offset + at)
}

fn machine(
    elaborated: &Elaborated,
    component: ComponentId,
    owner: Owner,
    name: &str,
) -> Option<LensKind> {
    let component = elaborated.spec.components.get(component)?;
    is_machine(component, owner)
        .then(|| LensKind::StateMachine { component: component.name.clone(), owner: name.into() })
}

/// Tasks and services by their access to a port or a member of the ids.
#[derive(Debug, Default)]
struct Accesses {
    written: Vec<SmolStr>,
    read: Vec<SmolStr>,
}

impl Accesses {
    fn is_empty(&self) -> bool {
        self.written.is_empty() && self.read.is_empty()
    }

    fn add(&mut self, name: &SmolStr, writes: bool, reads: bool) {
        for (all, does) in [(&mut self.written, writes), (&mut self.read, reads)] {
            if does && !all.contains(name) {
                all.push(name.clone());
            }
        }
    }

    /// `written by a, b · read by c`
    fn text(&self) -> String {
        let part = |word: &str, all: &[SmolStr]| {
            (!all.is_empty()).then(|| format!("{word} {}", all.join(", ")))
        };
        let parts = [part("written by", &self.written), part("read by", &self.read)];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" · ")
    }

    /// The text, or numbers if it has more characters: `2 writers · 1 reader`.
    fn short(&self, most: usize) -> String {
        let text = self.text();
        if text.chars().count() <= most {
            return text;
        }
        let part = |word: &str, number: usize| {
            let plural = if number == 1 { "" } else { "s" };
            (number > 0).then(|| format!("{number} {word}{plural}"))
        };
        let parts = [part("writer", self.written.len()), part("reader", self.read.len())];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" · ")
    }
}

/// The users of a port or a member of the ids, in the component that declares it.
fn accesses(elaborated: &Elaborated, definition: &Definition) -> Accesses {
    let mut out = Accesses::default();
    let component = match definition.entity {
        Some(Entity::Port(component, _)) => Some(component),
        _ => home(elaborated, definition),
    };
    let component = component.and_then(|component| elaborated.spec.components.get(component));
    let Some(component) = component else {
        return out;
    };
    let concerns = |param: &Param| match (&param.source, definition.entity) {
        (ParamSource::Port(port), Some(Entity::Port(_, own))) => *port == own,
        // A path without a member is the whole ids.
        (ParamSource::Ids, None) => match param.path.first() {
            Some(PathElement::Member(name)) => *name == definition.name,
            _ => true,
        },
        _ => false,
    };
    for at in component.all_codels() {
        let name = component.owner_name(at.owner);
        for param in component.codel(at).params.iter().filter(|param| concerns(param)) {
            let (reads, writes) = param.dir.flow();
            out.add(name, writes, reads);
        }
    }
    // A client sends the inputs of an attribute and receives its outputs.
    let services = component.services.iter();
    for service in services.filter(|service| service.kind == ServiceKind::Attribute) {
        for param in service.params.iter().filter(|param| concerns(param)) {
            let (given, returned) = param.dir.flow();
            out.add(&service.name, given, returned);
        }
    }
    out
}

/// The component around a definition.
fn home(elaborated: &Elaborated, definition: &Definition) -> Option<ComponentId> {
    elaborated.containers(definition).find_map(|around| match around.entity {
        Some(Entity::Component(component)) => Some(component),
        _ => None,
    })
}

/// The text of a lens of a file; `None` if its declaration no longer exists.
pub(crate) fn resolve(view: &FileView<'_>, kind: &LensKind) -> Option<LensText> {
    match kind {
        LensKind::Accesses { offset } => {
            let shown = accesses_in_line(view, *offset);
            let at = shown.iter().position(|entry| entry.0 == *offset)?;
            let mut found = references(view, *offset, true)?;
            found.retain(|reference| reference.access != AccessKind::Declaration);
            let (_, name, own) = &shown[at];
            let most = LINE / shown.len().min(MOST_IN_A_LINE);
            let title = if shown.len() > 1 {
                format!("{name}: {}", own.short(most.saturating_sub(name.len() + 2)))
            } else {
                own.short(most)
            };
            let told = if at == 0 { &shown[..] } else { &shown[at..=at] };
            let details = told.iter().map(|(_, name, all)| format!("{name}: {}", all.text()));
            Some(LensText {
                title,
                references: found.into_iter().map(|reference| reference.place).collect(),
                details: details.collect::<Vec<_>>().join("\n"),
            })
        }
        LensKind::StateMachine { .. } => Some(LensText {
            title: "state machine".to_owned(),
            references: Vec::new(),
            details: String::new(),
        }),
    }
}

/// The ports and members of the ids with users that are declared in the line of an offset, by place. Of a
/// long line, only the first ones.
fn accesses_in_line<'v>(
    view: &'v FileView<'_>,
    offset: usize,
) -> Vec<(usize, &'v SmolStr, Accesses)> {
    let elaborated = view.elaborated();
    let line = line(view, offset);
    let declared = elaborated
        .definitions
        .iter()
        .filter(|definition| matches!(definition.kind, DefKind::Port | DefKind::IdsMember));
    let here =
        declared.filter_map(|definition| Some((written(view, definition)?.start, definition)));
    let mut here: Vec<_> = here.filter(|entry| line.contains(&entry.0)).collect();
    here.sort_by_key(|entry| entry.0);
    let all = here
        .into_iter()
        .map(|(at, definition)| (at, &definition.name, accesses(elaborated, definition)));
    all.filter(|entry| !entry.2.is_empty()).take(MOST_DETAILS).collect()
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;
    use expect_test::expect;

    use super::{Accesses, LensConfig};
    use crate::test_support::Fixture;

    #[test]
    fn a_lens_that_is_long_has_numbers() {
        let name = |name: &&str| smol_str::SmolStr::from(*name);
        let accesses = Accesses {
            written: ["calibrate", "restart"].iter().map(name).collect(),
            read: vec!["supervise".into()],
        };
        assert_eq!(accesses.short(50), "written by calibrate, restart · read by supervise");
        assert_eq!(accesses.short(48), "2 writers · 1 reader");
    }

    #[test]
    fn lenses_and_what_they_say() {
        let fixture = Fixture::new(
            "struct s { long x; };
typedef s u;
component c {
  port in s p;
  port out s idle;
  ids {
    long speed; long unused;
    long c1, c2, c3, c4;
  };
  attribute set(in speed);
  attribute all_of_them(in c1, in c2, in c3, in c4);
  task t { period 10 ms; codel<start> f(port in p, in speed) wcet 1 ms yield pause::start; };
  function g() { interrupt g; };
  activity a() { task t; codel<start> h() yield ether; };
};
",
        );
        let path = Utf8Path::new("/main.gen");
        let analysis = fixture.analysis();
        let text = fixture.text("/main.gen");
        let mut out = String::new();
        for lens in analysis.code_lenses(path, &LensConfig::all(true)).unwrap() {
            let shown = analysis.resolve_lens(path, &lens.kind).unwrap().unwrap();
            out += &format!("{}: {} [{}]\n", &text[lens.range], shown.title, shown.details);
        }
        expect![[r"
            p: read by t [p: read by t]
            speed: written by set · read by t [speed: written by set · read by t]
            c1: c1: written by all_of_them [c1: written by all_of_them
            c2: written by all_of_them
            c3: written by all_of_them
            c4: written by all_of_them]
            c2: c2: written by all_of_them [c2: written by all_of_them]
            c3: c3: written by all_of_them [c3: written by all_of_them]
            t: state machine []
            a: state machine []
        "]]
        .assert_eq(&out);
    }
}
