"""What scripts of genomix need: `import dotgen.genomix as genomix`, and the rest stays as it is.

    g = genomix.connect()
    g.rpath("/opt/openrobots/lib/genom/pocolibs/plugins")
    pump = g.load("pump")
    pump.fill({"height": 2}, ack=True)
    print(pump.level()["level"])

Differs from `dotgen` itself in what comes back: outputs of services and data of ports are always dictionaries by name.
"""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable
from typing import Any

from . import client
from .client import Activity, Error, Failed, Lost, Wrong

__all__ = ["Activity", "Component", "Connection", "Error", "Failed", "Lost", "Wrong", "connect"]

# Names of this machine.
_HERE = ("localhost", "127.0.0.1")


class _Service:
    """A service: call it, with inputs in order, by name, or as one dictionary."""

    def __init__(self, request: Callable[..., Activity[Any]], doc: str | None) -> None:
        self._request = request
        self.__doc__ = doc

    def __call__(self, *args: Any, ack: bool = False, **inputs: Any) -> Any:
        activity = self._request(*args, ack=True, **inputs)
        return activity if ack else activity.wait() or {}


class _Port:
    """An output port: call it, with the name of an instance if it is `multiple`."""

    def __init__(self, port: client.Port[Any], name: str) -> None:
        self._port = port
        self._name = name

    def __call__(self, instance: str = "") -> dict[str, Any]:
        return {self._name: self._port(instance)}


class Component:
    """A component: its services and output ports are functions."""

    def __init__(self, component: client.Component) -> None:
        self._component = component
        self.__doc__ = component.__doc__
        description = component._description
        for port in description["ports"]:
            if port["direction"] == "out":
                found = getattr(component, port["name"])
                setattr(self, port["name"], _Port(found, port["name"]))
        for service in description["services"]:
            request = component._function(service, named=True)
            setattr(self, service["name"], _Service(request, service.get("doc")))

    def __dir__(self) -> list[str]:
        return sorted(it for it in self.__dict__ if not it.startswith("_"))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._component, name)


class Connection:
    """A connection with a run."""

    def __init__(self, connection: client.Connection) -> None:
        self._connection = connection

    def rpath(self, *_: str) -> None:
        """Does nothing: components are where the run has them."""

    def load(self, name: str, *_: Any, **__: Any) -> Component:
        """A component of the run, by its name or by the path of the plugin that it would have."""
        found = self._connection.load(pathlib.PurePath(name).stem)
        return Component(found)

    def close(self) -> None:
        """Ends the connection. Activities go on."""
        self._connection.close()


def connect(host: str | os.PathLike[str] | None = None) -> Connection:
    """Connects to the only run on this machine, to the one that listens at `localhost:PORT`, or to the one whose socket is
    at a path."""
    if host is None or os.fspath(host) in _HERE:
        return Connection(client.connect())
    text = os.fspath(host)
    if text.rpartition(":")[0] in _HERE:
        return Connection(client.connect(text))
    if not os.path.exists(text):
        raise Wrong(f"`{text}` is no socket of a run; dotgen runs are reached on their own machine only")
    return Connection(client.connect(text))
