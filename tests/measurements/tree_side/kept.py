"""The files that a part leaves: equal trees leave equal ones."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

OF_A_RUN = ("epoch", "utc", "microseconds", "costs", "realtime_factor")  # a random name, and measured times


class Kept:
    """A folder of results. Names may have slashes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def bytes(self, name: str, content: bytes) -> None:
        """Keeps bytes."""
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)

    def array(self, name: str, values: np.ndarray) -> None:
        """Keeps an array of any shape."""
        path = self._folder / f"{name}.npy"
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, values)

    def record(self, name: str, value: object) -> None:
        """Keeps a record, a list of them, or plain data as JSON. Numbers keep all their digits."""
        self.bytes(f"{name}.json", json.dumps(plain(value), indent=1, sort_keys=True).encode())


def plain(value: Any) -> Any:
    """A value of records, arrays and numbers as plain data; of other objects what they show."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value if isinstance(value, str | int | float | bool | None) else str(value)


def lasting(value: Any) -> Any:
    """Plain data without what each run has anew: OF_A_RUN, in tables at any depth."""
    if isinstance(value, dict):
        return {key: lasting(item) for key, item in value.items() if key not in OF_A_RUN}
    return [lasting(item) for item in value] if isinstance(value, list | tuple) else value
