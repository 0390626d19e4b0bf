//! Templates of GenoM3 that are known by their contents: ours, which need no Tcl, against the Tcl ones.
//!
//! GenoM3's templates and the specifications are not part of this repository: without them the tests are
//! skipped.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use dotgen_analysis::release::{Release, ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::command::{Environment, Ros2Packages, generate};
use dotgen_codegen::process::{Folder, Gap, Meter, Process, Processes, Program, Resources};
use dotgen_codegen::template::console::CapturedConsole;
use dotgen_codegen::template::{Limits, OutputSink, find_tclsh};

/// Counts what is started.
#[derive(Default)]
struct Counted(AtomicUsize);

impl Processes for Counted {
    fn start(&self, program: &Program) -> io::Result<Process> {
        self.0.fetch_add(1, Ordering::Relaxed);
        crate::processes::ShellProcesses.start(program)
    }
    fn renderer(&self, resources: Resources) -> Option<io::Result<Process>> {
        crate::processes::ShellProcesses.renderer(resources)
    }
    fn folder(&self, parent: Option<&Path>) -> io::Result<Box<dyn Folder>> {
        crate::processes::ShellProcesses.folder(parent)
    }
    fn gaps(&self) -> Vec<Gap> {
        crate::processes::ShellProcesses.gaps()
    }
    fn meter(&self, folders: Vec<PathBuf>) -> Meter {
        crate::processes::ShellProcesses.meter(folders)
    }
}

/// A folder in which a template writes, and the templates it is taken from.
struct Place<'a> {
    release: Release,
    templates: &'a Path,
    folder: tempfile::TempDir,
}

/// What came of a run.
#[derive(Debug, PartialEq, Eq)]
struct RunResult {
    status: i32,
    out: String,
    err: String,
    /// A character for each byte.
    files: BTreeMap<PathBuf, String>,
}

impl Place<'_> {
    /// Runs a template; tells how many programs that took as well.
    fn run(&self, words: &[&str]) -> (RunResult, usize) {
        let mut console = CapturedConsole::default();
        let started = Arc::new(Counted::default());
        let choice = ReleaseChoice { release: self.release, origin: ReleaseOrigin::Environment };
        let mut environment = Environment {
            name: "genom3",
            program: "/bin/genom3".into(),
            variables: &|name| (name == "PATH").then(|| std::env::var(name).ok()).flatten(),
            disk: Arc::new(crate::files::Files),
            loader: Arc::new(crate::disk::Disk),
            pictures: Arc::new(|_, _, _, _| Ok(String::new())),
            ros2: Arc::new(|_| Ok(Ros2Packages::default())),
            console: &mut console,
            limits: Limits::default(),
            base: self.folder.path().to_owned(),
            sink: OutputSink::Direct,
            processes: Arc::clone(&started) as Arc<dyn Processes>,
            confined: None,
            failed_at: None,
            project_templates: None,
            release: Some(choice),
        };
        let mut all = vec!["-t".to_owned(), self.templates.display().to_string()];
        all.extend(words.iter().map(|word| (*word).to_owned()));
        let status = generate(&all, &mut environment);
        let result = RunResult {
            status,
            out: String::from_utf8_lossy(&console.out)
                .replace(self.folder.path().to_str().expect("a name"), "FOLDER"),
            err: console.err.clone(),
            files: self.files(),
        };
        (result, started.0.load(Ordering::Relaxed))
    }

    fn files(&self) -> BTreeMap<PathBuf, String> {
        let all = walkdir::WalkDir::new(self.folder.path()).into_iter();
        let files = all
            .map(|directory| directory.expect("a folder"))
            .filter(|directory| directory.file_type().is_file());
        let with_text = files.map(|file| {
            let path = file.path().strip_prefix(self.folder.path()).expect("below").to_owned();
            let bytes = std::fs::read(file.path()).expect("a file");
            let text: String = bytes.into_iter().map(char::from).collect();
            // Files of the build repeat the options of the call.
            let templates = self.templates.to_str().expect("a name");
            (path, text.replace(templates, "TEMPLATES"))
        });
        with_text.collect()
    }
}

