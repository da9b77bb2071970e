// Which node is where in the picture, and whether something hides it.

const NEAR_NODE = 14;  // pixels from the pointer to a node
const TRIED = 60;  // nodes that are looked for in sight

class Sight {
  constructor(film, arrays) {
    Object.assign(this, { film, arrays });
    this.triangles = table(arrays.triangles, Int32Array);
    this.skinLife = lives(arrays["life of skin"]);
    this.ends = table(arrays.ends, Int32Array);
    this.lineLife = lives(arrays["life of lines"]);
    const { ids } = arrays;
    this.hasSkin = this.triangles.length > 0;
    this.isDrawn = new Uint8Array(film.nodes);
    // Corners of parts of cut elements are no nodes, and have the id -1.
    for (const node of [...this.ends, ...this.triangles, ...row(arrays.dots, 0)]) this.isDrawn[node] = ids.low + ids.data[node] !== -1;
  }

  // Look at a moment through a camera, on a picture of so many pixels.
  look(moment, camera, width, height, isSolid, section) {
    const { film, arrays } = this;
    if (this.moment !== moment) {
      this.place = new Float64Array(3 * film.nodes);
      for (let i = 0; i < film.nodes; i += 1) this.place.set(placeOf(film, arrays, i, moment), 3 * i);
    }
    const [right, up, eye] = camera.axes;
    const from = camera.target.map((value, k) => value + camera.shift[k] + camera.distance * eye[k]);
    Object.assign(this, { moment, camera, width, height, right, up, eye, from, isSolid: isSolid && this.hasSkin });
    this.cut = section?.isOn ? section.towards(from) : null;
    this.cap = this.cut && section.count ? section.cut(this.place, moment) : null;
    this.cutNodes = new Set(this.cap?.ends);
    return this;
  }

  at(node) { return [this.place[3 * node], this.place[3 * node + 1], this.place[3 * node + 2]]; }

  // Return where a node is seen [px].
  pixel(node) {
    const [x, y] = this.camera.seen(this.at(node));
    return [((1 + x) * this.width) / 2, ((1 - y) * this.height) / 2];
  }

  // Return the first triangle along a way from the eye, but for those at a node, and how far it is.
  hit(way, but = -1) {
    const { triangles, place, skinLife, moment, from } = this;
    let best = Infinity, found = -1;
    for (let t = 0; t < triangles.length / 3; t += 1) {
      if (!(skinLife[2 * t] <= moment && moment < skinLife[2 * t + 1])) continue;
      const i = triangles[3 * t], j = triangles[3 * t + 1], k = triangles[3 * t + 2];
      if (i === but || j === but || k === but) continue;
      const far = crossing(place, 3 * i, 3 * j, 3 * k, from, way);
      if (far < best && !this.isCutOff(from.map((value, n) => value + far * way[n]))) [best, found] = [far, t];
    }
    return { triangle: found, far: best };
  }

  // Return whether a point is in front of the section, where nothing is drawn.
  isCutOff(point) { return this.cut !== null && dot(point, this.cut.normal) > this.cut.offset; }

