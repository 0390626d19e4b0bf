//! The prototypes of a codel in both languages, for display.

use dotgen_analysis::model::{Codel, ComponentId, Spec};

use super::{Language, Mapper, NoPlaces};

/// Names of the languages, and the prototype in each; a language without a prototype is left out. `component`
/// is an index into [`Spec::components`].
pub fn prototypes(
    spec: &Spec,
    component: ComponentId,
    codel: &Codel,
) -> Vec<(&'static str, String)> {
    [("c", Language::C), ("c++", Language::Cxx)]
        .into_iter()
        .filter_map(|(word, language)| {
            let mapper = Mapper::new(spec, &NoPlaces, language);
            Some((word, mapper.prototype(component, codel, " ").ok()?))
        })
        .collect()
}
