// Which way faces look.

const SHARP = Math.cos((50 * Math.PI) / 180);  // between faces, beyond which an edge is seen

// Return the normal of each triangle, as long as twice its area; zero where it is not there.
function faceNormals(position, triangles, isThere) {
  const found = new Float32Array(triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    if (!isThere(t / 3)) continue;
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const ux = position[b] - position[a], uy = position[b + 1] - position[a + 1], uz = position[b + 2] - position[a + 2];
    const vx = position[c] - position[a], vy = position[c + 1] - position[a + 1], vz = position[c + 2] - position[a + 2];
    found[t] = uy * vz - uz * vy;
    found[t + 1] = uz * vx - ux * vz;
    found[t + 2] = ux * vy - uy * vx;
  }
  return found;
}

// Return for each node which triangles are around it, as lists behind one another.
function around(triangles, nodes) {
  const first = new Int32Array(nodes + 1), list = new Int32Array(triangles.length);
  for (const node of triangles) first[node + 1] += 1;
  for (let i = 0; i < nodes; i += 1) first[i + 1] += first[i];
  const next = first.slice();
  triangles.forEach((node, corner) => { list[next[node]++] = (corner - (corner % 3)) / 3; });
  return { first, list };
}

// Return a normal for each corner of each triangle, smooth but across sharp edges.
function cornerNormals(position, triangles, { first, list }, isThere) {
  const faces = faceNormals(position, triangles, isThere), found = new Float32Array(3 * triangles.length);
  const size = new Float32Array(triangles.length / 3);
  for (let t = 0; t < size.length; t += 1) size[t] = Math.hypot(faces[3 * t], faces[3 * t + 1], faces[3 * t + 2]);
  for (let corner = 0; corner < triangles.length; corner += 1) {
    const t = (corner - (corner % 3)) / 3, node = triangles[corner];
    let x = 0, y = 0, z = 0;
    for (let k = first[node]; k < first[node + 1]; k += 1) {
      const other = list[k], i = 3 * other;
      const cosine = faces[i] * faces[3 * t] + faces[i + 1] * faces[3 * t + 1] + faces[i + 2] * faces[3 * t + 2];
      if (cosine < SHARP * size[t] * size[other]) continue;
      x += faces[i];
      y += faces[i + 1];
      z += faces[i + 2];
    }
    const length = Math.hypot(x, y, z) || 1;
    found[3 * corner] = x / length;
    found[3 * corner + 1] = y / length;
    found[3 * corner + 2] = z / length;
  }
  return found;
}

// Return normals of points, as long as the triangles around them are large.
function normals(position, triangles, isThere) {
  const found = new Float32Array(position.length), faces = faceNormals(position, triangles, isThere);
  triangles.forEach((node, corner) => {
    for (let k = 0; k < 3; k += 1) found[3 * node + k] += faces[corner - (corner % 3) + k];
  });
  for (let i = 0; i < found.length; i += 3) {
    const size = Math.hypot(found[i], found[i + 1], found[i + 2]);
    if (size > 0) for (let k = 0; k < 3; k += 1) found[i + k] /= size;
  }
  return found;
}

// Return for the edge behind each corner where the same edge stands in another triangle: -1 for
// a free edge, -2 where more than two triangles meet.
function opposites(triangles) {
  const found = new Int32Array(triangles.length).fill(-1), met = new Map();
  for (let side = 0; side < triangles.length; side += 1) {
    const a = triangles[side], b = triangles[following(side)], key = Math.min(a, b) * 2 ** 24 + Math.max(a, b);
    const other = met.get(key);
    if (other === undefined) met.set(key, side);
    else if (found[other] === -1) [found[other], found[side]] = [side, other];
    else [found[other], found[found[other]], found[side]] = [-2, -2, -2];
  }
  return found;
}

const following = (side) => (side % 3 === 2 ? side - 2 : side + 1);

// Return by how much the edge behind each corner bends towards the normals at its ends, as in bodies.py.
function bulges(position, triangles, normals, sides, isThere) {
  const faces = faceNormals(position, triangles, isThere), found = new Float32Array(3 * triangles.length);
  const face = (side) => 3 * ((side - (side % 3)) / 3);
  for (let side = 0; side < triangles.length; side += 1) {
    if (sides[side] === -2 || !isThere((side - (side % 3)) / 3)) continue;
    const isPair = sides[side] >= 0 && isThere((sides[side] - (sides[side] % 3)) / 3), other = isPair ? sides[side] : side;
    if (isPair) {
      const [a, b] = [face(side), face(other)].map((t) => [0, 1, 2].map((k) => faces[t + k]));
      if (dot(a, b) < SHARP * Math.hypot(...a) * Math.hypot(...b)) continue;
    }
    const [q, r] = [triangles[side], triangles[following(side)]];
    const way = [0, 1, 2].map((k) => position[3 * q + k] - position[3 * r + k]);
    for (const [node, corner, sign] of [[q, side, 1], [r, following(side), -1]]) {
      const beside = triangles[other] === node ? other : following(other);
      const normal = [0, 1, 2].map((k) => normals[3 * corner + k] + normals[3 * beside + k]);
      const size = dot(normal, normal) || 1, along = (sign * dot(way, normal)) / size;
      for (let k = 0; k < 3; k += 1) found[3 * side + k] += along * normal[k];
    }
  }
  return found;
}

// Return whether triangles enclose bodies at all times and look outwards, so that no back is ever seen.
function isClosed(position, triangles, sides, spans) {
  const isSame = (s, t) => spans[2 * s] === spans[2 * t] && spans[2 * s + 1] === spans[2 * t + 1];
  for (let side = 0; side < sides.length; side += 1) {
    const other = sides[side], face = Math.floor(side / 3);
    if (other < 0 || triangles[other] !== triangles[following(side)] || !isSame(face, Math.floor(other / 3))) return false;
  }
  // The volume of each body, whose triangles are found from one to the next.
  const faces = faceNormals(position, triangles, () => true), isMet = new Uint8Array(triangles.length / 3);
  for (let first = 0; first < isMet.length; first += 1) {
    let volume = 0;
    for (const open = isMet[first] ? [] : [first]; open.length;) {
      const t = open.pop(), p = 3 * triangles[3 * t];
      if (isMet[t]) continue;
      isMet[t] = 1;
      for (let k = 0; k < 3; k += 1) {
        volume += faces[3 * t + k] * (position[p + k] - position[3 * triangles[3 * first] + k]);
        open.push(Math.floor(sides[3 * t + k] / 3));
      }
    }
    if (volume < 0) return false;
  }
  return triangles.length > 0;
}
