// Tables, which become a card per row in narrow windows, and sorting by a column.
import { make, type Child } from "./elements";

export interface Column<Row> {
  name: string;
  cell: (row: Row) => Child;
  order?: (row: Row) => number | string | null; // by which it is sorted; null comes last
  number?: boolean;
}

type Key = number | string | null;

function before(a: Key, b: Key, ascending: boolean): number {
  if (a === null || b === null) return Number(a === null) - Number(b === null);
  const order =
    typeof a === "number" && typeof b === "number"
      ? a - b
      : String(a).localeCompare(String(b), "en", { numeric: true });
  return ascending ? order : -order;
}

/** `mark`: a class of a row, or null. Roles are named as narrow windows have rows as blocks. */
export function table<Row>(
  label: string,
  columns: Column<Row>[],
  rows: Row[],
  mark: (row: Row) => string | null = () => null,
): HTMLElement {
  const kind = (column: Column<Row>) => (column.number ? "number" : null);
  const lines = rows.map((row) => {
    const cells = columns.map((column) =>
      make(
        "td",
        { role: "cell", class: kind(column), "data-label": column.name },
        column.cell(row),
      ),
    );
    return { row, line: make("tr", { role: "row", class: mark(row) }, ...cells) };
  });
  const body = make("tbody", { role: "rowgroup" }, ...lines.map(({ line }) => line));
  const headings = columns.map((column) =>
    make("th", { role: "columnheader", scope: "col", class: kind(column) },
      column.order === undefined
        ? column.name
        : make("button", { type: "button", click: () => sort(column) }, column.name)),
  );
  const sort = (column: Column<Row>) => {
    const heading = headings[columns.indexOf(column)];
    const ascending = heading.getAttribute("aria-sort") !== "ascending";
    for (const other of headings) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
    const key = column.order!;
    const sorted = [...lines].sort((a, b) => before(key(a.row), key(b.row), ascending));
    body.append(...sorted.map(({ line }) => line));
  };
  const sorted = columns.some((column) => column.order !== undefined) ? " sorted" : "";
  const head = make("thead", { role: "rowgroup" }, make("tr", { role: "row" }, ...headings));
  return make("div", { class: "wide" },
    make("table", { role: "table", class: `cards${sorted}`, "aria-label": label }, head, body));
}
