"""Blind runs: seeds of a salt, which the folder of plots keeps for all trackers, and folders that a program cannot read."""

import ctypes
import hashlib
import json
import os
import secrets
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from radar_service.bench.trackers.sealed_child import CREATE_RULESET
from radar_service.terminal import make_folder, write_file

SALT = "salt.json"
SEEDS = 1 << 53  # as many as JSON keeps in any language, and too many to try
FIRST_SEED = 2**32  # open seeds are smaller


@dataclass(frozen=True)
class Blind:
    """How runs are kept from a program. salt: of the seeds; sealed: folders that it cannot read; none: truth stays in memory."""

    salt: str
    sealed: tuple[str, ...]

    def seed(self, scenario: str, run: int) -> int:
        """Returns the seed of a run of a scenario."""
        digest = hashlib.blake2b(f"{self.salt} {scenario} {run}".encode(), digest_size=8).digest()
        return FIRST_SEED + int.from_bytes(digest, "big") % (SEEDS - FIRST_SEED)


def blind_for(plots: Path, folder: Path, salt: str | None = None, files: Iterable[Path] = ()) -> Blind:
    """Returns how runs are kept from a program: folders of plots and of all their reports are sealed, and some files.

    salt: for this report alone; the folder of plots keeps its own. Raises OSError.
    """
    if not can_seal():
        return Blind(salt or secrets.token_hex(16), ())
    path = plots / SALT
    kept = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    own = str(kept.get("salt") or secrets.token_hex(16))
    folders = sorted({*kept.get("folders", ()), os.path.realpath(folder)})
    make_folder(plots)
    write_file(path, json.dumps({"salt": own, "folders": folders}))
    return Blind(salt or own, (os.path.realpath(plots), *folders, *map(os.path.realpath, files)))


def can_seal() -> bool:
    """Returns whether this system has Landlock."""
    return sys.platform == "linux" and bool(ctypes.CDLL(None).syscall(CREATE_RULESET, None, 0, 1) > 0)
