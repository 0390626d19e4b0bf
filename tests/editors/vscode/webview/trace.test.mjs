// The trace viewer in Chromium: what it shows, the keyboard, screen readers, data that would like to be more, and how much it
// draws of very long runs.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { opener, THEMES, violations } from './page.mjs';
import { MACHINE, trace } from './traces.mjs';

let pages;
before(async () => (pages = await opener('src/trace/page.ts', 'src/webview/trace.ts')));
after(() => pages.close());

const position = (it) => it.page.locator('#position').textContent();
const drawn = (it) => it.page.evaluate(() => ({ ...window.dotgenTrace.last, from: window.dotgenTrace.window.from, to: window.dotgenTrace.window.to }));
async function key(it, name, times = 1) {
  for (let i = 0; i < times; i++) await it.page.keyboard.press(name);
  await it.frame();
}

for (const theme of Object.keys(THEMES)) {
  test(`names and roles for screen readers: ${theme}`, async () => {
    const it = await pages.open({ theme });
    assert.deepEqual(await violations(it.page), [], 'empty');
    await it.send({ type: 'trace', trace: trace(40) });
    const { step } = (await it.said()).at(-1);
    await it.send({ type: 'machine', step, machine: MACHINE });
    await it.send({ type: 'notice', text: 'The text has changed.' });
    assert.deepEqual(await violations(it.page), [], 'with a run');
    await it.page.close();
  });
}

test('it opens where the run fails, and little of the picture is empty', async () => {
  const it = await pages.open();
  const run = trace(400);
  await it.send({ type: 'trace', trace: run });
  const { from, to } = await drawn(it);
  assert.ok(from < run.focus.at && to > run.focus.at && (to - run.end) < (to - from) / 6, `${from} ${to} ${run.focus.at}`);
  assert.equal(await position(it), `step ${run.steps.length} of ${run.steps.length}`);
  await it.page.close();
});

test('the keyboard reaches every step, all of time, and every button', async () => {
  const it = await pages.open();
  const run = trace(200);
  await it.send({ type: 'trace', trace: run });
  await it.page.locator('#trace').focus();
  await key(it, 'ArrowLeft', 3);
  assert.equal(await position(it), `step ${run.steps.length - 3} of ${run.steps.length}`);
  const { at, lane, what } = run.steps.at(-4);
  const told = await it.page.locator('#told').textContent();
  assert.ok(told.includes(`${at} ms`) && told.includes(run.lanes[lane].name) && told.includes(what), told);
  assert.equal(await it.page.locator('#names .current').textContent(), run.lanes[lane].name);
  assert.deepEqual((await it.said()).at(-1), { type: 'step', step: run.steps.length - 4 });
  // In the same lane.
  await key(it, 'ArrowUp');
  const before = run.steps.map((step, i) => [step.lane, i]).filter(([of, i]) => of === lane && i < run.steps.length - 4).at(-1)[1];
  assert.equal(await position(it), `step ${before + 1} of ${run.steps.length}`);
  await key(it, 'Home');
  assert.equal(await position(it), `step 1 of ${run.steps.length}`);
  const window = await drawn(it);
  assert.ok(window.from <= run.steps[0].at && run.steps[0].at <= window.to, 'the step is in sight');
  await key(it, '+');
  const near = await drawn(it);
  assert.ok(near.to - near.from < window.to - window.from);
  await key(it, 'Shift+ArrowRight');
  assert.ok((await drawn(it)).from > near.from);
  await key(it, '0');
  const whole = await drawn(it);
  assert.ok(whole.from < run.start && whole.to > run.end);
  await key(it, 'f');
  assert.equal(await position(it), `step ${run.steps.length} of ${run.steps.length}`);
  await key(it, 'Enter');
  assert.deepEqual((await it.said()).at(-1), { type: 'go', step: run.steps.length - 1 });
  // With Tab alone, from the beginning.
  await it.page.locator('h1').evaluate((title) => { title.tabIndex = -1; title.focus(); });
  const seen = new Set();
  for (let i = 0; i < 20; i++) {
    await it.page.keyboard.press('Tab');
    seen.add(await it.page.evaluate(() => document.activeElement?.id || document.activeElement?.tagName));
  }
  const buttons = await it.page.locator('button:visible').evaluateAll((all) => all.map((button) => button.id));
  assert.ok(buttons.length >= 9, buttons.join(' '));
  assert.deepEqual([...buttons, 'trace', 'ASIDE'].filter((id) => !seen.has(id)), []);
  await it.page.close();
});

