//! Regions that can be folded: bodies, lists, runs of comments and includes, conditionals.

use dotgen_syntax::{
    SyntaxElement, SyntaxKind, SyntaxNode, TextRange,
    ast::{self, AstNode, DirectiveKind},
};

use super::{FileView, FoldKind, FoldingRange};
use crate::source_map::bytes;

pub(crate) fn folding_ranges(view: &FileView<'_>) -> Vec<FoldingRange> {
    let mut folds = Folds {
        text: view.text(),
        out: Vec::new(),
        comments: None,
        includes: None,
        conditionals: Vec::new(),
    };
    for element in view.root().descendants_with_tokens() {
        folds.element(&element);
    }
    folds.end_runs();
    let mut out = folds.out;
    out.sort_by_key(|range| (range.range.start, std::cmp::Reverse(range.range.end)));
    out.dedup();
    out
}

struct Folds<'a> {
    text: &'a str,
    out: Vec<FoldingRange>,
    /// The run of line comments so far.
    comments: Option<TextRange>,
    /// The run of includes so far.
    includes: Option<TextRange>,
    /// The starts of the open branches.
    conditionals: Vec<TextRange>,
}

impl Folds<'_> {
    fn element(&mut self, element: &SyntaxElement) {
        match element.kind() {
            SyntaxKind::WHITESPACE => {}
            SyntaxKind::NEWLINE => self.blank_line(element.text_range()),
            SyntaxKind::LINE_COMMENT => {
                self.comments = Some(match self.comments {
                    Some(run) => run.cover(element.text_range()),
                    None => element.text_range(),
                });
            }
            SyntaxKind::BLOCK_COMMENT | SyntaxKind::OPEN_COMMENT => {
                self.end_runs();
                self.fold(element.text_range(), Some(FoldKind::Comment));
            }
            SyntaxKind::DIRECTIVE => {
                if let Some(node) = element.as_node() {
                    self.directive(node);
                }
            }
            SyntaxKind::BODY
            | SyntaxKind::ENUMERATOR_LIST
            | SyntaxKind::PARAM_LIST
            | SyntaxKind::INITIALIZER_LIST => {
                self.end_runs();
                self.fold(element.text_range(), None);
            }
            SyntaxKind::INACTIVE => {
                self.end_runs();
                self.fold(element.text_range(), Some(FoldKind::Region));
            }
            _ => {
                let in_directive =
                    element.ancestors().any(|ancestor| ancestor.kind() == SyntaxKind::DIRECTIVE);
                if !in_directive {
                    self.end_runs();
                }
            }
        }
    }

    fn directive(&mut self, node: &SyntaxNode) {
        let range = node.text_range();
        let Some(directive) = ast::Directive::cast(node.clone()) else {
            return;
        };
        let kind = directive.kind();
        if kind == DirectiveKind::Include {
            self.comments = self.end_run(self.comments, FoldKind::Comment);
            self.includes = Some(match self.includes {
                Some(run) => run.cover(range),
                None => range,
            });
            return;
        }
        self.end_runs();
        match kind {
            DirectiveKind::If | DirectiveKind::Ifdef | DirectiveKind::Ifndef => {
                self.conditionals.push(range);
            }
            DirectiveKind::Elif | DirectiveKind::Else => {
                if let Some(start) = self.conditionals.pop() {
                    self.branch(start, range);
                    self.conditionals.push(range);
                }
            }
            DirectiveKind::Endif => {
                if let Some(start) = self.conditionals.pop() {
                    self.branch(start, range);
                }
            }
            _ => {}
        }
    }

    /// Text between two directives of a conditional, the line of the second left out.
    fn branch(&mut self, start: TextRange, end: TextRange) {
        let from = usize::from(start.start());
        let to = usize::from(end.start());
        let inside = self.text.get(from..to).unwrap_or_default();
        let trimmed = inside.trim_end().len();
        self.fold(
            TextRange::at(start.start(), crate::source_map::offset(trimmed)),
            Some(FoldKind::Region),
        );
    }

    fn fold(&mut self, range: TextRange, kind: Option<FoldKind>) {
        let range = bytes(range);
        let text = self.text.get(range.clone()).unwrap_or_default();
        let end = range.start + text.trim_end().len();
        if text.trim_end().contains(['\n', '\r']) {
            self.out.push(FoldingRange { range: range.start..end, kind });
        }
    }

    /// An empty line separates runs.
    fn blank_line(&mut self, newline: TextRange) {
        let before = self.text.get(..usize::from(newline.start())).unwrap_or_default();
        let line = before.rsplit(['\n', '\r']).next().unwrap_or_default();
        if line.trim().is_empty() {
            self.end_runs();
        }
    }

    fn end_runs(&mut self) {
        self.comments = self.end_run(self.comments, FoldKind::Comment);
        self.includes = self.end_run(self.includes, FoldKind::Imports);
    }

    fn end_run(&mut self, run: Option<TextRange>, kind: FoldKind) -> Option<TextRange> {
        if let Some(run) = run {
            self.fold(run, Some(kind));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use expect_test::{Expect, expect};

    use crate::test_support::Fixture;

    #[track_caller]
    fn check(text: &str, expected: Expect) {
        let fixture = Fixture::new(text);
        let folds = fixture.analysis().folding_ranges("/main.gen".into()).unwrap();
        let lines = |at: usize| text[..at].matches('\n').count() + 1;
        let lines: Vec<String> = folds
            .iter()
            .map(|range| {
                format!(
                    "{}-{} {:?}\n",
                    lines(range.range.start),
                    lines(range.range.end),
                    range.kind
                )
            })
            .collect();
        expected.assert_eq(&lines.concat());
    }

    #[test]
    fn bodies_comments_and_includes() {
        check(
            "// one
// two

// alone
/* three
   four */
#include \"a\"
#include \"b\"

#include \"c\"
component c {
  port in long p; // five
  // six
  attribute a(
    in x
  );
  enum e { A,
    B };
};
",
            expect![[r"
                1-2 Some(Comment)
                5-6 Some(Comment)
                7-8 Some(Imports)
                11-19 None
                14-16 None
                17-18 None
            "]],
        );
    }

    #[test]
    fn conditionals() {
        check(
            "#if 1
const long a = 1;
#if 0
const long b = 1;
const long c = 1;
#else
const long d = 1;
#endif
#endif
",
            expect![[r"
                1-8 Some(Region)
                3-5 Some(Region)
                4-5 Some(Region)
                6-7 Some(Region)
            "]],
        );
    }
}
