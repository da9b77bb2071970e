// Numbers of the page: the inverse of tissuec/view/player/packing.py.

async function unpack(text, specs) {
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i += 1) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const raw = new Uint8Array(await new Response(stream).arrayBuffer());
  const found = {};
  for (const [name, spec] of Object.entries(specs)) found[name] = decode(raw, spec);
  return found;
}

// Return {data, low, shape, width}; the numbers are low + data, row after row of that width.
function decode(raw, spec) {
  const { shape, low, order, bytes } = spec;
  const width = shape.slice(1).reduce((product, side) => product * side, 1);
  const count = shape[0] * width;
  const data = new { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array }[bytes](count);
  for (let i = 0; i < count; i += 1) {
    let folded = 0;
    for (let plane = bytes - 1; plane >= 0; plane -= 1) {
      folded = (folded << 8) | raw[spec.from + plane * count + i];
    }
    data[i] = (folded >>> 1) ^ -(folded & 1);
  }
  for (let round = 0; round < order; round += 1) {
    for (let i = width; i < count; i += 1) data[i] += data[i - width];
  }
  return { data, low, shape, width };
}

// Return the numbers of one row as a Float32Array, times a factor.
function row(array, number, factor = 1) {
  const { data, low, width } = array;
  const found = new Float32Array(width);
  for (let i = 0; i < width; i += 1) found[i] = (low + data[number * width + i]) * factor;
  return found;
}

// Return x, y, z of each point of a frame; they are packed as all x, all y, all z.
function vectors(array, frame, step, origin) {
  const { data, low, width } = array;
  const count = width / 3, found = new Float32Array(width), start = frame * width;
  for (let axis = 0; axis < 3; axis += 1) {
    const first = start + axis * count;
    for (let i = 0; i < count; i += 1) {
      found[3 * i + axis] = origin[axis] + step * (low + data[first + i]);
    }
  }
  return found;
}

// Return the points of an array between two frames, on a cubic if there is time between them.
function pointsBetween({ film, arrays }, array, [first, second, mixing], origin, span = 0) {
  const places = [first, second].map((frame) => vectors(array, frame, film.step, origin));
  const speeds = span ? [first, second].map((k) => vectors(arrays.velocity, k, film.rate, [0, 0, 0])) : null;
  return mixed(new Float32Array(array.width), places, mixing, speeds, span);
}

// Fill a list with numbers between two lists: on a cubic if there are the speeds at both.
function mixed(found, [from, to], mixing, speeds, span) {
  const left = 1 - mixing;
  for (let i = 0; i < found.length; i += 1) {
    const way = to[i] - from[i];
    const bend = speeds ? mixing * left * (left * (span * speeds[0][i] - way) + mixing * (way - span * speeds[1][i])) : 0;
    found[i] = from[i] + mixing * way + bend;
  }
  return found;
}

// Return tables packed column after column as rows, such as the ends of lines.
function table(array, kind) {
  const { data, low, shape, width } = array;
  const columns = shape[0], found = new kind(columns * width);
  for (let i = 0; i < width; i += 1) {
    for (let c = 0; c < columns; c += 1) found[columns * i + c] = low + data[c * width + i];
  }
  return found;
}

// Return lives in frames, two numbers each; they are packed in thousandths.
function lives(array) {
  const found = table(array, Float32Array);
  for (let i = 0; i < found.length; i += 1) found[i] /= 1000;
  return found;
}

// Return how many things with these lives are there at a moment.
function tally(life, moment) {
  let there = 0;
  for (let i = 0; i < life.length; i += 2) there += life[i] <= moment && moment < life[i + 1];
  return there;
}

// Return the numbers before and behind a place in an ascending list, and how far between.
function between(list, value) {
  let low = 0, high = list.length - 1;
  if (high <= 0 || value <= list[0]) return [0, 0, 0];
  if (value >= list[high]) return [high, high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= value) low = middle;
    else high = middle;
  }
  const length = list[high] - list[low];
  return [low, high, length > 0 ? (value - list[low]) / length : 1];
}
