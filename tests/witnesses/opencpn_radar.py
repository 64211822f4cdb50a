"""OpenCPN with the whole plugin radar_pi, built from its sources (`radar_pi.mk`), which draws the radar as xHD and HALO, and
whose ARPA the bench judges on video by the TTM that OpenCPN passes on.

RADAR_PI names the sources with their submodule opencpn-libs. The plugin needs OpenCPN with OpenGL, which Xvfb draws in software,
and lies where a user's plugins do: OpenCPN passes over others.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from radar_service.bench.scenario import scenarios
from tests.witnesses.dialects import alone, serving, still_scene, truth

MAKEFILE = Path(__file__).with_name("radar_pi.mk")
SCREEN = ":78"
NMEA = 10110
ORIGIN = {"latitude_deg": 50.4, "longitude_deg": -1.3}
WX = "base,core,adv,net,aui,gl,xml,html"
LIBRARIES = ["api-18", "nmea0183/src", "nmea0183/include", "wxJSON/include"]
INCLUDES = ["", *(f"/{name}" for name in ("emulator", "garminhd", "garminxhd", "navico", "raymarine"))]
CONFIG = """
#define API_VERSION "1.18"
#define PLUGIN_VERSION_MAJOR 5
#define PLUGIN_VERSION_MINOR 6
#define PLUGIN_VERSION_PATCH 0
#define PLUGIN_VERSION_TWEAK 0
#define PLUGIN_VERSION "5.6.0"
#define PLUGIN_VERSION_WITH_DATE "5.6.0"
#define PKG_PRERELEASE ""
#define PKG_BUILD_INFO ""
"""
RANGE = 1852.0  # of the picture [m]
CENTRE, RADIUS = (599.5, 310.0), 252.0  # of the picture in the window [pixels]
SETTINGS = f"""[Settings]
OpenGL=1
[Settings/GlobalState]
VPLatLon=  50.4000,   -1.3000
VPScale=0.05
[Settings/NMEADataSource]
DataConnections=1;0;127.0.0.1;{NMEA};0;;4800;1;0;0;;0;;0;0;0;0;1;;0;0;;
[PlugIns/libradar_pi.so]
bEnabled=1
[Plugins/Radar]
RadarCount=1
Radar0Type=Garmin xHD
Radar0Interface=172.16.2.0
Show=1
"""
# ARPA acquires all in a circle of 4 km, of echoes from 100 of 255 on, and its sentences leave by UDP. The ship is at rest.
ARPA = (
    SETTINGS.replace(";0;0;;\n", ";0;0;;|1;1;127.0.0.1;PORT;0;;4800;1;2;0;;0;;0;0;0;0;1;;0;0;;\n")
    + """Radar0WindowShow=0
