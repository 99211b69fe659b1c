"use strict";
document.querySelectorAll(".tabs").forEach((tabs) => {
  const panels = [...tabs.querySelectorAll(":scope > .panel")];
  if (panels.length < 2) return;
  const list = document.createElement("div");
  list.className = "tablist";
  list.setAttribute("role", "tablist");
  const open = (chosen) => panels.forEach((panel, i) => {
    panel.classList.toggle("open", i === chosen);
    list.children[i].setAttribute("aria-selected", String(i === chosen));
    list.children[i].tabIndex = i === chosen ? 0 : -1;
  });
  panels.forEach((panel, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = panel.dataset.label;
    button.setAttribute("role", "tab");
    button.setAttribute("aria-controls", panel.id);
    button.addEventListener("click", () => open(i));
    button.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const next = (i + step + panels.length) % panels.length;
      open(next);
      list.children[next].focus();
    });
    panel.setAttribute("role", "tabpanel");
    list.append(button);
  });
  tabs.prepend(list);
  tabs.classList.add("live");
  open(0);
});
const table = document.getElementById("all-rows");
if (table) {
  const rows = [...table.tBodies[0].rows];
  const search = document.getElementById("row-search");
  const iso = document.getElementById("row-iso");
  const best = document.getElementById("row-best");
  const count = document.getElementById("row-count");
  const filter = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    rows.forEach((row) => {
      const text = row.textContent.toLowerCase();
      const fits = words.every((word) => text.includes(word)) && (!iso.value || row.dataset.iso === iso.value) &&
        (!best.value || row.dataset.best === "1");
      row.hidden = !fits;
      shown += fits ? 1 : 0;
    });
    count.textContent = `${shown} of ${rows.length} rows`;
  };
  [search, iso, best].forEach((field) => field.addEventListener("input", filter));
  filter();
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    head.tabIndex = 0;
    const sort = () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      [...table.tHead.rows[0].cells].forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const text = (row) => row.cells[column].textContent;
      const number = (row) => row.cells[column].dataset.sort === "" ? -Infinity : Number(row.cells[column].dataset.sort);
      const numeric = rows.some((row) => "sort" in row.cells[column].dataset);
      rows.sort((a, b) => numeric ? number(a) - number(b) || 0 : text(a).localeCompare(text(b), "en", { numeric: true }));
      if (down) rows.reverse();
      table.tBodies[0].append(...rows);
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => { if (event.key === "Enter") sort(); });
  });
}
document.querySelectorAll('a[href^="#def-"]').forEach((link) => link.addEventListener("click", () => {
  const target = document.querySelector(link.getAttribute("href"));
  if (target) target.closest("details")?.setAttribute("open", "");
}));
