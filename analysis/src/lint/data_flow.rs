//! Rules about readers and writers of ports and ids.

use crate::finding::role::Role;
use crate::model::{
    CodelKind, CodelRef, Name, Owner, ParamSource, PathElement, PortDir, PortId, ServiceId,
    ServiceKind, Src, TaskId, TypeKind,
};

use super::Lint;
use super::locks::only_starts_or_stops;
use crate::finding::lints::{LintWarning, ListedNames};

/// An access to data by a codel or an attribute.
struct DataAccess {
    /// Member of the ids (`None`: the whole ids), or index of the port.
    what: AccessedData,
    reads: bool,
    writes: bool,
    at: Src,
    by: Accessor,
}

#[derive(Clone, PartialEq, Eq)]
enum AccessedData {
    Ids(Option<String>),
    Port(PortId),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Accessor {
    Codel(CodelRef),
    Attribute(ServiceId),
}

pub(super) fn check(lint: &mut Lint) {
    // A component that is only declared so far (without codels) uses nothing yet.
    if lint.component.all_codels().next().is_none() {
        return;
    }
    let uses = uses(lint);
    ports(lint, &uses);
    ids(lint, &uses);
}

fn uses(lint: &Lint) -> Vec<DataAccess> {
    let mut out = Vec::new();
    let component = lint.component;
    for codel in component.all_codels() {
        for param in &component.codel(codel).params {
            let what = match param.source {
                ParamSource::Ids => AccessedData::Ids(member(&param.path)),
                ParamSource::Port(port) => AccessedData::Port(port),
                _ => continue,
            };
            // `in` on an output port reads back the written value.
            let (reads, writes) = param.dir.flow();
            out.push(DataAccess { what, reads, writes, at: param.src, by: Accessor::Codel(codel) });
        }
    }
    for (i, service) in component.services.iter_enumerated() {
        if service.kind == ServiceKind::Attribute {
            for param in &service.params {
                // Relative to the ids: an `in` attribute sets, an `out` attribute gets.
                let (writes, reads) = param.dir.flow();
                let what = AccessedData::Ids(member(&param.path));
                out.push(DataAccess {
                    what,
                    reads,
                    writes,
                    at: param.src,
                    by: Accessor::Attribute(i),
                });
            }
        }
    }
    out
}

fn member(path: &[PathElement]) -> Option<String> {
    match path.first() {
        Some(PathElement::Member(name)) => Some(name.to_string()),
        _ => None,
    }
}

fn ports(lint: &mut Lint, uses: &[DataAccess]) {
    for (index, port) in lint.component.ports.iter_enumerated() {
        let of_port: Vec<&DataAccess> =
            uses.iter().filter(|u| u.what == AccessedData::Port(index)).collect();
        let name = &port.name;
        if port.dir == PortDir::In {
            if !of_port.iter().any(|u| u.reads) {
                lint.report(port.src, LintWarning::PortNeverRead { name: name.clone() });
            }
            continue;
        }
        let writers: Vec<&&DataAccess> = of_port.iter().filter(|u| u.writes).collect();
        if writers.is_empty() {
            lint.report(port.src, LintWarning::PortNeverWritten { name: name.clone() });
            continue;
        }
        let mut tasks: Vec<TaskId> = writers
            .iter()
            .filter_map(|u| match u.by {
                Accessor::Codel(codel) => lint.component.task_of(codel),
                Accessor::Attribute(_) => None,
            })
            .collect();
        tasks.sort_unstable();
        tasks.dedup();
        if tasks.len() > 1 {
            // The `start` and `stop` codels of tasks run before and after everything else.
            let steady: Vec<&&&DataAccess> = writers
                .iter()
                .filter(|u| !matches!(u.by, Accessor::Codel(codel) if only_starts_or_stops(lint, codel)))
                .collect();
            let mut racing: Vec<TaskId> = steady
                .iter()
                .filter_map(|u| {
                    if let Accessor::Codel(codel) = u.by {
                        lint.component.task_of(codel)
                    } else {
                        None
                    }
                })
                .collect();
            racing.sort_unstable();
            racing.dedup();
            if racing.len() < 2 {
                continue;
            }
            let names: Vec<Name> =
                racing.iter().map(|&t| lint.component.tasks[t].name.clone()).collect();
            let related: Vec<(Src, Role)> = steady
                .iter()
                .filter_map(|u| match u.by {
                    Accessor::Codel(codel) => Some((u.at, Role::WrittenBy(lint.codel_name(codel)))),
                    Accessor::Attribute(_) => None,
                })
                .collect();
            let found = lint.report(
                port.src,
                LintWarning::WriteRace { name: name.clone(), tasks: ListedNames(names) },
            );
            found.related = related;
        }
    }
}

fn ids(lint: &mut Lint, uses: &[DataAccess]) {
    let Some(ids) = lint.component.ids else {
        return;
    };
    let TypeKind::Struct { members } = &lint.spec.ty(ids).kind else {
        return;
    };
    for &id in members {
        let ty = lint.spec.ty(id);
        let Some(name) = &ty.name else { continue };
        let touches = |u: &&DataAccess| match &u.what {
            AccessedData::Ids(None) => true,
            AccessedData::Ids(Some(member)) => member == name.as_str(),
            AccessedData::Port(_) => false,
        };
        let of_member: Vec<&DataAccess> = uses.iter().filter(touches).collect();
        let named = of_member.iter().any(|u| matches!(u.what, AccessedData::Ids(Some(_))));
        let reads = of_member.iter().any(|u| u.reads);
        let writes = of_member.iter().any(|u| u.writes);
        if !reads && !writes {
            lint.report(ty.src, LintWarning::MemberUnused { name: name.clone() });
        } else if !writes {
            lint.report(ty.src, LintWarning::MemberNeverWritten { name: name.clone() });
        } else if !reads && named {
            lint.report(ty.src, LintWarning::MemberNeverRead { name: name.clone() });
        } else {
            read_before_write(lint, name, &of_member);
        }
    }
}

/// `ids/read-before-write`: after the start of the component, a codel can read a member that only later
/// requests set.
fn read_before_write(lint: &mut Lint, name: &Name, uses: &[&DataAccess]) {
    let starts = |by: Accessor| match by {
        Accessor::Codel(codel @ CodelRef { owner: Owner::Task(_), .. }) => {
            lint.codel(codel).triggers.iter().any(|s| s.name == "start")
        }
        _ => false,
    };
    if uses.iter().any(|u| u.writes && starts(u.by)) {
        return;
    }
    // Permanent activities run without requests; services run on request, perhaps after the one that sets the
    // member. So only permanent activities certainly can run first.
    let reader = uses.iter().find(|u| {
        u.reads
            && !u.writes
            && matches!(u.by, Accessor::Codel(CodelRef { owner: Owner::Task(_), .. }))
    });
    let permanent_writer = uses.iter().any(|u| {
        u.writes && matches!(u.by, Accessor::Codel(CodelRef { owner: Owner::Task(_), .. }))
    });
    if permanent_writer {
        return;
    }
    let Some((reader, Accessor::Codel(names))) = reader.map(|r| (r, r.by)) else {
        return;
    };
    let writers: Vec<(Src, Role)> = uses
        .iter()
        .filter(|u| u.writes)
        .map(|u| match u.by {
            Accessor::Codel(codel) => (u.at, Role::WrittenBy(lint.codel_name(codel))),
            Accessor::Attribute(i) => (u.at, Role::SetBy(lint.owner_name(Owner::Service(i)))),
        })
        .collect();
    debug_assert!(lint.codel(names).kind == CodelKind::Fsm);
    let codel = lint.codel_name(names);
    let found = lint.report(reader.at, LintWarning::ReadBeforeWrite { codel, name: name.clone() });
    found.related = writers;
}
