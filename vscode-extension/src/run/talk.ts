// A run, talked to at its socket: docs/socket.md has the protocol.
import { createConnection, type Socket } from 'node:net';
import { createInterface } from 'node:readline';
import type { Input, Port, Progress, Service, ViolationEvent } from './messages';
import { numbers, value } from './values';

/** Values of a series that are kept. */
const KEPT = 60;
/** Numbers of a port that are plotted. */
const SERIES = 6;
const RETRY_MS = 150;

interface Described {
  name: string;
  executed: boolean;
  services: { name: string; kind: string; doc: string | null; inputs: Input[] }[];
  ports: { name: string; direction: string; doc: string | null }[];
}

interface Told {
  id: string;
  event: string;
  components?: Described[];
  value?: unknown;
  output?: unknown;
  exception?: string;
  detail?: unknown;
  message?: string;
  number?: number;
}

export class Talk {
  readonly services: Service[] = [];
  readonly ports: Port[] = [];
  readonly simulated: string[] = [];
  /** How far the run has come. */
  progress: Progress | null = null;
  /** By number: a repeated one comes again. */
  readonly violations: ViolationEvent[] = [];
  private socket: Socket | undefined;
  private retry: NodeJS.Timeout | undefined;
  private ended = false;
  /** The request of each service that is under way. */
  private readonly requests = new Map<string, string>();
  private sent = 0;

  constructor(
    private readonly path: string,
    private readonly changed: () => void,
  ) {
    this.connect();
  }

  /** Sends a request, with inputs by name. */
  call(service: string, input: Record<string, unknown>): void {
    const it = this.services.find(({ name }) => name === service);
    if (it === undefined) return;
    const id = `call ${++this.sent}`;
    this.requests.set(service, id);
    it.active = it.kind === 'activity';
    it.answer = 'sent';
    this.say({ id, call: service, input });
    this.changed();
  }

  abort(service: string): void {
    const id = this.requests.get(service);
    if (id !== undefined) this.say({ id: `abort ${++this.sent}`, abort: id });
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.retry);
    this.socket?.destroy();
    for (const it of this.services) it.active = false;
  }

  /** The run listens some time after it was started: codels are compiled before. */
  private connect(): void {
    const socket = createConnection(this.path);
    this.socket = socket;
    socket.on('connect', () => {
      // Answers to requests of an earlier connection do not come.
      this.requests.clear();
      for (const it of this.services) it.active = false;
      this.say({ id: 'describe', describe: null });
      this.say({ id: 'progress', progress: null });
      this.say({ id: 'violations', violations: null });
    });
    // An error closes the socket too.
    socket.on('error', () => {});
    socket.on('close', () => {
      if (!this.ended) this.retry = setTimeout(() => this.connect(), RETRY_MS);
    });
    const heard = (line: string): void => {
      const told = parsed(line);
      if (told !== undefined) this.hear(told);
    };
    createInterface({ input: socket, crlfDelay: Infinity }).on('line', heard).on('error', () => {});
  }

  private say(request: unknown): void {
    this.socket?.write(`${JSON.stringify(request)}\n`);
  }

  private hear(told: Told): void {
    if (told.id === 'describe') this.described(told.components ?? []);
    else if (told.event === 'data') this.data(told);
    else if (told.event === 'progress') this.progress = told as unknown as Progress;
    else if (told.event === 'violation') this.violations[told.number ?? 0] = told as unknown as ViolationEvent;
    else this.answered(told);
    this.changed();
  }

  /** Adds what a run has. A second connection describes the same things again. */
  private described(components: Described[]): void {
    for (const { name: component, executed, services, ports } of components) {
      if (!executed && !this.simulated.includes(component)) this.simulated.push(component);
      for (const it of services) {
        const name = `${component}.${it.name}`;
        if (!this.services.some((known) => known.name === name)) this.services.push({ ...it, name, answer: '', active: false });
      }
      for (const { name, doc, direction } of ports) {
        if (direction !== 'out') continue;
        const full = `${component}/${name}`;
        if (!this.ports.some((known) => known.name === full)) this.ports.push({ name: full, doc, value: '', series: [] });
        this.say({ id: full, watch: full });
      }
    }
  }

  private data({ id, value }: Told): void {
    const port = this.ports.find((it) => it.name === id);
    if (port === undefined) return;
    port.value = JSON.stringify(value);
    for (const [name, number] of numbers(value).slice(0, SERIES)) {
      let series = port.series.find((it) => it.name === name);
      if (series === undefined) port.series.push((series = { name, values: [] }));
      series.values.push(number);
      if (series.values.length > KEPT) series.values.shift();
    }
  }

  private answered({ id, event, output, exception, detail, message }: Told): void {
    const [service] = [...this.requests].find(([, request]) => request === id) ?? [];
    const it = this.services.find(({ name }) => name === service);
    if (it === undefined) return;
    const details = detail === null || detail === undefined ? '' : ` ${JSON.stringify(detail)}`;
    const empty = output === null || output === undefined || JSON.stringify(output) === '{}';
    it.answer = { done: empty ? 'done' : `done: ${JSON.stringify(output)}`, failed: `failed: ${exception ?? ''}${details}`, error: message ?? 'not understood' }[event] ?? event;
    if (event !== 'accepted') it.active = false;
  }
}

/** A line of the socket. Half of one comes where the run is killed while it writes. */
function parsed(line: string): Told | undefined {
  const it = value(line);
  return typeof it === 'object' && it !== null ? (it as Told) : undefined;
}
