// What holds the page together: one thing is chosen or hovered, and every table and figure shows it.
const rowsOf = new Map();
function choose(id) {
  const before = [state.chosen, state.hovered];
  state.chosen = id;
  document.querySelectorAll("tr.chosen").forEach((row) => { row.classList.remove("chosen"); row.querySelector(".pick")?.setAttribute("aria-pressed", "false"); });
  const rows = rowsOf.get(id) ?? [];
  rows.forEach((row) => { row.classList.add("chosen"); row.querySelector(".pick")?.setAttribute("aria-pressed", "true"); });
  const bar = document.getElementById("chosen");
  bar.hidden = id < 0;
  if (id >= 0) {
    const figures = panels.filter((view) => view.ids.has(id)).length;
    const count = (n, word) => `${n} ${word}${n === 1 ? "" : "s"}`;
    document.getElementById("chosen-text").textContent = `${data.ids[id]}: in ${count(rows.length, "row")} and ${count(figures, "diagram")}`;
    document.getElementById("chosen-next").hidden = rows.length + figures < 2;
  }
  state.at = -1;
  redraw([...before, id]);
}
function hover(id) {
  if (id === state.hovered) return;
  (rowsOf.get(state.hovered) ?? []).forEach((row) => row.classList.remove("hovered"));
  const before = state.hovered;
  state.hovered = id;
  (rowsOf.get(id) ?? []).forEach((row) => row.classList.add("hovered"));
  if (state.chosen < 0) redraw([before, id]);
}
function nextPlace() {
  const figures = panels.filter((view) => view.ids.has(state.chosen)).map((view) => view.host);
  const places = [...(rowsOf.get(state.chosen) ?? []).filter((row) => !row.hidden && !row.closest("details:not([open])")), ...figures]
    .sort((a, b) => (a.compareDocumentPosition(b) & 4 ? -1 : 1));
  if (!places.length) return;
  state.at = (state.at + 1) % places.length;
  places[state.at].scrollIntoView({ block: "center" });
}
function themed() {
  state.listeners.forEach((listener) => listener("theme"));
  redraw();
}
(function start() {
  const box = make("div", "");
  box.id = "tip";
  box.hidden = true;
  document.body.append(box);
  document.querySelectorAll("tr[data-i]").forEach((row) => {
    const id = Number(row.dataset.i);
    rowsOf.set(id, [...(rowsOf.get(id) ?? []), row]);
  });
  document.querySelectorAll("div.table").forEach((table) => new TableView(table));
  document.querySelectorAll("figure[data-figure]").forEach(drawFigure);
  const theme = document.getElementById("theme"), root = document.documentElement;
  const names = { "": "as the system", dark: "dark", light: "light" };
  theme.addEventListener("click", () => {
    const order = ["", "dark", "light"], next = order[(order.indexOf(root.dataset.theme ?? "") + 1) % 3];
    if (next) root.dataset.theme = next; else delete root.dataset.theme;
    theme.textContent = `theme: ${names[next]}`;
    themed();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", themed);
  document.getElementById("chosen-clear").addEventListener("click", () => choose(-1));
  document.getElementById("chosen-next").addEventListener("click", nextPlace);
  addEventListener("keydown", (event) => { if (event.key === "Escape" && state.chosen >= 0) choose(-1); });
  addEventListener("beforeprint", () => { state.print = true; themed(); });
  addEventListener("afterprint", () => { state.print = false; themed(); });
})();
