//! A reader of pkg-config's `.pc` files, for machines without pkg-config and for workspaces that may not run
//! it. It implements pkg-config(1): variables, flags through `Requires` and `Requires.private`, and
//! comparison of versions as in RPM.

use std::cmp::Ordering;
use std::path::Path;

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::{FxHashMap, FxHashSet};

/// The name of the tool.
pub(super) const TOOL: &str = "pkg-config";

/// A `.pc` file, with variables replaced.
#[derive(Debug, Default)]
struct Package {
    name: String,
    description: String,
    version: String,
    cflags: Vec<String>,
    requires: Vec<Requirement>,
}

/// `name`, or `name op version`.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Requirement {
    name: String,
    constraint: Option<(String, String)>,
}

/// The directories of `.pc` files: configured directories, `PKG_CONFIG_PATH`, then `PKG_CONFIG_LIBDIR` or the
/// directories next to the tool and of the system.
pub(super) fn search_path(configured: &[Utf8PathBuf]) -> Vec<Utf8PathBuf> {
    let variable = |name: &str| -> Option<Vec<Utf8PathBuf>> {
        let value = std::env::var(name).ok()?;
        let parts = value.split(':').filter(|part| !part.is_empty());
        Some(parts.map(Utf8PathBuf::from).collect())
    };
    let mut path = configured.to_vec();
    path.extend(variable("PKG_CONFIG_PATH").unwrap_or_default());
    path.extend(variable("PKG_CONFIG_LIBDIR").unwrap_or_else(|| {
        let multiarch = format!("/usr/lib/{}-linux-gnu/pkgconfig", std::env::consts::ARCH);
        let system = [
            "/usr/local/lib/pkgconfig",
            "/usr/local/share/pkgconfig",
            &multiarch,
            "/usr/lib/pkgconfig",
            "/usr/lib64/pkgconfig",
            "/usr/share/pkgconfig",
        ]
        .map(Utf8PathBuf::from);
        let mut directories = installation_directories();
        directories.extend(system);
        directories
    }));
    path
}

/// The package tool: the program that the environment variable `PKG_CONFIG` names, or [`TOOL`].
pub(super) fn tool() -> String {
    let named = std::env::var("PKG_CONFIG").ok().filter(|variable| !variable.is_empty());
    named.unwrap_or_else(|| TOOL.to_owned())
}

/// The directories of the installation that contains the tool: `/opt/robot/lib/pkgconfig` for
/// `/opt/robot/bin/pkg-config`, also if a link leads there. They are built into the tool.
fn installation_directories() -> Vec<Utf8PathBuf> {
    let found = crate::process::find_in_path(Path::new(&tool()));
    let real = found.as_deref().and_then(|path| path.canonicalize().ok());
    let mut out = Vec::new();
    for tool in found.into_iter().chain(real) {
        let prefix = Utf8PathBuf::from_path_buf(tool).ok();
        let prefix = prefix.as_deref().and_then(Utf8Path::parent);
        if let Some(prefix) = prefix.and_then(Utf8Path::parent) {
            // The last one is FreeBSD's.
            let parts = ["lib/pkgconfig", "share/pkgconfig", "libdata/pkgconfig"];
            out.extend(parts.map(|part| prefix.join(part)));
        }
    }
    out
}

