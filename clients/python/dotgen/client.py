"""The synchronous client. Many threads may use one connection."""

from __future__ import annotations

import functools
import os
import queue
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
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
_Callback = Callable[[Any], object]


class _Exchange:
    """The answers to a request. Many threads may wait for them."""

    def __init__(self, notify: Callable[[], None] | None = None) -> None:
        self._changed = threading.Condition()
        self._notify = notify
        self.answers = Answers()

    def put(self, answer: Answer) -> None:
        """Adds an answer and wakes all threads that wait."""
        with self._changed:
            self.answers.put(answer)
            self._changed.notify_all()
        if self._notify is not None:
            self._notify()

    def wait(self, poll: Callable[[], _T | None], timeout: float | None = None) -> _T:
        """Waits until a function of the answers returns something."""
        end = None if timeout is None else time.monotonic() + timeout
        with self._changed:
            while True:
                found = poll()
                if found is not None:
                    return found
                rest = None if end is None else end - time.monotonic()
                if rest is not None and rest <= 0 or not self._changed.wait(rest):
                    raise TimeoutError(f"no answer within {timeout} s")

    def status(self) -> str:
        """Returns the status of a service."""
        with self._changed:
            return self.answers.status()


class Activity(Generic[_T]):
    """A request of a service."""

    def __init__(
        self, connection: Connection, signature: Signature, callback: _Callback | None = None
    ) -> None:
        self._connection = connection
        self._signature = signature
        self._callback = callback
        # The status that was passed on last, and the one that a callback hears now.
        self._told = "sent"
        self._shown: str | None = None
        self._exchange = _Exchange(self._notify if callback is not None else None)
        self._number = 0

    def __repr__(self) -> str:
        status, rest = self.status, ""
        if status == "done":
            rest = f" {self.result!r}"
        elif status == "failed":
            rest = f" {self.exception}"
        return f"<Activity {self._signature.path}: {status}{rest}>"

    def _send(self, request: dict[str, Any]) -> None:
        connection = self._connection
        # The number is known before the first callback.
        with connection._lock:
            self._number, line = connection._requests.open(request, self._exchange.put)
            connection._write(line)

    def _notify(self) -> None:
        # Called for each answer. A status is passed on once.
        status = self._exchange.status()
        if self._callback is not None and status != self._told:
            self._told = status
            self._connection._later(functools.partial(self._tell, self._callback, status))

    def _tell(self, callback: _Callback, status: str) -> None:
        self._shown = status
        try:
            callback(self)
        finally:
            self._shown = None

    def _value(self, end: dict[str, Any]) -> Any:
        return outputs(end)

    def wait(self, timeout: float | None = None) -> _T:
        """Waits for the end and returns the outputs: one as a value, several as a dictionary.

        Raises `Failed` if the service failed, and `TimeoutError` after the timeout in seconds.
        """
        value: _T = self._value(self._exchange.wait(self._exchange.answers.ended, timeout))
        return value

    def accepted(self, timeout: float | None = None) -> Activity[_T]:
        """Waits until the service is accepted. Raises `Failed` if it is refused."""
        self._exchange.wait(self._exchange.answers.begun, timeout)
        return self

    def abort(self) -> None:
        """Interrupts the service. `wait()` returns or raises the result of the interruption."""
        if self._exchange.status() in ("sent", "running"):
            self._connection._ask({"abort": self._number})

    @property
    def status(self) -> str:
        """`sent`, `running`, `done` or `failed`. In a callback, the status that the callback is called for."""
        if self._shown is not None and self._connection._is_caller():
            return self._shown
        return self._exchange.status()

    @property
    def result(self) -> _T | None:
        """The outputs, or None before the end. Raises `Failed` if the service failed."""
        return self.wait() if self._exchange.status() in ("done", "failed") else None

    @property
    def exception(self) -> Error | None:
        """The error of a service that failed, or None."""
        try:
            self.result
        except Error as error:
            return error
        return None


class Port(Generic[_T]):
    """An output port. A call returns its newest data. Iteration yields each value that is written."""

    def __init__(self, connection: Connection, path: str) -> None:
        self._connection = connection
        self._path = path

    def __repr__(self) -> str:
        return f"<Port {self._path}>"

    def __call__(self, instance: str = "") -> _T | None:
        """Returns the newest data, of an instance if the port is `multiple`. None: no data yet."""
        answer = self._connection._ask({"read": self._path})
        value: _T | None = answer["instances"].get(instance)
        return value

    def __iter__(self) -> Iterator[_T]:
        exchange = _Exchange()
        self._connection._watch(self._path, exchange.put)
        try:
            while True:
                answer = exchange.wait(exchange.answers.take)
                if answer["event"] == "data":
                    yield answer["value"]
                elif answer["event"] == "lost":
                    raise Lost(answer["message"])
        finally:
            self._connection._unwatch(self._path, exchange.put)


class InputPort(Generic[_T]):
    """An input port. `write` gives it a value, if no output port of the run is connected to it."""

    def __init__(self, connection: Connection, inlet: Inlet) -> None:
        self._connection = connection
        self._inlet = inlet

    def __repr__(self) -> str:
        return f"<InputPort {self._inlet.path}>"

    def write(self, value: _T, instance: str = "") -> None:
        """Writes a value, to an instance if the port is `multiple`. Codels read the newest one.

        Raises `Wrong` if the value does not fit, or an output port is connected.
        """
        self._connection._ask(self._inlet.request(value, instance))


