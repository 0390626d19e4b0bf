"""A ROS 2 peer of plain Zenoh and CDR, for the components `echo` and `reader`. Prints what it has seen."""
import json
import os
import struct
import sys
import threading
import time

import zenoh

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("scouting/multicast/enabled", "false")
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
session = zenoh.open(config)
gid, sent = os.urandom(16), 0
endpoints, gone = {}, threading.Event()


def token(sample):
    """`@ros2_lv/DOMAIN/SESSION/NODE/ID/KIND/%/%/NAME/TOPIC/TYPE/HASH/QOS`"""
    words = str(sample.key_expr).split("/")
    if sample.kind == zenoh.SampleKind.DELETE:
        gone.set()
    elif words[5] != "NN":
        endpoints[words[9].replace("%", "/")] = words


def soon(what, check):
    until = time.monotonic() + 30
    while not (found := check()):
        assert time.monotonic() < until, what
        threading.Event().wait(0.02)
    return found


def key(topic):
    words = soon(topic, lambda: endpoints.get(topic))
    return "/".join([words[1], topic[1:], words[10], words[11]])


def attachment():
    global sent
    sent += 1
    return struct.pack("<qqB", sent, time.time_ns(), 16) + gid


def ask(topic, body, **more):
    """The payload after its header, or the text of the error."""
    given = {"attachment": attachment(), "payload": b"\0\1\0\0" + body, "timeout": 20} | more
    (reply,) = session.get(key(topic), target=zenoh.QueryTarget.ALL_COMPLETE, **given)
    if reply.err is not None:
        return bytes(reply.err.payload).decode()
    number, _, length = struct.unpack_from("<qqB", bytes(reply.ok.attachment))
    assert (number, length) == (sent, 16) and bytes(reply.ok.attachment)[17:] == gid
    return bytes(reply.ok.payload)[4:]


def exception(payload, at):
    (length,) = struct.unpack_from("<I", payload, at)
    return payload[at + 4:at + 3 + length].decode()


def goal(name, n):
    name = name.encode().ljust(16, b"-")
    return name, ask("/echo/count/_action/send_goal", name + struct.pack("<i", n))[0]


def result(name):
    """Status, output and exception."""
    payload = ask("/echo/count/_action/get_result", name)
    return [struct.unpack_from("b", payload)[0], struct.unpack_from("<i", payload, 4)[0], exception(payload, 8)]


def check(what, found, expected):
    assert found == expected, f"{what}: {found}, not {expected}"


def fail(kind, error, trace):
    sys.__excepthook__(kind, error, trace)
    sys.stderr.flush()
    # Threads of Zenoh would keep the process.
    os._exit(1)


sys.excepthook = fail
watch = session.liveliness().declare_subscriber("@ros2_lv/7/**", token, history=True)
# A topic that is `multiple`: its instance has a topic of its own, with the type of ROS 2.
got, heard = [], threading.Event()


def hear(sample):
    got.append((bytes(sample.payload), bytes(sample.attachment)))
    if len(got) > 2:
        heard.set()


HASH = "RIHS01_b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb"
check("key", key("/echo/each/a"), f"7/echo/each/a/std_msgs::msg::dds_::Int32_/{HASH}")
subscriber = session.declare_subscriber(key("/echo/each/a"), hear)
assert heard.wait(30), "no data"
check("data", got[0][0], b"\0\1\0\0" + struct.pack("<i", 70))
numbers = [struct.unpack_from("<q", it[1])[0] for it in got[:3]]
check("numbers", numbers, list(range(numbers[0], numbers[0] + 3)))

# Services.
check("get_gain", ask("/echo/get_gain", b"\0")[:4], struct.pack("<i", 7))
check("set_gain", exception(ask("/echo/set_gain", struct.pack("<i", 9)), 0), "")
check("get_gain", ask("/echo/get_gain", b"\0")[:4], struct.pack("<i", 9))
check("set_gain", exception(ask("/echo/set_gain", struct.pack("<i", -1)), 0), "::echo::e_plain")
failed = ask("/echo/fail", struct.pack("<h", 5))
check("fail", exception(failed, 0), "::echo::e_bad")
check("code", struct.unpack("<Ih", failed[20:26]), (1, 5))

# Malformed requests get an error each, and the component goes on.
for given in [
    {"attachment": None}, {"attachment": b"short"}, {"payload": b""}, {"payload": b"\0\1\0\0\1"},
    {"payload": b"\0" * (5 << 20)},
]:
    for topic in ["/echo/set_gain", "/echo/count/_action/send_goal", "/echo/count/_action/cancel_goal"]:
        found = ask(topic, b"", **given)
        assert isinstance(found, str), (topic, given, found)

# Actions.
statuses = {}


def status(sample):
    payload = bytes(sample.payload)[4:]
    at, (count,) = 4, struct.unpack_from("<I", payload)
    for _ in range(count):
        # The time after the identifier is aligned, the identifier is not.
        end = (at + 16 + 3) // 4 * 4 + 8
        statuses.setdefault(payload[at:at + 16], []).append(payload[end])
        at = end + 1


topics = session.declare_subscriber(key("/echo/count/_action/status"), status)
name, accepted = goal("short", 3)
check("accepted", accepted, 1)
check("result", result(name), [4, 3, ""])
check("again", goal("short", 3)[1], 0)
check("known", result(name), [4, 3, ""])
check("unknown", result(b"?" * 16), [0, 0, ""])
name, _ = goal("long", 1 << 30)
soon("executing", lambda: 2 in statuses.get(name, []))
canceled = ask("/echo/count/_action/cancel_goal", name + bytes(8))
check("canceling", (canceled[0], canceled[4], canceled[8:24]), (0, 1, name))
check("canceled", result(name), [5, 0, "::genom::interrupted"])
check("too late", ask("/echo/count/_action/cancel_goal", name + bytes(8))[0], 3)
check("nobody", ask("/echo/count/_action/cancel_goal", b"?" * 16 + bytes(8))[0], 2)
soon("status", lambda: statuses[name][-1] == 5)

nodes = session.liveliness().get("@ros2_lv/7/*/*/*/NN/%/%/*")
check("nodes", [str(it.ok.key_expr).split("/")[8] for it in nodes], ["echo"])
print("seen", flush=True)
# The run ends: so does its node.
sys.stdin.readline()
assert gone.wait(30), "the node is still there"
print("gone", flush=True)
