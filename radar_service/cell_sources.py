"""What spokes tell of the sources of their cells: labels, which name the strongest source, and the power of each source."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.uint32]  # number of the strongest source
Powers = Mapping[int, NDArray[np.float32]]  # [W] by source number; a source without power may be left out

UNKNOWN = 2**31 - 1  # label of old echoes, in a stuck sector, that are older than the first request for labels


@dataclass(frozen=True)
class SourceRequest:
    """What spokes are to tell of their sources."""

    labels: bool = False
    powers: bool = False

    def __or__(self, other: "SourceRequest") -> "SourceRequest":
        return SourceRequest(self.labels or other.labels, self.powers or other.powers)


@dataclass(frozen=True)
class SourceList:
    """The sources that the cells of a radar may have.

    names: by rising number. no_labels, no_powers: why the spokes do not tell them; "" where they do.
    on_request: whether spokes tell them where that is requested; otherwise they always do.
    """

    names: Mapping[int, str] = field(default_factory=dict)
    no_labels: str = ""
    no_powers: str = ""
    on_request: bool = True

    def to_request(self, wanted: SourceRequest) -> SourceRequest:
        """Returns the part of a request that spokes can tell, and do not tell without it."""
        if not self.on_request:
            return SourceRequest()
        return SourceRequest(wanted.labels and not self.no_labels, wanted.powers and not self.no_powers)

    def check(self, request: SourceRequest) -> None:
        """Raises ValueError that says why the spokes cannot tell what is requested."""
        for name, is_requested, reason in (
            ("labels", request.labels, self.no_labels),
            ("powers", request.powers, self.no_powers),
        ):
            if is_requested and reason:
                raise ValueError(f"{name}: {reason}, or leave {name} out")

    def as_list(self) -> list[dict[str, Any]]:
        """Returns the table of sources as plain data: `number` and `name` of each."""
        return [{"number": number, "name": name} for number, name in self.names.items()]


def part_of(powers: Powers | None, cut: int | slice) -> Powers | None:
    """Returns the powers of some spokes of a block, or of one."""
    return None if powers is None else {number: power[cut] for number, power in powers.items()}


def joined_powers(parts: Sequence[tuple[Powers, tuple[int, int]]]) -> Powers:
    """Returns the powers of consecutive blocks, each with its shape (K, N), as those of one. A missing source has no power."""
    numbers = sorted({number for powers, _ in parts for number in powers})
    return {
        number: np.concatenate([powers.get(number, np.zeros(shape, dtype=np.float32)) for powers, shape in parts])
        for number in numbers
    }
