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
from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from radar_service.display.video import Controls, Layout, display_video, layout
from radar_service.numerics.types import Singles
from radar_service.radar.sets import radar_sets
from radar_service.scene_file.document import packaged_folder, scene_content, scene_path
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator

Video = npt.NDArray[np.uint8]
QUANTUM = "03 gain, seq clutter, rain tests.pcapng"
LIKE = {
    "garmin_xhd.pcap": "furuno-1824c", "br24-ranges-nm.pcap": "navico-br24", "3g.pcap": "navico-br24",
    "4g-heading.pcap": "navico-br24",
    "halo20-ranges.pcap": "humminbird-hb2124", QUANTUM: "humminbird-hb2124",
}  # fmt: skip
NM, AUTOMATIC = 1852.0, Controls()
APART_M, APART_DEG = 30.0, 2.0  # of what is correlated
SCANS = 8  # of ours; at least three of a capture count
CIRCLE = {"garmin_xhd.pcap": 1440, QUANTUM: 250}  # spokes; of the others 2048
OURS = [{"gain": gain} for gain in (40, 50, 55, 60)] + [{"sea": sea} for sea in (0, 10, 20, 30)] + [{"rain": 10}]
Key = tuple[int, bytes]  # range [m], and the controls that a capture tells: auto and value of gain, colour, sea and rain


class CaptureError(ValueError):
    """A capture that is cut or of another kind; its text names the file."""


def frames(path: Path) -> Iterator[bytes]:
    """Yields the frames of a capture. Raises CaptureError."""
    data = gzip.open(path).read()
    if data[:4] == b"\x0a\x0d\x0d\x0a":
        yield from _blocks(path, data)
        return
    if data[:4] != b"\xd4\xc3\xb2\xa1":
        raise CaptureError(f"{path}: this is no capture by libpcap, little-endian: take the .pcap.gz of that folder")
    at = 24
    while at < len(data):
        size = struct.unpack_from("<I", data, at + 8)[0] if at + 16 <= len(data) else 0
        if not size or at + 16 + size > len(data):
            raise CaptureError(f"{path}: it is cut {len(data) - at} bytes before its end: fetch it again")
        yield data[at + 16 : at + 16 + size]
        at += 16 + size


