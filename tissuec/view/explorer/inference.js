// The inference of tissuec.fuzzy, step by step and in the same order, on the tables of
// tables.py. Coordinates are those of scales, values are in SI units. Nothing is sampled.

const SQRT2 = Math.SQRT2;
const HALF_SQRT_2PI = Math.sqrt(Math.PI / 2);
const SQRT_PI = Math.sqrt(Math.PI);

// --- sets -----------------------------------------------------------------------------------

/** The height at x of the line through two points, x0 < x1. */
function between(x0, y0, x1, y1, x) {
  if (y0 === y1) return y0;
  const height = (y0 * (x1 - x) + y1 * (x - x0)) / (x1 - x0);
  return Math.min(height, Math.max(y0, y1));
}

/** The first place in an ascending list whose number is not below x. */
function bisect(list, x) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] < x) low = middle + 1;
    else high = middle;
  }
  return low;
}

class Piecewise {
  constructor(xs, ys) {
    this.xs = xs;
    this.ys = ys;
    this.corners = xs;
    const top = Math.max(...ys);
    const first = ys.indexOf(top);
    const low = xs[first];
    const high = xs[first + ys.filter((y) => y === top).length - 1];
    this.core = [low, high];
    this.middle = low + (high - low) / 2;
    const last = ys.findLastIndex((y) => y > 0);
    this.support = [
      xs[Math.max(ys.findIndex((y) => y > 0) - 1, 0)], xs[Math.min(last + 1, xs.length - 1)],
    ];
  }

  degree(x) {
    const { xs, ys } = this;
    const i = bisect(xs, x);
    if (i === xs.length) return ys[i - 1];
    if (xs[i] === x) {
      let top = ys[i];
      for (let j = i + 1; xs[j] === x; j++) top = Math.max(top, ys[j]);
      return top;
    }
    return i === 0 ? ys[0] : between(xs[i - 1], ys[i - 1], xs[i], ys[i], x);
  }

  /** The arcs of factor · min(set, cut) that lie above zero. */
  outline(cut, factor) {
    const { xs, ys } = this;
    const arcs = [];
    for (let i = 0; i + 1 < xs.length; i++) {
      const [x0, y0, x1, y1] = [xs[i], ys[i], xs[i + 1], ys[i + 1]];
      if (x0 === x1 || (y0 === 0 && y1 === 0)) continue;
      const [first, last] = [factor * Math.min(y0, cut), factor * Math.min(y1, cut)];
      if (Math.min(y0, y1) < cut && cut < Math.max(y0, y1)) {
        const x = x0 + (x1 - x0) * ((cut - y0) / (y1 - y0));
        if (x0 < x) arcs.push(new Line(x0, x, first, factor * cut));
        if (x < x1) arcs.push(new Line(x, x1, factor * cut, last));
      } else arcs.push(new Line(x0, x1, first, last));
    }
    return arcs;
  }
}

class Gaussian {
  constructor(mean, sigma, { reach, negligible }) {
    this.mean = mean;
    this.sigma = sigma;
    this.reach = reach;
    this.core = [mean, mean];
    this.middle = mean;
    const told = sigma * Math.sqrt(-2 * Math.log(negligible));
    this.corners = [mean - told, mean, mean + told];
    this.support = [mean - reach * sigma, mean + reach * sigma];
  }

  degree(x) {
    const z = (x - this.mean) / this.sigma;
    return Math.abs(z) < this.reach ? Math.exp(-0.5 * z * z) : 0;
  }

