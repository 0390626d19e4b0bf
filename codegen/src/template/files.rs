//! The files of a template and their roles, as far as its scripts name them. Scripts are read as text:
//! computed names stay unknown.

use camino::{Utf8Path, Utf8PathBuf};

use super::check;

/// The script that makes a directory a template.
pub const SCRIPT: &str = "template.tcl";

/// The role of a file of a template.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Tcl.
    Script,
    /// Text with markers.
    Source,
}

/// The role of a file next to a template with these scripts; `None` for a file that the template does not
/// use, or copies unchanged.
pub fn role<'a>(
    file: &Utf8Path,
    text: &str,
    scripts: impl IntoIterator<Item = &'a str>,
) -> Option<Role> {
    let name = file.file_name()?;
    if name == SCRIPT {
        return Some(Role::Script);
    }
    let mut named = false;
    for script in scripts {
        let mut before = "";
        for word in words(script) {
            if Utf8Path::new(word).file_name() == Some(name) {
                match before {
                    "require" | "gsource" | "source" => return Some(Role::Script),
                    // It is copied unchanged into the result.
                    "raw" | "copy" => {}
                    _ => named = true,
                }
            }
            before = word;
        }
    }
    // A script that is not named in others may still contain the syntax of markers.
    let source = named || file.extension() != Some("tcl") && check::has_marker(text);
    source.then_some(Role::Source)
}

/// Files that a script in `directory` requires.
pub fn required(directory: &Utf8Path, script: &str) -> Vec<Utf8PathBuf> {
    let mut before = "";
    let mut out = Vec::new();
    for word in words(script) {
        if before == "require" {
            out.push(join(directory, word));
        }
        before = word;
    }
    out
}

/// Files next to or above `directory` that a script there names.
pub fn outside(directory: &Utf8Path, script: &str) -> Vec<Utf8PathBuf> {
    let above = words(script).filter(|word| word.starts_with("../"));
    let mut out: Vec<_> = above.map(|word| join(directory, word)).collect();
    out.retain(|path| !path.starts_with(directory));
    out.sort();
    out.dedup();
    out
}

/// Words without white space and without characters that are special in Tcl.
fn words(script: &str) -> impl Iterator<Item = &str> {
    let words = script.split(|c: char| c.is_whitespace() || "{}[]\";".contains(c));
    words.filter(|word| !word.is_empty())
}

fn join(directory: &Utf8Path, name: &str) -> Utf8PathBuf {
    let mut out = directory.to_owned();
    for part in Utf8Path::new(name).components() {
        match part.as_str() {
            "." => {}
            ".." => {
                out.pop();
            }
            name => out.push(name),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAIN: &str = "template require ../common/util.tcl\nset files {model.tcl}\n\
                        foreach f $files { template parse file $f file [file tail $f] }\n\
                        template parse file ../../common/serialize.h file \"src/serialize.h\"\n";

    #[test]
    fn files_are_what_the_script_makes_of_them() {
        let role = |name: &str, text: &str| role(name.into(), text, [MAIN]);
        assert_eq!(role("/t/template.tcl", ""), Some(Role::Script));
        assert_eq!(role("/common/util.tcl", "<'x'>"), Some(Role::Script));
        assert_eq!(role("/t/model.tcl", ""), Some(Role::Source));
        assert_eq!(role("/common/serialize.h", ""), Some(Role::Source));
        assert_eq!(role("/t/other.h", "a <\"$b\"> c"), Some(Role::Source));
        assert_eq!(role("/t/other.tcl", "a <\"$b\"> c"), None);
        assert_eq!(role("/t/other.h", "if (c == '>') f(\"<'\");"), None);
    }

    #[test]
    fn files_outside_are_found_by_their_names() {
        let at = |names: &[&str]| names.iter().map(Utf8PathBuf::from).collect::<Vec<_>>();
        assert_eq!(required("/a/t".into(), MAIN), at(&["/a/common/util.tcl"]));
        let outside = outside("/a/t".into(), MAIN);
        assert_eq!(outside, at(&["/a/common/util.tcl", "/common/serialize.h"]));
    }
}
