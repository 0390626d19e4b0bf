//! Workspaces of any size: components of about a thousand lines that share one interface file.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;

/// Activities of a component, of 19 lines each.
const ACTIVITIES: usize = 52;
/// Types of the shared file that few components use, in addition to those that all use.
const TYPES: usize = 20;

/// Name of the shared file.
pub(in crate::bench) const SHARED: &str = "types.idl";
/// Text before the name of a type that every component uses, at its declaration.
pub(in crate::bench) const USED_BY_ALL: &str = "  struct vec";

/// Writes `count` components and their shared file.
pub(in crate::bench) fn write(folder: &Path, count: usize) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join(SHARED), shared())?;
    for i in 0..count {
        std::fs::write(folder.join(name(i)), component(i))?;
    }
    Ok(())
}

/// Writes `count` independent files of one line.
pub(in crate::bench) fn write_tiny(folder: &Path, count: usize) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    for i in 0..count {
        let text =
            format!("component t{i} {{ version \"1.0\"; lang \"c\"; ids {{ long v; }}; }};\n");
        std::fs::write(folder.join(format!("t{i:05}.gen")), text)?;
    }
    Ok(())
}

/// Name of the file of a component.
pub(in crate::bench) fn name(i: usize) -> String {
    format!("c{i:04}.gen")
}

/// The file that each component includes.
pub(in crate::bench) fn shared() -> String {
    let mut out = String::from(
        "#ifndef TYPES\n#define TYPES
// What all components share.
#define SIZE 16
module geo {
  struct vec { double x, y, z; };
  struct pose { vec at; vec speed; unsigned long long time; };
  enum frame { body, world, camera };
  exception lost { string<64> why; };
",
    );
    for i in 0..TYPES {
        let _ = write!(
            out,
            "
  /** Reading number {i}. */
  struct reading{i} {{
    unsigned long stamp;
    frame in_frame;
    sequence<vec, SIZE> points;
    double covariance[6];
  }};
"
        );
    }
    out + "};
interface tracker {
  port out geo::pose target;
  function reset(in geo::vec at);
};
#endif
"
}

/// A component of about a thousand lines.
pub(in crate::bench) fn component(i: usize) -> String {
    let mut out = format!(
        "#include \"{SHARED}\"
component c{i} {{
  version \"1.0\"; lang \"c\"; doc \"Component number {i}.\";
  provides tracker;
  ids {{ geo::pose current; geo::pose goal; sequence<geo::vec, SIZE> path; }};
  port in geo::reading{} sensed;
  task fast {{ period 1 ms; codel<start> c{i}_init(ids out current) yield main;
    codel<main> c{i}_loop(ids in current, port in sensed, port out target) yield pause::main, stop;
    codel<stop> c{i}_end() yield ether; }};
  task slow {{ period 100 ms; }};
  attribute set_goal(in goal.at = {{ 0., 0., 0. }} : \"where to go\");
",
        i % TYPES
    );
    for a in 0..ACTIVITIES {
        let _ = write!(
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
        );
    }
    out + "};\n"
}
