//! What is measured: commands on texts of any size, and requests of an editor.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use crate::bench::client::{Document, Editor};
use xtask::run;

/// Something that users do.
pub(super) struct Operation {
    /// Name in the file of budgets: at most 23 letters.
    pub(super) name: &'static str,
    /// Makes the input of a size in a folder. Returns the arguments of the program.
    pub(super) prepare: fn(dotgen: &Path, folder: &Path, size: usize) -> Result<Vec<String>>,
    /// What an editor does, if the program is a server.
    pub(super) session: Option<fn(&mut Editor, &Path) -> Result<()>>,
    /// Twice the input, so many times the instructions at most.
    pub(super) growth: f64,
}

/// The growth of an operation in proportion to the text.
const LINEAR: f64 = 2.2;

/// The growth of the analysis of tasks; 4.6 was measured for 4 and 8 tasks.
const OF_ANALYSIS: f64 = 5.0;

impl Operation {
    const fn command(
        name: &'static str,
        prepare: fn(&Path, &Path, usize) -> Result<Vec<String>>,
    ) -> Operation {
        Operation { name, prepare, session: None, growth: LINEAR }
    }

    /// A session of an editor over a component with codels.
    const fn session(
        name: &'static str,
        session: fn(&mut Editor, &Path) -> Result<()>,
    ) -> Operation {
        let prepare = |dotgen: &Path, folder: &Path, size: usize| {
            with_codels(dotgen, folder, size)?;
            command(&["lsp"])
        };
        Operation { name, prepare, session: Some(session), growth: LINEAR }
    }
}

/// The name of the specification.
const FILE: &str = "arm.gen";
/// The name of the source of its codels.
const CODELS: &str = "codels/arm_main_codels.c";

pub(super) const OPERATIONS: &[Operation] = &[
    Operation::command("start", |_, _, _| command(&["--version"])),
    Operation::command("explain", |_, _, _| command(&["explain", "fsm/undefined-state"])),
    Operation::command("check", |_, folder, size| on_file(folder, size, &["check", FILE])),
    Operation::command("check with errors", |_, folder, size| {
        let text = specification(size / 4).replace("yield pause::step", "yield pause::stop");
        std::fs::write(folder.join(FILE), text)?;
        command(&["check", FILE])
    }),
    Operation::command("check with hints", |_, folder, size| {
        let text = specification(size / 4).replace("    interrupt go", "    before go");
        std::fs::write(folder.join(FILE), text)?;
        command(&["check", FILE])
    }),
    Operation::command("fmt", |_, folder, size| on_file(folder, size, &["fmt", FILE])),
    Operation::command("tree", |_, folder, size| on_file(folder, size, &["tree", FILE])),
    Operation::command("model", |_, folder, size| on_file(folder, size, &["model", FILE])),
    Operation::command("diagram fsm", |_, folder, size| {
        on_file(folder, size, &["diagram", "fsm", FILE, "-o", "out"])
    }),
    Operation::command("generate json-schema", |_, folder, size| {
        on_file(folder, size, &["generate", "json-schema", FILE])
    }),
    Operation::command("generate python", |_, folder, size| {
        on_file(folder, size, &["generate", "python", FILE])
    }),
    Operation::command("codels stub", |_, folder, size| {
        on_file(folder, size, &["codels", "stub", FILE])
    }),
    Operation::command("codels check", |dotgen, folder, size| {
        with_codels(dotgen, folder, size)?;
        command(&["codels", "check", FILE])
    }),
    Operation::command("check with codels", |dotgen, folder, size| {
        with_codels(dotgen, folder, size / 4)?;
        let text = specification(size / 4).replace("    interrupt go", "    before go");
        std::fs::write(folder.join(FILE), text)?;
        command(&["check", FILE])
    }),
    Operation::session("first lenses", |editor, folder| {
        let opened = editor.open(FILE, &std::fs::read_to_string(folder.join(FILE))?)?;
        ask(editor, "textDocument/codeLens", &opened)?;
        // What begins with the server has ended before the server does.
        ask(editor, "textDocument/diagnostic", &opened)?;
        editor.request("workspace/symbol", json!({ "query": "arm" }))?;
        Ok(())
    }),
    Operation::session("keystroke", |editor, folder| typed(editor, folder, FILE, "task main;")),
    Operation::session("keystroke in a codel", |editor, folder| {
        typed(editor, folder, CODELS, "genom_event")
    }),
    Operation::session("code actions", |editor, folder| {
        let text = std::fs::read_to_string(folder.join(FILE))?;
        let opened = editor.open(FILE, &text)?;
        ask(editor, "textDocument/diagnostic", &opened)?;
        let at = place(&text, "activity go0")?;
        let range = json!({ "start": at, "end": at });
        let params = json!({ "textDocument": { "uri": opened.uri }, "range": range,
            "context": { "diagnostics": [] } });
        editor.request("textDocument/codeAction", params)?;
        Ok(())
    }),
    Operation::command("run", |_, folder, size| {
        std::fs::write(folder.join(FILE), specification(4))?;
        let until = format!("{} ms", 20 * size);
        let until = ["run", "--simulate", "all", "--bounds", "none", "--until", &until, FILE];
        command(&until)
    }),
    Operation {
        growth: OF_ANALYSIS,
        ..Operation::command("verify", |_, folder, size| {
            std::fs::write(folder.join(FILE), tasks(size / 4))?;
            command(&["verify", FILE])
        })
    },
];

