//! A new name in a specification is followed by the sources: what is told apart, what is listed, and
//! random renames of published components, whose codels compile afterwards as they did before.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{AnalysisHost, FileContent, Loader, PackageFlags};
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::progress::Progress;
use dotgen_codegen::codels::edit::apply;
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::{Files, FilesConfig, Sources};
use dotgen_codegen::codels::folder::{Folder, folders};
use dotgen_codegen::codels::headers::headers;
use dotgen_codegen::codels::rename::{RenameRefusal, Renaming, rename};
use dotgen_codegen::lang::Language;

use crate::codels::project::{Overlay, examples, host_over, published};
use crate::codels::support::{compile, compiler, temporary, write};

/// A specification with its codels, as they are before a rename.
struct Before {
    files: Arc<Overlay>,
    root: Utf8PathBuf,
    includes: Vec<Utf8PathBuf>,
}

/// What became of it.
struct After {
    files: Overlay,
    renaming: Renaming,
}

impl Before {
    fn memory(specification: &str, codels: &[(&str, &str)]) -> Before {
        let mut texts = BTreeMap::from([("/c.gen".into(), specification.to_owned())]);
        for (name, text) in codels {
            texts.insert(Utf8PathBuf::from("/").join(name), (*text).to_owned());
        }
        Before {
            files: Arc::new(Overlay { texts, disk: false }),
            root: "/c.gen".into(),
            includes: Vec::new(),
        }
    }

    fn host(&self) -> AnalysisHost {
        host_over(self.files.clone(), self.includes.clone())
    }

    fn folders(&self, host: &AnalysisHost) -> Vec<Folder> {
        let unit = host.analysis().root_unit(&self.root).expect("not cancelled");
        folders(&unit, &mut |path| Sources::load(path, &FilesConfig::default(), &*self.files))
    }

    /// `code: message` of everything, with the number of each.
    fn diagnostics(&self) -> BTreeMap<String, usize> {
        let host = self.host();
        let unit = host.analysis().root_unit(&self.root).expect("not cancelled");
        let mut out = BTreeMap::new();
        let codes = unit.diagnostics.iter().map(|diagnostic| diagnostic.code.to_string());
        let mut all: Vec<String> = codes.collect();
        if unit.accepted() {
            for folder in self.folders(&host) {
                let found = folder.check(&folder.expected());
                all.extend(found.iter().map(|check| check.code().to_owned()));
            }
        }
        for code in all {
            *out.entry(code).or_default() += 1;
        }
        out
    }

    /// Renames what stands at an offset of the specification; `None` when analysis refuses.
    fn rename(&self, offset: usize, to: &str) -> Option<Result<After, RenameRefusal>> {
        let host = self.host();
        let analysis = host.analysis();
        let at = FilePosition { path: self.root.clone(), offset };
        let edits = analysis.rename(&at, to, &Progress::default()).expect("not cancelled").ok()?;
        let unit = analysis.edited_root_unit(&self.root, &edits).expect("not cancelled");
        assert!(unit.accepted(), "{:?}", unit.diagnostics);
        let mut after = After { files: (*self.files).clone(), renaming: Renaming::default() };
        for folder in self.folders(&host) {
            match rename(&folder, &unit, &*self.files) {
                Ok(one) => {
                    assert!(after.renaming.edit.merge(one.edit));
                    after.renaming.left.extend(one.left);
                }
                Err(why) => return Some(Err(why)),
            }
        }
        for change in edits {
            let edit = &mut after.renaming.edit;
            edit.replace(&change.path, change.range, change.new_text);
        }
        for (path, edits) in &after.renaming.edit.changed {
            let text = Files::read(&*self.files, path).expect("an edited file");
            after.files.texts.insert(path.clone(), apply(&text, edits));
        }
        Some(Ok(after))
    }
}

const SPEC: &str = "component c {\n  lang \"c\";\n  exception bad { short n; };\n  struct point { double x; double y; };\n  \
    struct other { double x; };\n  enum color { RED, BLUE };\n  ids { point here; other there; color paint; };\n  \
    port out point place;\n  task t {\n    period 10 ms;\n    codel<start> go(ids inout here, ids in there, port out place) yield wait;\n    \
    codel<wait> stay(ids inout c::self_ids) yield pause::wait, ether;\n    throw bad;\n  };\n};\n";

