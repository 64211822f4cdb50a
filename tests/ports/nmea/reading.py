"""A reader and a writer of NMEA 0183 that share nothing with ours: the checksum is counted bit by bit."""


def checksum(body: str) -> int:
    return sum((sum(ord(character) >> bit & 1 for character in body) % 2) << bit for bit in range(7))


def read(line: bytes) -> str:
    """What stands between `$` or `!` and `*`. Raises ValueError for another form or a wrong checksum."""
    text = line.decode("ascii")
    if text[0] not in "$!" or text[-5] != "*" or text[-2:] != "\r\n":
        raise ValueError(f"not a sentence: {text!r}")
    body, given = text[1:-5], int(text[-4:-2], 16)
    counted = checksum(body)
    if counted != given:
        raise ValueError(f"checksum {given:02X} of {body!r} is {counted:02X}")
    return body


def fields_of(line: bytes) -> tuple[str, list[str]]:
    kind, *fields = read(line).split(",")
    return kind, fields


def line(body: str) -> bytes:
    """The sentence of a body, with its checksum and without a line end."""
    return f"${body}*{checksum(body):02X}".encode("ascii")


def hdt(heading_deg: float) -> bytes:
    return line(f"HEHDT,{heading_deg:.2f},T")


def rmc(clock: str, place: str = "5000.0000,N,00100.0000,W", speed_kn: float = 6.0, course_deg: float = 80.0) -> bytes:
    return line(f"GPRMC,{clock},A,{place},{speed_kn:.2f},{course_deg:.2f},311226,,,A")
