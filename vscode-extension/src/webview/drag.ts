// Moving nodes of a picture with the pointer.

/** So far the pointer goes before a click becomes a drag, in pixels. */
const SLACK = 4;

/**
 * Lets a node be dragged: `all` are what goes with it, `factor` is the size of a pixel of the picture. When it is let go,
 * `moved` hears how far, in pixels of the picture.
 */
export function draggable(node: SVGGElement, factor: () => number, all: () => SVGGElement[], moved: (by: [number, number]) => void): void {
  node.addEventListener('pointerdown', (down) => {
    if (down.button !== 0) return;
    let by: [number, number] | undefined;
    const move = (event: PointerEvent) => {
      const [dx, dy] = [event.clientX - down.clientX, event.clientY - down.clientY];
      if (by === undefined && Math.hypot(dx, dy) < SLACK) return;
      by = [dx / factor(), dy / factor()];
      for (const it of all()) {
        it.classList.add('moving');
        it.setAttribute('transform', `translate(${by[0]} ${by[1]})`);
      }
    };
    const up = () => {
      window.removeEventListener('pointermove', move);
      if (by === undefined) return;
      // What follows is no click.
      window.addEventListener('click', (event) => event.stopPropagation(), { capture: true, once: true });
      moved(by);
    };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', up, { once: true });
  });
}
