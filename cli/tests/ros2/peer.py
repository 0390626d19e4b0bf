"""A ROS 2 peer of plain Zenoh and CDR: the session, keys, requests and topics."""
import faulthandler
import json
import os
import struct
import sys
import threading
import time

import zenoh
import zenoh.ext

# Bound of each wait, in seconds. Reached only by a failure.
BOUND = 30
DOMAIN = 7


def fail(kind, error, trace):
    sys.__excepthook__(kind, error, trace)
    sys.stderr.flush()
    # Threads of Zenoh would keep the process.
    os._exit(1)


sys.excepthook = fail
faulthandler.dump_traceback_later(10 * BOUND, exit=True)


def check(what, found, expected):
    assert found == expected, f"{what}: {found}, not {expected}"


def session(mode, **endpoints):
    """A session without discovery."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("scouting/multicast/enabled", "false")
    for what in ["listen", "connect"]:
        config.insert_json5(f"{what}/endpoints", json.dumps([it for it in [endpoints.get(what)] if it]))
    return zenoh.open(config)


def text(payload, at):
    (length,) = struct.unpack_from("<I", payload, at)
    return payload[at + 4:at + 3 + length].decode()


class Peer:
    """A client of a router."""

    def __init__(self, endpoint):
        self.session = session("client", connect=endpoint)
        self.gid, self.sent = os.urandom(16), 0
        self.changed = threading.Condition()
        # The words of tokens: of nodes by name, of endpoints by topic.
        self.nodes, self.endpoints = {}, {}
        tokens = f"@ros2_lv/{DOMAIN}/**"
        liveliness = self.session.liveliness()
        self.watch = liveliness.declare_subscriber(tokens, self.token, history=True)

    def token(self, sample):
        """`@ros2_lv/DOMAIN/SESSION/NODE/ID/KIND/%/%/NAME/TOPIC/TYPE/HASH/QOS`"""
        words = str(sample.key_expr).split("/")
        is_node = words[5] == "NN"
        of, name = (self.nodes, words[8]) if is_node else (self.endpoints, words[9].replace("%", "/"))
        with self.changed:
            if sample.kind == zenoh.SampleKind.DELETE:
                of.pop(name, None)
            else:
                of[name] = words
            self.changed.notify_all()

    def note(self, _):
        """Something that `soon` waits for may have changed."""
        with self.changed:
            self.changed.notify_all()

    def soon(self, what, found):
        """Waits until `found` returns something true."""
        with self.changed:
            assert self.changed.wait_for(found, BOUND), what
            return found()

    def key(self, topic):
        words = self.soon(topic, lambda: self.endpoints.get(topic))
        return "/".join([words[1], topic[1:], words[10], words[11]])

    def attachment(self):
        self.sent += 1
        return struct.pack("<qqB", self.sent, time.time_ns(), 16) + self.gid

    def request(self, topic, body, **more):
        """The replies to come."""
        given = {"attachment": self.attachment(), "payload": b"\0\1\0\0" + body, "timeout": BOUND} | more
        return self.session.get(self.key(topic), target=zenoh.QueryTarget.ALL_COMPLETE, **given)

    def ask(self, topic, body, **more):
        """The payload after its header, or the text of the error."""
        (reply,) = self.request(topic, body, **more)
        if reply.err is not None:
            return bytes(reply.err.payload).decode()
        number, _, length = struct.unpack_from("<qqB", bytes(reply.ok.attachment))
        check("number", (number, length), (self.sent, 16))
        check("sender", bytes(reply.ok.attachment)[17:], self.gid)
        return bytes(reply.ok.payload)[4:]

    def read(self, topic, latched=False):
        """Messages of a topic, from now on: payload after the header, and attachment. A latched topic begins
        with its last message."""
        got = []

        def hear(sample):
            with self.changed:
                got.append((bytes(sample.payload)[4:], bytes(sample.attachment)))
                self.changed.notify_all()

        key = self.key(topic)
        if latched:
            history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
            subscriber = zenoh.ext.declare_advanced_subscriber(self.session, key, hear, history=history)
        else:
            subscriber = self.session.declare_subscriber(key, hear)
        return got, subscriber


def statuses(payload):
    """The status of each goal."""
    out, at, (count,) = {}, 4, struct.unpack_from("<I", payload)
    for _ in range(count):
        # The time after the identifier is aligned, the identifier is not.
        end = (at + 16 + 3) // 4 * 4 + 8
        out[payload[at:at + 16]], at = payload[end], end + 1
    return out