/// Names of the packages that have a `.pc` file on the search path, sorted.
pub(super) fn names(configured: &[Utf8PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for directory in search_path(configured) {
        let entries = directory.read_dir_utf8().into_iter().flatten();
        for entry in entries.filter_map(Result::ok) {
            names.extend(entry.file_name().strip_suffix(".pc").map(str::to_owned));
        }
    }
    names.sort();
    names.dedup();
    names
}

/// The `Cflags` words of the packages and of all packages they require.
pub(super) fn cflags(path: &[Utf8PathBuf], arguments: &[String]) -> Result<Vec<String>, String> {
    let mut todo: Vec<(Requirement, Option<String>)> = Vec::new();
    for argument in arguments {
        todo.extend(requirements(argument).into_iter().map(|requirement| (requirement, None)));
    }
    todo.reverse();
    let mut words = Vec::new();
    let mut seen = FxHashSet::default();
    while let Some((wanted, by)) = todo.pop() {
        let required_by = by.map_or(String::new(), |by| format!(", required by '{by}',"));
        let Some(package) = find(path, &wanted.name) else {
            let places: Vec<&str> = path.iter().map(|path| path.as_str()).collect();
            return Err(format!(
                "package '{}'{required_by} was not found: no {}.pc in {}",
                wanted.name,
                wanted.name,
                places.join(":")
            ));
        };
        if let Some((operator, version)) = &wanted.constraint
            && !satisfies(&package.version, operator, version)
        {
            return Err(format!(
                "package '{}'{required_by} has version {}, but {operator} {version} is wanted",
                wanted.name, package.version
            ));
        }
        if !seen.insert(wanted.name.clone()) {
            continue;
        }
        words.extend(package.cflags);
        let next = package.requires.into_iter().rev();
        todo.extend(next.map(|requirement| (requirement, Some(wanted.name.clone()))));
    }
    Ok(words)
}

/// The version of a package.
pub(super) fn version(path: &[Utf8PathBuf], name: &str) -> Option<String> {
    find(path, name).map(|package| package.version)
}

fn find(path: &[Utf8PathBuf], name: &str) -> Option<Package> {
    path.iter().find_map(|directory| {
        let file = directory.join(format!("{name}.pc"));
        let text = crate::files::read_regular(file.as_ref()).ok()?;
        let package = parse(&String::from_utf8_lossy(&text), directory);
        // pkg-config ignores files without these fields.
        let fields = [&package.name, &package.description, &package.version];
        fields.iter().all(|field| !field.is_empty()).then_some(package)
    })
}

fn parse(text: &str, directory: &Utf8Path) -> Package {
    let mut variables: FxHashMap<String, String> = FxHashMap::default();
    // Values are split into words as in a shell; directories may contain blanks.
    let here = directory.as_str().replace('\\', "\\\\").replace(' ', "\\ ");
    variables.insert("pcfiledir".to_owned(), here);
    let mut package = Package::default();
    let joined = text.replace("\\\r\n", "").replace("\\\n", "");
    for line in joined.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let Some(end) = line.find(|c: char| !c.is_alphanumeric() && !matches!(c, '_' | '.' | '-'))
        else {
            continue;
        };
        let (name, rest) = line.split_at(end);
        let rest = rest.trim_start();
        if let Some(value) = rest.strip_prefix('=') {
            let value = expand(value.trim(), &variables);
            variables.insert(name.to_owned(), value);
        } else if let Some(value) = rest.strip_prefix(':') {
            let value = expand(value.trim(), &variables);
            match name {
                "Name" => package.name = value,
                "Description" => package.description = value,
                "Version" => package.version = value,
                "Cflags" | "CFlags" => {
                    package.cflags = shlex::split(&value)
                        .unwrap_or_else(|| value.split_whitespace().map(str::to_owned).collect());
                }
                "Requires" | "Requires.private" => package.requires.extend(requirements(&value)),
                _ => {}
            }
        }
    }
    package
}

/// Replaces `${name}`; `$$` is a dollar. An unknown variable is empty. One pass is sufficient: values were
/// expanded when they were read.
fn expand(text: &str, variables: &FxHashMap<String, String>) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('$') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        if let Some(after) = rest.strip_prefix("$$") {
            out.push('$');
            rest = after;
        } else if let Some((name, after)) =
            rest.strip_prefix("${").and_then(|after| after.split_once('}'))
        {
            out.push_str(variables.get(name).map_or("", String::as_str));
            rest = after;
        } else {
            out.push('$');
            rest = &rest[1..];
        }
    }
    out.push_str(rest);
    out
}

/// `a >= 1, b c=2`
fn requirements(text: &str) -> Vec<Requirement> {
    // An operator may have no blank on either side.
    let mut spaced = String::with_capacity(text.len() + 8);
    let mut in_operator = false;
    for c in text.chars() {
        let c = if c == ',' { ' ' } else { c };
        let operator = matches!(c, '<' | '>' | '=' | '!');
        if operator != in_operator {
            spaced.push(' ');
        }
        in_operator = operator;
        spaced.push(c);
    }
    let mut words = spaced.split_whitespace().peekable();
    let mut out = Vec::new();
    while let Some(name) = words.next() {
        let constraint = match words.next_if(|word| word.starts_with(['<', '>', '=', '!'])) {
            Some(operator) => words.next().map(|version| (operator.to_owned(), version.to_owned())),
            None => None,
        };
        out.push(Requirement { name: name.to_owned(), constraint });
    }
    out
}

