"""Frames as RFC 6455 defines them."""

import pytest

from radar_service.stream.fanout.frames import frame


@pytest.mark.parametrize(
    ("size", "head"),
    [(0, "8200"), (125, "827d"), (126, "827e007e"), (256, "827e0100"), (65_535, "827effff"), (65_536, "827f0000000000010000")],
)  # fmt: skip
def test_frames_are_those_of_the_standard(size: int, head: str) -> None:
    """256 and 65,536 bytes are the examples of RFC 6455, section 5.7."""
    data = bytes(range(256)) * 256
    assert frame(data[:size]) == bytes.fromhex(head) + data[:size]
