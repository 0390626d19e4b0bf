//! Packages that specifications require: their names, and the packages that install them.
//!
//! Components, interfaces and GenoM3 itself come from [robotpkg](http://robotpkg.openrobots.org), whose
//! binary packages for Debian and Ubuntu have the robotpkg name after `robotpkg-`. Other packages come from
//! the system.

/// Debian names that cannot be derived from the pkg-config name.
const DEBIAN: [(&str, &str); 4] = [
    ("opencv", "libopencv-dev"),
    ("opencv4", "libopencv-dev"),
    ("tcl", "tcl-dev"),
    ("tk", "tk-dev"),
];

/// The packages that install a required package.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Providers {
    /// The robotpkg package, with its category if that follows from the name.
    pub robotpkg: Option<String>,
    /// The Debian package. If [`Providers::robotpkg`] is set, it comes from the robotpkg repository.
    pub debian: Option<String>,
}

/// Names of the packages in a requirement as pkg-config reads it: `a >= 1.0, b c`.
pub fn names(requirement: &str) -> Vec<&str> {
    let separator = |character: char| character.is_whitespace() || character == ',';
    let mut out = Vec::new();
    let mut version = false;
    for word in requirement.split(separator).filter(|part| !part.is_empty()) {
        let is_operator = |character: char| matches!(character, '<' | '>' | '=' | '!');
        let name = word.split(is_operator).next().unwrap_or_default();
        let operator = &word[name.len()..];
        if name.is_empty() {
            // The version stands in this word, or in the next one.
            version = word.ends_with(is_operator);
        } else if !std::mem::take(&mut version) {
            out.push(name);
            version = !operator.is_empty() && operator.ends_with(is_operator);
        }
    }
    out
}

/// The packages that install a required package, derived from its name.
pub fn providers(name: &str) -> Providers {
    let robotpkg = match name {
        "genom3" => Some("architecture/genom3".to_owned()),
        name if name.starts_with("genom3-") => Some(format!("architecture/{name}")),
        name if name.ends_with("-idl") => Some(format!("interfaces/{name}")),
        name if name.ends_with("-genom3") => Some(name.to_owned()),
        _ => None,
    };
    let debian = match &robotpkg {
        Some(_) => format!("robotpkg-{}", debian_part(name)),
        None => match DEBIAN.iter().find(|debian| debian.0 == name) {
            Some((_, package)) => (*package).to_owned(),
            None => format!("lib{}-dev", debian_part(name.strip_prefix("lib").unwrap_or(name))),
        },
    };
    Providers { robotpkg, debian: Some(debian).filter(|debian| is_debian_name(debian)) }
}

/// A name as part of the name of a Debian package: `geometry-msgs` for `geometry_msgs`.
fn debian_part(name: &str) -> String {
    name.to_ascii_lowercase().replace('_', "-")
}

/// Returns true for a name that Debian allows.
fn is_debian_name(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "+-.".contains(c);
    name.chars().all(allowed) && !name.contains("--") && !name.starts_with("lib-")
}

/// The installation advice for a package: `` `interfaces/a-idl` of robotpkg (Debian: `robotpkg-a-idl`) ``.
pub fn advice(name: &str) -> String {
    let providers = providers(name);
    match (providers.robotpkg, providers.debian) {
        (Some(robotpkg), Some(debian)) => {
            format!("`{robotpkg}` of robotpkg (Debian package `{debian}` of its repository)")
        }
        (Some(robotpkg), None) => format!("`{robotpkg}` of robotpkg"),
        (None, Some(debian)) => format!("`{name}` (on Debian most likely package `{debian}`)"),
        (None, None) => format!("`{name}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_requirements() {
        assert_eq!(names("openrobots2-idl >= 2.0"), ["openrobots2-idl"]);
        assert_eq!(names("a>=1 b, c >=2.0 d = 1"), ["a", "b", "c", "d"]);
        assert_eq!(names("realsense2, opencv"), ["realsense2", "opencv"]);
        assert_eq!(names("a>= 1.0 b"), ["a", "b"]);
        assert!(names(" , ").is_empty());
    }

    #[test]
    fn what_brings_a_package_follows_from_its_name() {
        let of = |name| {
            let provider = providers(name);
            (provider.robotpkg.unwrap_or_default(), provider.debian.unwrap_or_default())
        };
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(of("vision-idl"), pair("interfaces/vision-idl", "robotpkg-vision-idl"));
        assert_eq!(of("pom-genom3"), pair("pom-genom3", "robotpkg-pom-genom3"));
        assert_eq!(of("eigen3"), pair("", "libeigen3-dev"));
        assert_eq!(of("libkdtp"), pair("", "libkdtp-dev"));
        assert_eq!(of("geometry_msgs"), pair("", "libgeometry-msgs-dev"));
        assert_eq!(of("OGRE"), pair("", "libogre-dev"));
        assert_eq!(of("a/b"), pair("", ""));
        assert_eq!(of("_"), pair("", ""));
        assert_eq!(of("opencv4"), pair("", "libopencv-dev"));
    }
}