test('a wait names who has the lock, and the rule that acted', async () => {
  const it = await pages.open();
  const run = trace(60);
  await it.send({ type: 'trace', trace: run });
  await it.page.locator('#trace').focus();
  const wait = run.steps.findLastIndex((step) => step.rule === 'wait');
  await key(it, 'ArrowLeft', run.steps.length - 1 - wait);
  const text = await it.page.locator('#step').textContent();
  const [holder] = run.spans.find((span) => span.step === wait).by;
  assert.ok(text.includes(holder.name) && text.includes(run.lanes[holder.lane].name) && text.includes('of the ids'), text);
  assert.ok(text.includes(run.rules.wait), text);
  await it.page.close();
});

test('the mouse: a click chooses, the wheel zooms at the pointer, a drag moves time', async () => {
  const it = await pages.open({ height: 900 });
  const run = trace(60);
  await it.send({ type: 'trace', trace: run });
  await key(it, '0');
  const box = await it.page.locator('#canvas').boundingBox();
  const whole = await drawn(it);
  const x = (at) => box.x + ((at - whole.from) / (whole.to - whole.from)) * box.width;
  const span = run.spans.filter((one) => one.lane === 2 && one.kind === 'run')[1];
  // The name of a lane is as high as the lane; spans of one row are in the middle of 32 pixels.
  const y = (await it.page.locator('#names [data-lane="2"]').boundingBox()).y + 16;
  await it.page.mouse.click(x((span.from + span.to) / 2), y);
  assert.deepEqual((await it.said()).at(-1), { type: 'step', step: span.step });
  const at = (span.from + span.to) / 2;
  await it.page.mouse.move(x(at), y);
  await it.page.mouse.wheel(0, -300);
  await it.frame();
  const near = await drawn(it);
  assert.ok(near.to - near.from < (whole.to - whole.from) / 1.5);
  const share = (window) => (at - window.from) / (window.to - window.from);
  assert.ok(Math.abs(share(near) - share(whole)) < 0.01);
  await it.page.mouse.down();
  await it.page.mouse.move(x(at) + 100, y, { steps: 4 });
  await it.page.mouse.up();
  await it.frame();
  const moved = await drawn(it);
  assert.ok(Math.abs(near.from - moved.from - (100 / box.width) * (near.to - near.from)) < (near.to - near.from) / 200);
  assert.deepEqual(it.errors, []);
  await it.page.close();
});

