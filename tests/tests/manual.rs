//! The manual pages of diagnostic codes are generated; this test writes them when they are not up to
//! date, and fails.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use dotgen_analysis::codes::{self, Code};
use dotgen_analysis::diagnostic::Severity;
use dotgen_codegen::codels::codes::{CODES, CodelCode, Correction};
use dotgen_codegen::template::check;
use dotgen_tests::workspace_root;
use dotgen_timing::diagnostic::Severity as ScenarioSeverity;
use dotgen_timing::scn::codes as scenarios;

/// The codes of all layers.
fn all() -> impl Iterator<Item = Code> {
    let codels = CODES.iter().map(|codel| Code {
        id: codel.code.as_str(),
        severity: codel.code.severity(),
        on: true,
        meaning: codel.meaning,
        why: codel.why,
        example: Some(codel.specification),
        corrected: None,
        fix: codel.fix,
        reference: false,
    });
    let scenarios = scenarios::all().map(|code| Code {
        id: code.id,
        severity: match code.severity {
            ScenarioSeverity::Error => Severity::Error,
            ScenarioSeverity::Warning => Severity::Warning,
        },
        on: true,
        meaning: code.meaning,
        why: code.why,
        example: Some(code.example),
        corrected: (!code.corrected.is_empty()).then_some(code.corrected),
        fix: code.fix,
        reference: false,
    });
    codes::all().chain(codels).chain(check::CODES.iter().copied()).chain(scenarios)
}

/// The entry of a code that compares specification and codels.
fn codel(id: &str) -> Option<&'static CodelCode> {
    CODES.iter().find(|codel| codel.code.as_str() == id)
}

/// The entry of a code about scenarios.
fn scenario(id: &str) -> Option<&'static scenarios::Code> {
    scenarios::all().find(|code| code.id == id)
}

/// True for a code of a verification, which no comment switches off.
fn of_verification(id: &str) -> bool {
    codes::verification::CODES.iter().any(|code| code.id == id)
}

/// True for a code about a file of a template.
fn of_template(id: &str) -> bool {
    check::CODES.iter().any(|code| code.id == id)
}

/// The text of a fixture that triggers a code, without its marks, and the text as it should be.
fn fixture(code: &str) -> Option<(String, String)> {
    let path = workspace_root().join(format!("analysis/tests/data/codes/{code}.gen"));
    let text = std::fs::read_to_string(path).ok()?;
    let (bad, good) = text.split_once("// near miss\n")?;
    let good = good.split_once("// corrected\n").map_or(good, |pair| pair.1);
    let bad = bad.lines().map(|line| format!("{}\n", line.replace("//!", "").trim_end())).collect();
    Some((bad, good.to_owned()))
}

fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Information => "information",
        Severity::Hint => "hint",
    }
}

/// Says how codes about the machine, not about the text, are reported.
const ENVIRONMENT: &str = "
`genom3` rejects the specification. `dotgen check` and editors show a warning, because the text itself may be
correct. They check the rest and count the names that depend on the missing file or package. `dotgen check
--deny missing` (or `DOTGEN_DENY=missing` in the environment) reports an error instead. `dotgen deps` lists
missing files and packages and how to install them.
";

/// A text in a fence with the language of an example.
fn block(id: &str, text: &str) -> String {
    let plain = of_template(id) || text.starts_with("scenario ");
    let language = if plain { "text" } else { "genom" };
    format!("\n```{language}\n{}\n```\n", text.trim_end())
}

/// The example of a code and, if there is one, its correction.
fn examples(code: &Code) -> String {
    let id = code.id;
    let Some((example, corrected)) = code
        .example
        .map(|example| (example.to_owned(), code.corrected.map(str::to_owned)))
        .or_else(|| fixture(id).map(|(bad, good)| (bad, Some(good))))
    else {
        return String::new();
    };
    let mut out = String::from("\n## Example\n");
    if let Some(scenario) = scenario(id).filter(|code| !code.specification.is_empty()) {
        out += &block(id, scenario.specification);
    }
    out += &block(id, &example);
    if let Some(codel) = codel(id) {
        let _ = write!(out, "\n```c\n{}\n```\n\nCorrected:\n", codel.source.trim_end());
        match codel.corrected {
            Correction::Specification(text) => out += &block(id, text),
            Correction::Source(text) => {
                let _ = write!(out, "\n```c\n{}\n```\n", text.trim_end());
            }
        }
    }
    if let Some(corrected) = corrected {
        out += "\nCorrected:\n";
        out += &block(id, &corrected);
    }
    out
}

