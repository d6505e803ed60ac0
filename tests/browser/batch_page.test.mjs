// The page of a batch in Chromium, opened from the disk with made-up data: failures, tables of
// variants, the chart of quality against cost, and scenes that are built when they are opened.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {batchData} from './batch_data.mjs';
import {kNarrow, kWide, onPage} from './report_browser.mjs';

// Finds: the chart as wide as its viewBox in pixels.
for (const colorScheme of ['light', 'dark'])
  for (const viewport of [kWide, kNarrow])
    test(`${colorScheme}, fits a window of ${viewport.width} pixels`, async () => {
      await onPage(batchData(), viewport, async (page) => {
        const width = await page.evaluate(() => document.documentElement.scrollWidth);
        assert.equal(width, viewport.width);
        assert.equal(await page.locator('svg.scatter').count(), 2);
      }, {colorScheme});
    });

// Finds: the lowest PSNR is best; the mean over scenes includes each twice; a cell of the
// training where the whole command is known.
test('scenes by presets, with means and the best in bold', async () => {
  await onPage(batchData(), kWide, async (page) => {
    const table = page.getByRole('table', {name: 'PSNR of all scenes'});
    const rows = await table.locator('tbody tr').allTextContents();
    assert.deepEqual(rows, [
      'hall27.00 dB13.0 s, 4.0 MB30.00 dB22.0 s, 8.0 MB31.00 dB1:09 min, 12.0 MB',
      'garden <b> training views28.00 dB13.0 s, 4.0 MB31.00 dB22.0 s, 8.0 MB32.00 dB1:09 min, 12.0 MB',
      'mean of 2 scenes27.50 dB13.0 s, 4.0 MB30.50 dB22.0 s, 8.0 MB31.50 dB1:09 min, 12.0 MB',
    ]);
    assert.deepEqual(await table.locator('strong').allTextContents(),
                     ['31.00 dB', '32.00 dB', '31.50 dB']);
    assert.deepEqual(await table.locator('th').allTextContents(),
                     ['scene', 'fast', 'balanced, 3000', 'best']);
    assert.equal(await page.getByText('Scored on training views').count(), 1);
    const row = page.getByRole('table', {name: 'presets on hall'}).locator('tbody tr').first();
    assert.equal(await row.textContent(), 'fast31,00027.00 dB26.70–27.300.900013.0 s12.5 s–13.5 s' +
                                              '4.0 s3.8 s–4.2 s100k4.0 MB20.0 MB');
    assert.deepEqual(await page.locator('ul.soft').first().locator('li').allTextContents(), [
      'best: PSNR 30.50 dB, training 5:00 min (a paper, RTX 4090)',
      'best: PSNR 27.50 dB, training 6:40 min (a paper, mean of others)']);
  });
});

// Finds: published figures of other scenes in the chart; figures of others on the front; the
// front by the first axis whatever is shown; the knee not marked.
test('quality against cost, by pointer, keys and axis', async () => {
  await onPage(batchData(), kWide, async (page) => {
    const figure = page.getByRole('figure', {name: 'Quality on hall'});
    const svg = figure.locator('svg');
    const front = async () => (await svg.locator('.front').getAttribute('points')).split(' ').length;
    assert.equal(await svg.locator('circle').count(), 3, 'no published figure has the whole command');
    assert.equal(await front(), 3);
    assert.equal(await svg.locator('circle[r="8"]').count(), 1);
    await svg.focus();
    await page.keyboard.press('ArrowRight');
    assert.match(await figure.locator('.at').textContent(), /^fast: 27\.00 dB, whole command 13\.0 s/);
    await page.keyboard.press('ArrowRight');
    assert.match(await figure.locator('.at').textContent(), /^balanced, 3000: 30\.00 dB/);
    const box = await svg.locator('circle').nth(2).boundingBox();
    await page.mouse.move(box.x + 2, box.y + 2);
    assert.match(await figure.locator('.at').textContent(), /^best: 31\.00 dB/);
    await figure.getByRole('button', {name: 'training'}).click();
    assert.equal(await svg.locator('circle').count(), 4);
    assert.equal(await front(), 3, 'another machine is on no front');
    const published = await svg.locator('circle').last().boundingBox();
    await page.mouse.move(published.x + 2, published.y + 2);
    assert.equal(await figure.locator('.at').textContent(),
                 '30.50 dB: a paper, RTX 4090, another machine');
    await figure.getByRole('button', {name: '4D file'}).click();
    assert.match(await svg.textContent(), /4D file \[MB\]/);
  });
});

// Finds: all scenes are built at once.
test('many scenes are folded and built when they are opened', async () => {
  await onPage(batchData({count: 6}), kWide, async (page) => {
    assert.equal(await page.locator('svg.scatter').count(), 0);
    await page.locator('summary', {hasText: 'garden <b>'}).click();
    await page.locator('svg.scatter').waitFor();
    assert.equal(await page.locator('svg.scatter').count(), 1);
    await page.locator('summary', {hasText: 'garden <b>'}).click();
    await page.locator('summary', {hasText: 'garden <b>'}).click();
    assert.equal(await page.locator('svg.scatter').count(), 1);
  });
});

// Finds: failures below the scores; a colour for each seed; views of seeds.
test('failures come first, seeds share a colour, presets are compared by their views', async () => {
  const failures = [{line: 'barn: train, fast, seed 2 (exit 1): <loss>', log: '../logs/a b.log'}];
  await onPage(batchData({failures}), kWide, async (page) => {
    const [first] = await page.locator('h2').allTextContents();
    assert.equal(first, 'Failures');
    const log = page.getByRole('link', {name: 'log'});
    assert.equal(await log.getAttribute('href'), '../logs/a%20b.log');
    assert.equal(await page.getByText('ingest: hall: the clocks differ').count(), 1);
    const legend = page.getByRole('figure', {name: 'Loss'}).first().locator('.legend');
    assert.deepEqual(await legend.locator('span:not(.at)').allTextContents(),
                     ['fast', 'balanced', 'best'].map((name) => `${name} 0.02 0.02`));
    const viewer = page.locator('.viewer').first();
    assert.deepEqual(await viewer.locator('.compare').first().locator('span').allTextContents(),
                     ['fast', 'balanced']);
  });
});
