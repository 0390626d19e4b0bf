"""What scripts of genomix need: `import dotgen.genomix as genomix`, and the rest of a script stays as it is.

    g = genomix.connect()
    g.rpath("/opt/openrobots/lib/genom/pocolibs/plugins")
    pump = g.load("pump")
    pump.fill({"height": 2}, ack=True)
    print(pump.level()["level"])

`python3 -m dotgen.genomix SCRIPT` runs a script without any change. Unlike `dotgen`, outputs of services and
data of ports are always dictionaries by name.
"""

from __future__ import annotations

import os
import pathlib
import time
import weakref
from typing import Any

from .. import client
from ..client import Activity, Error, Failed, Lost, Wrong
from ..protocol import HERE, Described, Signature, ports, tcp_port
from .event import GenoMError, Status

__all__ = [
    "Activity",
    "Component",
    "Connection",
    "Error",
    "Failed",
    "GenoMError",
    "Lost",
    "Request",
    "Status",
    "Wrong",
    "connect",
    "update",
]

# All connections, for `update()`.
_connections: weakref.WeakSet[client.Connection] = weakref.WeakSet()

# Seconds that `update()` takes, so that a loop around it leaves the processor to others.
_TURN = 0.01


class Request(Activity["dict[str, Any]"]):
    """A request of a service."""

    def _value(self, end: dict[str, Any]) -> Any:
        return end["output"] or {}

    @property
    def status(self) -> Status:
        """`Status.sent` until the end, then `Status.done` or `Status.error`."""
        return {"done": Status.done, "failed": Status.error}.get(super().status, Status.sent)

    def __repr__(self) -> str:
        return f"<Request {self._signature.path}: {self.status}>"


class _Service(client.Service):
    """A service. A call sends a request, with inputs in order, by name, or in one dictionary."""

    def __call__(self, *args: Any, ack: bool = False, **inputs: Any) -> Any:
        """Waits for the end and returns the outputs by name.

        With `ack=True`, waits until the service is accepted and returns a `Request`. With `send=True`,
        returns the `Request` at once, and with `oneway=True` None. `callback=` is called with the `Request`
        at each change of its status. `timeout=` limits the wait, in seconds.
        """
        options: dict[str, Any] = dict(callback=None, timeout=None, send=False, oneway=False)
        inputs, options = self._signature.options(args, inputs, options)
        request = Request(self._connection, self._signature, options["callback"])
        request._send(self._signature.request(args, inputs))
        if options["oneway"]:
            return None
        if ack:
            return request.accepted(options["timeout"])
        return request if options["send"] else request.wait(options["timeout"])


class _Port:
    """An output port: call it, with the name of an instance if it is `multiple`."""

    def __init__(self, port: client.Port[Any], name: str) -> None:
        self._port = port
        self._name = name

    def __repr__(self) -> str:
        return repr(self._port)

    def __call__(self, instance: str = "") -> dict[str, Any]:
        return {self._name: self._port(instance)}


class Component(Described):
    """A component: its services and output ports are functions."""

    def __init__(self, connection: client.Connection, description: dict[str, Any]) -> None:
        super().__init__(description)
        name = description["name"]
        for port in ports(description, "out"):
            found = client.Port[Any](connection, f"{name}/{port}")
            setattr(self, port, _Port(found, port))
        for service in description["services"]:
            setattr(self, service["name"], _Service(connection, Signature(name, service)))


class Connection:
    """A connection to a run."""

    def __init__(self, connection: client.Connection) -> None:
        self._connection = connection
        _connections.add(connection)

    def __repr__(self) -> str:
        return repr(self._connection)

    def rpath(self, *_: str) -> None:
        """Does nothing: the run knows its components."""

    def load(self, name: str, *options: str, **_: Any) -> Component:
        """Returns a component of the run, by its name, by the path of a plugin, or by its instance.

        After `'-i'` comes the name of the instance.
        """
        loaded = pathlib.PurePath(name).stem
        if "-i" in options[:-1]:
            loaded = options[options.index("-i") + 1]
        found: client.Component = self._connection.load(loaded)
        return Component(self._connection, found._description)

    def unload(self, *_: Any) -> None:
        """Does nothing: components run as long as their run."""

    def close(self) -> None:
        """Ends the connection. Activities go on."""
        self._connection.close()


def connect(host: str | os.PathLike[str] | None = None) -> Connection:
    """Connects to a run: the only one on this machine, at `localhost:PORT`, or at the path of its socket.

    If no run listens at the port, the only run is meant: `localhost:8080` is the default of genomix.
    """
    if host is None or os.fspath(host) in HERE:
        return Connection(client.connect())
    text = os.fspath(host)
    if tcp_port(text) is not None:
        try:
            return Connection(client.connect(text))
        except Lost:
            return Connection(client.connect())
    if not os.path.exists(text):
        raise Wrong(f"`{text}` is not the socket of a run; other machines cannot be reached")
    return Connection(client.connect(text))


def update() -> None:
    """Waits for news for ten milliseconds, and for callbacks that are due for up to a second.

    Answers are also received, and callbacks called, without this function.
    """
    time.sleep(_TURN)
    for connection in list(_connections):
        connection._settle(1)
