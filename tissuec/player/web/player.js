// The page: time, controls, keys and touch.

const ICONS = {
  first: "M3 2h2v12H3zM14 2v12L6 8z",
  back: "M12 2v12L3 8z",
  play: "M4 1.5v13L15 8z",
  pause: "M3 2h4v12H3zM9 2h4v12H9z",
  forth: "M4 2v12l9-6z",
  last: "M11 2h2v12h-2zM2 2v12l8-6z",
  loop: "M8 2a6 6 0 0 1 5.2 3L15 4v5h-5l1.6-1.6A3.9 3.9 0 0 0 4.4 6.2L2.7 5.1A6 6 0 0 1 8 2zM1 7h5L4.400 8.600a3.900 3.900 0 0 0 7.200 1.200l1.700 1.100A6 6 0 0 1 2.800 11L1 12z",
  light: "M8 4.500a3.500 3.500 0 1 0 0 7 3.500 3.500 0 0 0 0-7zM7.300 0h1.400v2.500H7.300zM7.300 13.500h1.400V16H7.300zM0 7.300h2.500v1.400H0zM13.500 7.300H16v1.400h-2.500zM2 3l1-1 1.800 1.800-1 1zM11.200 12.200l1-1L14 13l-1 1zM2 13l1.800-1.800 1 1L3 14zM11.200 3.800L13 2l1 1-1.800 1.800z",
  dark: "M6 1a7 7 0 1 0 9 9A6 6 0 0 1 6 1z",
  auto: "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 1.600v10.800A5.400 5.400 0 0 1 8 2.600z",
};
const KEYS = [
  ["space", "play or pause"], ["← →", "one frame back or on; with Alt ten"], ["Home, End", "to the start, to the end"],
  ["n, p", "to the next or previous event"], ["↑ ↓", "faster, slower"], ["l", "again and again, or once"],
  ["+ −", "closer, further away"], ["Shift + arrows", "turn"], ["1 2 3", "look along x, y, z"], ["r", "first view"],
  ["c", "other colours of the springs"], ["s, u, i, f", "springs, surface, instruments, forces"], ["t", "light or dark"],
  ["drag, scroll", "turn, come closer; with Shift or the right button, move"], ["two fingers", "come closer, move"],
];
const THEMES = ["auto", "light", "dark"];
const LOOKS = [[180, 0], [-90, 0], [-90, 90]];  // azimuth and elevation along x, y, z
const FADE = 4;  // frames in which a spring that broke fades out
const SPOKEN = 1.8;  // seconds for which an event is told

const byId = (id) => document.getElementById(id);
const icon = (name) => `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`;

class Player {
  constructor(film, arrays) {
    Object.assign(this, { film, arrays });
    const { times } = film;
    this.range = [times[0], times[times.length - 1]];
    this.duration = this.range[1] - this.range[0];
    this.clock = this.makeClock();
    this.camera = new Camera(film.view);
    this.stage = new Stage(byId("view"), film, arrays);
    this.calm = window.matchMedia("(prefers-reduced-motion: reduce)");
    this.nights = window.matchMedia("(prefers-color-scheme: dark)");
    const hasSkin = film.surfaces.length > 0 || arrays.triangles.width > 0;
    this.shown = {
      springs: !film.surfaces.length, surface: hasSkin ? "solid" : "none", tools: true, forces: false,
      colour: film.colour, fading: FADE, reach: 1,
    };
    this.isPlaying = false;
    this.loops = true;
    this.speed = film.pace;
    this.drawn = 0;
    this.part = 1;  // of the springs that are drawn while it plays
    this.charts = film.curves.map((curve, k) => new Chart(byId("curves"), curve, arrays[`curve ${k}`], this));
    this.prepareControls(hasSkin);
    this.listen();
    this.theme("auto");
    this.time = Math.max(this.range[0], Math.min(this.range[1], film.start));
    this.resize();
  }

