"""Programs of others as witnesses of what a service sends: gpsdecode, OpenCPN on a screen of its own, mayara's web page.

`python -m tests.witnesses FOLDER [NAMES]`, which `.ci/witnesses` calls; ASTERIX, Garmin xHD, HALO and ROS 2 are in `dialects.py`.
Ten ships move. gpsdecode decodes their AIS, and that of an aid to navigation and a SART, with the parts of static reports
joined; it is compared with the truth. OpenCPN shows own ship and the ships on FOLDER/opencpn.png, to be looked at. The page is
opened where MAYARA_GUI names its folder (`signalk_page.py`), radar_pi in OpenCPN is in `opencpn_radar.py`. What is absent is
printed.
"""

import contextlib
import json
import math
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from tests.reference.true_north import true_deg
from tests.witnesses import dialects, opencpn_radar, signalk_page

KNOT = 1852.0 / 3600.0
START, START_SECOND = "2026-12-31T23:59:30", 30
NMEA, AIS = 10110, 10111
ORIGIN = (50.4, -1.3)  # degrees
LISTEN_S, PACE = 40.0, 5  # 200 s of simulation: an aid reports each three minutes
DRAW_S = 70.0  # for the first names, which come within a minute
PARTS = 600_000  # 1/10000 minutes in a degree
SCREEN = ":79"
CONNECTION = "1;0;127.0.0.1;{};0;;4800;1;0;0;;0;;0;0;0;0;1;;0;0;;"


def ships() -> list[dict[str, Any]]:
    """Ten ships around own ship; some turn, some have class B."""
    places = [
        (-1900, 2300),
        (900, 1700),
        (-700, 600),
        (-1500, -2000),
        (300, -900),
        (1700, 600),
        (2200, -1800),
        (-2600, -300),
    ]
    return [
        {
            "name": f"ship {k}", "shape": "hull", "length_m": 40.0 + 20 * k, "beam_m": 8.0 + 2 * k, "height_m": 12.0,
            "position_m": [*place, -4], "speed_kn": 3.0 + 3 * k, "course_deg": 36.0 * k, "mmsi": 235_000_200 + k,
            **({"turn_rate_deg_s": 0.6} if k % 3 == 0 else {}),
            "ais": {"ship_type": 30 + 5 * k, "class": ["A", "B-SO", "B-CS"][max(0, k - 5)] if k < 8 else "A"},
        }
        for k, place in enumerate([*places, (2600, 2500), (-300, -2700)])
    ]  # fmt: skip


SCENE: dict[str, Any] = {
    "name": "ten ships", "origin": {"latitude_deg": ORIGIN[0], "longitude_deg": ORIGIN[1]}, "radar": {"range_max_m": 6000},
    "environment": {"current_kn": 2, "current_to_deg": 90}, "body": ships(),
    "own_ship": {"speed_kn": 12, "course_deg": 30, "mmsi": 235_000_100, "ais": {"length_m": 60, "beam_m": 11}},
}  # fmt: skip


AID: dict[str, Any] = {
    "name": "fairway", "shape": "point", "rcs_dbsm": 10, "position_m": [700, 1200, 3], "mmsi": 992_350_300,
    "ais": {"kind": "aid", "aid_type": 30},
}  # fmt: skip
RAFT: dict[str, Any] = {
    "name": "raft", "shape": "point", "rcs_dbsm": 0, "position_m": [-900, -1200, 1], "mmsi": 970_010_300,
    "speed_kn": 1, "course_deg": 90, "ais": {"kind": "sart"},
}  # fmt: skip


@contextlib.contextmanager
def served(folder: Path, scene: dict[str, Any], pace: int = 1) -> Iterator[None]:
    """The service with both ports, once they are open."""
    file = folder / "scene.json"
    file.write_text(json.dumps(scene))
    command = [sys.executable, "-m", "radar_service", "serve", str(file), "--port", "0", "--fidelity", "fast"]
    command += ["--start-utc", START, "--pace", str(pace)]
    ports = ["--nmea-tcp", str(NMEA), "--ais-tcp", str(AIS)]
    with subprocess.Popen([*command, *ports], stdout=subprocess.PIPE, text=True) as service:
        try:
            assert service.stdout is not None
            print(service.stdout.readline().strip())
            yield
        finally:
            service.terminate()


def listened(folder: Path, scene: dict[str, Any]) -> bytes:
    """The AIS of LISTEN_S seconds at PACE."""
    text, until = b"", time.monotonic() + LISTEN_S
    with served(folder, scene, PACE), socket.create_connection(("127.0.0.1", AIS), timeout=10) as connection:
        while time.monotonic() < until:
            text += connection.recv(65536)
    return text


