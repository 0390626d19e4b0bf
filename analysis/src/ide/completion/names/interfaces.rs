//! Interfaces that a component can provide, use or extend.

use smol_str::SmolStr;

use super::VisibleNames;
use crate::{
    elab::DefKind,
    ide::{completion::Completions, context::Word},
    model::{Component, ComponentId},
};

impl VisibleNames<'_, '_> {
    /// Returns true if no name from an interface clashes with a name of the component. False if the interface
    /// is not known.
    fn has_room_for(&self, interface: &str) -> bool {
        let Some(interface) =
            self.spec().components.iter().find(|component| component.name == interface)
        else {
            return false;
        };
        fn all(component: &Component) -> impl Iterator<Item = &SmolStr> {
            let services = component.services.iter().map(|service| &service.name);
            let ports = component.ports.iter().map(|port| &port.name);
            services.chain(ports).chain(component.tasks.iter().map(|task| &task.name))
        }
        let own = self.component();
        !all(interface).any(|name| own.is_some_and(|own| all(own).any(|text| text == name)))
    }

    /// Returns true if the component already provides, uses or extends an interface.
    fn has_interface(&self, interface: &str) -> bool {
        let all = &self.spec().components;
        let named = |number: &ComponentId| {
            all.get(*number).is_some_and(|component| component.name == interface)
        };
        self.component().is_some_and(|component| {
            let mut listed =
                component.provides.iter().chain(&component.uses).chain(&component.extends);
            listed.any(named)
        })
    }

    /// Components and interfaces by kind, in order of declaration.
    pub(in crate::ide::completion) fn interfaces(
        &self,
        used: &[Word],
        rank: u8,
        out: &mut Completions,
    ) {
        for definition in &self.elaborated.definitions {
            let own = self.component().is_some_and(|own| own.name == definition.name);
            let named = used.iter().any(|word| word.text == definition.name)
                || self.has_interface(&definition.name);
            let unused_name_like = || self.has_room_for(&definition.name);
            if definition.kind == DefKind::Interface
                && !own
                && !named
                && self.is_before(definition)
                && unused_name_like()
            {
                self.push(definition, definition.name.to_string(), rank, out);
            }
        }
    }
}