/// Says what `dotgen.toml` and comments can do about a code.
fn configuration(code: &Code) -> String {
    let id = code.id;
    if codes::is_environment(id) {
        return ENVIRONMENT.to_owned();
    }
    if code.severity == Severity::Error {
        let rejected = if of_template(id) {
            "the template fails"
        } else if scenario(id).is_some() {
            "the scenario cannot be verified"
        } else {
            "the specification is rejected"
        };
        return format!("\nThis error cannot be switched off: {rejected}.\n");
    }
    if scenario(id).is_some() {
        return "\nThis warning cannot be switched off.\n".to_owned();
    }
    let mut out = format!(
        "\n## Configuration\n\nFor a whole project, set the severity:\n\n```toml\n# dotgen.toml\n[severity]\n\"{id}\" = \"off\" \
         # or \"hint\", \"information\", \"warning\", \"error\"\n```\n"
    );
    if !of_verification(id) {
        let places = match codel(id) {
            Some(_) => "above the declaration, or in front of or inside the function",
            None => "above the declaration",
        };
        let _ = write!(
            out,
            "\nTo allow a single finding, write a comment with the reason {places}: `// dotgen: allow({id}) the reason`.\n"
        );
    }
    out
}

fn page(code: &Code) -> String {
    let Code { id, meaning, why, fix, .. } = code;
    let default = match code.on {
        true => severity(code.severity),
        false => "off",
    };
    let reference = match code.reference {
        true if of_template(id) => " The template engine of GenoM3 reports it too.",
        true => " `genom3` reports it too.",
        false => "",
    };
    format!(
        "# {id}\n\n{meaning}\n\nDefault severity: **{default}**.{reference}\n{}\n## Why it matters\n\n{why}\n\n## What to do\n\n{fix}\n{}",
        examples(code),
        configuration(code)
    )
}

fn index(codes: &[Code]) -> String {
    let mut out = String::from(
        "# Diagnostics\n\nEvery code that dotgen reports, with its default severity. Codes never change their meaning.\n\
         `dotgen explain CODE` prints the page of a code.\n\n\
         | Code | Default | Meaning |\n| --- | --- | --- |\n",
    );
    for code in codes {
        let default = match code.on {
            true => severity(code.severity),
            false => "off",
        };
        let meaning = code.meaning.replace('|', "\\|");
        let _ = writeln!(out, "| [{id}]({id}.md) | {default} | {meaning} |", id = code.id);
    }
    out
}

#[test]
fn the_pages_of_all_codes_are_up_to_date() {
    let folder = workspace_root().join("docs/diagnostics");
    let codes: Vec<Code> = all().collect();
    let mut wanted: BTreeMap<String, String> = BTreeMap::new();
    for code in &codes {
        let before = wanted.insert(format!("{}.md", code.id), page(code));
        assert!(before.is_none(), "`{}` is in two tables", code.id);
    }
    wanted.insert("README.md".into(), index(&codes));
    let mut stale = Vec::new();
    for (name, text) in &wanted {
        let path = folder.join(name);
        if std::fs::read_to_string(&path).ok().as_deref() != Some(text) {
            std::fs::create_dir_all(path.parent().unwrap_or(&folder)).unwrap();
            std::fs::write(&path, text).unwrap();
            stale.push(name.clone());
        }
    }
    assert!(
        stale.is_empty(),
        "docs/diagnostics was not up to date; commit the new pages: {stale:?}"
    );
}

#[test]
fn every_code_has_an_example() {
    for code in all() {
        assert!(code.example.is_some() || fixture(code.id).is_some(), "{} has no example", code.id);
    }
}

/// The texts of a page are sentences, and the first one is short enough for a table.
#[test]
fn every_code_is_explained_in_sentences() {
    for code in all() {
        let id = code.id;
        for text in [code.meaning, code.why, code.fix] {
            let capital = |first: char| !first.is_lowercase();
            assert!(text.starts_with(capital) || text.starts_with("dotgen "), "{id}: {text}");
            assert!(text.ends_with('.'), "{id}: {text}");
        }
        let length = code.meaning.chars().count();
        assert!(length <= 120, "{id}: {length} characters: {}", code.meaning);
    }
}

/// Every `"scn-…"` in the sources is in the table, and the table has no other codes.
#[test]
fn every_code_of_scenarios_is_in_the_table() {
    let mut used = BTreeSet::new();
    for folder in ["timing/src", "views/src/verification"] {
        let files = walkdir::WalkDir::new(workspace_root().join(folder)).into_iter();
        for entry in files.flatten() {
            let path = entry.path();
            let table = path.to_string_lossy().replace('\\', "/");
            if !table.ends_with(".rs") || table.contains("/scn/codes") {
                continue;
            }
            let text = std::fs::read_to_string(path).unwrap();
            let codes = text.split("\"scn-").skip(1);
            used.extend(codes.filter_map(|rest| Some(format!("scn-{}", rest.split_once('"')?.0))));
        }
    }
    let known: BTreeSet<String> = scenarios::all().map(|code| code.id.to_owned()).collect();
    assert_eq!(used, known);
}
