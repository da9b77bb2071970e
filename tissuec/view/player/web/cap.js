// Cut faces of filled bodies, by WebGL 2.

const WHOLE = [0, 0, 0, 1];  // a plane in front of which nothing is

// Return the plane in front of which nothing is drawn, as shaders take it.
function cutOff(section, camera, view) {
  if (!section) return { cut: WHOLE };
  const { normal, offset } = section.towards(camera.eye), seen = camera.axes.map((axis) => dot(axis, normal));
  const near = 1e-6 * camera.distance;  // lest rounding tears what lies in the plane
  return { cut: [...seen, offset + near + dot(seen, view.subarray(12, 15))], normal, isOpen: section.count > 0 };
}

class Cap {
  constructor(stage) {
    this.stage = stage;
    [this.faces, this.borders] = [this.made(), this.made()];
  }

  // Return arrays of corners: points, the nodes on both sides, and how far between these.
  made() {
    const { gl } = this.stage, array = gl.createVertexArray(), buffers = [0, 1, 2].map(() => gl.createBuffer());
    gl.bindVertexArray(array);
    [3, 2, 1].forEach((size, place) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[place]);
      gl.enableVertexAttribArray(place);
      if (place === 1) gl.vertexAttribIPointer(place, size, gl.INT, 0, 0);
      else gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    });
    const indices = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    gl.bindVertexArray(null);
    return { array, buffers, indices };
  }

  fill({ array, buffers }, ...lists) {
    const { gl } = this.stage;
    gl.bindVertexArray(array);
    lists.forEach((list, i) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[i]);
      gl.bufferData(gl.ARRAY_BUFFER, list, gl.DYNAMIC_DRAW);
    });
  }

  draw(common, section, ink) {
    const { stage, faces, borders } = this, { gl, film, programs } = stage;
    const { points, ends, part, triangles, lines } = section.cut(stage.places.now, common.moment);
    if (!triangles.length) return;
    const values = { ...common, paler: common.withSprings ? film.rules.paler : 0, cut: WHOLE };
    this.fill(faces, points, Int32Array.from(ends), Float32Array.from(part));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, faces.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(triangles), gl.DYNAMIC_DRAW);
    programs.section.use({ ...values, nearer: 0, plain: [0, 0, 0, 0] });
    gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
    const count = lines.length / 3;
    this.fill(borders, Float32Array.from(lines), new Int32Array(2 * count), new Float32Array(count));
    programs.section.use({ ...values, nearer: film.rules.nearer * film.view.size, plain: [...hexed(ink), 1] });
    gl.drawArrays(gl.LINES, 0, count);
  }
}
