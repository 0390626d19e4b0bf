//! Reading the arguments of a macro call.

use super::{CallProblem, Disabled, Expander, Expansion};
use crate::{
    finding::preprocessing::{Arguments, Preprocessing},
    kind::SyntaxKind::*,
    lexer::is_trivia,
    preproc::{Origin, definition::Macro, token::Token},
};

/// The reasons for which reading arguments ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ArgumentsEnd {
    Closed,
    End,
    Directive,
    Limit,
}

/// The arguments of a call, `__VA_ARGS__` last.
#[derive(Default)]
pub(super) struct Args {
    pub(super) spelled: Vec<Vec<Token>>,
    pub(super) expanded: Vec<Option<Vec<Token>>>,
}

impl Expander<'_> {
    /// Reads the next token for the arguments of a call, from the lists or the text.
    fn next_in_call(
        &self,
        run: &mut Expansion<'_>,
        disabled: &mut Disabled,
    ) -> Result<Token, ArgumentsEnd> {
        if let Some(token) = run.next(disabled) {
            return Ok(token);
        }
        let Some(source) = run.source.as_deref_mut() else {
            return Err(ArgumentsEnd::End);
        };
        let mut line_start = false;
        while source.next < source.end {
            let i = source.next;
            let kind = self.raw.kind(i as usize);
            if kind == HASH && line_start {
                return Err(ArgumentsEnd::Directive);
            }
            source.next += 1;
            if !is_trivia(kind) {
                return Ok(self.token(i));
            }
            line_start |= kind == NEWLINE;
        }
        Err(ArgumentsEnd::End)
    }

    /// Reads the arguments of a call, parentheses included. On failure, puts the tokens read from the lists
    /// back and leaves the position in the text unchanged.
    pub(super) fn arguments(
        &mut self,
        run: &mut Expansion<'_>,
        disabled: &mut Disabled,
        definition: &Macro,
        named: usize,
        variadic: bool,
    ) -> Result<Args, Vec<Token>> {
        let start = run.source.as_deref().copied();
        let mut args: Vec<Vec<Token>> = vec![Vec::new()];
        let mut parens = 0usize;
        let mut opening = None;
        let stop = loop {
            let token = match self.next_in_call(run, disabled) {
                Ok(token) => token,
                Err(stop) => break stop,
            };
            if self.budget == 0 {
                self.take_from_budget(1, definition);
                break ArgumentsEnd::Limit;
            }
            self.budget -= 1;
            match token.kind {
                L_PAREN if opening.is_none() => {
                    opening = Some(token);
                    continue;
                }
                L_PAREN => parens += 1,
                R_PAREN if parens == 0 => break ArgumentsEnd::Closed,
                R_PAREN => parens -= 1,
                COMMA if parens == 0 && !(variadic && args.len() > named) => {
                    args.push(Vec::new());
                    continue;
                }
                _ => {}
            }
            if let Some(last) = args.last_mut() {
                last.push(token);
            }
        };
        let end = run.source.as_deref().map(|source| source.next);
        if stop != ArgumentsEnd::Closed {
            if let (Some(source), Some(start)) = (run.source.as_deref_mut(), start) {
                *source = start;
            }
            self.report_open_call(stop, definition);
            // Tokens of the text are read again.
            let from = start.map_or(u32::MAX, |start| start.next);
            let read = opening.into_iter().chain(args.into_iter().flatten());
            return Err(read
                .filter(|argument| !matches!(argument.origin, Origin::Argument(i) if i >= from))
                .collect());
        }
        if named == 0 && !variadic && args.len() == 1 && args.iter().all(Vec::is_empty) {
            args.clear();
        }
        self.check_count(definition, &args, Arguments { count: named, open: variadic }, end);
        args.resize(named + usize::from(variadic), Vec::new());
        Ok(Args { expanded: vec![None; args.len()], spelled: args })
    }

    fn report_open_call(&mut self, stop: ArgumentsEnd, definition: &Macro) {
        if stop == ArgumentsEnd::Limit || self.open_call {
            return;
        }
        self.open_call = true;
        let name = definition.name.clone();
        let kind = match stop {
            ArgumentsEnd::Directive => Preprocessing::DirectiveInCall { name },
            _ => Preprocessing::OpenCall { name },
        };
        self.problems.push(CallProblem { kind, end: None });
    }

    /// Reports a call with another number of arguments than its macro takes.
    fn check_count(
        &mut self,
        definition: &Macro,
        args: &[Vec<Token>],
        takes: Arguments,
        end: Option<u32>,
    ) {
        let complete = args.len() == takes.count || takes.open && args.len() > takes.count;
        if !complete {
            let given =
                if args.len() == 1 && args.iter().all(Vec::is_empty) { 0 } else { args.len() };
            self.problems.push(CallProblem {
                kind: Preprocessing::WrongArguments { name: definition.name.clone(), takes, given },
                end,
            });
        }
    }
}
