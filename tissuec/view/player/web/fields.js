// Numbers at nodes, which colour the skin; see tissuec/view/player/node_fields.py.

// What stands for a number that is unknown; see fieldColour in shared.glsl.
const UNKNOWN = -1e38;

// Return the vector of a node in a frame, in steps.
function vectorOf({ data, low, width }, frame, node) {
  const count = width / 3, first = frame * width + node;
  return [low + data[first], low + data[first + count], low + data[first + 2 * count]];
}

// Return between which frames a moment is, how far, and by which time cubics are scaled.
function span(film, arrays, moment) {
  const last = film.times.length - 1, frame = Math.min(Math.floor(moment), last), next = Math.min(frame + 1, last);
  const isCurved = next > frame && arrays.curved.low + arrays.curved.data[frame] > 0;
  return { frame, next, mixing: next > frame ? moment - frame : 0, long: isCurved ? film.times[next] - film.times[frame] : 0 };
}

// Return where a node is at a moment, as mixed() in arrays.js.
function placeOf(film, arrays, node, moment) {
  const { frame, next, mixing, long } = span(film, arrays, moment), left = 1 - mixing;
  const [from, to] = [frame, next].map((one) => vectorOf(arrays.position, one, node));
  const [begin, end] = [frame, next].map((one) => vectorOf(arrays.velocity, one, node));
  const speed = (long * film.rate) / film.step;
  return from.map((value, k) => {
    const way = to[k] - value;
    const bend = long ? mixing * left * (left * (speed * begin[k] - way) + mixing * (way - speed * end[k])) : 0;
    return film.origin[k] + film.step * (value + mixing * way + bend);
  });
}

class NodeField {
  constructor(film, arrays, spec) {
    Object.assign(this, spec, { film, arrays, packed: arrays[`field ${spec.name}`] });
    [this.divisor, this.unit] = spec.shown;
    if (this.whole.every((end, k) => end === spec.range[k])) this.range = this.whole;
    if (spec.name === "displacement") this.step = film.step;
    if (spec.name === "force") this.step = film.most.force / film.steps.force;
  }

  get isSigned() { return this.range[0] < 0; }

  // The range of the colours unless another one is chosen.
  get whole() { return this.isLog ? this.decades : this.usual; }

  // The number in the middle of the colours.
  get middle() { return this.isLog ? Math.sqrt(this.range[0] * this.range[1]) : (this.range[0] + this.range[1]) / 2; }

  // Return where a number lies in the range of the colours, from 0 to 1; as fieldColour in shared.glsl.
  part(value) {
    const [low, high] = this.range;
    const part = this.isLog ? Math.log(Math.max(value, 1e-37) / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.max(0, Math.min(1, part));
  }

  // Whether there are numbers below and above the range, by more than rounding.
  get beyond() {
    const [low, high] = this.range, near = 1e-6 * (high - low);
    return [this.extent[0] < low - near, this.extent[1] > high + near];
  }

  // Return the numbers of all nodes in a frame.
  fill(frame) { return Float32Array.from({ length: this.film.nodes }, (_, node) => this.number(frame, node)); }

  number(frame, node) {
    const { arrays, packed, step } = this;
    if (packed) {
      const level = packed.low + packed.data[frame * packed.width + node];
      return level > 0 ? this.extent[0] + (level - 1) * step : UNKNOWN;
    }
    const [x, y, z] = vectorOf(this.name === "force" ? arrays.force : arrays.position, frame, node);
    if (this.name === "force") return step * Math.hypot(x, y, z);
    const [a, b, c] = vectorOf(arrays.home, 0, node);
    return step * Math.hypot(x - a, y - b, z - c);
  }

  // Return the number of a node at a moment.
  at(node, moment) {
    const { film, arrays } = this;
    if (this.name === "displacement") {
      const place = placeOf(film, arrays, node, moment), home = vectorOf(arrays.home, 0, node);
      return Math.hypot(...place.map((value, k) => value - film.origin[k] - film.step * home[k]));
    }
    const { frame, next, mixing } = span(film, arrays, moment), from = this.number(frame, node);
    return from + mixing * (this.number(next, node) - from);
  }

  // Return a number of this field as text, with the digits that its steps have.
  text(value, mark = "") {
    if (value < UNKNOWN / 10) return "–";
    return `${mark}${stepped(value / this.divisor, this.step / this.divisor)} ${this.unit}`.trim();
  }

  // Whether a number is at least so large, because larger forces are packed as the largest one.
  isClipped(node, moment) {
    if (this.name !== "force") return false;
    const { frame, next } = span(this.film, this.arrays, moment), most = this.film.rules.longest * this.film.steps.force;
    return [frame, next].some((one) => vectorOf(this.arrays.force, one, node).some((value) => Math.abs(value) >= most));
  }
}

// Return the colours between whose shades numbers of a field stand, from its low end on.
function shadesOf(field, looks, look) {
  const list = field.isSigned ? looks.tension : looks.amount;
  return list.map((text) => seenIn(look, text, looks));
}
