// A click on the heading of a table sorts it.
"use strict";
(() => {
  function sortBy(heading) {
    const table = heading.closest("table"), k = heading.cellIndex, rows = [...table.tBodies[0].rows];
    const order = heading.ariaSort === "descending" ? 1 : -1;
    for (const other of table.tHead.rows[0].cells) other.ariaSort = null;
    heading.ariaSort = order > 0 ? "ascending" : "descending";
    const value = (row) => (row.cells[k].dataset.v === undefined ? NaN : Number(row.cells[k].dataset.v));
    rows.sort((a, b) => {
      const [x, y] = [value(a), value(b)];
      if (Number.isNaN(x) && Number.isNaN(y)) return -order * a.cells[k].textContent.localeCompare(b.cells[k].textContent);
      return Number.isNaN(x) ? 1 : Number.isNaN(y) ? -1 : order * (x - y || 0);
    });
    table.tBodies[0].append(...rows);
  }
  document.addEventListener("click", (event) => { if (event.target.closest("th")) sortBy(event.target.closest("th")); });
})();
