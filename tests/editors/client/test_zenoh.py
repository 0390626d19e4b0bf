"""Ports of a run, reached by the Python package of Zenoh."""

import json
import os
import socket
import struct
import subprocess
import threading

import pytest
import zenoh

from hosted import lay_out

LITTLE_ENDIAN = bytes([0, 1, 0, 0])


def free_endpoint() -> str:
    with socket.socket() as it:
        it.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{it.getsockname()[1]}"


@pytest.fixture
def joined(tmp_path):
    """A session of Zenoh next to a run of a component."""
    sessions = []

    def join(name: str) -> zenoh.Session:
        lay_out(tmp_path, name)
        endpoint = free_endpoint()
        command = [os.environ["DOTGEN"], "run", f"{name}/{name}.gen", "--clock", "real"]
        command += ["--bounds", "none", "--until", "60s", "--socket", f"{name}.sock"]
        command += ["--zenoh-listen", endpoint]
        run = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
        sessions.append(run)
        said = ""
        for line in run.stderr:
            said += line
            if "listening at" in line:
                break
        assert "listening at" in said, said
        threading.Thread(target=run.stderr.read, daemon=True).start()
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", f'["{endpoint}"]')
        session = zenoh.open(config)
        sessions.append(session)
        return session

    yield join
    for it in reversed(sessions):
        it.close() if isinstance(it, zenoh.Session) else it.kill()
    for it in sessions:
        if not isinstance(it, zenoh.Session):
            it.wait()


def test_an_output_port_is_a_key_with_cdr(joined):
    heard = {}
    complete = threading.Event()

    def hear(sample):
        heard[str(sample.key_expr)] = (bytes(sample.payload), str(sample.encoding))
        if {"echo/trail", "echo/each/a"} <= heard.keys():
            complete.set()

    session = joined("echo")
    subscriber = session.declare_subscriber("echo/**", hear)
    assert complete.wait(20), heard.keys()
    subscriber.undeclare()
    each, encoding = heard["echo/each/a"]
    assert (each, encoding) == (LITTLE_ENDIAN + struct.pack("<i", 70), "application/cdr;m::number")
    trail, _ = heard["echo/trail"]
    (count,) = struct.unpack_from("<I", trail, 4)
    # Doubles are aligned to eight bytes, counted from behind the header.
    assert len(trail) == 4 + 8 + count * 16


def test_an_input_port_reads_what_is_published(joined):
    session = joined("reader")
    points = [(1.0, 2.0), (3.0, -4.0)]
    sent = LITTLE_ENDIAN + struct.pack("<I4x", len(points))
    sent += b"".join(struct.pack("<dd", *it) for it in points)
    wanted = sent[:12] + b"".join(struct.pack("<dd", *it) for it in reversed(points))
    complete = threading.Event()

    def hear(sample):
        if bytes(sample.payload) == wanted:
            complete.set()

    subscriber = session.declare_subscriber("reader/seen", hear)
    publisher = session.declare_publisher("other/trail")
    for _ in range(200):
        publisher.put(b"what is no CDR")
        publisher.put(sent)
        if complete.wait(0.1):
            break
    assert complete.is_set()
    subscriber.undeclare()


def test_services_are_requested_with_json(joined):
    session = joined("echo")

    def ask(key, **more):
        replies = list(session.get(key, timeout=20, **more))
        assert len(replies) == 1, replies
        reply = replies[0]
        answer = reply.ok or reply.err
        assert str(answer.encoding) == "application/json"
        return reply.ok is not None, json.loads(answer.payload.to_string())

    def done(output):
        return True, {"event": "done", "output": output, "version": 1}

    assert ask("echo/set_gain", payload='{"gain": 9}') == done({})
    assert ask("echo/get_gain") == done({"gain": 9})
    # The acceptance of an activity is replaced by its end.
    assert ask("echo/count", payload='{"n": 3}') == done({"seen": 3})
    everything = session.get("echo/count", consolidation=zenoh.ConsolidationMode.NONE, timeout=20)
    events = [json.loads(it.ok.payload.to_string())["event"] for it in everything]
    assert events == ["accepted", "done"]
    is_fine, failed = ask("echo/fail", payload='{"code": 3}')
    assert is_fine and failed["event"] == "failed"
    assert (failed["exception"], failed["detail"]) == ("::echo::e_bad", {"code": 3})
    for key, payload, why in [
        ("echo/get_gain", "what is no JSON", "not JSON"),
        ("echo/get_gain", b"\xff\xfe", "not JSON"),
        ("echo/get_gain", "[" * 100_000, "not JSON"),
        ("echo/get_gain", " " * (5 << 20), "at most 4 MiB"),
        ("echo/set_gain", '{"gain": {}}', "echo.set_gain"),
        ("*/get_gain", "{}", "request one service"),
    ]:
        is_fine, refused = ask(key, payload=payload)
        assert not is_fine and refused["event"] == "error" and refused["version"] == 1
        assert why in refused["message"]
    # More activities than the component has room for hold up nothing else.
    refused = threading.Event()

    def hear(reply):
        if reply.ok and json.loads(reply.ok.payload.to_string()).get("exception") == "::genom::disallowed":
            refused.set()

    for _ in range(300):
        session.get("echo/count", hear, payload='{"n": 100000000}', timeout=60)
    assert refused.wait(20)
    assert ask("echo/get_gain") == done({"gain": 9})
