"""Video of real sets beside ours: shares of cells without an echo, runs, correlations. Opt-in, and nothing of it is committed.

`python -m tests.measurements.captured_video CAPTURES OUT`: CAPTURES holds the captures that LIKE names, from the examples
of opencpn-radar-pi/radar_pi, packed; a table is printed, and OUT gets pictures.
Each capture stands beside the scene `coast` by the set that is nearest, on the scale nearest, as its automatic controls show it.
"""

import gzip
import struct
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from radar_service.display.video import Controls, display_video, layout
from radar_service.radar.sets import radar_sets
from radar_service.scene_file.document import packaged_folder, scene_content, scene_path
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator

Video = npt.NDArray[np.uint8]
LIKE = {
    "garmin_xhd": "furuno-1824c", "br24-ranges-nm": "navico-br24", "3g": "navico-br24", "4g-heading": "navico-br24",
}  # fmt: skip
APART_M, APART_DEG = 30.0, 2.0  # of what is correlated
SCANS = 8  # of ours; at least three of a capture count
CIRCLE = {"garmin_xhd": 1440}  # spokes; of the others 2048


class CaptureError(ValueError):
    """A capture that is cut or of another kind; its text names the file."""


def frames(path: Path) -> Iterator[bytes]:
    """Yields the frames of a capture. Raises CaptureError."""
    data = gzip.open(path).read()
    if data[:4] != b"\xd4\xc3\xb2\xa1":
        raise CaptureError(f"{path}: this is no capture by libpcap, little-endian: take the .pcap.gz of that folder")
    at = 24
    while at < len(data):
        size = struct.unpack_from("<I", data, at + 8)[0] if at + 16 <= len(data) else 0
        if not size or at + 16 + size > len(data):
            raise CaptureError(f"{path}: it is cut {len(data) - at} bytes before its end: fetch it again")
        yield data[at + 16 : at + 16 + size]
        at += 16 + size


def datagrams(path: Path) -> Iterator[bytes]:
    """Yields what UDP carries, joined where IP has cut it."""
    pieces: dict[bytes, dict[int, bytes]] = defaultdict(dict)
    for frame in frames(path):
        packet = frame[14:]
        if packet[:1] != b"\x45" or packet[9] != 17:
            continue
        length, number, flags = struct.unpack_from(">HHH", packet, 2)
        parts = pieces[packet[12:16] + packet[4:6]]
        parts[(flags & 0x1FFF) * 8] = packet[20:length]
        if not flags & 0x2000:
            whole = b"".join(parts[key] for key in sorted(parts))
            if len(whole) == max(parts) + len(packet[20:length]):
                yield whole[8:]
            pieces.pop(packet[12:16] + packet[4:6])


def spokes(path: Path) -> Iterator[tuple[int, float, Video]]:
    """Yields number in the circle, range [m] and samples of each spoke, from 0 to 255."""
    for body in datagrams(path):
        if body[:4] == b"\x98\x09\x00\x00" and len(body) > 36:
            angle, metres = struct.unpack_from("<H", body, 12)[0], struct.unpack_from("<I", body, 16)[0]
            count = struct.unpack_from("<H", body, 26)[0]
            yield angle // 8, float(metres), np.frombuffer(body[-count:], dtype=np.uint8)
        for k in range(32) if len(body) == 17160 else ():
            head, samples = body[8 + 536 * k :][:24], np.frombuffer(body[32 + 536 * k :][:512], dtype=np.uint8)
            angle, large, small = struct.unpack_from("<H4xH", head, 8)[0], *struct.unpack_from("<H4xH", head, 6)
            is_4g = head[4:6] == b"\x00\x44" and head[6:8] != b"\x0d\x0e"
            metres = (
                (small / 4 if large == 0x80 else large * 64)
                if is_4g
                else int.from_bytes(head[12:15], "little") * 10 / 2**0.5
            )
            yield angle // 2 % 2048, metres, (np.stack([samples & 15, samples >> 4], axis=1).ravel() * 17).astype(np.uint8)


def captured_scans(path: Path) -> dict[int, Video]:
    """Returns the whole scans (S, A, N) of each range [m]: those that miss no more than a tenth of their spokes."""
    azimuths = CIRCLE.get(path.name.removesuffix(".pcap.gz"), 2048)
    scans: dict[int, list[Video]] = defaultdict(list)
    rows: dict[int, Video] = {}
    before, scale = -1, 0
    for number, metres, samples in spokes(path):
        if number < before - azimuths // 2 or round(metres) != scale:
            if len(rows) > 0.9 * azimuths and scale:
                scan = np.zeros((azimuths, max(map(len, rows.values()))), dtype=np.uint8)
                for key, row in rows.items():
                    scan[key, : len(row)] = row
                scans[scale].append(scan)
            rows, scale = {}, round(metres)
        rows[number], before = samples, number
    return {metres: np.stack(found) for metres, found in scans.items() if len(found) >= 3}


