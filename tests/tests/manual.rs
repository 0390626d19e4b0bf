//! The manual pages of diagnostic codes are generated; this test writes them when they are not up to
//! date, and fails.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use dotgen_analysis::codes::{self, Code};
use dotgen_analysis::diagnostic::Severity;
use dotgen_codegen::codels::codes::{CODES, CodelCode};
use dotgen_codegen::template::check;
use dotgen_tests::workspace_root;

/// The codes of all layers.
fn all() -> impl Iterator<Item = Code> {
    let codels = CODES.iter().map(|it| Code {
        id: it.code.as_str(),
        severity: it.code.severity(),
        on: true,
        meaning: it.meaning,
        why: Some(it.why),
        example: Some(it.specification),
        fix: Some(it.fix),
        reference: false,
    });
    codes::all()
        .chain(codels)
        .chain(check::CODES.iter().copied())
}

/// The entry of a code that compares specification and codels.
fn codel(id: &str) -> Option<&'static CodelCode> {
    CODES.iter().find(|it| it.code.as_str() == id)
}

/// Whether a code comes from a verification, which looks at no comments.
fn of_verification(id: &str) -> bool {
    codes::verification::CODES.iter().any(|it| it.id == id)
}

/// Whether a code is about a file of a template.
fn of_template(id: &str) -> bool {
    check::CODES.iter().any(|it| it.id == id)
}

/// The text of a fixture that triggers a code, without its marks.
fn fixture(code: &str) -> Option<String> {
    let path = workspace_root().join(format!("analysis/tests/data/codes/{code}.gen"));
    let text = std::fs::read_to_string(path).ok()?;
    let (bad, _) = text.split_once("// near miss\n")?;
    Some(
        bad.lines()
            .map(|line| format!("{}\n", line.replace("//!", "").trim_end()))
            .collect(),
    )
}

fn severity(it: Severity) -> &'static str {
    match it {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Information => "information",
        Severity::Hint => "hint",
    }
}

/// About what is wrong with the machine and not with the text.
const ENVIRONMENT: &str = "
`dotgen check` rejects the specification, as the reference compiler does. Editors show a warning: nothing is wrong
with the text. In both, the rest is checked; what would come from there is unknown, and nothing is reported that
only follows from it. `dotgen deps` lists what is missing and what would bring it.
";

fn page(code: &Code) -> String {
    let Code { id, meaning, .. } = code;
    let mut out = format!("# {id}\n\nReports {meaning}.\n\n");
    let default = if code.on {
        severity(code.severity)
    } else {
        "off"
    };
    let _ = writeln!(out, "Default: **{default}**.");
    if code.reference {
        out.push_str("The reference compiler reports this too.\n");
    }
    if let Some(why) = code.why {
        let _ = write!(out, "\n## Why\n\n{why}\n");
    }
    if let Some(example) = code.example.map(str::to_owned).or_else(|| fixture(id)) {
        let _ = write!(
            out,
            "\n## Example\n\n```{}\n{}\n```\n",
            if of_template(id) { "text" } else { "genom" },
            example.trim_end()
        );
    }
    if let Some(codel) = codel(id) {
        let _ = write!(out, "\n```c\n{}\n```\n", codel.source.trim_end());
    }
    if let Some(fix) = code.fix {
        let _ = write!(out, "\n## What to do\n\n{fix}\n");
    }
    if dotgen_analysis::codes::is_environment(id) {
        out.push_str(ENVIRONMENT);
    } else if code.severity == Severity::Error {
        let rejected = match of_template(id) {
            true => "the template fails",
            false => "the specification is rejected",
        };
        let _ = writeln!(out, "\nAn error cannot be switched off: {rejected}.");
    } else {
        let _ = write!(
            out,
            "\n## Configuration\n\n```toml\n# dotgen.toml\n[severity]\n\"{id}\" = \"off\" # or \"hint\", \"information\", \"warning\", \"error\"\n```\n"
        );
        if !of_verification(id) {
            let _ = write!(
                out,
                "\nIn one place: a comment `// dotgen: allow({id}) why it is right here` above the declaration{}.\n",
                match codel(id) {
                    Some(_) => ", or in front of or inside the function",
                    None => "",
                }
            );
        }
    }
    out
}

fn index(codes: &[Code]) -> String {
    let mut out = String::from(
        "# Diagnostics\n\nEvery code that dotgen reports, with its default severity. Codes never change their meaning.\n\n\
         | Code | Default | Reports |\n| --- | --- | --- |\n",
    );
    for code in codes {
        let default = if code.on {
            severity(code.severity)
        } else {
            "off"
        };
        let meaning = code.meaning.replace('|', "\\|");
        let _ = writeln!(
            out,
            "| [{id}]({id}.md) | {default} | {meaning} |",
            id = code.id
        );
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
        assert!(
            code.example.is_some() || fixture(code.id).is_some(),
            "{} has no example",
            code.id
        );
    }
}
