"""The command line on a terminal: the line that says how far a verification is, and Ctrl-C.

Run by ``cargo xtask test``. DOTGEN: the server program.
"""

import os
import pty
import re
import select
import time

import pytest

# Seconds after which a terminal that says nothing has failed.
PATIENCE = 60

# `blink` is answered by analysis; what any client can do to `mixer` is more than can be visited.
LAMP = """component lamp {
  version "1"; lang "c";
  ids { long light; };
  task blink { period 8 ms; codel<start> toggle(inout light) yield pause::start wcet 1 ms; };
};
"""
MIXER = """component mixer {
  version "1"; lang "c";
  ids { long level; };
  task u { period 7 ms; codel<start> w(inout level) yield pause::start wcet 1301 us; };
  ACTIVITIES
};
"""
ACTIVITY = """activity a%d() { task u;
    codel<start> s%d(inout level) yield pause::start, ether wcet %d us;
  };
  """
SCENARIO = """scenario endless {
  use "lamp.gen"; use "mixer.gen";
  client any { repeat * { delay [0,*] ms; choice CHOICES } }
  check schedulable lamp.blink;
  check within mixer.a0.run => mixer.a0.void <= 1 s;
}
"""


class Terminal:
    """A program on a terminal of its own."""

    def __init__(self, directory, *arguments):
        self.pid, self.end = pty.fork()
        if self.pid == 0:
            os.chdir(directory)
            os.environ["TERM"] = "xterm"
            os.execv(os.environ["DOTGEN"], ["dotgen", *arguments])
        self.text = ""

    def read(self, until=None):
        """What is shown, up to something; without that, up to the end."""
        latest = time.monotonic() + PATIENCE
        while until is None or not re.search(until, self.text):
            left = latest - time.monotonic()
            if left <= 0 or not select.select([self.end], [], [], left)[0]:
                pytest.fail(f"{until!r} was not shown: {self.text!r}")
            try:
                more = os.read(self.end, 65536)
            except OSError:  # Linux says so when the other end is closed.
                more = b""
            if not more and until is not None:
                pytest.fail(f"ended without {until!r}: {self.text!r}")
            if not more:
                break
            self.text += more.decode()
        return self.text

    def type(self, keys):
        os.write(self.end, keys)

    def status(self):
        _, status = os.waitpid(self.pid, 0)
        os.close(self.end)
        return os.waitstatus_to_exitcode(status)


@pytest.fixture
def endless(tmp_path):
    numbers = range(8)
    activities = "".join(ACTIVITY % (i, i, 1000 + 7 * i) for i in numbers)
    choices = " or ".join(f"{{ send mixer.a{i}; }}" for i in numbers)
    (tmp_path / "lamp.gen").write_text(LAMP)
    (tmp_path / "mixer.gen").write_text(MIXER.replace("ACTIVITIES", activities))
    (tmp_path / "endless.scn").write_text(SCENARIO.replace("CHOICES", choices))
    return tmp_path


def test_a_line_counts_answers_until_ctrl_c_ends_with_what_is_known(endless):
    terminal = Terminal(endless, "verify", "endless.scn")
    terminal.read(r"verifying endless: 1 of 2 checks answered, \d+ states, \d+ s, \d+ MB")
    # It is written over, not added to.
    terminal.read(r"\r\x1b\[2Kverifying endless.*\r\x1b\[2Kverifying endless")
    terminal.type(b"\x03")
    shown = terminal.read()
    assert terminal.status() == 3, shown
    line, result = shown.rsplit("\r\x1b[2K", 1)
    assert "lamp.blink" not in line, "the line is taken back before the answers come"
    result = re.sub(r"\x1b\[[\d;]*m", "", result)
    assert re.search(r"proved +schedulable +lamp\.blink", result), result
    assert re.search(r"gave up +within +mixer.*interrupted at \d+ states", result, re.DOTALL), result
    assert "1 proved, 1 gave up" in result


def test_where_time_is_up_the_answers_known_so_far_are_told(endless):
    terminal = Terminal(endless, "verify", "--timeout", "0.1", "endless.scn")
    shown = terminal.read()
    assert terminal.status() == 3, shown
    assert "1 proved" in shown and "gave up after 0.1 s" in shown
    assert "verifying" not in shown, "what is soon over has no line"
