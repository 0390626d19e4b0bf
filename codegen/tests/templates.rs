//! The template engine with our own test templates: their output and files, and the containment of templates
//! that misbehave.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use dotgen_analysis::release::{Release, ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::compiler::Compiler;
use dotgen_codegen::template::console::CapturedConsole;
use dotgen_codegen::template::discover::SearchPath;
use dotgen_codegen::template::{
    Confinement, Confirmation, Limits, OutputSink, Run, TemplateResult, find_tclsh,
};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs::Vfs;
use dotgen_platform::process;

const SPECIFICATION: &str = r#"/*/ A lamp.
 * Second line.
 */
struct colour { double hue; string<8> name; };
component lamp {
  version "1.2";
  lang "c";
  ids { colour now; sequence<double, 3> steps; };
  exception e_burnt;
  port out colour light;
  task blink {
    period 10 ms;
    codel<start> lampStart(out ::ids, port out light) yield loop wcet 0.5 ms;
    codel<loop> lampLoop(inout now.hue::hue, port out light) yield pause::loop;
  };
  attribute setColour(in now) { validate lampCheck(local in now); };
  function reset() { codel lampReset(out steps); throw e_burnt; };
};
"#;

/// Runs one of our test templates; `None` without Tcl.
fn run(
    template: &str,
    args: &[&str],
    sink: OutputSink,
    limits: Limits,
) -> Option<(TemplateResult, CapturedConsole)> {
    if let Err(reason) = find_tclsh() {
        dotgen_loaders::skip(format_args!("{reason}"));
        return None;
    }
    let templates = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/templates");
    let search = SearchPath { dirs: vec![templates], builtin: None };
    // Previews are confined: the results of these tests are in temporary folders.
    let results = vec![std::env::temp_dir()];
    let confined = sink.preview.then_some(Confinement {
        results,
        confirmed: Confirmation::All,
        reviewed: false,
    });
    let run = Run {
        disk: Arc::new(SystemDisk),
        dir: search.find(&SystemDisk, template).unwrap(),
        args: args.iter().map(|argument| (*argument).to_owned()).collect(),
        search: &search,
        program: "/bin/dotgen".into(),
        cmdline: String::new(),
        verbose: false,
        debug: false,
        tmpdir: None,
        limits,
        base: PathBuf::new(),
        input_path: String::new(),
        processes: process::system(),
        confined: confined.as_ref(),
        allowed: Vec::new(),
    };
    let mut compiler = Compiler::new(
        Arc::new(SystemDisk),
        Arc::<Vfs>::default(),
        Vec::new(),
        Vec::new(),
        release(),
    );
    let mut console = CapturedConsole::default();
    let outcome = run.execute(&mut compiler, &mut console, sink);
    // Only dotgen itself can confine what it starts, and the engine warns of that.
    let lines = console.err.split_inclusive('\n');
    console.err = lines.filter(|line| !line.contains("does not confine templates")).collect();
    Some((outcome, console))
}

/// The release of the expectations.
fn release() -> ReleaseChoice {
    ReleaseChoice { release: Release::V2_99_39, origin: ReleaseOrigin::CommandLine }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn specification() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lamp.gen");
    std::fs::write(&path, SPECIFICATION).unwrap();
    (dir, path)
}

#[test]
fn templates_ask_about_the_model() {
    let (_dir, path) = specification();
    let path = path.to_str().unwrap();
    let Some((outcome, console)) = run("report", &[path], OutputSink::PREVIEW, Limits::default())
    else {
        return;
    };
    assert_eq!((outcome.status, console.err.as_str()), (0, ""));
    insta::assert_snapshot!(text(&console.out));
    let (outcome, console) =
        run("report", &["--language=c++", path], OutputSink::DIRECT, Limits::default()).unwrap();
    // An option written with `=` counts twice, so the file is still left for the template.
    assert_eq!((outcome.status, console.err.as_str()), (0, ""));
    assert!(
        text(&console.out).contains("genom::event lampStart(lamp::ids &ids, lamp::light &light)")
    );
}

