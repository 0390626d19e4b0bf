//! Published models, generated again from their specifications: `DOTGEN_CLONES` names a folder with clones of
//! `Mo-F/uppaal-smc-exp` and `Mo-F/FM_Templates_U`.

use std::collections::BTreeMap;
use std::path::Path;

use crate::directory::{Directory, status, stderr};

/// The processes of a model in UPPAAL's textual format, in order, and the text of each without comments,
/// blanks and the order in lists of locations.
fn processes(text: &str) -> (Vec<String>, BTreeMap<String, Vec<String>>) {
    let mut code = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("/*") {
        code.push_str(&rest[..start]);
        rest = rest[start..].split_once("*/").map_or("", |(_, rest)| rest);
    }
    code.push_str(rest);
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    let code = lines.collect::<Vec<_>>().join("\n");
    let (mut names, mut bodies) = (Vec::new(), BTreeMap::new());
    for part in code.split("process ").skip(1) {
        let name = part.split('(').next().unwrap_or_default().trim().to_owned();
        // The next process, or the instances after the last one.
        let mut depth = 0;
        let end = part.find(|c: char| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            c == '}' && depth == 0
        });
        let body = part[..end.expect("the process ends")].to_owned();
        let statements = body.split(';').map(|statement| {
            let text: String = statement.split_whitespace().collect();
            let mut list: Vec<&str> = text.split(',').collect();
            if text.starts_with("urgent") || text.starts_with("commit") {
                list = text["urgent".len()..].split(',').collect();
                list.sort_unstable();
            }
            list.join(",")
        });
        bodies.insert(name.clone(), statements.collect());
        names.push(name);
    }
    (names, bodies)
}

#[test]
fn the_quadcopter_is_generated_with_the_interfaces_that_come_along() {
    let Some(clones) = std::env::var_os("DOTGEN_CLONES") else {
        return dotgen_loaders::skip("no data: DOTGEN_CLONES names no folder of clones");
    };
    let clones = Path::new(&clones);
    let directory = Directory::new(&[]);
    let mut command = directory.command(&["generate"]);
    command.arg("-t").arg(clones.join("FM_Templates_U")).args(["model", "-C", "out", "-smc"]);
    let artefact = clones.join("uppaal-smc-exp");
    command.arg(artefact.join("all.proba")).arg(artefact.join("all.gen"));
    let output = command.env("PKG_CONFIG_PATH", "").output().expect("the program runs");
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let published = std::fs::read_to_string(artefact.join("quadcopter.xta")).expect("the model");
    let own = directory.read("out/mikrokopter-pom-nhfc-maneuver-optitrack.xta");
    let ((names, published), (own_names, own)) = (processes(&published), processes(&own));
    assert_eq!(names, own_names);
    assert_eq!(names.len(), 36);
    // The authors wrote the client by hand.
    let other: Vec<&String> =
        names.iter().filter(|&name| *name != "client" && published[name] != own[name]).collect();
    assert!(other.is_empty(), "{other:?}: {:#?}\n{:#?}", published[other[0]], own[other[0]]);
}
