//! Text to tree, in bytes and tokens per second; run with `cargo bench -p dotgen-syntax --bench parse`.

use divan::{
    Bencher,
    counter::{BytesCount, ItemsCount},
};
use dotgen_syntax::{
    Fragment,
    lexer::lex,
    parse, parse_text,
    preproc::{MacroEnv, NoIncludes, preprocess},
};

mod specification;

use specification::specification;

fn main() {
    divan::main();
}

/// About 700, 5,000 and 300,000 lines.
const SIZES: [usize; 3] = [23, 165, 10_000];

#[divan::bench(args = SIZES)]
fn whole(bencher: Bencher<'_, '_>, components: usize) {
    let text = specification(components);
    assert_eq!(parse_text(&text).errors, []);
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(lex(&text).len()))
        .bench(|| parse_text(&text));
}

#[divan::bench(args = SIZES)]
fn tree_alone(bencher: Bencher<'_, '_>, components: usize) {
    let text = specification(components);
    let raw = lex(&text);
    let pre = preprocess(&"".into(), &text, &raw, MacroEnv::default(), &mut NoIncludes);
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(raw.len()))
        .bench(|| parse(&text, &raw, &pre, Fragment::Specification));
}

#[divan::bench(args = SIZES)]
fn broken_text(bencher: Bencher<'_, '_>, components: usize) {
    let text = specification(components).replace(';', " ");
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(lex(&text).len()))
        .bench(|| parse_text(&text));
}
