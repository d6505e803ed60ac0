'use strict';
// The interactive parts of a report: sliders between truth and result, and tables by a column.
for (const compare of document.querySelectorAll('.compare')) {
  const slider = compare.parentElement.querySelector('.slider');
  const show = (percent) => {
    slider.value = percent;
    compare.style.setProperty('--at', percent + '%');
  };
  const follow = (event) => {
    const box = compare.getBoundingClientRect();
    show(Math.min(100, Math.max(0, 100 * (event.clientX - box.left) / box.width)));
  };
  slider.addEventListener('input', () => show(Number(slider.value)));
  compare.addEventListener('pointerdown', (event) => {
    compare.setPointerCapture(event.pointerId);
    follow(event);
  });
  compare.addEventListener('pointermove', (event) => {
    if (event.buttons !== 0) follow(event);
  });
}

for (const heading of document.querySelectorAll('th.sort')) {
  const sort = () => {
    const body = heading.closest('table').tBodies[0];
    const column = heading.cellIndex;
    const ascending = heading.getAttribute('aria-sort') !== 'ascending';
    for (const other of heading.parentElement.cells) other.removeAttribute('aria-sort');
    heading.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
    const value = (row) => row.cells[column].textContent;
    const order = (a, b) => heading.classList.contains('number')
        ? (parseFloat(value(a)) || 0) - (parseFloat(value(b)) || 0)
        : value(a).localeCompare(value(b));
    const rows = [...body.rows].sort(order);
    if (!ascending) rows.reverse();
    body.append(...rows);
  };
  heading.tabIndex = 0;
  heading.addEventListener('click', sort);
  heading.addEventListener('keydown', (event) => {
    if (event.key === 'Enter') sort();
  });
}
