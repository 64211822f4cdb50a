"""The limits of the sandbox's child process."""

import json
import os
import subprocess
import sys

REACH_OUT = """
import json, os, socket, sys
from radar_service.processes import limits
from radar_service.scene_file.readers import sandbox_child as child
child.warm_up()
kept = os.dup(1)
limits.limit_memory(2**30)
limits.forbid_access()
outcome = {}
for name, act in {
    "open": lambda: open("/etc/hostname"), "write": lambda: open("/tmp/radar-sandbox-test", "w"), "socket": socket.socket,
    "fork": lambda: os.fork() or os._exit(0) if os.getuid() else (_ for _ in ()).throw(OSError("root may")),
    "memory": lambda: bytearray(2**31),
}.items():
    try:
        act()
        outcome[name] = "done"
    except (OSError, MemoryError) as fault:
        outcome[name] = type(fault).__name__
os.write(kept, json.dumps(outcome).encode())
"""


def test_the_child_has_no_access() -> None:
    environment = {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
    out = subprocess.run([sys.executable, "-c", REACH_OUT], capture_output=True, env=environment, check=True, timeout=60)
    refused = json.loads(out.stdout)
    assert "done" not in refused.values() and refused["memory"] == "MemoryError", refused
