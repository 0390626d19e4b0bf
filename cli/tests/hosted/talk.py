"""Talks to the components of this folder, which run at a socket, and compares what it hears."""

import sys
import threading

import dotgen


def failed(do, exception, detail=None):
    try:
        do()
    except dotgen.Failed as it:
        assert (it.exception, it.detail) == (exception, detail), it
    else:
        raise AssertionError(f"{exception} was expected")


def main(path):
    robot = dotgen.connect(path)
    assert robot.components() == ["echo", "reader"]
    echo, reader = robot.load("echo"), robot.load("reader")

    value = {
        "b": True,
        "o": 255,
        "s": -3,
        "ul": 4_000_000_000,
        "ll": -5_000_000_000_000,
        "f": 0.1,
        "name": "12345678",
        "c": "BLUE",
        "grid": [
            [{"x": 1.0, "y": 2.0}, {"x": 3.0, "y": 4.0}],
            [{"x": 5.0, "y": 6.0}, {"x": 7.5, "y": 8.0}],
        ],
        "few": [{"x": 1.0, "y": 1.0}],
        "deep": [[1, 2], [], [3]],
        "maybe": {"x": 9.0, "y": 9.0},
        "kind": {"_d": "GREEN", "centre": {"x": 1.0, "y": 0.5}},
        "bits": [True, False, True],
        "text": "grüß",
        "words": ["a", "", "ccc"],
    }
    assert echo.mirror(value) == value
    assert echo.mirror(given=value) == value
    value.update(maybe=None, kind={"_d": "BLUE", "none": 7}, deep=[], words=[])
    assert echo.mirror(value) == value

    failed(lambda: echo.fail(5), "::echo::e_bad", {"code": 5})
    failed(lambda: echo.fail(0), "::echo::e_plain")
    echo.set_gain(9)
    assert echo.get_gain() == 9
    failed(lambda: echo.set_gain(-1), "::echo::e_plain")
    assert echo.get_gain() == 9
    echo.set_gain()
    assert echo.get_gain() == 3

    assert echo.count(n=5) == 5
    assert echo.count() == 2
    endless = echo.count(n=10**6, ack=True)
    assert endless.status == "running"
    seen = iter(reader.seen)
    next(seen), next(seen), next(seen)
    endless.abort()
    # It has ended by its own codel `stop`, as it should.
    assert endless.wait(10) == -1
    assert endless.status == "done"

    # Whoever waits keeps nobody from aborting.
    endless = echo.count(n=10**6, ack=True)

    def wait() -> None:
        try:
            endless.wait(30)
        except dotgen.Failed:
            pass  # It had not begun yet.

    waiting = threading.Thread(target=wait)
    waiting.start()
    endless.abort()
    waiting.join(20)
    assert not waiting.is_alive() and endless.status in ("done", "failed")

    last = next(it for it in reader.seen if it[0]["y"] == 3)
    assert [it["x"] for it in last] == [3.0, 2.0, 1.0]
    assert next(it for it in reader.sum if it == 31)

    for wrong in (
        lambda: echo.count(1, 2),
        lambda: echo.count(m=1),
        lambda: echo.count(n="many"),
        lambda: echo.count(n=float("nan")),
        lambda: robot.load("nobody"),
    ):
        try:
            wrong()
        except dotgen.Wrong:
            continue
        raise AssertionError("that is wrong")
    robot.close()


main(sys.argv[1])
