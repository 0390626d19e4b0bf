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
