"""Truth files: JSON Lines with a header, and for each scan its crossings and a snapshot of all bodies at its end.

SI units and radians, bearings clockwise from true north; the keys are the fields of `records.Crossing` and
`records.Snapshot`. Each line has a `type`: header, crossing or snapshot. Absent values are null.
"""

import json
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from radar_service.records.truth import Crossing, Snapshot
from radar_service.scene.world import Scene
from radar_service.truth.scene_hash import scene_hash

SCHEMA = 1  # version of these keys


def header(scene: Scene, seed: int, fidelity: str) -> dict[str, Any]:
    """Returns the first line of a truth file. The same scene, seed and fidelity give the same truth."""
    radar = scene.radar
    return {
        "type": "header", "schema": SCHEMA, "version": version("radar-service"), "scene": scene.name,
        "scene_hash": scene_hash(scene), "seed": seed, "fidelity": fidelity,
        "radars": [
            {"id": scene.radar_id, "azimuths": radar.azimuths, "rotation_period": radar.rotation_period, "bins": radar.bins,
             "range_first": radar.range_step / 2.0, "range_step": radar.range_step, "beamwidth": radar.beamwidth,
             "frequency": radar.frequency},
        ],
    }  # fmt: skip


class TruthFile:
    """Writes a truth file, as a context manager. Each scan is on disk before the next one begins."""

    def __init__(self, path: Path, first: Mapping[str, Any]) -> None:
        """first: the header. Raises OSError."""
        self._file = path.open("w", encoding="utf-8")
        self._write(first)

    def write(self, crossings: Iterable[Crossing], snapshot: Snapshot) -> None:
        """Writes the truth of one scan. Raises OSError."""
        for crossing in crossings:
            self._write(crossing.as_dict())
        self._write(snapshot.as_dict())
        self._file.flush()

    def _write(self, content: Mapping[str, Any]) -> None:
        self._file.write(json.dumps(content, allow_nan=False) + "\n")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._file.close()
