"""Programs of others as witnesses of ASTERIX, Garmin xHD, Navico HALO and ROS 2 bags: five reflectors against the truth.

A service runs in a network namespace of its own, with a bridge in 172.16/12, which needs root. tshark captures there what it
sends by UDP, and decodes it; libasterix and asterix-decoder, each in an environment of its own below FOLDER, decode it too. The
receivers and the controls of radar_pi for a Garmin xHD and a HALO, built from its sources (RADAR_PI names their folder, with
`src` and `include`) by g++ with wxWidgets and the stubs of `radar_pi/`, find the radar, draw it and command it; so does the class
Radar of the ROS driver halo_radar, whose folder HALO_RADAR names, and so does mayara-core (MAYARA) a HALO. The discovery of
mayara_pi (MAYARA_PI) finds the service by mDNS. rosbags reads a bag.
"""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from tests.ports.asterix.reading import blocks, reports
from tests.ports.reflectors import crossings, scene
from tests.ports.udp.test_capture import frames
from tests.reference.true_north import true_deg

HERE = Path(__file__).parent
PORT = 8600
OTHERS = {"libasterix": "libasterix", "asterix-decoder": "asterix-decoder"}
LIGHT = 299_792_458.0
# What the reader is told, and which line it says then, with the longest time between both [s].
TALK = [
    ("range 1000", "range 1000", 0.2), ("gain 33", "gain 33", 0.2), ("sea 20", "sea 20", 0.2), ("rain 7", "rain 7", 0.2),
    ("rejection 1", "rejection 1", 0.2), ("off", "power 1", 0.2), ("on", "power 8", 0.2), ("gain-auto", "gain-state 1", 0.2),
    ("sea-auto", "sea-state 1", 0.2), ("range 1852", "range 1852", 0.2),
]  # fmt: skip
HALO_TALK = [
    ("range 1000", "range 1000", 0.2), ("gain 33", "gain 32.941176", 0.2), ("sea_clutter 20", "sea_clutter 20.000000", 0.2),
    ("rain_clutter 7", "rain_clutter 6.666667", 0.2), ("interference_rejection low", "interference_rejection low", 0.2),
    ("status standby", "status standby", 0.2), ("status transmit", "status transmit", 0.2), ("gain auto", "gain_mode auto", 0.2),
    ("sea_clutter auto", "sea_clutter_mode auto", 0.2), ("range 1852", "range 1852", 0.2),
]  # fmt: skip
MAYARA_TALK = [
    ("range 10000", "range 10000", 0.2), ("gain 85", "gain 85", 0.2), ("sea 51", "sea 20", 0.2), ("rain 18", "rain 18", 0.2),
    ("rejection 1", "rejection 1", 0.2), ("status 1", "status 1", 0.2), ("status 2", "status 2", 0.2),
    ("gain -1", "gain -1", 0.2), ("sea -1", "sea-auto 1", 0.2), ("range 18520", "range 18520", 0.2),
]  # fmt: skip
NAMESPACE = """ip link set lo up && ip link add br0 type bridge && ip addr add 172.16.2.0/12 dev br0 &&
ip addr add 172.16.3.150/12 dev br0 && ip link set br0 up && exec "$@" """
COMMON = ["include/RadarReceive.h", "include/RadarControl.h", "include/socketutil.h", "src/socketutil.cpp"]
COMMON += ["include/RadarLocationInfo.h"]
PARTS = {"garmin-xhd": ("GarminxHD", ("Receive", "Control")), "navico-halo": ("Navico", ("Receive", "Control", "Locate"))}
LEFT_OUT = r"nalgebra|bitflags|pub (mod|use) (arpa|engine)"
IMAGE = {"garmin-xhd": (1440, 705), "navico-halo": (2048, 1024)}


