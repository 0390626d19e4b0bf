//! Each text is read and parsed once, and what is kept from one revision to the next is what a fresh project
//! finds.
//!
//! The environment variable `DOTGEN_TIMES` multiplies the number of edits: 250 gives 10,000.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{AnalysisHost, FileContent, Loader, PackageFlags};
use dotgen_codegen::codels::command::judge::{Judge, Known};
use dotgen_codegen::codels::command::{Project, check};
use dotgen_codegen::codels::edit::Edit;
use dotgen_codegen::codels::files::{Files, FilesConfig, IndexedFile, Indexes};
use dotgen_codegen::codels::stub::StubOptions;

use crate::codels::support::workspace;

/// Files in memory that count how often each is read, and each folder listed.
#[derive(Default)]
struct Counted {
    texts: BTreeMap<Utf8PathBuf, String>,
    calls: Mutex<BTreeMap<Utf8PathBuf, usize>>,
}

impl Counted {
    /// The files of `examples/drift`.
    fn drift() -> Counted {
        let folder = workspace().join("examples/drift");
        let names = ["tank.gen", "codels/tank_codels.c", "codels/tank_control_codels.c"];
        let read = |name| std::fs::read_to_string(folder.join(name)).expect("the example is there");
        let texts = names.map(|name| (Utf8Path::new("/").join(name), read(name)));
        Counted { texts: texts.into(), ..Counted::default() }
    }

    fn count(&self, path: &Utf8Path) {
        *self.calls.lock().expect("no test fails here").entry(path.to_owned()).or_default() += 1;
    }
}