impl RunResult {
    /// Fails where another result differs, with what does.
    fn is(&self, expected: &RunResult, what: &str) {
        // Lines behind the first one are of Tcl: commands that led to an error.
        let err = |run: &RunResult| run.err.lines().next().map(str::to_owned);
        assert_eq!((self.status, err(self)), (expected.status, err(expected)), "{what}");
        assert_eq!(self.out, expected.out, "{what}");
        let names = |run: &RunResult| run.files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(self), names(expected), "{what}");
        for (name, text) in &expected.files {
            assert!(
                self.files[name] == *text,
                "{what}: {}\n{}\nexpected:\n{text}",
                name.display(),
                self.files[name]
            );
        }
    }
}

/// Templates of a release: as they are, and a copy that is not known.
struct Templates {
    release: Release,
    own: PathBuf,
    copy: tempfile::TempDir,
}

impl Templates {
    /// `None` when something is missing, which is told.
    fn new(release: Release, variable: &str) -> Option<Templates> {
        let own = std::env::var_os(variable).map(PathBuf::from);
        let Some(own) = own else {
            dotgen_loaders::skip(format_args!("no data: {variable} names no folder of templates"));
            return None;
        };
        if let Err(reason) = find_tclsh() {
            dotgen_loaders::skip(reason);
            return None;
        }
        let copy = tempfile::tempdir().expect("a folder");
        for template in ["skeleton", "mappings", "common"] {
            let to = copy.path().join(template);
            std::fs::create_dir(&to).expect("a folder");
            for entry in own.join(template).read_dir().expect("a template") {
                let entry = entry.expect("a file");
                std::fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
            }
            std::fs::write(to.join("one-more"), "").expect("a file");
        }
        Some(Templates { release, own, copy })
    }

    fn places(&self) -> [Place<'_>; 2] {
        [&self.own, &self.copy.path().to_owned()].map(|templates| Place {
            release: self.release,
            templates: if *templates == self.own { &self.own } else { self.copy.path() },
            folder: tempfile::tempdir().expect("a folder"),
        })
    }
}

/// All specifications beside the project.
fn specifications() -> Option<(PathBuf, Vec<PathBuf>)> {
    let shared = dotgen_loaders::shared("")?;
    let folders = ["corpus", "golden/inputs"].map(|text| shared.join(text));
    let all = folders.iter().flat_map(walkdir::WalkDir::new);
    let mut all: Vec<PathBuf> = all
        .map(|directory| directory.expect("a folder").into_path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "gen"))
        .collect();
    all.sort();
    Some((shared, all))
}

#[test]
fn ours_writes_what_tcl_writes_2_99_39() {
    ours_writes_what_tcl_writes(Release::V2_99_39, "DOTGEN_TEST_TEMPLATES");
}

#[test]
fn ours_writes_what_tcl_writes_2_99_41() {
    ours_writes_what_tcl_writes(Release::V2_99_41, "DOTGEN_TEST_TEMPLATES_2_99_41");
}

fn ours_writes_what_tcl_writes(release: Release, variable: &str) {
    let Some(templates) = Templates::new(release, variable) else {
        return;
    };
    let Some((shared, all)) = specifications() else {
        return;
    };
    let includes = ["corpus/quadcopter", "corpus/components/standins", "golden/standins"];
    let includes = includes.map(|include| format!("-I{}", shared.join(include).display()));
    let calls: [&[&str]; 5] = [
        &["skeleton", "-C", "out"],
        &["skeleton", "-l", "c++", "-t", "-C", "out/deeper"],
        &["mappings", "-l", "c"],
        &["mappings", "-l", "c++"],
        &["mappings", "-l", "c", "--signature"],
    ];
    let mut without = 0;
    for file in &all {
        let file = file.to_str().expect("a name");
        for call in calls {
            let [ours, tcl] = templates.places();
            let mut words: Vec<&str> = includes.iter().map(String::as_str).collect();
            words.extend(call);
            words.push(file);
            let (expected, _) = tcl.run(&words);
            let (found, started) = ours.run(&words);
            found.is(&expected, &format!("{call:?} {file}"));
            if started == 0 {
                without += 1;
            } else {
                assert_ne!(expected.status, 0, "{call:?} {file} needs Tcl");
            }
        }
    }
    assert!(without > 100, "{without} runs without Tcl");
}

