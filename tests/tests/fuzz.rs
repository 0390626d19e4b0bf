//! The kept corpus, and random changes of it: no input makes anything panic, hang, or write outside of a
//! text.
//!
//! `FUZZ_SEED` is the first random number. With coverage: `cargo xtask fuzz`.

use dotgen_tests::fuzz::Target;
use dotgen_tests::fuzz::mutate::{Random, mutated};

fn fuzz(target: Target, inputs: u64) {
    let mut corpus = target.seeds();
    assert!(!corpus.is_empty(), "there is something to begin with");
    let kept = std::fs::read_dir(target.corpus()).into_iter().flatten().flatten();
    let mut kept: Vec<_> = kept.map(|entry| entry.path()).collect();
    kept.sort();
    corpus.extend(kept.iter().map(|path| std::fs::read(path).expect("a kept input")));
    for input in &corpus {
        tried(target, input);
    }
    let seed = std::env::var("FUZZ_SEED").ok().and_then(|seed| seed.parse().ok());
    let mut random = Random(seed.unwrap_or(1));
    for _ in 0..dotgen_loaders::times(inputs) {
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
    fuzz(Target::Specification, 150);
}

#[test]
fn formatter() {
    fuzz(Target::Format, 400);
}

#[test]
fn codels() {
    fuzz(Target::Codels, 40);
}

#[test]
fn scenarios() {
    fuzz(Target::Scenario, 200);
}

#[test]
fn messages() {
    fuzz(Target::Messages, 50);
}
