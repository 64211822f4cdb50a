"""The picture of a run: a map with tracks joined and coloured by name, and how far they are from their targets."""

import base64
import io
import math
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from radar_service.bench.run import simulator_of
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.events import Event, gravest
from radar_service.bench.scores.judged_scan import CUTOFF
from radar_service.display.picture import picture_from_power
from radar_service.display.ppi import scan_convert
from radar_service.numerics import Floats, Singles
from radar_service.scans import Scan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = 800  # pixels of a PPI
MIN_HALF_WIDTH = 100.0  # m, of the map
MAX_NAMES = 8  # of targets or tracks in a legend: more leave no room for the map
MARGIN = 2.0  # s about the time of the chart
MAX_MARKS = 6  # events that are marked
STYLES = ("-", "--", ":", "-.")  # of targets in the chart of distances
NO_TRACK = "0.6"  # the colour of a target there
DARKEST = 2.5  # brightness of the PPI that would be black: plots and targets are seen where noise alone fills the picture


def run_picture(run: Mapping[str, Any]) -> str:
    """Returns the picture of a run with at least one scan, over the PPI in `ppi` where it has one; as `png_text`."""

    def draw(figure: "Figure") -> None:
        chart, errors = figure.subplots(1, 2)
        colours = track_colours(run["scans"])
        _draw_map(chart, run, colours)
        _draw_distances(errors, run, colours)

    return png_text((11.0, 4.8), draw)


def png_text(size: tuple[float, float], draw: Callable[["Figure"], None]) -> str:
    """Returns the figure of a size [inches] that `draw` fills, a PNG in base 64; empty where matplotlib is absent."""
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        return ""
    figure, buffer = Figure(figsize=size, layout="constrained"), io.BytesIO()
    draw(figure)
    figure.savefig(buffer, format="png", dpi=100)
    return base64.b64encode(buffer.getvalue()).decode()


