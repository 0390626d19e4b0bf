//! The values that are inserted into a file of the template, and the order of its texts.

use std::path::Path;

use dotgen_analysis::model::Spec;
use dotgen_syntax::encoding;

use crate::disk::Disk;
use crate::frontend::Compiled;
use crate::lang::Language;
use crate::template::marker::{self, PieceKind};
use crate::template::model::Model;
use crate::template::object::{Object, Registry};
use crate::template::{Failure, tcl};

/// The queries about a specification, as templates ask them.
pub(super) struct Facts<'a> {
    compiled: &'a Compiled,
    registry: Registry,
    /// Name of the template.
    pub(super) template: &'a str,
}

impl<'a> Facts<'a> {
    pub(super) fn new(compiled: &'a Compiled, template: &'a str) -> Facts<'a> {
        let mut registry = Registry::default();
        registry.update(&compiled.spec);
        Facts { compiled, registry, template }
    }

    pub(super) fn spec(&self) -> &'a Spec {
        &self.compiled.spec
    }

    /// The answer to a query about an object; `None` if there is none.
    pub(super) fn text(&self, object: &Object, question: &[&str]) -> Option<String> {
        let model = Model {
            spec: &self.compiled.spec,
            places: &*self.compiled.places,
            registry: &self.registry,
            template: self.template,
            language: Language::C,
        };
        let words: Vec<String> = question.iter().map(|question| (*question).to_owned()).collect();
        let mut no_lambda = |_: &str, _: &str| Err(Failure::Error(String::new()));
        let answer = model.call(object, &words, &mut no_lambda).ok()?;
        Some(encoding::latin1(&answer.text).into_owned())
    }

    /// The answer to a query about a component.
    pub(super) fn component(&self, component: u32, question: &[&str]) -> Option<String> {
        self.text(&Object::Component(component), question)
    }

    /// An answer that is a list.
    pub(super) fn list(&self, object: &Object, question: &[&str]) -> Option<Vec<String>> {
        tcl::parse_list(&self.text(object, question)?).ok()
    }

    /// An answer that is a list of objects.
    pub(super) fn objects(&self, object: &Object, question: &[&str]) -> Option<Vec<Object>> {
        let handles = self.list(object, question)?;
        handles.iter().map(|handle| self.object_of(handle)).collect()
    }

    /// An answer that is an object.
    pub(super) fn object(&self, object: &Object, question: &[&str]) -> Option<Object> {
        self.object_of(&self.text(object, question)?)
    }

    pub(super) fn object_of(&self, handle: &str) -> Option<Object> {
        self.registry.object(handle).cloned()
    }
}

/// A file of the template: its texts, in order, and the values inserted between them.
///
/// A text lies between two markers. The next text is determined by counting, because the contents of the
/// folder are known. Therefore no text of the template is stored here.
pub(super) struct TemplateWriter {
    texts: Vec<String>,
    at: usize,
    out: String,
}

impl TemplateWriter {
    /// Reads a file; `None` if that fails.
    pub(super) fn read(disk: &dyn Disk, path: &Path) -> Option<TemplateWriter> {
        let source = tcl::decode(&disk.read(path).ok()?);
        let pieces = marker::translate(&source).ok()?.pieces;
        let source: Vec<char> = source.chars().collect();
        let mut texts: Vec<String> = Vec::new();
        let mut end = None;
        for piece in pieces.iter().filter(|piece| piece.kind == PieceKind::Literal) {
            let text = source.get(piece.source.clone())?.iter();
            // A long text is read in parts.
            match texts.last_mut() {
                Some(last) if end == Some(piece.source.start) => last.extend(text),
                _ => texts.push(text.collect()),
            }
            end = Some(piece.source.end);
        }
        Some(TemplateWriter { texts, at: 0, out: String::new() })
    }

    /// Writes the next text.
    pub(super) fn next(&mut self) -> &mut TemplateWriter {
        if let Some(text) = self.texts.get(self.at) {
            self.out += text;
        }
        self.at += 1;
        self
    }

    /// Writes a value.
    pub(super) fn put(&mut self, value: &str) -> &mut TemplateWriter {
        self.out += &encoding::latin1(value);
        self
    }

    /// Writes the notice as a comment of lines that begin with `mark`.
    pub(super) fn notice(&mut self, mark: &str, notice: Option<&str>) {
        if let Some(notice) = notice {
            let lines = notice.replace('\n', &format!("\n{mark}"));
            self.put(&format!("{mark}{lines}\n"));
        }
    }

    /// Writes the next `count` texts, with the values between them, once for each item.
    pub(super) fn each<T>(
        &mut self,
        count: usize,
        things: impl IntoIterator<Item = T>,
        mut write: impl FnMut(&mut TemplateWriter, T) -> Option<()>,
    ) -> Option<()> {
        let start = self.at;
        for thing in things {
            self.at = start;
            write(self, thing)?;
        }
        self.at = start + count;
        Some(())
    }

    /// Writes the next `count` texts, with the values between them, or skips them.
    pub(super) fn when(
        &mut self,
        count: usize,
        wanted: bool,
        mut write: impl FnMut(&mut TemplateWriter) -> Option<()>,
    ) -> Option<()> {
        self.each(count, wanted.then_some(()), |walk, ()| write(walk))
    }

    /// The written text; `None` if any text of the file remains.
    pub(super) fn done(self) -> Option<String> {
        (self.at == self.texts.len()).then_some(self.out)
    }

    /// A file without inserted values.
    pub(super) fn whole(mut self) -> Option<String> {
        self.next();
        self.done()
    }
}
