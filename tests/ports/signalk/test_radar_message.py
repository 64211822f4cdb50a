"""The message of spokes: what the library of Protocol Buffers reads is what was written, for any values."""

from hypothesis import given, settings
from hypothesis import strategies as st

from radar_service.ports.signalk.codec import SpokeFields, last_spokes, spoke_bytes, varint
from tests.ports.signalk.protobuf import spokes

DEGREES = st.floats(-180.0, 180.0)
SPOKE = st.builds(
    SpokeFields, st.integers(0, 16383), st.none() | st.integers(0, 16383), st.integers(0, 200_000),
    st.none() | st.integers(0, 2**53), st.none() | st.tuples(DEGREES, DEGREES), st.binary(max_size=300),
)  # fmt: skip


def test_varints_of_the_encoding_guide() -> None:
    """Protocol Buffers, Encoding: 1 is 01, 150 is 96 01."""
    assert varint(1) == b"\x01" and varint(150) == b"\x96\x01" and varint(0) == b"\x00" and varint(127) == b"\x7f"


@settings(deadline=None)
@given(st.lists(SPOKE, max_size=5))
def test_what_was_written_is_read(written: list[SpokeFields]) -> None:
    read = spokes(b"".join(map(spoke_bytes, written)))
    assert len(read) == len(written)
    for got, spoke in zip(read, written, strict=True):
        assert got.get("angle", 0) == spoke.angle and got.get("range", 0) == spoke.range
        assert got.get("bearing") == spoke.bearing and got.get("time") == spoke.time  # absent where it is not known
        assert got.get("data", b"") == spoke.data
        assert (got.get("lat"), got.get("lon")) == (spoke.position or (None, None))


@settings(deadline=None)
@given(st.lists(SPOKE, min_size=1, max_size=5), st.data())
def test_the_last_spokes_of_a_message(written: list[SpokeFields], data: st.DataObject) -> None:
    count = data.draw(st.integers(0, len(written)))
    whole = list(map(spoke_bytes, written))
    assert last_spokes(b"".join(whole), count) == b"".join(whole[len(whole) - count :])
