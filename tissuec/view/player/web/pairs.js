// One logged quantity against another, both chosen by menus; a point runs along the curve with the time.

class PairChart {
  constructor(box, player) {
    Object.assign(this, { player, quantities: player.film.quantities });
    this.figure = document.createElement("figure");
    this.figure.id = "pair";
    const caption = document.createElement("figcaption");
    const [vertical, across] = player.film.pair.map((chosen) => this.menu(chosen));
    caption.append(this.labelled("vertical", vertical), this.labelled("horizontal", across));
    Object.assign(this, { vertical, across });
    this.plot = document.createElement("div");
    this.plot.className = "plot";
    this.plot.setAttribute("role", "img");
    this.canvas = document.createElement("canvas");
    this.head = document.createElement("div");
    this.head.className = "point";
    this.plot.append(this.canvas, this.head);
    this.figure.append(caption, this.plot);
    box.append(this.figure);
  }

  menu(chosen) {
    const select = document.createElement("select");
    this.quantities.forEach(({ name, shown: [, unit] }, k) => {
      const option = new Option(unit ? `${name} [${unit}]` : name, k, k === chosen, k === chosen);
      select.append(option);
    });
    select.addEventListener("change", () => this.player.redraw());
    return select;
  }

  labelled(text, select) {
    const label = document.createElement("label");
    label.append(text, select);
    return label;
  }

  // Return the times of a quantity, and what it is at each [shown unit]; null where it is none.
  series({ curve, columns, from, shown: [divisor] }) {
    const chart = this.player.charts[curve], { time } = chart.curve;
    if (!columns.length) return { time, value: time.map((one) => one / divisor) };
    const rows = time.map((_, moment) => columns.map((column) => chart.value(moment, column)));
    const home = from ? rows[0] : columns.map(() => 0);
    const value = rows.map((row) => {
      if (row.includes(null)) return null;
      const way = row.map((one, k) => one - home[k]);
      return (way.length > 1 ? Math.hypot(...way) : way[0]) / divisor;
    });
    return { time, value };
  }

  at({ time, value }, moment) {
    const [first, second, part] = between(time, moment), [a, b] = [value[first], value[second]];
    return a === null || b === null ? a : a + part * (b - a);
  }

  draw(style) {
    const [y, x] = [this.vertical, this.across].map((menu) => this.quantities[menu.value]);
    this.plot.setAttribute("aria-label", `${y.name} over ${x.name}`);
    const { pen, width, height } = penOf(this.canvas, this.plot, style);
    Object.assign(this, { up: this.series(y), along: this.series(x) });
    // At the times of the one with more of them.
    const { time } = this.up.time.length >= this.along.time.length ? this.up : this.along;
    const points = time.map((moment) => [this.at(this.along, moment), this.at(this.up, moment)]);
    const known = points.filter((point) => !point.includes(null));
    this.place = null;
    if (!known.length) {
      pen.fillText("no numbers", LEFT, height / 2);
      return;
    }
    const [[left, right], [low, high]] = [0, 1].map((k) => {
      const values = known.map((point) => point[k]);
      return roomFor(Math.min(...values), Math.max(...values));
    });
    const bottom = height - BELOW, top = 7;
    const down = (value) => bottom - 3 - ((value - low) / (high - low)) * (bottom - top - 3);
    const start = drawLevels(pen, style, low, high, down, width, height);
    const over = (value) => start + ((value - left) / (right - left)) * (width - start - 6);
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const found = ticks(left, right, Math.floor(width / 70));
    apart(found).forEach((text, k) => {
      const last = width - pen.measureText(text).width / 2 - 1;
      pen.fillText(text, Math.min(over(found[k]), last), bottom + 4);
    });
    pen.beginPath();
    let isDown = false;
    for (const point of points) {
      const isThere = !point.includes(null), place = isThere ? [over(point[0]), down(point[1])] : [];
      if (isThere && isDown) pen.lineTo(...place);
      else if (isThere) pen.moveTo(...place);
      isDown = isThere;
    }
    const { looks } = this.player.film;
    pen.lineJoin = "round";
    pen.lineWidth = 1.7;
    pen.strokeStyle = css(seenIn(this.player.look, looks.series[0], looks));
    pen.stroke();
    this.place = (moment) => [over(this.at(this.along, moment)), down(this.at(this.up, moment))];
  }

  // Move the point to where the curve is at a time.
  show(time) {
    this.head.hidden = !this.place;
    if (!this.place) return;
    const [x, y] = this.place(time);
    this.head.style.transform = `translate(${x}px, ${y}px)`;
  }
}
