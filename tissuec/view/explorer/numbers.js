// Numbers with units, read and shown as the language and its messages do.

const STEP = /([*/·]?)([\p{L}]+|%)(?:\^(-?\d+))?/uy;
const WRITTEN = /^([+-]?)\s*(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*(.*)$/;

/** What one of a unit is in SI, and its dimension; null if it is none. */
function readUnit(text, units) {
  const compact = text.replaceAll(" ", "");
  let factor = 1;
  const dimension = [0, 0, 0];
  let position = 0;
  while (position < compact.length) {
    STEP.lastIndex = position;
    const step = STEP.exec(compact);
    if (!step || position > 0 !== Boolean(step[1]) || !(step[2] in units)) return null;
    position = STEP.lastIndex;
    const [size, ...kind] = units[step[2]];
    const exponent = Number(step[3] ?? 1) * (step[1] === "/" ? -1 : 1);
    factor *= size ** exponent;
    kind.forEach((power, i) => { dimension[i] += power * exponent; });
  }
  return { factor, dimension };
}

/** The value in SI of what stands in a number field; an Error says what is wrong with it. */
function readNumber(text, scale, units) {
  const found = WRITTEN.exec(text.trim());
  const sample = scale.unit ? `0.5 ${scale.unit}` : "0.5";
  if (!found) throw new Error(`write a number, such as ${sample}`);
  const [, sign, digits, unitText] = found;
  const amount = Number(digits) * (sign === "-" ? -1 : 1);
  if (!Number.isFinite(amount)) throw new Error("this number is too large");
  if (!unitText) {
    if (scale.dimension.every((power) => power === 0)) return amount;
    throw new Error(`write a unit, such as ${sample}`);
  }
  const unit = readUnit(unitText, units);
  if (!unit) throw new Error(`"${unitText}" is not a unit`);
  if (unit.dimension.some((power, i) => power !== scale.dimension[i])) {
    throw new Error(`${scale.name} is ${scale.kind}; ${unitText} is not`);
  }
  return amount * unit.factor;
}

/** As Python's format code g. */
function general(value, digits) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = Number(exponent);
  if (power < -4 || power >= digits) {
    const sign = power < 0 ? "-" : "+";
    return `${trimmed(mantissa)}e${sign}${String(Math.abs(power)).padStart(2, "0")}`;
  }
  return trimmed(value.toFixed(Math.max(digits - 1 - power, 0)));
}

function trimmed(digits) {
  return digits.includes(".") ? digits.replace(/\.?0+$/, "") : digits;
}

/** A value for people, such as "3.16 mN*s/m"; units from the smallest to the largest. */
function show(value, units, digits = 3) {
  let [factor, unit] = units[0];
  const plain = units.filter(([, name]) => !name.startsWith("m^3"));  // 0 of a volume is in litres
  if (value === 0) [factor, unit] = plain.find(([size]) => size === 1) ?? plain.at(-1) ?? units[0];
  for (const [size, name, least = size * (1 - 0.5 * 10 ** -digits)] of value === 0 ? [] : units) {
    if (Math.abs(value) >= least) [factor, unit] = [size, name];
  }
  // 1050 and not 1.05e+03.
  const rounded = Number((value / factor).toPrecision(digits));
  return `${general(rounded, Math.max(digits, 6))} ${unit}`.trimEnd();
}

/** The text of a value at a share of a scale, no longer than a slider can be set to. */
function textAt(scale, share) {
  const [low, high] = scale.bounds;
  const place = share <= 0 ? low : share >= 1 ? high : low + (high - low) * share;
  const inUnit = (share <= 0 ? scale.low : share >= 1 ? scale.high : fromScale(scale, place))
    / scale.factor;
  const isEnd = share <= 0 || share >= 1;
  return withUnit(isEnd ? Number(inUnit.toPrecision(15)) : rounded(scale, inUnit), scale);
}

function rounded(scale, inUnit) {
  const step = (scale.bounds[1] - scale.bounds[0]) / 1000;
  if (scale.log) {
    return Number(inUnit.toPrecision(Math.min(Math.max(Math.ceil(-Math.log10(step)) + 1, 3), 17)));
  }
  const decimals = Math.ceil(-Math.log10(step / scale.factor));
  return decimals > 0 ? Number(inUnit.toFixed(Math.min(decimals, 100))) : Math.round(inUnit);
}

function withUnit(number, scale) {
  return scale.unit ? `${number} ${scale.unit}` : String(number);
}
