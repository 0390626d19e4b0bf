//! Tasks.

use super::*;

// test task
// component c {
//   task t;
//   task u { period 5 ms; priority 10; codel<start> f() yield ether; };
// };
pub(super) fn task(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(TASK_KW);
    property::unless_item(p, name);
    property::properties(p, "this task");
    semicolon(p, "this task");
    m.complete(p, TASK);
}
