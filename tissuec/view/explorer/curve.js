// The curve of stress over strain that follows from the words, and tissues to compare it with.

const CURVE = { width: 640, height: 240, left: 62, right: 12, top: 10, bottom: 38, points: 60 };
const OF_CURVE = {
  young: "young's modulus", stiffening: "stiffening", breaking: "breaking strain", strength: "strength",
};

/** The tissues whose description has a word of a property; plain words first, and tissues that
 *  have a file to themselves. */
function anchorsOf(property, word) {
  const longest = (text) => property.words.map((one) => keyOf(one.word))
    .filter((one) => text === one || text.endsWith(` ${one}`))
    .sort((a, b) => b.length - a.length)[0];
  const key = keyOf(word.word);
  const isMain = ({ name, file }) => file.split("/").at(-1).replaceAll("_", " ") === name;
  const said = DATA.presets.filter(({ facts }) => facts[property.key]?.sign === "is")
    .sort((a, b) => isMain(b) - isMain(a))
    .map((preset) => [preset.name, keyOf(preset.facts[property.key].text)])
    .filter(([, text]) => longest(text) === key);
  return [...said.filter(([, text]) => text === key), ...said.filter(([, text]) => text !== key)]
    .map(([name]) => name);
}

/** A line such as "soft = liver, fat; hard = fascia". */
function ladder(property) {
  const steps = property.words.map((word) => [word.word, anchorsOf(property, word).slice(0, 2)])
    .filter(([, names]) => names.length);
  return steps.map(([word, names]) => `${word} = ${names.join(", ")}`).join("; ");
}

/** The drawing of the curve, and what it is like. */
class StressCurve {
  constructor(section) {
    this.section = section;
    this.drawing = section.querySelector("svg");
    this.told = section.querySelector(".told");
    this.possible = SYSTEM.quantities.has(OF_CURVE.young);
    section.hidden = !this.possible;
  }

  /** The number of a quantity: the written one, otherwise the conclusion of the rules. */
  number(key) {
    const written = state.numbers.find(({ quantity }) => quantity === key);
    return written ? written.value : found.answers.get(key)?.value ?? null;
  }

  draw() {
    if (!this.possible) return;
    const numbers = Object.fromEntries(
      Object.entries(OF_CURVE).map(([name, key]) => [name, this.number(key)]));
    const isKnown = numbers.young > 0;
    this.drawing.toggleAttribute("hidden", !isKnown);
    if (!isKnown) {
      this.told.textContent = "No curve: the words lead to no Young's modulus.";
      return;
    }
    const torn = tearing(numbers);
    const end = torn ?? USUAL_STRAIN;
    const ticks = { x: ticksTo(100 * end), y: this.heights(stressAt(numbers, end)) };
    const at = this.placing(ticks);
    const strains = Array.from({ length: CURVE.points + 1 }, (_, n) => (end * n) / CURVE.points);
    const path = strains.map((strain) => at(100 * strain, stressAt(numbers, strain) / ticks.y.size).join(","));
    const parts = [...this.grid(ticks, at), makeSvg("path", { class: "stress", d: `M${path.join("L")}` })];
    if (torn !== null) {
      const [x, y] = at(100 * torn, stressAt(numbers, torn) / ticks.y.size);
      parts.push(makeSvg("path", { class: "torn", d: `M${x - 5},${y - 5}l10,10m0,-10l-10,10` }));
    }
    this.drawing.replaceChildren(...parts);
    this.told.textContent = this.tell(numbers, torn);
  }

  /** Ticks of stresses in a unit that makes them short numbers. */
  heights(most) {
    const [size, unit] = [[1e9, "GPa"], [1e6, "MPa"], [1e3, "kPa"], [1, "Pa"]].find(([one]) => most >= one)
      ?? [1, "Pa"];
    return Object.assign(ticksTo(most / size), { size, unit });
  }

  placing(ticks) {
    const { width, height, left, right, top, bottom } = CURVE;
    const rounded = (value) => Number(value.toFixed(1));
    return (x, y) => [
      rounded(left + (x / ticks.x.at(-1)) * (width - left - right)),
      rounded(height - bottom - (y / ticks.y.at(-1)) * (height - top - bottom)),
    ];
  }

  grid(ticks, at) {
    const [xs, ys] = [ticks.x, ticks.y];
    const text = (content, x, y, anchor, more = {}) => makeSvg("text", { x, y, "text-anchor": anchor, ...more }, content);
    const lines = [];
    for (const x of xs) {
      const [[a, b], [, c]] = [at(x, 0), at(x, ys.at(-1))];
      lines.push(makeSvg("path", { class: "line", d: `M${a},${b}V${c}` }), text(general(x, 6), a, b + 14, "middle"));
    }
    for (const y of ys) {
      const [[a, b], [c]] = [at(0, y), at(xs.at(-1), y)];
      lines.push(makeSvg("path", { class: "line", d: `M${a},${b}H${c}` }), text(general(y, 6), a - 5, b + 4, "end"));
    }
    const middle = [CURVE.left + (CURVE.width - CURVE.left - CURVE.right) / 2, CURVE.height - 6];
    lines.push(text("strain [%]", ...middle, "middle"));
    const turned = `translate(12 ${(CURVE.height - CURVE.bottom) / 2}) rotate(-90)`;
    lines.push(text(`stress [${ys.unit}]`, 0, 0, "middle", { transform: turned }));
    return lines;
  }

  tell(numbers, torn) {
    const ends = torn === null ? "It does not tear here."
      : `× It tears at ${general(100 * torn, 3)} %, ${show(stressAt(numbers, torn), this.units(OF_CURVE.young))}.`;
    const alike = Object.values(OF_CURVE).flatMap((key) => this.compare(key));
    const law = state.like?.laws?.length ? " The tissue has a law of its own, which is not drawn." : "";
    return [ends, ...alike].join(" ") + law;
  }

  units(key) {
    return SYSTEM.quantities.get(key).shown_units;
  }

  /** The tissue whose number is nearest to that of the words, as a sentence. */
  compare(key) {
    const value = this.number(key);
    if (!SYSTEM.quantities.has(key) || !(value > 0)) return [];
    const pairs = DATA.presets.flatMap((preset) => preset.numbers
      .filter((number) => number.quantity === key).map((number) => [preset.name, number.value]));
    const like = nearest(pairs, value);
    if (!like) return [];
    const { name } = SYSTEM.quantities.get(key);
    return [`${name[0].toUpperCase()}${name.slice(1)}: nearest is ${like[0]}, ${show(like[1], this.units(key))}.`];
  }
}
