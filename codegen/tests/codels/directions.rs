//! Both ways to bring yields and throws in order, and how lists of a specification are extended.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_codegen::codels::command::{Project, SyncOptions, sync};
use dotgen_codegen::codels::drift::Repair;
use dotgen_codegen::codels::edit::apply;
use dotgen_codegen::codels::files::{Files, FilesConfig, ModificationTime, Sources};
use dotgen_codegen::codels::repair::Repairs;
use dotgen_codegen::codels::stub::StubOptions;

use crate::codels::project::host_over;
use crate::codels::support::{Fixture, Memory};

const SPECIFICATION: &str = "/c.gen";
const SOURCE: &str = "/codels/c_t_codels.c";

/// The files of a fixture, of which one was changed last.
struct Dated<'a> {
    files: &'a Memory,
    last: &'a str,
}

impl Files for Dated<'_> {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        Files::read(self.files, path)
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        self.files.list(folder)
    }

    fn changed(&self, path: &Utf8Path) -> Option<ModificationTime> {
        let seconds = if path == self.last { 10 } else { 0 };
        Some(ModificationTime::At(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)))
    }
}

/// The ways to mend each finding in their order, and what the first file that one touches becomes.
fn ways(specification: &str, source: &str, last: &str) -> Vec<Vec<(String, String)>> {
    let name = if specification.contains("lang") { "c_t_codels.cc" } else { "c_t_codels.c" };
    let fixture = Fixture::new(specification, &[(name, source)]);
    let expected = fixture.expected();
    let stubs = StubOptions::default();
    let files = Dated { files: &fixture.files, last };
    let repairs = Repairs {
        expected: &expected,
        sources: &fixture.sources,
        locations: &*fixture.unit.locations,
        text: &files,
        stubs: &stubs,
    };
    let found = fixture.check();
    let of = |drift| -> Vec<(String, String)> {
        let ordered = repairs.ordered(drift).into_iter();
        let made = ordered.map(|repair| {
            let edit = repairs.edit(repair).expect("the repair has an edit");
            let texts = edit
                .changed
                .iter()
                .map(|(path, edits)| apply(&files.read(path).expect("it is there"), edits));
            (repairs.title(repair), texts.collect())
        });
        made.collect()
    };
    found.iter().map(of).collect()
}

fn titles(specification: &str, source: &str, last: &str) -> Vec<Vec<String>> {
    let all = ways(specification, source, last);
    let titles = |pairs: Vec<(String, String)>| pairs.into_iter().map(|(title, _)| title).collect();
    all.into_iter().map(titles).collect()
}

const MACHINE: &str = "component c {\n  task t {\n    codel<start> f() yield main, ether;\n    \
     codel<main> g() yield pause::main, stop;\n    codel<stop> h() yield ether;\n  };\n};\n";

/// The codels of [`MACHINE`]; `f` returns what is wanted.
fn machine(returned: &str) -> String {
    format!(
        "genom_event f(const genom_context self) {{ if (1) return {returned}; return c_ether; }}\n\
         genom_event g(const genom_context self) {{ if (1) return c_pause_main; return c_stop; }}\n\
         genom_event h(const genom_context self) {{ return c_ether; }}\n"
    )
}

#[test]
fn what_was_changed_last_is_meant() {
    let declare = "Add `yield stop` to codel `f`";
    let comply = "Return `c_main` from `f`";
    let drop = "Remove `main` from the yields of codel `f`";
    let code = machine("c_stop");
    assert_eq!(titles(MACHINE, &code, SOURCE), [[declare, comply], [drop, comply]]);
    assert_eq!(titles(MACHINE, &code, SPECIFICATION), [[comply, declare], [comply, drop]]);
    // Nobody knows.
    assert_eq!(titles(MACHINE, &code, "")[0], [declare, comply]);
    let after = &ways(MACHINE, &code, SPECIFICATION)[0][0].1;
    assert_eq!(*after, machine("c_main"));
}

#[test]
fn what_is_saved_together_is_not_ordered() {
    let at = |milliseconds| {
        ModificationTime::At(SystemTime::UNIX_EPOCH + Duration::from_millis(milliseconds))
    };
    let unsaved = ModificationTime::Unsaved;
    assert!(at(10_000).is_after(at(0)) && unsaved.is_after(at(0)));
    for (a, b) in [(at(9_999), at(0)), (at(0), at(10_000)), (at(0), unsaved), (unsaved, unsaved)] {
        assert!(!a.is_after(b), "{a:?} {b:?}");
    }
}

