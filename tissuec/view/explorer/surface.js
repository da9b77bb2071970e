// A quantity over two properties as a small map, the other properties as they are.

const CELLS = 72;
const FLAT = 1e-6; // of the scale; what differs by less is one value, up to rounding
const SLICE = 12; // milliseconds of work before the page may breathe

/** Shares of the scale for each cell, by rows from the top; null where nothing is concluded. */
function* surfaceOf(base, facts, [x, y], quantity) {
  const fixed = placesOf(SYSTEM, base, facts);
  const rules = [...new Set(base.bearings.get(quantity.key).map((bearing) => bearing.rule))];
  const place = (scale, k) => placeOf(scale, fromScale(scale,
    scale.bounds[0] + (scale.bounds[1] - scale.bounds[0]) * ((k + 0.5) / CELLS)));
  const verdicts = [];
  for (let row = 0; row < CELLS; row++) {
    fixed.set(y.key, place(y, CELLS - 1 - row));
    for (let column = 0; column < CELLS; column++) {
      fixed.set(x.key, place(x, column));
      for (const rule of rules) verdicts[rule] = verdictOf(SYSTEM, base, rule, fixed);
      const { value } = answerOf(SYSTEM, base, quantity.key, verdicts);
      yield value === null ? null : shareOf(quantity, toScale(quantity, value));
    }
  }
}

/** A colour between those of a list, as [red, green, blue]. */
function mixed(colours, share) {
  const at = Math.min(Math.max(share, 0), 1) * (colours.length - 1);
  const i = Math.min(Math.floor(at), colours.length - 2);
  const channel = (colour, k) => parseInt(colour.slice(1 + 2 * k, 3 + 2 * k), 16);
  return [0, 1, 2].map((k) => {
    const [first, last] = [channel(colours[i], k), channel(colours[i + 1], k)];
    return Math.round(first + (last - first) * (at - i));
  });
}

function paint(canvas, shares, low, high) {
  canvas.width = canvas.height = CELLS;
  const context = canvas.getContext("2d");
  const image = context.createImageData(CELLS, CELLS);
  shares.forEach((share, i) => {
    if (share === null) return;
    const colour = mixed(DATA.colours.amount, high - low > FLAT ? (share - low) / (high - low) : 0.5);
    image.data.set([...colour, 255], 4 * i);
  });
  context.putImageData(image, 0, 0);
}

/** The section with the map; update() draws it anew when what it depends on has changed. */
class Surface {
  constructor(section, move) {
    this.canvas = section.querySelector("canvas");
    this.map = section.querySelector(".map");
    this.mark = section.querySelector(".mark");
    this.said = section.querySelector(".said");
    this.legend = section.querySelector(".legend");
    this.axes = ["x", "y"].map((axis) => section.querySelector(`.axis.${axis}`));
    this.choices = ["x", "y", "quantity"].map((name) => section.querySelector(`[name=${name}]`));
    this.drawn = "";
    this.run = 0;
    this.choices.forEach((choice) => choice.addEventListener("change", () => this.update(this.state)));
    const drag = (event) => {
      if (event.buttons !== 1 && event.type !== "pointerdown") return;
      const box = this.canvas.getBoundingClientRect();
      const share = (at) => Math.min(Math.max(at, 0), 1);
      move(this.x, share((event.clientX - box.left) / box.width),
        this.y, share(1 - (event.clientY - box.top) / box.height));
    };
    this.map.addEventListener("pointerdown", drag);
    this.map.addEventListener("pointermove", drag);
  }

  /** Offers what the rules ask about; a map needs two properties and a quantity. */
  offer(base) {
    const asked = new Set(base.atoms.flat().map(([, property]) => property));
    const properties = [...SYSTEM.properties.values()].filter(({ key }) => asked.has(key));
    const concluded = [...SYSTEM.quantities.values()]
      .filter(({ key }) => base.bearings.get(key).length);
    this.possible = properties.length > 1 && concluded.length > 0;
    const options = (list) => list.map(({ key, name }) => new Option(name, key));
    const [x, y, quantity] = this.choices;
    x.replaceChildren(...options(properties));
    y.replaceChildren(...options(properties));
    quantity.replaceChildren(...options(concluded));
    if (!this.possible) return;
    const bearing = base.bearings.get(concluded[0].key).flatMap(({ rule }) => base.atoms[rule]);
    const first = [...new Set(bearing.map(([, property]) => property))];
    x.value = first[0];
    y.value = first[1] ?? properties.find(({ key }) => key !== first[0]).key;
  }

  get x() { return SYSTEM.properties.get(this.choices[0].value); }
  get y() { return SYSTEM.properties.get(this.choices[1].value); }
  get quantity() { return SYSTEM.quantities.get(this.choices[2].value); }

  update(state) {
    this.state = state;
    const { base, facts, places } = state;
    const others = [...facts].filter(([key]) => key !== this.x.key && key !== this.y.key);
    const same = this.x === this.y;
    this.canvas.hidden = this.mark.hidden = same;
    if (same) {
      this.said.textContent = "Choose two different properties.";
      return;
    }
    const key = JSON.stringify([base.key, this.choices.map((choice) => choice.value), others]);
    if (key !== this.drawn) {
      this.drawn = key;
      this.compute(base, new Map(others));
    }
    const share = (scale) => (places.has(scale.key) ? shareOf(scale, places.get(scale.key)) : null);
    const [x, y] = [share(this.x), share(this.y)];
    this.mark.hidden = x === null || y === null;
    this.mark.style.left = `${100 * x}%`;
    this.mark.style.top = `${100 * (1 - y)}%`;
    [this.x, this.y].forEach((scale, i) => {
      const ends = this.axes[i].children;
      ends[0].textContent = scale.ends[0];
      ends[1].textContent = scale.name;
      ends[2].textContent = scale.ends[1];
    });
  }

  compute(base, facts) {
    const { x, y, quantity } = this;
    const run = ++this.run;
    const cells = surfaceOf(base, facts, [x, y], quantity);
    const shares = [];
    const go = () => {
      if (run !== this.run) return;
      const until = performance.now() + SLICE;
      while (performance.now() < until) {
        for (let i = 0; i < CELLS; i++) {
          const { done, value } = cells.next();
          if (done) {
            this.finish(shares, quantity);
            return;
          }
          shares.push(value);
        }
      }
      requestAnimationFrame(go);
    };
    requestAnimationFrame(go); // sliders come first
  }

  finish(shares, quantity) {
    const known = shares.filter((share) => share !== null);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    paint(this.canvas, shares, low, high);
    const value = (share) => shown(quantity, fromScale(quantity, quantity.bounds[0]
      + (quantity.bounds[1] - quantity.bounds[0]) * share));
    this.legend.hidden = high - low <= FLAT || !known.length;
    const range = known.length ? [...new Set([value(low), value(high)])] : [];
    this.legend.firstElementChild.textContent = range[0] ?? "";
    this.legend.lastElementChild.textContent = range[1] ?? "";
    const empty = shares.length - known.length;
    const spread = range.length > 1 ? `from ${range.join(" to ")}` : `${range[0]} everywhere`;
    this.said.textContent = [
      known.length ? `${quantity.name} ${spread}` : "no rule fires anywhere here",
      empty && known.length ? "hatched: no rule fires" : "",
    ].filter(Boolean).join("; ");
    this.canvas.setAttribute("aria-label",
      `${this.said.textContent}, over ${this.x.name} and ${this.y.name}`);
  }
}
