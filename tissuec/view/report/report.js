"use strict";
// A link into a folded part unfolds it, and a click on a command line selects it.

function unfold() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  for (let part = target; part; part = part.parentElement) {
    if (part instanceof HTMLDetailsElement) part.open = true;
  }
  target.scrollIntoView({ block: target.classList.contains("line") ? "center" : "start" });
}

addEventListener("hashchange", unfold);
if (location.hash) unfold();

for (const command of document.querySelectorAll("pre.command")) {
  command.addEventListener("click", () => getSelection().selectAllChildren(command));
}
