"use strict";
// Draws a figure's panels with uPlot, which gives axes, zoom and resizing; marks, stripes and labels are drawn here as
// the SVG draws them. Every mark knows the id of its thing; hovering and choosing go through `state`.
const data = JSON.parse(document.getElementById("data").textContent);
const state = { chosen: -1, hovered: -1, listeners: [], print: false };
const panels = [];

function dark() {
  if (state.print) return false;
  const theme = document.documentElement.dataset.theme;
  return theme ? theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}
const ink = () => dark()
  ? { text: "#d7dde4", grid: "#262d36", minor: "#1b2129", frame: "#8c949e", ground: "#12161b", faint: "#8c949e" }
  : { text: "#1c2126", grid: "#e2e2e2", minor: "#f1f1f1", frame: "#5a5a5a", ground: "#ffffff", faint: "#555555" };
const tone = (k) => { const [area, line, edge] = data.tones[dark() ? "dark" : "light"][k]; return { area, line, edge }; };
const FONT = 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif';

function show(value) {
  if (value === null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  return size < -4 || size >= 7 ? value.toExponential(3) : String(Number(value.toPrecision(4)));
}
function shape(ctx, kind, x, y, r) {
  const to = (points) => points.forEach(([px, py], k) => (k ? ctx.lineTo(x + px * r, y + py * r) : ctx.moveTo(x + px * r, y + py * r)));
  ctx.beginPath();
  switch (kind) {
    case "Square": ctx.rect(x - 0.9 * r, y - 0.9 * r, 1.8 * r, 1.8 * r); break;
    case "Triangle": to([[0, -1.15], [1.05, 0.8], [-1.05, 0.8]]); ctx.closePath(); break;
    case "Down": to([[0, 1.15], [1.05, -0.8], [-1.05, -0.8]]); ctx.closePath(); break;
    case "Left": to([[-1.15, 0], [0.8, 1.05], [0.8, -1.05]]); ctx.closePath(); break;
    case "Diamond": to([[0, -1.25], [1.25, 0], [0, 1.25], [-1.25, 0]]); ctx.closePath(); break;
    case "Cross": to([[-0.9, -0.9], [0.9, 0.9]]); to([[-0.9, 0.9], [0.9, -0.9]]); return false;
    case "Plus": to([[-1.1, 0], [1.1, 0]]); to([[0, -1.1], [0, 1.1]]); return false;
    default: ctx.arc(x, y, r, 0, 7);
  }
  return true;
}
function point(ctx, s, x, y, r, scale) {
  const t = tone(s.tone);
  const closed = shape(ctx, s.shape, x, y, r);
  ctx.lineWidth = (closed && !s.hollow ? 0.8 : 1.6) * scale;
  ctx.strokeStyle = closed && !s.hollow ? t.edge : t.line;
  if (closed) { ctx.fillStyle = s.hollow ? ink().ground : t.area; ctx.fill(); }
  ctx.stroke();
}
const idOf = (s, k) => (!s.ids ? -1 : s.ids.length === 1 ? s.ids[0] : s.ids[k] ?? -1);
const noteOf = (s, k) => s.notes?.[k] ?? (idOf(s, k) >= 0 ? data.ids[idOf(s, k)] : s.name ?? "");

class PanelView {
  constructor(panel, figure, host) {
    Object.assign(this, { host, hidden: new Set(), marks: [] });
    this.take(panel, figure);
    this.reset = document.createElement("button");
    this.reset.type = "button";
    this.reset.className = "reset";
    this.reset.textContent = "whole range";
    this.reset.hidden = true;
    this.reset.addEventListener("click", () => this.zoomOut());
    host.append(this.reset);
    this.make();
    panels.push(this);
  }
  take(panel, figure) {
    Object.assign(this, { panel, figure });
    this.ids = new Set(panel.series.flatMap((s) => s.ids ?? []));
    this.full = { x: panel.x.range, y: panel.y.range };
    const overDots = new Set(panel.series.filter((s) => s.mark === "dots").map((s) => s.tone));
    for (const s of panel.series) s.strong = overDots.has(s.tone);
  }
  // Other values on the same axes: what was zoomed into and what was hidden stays.
  update(panel, figure) {
    const zoomed = !this.reset.hidden, { x, y } = this.plot.scales, seen = { x: [x.min, x.max], y: [y.min, y.max] };
    this.take(panel, figure);
    const range = zoomed ? seen : this.full;
    // What nobody sees is drawn when it comes into sight.
    this.waits = !this.seen;
    if (this.waits) {
      const { ctx } = this.plot;
      ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
      this.next = range;
      return;
    }
    this.drawn(range);
  }
  drawn(range) {
    this.waits = false;
    this.plot.batch(() => {
      for (const key of ["x", "y"]) this.plot.setScale(key, { min: range[key][0], max: range[key][1] });
    });
    this.zoomed();
    this.plot.redraw(false, true);
  }
  size() {
    const [w, h] = this.figure.panel, width = Math.max(240, Math.floor(this.host.clientWidth));
    const names = this.panel.y.names.length;
    let height = Math.min(1.2 * h, Math.max(270, (h * width) / w));
    if (names) height = Math.max(height, 17 * names + 70);
    return { width, height: Math.round(height) };
  }
  ticks(key, low, high) {
    const axis = this.panel[key], box = this.plot.bbox, ratio = devicePixelRatio || 1;
    if (key === "y") return ticks(axis, low, high, axis.names.length ? 1e9 : Math.floor(box.height / ratio / 38));
    const room = box.width / ratio;
    for (let most = Math.floor(room / 48) + 1; ; most--) {
      const found = ticks(axis, low, high, most);
      const widest = Math.max(0, ...[...found.text.values()].map((t) => this.width(t, 11)));
      if (most <= 2 || (widest + 10) * found.at.length <= room) return found;
    }
  }
  width(text, size, bold) {
    PanelView.measure ??= document.createElement("canvas").getContext("2d");
    PanelView.measure.font = `${bold ? "bold " : ""}${size}px ${FONT}`;
    return PanelView.measure.measureText(text).width;
  }
  make() {
    const { panel } = this;
    const scale = (key) => ({
      time: false, auto: false, distr: panel[key].log ? 3 : 1,
      range: (u, low, high) => (Number.isFinite(low) && Number.isFinite(high) && low < high ? [low, high] : this.full[key].slice()),
    });
    const axis = (key, side) => {
      const texts = new Map();
      const longest = () => Math.min(0.42 * this.host.clientWidth, Math.max(20, ...[...texts.values()].map((t) => this.width(t, 11))));
      return {
        scale: key, side, label: panel[key].label || undefined, labelSize: 20, labelFont: `12px ${FONT}`, font: `11px ${FONT}`,
        stroke: () => ink().text, gap: 4, size: key === "x" ? 24 : () => Math.ceil(longest()) + 10,
        splits: (u, k, low, high) => {
          const found = this.ticks(key, low, high);
          texts.clear();
          found.text.forEach((text, at) => texts.set(at, text));
          this["minor" + key] = found.minor;
          return found.at;
        },
        filter: (u, splits) => splits,
        values: (u, splits) => splits.map((v) => this.clip(texts.get(v) ?? "")),
        grid: { stroke: () => ink().grid, width: 1, filter: (u, splits) => splits },
        ticks: { show: false },
      };
    };
    this.plot = new uPlot({
      ...this.size(), legend: { show: false }, pxAlign: 0,
      scales: { x: scale("x"), y: scale("y") },
      series: [{}, { scale: "y", paths: () => null, points: { show: false } }],
      axes: [axis("x", 2), axis("y", 3)],
      cursor: { drag: { x: true, y: true, uni: 24, dist: 6 }, points: { show: false }, x: false, y: false, bind: { dblclick: () => () => this.zoomOut() } },
      hooks: {
        drawAxes: [(u) => this.minor(u)],
        draw: [(u) => this.draw(u)],
        setScale: [() => this.zoomed()],
      },
    }, [this.full.x.slice(), this.full.y.slice()], this.host);
    const over = this.plot.over;
    over.addEventListener("mousemove", (e) => this.move(e));
    over.addEventListener("mouseleave", () => { hover(-1); tip(null); });
    over.addEventListener("click", (e) => {
      const hit = this.nearest(e);
      if (hit) choose(hit.id === state.chosen ? -1 : hit.id);
    });
    new ResizeObserver(() => {
      const size = this.size();
      if (this.host.clientWidth > 0 && size.width !== this.plot.width) this.plot.setSize(size);
    }).observe(this.host);
    this.plot.root.querySelector("canvas").setAttribute("aria-hidden", "true");
    this.seen = true;
    new IntersectionObserver((all) => {
      this.seen = all[all.length - 1].isIntersecting;
      if (this.seen && this.waits) this.drawn(this.next);
    }, { rootMargin: "200px" }).observe(this.host);
  }
  clip(text) {
    const most = 0.42 * this.host.clientWidth;
    if (this.width(text, 11) <= most) return text;
    let short = text;
    while (short.length > 3 && this.width(short + "…", 11) > most) short = short.slice(0, -1);
    return short + "…";
  }
  zoomOut() {
    this.plot.batch(() => {
      for (const key of ["x", "y"]) this.plot.setScale(key, { min: this.full[key][0], max: this.full[key][1] });
    });
  }
  zoomed() {
    if (!this.plot) return;
    const same = (key) => {
      const { min, max } = this.plot.scales[key], [low, high] = this.full[key];
      return Math.abs(min - low) <= 1e-6 * (high - low) && Math.abs(max - high) <= 1e-6 * (high - low);
    };
    this.reset.hidden = same("x") && same("y");
  }
  minor(u) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.strokeStyle = ink().minor;
    ctx.lineWidth = 1;
    ctx.beginPath();
    for (const v of this.minorx ?? []) { const p = u.valToPos(v, "x", true); ctx.moveTo(p, bbox.top); ctx.lineTo(p, bbox.top + bbox.height); }
    for (const v of this.minory ?? []) { const p = u.valToPos(v, "y", true); ctx.moveTo(bbox.left, p); ctx.lineTo(bbox.left + bbox.width, p); }
    ctx.stroke();
    ctx.restore();
  }
  draw(u) {
    const { ctx, bbox } = u, ratio = devicePixelRatio || 1, colours = ink();
    const x = (v) => u.valToPos(v, "x", true), y = (v) => u.valToPos(v, "y", true);
    const right = bbox.left + bbox.width, bottom = bbox.top + bbox.height;
    this.marks = [];
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const s of this.panel.stripes) {
      if (this.hidden.has(s.name)) continue;
      const of = s.along === "x" ? x : y;
      const ends = [s.from, s.to].map((v, k) => (v === null || !Number.isFinite(of(v)) ? (k ? 1e9 : -1e9) : of(v))).sort((a, b) => a - b);
      ctx.globalAlpha = dark() ? 0.22 : 0.13;
      ctx.fillStyle = tone(s.tone).area;
      if (s.along === "x") ctx.fillRect(Math.max(ends[0], bbox.left), bbox.top, Math.min(ends[1], right) - Math.max(ends[0], bbox.left), bbox.height);
      else ctx.fillRect(bbox.left, Math.max(ends[0], bbox.top), bbox.width, Math.min(ends[1], bottom) - Math.max(ends[0], bbox.top));
    }
    ctx.globalAlpha = 1;
    for (const rule of this.panel.rules) {
      ctx.setLineDash(rule.dash.map((d) => d * ratio));
      ctx.lineWidth = 1.2 * ratio;
      ctx.strokeStyle = tone(rule.tone).line;
      ctx.beginPath();
      if (rule.along === "x") { ctx.moveTo(x(rule.at), bbox.top); ctx.lineTo(x(rule.at), bottom); }
      else { ctx.moveTo(bbox.left, y(rule.at)); ctx.lineTo(right, y(rule.at)); }
      ctx.stroke();
    }
    ctx.setLineDash([]);
    const lit = state.chosen >= 0 ? state.chosen : state.hovered;
    // Only what is here can be set off against the rest.
    const here = lit >= 0 && this.ids.has(lit);
    this.panel.series.forEach((s, index) => this.series(ctx, s, index, { x, y, ratio, lit: here ? lit : -1, pass: 0 }));
    if (here) this.panel.series.forEach((s, index) => this.series(ctx, s, index, { x, y, ratio, lit, pass: 1 }));
    ctx.restore();
    ctx.save();
    ctx.strokeStyle = colours.frame;
    ctx.lineWidth = ratio;
    ctx.strokeRect(bbox.left, bbox.top, bbox.width, bbox.height);
    this.texts(ctx, u, x, y, ratio, here ? lit : -1);
    ctx.restore();
    this.host.dataset.lit = here ? lit : "";
    this.host.dataset.marks = this.marks.length;
  }
  // In the first pass all but what is lit, drawn back where something is lit; in the second what is lit.
  series(ctx, s, index, { x, y, ratio, lit, pass }) {
    if (s.name && this.hidden.has(s.name)) return;
    const t = tone(s.tone), whole = s.ids?.length === 1;
    const mine = (k) => lit >= 0 && idOf(s, k) === lit;
    const background = s.mark === "thin" && !s.ids;
    ctx.globalAlpha = pass === 0 && lit >= 0 && !background ? 0.25 : 1;
    const strong = pass === 1 ? 1.7 : 1;
    const lines = s.mark === "line" || s.mark === "thin" || s.mark === "band";
    if (lines && (pass === 1) !== (lit >= 0 && whole && mine(0))) return;
    const px = s.x.map((v) => (v === null ? NaN : x(v))), py = s.y.map((v) => (v === null ? NaN : y(v)));
    const visible = (k) => Number.isFinite(px[k]) && Number.isFinite(py[k]);
    if (s.mark === "band") {
      ctx.beginPath();
      let begun = false;
      const along = (k, q) => { if (!Number.isFinite(px[k]) || !Number.isFinite(q)) return; begun ? ctx.lineTo(px[k], q) : ctx.moveTo(px[k], q); begun = true; };
      px.forEach((_, k) => along(k, py[k]));
      for (let k = px.length - 1; k >= 0; k--) along(k, s.upper[k] === null ? NaN : y(s.upper[k]));
      ctx.closePath();
      ctx.globalAlpha *= 0.3;
      ctx.fillStyle = t.area;
      ctx.fill();
    } else if (lines) {
      ctx.beginPath();
      let begun = false;
      px.forEach((_, k) => { if (!visible(k)) { begun = false; return; } begun ? ctx.lineTo(px[k], py[k]) : ctx.moveTo(px[k], py[k]); begun = true; });
      ctx.setLineDash((s.dash ?? []).map((d) => d * ratio));
      ctx.lineWidth = (s.mark === "line" ? 2 : 1) * strong * ratio;
      ctx.strokeStyle = s.mark === "thin" ? t.area : s.strong && !dark() ? t.edge : s.strong ? "#ffffff" : t.line;
      ctx.stroke();
      ctx.setLineDash([]);
    } else {
      for (let k = 0; k < px.length; k++) {
        if (!visible(k) || (pass === 1) !== mine(k)) continue;
        if (s.mark === "points") point(ctx, s, px[k], py[k], 3.6 * (s.sizes?.[k] ?? 1) * strong * ratio, ratio);
        else if (s.mark === "dots") {
          ctx.save();
          ctx.globalAlpha *= 0.55;
          ctx.fillStyle = t.area;
          ctx.beginPath();
          ctx.arc(px[k], py[k], 2 * strong * ratio, 0, 7);
          ctx.fill();
          ctx.restore();
        } else {
          const zero = y(Math.max(0, this.plot.scales.y.min));
          if (this.panel.x.names.length) {
            const half = 0.3 * (x(1) - x(0)), box = [px[k] - half, Math.min(zero, py[k]), 2 * half, Math.abs(zero - py[k])];
            ctx.fillStyle = s.hollow ? ink().ground : t.area;
            ctx.fillRect(...box);
            ctx.lineWidth = 1.4 * strong * ratio;
            ctx.strokeStyle = t.line;
            ctx.strokeRect(...box);
            continue;
          }
          ctx.lineWidth = 2 * ratio;
          ctx.strokeStyle = t.line;
          ctx.beginPath();
          ctx.moveTo(px[k], zero);
          ctx.lineTo(px[k], py[k]);
          ctx.stroke();
        }
      }
    }
    ctx.globalAlpha = 1;
    if (pass === 0 || lit >= 0) this.marks.push({ s, index, px, py, line: lines });
  }
  texts(ctx, u, x, y, ratio, lit) {
    const { bbox } = u, colours = ink(), taken = [];
    const inside = (p, q) => p >= bbox.left && p <= bbox.left + bbox.width && q >= bbox.top && q <= bbox.top + bbox.height;
    const free = (r) => r[0] >= bbox.left && r[1] >= bbox.top && r[2] <= bbox.left + bbox.width && r[3] <= bbox.top + bbox.height &&
      !taken.some((o) => o[0] < r[2] && r[0] < o[2] && o[1] < r[3] && r[1] < o[3]);
    const write = (text, px, py, { bold, colour, align = "left", turn = 0 }) => {
      ctx.save();
      ctx.translate(px, py);
      ctx.rotate(turn);
      ctx.font = `${bold ? "bold " : ""}${11 * ratio}px ${FONT}`;
      ctx.textAlign = align;
      ctx.textBaseline = "middle";
      ctx.lineJoin = "round";
      ctx.lineWidth = 3 * ratio;
      ctx.strokeStyle = colours.ground;
      ctx.strokeText(text, 0, 0);
      ctx.fillStyle = colour ?? colours.text;
      ctx.fillText(text, 0, 0);
      ctx.restore();
    };
    // What texts had better not cover.
    const crowd = this.marks.flatMap((m) => m.px.map((p, k) => [p, m.py[k]]));
    if (this.panel.x.names.length) {
      // A wide bar is in the way with all of its area.
      const half = 0.3 * (x(1) - x(0)), bottom = bbox.top + bbox.height;
      for (const m of this.marks) if (m.s.mark === "bars") m.px.forEach((p, k) => {
        for (let q = m.py[k] + ratio; q < bottom; q += 8 * ratio) for (const s of [-0.9, -0.5, 0, 0.5, 0.9]) crowd.push([p + s * half, q]);
      });
    }
    const around = 3 * ratio;
    const covered = (r) => crowd.reduce((n, [p, q]) => n + (p > r[0] - around && p < r[2] + around && q > r[1] - around && q < r[3] + around), 0);
    let labels = this.panel.labels.map((l) => ({ ...l, px: x(l.x), py: y(l.y) }));
    if (lit >= 0) {
      // The first place of what is lit, where it does not stand already.
      const name = data.ids[lit];
      for (const s of this.panel.series) {
        const k = s.mark === "points" ? s.x.findIndex((_, j) => idOf(s, j) === lit && s.y[j] !== null) : -1;
        if (k < 0 || labels.some((l) => l.text === name || (l.text.startsWith(name) && l.chosen))) continue;
        labels.unshift({ text: name, px: x(s.x[k]), py: y(s.y[k]), lit: true });
        break;
      }
    }
    labels = labels.filter((l) => inside(l.px, l.py));
    for (const l of labels) taken.push([l.px - 5 * ratio, l.py - 5 * ratio, l.px + 5 * ratio, l.py + 5 * ratio]);
    for (const rule of this.panel.rules) {
      if (!rule.text) continue;
      const long = this.width(rule.text, 11) * ratio, high = 14 * ratio;
      const at = rule.along === "x" ? x(rule.at) : y(rule.at);
      const [l, t, r, b] = [bbox.left, bbox.top, bbox.left + bbox.width, bbox.top + bbox.height];
      const places = rule.along === "x"
        ? [t + 4 * ratio, b - long - 4 * ratio, (t + b - long) / 2].flatMap((q) => [at + 2 * ratio, at - high - 2 * ratio].map((p) => [p, q, p + high, q + long]))
        : [r - long - 4 * ratio, l + 4 * ratio, (l + r - long) / 2].flatMap((p) => [at - high - ratio, at + 2 * ratio].map((q) => [p, q, p + long, q + high]));
      const rect = places.find(free);
      if (!rect) continue;
      taken.push(rect);
      if (rule.along === "x") write(rule.text, (rect[0] + rect[2]) / 2, rect[3], { turn: -Math.PI / 2, colour: tone(rule.tone).line });
      else write(rule.text, rect[0], (rect[1] + rect[3]) / 2, { colour: tone(rule.tone).line });
    }
    for (const s of this.panel.series) {
      if (!s.along || (s.name && this.hidden.has(s.name))) continue;
      const trail = [];
      for (let k = 1; k < s.x.length; k++) {
        const [x0, y0, x1, y1] = [x(s.x[k - 1]), y(s.y[k - 1]), x(s.x[k]), y(s.y[k])];
        const parts = Math.ceil(Math.hypot(x1 - x0, y1 - y0) / (4 * ratio));
        for (let j = 0; j < parts && parts < 5000; j++) {
          const p = x0 + ((x1 - x0) * j) / parts, q = y0 + ((y1 - y0) * j) / parts;
          if (inside(p, q)) trail.push([p, q, Math.atan2(y1 - y0, x1 - x0)]);
        }
      }
      const long = this.width(s.along, 11) * ratio, high = 11 * ratio;
      let best = null;
      for (const share of [0.92, 0.08, 0.85, 0.15, 0.75, 0.25, 0.65, 0.35, 0.5]) {
        const on = trail[Math.floor(share * trail.length)];
        if (!on) continue;
        const turn = Math.cos(on[2]) < 0 ? on[2] + Math.PI : on[2];
        // Beside the line, on its upper side.
        const at = [on[0] + 8 * ratio * Math.sin(turn), on[1] - 8 * ratio * Math.cos(turn)];
        const w = (long * Math.abs(Math.cos(turn)) + high * Math.abs(Math.sin(turn))) / 2 + 1, h = (long * Math.abs(Math.sin(turn)) + high * Math.abs(Math.cos(turn))) / 2 + 1;
        const rect = [at[0] - w, at[1] - h, at[0] + w, at[1] + h];
        if (!free(rect)) continue;
        const cover = covered(rect);
        if (!best || cover < best.cover) best = { cover, rect, at, turn };
      }
      if (!best) continue;
      taken.push(best.rect);
      write(s.along, best.at[0], best.at[1], { turn: best.turn, align: "center", colour: colours.faint });
    }
    for (const l of labels) {
      if (l.chosen || l.lit) {
        ctx.beginPath();
        ctx.lineWidth = 1.8 * ratio;
        ctx.strokeStyle = colours.text;
        ctx.arc(l.px, l.py, 7 * ratio, 0, 7);
        ctx.stroke();
      }
      const w = this.width(l.text, 11, l.chosen || l.lit) * ratio + 2, h = 14 * ratio;
      let best = null;
      for (const d of [8, 14, 22, 34, 48, 66]) {
        const gap = d * ratio;
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, -1], [0, 1], [0.7, -0.7], [0.7, 0.7], [-0.7, -0.7], [-0.7, 0.7]]) {
          const cx = l.px + dx * (gap + (dx ? w / 2 : 0)) , cy = l.py + dy * (gap + h / 2);
          const rect = [cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2];
          if (!free(rect)) continue;
          const cover = 3 * covered(rect) + d / 10;
          if (!best || cover < best.cover) best = { rect, cover, away: d };
        }
      }
      if (!best) continue;
      taken.push(best.rect);
      if (best.away > 8) {
        const [r, near] = [best.rect, (v, low, high) => Math.min(high, Math.max(low, v))];
        ctx.beginPath();
        ctx.lineWidth = 0.8 * ratio;
        ctx.strokeStyle = colours.faint;
        ctx.moveTo(l.px, l.py);
        ctx.lineTo(near(l.px, r[0], r[2]), near(l.py, r[1], r[3]));
        ctx.stroke();
      }
      write(l.text, best.rect[0] + 1, (best.rect[1] + best.rect[3]) / 2, { bold: l.chosen || l.lit });
    }
  }
  // The mark under the pointer: a point within reach, else a line.
  nearest(event) {
    const ratio = devicePixelRatio || 1, { bbox } = this.plot, box = this.plot.over.getBoundingClientRect();
    const mx = (event.clientX - box.left) * ratio + bbox.left, my = (event.clientY - box.top) * ratio + bbox.top;
    let best = null;
    const offer = (distance, m, k) => { if (!best || distance < best.distance) best = { distance, s: m.s, k, id: idOf(m.s, k), px: m.px[k], py: m.py[k] }; };
    for (const m of this.marks) {
      if (m.line) continue;
      for (let k = 0; k < m.px.length; k++) {
        const distance = Math.hypot(m.px[k] - mx, m.py[k] - my) / ratio;
        if (distance < 11) offer(distance, m, k);
      }
    }
    if (best) return best;
    for (const m of this.marks) {
      if (!m.line || m.s.mark === "band") continue;
      for (let k = 1; k < m.px.length; k++) {
        const [ax, ay, bx, by] = [m.px[k - 1], m.py[k - 1], m.px[k], m.py[k]];
        const length = (bx - ax) ** 2 + (by - ay) ** 2;
        if (!Number.isFinite(length) || length === 0) continue;
        const share = Math.min(1, Math.max(0, ((mx - ax) * (bx - ax) + (my - ay) * (by - ay)) / length));
        const distance = Math.hypot(ax + share * (bx - ax) - mx, ay + share * (by - ay) - my) / ratio;
        if (distance < 7) offer(distance, m, share < 0.5 ? k - 1 : k);
      }
    }
    return best;
  }
  move(event) {
    const hit = this.nearest(event);
    this.plot.over.classList.toggle("hit", Boolean(hit && hit.id >= 0));
    hover(hit ? hit.id : -1);
    if (!hit) return tip(null);
    const { x, y } = this.panel, { s, k } = hit, lines = [];
    const head = noteOf(s, k) || s.along || "";
    if (head) lines.push(head);
    if (s.name && s.name !== head && !head.startsWith(s.name)) lines.push(s.name);
    const value = (axis, v) => (axis.names.length ? null : `${axis.label || "value"}: ${show(v)}`);
    lines.push(...[value(x, s.x[k]), value(y, s.y[k])].filter(Boolean));
    tip(lines, event.clientX, event.clientY);
  }
}

