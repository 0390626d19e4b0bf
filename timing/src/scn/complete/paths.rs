//! Proposals for paths: whole ones, or one name of a predicate's path at a time.

use std::collections::BTreeSet;

use dotgen_analysis::model::{PortDir, TypeKind};

use super::{Completion, CompletionKind, Finder, PathKind, word};
use crate::scn::ast::{Client, Item, Path, Spanned, Step, StepKind};
use crate::scn::lexer::{Kind, Token};
use crate::scn::names::Target;

impl<'f> Finder<'f> {
    /// Returns the names of the path that ends at the cursor, and its beginning; `None` if the tokens before
    /// do not end in a path.
    pub(super) fn written(&self, rest: &[&Token]) -> Option<(usize, Path)> {
        let mut path = Path::default();
        let mut i = rest.len();
        while i >= 2 && rest[i - 1].kind == Kind::Dot && rest[i - 2].kind == Kind::Name {
            let range = rest[i - 2].range.clone();
            path.names.insert(0, Spanned { value: self.text[range.clone()].to_owned(), range });
            i -= 2;
        }
        let begun = i < rest.len() && path.names.is_empty();
        (!begun).then_some((i, path))
    }

    /// Adds proposals for a chain: its two ports, and the words between.
    pub(super) fn chain(&mut self, rest: &[&Token]) {
        if self.unit(rest) {
            return;
        }
        let after = |token: &&Token| {
            token.kind == Kind::Arrow
                || token.kind == Kind::Comma
                || word(self.text, Some(token)) == "via"
        };
        let Some(last) = rest.iter().rposition(after) else {
            self.path(PathKind::Port, rest);
            return;
        };
        if rest[last].kind != Kind::Arrow {
            self.path(PathKind::Port, &rest[last + 1..]);
            self.path(PathKind::TaskOrService, &rest[last + 1..]);
            self.path(PathKind::Codel, &rest[last + 1..]);
        } else if !self.path(PathKind::Output, &rest[last + 1..]) {
            self.words(&["via"]);
        }
    }

    /// Adds whole paths of the expected kind. Returns true if this is a place for a path.
    pub(super) fn path(&mut self, wanted: PathKind, rest: &[&Token]) -> bool {
        let Some((0, path)) = self.written(rest) else {
            return false;
        };
        if let Some(first) = path.names.first() {
            self.replace.start = first.range.start;
        }
        let before = if path.names.is_empty() { String::new() } else { path.text() + "." };
        for (label, target) in self.paths(wanted) {
            if label.starts_with(&before) {
                self.push(label, &target);
            }
        }
        true
    }

    pub(super) fn push(&mut self, label: String, target: &Target) {
        let (form, meaning) = self.names.describe(target);
        let kind = match target {
            Target::Component(_) => CompletionKind::Component,
            Target::Task(..) => CompletionKind::Task,
            Target::Service(..) => CompletionKind::Service,
            Target::Port(..) | Target::Member(..) => CompletionKind::Port,
            Target::State(..) | Target::Codel(..) => CompletionKind::Codel,
            Target::Client(_) | Target::Step(..) => CompletionKind::Client,
            Target::Status(_) => CompletionKind::Status,
        };
        let detail = match target {
            Target::Status(_) => meaning,
            _ => format!("{form}: {meaning}"),
        };
        self.items.push(Completion { label, kind, detail });
    }

    fn paths(&self, wanted: PathKind) -> Vec<(String, Target)> {
        let mut out = Vec::new();
        for (component, target) in self.names.after(None) {
            for (name, member) in self.names.after(Some(&target)) {
                let path = format!("{component}.{name}");
                let fits = match (wanted, &member) {
                    (
                        PathKind::Task | PathKind::TaskOrService | PathKind::TaskOrActivity,
                        Target::Task(..),
                    )
                    | (PathKind::Service | PathKind::TaskOrService, Target::Service(..)) => true,
                    (PathKind::TaskOrActivity | PathKind::Activity, &Target::Service(c, s)) => {
                        self.names.is_activity(c, s)
                    }
                    (PathKind::Port, Target::Port(..)) => true,
                    (PathKind::Input | PathKind::Output, &Target::Port(c, p)) => {
                        let port = &self.names.components[c].component.ports[p];
                        (port.dir == PortDir::In) == (wanted == PathKind::Input)
                    }
                    (PathKind::Codel, Target::Task(..) | Target::Service(..)) => {
                        let codels = self.names.after(Some(&member)).into_iter();
                        out.extend(codels.map(|(state, codel)| (format!("{path}.{state}"), codel)));
                        false
                    }
                    _ => false,
                };
                if fits {
                    out.push((path, member));
                }
            }
        }
        out
    }

