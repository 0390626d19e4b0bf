"""Reads the recording of a flight (`dotgen run --record`), and measures it."""

from __future__ import annotations

import json
import math
import pathlib
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple, Tuple

Position = Tuple[float, float, float]

TARGETS = {  # m; the points of the tour are the defaults of `set_tour` in maneuver.gen
    "take-off": (0.0, 0.0, 1.0),
    "point 1": (1.0, 0.5, 1.2),
    "point 2": (-0.5, 1.0, 1.5),
    "point 3": (0.0, -1.0, 1.0),
    "landing": (0.0, -1.0, 0.01),
}
REST = 1.0  # s, the shortest time without a new desired position at a target
WINDOW = 0.5  # s, the end of a rest: there the position is checked


class Sample(NamedTuple):
    """A position in metres, and its simulated time in seconds."""

    time: float
    position: Position


class Rest(NamedTuple):
    """A desired position in metres, and the simulated times in seconds between which it stays."""

    begin: float
    end: float
    position: Position


class Flight:
    """The desired and the true positions of a flight."""

    def __init__(self, file: str | pathlib.Path) -> None:
        self.desired: list[Sample] = []
        self.true: list[Sample] = []
        channels = {"/maneuver/desired": self.desired, "/simulator/body": self.true}
        for channel, data in messages(file):
            if channel in channels:
                value = json.loads(data)
                if value["pos"]:
                    channels[channel].append(sample(value))

    def rests(self) -> list[Rest]:
        """Returns the desired positions that stay for a while."""
        ends = [it.time for it in self.desired[1:]] + [self.true[-1].time]
        pairs = zip(self.desired, ends)
        return [Rest(it.time, end, it.position) for it, end in pairs if end - it.time >= REST]

    def error(self, rest: Rest, target: Position) -> float:
        """Returns the greatest distance from a target at the end of a rest, in metres."""
        last = [it.position for it in self.true if rest.end - WINDOW <= it.time < rest.end]
        return max(math.dist(it, target) for it in last)


def sample(state: dict[str, Any]) -> Sample:
    """Returns the time and the position of a state."""
    at = state["pos"]
    return Sample(seconds(state), (at["x"], at["y"], at["z"]))


def seconds(state: dict[str, Any]) -> float:
    """Returns the simulated time of a state."""
    return float(state["ts"]["sec"]) + float(state["ts"]["nsec"]) * 1e-9


def messages(file: str | pathlib.Path) -> Iterator[tuple[str, bytes]]:
    """Yields the channels and data of a recording: MCAP with chunks that are not compressed."""
    channels: dict[int, str] = {}

    def records(data: memoryview) -> Iterator[tuple[str, bytes]]:
        at = 0
        while at + 9 <= len(data):
            kind, size = struct.unpack_from("<BQ", data, at)
            record = data[at + 9 : at + 9 + size]
            at += 9 + size
            if kind == 4:  # Channel
                number, _, length = struct.unpack_from("<HHI", record)
                channels[number] = bytes(record[8 : 8 + length]).decode()
            elif kind == 5:  # Message
                yield channels[struct.unpack_from("<H", record)[0]], bytes(record[22:])
            elif kind == 6:  # Chunk
                (length,) = struct.unpack_from("<I", record, 28)
                (size,) = struct.unpack_from("<Q", record, 32 + length)
                yield from records(record[40 + length : 40 + length + size])

    yield from records(memoryview(pathlib.Path(file).read_bytes())[8:])
