//! The release of GenoM3 for a specification, and its effects.

use super::super::test_support::Fixture;
use crate::{
    host::{Config, Project},
    release::{Release, ReleaseChoice, ReleaseOrigin},
};

const OLD: &str = "component old { requires \"genom3 >= 2.99.26\"; };\n";

fn given(release: Release) -> Option<ReleaseChoice> {
    let origin = ReleaseOrigin::Environment;
    Some(ReleaseChoice { release, origin })
}

#[track_caller]
fn check(fixture: &Fixture, path: &str, release: &str, origin: ReleaseOrigin) {
    let choice = fixture.analysis().release(path.into()).unwrap();
    assert_eq!((choice.release.to_string().as_str(), choice.origin), (release, origin));
}

#[test]
fn without_any_word_it_is_the_newest_verified_one() {
    let fixture = Fixture::new("component c { doc \"genom3 >= 3.1 or so\"; };");
    check(&fixture, "/main.gen", "2.99.41", ReleaseOrigin::Default);
}

#[test]
fn the_greatest_bound_of_all_roots_counts() {
    let bound = |text: &str| ReleaseOrigin::Required(text.parse().unwrap());
    let mut fixture = Fixture::new(&format!(
        "//- /a.gen\n{OLD}//- /b.gen\n#include \"sub/part.idl\"\n//- /sub/part.idl\ncomponent b {{ }};\n"
    ));
    // Never older than the oldest known release.
    check(&fixture, "/b.gen", "2.99.39", bound("2.99.26"));
    // Included files count, comments do not.
    fixture.edit("/sub/part.idl", "#pragma requires \"genom3 >= 3.1\"\n");
    check(&fixture, "/a.gen", "3.1", bound("3.1"));
    for text in [
        "/* require \"genom3 >= 3.1\" */\n",
        "// require \"genom3 >= 3.1\"\n",
        "/*\n \"genom3 >= 3.1\"\n*/\n",
        "component b { doc \"say \\\"genom3 >= 3.1\\\"\"; };\n",
    ] {
        fixture.edit("/sub/part.idl", text);
        check(&fixture, "/a.gen", "2.99.39", bound("2.99.26"));
    }
    let text = "component b { doc \"a/*.gen\"; requires \"x\", \"genom3 >= 2.99.43\"; };\n";
    fixture.edit("/sub/part.idl", text);
    check(&fixture, "/a.gen", "2.99.43", bound("2.99.43"));
}

#[test]
fn what_is_said_counts_more_than_what_is_required() {
    let config = Config {
        release: given(Release::V2_99_41),
        projects: vec![
            Project { directory: "/p".into(), release: given(Release::V3), ..Project::default() },
            Project { directory: "/q".into(), ..Project::default() },
        ],
        ..Config::default()
    };
    let text = format!("//- /a.gen\n{OLD}//- /p/b.gen\n{OLD}//- /q/c.gen\n{OLD}");
    let fixture = Fixture::with_config(&text, config);
    check(&fixture, "/a.gen", "2.99.41", ReleaseOrigin::Environment);
    check(&fixture, "/p/b.gen", "3.0", ReleaseOrigin::Environment);
    let required = ReleaseOrigin::Required("2.99.26".parse().unwrap());
    check(&fixture, "/q/c.gen", "2.99.39", required);
}

#[test]
fn the_language_follows_the_release() {
    let stack = "component c { requires \"genom3 >= 2.99.41\"; stack 8k; };\n";
    let mut fixture = Fixture::new(stack);
    assert_eq!(fixture.all_diagnostics(), "");
    fixture.replace("/main.gen", "2.99.41", "2.99.26");
    let found = fixture.all_diagnostics();
    assert!(found.contains("prop-not-in-component") && found.contains("2.99.40"), "{found}");
    fixture.replace("/main.gen", "2.99.26", "2.99.40");
    assert_eq!(fixture.all_diagnostics(), "");
}

#[test]
fn what_older_releases_refuse_is_hinted_at_until_it_is_required() {
    let text = "component c {\n  requires \"genom3 >= 2.99.26\";\n  ids { long x; };\n  \
                attribute set(in x) { codel hook(inout x::y); };\n};\n";
    let config = Config { release: given(Release::V2_99_41), ..Config::default() };
    let mut fixture = Fixture::with_config(text, config);
    let found = fixture.analysis().diagnostics("/main.gen".into()).unwrap();
    let newer: Vec<_> =
        found.iter().filter(|diagnostic| diagnostic.code == "newer-release").collect();
    let [newer] = newer[..] else {
        panic!("{found:#?}");
    };
    let [edit] = &newer.fixes[0].edits[..] else {
        panic!("{newer:#?}");
    };
    assert_eq!(edit.new_text, "\"genom3 >= 2.99.41\"");
    assert_eq!(&text[edit.range.clone()], "\"genom3 >= 2.99.26\"");
    fixture.replace("/main.gen", "2.99.26", "2.99.41");
    assert!(!fixture.all_diagnostics().contains("newer-release"));
}

/// A port imported by `provides` keeps the type of the interface, and its name in the component is an alias
/// of that type; in older releases it has a type of its own.
#[test]
fn provided_ports_have_the_type_of_the_interface() {
    let text = "interface i { port out double p; };\ncomponent c { provides i; };\n"
        .replace("port out double p", "typedef double d; port out d p");
    for (release, expected) in [(Release::V2_99_39, "::c::p"), (Release::V2_99_41, "::i::p")] {
        let config = Config { release: given(release), ..Config::default() };
        let fixture = Fixture::with_config(&text, config);
        let unit = fixture.analysis().unit("/main.gen".into()).unwrap();
        assert_eq!(fixture.all_diagnostics(), "", "{release}");
        let component = &unit.spec.components.raw[1];
        let ty = component.ports.raw[0].ty;
        assert_eq!(unit.spec.full_name(ty).as_deref(), Some(expected), "{release}");
        assert_eq!(unit.spec.release, release);
    }
}

#[test]
fn what_is_used_gives_no_properties_from_2_99_43_on() {
    let text = "exception e_far {};
interface far { lang \"c++\"; requires \"far-idl\"; throws e_far; activity go() {}; };
component c { uses far; };
component d { extends far; };
";
    let read = |release: Release| {
        let config = Config { release: given(release), ..Config::default() };
        let fixture = Fixture::with_config(text, config);
        let spec = fixture.analysis().unit("/main.gen".into()).unwrap().spec;
        let of = |name: &str| {
            let component =
                spec.components.iter().find(|component| component.name == name).unwrap();
            (component.lang.clone(), component.requires.len(), component.throws.len())
        };
        assert_eq!(of("d"), (Some("c++".to_owned()), 1, 1));
        let used = spec.components.iter().find(|component| component.name == "c").unwrap();
        assert_eq!(used.remotes.raw[0].throws.len(), 1, "the service throws it");
        of("c")
    };
    assert_eq!(read(Release::V2_99_42), (Some("c++".to_owned()), 1, 1));
    assert_eq!(read(Release::V2_99_43), (Some("c".to_owned()), 0, 0));
}
