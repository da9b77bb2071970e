// Springs as strips that face the eye.

const MANY = 40000;  // lines of which some will do, and triangles that are too small to be rounded
const THINNEST = 1.2;  // pixels of lines that would else be broken
const RIBBON = [0, 1, 2, 1, 3, 2];  // the corners of a line as two triangles

// Put a list in an order without an order, the same each time.
function shuffle(list) {
  let seed = 1;
  for (let i = list.length - 1; i > 0; i -= 1) {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    const k = Math.floor((seed / 2 ** 32) * (i + 1));
    [list[i], list[k]] = [list[k], list[i]];
  }
}

class Lines {
  // The lines with these numbers, those inside of bodies last.
  constructor(stage, { own, isInner, ends, life, rest, law }) {
    const { gl } = stage, outer = own.filter((i) => !isInner(i)), inner = own.filter(isInner);
    if (own.length > MANY) [outer, inner].forEach(shuffle);  // so that any first part of them is spread evenly
    this.pairs = picked(ends, 2, outer);
    Object.assign(this, { stage, own: [...outer, ...inner], outer: outer.length, count: own.length, keys: [null, null] });
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    // Four times the same, for instances of so few corners are slow.
    const corners = Array.from({ length: 4 * own.length }, (_, i) => this.own[i >> 2]);
    stage.attribute(1, picked(ends, 2, corners), 2, { whole: true });
    stage.attribute(2, picked(life, 2, corners), 2);
    stage.attribute(3, picked(rest, 1, corners), 1);
    stage.attribute(4, picked(law, 1, corners), 1);
    this.tensions = [5, 6].map((place) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, corners.length, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 1, gl.BYTE, true, 0, 0);
      return buffer;
    });
    [this.every, this.some] = [0, 1].map(() => gl.createBuffer());
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.every);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, ribbons([...own.keys()]), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  showTensions(first, second) {
    const { stage: { gl, arrays }, keys } = this, { data, low, width } = arrays.tension;
    [first, second].forEach((frame, slot) => {
      if (keys[slot] === frame) return;
      const found = new Int8Array(4 * this.count), start = frame * width;
      for (let i = 0; i < found.length; i += 1) found[i] = low + data[start + this.own[i >> 2]];
      gl.bindBuffer(gl.ARRAY_BUFFER, this.tensions[slot]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, found);
      keys[slot] = frame;
    });
  }

  // Have the indices of those that can be seen; return how many there are.
  choose({ isShut, eye }) {
    const { stage: { gl, skin }, pairs } = this;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, isShut ? this.some : this.every);
    if (!isShut) return this.count;
    const front = skin.front(eye), found = [];
    for (let k = 0; k < this.outer; k += 1) if (front[pairs[2 * k]] && front[pairs[2 * k + 1]]) found.push(k);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, ribbons(found), gl.DYNAMIC_DRAW);
    return found.length;
  }

  // Draw them, or a part of them, in one of the FORMS.
  draw(common, [frame, next], shown, { samples, springs }) {
    const { stage, count } = this, { gl, film } = stage;
    if (!count) return;
    const isCrowded = Math.min(1, 18 / Math.sqrt(count)), isField = shown.field && !stage.skin.count;
    gl.bindVertexArray(this.array);
    this.showTensions(frame, next);
    stage.programs.lines.use({
      ...common, ramp: isField ? common.ramp : -1,
      width: Math.max(samples ? 0 : THINNEST, (0.55 + 1.0 * isCrowded) * 1.25 * stage.ratio),
      nearer: shown.surface === "solid" ? film.rules.nearer * film.view.size : 0,
      dashes: stage.meanRest / film.rules.dashes,
      colouring: isField ? 3 : ["tension", "strain", "law"].indexOf(shown.colour),
    });
    const seen = this.choose(common);
    this.part = Math.min(1, springs / (seen || 1));  // of those that can be seen
    gl.drawElements(gl.TRIANGLES, 6 * Math.ceil(seen * this.part), gl.UNSIGNED_INT, 0);
  }
}

// Return the corners of two triangles for each of some lines.
function ribbons(numbers) {
  const found = new Uint32Array(6 * numbers.length);
  for (let i = 0; i < found.length; i += 1) found[i] = 4 * numbers[Math.floor(i / 6)] + RIBBON[i % 6];
  return found;
}

// Return the rows of a list with these numbers.
function picked(data, size, chosen) {
  const found = new data.constructor(size * chosen.length);
  chosen.forEach((i, k) => { for (let c = 0; c < size; c += 1) found[size * k + c] = data[size * i + c]; });
  return found;
}
