"""The pictures of the README, each from a run: `python -m tests.measurements.readme_pictures FOLDER [CHART]`, two minutes.

FOLDER gets page.png, the page as Chromium shows it on the harbour, and labels.png, the sources of a scan of the harbour.
CHART is the chart.json of `radar-service chart harbour`: presets.png shows what its presets err by and take.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter
from PIL import Image

import radar_service as rs
from radar_service.display.ppi import scan_convert
from radar_service.display.video import Controls, display_video, layout
from radar_service.study.plotting import COLOURS, LIMIT, SMALL, duration, new_figure, percent, png_bytes, style
from tests.clients.chromium import Browser

SPOKES = "Number(document.getElementById('scope').dataset.drawn?.split(':')[1]) > {}"
SIZE = 960  # pixels of the labelled picture
SOURCES = {  # what the name of a label matches: colour and title
    "sea": ("#2f6fb5", "sea"),
    "land: vegetation": ("#3f9a63", "land: vegetation"),
    "land: rock": ("#a9a9a9", "rock"),
    "land: building": ("#e0783c", "building"),
    "land: concrete": ("#f0c040", "concrete"),
    "range sidelobes": ("#b27fd6", "sidelobes"),
    "buoy|reflector": ("#ff8fc8", "buoys, reflectors"),
    "ferry|coaster|tanker|ship|boat": ("#ffffff", "ships"),
}
OFFSETS = {"tanker at anchor": (10, -34), "coaster": (-120, 22), "moored ship": (14, -26)}


def page(path: Path) -> None:
    """Writes the page on the harbour after two scans, at a tenth of the speed: Chromium may draw WebGL in software."""
    command = [sys.executable, "-m", "radar_service", "serve", "--port", "0", "--pace", "0.1"]
    with tempfile.TemporaryDirectory() as profile, subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout is not None
        address = re.search(r"http://[\d.:]+", service.stdout.readline())
        assert address is not None
        browser = Browser(Path(profile))
        shown = browser.open(f"{address[0]}/?detail=full", 1040, 780)
        for scan in (1, 2):
            shown.wait(SPOKES.format(scan * 720))
        shown.look(path)
        browser.close()
        service.terminate()
    Image.open(path).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


def labelled(path: Path) -> None:
    """Writes a scan of the harbour, each echo that the display shows in the colour of its strongest source."""
    simulator = rs.Simulator(rs.load_scene("harbour"), labels=True)
    scan = simulator.scan()
    assert scan.labels is not None
    to = layout(simulator.range.size, float(simulator.range[0]), simulator.range_step)
    video = display_video(scan.power, to, Controls(), simulator.noise_power)
    shown = np.zeros((len(SOURCES), SIZE, SIZE))
    for image, pattern in zip(shown, SOURCES, strict=True):
        numbers = [number for number, name in simulator.label_names.items() if re.search(pattern, name)]
        cells = np.where(np.isin(scan.labels, numbers), video, 0)
        image[:] = scan_convert(cells, to.first, to.step, SIZE, to.range, interpolation="peak")
    colours = np.array([[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour, _ in SOURCES.values()]) / 255.0
    level = np.where(shown.max(axis=0) > 0.5, 0.45 + 0.55 * np.minimum(shown.max(axis=0) / 120.0, 1.0), 0.0)
    with style():
        figure = new_figure(SIZE / 200.0, SIZE / 200.0)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.imshow(level[..., None] * colours[shown.argmax(axis=0)])
        axes.axis("off")
        _name_bodies(axes, simulator, to.range)
        marks = [Line2D([], [], color=c, marker="s", linestyle="none", label=title) for c, title in SOURCES.values()]
        axes.legend(handles=marks, loc="lower right", labelcolor="white", fontsize=6.5, handletextpad=0.2)
        path.write_bytes(png_bytes(figure))


def _name_bodies(axes: Axes, simulator: rs.Simulator, range_max: float) -> None:
    for crossing in simulator.crossings(0):
        if re.search("tanker|ferry|coaster|moored|pilot|rocks", crossing.body):
            x, y = (
                SIZE / 2 * (1 + s * f(crossing.bearing) * crossing.range / range_max) for s, f in ((1, np.sin), (-1, np.cos))
            )
            axes.annotate(
                crossing.body,
                (x, y),
                OFFSETS.get(crossing.body, (14, 14)),
                textcoords=("offset pixels"),
                color="white",
                fontsize=6.5,
            )


def presets(chart: dict[str, Any], path: Path) -> None:
    """Writes error against CPU time per azimuth of each preset: the field, and the power of diffuse targets."""
    titles = {
        "field": ("Field against the closed form", "relative error [dB]"),
        "power": ("Power of diffuse targets", "error of mean and spread [dB]"),
    }
    real_time = chart["real_time_seconds_per_azimuth"]
    with style():
        figure = new_figure(3.6)
        figure.text(0.01, 0.95, f'Presets on "{chart["scene"]}": lower left is better', weight="bold", fontsize=10)
        for left, (panel, (title, error)) in zip((0.07, 0.57), titles.items(), strict=True):
            axes = figure.add_axes((left, 0.14, 0.41, 0.68))
            axes.set(xscale="log", yscale="log" if panel == "power" else "linear", title=title, ylabel=error)
            axes.set_xlabel(f"CPU time per azimuth, {chart['machine']['processor']}")
            for point in chart["points"]:
                if point["panel"] == panel and point["preset"]:
                    _draw_preset(axes, point, real_time)
            axes.axvline(real_time, color=LIMIT, linestyle="--", linewidth=1.2)
            axes.margins(0.2, 0.3)
            axes.set_xlim(5e-7, 1.0)
            axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: duration(x)))
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
            axes.text(
                real_time * 1.2,
                0.87,
                "slower than\nreal time",
                color=LIMIT,
                fontsize=SMALL,
                transform=axes.get_xaxis_transform(),
            )
        path.write_bytes(png_bytes(figure))


def _draw_preset(axes: Axes, point: dict[str, Any], real_time: float) -> None:
    """One preset: its name, and how many times faster than real time; hollow under way."""
    names, under_way, _ = point["preset"].partition(" under way")
    colour = COLOURS[["fast", "balanced", "reference", "documented"].index(names.split(", ")[0])]
    at = point["seconds_per_azimuth"], point["charted_db"]
    axes.plot(*at, "o", color=colour, markerfacecolor="white" if under_way else colour, markersize=8)
    missed = f"\n{percent(point['missed'])} of targets missed" if point["missed"] else ""
    text = f"{point['preset']}\n{real_time / at[0]:.2g} x real time{missed}"
    side = 1 if under_way else -1
    axes.annotate(
        text, at, (8 * side, 0), textcoords="offset points", ha={1: "left", -1: "right"}[side], va="center", fontsize=SMALL
    )


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    page(folder / "page.png")
    labelled(folder / "labels.png")
    for chart in sys.argv[2:]:
        presets(json.loads(Path(chart).read_text(encoding="utf-8")), folder / "presets.png")
