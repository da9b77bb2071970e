// The net drawn without WebGL: flat faces and lines on a plain canvas, the far ones first.

const PARTS = 6;  // of a piece of a thread, each of one colour
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

  finish() {}

  // Draw a moment, counted in frames, as `shown` says, in one of the FORMS.
  draw(moment, camera, shown, look, form) {
    const { film, arrays, pen, canvas } = this, last = film.times.length - 1;
    const frame = Math.min(Math.floor(moment), last), next = Math.min(frame + 1, last);
    const mixing = next > frame ? moment - frame : 0;
    fill(canvas, form.scale);
    camera.follow(frame, next, mixing);
    const isCurved = next > frame && arrays.curved.low + arrays.curved.data[frame] > 0;
    const span = isCurved ? film.times[next] - film.times[frame] : 0;
    this.look = look;
    this.showField(shown.field, frame, next, mixing);
    this.axes = camera.axes;
    this.eye = camera.eye;
    this.scale = canvas.height / 2 / camera.half;
    this.nearest = camera.distance / 100;
    this.items = [];
    const place = pointsBetween(this, arrays.position, [frame, next, mixing], film.origin, span);
    this.cut = shown.section ? shown.section.towards(this.eye) : null;
    if (shown.surface !== "none") this.addSkins(place, moment, shown);
    if (shown.section && shown.surface !== "none") this.addCap(place, moment, shown.section);
    this.addLines(place, moment, frame, next, mixing, shown);
    if (shown.tools) this.addSolids(place, moment);
    this.cut = null;
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
    const [from, to] = [frame, next].map((row) => field.fill(row));
    const shades = shadesOf(field, this.film.looks, this.look);
    const at = (node) => from[node] + mixing * (to[node] - from[node]);
    // Of the mean of nodes, or of a place on the way from the first to the second.
    this.colourOf = (nodes, part = null) => {
      const mean = () => nodes.reduce((sum, node) => sum + at(node), 0) / nodes.length;
      const value = part === null ? mean() : at(nodes[0]) + part * (at(nodes[1]) - at(nodes[0]));
      if (value < UNKNOWN / 10) return [1, 1, 1].map((value) => value * this.film.rules.unknown);
      return shadeAt(shades, field.part(value));
    };
  }

  // Return the parts of a face or line that are not in front of the section.
  behind(points) { return this.cut ? clipped(points, this.cut) : points; }

  addCap(place, moment, section) {
    const { points, triangles, ends, part, lines } = section.cut(place, moment), { tints } = this.arrays, { cut } = this;
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
      this.add([lines.slice(i, i + 3), lines.slice(i + 3, i + 6)], this.film.looks.ink, this.canvas.height / 500);
    }
    this.cut = cut;
  }

  // Return where a point is seen [px], and how far from the eye.
  seen(point) {
    const way = point.map((value, k) => value - this.eye[k]);
    const away = -dot(way, this.axes[2]), { canvas, scale } = this;
    return [canvas.width / 2 + (scale * dot(way, this.axes[0])) / away, canvas.height / 2 - (scale * dot(way, this.axes[1])) / away, away];
  }

  // Draw a face, or a line if it has a width, as far as it is behind the section.
  add(points, colour, width = 0, opacity = 1) {
    const corners = this.behind(points).map((point) => this.seen(point));
    if (!corners.length || corners.some((corner) => corner[2] < this.nearest)) return;
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
      const share = this.isThere(patches, t, moment) ? this.film.rules.held : 0, node = this.triangles[3 * t];
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
    const { rules } = this.film, every = Math.ceil(triangles.length / 3 / MOST_FLAT);
    const lamp = rules.lamp.map((value) => value / Math.hypot(...rules.lamp));
    for (let t = 0; t < triangles.length / 3; t += every) {
      if (!isShown(t)) continue;
      const at = [0, 1, 2].map((k) => triangles[3 * t + k]);
      const [a, b, c] = at.map((i) => pointAt(place, i));
      const normal = cross(b.map((value, k) => value - a[k]), c.map((value, k) => value - a[k]));
      const size = Math.hypot(...normal) || 1, isFront = dot(normal, a.map((value, k) => this.eye[k] - value)) > 0;
      const facing = this.axes.map((axis) => (dot(normal, axis) / size) * (isFront ? 1 : -1));
      const light = isPlain ? rules.lit + (1 - rules.lit) * Math.abs(facing[2]) : 0.62 + 0.38 * Math.max(0, dot(facing, lamp));
      this.add([a, b, c], css(tint(t, isFront).map((value) => light * value)), 0, opacity);
    }
  }

  addLines(place, moment, frame, next, mixing, shown) {
    const { ends, film, arrays, canvas } = this, { data, low, width } = arrays.tension;
    const every = Math.ceil(ends.length / 2 / MOST_FLAT), pixel = canvas.height / 500;
    const shades = film.looks.tension.map((text) => seenIn(this.look, text, film.looks));
    for (let s = 0; s < ends.length / 2; s += 1) {
      if (!this.isThere(this.lineLife, s, moment)) continue;
      const nodes = [ends[2 * s], ends[2 * s + 1]], points = nodes.map((i) => pointAt(place, i));
      if (this.threads[s] > 0 && !(this.stitched[s] && shown.springs)) {
        const wide = (2 * this.threads[s] * this.scale) / this.seen(points[0])[2];
        if (shown.tools || this.stitched[s]) this.addThread(points, nodes, Math.max(wide, pixel));
        continue;
      }
      if (!shown.springs || s % every) continue;
      let value = (low + (1 - mixing) * data[frame * width + s] + mixing * data[next * width + s]) / film.steps.tension;
      if (shown.colour === "strain") value = this.strain(place, s) / (film.most.strain || 1);
      const series = film.looks.series[(arrays.law.low + arrays.law.data[s]) % film.looks.series.length];
      const ramp = ((Math.max(-1, Math.min(1, value)) + 1) / 2) * (shades.length - 1);
      const colour = shown.colour === "law" ? seenIn(this.look, series, film.looks) : shades[Math.round(ramp)];
      const isField = this.colourOf && !this.triangles.length;
      this.add(points, css(isField ? this.colourOf(nodes) : colour), pixel * (0.8 + 0.6 * Math.min(1, Math.abs(value))));
    }
  }

  // Add a piece of a thread, in parts where a field gives them colours.
  addThread([from, to], nodes, width) {
    const count = this.colourOf ? PARTS : 1, at = (part) => from.map((value, k) => value + part * (to[k] - value));
    for (let i = 0; i < count; i += 1) {
      const colour = this.colourOf ? css(this.colourOf(nodes, (i + 0.5) / count)) : this.film.looks.silk;
      this.add([at(i / count), at((i + 1) / count)], colour, width);
    }
  }

  strain(place, s) {
    const [a, b] = [this.ends[2 * s], this.ends[2 * s + 1]];
    const length = Math.hypot(...[0, 1, 2].map((k) => place[3 * b + k] - place[3 * a + k]));
    return this.rest[s] > 0 ? length / this.rest[s] - 1 : 0;
  }

  addSolids(place, moment) {
    const { film, arrays, cut } = this, { steel } = film.looks, size = (this.canvas.height / 500) * 5;
    this.cut = null;  // instruments stay whole
    for (const { kind, radius, points } of film.solids) {
      if (kind === "plane") continue;
      const ends = points.map((i) => pointAt(place, i));
      if (kind === "opening") {  // the tube is behind it
        const way = ends[1].map((value, k) => value - ends[0][k]), back = (film.rules.opening * film.view.size) / Math.hypot(...way);
        ends[1] = ends[0].map((value, k) => value - back * way[k]);
      }
      this.add(ends, steel, Math.max(2, (2 * radius * this.scale) / this.seen(ends[0])[2]));
    }
    for (const one of film.instruments) {
      if (moment < one.life[0] || moment >= one.life[1]) continue;
      const { points, triangles } = posed(film, arrays, one, place);
      this.addFaces(points, triangles, () => true, 1, () => hexed(one.kind === "jet" ? film.looks.water : steel));
    }
    this.cut = cut;
    const life = lives(arrays["life of held"]), ends = table(arrays.held, Int32Array);
    for (let i = 0; i < life.length / 2; i += 1) {
      if (!this.isThere(life, i, moment)) continue;
      const points = [ends[2 * i], ends[2 * i + 1]].map((node) => pointAt(place, node));
      this.add(points, steel, size);
    }
  }

  addForces(place, frame, next, mixing, reach) {
    const { film, arrays } = this, step = film.most.force / film.steps.force;
    const [from, to] = [frame, next].map((k) => vectors(arrays.force, k, step, [0, 0, 0]));
    for (let i = 0; i < film.nodes; i += 1) {
      const tip = [0, 1, 2].map((k) => place[3 * i + k] + reach * (from[3 * i + k] + mixing * (to[3 * i + k] - from[3 * i + k])));
      const foot = pointAt(place, i), [from2, to2] = [foot, tip].map((point) => this.seen(point));
      if (Math.hypot(to2[0] - from2[0], to2[1] - from2[1]) > 3) {
        this.add([foot, tip], film.looks.series[2], this.canvas.height / 250);
      }
    }
  }

  stroke({ corners, colour, width, opacity }) {
    const { pen } = this;
    pen.globalAlpha = opacity;
    pen.beginPath();
    corners.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (width) {
      const [x, y] = corners[corners.length - 1];
      pen.lineTo(x + 0.1, y);  // so that a line without length is a dot
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

const pointAt = (place, i) => [place[3 * i], place[3 * i + 1], place[3 * i + 2]];

// Return the part of a line, or of a face without dents, that is not in front of a plane.
function clipped(points, { normal, offset }) {
  const height = points.map((point) => dot(point, normal) - offset), found = [];
  const count = points.length === 2 ? 1 : points.length;  // of sides
  points.forEach((point, i) => {
    const k = (i + 1) % points.length;
    if (height[i] <= 0) found.push(point);
    if (i < count && height[i] > 0 !== height[k] > 0) {
      const part = height[i] / (height[i] - height[k]);
      found.push(point.map((value, axis) => value + part * (points[k][axis] - value)));
    }
  });
  return found;
}
