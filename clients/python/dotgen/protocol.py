"""The protocol of docs/socket.md without input and output: shared by `dotgen` and `dotgen.aio`."""

from __future__ import annotations

import collections
import enum
import inspect
import itertools
import json
import keyword
import os
import pathlib
import stat
import tempfile
from collections.abc import Callable
from typing import Any, Optional

#: One answer of the run, or None at the end of the connection.
Answer = Optional["dict[str, Any]"]
Receive = Callable[[Answer], None]

# Values of a port, or violations, that a reader may lag behind. Beyond them, the oldest one is dropped.
_BEHIND = 10_000

#: Seconds in which a run must answer a request that it answers at once.
TIMEOUT = 5.0

# Names that mean this machine.
HERE = ("localhost", "127.0.0.1")


class Error(Exception):
    """Any error of this package."""


class Wrong(Error):
    """A request that cannot be made: an unknown service, or inputs that do not fit."""


class Lost(Error):
    """The end of the run, or of a component."""


class Failed(Error):
    """A service that was refused, was interrupted, or threw an exception."""

    def __init__(self, exception: str, detail: Any = None) -> None:
        super().__init__(exception if detail is None else f"{exception} {json.dumps(detail)}")
        #: Full name of the exception: `::pump::e_valve`.
        self.exception = exception
        #: Members of the exception by name, or None.
        self.detail = detail


class Silent(Lost, TimeoutError):
    """A run that does not answer: it is stopped, or the machine is overloaded."""

    def __init__(self, request: dict[str, Any], timeout: float | None) -> None:
        kind = next(iter(request))
        super().__init__(f"the run did not answer `{kind}` within {timeout} s: is its process stopped?")


class Answers:
    """The answers to one request, in order of arrival."""

    def __init__(self) -> None:
        self._all: collections.deque[dict[str, Any]] = collections.deque()
        self._over = False

    def put(self, answer: Answer) -> None:
        """Adds an answer. None ends the answers."""
        if answer is None:
            self._over = True
            return
        if answer["event"] in ("data", "violation") and len(self._all) > _BEHIND:
            self._all.popleft()
        self._all.append(answer)

    def take(self) -> dict[str, Any] | None:
        """Removes and returns the oldest answer. None: it has not come yet."""
        if not self._all:
            self._check_end()
            return None
        return _checked(self._all.popleft())

    def find(self, *events: str) -> dict[str, Any] | None:
        """Returns the first answer of some kinds, and keeps it. None: it has not come yet."""
        found = self.seen(*events, "error")
        if found is None:
            self._check_end()
            return None
        return _checked(found)

    def seen(self, *events: str) -> dict[str, Any] | None:
        """Returns the first answer of some kinds, if it has come. Never raises."""
        return next((answer for answer in self._all if answer["event"] in events), None)

    def status(self) -> str:
        """Returns `sent`, `running`, `done` or `failed`, for the request of a service."""
        if self.seen("done") is not None:
            return "done"
        if self._over or self.seen("failed", "error") is not None:
            return "failed"
        return "running" if self.seen("accepted") else "sent"

    def ended(self) -> dict[str, Any] | None:
        """Returns the answer that ended a service. None: it goes on. Raises `Failed` if it failed."""
        return _succeeded(self.find("done", "failed"))

    def begun(self) -> dict[str, Any] | None:
        """Returns the first answer of a service. None: it is not accepted yet. Raises `Failed` if it failed."""
        return _succeeded(self.find("accepted", "done", "failed"))

    def _check_end(self) -> None:
        if self._over:
            raise Lost("the run has ended")


def _checked(answer: dict[str, Any]) -> dict[str, Any]:
    if answer["event"] == "error":
        raise Wrong(answer["message"])
    return answer


def _succeeded(answer: dict[str, Any] | None) -> dict[str, Any] | None:
    if answer is not None and answer["event"] == "failed":
        raise Failed(answer["exception"], answer.get("detail"))
    return answer