  /** A flat top and flanks, divided at the mean and the inflections. */
  outline(cut, factor, low, high) {
    const { mean, sigma } = this;
    const flat = sigma * Math.sqrt(-2 * Math.log(cut)); // half width of the flat top
    const distances = [0, flat, sigma, this.support[1] - mean].sort((a, b) => a - b);
    const places = [...distances.map((d) => mean - d).reverse(), ...distances.map((d) => mean + d)]
      .map((x) => Math.min(Math.max(x, low), high));
    const arcs = [];
    for (let i = 0; i + 1 < places.length; i++) {
      const [a, b] = [places[i], places[i + 1]];
      if (a === b) continue;
      const isFlat = Math.abs(a + (b - a) / 2 - mean) < flat;
      arcs.push(isFlat ? new Line(a, b, factor * cut, factor * cut)
        : new Bell(a, b, mean, sigma, factor));
    }
    return arcs;
  }
}

class Powered {
  constructor(base, exponent, limits) {
    this.base = base;
    this.exponent = exponent;
    this.core = base.core;
    this.middle = base.middle;
    this.support = base.support;
    const isBell = base instanceof Gaussian; // raised to a power it is another bell
    this.corners = (isBell ? new Gaussian(base.mean, base.sigma / exponent ** 0.5, limits) : base)
      .corners;
  }

  degree(x) {
    return this.base.degree(x) ** this.exponent;
  }
}

function setOf(row, earlier, limits) {
  if (row.xs) return new Piecewise(row.xs, row.ys);
  if (row.sigma) return new Gaussian(row.mean, row.sigma, limits);
  return new Powered(earlier[row.base], row.exponent, limits);
}

// --- arcs -----------------------------------------------------------------------------------

class Line {
  constructor(start, end, first, last) {
    Object.assign(this, { start, end, first, last });
  }

  height(x) {
    return between(this.start, this.first, this.end, this.last, x);
  }

  /** The area below from a to b, and its moment about a. */
  integrals(a, b) {
    const [ya, yb, width] = [this.height(a), this.height(b), b - a];
    return [(width * (ya + yb)) / 2, (width * width * (ya + 2 * yb)) / 6];
  }
}

/** A part of a bell without its mean or an inflection inside. */
class Bell {
  constructor(start, end, mean, sigma, peak) {
    Object.assign(this, { start, end, mean, sigma, peak });
  }

  height(x) {
    const z = (x - this.mean) / this.sigma;
    return this.peak * Math.exp(-0.5 * z * z);
  }

  slope(x) {
    return ((this.mean - x) / this.sigma ** 2) * this.height(x);
  }

  integrals(a, b) {
    const { mean, sigma, peak } = this;
    const [near, far] = [Math.abs(a - mean), Math.abs(b - mean)].sort((p, q) => p - q);
    const tails = erfc(near / sigma / SQRT2) - erfc(far / sigma / SQRT2);
    const area = peak * sigma * HALF_SQRT_2PI * tails;
    const aboutMean = sigma ** 2 * (this.height(a) - this.height(b));
    return [area, aboutMean + (mean - a) * area];
  }
}

/** The complementary error function of x >= 0: a series of positive terms below 2, a continued
 *  fraction above; both to nearly the last digit, also of the smallest tails. */
function erfc(x) {
  if (x < 2) {
    let term = x;
    let sum = x;
    for (let n = 1; term > sum * 1e-17; n++) sum += term *= (2 * x * x) / (2 * n + 1);
    return 1 - (2 / SQRT_PI) * Math.exp(-x * x) * sum;
  }
  let fraction = x;
  for (let k = 160; k > 0; k--) fraction = x + k / 2 / fraction;
  return Math.exp(-x * x) / SQRT_PI / fraction;
}

/** Where two arcs that both span [a, b] cross inside it. */
function crossings(one, other, a, b) {
  const [oneIsLine, otherIsLine] = [one instanceof Line, other instanceof Line];
  let found;
  if (oneIsLine && otherIsLine) found = crossingsOfLines(one, other, a, b);
  else if (oneIsLine) found = crossingsOfBellAndLine(other, one, a, b);
  else if (otherIsLine) found = crossingsOfBellAndLine(one, other, a, b);
  else found = crossingsOfBells(one, other);
  return found.filter((x) => a < x && x < b);
}

