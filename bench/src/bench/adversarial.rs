//! Worst-case texts: instructions of `dotgen check` for growing sizes.
//!
//! Twice the text may take twice the instructions, and slightly more for growing tables. A text that exceeds
//! this is reported, and the command fails.

use std::path::Path;

use anyhow::{Context, Result};

use xtask::run::{self, step};
use xtask::{target, tools};

/// Maximum factor of instructions for twice the text.
const LINEAR: f64 = 2.5;

/// A text of a given size.
type Text = fn(usize) -> String;

/// Measures every kind of text at `size`, at twice and at four times that. Returns true if all grow as
/// required.
pub(super) fn adversarial(dotgen: &Path, size: usize) -> Result<bool> {
    tools::ensure(tools::VALGRIND)?;
    let folder = target().join("adversarial");
    std::fs::create_dir_all(&folder)?;
    step(
        "Instructions of `dotgen check`, in millions, counted by valgrind; those of an empty file taken off",
    );
    let base = count(dotgen, &folder, "")?;
    println!("{:<28} {:>9} {:>9} {:>9}   growth", "text", size, 2 * size, 4 * size);
    let mut fine = true;
    for (name, text) in TEXTS {
        let mut counts = [0.0; 3];
        for (count_, times) in std::iter::zip(&mut counts, [1, 2, 4]) {
            *count_ =
                count(dotgen, &folder, &text(times * size))?.saturating_sub(base) as f64 / 1e6;
        }
        let growth = counts[2] / counts[1].max(0.1);
        let verdict = match growth > LINEAR {
            true => "  not linear",
            false => "",
        };
        fine &= verdict.is_empty();
        let [a, b, c] = counts;
        println!("{name:<28} {a:>9.1} {b:>9.1} {c:>9.1} {growth:>8.2}{verdict}");
    }
    Ok(fine)
}

/// Instructions of checking a text.
fn count(dotgen: &Path, folder: &Path, text: &str) -> Result<u64> {
    let (file, out) = (folder.join("adversarial.gen"), folder.join("callgrind.out"));
    std::fs::write(&file, text)?;
    let output = format!("--callgrind-out-file={}", out.display());
    let (dotgen, file) = (dotgen.to_string_lossy(), file.to_string_lossy());
    let arguments = ["--tool=callgrind", &output, &dotgen, "check", "--format", "json", &file];
    // The exit status reports errors in the text, which do not matter here.
    run::command(folder, "valgrind", &arguments).output()?;
    let text = std::fs::read_to_string(&out).context("valgrind wrote no counts")?;
    let mut lines = text.lines();
    let total =
        lines.find_map(|line| line.strip_prefix("summary: ").or(line.strip_prefix("totals: ")));
    Ok(total.context("no total in what valgrind wrote")?.trim().parse()?)
}

fn each(n: usize, one: impl FnMut(usize) -> String) -> String {
    (0..n).map(one).collect()
}

fn list(n: usize, one: impl FnMut(usize) -> String) -> String {
    (0..n).map(one).collect::<Vec<_>>().join(", ")
}

fn component(body: &str) -> String {
    format!("component c {{ version \"1.0\"; lang \"c\"; task t; {body} }};\n")
}

fn around(open: &str, n: usize, middle: &str, close: &str) -> String {
    open.repeat(n) + middle + &close.repeat(n)
}

