// The net drawn without WebGL: flat faces and lines on a plain canvas, the far ones first.

const MOST_FLAT = 30000;  // faces and lines of a picture; of more, some are left out

class FlatStage {
  constructor(canvas, film, arrays) {
    Object.assign(this, { canvas, film, arrays });
    this.pen = canvas.getContext("2d");
    this.ends = table(arrays.ends, Int32Array);
    this.lineLife = lives(arrays["life of lines"]);
    this.triangles = table(arrays.triangles, Int32Array);
    this.skinLife = lives(arrays["life of skin"]);
    const { smooth } = arrays;
    this.isSmooth = (t) => smooth.low + smooth.data[t] > 0;
    this.surfaces = film.surfaces.map(({ pieces }) => pieces.map((piece) => ({
      ...piece, position: arrays[`${piece.name} position`],
      triangles: table(arrays[`${piece.name} triangles`], Int32Array),
    })));
    const radius = row(arrays.radius, 0, film.largest.radius / film.steps.level);
    this.stitched = row(arrays.stitch, 0);
    this.tubes = { radius: radius.filter((value, s) => value > 0 && !this.stitched[s]) };
    this.threads = radius;
    this.rest = row(arrays.rest, 0, film.largest.rest / film.steps.level);
    this.lines = { count: this.ends.length / 2 - this.tubes.radius.length };
    this.shades = {};
  }

  resize() {
    const { canvas } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    return canvas.width / canvas.height;
  }

  finish() {}

  // Draw a moment, counted in frames, as `shown` says.
  draw(moment, camera, shown, look) {
    const { film, arrays, pen, canvas } = this, last = film.times.length - 1;
    const frame = Math.min(Math.floor(moment), last), next = Math.min(frame + 1, last);
    const mixing = next > frame ? moment - frame : 0;
    camera.follow(frame, next, mixing);
    const isCurved = next > frame && arrays.curved.low + arrays.curved.data[frame] > 0;
    const span = isCurved ? film.times[next] - film.times[frame] : 0;
    this.look = look;
    this.showField(shown.field, frame, next, mixing);
    this.axes = camera.axes;
    this.eye = camera.target.map((value, k) => value + camera.shift[k] + camera.distance * this.axes[2][k]);
    this.scale = canvas.height / 2 / camera.half;
    this.nearest = camera.distance / 100;
    this.items = [];
    const place = pointsBetween(this, arrays.position, [frame, next, mixing], film.origin, span);
    this.cut = shown.section ? shown.section.towards(this.eye) : null;
    if (shown.surface !== "none") this.addSkins(place, moment, shown);
    if (shown.section && shown.surface !== "none") this.addCap(place, moment, shown.section);
    this.addLines(place, moment, frame, next, mixing, shown);
    if (shown.tools) this.addSolids(place, moment);
    if (shown.forces && film.most.force) this.addForces(place, frame, next, mixing, shown.reach);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.lineCap = "round";
    this.items.sort((a, b) => b.away - a.away);
    for (const item of this.items) this.stroke(item);
  }

  // Have a colour for each number of a field, and these between two frames.
  showField(field, frame, next, mixing) {
    this.colourOf = null;
    if (!field) return;
    const [from, to] = [frame, next].map((row) => field.fill(row)), [low, high] = field.range;
    const shades = shadesOf(field, this.film.looks, this.look);
    this.colourOf = (nodes) => {
      const value = nodes.reduce((sum, node) => sum + from[node] + mixing * (to[node] - from[node]), 0) / nodes.length;
      if (value < UNKNOWN / 10) return [0.62, 0.62, 0.62];
      return shadeAt(shades, Math.max(0, Math.min(1, (value - low) / (high - low))));
    };
  }

  // Return whether points are in front of the section, on average.
  isCutOff(points) {
    return this.cut !== null && points.reduce((sum, point) => sum + dot(point, this.cut.normal), 0) > points.length * this.cut.offset;
  }

  addCap(place, moment, section) {
    const { points, triangles, ends, part, lines } = section.cut(place, moment), { tints } = this.arrays;
    const tint = (t) => {
      const i = triangles[3 * t], nodes = [ends[2 * i], ends[2 * i + 1]];
      if (this.colourOf) return this.colourOf(nodes);
      return [0, 1, 2].map((k) => {
        const [a, b] = nodes.map((node) => (tints.low + tints.data[4 * node + k]) / 255);
        return a + part[i] * (b - a);
      });
    };
    this.cut = null;
    this.addFaces(points, triangles, () => true, 1, tint, Boolean(this.colourOf));
    for (let i = 0; i < lines.length; i += 6) {
      this.add([lines.slice(i, i + 3), lines.slice(i + 3, i + 6)].map((point) => this.seen(point, 0)), this.film.looks.ink, this.canvas.height / 500);
    }
    this.cut = section.towards(this.eye);
  }

