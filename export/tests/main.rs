//! Tests of exported models.

mod checks;
mod examples;
mod outside;
mod random_systems;
mod read_back;
mod systems;
