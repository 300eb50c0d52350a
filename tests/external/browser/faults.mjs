// What is cut off, off screen or too faint to read, each in words.
export const faults = (page) => page.evaluate(() => {
  const found = [], shown = (e) => e.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true });
  const hidden = (e) => e.closest(".unseen, .skip, .blocks thead");
  const say = (e) => `${e.tagName.toLowerCase()} "${(e.textContent || e.getAttribute("aria-label") || "").trim().slice(0, 40)}"`;
  for (const e of document.querySelectorAll("body *")) {
    if (!shown(e) || hidden(e)) continue;
    const box = e.getBoundingClientRect();
    if (box.width && (box.right > innerWidth + 1 || box.left < -1)) found.push(`${say(e)} is off screen: ${Math.round(box.left)} to ${Math.round(box.right)}`);
    const clips = getComputedStyle(e).overflowX !== "visible";
    if (clips && e.scrollWidth > e.clientWidth + 1 && e.tagName !== "INPUT") found.push(`${say(e)} is cut: ${e.scrollWidth} in ${e.clientWidth} px`);
  }
  const numbers = (colour) => colour.match(/[\d.]+/g).map(Number);
  const light = ([r, g, b]) => {
    const [x, y, z] = [r, g, b].map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * x + 0.7152 * y + 0.0722 * z;
  };
  const ground = (e) => {
    for (let on = e; on; on = on.parentElement) {
      const colour = numbers(getComputedStyle(on).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const seen = new Set(), walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode()); ) {
    const e = node.parentElement;
    if (!node.data.trim() || !shown(e) || hidden(e) || e.closest("[aria-pressed='false'].legend button")) continue;
    const style = getComputedStyle(e), colour = numbers(style.color), under = ground(e), key = `${colour} ${under} ${style.fontSize}`;
    if (seen.has(key)) continue;
    seen.add(key);
    const [a, b] = [light(colour), light(under)].sort((x, y) => y - x), contrast = (a + 0.05) / (b + 0.05);
    const large = parseFloat(style.fontSize) >= 24;
    if (contrast < (large ? 3 : 4.5)) found.push(`${say(e)} has a contrast of ${contrast.toFixed(2)}`);
  }
  return found;
});
