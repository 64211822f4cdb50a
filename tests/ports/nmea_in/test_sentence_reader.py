"""Reading is compared with pynmea2, which shares no code with it; what is not a sentence is refused with a word."""

import random

import pynmea2
import pytest

from radar_service.ports.nmea_in.sentence_reader import MAX_LINE, Reading, SentenceIgnoredError, SentenceLines, read
from tests.ports.nmea.reading import line

ROUNDING = 1e-12  # of degrees up to 180: some ten times 2^-46
PLACE = "5030.12345,S,17959.99999,W"
PUBLISHED = [  # of the manuals of receivers: NMEA 0183 as others print it
    b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47",
    b"$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A",
    b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*48",
]


def word(sentence: bytes) -> str:
    with pytest.raises(SentenceIgnoredError) as ignored:
        read(sentence)
    return str(ignored.value)


def test_published_sentences_are_read() -> None:
    gga, rmc, vtg = map(read, PUBLISHED)
    assert gga == Reading(position=(48 + 7.038 / 60, 11 + 31 / 60), clock=12 * 3600 + 35 * 60 + 19)
    assert rmc == Reading(None, 84.4, 22.4, gga.position, gga.clock)
    assert vtg == Reading(course_deg=54.7, speed_kn=5.5)


def test_drawn_sentences_are_read_as_pynmea2_reads_them() -> None:
    draw = random.Random(7)
    for _ in range(300):
        place = (
            f"{draw.randrange(90):02d}{draw.uniform(0, 59.9):08.5f},{draw.choice('NS')},"
            f"{draw.randrange(180):03d}{draw.uniform(0, 59.9):08.5f},{draw.choice('EW')}"
        )
        clock = f"{draw.randrange(24):02d}{draw.randrange(60):02d}{draw.uniform(0, 59):05.2f}"
        course, speed, talker = draw.uniform(0, 359.9), draw.uniform(0, 40), draw.choice(["GP", "GN", "II"])
        sentences = [
            line(f"{talker}RMC,{clock},A,{place},{speed:.2f},{course:.1f},010100,,,A"),
            line(f"{talker}GGA,{clock},{place},1,08,1.0,0.0,M,,M,,"),
            line(f"{talker}VTG,{course:.2f},T,,M,{speed:.3f},N,,K,A"),
            line(f"HEHDT,{course:.3f},T"),
        ]
        rmc, gga, vtg, hdt = map(read, sentences)
        theirs = [pynmea2.parse(sentence.decode(), check=True) for sentence in sentences]
        for ours, other in ((rmc, theirs[0]), (gga, theirs[1])):
            assert ours.position == pytest.approx((other.latitude, other.longitude), rel=0, abs=ROUNDING)
            seconds = other.timestamp.hour * 3600 + other.timestamp.minute * 60 + other.timestamp.second
            assert ours.clock == pytest.approx(
                seconds + other.timestamp.microsecond * 1e-6, rel=0, abs=1e-6
            )  # theirs ends there
        assert (rmc.course_deg, rmc.speed_kn) == (theirs[0].true_course, theirs[0].spd_over_grnd)
        assert (vtg.course_deg, vtg.speed_kn) == (theirs[2].true_track, float(theirs[2].spd_over_grnd_kts))
        assert hdt == Reading(heading_deg=float(theirs[3].heading))


def test_what_is_left_empty_is_not_known() -> None:
    assert read(line(f"GPRMC,120000,A,{PLACE},,,010126,,,A")).motion == {}
    assert read(line("GPVTG,,T,,M,0.00,N,,K,A")) == Reading(speed_kn=0.0)
    assert read(line("HETHS,12.5,A")).motion == {"heading_deg": 12.5}


@pytest.mark.parametrize(
    ("sentence", "reason"),
    [
        (b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*49", "checksum"), (b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K", "form"),
        (b"", "form"), (bytes(range(256)), "form"), (b"$" + b"A" * 400, "form"), (b"\xff" * 40, "form"),
        (line("HEHDT," + "1" * MAX_LINE + ",T"), "form"), (line("GPGSV,3,1,11"), "kind"), (line("XXHDT,12,T"), "talker"),
        (line("HEHDT,361,T"), "value"), (line("HEHDT,-1,T"), "value"), (line("HEHDT,nan,T"), "value"),
        (line("HEHDT,1e2,T"), "value"), (line("HEHDT,12,M"), "value"), (line("HEHDT,12"), "value"),
        (line("HEHDT,,T"), "invalid"), (line("HETHS,12.0,V"), "invalid"), (line("HETHS,,V"), "invalid"),
        (line(f"GPRMC,120000,V,{PLACE},1,2,010126,,,A"), "invalid"), (line(f"GPRMC,120000,A,{PLACE},1,2,010126,,,N"), "invalid"),
        (line(f"GPGGA,120000,{PLACE},0,0,,,M,,M,,"), "invalid"), (line("GPVTG,1,T,,M,2,N,,K,N"), "invalid"),
        (line("GPVTG,054.7,034.4,005.5,010.2,,,,"), "value"), (line(f"GPGGA,250000,{PLACE},1,8,,,M,,M,,"), "value"),
        (line("GPGGA,120000,5060.0,N,00100.0,W,1,8,,,M,,M,,"), "value"),
        (line("GPGGA,120000,9000.1,N,00100.0,W,1,8,,,M"), "value"),
        (line("GPGGA,120000,5000.0,,00100.0,W,1,8,,,M"), "value"), (line("GPGGA,120000,5000.0,N,18000.1,W,1,8,,,M"), "value"),
    ],
)  # fmt: skip
def test_what_is_not_followed_has_a_reason(sentence: bytes, reason: str) -> None:
    assert word(sentence) == reason


def test_one_wrong_bit_never_passes() -> None:
    """The checksum finds each; no reading comes of it."""
    sentence = line(f"GPRMC,120000.00,A,{PLACE},6.00,80.00,010126,,,A")
    for at in range(8 * len(sentence)):
        changed = bytearray(sentence)
        changed[at // 8] ^= 1 << at % 8
        if bytes(changed).upper() != sentence:  # the letters of the checksum may be small
            assert word(bytes(changed)) in ("form", "checksum")


def test_rubbish_has_no_other_outcome() -> None:
    draw = random.Random(3)
    for _ in range(2000):
        assert word(draw.randbytes(draw.randrange(120))) == "form"
        word(line("HEHDT," + "".join(chr(draw.randrange(32, 127)) for _ in range(9))))


def test_lines_come_whole_however_they_are_cut() -> None:
    text = b"one\r\n\r\ntwo\nthree\r\n" + b"x" * 1000 + b"\nfour\n"
    for size in (1, 2, 7, 300, 2000):
        lines = SentenceLines()
        got = [each for at in range(0, len(text), size) for each in lines.of(text[at : at + size])]
        assert [each for each in got if len(each) <= MAX_LINE] == [b"one", b"two", b"three", b"four"], size
        assert lines.too_long == (0 if size == 2000 else 1)  # whole at once it is a line, which `read` refuses


def test_ten_megabytes_without_an_end_keep_no_memory() -> None:
    lines = SentenceLines()
    for _ in range(640):
        assert lines.of(b"x" * 2**14) == [] and len(lines.rest) <= MAX_LINE
    assert lines.too_long == 1 and lines.of(b"\nnext\n") == [b"next"]
