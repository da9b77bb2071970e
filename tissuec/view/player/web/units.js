// Numbers for people.

// Return by what to divide numbers up to a size, and the unit that they are then in, as messages
// and axes choose it among `units`, which are sizes and names from the smallest to the largest.
function scaled(most, units) {
  if (!(most > 0)) return units.find(([size]) => size === 1);
  return units.filter(([size]) => 0.9995 * size <= most).pop() ?? units[0];
}

const hexed = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);

// Return a colour that is seen on a dark page as well: there it comes closer to the letters.
function seenIn(look, text, looks) {
  if (look !== "dark") return hexed(text);
  return hexed(text).map((value, k) => value + 0.28 * (hexed(looks.ink_dark)[k] - value));
}

// Return the colour at a part of the way through some.
function shadeAt(shades, part) {
  const place = part * (shades.length - 1), low = Math.min(Math.floor(place), shades.length - 2);
  return shades[low].map((value, k) => value + (place - low) * (shades[low + 1][k] - value));
}

const css = (colour) => `rgb(${colour.map((value) => Math.round(255 * value)).join(" ")})`;

// Return a number with so many digits, without an exponent where people need none.
function digits(value, count = 3) {
  if (value === null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(count - 1)
    : size >= 10 ** count ? value.toFixed(0) : String(Number(value.toPrecision(count)));
  return text.replace(/-/g, "−");
}

// Return a number with the decimals that steps of this size have.
function stepped(value, step) {
  const places = Math.max(0, Math.min(9, Math.ceil(-Math.log10(step) - 1e-9)));
  return value.toFixed(places).replace("-", "−").replace(/^−(0\.?0*)$/, "$1");
}

// Return a number, but 0 where it is smaller than a step in which such numbers are stored.
const snapped = (value, step) => (Math.abs(value) < step ? 0 : value);

// Return the largest of 1, 2, 5, 10, … that is no larger.
function round125(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return power * (lead >= 5 - 1e-9 ? 5 : lead >= 2 - 1e-9 ? 2 : 1);
}

// Return round numbers within an interval, at most about so many, and at least two.
function ticks(low, high, count) {
  if (!(high > low)) return [low];
  count = Math.max(1, count);  // a page that is hidden has no room
  let step = round125((high - low) / count);
  while ((high - low) / step > count + 0.5) step = round125(step * 2.5);
  const within = () => {
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1) found.push(i * step);
    return found;
  };
  while (within().length < 2) step = round125(step * 0.6);  // one number is no scale
  return within();
}

// Return numbers at equal distances as texts, with the digits that tell them apart.
function apart(numbers) {
  const step = Math.abs(numbers[1] - numbers[0]), most = Math.max(...numbers.map(Math.abs));
  const count = step > 0 ? Math.max(3, Math.ceil(Math.log10(most / step) - 1e-9) + 1) : 3;
  return numbers.map((value) => digits(Math.abs(value) < step / 2 ? 0 : value, count));
}