class Service:
    """A service. A call sends a request, with inputs in order, by name, or in one dictionary."""

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

    def __call__(self, *args: Any, ack: bool = False, **inputs: Any) -> Any:
        """Waits for the end and returns the outputs.

        With `ack=True`, waits until the service is accepted and returns an `Activity`. `callback=` is called
        with the `Activity` at each change of its status, in a thread of its own. `timeout=` limits the wait,
        in seconds: the service goes on.
        """
        options: dict[str, Any] = {"callback": None, "timeout": None}
        inputs, options = self._signature.options(args, inputs, options)
        activity = Activity[Any](self._connection, self._signature, options["callback"])
        activity._send(self._signature.request(args, inputs))
        timeout = options["timeout"]
        return activity.accepted(timeout) if ack else activity.wait(timeout)


class Component(Described):
    """A component: its services are functions, its ports are `Port`s and `InputPort`s."""

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
    """A connection to a run. `timeout` limits the wait for answers that a run gives at once, in seconds.

    Services are not limited by it: their calls have a `timeout` of their own.
    """

    def __init__(self, path: _Path, timeout: float | None = TIMEOUT) -> None:
        self._timeout = timeout
        self._path = os.fspath(path)
        port = tcp_port(path)
        family = socket.AF_UNIX if port is None else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_STREAM)
        self._socket.settimeout(timeout)
        try:
            self._socket.connect(self._path if port is None else ("127.0.0.1", port))
            if port is not None:
                self._socket.sendall(token(port))
        except OSError as error:
            self._socket.close()
            reason = error.strerror or str(error)
            raise Lost(f"no run listens at `{self._path}`: {reason}") from None
        self._socket.settimeout(None)
        self._lock = threading.Lock()
        self._requests = Requests()
        self._callbacks: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._caller: threading.Thread | None = None
        threading.Thread(target=self._read, daemon=True).start()
        try:
            self._components: list[dict[str, Any]] = self._ask({"describe": None})["components"]
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        return f"<Connection {self._path}: {', '.join(self.components())}>"

    def _read(self) -> None:
        try:
            with self._socket.makefile("rb") as lines:
                for line in lines:
                    with self._lock:
                        receivers = self._requests.receive(line)
                    self._pass(receivers)
        except (OSError, ValueError):
            pass
        with self._lock:
            receivers = self._requests.end()
        self._pass(receivers)
        # Ends the thread for callbacks after the last one.
        self._callbacks.put(sys.exit)

    def _pass(self, receivers: list[tuple[Receive, Answer]]) -> None:
        for receive, answer in receivers:
            receive(answer)

    def _write(self, line: bytes) -> None:
        try:
            self._socket.sendall(line)
        except OSError:
            raise Lost("the run has ended") from None

    def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        exchange = _Exchange()
        with self._lock:
            number, line = self._requests.open(request, exchange.put)
            self._write(line)
        try:
            return exchange.wait(exchange.answers.take, self._timeout)
        except TimeoutError:
            raise Silent(request, self._timeout) from None
        finally:
            with self._lock:
                self._requests.close(number)

    def _watch(self, path: str, receive: Receive) -> None:
        with self._lock:
            line = self._requests.watch(path, receive)
            if line is not None:
                self._write(line)

    def _unwatch(self, path: str, receive: Receive) -> None:
        with self._lock:
            self._requests.unwatch(path, receive)

    def _later(self, call: Callable[[], object]) -> None:
        """Calls a function in the thread for callbacks. There it may request services and wait."""
        with self._lock:
            if self._caller is None:
                self._caller = threading.Thread(target=self._call, daemon=True)
                self._caller.start()
        self._callbacks.put(call)

    def _call(self) -> None:
        while True:
            try:
                self._callbacks.get()()
            except Exception:
                traceback.print_exc()

    def _is_caller(self) -> bool:
        return self._caller is threading.current_thread()

    def _settle(self, timeout: float) -> None:
        """Waits for the callbacks of all answers that have come."""
        if self._caller is None or self._is_caller():
            return
        done = threading.Event()
        self._callbacks.put(done.set)
        until = time.monotonic() + timeout
        # The thread ends with the connection.
        while self._caller.is_alive() and time.monotonic() < until:
            if done.wait(min(0.01, timeout)):
                break

    def rpath(self, *_: str) -> None:
        """Does nothing: the run knows its components. Kept for scripts of genomix."""

    def load(self, name: str, **_: Any) -> Any:
        """Returns a `Component` of the run. `dotgen generate python` writes its type."""
        return Component(self, known(self._components, name))

    def violations(self) -> Iterator[dict[str, Any]]:
        """Yields the violations so far, then each one when it happens: see docs/socket.md.

        A repeated one comes again, at most once a second, with greater `times`. Raises `Lost` at the end of
        the run.
        """
        exchange = _Exchange()
        with self._lock:
            number, line = self._requests.open({"violations": None}, exchange.put)
            self._write(line)
        try:
            while True:
                answer = exchange.wait(exchange.answers.take)
                if answer["event"] == "violation":
                    yield violated(answer)
        finally:
            self._unsubscribe(number)

    def _unsubscribe(self, number: int) -> None:
        with self._lock:
            self._requests.close(number)
            try:
                self._write(self._requests.open({"abort": number}, lambda _: None)[1])
            except Lost:
                pass

    def components(self) -> list[str]:
        """Returns the names of the components."""
        return [each["name"] for each in self._components]

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


def connect(path: _Path | None = None, *, timeout: float | None = TIMEOUT) -> Connection:
    """Connects to a run: at the path of its socket, at `localhost:PORT`, or to the only run.

    If the run does not answer within `timeout` seconds, connecting, reads and writes raise `Silent`. None
    waits without limit.
    """
    if path is not None:
        return Connection(path, timeout)
    found: list[Connection] = []
    for each in sockets():
        try:
            found.append(Connection(each, timeout))
        except Silent:
            raise
        except Lost:
            continue
    try:
        only([connection._path for connection in found])
    except Wrong:
        for connection in found:
            connection.close()
        raise
    return found[0]
