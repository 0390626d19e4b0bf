//! `dotgen scenario import`: clients of published models become scenarios.

use crate::directory::{Directory, status, stderr, stdout};

const SPEC: &str = "\
component rover {
  version \"1.0\"; lang \"c\";
  ids { double speed; };
  task track { period 100 ms; };
  function StopTrack() { codel rover_stop(inout speed) wcet 1 ms; };
  activity Track() {
    task track;
    codel<start> rover_track(inout speed) yield pause::start, ether wcet 3 ms;
  };
};
";

const CLIENT: &str = "\
var q: queue 10 of e := {|
  {rqid=ROVER_RQ(ROVER_Track_RQSTID_FCR), fr=true, wait_cycle=100},
  {rqid=ROVER_RQ(ROVER_StopTrack_RQSTID_FCR), fr=true, wait_cycle=0} //,
//{rqid=ROVER_RQ(ROVER_kill_RQSTID_FCR), fr=true, wait_cycle=0}
|}
from wait_after_rqst
  select wait [0,10]; to wait_after_rqst end
";

#[test]
fn a_fiacre_client_becomes_a_scenario_that_is_verified() {
    let directory = Directory::new(&[("rover.gen", SPEC), ("rover.client.fcr", CLIENT)]);
    let run = directory.run(&["scenario", "import", "rover.client.fcr", "rover.gen"]);
    assert_eq!(status(&run), 0, "{}", stderr(&run));
    insta::assert_snapshot!(stdout(&run), @r#"
    // The requests of `rover.client.fcr`.
    scenario rover {
      use "rover.gen";

      client requests {
        send rover.Track;
        delay [0,1000] ms;
        send rover.StopTrack;
        await ended rover.Track;
        await ended rover.StopTrack;
      }

      check schedulable *;
    }
    "#);
    let arguments = ["scenario", "import", "rover.client.fcr", "rover.gen", "-o", "s.scn"];
    assert_eq!(status(&directory.run(&arguments)), 0);
    assert_eq!(status(&directory.run(&["verify", "s.scn"])), 0);
    let again = directory.run(&arguments);
    assert_eq!(status(&again), 2);
    assert!(stderr(&again).contains("cannot create `s.scn`"), "{}", stderr(&again));
}

#[test]
fn stale_services_of_a_list_are_named() {
    let list = "cnam_Track 1\ncnam_Stop 1\ncnam_kill 1\n";
    let directory = Directory::new(&[("rover.gen", SPEC), ("rover.rqst", list)]);
    let run = directory.run(&["scenario", "import", "rover.rqst", "rover.gen"]);
    assert_eq!(status(&run), 1);
    let text = stderr(&run);
    assert!(text.contains("line 2: `cnam_Stop` is not a service; there is `StopTrack`"), "{text}");
    let steps = "    send rover.Track;\n    kill rover;\n";
    assert!(stdout(&run).contains(steps), "{}", stdout(&run));
    let run = directory.run(&["scenario", "import", "rover.rqst"]);
    assert_eq!(status(&run), 2);
    assert!(stderr(&run).contains("name the specification"), "{}", stderr(&run));
}

#[test]
fn a_service_of_several_components_needs_the_name_of_one() {
    let second = SPEC.replace("component rover", "component crane");
    let list = "cnam_kill 1\nTrack 1\nCRANE_Track 1\ncrane_kill 1\n";
    let files = [("rover.gen", SPEC), ("crane.gen", &second), ("all.rqst", list)];
    let directory = Directory::new(&files);
    let run = directory.run(&["scenario", "import", "all.rqst", "rover.gen", "crane.gen"]);
    assert_eq!(status(&run), 1);
    let text = stderr(&run);
    for line in ["line 1: `cnam_kill`", "line 2: `Track`"] {
        assert!(text.contains(&format!("{line} is a service of several components")), "{text}");
    }
    let steps = "requests {\n    send crane.Track;\n    kill crane;\n  }";
    assert!(stdout(&run).contains(steps), "{}", stdout(&run));
}
