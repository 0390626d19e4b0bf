//! Links out of folders, and files that configure tools.
#![cfg(unix)]

use dotgen_codegen::template::readable_files::{is_below, is_control, is_hidden, link_out};
use dotgen_platform::files::disk::SystemDisk;

#[test]
fn links_lead_where_they_lead() {
    use std::os::unix::fs::symlink;
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().join("root");
    std::fs::create_dir(&root).unwrap();
    std::fs::create_dir(dir.path().join("other")).unwrap();
    symlink("../other", root.join("out")).unwrap();
    symlink("../missing", root.join("nowhere")).unwrap();
    symlink("sub", root.join("inner")).unwrap();
    std::fs::create_dir(root.join("sub")).unwrap();
    let below = |path: &str| is_below(&SystemDisk, &root.join(path), std::slice::from_ref(&root));
    for path in ["a", "a/b/c", "x/../a", "inner/a", "sub/new/a"] {
        assert!(below(path), "{path}");
    }
    for path in ["../a", "x/../../a", "out/a", "out/../a/../../b", "nowhere", "nowhere/a", "/a"] {
        assert!(!below(path), "{path}");
    }
    let link = |path: &str| link_out(&SystemDisk, &root.join(path), std::slice::from_ref(&root));
    assert_eq!(link("out/sub/a"), Some(root.join("out")));
    assert_eq!(link("nowhere"), Some(root.join("nowhere")));
    assert_eq!(link("inner/a"), None);
    // A folder that does not exist yet has the place where it will be created.
    assert!(is_below(&SystemDisk, &root.join("out/new/a"), &[root.join("out/new")]));
    let hidden = |path: &str| is_hidden(&SystemDisk, &root.join(path), std::slice::from_ref(&root));
    std::fs::create_dir(root.join(".git")).unwrap();
    symlink(".git", root.join("plain")).unwrap();
    symlink("sub", root.join(".link")).unwrap();
    for path in [".a", ".git/hooks/x", "sub/.b/c", "plain/hooks/x", "inner/.d", ".link/e"] {
        assert!(hidden(path), "{path}");
    }
    for path in ["a", "inner/a", ".git/../a", "sub/b.c/d"] {
        assert!(!hidden(path), "{path}");
    }
    let control =
        |path: &str| is_control(&SystemDisk, &root.join(path), std::slice::from_ref(&root));
    for path in [".git/hooks/x", "sub/.GIT/x", ".vscode/a", "plain/hooks/x"] {
        assert!(control(path), "{path}");
    }
    for path in [".clang-format", ".gitignore", "inner/.d", ".link/e", "git/x"] {
        assert!(!control(path), "{path}");
    }
    // The folder itself may be hidden.
    let folders = [root.clone(), root.join(".git")];
    assert!(!is_hidden(&SystemDisk, &root.join(".git/a"), &folders));
    // A folder whose name has the same prefix is another folder.
    assert!(!is_below(&SystemDisk, &dir.path().join("root2/a"), &[root]));
}
