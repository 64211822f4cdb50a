"""Figures by matplotlib: loaded only when used, independent of a user's settings, numbers for readers."""

import subprocess
import sys

import matplotlib

from radar_service.study.plotting import duration, new_figure, number, percent, png_bytes, style


def test_neither_the_library_nor_the_service_loads_matplotlib_and_nothing_pyplot() -> None:
    library = "radar_service", "radar_service.__main__", "radar_service.ports.app"
    studies = "radar_service.study.chart.chart", "radar_service.study.stability.report"
    code = f"import sys, {', '.join(library)}; print('matplotlib' in sys.modules)\n" \
        f"import {', '.join(studies)}; print('matplotlib' in sys.modules, 'matplotlib.pyplot' in sys.modules)"  # fmt: skip
    printed = subprocess.run([sys.executable, "-c", code], timeout=120, capture_output=True, text=True).stdout
    assert printed.split() == ["False", "True", "False"]


def test_settings_of_the_user_change_nothing() -> None:
    def picture() -> bytes:
        with style():
            figure = new_figure(1.0)
            figure.add_subplot().plot([0, 1], [0, 1], label="line")
        return png_bytes(figure)

    before = picture()
    with matplotlib.rc_context({"axes.facecolor": "black", "lines.linewidth": 9, "savefig.transparent": True}):
        assert picture() == before
    assert matplotlib.rcParams["svg.fonttype"] == "path"  # nothing remains of the style


def test_numbers_for_readers() -> None:
    assert [duration(t) for t in (1.0, 3.47e-3, 2e-5, 1e-9)] == ["1 s", "3.47 ms", "20 us", "1 ns"]
    assert [percent(share) for share in (0.0052, 0.633, 1.0)] == ["0.52 %", "63 %", "100 %"]
    assert [number(x) for x in (0.0, 1024.0, 0.66, 3.4028e38)] == ["0", "1,020", "0.66", "3.4e38"]