const CODELS: &str = "#include \"c_c_types.h\"\n#define WAITING c_wait\n#define X(p) ((p)->x)\n#define GLUE(s) c_ ## s\n\
    /** Codel go of task t.\n *\n * Triggered by c_start.\n * Yields to c_wait.\n * Throws c_bad.\n */\n\
    genom_event\ngo(c_point *here, const c_other *there, const c_place *place, const genom_context self)\n{\n  \
    c_point local = { .x = 1., .y = 2. }, *p = &local;\n  here->x = there->x + p->x + place->data(self)->x;\n  \
    /* c_wait is next */\n  log(\"c_wait\", unknown()->x);\n  if (here->x > 3.) {\n    c_bad_detail d = { 1 };\n    return c_bad(&d, self);\n  }\n  \
    return c_wait;\n}\n\
    genom_event stay(c_ids *self_ids, const genom_context self)\n{\n  c_point c_wait_time = self_ids->here;\n  \
    return self_ids->paint == c_RED && c_wait_time.x > 0 ? c_pause_wait : c_ether;\n}\n";

fn spec() -> String {
    SPEC.replace("ids inout c::self_ids", "ids inout ::self_ids")
}

/// The lines of the codels that a rename changes, and what it leaves.
#[track_caller]
fn renamed(at: &str, to: &str) -> (Vec<String>, Vec<String>) {
    let before = Before::memory(&spec(), &[("codels/c_t_codels.c", CODELS)]);
    let offset = spec().find(at).expect("it is there");
    let after = before.rename(offset, to).expect("it can be renamed");
    let after = after.expect("the sources follow");
    let text = after.files.texts[Utf8Path::new("/codels/c_t_codels.c")].clone();
    let changed = CODELS.lines().zip(text.lines()).filter(|(a, b)| a != b);
    let changed = changed.map(|(_, line)| line.trim().to_owned()).collect();
    let left = after.renaming.left.iter().map(ToString::to_string);
    let found = Before { files: Arc::new(after.files), ..before };
    let _ = found.diagnostics();
    (changed, left.collect())
}

/// In C, the event of the state `run` of component `c` and a codel `c_run` are one word.
#[test]
fn a_codel_and_an_event_of_one_name_are_two_things() {
    let specification = "component c {\n  lang \"c\";\n  task t {\n    codel<start> c_run() yield run, ether;\n    \
        codel<run> c_halt() yield ether;\n  };\n};\n";
    let code = "#include \"acc.h\"\n/* --- Task t --- */\n\n\
        /** Codel c_run of task t.\n *\n * Triggered by c_start.\n * Yields to c_run, c_ether.\n */\ngenom_event\nc_run(const genom_context self)\n{\n  if (0) return c_ether;\n  \
        return c_run;\n}\ngenom_event\nc_halt(const genom_context self)\n{\n  (void)c_run(self);\n  return c_ether;\n}\n";
    let before = Before::memory(specification, &[("codels/c_t_codels.c", code)]);
    let source = |after: After| after.files.texts[Utf8Path::new("/codels/c_t_codels.c")].clone();
    let at = specification.find("c_run").expect("the codel");
    let after = before.rename(at, "c_begin").expect("a rename").expect("the codels follow");
    let code_of = |function: &str, event: &str| {
        code.replace("\nc_run(", &format!("\n{function}("))
            .replace("Codel c_run", &format!("Codel {function}"))
            .replace("to c_run", &format!("to {event}"))
            .replace(")c_run(", &format!("){function}("))
            .replace("return c_run;", &format!("return {event};"))
    };
    assert_eq!(source(after), code_of("c_begin", "c_run"));
    let at = specification.find("codel<run>").expect("the state") + "codel<".len();
    let after = before.rename(at, "go").expect("a rename").expect("the codels follow");
    assert_eq!(source(after), code_of("c_run", "c_go"));
    // A name that the sources declare is refused for a codel of either kind.
    let taken = code.replace("c_halt(const", "c_begin(const") + "int c_other;\n";
    let before = Before::memory(specification, &[("codels/c_t_codels.c", &taken)]);
    let at = specification.find("c_run").expect("the codel");
    assert!(before.rename(at, "c_other").expect("a rename").is_err());
}

#[test]
fn states_are_followed_with_their_events() {
    let (changed, left) = renamed("wait;", "hold");
    assert_eq!(
        changed,
        [
            "#define WAITING c_hold",
            "* Yields to c_hold.",
            "return c_hold;",
            "return self_ids->paint == c_RED && c_wait_time.x > 0 ? c_pause_hold : c_ether;",
        ]
    );
    let wanted = [
        "/codels/c_t_codels.c:4: `c_` in a macro",
        "/codels/c_t_codels.c:16: `c_wait` in a comment",
        "/codels/c_t_codels.c:17: `c_wait` in a string",
    ];
    assert_eq!(left, wanted);
}