def judged(folder: Path) -> str:
    """What gpsdecode reads of AIS, against the truth. Raises AssertionError."""
    scene = {**SCENE, "body": [*ships(), AID, RAFT]}
    lines = listened(folder, scene)
    output = subprocess.run(["gpsdecode", "-j"], input=lines, capture_output=True, check=True).stdout
    simulator = Simulator(load_scene(scene), fidelity="fast")
    numbers = {body["mmsi"]: number for number, body in enumerate(scene["body"])}
    reports = [json.loads(line) for line in output.splitlines() if b'"class":"AIS"' in line]
    positions = [report for report in reports if report["type"] in (1, 18, 21)]
    now = 0.0
    for report in positions:
        now += math.remainder(report["second"] - START_SECOND - now, 60)  # own ship reports each second
        truth = simulator.truth(now)
        number = numbers.get(report["mmsi"])
        body = truth.own_ship if number is None else truth.bodies[number]
        assert body.latitude_deg is not None and body.longitude_deg is not None
        assert abs(round(report["lat"] * PARTS) - body.latitude_deg * PARTS) <= 0.5 + 1e-6, report
        assert abs(round(report["lon"] * PARTS) - body.longitude_deg * PARTS) <= 0.5 + 1e-6, report
        if report["type"] == 21:
            continue
        assert abs(report["speed"] - body.speed / KNOT) <= 0.05 + 1e-6, report
        assert abs(math.remainder(report["course"] - true_deg(body.course, body.position, ORIGIN), 360)) <= 0.05 + 1e-6, (
            report
        )
        if report["mmsi"] != RAFT["mmsi"]:
            assert (
                abs(math.remainder(report["heading"] - true_deg(body.heading, body.position, ORIGIN), 360)) <= 0.5 + 1e-6
            ), report
    bodies: list[dict[str, Any]] = scene["body"]
    for body_of in bodies:
        types = {report["type"] for report in reports if report["mmsi"] == body_of["mmsi"]}
        is_a = body_of["ais"].get("class", "A") == "A"
        assert types == {"aid": {21}, "sart": {1, 14}}.get(body_of["ais"].get("kind"), {1, 5} if is_a else {18, 24}), body_of
    names = {
        report["mmsi"]: report.get("shipname", report.get("name")) for report in reports if report["type"] in (5, 21, 24)
    }
    assert names == {235_000_100: "OWN SHIP"} | {each["mmsi"]: each["name"].upper() for each in bodies if each is not RAFT}
    assert {report["status"] for report in positions if report["mmsi"] == RAFT["mmsi"]} == {14}
    assert {report["text"] for report in reports if report["type"] == 14} == {"SART ACTIVE"}
    return f"{len(positions)} positions and {len(reports) - len(positions)} static reports agree with the truth"


def drawn(folder: Path) -> str:
    """OpenCPN's picture: it asks for consent at its first start, which a click gives."""
    home = folder / "opencpn"
    (home / ".opencpn").mkdir(parents=True, exist_ok=True)
    sources = "|".join(CONNECTION.format(port) for port in (NMEA, AIS))
    (home / ".opencpn" / "opencpn.conf").write_text(
        "[Settings]\nOpenGL=0\n[Settings/GlobalState]\nVPLatLon=  50.4000,   -1.3000\nVPScale=0.05\n"
        f"[Settings/NMEADataSource]\nDataConnections={sources}\n[Settings/AIS]\nbShowAISName=1\n"
    )
    own = {**os.environ, "HOME": str(home), "DISPLAY": SCREEN}
    with contextlib.ExitStack() as on_end:
        for command in (["Xvfb", SCREEN, "-screen", "0", "1280x900x24"], ["opencpn", "--no_opengl"]):
            program = subprocess.Popen(command, env=own, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            on_end.callback(program.wait)
            on_end.callback(program.kill)
            time.sleep(8.0)
        subprocess.run("xdotool search --name Welcome windowraise", shell=True, env=own, check=False)
        subprocess.run(["xdotool", "mousemove", "817", "628", "click", "1"], env=own, check=True)
        on_end.enter_context(served(folder, SCENE))  # after OpenCPN, which then gets the names, of the first minute, too
        time.sleep(DRAW_S)
        picture = folder / "opencpn.png"
        subprocess.run(["import", "-window", "root", "-crop", "896x630+0+0", "+repage", str(picture)], env=own, check=True)
    return f"look at {picture}: own ship to the north-east, and ten ships with their names"


def main(folder: Path, names: Sequence[str] = ()) -> None:
    """Asks each witness that is here. names: of those that are asked, all by default."""
    folder.mkdir(parents=True, exist_ok=True)
    gui = os.environ.get("MAYARA_GUI", "")
    needed = {
        "gpsdecode": ("gpsdecode",),
        "OpenCPN": ("opencpn", "Xvfb", "xdotool", "import"),
        "mayara's page": ("chromium",),
        "ASTERIX 240": ("unshare", "ip", "tshark"),
        "ASTERIX 048": ("unshare", "ip", "tshark"),
        "radar_pi": ("unshare", "ip", "g++", "wx-config"),
        "radar_pi in OpenCPN": ("opencpn", "Xvfb", "xdotool", "import", "unshare", "ip", "g++", "make", "wx-config"),
        "radar_pi's ARPA": ("opencpn", "Xvfb", "xdotool", "unshare", "ip", "g++", "make", "wx-config"),
        "halo_radar": ("unshare", "ip", "g++"),
        "mayara-core": ("unshare", "ip", "cargo"),
        "mayara_pi": ("unshare", "ip", "g++"),
        "rosbags": (),
    }
    absent = {name: [each for each in programs if not shutil.which(each)] for name, programs in needed.items()}
    judges: dict[str, Callable[[], str]] = {
        "gpsdecode": lambda: judged(folder),
        "OpenCPN": lambda: drawn(folder),
        "mayara's page": lambda: signalk_page.judged(folder, Path(gui)) if gui else "not asked, without MAYARA_GUI",
        "ASTERIX 240": lambda: dialects.asterix(folder),
        "ASTERIX 048": lambda: dialects.asterix_plots(folder),
        "radar_pi": lambda: dialects.radar_pi(folder),
        "radar_pi in OpenCPN": lambda: opencpn_radar.drawn(folder),
        "radar_pi's ARPA": lambda: opencpn_radar.tracked(folder),
        "halo_radar": lambda: dialects.halo_radar(folder),
        "mayara-core": lambda: dialects.mayara_core(folder),
        "mayara_pi": lambda: dialects.mayara_pi(folder),
        "rosbags": lambda: dialects.ros2_bag(folder),
    }
    for name, judge in judges.items() if not names else [(name, judges[name]) for name in names]:
        print(f"{name}: {f'not asked, without {absent[name]}' if absent[name] else judge()}", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
