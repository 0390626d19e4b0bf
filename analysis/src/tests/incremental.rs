//! The queries that an edit re-runs, from the log of the database.

use crate::test_support::Fixture;

const TWO_UNITS: &str = r#"
//- /a.gen
#include "x.idl"
component c {
  ids { long v; };
  task t { period 1 ms; };
  activity go() {
    task t;
    codel<start> begin(ids in v) yield ether;
  };
};
component e {
  ids { long v; };
  task t { period 1 ms; };
  activity stay() {
    task t;
    codel<start> other(ids in v) yield ether;
  };
};
//- /b.gen
#include "x.idl"
component d { version "1"; };
//- /x.idl
const long n = 1;
"#;

/// Runs the queries of an editor while typing; returns the ones that ran.
fn run(fixture: &Fixture) -> Vec<String> {
    for path in fixture.paths() {
        fixture.analysis().diagnostics(&path).unwrap();
    }
    fixture.take_log()
}

/// The two units after their queries, with a file that already has an edit.
fn edited(path: &str) -> Fixture {
    let mut fixture = Fixture::new(TWO_UNITS);
    run(&fixture);
    let text = fixture.text(path);
    fixture.edit(path, format!("\n{text}"));
    run(&fixture);
    fixture
}

fn count(log: &[String], query: &str) -> usize {
    log.iter().filter(|log| *log == query).count()
}

#[track_caller]
fn assert_never(log: &[String], queries: &[&str]) {
    for query in queries {
        assert_eq!(count(log, query), 0, "{query} in {log:#?}");
    }
}

const BELOW_ITEM_TREE: &[&str] =
    &["elaborated", "body_findings", "visits", "walk_unit", "includers"];

#[test]
fn an_edit_in_a_comment_stops_at_the_item_tree() {
    for path in ["/x.idl", "/a.gen"] {
        let fixture = Fixture::new(TWO_UNITS);
        assert_eq!(count(&run(&fixture), "elaborated"), 2);
        let mut fixture = edited(path);
        let text = fixture.text(path);
        fixture.edit(path, format!("// a comment\n\n{text}"));
        let log = run(&fixture);
        assert_never(&log, BELOW_ITEM_TREE);
        for once in ["lexed", "parse_text", "lowered", "item_tree", "skeleton", "mentioned"] {
            assert_eq!(count(&log, once), 1, "{once} in {log:#?}");
        }
    }
}

#[test]
fn an_edit_in_a_codel_checks_its_unit_once() {
    let mut fixture = edited("/a.gen");
    fixture.replace("/a.gen", "begin(ids in v)", "begin(ids out v)");
    let log = run(&fixture);
    assert_eq!(count(&log, "elaborated"), 1, "{log:#?}");
    assert_eq!(count(&log, "body_findings"), 1, "{log:#?}");
    assert_eq!(count(&log, "parse_text"), 1, "{log:#?}");
    assert_never(&log, &["walk_unit", "includers"]);
}

#[test]
fn an_edit_of_a_shared_file_elaborates_its_units() {
    let mut fixture = edited("/x.idl");
    fixture.edit("/x.idl", "const long n = 2;\n");
    let log = run(&fixture);
    assert_eq!(count(&log, "elaborated"), 2, "{log:#?}");
    assert_eq!(count(&log, "parse_text"), 1, "{log:#?}");
    assert_never(&log, &["walk_unit", "visits"]);
}

#[test]
fn nothing_runs_without_a_change() {
    let mut fixture = Fixture::new(TWO_UNITS);
    run(&fixture);
    assert_eq!(run(&fixture), [""; 0]);
    let same = fixture.text("/a.gen");
    fixture.edit("/a.gen", same);
    assert_eq!(run(&fixture), [""; 0]);
}

#[test]
fn a_missing_file_is_an_input() {
    let mut fixture = Fixture::new("//- /a.gen\n#include \"y.idl\"\n//- /b.gen\ncomponent d;\n");
    run(&fixture);
    fixture.edit("/y.idl", "const long n = 2;\n");
    let log = run(&fixture);
    assert_eq!(count(&log, "walk_unit"), 1, "{log:#?}");
    // The unit of the new file is not one of the two.
    assert_eq!(count(&log, "elaborated"), 1, "{log:#?}");
}
