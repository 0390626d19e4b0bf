//! Tests of the verifier.

mod agreement;
mod corpus;
mod effort;
mod scenario;
