"use strict";

// Tables sort by the column whose heading is clicked; a second click turns the order round.
const key = (row, column) => row.cells[column].dataset.key ?? row.cells[column].textContent.trim();
const compare = (first, second) => {
  const [a, b] = [Number(first), Number(second)];
  if (first !== "" && second !== "" && !Number.isNaN(a) && !Number.isNaN(b)) return a - b;
  return first.localeCompare(second, undefined, { numeric: true });
};
for (const heading of document.querySelectorAll("table.data thead th")) {
  heading.querySelector("button").addEventListener("click", () => {
    const body = heading.closest("table").tBodies[0];
    const turn = heading.getAttribute("aria-sort") === "ascending" ? -1 : 1;
    for (const other of heading.parentElement.cells) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", turn === 1 ? "ascending" : "descending");
    const column = heading.cellIndex;
    // What is not known stays at the end.
    const known = [], unknown = [];
    for (const row of body.rows) (["nan", ""].includes(key(row, column)) ? unknown : known).push(row);
    known.sort((first, second) => turn * compare(key(first, column), key(second, column)));
    body.append(...known, ...unknown);
  });
}

// The filter hides rows of entries in all tables; the reference always stays.
const filter = document.getElementById("filter");
filter.addEventListener("input", () => {
  const part = filter.elements.name.value.trim().toLowerCase();
  for (const row of document.querySelectorAll("tr[data-name]")) {
    const { kind, gains, name } = row.dataset;
    const box = filter.elements.namedItem(kind === "agent" ? "agent" : gains === "tuned" ? "tuned" : "default");
    row.hidden = !row.classList.contains("reference") && !(box.checked && name.toLowerCase().includes(part));
  }
});
filter.addEventListener("submit", (event) => event.preventDefault());

// Paper cannot be clicked.
const closed = [];
addEventListener("beforeprint", () => {
  for (const item of document.querySelectorAll("details.printed:not([open])")) closed.push(item), (item.open = true);
});
addEventListener("afterprint", () => {
  while (closed.length) closed.pop().open = false;
});