class Requests:
    """The open requests of a connection, and who receives their answers."""

    def __init__(self) -> None:
        self._next = itertools.count(1)
        self._open: dict[int, Receive] = {}
        # Readers of each watched port: the run sends a port once, to however many readers.
        self._watched: dict[str, list[Receive]] = {}
        self._over = False

    def open(self, request: dict[str, Any], receive: Receive) -> tuple[int, bytes]:
        """Opens a request. Returns its number, and the line to send."""
        if self._over:
            raise Lost("the run has ended")
        number = next(self._next)
        try:
            # A run reads `null` as zero: NaN must not become `null`.
            line = json.dumps({"id": number, **request}, allow_nan=False, default=_plain)
        except TypeError as error:
            raise Wrong(f"cannot be sent: {error}") from None
        except ValueError:
            raise Wrong("NaN and infinity cannot be sent") from None
        self._open[number] = receive
        return number, line.encode() + b"\n"

    def close(self, number: int) -> None:
        """Forgets a request: later answers are dropped."""
        self._open.pop(number, None)

    def watch(self, path: str, receive: Receive) -> bytes | None:
        """Adds a reader of a port. Returns the line to send, if no request watches this port yet."""
        readers = self._watched.get(path)
        if readers is not None and not self._over:
            readers.append(receive)
            return None
        readers = [receive]

        def spread(answer: Answer) -> None:
            if answer is None or answer["event"] in ("lost", "error"):
                self._watched.pop(path, None)
            for reader in list(readers):
                reader(answer)

        line = self.open({"watch": path}, spread)[1]
        self._watched[path] = readers
        return line

    def unwatch(self, path: str, receive: Receive) -> None:
        """Removes a reader of a port.

        The run goes on sending the port: the protocol has no request that ends `watch`.
        """
        readers = self._watched.get(path, [])
        if receive in readers:
            readers.remove(receive)

    def receive(self, line: bytes) -> list[tuple[Receive, Answer]]:
        """Reads a line of the run. Returns the answer with its receivers."""
        answer = json.loads(line)
        number = answer.get("id")
        if number is None:
            # A line that was not understood can belong to any request.
            return [(receive, answer) for receive in self._open.values()]
        found = self._open.get(number)
        if answer["event"] in ("done", "failed", "error"):
            self.close(number)
        return [] if found is None else [(found, answer)]

    def end(self) -> list[tuple[Receive, Answer]]:
        """Ends all requests. Returns their receivers."""
        self._over = True
        return [(receive, None) for receive in self._open.values()]


class Input:
    """An input of a service."""

    def __init__(self, description: dict[str, Any]) -> None:
        #: Name of the parameter.
        self.name: str = description["name"]
        #: JSON Schema of its values. An empty schema accepts any value.
        self.schema: dict[str, Any] = description.get("schema") or {}
        #: Default of the specification, or None.
        self.default: Any = description.get("default")

    def __repr__(self) -> str:
        return self.name if self.default is None else f"{self.name}={self.default!r}"


class Inlet:
    """An input port as the run describes it."""

    def __init__(self, component: str, description: dict[str, Any]) -> None:
        #: Name of the port, and its path: `pump/flow`.
        self.name: str = description["name"]
        self.path = f"{component}/{self.name}"
        #: JSON Schema of its values.
        self.schema: dict[str, Any] = description.get("schema") or {}

    def request(self, value: Any, instance: str) -> dict[str, Any]:
        """Returns the request that writes a value."""
        named = {"instance": instance} if instance else {}
        return {"write": self.path, "value": fit(value, self.schema), **named}


