//! Rules about services.

use typed_index_collections::{TiVec, ti_vec};

use crate::finding::role::Role;
use crate::model::{CodelKind, ParamDir, ParamSource, ServiceId, ServiceKind, Src};

use super::Lint;
use super::timing::control_task_time;
use crate::finding::lints::{CyclePath, LintWarning, Time};

pub(super) fn check(lint: &mut Lint) {
    for index in lint.component.services.keys() {
        interrupts_nothing(lint, index);
        blind_validate(lint, index);
        long_function(lint, index);
    }
    order_cycles(lint);
}

/// `service/concurrent-instances`: an activity that may run twice at the same time and changes data.
fn interrupts_nothing(lint: &mut Lint, index: ServiceId) {
    let service = &lint.component.services[index];
    let list = &service.interrupts;
    if service.kind != ServiceKind::Activity || list.all || list.services.contains(&index) {
        return;
    }
    let pauses = service.codels.iter().flat_map(|c| &c.yields).any(|s| s.paused);
    let writes = service.codels.iter().flat_map(|c| &c.params).find(|p| {
        matches!(p.dir, ParamDir::Out | ParamDir::Inout)
            && matches!(p.source, ParamSource::Ids | ParamSource::Port(_))
    });
    if let Some(param) = writes.filter(|_| pauses) {
        let (name, at, param_name, param_src) =
            (&service.name, service.src, &param.name, param.src);
        let found = lint.report(
            at,
            LintWarning::ConcurrentInstances { name: name.clone(), param: param_name.clone() },
        );
        found.related.push((param_src, Role::Written));
    }
}

/// `service/blind-validate`: a validate codel of a setter that does not get the value to set.
fn blind_validate(lint: &mut Lint, index: ServiceId) {
    let service = &lint.component.services[index];
    let sets = service.params.iter().any(|p| matches!(p.dir, ParamDir::In | ParamDir::Inout));
    if service.kind != ServiceKind::Attribute || !sets {
        return;
    }
    let component = lint.component;
    for codel in component.services[index].codels.iter().filter(|c| c.kind == CodelKind::Validate) {
        if codel.params.is_empty()
            || codel.params.iter().any(|p| matches!(p.source, ParamSource::Local(_)))
        {
            continue;
        }
        let value = &service.params[0].name;
        let found = lint.report(
            codel.src,
            LintWarning::BlindValidate {
                codel: codel.name.clone(),
                attribute: service.name.clone(),
                value: value.clone(),
            },
        );
        found.related = codel.params.iter().map(|p| (p.src, Role::OldValue)).collect();
    }
}

/// `service/long-function`: the control task delays every other request while it executes a function.
fn long_function(lint: &mut Lint, index: ServiceId) {
    let Some(time) =
        control_task_time(lint, index).filter(|t| *t > lint.config.control_task_budget)
    else {
        return;
    };
    let service = &lint.component.services[index];
    let budget = lint.config.control_task_budget;
    lint.report(
        service.src,
        LintWarning::LongFunction {
            name: service.name.clone(),
            time: Time(time),
            budget: Time(budget),
        },
    );
}

/// `service/order-cycle`: `before` and `after` that no order can satisfy.
fn order_cycles(lint: &mut Lint) {
    let services = &lint.component.services;
    // Edge: the first must come before the second.
    let mut next: TiVec<ServiceId, Vec<ServiceId>> = ti_vec![Vec::new(); services.len()];
    for (i, service) in services.iter_enumerated() {
        for &later in &service.before.services {
            next[i].push(later);
        }
        for &earlier in &service.after.services {
            next[earlier].push(i);
        }
    }
    let none: TiVec<ServiceId, bool> = ti_vec![false; services.len()];
    let mut reported = none.clone();
    for start in services.keys() {
        let mut path = Vec::new();
        if reported[start] || !find_cycle(&next, start, start, &mut none.clone(), &mut path) {
            continue;
        }
        for &i in &path {
            reported[i] = true;
        }
        let round = CyclePath(path.iter().map(|&i| services[i].name.clone()).collect());
        let related: Vec<(Src, Role)> = path[1..]
            .iter()
            .map(|&i| (services[i].src, Role::InCircle(services[i].name.clone())))
            .collect();
        let found = lint.report(services[start].src, LintWarning::OrderCycle { round });
        found.related = related;
    }
}

/// A path from `at` back to `goal`, its vertices in `path`.
fn find_cycle(
    next: &TiVec<ServiceId, Vec<ServiceId>>,
    at: ServiceId,
    goal: ServiceId,
    seen: &mut TiVec<ServiceId, bool>,
    path: &mut Vec<ServiceId>,
) -> bool {
    path.push(at);
    for &to in &next[at] {
        if to == goal {
            return true;
        }
        if !std::mem::replace(&mut seen[to], true) && find_cycle(next, to, goal, seen, path) {
            return true;
        }
    }
    path.pop();
    false
}
