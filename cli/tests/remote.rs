//! Codels that call services of other components.
#![cfg(target_os = "linux")]

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{Listening, compilers, ended};

const ADDER: &str = "#pragma once
module sums { struct pair { long one; double other; }; enum kind { FEW, MANY }; };
interface adder {
  function add(in sums::pair both, in string<8> name, in string text, in long list[2],
               inout sums::kind kind, out string said, out double sum);
  activity fail();
};
";

const ADDS: &str = "#include \"adder.gen\"
component adds {
  version \"1\"; lang \"LANG\"; provides adder;
  exception never;
  task main { period 5 ms; };
  function add(in sums::pair both, in string<8> name, in string text, in long list[2],
               inout sums::kind kind, out string said, out double sum) {
    codel adds_add(in both, in name, in text, in list, inout kind, out said, out sum);
  };
  activity fail() { task main; codel<start> adds_fail() yield ether; throw never; };
};
";

const ASKS: &str = "#include \"adder.gen\"
component asks {
  version \"1\"; lang \"LANG\"; uses adder;
  struct outcome { double sum; string<64> said; sums::kind kind; long error; };
  ids { long n; };
  port out outcome answer;
  task main { period 10 ms;
    codel<start> ask_sum(inout n, remote in add, port out answer) yield second;
    codel<second> ask_fail(remote in fail, port out answer) yield pause::start; };
};
";

const ADDS_C: &str = "#include \"acadds.h\"
#include <stdlib.h>
#include <string.h>
#include \"adds_c_types.h\"
genom_event adds_add(const sums_pair *both, const char name[8], const char *text, const int32_t list[2],
                     sums_kind *kind, char **said, double *sum, const genom_context self) {
  *said = malloc(100);
  **said = 0;
  strncat(*said, name, 8);
  strcat(*said, text);
  *sum = both->one + both->other + list[0] + list[1];
  *kind = *kind == sums_FEW ? sums_MANY : sums_FEW;
  return genom_ok;
}
genom_event adds_fail(const genom_context self) { return adds_never(self); }
";

const ASKS_C: &str = "#include \"acasks.h\"
#include <string.h>
#include \"asks_c_types.h\"
genom_event ask_sum(int32_t *n, const asks_add *add, const asks_answer *answer, const genom_context self) {
  sums_pair both = { ++*n, .5 };
  int32_t list[2] = { 10, 20 };
  sums_kind kind = sums_FEW;
  char *said = NULL;
  double sum = -1;
  asks_outcome *data = answer->data(self);
  genom_event event = add->call(&both, \"eight678\", \"and so\", list, &kind, &said, &sum, self);
  data->error = 0;
  if (event == genom_ok) {
    strcpy(data->said, said);
    data->sum = sum - *n;
    data->kind = kind;
  } else
    data->error = ((genom_syserr_detail *)self->raised(NULL, (genom_context)self))->code;
  return asks_second;
}
genom_event ask_fail(const asks_fail *fail, const asks_answer *answer, const genom_context self) {
  asks_outcome *data = answer->data(self);
  if (fail->call(self) != genom_ok && data->error == 0)
    data->error = ((genom_syserr_detail *)self->raised(NULL, (genom_context)self))->code;
  answer->write(self);
  return asks_pause_start;
}
";

const ASKS_CC: &str = "#include \"acasks.h\"
#include <string.h>
#include \"asks_cxx_types.h\"
genom::event ask_sum(int32_t &n, asks::add &add, asks::answer &answer) {
  sums::pair both = { ++n, .5 };
  int32_t list[2] = { 10, 20 };
  sums::kind kind = sums::FEW;
  std::string said;
  double sum = -1;
  asks::outcome &data = answer.data();
  data.error = 0;
  try {
    add.call(both, \"eight678\", \"and so\", list, kind, said, sum);
    strcpy(data.said, said.c_str());
    data.sum = sum - n;
    data.kind = kind;
  } catch (genom::syserr &e) { data.error = e.detail.code; }
  return asks::second;
}
genom::event ask_fail(asks::fail &fail, asks::answer &answer) {
  try { fail.call(); } catch (genom::syserr &e) { answer.data().error += e.detail.code; }
  answer.write();
  return asks::pause::start;
}
";

/// What the codels that ask have written, twice.
fn answers(directory: &Directory) -> String {
    let arguments = ["run", "a/adds.gen", "b/asks.gen", "--clock", "real", "--socket", "s"];
    let mut run = Listening::start(directory, &arguments);
    let watched = directory.run(&["watch", "--socket", "s", "asks/answer", "-n", "2"]);
    assert_eq!(status(&watched), 0, "{}", stderr(&watched));
    run.signal("-TERM");
    ended(&mut run.0);
    stdout(&watched)
}

#[test]
fn a_codel_calls_a_service_of_another_component() {
    if !compilers() {
        return;
    }
    let directory = Directory::new(&[
        ("a/adder.gen", ADDER),
        ("a/adds.gen", &ADDS.replace("LANG", "c")),
        ("a/codels/adds.c", ADDS_C),
        ("b/adder.gen", ADDER),
        ("b/asks.gen", &ASKS.replace("LANG", "c")),
        ("b/codels/asks.c", ASKS_C),
    ]);
    let line = r#"{"sum":30.5,"said":"eight678and so","kind":"MANY","error":5}"#;
    assert_eq!(answers(&directory), format!("{line}\n{line}\n"));
    // Of another language.
    std::fs::remove_file(directory.path().join("b/codels/asks.c")).expect("it is there");
    directory.write("b/asks.gen", ASKS.replace("LANG", "c++").as_bytes());
    directory.write("b/codels/asks.cc", ASKS_CC.as_bytes());
    assert_eq!(answers(&directory), format!("{line}\n{line}\n"));
    // Nobody provides it in this run.
    let mut run =
        Listening::start(&directory, &["run", "b/asks.gen", "--clock", "real", "--socket", "s"]);
    let watched = directory.run(&["watch", "--socket", "s", "asks/answer", "-n", "1"]);
    let line = r#"{"sum":0.0,"said":"","kind":"FEW","error":76}"#;
    assert_eq!(stdout(&watched), format!("{line}\n"), "twice ENOSYS");
    run.signal("-TERM");
    ended(&mut run.0);
    // On the virtual clock nobody can answer in time.
    let output = directory.run(&["run", "a/adds.gen", "b/asks.gen", "--until", "100ms"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
}
