"""The report of a detection study as one HTML page: the criterion, a table of targets, and Pd by range as a figure."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from radar_service.bench.detection.clutter import clutter_summary
from radar_service.bench.report import table
from radar_service.bench.run_picture import png_text
from radar_service.numerics import NAUTICAL_MILE
from radar_service.terminal import html_page, make_folder, write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_detection(study: Mapping[str, Any], folder: Path) -> None:
    """Writes detection.json and detection.html, of noise or of clutter, into a folder, which is made. Raises OSError."""
    make_folder(folder)
    write_file(folder / "detection.json", json.dumps(study, indent=1, allow_nan=False))
    if "criterion" in study:
        page = html_page("bench/detection/report.html", study=study, criterion=criterion, row=_row, figure=_figure)
    else:
        page = html_page("bench/detection/clutter.html", study=study, tables=clutter_summary(study))
    write_file(folder / "detection.html", page)


def criterion(study: Mapping[str, Any]) -> str:
    """Returns what the words of the report mean, as sentences."""
    return (
        f"A target is held where its Pd per scan is {study['criterion']:g} or more, at a Pfa of {study['pfa']:g}. Then 8 of 10 "
        f"scans detect it with a chance of {study['eight_of_ten']:.2f}. First lost is the nearest range with a lower Pd, last "
        f"held the farthest one without: nulls of the two rays lie between. Each range was measured over {study['scans']} scans. "
        "The range of a standard is shown and decides nothing."
    )


def summary(study: Mapping[str, Any]) -> str:
    """Returns a table of the targets as text."""
    heads = ("environment", "target", "first lost", "last held", "standard", "p", "SNR", "verdict")
    rows = [(series["environment"], *_row(measured)) for series in study["series"] for measured in series["targets"]]
    lines = table("{:14.14} {:32.32} {:>16} {:>16} {:>9} {:>6} {:>17}  {}", [heads, *rows])
    return "\n".join([*lines, "ranges: predicted (measured); SNR: mean of the measured less the predicted one"]) + "\n"


def _row(target: Mapping[str, Any]) -> tuple[str, ...]:
    """The cells of a target: its name, first lost, last held, range of a standard, p, difference of the SNR, verdict."""
    lost, held = (_both(target[key]) for key in ("first_lost_m", "last_held_m"))
    standard = "none" if target["standard_nm"] is None else f"{target['standard_nm']:g} NM"
    p = "none" if target["p"] is None else f"{target['p']:.2g}"
    difference, error = target["snr_difference_db"], target["snr_error_db"]
    snr = "none" if difference is None else f"{difference:+.2f} +- {error:.2f} dB"
    return target["target"], lost, held, standard, p, snr, target["word"]


def _both(values: Mapping[str, float | None]) -> str:
    """A predicted and a measured range in nautical miles."""
    predicted, measured = ("none" if value is None else f"{value / NAUTICAL_MILE:.2f}" for value in values.values())
    return f"{predicted} NM ({measured})"


def _figure(series: Mapping[str, Any]) -> str:
    """Pd by range of each target, predicted and measured, with the range of the standard, as `png_text`."""

    def draw(figure: "Figure") -> None:
        chart = figure.subplots()
        for target in series["targets"]:
            rows = [(r["range_m"] / NAUTICAL_MILE, r["detected"]) for r in target["ranges"]]
            curve, standard = target["curve"], target["standard_nm"]
            (line,) = chart.plot(curve["range_nm"], curve["predicted"], linewidth=1.0, label=target["target"])
            chart.plot(*np.array(rows).reshape(-1, 2).T, "o", markersize=3, color=line.get_color())
            if standard is not None:
                chart.axvline(standard, color=line.get_color(), linewidth=0.7, linestyle=":")
        chart.set(xlabel="range [NM]; dotted: of the standard", ylabel="Pd per scan; dots: measured", ylim=(-0.02, 1.02))
        chart.legend(fontsize="small")

    return png_text((11.0, 5.0), draw)
