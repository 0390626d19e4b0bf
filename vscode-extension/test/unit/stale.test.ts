// A file that has changed since its preview is not written.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { isStale } from '../../src/generate/stale';

test('a file is stale if its text is another one, or if it has appeared or gone', () => {
  assert.ok(isStale('a\nb\n', 'a\n'));
  assert.ok(isStale('', null));
  assert.ok(isStale(undefined, 'a\n'));
});

test('what the editor changes in a text does not count', () => {
  assert.ok(!isStale(undefined, null));
  assert.ok(!isStale('a\nb\n', '\uFEFFa\r\nb\n'));
});
