"use strict";

// What the page drew and what went wrong, written where a script that opens the page can read it:
// lines "chart NAME MARKS", "error TEXT", and "drawn" at the end.
const journal = text => { document.getElementById("journal").textContent += `${text}\n`; };

window.addEventListener("error", event => journal(`error ${event.message}`));
window.addEventListener("unhandledrejection", event => journal(`error ${event.reason}`));
const logError = console.error;
console.error = (...words) => {
  journal(`error ${words.join(" ")}`);
  logError(...words);
};

function writeJournal(charts) {
  for (const {name, svg} of charts) journal(`chart ${name} ${countMarks(svg.node())}`);
  journal("drawn");
}

/** The number of data marks inside a chart: subpaths of its paths of class "mark" that start in view. */
function countMarks(svg) {
  for (const element of svg.querySelectorAll("*")) {
    for (const {name, value} of element.attributes) {
      if (/NaN|undefined|Infinity/.test(value)) {
        journal(`error <${element.tagName} ${name}="${value.slice(0, 40)}">`);
      }
    }
  }
  const {width, height} = svg.viewBox.baseVal;
  const starts = path => [...(path.getAttribute("d") || "").matchAll(/M([-\d.]+),([-\d.]+)/g)];
  const inView = ([, x, y]) => x >= 0 && x <= width && y >= 0 && y <= height;
  return [...svg.querySelectorAll("path.mark")].flatMap(starts).filter(inView).length;
}
