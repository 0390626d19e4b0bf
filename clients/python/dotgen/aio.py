"""The client for asyncio.

    async with dotgen.aio.connect() as robot:
        pump = robot.load("pump")
        await pump.fill(height=2)                    # the outputs
        filling = await pump.fill(height=5, ack=True)  # an activity that is accepted
        async for status in filling: ...             # running, then done or failed
        async for level in pump.level: ...           # each value of an output port
        async for violation in robot.violations(): ...  # each when it happens
        await pump.flow.write(1.5)                   # to an input port

A connection belongs to the event loop in which it was made. If a task is cancelled while it awaits the call of
a service, the service is interrupted. An activity goes on.
"""

from __future__ import annotations

import asyncio
import functools
import os
from collections.abc import AsyncIterator, Callable, Generator
from typing import Any, Generic, TypeVar, Union

from .protocol import (
    TIMEOUT,
    Answer,
    Answers,
    Described,
    Error,
    Failed,
    Inlet,
    Lost,
    Receive,
    Requests,
    Signature,
    Silent,
    Wrong,
    inlet,
    inlets,
    known,
    only,
    outputs,
    ports,
    sockets,
    tcp_port,
    token,
    violated,
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

_T = TypeVar("_T")
_Path = Union[str, "os.PathLike[str]"]

# Bytes of the longest line that is read: an image is one line.
_LONGEST = 1 << 28


class _Exchange:
    """The answers to a request. Many tasks may wait for them."""

    def __init__(self) -> None:
        self._changed = asyncio.Event()
        self.answers = Answers()

    def put(self, answer: Answer) -> None:
        """Adds an answer and wakes all tasks that wait."""
        self.answers.put(answer)
        self._changed.set()

    async def wait(self, poll: Callable[[], _T | None]) -> _T:
        """Waits until a function of the answers returns something."""
        while True:
            found = poll()
            if found is not None:
                return found
            self._changed.clear()
            await self._changed.wait()


class Activity(Generic[_T]):
    """A request of a service. `await` returns its outputs. `async for` yields each change of its status."""

    def __init__(self, connection: Connection, signature: Signature, request: dict[str, Any]) -> None:
        self._connection = connection
        self._signature = signature
        self._exchange = _Exchange()
        self._number, line = connection._requests.open(request, self._exchange.put)
        connection._write(line)

    def __repr__(self) -> str:
        return f"<Activity {self._signature.path}: {self.status}>"

    async def wait(self) -> _T:
        """Waits for the end and returns the outputs. Raises `Failed` if the service failed."""
        value: _T = outputs(await self._exchange.wait(self._exchange.answers.ended))
        return value

    def __await__(self) -> Generator[Any, None, _T]:
        return self.wait().__await__()

    async def __aiter__(self) -> AsyncIterator[str]:
        told = "sent"
        while told not in ("done", "failed"):
            told = await self._exchange.wait(functools.partial(self._changed, told))
            yield told

    def _changed(self, told: str) -> str | None:
        status = self.status
        return status if status != told else None

    async def accepted(self) -> Activity[_T]:
        """Waits until the service is accepted. Raises `Failed` if it is refused."""
        await self._exchange.wait(self._exchange.answers.begun)
        return self

    async def abort(self) -> None:
        """Interrupts the service. `wait()` returns or raises the result of the interruption."""
        if self.status in ("sent", "running"):
            await self._connection._ask({"abort": self._number})

    @property
    def status(self) -> str:
        """`sent`, `running`, `done` or `failed`."""
        return self._exchange.answers.status()


class Port(Generic[_T]):
    """An output port. A call returns its newest data. `async for` yields each value that is written."""

    def __init__(self, connection: Connection, path: str) -> None:
        self._connection = connection
        self._path = path

    def __repr__(self) -> str:
        return f"<Port {self._path}>"

    async def __call__(self, instance: str = "") -> _T | None:
        """Returns the newest data, of an instance if the port is `multiple`. None: no data yet."""
        answer = await self._connection._ask({"read": self._path})
        value: _T | None = answer["instances"].get(instance)
        return value

    async def __aiter__(self) -> AsyncIterator[_T]:
        exchange = _Exchange()
        line = self._connection._requests.watch(self._path, exchange.put)
        if line is not None:
            self._connection._write(line)
        try:
            while True:
                answer = await exchange.wait(exchange.answers.take)
                if answer["event"] == "data":
                    yield answer["value"]
                elif answer["event"] == "lost":
                    raise Lost(answer["message"])
        finally:
            self._connection._requests.unwatch(self._path, exchange.put)


class InputPort(Generic[_T]):
    """An input port. `write` gives it a value, if no output port of the run is connected to it."""

    def __init__(self, connection: Connection, inlet: Inlet) -> None:
        self._connection = connection
        self._inlet = inlet

    def __repr__(self) -> str:
        return f"<InputPort {self._inlet.path}>"

    async def write(self, value: _T, instance: str = "") -> None:
        """Writes a value, to an instance if the port is `multiple`. Codels read the newest one.

        Raises `Wrong` if the value does not fit, or an output port is connected.
        """
        await self._connection._ask(self._inlet.request(value, instance))


class Service:
    """A service: a coroutine, with inputs in order, by name, or in one dictionary."""

    def __init__(self, connection: Connection, signature: Signature) -> None:
        self._connection = connection
        self._signature = signature
        self.__name__ = signature.name
        self.__qualname__ = signature.path
        self.__doc__ = signature.text()
        python = signature.python()
        if python is not None:
            self.__signature__ = python

    def __repr__(self) -> str:
        return f"<Service {self._signature}>"

    async def __call__(self, *args: Any, ack: bool = False, **inputs: Any) -> Any:
        """Waits for the end and returns the outputs.

        With `ack=True`, waits until the service is accepted and returns an `Activity`.
        """
        request = self._signature.request(args, inputs)
        activity = Activity[Any](self._connection, self._signature, request)
        try:
            return await (activity.accepted() if ack else activity.wait())
        except asyncio.CancelledError:
            # Nobody else can interrupt the service.
            activity._connection._interrupt(activity._number)
            raise


class Component(Described):
    """A component: its services are coroutines, its ports are `Port`s and `InputPort`s."""

    def __init__(self, connection: Connection, description: dict[str, Any]) -> None:
        self._connection = connection
        super().__init__(description)
        name = description["name"]
        for each in inlets(description):
            setattr(self, each.name, InputPort[Any](connection, each))
        for port in ports(description, "out"):
            setattr(self, port, Port[Any](connection, f"{name}/{port}"))
        for service in description["services"]:
            setattr(self, service["name"], Service(connection, Signature(name, service)))

    def port(self, name: str) -> InputPort[Any]:
        """Returns an input port. It is also an attribute, unless a service has its name."""
        return InputPort[Any](self._connection, inlet(self._description, name))


class Connection:
    """A connection to a run."""

    def __init__(
        self,
        path: str,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        timeout: float | None = TIMEOUT,
    ) -> None:
        self._path = path
        self._timeout = timeout
        self._reader = reader
        self._writer = writer
        self._requests = Requests()
        self._components: list[dict[str, Any]] = []
        self._task = asyncio.ensure_future(self._read())

    def __repr__(self) -> str:
        return f"<Connection {self._path}: {', '.join(self.components())}>"

    async def _read(self) -> None:
        try:
            while line := await self._reader.readline():
                self._pass(self._requests.receive(line))
        except (OSError, ValueError):
            pass
        finally:
            self._pass(self._requests.end())
            self._writer.close()

    def _pass(self, receivers: list[tuple[Receive, Answer]]) -> None:
        for receive, answer in receivers:
            receive(answer)

    def _write(self, line: bytes) -> None:
        self._writer.write(line)

    def _interrupt(self, number: int) -> None:
        try:
            self._write(self._requests.open({"abort": number}, lambda _: None)[1])
        except Lost:
            pass

    async def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        exchange = _Exchange()
        number, line = self._requests.open(request, exchange.put)
        self._write(line)
        try:
            return await asyncio.wait_for(exchange.wait(exchange.answers.take), self._timeout)
        except asyncio.TimeoutError:
            raise Silent(request, self._timeout) from None
        finally:
            self._requests.close(number)

    def load(self, name: str) -> Component:
        """Returns a component of the run."""
        return Component(self, known(self._components, name))

    async def violations(self) -> AsyncIterator[dict[str, Any]]:
        """Yields the violations so far, then each one when it happens: see docs/socket.md.

        A repeated one comes again, at most once a second, with greater `times`. Raises `Lost` at the end of
        the run.
        """
        exchange = _Exchange()
        number, line = self._requests.open({"violations": None}, exchange.put)
        self._write(line)
        try:
            while True:
                answer = await exchange.wait(exchange.answers.take)
                if answer["event"] == "violation":
                    yield violated(answer)
        finally:
            self._requests.close(number)
            self._interrupt(number)

    def components(self) -> list[str]:
        """Returns the names of the components."""
        return [each["name"] for each in self._components]

    async def close(self) -> None:
        """Ends the connection. Activities go on."""
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)

    async def __aenter__(self) -> Connection:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


