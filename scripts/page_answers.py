"""Run a command that serves the cockpit until half a second is simulated: page_answers.py COMMAND...

Prints after how many seconds the page and that time came. Needs websockets, which the cockpit brings.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from urllib.request import urlopen

from websockets.sync.client import connect

# the first byte of a binary frame; eight bytes with nanoseconds follow that of a time
MESSAGE, TIME = 1, 2


def watch(address: str, until_ns: int) -> int:
    """Receive all that is published beside a page until this simulated time; the number of messages."""
    host, query = re.findall(r"http://(.*?)/\?([^#\s]*)", address)[0]
    messages = now_ns = 0
    # not to wait, at the end, until all that is on its way has been read
    address = f"ws://{host}/ws?{query}"
    with connect(address, subprotocols=["foxglove.sdk.v1"], max_size=None, close_timeout=0.1) as socket:
        while now_ns < until_ns:
            frame = socket.recv(timeout=120)
            if isinstance(frame, bytes):
                messages += frame[0] == MESSAGE
                now_ns = int.from_bytes(frame[1:9], "little") if frame[0] == TIME else now_ns
            elif (told := json.loads(frame))["op"] == "advertise":
                wanted = [{"id": channel["id"], "channelId": channel["id"]} for channel in told["channels"]]
                socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
    return messages


began = time.monotonic()
server = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE, text=True, start_new_session=True)
try:
    line = next((line for line in server.stdout or () if "http://" in line), None) or sys.exit(
        "no page was served"
    )
    address = line[line.index("http://") :].split()[0].replace("0.0.0.0", "127.0.0.1")
    page = urlopen(address).read()
    assert b"<script" in page, page[:200]
    page_s = time.monotonic() - began
    messages = watch(address, until_ns=500_000_000)
    print(f"the page after {page_s:.0f} s, {messages} messages after {time.monotonic() - began:.0f} s")
finally:
    os.killpg(server.pid, signal.SIGTERM)
