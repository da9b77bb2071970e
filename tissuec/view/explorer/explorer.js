// The whole page: what changes is drawn anew.

const controls = DATA.properties.map((property) => new Control(SYSTEM.properties.get(property.key)));
const results = DATA.quantities.map((quantity) => new Result(SYSTEM.quantities.get(quantity.key)));
const stressCurve = new StressCurve($("#curve"));
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
  stressCurve.draw();
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
  }, "use the rules");
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
