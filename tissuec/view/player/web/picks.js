// The node that is read off, and those that are pinned: parts of the player.

const SILENT = 400;  // ms for which a pick rests before it is read aloud

const picks = {
  preparePicks() {
    const { film, arrays } = this;
    this.sight = new Sight(film, arrays);
    this.displaced = this.fields.find(({ name }) => name === "displacement");
    this.node = null;  // that is read off
    this.isHeld = false;  // whether it stays while the pointer moves
    this.pins = [];
    this.metres = scaled(Math.max(...film.view.points.flat().map(Math.abs)), film.units.m);
    byId("pin").addEventListener("click", () => this.pin());
    this.listenPicks(this.stage.canvas);
  },

  listenPicks(canvas) {
    let pressed = null;
    const where = (event) => [event.offsetX, event.offsetY];
    canvas.addEventListener("pointerdown", (event) => { pressed = pressed ? [-1e9, 0] : where(event); });
    canvas.addEventListener("pointerup", (event) => {
      const [x, y] = where(event), isStill = pressed && Math.hypot(x - pressed[0], y - pressed[1]) < 5;
      pressed = null;
      if (!isStill) return;
      const node = this.nodeUnder(x, y);
      this.isHeld = node !== null;
      this.pick(node);
    });
    canvas.addEventListener("pointercancel", () => { pressed = null; });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons || event.pointerType === "touch" || this.isHeld || this.asks) return;
      const [x, y] = where(event);
      this.asks = requestAnimationFrame(() => {
        this.asks = 0;
        if (!this.isHeld) this.pick(this.nodeUnder(x, y));
      });
    });
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType !== "touch" && !this.isHeld && !event.buttons) this.pick(null);
    });
  },

  // Look for nodes as they are drawn now.
  seeing() {
    const { canvas } = this.stage;
    return this.sight.look(this.moment, this.camera, canvas.clientWidth, canvas.clientHeight, this.shown.surface !== "none", this.section);
  },

  nodeUnder(x, y) { return this.seeing().under(x, y); },

  // Read off a node; null for none.
  pick(node) {
    if (this.node === node) return;
    this.node = node;
    this.refresh();
    clearTimeout(this.spoken);
    this.spoken = setTimeout(() => { byId("said").textContent = node === null ? "" : this.sentence(); }, SILENT);
  },

  // Go to the next node in a direction of the picture.
  walk(across, down) {
    const sight = this.seeing();
    this.isHeld = true;
    this.pick(this.node === null ? sight.central() : sight.beside(this.node, across, down));
  },

  release() {
    this.isHeld = false;
    this.pick(null);
  },

  // What is known of a node at this moment; null without one.
  picked(node = this.node) {
    if (node === null) return null;
    const { film, arrays, moment, chosen } = this, body = film.bodies.findLast(({ from }) => from <= node);
    const number = arrays.region.low + arrays.region.data[node], region = number > 0 ? film.regions[number - 1] : null;
    return {
      node, id: arrays.ids.low + arrays.ids.data[node], body: body?.name ?? "", region: region?.name ?? "",
      tissue: (region ?? body)?.tissue ?? "", position: placeOf(film, arrays, node, moment),
      displacement: this.displaced.at(node, moment),
      field: chosen && { name: chosen.name, value: chosen.at(node, moment), isClipped: chosen.isClipped(node, moment) },
      pins: this.pins.map((pin) => pin.node),
    };
  },

  // Return names and numbers of a node, as pairs of texts.
  lines(node) {
    const found = this.picked(node), [divisor, unit] = this.metres, { chosen } = this;
    const place = found.position.map((value) => stepped(value / divisor, this.film.step / divisor));
    const rows = [["position", `(${place.join(", ")}) ${unit}`], ["displacement", this.displaced.text(found.displacement)]];
    if (chosen && chosen !== this.displaced) rows.push([chosen.name, chosen.text(found.field.value, found.field.isClipped ? "≥ " : "")]);
    return rows;
  },

  nameOf({ id, body }) { return body ? `node ${id} of ${body}` : `node ${id}`; },

  sentence() {
    const found = this.picked(), rows = this.lines(this.node).map((row) => row.join(" "));
    const parts = [this.nameOf(found), found.region && `region ${found.region}`, found.tissue && `tissue ${found.tissue}`];
    return [...parts.filter(Boolean), ...rows].join(", ");
  },

  // Write what is read off, and mark nodes in the picture.
  showPicks() {
    const { node } = this, box = byId("value");
    box.hidden = node === null;
    if (node !== null) {
      const found = this.picked(), rows = [];
      if (found.region) rows.push(["region", found.region]);
      if (found.tissue) rows.push(["tissue", found.tissue]);
      rows.push(...this.lines(node));
      byId("whose").textContent = this.nameOf(found);
      const list = byId("numbers"), text = rows.map((row) => row.join("\t")).join("\n");
      if (list.dataset.text !== text) {
        list.dataset.text = text;
        list.replaceChildren(...rows.flatMap((row) => row.map((word, k) => Object.assign(document.createElement(k ? "dd" : "dt"), { textContent: word }))));
      }
      byId("pin").disabled = this.pins.some((pin) => pin.node === node);
    }
    this.markNodes();
  },

  markNodes() {
    const { canvas } = this.stage, marks = this.pins.map(({ node, letter, colour }) => ({ node, letter, colour: colour() }));
    if (this.node !== null) marks.push({ node: this.node, letter: "", colour: "var(--ink)" });
    byId("picks").innerHTML = marks.map(({ node, letter, colour }) => {
      const [x, y] = this.camera.seen(placeOf(this.film, this.arrays, node, this.moment));
      const [u, v] = [((1 + x) * canvas.clientWidth) / 2, ((1 - y) * canvas.clientHeight) / 2].map((value) => value.toFixed(1));
      return `<g transform="translate(${u} ${v})"><circle r="5.5"/><circle r="5.5" style="stroke:${colour}"/><text x="9" y="-6">${letter}</text></g>`;
    }).join("");
  },

  // Keep a node, with a curve of its numbers over time.
  pin(node = this.node) {
    if (node === null || this.pins.some((pin) => pin.node === node)) return;
    const used = this.pins.map(({ letter }) => letter), letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";
    const letter = [...letters].find((one) => !used.includes(one)) ?? "•";
    const pin = { node, letter }, chart = new PinChart(byId("curves"), this, pin, letters.indexOf(letter));
    Object.assign(pin, { chart, colour: () => chart.colour(0) });
    this.pins.push(pin);
    this.charts.push(chart);
    this.resize();
    chart.figure.scrollIntoView({ block: "nearest" });
  },

  unpin(pin) {
    pin.chart.figure.remove();
    this.pins = this.pins.filter((one) => one !== pin);
    this.charts = this.charts.filter((chart) => chart !== pin.chart);
    this.resize();
    this.stage.canvas.focus();
  },
};

