//! `dotgen verify --certificate`.

use crate::directory::{Directory, status, stderr};

#[test]
fn a_certificate_has_the_checks_that_invariants_prove() {
    let directory = Directory::new(&[
        (
            "c.gen",
            "component c {\n  ids { long a; };\n  task t { period 10 ms;\n    codel<start> f(inout a) yield pause::start wcet 3 ms; };\n  task u { period 20 ms;\n    codel<start> g(inout a) yield pause::start wcet 2 ms; };\n};\n",
        ),
        (
            "c.scn",
            "scenario c {\n  use \"c.gen\";\n  check always not (c.t.start.exec and c.u.start.exec);\n  check schedulable c.t;\n}\n",
        ),
    ]);
    let output = directory.run(&["verify", "--certificate", "c.json", "c.scn"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert_eq!(stderr(&output), "`c.json`: 1 of 2 checks certified, 1 not\n");
    let certificate = std::fs::read(directory.path().join("c.json")).expect("it is written");
    let answers = dotgen_check::check(&certificate).expect("it is a certificate");
    let told: Vec<String> = answers.iter().map(|one| one.outcome.to_string()).collect();
    assert!(told[0].starts_with("accepted: never "), "{told:?}");
    assert!(told[1].starts_with("not certified: proved by "), "{told:?}");
}
