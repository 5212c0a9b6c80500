"use strict";
// All text goes into the page as text: names and comments come from files.
const drawn = {};

function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element && typeof value !== "string") element[name] = value;
    else if (value !== false && value !== null) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== ""));
  return element;
}
const button = (text, onclick, kind = "plain", more = {}) => h("button", { type: "button", class: kind, onclick, ...more }, text);
const seconds = (t) => t === null ? "" : t < 60 ? `${t.toPrecision(4)} s` : `${Math.floor(t / 60)} min ${(t % 60).toFixed(1)} s`;

/* Replaces what is in a place where its data have changed; what has the focus, or is unfolded, stays so. */
function put(place, key, data, make) {
  const text = JSON.stringify(data);
  if (drawn[key] === text && place.childNodes.length) return;
  drawn[key] = text;
  const focus = place.contains(document.activeElement) ? document.activeElement.dataset.focus : null;
  const open = new Set([...place.querySelectorAll("details[open]")].map((each) => each.dataset.fold));
  place.replaceChildren(...[make()].flat());
  for (const each of place.querySelectorAll("details")) each.open ||= open.has(each.dataset.fold);
  if (focus) place.querySelector(`[data-focus="${CSS.escape(focus)}"]`)?.focus();
}
