// Shaders and textures, as WebGL 2 has them.

const ACROSS = 1024;  // texels of a row, as in shared.glsl
const UNITS = { places: 0, normal0: 2, normal1: 3, force0: 4, force1: 5, colours: 6, bulge0: 10, bulge1: 11, tints: 12, value0: 13, value1: 14 };

class Program {
  constructor(gl, shared, source) {
    this.gl = gl;
    const parts = [shared, source].map((text) => text.split("// ---- fragment\n"));
    this.program = gl.createProgram();
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, i) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, parts[0][i] + parts[1][i]);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    });
    gl.linkProgram(this.program);
    this.setters = {};
    for (let i = 0; i < gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS); i += 1) {
      const { name, type } = gl.getActiveUniform(this.program, i);
      this.setters[name] = this.setter(gl.getUniformLocation(this.program, name), type);
    }
  }

  setter(place, type) {
    const { gl } = this;
    switch (type) {
      case gl.FLOAT: return (value) => gl.uniform1f(place, value);
      case gl.FLOAT_VEC2: return (value) => gl.uniform2fv(place, value);
      case gl.FLOAT_VEC3: return (value) => gl.uniform3fv(place, value);
      case gl.INT_VEC2: return (value) => gl.uniform2iv(place, value);
      case gl.INT_VEC4: return (value) => gl.uniform4iv(place, value);
      case gl.FLOAT_VEC4: return (value) => gl.uniform4fv(place, value);
      case gl.FLOAT_MAT4: return (value) => gl.uniformMatrix4fv(place, false, value);
      default: return (value) => gl.uniform1i(place, value);
    }
  }

  use(values) {
    this.gl.useProgram(this.program);
    for (const [name, set] of Object.entries(this.setters)) {
      if (name in values) set(values[name]);
      else if (name in UNITS) set(UNITS[name]);
    }
  }
}

// Vectors or numbers in a texture.
class Texels {
  constructor(gl, count, width = 3) {
    Object.assign(this, { gl, count, width, texture: gl.createTexture() });
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, width === 3 ? gl.RGB32F : gl.R32F, ACROSS, Math.max(1, Math.ceil(count / ACROSS)));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  upload(data) {
    const { gl, count, width } = this, kind = width === 3 ? gl.RGB : gl.RED;
    const whole = Math.floor(count / ACROSS), left = count - whole * ACROSS;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (whole) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ACROSS, whole, kind, gl.FLOAT, data, 0);
    if (left) {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, whole, left, 1, kind, gl.FLOAT, data, width * whole * ACROSS);
    }
  }

  bind(unit) {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
    this.gl.activeTexture(this.gl.TEXTURE0 + 7);  // free for uploads
  }
}

// Vectors or numbers of two neighbouring frames, filled when they are first asked for, in two textures.
class Field {
  constructor(gl, count, fill, width = 3) {
    Object.assign(this, { fill, keys: [null, null], arrays: [null, null] });
    this.textures = [0, 1].map(() => new Texels(gl, count, width));
  }

  show(first, second) {
    if (this.keys[1] === first || this.keys[0] === second) {
      for (const pair of [this.keys, this.arrays, this.textures]) pair.reverse();
    }
    [first, second].forEach((key, slot) => {
      if (this.keys[slot] === key) return;
      this.arrays[slot] = key === this.keys[1 - slot] ? this.arrays[1 - slot] : this.fill(key, slot);
      this.keys[slot] = key;
      this.textures[slot].upload(this.arrays[slot]);
    });
    return this;
  }

  bind(unit) { this.textures.forEach((texture, slot) => texture.bind(unit + slot)); }
}

// Points at a moment in a texture; what is known of the frames around it is kept.
class Points {
  constructor(gl, count, place, speed = null) {
    Object.assign(this, { place, speed, frames: new Map(), now: new Float32Array(3 * count), texture: new Texels(gl, count) });
  }

  // Return places and speeds of a frame.
  at(frame) {
    if (!this.frames.has(frame)) this.frames.set(frame, { place: this.place(frame), speed: this.speed?.(frame) });
    return this.frames.get(frame);
  }

  // Go to a moment between two frames; on a cubic if there is time between them.
  show([first, second, mixing], span = 0) {
    if (this.moment === first + mixing) return this;
    this.moment = first + mixing;
    for (const frame of this.frames.keys()) if (frame !== first && frame !== second) this.frames.delete(frame);
    const ends = [this.at(first), this.at(second)], speeds = span ? ends.map(({ speed }) => speed) : null;
    mixed(this.now, ends.map(({ place }) => place), mixing, speeds, span);
    this.texture.upload(this.now);
    return this;
  }

  bind() { this.texture.bind(UNITS.places); }
}