#[test]
fn members_are_followed_where_their_structure_is_known() {
    let (changed, left) = renamed("x; double y", "east");
    assert_eq!(
        changed,
        [
            "c_point local = { .east = 1., .y = 2. }, *p = &local;",
            "here->east = there->x + p->east + place->data(self)->east;",
            "if (here->east > 3.) {",
            "return self_ids->paint == c_RED && c_wait_time.east > 0 ? c_pause_wait : c_ether;",
        ]
    );
    let wanted = [
        "/codels/c_t_codels.c:3: `x` in a macro",
        "/codels/c_t_codels.c:17: `x` a member of something whose type is not known",
    ];
    assert_eq!(left, wanted);
}

#[test]
fn ids_types_ports_and_exceptions_are_followed() {
    let (changed, _) = renamed("here;", "spot");
    assert_eq!(
        changed,
        [
            "go(c_point *spot, const c_other *there, const c_place *place, const genom_context self)",
            "spot->x = there->x + p->x + place->data(self)->x;",
            "if (spot->x > 3.) {",
            "c_point c_wait_time = self_ids->spot;",
        ]
    );
    let (changed, _) = renamed("place;", "site");
    assert_eq!(
        changed,
        [
            "go(c_point *here, const c_other *there, const c_site *site, const genom_context self)",
            "here->x = there->x + p->x + site->data(self)->x;",
        ]
    );
    let (changed, _) = renamed("bad {", "e_bad");
    assert_eq!(
        changed,
        ["* Throws c_e_bad.", "c_e_bad_detail d = { 1 };", "return c_e_bad(&d, self);",]
    );
    let (changed, _) = renamed("t {\n    period", "control");
    assert_eq!(changed, ["/** Codel go of task control."]);
    let (changed, _) = renamed("go(", "run");
    assert_eq!(
        changed,
        [
            "/** Codel run of task t.",
            "run(c_point *here, const c_other *there, const c_place *place, const genom_context self)",
        ]
    );
}

#[test]
fn a_component_is_followed_into_includes_and_build_files() {
    let makefile =
        "lib_LTLIBRARIES = libc_codels.la\nlibc_codels_la_SOURCES = c_t_codels.c c_c_types.h\n";
    let before = Before::memory(
        &spec(),
        &[("codels/c_t_codels.c", CODELS), ("codels/Makefile.am", makefile)],
    );
    let offset = spec().find("c {").expect("it is there");
    let after = before.rename(offset, "robot").expect("it can be renamed");
    let after = after.expect("the sources follow");
    let text = &after.files.texts[Utf8Path::new("/codels/c_t_codels.c")];
    assert!(text.starts_with("#include \"robot_c_types.h\"\n"), "{text}");
    assert!(text.contains("\ngo(robot_point *here, const robot_other *there"));
    let text = &after.files.texts[Utf8Path::new("/codels/Makefile.am")];
    assert!(text.ends_with("= c_t_codels.c robot_c_types.h\n"), "{text}");
    let build = after.renaming.left.iter().filter(|place| place.path == "/codels/Makefile.am");
    let build: Vec<_> = build.map(|place| (place.line, place.name.as_str())).collect();
    assert_eq!(build, [(1, "libc_codels"), (2, "c_t_codels"), (2, "libc_codels_la_SOURCES"),]);
}

#[test]
fn what_the_sources_declare_is_not_taken() {
    let codels = format!("static int c_hold;\n{CODELS}");
    let before = Before::memory(&spec(), &[("codels/c_t_codels.c", &codels)]);
    let offset = spec().find("wait;").expect("it is there");
    let refused = before.rename(offset, "hold").expect("analysis allows it");
    let why = refused.map(|_| ()).expect_err("the sources declare it").to_string();
    assert!(why.contains("`c_hold` exists already"), "{why}");
}

#[test]
fn scopes_tell_names_apart_in_cxx() {
    let spec = "component c {\n  lang \"c++\";\n  struct point { double x; };\n  ids { point here; sequence<point> many; };\n  \
        task t {\n    codel<start> go(ids inout here, ids in many) yield wait;\n    codel<wait> stay() yield pause::wait, ether;\n  };\n};\n";
    let code = "using namespace c;\ngenom::event go(::c::point &here, const std::vector< ::c::point > &many) {\n  \
        for (const auto &it : many) here.x += it.x + many[0].x;\n  auto wait = 1;\n  other::wait(wait);\n  return c::wait;\n}\n\
        genom::event stay() { return pause::wait; }\nnamespace other { struct wait { int x; }; }\n";
    let before = Before::memory(spec, &[("codels/c_t_codels.cc", code)]);
    let lines = |at: &str, to: &str| -> Vec<String> {
        let offset = spec.find(at).expect("it is there");
        let after = before.rename(offset, to).expect("it can be renamed");
        let after = after.expect("the sources follow");
        let text = after.files.texts[Utf8Path::new("/codels/c_t_codels.cc")].clone();
        let changed = code.lines().zip(text.lines()).filter(|(a, b)| a != b);
        changed.map(|(_, line)| line.trim().to_owned()).collect()
    };
    assert_eq!(
        lines("wait;", "hold"),
        ["return c::hold;", "genom::event stay() { return pause::hold; }",]
    );
    assert_eq!(
        lines("x; };", "east"),
        ["for (const auto &it : many) here.east += it.east + many[0].east;"]
    );
}

