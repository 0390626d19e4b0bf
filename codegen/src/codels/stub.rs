//! Stubs: prototype, comment, and a body that returns an allowed event.
//!
//! Layout, comments and file names are those of the `skeleton` template of the release of GenoM3 in use, so
//! that its merge mode makes no changes.

use camino::Utf8PathBuf;
use dotgen_analysis::model::{CodelKind, CodelRef, Owner, Param, ServiceId, State, TaskId};
use dotgen_analysis::release::Change;
use rustc_hash::FxHashMap;

use super::expected::{Expected, owner_words};
use crate::lang::{LangError, Language, text};

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StubOptions {
    /// Adds `(void)x;` for every parameter, so that the stub compiles without warnings. The reference
    /// skeleton does not.
    pub use_parameters: bool,
    /// Compiles C codels as C++: the files end in `.cc` (`skeleton -l c++`).
    pub compile_as_cxx: bool,
    /// Text of the comment at the head of new files.
    pub notice: Option<String>,
    /// Indentation of bodies; that of the skeleton if `None`.
    pub indentation: Option<String>,
}

/// A file that does not exist yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewFile {
    /// Relative to the folder of the `.gen`.
    pub path: Utf8PathBuf,
    pub text: String,
}

/// Writes stubs for one component.
pub struct Stubs<'a> {
    expected: &'a Expected<'a>,
    options: &'a StubOptions,
}

/// The subject of the heading of a group of stubs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Group {
    Task(TaskId),
    Validation(ServiceId),
    Service(ServiceId),
}

