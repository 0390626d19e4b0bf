//! Stubs against the digests of the reference skeletons, and compilers over everything generated.

use std::io::Write as _;
use std::process::{Command, Stdio};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{BatchInput, Change, Input};
use dotgen_analysis::model::{ComponentId, ComponentKind, Spec};
use dotgen_analysis::release::Release;
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::headers::headers;
use dotgen_codegen::codels::stub::{NewFile, StubOptions, Stubs, types_header};
use dotgen_codegen::lang::Language;
use dotgen_codegen::template::notice;
use serde_json::Value;

use crate::codels::support::{
    compile, compiler, host, host_of, shared, temporary, workspace, write,
};

pub(crate) fn components(spec: &Spec) -> Vec<ComponentId> {
    let all = spec.components.iter_enumerated();
    all.filter(|(_, component)| component.kind == ComponentKind::Component)
        .map(|(index, _)| index)
        .collect()
}

fn sha256(text: &str) -> Option<String> {
    let mut child =
        Command::new("sha256sum").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    child.stdin.take()?.write_all(text.as_bytes()).ok()?;
    let output = child.wait_with_output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.split_whitespace().next()?.to_owned())
}

/// What a run of the skeleton template was given.
struct Run {
    input: BatchInput,
    notice: Option<String>,
    cxx: bool,
    output: String,
}

/// Reads the arguments of an entry; `None` when it is no plain run of `skeleton`.
fn run(golden: &Utf8Path, entry: &Value) -> Option<Run> {
    let steps = entry["steps"].as_array()?;
    let [step] = steps.as_slice() else {
        return None;
    };
    let words = step["argv"].as_array()?.iter().filter_map(Value::as_str);
    let words: Vec<&str> = words.collect();
    if step["status"] != 0 || !words.contains(&"skeleton") {
        return None;
    }
    let mut out =
        Run { input: BatchInput::default(), notice: None, cxx: false, output: ".".into() };
    let folder = |text: &str| match text {
        "@STANDINS@" => golden.join("standins"),
        text => golden.join("inputs").join(text),
    };
    let define = |text: &str| {
        let (name, value) = text.split_once('=').unwrap_or((text, "1"));
        (name.into(), value.into())
    };
    let mut words = words.into_iter();
    let mut template = false;
    while let Some(word) = words.next() {
        match word {
            "-I" => out.input.include_dirs.push(folder(words.next()?)),
            "-D" => out.input.defines.push(define(words.next()?)),
            "-C" => words.next()?.clone_into(&mut out.output),
            "-l" => out.cxx = words.next()? == "c++",
            "-t" if !template => {
                words.next()?;
            }
            "-t" => {}
            "skeleton" => template = true,
            _ if word.starts_with("-I") => out.input.include_dirs.push(folder(&word[2..])),
            _ if word.starts_with("-D") => out.input.defines.push(define(&word[2..])),
            _ if word.starts_with('-') => return None,
            // The name of a component.
            _ if !word.ends_with(".gen") => {
                return None;
            }
            _ => out.input.inputs.push(Input::File(source(golden, entry, word)?)),
        }
    }
    for input in &out.input.inputs {
        if let Input::File(path) = input
            && let Some(text) = notice(&std::fs::read_to_string(path).ok()?)
        {
            out.notice.get_or_insert_default().push_str(&text);
        }
    }
    Some(out)
}

/// An input of an entry: one of the golden inputs, or a file of the corpus, found by its name.
fn source(golden: &Utf8Path, entry: &Value, name: &str) -> Option<Utf8PathBuf> {
    let own = golden.join("inputs").join(name);
    if entry.get("corpus").is_none() {
        return Some(own);
    }
    let corpus = golden.parent()?.join("corpus/components");
    let mut folders = corpus.read_dir_utf8().ok()?.flatten();
    let found = folders.find(|folder| folder.path().join(name).is_file())?;
    Some(found.path().join(name))
}

#[test]
fn stubs_are_those_of_the_skeleton_of_2_99_39() {
    stubs_are_those_of_the_skeleton(Release::V2_99_39, "manifest.json");
}

#[test]
fn stubs_are_those_of_the_skeleton_of_2_99_41() {
    stubs_are_those_of_the_skeleton(Release::V2_99_41, "manifest-2.99.41.json");
}