  // Return where a point is seen [px], and how far from the eye.
  seen(place, i) {
    const way = [0, 1, 2].map((k) => place[3 * i + k] - this.eye[k]);
    const away = -dot(way, this.axes[2]), { canvas, scale } = this;
    return [canvas.width / 2 + (scale * dot(way, this.axes[0])) / away, canvas.height / 2 - (scale * dot(way, this.axes[1])) / away, away];
  }

  add(corners, colour, width = 0, opacity = 1) {
    if (corners.some((corner) => corner[2] < this.nearest)) return;
    const away = corners.reduce((sum, corner) => sum + corner[2], 0) / corners.length;
    // Lines lie on the faces that they belong to.
    this.items.push({ corners, colour, width, opacity, away: away - (width ? 0.03 * this.film.view.size : 0) });
  }

  addSkins(place, moment, shown) {
    const opacity = shown.surface === "glass" ? 0.38 : 1;
    const hasSmooth = this.surfaces.length > 0 && !shown.springs && !shown.field && !shown.section?.count;
    const own = (t) => !(hasSmooth && this.isSmooth(t)) && this.isThere(this.skinLife, t, moment);
    const { looks } = this.film, [lumen, steel] = [looks.lumen, looks.steel].map(hexed), { tints, hollow } = this.arrays;
    const patches = lives(this.arrays["life of patches"]);
    const tint = (t, isFront) => {
      if (this.colourOf) return this.colourOf([0, 1, 2].map((k) => this.triangles[3 * t + k]));
      if (!isFront && hollow.low + hollow.data[t] > 0) return lumen;
      const share = this.isThere(patches, t, moment) ? 0.75 : 0, node = this.triangles[3 * t];
      return steel.map((value, k) => {
        const own = (tints.low + tints.data[4 * node + k]) / 255;
        return own + share * (value - own);
      });
    };
    this.addFaces(place, this.triangles, own, opacity, tint, Boolean(this.colourOf));
    for (const pieces of hasSmooth ? this.surfaces : []) {
      const begun = pieces.filter((piece) => piece.frames[0] <= moment + 1e-6);
      const piece = begun.length ? begun[begun.length - 1] : pieces[0];
      const [first, second, part] = between(piece.frames, moment);
      this.addFaces(pointsBetween(this, piece.position, [first, second, part], piece.origin), piece.triangles, () => true, opacity, (_, isFront) => (isFront ? piece.tint : lumen));
    }
  }

  addFaces(place, triangles, isShown, opacity, tint, isPlain = false) {
    const { looks } = this.film, every = Math.ceil(triangles.length / 3 / MOST_FLAT);
    const lamp = [-0.39, 0.52, 0.65];
    for (let t = 0; t < triangles.length / 3; t += every) {
      if (!isShown(t)) continue;
      const at = [0, 1, 2].map((k) => triangles[3 * t + k]);
      const [a, b, c] = at.map((i) => [0, 1, 2].map((k) => place[3 * i + k]));
      if (this.isCutOff([a, b, c])) continue;
      const normal = cross(b.map((value, k) => value - a[k]), c.map((value, k) => value - a[k]));
      const size = Math.hypot(...normal) || 1, isFront = dot(normal, a.map((value, k) => this.eye[k] - value)) > 0;
      const facing = this.axes.map((axis) => (dot(normal, axis) / size) * (isFront ? 1 : -1));
      const light = isPlain ? 0.84 + 0.16 * Math.abs(facing[2]) : 0.62 + 0.38 * Math.max(0, dot(facing, lamp));
      this.add(at.map((i) => this.seen(place, i)), css(tint(t, isFront).map((value) => light * value)), 0, opacity);
    }
  }

