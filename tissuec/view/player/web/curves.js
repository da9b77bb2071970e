// Logs and energies over time, drawn on canvases; a line runs over them with the time.

const DASHES = [[], [5, 3], [1.5, 2.5], [8, 3, 2, 3], [3, 3]];
const BELOW = 16, LEFT = 44;  // pixels for numbers

// Return the pen of a canvas as large as its box, with what it measures.
function penOf(canvas, box, style) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2), width = box.clientWidth, height = box.clientHeight;
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  pen.font = "11px system-ui, sans-serif";
  pen.fillStyle = style.muted;
  return { pen, width, height };
}

// Draw levels with their numbers; return how far these reach from the left.
function drawLevels(pen, style, low, high, y, width, height) {
  pen.lineWidth = 1;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  const levels = ticks(low, high, Math.max(2, Math.floor(height / 34))), texts = apart(levels);
  const left = Math.max(LEFT, ...texts.map((text) => Math.ceil(pen.measureText(text).width) + 8));
  levels.forEach((tick, k) => {
    pen.strokeStyle = style.grid;
    pen.beginPath();
    pen.moveTo(left, Math.round(y(tick)) + 0.5);
    pen.lineTo(width - 6, Math.round(y(tick)) + 0.5);
    pen.stroke();
    pen.fillText(texts[k], left - 5, y(tick));
  });
  return left;
}

// Return an interval that is wide enough for an axis.
function roomFor(low, high) {
  if (low < high) return [low, high];
  return low === 0 ? [-1, 1] : [low - Math.abs(low) / 2, high + Math.abs(high) / 2];
}

class Chart {
  constructor(box, curve, levels, player) {
    Object.assign(this, { curve, levels, player, left: LEFT });
    this.figure = document.createElement("figure");
    [this.divisor, this.unit] = curve.shown;
    const caption = document.createElement("figcaption"), name = document.createElement("b");
    name.textContent = this.unit ? `${curve.name} [${this.unit}]` : curve.name;
    caption.append(name);
    const named = curve.columns.length <= 7;
    this.readouts = curve.columns.map((column, k) => {
      if (!named) return null;
      const label = document.createElement("span"), value = document.createElement("span");
      const isAlone = curve.columns.length === 1;
      label.innerHTML = `<svg class="line" viewBox="0 0 18 8" aria-hidden="true"><line x1="0" x2="18" y1="4" y2="4"
        stroke-width="2" stroke-dasharray="${this.dash(k).join(" ")}"/></svg>`;
      label.append(isAlone ? "" : column, value);
      caption.append(label);
      return value;
    });
    if (!named) {
      const label = document.createElement("span");
      label.textContent = `${curve.columns.length + curve.leftOut} columns`
        + (curve.leftOut ? `, the first ${curve.columns.length} drawn` : "");
      caption.append(label);
    }
    this.plot = document.createElement("div");
    this.plot.className = "plot";
    this.plot.setAttribute("role", "img");
    this.plot.setAttribute("aria-label", `${curve.name} over time`);
    this.canvas = document.createElement("canvas");
    this.head = document.createElement("div");
    this.head.className = "head";
    this.plot.append(this.canvas, this.head);
    this.figure.append(caption, this.plot);
    box.append(this.figure);
    this.listen();
  }

  colour(k) {
    const { looks } = this.player.film;
    return css(seenIn(this.player.look, looks.series[k % looks.series.length], looks));
  }

  // The first columns differ in colour and dash; many columns have no room for both.
  dash(k) { return this.curve.columns.length > 7 ? [] : DASHES[k % DASHES.length]; }

