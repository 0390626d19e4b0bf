"""The component `reader` as a node of a run that is the router. Its input ports read topics of a peer."""
import os
import struct
import sys

from peer import Peer

peer, other = Peer(sys.argv[1]), Peer(sys.argv[1])


def publisher(key):
    """A publisher whose messages reach the run."""
    out = peer.session.declare_publisher(key)
    listener = out.declare_matching_listener(peer.note)
    peer.soon(key, lambda: out.matching_status.matching)
    return out, listener


def write(to, payload):
    to.put(payload, attachment=peer.attachment())


trail, trail_listener = publisher(peer.key("/reader/trail"))
seen, seen_subscriber = peer.read("/reader/seen")
# A topic for each instance of a port that is `multiple`.
words = peer.key("/reader/sum").split("/")
each, each_listener = publisher("/".join([words[0], "reader/each/a", *words[3:]]))
total, total_subscriber = peer.read("/reader/sum")

# Malformed messages are ignored.
for wrong in [b"", b"\0\1\0\0", b"\0\1\0\0\xff\xff\xff\xff", b"\0" * (5 << 20)]:
    write(trail, wrong)
write(trail, b"\0\1\0\0" + struct.pack("<I4x4d", 2, 1, 2, 3, 4))
peer.soon("trail", lambda: seen and seen[-1][0] == struct.pack("<I4x4d", 2, 3, 4, 1, 2))
write(each, b"\0\1\0\0" + struct.pack("<i", 41))
peer.soon("each", lambda: total and total[-1][0] == struct.pack("<i", 42))

# Two nodes that know this router only find each other.
friend = peer.session.liveliness().declare_token("@ros2_lv/7/a/0/0/NN/%/%/friend")
other.soon("friend", lambda: other.nodes.get("friend"))
print("seen", flush=True)
# The end of the interpreter would wait for threads of Zenoh.
os._exit(0)
