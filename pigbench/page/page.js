"use strict";

const root = document.documentElement;
const systemDark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : systemDark.matches);

const figures = () => Bokeh.documents.flatMap((doc) => doc.roots());

// Models are tagged with the colours of their properties on light and on dark ground.
function paint(figure) {
  for (const model of figure.references()) {
    for (const shades of model.tags ?? []) {
      const pick = ([name, pair]) => [name, pair[isDark() ? 1 : 0]];
      model.setv(Object.fromEntries(Object.entries(shades).map(pick)));
    }
  }
}

function showTheme() {
  document.querySelector(".theme").textContent = isDark() ? "light" : "dark";
  figures().forEach(paint);
}

document.querySelector(".theme").addEventListener("click", () => {
  root.dataset.theme = isDark() ? "light" : "dark";
  showTheme();
});
systemDark.addEventListener("change", showTheme);

// A click on a method hides it in every figure; another shows it again.
for (const button of document.querySelectorAll(".legend button")) {
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", shown);
    for (const figure of figures()) {
      for (const model of figure.references()) {
        if (model.name === button.dataset.method) model.visible = shown;
      }
    }
  });
}

// Numbers in descending order, words in alphabetical order, then reversed; missing values last.
function sort(table, column, header) {
  const body = table.tBodies[0];
  const key = (row) => row.cells[column].dataset.value;
  const rows = [...body.rows];
  const numeric = rows.every((row) => !key(row) || !isNaN(key(row)));
  const before = header.getAttribute("aria-sort");
  const first = numeric ? "descending" : "ascending";
  const other = numeric ? "ascending" : "descending";
  const now = before === first ? other : first;
  const sign = now === "ascending" ? 1 : -1;
  rows.sort((a, b) => {
    const [left, right] = [key(a), key(b)];
    if (!left || !right) return !left - !right;
    return sign * (numeric ? left - right : left.localeCompare(right, undefined, { numeric: true }));
  });
  for (const other of table.tHead.rows[0].cells) other.setAttribute("aria-sort", "none");
  header.setAttribute("aria-sort", now);
  body.append(...rows);
}

for (const button of document.querySelectorAll("thead button")) {
  const header = button.closest("th");
  button.addEventListener("click", () => sort(header.closest("table"), header.cellIndex, header));
}

async function draw() {
  for (const place of document.querySelectorAll(".figure")) {
    const item = JSON.parse(place.querySelector("script").textContent);
    await Bokeh.embed.embed_item(item, place.id);
  }
  showTheme();
  root.dataset.drawn = figures().length;
}

const when = { dateStyle: "long", timeStyle: "short" };
const made = new Date(document.lastModified).toLocaleString(undefined, when);
document.querySelector(".made").textContent = made;
draw();
