// The page: what is shown when.

const CHART = 285;  // pixels of width that a curve needs
const SPOKEN = 1.8;  // seconds for which an event is told

class Player {
  constructor(film, arrays) {
    Object.assign(this, { film, arrays });
    const { times } = film;
    // Where arrow keys stop: at frames, and not at the two sides of events.
    this.stops = times.filter((_, k) => !film.sides.includes(k));
    this.range = [times[0], times[times.length - 1]];
    this.duration = this.range[1] - this.range[0];
    this.clock = this.makeClock();
    this.camera = new Camera(film.view);
    // Without WebGL 2, which graphics drivers may lack, pictures are plainer.
    const hasGraphics = Boolean(document.createElement("canvas").getContext("webgl2"));
    this.stage = new (hasGraphics ? Stage : FlatStage)(byId("view"), film, arrays);
    byId("plain").hidden = hasGraphics;
    this.nights = window.matchMedia("(prefers-color-scheme: dark)");
    const hasSkin = film.surfaces.length > 0 || arrays.triangles.width > 0;
    this.shown = {
      springs: film.springs, surface: hasSkin ? "solid" : "none", tools: true, results: true, forces: false,
      colour: film.colour, field: film.field, reach: 1,
    };
    this.isPlaying = false;
    this.loops = true;
    this.speed = film.pace;
    this.drawn = 0;
    this.haste = new Haste();
    this.form = FORMS[0];
    film.curves.forEach((curve, k) => {
      const { data, low } = arrays[`clock ${k}`], { first, step } = curve.clock;
      curve.time = Array.from(data, (value) => first + (low + value) * step);
    });
    this.charts = film.curves.map((curve, k) => new Chart(byId("curves"), curve, arrays[`curve ${k}`], this));
    this.pulls = new Pulls(byId("pulls"), film, arrays);
    if (film.quantities.length > 1) this.pair = new PairChart(byId("curves"), this);
    this.prepareFields();
    this.preparePicks();
    this.prepareControls(hasSkin);
    this.prepareSection();
    this.listen();
    this.theme("auto");
    this.time = Math.max(this.range[0], Math.min(this.range[1], film.start));
    this.resize();
  }

