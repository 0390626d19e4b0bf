"""Writes input ports of the component `reader`, which runs alone at a socket."""

import asyncio
import sys

import dotgen
import dotgen.aio


def refused(do, words):
    try:
        do()
    except dotgen.Wrong as error:
        assert words in str(error), error
    else:
        raise AssertionError(f"{words} was expected")


def synchronous(path):
    with dotgen.connect(path) as robot:
        reader = robot.load("reader")
        assert repr(reader).endswith("input ports trail, each>"), reader
        reader.trail.write([{"x": 1, "y": True}, {"x": 2}])
        expected = [{"x": 2.0, "y": 0.0}, {"x": 1.0, "y": 1.0}]
        assert next(seen for seen in reader.seen if seen) == expected
        reader.port("each").write(4.0, instance="a")
        assert next(total for total in reader.sum if total == 5)
        refused(lambda: reader.trail.write([{"x": "far"}]), "`[0].x` has to be a number")
        refused(lambda: reader.trail.write([{"x": float("nan")}]), "NaN")
        refused(lambda: reader.each.write(1), "`instance`")


async def asynchronous(path):
    async with dotgen.aio.connect(path) as robot:
        reader = robot.load("reader")
        await reader.each.write(40, "a")
        async for total in reader.sum:
            if total == 41:
                break
        await reader.port("trail").write([])
        async for seen in reader.seen:
            if not seen:
                break


synchronous(sys.argv[1])
asyncio.run(asynchronous(sys.argv[1]))
