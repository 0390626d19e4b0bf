//! Changes and tokens stop the running snapshots.

use std::{sync::mpsc, thread};

use crate::{
    host::{Cancelled, Change},
    test_support::Fixture,
};

#[test]
fn a_token_cancels_its_snapshot_only() {
    let fixture = Fixture::new("const long n = 1;\n");
    let (one, two) = (fixture.analysis(), fixture.analysis());
    one.cancellation_token().cancel();
    assert_eq!(one.diagnostics("/main.gen".into()), Err(Cancelled::Local));
    assert_eq!(two.diagnostics("/main.gen".into()), Ok(vec![]));
}

#[test]
fn a_change_stops_a_reader_and_waits_for_it() {
    let mut fixture = Fixture::new("const long n = 1;\n");
    let analysis = fixture.analysis();
    let (ready, is_ready) = mpsc::channel();
    let reader = thread::spawn(move || {
        let mut asked = 0_u64;
        loop {
            // Every query is cancelled once a change waits.
            let result = analysis.diagnostics("/main.gen".into());
            if asked == 0 {
                ready.send(()).unwrap();
            }
            asked += 1;
            if let Err(why) = result {
                return why;
            }
        }
    });
    is_ready.recv().unwrap();
    fixture.host.apply(Change {
        files: vec![("/main.gen".into(), Some("typedef nope t;\n".into()))],
        ..Change::default()
    });
    assert_eq!(reader.join().unwrap(), Cancelled::PendingWrite);
    let after = fixture.analysis().diagnostics("/main.gen".into()).unwrap();
    assert_eq!(after[0].code, "unknown-type");
}
