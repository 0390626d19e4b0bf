//! On the first line of an included file: the root in whose unit it is shown.

use super::{FileView, Hover, RangeInfo};
use crate::unit::roots_of;

/// Maximum number of roots in the list.
const MAX_ROOTS: usize = 8;

pub(crate) fn hover(view: &FileView<'_>, at: usize) -> Option<RangeInfo<Hover>> {
    let text = view.text();
    let end = text.find(['\n', '\r']).unwrap_or(text.len());
    let roots = roots_of(view.db, view.file);
    let (first, others) = roots.split_first()?;
    if at > end || *first == view.file {
        return None;
    }
    let name = |file: &crate::base::SourceFile| {
        let path = file.path(view.db);
        crate::markdown::code(path.file_name().unwrap_or(path.as_str()))
    };
    let mut markdown = format!("Analysed as included by {}.", name(first));
    if !others.is_empty() {
        let mut names: Vec<String> = others.iter().take(MAX_ROOTS).map(name).collect();
        if others.len() > MAX_ROOTS {
            names.push(format!("{} more", others.len() - MAX_ROOTS));
        }
        markdown += &format!(
            "\n\nAlso included by {}: the command *dotgen.chooseRoot* changes the choice.",
            names.join(", ")
        );
    }
    Some(RangeInfo { range: 0..end, info: Hover { markdown, codels: Vec::new() } })
}

#[cfg(test)]
mod tests {
    use crate::{host::Change, ide::FilePosition, test_support::Fixture};

    #[test]
    fn the_choice_is_shown_and_can_be_changed() {
        let mut fixture = Fixture::new(
            "//- /a.gen\n#define T long\n#include \"t.idl\"\n//- /b.gen\n#define T short\n#include \"t.idl\"\n//- /t.idl\n// shared\ntypedef T t;\n",
        );
        let at = |offset| FilePosition { path: "/t.idl".into(), offset };
        let markdown = |fixture: &Fixture, offset| {
            let hover = fixture.analysis().hover(&at(offset)).unwrap();
            hover.map_or_else(String::new, |hover| hover.info.markdown)
        };
        let first = markdown(&fixture, 0);
        assert!(first.contains("included by `a.gen`.") && first.contains("`b.gen`"), "{first}");
        assert!(markdown(&fixture, 20).contains("long"));
        fixture.host.apply(Change {
            chosen: Some(vec![("/t.idl".into(), "/b.gen".into())]),
            active: Some("/a.gen".into()),
            ..Change::default()
        });
        let second = markdown(&fixture, 0);
        assert!(second.contains("included by `b.gen`."), "{second}");
        assert!(markdown(&fixture, 20).contains("short"));
        // A root is shown in its own unit.
        let root = FilePosition { path: "/a.gen".into(), offset: 3 };
        assert_eq!(fixture.analysis().hover(&root).unwrap(), None);
    }
}
