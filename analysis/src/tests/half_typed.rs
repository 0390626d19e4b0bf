//! Every editing feature at the end of every prefix of a text, as during typing: none may panic, and every
//! result must fit the text.

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::format::Options;

use super::random_edits::FILES;
use crate::{
    diagnostic::FileEdit,
    ide::{FilePosition, InlayConfig},
    test_support::{Fixture, split},
};

/// Runs all queries at one offset.
#[track_caller]
fn ask(fixture: &Fixture, path: &Utf8Path, text: &str, offset: usize) {
    let analysis = fixture.analysis();
    let at = FilePosition { path: path.to_owned(), offset };
    let fits = |range: &Range<usize>| {
        assert!(
            text.get(range.clone()).is_some(),
            "{path} at {offset}: {range:?} of {} bytes",
            text.len()
        );
    };
    let disjoint = |edits: &[FileEdit]| {
        let mut own: Vec<&FileEdit> = edits.iter().filter(|edit| edit.path == path).collect();
        for edit in &own {
            fits(&edit.range);
        }
        own.sort_by_key(|edit| (edit.range.start, edit.range.end));
        for pair in own.windows(2) {
            assert!(pair[0].range.end <= pair[1].range.start, "{pair:?}");
        }
    };
    for completion in analysis.completions(&at).unwrap() {
        fits(&completion.replace);
        assert!(
            completion.replace.start <= offset && offset <= completion.replace.end,
            "{completion:?}"
        );
    }
    if let Some(help) = analysis.signature_help(&at).unwrap() {
        assert!(help.active.is_none_or(|active| active < help.parameters.len()));
        assert!(
            help.parameters.iter().all(|parameter| help.label.get(parameter.clone()).is_some())
        );
    }
    if let Ok(found) = analysis.prepare_rename(&at).unwrap() {
        assert_eq!(text[found.range], found.info);
    }
    analysis.goto_implementation(&at).unwrap();
    for item in analysis.call_hierarchy(&at).unwrap().unwrap_or_default() {
        analysis.incoming_calls(path, &item.key).unwrap();
        analysis.outgoing_calls(path, &item.key).unwrap();
    }
    for assist in analysis.assists(path, offset..offset).unwrap() {
        disjoint(&assist.edits);
    }
    for typed in [';', '}', '\n'] {
        for format in analysis.format_on_type(&at, typed, &Options::default()).unwrap() {
            fits(&format.range);
            assert!(text[format.range].trim().is_empty());
        }
    }
}

/// Runs all queries on a whole file.
fn ask_file(fixture: &Fixture, path: &Utf8Path, text: &str) {
    let analysis = fixture.analysis();
    let whole = 0..text.len();
    for hint in analysis.inlay_hints(path, whole, &InlayConfig::default()).unwrap() {
        assert!(hint.at <= text.len());
    }
    for lens in analysis.code_lenses(path, &crate::ide::LensConfig::all(true)).unwrap() {
        assert!(text.get(lens.range.clone()).is_some());
        analysis.resolve_lens(path, &lens.kind).unwrap();
    }
    for format in analysis.format(path, None, &Options::default()).unwrap() {
        assert!(text[format.range].trim().is_empty());
    }
    analysis.organize_includes(path).unwrap();
}

/// Types a text: runs all queries at the end of its prefixes, `step` bytes apart.
fn type_in(fixture: &mut Fixture, path: &str, text: &str, step: usize) {
    let mut end = 0;
    while end <= text.len() {
        if text.is_char_boundary(end) {
            let prefix = &text[..end];
            fixture.edit(path, prefix);
            ask(fixture, Utf8Path::new(path), prefix, end);
            if end % (step * 8) == 0 {
                ask_file(fixture, Utf8Path::new(path), prefix);
            }
        }
        end += step;
    }
    fixture.edit(path, text);
}

#[test]
fn every_prefix_of_a_specification() {
    for (path, text) in split(FILES) {
        let mut fixture = Fixture::new(FILES);
        type_in(&mut fixture, path.as_str(), &text, 1);
    }
}

#[test]
fn every_offset_of_a_specification() {
    let fixture = Fixture::new(FILES);
    for (path, text) in split(FILES) {
        let offsets = (0..=text.len()).filter(|offset| text.is_char_boundary(*offset));
        for offset in offsets {
            ask(&fixture, &path, &text, offset);
        }
        ask_file(&fixture, &path, &text);
    }
}

/// Published specifications next to the project.
fn corpus() -> Vec<(Utf8PathBuf, String)> {
    let folder = dotgen_loaders::optional("corpus");
    let folder = folder.and_then(|folder| Utf8PathBuf::from_path_buf(folder).ok());
    let mut out = Vec::new();
    let mut folders = Vec::from_iter(folder);
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir_utf8().into_iter().flatten().flatten() {
            let path = entry.path().to_owned();
            if path.is_dir() {
                folders.push(path);
            } else if matches!(path.extension(), Some("gen" | "idl"))
                && let Ok(text) = std::fs::read_to_string(&path)
            {
                out.push((path, text));
            }
        }
    }
    out.sort();
    out
}

fn published(prefixes: usize, files: usize) {
    let all = corpus();
    let every = (all.len() / files.max(1)).max(1);
    for (path, text) in all.iter().step_by(every) {
        let fixture = format!("//- /main.gen\n{text}");
        let mut fixture = Fixture::new(&fixture);
        eprintln!("{path}");
        type_in(&mut fixture, "/main.gen", text, (text.len() / prefixes.max(1)).max(1));
    }
}

#[test]
fn some_prefixes_of_published_specifications() {
    published(12, 12);
}

#[test]
#[ignore = "an hour: every prefix of every published specification"]
fn every_prefix_of_published_specifications() {
    published(usize::MAX, usize::MAX);
}