def track_colours(scans: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Returns the colour of each track by its name, in the order in which they come; ten colours return again and again."""
    names = dict.fromkeys(track["track"] for scan in scans for track in scan["tracks"])
    return {name: f"C{k % 10}" for k, name in enumerate(names)}


def joined(scans: Sequence[Mapping[str, Any]], track: str, stale: bool = False) -> Floats:
    """Returns the states (scans, 2) of a track [m], nan where it has none, so that a line through them is broken there. stale:
    whether states that are too old are among them."""
    states = [
        next((each for each in scan["tracks"] if each["track"] == track and (stale or not each.get("stale"))), None)
        for scan in scans
    ]
    return np.array([(state["east"], state["north"]) if state else (math.nan, math.nan) for state in states])


def _draw_map(chart: "Axes", run: Mapping[str, Any], colours: Mapping[str, str]) -> None:
    scans = run["scans"]
    chart.plot(*_points(scan["plots"] for scan in scans).T, ".", color="0.3", markersize=2, label="plots")
    bodies = _bodies(scans)
    for k, body in enumerate(bodies):
        path = np.array([target["position"] for _, target in _of_body(scans, body)])
        chart.plot(*path.T, color="0.5", linewidth=5.0, alpha=0.35, label=_legend("targets", k))
        if len(bodies) <= MAX_NAMES:
            chart.annotate(body, path[0], fontsize="small", color="0.3", xytext=(4, 4), textcoords="offset points")
    for k, (track, colour) in enumerate(colours.items()):
        label = f"track {track}"[:24] if len(colours) <= MAX_NAMES else _legend(f"{len(colours)} tracks", k)
        stale = joined(scans, track, stale=True)  # of which alone what is too old is seen
        chart.plot(*stale.T, "--", color=colour, linewidth=1.0)
        chart.plot(*joined(scans, track).T, ".-", color=colour, linewidth=1.0, markersize=3, label=label)
    own = _points([scan["own"]] for scan in scans)
    chart.plot(*own.T, color="red", linewidth=1.0)
    chart.plot(*own[-1:].T, "^", color="red", markersize=6, label="own ship")
    for event in gravest_of(run, MAX_MARKS):
        target = next((each for each in scans[event.scan]["targets"] if each["body"] == event.body), None)
        if target:
            chart.plot(*target["position"], "o", markersize=12, markerfacecolor="none", markeredgecolor="black")
            chart.annotate(_mark(event), target["position"], fontsize="small", xytext=(8, -10), textcoords="offset points")
    if ppi := run.get("ppi"):  # behind all else; echoes are dark
        (east, north), reach = own[-1], ppi["range"]
        extent = (east - reach, east + reach, north - reach, north + reach)
        chart.imshow(image_of(ppi), cmap="Greys", vmin=0.0, vmax=DARKEST, extent=extent, interpolation="nearest", zorder=0)
    tracks = _points([[track["east"], track["north"]] for track in scan["tracks"]] for scan in scans)
    targets = _points([target["position"] for target in scan["targets"]] for scan in scans)
    _zoom(chart, np.concatenate([own, tracks, targets]), own[-1])
    chart.legend(fontsize="small")


def _draw_distances(errors: "Axes", run: Mapping[str, Any], colours: Mapping[str, str]) -> None:
    """The distance of the nearest track of each target in the style of the target, in the colour of the track that follows it."""
    scans, bodies = run["scans"], _bodies(run["scans"])
    for k, body in enumerate(bodies):
        style = STYLES[k % len(STYLES)]
        seen = [(scan["time"], target) for scan, target in _of_body(scans, body)]
        time = np.array([at for at, _ in seen])
        distance = np.array([math.nan if target["nearest"] is None else target["nearest"] for _, target in seen])
        label = body if len(bodies) <= MAX_NAMES else _legend(f"{len(bodies)} targets", k)
        errors.plot(time, distance, style, color=NO_TRACK, linewidth=1.0, label=label)
        for track in {target["track"] for _, target in seen} & colours.keys():
            follows = np.array([target["track"] == track for _, target in seen])
            errors.plot(time, np.where(follows, distance, math.nan), style, color=colours[track], linewidth=1.5)
    allowed = sorted({target["allowed"] for scan in scans for target in scan["targets"]})
    for k, limit in enumerate(allowed):
        errors.axhline(limit, color="C3", linestyle="--", label=_legend("limit of the mean distance", k))
    errors.axhline(CUTOFF, color="black", linestyle="--", linewidth=1.0, label="limit of a track that follows")
    for k, event in enumerate(gravest_of(run, MAX_MARKS)):
        errors.axvline(scans[event.scan]["time"], color="0.4", linestyle=":", label=_legend("events", k))
        place = scans[event.scan]["time"], 1.0 - 0.05 * (k + 1)
        errors.annotate(_mark(event), place, xycoords=("data", "axes fraction"), fontsize="small")
    errors.set(xlabel="time [s]", ylabel="distance of the nearest track [m]", yscale="log")
    errors.set_xlim(scans[0]["time"] - MARGIN, scans[-1]["time"] + MARGIN)  # where no track is near anything, too
    errors.legend(fontsize="small")


def gravest_of(run: Mapping[str, Any], count: int) -> list[Event]:
    """Returns the gravest events of a run."""
    return gravest([Event(**event) for event in run["events"]], count)


def _mark(event: Event) -> str:
    return f"{event.kind}, scan {event.scan}"


def _legend(text: str, number: int) -> str:
    """The text for the first of several; what begins with "_" is in no legend."""
    return "_" if number else text


def _bodies(scans: Iterable[Mapping[str, Any]]) -> list[str]:
    return sorted({target["body"] for scan in scans for target in scan["targets"]})


def _of_body(scans: Sequence[Mapping[str, Any]], body: str) -> list[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """The scans that have a target, with the target in them."""
    return [(scan, target) for scan in scans for target in scan["targets"] if target["body"] == body]


def _points(scans: Iterable[Sequence[Sequence[float]]]) -> Floats:
    """All points (K, 2) of scans."""
    return np.array([point for points in scans for point in points], dtype=np.float64).reshape(-1, 2)


def _zoom(chart: "Axes", points: Floats, centre: Floats) -> None:
    """Shows points (K, 2), whatever false plots lie elsewhere, with range rings about a centre (2,)."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    half = max(0.55 * float(np.ptp(points, axis=0).max()), MIN_HALF_WIDTH)
    chart.set(
        xlabel="east [m]", ylabel="north [m]", aspect="equal", xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
    )  # fmt: skip
    step = 10.0 ** math.floor(math.log10(half))
    bearing = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack([np.sin(bearing), np.cos(bearing)])
    for ring in step * np.arange(1, math.ceil(4.0 * half / step)):
        chart.plot(*(centre[:, None] + ring * circle), color="0.85", linewidth=0.6, zorder=0)


def ppi_of(scan: Scan) -> dict[str, Any]:
    """Returns the PPI of a scan as plain data, north up: `range`, half its width [m], and `pixels`, bytes of brightness row by
    row, deflated and in base 64."""
    reach = float(scan.range[-1] + scan.range_step / 2.0)
    bright = picture_from_power(np.nan_to_num(scan.power))
    image = scan_convert(bright, float(scan.range[0]), scan.range_step, SIZE, reach, interpolation="peak")
    return {"range": reach, "pixels": base64.b64encode(zlib.compress(np.rint(image).astype(np.uint8).tobytes())).decode()}


def ppi_at(scenario: Scenario, seed: int, scan: int) -> dict[str, Any]:
    """Returns the PPI of a scan of a scenario and a seed, which alone is simulated. Raises SceneError."""
    simulator = simulator_of(scenario, seed)
    simulator.skip_to(scan)
    return ppi_of(simulator.scan())


def image_of(ppi: Mapping[str, Any]) -> Singles:
    """Returns the brightness (SIZE, SIZE), 0 to 1, of what `ppi_of` returned; row 0 is in the north."""
    pixels = np.frombuffer(zlib.decompress(base64.b64decode(ppi["pixels"])), dtype=np.uint8)
    return pixels.reshape(SIZE, SIZE).astype(np.float32) / np.float32(255.0)
