"""Reads an MCAP file with other programs and prints its content as JSON.

usage: read_bag.py FILE.mcap
"""

import json
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore


def plain(value):
    """The message as JSON values: objects, lists, numbers, strings."""
    if hasattr(value, "__slots__") and not isinstance(value, (str, bytes)):
        return {name.lstrip("_"): plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        return [plain(item) for item in value]
    if isinstance(value, float) and value != value:
        return "NaN"
    return value


def with_mcap(path):
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        header = reader.get_header()
        summary = reader.get_summary()
        messages = [
            {
                "topic": channel.topic,
                "type": schema.name,
                "log_time": message.log_time,
                "sequence": message.sequence,
                "message": plain(decoded),
            }
            for schema, channel, message, decoded in reader.iter_decoded_messages()
        ]
        attachments = {a.name: a.data.decode() for a in reader.iter_attachments()}
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
    return {
        "profile": header.profile,
        "library": header.library,
        "indexed_messages": summary.statistics.message_count,
        "chunks": [index.compression for index in summary.chunk_indexes],
        "messages": messages,
        "attachments": attachments,
        "metadata": metadata,
    }


def with_rosbags(path):
    store = get_typestore(Stores.EMPTY)
    counts = {}
    stamps = []
    with AnyReader([Path(path)], default_typestore=store) as reader:
        for connection, timestamp, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
            if hasattr(message, "header"):
                stamp = message.header.stamp
                stamps.append(stamp.sec * 10**9 + stamp.nanosec == timestamp)
    return {"counts": counts, "stamps_agree": all(stamps)}


if __name__ == "__main__":
    path = sys.argv[1]
    json.dump({"mcap": with_mcap(path), "rosbags": with_rosbags(path)}, sys.stdout)