function tip(lines, px, py) {
  const box = document.getElementById("tip");
  box.hidden = !lines;
  if (!lines) return;
  box.replaceChildren(...lines.map((line, k) => Object.assign(document.createElement(k ? "div" : "b"), { textContent: line })));
  const { width, height } = box.getBoundingClientRect();
  const left = px + 14 + width > innerWidth ? px - 14 - width : px + 14, top = py + 14 + height > innerHeight ? py - 14 - height : py + 14;
  box.style.left = `${Math.max(4, left)}px`;
  box.style.top = `${Math.max(4, top)}px`;
}

// The legend's entries, each once, with all that has the name; pressing one hides or shows it.
function legend(views) {
  const entries = new Map();
  // Of one look full and hollow, the full one is the sample.
  const add = (name, sample) => {
    if (!name) return;
    const others = entries.get(name) ?? [], alike = others.findIndex((s) => s.mark === sample.mark && s.tone === sample.tone);
    if (alike < 0) entries.set(name, [...others, sample]);
    else if (others[alike].hollow) others[alike] = sample;
  };
  for (const { panel } of views) {
    for (const s of panel.series) add(s.name, s);
    for (const s of panel.stripes) add(s.name, { ...s, mark: "stripe" });
  }
  const list = Object.assign(document.createElement("div"), { className: "legend" });
  for (const [name, samples] of entries) {
    const button = Object.assign(document.createElement("button"), { type: "button", title: "hide or show" });
    button.setAttribute("aria-pressed", String(!views.some((view) => view.hidden.has(name))));
    const canvas = document.createElement("canvas");
    button.append(canvas, name);
    button.addEventListener("click", () => {
      const hide = button.getAttribute("aria-pressed") === "true";
      button.setAttribute("aria-pressed", String(!hide));
      for (const view of views) { hide ? view.hidden.add(name) : view.hidden.delete(name); view.plot.redraw(false); }
    });
    const paint = () => {
      const ratio = devicePixelRatio || 1, ctx = canvas.getContext("2d");
      canvas.width = 30 * ratio;
      canvas.height = 14 * ratio;
      const drawn = samples.length > 1 ? samples.filter((s) => s.mark !== "bars") : samples;
      for (const s of drawn) {
        const t = tone(s.tone), mid = 7 * ratio;
        if (s.mark === "points") point(ctx, s, 15 * ratio, mid, 4.5 * ratio, ratio);
        else if (s.mark === "dots") { ctx.fillStyle = t.area; ctx.beginPath(); ctx.arc(15 * ratio, mid, 3.5 * ratio, 0, 7); ctx.fill(); }
        else if (s.mark === "line" || s.mark === "thin") {
          ctx.strokeStyle = s.mark === "line" ? t.line : t.area;
          ctx.lineWidth = (s.mark === "line" ? 2 : 1) * ratio;
          ctx.setLineDash((s.dash ?? []).map((d) => d * ratio));
          ctx.beginPath(); ctx.moveTo(0, mid); ctx.lineTo(30 * ratio, mid); ctx.stroke();
          ctx.setLineDash([]);
        } else {
          const bars = s.mark === "bars", box = [bars ? 11 * ratio : 0, ratio, (bars ? 8 : 30) * ratio, 12 * ratio];
          ctx.globalAlpha = bars ? 1 : 0.3;
          ctx.fillStyle = s.hollow ? ink().ground : t.area;
          ctx.fillRect(...box);
          if (bars) { ctx.strokeStyle = t.line; ctx.lineWidth = 1.2 * ratio; ctx.strokeRect(...box); }
          ctx.globalAlpha = 1;
        }
      }
    };
    paint();
    state.listeners.push({ at: canvas, paint });
    list.append(button);
  }
  return entries.size ? list : null;
}