/// The output of the template `types`.
fn types(specification: &str) -> Option<String> {
    printed("types", specification)
}

/// The output of one of our test templates.
fn printed(template: &str, specification: &str) -> Option<String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("it.gen");
    std::fs::write(&path, specification).unwrap();
    let path = path.to_str().unwrap();
    let (outcome, console) = run(template, &[path], OutputSink::PREVIEW, Limits::default())?;
    assert_eq!((outcome.status, console.err.as_str()), (0, ""));
    Some(text(&console.out))
}

#[test]
fn states_of_an_interface_come_with_its_codels() {
    let Some(found) = types(
        "interface i {
  typedef long d;
  task t {
    codel<go> f()
      yield
        on;
    codel<on> g() yield pause::go, ether;
  };
  port in d p;
};
component c {
  provides i;
  task t { codel<start> s() yield go; };
};
",
    ) else {
        return;
    };
    let own = found.lines().filter(|line| line.contains("::c::")).collect::<Vec<_>>();
    assert_eq!(
        own,
        [
            "event ::c::ether 11",
            "event ::c::start 11",
            "event ::c::stop 11",
            "event ::c::on 4",
            "event ::c::go 4",
            "pause event ::c::pause::go 7",
            "port ::c::p 9",
        ]
    );
}

#[test]
fn what_a_macro_declares_is_where_it_is_called() {
    let Some(found) = types(
        "#define PAIR(name) \\\n  struct name { long a, b; }
const long before = 1;

PAIR(one);
struct two { one x; };
",
    ) else {
        return;
    };
    let structs = found.lines().filter(|line| line.starts_with("struct ::")).collect::<Vec<_>>();
    assert_eq!(structs, ["struct ::one 5", "struct ::two 6"]);
}

#[test]
fn columns_are_those_after_preprocessing() {
    let Some(found) = printed(
        "columns",
        "#define SIZE 4
#define EMPTY
#define LIST(x) sequence<x, 12>
#define SUM (1 + 2)
struct s { long a[SIZE], b; EMPTY double c; LIST(long) d; /* comment */ long e[SUM], f; /* two
  lines */ long g; };
",
    ) else {
        return;
    };
    assert_eq!(found, "a 5 17\nb 5 23\nc 5 34\nd 5 56\ne 5 66\nf 5 79\ng 6 8\n");
}

#[cfg(unix)]
#[test]
fn included_files_are_named_after_following_links() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().canonicalize().unwrap();
    std::fs::create_dir(root.join("real")).unwrap();
    std::fs::write(root.join("real/t.idl"), "struct s { long x; };\n").unwrap();
    std::os::unix::fs::symlink(root.join("real"), root.join("link")).unwrap();
    let path = root.join("it.gen");
    std::fs::write(&path, "#include \"link/t.idl\"\n").unwrap();
    let path = path.to_str().unwrap();
    let Some((outcome, console)) =
        run("files-read", &[path], OutputSink::PREVIEW, Limits::default())
    else {
        return;
    };
    assert_eq!((outcome.status, console.err.as_str()), (0, ""));
    let idl = root.join("real/t.idl");
    let idl = idl.to_str().unwrap();
    assert_eq!(text(&console.out), format!("{path} {idl}\n{idl}\n"));
}

#[test]
fn numbers_are_one_token() {
    let Some(found) = printed(
        "initializers",
        "component c { function f(in octet a = 0x1Ful, in float b = 1.5e-7f, in float c = .5, in long d = 12); };\n",
    ) else {
        return;
    };
    assert_eq!(found, "a 1 45\nb 1 67\nc 1 84\nd 1 100\n");
}