    /// Adds one name of a predicate's path at a time, with statuses, clients and the words between, among
    /// them `more` of the check. Every place is one for a predicate, so it returns true.
    pub(super) fn predicate(&mut self, rest: &[&Token], more: &[&'static str]) -> bool {
        let after_operand = rest.last().is_some_and(|token| match token.kind {
            Kind::CloseParen => true,
            Kind::Name => {
                let word = word(self.text, Some(token));
                !matches!(word, "and" | "or" | "not" | "leave" | "precedes" | "after" | "until")
                    && !more.contains(&word)
            }
            _ => false,
        });
        if after_operand {
            let operators = self.operand(rest).and_then(|target| self.operators(&target));
            if let Some(operators) = operators {
                self.words(operators);
            } else {
                self.words(&["and", "or"]);
                self.words(more);
            }
            return true;
        }
        let path = self.written(rest).map(|(_, path)| path).unwrap_or_default();
        if path.names.is_empty() {
            for (label, target) in self.names.after(None) {
                self.push(label, &target);
            }
            for client in self.clients() {
                let target = Target::Client(client.name.value.clone());
                self.push(client.name.value.clone(), &target);
            }
            self.words(&["not", "leave"]);
            return true;
        }
        let targets = self.names.follow(&path);
        if targets.len() == path.names.len() {
            let target = targets.last();
            for (label, target) in self.names.after(target) {
                // Outputs have data to compare.
                let is_input = matches!(target, Target::Port(c, p)
                    if self.names.components[c].component.ports[p].dir == PortDir::In);
                let is_data = matches!(target, Target::Port(..) | Target::Member(..));
                let has_value = self.operators(&target).is_some()
                    || !self.names.after(Some(&target)).is_empty();
                if !is_input && (!is_data || has_value) {
                    self.push(label, &target);
                }
            }
            for status in statuses(target) {
                self.push((*status).to_owned(), &Target::Status((*status).to_owned()));
            }
        } else if let [name] = path.names.as_slice() {
            let client = self.clients().find(|client| client.name.value == name.value);
            for label in client.into_iter().flat_map(|client| steps(&client.steps)) {
                let target = Target::Step(name.value.clone(), label.to_owned());
                self.push(label.to_owned(), &target);
            }
        }
        true
    }

    /// Returns the target of the path that the tokens end in.
    fn operand(&self, rest: &[&Token]) -> Option<Target> {
        let (last, before) = rest.split_last()?;
        let mut path = self.written(before)?.1;
        let value = word(self.text, Some(last)).to_owned();
        path.names.push(Spanned { value, range: last.range.clone() });
        let mut targets = self.names.follow(&path);
        targets.pop().filter(|_| targets.len() + 1 == path.names.len())
    }

    /// Returns the operators that compare the data of a target; `None` if it has none to compare.
    fn operators(&self, target: &Target) -> Option<&'static [&'static str]> {
        let (&Target::Port(c, _) | &Target::Member(c, ..)) = target else { return None };
        let spec = self.names.components[c].spec;
        let ty = spec.resolve_alias(self.names.data_type(target)?);
        match &spec.ty(ty).kind {
            TypeKind::Boolean | TypeKind::Enum { .. } => Some(&["==", "!="]),
            kind if kind.is_number() => Some(&["==", "!=", "<", "<=", ">", ">="]),
            _ => None,
        }
    }

    pub(super) fn clients(&self) -> impl Iterator<Item = &'f Client> + use<'f> {
        self.scenario.items.iter().filter_map(|item| match item {
            Item::Client(client) => Some(client),
            _ => None,
        })
    }
}

fn statuses(target: Option<&Target>) -> &'static [&'static str] {
    match target {
        Some(Target::Component(_)) => &["idle"],
        Some(Target::Task(..)) => &["idle", "waiting", "running", "tick"],
        Some(Target::Service(..)) => &["waiting", "run", "stop", "void", "lock", "exec"],
        Some(Target::State(..) | Target::Codel(..)) => &["lock", "exec"],
        _ => &[],
    }
}

fn steps(list: &[Step]) -> BTreeSet<&str> {
    let names = Step::all(list).into_iter().filter_map(|step| match (&step.label, &step.kind) {
        (Some(label), _) => Some(&*label.value),
        (None, StepKind::Send(path)) => path.names.last().map(|name| &*name.value),
        _ => None,
    });
    names.collect()
}
