"""What spokes tell of the sources of their cells: labels, which name the strongest source, and the power of each source."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Singles

Labels = NDArray[np.uint32]  # number of the strongest source
Powers = Mapping[int, Singles]  # [W] by source number; a source without power may be left out
PowersOf = tuple[int, ...] | Literal["all"]  # numbers of sources

MAX_POWERS = 64  # sources that are named one by one
UNKNOWN = 2**31 - 1  # label of old echoes, in a stuck sector, that are older than the first request for labels


@dataclass(frozen=True)
class SourceRequest:
    """What spokes are to tell of their sources. powers: of which sources; no other one is computed."""

    labels: bool = False
    powers: PowersOf = ()

    def __or__(self, other: "SourceRequest") -> "SourceRequest":
        if self.powers == "all" or other.powers == "all":
            return SourceRequest(self.labels or other.labels, "all")
        return SourceRequest(self.labels or other.labels, tuple(sorted({*self.powers, *other.powers})))

    def __bool__(self) -> bool:
        return self.labels or bool(self.powers)


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

    def to_request(self, request: SourceRequest) -> SourceRequest:
        """Returns the part of a request that spokes can tell, and do not tell without it."""
        if not self.on_request:
            return SourceRequest()
        powers = (
            request.powers if request.powers == "all" else tuple(number for number in request.powers if number in self.names)
        )
        return SourceRequest(request.labels and not self.no_labels, () if self.no_powers else powers)

    def check(self, request: SourceRequest) -> None:
        """Raises ValueError that says why the spokes cannot tell what is requested."""
        for name, is_requested, reason in (
            ("labels", request.labels, self.no_labels),
            ("powers", bool(request.powers), self.no_powers),
        ):
            if is_requested and reason:
                raise ValueError(f"{name}: {reason}, or leave {name} out")
        for number in () if request.powers == "all" else request.powers:
            if number not in self.names:
                known = ", ".join(f"{number} {name}" for number, name in self.names.items())
                raise ValueError(f"powers: {number} is no source of this scene; it has {known[:400]}")

    def as_list(self) -> list[dict[str, Any]]:
        """Returns the table of sources as plain data: `number` and `name` of each."""
        return [{"number": number, "name": name} for number, name in self.names.items()]


def source_request(labels: bool, powers: Literal["all"] | Iterable[int]) -> SourceRequest:
    """Returns the request of these arguments. Raises ValueError for powers that are neither "all" nor whole numbers."""
    if powers == "all":
        return SourceRequest(labels, "all")
    numbers = tuple(powers) if isinstance(powers, Iterable) else (powers,)
    if not all(isinstance(number, int) and not isinstance(number, bool) and number >= 0 for number in numbers):
        raise ValueError(f'powers: {powers!r} is not allowed; "all", or numbers of sources, as (1, 257)')
    return SourceRequest(labels, tuple(sorted(set(numbers))))


def powers_from_text(text: str) -> PowersOf:
    """Returns the sources that a text names: all, or numbers with commas between; none for "". Raises ValueError."""
    if text in ("", "all"):
        return "all" if text else ()
    numbers = text.split(",")
    if len(numbers) > MAX_POWERS or not all(re.fullmatch(r"[0-9]{1,10}", number) for number in numbers):
        raise ValueError(f'powers: "{text[:40]}" is not all, nor 1 to {MAX_POWERS} numbers of sources with commas between')
    return tuple(sorted({int(number) for number in numbers}))


def text_of(powers: PowersOf) -> str:
    """Returns the text that `powers_from_text` reads."""
    return powers if powers == "all" else ",".join(map(str, powers))


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
