// What the rules make of it: quantities with their sets, and the rules as sentences.

function shown(quantity, value) {
  return show(value, quantity.shown_units) + quantity.belonging;
}

function degreeText(degree) {
  return degree === 1 ? "1" : degree < 0.005 ? "<0.01" : degree.toFixed(2);
}

/** What is drawn and told of one quantity. */
class Result {
  constructor(quantity) {
    this.quantity = quantity;
    this.value = make("data", { class: "value" });
    this.told = make("p", { class: "told" });
    this.labels = make("div", { class: "ticks" });
    this.drawing = plot();
    const ends = quantity.ends.map((end) => make("span", {}, end));
    this.box = make("article", { class: "quantity", "data-key": quantity.key },
      make("h3", {}, quantity.name), this.value, this.told,
      make("div", { class: "scale" }, this.drawing, this.labels,
        make("div", { class: "ends" }, ends[0], make("span", {}, quantity.log ? "log scale" : ""), ends[1])));
  }

  /** Words of the scale, and hedged ones that rules conclude: [word, number of the set]. */
  words(base) {
    const { key, words } = this.quantity;
    const concluded = [...base.bearings.get(key), ...[base.otherwise[key]].filter(Boolean)];
    const shapes = new Map([...words, ...concluded].map(({ word, shape }) => [shape, word]));
    return [...shapes].map(([shape, word]) => ({ word, shape }));
  }

  draw(base) {
    const { quantity } = this;
    const answer = found.answers.get(quantity.key);
    const written = state.numbers.find((number) => number.quantity === quantity.key);
    const value = written ? written.value : answer.value;
    const place = value === null ? null : toScale(quantity, value);
    this.box.dataset.source = written ? "written" : answer.source;
    this.value.value = value ?? "";
    this.value.textContent = written ? written.shown : value === null ? "no value" : shown(quantity, value);
    this.told.replaceChildren(...this.tell(base, answer, written, place));
    this.drawSets(base, answer, place);
  }

  tell(base, answer, written, place) {
    const parts = [];
    const { word, degree } = place === null ? {} : fitting(this.quantity, place);
    const fits = word ? ["fits ", make("b", {}, word.word), ` ${degreeText(degree)}`] : [];
    if (written) {
      parts.push("written", place === null ? ", outside the words" : "", "; the rules give ",
        answer.value === null ? "nothing" : shown(this.quantity, answer.value));
    } else if (answer.source === "otherwise") {
      parts.push("no rule fires: fallback ", make("b", {}, base.otherwise[this.quantity.key].word));
    } else if (answer.source === "none") {
      const { without } = this.quantity;
      parts.push(reasonOf(base, this.quantity.key, found.verdicts), ". ",
        without ? `Without it: ${without}.` : "A body that needs it gives error TIS206.");
    } else if (word) parts.push(...fits);
    else parts.push("no word fits");
    return parts;
  }

  drawSets(base, answer, place) {
    const { quantity } = this;
    const area = (points, name) => makeSvg("path", { d: areaOf(points, quantity), class: name });
    const words = this.words(base);
    const own = new Set(quantity.words.map(({ shape }) => shape));
    const layers = words.map(({ shape }) => area(pointsOf(SYSTEM.sets[shape], quantity),
      own.has(shape) ? "word" : `word other ${answer.strongest.has(shape) ? "" : "unlit"}`));
    const otherwise = answer.source === "otherwise" ? base.otherwise[quantity.key] : null;
    if (answer.pieces.length) layers.push(area(pointsOfPieces(answer.pieces), "joined"));
    if (otherwise) layers.push(area(pointsOf(SYSTEM.sets[otherwise.shape], quantity), "joined otherwise"));
    if (answer.source === "rules" && !answer.pieces.length) {
      const bars = [...answer.strongest].map(([shape, degree]) => [
        shareOf(quantity, SYSTEM.sets[shape].middle), degree]);
      layers.push(makeSvg("path", { class: "bars", d: bars.map(([at, d]) => `M${at * WIDE},${HIGH}V${(1 - d) * HIGH}`).join("") }));
    }
    if (place !== null) layers.push(makeSvg("path", { class: "result", d: `M${shareOf(quantity, place) * WIDE},0V${HIGH}` }));
    this.drawing.replaceChildren(...layers);
    this.drawLabels(words.filter(({ shape }) => own.has(shape) || answer.strongest.has(shape)),
      answer, otherwise);
  }

  /** Words below the plot; they are laid out anew only where others are shown than before. */
  drawLabels(words, answer, otherwise) {
    const key = words.map(({ shape }) => shape).join();
    if (key !== this.labelled) {
      this.labels.replaceChildren(...words.map(({ word, shape }) => make("span", {
        "data-share": shareOf(this.quantity, SYSTEM.sets[shape].middle),
      }, make("span", {}, word), make("small", {}))));
      this.labelled = key;
      layOut(this.labels);
    }
    words.forEach(({ shape }, i) => {
      const degree = answer.strongest.get(shape) ?? 0;
      const label = this.labels.children[i];
      label.classList.toggle("lit", degree > 0 || otherwise?.shape === shape);
      label.lastElementChild.textContent = degree > 0 ? degreeText(degree) : "";
    });
  }
}

/** A rule as a sentence; its tests are marked with their degrees. */
class Sentence {
  constructor(rule) {
    this.rule = rule;
    this.degree = make("output", { class: "degree" });
    this.bar = make("i", { class: "bar" });
    this.missing = make("small", { class: "missing" });
    this.tests = [];
    const parts = rule.parts.map(([kind, text]) => {
      if (!kind) return text;
      const mark = make(kind === "then" ? "b" : "span", { class: kind === "then" ? "then" : "test" }, text);
      if (kind !== "then") this.tests.push([mark, kind === "not"]);
      return mark;
    });
    this.row = make("li", { title: rule.place }, make("span", { class: "meter" },
      make("span", { class: "track" }, this.bar), this.degree),
      make("span", { class: "sentence" }, ...parts, this.missing));
  }

  draw({ degree, degrees, missing }) {
    this.row.classList.toggle("lit", degree > 0);
    this.row.dataset.degree = degree;
    this.degree.textContent = missing.length ? "–" : degree > 0 ? degreeText(degree) : "0";
    this.bar.style.width = `${100 * degree}%`;
    this.missing.textContent = missing.length ? ` not evaluated: ${missing.join(", ")} not given` : "";
    this.tests.forEach(([mark, isNegated], i) => {
      const known = degrees[i] === null ? null : isNegated ? 1 - degrees[i] : degrees[i];
      mark.classList.toggle("lit", known > 0);
      mark.title = known === null ? "not given" : `degree ${degreeText(known)}`;
      mark.dataset.degree = known === null || known === 0 || known === 1 ? "" : degreeText(known);
    });
  }
}