fn command(arguments: &[&str]) -> Result<Vec<String>> {
    let words = arguments.iter().map(|argument| (*argument).to_owned());
    Ok(words.collect())
}

/// Writes a specification with the stubs of its codels.
fn with_codels(dotgen: &Path, folder: &Path, size: usize) -> Result<()> {
    std::fs::write(folder.join(FILE), specification(size))?;
    // A verification in the background takes as long as the machine lets it.
    std::fs::write(folder.join("dotgen.toml"), "[verification]\nenable = false\n")?;
    let program = dotgen.to_string_lossy();
    run::capture(run::command(folder, &program, &["codels", "stub", FILE]))?;
    Ok(())
}

/// Types a comment before a text, a letter at a time, and asks for diagnostics after each.
fn typed(editor: &mut Editor, folder: &Path, name: &str, before: &str) -> Result<()> {
    let text = std::fs::read_to_string(folder.join(name))?;
    let mut opened = editor.open(name, &text)?;
    ask(editor, "textDocument/diagnostic", &opened)?;
    let at = place(&text, before)?;
    let (line, start) = (at["line"].as_u64().unwrap_or(0), at["character"].as_u64().unwrap_or(0));
    for (number, letter) in "x = y; /* typed */".chars().enumerate() {
        let column = start as usize + number;
        editor.edit(&mut opened, line as usize, [column; 2], &letter.to_string())?;
        ask(editor, "textDocument/diagnostic", &opened)?;
    }
    Ok(())
}

fn ask(editor: &mut Editor, method: &str, document: &Document) -> Result<()> {
    editor.request(method, json!({ "textDocument": { "uri": document.uri } }))?;
    Ok(())
}

/// The position of the last occurrence of a text.
fn place(text: &str, wanted: &str) -> Result<Value> {
    let at = text.rfind(wanted).with_context(|| format!("no `{wanted}`"))?;
    let line = text[..at].matches('\n').count();
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    Ok(json!({ "line": line, "character": at - start }))
}

fn on_file(folder: &Path, size: usize, arguments: &[&str]) -> Result<Vec<String>> {
    std::fs::write(folder.join(FILE), specification(size))?;
    command(arguments)
}

/// A component with `size` activities of fourteen lines, ports, attributes and types.
fn specification(size: usize) -> String {
    let mut out = "\
struct pose { double x, y, z; };
exception lost { string<64> why; };
component arm {
  version \"1.0\"; lang \"c\";
  ids { pose current; };
  task main { period 10 ms;
    codel<start> first(out current) yield step wcet 10 us;
    codel<step> next(inout current) yield pause::step wcet 10 us; };
"
    .to_owned();
    for i in 0..size {
        _ = write!(
            out,
            "
  struct reading{i} {{ unsigned long stamp; sequence<pose, 16> points; }};
  port out reading{i} out{i};
  ids {{ pose goal{i}; }};
  attribute set{i}(in goal{i} = {{ 0., 0., 0. }} : \"where to go\");
  /** Goes somewhere. */
  activity go{i}(in pose to = : \"where\", in double speed = {i}.5 : \"in m/s\") {{
    task main;
    throw lost;
    validate check{i}(in to, in speed) wcet 10 us;
    codel<start> begin{i}(in to, out goal{i}) yield step, ether wcet 10 us;
    codel<step> step{i}(in speed, in goal{i}, in current, port out out{i}) yield pause::step, ether wcet 10 us;
    codel<stop> end{i}(out goal{i}) yield ether wcet 10 us;
    interrupt go{i};
  }};
"
        );
    }
    out + "};\n"
}

/// A component with periodic tasks alone.
fn tasks(count: usize) -> String {
    let mut out =
        "component arm {\n  version \"1.0\"; lang \"c\";\n  ids { long n; };\n".to_owned();
    for i in 0..count {
        _ = writeln!(
            out,
            "  task t{i} {{ period {} ms;\n    codel<start> f{i}() yield pause::start wcet 100 us; }};",
            10 << (i % 3)
        );
    }
    out + "};\n"
}
