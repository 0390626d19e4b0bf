//! The preprocessor on real files: the shared conformance suite and corpus, and a C preprocessor for
//! comparison. Each part is skipped, with a message, if its files or programs are missing.

use std::{
    collections::BTreeSet,
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::{
    kind::SyntaxKind,
    lexer::lex,
    line_index::LineIndex,
    preproc::{
        Element, Host, IncludeError, IncludeRequest, MacroEnv, PpError, RequiredPackages, Severity,
        preprocess,
    },
};
use serde_json::Value;
use smol_str::SmolStr;

/// Files on disk.
struct Disk {
    include_dirs: Vec<Utf8PathBuf>,
    /// The files being read, innermost last.
    open: Vec<Utf8PathBuf>,
    /// File, line from 1, and report.
    reports: Vec<(Utf8PathBuf, u32, PpError)>,
    /// Active text, by the innermost call.
    live: Vec<String>,
}

impl Disk {
    fn new(include_dirs: Vec<Utf8PathBuf>) -> Disk {
        Disk { include_dirs, open: Vec::new(), reports: Vec::new(), live: Vec::new() }
    }

    fn run(&mut self, path: &Utf8Path, env: MacroEnv) -> Option<MacroEnv> {
        let text = String::from_utf8_lossy(&fs::read(path).ok()?).into_owned();
        let raw = lex(&text);
        self.open.push(path.to_owned());
        let out = preprocess(&path.as_str().into(), &text, &raw, env, self);
        self.open.pop();
        let lines = LineIndex::new(&text);
        for error in out.errors {
            self.reports.push((path.to_owned(), lines.line(error.range.start()) + 1, error));
        }
        self.live = out
            .elements
            .iter()
            .filter_map(|element| match element {
                Element::Real(i) => Some(raw.clean_text(&text, *i as usize).into_owned()),
                Element::Virtual(token) => Some(token.text.to_string()),
                _ => None,
            })
            .collect();
        Some(out.exit_env)
    }
}

impl Host for Disk {
    fn include(
        &mut self,
        request: &IncludeRequest,
        env: &MacroEnv,
    ) -> Result<MacroEnv, IncludeError> {
        if self.open.len() >= 99 {
            return Err(IncludeError::TooDeep);
        }
        let beside = self.open.last().and_then(|path| path.parent()).filter(|_| !request.angled);
        let dirs =
            beside.into_iter().chain(self.include_dirs.iter().map(camino::Utf8PathBuf::as_path));
        let candidates: Vec<Utf8PathBuf> =
            dirs.map(|dir| dir.join(request.path.as_str())).collect();
        match candidates.iter().find(|candidate| candidate.is_file()) {
            Some(path) => Ok(self.run(path, env.clone()).unwrap_or_default()),
            None => Err(IncludeError::NotFound { searched: Vec::new() }),
        }
    }

    fn requires(&mut self, _: &[SmolStr], env: &MacroEnv) -> Result<RequiredPackages, String> {
        Ok(env.clone().into())
    }
}

fn shared(name: &str) -> Option<Utf8PathBuf> {
    Utf8PathBuf::from_path_buf(crate::suite::shared::shared(name)?).ok()
}

/// Runs the preprocessor on a case of the conformance suite.
fn case_on_disk(dir: &Utf8Path, case: &Value) -> Disk {
    let file = dir.join(case["file"].as_str().unwrap());
    let folder = file.parent().unwrap();
    let mut disk = Disk::new(Vec::new());
    let mut env = MacroEnv::predefined();
    for arg in case["args"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        let arg = arg.replace("{case}", folder.as_str());
        if let Some(dir) = arg.strip_prefix("-I") {
            disk.include_dirs.push(dir.into());
        } else if let Some(definition) = arg.strip_prefix("-D") {
            env.define_option(definition).unwrap();
        }
    }
    disk.run(&file, env);
    disk
}

impl Disk {
    /// Compares the reports with those that a case expects. Returns false for a case of another layer.
    fn judge(&self, name: &str, case: &Value, failures: &mut Vec<String>) -> bool {
        let ours = if case["ours"].is_null() { case } else { &case["ours"] };
        let errors: Vec<&Value> = case["errors"].as_array().into_iter().flatten().collect();
        let required = || errors.iter().filter(|error| error["consequence"] != true);
        let of_this_layer = |check: &Value| {
            check
                .as_str()
                .is_some_and(|check| check.starts_with("pp-") || check.starts_with("lex-"))
        };
        let close = |wanted: &Value, severity: Severity| {
            self.reports.iter().any(|(file, line, report)| {
                let mut lines =
                    wanted["also"].as_array().into_iter().flatten().chain([&wanted["line"]]);
                file.file_name() == wanted["file"].as_str()
                    && report.severity == severity
                    && lines.any(|candidate| {
                        candidate
                            .as_i64()
                            .is_some_and(|number| (number - i64::from(*line)).abs() <= 1)
                    })
            })
        };
        let reported = self.reports.iter().filter(|report| report.2.severity == Severity::Error);
        if ours["verdict"] == "accept" {
            if reported.count() > 0 {
                failures.push(format!("{name}: accepted, but {:?}", self.reports));
            }
            for warning in case["warnings"].as_array().into_iter().flatten() {
                if of_this_layer(&warning["check"]) && !close(warning, Severity::Warning) {
                    failures.push(format!("{name}: no {warning} in {:?}", self.reports));
                }
            }
        } else if required().all(|json| of_this_layer(&json["check"])) {
            for error in required() {
                if !close(error, Severity::Error) {
                    failures.push(format!("{name}: no {error} in {:?}", self.reports));
                }
            }
        } else if !required().any(|json| of_this_layer(&json["check"]))
            && name.starts_with("preproc/")
        {
            if reported.count() > 0 {
                failures.push(format!("{name}: wrong for another reason, but {:?}", self.reports));
            }
        } else {
            return false;
        }
        true
    }
}

#[test]
fn conformance() {
    let Some(dir) = shared("conformance") else {
        return;
    };
    let expected = fs::read_to_string(dir.join("expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&expected).unwrap();
    let mut judged = 0;
    let mut failures = Vec::new();
    for (name, case) in expected.as_object().unwrap() {
        if !case["needs"].is_null() {
            continue;
        }
        let disk = case_on_disk(&dir, case);
        judged += usize::from(disk.judge(name, case, &mut failures));
    }
    assert!(failures.is_empty(), "{judged} judged\n{}", failures.join("\n"));
    assert!(judged > 100, "only {judged} cases");
    eprintln!("{judged} cases judged");
}

/// The specifications below a directory.
fn specifications(dir: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(specifications(&path));
        } else if path.extension().is_some_and(|extension| extension == "gen" || extension == "idl")
        {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn corpus() {
    let Some(dir) = shared("corpus") else { return };
    let files = specifications(dir.as_std_path());
    assert!(!files.is_empty());
    for path in files {
        let path = Utf8PathBuf::from_path_buf(path).unwrap();
        let mut disk = Disk::new(Vec::new());
        disk.run(&path, MacroEnv::predefined());
        let codes: BTreeSet<&str> = disk
            .reports
            .iter()
            .filter(|(_, _, error)| error.severity != Severity::Hint)
            .map(|(_, _, error)| error.kind.code())
            .collect();
        // Files of packages that are not part of the corpus.
        assert!(codes.iter().all(|&code| code == "pp-include-not-found"), "{path}: {codes:?}");
    }
}

/// Tokens after a C preprocessor.
fn c_preprocessor(text: &str) -> Option<Vec<String>> {
    let mut cpp = Command::new("cpp")
        .args(["-P", "-undef", "-nostdinc", "-w", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    cpp.stdin.take()?.write_all(text.as_bytes()).ok()?;
    let out = cpp.wait_with_output().ok()?;
    let out = String::from_utf8_lossy(&out.stdout).into_owned();
    let raw = lex(&out);
    let blank = [SyntaxKind::WHITESPACE, SyntaxKind::NEWLINE];
    let tokens = (0..raw.len()).filter(|&i| !blank.contains(&raw.kind(i)));
    Some(tokens.map(|i| raw.text(&out, i).to_owned()).collect())
}

#[test]
fn agrees_with_a_c_preprocessor() {
    if c_preprocessor("").is_none() {
        crate::suite::shared::skip("there is no `cpp`");
        return;
    }
    let fixtures = [
        // Rescanning, with arguments from behind the expansion.
        "#define f(x) x f\n#define g f\n#define h(x) g(x)\nf(1)(2)(3) g(1)(2) h(h)(1) h(h(1))\n",
        "#define a b c\n#define b a\n#define c(x) x a\na(1) c(a)(2) b\n",
        "#define AA BB\n#define BB AA\n#define L (\n#define F(x) [x]\nAA F L 1) F(L) F((AA, 1)) F(F)(1) F(F(F(2)))\n",
        "#define NIL(xxx) xxx\n#define G_0(arg) NIL(G_1)(arg)\n#define G_1(arg) NIL(arg)\nG_0(42)\n",
        "#define foo(x) bar x\nfoo(foo) (2)\n#define m(x) m\nm(1)(2)(3)\n",
        // Strings and pastes.
        "#define X(...) #__VA_ARGS__\n#define C(a,b) a##b\n#define D(a,b) C(a,b)\n#define N 7\n\
         X(a , b  c) X( \"x\\n\" ) C(N,N) D(N,N) C(x,) C(,x) D(C(a,b),C(c,d)) C(C(a,b),c) C(<,<) D(1,N)\n",
        "#define E(a,...) a(__VA_ARGS__)\n#define V(...) __VA_ARGS__ end\nE(V,1,2) E(E,V,1) V() V(,) E(V,)\n",
        // Conditions.
        "#define A 3\n#if A * 2 == 6 && defined(A) || 1/0\nyes\n#elif 1\nno\n#endif\n#if (A ? 1 ? 2 : 3 : 4) == 2 && -1 < 0 && -1 > 0u\nyes\n#else\nno\n#endif\n\
         #if 'a' < 'b' && 0x10 + 010 - 24 == 0 && (1,2) == 2\nyes\n#endif\n#ifdef B\n#if 1\nno\n#else\nno\n#endif\n#elif !defined B && ~0 == -1\nyes\n#endif\n",
        // Lines joined, comments, line numbers.
        "#define LONG a \\\n b /* c\n d */ e\nLONG /* LONG */ LO\\\nNG // LONG\n__LINE__\n#define P __LINE__\n\nP\n",
    ];
    for text in fixtures {
        let Some(expected) = c_preprocessor(text) else {
            continue;
        };
        let dir = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::from_path_buf(dir.path().join("main.gen")).unwrap();
        fs::write(&path, text).unwrap();
        let mut disk = Disk::new(Vec::new());
        disk.run(&path, MacroEnv::predefined());
        assert_eq!(disk.reports, [], "{text}");
        assert_eq!(disk.live, expected, "{text}");
    }
}
