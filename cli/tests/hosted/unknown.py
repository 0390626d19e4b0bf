"""Talks to a simulated component whose types are in a package that is missing."""

import asyncio
import sys

import dotgen
import dotgen.aio
from dotgen import genomix


def main(path):
    with dotgen.connect(path) as robot:
        unknown = robot.load("unknown")
        unknown.set_state({"pos": {"x": (1, 2)}, "anything": None})
        unknown.set_state(state=[1, "two", {"three": 3.0}])
        unknown.set_states([{"x": 1}, {"x": 2}])
        unknown.get_state(), unknown.estimate()
        going = unknown.go({"x": 1}, 3, ack=True)
        assert repr(going) == "<Activity unknown.go: running>", going
        going.abort()
        try:
            going.wait(10)
        except dotgen.Failed as error:
            # The activity was interrupted before its first codel.
            assert error.exception == "::genom::interrupted" == str(going.exception)
            assert repr(going) == "<Activity unknown.go: failed ::genom::interrupted>", going
        assert repr(unknown.go) == "<Service unknown.go(goal, steps)>"

    component = genomix.connect(path).load("unknown")
    component.set_debug(1)
    component.set_debug(debug=0)
    component.set_state({"x": 1})
    component.go(goal={"x": 1}, steps=3.0, send=True, ack=True).abort()
    try:
        component.measure
    except AttributeError as error:
        assert "`unknown/measure` is an input port" in str(error), error
    else:
        raise AssertionError("an input port cannot be written")

    async def over_asyncio():
        async with dotgen.aio.connect(path) as robot:
            going = await robot.load("unknown").go({"x": 1}, ack=True)
            await going.abort()
            assert [status async for status in going][-1] in ("done", "failed")

    asyncio.run(over_asyncio())


main(sys.argv[1])
