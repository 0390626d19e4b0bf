//! Releases of GenoM3, and all differences between them.
//!
//! A [`Release`] is a version number, ordered as versions are. The changes between releases are one table,
//! [`CHANGES`]: each line has the name of the change and its first release. Code calls [`Release::has`] with
//! the name; nothing else compares version numbers. `docs/releases.md` shows the table to users.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A release of GenoM3. The default is the newest one that dotgen was compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Release {
    major: u16,
    minor: u16,
    patch: u16,
}

impl Release {
    /// The oldest release whose differences are known; older ones are read as this one.
    pub const V2_99_39: Release = Release::new(2, 99, 39);
    /// A stack size for a whole component, bounded sequences that can be assigned in C.
    pub const V2_99_40: Release = Release::new(2, 99, 40);
    /// The newest release that dotgen was compared with.
    pub const V2_99_41: Release = Release::new(2, 99, 41);
    /// Known by its list of changes only.
    pub const V2_99_42: Release = Release::new(2, 99, 42);
    /// Known by its list of changes only.
    pub const V2_99_43: Release = Release::new(2, 99, 43);
    /// Known by its list of changes only.
    pub const V2_99_44: Release = Release::new(2, 99, 44);
    /// Known by its list of changes only.
    pub const V2_99_45: Release = Release::new(2, 99, 45);
    /// The first of the third series; known by its generated code. Its list of changes ends with 2.99.45.
    pub const V3: Release = Release::new(3, 0, 0);

    /// The oldest release that dotgen knows.
    pub const OLDEST: Release = Release::V2_99_39;

    const fn new(major: u16, minor: u16, patch: u16) -> Release {
        Release { major, minor, patch }
    }

    /// Returns true if the behaviour of this release was compared with dotgen, run by run. Statements about
    /// the others follow from their lists of changes and from their generated code.
    pub fn is_verified(self) -> bool {
        matches!(self, Release::V2_99_39 | Release::V2_99_41)
    }

    /// Returns true if a change is part of this release.
    pub fn has(self, change: Change) -> bool {
        self >= change.since()
    }

    /// The least release that a requirement on the package `genom3` admits: `genom3 >= 2.99.41`. `None` if
    /// the text requires something else, or has no lower bound.
    pub fn lower_bound(requirement: &str) -> Option<Release> {
        let rest = requirement.trim_start().strip_prefix("genom3")?;
        let rest = rest.trim_start();
        let operator = rest.len() - rest.trim_start_matches(['>', '=']).len();
        let release: Release = rest[operator..].trim().parse().ok()?;
        match &rest[..operator] {
            ">=" | "=" | "==" => Some(release),
            ">" => Some(Release { patch: release.patch.saturating_add(1), ..release }),
            _ => None,
        }
    }
}

impl Default for Release {
    fn default() -> Release {
        Release::V2_99_41
    }
}

impl fmt::Display for Release {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)?;
        // The second series counts in its third number, also where that is 0.
        if self.patch != 0 || self.major < 3 {
            write!(f, ".{}", self.patch)?;
        }
        Ok(())
    }
}

/// The error for a text that is not the number of a release.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoRelease(String);

impl fmt::Display for NoRelease {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = &self.0;
        write!(f, "`{text}` is not a release of GenoM3: expected a number such as 2.99.41 or 3.1")
    }
}

impl std::error::Error for NoRelease {}

impl FromStr for Release {
    type Err = NoRelease;

    /// Reads two or three numbers separated by points.
    fn from_str(text: &str) -> Result<Release, NoRelease> {
        let fail = || NoRelease(text.to_owned());
        let mut numbers = text.trim().split('.').map(|part| {
            let digits = part.bytes().all(|byte| byte.is_ascii_digit());
            digits.then(|| part.parse::<u16>().ok()).flatten()
        });
        let mut number = || numbers.next().map(|number| number.ok_or_else(fail)).transpose();
        let (major, minor, patch) = (number()?, number()?, number()?);
        match (major, minor, numbers.next()) {
            (Some(major), Some(minor), None) => {
                Ok(Release::new(major, minor, patch.unwrap_or_default()))
            }
            _ => Err(fail()),
        }
    }
}

impl Serialize for Release {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Release {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Release, D::Error> {
        let text = String::deserialize(from)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

/// The parts of GenoM3 that change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Area {
    /// The accepted texts.
    Language,
    /// The meaning of a specification.
    Model,
    /// The C and C++ mapping.
    Mapping,
    /// Digests, which clients use to check compatibility.
    Digest,
    /// The templates that come with GenoM3.
    Templates,
}

impl Area {
    /// The name of the area in the manual's table.
    pub fn name(self) -> &'static str {
        match self {
            Area::Language => "language",
            Area::Model => "model",
            Area::Mapping => "mapping",
            Area::Digest => "digest",
            Area::Templates => "templates",
        }
    }
}

/// A line of the table of changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// The name in code.
    pub change: Change,
    /// The first release that has it.
    pub since: Release,
    /// The part that changes.
    pub area: Area,
    /// The behaviour before the change, and after it.
    pub what: &'static str,
}

/// Generates the names of the changes and the table from the same lines.
macro_rules! changes {
    ($($name:ident: $since:ident, $area:ident, $what:literal;)*) => {
        /// The changes between releases, by name; [`CHANGES`] describes each.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Change {
            $(#[doc = $what] $name,)*
        }

        /// All differences between releases that dotgen knows, oldest first.
        pub const CHANGES: &[Entry] = &[
            $(Entry {
                change: Change::$name,
                since: Release::$since,
                area: Area::$area,
                what: $what,
            },)*
        ];

        impl Change {
            /// The first release that has it.
            pub fn since(self) -> Release {
                match self {
                    $(Change::$name => Release::$since,)*
                }
            }
        }
    };
}

