//! No text makes the analysis panic, and every diagnostic has a known code and a place in its text.

use std::{fs, path::Path, sync::Arc};

use camino::Utf8Path;
use dotgen_analysis::{
    host::{AnalysisHost, BatchInput, FileContent, Input, Loader, PackageFlags},
    model_json,
};
use proptest::prelude::*;

struct EmptyLoader;

impl Loader for EmptyLoader {
    fn read(&self, _: &Utf8Path) -> FileContent {
        FileContent::Missing
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Err("no packages here".to_owned())
    }
}

/// Words of all fixtures: the text without its spaces.
fn texts() -> Vec<Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let fixtures = fs::read_dir(folder.join("codes")).unwrap();
    let fixtures = fixtures.map(|fixture| fixture.unwrap().path());
    let all = fixtures.chain([folder.join("model/everything.gen")]);
    let mut paths: Vec<_> = all.collect();
    paths.sort();
    let words = |text: String| {
        let mut words: Vec<String> = Vec::new();
        for c in text.chars() {
            match words.last_mut() {
                Some(last) if c.is_alphanumeric() && last.chars().all(char::is_alphanumeric) => {
                    last.push(c);
                }
                _ => words.push(c.to_string()),
            }
        }
        words
    };
    let files = paths.iter().filter(|path| path.is_file());
    let texts = files.map(|file| fs::read_to_string(file).unwrap());
    texts.map(words).collect()
}

fn check(text: &str) {
    let host = AnalysisHost::new(Arc::new(EmptyLoader));
    let input = BatchInput {
        inputs: vec![Input::Text { name: "/text.gen".into(), text: text.into() }],
        ..BatchInput::default()
    };
    let unit = host.analysis().batch(&input).unwrap();
    for diagnostic in unit.diagnostics.iter() {
        assert!(diagnostic.range.end <= text.len(), "{diagnostic:?}");
        assert!(!diagnostic.message.to_string().is_empty());
    }
    let _ = model_json::to_json(&unit.spec, Some(&*unit.locations));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Two fixtures joined, then words dropped, doubled, moved or exchanged.
    #[test]
    fn shuffled_words(
        which in any::<(prop::sample::Index, prop::sample::Index)>(),
        edits in prop::collection::vec((0..4u8, any::<prop::sample::Index>(), any::<prop::sample::Index>()), 0..12),
    ) {
        let texts = texts();
        let mut words = texts[which.0.index(texts.len())].clone();
        words.extend(texts[which.1.index(texts.len())].iter().cloned());
        for (kind, a, b) in edits {
            if words.is_empty() {
                break;
            }
            let (a, b) = (a.index(words.len()), b.index(words.len()));
            match kind {
                0 => {
                    words.remove(a);
                }
                1 => words.insert(b, words[a].clone()),
                2 => words[b] = words[a].clone(),
                _ => words.swap(a, b),
            }
        }
        check(&words.concat());
    }
}
