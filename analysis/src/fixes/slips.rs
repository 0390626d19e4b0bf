//! Slips of the pen: what was meant is plain, and a word or a character away.

use dotgen_syntax::{SyntaxNode, TextRange, TextSize, ast, ast::AstNode};

use super::{Place, TextFix, add_property, braces::token_before, end_of, with_comma};

/// The codes of [`Place::slip`].
pub(super) const CODES: [&str; 10] = [
    "activity-start",
    "activity-task",
    "fsm/duplicate-yield",
    "fsm/paused-ether",
    "glued-unit",
    "lex-stray",
    "list-duplicate-string",
    "missing-semicolon",
    "missing-yield",
    "throw-duplicate",
];

impl Place<'_> {
    /// The one edit that is meant.
    pub(super) fn slip(&self) -> Option<TextFix> {
        let (code, range) = (self.finding.code, self.finding.range);
        match code {
            "missing-semicolon" => {
                let at = token_before(self.root, range.start())?.text_range().end();
                insert(at, ";")
            }
            "missing-yield" => {
                let codel: ast::Codel = self.node(range)?;
                insert(end_of(codel.syntax()), " yield ether")
            }
            "glued-unit" => {
                let text = self.text(range);
                let number = text.find(|it: char| it.is_ascii_alphabetic())?;
                let unit = range.start() + TextSize::try_from(number).ok()?;
                Some(TextFix {
                    title: format!("Write `{} us`", &text[..number]),
                    edits: vec![(TextRange::empty(unit), " ".to_owned())],
                })
            }
            "fsm/paused-ether" => Some(TextFix {
                title: "Change to `ether`".to_owned(),
                edits: vec![(range, "ether".to_owned())],
            }),
            // What is not about a character has no place to be mended at.
            "lex-stray" if self.finding.message.contains("remove it") => {
                remove(range, &self.text(range))
            }
            "lex-stray" if self.finding.message.contains("byte order mark") => Some(TextFix {
                title: "Remove the byte order mark".to_owned(),
                edits: vec![(range, String::new())],
            }),
            "fsm/duplicate-yield" | "throw-duplicate" | "list-duplicate-string" => {
                let part = self.part(range)?;
                remove(with_comma(&part), &self.text(range))
            }
            "activity-task" => {
                let (_, example) = self.finding.message.split_once("for instance `")?;
                let (property, _) = example.split_once('`')?;
                let service = self.node::<ast::Service>(range)?;
                add_property(service.syntax(), property, format!("Add `{property}`"))
            }
            "activity-start" => {
                let service = self.node::<ast::Service>(range)?;
                let name = self.text(range);
                let property = format!("codel<start> {name}_start() yield ether;");
                let title = format!("Add the codel `{name}_start`");
                add_property(service.syntax(), &property, title)
            }
            _ => None,
        }
    }

    /// The outermost node that is just what a range covers.
    fn part(&self, range: TextRange) -> Option<SyntaxNode> {
        let around = self.token_at(range)?.parent_ancestors();
        let same =
            |it: &SyntaxNode| it.text_range().start() == range.start() && end_of(it) == range.end();
        around.take_while(same).last()
    }
}

fn insert(at: TextSize, text: &str) -> Option<TextFix> {
    Some(TextFix {
        title: format!("Insert `{}`", text.trim()),
        edits: vec![(TextRange::empty(at), text.to_owned())],
    })
}

fn remove(range: TextRange, what: &str) -> Option<TextFix> {
    Some(TextFix {
        title: format!("Remove `{what}`"),
        edits: vec![(range, String::new())],
    })
}