changes! {
    ComponentStack: V2_99_40, Language,
        "`stack` may be given for a component or interface, once";
    MutableBoundedSequences: V2_99_40, Mapping,
        "`_maximum` of a bounded sequence is not `const` in C, and C++ code gets no constructor with it";
    AttributeCodels: V2_99_41, Language,
        "attributes may have simple codels";
    MergedProperties: V2_99_41, Language,
        "`version`, `email`, an equal `lang` and the `task` of an activity may be repeated, the first counts; lists of \
         `codels-require` are joined";
    SpecialParameterTypes: V2_99_41, Language,
        "parameters and local variables of services cannot be ports, remotes or events";
    OpaqueInitializers: V2_99_41, Language,
        "a default value for a native, `any` or exception is one error instead of two";
    InterfaceDefaults: V2_99_41, Model,
        "interfaces have the language \"c\" and the version \"0\" by default, set at the end of every parse";
    ProvidedPortTypes: V2_99_41, Mapping,
        "a port provided through an interface has the interface's type, and the component an alias of it";
    PortManglings: V2_99_41, Mapping,
        "mangled names of port types are different for different ports";
    ReopenedTaskPlaces: V2_99_41, Model,
        "the place of a task that is declared again is that of the last declaration";
    ContextsOfPlaces: V2_99_41, Templates,
        "places that templates ask for have a fourth element, the component or interface they are in";
    ReturnValueVariables: V2_99_41, Mapping,
        "returned values can be given a variable; strings and arrays are returned as pointers to `const`";
    RemoteCallsWithoutLocals: V2_99_41, Mapping,
        "local variables of a used service are listed with its parameters, and left out of its call";
    DigestsOfExceptions: V2_99_41, Digest,
        "digests contain the names of thrown exceptions, and no local variables";
    PerComponentSkeletons: V2_99_41, Templates,
        "`skeleton` writes stubs only for codels that the component declares itself";
    SignaturesOfInterfaces: V2_99_41, Templates,
        "`mappings --signature` lists the codels of interfaces, each codel once";
    ConstExceptionDetails: V2_99_42, Mapping,
        "the function that raises an exception takes its detail as `const`";
    ExternalLocalCodels: V2_99_42, Templates,
        "`skeleton` writes the codels that a component adds to a task of an interface";
    SeparateInterfaceDocs: V2_99_43, Model,
        "the `doc` of a provided interface does not join that of the component";
    NoPropertiesOfUsed: V2_99_43, Model,
        "an interface that is only used gives the component none of its properties";
    PackageVariables: V2_99_44, Templates,
        "`configure.ac` of `skeleton` has the required packages in variables, `requires_SPEC` and \
         `codels_requires_SPEC`, which the file for pkg-config uses too";
    NoLeadingBlankLine: V2_99_45, Templates,
        "generated files do not begin with a blank line";
}

#[cfg(test)]
mod tests {
    use super::*;

    fn release(text: &str) -> Release {
        text.parse().unwrap()
    }

    #[test]
    fn numbers_are_read_ordered_and_written() {
        let sorted =
            ["2.9", "2.99.4", "2.99.26", "2.99.39", "2.99.41", "3.0", "3.1", "3.1.2", "3.10"];
        let mut read: Vec<Release> = sorted.iter().rev().map(|text| release(text)).collect();
        read.sort_unstable();
        let shown: Vec<String> = read.iter().map(Release::to_string).collect();
        assert_eq!(shown[1..], sorted[1..]);
        assert_eq!(shown[0], "2.9.0");
        for text in
            ["", "2", "2.", "2.99.", "2.99.41.1", "2.99.x", "v2.99", "+2.99", "2.99.99999999"]
        {
            assert!(text.parse::<Release>().is_err(), "{text}");
        }
    }

    #[test]
    fn requirements_have_lower_bounds() {
        let bound = |text: &str| Release::lower_bound(text).map(|bound| bound.to_string());
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(bound("genom3 >= 2.99.41"), some("2.99.41"));
        assert_eq!(bound(" genom3>=3.1 "), some("3.1"));
        assert_eq!(bound("genom3 = 2.99.40"), some("2.99.40"));
        assert_eq!(bound("genom3 > 2.99.40"), some("2.99.41"));
        for text in [
            "genom3",
            "genom3 < 3",
            "genom3-idl >= 2.99.41",
            "openrobots-idl >= 2.0",
            "genom3 <= 2.99.4",
        ] {
            assert_eq!(bound(text), None, "{text}");
        }
    }

    #[test]
    fn the_manual_has_the_same_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/releases.md");
        let manual = std::fs::read_to_string(path).unwrap();
        let rows: Vec<&str> = manual
            .lines()
            .skip_while(|line| !line.starts_with("| since |"))
            .skip(2)
            .take_while(|line| line.starts_with('|'))
            .collect();
        let row =
            |entry: &Entry| format!("| {} | {} | {} |", entry.since, entry.area.name(), entry.what);
        let expected: Vec<String> = CHANGES.iter().map(row).collect();
        assert_eq!(rows, expected);
    }

    #[test]
    fn the_table_is_in_order() {
        assert!(CHANGES.is_sorted_by_key(|change| change.since));
        assert!(CHANGES.iter().all(|change| change.since > Release::OLDEST));
    }
}
