// What is drawn: nets, skins, instruments and arrows, by WebGL 2.

const MANY = 40000;  // triangles that are too small to be rounded, and lines of which some will do

// Put a list in an order without an order, the same each time.
function shuffle(list) {
  let seed = 1;
  for (let i = list.length - 1; i > 0; i -= 1) {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    const k = Math.floor((seed / 2 ** 32) * (i + 1));
    [list[i], list[k]] = [list[k], list[i]];
  }
}

class Stage {
  constructor(canvas, film, arrays) {
    this.canvas = canvas;
    this.film = film;
    this.arrays = arrays;
    this.gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
    this.isLost = false;
    this.prepare();
  }

  // Make all that the graphics hardware holds; again when it has forgotten everything.
  prepare() {
    const { gl, film, arrays } = this;
    this.programs = {};
    for (const [name, source] of Object.entries(film.shaders)) {
      if (name !== "shared") this.programs[name] = new Program(gl, film.shaders.shared, source);
    }
    const points = arrays.position.width / 3;
    this.places = new Field(gl, points, (frame) => vectors(arrays.position, frame, film.step, film.origin));
    this.rates = new Field(gl, points, (frame) => vectors(arrays.velocity, frame, film.rate, [0, 0, 0]));
    const most = film.most.force / film.steps.force;
    this.forces = new Field(gl, film.nodes, (frame) => vectors(arrays.force, frame, most, [0, 0, 0]));
    this.values = new Field(gl, film.nodes, (frame) => this.field.fill(frame), 1);
    this.field = null;
    this.values.bind(UNITS.value0);
    this.colours = gl.createTexture();
    this.makeColours("light");
    this.makeLines();
    this.makeSkin();
    this.makeSurfaces();
    this.makeSolids();
    this.cap = new Cap(this);
    this.instruments = new Instruments(this);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthFunc(gl.LEQUAL);
  }

