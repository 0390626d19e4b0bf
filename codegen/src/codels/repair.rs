//! Text edits for repairs, on either side. Nothing is written: the caller shows the edits.

mod declare;
mod signature;
mod source;
mod specification;

pub use signature::{ManualChange, UnadaptedUse};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::model::{CodelRef, Owner};
use dotgen_analysis::source_map::Locations;

use super::{
    drift::{Drift, NameReplacement, Repair},
    edit::Edit,
    expected::{Expected, owner_words},
    files::{Files, IndexedFile, Sources},
    source::Function,
    stub::{StubOptions, Stubs},
};

/// The data for the edits of one component.
pub struct Repairs<'a> {
    /// The functions that the specification requires.
    pub expected: &'a Expected<'a>,
    pub sources: &'a Sources,
    /// Places of the specification.
    pub locations: &'a dyn Locations,
    /// Texts of the files of the specification.
    pub text: &'a dyn Files,
    pub stubs: &'a StubOptions,
}

/// The edit for new names in a source.
fn respelled(names: &NameReplacement) -> Edit {
    let mut edit = Edit::default();
    for (range, text) in &names.places {
        edit.replace(&names.path, range.clone(), text.as_str());
    }
    edit
}

impl Repairs<'_> {
    /// The description of a repair, in the imperative.
    pub fn title(&self, repair: &Repair) -> String {
        let component = self.expected.component();
        match repair {
            Repair::Stub { at } => {
                let path = self.stub_file(*at);
                let file = path.file_name().unwrap_or_default();
                format!("Write a stub of `{}` in {file}", component.codel(*at).name)
            }
            Repair::UpdateSignature { name, .. } => format!("Update the signature of `{name}`"),
            Repair::AdaptParameters { at, .. } => {
                format!(
                    "Give codel `{0}` the parameters of its function",
                    component.codel(*at).name
                )
            }
            Repair::RefreshComment { at, .. } => {
                format!("Refresh the comment of `{}`", component.codel(*at).name)
            }
            Repair::AddYield { at, state } => {
                format!("Add `yield {state}` to codel `{}`", component.codel(*at).name)
            }
            Repair::RemoveYield { at, index } => {
                let codel = component.codel(*at);
                let state = codel.yields.get(*index).map(super::expected::state_text);
                format!(
                    "Remove `{}` from the yields of codel `{}`",
                    state.unwrap_or_default(),
                    codel.name
                )
            }
            Repair::AddThrow { owner, exception } => {
                let (kind, name) = owner_words(component, *owner);
                format!("Add `throw {}` to {kind} `{name}`", self.exception_name(*exception))
            }
            Repair::AddPausedYield { at, state, returns } => format!(
                "Add `yield pause::{state}` to codel `{}`, and return `{}`",
                component.codel(*at).name,
                returns.to
            ),
            Repair::ReturnDeclared(replacement) => {
                format!("Return `{}` from `{}`", replacement.to, replacement.function)
            }
            Repair::RaiseDeclared(replacement) => {
                format!("Raise `{}` in `{}`", replacement.to, replacement.function)
            }
            Repair::RenameFunction { from, to } => {
                format!("Rename the function `{from}` to `{to}`")
            }
            Repair::RenameCodel { from, to } => format!("Rename the codel `{from}` to `{to}`"),
            Repair::DeclareCodel { name, .. } => format!("Declare codel `{name}`"),
        }
    }

    /// The edits of a repair; `None` if their place cannot be determined.
    pub fn edit(&self, repair: &Repair) -> Option<Edit> {
        match repair {
            Repair::Stub { at } => self.stub(&[*at]).ok(),
            Repair::UpdateSignature { name, path, start } => {
                let (file, function) = self.function(path, *start)?;
                self.update_signature(name, file, function)
            }
            Repair::AdaptParameters { at, path, start } => {
                let (_, function) = self.function(path, *start)?;
                self.adapt_parameters(*at, function)
            }
            Repair::RefreshComment { at, path, start } => self.refresh_comment(*at, path, *start),
            Repair::AddYield { at, state } => self.add_yield(*at, state),
            Repair::RemoveYield { at, index } => self.remove_yield(*at, *index),
            Repair::AddThrow { owner, exception } => self.add_throw(*owner, *exception),
            Repair::AddPausedYield { at, state, returns } => {
                let mut edit = self.add_yield(*at, &format!("pause::{state}"))?;
                edit.merge(respelled(returns)).then_some(edit)
            }
            Repair::ReturnDeclared(replacement) | Repair::RaiseDeclared(replacement) => {
                Some(respelled(replacement))
            }
            Repair::RenameFunction { from, to } => Some(self.rename_function(from, to)),
            Repair::RenameCodel { from, to } => self.rename_codel(from, to),
            Repair::DeclareCodel { path, start, .. } => {
                let (_, function) = self.function(path, *start)?;
                self.declare_codel(function, path)
            }
        }
    }

    /// The repairs of a finding, the best first. If some change the specification and others change the
    /// behaviour of code, the side that was changed last is taken as correct, and the other side is adapted.
    pub fn ordered<'d>(&self, drift: &'d Drift) -> Vec<&'d Repair> {
        let mut out: Vec<&Repair> = drift.repairs.iter().collect();
        let code = out.iter().filter(|repair| repair.changes_code()).count();
        if code > 0 && code < out.len() && self.specification_is_newer(drift) {
            out.sort_by_key(|repair| !repair.changes_code());
        }
        out
    }

    /// True if the specification was changed later than the source.
    fn specification_is_newer(&self, drift: &Drift) -> bool {
        let specification = drift.spec.first().and_then(|spec| self.locations.locate(*spec));
        let changed = |path: &Utf8Path| self.text.changed(path);
        let specification = specification.and_then(|specification| changed(&specification.path));
        let source = drift.source.as_ref().and_then(|source| changed(&source.path));
        specification
            .zip(source)
            .is_some_and(|(specification, source)| specification.is_after(source))
    }

    /// Renames a codel and its function, in every place of the specification and of the sources.
    pub fn rename(&self, from: &str, to: &str) -> Option<Edit> {
        let mut edit = self.rename_codel(from, to)?;
        edit.merge(self.rename_function(from, to)).then_some(edit)
    }

    /// Codels of the component without a function.
    pub fn missing(&self) -> Vec<CodelRef> {
        let functions = self.expected.functions.iter();
        let missing = functions.filter(|function| {
            let mut files = self.sources.all();
            !files.any(|file| file.index().definitions(&function.name).next().is_some())
        });
        missing.filter_map(|function| function.uses.first().copied()).collect()
    }

    /// Codels of one task or service without a function.
    pub fn missing_codels_of(&self, owner: Owner) -> Vec<CodelRef> {
        let mut all = self.missing();
        all.retain(|codel| codel.owner == owner);
        all
    }

    pub(crate) fn stub_file(&self, at: CodelRef) -> Utf8PathBuf {
        let wanted = self.skeleton_file(at);
        let same = |file: &&IndexedFile| file.path.with_extension("") == wanted.with_extension("");
        if let Some(file) = self.sources.sources.iter().find(same) {
            return file.path.clone();
        }
        // The file with the other codels of its task.
        let component = self.expected.component();
        let others = component.all_codels().filter(|codel| self.skeleton_file(*codel) == wanted);
        for other in others {
            let name = &component.codel(other).name;
            let mut files = self.sources.sources.iter();
            if let Some(file) = files.find(|file| file.index().definitions(name).next().is_some()) {
                return file.path.clone();
            }
        }
        wanted
    }

    fn skeleton_file(&self, at: CodelRef) -> Utf8PathBuf {
        let options = self.stub_options();
        let path = Stubs::new(self.expected, &options).file_of(at);
        self.sources.folder.join(path.file_name().unwrap_or_default())
    }

    /// The options, with the language of the other sources.
    fn stub_options(&self) -> StubOptions {
        let mut files = self.sources.sources.iter();
        StubOptions {
            compile_as_cxx: self.stubs.compile_as_cxx
                || files.any(|file| file.path.extension() != Some("c")),
            ..self.stubs.clone()
        }
    }

    fn function(&self, path: &Utf8Path, start: usize) -> Option<(&IndexedFile, &Function)> {
        let file = self.sources.file(path)?;
        let mut functions = file.index().functions.iter();
        Some((file, functions.find(|function| function.span.start == start)?))
    }
}
