// Stress over strain of a bar that keeps its volume, from the numbers of a tissue.

/** How far a curve is drawn where nothing breaks, and at most. */
const USUAL_STRAIN = 0.3;
const LONGEST_STRAIN = 4;

/** The nominal stress at a strain [Pa]: of Fung's law if the tissue stiffens, otherwise of the
 *  neo-Hookean one. */
function stressAt({ young, stiffening }, strain) {
  if (stiffening > 0) return (young / stiffening) * Math.expm1(stiffening * strain);
  const stretch = 1 + strain;
  return (young / 3) * (stretch - stretch ** -2);
}

/** Where the tissue tears: at its breaking strain or its strength, whichever comes first. */
function tearing(numbers) {
  const { breaking, strength } = numbers;
  const longest = Math.min(breaking > 0 ? breaking : Infinity, LONGEST_STRAIN);
  let [low, high] = [0, longest];
  if (!(strength > 0) || stressAt(numbers, high) <= strength) {
    return breaking > 0 && breaking <= LONGEST_STRAIN ? longest : null;
  }
  for (let i = 0; i < 60; i += 1) {
    const middle = (low + high) / 2;
    if (stressAt(numbers, middle) < strength) low = middle;
    else high = middle;
  }
  return high;
}

/** Ticks from 0 to a number, about four of them, and their end. */
function ticksTo(most) {
  const power = 10 ** Math.floor(Math.log10(most / 4));
  const step = [1, 2, 2.5, 5, 10].find((one) => one * power * 4 >= most * (1 - 1e-9)) * power;
  const count = Math.ceil(most / step - 1e-9);
  return Array.from({ length: count + 1 }, (_, n) => n * step);
}

/** The one of several [name, value] whose value is nearest in ratio; null without any. */
function nearest(pairs, value) {
  const apart = ([, other]) => Math.abs(Math.log(other / value));
  return pairs.filter(([, other]) => other > 0).sort((a, b) => apart(a) - apart(b))[0] ?? null;
}
