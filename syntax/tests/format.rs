//! The formatter: its style, and that it changes nothing but white space.

use dotgen_syntax::format::{Align, Options, Unit, apply, format};
use dotgen_syntax::lexer::lex;
use dotgen_syntax::{SyntaxKind, parse_text};
use expect_test::{Expect, expect};

fn formatted(text: &str) -> String {
    let parse = parse_text(text);
    let broken: Vec<_> = parse.errors.iter().map(|e| e.range).collect();
    apply(text, &format(&parse.syntax(), &broken, None, &Options::default()))
}

/// Everything but blanks and line breaks, and the indentation of lines of block comments.
fn tokens(text: &str) -> Vec<(SyntaxKind, String)> {
    let raw = lex(text);
    let token = |i: usize| {
        let token = raw.text(text, i);
        let lines = token.split('\n').enumerate();
        let lines = lines.map(|(at, line)| match at {
            0 => line,
            _ => line.trim_start_matches([' ', '\t']),
        });
        match raw.kind(i) {
            SyntaxKind::BLOCK_COMMENT => lines.collect::<Vec<_>>().join("\n"),
            _ => token.to_owned(),
        }
    };
    (0..raw.len())
        .filter(|&i| !matches!(raw.kind(i), SyntaxKind::WHITESPACE | SyntaxKind::NEWLINE))
        .map(|i| (raw.kind(i), token(i)))
        .collect()
}

fn check(text: &str, expect: Expect) {
    let once = formatted(text);
    assert_eq!(tokens(text), tokens(&once), "tokens changed");
    assert_eq!(formatted(&once), once, "not idempotent");
    expect.assert_eq(&once);
}

