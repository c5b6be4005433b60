"use strict";
// A press on a header sorts its table by that column, another one the other way round.
for (const table of document.querySelectorAll("table.sorts")) {
  const heads = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  heads.forEach((head, column) => head.querySelector("button").addEventListener("click", () => {
    const order = head.getAttribute("aria-sort") === "ascending" ? "descending" : "ascending";
    const sign = order === "ascending" ? 1 : -1;
    const key = row => {
      const cell = row.cells[column];
      return "value" in cell.dataset ? Number(cell.dataset.value) : cell.textContent;
    };
    // Numbers come before words, and what is not a number after all of them, whichever way round.
    const rank = value => typeof value === "string" ? 1 : Number.isNaN(value) ? 2 : 0;
    const rows = [...body.rows].map(row => [key(row), row]);
    rows.sort(([a], [b]) => rank(a) - rank(b)
      || (rank(a) === 0 ? sign * (a < b ? -1 : a > b ? 1 : 0)
        : rank(a) === 1 ? sign * a.localeCompare(b, "en", { numeric: true }) : 0));
    body.append(...rows.map(([, row]) => row));
    heads.forEach(other => other.setAttribute("aria-sort", other === head ? order : "none"));
  }));
}
// The slider, and a finger or a mouse on the picture, move the border between two pictures.
for (const figure of document.querySelectorAll("figure.wipe")) {
  const frame = figure.querySelector(".frame");
  const slider = figure.querySelector("input");
  const show = () => frame.style.setProperty("--split", slider.value + "%");
  const follow = event => {
    const box = frame.getBoundingClientRect();
    slider.value = 100 * (event.clientX - box.left) / box.width;
    show();
  };
  slider.addEventListener("input", show);
  frame.addEventListener("pointerdown", event => {
    event.preventDefault();
    frame.setPointerCapture(event.pointerId);
    follow(event);
  });
  frame.addEventListener("pointermove", event => {
    if (event.buttons) follow(event);
  });
  show();
}
