"""What is requested of the sources of cells, and what can be told."""

from typing import Any

import numpy as np
import pytest

from radar_service.records.cell_sources import (
    MAX_POWERS,
    SourceList,
    SourceRequest,
    joined_powers,
    part_of,
    powers_from_text,
    source_request,
    text_of,
)

NAMES = {0: "noise", 1: "sea", 256: "ferry"}


def test_requests_add_up() -> None:
    one, other = SourceRequest(powers=(256, 1)), SourceRequest(labels=True, powers=(0, 1))
    assert one | other == SourceRequest(True, (0, 1, 256)) and one | SourceRequest(powers="all") == SourceRequest(
        False, "all"
    )
    assert not SourceRequest() and SourceRequest(labels=True) and SourceRequest(powers=(0,))


def test_only_what_can_be_told_and_is_not_told_anyway_is_requested() -> None:
    wanted = SourceRequest(True, (1, 999))
    assert SourceList(NAMES).to_request(wanted) == SourceRequest(True, (1,))
    assert SourceList(NAMES, no_labels="no").to_request(wanted) == SourceRequest(False, (1,))
    assert SourceList(NAMES, no_powers="no").to_request(SourceRequest(True, "all")) == SourceRequest(True)
    assert SourceList(NAMES, on_request=False).to_request(wanted) == SourceRequest()
    assert SourceList(NAMES).as_list()[2] == {"number": 256, "name": "ferry"}


@pytest.mark.parametrize(
    ("sources", "request_", "words"),
    [
        (SourceList(NAMES, no_labels="it is old"), SourceRequest(labels=True), "labels: it is old, or leave labels out"),
        (SourceList(NAMES, no_powers="it is old"), SourceRequest(powers="all"), "powers: it is old, or leave powers out"),
        (
            SourceList(NAMES),
            SourceRequest(powers=(1, 7)),
            "powers: 7 is no source of this scene; it has 0 noise, 1 sea, 256 ferry",
        ),
    ],
)
def test_what_cannot_be_told_is_refused(sources: SourceList, request_: SourceRequest, words: str) -> None:
    sources.check(SourceRequest())
    with pytest.raises(ValueError, match=words):
        sources.check(request_)


@pytest.mark.parametrize(("text", "powers"), [("", ()), ("all", "all"), ("257,1,257", (1, 257)), ("0", (0,))])
def test_powers_are_read_from_a_text(text: str, powers: Any) -> None:
    assert powers_from_text(text) == powers and powers_from_text(text_of(powers)) == powers


@pytest.mark.parametrize(
    "text", ["ALL", "1,", ",", "-1", "1.5", "one", "1 2", "99999999999", ",".join(["1"] * (MAX_POWERS + 1))]
)
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"^powers: .* is not all, nor 1 to 64 numbers"):
        powers_from_text(text)


@pytest.mark.parametrize("powers", [True, 1.5, -1, [1, "a"], [True], None, "some"])
def test_powers_in_process_are_all_or_numbers(powers: Any) -> None:
    assert source_request(True, [257, 1]) == SourceRequest(True, (1, 257)) and source_request(False, 5).powers == (5,)
    with pytest.raises(ValueError, match=r"^powers: .* is not allowed"):
        source_request(False, powers)


def test_powers_of_blocks_are_cut_and_joined() -> None:
    first, second = np.ones((2, 3), dtype=np.float32), np.full((1, 3), 2, dtype=np.float32)
    whole = joined_powers([({5: first}, (2, 3)), ({4: second, 5: second}, (1, 3))])
    assert list(whole) == [4, 5] and whole[5][:, 0].tolist() == [1, 1, 2] and whole[4][:, 0].tolist() == [0, 0, 2]
    assert part_of(None, 0) is None and part_of(whole, 2)[4].tolist() == [2, 2, 2]  # type: ignore[index]
