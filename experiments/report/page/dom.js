"use strict";
// Elements of the page, numbers, and boxes that scroll.

function show(value) {
  return String(Math.round(value * 1e6) / 1e6);
}

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

function make(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

function draw(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

// Arrow keys, Home and End go along elements, of which Tab reaches one; `reached` gets the index of the new one.
function walkable(elements, reached = () => {}) {
  elements.forEach((element, k) => {
    element.setAttribute("tabindex", k ? -1 : 0);
    element.addEventListener("focus", () => elements.forEach((other) => other.setAttribute("tabindex", other === element ? 0 : -1)));
    element.addEventListener("keydown", (event) => {
      const next = { ArrowRight: k + 1, ArrowDown: k + 1, ArrowLeft: k - 1, ArrowUp: k - 1, Home: 0, End: elements.length - 1 }[event.key];
      if (!elements[next]) return;
      event.preventDefault();
      event.stopPropagation();
      elements[next].focus();
      reached(next);
    });
  });
}

// Fade the content of a box that scrolls on each side where there is more; Tab reaches it while there is.
function watchEdges(box) {
  const mark = () => {
    const across = box.scrollWidth - box.clientWidth, down = box.scrollHeight - box.clientHeight;
    box.classList.toggle("more-left", box.scrollLeft > 1);
    box.classList.toggle("more-right", box.scrollLeft < across - 1);
    box.classList.toggle("more-below", box.scrollTop < down - 1);
    if (across > 1 || down > 1) box.tabIndex = 0;
    else box.removeAttribute("tabindex");
  };
  box.addEventListener("scroll", mark, { passive: true });
  const observer = new ResizeObserver(mark);
  for (const element of [box, ...box.children]) observer.observe(element);
  return box;
}

// `name`: for those who cannot see the box.
function scrollBox(name, kind, content) {
  return watchEdges(make("div", { class: `scroll ${kind}`, role: "region", "aria-label": name }, content));
}

// Where a picture is wider than its box, scroll to the part that matters now.
function bringIntoView(box, part) {
  if (!part || box.scrollWidth <= box.clientWidth) return;
  const frame = box.getBoundingClientRect(), here = part.getBoundingClientRect();
  if (here.left >= frame.left && here.right <= frame.right) return;
  box.scrollLeft += (here.left + here.right - frame.left - frame.right) / 2;
}
