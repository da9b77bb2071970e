// Events on the timeline.

const SIGNS = {
  cross: "M3 3L11 11M11 3L3 11",
  bolt: "M8 1.5L4 7.5H10L6 12.5",
  square: "M3.5 3.5H10.5V10.5H3.5Z",
  hollow: "M3 3.5V10.5H11V3.5",
  arrow: "M2.5 7H11M7.5 3.5L11 7L7.5 10.5",
  diamond: "M7 2L12 7L7 12L2 7Z",
  bar: "M7 2.5V11.5",
  dot: "M7 4.5A2.5 2.5 0 1 0 7 9.5A2.5 2.5 0 1 0 7 4.5Z",
  ring: "M7 3.5A3.5 3.5 0 1 0 7 10.5A3.5 3.5 0 1 0 7 3.5Z",
};
// What tells most about a moment at which several things happen.
const RANK = ["cross", "bolt", "diamond", "square", "hollow", "dot", "arrow", "ring", "bar"];
const FILLED = ["square", "dot", "diamond"];
const NEAR = 15;  // pixels within which events share a mark

function sign(name) {
  const fill = FILLED.includes(name) ? ' fill="currentColor"' : "";
  return `<svg viewBox="0 0 14 14" aria-hidden="true"><path d="${SIGNS[name]}"${fill}/></svg>`;
}

// Put marks above the timeline: one for all that happens nearly at once, with words if they fit.
function placeMarks(box, marks, range, clock, seek) {
  const width = box.clientWidth, at = (time) => ((time - range[0]) / (range[1] - range[0] || 1)) * width;
  const groups = [];
  for (const mark of marks) {
    const last = groups[groups.length - 1];
    if (last && at(mark.time) - at(last[0].time) < NEAR) last.push(mark);
    else groups.push([mark]);
  }
  box.replaceChildren();
  const found = groups.map((group) => {
    const kinds = [...new Set(group.map((mark) => mark.kind))];
    const best = RANK.find((name) => group.some((mark) => mark.sign === name));
    const button = document.createElement("button");
    button.type = "button";
    button.tabIndex = -1;  // n and p lead from one to the next
    button.innerHTML = sign(best);
    button.style.left = `${at(group[0].time)}px`;
    button.title = group.map((mark) => `${clock(mark.time)}: ${mark.text}`).join("\n");
    button.addEventListener("click", () => seek(group[0].time));
    box.append(button);
    return { group, button, word: kinds.slice(0, 2).join(", ") + (kinds.length > 2 ? ", …" : "") };
  });
  // Words, the most telling first, where they meet neither signs nor each other.
  const taken = found.map(({ group }) => [at(group[0].time) - 7, at(group[0].time) + 7]);
  const rank = ({ group }) => Math.min(...group.map((mark) => RANK.indexOf(mark.sign)));
  const ordered = found.map((one, i) => [one, i]).sort((a, b) => rank(a[0]) - rank(b[0]));
  for (const [{ button, word }, i] of ordered) {
    const span = document.createElement("span");
    span.textContent = word;
    button.append(span);
    const from = taken[i][1] + 3, to = from + span.offsetWidth + 1;
    // What is read aloud begins with what is seen.
    button.setAttribute("aria-label", `${word}: ${button.title}`);
    if (to > width + 8 || taken.some(([low, high], k) => k !== i && low < to && high > from)) span.remove();
    else taken.push([from, to]);
  }
  return found;
}