test('many remedies leave room for the lanes in a small pane', async () => {
  const it = await pages.open({ width: 340, height: 290 });
  const remedies = ['pump.report.start', 'pump.control', 'pump.report', 'pump.control.main'].map((name) => ({ title: `Give \`${name}\` a budget of 5 ms`, previews: true }));
  await it.send({ type: 'trace', trace: trace(200), remedies });
  const { height } = await it.page.locator('#trace').boundingBox();
  assert.ok(height >= 60, `${height} pixels`);
  assert.deepEqual(await violations(it.page), []);
  if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/trace-remedies.png` });
  await it.page.close();
});

test('a remedy shows the run with it while it is pointed at, and is written by a click', async () => {
  const it = await pages.open();
  const run = trace(200);
  const other = { ...trace(40), title: 'it holds' };
  const remedies = [{ title: 'Give `move` a budget of 3 ms', previews: true }, { title: 'Set the period of `main` to 20 ms', previews: false }];
  await it.send({ type: 'trace', trace: run, remedies });
  const buttons = it.page.locator('#remedies button');
  const title = () => it.page.locator('#title').textContent();
  assert.deepEqual(await violations(it.page), []);
  const before = await drawn(it);
  await buttons.first().hover();
  assert.deepEqual((await it.said()).at(-1), { type: 'preview', remedy: 0 });
  await it.send({ type: 'preview', remedy: 0, trace: other });
  await it.frame();
  assert.equal(await title(), 'With this change: it holds');
  assert.notDeepEqual(await drawn(it), before);
  // An answer that comes too late shows nothing.
  await it.page.mouse.move(700, 250);
  await it.frame();
  assert.equal(await title(), run.title);
  await it.send({ type: 'preview', remedy: 0, trace: other });
  assert.equal(await title(), run.title);
  assert.deepEqual(await drawn(it), before);
  await buttons.nth(1).hover();
  assert.deepEqual((await it.said()).filter((one) => one.type === 'preview').length, 1);
  await buttons.first().hover();
  await it.send({ type: 'preview', remedy: 0, trace: null });
  assert.equal(await title(), 'With this change: there is no run to show');
  await buttons.first().click();
  assert.deepEqual((await it.said()).filter((one) => one.type === 'remedy'), [{ type: 'remedy', remedy: 0 }]);
  assert.equal(await title(), run.title);
  // A recorded run has none.
  await it.send({ type: 'trace', trace: run });
  assert.ok(await it.page.locator('#remedies').isHidden());
  await it.page.close();
});

test('the state of a step is marked in its machine, and an answer for another step is dropped', async () => {
  const it = await pages.open();
  await it.send({ type: 'trace', trace: trace(40) });
  const { step } = (await it.said()).at(-1);
  await it.send({ type: 'machine', step: step - 1, machine: MACHINE });
  assert.ok(await it.page.locator('#machine').isHidden());
  await it.send({ type: 'machine', step, machine: MACHINE });
  assert.equal(await it.page.locator('#machine .current').getAttribute('data-id'), 'main');
  await it.page.close();
});

test('names are text, whatever they look like', async () => {
  const it = await pages.open();
  const evil = '<img src=x onerror="window.evil=1"><script>window.evil=1</script>';
  const run = trace(40, { names: () => evil });
  run.title = evil;
  for (const step of run.steps) Object.assign(step, { what: `${evil} \`${evil}\``, codel: evil, locks: [evil] });
  for (const span of run.spans) span.label = evil;
  run.rules = { tick: evil, wait: evil, begin: evil, end: evil };
  await it.send({ type: 'trace', trace: run });
  await it.page.mouse.move(700, 120);
  await it.send({ type: 'machine', step: (await it.said()).at(-1).step, machine: { title: evil, node: null, svg: `<svg xmlns="http://www.w3.org/2000/svg"><script>window.evil=1</script><text onclick="1">x</text></svg>` } });
  assert.equal(await it.page.evaluate(() => window.evil), undefined);
  assert.equal(await it.page.locator('img').count(), 0);
  assert.ok((await it.page.locator('#names').textContent()).includes(evil));
  await it.page.close();
});

test('what is drawn is held to what the screen can show, however long the run is', async () => {
  const it = await pages.open();
  const rows = trace(10).lanes.reduce((sum, lane) => sum + lane.rows, 0);
  const work = [];
  for (const steps of [10_000, 100_000]) {
    await it.send({ type: 'trace', trace: trace(steps) });
    await key(it, '0');
    const all = await drawn(it);
    const { width } = await it.page.locator('#canvas').boundingBox();
    assert.ok(all.spans <= (rows * width) / 1.5, `${all.spans} spans in ${rows} rows of ${width} pixels`);
    await key(it, 'f');
    const near = await drawn(it);
    // Thirty steps on the left, and nothing on the right.
    assert.ok(near.spans < 120 && near.marks < 60, JSON.stringify(near));
    work.push({ all: all.spans, near: near.spans });
  }
  const [short, long] = work;
  assert.ok(long.near <= short.near * 1.5 && long.all <= short.all * 3, JSON.stringify(work));
  await it.page.close();
});

