// Where an axis has ticks, and their texts: as in the SVG.
function raised(exponent) {
  return String(exponent).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)]));
}
function tickText(value, step) {
  if (Math.abs(value) < 1e-6 * step) return "0";
  if (step < 1e-4 || step >= 1e6) {
    const [mantissa, exponent] = value.toExponential(2).split("e");
    const short = String(Number(mantissa));
    return (short === "1" ? "10" : short + "·10") + raised(Number(exponent));
  }
  const digits = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(step))));
  return String(Number(value.toFixed(digits))).replace("-", "−");
}
// Ticks as in the SVG: steps of 1, 2 or 5; powers of ten with 2 and 5 in between where there are few.
function ticks(axis, low, high, most) {
  const out = { at: [], text: new Map(), minor: [] };
  const add = (value, text) => { out.at.push(value); out.text.set(value, text); };
  if (axis.names.length) {
    const every = Math.max(1, Math.ceil(axis.names.length / Math.max(1, most)));
    axis.names.forEach((name, k) => { if (k % every === 0 && k >= low && k <= high) add(k, name); });
    return out;
  }
  // Of a logarithmic axis at least three: from fewer nobody can tell that it is one.
  const least = axis.log ? 3 : 1;
  most = Math.max(most, least);
  if (axis.log && high >= 5 * low) {
    const from = Math.floor(Math.log10(low)), to = Math.ceil(Math.log10(high));
    const inside = (v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9);
    const powers = [];
    for (let e = from; e <= to; e++) if (inside(10 ** e)) powers.push(e);
    const full = powers.length, labelled = (n) => powers.filter((e) => e % n === 0).length;
    let every = Math.max(1, Math.ceil(full / most));
    while (every > 1 && labelled(every) < least) every--;
    const between = full < least || (3 * full <= most && high / low < 1010), plain = low >= 0.9e-3 && high <= 1.1e4;
    for (let e = from; e <= to; e++) {
      for (let digit = 1; digit < 10; digit++) {
        const value = digit * 10 ** e;
        if (!inside(value)) continue;
        const text = plain ? tickText(value, value) : (digit === 1 ? "10" : digit + "·10") + raised(e);
        if (digit === 1 && ((e % every) + every) % every === 0) add(value, text);
        else if (between && (digit === 2 || digit === 5)) add(value, text);
        else if (every === 1 || digit === 1) out.minor.push(value);
      }
    }
    if (out.at.length >= least) return out;
  }
  for (let tries = most; tries < most + 16; tries++) {
    Object.assign(out, { at: [], text: new Map(), minor: [] });
    const raw = (high - low) / Math.max(2, tries), magnitude = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * magnitude).find((s) => s >= raw * (1 - 1e-9));
    const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
    for (let k = first; k <= last && k < first + 200; k++) add(k * step, tickText(k * step, step));
    if (out.at.length >= least) break;
  }
  return out;
}
