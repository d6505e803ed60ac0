// The page of a report in Chromium, opened from the disk with made-up data: its charts, the viewer,
// its tables, and the comparison of two runs.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {kNarrow, kWide, onPage} from './report_browser.mjs';
import {comparisonData, imageAddress, reportData, runData, windowsData} from './report_data.mjs';

async function boxOf(locator) {
  await locator.scrollIntoViewIfNeeded();
  return locator.boundingBox();
}

/** Points the mouse at a share of the width of a chart's area. */
async function hover(page, chart, share) {
  const box = await boxOf(page.locator('.u-over').nth(chart));
  await page.mouse.move(box.x + share * box.width, box.y + box.height / 2, {steps: 2});
}

/** The step under the cursor of a chart. */
async function stepAt(page, chart) {
  const text = await page.locator('.chart .at').nth(chart).textContent();
  const [, number, thousands] = /^(?:step|second) ([\d.,]+)(k?)$/.exec(text) ?? assert.fail(text);
  return Number(number.replace(',', '')) * (thousands ? 1000 : 1);
}

function dividerPercent(page) {
  return page.locator('.viewer [role=slider]').first().getAttribute('aria-valuenow').then(Number);
}

// Bug put back: columns of charts that are never narrower than 28rem, and no style of narrow windows,
// so that tables stay tables; each seen to fail at 390 pixels.
const kPages = [['run', reportData(), 4], ['comparison', comparisonData(), 4],
                ['windows', windowsData(), 0]];
for (const [kind, data, charts] of kPages)
  for (const colorScheme of ['light', 'dark'])
    for (const viewport of [kWide, kNarrow])
      test(`${kind}, ${colorScheme}, fits a window of ${viewport.width} pixels`, async () => {
        await onPage(data, viewport, async (page) => {
          await page.evaluate(() => {
            for (const part of document.querySelectorAll('details')) part.open = true;
          });
          const width = await page.evaluate(() => document.documentElement.scrollWidth);
          assert.equal(width, viewport.width);
          assert.equal(await page.locator('.chart canvas').count(), charts);
          assert.equal(await page.evaluate(
              () => [...document.images].filter((i) => i.complete && i.naturalWidth === 0 &&
                                                       i.hasAttribute('src')).length), 0);
          for (const table of await page.locator('table').all())
            assert.ok(await table.evaluate((t) => t.scrollWidth <= t.parentElement.clientWidth));
        }, {colorScheme});
      });

// Bug put back: points without a value under the cursor are not skipped; seen to fail.
test('all charts show their values under the cursor of one', async () => {
  await onPage(reportData(), kWide, async (page) => {
    const values = () => page.locator('.chart').first().locator('b').allTextContents();
    assert.deepEqual(await values(), ['30.98 dB', '30.00 dB']);
    await hover(page, 0, 0.4984); // step 15,000 of 100 to 30,000: validation alone
    const [testViews, validation] = await values();
    assert.equal(validation, '29.81 dB');
    assert.ok(['30.45 dB', '30.63 dB'].includes(testViews), testViews);
    for (const chart of [0, 1, 2, 3]) assert.equal(await stepAt(page, chart), 15000);
    await page.mouse.move(5, 5, {steps: 2});
    assert.deepEqual(await values(), ['30.98 dB', '30.00 dB']);
  });
});

// Bug put back: charts without a shared cursor; seen to fail in the other chart.
test('dragging zooms all charts, and a double click shows the whole range', async () => {
  await onPage(reportData(), kWide, async (page) => {
    const box = await boxOf(page.locator('.u-over').nth(0));
    const y = box.y + box.height / 2;
    await page.mouse.move(box.x + 0.25 * box.width, y);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.5 * box.width, y, {steps: 4});
    await page.mouse.up();
    for (const chart of [0, 1]) {
      await hover(page, chart, 0.002);
      const step = await stepAt(page, chart);
      assert.ok(step > 6000 && step < 9000, `chart ${chart}: ${step}`);
    }
    const over = await boxOf(page.locator('.u-over').nth(0));
    await page.mouse.dblclick(over.x + 0.5 * over.width, over.y + over.height / 2);
    await hover(page, 1, 0.002);
    assert.ok(await stepAt(page, 1) < 500);
  });
});