Radar0Zone0Type=1
Radar0Zone0InnerRange=100
Radar0Zone0OuterRange=4000
Radar0Zone0ArpaOn=1
Refreshrate=1
ThresholdRed=100
FixedHeading=1
"""
)
PLOTTER = f"""#!/bin/sh
export HOME=$1-run DISPLAY={SCREEN}
rm -rf $HOME && cp -r $1 $HOME
sed -i "s/PORT/$2/" $HOME/.opencpn/opencpn.conf
Xvfb {SCREEN} -screen 0 1280x900x24 +extension GLX >&2 &
until xdotool getdisplaygeometry >/dev/null 2>&1; do sleep 0.2; done
opencpn &
until xdotool search --name Welcome >/dev/null 2>&1; do sleep 0.2; done
while xdotool search --name Welcome windowraise mousemove 817 628 click 1 >/dev/null 2>&1; do sleep 0.5; done
wait
"""
JUDGED = ("late", "crossing-cpa-500")
SHOWN = f"""Xvfb {SCREEN} -screen 0 1280x900x24 +extension GLX & screen=$!
$SERVE >&2 & service=$!
sleep 8
opencpn & chart=$!
sleep 10
xdotool search --name Welcome windowraise; xdotool mousemove 817 628 click 1
sleep 12
xdotool search --name "$TITLE" windowmap %@ windowraise %@
xdotool search --name "$TITLE" windowsize %@ 560 585 windowmove %@ 320 10
sleep 15
import -window root -crop 896x630+0+0 +repage "$PICTURE"
kill $chart $service $screen
"""


def plugin(folder: Path, sources: Path) -> Path:
    """Builds the plugin, some six minutes of processor time at first."""
    build = folder / "radar_pi"
    build.mkdir(exist_ok=True)
    (build / "config.h").write_text(CONFIG)
    folders = [f"-I{sources}/include{name}" for name in INCLUDES]
    folders += [f"-I{sources}/opencpn-libs/{name}" for name in LIBRARIES]
    command = ["make", "-s", "-C", str(build), "-f", str(MAKEFILE), "-j2", f"RADAR={sources}", f"WX={WX}"]
    command.append(f"INCLUDES={' '.join(folders)}")
    subprocess.run(command, check=True)
    return build / "libradar_pi.so"


def drawn(folder: Path) -> str:
    """Lets OpenCPN with radar_pi draw the reflectors on FOLDER/opencpn-radar.png and opencpn-halo.png. Raises AssertionError."""
    if not (name := os.environ.get("RADAR_PI", "")):
        return "not asked, without RADAR_PI"
    farthest = []
    for title, option in (("Navico Halo A", "navico-halo"), ("Garmin xHD", "garmin-xhd")):
        picture = folder / f"opencpn-{'radar' if option == 'garmin-xhd' else 'halo'}.png"
        home = home_for(folder / "opencpn-radar", Path(name).resolve(), SETTINGS.replace("Garmin xHD", title))
        service = serving(folder, f"--{option}", "br0", "--nmea-tcp", str(NMEA))
        scene = folder / "reflectors.json"
        scene.write_text(json.dumps(json.loads(scene.read_text()) | {"origin": ORIGIN}))
        own = {"HOME": str(home), "DISPLAY": SCREEN, "SERVE": " ".join(service), "PICTURE": str(picture), "TITLE": title}
        picture.unlink(missing_ok=True)
        command = alone(["sh", "-c", SHOWN])
        subprocess.run(command, env=os.environ | own, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        farthest.append(f"{judged(picture):.1f} pixels as {title}, {picture}")
    return f"at most {' and '.join(farthest)}, of {RANGE / RADIUS:.1f} m, from five reflectors"


def home_for(home: Path, sources: Path, settings: str) -> Path:
    """Makes a user's folder with the plugin."""
    shutil.rmtree(home, ignore_errors=True)
    for place in (".opencpn", ".local/lib/opencpn", ".local/share/opencpn/plugins/radar_pi"):
        (home / place).mkdir(parents=True)
    (home / ".opencpn" / "opencpn.conf").write_text(settings)
    shutil.copy(plugin(home.parent, sources), home / ".local/lib/opencpn")
    shutil.copytree(sources / "data", home / ".local/share/opencpn/plugins/radar_pi/data")
    return home


def tracked(folder: Path) -> str:
    """Lets the bench judge the ARPA of radar_pi on two scenarios, one seed each, in real time (eight minutes)."""
    if not (name := os.environ.get("RADAR_PI", "")):
        return "not asked, without RADAR_PI"
    home, out = home_for(folder / "opencpn-arpa", Path(name).resolve(), ARPA), folder / "arpa"
    (plotter := folder / "plotter.sh").write_text(PLOTTER)
    files = [folder / f"{scenario}.toml" for scenario in JUDGED]
    for file in files:  # NMEA needs a place on the earth
        origin = "".join(f"{key} = {value}\n" for key, value in ORIGIN.items())
        file.write_text(f"{scenarios()[file.stem].read_text()}\n[scene.origin]\n{origin}")
    command = [sys.executable, "-m", "radar_service", "bench-tracker", *map(str, files), "--seeds", "1", "--fixed", "--open"]
    command += ["--jobs", "1", "--input", "video", "--answers", "ttm", "--serve", f"--garmin-xhd br0 --nmea-tcp {NMEA}"]
    command += ["--tracker", f"sh {plotter} {home} {{udp}}", "--record", "-o", str(out)]
    subprocess.run(alone(command), check=False, capture_output=True)
    told = json.loads((out / "report.json").read_text())["scenarios"]
    assert not any(each["failures"] for each in told), told[0]["failures"]
    shown = ("held", "first_state_scans", "velocity_kn_3min", "localisation_m", "delay_s")
    figures = "; ".join(f"{each['name']} {[(key, each['metrics'].get(key)) for key in shown]}" for each in told)
    return f"{figures}; {out}/report.html shows the worst events, and its recordings open by `radar-service replay`"


def judged(picture: Path) -> float:
    """Returns how far [pixels] the reflectors are from the echoes that are nearest. Raises AssertionError."""
    image = np.asarray(Image.open(picture).convert("RGB")).astype(int)
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    inside = np.hypot(columns - CENTRE[0], rows - CENTRE[1]) < RADIUS
    row, column = np.nonzero(inside & (image[..., 2] > 110) & (image[..., 0] < 80))
    assert len(row) < 500, "more than five small echoes"
    farthest = 0.0
    for crossing in truth():
        angle, away = (
            crossing["bearing"] - np.radians(still_scene()["own_ship"]["heading_deg"]),
            crossing["range"] / RANGE * RADIUS,
        )
        place = CENTRE[0] + away * np.sin(angle), CENTRE[1] - away * np.cos(angle)
        farthest = max(farthest, float(np.hypot(column - place[0], row - place[1]).min()))
    assert farthest < 2.0, farthest
    return farthest
