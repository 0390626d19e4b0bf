//! Runs one operation a given number of times, so that its instructions can be counted: `cargo xtask bench`
//! runs this program in valgrind.
//!
//! Arguments: `lex` or `parse`, and the number of rounds. Prints the number of tokens of one round.

use std::hint::black_box;

use dotgen_syntax::{lexer::lex, parse_text};

mod specification;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let what = arguments.next().unwrap_or_default();
    // Cargo passes `--bench` when it runs this itself.
    let rounds = arguments.next().and_then(|argument| argument.parse().ok()).unwrap_or(0);
    let text = specification::specification(23);
    for _ in 0..rounds {
        match what.as_str() {
            "lex" => drop(black_box(lex(black_box(&text)))),
            "parse" => drop(black_box(parse_text(black_box(&text)))),
            _ => {}
        }
    }
    println!("{}", lex(&text).len());
}