// Bug put back: pinch() not called; seen to fail.
test('two fingers zoom all charts', async () => {
  await onPage(reportData(), kNarrow, async (page) => {
    const box = await boxOf(page.locator('.u-over').nth(0));
    const devices = await page.context().newCDPSession(page);
    const touch = (type, ...shares) => devices.send('Input.dispatchTouchEvent', {
      type, touchPoints: shares.map((share, id) => (
          {x: box.x + share * box.width, y: box.y + box.height / 2, id})),
    });
    await touch('touchStart', 0.4, 0.6);
    for (const half of [0.25, 0.3, 0.35, 0.4]) await touch('touchMove', 0.5 - half, 0.5 + half);
    await touch('touchEnd');
    for (const chart of [0, 1]) {
      await hover(page, chart, 0.01);
      assert.ok(await stepAt(page, chart) > 9000, `chart ${chart}: ${await stepAt(page, chart)}`);
    }
    await page.getByRole('button', {name: 'Whole range'}).click();
    await hover(page, 1, 0.01);
    assert.ok(await stepAt(page, 1) < 1000);
  }, {hasTouch: true});
});

// Bug put back: the columns stay those of steps, and losses of 0 stay on the logarithmic axis; each
// seen to fail.
test('charts have other axes, and files of what they show', async () => {
  const data = reportData();
  await onPage(data, kWide, async (page) => {
    const csv = async (chart) => {
      const [download] = await Promise.all([
        page.waitForEvent('download'), page.getByRole('button', {name: `CSV of ${chart}`}).click(),
      ]);
      const parts = [];
      for await (const part of await download.createReadStream()) parts.push(part);
      return Buffer.concat(parts).toString();
    };
    assert.equal((await csv('PSNR [dB]')).split('\n')[0], 'step,test views,validation views');
    await page.getByRole('button', {name: 'seconds'}).click();
    await hover(page, 1, 0.9999);
    assert.equal(await stepAt(page, 1), 600);
    assert.ok((await csv('PSNR [dB]')).startsWith('seconds,test views,validation views\n20,,'));
    await hover(page, 1, (10 - 2) / 598); // step 500, whose loss is 0: that of a neighbour
    const loss = page.locator('.chart').nth(1);
    assert.ok(Number(await loss.locator('b').textContent()) > 0.1);
    await loss.getByRole('button', {name: 'linear'}).click();
    await hover(page, 1, (10 - 2) / 598);
    assert.equal(await loss.locator('b').textContent(), '0');
    const [image] = await Promise.all([
      page.waitForEvent('download'), page.getByRole('button', {name: 'PNG of Loss'}).click(),
    ]);
    assert.equal(image.suggestedFilename(), 'loss.png');
  }, {acceptDownloads: true});
});

// Bug put back: charts do not follow the change; seen to fail.
test('charts are drawn in the colours of light and of dark', async () => {
  await onPage(reportData(), kWide, async (page) => {
    const drawn = () => page.locator('.chart canvas').first().evaluate((c) => c.toDataURL());
    // charts are drawn again some time after the change
    const becomes = async (holds) => {
      for (let waited = 0; waited < 5000 && !holds(await drawn()); waited += 50)
        await page.waitForTimeout(50);
      return holds(await drawn());
    };
    const light = await drawn();
    await page.emulateMedia({colorScheme: 'dark'});
    assert.ok(await becomes((image) => image !== light), 'dark');
    await page.emulateMedia({colorScheme: 'light'});
    assert.ok(await becomes((image) => image === light), 'light again');
  }, {colorScheme: 'light'});
});