fn stubs_are_those_of_the_skeleton(release: Release, manifest: &str) {
    let Some(shared) = shared() else { return };
    if sha256("").is_none() {
        dotgen_loaders::skip("no `sha256sum` on this system");
        return;
    }
    let golden = shared.join("golden");
    let manifest = std::fs::read_to_string(golden.join(manifest)).expect("the manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("the manifest is JSON");
    let mut compared = 0;
    for entry in manifest["entries"].as_array().expect("entries") {
        let id = entry["id"].as_str().unwrap_or_default();
        let Some(run) = run(&golden, entry) else {
            continue;
        };
        let unit = host_of(Some(release), Vec::new())
            .analysis()
            .batch(&run.input)
            .expect("nothing is cancelled");
        assert!(unit.accepted(), "{id}: {:?}", unit.diagnostics);
        let options =
            StubOptions { compile_as_cxx: run.cxx, notice: run.notice, ..StubOptions::default() };
        for component in components(&unit.spec) {
            let expected = Expected::new(&unit.spec, component);
            for file in Stubs::new(&expected, &options).all_files().expect("types have a mapping") {
                let path = match run.output.as_str() {
                    "." => file.path.to_string(),
                    folder => format!("{folder}/{}", file.path),
                };
                let wanted = entry["files"][&path]["sha256"].as_str();
                let found = sha256(&file.text);
                assert_eq!(wanted, found.as_deref(), "{id} {path}:\n{}", file.text);
                compared += 1;
            }
        }
    }
    assert!(compared > 40, "{compared} files compared");
}

/// Generates headers and stubs of every component and compiles them.
fn compiles(name: &str, spec: &Spec, failures: &mut Vec<String>) -> usize {
    let mut count = 0;
    for component in components(spec) {
        let mut cxx = spec.clone();
        cxx.components[component].lang = Some("c++".into());
        // C codels as C and as C++, and C++ codels.
        let runs = [(spec, false, "cc"), (spec, true, "c++"), (&cxx, true, "c++")];
        for (spec, compile_as_cxx, command) in runs {
            let Some(command) = compiler(command) else {
                continue;
            };
            let expected = Expected::new(spec, component);
            let options =
                StubOptions { use_parameters: true, compile_as_cxx, ..StubOptions::default() };
            let (_guard, folder) = temporary();
            let headers = headers(&expected, &folder, &folder.join("codels"), &[]);
            let stubs = Stubs::new(&expected, &options).all_files();
            let (headers, stubs) = match (headers, stubs) {
                (Ok(headers), Ok(stubs)) => (headers, stubs),
                // C++ has no union of types with constructors: said, not written wrongly.
                (Err(error), _) | (_, Err(error)) => {
                    let known = error.message.contains("not allowed in C++");
                    assert!(known && spec.components[component].lang.as_deref() == Some("c++"));
                    continue;
                }
            };
            write(&folder, &headers);
            write(&folder, &stubs);
            // The types alone, for components without codels.
            let types = types_header(&expected);
            let cxx = compile_as_cxx || expected.language == Language::Cxx;
            let suffix = if cxx { "cc" } else { "c" };
            let alone = NewFile {
                path: format!("types_alone.{suffix}").into(),
                text: format!("#include \"{types}\"\n"),
            };
            write(&folder, std::slice::from_ref(&alone));
            for stub in stubs.iter().chain([&alone]) {
                // Modules may be called `or`.
                let extra: &[&str] =
                    if stub.path.extension() == Some("c") { &[] } else { &["-fno-operator-names"] };
                count += 1;
                if let Err(error) = compile(command, &folder, &folder.join(&stub.path), extra) {
                    failures.push(format!("{name} {command}: {error}"));
                }
            }
        }
    }
    count
}

#[test]
fn headers_and_stubs_of_the_examples_compile() {
    let mut failures = Vec::new();
    let mut count = 0;
    let examples = workspace().join("examples");
    // Some examples include interfaces of others.
    let all = examples.read_dir_utf8().expect("examples").flatten();
    let interfaces: Vec<Utf8PathBuf> = all.map(|directory| directory.path().join("idl")).collect();
    for example in examples.read_dir_utf8().expect("examples").flatten() {
        let Ok(files) = example.path().read_dir_utf8() else {
            continue;
        };
        for file in files.flatten().filter(|file| file.path().extension() == Some("gen")) {
            let host = host(interfaces.clone());
            let unit = host.analysis().root_unit(file.path()).expect("nothing is cancelled");
            assert!(unit.accepted(), "{}: {:?}", file.path(), unit.diagnostics);
            count += compiles(file.path().as_str(), &unit.spec, &mut failures);
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    if compiler("cc").is_some() {
        assert!(count >= 4, "{count} files compiled");
    }
}

/// Declarations of `alltypes.gen` whose mapping by the reference, which ours equals byte for byte, no
/// compiler takes.
const NOT_COMPILABLE: [&str; 5] = [
    // C: `static const char[40] k_string40`.
    "const string<40> k_string40 = \"concatenated \" \"literal\";",
    // C: an array of the structure that it is in.
    "sequence<node, 2> pair;",
    // C as C++: arrays are assigned.
    "typedef sequence<t_along, 2> t_salias;",
    // C++: `bounded_sequence< char t_sstring12[12],3 >`.
    "typedef sequence<string<12>, 3> t_sstring12;",
    // C++: `optional< char os5[5] >`.
    "optional<long> ol; optional<string<5> > os5;",
];

/// `alltypes.gen` without these, and without the name `u_long`, which `<sys/types.h>` has for a type.
fn compilable(text: &str) -> String {
    let mut left_out = 0;
    let mut out = String::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if NOT_COMPILABLE.contains(&words.join(" ").as_str()) {
            left_out += 1;
        } else {
            out += &line.replace("u_long", "u_of_long");
            out.push('\n');
        }
    }
    assert_eq!(left_out, NOT_COMPILABLE.len());
    out
}

#[test]
fn headers_and_stubs_of_the_golden_inputs_compile() {
    let Some(shared) = shared() else { return };
    let golden = shared.join("golden");
    let mut failures = Vec::new();
    let mut count = 0;
    for file in golden.join("inputs").read_dir_utf8().expect("inputs").flatten() {
        if file.path().extension() != Some("gen") {
            continue;
        }
        // Later releases accept an input whose C++ mapping, byte for byte, is none that a compiler takes.
        let includes = vec![golden.join("inputs/more"), golden.join("standins")];
        let mut host = host_of(Some(Release::V2_99_39), includes);
        if file.file_name() == "alltypes.gen" {
            let text = std::fs::read_to_string(file.path()).expect("an input");
            host.apply(Change {
                files: vec![(file.path().to_owned(), Some(compilable(&text)))],
                ..Change::default()
            });
        }
        let unit = host.analysis().root_unit(file.path()).expect("nothing is cancelled");
        if unit.accepted() {
            count += compiles(file.file_name(), &unit.spec, &mut failures);
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    if compiler("cc").is_some() {
        assert!(count > 20, "{count} files compiled");
    }
}
