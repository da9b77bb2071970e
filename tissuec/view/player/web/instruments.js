// Instruments with shapes of their own, at the points that carry them.

class Instruments {
  constructor(stage) {
    this.stage = stage;
    this.meshes = Object.fromEntries(Object.entries(stage.film.meshes).map(
      ([kind, pivot]) => [kind, this.make(kind, pivot)],
    ));
  }

  make(kind, pivot) {
    const { gl, film, arrays } = this.stage;
    const points = vectors(arrays[`mesh ${kind}`], 0, film.steps.mesh, [0, 0, 0]);
    const triangles = table(arrays[`mesh ${kind} triangles`], Int32Array), parts = row(arrays[`mesh ${kind} parts`], 0);
    const normals = cornerNormals(points, triangles, around(triangles, points.length / 3), () => true);
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const corners = new Float32Array(3 * triangles.length);
    triangles.forEach((node, k) => corners.set(points.subarray(3 * node, 3 * node + 3), 3 * k));
    this.stage.attribute(0, corners, 3);
    this.stage.attribute(1, normals, 3);
    this.stage.attribute(2, Float32Array.from(triangles, (node) => parts[node]), 1);
    gl.bindVertexArray(null);
    return { array, pivot, count: triangles.length };
  }

  draw(common, looks) {
    const { gl, film, programs } = this.stage;
    for (const { kind, points, size, life } of film.instruments) {
      if (common.moment < life[0] || common.moment >= life[1]) continue;
      const { array, pivot, count } = this.meshes[kind];
      gl.bindVertexArray(array);
      programs.instruments.use({ ...common, points, size, pivot, base: hexed(kind === "jet" ? looks.water : looks.steel) });
      gl.drawArrays(gl.TRIANGLES, 0, count);
    }
  }
}

// Return the points of an instrument at a moment, as the shader places them, and its triangles.
function posed(film, arrays, { kind, points, size }, place) {
  const local = vectors(arrays[`mesh ${kind}`], 0, film.steps.mesh, [0, 0, 0]), parts = row(arrays[`mesh ${kind} parts`], 0);
  const at = (i) => [0, 1, 2].map((k) => place[3 * i + k]), origin = at(points[0]);
  const minus = (a, b) => a.map((value, k) => value - b[k]), unit = (a) => a.map((value) => value / Math.hypot(...a));
  const z = unit(minus(at(points[1]), origin)), side = minus(at(points[2]), origin), along = dot(side, z);
  const x = unit(side.map((value, k) => value - along * z[k])), y = cross(z, x);
  const setting = dot(minus(at(points[3]), origin), z) / size, pivot = film.meshes[kind];
  const found = new Float32Array(local.length);
  for (let i = 0; i < parts.length; i += 1) {
    let [px, py, pz] = local.subarray(3 * i, 3 * i + 3);
    if (parts[i] === 3) pz *= setting;
    else if (parts[i] > 0) {
      const turn = parts[i] === 2 ? -setting : setting, c = Math.cos(turn), s = Math.sin(turn), from = pz - pivot;
      [px, pz] = [c * px - s * from, s * px + c * from + pivot];
    }
    for (let k = 0; k < 3; k += 1) found[3 * i + k] = origin[k] + size * (px * x[k] + py * y[k] + pz * z[k]);
  }
  return { points: found, triangles: table(arrays[`mesh ${kind} triangles`], Int32Array) };
}
