//! The mentions, in one file, of the name under the cursor.

use std::cmp::Reverse;

use dotgen_syntax::TextRange;

use super::{
    AccessKind, FileView, Highlight,
    document_links::include_target,
    resolve::{Target, nav_target, occurrences, targets_at},
};
use crate::source_map::{bytes, text_range};

pub(crate) fn highlights(view: &FileView<'_>, at: usize) -> Vec<Highlight> {
    let Some((_, targets)) = targets_at(view, at) else {
        return Vec::new();
    };
    let mut found: Vec<(TextRange, AccessKind)> = Vec::new();
    for target in &targets {
        match target {
            Target::Definition(id) => {
                let all = occurrences(view.db, view.unit, view.file).iter();
                let same = all.filter(|occurrence| occurrence.target == *id);
                found.extend(same.map(|occurrence| (occurrence.range, occurrence.access)));
            }
            Target::Macro(name, site) => {
                let uses = view.pre().macro_uses.iter();
                let same = uses.filter(|usage| usage.name == *name && usage.site == *site);
                found.extend(same.map(|usage| (usage.range, AccessKind::Mention)));
                let definition = nav_target(view, target);
                let here =
                    definition.filter(|definition| definition.path == *view.file.path(view.db));
                found.extend(here.map(|definition| {
                    (text_range(&definition.focus_range), AccessKind::Declaration)
                }));
            }
            Target::File(file) => {
                let includes = view.pre().includes.iter().enumerate();
                let same = includes.filter(|(i, _)| include_target(view, *i) == Some(*file));
                found.extend(same.map(|(_, include)| (include.range, AccessKind::Mention)));
            }
        }
    }
    // For a name that is both declared and used, the use is more informative.
    found.sort_by_key(|&(range, access)| (range.start(), range.end(), Reverse(access)));
    found.dedup_by_key(|(range, _)| *range);
    found.into_iter().map(|(range, access)| Highlight { range: bytes(range), access }).collect()
}

#[cfg(test)]
mod tests {
    use crate::test_support::{Fixture, annotations};

    #[track_caller]
    fn check(text: &str) {
        let fixture = Fixture::new(text);
        let path = fixture.at().path;
        let found = fixture.analysis().highlights(&fixture.at()).unwrap();
        let found: Vec<_> = found
            .into_iter()
            .map(|highlight| (highlight.range, format!("{:?}", highlight.access)))
            .collect();
        let mut wanted = annotations(&fixture.text(path.as_str()));
        wanted.sort_by_key(|annotation| annotation.0.start);
        assert_eq!(found, wanted, "{}", fixture.all_diagnostics());
    }

    #[test]
    fn names() {
        check(
            "
component c {
  ids { long v; };
  //         ^ Declaration
  task t {
    codel<start> f(ids in v$0, ids out w) yield ether;
    //                    ^ Read
    codel<stop> g(ids out v) yield ether;
    //                    ^ Write
  };
};
",
        );
    }

    #[test]
    fn in_this_file_only() {
        check(
            "
//- /a.gen
#include \"t.idl\"
typedef t$0 u;
//      ^ Mention
//- /t.idl
typedef long t;
",
        );
    }

    #[test]
    fn macros_and_files() {
        check(
            "
#define N 3
//      ^ Declaration
#ifdef N$0
//     ^ Mention
const long a = N;
//             ^ Mention
#endif
",
        );
        check(
            "
//- /a.gen
#include \"t$0.idl\"
//       ^^^^^^^ Mention
#include \"t.idl\"
//       ^^^^^^^ Mention
//- /t.idl
",
        );
    }
}
