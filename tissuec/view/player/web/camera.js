// Who looks from where: the same as in tissuec/view/player/camera.py.

const radians = (degrees) => (degrees * Math.PI) / 180;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

class Camera {
  constructor(view) {
    Object.assign(this, { points: view.points, middle: view.middle, size: view.size });
    this.tangent = Math.tan(radians(view.angle / 2));
    this.margin = view.margin;
    this.home = [view.azimuth, view.elevation];
    this.aspect = 1;
    this.isTouched = false;
    this.shift = [0, 0, 0];
    this.turnTo(...this.home);
  }

  // Half of the height that is seen, at a distance of one.
  get half() { return this.tangent / Math.max(1, this.aspect); }

  // Return the directions to the right, upwards and to the eye.
  get axes() {
    const a = radians(this.azimuth), e = radians(this.elevation);
    const eye = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const right = [-Math.sin(a), Math.cos(a), 0];
    return [right, cross(eye, right), eye];
  }

  // Return where the eye is.
  get eye() { return this.target.map((value, k) => value + this.shift[k] + this.distance * this.axes[2][k]); }

  turnTo(azimuth, elevation) {
    [this.azimuth, this.elevation] = [azimuth, elevation];
    this.fit();
  }

  // Take the place from which everything that ever moves is just seen.
  fit() {
    const axes = this.axes;
    const seen = this.points.map((point) => axes.map((axis) => dot(point, axis)));
    const low = [0, 1, 2].map((k) => Math.min(...seen.map((p) => p[k])));
    const high = [0, 1, 2].map((k) => Math.max(...seen.map((p) => p[k])));
    const middle = low.map((value, k) => (value + high[k]) / 2);
    const half = [this.half * this.aspect * this.margin, this.half * this.margin];
    const largest = Math.max(...this.points.flat().map(Math.abs));
    const least = low.every((value, k) => value === high[k]) ? 1 : 1e-6 * largest;
    for (let round = 0; round < 6; round += 1) {
      let distance = least;
      for (const p of seen) {
        for (const k of [0, 1]) {
          distance = Math.max(distance, Math.abs(p[k] - middle[k]) / half[k] + p[2] - middle[2]);
        }
      }
      this.distance = distance;
      const shift = [0, 0];
      for (const k of [0, 1]) {
        const places = seen.map((p) => (p[k] - middle[k]) / (distance - (p[2] - middle[2])));
        shift[k] = ((Math.min(...places) + Math.max(...places)) / 2) * distance;
      }
      middle[0] += shift[0];
      middle[1] += shift[1];
    }
    this.target = [0, 1, 2].map((k) => axes.reduce((sum, axis, i) => sum + middle[i] * axis[k], 0));
    this.fitted = this.distance;
    this.isTouched = false;
  }

  // Another shape of the picture: fit again, unless somebody has chosen the view.
  reshape(aspect) {
    if (aspect === this.aspect) return;
    this.aspect = aspect;
    if (!this.isTouched) this.fit();
  }

  // Follow the middle of the nodes, where the run asks for that.
  follow(frame, next, mixing) {
    if (!this.middle.length) return;
    this.shift = this.middle[frame].map((value, k) => value + mixing * (this.middle[next][k] - value));
  }

  orbit(across, up) {
    this.azimuth = ((this.azimuth - across + 540) % 360) - 180;
    this.elevation = Math.max(-89.9, Math.min(89.9, this.elevation + up));
    this.isTouched = true;
  }

  // Move by parts of the picture's height.
  pan(across, up) {
    const [right, above] = this.axes, reach = 2 * this.half * this.distance;
    this.target = this.target.map((value, k) => value - reach * (across * right[k] + up * above[k]));
    this.isTouched = true;
  }

  zoom(factor) {
    this.distance = Math.max(this.fitted / 50, Math.min(this.fitted * 20, this.distance / factor));
    this.isTouched = true;
  }

  // Return the matrices of the graphics library, column after column.
  matrices() {
    const [right, up, eye] = this.axes;
    const target = this.target.map((value, k) => value + this.shift[k]);
    const view = new Float32Array([
      right[0], up[0], eye[0], 0, right[1], up[1], eye[1], 0, right[2], up[2], eye[2], 0,
      -dot(target, right), -dot(target, up), -dot(target, eye) - this.distance, 1,
    ]);
    const near = this.distance / 100, far = this.distance * 4 + 6 * this.size;
    const projection = new Float32Array([
      1 / (this.half * this.aspect), 0, 0, 0, 0, 1 / this.half, 0, 0,
      0, 0, (near + far) / (near - far), -1, 0, 0, (2 * near * far) / (near - far), 0,
    ]);
    return { view, projection };
  }

  // Return whether the eye is outside of the box of everything that ever moves.
  get isOutside() {
    return this.eye.some((value, k) => {
      const place = value - this.shift[k], all = this.points.map((point) => point[k]);
      return place < Math.min(...all) || place > Math.max(...all);
    });
  }

  // Return where a point is seen, from -1 to 1 to the right and upwards.
  seen(point) {
    const target = this.target.map((value, k) => value + this.shift[k]);
    const from = point.map((value, k) => value - target[k]);
    const [across, up, near] = this.axes.map((axis) => dot(from, axis));
    const depth = this.distance - near;
    return [across / (this.half * this.aspect * depth), up / (this.half * depth)];
  }
}