const TEXTS: &[(&str, Text)] = &[
    ("conditionals, nested", |n| around("#if 1\n", n, "", "#endif\n")),
    ("conditionals, left out", |n| around("#if 0\n", n, "", "#endif\n")),
    ("conditionals with #else", |n| around("#ifdef A\n#else\n", n, "", "#endif\n")),
    ("conditionals without end", |n| "#if 1\n".repeat(n)),
    ("#elif, one after another", |n| around("#if 0\n", 1, &"#elif 0\n".repeat(n), "#endif\n")),
    ("condition, parentheses", |n| format!("#if {}\n#endif\n", around("(", n, "1", ")"))),
    ("condition, long", |n| format!("#if {}1\n#endif\n", "1 && ".repeat(n))),
    ("macros, a chain", |n| {
        each(n, |i| format!("#define A{i} A{}\n", i + 1))
            + &format!("#define A{n} long\ntypedef A0 t;\n")
    }),
    ("macros with arguments", |n| {
        each(n, |i| format!("#define A{i}(x) A{}(x)\n", i + 1))
            + &format!("#define A{n}(x) x\ntypedef A0(long) t;\n")
    }),
    ("macros, many used", |n| {
        each(n, |i| format!("#define A{i} {i}\n"))
            + &each(n, |i| format!("const long c{i} = A{i};\n"))
    }),
    ("macros, defined again", |n| each(n, |i| format!("#define A {i}\n"))),
    ("macros, undefined", |n| {
        each(n, |i| format!("#define A{i} 1\n")) + &each(n, |i| format!("#undef A{i}\n"))
    }),
    ("macros, many parameters", |n| {
        let names = list(n, |i| format!("a{i}"));
        format!("#define F({names}) long {}\n", names.replace(',', ""))
    }),
    ("macro calls, nested", |n| {
        format!("#define F(x) x\ntypedef {} t;\n", around("F(", n, "long", ")"))
    }),
    ("macros, doubling", |n| {
        each(60, |i| format!("#define A{} A{i} A{i}\n", i + 1))
            + &"const long x = A60;\n".repeat(n / 100)
    }),
    ("modules, nested", |n| each(n, |i| format!("module m{i} {{\n")) + &"};\n".repeat(n)),
    ("structs, nested", |n| {
        each(n, |i| format!("struct s{i} {{\n")) + "long x;\n" + &each(n, |i| format!("}} f{i};\n"))
    }),
    ("sequences, nested", |n| format!("typedef {} t;\n", around("sequence<", n, "long", ">"))),
    ("parentheses", |n| format!("const long x = {};\n", around("(", n, "1", ")"))),
    ("a long sum", |n| format!("const long x = {}1;\n", "1 + ".repeat(n))),
    ("initialisers, nested", |n| {
        component(&format!("ids {{ long v; }}; attribute a(in v = {});", around("{", n, "1", "}")))
    }),
    ("an initialiser, long", |n| {
        component(&format!(
            "ids {{ long v[{n}]; }}; attribute a(in v = {{ {} }});",
            list(n, |_| "1".into())
        ))
    }),
    ("a line, long", |n| {
        format!("/* {} */ const long {} = 1;\n", "x".repeat(10 * n), "y".repeat(10 * n))
    }),
    ("splices", |n| format!("const long x = {}1;\n", "\\\n".repeat(n))),
    ("stray characters", |n| "@ ".repeat(n)),
    ("no declarations", |n| "foo bar;\n".repeat(n)),
    ("types nobody declares", |n| each(n, |i| format!("typedef unknown{i} t{i};\n"))),
    ("one name, many constants", |n| "const long a = 1;\n".repeat(n)),
    ("one name, many structs", |n| "struct a { long x; };\n".repeat(n)),
    ("constants, a chain", |n| {
        "const long a0 = 1;\n".to_owned()
            + &each(n, |i| format!("const long a{} = a{i} + 1;\n", i + 1))
    }),
    ("typedefs, a chain", |n| {
        "typedef long a0;\n".to_owned() + &each(n, |i| format!("typedef a{i} a{};\n", i + 1))
    }),
    ("structs, each twice in the next", |n| {
        "struct a0 { long x; };\n".to_owned()
            + &each(n, |i| format!("struct a{} {{ a{i} x; a{i} y; }};\n", i + 1))
    }),
    ("an enumeration", |n| format!("enum e {{ {} }};\n", list(n, |i| format!("e{i}")))),
    ("a union", |n| {
        format!("union u switch (long) {{ {} }};\n", each(n, |i| format!("case {i}: long m{i}; ")))
    }),
    ("a struct", |n| format!("struct s {{ {} }};\n", each(n, |i| format!("long m{i}; ")))),
    ("a struct, one name", |n| format!("struct s {{ {} }};\n", "long m; ".repeat(n))),
    ("a module, opened again", |n| each(n, |i| format!("module m {{ typedef long t{i}; }};\n"))),
    ("components", |n| {
        each(n, |i| {
            format!("component c{i} {{ version \"1.0\"; lang \"c\"; ids {{ long v; }}; }};\n")
        })
    }),
    ("ports", |n| component(&each(n, |i| format!("port out long p{i}; ")))),
    ("tasks", |n| {
        component(&each(n, |i| format!("task t{i} {{ codel<start> f{i}() yield ether; }}; ")))
    }),
    ("activities", |n| {
        component(&each(n, |i| {
            format!("activity a{i}() {{ task t; codel<start> f{i}() yield ether; }}; ")
        }))
    }),
    ("activities that interrupt all", |n| {
        component(&each(n, |i| {
            format!(
                "activity a{i}() {{ task t; codel<start> f{i}() yield ether; interrupts all; }}; "
            )
        }))
    }),
    ("states, a chain", |n| {
        let states = each(n, |i| format!("codel<s{i}> f{i}() yield s{}; ", i + 1));
        component(&format!(
            "task u {{ codel<start> b() yield s0; {states} codel<s{n}> e() yield ether; }};"
        ))
    }),
    ("parameters", |n| {
        component(&format!("function f({});", list(n, |i| format!("in long p{i}"))))
    }),
    ("attributes", |n| {
        component(
            &("ids { long v; }; ".to_owned() + &each(n, |i| format!("attribute a{i}(in v); "))),
        )
    }),
    ("interfaces, a chain", |n| {
        "interface i0 { function f0(); };\n".to_owned()
            + &each(n, |i| format!("interface i{} {{ uses i{i}; }};\n", i + 1))
    }),
    ("braces without end", |n| "{".repeat(n)),
    ("components without end", |n| "component c { ".repeat(n)),
    ("braces that end nothing", |n| "};".repeat(n)),
    ("strings without end", |n| "const string s = \"abc\n".repeat(n)),
    ("comments that allow", |n| {
        each(n, |i| {
            format!("// dotgen: allow(unused/type) because x\nstruct s{i} {{ long x; }};\n")
        })
    }),
    ("pragmas", |n| "#pragma provides i\n".repeat(n)),
    ("includes of nothing", |n| each(n, |i| format!("#include \"m{i}.h\"\n"))),
    ("includes of itself", |n| {
        "#ifndef A\n#define A\n".to_owned()
            + &"#include \"adversarial.gen\"\n".repeat(n / 4)
            + "#endif\n"
    }),
];
