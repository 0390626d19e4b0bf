//! The languages of the files of a project.

use camino::Utf8Path;

/// Extension of specifications that are compiled on their own. Files that they include have other ones, too.
pub const SPECIFICATION: &str = "gen";

/// Extension of scenarios.
pub const SCENARIO: &str = "scn";

/// Extensions of headers in C and C++.
pub const HEADERS: [&str; 4] = ["h", "hh", "hpp", "hxx"];

/// A language of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Language {
    /// Specifications, and the files that they include.
    Specification,
    /// Scenarios of the verifier.
    Scenario,
    /// C and C++ sources of codels.
    Codel,
    /// Templates: scripts, and the sources that they fill in.
    Template,
}

impl Language {
    /// Returns the language of a file by its name; `None` if the name does not say it. A header (`.h`) may
    /// belong to a specification or to codels, and most files of a template are known by their folder only.
    pub fn of(path: &Utf8Path) -> Option<Language> {
        match path.extension()? {
            SPECIFICATION | "idl" => Some(Language::Specification),
            SCENARIO => Some(Language::Scenario),
            "c" | "cc" | "cpp" | "cxx" => Some(Language::Codel),
            "tcl" => Some(Language::Template),
            _ => None,
        }
    }
}

/// Returns true if a file is a specification that is compiled on its own, by its name.
pub fn is_specification(path: &Utf8Path) -> bool {
    path.extension() == Some(SPECIFICATION)
}

/// Returns true if a file is a scenario, by its name.
pub fn is_scenario(path: &Utf8Path) -> bool {
    Language::of(path) == Some(Language::Scenario)
}

/// Returns true if a file is a header in C or C++, by its name.
pub fn is_header(path: &Utf8Path) -> bool {
    path.extension().is_some_and(|extension| HEADERS.contains(&extension))
}
