//! Every mention of a name, in every unit that sees its definition.

use dotgen_syntax::preproc::MacroSite;
use rustc_hash::FxHashSet;

use super::{
    AccessKind, FileRange, FileView, ReferenceAt,
    resolve::{
        Identity, Target, elaborated_of_many, find_identities, identity, nav_target, targets_at,
    },
    view::place,
};
use crate::{
    base::{Db, SourceFile},
    model::Src,
    parallel,
    source_map::bytes,
    unit::{UnitKey, preprocessed, roots_of, unit_of_root, visits},
};

/// Every mention of the name under the cursor, by file and place.
pub(crate) fn references(
    view: &FileView<'_>,
    at: usize,
    include_declaration: bool,
) -> Option<Vec<ReferenceAt>> {
    let (_, targets) = targets_at(view, at)?;
    let mut out = Vec::new();
    let identities: Vec<Identity> = targets
        .iter()
        .filter_map(|target| match target {
            Target::Definition(id) => identity(view.db, view.unit, *id),
            _ => None,
        })
        .collect();
    let mut roots: Vec<SourceFile> = view.unit.inputs(view.db).clone();
    let mut seen = roots.iter().copied().collect::<FxHashSet<_>>();
    let others = identities.iter().flat_map(|identity| roots_of(view.db, identity.file));
    roots.extend(others.copied().filter(|root| seen.insert(*root)));
    let found = parallel::over(view.db, &roots, |db, &root| {
        named(db, unit_of_root(db, root), &identities, roots.len())
    });
    out.extend(found.into_iter().flatten());
    for target in &targets {
        match target {
            Target::Macro(name, Some(site)) => {
                let home = nav_target(view, target).map(|target| view.db.file(&target.path));
                for_each_unit(view, home, |unit| macro_uses(view.db, unit, name, site, &mut out));
                out.extend(nav_target(view, target).map(|target| ReferenceAt {
                    place: FileRange { path: target.path, range: target.focus_range },
                    access: AccessKind::Declaration,
                }));
            }
            Target::File(file) => {
                for_each_unit(view, [*file], |unit| includes(view.db, unit, *file, &mut out));
            }
            _ => {}
        }
    }
    if !include_declaration {
        out.retain(|reference| reference.access != AccessKind::Declaration);
    }
    // For a name that is both declared and used, the use is more informative.
    let key = |reference: &ReferenceAt| {
        let place =
            (reference.place.path.clone(), reference.place.range.start, reference.place.range.end);
        (place, std::cmp::Reverse(reference.access))
    };
    out.sort_by_key(key);
    out.dedup_by(|a, b| a.place == b.place);
    Some(out)
}

/// Calls `f` for the unit of the view and every other unit that contains one of `files`.
pub(super) fn for_each_unit<'db>(
    view: &FileView<'db>,
    files: impl IntoIterator<Item = SourceFile>,
    mut f: impl FnMut(UnitKey<'db>),
) {
    let db = view.db;
    let mut seen = FxHashSet::from_iter([view.unit]);
    f(view.unit);
    for file in files {
        for &root in roots_of(db, file) {
            let unit = unit_of_root(db, root);
            if seen.insert(unit) {
                db.unwind_if_revision_cancelled();
                f(unit);
            }
        }
    }
}

/// The mentions in one of `count` units.
fn named(db: &dyn Db, unit: UnitKey<'_>, wanted: &[Identity], count: usize) -> Vec<ReferenceAt> {
    let elaborated = elaborated_of_many(db, unit, count);
    let ids = find_identities(db, unit, &elaborated, wanted);
    if ids.is_empty() {
        return Vec::new();
    }
    let at = |src: Src, access| {
        let (file, range) = place(db, unit, src)?;
        Some(ReferenceAt { place: file_range(db, file, range), access })
    };
    let declared = elaborated.definitions.iter();
    let declared = declared.filter(|definition| ids.contains(&definition.id));
    let declared = declared.filter_map(|definition| at(definition.src, AccessKind::Declaration));
    let used = elaborated.references.iter();
    let used = used.filter(|reference| ids.contains(&reference.target));
    let used = used.filter_map(|reference| at(reference.at, reference.access));
    declared.chain(used).collect()
}

