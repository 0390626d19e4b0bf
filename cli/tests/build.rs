//! `dotgen codels build`, with the compilers of the system.

use std::path::Path;
use std::time::SystemTime;

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};

const VALVE: &str = "\
native handle;
typedef sequence<string> lines;
struct pose { double x, y; };
component valve {
  version \"1.0\";
  lang \"LANG\";
  native handle;
  ids { double angle; lines log; handle device; };
  exception e_stuck { short code; };
  port out pose position;
  task turn {
    period 10 ms;
    throw e_stuck;
    codel<start> turn_first(out angle, port out position) yield pause::main;
    codel<main> turn_again(inout angle, inout log, port out position) yield pause::main;
  };
  function open(in double by = 1.) {
    codel turn_open(in by, inout angle);
    throw e_stuck;
  };
};
";

/// A component with stubs; `None` without compilers.
fn valve(language: &str) -> Option<Directory> {
    if !crate::running::compilers() {
        return None;
    }
    let directory = Directory::new(&[("valve.gen", &VALVE.replace("LANG", language))]);
    let output = directory.run(&["codels", "stub", "valve.gen"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    Some(directory)
}

fn modified(directory: &Directory, name: &str) -> SystemTime {
    let path = directory.path().join(".dotgen/run/valve").join(name);
    let metadata =
        std::fs::metadata(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    metadata.modified().expect("a time")
}

/// Where the first codel of the task is.
fn source(directory: &Directory) -> (String, String) {
    let folder = std::fs::read_dir(directory.path().join("codels")).expect("the stubs");
    let mut names = folder.flatten().map(|folder| folder.file_name().into_string().expect("UTF-8"));
    let name = names.find(|name| name.contains("turn")).expect("a file of the task");
    let text =
        std::fs::read_to_string(directory.path().join("codels").join(&name)).expect("a file");
    (format!("codels/{name}"), text)
}

#[test]
fn stubs_compile_in_both_languages() {
    for language in ["c", "c++"] {
        let Some(valve) = valve(language) else { return };
        let output = valve.run(&["codels", "build", "valve.gen"]);
        assert_eq!(status(&output), 0, "{language}: {}{}", stdout(&output), stderr(&output));
        assert!(stderr(&output).contains("compiled 2 files into"), "{}", stderr(&output));
        let again = valve.run(&["codels", "build", "valve.gen"]);
        assert!(stderr(&again).contains("valve.so` is up to date"), "{}", stderr(&again));
        let library =
            std::fs::read(valve.path().join(".dotgen/run/valve/valve.so")).expect("a library");
        assert!(library.starts_with(b"\x7fELF") || !cfg!(target_os = "linux"));
        let text = String::from_utf8_lossy(&library);
        assert!(text.contains("turn_again"), "the codel is a symbol of it");
    }
}

#[test]
fn only_what_has_changed_is_compiled() {
    let Some(valve) = valve("c") else { return };
    let objects = |directory: &Directory| -> Vec<String> {
        let folder =
            std::fs::read_dir(directory.path().join(".dotgen/run/valve/objects")).expect("objects");
        let names = folder.flatten().map(|folder| folder.file_name().into_string().expect("UTF-8"));
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".o")).collect();
        names.sort();
        names.into_iter().map(|name| format!("objects/{name}")).collect()
    };
    let build = |directory: &Directory, more: &[&str]| {
        let output = directory.run(&[&["codels", "build", "valve.gen"], more].concat());
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        objects(directory).iter().map(|name| modified(directory, name)).collect::<Vec<_>>()
    };
    let first = build(&valve, &[]);
    assert!(first.len() >= 2, "one for the task, one for the control task");
    assert_eq!(build(&valve, &["--jobs", "1"]), first);
    let (name, text) = source(&valve);
    valve.write(&name, format!("{text}\n/* more */\n").as_bytes());
    let second = build(&valve, &[]);
    let again = first.iter().zip(&second).filter(|(a, b)| a != b).count();
    assert_eq!(again, 1, "{first:?} {second:?}");
    // Another type changes a header that all sources include.
    let specification = VALVE.replace("LANG", "c").replace("double angle", "float angle");
    valve.write("valve.gen", specification.as_bytes());
    let (name, text) = source(&valve);
    valve.write(&name, text.replace("double *angle", "float *angle").as_bytes());
    let control = "codels/valve_codels.c";
    if let Ok(text) = std::fs::read_to_string(valve.path().join(control)) {
        valve.write(control, text.replace("double *angle", "float *angle").as_bytes());
    }
    let third = build(&valve, &[]);
    assert!(second.iter().zip(&third).all(|(a, b)| a != b), "{second:?} {third:?}");
}

#[test]
fn what_does_not_compile_is_told_at_its_codel() {
    let Some(valve) = valve("c") else { return };
    let (name, text) = source(&valve);
    let body = text.find("turn_again(").expect("the codel");
    let brace = body + text[body..].find('{').expect("its body");
    let broken = format!("{}{{\n  undeclared_thing = 1;{}", &text[..brace], &text[brace + 1..]);
    valve.write(&name, broken.as_bytes());
    let output = valve.run(&["codels", "build", "--format", "json", "valve.gen"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let all = document["diagnostics"].as_array().expect("a list");
    let error = all.iter().find(|diagnostic| diagnostic["severity"] == "error").expect("an error");
    assert_eq!(error["code"], "codel/compiler");
    assert!(error["file"].as_str().expect("a path").ends_with(&name), "{error}");
    let line = broken[..broken.find("undeclared_thing").expect("it is there")].lines().count() - 1;
    assert_eq!(error["range"]["start"]["line"], line, "{error}");
    assert_eq!(error["range"]["start"]["character"], 2, "{error}");
    assert_eq!(error["range"]["end"]["character"], 18, "{error}");
    let related = error["related"].as_array().expect("a list");
    let declared = related.iter().any(|json| {
        json["message"]
            .as_str()
            .is_some_and(|message| message.contains("`turn_again` is declared here"))
            && json["file"].as_str().is_some_and(|file| file.ends_with("valve.gen"))
    });
    assert!(declared, "{error}");
    // Mended, it is whole again.
    valve.write(&name, text.as_bytes());
    assert_eq!(status(&valve.run(&["codels", "build", "valve.gen"])), 0);
}

#[test]
fn what_is_missing_is_said() {
    let Some(valve) = valve("c") else { return };
    let (name, text) = source(&valve);
    valve.write(&name, text.replace("turn_again", "turn_other").as_bytes());
    let output = valve.run(&["codels", "build", "valve.gen"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let said = stderr(&output);
    assert!(
        said.contains("without a function: turn_again") && said.contains("dotgen codels stub"),
        "{said}"
    );
    std::fs::remove_dir_all(valve.path().join("codels")).expect("removed");
    let output = valve.run(&["codels", "build", "valve.gen"]);
    assert_eq!(status(&output), 1);
    assert!(stderr(&output).contains("has no sources"), "{}", stderr(&output));
    let mut command = valve.command(&["codels", "build", "valve.gen"]);
    valve.run(&["codels", "stub", "valve.gen"]);
    let output = command.env("CC", "no-such-compiler").env("CXX", "no-such-compiler").output();
    let output = output.expect("the program runs");
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("there is no compiler `no-such-compiler`"),
        "{}",
        stderr(&output)
    );
    let package = VALVE.replace("LANG\";", "c\";\n  codels-require \"no-such-package-of-dotgen\";");
    valve.write("valve.gen", package.as_bytes());
    let output = valve.run(&["codels", "build", "valve.gen"]);
    assert_eq!(status(&output), 2, "{}", stderr(&output));
    assert!(stderr(&output).contains("no-such-package-of-dotgen"), "{}", stderr(&output));
    assert!(stderr(&output).contains("install"), "{}", stderr(&output));
    assert!(!Path::new("valve.so").exists());
    // What only the specification requires may be missing, and GenoM3 always.
    let package = VALVE.replace(
        "LANG\";",
        "c\";\n  require \"no-such-package-of-dotgen >= 2\", \"genom3 >= 99\";",
    );
    valve.write("valve.gen", package.as_bytes());
    let output = valve.run(&["codels", "build", "valve.gen"]);
    let said = stderr(&output);
    assert_eq!(status(&output), 0, "{said}");
    assert!(said.contains("not installed: `no-such-package-of-dotgen"), "{said}");
    assert!(!said.contains("genom3"), "{said}");
}

#[cfg(unix)]
#[test]
fn missing_functions_are_in_the_summary() {
    let directory = Directory::new(&[("valve.gen", &VALVE.replace("LANG", "c"))]);
    directory.write("elsewhere/notes.txt", b"");
    let link = directory.path().join("codels");
    std::os::unix::fs::symlink("elsewhere", link).expect("a link");
    let output = directory.run(&["codels", "build", "valve.gen"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    assert_eq!(stdout(&output), "checked 1 file: 1 file lacks codels\n");
    assert!(
        stderr(&output).contains("`valve.gen` has no sources in `codels`"),
        "{}",
        stderr(&output)
    );
}
