// The skin of the net: its triangles, flat or in parts that follow their normals.

class Skin {
  constructor(stage) {
    const { gl, film, arrays } = stage, triangles = table(arrays.triangles, Int32Array), life = lives(arrays["life of skin"]);
    const smooth = arrays.smooth, isSmooth = (i) => smooth.low + smooth.data[i] > 0;
    // Those that a smooth surface shows as well come last, to be left out together.
    const order = Array.from({ length: life.length / 2 }, (_, i) => i);
    order.sort((a, b) => isSmooth(a) - isSmooth(b));
    const nodes = picked(triangles, 3, order), spans = picked(life, 2, order);
    const held = picked(lives(arrays["life of patches"]), 2, order), hollow = picked(row(arrays.hollow, 0), 1, order);
    const isThere = (t, frame) => spans[2 * t] <= frame && frame < spans[2 * t + 1];
    const isFine = order.length > MANY;  // too many to be rounded
    const lists = isFine ? null : around(nodes, film.nodes), sides = isFine ? null : opposites(nodes);
    const place = (frame) => stage.places.at(frame).place;
    const known = (field, frame, slot) => field.arrays[field.keys[slot] === frame ? slot : 1 - slot];
    this.facing = new Field(gl, isFine ? 1 : nodes.length, (frame) => (isFine ? new Float32Array(3)
      : cornerNormals(place(frame), nodes, lists, (t) => isThere(t, frame))));
    this.bulge = new Field(gl, isFine ? 1 : nodes.length, (frame, slot) => (isFine ? new Float32Array(3)
      : bulges(place(frame), nodes, known(this.facing, frame, slot), sides, (t) => isThere(t, frame))));
    Object.assign(this, { stage, life, nodes, isFine, shape: { nodes, spans, held, hollow }, forms: new Map() });
    this.count = order.length;
    this.bare = order.filter((i) => !isSmooth(i)).length;
    this.isClosed = !isFine && isClosed(place(0), nodes, sides, spans);
  }

  // Return which nodes have a triangle that looks to the eye.
  front([x, y, z]) {
    const { nodes, stage: { places, film } } = this, place = places.now, faces = faceNormals(place, nodes, () => true), found = new Uint8Array(film.nodes);
    for (let t = 0; t < faces.length; t += 3) {
      const p = 3 * nodes[t];
      if (faces[t] * (x - place[p]) + faces[t + 1] * (y - place[p + 1]) + faces[t + 2] * (z - place[p + 2]) <= 0) continue;
      for (let k = 0; k < 3; k += 1) found[nodes[t + k]] = 1;
    }
    return found;
  }

  // Return how many parts an edge may be divided into, if there are so many faces at most.
  divisions(most) {
    const { film } = this.stage;
    return Math.max(1, Math.min(film.divisions, 2 ** Math.floor(Math.log2(most / (this.count || 1)) / 2)));
  }

  faces(divisions) {
    if (!this.forms.has(divisions)) this.forms.set(divisions, new Faces(this.stage, divisions, this.shape));
    return this.forms.get(divisions);
  }

  // Draw the first triangles, of which edges are divided.
  draw(count, [frame, next], divisions, values, side) {
    this.stage.places.bind();
    this.facing.show(frame, next).bind(UNITS.normal0);
    if (divisions > 1) this.bulge.show(frame, next).bind(UNITS.bulge0);
    this.faces(divisions).draw(count, { ...values, byCorner: this.isFine ? 2 : 1, plain: [0, 0, 0, -1] }, side);
  }
}

// Triangles that are each drawn in parts. The parts of all triangles follow one another, for instances of so
// few corners are slow.
class Faces {
  constructor(stage, divisions, { nodes, spans, held, hollow }) {
    const { gl } = stage, { weights, indices } = partsOfTriangle(divisions), count = nodes.length / 3;
    Object.assign(this, { stage, divisions, array: gl.createVertexArray(), indices: indices.length, points: weights.length / 2 });
    const owner = new Uint32Array(this.points * count).map((_, i) => i / this.points);
    gl.bindVertexArray(this.array);
    if (divisions === 1) stage.attribute(1, nodes, 1, { whole: true });
    else {
      stage.attribute(0, Float32Array.from({ length: weights.length * count }, (_, i) => weights[i % weights.length]), 2);
      stage.attribute(1, picked(nodes, 3, owner), 3, { whole: true });
      const all = Uint32Array.from({ length: indices.length * count }, (_, i) => indices[i % indices.length] + this.points * Math.floor(i / indices.length));
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, all, gl.STATIC_DRAW);
    }
    if (spans) {
      stage.attribute(2, picked(spans, 2, owner), 2);
      stage.attribute(3, picked(held, 2, owner), 2);
      stage.attribute(4, picked(hollow, 1, owner), 1);
    }
    gl.bindVertexArray(null);
  }

  // Draw the first triangles but for those that look to one side, which is null for none.
  draw(count, values, culled) {
    const { stage, divisions, points, indices } = this, { gl } = stage;
    if (culled !== null) {
      gl.enable(gl.CULL_FACE);
      gl.cullFace(culled);
    }
    gl.depthMask(values.opacity === 1);
    gl.bindVertexArray(this.array);
    stage.programs.skin.use({ ...values, points, isRounded: divisions > 1 ? 1 : 0 });
    if (divisions > 1) gl.drawElements(gl.TRIANGLES, indices * count, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.TRIANGLES, 0, 3 * count);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
  }
}