fn macro_uses(
    db: &dyn Db,
    unit: UnitKey<'_>,
    name: &str,
    site: &MacroSite,
    out: &mut Vec<ReferenceAt>,
) {
    for visit in visits(db, unit).all() {
        for usage in &preprocessed(db, visit.key).macro_uses {
            if usage.name == name && usage.site.as_ref() == Some(site) {
                out.push(ReferenceAt {
                    place: file_range(db, visit.key.file(db), usage.range),
                    access: AccessKind::Mention,
                });
            }
        }
    }
}

fn includes(db: &dyn Db, unit: UnitKey<'_>, target: SourceFile, out: &mut Vec<ReferenceAt>) {
    let visits = visits(db, unit).all();
    for visit in visits {
        let all = std::iter::zip(&preprocessed(db, visit.key).includes, &visit.includes);
        for (include, leads_to) in all {
            let leads_to = leads_to.and_then(|lead| visits.get(lead));
            if leads_to.is_some_and(|lead| lead.key.file(db) == target) {
                out.push(ReferenceAt {
                    place: file_range(db, visit.key.file(db), include.range),
                    access: AccessKind::Mention,
                });
            }
        }
    }
}

fn file_range(db: &dyn Db, file: SourceFile, range: dotgen_syntax::TextRange) -> FileRange {
    FileRange { path: file.path(db).clone(), range: bytes(range) }
}

#[cfg(test)]
mod tests {
    use crate::test_support::{Fixture, annotations};

    /// Checks that the references are exactly the marked places, with the access of the label.
    #[track_caller]
    fn check(text: &str) {
        let fixture = Fixture::new(text);
        let found = fixture.analysis().references(&fixture.at(), true).unwrap();
        let mut found: Vec<String> = found
            .unwrap_or_default()
            .iter()
            .map(|reference| {
                format!(
                    "{}:{:?} {:?}",
                    reference.place.path, reference.place.range, reference.access
                )
            })
            .collect();
        found.sort();
        let mut wanted = Vec::new();
        for path in fixture.paths() {
            for (range, label) in annotations(&fixture.text(path.as_str())) {
                wanted.push(format!("{path}:{range:?} {label}"));
            }
        }
        wanted.sort();
        assert_eq!(found, wanted, "{}", fixture.all_diagnostics());
    }

    #[test]
    fn access_kinds() {
        check(
            "
component c {
  ids { long v; };
  //         ^ Declaration
  task t;
  attribute set(in v$0);
  //               ^ Write
  activity go() {
    task t;
    codel<start> f(ids in v) yield next;
    //                    ^ Read
    codel<next> g(ids inout v) yield ether;
    //                      ^ ReadWrite
  };
};
",
        );
    }

    #[test]
    fn across_units() {
        check(
            "
//- /a.gen
#include \"t.idl\"
typedef t a;
//      ^ Mention
//- /b.gen
#include \"t.idl\"
typedef sequence<t$0> b;
//               ^ Mention
//- /c.gen
typedef long t;
//- /t.idl
typedef long t;
//           ^ Declaration
",
        );
    }

    #[test]
    fn macros_and_files() {
        check(
            "
//- /a.gen
#include \"t.idl\"
const long a = N$0;
//             ^ Mention
//- /b.gen
#include \"t.idl\"
#ifdef N
//     ^ Mention
#endif
//- /t.idl
#define N 3
//      ^ Declaration
",
        );
        check(
            "
//- /a.gen
#include \"t$0.idl\"
//       ^^^^^^^ Mention
//- /b.gen
#include <none>
#include \"t.idl\"
//       ^^^^^^^ Mention
//- /t.idl
",
        );
    }

    #[test]
    fn arguments_of_macro_calls() {
        check(
            "
typedef long t$0;
//           ^ Declaration
#define PAIR(x) struct pair { x a; x b; }
PAIR(t);
//   ^ Mention
",
        );
    }

    #[test]
    fn several_declarations() {
        check(
            "
module m$0 { };
//     ^ Declaration
module m { typedef long t; };
//     ^ Declaration
typedef m::t u;
//      ^ Mention
",
        );
    }

    #[test]
    fn without_the_declaration() {
        let fixture = Fixture::new("typedef long t$0;\ntypedef t u;\n");
        let found = fixture.analysis().references(&fixture.at(), false).unwrap().unwrap();
        assert_eq!(found.len(), 1);
    }
}
