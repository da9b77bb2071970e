// The page: what is said of a tissue, and what the rules make of it.

const DATA = JSON.parse(document.getElementById("data").textContent);
const SYSTEM = prepare(DATA);
const OWN = "my tissue";
const $ = (selector) => document.querySelector(selector);

/** What is said: rules, name, facts {sign, text, value} by property, numbers, and the preset
 *  whose laws of springs are kept. */
const state = { rules: "", name: OWN, facts: new Map(), numbers: [], like: null };
/** What the rules make of it: see infer(). */
let found = null;

// --- facts ----------------------------------------------------------------------------------

/** Words and hedged words of a property, by what is written for them, and phrases of presets. */
function phrasesOf(property) {
  const phrases = new Map();
  for (const preset of DATA.presets) {
    const fact = preset.facts[property.key];
    if (fact?.sign === "is") phrases.set(keyOf(fact.text), { ...fact, word: null, hedge: "" });
  }
  for (const word of property.words) {
    for (const [hedge, turned] of [["", word], ...Object.entries(word.hedged)]) {
      phrases.set(keyOf(turned.phrase), { ...turned, text: turned.phrase, word, hedge });
    }
  }
  return phrases;
}

function keyOf(text) {
  return text.replaceAll('"', "").toLowerCase().trim().replace(/\s+/g, " ");
}

function said(property, sign, text, value) {
  state.facts.set(property.key, { sign, text, value });
}

/** Takes a fact as a text; an Error says why it is none. */
function say(property, sign, text) {
  if (sign === "is") {
    const phrase = property.phrases.get(keyOf(text));
    if (!phrase) throw new Error(`"${text}" is not a word for ${property.name}`);
    said(property, "is", phrase.text, phrase.value);
    return;
  }
  const value = readNumber(text, property, DATA.units);
  if (toScale(property, value) === null) {
    throw new Error(`outside the range from ${property.ends.join(" to ")}`);
  }
  said(property, "=", text.trim().replace(/\s+/g, " "), value);
}

/** Sets a property to a share of its scale, as a slider does. */
function slide(property, share) {
  const text = textAt(property, share);
  const value = readNumber(text, property, DATA.units);
  const inside = toScale(property, value) !== null;
  const end = textAt(property, share < 0.5 ? 0 : 1); // digits that were cut led out of the range
  said(property, "=", inside ? text : end, inside ? value : share < 0.5 ? property.low : property.high);
}

/** The word that is most true at a coordinate, and how true it is. */
function fitting(scale, place) {
  let best = { word: null, degree: 0 };
  for (const word of scale.words) {
    const degree = SYSTEM.sets[word.shape].degree(place);
    if (degree > best.degree) best = { word, degree };
  }
  return best;
}

/** What is said in words, or else the word that fits best: {word, hedge}. */
function wordingOf(property, fact, place) {
  if (fact?.sign === "is") return property.phrases.get(keyOf(fact.text));
  return { word: place === undefined ? null : fitting(property, place).word, hedge: "" };
}

// --- a property -----------------------------------------------------------------------------

/** The controls of one property; draw() shows the present state. */
class Control {
  constructor(property) {
    this.property = property;
    property.phrases = phrasesOf(property);
    const name = property.name;
    this.box = make("section", {
      class: "property", role: "group", "aria-label": name, "data-key": property.key,
    });
    this.told = make("input", { type: "checkbox", onchange: () => this.toggle() });
    this.text = make("output", { class: "fact" });
    this.number = make("input", {
      type: "text", class: "number", spellcheck: "false", autocomplete: "off",
      "aria-label": `${name} as a number`, oninput: () => this.type(false), onchange: () => this.type(true),
    });
    this.hedge = make("select", {
      "aria-label": `hedge of ${name}`, onchange: () => this.choose(this.wording.word, this.hedge.value),
    }, new Option("no hedge", ""), ...DATA.hedges.map((hedge) => new Option(hedge.name, hedge.key)));
    this.hedge.hidden = property.words.every((word) => !Object.keys(word.hedged).length);
    this.slider = make("input", {
      type: "range", min: 0, max: 1, step: "any", "aria-label": name,
      oninput: () => change(() => slide(property, Number(this.slider.value))),
      onkeydown: (event) => this.step(event),
    });
    this.outlines = property.words.map((word) => {
      const points = pointsOf(SYSTEM.sets[word.shape], property);
      return makeSvg("path", { d: areaOf(points, property), class: "word" });
    });
    this.hedged = makeSvg("path", { class: "hedged" });
    this.line = makeSvg("path", { class: "present" });
    this.dots = makeSvg("path", { class: "dots" });
    this.ticks = make("div", { class: "ticks", role: "group", "aria-label": `words for ${name}` },
      ...property.words.map((word) => this.tick(word)));
    this.error = make("p", { class: "error", role: "alert" });
    const head = make("div", { class: "head" }, make("label", {}, this.told, make("b", {}, name)),
      this.text, this.hedge, this.number);
    this.box.append(head, make("div", { class: "scale" },
      plot(...this.outlines, this.hedged, this.line, this.dots), this.slider, this.ticks), this.error);
    if (property.cannot_be_said) this.refuse(property.cannot_be_said);
  }

