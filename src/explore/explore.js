// The explorer: a state, questions about it, and answers that are put in the place of older ones. All goes through `send`, so
// that a grid of answers in the page can take the place of the program.
(function explorer() {
  const known = data.explore, at = (id) => document.getElementById(id);
  const live = !known.grid, tab = Array.from(crypto.getRandomValues(new Uint8Array(8)), (b) => b.toString(16).padStart(2, "0")).join("");
  // What is asked: values in the place of the file's, and what is looked at.
  let now = { state: {}, joint: known.joints[0], design: "", filter: "", pins: [] };
  // What was answered last.
  const shown = { controls: [], joints: {}, design: null, objective: null, references: {} };
  const times = (window.gearwiseTimes = []);
  let number = 0, flying = false, waits = null, standing = 0, applying = false;
  // Whether the full answer to this state is still owed, and whether what is wrong with it may be left out.
  let owed = true, lenient = false;
  // Whether the next answer moves what has the focus, too: it is of another state, not of what is turned.
  let moved = false;

  // ---- the state as a link
  const part = encodeURIComponent;
  function linkOf(of, whole = true) {
    const all = Object.entries(of.state).sort().map(([key, value]) => `${part(key)}=${part(value)}`);
    if (known.joints.length > 1 || of.joint !== known.joints[0]) all.push(`joint=${part(of.joint)}`);
    if (of.design) all.push(`design=${part(of.design)}`);
    if (whole) {
      if (of.filter) all.push(`filter=${part(of.filter)}`);
      for (const pin of of.pins) all.push(`pin=${part(pin)}`);
      all.push(`file=${known.hash}`);
    }
    return all.join("&");
  }
  function ofLink(link) {
    const of = { state: {}, joint: known.joints[0], design: "", filter: "", pins: [] }, left = [];
    let file = known.hash;
    for (const piece of link.replace(/^#/, "").split("&").filter(Boolean)) {
      let key, value;
      try {
        const cut = piece.indexOf("=");
        if (cut < 1) throw new Error();
        [key, value] = [piece.slice(0, cut), piece.slice(cut + 1)].map(decodeURIComponent);
        if (Math.max(key.length, value.length) > 1000) throw new Error();
      } catch { left.push({ key: "", message: `of the link \`${piece.slice(0, 60)}\` is left out: it is no KEY=VALUE that can be read`, help: "" }); continue; }
      if (key === "pin") { if (of.pins.length < 2) of.pins.push(value); }
      else if (key === "file") file = value;
      else if (["joint", "design", "filter"].includes(key)) of[key] = value;
      else of.state[key] = value;
    }
    if (file !== known.hash) left.unshift({ key: "", message: `This link was made with another ${known.file}: its values are applied to the file as it is now.`, help: "" });
    return { of, left };
  }
  // A change that stands for half a second is a step of the history.
  function stands() {
    clearTimeout(standing);
    standing = setTimeout(step, 500);
  }
  function step() {
    clearTimeout(standing);
    const hash = `#${linkOf(now)}`;
    if (hash !== location.hash) history.pushState(null, "", hash);
  }

  // ---- questions and answers
  const question = (more) => ({ tab, ask: ++number, state: now.state, joint: now.joint, design: now.design, pins: now.pins, ...more });
  async function send(path, body) {
    if (!live) return fromGrid(body);
    const answer = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body), cache: "no-store" });
    if (answer.status === 204) return null;
    if (!answer.ok) throw new Error(await answer.text());
    return answer.headers.get("Content-Type").startsWith("application/json") ? answer.json() : answer.text();
  }
  // One question flies; of those that come meanwhile the latest waits. Until a state was answered in full, a question about the design
  // alone asks for the rest again.
  function ask(more = {}) {
    if (!more.design_only) owed = true;
    if (more.lenient) lenient = true;
    waits = { design_only: !owed, since: performance.now() };
    if (!flying) fly();
  }
  async function fly() {
    flying = true;
    while (waits) {
      const { design_only, since } = waits;
      waits = null;
      try { await answered(question({ design_only, lenient }), since); } catch (why) { broken(why); }
    }
    flying = false;
    busy("");
  }
  async function answered(asked, since) {
    busy("…");
    let reply = await send("ask", asked), have = 0, first = true;
    while (reply) {
      if (reply.ask !== asked.ask) return;
      if (reply.far) {
        // Nothing yet: what is shown is of the state before.
        if (!have) at("views").classList.add("stale");
        const [done, of] = reply.far;
        busy(of ? `${done} of ${of} motors` : "…");
      } else {
        have++;
        apply(reply, asked);
        if (first) painted(since, asked);
        first = false;
      }
      if (!reply.pending) { if (!waits && !asked.design_only && (reply.views || reply.joints || !reply.problems)) owed = false; return; }
      if (waits) return;
      reply = await send("more", { tab, ask: asked.ask, have });
    }
  }
  // How long it took until the answer was painted.
  function painted(since, asked) {
    requestAnimationFrame(() => setTimeout(() => times.push({ took: performance.now() - since, design: Boolean(asked.design_only) })));
  }
  function broken(why) {
    banner([{ key: "", message: why instanceof TypeError ? "gearwise does not answer: it was stopped. What is shown is the last answer." : String(why.message ?? why), help: "" }]);
    at("views").classList.add("stale");
  }
  const busy = (text) => { at("busy").textContent = text; };

  function apply(reply, asked) {
    applying = true;
    const views = at("views"), answered = Boolean(reply.views || reply.joints);
    // What was asked since has a state of its own.
    if (!waits) {
      if (reply.state && asked.lenient) { now.state = reply.state; lenient = false; }
      if (reply.joint && reply.joint !== now.joint) now.joint = reply.joint;
    }
    if (reply.objective) shown.objective = reply.objective;
    if (reply.references) shown.references[reply.joint ?? asked.joint] = reply.references;
    if (reply.controls) controls(reply.controls);
    if (reply.problems) problems(reply.problems);
    // What was asked since is answered within a moment, or says that it is not: to draw this in grey meanwhile would flicker.
    if (reply.views?.headline || (reply.views?.design && asked.design_only)) views.classList.remove("stale");
    else if (reply.problems?.length && !answered) views.classList.add("stale");
    if (reply.design !== undefined) Object.assign(shown, { design: reply.design, ask: asked.ask });
    for (const joint of reply.joints ?? []) shown.joints[joint.joint] = { ...joint, of: asked.ask };
    if (reply.joints || reply.pending === false) joints(asked.ask, reply.pending !== false);
    for (const [name, fragment] of Object.entries(reply.views ?? {})) mount(at(name), fragment);
    if (reply.views?.ranking) filtered();
    if (reply.views?.pins) pinned();
    if (reply.design !== undefined) ratio();
    if (reply.notes) at("notes").replaceChildren(...reply.notes.map((note) => make("p", note, "note")));
    if (reply.views?.headline) speak();
    if (live && reply.design !== undefined) mark();
    if (reply.design !== undefined && !waits) moved = false;
    at("undo").disabled = !Object.keys(now.state).length && !now.design && history.length < 2;
    applying = false;
  }
  // The row and the dots of a design that was chosen to be looked at.
  function mark() {
    const id = now.design ? data.ids.indexOf(shown.design?.motor ?? "") : -1;
    if (id !== state.chosen) choose(id);
  }
  let spoke = 0;
  function speak() {
    clearTimeout(spoke);
    spoke = setTimeout(() => { at("spoken").textContent = at("headline").querySelector("p")?.textContent ?? ""; }, 1000);
  }

  // ---- what is wrong
  function problems(all) {
    document.querySelectorAll(".control").forEach((box) => {
      box.querySelector(".wrong")?.remove();
      box.querySelectorAll("input, select").forEach((e) => { e.removeAttribute("aria-invalid"); e.removeAttribute("aria-describedby"); });
    });
    const elsewhere = [];
    all.forEach((problem, k) => {
      const box = [...document.querySelectorAll(".control")].find((b) => b.dataset.key === problem.key);
      if (!box) { elsewhere.push(problem); return; }
      const text = make("p", problem.help ? `${problem.message}; ${problem.help}` : problem.message, "wrong");
      text.id = `wrong-${k}`;
      box.append(text);
      box.querySelectorAll("input, select").forEach((e) => { e.setAttribute("aria-invalid", "true"); e.setAttribute("aria-describedby", text.id); });
    });
    banner([...ofThisLink, ...elsewhere]);
  }
  let ofThisLink = [];
  function banner(all) {
    at("banner").hidden = !all.length;
    at("banner").replaceChildren(...all.map((p) => make("p", [p.key && `${p.key}: `, p.message, p.help && `; ${p.help}`].filter(Boolean).join(""))));
  }

  // ---- controls
  const digits = (value, of = 3) => String(Number(value.toPrecision(of)));
  const numberOf = (text) => { const value = parseFloat(text); return Number.isFinite(value) ? value : null; };
  const withUnit = (value, unit) => (unit ? `${digits(value)} ${unit}` : digits(value));
  const print = (unit) => unit.replace("kg*m^2", "kg·m²").replace("degC", "°C").replace("N*m", "N·m");
  function place(c, value) {
    const share = c.log ? Math.log(value / c.low) / Math.log(c.high / c.low) : (value - c.low) / (c.high - c.low);
    return Math.round(1000 * Math.min(1, Math.max(0, share)));
  }
  function valueAt(c, share) {
    const t = share / 1000;
    return c.log ? c.low * (c.high / c.low) ** t : c.low + t * (c.high - c.low);
  }
  function controls(all) {
    const keys = all.map((c) => c.key).join("\n");
    if (keys !== shown.controls.map((c) => c.key).join("\n")) build(all);
    shown.controls = all;
    all.forEach(refresh);
    objective();
  }
  function build(all) {
    const of = (joint) => all.filter((c) => c.joint === joint).map(control), joints = of(true);
    at("controls").replaceChildren(make("h3", known.joints.length > 1 ? "the whole robot" : "the supply, the motion"), ...of(false), ...(joints.length ? [make("h3", `the joint ${now.joint}`), ...joints] : []));
    if (live) at("controls").append(objectiveBox());
    at("ground").textContent = live ? `Turned values are put in the place of those of ${known.file} as it was read when the program started; the file is not changed.` : "This page holds answers that were worked out before, at the values of its sliders: there is no other ratio, motor or pin to look at. gearwise explore does that." + (Object.keys(known.begin).length ? ` All with ${Object.entries(known.begin).map(([key, value]) => `${key} = ${value}`).join(", ")} in the place of the file's.` : "");
  }
  function control(c) {
    const box = make("div", "", "control"), label = document.createElement("label"), row = make("div", "", "row");
    const range = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 1000, step: c.values ? 1 : 2, id: `c-${c.key}`, title: c.help });
    const field = Object.assign(document.createElement("input"), { type: "text", spellcheck: false, autocomplete: "off", title: c.help });
    const undo = Object.assign(make("button", "↺", "undo"), { type: "button", title: "as in the file" });
    box.dataset.key = c.key;
    if (c.values) range.max = c.values.length - 1;
    label.htmlFor = range.id;
    label.append(make("span", c.name), make("span", "", "was"));
    field.setAttribute("aria-label", `${c.name}${c.unit ? `, in ${print(c.unit)} or with a unit` : ""}`);
    undo.setAttribute("aria-label", `${c.name}: as in the file`);
    range.addEventListener("input", () => {
      const of = shown.controls.find((o) => o.key === c.key) ?? c;
      set(c.key, of.values ? of.values[Number(range.value)] : withUnit(valueAt(of, Number(range.value)), of.unit));
    });
    field.addEventListener("change", () => {
      const text = field.value.trim();
      if (!text) return set(c.key, null);
      set(c.key, c.unit && /^[-+]?[\d.]+(e[-+]?\d+)?$/i.test(text) ? `${text} ${c.unit}` : text);
    });
    undo.addEventListener("click", () => { set(c.key, null); range.focus(); });
    row.append(range, ...(c.values ? [] : [field]), undo);
    box.append(label, row);
    return box;
  }
  // What the file says, in full.
  const fileWords = (c) => (c.file === null || c.file === undefined ? "" : c.unit ? `${c.file} ${c.unit}` : String(c.file));
  const boxOf = (key) => [...document.querySelectorAll(".control")].find((b) => b.dataset.key === key);
  function refresh(c) {
    const box = boxOf(c.key);
    if (!box) return;
    const [range, field] = [box.querySelector("input[type=range]"), box.querySelector("input[type=text]")];
    const text = now.state[c.key], said = text === undefined ? c.file : c.now ?? numberOf(text);
    const words = text ?? fileWords(c);
    box.classList.toggle("turned", text !== undefined);
    box.querySelector(".was").textContent = c.values ? print(c.values[Number(c.at)]) : text === undefined ? (c.file === null ? "not set" : "as in the file") : `file: ${print(fileWords(c)) || "not set"}`;
    box.querySelector(".undo").disabled = text === undefined || Boolean(c.values);
    if (c.values) range.value = c.at;
    else if (moved || document.activeElement !== range || said === null) range.value = said === null ? 1000 : place(c, said);
    range.setAttribute("aria-valuetext", words ? print(words) : "not set");
    if (field && (moved || document.activeElement !== field)) field.value = words;
  }
  function set(key, text) {
    const file = shown.controls.find((c) => c.key === key);
    if (text === null || (file && text === fileWords(file))) delete now.state[key];
    else now.state[key] = text;
    ofThisLink = [];
    if (file) refresh({ ...file, now: text === null ? file.file : numberOf(text) });
    ask();
    stands();
  }
  // What makes a choice good: one quantity, or weights of three with the first choice as their reference.
  const WEIGHED = ["loss", "mass", "reflected_inertia"];
  function objectiveBox() {
    const box = make("div", "", "control"), label = make("label", "what is best"), pick = document.createElement("select"), weights = make("div", "");
    box.id = "objective";
    pick.id = "objective-pick";
    label.htmlFor = pick.id;
    for (const name of [...known.objectives, "weights of three"]) pick.append(new Option(name.replaceAll("_", " "), name));
    pick.addEventListener("change", () => {
      const { key } = shown.objective, reference = key.replace(/objective$/, "reference");
      if (pick.value === "weights of three") {
        const of = shown.references[now.joint] ?? {};
        if (WEIGHED.some((name) => !of[name]?.[0])) return banner([{ key: "", message: "weights need a first choice by the file whose loss, mass and inertia are known", help: "" }]);
        now.state[reference] = `{ ${WEIGHED.map((name) => `${name} = "${digits(of[name][0], 4)} ${of[name][1]}"`).join(", ")} }`;
        weigh([1, 1, 1]);
      } else {
        delete now.state[reference];
        now.state[key] = pick.value;
      }
      ask();
      stands();
    });
    WEIGHED.forEach((name, k) => {
      const row = make("label", "", "row"), range = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 4, step: 0.1, value: 1 });
      row.append(make("span", name.replace("reflected_", "")), range);
      range.addEventListener("input", () => { weigh([...weights.querySelectorAll("input")].map((e) => Number(e.value))); ask(); stands(); });
      weights.append(row);
    });
    weights.hidden = true;
    weights.append(make("p", "", "note"));
    box.append(label, pick, weights);
    return box;
  }
  function weigh(values) {
    if (!values.some((v) => v > 0)) return banner([{ key: "", message: "one weight at least has to be more than zero", help: "" }]);
    banner([]);
    now.state[shown.objective.key] = `{ ${WEIGHED.map((name, k) => [name, values[k]]).filter(([, v]) => v > 0).map(([name, v]) => `${name} = ${v}`).join(", ")} }`;
  }
  function objective() {
    const box = at("objective");
    if (!box || !shown.objective) return;
    const { key, sole } = shown.objective, text = now.state[key];
    box.dataset.key = key;
    box.querySelector("select").value = sole ?? "weights of three";
    box.classList.toggle("turned", text !== undefined);
    const weights = box.querySelector("div");
    weights.hidden = sole !== null || !text;
    const over = now.state[key.replace(/objective$/, "reference")];
    weights.querySelector(".note").textContent = over ? `Each over that of the first choice by the file: ${print(over.replace(/[{}"]/g, "").replace(/ =/g, "").replaceAll("_", " ").trim())}.` : "";
    if (!weights.hidden && !box.contains(document.activeElement)) weights.querySelectorAll("input").forEach((e, k) => {
      e.value = new RegExp(`\\b${WEIGHED[k]} = ([\\d.]+)`).exec(text)?.[1] ?? 0;
    });
  }

  // ---- joints, ranking, design
  function joints(asked, pending) {
    at("joints").hidden = known.joints.length < 2;
    if (known.joints.length < 2) return;
    known.joints.forEach((name, k) => {
      const of = shown.joints[name], fresh = of && of.of === asked;
      let button = at("joints").children[k];
      if (!button) {
        button = Object.assign(document.createElement("button"), { type: "button" });
        button.append(make("b", ""), make("span", ""));
        button.addEventListener("click", () => { Object.assign(now, { joint: name, design: "" }); ask(); stands(); });
        at("joints").append(button);
      }
      button.setAttribute("aria-current", String(name === now.joint));
      button.firstChild.textContent = of && of.count > 1 ? `${name} ×${of.count}` : name;
      button.lastChild.textContent = of ? of.text : "…";
      button.lastChild.className = !fresh && pending ? "pending" : of && !of.satisfied ? "none" : "";
      button.classList.toggle("waits", !fresh && pending);
    });
  }
  function filtered() {
    const field = at("ranking").querySelector(".bar input");
    if (!field || field.dataset.tied) return;
    field.dataset.tied = "1";
    if (now.filter) { field.value = now.filter; field.dispatchEvent(new Event("input")); }
    field.addEventListener("input", () => { now.filter = field.value; stands(); });
  }
  function look(design) {
    if (design === now.design) return;
    now.design = design;
    ask({ design_only: true });
    stands();
  }
  state.onChosen = (motor) => {
    if (applying || !live) return;
    if (motor && motor !== shown.design?.motor) look(motor);
    else if (!motor && now.design) look("");
  };
  function ratio() {
    const { design } = shown, range = design?.range, slider = at("ratio-at"), field = at("ratio-text");
    at("ratio").hidden = !live || !range;
    at("first").hidden = !live || !now.design;
    at("pin").hidden = !live || !design;
    if (!range) return;
    if (moved || document.activeElement !== slider) slider.value = place({ low: range[0], high: range[1], log: true }, design.ratio);
    slider.setAttribute("aria-valuetext", design.text);
    if (moved || document.activeElement !== field) field.value = design.text;
    at("ratio-best").disabled = !design.best;
  }
  const tune = (text) => { if (shown.design) look(`${shown.design.motor}@${text}`); };
  at("ratio-at").addEventListener("input", () => {
    const [low, high] = shown.design.range, text = String(Number(valueAt({ low, high, log: true }, Number(at("ratio-at").value)).toPrecision(4)));
    at("ratio-text").value = text;
    tune(text);
  });
  at("ratio-text").addEventListener("change", () => tune(at("ratio-text").value.trim()));
  at("ratio-best").addEventListener("click", () => look(shown.design.motor));
  at("first").addEventListener("click", () => look(""));

  // ---- pins
  at("pin").addEventListener("click", () => {
    const { design } = shown;
    if (at("views").classList.contains("stale") || waits || shown.ask !== number) return busy("not pinned: there is no answer to these values yet");
    const pin = linkOf({ ...now, design: design.gear ? `${design.motor}@${design.gear}` : `${design.motor}@${design.ratio}` }, false);
    now.pins = [...now.pins.filter((other) => other !== pin), pin].slice(-2);
    ask({ design_only: true });
    step();
  });
  function pinned() {
    at("held").hidden = !now.pins.length;
    at("pinned").replaceChildren(...now.pins.map((pin, k) => {
      const { of } = ofLink(pin), box = make("span", "", "pinned"), name = of.design.replace(/@([\d.]+)$/, (_, n) => ` at N = ${digits(Number(n), 4)}`);
      const values = Object.entries(of.state).map(([key, value]) => `${key.split(".").slice(-2).join(".")} ${value}`).join(", ");
      const go = Object.assign(make("button", "show"), { type: "button" }), drop = Object.assign(make("button", "×"), { type: "button" });
      go.setAttribute("aria-label", `show ${name}`);
      drop.setAttribute("aria-label", `unpin ${name}`);
      go.addEventListener("click", () => { Object.assign(now, { state: of.state, joint: of.joint, design: of.design }); ask(); step(); });
      drop.addEventListener("click", () => { now.pins = now.pins.filter((_, other) => other !== k); ask({ design_only: true }); step(); });
      box.append(`${"AB"[k]}: ${known.joints.length > 1 ? `${of.joint}: ` : ""}${name}${values ? `, ${values}` : ""} `, go, drop);
      return box;
    }));
  }

  // ---- what is taken away
  at("undo").addEventListener("click", () => history.back());
  at("link").addEventListener("click", async () => {
    const text = linkOf(now);
    try { await navigator.clipboard.writeText(text); busy("copied: for --state, or behind the # of the page"); }
    catch { busy("not copied: it stands behind the # of the address"); }
  });
  at("save").addEventListener("click", async () => {
    try {
      const text = await send("toml", question({}));
      if (typeof text !== "string") { busy("not saved: a value is wrong"); return problems(text.problems); }
      const name = known.file.split(/[\\/]/).pop().replace(/\.toml$/, "");
      const a = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([text], { type: "application/toml" })), download: `${name}_explored.toml` });
      a.click();
      URL.revokeObjectURL(a.href);
      busy(`keep it next to ${known.file}: it names its motions from there`);
    } catch (why) { broken(why); }
  });
  at("report").addEventListener("click", async () => {
    // The window has to be asked for at once, or it is taken for one that nobody asked for.
    const page = window.open("", "_blank");
    busy("the report is made …");
    try {
      const answer = await send("report", question({}));
      if (answer?.problems) { page?.close(); busy("no report: a value is wrong"); return problems(answer.problems); }
      if (page) page.location = new URL(answer, location.href.split("#")[0]).href;
      busy("");
    } catch (why) { page?.close(); broken(why); }
  });
  at("fronts").addEventListener("click", async () => {
    busy("fronts …");
    try {
      const answer = await send("fronts", question({}));
      if (answer?.problems) problems(answer.problems); else mount(at("front"), answer);
      busy("");
    } catch (why) { broken(why); }
  });

  // ---- keys, history, beginning
  addEventListener("keydown", (event) => {
    const typing = event.target.matches?.("input[type=text], input[type=search], select");
    if ((event.ctrlKey || event.metaKey) && event.key === "z" && !typing) { event.preventDefault(); history.back(); }
  });
  function begin(link) {
    const { of, left } = ofLink(link);
    now = of;
    moved = true;
    ofThisLink = left;
    ask({ lenient: true });
  }
  addEventListener("popstate", () => { clearTimeout(standing); begin(location.hash); });

  // ---- a grid in the place of the program
  function fromGrid(body) {
    const problems = [], axes = known.grid.axes;
    for (const [key, value] of Object.entries(body.state)) {
      const axis = axes.find((axis) => axis.key === key);
      if (!axis || !axis.values.includes(value)) problems.push({ key: "", message: `this page holds no answer for ${key} = ${value}`, help: "" });
    }
    const place = axes.map((axis) => axis.values.indexOf(axis.values.includes(body.state[axis.key]) ? body.state[axis.key] : axis.values[axis.file]));
    const joint = known.joints.includes(body.joint) ? body.joint : known.joints[0];
    if (joint !== body.joint) problems.push({ key: "", message: `there is no joint ${body.joint}`, help: "" });
    const answer = known.grid.answers[`${place.join(",")}|${joint}`];
    const controls = axes.map((axis, k) => ({ ...axis, at: place[k], file: null, now: null, log: false, low: 0, high: 1 }));
    return { notes: [], pending: false, ...structuredClone(answer), problems, ask: body.ask, joint, controls };
  }

  at("name").textContent = known.name;
  if (!live) ["undo", "link", "save", "report", "fronts", "pin", "first"].forEach((id) => { at(id).hidden = true; });
  if (matchMedia("(max-width: 900px)").matches) at("sheet").open = false;
  const link = location.hash || known.link;
  history.replaceState(null, "", location.hash || `#${linkOf(ofLink(link).of)}`);
  begin(link);
})();
