// The controls of a property.

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
      plot(...this.outlines, this.hedged, this.line, this.dots), this.slider, this.ticks),
    make("p", { class: "anchors" }, ladder(property)), this.error);
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
    this.error.textContent = `Invalid: ${reason}.`;
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

  /** Shows the present state; degrees are those that count in the chosen rules. */
  draw() {
    const { property } = this;
    const base = SYSTEM.bases.get(state.rules);
    const fact = state.facts.get(property.key);
    const place = found.places.get(property.key);
    this.wording = wordingOf(property, fact, place);
    this.box.classList.toggle("unsaid", !fact);
    this.told.checked = Boolean(fact);
    this.text.textContent = this.text.title = fact ? `${fact.sign} ${fact.text}` : "not given";
    if (document.activeElement !== this.number) {
      this.complain("");
      this.number.value = !fact ? "" : fact.sign === "=" ? fact.text
        : withUnit(Number((fact.value / property.factor).toPrecision(4)), property);
    }
    const share = fact ? shareOf(property, place) : Number(this.slider.value);
    if (fact) this.slider.value = share;
    this.drawHedges(fact);
    const degreesAt = (at) => property.words.map(({ shape }) => SYSTEM.sets[shape].degree(at));
    const none = property.words.map(() => 0);
    const degrees = fact ? degreesAt(countingPlace(base, property, place)) : none;
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
    this.dots.setAttribute("d", (fact ? degreesAt(place) : none).map((d) => (d > 0 ? dotAt(share, d) : "")).join(""));
    const true_ = property.words.map((word, i) => [word.word, degrees[i]]).filter(([, d]) => d > 0)
      .map(([word, d]) => `${word} ${degreeText(d)}`);
    this.slider.setAttribute("aria-valuetext",
      fact ? [this.number.value, fact.sign === "is" ? fact.text : "", ...true_].filter(Boolean).join(", ")
        : "not given");
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