#[test]
fn ids_are_declared_again_by_every_import() {
    let Some(found) = types(
        "interface i { ids { long x; }; };
component c { provides i; };
const long between = 1;
component c { extends i; };
",
    ) else {
        return;
    };
    let order = found
        .lines()
        .filter(|line| line.ends_with("ids 1") || line.starts_with("const"))
        .collect::<Vec<_>>();
    assert_eq!(order, ["struct ::i::ids 1", "const ::between 3", "struct ::c::ids 1"]);
}

#[test]
fn a_preview_writes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let out = out.to_str().unwrap();
    let Some((outcome, console)) =
        run("files", &["-C", out], OutputSink::PREVIEW, Limits::preview())
    else {
        return;
    };
    assert_eq!((outcome.status, console.err.as_str()), (0, ""));
    assert!(!Path::new(out).exists());
    assert!(outcome.sink.preview);
    let files = outcome.sink.files;
    let shown: Vec<(String, String, Option<u32>)> = files
        .iter()
        .map(|(path, file)| {
            let name = path.strip_prefix(out).unwrap().display().to_string();
            (name, text(&file.after), file.mode)
        })
        .collect();
    let file = |name: &str, text: &str, mode| (name.to_owned(), text.to_owned(), mode);
    assert_eq!(
        shown,
        [
            file("a/one.txt", "changed\n", None),
            file("run.sh", "#!/bin/sh\necho files\n", Some(0o755)),
        ]
    );
    let printed = text(&console.out).replace(out, "OUT");
    assert_eq!(
        printed,
        "creating OUT/a/one.txt\nOUT/a/one.txt is up-to-date\ncreating OUT/run.sh\n\
         refused: stop: file OUT/a/one.txt exists and would be overwritten.\n\
         overwriting OUT/a/one.txt\ndeps template.tcl\n"
    );
}

#[test]
fn a_preview_reaches_nothing_outside() {
    let dir = tempfile::tempdir().unwrap();
    let kept = dir.path().join("kept.txt");
    std::fs::write(&kept, "old\n").unwrap();
    let Some((outcome, console)) =
        run("outside", &[dir.path().to_str().unwrap()], OutputSink::PREVIEW, Limits::preview())
    else {
        return;
    };
    let printed = text(&console.out);
    let refused = printed.lines().filter(|line| line.ends_with(": 1")).count();
    // `file mkdir` is accepted, and no folder is made.
    assert_eq!(refused, 7, "{printed}");
    // Its last action is to overwrite a file, which the engine refuses too.
    assert_eq!(outcome.status, 2);
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), "old\n");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn templates_start_programs() {
    let Some((outcome, console)) = run("starts", &[], OutputSink::DIRECT, Limits::default()) else {
        return;
    };
    assert_eq!((outcome.status, console.err.as_str()), (0, ""));
    assert_eq!(text(&console.out), "hello\n<>\nHELLO\nsame\nread\n");
}

#[test]
fn endless_templates_are_stopped() {
    let limits = Limits { time: Some(Duration::from_millis(300)), ..Limits::default() };
    let Some((outcome, console)) = run("loops", &[], OutputSink::PREVIEW, limits) else {
        return;
    };
    assert_eq!(outcome.status, 2);
    assert_eq!(console.err, "loops: stopped: the template took too long\n");
}

#[test]
fn templates_can_be_cancelled() {
    let limits = Limits { cancel: Some(Arc::new(AtomicBool::new(true))), ..Limits::default() };
    let Some((outcome, console)) = run("loops", &[], OutputSink::PREVIEW, limits) else {
        return;
    };
    assert_eq!((outcome.status, console.err.as_str()), (2, "loops: cancelled\n"));
}

#[test]
fn floods_are_stopped() {
    let limits = Limits { output: Some(1 << 20), ..Limits::default() };
    let Some((outcome, console)) = run("prints", &[], OutputSink::PREVIEW, limits) else {
        return;
    };
    assert_eq!(outcome.status, 2);
    assert_eq!(console.err, "prints: stopped: the template printed or wrote more than 1 MiB\n");
    assert!(console.out.len() <= 1 << 20);
}

