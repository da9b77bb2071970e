// Shapes of one unit that are drawn many times: {local, outward, end, indices}.

// A capsule: two half-spheres, of which `end` says at which point they are.
function capsuleMesh(sides, rings) {
  const local = [], outward = [], end = [], indices = [];
  for (let ring = 0; ring <= rings + 1; ring += 1) {
    const half = ring > rings / 2 ? 1 : 0;
    const angle = ((ring - half) / rings - 0.5) * Math.PI;
    for (let side = 0; side <= sides; side += 1) {
      const turn = (2 * Math.PI * side) / sides;
      const at = [Math.cos(angle) * Math.cos(turn), Math.cos(angle) * Math.sin(turn), Math.sin(angle)];
      local.push(...at);
      outward.push(...at);
      end.push(half);
    }
  }
  strips(indices, rings + 1, sides);
  return { local, outward, end, indices };
}

// A tube that is open at its second point.
function tubeMesh() {
  const local = [], outward = [], end = [], indices = [], sides = 24;
  for (const [at, radius, facing] of [[0, 1, 1], [1, 1, 1], [1, 0.8, -1], [0, 0.8, -1]]) {
    for (let side = 0; side <= sides; side += 1) {
      const turn = (2 * Math.PI * side) / sides, c = Math.cos(turn), s = Math.sin(turn);
      local.push(radius * c, radius * s, 0);
      outward.push(facing * c, facing * s, 0);
      end.push(at);
    }
  }
  strips(indices, 3, sides);
  return { local, outward, end, indices };
}

// An arrow; the third number of `local` says where along it: foot, neck, collar or tip.
function arrowMesh() {
  const local = [], outward = [], indices = [], sides = 10;
  for (const [part, slope] of [[0, 0], [1, 0], [2, 0.4], [3, 0.4]]) {
    for (let side = 0; side <= sides; side += 1) {
      const turn = (2 * Math.PI * side) / sides, c = Math.cos(turn), s = Math.sin(turn);
      local.push(c, s, part);
      outward.push(c, s, slope);
    }
  }
  strips(indices, 3, sides);
  return { local, outward, end: null, indices };
}

// Join rings of points by triangles.
function strips(indices, count, sides) {
  for (let ring = 0; ring < count; ring += 1) {
    for (let side = 0; side < sides; side += 1) {
      const a = ring * (sides + 1) + side, b = a + sides + 1;
      indices.push(a, a + 1, b, a + 1, b + 1, b);
    }
  }
}

// The parts of a triangle whose edges are divided: weights of its second and third corner.
function partsOfTriangle(divisions) {
  const weights = [], indices = [], at = (i, j) => i * (divisions + 1) - (i * (i - 1)) / 2 + j;
  for (let i = 0; i <= divisions; i += 1) {
    for (let j = 0; j <= divisions - i; j += 1) {
      weights.push(i / divisions, j / divisions);
      if (i + j < divisions) indices.push(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j < divisions - 1) indices.push(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return { weights, indices };
}
