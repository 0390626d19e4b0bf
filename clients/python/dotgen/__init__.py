"""Sends requests to components that `dotgen run --clock real` runs, and reads and writes their ports.

    import dotgen
    robot = dotgen.connect()
    pump = robot.load("pump")
    pump.fill(height=2)                  # waits for the end, returns the outputs
    filling = pump.fill(height=5, ack=True)  # waits until the service is accepted
    filling.abort()
    filling.wait()                       # raises dotgen.Failed: it was interrupted
    pump.level()                         # the newest data of an output port
    pump.flow.write(1.5)                 # to an input port that no output port is connected to

`dotgen.aio` is the same for asyncio, `dotgen.genomix` runs scripts of genomix. Only the standard library is
needed. docs/socket.md describes the protocol.
"""

from .client import (
    Activity,
    Component,
    Connection,
    Error,
    Failed,
    InputPort,
    Lost,
    Port,
    Service,
    Silent,
    Wrong,
    connect,
)

__all__ = [
    "Activity",
    "Component",
    "Connection",
    "Error",
    "Failed",
    "InputPort",
    "Lost",
    "Port",
    "Service",
    "Silent",
    "Wrong",
    "connect",
]
