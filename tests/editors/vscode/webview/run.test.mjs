// The page of runs in Chromium: what it shows, what is typed into it, what screen readers are told, what the keyboard reaches.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { opener, THEMES, violations } from './page.mjs';

let pages;
before(async () => (pages = await opener('src/run/page.ts', 'src/webview/run.ts')));
after(() => pages.close());

const report = {
  scenario: 'tank', unit: 'ms', seed: 7, time: 10_000, end: 'done',
  tasks: [{ task: 'pump.control', jobs: 999, greatest: 9, mean: 2.111611612, bound: 8, period: 10, missed: 0, load: 0.2094 }, { task: 'pump.listen', jobs: 0, missed: 0, load: 0.004 }],
  services: [{ service: 'pump.fill', requests: 1, refused: 0, ended: 1 }],
  machines: [{ machine: 'pump.fill', transitions: [{ from: 'start', to: 'wait', taken: 1 }, { from: 'wait', to: 'ether', taken: 0 }] }],
  checks: [{ name: 'control', check: 'response', of: 'pump.control', verdict: 'violated', greatest: 9, limit: 8.5, at: { time: 20 }, violations: 1 }],
  violations: [{ at: { time: 20 }, kind: 'check', check: 0 }, { at: { time: 30.5 }, kind: 'overrun', codel: 'pump.control.main', took: 5, limit: 3 }],
  'violation-count': 2, assumptions: ['cores: 1'], notes: ['a note'],
};
const service = { name: 'pump.fill', kind: 'activity', doc: 'Pumps.', inputs: [{ name: 'height', default: 1, schema: { type: ['number', 'null'], default: 1, description: 'Level to reach', unit: 'm' } }, { name: 'how', schema: { type: 'string' } }], answer: '', active: false };
const port = { name: 'pump/level', doc: 'of the tank', value: '{"z":3}', series: [{ name: 'z', values: [1, 2, 3] }] };
const view = (more) => ({ type: 'run', view: { name: 'pump.scn', clock: 'real', debug: false, state: 'running', report: null, progress: null, violations: [], simulated: [], times: 0, hasTrace: false, services: [service], ports: [port], log: ['note: one', 'two'], ...more } });
const ended = view({ state: 'ended', report, hasTrace: true, times: 2, clock: 'virtual' });

