//! Rules of taste, off by default.

use crate::finding::lints::{LateCodels, LintWarning, ListedNames};
use crate::finding::role::Role;
use crate::model::{ComponentKind, Name, Src};

use super::Lint;

pub(super) fn check(lint: &mut Lint) {
    missing_doc(lint);
    naming(lint);
    ordering(lint);
}

/// `style/missing-doc`
fn missing_doc(lint: &mut Lint) {
    let component = lint.component;
    let mut undocumented: Vec<(Src, &str, Name)> = Vec::new();
    if component.doc.is_none() && component.kind == ComponentKind::Component {
        undocumented.push((component.src, "component", component.name.clone()));
    }
    for service in
        component.services.iter().filter(|s| s.doc.is_none() && s.imported_from.is_none())
    {
        undocumented.push((service.src, "service", service.name.clone()));
    }
    for (at, what, name) in undocumented {
        lint.report(at, LintWarning::MissingDoc { what, name });
    }
}

/// `style/naming`: one convention for all services of a component, the most frequent one.
fn naming(lint: &mut Lint) {
    let style = |name: &str| -> Option<&'static str> {
        if name.contains('_') {
            Some("snake_case")
        } else if name.chars().next().is_some_and(char::is_uppercase) {
            Some("CamelCase")
        } else if name.chars().any(char::is_uppercase) {
            Some("camelCase")
        } else {
            None
        }
    };
    let services = || lint.component.services.iter().filter(|s| s.imported_from.is_none());
    let mut count: Vec<(&'static str, usize)> = Vec::new();
    for convention in services().filter_map(|s| style(&s.name)) {
        match count.iter_mut().find(|(c, _)| *c == convention) {
            Some((_, n)) => *n += 1,
            None => count.push((convention, 1)),
        }
    }
    let Some(&(main, most)) = count.iter().max_by_key(|(_, n)| *n) else {
        return;
    };
    let odd: Vec<(Src, Name)> = services()
        .filter(|s| style(&s.name).is_some_and(|c| c != main))
        .map(|s| (s.src, s.name.clone()))
        .collect();
    if most > odd.len() {
        for (at, name) in odd {
            lint.report(at, LintWarning::OddName { name, convention: main });
        }
    }
}

/// `style/order`: attributes, then functions, then activities.
fn ordering(lint: &mut Lint) {
    let mut highest = 0;
    let mut late: Vec<(Src, Name)> = Vec::new();
    for service in lint.component.services.iter().filter(|s| s.imported_from.is_none()) {
        let rank = service.kind as u32;
        if rank < highest {
            late.push((service.src, service.name.clone()));
        }
        highest = highest.max(rank);
    }
    if let Some((at, _)) = late.first().cloned() {
        let names = late.iter().map(|(_, n)| n.clone()).collect();
        let found = lint.report(at, LintWarning::OddOrder { late: LateCodels(ListedNames(names)) });
        found.related = late[1..].iter().map(|(src, n)| (*src, Role::Too(n.clone()))).collect();
    }
}
