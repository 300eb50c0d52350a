// Tables: a button in each header sorts, a field filters; rows know the id of their thing.
function numeric(text) {
  const plain = text.trim().replace("−", "-");
  if (plain.startsWith("∞")) return Infinity;
  if (plain.startsWith("-∞")) return -Infinity;
  const value = parseFloat(plain.replace(/^[^\d+-]*/, ""));
  return Number.isNaN(value) ? null : value;
}
// `loss<20 maxon -delta`: every word must hold; words with < or > or = compare the column whose name they begin.
function conditions(text, names) {
  return text.toLowerCase().split(/\s+/).filter(Boolean).map((word) => {
    const found = /^([^<>=]+)(<=|>=|<|>|=)(.+)$/.exec(word);
    const column = found ? names.findIndex((n) => n.startsWith(found[1])) : -1;
    if (found && column >= 0) {
      const [, , sign, right] = found, limit = parseFloat(right);
      if (sign === "=" && Number.isNaN(limit)) return (cells) => cells[column].includes(right);
      const holds = { "<": (v) => v < limit, ">": (v) => v > limit, "<=": (v) => v <= limit, ">=": (v) => v >= limit, "=": (v) => v === limit }[sign];
      return (cells) => { const value = numeric(cells[column]); return value !== null && holds(value); };
    }
    if (word.length > 1 && word.startsWith("-")) return (cells) => !cells.some((c) => c.includes(word.slice(1)));
    return (cells) => cells.some((c) => c.includes(word));
  });
}
// Columns that a table is never cut down below, and that the style knows how to cut down to.
const LEAST_SHORT = 5, MOST_SHORT = 24;
// Windows that are narrower show wide tables as blocks: always, or unless all columns were asked for.
const NARROW = 700, WIDE = 1100;
class TableView {
  constructor(box) {
    this.body = box.querySelector("tbody");
    this.rows = [...this.body.rows];
    this.heads = [...box.querySelectorAll("thead th")];
    this.names = this.heads.map((h) => (h.firstChild?.nodeType === 3 ? h.firstChild.data : h.textContent).toLowerCase().trim().replace(/\s+/g, "_"));
    this.cells = this.rows.map((row) => [...row.cells].map((c) => c.textContent.toLowerCase()));
    this.sorted = { column: -1, down: false };
    this.heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      if (!button.textContent.trim()) { head.append(...button.childNodes); return; }
      head.append(button);
      head.setAttribute("aria-sort", "none");
      button.addEventListener("click", () => this.sort(column));
    });
    this.heading = this.heads.map((h) => h.textContent);
    this.rows.forEach((row) => this.tie(row));
    this.box = box;
    this.labelled = 0;
    this.scroll = box.querySelector(".scroll");
    this.main = Number(box.dataset.main ?? 0);
    if (this.rows.length > 7 || this.main) this.bar(box);
    new ResizeObserver(() => {
      if (this.scroll.clientWidth !== this.seen) this.fit();
    }).observe(this.scroll);
    this.fit();
  }
  // As many of the main columns as have room; all where they were asked for. What then is wider than a narrow window
  // becomes a block for each row.
  fit() {
    const { box, scroll } = this, room = scroll.clientWidth;
    if (!room || state.print) return;
    this.seen = room;
    box.className = `table${this.rows.length <= 12 ? " whole" : ""}${this.all ? " all" : ""}`;
    let shown = this.heads.length;
    if (this.main && !this.all) {
      const most = Math.min(this.main, MOST_SHORT), widths = this.heads.map((h) => h.offsetWidth);
      let wide = 0;
      shown = 0;
      while (shown < most && (wide + widths[shown] <= room || shown < LEAST_SHORT)) wide += widths[shown++];
      // A phone shows blocks, which have room for all of the main columns.
      if (innerWidth < NARROW) shown = most;
      box.classList.add(`first-${shown}`);
    }
    const over = () => scroll.scrollWidth > room + 1;
    if (over() && (innerWidth < NARROW || (innerWidth < WIDE && !this.all))) this.blocks(shown);
    else if (over() && !this.all) box.classList.add("tight");
    if (this.more) {
      this.more.textContent = this.all ? "main columns" : `all ${this.heads.length} columns`;
      this.more.setAttribute("aria-pressed", String(Boolean(this.all)));
    }
  }
  blocks(shown) {
    this.shown = shown;
    // Only the cells that are shown need the name of their column.
    const names = this.heads.slice(0, shown).map((h) => h.textContent.trim());
    if (names.length > this.labelled) {
      for (const row of this.rows) for (let k = this.labelled; k < names.length; k++) row.cells[k]?.setAttribute("data-of", names[k]);
      this.labelled = names.length;
    }
    this.box.classList.add("blocks");
  }
  // The cell that names the thing becomes a button, so that the keyboard can choose it too.
  tie(row) {
    if (row.dataset.i === undefined) return;
    const id = Number(row.dataset.i), name = data.ids[id];
    const cell = [...row.cells].find((c) => c.textContent === name);
    if (cell) {
      const button = make("button", name, "pick");
      button.type = "button";
      button.setAttribute("aria-pressed", "false");
      cell.replaceChildren(button);
      for (const c of [cell, this.heads[cell.cellIndex]]) c.classList.add("name");
    }
    row.addEventListener("click", (event) => {
      if (getSelection().toString() && !event.target.closest("button")) return;
      choose(id === state.chosen ? -1 : id);
    });
    row.addEventListener("mouseenter", () => hover(id));
    row.addEventListener("mouseleave", () => hover(-1));
  }
  bar(box) {
    const bar = make("div", "", "bar");
    const label = make("label", "filter ");
    this.field = Object.assign(document.createElement("input"), { type: "search", spellcheck: false, placeholder: this.hint() });
    label.append(this.field);
    this.count = make("span", "", "count");
    this.count.setAttribute("role", "status");
    bar.append(label, this.count);
    if (this.main) {
      this.more = make("button", "", "more");
      this.more.type = "button";
      this.more.addEventListener("click", () => { this.all = !this.all; this.fit(); });
      bar.append(this.more);
    }
    box.prepend(bar);
    this.field.addEventListener("input", () => this.filter());
    this.filter();
  }
  hint() {
    const column = this.heads.findIndex((h, k) => h.classList.contains("n") && /^[a-z]/.test(this.names[k]));
    return column >= 0 ? `a word, -word, ${this.names[column]}<…` : "a word, -word";
  }
  filter() {
    const tests = conditions(this.field.value, this.names);
    let shown = 0;
    this.rows.forEach((row, k) => {
      row.hidden = !tests.every((test) => test(this.cells[k]));
      if (!row.hidden) shown++;
    });
    this.count.textContent = shown === this.rows.length ? `${shown} rows` : `${shown} of ${this.rows.length} rows`;
  }
  // Other rows under the same heads: order, filter and what has the focus stay.
  takes(part) {
    const heads = part.matches("div.table") ? [...part.querySelectorAll("thead th")].map((h) => h.textContent) : null;
    if (!heads || heads.join("\n") !== this.heading.join("\n") || Number(part.dataset.main ?? 0) !== this.main) return false;
    const focused = this.body.contains(document.activeElement) ? document.activeElement.closest("tr")?.dataset.i : undefined;
    this.rows.forEach(forgetRow);
    this.rows = [...part.querySelector("tbody").rows];
    this.cells = this.rows.map((row) => [...row.cells].map((c) => c.textContent.toLowerCase()));
    this.labelled = 0;
    this.body.replaceChildren(...this.rows);
    this.rows.forEach((row) => { rememberRow(row); this.tie(row); });
    this.box.querySelector("caption").replaceChildren(...part.querySelector("caption").childNodes);
    this.scroll.setAttribute("aria-label", part.querySelector(".scroll").getAttribute("aria-label"));
    if (this.field) this.filter();
    else if (this.rows.length > 7) this.bar(this.box);
    if (this.sorted.column >= 0) this.order();
    if (focused !== undefined) this.rows.find((row) => row.dataset.i === focused)?.querySelector(".pick")?.focus();
    // How wide the rows are is asked once they were seen: to ask at once would hold up what comes after this table.
    if (this.box.classList.contains("blocks")) this.blocks(this.shown);
    clearTimeout(this.later);
    this.later = setTimeout(() => this.fit(), 60);
    return true;
  }
  sort(column) {
    this.sorted = { column, down: this.sorted.column === column && !this.sorted.down };
    this.order();
  }
  order() {
    const { column, down } = this.sorted;
    const numbers = this.heads[column].classList.contains("n");
    const keys = this.cells.map((c) => (numbers ? numeric(c[column]) : c[column] || null));
    const order = this.rows.map((_, k) => k).sort((a, b) => {
      // What is unknown stands last in either direction; what is alike keeps its order.
      if (keys[a] === null || keys[b] === null) return (keys[a] === null) - (keys[b] === null) || a - b;
      const less = numbers ? keys[a] - keys[b] || 0 : keys[a] < keys[b] ? -1 : keys[a] > keys[b] ? 1 : 0;
      return (down ? -less : less) || a - b;
    });
    this.body.append(...order.map((k) => this.rows[k]));
    this.heads.forEach((head, k) => head.hasAttribute("aria-sort") && head.setAttribute("aria-sort", k !== column ? "none" : down ? "descending" : "ascending"));
  }
}
