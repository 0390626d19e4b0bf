//! Random edits of specifications, as people make them, whose codels compile after one `sync`, or whose lines
//! that do not are named.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model::{Component, ComponentKind, Src, TypeKind};
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::command::{Project, SyncOptions, SyncReport, headers, sync};
use dotgen_codegen::codels::files::{FilesConfig, Sources};
use dotgen_codegen::codels::folder::folders;
use dotgen_codegen::codels::stub::StubOptions;
use dotgen_codegen::lang::Language;

use crate::codels::project::{Overlay, codels, examples, host_over, published};
use crate::codels::support::{compile, compiler, temporary, write};

/// Kinds of edits.
const KINDS: [&str; 6] =
    ["direction", "parameter added", "parameter removed", "yield", "throw", "name of a codel"];

/// A component that is edited.
struct Subject {
    root: Utf8PathBuf,
    includes: Vec<Utf8PathBuf>,
    files: Overlay,
    text: String,
}

impl Subject {
    /// The text after a random edit of a kind; nothing if the choice does not fit.
    fn edited(&self, kind: &str, random: &mut fastrand::Rng) -> Option<String> {
        let host = host_over(Arc::new(self.files.clone()), self.includes.clone());
        let analysis = host.analysis();
        let unit = analysis.root_unit(&self.root).expect("not cancelled");
        let mut components = unit.spec.components.iter();
        let component = components.find(|component| {
            let place = unit.locations.locate(component.src);
            component.kind == ComponentKind::Component
                && place.is_some_and(|place| place.path == self.root)
        })?;
        let edit = Edit { subject: self, unit: &unit, component };
        match kind {
            "direction" => edit.direction(random),
            "parameter added" => edit.parameter_added(random),
            "parameter removed" => edit.parameter_removed(random),
            "yield" => edit.listed("yield", &edit.states(), random),
            "throw" => edit.listed("throw", &edit.exceptions(), random),
            _ => {
                let codel = edit.codel(random)?;
                Some(self.with(codel.end..codel.end, "2"))
            }
        }
    }

    fn with(&self, range: std::ops::Range<usize>, text: &str) -> String {
        format!("{}{text}{}", &self.text[..range.start], &self.text[range.end..])
    }
}

/// What an edit is made from.
struct Edit<'a> {
    subject: &'a Subject,
    unit: &'a UnitResult,
    component: &'a Component,
}

