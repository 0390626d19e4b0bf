//! The outline of a scenario.

use std::ops::Range;

use super::ast::{CheckKind, Item, Scenario, Step};

/// An entry of the outline.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    pub name: String,
    pub kind: EntryKind,
    /// Range of the entry.
    pub range: Range<usize>,
    /// Range of the name.
    pub selection: Range<usize>,
    /// Nested entries.
    pub children: Vec<Entry>,
}

/// The kind of an [`Entry`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EntryKind {
    Scenario,
    /// A specification.
    File,
    Client,
    /// A step with a label.
    Step,
    Check,
}

/// Returns the outline: the scenario with its files, clients (and their labelled steps) and checks.
pub fn outline(text: &str, scenario: &Scenario) -> Vec<Entry> {
    if scenario.name.is_empty() {
        return Vec::new();
    }
    let mut children = Vec::new();
    for item in &scenario.items {
        match item {
            Item::Use(file) | Item::Times(file) | Item::Weights(file) => children.push(Entry {
                name: file.value.clone(),
                kind: EntryKind::File,
                range: file.range.clone(),
                selection: file.range.clone(),
                children: Vec::new(),
            }),
            Item::Client(client) => {
                let steps = Step::all(&client.steps).into_iter().filter_map(labelled).collect();
                let end = client.steps.last().map_or(0, |step| step.range.end);
                let name = client.name.range.clone();
                children.push(Entry {
                    name: client.name.value.clone(),
                    kind: EntryKind::Client,
                    range: name.start..end.max(name.end),
                    selection: name,
                    children: steps,
                });
            }
            Item::Check(check) => {
                let written = text.get(check.range.clone()).unwrap_or_default();
                let what: Vec<&str> = written.split_whitespace().collect();
                let whole = what.join(" ").trim_end_matches(';').to_owned();
                let name = check.name.as_ref();
                children.push(Entry {
                    name: name.map_or(whole, |name| name.value.clone()),
                    kind: EntryKind::Check,
                    range: check.range.clone(),
                    selection: name.map_or(check.range.clone(), |name| name.range.clone()),
                    children: Vec::new(),
                });
            }
            _ => {}
        }
    }
    let start = scenario.name_range.start;
    vec![Entry {
        name: scenario.name.clone(),
        kind: EntryKind::Scenario,
        range: start..text.len().max(start),
        selection: scenario.name_range.clone(),
        children,
    }]
}

/// Returns the entry of a step with a label.
fn labelled(step: &Step) -> Option<Entry> {
    let label = step.label.as_ref()?;
    Some(Entry {
        name: label.value.clone(),
        kind: EntryKind::Step,
        range: step.range.clone(),
        selection: label.range.clone(),
        children: Vec::new(),
    })
}

/// Returns true if a check is about all tasks.
pub fn is_of_all(kind: &CheckKind) -> bool {
    matches!(
        kind,
        CheckKind::Schedulable(None) | CheckKind::NoOverdue(None) | CheckKind::Response(None, _)
    )
}