class connect:
    """Connects to a run: at the path of its socket, at `localhost:PORT`, or to the only run.

    Use `async with connect() as robot:`, or `robot = await connect()` with `await robot.close()`.
    If the run does not answer within `timeout` seconds, connecting, reads and writes raise `Silent`.
    """

    def __init__(self, path: _Path | None = None, *, timeout: float | None = TIMEOUT) -> None:
        self._path = path
        self._timeout = timeout
        self._connection: Connection | None = None

    def __await__(self) -> Generator[Any, None, Connection]:
        return _connect(self._path, self._timeout).__await__()

    async def __aenter__(self) -> Connection:
        self._connection = await self
        return self._connection

    async def __aexit__(self, *_: object) -> None:
        if self._connection is not None:
            await self._connection.close()


async def _connect(path: _Path | None, timeout: float | None) -> Connection:
    if path is not None:
        return await _open(path, timeout)
    found: list[Connection] = []
    for each in sockets():
        try:
            found.append(await _open(each, timeout))
        except Silent:
            raise
        except Lost:
            continue
    try:
        only([connection._path for connection in found])
    except Wrong:
        for connection in found:
            await connection.close()
        raise
    return found[0]


async def _open(path: _Path, timeout: float | None) -> Connection:
    shown, port = os.fspath(path), tcp_port(path)
    try:
        if port is None:
            reader, writer = await asyncio.open_unix_connection(shown, limit=_LONGEST)
        else:
            reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=_LONGEST)
            writer.write(token(port))
    except OSError as error:
        raise Lost(f"no run listens at `{shown}`: {error.strerror}") from None
    connection = Connection(shown, reader, writer, timeout)
    try:
        connection._components = (await connection._ask({"describe": None}))["components"]
    except BaseException:
        await connection.close()
        raise
    return connection