  tick(word) {
    const button = make("button", {
      type: "button", "data-share": shareOf(this.property, SYSTEM.sets[word.shape].middle),
      onclick: () => this.choose(word, ""),
    }, make("span", {}, word.word), make("small", {}));
    return button;
  }

  refuse(reason) {
    this.box.querySelectorAll("input, select, button").forEach((one) => { one.disabled = true; });
    this.error.textContent = `Cannot be said: ${reason}.`;
  }

  choose(word, hedge) {
    if (!word) return;
    const { phrase } = hedge ? word.hedged[hedge] : word;
    change(() => say(this.property, "is", phrase));
  }

  toggle() {
    change(() => {
      if (this.told.checked) slide(this.property, Number(this.slider.value));
      else state.facts.delete(this.property.key);
    });
  }

  /** Takes what was typed; while it is being typed, mistakes are no news. */
  type(finished) {
    try {
      change(() => say(this.property, "=", this.number.value));
      this.complain("");
    } catch (error) {
      if (finished) this.complain(error.message);
    }
    if (finished && !this.error.textContent) this.draw();
  }

  complain(message) {
    this.error.textContent = message;
    this.number.setAttribute("aria-invalid", message ? "true" : "false");
  }

  /** Arrows go by hundredths, with shift by thousandths; page keys go from word to word. */
  step(event) {
    const sign = { ArrowUp: 1, ArrowRight: 1, PageUp: 1, ArrowDown: -1, ArrowLeft: -1, PageDown: -1 }[event.key];
    if (!sign) return;
    event.preventDefault();
    const share = Number(this.slider.value);
    if (event.key.startsWith("Page")) {
      const at = (word) => shareOf(this.property, SYSTEM.sets[word.shape].middle);
      const ahead = this.property.words.filter((word) => sign * (at(word) - share) > 1e-9)
        .sort((a, b) => sign * (at(a) - at(b)));
      this.choose(ahead[0], "");
    } else {
      const step = sign * (event.shiftKey ? 0.001 : 0.01);
      change(() => slide(this.property, Math.min(Math.max(share + step, 0), 1)));
    }
  }

  draw() {
    const { property } = this;
    const fact = state.facts.get(property.key);
    const place = found.places.get(property.key);
    this.wording = wordingOf(property, fact, place);
    this.box.classList.toggle("unsaid", !fact);
    this.told.checked = Boolean(fact);
    this.text.textContent = this.text.title = fact ? `${fact.sign} ${fact.text}` : "not said";
    if (document.activeElement !== this.number) {
      this.complain("");
      this.number.value = !fact ? "" : fact.sign === "=" ? fact.text
        : withUnit(Number((fact.value / property.factor).toPrecision(4)), property);
    }
    const share = fact ? shareOf(property, place) : Number(this.slider.value);
    if (fact) this.slider.value = share;
    this.drawHedges(fact);
    const degrees = property.words.map(({ shape }) => (fact ? SYSTEM.sets[shape].degree(place) : 0));
    const pressed = fact?.sign === "is" ? this.wording.word : null;
    property.words.forEach((word, i) => {
      this.outlines[i].classList.toggle("lit", degrees[i] > 0);
      const tick = this.ticks.children[i];
      tick.setAttribute("aria-pressed", String(word === pressed));
      tick.classList.toggle("lit", degrees[i] > 0);
      tick.lastElementChild.textContent = degrees[i] > 0 ? degreeText(degrees[i]) : "";
    });
    const set = fact?.sign === "is" && this.wording.hedge ? SYSTEM.sets[this.wording.shape] : null;
    this.hedged.setAttribute("d", set ? areaOf(pointsOf(set, property), property) : "");
    this.line.setAttribute("d", fact ? `M${share * WIDE},0V${HIGH}` : "");
    this.dots.setAttribute("d", degrees.map((d) => (d > 0 ? dotAt(share, d) : "")).join(""));
    const true_ = property.words.map((word, i) => [word.word, degrees[i]]).filter(([, d]) => d > 0)
      .map(([word, d]) => `${word} ${degreeText(d)}`);
    this.slider.setAttribute("aria-valuetext",
      fact ? [this.number.value, fact.sign === "is" ? fact.text : "", ...true_].filter(Boolean).join(", ")
        : "not said");
  }