impl<'a> Stubs<'a> {
    /// Stubs for a component.
    pub fn new(expected: &'a Expected<'a>, options: &'a StubOptions) -> Stubs<'a> {
        Stubs { expected, options }
    }

    /// The file of a codel: the file of its task, or of the control task.
    pub fn file_of(&self, at: CodelRef) -> Utf8PathBuf {
        let component = self.expected.component();
        let task = match at.owner {
            Owner::Task(task) => Some(task),
            // Services without a task belong to the control task, whatever their codels.
            Owner::Service(service) => {
                let validation = component.codel(at).kind == CodelKind::Validate;
                component.services[service].task.filter(|_| !validation)
            }
        };
        self.file(task)
    }

    fn file(&self, task: Option<TaskId>) -> Utf8PathBuf {
        let component = self.expected.component();
        let cxx = self.options.compile_as_cxx || self.expected.language == Language::Cxx;
        let extension = if cxx { "cc" } else { "c" };
        let task = match task {
            Some(task) => format!("{}_", component.tasks[task].name),
            None => String::new(),
        };
        format!("codels/{}_{task}codels.{extension}", component.name).into()
    }

    /// Every file of the component with all its stubs: one for each task, then that of the control
    /// task.
    pub fn all_files(&self) -> Result<Vec<NewFile>, LangError> {
        // A function is written once, even if several files would contain it.
        let mut written = FxHashMap::default();
        let component = self.expected.component();
        let tasks = component.tasks.keys().filter(|task| self.expected.has_file(*task));
        let tasks = tasks.map(Some).chain([None]);
        tasks
            .map(|task| {
                Ok(NewFile { path: self.file(task), text: self.whole_file(task, &mut written)? })
            })
            .collect()
    }

    /// The beginning of a new file: notice and includes.
    pub(crate) fn preamble(&self) -> String {
        let name = &self.expected.component().name;
        let mut out = String::new();
        if let Some(notice) = &self.options.notice {
            out += &text::c_comment(notice);
            out.push('\n');
        }
        let types = types_header(self.expected);
        if self.options.notice.is_some()
            || !self.expected.spec.release.has(Change::NoLeadingBlankLine)
        {
            out.push('\n');
        }
        out += &format!("#include \"ac{name}.h\"\n\n#include \"{types}\"\n");
        out
    }

    fn whole_file(
        &self,
        task: Option<TaskId>,
        written: &mut FxHashMap<String, String>,
    ) -> Result<String, LangError> {
        let component = self.expected.component();
        let mut out = self.preamble();
        let all = component.services.iter_enumerated();
        let services = || all.clone().filter(|(_, service)| self.expected.is_own(service.src));
        let refs = |owner: Owner, kinds: &[CodelKind]| -> Vec<CodelRef> {
            let codels = component.codels_of(owner).iter_enumerated();
            codels
                .filter(|codel| kinds.contains(&codel.1.kind) && self.expected.is_own(codel.1.src))
                .map(|(index, _)| CodelRef { owner, index })
                .collect()
        };
        let mut groups = Vec::new();
        match task {
            Some(task) => groups.push((
                Group::Task(task),
                refs(Owner::Task(task), &[CodelKind::Fsm, CodelKind::Simple]),
            )),
            None => {
                for (index, _) in services() {
                    let codels = refs(Owner::Service(index), &[CodelKind::Validate]);
                    groups.push((Group::Validation(index), codels));
                }
            }
        }
        for (index, service) in services() {
            if service.task == task {
                let kinds = [CodelKind::Simple, CodelKind::Fsm];
                groups.push((Group::Service(index), refs(Owner::Service(index), &kinds)));
            }
        }
        for (group, codels) in groups {
            if codels.is_empty() && !matches!(group, Group::Task(_)) {
                continue;
            }
            out += &self.heading(group);
            for at in codels {
                let gap = if matches!(group, Group::Task(_)) { "\n\n" } else { "\n" };
                out += gap;
                let name = component.codel(at).name.to_string();
                let place = match group {
                    Group::Task(task) => {
                        format!("task {}", component.tasks[task].name)
                    }
                    Group::Validation(validation) => {
                        format!("service {} validation", component.services[validation].name)
                    }
                    Group::Service(service) => {
                        format!("service {}", component.services[service].name)
                    }
                };
                out += &self.comment(at);
                if let Some(before) = written.get(&name) {
                    out += &format!("/* already defined in {before} */\n\n");
                } else {
                    out += &self.function(at)?;
                    written.insert(name, place);
                }
            }
        }
        Ok(out)
    }

    fn heading(&self, group: Group) -> String {
        let component = self.expected.component();
        let title = match group {
            Group::Task(task) => format!("Task {}", component.tasks[task].name),
            Group::Validation(validation) | Group::Service(validation) => {
                let (kind, name) = owner_words(component, Owner::Service(validation));
                let mut kind = kind.to_owned();
                kind[..1].make_ascii_uppercase();
                format!("{kind} {name}")
            }
        };
        format!("\n\n/* {} */\n", text::rule(&title, Some('-'), 70))
    }

    /// The comment and the function of one codel.
    pub fn stub(&self, at: CodelRef) -> Result<String, LangError> {
        Ok(self.comment(at) + &self.function(at)?)
    }

    /// The comment of a codel with a final newline.
    pub fn comment(&self, at: CodelRef) -> String {
        let header = self.comment_header(at);
        let sentences = self.comment_sentences(at);
        format!("/** {header}.\n *\n * {}\n */\n", sentences.replace('\n', "\n * "))
    }

    /// `Codel f of task t`
    pub(crate) fn comment_header(&self, at: CodelRef) -> String {
        let component = self.expected.component();
        let codel = component.codel(at);
        let (kind, owner) = owner_words(component, at.owner);
        let word = match codel.kind {
            CodelKind::Validate => "Validation codel",
            _ => "Codel",
        };
        format!("{word} {} of {kind} {owner}", codel.name)
    }

    /// `Triggered by …`, `Yields to …`, `Throws …`, each on a separate line, without comment marks.
    pub(crate) fn comment_sentences(&self, at: CodelRef) -> String {
        let codel = self.expected.component().codel(at);
        let events = |all: &[State]| {
            let names = all.iter().map(|state| self.expected.spelling(state.event).to_string());
            names.collect::<Vec<_>>().join(", ")
        };
        let throws = self.expected.throws_of(at.owner);
        let throws = throws.iter().map(|&exception| self.expected.spelling(exception).to_string());
        let throws = throws.collect::<Vec<_>>().join(", ");
        let mut lines = Vec::new();
        // Wrapped as in the comment, with its mark included.
        let mut line = |text: String, indent: usize| {
            let prefix = format!(" * {}", " ".repeat(indent));
            let wrapped = text::wrap(&format!(" * {text}"), &prefix, " ", 70);
            let cut =
                wrapped.lines().map(|line| line.strip_prefix(" * ").unwrap_or(line).to_owned());
            lines.extend(cut);
        };
        if !codel.triggers.is_empty() {
            line(format!("Triggered by {}.", events(&codel.triggers)), 0);
        }
        match codel.kind {
            CodelKind::Fsm => line(format!("Yields to {}.", events(&codel.yields)), 10),
            CodelKind::Simple | CodelKind::Validate => line("Returns genom_ok.".into(), 0),
        }
        if codel.kind == CodelKind::Validate {
            line(format!("Throws {throws}."), 0);
        } else if !throws.is_empty() || matches!(at.owner, Owner::Task(_)) && !throws.is_empty() {
            line(format!("Throws {throws}."), 7);
        }
        lines.join("\n")
    }

    /// The function of a codel with a final newline.
    pub fn function(&self, at: CodelRef) -> Result<String, LangError> {
        let codel = self.expected.component().codel(at);
        let mapper = self.expected.mapper();
        let mut out = mapper.prototype(self.expected.component, codel, "\n")?;
        let indentation = self.options.indentation.as_deref().unwrap_or("  ");
        out += &format!("\n{{\n{indentation}/* skeleton sample: insert your code */\n");
        if self.options.use_parameters {
            for name in self.parameter_names(&codel.params) {
                out += &format!("{indentation}(void){name};\n");
            }
        }
        let event = match codel.kind {
            CodelKind::Fsm => codel.yields.first().map(|state| self.expected.spelling(state.event)),
            CodelKind::Simple | CodelKind::Validate => None,
        };
        let event = event.unwrap_or_else(|| self.expected.ok().into());
        out += &format!("{indentation}/* skeleton sample */ return {event};\n}}\n");
        Ok(out)
    }

    fn parameter_names(&self, params: &[Param]) -> Vec<String> {
        let mut out: Vec<String> = params.iter().map(|param| param.name.to_string()).collect();
        if self.expected.language == Language::C {
            out.push("self".into());
        }
        out
    }
}

/// The header with the mapped types, which the codels of a component include.
pub fn types_header(expected: &Expected<'_>) -> String {
    let name = &expected.component().name;
    match expected.language {
        Language::Cxx => format!("{name}_cxx_types.h"),
        _ => format!("{name}_c_types.h"),
    }
}