fn satisfies(version: &str, operator: &str, wanted: &str) -> bool {
    let order = compare_versions(version, wanted);
    match operator {
        "=" | "==" => order.is_eq(),
        "!=" => order.is_ne(),
        "<" => order.is_lt(),
        "<=" => order.is_le(),
        ">" => order.is_gt(),
        ">=" => order.is_ge(),
        _ => false,
    }
}

/// Compares versions: runs of digits as numbers, runs of letters as text, digits above letters. The version
/// with a remaining part is newer.
fn compare_versions(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (segments(a), segments(b));
    loop {
        match (a.next(), b.next()) {
            (None, None) => return Ordering::Equal,
            (None, Some(_)) => return Ordering::Less,
            (Some(_), None) => return Ordering::Greater,
            (Some(a), Some(b)) => {
                let number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit());
                let order = match (number(a), number(b)) {
                    (true, true) => {
                        let (a, b) = (a.trim_start_matches('0'), b.trim_start_matches('0'));
                        a.len().cmp(&b.len()).then_with(|| a.cmp(b))
                    }
                    (true, false) => Ordering::Greater,
                    (false, true) => Ordering::Less,
                    (false, false) => a.cmp(b),
                };
                if order.is_ne() {
                    return order;
                }
            }
        }
    }
}

fn segments(version: &str) -> impl Iterator<Item = &str> {
    let mut rest = version;
    std::iter::from_fn(move || {
        rest = rest.trim_start_matches(|c: char| !c.is_ascii_alphanumeric());
        let digits = rest.starts_with(|c: char| c.is_ascii_digit());
        let same = |c: char| c.is_ascii_alphanumeric() && c.is_ascii_digit() == digits;
        let end = rest.find(|c| !same(c)).unwrap_or(rest.len());
        let (segment, after) = rest.split_at(end);
        rest = after;
        (!segment.is_empty()).then_some(segment)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_as_rpm_does() {
        for (a, order, b) in [
            ("1.2", Ordering::Equal, "1.2"),
            ("1.10", Ordering::Greater, "1.9"),
            ("1.2", Ordering::Less, "1.2.1"),
            ("2.0a", Ordering::Greater, "2.0"),
            ("1.a", Ordering::Less, "1.1"),
            ("3.04", Ordering::Equal, "3.4"),
        ] {
            assert_eq!(compare_versions(a, b), order, "{a} against {b}");
        }
    }

    #[test]
    fn requirements_are_read_with_and_without_blanks() {
        let plain: Vec<String> = requirements("a >= 1.2, b c=3 d")
            .iter()
            .map(|requirement| format!("{} {:?}", requirement.name, requirement.constraint))
            .collect();
        assert_eq!(
            plain,
            ["a Some((\">=\", \"1.2\"))", "b None", "c Some((\"=\", \"3\"))", "d None"]
        );
    }

    #[test]
    fn flags_of_required_packages_follow() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let path = Utf8PathBuf::from_path_buf(directory.path().to_owned()).expect("UTF-8");
        let write = |name: &str, text: &str| std::fs::write(path.join(name), text).expect("write");
        write(
            "pose.pc",
            "prefix=/opt/robot\nincludedir=${prefix}/include\nName: pose\nDescription: Poses\n\
             Version: 1.4\nRequires: base >= 2\nCflags: -I${includedir}/pose -DDOLLAR=$$\n",
        );
        write("none.pc", "Name: none\nVersion: 1\n");
        write(
            "base.pc",
            "Name: base\nDescription: x\nVersion: 2.1\nRequires: pose\nCflags: -I/opt/base\n",
        );
        let path = [path];
        assert_eq!(
            cflags(&path, &["pose > 1.3".to_owned()]).expect("found"),
            ["-I/opt/robot/include/pose", "-DDOLLAR=$", "-I/opt/base"]
        );
        let error = cflags(&path, &["pose >= 2".to_owned()]).expect_err("too old");
        assert_eq!(error, "package 'pose' has version 1.4, but >= 2 is wanted");
        for name in ["nothing", "none"] {
            let error = cflags(&path, &[name.to_owned()]).expect_err("missing");
            let start = format!("package '{name}' was not found");
            assert!(error.starts_with(&start), "{error}");
        }
    }
}
