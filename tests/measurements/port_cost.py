"""What Signal K, NMEA and AIS cost a service: python -m tests.measurements.port_cost [ROUNDS].

The scene is `open-sea` at 4096 spokes x 48 rpm. By turns: one u8 client of the feed, and the same with all ports on, each read by
a client. Prints processor time of the service and its children a spoke, spokes a second, what was lost, and the ratio of the
medians. Loopback only; needs a quiet machine.
"""

import json
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from pathlib import Path
from typing import Any

import httpx
from websockets.sync.client import connect

from radar_service.processes.limits import processor_time_of
from tests.measurements.places import SCENES

SETTLE, SECONDS = 5.0, 15.0
FEED = "/api/radars/0/feed?encoding=u8"
SPOKES = "/signalk/v2/api/vessels/self/radars/sim-0/spokes"
STREAM = "/signalk/v1/stream?subscribe=all"


def scene_file(folder: Path) -> Path:
    """The scene, with an MMSI for own ship's AIS."""
    settings: dict[str, Any] = tomllib.loads((SCENES / "open-sea.toml").read_text(encoding="utf-8"))
    settings["radar"] |= {"azimuths": 4096, "rpm": 48}
    settings["own_ship"] = settings.get("own_ship", {}) | {"mmsi": 235000100}
    path = folder / "scene.json"
    path.write_text(json.dumps(settings))
    return path


def family(pid: int) -> list[int]:
    """A process and all its children."""
    children = [int(each) for path in Path(f"/proc/{pid}/task").glob("*/children") for each in path.read_text().split()]
    return [pid, *(each for child in children for each in family(child))]


def read_socket(address: str, stop: threading.Event) -> None:
    """Reads a websocket until `stop`."""
    with connect(address, max_size=None, compression=None, ping_interval=None) as opened:
        while not stop.is_set():
            try:
                opened.recv(timeout=0.5)
            except TimeoutError:
                continue


def read_lines(port: int, stop: threading.Event) -> None:
    """Reads sentences over TCP until `stop`."""
    with socket.create_connection(("127.0.0.1", port)) as opened:
        opened.settimeout(0.5)
        while not stop.is_set():
            try:
                opened.recv(65536)
            except TimeoutError:
                continue


def free_port() -> int:
    with socket.socket() as bound:
        bound.bind(("127.0.0.1", 0))
        return int(bound.getsockname()[1])


def metrics(host: str) -> dict[str, float]:
    lines = httpx.get(f"http://{host}/metrics").text.splitlines()
    return {line.split()[0]: float(line.split()[1]) for line in lines if not line.startswith("#")}


def measured(scene: Path, with_ports: bool) -> float:
    """Processor time a spoke [us]."""
    nmea, ais = free_port(), free_port()
    ports = ["--signalk", "--nmea-tcp", f"{nmea}", "--ais-tcp", f"{ais}"] if with_ports else []
    command = [sys.executable, "-m", "radar_service", "serve", str(scene), "--port", "0", *ports]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout is not None
        found = re.search(r"http://([\d.:]+)", service.stdout.readline())
        assert found is not None
        host, stop = found.group(1), threading.Event()
        readers = [threading.Thread(target=read_socket, args=(f"ws://{host}{FEED}", stop))]
        if with_ports:
            readers += [threading.Thread(target=read_socket, args=(f"ws://{host}{path}", stop)) for path in (SPOKES, STREAM)]
            readers += [threading.Thread(target=read_lines, args=(port, stop)) for port in (nmea, ais)]
        for reader in readers:
            reader.start()
        time.sleep(SETTLE)
        before, begun = metrics(host), {pid: processor_time_of(pid) or 0.0 for pid in family(service.pid)}
        time.sleep(SECONDS)
        ended, after = {pid: processor_time_of(pid) or 0.0 for pid in family(service.pid)}, metrics(host)
        stop.set()
        for reader in readers:
            reader.join()
        service.terminate()
    grown = {name: value - before.get(name, 0.0) for name, value in after.items()}
    spokes = sum(value for name, value in grown.items() if name.startswith("radar_azimuths_total"))
    lost = {name: value for name, value in grown.items() if value and re.search("drop|lost|slip", name)}
    spent = sum(value - begun.get(pid, 0.0) for pid, value in ended.items())
    what, rate = "all ports" if with_ports else "one client", spokes / SECONDS
    print(f"{what}: {spent / spokes * 1e6:.0f} us a spoke, {rate:.0f} a second, {lost}")
    return spent / spokes * 1e6


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    with tempfile.TemporaryDirectory() as folder:
        scene = scene_file(Path(folder))
        pairs = [(measured(scene, False), measured(scene, True)) for _ in range(rounds)]
    one, every = (statistics.median(column) for column in zip(*pairs, strict=True))
    print(f"all ports take {every / one:.2f} of one client's")


if __name__ == "__main__":
    main()
