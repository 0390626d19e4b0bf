#!/usr/bin/env python3
"""Draws a recorded flight as SVG: the path from above, and the height over time.

    python3 examples/quadcopter/plot.py flight.mcap -o flight.svg
"""

from __future__ import annotations

import argparse
import pathlib
from collections.abc import Callable, Iterable

from recording import TARGETS, Flight, Rest, Sample

WIDTH, HEIGHT = 880, 340
DESIRED, TRUE, GREY = "#f2a65a", "#0072b2", "#777777"
WIDE, NARROW = 'stroke-width="6"', 'stroke-width="1.5"'
Place = Callable[[float, float], tuple[float, float]]


def line(points: Iterable[tuple[float, float]], colour: str, more: str) -> str:
    """Returns a line through points."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{places}" fill="none" stroke="{colour}" {more}/>'


def text(x: float, y: float, words: str, anchor: str = "middle", colour: str = GREY) -> str:
    """Returns a text at a place."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{words}</text>'


def axes(place: Place, across: list[float], up: list[float], names: tuple[str, str]) -> list[str]:
    """Returns grid lines with their values, and the names of both axes."""
    out = []
    (left, bottom), (right, top) = place(across[0], up[0]), place(across[-1], up[-1])
    for value in across:
        x = place(value, 0)[0]
        out += [line([(x, bottom), (x, top)], GREY, 'stroke-opacity="0.3"')]
        out += [text(x, bottom + 16, f"{value:g}")]
    for value in up:
        y = place(0, value)[1]
        out += [line([(left, y), (right, y)], GREY, 'stroke-opacity="0.3"')]
        out += [text(left - 6, y + 4, f"{value:g}", "end")]
    out += [text((left + right) / 2, bottom + 34, names[0]), text(left, top - 8, names[1], "start")]
    return out


def thinned(samples: list[Sample], step: float) -> list[Sample]:
    """Returns samples with at least this time between them, and the last one."""
    out: list[Sample] = []
    for sample in samples:
        if not out or sample.time - out[-1].time >= step:
            out.append(sample)
    return [*out, *samples[-1:]]


def above(rests: list[Rest], desired: list[Sample], true: list[Sample]) -> list[str]:
    """Returns the path from above, with the targets."""
    def place(x: float, y: float) -> tuple[float, float]:
        return 50 + (x + 1) * 110, 290 - (y + 1.1) * 110

    out = axes(place, [-1, -0.5, 0, 0.5, 1, 1.5], [-1, -0.5, 0, 0.5, 1], ("east (m)", "north (m)"))
    for samples, colour, more in [(desired, DESIRED, WIDE), (true, TRUE, NARROW)]:
        out.append(line([place(*it.position[:2]) for it in samples], colour, more))
    for name, rest in zip(TARGETS, rests):
        x, y, _ = rest.position
        if name != "landing":
            at = place(x, y)
            out.append(f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="4" fill="{TRUE}"/>')
            side, anchor = (-10, "end") if x < 0 else (10, "start")
            out.append(text(at[0] + side, at[1] + (16 if y > -1 else -8), name, anchor, TRUE))
    return out


def heights(flight: Flight, desired: list[Sample], true: list[Sample]) -> list[str]:
    """Returns the heights over time, with the error at each target."""
    def place(time: float, z: float) -> tuple[float, float]:
        return 440 + time * 14, 265 - z * 125

    ticks = [float(it) for it in range(0, int(true[-1].time) + 5, 5)]
    out = axes(place, ticks, [0, 0.5, 1, 1.5], ("simulated time (s)", "height (m)"))
    for samples, colour, more in [(desired, DESIRED, WIDE), (true, TRUE, NARROW)]:
        out.append(line([place(it.time, it.position[2]) for it in samples], colour, more))
    for name, rest in zip(TARGETS, flight.rests()):
        error = flight.error(rest, rest.position) * 100
        x, y = place((rest.begin + rest.end) / 2, rest.position[2])
        out += [text(x, y - 22, name, colour=TRUE), text(x, y - 8, f"{error:.1f} cm", colour=TRUE)]
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description="Draw a recorded flight.")
    parser.add_argument("recording", help="recording of a flight (.mcap)")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="picture (.svg)")
    arguments = parser.parse_args()

    flight = Flight(arguments.recording)
    desired, true = thinned(flight.desired, 0.1), thinned(flight.true, 0.1)
    legend = [
        line([(600, 14), (630, 14)], TRUE, NARROW), text(636, 18, "true", "start"),
        line([(690, 14), (720, 14)], DESIRED, WIDE), text(726, 18, "desired", "start"),
    ]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
    head += f'height="{HEIGHT}" font-family="sans-serif" font-size="12">'
    ground = '<rect width="100%" height="100%" fill="white"/>'
    drawn = [*above(flight.rests(), desired, true), *heights(flight, desired, true)]
    parts = [head, ground, *drawn, *legend, "</svg>", ""]
    pathlib.Path(arguments.output).write_text("\n".join(parts))


if __name__ == "__main__":
    main()
