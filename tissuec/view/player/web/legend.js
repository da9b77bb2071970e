// The field on the skin, its colours and their range: parts of the player.

const legend = {
  prepareFields() {
    const { film } = this, menu = byId("field");
    this.fields = film.fields.map((spec) => new NodeField(film, this.arrays, spec));
    menu.append(...["tissue", ...film.fields.map(({ name }) => name)].map((name) => new Option(name, name)));
    menu.addEventListener("change", () => this.set("field", menu.value));
    const ends = [byId("low"), byId("high")];
    const take = () => {
      const { chosen: field } = this, range = ends.map((end) => end.valueAsNumber * field.divisor);
      const isRange = range[0] < range[1] && (!field.isLog || range[0] > 0);
      const what = `The first number must be the smaller one${field.isLog ? " and above 0" : ""}.`;
      for (const end of ends) end.setCustomValidity(isRange ? "" : what);
      if (!isRange) return;
      field.range = range;
      this.showField();
      this.refresh();
    };
    for (const end of ends) end.addEventListener("change", take);
    const reset = () => {
      this.chosen.isLog = byId("log").checked;
      this.chosen.range = this.chosen.whole;
      this.showField();
      this.refresh();
    };
    byId("usual").addEventListener("click", reset);
    byId("log").addEventListener("change", reset);
  },

  // The field that colours the skin; null where its tissues do.
  get chosen() { return this.fields.find(({ name }) => name === this.shown.field) ?? null; },

  // Write the colours of the field with their numbers.
  showField() {
    const field = this.chosen, box = byId("range");
    for (const { chart } of this.pins) chart.take(field ?? this.displaced);
    byId("field").value = this.shown.field;
    box.hidden = !field;
    if (!field) return;
    const { divisor, unit, range } = field, [low, high] = range;
    const numbers = [low, field.middle, high].map((value) => value / divisor);
    const texts = field.isLog ? numbers.map((value) => `${Number(value.toPrecision(2))}`) : apart(numbers);
    const [isUnder, isOver] = field.beyond;
    const shades = shadesOf(field, this.film.looks, this.look).map(css);
    byId("ramp").style.background = `linear-gradient(90deg,${shades.join(",")})`;
    byId("ramp").classList.toggle("under", isUnder);
    byId("ramp").classList.toggle("over", isOver);
    byId("ramp").style.setProperty("--first", shades[0]);
    byId("ramp").style.setProperty("--last", shades[shades.length - 1]);
    byId("ticks").replaceChildren(...texts.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
    byId("what").textContent = unit ? `${field.about} [${unit}]` : field.about;
    byId("clipped").textContent = this.clipped(field);
    [byId("low"), byId("high")].forEach((end, k) => {
      end.value = Number((range[k] / divisor).toPrecision(6));
      end.setCustomValidity("");
      end.setAttribute("aria-label", `${k ? "Upper" : "Lower"} end of the colours${unit ? ` in ${unit}` : ""}`);
    });
    byId("usual").disabled = range === field.whole;
    byId("log").checked = field.isLog;
    byId("log").disabled = !field.decades;
  },

  // Say which numbers the colours do not tell apart.
  clipped({ divisor, unit, range, usual, isLog, extent, beyond }) {
    const text = (value) => `${digits(value / divisor)} ${unit}`.trim();
    const parts = [];
    if (range === usual && !isLog && beyond.includes(true)) parts.push("colours cover 98 % of the values");
    if (beyond[1]) parts.push(`largest: ${text(extent[1])}`);
    if (beyond[0]) parts.push(`smallest: ${text(extent[0])}`);
    return parts.join("; ");
  },
};
