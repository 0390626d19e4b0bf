//! Tests of the database as a whole; tests of single features are next to their features.

mod cancellation;
mod consequences;
mod half_typed;
mod incremental;
mod random_edits;
mod releases;
mod units;