def our_scans(name: str, metres: float) -> tuple[float, Video]:
    """Returns the scale [m] and scans (S, A, N) of the coast by a set, as automatic controls show it."""
    scene = dict(scene_content(scene_path("coast")))
    scale = min(radar_sets()[name].scales, key=lambda each: abs(np.log(each / metres)))
    scene["radar"] = {"set": name, "range_max_m": scale, "height_m": 10}
    simulator = Simulator(load_scene(scene, folder=packaged_folder("scenes")), "balanced")
    controls = Controls(gain_auto=True, sea_auto=True)
    shown = []
    for _ in range(SCANS):
        power = simulator.scan().power
        cells, pulses = (power.shape[1], simulator.range_step), simulator.scene.radar.pulses_integrated
        to = layout(cells[0], cells[1] / 2.0, cells[1], min(cells[0], 512), pulses=pulses)
        shown.append(display_video(power, to, controls, simulator.noise_power))
    return scale, np.stack(shown)


def figures(video: Video, metres: float) -> dict[str, float]:
    """Share of samples without an echo [%], mean runs with one [m, degrees], correlations of what comes and goes, mean of 255."""
    lit, size = video > 0, (metres / video.shape[2], 360.0 / video.shape[1])
    runs = [lit.sum() / (np.diff(lit, axis=axis).sum() / 2.0 + 1.0) for axis in (2, 1)]
    share = lit.mean(axis=0)
    loose = (share > 0.1) & (share < 0.9)
    swing = np.where(loose, video - video.mean(axis=0), 0.0)
    shifts = [(1, max(1, round(APART_M / size[0]))), (0, max(1, round(APART_DEG / size[1])))]
    moved = [
        _correlation(swing, np.roll(swing, -lag, axis + 1), loose & np.roll(loose, -lag, axis=axis)) for axis, lag in shifts
    ]
    return {
        "zero": 100.0 * (1.0 - float(lit.mean())), "run m": float(runs[0] * size[0]), "run deg": float(runs[1] * size[1]),
        "range": moved[0], "azimuth": moved[1],
        "scan": _correlation(swing[:-1], swing[1:], loose) + 1.0 / (len(video) - 1.0),
        "mean": float(video[lit].mean()) if lit.any() else 0.0,
    }  # fmt: skip


def _correlation(one: npt.NDArray[np.float64], other: npt.NDArray[np.float64], where: npt.NDArray[np.bool_]) -> float:
    a, b = one[:, where], other[:, where]
    return float((a * b).sum() / max(np.sqrt((a**2).sum() * (b**2).sum()), 1e-9))


def draw(pairs: dict[str, tuple[Video, Video]], out: Path) -> None:
    """Draws a scan of each capture above ours: azimuth downward, range to the right."""
    from matplotlib.figure import Figure

    drawing = Figure(figsize=(3.2 * len(pairs), 6.4), layout="constrained")
    for axes, (title, video) in zip(
        drawing.subplots(2, len(pairs), squeeze=False).T.ravel(),
        [(f"{name}{what}", pair[k]) for name, pair in pairs.items() for k, what in ((0, ""), (1, ", ours"))],
        strict=True,
    ):
        axes.imshow(video[0], aspect="auto", cmap="gray")
        axes.set_title(title, fontsize=8)
        axes.set_axis_off()
    drawing.savefig(out / "captured.png", dpi=130)


def main(captures: Path, out: Path) -> None:
    """Prints the table, and draws the longest series of each capture."""
    pairs: dict[str, tuple[Video, Video]] = {}
    print("| video | range | scans | without echo | run in range | in azimuth | at 30 m | at 2 deg | scan to scan | mean |")
    print("| --- " * 10 + "|")
    for name, like in LIKE.items():
        series = captured_scans(captures / f"{name}.pcap.gz")
        for metres in sorted(series, key=lambda key: -len(series[key]))[:1]:
            scale, ours = our_scans(like, metres)
            pairs.setdefault(f"{name}, {metres} m", (series[metres], ours))
            for what, length, video in ((name, metres, series[metres]), (f"ours, {like}", scale, ours)):
                values = " | ".join(f"{value:.3g}" for value in figures(video, length).values())
                print(f"| {what} | {length:.0f} m | {len(video)} | {values} |", flush=True)
    out.mkdir(exist_ok=True)
    draw(pairs, out)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
