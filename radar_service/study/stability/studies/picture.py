"""The picture: pixels larger and smaller than range bins, and spokes lost, repeated, shuffled or renumbered."""

import numpy as np

from radar_service.display.ppi import Interpolation, Ppi, scan_convert
from radar_service.study.stability.finding import Axis, Expected, Finding, crossing, curve, plain

AZIMUTHS, BINS = 180, 256
FEW_BINS = 32  # of pictures with small pixels


def pixel_size(fine: int = 1) -> Finding:
    """Drives the size of pixels: brightness of the faintest of single bright cells."""
    ratios = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0])
    brightness: dict[Interpolation, list[float]] = {"bilinear": [], "peak": []}
    for ratio in ratios:
        for interpolation, values in brightness.items():
            values.append(_faintest(interpolation, max(4, round(2 * BINS / ratio)), 12))
    return Finding(
        name="large pixels",
        method="bilinear interpolation",
        setup="single bright cells, scan converted with pixels of different size",
        parameter=Axis("pixel / range bin [1]", log=True),
        values=plain(ratios),
        measured=Axis("brightness of the faintest cell [1]"),
        curves=(curve("bilinear", brightness["bilinear"]), curve("peak", brightness["peak"])),
        limit=0.5,
        limit_reason="half of the brightness",
        boundary=crossing(ratios, -np.array(brightness["bilinear"]), -0.5, log=True),
        expected=Expected(1.567, 0.05, "measured"),
        response="another method",
        instead="peak interpolation",
        details="The service draws its pictures with peak interpolation, which keeps every cell at every size of pixels.",
    )


def small_pixels(fine: int = 1) -> Finding:
    """Drives the size of pixels below a range bin: share of dark pixels where every cell is bright."""
    ratios = np.array([1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05])
    dark: dict[Interpolation, list[float]] = {"bilinear": [], "peak": []}
    bright = np.ones((AZIMUTHS, FEW_BINS), dtype=np.float32)
    for ratio in ratios:
        size = round(2 * FEW_BINS / ratio)
        row, column = np.mgrid[:size, :size] + 0.5 - size / 2.0
        inside = np.hypot(row, column) * 2.0 / size < 1.0
        for interpolation, values in dark.items():
            image = scan_convert(bright, 0.5, 1.0, size, float(FEW_BINS), interpolation=interpolation)
            values.append(float(np.mean(image[inside] < 0.5)))
    return Finding(
        name="small pixels",
        method="bilinear and peak interpolation",
        setup="a picture with every cell bright, with pixels of different size",
        parameter=Axis("pixel / range bin [1]", log=True),
        values=plain(ratios),
        measured=Axis("share of dark pixels [1]"),
        curves=(curve("bilinear", dark["bilinear"]), curve("peak", dark["peak"])),
        limit=1e-9,
        limit_reason="any pixel within range",
        boundary=crossing(ratios, np.maximum(dark["bilinear"], dark["peak"]), 1e-9, log=True),
        expected=Expected(None),
        response="no failure",
        instead="interpolation between the cells around each pixel",
        details="Each pixel takes its value from the cells around it, so no gaps open between spokes.",
    )


def _faintest(interpolation: Interpolation, size: int, cells: int) -> float:
    """Returns the brightness in the picture of the faintest of some single cells of brightness 1."""
    rng = np.random.default_rng(7)
    faintest = 1.0
    for _ in range(cells):
        polar = np.zeros((AZIMUTHS, BINS), dtype=np.float32)
        polar[rng.integers(AZIMUTHS), rng.integers(BINS // 2, BINS - 2)] = 1.0
        image = scan_convert(polar, 0.5, 1.0, size, float(BINS), interpolation=interpolation)
        faintest = min(faintest, float(image.max()))
    return faintest


def spokes_lost(fine: int = 1) -> Finding:
    """Drives the share of lost spokes; all others arrive twice and shuffled: share of wrong rows in the picture."""
    shares = np.linspace(0.0, 0.9, 10)
    stale, wrong = [], []
    rng = np.random.default_rng(8)
    for share in shares:
        ppi = Ppi(AZIMUTHS, 4, 0.5, 1.0, dtype=np.int64)
        sent = np.arange(2 * AZIMUTHS)
        received = np.flatnonzero((sent < AZIMUTHS) | (rng.random(len(sent)) >= share))
        order = rng.permutation(np.concatenate([received, received]))
        ppi.add(order % AZIMUTHS, np.repeat(order[:, None], 4, axis=1), order)
        newest = np.array([received[received % AZIMUTHS == row].max() for row in range(AZIMUTHS)])
        wrong.append(float((ppi.polar != newest[:, None]).mean()))
        stale.append(float((ppi.age >= AZIMUTHS).mean()))
    return Finding(
        name="spokes lost, repeated or shuffled",
        method="the picture's accumulator of spokes",
        setup="two scans; the second loses spokes, and all arrive twice and shuffled",
        parameter=Axis("share of lost spokes [1]"),
        values=plain(shares),
        measured=Axis("share of rows [1]"),
        curves=(curve("not the newest received spoke", wrong), curve("of the scan before", stale)),
        limit=1e-9,
        limit_reason="any row that is not the newest received",
        boundary=crossing(shares, np.array(wrong), 1e-9),
        expected=Expected(None),
        response="no failure",
        instead="the newest spoke of each azimuth, with its age",
        details="Each row keeps its newest spoke. A row of a lost spoke stays as it was, and `age` states how old it is.",
    )


def numbered_anew(fine: int = 1) -> Finding:
    """Drives the length of the run before a restart from number 0, with the same accumulator: share of frozen rows."""
    scans_before = np.array([0.5, 1.0, 2.0, 5.0, 10.0, 100.0])
    frozen = []
    for scans in scans_before:
        ppi = Ppi(AZIMUTHS, 4, 0.5, 1.0)
        before = np.arange(int(scans * AZIMUTHS))
        ppi.add(before % AZIMUTHS, np.zeros((len(before), 4), dtype=np.uint8), before)
        after = np.arange(AZIMUTHS)
        shown = ppi.add(after, np.ones((AZIMUTHS, 4), dtype=np.uint8), after)
        frozen.append(float((~shown).mean()))
    return Finding(
        name="restart from number 0",
        method="one picture for the runs before and after a restart",
        setup="a radar that restarts and counts from 0, with the accumulator of the run before",
        parameter=Axis("scans before the restart [1]", log=True),
        values=plain(scans_before),
        measured=Axis("share of frozen rows [1]"),
        curves=(curve("one picture for both runs", frozen),),
        limit=1e-9,
        limit_reason="any row",
        boundary=crossing(scans_before, np.array(frozen), 1e-9, log=True),
        expected=Expected(0.5, 0.0, "at once"),
        response="another method",
        instead="a new picture for each epoch of the feed",
        details="The accumulator ignores numbers older than those on display. The feed names its epoch, and clients begin a new "
        "picture with a new epoch.",
    )


STUDIES = (pixel_size, small_pixels, spokes_lost, numbered_anew)
