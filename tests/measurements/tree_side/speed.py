"""The processor time that work takes in a tree. Each kind of work prints its seconds."""

import http.client
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import radar_service as rs
from tests.measurements.tree_side.service import served
from tests.measurements.tree_side.worlds import two_radars

SCANS, CLIENTS, SECONDS, COMMANDS = 20, 100, 5.0, 100
WORKS = ("scan", "harbour", "feed", "commands")


def cpu_of(work: str) -> float:
    """Processor time [s] of one of WORKS: scans of `open-sea` or the harbour, a feed to CLIENTS, a flood of commands."""
    if work == "feed":
        return _of_feed()
    if work == "commands":
        return _of_commands()
    sim = rs.Simulator(rs.load_scene("open-sea" if work == "scan" else work), fidelity="balanced", seed=1)
    for _ in range(SCANS):
        sim.scan()
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def _of_feed() -> float:
    """Of a service at pace 1 that 100 clients listen to for SECONDS; its start does not count."""
    with served("serve", "open-sea", pace="1") as (address, process):
        host, port = address.split(":")
        load = [
            sys.executable,
            "-m",
            "tests.measurements.load",
            host,
            port,
            str(CLIENTS),
            str(SECONDS),
            "0",
            "encoding=u8&bins=1024",
        ]
        before = _used(process)
        told = json.loads(subprocess.run(load, check=True, capture_output=True, text=True).stdout)
        assert told["lost"] == told["holes"] == 0, told
        return _used(process) - before


def _of_commands() -> float:
    """Of a service of two radars that is steered COMMANDS times, one command after the other."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.json"
        scene.write_text(json.dumps(two_radars()))
        with served("serve", str(scene), pace="1") as (address, process):
            before = _used(process)
            connection = http.client.HTTPConnection(address, timeout=30)
            for number in range(COMMANDS):
                body = json.dumps({"course_deg": number % 360, "speed_kn": number % 12})
                connection.request("PATCH", "/api/radars/bow/own-ship", body, {"content-type": "application/json"})
                answer = connection.getresponse()
                said = answer.read()
                assert answer.status == 200, said
            return _used(process) - before


def _used(process: int) -> float:
    """Processor time [s] of a process and all that it has started."""
    parents = {}
    times = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:  # it has just ended
            continue
        parents[int(entry.name)], times[int(entry.name)] = int(fields[1]), sum(map(int, fields[11:15]))
    family = {process}
    while more := {child for child, parent in parents.items() if parent in family} - family:
        family |= more
    return float(sum(times.get(one, 0) for one in family)) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    print(json.dumps(cpu_of(sys.argv[1])))
