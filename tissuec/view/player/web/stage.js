// What is drawn: nets, skins, instruments and arrows, by WebGL 2.

class Stage {
  constructor(canvas, film, arrays) {
    this.canvas = canvas;
    this.film = film;
    this.arrays = arrays;
    this.gl = canvas.getContext("webgl2", { antialias: false, alpha: true, premultipliedAlpha: true });
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
    this.target = new Target(gl);
    this.places = new Points(gl, points, (frame) => vectors(arrays.position, frame, film.step, film.origin),
      (frame) => vectors(arrays.velocity, frame, film.rate, [0, 0, 0]));
    const most = film.most.force / film.steps.force;
    this.forces = new Field(gl, film.nodes, (frame) => vectors(arrays.force, frame, most, [0, 0, 0]));
    this.values = new Field(gl, film.nodes, (frame) => this.field.fill(frame), 1);
    this.field = null;
    this.values.bind(UNITS.value0);
    this.colours = gl.createTexture();
    this.makeColours("light");
    this.makeTints();
    this.skin = new Skin(this);
    this.makeLines();
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

  // Tell threads and stitches, which are round, from the other lines.
  makeLines() {
    const { film, arrays } = this;
    const ends = table(arrays.ends, Int32Array), life = lives(arrays["life of lines"]);
    const rest = row(arrays.rest, 0, film.largest.rest / film.steps.level);
    const radius = row(arrays.radius, 0, film.largest.radius / film.steps.level);
    const stitched = row(arrays.stitch, 0), numbers = Array.from(radius.keys()), isTube = (i) => radius[i] > 0 && !stitched[i];
    // What only filled bodies have: nodes that are not of the skin.
    const isInside = new Uint8Array(film.nodes);
    for (const node of table(arrays.cells, Int32Array)) isInside[node] = 1;
    for (const node of this.skin.nodes) isInside[node] = 0;
    this.lineLife = life;
    this.lines = new Lines(this, {
      own: numbers.filter((i) => !isTube(i)), isInner: (i) => isInside[ends[2 * i]] || isInside[ends[2 * i + 1]],
      ends, life, rest, law: row(arrays.law, 0),
    });
    const round = (chosen) => ({ ends: picked(ends, 2, chosen), life: picked(life, 2, chosen), radius: picked(radius, 1, chosen) });
    this.tubes = round(numbers.filter(isTube));
    this.stitches = round(numbers.filter((i) => stitched[i]));
    const known = rest.filter((value) => value > 0);
    this.meanRest = known.length ? known.reduce((sum, value) => sum + value, 0) / known.length : film.view.size / 20;
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
      const places = new Points(gl, position.width / 3, (k) => vectors(position, k, film.step, piece.origin));
      const faces = new Faces(this, 1, { nodes: triangles });
      const facing = new Field(gl, position.width / 3, (k) => normals(places.at(k).place, triangles, () => true));
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
    this.rims = { count: 0 };
    if (arrays.rims) {
      const life = lives(arrays["life of rims"]), thin = new Float32Array(life.length / 2).fill(rules.thick * film.view.size);
      this.rims = this.solids(capsule, table(arrays.rims, Int32Array), life, thin);
    }
    const dots = Array.from(arrays.dots.data, (value) => arrays.dots.low + value);
    this.dots = marks(dots.flatMap((node) => [node, node]), lives(arrays["life of dots"]));
    this.arrows = this.solids(arrowMesh(), null, null, []);
    this.square = gl.createVertexArray();
    gl.bindVertexArray(this.square);
    this.attribute(0, new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), 2);
    gl.bindVertexArray(null);
  }

