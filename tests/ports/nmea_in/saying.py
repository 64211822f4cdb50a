"""What another simulator says: sentences whose checksum is counted bit by bit, so that it shares nothing with the reader."""


def line(body: str) -> bytes:
    """The sentence of a body, with its checksum and without a line end."""
    counted = sum((sum(ord(character) >> bit & 1 for character in body) % 2) << bit for bit in range(7))
    return f"${body}*{counted:02X}".encode("ascii")


def hdt(heading_deg: float) -> bytes:
    return line(f"HEHDT,{heading_deg:.2f},T")


def rmc(clock: str, place: str = "5000.0000,N,00100.0000,W", speed_kn: float = 6.0, course_deg: float = 80.0) -> bytes:
    return line(f"GPRMC,{clock},A,{place},{speed_kn:.2f},{course_deg:.2f},311226,,,A")
