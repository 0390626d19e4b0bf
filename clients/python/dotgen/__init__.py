"""Talks to components that `dotgen run --clock real` runs.

    import dotgen
    robot = dotgen.connect()
    pump = robot.load("pump")
    pump.fill(height=2)                  # waits for its end, and returns the outputs
    filling = pump.fill(height=5, ack=True)  # waits until it is accepted
    filling.abort()
    filling.wait()                       # raises dotgen.Failed: it was interrupted
    pump.level()                         # the newest data of an output port

Needs nothing beside the standard library. The protocol is described in docs/socket.md.
"""

from .client import Activity, Component, Connection, Error, Failed, Lost, Port, Wrong, connect

__all__ = [
    "Activity",
    "Component",
    "Connection",
    "Error",
    "Failed",
    "Lost",
    "Port",
    "Wrong",
    "connect",
]
