//! Checks on the finished model, component by component.
//!
//! Each is a pure function of the [`Spec`] and one [`Component`] of it. [`component`] runs them all; a body
//! that was reopened later is checked in its state at the end of the body, from
//! [`crate::elab::BodyEnd::snapshot`].

mod concurrency;
mod machine;
mod usage;

use crate::{
    finding::Finding,
    model::{Component, Spec},
};

/// The conditions that must hold when the body of a component or interface ends.
pub fn component(spec: &Spec, component: &Component) -> Vec<Finding> {
    let mut found = Vec::new();
    machine::check(spec, component, &mut found);
    concurrency::check(spec, component, &mut found);
    found
}

/// Warnings about a component as a whole, after all of it was read.
pub(crate) fn lints(component: &Component) -> Vec<Finding> {
    let mut found = Vec::new();
    usage::check(component, &mut found);
    found
}