function crossingsOfLines(one, other, a, b) {
  const left = one.height(a) - other.height(a);
  const right = one.height(b) - other.height(b);
  if (left < 0 === right < 0) return [];
  return [a + (b - a) * (left / (left - right))];
}

/** Solves for equal logarithms, a quadratic in the distance from the first mean. */
function crossingsOfBells(one, other) {
  const apart = other.mean - one.mean;
  const [p, q] = [1 / one.sigma ** 2, 1 / other.sigma ** 2];
  const [squared, linear] = [(q - p) / 2, -apart * q];
  const constant = Math.log(one.peak / other.peak) + (apart * apart * q) / 2;
  const root = linear * linear - 4 * squared * constant;
  if (root < 0 || (linear === 0 && (squared === 0 || constant === 0))) return [];
  const isNegative = linear < 0 || Object.is(linear, -0);
  const larger = -(linear + (isNegative ? -1 : 1) * Math.sqrt(root)) / 2;
  return [[larger, squared], [constant, larger]]
    .filter(([, below]) => below !== 0)
    .map(([above, below]) => one.mean + above / below);
}

/** Bisects on either side of the one place where bell and line can be parallel. */
function crossingsOfBellAndLine(bell, line, a, b) {
  const rise = (line.last - line.first) / (line.end - line.start);
  const distance = (x) => bell.height(x) - line.height(x);
  const parallel = rootOf((x) => bell.slope(x) - rise, a, b);
  const places = parallel === null ? [a, b] : [a, parallel, b];
  const roots = places.slice(1).map((end, i) => rootOf(distance, places[i], end));
  return roots.filter((x) => x !== null);
}

/** A root to the last digit, or null where the ends have one sign. */
function rootOf(f, a, b) {
  if (f(a) < 0 === f(b) < 0) return null;
  const isNegative = f(a) < 0;
  for (let x = a + (b - a) / 2; a < x && x < b; x = a + (b - a) / 2) {
    if (f(x) < 0 === isNegative) a = x;
    else b = x;
  }
  return a;
}

// --- the centre of gravity ------------------------------------------------------------------

/** The upper envelope of clipped or scaled sets: [arc, from, to], from left to right. */
function envelope(terms, low, high, implication) {
  const arcs = terms.flatMap(([set, degree]) => (implication === "minimum"
    ? set.outline(degree, 1, low, high)
    : set.outline(1, degree, low, high)));
  const waiting = [...arcs].sort((one, other) => other.start - one.start);
  const ends = [...new Set(arcs.flatMap((arc) => [arc.start, arc.end]))].sort((a, b) => a - b);
  const pieces = [];
  let present = [];
  for (let i = 0; i + 1 < ends.length; i++) {
    const [a, b] = [ends[i], ends[i + 1]];
    present = present.filter((arc) => arc.end > a);
    while (waiting.length && waiting.at(-1).start === a) present.push(waiting.pop());
    if (present.length === 1) pieces.push([present[0], a, b]);
    else if (present.length) pieces.push(...highest(present, a, b));
  }
  return pieces;
}

/** The highest of arcs that all span [a, b], divided where they cross. */
function highest(arcs, a, b) {
  const cuts = new Set([a, b]);
  arcs.forEach((one, i) => arcs.slice(i + 1).forEach((other) => {
    crossings(one, other, a, b).forEach((x) => cuts.add(x));
  }));
  const places = [...cuts].sort((x, y) => x - y);
  return places.slice(1).map((end, i) => {
    const start = places[i];
    const middle = start + (end - start) / 2;
    const top = arcs.reduce((best, arc) => (arc.height(middle) > best.height(middle) ? arc : best));
    return [top, start, end];
  });
}

function centreOfGravity(pieces, low, high) {
  let area = 0;
  let moment = 0;
  for (const [arc, a, b] of pieces) {
    const [part, aboutStart] = arc.integrals(a, b);
    area += part;
    moment += aboutStart + part * (a - low);
  }
  return Math.min(Math.max(low + moment / area, low), high);
}

