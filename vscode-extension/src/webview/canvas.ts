// A picture that can be zoomed and moved: shared by the pages.

/** Letters of 9 of 11 pixels can be read: at a smaller scale, a picture is larger than its view and is scrolled. */
const READABLE = 9 / 11;

export class Canvas {
  private scale = 1;
  private fitted = true;
  private size: { width: number; height: number } | undefined;

  constructor(
    private readonly view: HTMLElement,
    /** What is clicked instead of moved. */
    private readonly links: string,
  ) {
    view.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    view.addEventListener('pointerdown', (event) => this.pan(event));
    window.addEventListener('resize', () => this.fitted && this.fit(READABLE));
    const click = (id: string, action: () => void) => document.getElementById(id)?.addEventListener('click', action);
    click('in', () => this.zoomBy(1.25));
    click('out', () => this.zoomBy(0.8));
    click('fit', () => this.fit());
  }

  /** Shows a picture instead of the last one, at the same zoom. */
  show(svg: string, width: number, height: number): void {
    const parsed = new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement;
    // The page's policy allows no style elements but its own; a constructed sheet is not one.
    const style = parsed.querySelector('style');
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(style?.textContent ?? '');
    document.adoptedStyleSheets = [sheet];
    style?.remove();
    this.view.replaceChildren(document.importNode(parsed, true));
    this.size = { width, height };
    if (this.fitted) this.fit(READABLE);
    else this.zoom(this.scale);
  }

  /** Pixels of the window for one of the picture. */
  get factor(): number {
    return this.scale;
  }

  /** What is shown next is as large as this. */
  keep(): void {
    this.fitted = false;
  }

  /** Brings an element to the middle, large enough to be read. */
  centre(element: Element): void {
    if (this.scale < READABLE) {
      this.fitted = false;
      this.zoom(READABLE);
    }
    element.scrollIntoView({ block: 'center', inline: 'center' });
  }

  clear(): void {
    this.view.replaceChildren();
    this.size = undefined;
  }

  /** All of the picture, at a scale of at least so much. */
  fit(least = 0): void {
    if (this.size === undefined) return;
    this.fitted = true;
    const { clientWidth, clientHeight } = this.view;
    const width = (clientWidth - 4) / this.size.width;
    this.zoom(Math.max(least, Math.min(1.4, width, (clientHeight - 4) / this.size.height)));
  }

  zoomBy(factor: number, at?: MouseEvent): void {
    this.fitted = false;
    this.zoom(this.scale * factor, at);
  }

  /** `+`, `-` and `0`; whether it was one of them. */
  key(event: KeyboardEvent): boolean {
    if (event.key === '+' || event.key === '=') this.zoomBy(1.25);
    else if (event.key === '-') this.zoomBy(0.8);
    else if (event.key === '0') this.fit();
    else return false;
    return true;
  }

  /** Sets the scale; what is at a place of the window (the middle of the view if none is given) stays there. */
  private zoom(to: number, at?: { clientX: number; clientY: number }): void {
    const svg = this.view.querySelector('svg');
    if (svg === null || this.size === undefined) return;
    const box = this.view.getBoundingClientRect();
    const { clientX, clientY } = at ?? { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
    const before = svg.getBoundingClientRect();
    const [x, y] = [(clientX - before.left) / before.width, (clientY - before.top) / before.height];
    this.scale = Math.min(8, Math.max(0.2, to));
    svg.setAttribute('width', String(this.size.width * this.scale));
    svg.setAttribute('height', String(this.size.height * this.scale));
    const after = svg.getBoundingClientRect();
    this.view.scrollBy(after.left + x * after.width - clientX, after.top + y * after.height - clientY);
  }

  private wheel(event: WheelEvent): void {
    if (event.ctrlKey || event.metaKey) {
      event.preventDefault();
      this.zoomBy(event.deltaY < 0 ? 1.1 : 1 / 1.1, event);
    }
  }

  private pan(event: PointerEvent): void {
    if (event.button !== 0 || (event.target instanceof Element && event.target.closest(this.links) !== null)) return;
    this.view.classList.add('pan');
    const move = (it: PointerEvent) => this.view.scrollBy(-it.movementX, -it.movementY);
    const end = () => {
      this.view.classList.remove('pan');
      window.removeEventListener('pointermove', move);
    };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', end, { once: true });
  }
}
