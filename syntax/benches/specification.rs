//! The input of the benchmarks.

use std::fmt::Write;

/// Returns a specification with this many components of about 30 lines each.
pub(crate) fn specification(components: usize) -> String {
    let mut text = String::from("/* Licence and purpose. */\n#pragma require \"idl >= 1.0\"\n");
    for i in 0..components {
        let _ = write!(
            text,
            r#"
/* --- Component of one track ------------------------------------------ */
component track{i} {{
  version "1.{i}";
  lang    "c";
  email   "somebody@example.org"; // who to ask
  require "genom3 >= 2.99.4";
  exception e_speed {{ double limit; }};

  ids {{
    double     wheels[4];     /* measured speeds, in radians per second */
    sequence<double, 16> targets;
    octet      mode;
  }};
  port out state::pose pose;
  port in  state::speed speed {{ doc "What to follow."; }};
  task motion {{ period 10 ms; priority 100; stack 4000; }};

  attribute set_mode(in mode = 1 : "0 for stop, 1 for run") {{ validate check_mode(in mode); }};
  activity follow(in double x = 0.0 : "x in the base frame (m)", in double y = .5 : "y") {{
    doc "Follows a line of the base frame.";
    task motion;
    validate check(in x, in y);
    codel <start> begin(in x, in y, out targets) yield run, ether;
    codel <run>   advance(inout targets, port out pose) yield pause::run, stop;
    codel <stop>  halt(out targets) wcet 200 us yield ether;
    throw e_speed;
    interrupts follow;
  }};
}};
"#
        );
    }
    text
}
