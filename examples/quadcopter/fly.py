#!/usr/bin/env python3
"""Flies the simulated quadcopter to three points, and checks the true position at each.

    python3 examples/quadcopter/fly.py real       # one flight, on the clock of this machine
    python3 examples/quadcopter/fly.py virtual    # three flights, in simulated time

On the real clock, the script connects the ports and sends every request itself. On the virtual clock, a run
accepts no requests: the client of `flight.scn` sends them. A service has one input for the whole run there,
so each point has a flight of its own.

`--record FILE.mcap` and `--trace FILE.pftrace` keep the last flight, for Foxglove and Perfetto.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from typing import Any

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent / "clients" / "python"))
import dotgen  # noqa: E402

POINTS = [(1.0, 0.5, 1.2, 0.5), (-0.5, 1.0, 1.5, -0.5), (0.0, -1.0, 1.0, 0.0)]
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


def seconds(state: dict[str, Any]) -> float:
    """Returns the simulated time of a state."""
    return float(state["ts"]["sec"]) + float(state["ts"]["nsec"]) * 1e-9


def distance(state: dict[str, Any], x: float, y: float, z: float) -> float:
    """Returns the distance of a body from a point, in metres."""
    at = state["pos"]
    return math.dist((at["x"], at["y"], at["z"]), (x, y, z))


def check(name: str, errors: list[float]) -> None:
    """Prints the greatest error and asserts that it is small."""
    if not errors:
        raise SystemExit(f"{name}: no position was seen")
    print(f"{name}: at most {max(errors) * 100:.1f} cm away, {len(errors)} samples", flush=True)
    assert max(errors) < TOLERANCE, f"{name}: {max(errors) * 100:.1f} cm"


def real(options: list[str]) -> None:
    """One flight on the real clock, by requests."""
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

    began, simulated = time.monotonic(), seconds(body())
    reach(maneuver, body, "take-off", 0.0, 0.0, 1.0, 0.0)
    for number, point in enumerate(POINTS, 1):
        reach(maneuver, body, f"point {number}", *point)
    x, y, _, yaw = POINTS[-1]
    reach(maneuver, body, "landing", x, y, 0.01, yaw)
    mikrokopter.stop()
    simulated = seconds(body()) - simulated
    print(f"{simulated:.1f} s of flight in {time.monotonic() - began:.1f} s")


def reach(maneuver: Any, body: Any, name: str, x: float, y: float, z: float, yaw: float) -> None:
    """Goes to a point, settles for three seconds of simulated time, and checks the fourth."""
    maneuver.goto(x=x, y=y, z=z, yaw=yaw)
    there = seconds(body())
    errors = []
    while (now := body()) and seconds(now) < there + 4:
        if seconds(now) >= there + 3:
            errors.append(distance(now, x, y, z))
        time.sleep(0.02)
    check(name, errors)


def virtual(options: list[str], record: str | None) -> None:
    """A flight for each point on the virtual clock, by `flight.scn`."""
    for number, (x, y, z, yaw) in enumerate(POINTS, 1):
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            file = record or str(pathlib.Path(folder) / "flight.mcap")
            inputs = {
                "mikrokopter.connect": {"baud": 0},
                "maneuver.goto": {"x": x, "y": y, "z": z, "yaw": yaw},
                "maneuver.waypoint": {"x": x, "y": y, "z": 0.01, "yaw": yaw},
            }
            command = [program(), "run", str(HERE / "flight.scn"), "--bounds", "none", "--until", "14s"]
            for service, value in inputs.items():
                command += ["--input", f"{service}={json.dumps(value)}"]
            command += ["--record", file, *options]
            run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if run.returncode != 0:
                raise SystemExit(run.stdout)
            channels: dict[str, list[Any]] = {}
            for channel, value in messages(file):
                channels.setdefault(channel, []).append(value)
        bodies = channels["/simulator/body"]
        # Nothing is desired anew for four seconds at the point, until the landing begins.
        steps = [seconds(it) for it in channels["/maneuver/desired"]]
        leaves = next((after for before, after in zip(steps, steps[1:]) if after - before > 3), 0.0)
        errors = [distance(it, x, y, z) for it in bodies if leaves - 1 <= seconds(it) < leaves]
        check(f"point {number}", errors)
        check(f"point {number}, landing", [distance(it, x, y, 0.0) for it in bodies[-500:]])
        print(f"{seconds(bodies[-1]):.1f} s of flight in {time.monotonic() - began:.1f} s", flush=True)


def messages(file: str) -> Iterator[tuple[str, Any]]:
    """Yields the channels and values of a recording: MCAP with chunks that are not compressed."""
    channels: dict[int, str] = {}

    def records(data: memoryview) -> Iterator[tuple[str, Any]]:
        at = 0
        while at + 9 <= len(data):
            kind, size = struct.unpack_from("<BQ", data, at)
            record = data[at + 9 : at + 9 + size]
            at += 9 + size
            if kind == 4:  # Channel
                number, _, length = struct.unpack_from("<HHI", record)
                channels[number] = bytes(record[8 : 8 + length]).decode()
            elif kind == 5:  # Message
                channel = channels[struct.unpack_from("<H", record)[0]]
                if not channel.startswith("/dotgen/"):
                    yield channel, json.loads(bytes(record[22:]))
            elif kind == 6:  # Chunk
                (length,) = struct.unpack_from("<I", record, 28)
                (size,) = struct.unpack_from("<Q", record, 32 + length)
                yield from records(record[40 + length : 40 + length + size])

    yield from records(memoryview(pathlib.Path(file).read_bytes())[8:])


def main() -> None:
    parser = argparse.ArgumentParser(description="Fly the simulated quadcopter to three points and land.")
    parser.add_argument("clock", choices=["real", "virtual"], help="clock of the run")
    parser.add_argument("--record", metavar="FILE", help="keep a recording (.mcap) for Foxglove")
    parser.add_argument("--trace", metavar="FILE", help="keep a trace (.pftrace) for Perfetto")
    arguments = parser.parse_args()
    options = ["--trace", arguments.trace] if arguments.trace else []
    if arguments.clock == "virtual":
        virtual(options, arguments.record)
    else:
        real([*options, *(["--record", arguments.record] if arguments.record else [])])


if __name__ == "__main__":
    main()
