// Numbers at nodes, which colour the skin; see tissuec/view/player/fields.py.

// What shaders and the functions below take for a number that is unknown.
const UNKNOWN = -1e38;

class NodeField {
  constructor(film, arrays, spec) {
    Object.assign(this, spec, { film, arrays, packed: arrays[`field ${spec.name}`] });
    [this.divisor, this.unit] = spec.shown;
    if (spec.usual.every((end, k) => end === spec.range[k])) this.range = this.usual;
  }

  get isSigned() { return this.range[0] < 0; }

  // Return the numbers of all nodes in a frame.
  fill(frame) {
    const { film, arrays, packed } = this, found = new Float32Array(film.nodes);
    if (packed) {
      for (let i = 0; i < film.nodes; i += 1) found[i] = this.level(frame, i);
      return found;
    }
    const [place, home] = this.vectors(frame);
    for (let i = 0; i < 3 * film.nodes; i += 3) {
      found[i / 3] = Math.hypot(place[i] - home[i], place[i + 1] - home[i + 1], place[i + 2] - home[i + 2]);
    }
    return found;
  }

  // Return the vectors of a frame, and those from which they are measured.
  vectors(frame) {
    const { film, arrays } = this;
    if (this.name === "displacement") {
      this.home ??= vectors(arrays.home, 0, film.step, film.origin);
      return [vectors(arrays.position, frame, film.step, film.origin), this.home];
    }
    this.none ??= new Float32Array(3 * film.nodes);
    return [vectors(arrays.force, frame, film.most.force / film.steps.force, [0, 0, 0]), this.none];
  }

  level(frame, node) {
    const { data, low, width } = this.packed, level = low + data[frame * width + node];
    return level > 0 ? this.extent[0] + (level - 1) * this.step : UNKNOWN;
  }
}

// Return the colours between whose shades numbers of a field stand, from its low end on.
function shadesOf(field, looks, look) {
  const list = field.isSigned ? looks.tension : looks.amount;
  return list.map((text) => seenIn(look, text, looks));
}
