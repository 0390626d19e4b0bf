//! Scenarios.

use std::sync::Arc;

use dotgen_analysis::host::{AnalysisHost, BatchInput, Input};
use dotgen_loaders::EmptyLoader;
use dotgen_syntax::encoding;
use dotgen_timing::scn;

/// What the scenarios are about.
const COMPONENT: &str = include_str!("../../../examples/pump/pump.gen");

/// Parses, formats, resolves, and completes at one place.
pub(super) fn read(input: &[u8]) {
    let text = encoding::decode(input.to_vec());
    let parse = scn::parse(&text);
    for error in &parse.errors {
        assert!(text.get(error.range.clone()).is_some(), "{error:?}");
        assert!(!error.message.to_string().is_empty(), "{error:?}");
    }
    if let Some(once) = scn::format(&text) {
        let solid = |text: &str| -> String { text.split_whitespace().collect() };
        assert_eq!(solid(&text), solid(&once), "the formatter changed more than blanks");
        let twice = scn::format(&once).unwrap_or_else(|| once.clone());
        assert_eq!(once, twice, "formatted twice is not formatted once");
    }
    let host = AnalysisHost::new(Arc::new(EmptyLoader));
    let input_of = Input::Text { name: "/pump.gen".into(), text: COMPONENT.into() };
    let unit = host
        .analysis()
        .batch(&BatchInput { inputs: vec![input_of], ..BatchInput::default() })
        .expect("nothing cancels");
    let names = scn::names::Names::new(&[&unit.spec]);
    for unknown_name in names.unknown_names(&parse.scenario) {
        assert!(text.get(unknown_name.range.clone()).is_some(), "{unknown_name:?}");
    }
    drop(names.references(&parse.scenario));
    drop(scn::outline::outline(&text, &parse.scenario));
    let sum = input.iter().fold(0usize, |sum, byte| sum.wrapping_mul(31) + usize::from(*byte));
    let mut offset = sum % (text.len() + 1);
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    drop(scn::complete::complete(&text, &parse.scenario, &names, offset));
}
