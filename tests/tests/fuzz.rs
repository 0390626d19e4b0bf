//! The kept corpus, and random changes of it: no input makes anything panic, hang, or write outside of a
//! text.
//!
//! `FUZZ_INPUTS` says how many changed inputs of each kind there are, `FUZZ_SEED` where the random numbers
//! begin. With coverage: `cargo xtask fuzz`.

use dotgen_tests::fuzz::Target;
use dotgen_tests::fuzz::mutate::{Random, mutated};

fn number(name: &str, default: usize) -> usize {
    let value = std::env::var(name).ok();
    value.and_then(|variable| variable.parse().ok()).unwrap_or(default)
}

fn fuzz(target: Target, inputs: usize) {
    let mut corpus = target.seeds();
    assert!(!corpus.is_empty(), "there is something to begin with");
    let kept = std::fs::read_dir(target.corpus()).into_iter().flatten().flatten();
    let mut kept: Vec<_> = kept.map(|entry| entry.path()).collect();
    kept.sort();
    corpus.extend(kept.iter().map(|path| std::fs::read(path).expect("a kept input")));
    for input in &corpus {
        tried(target, input);
    }
    let mut random = Random(number("FUZZ_SEED", 1) as u64);
    for _ in 0..number("FUZZ_INPUTS", inputs) {
        let input = &corpus[random.below(corpus.len())];
        let other = &corpus[random.below(corpus.len())];
        tried(target, &mutated(input, other, target.words(), &mut random));
    }
}

/// A fault leaves its input behind, ready to become part of the corpus.
fn tried(target: Target, input: &[u8]) {
    let result = std::panic::catch_unwind(|| target.run(input));
    if let Err(panic) = result {
        let path = std::env::temp_dir().join(format!("dotgen-fuzz-{}", target.name()));
        std::fs::write(&path, input).expect("a place for the input");
        eprintln!("{target:?}: the input is in {}", path.display());
        std::panic::resume_unwind(panic);
    }
}

#[test]
fn specifications() {
    fuzz(Target::Specification, 600);
}

#[test]
fn formatter() {
    fuzz(Target::Format, 1500);
}

#[test]
fn codels() {
    fuzz(Target::Codels, 300);
}

#[test]
fn scenarios() {
    fuzz(Target::Scenario, 600);
}

#[test]
fn messages() {
    fuzz(Target::Messages, 150);
}
