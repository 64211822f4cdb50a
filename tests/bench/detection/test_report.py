"""The report of a detection study as files and as text."""

import base64
import json
import re
from pathlib import Path

from radar_service.bench.detection.report import criterion, summary, write_detection

TARGET = {
    "target": "buoy <1>", "rcs_dbsm": 10.0, "swerling": 0, "height_m": 3.5, "standard_nm": 4.9, "p": 0.25,
    "snr_difference_db": 0.1, "snr_error_db": 0.05, "word": "pass", "first_lost_m": {"predicted": 1852.0, "measured": None},
    "last_held_m": {"predicted": 3704.0, "measured": 3889.2}, "curve": {"range_nm": [1.0, 2.0], "predicted": [1.0, 0.0]},
    "ranges": [{"range_m": 1852.0, "predicted": 0.9, "detected": 0.8, "eight_of_ten": 0.9, "snr_db": 12.0, "tested": True}],
}  # fmt: skip
UNSEEN = {
    **TARGET, "target": "ship", "standard_nm": None, "p": None, "snr_difference_db": None, "word": "no range to test",
    "ranges": [],
}  # fmt: skip
STUDY = {
    "schema": 1, "scenario": "s & s", "question": "?", "source": "a <test>", "scans": 40, "pfa": 1e-4, "criterion": 0.8,
    "eight_of_ten": 0.678, "series": [{"environment": "free space", "targets": [TARGET, UNSEEN]}],
}  # fmt: skip


def test_files_are_written_and_can_be_read(tmp_path: Path) -> None:
    write_detection(STUDY, tmp_path / "new")
    assert json.loads((tmp_path / "new" / "detection.json").read_text()) == STUDY
    page = (tmp_path / "new" / "detection.html").read_text()
    for text in ("s &amp; s", "a &lt;test&gt;", "buoy &lt;1&gt;", "4.9 NM", "chance of 0.68", 'class="pass"', 'class="no"'):
        assert text in page
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert base64.b64decode(picture).startswith(b"\x89PNG")


def test_a_row_for_each_target_under_heads_in_one_column_each() -> None:
    heads, buoy, ship, _ = summary(STUDY).splitlines()
    assert re.split(" {2,}", heads) == [
        "environment",
        "target",
        "first lost",
        "last held",
        "standard",
        "p",
        "SNR",
        "verdict",
    ]
    cells = ["free space", "buoy <1>", "1.00 NM (none)", "2.00 NM (2.10)", "4.9 NM", "0.25", "+0.10 +- 0.05 dB", "pass"]
    assert re.split(" {2,}", buoy) == cells
    assert {line.index(word) for line, word in ((heads, "verdict"), (buoy, "pass"), (ship, "no range"))} == {len(buoy) - 4}
    assert "0.8 or more" in criterion(STUDY) and "40 scans" in criterion(STUDY)