function make(tag, text, className) {
  return Object.assign(document.createElement(tag), { textContent: text, className: className ?? "" });
}
const axes = (panel) => [panel.x, panel.y].flatMap((axis) => [axis.label, axis.log, !axis.range, ...axis.names]);
class FigureView {
  constructor(host, figure) {
    Object.assign(this, { host, figure, views: [], legends: [] });
    for (const group of figure.groups) {
      if (group.title) host.append(make("h3", group.title));
      if (group.caption) host.append(make("p", group.caption, "note"));
      const grid = make("div", "", "panels");
      const shared = [], later = [];
      host.append(grid);
      const single = group.panels.length === 1;
      if (single) grid.classList.add("single");
      for (const panel of group.panels) {
        const box = make("div", "", "panel");
        grid.append(box);
        if (panel.title) box.append(make(group.title ? "h4" : "h3", panel.title));
        if (!panel.x.range || !panel.y.range) {
          box.append(make("p", `${panel.x.label ? panel.x.label + ": " : ""}${panel.empty || "nothing to draw"}`, "note"));
          continue;
        }
        const plot = make("div", "", "plot");
        box.append(plot);
        later.push(() => {
          const view = new PanelView(panel, figure, plot);
          this.views.push(view);
          if (group.own) this.legend([view], plot); else shared.push(view);
        });
      }
      // Only when all boxes stand is it known how wide each is.
      later.forEach((draw) => draw());
      if (shared.length) this.legend(shared, grid);
    }
  }
  // The legend of some diagrams, before an element.
  legend(views, before) {
    const list = legend(views);
    if (list) before.before(list);
    this.legends.push({ views, before, list });
  }
  // Whether another figure has the same diagrams, with other values.
  same(other) {
    const groups = (figure) => figure.groups.map((g) => [g.title, g.caption, g.own, g.panels.map((p) => [p.title, axes(p), p.empty])]);
    return JSON.stringify(groups(this.figure)) === JSON.stringify(groups(other));
  }
  takes(part, figures) {
    const figure = part.matches("figure[data-figure]") ? figures[Number(part.dataset.figure)] : null;
    if (!figure || !this.same(figure)) return false;
    this.figure = figure;
    const drawn = figure.groups.flatMap((g) => g.panels).filter((p) => p.x.range && p.y.range);
    this.views.forEach((view, k) => view.update(drawn[k], figure));
    for (const of of this.legends) {
      const focused = of.list?.contains(document.activeElement) ? document.activeElement.textContent : null;
      of.list?.remove();
      of.list = legend(of.views);
      if (of.list) of.before.before(of.list);
      if (focused !== null) [...(of.list?.children ?? [])].find((b) => b.textContent === focused)?.focus();
    }
    this.host.setAttribute("aria-label", part.getAttribute("aria-label"));
    this.host.querySelector("figcaption")?.replaceChildren(...part.querySelector("figcaption").childNodes);
    return true;
  }
}
// Draws again; with ids only the diagrams that have one of them.
function redraw(ids) {
  for (const view of panels) {
    if (state.print && view.waits) view.drawn(view.next);
    else if (!ids || ids.some((id) => view.ids.has(id))) view.plot.redraw(false, true);
  }
}
