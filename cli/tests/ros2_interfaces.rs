//! ROS 2 packages of components, and the parts without a form in ROS 2.

use crate::directory::{Directory, status, stderr, stdout};

/// Two modules become one package, two members one field, and an output is a keyword.
const ODD: &str = "module a { module b { struct c { long x; }; }; };
module a_b { struct c { long y; }; };
module m { struct s { long maxSpeed; long max_speed; }; };
component odd {
  version \"1\"; lang \"c\";
  ids { long n; };
  task t { period 10 ms; };
  port out a_b::c one;
  port out a::b::c two;
  port out m::s twice;
  attribute set_n(in n);
  function f(out long lambda) { codel f_codel(out lambda); };
};
";

const REFUSED: [&str; 3] = [
    "port `odd.two` is not offered to ROS 2: `a_b` and `a::b` both become the package `a_b`: rename one",
    "port `odd.twice` is not offered to ROS 2: two fields become `max_speed`: rename one",
    "service `odd.f` is not offered to ROS 2: `lambda` is a keyword of C++ or Python: rename it",
];

const LAMP: &str = "module light {
  enum colour { RED, GREEN };
  typedef string text;
  struct beam { colour hue; double power; sequence<long, 3> steps; };
};
component lamp {
  version \"1\"; lang \"c\";
  exception e_hot { double degrees; };
  ids { light::beam now; };
  task blink { period 10 ms; };
  port out light::beam beam;
  port in light::text words;
  attribute set_now(in now);
  function cool(in optional<long> level) { codel lampCool(in level); throw e_hot; };
  activity shine(in light::beam wanted, out double spent) {
    task blink;
    codel<start> lampShine(in wanted, out spent) yield ether;
  };
};
";

#[test]
fn a_component_is_written_as_packages() {
    let directory = Directory::new(&[("lamp.gen", LAMP)]);
    let generate = |more: &[&str]| {
        let words = ["generate", "ros2-interfaces", "-o", "ros"];
        directory.run(&[&words, more, &["lamp.gen"]].concat())
    };
    let output = generate(&[]);
    assert_eq!((status(&output), stderr(&output)), (0, String::new()));
    let written = stdout(&output);
    let mut all = String::new();
    for line in written.lines() {
        let path = line.strip_prefix("creating ").expect("a new file");
        let text = std::fs::read_to_string(directory.path().join(path)).expect("a file");
        all += &format!("== {path}\n{text}");
    }
    insta::assert_snapshot!(all);
    // A changed file stays, unless it is to be overwritten.
    let message = "ros/light/msg/Beam.msg";
    directory.write(message, b"mine\n");
    let output = generate(&[]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains(message), "{}", stderr(&output));
    assert_eq!(status(&generate(&["-f"])), 0);
    let text = std::fs::read(directory.path().join(message)).expect("a file");
    assert_ne!(text, b"mine\n");
}

#[test]
fn parts_without_a_form_are_named_and_the_others_written() {
    let directory = Directory::new(&[("odd.gen", ODD)]);
    let output = directory.run(&["generate", "ros2-interfaces", "odd.gen"]);
    assert_eq!(status(&output), 0);
    let told = stderr(&output);
    for (line, refused) in [1, 3, 12].iter().zip(REFUSED) {
        let expected = format!("odd.gen:{line}: {refused}\n");
        assert!(told.contains(&expected), "{told}");
    }
    for (path, is_written) in [("odd/srv/SetN.srv", true), ("odd/srv/F.srv", false)] {
        assert_eq!(directory.path().join(path).exists(), is_written, "{path}");
    }
}

#[test]
#[cfg(all(target_os = "linux", feature = "zenoh"))]
fn a_run_begins_with_the_parts_without_a_form() {
    let directory = Directory::new(&[("odd.gen", ODD)]);
    let endpoint = crate::network::endpoint();
    let words = ["run", "odd.gen", "--clock", "real", "--until", "1ms", "--socket", "s"];
    let ros2 = ["--simulate", "all", "--ros2", "--zenoh-listen", &endpoint];
    let output = directory.run(&[&words[..], &ros2].concat());
    let told = stderr(&output);
    assert_eq!(status(&output), 0, "{told}");
    for refused in REFUSED {
        assert!(told.contains(&format!("note: {refused}\n")), "{told}");
    }
}
