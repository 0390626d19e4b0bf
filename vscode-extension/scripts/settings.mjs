// Writes the server's settings into package.json, from the schema that the server's sources generate
// (docs/dotgen.schema.json). The extension's own settings, below server, trace, files, run and diagrams, are left alone.
//
// Tables become settings of their own (`dotgen.verification.timeLimit`), choices become lists, and what may be left out has
// the default that it stands for: VS Code shows those as checkboxes, lists and fields. The extension sends only what is set
// (src/config.ts), so a default never wins over dotgen.toml.
//
//   node scripts/settings.mjs            write them
//   node scripts/settings.mjs --check    fail if package.json has others
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const at = (path) => fileURLToPath(new URL(path, import.meta.url));
const schema = JSON.parse(readFileSync(at('../../docs/dotgen.schema.json'), 'utf8'));
const text = readFileSync(at('../package.json'), 'utf8');
const manifest = JSON.parse(text);

const OURS = /^dotgen\.(server|trace|files|run|diagrams)\./;
// Written by the command Generate… into dotgen.toml; nothing to set by hand.
const HIDDEN = new Set(['generate']);
const FIRST_ORDER = 10;
const camelCase = (name) => name.replace(/-(\w)/g, (_, letter) => letter.toUpperCase());
const unwrap = (description) => description?.replace(/([^\n])\n(?=[^\n])/g, '$1 ');

/** The schema with references replaced by what they name, and lines of prose joined. */
function resolve(value) {
  if (Array.isArray(value)) return value.map(resolve);
  if (value === null || typeof value !== 'object') return value;
  const { $ref, ...rest } = value;
  const whole = $ref === undefined ? rest : { ...schema.$defs[$ref.split('/').at(-1)], ...rest };
  const entries = Object.entries(whole).filter(([key]) => key !== 'format');
  return Object.fromEntries(entries.map(([key, it]) => [key, key === 'description' ? unwrap(it) : resolve(it)]));
}

/** Without the possibility of null, and with choices as a list. */
function plain(value) {
  if (Array.isArray(value)) return value.map(plain);
  if (value === null || typeof value !== 'object') return value;
  const { anyOf, oneOf, ...rest } = Object.fromEntries(Object.entries(value).map(([key, it]) => [key, plain(it)]));
  const some = anyOf?.filter((it) => it.type !== 'null');
  if (some?.length === 1) return { ...some[0], ...rest };
  const choices = [...(some ?? []), ...(oneOf ?? [])].filter((it) => it.const !== undefined);
  if (choices.length > 0 && choices.length === (some ?? oneOf).length) {
    return { ...rest, type: 'string', enum: choices.map((it) => it.const), enumDescriptions: choices.map((it) => it.description ?? '') };
  }
  return { ...rest, ...(some && { anyOf: some }), ...(oneOf && { oneOf }) };
}

/** What a setting has that nobody set. Numbers without default stay empty. */
function withDefault({ type, ...shape }) {
  const types = [type ?? []].flat();
  const kind = types.find((it) => it !== 'null');
  if (shape.default !== undefined && shape.default !== null) return { type: kind, ...shape };
  switch (kind) {
    case 'boolean':
      return { type: kind, ...shape, default: false };
    case 'string':
      return shape.enum === undefined
        ? { type: kind, ...shape, default: '' }
        : { type: kind, ...shape, enum: ['', ...shape.enum], enumDescriptions: ['As dotgen.toml says', ...shape.enumDescriptions], default: '' };
    case 'array':
      return { type: kind, ...shape, default: [] };
    case 'object':
      return { type: kind, ...shape, default: {} };
    default:
      return { type, ...shape, default: null };
  }
}

/** The settings of a table, by name. */
function flattened(properties, prefix) {
  return Object.entries(properties).flatMap(([name, property]) => {
    if (HIDDEN.has(name)) return [];
    const { description, ...shape } = plain(resolve(property));
    const full = `${prefix}.${camelCase(name)}`;
    return shape.properties === undefined ? [[full, { ...withDefault(shape), markdownDescription: description }]] : flattened(shape.properties, full);
  });
}

const settings = flattened(schema.properties, 'dotgen').map(([name, it], i) => [name, { ...it, scope: 'resource', order: FIRST_ORDER + i }]);
const { configuration } = manifest.contributes;
const own = Object.entries(configuration.properties).filter(([name]) => OURS.test(name));
configuration.properties = Object.fromEntries([...own, ...settings]);

const fresh = JSON.stringify(manifest, null, 2) + '\n';
if (process.argv.includes('--check')) {
  if (fresh !== text) {
    console.error('the settings in package.json are out of date: run `npm run settings` and commit it');
    process.exit(1);
  }
} else {
  writeFileSync(at('../package.json'), fresh);
}