class Signature:
    """A service as the run describes it: its inputs and outputs."""

    def __init__(self, component: str, description: dict[str, Any]) -> None:
        #: Name of the service, and its path: `pump.fill`.
        self.name: str = description["name"]
        self.path = f"{component}.{self.name}"
        #: `attribute`, `function` or `activity`.
        self.kind: str = description.get("kind", "function")
        self.doc: str | None = description.get("doc")
        #: Inputs in order, and names of outputs.
        self.inputs = [Input(each) for each in description["inputs"]]
        self.outputs: list[str] = list(description.get("outputs", []))

    def __repr__(self) -> str:
        return f"{self.path}({', '.join(map(repr, self.inputs))})"

    def request(self, args: tuple[Any, ...], named: dict[str, Any]) -> dict[str, Any]:
        """Returns the request, for inputs in order, by name, or in one dictionary by names."""
        names = [each.name for each in self.inputs]
        given = dict(named)
        if self._is_dictionary(args, named):
            given = dict(args[0])
        elif len(args) > len(names):
            raise Wrong(f"{self.path} has {len(names)} inputs: {', '.join(names)}")
        else:
            for name, value in zip(names, args):
                if name in given:
                    raise Wrong(f"{self.path} was given `{name}` twice")
                given[name] = value
        schemas = {each.name: each.schema for each in self.inputs}
        # The run refuses unknown names, and says which ones it knows.
        values = {name: fit(value, schemas.get(name, {})) for name, value in given.items()}
        return {"call": self.path, "input": values}

    def options(
        self, args: tuple[Any, ...], named: dict[str, Any], options: dict[str, Any]
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Separates options of a call from inputs. Returns inputs by name, and all options.

        An option with the name of an input is that input, unless one dictionary has all inputs.
        """
        free = {each.name for each in self.inputs}
        if self._is_dictionary(args, {}):
            free = set()
        chosen = {name: named.get(name, default) for name, default in options.items() if name not in free}
        inputs = {name: value for name, value in named.items() if name not in chosen}
        return inputs, {**options, **chosen}

    def text(self) -> str:
        """Returns the documentation of the specification, for `help()`."""
        lines = [f"{self}: {self.kind}", *([self.doc] if self.doc else [])]
        for each in self.inputs:
            if "description" in each.schema:
                lines.append(f"{each.name}: {each.schema['description']}")
        return "\n".join([*lines, f"Outputs: {', '.join(self.outputs) or 'none'}"])

    def python(self) -> inspect.Signature | None:
        """Returns the signature for `help()` and completion, if Python can write all names."""
        names = [each.name for each in self.inputs]
        if any(keyword.iskeyword(name) or name == "ack" for name in names):
            return None
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        parameters = [inspect.Parameter(each.name, kind, default=each.default) for each in self.inputs]
        ack = inspect.Parameter("ack", inspect.Parameter.KEYWORD_ONLY, default=False)
        return inspect.Signature([*parameters, ack])

    def _is_dictionary(self, args: tuple[Any, ...], named: dict[str, Any]) -> bool:
        one = len(args) == 1 and isinstance(args[0], dict) and not named
        return one and set(args[0]) <= {each.name for each in self.inputs}


def fit(value: Any, schema: dict[str, Any]) -> Any:
    """Returns the JSON of a value, as the schema of an input wants it.

    0 and 1 are accepted for booleans, whole floats for integers, tuples and arrays of numpy for lists, and
    enumerators of Python by name. Values without a schema are passed on.
    """
    value = _plain(value, keep=True)
    # The first is the type of an optional value, or the names of an enumeration.
    schema = schema.get("anyOf", [schema])[0]
    kinds = schema.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if isinstance(value, dict):
        members = schema.get("properties", {})
        return {key: fit(each, members.get(key, {})) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [fit(each, schema.get("items", {})) for each in value]
    if isinstance(value, bool):
        return int(value) if "integer" in kinds or "number" in kinds else value
    if isinstance(value, (int, float)):
        if "boolean" in kinds and value in (0, 1):
            return bool(value)
        if isinstance(value, float) and "integer" in kinds and value.is_integer():
            return int(value)
    return value


def _plain(value: Any, keep: bool = False) -> Any:
    """Returns what JSON can contain: numbers and lists of numpy, names of enumerators, lists of octets."""
    if isinstance(value, enum.Enum) and not isinstance(value, (int, str)):
        return value.name
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if not isinstance(value, (int, float)) or type(value).__module__ == "numpy":
        convert = getattr(value, "tolist", None)
        if callable(convert):
            return convert()
    if keep:
        return value
    raise TypeError(f"{type(value).__name__} {value!r}")


def outputs(answer: dict[str, Any]) -> Any:
    """Returns the outputs of a service: one as a value, several as a dictionary, or None."""
    found = answer["output"]
    if isinstance(found, dict) and len(found) == 1:
        return next(iter(found.values()))
    return found or None


def violated(answer: dict[str, Any]) -> dict[str, Any]:
    """Returns a violation as in the report of a run, with `what` in words, and the `unit` of its times."""
    return {"what": answer["what"], "unit": answer["unit"], **answer["violation"]}


def known(components: list[dict[str, Any]], name: str) -> dict[str, Any]:
    """Returns the description of a component."""
    for each in components:
        if each["name"] == name:
            return each
    names = [each["name"] for each in components]
    raise Wrong(f"no component `{name}` in this run; {_all(names)}")


def ports(description: dict[str, Any], direction: str) -> list[str]:
    """Returns the names of the ports of a component: those that go `in` or `out`."""
    return [each["name"] for each in description["ports"] if each["direction"] == direction]


def inlets(description: dict[str, Any]) -> list[Inlet]:
    """Returns the input ports of a component."""
    own = [each for each in description["ports"] if each["direction"] == "in"]
    return [Inlet(description["name"], each) for each in own]


def inlet(description: dict[str, Any], name: str) -> Inlet:
    """Returns an input port of a component."""
    own = inlets(description)
    for each in own:
        if each.name == name:
            return each
    component = description["name"]
    if name in ports(description, "out"):
        raise Wrong(f"`{component}/{name}` is an output port: only its component writes it")
    raise Wrong(f"`{component}` has no input port `{name}`; {_all([each.name for each in own])}")


def missing(description: dict[str, Any], name: str, names: list[str]) -> str:
    """Returns the message for an attribute that a component does not have."""
    component = description["name"]
    if name in ports(description, "in"):
        return f"`{component}/{name}` is an input port: use `{component}.connect_port`"
    return f"`{component}` has no `{name}`; {_all(names)}"


def _all(names: list[str]) -> str:
    quoted = [f"`{name}`" for name in names]
    if len(quoted) < 2:
        return f"the only one is {quoted[0]}" if quoted else "there are none"
    return f"there are {', '.join(quoted)}"


def summary(description: dict[str, Any]) -> str:
    """Returns a component in one line."""
    services = ", ".join(each["name"] for each in description["services"])
    own = (("ports", ports(description, "out")), ("input ports", ports(description, "in")))
    rest = "".join(f"; {kind} {', '.join(names)}" for kind, names in own if names)
    return f"<Component {description['name']}: services {services}{rest}>"


class Described:
    """A component with a member for each of its services and ports, as its description names them."""

    def __init__(self, description: dict[str, Any]) -> None:
        self._description = description
        self.__doc__ = description.get("doc")

    def __repr__(self) -> str:
        return summary(self._description)

    def __dir__(self) -> list[str]:
        return sorted(name for name in self.__dict__ if not name.startswith("_"))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise AttributeError(missing(self._description, name, self.__dir__()))


def tcp_port(path: str | os.PathLike[str]) -> int | None:
    """Returns the port of `localhost:PORT`, or None for the path of a socket."""
    host, _, port = os.fspath(path).rpartition(":")
    return int(port) if host in HERE and port.isdecimal() else None


def _folder() -> pathlib.Path:
    """Returns the folder with the sockets and tokens of runs of this user."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime:
        return pathlib.Path(runtime) / "dotgen"
    return pathlib.Path(tempfile.gettempdir()) / f"dotgen-{os.getuid()}"


def token(port: int) -> bytes:
    """Returns the line that a client sends first to a TCP port: empty if the run serves all users."""
    try:
        text = (_folder() / f"{port}.token").read_text(encoding="ascii")
    except OSError:
        return b""
    return json.dumps({"token": text}).encode() + b"\n"


def sockets() -> list[pathlib.Path]:
    """Returns the sockets of runs of this user. A killed run can have left one behind."""
    folder = _folder()
    try:
        info = folder.lstat()
        private = stat.S_ISDIR(info.st_mode) and info.st_uid == os.getuid()
        return sorted(folder.glob("*.sock")) if private else []
    except OSError:
        return []


def only(found: list[str]) -> None:
    """Checks that one run listens."""
    if not found:
        raise Lost("nothing runs; start it with `dotgen run --clock real FILE`")
    if len(found) > 1:
        raise Wrong(f"several runs; choose one: {', '.join(found)}")