test('the lane that fails is in sight beside half a window', async () => {
  const it = await pages.open({ width: 700, height: 320 });
  const run = trace(200, { tasks: 30 });
  run.focus.lane = 28;
  await it.send({ type: 'trace', trace: run });
  for (const again of [false, true]) {
    if (again) await it.page.locator('#focus').click();
    const lane = await it.page.locator('#names [data-lane="28"]').boundingBox();
    const view = await it.page.locator('#trace').boundingBox();
    assert.ok(lane.y >= view.y && lane.y + lane.height <= view.y + view.height + 1, JSON.stringify([lane, view]));
    await it.page.locator('#trace').evaluate((one) => (one.scrollTop = 0));
  }
  await it.page.close();
});

test('the cause stands in the picture at the guilty wait, beside half a window too', async () => {
  for (const theme of Object.keys(THEMES)) {
    for (const width of [700, 1400]) {
      const it = await pages.open({ theme, width, height: 320 });
      const run = trace(200, { tasks: 30 });
      await it.send({ type: 'trace', trace: run });
      const { lane } = run.focus;
      const wait = run.spans.filter((span) => span.lane === lane && span.kind === 'wait-lock').at(-1);
      const { cause, from, to } = await drawn(it);
      assert.equal(cause.text, `waits 1 ms for x of the ids, held by ${wait.by[0].name}`);
      const canvas = await it.page.locator('#canvas').boundingBox();
      const x = (at) => ((at - from) / (to - from)) * canvas.width;
      assert.ok(cause.left >= 0 && cause.right <= canvas.width && cause.left <= x(wait.to) && cause.right >= x(wait.from), JSON.stringify([cause, x(wait.from), canvas]));
      assert.match(await it.page.locator('#told').textContent(), /waits 1 ms for x of the ids/);
      assert.deepEqual(await violations(it.page), []);
      if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/trace-cause-${theme}-${width}.png` });
      await it.page.close();
    }
  }
});

test('lanes that have to do with the failure come first; the others are folded, and unfold by click, key and search', async () => {
  const it = await pages.open({ width: 700, height: 320 });
  const run = trace(200, { tasks: 30 });
  await it.send({ type: 'trace', trace: run });
  const names = () => it.page.locator('#names li').allInnerTexts();
  const { lane } = run.focus;
  const locks = run.lanes.length - 1;
  const first = [lane, lane - 1].map((at) => run.lanes[at].name);
  const before = await names();
  assert.deepEqual(before.slice(0, 2), first);
  assert.ok(before.includes('c locks') && before.length < 12, before.join());
  assert.match(before.at(-1), /^▸ \d+ more lanes$/);
  assert.equal(before.length - 1 + Number(/\d+/.exec(before.at(-1))[0]), locks + 1);
  const few = (await drawn(it)).spans;
  await it.page.locator('#fold').press('Enter');
  await it.frame();
  assert.equal((await names()).length, locks + 2);
  assert.equal(await it.page.locator('#fold').getAttribute('aria-expanded'), 'true');
  assert.ok((await drawn(it)).spans > few || (await it.page.locator('#trace').evaluate((one) => one.scrollHeight > one.clientHeight)));
  await it.page.locator('#fold').click();
  assert.deepEqual(await names(), before);
  // A step of a folded lane is marked at the line of the folded ones; a search shows its lane.
  await it.page.locator('#trace').focus();
  await key(it, 'Home');
  assert.match(await it.page.locator('#names .current').innerText(), /more lanes/);
  await it.page.locator('#search').fill('t9.main begins');
  await it.frame();
  assert.equal(await it.page.locator('#names .current').innerText(), 'c.t9');
  await it.page.close();
});

test('where there is room for all lanes none is folded, and without a late lane none comes first', async () => {
  const it = await pages.open({ height: 900 });
  const run = trace(60);
  await it.send({ type: 'trace', trace: run });
  assert.match(await it.page.locator('#fold').innerText(), /^▾ \d more lanes$/);
  assert.equal(await it.page.locator('#names [data-lane]').count(), run.lanes.length);
  run.focus.lane = null;
  await it.send({ type: 'trace', trace: run });
  assert.deepEqual(await it.page.locator('#names li').allInnerTexts(), run.lanes.map(({ name }) => name));
  assert.equal((await drawn(it)).cause, undefined);
  await it.page.close();
});

test('a part of the run is selected with Shift, and its sums are told', async () => {
  const it = await pages.open();
  const run = trace(60);
  await it.send({ type: 'trace', trace: run });
  const box = await it.page.locator('#canvas').boundingBox();
  const { from, to } = await drawn(it);
  await it.page.keyboard.down('Shift');
  await it.page.mouse.move(box.x + box.width * 0.25, box.y + 60);
  await it.page.mouse.down();
  await it.page.mouse.move(box.x + box.width * 0.75, box.y + 60, { steps: 3 });
  await it.page.mouse.up();
  await it.page.keyboard.up('Shift');
  const same = await drawn(it);
  assert.deepEqual([same.from, same.to], [from, to], 'time does not move');
  const text = await it.page.locator('#range').innerText();
  const half = Number(/([\d.]+) ms selected/.exec(text)[1]);
  assert.ok(Math.abs(half - (to - from) / 2) < (to - from) / 50, text);
  assert.match(text, /core 1\s+[\d.]+ %/);
  assert.match(text, /lock held by t\d\.main\s+1 ms/);
  assert.deepEqual(await violations(it.page), []);
  await it.page.locator('#trace').focus();
  await key(it, 'Escape');
  assert.ok(await it.page.locator('#range').isHidden());
  await key(it, 'm');
  assert.match(await it.page.locator('#range').innerText(), /selected/);
  await it.page.close();
});

test('w, a, s and d zoom and move; the overview leads elsewhere', async () => {
  const it = await pages.open();
  await it.send({ type: 'trace', trace: trace(400) });
  await it.page.locator('#trace').focus();
  await key(it, '0');
  const whole = await drawn(it);
  await key(it, 'w', 3);
  const near = await drawn(it);
  assert.ok(near.to - near.from < (whole.to - whole.from) / 4);
  await key(it, 'a');
  const left = await drawn(it);
  assert.ok(left.from < near.from);
  await key(it, 'd');
  assert.ok((await drawn(it)).from > left.from);
  await key(it, 's');
  const far = await drawn(it);
  assert.ok(far.to - far.from > near.to - near.from);
  const strip = await it.page.locator('#overview').boundingBox();
  await it.page.mouse.click(strip.x + strip.width / 4, strip.y + 10);
  await it.frame();
  const there = await drawn(it);
  assert.ok(Math.abs((there.from + there.to) / 2 - (whole.from + whole.to) / 4) < (there.to - there.from) / 10, JSON.stringify(there));
  await it.page.close();
});

test('the search goes from one step to the next that has the text', async () => {
  const it = await pages.open();
  const run = trace(60);
  await it.send({ type: 'trace', trace: run });
  await it.page.locator('#trace').focus();
  await key(it, 'Home');
  await key(it, '/');
  await it.page.keyboard.type('t3.main waits');
  const all = run.steps.flatMap((step, i) => (step.what.includes('t3.main waits') ? [i] : []));
  assert.equal(await position(it), `step ${all[0] + 1} of ${run.steps.length}`);
  assert.equal(await it.page.locator('#found').textContent(), `1 of ${all.length}`);
  await key(it, 'Enter');
  assert.equal(await position(it), `step ${all[1] + 1} of ${run.steps.length}`);
  await key(it, 'Shift+Enter');
  assert.equal(await position(it), `step ${all[0] + 1} of ${run.steps.length}`);
  await it.page.keyboard.type(' nowhere');
  assert.equal(await it.page.locator('#found').textContent(), 'none');
  await it.page.close();
});

test('the lane of the step stays in sight when the panel becomes small', async () => {
  const it = await pages.open({ width: 1000, height: 600 });
  await it.send({ type: 'trace', trace: trace(60, { tasks: 8 }) });
  await it.page.setViewportSize({ width: 340, height: 290 });
  await it.frame();
  const lane = await it.page.locator('#names .current').boundingBox();
  const view = await it.page.locator('#trace').boundingBox();
  assert.ok(lane.y >= view.y && lane.y + lane.height <= view.y + view.height + 1, JSON.stringify([lane, view]));
  if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/trace-small.png` });
  await it.page.close();
});
