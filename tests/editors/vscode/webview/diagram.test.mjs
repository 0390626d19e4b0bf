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

/** A machine of 40 states, 8 in a row, with `start` in the middle. */
function large() {
  const names = Array.from({ length: 40 }, (_, i) => (i === 20 ? 'start' : `s${i}`));
  const states = names.map((name, i) => {
    const [x, y] = [(i % 8) * 400 + 100, Math.floor(i / 8) * 400 + 100];
    return `<g class="node state" data-id="${name}" data-names="${name}" tabindex="0" role="graphics-symbol" aria-label="state ${name}"><rect class="shape" x="${x}" y="${y}" width="90" height="40"/><text x="${x + 8}" y="${y + 24}">${name}</text></g>`;
  });
  const change = () => `<svg xmlns="http://www.w3.org/2000/svg" width="3200" height="2200" viewBox="0 0 3200 2200" role="graphics-document" aria-label="large"><style>text{font:11px sans-serif}.shape{fill:none;stroke:gray}</style>${states.join('')}</svg>`;
  return picture('fsm', 'goto', { change, subject: { component: 'large', owner: 'main' } });
}

/** The scale of the picture, and how far a node is from the middle of the view. */
async function placed(it, id) {
  const scale = await it.page.locator('#view svg').evaluate((svg) => svg.getBoundingClientRect().width / svg.viewBox.baseVal.width);
  const [view, box] = [await it.page.locator('#view').boundingBox(), await node(it, id).boundingBox()];
  const away = Math.hypot(box.x + box.width / 2 - view.x - view.width / 2, box.y + box.height / 2 - view.y - view.height / 2);
  return { scale, away };
}

test('a large machine opens at its natural size on its first state, and then on the state at the cursor', async () => {
  const it = await pages.open({ width: 700, height: 700 });
  await it.send(large());
  let at = await placed(it, 'start');
  assert.ok(Math.abs(at.scale - 1) < 0.01 && at.away < 20, JSON.stringify(at));
  if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/diagram-large.png` });
  await it.send({ type: 'highlight', id: 's29' });
  at = await placed(it, 's29');
  assert.ok(Math.abs(at.scale - 1) < 0.01 && at.away < 20, JSON.stringify(at));
  // What is typed does not move the picture.
  await it.send(large());
  assert.ok((await placed(it, 's29')).away < 20);
  // What is found comes to the middle.
  await it.page.locator('#search').fill('s13');
  assert.ok((await placed(it, 's13')).away < 20);
  await it.page.locator('#search').fill('');
  await it.page.locator('#fit').click();
  assert.ok((await placed(it, 'start')).scale < 7 / 11);
  assert.equal(await it.page.locator('#view').evaluate((view) => view.scrollWidth <= view.clientWidth && view.scrollHeight <= view.clientHeight), true);
  await it.page.locator('#search').fill('s13');
  at = await placed(it, 's13');
  assert.ok(Math.abs(at.scale - 1) < 0.01 && at.away < 20, JSON.stringify(at));
  await it.page.close();
});

test('a machine that is legible when it is fitted opens whole, and fitting enlarges a small picture', async () => {
  const it = await pages.open({ width: 900, height: 700 });
  const cut = () => it.page.locator('#view').evaluate((view) => view.scrollWidth > view.clientWidth || view.scrollHeight > view.clientHeight);
  await it.send(large());
  await it.send(picture('fsm', 'goto', { subject: { component: 'maneuver', owner: 'goto' } }));
  assert.equal(await cut(), false);
  await it.page.setViewportSize({ width: 2000, height: 2000 });
  await it.frame();
  assert.ok(Math.abs((await placed(it, 'start')).scale - 1.5) < 0.01);
  for (let i = 0; i < 6; i++) await it.page.locator('#out').click();
  await it.page.locator('body').press('0');
  assert.ok(Math.abs((await placed(it, 'start')).scale - 1.5) < 0.01);
  assert.equal(await cut(), false);
  await it.page.close();
});