/// In C, the event of the state `run` and the function are one word.
#[test]
fn a_renamed_function_leaves_the_event_of_its_name() {
    let specification = "component c {\n  task t {\n    codel<start> c_begin() yield run, ether;\n    \
         codel<run> c_halt() yield ether;\n  };\n};\n";
    let code = "genom_event c_run(const genom_context self) { if (0) return c_ether; return c_run; }\n\
         genom_event c_halt(const genom_context self) { return c_ether; }\n";
    let fixture = Fixture::new(specification, &[("c_t_codels.c", code)]);
    let files = Dated { files: &fixture.files, last: "" };
    let repairs = Repairs {
        expected: &fixture.expected(),
        sources: &fixture.sources,
        locations: &*fixture.unit.locations,
        text: &files,
        stubs: &StubOptions::default(),
    };
    let rename = Repair::RenameFunction { from: "c_run".into(), to: "c_begin".into() };
    let edit = repairs.edit(&rename).expect("an edit");
    let after = apply(code, &edit.changed[Utf8Path::new(SOURCE)]);
    assert_eq!(after, code.replace("genom_event c_run(", "genom_event c_begin("));
}

#[test]
fn an_event_that_is_misspelt_is_the_nearest_declared_one() {
    let found = titles(MACHINE, &machine("c_mian"), SOURCE);
    assert_eq!(found[0], ["Return `c_main` from `f`"]);
}

#[test]
fn names_stay_as_short_as_they_are() {
    let specification = "component c {\n  lang \"c++\";\n  task t {\n    codel<start> f() yield main, ether;\n    \
         codel<main> g() yield ether;\n  };\n};\n";
    let source = |event: &str| {
        format!(
            "using namespace c;\ngenom::event f() {{ if (1) return {event}; return ether; }}\n\
             genom::event g() {{ return ether; }}\n"
        )
    };
    let found = ways(specification, &source("start"), SPECIFICATION);
    assert_eq!(found[0][0].0, "Return `c::main` from `f`");
    assert_eq!(found[0][0].1, source("main"));
    let found = ways(specification, &source("c::start"), SPECIFICATION);
    assert_eq!(found[0][0].1, source("c::main"));
}

#[test]
fn a_cycle_without_pause_is_offered_with_one_first() {
    let code = machine("c_main").replace("return c_stop", "return c_main");
    let all = ways(MACHINE, &code, SOURCE);
    let titles: Vec<&str> = all[0].iter().map(|(title, _)| title.as_str()).collect();
    // It pauses before `main` already, so that a pause is no new yield.
    assert_eq!(titles[0], "Return `c_pause_main` from `g`", "{titles:?}");
    assert!(titles.contains(&"Add `yield main` to codel `g`"));
    let specification = MACHINE.replace("yield pause::main, stop", "yield stop");
    let code = machine("c_main").replace("c_pause_main", "c_main");
    let all = ways(&specification, &code, SOURCE);
    let titles: Vec<&str> = all[0].iter().map(|(title, _)| title.as_str()).collect();
    assert_eq!(
        titles[..2],
        [
            "Add `yield pause::main` to codel `g`, and return `c_pause_main`",
            "Add `yield main` to codel `g`"
        ]
    );
    let both = format!(
        "{}{}",
        specification.replace("yield stop;", "yield stop, pause::main;"),
        machine("c_main")
    );
    assert_eq!(all[0][0].1, both);
}

const THROWING: &str = "component c {\n  exception e_one, e_two;\n  exception e_more { long n; };\n  task t {\n    \
     throw e_one;\n    codel<start> f() yield ether;\n  };\n};\n";