/// A component whose task yields these states.
fn lamp(states: &str) -> String {
    format!(
        "/*/ A lamp. */
component lamp {{
  version \"1.2\"; lang \"c\"; doc \"Gives light.\"; require \"genom3 >= 2.99.26\";
  codels-require \"libm\", \"liblamp >= 2\";
  ids {{ boolean on; }};
  struct glow {{ double power; }};
  port out glow light {{ doc \"How much.\"; }};
  task blink {{ period 5 ms; codel<start> lampStart(out on, port out light) yield {states}; }};
  function reset(in long level = 3: \"How bright\") {{ codel lampReset(in level); }};
}};
"
    )
}

#[test]
fn ours_merges_as_tcl_merges() {
    for (release, variable) in [
        (Release::V2_99_39, "DOTGEN_TEST_TEMPLATES"),
        (Release::V2_99_41, "DOTGEN_TEST_TEMPLATES_2_99_41"),
    ] {
        let Some(templates) = Templates::new(release, variable) else {
            return;
        };
        let places = templates.places();
        let both = |words: &[&str], programs: usize| {
            let [(found, started), (expected, _)] =
                [&places[0], &places[1]].map(|place| place.run(words));
            found.is(&expected, &format!("{words:?}"));
            assert_eq!(started, programs, "programs for {words:?}");
            found
        };
        let specification = |states: &str| {
            let text = lamp(states);
            for place in &places {
                std::fs::write(place.folder.path().join("lamp.gen"), &text).expect("a file");
            }
        };
        specification("pause::start");
        let first = both(&["skeleton", "lamp.gen"], 0);
        assert_eq!((first.status, first.files.len()), (0, 11));
        let unchanged = both(&["skeleton", "lamp.gen"], 0);
        assert_eq!((unchanged.status, unchanged.files), (0, first.files));
        // Somebody writes a codel, and the specification grows.
        for place in &places {
            let path = place.folder.path().join("codels/lamp_blink_codels.c");
            let text = std::fs::read_to_string(&path).expect("a file");
            let text = text.replace(
                "  /* skeleton sample: insert",
                "  light++;\n  /* skeleton sample: insert",
            );
            std::fs::write(&path, text).expect("a file");
        }
        specification("pause::start, ether");
        let refused = both(&["skeleton", "lamp.gen"], 0);
        assert_eq!(refused.status, 2);
        let merged = both(&["skeleton", "-u", "lamp.gen"], 0);
        assert_eq!(merged.status, 0);
        let codels = &merged.files[Path::new("codels/lamp_blink_codels.c")];
        assert!(codels.contains("light++;"));
        for place in &places {
            let folder = place.folder.path();
            std::fs::create_dir_all(folder.join("specifications")).expect("a folder");
            let to = folder.join("specifications/lamp.gen");
            std::fs::copy(folder.join("lamp.gen"), to).expect("a copy");
        }
        let elsewhere = ["-C", "specifications", "skeleton", "-C", "elsewhere", "lamp.gen"];
        assert_eq!(both(&elsewhere, 0).status, 0);
        let printed = both(&["-C", "specifications", "mappings", "lamp.gen"], 0);
        assert!(printed.out.contains("A lamp."), "{}", printed.out);
        specification("ether");
        // A tool is run for what differs: the codels, and nothing else here.
        let by_tool = both(&["skeleton", "-m", "cp", "lamp.gen"], 1);
        assert_eq!(by_tool.status, 0);
        let forced = both(&["skeleton", "-f", "-t", "lamp.gen"], 0);
        assert_eq!(forced.status, 0);
    }
}