  // Draw a moment, counted in frames, as `shown` says, in one of the FORMS.
  draw(moment, camera, shown, look, form) {
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
    this.ratio = fill(this.canvas, form.scale);
    const frames = [frame, next, mixing], screen = this.target.begin(form.samples);
    // A closed skin hides everything inside from an eye outside.
    const isShut = this.skin.isClosed && shown.surface === "solid" && !shown.section && camera.isOutside;
    const common = {
      view, projection, mixing, moment, distance, isShut, eye: camera.eye, screen, mostStrain: film.most.strain || 1,
      withSprings: shown.springs && this.lines.count > 0, paper: hexed(isDark ? looks.paper_dark : looks.paper),
      haze: [distance - 0.25 * size, distance + 0.9 * size],
      ...this.showField(shown.field, frame, next),
      ...cutOff(shown.section, camera, view),
    };
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.places.show(frames, span).bind();
    if (shown.tools) this.drawSolids(common, looks, isDark ? looks.ink_dark : looks.ink);
    if (shown.section && shown.surface !== "none") this.cap.draw(common, shown.section, isDark ? looks.ink_dark : looks.ink);
    if (shown.surface === "solid") this.drawSkins(common, frames, 1, form);
    this.lines.part = 1;
    if (shown.springs) this.lines.draw(common, frames, shown, form);
    else this.drawRound(this.seams, common, looks.silk);
    this.drawRound(this.dots, { ...common, ramp: -1 }, isDark ? looks.ink_dark : looks.steel);
    if (shown.forces) this.drawForces(common, frame, next, shown.reach);
    if (shown.surface === "glass") this.drawSkins(common, frames, 0.38, form);
    if (shown.tools) this.drawPlanes(common);
    this.target.end();
  }

  // Have the numbers of a field ready for shaders, and return what these have to know of it.
  showField(field, frame, next) {
    if (!field) return { ramp: -1, isLog: 0 };
    if (this.field !== field) this.values.keys = [null, null];
    this.field = field;
    this.values.show(frame, next).bind(UNITS.value0);
    return { ramp: field.isSigned ? 0 : 2, range: field.range, isLog: field.isLog ? 1 : 0 };
  }

  drawSkins(common, frames, opacity, form) {
    const { gl, film, skin, places } = this, { looks } = film, isNet = common.withSprings;
    // The skin steps back where springs lie on it, whose colours say something.
    const values = { ...common, opacity, inside: hexed(looks.lumen), steel: hexed(looks.steel), paler: isNet ? film.rules.paler : 0 };
    const isOwn = isNet || common.ramp >= 0 || common.isOpen;  // smooth surfaces have no nodes that fields are known at
    const shown = isOwn ? [] : this.surfaces.map((pieces) => this.pieceAt(pieces, common.moment)).filter(Boolean);
    const count = this.surfaces.length && !isOwn ? skin.bare : skin.count;
    const divisions = isNet || skin.isFine || common.isOpen ? 1 : skin.divisions(form.faces);
    const sides = opacity < 1 ? [gl.FRONT, gl.BACK] : [common.isShut ? gl.BACK : null];
    for (const side of sides) {
      if (count) skin.draw(count, frames, divisions, values, side);
      for (const { piece, first, second, mixing } of shown) {
        piece.places.show([first, second, mixing]).bind();
        piece.normals.show(first, second).bind(UNITS.normal0);
        gl.bindVertexArray(piece.faces.array);
        gl.vertexAttrib2f(2, -1, 1e9);
        gl.vertexAttrib2f(3, 0, 0);
        gl.vertexAttrib1f(4, 1);
        piece.faces.draw(piece.count, { ...values, mixing, byCorner: 0, plain: piece.tint }, opacity < 1 ? side : null);
      }
    }
    places.bind();
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

  drawSolids(common, looks, ink) {
    const { rules, view } = this.film, whole = { ...common, cut: WHOLE, ramp: -1 };
    this.drawRound(this.tools, whole, looks.steel);
    this.drawRound(this.openings, whole, looks.steel, rules.opening * view.size);
    this.instruments.draw(whole, looks);
    this.drawRound(this.threads, common, looks.silk);
    this.drawRound(this.held, { ...common, ramp: -1 }, looks.steel);
    // Where colours are those of a field, what is held has a rim.
    if (common.ramp >= 0) this.drawRound(this.rims, { ...common, ramp: -1 }, ink);
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
  count(moment) { return { springs: tally(this.lineLife, moment), triangles: tally(this.skin.life, moment) }; }

  finish() { this.gl.finish(); }
}
