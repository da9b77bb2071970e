// Controls, legend and rulers: parts of the player.

const ICONS = {
  first: "M3 2h2v12H3zM14 2v12L6 8z",
  back: "M12 2v12L3 8z",
  play: "M4 1.5v13L15 8z",
  pause: "M3 2h4v12H3zM9 2h4v12H9z",
  forth: "M4 2v12l9-6z",
  last: "M11 2h2v12h-2zM2 2v12l8-6z",
  loop: "M8 2a6 6 0 0 1 5.2 3L15 4v5h-5l1.6-1.6A3.9 3.9 0 0 0 4.4 6.2L2.7 5.1A6 6 0 0 1 8 2zM1 7h5L4.4 8.6a3.9 3.9 0 0 0 7.2 1.2l1.7 1.1A6 6 0 0 1 2.8 11L1 12z",
  light: "M8 4.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7zM7.3 0h1.4v2.5H7.3zM7.3 13.5h1.4V16H7.3zM0 7.3h2.5v1.4H0zM13.5 7.3H16v1.4h-2.5zM2 3l1-1 1.8 1.8-1 1zM11.2 12.2l1-1L14 13l-1 1zM2 13l1.8-1.8 1 1L3 14zM11.2 3.8L13 2l1 1-1.8 1.8z",
  dark: "M6 1a7 7 0 1 0 9 9A6 6 0 0 1 6 1z",
  auto: "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 1.6v10.8A5.4 5.4 0 0 1 8 2.6z",
};
const THEMES = ["auto", "light", "dark"];

const byId = (id) => document.getElementById(id);
const icon = (name) => `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`;

const panel = {
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
    byId("instruments").hidden = !film.solids.length && !film.instruments.length && !held;
    byId("resultants").hidden = !film.most.pull;
    byId("vectors").hidden = !film.most.force;
    byId("springs").closest("label").hidden = !this.stage.lines.count;
    byId("colour").value = shown.colour;
    if (film.laws.length < 2) byId("colour").querySelector('[value="law"]').hidden = true;
    byId("made").textContent = [film.made, film.thinned, film.noStress && `no stress: ${film.noStress}`, this.exactness()].filter(Boolean).join("; ");
    if (window.innerWidth < 600) byId("show").open = false;
    this.showSwitches();
  },

  // The speeds 1, 2, 5, 10, … times that of the film, counted from it.
  paced(k) {
    const factor = [1, 2, 5][((k % 3) + 3) % 3] * 10 ** Math.floor(k / 3);
    return Number((this.film.pace * factor).toPrecision(3));
  },

  setSpeed(speed) {
    this.speed = speed;
    byId("speed").value = String(speed);
  },

  // Say in which steps the numbers of this page are rounded.
  exactness() {
    const { film, arrays } = this, [length, metres] = scaled(film.step, film.units.m), force = film.most.tension / film.steps.tension;
    const [newton, newtons] = scaled(force, film.units.N);
    const tension = force ? `, tensions to ${digits(force / newton, 2)} ${newtons}` : "";
    return `positions rounded to ${digits(film.step / length, 2)} ${metres}${tension}`
      + (arrays.curved.data.some((one) => one + arrays.curved.low > 0) ? ", cubic between frames" : ", linear between frames");
  },

  showSwitches() {
    const { shown } = this;
    for (const name of ["springs", "tools", "forces", "results"]) byId(name).checked = shown[name];
    byId("surface").value = shown.surface;
    byId("colour").value = shown.colour;
    byId("reaching").hidden = !shown.forces;
    byId("legend").hidden = !this.stage.lines.count || !shown.springs;
    byId("loop").setAttribute("aria-pressed", String(this.loops));
    this.showArrow();
  },

  showArrow() {
    if (!this.shown.forces || !this.arrowReach) return;
    const metre = this.stage.canvas.clientHeight / (2 * this.camera.half * this.camera.distance);
    const force = round125(100 / (metre * this.arrowReach)), [divisor, unit] = scaled(force, this.film.units.N);
    const [line, said] = byId("arrow").children;
    line.style.width = `${force * metre * this.arrowReach}px`;
    said.textContent = `${digits(force / divisor)} ${unit}`;
  },

  showScale() {
    const { film, shown } = this, box = byId("scale"), { looks } = film;
    if (shown.colour === "law") {
      const items = film.laws.map((law, k) => {
        const item = document.createElement("li"), dash = k >= looks.series.length ? "4 3" : "";
        const colour = css(seenIn(this.look, looks.series[k % looks.series.length], looks));
        item.innerHTML = `<svg class="line" width="20" height="8" aria-hidden="true">
          <line x2="20" y1="4" y2="4" stroke="${colour}" stroke-width="3" stroke-dasharray="${dash}"/></svg>`;
        item.append(law);
        return item;
      });
      const list = document.createElement("ul");
      list.append(...items);
      box.replaceChildren(list);
      return;
    }
    const isTension = shown.colour === "tension", most = isTension ? film.most.tension : film.most.strain;
    const [divisor, unit] = isTension ? scaled(most, film.units.N) : [0.01, "%"];
    const rows = [[-1, 0, 1].map((part) => `<span>${digits((part * most) / divisor)}</span>`)];
    rows.push((isTension ? ["compression", unit, "tension"] : ["shorter", unit, "longer"]).map((word) => `<span>${word}</span>`));
    const shades = looks.tension.map((text) => css(seenIn(this.look, text, looks)));
    box.innerHTML = `<div class="ramp" style="background:linear-gradient(90deg,${shades.join(",")})"><i></i></div>
      ${rows.map((row) => `<div class="words">${row.join("")}</div>`).join("")}`;
  },

  theme(name) {
    document.documentElement.dataset.theme = name;
    const button = byId("theme"), word = { auto: "system setting", light: "light", dark: "dark" }[name];
    button.innerHTML = icon(name);
    button.setAttribute("aria-label", `Colours: ${word}`);
    this.redraw();
  },

  nextTheme() { this.theme(THEMES[(THEMES.indexOf(document.documentElement.dataset.theme) + 1) % 3]); },

  // A length in round numbers, as large as it is at the target.
  drawRuler() {
    const height = this.stage.canvas.clientHeight;
    const metre = height / (2 * this.camera.half * this.camera.distance);
    const length = round125(120 / metre), [divisor, unit] = scaled(length, this.film.units.m);
    const ruler = byId("ruler");
    ruler.firstElementChild.style.width = `${length * metre}px`;
    ruler.lastElementChild.textContent = `${digits(length / divisor)} ${unit}`;
  },

  drawTriad() {
    const [right, up, eye] = this.camera.axes;
    const parts = ["x", "y", "z"].map((name, k) => ({ name, x: 20 * right[k], y: -20 * up[k], near: eye[k] }));
    parts.sort((a, b) => a.near - b.near);
    const at = (value) => value.toFixed(1);
    byId("triad").innerHTML = parts.map(({ name, x, y, near }) => `<g opacity="${at(0.8 + 0.2 * near)}">
      <line x2="${at(x)}" y2="${at(y)}"/><text x="${at(1.4 * x)}" y="${at(1.4 * y)}">${name}</text></g>`).join("");
  },
};
