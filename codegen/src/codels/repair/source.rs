//! Edits of the C and C++ sources.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::model::CodelRef;

use super::Repairs;
use crate::codels::{
    edit::Edit,
    files::IndexedFile,
    indentation::indentation,
    source::{function_mentions, mentions},
    stub::{StubOptions, Stubs},
};
use crate::lang::LangError;

impl Repairs<'_> {
    /// Stubs of codels, each in the file of the skeleton. Codels with a function are skipped.
    pub fn stub(&self, codels: &[CodelRef]) -> Result<Edit, LangError> {
        let missing = self.missing();
        let mut edit = Edit::default();
        if self.sources.sources.is_empty() && missing.iter().all(|codel| codels.contains(codel)) {
            let options = self.indented_stubs(&self.sources.folder.join("new.c"));
            for file in Stubs::new(self.expected, &options).all_files()? {
                let name = file.path.file_name().unwrap_or_default();
                edit.created.insert(self.sources.folder.join(name), file.text);
            }
            return Ok(edit);
        }
        let mut by_file: BTreeMap<Utf8PathBuf, Vec<CodelRef>> = BTreeMap::new();
        for &at in codels {
            if missing.contains(&at) {
                by_file.entry(self.stub_file(at)).or_default().push(at);
            }
        }
        for (path, codels) in by_file {
            let options = self.indented_stubs(&path);
            let stubs = Stubs::new(self.expected, &options);
            if let Some(file) = self.sources.file(&path) {
                for at in codels {
                    let here = self.stub_place(file, at);
                    let text = stubs.stub(at)?;
                    let text = format!("\n\n\n{}", text.trim_end());
                    edit.replace(&path, here..here, text);
                }
            } else {
                let mut text = stubs.preamble();
                for at in codels {
                    text += "\n\n";
                    text += &stubs.stub(at)?;
                }
                edit.created.insert(path.clone(), text);
                self.list_source(&path, &mut edit);
            }
        }
        Ok(edit)
    }

    /// The options for stubs in a file, with its indentation.
    fn indented_stubs(&self, path: &Utf8Path) -> StubOptions {
        let own = self.sources.file(path).into_iter();
        let files = own.chain(&self.sources.sources);
        StubOptions {
            indentation: Some(indentation(path, files, self.text)),
            ..self.stub_options()
        }
    }

    /// The place of a stub: after the function of the preceding codel, else at the end of the file.
    fn stub_place(&self, file: &IndexedFile, at: CodelRef) -> usize {
        let component = self.expected.component();
        let before =
            (0..at.index.into()).rev().map(|index: usize| CodelRef { index: index.into(), ..at });
        for at in before {
            let name = &component.codel(at).name;
            if let Some(function) = file.index().definitions(name).last() {
                return function.span.end;
            }
        }
        file.text.trim_end().len()
    }

    /// Adds a new file to the list of sources in the build file.
    fn list_source(&self, path: &Utf8Path, edit: &mut Edit) {
        let Some((makefile, text)) = &self.sources.makefile else {
            return;
        };
        let stem = format!("{}_", self.expected.component().name);
        let mut at = 0;
        let mut last = None;
        let mut variable = None;
        for line in text.split_inclusive('\n') {
            at += line.len();
            if let Some((name, _)) = line.split_once('=') {
                let name = name.trim_end_matches(['+', ':', ' ', '\t']);
                variable = (name.ends_with("_SOURCES") && name != "BUILT_SOURCES").then_some(name);
            }
            let continued = line.trim_end().ends_with('\\');
            if let Some(name) = variable {
                // The variable with other files of the component is preferred.
                let own = line.contains(&stem);
                if !continued && (own || last.is_none()) {
                    last = Some((at, name));
                }
            }
            if !continued {
                variable = None;
            }
        }
        if let Some((at, name)) = last {
            let file = path.file_name().unwrap_or_default();
            let newline = if text[..at].ends_with('\n') { "" } else { "\n" };
            edit.replace(makefile, at..at, format!("{newline}{name} += {file}\n"));
        }
    }

    pub(super) fn refresh_comment(
        &self,
        at: CodelRef,
        path: &Utf8Path,
        start: usize,
    ) -> Option<Edit> {
        let file = self.sources.file(path)?;
        let mut comments = file.index().functions.iter().flat_map(|function| &function.comments);
        let comment = comments.find(|comment| comment.span.start == start)?;
        let generated = comment.generated.as_ref()?;
        let stubs = Stubs::new(self.expected, self.stubs);
        let mut edit = Edit::default();
        let header = stubs.comment_header(at);
        if file.text.get(generated.header.clone())? != header {
            edit.replace(path, generated.header.clone(), header);
        }
        if !generated.sentences.is_empty() {
            // Each line has the prefix of the first one.
            let before = file.text.get(..generated.sentences.start)?;
            let prefix = before.rsplit('\n').next().unwrap_or_default();
            let sentences = stubs.comment_sentences(at).replace('\n', &format!("\n{prefix}"));
            edit.replace(path, generated.sentences.clone(), sentences);
        }
        Some(edit)
    }

    pub(super) fn rename_function(&self, from: &str, to: &str) -> Edit {
        let mut edit = Edit::default();
        for file in self.sources.all() {
            // In C, an event can have the name too.
            let is_event = self.expected.events.contains_key(from);
            let find = if is_event { function_mentions } else { mentions };
            for range in find(&file.text, file.grammar, from) {
                edit.replace(&file.path, range, to);
            }
            let comments = file.index().functions.iter().flat_map(|function| &function.comments);
            for generated in comments.filter_map(|comment| comment.generated.as_ref()) {
                if generated.codel == from
                    && let Some(header) = file.text.get(generated.header.clone())
                    && let Some(at) = header.find(&format!(" {from} "))
                {
                    let start = generated.header.start + at + 1;
                    edit.replace(&file.path, start..start + from.len(), to);
                }
            }
        }
        edit
    }
}
