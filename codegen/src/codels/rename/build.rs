//! Renames in the build files.

use smol_str::SmolStr;

use super::{Renaming, UnchangedPlace, UnchangedReason, names::NewNames};
use crate::codels::{expected::Expected, files::Files, folder::Folder, source::Span};

/// Build files that may name headers and components, relative to the folder of the specification.
const BUILD_FILES: [&str; 5] = [
    "Makefile.am",
    "configure.ac",
    "CMakeLists.txt",
    "codels/Makefile.am",
    "codels/CMakeLists.txt",
];

/// Renames headers and functions in build files, and lists places where the name of the component is a part
/// of another name.
pub(super) fn rename(
    folder: &Folder,
    before: &Expected<'_>,
    names: &NewNames,
    texts: &dyn Files,
    out: &mut Renaming,
) {
    let Some(root) = folder.specification.parent() else {
        return;
    };
    let component = before.component().name.as_str();
    let renamed = !names.files.is_empty();
    for name in BUILD_FILES {
        let path = root.join(name);
        let Some(text) = texts.read(&path) else {
            continue;
        };
        for line in lines(&text) {
            let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let content = &text[line.1.clone()];
            for word in content.split(|c| !part(c)).filter(|part| !part.is_empty()) {
                let at = word.as_ptr() as usize - content.as_ptr() as usize;
                let start = line.1.start + at;
                // The extension of a file.
                if at > 0 && content[..at].ends_with('.') {
                    continue;
                }
                let global = || names.globals.get(&(Vec::new(), SmolStr::from(word)));
                if let Some(to) = names.files.get(word).or_else(global) {
                    out.edit.replace(&path, start..start + word.len(), to.as_str());
                } else if renamed && word.split('_').any(|part| is_part(part, component)) {
                    out.left.push(UnchangedPlace {
                        path: path.clone(),
                        line: line.0,
                        name: word.into(),
                        why: UnchangedReason::Build,
                    });
                }
            }
        }
    }
}

/// True if a part of a word is the name of the component, or the name of one of its libraries.
fn is_part(word: &str, component: &str) -> bool {
    word == component || word.strip_prefix("lib") == Some(component)
}

/// Lines with their numbers, from 1.
fn lines(text: &str) -> impl Iterator<Item = (usize, Span)> {
    let mut at = 0;
    (1..).zip(text.split_inclusive('\n')).map(move |(number, part)| {
        at += part.len();
        (number, at - part.len()..at)
    })
}