#[test]
fn component() {
    check(
        "component   demo{version \"1.0\";lang\t\"c\"; codels-require \"lib >= 1\";\n\n\n\n port in or::state   state ;\n exception e_a,e_b{short code;string<128> what;};
 ids{ long x ;  // the x\n  struct s { double a [ 2 ]; } inner; /* nested */ };
     task t { period 5ms; codel<start> f ( out ::ids ) yield  pause::main,ether wcet 2 ms ;};
   activity a(in long x=3:\"count\",in s y = {.a=1,[2]=2}){ doc \"one\"
  \"two\"; task t; validate v(in x,\n inout inner . a [ 0 ]::q);
  async codel<start,\nmain> g(in x,
  out inner)
  yield ether;
  throw e_a; interrupts a; };};",
        expect![[r#"
            component demo {
              version "1.0";
              lang	"c";
              codels-require "lib >= 1";


              port in or::state state;
              exception e_a, e_b { short code; string<128> what; };
              ids {
                long x;  // the x
                struct s { double a[2]; } inner; /* nested */
              };
              task t { period 5ms; codel<start> f(out ::ids) yield pause::main, ether wcet 2 ms; };
              activity a(in long x = 3:"count", in s y = { .a = 1, [2] = 2 }) {
                doc "one"
                  "two";
                task t;
                validate v(in x,
                    inout inner.a[0]::q);
                async codel<start,
                  main> g(in x,
                    out inner)
                  yield ether;
                throw e_a;
                interrupts a;
              };
            };
        "#]],
    );
}

#[test]
fn types_and_constants() {
    check(
        "module m{const long a=-( 1+2 )*3<<2;typedef sequence<sequence<long> > t[3],u;
enum e{A,B,\nC};union w switch(e){case A:case B:long x;default:double y;};};\n\n\n#define X 3\n   #include \"a.idl\"\nconst long b = ::m::a;typedef sequence< ::m::t > v;",
        expect![[r#"
            module m {
              const long a = -(1 + 2) * 3 << 2;
              typedef sequence<sequence<long> > t[3], u;
              enum e {
                A, B,
                C
              };
              union w switch (e) { case A: case B: long x; default: double y; };
            };


            #define X 3
               #include "a.idl"
            const long b = ::m::a;
            typedef sequence< ::m::t> v;
        "#]],
    );
}

#[test]
fn a_broken_declaration_is_left_alone() {
    check(
        "component c {\n   task   t { period 5ms ;};\n   codel   <<  broken   here ;\n   function   f( ) ;\n};\n",
        expect![[r"
            component c {
              task t { period 5ms; };
              codel   <<  broken   here ;
              function f();
            };
        "]],
    );
}

#[test]
fn comments_stay() {
    check(
        "/* head */\n\n// one\ncomponent c { // open\n    // own line\n\n\n  task t; // t\n  function long_name(in long a, // first\n     in long b /* second */ );   // f\n  /* last */ };\n// end",
        expect![[r"
            /* head */

            // one
            component c { // open
              // own line


              task t; // t
              function long_name(in long a, // first
                  in long b /* second */);   // f
              /* last */
            };
            // end
        "]],
    );
}

/// The white space around a declaration must not decide whether the declaration is broken.
#[test]
fn a_broken_declaration_beside_a_brace_settles_at_once() {
    check(
        "component c {\n  ; struct s{long y,z;}task t{};\n};\nmodule m {\n  const   long b =}\n;\n",
        expect![[r"
            component c {
              ;
              struct s { long y, z; }
              task t { };
            };
            module m {
              const long b =
            };
        "]],
    );
}

#[test]
fn a_comment_before_a_value_settles_at_once() {
    check(
        "component c {\n  doc// why\n\"one\"\n\"two\";\n  version \"1\"; // first\n};\n",
        expect![[r#"
            component c {
              doc // why
                "one"
                "two";
              version "1"; // first
            };
        "#]],
    );
}

#[test]
fn comments_side_by_side_stay_there() {
    check(
        "component c {\n  require \"a\",\n/* one *//* two */\"b\";\n};\n",
        expect![[r#"
            component c {
              require "a",
                /* one */ /* two */ "b";
            };
        "#]],
    );
}

/// Found by fuzzing: the backslash went with the line end.
#[test]
fn a_line_end_with_a_joined_line_in_it_stays() {
    for text in
        ["\r\\\n\nstruct s { long x; };\n", "typedef long a;\n \r\\\r\n\ntypedef long b;\r\n"]
    {
        assert!(formatted(text).contains('\\'), "{text:?}");
    }
}

/// The line end at the end of the file would become part of the comment.
#[test]
fn a_comment_that_is_continued_by_nothing() {
    check(
        "task  t;\n// \\",
        expect![[r"
        task  t;
        // \"]],
    );
}

fn first_difference(a: &str, b: &str) -> String {
    let differs = a.lines().zip(b.lines()).position(|(a, b)| a != b).unwrap_or(0);
    let around = |text: &str| {
        text.lines().skip(differs.saturating_sub(2)).take(5).collect::<Vec<_>>().join("\n")
    };
    format!("line {differs}:\n{}\n--- then\n{}", around(a), around(b))
}

/// Every specification and interface of the shared test data.
fn shared_files() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let Some(root) = crate::suite::shared::shared("") else {
        return found;
    };
    let mut folders =
        vec![root.join("corpus"), root.join("golden/inputs"), root.join("conformance")];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else {
            continue;
        };
        for path in entries.flatten().map(|e| e.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "gen" || e == "idl")
                && let Ok(text) = std::fs::read_to_string(&path)
            {
                found.push((path.display().to_string(), text));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn defaults_stay_in_their_column() {
    check(
        "component c {
  activity go(in double x   = 0. : \"East\",  // first
              in double yaw = 1. : \"Heading\",
        in long n) { task t; };
  function f(in double x=0.,
             in double yaw   = 1.);
  attribute a(in x    =  1,
              in yaw  = 2);
};
",
        expect![[r#"
            component c {
              activity go(in double x   = 0. : "East",  // first
                          in double yaw = 1. : "Heading",
                          in long n) { task t; };
              function f(in double x = 0.,
                         in double yaw = 1.);
              attribute a(in x    = 1,
                          in yaw  = 2);
            };
        "#]],
    );
}

#[test]
fn real_files_keep_their_tokens_and_settle_at_once() {
    for (path, text) in shared_files() {
        let once = formatted(&text);
        assert_eq!(tokens(&text), tokens(&once), "{path}");
        let twice = formatted(&once);
        assert!(twice == once, "not idempotent: {path}\n{}", first_difference(&once, &twice));
    }
}

#[test]
fn damaged_files_keep_their_tokens() {
    // A simple generator is enough: only the reproducibility of the damage matters.
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below.max(1) as u64) as usize
    };
    for (path, text) in shared_files() {
        if text.len() > 8000 || text.is_empty() {
            continue;
        }
        for _ in 0..40 {
            let mut damaged = text.clone();
            for _ in 0..3 {
                let mut at = random(damaged.len());
                while !damaged.is_char_boundary(at) {
                    at -= 1;
                }
                if random(4) == 0 {
                    let cut = |character: char| character.len_utf8();
                    let end = at + damaged[at..].chars().take(6).map(cut).sum::<usize>();
                    damaged.replace_range(at..end, " ");
                }
                let noise = [
                    "{",
                    "}",
                    ";",
                    "(",
                    "/*",
                    "\"",
                    "\n",
                    "component ",
                    " \\\n",
                    "#if X\n",
                    "<",
                    "\t",
                    "//",
                    "// x\n",
                    "/* x */",
                    ")",
                    "};",
                    "\\\n",
                    "X",
                ];
                damaged.insert_str(at, noise[random(noise.len())]);
            }
            let once = formatted(&damaged);
            assert_eq!(tokens(&damaged), tokens(&once), "{path}\n{damaged}");
            let twice = formatted(&once);
            assert!(
                twice == once,
                "not idempotent: {path}\n{damaged}\n{}",
                first_difference(&once, &twice)
            );
        }
    }
}

/// The number of lines that formatting changes, and the lines over the width before and after.
fn changes(text: &str) -> (usize, usize, usize, usize) {
    let once = formatted(text);
    let over = |text: &str| text.lines().filter(|line| line.chars().count() > 80).count();
    let diff = similar::TextDiff::from_lines(text, &once);
    let changed = diff.iter_all_changes();
    let changed = changed.filter(|change| change.tag() == similar::ChangeTag::Delete).count();
    (text.lines().count(), changed, over(text), over(&once))
}

#[test]
fn published_components_change_little() {
    let Some(root) = crate::suite::shared::shared("corpus/components") else {
        return;
    };
    let mut lines = 0;
    let mut changed = 0;
    for (path, text) in shared_files() {
        if !std::path::Path::new(&path).starts_with(&root) {
            continue;
        }
        let (all, touched, before, after) = changes(&text);
        println!("{touched:>4} of {all:>4} lines, over the width {before} to {after}: {path}");
        assert!(after <= before, "{path}: longer lines than before");
        lines += all;
        changed += touched;
    }
    println!("{changed} of {lines}");
    assert!(changed * 10 <= lines, "{changed} of {lines} lines change");
}

fn with(options: Options, text: &str) -> String {
    let parse = parse_text(text);
    assert!(parse.errors.is_empty(), "{:?}", parse.errors);
    apply(text, &format(&parse.syntax(), &[], None, &options))
}

#[test]
fn the_files_own_unit_is_kept() {
    let two = "component c {\n  task t {\n    period 5 ms;\n  };\n};\n";
    let four = "component c {\n    task t {\n        period 5 ms;\n    };\n};\n";
    let tabs = "component c {\n\ttask t {\n\t\tperiod 5 ms;\n\t};\n};\n";
    for text in [two, four, tabs] {
        assert_eq!(formatted(text), text);
        let crlf = text.replace('\n', "\r\n");
        assert_eq!(formatted(&crlf), crlf);
    }
    let to = |unit| Options { unit: Some(unit), ..Options::default() };
    for text in [two, four, tabs] {
        assert_eq!(with(to(Unit::Spaces(2)), text), two);
        assert_eq!(with(to(Unit::Spaces(4)), text), four);
        assert_eq!(with(to(Unit::Tabs(8)), text), tabs);
    }
    let flat = "component c {\ntask t;\n};\n";
    let new = Options { otherwise: Unit::Spaces(4), ..Options::default() };
    assert_eq!(with(new, flat), "component c {\n    task t;\n};\n");
    assert_eq!(with(new, two), two);
}

#[test]
fn a_line_that_was_short_enough_stays_so() {
    let narrow = Options { width: 40, ..Options::default() };
    let text = "component c {
function move(in double x,in double y,in double z) {
codel f(in x,in y,in z);
};
};
";
    let expected = expect![[r"
        component c {
          function move(in double x,
              in double y, in double z) {
            codel f(in x, in y, in z);
          };
        };
    "]];
    // Its second line was over the width before.
    expected.assert_eq(&with(narrow, text));
    let expected = expect![[r"
        component c {
          function move(in double x, in double y,
              in double z) {
            codel f(in x, in y, in z);
          };
        };
    "]];
    let wide = Options { width: 52, ..Options::default() };
    let once = with(wide, text);
    expected.assert_eq(&once);
    assert_eq!(with(wide, &once), once);
}

#[test]
fn what_an_author_lays_out_stays() {
    let text = r#"component c {
  version		"1.0";
  lang			"c";
  port in	or::state state;

  attribute set(
    in body.min =: "least",
    in body.max = :"most") {
    validate check(local in min,
                   local in max);
  };
  activity log(in string<64> path = "/tmp/log": "file name",
      in long decimation = 1: "one of so many")
  {
    task t;  throw e;
    codel<start> f()
      yield ether;
  };
};
"#;
    let expected = text.replace("task t;  throw e;", "task t;\n    throw e;");
    assert_eq!(formatted(text), expected);
    let plain = Options { align: Align::None, ..Options::default() };
    assert_eq!(
        with(plain, "component c {\n  port in  t a;\n  port out t b; // one\n};\n"),
        "component c {\n  port in t a;\n  port out t b; // one\n};\n"
    );
}

#[test]
fn block_comments_move_as_a_block() {
    check(
        "component c {\n  task u;\n      /* one\n       *   two\n\n   three */\n      task t;\n};\n",
        expect![[r"
            component c {
              task u;
              /* one
               *   two

            three */
              task t;
            };
        "]],
    );
}

/// Texts that are one long line, or nested deeply, take time in proportion to their length: four times the
/// text takes much less than sixteen times the time.
#[test]
fn long_lines_and_deep_nesting_take_linear_time() {
    let list = |n: usize, item: &dyn Fn(usize) -> String, between: &str| {
        let all: Vec<String> = (0..n).map(item).collect();
        all.join(between)
    };
    let component =
        |text: String| format!("component c {{ version \"1\"; lang \"c\"; {text} }};\n");
    type Text<'a> = (&'a str, usize, &'a dyn Fn(usize) -> String);
    let texts: [Text<'_>; 8] = [
        ("exceptions", 5_000, &|n| {
            let names = list(n, &|i| format!("e{i}"), ", ");
            component(format!("exception {names};"))
        }),
        ("parameters", 5_000, &|n| {
            let all = list(n, &|i| format!("in long x{i}"), ", ");
            component(format!("function f({all}) {{ }};"))
        }),
        ("enumerators", 10_000, &|n| {
            format!("enum e {{ {} }};\n", list(n, &|i| format!("v{i}"), ", "))
        }),
        ("lines", 10_000, &|n| {
            let all = list(n, &|i| format!("v{i}"), ",\n  ");
            format!("enum e {{\n  {all}\n}};\n")
        }),
        ("labels", 10_000, &|n| {
            let all = list(n, &|i| format!("case {i}:"), " ");
            format!("union u switch (long) {{ {all} long x; }};\n")
        }),
        ("columns", 2_500, &|n| {
            let line = list(n, &|i| format!("v{i}"), ",  ");
            format!("enum e {{\n  {line},\n  {line},\n  {line}\n}};\n")
        }),
        ("sequences", 1_000, &|n| {
            let (open, close) = ("sequence<".repeat(n), ">".repeat(n));
            format!("typedef {open}long{close} t;\n")
        }),
        ("structs", 1_000, &|n| {
            let (open, close) = ("struct s { ".repeat(n), " } x; ".repeat(n));
            format!("{open}\nlong x;{close};\n")
        }),
    ];
    let time = |text: &str| {
        let parse = parse_text(text);
        let (root, broken) = (parse.syntax(), parse.broken());
        let start = std::time::Instant::now();
        std::hint::black_box(format(&root, &broken, None, &Options::default()));
        start.elapsed().as_secs_f64()
    };
    for (name, n, text) in texts {
        let (short, long) = (text(n), text(4 * n));
        // Other processes slow both down at times. One attempt that is linear is enough.
        let is_linear = (0..5).any(|_| time(&long) < 9.0 * time(&short));
        assert!(is_linear, "{name}");
    }
}