  addLines(place, moment, frame, next, mixing, shown) {
    const { ends, film, arrays, canvas } = this, { data, low, width } = arrays.tension;
    const every = Math.ceil(ends.length / 2 / MOST_FLAT), pixel = canvas.height / 500;
    const shades = film.looks.tension.map((text) => seenIn(this.look, text, film.looks));
    for (let s = 0; s < ends.length / 2; s += 1) {
      if (!this.isThere(this.lineLife, s, moment)) continue;
      const corners = [ends[2 * s], ends[2 * s + 1]].map((i) => this.seen(place, i));
      if (this.threads[s] > 0 && !(this.stitched[s] && shown.springs)) {
        const wide = (2 * this.threads[s] * this.scale) / corners[0][2];
        if (shown.tools || this.stitched[s]) this.add(corners, film.looks.silk, Math.max(wide, pixel));
        continue;
      }
      if (!shown.springs || s % every) continue;
      if (this.isCutOff([ends[2 * s], ends[2 * s + 1]].map((i) => [0, 1, 2].map((k) => place[3 * i + k])))) continue;
      let value = (low + (1 - mixing) * data[frame * width + s] + mixing * data[next * width + s]) / film.steps.tension;
      if (shown.colour === "strain") value = this.strain(place, s) / (film.most.strain || 1);
      const series = film.looks.series[(arrays.law.low + arrays.law.data[s]) % film.looks.series.length];
      const ramp = ((Math.max(-1, Math.min(1, value)) + 1) / 2) * (shades.length - 1);
      const colour = shown.colour === "law" ? seenIn(this.look, series, film.looks) : shades[Math.round(ramp)];
      const isField = this.colourOf && !this.triangles.length;
      this.add(corners, css(isField ? this.colourOf([ends[2 * s], ends[2 * s + 1]]) : colour), pixel * (0.8 + 0.6 * Math.min(1, Math.abs(value))));
    }
  }

  strain(place, s) {
    const [a, b] = [this.ends[2 * s], this.ends[2 * s + 1]];
    const length = Math.hypot(...[0, 1, 2].map((k) => place[3 * b + k] - place[3 * a + k]));
    return this.rest[s] > 0 ? length / this.rest[s] - 1 : 0;
  }

  addSolids(place, moment) {
    const { film, arrays } = this, { steel } = film.looks, size = (this.canvas.height / 500) * 5;
    for (const { kind, radius, points } of film.solids) {
      if (kind === "plane") continue;
      const ends = points.map((i) => [0, 1, 2].map((k) => place[3 * i + k]));
      if (kind === "opening") {  // the tube is behind it
        const way = ends[1].map((value, k) => value - ends[0][k]), back = (0.3 * film.view.size) / Math.hypot(...way);
        ends[1] = ends[0].map((value, k) => value - back * way[k]);
      }
      const corners = ends.map((end) => this.seen(end, 0));
      this.add(corners, steel, Math.max(2, (2 * radius * this.scale) / corners[0][2]));
    }
    this.cut = null;  // instruments stay whole
    const life = lives(arrays["life of held"]), ends = table(arrays.held, Int32Array);
    for (let i = 0; i < life.length / 2; i += 1) {
      if (!this.isThere(life, i, moment)) continue;
      const [first, [x, y, away]] = [ends[2 * i], ends[2 * i + 1]].map((node) => this.seen(place, node));
      this.add([first, [x + 0.1, y, away]], steel, size);
    }
    for (const one of film.instruments) {
      if (moment < one.life[0] || moment >= one.life[1]) continue;
      const { points, triangles } = posed(film, arrays, one, place);
      this.addFaces(points, triangles, () => true, 1, () => hexed(one.kind === "jet" ? film.looks.water : steel));
    }
  }

  addForces(place, frame, next, mixing, reach) {
    const { film, arrays } = this, step = film.most.force / film.steps.force;
    const [from, to] = [frame, next].map((k) => vectors(arrays.force, k, step, [0, 0, 0]));
    for (let i = 0; i < film.nodes; i += 1) {
      const tip = [0, 1, 2].map((k) => place[3 * i + k] + reach * (from[3 * i + k] + mixing * (to[3 * i + k] - from[3 * i + k])));
      const corners = [this.seen(place, i), this.seen(tip, 0)];
      if (Math.hypot(corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]) > 3) {
        this.add(corners, film.looks.series[2], this.canvas.height / 250);
      }
    }
  }

  stroke({ corners, colour, width, opacity }) {
    const { pen } = this;
    pen.globalAlpha = opacity;
    pen.beginPath();
    corners.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (width) {
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.stroke();
      return;
    }
    pen.closePath();
    pen.fillStyle = colour;
    pen.strokeStyle = colour;
    pen.lineWidth = 0.7;  // lest the page shows between faces
    pen.fill();
    if (opacity === 1) pen.stroke();
  }

  isThere(life, i, moment) { return life[2 * i] <= moment && moment < life[2 * i + 1]; }

  // Return how many springs and triangles are there at a moment.
  count(moment) { return { springs: tally(this.lineLife, moment), triangles: tally(this.skinLife, moment) }; }
}
