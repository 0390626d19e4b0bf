//! The examples of the manual: each triggers its code, and its correction does not.

use dotgen_loaders::pages::Page;
use dotgen_timing::scn::{codes, parse};
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::scenario::{ROBOT, load};

/// Returns the codes for a scenario over a specification.
fn found(specification: &str, scenario: &str) -> Vec<&'static str> {
    let unit = load(specification);
    let parsed = parse(scenario);
    if !parsed.errors.is_empty() {
        return parsed.errors.iter().map(|error| error.code).collect();
    }
    let input = SystemInput { specs: vec![&unit.spec] };
    let options = Options::default();
    let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
    report.diagnostics.iter().map(|error| error.code).collect()
}

/// Codes of file access, which the layer above reports.
const OF_FILES: [&str; 4] = ["scn-no-use", "scn-use-not-found", "scn-times", "scn-times-name"];

#[test]
fn the_examples_of_the_manual_trigger_their_codes() {
    for code in codes::CODES {
        let id = code.id;
        let page = Page::read(id).expect("every code has a page");
        let text = |language, corrected| page.texts(language, corrected).first().copied();
        let Some(scenario) = text("text", false).filter(|_| !OF_FILES.contains(&id)) else {
            continue;
        };
        let specification = text("genom", false).unwrap_or(ROBOT);
        let codes = found(specification, scenario);
        assert!(codes.contains(&id), "{id}: {codes:?}");
        let codes = match text("text", true) {
            Some(corrected) => found(specification, corrected),
            None => found(text("genom", true).unwrap_or_default(), scenario),
        };
        let errors: Vec<_> = codes.iter().filter(|code| code.starts_with("scn-")).collect();
        assert!(errors.is_empty(), "{id}: corrected: {errors:?}");
    }
}