/// Codels that use whatever they are given: every member of every parameter, and every event.
fn exercised(expected: &Expected<'_>) -> BTreeMap<Utf8PathBuf, String> {
    crate::codels::project::codels(expected)
}

/// The accepted examples and published specifications, those without sources with generated ones.
fn projects() -> Vec<Before> {
    let mut all = Vec::new();
    for (root, includes) in examples().into_iter().chain(published()) {
        let host = host_over(Arc::new(Overlay::default()), includes.clone());
        let unit = host.analysis().root_unit(&root).expect("not cancelled");
        if !unit.accepted() {
            continue;
        }
        let mut files = Overlay::default();
        let found =
            folders(&unit, &mut |path| Sources::load(path, &FilesConfig::default(), &files));
        for folder in found {
            let own = folder.specification == root && folder.sources.sources.is_empty();
            for expected in folder.expected().iter().filter(|_| own) {
                for (path, text) in exercised(expected) {
                    files.texts.insert(folder.sources.folder.join(path), text);
                }
            }
        }
        all.push(Before { files: Arc::new(files), root, includes });
    }
    all
}

#[test]
fn random_renames_leave_nothing_worse() {
    let count = dotgen_loaders::times(25) as usize;
    let all = projects();
    assert!(all.len() > 5, "{} components", all.len());
    let before: Vec<_> = all.iter().map(Before::diagnostics).collect();
    let compiled: Vec<bool> = all.iter().map(|before| broken(before).is_none()).collect();
    let mut random = fastrand::Rng::with_seed(0x51ed_270b_9f4a_7c15);
    let (mut done, mut tried, mut edited, mut bad) = (0, 0, 0, Vec::new());
    while done < count && tried < 200 * count {
        tried += 1;
        let index = random.usize(..all.len().max(1));
        let entry = &all[index];
        let text = Files::read(&*entry.files, &entry.root).expect("a specification");
        let offset = random.usize(..text.len().max(1));
        let part = |c: u8| c.is_ascii_alphanumeric() || c == b'_';
        let bytes = text.as_bytes();
        if !part(bytes[offset]) || offset > 0 && part(bytes[offset - 1]) {
            continue;
        }
        let to = format!("zz{done}");
        let Some(after) = entry.rename(offset, &to) else {
            continue;
        };
        done += 1;
        let word: String = text[offset..].chars().take_while(|c| part(*c as u8)).collect();
        let title = format!("{}: `{word}` at {offset}", entry.root);
        let after = match after {
            Ok(after) => after,
            Err(why) => {
                bad.push(format!("{title}: {why}"));
                continue;
            }
        };
        let left: Vec<_> = after.renaming.left.iter().map(ToString::to_string).collect();
        edited += usize::from(
            after.renaming.edit.changed.keys().any(|key| key.extension() != Some("gen")),
        );
        let after = Before {
            files: Arc::new(after.files),
            root: entry.root.clone(),
            includes: entry.includes.clone(),
        };
        let now = after.diagnostics();
        if now != before[index] {
            bad.push(format!("{title}: {:?} -> {now:?}, left {left:?}", before[index]));
        }
        if compiled[index] {
            bad.extend(broken(&after).map(|text| format!("{title}: {text}, left {left:?}")));
        }
    }
    assert!(done == count, "{done} renames");
    println!("{done} renames, {edited} of them in sources too");
    assert!(bad.is_empty(), "{} of {done}:\n{}", bad.len(), bad[..bad.len().min(12)].join("\n"));
}

/// What a compiler says against the first codels that it does not take.
fn broken(project: &Before) -> Option<String> {
    let host = project.host();
    for folder in project.folders(&host) {
        for expected in folder.expected() {
            let command = match expected.language {
                Language::Cxx => compiler("c++")?,
                _ => compiler("cc")?,
            };
            let (_guard, temporary) = temporary();
            let files = headers(&expected, &temporary, &folder.sources.folder, &[]).ok()?;
            write(&temporary, &files);
            for file in &folder.sources.sources {
                let name = file.path.file_name().unwrap_or_default();
                let path = temporary.join(name);
                std::fs::write(&path, &*file.text).expect("a temporary file");
                let quiet = ["-Wno-error", "-w"];
                if let Err(why) = compile(command, &temporary, &path, &quiet) {
                    return Some(why);
                }
            }
        }
    }
    None
}

impl Loader for Overlay {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match Files::read(self, path) {
            Some(text) => FileContent::Text(text.to_string()),
            None => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}
