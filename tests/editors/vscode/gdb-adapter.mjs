// The part of the Debug Adapter Protocol that the scenario `debug` needs, over gdb's machine interface: that of Debian 12
// does not speak the protocol itself.
import { spawn } from 'node:child_process';
import { createInterface } from 'node:readline';

const gdb = spawn('gdb', ['-nx', '-q', '--interpreter=mi2'], { stdio: ['pipe', 'pipe', 'ignore'], env: { ...process.env, DEBUGINFOD_URLS: '' } });
let sent = 0;
let asked = 0;
const awaited = new Map();

function say(message) {
  const body = JSON.stringify({ seq: ++sent, ...message });
  process.stdout.write(`Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`);
}
const event = (name, body = {}) => say({ type: 'event', event: name, body });

/** A command of gdb, and the record that answers it. */
const ask = (command) => new Promise((resolve) => {
  awaited.set(String(++asked), resolve);
  gdb.stdin.write(`${asked}-${command}\n`);
});

createInterface({ input: gdb.stdout }).on('line', (line) => {
  const [, token, record] = line.match(/^(\d+)\^(.*)$/) ?? [];
  if (token !== undefined) awaited.get(token)?.(record);
  if (line.startsWith('*stopped,reason="breakpoint-hit"')) event('stopped', { reason: 'breakpoint', threadId: 1, allThreadsStopped: true });
  if (line.startsWith('*stopped,reason="exited')) event('terminated');
});
gdb.on('close', () => process.exit(0));
// Without an editor there is nothing to debug.
process.stdin.on('close', () => gdb.kill());

const requests = {
  initialize: async () => ({ supportsConfigurationDoneRequest: true }),
  attach: async ({ pid }) => {
    await ask(`target-attach ${pid}`);
    setImmediate(() => event('initialized'));
  },
  setBreakpoints: async ({ source, breakpoints = [] }) => {
    await ask('break-delete');
    for (const { line } of breakpoints) await ask(`break-insert -f ${source.path}:${line}`);
    return { breakpoints: breakpoints.map(({ line }) => ({ verified: true, line })) };
  },
  configurationDone: async () => void (await ask('exec-continue')),
  threads: async () => ({ threads: [{ id: 1, name: 'task' }] }),
  stackTrace: async () => {
    const frames = [...(await ask('stack-list-frames')).matchAll(/level="(\d+)",addr="[^"]*",func="([^"]*)"(?:,file="[^"]*",fullname="([^"]*)",line="(\d+)")?/g)];
    return { stackFrames: frames.map(([, id, name, path, line = 0]) => ({ id: Number(id), name, line: Number(line), column: 1, ...(path && { source: { path } }) })) };
  },
  scopes: async () => ({ scopes: [{ name: 'Locals', variablesReference: 1, expensive: false }] }),
  variables: async () => {
    const all = [...(await ask('stack-list-variables --simple-values')).matchAll(/name="([^"]*)"(?:,arg="1")?,type="[^"]*",value="([^"]*)"/g)];
    return { variables: all.map(([, name, value]) => ({ name, value, variablesReference: 0 })) };
  },
  continue: async () => (await ask('exec-continue'), { allThreadsContinued: true }),
  disconnect: async () => {
    setImmediate(() => gdb.stdin.end('-gdb-exit\n'));
  },
};

let input = Buffer.alloc(0);
process.stdin.on('data', async (bytes) => {
  input = Buffer.concat([input, bytes]);
  for (;;) {
    const head = input.indexOf('\r\n\r\n');
    if (head === -1) return;
    const length = Number(input.subarray(0, head).toString().match(/Content-Length: (\d+)/)[1]);
    if (input.length < head + 4 + length) return;
    const { seq, command, arguments: given } = JSON.parse(input.subarray(head + 4, head + 4 + length));
    input = input.subarray(head + 4 + length);
    void (requests[command] ?? (async () => {}))(given ?? {}).then((body) => say({ type: 'response', request_seq: seq, command, success: true, body }));
  }
});