  // Fill the table of colours for a light or dark page.
  makeColours(look) {
    const { gl, film } = this, width = 256, data = new Uint8Array(width * 3 * 4);
    const [series, ...ramps] = [film.looks.series, film.looks.tension, film.looks.amount].map(
      (list) => list.map((text) => seenIn(look, text, film.looks)),
    );
    this.lookOfColours = look;
    for (let i = 0; i < width; i += 1) {
      const [signed, amount] = ramps.map((shades) => shadeAt(shades, i / (width - 1)));
      [signed, series[i % series.length], amount].forEach((colour, line) => {
        data.set([...colour.map((value) => Math.round(255 * value)), 255], 4 * (line * width + i));
      });
    }
    gl.activeTexture(gl.TEXTURE0 + UNITS.colours);
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, 3, 0, gl.RGBA, gl.UNSIGNED_BYTE, data);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.activeTexture(gl.TEXTURE0 + 7);
  }

  // Bind numbers to a place of the present vertex array.
  attribute(place, data, size, { every = 0, whole = false } = {}) {
    const { gl } = this, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    if (whole) gl.vertexAttribIPointer(place, size, gl.INT, 0, 0);
    else gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    gl.vertexAttribDivisor(place, every);
    return buffer;
  }

  makeLines() {
    const { gl, film, arrays } = this;
    const ends = table(arrays.ends, Int32Array), life = lives(arrays["life of lines"]);
    const rest = row(arrays.rest, 0, film.largest.rest / film.steps.level);
    const radius = row(arrays.radius, 0, film.largest.radius / film.steps.level);
    const law = row(arrays.law, 0);
    this.lineLife = life;
    const stitched = row(arrays.stitch, 0);
    this.isTube = Array.from(radius, (value, i) => value > 0 && !stitched[i]);
    const own = [], tubes = [], stitches = [];
    this.isTube.forEach((isTube, i) => (isTube ? tubes : own).push(i));
    stitched.forEach((isStitch, i) => { if (isStitch) stitches.push(i); });
    if (own.length > MANY) shuffle(own);  // so that any first part of them is spread evenly
    const pick = (data, size, chosen) => {
      const found = new data.constructor(size * chosen.length);
      chosen.forEach((i, k) => { for (let c = 0; c < size; c += 1) found[size * k + c] = data[size * i + c]; });
      return found;
    };
    const lines = { count: own.length, own, keys: [null, null] };
    lines.array = gl.createVertexArray();
    gl.bindVertexArray(lines.array);
    // Four times the same, for instances of so few corners are slow.
    const corners = Array.from({ length: 4 * own.length }, (_, i) => own[i >> 2]);
    this.attribute(1, pick(ends, 2, corners), 2, { whole: true });
    this.attribute(2, pick(life, 2, corners), 2);
    this.attribute(3, pick(rest, 1, corners), 1);
    this.attribute(4, pick(law, 1, corners), 1);
    lines.tensions = [5, 6].map((place) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, corners.length, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 1, gl.BYTE, true, 0, 0);
      return buffer;
    });
    const indices = new Uint32Array(6 * own.length);
    own.forEach((_, k) => indices.set([0, 1, 2, 1, 3, 2].map((i) => 4 * k + i), 6 * k));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    this.lines = lines;
    const round = (chosen) => ({ ends: pick(ends, 2, chosen), life: pick(life, 2, chosen), radius: pick(radius, 1, chosen) });
    this.tubes = round(tubes);
    this.stitches = round(stitches);
    let sum = 0, count = 0;
    rest.forEach((value) => { if (value > 0) { sum += value; count += 1; } });
    this.meanRest = count ? sum / count : film.view.size / 20;
    this.hasInside = own.length > 0;
  }

  showTensions(first, second) {
    const { gl, lines, arrays } = this, { data, low, width } = arrays.tension;
    [first, second].forEach((frame, slot) => {
      if (lines.keys[slot] === frame) return;
      const found = new Int8Array(4 * lines.count), start = frame * width;
      for (let i = 0; i < found.length; i += 1) found[i] = low + data[start + lines.own[i >> 2]];
      gl.bindBuffer(gl.ARRAY_BUFFER, lines.tensions[slot]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, found);
      lines.keys[slot] = frame;
    });
  }

  makeSkin() {
    const { gl, film, arrays } = this;
    const triangles = table(arrays.triangles, Int32Array), life = lives(arrays["life of skin"]);
    const smooth = arrays.smooth, isSmooth = (i) => smooth.low + smooth.data[i] > 0;
    this.skinLife = life;
    // Those that a smooth surface shows too stand last, to be left out together.
    const order = Array.from({ length: life.length / 2 }, (_, i) => i);
    order.sort((a, b) => isSmooth(a) - isSmooth(b));
    const sorted = (data, size) => {
      const found = new data.constructor(size * order.length);
      order.forEach((from, to) => found.set(data.subarray(size * from, size * (from + 1)), size * to));
      return found;
    };
    const nodes = sorted(triangles, 3), spans = sorted(life, 2), isFine = order.length > MANY;
    const held = sorted(lives(arrays["life of patches"]), 2), hollow = sorted(row(arrays.hollow, 0), 1);
    const shape = { nodes, spans, held, hollow };
    const isThere = (t, frame) => spans[2 * t] <= frame && frame < spans[2 * t + 1];
    const known = (field, frame, slot) => field.arrays[field.keys[slot] === frame ? slot : 1 - slot];
    const lists = isFine ? null : around(nodes, film.nodes), sides = isFine ? null : opposites(nodes);
    const facing = new Field(gl, isFine ? 1 : nodes.length, (frame, slot) => (isFine ? new Float32Array(3)
      : cornerNormals(known(this.places, frame, slot), nodes, lists, (t) => isThere(t, frame))));
    const bulge = new Field(gl, isFine ? 1 : nodes.length, (frame, slot) => (isFine ? new Float32Array(3)
      : bulges(known(this.places, frame, slot), nodes, known(facing, frame, slot), sides, (t) => isThere(t, frame))));
    this.skin = {
      flat: this.faces(1, shape), round: this.faces(film.divisions, shape), facing, bulge, isFine,
      count: order.length, bare: order.filter((i) => !isSmooth(i)).length,
    };
    this.makeTints();
  }

  // Return an array of triangles that are each drawn in parts.
  faces(divisions, { nodes, spans, held, hollow }) {
    const { gl } = this, array = gl.createVertexArray(), { weights, indices } = partsOfTriangle(divisions);
    gl.bindVertexArray(array);
    this.attribute(0, new Float32Array(weights), 2);
    this.attribute(1, nodes, 3, { every: 1, whole: true });
    if (spans) {
      this.attribute(2, spans, 2, { every: 1 });
      this.attribute(3, held, 2, { every: 1 });
      this.attribute(4, hollow, 1, { every: 1 });
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(indices), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { array, indices: indices.length };
  }

  // Fill a texture with the colours of the nodes.
  makeTints() {
    const { gl, arrays } = this, { data, low } = arrays.tints, rows = Math.ceil(data.length / 4 / ACROSS) || 1;
    const tints = new Uint8Array(4 * ACROSS * rows).map((_, i) => (i < data.length ? low + data[i] : 0));
    gl.activeTexture(gl.TEXTURE0 + UNITS.tints);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, ACROSS, rows, 0, gl.RGBA, gl.UNSIGNED_BYTE, tints);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.activeTexture(gl.TEXTURE0 + 7);
  }

  makeSurfaces() {
    const { gl, film, arrays } = this;
    this.surfaces = film.surfaces.map(({ name, pieces }) => pieces.map((piece) => {
      const position = arrays[`${piece.name} position`];
      const triangles = table(arrays[`${piece.name} triangles`], Int32Array);
      const places = new Field(gl, position.width / 3, (k) => vectors(position, k, film.step, piece.origin));
      const faces = this.faces(1, { nodes: triangles });
      const facing = new Field(gl, position.width / 3, (k, slot) => normals(
        places.arrays[places.keys[slot] === k ? slot : 1 - slot], triangles, () => true,
      ));
      return { name, frames: piece.frames, faces, count: triangles.length / 3, places, normals: facing, tint: piece.tint };
    }));
  }

  solids(mesh, ends, life, radius) {
    const { gl } = this, array = gl.createVertexArray(), count = radius.length;
    gl.bindVertexArray(array);
    this.attribute(0, new Float32Array(mesh.local), 3);
    this.attribute(1, new Float32Array(mesh.outward), 3);
    if (mesh.end) this.attribute(2, new Float32Array(mesh.end), 1);
    if (ends) {
      this.attribute(3, new Int32Array(ends), 2, { every: 1, whole: true });
      this.attribute(4, new Float32Array(life), 2, { every: 1 });
      this.attribute(5, new Float32Array(radius), 1, { every: 1 });
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(mesh.indices), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { array, count, indices: mesh.indices.length };
  }

  makeSolids() {
    const { film, arrays, gl } = this, always = [-1, 1e9];
    const round = capsuleMesh(36, 20), capsule = capsuleMesh(16, 10);
    const { rules } = film, marker = Math.min(rules.marker * film.view.size, rules.marker_rest * this.meanRest);
    const some = (kind) => film.solids.filter((solid) => solid.kind === kind);
    const made = (mesh, list) => this.solids(
      mesh, list.flatMap((s) => s.points), list.flatMap(() => always), list.map((s) => s.radius),
    );
    this.tools = made(round, some("capsule"));
    this.openings = made(tubeMesh(), some("opening"));
    this.planes = some("plane");
    this.threads = this.solids(capsule, this.tubes.ends, this.tubes.life, this.tubes.radius);
    this.seams = this.solids(capsule, this.stitches.ends, this.stitches.life, this.stitches.radius);
    const marks = (ends, life) => this.solids(capsule, ends, life, new Float32Array(life.length / 2).fill(marker));
    this.held = marks(table(arrays.held, Int32Array), lives(arrays["life of held"]));
    const dots = Array.from(arrays.dots.data, (value) => arrays.dots.low + value);
    this.dots = marks(dots.flatMap((node) => [node, node]), lives(arrays["life of dots"]));
    this.arrows = this.solids(arrowMesh(), null, null, []);
    this.square = gl.createVertexArray();
    gl.bindVertexArray(this.square);
    this.attribute(0, new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), 2);
    gl.bindVertexArray(null);
  }

  resize() {
    const { canvas, gl } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    this.ratio = ratio;
    return width / height;
  }

  // Draw a moment, counted in frames, as `shown` says.
  draw(moment, camera, shown, look) {
    const { gl, film, arrays } = this;
    if (gl.isContextLost()) return;
    const frame = Math.min(Math.floor(moment), film.times.length - 1);
    const next = Math.min(frame + 1, film.times.length - 1), mixing = next > frame ? moment - frame : 0;
    const isCurved = next > frame && arrays.curved.low + arrays.curved.data[frame] > 0;
    const span = isCurved ? film.times[next] - film.times[frame] : 0;
    const isDark = look === "dark", { looks } = film;
    if (this.lookOfColours !== look) this.makeColours(look);
    camera.follow(frame, next, mixing);
    const { view, projection } = camera.matrices();
    const { distance } = camera, size = film.view.size;
    const common = {
      view, projection, mixing, span, moment, distance, mostStrain: film.most.strain || 1,
      withSprings: shown.springs && this.lines.count > 0, paper: hexed(isDark ? looks.paper_dark : looks.paper),
      haze: [distance - 0.25 * size, distance + 0.9 * size],
      screen: [gl.drawingBufferWidth, gl.drawingBufferHeight], ...this.showField(shown.field, frame, next),
      ...cutOff(shown.section, camera, view),
    };
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.places.show(frame, next).bind(UNITS.place0);
    if (span) this.rates.show(frame, next).bind(UNITS.rate0);
    if (shown.tools) this.drawSolids(common, looks);
    if (shown.section && shown.surface !== "none") this.cap.draw(common, shown.section, [frame, next, mixing], isDark ? looks.ink_dark : looks.ink);
    if (shown.surface === "solid") this.drawSkins(common, moment, frame, next, 1);
    if (shown.springs) this.drawLines(common, frame, next, shown);
    else this.drawRound(this.seams, common, looks.silk);
    this.drawRound(this.dots, { ...common, ramp: -1 }, isDark ? looks.ink_dark : looks.steel);
    if (shown.forces) this.drawForces(common, frame, next, shown.reach);
    if (shown.surface === "glass") this.drawSkins(common, moment, frame, next, 0.38);
    if (shown.tools) this.drawPlanes(common);
  }

  // Have the numbers of a field ready for shaders, and return what these have to know of it.
  showField(field, frame, next) {
    if (!field) return { ramp: -1 };
    if (this.field !== field) this.values.keys = [null, null];
    this.field = field;
    this.values.show(frame, next).bind(UNITS.value0);
    return { ramp: field.isSigned ? 0 : 2, range: field.range };
  }

  drawLines(common, frame, next, shown) {
    const { gl, lines } = this;
    if (!lines.count) return;
    const isCrowded = Math.min(1, 18 / Math.sqrt(lines.count));
    gl.bindVertexArray(lines.array);
    this.showTensions(frame, next);
    const isField = shown.field && !this.skin.count;
    this.programs.lines.use({
      ...common, ramp: isField ? common.ramp : -1,
      width: (0.55 + 1.0 * isCrowded) * 1.25 * this.ratio,
      nearer: shown.surface === "solid" ? this.film.rules.nearer * this.film.view.size : 0,
      dashes: this.meanRest / this.film.rules.dashes,
      colouring: isField ? 3 : ["tension", "strain", "law"].indexOf(shown.colour),
    });
    const count = Math.ceil(lines.count * (shown.part || 1));
    gl.drawElements(gl.TRIANGLES, 6 * count, gl.UNSIGNED_INT, 0);
  }

  drawSkins(common, moment, frame, next, opacity) {
    const { film, skin } = this, { looks } = film, isNet = common.withSprings;
    // The skin steps back where springs lie on it, whose colours say something.
    const values = { ...common, opacity, inside: hexed(looks.lumen), steel: hexed(looks.steel), paler: isNet ? film.rules.paler : 0 };
    const isOwn = isNet || common.ramp >= 0 || common.isOpen;  // smooth surfaces have no nodes that fields are known at
    const shown = isOwn ? [] : this.surfaces.map((pieces) => this.pieceAt(pieces, moment)).filter(Boolean);
    const count = this.surfaces.length && !isOwn ? skin.bare : skin.count, isRounded = !isNet && !skin.isFine && !common.isOpen;
    const sides = opacity < 1 ? [this.gl.FRONT, this.gl.BACK] : [null];
    for (const side of sides) {
      if (count) {
        this.places.show(frame, next).bind(UNITS.place0);
        skin.facing.show(frame, next).bind(UNITS.normal0);
        if (isRounded) skin.bulge.show(frame, next).bind(UNITS.bulge0);
        const own = { byCorner: skin.isFine ? 2 : 1, isRounded: isRounded ? 1 : 0, plain: [0, 0, 0, -1] };
        this.drawFaces(isRounded ? skin.round : skin.flat, count, { ...values, ...own }, side, opacity);
      }
      for (const { piece, first, second, mixing } of shown) {
        piece.places.show(first, second).bind(UNITS.place0);
        piece.normals.show(first, second).bind(UNITS.normal0);
        this.gl.bindVertexArray(piece.faces.array);
        this.gl.vertexAttrib2f(2, -1, 1e9);
        this.gl.vertexAttrib2f(3, 0, 0);
        this.gl.vertexAttrib1f(4, 1);
        const own = { mixing, span: 0, byCorner: 0, isRounded: 0, plain: piece.tint };
        this.drawFaces(piece.faces, piece.count, { ...values, ...own }, side, opacity);
      }
    }
    this.places.bind(UNITS.place0);
  }

  drawFaces(faces, count, values, culled, opacity) {
    const { gl } = this;
    if (culled !== null) {
      gl.enable(gl.CULL_FACE);
      gl.cullFace(culled);
    }
    gl.depthMask(opacity === 1);
    gl.bindVertexArray(faces.array);
    this.programs.skin.use(values);
    gl.drawElementsInstanced(gl.TRIANGLES, faces.indices, gl.UNSIGNED_SHORT, 0, count);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
  }

  // Return which piece of a smooth surface is seen, and between which of its frames.
  pieceAt(pieces, moment) {
    const begun = pieces.filter((piece) => piece.frames[0] <= moment + 1e-6);
    const piece = begun.length ? begun[begun.length - 1] : pieces[0];
    const [first, second, mixing] = between(piece.frames, moment);
    return { piece, first, second, mixing };
  }

  drawRound(solids, common, colour, behind = 0) {
    const { gl } = this;
    if (!solids.count) return;
    gl.bindVertexArray(solids.array);
    this.programs.solids.use({ ...common, base: hexed(colour), behind });
    gl.drawElementsInstanced(gl.TRIANGLES, solids.indices, gl.UNSIGNED_SHORT, 0, solids.count);
  }

  drawSolids(common, looks) {
    const { rules, view } = this.film, whole = { ...common, cut: WHOLE, ramp: -1 };
    this.drawRound(this.tools, whole, looks.steel);
    this.drawRound(this.openings, whole, looks.steel, rules.opening * view.size);
    this.instruments.draw(whole, looks);
    this.drawRound(this.threads, common, looks.silk);
    this.drawRound(this.held, { ...common, ramp: -1 }, looks.steel);
  }

  drawForces(common, frame, next, reach) {
    const { gl, film, arrows } = this;
    if (!film.most.force) return;
    this.forces.show(frame, next).bind(UNITS.force0);
    gl.bindVertexArray(arrows.array);
    this.programs.arrows.use({
      ...common, reach, thick: film.rules.thick * film.view.size, base: hexed(film.looks.series[2]),
    });
    gl.drawElementsInstanced(gl.TRIANGLES, arrows.indices, gl.UNSIGNED_SHORT, 0, film.nodes);
  }

  drawPlanes(common) {
    const { gl, film } = this;
    if (!this.planes.length) return;
    const low = [0, 1, 2].map((k) => Math.min(...film.view.points.map((p) => p[k])));
    const high = [0, 1, 2].map((k) => Math.max(...film.view.points.map((p) => p[k])));
    gl.depthMask(false);
    gl.bindVertexArray(this.square);
    for (const plane of this.planes) {
      this.programs.plane.use({
        ...common, points: plane.points, middle: low.map((value, k) => (value + high[k]) / 2),
        size: 1.1 * film.view.size, cell: round125(film.view.size / 8), base: hexed(film.looks.steel),
      });
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    gl.depthMask(true);
  }

  // Return how many springs and triangles are there at a moment.
  count(moment) { return { springs: tally(this.lineLife, moment), triangles: tally(this.skinLife, moment) }; }

  finish() { this.gl.finish(); }
}
