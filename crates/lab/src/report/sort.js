"use strict";
// A click on the head of a column sorts its table, a second one the other way round. Heads become buttons, so that the
// keyboard reaches them. Cells without a value stay last either way.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  const heads = [...table.tHead.rows[0].cells];
  const compareText = new Intl.Collator("en", { numeric: true }).compare;

  const sort = (head, column) => {
    const isText = head.classList.contains("text");
    const isDescending = head.getAttribute("aria-sort") === "ascending";
    const key = (row) => row.cells[column].dataset.value;
    const compare = (a, b) => {
      if (a === "" || b === "") return (a === "") - (b === "");
      // Subtraction would make NaN of two infinities.
      const order = isText ? compareText(a, b) : (Number(a) > Number(b)) - (Number(a) < Number(b));
      return isDescending ? -order : order;
    };
    body.append(...[...body.rows].sort((a, b) => compare(key(a), key(b))));
    for (const other of heads) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", isDescending ? "descending" : "ascending");
  };

  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sort(head, column));
    head.append(button);
    head.setAttribute("aria-sort", "none");
  });
}