/** The mean of the middles of the words' cores, weighted by their degrees. */
function weightedMean(terms, low, high) {
  let total = 0;
  let moment = 0;
  for (const [set, degree] of terms) {
    total += degree;
    moment += degree * (set.middle - low);
  }
  return Math.min(Math.max(low + moment / total, low), high);
}

/** How far a fact has gone from the shoulder of an outer word to the end of its scale, 0 to 1. */
function progressOf(set, place, [low, high]) {
  const [start, end] = set.core;
  if (start <= low && low < end && place < end) return (end - place) / (end - low);
  if (start < high && high <= end && place > start) return (place - start) / (high - start);
  return 0;
}

/** How places of a property are stretched, so that the middles of outer words come to where
 *  these begin to be fully true: [place, where it counts], ascending. */
function stretchingOf(sets, [low, high]) {
  const ends = (list, better) => list.reduce((a, b) => (a && !better(b, a) ? a : b), undefined);
  const first = ends(
    sets.filter(({ core: [a, b] }) => a <= low && low < b), (a, b) => a.core[1] > b.core[1] || (a.core[1] === b.core[1] && a.support[1] > b.support[1]),
  );
  const last = ends(
    sets.filter(({ core: [a, b] }) => a < high && high <= b), (a, b) => a.core[0] < b.core[0] || (a.core[0] === b.core[0] && a.support[0] < b.support[0]),
  );
  let [left, right] = [low, high];
  const before = [[low, low]];
  const behind = [[high, high]];
  if (first && first.core[1] < first.support[1]) {
    before.push([first.middle, first.core[1]]);
    [, left] = first.support;
  }
  if (last && last.support[0] < last.core[0]) {
    behind.unshift([last.middle, last.core[0]]);
    [right] = last.support;
  }
  if (before.at(-1)[1] >= behind[0][1]) return [[low, low], [high, high]];
  return [...before, ...(left <= right ? [[left, left], [right, right]] : []), ...behind];
}

function stretched(place, anchors) {
  for (let i = 0; i + 1 < anchors.length; i++) {
    const [[x0, y0], [x1, y1]] = [anchors[i], anchors[i + 1]];
    if (x0 <= place && place <= x1 && x0 < x1 && (x0 !== y0 || x1 !== y1)) {
      return (y0 * (x1 - place) + y1 * (place - x0)) / (x1 - x0);
    }
  }
  return place;
}

/** The mean of what each rule concludes; words move towards the nearer end. */
function gradualMean(sayings, low, high) {
  const centre = low + (high - low) / 2;
  let total = 0;
  let moment = 0;
  for (const [{ middle }, degree, progress] of sayings) {
    const isCentral = Math.abs(middle - centre) <= 1e-9 * (high - low);
    const end = middle < centre ? low : high;
    const place = isCentral ? middle : middle + progress * (end - middle);
    total += degree;
    moment += degree * (place - low);
  }
  return Math.min(Math.max(low + moment / total, low), high);
}

// --- scales ---------------------------------------------------------------------------------

/** The coordinate of a value; null where it lies outside the range by more than rounding. */
function toScale(scale, value) {
  if (scale.log && !(value > 0)) return null;
  let place = scale.log ? Math.log(value) : value;
  const near = scale.bounds.find((end) => Math.abs(place - end) <= scale.rounding);
  if (near !== undefined) place = near;
  return scale.bounds[0] <= place && place <= scale.bounds[1] ? place : null;
}

/** The value at a coordinate; rounding never carries it out of the range. */
function fromScale(scale, place) {
  const value = scale.log ? Math.exp(place) : place;
  return Math.min(Math.max(value, scale.low), scale.high);
}

// --- rules ----------------------------------------------------------------------------------

