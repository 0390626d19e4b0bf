//! What follows a new signature: the body, calls, comments, and how the parameters are laid out.

use std::sync::Arc;

use dotgen_codegen::codels::command::{Project, SyncOptions, SyncReport, sync};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_codegen::codels::stub::StubOptions;

use crate::codels::project::{Overlay, host_over};

fn stubs() -> StubOptions {
    StubOptions { use_parameters: true, ..StubOptions::default() }
}

/// The source after `sync`, and what it says.
fn synced(params: &str, code: &str) -> (String, SyncReport) {
    let specification = format!(
        "component c {{\n  struct s {{ double x; }};\n  ids {{ s a; double v; double w; long n; }};\n  \
         task t {{\n    codel<start> f({params}) yield ether;\n  }};\n}};\n"
    );
    let mut files = Overlay { disk: false, ..Overlay::default() };
    files.texts.insert("/c.gen".into(), specification);
    files.texts.insert("/codels/c_t_codels.c".into(), code.to_owned());
    let files = Arc::new(files);
    let mut host = host_over(files.clone(), Vec::new());
    let mut project = Project::new(&mut host, &*files, FilesConfig::default(), stubs());
    let report = sync(&mut project, &["/c.gen".into()], &SyncOptions::default());
    let text = project.text("/codels/c_t_codels.c".into());
    (text.unwrap_or_default().to_string(), report)
}

#[track_caller]
fn check(params: &str, code: &str, wanted: &str) {
    let (text, report) = synced(params, code);
    assert_eq!(text, wanted);
    assert!(report.left.findings.is_empty(), "{:?}", report.left.findings);
}

#[test]
fn a_changed_direction_changes_how_the_body_reaches_it() {
    check(
        "inout v",
        "genom_event f(double v, const genom_context self)\n{\n  double y = 2*v/v;\n  v++; g(&v, v);\n  return c_ether;\n}\n",
        "genom_event f(double *v, const genom_context self)\n{\n  double y = 2**v/(*v);\n  (*v)++; g(v, *v);\n  return c_ether;\n}\n",
    );
    check(
        "in v",
        "genom_event f(double *v, const genom_context self)\n{\n  *v = 2; g(v, *v);\n  return c_ether;\n}\n",
        "genom_event f(double v, const genom_context self)\n{\n  v = 2; g(&v, v);\n  return c_ether;\n}\n",
    );
}

#[test]
fn a_renamed_parameter_is_renamed_in_the_body() {
    check(
        "out w",
        "genom_event f(double *v, double old, const genom_context self)\n{\n  v[0] = 1; h(\"v\", x.v);\n  return c_ether;\n}\n",
        "genom_event f(double *w, const genom_context self)\n{\n  w[0] = 1; h(\"v\", x.v);\n  return c_ether;\n}\n",
    );
    // The body has the new name for something else.
    check(
        "in w, in n",
        "genom_event f(double v, const genom_context self)\n{\n  int w = v;\n  return c_ether;\n}\n",
        "genom_event f(double v, int32_t n, const genom_context self)\n{\n  int w = v;\n  return c_ether;\n}\n",
    );
}

#[test]
fn calls_follow_where_every_argument_is_known() {
    check(
        "in w, inout v",
        "genom_event f(double v, double w, const genom_context self) { return c_ether; }\n\
         static void g(double v, double w, genom_context self) { f(v, 2 * w, self); }\n",
        "genom_event f(double w, double *v, const genom_context self) { return c_ether; }\n\
         static void g(double v, double w, genom_context self) { f(2 * w, &v, self); }\n",
    );
}

#[test]
fn calls_keep_their_lines_and_comments() {
    check(
        "inout v, in w",
        "genom_event f(double v, double w, const genom_context self) { return c_ether; }\n\
         static void g(double v, genom_context self) {\n  f(v, /* half */\n    v / 2,\n    self);\n}\n",
        "genom_event f(double *v, double w, const genom_context self) { return c_ether; }\n\
         static void g(double v, genom_context self) {\n  f(&v, /* half */\n    v / 2,\n    self);\n}\n",
    );
}

