"""Serves a bag as a robot's bridge does: a Foxglove WebSocket server of another library, with the topics of the bag.

usage: foreign_server.py BAG PORT_FILE SPEED

The port is written to PORT_FILE. The messages are sent once somebody has subscribed to TOPICS of them, SPEED times as fast
as they were recorded; then the server ends.
"""

import json
import sys
import threading
import time
from pathlib import Path

import foxglove
from foxglove import Channel, Schema
from foxglove.websocket import ServerListener
from mcap.reader import make_reader

TOPICS = 3


class Subscribers(ServerListener):
    """Knows which topics somebody wants."""

    def __init__(self):
        self.topics = set()
        self.are_enough = threading.Event()

    def on_subscribe(self, client, channel):
        self.topics.add(channel.topic)
        if len(self.topics) >= TOPICS:
            self.are_enough.set()


def main(bag, port_file, speed):
    subscribers = Subscribers()
    server = foxglove.start_server(name="cart", host="127.0.0.1", port=0, server_listener=subscribers)
    with open(bag, "rb") as file:
        messages = list(make_reader(file).iter_messages())
    channels = {}
    for schema, channel, _ in messages:
        if channel.topic not in channels:
            own = Schema(name=schema.name, encoding=schema.encoding, data=schema.data)
            channels[channel.topic] = Channel(channel.topic, schema=own, message_encoding=channel.message_encoding)
    notes = Channel("/notes", message_encoding="json")
    port_file.with_suffix(".new").write_text(str(server.port))
    port_file.with_suffix(".new").rename(port_file)
    if not subscribers.are_enough.wait(120):
        sys.exit(f"somebody subscribed to {subscribers.topics} alone")
    began, first_ns = time.monotonic(), messages[0][2].log_time
    for _, channel, message in messages:
        due = (message.log_time - first_ns) * 1e-9 / speed
        time.sleep(max(0.0, began + due - time.monotonic()))
        channels[channel.topic].log(message.data, log_time=message.log_time)
    notes.log(json.dumps({"text": "that was all"}).encode())
    time.sleep(1)
    server.stop()
    print(*sorted(subscribers.topics))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]))
