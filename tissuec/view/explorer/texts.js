// The tissue as text, and the state of the page as text.

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
  return `For ${file}${used.length ? ` with ${used.join(" and ")}` : " itself"}.`;
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
  if (!SYSTEM.bases.has(rules)) throw new Error(`the vocabulary has no rules "${rules}"`);
  const before = [state.facts, state.numbers];
  state.facts = new Map();
  try {
    for (const [key, fact] of Object.entries(facts)) {
      const property = SYSTEM.properties.get(key);
      if (!property) throw new Error(`the vocabulary has no property "${key}"`);
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
  if (!known) throw new Error(`no tissue has "${text}"`);
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