  drawHedges(fact) {
    const { word, hedge } = this.wording;
    for (const option of this.hedge.options) {
      option.disabled = Boolean(option.value) && !word?.hedged[option.value];
    }
    this.hedge.value = hedge;
    this.hedge.disabled = !fact || Boolean(this.property.cannot_be_said);
  }
}

function degreeText(degree) {
  return degree === 1 ? "1" : degree < 0.005 ? "<0.01" : degree.toFixed(2);
}

// --- quantities -----------------------------------------------------------------------------

function shown(quantity, value) {
  return show(value, quantity.shown_units) + quantity.belonging;
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
    this.value.textContent = written ? written.shown : value === null ? "no number" : shown(quantity, value);
    this.told.replaceChildren(...this.tell(base, answer, written, place));
    this.drawSets(base, answer, place);
  }

  tell(base, answer, written, place) {
    const parts = [];
    const { word, degree } = place === null ? {} : fitting(this.quantity, place);
    const fits = word ? ["fits ", make("b", {}, word.word), ` ${degreeText(degree)}`] : [];
    if (written) {
      parts.push("written", place === null ? ", outside the words" : "", "; rules say ",
        answer.value === null ? "nothing" : shown(this.quantity, answer.value));
    } else if (answer.source === "otherwise") {
      parts.push("no rule speaks: otherwise ", make("b", {}, base.otherwise[this.quantity.key].word));
    } else if (answer.source === "none") {
      const { without } = this.quantity;
      parts.push(reasonOf(base, this.quantity.key, found.verdicts), ". ",
        without ? `Without it: ${without}.` : "A body that needs it is refused (TIS206).");
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

// --- rules ----------------------------------------------------------------------------------

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
    this.missing.textContent = missing.length ? ` does not speak: ${missing.join(", ")} not said` : "";
    this.tests.forEach(([mark, isNegated], i) => {
      const known = degrees[i] === null ? null : isNegated ? 1 - degrees[i] : degrees[i];
      mark.classList.toggle("lit", known > 0);
      mark.title = known === null ? "not said" : `true to ${degreeText(known)}`;
      mark.dataset.degree = known === null || known === 0 || known === 1 ? "" : degreeText(known);
    });
  }
}

// --- texts ----------------------------------------------------------------------------------

