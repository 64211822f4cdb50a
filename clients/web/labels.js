// Places labels beside marks so that none covers a mark or another label; where there is no room beside, with a leader line.

const CELL = 64; // CSS pixels, of the grid that finds the boxes near a point
const COLUMN = 65_536; // cells; more than a screen has
const HEIGHT = 15; // CSS pixels, of a label
const GAP = 3; // CSS pixels, between a mark and its label
const BESIDE = [90, 270, 45, 135, 315, 225]; // degrees clockwise from the top: right and left first
const LEADERS = [18, 36, 60, 90]; // CSS pixels, of leader lines from the edge of a mark
const SHORT = 36; // CSS pixels; a longer leader line crosses no other mark
const TURNS = [...Array(16).keys()].map((k) => 22.5 * ((k * 5 + 4) % 16)); // from the right, in steps that leave the first ones apart
const STEP = 6; // CSS pixels, between the points of a leader line that must be free

/** Boxes [x, y, width, height] by the cells of a grid. */
class Boxes {
  constructor(boxes) {
    this.cells = new Map();
    for (const box of boxes) this.add(box);
  }

  add(box) {
    for (const key of this.keys(box)) {
      if (!this.cells.has(key)) this.cells.set(key, []);
      this.cells.get(key).push(box);
    }
  }

  /** Whether a box is free of all others but `own`. */
  isFree(box, own) {
    return this.keys(box).every((key) => (this.cells.get(key) ?? []).every((other) => other === own || !overlap(box, other)));
  }

  keys([x, y, width, height]) {
    const keys = [];
    for (let i = Math.floor(x / CELL); i * CELL < x + width; i++) {
      for (let j = Math.floor(y / CELL); j * CELL < y + height; j++) keys.push(i * COLUMN + j);
    }
    return keys;
  }
}

const overlap = ([x, y, w, h], [u, v, width, height]) => x < u + width && u < x + w && y < v + height && v < y + h;

/** Places the label of each mark {x, y, half, width}: its middle, half its side, and the width of its label [CSS pixels]. The
 *  first ones choose first. A short leader line crosses other marks where there is no other way.
 *  isInside([x, y, width, height]): whether a box is in the picture; taken: boxes of other labels. Returns for each mark
 *  {x, y, align, leader, box}: where text stands, the points of its leader line or null, its box; null without room. */
export function placeLabels(marks, isInside, taken) {
  const own = marks.map(({ x, y, half }) => [x - half, y - half, 2 * half, 2 * half]);
  const [squares, texts] = [new Boxes(own), new Boxes(taken)];
  return marks.map((mark, k) => {
    const fits = ({ box, line }) => isInside(box) && squares.isFree(box, own[k]) && [box, ...line].every((one) => texts.isFree(one));
    const isClear = (one) => fits(one) && one.line.every((point) => squares.isFree(point, own[k]));
    const all = candidates(mark);
    const place = all.find(isClear) ?? all.find((one) => one.length <= SHORT && fits(one));
    if (place) for (const box of [place.box, ...place.line]) texts.add(box);
    return place ?? null;
  });
}

function candidates(mark) {
  const beside = BESIDE.map((degrees) => candidate(mark, degrees, 0));
  return [...beside, ...LEADERS.flatMap((length) => TURNS.map((degrees) => candidate(mark, degrees, length)))];
}

/** A label in a direction from a mark, at the end of a leader line of a length. */
function candidate({ x, y, half, width }, degrees, length) {
  const [right, down] = [Math.sin((degrees * Math.PI) / 180), -Math.cos((degrees * Math.PI) / 180)];
  const edge = half / Math.max(Math.abs(right), Math.abs(down)); // from the middle of the square to its side
  const [u, v] = [x + right * (edge + length), y + down * (edge + length)];
  const side = Math.abs(right) < 0.1 ? 0 : Math.sign(right);
  const left = u + side * GAP - [width, width / 2, 0][side + 1];
  const middle = v + (side ? (down * HEIGHT) / 2 : Math.sign(down) * (HEIGHT / 2));
  return {
    x: u + side * GAP, y: middle, length, align: ["right", "center", "left"][side + 1],
    box: [left, middle - HEIGHT / 2, width, HEIGHT],
    ...leaderTo(length, [x + right * edge, y + down * edge], [u, v]),
  };
}

/** A leader line of a length between two points, and the small boxes along it that must be free. */
function leaderTo(length, [x, y], [u, v]) {
  if (!length) return { leader: null, line: [] };
  const count = Math.ceil(length / STEP);
  const shares = [...Array(count).keys()].map((k) => k / count);
  return { leader: [[x, y], [u, v]], line: shares.map((share) => [x + share * (u - x) - 1, y + share * (v - y) - 1, 2, 2]) };
}
