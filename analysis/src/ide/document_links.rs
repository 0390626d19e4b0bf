//! Links from include directives to the files they include.

use std::ops::Range;

use dotgen_syntax::{TextRange, TextSize};

use super::{DocumentLink, FileView};
use crate::{base::SourceFile, source_map::bytes, unit::visits};

pub(crate) fn document_links(view: &FileView<'_>) -> Vec<DocumentLink> {
    let includes = view.pre().includes.iter().enumerate();
    includes
        .filter_map(|(ordinal, include)| {
            let target = include_target(view, ordinal)?;
            Some(DocumentLink {
                range: bytes(path_range(view.text(), include.range)),
                target: target.path(view.db).clone(),
            })
        })
        .collect()
}

/// An `#include` that leads nowhere, or that is not read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingInclude {
    /// The path between its delimiters.
    pub range: Range<usize>,
    /// That path as written.
    pub path: String,
}

/// The includes of a file that lead nowhere, by place.
pub(crate) fn missing_includes(view: &FileView<'_>) -> Vec<MissingInclude> {
    let includes = view.pre().includes.iter().enumerate();
    includes
        .filter(|(ordinal, _)| include_target(view, *ordinal).is_none())
        .filter_map(|(_, include)| {
            let delimited = path_range(view.text(), include.range);
            let path = view.text().get(bytes(delimited))?.to_owned();
            // The name of a macro is no path.
            (delimited != include.range).then(|| MissingInclude {
                range: bytes(delimited),
                path,
            })
        })
        .collect()
}

/// The file that an active include leads to.
pub(super) fn include_target(view: &FileView<'_>, ordinal: usize) -> Option<SourceFile> {
    let visits = &visits(view.db, view.unit).visits;
    let own = visits.iter().filter(|it| it.key == view.key);
    let mut targets = own.filter_map(|it| it.includes.get(ordinal).copied().flatten());
    Some(visits.get(targets.next()? as usize)?.key.file(view.db))
}

/// The path in an include operand, without its delimiters.
pub(super) fn path_range(text: &str, operand: TextRange) -> TextRange {
    let spelled = text.get(bytes(operand)).unwrap_or_default();
    let delimited = (spelled.starts_with('"') && spelled.ends_with('"'))
        || (spelled.starts_with('<') && spelled.ends_with('>'));
    if delimited && spelled.len() >= 2 {
        let one = TextSize::new(1);
        TextRange::new(operand.start() + one, operand.end() - one)
    } else {
        operand
    }
}

#[cfg(test)]
mod tests {
    use crate::test_support::Fixture;

    #[test]
    fn links_lead_to_the_included_files() {
        let fixture = Fixture::new(
            "
//- /main.gen
#define HERE \"b.idl\"
#include \"a.idl\"
#include HERE
#include \"none.idl\"
#if 0
#include \"c.idl\"
#endif
//- /a.idl
//- /b.idl
//- /c.idl
",
        );
        let links = fixture
            .analysis()
            .document_links("/main.gen".into())
            .unwrap();
        let text = fixture.text("/main.gen");
        let links: Vec<(&str, &str)> = links
            .iter()
            .map(|it| (&text[it.range.clone()], it.target.as_str()))
            .collect();
        assert_eq!(links, [("a.idl", "/a.idl"), ("HERE", "/b.idl")]);
    }
}