#[test]
fn exceptions_go_both_ways() {
    let code = "genom_event f(const genom_context self) { if (1) return c_e_two(self); return c_ether; }\n";
    let declare = "Add `throw e_two` to task `t`";
    let comply = "Raise `c_e_one` in `f`";
    assert_eq!(titles(THROWING, code, SOURCE), [[declare, comply]]);
    let all = ways(THROWING, code, SPECIFICATION);
    assert_eq!(all[0][0].0, comply);
    assert_eq!(all[0][0].1, code.replace("c_e_two", "c_e_one"));
    assert_eq!(all[0][1].1, THROWING.replace("throw e_one", "throw e_one, e_two"));
    // With details, another exception has another type of them.
    let code = "genom_event f(const genom_context self) { c_e_more_detail d; if (1) return c_e_more(&d, self); return c_ether; }\n";
    assert_eq!(titles(THROWING, code, SOURCE), [["Add `throw e_more` to task `t`"]]);
    // What is not declared at all.
    let code =
        "genom_event f(const genom_context self) { if (1) return c_e_on(self); return c_ether; }\n";
    assert_eq!(titles(THROWING, code, SOURCE), [["Raise `c_e_one` in `f`"]]);
}

/// What `sync` makes of a specification and a source.
fn synced(specification: &str, source: &str, last: &str) -> (String, String) {
    let fixture = Fixture::new(specification, &[("c_t_codels.c", source)]);
    let files = Dated { files: &fixture.files, last };
    let mut over = crate::codels::project::Overlay { disk: false, ..Default::default() };
    over.texts.extend(fixture.files.0.clone());
    let mut host = host_over(Arc::new(over), Vec::new());
    let mut project =
        Project::new(&mut host, &files, FilesConfig::default(), StubOptions::default());
    sync(&mut project, &[SPECIFICATION.into()], &SyncOptions::default());
    let text = |path: &str| project.text(path.into()).unwrap_or_default().to_string();
    (text(SPECIFICATION), text(SOURCE))
}

#[test]
fn sync_takes_nothing_back_that_was_changed_last() {
    let code = machine("c_stop");
    let declared = MACHINE.replace("yield main, ether;", "yield main, ether, stop;");
    assert_eq!(synced(MACHINE, &code, SOURCE), (declared, code.clone()));
    // What the code is to do instead is for people to say.
    let same = (MACHINE.to_owned(), code.clone());
    assert_eq!(synced(MACHINE, &code, SPECIFICATION), same);
}

#[test]
fn sync_makes_no_cycle_without_pause() {
    let specification = MACHINE.replace("yield pause::main, stop", "yield stop");
    let code = machine("c_main").replace("c_pause_main", "c_main");
    assert_eq!(synced(&specification, &code, SOURCE), (specification, code.clone()));
}

#[test]
fn lists_are_extended_as_they_are_laid_out() {
    let check = |list: &str, wanted: &str| {
        let specification = MACHINE.replace("yield main, ether;", list);
        let all = ways(&specification, &machine("c_stop"), SOURCE);
        let declared = all[0].iter().find(|(title, _)| title.starts_with("Add"));
        let declared = &declared.expect("it can be declared").1;
        assert_eq!(*declared, MACHINE.replace("yield main, ether;", wanted));
    };
    check("yield main,\n          ether;", "yield main,\n          ether,\n          stop;");
    check("yield main,ether;", "yield main,ether,stop;");
    check(
        "yield main\n    , ether // the end\n    ;",
        "yield main\n    , ether // the end\n    , stop\n    ;",
    );
    let throws = THROWING.replace("throw e_one;", "throws\n      e_one,\n      e_more;");
    let code = "genom_event f(const genom_context self) { if (1) return c_e_two(self); return c_ether; }\n";
    let all = ways(&throws, code, SOURCE);
    assert_eq!(
        all[0][0].1,
        throws.replace("e_more;\n    codel", "e_more,\n      e_two;\n    codel")
    );
}

/// Returns the parameters that the second repair of a prototype writes, and the text of the finding.
fn adapted(parameters: &str, function: &str) -> (Option<String>, String) {
    let specification = format!(
        "typedef double metres;\ncomponent c {{\n  ids {{ double v; double w; long n; }};\n  port in metres p;\n  \
         task t {{\n    codel<start> f({parameters}) yield ether;\n  }};\n}};\n"
    );
    let code = format!("genom_event f({function}) {{ return c_ether; }}\n");
    let fixture = Fixture::new(&specification, &[("c_t_codels.c", &code)]);
    let files = Dated { files: &fixture.files, last: "" };
    let repairs = Repairs {
        expected: &fixture.expected(),
        sources: &fixture.sources,
        locations: &*fixture.unit.locations,
        text: &files,
        stubs: &StubOptions::default(),
    };
    let found = fixture.check();
    let [drift] = found.as_slice() else {
        panic!("{found:?}");
    };
    let place = drift.source.as_ref().expect("the function");
    let edit = drift.repairs.get(1).and_then(|repair| repairs.edit(repair));
    let after = edit.map(|edit| apply(&specification, &edit.changed[Utf8Path::new("/c.gen")]));
    let list = after.map(|text| {
        let (_, rest) = text.split_once("f(").expect("the codel");
        rest.split_once(')').expect("its end").0.to_owned()
    });
    (list, code[place.range.clone()].to_owned())
}

