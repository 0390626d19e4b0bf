//! Measures: clients that wait for an event of a run.

use super::Parser;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{
    Bound, Check, CheckKind, Client, Path, Pred, Spanned, Step, StepKind, Trigger, TriggerKind,
};
use crate::scn::lexer::Kind;

/// Words after `on`.
pub(in crate::scn) const TRIGGERS: &[(&str, TriggerKind)] = &[
    ("late", TriggerKind::Late),
    ("violation", TriggerKind::Violation),
    ("lost", TriggerKind::Lost),
    ("stale", TriggerKind::Stale),
];

impl Parser<'_> {
    /// Parses a measure after `on`, which begins at `start`.
    pub(super) fn measure(&mut self, start: usize) -> Option<Client> {
        let on = start..self.end();
        let mut name = None;
        if self.tokens.get(self.at + 1).is_some_and(|token| token.kind == Kind::Colon) {
            name = Some(self.name("the name of the measure")?);
            self.at += 1;
        }
        let word = self.word().to_owned();
        let kind = self.choose(TRIGGERS)?;
        if kind == TriggerKind::Violation && !self.eat_word("of") {
            self.expected("`of` and the name of a check");
            return None;
        }
        let mut of = vec![self.path()?];
        while self.eat(Kind::Comma) {
            of.push(self.path()?);
        }
        let mut after = None;
        if kind == TriggerKind::Stale {
            if !self.eat_word("after") {
                self.expected("`after` and a time");
                return None;
            }
            after = Some((self.number()?, self.unit()?));
        }
        let bound = self.bound()?;
        let range = start..self.end();
        let steps = self.steps()?;
        self.refuse_stops(steps.split_last().map_or(&[], |(last, rest)| match last.kind {
            StepKind::Stop => rest,
            _ => &steps,
        }));
        let made = format!("on_{word}_{}", of[0].text().replace('.', "_"));
        let name = name.unwrap_or(Spanned { value: made, range: on });
        let of_words = if kind == TriggerKind::Violation { "of " } else { "" };
        let paths: Vec<String> = of.iter().map(Path::text).collect();
        let age =
            after.map_or(String::new(), |(count, unit)| format!(" after {count} {}", unit.name()));
        let check = Check {
            name: None,
            subject: Some(format!("on {word} {of_words}{}{age}", paths.join(", "))),
            kind: duration(&name.value, &steps, bound),
            range,
        };
        Some(Client { name, steps, trigger: Some(Trigger { kind, of, after, check }) })
    }

    /// Reports steps that end a run where they may not stand.
    pub(super) fn refuse_stops(&mut self, steps: &[Step]) {
        for step in Step::all(steps).iter().filter(|step| step.kind == StepKind::Stop) {
            let message = "`stop;` ends the run; it may only be the last step of `on … { … }`";
            let range = step.range.clone();
            self.errors.push(Diagnostic::error("scn-stop", range, message.to_owned()));
        }
    }
}

/// The time from the event of a measure to its end: each activity that it interrupts has ended once, then all
/// its steps are done.
fn duration(name: &str, steps: &[Step], bound: Bound) -> CheckKind {
    let of_measure = |label: &str| Pred::Atom(Path::of(&format!("{name}.{label}")));
    let mut ends: Vec<Pred> = Vec::new();
    for step in Step::all(steps) {
        let StepKind::Abort(activity) = &step.kind else { continue };
        if activity.names.len() <= 1 {
            continue;
        }
        let after = of_measure(&format!("{}{}", Trigger::AFTER, Trigger::abort_label(activity)));
        let void = Pred::Atom(Path::of(&format!("{}.void", activity.text())));
        ends.push(Pred::And(Box::new(after), Box::new(void)));
    }
    ends.push(Pred::Atom(Path::of(name)));
    CheckKind::Within(of_measure(Trigger::BEGUN), ends, bound)
}
