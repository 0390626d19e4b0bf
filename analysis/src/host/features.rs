//! The queries of editors on a snapshot: one method per feature, each answered by a module of [`crate::ide`].

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::format::Options;

use super::{Analysis, Cancellable};
use crate::{
    diagnostic::{Diagnostic, FileEdit, Fix},
    elab::DefId,
    ide::{self, *},
    progress::Progress,
    source_map::bytes,
};

impl Analysis {
    /// The innermost macro call around the cursor.
    pub fn expand_macro(
        &self,
        at: &FilePosition,
    ) -> Cancellable<Option<RangeInfo<MacroExpansion>>> {
        self.at(at, ide::expand_macro::expand_macro)
    }

    /// The outline of a file.
    pub fn document_symbols(&self, path: &Utf8Path) -> Cancellable<Vec<DocumentSymbol>> {
        self.list(path, ide::document_symbols::document_symbols)
    }

    /// Named declarations of the workspace whose name contains the characters of `query` in order, ignoring
    /// case; best first, at most `limit`.
    pub fn workspace_symbols(
        &self,
        query: &str,
        limit: usize,
    ) -> Cancellable<Vec<WorkspaceSymbol>> {
        self.with(|db| ide::workspace_symbols::workspace_symbols(db, query, limit))
    }

    /// The declarations whose qualified name ends with `names`, in order of file and place.
    pub fn named(&self, names: &[&str]) -> Cancellable<Vec<NamedDeclaration>> {
        self.with(|db| ide::named::named(db, names))
    }

    /// Regions that can be folded, by start.
    pub fn folding_ranges(&self, path: &Utf8Path) -> Cancellable<Vec<FoldingRange>> {
        self.list(path, ide::folding_ranges::folding_ranges)
    }

    /// For each offset the ranges around it, innermost first; never empty.
    pub fn selection_ranges(
        &self,
        path: &Utf8Path,
        offsets: &[usize],
    ) -> Cancellable<Vec<Vec<Range<usize>>>> {
        self.list(path, |view| {
            let ranges = |&offset| ide::selection_ranges::selection_ranges(view, offset);
            offsets.iter().map(ranges).collect()
        })
    }

    /// Links on include directives.
    pub fn document_links(&self, path: &Utf8Path) -> Cancellable<Vec<DocumentLink>> {
        self.list(path, ide::document_links::document_links)
    }

    /// Includes whose file is not found.
    pub fn missing_includes(&self, path: &Utf8Path) -> Cancellable<Vec<MissingInclude>> {
        self.list(path, ide::document_links::missing_includes)
    }

    /// Required packages of a file that are not found.
    pub fn missing_packages(&self, path: &Utf8Path) -> Cancellable<Vec<MissingPackages>> {
        self.list(path, ide::document_links::missing_packages)
    }

    /// Coloured tokens of a file, or of the part that touches `range`.
    pub fn semantic_tokens(
        &self,
        path: &Utf8Path,
        range: Option<Range<usize>>,
    ) -> Cancellable<Vec<SemanticToken>> {
        self.list(path, |view| ide::semantic_tokens::semantic_tokens(view, range))
    }

    /// Regions excluded by conditionals.
    pub fn inactive_regions(&self, path: &Utf8Path) -> Cancellable<Vec<Range<usize>>> {
        self.list(path, |view| view.pre().inactive.iter().map(|&range| bytes(range)).collect())
    }

    /// The definition of the name under the cursor.
    pub fn goto_definition(
        &self,
        at: &FilePosition,
    ) -> Cancellable<Option<RangeInfo<Vec<NavTarget>>>> {
        self.at(at, ide::goto::definition)
    }

    /// The first declaration of the name under the cursor (forward declarations, first openings).
    pub fn goto_declaration(
        &self,
        at: &FilePosition,
    ) -> Cancellable<Option<RangeInfo<Vec<NavTarget>>>> {
        self.at(at, ide::goto::declaration)
    }

