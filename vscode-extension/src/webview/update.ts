// New content in the place of old, without touching what stays the same: selection, focus and scrolling survive.

/** What may have the focus is found again by this, when it is replaced by something else of the same meaning. */
const NAMED = 'data-name';

/** Gives an element new children; those that are equal to old ones stay where they are. */
export function update(parent: Element, children: readonly Element[]): void {
  const { activeElement } = document;
  const focused = activeElement !== null && parent.contains(activeElement) ? activeElement.getAttribute(NAMED) : null;
  let old = parent.firstElementChild;
  for (const child of children) {
    let same = old;
    while (same !== null && !same.isEqualNode(child)) same = same.nextElementSibling;
    if (same === null) {
      parent.insertBefore(child, old);
      continue;
    }
    while (old !== same) old = drop(old);
    old = same.nextElementSibling;
  }
  while (old !== null) old = drop(old);
  if (focused !== null && !parent.contains(activeElement)) {
    parent.querySelector<HTMLElement>(`[${NAMED}="${CSS.escape(focused)}"]`)?.focus();
  }
}

/** Removes an element; the one after it. */
function drop(it: Element | null): Element | null {
  const next = it?.nextElementSibling ?? null;
  it?.remove();
  return next;
}
