//! Where templates are found.

use dotgen_codegen::catalog::{TemplateKind, templates};
use dotgen_codegen::template::discover::{FindError, SearchPath};
use dotgen_platform::files::disk::SystemDisk;

/// A folder with files of these names and texts.
fn tree(files: &[(&str, &str)]) -> tempfile::TempDir {
    let tree = tempfile::tempdir().unwrap();
    for (path, text) in files {
        let path = tree.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    tree
}

#[test]
fn directories_with_a_template_are_found() {
    let tree = tree(&[("a/template.tcl", ""), ("b/c/template.tcl", ""), ("d/template.py", "")]);
    let path = SearchPath {
        dirs: SearchPath::parse(&format!("nowhere::{}", tree.path().display())),
        builtin: None,
    };
    let find = |name: &str| path.find(&SystemDisk, name);
    assert_eq!(path.list(&SystemDisk), ["a", "b/c", "d"]);
    assert_eq!(find("b/c"), Ok(tree.path().join("b/c")));
    assert_eq!(find("b"), Err(FindError::NotFound("b".into())));
    assert_eq!(find("d"), Err(FindError::UnknownEngine("py".into())));
    let file = tree.path().join("a/template.tcl");
    let file = file.to_str().unwrap().to_owned();
    assert_eq!(find(&file), Err(FindError::MissingArgument(file)));
}

#[test]
fn a_folder_wins_over_a_template_of_dotgen() {
    let tree =
        tree(&[("skeleton/template.tcl", ""), ("mine/template.toml", "about = \"names\"\n")]);
    let search = SearchPath { dirs: vec![tree.path().to_owned()], builtin: None };
    let all = templates(&SystemDisk, &search, false);
    let of = |name: &str| {
        let found = all.iter().find(|template| template.name == name);
        found.map(|template| (template.kind, template.about.as_str()))
    };
    assert_eq!(of("skeleton"), Some((TemplateKind::Tcl, "")));
    assert_eq!(of("mine"), Some((TemplateKind::Minijinja, "names")));
    assert_eq!(of("mappings").map(|found| found.0), Some(TemplateKind::Builtin));
}