    /// The definition of the type of the name under the cursor.
    pub fn goto_type_definition(
        &self,
        at: &FilePosition,
    ) -> Cancellable<Option<RangeInfo<Vec<NavTarget>>>> {
        self.at(at, ide::goto::type_definition)
    }

    /// Every mention, in every unit, of the name under the cursor; by file and place.
    pub fn references(
        &self,
        at: &FilePosition,
        include_declaration: bool,
    ) -> Cancellable<Option<Vec<ReferenceAt>>> {
        self.at(at, |view, offset| ide::references::references(view, offset, include_declaration))
    }

    /// Every mention in this file of the name under the cursor.
    pub fn highlights(&self, at: &FilePosition) -> Cancellable<Vec<Highlight>> {
        self.list(&at.path, |view| ide::highlights::highlights(view, at.offset))
    }

    /// The description of the name under the cursor.
    pub fn hover(&self, at: &FilePosition) -> Cancellable<Option<RangeInfo<Hover>>> {
        for hover in [ide::hover::hover, ide::context_hover::hover, ide::keyword_hover::hover] {
            if let Some(found) = self.at(at, hover)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Completions at a cursor, best first.
    pub fn completions(&self, at: &FilePosition) -> Cancellable<Vec<CompletionItem>> {
        self.list(&at.path, |view| ide::completion::completions(view, at.offset))
    }

    /// Documentation of a completion: its [`CompletionItem::definition`] and name.
    pub fn resolve_completion(
        &self,
        path: &Utf8Path,
        definition: DefId,
        name: &str,
    ) -> Cancellable<Option<CompletionDoc>> {
        Ok(self.in_file(path, |view| ide::completion::resolve(view, definition, name))?.flatten())
    }

    /// Components that provide the entity under the cursor, or the interface that declares it.
    pub fn goto_implementation(
        &self,
        at: &FilePosition,
    ) -> Cancellable<Option<RangeInfo<Vec<NavTarget>>>> {
        self.at(at, ide::implementation::implementations)
    }

    /// The range and present name of a rename at a cursor.
    ///
    /// # Errors
    /// Returns the reason if the name cannot be renamed.
    pub fn prepare_rename(
        &self,
        at: &FilePosition,
    ) -> Cancellable<Result<RangeInfo<String>, RenameError>> {
        let found = self.in_file(&at.path, |view| ide::rename::prepare(view, at.offset))?;
        Ok(found.unwrap_or_else(|| Err(RenameError("The file cannot be read".to_owned()))))
    }

    /// The edits that rename the entity under the cursor everywhere. Progress counts the specifications that
    /// are searched and those that are compiled with the new name.
    ///
    /// # Errors
    /// Returns the reason if the entity cannot have that name.
    pub fn rename(
        &self,
        at: &FilePosition,
        new_name: &str,
        progress: &Progress,
    ) -> Cancellable<Result<Vec<FileEdit>, RenameError>> {
        let found = self
            .in_file(&at.path, |view| ide::rename::rename(view, at.offset, new_name, progress))?;
        Ok(found.unwrap_or_else(|| Err(RenameError("The file cannot be read".to_owned()))))
    }

    /// The edits of include directives after moving files or folders; pairs of old and new path.
    pub fn files_moved(&self, moves: &[(Utf8PathBuf, Utf8PathBuf)]) -> Cancellable<Vec<FileEdit>> {
        self.with(|db| ide::rename::files_moved(db, moves))
    }

    /// The states or services under a cursor.
    pub fn call_hierarchy(&self, at: &FilePosition) -> Cancellable<Option<Vec<CallItem>>> {
        self.at(at, ide::call_hierarchy::prepare)
    }

    /// The states that lead to a state, or the services that interrupt one.
    pub fn incoming_calls(&self, path: &Utf8Path, key: &CallKey) -> Cancellable<Vec<Call>> {
        self.list(path, |view| ide::call_hierarchy::incoming(view, key))
    }

    /// The states that a state leads to, or the services that one interrupts.
    pub fn outgoing_calls(&self, path: &Utf8Path, key: &CallKey) -> Cancellable<Vec<Call>> {
        self.list(path, |view| ide::call_hierarchy::outgoing(view, key))
    }

    /// Inlay hints of a range, by place.
    pub fn inlay_hints(
        &self,
        path: &Utf8Path,
        range: Range<usize>,
        config: &InlayConfig,
    ) -> Cancellable<Vec<InlayHint>> {
        self.list(path, |view| ide::inlay_hints::inlay_hints(view, &range, config))
    }

    /// The code lenses of a file, by place.
    pub fn code_lenses(&self, path: &Utf8Path, config: &LensConfig) -> Cancellable<Vec<CodeLens>> {
        self.list(path, |view| ide::code_lens::code_lenses(view, config))
    }

    /// The text of a code lens of a file; `None` if its declaration no longer exists.
    pub fn resolve_lens(&self, path: &Utf8Path, kind: &LensKind) -> Cancellable<Option<LensText>> {
        Ok(self.in_file(path, |view| ide::code_lens::resolve(view, kind))?.flatten())
    }

    /// The signature around a cursor.
    pub fn signature_help(&self, at: &FilePosition) -> Cancellable<Option<SignatureHelp>> {
        self.at(at, ide::signature_help::signature_help)
    }

    /// The formatting edits for a file, or for the part of it that touches a range: blanks and line ends
    /// only.
    pub fn format(
        &self,
        path: &Utf8Path,
        within: Option<Range<usize>>,
        options: &Options,
    ) -> Cancellable<Vec<FileEdit>> {
        self.list(path, |view| ide::formatting::format(view, within, options))
    }

    /// The edits after typing `;`, `}` or a line end just before the cursor.
    pub fn format_on_type(
        &self,
        at: &FilePosition,
        typed: char,
        options: &Options,
    ) -> Cancellable<Vec<FileEdit>> {
        self.list(&at.path, |view| ide::formatting::on_type(view, at.offset, typed, options))
    }

    /// The fix that allows a finding by a comment above its declaration.
    pub fn allowing(&self, diagnostic: &Diagnostic) -> Cancellable<Option<Fix>> {
        let path = &diagnostic.path;
        Ok(self.in_file(path, |view| ide::allow::allowing(view, diagnostic))?.flatten())
    }

    /// The refactorings that apply to a selection.
    pub fn assists(&self, path: &Utf8Path, range: Range<usize>) -> Cancellable<Vec<Assist>> {
        self.list(path, |view| ide::assists::assists(view, &range))
    }

    /// The edit that sets the execution time (`4 ms`) of the codel around a place, if the codel states one.
    pub fn with_execution_time(
        &self,
        path: &Utf8Path,
        range: Range<usize>,
        time: &str,
    ) -> Cancellable<Option<FileEdit>> {
        Ok(self.in_file(path, |view| ide::assists::execution_time(view, &range, time))?.flatten())
    }

    /// The edit that sets the period or delay of the task around a place; `None` if the text comes from a
    /// macro or there is no place for it.
    pub fn with_task_time(
        &self,
        path: &Utf8Path,
        range: Range<usize>,
        which: TaskTime,
        time: &str,
    ) -> Cancellable<Option<FileEdit>> {
        Ok(self.in_file(path, |view| ide::assists::task_time(view, &range, which, time))?.flatten())
    }

    /// Sorts the includes of a file; `None` if they are sorted, or if their order matters.
    pub fn organize_includes(&self, path: &Utf8Path) -> Cancellable<Option<Assist>> {
        Ok(self.in_file(path, ide::assists::organize_includes)?.flatten())
    }

    fn list<T>(
        &self,
        path: &Utf8Path,
        f: impl FnOnce(&FileView<'_>) -> Vec<T>,
    ) -> Cancellable<Vec<T>> {
        Ok(self.in_file(path, f)?.unwrap_or_default())
    }

    fn at<T>(
        &self,
        at: &FilePosition,
        f: impl FnOnce(&FileView<'_>, usize) -> Option<T>,
    ) -> Cancellable<Option<T>> {
        Ok(self.in_file(&at.path, |view| f(view, at.offset))?.flatten())
    }
}
