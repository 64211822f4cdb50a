"""Where the picture fails: pixels larger and smaller than cells, spokes lost, repeated, out of order, numbered anew."""

import numpy as np

from radar_service.display.ppi import Interpolation, Ppi, scan_convert
from radar_service.study.stability.finding import Axis, Finding, crossing, curve, places

AZIMUTHS, BINS = 180, 256
FEW = 32  # bins of pictures whose pixels are much smaller


def pixel_size(fine: int = 1) -> Finding:
    """Single bright cells in pictures of ever larger pixels: what is left of the faintest."""
    ratios = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0])
    left: dict[Interpolation, list[float]] = {"bilinear": [], "peak": []}
    for ratio in ratios:
        for kind, found in left.items():
            found.append(_faintest(kind, max(4, round(2 * BINS / ratio)), 12))
    return Finding(
        "pixels against bins", "single bright cells, scan converted with pixels of different size",
        Axis("pixel / range bin [1]", log=True), places(ratios), Axis("brightness left of the faintest [1]"),
        (curve("bilinear", left["bilinear"]), curve("peak", left["peak"])), 0.5, "half of its brightness",
        crossing(ratios, -np.array(left["bilinear"]), -0.5, log=True), "falls back",
        "Pictures that the service draws use peak, which loses no cell, however large the pixels.",
    )  # fmt: skip


def small_pixels(fine: int = 1) -> Finding:
    """Pictures of ever smaller pixels: places between cells that stay dark, and what a single bright cell loses."""
    ratios = np.array([1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05])
    dark: dict[Interpolation, list[float]] = {"bilinear": [], "peak": []}
    lit = np.ones((AZIMUTHS, FEW), dtype=np.float32)
    for ratio in ratios:
        size = round(2 * FEW / ratio)
        row, column = np.mgrid[:size, :size] + 0.5 - size / 2.0
        inside = np.hypot(row, column) * 2.0 / size < 1.0
        for kind, found in dark.items():
            image = scan_convert(lit, 0.5, 1.0, size, float(FEW), interpolation=kind)
            found.append(float(np.mean(image[inside] < 0.5)))
    return Finding(
        "pixels smaller than bins", "a picture with every cell bright, in ever smaller pixels",
        Axis("pixel / range bin [1]", log=True), places(ratios), Axis("share of pixels that stay dark [1]"),
        (curve("bilinear", dark["bilinear"]), curve("peak", dark["peak"])), 1e-9, "any pixel within range",
        crossing(ratios, np.maximum(dark["bilinear"], dark["peak"]), 1e-9, log=True), "computes right",
        "Every pixel is made of the cells about it, so no gaps open between spokes, however far out or finely drawn.",
    )  # fmt: skip


def _faintest(kind: Interpolation, size: int, cells: int) -> float:
    """Brightness in the picture of the faintest of some single cells of brightness 1."""
    rng = np.random.default_rng(7)
    faintest = 1.0
    for _ in range(cells):
        polar = np.zeros((AZIMUTHS, BINS), dtype=np.float32)
        polar[rng.integers(AZIMUTHS), rng.integers(BINS // 2, BINS - 2)] = 1.0
        faintest = min(faintest, float(scan_convert(polar, 0.5, 1.0, size, float(BINS), interpolation=kind).max()))
    return faintest


def spokes_lost(fine: int = 1) -> Finding:
    """Spokes lost, repeated and shuffled on their way to the accumulator."""
    shares = np.linspace(0.0, 0.9, 10)
    stale, wrong = [], []
    rng = np.random.default_rng(8)
    for share in shares:
        ppi = Ppi(AZIMUTHS, 4, 0.5, 1.0, dtype=np.int64)
        sent = np.arange(2 * AZIMUTHS)
        kept = np.flatnonzero((sent < AZIMUTHS) | (rng.random(len(sent)) >= share))
        order = rng.permutation(np.concatenate([kept, kept]))  # everything twice, in any order
        ppi.add(order % AZIMUTHS, np.repeat(order[:, None], 4, axis=1), order)
        newest = np.array([kept[kept % AZIMUTHS == row].max() for row in range(AZIMUTHS)])
        wrong.append(float((ppi.polar != newest[:, None]).mean()))
        stale.append(float((ppi.age >= AZIMUTHS).mean()))
    return Finding(
        "spokes lost, repeated, out of order", "two scans, the second with losses, all twice and shuffled",
        Axis("share of spokes lost [1]"), places(shares), Axis("share of rows [1]"),
        (curve("not the newest that came", wrong), curve("of the scan before", stale)), 1e-9, "any row that is not",
        crossing(shares, np.array(wrong), 1e-9), "computes right",
        "A row keeps the newest spoke that came; what was lost stays as it was, and age says how old it is.",
    )  # fmt: skip


def numbered_anew(fine: int = 1) -> Finding:
    """A radar that starts anew, and counts from 0, under an accumulator that goes on."""
    run = np.array([0.5, 1.0, 2.0, 5.0, 10.0, 100.0])
    frozen = []
    for scans in run:
        ppi = Ppi(AZIMUTHS, 4, 0.5, 1.0)
        before = np.arange(int(scans * AZIMUTHS))
        ppi.add(before % AZIMUTHS, np.zeros((len(before), 4), dtype=np.uint8), before)
        again = np.arange(AZIMUTHS)
        news = ppi.add(again, np.ones((AZIMUTHS, 4), dtype=np.uint8), again)
        frozen.append(float((~news).mean()))
    return Finding(
        "sequence numbers from 0 again", "an accumulator kept over a restart of the radar",
        Axis("scans before the restart [1]", log=True), places(run), Axis("share of rows that stay frozen [1]"),
        (curve("one picture for both", frozen),), 1e-9, "any row",
        crossing(run, np.array(frozen), 1e-9, log=True), "says so",
        "Numbers older than those shown are late comers. A feed names its stream; clients begin a new picture with it.",
    )  # fmt: skip