  // Return the triangle of the cut face along a way from the eye, and how far it is.
  hitCap(way) {
    let best = Infinity, found = -1;
    const { points, triangles } = this.cap ?? { triangles: [] };
    for (let t = 0; t < triangles.length; t += 3) {
      const far = crossing(points, 3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2], this.from, way);
      if (far < best) [best, found] = [far, t];
    }
    return { triangle: found, far: best };
  }

  // Return whether no skin hides a node.
  isSeen(node) {
    if (!this.isDrawn[node] || dot(this.at(node).map((value, k) => value - this.from[k]), this.eye) >= 0) return false;
    if (this.isCutOff(this.at(node))) return false;
    const way = this.at(node).map((value, k) => value - this.from[k]), before = 1 - 1e-3;
    if (this.hitCap(way).far <= before && !this.cutNodes.has(node)) return false;
    return !this.isSolid || this.hit(way, node).far > before;
  }

  // Return the node under a pixel: of the first triangle there, or one that is near enough.
  under(x, y) {
    const { camera } = this, across = ((2 * x) / this.width - 1) * camera.half * camera.aspect, above = (1 - (2 * y) / this.height) * camera.half;
    const way = this.eye.map((value, k) => across * this.right[k] + above * this.up[k] - value);
    const { triangle, far } = this.isSolid ? this.hit(way) : { triangle: -1, far: Infinity }, face = this.hitCap(way);
    if (face.far < far) {
      const { ends: pairs, triangles } = this.cap, corners = triangles.slice(face.triangle, face.triangle + 3);
      const ends = corners.flatMap((corner) => pairs.slice(2 * corner, 2 * corner + 2));
      return this.ordered(x, y, ends.filter((node) => !this.isCutOff(this.at(node))))[0].node;
    }
    if (triangle >= 0) {
      const corners = Array.from(this.triangles.subarray(3 * triangle, 3 * triangle + 3));
      return this.ordered(x, y, corners)[0].node;
    }
    const near = this.ordered(x, y).filter(({ away }) => away <= NEAR_NODE);
    return near.find(({ node }) => this.isSeen(node))?.node ?? null;
  }

  // Return nodes with their pixels, the nearest ones to a pixel first.
  ordered(x, y, nodes = this.every) {
    const found = nodes.map((node) => {
      const [u, v] = this.pixel(node);
      return { node, u, v, away: Math.hypot(u - x, v - y) };
    });
    return found.sort((a, b) => a.away - b.away);
  }

  get every() { return Array.from(this.isDrawn.keys()).filter((node) => this.isDrawn[node]); }

  // Return the node in sight that is nearest to the middle of the picture.
  central() {
    const found = this.ordered(this.width / 2, this.height / 2).slice(0, 10 * TRIED);
    return found.find(({ node }) => this.isSeen(node))?.node ?? null;
  }

  // Return the node in sight beside another one, in a direction of the picture; itself without any.
  beside(node, across, down) {
    const [x, y] = this.pixel(node);
    const along = ({ u, v, away }) => (away > 0.5 ? ((u - x) * across + (v - y) * down) / away : -1);
    const best = (nodes, least) => this.ordered(x, y, nodes).filter((one) => along(one) > least)
      .slice(0, TRIED).filter((one) => this.isSeen(one.node))
      .sort((a, b) => a.away / along(a) ** 2 - b.away / along(b) ** 2)[0]?.node;
    return best(this.neighbours(node), 0.6) ?? best(this.every, 0.7) ?? node;
  }

  neighbours(node) {
    const { ends, triangles, lineLife, skinLife, moment } = this, found = new Set();
    const collect = (list, size, life) => {
      for (let i = 0; i < list.length; i += 1) {
        const first = size * Math.floor(i / size), one = first / size;
        if (list[i] !== node || !(life[2 * one] <= moment && moment < life[2 * one + 1])) continue;
        for (let k = 0; k < size; k += 1) found.add(list[first + k]);
      }
    };
    collect(ends, 2, lineLife);
    collect(triangles, 3, skinLife);
    found.delete(node);
    return [...found].filter((one) => this.isDrawn[one]);
  }
}

// Return how many ways from a point it is to a triangle; infinite beside it (T. Möller, B. Trumbore,
// Journal of Graphics Tools 2 (1997) 21).
function crossing(p, i, j, k, from, [dx, dy, dz]) {
  const ax = p[j] - p[i], ay = p[j + 1] - p[i + 1], az = p[j + 2] - p[i + 2];
  const bx = p[k] - p[i], by = p[k + 1] - p[i + 1], bz = p[k + 2] - p[i + 2];
  const ux = dy * bz - dz * by, uy = dz * bx - dx * bz, uz = dx * by - dy * bx, size = ax * ux + ay * uy + az * uz;
  if (size === 0) return Infinity;
  const sx = from[0] - p[i], sy = from[1] - p[i + 1], sz = from[2] - p[i + 2];
  const u = (sx * ux + sy * uy + sz * uz) / size;
  if (u < -1e-9 || u > 1 + 1e-9) return Infinity;
  const qx = sy * az - sz * ay, qy = sz * ax - sx * az, qz = sx * ay - sy * ax;
  const v = (dx * qx + dy * qy + dz * qz) / size;
  if (v < -1e-9 || u + v > 1 + 1e-9) return Infinity;
  const far = (bx * qx + by * qy + bz * qz) / size;
  return far > 0 ? far : Infinity;
}