impl Edit<'_> {
    fn text(&self) -> &str {
        &self.subject.text
    }

    /// Where something stands in the specification, if it is its name that stands there.
    fn place(&self, src: Src, name: &str) -> Option<std::ops::Range<usize>> {
        let place = self.unit.locations.locate(src)?;
        let here =
            place.path == self.subject.root && self.text().get(place.range.clone()) == Some(name);
        here.then_some(place.range)
    }

    fn codel(&self, random: &mut fastrand::Rng) -> Option<std::ops::Range<usize>> {
        let all: Vec<_> = self.component.all_codels().collect();
        let codel = self.component.codel(*all.get(random.usize(..all.len().max(1)))?);
        self.place(codel.src, &codel.name)
    }

    /// The list of parameters of a random codel, without its parentheses.
    fn parameters(&self, random: &mut fastrand::Rng) -> Option<std::ops::Range<usize>> {
        let codel = self.codel(random)?;
        let rest = &self.text()[codel.end..];
        let open = rest.find('(').filter(|open| rest[..*open].trim().is_empty())?;
        let close = rest.find(')')?;
        Some(codel.end + open + 1..codel.end + close)
    }

    fn direction(&self, random: &mut fastrand::Rng) -> Option<String> {
        let list = self.parameters(random)?;
        let words: Vec<_> = ["in", "out", "inout"]
            .iter()
            .flat_map(|word| {
                let found = self.text()[list.clone()]
                    .match_indices(&format!("{word} "))
                    .collect::<Vec<_>>();
                found.into_iter().map(|(at, _)| (list.start + at, *word)).collect::<Vec<_>>()
            })
            .filter(|(at, _)| !self.text()[..*at].ends_with(char::is_alphanumeric))
            .collect();
        let &(at, word) = words.get(random.usize(..words.len().max(1)))?;
        let others: Vec<&str> =
            ["in", "out", "inout"].into_iter().filter(|name| *name != word).collect();
        Some(self.subject.with(at..at + word.len(), others[random.usize(..2)]))
    }

    fn parameter_added(&self, random: &mut fastrand::Rng) -> Option<String> {
        let list = self.parameters(random)?;
        let TypeKind::Struct { members } = &self.unit.spec.ty(self.component.ids?).kind else {
            return None;
        };
        let member = members.get(random.usize(..members.len().max(1)))?;
        let name = self.unit.spec.ty(*member).name.clone()?;
        let direction = ["in", "out", "inout"][random.usize(..3)];
        let old = self.text()[list.clone()].trim();
        Some(match (old.is_empty(), random.usize(..2)) {
            (true, _) => self.subject.with(list, &format!("ids {direction} {name}")),
            (false, 0) => {
                self.subject.with(list.start..list.start, &format!("ids {direction} {name}, "))
            }
            (false, _) => {
                self.subject.with(list.end..list.end, &format!(", ids {direction} {name}"))
            }
        })
    }

    fn parameter_removed(&self, random: &mut fastrand::Rng) -> Option<String> {
        let list = self.parameters(random)?;
        let all: Vec<&str> = self.text()[list.clone()].split(',').collect();
        let gone = random.usize(..all.len().max(1));
        let left: Vec<&str> =
            (0..).zip(&all).filter(|(at, _)| *at != gone).map(|(_, one)| *one).collect();
        Some(self.subject.with(list, left.join(",").trim_start()))
    }

    fn states(&self) -> Vec<String> {
        let codels = self.component.all_codels().map(|codel| self.component.codel(codel));
        let names =
            codels.flat_map(|codel| &codel.triggers).map(|trigger| trigger.name.to_string());
        let mut out: BTreeSet<String> = names.collect();
        out.insert("ether".to_owned());
        out.into_iter().collect()
    }

    fn exceptions(&self) -> Vec<String> {
        let types = self.unit.spec.types.iter();
        let own = types.filter(|ty| matches!(ty.kind, TypeKind::Exception { .. }));
        let names = own.filter_map(|ty| {
            let name = ty.name.as_ref()?;
            self.place(ty.src, name).map(|_| name.to_string())
        });
        names.collect()
    }

    /// One more, or one less, in a list behind a keyword.
    fn listed(
        &self,
        keyword: &str,
        names: &[String],
        random: &mut fastrand::Rng,
    ) -> Option<String> {
        let text = self.text();
        let all: Vec<usize> = text
            .match_indices(keyword)
            .map(|(at, _)| at)
            .filter(|at| {
                !text[..*at]
                    .ends_with(|character: char| character.is_alphanumeric() || character == '_')
            })
            .collect();
        let at = *all.get(random.usize(..all.len().max(1)))? + keyword.len();
        let plural = usize::from(text[at..].starts_with('s'));
        let list = at + plural..at + text[at..].find(';')?;
        let items: Vec<&str> = text[list.clone()].split(',').collect();
        if random.usize(..2) == 0 {
            let name = names.get(random.usize(..names.len().max(1)))?;
            return Some(self.subject.with(list.start..list.start, &format!(" {name},")));
        }
        if items.len() < 2 {
            return None;
        }
        let gone = random.usize(..items.len().max(1));
        let left: Vec<&str> =
            (0..).zip(&items).filter(|(at, _)| *at != gone).map(|(_, one)| *one).collect();
        Some(self.subject.with(list, &format!(" {}", left.join(",").trim_start())))
    }
}

/// The components that have codels, which the test writes.
fn subjects() -> Vec<Subject> {
    let mut all = Vec::new();
    for (root, includes) in examples().into_iter().chain(published()) {
        let mut files = Overlay::default();
        let host = host_over(Arc::new(files.clone()), includes.clone());
        let unit = host.analysis().root_unit(&root).expect("not cancelled");
        let found =
            folders(&unit, &mut |path| Sources::load(path, &FilesConfig::default(), &files));
        let mut texts = BTreeMap::new();
        for folder in found {
            let own = folder.specification == root && folder.sources.sources.is_empty();
            for expected in folder.expected().iter().filter(|_| own) {
                let written = codels(expected).into_iter();
                texts.extend(written.map(|(path, text)| (folder.sources.folder.join(path), text)));
            }
        }
        if !texts.is_empty() {
            files.texts.extend(texts);
            let text = std::fs::read_to_string(&root).expect("a specification");
            all.push(Subject { root, includes, files, text });
        }
    }
    all
}