impl Loader for Counted {
    fn read(&self, path: &Utf8Path) -> FileContent {
        self.count(path);
        match self.texts.get(path) {
            Some(text) => FileContent::Text(text.clone()),
            None => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

impl Files for Counted {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        self.count(path);
        self.texts.get(path).map(|text| text.as_str().into())
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        self.count(folder);
        let below = self.texts.keys().filter_map(|key| key.strip_prefix(folder).ok());
        Some(below.map(Utf8Path::to_owned).collect())
    }
}

fn roots() -> Vec<Utf8PathBuf> {
    vec!["/tank.gen".into()]
}

fn project<'p>(host: &'p mut AnalysisHost, files: &'p Counted) -> Project<'p> {
    Project::new(host, files, FilesConfig::default(), StubOptions::default())
}

/// The findings of both sides, the edits of their repairs, and the verdicts about fixes.
fn everything(project: &mut Project<'_>) -> String {
    let found = project.diagnostics(&roots());
    let mut out = format!("{found:#?}\n{:#?}", check(project, &roots()));
    for folder in project.folders(&roots(), &mut Vec::new()) {
        let all = folder.expected();
        for drift in project.findings(&folder, &all) {
            out += &format!("{drift:#?}\n");
            let stubs = project.stub_options(&folder.specification);
            for expected in all.iter().filter(|expected| expected.component == drift.component) {
                let repairs = project.repairs(&folder, expected, &stubs);
                let edits = drift.repairs.iter().map(|repair| repairs.edit(repair));
                out += &format!("{:#?}\n", edits.collect::<Vec<_>>());
            }
        }
    }
    let mut judge = Judge::new(project, &roots());
    for (fix, code) in found.iter().flat_map(|of| of.fixes.iter().map(|fix| (fix, of.code))).take(2)
    {
        let verdict = judge.verdict(&Edit::of(&fix.edits), Some(code));
        out += &format!("{}: {verdict:?}\n", fix.title);
    }
    out
}

#[test]
fn no_file_is_read_twice_and_no_folder_listed_twice() {
    let files = Arc::new(Counted::drift());
    let mut host = AnalysisHost::new(files.clone());
    let text = everything(&mut project(&mut host, &files));
    assert!(text.contains("Whole") || text.contains("Paired"), "no fix was tried");
    let calls = files.calls.lock().expect("no test fails here");
    let often: Vec<_> = calls.iter().filter(|call| *call.1 > 1).collect();
    assert!(often.is_empty(), "{often:?}");
    assert!(calls.len() > 3, "{calls:?}");
}

#[test]
fn an_edit_of_one_file_parses_one_file() {
    let files = Arc::new(Counted::drift());
    let mut host = AnalysisHost::new(files.clone());
    let indexes = Arc::new(Mutex::new(Indexes::default()));
    let mut project = project(&mut host, &files).sharing(indexes);
    let sources = |project: &mut Project<'_>| -> Vec<IndexedFile> {
        let folders = project.folders(&roots(), &mut Vec::new());
        folders.iter().flat_map(|folder| folder.sources.all().cloned()).collect()
    };
    let before = sources(&mut project);
    assert_eq!(before.len(), 2);
    let edited = before[0].path.clone();
    project.overlay(edited.clone(), format!("/* a comment */\n{}", before[0].text));
    let after = sources(&mut project);
    let same = std::iter::zip(&before, &after).map(|(a, b)| a.is(b));
    assert_eq!(same.collect::<Vec<_>>(), [false, true]);
    // Back to a text that was parsed before, and a change of the specification alone.
    project.overlay(edited, before[0].text.to_string());
    project.overlay(
        "/tank.gen".into(),
        format!("// a comment\n{}", files.texts["/tank.gen".as_ref() as &Utf8Path]),
    );
    let again = sources(&mut project);
    assert!(std::iter::zip(&before, &again).all(|(a, b)| a.is(b)));
}

#[test]
fn what_a_judge_knows_is_what_another_one_finds() {
    let files = Arc::new(Counted::drift());
    let mut host = AnalysisHost::new(files.clone());
    let mut project = project(&mut host, &files);
    let found = project.diagnostics(&roots());
    let fixes: Vec<_> = found
        .iter()
        .flat_map(|of| of.fixes.iter().map(|fix| (Edit::of(&fix.edits), of.code)))
        .collect();
    assert!(!fixes.is_empty());
    let mut verdicts = |known: Known| {
        let mut judge = Judge::knowing(&mut project, &roots(), known);
        let all: Vec<_> =
            fixes.iter().map(|(edit, code)| judge.verdict(edit, Some(code))).collect();
        (all, judge.room, judge.into_known())
    };
    let (first, room, known) = verdicts(Known::default());
    let (second, room_again, _) = verdicts(known);
    assert_eq!(first, second);
    assert!(room_again > room, "the second judge tried every edit again");
}

/// Pieces of text, for both sides.
const PIECES: [&str; 16] = [
    " ",
    "\n",
    ";",
    "{",
    "}",
    "/* x */",
    "\"",
    "yield ether",
    "in level",
    "codel<start> f() yield ether;",
    "return tank_ether;",
    "genom_event tank_new(const genom_context self) { return genom_ok; }\n",
    "#define X ",
    "static ",
    "tank_",
    "throw tank_e_empty;",
];

#[test]
fn incremental_equals_fresh() {
    let mut random = fastrand::Rng::with_seed(0x9e37_79b9_7f4a_7c15);
    let original = Counted::drift();
    let files = Arc::new(Counted::drift());
    let mut host = AnalysisHost::new(files.clone());
    let mut project = project(&mut host, &files);
    let mut texts = original.texts.clone();
    let paths: Vec<Utf8PathBuf> = texts.keys().cloned().collect();
    for number in 0..dotgen_loaders::times(40) {
        let path = &paths[random.usize(..paths.len())];
        let text = texts.get_mut(path).expect("one of the paths");
        let boundary =
            |at: usize| (0..=at).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        let start = boundary(random.usize(..=text.len()));
        match random.usize(..8) {
            0 => text.clone_from(&original.texts[path]),
            1..=3 => {
                let end = boundary((start + random.usize(1..40)).min(text.len())).max(start);
                text.replace_range(start..end, "");
            }
            _ => text.insert_str(start, PIECES[random.usize(..PIECES.len())]),
        }
        project.overlay(path.clone(), text.clone());
        let fresh = Arc::new(Counted { texts: texts.clone(), ..Counted::default() });
        let mut other = AnalysisHost::new(fresh.clone());
        let wanted = everything(&mut self::project(&mut other, &fresh));
        assert_eq!(everything(&mut project), wanted, "after edit {number}");
    }
}
