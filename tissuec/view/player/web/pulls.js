// Resultant forces with their names and numbers, drawn over the picture.

const LETTER = 7, LINE = 15;  // pixels: width and height of letters
const LABELLED = ["triad", "ruler", "value", "handle"];  // what labels keep clear of

class Pulls {
  constructor(box, film, arrays) {
    Object.assign(this, { box, film, arrays });
    box.innerHTML = film.pulls.map(() => '<g><path/><text dy="0.32em"/></g>').join("");
  }

  // Return three numbers of a point or force between two frames.
  at(array, i, count, [frame, next, mixing], step, origin) {
    const { data, low, width } = array;
    return [0, 1, 2].map((k) => {
      const [a, b] = [frame, next].map((row) => low + data[row * width + k * count + i]);
      return origin[k] + step * (a + mixing * (b - a));
    });
  }

  draw(moment, camera, isShown) {
    const { film, arrays, box } = this, { clientWidth: wide, clientHeight: high } = box.parentElement;
    box.toggleAttribute("hidden", !isShown);
    if (!isShown || !film.pulls.length) return;
    const frame = Math.min(Math.floor(moment), film.times.length - 1), next = Math.min(frame + 1, film.times.length - 1);
    const between = [frame, next, next > frame ? moment - frame : 0], points = arrays.position.width / 3;
    const { rules } = film, step = film.most.pull / film.steps.pull, reach = (rules.pull * film.view.size) / film.most.pull;
    const placing = new Placing(wide, high, boxesIn(box.parentElement, LABELLED.map(byId))), labels = [];
    film.pulls.forEach(({ name, point, life, shown: [divisor, unit] }, i) => {
      const group = box.children[i], [path, text] = group.children;
      const force = this.at(arrays.pulls, i, film.pulls.length, between, step, [0, 0, 0]), size = Math.hypot(...force);
      const isThere = life[0] <= moment && moment < life[1] && size > rules.least * film.most.pull;
      group.toggleAttribute("hidden", !isThere);
      if (!isThere) return;
      const foot = this.at(arrays.position, point, points, between, film.step, film.origin);
      const [a, b] = [foot, foot.map((value, k) => value + reach * force[k])].map((place) => {
        const [x, y] = camera.seen(place);
        return [((1 + x) * wide) / 2, ((1 - y) * high) / 2];
      });
      const inside = (value, most) => Math.max(rules.edge, Math.min(most - rules.edge, value));
      const tip = [inside(b[0], wide), inside(b[1], high)], isCut = tip[0] !== b[0] || tip[1] !== b[1];
      const long = Math.hypot(tip[0] - a[0], tip[1] - a[1]) || 1, u = (tip[0] - a[0]) / long, v = (tip[1] - a[1]) / long;
      const head = Math.min(9, 0.6 * long), wing = (away, side) => `${tip[0] - away * u - side * v},${tip[1] - away * v + side * u}`;
      const mark = isCut ? `M${wing(head + 4, 5)}L${wing(head + 4, -5)}` : "";  // the arrow is longer than the picture
      path.setAttribute("d", `M${a[0]},${a[1]}L${wing(head, 0)}M${wing(0, 0)}L${wing(head, 4)}L${wing(head, -4)}Z${mark}`);
      text.textContent = `${name} ${digits(size / divisor)} ${unit}`;
      labels.push({ text, tip: [tip[0], tip[1] + 10 * v], isRight: u >= 0 });
    });
    for (const { text, tip, isRight } of labels) {
      placing.rivals = labels.filter((other) => other.text !== text).map((other) => other.tip);
      const [left, middle] = placing.beside(tip, [LETTER * text.textContent.length, LINE], isRight, 6);
      text.setAttribute("x", left);
      text.setAttribute("y", middle);
    }
  }
}