  // Return how times are written: in one unit, with the digits that tell frames apart.
  makeClock() {
    const { times } = this.film, most = Math.max(...this.range.map(Math.abs));
    const [divisor, unit] = scaled(most, "s");
    const steps = times.slice(1).map((time, i) => time - times[i]).filter((step) => step > 0);
    const least = steps.length ? Math.min(...steps) / divisor : 1;
    const places = Math.max(0, Math.min(6, Math.ceil(-Math.log10(least) - 1e-9)));
    const clock = (time) => `${(time / divisor).toFixed(places).replace("-", "−")} ${unit}`;
    return Object.assign(clock, { divisor, unit, places });
  }

  // Return the time as a number of frames.
  get moment() {
    const [frame, , part] = between(this.film.times, this.time);
    return frame + part;
  }

  seek(time) {
    this.time = Math.max(this.range[0], Math.min(this.range[1], time));
    this.tell(false);
    this.refresh();
  }

  step(frames) {
    const { times } = this.film, now = this.moment;
    const frame = frames > 0 ? Math.floor(now + 1e-9) + frames : Math.ceil(now - 1e-9) + frames;
    this.pause();
    this.seek(times[Math.max(0, Math.min(times.length - 1, frame))]);
  }

  event(way) {
    const near = 1e-9 * (this.duration || 1);
    const found = this.film.marks.filter((mark) => (mark.time - this.time) * way > near);
    if (found.length) this.seek((way > 0 ? found[0] : found[found.length - 1]).time);
    this.tell(true);
  }

  play() {
    if (this.isPlaying || !(this.duration > 0)) return;
    if (this.time >= this.range[1]) this.time = this.range[0];
    this.isPlaying = true;
    this.last = null;
    this.showPlaying();
    requestAnimationFrame((now) => this.run(now));
  }

  pause() {
    if (this.isPlaying && this.part < 1) requestAnimationFrame(() => this.draw());
    this.isPlaying = false;
    this.showPlaying();
  }

  toggle() { if (this.isPlaying) this.pause(); else this.play(); }

  showPlaying() {
    const button = byId("play");
    button.innerHTML = icon(this.isPlaying ? "pause" : "play");
    button.setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
  }

  run(now) {
    if (!this.isPlaying) return;
    const before = this.time;
    if (this.last !== null) {
      this.time += ((now - this.last) / 1000) * this.speed;
      this.adapt(now - this.last);
    }
    this.last = now;
    if (this.time >= this.range[1]) {
      // Stay at the end for a moment before it begins again.
      if (!this.loops) {
        this.time = this.range[1];
        this.pause();
      } else if (this.time > this.range[1] + 0.5 * this.speed) this.time = this.range[0];
    }
    this.happen(before);
    this.draw();
    requestAnimationFrame((next) => this.run(next));
  }

  // Draw fewer of very many springs while it plays, if pictures take too long.
  adapt(pause) {
    if (this.stage.lines.count <= MANY) return;
    this.part = Math.max(0.02, Math.min(1, this.part * (pause > 60 ? 0.7 : pause < 25 ? 1.1 : 1)));
  }

  // Tell what happens while playing.
  happen(before) {
    const found = this.film.marks.filter((mark) => before < mark.time && mark.time <= this.time);
    if (found.length) this.tell(true, found[found.length - 1]);
  }

  // Say an event in words, for a while; without one, the one at this time.
  tell(isSeen, mark) {
    const caption = byId("caption"), near = 1e-9 * (this.duration || 1);
    const found = mark || this.film.marks.filter((one) => Math.abs(one.time - this.time) <= near).pop();
    clearTimeout(this.silence);
    caption.classList.toggle("seen", Boolean(isSeen && found));
    if (!found || !isSeen) return;
    caption.textContent = `${this.clock(found.time)}: ${found.text}`;
    this.silence = setTimeout(() => caption.classList.remove("seen"), 1000 * SPOKEN);
  }