#[test]
fn a_codel_gets_the_parameters_of_its_function() {
    let text = |text: &str| Some(text.to_owned());
    let own = "const genom_context self";
    // Added, removed, changed, and in another order.
    let found = adapted("in v", &format!("double v, double *w, {own}"));
    assert_eq!(found, (text("in v, ids inout w"), "double *w".to_owned()));
    let found = adapted("in v, in w", &format!("double w, {own}"));
    assert_eq!(found, (text("in w"), "f".to_owned()));
    let found = adapted("in v,\n      out w", &format!("double v, double w, {own}"));
    assert_eq!(found, (text("in v,\n      ids in w"), "double w".to_owned()));
    let found = adapted("ids in v, port in p", &format!("const c_p *p, double v, {own}"));
    assert_eq!(found, (text("port in p, ids in v"), "f".to_owned()));
    // An unknown parameter, and a comment that would be lost.
    assert_eq!(adapted("in v", &format!("double v, float other, {own}")).0, None);
    assert_eq!(adapted("in v, /* half */ in w", &format!("double w, {own}")).0, None);
}

/// The lines of the stub of `g` in a folder with these texts.
fn stub_in(texts: &[(&str, &str)]) -> String {
    let specification = "component c {\n  task t {\n    codel<start> f() yield ether;\n    codel<stop> g() yield ether;\n  };\n};\n";
    let mut fixture = Fixture::new(specification, &[("c_t_codels.c", "")]);
    let mut files = fixture.files.0.clone();
    for (path, text) in texts {
        files.insert((*path).into(), (*text).to_owned());
    }
    fixture.files = Arc::new(Memory(files));
    fixture.sources = Sources::load("/c.gen".into(), &FilesConfig::default(), &*fixture.files);
    let repairs = Repairs {
        expected: &fixture.expected(),
        sources: &fixture.sources,
        locations: &*fixture.unit.locations,
        text: &*fixture.files,
        stubs: &StubOptions::default(),
    };
    let missing = repairs.missing();
    let edit = repairs.stub(&missing[missing.len() - 1..]).expect("a stub");
    let text = edit.changed.values().flatten().map(|change| change.text.clone());
    text.chain(edit.created.into_values()).collect::<String>()
}

#[test]
fn stubs_are_indented_as_the_sources_are() {
    let returns =
        |indentation: &str| format!("\n{indentation}/* skeleton sample */ return c_ether;\n}}");
    let written = |body: &str| {
        format!("genom_event f(const genom_context self)\n{{\n{body}return c_ether;\n}}\n")
    };
    let found = |texts: &[(&str, &str)], indentation: &str| {
        let text = stub_in(texts);
        assert!(text.contains(&returns(indentation)), "{text}");
    };
    found(&[("/codels/c_t_codels.c", &written("    "))], "    ");
    found(&[("/codels/c_t_codels.c", &written("\t"))], "\t");
    found(&[("/codels/other.c", "int h(void)\n{\n   return 1;\n}\n")], "   ");
    // Samples do not count.
    let sample = written("  /* skeleton sample: insert your code */\n  /* skeleton sample */ ");
    let sample = ("/codels/c_t_codels.c", sample.as_str());
    found(&[sample], "  ");
    found(&[sample, ("/.clang-format", "BasedOnStyle: LLVM\nIndentWidth: 4\n")], "    ");
    found(&[sample, ("/codels/.clang-format", "UseTab: Always\n")], "\t");
    found(&[sample, ("/.editorconfig", "root = true\n[*.c]\nindent_size = 3\n")], "   ");
    found(&[sample, ("/.editorconfig", "root = true\n[*.py]\nindent_size = 3\n")], "  ");
}
