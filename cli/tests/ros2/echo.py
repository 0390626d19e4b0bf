"""The component `echo` as a node, at a router in this process. Prints where it is."""
import os
import struct
import subprocess
import sys
from pathlib import Path

from peer import BOUND, Peer, check, session, statuses, text

router = session("router", listen=sys.argv[1])
print("router", flush=True)
peer = Peer(sys.argv[1])
COUNT = "/echo/count/_action/"
LONG = 1 << 30


def goal(name, n):
    name = name.encode().ljust(16, b"-")
    return name, peer.ask(COUNT + "send_goal", name + struct.pack("<i", n))[0]


def result(name):
    """Status, output and exception."""
    payload = peer.ask(COUNT + "get_result", name)
    return [payload[0], struct.unpack_from("<i", payload, 4)[0], text(payload, 8)]


def cancel(name):
    """The code, and the goals that are cancelled."""
    payload = peer.ask(COUNT + "cancel_goal", name + bytes(8))
    return payload[0], struct.unpack_from("<I", payload, 4)[0]


# A topic that is `multiple`: its instance has a topic of its own, with the type of ROS 2.
HASH = "RIHS01_b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb"
check("key", peer.key("/echo/each/a"), f"7/echo/each/a/std_msgs::msg::dds_::Int32_/{HASH}")
got, subscriber = peer.read("/echo/each/a")
peer.soon("data", lambda: len(got) > 2)
check("data", got[0][0], struct.pack("<i", 70))
numbers = [struct.unpack_from("<q", it[1])[0] for it in got[:3]]
check("numbers", numbers, list(range(numbers[0], numbers[0] + 3)))
check("node", peer.soon("node", lambda: peer.nodes.get("echo"))[:2], ["@ros2_lv", "7"])

# Services.
check("get_gain", peer.ask("/echo/get_gain", b"\0")[:4], struct.pack("<i", 7))
check("set_gain", text(peer.ask("/echo/set_gain", struct.pack("<i", 9)), 0), "")
check("get_gain", peer.ask("/echo/get_gain", b"\0")[:4], struct.pack("<i", 9))
check("set_gain", text(peer.ask("/echo/set_gain", struct.pack("<i", -1)), 0), "::echo::e_plain")
failed = peer.ask("/echo/fail", struct.pack("<h", 5))
check("fail", text(failed, 0), "::echo::e_bad")
check("code", struct.unpack("<Ih", failed[20:26]), (1, 5))

# Malformed requests get an error each, and the component goes on.
for given in [
    {"attachment": None}, {"attachment": b"short"}, {"payload": b""}, {"payload": b"\0\1\0\0\1"},
    {"payload": b"\0" * (5 << 20)},
]:
    for topic in ["/echo/set_gain", COUNT + "send_goal", COUNT + "get_result", COUNT + "cancel_goal"]:
        found = peer.ask(topic, b"", **given)
        assert isinstance(found, str), (topic, given, found)
check("get_gain", peer.ask("/echo/get_gain", b"\0")[:4], struct.pack("<i", 9))

# Actions.
seen, status_subscriber = peer.read(COUNT + "status")
states, state_subscriber = peer.read(COUNT + "feedback")


def status(name):
    """The last status of a goal."""
    return statuses(seen[-1][0]).get(name) if seen else None


def feedback(name):
    return [text(it[0], 16) for it in states if it[0][:16] == name]


name, accepted = goal("short", 3)
check("accepted", accepted, 1)
check("result", result(name), [4, 3, ""])
peer.soon("done", lambda: status(name) == 4)
check("feedback", peer.soon("feedback", lambda: feedback(name)), ["start"])
check("again", goal("short", 3)[1], 0)
check("known", result(name), [4, 3, ""])
check("unknown", result(b"?" * 16), [0, 0, ""])
name, accepted = goal("wrong", -1)
check("accepted", accepted, 1)
check("exception", result(name)[0], 6)
name, _ = goal("long", LONG)
peer.soon("executing", lambda: status(name) == 2 and feedback(name) == ["start"])
check("canceling", cancel(name), (0, 1))
check("canceled", result(name), [5, -1, ""])
peer.soon("canceled", lambda: status(name) == 5)
check("feedback", peer.soon("stop", lambda: feedback(name)[1:] and feedback(name)), ["start", "stop"])
check("too late", cancel(name)[0], 3)
check("nobody", cancel(b"?" * 16)[0], 2)

# Who subscribes later reads the last message of a latched topic.
late, late_subscriber = peer.read(COUNT + "status", latched=True)
check("latched", statuses(peer.soon("latched", lambda: late and late[0])[0])[name], 5)

# A client dies while its goal is executed. The goal goes on, and others can cancel it.
CLIENT = f"""
from peer import Peer
import struct, sys
peer, name = Peer(sys.argv[1]), b"dying".ljust(16, b"-")
peer.ask("{COUNT}send_goal", name + struct.pack("<i", {LONG}))
replies = peer.request("{COUNT}get_result", name)
print("waits", flush=True)
sys.stdin.read()
"""
words = [sys.executable, "-c", CLIENT, sys.argv[1]]
here = Path(__file__).parent
client = subprocess.Popen(words, cwd=here, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
check("client", client.stdout.readline(), b"waits\n")
client.kill()
client.wait(BOUND)
name = b"dying".ljust(16, b"-")
peer.soon("goes on", lambda: status(name) == 2 and feedback(name))
check("all", cancel(bytes(16)), (0, 1))
check("canceled", result(name), [5, -1, ""])

# Many goals at once: each is accepted or refused, and each accepted one has a result.
names = [f"many{it}".encode().ljust(16, b"-") for it in range(100)]
asked = [peer.request(COUNT + "send_goal", it + struct.pack("<i", 3)) for it in names]
accepted = [next(iter(it)).ok.payload for it in asked]
accepted = [name for name, payload in zip(names, accepted) if bytes(payload)[4]]
asked = [peer.request(COUNT + "get_result", it) for it in accepted]
results = [bytes(next(iter(it)).ok.payload)[4] for it in asked]
check("many", (len(accepted), set(results) <= {4, 6}, 4 in results), (100, True, True))
check("get_gain", peer.ask("/echo/get_gain", b"\0")[:4], struct.pack("<i", 9))
print("seen", flush=True)

# The run is killed: its node leaves the graph.
sys.stdin.readline()
peer.soon("the node is still there", lambda: not peer.nodes and not peer.endpoints)
print("gone", flush=True)
# The end of the interpreter would wait for threads of Zenoh.
os._exit(0)
