//! The pictures in docs/pictures are what the program draws now.

use std::path::Path;
use std::process::Command;

#[test]
fn pictures_of_the_documentation_are_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let directory = root.join("docs/pictures");
    let list = std::fs::read_to_string(directory.join("list.txt")).expect("the list");
    let mut stale = Vec::new();
    let mut listed = vec!["list.txt".to_owned()];
    for line in list.lines().filter(|line| !line.starts_with('#')) {
        let (file, how) = line.split_once(": ").expect("FILE: ARGUMENTS");
        let draw = || {
            let mut command = Command::new(env!("CARGO_BIN_EXE_dotgen"));
            command.current_dir(&root).arg("diagram");
            let output = command.args(how.split_whitespace()).output();
            let output = output.expect("dotgen runs");
            assert!(output.status.success(), "{line}\n{}", String::from_utf8_lossy(&output.stderr));
            output.stdout
        };
        let drawn = draw();
        assert_eq!(drawn, draw(), "{file}: the same input gives the same bytes");
        if std::fs::read(directory.join(file)).ok() != Some(drawn) {
            stale.push(file.to_owned());
        }
        listed.push(file.to_owned());
    }
    assert!(
        stale.is_empty(),
        "{stale:?} are not what dotgen draws now: run `cargo xtask docs`, and look at them"
    );
    for entry in std::fs::read_dir(&directory).expect("docs/pictures") {
        let name = entry.expect("an entry").file_name();
        let name = name.to_string_lossy().into_owned();
        let known = listed.contains(&name) || name.ends_with(".md");
        assert!(known, "docs/pictures/{name} is in no line of list.txt");
    }
}