def still_scene(noise: bool = False) -> dict[str, Any]:
    """Reflectors from a ship at rest: without noise weak, below the highest video, and the picture is always the same."""
    moving, weaker = scene(), 0 if noise else 25
    bodies = [{**body, "rcs_dbsm": body["rcs_dbsm"] - weaker} for body in moving["body"]]
    return {**moving, "own_ship": {"heading_deg": 33}, "body": bodies, "environment": {"noise": noise, "multipath": False}}


def truth() -> list[dict[str, Any]]:
    """The truth of the first scan."""
    return crossings(Simulator(load_scene(still_scene()), "fast", 1))


def serving(folder: Path, *options: str, noise: bool = False) -> list[str]:
    """The command of a service that sends the reflectors."""
    (folder / "reflectors.json").write_text(json.dumps(still_scene(noise)))
    command = [sys.executable, "-m", "radar_service", "serve", str(folder / "reflectors.json"), "--port", "0"]
    return [*command, "--fidelity", "fast", *options]


def alone(command: list[str]) -> list[str]:
    """A command in a namespace of its own."""
    return ["unshare", "-n", "sh", "-c", NAMESPACE, "sh", *command]


def environment(folder: Path, package: str) -> Path:
    """The Python of an environment with a package."""
    python = folder / f"with-{package}" / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(python.parents[1])], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", package], check=True)
    return python


def asterix(folder: Path) -> str:
    """Decodes 8 and 16 bits, split and whole, of running services. Raises AssertionError."""
    told = []
    for bits, largest in ((8, 1400), (16, 1400), (16, 65507)):
        own, dump = captured(folder, "--asterix", "--asterix-bits", str(bits), "--asterix-datagram", str(largest))
        assert len(own) > 1000 and dump.count("Category: 240") >= 1600
        one_scan = own[: 1 + 720 * (1 if bits == 8 or largest > 1400 else 2)]
        assert all(len(blocks(each)) == 1 for each in one_scan)
        for name in OTHERS:
            judge_video(decoded(folder, name, one_scan), bits)
        told.append(f"{bits} bits of {largest} bytes")
    return f"tshark, {' and '.join(OTHERS)} have 5 reflectors in their cell and sector: {', '.join(told)}"


def captured(folder: Path, option: str, *form: str, noise: bool = False) -> tuple[list[bytes], str]:
    """What a service has captured of some seconds, of which tshark has seen the same, and what tshark says of the first ones."""
    captures = [folder / f"asterix-{name}.pcap" for name in ("tshark", "own")]
    run = " ".join(
        [*serving(folder, option, f"127.0.0.1:{PORT}", *form, "--pcap", str(captures[1]), "--overwrite", noise=noise), "& S=$!;",
         f"timeout 30 tshark -q -i lo -F pcap -s 0 -f 'udp port {PORT}' -a duration:22 -w {captures[0]}; kill $S; wait $S"]
    )  # fmt: skip
    subprocess.run(alone(["sh", "-c", run]), check=False, capture_output=True)
    seen, own = ([frame[42:] for _, frame in frames(file)] for file in captures)
    assert seen and {each for each in seen if len(each) > 3} <= set(own)
    words = ["tshark", "-r", str(captures[1]), "-c", "1600", "-V"]
    dump = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert "alformed" not in dump
    return own, dump


def decoded(folder: Path, name: str, datagrams: list[bytes]) -> list[Any]:
    """What a library has of each datagram."""
    content = b"".join(len(each).to_bytes(4, "big") + each for each in datagrams)
    command = [str(environment(folder, name)), str(HERE / "asterix_decoded.py"), name]
    lines = subprocess.run(command, input=content, capture_output=True, check=True).stdout.splitlines()
    return [json.loads(line) for line in lines]


