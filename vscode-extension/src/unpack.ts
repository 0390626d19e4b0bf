// The server program of the package: compressed there, and unpacked once for each version.
//
// Nothing here needs the editor, so that it is tested without one. `scripts/pack.mjs` writes the files that are read here.
import { createHash, randomUUID } from 'node:crypto';
import { constants, createReadStream, createWriteStream, existsSync } from 'node:fs';
import { access, chmod, mkdir, readFile, readdir, rename, rm, stat, utimes } from 'node:fs/promises';
import { join } from 'node:path';
import { pipeline } from 'node:stream/promises';
import { createBrotliDecompress } from 'node:zlib';

/** A folder of a package with the compressed program, and the place for the program. */
export interface Packed {
  /** Folder with `dotgen.br` and `dotgen.json`. A package without the program has neither. */
  from: string;
  /** Folder that gets a folder for each version. */
  into: string;
  /** Version of the extension. */
  version: string;
  log(text: string): void;
}

/** Contents of `dotgen.json`: the file name of the program, and its size and checksum when unpacked. */
interface Description {
  name: string;
  bytes: number;
  sha256: string;
}

// A window that still runs an older version can start its program again this long.
const UNUSED_MS = 24 * 60 * 60 * 1000;
// Brotli's output is passed on in pieces of this size, in bytes.
const CHUNK = 1 << 20;

const REMEDY = 'choose Restart Server, or set dotgen.server.path to an installed dotgen.';

/** The package lacks a file, or a file is damaged. */
class Broken extends Error {
  constructor(reason: string) {
    super(
      `The package of the dotgen extension is damaged (${reason}). Reinstall the extension, or set dotgen.server.path to an installed dotgen.`,
    );
  }
}

/**
 * Returns the path of the unpacked program, undefined if the package has none. Several windows may unpack at once: each writes
 * a file of its own, and renames the finished file. Throws an error whose message says what to do.
 */
export async function unpack(packed: Packed): Promise<string | undefined> {
  const source = join(packed.from, 'dotgen.br');
  const description = await describe(packed.from, source);
  if (description === undefined) {
    return undefined;
  }
  const folder = join(packed.into, `${packed.version}-${description.sha256.slice(0, 12)}`);
  const program = join(folder, description.name);
  if (!(await isComplete(program, description))) {
    packed.log(`unpacking the server into ${folder}`);
    try {
      await write(source, description, folder);
    } catch (error) {
      throw explained(error, source, description.bytes, packed.into);
    }
  }
  await removeUnused(packed.into, folder);
  return program;
}

async function describe(from: string, source: string): Promise<Description | undefined> {
  let text: string;
  try {
    text = await readFile(join(from, 'dotgen.json'), 'utf8');
  } catch (error) {
    if (!existsSync(source)) {
      return undefined;
    }
    throw new Broken(message(error));
  }
  try {
    return JSON.parse(text) as Description;
  } catch (error) {
    throw new Broken(`dotgen.json: ${message(error)}`);
  }
}

async function isComplete(program: string, { bytes }: Description): Promise<boolean> {
  try {
    await access(program, constants.X_OK);
    const found = await stat(program);
    return found.isFile() && found.size === bytes;
  } catch {
    return false;
  }
}

async function write(source: string, description: Description, folder: string): Promise<void> {
  await mkdir(folder, { recursive: true });
  const partial = `${folder}-${randomUUID()}.partial`;
  const hash = createHash('sha256');
  async function* hashed(chunks: AsyncIterable<Buffer>) {
    for await (const chunk of chunks) {
      hash.update(chunk);
      yield chunk;
    }
  }
  try {
    const target = createWriteStream(partial, { flags: 'wx', flush: true });
    await pipeline(createReadStream(source), createBrotliDecompress({ chunkSize: CHUNK }), hashed, target);
    if (hash.digest('hex') !== description.sha256) {
      throw new Broken('dotgen.br: wrong checksum');
    }
    await chmod(partial, 0o755);
    await place(partial, join(folder, description.name), description);
  } finally {
    await rm(partial, { force: true });
  }
}

/** Gives the finished file its name. Windows refuses that while another window runs the file of that name. */
async function place(partial: string, program: string, description: Description): Promise<void> {
  try {
    await rename(partial, program);
  } catch (error) {
    if (!(await isComplete(program, description))) {
      throw error;
    }
  }
}

/** Deletes versions, and files of an interrupted unpacking, that no window has started for a day. */
async function removeUnused(into: string, current: string): Promise<void> {
  const now = new Date();
  // A folder that cannot be changed, or a program that runs under Windows: that does not stop the server.
  const ignored = () => undefined;
  await utimes(current, now, now).catch(ignored);
  for (const name of await readdir(into).catch(() => [])) {
    const path = join(into, name);
    const used = path === current ? undefined : await stat(path).catch(ignored);
    if (used !== undefined && now.getTime() - used.mtimeMs > UNUSED_MS) {
      await rm(path, { recursive: true, force: true }).catch(ignored);
    }
  }
}

/** The error for the user: a full disk, a folder that cannot be written, or a damaged package. */
export function explained(error: unknown, source: string, bytes: number, into: string): Error {
  const { code = '', syscall, path } = error as NodeJS.ErrnoException;
  if (['ENOSPC', 'EDQUOT'].includes(code)) {
    return new Error(`Disk full: the dotgen server needs ${Math.ceil(bytes / 1e6)} MB in ${into}. Free space there and ${REMEDY}`);
  }
  if (error instanceof Broken) {
    return error;
  }
  // Errors of Brotli come from no system call.
  return syscall === undefined || path === source
    ? new Broken(`dotgen.br: ${message(error)}`)
    : new Error(`The dotgen server cannot be unpacked into ${into}: ${message(error)}. Make the folder writable and ${REMEDY}`);
}

function message(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