  // Draw once before the next picture of the screen, however much has changed.
  refresh() {
    if (this.isPlaying || this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.draw();
    });
  }

  get fading() { return this.calm.matches ? 0 : this.shown.fading; }

  draw() {
    const time = Math.min(this.time, this.range[1]), { shown } = this;
    const [frame, , part] = between(this.film.times, time);
    this.stage.draw(frame + part, this.camera, {
      ...shown, fading: this.fading, reach: this.arrowReach, part: this.isPlaying ? this.part : 1,
    }, this.look);
    this.drawn += 1;
    const slider = byId("time"), clock = this.clock;
    slider.value = this.duration > 0 ? (1000 * (time - this.range[0])) / this.duration : 0;
    const text = clock(time);
    if (this.saidTime !== text) {
      this.saidTime = text;
      slider.setAttribute("aria-valuetext", text);
      byId("clock").innerHTML = `<b>${text}</b> <span>of ${clock(this.range[1])}</span>`;
    }
    for (const chart of this.charts) chart.show(time);
    this.drawRuler();
    this.drawTriad();
  }

  // A length in round numbers, as large as it is at the target.
  drawRuler() {
    const height = this.stage.canvas.clientHeight;
    const metre = height / (2 * this.camera.half * this.camera.distance);
    const length = round125(120 / metre), [divisor, unit] = scaled(length, "m");
    const ruler = byId("ruler");
    ruler.firstElementChild.style.width = `${length * metre}px`;
    ruler.lastElementChild.textContent = `${digits(length / divisor)} ${unit}`;
  }

  drawTriad() {
    const [right, up, eye] = this.camera.axes;
    const parts = ["x", "y", "z"].map((name, k) => ({ name, x: 20 * right[k], y: -20 * up[k], near: eye[k] }));
    parts.sort((a, b) => a.near - b.near);
    byId("triad").innerHTML = parts.map(({ name, x, y, near }) => `<g opacity="${0.65 + 0.35 * (near + 1) / 2}"><line x2="${x.toFixed(1)}" y2="${y.toFixed(1)}"/>
      <text x="${(1.4 * x).toFixed(1)}" y="${(1.4 * y).toFixed(1)}">${name}</text></g>`).join("");
  }

  get look() {
    const theme = document.documentElement.dataset.theme;
    return theme === "auto" ? (this.nights.matches ? "dark" : "light") : theme;
  }

  theme(name) {
    document.documentElement.dataset.theme = name;
    const button = byId("theme"), word = { auto: "as the system has them", light: "light", dark: "dark" }[name];
    button.innerHTML = icon(name);
    button.setAttribute("aria-label", `Colours: ${word}`);
    this.redraw();
  }

  nextTheme() { this.theme(THEMES[(THEMES.indexOf(document.documentElement.dataset.theme) + 1) % 3]); }

  resize() {
    this.camera.reshape(this.stage.resize());
    this.marks = placeMarks(byId("marks"), this.film.marks, this.range, this.clock, (time) => {
      this.seek(time);
      this.tell(true);
    });
    this.redraw();
  }

  // Draw the curves too, which depend on sizes and colours only.
  redraw() {
    const resolved = (name) => {
      const probe = byId("made");
      probe.style.color = `var(${name})`;
      const colour = getComputedStyle(probe).color;
      probe.style.color = "";
      return colour;
    };
    const colours = { muted: resolved("--muted"), grid: resolved("--grid") };
    for (const chart of this.charts) chart.draw(colours);
    this.showScale();
    this.refresh();
  }

  prepareControls(hasSkin) {
    const { film, shown } = this;
    for (const name of ["first", "back", "forth", "last", "loop"]) byId(name).innerHTML = icon(name);
    this.showPlaying();
    byId("help").addEventListener("click", () => byId("keys").showModal());
    byId("keys").querySelector("dl").innerHTML = KEYS.map(([key, what]) => `<dt>${key}</dt><dd>${what}</dd>`).join("");
    const speeds = [-3, -2, -1, 0, 1, 2, 3].map((k) => this.paced(k));
    byId("speed").innerHTML = speeds.map((speed) => `<option value="${speed}">${digits(speed)}×</option>`).join("");
    this.speeds = speeds;
    this.setSpeed(film.pace);
    byId("surfaces").hidden = !hasSkin;
    const held = this.arrays.held.width + this.stage.tubes.radius.length;
    byId("instruments").hidden = !film.solids.length && !held;
    byId("vectors").hidden = !film.most.force;
    byId("legend").hidden = !this.stage.lines.count;
    byId("springs").closest("label").hidden = !this.stage.lines.count;
    byId("colour").value = shown.colour;
    if (film.laws.length < 2) byId("colour").querySelector('[value="law"]').hidden = true;
    byId("made").textContent = [film.made, film.thinned, this.exactness()].filter(Boolean).join("; ");
    if (window.innerWidth < 600) byId("show").open = false;
    this.showSwitches();
  }

  // The speeds 1, 2, 5, 10, … times that of the film, counted from it.
  paced(k) {
    const factor = [1, 2, 5][((k % 3) + 3) % 3] * 10 ** Math.floor(k / 3);
    return Number((this.film.pace * factor).toPrecision(3));
  }

  setSpeed(speed) {
    this.speed = speed;
    byId("speed").value = String(speed);
  }

  // Say in which steps the numbers of this page are rounded.
  exactness() {
    const { film } = this, [length, metres] = scaled(film.step, "m"), force = film.most.tension / film.steps.tension;
    const [newton, newtons] = scaled(force, "N");
    const tension = force ? `, tensions of ${digits(force / newton, 2)} ${newtons}` : "";
    return `drawn in steps of ${digits(film.step / length, 2)} ${metres}${tension}, straight between frames`;
  }

  showSwitches() {
    const { shown } = this;
    for (const name of ["springs", "tools", "forces"]) byId(name).checked = shown[name];
    byId("surface").value = shown.surface;
    byId("colour").value = shown.colour;
    byId("reaching").hidden = !shown.forces;
    byId("loop").setAttribute("aria-pressed", String(this.loops));
    this.showArrow();
  }

  // The largest force has an arrow of an eighth of the scene, as the slider stands at first.
  get arrowReach() {
    const { film } = this;
    return film.most.force ? (this.shown.reach * film.view.size) / 8 / film.most.force : 0;
  }

  showArrow() {
    if (!this.shown.forces || !this.arrowReach) return;
    const metre = this.stage.canvas.clientHeight / (2 * this.camera.half * this.camera.distance);
    const force = round125(100 / (metre * this.arrowReach)), [divisor, unit] = scaled(force, "N");
    const [line, said] = byId("arrow").children;
    line.style.width = `${force * metre * this.arrowReach}px`;
    said.textContent = `${digits(force / divisor)} ${unit}`;
  }

  showScale() {
    const { film, shown } = this, box = byId("scale"), { looks } = film;
    if (shown.colour === "law") {
      const items = film.laws.map((law, k) => {
        const item = document.createElement("li"), dash = k >= looks.series.length ? "4 3" : "";
        item.innerHTML = `<svg class="line" width="20" height="8" aria-hidden="true"><line x2="20" y1="4" y2="4" stroke="${css(seenIn(this.look, looks.series[k % looks.series.length], looks))}"
          stroke-width="3" stroke-dasharray="${dash}"/></svg>`;
        item.append(law);
        return item;
      });
      const list = document.createElement("ul");
      list.append(...items);
      box.replaceChildren(list);
      return;
    }
    const isTension = shown.colour === "tension", most = isTension ? film.most.tension : film.most.strain;
    const [divisor, unit] = isTension ? scaled(most, "N") : [0.01, "%"];
    const end = most / divisor || 1, marks = ticks(-end, end, 5);
    const labels = marks.map((tick) => `<span style="left:${(50 + (50 * tick) / end).toFixed(2)}%">${digits(tick)}</span>`);
    const shades = looks.tension.map((text) => css(seenIn(this.look, text, looks)));
    box.innerHTML = `<div class="ramp" style="background:linear-gradient(90deg,${shades.join(",")})"><i style="width:44%"></i></div>
      <div class="ticks">${labels.join("")}</div>
      <div class="words"><span>${isTension ? "pressed" : "shorter"}</span><span>${unit}</span><span>${isTension ? "drawn" : "longer"}</span></div>`;
  }

  set(name, value) {
    this.shown[name] = value;
    this.showSwitches();
    if (name === "colour") this.showScale();
    this.refresh();
  }

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
    for (const name of ["springs", "tools", "forces"]) on(name, "change", (event) => this.set(name, event.target.checked));
    for (const name of ["surface", "colour"]) on(name, "change", (event) => this.set(name, event.target.value));
    on("reach", "input", (event) => this.set("reach", 10 ** Number(event.target.value)));
    window.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.resize()).observe(byId("stage"));
    this.nights.addEventListener("change", () => this.redraw());
    const { canvas } = this.stage;
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.stage.prepare(); this.refresh(); });
    this.listenPointers(canvas);
  }

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
  }

  turned() {
    this.showArrow();
    this.refresh();
  }

  home() {
    this.camera.turnTo(...this.camera.home);
    this.turned();
  }

  key(event) {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || byId("keys").open) return;
    const isTyping = target.matches?.("select") || (target.matches?.("input") && target.id !== "time");
    const isButton = target.matches?.("button, summary, input[type=checkbox]");
    if ((isTyping && !target.matches("[type=checkbox]")) || (isButton && [" ", "Enter"].includes(event.key))) return;
    const act = this.action(event);
    if (!act) return;
    event.preventDefault();
    act();
  }

  action(event) {
    const { camera } = this, turn = (across, up) => () => { camera.orbit(across, up); this.turned(); };
    const closer = (factor) => () => { camera.zoom(factor); this.turned(); };
    const flip = (name) => () => this.set(name, !this.shown[name]);
    const next = (name, list) => () => this.set(name, list[(list.indexOf(this.shown[name]) + 1) % list.length]);
    const faster = (by) => () => {
      const place = Math.max(0, Math.min(this.speeds.length - 1, this.speeds.indexOf(this.speed) + by));
      this.setSpeed(this.speeds[place]);
    };
    const frames = event.altKey ? 10 : 1;
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
      s: flip("springs"),
      i: flip("tools"),
      f: flip("forces"),
      u: next("surface", ["solid", "glass", "none"]),
      c: next("colour", this.film.laws.length < 2 ? ["tension", "strain"] : ["tension", "strain", "law"]),
      "?": () => byId("keys").showModal(),
    }[event.key];
  }

  // What the page shows, for tests and for pages around this one.
  state() {
    const { camera, shown } = this, moment = this.moment;
    return {
      time: this.time, frame: Math.round(moment), frames: this.film.times.length, moment,
      playing: this.isPlaying, speed: this.speed, loops: this.loops, pictures: this.drawn,
      ...this.stage.count(moment, this.fading), shown: { ...shown }, look: this.look,
      camera: {
        azimuth: camera.azimuth, elevation: camera.elevation, distance: camera.distance,
        target: [...camera.target], aspect: camera.aspect,
      },
    };
  }
}

