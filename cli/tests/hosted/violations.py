"""Reads the violations of a run in which a codel of `drive` is late each time, while the run goes on."""

import asyncio
import sys

import dotgen
import dotgen.aio


def check(found):
    assert found["codel"] == "drive.go.start" and found["took"] > found["limit"], found
    assert found["unit"] and found["what"].startswith("the execution time of drive.go.start"), found


def overruns(violations):
    return (found for found in violations if found["kind"] == "overrun")


def main(path):
    with dotgen.connect(path) as robot:
        violations = overruns(robot.violations())
        first = next(violations)
        check(first)
        again = next(violations)
        check(again)
        assert again["times"] > first["times"], (first, again)
        violations.close()
        # A later reader gets those so far.
        later = next(overruns(robot.violations()))
        assert later["times"] >= again["times"], later
    asyncio.run(asynchronous(path))


async def asynchronous(path):
    async with dotgen.aio.connect(path) as robot:
        async for found in robot.violations():
            if found["kind"] == "overrun":
                check(found)
                break


if __name__ == "__main__":
    main(sys.argv[1])
