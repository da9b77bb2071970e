"use strict";
// The search shows the tissues whose texts contain all of its words; the address keeps it.

const field = document.getElementById("search");

function show() {
  const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const part of document.querySelectorAll("section.tissue-page")) {
    const fits = words.every((word) => part.dataset.text.includes(word));
    part.hidden = !fits;
    for (const other of document.querySelectorAll("[data-for]")) {
      if (other.dataset.for === part.id) other.hidden = !fits;
    }
    if (fits) count += 1;
  }
  document.getElementById("found").textContent = words.length ? `${count} found` : "";
  document.getElementById("nothing").hidden = count > 0;
}

if (field) {
  field.addEventListener("input", show);
  field.value = new URLSearchParams(location.search).get("search") ?? "";
  show();
}