// Bug put back: seconds are offered without regard to the curves; seen to fail.
test('seconds are offered only where they are known', async () => {
  const run = runData();
  run.curves.loss.seconds.fill(null);
  await onPage(reportData([run]), kWide, async (page) => {
    assert.equal(await page.getByRole('button', {name: 'seconds'}).count(), 0);
  });
});

// Bug put back: the viewer without pointermove and keydown; seen to fail.
test('the dividing line follows mouse and keys', async () => {
  await onPage(reportData(), kWide, async (page) => {
    const box = await boxOf(page.locator('.viewer > .compare'));
    const y = box.y + 0.3 * box.height;
    await page.mouse.move(box.x + 0.6 * box.width, y);
    await page.mouse.down();
    assert.equal(await dividerPercent(page), 60);
    await page.mouse.move(box.x + 0.25 * box.width, y, {steps: 3});
    await page.mouse.up();
    assert.equal(await dividerPercent(page), 25);
    await page.mouse.move(box.x + 0.75 * box.width, y);
    assert.equal(await dividerPercent(page), 25);
    await page.keyboard.press('ArrowRight'); // the line has the focus
    assert.equal(await dividerPercent(page), 27);
    await page.keyboard.press('End');
    assert.equal(await dividerPercent(page), 100);
  });
});

// Bug put back: without touch-action the browser takes the touch to scroll; seen to fail.
test('the dividing line follows a finger', async () => {
  await onPage(reportData(), kNarrow, async (page) => {
    const box = await boxOf(page.locator('.viewer > .compare'));
    const devices = await page.context().newCDPSession(page);
    const touch = (type, ...shares) => devices.send('Input.dispatchTouchEvent', {
      type, touchPoints: shares.map((share) => (
          {x: box.x + share * box.width, y: box.y + 0.3 * box.height})),
    });
    await touch('touchStart', 0.5);
    for (const share of [0.55, 0.6, 0.7, 0.8]) await touch('touchMove', share);
    await touch('touchEnd');
    assert.equal(await dividerPercent(page), 80);
  }, {hasTouch: true, isMobile: true});
});

// Bug put back: the error map's button changes its look alone; seen to fail.
test('views are chosen by buttons, thumbnails and keys, and show their error', async () => {
  const data = reportData();
  const [run] = data.runs;
  await onPage(data, kWide, async (page) => {
    const shown = () => page.locator('.viewer > .compare img.right').getAttribute('src');
    const errors = page.getByRole('button', {name: 'Error map'});
    assert.equal(await shown(), run.views[0].result);
    await errors.click();
    assert.equal(await shown(), run.views[0].error);
    assert.ok(await page.locator('.scale').isVisible());
    await page.getByRole('button', {name: 'best', exact: true}).click();
    assert.equal(await shown(), run.views[4].error);
    await errors.click();
    assert.equal(await shown(), run.views[4].result);
    await page.getByRole('button', {name: 'cam01/frame_0002'}).first().click();
    assert.equal(await shown(), run.views[8].result);
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('ArrowLeft');
    assert.equal(await shown(), run.views[6].result);
    await page.getByRole('button', {name: 'Full size'}).focus();
    await page.keyboard.press('Enter');
    const full = page.locator('dialog .compare');
    assert.equal((await full.boundingBox()).width, 320);
    assert.equal(await full.locator('img.right').getAttribute('src'), run.views[6].result);
    await page.keyboard.press('Escape');
    assert.ok(!(await full.isVisible()));
  });
});