#[test]
fn calls_that_cannot_follow_stay_and_are_named() {
    let (text, report) = synced(
        "in w, in v, in n",
        "genom_event f(double v, double w, const genom_context self)\n{\n  return f(w, v, self);\n}\n\
         static void g(double v, genom_context self) {\n  f(v, v, self);\n  f(/* far */ v, v, self);\n}\n",
    );
    for call in ["f(w, v, self);", "  f(v, v, self);", "f(/* far */ v, v, self);"] {
        assert!(text.contains(call), "{text}");
    }
    let notes: Vec<String> = report.notes.iter().map(ToString::to_string).collect();
    let lines: Vec<_> = report.notes.iter().map(|note| note.line).collect();
    assert_eq!(lines, [3, 6, 7], "{notes:?}");
    assert!(notes[0].ends_with("give this call the arguments for them"));
}

#[test]
fn an_address_is_taken_before_what_follows_it() {
    check(
        "in v",
        "genom_event f(double *v, const genom_context self)\n{\n  double y = v[0];\n  return c_ether;\n}\n",
        "genom_event f(double v, const genom_context self)\n{\n  double y = (&v)[0];\n  return c_ether;\n}\n",
    );
}

#[test]
fn comments_between_parameters_stay() {
    check(
        "in w, inout v",
        "genom_event\nf(double v, /* metres */\n  // how far\n  double w, const genom_context self)\n{\n  return c_ether;\n}\n",
        "genom_event\nf(// how far\n  double w,\n  double *v, /* metres */\n  const genom_context self)\n{\n  return c_ether;\n}\n",
    );
}

#[test]
fn parameters_stay_as_they_are_laid_out() {
    // Each on a line of its own.
    check(
        "in w, inout v, in n",
        "genom_event f (double  w,\n               double v,\n               genom_context self )\n{\n  return c_ether;\n}\n",
        "genom_event f (double  w,\n               double *v,\n               int32_t n,\n               genom_context self )\n{\n  return c_ether;\n}\n",
    );
    // A line break of its own, and one parameter less.
    check(
        "in w",
        "genom_event\nf(\n    double w\n  , double v\n  , genom_context self\n)\n{\n  return c_ether;\n}\n",
        "genom_event\nf(\n    double w\n  , genom_context self\n)\n{\n  return c_ether;\n}\n",
    );
    // Comments stay where every parameter does.
    check(
        "in w, out v",
        "genom_event f(double w, /* metres */ double v, // how far\n              genom_context self)\n{\n  return c_ether;\n}\n",
        "genom_event f(double w, /* metres */ double *v, // how far\n              genom_context self)\n{\n  return c_ether;\n}\n",
    );
}

#[test]
fn a_parameter_that_is_gone_and_used_is_named() {
    let (text, report) = synced(
        "in n",
        "genom_event f(double v, int n, const genom_context self)\n{\n  use(v);\n  return c_ether;\n}\n",
    );
    assert!(text.contains("f(int n, const genom_context self)"), "{text}");
    assert!(text.contains("use(v)"), "{text}");
    let notes: Vec<String> = report.notes.iter().map(ToString::to_string).collect();
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].starts_with("/codels/c_t_codels.c:3: `f` has no parameter `v`"));
}

#[test]
fn a_discarded_parameter_that_is_gone_leaves_no_statement() {
    let (text, report) = synced(
        "in n",
        "genom_event f(double v, int n, const genom_context self)\n{\n  (void)v; /* why */\n  (void)v;\n  (void)n;\n  return c_ether;\n}\n",
    );
    assert!(text.contains("{\n   /* why */\n  (void)n;\n  return"), "{text}");
    assert!(report.notes.is_empty(), "{:?}", report.notes);
}

#[test]
fn events_and_exceptions_of_helpers_count() {
    let specification = "component c {\n  exception bad;\n  task t {\n    codel<start> f() yield ether;\n    \
         codel<stop> h() yield more;\n    codel<more> g() yield ether;\n  };\n};\n";
    let code = "static genom_event fail(genom_context self) { return c_bad(self); }\n\
         static genom_event next(void) { return c_more; }\n\
         genom_event f(const genom_context self) { if (1) return fail(self); if (2) return next(); return c_ether; }\n\
         genom_event h(const genom_context self) { return c_more; }\n\
         genom_event g(const genom_context self) { return c_ether; }\n";
    let found =
        crate::codels::support::Fixture::new(specification, &[("c_t_codels.c", code)]).report();
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[1].contains("returns `c_more`"), "{found:#?}");
    assert!(found[0].contains("raises `c_bad`"), "{found:#?}");
}
