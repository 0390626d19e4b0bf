"""Uses all interfaces of the Python client: `dotgen`, `dotgen.genomix` and `dotgen.aio`.

Talks to the components of this folder, which run at a socket.
"""

import asyncio
import contextlib
import enum
import inspect
import io
import math
import sys
import threading
import time

import dotgen
import dotgen.aio
from dotgen import genomix


def raises(kind, do, text=""):
    try:
        do()
    except kind as error:
        assert text in str(error), error
        return error
    raise AssertionError(f"{kind.__name__} was expected")


def until(true):
    end = time.monotonic() + 20
    while not true():
        assert time.monotonic() < end, "nothing came"
        time.sleep(0.005)


class Colour(enum.Enum):
    BLUE = 7


class Array:
    """A stand-in for an array or a number of numpy."""

    def __init__(self, value):
        self.value = value

    def tolist(self):
        return self.value


def values(echo):
    back = echo.mirror(
        {
            "b": 1,
            "o": True,
            "s": 3.0,
            "f": 1,
            "c": Colour.BLUE,
            "grid": Array([[{"x": 1}] * 2] * 2),
            "few": ({"x": Array(2)}, {"y": 3}),
            "maybe": {"x": True, "y": 1.5},
            "bits": (0, 1, True),
            "deep": [b"\x01\x02"],
            "kind": {"_d": "::m::GREEN", "centre": {"x": 3}},
        }
    )
    assert back["b"] is True and back["o"] == 1 and back["s"] == 3 and back["f"] == 1.0, back
    assert back["c"] == "BLUE" and back["grid"][1][1] == {"x": 1.0, "y": 0.0}, back
    assert back["few"] == [{"x": 2.0, "y": 0.0}, {"x": 0.0, "y": 3.0}], back
    assert back["maybe"] == {"x": 1.0, "y": 1.5}, back
    assert back["bits"] == [False, True, True] and back["deep"] == [[1, 2]], back
    assert back["kind"] == {"_d": "GREEN", "centre": {"x": 3.0, "y": 0.0}}, back
    assert echo.mirror({"c": "::m::GREEN"})["c"] == "GREEN"
    assert echo.mirror({"c": 2})["c"] == "BLUE"
    raises(dotgen.Wrong, lambda: echo.mirror({"b": 2}), "true or false")
    for number in (math.nan, math.inf):
        raises(dotgen.Wrong, lambda: echo.mirror({"maybe": {"x": number}}), "NaN and infinity")
    raises(dotgen.Wrong, lambda: echo.mirror({"text": object()}))
    raises(dotgen.Wrong, lambda: echo.count(n=0.5))
    raises(dotgen.Wrong, lambda: echo.count(1, m=2), "n")


def synchronous(path):
    robot = dotgen.connect(path)
    echo = robot.load("echo")
    values(echo)
    assert repr(robot) == f"<Connection {path}: echo, reader>", robot
    assert repr(echo).startswith("<Component echo: services mirror, fail, "), echo
    assert repr(echo).endswith("; ports trail, each>"), echo
    assert repr(echo.count) == "<Service echo.count(n=2)>", echo.count
    assert echo.count.__doc__ == "echo.count(n=2): activity\nOutputs: seen", echo.count.__doc__
    assert str(inspect.signature(echo.count)) == "(n=2, *, ack=False)"
    assert repr(echo.each) == "<Port echo/each>"
    raises(AttributeError, lambda: echo.nothing, "`echo` has no `nothing`")
    reader = robot.load("reader")
    assert repr(reader.trail) == repr(reader.port("trail")) == "<InputPort reader/trail>", reader.trail
    raises(dotgen.Wrong, lambda: reader.trail.write([]), "is connected to `echo/trail`")
    raises(dotgen.Wrong, lambda: reader.port("trial"), "there are `trail`, `each`")
    raises(dotgen.Wrong, lambda: reader.port("seen"), "is an output port")

    counting = echo.count(3, ack=True)
    assert counting.wait() == 3 and counting.result == 3
    assert repr(counting) == "<Activity echo.count: done 3>", counting
    failed = echo.count(10**6, ack=True)
    assert failed.result is None and failed.exception is None
    raises(TimeoutError, lambda: failed.wait(0.01))
    raises(TimeoutError, lambda: echo.count(50, timeout=0.01))
    failed.abort()
    until(lambda: failed.status != "running")

    # A callback may request services. It hears each status once.
    heard, threads = [], []

    def callback(activity):
        heard.append((activity.status, echo.get_gain()))
        threads.append(threading.current_thread())

    seen = echo.count(10**6, ack=True, callback=callback)
    until(lambda: heard)
    seen.abort()
    until(lambda: len(heard) == 2)
    assert heard[0][0] == "running" and heard[1][0] in ("done", "failed"), heard
    assert threading.main_thread() not in threads
    # A callback that raises does not keep others from being called.
    with contextlib.redirect_stderr(io.StringIO()) as printed:
        echo.count(1, callback=lambda _: 1 / 0)
        until(lambda: printed.getvalue().count("ZeroDivisionError") == 2)
    for _ in range(20):
        heard.clear()
        echo.count(1, callback=callback)
        until(lambda: len(heard) == 2)
        assert [status for status, _ in heard] == ["running", "done"], heard
    # A run accepts 256 open requests of a connection: readers of a port share one.
    for _ in range(260):
        next(iter(echo.each))
    robot.close()
    raises(dotgen.Lost, lambda: echo.get_gain())


