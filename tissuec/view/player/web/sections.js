// Where a plane cuts filled bodies; the same as tissuec/view/section/cross_section.py.

// Corners of the polygon by how many corners of a tetrahedron are in front of the plane: pairs of
// these, the ones in front first.
const SIDES = [null, [[0, 1], [0, 2], [0, 3]], [[0, 2], [0, 3], [1, 3], [1, 2]], [[0, 3], [1, 3], [2, 3]]];

// Return the polygons: for each corner two nodes, lower one first, and how far between them.
function cutPolygons(place, cells, isThere, normal, offset) {
  const height = new Float64Array(place.length / 3), ends = [], part = [], first = [0];
  for (let i = 0; i < height.length; i += 1) {
    height[i] = normal[0] * place[3 * i] + normal[1] * place[3 * i + 1] + normal[2] * place[3 * i + 2] - offset;
  }
  const order = [0, 0, 0, 0];
  for (let t = 0; t < cells.length; t += 4) {
    let count = 0, behind = 4;
    for (let k = 3; k >= 0; k -= 1) if (height[cells[t + k]] < 0) order[behind -= 1] = cells[t + k];
    if (behind === 0 || behind === 4 || !isThere(t / 4)) continue;
    for (let k = 0; k < 4; k += 1) if (height[cells[t + k]] >= 0) order[count++] = cells[t + k];
    for (const [i, j] of SIDES[count]) {
      const a = Math.min(order[i], order[j]), b = Math.max(order[i], order[j]);
      ends.push(a, b);
      part.push(height[a] / (height[a] - height[b]));
    }
    first.push(part.length);
  }
  return { ends, part, first };
}

// Return the points of corners, three numbers each.
function cornerPoints(place, { ends, part }) {
  const found = new Float32Array(3 * part.length);
  for (let i = 0; i < found.length; i += 1) {
    const corner = Math.floor(i / 3), a = place[3 * ends[2 * corner] + (i % 3)], b = place[3 * ends[2 * corner + 1] + (i % 3)];
    found[i] = a + part[corner] * (b - a);
  }
  return found;
}

// Return the triangles of polygons, and the area of all.
function polygonTriangles(points, { first }) {
  const triangles = [];
  let area = 0;
  for (let p = 0; p + 1 < first.length; p += 1) {
    for (let k = first[p] + 2; k < first[p + 1]; k += 1) {
      const three = [first[p], k - 1, k], [a, b, c] = three.map((i) => points.subarray(3 * i, 3 * i + 3));
      triangles.push(...three);
      area += Math.hypot(...cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]])) / 2;
    }
  }
  return { triangles, area };
}

// Return the outlines of bodies, as pairs of corners.
function outlines({ ends, first }) {
  const sides = new Map();
  for (let p = 0; p + 1 < first.length; p += 1) {
    const count = first[p + 1] - first[p];
    for (let k = 0; k < count; k += 1) {
      const i = first[p] + k, j = first[p] + ((k + 1) % count);
      // The edges at both ends of a side have three nodes: those of a face.
      const face = [...new Set([ends[2 * i], ends[2 * i + 1], ends[2 * j], ends[2 * j + 1]])].sort((a, b) => a - b).join();
      sides.set(face, sides.has(face) ? null : [i, j]);
    }
  }
  return [...sides.values()].filter(Boolean).flat();
}

// Return points of the lines on which a tissue has half a share, in pairs.
function contours(points, { ends, part }, triangles, tissue, count) {
  const found = [], share = new Float32Array(part.length);
  for (let number = 1; number < count; number += 1) {
    for (let i = 0; i < share.length; i += 1) {
      const a = tissue[ends[2 * i]] === number ? 1 : 0, b = tissue[ends[2 * i + 1]] === number ? 1 : 0;
      share[i] = a + part[i] * (b - a) - 0.5;
    }
    for (let t = 0; t < triangles.length; t += 3) {
      for (let k = 0; k < 3; k += 1) {
        const i = triangles[t + k], j = triangles[t + ((k + 1) % 3)];
        if (share[i] > 0 === share[j] > 0) continue;
        const w = share[i] / (share[i] - share[j]);
        for (let c = 0; c < 3; c += 1) found.push(points[3 * i + c] + w * (points[3 * j + c] - points[3 * i + c]));
      }
    }
  }
  return found;
}

// The plane of the section of a player, and what it cuts.
class Section {
  constructor(film, arrays) {
    Object.assign(this, { film, arrays, isOn: false, normal: [0, 0, 1], offset: 0, name: "z" });
    const { data, low, width } = arrays.cells;
    this.cells = Int32Array.from(data, (value) => low + value);
    this.count = width ? this.cells.length / 4 : 0;
    this.life = lives(arrays["life of cells"]);
    this.tissue = Int32Array.from(row(arrays.tissue, 0));
  }

  // Return the ends of all frames along the normal.
  get extent() {
    const { film, arrays, normal } = this;
    let low = Infinity, high = -Infinity;
    for (let frame = 0; frame < film.times.length; frame += 1) {
      const place = vectors(arrays.position, frame, film.step, film.origin);
      for (let i = 0; i < 3 * film.nodes; i += 3) {
        const at = normal[0] * place[i] + normal[1] * place[i + 1] + normal[2] * place[i + 2];
        low = Math.min(low, at);
        high = Math.max(high, at);
      }
    }
    return [low, high];
  }

  // What it shows, for tests and for pages around this one.
  state() {
    const { isOn, normal, offset, name, area, polygons } = this;
    return { isOn, normal, offset, name, area, polygons };
  }

  // Return the plane with its front, where nothing is drawn, to the eye.
  towards(eye) {
    const { normal, offset } = this;
    if (dot(normal, eye) >= offset) return { normal, offset };
    return { normal: normal.map((value) => -value), offset: -offset };
  }

  // Cut what is there at a moment, with the points of nodes.
  cut(place, moment) {
    const { normal, offset, cells, life, tissue, film } = this;
    const found = cutPolygons(place, cells, (t) => life[2 * t] <= moment && moment < life[2 * t + 1], normal, offset);
    const points = cornerPoints(place, found), { triangles, area } = polygonTriangles(points, found);
    const lines = outlines(found).flatMap((i) => [...points.subarray(3 * i, 3 * i + 3)]);
    lines.push(...contours(points, found, triangles, tissue, film.tissues.length));
    Object.assign(this, { area, polygons: found.first.length - 1 });
    return { ...found, points, triangles, lines };
  }
}