// The numbers of a node over time: of the field on the skin, or its displacement.
class PinChart extends Chart {
  constructor(box, player, pin, order) {
    const curve = { name: "", shown: [1, ""], columns: [""], leftOut: 0, time: player.film.times, empty: false };
    super(box, curve, null, player);
    Object.assign(this, { pin, order });
    const button = document.createElement("button"), whose = player.nameOf(player.picked(pin.node));
    Object.assign(button, { type: "button", textContent: "×", title: "Remove" });
    button.setAttribute("aria-label", `Remove ${whose}`);
    button.addEventListener("click", () => player.unpin(pin));
    this.title = this.figure.querySelector("b");
    this.title.after(button);
    this.whose = whose;
    this.take(player.chosen ?? player.displaced);
  }

  // Show the numbers of a field.
  take(field) {
    const { curve, pin } = this;
    this.numbers = curve.time.map((_, frame) => field.number(frame, pin.node)).map((value) => (value < UNKNOWN / 10 ? null : value));
    const known = this.numbers.filter((value) => value !== null);
    [this.divisor, this.unit] = field.shown;
    const name = `${pin.letter}: ${field.name} of ${this.whose}`;
    Object.assign(curve, {
      name, empty: !known.length, low: Math.min(...known), high: Math.max(...known),
    });
    this.title.textContent = this.unit ? `${name} [${this.unit}]` : name;
    this.plot.setAttribute("aria-label", `${name} over time`);
  }

  colour() {
    const { looks } = this.player.film;
    return css(seenIn(this.player.look, looks.series[this.order % looks.series.length], looks));
  }

  value(moment) { return this.numbers[moment]; }
}