for (const theme of Object.keys(THEMES)) {
  test(`names and roles for screen readers: ${theme}`, async () => {
    const it = await pages.open({ theme, width: 700, height: 1000 });
    assert.deepEqual(await violations(it.page), [], 'empty');
    await it.send(view({}));
    assert.deepEqual(await violations(it.page), [], 'running');
    await it.send(ended);
    for (const closed of await it.page.locator('details').all()) await closed.evaluate((details) => (details.open = true));
    assert.deepEqual(await violations(it.page), [], 'ended');
    assert.deepEqual(it.errors, []);
    if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/run-${theme}.png`, fullPage: true });
    await it.page.close();
  });
}

test('what runs is told: violations by name, times beside their bounds, transitions never taken', async () => {
  const it = await pages.open({ width: 700, height: 1000 });
  await it.send(ended);
  assert.equal(await it.page.locator('#state').innerText(), 'violated');
  assert.deepEqual(await it.page.locator('#violations li').allInnerTexts(), [
    '20 ms: response pump.control is violated',
    '30.5 ms: pump.control.main took 5 ms, and its wcet is 3 ms: what is proved assumes that',
  ]);
  assert.deepEqual(await it.page.locator('#tasks tbody tr').first().locator('td').allInnerTexts(), ['pump.control', '21 %', '999', '2.112', '9', '8', '10', '0']);
  assert.equal(await it.page.locator('#tasks .violated').innerText(), '9');
  await it.page.locator('#machines summary').click();
  assert.equal(await it.page.locator('#machines .faint').innerText(), 'never');
  assert.equal(await it.page.locator('#import').innerText(), 'Import 2 Times');
  for (const name of ['import', 'trace', 'again']) await it.page.locator(`#${name}`).click();
  assert.deepEqual((await it.said()).slice(-3), [{ type: 'import' }, { type: 'trace' }, { type: 'again' }]);
  await it.page.close();
});

test('what is typed into a form stays while values come, and is sent', async () => {
  const it = await pages.open({ width: 700, height: 700 });
  await it.send(view({}));
  const field = it.page.getByLabel('height');
  assert.equal(await field.inputValue(), '1');
  assert.equal(await it.page.locator('form .field').first().innerText(), 'height\nm\nLevel to reach');
  await field.fill('2.5');
  await it.send(view({ ports: [{ ...port, value: '{"z":9}', series: [{ name: 'z', values: [1, 2, 3, 9] }] }] }));
  assert.equal(await field.inputValue(), '2.5');
  assert.equal(await it.page.locator('.port svg').getAttribute('aria-label'), 'z from 1 to 9, now 9');
  await field.press('Enter');
  assert.deepEqual((await it.said()).at(-1), { type: 'call', service: 'pump.fill', inputs: { height: 2.5 } });
  await it.send(view({ services: [{ ...service, answer: 'accepted', active: true }] }));
  assert.equal(await it.page.locator('.answer').innerText(), 'accepted');
  await it.page.getByRole('button', { name: 'Interrupt pump.fill' }).click();
  assert.deepEqual((await it.said()).at(-1), { type: 'abort', service: 'pump.fill' });
  await it.page.locator('#stop').click();
  assert.deepEqual((await it.said()).at(-1), { type: 'stop' });
  await it.send(view({ state: 'ended', report }));
  assert.equal(await it.page.getByRole('button', { name: 'Send pump.fill' }).isDisabled(), true);
  await it.page.close();
});

test('what is typed into a form is there when the page is made again, for the same run', async () => {
  const it = await pages.open({ width: 700, height: 700 });
  const list = { name: 'by', schema: { type: 'array', items: { type: 'integer' }, maxItems: 4 } };
  const text = { name: 'what', schema: { type: 'object', properties: { _d: {} } } };
  const shown = { services: [{ ...service, inputs: [...service.inputs, list, text] }] };
  await it.send(view(shown));
  await it.page.getByLabel('height').fill('2.5');
  await it.page.getByRole('button', { name: 'Add an element of by' }).click();
  await it.page.getByLabel('by[0]').fill('7');
  await it.page.getByLabel('what').fill('{"_d": ');
  await it.page.reload();
  await it.send(view(shown));
  assert.equal(await it.page.getByLabel('height').inputValue(), '2.5');
  assert.equal(await it.page.getByLabel('by[0]').inputValue(), '7');
  assert.equal(await it.page.getByLabel('what').inputValue(), '{"_d": ');
  await it.page.reload();
  await it.send(view({ ...shown, name: 'other.scn' }));
  assert.equal(await it.page.getByLabel('height').inputValue(), '1');
  await it.page.close();
});

const OCTET = { type: 'integer', minimum: 0, maximum: 255 };
const MODES = { anyOf: [{ type: 'string', enum: ['SLOW', 'FAST'] }, { type: 'integer' }] };
const POINT = { type: 'object', properties: { y: { type: ['number', 'null'] }, x: { type: ['number', 'null'] } }, required: ['x', 'y'] };
const INPUTS = {
  count: { ...OCTET, default: 3 },
  hard: { type: 'boolean', default: true },
  mode: { ...MODES, default: 'FAST' },
  to: { ...POINT, default: { x: 1.5 } },
  by: { type: 'array', items: POINT, maxItems: 2 },
  gain: { type: 'array', items: { type: ['number', 'null'] }, minItems: 2, maxItems: 2 },
  until: { anyOf: [{ type: ['number', 'null'] }, { type: 'null' }] },
  what: { type: 'object', properties: { _d: MODES, near: OCTET }, required: ['_d'] },
};

test('forms are made from types: what they hold at first, and what is sent', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  const inputs = Object.entries(INPUTS).map(([name, schema]) => ({ name, schema }));
  await it.send(view({ services: [{ ...service, inputs }] }));
  const send = async () => {
    await it.page.getByRole('button', { name: 'Send pump.fill' }).click();
    return (await it.said()).at(-1).inputs;
  };
  assert.deepEqual(await send(), { count: 3, hard: true, mode: 'FAST', to: { x: 1.5 }, by: [], gain: [null, null], until: null });
  const label = (name) => it.page.getByLabel(name, { exact: true });
  await label('count').fill('255');
  await label('hard').uncheck();
  await label('mode').selectOption('SLOW');
  await it.page.getByRole('group', { name: 'to' }).getByLabel('y').fill('-2e3');
  const more = it.page.getByRole('button', { name: 'Add an element of by' });
  await more.click();
  await more.click();
  assert.equal(await more.isDisabled(), true);
  await it.page.getByRole('button', { name: 'Remove an element of by' }).click();
  await it.page.getByRole('group', { name: 'by[0]' }).getByLabel('x').fill('4');
  await label('gain[1]').fill('7');
  await label('until is given').check();
  await label('until').fill('0.5');
  await label('what').fill('{"_d": "FAST", "near": 1}');
  if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/run-form.png`, fullPage: true });
  assert.deepEqual(await violations(it.page), []);
  assert.deepEqual(await send(), { count: 255, hard: false, mode: 'SLOW', to: { x: 1.5, y: -2000 }, by: [{ x: 4 }], gain: [null, 7], until: 0.5, what: { _d: 'FAST', near: 1 } });
  // What does not fit is told beside the field, and not sent.
  await label('count').fill('256');
  const before = (await it.said()).length;
  await it.page.getByRole('button', { name: 'Send pump.fill' }).click();
  assert.equal((await it.said()).length, before);
  await it.page.close();
});

test('a run without sources says from the start that it is simulated, and offers stubs', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  await it.send(view({ simulated: ['pump'] }));
  assert.equal(await it.page.locator('#title').innerText(), 'Simulated run of pump.scn');
  assert.equal(await it.page.locator('#facts').innerText(), 'without sources: pump');
  await it.page.locator('#stubs').click();
  assert.deepEqual((await it.said()).at(-1), { type: 'stubs' });
  await it.send(view({ simulated: ['pump'], state: 'ended', report: { ...report, verdict: 'simulated', 'violation-count': 0 } }));
  assert.equal(await it.page.locator('#state').innerText(), 'simulated');
  await it.page.close();
});

test('a run that goes on shows how far it has come', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  const { tasks, machines, unit } = report;
  await it.send(view({ progress: { unit, time: 1500, tasks, machines, activities: [], 'violation-count': 1 } }));
  assert.equal(await it.page.locator('#state').innerText(), 'violated');
  assert.equal(await it.page.locator('#facts').innerText(), '1500 ms');
  assert.deepEqual(await it.page.locator('#tasks tbody tr').first().locator('td').allInnerTexts(), ['pump.control', '21 %', '999', '2.112', '9', '8', '10', '0']);
  await it.page.close();
});

test('the keyboard alone reaches everything that can be pressed', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  await it.send(view({ services: [{ ...service, active: true }], report, hasTrace: true }));
  const pressed = ':is(button, input, summary, #log):visible';
  const count = await it.page.locator(pressed).evaluateAll((all) => all.map((one, number) => one.setAttribute('data-test', number)).length);
  assert.ok(count >= 8, String(count));
  const seen = new Set();
  for (let i = 0; i < count + 6; i++) {
    await it.page.keyboard.press('Tab');
    seen.add(await it.page.evaluate(() => document.activeElement?.getAttribute('data-test')));
  }
  for (let i = 0; i < count; i++) assert.ok(seen.has(String(i)), `${i} is not reached`);
  await it.page.close();
});

/** A run of five components with their tasks, ports and services. */
function large(more = {}) {
  const names = ['optitrack', 'pom', 'nhfc', 'maneuver', 'rotorcraft'];
  const tasks = names.flatMap((name, i) => ['main', 'plan', 'publish'].map((task, k) => ({ task: `${name}.${task}`, jobs: 1000 * (k + 1), greatest: 2.5 + k, mean: 1.2, bound: 4 + k, period: 5, missed: i === 2 && k === 1 ? 3 : 0, load: 0.04 * (i + 1) + 0.07 * k })));
  const values = (k) => Array.from({ length: 60 }, (_, i) => Math.sin((i + 7 * k) / (5 + k)) * (k + 1));
  const pose = { ts: { sec: 12, nsec: 5 }, pos: { x: 1.25, y: -0.5, z: 2 }, att: { qw: 1, qx: 0, qy: 0, qz: 0 } };
  const ports = names.map((name, i) => ({ name: `${name}/${['bodies', 'frame', 'rotors', 'desired', 'imu'][i]}`, doc: 'what it has', value: JSON.stringify(pose), series: ['ts.sec', 'ts.nsec', 'pos.x', 'pos.y', 'pos.z', 'att.qw'].map((member, k) => ({ name: member, values: values(k) })) }));
  const inputs = ['x', 'y', 'z', 'yaw', 'duration'].map((name) => ({ name, default: 0, schema: { type: ['number', 'null'], description: `The ${name} to reach`, unit: 'm' } }));
  const services = names.flatMap((name) => ['connect', 'goto', 'stop', 'log', 'set_gains', 'reset'].map((one, k) => ({ name: `${name}.${one}`, kind: 'activity', doc: `Does ${one}.`, inputs: k % 3 === 1 ? inputs : [], answer: '', active: name === 'pom' && one === 'goto' })));
  const told = Array.from({ length: 12 }, (_, i) => ({ unit: 'ms', what: 'response nhfc.plan', violation: { at: { time: 200 + 10 * i }, kind: 'check', check: 0 } }));
  const progress = { unit: 'ms', time: 1500, tasks, machines: [], activities: [], 'violation-count': told.length };
  return view({ name: 'flight.scn', services, ports, violations: told, progress, ...more });
}

for (const theme of Object.keys(THEMES)) {
  test(`a large system begins with what moves: ${theme}`, async () => {
    const it = await pages.open({ theme, width: 1000, height: 700 });
    const message = large();
    for (const time of [500, 800, 1000, 1200, 1300, 1500]) {
      const tasks = message.view.progress.tasks.map((task) => ({ ...task, load: task.load * (1 + Math.sin(time) / 3) }));
      await it.send(large({ progress: { ...message.view.progress, time, tasks } }));
    }
    const lines = await it.page.locator('#components tbody tr').evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));
    assert.deepEqual(lines.map((cells) => cells.slice(0, 3)), [
      ['optitrack', '0', '0'], ['pom', '0', '0'], ['nhfc', '12', '3'], ['maneuver', '0', '0'], ['rotorcraft', '0', '0'],
    ]);
    assert.equal(await it.page.locator('#components .plot svg').count(), 5);
    // The newest violation is in sight, and services are folded.
    const box = await it.page.locator('#violated').evaluate((all) => all.scrollTop + all.clientHeight >= all.scrollHeight - 2);
    assert.equal(box, true);
    assert.equal(await it.page.locator('form:visible').count(), 0);
    assert.deepEqual(await it.page.locator('#services summary').allInnerTexts(), ['optitrack6 services', 'pom6 services · 1 active', 'nhfc6 services', 'maneuver6 services', 'rotorcraft6 services']);
    assert.ok(await it.page.evaluate(() => document.documentElement.scrollHeight) < 1400, 'the page is short');
    assert.equal(await it.page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true);
    if (process.env.SHOTS) {
      await it.page.screenshot({ path: `${process.env.SHOTS}/large-${theme}.png` });
      await it.page.screenshot({ path: `${process.env.SHOTS}/large-${theme}-all.png`, fullPage: true });
    }
    assert.deepEqual(await violations(it.page), []);
    await it.page.locator('.port summary').first().click();
    await it.page.locator('#services summary').first().click();
    assert.deepEqual(await violations(it.page), []);
    assert.deepEqual(it.errors, []);
    await it.page.close();
  });
}

test('the filter opens what matches, by keyboard alone', async () => {
  const it = await pages.open({ width: 1000, height: 700 });
  await it.send(large());
  await it.page.keyboard.press('/');
  await it.page.keyboard.type('nhfc goto');
  assert.equal(await it.page.locator('#found').innerText(), '1 found');
  assert.deepEqual(await it.page.locator('form:visible .name').allInnerTexts(), ['nhfc.goto']);
  assert.equal(await it.page.locator('#ports').isVisible(), false);
  if (process.env.SHOTS) await it.page.screenshot({ path: `${process.env.SHOTS}/large-filter.png` });
  await it.page.keyboard.press('Enter');
  assert.equal(await it.page.evaluate(() => document.activeElement?.getAttribute('aria-label')), 'x');
  await it.page.keyboard.type('2');
  await it.page.keyboard.press('Enter');
  assert.deepEqual((await it.said()).at(-1), { type: 'call', service: 'nhfc.goto', inputs: { x: 2 } });
  // What is typed and the filter are there when the page is made again.
  await it.page.reload();
  await it.send(large());
  assert.equal(await it.page.getByLabel('x', { exact: true }).locator('visible=true').inputValue(), '2');
  await it.page.locator('#filter').focus();
  await it.page.keyboard.press('Escape');
  assert.equal(await it.page.locator('form:visible').count(), 0);
  await it.page.locator('#services summary', { hasText: 'pom' }).focus();
  await it.page.keyboard.press('Enter');
  assert.equal(await it.page.locator('form:visible').count(), 6);
  // A component that is opened stays open, also while values come and when the page is made again.
  await it.frame();
  await it.send(large());
  assert.equal(await it.page.locator('form:visible').count(), 6);
  await it.page.reload();
  await it.send(large());
  assert.equal(await it.page.locator('form:visible').count(), 6);
  await it.page.close();
});

test('in a narrow panel, tables that are scrolled sideways take the focus', async () => {
  const it = await pages.open({ width: 380, height: 700 });
  await it.send(large());
  // Times and their limits fit; other columns are left out.
  assert.equal(await it.page.locator('.tables[tabindex]').count(), 0);
  await it.page.setViewportSize({ width: 420, height: 700 });
  await it.frame();
  assert.deepEqual(await violations(it.page), []);
  assert.equal(await it.page.locator('#components .tables[tabindex]').count(), 0);
  await it.page.locator('#tasks .tables').focus();
  await it.page.keyboard.press('ArrowRight');
  await it.page.waitForFunction(() => document.querySelector('#tasks .tables').scrollLeft > 0);
  await it.page.setViewportSize({ width: 1000, height: 700 });
  await it.frame();
  assert.equal(await it.page.locator('.tables[tabindex]').count(), 0);
  await it.page.close();
});

test('a port opens to its whole value, and stays open with the focus while values come', async () => {
  const it = await pages.open({ width: 1000, height: 700 });
  await it.send(view({}));
  const summary = it.page.locator('.port summary');
  await summary.focus();
  await it.page.keyboard.press('Enter');
  await it.send(view({ ports: [{ ...port, value: '{"z":9}', series: [{ name: 'z', values: [1, 2, 9] }] }] }));
  assert.equal(await it.page.locator('.port pre').innerText(), '{\n  "z": 9\n}');
  assert.equal(await summary.evaluate((one) => one === document.activeElement), true);
  await it.page.close();
});
