// Keys, mouse and fingers: parts of the player.

const KEYS = [
  ["space", "play or pause"], ["← →", "one frame back or forward; ten with Alt"], ["Home, End", "to the start, to the end"],
  ["n, p", "to the next or previous event"], ["↑ ↓", "faster, slower"], ["l", "repeat or play once"],
  ["+ −", "zoom in, out"], ["Shift + arrows", "rotate"], ["1 2 3", "look along x, y, z"], ["r", "reset the view"],
  ["c, o", "change the colours of the springs, of the skin"], ["s, u, i, e, f", "springs, surface, instruments, resultant forces, forces on nodes"], ["x", "section: cut open or closed"], ["t", "light or dark"],
  ["Alt + arrows", "in the view: read off the next node"], ["Enter, Esc", "pin the node that is read off, let it go"],
  ["drag, scroll", "rotate, zoom; with Shift or the right button, pan"], ["two fingers", "zoom, pan"],
];
const LOOKS = [[180, 0], [-90, 0], [-90, 90]];  // azimuth and elevation along x, y, z

const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };  // in the picture, downwards

const hands = {
  listen() {
    const on = (id, kind, act) => byId(id).addEventListener(kind, act);
    on("play", "click", () => this.toggle());
    on("first", "click", () => this.seek(this.range[0]));
    on("last", "click", () => this.seek(this.range[1]));
    on("back", "click", () => this.step(-1));
    on("forth", "click", () => this.step(1));
    on("loop", "click", () => { this.loops = !this.loops; this.showSwitches(); });
    on("theme", "click", () => this.nextTheme());
    on("time", "input", (event) => this.seek(this.range[0] + (event.target.value / 1000) * this.duration));
    on("speed", "change", (event) => this.setSpeed(Number(event.target.value)));
    for (const name of ["springs", "tools", "results", "forces"]) on(name, "change", (event) => this.set(name, event.target.checked));
    for (const name of ["surface", "colour"]) on(name, "change", (event) => this.set(name, event.target.value));
    on("reach", "input", (event) => this.set("reach", 10 ** Number(event.target.value)));
    window.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.resize()).observe(byId("stage"));
    this.nights.addEventListener("change", () => this.redraw());
    const { canvas } = this.stage;
    window.addEventListener("beforeprint", () => this.print());
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.stage.prepare(); this.refresh(); });
    this.listenPointers(canvas);
  },

  listenPointers(canvas) {
    const fingers = new Map();
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return { size: Math.hypot(a.x - b.x, a.y - b.y), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(kind, (event) => fingers.delete(event.pointerId));
    }
    canvas.addEventListener("pointermove", (event) => {
      const finger = fingers.get(event.pointerId);
      if (!finger) return;
      const height = canvas.clientHeight, across = event.clientX - finger.x, down = event.clientY - finger.y;
      const before = fingers.size === 2 ? spread() : null;
      Object.assign(finger, { x: event.clientX, y: event.clientY });
      if (before) {
        const after = spread();
        this.camera.pan((after.x - before.x) / height, (before.y - after.y) / height);
        if (before.size > 0) this.camera.zoom(after.size / before.size);
      } else if (event.buttons & 2 || event.shiftKey) this.camera.pan(across / height, -down / height);
      else this.camera.orbit((across * 240) / height, (down * 240) / height);
      this.turned();
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(-Math.max(-100, Math.min(100, event.deltaY)) / 400));
      this.turned();
    }, { passive: false });
    canvas.addEventListener("dblclick", () => this.home());
  },

  key(event) {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || byId("keys").open) return;
    const isTyping = target.matches?.("select") || (target.matches?.("input") && target.id !== "time");
    // A dialog that was just closed may still have the focus.
    const isButton = target.matches?.("button, summary, input[type=checkbox]") && !target.closest("dialog");
    if ((isTyping && !target.matches("[type=checkbox]")) || (isButton && [" ", "Enter"].includes(event.key))) return;
    const act = this.action(event);
    if (!act) return;
    event.preventDefault();
    act();
  },

  action(event) {
    const { camera } = this, turn = (across, up) => () => { camera.orbit(across, up); this.turned(); };
    const closer = (factor) => () => { camera.zoom(factor); this.turned(); };
    const flip = (name) => () => this.set(name, !this.shown[name]);
    const next = (name, list) => () => this.set(name, list[(list.indexOf(this.shown[name]) + 1) % list.length]);
    const faster = (by) => () => {
      const place = Math.max(0, Math.min(this.speeds.length - 1, this.speeds.indexOf(this.speed) + by));
      this.setSpeed(this.speeds[place]);
    };
    const isInView = event.target === this.stage.canvas, frames = event.altKey ? 10 : 1;
    if (isInView && event.altKey && event.key in WAYS) return () => this.walk(...WAYS[event.key]);
    if (isInView && event.key === "Enter" && this.node !== null) return () => this.pin();
    if (event.key === "Escape" && this.node !== null) return () => this.release();
    if (event.shiftKey && event.key.startsWith("Arrow")) {
      return { ArrowLeft: turn(8, 0), ArrowRight: turn(-8, 0), ArrowUp: turn(0, -8), ArrowDown: turn(0, 8) }[event.key];
    }
    return {
      " ": () => this.toggle(),
      ArrowLeft: () => this.step(-frames),
      ArrowRight: () => this.step(frames),
      ArrowUp: faster(1),
      ArrowDown: faster(-1),
      Home: () => this.seek(this.range[0]),
      End: () => this.seek(this.range[1]),
      "+": closer(1.15),
      "=": closer(1.15),
      "-": closer(1 / 1.15),
      r: () => this.home(),
      1: () => { camera.turnTo(...LOOKS[0]); this.turned(); },
      2: () => { camera.turnTo(...LOOKS[1]); this.turned(); },
      3: () => { camera.turnTo(...LOOKS[2]); this.turned(); },
      n: () => this.event(1),
      p: () => this.event(-1),
      l: () => byId("loop").click(),
      t: () => this.nextTheme(),
      x: () => this.openSection(!this.section.isOn),
      s: flip("springs"),
      i: flip("tools"),
      f: flip("forces"),
      e: flip("results"),
      u: next("surface", ["solid", "glass", "none"]),
      c: next("colour", this.film.laws.length < 2 ? ["tension", "strain"] : ["tension", "strain", "law"]),
      o: next("field", ["tissue", ...this.fields.map(({ name }) => name)]),
      "?": () => byId("keys").showModal(),
    }[event.key];
  },

  // A canvas of WebGL is empty on paper: an image takes its place there.
  print() {
    this.draw();
    byId("paper").src = this.stage.canvas.toDataURL();
  },

  turned() {
    this.showArrow();
    this.refresh();
  },

  home() {
    this.camera.turnTo(...this.camera.home);
    this.turned();
  },
};