#[test]
fn a_dead_interpreter_is_an_error() {
    let Some((outcome, console)) = run("dies", &[], OutputSink::DIRECT, Limits::default()) else {
        return;
    };
    assert_eq!(outcome.status, 2);
    assert!(
        console.err.starts_with("dies: the Tcl interpreter ended before the template did"),
        "{}",
        console.err
    );
}

#[test]
fn exit_gives_the_status() {
    let Some((outcome, console)) = run("exits", &[], OutputSink::DIRECT, Limits::default()) else {
        return;
    };
    assert_eq!((outcome.status, console.err.as_str()), (7, "exits: exit 7\n"));
}

#[test]
fn errors_name_the_source_and_the_line() {
    for (source, first) in [
        ("procedure.txt", "fails: procedure.txt:4: no bread"),
        ("variable.txt", "fails: variable.txt:2: can't read \"nosuch\": no such variable"),
        ("unopened.txt", "fails: unopened.txt:1: missing opening tag"),
        (
            "adjacent.txt",
            "fails: adjacent.txt:1: wrong # args: should be \"set varName ?newValue?\"",
        ),
    ] {
        let args = ["-f", source];
        let Some((outcome, console)) = run("fails", &args, OutputSink::PREVIEW, Limits::default())
        else {
            return;
        };
        assert_eq!(outcome.status, 2);
        assert_eq!(console.err.lines().next(), Some(first));
    }
}

#[test]
fn a_missing_time_names_its_codel() {
    let (_dir, path) = specification();
    let argument = path.to_str().unwrap();
    let Some((outcome, console)) =
        run("times", &[argument], OutputSink::PREVIEW, Limits::default())
    else {
        return;
    };
    assert_eq!(outcome.status, 2);
    let first = console.err.lines().next().unwrap_or_default();
    let (start, end) = ("undefined member \"wcet\": codel `lampLoop` (", ") has none");
    assert!(first.contains(start) && first.contains(end), "{first}");
    assert!(first.contains("lamp.gen:"), "{first}");
}

#[test]
fn a_preview_shows_what_a_run_writes() {
    let (dir, path) = specification();
    let Some(templates) = std::env::var_os("DOTGEN_TEST_TEMPLATES") else {
        dotgen_loaders::skip("no data: DOTGEN_TEST_TEMPLATES names no directory of templates");
        return;
    };
    let search = SearchPath { dirs: vec![templates.into()], builtin: None };
    let run = |sink| {
        let out = dir.path().join("out").display().to_string();
        let run = Run {
            disk: Arc::new(SystemDisk),
            dir: search.find(&SystemDisk, "skeleton").unwrap(),
            args: vec!["-C".into(), out, path.display().to_string()],
            search: &search,
            program: String::new(),
            cmdline: String::new(),
            verbose: false,
            debug: false,
            tmpdir: None,
            limits: Limits::preview(),
            base: PathBuf::new(),
            input_path: String::new(),
            processes: process::system(),
            confined: None,
            allowed: Vec::new(),
        };
        let mut compiler = Compiler::new(
            Arc::new(SystemDisk),
            Arc::<Vfs>::default(),
            Vec::new(),
            Vec::new(),
            release(),
        );
        let mut console = CapturedConsole::default();
        let outcome = run.execute(&mut compiler, &mut console, sink);
        assert_eq!((outcome.status, console.err.as_str()), (0, ""));
        (outcome.sink, console.out)
    };
    let (preview, shown) = run(OutputSink::PREVIEW);
    let (_, printed) = run(OutputSink::DIRECT);
    assert_eq!(text(&shown), text(&printed));
    assert!(preview.preview);
    let files = preview.files;
    assert!(files.len() > 5);
    for (path, file) in files {
        assert_eq!(text(&std::fs::read(&path).unwrap()), text(&file.after));
    }
}
