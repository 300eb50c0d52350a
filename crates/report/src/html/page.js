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
  if (before[0] !== id) state.onChosen?.(id >= 0 ? data.ids[id] : "");
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
  state.listeners = state.listeners.filter(({ at }) => at.isConnected);
  state.listeners.forEach(({ paint }) => paint());
  redraw();
}
function rememberRow(row) {
  if (row.dataset.i === undefined) return;
  const id = Number(row.dataset.i);
  rowsOf.set(id, [...(rowsOf.get(id) ?? []), row]);
}
function forgetRow(row) {
  const id = Number(row.dataset.i);
  if (rowsOf.has(id)) rowsOf.set(id, rowsOf.get(id).filter((other) => other !== row));
}
// The views of tables and figures, by their elements.
const views = new WeakMap();
function bring(root, figures) {
  root.querySelectorAll("tr[data-i]").forEach(rememberRow);
  const of = (what) => [...(root.matches?.(what) ? [root] : []), ...root.querySelectorAll(what)];
  of("div.table").forEach((table) => views.set(table, new TableView(table)));
  of("figure[data-figure]").forEach((host) => views.set(host, new FigureView(host, figures[Number(host.dataset.figure)])));
}
// Puts a fragment (html, ids, figures) into an element. Tables and figures that are alike stay, with what was sorted, filtered,
// hidden, zoomed into and focused, and show what is new; all else is replaced.
function mount(root, fragment) {
  const at = fragment.ids.map((name) => (data.ids.includes(name) ? data.ids.indexOf(name) : data.ids.push(name) - 1));
  for (const figure of fragment.figures) for (const group of figure.groups) for (const panel of group.panels) {
    for (const s of panel.series) if (s.ids) s.ids = s.ids.map((id) => at[id]);
  }
  const box = document.createElement("template");
  box.innerHTML = fragment.html;
  box.content.querySelectorAll("tr[data-i]").forEach((row) => { row.dataset.i = at[Number(row.dataset.i)]; });
  renew(root, box.content, fragment.figures);
  for (let k = panels.length - 1; k >= 0; k--) if (!panels[k].host.isConnected) panels.splice(k, 1);
  choose(state.chosen);
}
function renew(root, content, figures) {
  // Of what is folded the title is the same whatever number of things is in it.
  const title = (e) => e.querySelector(":scope > summary")?.textContent.replace(/ \(\d+\)$/, "");
  const left = [...root.children];
  const parts = [...content.children].map((part) => {
    let found = left.findIndex((old) => views.get(old)?.takes(part, figures));
    if (found < 0 && part.matches("details")) {
      found = left.findIndex((old) => old.matches("details") && title(old) === title(part));
      if (found >= 0) renew(left[found], part, figures);
    } else if (found < 0 && part.matches("summary")) {
      found = left.findIndex((old) => old.matches("summary"));
      if (found >= 0) left[found].textContent = part.textContent;
    }
    return found >= 0 ? { here: left.splice(found, 1)[0] } : { here: part, isNew: true };
  });
  for (const old of left) {
    old.querySelectorAll("tr[data-i]").forEach(forgetRow);
    old.remove();
  }
  // What stays in its place is not touched: it would lose the focus.
  parts.forEach(({ here, isNew }, k) => {
    if (root.children[k] !== here) root.insertBefore(here, root.children[k] ?? null);
    if (isNew) bring(here, figures);
  });
}
(function start() {
  const box = make("div", "");
  box.id = "tip";
  box.hidden = true;
  document.body.append(box);
  bring(document, data.figures);
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
