//! What commands write: bytes and line ends that are not theirs stay, all files or none, and one that cannot
//! be used keeps no other from being done. What they offer to write was tried.

use crate::directory::{Directory, status, stderr, stdout};

/// A component in Latin-1.
const SPEC: &str = "/* Andr\u{e9} */\ncomponent c {\n  version \"1.0\";\n  lang \"c\";\n  ids { long x; };\n  \
                    task t {\n    codel<start> f(in x) yield ether; // d\u{e9}but\n    codel<stop> g(in x) yield \
                    ether;\n  };\n};\n";

/// Its codels, with a byte order mark.
const SOURCE: &str = "\u{feff}/* \u{e9}t\u{e9} */\n#include \"acc.h\"\n#include \"c_c_types.h\"\n\n/* --- Task t \
                      ---------------------------------------------------------- */\n\n\n/** Codel f of task t.\n \
                      *\n * Triggered by c_start.\n * Yields to c_ether.\n */\ngenom_event\nf(int32_t x, const genom_context \
                      self)\n{\n  /* \u{e0} faire */ return c_ether;\n}\n";

/// As Latin-1, but for the byte order mark, with the line ends given.
fn bytes(text: &str, line_end: &str) -> Vec<u8> {
    let text = text.replace('\n', line_end);
    let byte = |c: char| match c {
        '\u{feff}' => vec![0xef, 0xbb, 0xbf],
        c => vec![u8::try_from(u32::from(c)).expect("Latin-1")],
    };
    text.chars().flat_map(byte).collect()
}

