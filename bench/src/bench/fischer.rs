//! Mutual exclusion by time alone, after Fischer's protocol: for dotgen, and by hand for TChecker.
//!
//! Specifications have no values to test, so the shared variable of the protocol is played by what services
//! do to each other. Process *i* is a client that goes round like this:
//!
//! | protocol | here |
//! | --- | --- |
//! | wait until the variable is 0 | `ask`*i*, which needs the lock that every `hold` has |
//! | within some time | a delay of the client |
//! | set it to *i*, which overwrites | `hold`*i* and `claim`*i*; function `set`*i* interrupts the claims of the others |
//! | wait | `claim`*i*, codel `start`, of fixed length |
//! | go on if it is still *i* | an interrupted activity has no second turn |
//! | critical section | `claim`*i*, codel `cs` |
//! | set it to 0 | the end of `hold`*i*, after the longest critical section |
//!
//! Claims neither lock nor wait for each other: only the wait keeps them apart. As in the protocol, it must
//! be longer than the time between test and write.

use std::fmt::Write;

/// Durations of its steps, in ms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times {
    /// From test to write, maximum.
    pub(crate) within: u32,
    /// From write to critical section, exact.
    pub(crate) wait: u32,
    /// In the critical section, maximum.
    pub(crate) section: u32,
}

/// Specification and scenario of `n` processes.
pub(crate) fn dotgen(n: usize, times: Times) -> (String, String) {
    let Times { within, wait, section } = times;
    let mut genom = String::from(
        "component fischer {\n  version \"1.0\";\n  lang \"c\";\n  ids { long id; };\n",
    );
    let mut scenario = String::from(
        "scenario fischer {\n  use \"fischer.gen\"; semantics published;\n  unit 1 ms;\n  cores free;\n",
    );
    let hold = wait + section;
    for i in 1..=n {
        let others = (1..=n).filter(|&j| j != i).map(|j| format!("claim{j}"));
        let others = others.collect::<Vec<_>>().join(", ");
        let _ = writeln!(
            genom,
            "  task t{i} {{ }};
  task h{i} {{ }};
  activity ask{i}() {{
    task t{i};
    codel<start> test{i}(inout id) yield ether wcet 0 ms;
  }};
  activity hold{i}() {{
    task h{i};
    codel<start> hold{i}(in id) yield ether wcet {hold} ms;
  }};
  activity claim{i}() {{
    task t{i};
    codel<start> wait{i}() yield pause::cs wcet {wait} ms;
    codel<cs> cs{i}() yield ether wcet {section} ms;
  }};
  function set{i}() {{ interrupt {others}; }};"
        );
        let _ = writeln!(
            scenario,
            "  duration fischer.hold{i}.start [{hold}, {hold}] ms;
  duration fischer.claim{i}.start [{wait}, {wait}] ms;
  slots fischer.ask{i} 1;
  slots fischer.hold{i} 1;
  slots fischer.claim{i} 1;
  client p{i} {{
    repeat * {{
      delay [0, *] ms;
      send fischer.ask{i}; await ended;
      delay [0, {within}] ms;
      send fischer.hold{i}; send fischer.claim{i}; send fischer.set{i};
      await ended fischer.claim{i}; await ended fischer.hold{i};
    }}
  }}"
        );
    }
    genom.push_str("};\n");
    let pairs = (1..=n).flat_map(|i| {
        (1..i).map(move |j| format!("(fischer.claim{i}.cs.exec and fischer.claim{j}.cs.exec)"))
    });
    let pairs = pairs.collect::<Vec<_>>().join(" or ");
    let _ = writeln!(scenario, "  check always not ({pairs});\n}}");
    (genom, scenario)
}

/// The same behaviour as a network of one automaton per process, with one clock each. The label `both` is
/// reached if two processes are in their critical sections.
pub(crate) fn tchecker(n: usize, times: Times) -> String {
    let Times { within, wait, section } = times;
    let mut out =
        format!("system:fischer\nevent:tau\nint:1:0:{n}:0:holders\nint:1:0:{n}:0:inside\n");
    for i in 1..=n {
        // 1: has claimed; 2: was interrupted after that.
        let _ = writeln!(out, "int:1:0:2:0:claim{i}\nclock:1:x{i}");
    }
    let hold = wait + section;
    for i in 1..=n {
        let mut interrupt = Vec::new();
        for j in (1..=n).filter(|&j| j != i) {
            interrupt.push(format!("claim{j}=(if claim{j}==0 then 0 else 2)"));
        }
        let interrupt = interrupt.join(";");
        let _ = writeln!(
            out,
            "process:P{i}
location:P{i}:idle{{initial:}}
location:P{i}:write{{invariant:x{i}<={within}}}
location:P{i}:set{{urgent:}}
location:P{i}:wait{{invariant:x{i}<={wait}}}
location:P{i}:cs{{invariant:x{i}<={hold}}}
location:P{i}:both{{labels:both}}
location:P{i}:rest{{invariant:x{i}<={hold}}}
edge:P{i}:idle:write:tau{{provided:holders==0 : do:x{i}=0}}
edge:P{i}:write:set:tau{{do:x{i}=0;claim{i}=1;holders=holders+1}}
edge:P{i}:set:wait:tau{{do:{interrupt}}}
edge:P{i}:wait:rest:tau{{provided:x{i}=={wait}&&claim{i}==2 : do:claim{i}=0}}
edge:P{i}:wait:cs:tau{{provided:x{i}=={wait}&&claim{i}==1&&inside==0 : do:inside=1}}
edge:P{i}:wait:both:tau{{provided:x{i}=={wait}&&claim{i}==1&&inside==1}}
edge:P{i}:cs:rest:tau{{do:claim{i}=0;inside=0}}
edge:P{i}:rest:idle:tau{{provided:x{i}=={hold} : do:holders=holders-1}}"
        );
    }
    out
}
