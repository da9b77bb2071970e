// Places of labels in the picture, clear of each other; the same as placing.py.

const RIM = 4;  // pixels between labels and the rim of the picture
const LINES = [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6];  // by which a label gives way, in its heights

// Return the boxes of elements within another one, as left, top, right and bottom [px].
function boxesIn(frame, elements) {
  const { left, top } = frame.getBoundingClientRect();
  return elements.map((element) => element.getBoundingClientRect())
    .filter(({ width }) => width > 0)
    .map((box) => [box.left - left, box.top - top, box.right - left, box.bottom - top]);
}

class Placing {
  constructor(width, height, taken) { Object.assign(this, { width, height, taken, rivals: [] }); }

  // Take the best place for a label beside a point, and return its left and its middle [px].
  beside([x, y], [wide, high], isRight, gap) {
    const sides = [x + gap, x - gap - wide], places = [];
    if (!isRight) sides.reverse();
    const inside = (value, room, most) => Math.max(RIM, Math.min(most - RIM - room, value));
    for (const line of LINES) {
      for (const side of sides) {
        const left = inside(side, wide, this.width);
        // A label that the rim moves over the point is placed above or below it.
        const lines = left === side ? line : line + (line > 0 ? 1 : -1);
        const top = inside(y - high / 2 + lines * high, high, this.height);
        places.push([left, top, left + wide, top + high]);
      }
    }
    const covered = places.map((place) => this.covered(place) + this.strays(place, [x, y]));
    const best = places[covered.indexOf(Math.min(...covered))];
    this.taken.push(best);
    return [best[0], (best[1] + best[3]) / 2];
  }

  // Return a small cost of a box that is nearer to another point that has a label than to its own.
  strays([left, top, right, bottom], own) {
    const away = ([x, y]) => Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
    return this.rivals.some((one) => away(one) <= away(own)) ? 1 : 0;
  }

  // Return the area of a box that others have.
  covered([left, top, right, bottom]) {
    return this.taken.reduce((sum, [a, b, c, d]) => sum
      + Math.max(0, Math.min(right, c) - Math.max(left, a)) * Math.max(0, Math.min(bottom, d) - Math.max(top, b)), 0);
  }
}