def asterix_plots(folder: Path) -> str:
    """Decodes plots of a running service, against our reader and the truth, beside false alarms. Raises AssertionError."""
    own, dump = captured(folder, "--asterix-plots", noise=True)  # a threshold of clutter needs some
    read = [reports([each]) for each in own]
    count = sum(map(len, read))
    assert len(own) >= 3 and dump.count("Category: 48") == len(own) and dump.count("Single PSR detection") == count
    for name in OTHERS:
        for ours, theirs in zip(read, decoded(folder, name, own), strict=True):
            rows = [
                [*each.source, each.time, 1, 1, each.range / 1852.0, 360 * each.bearing, 360 * each.run, each.amplitude]
                for each in ours
            ]
            assert np.allclose(rows, theirs, rtol=0.0, atol=1e-9), (rows, theirs)
    for plots in read[1:]:  # sidelobes of a strong echo may reach to the first spoke of all, which cuts it
        for crossing in truth():
            bearing = true_deg(crossing["bearing"], [0.0, 0.0], (50.0, 1.0))
            errors = [
                (abs(plot.range - crossing["range"]), abs(math.remainder(360.0 * plot.bearing - bearing, 360.0)))
                for plot in plots
            ]
            assert any(far <= 0.5 * 1852.0 / 256.0 + 0.1 and off <= 0.5 * 360.0 / 65536 + 0.01 for far, off in errors), (
                crossing
            )
    return f"tshark, {' and '.join(OTHERS)} have {count} plots to the last bit, 5 reflectors where they are"


def judge_video(decoded: list[Any], bits: int) -> None:
    """Whether each reflector is in the strongest cell near it."""
    rows: dict[float, bytes] = {}
    for each in decoded:
        if not isinstance(each, str):
            assert len(rows.get(each[0], b"")) * 8 // bits == each[2]
            rows[each[0]] = rows.get(each[0], b"") + bytes.fromhex(each[4])
    ends = {each[0]: each[1] for each in decoded if not isinstance(each, str)}
    cell = next(each[3] for each in decoded if not isinstance(each, str)) * 1e-15 * LIGHT / 2.0
    image = np.array([np.frombuffer(row, ">u2" if bits == 16 else "u1") for row in rows.values()]).astype(int)
    assert image.shape[0] == 720 and len(truth()) == 5
    for crossing in truth():
        near = abs(np.arange(image.shape[1]) * cell - crossing["range"]) < 30.0
        row, number = np.unravel_index(np.argmax(np.where(near, image, -1)), image.shape)
        assert number * cell <= crossing["range"] < (number + 1) * cell, crossing
        begin = list(rows)[row]
        bearing = true_deg(crossing["bearing"], [0.0, 0.0], (50.0, 1.0))
        assert (bearing - begin) % 360.0 <= (ends[begin] - begin) % 360.0 + 0.011, crossing


def built_reader(folder: Path, sources: Path, dialect: str) -> Path:
    """radar_pi's receiver and control of an xHD or a HALO, with what `radar_pi/` has in place of the rest."""
    build, (maker, parts) = folder / f"{dialect}-reader", PARTS[dialect]
    build.mkdir(exist_ok=True)
    own = [
        f"{kind}/{maker.lower()}/{maker}{part}.{end}" for part in parts for kind, end in (("include", "h"), ("src", "cpp"))
    ]
    if maker == "Navico":
        own.append("include/navico/NavicoCommon.h")
        (build / "navico").is_symlink() or (build / "navico").symlink_to(".")
    for file in [*(HERE / "radar_pi").iterdir(), *(sources / name for name in COMMON + own)]:
        shutil.copy(file, build)
    names = sorted(set(re.findall("CT_[A-Z_0-9]+", (build / f"{maker}Control.cpp").read_text())))
    (build / "items.h").write_text(",".join(names))
    flags = " ".join(subprocess.run(["wx-config", f"--{of}", "base"], capture_output=True, text=True, check=True).stdout.strip()
                     for of in ("cxxflags", "libs"))  # fmt: skip
    command = f"g++ -w -O1 -D{maker.upper()} -include RadarControl.h -o reader *.cpp {flags}"
    subprocess.run(command, shell=True, cwd=build, check=True)
    return build / "reader"


