// The page of the diagrams in Chromium: what is clicked, dragged, typed and searched there, and what screen readers are told.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { opener, THEMES, violations } from './page.mjs';

const pictures = resolve(import.meta.dirname, '../../../../docs/pictures');
let pages;
before(async () => (pages = await opener('src/preview/page.ts', 'src/webview/main.ts')));
after(() => pages.close());

/** One of the manual's pictures as the server would send it; `change` makes another of it. */
function picture(kind, name, { subject = {}, open = {}, holds = {}, change = (svg) => svg, ...more } = {}) {
  const svg = change(readFileSync(resolve(pictures, `${name}.svg`), 'utf8'));
  const [, width, height] = svg.match(/width="([\d.]+)" height="([\d.]+)"/);
  const nodes = [...svg.matchAll(/<g class="node ([^"]*)" data-id="([^"]*)"/g)].map(([, classes, id]) => ({
    id,
    names: kind === 'fsm' ? id.split('+') : [id],
    lines: [id],
    classes: classes.split(' '),
    description: id,
    place: null,
    parts: [],
    open: kind === 'system' && !id.includes('.') ? (open[id] ?? false) : null,
    holds: holds[id] ?? [],
    codel: null,
  }));
  const shown = { subject: { uri: 'file:///a.gen', kind, options: {}, ...subject }, title: name, svg, width: Number(width), height: Number(height), nodes, withoutChains: false, arranged: false, ...more };
  return { type: 'picture', shown };
}

const node = (it, id) => it.page.locator(`g.node[data-id="${id}"]`);
const last = async (it) => (await it.said()).at(-1);