#[test]
fn random_edits_compile_after_one_sync() {
    let count = dotgen_loaders::times(20) as usize;
    let all = subjects();
    assert!(all.len() > 5, "{} components", all.len());
    let mut random = fastrand::Rng::with_seed(0x2545_f491_4f6c_dd1d);
    let mut done: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    let (mut tried, mut bad) = (0, Vec::new());
    for _ in 0..400 * count {
        let sum: usize = done.values().map(|done| done[0]).sum();
        if sum == count {
            break;
        }
        let kind = KINDS[sum % KINDS.len()];
        let subject = &all[random.usize(..all.len().max(1))];
        let Some(text) = subject.edited(kind, &mut random) else {
            continue;
        };
        let mut files = subject.files.clone();
        files.texts.insert(subject.root.clone(), text);
        let files = Arc::new(files);
        let mut host = host_over(files.clone(), subject.includes.clone());
        let unit = host.analysis().root_unit(&subject.root);
        if !unit.expect("not cancelled").accepted() {
            continue;
        }
        tried += 1;
        let numbers = done.entry(kind).or_default();
        numbers[0] += 1;
        let stubs = StubOptions { use_parameters: true, ..StubOptions::default() };
        let mut project = Project::new(&mut host, &*files, FilesConfig::default(), stubs);
        let roots = std::slice::from_ref(&subject.root);
        let report = sync(&mut project, roots, &SyncOptions::default());
        let again = sync(&mut project, roots, &SyncOptions::default());
        let what = || format!("{kind} in {}: {:?}", subject.root, report.applied);
        if !again.applied.is_empty() {
            bad.push(format!("{}: a second run does {:?}", what(), again.applied));
        }
        let said = broken(&mut project, &subject.root, &files);
        if said.is_empty() {
            numbers[1] += 1;
        } else {
            let named = named(&report);
            let unnamed: Vec<_> = said.iter().filter(|(place, _)| !named.contains(place)).collect();
            if unnamed.is_empty() {
                numbers[2] += 1;
            } else {
                bad.push(format!("{}: {unnamed:?} not among {named:?}", what()));
            }
        }
    }
    println!("edits, all sources compile, the lines that do not are named");
    for (kind, [edits, compile, named]) in &done {
        println!("{kind}: {edits}, {compile}, {named}");
    }
    assert_eq!(tried, count);
    assert!(bad.is_empty(), "{} of {tried}:\n{}", bad.len(), bad[..bad.len().min(8)].join("\n"));
}

/// Files, without their folders, with the lines that `sync` names.
fn named(report: &SyncReport) -> BTreeSet<(String, usize)> {
    let name = |path: &Utf8Path| path.file_name().unwrap_or_default().to_owned();
    let notes = report.notes.iter().map(|note| (name(&note.path), note.line));
    let left = report.left.findings.iter().filter_map(|finding| finding.at.as_ref());
    notes.chain(left.map(|finding| (name(&finding.path), finding.line))).collect()
}

/// What a compiler says against the sources: file, line and text of each error.
fn broken(
    project: &mut Project<'_>,
    root: &Utf8Path,
    files: &Overlay,
) -> Vec<((String, usize), String)> {
    let mut out = Vec::new();
    let found = project.folders(&[root.to_owned()], &mut Vec::new());
    for folder in found.iter().filter(|folder| folder.specification == root) {
        for expected in folder.expected() {
            let command = match expected.language {
                Language::Cxx => compiler("c++"),
                _ => compiler("cc"),
            };
            let Some(command) = command else { continue };
            let (_guard, temporary) = temporary();
            let written = headers(project, root, &temporary, &[]).expect("headers");
            write(&temporary, &written);
            let sources = files.texts.keys().filter(|key| key.starts_with(&folder.sources.folder));
            for path in sources {
                let copy = temporary.join(path.file_name().unwrap_or_default());
                let text = project.text(path).unwrap_or_default();
                std::fs::write(&copy, &*text).expect("a temporary file");
                // An undeclared name is told at every use, and what follows from an error is not another one.
                let flags = ["-Wno-error", "-w", "-fmax-errors=1"];
                if let Err(why) = compile(command, &temporary, &copy, &flags) {
                    out.push((place(&why), why));
                }
            }
        }
    }
    out
}

/// File and line of the first error of a compiler.
fn place(said: &str) -> (String, usize) {
    let error = said.lines().find(|line| line.contains(": error: ")).unwrap_or_default();
    let mut parts = error.split(':');
    let file = Utf8Path::new(parts.next().unwrap_or_default()).file_name();
    let line = parts.next().and_then(|part| part.parse().ok());
    (file.unwrap_or_default().to_owned(), line.unwrap_or_default())
}
