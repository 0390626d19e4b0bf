//! Links from include directives to the files they include.

use std::ops::Range;

use camino::Utf8PathBuf;
use dotgen_syntax::{TextRange, TextSize, finding::preprocessing::Preprocessing, packages};

use super::{DocumentLink, FileView};
use crate::{
    base::SourceFile,
    source_map::bytes,
    unit::{serving_visit, visits, walk_unit},
};

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

/// An `#include` whose file is not found, or not read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingInclude {
    /// The path between its delimiters.
    pub range: Range<usize>,
    /// That path as written.
    pub path: String,
    /// The searched directories, in order.
    pub searched: Vec<Utf8PathBuf>,
}

/// A `#pragma requires` whose packages are not found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingPackages {
    /// The range of the requirement, as marked by the diagnostic.
    pub range: Range<usize>,
    /// The names of the packages, without versions.
    pub names: Vec<String>,
}

/// The required packages of a file that are not found, by place.
pub(crate) fn missing_packages(view: &FileView<'_>) -> Vec<MissingPackages> {
    let unmet = |kind: &Preprocessing| match kind {
        Preprocessing::Unresolved { install, .. } => Some(install.0.clone()),
        _ => None,
    };
    let errors = view.pre().errors.iter();
    let found = errors.filter_map(|error| {
        let required = unmet(&error.kind)?;
        let names = required.iter().flat_map(|text| packages::names(text));
        Some(MissingPackages {
            range: bytes(error.range),
            names: names.map(str::to_owned).collect(),
        })
    });
    found.collect()
}

/// The directories in which the active include of an index was, or would be, searched, in order, in the unit
/// that serves the file.
pub(crate) fn searched(view: &FileView<'_>, ordinal: usize) -> Vec<Utf8PathBuf> {
    let include = view.pre().includes.get(ordinal);
    let Some(request) = include.and_then(|include| include.request.as_ref()) else {
        return Vec::new();
    };
    let Some((visit, _)) = serving_visit(view.db, view.unit, view.file) else {
        return Vec::new();
    };
    walk_unit(view.db, view.unit).places(view.db, visit, ordinal, request)
}

/// The includes of a file that are not found, by place.
pub(crate) fn missing_includes(view: &FileView<'_>) -> Vec<MissingInclude> {
    let includes = view.pre().includes.iter().enumerate();
    includes
        .filter(|(ordinal, _)| include_target(view, *ordinal).is_none())
        .filter_map(|(ordinal, include)| {
            let delimited = path_range(view.text(), include.range);
            let path = view.text().get(bytes(delimited))?.to_owned();
            // The name of a macro is not a path.
            (delimited != include.range).then(|| MissingInclude {
                range: bytes(delimited),
                path,
                searched: searched(view, ordinal),
            })
        })
        .collect()
}

/// The target of an active include.
pub(super) fn include_target(view: &FileView<'_>, ordinal: usize) -> Option<SourceFile> {
    let visits = visits(view.db, view.unit).all();
    let own = visits.iter().filter(|visit| visit.key == view.key);
    let mut targets = own.filter_map(|visit| visit.includes.get(ordinal).copied().flatten());
    Some(visits.get(targets.next()?)?.key.file(view.db))
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
    fn where_was_looked_grows_with_the_packages() {
        let fixture = Fixture::new(
            "//- /sub/main.gen
#include <a.idl>
#pragma requires \"pose-idl >= 1\"
#include \"a.idl\"
#pragma requires \"other-idl >= 2\", far
#include \"/b.idl\"
",
        );
        let flags = crate::host::PackageFlags {
            include_dirs: vec!["/pose".into()],
            ..crate::host::PackageFlags::default()
        };
        let mut packages = fixture.loader.packages.lock().unwrap();
        packages.insert("pose-idl >= 1".to_owned(), flags);
        drop(packages);
        let missing = fixture.analysis().missing_includes("/sub/main.gen".into());
        let missing = missing.unwrap();
        let searched: Vec<Vec<&str>> = missing
            .iter()
            .map(|include| include.searched.iter().map(|path| path.as_str()).collect())
            .collect();
        assert_eq!(searched, [vec![], vec!["/sub", "/pose"], vec!["/"]]);
        let packages = fixture.analysis().missing_packages("/sub/main.gen".into());
        let names: Vec<_> = packages.unwrap().into_iter().map(|package| package.names).collect();
        assert_eq!(names, [["other-idl", "far"]]);
    }

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
        let links = fixture.analysis().document_links("/main.gen".into()).unwrap();
        let text = fixture.text("/main.gen");
        let links: Vec<(&str, &str)> =
            links.iter().map(|link| (&text[link.range.clone()], link.target.as_str())).collect();
        assert_eq!(links, [("a.idl", "/a.idl"), ("HERE", "/b.idl")]);
    }
}
