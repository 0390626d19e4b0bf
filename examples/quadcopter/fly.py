#!/usr/bin/env python3
"""Flies the simulated quadcopter to three points and lands, and checks the true position at each point.

    python3 examples/quadcopter/fly.py virtual              # in simulated time
    python3 examples/quadcopter/fly.py real                 # on the clock of this machine
    python3 examples/quadcopter/fly.py check flight.mcap    # checks the recording of a flight

On the virtual clock, the client of `flight.scn` sends all requests. On the real clock, this script connects
the ports and sends them. `--record FILE.mcap`, `--trace FILE.pftrace` and `--profile FILE` keep the flight.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Any

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent / "clients" / "python"))
import dotgen  # noqa: E402

from recording import TARGETS, Flight, seconds  # noqa: E402

TOLERANCE = 0.05  # m

COMPONENTS = ["maneuver", "mikrokopter", "nhfc", "optitrack", "pom", "simulator"]
CONNECTIONS = {
    "maneuver.state": "pom/state",
    "nhfc.state": "pom/state",
    "nhfc.desired": "maneuver/desired",
    "nhfc.actual_velocity": "mikrokopter/actual_velocity",
    "mikrokopter.cmd_velocity": "nhfc/cmd_velocity",
    "pom.imu": "mikrokopter/imu",
    "pom.pose": "optitrack/mocap_pose",
    "optitrack.cameras": "simulator/body",
    "mikrokopter.line_velocity": "simulator/turning",
    "mikrokopter.line_inertia": "simulator/inertia",
    "simulator.command": "mikrokopter/line_command",
}


def program() -> str:
    """The program: that of the variable DOTGEN, the installed one, or the one that cargo built."""
    built = [HERE.parent.parent / "target" / it / "dotgen" for it in ("release", "debug")]
    found = os.environ.get("DOTGEN") or shutil.which("dotgen")
    found = found or next((str(it) for it in built if it.exists()), None)
    if found is None:
        raise SystemExit("dotgen is not installed: see README.md")
    return found


def check(file: str) -> None:
    """Prints the error at each target of a recorded flight, and fails if one is missing or too large."""
    flight = Flight(file)
    rests = flight.rests()
    if len(rests) != len(TARGETS):
        raise SystemExit(f"{len(rests)} rests instead of {len(TARGETS)}: the flight is not complete")
    far = []
    for (name, target), rest in zip(TARGETS.items(), rests):
        error = flight.error(rest, target)
        print(f"{name}: {error * 100:.1f} cm from {target}", flush=True)
        if error >= TOLERANCE:
            far.append(name)
    if far:
        raise SystemExit(f"{TOLERANCE * 100:.0f} cm or more: {', '.join(far)}")


def virtual(options: list[str]) -> None:
    """A flight on the virtual clock, by the client of `flight.scn`."""
    command = [program(), "run", str(HERE / "flight.scn"), "--until", "27s", *options]
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if run.returncode != 0:
        raise SystemExit(run.stdout)


def real(options: list[str]) -> None:
    """A flight on the real clock, by requests."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "s"
        files = [str(HERE / f"{it}.gen") for it in COMPONENTS]
        command = [program(), "run", *files, "--clock", "real", "--bounds", "none", "--socket", str(path)]
        with open(pathlib.Path(folder) / "log", "w+") as log:
            run = subprocess.Popen([*command, *options], stdout=log, stderr=log)
            try:
                while not path.exists() and run.poll() is None:
                    time.sleep(0.1)
                if run.poll() is not None:
                    log.seek(0)
                    raise SystemExit(log.read())
                with dotgen.connect(path) as robot:
                    mission(robot)
            finally:
                run.terminate()
                run.wait()


def mission(robot: dotgen.Connection) -> None:
    """Connects the ports, takes off, goes to the points and lands."""
    loaded = {it: robot.load(it) for it in COMPONENTS}
    for port, writer in CONNECTIONS.items():
        component, local = port.split(".")
        loaded[component].connect_port(local=local, remote=writer)
    maneuver, mikrokopter, nhfc = loaded["maneuver"], loaded["mikrokopter"], loaded["nhfc"]
    body, state = loaded["simulator"].body, loaded["pom"].state

    loaded["optitrack"].connect()
    mikrokopter.connect()
    while not (state() or {}).get("pos"):
        time.sleep(0.01)
    mikrokopter.start()
    nhfc.servo(ack=True)
    mikrokopter.servo(ack=True)

    maneuver.set_tour()
    for move in [maneuver.goto, maneuver.next, maneuver.next, maneuver.next, maneuver.land]:
        move()
        there = seconds(body())
        while seconds(body()) < there + 2:
            time.sleep(0.02)
    mikrokopter.stop()


def main() -> None:
    parser = argparse.ArgumentParser(description="Fly the simulated quadcopter to three points and land.")
    commands = parser.add_subparsers(dest="command", required=True)
    for clock in ["virtual", "real"]:
        command = commands.add_parser(clock, help=f"fly on the {clock} clock")
        command.add_argument("--record", metavar="FILE", help="keep the recording (.mcap), also for Foxglove")
        command.add_argument("--trace", metavar="FILE", help="keep a trace (.pftrace) for Perfetto")
        command.add_argument("--profile", metavar="FILE", help="keep a log of all codels")
    commands.add_parser("check", help="check a recording").add_argument("record", metavar="FILE")
    arguments = parser.parse_args()
    if arguments.command == "check":
        return check(arguments.record)

    with tempfile.TemporaryDirectory() as folder:
        record = arguments.record or str(pathlib.Path(folder) / "flight.mcap")
        options = ["--record", record]
        for name in ["trace", "profile"]:
            if getattr(arguments, name):
                options += [f"--{name}", getattr(arguments, name)]
        began = time.monotonic()
        (virtual if arguments.command == "virtual" else real)(options)
        took = time.monotonic() - began
        check(record)
    print(f"the run took {took:.0f} s")


if __name__ == "__main__":
    main()