fn read(directory: &Directory, name: &str) -> Vec<u8> {
    std::fs::read(directory.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Every line of `old` is still there, in order; what is new ends its lines in the same way.
#[track_caller]
fn kept(old: &[u8], new: &[u8], line_end: &str) {
    let mut rest = new.split_inclusive(|byte| *byte == b'\n');
    for line in old.split_inclusive(|byte| *byte == b'\n') {
        assert!(
            rest.any(|part| part == line),
            "lost {:?} in\n{}",
            String::from_utf8_lossy(line),
            String::from_utf8_lossy(new)
        );
    }
    let lines = new.split_inclusive(|byte| *byte == b'\n');
    for line in lines.filter(|line| line.ends_with(b"\n")) {
        assert_eq!(
            line.ends_with(b"\r\n"),
            line_end == "\r\n",
            "{}",
            String::from_utf8_lossy(line)
        );
    }
    let replacement = "\u{fffd}".as_bytes();
    assert!(!new.windows(3).any(|window| window == replacement));
}

#[test]
fn stubs_leave_the_other_bytes_of_a_source() {
    for line_end in ["\n", "\r\n"] {
        let directory = Directory::new(&[]);
        directory.write("c.gen", &bytes(SPEC, line_end));
        directory.write("codels/c_t_codels.c", &bytes(SOURCE, line_end));
        let output = directory.run(&["codels", "stub", "c.gen"]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        assert_eq!(stdout(&output), "changed codels/c_t_codels.c\n");
        let new = read(&directory, "codels/c_t_codels.c");
        kept(&bytes(SOURCE, line_end), &new, line_end);
        assert!(String::from_utf8_lossy(&new).contains("\ng(int32_t x,"), "the stub is there");
        assert_eq!(read(&directory, "c.gen"), bytes(SPEC, line_end));
        let check = directory.run(&["codels", "check", "c.gen"]);
        assert_eq!(status(&check), 0, "{}{}", stdout(&check), stderr(&check));
    }
}

#[test]
fn synchronising_leaves_the_other_bytes_of_both_sides() {
    for line_end in ["\n", "\r\n"] {
        let directory = Directory::new(&[]);
        // The body yields what the specification does not know, and `g` is missing.
        let source = SOURCE.replace("return c_ether", "if (x) return c_stop; return c_ether");
        directory.write("c.gen", &bytes(SPEC, line_end));
        directory.write("codels/c_t_codels.c", &bytes(&source, line_end));
        let output = directory.run(&["codels", "sync", "c.gen"]);
        assert!(
            stdout(&output).contains("changed c.gen\n"),
            "{}{}",
            stdout(&output),
            stderr(&output)
        );
        let (spec, code) = (read(&directory, "c.gen"), read(&directory, "codels/c_t_codels.c"));
        let line = bytes("    codel<start> f(in x) yield ether", "\n");
        let changed = |old: Vec<u8>| {
            let lines = old.split_inclusive(|byte| *byte == b'\n');
            let lines = lines.filter(|bytes| !bytes.starts_with(&line));
            let lines = lines.filter(|line| !line.starts_with(b" * Yields to c_ether"));
            lines.collect::<Vec<_>>().concat()
        };
        kept(&changed(bytes(SPEC, line_end)), &spec, line_end);
        kept(&changed(bytes(&source, line_end)), &code, line_end);
        assert!(
            spec.windows(8).any(|window| window == b"// d\xe9but"),
            "the comment of the changed line"
        );
        let again = directory.run(&["codels", "sync", "c.gen"]);
        assert!(stderr(&again).contains("nothing to mend"), "{}{}", stdout(&again), stderr(&again));
    }
}

#[test]
fn formatting_leaves_all_but_blanks() {
    let scenario = |uses: &str| format!("scenario s {{\n  {uses}\"c.gen\"; // \u{e9}t\u{e9}\n}}\n");
    for line_end in ["\n", "\r\n"] {
        let directory = Directory::new(&[]);
        directory.write("c.gen", &bytes(&SPEC.replace("ids {", "ids   {"), line_end));
        directory.write("a.scn", &bytes(&scenario("use   "), line_end));
        let output = directory.run(&["fmt"]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let text = |bytes: Vec<u8>| -> Vec<u8> {
            bytes.into_iter().filter(|byte| !byte.is_ascii_whitespace()).collect()
        };
        let new = read(&directory, "c.gen");
        assert_eq!(text(new.clone()), text(bytes(SPEC, "\n")));
        kept(&bytes("/* Andr\u{e9} */\n", line_end), &new, line_end);
        assert_eq!(read(&directory, "a.scn"), bytes(&scenario("use "), line_end));
        let piped = directory.pipe(&["fmt", "-"], &bytes(SPEC, line_end));
        assert_eq!(piped.stdout, new);
    }
}

#[test]
fn merging_a_template_leaves_the_other_bytes() {
    for line_end in ["\n", "\r\n"] {
        let directory = Directory::new(&[]);
        directory.write("c.gen", &bytes(SPEC, line_end));
        let first = directory.run(&["generate", "skeleton", "c.gen"]);
        assert_eq!(status(&first), 0, "{}", stderr(&first));
        let written = String::from_utf8_lossy(&read(&directory, "codels/c_t_codels.c"))
            .replace('\u{fffd}', "?");
        let mine = written.replace("/* skeleton sample */ return", "/* \u{e9}t\u{e9} */ return");
        let mine =
            mine.lines().filter(|line| !line.contains("#include")).collect::<Vec<_>>().join("\n")
                + "\n";
        assert!(mine.contains("\u{e9}t\u{e9}"), "{mine}");
        directory.write("codels/c_t_codels.c", &bytes(&mine, line_end));
        let again = directory.run(&["generate", "skeleton", "-m", "auto", "c.gen"]);
        assert_eq!(status(&again), 0, "{}{}", stdout(&again), stderr(&again));
        let new = read(&directory, "codels/c_t_codels.c");
        kept(&bytes(&mine, line_end), &new, line_end);
        assert!(String::from_utf8_lossy(&new).contains("#include"), "what was missing is there");
    }
}

#[test]
fn what_is_shown_of_other_encodings_is_utf8() {
    let directory = Directory::new(&[]);
    directory.write("c.gen", &bytes(&SPEC.replace("long x", "lng x; /** caf\u{e9} */"), "\n"));
    for arguments in [
        &["check", "c.gen"][..],
        &["check", "--format", "json", "c.gen"],
        &["check", "--format", "sarif", "c.gen"],
        &["model", "c.gen"],
        &["tree", "c.gen"],
        &["codels", "stub", "--dry-run", "c.gen"],
    ] {
        let output = directory.run(arguments);
        let shown = stdout(&output) + &stderr(&output);
        let escapes = |c: char| (0x10_f780..=0x10_f7ff).contains(&u32::from(c));
        assert!(!shown.contains(escapes), "{arguments:?}: {shown}");
    }
    let text = stdout(&directory.run(&["tree", "c.gen"]));
    assert!(text.contains("Andr\u{fffd}"), "{text}");
}

#[test]
fn one_unusable_file_does_not_stop_the_others() {
    let directory = Directory::new(&[
        ("a.gen", "struct  a { long x ; } ;\n"),
        ("b.gen", "struct b { lng x; };\n"),
    ]);
    let checked = directory.run(&["check", "none.gen", "b.gen", "a.gen"]);
    assert_eq!(status(&checked), 2);
    assert!(stderr(&checked).contains("`none.gen`: no such file"), "{}", stderr(&checked));
    assert!(stdout(&checked).contains("checked 2 files"), "{}", stdout(&checked));
    let formatted = directory.run(&["fmt", "none.gen", "a.gen", "nowhere"]);
    assert_eq!(status(&formatted), 2);
    assert!(stderr(&formatted).contains("nowhere"), "{}", stderr(&formatted));
    assert_ne!(read(&directory, "a.gen"), b"struct  a { long x ; } ;\n");
    let compared = directory.run(&["codels", "check", "a.gen", "none.gen"]);
    assert_eq!(status(&compared), 2);
    let spec = "component c { ids { long x; }; task t { codel<start> f(in x) yield ether; }; };\n";
    directory.write("c.gen", spec.as_bytes());
    let drawn = directory.run(&["diagram", "fsm", "none.gen", "c.gen"]);
    assert_eq!(status(&drawn), 2);
    assert!(stdout(&drawn).starts_with("<svg"), "{}", stderr(&drawn));
}

#[cfg(unix)]
#[test]
fn names_that_are_no_utf8_are_told() {
    use std::os::unix::ffi::OsStrExt;
    let directory = Directory::new(&[("a.gen", "struct a { long x; };\n")]);
    let name = std::ffi::OsStr::from_bytes(b"caf\xe9.gen");
    if std::fs::write(directory.path().join(name), "struct b { long x; };\n").is_err() {
        dotgen_loaders::skip("this file system has no such names");
        return;
    }
    let output = directory.run(&["check", "."]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("its name is not UTF-8"), "{}", stderr(&output));
    assert!(stdout(&output).contains("checked 1 file"), "{}", stdout(&output));
    for command in ["check", "fmt", "model", "tree"] {
        let output = directory.command(&[command]).arg(name).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
    }
}

/// A folder without permissions, which its owner, or a user without rights, cannot list.
#[cfg(unix)]
#[test]
fn folders_that_cannot_be_listed_are_told() {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::CommandExt;
    let component = "component c { task t { codel<start> f() yield ether; }; };\n";
    let directory = Directory::new(&[("a.gen", component), ("sub/b.gen", component)]);
    directory.write("codels/deep/f.c", b"\n");
    let mode = |path: &str, mode| {
        let path = directory.path().join(path);
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("set");
    };
    mode(".", 0o755);
    mode("sub", 0o000);
    mode("codels/deep", 0o000);
    let root = directory.path().join("sub").read_dir().is_ok();
    let run = |arguments: &[&str]| {
        let mut command = directory.command(arguments);
        if root {
            command.uid(65534);
        }
        command.output()
    };
    let outputs = [
        run(&["check", "."]),
        run(&["check", "sub"]),
        run(&["fmt", "--check"]),
        run(&["verify", "sub"]),
        run(&["model", "."]),
        run(&["codels", "check", "a.gen"]),
    ];
    mode("sub", 0o700);
    mode("codels/deep", 0o700);
    for (at, output) in outputs.into_iter().enumerate() {
        let Ok(output) = output else {
            dotgen_loaders::skip("another user cannot run the program");
            return;
        };
        let told = stderr(&output);
        // The first one ends `model`.
        let folder = match at {
            4 if told.contains("deep") => "codels/deep",
            5 => "codels/deep",
            _ => "sub",
        };
        assert_eq!(status(&output), 2, "{at}: {told}");
        assert!(told.contains("cannot list the folder `"), "{at}: {told}");
        assert!(told.contains(&format!("{folder}`: ")), "{at}: {told}");
    }
}

#[test]
fn utf_16_is_told() {
    let text = "struct  a { long x ; } ;\n";
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let marked = [&b"\xff\xfe"[..], &little].concat();
    let directory = Directory::new(&[]);
    directory.write("marked.gen", &marked);
    directory.write("bare.gen", &little);
    directory.write("bare.scn", &little);
    for file in ["marked.gen", "bare.gen", "bare.scn"] {
        for arguments in [&["fmt"][..], &["fmt", "--check"], &["check"]] {
            let output = directory.run(&[arguments, &[file]].concat());
            assert_eq!(status(&output), 2, "{file}");
            let expected = format!("cannot read `{file}`: it is UTF-16; save it as UTF-8");
            assert!(stderr(&output).contains(&expected), "{}", stderr(&output));
        }
    }
    assert_eq!(read(&directory, "marked.gen"), marked);
    let below = directory.run(&["fmt", "."]);
    assert_eq!(status(&below), 2);
    assert!(stderr(&below).contains("`marked.gen`: it is UTF-16"), "{}", stderr(&below));
    let below = directory.run(&["check", "."]);
    assert_eq!(status(&below), 2);
    assert!(stdout(&below).contains("it is UTF-16; save it as UTF-8"), "{}", stdout(&below));
}

/// On a small file system of our own, in a namespace: full before all is written.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_changes_nothing() {
    let directory = Directory::new(&[]);
    let script = "mkdir full && mount -t tmpfs -o size=64k none full && cd full && cp ../*.gen . \
                  && head -c 1000000 /dev/zero > rest 2>/dev/null; \"$0\" fmt; echo $? > ../status; cp *.gen ../after; \
                  ls -A > ../names";
    let wide = |name: &str| {
        format!("struct  {name} {{ long x ; }} ;\n").repeat(1) + &"// text\n".repeat(1500)
    };
    for name in ["a", "b"] {
        directory.write(&format!("{name}.gen"), wide(name).as_bytes());
    }
    std::fs::create_dir(directory.path().join("after")).expect("a directory");
    let mut command = std::process::Command::new("unshare");
    command.args(["--user", "--map-root-user", "--mount", "sh", "-c", script]);
    let output = command.arg(env!("CARGO_BIN_EXE_dotgen")).current_dir(directory.path()).output();
    let (Ok(output), Ok(code)) = (output, std::fs::read_to_string(directory.path().join("status")))
    else {
        dotgen_loaders::skip("no file system can be mounted here");
        return;
    };
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if !directory.path().join("names").exists() || !said.contains("dotgen") && code.trim() != "2" {
        dotgen_loaders::skip(format_args!("no file system can be mounted here: {said}"));
        return;
    }
    assert_eq!(code.trim(), "2", "{said}");
    assert!(said.contains("none of the 2 files was changed"), "{said}");
    for name in ["a.gen", "b.gen"] {
        assert_eq!(read(&directory, &format!("after/{name}")), read(&directory, name), "{name}");
    }
    let names = String::from_utf8_lossy(&read(&directory, "names")).into_owned();
    assert_eq!(names, "a.gen\nb.gen\nrest\n", "nothing is left over");
}

/// A fix that there is no room to try is not offered, as one that was tried and refused. Here every fix adds
/// a codel without execution time, where the others have one.
#[test]
fn fixes_of_a_large_file_are_tried_or_left_out() {
    let activity = |i: usize| {
        format!(
            "  activity a{i}() {{ task t; codel<start> s{i}(out v) yield pause::start, ether wcet 1 ms;
                interrupt a{i}; }};\n"
        )
    };
    let activities: String = (0..20).map(activity).collect();
    for comment in [10, 300_000] {
        let text = format!(
            "/*{}*/\ncomponent c {{ version \"1\"; lang \"c\"; ids {{ long v; }}; task t {{ period 10 ms; }};\n\
             {activities}  attribute get(out v); }};\n",
            " ".repeat(comment)
        );
        let directory = Directory::new(&[("c.gen", &text)]);
        let output = directory.run(&["check", "c.gen", "--format", "json"]);
        let report: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON");
        let found = report["diagnostics"].as_array().expect("a list");
        let of_code = found.iter().filter(|diagnostic| diagnostic["code"] == "fsm/missing-stop");
        let fixes: Vec<&serde_json::Value> = of_code.map(|code| &code["fixes"]).collect();
        assert_eq!(fixes.len(), 20, "{report:#}");
        assert!(fixes.iter().all(|fix| **fix == serde_json::json!([])), "{fixes:#?}");
    }
}
