//! Manners of the command line: standard input, colours, completions, manual pages, names of files.

use crate::directory::{Directory, status, stderr, stdout};

const SPEC: &str = "component c {\n  ids { long x; };\n  task t { codel<start> f(in x) yield ether; };\n  \
                    task u { codel<start> g(in x) yield ether; };\n};\n";

#[test]
fn standard_input_is_a_specification() {
    let directory = Directory::new(&[("p.idl", "struct p { long x; };\n")]);
    let text = format!("#include \"p.idl\"\n{}", SPEC.replace("long x; }", "p x; lng y; }"));
    for name in ["-", "/dev/stdin"] {
        let output = directory.pipe(&["check", name], text.as_bytes());
        assert_eq!(status(&output), 1, "{}", stderr(&output));
        assert!(stdout(&output).contains("-:3:"), "{}", stdout(&output));
        assert!(stdout(&output).contains("checked 1 file: 1 error"), "{}", stdout(&output));
        assert_eq!(status(&directory.pipe(&["model", name], SPEC.as_bytes())), 0);
        assert!(stdout(&directory.pipe(&["tree", name], SPEC.as_bytes())).contains("COMPONENT"));
        let drawn = directory.pipe(&["diagram", "system", name], SPEC.as_bytes());
        assert!(stdout(&drawn).starts_with("<svg"), "{}", stderr(&drawn));
        let compared = directory.pipe(&["codels", "check", name], SPEC.as_bytes());
        assert_eq!(status(&compared), 0, "{}{}", stdout(&compared), stderr(&compared));
        let refused = directory.pipe(&["codels", "sync", name], SPEC.as_bytes());
        assert_eq!(status(&refused), 2);
        assert!(stderr(&refused).contains("name the specification"), "{}", stderr(&refused));
    }
    assert!(!directory.path().join("-").exists());
}

#[test]
fn colours_are_a_choice() {
    let directory = Directory::new(&[("c.gen", "struct b { lng x; };\n")]);
    let has = |arguments: &[&str]| stdout(&directory.run(arguments)).contains('\u{1b}');
    assert!(!has(&["check", "c.gen"]), "this is no terminal");
    assert!(has(&["check", "--color", "always", "c.gen"]));
    assert!(has(&["--color=always", "check", "c.gen"]));
    assert!(!has(&["check", "--color", "never", "c.gen"]));
    assert_eq!(status(&directory.run(&["check", "--color", "sometimes", "c.gen"])), 2);
}

#[test]
fn shells_complete_every_command() {
    let directory = Directory::new(&[]);
    for (shell, mark) in
        [("bash", "complete -F"), ("zsh", "#compdef dotgen"), ("fish", "complete -c dotgen")]
    {
        let output = directory.run(&["completions", shell]);
        assert_eq!(status(&output), 0);
        let script = stdout(&output);
        assert!(script.contains(mark), "{shell}");
        for word in ["check", "codels", "diagram", "verify", "--color"] {
            let word = word.trim_start_matches("--");
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn manual_pages_are_made_of_the_same_definitions() {
    let directory = Directory::new(&[]);
    assert_eq!(status(&directory.run(&["man", "pages"])), 0);
    let page = |name: &str| {
        let path = directory.path().join("pages").join(name);
        std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    assert!(page("dotgen.1").contains(".TH dotgen 1"));
    assert!(page("dotgen-codels-sync.1").contains("dry\\-run"));
    assert!(page("dotgen-check.1").contains("SARIF"));
}

#[test]
fn pictures_are_what_their_files_are_called() {
    let directory = Directory::new(&[("c.gen", SPEC)]);
    let read = |name: &str| std::fs::read(directory.path().join(name)).expect("a picture");
    let draw = |arguments: &[&str]| directory.run(&[&["diagram"], arguments].concat());
    assert_eq!(status(&draw(&["system", "c.gen", "-o", "c.png"])), 0);
    assert!(read("c.png").starts_with(b"\x89PNG"));
    assert_eq!(status(&draw(&["system", "c.gen", "-o", "c.mmd"])), 0);
    assert!(!read("c.mmd").starts_with(b"<svg"));
    assert_eq!(status(&draw(&["fsm", "c.gen", "--task", "t", "-o", "t.dot"])), 0);
    assert!(read("t.dot").starts_with(b"digraph"));
    let both = draw(&["system", "c.gen", "--format", "svg", "-o", "d.png"]);
    assert_eq!(status(&both), 2);
    assert!(stderr(&both).contains("`d.png` is the name of a png file"), "{}", stderr(&both));
    let several = draw(&["fsm", "c.gen", "-o", "all.svg"]);
    assert_eq!(status(&several), 2);
    assert!(
        stderr(&several).contains("there are 2 pictures, and `all.svg` is one file"),
        "{}",
        stderr(&several)
    );
    assert!(!directory.path().join("all.svg").exists());
    assert_eq!(status(&draw(&["fsm", "c.gen", "--format", "png", "-o", "all"])), 0);
    assert!(read("all/c.t.png").starts_with(b"\x89PNG"));
}

#[test]
fn only_what_ends_too_early_is_led_back_to_its_include() {
    let led_back = |included: &str| {
        let directory = Directory::new(&[("a.gen", "#include \"b.gen\"\n"), ("b.gen", included)]);
        stdout(&directory.run(&["check", "a.gen"])).contains("included here")
    };
    assert!(led_back("component b { task t {"));
    assert!(!led_back("component b { task t { codel<start> f(); }; };\n"));
}
