// Complaints about the page that is open: text that is cut or covered, faint text, parts that keys do not reach.

const audit = (() => {
  const SLACK = 2.5; // px; boxes of letters are larger than what is drawn

  const UNSEEN = ".hidden, .skip, [opacity='0'], script, style, title, template, noscript, option";

  function seen(element) {
    return !element.closest(UNSEEN) && element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
  }

  // The text on the page: every line with its rectangle, cut to what the boxes around it show.
  function lines() {
    const found = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const node = walker.currentNode, element = node.parentElement;
      if (!node.data.trim() || !seen(element)) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      const whole = element.closest("svg") ? [element.getBoundingClientRect()] : [...range.getClientRects()];
      const text = node.data.trim().slice(0, 40), broken = whole.length > 1 && /^\S{1,20}$/.test(text);
      for (const rect of whole) found.push({ element, text, rect, shown: cut(rect, element), broken });
    }
    return found;
  }

  // The boxes around an element that cut what they hold.
  function frames(element) {
    if (!element || element === document.body) return [];
    const own = getComputedStyle(element).overflow === "visible" ? [] : [element.getBoundingClientRect()];
    return [...own, ...frames(element.parentElement)];
  }

  function cut(rect, element) {
    let { left, top, right, bottom } = rect;
    for (const box of frames(element.closest("svg") || element)) {
      [left, top] = [Math.max(left, box.left), Math.max(top, box.top)];
      [right, bottom] = [Math.min(right, box.right), Math.min(bottom, box.bottom)];
    }
    return { left, top, right, bottom };
  }

  function* cutOff(all) {
    const page = document.documentElement;
    if (page.scrollWidth > page.clientWidth) yield `the page is ${page.scrollWidth} wide in a window of ${page.clientWidth}`;
    for (const { element, text, rect, shown, broken } of all) {
      if (broken) yield `"${text}" is broken into lines`;
      const svg = element.closest("svg");
      const box = svg ? svg.getBoundingClientRect() : null;
      if (box && (rect.left < box.left - 1 || rect.right > box.right + 1 || rect.top < box.top - SLACK || rect.bottom > box.bottom + SLACK)) {
        yield `"${text}" leaves its picture`;
      }
      if (element.closest(".scroll")) continue;
      if (rect.left < 0 || rect.right > page.clientWidth) yield `"${text}" leaves the window`;
      if (shown.right < rect.right - SLACK || shown.left > rect.left + SLACK || shown.bottom < rect.bottom - SLACK) yield `"${text}" is cut`;
    }
    for (const box of document.querySelectorAll("*")) {
      const across = box.scrollWidth - box.clientWidth, down = box.scrollHeight - box.clientHeight;
      const style = getComputedStyle(box);
      if (box === page || box === document.body || !seen(box) || box.closest("svg") || !/auto|scroll/.test(style.overflow)) continue;
      if (across <= 1 && down <= 1) continue;
      if (box.tabIndex !== 0) yield `${name(box)} scrolls, but not by keyboard`;
      const before = [box.scrollLeft, box.scrollTop];
      box.scrollTo(1e6, 1e6);
      if (Math.abs(box.scrollLeft - across) > 1 || Math.abs(box.scrollTop - down) > 1) yield `${name(box)} does not scroll to its end`;
      box.scrollTo(...before);
      if (box.scrollLeft < across - 1 && !(style.maskImage.includes("90deg") && box.classList.contains("more-right"))) yield `${name(box)} does not show that there is more`;
    }
  }

  function* covered(all) {
    const there = all.filter(({ element, shown }) => !element.closest(".transport") && shown.right > shown.left && shown.bottom > shown.top);
    for (let i = 0; i < there.length; i += 1) {
      for (let j = 0; j < i; j += 1) {
        const a = there[i].shown, b = there[j].shown;
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left), down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (across > SLACK && down > SLACK) yield `"${there[i].text}" lies on "${there[j].text}"`;
      }
    }
  }

  const pixel = Object.assign(document.createElement("canvas"), { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });

  // The luminance of colours that lie one on the other, the lowest first.
  function luminance(colours) {
    for (const colour of ["canvas", ...colours]) {
      pixel.fillStyle = colour;
      pixel.fillRect(0, 0, 1, 1);
    }
    const shown = [...pixel.getImageData(0, 0, 1, 1).data];
    const [r, g, b] = shown.map((part) => (part / 255 <= 0.04045 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  }

  // The backgrounds of an element and of all around it, the lowest first.
  function grounds(element) {
    return element ? [...grounds(element.parentElement), getComputedStyle(element).backgroundColor] : [];
  }

  function* faint(all) {
    const told = new Set();
    for (const { element, text } of all) {
      if (element.closest(":disabled")) continue;
      const style = getComputedStyle(element), below = grounds(element);
      const ink = element.closest("svg") ? style.fill : style.color;
      const [dark, light] = [luminance([...below, ink]), luminance(below)].sort((a, b) => a - b);
      const contrast = (light + 0.05) / (dark + 0.05), key = `${element.className.baseVal ?? element.className}${contrast}`;
      if (contrast >= 4.5 || told.has(key)) continue;
      told.add(key);
      yield `"${text}" has a contrast of ${contrast.toFixed(2)}`;
    }
  }

  function name(element) {
    return element.getAttribute("aria-label") || element.textContent.trim() || element.outerHTML.slice(0, 60);
  }

  function* unreachable() {
    for (const element of document.querySelectorAll("button, input, select, a, summary, [tabindex='0'], [role=button]")) {
      if (!seen(element) || element.disabled || element.classList.contains("skip")) continue;
      element.focus({ preventScroll: true });
      const style = getComputedStyle(element);
      const ring = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
      if (document.activeElement !== element) yield `${name(element)} takes no focus`;
      else if (!ring && !(element.closest("svg") && parseFloat(style.strokeWidth) >= 5)) yield `${name(element)} does not show its focus`;
    }
  }

  // With each picture in sight, the playback is in sight too and leaves most of the window free.
  function* outOfReach() {
    const playback = document.getElementById("transport");
    for (const picture of document.querySelectorAll(".view .picture, .view video, .timeline, .automaton")) {
      picture.scrollIntoView({ block: "center" });
      const box = playback.getBoundingClientRect();
      if (box.top < 0 || box.bottom > innerHeight + 1) yield `playback is out of sight of ${name(picture)}`;
      if (box.height > innerHeight / 5) yield "playback takes a fifth of the window";
    }
    scrollTo(0, 0);
  }

  function layout() {
    const all = lines();
    return [...cutOff(all), ...covered(all)];
  }

  return {
    layout,
    contrast: () => [...faint(lines())],
    access: () => [...unreachable()],
    playback: () => [...outOfReach()],
    settled: (done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60))),
  };
})();
window.audit = audit;
