"""The report of ladders as files, as text and as curves."""

import base64
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from radar_service.bench.ladder.climb import report
from radar_service.bench.ladder.report import curves, method, scale_of, text_of, write_ladders
from tests.bench.ladder.test_climb import runs
from tests.bench.ladder.test_series import ladder

EASY, HARD = np.linspace(2.0, 4.0, 10), np.linspace(20.0, 60.0, 10)
BLUE, ORANGE, GREY = (0x1F, 0x77, 0xB4), (0xFF, 0x7F, 0x0E), (0x99, 0x99, 0x99)


@pytest.fixture
def made(tmp_path: Path) -> dict:
    """The reference, and a tracker that is better by 1 m on the first rung and worse by 3 m on the second; one of its runs
    failed."""
    own = [(EASY - 1.0).tolist(), [*(HARD[:-1] + 3.0).tolist(), None]]
    return report([ladder(tmp_path)], {"gnn": runs([EASY.tolist(), HARD.tolist()]), "<mine>": runs(own)})


def test_files_are_written_and_can_be_read(made: dict, tmp_path: Path) -> None:
    write_ladders(made, tmp_path)
    assert json.loads((tmp_path / "report.json").read_text()) == json.loads(json.dumps(made))
    page = (tmp_path / "report.html").read_text()
    assert "&lt;mine&gt;" in page and "<mine>" not in page
    assert '<td class="pass">2 +</td><td class="fail">' in page and "<td>1</td></tr>" in page
    assert "gnn is better than &lt;mine&gt; (p = 0.002)" in page
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert base64.b64decode(picture).startswith(b"\x89PNG")


def test_the_text_has_places_curves_and_pairs(made: dict) -> None:
    lines = [line.split() for line in text_of(made).splitlines()]
    assert ["1", "gnn", "0.1075"] in [line[:3] for line in lines] and ["1", "gnn", "21.5"] in [line[:3] for line in lines]
    assert "noise of plots [m] 1 30".split() in lines
    assert "gnn 3 40".split() in lines and "<mine> 2 + 56.7 - 1 failed runs".split() in lines
    assert "gnn is better than <mine> (p = 0.002)".split() in lines
    assert "10 seeds of each rung" in method(made) and "5 % at most" in method(made)


def rows_of(image: np.ndarray, colour: tuple[int, int, int]) -> float:
    """The row in which most pixels have a colour: that of a flat curve."""
    return float(
        (np.abs(image - colour).max(axis=2) < 12).sum(axis=1).argmax()
    )  # 12: what smoothing leaves inside of a line


def test_curves_lie_where_figures_are(tmp_path: Path) -> None:
    """Figures of 2 and 20 m and the worst of 200 m are as far from each other on a logarithmic axis; curves are blue and orange,
    the line of the worst is grey."""
    its = report([ladder(tmp_path)], {"gnn": runs([[2.0, 2.0]] * 2), "mine": runs([[20.0, 20.0]] * 2)})["ladders"][0]
    image = np.asarray(Image.open(io.BytesIO(base64.b64decode(curves(its)))).convert("RGB")).astype(int)
    low, middle, worst = (rows_of(image, colour) for colour in (BLUE, ORANGE, GREY))
    assert low - middle == pytest.approx(middle - worst, abs=2.0) and low - middle > 50


def test_a_figure_of_zero_has_a_linear_axis(tmp_path: Path) -> None:
    """0 lies on no logarithmic one."""
    for first, scale in ((0.0, "linear"), (1.0, "log")):
        assert scale_of(report([ladder(tmp_path)], {"gnn": runs([[first] * 2, [50.0, 60.0]])})["ladders"][0]) == scale
