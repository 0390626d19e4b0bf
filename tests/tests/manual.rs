//! The manual pages of diagnostic codes: each code has one, in one form, and its page says what the tables of
//! codes say. The list of all pages is generated: a test writes it when it is not up to date, and fails.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use dotgen_analysis::codes::{self, Code};
use dotgen_analysis::diagnostic::Severity;
use dotgen_codegen::codels::drift;
use dotgen_codegen::template::check;
use dotgen_loaders::pages::{self, Page};
use dotgen_tests::workspace_root;
use dotgen_timing::diagnostic::Severity as ScenarioSeverity;
use dotgen_timing::scn::codes as scenarios;

/// The codes of all layers.
fn all() -> impl Iterator<Item = Code> {
    let codels = drift::CODES.map(|(id, severity)| Code::new(id, severity));
    let scenarios = scenarios::CODES.iter().map(|code| {
        let severity = match code.severity {
            ScenarioSeverity::Error => Severity::Error,
            ScenarioSeverity::Warning => Severity::Warning,
        };
        Code::new(code.id, severity)
    });
    codes::all().chain(codels).chain(check::CODES.iter().copied()).chain(scenarios)
}

fn of_scenario(id: &str) -> bool {
    scenarios::CODES.iter().any(|code| code.id == id)
}

/// True for a code of a verification, which no comment switches off.
fn of_verification(id: &str) -> bool {
    codes::verification::CODES.iter().any(|code| code.id == id)
}

fn of_template(id: &str) -> bool {
    check::CODES.iter().any(|code| code.id == id)
}

/// The text of a fixture that triggers a code, without its marks, and the text as it should be.
fn fixture(code: &str) -> Option<(String, String)> {
    let path = workspace_root().join(format!("analysis/tests/data/codes/{code}.gen"));
    let text = std::fs::read_to_string(path).ok()?;
    let (bad, good) = text.split_once("// near miss\n")?;
    let good = good.split_once("// corrected\n").map_or(good, |(_, good)| good);
    let bad = bad.lines().map(|line| format!("{}\n", line.replace("//!", "").trim_end())).collect();
    Some((bad, good.to_owned()))
}

fn default(code: &Code) -> &'static str {
    match code.severity {
        _ if !code.on => "off",
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

/// Says what `dotgen.toml` and comments can do about a code.
fn configuration(code: &Code) -> String {
    let id = code.id;
    if codes::is_environment(id) {
        return ENVIRONMENT.to_owned();
    }
    if code.severity == Severity::Error {
        let rejected = if of_template(id) {
            "the template fails"
        } else if of_scenario(id) {
            "the scenario cannot be verified"
        } else {
            "the specification is rejected"
        };
        return format!("\nThis error cannot be switched off: {rejected}.\n");
    }
    if of_scenario(id) {
        return "\nThis warning cannot be switched off.\n".to_owned();
    }
    let mut out = format!(
        "\n## Configuration\n\nFor a whole project, set the severity:\n\n```toml\n# dotgen.toml\n[severity]\n\"{id}\" = \"off\" \
         # or \"hint\", \"information\", \"warning\", \"error\"\n```\n"
    );
    if !of_verification(id) {
        let places = if id.starts_with(codes::CODEL) {
            "above the declaration, or in front of or inside the function"
        } else {
            "above the declaration"
        };
        let _ = write!(
            out,
            "\nTo allow a single finding, write a comment with the reason {places}: `// dotgen: allow({id}) the reason`.\n"
        );
    }
    out
}

fn index() -> String {
    let mut out = String::from(
        "# Diagnostics\n\nEvery code that dotgen reports, with its default severity. Codes never change their meaning.\n\
         `dotgen explain CODE` prints the page of a code.\n\n\
         | Code | Default | Meaning |\n| --- | --- | --- |\n",
    );
    for code in all() {
        let meaning = Page::read(code.id).map(|page| page.meaning.replace('|', "\\|"));
        let (meaning, default) = (meaning.unwrap_or_default(), default(&code));
        let _ = writeln!(out, "| [{id}]({id}.md) | {default} | {meaning} |", id = code.id);
    }
    out
}

#[test]
fn the_list_of_all_pages_is_up_to_date() {
    let path = pages::folder().join("README.md");
    let wanted = index();
    if std::fs::read_to_string(&path).ok().as_deref() != Some(&wanted) {
        std::fs::write(&path, wanted).unwrap();
        panic!("docs/diagnostics/README.md was not up to date; commit the new one");
    }
}

/// The texts of a page are sentences, and the first one is short enough for a table.
#[test]
fn every_code_has_a_page_that_says_what_the_tables_say() {
    let mut wrong = Vec::new();
    for code in all() {
        let id = code.id;
        let page = match Page::read(id) {
            Ok(page) => page,
            Err(why) => {
                wrong.push(why);
                continue;
            }
        };
        let mut check = |holds: bool, what: &str| {
            if !holds {
                wrong.push(format!("{id}: {what}"));
            }
        };
        let reference = match code.reference {
            true if of_template(id) => " The template engine of GenoM3 reports it too.",
            true => " `genom3` reports it too.",
            false => "",
        };
        let line = format!("Default severity: **{}**.{reference}", default(&code));
        check(page.default == line, &format!("its severity is `{line}`"));
        let advice = page.rest.strip_suffix(&configuration(&code));
        check(advice.is_some(), &format!("it ends with `{}`", configuration(&code)));
        let advice = advice.map_or("", str::trim_end);
        for text in [&*page.meaning, &*page.why, advice] {
            let capital = |first: char| !first.is_lowercase();
            let begins = text.starts_with(capital) || text.starts_with("dotgen ");
            check(begins && text.ends_with('.'), &format!("a sentence: {text}"));
        }
        let length = page.meaning.chars().count();
        check(length <= 120, &format!("{length} characters: {}", page.meaning));
        check(!page.examples.is_empty(), "it has an example");
        if let Some((bad, good)) = fixture(id) {
            let shown = |corrected| page.texts("genom", corrected).first().copied().unwrap_or("");
            check(shown(false).trim_end() == bad.trim_end(), &format!("its example is\n{bad}"));
            check(shown(true).trim_end() == good.trim_end(), &format!("its correction is\n{good}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_page_is_of_a_code() {
    let known: BTreeSet<&str> = all().map(|code| code.id).collect();
    assert_eq!(known.len(), all().count(), "a code is in two tables");
    for entry in walkdir::WalkDir::new(pages::folder()).into_iter().flatten() {
        let path = entry.path().strip_prefix(pages::folder()).unwrap().with_extension("");
        let id = path.to_string_lossy().replace('\\', "/");
        let is_page = entry.file_type().is_file() && id != "README";
        assert!(!is_page || known.contains(&*id), "{id} is no code");
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
            if !table.ends_with(".rs") || table.contains("/scn/codes.rs") {
                continue;
            }
            let text = std::fs::read_to_string(path).unwrap();
            let codes = text.split("\"scn-").skip(1);
            used.extend(codes.filter_map(|rest| Some(format!("scn-{}", rest.split_once('"')?.0))));
        }
    }
    let known: BTreeSet<String> = scenarios::CODES.iter().map(|code| code.id.to_owned()).collect();
    assert_eq!(used, known);
}
