// Sets as paths of SVG, and words in rows below them. A plot is WIDE by HIGH, stretched to
// the page; strokes keep their width.

const WIDE = 1000;
const HIGH = 100;
const SAMPLES = 24; // points of a curve between two corners, for the eye alone

/** An element with attributes ("on…" are listeners, null is left out) and children. */
function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  return filled(element, attributes, children);
}

function makeSvg(name, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function plot(...layers) {
  return makeSvg("svg", {
    viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none", "aria-hidden": "true",
  }, ...layers);
}

/** Where a coordinate lies along its scale, from 0 to 1. */
function shareOf(scale, place) {
  const [low, high] = scale.bounds;
  return Math.min(Math.max((place - low) / (high - low), 0), 1);
}

/** The points of a set that lie in the range, vertical edges included. */
function pointsOf(set, scale) {
  if (set instanceof Piecewise) return set.xs.map((x, i) => [x, set.ys[i]]);
  const [low, high] = scale.bounds;
  const corners = [low, ...set.corners.filter((x) => low < x && x < high), high];
  return sampled(corners, (x) => set.degree(x));
}

function sampled(places, height) {
  const points = places.slice(1).flatMap((end, i) => {
    const start = places[i];
    return Array.from({ length: SAMPLES }, (_, k) => start + ((end - start) * k) / SAMPLES);
  });
  return [...points, places.at(-1)].map((x) => [x, height(x)]);
}

/** The outline of an envelope; in the gaps between its pieces it lies on the ground. */
function pointsOfPieces(pieces) {
  return pieces.flatMap(([arc, a, b], i) => {
    const top = arc instanceof Line ? [a, b].map((x) => [x, arc.height(x)])
      : sampled([a, b], (x) => arc.height(x));
    const isFirst = pieces[i - 1]?.[2] !== a;
    const isLast = pieces[i + 1]?.[1] !== b;
    return [...(isFirst ? [[a, 0]] : []), ...top, ...(isLast ? [[b, 0]] : [])];
  });
}

function pathOf(points, scale) {
  const to = ([x, y]) => `${(shareOf(scale, x) * WIDE).toFixed(1)},${((1 - y) * HIGH).toFixed(2)}`;
  return `M${points.map(to).join("L")}`;
}

/** A path to be filled: from the ground to the ground, without what lies on it outside. */
function areaOf(points, scale) {
  const isUp = ([, y]) => y > 0;
  const first = Math.max(points.findIndex(isUp) - 1, 0);
  const last = points.length - Math.max([...points].reverse().findIndex(isUp) - 1, 0);
  const up = points.slice(first, last);
  return pathOf([[up[0][0], 0], ...up, [up.at(-1)[0], 0]], scale);
}

/** A dot that stays round in a stretched plot: a line without length, with round ends. */
function dotAt(share, degree) {
  return `M${share * WIDE},${(1 - degree) * HIGH}h0.01`;
}

/** Puts the children of a box, each with a share of its width, into as few rows as they need. */
function layOut(box) {
  const width = box.clientWidth;
  if (!width) return;
  const children = [...box.children].sort((a, b) => a.dataset.share - b.dataset.share);
  const sizes = children.map((child) => child.offsetWidth);
  const rows = [];
  const height = Math.max(0, ...children.map((child) => child.offsetHeight)) + 3;
  children.forEach((child, i) => {
    const wanted = child.dataset.share * width - sizes[i] / 2;
    const left = Math.min(Math.max(wanted, -10), Math.max(width + 10 - sizes[i], -10));
    const free = rows.findIndex((end) => end <= left);
    const row = free < 0 ? rows.length : free;
    rows[row] = left + sizes[i] + 3;
    child.style.left = `${left + sizes[i] / 2}px`; // its middle, which bold letters keep
    child.style.top = `${row * height}px`;
  });
  box.style.height = `${rows.length * height}px`;
}
