// The space of a small picture.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { DiagramNode } from '../../src/protocol';
import { fitted } from '../../src/preview/fit';

const nodes = [{ id: 'start', names: ['start'] }, { id: 'late+later', names: ['late', 'later'] }] as DiagramNode[];
const machine = (width: number, height: number) => ({
  width,
  height,
  nodes,
  picture: `<svg width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"><g data-id="start"><rect class="shape" x="12" y="20" width="90" height="40"/></g><g data-id="late+later"><rect class="shape" x="12.5" y="900" width="90" height="40"/></g></svg>`,
});

test('a small machine keeps its size, a larger one its proportions', () => {
  assert.deepEqual({ ...fitted(machine(200, 100), 'late'), picture: '' }, { picture: '', width: 200, height: 100 });
  assert.deepEqual({ ...fitted(machine(400, 352), undefined), picture: '' }, { picture: '', width: 250, height: 220 });
});

test('of a machine that would be too small, the part around a state is shown', () => {
  const { picture, width, height } = fitted(machine(300, 1000), 'late');
  assert.match(picture, /^<svg width="165" height="220" viewBox="0 600 300 400">/);
  assert.deepEqual([width, height], [165, 220]);
  assert.match(fitted(machine(300, 1000), undefined).picture, /viewBox="0 0 300 400"/);
});