function refuse(text) {
  const notice = byId("notice");
  notice.textContent = text;
  notice.hidden = false;
}

async function begin() {
  if (!document.createElement("canvas").getContext("webgl2")) {
    refuse("This browser has no WebGL 2, by which the net is drawn. A newer one has it, or one with graphics acceleration switched on.");
    return null;
  }
  if (!("DecompressionStream" in window)) {
    refuse("This browser is too old to unpack what it is to show. Any of 2023 or later can.");
    return null;
  }
  const film = JSON.parse(byId("film").textContent);
  const arrays = await unpack(byId("arrays").textContent, film.arrays);
  byId("arrays").remove();
  const player = new Player(film, arrays);
  return player;
}

const ready = begin().catch((error) => {
  refuse(`The net cannot be shown: ${error.message}`);
  throw error;
});
window.tissuec = {
  ready: ready.then((player) => player !== null),
  state: () => ready.then((player) => player && player.state()),
  seek: (time) => ready.then((player) => player && player.seek(time)),
  // Draw now, instead of before the next picture of the screen, and wait until that is done.
  draw: () => ready.then((player) => { player.draw(); player.stage.gl.finish(); }),
  set: (name, value) => ready.then((player) => player.set(name, value)),
  look: (azimuth, elevation) => ready.then((player) => { player.camera.turnTo(azimuth, elevation); player.turned(); }),
  seen: (point) => ready.then((player) => player.camera.seen(point)),
};
