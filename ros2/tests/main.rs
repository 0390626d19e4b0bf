//! Tests of the crate as others use it.

mod common;
mod corpus;
mod hashes;
mod interfaces;
mod lists;
mod masquerade;
mod node;
mod payloads;
mod remap;

use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model::{Spec, TypeId};

/// Types and services with everything that has a form in ROS 2. The messages `Level`, `Point` and `State` are
/// those of the hashes of `rosidl`.
const PUMP: &str = include_str!("fixtures/pump.gen");

fn unit(text: &str) -> UnitResult {
    dotgen_loaders::unit(text).unwrap_or_else(|error| panic!("{error}"))
}

fn type_of(spec: &Spec, name: &str) -> TypeId {
    let mut all = spec.types.keys();
    let found = all.find(|&ty| spec.full_name(ty).as_deref() == Some(name));
    found.unwrap_or_else(|| panic!("no `{name}`"))
}