// Bug put back: numbers compared as text; seen to fail.
test('the table of views is sorted by keys', async () => {
  const data = reportData();
  data.runs[0].views[3].psnr = 9.5;
  await onPage(data, kWide, async (page) => {
    await page.locator('summary', {hasText: '12 test views'}).click();
    const table = page.getByRole('table', {name: 'all views'});
    const column = async (index) =>
        (await table.locator(`tbody td:nth-child(${index})`).allTextContents()).map(Number);
    await table.getByRole('button', {name: 'PSNR'}).focus();
    await page.keyboard.press('Enter');
    const up = await column(4);
    assert.equal(up[0], 9.5);
    assert.deepEqual(up, [...up].sort((a, b) => a - b));
    await page.keyboard.press('Enter');
    assert.deepEqual(await column(4), up.reverse());
    assert.equal(await table.locator('th[aria-sort=descending]').count(), 1);
    await table.getByRole('button', {name: 'moving'}).focus();
    await page.keyboard.press('Space');
    assert.ok((await column(5)).slice(-2).every(Number.isNaN)); // unknown values come last
  });
});

// Bug put back: the means without what they look like; seen to fail.
test('the scores are followed by what they look like', async () => {
  await onPage(reportData(), kWide, async (page) => {
    assert.match(await page.locator('.scores + p').textContent(),
                 /^Sharp where it stands still, good where it moves\. Scores are means over /);
  });
});

// Bugs put back: a window without a score is the lowest; the ratio of the borders turned round; each
// seen to fail.
test('a clip in windows shows its lowest one, its borders, and all of them in a table', async () => {
  await onPage(windowsData(), kWide, async (page) => {
    const tile = (name) => page.locator('.scores div', {hasText: name}).locator('dd')
        .allTextContents();
    assert.deepEqual(await tile('Lowest window'), ['25.00 dB', 'number 5, 20.0 to 25.0 s']);
    assert.deepEqual(await tile('Borders'),
                     ['1.60 ×', 'moving pixels 1.04 ×; temporal error by that inside windows']);
    await page.locator('summary', {hasText: '12 windows'}).click();
    const table = page.getByRole('table', {name: 'windows'});
    await table.getByRole('button', {name: 'PSNR'}).click();
    assert.equal(await table.locator('tbody td').first().textContent(), '5');
    assert.equal(await table.locator('tbody tr').count(), 12);
  });
});

// Bug put back: texts of warnings set as innerHTML; seen to fail.
test('texts with tags are shown as text, and paths may have any letters', async () => {
  const data = reportData();
  await onPage(data, kWide, async (page) => {
    const {stage, text} = data.runs[0].warnings[0];
    assert.equal(await page.locator('.warnings li').textContent(), `${stage}: ${text}`);
    assert.equal(await page.locator('h1').textContent(), data.title);
    const first = page.locator('.links a').first();
    assert.equal(await first.textContent(), 'Player');
    assert.equal(await first.getAttribute('href'), 'player%201%23.html');
  });
});

// Bug put back: views of runs paired by their place; seen to fail.
test('a comparison pairs views by name', async () => {
  const data = comparisonData();
  const [one, two] = data.runs;
  const name = 'cam00/frame_0003';
  two.views.find((view) => view.name === name).result = imageAddress('#123456');
  await onPage(data, kWide, async (page) => {
    const shown = (side) => page.locator(`.viewer > .compare img.${side}`).getAttribute('src');
    const imageOf = (run, key) => run.views.find((view) => view.name === name)[key];
    await page.getByRole('button', {name}).first().click();
    assert.equal(await shown('left'), imageOf(one, 'result'));
    assert.equal(await shown('right'), imageAddress('#123456'));
    await page.getByLabel('left side').selectOption('truth');
    assert.equal(await shown('left'), imageOf(one, 'truth'));
    await page.getByLabel('right side').selectOption('one');
    assert.equal(await shown('right'), imageOf(one, 'result'));
    const options = page.getByRole('table', {name: 'options that differ'});
    assert.deepEqual(await options.locator('tbody tr').allTextContents(),
                     ['cloudingestdefaultsparse', 'initial pointstrain1000 points90 points',
                      'motiontrainnodespair', 'seed_pointstrain–5']);
    assert.match(await page.getByRole('table', {name: 'scores'}).textContent(), /two.*31\.66 dB/);
  });
});

