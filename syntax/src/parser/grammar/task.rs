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
    // `task ids { period 1; };` is a task called `ids`.
    if p.at(IDS_KW) && p.nth_at(1, L_CURLY) && property::at_body(p, 2) {
        name(p);
    } else {
        property::unless_item(p, name);
    }
    property::properties(p, "this task");
    semicolon(p, "this task");
    m.complete(p, TASK);
}
