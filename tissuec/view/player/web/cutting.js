// The section: its controls, and the handle in the view. Parts of the player.

const NORMALS = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

const cutting = {
  prepareSection() {
    const { film } = this, menu = byId("across"), given = film.section;
    this.section = new Section(film, this.arrays);
    const names = { x: "along x", y: "along y", z: "along z", view: "along the view" };
    if (given && !given.axis) names.given = "as given";
    menu.append(...Object.entries(names).map(([value, text]) => new Option(text, value)));
    byId("cut").addEventListener("change", (event) => this.openSection(event.target.checked));
    menu.addEventListener("change", () => this.cutAcross(menu.value));
    byId("place").addEventListener("input", (event) => this.cutAt(Number(event.target.value)));
    byId("uncapped").textContent = film.uncapped;
    byId("uncapped").hidden = !film.uncapped;
    this.listenHandle(byId("handle"));
    if (!given) return;
    this.cutAcross(given.axis || "given");
    this.section.offset = given.offset;
    this.openSection(true);
  },

  // At first across the axis along which one looks.
  openSection(isOn) {
    const { section } = this;
    section.isOn = isOn;
    if (isOn && !section.ends) {
      const sizes = this.camera.axes[2].map(Math.abs);
      this.cutAcross("xyz"[sizes.indexOf(Math.max(...sizes))]);
    }
    this.showSection();
    this.refresh();
  },

  cutAcross(name) {
    const { section, film } = this;
    section.name = name;
    section.normal = NORMALS[name] ?? (name === "given" ? film.section.normal : [...this.camera.axes[2]]);
    section.ends = section.extent;
    this.cutAt((section.ends[0] + section.ends[1]) / 2);
  },

  cutAt(offset) {
    const { section } = this, [low, high] = section.ends;
    section.offset = Math.max(low, Math.min(high, offset));
    this.showSection();
    this.refresh();
  },

  showSection() {
    const { section } = this, slider = byId("place");
    byId("cut").checked = section.isOn;
    byId("cutting").hidden = !section.isOn;
    byId("handle").hidden = !section.isOn;
    if (!section.ends) return;
    const [low, high] = section.ends;
    byId("across").value = section.name;
    Object.assign(slider, { min: low, max: high, step: (high - low) / 1000 || "any", value: section.offset });
    slider.setAttribute("aria-valuetext", this.sectionText());
  },

  sectionText() {
    const { section, film } = this, [low, high] = section.ends, [divisor, unit] = scaled(Math.max(Math.abs(low), Math.abs(high)), film.units.m);
    return `${section.name in NORMALS ? section.name : "distance"} = ${digits(snapped(section.offset, film.step) / divisor)} ${unit}`;
  },

  // Say what is cut in the picture that was drawn, and move the handle there.
  drawSection() {
    const { section, camera } = this;
    if (!section.isOn) return;
    const area = section.count && !this.film.thinned ? `, cut face ${digits(1e6 * section.area)} mm²` : "";
    byId("where").textContent = this.sectionText() + area;
    const [x, y] = camera.seen(this.handlePoint(section.offset)), { style } = byId("handle");
    const inside = (value) => `${50 + 50 * Math.max(-0.94, Math.min(0.94, value))}%`;
    [style.left, style.top] = [inside(x), inside(-y)];
  },

  // Return where the handle is: beside what is cut, in the plane.
  handlePoint(offset) {
    const { normal } = this.section, { points } = this.film.view, { shift } = this.camera;
    const low = [0, 1, 2].map((k) => Math.min(...points.map((p) => p[k]))), high = [0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])));
    const middle = low.map((value, k) => (value + high[k]) / 2 + shift[k]);
    const [right, up] = this.camera.axes.map((axis) => axis.map((value, k) => value - dot(axis, normal) * normal[k]));
    const way = Math.hypot(...up) > 0.3 ? up : right, length = Math.hypot(...way);
    const reach = way.reduce((sum, value, k) => sum + Math.abs(value / length) * (high[k] - low[k]), 0) / 2;
    const away = offset - dot(normal, middle);
    return middle.map((value, k) => value + away * normal[k] + (reach / length) * way[k]);
  },

  listenHandle(handle) {
    let last = null;
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      last = [event.clientX, event.clientY];
    });
    for (const kind of ["pointerup", "pointercancel"]) handle.addEventListener(kind, () => { last = null; });
    handle.addEventListener("pointermove", (event) => {
      if (!last) return;
      const { section, stage: { canvas } } = this, moved = [event.clientX - last[0], event.clientY - last[1]];
      last = [event.clientX, event.clientY];
      // How far it moves on the screen for a thousandth of the way; along the view, upwards.
      const step = (section.ends[1] - section.ends[0]) / 1000;
      const [from, to] = [0, step].map((by) => this.camera.seen(this.handlePoint(section.offset + by)));
      let way = [((to[0] - from[0]) * canvas.clientWidth) / 2, ((from[1] - to[1]) * canvas.clientHeight) / 2];
      const least = canvas.clientHeight / 4000;
      if (Math.hypot(...way) < least) way = [0, -least];
      this.cutAt(section.offset + (step * (moved[0] * way[0] + moved[1] * way[1])) / (way[0] ** 2 + way[1] ** 2));
    });
  },
};