def radar_pi(folder: Path) -> str:
    """Lets radar_pi's code find, draw and command the radar as an xHD and as a HALO. Raises AssertionError."""
    sources = os.environ.get("RADAR_PI", "")
    if not sources:
        return "not asked, without RADAR_PI"
    return "; ".join(
        f"{dialect}: {read_by(folder, built_reader(folder, Path(sources), dialect), dialect, TALK)}" for dialect in PARTS
    )


def halo_radar(folder: Path) -> str:
    """Lets the code of the ROS driver find, draw and command the radar as a HALO. Raises AssertionError."""
    if not (sources := os.environ.get("HALO_RADAR", "")):
        return "not asked, without HALO_RADAR"
    build = folder / "halo_radar"
    build.mkdir(exist_ok=True)
    code = Path(sources) / "simrad_halo_radar" / "src" / "halo_radar"
    for name in ("halo_radar.cpp", "halo_radar.h", "halo_radar_structures.h"):
        shutil.copy(code / name, build)
    shutil.copy(HERE / "halo_radar" / "reader.cpp", build)
    subprocess.run("g++ -w -O1 -pthread -o reader *.cpp", shell=True, cwd=build, check=True)
    return read_by(folder, build / "reader", "navico-halo", HALO_TALK)


def mayara_core(folder: Path) -> str:
    """Lets mayara-core find, read and command the radar as a HALO, built by cargo with Debian's crates. Raises AssertionError."""
    if not (sources := os.environ.get("MAYARA", "")):
        return "not asked, without MAYARA"
    build = folder / "mayara-core"
    shutil.copytree(Path(sources) / "mayara-core", build, dirs_exist_ok=True)
    for name in ("Cargo.toml", "src/lib.rs"):  # without what needs crates that Debian has not: targets of its own
        kept = [line for line in (build / name).read_text().splitlines() if not re.match(LEFT_OUT, line)]
        (build / name).write_text("\n".join(kept))
    (build / "src" / "bin").mkdir(exist_ok=True)
    shutil.copy(HERE / "mayara_core" / "reader.rs", build / "src" / "bin")
    crates = ["source.crates-io.replace-with='debian'", "source.debian.directory='/usr/share/cargo/registry'"]
    command = ["cargo", "build", "-q", "--release", "--offline", *(word for each in crates for word in ("--config", each))]
    subprocess.run(command, cwd=build, check=True)
    return read_by(folder, build / "target" / "release" / "reader", "navico-halo", MAYARA_TALK)


def read_by(folder: Path, reader: Path, dialect: str, talk: list[tuple[str, str, float]]) -> str:
    """What a reader says and draws, against the truth. talk: what it is told, as TALK is. Raises AssertionError."""
    image = folder / f"{dialect}.image"
    service = " ".join(serving(folder, f"--{dialect}", "br0"))
    with subprocess.Popen(
        alone(["sh", "-c", f"{service} >&2 & sleep 5; {reader}; kill $!"]), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
    ) as process:  # fmt: skip
        assert process.stdin is not None and process.stdout is not None
        time.sleep(12.0)
        for word in (*(word for word, _, _ in talk), "wait", f"image {image}", "quit 0"):
            if word == "wait":
                time.sleep(6.0)
                continue
            process.stdin.write(word + "\n")
            process.stdin.flush()
            time.sleep(1.0)
        lines = process.communicate(timeout=30)[0].splitlines()
    (folder / f"{dialect}.log").write_text("\n".join(lines))
    said = [(float(line.split()[0]), line.split(maxsplit=1)[1]) for line in lines]
    first = {text: when for when, text in reversed(said)}
    started = first["started 1"]
    spoke = next(when for when, text in said if text.startswith("spoke "))
    slowest = 0.0
    for word, answer, limit in talk:
        begin = next(when for when, text in said if text in (f"say-{word}", f"say-{word} 0"))
        delay = min((when - begin for when, text in said if text == answer and when >= begin), default=math.inf)
        assert delay <= limit, (word, delay)
        slowest = max(slowest, delay)
    values = {text.split()[0]: int(text.split()[1]) for _, text in said if text.split()[1].isdigit()}
    assert values.get("broken", 0) == 0
    assert dialect == "garmin-xhd" or abs(values.get("heading", 188) - 33 / 360 * 2048) <= 1.0
    judge_picture(np.frombuffer(image.read_bytes(), np.uint8).reshape(IMAGE[dialect]), values["samples"], values["metres"])
    return (
        f"found {1000 * (first['found 1'] - started):.0f} ms and drawn {1000 * (spoke - started):.0f} ms after its start, "
        f"commands back within {1000 * slowest:.0f} ms, 5 reflectors within a sample and a spoke"
    )


