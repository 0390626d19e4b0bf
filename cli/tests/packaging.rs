//! The lists of files in packages.

use std::collections::BTreeSet;
use std::path::Path;

use crate::directory::Directory;

/// Other files that the robotpkg package installs.
const OTHERS: [&str; 6] = [
    "bin/dotgen",
    "share/bash-completion/completions/dotgen",
    "share/doc/dotgen/LICENSE",
    "share/doc/dotgen/THIRD-PARTY-NOTICES.txt",
    "share/fish/vendor_completions.d/dotgen.fish",
    "share/zsh/site-functions/_dotgen",
];

/// The list of robotpkg has every manual page and every file of docs/. The test writes the list.
#[test]
fn robotpkg_lists_all_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let directory = Directory::new(&[]);
    assert!(directory.run(&["man", "pages"]).status.success());
    let mut files: BTreeSet<String> = OTHERS.iter().map(|text| (*text).to_owned()).collect();
    let mut add = |folder: &Path, prefix: &str| {
        let entries = walkdir::WalkDir::new(folder).into_iter().flatten();
        for entry in entries.filter(|entry| entry.file_type().is_file()) {
            let path = entry.path().strip_prefix(folder).expect("it is below");
            files.insert(format!("{prefix}/{}", path.display()));
        }
    };
    add(&directory.path().join("pages"), "${PKGMANDIR}/man1");
    add(&root.join("docs"), "share/doc/dotgen");
    let lines: Vec<String> = files.into_iter().collect();
    let expected = format!("@comment \n{}\n", lines.join("\n"));
    let path = root.join("packaging/robotpkg/PLIST");
    let listed = std::fs::read_to_string(&path).expect("a list");
    let (first, _) = listed.split_once('\n').expect("a first line");
    let expected = expected.replacen("@comment ", first, 1);
    if listed != expected {
        std::fs::write(&path, expected).expect("the list can be written");
        panic!("packaging/robotpkg/PLIST was not up to date: it is now");
    }
}
