"""All ports at once beside 20 clients, and strangers: python -m tests.measurements.all_ports [SECONDS] [--hostile] [RPM].

In a network namespace of its own with a bridge (needs root): the open sea of 2048 spokes as xHD, HALO, ASTERIX 240 and 048 to a
group, Signal K, NMEA and AIS. Prints what clients lost, how late messages were, processor time, and what the ports dropped.
Hostile: 10,000 datagrams a second come to both sets, too short, too long, of other radars and out of range; in the middle the
bridge is taken away for 3 s.
"""

import json
import os
import random
import re
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from pathlib import Path
from typing import Any

import httpx

from radar_service.processes.limits import processor_time_of
from tests.measurements.places import SCENES
from tests.witnesses.dialects import alone

CLIENTS, RATE = 20, 10_000  # datagrams a second
BRIDGE = (
    "ip link add br0 type bridge; ip addr add 172.16.2.0/12 dev br0; ip addr add 172.16.3.150/12 dev br0; ip link set br0 up"
)
GROUP = "239.192.43.78"
PORTS = ["--garmin-xhd", "br0", "--navico-halo", "br0", "--asterix", f"{GROUP}:8600%172.16.2.0", "--asterix-plots"]
PORTS += [f"{GROUP}:8601%172.16.2.0", "--asterix-allow", GROUP, "--signalk", "--nmea-tcp", "10110", "--ais-tcp", "10111"]
SETS = [("172.16.2.0", 50101), ("236.6.7.101", 6133), ("236.6.7.5", 6878)]


def datagram(chance: random.Random) -> bytes:
    """One that no reader sends, or out of range, or of the other set."""
    number = chance.choice((0x0919, 0x091E, 0x0925, 0x093A, 0x0934, 0xC100, 0xC103, 0xC106, 0xC111, 0xB101, 0xFFFF))
    return chance.choice((
        b"", chance.randbytes(chance.randrange(1, 9)), chance.randbytes(8000), struct.pack("<IIH", number, 2, 0xFFFF),
        struct.pack("<HI", number, 0xFFFFFFFF), struct.pack("<HQB", number, 2**64 - 1, 255),
    ))  # fmt: skip


def assail(stop: threading.Event) -> int:
    """Sends datagrams until `stop`; returns how many."""
    chance, sent, begun = random.Random(1), 0, time.monotonic()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        content = [datagram(chance) for _ in range(1000)]
        while not stop.is_set():
            try:
                sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("172.16.3.150"))
                for _ in range(100):
                    sender.sendto(chance.choice(content), chance.choice(SETS))
                    sent += 1
            except OSError:
                time.sleep(0.1)  # the bridge is away
            time.sleep(max(0.0, sent / RATE - (time.monotonic() - begun)))
    return sent


def scene_file(folder: Path, rpm: float) -> Path:
    """The open sea."""
    settings: dict[str, Any] = tomllib.loads((SCENES / "open-sea.toml").read_text(encoding="utf-8"))
    settings["radar"] |= {"azimuths": 2048, "rpm": rpm}
    (folder / "scene.json").write_text(json.dumps(settings))
    return folder / "scene.json"


def family(pid: int) -> list[int]:
    """A process and all its children."""
    children = [int(each) for path in Path(f"/proc/{pid}/task").glob("*/children") for each in path.read_text().split()]
    return [pid, *(each for child in children for each in family(child))]


def metrics(host: str) -> dict[str, float]:
    """Returns the metrics of a service by their names with labels."""
    lines = httpx.get(f"http://{host}/metrics").text.splitlines()
    return {line.split()[0]: float(line.split()[1]) for line in lines if not line.startswith("#")}


def measured(seconds: float, hostile: bool, rpm: float) -> None:
    """Runs the service and prints what was seen."""
    with tempfile.TemporaryDirectory() as folder:
        file = str(scene_file(Path(folder), rpm))
        command = [sys.executable, "-m", "radar_service", "serve", file, "--port", "8000", *PORTS]
        service = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert service.stdout is not None and re.search("http://", service.stdout.readline())
        load = ["tests.measurements.load", "127.0.0.1", "8000", str(CLIENTS), str(seconds), "0", "encoding=u8"]
        clients = subprocess.Popen([sys.executable, "-m", *load], stdout=subprocess.PIPE, text=True)
        time.sleep(5.0)
        before, begun = metrics("127.0.0.1:8000"), {pid: processor_time_of(pid) or 0.0 for pid in family(service.pid)}
        stop, began = threading.Event(), time.monotonic()
        foe = threading.Thread(target=assail, args=(stop,))
        if hostile:
            foe.start()
            time.sleep(seconds / 2.0)
            subprocess.run("ip link del br0; sleep 3; " + BRIDGE, shell=True, check=True)
        print(clients.communicate()[0].strip())
        spent = sum((processor_time_of(pid) or 0.0) - begun.get(pid, 0.0) for pid in family(service.pid))
        after = metrics("127.0.0.1:8000")
        print(f"{spent / (time.monotonic() - began):.2f} cores; grown:")
        for name, value in after.items():
            if value != before.get(name, 0.0) and re.search("drop|lost|slip|refused|fault|azimuths_total|behind", name):
                print(f"  {name} {value - before.get(name, 0.0):g}")
        stop.set()
        service.terminate()
        service.wait()


if __name__ == "__main__":
    numbers = [float(word) for word in sys.argv[1:] if not word.startswith("-")]
    if "INSIDE" in os.environ:
        measured(numbers[0] if numbers else 120.0, "--hostile" in sys.argv, numbers[1] if numbers[1:] else 48.0)
    else:
        subprocess.run(
            alone(["env", "INSIDE=1", sys.executable, "-m", "tests.measurements.all_ports", *sys.argv[1:]]), check=True
        )
