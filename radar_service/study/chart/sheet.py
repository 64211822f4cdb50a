"""A sheet of paper: lines, marks and words, written as SVG and painted as PNG from one list, so that both say the same."""

from dataclasses import dataclass, field
from io import BytesIO
from xml.sax.saxutils import escape

from PIL import Image, ImageDraw, ImageFont

Place = tuple[float, float]
FINER = 3  # pixels of the PNG to a unit of the sheet, painted twice as fine and shrunk: Pillow's own lines are jagged
PIXELS = 1.5  # of the finished PNG to a unit
ANCHORS = {"start": "l", "middle": "m", "end": "r"}
WIDE = 0.56  # width of a letter in heights: enough to keep labels apart


@dataclass(frozen=True)
class Line:
    """Straight pieces through places; dash: lengths on and off, 0 for none."""

    places: tuple[Place, ...]
    colour: str
    width: float = 1.0
    dash: float = 0.0


@dataclass(frozen=True)
class Mark:
    """A closed outline, filled or hollow."""

    places: tuple[Place, ...]
    colour: str
    filled: bool


@dataclass(frozen=True)
class Words:
    """One line of text whose middle in height is at the place; turned: read upwards."""

    place: Place
    text: str
    size: float = 13.0
    anchor: str = "start"
    colour: str = "#222222"
    turned: bool = False
    bold: bool = False

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom, about."""
        width = WIDE * self.size * len(self.text)
        left = self.place[0] - {"start": 0.0, "middle": width / 2, "end": width}[self.anchor]
        return left, self.place[1] - 0.6 * self.size, left + width, self.place[1] + 0.6 * self.size


@dataclass
class Sheet:
    """What is drawn, in order."""

    width: float
    height: float
    items: list[Line | Mark | Words] = field(default_factory=list)

    def svg(self, title: str) -> str:
        """The sheet as SVG."""
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:g} {self.height:g}" width="{self.width:g}" '
            f'height="{self.height:g}" font-family="DejaVu Sans, Verdana, Arial, sans-serif" role="img">'
        )
        body = [f"<title>{escape(title)}</title>", f'<rect width="{self.width:g}" height="{self.height:g}" fill="#ffffff"/>']
        return "\n".join([head, *body, *(_svg(item) for item in self.items), "</svg>", ""])

    def png(self) -> bytes:
        """The sheet as PNG."""
        size = (round(self.width * FINER), round(self.height * FINER))
        image = Image.new("RGB", size, "#ffffff")
        draw = ImageDraw.Draw(image)
        for item in self.items:
            if isinstance(item, Words):
                _write(image, draw, item)
            else:
                _paint(draw, item)
        out = BytesIO()
        small = image.resize((round(self.width * PIXELS), round(self.height * PIXELS)), Image.Resampling.LANCZOS)
        # Not by the median, which would give the greys of letters all the palette and make the few coloured marks alike
        small.quantize(128, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
        return out.getvalue()


def _svg(item: Line | Mark | Words) -> str:
    if isinstance(item, Words):
        x, y = item.place
        turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if item.turned else ""
        bold = ' font-weight="bold"' if item.bold else ""
        return (
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{item.size:g}" text-anchor="{item.anchor}" fill="{item.colour}" '
            f'dominant-baseline="central"{bold}{turn}>{escape(item.text)}</text>'
        )
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in item.places)
    if isinstance(item, Mark):
        fill = item.colour if item.filled else "#ffffff"
        return f'<polygon points="{places}" fill="{fill}" stroke="{item.colour}" stroke-width="1.6"/>'
    dash = f' stroke-dasharray="{item.dash:g}"' if item.dash else ""
    return f'<polyline points="{places}" fill="none" stroke="{item.colour}" stroke-width="{item.width:g}"{dash}/>'


def _paint(draw: ImageDraw.ImageDraw, item: Line | Mark) -> None:
    places = [(FINER * x, FINER * y) for x, y in item.places]
    if isinstance(item, Mark):
        draw.polygon(places, fill=item.colour if item.filled else "#ffffff")
        draw.line([*places, places[0], places[1]], fill=item.colour, width=round(1.6 * FINER), joint="curve")
        return
    for piece in _dashes(item.places, item.dash) if item.dash else [item.places]:
        draw.line([(FINER * x, FINER * y) for x, y in piece], fill=item.colour, width=max(1, round(item.width * FINER)))


def _dashes(places: tuple[Place, ...], dash: float) -> list[tuple[Place, ...]]:
    found: list[tuple[Place, ...]] = []
    for (x0, y0), (x1, y1) in zip(places, places[1:], strict=False):
        length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        for k in range(int(length / (2 * dash)) + 1):
            a, b = 2 * k * dash / length, min(1.0, (2 * k + 1) * dash / length)
            if a < 1.0:
                found.append(((x0 + a * (x1 - x0), y0 + a * (y1 - y0)), (x0 + b * (x1 - x0), y0 + b * (y1 - y0))))
    return found


def _write(image: Image.Image, draw: ImageDraw.ImageDraw, words: Words) -> None:
    font = ImageFont.load_default(words.size * FINER)
    x, y = FINER * words.place[0], FINER * words.place[1]
    stroke = 0.02 * words.size * FINER if words.bold else 0
    if not words.turned:
        anchor = ANCHORS[words.anchor] + "m"
        draw.text(
            (x, y), words.text, fill=words.colour, font=font, anchor=anchor, stroke_width=stroke, stroke_fill=words.colour
        )
        return
    left, top, right, bottom = draw.textbbox((0, 0), words.text, font=font, anchor="lt")
    strip = Image.new("L", (round(right - left) + 4, round(bottom - top) + 4), 0)
    ImageDraw.Draw(strip).text((2, 2), words.text, fill=255, font=font, anchor="lt")
    strip = strip.rotate(90, expand=True)
    image.paste(words.colour, (round(x - strip.width / 2), round(y - strip.height / 2)), strip)
