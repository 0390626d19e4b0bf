//! Scripts of genomix, GenoM's own client in Python, against a run.

use std::path::Path;
use std::process::Command;

use crate::directory::Directory;
use crate::running::{Listening, compilers, ended, installed};

/// As public scripts are: interactive functions, dictionaries by name, `connect_port`, `ack`.
const SCRIPT: &str = "import genomix
import os

g = genomix.connect()
g.rpath(os.environ['HOME'] + '/openrobots/lib/genom/pocolibs/plugins')
gives = g.load('gives')
takes = g.load('/opt/openrobots/lib/genom/pocolibs/plugins/takes.so')

def setup():
  gives.set_step({'step': {'by': 3, 'way': '::gives::UP'}})
  takes.connect_port({'local': 'heard', 'remote': 'gives/number'})
  takes.connect_port({'local': 'many/left', 'remote': 'gives/sides/a'})

def start():
  following = gives.follow({'rounds': 4}, ack=True)
  assert following.wait() == {'seen': 4}
  endless = gives.follow(1000000, ack=True)
  assert endless.status == genomix.Status.sent
  endless.abort()
  while endless.status == genomix.Status.sent: genomix.update()

def failed(inputs, exception):
  try:
    takes.connect_port(inputs)
  except genomix.event.GenoMError as it:
    assert it.exception == exception and exception in str(it), it
  else:
    raise AssertionError(inputs)

setup()
start()
while takes.last()['last'] == 0: pass
assert takes.last()['last'] % 3 == 0
while takes.left()['left'] != 7: pass
while gives.number()['number'] is None: pass
assert gives.sides('a')['sides'] == 7
step = gives.get_step()
assert step == {'step': {'by': 3, 'way': 'UP'}}
gives.set_step(step)
failed({'local': 'heart', 'remote': 'gives/number'}, '::genom::no_such_inport')
failed({'local': 'heard', 'remote': 'gives/nobody'}, '::genom::no_such_outport')
failed({'local': 'heard', 'remote': 'gives/sides'}, '::genom::no_such_outport')
failed({'local': 'heard', 'remote': 'gives/sides/a'}, '::genom::port_io')
";

#[test]
fn scripts_of_genomix_run_with_another_import() {
    if !installed(&["python3"]) || !compilers() {
        return;
    }
    let directory = Directory::new(&[
        (
            "gives/gives.gen",
            "component gives { version \"1\"; lang \"c\"; enum way { DOWN, UP };
               struct pace { long by; way way; };
               ids { pace step; long n; };
               typedef long count; typedef double side;
               port out count number; port multiple out side sides;
               attribute set_step(in step); attribute get_step(out step);
               task main { period 2 ms;
                 codel<start> give_first(port out sides) yield pause::go;
                 codel<go> give_on(in step, inout n, port out number, port out sides) yield pause::go; };
               activity follow(in long rounds, out long seen) { task main;
                 codel<start> gives_follow(in rounds, inout seen) yield pause::start, ether; }; };\n",
        ),
        (
            "gives/codels/gives.c",
            "#include \"acgives.h\"
#include \"gives_c_types.h\"
genom_event give_first(const gives_sides *sides, const genom_context self) {
  sides->open(\"a\", self);
  return gives_pause_go;
}
genom_event give_on(const gives_pace *step, int32_t *n, const gives_number *number,
                    const gives_sides *sides, const genom_context self) {
  *n += step->way == gives_UP ? step->by : -step->by;
  *number->data(self) = *n;
  number->write(self);
  *sides->data(\"a\", self) = 7.;
  sides->write(\"a\", self);
  return gives_pause_go;
}
genom_event gives_follow(int32_t rounds, int32_t *seen, const genom_context self) {
  return ++*seen < rounds ? gives_pause_start : gives_ether;
}
",
        ),
        (
            "takes/takes.gen",
            "component takes { version \"1\"; lang \"c\"; ids { long last; double left; };
               typedef long count; typedef double side;
               port in count heard; port multiple in side many;
               attribute last(out last); attribute left(out left);
               task main { period 2 ms;
                 codel<start> takes_go(out last, out left, port in heard, port in many) yield pause::start; }; };\n",
        ),
        (
            "takes/codels/takes.c",
            "#include \"actakes.h\"
#include \"takes_c_types.h\"
genom_event takes_go(int32_t *last, double *left, const takes_heard *heard, const takes_many *many,
                     const genom_context self) {
  heard->read(self);
  if (heard->data(self)) *last = *heard->data(self);
  many->read(\"left\", self);
  if (many->data(\"left\", self)) *left = *many->data(\"left\", self);
  return takes_pause_start;
}
",
        ),
        ("script.py", SCRIPT),
        // Changed in nothing else.
        ("changed.py", &SCRIPT.replace("import genomix", "import dotgen.genomix as genomix")),
    ]);
    std::fs::create_dir(directory.path().join("own")).expect("a directory");
    let mut command = directory.command(&["run", "gives/gives.gen", "takes/takes.gen"]);
    let runtime = directory.path().join("own");
    command.args(["--clock", "real", "--bounds", "none"]);
    command.env("XDG_RUNTIME_DIR", &runtime);
    let mut run = Listening::begin(&mut command);
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    for arguments in [&["changed.py"][..], &["-m", "dotgen.genomix", "script.py"]] {
        let mut script = Command::new("python3");
        script.args(arguments).current_dir(directory.path());
        script.env("PYTHONPATH", here.join("../clients/python"));
        script.env("PYTHONDONTWRITEBYTECODE", "1");
        script.env("XDG_RUNTIME_DIR", &runtime);
        let mut script = script.stderr(std::process::Stdio::piped()).spawn().expect("it runs");
        let status = ended(&mut script);
        let mut said = String::new();
        let mut errors = script.stderr.take().expect("a pipe");
        std::io::Read::read_to_string(&mut errors, &mut said).expect("text");
        assert!(status.success(), "{arguments:?}: {said}");
    }
    run.signal("-TERM");
    ended(&mut run.0);
}
