//! What is measured: commands on texts of any size.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;

use xtask::run;

/// Something that users do.
pub(super) struct Operation {
    /// Name in the file of budgets: at most 23 letters.
    pub(super) name: &'static str,
    /// Makes the input of a size in a folder. Returns the arguments of the program.
    pub(super) prepare: fn(dotgen: &Path, folder: &Path, size: usize) -> Result<Vec<String>>,
}

/// The name of the specification.
const FILE: &str = "arm.gen";

pub(super) const OPERATIONS: &[Operation] = &[
    Operation { name: "start", prepare: |_, _, _| command(&["--version"]) },
    Operation { name: "explain", prepare: |_, _, _| command(&["explain", "fsm/undefined-state"]) },
    Operation { name: "check", prepare: |_, folder, size| on_file(folder, size, &["check", FILE]) },
    Operation {
        name: "check with errors",
        prepare: |_, folder, size| {
            let text = specification(size / 4).replace("yield pause::step", "yield pause::stop");
            std::fs::write(folder.join(FILE), text)?;
            command(&["check", FILE])
        },
    },
    Operation {
        name: "check with hints",
        prepare: |_, folder, size| {
            let text = specification(size / 4).replace("    interrupt go", "    before go");
            std::fs::write(folder.join(FILE), text)?;
            command(&["check", FILE])
        },
    },
    Operation { name: "fmt", prepare: |_, folder, size| on_file(folder, size, &["fmt", FILE]) },
    Operation { name: "tree", prepare: |_, folder, size| on_file(folder, size, &["tree", FILE]) },
    Operation { name: "model", prepare: |_, folder, size| on_file(folder, size, &["model", FILE]) },
    Operation {
        name: "diagram fsm",
        prepare: |_, folder, size| on_file(folder, size, &["diagram", "fsm", FILE, "-o", "out"]),
    },
    Operation {
        name: "generate json-schema",
        prepare: |_, folder, size| on_file(folder, size, &["generate", "json-schema", FILE]),
    },
    Operation {
        name: "generate python",
        prepare: |_, folder, size| on_file(folder, size, &["generate", "python", FILE]),
    },
    Operation {
        name: "codels stub",
        prepare: |_, folder, size| on_file(folder, size, &["codels", "stub", FILE]),
    },
    Operation {
        name: "codels check",
        prepare: |dotgen, folder, size| {
            let prepared = on_file(folder, size, &["codels", "check", FILE])?;
            let program = dotgen.to_string_lossy();
            run::capture(run::command(folder, &program, &["codels", "stub", FILE]))?;
            Ok(prepared)
        },
    },
    Operation {
        name: "run",
        prepare: |_, folder, size| {
            std::fs::write(folder.join(FILE), specification(4))?;
            let until = format!("{} ms", 20 * size);
            let until = ["run", "--simulate", "all", "--bounds", "none", "--until", &until, FILE];
            command(&until)
        },
    },
    Operation {
        name: "verify",
        prepare: |_, folder, size| {
            std::fs::write(folder.join(FILE), tasks(size / 4))?;
            command(&["verify", FILE])
        },
    },
];

fn command(arguments: &[&str]) -> Result<Vec<String>> {
    let words = arguments.iter().map(|argument| (*argument).to_owned());
    Ok(words.collect())
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
