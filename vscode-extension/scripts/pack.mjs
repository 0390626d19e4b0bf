// Compresses the server program into server/dotgen.br, and describes it in server/dotgen.json. src/unpack.ts reads both.
//
//   node scripts/pack.mjs PROGRAM QUALITY    QUALITY of Brotli: 0 (fast) to 11 (small)
import { createHash } from 'node:crypto';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { basename } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, constants } from 'node:zlib';

// The largest window that every decoder accepts, 16 MB.
const WINDOW = 24;

const [program, quality] = process.argv.slice(2);
const bytes = readFileSync(program);
const folder = fileURLToPath(new URL('../server/', import.meta.url));
const packed = brotliCompressSync(bytes, {
  params: {
    [constants.BROTLI_PARAM_QUALITY]: Number(quality),
    [constants.BROTLI_PARAM_LGWIN]: WINDOW,
    [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length,
  },
});
const sha256 = createHash('sha256').update(bytes).digest('hex');
mkdirSync(folder, { recursive: true });
writeFileSync(`${folder}dotgen.br`, packed);
writeFileSync(`${folder}dotgen.json`, `${JSON.stringify({ name: basename(program), bytes: bytes.length, sha256 })}\n`);