def judge_picture(image: np.ndarray[Any, Any], samples: int, metres: int) -> None:
    """Whether each reflector is in the strongest sample near it or, where ours are longer, within a cell, and within a spoke."""
    width, turn = metres / samples, image.shape[0]
    cell, half = Simulator(load_scene(still_scene()), "fast", 1).range_step, round(30.0 / width)
    for crossing in truth():
        sample = int(crossing["range"] / width)
        near = image[:, sample - half : sample + half + 1]
        rows, columns = np.nonzero(near == near.max())
        assert set(columns) == {half} or (cell > width and abs(np.median(columns) - half) * width <= cell), (
            crossing,
            columns,
        )
        angle = crossing["relative_bearing"] / (2.0 * math.pi) * turn
        assert abs(math.remainder(float(np.median(rows)) - angle, turn)) <= 0.5 + 0.5 * turn / 720, (crossing, rows)


def mayara_pi(folder: Path) -> str:
    """Lets the discovery of mayara_pi find a service that announces itself. Raises AssertionError."""
    if not (sources := os.environ.get("MAYARA_PI", "")):
        return "not asked, without MAYARA_PI"
    code, service = folder / "find.cpp", serving(folder, "--host", "172.16.2.0", "--insecure", "--signalk", "--announce")
    service[service.index("--port") + 1] = "8000"
    code.write_text(
        '#include "MayaraDiscovery.h"\n#include <cstdio>\nint main() { puts(MayaraDiscovery::FindServer().c_str()); }'
    )
    build = (
        f"g++ -w -I{sources}/include -I{sources}/third_party/mdns -o {folder}/find {code} {sources}/src/MayaraDiscovery.cpp"
    )
    subprocess.run(build, shell=True, check=True)
    run = f"ip route add default dev br0; {' '.join(service)} >&2 & S=$!; sleep 8; {folder}/find; kill $S; wait $S"
    found = subprocess.run(alone(["sh", "-c", run]), capture_output=True, text=True).stdout
    assert found == "http://172.16.2.0:8000\n", found
    return f"found {found.strip()}"


def ros2_bag(folder: Path) -> str:
    """Lets rosbags read a bag. Raises CalledProcessError."""
    bag = folder / "bag.mcap"
    serving(folder)
    command = [sys.executable, "-m", "radar_service", "record", str(folder / "reflectors.json"), "--ros2", "--overwrite"]
    subprocess.run([*command, "-o", str(bag)], check=True, capture_output=True)
    read = [str(environment(folder, "rosbags")), str(HERE / "bag_read.py"), str(bag)]
    got = json.loads(subprocess.run(read, capture_output=True, check=True).stdout)
    image, angles, ranges = np.array(got["image"]), np.array(got["angles"]), np.linspace(*got["range"], len(got["image"][0]))
    for crossing in truth():
        ray, cell = np.unravel_index(np.argmax(np.where(abs(ranges - crossing["range"]) < 30.0, image, -1.0)), image.shape)
        assert abs(ranges[cell] - crossing["range"]) <= (ranges[1] - ranges[0]) / 2.0 + 1e-3
        assert abs(math.remainder(angles[ray] + crossing["relative_bearing"], 2 * math.pi)) < math.pi / 720 + 1e-3
    return f"{got['messages']} messages of {got['types']} types; 5 reflectors within half a cell and half a spoke"
