//! The effects of the directives.

use std::ops::Range;

use rowan::TextRange;
use smol_str::SmolStr;

use super::{Conditional, MAX_ERRORS, Walker};
use crate::{
    directive::{
        Define, Directive, DirectiveKind, IncludeForm, IncludeOperand, Name, Operand, Pragma,
        unquote,
    },
    finding::preprocessing::{PackagesToInstall, Preprocessing, SearchedDirectories},
    kind::SyntaxKind::*,
    lexer::{is_trivia, is_word},
    preproc::{
        ActiveInclude, IncludeError, IncludeRequest, MacroUse, PpError, Severity,
        body::lower_define, cond::evaluate, token::Token,
    },
};

/// Maximum number of arguments of `#pragma requires` (language reference, 17.1).
const MAX_PACKAGES: usize = 8;

impl Walker<'_> {
    /// Executes a directive. For one that begins a group, returns true if the group is active.
    pub(super) fn execute(&mut self, directive: &Directive, index: usize) -> Option<bool> {
        let range = directive.range;
        if let Some(misspelt) = &directive.misspelt {
            let kind =
                Preprocessing::Misspelt { word: misspelt.word.text.clone(), meant: misspelt.meant };
            self.error(misspelt.word.range, kind);
        }
        match &directive.kind {
            DirectiveKind::Include(operand) => self.include(operand, index, range),
            DirectiveKind::Define(define) => self.define(define, range),
            DirectiveKind::Undef(operand) => self.undef(operand, range),
            DirectiveKind::If(condition) => {
                let value = self.condition(condition.clone(), range);
                return Some(self.open(index, value));
            }
            DirectiveKind::Ifdef(operand) | DirectiveKind::Ifndef(operand) => {
                let wanted = matches!(directive.kind, DirectiveKind::Ifdef(_));
                let value = self.is_defined(operand, directive).is_some_and(|flag| flag == wanted);
                return Some(self.open(index, value));
            }
            DirectiveKind::Elif(condition) => return self.elif(condition.clone(), range),
            DirectiveKind::Else(rest) => return self.else_(rest, directive),
            DirectiveKind::Endif(rest) => self.endif(rest, directive),
            DirectiveKind::Error(text) => {
                let text =
                    if text.is_empty() { "`#error`".into() } else { text.to_string().into() };
                self.error(range, Preprocessing::ErrorDirective { text });
            }
            DirectiveKind::Warning(text) => {
                let text =
                    if text.is_empty() { "`#warning`".into() } else { text.to_string().into() };
                self.warning(range, Preprocessing::WarningDirective { text });
            }
            DirectiveKind::Line(operand) => self.line(operand.clone(), range),
            DirectiveKind::Pragma(pragma) if pragma.name.is_none() => {
                self.error(range, Preprocessing::EmptyPragma);
            }
            DirectiveKind::Pragma(pragma) => self.pragma(pragma, range),
            DirectiveKind::Unknown => {
                let word = directive.keyword.as_ref().map_or("", |keyword| keyword.text.as_str());
                self.report(PpError {
                    kind: Preprocessing::UnknownDirective { word: word.into() },
                    range,
                    severity: Severity::Hint,
                    related: None,
                });
            }
            DirectiveKind::Empty => {}
        }
        None
    }

    fn include(&mut self, operand: &IncludeOperand, index: usize, range: TextRange) {
        let ordinal = self.out.includes.len() as u32;
        let named = match &operand.form {
            IncludeForm::Quoted(path) => Some((path.clone(), false)),
            IncludeForm::Angled(path) => Some((path.clone(), true)),
            IncludeForm::Macro(tokens) => self.include_operand(tokens.clone(), range),
        };
        let named = named.filter(|(path, _)| !path.is_empty());
        if named.is_none() {
            self.error(range, Preprocessing::IncludeWithoutFile);
        } else if !operand.rest.is_empty() {
            let extra = self.span(operand.rest.start, operand.rest.end);
            self.error(extra, Preprocessing::IncludeWithMore);
        }
        let request = named.map(|(path, angled)| IncludeRequest { ordinal, path, angled });
        let mut included = false;
        if let Some(request) = &request {
            match self.host.include(request, &self.env) {
                Ok(env) => {
                    self.env = env;
                    included = true;
                }
                Err(error) => self.report_include(request, error, operand.range),
            }
        }
        self.out.includes.push(ActiveInclude {
            directive: index as u32,
            request,
            range: operand.range,
            included,
        });
    }

    /// The file that macros in an `#include` name, and true if it is in angle brackets.
    fn include_operand(&mut self, tokens: Range<u32>, range: TextRange) -> Option<(SmolStr, bool)> {
        let tokens = self.expand(tokens, range);
        match &tokens[..] {
            [only] if only.kind == STRING => Some((unquote(&only.text).into(), false)),
            [open, path @ .., close] if open.text == "<" && close.text == ">" => {
                let mut name = String::new();
                for (i, token) in path.iter().enumerate() {
                    if i > 0 && token.spaced {
                        name.push(' ');
                    }
                    name.push_str(&token.text);
                }
                Some((name.into(), true))
            }
            _ => None,
        }
    }

    fn define(&mut self, define: &Define, range: TextRange) {
        let (definition, problems) = lower_define(self.text, self.raw, define, Some(self.file));
        for problem in problems {
            self.error(range, problem);
        }
        let Some(definition) = definition else { return };
        for i in define.body.clone() {
            let kind = self.raw.kind(i as usize);
            if !is_word(kind, self.raw.text(self.text, i as usize)) {
                continue;
            }
            let text = SmolStr::new(self.raw.clean_text(self.text, i as usize));
            let param = define
                .params
                .as_ref()
                .is_some_and(|param| param.names.iter().any(|name| name.text == text));
            if param {
                continue;
            }
            let range = self.expander.raw_range(i);
            match self.env.get(&text) {
                Some(used) => {
                    let site = Some(used.site.clone());
                    self.expander.uses.push(MacroUse { name: text, range, site });
                }
                None => self.body_words.push(Name { text, range }),
            }
        }
        if let Some(old) = self.env.get(&definition.name)
            && !old.same_meaning(&definition)
        {
            // Finding the former directive is too slow for files with very many errors.
            let here =
                old.site.file.as_ref() == Some(self.file) && self.out.errors.len() < MAX_ERRORS;
            let related = here
                .then(|| self.out.define_directive(old.site.ordinal))
                .flatten()
                .map(|directive| (directive.range, "the former definition"));
            self.report(PpError {
                kind: Preprocessing::Redefined { name: definition.name.clone() },
                range,
                severity: Severity::Warning,
                related,
            });
        }
        self.env.define(definition);
    }

    fn undef(&mut self, operand: &Operand, range: TextRange) {
        let Some(name) = &operand.name else {
            self.error(range, Preprocessing::UndefWithoutName);
            return;
        };
        self.extra_tokens(operand, "undef");
        self.record(name);
        self.env.undef(&name.text);
    }

    fn is_defined(&mut self, operand: &Operand, directive: &Directive) -> Option<bool> {
        let keyword = directive.keyword.as_ref().map_or("", |keyword| keyword.text.as_str());
        let Some(name) = &operand.name else {
            self.error(
                directive.range,
                Preprocessing::IfdefWithoutName { keyword: keyword.into() },
            );
            return None;
        };
        self.extra_tokens(operand, keyword);
        self.record(name);
        Some(self.env.get(&name.text).is_some())
    }

    fn extra_tokens(&mut self, operand: &Operand, keyword: &str) {
        if !operand.rest.is_empty() {
            let range = self.span(operand.rest.start, operand.rest.end);
            self.error(range, Preprocessing::MoreThanAName { keyword: keyword.into() });
        }
    }

    /// Records that a name was looked up.
    fn record(&mut self, name: &Name) {
        let site = self.env.get(&name.text).map(|environment| environment.site.clone());
        self.expander.uses.push(MacroUse { name: name.text.clone(), range: name.range, site });
    }

    /// Expands the operand of a directive.
    fn expand(&mut self, tokens: Range<u32>, range: TextRange) -> Vec<Token> {
        let at = tokens.start;
        let operand = tokens
            .filter(|&i| !is_trivia(self.raw.kind(i as usize)))
            .map(|i| self.expander.token(i))
            .collect();
        let expansion = self.expander.operand(&self.env, operand, at);
        self.report_calls(range);
        expansion
    }

    fn condition(&mut self, tokens: Range<u32>, range: TextRange) -> bool {
        self.expander.in_condition = true;
        let errors = self.out.errors.len();
        let tokens = self.expand(tokens, range);
        self.expander.in_condition = false;
        match evaluate(&tokens, |name| self.env.get(name).is_some()) {
            Ok(value) => value,
            Err(error) => {
                // An error in a call explains an error in the condition.
                if self.out.errors.len() == errors {
                    self.error(range, error);
                }
                false
            }
        }
    }

    fn open(&mut self, opening: usize, value: bool) -> bool {
        self.conditionals.push(Conditional { opening, closed: false, seen_else: false });
        self.live = value;
        value
    }

    fn elif(&mut self, condition: Range<u32>, range: TextRange) -> Option<bool> {
        let Some(conditional) = self.conditionals.last_mut() else {
            self.error(range, Preprocessing::ElifWithoutIf);
            return None;
        };
        // After an `#else` as well, as the reference compiler does.
        conditional.closed |= self.live;
        self.live = !conditional.closed && self.condition(condition, range);
        Some(self.live)
    }

    fn else_(&mut self, rest: &Range<u32>, directive: &Directive) -> Option<bool> {
        let range = directive.range;
        self.tail(rest, directive);
        let Some(conditional) = self.conditionals.last_mut() else {
            self.error(range, Preprocessing::ElseWithoutIf);
            return None;
        };
        if conditional.seen_else {
            let opening = self.out.directives.get(conditional.opening);
            let related = opening.map(|directive| (directive.range, "the conditional begins here"));
            conditional.closed = true;
            self.live = false;
            self.report(PpError {
                kind: Preprocessing::ElseTwice,
                range,
                severity: Severity::Error,
                related,
            });
            return Some(false);
        }
        conditional.seen_else = true;
        self.live = !self.live && !conditional.closed;
        Some(self.live)
    }

    fn endif(&mut self, rest: &Range<u32>, directive: &Directive) {
        self.tail(rest, directive);
        if self.conditionals.pop().is_none() {
            self.error(directive.range, Preprocessing::EndifWithoutIf);
        }
        self.live = true;
    }

    /// Warns about superfluous tokens after `#else` and `#endif`, or about a missing line end.
    fn tail(&mut self, rest: &Range<u32>, directive: &Directive) {
        let keyword = directive.keyword.as_ref().map_or("", |keyword| keyword.text.as_str());
        if !rest.is_empty() {
            let range = self.span(rest.start, rest.end);
            self.warning(range, Preprocessing::Tail { keyword: keyword.into() });
        }
        if self.at >= self.raw.len() && !self.open_comment {
            self.warning(directive.range, Preprocessing::NoLineEnd { keyword: keyword.into() });
        }
    }

    fn line(&mut self, operand: Range<u32>, range: TextRange) {
        let tokens = self.expand(operand, range);
        let number = |token: &Token| {
            token.kind == INT && token.text.bytes().all(|byte| byte.is_ascii_digit())
        };
        let valid = match &tokens[..] {
            [line] => number(line),
            [line, file] => number(line) && file.kind == STRING,
            _ => false,
        };
        if !valid {
            self.error(range, Preprocessing::BadLine);
        }
    }

    pub(super) fn pragma(&mut self, pragma: &Pragma, range: TextRange) {
        let Some(name) = &pragma.name else { return };
        if !matches!(name.text.as_str(), "requires" | "require") {
            return;
        }
        match pragma.args.len() {
            0 => {
                self.error(range, Preprocessing::EmptyRequires { word: name.text.clone() });
            }
            1..=MAX_PACKAGES => {
                let arguments: Vec<SmolStr> =
                    pragma.args.iter().map(|argument| argument.text.clone()).collect();
                match self.host.requires(&arguments, &self.env) {
                    Ok(required) => {
                        self.env = required.env;
                        for package in required.own {
                            self.error(range, Preprocessing::OwnInterfaces { package });
                        }
                    }
                    Err(why) => {
                        let why = why.trim_end_matches('.').into();
                        let install = PackagesToInstall(arguments);
                        self.error(range, Preprocessing::Unresolved { why, install });
                    }
                }
            }
            count => {
                let kind = Preprocessing::ManyRequired {
                    word: name.text.clone(),
                    most: MAX_PACKAGES,
                    given: count,
                };
                self.error(range, kind);
            }
        }
    }

    fn report_include(&mut self, request: &IncludeRequest, error: IncludeError, range: TextRange) {
        let path = request.path.clone();
        let kind = match error {
            IncludeError::NotFound { searched } if searched.is_empty() => {
                Preprocessing::NotFound { path }
            }
            IncludeError::NotFound { searched } => {
                Preprocessing::NotFoundIn { path, searched: SearchedDirectories(searched) }
            }
            IncludeError::Unreadable(why) => Preprocessing::NotIncluded { path, why: why.into() },
            IncludeError::TooDeep => Preprocessing::TooDeep { path },
            IncludeError::Silent => return,
        };
        self.error(range, kind);
    }
}
