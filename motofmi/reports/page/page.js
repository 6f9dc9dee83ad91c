// What a report's page does besides its charts: tables sort, say that they scroll, terms open beside their word.
"use strict";
(() => {
  for (const box of document.querySelectorAll(".scroller")) {
    const wide = box.querySelector(".wide");
    const look = () => {
      box.classList.toggle("scrolls", wide.scrollWidth > wide.clientWidth + 1);
      box.classList.toggle("ended", wide.scrollLeft + wide.clientWidth >= wide.scrollWidth - 2);
      const longer = wide.scrollHeight > wide.clientHeight + 1;
      box.classList.toggle("longer", longer);
      box.querySelector(".hint").textContent = `The table is ${[longer && "longer", box.classList.contains("scrolls") && "wider"].filter(Boolean).join(" and ")} than its frame: scroll it.`;
      wide.tabIndex = wide.scrollWidth > wide.clientWidth || wide.scrollHeight > wide.clientHeight ? 0 : -1;
    };
    wide.addEventListener("scroll", look);
    new ResizeObserver(look).observe(wide);
  }

  const value = (row, k) => row.cells[k].textContent.trim();
  const size = (text) => parseFloat(text.replace("< ", ""));
  function sort(heading, k) {
    const body = heading.closest("table").tBodies[0], up = heading.ariaSort !== "ascending";
    const rows = [...body.rows], numbers = rows.every((row) => value(row, k) === "" || !Number.isNaN(size(value(row, k))));
    const order = numbers ? (a, b) => (size(value(a, k)) || 0) - (size(value(b, k)) || 0) : (a, b) => value(a, k).localeCompare(value(b, k));
    rows.sort((a, b) => (up ? order(a, b) : order(b, a)));
    for (const other of heading.parentNode.cells) other.ariaSort = "none";
    heading.ariaSort = up ? "ascending" : "descending";
    body.append(...rows);
  }
  for (const heading of document.querySelectorAll("th")) {
    const button = heading.querySelector(".sort");
    if (button) button.addEventListener("click", () => sort(heading, heading.cellIndex));
  }

  for (const box of document.querySelectorAll("[popover]")) box.addEventListener("toggle", (event) => {
    if (event.newState !== "open") return;
    const word = document.activeElement?.closest?.(".term") || document.querySelector(`[popovertarget="${box.id}"]`);
    const at = word.getBoundingClientRect(), room = document.documentElement;
    box.style.left = `${Math.max(8, Math.min(at.left, room.clientWidth - box.offsetWidth - 8))}px`;
    box.style.top = `${at.bottom + box.offsetHeight + 8 > room.clientHeight ? Math.max(8, at.top - box.offsetHeight - 6) : at.bottom + 6}px`;
  });

  // A chart of a closed section has no size: it is drawn when the section opens.
  const draw = (root) => root.querySelectorAll(".chart:empty").forEach((element) => {
    if (element.checkVisibility()) motofmiCharts.draw(element, JSON.parse(element.nextElementSibling.textContent));
  });
  draw(document);
  for (const folded of document.querySelectorAll("details")) folded.addEventListener("toggle", () => draw(folded));
  window.addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((each) => { each.open = true; draw(each); }));
})();
