"""Makes the recorded scenarios of `scenes/scenarios/real` from the public set of Trondheim.

    .venv/bin/python -m tests.reference.make_recorded FOLDER

FOLDER has scenarioN/scenarioN_detections.json and scenarioN/scenarioN_groundTruth.json of Autoferry/sensor_fusion_dataset (CC0).
Radar alone is kept; positions of vessels are interpolated at the times of its scans, velocities over a second on either side.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

RADAR = 2  # sensorID
PERIOD = 1.68  # s, of its rotation
EVEN = (2, 4, 6, 16, 22)  # the odd ones stay outside, for others to judge by
SOURCE = (
    "Autoferry/sensor_fusion_dataset, CC0 1.0, of the paper: Heterogeneous multi-sensor tracking for an autonomous surface"
    " vehicle in a littoral environment (sciencedirect.com/science/article/pii/S0029801822005753)"
)
NAMES = {
    1: "Havfruen",
    2: {True: "Gunnerus", False: "jet boat"},
}  # the second one by environment: scenarios 2 to 6, and others


def recorded(number: int, detections: list[Any], truths: list[Any]) -> dict[str, Any]:
    """Returns a recording: north-east positions of the set as east and north, to a centimetre."""
    scans = [each for each in detections if each["sensorID"] == RADAR]
    start = scans[0]["time"] - PERIOD  # times are those of the ends of scans
    times = np.array([each["time"] for each in scans])
    targets = {}
    for target in (1, 2):
        name = NAMES[1] if target == 1 else NAMES[2][number < 10]  # type: ignore[index]
        rows = {state["time"]: state["position"][:2] for each in truths for state in each if state["targetID"] == target}
        stamps = np.array(sorted(rows))
        east, north = (np.array([rows[stamp][k] for stamp in stamps]) for k in (1, 0))
        at = [[np.interp(times + shift, stamps, axis) for axis in (east, north)] for shift in (-1.0, 0.0, 1.0)]
        speed = [(after - before) / 2.0 for before, after in zip(at[0], at[2], strict=True)]
        targets[name] = np.round(np.stack([*at[1], *speed], axis=1), 2).tolist()
    return {
        "source": SOURCE,
        "targets": targets,
        "scans": [
            {"time": round(each["time"] - start, 3), "own": _east_north([each["ownshipPosition"]])[0],
             "plots": _east_north(np.atleast_2d(np.array(each["measurement"] or np.empty((2, 0))).reshape(2, -1)).T)}
            for each in scans
        ],
    }  # fmt: skip


def _east_north(north_east: Any) -> list[list[float]]:
    return [[round(float(east), 2), round(float(north), 2)] for north, east in north_east]


if __name__ == "__main__":
    into = Path(__file__).parents[2] / "scenes" / "scenarios" / "real"
    for number in EVEN:
        stem = Path(sys.argv[1]) / f"scenario{number}" / f"scenario{number}"
        parts = [json.loads(Path(f"{stem}_{what}.json").read_text()) for what in ("detections", "groundTruth")]
        text = json.dumps(recorded(number, *parts), separators=(",", ":")).replace('{"time"', '\n{"time"')
        (into / f"autoferry-{number}.json").write_text(text + "\n")
