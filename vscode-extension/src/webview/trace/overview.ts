// The strip of the whole run above its lanes: how busy it is, where it fails, and which part is shown. A click or a drag in it
// moves the part that is shown.
import type { Trace } from '../../trace/form';
import type { Colours } from './draw';
import type { Window } from './model';
import { busy } from './sums';

export class Overview {
  private readonly context: CanvasRenderingContext2D;
  private trace: Trace | undefined;
  private shares: number[] = [];
  private width = 0;
  private height = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    /** The time in the middle of what is to be shown. */
    private readonly centre: (at: number) => void,
  ) {
    this.context = canvas.getContext('2d') as CanvasRenderingContext2D;
    canvas.addEventListener('pointerdown', (down) => {
      if (down.button !== 0) return;
      canvas.setPointerCapture(down.pointerId);
      const move = (event: PointerEvent) => this.go(event);
      canvas.addEventListener('pointermove', move);
      canvas.addEventListener('pointerup', () => canvas.removeEventListener('pointermove', move), { once: true });
      this.go(down);
    });
  }

  show(trace: Trace | undefined): void {
    this.trace = trace;
    this.shares = [];
  }

  /** Fits the canvas to its element. */
  resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = devicePixelRatio;
    if (clientWidth === this.width && this.canvas.width === Math.round(clientWidth * ratio)) return;
    [this.width, this.height] = [clientWidth, clientHeight];
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.shares = [];
  }

  draw(window: Window, theme: Colours, at: number | undefined, range: readonly [number, number] | undefined): void {
    const { context: c, trace, width, height } = this;
    if (trace === undefined || width === 0) return;
    if (this.shares.length === 0) this.shares = busy(trace, Math.max(1, Math.floor(width)));
    const x = (time: number) => ((time - trace.start) / Math.max(trace.end - trace.start, 1e-6)) * width;
    c.clearRect(0, 0, width, height);
    c.fillStyle = theme.run;
    for (const [i, share] of this.shares.entries()) {
      // What executes at all is seen.
      if (share > 0) c.fillRect(i, height - Math.max(1, share * (height - 4)), 1, height);
    }
    c.fillStyle = theme.miss;
    for (const mark of trace.marks) if (mark.kind === 'miss') c.fillRect(Math.min(x(mark.at), width - 2), 0, 2, height);
    if (range !== undefined) {
      c.globalAlpha = 0.3;
      c.fillStyle = theme.select;
      c.fillRect(x(range[0]), 0, Math.max(x(range[1]) - x(range[0]), 1), height);
      c.globalAlpha = 1;
    }
    if (at !== undefined) {
      c.fillStyle = theme.text;
      c.fillRect(Math.min(x(at), width - 1), 0, 1, height);
    }
    const [from, to] = [Math.max(0, x(window.from)), Math.min(width, x(window.to))];
    // What is not shown is paler.
    c.globalAlpha = 0.6;
    c.fillStyle = theme.ground;
    c.fillRect(0, 0, from, height);
    c.fillRect(to, 0, width - to, height);
    c.globalAlpha = 1;
    c.strokeStyle = theme.select;
    c.strokeRect(from + 0.5, 0.5, Math.max(to - from - 1, 2), height - 1);
  }

  private go(event: PointerEvent): void {
    const { trace, width } = this;
    if (trace === undefined || width === 0) return;
    const share = (event.clientX - this.canvas.getBoundingClientRect().left) / width;
    this.centre(trace.start + Math.min(1, Math.max(0, share)) * (trace.end - trace.start));
  }
}
