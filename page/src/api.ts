// The server: JSON, and JSON with binary blocks behind it (src/serve/wire.rs).

export type Point = [number, number];
export type Ends = [Point, Point];
export type Mode = "colocation" | "collinear" | "parallel" | "perpendicular";

export interface Correction {
  id: string;
  mode: Mode;
  enabled: boolean;
  weight: number;
  rejection: string | null;
  offset_before_m: number | null;
  angle_before_rad: number | null;
  offset_m: number | null;
  angle_rad: number | null;
  chi2: number | null;
  poses: [number, number];
  observations: [number, number];
  segments: [Ends, Ends] | null;
  seen_from: [number[], number[]] | null;
  conflicts?: string[];
}

export interface Work { id: number; what: string; done: number; of: number }

export interface State {
  map: { number: number; name: string; path: string; poses: number; points: number; closures: number; session: string } | null;
  revision: number;
  corrections: Correction[];
  /** Why it is not known which corrections contradict the rest. */
  unjudged: string | null;
  matching: { is_current: boolean; factors: number; refused: number; disagreeing: number; withdrawn: boolean; footprints: boolean; near_passes: number };
  straightened: boolean;
  undo: string | null;
  redo: string | null;
  settings: { solver: string; formulation: string; drawing_sigma_m: number };
  summary: { corrections: number; idle: number; events: number; minutes: number; worst_offset_m: number | null; moved_m: number };
  remarks: string[];
  works: Work[];
  solvers: string[];
  version: string;
}

const token = new URLSearchParams(location.search).get("token") ?? "";

/** What the server says it cannot do; the message is for the person. */
export class Refusal extends Error {
  constructor(readonly status: number, message: string) { super(message); }
}

async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  const headers = { "x-hitl-token": token, ...(init.headers as Record<string, string> | undefined) };
  let response: Response;
  try {
    response = await fetch(path, { ...init, headers });
  } catch (error) {
    if ((error as Error).name === "AbortError") throw error;
    throw new Refusal(0, "hitl serve does not answer: is it still running?");
  }
  if (response.ok) return response;
  const text = await response.text();
  let message = text;
  try { message = (JSON.parse(text) as { error: string }).error; } catch { /* not ours */ }
  throw new Refusal(response.status, message || `the server answered ${response.status}`);
}

export async function get<T>(path: string): Promise<T> { return (await ask(path)).json() as Promise<T>; }

export async function post<T>(path: string, body: unknown, signal?: AbortSignal): Promise<T> {
  return (await ask(path, { method: "POST", body: JSON.stringify(body), signal })).json() as Promise<T>;
}

export interface Packed<T> { head: T; rest: ArrayBuffer; at: number }

async function unpack<T>(response: Response): Promise<Packed<T>> {
  const rest = await response.arrayBuffer();
  const length = new DataView(rest).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(rest, 4, length))) as T;
  return { head, rest, at: 4 + length };
}

export async function getPacked<T>(path: string): Promise<Packed<T>> { return unpack<T>(await ask(path)); }

export async function postPacked<T>(path: string, body: unknown, signal?: AbortSignal): Promise<Packed<T>> {
  return unpack<T>(await ask(path, { method: "POST", body: JSON.stringify(body), signal }));
}

/** Takes the next block of a packed answer. */
export function block<A>(packed: Packed<unknown>, kind: { new(b: ArrayBuffer, at: number, n: number): A; BYTES_PER_ELEMENT: number }, n: number): A {
  const array = new kind(packed.rest, packed.at, n);
  packed.at += Math.ceil((n * kind.BYTES_PER_ELEMENT) / 8) * 8;
  return array;
}

/** Sends a file; `told` hears the share that has been sent. */
export function upload(file: File, start: "scan-match" | "odometry", told: (share: number) => void, signal: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", "/api/open");
    request.setRequestHeader("x-hitl-token", token);
    request.setRequestHeader("x-hitl-name", encodeURIComponent(file.name));
    request.setRequestHeader("x-hitl-start", start);
    request.upload.onprogress = (e) => told(e.lengthComputable ? e.loaded / e.total : 0);
    request.onerror = () => reject(new Refusal(0, "the file did not arrive: is hitl serve still running?"));
    request.onabort = () => reject(new Refusal(0, "given up: nothing has changed"));
    request.onload = () => {
      if (request.status === 200) return resolve();
      let message = request.responseText;
      try { message = (JSON.parse(message) as { error: string }).error; } catch { /* not ours */ }
      reject(new Refusal(request.status, message));
    };
    signal.addEventListener("abort", () => request.abort());
    request.send(file);
  });
}

/** Fetches a file and hands it to the browser to save. */
export async function download(path: string): Promise<string> {
  const response = await ask(path);
  const name = /filename="([^"]+)"/.exec(response.headers.get("content-disposition") ?? "")?.[1] ?? "picture.png";
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await response.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  return name;
}

export async function picture(path: string): Promise<string> { return URL.createObjectURL(await (await ask(path)).blob()); }

/** Listens for news for ever; says when the server is gone and when it is back. */
export async function listen(news: (state: State) => void, alive: (is: boolean) => void): Promise<never> {
  for (;;) {
    try {
      const reader = (await ask("/api/news")).body!.getReader();
      alive(true);
      const decoder = new TextDecoder();
      let rest = "";
      for (;;) {
        const { value, done } = await reader.read();
        if (done) break;
        const lines = (rest + decoder.decode(value, { stream: true })).split("\n");
        rest = lines.pop() ?? "";
        const last = lines.pop();
        if (last) news(JSON.parse(last) as State);
      }
    } catch { /* asked again below */ }
    alive(false);
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
}
