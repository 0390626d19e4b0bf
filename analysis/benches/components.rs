//! The input of the workspace benchmarks: components of 700 lines that share an interface.

use std::fmt::Write as _;

/// Activities of a component, of 19 lines each: about 700 lines and 25 KB, as in the largest published
/// specifications.
const ACTIVITIES: usize = 36;

/// The file `types.idl` that each component includes.
pub(crate) const TYPES: &str = "#ifndef TYPES\n#define TYPES
module geo {
  struct vec { double x, y, z; };
  struct pose { vec at; vec speed; unsigned long long time; };
  exception lost { string<64> why; };
};
interface tracker { port out geo::pose target; function reset(in geo::vec at); };
#endif\n";

/// Component number `i`.
pub(crate) fn component(i: usize) -> String {
    let mut out = format!(
        "#include \"types.idl\"
component c{i} {{
  version \"1.0\"; lang \"c\"; doc \"Component number {i}.\";
  provides tracker;
  ids {{ geo::pose current; geo::pose goal; sequence<geo::vec, 16> path; }};
  task fast {{ period 1 ms; codel<start> c{i}_init(ids out current) yield main;
    codel<main> c{i}_loop(ids in current, port out target) yield pause::main, stop;
    codel<stop> c{i}_end() yield ether; }};
  task slow {{ period 100 ms; }};
  attribute set_goal(in goal.at = {{ 0., 0., 0. }} : \"where to go\");
"
    );
    for a in 0..ACTIVITIES {
        write!(
            out,
            "
  /** Goes somewhere.
   *
   * And stops there. */
  activity go{a}(
    in geo::vec to,
    in double speed = {a}.5 : \"in m/s\")
  {{
    doc \"Goes somewhere.\";
    task slow;
    throws geo::lost;
    local geo::vec tmp;
    validate c{i}_check{a}(in to, in speed);
    codel<start> c{i}_begin{a}(in to, local out tmp, ids out goal.at)
      yield step, ether;
    codel<step> c{i}_step{a}(in tmp, in speed, ids in current.at)
      yield pause::step, ether;
    interrupts go{a};
  }};
"
        )
        .ok();
    }
    out + "};\n"
}
