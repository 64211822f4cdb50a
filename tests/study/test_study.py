"""The short modules of study, each under its name."""

from pathlib import Path

import matplotlib
import numpy as np
import pytest

from radar_service import study
from radar_service.study.compressed_pulse import compressed_chirp, cosine_coefficients
from radar_service.study.plotting import duration, new_figure, number, percent, png_bytes, style
from tests.reference.compressed_pulse import compressed_pulse


# compressed_pulse: the closed form of the studies, against that of the tests.
@pytest.mark.parametrize("window", ["none", "hamming", "blackman", "blackman-harris"])
def test_the_closed_form_of_the_studies_agrees_with_that_of_the_tests(window: str) -> None:
    """Two derivations, about the middle of the overlap and of the pulse, agree to the rounding of 64 bits, 1e-12 of the peak."""
    delay = np.linspace(-2.1e-6, 2.1e-6, 1001)
    coefficients = {"none": (1.0,), "hamming": (0.54, 0.46), "blackman": (0.42, 0.5, 0.08)}
    coefficients["blackman-harris"] = (0.35875, 0.48829, 0.14128, 0.01168)
    expected = compressed_pulse(delay, 50e6, 2e-6, coefficients[window])
    assert np.abs(compressed_chirp(delay, 50e6, 2e-6, window) - expected).max() < 1e-12


def test_the_cosine_series_of_a_taylor_window_holds_its_sidelobes() -> None:
    """Source: Taylor 1955. The first sidelobe of 35 dB is 35 dB below the peak, to 0.6 dB of the near sidelobes' slope."""
    coefficients = np.array(cosine_coefficients("taylor"))
    u = np.linspace(0.0, 5.0, 5001)
    field = coefficients[0] * np.sinc(u)
    for m, a in enumerate(coefficients[1:], start=1):
        field += 0.5 * a * (np.sinc(u - m) + np.sinc(u + m))
    level = np.abs(field / field[0])
    first_null = int(np.flatnonzero(np.diff(level) > 0)[0])
    assert 20 * np.log10(level[first_null:].max()) == pytest.approx(-35.0, abs=0.6)


# plotting: figures by matplotlib, independent of a user's settings, numbers for readers; tests/commands/test_serve.py has who
# loads it.
def test_no_study_uses_pyplot() -> None:
    """It holds every figure that it has made."""
    files = [*Path(study.__file__).parent.rglob("*.py")]
    assert len(files) > 20 and not [file for file in files if "pyplot" in file.read_text(encoding="utf-8")]


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