for (const theme of Object.keys(THEMES)) {
  test(`names and roles for screen readers: ${theme}`, async () => {
    const it = await pages.open({ theme, width: 700, height: 700 });
    await it.send(picture('fsm', 'goto', { subject: { way: ['start'] } }));
    assert.deepEqual(await violations(it.page), [], 'a machine');
    const change = (svg) => svg.replaceAll(/role="graphics-symbol"(?=[^>]*aria-label="component)/g, 'role="graphics-object"').replace('<text class="detail"', '<text class="detail part" data-line="1" tabindex="0" role="link"');
    await it.send(picture('system', 'quadcopter', { open: { pom: true }, change, arranged: true }));
    await it.send({ type: 'notice', text: 'The text has an error.' });
    await node(it, 'pom').focus();
    assert.deepEqual(await violations(it.page), [], 'a system');
    await it.send(picture('locks', 'locks'));
    assert.deepEqual(await violations(it.page), [], 'locks');
    await it.page.close();
  });
}

test('a run is shown in its machine: the state it is in, and what was taken how often and how long', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  await it.send(picture('fsm', 'goto'));
  assert.equal(await it.page.locator('#ran').isVisible(), false);
  const transitions = [
    { from: 'start', to: 'plan', taken: 1 },
    { from: 'exec', to: 'pause::exec', taken: 12345, greatest: 3.2 },
    { from: 'exec', to: 'wait', taken: 0 },
  ];
  await it.send({ type: 'live', live: { unit: 'ms', transitions, activities: [{ state: 'exec', executes: true }] } });
  const taken = () => it.page.locator('.taken').allTextContents();
  assert.deepEqual(await taken(), ['1', '12\u202f345 · ≤ 3.2 ms']);
  assert.deepEqual(await it.page.locator('.node.here').evaluateAll((all) => all.map((each) => each.dataset.id)), ['exec']);
  assert.deepEqual(await it.page.locator('.edge.never').evaluateAll((all) => all.map((each) => each.dataset.to)), ['wait']);
  assert.equal(await it.page.locator('#ran').isVisible(), true);
  if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/diagram-live.png` });
  // A picture that is drawn anew shows it as well; another machine does not.
  await it.send(picture('fsm', 'goto'));
  assert.deepEqual(await taken(), ['1', '12\u202f345 · ≤ 3.2 ms']);
  await it.send({ type: 'live' });
  assert.deepEqual(await taken(), []);
  assert.equal(await it.page.locator('.here, .executes, .never').count(), 0);
  await it.page.close();
});

test('a component opens by its sign and by the space bar, and the text is led to by all else', async () => {
  const it = await pages.open({ width: 900, height: 700 });
  await it.send(picture('system', 'quadcopter'));
  await node(it, 'pom').locator('.toggle').click();
  assert.deepEqual(await last(it), { type: 'open', id: 'pom', open: true });
  await it.send(picture('system', 'quadcopter', { open: { pom: true } }));
  assert.match(await node(it, 'pom').getAttribute('aria-label'), /open, Space closes it$/);
  await node(it, 'pom').focus();
  await it.page.keyboard.press(' ');
  assert.deepEqual(await last(it), { type: 'open', id: 'pom', open: false });
  await it.page.keyboard.press('Enter');
  assert.deepEqual(await last(it), { type: 'jump', id: 'pom' });
  await it.page.close();
});

test('what was opened stays where it is in the window', async () => {
  const it = await pages.open({ width: 500, height: 300 });
  await it.send(picture('system', 'quadcopter'));
  await node(it, 'pom').scrollIntoViewIfNeeded();
  await node(it, 'pom').focus();
  const before = await node(it, 'pom').boundingBox();
  await it.page.keyboard.press(' ');
  // All of it has come to stand further down.
  const down = (svg) => svg.replace(/<g class="node/g, '<g transform="translate(0 60)" class="node');
  await it.send(picture('system', 'quadcopter', { open: { pom: true }, change: down }));
  const after = await node(it, 'pom').boundingBox();
  assert.ok(Math.abs(after.y - before.y) < 3, `${before.y} ${after.y}`);
  await it.page.close();
});

test('a line of an open component leads to its own place', async () => {
  const it = await pages.open({ width: 900, height: 700 });
  const change = (svg) => svg.replace('<text class="detail"', '<text class="detail part" data-line="1" tabindex="0" role="link"');
  await it.send(picture('system', 'quadcopter', { change }));
  const part = it.page.locator('.part');
  const id = await part.evaluate((line) => line.closest('g.node').dataset.id);
  await part.click();
  assert.deepEqual(await last(it), { type: 'jump', id, line: 1 });
  await part.focus();
  await it.page.keyboard.press('Enter');
  assert.deepEqual(await last(it), { type: 'jump', id, line: 1 });
  await it.page.close();
});

test('a node is moved by the pointer and by keys, and that is no click', async () => {
  const it = await pages.open({ width: 900, height: 700 });
  await it.send(picture('system', 'quadcopter'));
  const box = await node(it, 'pom').boundingBox();
  const scale = await it.page.locator('#view svg').evaluate((svg) => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width);
  await it.page.mouse.move(box.x + 20, box.y + 20);
  await it.page.mouse.down();
  await it.page.mouse.move(box.x + 60, box.y + 40);
  await it.page.mouse.move(box.x + 120, box.y + 70);
  await it.page.mouse.up();
  const moves = (await it.said()).filter(({ type }) => type === 'move' || type === 'jump');
  assert.equal(moves.length, 1, JSON.stringify(moves));
  const [{ id, by }] = moves;
  assert.equal(id, 'pom');
  assert.ok(Math.abs(by[0] * scale - 100) < 2 && Math.abs(by[1] * scale - 50) < 2, String(by));
  await node(it, 'pom').focus();
  await it.page.keyboard.press('Shift+ArrowRight');
  assert.deepEqual(await last(it), { type: 'move', id: 'pom', by: [20, 0] });
  // A click after it is a click.
  await it.send(picture('system', 'quadcopter', { arranged: true }));
  await node(it, 'pom').click({ position: { x: 20, y: 20 } });
  assert.deepEqual(await last(it), { type: 'jump', id: 'pom' });
  await it.page.locator('#arrange').click();
  assert.deepEqual(await last(it), { type: 'arrange' });
  await it.page.close();
});

test('search pans to what it finds, in closed components too', async () => {
  const it = await pages.open({ width: 420, height: 260 });
  await it.send(picture('system', 'quadcopter', { holds: { nhfc: ['set_gains'] } }));
  await it.page.locator('body').press('/');
  await it.page.keyboard.type('set_gains');
  assert.equal(await it.page.locator('#found').textContent(), '1 found');
  const view = await it.page.locator('#view').boundingBox();
  const found = await node(it, 'nhfc').boundingBox();
  const middle = found.y + found.height / 2;
  assert.ok(middle > view.y && middle < view.y + view.height, `${middle} in ${JSON.stringify(view)}`);
  await it.page.keyboard.press('Enter');
  assert.equal(await it.page.evaluate(() => document.activeElement?.getAttribute('data-id')), 'nhfc');
  await it.page.close();
});

test('arrows go from hit to hit', async () => {
  const it = await pages.open({ width: 420, height: 260 });
  await it.send(picture('system', 'quadcopter'));
  await it.page.locator('#search').fill('pom');
  const hit = () => it.page.locator('g.node.hit').getAttribute('data-id');
  const first = await hit();
  await it.page.keyboard.press('ArrowDown');
  const second = await hit();
  assert.notEqual(second, first);
  await it.page.keyboard.press('ArrowUp');
  assert.equal(await hit(), first);
  await it.page.close();
});

test('states are chosen one after the other, by click and by key, and Escape begins anew', async () => {
  const it = await pages.open({ width: 900, height: 700 });
  await it.send(picture('fsm', 'goto'));
  const told = it.page.locator('#told');
  await it.page.locator('#way').click();
  assert.equal(await it.page.locator('#way').getAttribute('aria-pressed'), 'true');
  assert.match(await told.textContent(), /Choose the states/);
  await node(it, 'start').click();
  assert.deepEqual(await last(it), { type: 'way', states: ['start'] });
  await it.send(picture('fsm', 'goto', { subject: { way: ['start'] } }));
  await node(it, 'exec').focus();
  await it.page.keyboard.press('Enter');
  assert.deepEqual(await last(it), { type: 'way', states: ['start', 'exec'] });
  await it.send(picture('fsm', 'goto', { subject: { way: ['start', 'exec'] }, told: 'start → exec: at most 3 ms of execution' }));
  assert.equal(await told.textContent(), 'start → exec: at most 3 ms of execution');
  await it.page.keyboard.press('Escape');
  assert.deepEqual(await last(it), { type: 'way', states: [] });
  await it.send(picture('fsm', 'goto'));
  assert.equal(await told.isHidden(), true);
  await it.page.close();
});

test('the keyboard alone reaches every tool and every node', async () => {
  const it = await pages.open({ width: 700, height: 700 });
  for (const [kind, name] of [['fsm', 'goto'], ['system', 'quadcopter'], ['locks', 'locks']]) {
    await it.send(picture(kind, name, { arranged: true }));
    await it.page.evaluate(() => { document.activeElement?.blur(); document.body.tabIndex = -1; document.body.focus(); });
    const focused = () => it.page.evaluate(() => document.activeElement?.id || document.activeElement?.getAttribute('data-id'));
    const seen = new Set();
    for (let i = 0; i < 80; i++) {
      await it.page.keyboard.press('Tab');
      seen.add(await focused());
    }
    const tools = await it.page.locator('header :is(button, select, input):visible').evaluateAll((all) => all.map((tool) => tool.id));
    const nodes = await it.page.locator('g.node').evaluateAll((all) => all.map((one) => one.dataset.id));
    assert.ok(tools.length >= 7, tools.join(' '));
    assert.deepEqual([...tools, ...nodes].filter((id) => !seen.has(id)), [], kind);
  }
  await it.page.close();
});

test('a picture of much is as large as can be read, and all of it is seen on demand', async () => {
  const it = await pages.open({ width: 400, height: 300 });
  await it.send(picture('system', 'quadcopter'));
  const scale = () => it.page.locator('#view svg').evaluate((svg) => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width);
  assert.ok((await scale()) >= 0.69, String(await scale()));
  await it.page.locator('#fit').click();
  assert.ok((await scale()) < 0.69, String(await scale()));
  await it.page.close();
});

test('chains that no scenario asks for: how to ask is said, and a scenario is offered', async () => {
  const it = await pages.open({ width: 380, height: 700 });
  const about = it.page.locator('#chainless');
  await it.send(picture('system', 'quadcopter'));
  assert.equal(await about.isVisible(), false);
  await it.send(picture('system', 'quadcopter', { subject: { options: { chains: true } }, withoutChains: true }));
  assert.match(await about.innerText(), /check reaction sensor\.scan -> motor\.speed/);
  assert.deepEqual(await violations(it.page), []);
  await it.page.locator('#scenario').click();
  assert.deepEqual(await last(it), { type: 'scenario' });
  await it.page.close();
});
