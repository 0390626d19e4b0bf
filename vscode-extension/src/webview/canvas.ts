// A picture that can be zoomed and moved: shared by the pages.
import { COMFORTABLE, fitting, LEGIBLE, opening, type Size } from './geometry';

/** The smallest scale that buttons and keys reach; a fitted picture may be smaller. */
const LEAST = 0.2;

/** How a picture has its size: as it opened, by Fit, or by hand. */
type Mode = 'opened' | 'fitted' | 'free';

export class Canvas {
  private scale = 1;
  private mode: Mode = 'opened';
  private size: Size | undefined;
  /** All of the picture was in the view when it was sized last. */
  private whole = true;
  /** A wide picture is laid out for the width of the view, and may be scrolled down. */
  private flows = false;

  constructor(
    private readonly view: HTMLElement,
    /** What is clicked instead of moved. */
    private readonly links: string,
    /** Brings the part that is read first to the middle: the picture is larger than the view. */
    private readonly begin: () => void,
  ) {
    view.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    view.addEventListener('pointerdown', (event) => this.pan(event));
    window.addEventListener('resize', () => this.resize());
    const click = (id: string, action: () => void) => document.getElementById(id)?.addEventListener('click', action);
    click('in', () => this.zoomBy(1.25));
    click('out', () => this.zoomBy(0.8));
    click('fit', () => this.fit());
  }

  /**
   * Shows a picture. Another picture opens: whole if that is legible, or else at its natural size.
   * A new version of the last picture has the last scale.
   */
  show(svg: string, size: Size, { isOther, flows }: { isOther: boolean; flows: boolean }): void {
    const parsed = new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement;
    // The page's policy allows no style elements but its own; a constructed sheet is not one.
    const style = parsed.querySelector('style');
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(style?.textContent ?? '');
    document.adoptedStyleSheets = [sheet];
    style?.remove();
    const isFirst = this.size === undefined || isOther;
    this.size = size;
    this.flows = flows;
    // In the last scale at once: the scrollbars stay where they are.
    this.resizeTo(parsed, this.scale);
    this.view.replaceChildren(document.importNode(parsed, true));
    if (isFirst) {
      if (this.mode === 'fitted') this.mode = 'opened';
      this.whole = true;
    }
    if (this.mode === 'free') {
      if (isFirst) this.begin();
    } else this.resize();
  }

  /** Pixels of the window for one of the picture. */
  get factor(): number {
    return this.scale;
  }

  /** What is shown next is as large as this. */
  keep(): void {
    this.mode = 'free';
  }

  /** Brings an element to the middle, large enough to be read. */
  centre(element: Element): void {
    if (this.scale < LEGIBLE) {
      this.mode = 'opened';
      this.whole = false;
      this.zoom(this.flows ? COMFORTABLE : 1);
    }
    element.scrollIntoView({ block: 'center', inline: 'center' });
  }

  clear(): void {
    this.view.replaceChildren();
    this.size = undefined;
  }

  /** Shows all of the picture: a small one is enlarged, a large one is reduced. */
  fit(): void {
    this.mode = 'fitted';
    this.resize();
  }

  zoomBy(factor: number, at?: MouseEvent): void {
    this.mode = 'free';
    this.zoom(Math.min(8, Math.max(Math.min(LEAST, this.scale), this.scale * factor)), at);
  }

  /** `+`, `-` and `0`; whether it was one of them. */
  key(event: KeyboardEvent): boolean {
    if (event.key === '+' || event.key === '=') this.zoomBy(1.25);
    else if (event.key === '-') this.zoomBy(0.8);
    else if (event.key === '0') this.fit();
    else return false;
    return true;
  }

  /** Sizes the picture for the view, unless it is sized by hand. */
  private resize(): void {
    if (this.size === undefined || this.mode === 'free') return;
    if (this.mode === 'fitted') return this.zoom(fitting(this.size, this.room()));
    if (this.flows) return this.zoom(Math.max(COMFORTABLE, fitting(this.size, this.room(true))));
    const { scale, whole } = opening(this.size, this.room());
    const wasWhole = this.whole;
    this.whole = whole;
    this.zoom(scale);
    // A picture that was larger before stays where it is scrolled to.
    if (!whole && wasWhole) this.begin();
  }

  /** The size of the view without its padding. A fitted picture needs no scrollbars. */
  private room(withScrollbars = false): Size {
    const { view } = this;
    const style = getComputedStyle(view);
    const padding = (side: string) => Number.parseFloat(style.getPropertyValue(`padding-${side}`)) || 0;
    const [width, height] = withScrollbars ? [view.clientWidth, view.clientHeight] : [view.offsetWidth, view.offsetHeight];
    return { width: width - padding('left') - padding('right'), height: height - padding('top') - padding('bottom') };
  }

  private resizeTo(svg: Element, scale: number): void {
    svg.setAttribute('width', String((this.size?.width ?? 0) * scale));
    svg.setAttribute('height', String((this.size?.height ?? 0) * scale));
  }

  /** Sets the scale. The point at a place of the window, or else in the middle of the view, stays there. */
  private zoom(to: number, at?: { clientX: number; clientY: number }): void {
    const svg = this.view.querySelector('svg');
    if (svg === null || this.size === undefined) return;
    const box = this.view.getBoundingClientRect();
    const { clientX, clientY } = at ?? { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
    const before = svg.getBoundingClientRect();
    const [x, y] = [(clientX - before.left) / before.width, (clientY - before.top) / before.height];
    this.scale = to;
    this.resizeTo(svg, to);
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
