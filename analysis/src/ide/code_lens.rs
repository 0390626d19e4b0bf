//! Lines above declarations: how often they are mentioned, their state machine, their load.
//!
//! Where the lenses are is cheap; what they say is worked out one by one when they become visible.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use smol_str::SmolStr;

use super::{AccessKind, FileRange, FileView, inlay_hints::is_machine, references::references};
use crate::{
    elab::{DefKind, Entity},
    model::Owner,
    quantity,
    source_map::bytes,
};

/// What a lens shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", tag = "kind")]
pub enum LensKind {
    /// Mentions of the name at an offset.
    References {
        /// Byte offset of the name.
        offset: usize,
    },
    /// The state machine of a task or activity.
    StateMachine {
        /// The component.
        component: SmolStr,
        /// The task or activity.
        owner: SmolStr,
    },
    /// The same, between the lines of the text.
    InlineMachine {
        /// The component.
        component: SmolStr,
        /// The task or activity.
        owner: SmolStr,
    },
    /// The load of a task.
    Load {
        /// The component.
        component: SmolStr,
        /// The task.
        task: SmolStr,
    },
}

/// A line above a declaration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodeLens {
    /// The name of the declaration.
    pub range: Range<usize>,
    /// What it shows.
    pub kind: LensKind,
}

/// What a lens says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LensText {
    /// The text.
    pub title: String,
    /// For references: where they are.
    pub references: Vec<FileRange>,
}

/// The lenses of a file, by place.
pub(crate) fn code_lenses(view: &FileView<'_>) -> Vec<CodeLens> {
    let elaborated = view.elaborated();
    let mut out = Vec::new();
    for it in &elaborated.definitions {
        use DefKind::*;
        if !matches!(
            it.kind,
            Component
                | Interface
                | Task
                | Port
                | Attribute
                | Function
                | Activity
                | Struct
                | Union
                | Enum
                | Exception
                | Typedef
                | Ids
        ) {
            continue;
        }
        let Some((file, place)) = view.place(it.src) else {
            continue;
        };
        let range = bytes(place);
        // Names that come out of macros have no line of their own.
        if file != view.file || it.kind != Ids && view.text().get(range.clone()) != Some(&it.name) {
            continue;
        }
        let mut push = |kind| {
            out.push(CodeLens {
                range: range.clone(),
                kind,
            });
        };
        push(LensKind::References {
            offset: range.start,
        });
        let (component, owner) = match it.entity {
            Some(Entity::Task(component, task)) => (component, Owner::Task(task)),
            Some(Entity::Service(component, service)) => (component, Owner::Service(service)),
            _ => continue,
        };
        let Some(component) = elaborated.spec.components.get(component as usize) else {
            continue;
        };
        if is_machine(component, owner) {
            push(LensKind::StateMachine {
                component: component.name.clone(),
                owner: it.name.clone(),
            });
            push(LensKind::InlineMachine {
                component: component.name.clone(),
                owner: it.name.clone(),
            });
        }
        if let Owner::Task(task) = owner
            && component.utilisation(task).is_some()
        {
            push(LensKind::Load {
                component: component.name.clone(),
                task: it.name.clone(),
            });
        }
    }
    out.sort_by_key(|it| it.range.start);
    out
}

/// What a lens of a file says; `None` if what it is about has gone.
pub(crate) fn resolve(view: &FileView<'_>, kind: &LensKind) -> Option<LensText> {
    let text = |title: String| {
        Some(LensText {
            title,
            references: Vec::new(),
        })
    };
    match kind {
        LensKind::References { offset } => {
            let mut found = references(view, *offset, true)?;
            found.retain(|it| it.access != AccessKind::Declaration);
            let plural = if found.len() == 1 { "" } else { "s" };
            Some(LensText {
                title: format!("{} reference{plural}", found.len()),
                references: found.into_iter().map(|it| it.place).collect(),
            })
        }
        LensKind::StateMachine { .. } => text("state machine".to_owned()),
        LensKind::InlineMachine { .. } => text("inline".to_owned()),
        LensKind::Load { component, task } => {
            let all = &view.elaborated().spec.components;
            let component = all.iter().find(|it| it.name == *component)?;
            let index = component.tasks.iter().position(|it| it.name == *task)?;
            let share = component.utilisation(index as u32)?;
            let period = component.tasks[index].period.as_ref()?;
            text(format!(
                "load {} of {}",
                quantity::load(share),
                crate::lint::duration(period.value)
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;
    use expect_test::expect;

    use crate::test_support::Fixture;

    #[test]
    fn lenses_and_what_they_say() {
        let fixture = Fixture::new(
            "struct s { long x; };
typedef s u;
component c {
  port in s p;
  task t { period 10 ms; codel<start> f(port in p) wcet 1 ms yield pause::start; };
  function g() { interrupt g; };
  activity a() { task t; codel<start> h() yield ether; };
};
",
        );
        let path = Utf8Path::new("/main.gen");
        let analysis = fixture.analysis();
        let text = fixture.text("/main.gen");
        let mut out = String::new();
        for it in analysis.code_lenses(path).unwrap() {
            let title = analysis
                .resolve_lens(path, &it.kind)
                .unwrap()
                .unwrap()
                .title;
            out += &format!("{}: {title}\n", &text[it.range]);
        }
        expect![[r#"
            s: 2 references
            u: 0 references
            c: 0 references
            p: 1 reference
            t: 1 reference
            t: state machine
            t: inline
            t: load 10 % of 10 ms
            g: 1 reference
            a: 0 references
            a: state machine
            a: inline
        "#]]
        .assert_eq(&out);
    }
}