/** A name as a text must have it: in quotes if it is more than plain words. */
function writtenName(name) {
  const reserved = new Set(DATA.reserved);
  const isPlain = (word) => /^[\p{L}_][\p{L}\p{N}_]*$/u.test(word) && !reserved.has(word.toLowerCase());
  const clean = name.replace(/["\p{Cc}]/gu, "").trim().replace(/\s+/g, " ") || OWN;
  return clean.split(" ").every(isPlain) ? clean : `"${clean}"`;
}

/** Whether all that the preset says is still said, so that "like" brings back nothing else. */
function saysAllOf(preset) {
  return Object.keys(preset.facts).every((key) => state.facts.has(key))
    && preset.numbers.every(({ quantity }) => state.numbers.some((one) => one.quantity === quantity));
}

/** The tissue as the compiler reads it. */
function tissueText() {
  const base = SYSTEM.bases.get(state.rules);
  const like = state.like && saysAllOf(state.like) ? ` like ${state.like.written}` : "";
  const lines = [`tissue ${writtenName(state.name)}${like} {`, `  described in ${base.written}`];
  for (const [key, property] of SYSTEM.properties) {
    const fact = state.facts.get(key);
    if (fact) lines.push(`  ${property.written} ${fact.sign} ${fact.text}`);
  }
  for (const { quantity, text } of state.numbers) lines.push(`  ${quantity} ${text}`);
  if (state.like && !like) {
    lines.push(`  # without the ${state.like.laws.join(" and ")} of ${state.like.name}`);
  }
  return [...lines, "}"].join("\n");
}

/** Where the tissue can stand. */
function placeText() {
  const like = state.like && saysAllOf(state.like) ? state.like.file : "";
  const used = [...new Set([DATA.use, like].filter(Boolean))].map((file) => `use "${file}"`);
  const file = DATA.use ? "a file" : DATA.file;
  return `For ${file}${used.length ? ` that says ${used.join(" and ")}` : " itself"}.`;
}

/** All that is said, as a text that can be kept and given back. */
function stateText() {
  const facts = [...state.facts].map(([key, { sign, text }]) => [key, `${sign} ${text}`]);
  return JSON.stringify({
    rules: state.rules,
    name: state.name,
    facts: Object.fromEntries(facts),
    numbers: state.numbers.map(({ quantity, text }) => `${quantity} ${text}`),
    like: state.like && `${state.like.place} ${state.like.name}`,
  });
}

/** Takes back what stateText() wrote; an Error says what does not fit this vocabulary. */
function restore(text) {
  const { rules, name = OWN, facts = {}, numbers = [], like = null } = JSON.parse(text);
  if (!SYSTEM.bases.has(rules)) throw new Error(`there are no rules "${rules}" here`);
  const before = [state.facts, state.numbers];
  state.facts = new Map();
  try {
    for (const [key, fact] of Object.entries(facts)) {
      const property = SYSTEM.properties.get(key);
      if (!property) throw new Error(`there is no property "${key}" here`);
      const [, sign, phrase] = /^(=|is) (.*)$/.exec(fact) ?? [];
      if (!sign) throw new Error(`"${fact}" is neither = NUMBER nor is WORD`);
      say(property, sign, phrase);
    }
    state.numbers = numbers.map(knownNumber);
  } catch (error) {
    [state.facts, state.numbers] = before;
    throw error;
  }
  state.name = String(name);
  state.like = DATA.presets.find((one) => `${one.place} ${one.name}` === like) ?? null;
  $("#preset").value = "";
  chooseRules(rules);
}

/** The number of a preset that a text stands for. */
function knownNumber(text) {
  const numbers = DATA.presets.flatMap((preset) => preset.numbers);
  const known = numbers.find((one) => `${one.quantity} ${one.text}` === text);
  if (!known) throw new Error(`no tissue here has "${text}"`);
  return known;
}

/** Copies a text; pages from files may lack the clipboard, where a selection does as well. */
async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = make("textarea", { readonly: "" });
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  const label = button.textContent;
  button.textContent = "Copied";
  setTimeout(() => { button.textContent = label; }, 1200);
}

// --- the whole page -------------------------------------------------------------------------

const controls = DATA.properties.map((property) => new Control(SYSTEM.properties.get(property.key)));
const results = DATA.quantities.map((quantity) => new Result(SYSTEM.quantities.get(quantity.key)));
let sentences = [];
const surface = new Surface($("#surface"), (x, across, y, up) => change(() => {
  slide(x, across);
  slide(y, up);
}));

/** Changes what is said, and shows what follows. */
function change(action) {
  action();
  $("#preset").value = "";
  $("#about").textContent = DATA.about;
  draw();
}

function draw() {
  const base = SYSTEM.bases.get(state.rules);
  const facts = new Map([...state.facts].map(([key, fact]) => [key, fact.value]));
  found = infer(SYSTEM, base, facts);
  controls.forEach((control) => control.draw());
  results.forEach((result) => result.draw(base));
  sentences.forEach((sentence, i) => sentence.draw(found.verdicts[i]));
  const firing = found.verdicts.filter(({ degree }) => degree > 0).length;
  $("#count").textContent = `${firing} of ${base.rules.length} fire`;
  $("#numbers").replaceChildren(...state.numbers.map(numberRow));
  $("#text").textContent = tissueText();
  $("#place").textContent = placeText();
  if (document.activeElement !== $("#name")) $("#name").value = state.name;
  if (document.activeElement !== $("#state")) $("#state").value = stateText();
  $("#strip").replaceChildren(...results.map(({ quantity, value }) => make("span", {},
    make("small", {}, quantity.name), make("b", {}, value.textContent))));
  if (surface.possible) surface.update({ base, facts, places: found.places });
  announce();
}

/** A number that replaces what rules say, and a button that lets them speak. */
function numberRow(number) {
  const drop = make("button", {
    type: "button",
    onclick: () => change(() => { state.numbers = state.numbers.filter((one) => one !== number); }),
  }, "let the rules say");
  const isConcluded = SYSTEM.quantities.has(number.quantity);
  drop.hidden = !isConcluded;
  return make("li", {}, make("code", {}, `${number.quantity} ${number.text}`), " ", drop);
}

let waiting = 0;
/** Tells those who listen what came out, once the sliders rest. */
function announce() {
  clearTimeout(waiting);
  waiting = setTimeout(() => {
    $("#spoken").textContent = results
      .map(({ quantity, value }) => `${quantity.name} ${value.textContent}`).join(", ");
  }, 700);
}

function chooseRules(key) {
  state.rules = key;
  const base = SYSTEM.bases.get(key);
  $("#rules").value = key;
  sentences = base.rules.map((rule) => new Sentence(rule));
  $("#sentences").replaceChildren(...sentences.map(({ row }) => row));
  const { conjunction, disjunction, implication, result } = base.operators;
  $("#operators").textContent = `and: ${conjunction} · or: ${disjunction} · then: ${implication} · result: ${result}`;
  const asked = new Set(base.atoms.flat().map(([, property]) => property));
  controls.forEach(({ box, property }) => box.classList.toggle("unasked", !asked.has(property.key)));
  surface.offer(base);
  $("#surface").hidden = !surface.possible;
  draw();
}

function choosePreset(preset) {
  state.name = preset ? `my ${preset.name}` : OWN;
  state.facts = new Map(Object.entries(preset ? preset.facts : {}));
  state.numbers = preset ? preset.numbers : [];
  state.like = preset?.laws.length ? preset : null;
  if (!preset) {
    for (const property of SYSTEM.properties.values()) {
      const word = property.words[Math.floor(property.words.length / 2)];
      if (!property.cannot_be_said) said(property, "is", word.phrase, word.value);
    }
  }
  $("#about").textContent = preset?.about || DATA.about;
  chooseRules(preset ? preset.rules : state.rules || DATA.rules[0].key);
}

function listPresets() {
  const menu = $("#preset");
  const groups = [[DATA.file, (preset) => !preset.file], ["library", (preset) => preset.file]];
  for (const [label, belongs] of groups) {
    const options = DATA.presets.map((preset, i) => [preset, i]).filter(([preset]) => belongs(preset))
      .map(([{ name }, i]) => new Option(name, i));
    if (options.length) menu.append(make("optgroup", { label }, ...options));
  }
  menu.addEventListener("change", () => {
    const { value } = menu;
    choosePreset(DATA.presets[value] ?? null);
    menu.value = value;
  });
}

function listen() {
  $("#rules").append(...DATA.rules.map(({ key, name }) => new Option(name, key)));
  $("#rules").parentElement.hidden = DATA.rules.length < 2;
  $("#rules").addEventListener("change", () => chooseRules($("#rules").value));
  $("#firing").addEventListener("change", (event) => {
    $("#sentences").classList.toggle("firing", event.target.checked);
  });
  $("#name").addEventListener("input", () => {
    state.name = $("#name").value;
    draw();
  });
  $("#copy").addEventListener("click", (event) => copy(tissueText(), event.target));
  $("#keep").addEventListener("click", (event) => copy(stateText(), event.target));
  $("#restore").addEventListener("click", () => {
    try {
      restore($("#state").value);
      $("#wrong").textContent = "";
    } catch (error) {
      $("#wrong").textContent = error instanceof SyntaxError ? "This is not a state." : error.message;
    }
  });
  $("#theme").addEventListener("click", () => {
    const root = document.documentElement;
    const theme = root.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    root.dataset.theme = theme === "dark" ? "light" : "dark";
  });
  const resized = new ResizeObserver(() => document.querySelectorAll(".ticks").forEach(layOut));
  resized.observe(document.body);
}

$("#properties").append(...controls.map(({ box }) => box));
$("#quantities").append(...results.map(({ box }) => box));
listPresets();
listen();
choosePreset(null);
document.querySelectorAll(".ticks").forEach(layOut);
