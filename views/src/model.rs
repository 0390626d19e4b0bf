//! The model of a unit as a document: the output of `dotgen model` and the answer of `dotgen/model`.

use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model_json;
use dotgen_codegen::lang::prototypes;
use serde_json::Value;

/// The document, with places and the prototypes of codels.
pub fn document(unit: &UnitResult) -> Value {
    let spec = &unit.spec;
    let prototypes = |component, codel: &_| {
        let all = prototypes(spec, component, codel).into_iter();
        all.map(|(language, text)| (language.to_owned(), Value::from(text))).collect()
    };
    model_json::with_prototypes(spec, Some(&*unit.locations), Some(&prototypes))
}
