//! Entities that already have the new name.

use crate::{
    base::Db,
    elab::DefKind,
    ide::{speculate::Comparison, view::place},
    unit::unit_of_root,
};

/// The entity that already has a name, its place, and advice; if it can clash with a `kind`.
pub(super) fn taken(
    db: &dyn Db,
    unit: &Comparison,
    kind: Option<DefKind>,
    name: &str,
) -> Option<String> {
    let kind = kind?;
    let rivals = unit.before.definitions.iter();
    let rivals = rivals.filter(|rival| rival.name == name && family(rival.kind) == family(kind));
    let found = rivals.min_by_key(|rival| rival.kind != kind)?;
    let (file, range) = place(db, unit_of_root(db, unit.root), found.src)?;
    let line = 1 + file.text(db)[..range.start().into()].matches('\n').count();
    let file = file.path(db).file_name().unwrap_or_default();
    let what = noun(found.kind);
    let why = match kind {
        DefKind::Codel => " and codels of one name are one function",
        _ => "",
    };
    Some(format!(
        "{what} has that name already ({file}, line {line}){why}; choose another name, or rename that one \
            first"
    ))
}

/// The family of a kind: names of one family clash with each other.
fn family(kind: DefKind) -> u8 {
    match kind {
        DefKind::Codel => 0,
        DefKind::State => 1,
        DefKind::Task => 2,
        DefKind::Attribute | DefKind::Function | DefKind::Activity => 3,
        DefKind::Member => 4,
        DefKind::IdsMember
        | DefKind::Port
        | DefKind::Parameter
        | DefKind::Local
        | DefKind::CodelParameter => 5,
        _ => 6,
    }
}

fn noun(kind: DefKind) -> &'static str {
    match kind {
        DefKind::Module => "a module",
        DefKind::Component => "a component",
        DefKind::Interface => "an interface",
        DefKind::Typedef | DefKind::Native => "a type",
        DefKind::Struct => "a struct",
        DefKind::Union => "a union",
        DefKind::Enum => "an enum",
        DefKind::Enumerator => "an enumerator",
        DefKind::Member => "a member",
        DefKind::IdsMember => "a member of the ids",
        DefKind::Exception => "an exception",
        DefKind::Const => "a constant",
        DefKind::Ids => "the ids",
        DefKind::Task => "a task",
        DefKind::Port => "a port",
        DefKind::Attribute => "an attribute",
        DefKind::Function => "a function",
        DefKind::Activity => "an activity",
        DefKind::Parameter | DefKind::CodelParameter => "a parameter",
        DefKind::Local => "a local variable",
        DefKind::Codel => "a codel",
        DefKind::State => "a state",
    }
}
