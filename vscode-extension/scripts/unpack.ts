// Unpacks the program of an unpacked .vsix as the extension does, and prints its path.
//
//   npm run -s unpack -- FOLDER INTO    FOLDER has package.json and server; INTO gets the program
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { unpack } from '../src/unpack';

const [folder = '', into = ''] = process.argv.slice(2);
const { version } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8')) as { version: string };
void unpack({ from: join(folder, 'server'), into, version, log: () => undefined }).then((program) => {
  if (program === undefined) {
    throw new Error(`${folder} has no program`);
  }
  console.log(program);
});
