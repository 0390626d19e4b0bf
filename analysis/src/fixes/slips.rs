//! Slips of the pen: what was meant is plain, and a word or a character away.

use dotgen_syntax::{SyntaxNode, TextRange, TextSize, ast, ast::AstNode};

use super::{Place, TextFix, add_property, braces::token_before, end_of, with_comma};

impl Place<'_> {
    /// A semicolon behind the last token before the place.
    pub(crate) fn add_semicolon(&self) -> Option<TextFix> {
        let at = token_before(self.root, self.range.start())?;
        Some(insert(at.text_range().end(), ";"))
    }

    /// The list of states that a codel lacks.
    pub(crate) fn add_yield_list(&self) -> Option<TextFix> {
        let codel: ast::Codel = self.node(self.range)?;
        Some(insert(end_of(codel.syntax()), " yield ether"))
    }

    /// A blank between a number and its unit.
    pub(crate) fn part_unit(&self) -> Option<TextFix> {
        let text = self.text(self.range);
        let number = text.find(|it: char| it.is_ascii_alphabetic());
        let number = number.unwrap_or(text.len());
        let unit = self.range.start() + TextSize::try_from(number).ok()?;
        Some(TextFix {
            title: format!("Write `{} us`", &text[..number]),
            edits: vec![(TextRange::empty(unit), " ".to_owned())],
        })
    }

    /// The word `wcet` before an execution time.
    pub(crate) fn add_wcet_word(&self) -> TextFix {
        TextFix {
            title: "Write `wcet` before the duration".to_owned(),
            edits: vec![(TextRange::empty(self.range.start()), "wcet ".to_owned())],
        }
    }

    /// Another text in the place of this one.
    pub(crate) fn replace(&self, text: &str) -> TextFix {
        TextFix {
            title: format!("Change to `{text}`"),
            edits: vec![(self.range, text.to_owned())],
        }
    }

    /// Takes out what is here.
    pub(crate) fn remove(&self) -> TextFix {
        remove(self.range, &self.text(self.range))
    }

    /// Takes out what is here, which cannot be shown.
    pub(crate) fn remove_as(&self, title: &str) -> TextFix {
        TextFix {
            title: title.to_owned(),
            edits: vec![(self.range, String::new())],
        }
    }

    /// Takes a part of a list out.
    pub(crate) fn remove_part(&self) -> Option<TextFix> {
        let part = self.part(self.range)?;
        Some(remove(with_comma(&part), &self.text(self.range)))
    }

    /// Gives a service the task that it lacks.
    pub(crate) fn add_task(&self, task: &str) -> Option<TextFix> {
        let service = self.node::<ast::Service>(self.range)?;
        let property = format!("task {task};");
        add_property(service.syntax(), &property, format!("Add `{property}`"))
    }

    /// Gives an activity the codel with which it begins.
    pub(crate) fn add_start(&self) -> Option<TextFix> {
        let service = self.node::<ast::Service>(self.range)?;
        let name = self.text(self.range);
        let property = format!("codel<start> {name}_start() yield ether;");
        let title = format!("Add the codel `{name}_start`");
        add_property(service.syntax(), &property, title)
    }

    /// The outermost node that is just what a range covers.
    fn part(&self, range: TextRange) -> Option<SyntaxNode> {
        let around = self.token_at(range)?.parent_ancestors();
        let same =
            |it: &SyntaxNode| it.text_range().start() == range.start() && end_of(it) == range.end();
        around.take_while(same).last()
    }
}

fn insert(at: TextSize, text: &str) -> TextFix {
    TextFix {
        title: format!("Insert `{}`", text.trim()),
        edits: vec![(TextRange::empty(at), text.to_owned())],
    }
}

fn remove(range: TextRange, what: &str) -> TextFix {
    TextFix {
        title: format!("Remove `{what}`"),
        edits: vec![(range, String::new())],
    }
}
