"use strict";
const unknown = text => text === "–" || text === "";

for (const table of document.querySelectorAll("main table")) {
  const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells], original = [...body.rows];
  const key = (row, column) => {
    const cell = row.cells[column], text = cell.dataset.v ?? cell.firstChild?.data.trim() ?? "";
    return unknown(text) ? "" : /^-?[\d,]+(\.\d+)?$/.test(text) ? text.replaceAll(",", "") : text;
  };
  heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
    const was = head.getAttribute("aria-sort");
    heads.forEach(other => other.removeAttribute("aria-sort"));
    if (was === "descending") { body.append(...original); return; }  // third click: the order of the table
    const sign = was === "ascending" ? -1 : 1;
    head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
    body.append(...[...original].sort((a, b) => {
      const x = key(a, column), y = key(b, column);
      if (x === "" || y === "") return (x === "") - (y === "");      // what is unknown stays last
      const numbers = !isNaN(x) && !isNaN(y);
      return sign * (numbers ? x - y : x.localeCompare(y, "en", {numeric: true}));
    }));
  }));
  table.addEventListener("pointerover", event => {
    const cell = event.target.closest("td");
    if (cell?.dataset.v) cell.title = cell.dataset.v;
    else if (cell?.querySelector("small")) cell.title = cell.querySelector("small").textContent;
  });
}

for (const button of document.querySelectorAll("button.columns")) {
  button.hidden = false;
  button.addEventListener("click", () => {
    const all = document.getElementById(button.getAttribute("aria-controls")).classList.toggle("all");
    button.setAttribute("aria-pressed", all);
  });
}

for (const slider of document.querySelectorAll(".slider")) {
  const input = slider.querySelector("input"), figures = [...slider.querySelectorAll("figure")];
  const show = () => {
    figures.forEach((figure, number) => figure.classList.toggle("shown", number == input.value));
    input.setAttribute("aria-valuetext", figures[input.value].querySelector("figcaption").textContent);
  };
  slider.classList.add("on");
  input.addEventListener("input", show);
  show();
}

const theme = document.getElementById("theme"), schemes = ["light dark", "light", "dark"];
theme.hidden = false;
theme.addEventListener("click", () => {
  const next = (schemes.indexOf(document.documentElement.style.colorScheme || schemes[0]) + 1) % schemes.length;
  document.documentElement.style.colorScheme = schemes[next];
  theme.textContent = `theme: ${["auto", "light", "dark"][next]}`;
});