def _blocks(path: Path, data: bytes) -> Iterator[bytes]:
    """Yields the frames of a capture of the next generation of the format, its enhanced blocks."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from("<II", data, at) if at + 8 <= len(data) else (0, 0)
        if size < 12 or at + size > len(data):
            raise CaptureError(f"{path}: it is cut {len(data) - at} bytes before its end: fetch it again")
        if kind == 6:
            yield data[at + 28 :][: struct.unpack_from("<I", data, at + 20)[0]]
        at += size


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


def spokes(path: Path) -> Iterator[tuple[int, float, Video, bytes]]:
    """Yields number in the circle, range [m] and samples of each spoke, from 0 to 255, and the controls."""
    scanned, controls, halo = 0.0, b"", path.name.startswith("halo")
    for body in datagrams(path):
        if body[:4] == b"\x02\x00\x28\x00" and len(body) >= 228:  # a Quantum's report
            scanned, controls = struct.unpack_from("<I", body, 148 + 4 * body[20])[0] * 1.852, body[22 + 8 * body[21] :][:8]
        if body[:4] == b"\x03\x00\x28\x00" and scanned and len(body) > 20:
            count, of, angle, size = (struct.unpack_from("<H", body, k)[0] for k in (8, 14, 16, 18))
            yield angle, scanned * count / of, np.frombuffer(_unpacked(body[20 : 20 + size]), dtype=np.uint8), controls
        if body[:4] == b"\x98\x09\x00\x00" and len(body) > 36:
            angle, metres = struct.unpack_from("<H", body, 12)[0], struct.unpack_from("<I", body, 16)[0]
            count = struct.unpack_from("<H", body, 26)[0]
            yield angle // 8, float(metres), np.frombuffer(body[-count:], dtype=np.uint8), b""
        for k in range(32) if len(body) == 17160 else ():
            head, samples = body[8 + 536 * k :][:24], np.frombuffer(body[32 + 536 * k :][:512], dtype=np.uint8)
            angle, large, small = struct.unpack_from("<H4xH", head, 8)[0], *struct.unpack_from("<H4xH", head, 6)
            is_4g = head[4:6] == b"\x00\x44" and head[6:8] != b"\x0d\x0e"
            metres = (
                (small / 4 if large == 0x80 else large * (small / 512 if halo else 64))
                if is_4g
                else int.from_bytes(head[12:15], "little") * 10 / 2**0.5
            )
            video = (np.stack([samples & 15, samples >> 4], axis=1).ravel() * 17).astype(np.uint8)
            yield angle // 2 % 2048, metres, video, b""


def _unpacked(data: bytes) -> bytes:
    """Samples of a Quantum: 0x5c stands before a count and what is repeated."""
    result, at = bytearray(), 0
    while at < len(data):
        run = data[at] == 0x5C and at + 2 < len(data)
        result += bytes([data[at + 2]]) * data[at + 1] if run else data[at : at + 1]
        at += 3 if run else 1
    return bytes(result)


def captured_scans(path: Path, least: int = 3) -> dict[Key, Video]:
    """Returns the whole scans (S, A, N) of each range and setting: those that miss no more than a tenth of their spokes."""
    azimuths = CIRCLE.get(path.name.removesuffix(".gz"), 2048)
    scans: dict[Key, list[Video]] = defaultdict(list)
    rows: dict[int, Video] = {}
    before, scale = -1, (0, b"")
    for number, metres, samples, controls in spokes(path):
        if number < before - azimuths // 2 or (round(metres), controls) != scale:
            if len(rows) > 0.9 * azimuths and scale[0]:
                scan = np.zeros((azimuths, max(map(len, rows.values()))), dtype=np.uint8)
                for key, row in rows.items():
                    scan[key, : len(row)] = row
                scans[scale].append(scan)
            rows, scale = {}, (round(metres), controls)
        rows[number], before = samples, number
    return {key: np.stack(found) for key, found in scans.items() if len(found) >= least}


@lru_cache
def our_power(name: str, metres: float) -> tuple[float, Layout, float, list[Singles]]:
    """Returns the scale [m] of a set, how cells become bins, the power of its noise and that of scans of the coast [W]."""
    scene = dict(scene_content(scene_path("coast")))
    scale = min(radar_sets()[name].scales, key=lambda each: abs(np.log(each / metres)))
    scene["radar"] = {"set": name, "range_max_m": scale, "height_m": 10}
    simulator = Simulator(load_scene(scene, folder=packaged_folder("scenes")), "balanced")
    powers, step = [simulator.scan().power for _ in range(SCANS)], simulator.range_step
    count, pulses = powers[0].shape[1], simulator.scene.radar.pulses_integrated
    return scale, layout(count, step / 2.0, step, min(count, 512), pulses=pulses), simulator.noise_power, powers


def our_scans(name: str, metres: float, controls: Controls = AUTOMATIC) -> tuple[float, Video]:
    """Returns the scale [m] and scans (S, A, N) of the coast by a set."""
    scale, to, noise, powers = our_power(name, metres)
    return scale, np.stack([display_video(power, to, controls, noise) for power in powers])


def by_hand(gain: float = 45.0, sea: float = 0.0, rain: float = 0.0) -> Controls:
    """Returns controls without automatic gain and sea."""
    return Controls(gain=gain, sea=sea, rain=rain, gain_auto=False, sea_auto=False)


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
        series = captured_scans(captures / f"{name}.gz")
        for key in sorted(series, key=lambda key: -len(series[key]))[:1]:
            metres = key[0]
            scale, ours = our_scans(like, metres)
            pairs.setdefault(f"{name}, {metres} m", (series[key], ours))
            for what, length, video in ((name, metres, series[key]), (f"ours, {like}", scale, ours)):
                values = " | ".join(f"{value:.3g}" for value in figures(video, length).values())
                print(f"| {what} | {length:.0f} m | {len(video)} | {values} |", flush=True)
    out.mkdir(exist_ok=True)
    draw(pairs, out)
    turned = {f"{key[1].hex(' ')}": video for key, video in captured_scans(captures / f"{QUANTUM}.gz", 2).items()}
    turned |= {f"ours, {each}": our_scans(LIKE[QUANTUM], 2 * NM, by_hand(**each))[1] for each in OURS}
    for what, video in turned.items():
        lit, near = video > 0, video.shape[2] // 8
        shares = f"{100 * lit.mean():.3g} | {100 * lit[:, :, :near].mean():.3g} | {100 * lit[:, :, 4 * near :].mean():.3g}"
        print(f"| {what} | {len(video)} | {shares} | {video[lit].mean():.3g} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
