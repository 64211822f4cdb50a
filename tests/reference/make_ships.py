"""Makes the meshes of ships for the scenes: `python -m tests.reference.make_ships` writes them anew.

Drawn for this project after no particular ship, from the parts of `ship_parts`; x to starboard, y ahead, z up [m].
"""

from pathlib import Path

import numpy as np

from tests.reference.ship_parts import (
    SECTION,
    Drawing,
    Floats,
    bulwarks,
    catwalk,
    coaming,
    deckhouse,
    derricks,
    funnel,
    hull,
    manifold,
    mast,
    pipes,
    rails,
    winches,
)

FOLDER = Path(__file__).parents[2] / "scenes"


def coaster() -> Floats:
    """A general cargo ship of 88 x 13 m, house aft, about 4,700 t at 5.5 m draught (block coefficient 0.75)."""
    drawing = Drawing()
    length, beam, deck, forecastle = 88.0, 13.0, 3.2, 5.8
    hull(drawing, length, beam, deck, forecastle)
    bulwarks(drawing, length, beam, deck, forecastle, 1.1)
    coaming(drawing, 4.6, (-21.0, 3.5), deck, 1.9)
    coaming(drawing, 4.6, (7.0, 29.0), deck, 1.9)
    roof = deckhouse(drawing, beam, (-40.0, -26.0), deck, 3)
    mast(drawing, -31.0, roof, roof + 8.0, 0.22)
    mast(drawing, 38.0, forecastle, forecastle + 9.0, 0.18)
    funnel(drawing, 1.6, (-39.0, -35.5), (roof - 5.0, roof + 1.2))
    winches(drawing, 34.2, forecastle)
    for at in (-23.5, 5.2, 31.0):  # lockers and vents between the hatches
        drawing.box((5.2, 5.9), (at - 0.4, at + 0.4), (deck, deck + 0.8))
        drawing.box((-5.2, -5.9), (at - 0.4, at + 0.4), (deck, deck + 0.8))
        drawing.box((-1.1, 1.1), (at - 0.7, at + 0.7), (deck, deck + 2.3))
    return drawing.triangles


def ferry() -> Floats:
    """A passenger and car ferry of 118 x 19 m, house nearly all along, boats in recesses."""
    drawing = Drawing()
    length, beam, deck, forecastle = 118.0, 19.0, 7.2, 8.4
    hull(drawing, length, beam, deck, forecastle)
    bulwarks(drawing, length, beam, deck, forecastle, 1.1)
    roof = deckhouse(drawing, beam, (-48.0, 40.0), deck, 3)
    mast(drawing, 30.0, roof, roof + 9.0, 0.25)
    funnel(drawing, 3.0, (-34.0, -26.0), (roof - 3.0, roof + 6.0))
    winches(drawing, 44.5, forecastle)
    for at in np.arange(-20.0, 20.0, 12.0):  # boats in their davits
        for side in (1.0, -1.0):
            drawing.box((side * 8.4, side * 9.4), (at, at + 8.0), (deck + 3.4, deck + 4.9))
            for y in (at - 0.3, at + 8.3):
                drawing.box((side * 8.0, side * 9.6), (y - 0.1, y + 0.1), (deck + 2.6, deck + 5.4))
    for at in (-40.0, -12.0, 4.0, 18.0):  # houses of fans and stairs on the top deck
        drawing.box((-2.0, 2.0), (at, at + 3.0), (roof - 2.5, roof - 0.4))
    return drawing.triangles


def freighter() -> Floats:
    """A geared general cargo ship of 140 x 21 m, house aft, about 17,600 t at 8.2 m draught (block coefficient 0.73)."""
    drawing = Drawing()
    length, beam, deck, forecastle = 140.0, 21.0, 5.2, 8.2
    hull(drawing, length, beam, deck, forecastle)
    bulwarks(drawing, length, beam, deck, forecastle, 1.1)
    roof = deckhouse(drawing, beam, (-64.0, -47.0), deck, 5)
    for aft in (-43.0, -20.0, 3.0, 26.0):
        coaming(drawing, 7.2, (aft, aft + 18.5), deck, 2.2)
    for at in (-22.2, 23.8):
        derricks(drawing, 4.6, at, deck, SECTION)
    mast(drawing, -55.0, roof, roof + 9.0, 0.25)
    mast(drawing, 62.0, forecastle, forecastle + 10.0, 0.2)
    funnel(drawing, 2.4, (-63.5, -59.0), (roof - 7.0, roof + 2.0))
    for y, z in ((54.5, forecastle), (-68.5, deck)):
        winches(drawing, y, z)
    for at in (-45.5, 0.8, 46.5):  # lockers, vents and the ends of the hold's ladders
        for side in (1.0, -1.0):
            drawing.box((side * 7.6, side * 8.6), (at - 0.6, at + 0.6), (deck, deck + 1.4))
        drawing.box((-1.2, 1.2), (at - 0.7, at + 0.7), (deck, deck + 2.3))
    return drawing.triangles


def tanker() -> Floats:
    """A products tanker of 185 x 30 m in ballast, house aft, about 27,300 t at 6 m draught (block coefficient 0.8)."""
    drawing = Drawing()
    length, beam, deck, forecastle = 185.0, 30.0, 12.0, 14.6
    hull(drawing, length, beam, deck, forecastle)
    rails(drawing, length, beam, deck, forecastle)
    roof = deckhouse(drawing, 0.86 * beam, (-82.0, -66.0), deck, 5)
    pipes(drawing, (-60.0, 58.0), deck)
    catwalk(drawing, (-64.0, 66.0), deck)
    manifold(drawing, 0.0, beam, deck)
    mast(drawing, -71.0, roof, roof + 10.0, 0.3)
    mast(drawing, 78.0, forecastle, forecastle + 11.0, 0.22)
    funnel(drawing, 3.0, (-88.0, -83.0), (deck, roof + 3.0))
    for y, z in ((71.0, forecastle), (-20.0, deck), (24.0, deck)):
        winches(drawing, y, z)
    for at in np.arange(-52.0, 56.0, 13.0):  # hatches and vents of the tanks
        for side in (1.0, -1.0):
            drawing.box((side * 6.0, side * 7.4), (at, at + 1.4), (deck, deck + 0.9))
            drawing.post((side * 8.6, at + 3.0, deck), (side * 8.6, at + 3.0, deck + 2.6), 0.2, 8)
    return drawing.triangles


def obj_text(triangles: Floats, about: str) -> str:
    """An OBJ file to the millimetre, coinciding corners once."""
    points, where = np.unique(np.round(triangles.reshape(-1, 3), 3) + 0.0, axis=0, return_inverse=True)
    lines = [f"# {about}", "# Made by tests/reference/make_ships.py"]
    lines += [f"v {x:.3f} {y:.3f} {z:.3f}" for x, y, z in points]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in where.reshape(-1, 3)]
    return "\n".join([*lines, ""])


def main() -> None:
    """Writes the files."""
    made = {
        "coaster": (coaster(), "Coaster, 88 x 13 m"),
        "ferry": (ferry(), "Ferry, 118 x 19 m"),
        "freighter": (freighter(), "Geared freighter, 140 x 21 m"),
        "tanker": (tanker(), "Products tanker in ballast, 185 x 30 m"),
    }
    for name, (triangles, about) in made.items():
        (FOLDER / f"{name}.obj").write_text(obj_text(triangles, f"{about}, bow along y, waterline at z = 0 [m]"))


if __name__ == "__main__":
    main()
