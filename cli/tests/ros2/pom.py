"""The component `pom`, whose ports have common messages, as a node of a run that is the router."""
import os
import struct
import sys
import time

from peer import Peer, check

peer = Peer(sys.argv[1])

# Names and hashes of ROS 2 Jazzy.
TYPES = {
    "frame": ("geometry_msgs::msg::dds_::PoseStamped_",
              "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"),
    "odometry": ("nav_msgs::msg::dds_::Odometry_",
                 "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"),
    "wanted": ("geometry_msgs::msg::dds_::Twist_",
               "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"),
}
for port, (name, digest) in TYPES.items():
    check("key", peer.key(f"/pom/{port}"), f"7/pom/{port}/{name}/RIHS01_{digest}")

begin = time.time()
frames, frame_subscriber = peer.read("/pom/frame")
odometry, odometry_subscriber = peer.read("/pom/odometry")
wanted = peer.session.declare_publisher(peer.key("/pom/wanted"))
listener = wanted.declare_matching_listener(peer.note)
peer.soon("wanted", lambda: wanted.matching_status.matching)
# Neither has the form of a Twist.
for wrong in [b"\0\1\0\0", b"\0\1\0\0" + struct.pack("<5d", 9, 9, 9, 9, 9)]:
    wanted.put(wrong, attachment=peer.attachment())
wanted.put(b"\0\1\0\0" + struct.pack("<6d", 1.5, 7, 7, 7, 7, -2), attachment=peer.attachment())

# The first message: until then, the position is absent.
pose = peer.soon("frame", lambda: frames and frames[0][0])
check("pose", pose, struct.pack("<iII4s7d", 12, 34, 4, b"map", 1.5, -2, 0, 0, 0, 0, 1))
message = peer.soon("odometry", lambda: odometry and odometry[0][0])
sec, nanosec = struct.unpack_from("<iI", message)
assert begin - 1 < sec + nanosec / 1e9 < time.time() + 1, (sec, nanosec)
names = struct.pack("<I5s3xI5s", 5, b"odom", 5, b"base")
check("names", message[8:8 + len(names)], names)
numbers = struct.unpack("<85d", message[32:])
expected = [1.5, -2, 0, 0, 0, 0, 1, *[0] * 35, 0.25, 1.5, *[0] * 41]
check("odometry", list(numbers), expected)
print("seen", flush=True)
# The end of the interpreter would wait for threads of Zenoh.
os._exit(0)
