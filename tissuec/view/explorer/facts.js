// What is said of a tissue: facts in words and numbers, and how they are set.

const DATA = JSON.parse(document.getElementById("data").textContent);
const SYSTEM = prepare(DATA);
const OWN = "my tissue";
const $ = (selector) => document.querySelector(selector);

/** What is said: rules, name, facts {sign, text, value} by property, numbers, and the preset
 *  whose laws of springs are kept. */
const state = { rules: "", name: OWN, facts: new Map(), numbers: [], like: null };
/** What the rules make of it: see infer(). */
let found = null;

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