// Bugs put back: a legend without names; a warning listed for each run; no links; each seen to fail.
test('a comparison names its runs in legends, lists warnings once, and leads to the runs', async () => {
  await onPage(comparisonData(), kWide, async (page) => {
    const legend = (chart) => page.locator('.chart .legend').nth(chart).locator('span:not(.at)')
        .evaluateAll((entries) => entries.map((entry) => entry.childNodes[1].textContent));
    assert.deepEqual(await legend(0), ['one, test views', 'one, validation views',
                                       'two, test views', 'two, validation views']);
    assert.deepEqual(await legend(1), ['one', 'two']);
    assert.deepEqual((await page.locator('.warnings li').allTextContents()).map(
        (text) => text.replace(/^.*(?=\()/, '')), ['(all 2 runs)', '(two)']);
    const row = page.getByRole('table', {name: 'scores'}).locator('tbody tr').nth(1);
    assert.deepEqual(await row.locator('a').evaluateAll((links) => links.map(
        (link) => link.getAttribute('href'))), ['../two/report/index.html', 'player%201%23.html']);
  });
});

// Bugs put back: as many tiles a row as there is room for; the cards of cameras with a line a column;
// each seen to fail.
test('tiles fill rows evenly, and cards of cameras are short', async () => {
  const run = runData();
  Object.assign(run, {objects: [], worst: null, scores: {...run.scores, lpips: null}});
  for (const [width, rows] of [[1343, [3, 3]], [900, [3, 3]], [390, [2, 2, 2]]])
    await onPage(reportData([run]), {width, height: 800}, async (page) => {
      const tops = await page.locator('.scores div').evaluateAll(
          (tiles) => tiles.map((tile) => tile.offsetTop));
      assert.deepEqual([...new Set(tops)].map((top) => tops.filter((t) => t === top).length), rows);
      const camera = page.getByRole('table', {name: 'cameras'}).locator('tbody tr').first();
      assert.ok((await camera.boundingBox()).height < 150, `${width}`);
    });
});

// Bug put back: the decisions as paragraphs before the curves; seen to fail.
test('what the training decided is a folded table after the curves', async () => {
  await onPage(reportData(), kWide, async (page) => {
    const decisions = page.getByRole('table', {name: 'decisions'});
    assert.ok(!(await decisions.isVisible()));
    await page.locator('summary', {hasText: 'What the training decided'}).click();
    assert.deepEqual(await decisions.locator('tbody tr').first().locator('td').allTextContents(),
                     ['3,000', 'Densification stops: 180k Gaussians are enough.',
                      '190,000 → 182,345', '50,000 → 45,210']);
    const top = (locator) => locator.boundingBox().then(({y}) => y);
    assert.ok(await top(decisions) > await top(page.locator('.charts')));
  });
});

// Bug put back: a schema of 2 is read as 1; seen to fail.
test('what cannot be shown is said in one line', async () => {
  for (const [data, words] of [[{schema: 2, runs: [{}]}, /schema 2/], [null, /no report/],
                               [{schema: 1, runs: []}, /no runs/]])
    await onPage(data, kWide, async (page) => {
      assert.match(await page.getByRole('alert').textContent(), words);
    });
});

// Bug put back: the section of cameras is drawn without regard to their number; seen to fail.
test('what a run lacks is absent', async () => {
  const run = runData();
  const empty = {step: [], seconds: [], value: []};
  Object.assign(run, {views: [], cameras: [], decisions: [], warnings: [], files: [], stages: [],
                      objects: [], options: {}, worst: null, image_note: 'No images.'});
  for (const name of Object.keys(run.curves)) run.curves[name] = empty;
  for (const name of Object.keys(run.scores)) run.scores[name] = null;
  await onPage(reportData([run]), kWide, async (page) => {
    assert.deepEqual(await page.locator('h2').allTextContents(), ['Views', 'Run']);
    assert.ok(await page.getByText('No images.').isVisible());
    assert.ok(!/null|NaN|undefined/.test(await page.locator('main').textContent()));
  });
});
