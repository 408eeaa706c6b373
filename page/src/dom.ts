// Small helpers for the page's elements.

export function $<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`no element #${id}`);
  return element as T;
}

type Props = Record<string, string | boolean | number | ((event: Event) => void) | undefined>;

/** Makes an element: `on…` are listeners, everything else attributes; texts are texts, never HTML. */
export function el(tag: string, props: Props = {}, ...children: (Node | string)[]): HTMLElement {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== undefined) element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

let hiding = 0;

/** Says what went wrong, or (calm) what was done, for a while. */
export function toast(message: string, calm = false): void {
  const box = $("toast");
  box.classList.toggle("calm", calm);
  box.textContent = message;
  box.hidden = false;
  clearTimeout(hiding);
  hiding = setTimeout(() => { box.hidden = true; }, 6000) as unknown as number;
}

export function complain(error: unknown): void { toast((error as Error).message); }

/** A length for a person: mm below 1 cm, cm below 1 m. */
export function length(metres: number): string {
  if (metres < 0.00095) return "< 1 mm";
  if (metres < 0.0095) return `${(metres * 1000).toFixed(0)} mm`;
  if (metres < 0.995) return `${(metres * 100).toFixed(metres < 0.0995 ? 1 : 0)} cm`;
  return `${metres.toFixed(2)} m`;
}

export function angle(radians: number): string {
  const degrees = (radians * 180) / Math.PI;
  if (degrees < 0.05) return "< 0.1°";
  return `${degrees.toFixed(degrees < 9.95 ? 1 : 0)}°`;
}

export function many(count: number, thing: string): string {
  return `${count.toLocaleString("en")} ${thing}${count === 1 ? "" : "s"}`;
}

const MODE_LINES: Record<string, string> = {
  colocation: '<path d="M3 10h14" stroke="var(--a)"/><path d="M3 6.5h14" stroke="var(--b)"/><path d="M3 5v7M17 5v7" stroke-width="1"/>',
  collinear: '<path d="M1 8h7" stroke="var(--a)"/><path d="M12 8h7" stroke="var(--b)"/>',
  parallel: '<path d="M2 12h11" stroke="var(--a)"/><path d="M7 4h11" stroke="var(--b)"/>',
  perpendicular: '<path d="M2 13h16" stroke="var(--a)"/><path d="M10 13V2" stroke="var(--b)"/>',
  straighten: '<path d="M2 13h16M2 13V3" stroke-width="1"/><path d="M4 9.5h12" stroke="var(--b)"/>',
};

export function icon(mode: string): SVGElement {
  const holder = document.createElement("div");
  holder.innerHTML = `<svg viewBox="0 0 20 16" fill="none" stroke="currentColor" stroke-width="2" aria-hidden="true">${MODE_LINES[mode]}</svg>`;
  return holder.firstChild as SVGElement;
}

export function css(name: string): string { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

export function rgb(name: string): [number, number, number] {
  const hex = css(name).slice(1);
  return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)) as [number, number, number];
}
