//! One target of [`dotgen_tests::fuzz`] under libFuzzer; the environment variable `FUZZ_TARGET` names it.

#![no_main]

use std::sync::LazyLock;

use dotgen_tests::fuzz::Target;
use libfuzzer_sys::fuzz_target;

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    Target::of(&name).unwrap_or_else(|| panic!("FUZZ_TARGET names no target: `{name}`"))
});

fuzz_target!(|data: &[u8]| TARGET.run(data));
