//! Members that a specification has renamed, followed into the sources by one `sync`.

use std::sync::Arc;

use dotgen_codegen::codels::command::{Project, SyncOptions, SyncReport, sync};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_codegen::codels::stub::StubOptions;

use crate::codels::project::{Overlay, host_over};

/// The source after `sync`, and what it says.
fn synced(specification: &str, code: &str) -> (String, SyncReport) {
    let name = match specification.contains("lang") {
        true => "/codels/c_t_codels.cc",
        false => "/codels/c_t_codels.c",
    };
    let mut files = Overlay { disk: false, ..Overlay::default() };
    files.texts.insert("/c.gen".into(), specification.to_owned());
    files.texts.insert(name.into(), code.to_owned());
    let files = Arc::new(files);
    let mut host = host_over(files.clone(), Vec::new());
    let config = FilesConfig::default();
    let mut project = Project::new(&mut host, &*files, config, StubOptions::default());
    let roots = ["/c.gen".into()];
    let report = sync(&mut project, &roots, &SyncOptions::default());
    let again = sync(&mut project, &roots, &SyncOptions::default());
    assert!(again.applied.is_empty(), "{:?}", again.applied);
    let text = project.text(name.into()).unwrap_or_default().to_string();
    (text, report)
}

#[track_caller]
fn check(specification: &str, code: &str, wanted: &str) {
    let (text, report) = synced(specification, code);
    assert_eq!(text, wanted, "{:?}", report.left.findings);
    assert!(report.left.findings.is_empty(), "{:?}", report.left.findings);
}

/// A component whose `ids` and codel are given.
fn component(ids: &str, params: &str) -> String {
    format!(
        "component c {{\n  struct point {{ double x, y; }};\n  ids {{ {ids} }};\n  task t {{\n    codel<start> \
         f({params}) yield ether;\n  }};\n}};\n"
    )
}

#[test]
fn a_renamed_member_is_followed_wherever_its_type_is_known() {
    let code = |member: &str| {
        format!(
            "static double g(const c_ids *all) {{ return all->{member} + all->rate; }}\n\
             genom_event f(c_ids *ids, const genom_context self)\n{{\n  c_ids copy = {{ .{member} = 1. }};\n  \
             struct {{ double speed; }} own;\n  own.speed = g(ids);\n  ids->{member} = copy.{member};\n  \
             return c_ether;\n}}\n"
        )
    };
    check(
        &component("double speeds; double rate;", "inout ::ids"),
        &code("speed"),
        &code("speeds"),
    );
}

#[test]
fn one_member_left_on_either_side_is_no_evidence() {
    let code = "genom_event f(c_ids *ids, const genom_context self)\n{\n  ids->speed = 1.;\n  return c_ether;\n}\n";
    let (text, report) = synced(&component("point velocity;", "inout ::ids"), code);
    assert_eq!(text, code);
    let left: Vec<_> = report.left.findings.iter().map(|finding| finding.code).collect();
    assert_eq!(left, ["codel/unknown-member"]);
}

#[test]
fn members_of_a_nested_designator_are_those_of_the_member() {
    let code = "genom_event f(c_ids *ids, const genom_context self)\n{\n  *ids = (c_ids){ .goal.x = 1., .way[1].y = 2. };\n  return c_ether;\n}\n";
    check(&component("point goal; point way[3];", "inout ::ids"), code, code);
}

#[test]
fn several_are_told_apart_by_their_names() {
    check(
        &component("double max_speed; double min_speed; long n;", "inout ::ids"),
        "genom_event f(c_ids *ids, const genom_context self)\n{\n  ids->maxspeed = ids->minspeed;\n  return c_ether;\n}\n",
        "genom_event f(c_ids *ids, const genom_context self)\n{\n  ids->max_speed = ids->min_speed;\n  return c_ether;\n}\n",
    );
}

#[test]
fn members_of_members_are_followed() {
    let specification = component("point goal; point way[3];", "inout ::ids, in goal::g")
        .replace("double x, y;", "double east, y;");
    check(
        &specification,
        "genom_event f(c_ids *ids, const c_point *g, const genom_context self)\n{\n  ids->goal.eest = ids->way[1].eest + g->eest + g->y;\n  return c_ether;\n}\n",
        "genom_event f(c_ids *ids, const c_point *g, const genom_context self)\n{\n  ids->goal.east = ids->way[1].east + g->east + g->y;\n  return c_ether;\n}\n",
    );
}

#[test]
fn the_parameter_of_the_member_follows_too() {
    let code = |member: &str| {
        format!(
            "genom_event f(double *{member}, c_ids *ids, const genom_context self)\n{{\n  *{member} = ids->{member};\n  \
             return c_ether;\n}}\n"
        )
    };
    check(
        &component("double velocity; long n;", "out velocity, inout ::ids"),
        &code("v"),
        &code("velocity"),
    );
    // Where nothing else tells, a name that comes near does.
    let code = |member: &str| {
        format!(
            "genom_event f(double *{member}, const genom_context self)\n{{\n  *{member} = 1;\n  return c_ether;\n}}\n"
        )
    };
    let specification = component("double max_speed; long n;", "out max_speed");
    check(&specification, &code("maxspeed"), &code("max_speed"));
    // People may call a parameter as they like.
    check(&specification, &code("v"), &code("v"));
}

#[test]
fn members_are_followed_in_cxx() {
    let specification = component("double speeds; sequence<point> way;", "inout ::ids")
        .replace("component c {\n", "component c {\n  lang \"c++\";\n");
    check(
        &specification,
        "genom::event f(c::ids &ids)\n{\n  for (auto &p : ids.way) p.x = ids.speed;\n  return c::ether;\n}\n",
        "genom::event f(c::ids &ids)\n{\n  for (auto &p : ids.way) p.x = ids.speeds;\n  return c::ether;\n}\n",
    );
}

#[test]
fn what_nobody_can_know_is_left_and_named() {
    let lines = |specification: &str, code: &str| {
        let (text, report) = synced(specification, code);
        assert_eq!(text, code);
        let found = report.left.findings.iter();
        let found = found.map(|finding| format!("{}: {}", finding.code, finding.message));
        found.collect::<Vec<_>>()
    };
    // Two may be meant.
    let code = "genom_event f(c_ids *ids, const genom_context self)\n{\n  ids->speed = 1;\n  return c_ether;\n}\n";
    assert_eq!(
        lines(&component("double u, v;", "inout ::ids"), code),
        ["codel/unknown-member: `c_ids` has no member `speed`"]
    );
    // The only one left is of another shape.
    let code = "genom_event f(c_ids *ids, const genom_context self)\n{\n  ids->goal.x = 1;\n  return c_ether;\n}\n";
    assert_eq!(
        lines(&component("long n;", "inout ::ids"), code),
        ["codel/unknown-member: `c_ids` has no member `goal`"]
    );
}