  listen() {
    const seek = (event) => {
      const box = this.plot.getBoundingClientRect(), { range } = this.player;
      const part = (event.clientX - box.left - this.left) / Math.max(1, box.width - this.left - 6);
      this.player.seek(range[0] + Math.max(0, Math.min(1, part)) * (range[1] - range[0]));
    };
    this.plot.addEventListener("pointerdown", (event) => {
      this.plot.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.plot.addEventListener("pointermove", (event) => { if (event.buttons) seek(event); });
  }

  // Return a number with the decimals that tell values of this curve apart.
  rounded(value) {
    const { low, high } = this.curve, most = Math.max(Math.abs(low), Math.abs(high)) / this.divisor;
    if (!(most < 1e6) || most < 1e-4) return digits(value);
    const span = Math.max((high - low) / this.divisor, 1e-6 * most);
    const places = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(span))));
    return value.toFixed(places).replace("-", "−").replace(/^−(0\.?0*)$/, "$1");
  }

  value(moment, column) {
    const { curve, levels } = this;
    const level = levels.low + levels.data[moment * levels.width + column];
    return level > 0 ? curve.low + (level - 1) * curve.step : null;  // 0 is none
  }

  x(time) {
    const { range } = this.player;
    return this.left + ((time - range[0]) / (range[1] - range[0] || 1)) * (this.width - this.left - 6);
  }

  // Draw all but the running line.
  draw(style) {
    const { canvas, curve } = this, { pen, width, height } = penOf(canvas, this.plot, style);
    this.width = width;
    this.figure.querySelectorAll("line").forEach((line, k) => line.setAttribute("stroke", this.colour(k)));
    if (curve.empty) {
      pen.fillText(curve.time.length ? "no numbers" : "no data", this.left, height / 2);
      return;
    }
    const [low, high] = roomFor(curve.low / this.divisor, curve.high / this.divisor);
    const bottom = height - BELOW, top = 7;
    const y = (value) => bottom - 3 - ((value - low) / (high - low)) * (bottom - top - 3);
    this.left = drawLevels(pen, style, low, high, y, width, height);
    this.drawTimes(pen, bottom, style);
    pen.lineJoin = "round";
    pen.globalAlpha = curve.columns.length > 7 ? 0.6 : 1;
    curve.columns.forEach((_, column) => this.drawColumn(pen, column, y));
  }

  drawTimes(pen, bottom, style) {
    const { range, clock } = this.player;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const found = ticks(range[0] / clock.divisor, range[1] / clock.divisor, Math.floor(this.width / 70));
    apart(found).forEach((text, k) => {
      const last = this.width - pen.measureText(text).width / 2 - 1;
      pen.fillText(text, Math.min(this.x(found[k] * clock.divisor), last), bottom + 4);
    });
    pen.strokeStyle = style.grid;
    pen.setLineDash([2, 3]);
    for (const mark of this.player.film.marks) {
      if (!["cross", "bolt"].includes(mark.sign)) continue;
      pen.beginPath();
      pen.moveTo(this.x(mark.time), 2);
      pen.lineTo(this.x(mark.time), bottom);
      pen.strokeStyle = style.muted;
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  drawColumn(pen, column, y) {
    pen.beginPath();
    let isDown = false;
    this.curve.time.forEach((time, moment) => {
      const value = this.value(moment, column);
      if (value === null) isDown = false;
      else {
        const at = [this.x(time), y(value / this.divisor)];
        if (isDown) pen.lineTo(...at);
        else pen.moveTo(...at);
        isDown = true;
      }
    });
    pen.strokeStyle = this.colour(column);
    pen.lineWidth = this.curve.columns.length > 7 ? 1 : 1.7;
    pen.setLineDash(this.dash(column));
    pen.stroke();
    pen.setLineDash([]);
  }

  // Move the line, and say what the numbers are now.
  show(time) {
    this.head.style.transform = `translateX(${this.x(time)}px)`;
    const { curve } = this;
    if (curve.empty) return;
    const [first, second, part] = between(curve.time, time);
    this.readouts.forEach((readout, column) => {
      if (!readout) return;
      const a = this.value(first, column), b = this.value(second, column);
      const value = a === null || b === null ? a : a + part * (b - a);
      const text = value === null ? "–" : this.rounded(value / this.divisor);
      if (readout.textContent !== text) readout.textContent = text;
    });
  }
}