  // Return how times are written: in one unit, with the digits that tell frames apart.
  makeClock() {
    const times = this.stops, [divisor, unit] = this.film.clock;
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
    const [before, , part] = between(this.stops, this.time), now = before + part;
    const frame = frames > 0 ? Math.floor(now + 1e-9) + frames : Math.ceil(now - 1e-9) + frames;
    this.pause();
    this.seek(this.stops[Math.max(0, Math.min(this.stops.length - 1, frame))]);
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
    const isToRest = this.isPlaying && this.form !== FORMS[0];
    this.isPlaying = false;
    this.showPlaying();
    if (isToRest) this.refresh(FORMS[0]);
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
      this.haste.take(now - this.last);
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
    if (!this.isPlaying) return;
    this.draw(this.haste.form);
    requestAnimationFrame((next) => this.run(next));
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

  // Draw once before the next picture of the screen, however much has changed: in full, unless one
  // picture follows another so fast that they are slow to draw.
  refresh(form = null) {
    if (this.isPlaying || this.waits) return;
    this.waits = true;
    requestAnimationFrame((now) => {
      if (!this.waits || this.isPlaying) return;
      const isMoving = now - this.last < STILL;
      this.last = now;
      this.draw(form ?? (isMoving ? this.haste.form : FORMS[0]));
      if (isMoving) requestAnimationFrame((next) => this.haste.take(next - now));
    });
  }

  draw(form = FORMS[0]) {
    this.waits = false;
    clearTimeout(this.rests);
    if (form !== FORMS[0] && !this.isPlaying) this.rests = setTimeout(() => this.refresh(FORMS[0]), STILL);
    this.form = form;
    this.reshape();
    const time = Math.min(this.time, this.range[1]), { shown } = this;
    const [frame, , part] = between(this.film.times, time);
    this.stage.draw(frame + part, this.camera, {
      ...shown, field: this.chosen, section: this.section.isOn ? this.section : null, reach: this.arrowReach,
    }, this.look, form);
    this.showLeftOut();
    this.pulls.draw(frame + part, this.camera, shown.results);
    this.showPicks();
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
    this.pair?.show(time);
    this.drawSection();
    this.drawRuler();
    this.drawTriad();
  }

  // Say how many of the springs are drawn while something moves.
  showLeftOut() {
    const { part } = this.stage.lines, box = byId("fewer");
    box.hidden = !(part < 1);
    if (part < 1) box.textContent = `while moving: ${digits(100 * part, 2)} % of the springs`;
  }

  get look() {
    const theme = document.documentElement.dataset.theme;
    return theme === "auto" ? (this.nights.matches ? "dark" : "light") : theme;
  }

  reshape() {
    const { clientWidth: width, clientHeight: height } = this.stage.canvas;
    if (width && height) this.camera.reshape(width / height);
  }

  resize() {
    this.haste.reset();
    const box = byId("curves");
    box.classList.toggle("many", box.childElementCount * CHART > box.clientWidth);
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
    this.pair?.draw(colours);
    this.showScale();
    this.showField();
    this.reshape();  // after everything that takes height from the picture
    this.refresh();
  }

  // How long arrows of forces on nodes are, as the slider is set.
  get arrowReach() {
    const { film } = this;
    return film.most.force ? (this.shown.reach * film.rules.arrow * film.view.size) / film.most.force : 0;
  }

  set(name, value) {
    this.shown[name] = value;
    this.haste.reset();
    this.showSwitches();
    if (name === "colour") this.showScale();
    if (name === "field") this.showField();
    if (name === "field" && this.pins.length) this.redraw();
    this.refresh();
  }

  // What the page shows, for tests and for pages around this one.
  state() {
    const { camera, shown } = this, moment = this.moment;
    const [stop, , part] = between(this.stops, this.time);
    return {
      time: this.time, frame: Math.round(stop + part), frames: this.stops.length, moment,
      playing: this.isPlaying, speed: this.speed, loops: this.loops, pictures: this.drawn,
      form: FORMS.indexOf(this.form), ...this.stage.count(moment), shown: { ...shown }, look: this.look, section: this.section.state(),
      camera: {
        azimuth: camera.azimuth, elevation: camera.elevation, distance: camera.distance,
        target: [...camera.target], aspect: camera.aspect,
      },
    };
  }
}

// Controls and hands have files of their own.
for (const part of [panel, legend, picks, cutting, hands]) Object.defineProperties(Player.prototype, Object.getOwnPropertyDescriptors(part));

function refuse(text) {
  const notice = byId("notice");
  notice.textContent = text;
  notice.hidden = false;
  document.body.classList.add("refused");
}

async function begin() {
  if (!("DecompressionStream" in window)) {
    refuse("This browser is too old to decompress the data. Use a browser of 2023 or later.");
    return null;
  }
  const film = JSON.parse(byId("film").textContent);
  const arrays = await unpack(byId("arrays").textContent, film.arrays);
  byId("arrays").remove();
  const player = new Player(film, arrays);
  document.body.classList.add("ready");
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
  draw: () => ready.then((player) => { player.draw(); player.stage.finish(); }),
  set: (name, value) => ready.then((player) => player.set(name, value)),
  look: (azimuth, elevation) => ready.then((player) => { player.camera.turnTo(azimuth, elevation); player.turned(); }),
  cut: (name, offset) => ready.then((player) => { player.openSection(true); player.cutAcross(name); player.cutAt(offset); }),
  // Read off a node, by its number among the drawn ones; null for none.
  pick: (node) => ready.then((player) => { player.isHeld = node !== null; player.pick(node); }),
  picked: () => ready.then((player) => player.picked()),
  pin: () => ready.then((player) => player.pin()),
  ticks,
  seen: (point) => ready.then((player) => player.camera.seen(point)),
};
