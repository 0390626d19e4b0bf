"""Ports of a run, reached by the Python package of Zenoh."""

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