/** Makes sets of rows, and finds what each block of rules asks about and bears on. */
function prepare(tables) {
  const sets = [];
  for (const row of tables.shapes) sets.push(setOf(row, sets, tables));
  const byKey = (list) => new Map(list.map((one) => [one.key, one]));
  const system = {
    faintest: tables.faintest,
    negligible: tables.negligible,
    sets,
    properties: byKey(tables.properties),
    quantities: byKey(tables.quantities),
    bases: new Map(),
  };
  for (const rules of tables.rules) system.bases.set(rules.key, baseOf(rules, system));
  return system;
}

function baseOf(rules, system) {
  const atoms = rules.rules.map((rule) => [...atomsOf(rule.condition)]);
  const corners = new Map([...system.properties.keys()].map((key) => [key, new Set()]));
  for (const [, property, shape] of atoms.flat()) {
    system.sets[shape].corners.forEach((x) => corners.get(property).add(x));
  }
  const isGradual = rules.operators.result === "gradual mean";
  const used = (key) => atoms.flat().filter((atom) => atom[1] === key)
    .map((atom) => system.sets[atom[2]]);
  const stretchings = new Map([...system.properties].map(([key, { bounds }]) => [
    key, isGradual ? stretchingOf(used(key), bounds) : [],
  ]));
  const bearings = new Map([...system.quantities.keys()].map((key) => [key, []]));
  rules.rules.forEach((rule, number) => rule.conclusions.forEach((said) => {
    bearings.get(said.quantity).push({ rule: number, word: said.word, shape: said.shape });
  }));
  const ascending = ([key, places]) => [key, [...places].sort((a, b) => a - b)];
  return { ...rules, atoms, corners: new Map([...corners].map(ascending)), stretchings, bearings };
}

/** Every test of a condition in written order. */
function* atomsOf(condition) {
  if (condition[0] === "is") yield condition;
  else for (const operand of condition.slice(1)) yield* atomsOf(operand);
}

/** For each test whether an odd number of "not" stands before it. */
function* negationsOf(condition, isNot = false) {
  const [kind, ...operands] = condition;
  if (kind === "is") yield isNot;
  else for (const one of operands) yield* negationsOf(one, (kind === "not") !== isNot);
}

/** Where a place counts in rules; one that is a corner up to rounding is the corner. */
function countingPlace(base, scale, at) {
  const anchors = base.stretchings.get(scale.key);
  const atWord = anchors.find(([x]) => Math.abs(x - at) <= scale.rounding);
  if (atWord) return atWord[1];
  const place = stretched(at, anchors);
  const corners = base.corners.get(scale.key);
  const i = bisect(corners, place);
  for (const corner of corners.slice(Math.max(i - 1, 0), i + 1)) {
    if (Math.abs(corner - place) <= scale.rounding) return corner;
  }
  return place;
}

const JOINS = {
  minimum: Math.min,
  maximum: Math.max,
  product: (a, b) => a * b,
  "probabilistic sum": (a, b) => a + (1 - a) * b,
};

/** The coordinate of a fact. */
function placeOf(scale, value) {
  const place = toScale(scale, value);
  if (place === null) throw new RangeError(`${scale.name} = ${value} is outside its range`);
  return place;
}

/** How true a condition is; degrees of its tests are taken from the front of a list. */
function degreeOf(condition, degrees, operators) {
  const [kind, ...operands] = condition;
  if (kind === "is") return degrees.shift();
  const known = operands.map((operand) => degreeOf(operand, degrees, operators));
  if (kind === "not") return 1 - known[0];
  const join = JOINS[operators[kind === "and" ? "conjunction" : "disjunction"]];
  return known.reduce((a, b) => join(a, b));
}

