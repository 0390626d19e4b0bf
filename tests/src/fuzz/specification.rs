//! Specifications.

use std::ops::Range;
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::host::{AnalysisHost, Change, FileContent, Loader, PackageFlags};
use dotgen_analysis::ide::FilePosition;
use dotgen_syntax::encoding;
use dotgen_syntax::format::{self, Options};

/// An interface that the inputs may include.
const INTERFACE: &str =
    "interface device { struct reading { double value; }; port out reading state; };\n";

/// Finds one interface, and packages only where none is asked for.
struct InterfaceLoader;

impl Loader for InterfaceLoader {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match path.as_str() {
            "/device.gen" => FileContent::Text(INTERFACE.into()),
            _ => FileContent::Missing,
        }
    }

    fn packages(&self, names: &[String]) -> Result<PackageFlags, String> {
        match names {
            [] => Ok(PackageFlags::default()),
            _ => Err("there are no packages".to_owned()),
        }
    }
}

/// Checks an input, applies each fix alone, and asks at one place what editors ask.
pub(super) fn analyse(input: &[u8]) {
    let text = encoding::decode(input.to_vec());
    let path = Utf8Path::new("/text.gen");
    let mut host = AnalysisHost::new(Arc::new(InterfaceLoader));
    host.apply(Change {
        files: vec![(path.to_owned(), Some(text.clone()))],
        roots: Some(vec![path.to_owned()]),
        ..Change::default()
    });
    let analysis = host.analysis();
    let diagnostics = analysis.diagnostics(path).expect("nothing cancels");
    for diagnostic in &diagnostics {
        assert!(
            !diagnostic.message.to_string().is_empty(),
            "a finding without words: {diagnostic:?}"
        );
        is_in(&text, &diagnostic.range);
        for fix in &diagnostic.fixes {
            for edit in fix.edits.iter().filter(|edit| edit.path == path) {
                is_in(&text, &edit.range);
            }
        }
    }
    // The place depends on the text alone, so that a fault repeats.
    let sum = input.iter().fold(0usize, |sum, byte| sum.wrapping_mul(31) + usize::from(*byte));
    let mut offset = sum % (text.len() + 1);
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    let at = FilePosition { path: path.to_owned(), offset };
    let hover = analysis.hover(&at).expect("nothing cancels");
    if let Some(hover) = hover {
        is_in(&text, &hover.range);
    }
    for completion in analysis.completions(&at).expect("nothing cancels") {
        is_in(&text, &completion.replace);
    }
    drop(analysis.goto_definition(&at));
    drop(analysis.references(&at, true));
    drop(analysis.signature_help(&at));
    drop(analysis.prepare_rename(&at));
    drop(analysis.assists(path, offset..offset));
    drop(analysis.document_symbols(path));
    drop(analysis.folding_ranges(path));
}

/// Formats an input.
pub(super) fn format(input: &[u8]) {
    let text = encoding::decode(input.to_vec());
    let once = formatted(&text);
    let solid =
        |text: &str| -> String { text.chars().filter(|character| !is_blank(*character)).collect() };
    assert_eq!(solid(&text), solid(&once), "the formatter changed more than blanks");
    assert_eq!(once, formatted(&once), "formatted twice is not formatted once");
    assert_eq!(encoding::encode(&text), input, "reading and writing changes bytes");
}

fn formatted(text: &str) -> String {
    let parse = dotgen_syntax::parse_text(text);
    let root = parse.syntax();
    assert_eq!(root.text().to_string(), text, "the tree is not its text");
    let broken: Vec<_> = parse.errors.iter().map(|error| error.range).collect();
    format::apply(text, &format::format(&root, &broken, None, &Options::default()))
}

fn is_blank(character: char) -> bool {
    matches!(character, ' ' | '\t' | '\n' | '\r' | '\u{b}' | '\u{c}')
}

/// Ranges are of the text, between characters.
fn is_in(text: &str, range: &Range<usize>) {
    assert!(text.get(range.clone()).is_some(), "{range:?} is no part of {} bytes", text.len());
}
