//! Tests of exported models.

mod examples;
mod outside;
mod read_back;
mod systems;
