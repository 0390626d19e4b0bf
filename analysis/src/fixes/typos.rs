//! Typing mistakes: the intention is clear, and a word or a character away.

use dotgen_syntax::{
    SyntaxNode, TextRange, TextSize, ast, ast::AstNode, parser::Repair, suggestion::nearest,
};

use crate::diagnostic::FixKind;

use super::{FixSite, TextFix, braces::token_before, end_of, with_comma};

impl FixSite<'_> {
    /// The repair from the grammar.
    pub(crate) fn repair(&self, repair: &Repair) -> TextFix {
        let text = repair.text.as_str();
        let shown = text.trim();
        let title = match () {
            () if text.is_empty() => format!("Remove `{}`", self.text(repair.range)),
            () if repair.range.is_empty() => format!("Insert `{shown}`"),
            () => format!("Change to `{shown}`"),
        };
        TextFix { kind: FixKind::of(repair.plain), ..TextFix::guess(title, repair.range, text) }
    }

    /// Adds the state `start` to a codel without states; the codel's name is the related place.
    pub(crate) fn add_first_state(&self) -> Option<TextFix> {
        let at = *self.related.first()?;
        let codel: ast::CodelProperty = self.node(at)?;
        let name = self.token_at(at)?;
        let keyword = token_before(self.root, name.text_range().start())?;
        let inside = codel.syntax().text_range();
        inside
            .contains_range(keyword.text_range())
            .then(|| insert(keyword.text_range().end(), "<start>"))
    }

    /// Inserts a blank between a number and its unit.
    pub(crate) fn part_unit(&self) -> Option<TextFix> {
        let text = self.text(self.range);
        let number = text.find(|character: char| character.is_ascii_alphabetic());
        let number = number.unwrap_or(text.len());
        let unit = self.range.start() + TextSize::try_from(number).ok()?;
        let title = format!("Write `{} us`", &text[..number]);
        Some(TextFix::guess(title, TextRange::empty(unit), " ").choice())
    }

    /// Inserts the word `wcet` before an execution time.
    pub(crate) fn add_wcet_word(&self) -> TextFix {
        let at = TextRange::empty(self.range.start());
        TextFix::guess("Write `wcet` before the duration", at, "wcet ").choice()
    }

    /// Replaces the text by another one.
    pub(crate) fn replace(&self, text: &str) -> TextFix {
        TextFix::guess(format!("Change to `{text}`"), self.range, text)
    }

    /// Replaces the name of a constant by the nearest macro of the file.
    pub(crate) fn near_macro(&self, name: &str) -> Option<TextFix> {
        let macros = self.source.lines().filter_map(|line| {
            let line = line.trim_start().strip_prefix('#')?.trim_start();
            line.strip_prefix("define")?.split_whitespace().next()
        });
        nearest(name, macros).map(|near| self.replace(near))
    }

    pub(crate) fn remove(&self) -> TextFix {
        remove(self.range, &self.text(self.range))
    }

    /// Removes the text, with a title that does not show it.
    pub(crate) fn remove_as(&self, title: &str) -> TextFix {
        TextFix::guess(title, self.range, "")
    }

    /// Removes a part of a list.
    pub(crate) fn remove_part(&self) -> Option<TextFix> {
        let part = self.part(self.range)?;
        Some(remove(with_comma(&part), &self.text(self.range)))
    }

    /// Gives a service the task that it lacks.
    pub(crate) fn add_task(&self, task: &str) -> Option<TextFix> {
        let service = self.node::<ast::Service>(self.range)?;
        let property = format!("task {task};");
        self.add_property(service.syntax(), &property, format!("Add `{property}`"))
    }

    /// Adds a codel for a state of an activity.
    pub(crate) fn add_codel(&self, state: &str) -> Option<TextFix> {
        let service = self.node::<ast::Service>(self.range)?;
        let name = self.text(self.range);
        let codel = self.free_codel(&format!("{name}_{state}"));
        let property = format!("codel<{state}> {codel}() yield ether;");
        let title = format!("Add the codel `{codel}`");
        self.add_property(service.syntax(), &property, title)
    }

    /// The outermost node that covers exactly a range.
    fn part(&self, range: TextRange) -> Option<SyntaxNode> {
        let around = self.token_at(range)?.parent_ancestors();
        let same = |node: &SyntaxNode| {
            node.text_range().start() == range.start() && end_of(node) == range.end()
        };
        around.take_while(same).last()
    }
}

fn insert(at: TextSize, text: &str) -> TextFix {
    TextFix::guess(format!("Insert `{}`", text.trim()), TextRange::empty(at), text)
}

fn remove(range: TextRange, what: &str) -> TextFix {
    TextFix::guess(format!("Remove `{what}`"), range, "")
}
