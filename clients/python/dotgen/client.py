"""The client. Many threads may use one connection."""

from __future__ import annotations

import collections
import json
import os
import pathlib
import socket
import stat
import tempfile
import threading
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

_T = TypeVar("_T")

# Data of ports that a reader may be behind; then the oldest is dropped.
_BEHIND = 10_000


class Error(Exception):
    """Something went wrong."""


class Wrong(Error):
    """A request that cannot be made: there is no such service, or its inputs do not fit."""


class Lost(Error):
    """The run has ended."""


class Failed(Error):
    """A service was refused, interrupted, or has thrown an exception."""

    def __init__(self, exception: str, detail: Any = None) -> None:
        super().__init__(exception if detail is None else f"{exception} {json.dumps(detail)}")
        #: Full name of the exception: `::pump::e_valve`.
        self.exception = exception
        #: Its members by name, or None.
        self.detail = detail


class _Exchange:
    """A request and what came back. Many threads may look at it."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._answers: collections.deque[dict[str, Any]] = collections.deque()
        self._over = False

    def put(self, answer: dict[str, Any] | None) -> None:
        """Something came; None: nothing comes any more."""
        with self._changed:
            if answer is None:
                self._over = True
            else:
                if answer["event"] == "data" and len(self._answers) > _BEHIND:
                    self._answers.popleft()
                self._answers.append(answer)
            self._changed.notify_all()

    def next(self, timeout: float | None = None) -> dict[str, Any]:
        """Takes what came first."""
        with self._changed:
            self._await(lambda: self._answers, timeout)
            answer = self._answers.popleft()
        if answer["event"] == "error":
            raise Wrong(answer["message"])
        return answer

    def find(self, events: tuple[str, ...], timeout: float | None = None) -> dict[str, Any]:
        """The first answer of some kinds; it stays for whoever asks again."""
        with self._changed:
            self._await(lambda: self.seen(*events, "error") is not None, timeout)
            answer = self.seen(*events, "error")
        assert answer is not None
        if answer["event"] == "error":
            raise Wrong(answer["message"])
        return answer

    def seen(self, *events: str) -> dict[str, Any] | None:
        """Likewise, if it has come already."""
        with self._changed:
            return next((it for it in self._answers if it["event"] in events), None)

    def _await(self, there: Callable[[], object], timeout: float | None) -> None:
        if not self._changed.wait_for(lambda: there() or self._over, timeout):
            raise TimeoutError("nothing came in time")
        if not there():
            raise Lost("the run has ended")


class Activity(Generic[_T]):
    """A service that was requested."""

    def __init__(
        self, connection: Connection, number: int, exchange: _Exchange, named: bool = False
    ) -> None:
        self._connection = connection
        self._number = number
        self._exchange = exchange
        # Outputs are a dictionary, also where there is one.
        self._named = named

    def wait(self, timeout: float | None = None) -> _T:
        """Waits for the end and returns the outputs: a value if there is one, else a dictionary."""
        end = self._exchange.find(("done", "failed"), timeout)
        self._connection._forget(self._number)
        if end["event"] == "failed":
            raise Failed(end["exception"], end.get("detail"))
        outputs: _T = end["output"] if self._named else _outputs(end["output"])
        return outputs

    def accepted(self, timeout: float | None = None) -> Activity[_T]:
        """Waits until it is accepted; raises Failed if it is not."""
        first = self._exchange.find(("accepted", "done", "failed"), timeout)
        if first["event"] == "failed":
            raise Failed(first["exception"], first.get("detail"))
        return self

    def abort(self) -> None:
        """Interrupts it. What then comes of it tells wait()."""
        if self.status in ("sent", "running"):
            self._connection._ask({"abort": self._number})

    @property
    def status(self) -> str:
        """sent, running, done or failed."""
        end = self._exchange.seen("done", "failed")
        if end is not None:
            return str(end["event"])
        return "running" if self._exchange.seen("accepted") else "sent"


def _outputs(it: Any) -> Any:
    if isinstance(it, dict) and len(it) == 1:
        return next(iter(it.values()))
    return it or None


class Port(Generic[_T]):
    """An output port: call it for its newest data, iterate over it for what comes."""

    def __init__(self, connection: Connection, path: str) -> None:
        self._connection = connection
        self._path = path

    def __call__(self, instance: str = "") -> _T | None:
        answer = self._connection._ask({"read": self._path})
        value: _T | None = answer["instances"].get(instance)
        return value

    def __iter__(self) -> Iterator[_T]:
        number, exchange = self._connection._send({"watch": self._path})
        try:
            while True:
                answer = exchange.next()
                if answer["event"] == "data":
                    yield answer["value"]
                elif answer["event"] == "lost":
                    raise Lost(answer["message"])
        finally:
            self._connection._forget(number)


class Component:
    """A component: its services are functions, its output ports are Ports."""

    def __init__(self, connection: Connection, description: dict[str, Any]) -> None:
        self._connection = connection
        self._description = description
        self.__doc__ = description.get("doc")
        name = description["name"]
        for port in description["ports"]:
            if port["direction"] == "out":
                setattr(self, port["name"], Port[Any](connection, f"{name}/{port['name']}"))
        for service in description["services"]:
            setattr(self, service["name"], self._function(service))

    def _function(self, service: dict[str, Any], named: bool = False) -> Callable[..., Any]:
        path = f"{self._description['name']}.{service['name']}"
        names = [it["name"] for it in service["inputs"]]

        def request(*args: Any, ack: bool = False, **inputs: Any) -> Any:
            by_name = len(args) == 1 and isinstance(args[0], dict) and not inputs
            if by_name and set(args[0]) <= set(names):
                inputs = dict(args[0])
            elif len(args) > len(names):
                raise Wrong(f"{path} has {len(names)} inputs: {', '.join(names)}")
            else:
                for name, value in zip(names, args):
                    if name in inputs:
                        raise Wrong(f"{path} was given `{name}` twice")
                    inputs[name] = value
            number, exchange = self._connection._send({"call": path, "input": inputs})
            activity = Activity[Any](self._connection, number, exchange, named)
            return activity.accepted() if ack else activity.wait()

        request.__name__ = service["name"]
        request.__qualname__ = path
        request.__doc__ = service.get("doc")
        return request

    def __dir__(self) -> list[str]:
        return sorted(it for it in self.__dict__ if not it.startswith("_"))

    def __getattr__(self, name: str) -> Any:
        known = ", ".join(self.__dir__())
        raise AttributeError(f"`{self._description['name']}` has no `{name}`; it has {known}")


class Connection:
    """A connection with a run."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        host, _, port = os.fspath(path).rpartition(":")
        loopback = host in ("localhost", "127.0.0.1") and port.isdecimal()
        self._socket = socket.socket(socket.AF_INET if loopback else socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.connect(("127.0.0.1", int(port)) if loopback else os.fspath(path))
        except OSError as error:
            self._socket.close()
            raise Lost(f"no run listens at `{os.fspath(path)}`: {error.strerror}") from None
        self._lock = threading.Lock()
        self._next = 0
        self._exchanges: dict[int, _Exchange] = collections.OrderedDict()
        self._ended = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._components: list[dict[str, Any]] = self._ask({"describe": None})["components"]

    def _read(self) -> None:
        try:
            with self._socket.makefile("rb") as lines:
                for line in lines:
                    answer = json.loads(line)
                    with self._lock:
                        if answer.get("id") is None:
                            # What was not understood may be any request.
                            asked = list(self._exchanges.values())
                        else:
                            asked = [self._exchanges[it] for it in (answer["id"],) if it in self._exchanges]
                    for exchange in asked:
                        exchange.put(answer)
        except (OSError, ValueError):
            pass
        with self._lock:
            self._ended = True
            exchanges = list(self._exchanges.values())
        for exchange in exchanges:
            exchange.put(None)

    def _send(self, request: dict[str, Any]) -> tuple[int, _Exchange]:
        exchange = _Exchange()
        try:
            # NaN and infinity are no JSON.
            words = json.dumps(request, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise Wrong(f"this cannot be sent: {error}") from None
        with self._lock:
            if self._ended:
                raise Lost("the run has ended")
            self._next += 1
            number = self._next
            self._exchanges[number] = exchange
            try:
                self._socket.sendall(f'{{"id": {number}, {words[1:]}\n'.encode())
            except OSError:
                raise Lost("the run has ended") from None
        return number, exchange

    def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        number, exchange = self._send(request)
        try:
            return exchange.next()
        finally:
            self._forget(number)

    def _forget(self, number: int) -> None:
        with self._lock:
            self._exchanges.pop(number, None)

    def rpath(self, *_: str) -> None:
        """Does nothing: components are where the run has them. Kept for scripts of genomix."""

    def load(self, name: str, **_: Any) -> Any:
        """A Component of the run. Its type is what `dotgen generate python` writes."""
        for it in self._components:
            if it["name"] == name:
                return Component(self, it)
        known = ", ".join(it["name"] for it in self._components)
        raise Wrong(f"there is no component `{name}` in this run; there are {known}")

    def components(self) -> list[str]:
        """Their names."""
        return [it["name"] for it in self._components]

    def close(self) -> None:
        """Ends the connection. Activities go on."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._socket.close()

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _folder() -> pathlib.Path:
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime:
        return pathlib.Path(runtime) / "dotgen"
    return pathlib.Path(tempfile.gettempdir()) / f"dotgen-{os.getuid()}"


def connect(path: str | os.PathLike[str] | None = None) -> Connection:
    """Connects to a run: the one whose socket is at a path, or that listens at `localhost:PORT`; else the only one there
    is."""
    if path is not None:
        return Connection(path)
    folder = _folder()
    found = []
    try:
        info = folder.lstat()
        private = stat.S_ISDIR(info.st_mode) and info.st_uid == os.getuid()
        sockets = sorted(folder.glob("*.sock")) if private else []
    except OSError:
        sockets = []
    for it in sockets:
        try:
            found.append(Connection(it))
        except Lost:
            continue
    if not found:
        raise Lost("nothing runs; start it with `dotgen run --clock real FILE`")
    if len(found) > 1:
        for connection in found:
            connection.close()
        names = ", ".join(str(it) for it in sockets)
        raise Wrong(f"there are several runs; choose one: {names}")
    return found[0]
