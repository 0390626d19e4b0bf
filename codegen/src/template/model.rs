//! The model of a template: a specification, its places, and the objects given to the template.

use dotgen_analysis::model::{Port, Spec};

use super::object::Registry;
use crate::lang::{Language, Mapper, Places};

/// The source of answers.
#[derive(Clone, Copy)]
pub(crate) struct Model<'a> {
    pub(crate) spec: &'a Spec,
    pub(crate) places: &'a dyn Places,
    pub(crate) registry: &'a Registry,
    /// Name of the running template.
    pub(crate) template: &'a str,
    pub(crate) language: Language,
}

impl<'a> Model<'a> {
    /// The mapper for types and names in the current language.
    pub(crate) fn mapper(&self) -> Mapper<'a> {
        Mapper::new(self.spec, self.places, self.language)
    }
}

/// `kind` of a port.
pub(crate) fn port_kind(port: &Port) -> &'static str {
    if port.multiple { "multiple" } else { "simple" }
}
