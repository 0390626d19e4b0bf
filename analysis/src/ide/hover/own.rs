//! The component's own declarations about a service of an interface.

use dotgen_syntax::{SyntaxKind, TextRange};

use super::{code, elsewhere, facts, view_of};
use crate::{
    elab::{DefId, DefKind},
    ide::{FileView, render::normalized},
};

/// The declaration with which the component around a mention completes a service of an interface.
pub(super) fn completion(view: &FileView<'_>, mention: TextRange, id: DefId) -> Option<String> {
    let elaborated = view.elaborated();
    let declared = elaborated.definitions.get(id)?;
    let interface = elaborated.definitions.get(declared.container?)?;
    let of_an_interface = interface.kind == DefKind::Interface
        && matches!(declared.kind, DefKind::Function | DefKind::Activity | DefKind::Attribute);
    if !of_an_interface {
        return None;
    }
    let mut mentions = elaborated.references.iter().filter(|reference| reference.target == id);
    let here = mentions
        .clone()
        .find(|reference| view.place(reference.at) == Some((view.file, mention)))?;
    let component = elaborated.spec.components.get(here.component?)?;
    let own =
        mentions.find(|mention| mention.is_declaration() && mention.component == here.component)?;

    let (file, range) = view.place(own.at)?;
    let there = view_of(view, file)?;
    let name = there.root().covering_element(range);
    let service = name.ancestors().find(|ancestor| ancestor.kind() == SyntaxKind::SERVICE)?;
    let mut out = code(&normalized(&there, &service));
    out += &format!(
        "\n\nin `{}` · implements `{}` of the interface `{}`",
        component.name, declared.name, interface.name
    );
    if let Some(file) = elsewhere(view, declared) {
        out += &format!(" from `{file}`");
    }
    let mut services = component.services.iter();
    let service = services.find(|service| service.name == declared.name)?;
    if let Some(doc) = service.doc.as_ref().filter(|doc| !doc.is_empty()) {
        out += &format!("\n\n{doc}");
    }
    if let Some(facts) = facts::of_service(component, &declared.name) {
        out += &format!("\n\n{facts}");
    }
    Some(out)
}