def of_genomix(path):
    handle = genomix.connect(path)
    echo = handle.load("/opt/plugins/echo.so")
    reader = handle.load("reader", "-i", "echo")
    assert repr(reader) == repr(echo)
    handle.unload("echo")
    statuses = []
    request = echo.count(10**6, send=True, callback=lambda it: statuses.append(it.status))
    assert request.status == genomix.Status.sent and str(request.status) == "sent"
    request.abort()
    while request.status not in (genomix.Status.done, genomix.Status.error):
        genomix.update()
    genomix.update()
    assert statuses[-1] == request.status, statuses
    request = echo.count({"n": 2}, ack=True)
    assert request.wait() == {"seen": 2} == request.result
    assert request.status == genomix.Status.done == "done" and str(request.status) == "done"
    assert echo.set_gain(4, oneway=True) is None
    until(lambda: echo.get_gain() == {"gain": 4})
    assert echo.set_gain() == {} and echo.get_gain() == {"gain": 3}
    error = raises(genomix.event.GenoMError, lambda: echo.fail(5), "::echo::e_bad")
    assert error.exception == "::echo::e_bad"
    request = echo.fail(5, send=True)
    until(lambda: request.status == genomix.Status.error)
    raises(genomix.GenoMError, lambda: request.result, "e_bad")
    assert set(echo.each("a")) == {"each"}
    raises(genomix.Wrong, lambda: genomix.connect("robot.example"), "other machines")
    handle.close()


async def asynchronous(path):
    async with dotgen.aio.connect(path) as robot:
        assert robot.components() == ["echo", "reader"]
        echo = robot.load("echo")
        assert repr(echo.count) == "<Service echo.count(n=2)>"
        assert await asyncio.gather(echo.count(3), echo.count(n=1), echo.count({"n": 2})) == [3, 1, 2]
        counting = await echo.count(10**6, ack=True)
        assert counting.status == "running"
        await counting.abort()
        statuses = [status async for status in counting]
        assert statuses[-1] == counting.status and len(statuses) <= 2, statuses
        counting = await echo.count(4, ack=True)
        assert await counting == 4 and await counting.wait() == 4
        try:
            await echo.fail(2)
        except dotgen.Failed as error:
            assert error.detail == {"code": 2}
        else:
            raise AssertionError("fail() does not fail")
        values = []
        async for value in echo.each:
            values.append(value)
            if len(values) == 3:
                break
        assert await echo.each("a") in values + [await echo.each("a")]
        try:
            await asyncio.wait_for(echo.count(10**6), 0.05)
        except asyncio.TimeoutError:
            pass
        watched = asyncio.ensure_future(echo.each.__aiter__().__anext__())
        assert isinstance(await watched, int)
        waiting = asyncio.ensure_future(counting_long(echo))
        await asyncio.sleep(0.05)
    try:
        await waiting
    except dotgen.Lost:
        pass
    else:
        raise AssertionError("the connection is closed")
    try:
        await dotgen.aio.connect(path + ".not")
    except dotgen.Lost:
        return
    raise AssertionError("nothing listens")


async def counting_long(echo):
    return await echo.count(100)


if __name__ == "__main__":
    synchronous(sys.argv[1])
    of_genomix(sys.argv[1])
    asyncio.run(asynchronous(sys.argv[1]))
