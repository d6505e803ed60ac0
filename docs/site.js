// Tables of the site without sideways scrolling: a table that is wider than its column, and on a
// narrow window each table of three or more columns, shows each row as a card (site.css).
(() => {
  const kNarrow = '(max-width: 44.9375em)';  // the theme's phone layout
  const kLongCode = 28;                      // characters; longer code may be broken
  const kCardColumns = 3;

  const columnsOf = (table) => table.tHead?.rows[0]?.cells.length ?? 0;

  /** Labels of the cells, for the cards, and the roles that `display` takes from a table. */
  function prepare(table) {
    const labels = [...table.tHead.rows[0].cells].map((cell) => cell.textContent.trim());
    table.setAttribute('role', 'table');
    for (const row of table.rows) row.setAttribute('role', 'row');
    for (const cell of table.tHead.rows[0].cells) cell.setAttribute('role', 'columnheader');
    for (const row of table.tBodies[0]?.rows ?? [])
      [...row.cells].forEach((cell, index) => {
        cell.setAttribute('role', 'cell');
        cell.dataset.label = labels[index];
        const content = document.createElement('div');
        content.append(...cell.childNodes);
        if (!content.hasChildNodes()) cell.dataset.empty = '';
        cell.append(content);
      });
  }

  function isTooWide(table) {
    const column = table.closest('.md-content__inner').getBoundingClientRect();
    return table.scrollWidth > table.clientWidth + 1 ||
        table.getBoundingClientRect().right > column.right + 1;
  }

  function fit(tables) {
    const isNarrow = matchMedia(kNarrow).matches;
    for (const table of tables) {
      delete table.dataset.cards;
      if ((isNarrow && columnsOf(table) >= kCardColumns) || isTooWide(table))
        table.dataset.cards = '';
    }
  }

  document.addEventListener('DOMContentLoaded', () => {
    const tables = [...document.querySelectorAll('.md-content__inner table:not([class])')]
                       .filter((table) => columnsOf(table) > 0);
    tables.forEach(prepare);
    for (const code of document.querySelectorAll('.md-content__inner code'))
      if (code.textContent.length > kLongCode) code.dataset.long = '';
    fit(tables);
    addEventListener('load', () => fit(tables));
    addEventListener('resize', () => fit(tables));
    for (const fold of document.querySelectorAll('.md-content__inner details'))
      fold.addEventListener('toggle', () => fit(tables));
  });
})();