/** What one rule says: its degree, those of its tests (null if unsaid), and what is missing. */
function verdictOf(system, base, number, places) {
  const atoms = base.atoms[number];
  const counting = atoms.map(([, property]) => (places.has(property)
    ? countingPlace(base, system.properties.get(property), places.get(property)) : null));
  const degrees = atoms.map(([, , shape], i) => (counting[i] === null
    ? null : system.sets[shape].degree(counting[i])));
  const missing = atoms.filter((_, i) => degrees[i] === null).map(([, property]) => property);
  if (missing.length) return { degree: 0, degrees, missing: [...new Set(missing)] };
  const rule = base.rules[number];
  const truth = degreeOf(rule.condition, [...degrees], base.operators);
  const strength = rule.weight * truth;
  const gone = [...negationsOf(rule.condition)].map((isNot, i) => (isNot ? 0 : progressOf(
    system.sets[atoms[i][2]], counting[i], system.properties.get(atoms[i][1]).bounds,
  )));
  const progress = gone.reduce((a, b) => a + b, 0) / gone.length;
  const degree = strength >= system.faintest ? strength : 0;
  return { degree, degrees, missing: [], progress, holds: truth >= system.negligible };
}

/** The places of facts: a Map from property to coordinate. Throws where one is out of range. */
function placesOf(system, base, facts) {
  return new Map([...facts].map(([key, value]) => [
    key, placeOf(system.properties.get(key), value),
  ]));
}

/** What rules say about facts, a Map from property to value: verdicts and answers by quantity. */
function infer(system, base, facts) {
  const places = placesOf(system, base, facts);
  const verdicts = base.rules.map((_, number) => verdictOf(system, base, number, places));
  const keys = [...system.quantities.keys()];
  const answers = new Map(keys.map((key) => [key, answerOf(system, base, key, verdicts)]));
  return { places, verdicts, answers };
}

/** The number for one quantity: from "rules", "otherwise", or nothing ("none"). */
function answerOf(system, base, key, verdicts) {
  const quantity = system.quantities.get(key);
  const bearings = base.bearings.get(key);
  const strongest = new Map(); // by number of the set, so that equal sets count once
  const sayings = [];
  const isSpoken = bearings.some(({ rule }) => verdicts[rule].holds);
  for (const { rule, shape } of bearings) {
    const { degree, progress } = verdicts[rule];
    if (isSpoken && degree > 0) {
      strongest.set(shape, Math.max(degree, strongest.get(shape) ?? 0));
      sayings.push([system.sets[shape], degree, progress]);
    }
  }
  const otherwise = base.otherwise[key];
  if (!strongest.size && otherwise) {
    const value = fromScale(quantity, system.sets[otherwise.shape].middle);
    return { source: "otherwise", value, strongest, pieces: [] };
  }
  if (!strongest.size) return { source: "none", value: null, strongest, pieces: [] };
  const [low, high] = quantity.bounds;
  const terms = [...strongest].map(([shape, degree]) => [system.sets[shape], degree]);
  const isCentre = base.operators.result === "centre of gravity";
  const pieces = isCentre ? envelope(terms, low, high, base.operators.implication) : [];
  const results = {
    "centre of gravity": () => centreOfGravity(pieces, low, high),
    "weighted mean": () => weightedMean(terms, low, high),
    "gradual mean": () => gradualMean(sayings, low, high),
  };
  const place = results[base.operators.result]();
  return { source: "rules", value: fromScale(quantity, place), strongest, pieces };
}

/** Why nothing is concluded, in the words of the compiler. */
function reasonOf(base, key, verdicts) {
  const bearings = base.bearings.get(key);
  if (!bearings.length) return `no rule of ${base.name} concludes it`;
  if (bearings.some(({ rule }) => verdicts[rule].degree > 0)) {
    return `no rule of ${base.name} holds to more than a negligible degree for these words`;
  }
  const missing = [...new Set(bearings.flatMap(({ rule }) => verdicts[rule].missing))];
  if (missing.length) {
    const first = bearings.find(({ rule }) => verdicts[rule].missing.length);
    return `no rule of ${base.name} fires; the tissue does not say: ${missing.join(", ")} `
      + `(the first rule that uses it is at ${base.rules[first.rule].place})`;
  }
  return `no rule of ${base.name} fires for these words`;
}
