"""What a run writes, read by the packages of those whose formats these are."""

import json
import os
import subprocess

import jsonschema
import pytest
from google.protobuf import unknown_fields
from mcap.reader import make_reader
from perfetto.protos.perfetto.trace import perfetto_trace_pb2 as perfetto

from hosted import lay_out


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A folder with `run.mcap` and `run.pftrace`, of one second of two components with codels in C."""
    folder = tmp_path_factory.mktemp("recorded")
    for name in ["echo", "reader"]:
        lay_out(folder, name)
    command = [os.environ["DOTGEN"], "run", "echo/echo.gen", "reader/reader.gen", "--until", "1s"]
    command += ["--bounds", "none", "--record", "run.mcap", "--trace", "run.pftrace"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder


def test_mcap_is_read_and_messages_fit_their_schemas(recorded):
    with open(recorded / "run.mcap", "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None, "a reader can jump"
        times, topics = [], {}
        for schema, channel, message in reader.iter_messages():
            times.append(message.log_time)
            topics[channel.topic] = topics.get(channel.topic, 0) + 1
            if channel.message_encoding == "json" and schema.encoding == "jsonschema":
                jsonschema.validate(json.loads(message.data), json.loads(schema.data))
    assert times == sorted(times)
    counted = summary.statistics.channel_message_counts
    names = {it.id: it.topic for it in summary.channels.values()}
    assert {names[it]: count for it, count in counted.items()} == topics
    # 10 and 20 ms: each port is written in each job but the first.
    for port, least in [("echo/trail", 90), ("echo/each/a", 90), ("reader/seen", 40)]:
        assert max(count for it, count in topics.items() if it.endswith(port)) > least, topics


def known_to_perfetto(message):
    """No field of the message, or of one in it, is unknown to Perfetto."""
    assert len(unknown_fields.UnknownFieldSet(message)) == 0, message
    for field, value in message.ListFields():
        if field.type == field.TYPE_MESSAGE:
            for it in value if field.is_repeated else [value]:
                known_to_perfetto(it)


def test_perfetto_knows_every_field_and_slices_are_nested(recorded):
    trace = perfetto.Trace()
    trace.ParseFromString((recorded / "run.pftrace").read_bytes())
    known_to_perfetto(trace)
    tracks, open_slices, slices = set(), {}, 0
    for packet in trace.packet:
        if packet.HasField("track_descriptor"):
            tracks.add(packet.track_descriptor.uuid)
        if not packet.HasField("track_event"):
            continue
        event = packet.track_event
        assert event.track_uuid in tracks, "a track is described before it is used"
        began = open_slices.setdefault(event.track_uuid, [])
        if event.type == event.TYPE_SLICE_BEGIN:
            assert not began or began[-1] <= packet.timestamp
            began.append(packet.timestamp)
            slices += 1
        elif event.type == event.TYPE_SLICE_END:
            assert began and began.pop() <= packet.timestamp, "what ends has begun before"
    assert slices > 150
    assert not any(open_slices.values()), "what begins ends"
