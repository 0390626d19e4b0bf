//! Lexing and preprocessing, in bytes per second; run with `cargo bench -p dotgen-syntax`.

use std::fmt::Write;

use divan::{
    Bencher,
    counter::{BytesCount, ItemsCount},
};
use dotgen_syntax::{
    lexer::lex,
    preproc::{MacroEnv, NoIncludes, preprocess},
};

fn main() {
    divan::main();
}

/// A specification without macros, like published ones: many comments, an include guard.
fn plain(components: usize) -> String {
    let mut text =
        String::from("#ifndef H_ARM\n#define H_ARM\n#pragma requires \"openrobots-idl >= 1.0\"\n");
    for i in 0..components {
        let _ = write!(
            text,
            r#"
/* --- Component of one arm -------------------------------------------- */
component arm{i} {{
  version "1.{i}";
  lang    "c++";
  email   "somebody@example.org"; // who to ask
  require "genom3 >= 2.99.4";
  exception e_range {{ double min, max; }};

  ids {{
    double     joints[6];     /* measured positions, in radians */
    sequence<double, 16> targets;
    octet      mode;
  }};
  port out state::pose pose;
  task motion {{ period 10 ms; priority 100; stack 4000; }};

  activity reach(in double x = 0.0 : "x in the base frame (m)", in double y = .5 : "y") {{
    doc "Moves the tool to a point of the base frame.";
    task motion;
    validate check(in x, in y);
    codel <start> begin(in x, in y, out targets) yield run, ether;
    codel <run>   advance(inout targets, port out pose) yield pause::run, stop;
    codel <stop>  halt(out targets) wcet 200 us yield ether;
    throw e_range;
    interrupts reach;
  }};
}};
"#
        );
    }
    text.push_str("#endif\n");
    text
}

/// A specification as in [`plain`], with macros for the sizes and the declaration of ports.
fn with_macros(components: usize) -> String {
    let text = plain(components).replace("[6]", "[JOINTS]").replace("16>", "LIMIT(16)>");
    format!("#define JOINTS 6\n#define LIMIT(n) n\n{text}")
}

#[divan::bench(args = [1, 20, 1000])]
fn lexing(bencher: Bencher<'_, '_>, components: usize) {
    let text = plain(components);
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(lex(&text).len()))
        .bench(|| lex(divan::black_box(&text)));
}

#[divan::bench(args = [1, 20, 1000])]
fn preprocessing(bencher: Bencher<'_, '_>, components: usize) {
    bench_preprocess(bencher, &plain(components));
}

#[divan::bench(args = [1, 20, 1000])]
fn preprocessing_macros(bencher: Bencher<'_, '_>, components: usize) {
    bench_preprocess(bencher, &with_macros(components));
}

fn bench_preprocess(bencher: Bencher<'_, '_>, text: &str) {
    let raw = lex(text);
    let file = "arm.gen".into();
    bencher
        .counter(BytesCount::of_str(text))
        .counter(ItemsCount::new(raw.len()))
        .bench(|| preprocess(&file, text, &raw, MacroEnv::predefined(), &mut NoIncludes));
}
